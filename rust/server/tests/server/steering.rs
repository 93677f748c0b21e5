//! Changes on the way, and forces by the host.

use std::path::Path;

use relievo_client::{Activity, Force, Status};
use relievo_core::progress::Silent;
use relievo_core::{Context, ErrorKind};
use relievo_server::ServerOptions;

use super::{DAM, connect, fetched, local_frames, options, scene, start};

const FLAT: &str = "[fluid]\ngravity = [0, 0, 0]\nviscosity = 0.1\n";

/// The files of frames of a local run that changes after frame 3.
fn steered_locally() -> Vec<Vec<u8>> {
    use relievo_simulation::{Description, Making, Simulation, in_folder};
    let context = Context::serial();
    let begin = |text: &str| {
        let making = Making { format: "rlvfluid".into(), parts: 1, device: None };
        Simulation::begin(&context, Description::parse(text).unwrap(), &in_folder(Path::new("")), making).unwrap()
    };
    let mut frames = local_frames(DAM);
    let mut changed = begin(&DAM.replace("viscosity = 0.001", "viscosity = 0.1\ngravity = [0, 0, 0]"));
    changed.restore(Simulation::decode(&context, &frames[3]).unwrap()).unwrap();
    for frame in &mut frames[4..] {
        changed.advance(&context, |_| Ok(())).unwrap();
        *frame = changed.encode(&context).unwrap();
    }
    frames
}

#[test]
fn a_change_computes_anew_from_its_frame_on() {
    let folder = tempfile::tempdir().unwrap();
    let server = start(options(folder.path()));
    let mut client = connect(&server);
    client.submit(&scene("dam", DAM)).unwrap();
    client.wait("dam", 6, &mut Silent).unwrap();
    let status = client.steer("dam", 3, FLAT).unwrap();
    assert_eq!((status.ready, status.state), (4, Activity::Running));
    client.wait("dam", 6, &mut Silent).unwrap();
    let (expected, unchanged) = (steered_locally(), local_frames(DAM));
    assert!(expected[4] != unchanged[4]);
    for (frame, expected) in expected.iter().enumerate() {
        assert!(fetched(&mut client, "dam", frame as u64) == *expected, "frame {frame}");
    }
    // The same change again, which a client repeats after its connection broke, changes nothing.
    assert_eq!(client.steer("dam", 3, FLAT).unwrap().ready, 7);
    // Changed back, the frames are those in the cache.
    let status = client.steer("dam", 3, "[fluid]\ngravity = [0, 0, -9.81]\nviscosity = 0.001\n").unwrap();
    assert!(status.ready >= 4);
    for wrong in ["[fluid]\nviscosty = 1\n", "fps = 30", "[fluid", "[fluid]\nspacing = -1"] {
        assert!(client.steer("dam", 3, wrong).is_err(), "{wrong}");
    }
    assert!(client.steer("dam", 99, FLAT).is_err());
    assert_eq!(client.steer("dam", 5, "frames = 8").unwrap().frames, 9);
    assert_eq!(client.wait("dam", 8, &mut Silent).unwrap().state, Activity::Done);
}

#[test]
fn steered_scenes_go_on_after_a_restart() {
    let folder = tempfile::tempdir().unwrap();
    let server = start(options(folder.path()));
    let mut client = connect(&server);
    client.submit(&scene("dam", DAM)).unwrap();
    client.wait("dam", 4, &mut Silent).unwrap();
    client.steer("dam", 3, FLAT).unwrap();
    drop((client, server));
    let server = start(options(folder.path()));
    let mut client = connect(&server);
    client.wait("dam", 6, &mut Silent).unwrap();
    assert!(fetched(&mut client, "dam", 6) == steered_locally()[6]);
}

#[test]
fn forces_by_the_host_act_frame_by_frame_while_others_go_on() {
    let folder = tempfile::tempdir().unwrap();
    let server = start(ServerOptions { workers: 1, ..options(folder.path()) });
    let mut client = connect(&server);
    let mut forced = scene("forced", &DAM.replace("frames = 6", "frames = 3"));
    forced.forced = true;
    client.submit(&forced).unwrap();
    client.submit(&scene("dam", DAM)).unwrap();
    // The only worker does not wait for the host.
    client.wait("dam", 6, &mut Silent).unwrap();
    let mut local = {
        use relievo_simulation::{Description, Making, Simulation, in_folder};
        let making = Making { format: "rlvfluid".into(), parts: 1, device: None };
        let description = Description::parse(&forced.description).unwrap();
        Simulation::begin(&Context::serial(), description, &in_folder(Path::new("")), making).unwrap()
    };
    for frame in 0..3u64 {
        let status = client.wait("forced", frame, &mut Silent).unwrap();
        assert_eq!((status.state, status.ready), (Activity::Forces, frame + 1));
        let push = [0.0, 20.0 + frame as f32, 0.0];
        let bytes: Vec<u8> = push.iter().flat_map(|value| value.to_le_bytes()).collect();
        let count = status.particles as usize;
        let part = |first: u64, count: usize| Force {
            scene: "forced".into(),
            frame,
            first,
            accelerations: bytes.repeat(count),
        };
        let error = client.call::<Status>("scene.force", &part(0, count + 1)).unwrap_err();
        assert_eq!(error.kind, ErrorKind::Invalid);
        let _: Status = client.call("scene.force", &part(0, 100)).unwrap();
        // Again, as after a broken connection.
        let _: Status = client.call("scene.force", &part(0, 100)).unwrap();
        let _: Status = client.call("scene.force", &part(100, count - 100)).unwrap();
        local.accelerate(&vec![push; count]).unwrap();
        local.advance(&Context::serial(), |_| Ok(())).unwrap();
    }
    assert_eq!(client.wait("forced", 3, &mut Silent).unwrap().state, Activity::Done);
    assert!(fetched(&mut client, "forced", 3) == local.encode(&Context::serial()).unwrap());
}
