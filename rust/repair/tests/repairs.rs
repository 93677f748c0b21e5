//! Repairs whose results are known: volumes, Euler numbers and attributes of bodies that were torn apart.

use std::f32::consts::TAU;

use proptest::prelude::*;
use relievo_core::parameter::Switch;
use relievo_core::progress::Silent;
use relievo_core::{Attribute, Context, ContextOptions, Domain, ErrorKind, Mesh, Values};
use relievo_repair::{Element, RepairSettings, Repaired, check, repair};
use relievo_testing::{Random, grid};

fn repaired(mesh: &Mesh) -> Repaired {
    let made = repair(&Context::serial(), mesh, &RepairSettings::default(), &mut Silent).unwrap();
    made.mesh.check().unwrap();
    made
}

/// A box of quads that face outwards.
fn cuboid(low: [f32; 3], high: [f32; 3]) -> Mesh {
    let corner = |at: usize| [0, 1, 2].map(|axis| [low, high][at >> axis & 1][axis]);
    let corners = [0, 2, 3, 1, 4, 5, 7, 6, 0, 1, 5, 4, 1, 3, 7, 5, 3, 2, 6, 7, 2, 0, 4, 6];
    Mesh::new((0..8).map(corner).collect(), vec![4; 6], corners.to_vec())
}

/// Meshes side by side.
fn together(meshes: &[Mesh]) -> Mesh {
    let mut all = Mesh::default();
    for mesh in meshes {
        let first = all.points.len() as u32;
        all.points.extend(&mesh.points);
        all.face_sizes.extend(&mesh.face_sizes);
        all.corners.extend(mesh.corners.iter().map(|point| first + point));
    }
    all
}

/// The same faces without common points.
fn apart(mesh: &Mesh) -> Mesh {
    let points = mesh.corners.iter().map(|point| mesh.points[*point as usize]).collect();
    Mesh::new(points, mesh.face_sizes.clone(), (0..mesh.corners.len() as u32).collect())
}

/// Reverses the faces for which `turn` answers yes.
fn turned(mesh: &Mesh, mut turn: impl FnMut(usize) -> bool) -> Mesh {
    let mut made = mesh.clone();
    let mut start = 0;
    for (face, size) in mesh.face_sizes.iter().enumerate() {
        let end = start + *size as usize;
        if turn(face) {
            made.corners[start..end].reverse();
        }
        start = end;
    }
    made
}

fn sphere(rings: u32, segments: u32) -> Mesh {
    let mut points = vec![[0.0, 0.0, 1.0]];
    for ring in 1..rings {
        for segment in 0..segments {
            let (polar, turn) = (0.5 * TAU * ring as f32 / rings as f32, TAU * segment as f32 / segments as f32);
            points.push([polar.sin() * turn.cos(), polar.sin() * turn.sin(), polar.cos()]);
        }
    }
    points.push([0.0, 0.0, -1.0]);
    let last = points.len() as u32 - 1;
    let at = |ring: u32, segment: u32| 1 + (ring - 1) * segments + segment % segments;
    let mut mesh = Mesh { points, ..Mesh::default() };
    for segment in 0..segments {
        let mut add = |face: &[u32]| {
            mesh.face_sizes.push(face.len() as u32);
            mesh.corners.extend(face);
        };
        add(&[0, at(1, segment), at(1, segment + 1)]);
        for ring in 1..rings - 1 {
            add(&[at(ring, segment), at(ring + 1, segment), at(ring + 1, segment + 1), at(ring, segment + 1)]);
        }
        add(&[last, at(rings - 1, segment + 1), at(rings - 1, segment)]);
    }
    mesh
}

/// Leaves out the faces for which `drop` answers yes.
fn without(mesh: &Mesh, drop: impl Fn(&[[f32; 3]]) -> bool) -> Mesh {
    let mut made = Mesh { points: mesh.points.clone(), ..Mesh::default() };
    for face in mesh.faces() {
        let places: Vec<[f32; 3]> = face.iter().map(|point| mesh.points[*point as usize]).collect();
        if !drop(&places) {
            made.face_sizes.push(face.len() as u32);
            made.corners.extend(face);
        }
    }
    made
}

#[test]
fn a_twisted_soup_of_polygons_becomes_the_body_it_was() {
    let mut random = Random(3);
    let body = grid(12, true, &[0, 1, 2, 3, 5, 6], false);
    let sound = repaired(&body).report.after;
    assert_eq!((sound.euler, sound.closed_components), (0, 1));
    let made = repaired(&turned(&apart(&body), |_| random.below(3) == 0));
    let after = &made.report.after;
    assert_eq!((after.points, after.edges, after.faces), (sound.points, sound.edges, sound.faces));
    assert!((after.volume / sound.volume.abs() - 1.0).abs() < 1e-6 && after.volume > 0.0);
    assert_eq!(made.mesh.face_sizes, body.face_sizes);
    assert!(made.report.turned_faces > 0 && made.report.is_solid() == (made.report.misoriented_edges.count == 0));
}

#[test]
fn values_of_welded_points_stay_with_their_corners() {
    let mut body = apart(&cuboid([0.0; 3], [1.0; 3]));
    let attribute = |name: &str, width: u32, values: Vec<f32>| Attribute {
        name: name.into(),
        domain: Domain::Point,
        width,
        values: Values::F32(values),
        indices: None,
    };
    let sums = body.points.iter().map(|[x, y, z]| x + 2.0 * y + 4.0 * z).collect();
    body.attributes.push(attribute("uv", 1, (0..24).map(|corner| corner as f32).collect()));
    body.attributes.push(attribute("heat", 1, sums));
    body.attributes.push(attribute("weights", 1, (0..24).map(|corner| corner as f32).collect()));
    let made = repaired(&body);
    assert_eq!(made.report.seam_attributes, ["uv"]);
    assert_eq!(made.report.coincident_points.count, 16);
    let [uv, heat, weights] = ["uv", "heat", "weights"].map(|name| made.mesh.attribute(name).unwrap());
    assert_eq!((uv.domain, uv.indices.as_deref()), (Domain::Corner, Some((0..24).collect::<Vec<u32>>().as_slice())));
    assert_eq!((heat.domain, weights.domain), (Domain::Point, Domain::Point));
    let Values::F32(heat) = &heat.values else { panic!("floats") };
    for ([x, y, z], heat) in made.mesh.points.iter().zip(heat) {
        assert_eq!(x + 2.0 * y + 4.0 * z, *heat);
    }
    assert_eq!(made.point_origins.len(), 8);
    assert_eq!(made.face_origins, [0, 1, 2, 3, 4, 5]);
}

#[test]
fn a_filling_continues_a_sphere_and_carries_values() {
    let mut ball = without(&sphere(32, 48), |face| face.iter().all(|point| point[2] > 0.75));
    let height = ball.points.iter().flat_map(|point| [point[0], point[2]]).collect();
    ball.attributes.push(Attribute {
        name: "uv".into(),
        domain: Domain::Point,
        width: 2,
        values: Values::F32(height),
        indices: None,
    });
    let made = repaired(&ball);
    let report = &made.report;
    assert_eq!((report.filled_holes, report.open_holes.count, report.after.euler), (1, 0, 2));
    assert!(report.filling_points > 50, "{report:?}");
    let is_new = |point: &usize| made.point_origins[*point] == u32::MAX;
    let radius = |point: usize| made.mesh.points[point].iter().map(|value| value * value).sum::<f32>().sqrt();
    let worst = (0..made.mesh.points.len()).filter(is_new).map(|point| (radius(point) - 1.0).abs()).fold(0.0, f32::max);
    assert!(worst < 0.06, "the filling is {worst} away from the sphere");
    assert!((report.after.volume - 4.0 / 3.0 * std::f64::consts::PI).abs() < 0.06, "{}", report.after.volume);
    // Values are means of values around: within their range, and along x as the points are.
    let Some(Attribute { values: Values::F32(uv), .. }) = made.mesh.attribute("uv") else { panic!("uv") };
    for point in (0..made.mesh.points.len()).filter(is_new) {
        assert!((uv[2 * point] - made.mesh.points[point][0]).abs() < 0.12);
        assert!(uv[2 * point + 1] > 0.6 && uv[2 * point + 1] < 0.8);
    }
    // Without refinement the hole is closed by the points of its edge alone; a limit leaves it open.
    let settings = RepairSettings { refine: Switch::OFF, ..RepairSettings::default() };
    let flat = repair(&Context::serial(), &ball, &settings, &mut Silent).unwrap().report;
    assert_eq!((flat.filling_points, flat.filling_faces, flat.after.euler), (0, 46, 2));
    let settings = RepairSettings { hole_edges: 47, ..RepairSettings::default() };
    let open = repair(&Context::serial(), &ball, &settings, &mut Silent).unwrap().report;
    assert_eq!((open.filled_holes, open.open_holes.count, open.after.boundary_edges), (0, 1, 48));
}

#[test]
fn long_loops_are_closed_too() {
    let tube = without(&sphere(200, 900), |face| face.iter().any(|point| point[2].abs() > 0.5));
    let settings = RepairSettings { refine: Switch::OFF, ..RepairSettings::default() };
    let report = repair(&Context::serial(), &tube, &settings, &mut Silent).unwrap().report;
    assert_eq!((report.filled_holes, report.filling_faces, report.after.euler), (2, 2 * 898, 2));
    // Two caps of radius √3/2 and a belt of height 1.
    let area = std::f64::consts::PI * (2.0 + 2.0 * 0.75);
    assert!((report.after.area / area - 1.0).abs() < 0.02, "{} of {area}", report.after.area);
}

#[test]
fn a_sheet_stays_open_and_its_hole_is_filled() {
    let sheet = grid(10, false, &[2], false);
    let torn = without(&sheet, |face| {
        face.iter().all(|point| (3.9..6.1).contains(&point[0]) && (3.9..6.1).contains(&point[1]))
    });
    let report = repaired(&torn).report;
    assert_eq!((report.holes.count, report.filled_holes, report.open_holes.count), (2, 1, 1));
    assert_eq!((report.after.boundary_edges, report.after.boundary_loops, report.after.euler), (40, 1, 1));
    assert!(!report.is_solid());
}

#[test]
fn bodies_that_touch_come_apart() {
    let (first, second) = (cuboid([0.0; 3], [1.0; 3]), cuboid([1.0, 1.0, 0.0], [2.0, 2.0, 1.0]));
    let mut random = Random(5);
    for joined in
        [together(&[first.clone(), second.clone()]), turned(&together(&[first, second]), |_| random.below(2) == 0)]
    {
        let made = repaired(&apart(&joined));
        let report = &made.report;
        assert_eq!((report.non_manifold_edges.count, report.split_points, report.after.closed_components), (1, 2, 2));
        assert_eq!((report.after.volume, report.after.points, report.after.non_manifold_edges), (2.0, 16, 0));
        // What was split is not welded again.
        let again = check(&Context::serial(), &made.mesh, &RepairSettings::default(), &mut Silent).unwrap();
        assert!(again.is_solid() && again.coincident_points.count == 0, "{again:?}");
    }
    // In one point only.
    let corner = together(&[cuboid([0.0; 3], [1.0; 3]), cuboid([1.0; 3], [2.0; 3])]);
    let made = repaired(&apart(&corner)).report;
    assert_eq!((made.non_manifold_points.count, made.split_points, made.after.points), (1, 1, 16));
}

#[test]
fn a_fin_is_cut_off() {
    let body = cuboid([0.0; 3], [1.0; 3]);
    let fin =
        Mesh::new(vec![[0.0; 3], [1.0, 0.0, 0.0], [1.0, -1.0, -1.0], [0.0, -1.0, -1.0]], vec![4], vec![0, 1, 2, 3]);
    let report = repaired(&apart(&together(&[body, fin]))).report;
    assert_eq!((report.non_manifold_edges.count, report.after.components, report.after.closed_components), (1, 2, 1));
    assert_eq!((report.after.volume, report.open_holes.count), (1.0, 1));
}

#[test]
fn shells_within_shells_keep_their_sense_or_alternate() {
    let outer = cuboid([0.0; 3], [9.0; 3]);
    let inner = cuboid([3.0; 3], [6.0; 3]);
    let volume = |mesh: &Mesh| repaired(mesh).report.after.volume;
    let hollow = |is_cavity: bool| together(&[outer.clone(), turned(&inner, |_| is_cavity)]);
    assert_eq!((volume(&hollow(true)), volume(&hollow(false))), (729.0 - 27.0, 729.0 + 27.0));
    // Inside out as a whole, and twisted.
    let inverted = repaired(&turned(&hollow(true), |face| face < 6)).report;
    assert_eq!(
        (inverted.after.volume, inverted.inverted_components.first.as_slice()),
        (702.0, &[Element::Face(0)][..])
    );
    assert_eq!(volume(&turned(&hollow(false), |face| face % 6 == 1)), 702.0);
}

#[test]
fn one_sided_strips_are_cut() {
    let (length, mut mesh) = (24, Mesh::default());
    for step in 0..length {
        let turn = TAU * step as f32 / length as f32;
        for side in [-0.3, 0.3] {
            let radius = 1.0 + side * (0.5 * turn).cos();
            mesh.points.push([radius * turn.cos(), radius * turn.sin(), side * (0.5 * turn).sin()]);
        }
        let (a, b) = (2 * step, 2 * (step + 1) % (2 * length));
        let last = u32::from(step == length - 1);
        mesh.face_sizes.push(4);
        mesh.corners.extend([a, b + last, b + 1 - last, a + 1]);
    }
    let settings = RepairSettings { fill: Switch::OFF, ..RepairSettings::default() };
    let made = repair(&Context::serial(), &mesh, &settings, &mut Silent).unwrap();
    assert_eq!((made.report.one_sided_edges.count, made.report.split_points), (1, 2));
    assert_eq!((made.report.after.euler, made.report.after.boundary_loops), (1, 1));
    let again =
        check(&Context::serial(), &made.mesh, &RepairSettings { weld: Switch::OFF, ..settings }, &mut Silent).unwrap();
    assert_eq!((again.misoriented_edges.count, again.one_sided_edges.count), (0, 0));
}

#[test]
fn points_within_the_tolerance_are_welded_and_no_chain_collapses() {
    let mut random = Random(9);
    let mut body = apart(&sphere(12, 16));
    for value in body.points.as_flattened_mut() {
        *value += 1e-4 * random.below(1000) as f32 / 1000.0;
    }
    let settings = RepairSettings { tolerance: 1e-3, ..RepairSettings::default() };
    let report = repair(&Context::serial(), &body, &settings, &mut Silent).unwrap().report;
    assert_eq!((report.after.points, report.after.euler, report.after.closed_components), (11 * 16 + 2, 2, 1));
    assert_eq!(repaired(&body).report.coincident_points.count, 0);
    // Eleven points a tenth apart, welded within 0.15: every other one stays.
    let strip: Vec<[f32; 3]> =
        (0..11).flat_map(|at| [[0.1 * at as f32, 0.0, 0.0], [0.1 * at as f32, 1.0, 0.0]]).collect();
    let quads: Vec<u32> = (0..10).flat_map(|at| [2 * at, 2 * at + 2, 2 * at + 3, 2 * at + 1]).collect();
    let settings = RepairSettings { tolerance: 0.15, ..RepairSettings::default() };
    let strip = Mesh::new(strip, vec![4; 10], quads);
    let report = repair(&Context::serial(), &strip, &settings, &mut Silent).unwrap().report;
    assert_eq!((report.after.points, report.after.faces, report.degenerate_faces.count), (12, 5, 5));
}

/// Edges without length at a loop set no scale, with which the filling would never be fine enough.
#[test]
fn loops_of_coincident_points_get_few_points() {
    let places = [[1.0, 1.0, 4.5], [0.0; 3], [0.0, 0.0, 4.5]];
    let first = [0, 0, 0, 1, 1];
    let second = [1, 0, 2, 2, 2, 2, 2, 2, 2, 2, 2, 0, 0, 0, 0, 0];
    let points = first.iter().chain(&second).map(|place| places[*place]).collect();
    // The two faces share the edge at the end of the first and the start of the second.
    let corners = (0..5).chain([4, 3]).chain(7..21).collect();
    let settings = RepairSettings { weld: Switch::OFF, hole_area: 1e9, ..RepairSettings::default() };
    let made = repair(&Context::serial(), &Mesh::new(points, vec![5, 16], corners), &settings, &mut Silent).unwrap();
    assert!(made.report.filling_points < 5000, "{:?}", made.report);
}

#[test]
fn refusals_name_what_is_wrong() {
    let body = cuboid([0.0; 3], [1.0; 3]);
    let tight = Context::new(&ContextOptions { threads: 1, memory_limit: 1000 }).unwrap();
    let failed = |context: &Context, mesh: &Mesh, settings: &RepairSettings| {
        repair(context, mesh, settings, &mut Silent).unwrap_err()
    };
    assert_eq!(failed(&tight, &body, &RepairSettings::default()).kind, ErrorKind::Memory);
    let settings = RepairSettings { tolerance: f32::NAN, ..RepairSettings::default() };
    assert!(failed(&Context::serial(), &body, &settings).to_string().contains("tolerance"));
    let uneven = Mesh { face_sizes: vec![4, 4], ..body.clone() };
    assert!(failed(&Context::serial(), &uneven, &RepairSettings::default()).to_string().contains("add up to 8"));
    let mut nothing = body.clone();
    nothing.points.iter_mut().for_each(|point| point[1] = f32::NAN);
    assert!(failed(&Context::serial(), &nothing, &RepairSettings::default()).to_string().contains("no face"));
    let mut calls = 0;
    let mut stop = |_: f32, _: &str| {
        calls += 1;
        calls < 5
    };
    assert_eq!(
        repair(&Context::serial(), &body, &RepairSettings::default(), &mut stop).unwrap_err().kind,
        ErrorKind::Cancelled
    );
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]
    /// Tori torn and twisted at random come back closed, whatever the threads.
    #[test]
    fn torn_tori_are_closed(choices in prop::collection::vec(any::<u8>(), 1..40), missing in any::<u64>()) {
        let body = grid(8, true, &choices, true);
        let mut random = Random(missing);
        let torn = without(&turned(&body, |_| random.below(2) == 0), |face| face[0][2] > 0.9);
        let made = repaired(&apart(&torn));
        prop_assert_eq!(made.report.after.boundary_edges == 0, made.report.open_holes.count == 0);
        prop_assert_eq!(made.report.after.non_manifold_edges, 0);
        prop_assert!(made.report.after.volume > 0.0);
        let two = Context::new(&ContextOptions { threads: 2, memory_limit: 0 }).unwrap();
        let again = repair(&two, &apart(&torn), &RepairSettings::default(), &mut Silent).unwrap();
        prop_assert_eq!(&again.mesh, &made.mesh);
    }
}
