//! Refits keep clusters and promises: the same source changes nothing, sculpted ones have errors that hold, others are refused.

use relievo_core::progress::Silent;
use relievo_core::{Context, ContextOptions, Mesh};
use relievo_crowd::{BuildSettings, CrowdModel};
use relievo_meshio::Model;

use crate::arm::{arm, built};
use crate::errors;

const SETTINGS: BuildSettings =
    BuildSettings { pose_distance: 0.15, cluster_triangles: 40, group_clusters: 16, pose_rate: 12.0 };

/// Moves all points of an arm.
fn moved(mut source: Model, map: impl Fn([f32; 3]) -> [f32; 3]) -> Model {
    for point in &mut source.meshes[0].mesh.points {
        *point = map(*point);
    }
    source
}

/// Bulges and ripples that the hierarchy does not know.
fn sculpted() -> Model {
    moved(arm(40, 20), |[x, y, z]| {
        let factor = 1.0 + 0.5 * (-(y - 2.0) * (y - 2.0)).exp() + 0.05 * (23.0 * y).sin();
        [factor * x, y, factor * z]
    })
}

#[test]
fn the_same_source_gives_the_same_model() {
    let model = built(40, 20);
    let (again, found) = model.refit(&Context::serial(), &arm(40, 20), &[0], &SETTINGS, &mut Silent).unwrap();
    assert_eq!(again, model);
    assert_eq!((found.grown, found.growth, found.is_rebuild_due()), (0, 1.0, false));
}

#[test]
fn errors_hold_after_sculpting_and_for_other_clips() {
    let model = built(40, 20);
    let (made, found) = model.refit(&Context::serial(), &sculpted(), &[0], &SETTINGS, &mut Silent).unwrap();
    made.check().unwrap();
    errors::check(&made, [0.02, 0.05, 0.1], 0.2);
    assert!(found.grown > 0 && found.growth > 1.0, "{found:?}");
    assert_eq!(made.character.triangles, model.character.triangles);
    let context = Context::new(&ContextOptions { threads: 3, memory_limit: 0 }).unwrap();
    assert_eq!(model.refit(&context, &sculpted(), &[0], &SETTINGS, &mut Silent).unwrap().0, made);
    // The other way round, and twice as far.
    let mut source = arm(40, 20);
    for channel in &mut source.animations[0].channels {
        channel.values.chunks_exact_mut(4).for_each(|turn| turn[2] *= -1.0);
    }
    let (made, _) = model.refit(&Context::serial(), &source, &[0], &SETTINGS, &mut Silent).unwrap();
    errors::check(&made, [0.02, 0.05, 0.1], 0.2);
}

#[test]
fn a_spiky_model_is_due_for_a_rebuild() {
    let model = CrowdModel::build(&Context::serial(), &arm(40, 20), &[0], &SETTINGS, &mut Silent).unwrap();
    let spiky = moved(arm(40, 20), |[x, y, z]| {
        let factor = 1.0 + 0.3 * (0.5 + 0.5 * (40.0 * y).sin()) * (0.5 + 0.5 * (5.0 * z.atan2(x)).cos());
        [factor * x, y, factor * z]
    });
    let (_, found) = model.refit(&Context::serial(), &spiky, &[0], &SETTINGS, &mut Silent).unwrap();
    assert!(found.is_rebuild_due(), "{found:?}");
}

#[test]
fn other_models_are_refused() {
    let model = built(12, 8);
    let refused = |source: &Model, text: &str| {
        let error = model.refit(&Context::serial(), source, &[0], &SETTINGS, &mut Silent).unwrap_err();
        assert!(error.what.contains(text), "{error}");
    };
    refused(&arm(12, 9), "other triangles");
    let mut turned = arm(12, 8);
    turned.meshes[0].mesh.corners.swap(0, 1);
    refused(&turned, "other triangles");
    // The seam opens.
    let mut torn = arm(12, 8);
    torn.meshes[0].mesh.points[9 * 3][0] += 0.1;
    refused(&torn, "no longer at the place");
    refused(&Model::from_mesh(Mesh::from_triangles(vec![[0.0; 3]; 3], &[[0, 1, 2]])), "other triangles");
}
