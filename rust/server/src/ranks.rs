//! Messages between the domains of one fluid in several processes, as MessagePack-RPC over TCP: the transport of
//! `relievo fluid rank`, where a cluster has no MPI.
//!
//! Each rank listens at its address and connects to the ranks before it. The first message of a connection is the request
//! `domain.join`. After its response both sides send notifications `domain.part`, which are the parts of the messages of
//! [`Transport`].

use std::io::{ErrorKind as IoKind, Read, Write};
use std::net::{Shutdown, TcpListener, TcpStream};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, SyncSender, channel, sync_channel};
use std::sync::{Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use relievo_client::{
    Address, Failure, Hash, MAX_GREETING, MAX_MESSAGE, MAX_PART, Message, Nothing, Scanner, decode, failure,
    notification, parameters, parse, request, response,
};
use relievo_core::{Error, ErrorKind, Result};
use relievo_fluid::Transport;
use serde::{Deserialize, Serialize};
use subtle::ConstantTimeEq;

use crate::server::resolve;

/// The request that begins a connection.
const JOIN: &str = "domain.join";
/// The notification that carries a part of a message.
const PART: &str = "domain.part";
/// Bytes that are read at a time.
const READ: usize = 1 << 18;
/// Connections at most that have not joined yet; further ones are closed.
const GREETED: usize = 64;
/// The time that a connection has to join.
const GREETING: Duration = Duration::from_secs(5);
/// The pause between two tries to connect or to accept.
const PAUSE: Duration = Duration::from_millis(5);

/// How a rank joins the others.
#[derive(Clone, Debug)]
pub struct RankOptions {
    /// Where each rank listens over TCP, in the order of ranks; the same list on all of them.
    pub addresses: Vec<Address>,
    /// The number of this rank, from 0.
    pub rank: usize,
    /// What each rank shows to those before it, the same on all; empty for nothing.
    pub token: String,
    /// Whether ranks may be on other machines although messages are not encrypted.
    pub insecure: bool,
    /// How long to wait for the other ranks to begin.
    pub joining: Duration,
    /// How long to wait for a message of another rank.
    pub patience: Duration,
    /// Bytes of a message at most; 0 for no limit.
    pub limit: u64,
}

impl Default for RankOptions {
    fn default() -> Self {
        Self {
            addresses: Vec::new(),
            rank: 0,
            token: String::new(),
            insecure: false,
            joining: Duration::from_secs(60),
            patience: Duration::from_secs(600),
            limit: 8 << 30,
        }
    }
}

/// Parameters of `domain.join`.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct Join {
    /// The release of the program: others may give other bits.
    release: String,
    rank: u64,
    ranks: u64,
    #[serde(default)]
    token: String,
}

/// Parameters of `domain.part`.
#[derive(Debug, Serialize, Deserialize)]
struct Part {
    /// Bytes of the message that follow this part.
    following: u64,
    #[serde(with = "serde_bytes")]
    data: Vec<u8>,
}

/// A connection whose messages are read one by one.
struct Messages {
    stream: TcpStream,
    buffer: Vec<u8>,
    taken: usize,
}

impl Messages {
    fn new(stream: TcpStream) -> Self {
        Self { stream, buffer: Vec::new(), taken: 0 }
    }

    /// Reads the next message of at most `limit` bytes, until a time if one is given. Fails where the connection ends.
    fn next(&mut self, limit: usize, end: Option<Instant>) -> Result<&[u8]> {
        let broken = |error: std::io::Error| Error::new(ErrorKind::Io, error.to_string());
        self.buffer.drain(..self.taken);
        self.taken = 0;
        let mut scanner = Scanner::new(limit);
        loop {
            if let Some(length) = scanner.scan(&self.buffer)? {
                self.taken = length;
                return Ok(&self.buffer[..length]);
            }
            if let Some(end) = end {
                let left = end.saturating_duration_since(Instant::now());
                if left.is_zero() {
                    return Err(broken(IoKind::TimedOut.into()));
                }
                self.stream.set_read_timeout(Some(left)).map_err(broken)?;
            }
            let filled = self.buffer.len();
            self.buffer.resize(filled + READ, 0);
            let read = self.stream.read(&mut self.buffer[filled..]);
            self.buffer.truncate(filled + read.as_ref().map_or(0, |count| *count));
            match read {
                Ok(0) => return Err(broken(IoKind::UnexpectedEof.into())),
                Err(error) if error.kind() != IoKind::Interrupted => return Err(broken(error)),
                _ => {}
            }
        }
    }

    fn send(&mut self, message: &[u8]) -> Result<()> {
        self.stream.write_all(message).map_err(|error| Error::new(ErrorKind::Io, error.to_string()))
    }
}

/// A connection to another rank.
struct Link {
    stream: TcpStream,
    /// What the thread that reads has put together. The lock makes it shareable; nobody waits for it.
    received: Mutex<Receiver<Result<Vec<u8>>>>,
    reader: Option<JoinHandle<()>>,
}

impl Link {
    fn new(mut messages: Messages, options: &RankOptions) -> Result<Self> {
        let failed = |error: std::io::Error| Error::new(ErrorKind::Io, error.to_string());
        messages.stream.set_read_timeout(None).map_err(failed)?;
        messages.stream.set_write_timeout(Some(options.patience)).map_err(failed)?;
        let stream = messages.stream.try_clone().map_err(failed)?;
        let limit = if options.limit == 0 { u64::MAX } else { options.limit };
        // A rank is at most one exchange ahead. Reading goes on while this rank sends, so that two that send to each other do
        // not wait for ever.
        let (sender, receiver) = sync_channel(1);
        let read = move || forward(&mut messages, limit, &sender);
        let reader = std::thread::Builder::new().name("relievo-rank".into()).spawn(read).map_err(failed)?;
        Ok(Self { stream, received: Mutex::new(receiver), reader: Some(reader) })
    }

    fn send(&mut self, message: &[u8]) -> Result<()> {
        let failed = |error: std::io::Error| Error::new(ErrorKind::Io, error.to_string());
        let mut rest = message;
        loop {
            let (data, following) = rest.split_at(rest.len().min(MAX_PART));
            let part = Part { following: following.len() as u64, data: data.to_vec() };
            self.stream.write_all(&notification(PART, &part)?).map_err(failed)?;
            rest = following;
            if rest.is_empty() {
                return Ok(());
            }
        }
    }

    fn receive(&mut self, patience: Duration) -> Result<Vec<u8>> {
        match self.received.get_mut().unwrap_or_else(PoisonError::into_inner).recv_timeout(patience) {
            Ok(message) => message,
            Err(RecvTimeoutError::Timeout) => {
                Err(Error::new(ErrorKind::Io, format!("no message came for {} s", patience.as_secs())))
            }
            Err(RecvTimeoutError::Disconnected) => Err(Error::new(ErrorKind::Io, "the connection is closed")),
        }
    }
}

impl Drop for Link {
    fn drop(&mut self) {
        // What was sent is still delivered. The thread that reads ends with the connection, or where nobody takes what it has.
        let _ = self.stream.shutdown(Shutdown::Both);
        let (_, nobody) = sync_channel(0);
        self.received = Mutex::new(nobody);
        if let Some(reader) = self.reader.take() {
            let _ = reader.join();
        }
    }
}

/// Passes on whole messages until the connection or the receiver ends.
fn forward(messages: &mut Messages, limit: u64, sender: &SyncSender<Result<Vec<u8>>>) {
    loop {
        let message = assemble(messages, limit);
        let is_last = message.is_err();
        if sender.send(message).is_err() || is_last {
            return;
        }
    }
}

/// Reads the parts of a message. Memory grows with what arrives, not with what a part says of the rest.
fn assemble(messages: &mut Messages, limit: u64) -> Result<Vec<u8>> {
    let mut message = Vec::new();
    loop {
        let Message::Notification { method: PART, parameters } = parse(messages.next(MAX_MESSAGE, None)?)? else {
            return Err(Error::invalid(format!("what came is no `{PART}`")));
        };
        let Part { following, data } = relievo_client::parameters(parameters)?;
        let size = (message.len() as u64).saturating_add(data.len() as u64).saturating_add(following);
        if size > limit {
            return Err(Error::memory(format!("a message of {size} bytes is beyond the limit of {limit}"))
                .advise("take more ranks, or raise --memory-limit"));
        }
        if data.is_empty() && following > 0 {
            return Err(Error::invalid("a part of a message is empty"));
        }
        message.extend_from_slice(&data);
        if following == 0 {
            return Ok(message);
        }
    }
}

/// Carries messages between processes, on one machine or several.
pub struct RpcRanks {
    rank: usize,
    patience: Duration,
    /// Of each rank; none to itself.
    links: Vec<Option<Link>>,
}

impl RpcRanks {
    /// Connects this rank with all others, which call this at about the same time with the same list.
    ///
    /// # Errors
    /// An address cannot be listened at, a rank does not begin in time, is of another release, has another list or another
    /// token; or ranks are on other machines, which `insecure` does not allow.
    pub fn join(options: &RankOptions) -> Result<Self> {
        let (own, ranks) = (options.rank, options.addresses.len());
        if own >= ranks {
            return Err(Error::invalid(format!("rank {own} is not among {ranks}"))
                .at("rank")
                .advise("number ranks from 0, and name an address for each"));
        }
        check_reach(options)?;
        let end = Instant::now() + options.joining;
        // The last rank has nobody who connects to it.
        let listener = (own + 1 < ranks).then(|| listen(&options.addresses[own])).transpose()?;
        let mut links: Vec<Option<Link>> = (0..ranks).map(|_| None).collect();
        for (rank, link) in links.iter_mut().enumerate().take(own) {
            let joined = dial(options, rank, end).map_err(|error| error.at(place(options, rank)))?;
            *link = Some(Link::new(joined, options)?);
        }
        if let Some(listener) = &listener {
            accept(listener, options, end, &mut links)?;
        }
        Ok(Self { rank: own, patience: options.patience, links })
    }
}

impl Transport for RpcRanks {
    fn rank(&self) -> usize {
        self.rank
    }

    fn ranks(&self) -> usize {
        self.links.len()
    }

    fn exchange(&mut self, mut sent: Vec<Vec<u8>>) -> Result<Vec<Vec<u8>>> {
        if sent.len() != self.links.len() {
            let (given, ranks) = (sent.len(), self.links.len());
            return Err(Error::internal(format!("{given} messages are given for {ranks} ranks")));
        }
        for (rank, (link, message)) in self.links.iter_mut().zip(&sent).enumerate() {
            if let Some(link) = link {
                link.send(message).map_err(|error| ended(rank, error))?;
            }
        }
        let mut own = std::mem::take(&mut sent[self.rank]);
        let patience = self.patience;
        let receive = |(rank, link): (usize, &mut Option<Link>)| match link {
            Some(link) => link.receive(patience).map_err(|error| ended(rank, error)),
            None => Ok(std::mem::take(&mut own)),
        };
        self.links.iter_mut().enumerate().map(receive).collect()
    }
}

fn ended(rank: usize, cause: Error) -> Error {
    let remedy = match cause.remedy.is_empty() {
        true => "read its own message; then go on from the last frame".into(),
        false => cause.remedy,
    };
    Error::new(cause.kind, format!("a domain of the fluid has ended: {}", cause.what))
        .at(format!("rank {rank}"))
        .advise(remedy)
}

fn place(options: &RankOptions, rank: usize) -> String {
    format!("rank {rank} at {}", options.addresses[rank])
}

/// Fails if ranks are on other machines and that is not allowed, or an address is none of TCP.
fn check_reach(options: &RankOptions) -> Result<()> {
    for (rank, address) in options.addresses.iter().enumerate() {
        let Address::Tcp { host, port, tls: false } = address else {
            return Err(Error::unsupported("ranks are connected by TCP without encryption")
                .at(place(options, rank))
                .advise("use host:port"));
        };
        let is_local = resolve(host, *port)?.iter().all(|address| address.ip().is_loopback());
        if !options.insecure && !is_local {
            return Err(Error::invalid("what ranks send to other machines is not encrypted")
                .at(place(options, rank))
                .advise("use a network that nobody else reads and --allow-remote-connections-without-encryption"));
        }
    }
    Ok(())
}

/// Returns the host and port of an address over TCP.
fn host(address: &Address) -> Result<(&str, u16)> {
    match address {
        Address::Tcp { host, port, .. } => Ok((host, *port)),
        Address::Unix(_) => Err(Error::unsupported("ranks are connected by TCP").at(address.to_string())),
    }
}

fn listen(address: &Address) -> Result<TcpListener> {
    let failed = |error: std::io::Error| Error::new(ErrorKind::Io, error.to_string()).at(address.to_string());
    let listener = TcpListener::bind(host(address)?).map_err(failed)?;
    listener.set_nonblocking(true).map_err(failed)?;
    Ok(listener)
}

/// Connects to an earlier rank, again and again until it has begun.
fn dial(options: &RankOptions, rank: usize, end: Instant) -> Result<Messages> {
    let (host, port) = host(&options.addresses[rank])?;
    let join = Join {
        release: env!("CARGO_PKG_VERSION").into(),
        rank: options.rank as u64,
        ranks: options.addresses.len() as u64,
        token: options.token.clone(),
    };
    let join = request(1, JOIN, &join)?;
    let mut last = Error::new(ErrorKind::Io, "it does not answer");
    loop {
        for address in resolve(host, port)? {
            let left = end.saturating_duration_since(Instant::now());
            if left.is_zero() {
                return Err(last.advise("begin all ranks within a minute, with the same --ranks"));
            }
            let connected = TcpStream::connect_timeout(&address, left).and_then(|stream| {
                stream.set_nodelay(true)?;
                Ok(stream)
            });
            let mut messages = match connected {
                Ok(stream) => Messages::new(stream),
                Err(error) => {
                    last = Error::new(ErrorKind::Io, error.to_string());
                    continue;
                }
            };
            let answered =
                messages.send(&join).and_then(|()| messages.next(MAX_GREETING, Some(end)).map(<[u8]>::to_vec));
            match answered {
                // A rank that has no room for the connection closes it.
                Err(error) => last = error,
                Ok(answer) => match parse(&answer)? {
                    Message::Response { error: [0xc0], .. } => return Ok(messages),
                    Message::Response { error, .. } => {
                        return Err(decode::<Failure>(error).map_or_else(|it| it, Error::from));
                    }
                    // A port of this machine that nobody listens at may connect to itself.
                    _ => last = Error::invalid("it is no rank of a fluid"),
                },
            }
        }
        std::thread::sleep(PAUSE);
    }
}

/// Accepts all later ranks. Connections of others are closed and hold up nobody.
fn accept(listener: &TcpListener, options: &RankOptions, end: Instant, links: &mut [Option<Link>]) -> Result<()> {
    let failed = |error: std::io::Error| Error::new(ErrorKind::Io, error.to_string()).at("accepting ranks");
    let (sender, greeted) = channel();
    let mut open = 0;
    while let Some(missing) = (options.rank + 1..links.len()).find(|rank| links[*rank].is_none()) {
        match listener.accept() {
            Ok((stream, _)) if open < GREETED => {
                stream.set_nonblocking(false).and_then(|()| stream.set_nodelay(true)).map_err(failed)?;
                let (options, sender) = (options.clone(), sender.clone());
                let greet = move || greet(stream, &options, &sender);
                std::thread::Builder::new().name("relievo-join".into()).spawn(greet).map_err(failed)?;
                open += 1;
            }
            Ok(_) => {}
            Err(error) if error.kind() == IoKind::WouldBlock => std::thread::sleep(PAUSE),
            Err(error) => return Err(failed(error)),
        }
        while let Ok(outcome) = greeted.try_recv() {
            open -= 1;
            let Some((rank, mut messages)) = outcome else { continue };
            let answer = match links[rank] {
                None => response(1, &Nothing {})?,
                Some(_) => {
                    let error =
                        Error::invalid(format!("rank {rank} has joined before")).advise("number each rank once");
                    let _ = messages.send(&failure(1, &Failure::from(&error))?);
                    continue;
                }
            };
            // A rank that ended meanwhile may begin again.
            if messages.send(&answer).is_ok() {
                links[rank] = Some(Link::new(messages, options)?);
            }
        }
        if Instant::now() > end {
            return Err(Error::new(ErrorKind::Io, format!("it did not begin within {} s", options.joining.as_secs()))
                .at(place(options, missing))
                .advise("begin all ranks within a minute, with the same --ranks"));
        }
    }
    Ok(())
}

/// Reads who connects, and refuses what is no later rank of this run.
fn greet(stream: TcpStream, options: &RankOptions, sender: &Sender<Option<(usize, Messages)>>) {
    let mut messages = Messages::new(stream);
    let joined =
        messages.next(MAX_GREETING, Some(Instant::now() + GREETING)).and_then(|message| rank(message, options));
    let joined = match joined {
        Ok(rank) => Some((rank, messages)),
        Err(error) => {
            if let Ok(answer) = failure(1, &Failure::from(&error)) {
                let _ = messages.send(&answer);
            }
            None
        }
    };
    // Where all have joined, nobody listens.
    let _ = sender.send(joined);
}

/// Returns the rank that a request to join is of.
fn rank(message: &[u8], options: &RankOptions) -> Result<usize> {
    let Message::Request { method: JOIN, parameters: join, .. } = parse(message)? else {
        return Err(Error::invalid(format!("the first call of a rank is `{JOIN}`")));
    };
    let Join { release, rank, ranks, token } = parameters(join)?;
    let [theirs, ours] = [token.as_bytes(), options.token.as_bytes()].map(Hash::of);
    if !bool::from(theirs.0.ct_eq(&ours.0)) {
        return Err(Error::invalid("the ranks have different tokens").advise("give all the same --token-file"));
    }
    if release != env!("CARGO_PKG_VERSION") {
        let own = env!("CARGO_PKG_VERSION");
        return Err(Error::unsupported(format!("the ranks are of the releases {release:?} and {own}"))
            .advise("take the same release on all machines"));
    }
    let own = options.addresses.len();
    let later = options.rank as u64 + 1..own as u64;
    if ranks != own as u64 || !later.contains(&rank) {
        return Err(Error::invalid(format!("rank {rank} of {ranks} connects to rank {} of {own}", options.rank))
            .advise("give all ranks the same --ranks, and each its own --rank"));
    }
    Ok(rank as usize)
}
