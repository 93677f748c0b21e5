//! Simulations through the server beside local ones.

use std::collections::BTreeMap;

use relievo_client::{Activity, Address, Fetch, Packing, Particles, Values};
use relievo_core::progress::Silent;
use relievo_server::ServerOptions;

use super::{DAM, client_options, connect, fetched, local_frames, options, scene, start};

#[test]
fn frames_over_the_wire_are_those_of_a_local_run_to_the_bit() {
    let folder = tempfile::tempdir().unwrap();
    let server = start(options(folder.path()));
    let mut client = connect(&server);
    assert_eq!(client.welcome().user, "local");
    assert_eq!(client.welcome().kinds, ["fluid", "foam"]);
    client.submit(&scene("dam", DAM)).unwrap();
    let local = local_frames(DAM);
    for (frame, expected) in local.iter().enumerate() {
        let status = client.wait("dam", frame as u64, &mut Silent).unwrap();
        assert!(status.ready > frame as u64 && status.frames == 7);
        assert!(fetched(&mut client, "dam", frame as u64) == *expected, "frame {frame}");
    }
    assert_eq!(client.status("dam").unwrap().state, Activity::Done);
    // The same again changes nothing, and something else under the name is refused.
    client.submit(&scene("dam", DAM)).unwrap();
    assert!(client.submit(&scene("dam", &DAM.replace("0.05", "0.06"))).is_err());

    let last = relievo_particleio::read_frame(&relievo_core::Context::serial(), &local[6]).unwrap().particles;
    for packing in [Packing::None, Packing::Zstd, Packing::Lz4] {
        for differences in [false, true] {
            let fetch = Fetch { scene: "dam".into(), frame: 6, packing, differences, ..Fetch::default() };
            let frame = client.frame(&fetch, &mut Silent).unwrap();
            assert_eq!(frame.count, last.points.len() as u64);
            let floats = |values: &[f32]| values.iter().map(|value| value.to_bits()).collect::<Vec<_>>();
            let channel = |name: &str| match &frame.channels[name] {
                (_, Values::Floats(values)) => floats(values),
                (_, Values::Integers(values)) => values.clone(),
            };
            assert_eq!(channel("position"), floats(last.points.as_flattened()));
            assert_eq!(channel("velocity"), floats(&last.channel("velocity").unwrap().values));
            assert_eq!(Some(channel("number")), last.numbers);
        }
    }
    let fetch = Fetch { scene: "dam".into(), frame: 6, particles: Particles::Blind, ..Fetch::default() };
    let blind = client.frame(&fetch, &mut Silent).unwrap();
    let surface = client.frame(&Fetch { particles: Particles::Surface, ..fetch.clone() }, &mut Silent).unwrap();
    assert!(surface.count > 0 && surface.count < blind.count && blind.count <= last.points.len() as u64);
    let (1, Values::Floats(flags)) = &blind.channels["blind"] else { panic!("a channel of flags") };
    assert_eq!(flags.iter().filter(|flag| **flag == 0.0).count() as u64, surface.count);
    let alone = client.frame(&Fetch { channels: vec!["number".into()], ..fetch }, &mut Silent).unwrap();
    assert_eq!(alone.channels.keys().collect::<Vec<_>>(), ["number"]);
    assert!(client.frame(&Fetch { scene: "dam".into(), frame: 7, ..Fetch::default() }, &mut Silent).is_err());
}

#[test]
fn meshes_are_sent_once_by_their_content() {
    let folder = tempfile::tempdir().unwrap();
    let server = start(options(&folder.path().join("cache")));
    let mut client = connect(&server);
    let mesh = folder.path().join("box.obj");
    let cube = "v 0 0 0\nv .4 0 0\nv .4 .2 0\nv 0 .2 0\nv 0 0 .4\nv .4 0 .4\nv .4 .2 .4\nv 0 .2 .4\n\
                f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";
    std::fs::write(&mesh, cube).unwrap();
    let description = "frames = 1\n[fluid]\nspacing = 0.05\n[[fill]]\nmesh = \"../meshes/box.obj\"\n";
    let files = BTreeMap::from([("../meshes/box.obj".to_owned(), mesh)]);
    let mut submit = scene("filled", description);
    assert!(client.submit(&submit).is_err(), "a scene without its mesh");
    submit.files = client.send_files(&files, &mut Silent).unwrap();
    let sent = server_value(&mut client, "relievo_received_bytes_total");
    assert_eq!(client.send_files(&files, &mut Silent).unwrap(), submit.files);
    assert!(server_value(&mut client, "relievo_received_bytes_total") - sent < cube.len() as f64 / 2.0 + 300.0);
    client.submit(&submit).unwrap();
    let status = client.wait("filled", 1, &mut Silent).unwrap();
    assert!(status.particles > 50, "{status:?}");
}

fn server_value(client: &mut relievo_client::Client, name: &str) -> f64 {
    let stats: relievo_client::Stats = client.call("stats", &relievo_client::Nothing {}).unwrap();
    stats.values[name]
}

#[cfg(unix)]
#[test]
fn unix_sockets_and_restarts_serve_the_same_client() {
    let folder = tempfile::tempdir().unwrap();
    let listen = Address::Unix(folder.path().join("socket"));
    let begin = || start(ServerOptions { listen: listen.clone(), ..options(&folder.path().join("cache")) });
    let server = begin();
    let mut client = relievo_client::Client::connect(client_options(&listen)).unwrap();
    client.submit(&scene("dam", DAM)).unwrap();
    client.wait("dam", 2, &mut Silent).unwrap();
    drop(server);
    let _server = begin();
    // The client connects again, and the scene goes on.
    let status = client.wait("dam", 6, &mut Silent).unwrap();
    assert_eq!((status.state, status.ready), (Activity::Done, 7));
    assert!(fetched(&mut client, "dam", 6) == local_frames(DAM)[6]);
}

#[test]
fn scenes_pause_go_on_and_are_cancelled() {
    let folder = tempfile::tempdir().unwrap();
    let server = start(options(folder.path()));
    let mut client = connect(&server);
    let name = |scene: &str| relievo_client::SceneName { scene: scene.into() };
    client.submit(&scene("long", &DAM.replace("frames = 6", "frames = 5000"))).unwrap();
    client.wait("long", 1, &mut Silent).unwrap();
    let paused: relievo_client::Status = client.call("scene.pause", &name("long")).unwrap();
    assert_eq!(paused.state, Activity::Paused);
    // The frame that is computed is stored, and no other one after it.
    let later = client.wait("long", 4999, &mut Silent).unwrap_err();
    assert_eq!(later.kind, relievo_core::ErrorKind::Cancelled);
    let before = client.status("long").unwrap().ready;
    let resumed: relievo_client::Status = client.call("scene.resume", &name("long")).unwrap();
    assert_eq!(resumed.state, Activity::Running);
    assert!(client.wait("long", before + 1, &mut Silent).unwrap().seconds_left.is_some());
    let cancelled: relievo_client::Status = client.call("scene.cancel", &name("long")).unwrap();
    assert_eq!(cancelled.state, Activity::Cancelled);
    let _: relievo_client::Nothing = client.call("scene.remove", &name("long")).unwrap();
    assert_eq!(client.status("long").unwrap_err().kind, relievo_core::ErrorKind::NotFound);
}
