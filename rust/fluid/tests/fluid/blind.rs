//! Particles that a surface needs, and particles that it does not.

use relievo_core::progress::Silent;
use relievo_core::{Context, ContextOptions, ErrorKind};
use relievo_fluid::{Surface, SurfaceFunction, Visibility, classify, mesh};

use crate::shapes::{FUNCTIONS, hollow, lattice};

#[test]
fn what_is_left_out_does_not_change_the_surface() {
    let context = Context::serial();
    let points = hollow(30);
    for function in FUNCTIONS {
        let surface = Surface::new(&context, &points, function(0.01)).unwrap();
        let classes = classify(&context, &points, &surface, None, &mut Silent).unwrap();
        assert_eq!(classes.of[points.len() - 1], Visibility::Surface);
        let kept: Vec<[f32; 3]> = classes.indices().map(|at| points[at]).collect();
        assert_eq!(kept.len(), classes.surface + classes.blind);
        assert!(classes.surface < kept.len());
        // Anisotropic kernels see as far as the middle of this body.
        if surface.influence() < 0.1 {
            assert!(kept.len() < points.len(), "{:?}", surface.function());
        }
        let reduced = Surface::new(&context, &kept, function(0.01)).unwrap();
        let mesh = mesh(&context, &surface, 0.01, &[], &mut Silent).unwrap();
        let (mut all, mut few) = (surface.probe(&context), reduced.probe(&context));
        for point in &mesh.points {
            let (all, few) = (all.sample(*point), few.sample(*point));
            assert!((all.value - few.value).abs() < 1e-6, "{:?} {} {}", surface.function(), all.value, few.value);
            for (all, few) in all.gradient.iter().zip(few.gradient) {
                assert!((all - few).abs() < 1e-3, "{:?} {all} {few}", surface.function());
            }
        }
    }
}

#[test]
fn a_lattice_has_one_layer_at_the_surface() {
    let points = lattice(20, 0.02);
    let outer = points.len() - 18 * 18 * 18;
    for function in [SurfaceFunction::density(0.01), SurfaceFunction::zhu_bridson(0.01)] {
        let classes = [1, 2, 5].map(|threads| {
            let context = Context::new(&ContextOptions { threads, memory_limit: 0 }).unwrap();
            let surface = Surface::new(&context, &points, function).unwrap();
            classify(&context, &points, &surface, Some(surface.reach()), &mut Silent).unwrap()
        });
        assert!(classes[0] == classes[1] && classes[0] == classes[2]);
        assert_eq!(classes[0].surface, outer, "{function:?}");
        // Within some 6.7 radii of the surface: two layers more, and a third at the most.
        assert!((14usize.pow(3)..=16 * 16 * 16).contains(&(points.len() - outer - classes[0].blind)));
    }
}

#[test]
fn what_does_not_fit_is_refused() {
    let context = Context::serial();
    let surface = Surface::new(&context, &[[0.0; 3]; 2], SurfaceFunction::density(0.1)).unwrap();
    assert!(classify(&context, &[[0.0; 3]], &surface, None, &mut Silent).is_err());
    for threshold in [-1.0, f32::NAN, f32::INFINITY] {
        assert!(classify(&context, &[[0.0; 3]; 2], &surface, Some(threshold), &mut Silent).is_err());
    }
    // A thousand surfaces of at least eight vertices, of 12 bytes each.
    let apart = lattice(10, 1.0);
    let tight = Context::new(&ContextOptions { threads: 1, memory_limit: 90_000 }).unwrap();
    let surface = Surface::new(&context, &apart, SurfaceFunction::blobs(0.1)).unwrap();
    let error = classify(&tight, &apart, &surface, None, &mut Silent).unwrap_err();
    assert_eq!(error.kind, ErrorKind::Memory, "{error}");
    let none = Surface::new(&context, &[], SurfaceFunction::density(0.1)).unwrap();
    let classes = classify(&context, &[], &none, None, &mut Silent).unwrap();
    assert_eq!((classes.of.len(), classes.kept()), (0, 1.0));
}
