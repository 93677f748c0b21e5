//! The cluster hierarchy of a character (Sections 4.2 and 4.3), and what is drawn at an allowed error.
//!
//! The paper joins two clusters and simplifies both together, so that the border between two branches stays as fine as
//! the input up to the root. Here groups of 4 to 16 clusters are simplified together and divided into clusters anew,
//! so that borders differ from level to level. Places on the border of a group stay while it is simplified. Once the surface
//! has at most the triangles of ten full groups, it is one group without a border. The clusters
//! of a group are either all drawn coarse or all fine, and a group is coarse only if all below it are, because errors and
//! boxes grow upwards. That makes every cut free of cracks.

use relievo_core::{Context, Error, Progress, Result};

use crate::build;
use crate::character::Character;
use crate::clip::Clip;
use crate::geomorph::Collapse;
use crate::skinning::Blend;

/// No group.
pub const NONE: u32 = u32::MAX;

relievo_core::parameters! {
    /// How a hierarchy is built.
    pub struct BuildSettings {
        /// Distance of poses that are taken as alike, as a share of the diagonal of the model's box.
        pose_distance: f32 = 0.15, 0.001..=10, "";
        /// Triangles of a cluster at most.
        cluster_triangles: u32 = 100, 8..=4096, "";
        /// Clusters that are simplified together at most; an eighth of the input's clusters if that is less, but four.
        group_clusters: u32 = 16, 4..=64, "";
        /// Poses that are sampled for each second of a clip.
        pose_rate: f32 = 30.0, 0.1..=1000, "1/s";
    }
}

/// A cluster: triangles that are drawn together.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cluster {
    /// The first of its triangles in [`Character::triangles`] of the model.
    pub first: u32,
    /// How many triangles it has.
    pub count: u32,
    /// The group whose simplification made it, [`NONE`] for clusters of the input.
    pub made_by: u32,
    /// The group that it is simplified in, [`NONE`] for the coarsest.
    pub used_by: u32,
    /// The largest deformation level of its vertices, in units of the model.
    pub deformation: f32,
    /// Simplifications below it; 0 for clusters of the input.
    pub depth: u32,
}

/// Clusters that are simplified together.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Group {
    /// The largest distance between the input's surface and the simplified one, either way, in every pose of the clips,
    /// in units of the model. At least the errors of the groups below.
    pub error: f32,
    /// Smallest coordinates of its triangles, and of those below, in all poses.
    pub low: [f32; 3],
    /// Largest coordinates.
    pub high: [f32; 3],
    /// Simplifications below it, at least 1.
    pub depth: u32,
}

/// The largest distances, both ways, that the simplification of a group adds to those of the groups below it, in units of
/// the model. For levels of the whole surface they are from the first of them.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Distances {
    /// Over the representative poses.
    pub chosen: f32,
    /// Over all poses, at least that.
    pub all: f32,
}

/// How a hierarchy differs from that of [`CrowdModel::build`], for comparisons.
#[derive(Clone, Copy, Debug)]
pub struct Variant<'a> {
    /// Clusters of the input: lists of the triangles of [`Character::from_model`]. They are joined by their common edges
    /// alone, whatever their deformation.
    pub clusters: Option<&'a [Vec<u32>]>,
    /// Whether the whole surface becomes one group when its triangles fit into ten full groups.
    pub is_whole: bool,
}

impl Variant<'_> {
    /// The hierarchy of [`CrowdModel::build`].
    const OWN: Self = Self { clusters: None, is_whole: true };
}

/// What building found out.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Report {
    /// Poses of all clips.
    pub poses: u32,
    /// Poses that triangles were simplified over.
    pub representatives: u32,
    /// Measured distances: one for each group in each pose.
    pub measured: u64,
    /// Distances that exceed those of the group in the representative poses. The errors are widened to hold them.
    pub exceeded: u64,
}

/// A character with its clips and its cluster hierarchy.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CrowdModel {
    /// The character. Its triangles are those of all clusters, one cluster after the other, the input's first.
    pub character: Character,
    /// How many triangles the input has.
    pub input_triangles: u32,
    /// Clips, at least one.
    pub clips: Vec<Clip>,
    /// Clusters. The clusters that a group makes come after those it is made of.
    pub clusters: Vec<Cluster>,
    /// Groups. A group comes after those below it.
    pub groups: Vec<Group>,
    /// The measured distances of every group; empty for models of older files.
    pub distances: Vec<Distances>,
    /// Where every vertex goes when its place is removed; empty for models of older files.
    pub collapses: Vec<Collapse>,
    /// Smallest coordinates in all poses.
    pub low: [f32; 3],
    /// Largest coordinates in all poses.
    pub high: [f32; 3],
    /// What building found out.
    pub report: Report,
    /// How bones are blended, which [`Self::with_blend`] changes. Errors and boxes hold for it.
    pub blend: Blend,
}

impl CrowdModel {
    /// Builds the hierarchy of all that a file shows, for the animations given by index; without any for the pose at rest.
    /// Results do not depend on the number of threads.
    ///
    /// # Errors
    /// The model has no triangles, is malformed or too large, an animation does not exist, a setting is out of range, or
    /// `progress` asks to stop.
    pub fn build(
        context: &Context,
        model: &relievo_meshio::Model,
        animations: &[usize],
        settings: &BuildSettings,
        progress: &mut dyn Progress,
    ) -> Result<Self> {
        settings.check()?;
        build::build(context, (model, animations), settings, &Variant::OWN, progress)
    }

    /// As [`Self::build`], in another way.
    ///
    /// # Errors
    /// As [`Self::build`], or a triangle is not in exactly one cluster, or a cluster has none or more than the settings say.
    pub fn build_variant(
        context: &Context,
        (model, animations): (&relievo_meshio::Model, &[usize]),
        variant: &Variant,
        settings: &BuildSettings,
        progress: &mut dyn Progress,
    ) -> Result<Self> {
        settings.check()?;
        build::build(context, (model, animations), settings, variant, progress)
    }

    /// Returns the clusters that are drawn where an error of `allowed` in units of the model may be seen, in order. 0 gives
    /// the input's triangles wherever simplification is not exact.
    pub fn cut(&self, allowed: f32) -> Vec<u32> {
        let is_coarse: Vec<bool> = self.groups.iter().map(|group| group.error <= allowed).collect();
        self.drawn(&is_coarse)
    }

    /// Returns the clusters of the input, in order.
    pub fn input_clusters(&self) -> Vec<u32> {
        self.drawn(&vec![false; self.groups.len()])
    }

    /// Returns the clusters that are drawn when these groups are coarse. A group is coarse only if all below it are.
    pub fn drawn(&self, is_coarse: &[bool]) -> Vec<u32> {
        let coarse = |group: u32| is_coarse.get(group as usize).copied();
        let is_drawn =
            |cluster: &Cluster| coarse(cluster.made_by).unwrap_or(true) && !coarse(cluster.used_by).unwrap_or(false);
        let drawn = self.clusters.iter().zip(0..).filter(|(cluster, _)| is_drawn(cluster));
        drawn.map(|(_, index)| index).collect()
    }

    /// Whether its triangles are in memory. Those of a model whose clusters are read while it is drawn are not.
    pub fn has_triangles(&self) -> bool {
        self.character.triangles.iter().any(|triangle| *triangle != [0; 3])
    }

    /// Checks that its triangles are in memory.
    ///
    /// # Errors
    /// They are read while the model is drawn.
    pub fn check_triangles(&self) -> Result<()> {
        if self.has_triangles() {
            return Ok(());
        }
        Err(Error::unsupported("clusters of this model are read while it is drawn").advise("load the whole file"))
    }

    /// Returns how many triangles clusters have.
    pub fn triangle_count(&self, clusters: &[u32]) -> u64 {
        clusters.iter().map(|cluster| u64::from(self.clusters[*cluster as usize].count)).sum()
    }

    /// Returns the triangles of a cluster.
    pub fn triangles(&self, cluster: u32) -> &[[u32; 3]] {
        let Cluster { first, count, .. } = self.clusters[cluster as usize];
        &self.character.triangles[first as usize..(first + count) as usize]
    }

    /// Returns the triangles of clusters with their materials.
    pub(crate) fn faces(&self, clusters: &[u32]) -> Vec<([u32; 3], u32)> {
        let of = |cluster: &u32| {
            let Cluster { first, count, .. } = self.clusters[*cluster as usize];
            let range = first as usize..(first + count) as usize;
            let materials = self.character.materials[range.clone()].iter();
            self.character.triangles[range].iter().copied().zip(materials.copied())
        };
        clusters.iter().flat_map(of).collect()
    }

    /// Returns the diagonal of the box around all poses.
    pub fn size(&self) -> f32 {
        glam::Vec3::from(self.high).distance(self.low.into())
    }
}
