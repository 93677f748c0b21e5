//! Any bytes as a file of Bézier patches: refused, or patches that can be written, evaluated and tessellated.
#![no_main]

use libfuzzer_sys::fuzz_target;
use relievo_core::{Context, ContextOptions, ErrorKind};
use relievo_fuzz::MEMORY_LIMIT;
use relievo_meshio::parse_patches;
use relievo_surface::Place;
use relievo_surface::bezier::{BezierSurface, Levels};

fuzz_target!(|data: &[u8]| {
    let Ok(patches) = parse_patches(data, MEMORY_LIMIT) else { return };
    assert_eq!(patches.indices.len() % 16, 0);
    assert!(patches.indices.iter().all(|index| (*index as usize) < patches.points.len()));
    let options = ContextOptions { threads: 1, memory_limit: MEMORY_LIMIT };
    let context = Context::new(&options).expect("a thread");
    let weights = patches.weights.as_deref();
    let Ok(surface) = BezierSurface::new(&context, &patches.points, Some(&patches.indices), weights) else { return };
    for patch in [0, surface.count() as u32 - 1] {
        for (u, v) in [(0.0, 0.0), (0.5, 0.0), (1.0, 0.3), (0.6, 0.4)] {
            let (sample, normal) = surface.evaluate(Place::new(patch, u, v)).expect("a place of the surface");
            assert!(sample.p.iter().chain(&normal).all(|value| value.is_finite()), "{sample:?} {normal:?}");
        }
    }
    let levels = (0..surface.count()).map(|patch| 1 + (patch % 3) as u8).collect();
    let levels = Levels::new(&surface, levels).expect("levels that exist");
    match surface.tessellate(&context, &levels) {
        Ok(tessellation) => {
            let mesh = tessellation.mesh();
            assert!(mesh.corners.iter().all(|point| (*point as usize) < mesh.points.len()));
        }
        Err(error) => assert_eq!(error.kind, ErrorKind::Memory, "{error}"),
    }
});
