//! Level sets against spheres, and against themselves.

use relievo_core::progress::Silent;
use relievo_core::{Context, ContextOptions};
use relievo_fluid::{BLOCK, LevelSet, Surface, SurfaceFunction, level_set, mesh};

fn made(threads: usize, particles: &[[f32; 3]], voxel: f32) -> LevelSet {
    let context = Context::new(&ContextOptions { threads, memory_limit: 0 }).unwrap();
    let surface = Surface::new(&context, particles, SurfaceFunction::zhu_bridson(0.1)).unwrap();
    let mesh = mesh(&context, &surface, voxel, &[], &mut Silent).unwrap();
    level_set(&context, &surface, &mesh, voxel, &mut Silent).unwrap()
}

/// Places of voxels in metres, and values.
fn voxels(level_set: &LevelSet) -> impl Iterator<Item = ([f32; 3], f32)> {
    level_set.blocks.iter().flat_map(move |(origin, values)| {
        values.iter().enumerate().map(move |(at, value)| {
            let steps = [at / (BLOCK * BLOCK), at / BLOCK % BLOCK, at % BLOCK];
            ([0, 1, 2].map(|axis| (origin[axis] + steps[axis] as i32) as f32 * level_set.voxel), *value)
        })
    })
}

#[test]
fn distances_to_a_sphere_are_those_of_its_centre() {
    // One particle of Zhu and Bridson's function is a sphere of its radius.
    let centre = [0.31, -0.2, 1.05];
    let level_set = made(1, &[centre], 0.02);
    let (mut near, mut most) = (0, 0.0f32);
    for (place, value) in voxels(&level_set) {
        let from = [0, 1, 2].map(|axis| place[axis] - centre[axis]).iter().map(|d| d * d).sum::<f32>().sqrt();
        let expected = (from - 0.1).clamp(-level_set.band, level_set.band);
        near += i32::from(value.abs() < level_set.band);
        most = most.max((value - expected).abs());
    }
    // The mesh is inside its sphere by a part of a cell.
    println!("{near} voxels near the surface, at most {most} m off");
    assert!(near > 1000 && most < 0.1 * level_set.voxel, "{near} {most}");
}

#[test]
fn level_sets_do_not_depend_on_threads_and_their_blocks_are_sorted() {
    let particles: Vec<[f32; 3]> = (0..60).map(|at| [at % 5, at / 5 % 4, at / 20].map(|at| at as f32 * 0.2)).collect();
    let one = made(1, &particles, 0.05);
    assert!(one.blocks.windows(2).all(|pair| pair[0].0 < pair[1].0));
    assert!(voxels(&one).any(|(_, value)| value == -one.band) && voxels(&one).any(|(_, value)| value == one.band));
    assert_eq!(one, made(4, &particles, 0.05));
}

#[test]
fn far_from_0_voxels_need_no_more_memory() {
    let context = Context::new(&ContextOptions { threads: 1, memory_limit: 1 << 24 }).unwrap();
    for far in [0.0, 100.0, -100.0] {
        let surface = Surface::new(&context, &[[far; 3]], SurfaceFunction::zhu_bridson(0.1)).unwrap();
        let mesh = mesh(&context, &surface, 0.05, &[], &mut Silent).unwrap();
        assert!(!level_set(&context, &surface, &mesh, 0.05, &mut Silent).unwrap().blocks.is_empty(), "{far}");
    }
}

#[test]
fn voxels_that_cannot_be_are_refused_before_they_are_made() {
    let context = Context::new(&ContextOptions { threads: 1, memory_limit: 1 << 26 }).unwrap();
    let surface = Surface::new(&context, &[[0.0; 3]], SurfaceFunction::zhu_bridson(0.1)).unwrap();
    let mesh = mesh(&context, &surface, 0.1, &[], &mut Silent).unwrap();
    for voxel in [0.0, -1.0, f32::NAN, f32::INFINITY, 1e-9, 1e-5] {
        assert!(level_set(&context, &surface, &mesh, voxel, &mut Silent).is_err(), "{voxel}");
    }
}
