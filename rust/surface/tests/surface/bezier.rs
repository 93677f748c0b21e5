//! Newell's teapot and teacup: evaluation against de Casteljau, edges that are equal to the bit at any levels, meshes
//! without cracks.

use std::collections::BTreeMap;

use glam::Vec3;
use relievo_core::{Context, ContextOptions};
use relievo_meshio::Patches;
use relievo_surface::Place;
use relievo_surface::bezier::{BezierSurface, BezierTessellation, EdgeSense, Levels, MAX_LEVEL, ParametricMap};
use relievo_testing::{Random, tea_set};

/// Makes surfaces of the tea set, as it is and with weights. None where the data is not there.
fn models(context: &Context) -> Vec<(String, BezierSurface)> {
    let surface = |it: &Patches| BezierSurface::new(context, &it.points, Some(&it.indices), it.weights.as_deref());
    tea_set(context).into_iter().map(|(name, patches)| (name, surface(&patches).unwrap())).collect()
}

#[test]
fn the_tea_set_is_as_it_is_known() {
    let context = Context::serial();
    for (name, surface) in models(&context) {
        let pot = name.contains("teapot");
        assert_eq!(surface.count(), if pot { 32 } else { 26 }, "{name}");
        let sides = (0..surface.count()).flat_map(|patch| surface.edges().senses(patch));
        let collapsed = sides.filter(|sense| *sense == EdgeSense::Collapsed).count();
        let shared: Vec<usize> =
            (0..surface.edges().curve_count()).map(|curve| surface.edges().sharing(curve).count()).collect();
        let of = |count: usize| shared.iter().filter(|shared| **shared == count).count();
        // Eight patches of the teapot have an edge without length, which meets no other.
        assert_eq!((collapsed, of(2), of(1)), if pot { (8, 52, 24) } else { (0, 46, 12) }, "{name}");
        assert_eq!(of(2) * 2 + of(1), 4 * surface.count(), "{name}");
        let (low, high) = surface.total_bounds();
        let expected =
            if pot { ([-3.0, -2.0, 0.0], [3.525, 2.0, 3.15]) } else { ([-1.0, 0.0, -1.0], [1.0, 0.954545, 1.0]) };
        assert_eq!((low, high), expected, "{name}");
    }
}

/// De Casteljau's algorithm in homogeneous coordinates.
fn de_casteljau(controls: &[[f32; 4]; 16], u: f64, v: f64) -> [f64; 3] {
    let curve = |mut points: [[f64; 4]; 4], t: f64| {
        for round in 0..3 {
            for k in 0..3 - round {
                points[k] = std::array::from_fn(|axis| (1.0 - t) * points[k][axis] + t * points[k + 1][axis]);
            }
        }
        points[0]
    };
    let form = |[x, y, z, w]: [f32; 4]| {
        let w = f64::from(w);
        [f64::from(x) * w, f64::from(y) * w, f64::from(z) * w, w]
    };
    let rows = std::array::from_fn(|j| curve(std::array::from_fn(|i| form(controls[4 * j + i])), u));
    let [x, y, z, w] = curve(rows, v);
    [x / w, y / w, z / w]
}

fn distance(a: [f32; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|axis| (f64::from(a[axis]) - b[axis]).powi(2)).sum::<f64>().sqrt()
}

#[test]
fn points_are_those_of_de_casteljau() {
    let context = Context::new(&ContextOptions { threads: 2, memory_limit: 0 }).unwrap();
    for (name, surface) in models(&context) {
        let mut random = Random(17);
        let places: Vec<Place> = (0..5000)
            .map(|at| {
                let patch = at % surface.count() as u32;
                Place::new(patch, random.unit(), random.unit())
            })
            .collect();
        let samples = surface.evaluate_many(&context, &places).unwrap();
        for (place, (sample, normal)) in places.iter().zip(&samples) {
            let controls = surface.controls(place.tile as usize);
            let expected = de_casteljau(controls, f64::from(place.u), f64::from(place.v));
            assert!(distance(sample.p, expected) < 1e-6, "{name}, {place:?}");
            let length = normal.iter().map(|value| value * value).sum::<f32>();
            assert!((length - 1.0).abs() < 1e-5, "{name}, {place:?}: {normal:?}");
        }
        for level in [1, 3, 6] {
            let map = ParametricMap::new(level).unwrap();
            let tessellation = surface.tessellate(&context, &Levels::uniform(&surface, level).unwrap()).unwrap();
            assert_eq!(tessellation.triangles.len() as u64, map.triangles() * surface.count() as u64);
            let side = map.side();
            for (at, point) in tessellation.points.iter().enumerate() {
                let (patch, at) = (at as u64 / map.samples(), at as u32 % map.samples() as u32);
                let share = |k: u32| f64::from(k) / f64::from(map.segments());
                let (u, v) = (share(at % side), share(at / side));
                let expected = de_casteljau(surface.controls(patch as usize), u, v);
                assert!(distance(*point, expected) < 2e-6, "{name}, level {level}, patch {patch}, {u} {v}");
            }
            let normals = tessellation.normals.iter().map(|normal| normal.iter().map(|n| n * n).sum::<f32>());
            assert!(normals.into_iter().all(|square| (square - 1.0).abs() < 1e-5), "{name}, level {level}");
        }
    }
}

#[test]
fn second_derivatives_are_those_of_closed_forms() {
    let context = Context::serial();
    // x = u, y = v, z = u³ + 2 u²v + 3 v³, by its polar form at 0, 1/3, 2/3, 1.
    let third = |k: usize| k as f32 / 3.0;
    // Bézier ordinates of 1, t, t², t³ in degree 3.
    let power = |degree: usize, k: usize| match degree {
        0 => 1.0,
        1 => third(k),
        2 => [0.0, 0.0, 1.0 / 3.0, 1.0][k],
        _ => [0.0, 0.0, 0.0, 1.0][k],
    };
    let points: Vec<[f32; 3]> = (0..16)
        .map(|at| {
            let (i, j) = (at % 4, at / 4);
            [third(i), third(j), power(3, i) + 2.0 * power(2, i) * power(1, j) + 3.0 * power(3, j)]
        })
        .collect();
    // A quarter of a cylinder of radius 2 along z, an arc of degree 2 raised to 3, off the origin.
    let corner = std::f32::consts::FRAC_1_SQRT_2;
    let arc = [[2.0, 0.0, 1.0], [2.0, 2.0, corner], [0.0, 2.0, 1.0]].map(|[x, y, w]| [x * w, y * w, w]);
    let raised = |k: usize| -> [f32; 3] {
        let share = third(k);
        let blend = |a: [f32; 3], b: [f32; 3]| [0, 1, 2].map(|axis| share * a[axis] + (1.0 - share) * b[axis]);
        [arc[0], blend(arc[0], arc[1]), blend(arc[1], arc[2]), arc[2]][k]
    };
    let round: Vec<[f32; 3]> = (0..16)
        .map(|at| {
            let [x, y, w] = raised(at % 4);
            [x / w + 5.0, y / w, 4.0 * third(at / 4)]
        })
        .collect();
    let weights: Vec<f32> = (0..16).map(|at| raised(at % 4)[2]).collect();
    let graph = BezierSurface::new(&context, &points, None, None).unwrap();
    let cylinder = BezierSurface::new(&context, &round, None, Some(&weights)).unwrap();
    for (u, v) in [(0.0f32, 0.0f32), (0.25, 0.75), (1.0, 0.5), (0.5, 1.0), (1.0, 1.0)] {
        let near = |got: [f32; 3], expected: [f32; 3]| {
            assert!(Vec3::from(got).distance(Vec3::from(expected)) < 2e-5, "{u} {v}: {got:?} {expected:?}");
        };
        let (sample, _) = graph.evaluate(Place::new(0, u, v)).unwrap();
        near(sample.duu, [0.0, 0.0, 6.0 * u + 4.0 * v]);
        near(sample.duv, [0.0, 0.0, 4.0 * u]);
        near(sample.dvv, [0.0, 0.0, 18.0 * v]);
        let (sample, _) = cylinder.evaluate(Place::new(0, u, v)).unwrap();
        near(sample.duv, [0.0; 3]);
        near(sample.dvv, [0.0; 3]);
        // On a circle c about its middle: c·c'' = −c'·c'.
        let [c, first, second] = [sample.p, sample.du, sample.duu].map(|it| Vec3::from(it) * Vec3::new(1.0, 1.0, 0.0));
        let c = c - Vec3::new(5.0, 0.0, 0.0);
        assert!((c.length() - 2.0).abs() < 1e-5, "{c}");
        assert!((c.dot(second) + first.length_squared()).abs() < 1e-4, "{u} {v}: {c} {first} {second}");
    }
    // Along an edge that is a point nothing moves; inwards the patch bends as it does beside the edge.
    let mut points = points;
    points[..4].fill([0.0; 3]);
    let pointed = BezierSurface::new(&context, &points, None, None).unwrap();
    let at = |v: f32| pointed.evaluate(Place::new(0, 0.5, v)).unwrap().0;
    assert_eq!((at(0.0).du, at(0.0).duu), ([0.0; 3], [0.0; 3]));
    assert!(Vec3::from(at(0.0).dvv).length() > 0.1);
    assert!(Vec3::from(at(0.0).dvv).distance(Vec3::from(at(1e-4).dvv)) < 1e-2);
}

#[test]
fn the_teapot_looks_outwards_at_its_apex_and_its_base() {
    let Some(path) = relievo_testing::file("patches/teapot") else { return };
    let context = Context::serial();
    let patches = relievo_meshio::read_patches(&context, &path).unwrap();
    let surface = BezierSurface::new(&context, &patches.points, Some(&patches.indices), None).unwrap();
    let mut seen = 0;
    for patch in 0..surface.count() {
        for (edge, sense) in surface.edges().senses(patch).into_iter().enumerate() {
            if sense != EdgeSense::Collapsed {
                continue;
            }
            for step in 0..=16 {
                let place = Place::on_edge(patch as u32, edge as u8, step as f32 / 16.0);
                let (sample, normal) = surface.evaluate(place).unwrap();
                let up = if sample.p[2] > 1.0 { 1.0 } else { -1.0 };
                assert!((normal[2] - up).abs() < 1e-6, "patch {patch}: {normal:?} at {:?}", sample.p);
            }
            seen += 1;
        }
    }
    assert_eq!(seen, 8);
    for level in [1, 4] {
        let tessellation = surface.tessellate(&context, &Levels::uniform(&surface, level).unwrap()).unwrap();
        for (point, normal) in tessellation.points.iter().zip(&tessellation.normals) {
            if point[0] == 0.0 && point[1] == 0.0 {
                let up = if point[2] > 1.0 { 1.0 } else { -1.0 };
                assert!((normal[2] - up).abs() < 1e-6, "level {level}: {normal:?} at {point:?}");
            }
        }
    }
}

/// The points along an edge of a tessellated patch, without repeated ones, as bits.
fn along(tessellation: &BezierTessellation, levels: &Levels, patch: u32, edge: u8) -> Vec<[u32; 3]> {
    let side = ParametricMap::new(levels.patch(patch as usize)).unwrap().side();
    let first = tessellation.first[patch as usize];
    let point = |k: u32| match edge {
        0 => k,
        1 => side - 1 + side * k,
        2 => side * side - 1 - k,
        _ => side * (side - 1 - k),
    };
    let mut points: Vec<[u32; 3]> = (0..side)
        .map(|k| tessellation.points[(first + point(k)) as usize].map(|value| (value + 0.0).to_bits()))
        .collect();
    points.dedup();
    points
}

#[test]
fn both_sides_of_every_edge_have_the_same_points_at_any_levels() {
    let context = Context::new(&ContextOptions { threads: 2, memory_limit: 0 }).unwrap();
    let mut random = Random(29);
    for (name, surface) in models(&context) {
        for round in 0..6 {
            let most = if round < 5 { 5 } else { MAX_LEVEL };
            let levels = (0..surface.count()).map(|_| 1 + random.below(most as usize) as u8).collect();
            let levels = Levels::new(&surface, levels).unwrap();
            let tessellation = surface.tessellate(&context, &levels).unwrap();
            for curve in 0..surface.edges().curve_count() {
                let sides: Vec<_> = surface.edges().sharing(curve).collect();
                let level = sides.iter().map(|(patch, edge)| levels.edges(*patch as usize)[usize::from(*edge)]);
                let level = level.reduce(|a, b| if a == b { a } else { panic!("{name}: {a} and {b}") }).unwrap();
                let mut first: Option<Vec<[u32; 3]>> = None;
                assert!(sides.iter().any(|(patch, _)| levels.patch(*patch as usize) == level), "{name}");
                // Coarser patches have triangles between, which the mesh below shows.
                for (patch, edge) in sides.into_iter().filter(|(patch, _)| levels.patch(*patch as usize) == level) {
                    let points = along(&tessellation, &levels, patch, edge);
                    let collapsed = surface.edges().senses(patch as usize)[usize::from(edge)] == EdgeSense::Collapsed;
                    assert_eq!(points.len(), if collapsed { 1 } else { 2 << level }, "{name}");
                    let reversed: Vec<_> = points.iter().rev().copied().collect();
                    let first = first.get_or_insert(points.clone());
                    assert!(*first == points || *first == reversed, "{name}, round {round}, edge {edge} of {patch}");
                }
            }
            let [points, triangles] = surface.tessellated_counts(&levels).unwrap();
            assert_eq!([points, triangles], [tessellation.points.len(), tessellation.triangles.len()], "{name}");
            // Every edge of a triangle has another triangle beside it, but where the surface has a border.
            let mesh = tessellation.mesh();
            assert_eq!(mesh.check(), Ok(()), "{name}");
            let mut edges: BTreeMap<[u32; 2], i32> = BTreeMap::new();
            for face in mesh.faces() {
                for k in 0..3 {
                    let (a, b) = (face[k], face[(k + 1) % 3]);
                    *edges.entry([a.min(b), a.max(b)]).or_default() += if a < b { 1 } else { -1 };
                }
            }
            let border: u32 = (0..surface.edges().curve_count())
                .filter(|curve| surface.edges().sharing(*curve).count() == 1)
                .flat_map(|curve| surface.edges().sharing(curve))
                .filter(|(patch, edge)| {
                    surface.edges().senses(*patch as usize)[usize::from(*edge)] != EdgeSense::Collapsed
                })
                .map(|(patch, edge)| (2 << levels.edges(patch as usize)[usize::from(edge)]) - 1)
                .sum();
            let open = edges.values().filter(|count| **count != 0).count();
            assert_eq!(open, border as usize, "{name}, round {round}");
        }
    }
}

#[test]
fn threads_change_nothing() {
    for (name, surface) in models(&Context::serial()) {
        let levels = Levels::uniform(&surface, 4).unwrap();
        let one = surface.tessellate(&Context::serial(), &levels).unwrap();
        let context = Context::new(&ContextOptions { threads: 3, memory_limit: 0 }).unwrap();
        assert_eq!(surface.tessellate(&context, &levels).unwrap(), one, "{name}");
    }
    let context = Context::new(&ContextOptions { threads: 1, memory_limit: 1 << 20 }).unwrap();
    if let Some((_, surface)) = models(&context).first() {
        let error = surface.tessellate(&context, &Levels::uniform(surface, 8).unwrap()).unwrap_err();
        assert_eq!(error.kind, relievo_core::ErrorKind::Memory);
    }
}
