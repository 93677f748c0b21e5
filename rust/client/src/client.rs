//! A blocking client of the simulation server.
//!
//! Every method may be repeated without harm, so a call whose connection breaks is made again on a new connection, until
//! the client runs out of patience.

use std::collections::BTreeMap;
use std::io::{Read, Write};
use std::net::{TcpStream, ToSocketAddrs};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use relievo_core::progress::Silent;
use relievo_core::{Error, ErrorKind, Progress, Result};
use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::address::Address;
use crate::chunk::{Chunk, Values};
use crate::encryption::encrypt;
use crate::hash::Hash;
use crate::message::{Failure, Message, decode, parse, request};
use crate::protocol::*;
use crate::scanner::Scanner;

/// How a client connects.
#[derive(Clone, Debug)]
pub struct ClientOptions {
    /// Where the server listens.
    pub address: Address,
    /// The user's token; empty where the server needs none.
    pub token: String,
    /// A file with the certificates, in PEM, of the authorities that the server's certificate is checked against. Without
    /// one, connections by TLS are refused.
    pub authorities: Option<PathBuf>,
    /// How long a call may wait for bytes from the server.
    pub timeout: Duration,
    /// How long a call tries to connect again after the connection broke.
    pub patience: Duration,
}

impl Default for ClientOptions {
    fn default() -> Self {
        Self {
            address: Address::default(),
            token: String::new(),
            authorities: None,
            timeout: Duration::from_secs(60),
            patience: Duration::from_secs(30),
        }
    }
}

/// A connection's bytes.
trait Stream: Read + Write + Send {}

impl<T: Read + Write + Send> Stream for T {}

struct Link {
    stream: Box<dyn Stream>,
    /// Bytes that have arrived; the message that is read begins at their beginning.
    buffer: Vec<u8>,
}

/// A client of a server.
pub struct Client {
    options: ClientOptions,
    link: Option<Link>,
    welcome: Welcome,
    next: u32,
}

/// A frame that was fetched.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Frame {
    /// Particles.
    pub count: u64,
    /// The numbers of each channel, particle after particle, with their count per particle, by the channel's name.
    pub channels: BTreeMap<String, (u32, Values)>,
    /// Bytes of the channels as they were sent.
    pub bytes: u64,
}

/// Bytes that are read at a time.
const READ: usize = 1 << 18;
/// The pause before the second try to connect; each further one is twice as long, up to [`LONGEST_PAUSE`].
const PAUSE: Duration = Duration::from_millis(20);
const LONGEST_PAUSE: Duration = Duration::from_secs(1);
/// The time within a pause after which progress is reported, so that the caller can stop the call.
const LISTENING: Duration = Duration::from_millis(100);

/// What a call fails with: whether another connection may help.
enum Fault {
    Broken(Error),
    Refused(Error),
}

impl Client {
    /// Connects and introduces the user.
    ///
    /// # Errors
    /// Fails with `Io` if there is no server within the patience of the options, with `Unsupported` if it speaks
    /// another version of the protocol, and with its own error if it does not take the token.
    pub fn connect(options: ClientOptions) -> Result<Self> {
        let mut client = Self { options, link: None, welcome: Welcome::default(), next: 0 };
        client.retry(&mut Silent, 0.0, |_| Ok(()))?;
        Ok(client)
    }

    /// Returns what the server said of itself when the client connected last.
    pub fn welcome(&self) -> &Welcome {
        &self.welcome
    }

    /// Calls a method. Connects again, and repeats the call, where the connection breaks.
    ///
    /// # Errors
    /// Fails as the method does, and with `Io` when patience ends.
    pub fn call<R: DeserializeOwned>(&mut self, method: &str, parameters: &impl Serialize) -> Result<R> {
        self.call_at(method, parameters, &mut Silent, 0.0)
    }

    /// Calls a method as [`Self::call`] does, where the whole task has come to `fraction`. Stops if `progress` asks for it
    /// while the client connects again.
    fn call_at<R: DeserializeOwned>(
        &mut self,
        method: &str,
        parameters: &impl Serialize,
        progress: &mut dyn Progress,
        fraction: f32,
    ) -> Result<R> {
        self.next = self.next.wrapping_add(1);
        let id = self.next;
        let message = request(id, method, parameters)?;
        self.retry(progress, fraction, |link| link.exchange(&message, id))
    }

    /// Does something on a connection, on new ones where it breaks.
    fn retry<R>(
        &mut self,
        progress: &mut dyn Progress,
        fraction: f32,
        mut task: impl FnMut(&mut Link) -> std::result::Result<R, Fault>,
    ) -> Result<R> {
        let begin = Instant::now();
        let mut pause = PAUSE;
        loop {
            let outcome = match &mut self.link {
                Some(link) => task(link),
                None => match self.greet() {
                    Ok(link) => task(self.link.insert(link)),
                    Err(fault) => Err(fault),
                },
            };
            match outcome {
                Ok(result) => return Ok(result),
                Err(Fault::Refused(error)) => return Err(error),
                Err(Fault::Broken(error)) => {
                    self.link = None;
                    if begin.elapsed() + pause > self.options.patience {
                        return Err(error.advise("check that the server runs and the address is right"));
                    }
                    let end = Instant::now() + pause;
                    while let Some(left) = end.checked_duration_since(Instant::now()).filter(|left| !left.is_zero()) {
                        progress.step(fraction, "connect again")?;
                        std::thread::sleep(left.min(LISTENING));
                    }
                    pause = (2 * pause).min(LONGEST_PAUSE);
                }
            }
        }
    }

    /// Connects and says hello.
    fn greet(&mut self) -> std::result::Result<Link, Fault> {
        let mut link = Link { stream: open(&self.options)?, buffer: Vec::new() };
        let token = self.options.token.clone();
        let client = concat!("relievo ", env!("CARGO_PKG_VERSION")).to_owned();
        let hello = request(0, "hello", &Hello { version: VERSION, client, token }).map_err(Fault::Refused)?;
        let welcome: Welcome = link.exchange(&hello, 0)?;
        if welcome.version[0] != VERSION[0] {
            let [theirs, ours] = [welcome.version, VERSION].map(|[major, minor]| format!("{major}.{minor}"));
            return Err(Fault::Refused(
                Error::unsupported(format!("the server speaks protocol {theirs}, and this client {ours}"))
                    .advise("take a client and a server of the same release"),
            ));
        }
        self.welcome = welcome;
        Ok(link)
    }

    /// Sends the files of a scene that the server lacks. `files` are paths by the names that the description gives them.
    /// Returns their hashes.
    ///
    /// # Errors
    /// Fails with `NotFound` or `Io` if a file does not exist or cannot be read, with `Cancelled` if `progress` asks to
    /// stop, and as [`Self::call`] does.
    pub fn send_files(&mut self, files: &BTreeMap<String, PathBuf>, progress: &mut dyn Progress) -> Result<FileMap> {
        let mut hashes = FileMap::new();
        for (name, path) in files {
            hashes.insert(name.clone(), Hash::of(&load(path)?));
        }
        if hashes.is_empty() {
            return Ok(hashes);
        }
        let missing: FileList = self.call("file.missing", &FileList { files: hashes.clone() })?;
        for (number, (name, hash)) in missing.files.iter().enumerate() {
            let begin = number as f32 / missing.files.len() as f32;
            // A server may ask for no file but those of the scene.
            let Some(path) = files.get(name).filter(|_| hashes.get(name) == Some(hash)) else { continue };
            let bytes = load(path)?;
            let mut offset = 0;
            loop {
                let part = offset as f32 / bytes.len().max(1) as f32;
                let fraction = begin + part / missing.files.len() as f32;
                progress.step(fraction, name)?;
                let data = bytes[offset..(offset + MAX_PART).min(bytes.len())].to_vec();
                let put =
                    FilePut { name: name.clone(), hash: *hash, size: bytes.len() as u64, offset: offset as u64, data };
                let FilePutResult { received } = self.call_at("file.put", &put, progress, fraction)?;
                offset = received.min(bytes.len() as u64) as usize;
                if offset == bytes.len() {
                    break;
                }
            }
        }
        Ok(hashes)
    }

    /// Submits a scene whose files the server has.
    ///
    /// # Errors
    /// Fails as [`Self::call`] does: also if the server refuses the scene.
    pub fn submit(&mut self, scene: &Submit) -> Result<Status> {
        self.call("scene.submit", scene)
    }

    /// Returns what a scene is doing.
    ///
    /// # Errors
    /// Fails as [`Self::call`] does: also if the server has no such scene.
    pub fn status(&mut self, scene: &str) -> Result<Status> {
        self.call("scene.status", &SceneName { scene: scene.into() })
    }

    /// Waits until a frame is stored, and returns what the scene is doing then.
    ///
    /// # Errors
    /// Fails with `Cancelled` if the scene is finished, paused or cancelled before it, or `progress` asks to stop, with
    /// the error of the simulation if that failed, and as [`Self::call`] does.
    pub fn wait(&mut self, scene: &str, frame: u64, progress: &mut dyn Progress) -> Result<Status> {
        let mut share = 0.0;
        loop {
            // Short enough for a host that wants to stop.
            let wait = Wait { scene: scene.into(), frame, seconds: 0.2 };
            let status: Status = self.call_at("scene.wait", &wait, progress, share)?;
            share = ((status.ready as f32 + status.fraction) / (frame + 1) as f32).min(1.0);
            progress.step(share, "simulate")?;
            if status.ready > frame {
                return Ok(status);
            }
            let stopped = |what: &str| {
                let what = format!("the scene is {what} at frame {} of {}", status.ready, status.frames);
                Err(Error::new(ErrorKind::Cancelled, what).at(scene))
            };
            match status.state {
                Activity::Running | Activity::Forces => {}
                Activity::Done => return stopped("finished"),
                Activity::Paused => return stopped("paused"),
                Activity::Cancelled => return stopped("cancelled"),
                Activity::Failed => {
                    let error = status.error.map_or_else(|| Error::internal("the simulation failed"), Error::from);
                    return Err(error.at(scene));
                }
            }
        }
    }

    /// Changes keys of a scene's description from a frame on.
    ///
    /// # Errors
    /// Fails as [`Self::call`] does: also if the server has no such scene, or the keys cannot be changed so.
    pub fn steer(&mut self, scene: &str, frame: u64, changes: &str) -> Result<Status> {
        self.call("scene.steer", &Steer { scene: scene.into(), frame, changes: changes.into() })
    }

    /// Sends the accelerations in m/s² of all particles of a frame, on their way to the next one.
    ///
    /// # Errors
    /// Fails as [`Self::call`] does: also if the scene is not at that frame, was submitted without `forced`, or has
    /// another number of particles. Fails with `Cancelled` if `progress` asks to stop.
    pub fn force(
        &mut self,
        scene: &str,
        frame: u64,
        accelerations: &[[f32; 3]],
        progress: &mut dyn Progress,
    ) -> Result<Status> {
        let bytes = |part: &[[f32; 3]]| part.as_flattened().iter().flat_map(|it| it.to_le_bytes()).collect();
        let mut first = 0;
        loop {
            let fraction = first as f32 / accelerations.len().max(1) as f32;
            progress.step(fraction, "send accelerations")?;
            let part = &accelerations[first..(first + MAX_PART / 12).min(accelerations.len())];
            let force = Force { scene: scene.into(), frame, first: first as u64, accelerations: bytes(part) };
            let status = self.call_at("scene.force", &force, progress, fraction)?;
            first += part.len();
            if first == accelerations.len() {
                return Ok(status);
            }
        }
    }

    /// Fetches a frame chunk by chunk: what `fetch` asks for, from its first particle to the last of the frame. Begins again
    /// where the server computes the frame anew meanwhile.
    ///
    /// # Errors
    /// Fails with `Invalid` if the server sends chunks that do not fit together or cannot be decoded, with `Cancelled`
    /// if `progress` asks to stop, and as [`Self::call`] does.
    pub fn frame(&mut self, fetch: &Fetch, progress: &mut dyn Progress) -> Result<Frame> {
        let mut next = Fetch { count: MAX_CHUNK, ..fetch.clone() };
        let (mut frame, mut key) = (Frame::default(), None);
        let mut fraction = 0.0;
        loop {
            let chunk: Chunk = self.call_at("frame.fetch", &next, progress, fraction)?;
            if chunk.first != next.first {
                return Err(Error::invalid("the server sent other particles than those that it was asked for"));
            }
            if *key.get_or_insert_with(|| chunk.key.clone()) != chunk.key {
                (frame, key, next.first) = (Frame::default(), None, fetch.first);
                progress.step(fraction, "fetch")?;
                continue;
            }
            for column in &chunk.columns {
                frame.bytes += column.data.len() as u64;
                let values = column.values(chunk.count)?;
                match frame.channels.get_mut(&column.name) {
                    None if frame.count == 0 => {
                        frame.channels.insert(column.name.clone(), (column.width, values));
                    }
                    Some((width, old)) if *width == column.width => old.extend(values)?,
                    _ => return Err(Error::invalid(format!("the channel {:?} is in some chunks only", column.name))),
                }
            }
            frame.count += u64::from(chunk.count);
            next.first += u64::from(chunk.count);
            fraction = (next.first as f32 / chunk.total.max(1) as f32).min(1.0);
            progress.step(fraction, "fetch")?;
            if next.first >= chunk.total {
                return Ok(frame);
            }
            if chunk.count == 0 {
                return Err(Error::invalid("the server sent a chunk without particles"));
            }
        }
    }

    /// Fetches a frame as the file of the cache format that the simulation stored, and passes its parts to `write`. Returns
    /// the bytes of the file.
    ///
    /// # Errors
    /// Fails with `Busy` if the server computes the frame anew meanwhile, with `Io` if `write` does, with `Invalid` if
    /// the server sends a part without bytes, with `Cancelled` if `progress` asks to stop, and as [`Self::call`] does.
    pub fn file(
        &mut self,
        scene: &str,
        frame: u64,
        progress: &mut dyn Progress,
        write: impl FnMut(&[u8]) -> std::io::Result<()>,
    ) -> Result<u64> {
        let ask = |offset| FilePart { scene: scene.into(), frame, offset, length: MAX_PART as u32 };
        self.parts("frame.file", ask, progress, write)
    }

    /// Fetches the surface of a frame as a file that the server makes, and passes its parts to `write`. `settings` are keys
    /// and values of the kind of the simulation, in TOML. Returns the bytes of the file.
    ///
    /// # Errors
    /// Fails with `Busy` if the server computes the frame anew meanwhile, with `Io` if `write` does, with `Invalid` if
    /// the server sends a part without bytes, with `Cancelled` if `progress` asks to stop, and as [`Self::call`] does.
    pub fn surface(
        &mut self,
        (scene, frame): (&str, u64),
        (form, settings): (SurfaceForm, &str),
        progress: &mut dyn Progress,
        write: impl FnMut(&[u8]) -> std::io::Result<()>,
    ) -> Result<u64> {
        let ask = |offset| {
            let (scene, settings) = (scene.into(), settings.into());
            SurfacePart { scene, frame, form, settings, offset, length: MAX_PART as u32 }
        };
        self.parts("frame.surface", ask, progress, write)
    }

    /// Fetches a file part by part by the parameters that `ask` returns for an offset.
    fn parts<P: Serialize>(
        &mut self,
        method: &str,
        ask: impl Fn(u64) -> P,
        progress: &mut dyn Progress,
        mut write: impl FnMut(&[u8]) -> std::io::Result<()>,
    ) -> Result<u64> {
        let (mut offset, mut whole, mut fraction) = (0, None, 0.0);
        loop {
            let FilePartResult { size, key, data } = self.call_at(method, &ask(offset), progress, fraction)?;
            if *whole.get_or_insert_with(|| (size, key.clone())) != (size, key) {
                return Err(Error::new(ErrorKind::Busy, "the frame was computed anew while it was fetched")
                    .advise("fetch it again"));
            }
            write(&data).map_err(|error| Error::new(ErrorKind::Io, error.to_string()))?;
            offset += data.len() as u64;
            fraction = (offset as f32 / size.max(1) as f32).min(1.0);
            progress.step(fraction, "fetch")?;
            if offset >= size {
                return Ok(offset);
            }
            if data.is_empty() {
                return Err(Error::invalid("the server sent a part without bytes"));
            }
        }
    }
}

impl Values {
    fn extend(&mut self, more: Self) -> Result<()> {
        match (self, more) {
            (Self::Floats(all), Self::Floats(more)) => all.extend(more),
            (Self::Integers(all), Self::Integers(more)) => all.extend(more),
            _ => return Err(Error::invalid("a channel has integers in some chunks and floats in others")),
        }
        Ok(())
    }
}

impl Link {
    /// Sends a request and reads its response.
    fn exchange<R: DeserializeOwned>(&mut self, message: &[u8], id: u32) -> std::result::Result<R, Fault> {
        let broken = |error: std::io::Error| {
            let what = match error.kind() {
                std::io::ErrorKind::WouldBlock | std::io::ErrorKind::TimedOut => {
                    "the server does not answer".to_owned()
                }
                _ => format!("the connection broke: {error}"),
            };
            Fault::Broken(Error::new(ErrorKind::Io, what))
        };
        self.stream.write_all(message).and_then(|()| self.stream.flush()).map_err(broken)?;
        loop {
            let mut scanner = Scanner::new(MAX_MESSAGE);
            let length = loop {
                if let Some(length) = scanner.scan(&self.buffer).map_err(Fault::Broken)? {
                    break length;
                }
                let filled = self.buffer.len();
                self.buffer.resize(filled + READ, 0);
                let read = self.stream.read(&mut self.buffer[filled..]);
                self.buffer.truncate(filled + read.as_ref().map_or(0, |count| *count));
                if read.map_err(broken)? == 0 {
                    return Err(broken(std::io::ErrorKind::UnexpectedEof.into()));
                }
            };
            let outcome = match parse(&self.buffer[..length]).map_err(Fault::Broken)? {
                // A response to a call that was given up, or a notification, is none of ours.
                Message::Response { id: theirs, error, result } if theirs == id => match error {
                    [0xc0] => Some(decode(result).map_err(Fault::Refused)),
                    error => Some(Err(Fault::Refused(decode::<Failure>(error).map_or_else(|it| it, Error::from)))),
                },
                _ => None,
            };
            self.buffer.drain(..length);
            if let Some(outcome) = outcome {
                return outcome;
            }
        }
    }
}

/// Opens a connection.
fn open(options: &ClientOptions) -> std::result::Result<Box<dyn Stream>, Fault> {
    let place = options.address.to_string();
    let broken = |error: std::io::Error| Fault::Broken(Error::new(ErrorKind::Io, error.to_string()).at(&place));
    match &options.address {
        #[cfg(unix)]
        Address::Unix(path) => {
            let stream = std::os::unix::net::UnixStream::connect(path).map_err(broken)?;
            stream.set_read_timeout(Some(options.timeout)).map_err(broken)?;
            stream.set_write_timeout(Some(options.timeout)).map_err(broken)?;
            Ok(Box::new(stream))
        }
        #[cfg(not(unix))]
        Address::Unix(_) => Err(Fault::Refused(Error::unsupported("this system has no Unix sockets"))),
        Address::Tcp { host, port, tls } => {
            let missing = || {
                Fault::Refused(
                    Error::invalid("there are no certificates to check the server's against")
                        .at(&place)
                        .advise("name a file with those of its authority"),
                )
            };
            let authorities = match tls {
                true => Some(options.authorities.as_deref().ok_or_else(missing)?),
                false => None,
            };
            let mut last = std::io::Error::from(std::io::ErrorKind::NotFound);
            for address in (host.as_str(), *port).to_socket_addrs().map_err(broken)? {
                match TcpStream::connect_timeout(&address, options.timeout) {
                    Ok(stream) => {
                        stream.set_nodelay(true).map_err(broken)?;
                        stream.set_read_timeout(Some(options.timeout)).map_err(broken)?;
                        stream.set_write_timeout(Some(options.timeout)).map_err(broken)?;
                        return match authorities {
                            None => Ok(Box::new(stream)),
                            Some(path) => Ok(Box::new(encrypt(stream, host, path).map_err(Fault::Refused)?)),
                        };
                    }
                    Err(error) => last = error,
                }
            }
            Err(broken(last))
        }
    }
}

fn load(path: &Path) -> Result<Vec<u8>> {
    relievo_core::file::load(path, u64::MAX)
}
