//! Fluids that a graphics device simulates.

use relievo_client::{FrameInfo, FrameName, Nothing, SceneName};
use relievo_core::Context;
use relievo_core::progress::Silent;
use relievo_gpu::Device;
use relievo_server::{FluidKind, Server};

use super::{DAM, connect, fetched, local_frames, options, scene, start};

#[test]
fn a_device_makes_the_frames_of_the_processor_but_for_rounding() {
    let Some(device) = relievo_testing::device() else { return };
    let folder = tempfile::tempdir().unwrap();
    let key = |client: &mut relievo_client::Client| -> String {
        let name = FrameName { scene: "dam".into(), frame: 6 };
        client.call::<FrameInfo>("frame.info", &name).unwrap().key
    };
    let with_device = |device: &Device| {
        let kind = FluidKind { device: Some(device.clone()) };
        Server::start(options(folder.path()), vec![Box::new(kind)]).unwrap()
    };
    let server = with_device(&device);
    let mut client = connect(&server);
    client.submit(&scene("dam", DAM)).unwrap();
    client.wait("dam", 6, &mut Silent).unwrap();
    let context = Context::serial();
    let particles = |frame: &[u8]| relievo_particleio::read_frame(&context, frame).unwrap().particles;
    let by_number = |frame: &[u8]| {
        let mut particles = particles(frame);
        particles.sort();
        particles.points
    };
    let (theirs, ours) = (by_number(&fetched(&mut client, "dam", 6)), by_number(&local_frames(DAM)[6]));
    assert_eq!(theirs.len(), ours.len());
    let far = |(a, b): (&[f32; 3], &[f32; 3])| (0..3).map(|axis| (a[axis] - b[axis]).abs()).fold(0.0, f32::max);
    let most = theirs.iter().zip(&ours).map(far).fold(0.0, f32::max);
    assert!(most < 0.01, "{most} m apart");
    let on_device = key(&mut client);
    // A device has no sinks. The scene fails and says so; the server goes on.
    let sink = format!("{DAM}[[sink]]\noutside = {{ low = [-1, -1, -1], high = [2, 1, 1] }}\n");
    let refused = client.submit(&scene("sink", &sink)).and_then(|_| client.wait("sink", 6, &mut Silent));
    assert!(refused.unwrap_err().to_string().contains("emitters and sinks"));
    client.submit(&scene("long", &DAM.replace("frames = 6", "frames = 500"))).unwrap();
    client.wait("long", 2, &mut Silent).unwrap();
    let second = fetched(&mut client, "long", 2);
    // On the processor a scene of the device does not go on, and what it has stays. The processor's frames have keys of
    // their own.
    drop((client, server));
    let server = start(options(folder.path()));
    let mut client = connect(&server);
    let stopped = client.wait("long", 499, &mut Silent).unwrap_err();
    assert!(stopped.to_string().contains("same device"), "{stopped}");
    assert!(fetched(&mut client, "long", 2) == second);
    let name = |scene: &str| SceneName { scene: scene.into() };
    let _: Nothing = client.call("scene.remove", &name("dam")).unwrap();
    client.submit(&scene("dam", DAM)).unwrap();
    client.wait("dam", 6, &mut Silent).unwrap();
    assert_ne!(key(&mut client), on_device);
    assert!(fetched(&mut client, "dam", 6) == local_frames(DAM)[6]);
    drop((client, server));
    // On the device it goes on.
    let server = with_device(&device);
    let mut client = connect(&server);
    let ready = client.status("long").unwrap().ready;
    assert!(client.wait("long", ready + 1, &mut Silent).is_ok() && fetched(&mut client, "long", 2) == second);
}
