//! Bench `server`: the dam of 125,000 particles through the server on loopback beside a local run (Morgenroth, Weiskopf,
//! Eberhardt 2013, Section 5: 2 %), bytes and speed of frames, calls while scenes simulate, and steering.

use std::collections::BTreeMap;
use std::path::Path;
use std::time::{Duration, Instant};

use relievo_client::{Address, Client, ClientOptions, Fetch, Packing, Particles, Submit};
use relievo_core::progress::Silent;
use relievo_core::{Context, ContextOptions, Error, Result};
use relievo_particleio::EXTENSION;
use relievo_server::{FluidKind, Server, ServerOptions};
use relievo_simulation::{Description, Making, Simulation, in_folder};

use crate::measure::Sample;
use crate::report::{Goal, Report};

/// Frames of the dam that are simulated, and runs of it.
const FRAMES: u64 = 24;
const RUNS: usize = 3;
/// Fetches of a frame.
const FETCHES: usize = 8;
/// Clients that ask for the state of scenes, the scenes, and for how long.
const CLIENTS: usize = 50;
const SCENES: usize = 4;
const ASKING: Duration = Duration::from_secs(5);

/// Returns the description of a dam of so many particles along each edge, with so many frames.
fn dam(side: u32, frames: u64) -> String {
    let edge = f64::from(side) * 0.02;
    format!(
        "frames = {frames}\nfps = 100\n[fluid]\nspacing = 0.02\n[basin]\nlow = [0, 0, 0]\nhigh = [{}, {edge}, {}]\n\
         [[block]]\nlow = [0, 0, 0]\nhigh = [{edge}, {edge}, {edge}]\n",
        3.0 * edge,
        2.0 * edge
    )
}

fn scene(name: &str, description: String) -> Submit {
    Submit { scene: name.into(), kind: "fluid".into(), description, files: BTreeMap::new(), forced: false }
}

fn start(cache: &Path) -> Result<Server> {
    let listen = Address::Tcp { host: "127.0.0.1".into(), port: 0, tls: false };
    let options = ServerOptions { listen, cache: cache.to_owned(), ..ServerOptions::default() };
    Server::start(options, vec![Box::new(FluidKind::default())])
}

fn connect(server: &Server) -> Result<Client> {
    Client::connect(ClientOptions { address: server.address().clone(), ..ClientOptions::default() })
}

fn folder() -> Result<tempfile::TempDir> {
    tempfile::tempdir().map_err(|error| Error::io(&std::env::temp_dir(), &error))
}

/// Measures all cases into `report`.
pub fn run(report: &mut Report) -> Result<()> {
    beside_local(report)?;
    polling(report)?;
    steering(report)
}

/// Seconds of a local run that writes its frames, and their bytes.
fn local(description: &str) -> Result<(f64, Vec<Vec<u8>>)> {
    let folder = folder()?;
    let context = Context::new(&ContextOptions::default())?;
    let begin = Instant::now();
    let making = Making { format: EXTENSION.into(), parts: 1, device: None };
    let mut simulation =
        Simulation::begin(&context, Description::parse(description)?, &in_folder(folder.path()), making)?;
    let mut frames = Vec::new();
    loop {
        let frame = simulation.encode(&context)?;
        let path = folder.path().join(simulation.step().to_string());
        relievo_core::file::store(&path, |out| std::io::Write::write_all(out, &frame))?;
        frames.push(frame);
        if simulation.step() == simulation.last() {
            return Ok((begin.elapsed().as_secs_f64(), frames));
        }
        simulation.advance(&context, |_| Ok(()))?;
    }
}

fn beside_local(report: &mut Report) -> Result<()> {
    let description = dam(50, FRAMES);
    let (mut here, mut there) = (Vec::new(), Vec::new());
    for _ in 0..RUNS {
        let (seconds, frames) = local(&description)?;
        here.push(seconds);
        let folder = folder()?;
        let server = start(folder.path())?;
        let mut client = connect(&server)?;
        let begin = Instant::now();
        client.submit(&scene("dam", description.clone()))?;
        for frame in 0..=FRAMES {
            client.wait("dam", frame, &mut Silent)?;
            let mut fetched = Vec::new();
            client.file("dam", frame, &mut Silent, |part| {
                fetched.extend_from_slice(part);
                Ok(())
            })?;
            if fetched != frames[frame as usize] {
                return Err(Error::internal(format!("frame {frame} through the server differs from the local run's")));
            }
        }
        there.push(begin.elapsed().as_secs_f64());
        if there.len() == RUNS {
            transfer(report, &mut client)?;
        }
    }
    let (here, there) = (Sample::new(here), Sample::new(there));
    report.add(
        "dam of 125,000: frames through the server",
        &there,
        Some(("local run", &here)),
        "s",
        Goal::RatioAtMost(1.02),
    );
    Ok(())
}

/// Bytes and speed of the last frame of the dam in several encodings.
fn transfer(report: &mut Report, client: &mut Client) -> Result<()> {
    let nine = |packing, differences, half, particles| Fetch {
        scene: "dam".into(),
        frame: FRAMES,
        channels: ["position", "velocity", "number"].map(str::to_owned).into(),
        packing,
        differences,
        half,
        particles,
        ..Fetch::default()
    };
    let plain = nine(Packing::None, false, false, Particles::All);
    // The first fetch decodes the frame from the cache.
    let all = client.frame(&plain, &mut Silent)?;
    let mut rates = Vec::new();
    for _ in 0..FETCHES {
        let begin = Instant::now();
        let frame = client.frame(&plain, &mut Silent)?;
        rates.push(frame.bytes as f64 / 1e6 / begin.elapsed().as_secs_f64());
    }
    report.add("frames on loopback, plain", &Sample::new(rates), None, "MB/s", Goal::AtLeast(500.0));
    let count = all.count as f64;
    let cases = [
        ("plain", nine(Packing::None, false, false, Particles::All), Goal::None),
        ("lz4", nine(Packing::Lz4, false, false, Particles::All), Goal::None),
        ("zstd", nine(Packing::Zstd, false, false, Particles::All), Goal::AtMost(21.0)),
        ("zstd of differences", nine(Packing::Zstd, true, false, Particles::All), Goal::AtMost(21.0)),
        ("zstd of halves, blind particles", nine(Packing::Zstd, true, true, Particles::Blind), Goal::AtMost(9.0)),
    ];
    for (name, fetch, goal) in cases {
        let bytes = client.frame(&fetch, &mut Silent)?.bytes as f64 / count;
        let case = format!("bytes a particle of the frame: {name}");
        report.add(&case, &Sample::new(vec![bytes]), None, "bytes", goal);
    }
    Ok(())
}

/// Many clients ask for states while several scenes simulate.
fn polling(report: &mut Report) -> Result<()> {
    let folder = folder()?;
    let server = start(folder.path())?;
    let mut client = connect(&server)?;
    let name = |number: usize| format!("dam {number}");
    for number in 0..SCENES {
        // Different ones, so that none finds the frames of another.
        let description = dam(20 + number as u32, 100_000 - 1);
        client.submit(&scene(&name(number), description))?;
    }
    let end = Instant::now() + ASKING;
    let ask = |number: usize| -> Result<Vec<f64>> {
        let mut client = connect(&server)?;
        let (mut times, mut ready) = (Vec::new(), 0);
        while Instant::now() < end {
            let begin = Instant::now();
            let status = client.status(&name(number % SCENES))?;
            times.push(1e3 * begin.elapsed().as_secs_f64());
            if status.ready < ready {
                return Err(Error::internal("a frame was lost"));
            }
            ready = status.ready;
            std::thread::sleep(Duration::from_millis(20));
        }
        Ok(times)
    };
    let ask = &ask;
    let times = std::thread::scope(|scope| {
        let askers: Vec<_> = (0..CLIENTS).map(|number| scope.spawn(move || ask(number))).collect();
        let join = askers.into_iter().map(|asker| asker.join());
        join.map(|times| times.unwrap_or_else(|_| Err(Error::internal("a client panicked"))))
            .collect::<Result<Vec<_>>>()
    });
    let mut times = times?.concat();
    times.sort_by(f64::total_cmp);
    let at = times.len() * 99 / 100;
    let case = format!("status of {SCENES} scenes asked by {CLIENTS} clients: p99 of {} calls", times.len());
    report.add(&case, &Sample::new(vec![times[at]]), None, "ms", Goal::AtMost(50.0));
    Ok(())
}

/// From a changed parameter to its first frame, beside the time of a frame.
fn steering(report: &mut Report) -> Result<()> {
    let folder = folder()?;
    let server = start(folder.path())?;
    let mut client = connect(&server)?;
    client.submit(&scene("dam", dam(50, FRAMES)))?;
    client.wait("dam", 4, &mut Silent)?;
    let begin = Instant::now();
    client.wait("dam", 6, &mut Silent)?;
    let frame = begin.elapsed().as_secs_f64() / 2.0;
    client.wait("dam", FRAMES, &mut Silent)?;
    let begin = Instant::now();
    client.steer("dam", 4, "fluid.viscosity = 0.01")?;
    client.wait("dam", 5, &mut Silent)?;
    let beyond = 1e3 * (begin.elapsed().as_secs_f64() - frame);
    let case = "first frame of a changed parameter, beyond the time of a frame";
    report.add(case, &Sample::new(vec![beyond]), None, "ms", Goal::AtMost(100.0));
    Ok(())
}
