//! Grids of every kind through files, and the list of a file beside the facts of its grids.

use relievo_core::progress::Silent;
use relievo_core::{Context, ErrorKind};
use relievo_openvdb::peer::{is_available, write_instances};
use relievo_openvdb::{Class, Entry, Frustum, Grid, GridInfo, Kind, Packing, Survey, Transform, Writing, read, write};

use crate::shapes::{block, level_set};

const LIMIT: u64 = 1 << 28;

fn packings() -> impl Iterator<Item = Packing> {
    (0..8).map(|bits| Packing { zip: bits & 1 != 0, active: bits & 2 != 0, blosc: bits & 4 != 0 })
}

/// What a file and its grid must agree on; OpenVDB adds metadata when it writes.
fn facts(info: &GridInfo) -> impl PartialEq + std::fmt::Debug + use<> {
    let GridInfo { name, kind, class, is_half, active_voxels, leaf_count, bounds, transform, .. } = info.clone();
    (name, kind, class, is_half, active_voxels, leaf_count, bounds, transform.rows, transform.is_linear)
}

#[test]
fn every_kind_is_written_and_read_in_every_packing() {
    if !is_available() {
        return;
    }
    let (context, folder) = (Context::serial(), tempfile::tempdir().unwrap());
    let path = folder.path().join("a.vdb");
    for kind in Kind::all() {
        let mut grid = Grid::new(kind, [0.0; 3], 0.25).unwrap();
        grid.set_name("values").unwrap();
        let whole = block(kind, [-5, 100, 7], [20, 9, 13]);
        grid.set_block(&context, &whole, 0.0).unwrap();
        let axes = [[0.1, 0.0, 0.02], [0.0, 0.2, 0.0], [0.0, 0.05, 0.3], [1.0, -2.0, 3.0]];
        grid.set_transform(&Transform::affine(axes)).unwrap();
        let before = grid.info().unwrap();
        assert!(before.active_voxels > 1000 && before.kind == Some(kind), "{before:?}");
        for packing in packings() {
            for is_stream in [false, true] {
                let writing = Writing { packing, is_stream, metadata: Vec::new() };
                write(&context, &path, &[&grid], &writing, &mut Silent).unwrap();
                let survey = Survey::of_file(&path, LIMIT).unwrap();
                assert_eq!(survey.is_stream, is_stream);
                assert_eq!(facts(&survey.grids[0]), facts(&before));
                let found = read(&context, &path, Some("values"), None, &mut Silent).unwrap();
                assert_eq!(facts(&found.info().unwrap()), facts(&before));
                let (bound, used) = (survey.grids[0].memory_bytes, found.info().unwrap().memory_bytes);
                assert!(bound >= used, "{bound} {used} {kind:?}");
                assert_eq!(found.block(&context, whole.low, whole.size).unwrap(), whole, "{kind:?} {packing:?}");
            }
        }
        let middle = [[0, 1, 2].map(|axis| f64::from(whole.low[axis]) + 3.0)];
        let world = middle.map(|at| before.transform.place(at).unwrap());
        let voxel = [whole.low.map(|at| at + 3)];
        assert_eq!(grid.sample(&world, false).unwrap(), grid.voxels(&voxel).unwrap());
    }
}

#[test]
fn halves_metadata_frustums_and_instances_are_read() {
    if !is_available() {
        return;
    }
    let (context, folder) = (Context::serial(), tempfile::tempdir().unwrap());
    let path = folder.path().join("a.vdb");
    let mut grid = level_set([-1.0, 0.0, 0.0], [1.0, 2.0, 0.5], 0.05);
    grid.set_half(true).unwrap();
    let entry =
        |name: &str, kind: &str, value: &str| Entry { name: name.into(), kind: kind.into(), value: value.into() };
    let own = [entry("artist", "string", "nobody"), entry("frame", "int32", "12"), entry("scale", "double", "0.5")];
    own.iter().for_each(|entry| grid.set_metadata(entry).unwrap());
    assert!(grid.set_metadata(&entry("frame", "int32", "many")).is_err());
    let writing = Writing { metadata: vec![entry("shot", "string", "7b")], ..Writing::default() };
    write(&context, &path, &[&grid], &writing, &mut Silent).unwrap();
    let survey = Survey::of_file(&path, LIMIT).unwrap();
    assert!(survey.metadata.contains(&writing.metadata[0]), "{:?}", survey.metadata);
    assert!(own.iter().all(|entry| survey.grids[0].metadata.contains(entry)), "{:?}", survey.grids[0].metadata);
    let found = read(&context, &path, None, None, &mut Silent).unwrap();
    let info = found.info().unwrap();
    assert!(own.iter().all(|entry| info.metadata.contains(entry)) && info.is_half && info.class == Class::LevelSet);
    let at = [[0.5, 0.02, 0.3]];
    let difference = found.sample(&at, true).unwrap()[0] - grid.sample(&at, true).unwrap()[0];
    assert!(difference.abs() < 1e-3, "{difference}");

    // A frustum keeps its values and maps voxels to a pyramid.
    let mut camera = Grid::new(Kind::Float, [0.0; 3], 1.0).unwrap();
    camera.set_block(&context, &block(Kind::Float, [0; 3], [16; 3]), 0.0).unwrap();
    let frustum = Frustum { voxels: [[0.0; 3], [15.0; 3]], taper: 0.5, depth: 2.0 };
    camera.set_frustum(&frustum, &Transform::uniform(3.0)).unwrap();
    write(&context, &path, &[&camera], &Writing::default(), &mut Silent).unwrap();
    let survey = Survey::of_file(&path, LIMIT).unwrap();
    assert_eq!(facts(&survey.grids[0]), facts(&camera.info().unwrap()));
    assert!(!survey.grids[0].transform.is_linear);
    let found = read(&context, &path, None, None, &mut Silent).unwrap();
    assert_eq!(found.block(&context, [0; 3], [16; 3]).unwrap(), camera.block(&context, [0; 3], [16; 3]).unwrap());
    // The far plane is twice as wide as the near one.
    let values = [-1.4, 1.4].map(|x| found.sample(&[[x, 0.0, 0.01]], false).unwrap()[0]);
    assert!(values.iter().all(|value| value.is_finite()));

    write_instances(&path, &grid).unwrap();
    let survey = Survey::of_file(&path, LIMIT).unwrap();
    assert_eq!(survey.grids.len(), 2);
    let shared = survey.grids.iter().find(|grid| grid.instance_of.is_some()).unwrap();
    let found = read(&context, &path, Some(&shared.name), None, &mut Silent).unwrap();
    assert_eq!(found.info().unwrap().active_voxels, grid.info().unwrap().active_voxels);
    let shift = if shared.name == "second" { 100.0 } else { 0.0 };
    let value = found.sample(&[[shift, 1.0, 0.02]], true).unwrap()[0];
    assert!((value + 0.02).abs() < 1e-3, "{value}");
}

#[test]
fn a_box_of_a_grid_is_read_alone() {
    if !is_available() {
        return;
    }
    let (context, folder) = (Context::serial(), tempfile::tempdir().unwrap());
    let path = folder.path().join("a.vdb");
    let mut grids = Vec::new();
    for (name, high) in [("large", 4.0), ("small", 1.0)] {
        let mut grid = level_set([0.0; 3], [high; 3], 0.05);
        grid.set_name(name).unwrap();
        grids.push(grid);
    }
    let list: Vec<&Grid> = grids.iter().collect();
    write(&context, &path, &list, &Writing::default(), &mut Silent).unwrap();
    let part = read(&context, &path, Some("large"), Some([[-0.2; 3], [0.4; 3]]), &mut Silent).unwrap();
    let (all, few) = (grids[0].info().unwrap(), part.info().unwrap());
    assert!(few.active_voxels > 100 && few.active_voxels * 10 < all.active_voxels, "{few:?}");
    let near = [[0.1, 0.2, 0.0], [0.3, 0.1, 0.05]];
    assert_eq!(part.sample(&near, false).unwrap(), grids[0].sample(&near, false).unwrap());
    // The limit is for the grid that is read, not for the file.
    let need = Survey::of_file(&path, LIMIT).unwrap().grids.iter().map(|grid| grid.memory_bytes).min().unwrap();
    let tight = Context::new(&relievo_core::ContextOptions { threads: 1, memory_limit: need * 2 }).unwrap();
    assert!(read(&tight, &path, Some("small"), None, &mut Silent).is_ok());
    let error = read(&tight, &path, Some("large"), None, &mut Silent).unwrap_err();
    assert_eq!(error.kind, ErrorKind::Memory);
    let error = read(&context, &path, Some("none"), None, &mut Silent).unwrap_err();
    assert!(error.kind == ErrorKind::NotFound && error.to_string().contains("large"), "{error}");
}
