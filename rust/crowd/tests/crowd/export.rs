//! Levels of detail as glTF, read back by readers that do not know crowds.

use glam::Vec3;
use relievo_core::Context;
use relievo_core::progress::Silent;
use relievo_crowd::{Blend, LevelSettings, skin};
use relievo_meshio::Model;

use crate::arm::built;

const SETTINGS: LevelSettings = LevelSettings { count: 4, pixels: 0.5, is_separate: false };

#[test]
fn levels_are_skinned_and_play_the_clips() {
    let (context, model) = (Context::serial(), built(40, 20));
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("levels.glb");
    let exported = model.save_levels(&path, &SETTINGS, &mut Silent).unwrap();
    assert_eq!((exported.levels.len(), exported.sheared), (4, 0));
    assert_eq!(exported.levels[0], (0.0, u64::from(model.input_triangles)));
    for pair in exported.levels.windows(2) {
        let share = pair[1].1 as f64 / pair[0].1 as f64;
        assert!(pair[1].0 > pair[0].0 && (0.05..=0.25).contains(&share), "{:?}", exported.levels);
    }
    // Every level has its triangles and the joints.
    let file = gltf::Gltf::open(&path).unwrap();
    assert_eq!(file.extensions_used().collect::<Vec<_>>(), ["MSFT_lod"]);
    let triangles: Vec<u64> =
        file.meshes().map(|mesh| mesh.primitives().map(|it| it.indices().unwrap().count() as u64 / 3).sum()).collect();
    assert_eq!(triangles, exported.levels.iter().map(|level| level.1).collect::<Vec<_>>());
    let skinned = file.nodes().filter(|node| node.mesh().is_some() && node.skin().is_some()).count();
    assert_eq!(skinned, 4);
    assert_eq!(file.skins().next().unwrap().joints().count(), model.character.bones.len());

    // The scene shows the finest level alone, in the poses of the model.
    let source = relievo_meshio::read_model(&context, &path).unwrap();
    assert_eq!(source.instances().count(), 1);
    let clip = &model.clips[0];
    let (start, end) = source.animations[0].range();
    assert_eq!(start, 0.0);
    assert!((end - clip.poses.len() as f64 / f64::from(clip.rate)).abs() < 1e-5);
    for frame in 0..=clip.poses.len() {
        let pose = &clip.poses[frame % clip.poses.len()];
        let ours = skin(&context, &model.character, pose, Blend::Linear).unwrap();
        let theirs = source.pose(&context, 0, frame as f64 / f64::from(clip.rate)).unwrap();
        let corners = &source.meshes[0].mesh.corners;
        let input: Vec<u32> =
            model.input_clusters().iter().flat_map(|cluster| model.triangles(*cluster)).flatten().copied().collect();
        assert_eq!(corners.len(), input.len());
        for (corner, vertex) in corners.iter().zip(&input) {
            let off = Vec3::from(ours[*vertex as usize]).distance(theirs.shapes[0].points[*corner as usize].into());
            assert!(off < 1e-4, "pose {frame}, vertex {vertex}: {off}");
        }
    }
    for wrong in [LevelSettings { count: 0, ..SETTINGS }, LevelSettings { pixels: f64::NAN, ..SETTINGS }] {
        assert!(model.save_levels(&path, &wrong, &mut Silent).is_err());
    }
}

#[test]
fn each_level_may_have_a_file_of_its_own() {
    let (context, model) = (Context::serial(), built(40, 20));
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("arm.glb");
    let together = model.save_levels(&path, &SETTINGS, &mut Silent).unwrap();
    let whole = relievo_meshio::read_model(&context, &path).unwrap();
    std::fs::remove_file(&path).unwrap();
    let settings = LevelSettings { is_separate: true, ..SETTINGS };
    let exported = model.save_levels(&path, &settings, &mut Silent).unwrap();
    let names = ["arm_LOD0.glb", "arm_LOD1.glb", "arm_LOD2.glb", "arm_LOD3.glb"];
    assert_eq!(exported.files, names.map(|name| folder.path().join(name)));
    assert_eq!(exported.levels, together.levels);
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 4);
    for (level, (path, (_, triangles))) in exported.files.iter().zip(&exported.levels).enumerate() {
        assert_eq!(gltf::Gltf::open(path).unwrap().extensions_used().count(), 0);
        let source = relievo_meshio::read_model(&context, path).unwrap();
        let shown: Vec<usize> = source.meshes.iter().map(|part| part.mesh.face_count()).collect();
        assert_eq!(shown, [*triangles as usize], "level {level}");
        // Nodes have other numbers where there are fewer meshes.
        let curves = |model: &Model| -> Vec<(Vec<f32>, Vec<f32>)> {
            let channels = model.animations.iter().flat_map(|animation| &animation.channels);
            channels.map(|channel| (channel.times.clone(), channel.values.clone())).collect()
        };
        assert_eq!((source.skins.len(), curves(&source)), (1, curves(&whole)));
    }
}
