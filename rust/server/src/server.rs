//! The server: listens, counts connections and stops in order.

use std::collections::{HashMap, VecDeque};
use std::net::{IpAddr, SocketAddr, ToSocketAddrs};
use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use relievo_client::{Address, VERSION, Welcome};
use relievo_core::{Context, ContextOptions, Error, ErrorKind, Result};
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::{TcpListener, TcpStream};
use tokio::runtime::Runtime;
use tokio::task::AbortHandle;

use crate::connection;
use crate::encryption::Encryption;
use crate::kind::Kind;
use crate::metrics::Metrics;
use crate::options::{Limits, ServerOptions};
use crate::scheduler::Scheduler;
use crate::service::Service;
use crate::users::Users;

/// Threads that read and write on connections.
const IO_THREADS: usize = 2;
/// Threads that run methods that read files or pack frames.
const METHOD_THREADS: usize = 8;
/// How long a client may take to ask for metrics.
const METRICS_PATIENCE: Duration = Duration::from_secs(5);

/// What all connections share.
pub struct Shared {
    service: Service,
    users: Users,
    encryption: Option<Encryption>,
    entered: Mutex<HashMap<String, Entered>>,
    half_open: Mutex<HalfOpen>,
}

/// A user who is connected.
struct Entered {
    connections: usize,
    /// Requests that may be made at once, and when that was counted.
    allowance: f64,
    counted: Instant,
}

/// Connections without a user, the oldest first.
#[derive(Default)]
struct HalfOpen {
    next: u64,
    tasks: VecDeque<(u64, AbortHandle)>,
}

impl Shared {
    pub fn service(&self) -> &Service {
        &self.service
    }

    pub fn users(&self) -> &Users {
        &self.users
    }

    pub fn limits(&self) -> &Limits {
        &self.service.scheduler.limits
    }

    pub fn metrics(&self) -> &Metrics {
        &self.service.scheduler.metrics
    }

    /// Returns what a client hears of the server.
    pub fn welcome(&self, user: String) -> Welcome {
        let server = concat!("relievo ", env!("CARGO_PKG_VERSION")).to_owned();
        Welcome { version: VERSION, server, user, kinds: self.service.scheduler.kinds() }
    }

    /// Counts a connection of a user. Fails where there are too many.
    pub fn enter(&self, user: &str) -> Result<()> {
        let mut entered = self.entered.lock().unwrap_or_else(PoisonError::into_inner);
        let allowance = f64::from(self.limits().requests);
        let new = || Entered { connections: 0, allowance, counted: Instant::now() };
        let entry = entered.entry(user.to_owned()).or_insert_with(new);
        if entry.connections >= self.limits().user_connections {
            return Err(Error::new(
                ErrorKind::Busy,
                format!("a user may have {} connections", self.limits().user_connections),
            )
            .advise("close some"));
        }
        entry.connections += 1;
        Ok(())
    }

    /// Takes back what [`Self::enter`] counted.
    pub fn leave(&self, user: &str) {
        let mut entered = self.entered.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(entry) = entered.get_mut(user) {
            entry.connections -= 1;
            if entry.connections == 0 {
                entered.remove(user);
            }
        }
    }

    /// Counts a request of a user. Returns how long it has to wait, if the user makes too many.
    pub fn pause(&self, user: &str) -> Option<Duration> {
        let rate = f64::from(self.limits().requests.max(1));
        let mut entered = self.entered.lock().unwrap_or_else(PoisonError::into_inner);
        let entry = entered.get_mut(user)?;
        let now = Instant::now();
        entry.allowance = (entry.allowance + rate * (now - entry.counted).as_secs_f64()).min(rate);
        entry.counted = now;
        entry.allowance -= 1.0;
        (entry.allowance < 0.0).then(|| Duration::from_secs_f64(-entry.allowance / rate))
    }

    /// Returns whether there is no room for another connection.
    fn is_full(&self) -> bool {
        self.metrics().connections.get() >= self.limits().connections as u64
    }

    /// Closes the oldest connections without a user until there is room for one more.
    fn make_room(&self, half_open: &mut HalfOpen) {
        half_open.tasks.retain(|(_, task)| !task.is_finished());
        while half_open.tasks.len() >= self.limits().half_open.max(1) {
            if let Some((_, task)) = half_open.tasks.pop_front() {
                task.abort();
                self.metrics().dropped.add(1);
            }
        }
    }

    /// Takes a connection from those without a user.
    pub fn introduced(&self, number: u64) {
        let mut half_open = self.half_open.lock().unwrap_or_else(PoisonError::into_inner);
        half_open.tasks.retain(|(other, _)| *other != number);
    }
}

/// A server that runs. Dropping it stops it.
pub struct Server {
    shared: Arc<Shared>,
    address: Address,
    metrics: Option<Address>,
    runtime: Option<Runtime>,
    workers: Vec<JoinHandle<()>>,
}

/// What is listened at.
enum Listener {
    Tcp(TcpListener),
    #[cfg(unix)]
    Unix(tokio::net::UnixListener),
}

fn thread(name: String, task: impl FnOnce() + Send + 'static) -> Result<JoinHandle<()>> {
    let started = std::thread::Builder::new().name(name).spawn(task);
    started.map_err(|error| Error::internal(format!("cannot start a thread: {error}")))
}

impl Server {
    /// Starts a server.
    ///
    /// # Errors
    /// Fails with `Busy` if another server uses the cache; with `NotFound` or `Io` if the cache, the tokens, the
    /// certificates or the key cannot be read, or the address cannot be listened at; with `Invalid` if the tokens, the
    /// certificates, the key or the number of threads cannot be used, metrics would be served to other machines, or
    /// others than this machine could connect without a token or encryption, unless the options allow it; with
    /// `Unsupported` if metrics are not to be served over TCP, or the build or system lacks TLS or Unix sockets; with
    /// `Memory` if one of these files is longer than 1 MiB; and with `Internal` if threads cannot be started.
    pub fn start(options: ServerOptions, kinds: Vec<Box<dyn Kind>>) -> Result<Self> {
        let users = options.tokens.as_deref().map_or_else(|| Ok(Users::default()), Users::read)?;
        check_reach(&options, &users)?;
        let context = Context::new(&ContextOptions { threads: options.threads, memory_limit: options.limits.memory })?;
        let scheduler = Arc::new(Scheduler::open(context, options.limits.clone(), kinds, &options.cache)?);
        let service = Service::new(scheduler.clone());
        let open = |[certificates, key]: &[PathBuf; 2]| Encryption::open(certificates, key);
        let encryption = options.encryption.as_ref().map(open).transpose()?;
        let is_encrypted = encryption.is_some();
        let (entered, half_open) = (Mutex::default(), Mutex::default());
        let shared = Arc::new(Shared { service, users, encryption, entered, half_open });
        let runtime = tokio::runtime::Builder::new_multi_thread()
            .worker_threads(IO_THREADS)
            .max_blocking_threads(METHOD_THREADS)
            .thread_name("relievo-serve")
            .enable_all()
            .build()
            .map_err(|error| Error::internal(format!("cannot start threads: {error}")))?;
        let (listener, mut address) = runtime.block_on(listen(&options.listen))?;
        if let Address::Tcp { tls, .. } = &mut address {
            *tls = is_encrypted;
        }
        let metrics = match &options.metrics {
            None => None,
            Some(address) => {
                let (listener, address) = runtime.block_on(listen(address))?;
                let listener = match listener {
                    Listener::Tcp(listener) => listener,
                    #[cfg(unix)]
                    Listener::Unix(_) => {
                        return Err(Error::unsupported("metrics are served over TCP")
                            .at("metrics")
                            .advise("name host:port"));
                    }
                };
                runtime.spawn(serve_metrics(listener, shared.clone()));
                Some(address)
            }
        };
        runtime.spawn(accept(listener, shared.clone()));
        let mut workers = Vec::new();
        for number in 0..options.workers.max(1) {
            // A frame is handed over when the one before it is on the disk, so that at most two are in memory.
            let (sender, receiver) = std::sync::mpsc::sync_channel(0);
            let (simulating, writing) = (scheduler.clone(), scheduler.clone());
            workers.push(thread(format!("relievo-simulate-{number}"), move || simulating.run(&sender))?);
            workers.push(thread(format!("relievo-write-{number}"), move || writing.write(&receiver))?);
        }
        tracing::info!(%address, cache = %options.cache.display(), "listening");
        Ok(Self { shared, address, metrics, runtime: Some(runtime), workers })
    }

    /// Returns where the server listens.
    pub fn address(&self) -> &Address {
        &self.address
    }

    /// Returns where health and metrics are served, if they are.
    pub fn metrics(&self) -> Option<&Address> {
        self.metrics.as_ref()
    }

    /// Stops the server: frames that are computed are stored first, and clients are served meanwhile.
    pub fn stop(&mut self) {
        self.shared.service.scheduler.stop();
        for worker in self.workers.drain(..) {
            // A worker that panicked has nothing to finish.
            let _ = worker.join();
        }
        if let Some(runtime) = self.runtime.take() {
            runtime.shutdown_timeout(Duration::from_secs(2));
            if let Address::Unix(path) = &self.address {
                let _ = std::fs::remove_file(path);
            }
            tracing::info!("stopped");
        }
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        self.stop();
    }
}

/// Fails where machines other than this one could connect without tokens and encryption.
fn check_reach(options: &ServerOptions, users: &Users) -> Result<()> {
    let is_local = |ip: IpAddr| ip.is_loopback();
    if let Some(Address::Tcp { host, port, .. }) = &options.metrics
        && !resolve(host, *port)?.iter().all(|address| is_local(address.ip()))
    {
        return Err(Error::invalid("metrics are served to this machine only").at("metrics").advise("name 127.0.0.1"));
    }
    let Address::Tcp { host, port, tls } = &options.listen else { return Ok(()) };
    let is_encrypted = options.encryption.is_some();
    if *tls && !is_encrypted {
        return Err(Error::invalid("there is no certificate for encrypted connections")
            .at(options.listen.to_string())
            .advise("name files by --tls-cert and --tls-key"));
    }
    let is_reached = !resolve(host, *port)?.iter().all(|address| is_local(address.ip()));
    if is_reached && !(options.insecure || users.are_known() && is_encrypted) {
        return Err(Error::invalid("other machines could connect without a token and encryption")
            .at(options.listen.to_string())
            .advise(
                "use --token-file, --tls-cert and --tls-key, listen at 127.0.0.1 or a Unix socket, or use \
                 --allow-remote-connections-without-encryption",
            ));
    }
    Ok(())
}

/// Returns the addresses of a host.
pub fn resolve(host: &str, port: u16) -> Result<Vec<SocketAddr>> {
    let failed = |error: std::io::Error| Error::new(ErrorKind::Io, error.to_string()).at(host);
    Ok((host, port).to_socket_addrs().map_err(failed)?.collect())
}

async fn listen(address: &Address) -> Result<(Listener, Address)> {
    let failed = |error: std::io::Error| {
        Error::new(ErrorKind::Io, error.to_string()).at(address.to_string()).advise("name another address by --listen")
    };
    match address {
        Address::Tcp { host, port, tls } => {
            let listener = TcpListener::bind((host.as_str(), *port)).await.map_err(failed)?;
            let port = listener.local_addr().map_err(failed)?.port();
            Ok((Listener::Tcp(listener), Address::Tcp { host: host.clone(), port, tls: *tls }))
        }
        #[cfg(unix)]
        Address::Unix(path) => {
            use std::os::unix::fs::PermissionsExt;
            // A socket that nobody answers at is what a killed server leaves.
            if path.exists() && std::os::unix::net::UnixStream::connect(path).is_err() {
                std::fs::remove_file(path).map_err(failed)?;
            }
            let listener = tokio::net::UnixListener::bind(path).map_err(failed)?;
            std::fs::set_permissions(path, std::fs::Permissions::from_mode(0o600)).map_err(failed)?;
            Ok((Listener::Unix(listener), address.clone()))
        }
        #[cfg(not(unix))]
        Address::Unix(_) => Err(Error::unsupported("this system has no Unix sockets").at(address.to_string())),
    }
}

/// Accepts connections for ever.
async fn accept(listener: Listener, shared: Arc<Shared>) {
    loop {
        let accepted = match &listener {
            Listener::Tcp(listener) => listener.accept().await.map(|(stream, peer)| {
                // Requests are small, and their answers are waited for.
                let _ = stream.set_nodelay(true);
                begin(stream, peer.to_string(), shared.encryption.clone(), &shared);
            }),
            #[cfg(unix)]
            Listener::Unix(listener) => {
                listener.accept().await.map(|(stream, _)| begin(stream, "a Unix socket".to_owned(), None, &shared))
            }
        };
        if let Err(error) = accepted {
            // Without files to open, there may be some again soon.
            tracing::warn!(%error, "cannot accept a connection");
            tokio::time::sleep(Duration::from_millis(50)).await;
        }
    }
}

/// Begins to serve a connection, in place of the oldest one without a user where there are too many.
fn begin<S>(stream: S, peer: String, encryption: Option<Encryption>, shared: &Arc<Shared>)
where
    S: tokio::io::AsyncRead + tokio::io::AsyncWrite + Unpin + Send + 'static,
{
    shared.metrics().accepted.add(1);
    let mut half_open = shared.half_open.lock().unwrap_or_else(PoisonError::into_inner);
    shared.make_room(&mut half_open);
    if shared.is_full() {
        shared.metrics().dropped.add(1);
        tracing::warn!(peer, "no room for a connection");
        return;
    }
    let number = half_open.next;
    half_open.next += 1;
    let open = Open::new(shared);
    let task = tokio::spawn(async move {
        let shared = open.0.clone();
        match encryption {
            None => connection::serve(stream, (peer, number), shared).await,
            Some(encryption) => {
                // Agreeing on keys is part of the time that a connection without a user has.
                let accepted = tokio::time::timeout(shared.limits().greeting, encryption.accept(stream)).await;
                match accepted {
                    Ok(Ok(stream)) => connection::serve(stream, (peer, number), shared).await,
                    _ => {
                        shared.metrics().dropped.add(1);
                        tracing::warn!(peer, "no encryption was agreed on");
                    }
                }
            }
        }
        drop(open);
    });
    half_open.tasks.push_back((number, task.abort_handle()));
}

/// A connection, counted until it is dropped.
struct Open(Arc<Shared>);

impl Open {
    fn new(shared: &Arc<Shared>) -> Self {
        shared.metrics().connections.add(1);
        Self(shared.clone())
    }
}

impl Drop for Open {
    fn drop(&mut self) {
        self.0.metrics().connections.subtract(1);
    }
}

/// Serves `/healthz` and `/metrics` over HTTP.
async fn serve_metrics(listener: TcpListener, shared: Arc<Shared>) {
    loop {
        let Ok((stream, _)) = listener.accept().await else {
            tokio::time::sleep(Duration::from_millis(50)).await;
            continue;
        };
        let shared = shared.clone();
        tokio::spawn(tokio::time::timeout(METRICS_PATIENCE, answer_http(stream, shared)));
    }
}

async fn answer_http(mut stream: TcpStream, shared: Arc<Shared>) -> std::io::Result<()> {
    let mut head = Vec::new();
    while !head.windows(4).any(|end| end == b"\r\n\r\n") {
        if head.len() > 8192 || stream.read_buf(&mut head).await? == 0 {
            return Ok(());
        }
    }
    let (status, body) = match head.split(|byte| *byte == b' ').nth(1) {
        Some(b"/healthz") => ("200 OK", "ok\n".to_owned()),
        Some(b"/metrics") => ("200 OK", shared.service.metrics()),
        _ => ("404 Not Found", "there are /healthz and /metrics\n".to_owned()),
    };
    let kind = "text/plain; version=0.0.4; charset=utf-8";
    let answer = format!(
        "HTTP/1.1 {status}\r\nContent-Type: {kind}\r\nContent-Length: {}\r\nConnection: close\r\n\r\n{body}",
        body.len()
    );
    stream.write_all(answer.as_bytes()).await?;
    stream.shutdown().await
}
