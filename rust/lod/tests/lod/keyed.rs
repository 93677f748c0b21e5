//! Edits over time, by closed forms of what a handle does between its keys.

use std::f32::consts::PI;
use std::sync::Arc;

use glam::{Quat, Vec3};
use relievo_core::progress::Silent;
use relievo_core::{Context, Falloff};
use relievo_lod::Progressive;
use relievo_lod::progressive::{
    ActiveMesh, BuildOptions, Cut, Edit, Extents, Extract, Front, Handle, HandleKey, KeyedEdit, KeyedHandle, Region,
    View,
};

use crate::shapes::torus;

fn build() -> Arc<Progressive> {
    let (points, triangles) = torus(120, 60);
    let options = BuildOptions { faces: 60, ..BuildOptions::default() };
    Arc::new(Progressive::build(&Context::serial(), &points, &triangles, &options, &mut Silent).unwrap())
}

fn key(time: f64, translation: [f32; 3], axis: [f32; 3], angle: f32) -> HandleKey {
    HandleKey { time, translation, axis, angle }
}

const CENTER: [f32; 3] = [0.3, 0.1, -0.2];

/// Everything moves.
fn all(keys: Vec<HandleKey>) -> KeyedEdit {
    let region = Region { center: CENTER, radius: 100.0, falloff: Falloff::Constant };
    KeyedEdit { handles: vec![KeyedHandle { region, keys }], anchors: Vec::new() }
}

/// Pulls and turns a side.
pub(crate) fn side() -> KeyedEdit {
    let region = Region { center: [1.4, 0.0, 0.0], radius: 0.6, falloff: Falloff::Smooth };
    let keys = vec![
        key(1.0, [0.0; 3], [0.0, 0.0, 1.0], 0.0),
        key(2.0, [0.5, 0.0, 0.1], [1.0, 0.0, 0.0], 1.0),
        key(4.0, [0.0, 0.2, 0.0], [0.0, 0.6, 0.8], -0.5),
    ];
    let anchors = vec![Region { center: [1.2, 0.5, 0.0], radius: 0.2, falloff: Falloff::Linear }];
    KeyedEdit { handles: vec![KeyedHandle { region, keys }], anchors }
}

fn apart(a: &Extract, b: &Extract) -> f32 {
    assert_eq!(a.triangles, b.triangles);
    a.points.iter().zip(&b.points).map(|(a, b)| Vec3::from(*a).distance((*b).into())).fold(0.0, f32::max)
}

#[test]
fn between_keys_a_handle_moves_along_a_line_and_turns_about_its_middle() {
    let (mesh, context) = (build(), Context::serial());
    let (x, z) = ([1.0, 0.0, 0.0], [0.0, 0.0, 1.0]);
    let moving = all(vec![
        key(-1.0, [0.0; 3], x, 0.0),
        key(1.0, [2.0, 0.0, 0.0], z, PI / 2.0),
        key(2.0, [2.0, 1.0, 0.0], x, PI / 2.0),
        key(4.0, [2.0, 1.0, 0.0], [-1.0, 0.0, 0.0], 4.0 * PI),
    ]);
    let quarter = [z, x].map(|axis| Quat::from_axis_angle(axis.into(), PI / 2.0));
    let cases = [
        (-9.0, [0.0; 3], Quat::IDENTITY),
        (-0.5, [0.5, 0.0, 0.0], Quat::from_rotation_z(PI / 8.0)),
        (1.0, [2.0, 0.0, 0.0], quarter[0]),
        (1.25, [2.0, 0.25, 0.0], quarter[0].slerp(quarter[1], 0.25)),
        (2.0, [2.0, 1.0, 0.0], quarter[1]),
        // Whole turns count: from a quarter to two whole ones the other way.
        (3.0, [2.0, 1.0, 0.0], Quat::from_rotation_x(-7.0 * PI / 4.0)),
        (9.0, [2.0, 1.0, 0.0], Quat::IDENTITY),
    ];
    let mut active = ActiveMesh::new(&mesh);
    active.adapt(&context, Cut::FINEST);
    let rest = active.extract();
    for (time, translation, turn) in cases {
        active.pose(&context, &[(Front::Cut(Cut::BASE), moving.clone())], time).unwrap();
        for (now, before) in active.extract().points.iter().zip(&rest.points) {
            let expected =
                turn * (Vec3::from(*before) - Vec3::from(CENTER)) + Vec3::from(CENTER) + Vec3::from(translation);
            assert!(Vec3::from(*now).distance(expected) < 1e-5, "{time}: {now:?}, not {expected}");
        }
    }
    active.rest(&context);
    assert!(active.extract() == rest);
}

#[test]
fn a_part_of_a_turn_does_not_leap_over_time() {
    // From nearly a whole turn about one axis to half a turn about another.
    let moving = all(vec![key(0.0, [0.0; 3], [0.0, 0.0, 1.0], 6.0), key(1.0, [0.0; 3], [0.8, 0.6, 0.0], 3.0)]);
    let vector = |time: f64| {
        let handle = moving.at(time).unwrap().handles[0];
        Vec3::from(handle.axis) * handle.angle
    };
    assert!((0..1000).all(|step| vector(f64::from(step) / 1e3).distance(vector(f64::from(step + 1) / 1e3)) < 0.2));
    assert!(
        vector(0.0).distance(Vec3::new(0.0, 0.0, 6.0)) < 1e-5 && vector(1.0).distance(Vec3::new(2.4, 1.8, 0.0)) < 1e-5
    );
}

#[test]
fn a_pose_is_the_edit_at_its_time_and_leaves_nothing_behind() {
    let (mesh, context) = (build(), Context::serial());
    let mut active = ActiveMesh::new(&mesh);
    let extents = Extents::new(&mesh);
    let view =
        View { eye: [1.8, 0.0, 0.3], pixels: 500.0, tolerance: 3.0, outline: 1.0, planes: vec![[1.0, 0.0, 0.0, 0.0]] };
    active.adapt_to(&context, &view, &extents).unwrap();
    let fronts = [Front::Cut(Cut::of_faces(&mesh, 600)), active.front()];
    active.adapt(&context, Cut::FINEST);
    let rest = active.extract();
    for front in fronts {
        let moving = [(front.clone(), side())];
        for time in [3.0, 1.5, 2.0] {
            assert!(active.pose(&context, &moving, time).unwrap() > 10);
            let posed = active.extract();
            let mut other = ActiveMesh::new(&mesh);
            match &front {
                Front::Cut(cut) => _ = other.adapt(&context, *cut),
                Front::View(_) => _ = other.adapt_to(&context, &view, &extents).unwrap(),
            }
            other.edit(&context, &moving[0].1.at(time).unwrap()).unwrap();
            other.adapt(&context, Cut::FINEST);
            // Though the one went to the level and the other did not.
            assert!(apart(&posed, &other.extract()) < 1e-6 && apart(&posed, &rest) > 0.05);
        }
        assert_eq!((active.pose(&context, &moving, 0.0).unwrap(), active.edits()), (0, [0, 0]));
        // On top of an edit that stays.
        let (mut other, level) = (ActiveMesh::new(&mesh), Cut::of_faces(&mesh, 1500));
        let region = Region { center: [1.2, 0.3, 0.2], radius: 0.4, falloff: Falloff::Smooth };
        let handle = Handle { region, translation: [0.0, 0.1, 0.2], axis: [0.0, 0.0, 1.0], angle: 0.2 };
        for mesh in [&mut active, &mut other] {
            mesh.adapt(&context, level);
            mesh.edit(&context, &Edit { handles: vec![handle], anchors: Vec::new() }).unwrap();
            mesh.adapt(&context, Cut::FINEST);
        }
        let edited = active.extract();
        assert!(active.pose(&context, &moving, 1.7).unwrap() > 10);
        if let Front::Cut(cut) = &front {
            other.adapt(&context, *cut);
            other.edit(&context, &moving[0].1.at(1.7).unwrap()).unwrap();
            other.adapt(&context, Cut::FINEST);
            assert!(apart(&active.extract(), &other.extract()) < 1e-5);
        }
        active.rest(&context);
        assert!(active.extract() == edited && active.undo(&context) && active.extract() == rest);
        active = ActiveMesh::new(&mesh);
        active.adapt(&context, Cut::FINEST);
    }
    // Settled it is the pose; an edit is of the mesh at rest.
    active.pose(&context, &[(Front::Cut(Cut::FINEST), side())], 2.0).unwrap();
    let posed = active.extract();
    let mut settled = ActiveMesh::new(&Arc::new(active.settled(&context)));
    settled.adapt(&context, Cut::FINEST);
    assert!(apart(&settled.extract(), &posed) < 1e-5);
    let region = Region { center: [-1.4, 0.0, 0.0], radius: 0.3, falloff: Falloff::Smooth };
    let handle = Handle { region, translation: [0.0, 0.0, 0.1], axis: [0.0; 3], angle: 0.0 };
    active.edit(&context, &Edit { handles: vec![handle], anchors: Vec::new() }).unwrap();
    assert_eq!(active.edits(), [1, 0]);
    assert!(active.extract().points.iter().zip(&rest.points).all(|(now, before)| before[0] < -1.0 || now == before));
    active.pose(&context, &[(Front::Cut(Cut::FINEST), side())], 2.0).unwrap();
    assert!(active.undo(&context) && active.extract() == rest && active.edits() == [0, 1]);
}

#[test]
fn keys_that_mean_nothing_are_refused_and_the_mesh_is_at_rest() {
    let (mesh, context) = (build(), Context::serial());
    let mut active = ActiveMesh::new(&mesh);
    active.adapt(&context, Cut::FINEST);
    let rest = active.extract();
    let good = (Front::Cut(Cut::FINEST), side());
    let mut fails = |change: &dyn Fn(&mut KeyedEdit), time: f64| {
        active.pose(&context, std::slice::from_ref(&good), 2.0).unwrap();
        let mut edit = good.clone();
        change(&mut edit.1);
        let told = active.pose(&context, &[good.clone(), edit], time).unwrap_err().to_string();
        assert!(active.extract() == rest);
        told
    };
    assert!(fails(&|edit| edit.handles[0].keys.clear(), 2.0).contains("edit 1: keys of handle 0"));
    assert!(fails(&|edit| edit.handles[0].keys.swap(0, 1), 2.0).contains("later than the one before"));
    assert!(fails(&|edit| edit.handles[0].keys[1].time = f64::NAN, 2.0).contains("finite times"));
    assert!(fails(&|edit| edit.handles[0].keys[2].translation[0] = f32::NAN, 0.0).contains("handle 0"));
    assert!(fails(&|edit| edit.handles[0].keys[1].angle = 7.0, 0.0).contains("whole turn"));
    assert!(fails(&|edit| edit.anchors[0].radius = 0.0, 2.0).contains("anchor 0"));
    assert!(fails(&|edit| edit.handles[0].region.center[0] = 50.0, 2.0).contains("no vertex"));
    assert!(fails(&|_| (), f64::INFINITY).contains("no time"));
    assert!(active.pose(&context, &[], f64::NAN).is_err());
}
