//! Messages of MessagePack-RPC: requests `[0, id, method, [parameters]]`, responses `[1, id, error, result]` and
//! notifications `[2, method, [parameters]]`. Parameters are one map; keys that a reader does not have are left out.

use relievo_core::{Error, ErrorKind, Result};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use crate::scanner::Scanner;

/// A message whose parts are still MessagePack.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Message<'a> {
    /// A call that waits for a response with the same id.
    Request {
        /// The id of the call.
        id: u32,
        /// The method.
        method: &'a str,
        /// The list of parameters.
        parameters: &'a [u8],
    },
    /// The response to a request.
    Response {
        /// The id of the call.
        id: u32,
        /// What went wrong; nil if nothing did.
        error: &'a [u8],
        /// The result; nil after an error.
        result: &'a [u8],
    },
    /// A call without a response.
    Notification {
        /// The method.
        method: &'a str,
        /// The list of parameters.
        parameters: &'a [u8],
    },
}

/// An error on its way through the protocol.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Failure {
    /// What kind it is; `docs/protocol.md` lists them.
    pub kind: String,
    /// What went wrong.
    pub what: String,
    /// Where; empty if `what` says it all.
    #[serde(default)]
    pub place: String,
    /// What to do; empty if there is nothing to advise.
    #[serde(default)]
    pub remedy: String,
}

/// The names of kinds of errors in the protocol.
const KINDS: [(ErrorKind, &str); 9] = [
    (ErrorKind::Invalid, "invalid"),
    (ErrorKind::Unsupported, "unsupported"),
    (ErrorKind::NotFound, "not_found"),
    (ErrorKind::Io, "io"),
    (ErrorKind::Memory, "limit"),
    (ErrorKind::Busy, "busy"),
    (ErrorKind::Cancelled, "cancelled"),
    (ErrorKind::Device, "device"),
    (ErrorKind::Internal, "internal"),
];

impl From<&Error> for Failure {
    fn from(error: &Error) -> Self {
        let kind = KINDS.iter().find(|(kind, _)| *kind == error.kind).map_or("internal", |(_, name)| name);
        Self { kind: kind.into(), what: error.what.clone(), place: error.place.clone(), remedy: error.remedy.clone() }
    }
}

impl From<Failure> for Error {
    fn from(failure: Failure) -> Self {
        let kind = KINDS.iter().find(|(_, name)| *name == failure.kind).map_or(ErrorKind::Invalid, |(kind, _)| *kind);
        Self { kind, what: failure.what, place: failure.place, remedy: failure.remedy }
    }
}

fn malformed(what: impl std::fmt::Display) -> Error {
    Error::invalid(format!("the message is not one of MessagePack-RPC: {what}"))
        .advise("send [0, id, method, [parameters]], or see docs/protocol.md")
}

/// Splits a whole message into its parts.
///
/// # Errors
/// Fails with `Invalid` if it is none of the three kinds.
pub fn parse(bytes: &[u8]) -> Result<Message<'_>> {
    let mut rest = bytes;
    let length = rmp::decode::read_array_len(&mut rest).map_err(|_| malformed("it is not a list"))?;
    let kind: u32 = rmp::decode::read_int(&mut rest).map_err(|_| malformed("its kind is not a number"))?;
    let id = |rest: &mut &[u8]| rmp::decode::read_int(rest).map_err(|_| malformed("its id is not a number of 32 bits"));
    match (kind, length) {
        (0, 4) => {
            let id = id(&mut rest)?;
            let (method, parameters) = method(rest)?;
            Ok(Message::Request { id, method, parameters })
        }
        (1, 4) => {
            let id = id(&mut rest)?;
            let end = Scanner::new(rest.len()).scan(rest)?.ok_or_else(|| malformed("it is too short"))?;
            Ok(Message::Response { id, error: &rest[..end], result: &rest[end..] })
        }
        (2, 3) => {
            let (method, parameters) = method(rest)?;
            Ok(Message::Notification { method, parameters })
        }
        _ => Err(malformed(format!("a list of {length} items of kind {kind}"))),
    }
}

/// Splits the name of a method from its parameters.
fn method(rest: &[u8]) -> Result<(&str, &[u8])> {
    rmp::decode::read_str_from_slice(rest).map_err(|_| malformed("the method is not a text"))
}

/// Decodes one MessagePack item.
///
/// # Errors
/// Fails with `Invalid` if the bytes are no MessagePack, or not of the type.
pub fn decode<T: DeserializeOwned>(bytes: &[u8]) -> Result<T> {
    rmp_serde::from_slice(bytes).map_err(malformed)
}

/// Decodes the parameters of a call: a list of one map. An empty list is taken as an empty map.
///
/// # Errors
/// Fails with `Invalid` if they are not a list of one map with the keys of the type.
pub fn parameters<T: DeserializeOwned>(bytes: &[u8]) -> Result<T> {
    if bytes == [0x90] {
        return decode(&[0x80]);
    }
    let refused = |error| Error::invalid(format!("the parameters do not fit the method: {error}"));
    rmp_serde::from_slice::<(T,)>(bytes).map(|(parameters,)| parameters).map_err(refused)
}

fn encode(message: &impl Serialize) -> Result<Vec<u8>> {
    rmp_serde::to_vec_named(message).map_err(|error| Error::internal(format!("a message cannot be encoded: {error}")))
}

/// Encodes a request.
///
/// # Errors
/// Fails with `Internal` if the parameters have no MessagePack form.
pub fn request(id: u32, method: &str, parameters: &impl Serialize) -> Result<Vec<u8>> {
    encode(&(0, id, method, (parameters,)))
}

/// Encodes a notification.
///
/// # Errors
/// Fails with `Internal` if the parameters have no MessagePack form.
pub fn notification(method: &str, parameters: &impl Serialize) -> Result<Vec<u8>> {
    encode(&(2, method, (parameters,)))
}

/// Encodes the response to a request that succeeded.
///
/// # Errors
/// Fails with `Internal` if the result has no MessagePack form.
pub fn response(id: u32, result: &impl Serialize) -> Result<Vec<u8>> {
    encode(&(1, id, (), result))
}

/// Encodes the response to a request that failed.
///
/// # Errors
/// Fails with `Internal` if the failure has no MessagePack form; no case is known.
pub fn failure(id: u32, failure: &Failure) -> Result<Vec<u8>> {
    encode(&(1, id, failure, ()))
}
