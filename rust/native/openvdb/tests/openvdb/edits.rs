//! Set operations, offsets, filters, resampling, conversion and labels, held against volumes that are known.

use relievo_core::progress::Silent;
use relievo_core::{Context, ContextOptions, ErrorKind};
use relievo_openvdb::peer::is_available;
use relievo_openvdb::{Class, Filter, Grid, Kind, Operation, Order, Transform, labels};

use crate::shapes::{block, inside, level_set};

const VOXEL: f64 = 0.05;

fn near(value: f64, expected: f64, tolerance: f64) {
    assert!((value - expected).abs() <= tolerance * expected.abs(), "{value} for {expected}");
}

#[test]
fn level_sets_and_fog_are_combined() {
    if !is_available() {
        return;
    }
    let context = Context::serial();
    let (a, b) = (level_set([0.0; 3], [2.0, 1.0, 1.0], VOXEL), level_set([1.0, 0.0, 0.0], [3.0, 1.0, 1.0], VOXEL));
    let finer = level_set([1.0, 0.0, 0.0], [3.0, 1.0, 1.0], 0.04);
    for other in [&b, &finer] {
        for (operation, expected) in
            [(Operation::Union, 3.0), (Operation::Intersection, 1.0), (Operation::Difference, 1.0)]
        {
            let made = a.combined(&context, other, operation, &mut Silent).unwrap();
            assert_eq!(made.info().unwrap().class, Class::LevelSet);
            near(inside(&made, 0.0), expected, 0.03);
        }
    }
    let fog = |grid: &Grid| grid.fog(&context, &mut Silent).unwrap();
    let (thick, thin) = (fog(&a), fog(&b));
    assert_eq!(thick.info().unwrap().class, Class::Fog);
    let places = [[0.5, 0.5, 0.5], [1.5, 0.5, 0.5], [2.5, 0.5, 0.5], [3.5, 0.5, 0.5]];
    for (operation, expected) in [
        (Operation::Union, [1.0, 1.0, 1.0, 0.0]),
        (Operation::Intersection, [0.0, 1.0, 0.0, 0.0]),
        (Operation::Difference, [1.0, 0.0, 0.0, 0.0]),
    ] {
        let made = thick.combined(&context, &thin, operation, &mut Silent).unwrap();
        assert_eq!(made.sample(&places, false).unwrap(), expected, "{operation:?}");
    }
    let error = a.combined(&context, &thin, Operation::Union, &mut Silent).unwrap_err();
    assert_eq!(error.kind, ErrorKind::Invalid);
}

#[test]
fn surfaces_are_moved_and_smoothed() {
    if !is_available() {
        return;
    }
    let context = Context::serial();
    let grid = level_set([0.0; 3], [1.0; 3], 0.04);
    let moved = |distance| inside(&grid.offset(&context, distance, &mut Silent).unwrap(), 0.0);
    near(moved(-0.2), 0.6f64.powi(3), 0.04);
    // Edges and corners become round.
    let pi = std::f64::consts::PI;
    near(moved(0.2), 1.0 + 6.0 * 0.2 + 12.0 * pi * 0.04 / 4.0 + 4.0 / 3.0 * pi * 0.008, 0.03);
    for filter in [Filter::Mean, Filter::Gaussian, Filter::Median, Filter::Laplacian, Filter::MeanCurvature] {
        let smooth = grid.filtered(&context, filter, 1, 4, &mut Silent).unwrap();
        let (left, corner) = (inside(&smooth, 0.0), smooth.sample(&[[0.02, 0.02, 0.02]], true).unwrap()[0]);
        assert!((0.7..0.999).contains(&left), "{filter:?}: {left}");
        // The corner of the box is outside of the smooth surface.
        assert!(corner > grid.sample(&[[0.02, 0.02, 0.02]], true).unwrap()[0], "{filter:?}: {corner}");
    }
    let fog = grid.fog(&context, &mut Silent).unwrap();
    assert!(fog.filtered(&context, Filter::Laplacian, 1, 1, &mut Silent).is_err());
    let blurred = fog.filtered(&context, Filter::Gaussian, 2, 1, &mut Silent).unwrap();
    let edge = [[0.0, 0.5, 0.5]];
    assert!(blurred.sample(&edge, true).unwrap()[0] > fog.sample(&edge, true).unwrap()[0]);
    assert!(fog.offset(&context, 0.1, &mut Silent).is_err());
    assert!(grid.offset(&context, f64::NAN, &mut Silent).is_err());
    assert!(grid.filtered(&context, Filter::Mean, 0, 1, &mut Silent).is_err());
}

#[test]
fn grids_are_resampled_and_converted() {
    if !is_available() {
        return;
    }
    let context = Context::serial();
    let grid = level_set([0.0; 3], [1.0; 3], VOXEL);
    for order in [Order::Nearest, Order::Linear, Order::Quadratic] {
        let fine = grid.resampled(&context, &Transform::uniform(0.03), order, &mut Silent).unwrap();
        near(inside(&fine, 0.0), 1.0, 0.05);
        assert_eq!(fine.info().unwrap().transform, Transform::uniform(0.03));
    }
    let small = Context::new(&ContextOptions { threads: 1, memory_limit: 1 << 26 }).unwrap();
    let to = |voxel| grid.resampled(&small, &Transform::uniform(voxel), Order::Linear, &mut Silent).unwrap_err().kind;
    assert_eq!((to(1e-3), to(1e-9)), (ErrorKind::Memory, ErrorKind::Invalid));
    for kind in Kind::all() {
        let mut source = Grid::new(kind, [0.0; 3], 1.0).unwrap();
        source.set_block(&context, &block(kind, [0; 3], [12; 3]), 0.0).unwrap();
        let count = source.info().unwrap().active_voxels;
        let twice = source.resampled(&context, &Transform::uniform(0.5), Order::Linear, &mut Silent).unwrap();
        assert!(twice.info().unwrap().active_voxels > 5 * count, "{kind:?}");
        for to in Kind::all() {
            let made = source.converted(&context, to, &mut Silent);
            if kind.components() != to.components() && !matches!(to, Kind::Bool | Kind::Mask) {
                assert!(made.is_err(), "{kind:?} to {to:?}");
                continue;
            }
            let info = made.unwrap().info().unwrap();
            assert_eq!((info.kind, info.active_voxels), (Some(to), count), "{kind:?} to {to:?}");
        }
    }
    let doubles = grid.converted(&context, Kind::Double, &mut Silent).unwrap();
    near(inside(&doubles, 0.0), 1.0, 0.01);
}

#[test]
fn fog_masks_and_labels_become_level_sets() {
    if !is_available() {
        return;
    }
    let context = Context::serial();
    let (a, b) = (level_set([0.0; 3], [2.0, 1.0, 1.0], VOXEL), level_set([1.0, 0.0, 0.0], [3.0, 1.0, 1.0], VOXEL));
    let again = a.fog(&context, &mut Silent).unwrap().level_set(&context, 0.5, 3.0, &mut Silent).unwrap();
    assert_eq!(again.info().unwrap().class, Class::LevelSet);
    let mut named = a.fog(&context, &mut Silent).unwrap();
    named.set_name("cloud").unwrap();
    assert_eq!(named.level_set(&context, 0.5, 3.0, &mut Silent).unwrap().info().unwrap().name, "cloud");
    // Fog is 0.5 in the middle of its ramp, one and a half voxels inside.
    near(inside(&again, 0.0), (2.0 - 3.0 * VOXEL) * (1.0 - 3.0 * VOXEL).powi(2), 0.03);
    let made = labels(&context, &[&a, &b], &[5, 9], &mut Silent).unwrap();
    let places = [[0.5, 0.5, 0.5], [1.5, 0.5, 0.5], [2.5, 0.5, 0.5], [3.5, 0.5, 0.5]];
    assert_eq!(made.sample(&places, false).unwrap(), [5.0, 9.0, 9.0, 0.0]);
    for (label, expected) in [(5, 1.0), (9, 2.0)] {
        let mask = made.label_mask(&context, label, &mut Silent).unwrap();
        assert_eq!(mask.kind().unwrap(), Kind::Mask);
        near(mask.info().unwrap().active_voxels as f64 * VOXEL.powi(3), expected, 0.14);
        near(inside(&mask.level_set(&context, 0.0, 3.0, &mut Silent).unwrap(), 0.0), expected, 0.15);
    }
    assert_eq!(made.label_mask(&context, 7, &mut Silent).unwrap().info().unwrap().active_voxels, 0);
    assert!(labels(&context, &[&a], &[1, 2], &mut Silent).is_err());
    assert!(a.label_mask(&context, 1, &mut Silent).is_err());
}
