//! What is filled where a function is inside.

use glam::Vec3;
use relievo_core::{Context, ContextOptions};
use relievo_fluid::{block, fill_where};

#[test]
fn a_box_is_filled_as_a_block() {
    let (low, high, spacing) = (Vec3::new(-0.3, 0.1, 2.0), Vec3::new(0.1, 0.7, 2.2), 0.05);
    let is_inside = |at: Vec3| at.cmpgt(low).all() && at.cmplt(high).all();
    let places = fill_where(&Context::serial(), [low, high], spacing, &is_inside).unwrap();
    let expected = block(low, high, spacing).unwrap();
    assert_eq!((places.len(), expected.len()), (8 * 12 * 4, 8 * 12 * 4));
    assert!(places.iter().zip(&expected).all(|(a, b)| a.distance(*b) < 1e-5));
    // A box that is looked at from farther away has no fewer than without its outermost layer.
    let around = [low - 0.03, high + 0.03];
    let within = fill_where(&Context::serial(), around, spacing, &is_inside).unwrap();
    assert!((7 * 11 * 3..=places.len()).contains(&within.len()), "{}", within.len());
}

#[test]
fn particles_are_half_a_spacing_from_a_ball_in_any_number_of_threads() {
    let (radius, spacing) = (0.5, 0.04);
    let is_inside = |at: Vec3| at.length() < radius;
    let context = Context::new(&ContextOptions { threads: 3, ..ContextOptions::default() }).unwrap();
    let ends = [Vec3::splat(-radius), Vec3::splat(radius)];
    let places = fill_where(&context, ends, spacing, &is_inside).unwrap();
    assert_eq!(places, fill_where(&Context::serial(), ends, spacing, &is_inside).unwrap());
    let farthest = places.iter().map(|place| place.length()).fold(0.0, f32::max);
    // Between two of the directions that are looked at, 35° apart at most, it is a little nearer.
    assert!((0.44..0.485).contains(&farthest), "{farthest}");
    let volume = places.len() as f32 * spacing.powi(3) / (4.0 / 3.0 * std::f32::consts::PI * radius.powi(3));
    assert!((0.85..1.0).contains(&volume), "{volume}");
}

#[test]
fn too_many_are_refused_and_nothing_is_nothing() {
    let fill = |ends: [Vec3; 2], spacing: f32| fill_where(&Context::serial(), ends, spacing, &|_| false);
    assert!(fill([Vec3::ZERO, Vec3::ONE], 1e-4).is_err());
    assert!(fill([Vec3::ZERO, Vec3::NAN], 0.1).is_err() && fill([Vec3::ZERO, Vec3::ONE], 0.0).is_err());
    assert!(fill([Vec3::ZERO, Vec3::ONE], 0.1).unwrap().is_empty());
}
