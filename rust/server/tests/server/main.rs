//! The server from outside: whole simulations over sockets, a client in another language, crashes, and strangers.

mod cache;
#[cfg(target_os = "linux")]
mod clock;
mod codec;
mod device;
mod disk;
#[cfg(feature = "tls")]
mod encryption;
mod exchange;
mod faults;
mod foam;
mod killed;
mod python;
mod ranks;
mod steering;
mod surfaces;
mod transfer;

use std::path::Path;
use std::time::Duration;

use relievo_client::{Address, Client, ClientOptions, Submit};
use relievo_core::progress::Silent;
use relievo_core::{Context, ContextOptions};
use relievo_server::{FluidKind, FoamKind, Limits, Server, ServerOptions};
use relievo_simulation::{Description, Making, Simulation, in_folder};

/// A small dam that breaks: 8 × 4 × 8 particles.
const DAM: &str = "
frames = 6
[fluid]
spacing = 0.05
viscosity = 0.001
[basin]
low = [0, 0, 0]
high = [0.8, 0.4, 0.4]
[[block]]
low = [0, 0, 0]
high = [0.4, 0.2, 0.4]
";

fn options(cache: &Path) -> ServerOptions {
    let listen = Address::Tcp { host: "127.0.0.1".into(), port: 0, tls: false };
    ServerOptions { listen, cache: cache.to_owned(), threads: 1, workers: 1, ..ServerOptions::default() }
}

fn start(options: ServerOptions) -> Server {
    Server::start(options, vec![Box::new(FluidKind::default()), Box::new(FoamKind)]).expect("the server starts")
}

fn limited(cache: &Path, limits: Limits) -> Server {
    start(ServerOptions { limits, ..options(cache) })
}

fn client_options(address: &Address) -> ClientOptions {
    let patience = Duration::from_secs(10);
    ClientOptions { address: address.clone(), patience, ..ClientOptions::default() }
}

fn connect(server: &Server) -> Client {
    Client::connect(client_options(server.address())).expect("the client connects")
}

fn scene(name: &str, description: &str) -> Submit {
    Submit {
        scene: name.into(),
        kind: "fluid".into(),
        description: description.into(),
        files: Default::default(),
        forced: false,
    }
}

/// The files of all frames that a local run writes.
fn local_frames(description: &str) -> Vec<Vec<u8>> {
    let context = Context::new(&ContextOptions { threads: 2, memory_limit: 0 }).expect("a context");
    let making = Making { format: "rlvfluid".into(), parts: 1, device: None };
    let description = Description::parse(description).expect("a description");
    let mut simulation = Simulation::begin(&context, description, &in_folder(Path::new("")), making).expect("a fluid");
    let mut frames = vec![simulation.encode(&context).expect("a frame")];
    while simulation.step() < simulation.last() {
        simulation.advance(&context, |_| Ok(())).expect("a step");
        frames.push(simulation.encode(&context).expect("a frame"));
    }
    frames
}

/// The file of a frame, fetched.
fn fetched(client: &mut Client, scene: &str, frame: u64) -> Vec<u8> {
    let mut bytes = Vec::new();
    let write = |part: &[u8]| {
        bytes.extend_from_slice(part);
        Ok(())
    };
    client.file(scene, frame, &mut Silent, write).expect("the frame is there");
    bytes
}
