//! What a repair does.

use relievo_core::parameter::Switch;

relievo_core::parameters! {
    /// The steps of a repair. A check describes the mesh as these steps find it.
    pub struct RepairSettings {
        /// Joins points at the same place.
        weld: Switch = Switch::ON, 0..=1, "";
        /// Distance within which points are joined; 0 joins points with equal coordinates only.
        tolerance: f32 = 0.0, 0.0..=1e30, "object units";
        /// Drops faces with fewer than three different points, and splits faces that touch themselves in a point.
        degenerate: Switch = Switch::ON, 0..=1, "";
        /// Drops all but the first of the faces that have the same points, whichever way they face.
        duplicates: Switch = Switch::ON, 0..=1, "";
        /// Turns faces over until neighbours agree and closed components face outwards.
        orient: Switch = Switch::ON, 0..=1, "";
        /// Splits edges of more than two faces and vertices of more than one fan of faces.
        split: Switch = Switch::ON, 0..=1, "";
        /// Fills holes.
        fill: Switch = Switch::ON, 0..=1, "";
        /// Most edges of a hole that is filled; 0 for any number.
        hole_edges: u32 = 0, 0..=u32::MAX, "";
        /// Largest area of a filling, as a share of the area of its component. It keeps sheets open.
        hole_area: f32 = 0.75, 0.0..=1e30, "";
        /// Adds points to fillings until their triangles are as large as those around the hole.
        refine: Switch = Switch::ON, 0..=1, "";
        /// Moves the added points so that the filling continues the curvature around the hole.
        fair: Switch = Switch::ON, 0..=1, "";
        /// Drops points that no face uses.
        unused: Switch = Switch::ON, 0..=1, "";
        /// Most elements of each kind that the report names.
        listed: u32 = 8, 0..=65536, "";
    }
}
