//! Subdivision under all schemes and rules against OpenSubdiv's `Osd::CpuEvaluator`, and against closed forms.

use std::sync::Arc;

use relievo_core::{Attribute, Context, ContextOptions, Crease, Domain, Mesh, Values};
use relievo_opensubdiv::subdivision::{Channel, Interpolation, Spot, osd_evaluate};
use relievo_surface::subdivision::{
    Boundary, FaceVarying, PointRule, Primvar, Rules, Scheme, Subdivision, sharpened, without_boundary,
};
use relievo_surface::{Order, Place, Samples, Surface, SurfaceOptions};

/// A cage of quads, a pentagon and three triangles, or of triangles alone: a cap with a boundary, a crease, a sharp point,
/// and attributes on all domains. The texture has a seam along x = 2.
fn cap(triangles: bool) -> Mesh {
    let (n, mut points, mut faces) = (5_u32, Vec::new(), Vec::<Vec<u32>>::new());
    for j in 0..=n {
        for i in 0..=n {
            let (x, y) = (i as f32, j as f32);
            points.push([x + 0.1 * (y * 1.7).sin(), y, (x * 1.3).sin() + (y * 0.7).cos()]);
            if i < n && j < n {
                let a = j * (n + 1) + i;
                match (triangles, i, j) {
                    (true, ..) => faces.extend([vec![a, a + 1, a + n + 2], vec![a, a + n + 2, a + n + 1]]),
                    (false, 1, 3) => faces.extend([vec![a, a + 1, a + n + 2], vec![a, a + n + 2, a + n + 1]]),
                    (false, 3, 3) => {
                        faces.extend([vec![a, a + 1, a + n + 3, a + n + 2, a + n + 1], vec![a + 1, a + 2, a + n + 3]]);
                    }
                    (false, 4, 3) => {}
                    _ => faces.push(vec![a, a + 1, a + n + 2, a + n + 1]),
                }
            }
        }
    }
    let sizes = faces.iter().map(|face| face.len() as u32).collect();
    let corners: Vec<u32> = faces.concat();
    let mut mesh = Mesh::new(points, sizes, corners);
    // From boundary to boundary: OpenSubdiv's limit of the inner end of a crease is approximate.
    mesh.creases.extend((0..n).map(|k| Crease { points: [n + 1 + k, n + 2 + k], sharpness: 10.0 }));
    mesh.sharp_points.push((3 * (n + 1) + 2, 10.0));
    let mass = mesh.points.iter().flat_map(|[x, y, z]| [x * y, z * z - x]).collect();
    let mut uv = Vec::new();
    for face in &faces {
        let right = face.iter().all(|point| mesh.points[*point as usize][0] > 1.8);
        for point in face {
            let [x, y, _] = mesh.points[*point as usize];
            uv.extend([x + if right { 10.0 } else { 0.0 }, y + 0.1 * x * y]);
        }
    }
    let tint = (0..faces.len()).map(|face| face as f32).collect();
    let attributes = [("mass", Domain::Point, 2, mass), ("uv", Domain::Corner, 2, uv), ("tint", Domain::Face, 1, tint)];
    for (name, domain, width, values) in attributes {
        mesh.attributes.push(Attribute {
            name: name.into(),
            domain,
            width,
            values: Values::F32(values),
            indices: None,
        });
    }
    mesh
}

/// Places inside of every tile.
fn places(subdivision: &Subdivision, triangular: bool) -> Vec<Place> {
    let mut places = Vec::new();
    for tile in 0..subdivision.tile_count() as u32 {
        for (u, v) in [(0.31, 0.17), (0.05, 0.72), (0.6, 0.55), (0.93, 0.04), (0.05, 0.06)] {
            if !triangular || u + v <= 1.0 {
                places.push(Place::new(tile, u, v));
            }
        }
    }
    places
}

/// The spots of `places`, and the channel of the attribute "uv" with its values.
fn as_osd(mesh: &Mesh, triangular: bool, places: &[Place]) -> (Vec<Spot>, Channel, Vec<f32>) {
    let mut tiles = Vec::new();
    for (face, size) in mesh.face_sizes.iter().enumerate() {
        let count = if triangular || *size == 4 { 1 } else { *size };
        tiles.extend((0..count).map(|part| (face as u32, part)));
    }
    let spot = |place: &Place| {
        let (face, part) = tiles[place.tile as usize];
        Spot { face, part, u: place.u, v: place.v }
    };
    let Values::F32(uv) = &mesh.attributes[1].values else { unreachable!() };
    let (mut known, mut values) = (std::collections::HashMap::new(), Vec::new());
    let corners = mesh.corners.iter().zip(uv.as_chunks::<2>().0).map(|(point, value)| {
        *known.entry((*point, value.map(f32::to_bits))).or_insert_with(|| {
            values.extend(value);
            values.len() as u32 / 2 - 1
        })
    });
    let corners = corners.collect();
    (places.iter().map(spot).collect(), Channel { count: values.len() / 2, corners }, values)
}

/// Asserts that values and first derivatives agree within 2e-4, and second ones within 2e-2: around features the two
/// evaluators isolate other patches, whose second derivatives are approximate. Under Loop magnitudes of second ones are
/// compared, since OpenSubdiv 3.5 gives them the wrong sign in turned triangles of refined levels; their signs are tested
/// by [`second_derivatives_are_those_of_the_first`].
fn assert_same(what: &str, width: usize, got: &[f32], expected: &[f32], triangular: bool) {
    assert_eq!(got.len(), expected.len());
    for (index, (got, expected)) in got.iter().zip(expected).enumerate() {
        let order = index / width % 6;
        let (got, expected) = if triangular && order > 2 { (got.abs(), expected.abs()) } else { (*got, *expected) };
        let allowed = if order < 3 { 2e-4 } else { 2e-2 };
        let place = index / (6 * width);
        assert!((got - expected).abs() <= allowed, "{what}, place {place}, order {order}: {got} and {expected}");
    }
}

#[test]
fn schemes_rules_and_interpolations_agree_with_osd() {
    let context = Context::serial();
    let rules = |scheme, boundary, face_varying| Rules { scheme, boundary, face_varying, ..Rules::default() };
    let all = [
        rules(Scheme::CatmullClark, Boundary::EdgesAndCorners, FaceVarying::None),
        rules(Scheme::CatmullClark, Boundary::Edges, FaceVarying::CornersOnly),
        rules(Scheme::CatmullClark, Boundary::None, FaceVarying::CornersPlus1),
        Rules { smooth_triangles: true, ..rules(Scheme::CatmullClark, Boundary::Edges, FaceVarying::CornersPlus2) },
        Rules { chaikin: true, ..rules(Scheme::CatmullClark, Boundary::Edges, FaceVarying::Boundaries) },
        rules(Scheme::CatmullClark, Boundary::Edges, FaceVarying::All),
        rules(Scheme::Loop, Boundary::EdgesAndCorners, FaceVarying::CornersOnly),
        rules(Scheme::Loop, Boundary::Edges, FaceVarying::Boundaries),
        rules(Scheme::Loop, Boundary::None, FaceVarying::All),
        rules(Scheme::Bilinear, Boundary::EdgesAndCorners, FaceVarying::None),
    ];
    let (mut out, mut surfaces) = (Vec::new(), 0);
    for rules in all {
        let triangular = rules.scheme == Scheme::Loop;
        let mesh = Arc::new(cap(triangular));
        let subdivision = Subdivision::new(&context, mesh.clone(), &rules).unwrap();
        let places = places(&subdivision, triangular);
        let (spots, channel, values) = as_osd(&mesh, triangular, &places);
        let channels = [channel];
        let Values::F32(mass) = &mesh.attributes[0].values else { unreachable!() };
        let cases = [
            (Primvar::Points(&mesh.points), Interpolation::Vertex, mesh.points.as_flattened(), 3),
            (Primvar::Attribute("mass", PointRule::Vertex), Interpolation::Vertex, mass, 2),
            (Primvar::Attribute("mass", PointRule::Varying), Interpolation::Varying, mass, 2),
            (Primvar::Attribute("uv", PointRule::Vertex), Interpolation::FaceVarying(0), &values, 2),
        ];
        for (primvar, interpolation, values, width) in cases {
            subdivision.evaluate(&context, primvar, &places, 2, &mut out).unwrap();
            let expected =
                osd_evaluate((&mesh, &rules, &channels), interpolation, (values, width as u32), &spots).unwrap();
            let what = format!("{rules:?}, {primvar:?}");
            assert_same(&what[..what.len().min(300)], width, &out, &expected, triangular);
            surfaces += out.iter().filter(|value| **value != 0.0).count();
        }
        subdivision.evaluate(&context, Primvar::Attribute("tint", PointRule::Vertex), &places, 2, &mut out).unwrap();
        for (spot, found) in spots.iter().zip(out.as_chunks::<6>().0) {
            assert_eq!(*found, [spot.face as f32, 0.0, 0.0, 0.0, 0.0, 0.0]);
        }
    }
    assert!(surfaces > 10_000, "most places have a surface");
}

#[test]
fn second_derivatives_are_those_of_the_first() {
    let context = Context::serial();
    for scheme in [Scheme::CatmullClark, Scheme::Loop] {
        let triangular = scheme == Scheme::Loop;
        let mesh = Arc::new(cap(triangular));
        let rules = Rules { scheme, ..Rules::default() };
        let subdivision = Subdivision::new(&context, mesh.clone(), &rules).unwrap();
        let step = 0.004;
        let places: Vec<Place> =
            (0..subdivision.tile_count() as u32).map(|tile| Place::new(tile, 0.21, 0.34)).collect();
        let at = |du: f32, dv: f32| {
            let moved: Vec<Place> = places.iter().map(|it| Place::new(it.tile, it.u + du, it.v + dv)).collect();
            let mut out = Vec::new();
            subdivision.evaluate(&context, Primvar::Points(&mesh.points), &moved, 2, &mut out).unwrap();
            out
        };
        let (here, more_u, less_u) = (at(0.0, 0.0), at(step, 0.0), at(-step, 0.0));
        let (more_v, less_v) = (at(0.0, step), at(0.0, -step));
        for start in (0..here.len()).step_by(18) {
            for axis in start..start + 3 {
                let slope = |more: &[f32], less: &[f32], order: usize| -> f32 {
                    (more[axis + 3 * order] - less[axis + 3 * order]) / (2.0 * step)
                };
                let differences = [slope(&more_u, &less_u, 1), slope(&more_u, &less_u, 2), slope(&more_v, &less_v, 2)];
                for (order, difference) in (3..).zip(differences) {
                    let got = here[axis + 3 * order];
                    assert!((got - difference).abs() < 0.05, "{scheme:?}, {start}, {order}: {got} and {difference}");
                }
            }
        }
    }
}

#[test]
fn catmull_clark_is_the_surface_that_holds_detail() {
    let context = Context::serial();
    let mesh = Arc::new(cap(false));
    let subdivision = Subdivision::new(&context, mesh.clone(), &Rules::default()).unwrap();
    let places = places(&subdivision, false);
    let (mut out, mut samples) = (Vec::new(), Samples::default());
    subdivision.evaluate(&context, Primvar::Points(&mesh.points), &places, 1, &mut out).unwrap();
    let surface = Surface::new(&context, &mesh, &SurfaceOptions::default()).unwrap();
    surface.evaluate(&context, &places, Order::First, &mut samples).unwrap();
    for (index, found) in out.as_chunks::<18>().0.iter().enumerate() {
        for (order, quantity) in [&samples.p, &samples.du, &samples.dv].into_iter().enumerate() {
            for axis in 0..3 {
                let (got, expected) = (found[3 * order + axis], quantity[axis][index]);
                assert!((got - expected).abs() < 2e-4, "{:?}: {got} and {expected}", places[index]);
            }
        }
        assert!(found[9..].iter().all(|value| *value == 0.0), "second derivatives were not asked for");
    }
}

#[test]
fn a_sharpened_cage_is_bilinear_and_its_tiles_hold_detail() {
    let context = Context::serial();
    let rules = Rules { scheme: Scheme::Bilinear, ..Rules::default() };
    let mixed = Arc::new(cap(false));
    assert!(sharpened(&mixed).unwrap_err().to_string().contains("corners"));
    let refined = Subdivision::new(&context, mixed.clone(), &rules).unwrap().refined(&context, &mixed.points, 1);
    let mesh = Arc::new(refined.unwrap());
    let subdivision = Subdivision::new(&context, mesh.clone(), &rules).unwrap();
    let places = places(&subdivision, false);
    let (mut out, mut samples) = (Vec::new(), Samples::default());
    subdivision.evaluate(&context, Primvar::Points(&mesh.points), &places, 2, &mut out).unwrap();
    let surface = Surface::new(&context, &sharpened(&mesh).unwrap(), &SurfaceOptions::default()).unwrap();
    surface.evaluate(&context, &places, Order::Second, &mut samples).unwrap();
    for (index, found) in out.as_chunks::<18>().0.iter().enumerate() {
        for (order, quantity) in [&samples.p, &samples.du, &samples.dv, &samples.duu].into_iter().enumerate() {
            for axis in 0..3 {
                let (got, expected) = (quantity[axis][index], found[3 * order + axis]);
                assert!((got - expected).abs() < 1e-5, "{:?}, {order}: {got} and {expected}", places[index]);
            }
        }
    }
}

#[test]
fn a_cage_without_its_boundary_is_the_rule_none() {
    let context = Context::serial();
    let mesh = Arc::new(cap(false));
    let rules = Rules { boundary: Boundary::None, ..Rules::default() };
    let subdivision = Subdivision::new(&context, mesh.clone(), &rules).unwrap();
    let surface = Surface::new(&context, &without_boundary(&mesh), &SurfaceOptions::default()).unwrap();
    let (mut out, mut holes) = (Vec::new(), 0);
    for place in places(&subdivision, false) {
        subdivision.evaluate(&context, Primvar::Points(&mesh.points), &[place], 0, &mut out).unwrap();
        if surface.topology().is_hole(place.tile) {
            assert_eq!(out[..3], [0.0; 3], "{place:?}");
            holes += 1;
            continue;
        }
        let sample = surface.sample(context.level(), place).unwrap();
        let apart = (0..3).map(|axis| (sample.p[axis] - out[axis]).abs()).fold(0.0, f32::max);
        assert!(apart < 1e-4, "{place:?}: {sample:?} and {out:?}");
    }
    assert!(holes > 0);
}

#[test]
fn refined_cages_lie_on_the_limit_surface() {
    let context = Context::serial();
    for (scheme, boundary) in [
        (Scheme::CatmullClark, Boundary::EdgesAndCorners),
        (Scheme::Loop, Boundary::Edges),
        (Scheme::Loop, Boundary::None),
        (Scheme::Bilinear, Boundary::Edges),
    ] {
        let triangular = scheme == Scheme::Loop;
        let mesh = Arc::new(cap(triangular));
        let subdivision =
            Subdivision::new(&context, mesh.clone(), &Rules { scheme, boundary, ..Rules::default() }).unwrap();
        let refined = subdivision.refined(&context, &mesh.points, 2).unwrap();
        refined.check().unwrap();
        if boundary != Boundary::None {
            let parts: usize = if triangular { 16 * mesh.face_count() } else { 4 * subdivision.tile_count() };
            // A quad is one tile of 16 faces, a face of n corners has n tiles of 4.
            let quads = mesh.face_sizes.iter().filter(|size| **size == 4).count();
            assert_eq!(refined.face_count(), if triangular { parts } else { parts + 12 * quads });
        }
        assert!(refined.face_sizes.iter().all(|size| *size == if triangular { 3 } else { 4 }));
        // The corners of the first tile of a face are points of the refined cage.
        let mut out = Vec::new();
        let corner: Vec<Place> = (0..subdivision.tile_count() as u32).map(|tile| Place::new(tile, 0.0, 0.0)).collect();
        subdivision.evaluate(&context, Primvar::Points(&mesh.points), &corner, 0, &mut out).unwrap();
        let mut compared = 0;
        for found in out.as_chunks::<18>().0.iter().filter(|found| found[..3] != [0.0; 3]) {
            let nearest = refined
                .points
                .iter()
                .map(|point| (0..3).map(|axis| (point[axis] - found[axis]).powi(2)).sum::<f32>().sqrt());
            let nearest = nearest.fold(f32::INFINITY, f32::min);
            assert!(nearest < 1e-4, "{scheme:?}: {found:?} is {nearest} from the nearest point");
            compared += 1;
        }
        assert!(compared > 10);
        let tint = refined.attribute("tint").unwrap();
        assert_eq!((tint.domain, tint.values.len()), (Domain::Face, refined.face_count()));
        let uv = refined.attribute("uv").unwrap();
        assert_eq!(uv.indices.as_ref().map(Vec::len), Some(refined.corners.len()));
        assert_eq!(refined.attribute("mass").unwrap().values.len(), 2 * refined.points.len());
    }
}

#[test]
fn a_regular_octahedron_under_loop_has_its_closed_form() {
    let context = Context::serial();
    let points =
        vec![[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, -1.0]];
    let triangles = [[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]];
    let mesh = Arc::new(Mesh::from_triangles(points, &triangles));
    let rules = Rules { scheme: Scheme::Loop, ..Rules::default() };
    let subdivision = Subdivision::new(&context, mesh.clone(), &rules).unwrap();
    let mut out = Vec::new();
    subdivision.evaluate(&context, Primvar::Points(&mesh.points), &[Place::new(0, 0.0, 0.0)], 0, &mut out).unwrap();
    // The limit of a vertex of valence 4 (Loop 1987): its ring's centre is the origin, its weight 1 - n chi with
    // chi = 1 / (3 / (8 beta) + n) and beta = (5/8 - (3/8 + cos(2 pi / 4) / 4)^2) / 4.
    let beta = (5.0 / 8.0 - (3.0_f64 / 8.0).powi(2)) / 4.0;
    let expected = 1.0 - 4.0 / (3.0 / (8.0 * beta) + 4.0);
    assert!((f64::from(out[0]) - expected).abs() < 1e-6, "{} and {expected}", out[0]);
}

#[test]
fn what_cannot_be_subdivided_is_refused() {
    let context = Context::serial();
    let mesh = Arc::new(cap(false));
    let make = |rules| Subdivision::new(&context, mesh.clone(), &rules);
    let error = make(Rules { scheme: Scheme::Loop, ..Rules::default() }).unwrap_err();
    assert!(error.to_string().contains("face 0"), "{error}");
    assert!(make(Rules { isolation: 11, ..Rules::default() }).is_err());
    let subdivision = make(Rules::default()).unwrap();
    let mut out = Vec::new();
    let mut at = |primvar, place| subdivision.evaluate(&context, primvar, &[place], 2, &mut out);
    let points = Primvar::Points(&mesh.points);
    assert!(at(points, Place::new(10_000, 0.0, 0.0)).is_err());
    assert!(at(points, Place::new(0, f32::NAN, 0.0)).is_err());
    assert!(at(Primvar::Points(&mesh.points[1..]), Place::new(0, 0.0, 0.0)).is_err());
    assert!(at(Primvar::Attribute("st", PointRule::Vertex), Place::new(0, 0.0, 0.0)).is_err());
    assert!(subdivision.refined(&context, &mesh.points, 11).is_err());
    let small = Context::new(&ContextOptions { memory_limit: 100_000, ..ContextOptions::default() }).unwrap();
    let error = subdivision.refined(&small, &mesh.points, 8).unwrap_err();
    assert!(error.to_string().contains("memory limit"), "{error}");
}

#[test]
fn results_do_not_depend_on_threads() {
    let mesh = Arc::new(cap(true));
    let rules = Rules { scheme: Scheme::Loop, ..Rules::default() };
    let run = |context: &Context| {
        let subdivision = Subdivision::new(context, mesh.clone(), &rules).unwrap();
        let places = places(&subdivision, true).repeat(20);
        let mut out = Vec::new();
        subdivision.evaluate(context, Primvar::Points(&mesh.points), &places, 2, &mut out).unwrap();
        out
    };
    let threads = |threads| Context::new(&ContextOptions { threads, ..ContextOptions::default() }).unwrap();
    assert_eq!(run(&Context::serial()), run(&threads(3)));
}
