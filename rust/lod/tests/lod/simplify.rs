//! Simplification: what it keeps, what it reaches, and what it refuses.

use proptest::prelude::*;
use relievo_core::progress::Silent;
use relievo_core::{Context, ContextOptions, ErrorKind};
use relievo_lod::{Simplified, SimplifyOptions, Welded, simplify, weld};
use relievo_testing::file;

use crate::shapes::{Triangles, edges, lifted, torus, two_tori};

fn run((points, triangles): &Triangles, options: &SimplifyOptions) -> Simplified {
    simplify(&Context::serial(), points, triangles, options, &mut Silent).unwrap()
}

fn to(faces: usize) -> SimplifyOptions {
    SimplifyOptions { target_triangles: faces, ..SimplifyOptions::default() }
}

fn volume(points: &[[f32; 3]], triangles: &[[u32; 3]]) -> f64 {
    let corner = |vertex: u32| glam::Vec3::from(points[vertex as usize]).as_dvec3();
    triangles.iter().map(|[a, b, c]| corner(*a).dot(corner(*b).cross(corner(*c))) / 6.0).sum()
}

fn area(points: &[[f32; 3]], triangles: &[[u32; 3]]) -> f64 {
    let corner = |vertex: u32| glam::Vec3::from(points[vertex as usize]).as_dvec3();
    let twice = |[a, b, c]: &[u32; 3]| (corner(*b) - corner(*a)).cross(corner(*c) - corner(*a)).length();
    triangles.iter().map(twice).sum::<f64>() / 2.0
}

#[test]
fn a_plane_keeps_its_outline_with_few_triangles() {
    let plane = lifted(40, |x, y| 0.5 * x - 0.25 * y);
    let made = run(&plane, &SimplifyOptions { max_error: 1e-5, ..to(0) });
    assert!(made.triangles.len() <= 60, "{}", made.triangles.len());
    assert!((area(&made.points, &made.triangles) - area(&plane.0, &plane.1)).abs() < 1e-4);
    for [x, y, z] in made.points {
        assert!((z - 0.5 * x + 0.25 * y).abs() < 1e-5);
    }
}

#[test]
fn a_closed_surface_stays_closed_and_keeps_its_volume_and_its_hole() {
    let torus = torus(120, 60);
    let before = volume(&torus.0, &torus.1);
    for faces in [7200, 1440, 400, 0] {
        let made = run(&torus, &to(faces));
        let edges = edges(&made.triangles);
        assert!(edges.values().all(|count| *count == 2));
        assert_eq!(made.points.len() + made.triangles.len(), edges.len(), "Euler's number of a torus is 0");
        if faces > 0 {
            assert!(made.triangles.len() <= faces && made.triangles.len() + 2 > faces, "{}", made.triangles.len());
            let change = (volume(&made.points, &made.triangles) / before - 1.0).abs();
            assert!(change < 4e-3, "{faces} faces: {change}");
        }
    }
}

#[test]
fn points_stay_on_a_torus_within_the_error_that_is_told() {
    let (points, triangles) = torus(96, 48);
    let distance = |[x, y, z]: [f32; 3]| (((x * x + y * y).sqrt() - 1.0).hypot(z) - 0.4).abs();
    let mut last = f32::INFINITY;
    for error in [0.02, 0.005, 0.001] {
        let made = run(&(points.clone(), triangles.clone()), &SimplifyOptions { max_error: error, ..to(0) });
        let worst = made.points.iter().copied().map(distance).fold(0.0, f32::max);
        assert!(made.error <= error && worst <= 2.0 * error, "{error}: {} {worst}", made.error);
        assert!(made.triangles.len() < triangles.len() && worst <= last);
        last = worst;
    }
}

#[test]
fn results_do_not_depend_on_threads() {
    let bumps = lifted(90, |x, y| 0.1 * (9.0 * x).sin() * (7.0 * y).cos() + 0.02 * (40.0 * x * y).sin());
    let expected = run(&bumps, &to(1500));
    for threads in [2, 5] {
        let context = Context::new(&ContextOptions { threads, memory_limit: 0 }).unwrap();
        let made = simplify(&context, &bumps.0, &bumps.1, &to(1500), &mut Silent).unwrap();
        assert_eq!(made, expected);
    }
}

#[test]
fn the_border_of_a_surface_stays_where_it_is() {
    let bumps = lifted(60, |x, y| 0.05 * (12.0 * x * (1.0 - x) * y * (1.0 - y)).sin());
    let made = run(&bumps, &to(700));
    let border: Vec<_> = edges(&made.triangles).into_iter().filter(|(_, count)| *count == 1).collect();
    for ([a, b], _) in &border {
        for [x, y, _] in [made.points[*a as usize], made.points[*b as usize]] {
            let inside = x.min(y).min(1.0 - x).min(1.0 - y);
            assert!(inside.abs() < 2e-3, "{x} {y}");
        }
    }
    let length =
        |[a, b]: &[u32; 2]| glam::Vec3::from(made.points[*a as usize]).distance(made.points[*b as usize].into());
    let around: f32 = border.iter().map(|(edge, _)| length(edge)).sum();
    assert!((around - 4.0).abs() < 0.02, "{around}");
}

#[test]
fn locked_points_stay() {
    let surface = torus(60, 30);
    let locked: Vec<u32> = (0..surface.0.len() as u32).step_by(97).collect();
    let made = run(&surface, &SimplifyOptions { locked: locked.clone(), ..to(300) });
    for vertex in locked {
        assert!(made.points.contains(&surface.0[vertex as usize]), "{vertex}");
    }
    assert!(made.triangles.len() <= 300);
}

#[test]
fn what_is_not_manifold_survives() {
    let (points, triangles) = two_tori();
    let made = run(&(points.clone(), triangles.clone()), &to(600));
    assert!(made.triangles.len() <= 600);
    let (before, after) = (edges(&triangles), edges(&made.triangles));
    assert_eq!(after.values().filter(|count| **count == 4).count(), before.values().filter(|it| **it == 4).count());
    assert!(made.points.contains(&[9.0; 3]));
    assert_eq!(made.triangles.iter().filter(|[a, b, c]| a == b || b == c || c == a).count(), 1);
    assert_eq!(made.triangles.iter().filter(|it| made.points[it[2] as usize] == [5.0, 1.0, 0.0]).count(), 2);
}

/// Pages of n × n squares that meet along a spine, bent.
fn book(pages: u32, n: u32) -> Triangles {
    let (mut points, mut triangles) = (Vec::new(), Vec::new());
    let place = |page: u32, x: u32, y: u32| {
        let (x, y) = (x as f32 / n as f32, y as f32 / n as f32);
        let (sine, cosine) = (std::f32::consts::TAU * page as f32 / pages as f32 + 0.5 * (3.0 * x).sin()).sin_cos();
        [x * cosine + 0.1 * (5.0 * y).sin(), x * sine, y]
    };
    points.extend((0..=n).map(|y| place(0, 0, y)));
    for page in 0..pages {
        let first = points.len() as u32;
        points.extend((0..=n).flat_map(|y| (1..=n).map(move |x| (x, y))).map(|(x, y)| place(page, x, y)));
        let at = |x: u32, y: u32| if x == 0 { y } else { first + y * n + x - 1 };
        for (x, y) in (0..n).flat_map(|y| (0..n).map(move |x| (x, y))) {
            let [a, b, c, d] = [at(x, y), at(x + 1, y), at(x + 1, y + 1), at(x, y + 1)];
            triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    (points, triangles)
}

#[test]
fn sheets_that_meet_along_a_curve_have_fewer_vertices_there_and_no_gap() {
    for (pages, n) in [(3, 24), (4, 16)] {
        let mesh = book(pages, n);
        let faces = mesh.1.len() / 20;
        let made = run(&mesh, &to(faces));
        assert!(made.triangles.len() <= faces, "{} of {faces}", made.triangles.len());
        // The spine is one line from end to end, with edges of all pages.
        let is_spine = |point: &[f32; 3]| mesh.0[..=n as usize].contains(point);
        let mut spine: Vec<u32> =
            (0..).zip(&made.points).filter(|(_, point)| is_spine(point)).map(|(vertex, _)| vertex).collect();
        spine.sort_unstable_by(|a, b| made.points[*a as usize][2].total_cmp(&made.points[*b as usize][2]));
        assert!((3..n as usize / 2).contains(&spine.len()), "{} vertices", spine.len());
        let ends = [spine[0], spine[spine.len() - 1]].map(|vertex| made.points[vertex as usize]);
        assert_eq!(ends, [mesh.0[0], mesh.0[n as usize]]);
        let edges = edges(&made.triangles);
        let count = |a: u32, b: u32| edges.get(&[a.min(b), a.max(b)]).copied().unwrap_or(0);
        assert!(spine.windows(2).all(|pair| count(pair[0], pair[1]) >= pages));
    }
}

#[test]
fn triangles_that_are_back_to_back_are_simplified_together() {
    let (points, triangles) = lifted(30, |x, y| 0.1 * (5.0 * x).sin() * (4.0 * y).cos());
    let both: Vec<[u32; 3]> = triangles.iter().flat_map(|[a, b, c]| [[*a, *b, *c], [*b, *a, *c]]).collect();
    let made = run(&(points.clone(), both.clone()), &to(300));
    assert!((298..=300).contains(&made.triangles.len()), "{}", made.triangles.len());
    let single = run(&(points.clone(), triangles), &to(150));
    assert_eq!(made.points, single.points);
    // Every triangle has its other side.
    let sorted = |it: &[u32; 3]| {
        let mut it = *it;
        it.sort_unstable();
        it
    };
    let mut sides: Vec<_> = made.triangles.iter().map(sorted).collect();
    sides.sort_unstable();
    assert!(sides.chunk_by(|one, other| one == other).all(|pair| pair.len() == 2));
    // Beside a part with one side, and by a limit of the deviation.
    let (more, torus) = torus(30, 16);
    let first = points.len() as u32;
    let mixed = ([points, more].concat(), [both, torus.iter().map(|it| it.map(|it| it + first)).collect()].concat());
    let made = run(&mixed, &to(400));
    assert!((390..=400).contains(&made.triangles.len()), "{}", made.triangles.len());
    let made = run(&mixed, &SimplifyOptions { max_error: 0.01, ..to(0) });
    assert!(made.triangles.len() < mixed.1.len() / 2 && made.error <= 0.01, "{}", made.triangles.len());
}

#[test]
fn triangles_apart_are_welded_where_they_meet() {
    let (points, triangles) = torus(20, 10);
    let apart: Vec<[f32; 3]> = triangles.as_flattened().iter().map(|vertex| points[*vertex as usize]).collect();
    let numbers: Vec<[u32; 3]> =
        (0..triangles.len() as u32).map(|face| [3 * face, 3 * face + 1, 3 * face + 2]).collect();
    let Welded { points: welded, triangles: together, .. } = weld(&apart, &numbers);
    assert_eq!(welded.len(), points.len());
    for (now, before) in together.as_flattened().iter().zip(triangles.as_flattened()) {
        assert_eq!(welded[*now as usize], points[*before as usize]);
    }
    assert_eq!(weld(&[[0.0; 3], [-0.0; 3]], &[]).numbers, [0, 0]);
}

#[test]
fn a_point_where_surfaces_touch_stays() {
    let (mut points, mut triangles) = torus(30, 16);
    let count = points.len() as u32;
    let [x, y, z] = points[0];
    triangles.extend(triangles.clone().into_iter().map(|it| it.map(|it| if it == 0 { 0 } else { it + count })));
    points.extend(points.clone().into_iter().map(|[a, b, c]| [2.0 * x - a, 2.0 * y - b, 2.0 * z - c]));
    let made = run(&(points, triangles), &to(200));
    assert!(made.triangles.len() <= 200 && made.points.contains(&[x, y, z]));
}

#[test]
fn creases_between_planes_stay() {
    let height = |x: f32, y: f32| (0.4 - (x - 0.5).abs().max((y - 0.5).abs())).clamp(0.0, 0.2);
    let made = run(&lifted(60, height), &to(400));
    for [x, y, z] in made.points {
        assert!((z - height(x, y)).abs() < 1e-3, "{x} {y} {z}");
    }
}

#[test]
fn nothing_to_do_changes_nothing() {
    let surface = torus(20, 10);
    let made = run(&surface, &to(400));
    assert_eq!((made.points, made.triangles, made.error), (surface.0, surface.1, 0.0));
}

#[test]
fn bad_input_is_refused() {
    let good = torus(8, 6);
    let fails = |points: &[[f32; 3]], triangles: &[[u32; 3]], options: &SimplifyOptions| {
        simplify(&Context::serial(), points, triangles, options, &mut Silent).unwrap_err().to_string()
    };
    assert!(fails(&good.0, &[], &to(0)).contains("without triangles"));
    let mut broken = good.0.clone();
    broken[7][1] = f32::NAN;
    assert!(fails(&broken, &good.1, &to(0)).contains("point 7"));
    assert!(fails(&good.0, &[[0, 1, 48]], &to(0)).contains("triangle 0"));
    assert!(fails(&good.0, &good.1, &SimplifyOptions { max_error: -1.0, ..to(0) }).contains("-1"));
    assert!(fails(&good.0, &good.1, &SimplifyOptions { locked: vec![48], ..to(0) }).contains("locked"));
    let context = Context::new(&ContextOptions { threads: 1, memory_limit: 1000 }).unwrap();
    let error = simplify(&context, &good.0, &good.1, &to(0), &mut Silent).unwrap_err();
    assert_eq!(error.kind, ErrorKind::Memory);
    let mut stop = |fraction: f32, _: &str| fraction < 0.2;
    let error = simplify(&Context::serial(), &good.0, &good.1, &to(0), &mut stop).unwrap_err();
    assert_eq!(error.kind, ErrorKind::Cancelled);
}

#[test]
fn extreme_sizes_are_no_matter() {
    let (points, triangles) = torus(40, 20);
    let expected = run(&(points.clone(), triangles.clone()), &to(300));
    for power in [-60, 60] {
        let scale = 2.0f32.powi(power);
        let scaled = points.iter().map(|point| point.map(|value| value * scale)).collect();
        let made = run(&(scaled, triangles.clone()), &to(300));
        assert_eq!(made.triangles, expected.triangles);
        assert_eq!(made.points, expected.points.iter().map(|point| point.map(|it| it * scale)).collect::<Vec<_>>());
    }
}

#[test]
fn damaged_models_are_simplified_or_refused() {
    let names = ["beetle.obj", "bunny_zippered.ply", "chair_model.obj", "cow.obj", "cycloidal.ply", "featuretype.ply"];
    let more = ["joined_tetrahedra.obj", "multibody.stl", "not_convex.obj", "octagonal_pocket.ply", "soup.stl"];
    for name in names.into_iter().chain(more) {
        let Some(path) = file(&format!("ugly/{name}")) else { return };
        let mesh = relievo_meshio::read(&Context::serial(), &path).unwrap();
        let triangles = mesh.triangles();
        let (before, made) = (edges(&triangles), run(&(mesh.points, triangles.clone()), &to(triangles.len() / 4)));
        let most = before.values().max().copied().unwrap_or(0).max(2);
        assert!(made.triangles.len() <= triangles.len() && !made.triangles.is_empty(), "{name}");
        assert!(edges(&made.triangles).values().all(|count| *count <= most), "{name}");
    }
}

proptest! {
    #[test]
    fn random_triangles_do_no_harm(
        points in prop::collection::vec(prop::array::uniform3(-4i8..4), 3..40),
        picks in prop::collection::vec(prop::array::uniform3(any::<u16>()), 1..160),
        faces in 0usize..40,
    ) {
        let points: Vec<[f32; 3]> = points.iter().map(|point| point.map(f32::from)).collect();
        let count = points.len() as u32;
        let triangles: Vec<[u32; 3]> = picks.iter().map(|pick| pick.map(|it| u32::from(it) % count)).collect();
        let made = run(&(points, triangles.clone()), &to(faces));
        prop_assert!(made.triangles.as_flattened().iter().all(|vertex| (*vertex as usize) < made.points.len()));
        let (before, after) = (edges(&triangles), edges(&made.triangles));
        let most = before.values().max().copied().unwrap_or(0).max(2);
        prop_assert!(after.values().all(|count| *count <= most));
    }
}

#[test]
fn progress_is_told_where_it_was_asked_for() {
    let (points, triangles) = torus(60, 30);
    let context = Context::new(&ContextOptions { threads: 2, ..ContextOptions::default() }).unwrap();
    let here = std::thread::current().id();
    let mut told = 0;
    let mut progress = |_: f32, _: &str| {
        assert_eq!(std::thread::current().id(), here);
        told += 1;
        true
    };
    simplify(
        &context,
        &points,
        &triangles,
        &SimplifyOptions { target_triangles: 500, ..Default::default() },
        &mut progress,
    )
    .unwrap();
    assert!(told > 3);
    let stop = simplify(&context, &points, &triangles, &SimplifyOptions::default(), &mut |_: f32, _: &str| false);
    assert_eq!(stop.unwrap_err().kind, ErrorKind::Cancelled);
}
