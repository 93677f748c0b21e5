//! A server that simulates for hosts elsewhere (Morgenroth, Weiskopf, Eberhardt 2013, Sections 3 and 4).
//!
//! A host submits a scene, the server simulates it in the background, stores each frame in a cache on disk, and sends the
//! frames that are there while later ones are computed. The protocol, the cache and the scheduler handle any [`Simulation`]
//! that makes frames: [`FluidKind`] and [`FoamKind`]. `docs/server.md` is the manual and `docs/protocol.md` describes the
//! protocol.
//!
//! - [`Server`] listens and answers;
//! - [`Store`] is the cache: content-addressed, checksummed, bounded in size, and whole after any crash;
//! - [`Limits`] bound what a user may use;
//! - [`RpcRanks`] carries messages between the domains of one fluid in several processes.

mod connection;
mod decoded;
#[cfg(feature = "tls")]
mod encryption;
#[cfg(not(feature = "tls"))]
#[path = "encryption_absent.rs"]
mod encryption;
mod fluid;
mod foam;
mod kind;
mod library;
mod metrics;
mod object;
mod options;
mod ranks;
mod record;
mod scene;
mod scheduler;
mod server;
mod service;
mod store;
mod surface;
mod users;

pub use fluid::FluidKind;
pub use foam::FoamKind;
pub use kind::{Kind, Opening, Simulation};
pub use options::{Limits, ServerOptions};
pub use ranks::{RankOptions, RpcRanks};
pub use server::Server;
pub use store::{Listed, Store};
