use relievo_particleio::{Particles, read_ply, write_ply};

use crate::particles;

#[test]
fn what_is_written_is_read_but_for_time_and_spacing() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.ply");
    for particles in [particles(100), particles(1), Particles { numbers: None, ..particles(3) }] {
        write_ply(&path, &particles).unwrap();
        let read = read_ply(&std::fs::read(&path).unwrap(), 1 << 20).unwrap();
        assert!(read.notes.is_empty());
        assert_eq!(read.particles, Particles { time: None, spacing: None, ..particles });
    }
}

#[test]
fn columns_may_be_in_any_order() {
    let text = "ply\nformat ascii 1.0\nelement vertex 2\nproperty float vz\nproperty int id\nproperty double y\n\
        property float x\nproperty float vx\nproperty float z\nproperty float vy\nproperty uchar phase\n\
        property float q_0\nproperty float q_1\nproperty float r_1\nend_header\n\
        3 8 -1 0 1 5 2 7 1 2 9\n6 1 -1.5 0.5 4 5 5 7 3 4 9\n";
    let particles = read_ply(text.as_bytes(), 1 << 20).unwrap().particles;
    assert_eq!(particles.points, [[0.0, -1.0, 5.0], [0.5, -1.5, 5.0]]);
    assert_eq!(particles.numbers.as_deref(), Some(&[8, 1][..]));
    assert_eq!(particles.velocities().unwrap(), [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]);
    assert_eq!(particles.channel("q").unwrap().values, [1.0, 2.0, 3.0, 4.0]);
    assert_eq!(particles.channel("phase").unwrap().values, [7.0, 7.0]);
    assert!(particles.channel("r_1").is_some() && particles.channels.len() == 4);
}
