use std::io::Write;

use relievo_particleio::{Channel, Particles, read_bgeo, write_bgeo};

use crate::particles;

fn bytes(particles: &Particles) -> Vec<u8> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.bgeo");
    write_bgeo(&path, particles).unwrap();
    std::fs::read(&path).unwrap()
}

#[test]
fn what_is_written_is_the_classic_form_byte_by_byte() {
    let velocity = Channel { name: "velocity".into(), width: 3, values: vec![1.0, 0.0, -2.0] };
    let particles = Particles {
        points: vec![[0.5, 1.0, 2.0]],
        time: Some(0.5),
        spacing: Some(0.5),
        numbers: Some(vec![258]),
        channels: vec![velocity],
    };
    let mut expected = b"BgeoV\0\0\0\x05".to_vec();
    // One point, no primitives and groups, two attributes of points, none of vertices and primitives, two of the whole.
    expected.extend([1, 0, 0, 0, 2, 0, 0, 2u32].iter().flat_map(|count| count.to_be_bytes()));
    expected.extend(b"\0\x02id\0\x01\0\0\0\x01\0\0\0\0");
    expected.extend(b"\0\x01v\0\x03\0\0\0\x05\0\0\0\0\0\0\0\0\0\0\0\0");
    expected.extend([0.5f32, 1.0, 2.0, 1.0].iter().flat_map(|value| value.to_be_bytes()));
    expected.extend(258u32.to_be_bytes());
    expected.extend([1.0f32, 0.0, -2.0].iter().flat_map(|value| value.to_be_bytes()));
    expected.extend(b"\0\x04time\0\x01\0\0\0\0\0\0\0\0");
    expected.extend(b"\0\x06pscale\0\x01\0\0\0\0\0\0\0\0");
    expected.extend([0.5f32, 0.25].iter().flat_map(|value| value.to_be_bytes()));
    expected.extend([0x00, 0xff]);
    assert_eq!(bytes(&particles), expected);
}

#[test]
fn what_is_written_is_read_packed_or_not() {
    for particles in [particles(100), particles(0), Particles { numbers: None, time: None, ..particles(3) }] {
        let plain = bytes(&particles);
        let mut packed = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
        packed.write_all(&plain).unwrap();
        for bytes in [plain, packed.finish().unwrap()] {
            let read = read_bgeo(&bytes, 1 << 20).unwrap();
            assert!(read.particles == particles && read.notes.is_empty());
        }
    }
}

#[test]
fn what_no_channel_can_hold_is_left_out_with_a_note() {
    let mut bytes = b"BgeoV\0\0\0\x05".to_vec();
    bytes.extend([1, 1, 0, 0, 3, 0, 0, 0u32].iter().flat_map(|count| count.to_be_bytes()));
    bytes.extend(b"\0\x04name\0\x01\0\0\0\x04\0\0\0\x02\0\x03one\0\0");
    bytes.extend(b"\0\x01m\0\x05\0\0\0\0");
    bytes.extend([0; 20]);
    bytes.extend(b"\0\x01k\0\x02\0\0\0\x01");
    bytes.extend([0; 8]);
    bytes.extend([1.0f32, 2.0, 3.0, 1.0].iter().flat_map(|value| value.to_be_bytes()));
    bytes.extend([0; 4 + 20]);
    bytes.extend([-3i32, 4].iter().flat_map(|value| value.to_be_bytes()));
    // A particle system of one particle, as Houdini writes it.
    bytes.extend(b"\0\0\x80\0\0\0\0\x01\0\0\0\xff");
    let read = read_bgeo(&bytes, 1 << 20).unwrap();
    assert_eq!(read.particles.points, [[1.0, 2.0, 3.0]]);
    let channels: Vec<_> = read.particles.channels.iter().map(|it| (it.name.as_str(), it.values.clone())).collect();
    assert_eq!(channels, [("k", vec![-3.0, 4.0])]);
    assert_eq!(read.notes.len(), 3, "{:?}", read.notes);
}

#[test]
fn other_forms_of_houdini_are_refused_by_name() {
    let refused = |bytes: &[u8], why: &str| {
        let error = read_bgeo(bytes, 1 << 20).unwrap_err().to_string();
        assert!(error.contains(why), "{error}");
    };
    refused(b"\x7fNSJb\x01\0\0", "binary JSON");
    refused(b"[\n\t\"fileversion\",\"18.5.351\",", "in JSON");
    refused(b"PGEOMETRY V5\nNPoints 8", "as text");
    refused(b"scf1\0\0\0\x20", "Blosc");
    refused(b"BgeoV\0\0\0\x09rest", "version 9");
    refused(b"nothing at all", "does not begin");
}

#[test]
fn what_the_form_cannot_hold_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.bgeo");
    let mut many = particles(2);
    many.numbers = Some(vec![1, u32::MAX]);
    assert!(write_bgeo(&path, &many).unwrap_err().to_string().contains("31 bits"));
    let mut twice = particles(2);
    twice.channels[1].name = "v".into();
    assert!(write_bgeo(&path, &twice).unwrap_err().to_string().contains("\"v\""));
    assert!(!path.exists());
}
