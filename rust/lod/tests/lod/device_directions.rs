//! Normals and tangents among the attributes of progressive meshes that are edited on a graphics device.

use std::sync::Arc;

use glam::{Quat, Vec3};
use relievo_core::{Attribute, Context, Domain, ErrorKind, Falloff, Mesh, Values};
use relievo_gpu::Device;
use relievo_lod::Progressive;
use relievo_lod::progressive::{ActiveMesh, Cut, DeviceHierarchy, DeviceLevel, Edit, Extents, Extract, View};
use relievo_testing::device;

use crate::device::at;
use crate::directions::{WIDTH, assert_turned, cuts, edit, torus, wedges};
use crate::shapes::{Triangles, lifted, two_tori};
use crate::wedges::build;

fn level_of(device: &Device, mesh: &Arc<Progressive>) -> DeviceLevel {
    let extents = Extents::new(mesh);
    let whole = DeviceHierarchy::with_surroundings(&Context::serial(), device, mesh, &extents).unwrap();
    DeviceLevel::new(&Arc::new(whole)).unwrap()
}

/// With a normal alone, not of length 1, behind another number.
fn upright((points, triangles): Triangles) -> Mesh {
    let mut mesh = Mesh::from_triangles(points, &triangles);
    let mut add = |name: &str, width: u32, value: &dyn Fn([f32; 3]) -> Vec<f32>| {
        let values = Values::F32(mesh.points.iter().flat_map(|point| value(*point)).collect());
        let (name, domain) = (name.into(), Domain::Point);
        mesh.attributes.push(Attribute { name, domain, width, values, indices: None });
    };
    add("weight", 1, &|point| vec![point[0]]);
    add("normal", 3, &|[x, y, z]| vec![0.3 * x, 0.2 * y, z + 1.5]);
    mesh
}

/// The most by which directions differ, each of length about 1, given where they begin.
fn off(made: &Extract, expected: &Extract, width: usize, places: &[usize]) -> f32 {
    assert!(made.triangles == expected.triangles && made.wedges == expected.wedges);
    let mut worst = 0.0f32;
    for (found, wanted) in made.values.chunks(width).zip(expected.values.chunks(width)) {
        for number in 0..width {
            let is_direction = places.iter().any(|first| (*first..first + 3).contains(&number));
            let difference = (found[number] - wanted[number]).abs();
            assert!(is_direction || difference == 0.0);
            worst = worst.max(difference);
        }
    }
    worst
}

#[test]
fn directions_on_a_device_turn_as_on_the_processor() {
    let Some(device) = device() else { return };
    let context = Context::serial();
    let (mut exact, mut finest, mut closed, mut turned) = (0.0f32, 0.0f32, 0.0f32, 0.0f32);
    let shapes: [(Mesh, usize, &[usize]); 3] = [
        (torus(), WIDTH, &[0, 3]),
        (upright(two_tori()), 4, &[1]),
        (upright(lifted(30, |x, y| 0.1 * (9.0 * x).sin() + y)), 4, &[1]),
    ];
    for (shape, width, places) in shapes {
        let mesh = build(&shape, 100);
        let (mut level, mut active) = (level_of(&device, &mesh), ActiveMesh::new(&mesh));
        let built = at(&device, &mut level, Cut::FINEST);
        let center = if shape.points.len() == 961 { [0.5, 0.5, 0.5] } else { [1.4, 0.0, 0.0] };
        for (faces, angle) in [(400, 0.8), (usize::MAX, -0.5), (0, 0.3)] {
            let cut = Cut::of_faces(&mesh, faces);
            active.adapt(&context, cut);
            at(&device, &mut level, cut);
            let mut edit = edit(0.7, [0.2, 0.1, 0.1], (Vec3::new(0.0, 0.6, 0.8), angle));
            edit.handles[0].region.center = center;
            level.edit(&edit).unwrap();
            active.edit(&context, &edit).unwrap();
            // With the same places on the processor there is only what roundings make of the map.
            let mut own = level.to_active(&context, &mesh).unwrap();
            for faces in [usize::MAX, 900, 600, 200, 0] {
                let cut = Cut::of_faces(&mesh, faces);
                own.adapt(&context, cut);
                let (made, expected) = (at(&device, &mut level, cut), own.extract());
                assert!(made.points == expected.points);
                exact = exact.max(off(&made, &expected, width, places));
            }
            for faces in [faces, 900, usize::MAX, 200, 0, 600] {
                let cut = Cut::of_faces(&mesh, faces);
                active.adapt(&context, cut);
                let made = at(&device, &mut level, cut);
                let most = off(&made, &active.extract(), width, places);
                // Along flat parts of a sheet, quadrics leave places of coarser levels to roundings, and so what is there.
                if shape.points.len() != 961 {
                    closed = closed.max(most);
                }
                if faces == usize::MAX {
                    finest = finest.max(most);
                    turned = turned.max(off(&made, &built, width, places));
                }
            }
        }
    }
    assert!(exact < 1e-4 && finest < 1e-3 && closed < 1e-4 && turned > 0.3, "{exact} {finest} {closed} {turned}");
}

#[test]
fn a_rigid_motion_turns_all_directions_on_a_device() {
    let Some(device) = device() else { return };
    let built = build(&torus(), 200);
    let (axis, angle) = (Vec3::new(1.0, 2.0, -2.0) / 3.0, 1.1);
    let turn = Quat::from_axis_angle(axis, angle);
    let mut edit = edit(100.0, [0.3, -0.2, 0.5], (axis, angle));
    edit.handles[0].region.falloff = Falloff::Constant;
    let (mut plain, mut level) = (level_of(&device, &built), level_of(&device, &built));
    at(&device, &mut level, Cut::BASE);
    level.edit(&edit).unwrap();
    for cut in cuts(&built) {
        let (expected, found) = (wedges(&at(&device, &mut plain, cut)), wedges(&at(&device, &mut level, cut)));
        assert_turned(turn, &found, &expected);
    }
}

#[test]
fn directions_on_a_device_depend_on_edits_alone_and_undo_gives_their_bits_back() {
    let Some(device) = device() else { return };
    let built = build(&torus(), 200);
    let cuts = cuts(&built);
    let bend = edit(0.7, [0.2, 0.1, 0.1], (Vec3::Z, 0.8));
    let mut plain = level_of(&device, &built);
    let expected: Vec<[Extract; 2]> = cuts
        .iter()
        .map(|cut| {
            let mut level = level_of(&device, &built);
            at(&device, &mut level, cuts[2]);
            level.edit(&bend).unwrap();
            [at(&device, &mut plain, *cut), at(&device, &mut level, *cut)]
        })
        .collect();
    let mut level = level_of(&device, &built);
    at(&device, &mut level, cuts[2]);
    level.edit(&bend).unwrap();
    for step in [5, 0, 3, 1, 4, 0, 5, 2] {
        assert!(at(&device, &mut level, cuts[step]) == expected[step][1], "{step}");
    }
    for ([plain, edited], cut) in expected.iter().zip(&cuts) {
        let (mut same, mut moved) = (0, 0);
        for ((before, built), (place, values)) in wedges(plain).into_iter().zip(wedges(edited)) {
            if place == before { same += usize::from(values == built) } else { moved += usize::from(values != built) }
        }
        assert!(moved > 5 && (*cut == Cut::BASE || same > 50), "{same} {moved}");
    }
    // A view has what its splits have.
    let view = View { eye: [2.1, 0.3, 0.2], pixels: 500.0, tolerance: 1e-6, outline: 1.0, planes: Vec::new() };
    let mut frame = device.frame().unwrap();
    level.adapt_to(&mut frame, &view).unwrap();
    let _ = frame.submit().unwrap();
    let seen = level.extract().unwrap();
    let finest = expected.iter().find(|[_, edited]| edited.triangles.len() == seen.triangles.len()).unwrap();
    assert!(seen == finest[1]);
    assert!(level.undo().unwrap());
    for step in [2, 5, 0, 4] {
        assert!(at(&device, &mut level, cuts[step]) == expected[step][0], "{step}");
    }
    assert!(level.redo().unwrap());
    for step in [2, 5, 0, 4] {
        assert!(at(&device, &mut level, cuts[step]) == expected[step][1], "{step}");
    }
}

#[test]
fn vertices_of_too_many_triangles_for_directions_are_refused() {
    let Some(device) = device() else { return };
    let count = 4200;
    let turn = |k: u32| std::f32::consts::TAU * k as f32 / count as f32;
    let rim = (0..count).map(|k| [turn(k).cos(), turn(k).sin(), 0.0]);
    let points = std::iter::once([0.0, 0.0, 0.5]).chain(rim).collect();
    let triangles = (0..count).map(|k| [0, 1 + k, 1 + (k + 1) % count]).collect();
    let mesh = build(&upright((points, triangles)), 4100);
    let mut level = level_of(&device, &mesh);
    at(&device, &mut level, Cut::FINEST);
    let error = level.edit(&Edit { handles: edit(2.0, [0.1; 3], (Vec3::Z, 0.0)).handles, anchors: Vec::new() });
    let error = error.unwrap_err();
    assert!(error.kind == ErrorKind::Unsupported && error.to_string().contains("4200 triangles"), "{error}");
}
