//! Normals and tangents among the attributes of edited progressive meshes.

use std::sync::Arc;

use glam::{Quat, Vec3};
use relievo_core::progress::Silent;
use relievo_core::{Attribute, Context, Domain, Falloff, Mesh, Values};
use relievo_lod::Progressive;
use relievo_lod::progressive::{ActiveMesh, BuildOptions, Cut, Edit, Extract, Handle, Region};

use crate::shapes::lifted;
use crate::wedges::{build, painted_torus};

/// Numbers of a wedge: three of a normal, four of a tangent with its side.
pub const WIDTH: usize = 7;

/// A torus with normals on points, and tangents on corners along its texture coordinates, which are mirrored on one half.
pub fn torus() -> Mesh {
    let mut mesh = painted_torus(60, 32);
    mesh.attributes.clear();
    let around = |[x, y, _]: [f32; 3]| Vec3::new(x, y, 0.0).normalize();
    let normal = |point: [f32; 3]| (Vec3::from(point) - around(point)).normalize().to_array();
    let (name, values) = ("normal".into(), mesh.points.iter().flat_map(|point| normal(*point)).collect());
    mesh.attributes.push(Attribute {
        name,
        domain: Domain::Point,
        width: 3,
        values: Values::F32(values),
        indices: None,
    });
    let tangents = mesh.corners.chunks(3).flat_map(|corners| {
        let points = [0, 1, 2].map(|side| mesh.points[corners[side] as usize]);
        let side = if points.iter().map(|point| point[2]).sum::<f32>() > 0.0 { 1.0 } else { -1.0 };
        points.into_iter().flat_map(move |point| Vec3::Z.cross(around(point)).extend(side).to_array())
    });
    let (name, values) = ("tangent".into(), Values::F32(tangents.collect()));
    mesh.attributes.push(Attribute { name, domain: Domain::Corner, width: 4, values, indices: None });
    mesh
}

pub fn cuts(mesh: &Progressive) -> Vec<Cut> {
    let few = |share: usize| Cut::of_faces(mesh, mesh.triangle_count() / share);
    vec![Cut::BASE, few(9), few(3), few(2), Cut::of_error(0.0), Cut::FINEST]
}

pub fn edit(radius: f32, translation: [f32; 3], turn: (Vec3, f32)) -> Edit {
    let region = Region { center: [1.4, 0.0, 0.0], radius, falloff: Falloff::Smooth };
    Edit { handles: vec![Handle { region, translation, axis: turn.0.to_array(), angle: turn.1 }], anchors: Vec::new() }
}

/// The place of every wedge, with its numbers.
pub fn wedges(made: &Extract) -> Vec<(Vec3, [f32; WIDTH])> {
    let mut places = vec![Vec3::ZERO; made.values.len() / WIDTH];
    for (wedge, vertex) in made.wedges.as_flattened().iter().zip(made.triangles.as_flattened()) {
        places[*wedge as usize] = made.points[*vertex as usize].into();
    }
    places.into_iter().zip(made.values.as_chunks::<WIDTH>().0.iter().copied()).collect()
}

pub fn directions(values: &[f32; WIDTH]) -> [Vec3; 2] {
    [0, 3].map(|at| Vec3::from_slice(&values[at..]))
}

/// Directions are those of wedges that were turned, and sides of tangents are the same.
pub fn assert_turned(turn: Quat, found: &[(Vec3, [f32; WIDTH])], expected: &[(Vec3, [f32; WIDTH])]) {
    assert_eq!(found.len(), expected.len());
    for ((_, found), (_, expected)) in found.iter().zip(expected) {
        for (found, expected) in directions(found).into_iter().zip(directions(expected)) {
            assert!(found.distance(turn * expected) < 1e-5, "{found} {}", turn * expected);
        }
        assert_eq!(found[WIDTH - 1].to_bits(), expected[WIDTH - 1].to_bits());
    }
}

#[test]
fn a_rigid_motion_turns_all_directions() {
    let context = Context::serial();
    let built = build(&torus(), 200);
    let (axis, angle) = (Vec3::new(1.0, 2.0, -2.0) / 3.0, 1.1);
    let turn = Quat::from_axis_angle(axis, angle);
    let mut edit = edit(100.0, [0.3, -0.2, 0.5], (axis, angle));
    edit.handles[0].region.falloff = Falloff::Constant;
    let mut active = ActiveMesh::new(&built);
    active.edit(&context, &edit).unwrap();
    let mut settled = ActiveMesh::new(&Arc::new(active.settled(&context)));
    for cut in cuts(&built) {
        let mut plain = ActiveMesh::new(&built);
        [&mut plain, &mut active, &mut settled].into_iter().for_each(|mesh| _ = mesh.adapt(&context, cut));
        let expected = wedges(&plain.extract());
        for found in [wedges(&active.extract()), wedges(&settled.extract())] {
            assert_turned(turn, &found, &expected);
        }
    }
}

#[test]
fn what_has_not_moved_keeps_its_bits_and_undo_gives_them_back() {
    let context = Context::serial();
    let built = build(&torus(), 200);
    let mut active = ActiveMesh::new(&built);
    active.adapt(&context, Cut::of_faces(&built, 900));
    active.edit(&context, &edit(0.7, [0.2, 0.1, 0.1], (Vec3::Z, 0.8))).unwrap();
    let plain = |cut: Cut| {
        let mut mesh = ActiveMesh::new(&built);
        mesh.adapt(&context, cut);
        mesh.extract()
    };
    for cut in cuts(&built) {
        active.adapt(&context, cut);
        let (found, expected) = (active.extract(), plain(cut));
        let (mut same, mut turned) = (0, 0);
        for ((place, values), (built, before)) in wedges(&found).iter().zip(wedges(&expected)) {
            if *place == built {
                same += usize::from(*values == before);
            } else {
                let [normal, tangent] = directions(values);
                assert!((normal.length() - 1.0).abs() < 1e-5 && (tangent.length() - 1.0).abs() < 1e-5);
                let [were, along] = directions(&before);
                // As far from a right angle as they were.
                assert!((normal.dot(tangent) - were.dot(along)).abs() < 1e-4);
                turned += usize::from(normal.distance(were) > 0.05);
            }
        }
        assert!(turned > 5 && (cut == Cut::BASE || same > 50), "{same} {turned}");
    }
    assert!(active.undo(&context));
    for cut in cuts(&built) {
        active.adapt(&context, cut);
        assert!(active.extract() == plain(cut));
    }
}

#[test]
fn directions_are_the_same_on_every_way_to_a_level() {
    let context = Context::serial();
    let built = build(&torus(), 200);
    let cuts = cuts(&built);
    let edited = || {
        let mut active = ActiveMesh::new(&built);
        active.adapt(&context, cuts[2]);
        active.edit(&context, &edit(0.7, [0.2, 0.1, 0.1], (Vec3::Z, 0.8))).unwrap();
        active
    };
    let expected: Vec<Extract> = cuts
        .iter()
        .map(|cut| {
            let mut active = edited();
            active.adapt(&context, *cut);
            active.extract()
        })
        .collect();
    let mut active = edited();
    let mut kept = Extract::default();
    active.update(&mut kept, true);
    for step in [5, 0, 3, 1, 4, 0, 5, 2] {
        active.adapt(&context, cuts[step]);
        let found = active.extract();
        assert_eq!(found.wedges, expected[step].wedges);
        // Levels finer than that of the edit are made anew, but for last bits as they were.
        for (one, other) in found.values.iter().zip(&expected[step].values) {
            assert!((one - other).abs() < 1e-3, "{step}: {one} {other}");
        }
        // What is written where something changed is what all of it would be.
        let update = active.update(&mut kept, false);
        let corner = |made: &Extract, face: usize, side: usize| {
            let [vertex, wedge] = [made.triangles[face][side], made.wedges[face][side]].map(|at| at as usize);
            let values = made.values[wedge * WIDTH..(wedge + 1) * WIDTH].iter().chain(&made.points[vertex]);
            values.map(|value| value.to_bits()).collect::<Vec<_>>()
        };
        let mut lists = [(&kept, update.triangles), (&found, found.triangles.len())].map(|(made, count)| {
            (0..count).map(|face| [0, 1, 2].map(|side| corner(made, face, side))).collect::<Vec<_>>()
        });
        lists.iter_mut().for_each(|list| list.sort_unstable());
        assert!(lists[0] == lists[1], "{step}");
    }
}

#[test]
fn normals_and_tangents_go_with_the_surface() {
    let context = Context::serial();
    let (points, triangles) = lifted(40, |_, _| 0.0);
    let count = points.len();
    let mut mesh = Mesh::from_triangles(points, &triangles);
    for (name, value) in [("normal", [0.0, 0.0, 1.0]), ("tangent", [1.0, 0.0, 0.0])] {
        let values = Values::F32(value.repeat(count));
        mesh.attributes.push(Attribute { name: name.into(), domain: Domain::Point, width: 3, values, indices: None });
    }
    let built = Arc::new(
        Progressive::build_mesh(&context, &mesh, &BuildOptions::default(), &Default::default(), &mut Silent).unwrap().0,
    );
    let mut active = ActiveMesh::new(&built);
    active.adapt(&context, Cut::FINEST);
    let region = Region { center: [0.5, 0.5, 0.0], radius: 0.4, falloff: Falloff::Smooth };
    let handle = Handle { region, translation: [0.0, 0.0, 0.2], axis: [0.0, 0.0, 1.0], angle: 0.0 };
    active.edit(&context, &Edit { handles: vec![handle], anchors: Vec::new() }).unwrap();
    let made = active.extract();
    let mut sums = vec![Vec3::ZERO; made.points.len()];
    for triangle in &made.triangles {
        let [a, b, c] = triangle.map(|vertex| Vec3::from(made.points[vertex as usize]));
        triangle.iter().for_each(|vertex| sums[*vertex as usize] += (b - a).cross(c - a));
    }
    let mut steepest = 1.0f32;
    for (wedge, vertex) in made.wedges.as_flattened().iter().zip(made.triangles.as_flattened()) {
        let [normal, tangent] = [0, 3].map(|at| Vec3::from_slice(&made.values[6 * *wedge as usize + at..]));
        let surface = sums[*vertex as usize].normalize();
        steepest = steepest.min(surface.z);
        // What has not moved keeps its normal, whatever is beside it.
        let most = if made.points[*vertex as usize][2] == 0.0 { 0.05 } else { 0.03 };
        assert!(normal.angle_between(surface) < most, "{normal} {surface}");
        assert!(normal.dot(tangent).abs() < 1e-5 && tangent.y.abs() < 0.06 && tangent.x > 0.6, "{tangent}");
    }
    assert!(steepest < 0.85, "{steepest}");
}
