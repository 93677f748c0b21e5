//! Simplification with attributes: seams stay closed, and values stay what they are on the surface.

use std::collections::{HashMap, HashSet};
use std::f32::consts::TAU;

use glam::{Vec2, Vec3};
use proptest::prelude::*;
use relievo_core::progress::Silent;
use relievo_core::{Attribute, Context, ContextOptions, Domain, Mesh, Values};
use relievo_lod::{
    AttributeOptions, Attributes, SimplifiedWith, SimplifyOptions, simplify, simplify_mesh, simplify_with, weld,
};
use relievo_testing::Random;

use crate::shapes::{Triangles, edges, lifted, torus};

/// Vertices with numbers, and triangles.
struct Mapped {
    mesh: Triangles,
    values: Vec<f32>,
    width: usize,
}

impl Mapped {
    fn run(&self, context: &Context, weights: &[f32], options: &SimplifyOptions) -> SimplifiedWith {
        let (points, triangles) = &self.mesh;
        let attributes = Attributes { values: &self.values, weights, ..Attributes::default() };
        simplify_with(context, points, triangles, &attributes, options, &mut Silent).unwrap()
    }
}

fn to(faces: usize) -> SimplifyOptions {
    SimplifyOptions { target_triangles: faces, ..SimplifyOptions::default() }
}

/// A torus unrolled into a square of texture coordinates, cut open along a ring and a section.
fn unrolled(n: u32, m: u32) -> Mapped {
    let (points, values): (Vec<_>, Vec<_>) = (0..=m)
        .flat_map(|y| (0..=n).map(move |x| [x as f32 / n as f32, y as f32 / m as f32]))
        .map(|[u, v]| {
            // The ends of a turn are the same place to the last bit.
            let (u_place, v_place) = (TAU * (u % 1.0), TAU * (v % 1.0));
            let radius = 1.0 + 0.4 * v_place.cos();
            ([radius * u_place.cos(), radius * u_place.sin(), 0.4 * v_place.sin()], [u, v])
        })
        .unzip();
    let (_, triangles) = lifted_grid(n, m);
    Mapped { mesh: (points, triangles), values: values.into_flattened(), width: 2 }
}

fn lifted_grid(n: u32, m: u32) -> Triangles {
    let squares = (0..m).flat_map(|y| (0..n).map(move |x| y * (n + 1) + x));
    (Vec::new(), squares.flat_map(|a| [[a, a + 1, a + n + 2], [a, a + n + 2, a + n + 1]]).collect())
}

/// The texture coordinates that a place on the torus has.
fn unrolled_at(place: Vec3) -> Vec2 {
    let ring = (place.x.hypot(place.y) - 1.0) / 0.4;
    let turn = |angle: f32| angle.rem_euclid(TAU) / TAU;
    Vec2::new(turn(place.y.atan2(place.x)), turn((place.z / 0.4).atan2(ring)))
}

/// Places on triangles, the numbers there, and the areas that they stand for.
fn samples(made: &SimplifiedWith, width: usize) -> impl Iterator<Item = (Vec3, Vec<f32>, f32)> {
    let mut random = Random(7);
    made.triangles.iter().flat_map(move |triangle| {
        let shares = [(); 4].map(|()| {
            let (root, across) = (random.unit().sqrt(), random.unit());
            [1.0 - root, root * (1.0 - across), root * across]
        });
        shares.map(|shares| {
            let corners = || triangle.iter().zip(shares);
            let place = corners().map(|(vertex, share)| Vec3::from(made.points[*vertex as usize]) * share).sum();
            let at = |vertex: u32, index: usize| made.values[vertex as usize * width + index];
            let number = |index| corners().map(|(vertex, share)| at(*vertex, index) * share).sum();
            let [a, b, c] = triangle.map(|vertex| Vec3::from(made.points[vertex as usize]));
            (place, (0..width).map(number).collect(), (b - a).cross(c - a).length() / 8.0)
        })
    })
}

#[test]
fn seams_of_texture_coordinates_stay_closed() {
    let mapped = unrolled(160, 80);
    let made = mapped.run(&Context::serial(), &[0.1; 2], &to(1200));
    assert!(made.triangles.len() <= 1200 && made.triangles.len() >= 1198, "{}", made.triangles.len());
    let closed = weld(&made.points, &made.triangles);
    let sides = edges(&closed.triangles);
    assert!(sides.values().all(|count| *count == 2), "no gap");
    assert_eq!(closed.points.len() + closed.triangles.len(), sides.len(), "Euler's number of a torus is 0");
    // Without welding all that is open is the outline of the square.
    let outline: Vec<_> = edges(&made.triangles).into_iter().filter(|(_, count)| *count == 1).collect();
    for vertex in outline.iter().flat_map(|(edge, _)| edge) {
        let [u, v] = [0, 1].map(|axis| made.values[2 * *vertex as usize + axis]);
        assert!([u, v].iter().any(|it| *it < 1e-3 || *it > 1.0 - 1e-3), "{u} {v}");
    }
    let around: f32 = outline
        .iter()
        .map(|([a, b], _)| {
            let [a, b] = [a, b].map(|vertex| Vec2::from_slice(&made.values[2 * *vertex as usize..]));
            a.distance(b)
        })
        .sum();
    assert!((around - 4.0).abs() < 1e-2, "{around}");
    let mut worst = 0.0f32;
    for (place, uv, _) in samples(&made, 2) {
        let difference = Vec2::from_slice(&uv) - unrolled_at(place);
        worst = worst.max((difference - difference.round()).length());
    }
    assert!(worst < 0.02, "{worst}");
}

#[test]
fn values_that_are_linear_on_a_plane_stay_so() {
    let (points, triangles) = lifted(40, |x, y| 0.5 * x - 0.25 * y);
    let field = |[x, y, _]: [f32; 3]| [x, y, 1.0 - x, 0.5 * x + 0.25 * y, y - x];
    let values: Vec<f32> = points.iter().flat_map(|point| field(*point)).collect();
    let mapped = Mapped { mesh: (points, triangles), values, width: 5 };
    let made = mapped.run(&Context::serial(), &[0.1; 5], &SimplifyOptions { max_error: 1e-5, ..to(0) });
    assert!(made.triangles.len() <= 60, "{}", made.triangles.len());
    for (point, values) in made.points.iter().zip(made.values.as_chunks::<5>().0) {
        for (value, expected) in values.iter().zip(field(*point)) {
            assert!((value - expected).abs() < 1e-4, "{value} {expected}");
        }
    }
}

#[test]
fn a_pattern_of_colours_on_a_plane_is_kept_by_its_weight() {
    let (points, triangles) = lifted(96, |_, _| 0.0);
    let color = |x: f32, y: f32| {
        let disc = (40.0 * ((x - 0.45).hypot(y - 0.55) - 0.3)).clamp(-0.5, 0.5) + 0.5;
        [disc, 1.0 - disc, 0.5 + 0.5 * (5.0 * x).sin()]
    };
    let values: Vec<f32> = points.iter().flat_map(|[x, y, _]| color(*x, *y)).collect();
    let mapped = Mapped { mesh: (points, triangles), values, width: 3 };
    let deviation = |weight: f32| {
        let made = mapped.run(&Context::serial(), &[weight; 3], &to(1000));
        assert!(made.triangles.len() <= 1000);
        assert!(made.values.iter().all(|value| (0.0..=1.0).contains(value)));
        let mut sum = 0.0;
        for (place, found, area) in samples(&made, 3) {
            let expected = color(place.x, place.y);
            sum += area * found.iter().zip(expected).map(|(a, b)| (a - b) * (a - b)).sum::<f32>();
        }
        sum.sqrt()
    };
    let (with, without) = (deviation(0.1), deviation(0.0));
    println!("root mean square {with} with weights, {without} without");
    assert!(with < 0.25 * without, "{with} {without}");
}

/// A cube of n × n squares a side, each a square of texture coordinates of its own.
fn cube(n: u32) -> Mapped {
    let (mut points, mut values, mut triangles) = (Vec::new(), Vec::new(), Vec::new());
    let (_, squares) = lifted_grid(n, n);
    for side in 0..6 {
        let first = points.len() as u32;
        for (x, y) in (0..=n).flat_map(|y| (0..=n).map(move |x| (x as f32 / n as f32, y as f32 / n as f32))) {
            let (axis, is_far) = (side % 3, side / 3 == 1);
            let (a, b) = if is_far { (x, y) } else { (y, x) };
            let mut point = [0.0; 3];
            (point[axis], point[(axis + 1) % 3], point[(axis + 2) % 3]) = (f32::from(u8::from(is_far)), a, b);
            points.push(point);
            values.extend([x / 6.0 + side as f32 / 6.0, y]);
        }
        triangles.extend(squares.iter().map(|triangle| triangle.map(|vertex| vertex + first)));
    }
    Mapped { mesh: (points, triangles), values, width: 2 }
}

#[test]
fn places_where_seams_meet_stay_with_all_their_values() {
    let cube = cube(24);
    let made = cube.run(&Context::serial(), &[0.1; 2], &SimplifyOptions { max_error: 1e-4, ..to(0) });
    assert!(made.triangles.len() <= 100, "{}", made.triangles.len());
    let closed = weld(&made.points, &made.triangles);
    assert!(edges(&closed.triangles).values().all(|count| *count == 2));
    let key = |point: &[f32; 3], values: &[f32]| (point.map(f32::to_bits), [values[0], values[1]].map(f32::to_bits));
    let kept: HashSet<_> = made.points.iter().zip(made.values.chunks(2)).map(|(point, uv)| key(point, uv)).collect();
    let mut corners = 0;
    for (point, uv) in cube.mesh.0.iter().zip(cube.values.chunks(2)) {
        if point.iter().all(|it| *it == 0.0 || *it == 1.0) {
            assert!(kept.contains(&key(point, uv)), "{point:?} {uv:?}");
            corners += 1;
        }
    }
    assert_eq!(corners, 24);
}

#[test]
fn islands_of_values_never_vanish() {
    let cube = cube(12);
    let made = cube.run(&Context::serial(), &[0.0; 2], &to(0));
    // Corners may be at the border of two, middles are not.
    let middle =
        |triangle: &[u32; 3]| triangle.iter().map(|vertex| made.values[2 * *vertex as usize]).sum::<f32>() / 3.0;
    let islands: HashSet<u32> = made.triangles.iter().map(|triangle| (middle(triangle) * 6.0) as u32).collect();
    assert!(made.triangles.len() < 60, "{}", made.triangles.len());
    assert_eq!(islands.len(), 6);
}

#[test]
fn results_with_attributes_do_not_depend_on_threads() {
    let mapped = unrolled(120, 90);
    let expected = mapped.run(&Context::serial(), &[0.1, 0.2], &to(1500));
    for threads in [2, 5] {
        let context = Context::new(&ContextOptions { threads, memory_limit: 0 }).unwrap();
        assert!(mapped.run(&context, &[0.1, 0.2], &to(1500)) == expected);
    }
}

#[test]
fn directions_stay_of_length_1() {
    let (points, triangles) = torus(90, 60);
    let normal = |[x, y, z]: [f32; 3]| (Vec3::new(x, y, z) - Vec3::new(x, y, 0.0).normalize()).normalize();
    // Seven other numbers before put them into two quads.
    let values: Vec<f32> = points
        .iter()
        .flat_map(|point| [0.0; 6].into_iter().chain([point[2]]).chain(normal(*point).to_array()))
        .collect();
    let weights: Vec<f32> = (0..10).map(|index| if index < 7 { 0.0 } else { 0.05 }).collect();
    let attributes = Attributes { values: &values, weights: &weights, directions: &[7], ..Attributes::default() };
    let made = simplify_with(&Context::serial(), &points, &triangles, &attributes, &to(1000), &mut Silent).unwrap();
    for (point, values) in made.points.iter().zip(made.values.as_chunks::<10>().0) {
        let found = Vec3::from_slice(&values[7..]);
        assert!((found.length() - 1.0).abs() < 1e-5);
        assert!(found.angle_between(normal(*point)) < 0.1, "{}", found.angle_between(normal(*point)));
        assert!((values[6] - point[2]).abs() < 0.05);
    }
}

/// The cube with texture coordinates and normals on corners, two materials on each side in halves, and heights of points.
pub fn furnished_cube(n: u32) -> Mesh {
    let Mapped { mesh: (points, triangles), values, .. } = cube(n);
    let welded = weld(&points, &triangles);
    let mut mesh = Mesh::from_triangles(welded.points, &welded.triangles);
    let side = triangles.len() as u32 / 6;
    let normal = |face: u32| {
        let outward = if face / side < 3 { -1.0 } else { 1.0 };
        [0, 1, 2].map(|axis| if face / side % 3 == axis { outward } else { 0.0 })
    };
    let normals = (0..6 * side).flat_map(|face| [normal(face); 3]).flatten().collect();
    let heights = mesh.points.iter().map(|[x, y, z]| x + y + z).collect();
    let materials = (0..6 * side).map(|face| face % side * 2 / side).collect();
    let groups = vec![0; mesh.points.len()];
    let indices = triangles.as_flattened().to_vec();
    let mut add = |name: &str, domain: Domain, width: u32, values: Values, indices: Option<Vec<u32>>| {
        mesh.attributes.push(Attribute { name: name.into(), domain, width, values, indices });
    };
    add("uv", Domain::Corner, 2, Values::F32(values), Some(indices));
    add("normal", Domain::Corner, 3, Values::F32(normals), None);
    add("material", Domain::Face, 1, Values::U32(materials), None);
    add("height", Domain::Point, 1, Values::F32(heights), None);
    add("group", Domain::Point, 1, Values::U32(groups), None);
    mesh
}

#[test]
fn attributes_of_a_mesh_stay_on_what_they_were_on() {
    let mesh = furnished_cube(16);
    let options = SimplifyOptions { max_error: 1e-4, ..to(0) };
    let attributes = AttributeOptions { weights: vec![("height".into(), 0.01)], ..AttributeOptions::default() };
    let made = simplify_mesh(&Context::serial(), &mesh, &options, &attributes, &mut Silent).unwrap();
    assert_eq!(made.left_out, ["group"]);
    let made = made.mesh;
    made.check().unwrap();
    let triangles = made.triangles();
    assert!((24..140).contains(&triangles.len()), "{}", triangles.len());
    assert!(edges(&triangles).values().all(|count| *count == 2), "points are shared");
    let floats = |name: &str| match made.attribute(name) {
        Some(Attribute { values: Values::F32(values), indices, .. }) => (values.clone(), indices.clone()),
        other => panic!("{name}: {other:?}"),
    };
    let ((uvs, uv_of), (normals, normal_of)) = (floats("uv"), floats("normal"));
    let (uv_of, normal_of) = (uv_of.unwrap(), normal_of.unwrap());
    let Some(Values::U32(materials)) = made.attribute("material").map(|it| it.values.clone()) else { panic!() };
    let mut areas = [0.0; 2];
    for (face, triangle) in triangles.iter().enumerate() {
        let [a, b, c] = triangle.map(|point| Vec3::from(made.points[point as usize]));
        let across = (b - a).cross(c - a);
        areas[materials[face] as usize] += across.length() / 2.0;
        let uv = |corner: usize| Vec2::from_slice(&uvs[2 * uv_of[3 * face + corner] as usize..]);
        let side = (2.0 * (uv(0) + uv(1) + uv(2)).x) as usize;
        for (corner, point) in [a, b, c].into_iter().enumerate() {
            let normal = Vec3::from_slice(&normals[3 * normal_of[3 * face + corner] as usize..]);
            assert!(across.normalize().dot(normal) > 0.999);
            let (x, y) = (point[(side + 1) % 3], point[(side + 2) % 3]);
            let expected = if side < 3 { Vec2::new(y, x) } else { Vec2::new(x, y) };
            let found = uv(corner) * Vec2::new(6.0, 1.0) - Vec2::X * side as f32;
            assert!(found.distance(expected) < 1e-3, "{found} {expected}");
        }
    }
    assert!((areas[0] - 3.0).abs() < 1e-3 && (areas[1] - 3.0).abs() < 1e-3, "{areas:?}");
    for (point, height) in made.points.iter().zip(floats("height").0) {
        assert!((point.iter().sum::<f32>() - height).abs() < 1e-3);
    }
    let left_out = AttributeOptions { left_out: vec!["nothing".into()], ..AttributeOptions::default() };
    let refused = simplify_mesh(&Context::serial(), &mesh, &options, &left_out, &mut Silent).unwrap_err();
    assert!(refused.to_string().contains("`nothing`"));
}

#[test]
fn points_that_are_there_for_each_side_of_a_seam_stay_so() {
    let Mapped { mesh: (points, triangles), values, .. } = cube(16);
    let mut mesh = Mesh::from_triangles(points, &triangles);
    mesh.attributes.push(Attribute {
        name: "uv".into(),
        domain: Domain::Point,
        width: 2,
        values: Values::F32(values),
        indices: None,
    });
    let options = SimplifyOptions { locked: vec![20], ..to(200) };
    let made = simplify_mesh(&Context::serial(), &mesh, &options, &AttributeOptions::default(), &mut Silent).unwrap();
    let made = made.mesh;
    made.check().unwrap();
    assert!(made.points.contains(&mesh.points[20]));
    let triangles = made.triangles();
    assert!(edges(&triangles).values().any(|count| *count == 1), "it is cut open");
    assert!(edges(&weld(&made.points, &triangles).triangles).values().all(|count| *count == 2), "and has no gap");
    assert_eq!(
        made.attribute("uv").map(|uv| (uv.domain, uv.values.len())),
        Some((Domain::Point, 2 * made.points.len()))
    );
}

#[test]
fn more_triangles_are_left_where_factors_are_greater() {
    let (points, triangles) = torus(120, 60);
    let factors: Vec<f32> = points.iter().map(|[x, ..]| if *x > 0.0 { 100.0 } else { 1.0 }).collect();
    let count = |factors: Vec<f32>| {
        let options = SimplifyOptions { vertex_weights: factors, ..to(1400) };
        let made = simplify(&Context::serial(), &points, &triangles, &options, &mut Silent).unwrap();
        made.triangles.iter().filter(|it| it.iter().all(|vertex| made.points[*vertex as usize][0] > 0.0)).count()
    };
    let (even, uneven) = (count(Vec::new()), count(factors));
    assert!((600..760).contains(&even) && uneven > 1000, "{even} {uneven}");
    assert_eq!(count(vec![2.0; points.len()]), even);
}

#[test]
fn no_collapse_turns_a_triangle_over_in_a_texture() {
    // So rough that vertices move aside by more than a square.
    let rough = |x: f32, y: f32| 0.06 * ((91.0 * x + 47.0 * y).sin() + (113.0 * y - 29.0 * x).cos());
    let (points, triangles) = lifted(60, rough);
    let values: Vec<f32> = points.iter().flat_map(|[x, y, _]| [*x, *y]).collect();
    let turned = |uvs: &[usize]| {
        let attributes = Attributes { values: &values, weights: &[0.0; 2], uvs, ..Attributes::default() };
        let made = simplify_with(&Context::serial(), &points, &triangles, &attributes, &to(700), &mut Silent).unwrap();
        assert!((699..=700).contains(&made.triangles.len()));
        let at = |vertex: u32| Vec2::from_slice(&made.values[2 * vertex as usize..]);
        let is_turned = |[a, b, c]: &&[u32; 3]| (at(*b) - at(*a)).perp_dot(at(*c) - at(*a)) <= 0.0;
        made.triangles.iter().filter(is_turned).count()
    };
    assert!(turned(&[]) > 0);
    assert_eq!(turned(&[0]), 0);
}

#[test]
fn nothing_to_do_changes_no_number() {
    let mapped = unrolled(12, 8);
    let made = mapped.run(&Context::serial(), &[1.0; 2], &to(1000));
    assert_eq!(made.triangles, mapped.mesh.1);
    assert_eq!((made.points, made.values), (mapped.mesh.0.clone(), mapped.values.clone()));
    assert_eq!(made.origins, (0..mapped.mesh.1.len() as u32).collect::<Vec<_>>());
}

#[test]
fn bad_attributes_are_refused() {
    let (points, triangles) = torus(8, 6);
    let fails = |values: &[f32], weights: &[f32], directions: &[usize]| {
        let attributes = Attributes { values, weights, directions, ..Attributes::default() };
        let made = simplify_with(&Context::serial(), &points, &triangles, &attributes, &to(9), &mut Silent);
        made.unwrap_err().to_string()
    };
    assert!(fails(&[0.0; 95], &[1.0; 2], &[]).contains("95 numbers"));
    let mut values = [0.0; 96];
    values[31] = f32::INFINITY;
    assert!(fails(&values, &[1.0; 2], &[]).contains("vertex 15"));
    assert!(fails(&[0.0; 48 * 17], &[1.0; 17], &[]).contains("17"));
    assert!(fails(&[0.0; 96], &[1.0, f32::NAN], &[]).contains("NaN"));
    assert!(fails(&[0.0; 96], &[1.0, -1.0], &[]).contains("-1"));
    assert!(fails(&[0.0; 48 * 3], &[1.0; 3], &[1]).contains("direction"));
    assert!(fails(&[0.0; 48 * 3], &[1.0; 3], &[usize::MAX]).contains("direction"));
    let attributes = Attributes { values: &[0.0; 48], weights: &[1.0], uvs: &[0], ..Attributes::default() };
    let made = simplify_with(&Context::serial(), &points, &triangles, &attributes, &to(9), &mut Silent);
    assert!(made.unwrap_err().to_string().contains("texture coordinates"));
}

proptest! {
    #[test]
    fn random_triangles_with_values_do_no_harm(
        points in prop::collection::vec((prop::array::uniform3(-2i8..2), 0u8..3), 3..40),
        picks in prop::collection::vec(prop::array::uniform3(any::<u16>()), 1..160),
        faces in 0usize..40,
    ) {
        let count = points.len() as u32;
        let triangles: Vec<[u32; 3]> = picks.iter().map(|pick| pick.map(|it| u32::from(it) % count)).collect();
        let values = points.iter().map(|(_, value)| f32::from(*value)).collect();
        let points: Vec<[f32; 3]> = points.iter().map(|(point, _)| point.map(f32::from)).collect();
        let mapped = Mapped { mesh: (points, triangles), values, width: 1 };
        let made = mapped.run(&Context::serial(), &[0.5], &to(faces));
        prop_assert!(made.triangles.as_flattened().iter().all(|vertex| (*vertex as usize) < made.points.len()));
        prop_assert_eq!(made.values.len(), made.points.len() * mapped.width);
        prop_assert!(made.values.iter().all(|value| (0.0..=2.0).contains(value)));
        let [before, after]: [HashMap<_, _>; 2] = [
            edges(&weld(&mapped.mesh.0, &mapped.mesh.1).triangles),
            edges(&weld(&made.points, &made.triangles).triangles),
        ];
        let most = before.values().max().copied().unwrap_or(0).max(2);
        prop_assert!(after.values().all(|count| *count <= most));
    }
}

#[test]
fn a_mesh_without_attributes_is_welded_and_keeps_locked_points() {
    let (points, triangles) = torus(30, 16);
    // Every triangle has points of its own.
    let apart: Vec<[f32; 3]> = triangles.iter().flatten().map(|corner| points[*corner as usize]).collect();
    let corners: Vec<[u32; 3]> = (0..triangles.len() as u32).map(|at| [3 * at, 3 * at + 1, 3 * at + 2]).collect();
    let mesh = Mesh::from_triangles(apart.clone(), &corners);
    let options = SimplifyOptions { target_triangles: 200, locked: vec![7], ..Default::default() };
    let made = simplify_mesh(&Context::serial(), &mesh, &options, &AttributeOptions::default(), &mut Silent).unwrap();
    let left = made.mesh.triangles();
    assert!((150..=200).contains(&left.len()) && made.error > 0.0, "{} {}", left.len(), made.error);
    assert!(edges(&left).values().all(|count| *count == 2));
    assert!(made.mesh.points.contains(&apart[7]));
}
