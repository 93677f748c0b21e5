//! Meshes on a graphics device, against the processor's.

use std::sync::Arc;

use glam::Vec3;
use relievo_core::progress::Silent;
use relievo_core::{Context, ErrorKind, Falloff};
use relievo_gpu::Device;
use relievo_lod::Progressive;
use relievo_lod::progressive::{
    ActiveMesh, BuildOptions, Cut, DeviceHierarchy, DeviceLevel, Edit, Extents, Extract, Handle, Region, View,
};
use relievo_testing::device;

use crate::attributes::furnished_cube;
use crate::shapes::{Triangles, lifted, torus, two_tori};
use crate::wedges;

pub fn shapes() -> [Triangles; 4] {
    let bumps = lifted(40, |x, y| 0.1 * (9.0 * x).sin() * (7.0 * y).cos() + 0.02 * (40.0 * x * y).sin());
    [torus(120, 60), bumps, lifted(30, |_, _| 0.0), two_tori()]
}

pub fn build((points, triangles): &Triangles, locked: Vec<u32>) -> Arc<Progressive> {
    let options = BuildOptions { faces: 60, locked };
    Arc::new(Progressive::build(&Context::serial(), points, triangles, &options, &mut Silent).unwrap())
}

pub fn at(device: &Device, level: &mut DeviceLevel, cut: Cut) -> Extract {
    let mut frame = device.frame().unwrap();
    level.adapt(&mut frame, cut).unwrap();
    let _ = frame.submit().unwrap();
    level.extract().unwrap()
}

#[test]
fn levels_on_a_device_are_those_of_the_processor() {
    let Some(device) = device() else { return };
    let context = Context::serial();
    for shape in shapes() {
        // In the last case hardly a split is left, and most of the base are vertices of the input.
        for locked in [Vec::new(), (0..shape.0.len() as u32).filter(|vertex| vertex % 7 != 0).collect()] {
            let mesh = build(&shape, locked);
            let hierarchy = Arc::new(DeviceHierarchy::new(&device, &mesh).unwrap());
            assert!(hierarchy.bytes() < 46 * shape.1.len());
            let mut level = DeviceLevel::new(&hierarchy).unwrap();
            let mut active = ActiveMesh::new(&mesh);
            let faces = [0, 61, 333, 1500].map(|faces| Cut::of_faces(&mesh, faces));
            let errors = [0.0, 1e-3, 0.02, 0.1].map(Cut::of_error);
            let cuts = faces.into_iter().chain(errors).chain([Cut::FINEST, Cut::BASE]);
            for cut in cuts {
                active.adapt(&context, cut);
                let made = at(&device, &mut level, cut);
                assert!(made == active.extract(), "{cut:?}");
                assert_eq!(level.counts().unwrap(), [active.vertex_count(), active.triangle_count(), 0]);
            }
            let finest = at(&device, &mut level, Cut::FINEST);
            assert!(finest.points == shape.0 && finest.triangles == shape.1);
        }
    }
}

#[test]
fn attributes_on_a_device_are_those_of_the_processor() {
    let Some(device) = device() else { return };
    let context = Context::serial();
    for mesh in [furnished_cube(16), wedges::painted_torus(60, 32)] {
        let built = wedges::build(&mesh, 60);
        let mut file = Vec::new();
        built.write(&context, &mut file).unwrap();
        let coarse = Arc::new(Progressive::read(&context, &mut file.as_slice(), 900).unwrap());
        for mesh in [built, coarse] {
            let extents = Extents::new(&mesh);
            let hierarchy = Arc::new(DeviceHierarchy::with_surroundings(&context, &device, &mesh, &extents).unwrap());
            let mut level = DeviceLevel::new(&hierarchy).unwrap();
            let mut active = ActiveMesh::new(&mesh);
            let faces = [0, 100, 333, 1500].map(|faces| Cut::of_faces(&mesh, faces));
            for cut in faces.into_iter().chain([Cut::of_error(0.02), Cut::FINEST, Cut::BASE]) {
                active.adapt(&context, cut);
                let expected = active.extract();
                assert!(at(&device, &mut level, cut) == expected && !expected.values.is_empty(), "{cut:?}");
            }
            let view = View { eye: [2.1, 0.3, 0.2], pixels: 500.0, tolerance: 3.0, outline: 1.0, planes: Vec::new() };
            active.adapt_to(&context, &view, &extents).unwrap();
            let mut frame = device.frame().unwrap();
            level.adapt_to(&mut frame, &view).unwrap();
            let _ = frame.submit().unwrap();
            assert!(level.extract().unwrap() == active.extract());
        }
    }
}

/// How near to a limit of a view a split is, as a share, that may be made or not.
const MARGIN: f32 = 1e-5;

#[test]
fn views_on_a_device_are_those_of_the_processor() {
    let Some(device) = device() else { return };
    let context = Context::serial();
    let everything = View { eye: [1.8, 0.0, 0.3], pixels: 500.0, tolerance: 3.0, outline: 1.0, planes: Vec::new() };
    let views = [
        everything.clone(),
        View { tolerance: 0.3, ..everything.clone() },
        View { eye: [-0.4, 0.5, 6.0], tolerance: 2.0, outline: 8.0, ..everything.clone() },
        View { planes: vec![[0.6, 0.8, 0.0, -0.3], [0.0, 0.0, 1.0, 0.05]], ..everything.clone() },
        View { eye: [400.0, 0.0, 0.0], ..everything },
    ];
    let mut same = 0;
    for shape in shapes() {
        let mesh = build(&shape, Vec::new());
        let extents = Extents::new(&mesh);
        let hierarchy = Arc::new(DeviceHierarchy::with_surroundings(&context, &device, &mesh, &extents).unwrap());
        let plain = DeviceHierarchy::new(&device, &mesh).unwrap();
        let bytes = [plain.bytes(), hierarchy.bytes()].map(|bytes| bytes / shape.1.len());
        assert!((30..46).contains(&bytes[0]) && (bytes[0] + 20..110).contains(&bytes[1]), "{bytes:?}");
        let mut level = DeviceLevel::new(&hierarchy).unwrap();
        let after_finest = |view: &View| {
            let mut active = ActiveMesh::new(&mesh);
            active.adapt(&context, Cut::FINEST);
            active.adapt_to(&context, view, &extents).unwrap();
            active.extract()
        };
        for view in &views {
            let mut frame = device.frame().unwrap();
            level.adapt_to(&mut frame, view).unwrap();
            let _ = frame.submit().unwrap();
            let made = level.extract().unwrap();
            // Splits within the margin that roundings have may be made or not.
            let limit = |share: f32| {
                let moved = |plane: &[f32; 4]| [plane[0], plane[1], plane[2], plane[3] - share * 4.0];
                let planes = view.planes.iter().map(moved).collect();
                after_finest(&View { tolerance: view.tolerance * (1.0 + share), planes, ..view.clone() })
            };
            let [fewest, most] = [MARGIN, -MARGIN].map(limit);
            let count = made.triangles.len();
            assert!(fewest.triangles.len() <= count && count <= most.triangles.len(), "{count} {view:?}");
            if fewest.triangles.len() == most.triangles.len() {
                assert!(made == after_finest(view), "{view:?}");
                same += 1;
            }
        }
    }
    assert!(same > 12, "{same}");
    let plain = Arc::new(DeviceHierarchy::new(&device, &build(&shapes()[1], Vec::new())).unwrap());
    let mut level = DeviceLevel::new(&plain).unwrap();
    let mut frame = device.frame().unwrap();
    assert_eq!(level.adapt_to(&mut frame, &views[0]).unwrap_err().kind, ErrorKind::Invalid);
}

/// How far points of the same number are apart at most, how far along the normal, and how far normals are.
pub fn apart(one: &Extract, other: &Extract) -> [f32; 3] {
    let mut worst = [0.0f32; 3];
    for index in 0..one.points.len() {
        let vectors = |mesh: &Extract| [mesh.points[index], mesh.normals[index]].map(Vec3::from);
        let ([point, normal], [expected, upright]) = (vectors(one), vectors(other));
        let off = point - expected;
        let differences = [off.length(), off.dot(upright).abs(), normal.distance(upright)];
        worst = [0, 1, 2].map(|what| worst[what].max(differences[what]));
    }
    worst
}

/// What pulls and turns about a place, with something that holds beside it.
pub fn pull(center: [f32; 3]) -> Edit {
    let region = |shift: f32, radius: f32, falloff| Region { center: center.map(|x| x + shift), radius, falloff };
    let handle = |region, angle| Handle { region, translation: [0.05, 0.1, 0.2], axis: [0.0, 0.6, 0.8], angle };
    let handles = vec![
        handle(region(0.0, 0.5, Falloff::Smooth), 0.7),
        handle(region(0.1, 0.6, Falloff::Gaussian), -0.3),
        handle(region(-0.2, 0.3, Falloff::Sphere), 0.0),
    ];
    Edit { handles, anchors: vec![region(0.3, 0.4, Falloff::Linear)] }
}

#[test]
fn edits_on_a_device_are_followed_as_on_the_processor() {
    let Some(device) = device() else { return };
    let context = Context::serial();
    let (mut finest, mut worst, mut moved) = (0.0f32, [0.0f32; 3], 0.0f32);
    for (shape, center) in shapes().iter().zip([[1.4, 0.0, 0.0], [0.5, 0.5, 0.0], [0.4, 0.5, 0.0], [1.4, 0.0, 0.0]]) {
        let mesh = build(shape, Vec::new());
        let extents = Extents::new(&mesh);
        let hierarchy = Arc::new(DeviceHierarchy::with_surroundings(&context, &device, &mesh, &extents).unwrap());
        let mut level = DeviceLevel::new(&hierarchy).unwrap();
        let mut active = ActiveMesh::new(&mesh);
        // An edit in the middle, one of a finer level on top of it, one of the base.
        for (faces, shift) in [(400, 0.0), (usize::MAX, 0.1), (0, -0.1)] {
            let cut = Cut::of_faces(&mesh, faces);
            active.adapt(&context, cut);
            at(&device, &mut level, cut);
            let edit = pull(center.map(|x: f32| x + shift));
            assert_eq!(level.edit(&edit).unwrap(), active.edit(&context, &edit).unwrap());
            for faces in [faces, 900, usize::MAX, 200, 0, 600] {
                let cut = Cut::of_faces(&mesh, faces);
                active.adapt(&context, cut);
                let (made, expected) = (at(&device, &mut level, cut), active.extract());
                assert!(made.triangles == expected.triangles);
                let differences = apart(&made, &expected);
                worst = [0, 1, 2].map(|what| worst[what].max(differences[what]));
                if faces == usize::MAX {
                    finest = finest.max(differences[0]);
                    let built = Extract { points: shape.0.clone(), ..expected };
                    moved = moved.max(apart(&made, &built)[0]);
                }
            }
        }
    }
    // Quadrics leave places along flat parts of a surface open; those of coarser levels are where roundings put them.
    let [distance, along, normals] = worst;
    assert!(finest < 1e-5 && along < 1e-4 && distance < 2e-3 && normals < 2e-3, "{finest} {worst:?}");
    assert!(moved > 0.2, "{moved}");
}

#[test]
fn views_of_edited_meshes_on_a_device_are_those_of_the_processor() {
    let Some(device) = device() else { return };
    let context = Context::serial();
    let view = View { eye: [1.8, 0.0, 0.3], pixels: 500.0, tolerance: 1.0, outline: 1.0, planes: Vec::new() };
    let views = [
        view.clone(),
        View { eye: [-0.4, 0.5, 6.0], outline: 8.0, ..view.clone() },
        View { planes: vec![[0.6, 0.8, 0.0, -0.3]], ..view },
    ];
    let (mut same, mut far) = (0, 0.0f32);
    for (shape, center) in shapes().iter().zip([[1.4, 0.0, 0.0], [0.5, 0.5, 0.0], [0.4, 0.5, 0.0], [1.4, 0.0, 0.0]]) {
        let mesh = build(shape, Vec::new());
        let extents = Extents::new(&mesh);
        let hierarchy = Arc::new(DeviceHierarchy::with_surroundings(&context, &device, &mesh, &extents).unwrap());
        let (mut level, mut active) = (DeviceLevel::new(&hierarchy).unwrap(), ActiveMesh::new(&mesh));
        // An edit of a coarse level is seen from one view, then one of a finer level from others.
        for (faces, views) in [(300, &views[..1]), (700, &views)] {
            let cut = Cut::of_faces(&mesh, faces);
            active.adapt(&context, cut);
            at(&device, &mut level, cut);
            level.edit(&pull(center)).unwrap();
            active.edit(&context, &pull(center)).unwrap();
            for view in views {
                let mut frame = device.frame().unwrap();
                level.adapt_to(&mut frame, view).unwrap();
                let _ = frame.submit().unwrap();
                let made = level.extract().unwrap();
                let mut seen = |share: f32| {
                    active.adapt(&context, Cut::FINEST);
                    let planes = view.planes.iter().map(|[x, y, z, d]| [*x, *y, *z, d - 4.0 * share]).collect();
                    let view = View { tolerance: view.tolerance * (1.0 + share), planes, ..view.clone() };
                    active.adapt_to(&context, &view, &extents).unwrap();
                    active.extract()
                };
                let [fewest, expected, most] = [1e-3, 0.0, -1e-3].map(&mut seen);
                let count = made.triangles.len();
                let range = fewest.triangles.len()..=most.triangles.len();
                assert!(range.contains(&count), "{count} of {range:?} {view:?}");
                if fewest.triangles.len() == most.triangles.len() {
                    assert!(made.triangles == expected.triangles, "{view:?}");
                    let [distance, ..] = apart(&made, &expected);
                    far = far.max(distance);
                    same += 1;
                }
            }
        }
    }
    assert!(same > 4 && far < 2e-3, "{same} {far}");
}

#[test]
fn edits_that_a_device_cannot_make_are_refused_and_change_nothing() {
    let Some(device) = device() else { return };
    let context = Context::serial();
    let mesh = build(&shapes()[1], Vec::new());
    let extents = Extents::new(&mesh);
    let hierarchy = Arc::new(DeviceHierarchy::with_surroundings(&context, &device, &mesh, &extents).unwrap());
    let mut level = DeviceLevel::new(&hierarchy).unwrap();
    let edit = pull([0.5, 0.5, 0.0]);
    assert!(level.edit(&edit).unwrap_err().to_string().contains("adapt it to a cut"));
    let before = at(&device, &mut level, Cut::of_error(0.01));
    assert!(level.edit(&pull([9.0; 3])).unwrap_err().to_string().contains("no vertex"));
    let none = Edit { handles: Vec::new(), anchors: edit.anchors.clone() };
    assert!(level.edit(&none).unwrap_err().to_string().contains("no vertex"));
    let mut far = edit.clone();
    far.handles[0].translation = [f32::MAX; 3];
    far.handles[1].translation = [f32::MAX; 3];
    assert!(level.edit(&far).unwrap_err().to_string().contains("where there is no number"));
    far.handles[0].region.radius = 0.0;
    assert_eq!(level.edit(&far).unwrap_err().kind, ErrorKind::Invalid);
    assert!(at(&device, &mut level, Cut::of_error(0.01)) == before);
    let plain = Arc::new(DeviceHierarchy::new(&device, &mesh).unwrap());
    let mut level = DeviceLevel::new(&plain).unwrap();
    at(&device, &mut level, Cut::BASE);
    assert!(level.edit(&edit).unwrap_err().to_string().contains("without what edits need"));
}

#[test]
fn the_beginning_of_a_file_has_the_levels_of_the_processor() {
    let Some(device) = device() else { return };
    let context = Context::serial();
    let mut file = Vec::new();
    build(&torus(200, 130), Vec::new()).write(&context, &mut file).unwrap();
    let coarse = Arc::new(Progressive::read(&context, &mut file.as_slice(), 10_000).unwrap());
    let extents = Extents::new(&coarse);
    let hierarchy = Arc::new(DeviceHierarchy::with_surroundings(&context, &device, &coarse, &extents).unwrap());
    let mut level = DeviceLevel::new(&hierarchy).unwrap();
    let mut active = ActiveMesh::new(&coarse);
    for cut in [Cut::of_faces(&coarse, 1000), Cut::FINEST, Cut::BASE] {
        active.adapt(&context, cut);
        assert!(at(&device, &mut level, cut) == active.extract(), "{cut:?}");
    }
}
