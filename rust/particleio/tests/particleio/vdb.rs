//! Level sets that are written, as OpenVDB's own library reads them.

use relievo_core::Context;
use relievo_openvdb::peer::{LevelSet as Peer, is_available};
use relievo_particleio::{LevelSet, write_vdb};

/// Voxels of a ball, and its middle, in voxels.
const RADIUS: f32 = 90.0;
const MIDDLE: [f32; 3] = [-20.0, 10.5, 300.25];

fn distance(voxel: [i32; 3], size: f32) -> f32 {
    let d = [0, 1, 2].map(|axis| voxel[axis] as f32 - MIDDLE[axis]);
    (d.iter().map(|d| d * d).sum::<f32>().sqrt() - RADIUS) * size
}

/// The level set of the ball, of voxels of a size.
fn ball(size: f32) -> LevelSet {
    let band = 3.0 * size;
    let mut level_set = LevelSet { voxel: size, band, blocks: Vec::new() };
    let range = |axis: usize| (MIDDLE[axis] - RADIUS) as i32 / 8 - 2..(MIDDLE[axis] + RADIUS) as i32 / 8 + 2;
    for origin in range(0).flat_map(|x| range(1).flat_map(move |y| range(2).map(move |z| [x * 8, y * 8, z * 8]))) {
        let value = |at: usize| {
            let voxel = [at / 64, at / 8 % 8, at % 8];
            distance([0, 1, 2].map(|axis| origin[axis] + voxel[axis] as i32), size).clamp(-band, band)
        };
        let values: Vec<f32> = (0..512).map(value).collect();
        if values.iter().any(|value| value.abs() < band) {
            level_set.blocks.push((origin, values.try_into().unwrap()));
        }
    }
    level_set
}

fn is_inside(place: [f64; 3]) -> bool {
    let d = [0, 1, 2].map(|axis| place[axis] as f32 - MIDDLE[axis]);
    d.iter().map(|d| d * d).sum::<f32>() < RADIUS * RADIUS
}

#[test]
fn openvdb_reads_what_is_written() {
    if !is_available() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("ball.vdb");
    let level_set = ball(0.02);
    write_vdb(&Context::serial(), &path, &level_set, &is_inside).unwrap();
    let read = Peer::read(&path).unwrap();
    let (voxel, background, voxels, is_level_set) = read.facts().unwrap();
    let active = level_set.blocks.iter().flat_map(|(_, values)| values.iter()).filter(|it| it.abs() < level_set.band);
    assert_eq!((voxels, is_level_set), (active.count() as u64, true));
    assert_eq!((voxel, background), (f64::from(level_set.voxel), f64::from(level_set.band)));
    // Along lines through the ball and beyond: the band, what is inside of it, and tiles on both sides.
    let lines = (-400..700).flat_map(|at| [[-20, 10, at], [at, 10, 300], [-20 + at / 2, at, 300 - at]]);
    let voxels: Vec<[i32; 3]> = lines.collect();
    let mut seen = [0; 3];
    for (voxel, value) in voxels.iter().zip(read.values(&voxels).unwrap()) {
        let expected = distance(*voxel, 0.02).clamp(-level_set.band, level_set.band);
        assert!((value - expected).abs() < 1e-6, "{voxel:?}: {value} for {expected}");
        seen[(1.0 + value.signum() * f32::from(value.abs() == level_set.band)) as usize] += 1;
    }
    assert!(seen.iter().all(|count| *count > 10), "{seen:?}");
}

#[test]
fn nothing_is_a_grid_too_and_what_cannot_be_is_refused() {
    if !is_available() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("none.vdb");
    let write = |level_set: &LevelSet| write_vdb(&Context::serial(), &path, level_set, &|_| false);
    let none = LevelSet { voxel: 0.1, band: 0.3, blocks: Vec::new() };
    write(&none).unwrap();
    let read = Peer::read(&path).unwrap();
    assert_eq!((read.facts().unwrap().2, read.values(&[[5, 5, 5]]).unwrap()[0]), (0, 0.3));
    std::fs::remove_file(&path).unwrap();
    let block = |origin: [i32; 3]| (origin, Box::new([0.1; 512]));
    for blocks in [
        vec![block([8, 0, 0]), block([0, 0, 0])],
        vec![block([0, 0, 0]), block([0, 0, 0])],
        vec![block([0, 4, 0])],
        vec![block([1 << 30, 0, 0])],
        vec![([0; 3], Box::new([f32::NAN; 512]))],
    ] {
        assert!(write(&LevelSet { blocks, ..none.clone() }).is_err());
    }
    assert!(
        write(&LevelSet { voxel: 0.0, ..none.clone() }).is_err()
            && write(&LevelSet { band: f32::NAN, ..none }).is_err()
    );
    assert!(!path.exists());
}
