//! Foam as a second kind of simulation, over the same protocol as the first.

use std::path::Path;

use relievo_client::{Activity, Fetch, FrameInfo, FrameName, Submit, SurfaceForm, Values};
use relievo_core::progress::Silent;
use relievo_core::{Context, ErrorKind};
use relievo_simulation::{Foam, FoamDescription, Making, in_folder};

use super::{DAM, connect, fetched, options, scene, start};

/// A dam of which little motion is enough for foam, and whose foam lives long.
fn foaming() -> String {
    let settings = "[foam]\ntrapped_air = [0.1, 1]\ncrests = [0.1, 1]\nenergy = [0.01, 0.5]\nair_rate = 400\n\
                    crest_rate = 400\nseed = 5\n";
    format!("{}\n{settings}", DAM.replace("frames = 6", "frames = 12"))
}

fn submitted(name: &str, description: &str) -> Submit {
    Submit { kind: "foam".into(), ..scene(name, description) }
}

/// The files of all frames of a run on this thread.
fn local(description: &str) -> Vec<Vec<u8>> {
    let context = Context::serial();
    let making = Making { format: "rlvfluid".into(), parts: 1, device: None };
    let mut description = FoamDescription::parse(description).unwrap();
    // As the server bounds it by its limit of particles.
    let most = &mut description.options.settings.most;
    *most = (*most).min(50_000_000 - description.fluid.estimate() as u32);
    let mut foam = Foam::begin(&context, description, &in_folder(Path::new("")), making).unwrap();
    let mut frames = vec![foam.encode(&context).unwrap()];
    while foam.fluid().step() < foam.fluid().last() {
        foam.advance(&context, &mut Silent).unwrap();
        frames.push(foam.encode(&context).unwrap());
    }
    frames
}

#[test]
fn foam_is_simulated_with_its_fluid_and_goes_on_from_any_frame() {
    let folder = tempfile::tempdir().unwrap();
    let description = foaming();
    let expected = local(&description);
    let server = start(options(folder.path()));
    let mut client = connect(&server);
    client.submit(&submitted("foam", &description)).unwrap();
    client.wait("foam", 5, &mut Silent).unwrap();
    // A new server goes on from a frame of the cache.
    drop((client, server));
    let server = start(options(folder.path()));
    let mut client = connect(&server);
    let status = client.wait("foam", 12, &mut Silent).unwrap();
    assert_eq!(status.state, Activity::Done);
    for (frame, expected) in expected.iter().enumerate() {
        assert!(fetched(&mut client, "foam", frame as u64) == *expected, "frame {frame}");
    }
    let fetch = Fetch { scene: "foam".into(), frame: 12, ..Fetch::default() };
    let frame = client.frame(&fetch, &mut Silent).unwrap();
    assert!(frame.count > 100, "{} diffuse particles", frame.count);
    let (1, Values::Floats(kinds)) = &frame.channels["type"] else { panic!("a channel of kinds") };
    assert!(kinds.iter().all(|kind| [0.0, 1.0, 2.0].contains(kind)));
    assert_eq!(status.particles, 256 + frame.count);
    let info: FrameInfo = client.call("frame.info", &FrameName { scene: "foam".into(), frame: 12 }).unwrap();
    assert!((info.seconds - 0.5).abs() < 1e-6 && info.spacing == 0.05);
    // The surface is that of the fluid.
    let mut mesh = Vec::new();
    let write = |part: &[u8]| {
        mesh.extend_from_slice(part);
        Ok(())
    };
    client.surface(("foam", 12), (SurfaceForm::Mesh, ""), &mut Silent, write).unwrap();
    assert!(mesh.starts_with(b"ply") && mesh.len() > 1000);
    let blind = Fetch { particles: relievo_client::Particles::Blind, ..fetch };
    assert_eq!(client.frame(&blind, &mut Silent).unwrap_err().kind, ErrorKind::Unsupported);
}

#[test]
fn foam_is_steered_and_wrong_settings_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let server = start(options(folder.path()));
    let mut client = connect(&server);
    let description = foaming();
    client.submit(&submitted("foam", &description)).unwrap();
    client.wait("foam", 12, &mut Silent).unwrap();
    let before = fetched(&mut client, "foam", 8);
    client.steer("foam", 8, "[foam]\nair_rate = 0\ncrest_rate = 0\nlifetime = [0.01, 0.02]\n").unwrap();
    client.wait("foam", 12, &mut Silent).unwrap();
    assert!(fetched(&mut client, "foam", 8) == before);
    assert!(fetched(&mut client, "foam", 12) != local(&description)[12]);
    for wrong in ["[foam]\nseeds = 1", "[foam]\ndrag = 2", "fps = 30", "[fluid]\nspaces = 1"] {
        assert!(client.steer("foam", 8, wrong).is_err(), "{wrong}");
    }
    assert!(client.submit(&scene("fluid", &description)).is_err(), "a fluid has no table `foam`");
    let damaged = fetched(&mut client, "foam", 9);
    let context = Context::serial();
    for length in (0..damaged.len()).step_by(damaged.len() / 60) {
        assert!(Foam::water(&context, &damaged[..length]).is_err());
    }
}
