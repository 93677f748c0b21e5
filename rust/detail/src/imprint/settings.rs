//! The settings of imprints, the moment that turns their voxel grids, and the report on what they did.

use std::borrow::Borrow;

use relievo_core::Context;

use crate::imprint::dents::Limits;
use crate::imprint::rim::Volumes;
use crate::paint::report::unite;

relievo_core::parameters! {
    /// How colliders imprint themselves.
    pub struct ImprintSettings {
        /// Voxels an overlap is divided into at most; one bit each.
        voxels: u32 = 16_777_216, 4096..=1_073_741_824u32, "";
        /// Largest random turn of the voxel grid per frame, about each axis. It spreads the steps of the voxels.
        jitter: f32 = std::f32::consts::PI / 32.0, 0.0..=0.8, "rad";
        /// Seed of the random turns.
        seed: u32 = 0, 0..=u32::MAX, "";
        /// Largest distance by which a surface may be displaced inwards. Boxes are enlarged by it.
        max_displacement: f32 = 1.0, 0.0..=60000.0, "object units";
        /// Share of the penetration that the surface gives way to.
        share: f32 = 1.0, 0.0..=1.0, "";
        /// Largest distance by which a surface gives way in one frame.
        depth_limit: f32 = 60000.0, 0.0..=60000.0, "object units";
        /// Strength of the smoothing of what an imprint changed, 0 for none.
        smoothing: f32 = 0.0, 0.0..=1.0, "";
        /// Passes of the smoothing.
        smoothing_passes: u32 = 1, 1..=64, "";
        /// Most sub-steps of a frame.
        sub_steps: u32 = 256, 1..=4096, "";
        /// Whether surfaces are culled against the overlap (1) or looked at as a whole (0). Triangle meshes always are.
        culling: u32 = 1, 0..=1, "";
        /// Whether only changed tiles are updated (1) or all allocated ones (0). Triangle meshes always do the first.
        compaction: u32 = 1, 0..=1, "";
        /// Share of the pushed volume that rises around the contact, 0 for no rim.
        rim: f32 = 0.0, 0.0..=1.0, "";
        /// Distance from the contact at which a rim ends.
        rim_width: f32 = 0.1, 1e-4..=60000.0, "object units";
        /// Steepest slope of a rim; what would make it steeper is lost.
        repose: f32 = 0.6, 0.01..=1.5, "rad";
    }
}

impl ImprintSettings {
    /// What limits the displacement update.
    pub fn limits(&self) -> Limits {
        Limits { share: self.share, max_displacement: self.max_displacement, depth: self.depth_limit }
    }
}

/// Which imprint this is, for the random turn of its grid.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Moment {
    /// The frame.
    pub frame: u64,
    /// The sub-step of the frame.
    pub step: u32,
    /// The pair of objects.
    pub pair: u32,
}

/// What an imprint did.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Report {
    /// Tiles that were ray cast.
    pub tested_tiles: u64,
    /// Coefficients that were ray cast.
    pub tested_coefficients: u64,
    /// Tiles of which coefficients changed, ascending.
    pub changed: Vec<u32>,
    /// Coefficients that changed.
    pub changed_coefficients: u64,
    /// Tiles that were newly allocated, neighbours included.
    pub allocated: u64,
    /// Tiles that the budget refused, ascending.
    pub refused: Vec<u32>,
    /// Rays that left the grid inside the collider and were held at its border.
    pub clamped: u64,
    /// Triangles that were voxelised.
    pub triangles: u64,
    /// Edges of the collider that no edge in the opposite direction meets.
    pub open_edges: u64,
    /// The longest distance inside a voxel, world units.
    pub voxel_diagonal: f64,
    /// What was pushed away and what rose as a rim; counted only where a rim is asked for.
    pub volumes: Volumes,
    /// Bytes of the allocated tiles afterwards.
    pub bytes: u64,
    /// Imprints that were made.
    pub sub_steps: u64,
    /// Imprints that the motion needs for a track without gaps, where it was a motion; more than were made if the
    /// settings do not allow them.
    pub sub_steps_wanted: u64,
}

impl Report {
    /// Makes the report of an imprint that changed nothing so far.
    pub(crate) fn before(bytes: u64, open_edges: u64) -> Self {
        Self { bytes, open_edges, sub_steps: 1, ..Self::default() }
    }

    /// Adds what another imprint did afterwards.
    pub fn merge(&mut self, other: impl Borrow<Self>) {
        let other = other.borrow();
        self.tested_tiles += other.tested_tiles;
        self.tested_coefficients += other.tested_coefficients;
        unite(&mut self.changed, &other.changed);
        self.changed_coefficients += other.changed_coefficients;
        self.allocated += other.allocated;
        unite(&mut self.refused, &other.refused);
        self.clamped += other.clamped;
        self.triangles += other.triangles;
        self.open_edges = self.open_edges.max(other.open_edges);
        self.voxel_diagonal = self.voxel_diagonal.max(other.voxel_diagonal);
        self.volumes += other.volumes;
        self.bytes = other.bytes;
        self.sub_steps += other.sub_steps;
        self.sub_steps_wanted += other.sub_steps_wanted;
    }

    /// Gives the room of its lists back to the context that the imprint was made with.
    pub fn give_back(self, context: &Context) {
        [self.changed, self.refused].into_iter().for_each(|list| context.scratch().keep_list(list));
    }
}
