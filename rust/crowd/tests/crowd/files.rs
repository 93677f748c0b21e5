//! Files give back what was written, and refuse everything else.

use std::path::Path;

use relievo_core::progress::Silent;
use relievo_core::{Context, ErrorKind};
use relievo_crowd::{BuildSettings, CrowdModel, NONE, Reader};
use relievo_testing::Random;

use crate::arm::{built, swelling_arm};

fn written(model: &CrowdModel) -> Vec<u8> {
    let mut bytes = Vec::new();
    model.write(&mut bytes).unwrap();
    bytes
}

#[test]
fn a_file_gives_back_the_model() {
    let model = built(30, 16);
    let bytes = written(&model);
    let again = CrowdModel::from_bytes(&bytes, u64::MAX).unwrap();
    assert_eq!(again, model);
    assert_eq!(written(&again), bytes);
    let per_triangle = bytes.len() as f64 / f64::from(model.input_triangles);
    assert!(per_triangle < 48.0, "{per_triangle} bytes a triangle");
}

#[test]
fn distances_of_groups_are_in_files_of_the_newest_version() {
    let model = built(30, 16);
    assert_eq!((written(&model)[8], model.distances.len()), (4, model.groups.len()));
    let levels = model.level_distances();
    assert_eq!(levels.iter().map(|level| level.groups as usize).sum::<usize>(), model.groups.len());
    let made = model.clusters.iter().filter(|cluster| cluster.made_by != NONE).map(|cluster| u64::from(cluster.count));
    assert_eq!(levels.iter().map(|level| level.triangles).sum::<u64>(), made.sum::<u64>());
    for level in &levels {
        assert!(level.chosen.median <= level.chosen.largest && level.chosen.largest <= level.all.largest, "{level:?}");
        assert!(level.exceeding <= level.groups && (level.exceeding > 0) == (level.all != level.chosen), "{level:?}");
    }
    assert!(levels.iter().any(|level| level.exceeding > 0), "{levels:?}");

    let older = CrowdModel { distances: Vec::new(), ..model.clone() };
    let bytes = written(&older);
    assert_eq!(bytes[8], 3);
    let read = CrowdModel::from_bytes(&bytes, u64::MAX).unwrap();
    assert!(read == older && read.level_distances().is_empty());
    // Readers refuse negative distances, larger ones over chosen poses than over all, too few of them, and impossible depths.
    let wrong = |change: &dyn Fn(&mut CrowdModel)| {
        let mut wrong = model.clone();
        change(&mut wrong);
        assert!(wrong.check().is_err());
    };
    wrong(&|model| model.distances[0].all = -1.0);
    wrong(&|model| model.distances[0].chosen = 2.0 * model.distances[0].all + 1.0);
    wrong(&|model| model.distances.truncate(1));
    wrong(&|model| model.groups.iter_mut().for_each(|group| group.depth = u32::MAX));
}

#[test]
fn clusters_are_read_one_by_one() {
    let model = built(30, 16);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("arm.rcrowd");
    model.save(&path).unwrap();
    let mut reader = Reader::open(&Context::serial(), &path).unwrap();
    assert_eq!(reader.model().groups, model.groups);
    for cluster in [0, 5, model.clusters.len() as u32 - 1] {
        let (triangles, materials) = reader.cluster(cluster).unwrap();
        assert_eq!(triangles, model.triangles(cluster));
        assert_eq!(materials.len(), triangles.len());
    }
    assert!(reader.cluster(model.clusters.len() as u32).is_err());
    assert_eq!(CrowdModel::load(&Context::serial(), &path).unwrap(), model);
}

#[test]
fn every_truncation_and_every_wrong_bit_is_an_error_or_harmless() {
    let model = built(8, 8);
    let bytes = written(&model);
    for length in 0..bytes.len() {
        assert!(CrowdModel::from_bytes(&bytes[..length], 1 << 30).is_err(), "cut at {length}");
    }
    let mut random = Random(5);
    for _ in 0..4000 {
        let mut wrong = bytes.clone();
        let bit = random.below(8 * bytes.len());
        wrong[bit / 8] ^= 1 << (bit % 8);
        if let Ok(read) = CrowdModel::from_bytes(&wrong, 1 << 30) {
            assert_eq!(read, model, "bit {bit}");
        }
    }
    let mut long = bytes.clone();
    long.push(0);
    assert!(CrowdModel::from_bytes(&long, 1 << 30).is_err());
}

#[test]
fn counts_beyond_the_file_are_refused_before_memory_is_taken() {
    let model = built(8, 8);
    let bytes = written(&model);
    for count in 0..9 {
        let mut wrong = bytes.clone();
        let at = 12 + 4 * count;
        wrong[at..at + 4].copy_from_slice(&0x7fff_ffffu32.to_le_bytes());
        let sum = crc32(&wrong[..48]);
        wrong[48..52].copy_from_slice(&sum.to_le_bytes());
        assert!(CrowdModel::from_bytes(&wrong, u64::MAX).is_err(), "count {count}");
    }
    let error = CrowdModel::from_bytes(&bytes, 1000).unwrap_err();
    assert!(matches!(error.kind, ErrorKind::Memory | ErrorKind::Invalid), "{error}");
    let mut later = bytes;
    later[8] = 9;
    assert_eq!(CrowdModel::from_bytes(&later, u64::MAX).unwrap_err().kind, ErrorKind::Unsupported);
}

/// What a golden file of a version has.
struct Golden {
    version: u32,
    /// Rings and sides of its arm; the newer ones swell.
    size: [usize; 2],
    clusters: usize,
    groups: usize,
    /// Triangles of the cuts at errors of 0, 0.3 and infinity.
    triangles: [u64; 3],
    largest_error: f32,
}

const GOLDEN: [Golden; 4] = [
    Golden { version: 1, size: [8, 8], clusters: 11, groups: 5, triangles: [128, 64, 4], largest_error: 1.775_836_1 },
    Golden { version: 2, size: [6, 6], clusters: 74, groups: 17, triangles: [72, 30, 4], largest_error: 0.698_233_07 },
    Golden { version: 3, size: [6, 6], clusters: 74, groups: 17, triangles: [72, 30, 4], largest_error: 0.698_233_07 },
    Golden { version: 4, size: [8, 8], clusters: 140, groups: 22, triangles: [128, 34, 4], largest_error: 0.573_396 },
];

#[test]
fn models_of_every_version_are_read() {
    let settings = BuildSettings { cluster_triangles: 8, pose_rate: 4.0, ..BuildSettings::default() };
    for Golden { version, size: [rings, sides], clusters, groups, triangles, largest_error } in GOLDEN {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("../../tests/golden/model-{version}.rcrowd"));
        let swelling = || {
            let arm = swelling_arm(rings, sides);
            let made = CrowdModel::build(&Context::serial(), &arm, &[0], &settings, &mut Silent).unwrap();
            // Older versions lack distances of groups, and the oldest say not where vertices go.
            let distances = if version < 4 { Vec::new() } else { made.distances.clone() };
            let collapses = if version < 3 { Vec::new() } else { made.collapses.clone() };
            CrowdModel { distances, collapses, ..made }
        };
        let expected = if version == 1 { built(rings, sides) } else { swelling() };
        if std::env::var_os("RELIEVO_WRITE_GOLDEN").is_some() && version > 1 {
            expected.save(&path).unwrap();
        }
        assert_eq!(u32::from(std::fs::read(&path).unwrap()[8]), version);
        let found = CrowdModel::load(&Context::serial(), &path).unwrap();
        assert_eq!(found.character.bones, expected.character.bones);
        assert_eq!(
            (&found.character.points, &found.character.attributes, &found.character.morphs),
            (&expected.character.points, &expected.character.attributes, &expected.character.morphs)
        );
        assert_eq!(found.clips.len(), 1);
        let clip = |model: &CrowdModel| (model.clips[0].name.clone(), model.clips[0].poses.len());
        assert_eq!(clip(&found), clip(&expected));
        let input = |model: &CrowdModel| {
            let mut triangles = model.character.triangles[..model.input_triangles as usize].to_vec();
            triangles.sort_unstable();
            triangles
        };
        assert_eq!(input(&found), input(&expected));
        // The hierarchy is that of the program that wrote the file.
        let cuts = [0.0, 0.3, f32::INFINITY].map(|error| found.triangle_count(&found.cut(error)));
        let error = found.groups.iter().map(|group| group.error).fold(0.0, f32::max);
        println!("{version}: {} clusters, {} groups, {cuts:?}, {error}", found.clusters.len(), found.groups.len());
        assert_eq!((found.clusters.len(), found.groups.len(), cuts), (clusters, groups, triangles), "{version}");
        assert!((error - largest_error).abs() < 1e-6, "version {version}: {error}");
        assert_eq!(found.has_collapses(), version > 2);
        assert_eq!(found.distances.len(), if version > 3 { groups } else { 0 });
        // Half a second after the beginning the morph target has two thirds of its weight.
        let weights: Vec<&[f32]> = found.clips[0].poses.iter().map(|pose| pose.weights.as_slice()).collect();
        match version {
            1 => assert!(weights.iter().all(|weights| weights.is_empty())),
            _ => assert!(weights.len() == 4 && (weights[2][0] - 2.0 / 3.0).abs() < 1e-6, "{weights:?}"),
        }
    }
}

/// Returns the sum of the head, bit by bit.
fn crc32(bytes: &[u8]) -> u32 {
    let step = |sum: u32, byte: &u8| {
        (0..8).fold(sum ^ u32::from(*byte), |sum, _| if sum & 1 == 1 { sum >> 1 ^ 0xedb8_8320 } else { sum >> 1 })
    };
    !bytes.iter().fold(u32::MAX, step)
}
