//! Colliders of displaced surfaces, tessellated finely where they are met.

use glam::{DMat3, DVec3};
use relievo_core::{Context, Error, Mesh, Result};
use relievo_surface::{PatchForm, PatchView};
use relievo_tiles::tessellate::MAX_RATE;

use crate::geometry::obb::Obb;
use crate::imprint::collider::Collider;
use crate::object::DisplacedObject;

/// Bytes that a cell of a tessellated surface takes: a point and a normal, two triangles with their tile, parameters
/// and place in the hierarchy.
const CELL_BYTES: u64 = 256;

impl Collider {
    /// Makes a collider of the present shape of a displaced surface.
    ///
    /// Tiles that may be in `obb` are cut into cells whose sides are at most `edge` long there (world units), as far as
    /// a tile can be cut; the others are only as fine as their faces. `cage` has the surface's faces.
    ///
    /// # Errors
    /// Fails with `Memory` if the triangles would not fit the context's memory limit, and with `Invalid` if the points
    /// and faces of `cage` do not pass [`Mesh::check`], its faces are not those of the surface or all holes, or the
    /// triangles would have 2³² corners or more.
    pub fn of_object(context: &Context, object: &DisplacedObject, cage: &Mesh, obb: &Obb, edge: f64) -> Result<Self> {
        let topology = object.surface().topology();
        let mut rates = vec![1; topology.tile_count()];
        for tile in object.tiles_near(context, obb) {
            let length = object.surface().patches(tile).map(|patch| speed(&patch, &object.transform().matrix3));
            let cells = (length.fold(0.0, f64::max) / edge).ceil().clamp(1.0, f64::from(MAX_RATE)) as u32;
            rates[tile as usize] = cells.next_power_of_two().min(MAX_RATE);
        }
        let cells: u64 = rates.iter().map(|rate| u64::from(*rate).pow(2)).sum();
        if cells.saturating_mul(CELL_BYTES) > context.memory_limit() {
            return Err(Error::memory(format!(
                "{} triangles of a surface where it is met exceed the limit",
                2 * cells
            ))
            .advise("allow more memory or use fewer voxels"));
        }
        let faces = Mesh::new(cage.points.clone(), cage.face_sizes.clone(), cage.corners.clone());
        let displaced = object.displaced()?;
        let mesh = displaced.tessellate(context, &faces, &rates)?.mesh;
        let (triangles, points) = (mesh.triangles(), mesh.points);
        Self::new(context, points, triangles, *object.transform())
    }
}

/// A bound of the length of a patch's derivatives by the tile's parameters, after a linear map: a Bézier curve is no
/// faster than three times its longest difference.
fn speed(patch: &PatchView<'_>, map: &DMat3) -> f64 {
    let points: Vec<DVec3> = patch.points().map(|point| *map * DVec3::from(point.map(f64::from))).collect();
    let size = patch.patch.size.map(f64::from);
    if patch.patch.form == PatchForm::Gregory {
        // All control points are near the patch, which is small.
        let far = points.iter().map(|point| (*point - points[0]).length()).fold(0.0, f64::max);
        return 6.0 * far / size[0].min(size[1]);
    }
    let mut fastest: f64 = 0.0;
    for row in 0..4 {
        for k in 0..3 {
            let in_u = (points[4 * row + k + 1] - points[4 * row + k]).length() / size[0];
            let in_v = (points[4 * (k + 1) + row] - points[4 * k + row]).length() / size[1];
            fastest = fastest.max(3.0 * in_u.max(in_v));
        }
    }
    fastest
}
