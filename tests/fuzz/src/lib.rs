//! What the fuzz targets of mesh readers share.

use relievo_core::{Context, ContextOptions, ErrorKind, Result};
use relievo_meshio::{Model, Summary};

/// Bytes that a reader may allocate: far more than inputs of tens of kilobytes justify.
pub const MEMORY_LIMIT: u64 = 64 << 20;

/// Fails unless what a reader returned can be used without fear: indices exist, numbers are finite, and it can be
/// merged, posed and described. Only what `Mesh::check` is there to find may be wrong with its faces.
pub fn sound(read: Result<Model>) {
    let Ok(model) = read else { return };
    for part in &model.meshes {
        let mesh = &part.mesh;
        let total: u64 = mesh.face_sizes.iter().map(|size| u64::from(*size)).sum();
        assert_eq!(total, mesh.corners.len() as u64);
        assert!(mesh.corners.iter().all(|point| (*point as usize) < mesh.points.len()));
        if let Err(error) = mesh.check() {
            let allowed = ["is empty", "it has 0 corners", "it has 1 corners", "it has 2 corners", "is repeated"];
            assert!(allowed.iter().any(|allowed| error.what.ends_with(allowed)), "{error}");
        }
        assert!(part.targets.iter().all(|target| target.len() == mesh.points.len()));
    }
    let options = ContextOptions { threads: 1, memory_limit: MEMORY_LIMIT };
    let context = Context::new(&options).expect("a thread");
    let points = match Summary::of_model(&context, &model) {
        Ok(summary) => summary.points,
        Err(error) => {
            assert_eq!(error.kind, ErrorKind::Memory, "{error}");
            return;
        }
    };
    for (index, animation) in model.animations.iter().enumerate().take(4) {
        let (start, end) = animation.range();
        let pose = model.pose(&context, index, 0.5 * (start + end)).expect("an animation and a time");
        assert_eq!(pose.merged_points().len(), points);
    }
}
