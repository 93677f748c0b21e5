//! The protocol of the simulation server, and a blocking client of it (Morgenroth, Weiskopf, Eberhardt 2013, Section 3).
//!
//! Messages are those of MessagePack-RPC over TCP, TLS or Unix sockets; `docs/protocol.md` describes every method. A
//! [`Client`] submits a description, waits for frames and fetches them, and connects again by itself where the connection
//! breaks. The server uses the same types and the same codec, from this crate.

mod address;
mod chunk;
mod client;
#[cfg(feature = "tls")]
mod encryption;
#[cfg(not(feature = "tls"))]
#[path = "encryption_absent.rs"]
mod encryption;
mod hash;
mod message;
mod protocol;
mod scanner;

pub use address::{Address, PORT};
pub use chunk::{Chunk, Column, Form, Layout, Packing, Values};
pub use client::{Client, ClientOptions, Frame};
pub use hash::{Hash, Hasher};
pub use message::{Failure, Message, decode, failure, notification, parameters, parse, request, response};
pub use protocol::*;
pub use scanner::Scanner;
