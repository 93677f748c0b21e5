//! Bounds of the distance between a simplified mesh and its input, held against samples.

use glam::DVec3;
use relievo_core::progress::Silent;
use relievo_core::{Context, ContextOptions, ErrorKind};
use relievo_lod::progressive::{ActiveMesh, BuildOptions};
use relievo_lod::{Attributes, Distance, Progressive, SimplifyOptions, distance, simplify, simplify_with};
use relievo_surface::triangle::closest;
use relievo_testing::{Random, file};

use crate::shapes::{Triangles, bored_block, edges, framed_windows, lifted, torus};

/// Measures how far points spread over the area of a mesh are from another at most, triangle by triangle.
fn sampled(from: &Triangles, to: &Triangles, count: usize) -> f64 {
    let corners = |(points, _): &Triangles, triangle: &[u32; 3]| {
        triangle.map(|vertex| glam::Vec3::from(points[vertex as usize]).as_dvec3())
    };
    let mut sum = 0.0;
    let areas: Vec<f64> = (from.1.iter().map(|it| corners(from, it)))
        .map(|[a, b, c]| {
            sum += (b - a).cross(c - a).length();
            sum
        })
        .collect();
    let shapes: Vec<[DVec3; 3]> = to.1.iter().map(|it| corners(to, it)).collect();
    let mut random = Random(3);
    let mut farthest = 0.0f64;
    for _ in 0..count {
        let at = f64::from(random.unit()) * sum;
        let [a, b, c] = corners(from, &from.1[areas.partition_point(|area| *area < at).min(areas.len() - 1)]);
        let (root, across) = (f64::from(random.unit().sqrt()), f64::from(random.unit()));
        let point = a * (1.0 - root) + b * root * (1.0 - across) + c * root * across;
        let mut near = f64::INFINITY;
        for [a, b, c] in &shapes {
            let low = a.min(*b).min(*c) - point;
            let high = point - a.max(*b).max(*c);
            if low.max(high).max(DVec3::ZERO).length_squared() < near * near {
                let [s, t, u] = closest(point, [*a, *b, *c]);
                near = near.min((*a * s + *b * t + *c * u).distance(point));
            }
        }
        farthest = farthest.max(near);
    }
    farthest
}

/// Samples both ways.
fn apart(first: &Triangles, second: &Triangles, count: usize) -> f64 {
    sampled(first, second, count).max(sampled(second, first, count))
}

fn diagonal(points: &[[f32; 3]]) -> f32 {
    let points = || points.iter().map(|point| glam::Vec3::from(*point));
    points().reduce(glam::Vec3::max).unwrap().distance(points().reduce(glam::Vec3::min).unwrap())
}

fn measured(first: &Triangles, second: &Triangles) -> Distance {
    let context = Context::new(&ContextOptions::default()).unwrap();
    distance(&context, [first, second].map(|(points, triangles)| (&points[..], &triangles[..])), &mut Silent).unwrap()
}

fn model(name: &str) -> Option<Triangles> {
    let mesh = relievo_meshio::read(&Context::serial(), &file(name)?).unwrap();
    let triangles = mesh.triangles();
    let welded = relievo_lod::weld(&mesh.points, &triangles);
    Some((welded.points, welded.triangles))
}

/// What meshoptimizer leaves, which moves vertices too.
fn theirs(mesh: &Triangles, faces: usize) -> Triangles {
    let (mut points, mut indices) = (mesh.0.clone(), mesh.1.as_flattened().to_vec());
    let options = meshopt::SimplifyOptions::None;
    let count = meshopt::simplify_with_update(
        &mut indices,
        &mut points,
        &mut [],
        &[],
        0,
        None,
        3 * faces,
        f32::MAX,
        options,
        None,
    );
    (points, indices[..count].as_chunks().0.to_vec())
}

fn shapes() -> Vec<(&'static str, Triangles)> {
    let waves = lifted(60, |x, y| 0.1 * (9.0 * x).sin() * (7.0 * y).cos() + 0.02 * (40.0 * x * y).sin());
    let tent = lifted(40, |x, y| (0.4 - (x - 0.5).abs().max((y - 0.5).abs())).clamp(0.0, 0.2));
    let mut shapes =
        vec![("torus", torus(96, 48)), ("waves", waves), ("tent", tent), ("block", bored_block(64, 48, 3))];
    for name in ["cages/suzanne.obj", "ugly/cow.obj", "ugly/featuretype.ply"] {
        shapes.extend(model(name).map(|mesh| (name, mesh)));
    }
    shapes
}

#[test]
fn no_sample_is_farther_than_the_error_that_is_asked_for() {
    for (name, mesh) in shapes() {
        for share in [0.02, 0.003] {
            let bound = share * diagonal(&mesh.0);
            let options = SimplifyOptions { bound, ..Default::default() };
            let made = simplify(&Context::serial(), &mesh.0, &mesh.1, &options, &mut Silent).unwrap();
            let left = made.triangles.len();
            let found = apart(&mesh, &(made.points, made.triangles), 3000);
            assert!(found <= f64::from(made.error) && made.error <= bound, "{name} {share}: {found} {}", made.error);
            assert!(left < mesh.1.len(), "{name} {share}: {left} triangles");
        }
    }
}

#[test]
fn a_bound_leaves_about_as_many_triangles_as_an_estimate_of_half_of_it() {
    let mesh = lifted(80, |x, y| 0.1 * (9.0 * x).sin() * (7.0 * y).cos());
    let count = |options: SimplifyOptions| {
        simplify(&Context::serial(), &mesh.0, &mesh.1, &options, &mut Silent).unwrap().triangles.len()
    };
    let bounded = count(SimplifyOptions { bound: 0.01, ..Default::default() });
    let estimated = count(SimplifyOptions { max_error: 0.005, ..Default::default() });
    assert!(bounded <= estimated * 5 / 4, "{bounded} {estimated}");
}

#[test]
fn bounds_hold_with_attributes_faces_and_threads() {
    let mesh = torus(60, 30);
    let values: Vec<f32> = mesh.0.iter().map(|point| point[0]).collect();
    let attributes = Attributes { values: &values, weights: &[0.1], ..Default::default() };
    let options = SimplifyOptions { bound: 0.01, ..Default::default() };
    let context = Context::new(&ContextOptions { threads: 3, memory_limit: 0 }).unwrap();
    let made = simplify_with(&context, &mesh.0, &mesh.1, &attributes, &options, &mut Silent).unwrap();
    let serial = simplify_with(&Context::serial(), &mesh.0, &mesh.1, &attributes, &options, &mut Silent).unwrap();
    assert_eq!(made, serial);
    assert!(made.triangles.len() < mesh.1.len() / 2 && made.error <= 0.01);
    assert!(apart(&mesh, &(made.points, made.triangles), 2000) <= f64::from(made.error));
    // Whichever limit is met first ends it.
    let plain = |options: &SimplifyOptions| simplify(&context, &mesh.0, &mesh.1, options, &mut Silent).unwrap();
    let most = plain(&SimplifyOptions { target_triangles: 3000, bound: 0.01, ..Default::default() });
    assert!(most.triangles.len() >= 2999 && most.error <= 0.01, "{}", most.triangles.len());
    assert!(
        plain(&options).triangles.len() > plain(&SimplifyOptions { bound: 0.05, ..options.clone() }).triangles.len()
    );
}

#[test]
fn a_small_bound_keeps_a_curved_mesh_and_thins_out_a_plane() {
    let run = |mesh: &Triangles, bound: f32| {
        let options = SimplifyOptions { bound, ..Default::default() };
        simplify(&Context::serial(), &mesh.0, &mesh.1, &options, &mut Silent).unwrap()
    };
    let curved = torus(20, 10);
    assert_eq!(run(&curved, 0.0).triangles.len(), curved.1.len());
    let made = run(&lifted(20, |_, _| 0.0), 1e-3);
    assert!(made.triangles.len() < 100 && made.error <= 1e-3, "{} {}", made.triangles.len(), made.error);
}

#[test]
fn flat_parts_are_thinned_out_at_tight_bounds() {
    let count = |mesh: &Triangles, share: f32| {
        let bound = share * diagonal(&mesh.0);
        let options = SimplifyOptions { bound, ..Default::default() };
        let made = simplify(&Context::serial(), &mesh.0, &mesh.1, &options, &mut Silent).unwrap();
        assert!(made.error <= bound.max(1e-6), "{} {bound}", made.error);
        made.triangles.len()
    };
    for (side, share) in [(20, 1e-3), (20, 1e-4), (64, 1e-4), (150, 1e-3)] {
        let left = count(&lifted(side, |_, _| 0.0), share);
        assert!(left <= 16, "{side} {share}: {left} triangles");
    }
    // A plate with a hole.
    let mut holed = lifted(100, |_, _| 0.0);
    let is_left = |[a, ..]: &[u32; 3]| {
        let [x, y, _] = holed.0[*a as usize];
        !((0.4..0.6).contains(&x) && (0.3..0.7).contains(&y))
    };
    holed.1.retain(is_left);
    let left = count(&holed, 1e-4);
    assert!(left <= 16, "{left} triangles around a hole");
    // A plate with waves of a tenth of the bound, and one with waves along one axis.
    let left = count(&lifted(100, |x, y| 1e-4 * (31.0 * x).sin() * (27.0 * y).cos()), 1e-3);
    assert!(left <= 16, "{left} triangles of low waves");
    let left = count(&lifted(60, |x, _| 0.2 * (3.0 * x).sin()), 1e-4);
    assert!(left <= 400, "{left} triangles of a bent plate");
    // A machine part with flat sides and sharp edges.
    let Some(part) = model("meshes/fandisk.obj") else { return };
    let left = count(&part, 1e-4);
    assert!(left <= part.1.len() / 3, "{left} triangles of fandisk.obj");
}

#[test]
fn locked_borders_stay() {
    let mesh = lifted(24, |x, y| 0.1 * (5.0 * x * y).sin());
    let options = SimplifyOptions { target_triangles: 300, is_border_locked: true, ..Default::default() };
    let made = simplify(&Context::serial(), &mesh.0, &mesh.1, &options, &mut Silent).unwrap();
    let border = |triangles: &[[u32; 3]], points: &[[f32; 3]]| {
        let edges = edges(triangles).into_iter().filter(|(_, count)| *count == 1);
        let mut places: Vec<_> =
            edges.flat_map(|(edge, _)| edge.map(|it| points[it as usize].map(f32::to_bits))).collect();
        places.sort_unstable();
        places
    };
    assert!(made.triangles.len() <= 300);
    assert_eq!(border(&made.triangles, &made.points), border(&mesh.1, &mesh.0));
    let values = vec![0.0; mesh.0.len()];
    let attributes = Attributes { values: &values, weights: &[0.1], ..Default::default() };
    let made = simplify_with(&Context::serial(), &mesh.0, &mesh.1, &attributes, &options, &mut Silent).unwrap();
    assert_eq!(border(&made.triangles, &made.points), border(&mesh.1, &mesh.0));
}

#[test]
fn bad_bounds_are_refused_and_cancelled() {
    let mesh = torus(30, 16);
    let fails = |bound: f32, progress: &mut dyn relievo_core::Progress| {
        let options = SimplifyOptions { bound, ..Default::default() };
        simplify(&Context::serial(), &mesh.0, &mesh.1, &options, progress).unwrap_err()
    };
    assert!(fails(-1.0, &mut Silent).to_string().contains("bound"));
    assert!(fails(f32::NAN, &mut Silent).to_string().contains("bound"));
    let mut stop = |_: f32, stage: &str| stage != "measure";
    assert_eq!(fails(0.01, &mut stop).kind, ErrorKind::Cancelled);
    let mut last = 0.0;
    let mut rising = |fraction: f32, _: &str| {
        assert!((last..=1.0).contains(&fraction), "{fraction} after {last}");
        last = fraction;
        true
    };
    let options = SimplifyOptions { bound: 0.01, ..Default::default() };
    simplify(&Context::serial(), &mesh.0, &mesh.1, &options, &mut rising).unwrap();
}

#[test]
fn a_level_of_a_progressive_mesh_is_within_the_bound() {
    let mesh = lifted(60, |x, y| 0.1 * (9.0 * x).sin() * (7.0 * y).cos() + 0.02 * (40.0 * x * y).sin());
    let context = Context::serial();
    let options = BuildOptions { faces: 20, ..Default::default() };
    let whole = std::sync::Arc::new(Progressive::build(&context, &mesh.0, &mesh.1, &options, &mut Silent).unwrap());
    let mut active = ActiveMesh::new(&whole);
    let mut last = usize::MAX;
    for bound in [0.0, 0.002, 0.02, 0.1] {
        let distance = active.adapt_within(&context, bound, &mut Silent).unwrap();
        let level = active.extract();
        let found = apart(&mesh, &(level.points, level.triangles), 2000);
        assert!(found <= f64::from(distance) && distance <= bound.max(1e-6), "{bound}: {found} {distance}");
        assert!(active.triangle_count() <= last);
        last = active.triangle_count();
    }
    assert!(last < 1000, "{last}");
}

#[test]
fn the_bore_of_a_block_with_seams_is_not_torn() {
    for (around, outline, rows) in [(64, 48, 3), (96, 64, 2), (64, 40, 1), (160, 96, 1), (48, 30, 4)] {
        let block = bored_block(around, outline, rows);
        let faces = block.1.len() / 5;
        let options = SimplifyOptions { target_triangles: faces, ..Default::default() };
        let made = simplify(&Context::serial(), &block.0, &block.1, &options, &mut Silent).unwrap();
        assert!(made.triangles.len() <= faces, "{around}: {}", made.triangles.len());
        let ours = measured(&block, &(made.points, made.triangles)).at_least;
        let theirs = measured(&block, &theirs(&block, faces)).at_most;
        assert!(ours <= theirs, "{around} {outline} {rows}: {ours} {theirs}");
    }
}

#[test]
fn the_largest_deviation_is_no_larger_than_meshoptimizers() {
    let names = [
        "meshes/fandisk.obj",
        "meshes/cheburashka.obj",
        "ugly/cow.obj",
        "ugly/octagonal_pocket.ply",
        "ugly/teapot_unwelded.obj",
        "cages/suzanne.obj",
        "cages/armorguy.obj",
        "cages/bigguy.obj",
        "cages/monsterfrog.obj",
        "cages/t-rex.obj",
        "ugly/beetle.obj",
    ];
    for name in names {
        let Some(mesh) = model(name) else { return };
        let faces = mesh.1.len() / 10;
        let options = SimplifyOptions { target_triangles: faces, ..Default::default() };
        let made = simplify(&Context::serial(), &mesh.0, &mesh.1, &options, &mut Silent).unwrap();
        let ours = measured(&mesh, &(made.points, made.triangles)).at_least;
        let theirs = measured(&mesh, &theirs(&mesh, faces)).at_most;
        // Levels of instructions round costs otherwise, by which other edges collapse: the teapot is 0.8 % above at baseline.
        assert!(ours <= 1.01 * theirs, "{name}: {ours} {theirs}");
    }
}

/// Returns the count of vertices that are used, less that of edges, and triangles.
fn characteristic((_, triangles): &Triangles) -> isize {
    let vertices: std::collections::HashSet<u32> = triangles.iter().flatten().copied().collect();
    vertices.len() as isize - edges(triangles).len() as isize + triangles.len() as isize
}

#[test]
fn windows_keep_their_corners() {
    for (n, windows, around, width, share) in [(24, 2, 32, 0.03, 10), (20, 3, 32, 0.02, 15)] {
        let plate = framed_windows(n, windows, around, width);
        let faces = plate.1.len() / share;
        let options = SimplifyOptions { target_triangles: faces, ..Default::default() };
        let made = simplify(&Context::serial(), &plate.0, &plate.1, &options, &mut Silent).unwrap();
        assert!(made.triangles.len() <= faces && made.triangles.len() + 1 >= faces);
        let made = (made.points, made.triangles);
        assert_eq!(characteristic(&made), characteristic(&plate));
        assert!(edges(&made.1).values().all(|count| *count <= 2));
        // Without vertices that are put back it is 0.81 and 0.83.
        let [ours, theirs] = [&made, &theirs(&plate, faces)].map(|it| measured(&plate, it).at_least);
        assert!(ours <= 0.75 * theirs, "{n}: {ours} {theirs}");
    }
}
