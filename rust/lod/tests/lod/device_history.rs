//! Edits on a graphics device that are taken back and made again, of meshes for views, and over time.

use std::sync::Arc;

use relievo_core::{Context, ErrorKind};
use relievo_gpu::Device;
use relievo_lod::Progressive;
use relievo_lod::progressive::{
    ActiveMesh, Cut, DeviceFront, DeviceHierarchy, DeviceLevel, Edit, Extents, Extract, View,
};
use relievo_testing::device;

use crate::device::{apart, at, build, pull, shapes};
use crate::keyed::side;

fn level_of(device: &Device, mesh: &Arc<Progressive>) -> DeviceLevel {
    let extents = Extents::new(mesh);
    let whole = DeviceHierarchy::with_surroundings(&Context::serial(), device, mesh, &extents).unwrap();
    DeviceLevel::new(&Arc::new(whole)).unwrap()
}

/// Meshes from the base to the finest.
fn all(device: &Device, level: &mut DeviceLevel, mesh: &Progressive) -> Vec<Extract> {
    [0, 200, 600, usize::MAX].map(|faces| at(device, level, Cut::of_faces(mesh, faces))).to_vec()
}

fn seen(device: &Device, level: &mut DeviceLevel, view: &View) -> Extract {
    let mut frame = device.frame().unwrap();
    level.adapt_to(&mut frame, view).unwrap();
    let _ = frame.submit().unwrap();
    level.extract().unwrap()
}

fn shifted(edit: &Edit, shift: f32) -> Edit {
    let mut edit = edit.clone();
    for handle in &mut edit.handles {
        handle.region.center = handle.region.center.map(|x| x + shift);
    }
    edit
}

#[test]
fn edits_on_a_device_are_taken_back_and_made_again_to_the_bit() {
    let Some(device) = device() else { return };
    for (shape, center) in shapes().iter().zip([[1.4, 0.0, 0.0], [0.5, 0.5, 0.0], [0.4, 0.5, 0.0], [1.4, 0.0, 0.0]]) {
        let mesh = build(shape, Vec::new());
        let mut level = level_of(&device, &mesh);
        assert!(!level.undo().unwrap() && !level.redo().unwrap());
        let mut states = vec![all(&device, &mut level, &mesh)];
        let cuts = [400, usize::MAX, 0].map(|faces| Cut::of_faces(&mesh, faces));
        for (number, cut) in cuts.into_iter().enumerate() {
            let before = at(&device, &mut level, cut);
            level.edit(&shifted(&pull(center), 0.1 * number as f32)).unwrap();
            let after = level.extract().unwrap();
            assert!(before != after);
            assert!(level.undo().unwrap() && level.extract().unwrap() == before);
            assert!(level.redo().unwrap() && level.extract().unwrap() == after);
            states.push(all(&device, &mut level, &mesh));
        }
        assert_eq!(level.edits(), [3, 0]);
        // From the level of the edit, a finer one and a coarser one.
        for faces in [None, Some(usize::MAX), Some(0)] {
            for number in (0..3).rev() {
                at(&device, &mut level, faces.map_or(cuts[number], |faces| Cut::of_faces(&mesh, faces)));
                assert!(level.undo().unwrap());
                assert_eq!(level.edits(), [number, 3 - number]);
                assert!(faces != Some(0) || level.extract().unwrap() == states[number][0]);
                assert!(all(&device, &mut level, &mesh) == states[number]);
            }
            assert!(all(&device, &mut level, &mesh) == states[0]);
            for number in 0..3 {
                at(&device, &mut level, faces.map_or(cuts[number], |faces| Cut::of_faces(&mesh, faces)));
                assert!(level.redo().unwrap());
                assert!(all(&device, &mut level, &mesh) == states[number + 1]);
            }
        }
        assert!(level.undo().unwrap());
        at(&device, &mut level, cuts[0]);
        level.edit(&pull(center)).unwrap();
        assert_eq!(level.edits(), [3, 0]);
    }
}

#[test]
fn meshes_for_views_are_edited_on_a_device_as_on_the_processor() {
    let Some(device) = device() else { return };
    let context = Context::serial();
    let view =
        View { eye: [1.8, 0.0, 0.3], pixels: 500.0, tolerance: 3.0, outline: 1.0, planes: vec![[1.0, 0.0, 0.0, -0.2]] };
    let mut same = 0;
    for (shape, center) in shapes().iter().zip([[1.4, 0.0, 0.0], [0.5, 0.5, 0.0], [0.4, 0.5, 0.0], [1.4, 0.0, 0.0]]) {
        let mesh = build(shape, Vec::new());
        let mut level = level_of(&device, &mesh);
        let mut active = ActiveMesh::new(&mesh);
        active.adapt(&context, Cut::FINEST);
        active.adapt_to(&context, &view, &Extents::new(&mesh)).unwrap();
        let before = seen(&device, &mut level, &view);
        let finest = at(&device, &mut level, Cut::FINEST);
        assert!(seen(&device, &mut level, &view) == before);
        let (edit, expected) = (pull(center), active.extract());
        let reached = level.edit(&edit).unwrap();
        let after = level.extract().unwrap();
        if before.triangles == expected.triangles {
            assert_eq!(reached, active.edit(&context, &edit).unwrap());
            assert!(apart(&after, &active.extract())[0] < 1e-5);
            for faces in [usize::MAX, 300] {
                let cut = Cut::of_faces(&mesh, faces);
                active.adapt(&context, cut);
                let [distance, along, _] = apart(&at(&device, &mut level, cut), &active.extract());
                assert!(distance < if faces == 300 { 2e-3 } else { 1e-5 } && along < 1e-4, "{distance} {along}");
            }
            same += 1;
        }
        assert!(level.undo().unwrap());
        assert!(at(&device, &mut level, Cut::FINEST) == finest && seen(&device, &mut level, &view) == before);
        assert!(level.redo().unwrap() && level.extract().unwrap() == after);
        assert!(level.undo().unwrap() && level.extract().unwrap() == before);
    }
    assert!(same > 2, "{same}");
}

#[test]
fn edits_go_to_the_processor_and_back_to_the_bit() {
    let Some(device) = device() else { return };
    let context = Context::serial();
    for (shape, center) in shapes().iter().zip([[1.4, 0.0, 0.0], [0.5, 0.5, 0.0], [0.4, 0.5, 0.0], [1.4, 0.0, 0.0]]) {
        let mesh = build(shape, Vec::new());
        let (mut level, mut other) = (level_of(&device, &mesh), level_of(&device, &mesh));
        assert!(level.to_active(&context, &mesh).unwrap().extract().points == shape.0);
        for number in 0..2 {
            at(&device, &mut level, Cut::of_faces(&mesh, [400, 1000][number]));
            level.edit(&shifted(&pull(center), 0.1 * number as f32)).unwrap();
            let shown = level.extract().unwrap();
            let mut active = level.to_active(&context, &mesh).unwrap();
            assert!(level.extract().unwrap() == shown && active.edits() == [0, 0]);
            for faces in [usize::MAX, 600, 0] {
                let cut = Cut::of_faces(&mesh, faces);
                active.adapt(&context, cut);
                assert!(active.extract().points == at(&device, &mut level, cut).points);
            }
            // The processor edits on, and so does the device.
            let mut active = level.to_active(&context, &mesh).unwrap();
            other.take(&context, &mut active).unwrap();
            assert_eq!(other.edits(), [0, 0]);
            assert!(all(&device, &mut other, &mesh) == all(&device, &mut level, &mesh));
        }
        let mut active = level.to_active(&context, &mesh).unwrap();
        active.adapt(&context, Cut::of_faces(&mesh, 300));
        active.edit(&context, &pull(center)).unwrap();
        other.take(&context, &mut active).unwrap();
        at(&device, &mut level, Cut::of_faces(&mesh, 300));
        level.edit(&pull(center)).unwrap();
        active.adapt(&context, Cut::FINEST);
        let made = at(&device, &mut other, Cut::FINEST);
        assert!(made.points == active.extract().points);
        assert!(apart(&made, &at(&device, &mut level, Cut::FINEST))[0] < 1e-5);
    }
    let [one, other] = [0, 1].map(|number| build(&shapes()[number], Vec::new()));
    let refused = level_of(&device, &one).to_active(&context, &other).err().unwrap();
    assert!(refused.kind == ErrorKind::Invalid && refused.to_string().contains("that was sent"), "{refused}");
}

#[test]
fn a_pose_on_a_device_is_the_edit_at_its_time_and_leaves_nothing_behind() {
    let Some(device) = device() else { return };
    let mesh = build(&shapes()[0], Vec::new());
    let mut level = level_of(&device, &mesh);
    assert!(level.pose(&[], 0.0).unwrap_err().to_string().contains("adapt it to a cut"));
    let view = View { eye: [1.8, 0.0, 0.3], pixels: 500.0, tolerance: 3.0, outline: 1.0, planes: Vec::new() };
    let coarse = Cut::of_faces(&mesh, 600);
    seen(&device, &mut level, &view);
    let fronts = [DeviceFront::Cut(coarse), level.front().unwrap()];
    let rest = at(&device, &mut level, Cut::FINEST);
    for front in &fronts {
        let moving = [(front.clone(), side())];
        for time in [3.0, 1.5, 2.0] {
            assert!(level.pose(&moving, time).unwrap() > 10);
            let posed = level.extract().unwrap();
            let mut other = level_of(&device, &mesh);
            match front {
                DeviceFront::Cut(cut) => _ = at(&device, &mut other, *cut),
                DeviceFront::View(_) => _ = seen(&device, &mut other, &view),
            }
            other.edit(&side().at(time).unwrap()).unwrap();
            assert!(posed == at(&device, &mut other, Cut::FINEST) && apart(&posed, &rest)[0] > 0.05);
        }
        assert_eq!((level.pose(&moving, 0.0).unwrap(), level.edits()), (0, [0, 0]));
        assert!(level.extract().unwrap() == rest);
    }
    // An edit is of the mesh at rest.
    level.pose(&[(fronts[0].clone(), side())], 2.0).unwrap();
    level.edit(&pull([-1.4, 0.0, 0.0])).unwrap();
    let edited = level.extract().unwrap();
    assert!(edited.points.iter().zip(&rest.points).all(|(now, before)| before[0] < 0.0 || now == before));
    level.pose(&[(fronts[0].clone(), side()), (fronts[0].clone(), side())], 2.0).unwrap();
    assert!(level.undo().unwrap() && level.extract().unwrap() == rest);
    // What is refused leaves it at rest.
    let mut far = side();
    far.handles[0].region.center[0] = 50.0;
    let error = level.pose(&[(fronts[0].clone(), side()), (fronts[0].clone(), far)], 2.0).unwrap_err();
    assert!(error.kind == ErrorKind::Invalid && error.to_string().contains("edit 1"), "{error}");
    assert!(level.extract().unwrap() == rest);
    let mut other = level_of(&device, &build(&shapes()[1], Vec::new()));
    at(&device, &mut other, Cut::BASE);
    assert!(other.pose(&[(fronts[1].clone(), side())], 2.0).unwrap_err().to_string().contains("another mesh"));
}
