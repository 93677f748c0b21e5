//! `relievo server run`

use std::path::PathBuf;
use std::process::ExitCode;

use relievo_client::Address;
use relievo_core::{Error, Result};
use relievo_server::{FluidKind, FoamKind, Limits, Server, ServerOptions};

use crate::Outcome;
use crate::args::device::{Adapter, Device};
use crate::server::signals::Signals;

const EXAMPLE: &str = "Example: relievo server run --cache-limit 100G";

#[derive(clap::Args)]
#[command(after_help = EXAMPLE)]
pub struct Arguments {
    /// Where to listen: host:port, or unix:/path. Port 0 takes a free one.
    #[arg(long, value_name = "ADDRESS", default_value_t = Address::default())]
    listen: Address,
    /// The folder of the cache; left out, `relievo` in your folder for caches.
    #[arg(long, value_name = "DIR")]
    cache: Option<PathBuf>,
    /// Bytes of the frames in the cache, with K, M, G or T. The frames that were used longest ago are removed first.
    #[arg(long, value_name = "BYTES", value_parser = crate::bytes, default_value = "32G")]
    cache_limit: u64,
    /// A file with a line for each user: the name, a space and a token of 16 bytes or more.
    #[arg(long, value_name = "FILE")]
    token_file: Option<PathBuf>,
    /// A file with the server's certificates in PEM, its own first. Connections over TCP are then encrypted.
    #[arg(long, value_name = "FILE", requires = "tls_key")]
    tls_cert: Option<PathBuf>,
    /// A file with the key of the certificate in PEM.
    #[arg(long, value_name = "FILE", requires = "tls_cert")]
    tls_key: Option<PathBuf>,
    /// Listens for other machines although tokens and frames are not encrypted.
    #[arg(long)]
    allow_remote_connections_without_encryption: bool,
    /// What makes the steps of fluids. A graphics device has blocks, fills, basins, colliders and forces, but no bodies,
    /// emitters and sinks; foam is simulated by the processor.
    #[arg(long, value_enum, default_value = "cpu")]
    device: Device,
    #[command(flatten)]
    adapter: Adapter,
    /// Threads that simulate; 0 for one per core.
    #[arg(long, default_value_t = 0)]
    threads: usize,
    /// Scenes that are simulated at the same time. They share the threads.
    #[arg(long, value_name = "NUMBER", default_value_t = 2, value_parser = clap::value_parser!(u8).range(1..=64))]
    scenes_at_once: u8,
    /// Bytes that simulations in memory may occupy, with K, M, G or T.
    #[arg(long, value_name = "BYTES", value_parser = crate::bytes, default_value = "8G")]
    memory_limit: u64,
    /// Particles of a scene at most.
    #[arg(long, value_name = "NUMBER", default_value_t = 50_000_000)]
    particles: u64,
    /// Scenes of a user at most.
    #[arg(long, value_name = "NUMBER", default_value_t = 64)]
    scenes: usize,
    /// Bytes of the files of a user at most, with K, M, G or T.
    #[arg(long, value_name = "BYTES", value_parser = crate::bytes, default_value = "4G")]
    files: u64,
    /// Where to serve /healthz and /metrics over HTTP, to this machine: host:port.
    #[arg(long, value_name = "ADDRESS")]
    metrics: Option<Address>,
    /// Also logs calls that fail and frames that are stored.
    #[arg(long)]
    verbose: bool,
}

/// Returns the folder of the cache that is meant where none is named.
pub fn default_cache() -> Result<PathBuf> {
    let folder = |name: &str| std::env::var_os(name).filter(|value| !value.is_empty()).map(PathBuf::from);
    let caches = if cfg!(windows) {
        folder("LOCALAPPDATA")
    } else {
        folder("XDG_CACHE_HOME").or_else(|| Some(folder("HOME")?.join(".cache")))
    };
    let missing = || Error::invalid("there is no folder for caches").advise("name a folder by --cache");
    Ok(caches.ok_or_else(missing)?.join("relievo"))
}

pub fn run(arguments: &Arguments) -> Outcome {
    super::log::begin(if arguments.verbose { tracing::Level::DEBUG } else { tracing::Level::INFO });
    let failed = |error: std::io::Error| Error::internal(format!("cannot wait for signals: {error}"));
    // Before the server starts, so that no signal is lost.
    let mut signals = Signals::new().map_err(failed)?;
    let options = ServerOptions {
        listen: arguments.listen.clone(),
        cache: arguments.cache.clone().map_or_else(default_cache, Ok)?,
        tokens: arguments.token_file.clone(),
        encryption: arguments.tls_cert.clone().zip(arguments.tls_key.clone()).map(<[PathBuf; 2]>::from),
        insecure: arguments.allow_remote_connections_without_encryption,
        threads: arguments.threads,
        workers: arguments.scenes_at_once.into(),
        metrics: arguments.metrics.clone(),
        limits: Limits {
            cache: arguments.cache_limit,
            memory: arguments.memory_limit,
            particles: arguments.particles,
            scenes: arguments.scenes,
            files: arguments.files,
            ..Limits::default()
        },
    };
    let device = arguments.adapter.open(arguments.device, arguments.memory_limit)?;
    let mut server = Server::start(options, vec![Box::new(FluidKind { device }), Box::new(FoamKind)])?;
    crate::print(&format!("listening at {}\n", server.address()))?;
    if let Some(metrics) = server.metrics() {
        crate::print(&format!("metrics at http://{metrics}/metrics\n"))?;
    }
    signals.wait();
    // A second signal does not wait for the frames that are computed.
    std::thread::spawn(move || {
        signals.wait();
        std::process::exit(130);
    });
    server.stop();
    Ok(ExitCode::SUCCESS)
}
