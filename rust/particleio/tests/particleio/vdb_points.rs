//! Points and grids of floats, beside OpenVDB's own library.

use std::path::Path;

use proptest::prelude::*;
use relievo_core::{Context, Result};
use relievo_openvdb::Packing;
use relievo_openvdb::peer::{LevelSet as Peer, Placing, Points, is_available, read_points, write_points};
use relievo_particleio::{Grid, Particles, read, read_grid, read_vdb_points, write};

use crate::particles;

/// All ways in which values are packed.
fn packings() -> impl Iterator<Item = Packing> {
    (0..8).map(|bits| Packing { zip: bits & 1 != 0, active: bits & 2 != 0, blosc: bits & 4 != 0 })
}

/// Particles in the order of their numbers, which are unique.
fn numbered(count: usize) -> Particles {
    Particles { numbers: Some((0..count as u32).collect()), ..particles(count) }
}

fn assert_near(a: &[f32], b: &[f32], tolerance: f32) {
    assert_eq!(a.len(), b.len());
    let worst = a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
    assert!(worst <= tolerance, "{worst}");
}

#[test]
fn particles_are_read_as_they_were_written() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.vdb");
    for (count, spacing) in [(0, Some(0.02)), (1, None), (3000, Some(0.02)), (3000, None)] {
        let whole = Particles { spacing, ..numbered(count) };
        write(&Context::serial(), &path, &whole).unwrap();
        let mut found = read(&Context::serial(), &path).unwrap();
        assert!(found.notes.is_empty(), "{:?}", found.notes);
        found.particles.sort();
        if count > 0 {
            assert_eq!((found.particles.time, found.particles.spacing), (Some(0.625), spacing));
            assert_eq!(found.particles.channels, whole.channels);
            assert_eq!(found.particles.numbers, whole.numbers);
        }
        assert_near(found.particles.points.as_flattened(), whole.points.as_flattened(), 2e-6);
    }
}

#[test]
fn openvdb_reads_the_points_that_are_written() {
    if !is_available() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.vdb");
    let whole = numbered(3000);
    write(&Context::serial(), &path, &whole).unwrap();
    let numbers: Vec<usize> = read_points(&path, "id").unwrap().iter().map(|number| *number as usize).collect();
    assert_eq!(numbers.len(), 3000);
    let expected = whole.subset(&numbers);
    assert_near(&read_points(&path, "P").unwrap(), expected.points.as_flattened(), 2e-6);
    for (theirs, ours) in [("v", "velocity"), ("age", "age"), ("weights", "weights"), ("st", "st")] {
        assert_eq!(read_points(&path, theirs).unwrap(), expected.channel(ours).unwrap().values, "{theirs}");
    }
    assert!(read_points(&path, "pscale").unwrap().iter().all(|radius| *radius == 0.01));
}

#[test]
fn points_that_openvdb_wrote_are_read() {
    if !is_available() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.vdb");
    let whole = numbered(20_000);
    let velocities = whole.velocities().unwrap();
    for packing in packings() {
        for is_fixed in [false, true] {
            let voxel = 0.04;
            let points = Points { places: &whole.points, velocities, voxel, is_fixed, packing };
            write_points(&path, &points).unwrap();
            let found = read(&Context::serial(), &path).unwrap();
            assert!(found.notes.is_empty(), "{:?}", found.notes);
            assert_eq!(found.particles.points.len(), 20_000);
            assert_eq!(found.particles.spacing, Some(0.5));
            // As the library has them, in the same order.
            let tolerance = 1e-4;
            assert_near(found.particles.points.as_flattened(), &read_points(&path, "P").unwrap(), tolerance);
            let moved = found.particles.velocities().unwrap().as_flattened();
            assert_near(moved, &read_points(&path, "v").unwrap(), 0.0);
        }
    }
}

fn grid(path: &Path, name: Option<&str>) -> Result<Grid> {
    read_grid(&std::fs::read(path).unwrap(), name, 1 << 30)
}

/// A level set of a box, of voxels as they are in the world of the mesh.
fn cuboid(low: [f32; 3], high: [f32; 3]) -> Peer {
    let points: Vec<[f32; 3]> =
        (0..8).map(|i| [0, 1, 2].map(|axis| if i >> axis & 1 == 0 { low[axis] } else { high[axis] })).collect();
    let quads = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let triangles: Vec<[u32; 3]> = quads.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).collect();
    Peer::of_mesh(&points, &triangles, 3.0).unwrap()
}

#[test]
fn grids_that_openvdb_wrote_are_read() {
    if !is_available() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.vdb");
    let peer = cuboid([-20.0, 3.0, 10.0], [150.0, 30.0, 40.5]);
    let voxels: Vec<[i32; 3]> =
        (-60..200).flat_map(|at| [[at, 10, 20], [0, at, 20], [3, at / 2, at], [at, at, at]]).collect();
    let expected = peer.values(&voxels).unwrap();
    for packing in packings() {
        for is_half in [false, true] {
            let writing = Placing { voxel: 0.5, origin: [1.0, 2.0, 3.0], packing, is_half, is_fog: false };
            peer.write(&path, &writing).unwrap();
            let grid = grid(&path, None).unwrap();
            assert!(grid.is_level_set && grid.name == "cloud");
            assert_eq!(grid.transform, [[0.5, 0.0, 0.0], [0.0, 0.5, 0.0], [0.0, 0.0, 0.5], [1.0, 2.0, 3.0]]);
            let found: Vec<f32> = voxels.iter().map(|voxel| grid.voxel(*voxel)).collect();
            assert_near(&found, &expected, if is_half { 2e-3 } else { 0.0 });
            let [low, high] = grid.bounds(0.0, true).unwrap();
            let ends = [low, high].concat().iter().map(|end| *end as f32).collect::<Vec<_>>();
            assert_near(&ends, &[-20.0, 3.0, 10.0, 150.0, 30.0, 40.5], 2e-3);
            assert!((grid.sample([0.25, 4.75, 20.5]) + 1.75).abs() < 2e-3);
        }
    }
    peer.write(&path, &Placing { voxel: 1.0, is_fog: true, ..Placing::default() }).unwrap();
    let fog = grid(&path, Some("cloud")).unwrap();
    assert!(!fog.is_level_set && fog.voxel([50, 15, 25]) == 1.0 && fog.voxel([50, 15, 60]) == 0.0);
    // It grows from 0 at the surface to 1 at three voxels within.
    let [low, high] = fog.bounds(0.5, false).unwrap();
    assert_near(&[low[0] as f32, high[1] as f32], &[-18.5, 28.5], 0.01);
    assert!(fog.bounds(2.0, false).is_none());
    let refused = grid(&path, Some("smoke")).err().unwrap();
    assert!(refused.to_string().contains("cloud"), "{refused}");
    let refused = read(&Context::serial(), &path).unwrap_err();
    assert!(refused.to_string().contains("no grid of points"), "{refused}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn no_change_of_bytes_harms(changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..8), form in 0..8usize) {
        if !is_available() {
            return Ok(());
        }
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.vdb");
        let whole = numbered(40);
        let packing = packings().nth(form).unwrap();
        let points = Points {
            places: &whole.points,
            velocities: whole.velocities().unwrap(),
            voxel: 0.5,
            is_fixed: form % 2 == 0,
            packing,
        };
        write_points(&path, &points).unwrap();
        let mut bytes = std::fs::read(&path).unwrap();
        for (at, byte) in &changes {
            let at = at.index(bytes.len());
            bytes[at] = *byte;
        }
        let _ = read_vdb_points(&bytes, 1 << 26);
        let ball = cuboid([-3.0; 3], [9.0; 3]);
        ball.write(&path, &Placing { voxel: 1.0, packing, ..Placing::default() }).unwrap();
        let mut bytes = std::fs::read(&path).unwrap();
        for (at, byte) in &changes {
            let at = at.index(bytes.len());
            bytes[at] = *byte;
        }
        if let Ok(grid) = read_grid(&bytes, None, 1 << 26) {
            let _ = (grid.bounds(0.0, true), grid.sample([1.5, 2.0, -7.0]));
        }
    }
}
