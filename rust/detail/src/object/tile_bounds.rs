//! Bounds of the points and of the normals of tiles of a limit surface.

use std::cell::Cell;

use glam::DVec3;
use relievo_surface::{Cone, Surface};

use crate::geometry::hierarchy::Bounds;

/// Returns the box of the points of a tile; that of a hole is empty.
pub(crate) fn tile_bounds(surface: &Surface, tile: u32) -> Bounds {
    if surface.topology().is_hole(tile) {
        return Bounds::EMPTY;
    }
    let (low, high) = surface.tile_bounds(tile);
    Bounds { low, high }
}

/// A cone of the normals of all patches of a tile.
pub(crate) fn tile_cone(surface: &Surface, tile: u32) -> Cone {
    let mut patches = surface.patches(tile);
    if let (1, Some(patch)) = (patches.len(), patches.next()) {
        return patch.normals();
    }
    let mut cones = CONES.take();
    cones.clear();
    cones.extend(surface.patches(tile).map(|patch| patch.normals()));
    let cone = common_cone(&cones);
    CONES.set(cones);
    cone
}

thread_local! {
    /// Room for the cones of a tile's patches.
    static CONES: Cell<Vec<Cone>> = const { Cell::new(Vec::new()) };
}

/// A cone of what is in all `cones`.
fn common_cone(cones: &[Cone]) -> Cone {
    let axis = cones.iter().map(|cone| DVec3::from(cone.axis.map(f64::from))).sum::<DVec3>().normalize_or_zero();
    // The widest angle from the new axis to the rim of a cone.
    let angle = cones.iter().map(|cone| {
        let between = axis.dot(DVec3::from(cone.axis.map(f64::from))).clamp(-1.0, 1.0).acos();
        between + f64::from(cone.cosine).clamp(-1.0, 1.0).acos()
    });
    let angle = angle.fold(0.0, f64::max) + 1e-6;
    if axis == DVec3::ZERO || angle >= std::f64::consts::PI {
        return Cone::ALL;
    }
    Cone { axis: axis.as_vec3().to_array(), cosine: angle.cos() as f32 }
}
