//! Volumes: NIfTI in memory, hostile bytes, and the files beside the checkout.

use relievo_core::Context;
use relievo_core::progress::Silent;
use relievo_openvdb::{Block, Grid, Kind, Transform, Writing, peer};
use relievo_shaderlab::Volume;

/// A NIfTI-1 file of 3 × 2 × 2 voxels of 16-bit integers with the values 0, 10, 20, ...
fn nifti(is_big: bool) -> Vec<u8> {
    let mut bytes = vec![0; 352];
    let mut put = |at: usize, mut value: Vec<u8>| {
        if is_big {
            value.reverse();
        }
        bytes.splice(at..at + value.len(), value);
    };
    put(0, 348_i32.to_le_bytes().to_vec());
    for (axis, edge) in [3_i16, 3, 2, 2, 1].into_iter().enumerate() {
        put(40 + 2 * axis, edge.to_le_bytes().to_vec());
    }
    put(70, 4_i16.to_le_bytes().to_vec());
    for (at, value) in [(80, 1.0_f32), (84, 2.0), (88, 3.0), (108, 352.0), (112, 2.0), (116, -5.0)] {
        put(at, value.to_le_bytes().to_vec());
    }
    bytes[344..348].copy_from_slice(b"n+1\0");
    for value in 0..12_i16 {
        bytes.extend(if is_big { (10 * value).to_be_bytes() } else { (10 * value).to_le_bytes() });
    }
    bytes
}

#[test]
fn both_byte_orders_are_read() {
    for is_big in [false, true] {
        let volume = Volume::of_nifti(&nifti(is_big), 1 << 20).unwrap();
        assert_eq!((volume.size, volume.spacing), ([3, 2, 2], [1.0, 2.0, 3.0]));
        assert_eq!(volume.values[..4], [-5.0, 15.0, 35.0, 55.0]);
        assert_eq!(volume.range(), [-5.0, 215.0]);
        let normalized = volume.normalized();
        assert_eq!((normalized[0], normalized[11]), (0.0, 1.0));
        assert_eq!(volume.proportions(), [0.5, 4.0 / 6.0, 1.0]);
    }
}

#[test]
fn damaged_files_are_refused_or_read() {
    let bytes = nifti(false);
    for end in 0..bytes.len() {
        assert!(Volume::of_nifti(&bytes[..end], 1 << 20).is_err());
    }
    for bit in 0..8 * bytes.len() {
        let mut flipped = bytes.clone();
        flipped[bit / 8] ^= 1 << (bit % 8);
        if let Ok(volume) = Volume::of_nifti(&flipped, 1 << 20) {
            assert!(volume.values.iter().all(|value| value.is_finite()));
        }
    }
    assert!(Volume::of_nifti(&bytes, 16).is_err());
}

#[test]
fn a_scan_of_a_head_is_read() {
    let Some(file) = relievo_testing::file("volumes/CT_AVM.nii.gz") else { return };
    let volume = Volume::read(&Context::serial(), &file).unwrap();
    assert_eq!(volume.values.len(), volume.size.iter().map(|edge| *edge as usize).product::<usize>());
    let [low, high] = volume.range();
    assert!(high > low);
}

/// A grid with a ramp of 3 × 4 × 5 voxels off the origin: its active box becomes the volume, with x fastest.
#[test]
fn grids_of_openvdb_are_read() {
    if !peer::is_available() {
        return;
    }
    let context = Context::serial();
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("ramp.vdb");
    let mut grid = Grid::new(Kind::Float, [0.0; 3], 1.0).unwrap();
    grid.set_transform(&Transform::affine([[0.5, 0.0, 0.0], [0.0, 0.5, 0.0], [0.0, 0.0, 0.5], [1.0, 2.0, 3.0]]))
        .unwrap();
    let (low, size) = ([-1, 2, 7], [3, 4, 5]);
    // Blocks have x slowest; no value is the background, so that all voxels are active.
    let value = |x: u32, y: u32, z: u32| (100 * x + 10 * y + z + 1) as f32;
    let places = (0..3).flat_map(|x| (0..4).flat_map(move |y| (0..5).map(move |z| (x, y, z))));
    let bytes = places.flat_map(|(x, y, z)| value(x, y, z).to_ne_bytes()).collect();
    grid.set_block(&context, &Block { low, size, kind: Kind::Float, bytes }, 0.0).unwrap();
    relievo_openvdb::write(&context, &file, &[&grid], &Writing::default(), &mut Silent).unwrap();
    let volume = Volume::read(&context, &file).unwrap();
    assert_eq!((volume.size, volume.spacing), (size, [0.5; 3]));
    let expected: Vec<f32> =
        (0..5).flat_map(|z| (0..4).flat_map(move |y| (0..3).map(move |x| value(x, y, z)))).collect();
    assert_eq!(volume.values, expected);
    assert_eq!(volume.range(), [1.0, 235.0]);
    // A grid without an active voxel is no volume, and neither is one of integers.
    for (kind, reason) in [(Kind::Float, "active"), (Kind::Int32, "floats")] {
        let other = Grid::new(kind, [0.0; 3], 1.0).unwrap();
        relievo_openvdb::write(&context, &file, &[&other], &Writing::default(), &mut Silent).unwrap();
        let error = Volume::read(&context, &file).unwrap_err();
        assert!(error.what.contains(reason), "{error}");
    }
}
