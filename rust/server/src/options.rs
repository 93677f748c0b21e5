//! How a server is started, and what its users may use.

use std::path::PathBuf;
use std::time::Duration;

use relievo_client::Address;

/// What a server and each of its users may use at most.
#[derive(Clone, Debug)]
pub struct Limits {
    /// Bytes of the frames in the cache. The frames that were read or made longest ago are removed first.
    pub cache: u64,
    /// Bytes that simulations in memory may occupy, estimated from their particles. Others go on from their last frame.
    pub memory: u64,
    /// Bytes of decoded frames that are held for requests.
    pub decoded: u64,
    /// Connections in all.
    pub connections: usize,
    /// Connections of a user.
    pub user_connections: usize,
    /// Connections that have not introduced a user. The oldest is closed for a new one.
    pub half_open: usize,
    /// Time that a connection has to introduce a user.
    pub greeting: Duration,
    /// Time in which a message, once begun, must arrive, and in which a client must take a response.
    pub message: Duration,
    /// Time without a message after which a connection is closed.
    pub idle: Duration,
    /// Scenes of a user.
    pub scenes: usize,
    /// Frames of a scene.
    pub frames: u64,
    /// Particles of a scene.
    pub particles: u64,
    /// Bytes of the files of a user.
    pub files: u64,
    /// Requests of a user in a second; further ones wait.
    pub requests: u32,
}

impl Default for Limits {
    fn default() -> Self {
        Self {
            cache: 32 << 30,
            memory: 8 << 30,
            decoded: 512 << 20,
            connections: 1024,
            user_connections: 64,
            half_open: 256,
            greeting: Duration::from_secs(10),
            message: Duration::from_secs(60),
            idle: Duration::from_secs(600),
            scenes: 64,
            frames: 100_000,
            particles: 50_000_000,
            files: 4 << 30,
            requests: 4000,
        }
    }
}

/// How a server is started.
#[derive(Clone, Debug)]
pub struct ServerOptions {
    /// Where it listens. Port 0 takes a free one.
    pub listen: Address,
    /// The folder of the cache.
    pub cache: PathBuf,
    /// A file with the users and their tokens, a line each: the name, a space and the token. Without one, whoever connects
    /// is the user `local`.
    pub tokens: Option<PathBuf>,
    /// Files with the server's certificates and their key, in PEM. With them, connections over TCP are encrypted by TLS.
    pub encryption: Option<[PathBuf; 2]>,
    /// Whether the server may listen beyond this machine without tokens or encryption.
    pub insecure: bool,
    /// Threads that simulate; 0 for one per core.
    pub threads: usize,
    /// Scenes that are simulated at the same time, 1 at least. They share the threads.
    pub workers: usize,
    /// The address, of this machine, at which health and metrics are served over HTTP.
    pub metrics: Option<Address>,
    /// What may be used at most.
    pub limits: Limits,
}

impl Default for ServerOptions {
    fn default() -> Self {
        Self {
            listen: Address::default(),
            cache: PathBuf::from("relievo-cache"),
            tokens: None,
            encryption: None,
            insecure: false,
            threads: 0,
            workers: 2,
            metrics: None,
            limits: Limits::default(),
        }
    }
}
