use proptest::prelude::*;
use relievo_core::{Context, ContextOptions};
use relievo_particleio::{Frame, FrameStream, Particles, VERSION, read_frame, write_frame};

use crate::particles;

fn bytes(context: &Context, particles: &Particles, state: Option<&[u8]>) -> Vec<u8> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("0001.rlvfluid");
    write_frame(context, &path, particles, state).unwrap();
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    std::fs::read(&path).unwrap()
}

#[test]
fn a_frame_is_read_as_it_was_written_for_any_number_of_threads() {
    let threads = |threads| Context::new(&ContextOptions { threads, memory_limit: 0 }).unwrap();
    // Three chunks, the last of which is not full.
    let state: Vec<u8> = (0..200_000u32).map(|at| (at * at) as u8).collect();
    for (particles, state) in [
        (particles(150_000), Some(state.as_slice())),
        (particles(7), None),
        (Particles::default(), Some(&[][..])),
        (Particles { time: None, spacing: None, numbers: None, ..particles(65_536) }, None),
    ] {
        let written = bytes(&threads(1), &particles, state);
        assert!(written == bytes(&threads(5), &particles, state));
        let level = threads(1).level().name().to_owned();
        let expected = Frame { particles, level, state: state.map(<[u8]>::to_vec) };
        for threads in [threads(1), threads(3)] {
            assert!(read_frame(&threads, &written).unwrap() == expected);
        }
    }
}

#[test]
fn a_stream_has_the_particles_chunk_by_chunk_and_no_channel_that_is_not_named() {
    let (folder, context) = (tempfile::tempdir().unwrap(), Context::serial());
    let path = folder.path().join("0001.rlvfluid");
    let all = particles(150_000);
    write_frame(&context, &path, &all, Some(b"state")).unwrap();
    let mut stream = FrameStream::open(&context, &path).unwrap();
    assert_eq!((stream.count(), stream.chunks(), stream.spacing()), (150_000, 3, Some(0.02)));
    // In any order.
    for (chunk, range) in [(2, 131_072..150_000), (0, 0..65_536), (1, 65_536..131_072)] {
        let expected = all.subset(&range.collect::<Vec<_>>());
        let found = stream.read(chunk, &["velocity", "missing"]).unwrap();
        assert!(found.points == expected.points && found.numbers == expected.numbers);
        assert!(found.channels.len() == 1 && found.velocities() == expected.velocities());
    }
    assert!(stream.read(3, &[]).is_err());
    write_frame(&context, &path, &Particles::default(), None).unwrap();
    assert_eq!(FrameStream::open(&context, &path).unwrap().chunks(), 0);
    let little = Context::new(&ContextOptions { threads: 1, memory_limit: 64 }).unwrap();
    assert!(FrameStream::open(&little, &path).is_err());
}

#[test]
fn a_stream_of_damaged_bytes_is_an_error_never_wrong_data() {
    let (folder, context) = (tempfile::tempdir().unwrap(), Context::serial());
    let path = folder.path().join("0001.rlvfluid");
    let all = particles(40);
    let good = bytes(&context, &all, None);
    let stream = |bytes: &[u8]| {
        std::fs::write(&path, bytes).unwrap();
        FrameStream::open(&context, &path)?.read(0, &["velocity", "age", "weights", "st"])
    };
    assert!(stream(&good).unwrap() == all);
    for at in 0..good.len() {
        let mut bytes = good.clone();
        bytes[at] ^= 0x41;
        assert!(stream(&bytes).is_err(), "byte {at}");
        assert!(stream(&good[..at]).is_err(), "cut at {at}");
    }
}

#[test]
fn a_frame_begins_with_its_signature_and_version() {
    let written = bytes(&Context::serial(), &particles(3), None);
    assert_eq!(&written[..12], b"RLVFLUID\x01\0\0\0");
    assert_eq!(VERSION, 1);
    let sums = [&written[40..44], &crc32fast::hash(&written[..40]).to_le_bytes()];
    assert_eq!(sums[0], sums[1]);
}

#[test]
fn frames_of_every_version_are_read() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/golden/particles-1.rlvfluid");
    let particles = read_frame(&Context::serial(), &std::fs::read(path).unwrap()).unwrap().particles;
    assert_eq!(particles.points, [[0.0, 1.0, 0.0], [0.0, 0.0, 0.0], [1.0, 0.0, 0.0]]);
    assert_eq!(particles.numbers.as_deref(), Some(&[1, 4, 7][..]));
    assert_eq!(particles.velocities().unwrap(), [[1.0, 2.0, 3.0]; 3]);
    assert_eq!(particles.channel("heat").unwrap().values, [0.125, 0.5, 0.25]);
    assert_eq!((particles.time, particles.spacing), (None, None));
}

#[test]
fn every_damaged_byte_and_every_cut_is_an_error_never_wrong_data() {
    let context = Context::serial();
    let good = bytes(&context, &particles(40), Some(b"state"));
    for at in 0..good.len() {
        let mut bytes = good.clone();
        bytes[at] ^= 0x41;
        assert!(read_frame(&context, &bytes).is_err(), "byte {at}");
        assert!(read_frame(&context, &good[..at]).is_err(), "cut at {at}");
    }
    assert!(read_frame(&context, &[good.as_slice(), b"x"].concat()).is_err());
}

#[test]
fn a_newer_version_is_refused_by_its_number() {
    let mut bytes = bytes(&Context::serial(), &particles(3), None);
    bytes[8] = 2;
    let error = read_frame(&Context::serial(), &bytes).unwrap_err().to_string();
    assert!(error.contains("version 2") && error.contains("newer"), "{error}");
}

/// A frame whose index is `index`, with sums that are right and no chunks.
fn with_index(index: &[u8], length: u64) -> Vec<u8> {
    let packed = zstd::bulk::compress(index, 1).unwrap();
    let mut bytes = b"RLVFLUID\x01\0\0\0".to_vec();
    bytes.extend(crc32fast::hash(&packed).to_le_bytes());
    bytes.extend([packed.len() as u64, length, 0].iter().flat_map(|length| length.to_le_bytes()));
    bytes.extend(crc32fast::hash(&bytes).to_le_bytes());
    bytes.extend(packed);
    bytes
}

#[test]
fn counts_that_claim_the_world_allocate_nothing() {
    let context = Context::new(&ContextOptions { threads: 1, memory_limit: 1 << 20 }).unwrap();
    let index = |count: u32, width: u8, items: u64| {
        let mut index = 0.0f64.to_le_bytes().to_vec();
        index.extend(0.02f32.to_le_bytes());
        index.push(0);
        index.extend(count.to_le_bytes());
        index.extend([1, 0, 0, 0, 0, 0, width]);
        index.extend(items.to_le_bytes());
        index
    };
    for (count, width, items) in
        [(u32::MAX, 3, u64::MAX), (5, 3, u64::MAX), (1 << 30, 3, 1 << 30), (0, 200, 0), (1, 3, 1)]
    {
        let index = index(count, width, items);
        assert!(read_frame(&context, &with_index(&index, index.len() as u64)).is_err());
    }
    let none = index(0, 3, 0);
    assert!(read_frame(&context, &with_index(&none, none.len() as u64)).is_ok());
    for length in [none.len() as u64 + 1, 1 << 25, u64::MAX] {
        assert!(read_frame(&context, &with_index(&none, length)).is_err());
    }
}

#[test]
fn what_is_not_sound_is_not_written() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.rlvfluid");
    let refused = |spoil: fn(&mut Particles), why: &str| {
        let mut particles = particles(5);
        spoil(&mut particles);
        let error = write_frame(&Context::serial(), &path, &particles, None).unwrap_err().to_string();
        assert!(error.contains(why) && error.contains("a.rlvfluid"), "{error}");
    };
    refused(|it| it.points[3][1] = f32::NAN, "particle 3");
    refused(|it| it.channels[0].values[4] = f32::INFINITY, "\"velocity\": particle 1");
    refused(|it| it.channels[1].name = "velocity".into(), "two channels");
    refused(|it| it.channels[1].width = 5, "1 to 4");
    refused(|it| it.channels[1].name.clear(), "name");
    refused(|it| it.channels[2].values.truncate(7), "each of 5");
    refused(|it| it.numbers.as_mut().unwrap().truncate(4), "4 numbers");
    refused(|it| it.spacing = Some(-1.0), "apart");
    refused(|it| it.time = Some(f64::NAN), "time");
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
}

#[test]
fn particles_are_put_in_the_order_of_their_numbers() {
    let mut sorted = particles(50);
    let before = sorted.clone();
    sorted.sort();
    let (numbers, old) = (sorted.numbers.clone().unwrap(), before.numbers.clone().unwrap());
    assert!(numbers.is_sorted() && !old.is_sorted());
    for (at, number) in numbers.iter().enumerate() {
        let from = old.iter().position(|other| other == number).unwrap();
        assert_eq!(sorted.points[at], before.points[from]);
        assert_eq!(sorted.velocities().unwrap()[at], before.velocities().unwrap()[from]);
        assert_eq!(sorted.channels[2].values[4 * at..4 * at + 4], before.channels[2].values[4 * from..4 * from + 4]);
    }
}

proptest! {
    #[test]
    fn any_floats_and_states_are_kept_to_the_bit(
        values in prop::collection::vec(prop::num::f32::NORMAL | prop::num::f32::SUBNORMAL | prop::num::f32::ZERO, 0..60),
        state in prop::collection::vec(any::<u8>(), 0..300),
    ) {
        let points: Vec<[f32; 3]> = values.as_chunks().0.to_vec();
        let particles = Particles { points, ..Particles::default() };
        let context = Context::serial();
        let read = read_frame(&context, &bytes(&context, &particles, Some(&state))).unwrap();
        let bits = |particles: &Particles| particles.points.as_flattened().iter().map(|it| it.to_bits()).collect::<Vec<_>>();
        prop_assert_eq!(bits(&read.particles), bits(&particles));
        prop_assert_eq!(read.state.unwrap(), state);
    }
}
