//! A connection: reads messages within bounds of size, depth and time, and answers them in order.

use std::fmt;
use std::sync::Arc;
use std::time::Duration;

use relievo_client::{
    Failure, Hello, MAX_GREETING, MAX_MESSAGE, Message, Scanner, VERSION, Welcome, failure, parse, response,
};
use relievo_core::{Error, ErrorKind, Result};
use tokio::io::{AsyncRead, AsyncReadExt, AsyncWrite, AsyncWriteExt};
use tokio::time::{Instant, sleep_until, timeout};

use crate::server::Shared;
use crate::service::{Call, is_quick};

/// Bytes that are read at a time.
const READ: usize = 1 << 16;
/// Bytes of room that a connection keeps from message to message.
const KEPT: usize = 1 << 18;

/// Why a connection ends.
enum End {
    /// The client closed it between two messages.
    Closed,
    /// The client closed it within a message.
    Cut,
    /// Nothing came for too long.
    Idle,
    /// A message, or the taking of a response, took too long.
    Slow,
    /// What came is no message, or too large.
    Refused(Error),
    /// The system failed.
    Failed(std::io::Error),
}

impl fmt::Display for End {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Closed => out.write_str("the client closed it"),
            Self::Cut => out.write_str("the client closed it within a message"),
            Self::Idle => out.write_str("nothing came for too long"),
            Self::Slow => out.write_str("a message took too long"),
            Self::Refused(error) => write!(out, "{error}"),
            Self::Failed(error) => write!(out, "{error}"),
        }
    }
}

/// A connection's bytes that have arrived.
struct Reader {
    buffer: Vec<u8>,
    /// Bytes of the message that was taken last.
    taken: usize,
}

impl Reader {
    /// Reads the next message of at most `limit` bytes. Its first byte must come within `idle`, and all of it within
    /// `patience` of that.
    async fn next(
        &mut self,
        stream: &mut (impl AsyncRead + Unpin),
        limit: usize,
        [idle, patience]: [Duration; 2],
    ) -> std::result::Result<&[u8], End> {
        self.buffer.drain(..self.taken);
        self.taken = 0;
        if self.buffer.capacity() > KEPT && self.buffer.len() < KEPT {
            self.buffer.shrink_to(KEPT);
        }
        let mut scanner = Scanner::new(limit);
        let mut end = None;
        loop {
            if let Some(length) = scanner.scan(&self.buffer).map_err(End::Refused)? {
                self.taken = length;
                return Ok(&self.buffer[..length]);
            }
            let is_begun = !self.buffer.is_empty();
            if is_begun && end.is_none() {
                end = Some(Instant::now() + patience);
            }
            let until = end.unwrap_or_else(|| Instant::now() + idle);
            self.buffer.reserve(READ);
            let read = tokio::time::timeout_at(until, stream.read_buf(&mut self.buffer)).await;
            match read {
                Err(_) => return Err(if is_begun { End::Slow } else { End::Idle }),
                Ok(Err(error)) => return Err(End::Failed(error)),
                Ok(Ok(0)) => return Err(if is_begun { End::Cut } else { End::Closed }),
                Ok(Ok(_)) => {}
            }
        }
    }
}

async fn send(stream: &mut (impl AsyncWrite + Unpin), message: &[u8], shared: &Shared) -> std::result::Result<(), End> {
    let written = timeout(shared.limits().message, async {
        stream.write_all(message).await?;
        stream.flush().await
    });
    match written.await {
        Err(_) => Err(End::Slow),
        Ok(Err(error)) => Err(End::Failed(error)),
        Ok(Ok(())) => {
            shared.metrics().bytes[1].add(message.len() as u64);
            Ok(())
        }
    }
}

/// Serves a connection, which has a number among those without a user, until it ends.
pub async fn serve<S: AsyncRead + AsyncWrite + Unpin>(
    mut stream: S,
    (peer, number): (String, u64),
    shared: Arc<Shared>,
) {
    let mut reader = Reader { buffer: Vec::new(), taken: 0 };
    let Some(user) = greet(&mut stream, &mut reader, &peer, &shared).await else {
        shared.metrics().dropped.add(1);
        return;
    };
    shared.introduced(number);
    let end = answer(&mut stream, &mut reader, user.name(), &shared).await;
    match &end {
        End::Closed | End::Idle => tracing::debug!(peer, user = user.name(), %end, "closed"),
        _ => {
            shared.metrics().dropped.add(1);
            tracing::warn!(peer, user = user.name(), %end, "dropped a connection");
        }
    }
}

/// A user's connection, counted until it is dropped.
pub struct Introduced {
    name: String,
    shared: Arc<Shared>,
}

impl Introduced {
    fn name(&self) -> &str {
        &self.name
    }
}

impl Drop for Introduced {
    fn drop(&mut self) {
        self.shared.leave(&self.name);
    }
}

/// Reads `hello` and answers it. Returns the user, if the token is right.
async fn greet(
    stream: &mut (impl AsyncRead + AsyncWrite + Unpin),
    reader: &mut Reader,
    peer: &str,
    shared: &Arc<Shared>,
) -> Option<Introduced> {
    let patience = shared.limits().greeting;
    let greeted = timeout(patience, async {
        let message = reader.next(stream, MAX_GREETING, [patience; 2]).await;
        let message = message.inspect_err(|end| tracing::warn!(peer, %end, "no hello")).ok()?;
        let (id, outcome) = hello(message, shared);
        match outcome {
            Ok((name, welcome)) => {
                tracing::info!(peer, user = name, "connected");
                let user = Introduced { name, shared: shared.clone() };
                send(stream, &response(id, &welcome).ok()?, shared).await.ok()?;
                Some(user)
            }
            Err(error) => {
                shared.metrics().refused.add(1);
                tracing::warn!(peer, %error, "refused a connection");
                send(stream, &failure(id, &Failure::from(&error)).ok()?, shared).await.ok()?;
                None
            }
        }
    });
    greeted.await.unwrap_or_else(|_| {
        tracing::warn!(peer, "no hello in time");
        None
    })
}

fn hello(message: &[u8], shared: &Arc<Shared>) -> (u32, Result<(String, Welcome)>) {
    let first = || Error::invalid("the first call on a connection is `hello`").advise("see docs/protocol.md");
    let (id, parameters) = match parse(message) {
        Ok(Message::Request { id, method: "hello", parameters }) => (id, parameters),
        Ok(Message::Request { id, .. }) => return (id, Err(first())),
        _ => return (0, Err(first())),
    };
    let outcome = relievo_client::parameters::<Hello>(parameters).and_then(|hello| {
        if hello.version[0] != VERSION[0] {
            let [theirs, ours] = [hello.version, VERSION].map(|[major, minor]| format!("{major}.{minor}"));
            return Err(Error::unsupported(format!("the client speaks protocol {theirs}, and this server {ours}"))
                .advise("take a client and a server of the same release"));
        }
        let name = shared.users().user(&hello.token)?;
        shared.enter(&name)?;
        Ok((name.clone(), shared.welcome(name)))
    });
    (id, outcome)
}

/// Answers calls until the connection ends.
async fn answer(
    stream: &mut (impl AsyncRead + AsyncWrite + Unpin),
    reader: &mut Reader,
    user: &str,
    shared: &Arc<Shared>,
) -> End {
    let times = [shared.limits().idle, shared.limits().message];
    loop {
        let message = match reader.next(stream, MAX_MESSAGE, times).await {
            Ok(message) => message,
            Err(End::Refused(error)) => {
                // What follows in the stream cannot be told from the rest of the message.
                if let Ok(message) = failure(0, &Failure::from(&error)) {
                    let _ = send(stream, &message, shared).await;
                }
                return End::Refused(error);
            }
            Err(end) => return end,
        };
        shared.metrics().bytes[0].add(message.len() as u64);
        shared.metrics().requests.add(1);
        if let Some(pause) = shared.pause(user) {
            sleep_until(Instant::now() + pause).await;
        }
        let (id, method, parameters) = match parse(message) {
            Ok(Message::Request { id, method, parameters }) => (Some(id), method, parameters),
            Ok(Message::Notification { method, parameters }) => (None, method, parameters),
            Ok(Message::Response { .. }) => continue,
            Err(error) => return End::Refused(error),
        };
        let outcome = call(shared, user, id.unwrap_or(0), (method, parameters)).await;
        let outcome = outcome.or_else(|error| {
            shared.metrics().failures.add(1);
            tracing::debug!(user, method, %error, "a call failed");
            failure(id.unwrap_or(0), &Failure::from(&error))
        });
        // A notification has no response, also where it fails.
        let Some(_) = id else { continue };
        match outcome {
            Ok(message) => {
                if let Err(end) = send(stream, &message, shared).await {
                    return end;
                }
            }
            Err(error) => return End::Refused(error),
        }
    }
}

async fn call(shared: &Arc<Shared>, user: &str, id: u32, (method, parameters): (&str, &[u8])) -> Result<Vec<u8>> {
    if method == "scene.wait" {
        return response(id, &shared.service().wait(user, parameters).await?);
    }
    if is_quick(method) {
        return shared.service().call(&Call { user, id, method, parameters });
    }
    let (shared, user, method) = (shared.clone(), user.to_owned(), method.to_owned());
    let parameters = parameters.to_vec();
    let task = tokio::task::spawn_blocking(move || {
        let call = Call { user: &user, id, method: &method, parameters: &parameters };
        shared.service().call(&call)
    });
    // A method that panics fails alone.
    task.await.unwrap_or_else(|_| Err(Error::new(ErrorKind::Internal, "the method panicked")))
}
