//! Models whose bones are blended in another way, with errors and boxes that hold for it.
//!
//! A hierarchy is built where bones are blended as matrices. Dual quaternions have vertices elsewhere, further apart or nearer to
//! one another, so that errors of one do not bound those of the other. The distance that each simplification adds is measured
//! again in all poses, as a refit does, and the larger error taken. Boxes hold the places of both.

use relievo_core::progress::Silent;
use relievo_core::{Context, Progress, Result};

use crate::build::measure::{BLOCK, Gauge, NEGLIGIBLE, numbered};
use crate::build::{Face, lower, upper};
use crate::hierarchy::{CrowdModel, Group, NONE};
use crate::skinning::{Blend, Posing};

/// Relative rounding of places.
const ROUNDING: f32 = 1e-6;

/// A model in all of its poses.
struct Poses<'a> {
    model: &'a CrowdModel,
    poses: Vec<Posing<'a>>,
}

impl Poses<'_> {
    fn place(&self, posing: &Posing, vertex: u32) -> [f32; 3] {
        posing.place(&self.model.character, vertex as usize)
    }

    /// Measures the largest distance between two lists of faces in any pose.
    fn measure(&self, context: &Context, before: &[Face], after: &[Face]) -> Result<f32> {
        let (vertices, [before, after]) = numbered(before, after);
        let least = NEGLIGIBLE * self.model.size();
        let mut gauge = Gauge::new(context, [&before, &after], least);
        self.poses.chunks(BLOCK).try_fold(least, |most, poses| {
            let placed = |posing: &Posing| vertices.iter().map(|vertex| self.place(posing, *vertex)).collect();
            gauge.largest(&poses.iter().map(placed).collect::<Vec<Vec<[f32; 3]>>>(), most)
        })
    }

    /// Returns the box of a vertex in all poses.
    fn path(&self, vertex: u32) -> [[f32; 3]; 2] {
        let nothing = [[f32::INFINITY; 3], [f32::NEG_INFINITY; 3]];
        let places = self.poses.iter().map(|posing| self.place(posing, vertex));
        places.fold(nothing, |[low, high], place| [lower(low, place), upper(high, place)])
    }
}

impl CrowdModel {
    /// Returns this model with its bones blended in another way. Its errors and boxes hold for matrices and for dual quaternions.
    /// Files do not say how bones are blended: a model that is read has matrices. Takes about as long as a refit.
    ///
    /// # Errors
    /// A pose has another number of bones or morph targets than the character, or the triangles of the model are read while it
    /// is drawn.
    pub fn with_blend(&self, context: &Context, blend: Blend) -> Result<Self> {
        self.with_blend_watched(context, blend, &mut Silent)
    }

    /// As [`Self::with_blend`], and reports progress.
    ///
    /// # Errors
    /// As [`Self::with_blend`], or `progress` asks to stop.
    pub fn with_blend_watched(&self, context: &Context, blend: Blend, progress: &mut dyn Progress) -> Result<Self> {
        let mut made = Self { blend, ..self.clone() };
        if blend == self.blend || blend == Blend::Linear {
            return Ok(made);
        }
        self.check_triangles()?;
        let poses = self.clips.iter().flat_map(|clip| &clip.poses);
        let poses = poses.map(|pose| Posing::new(&self.character, pose, blend)).collect::<Result<Vec<_>>>()?;
        let poses = Poses { model: self, poses };
        let (before, after) = self.joined();
        // Distances are from where they were measured when the hierarchy was built.
        let is_whole = self.whole(&before, &after);
        let first = is_whole.iter().position(|is_whole| *is_whole).unwrap_or_default();
        let measured = context.map_watched(self.groups.len(), progress, ("measure", [0.0, 1.0]), |group| {
            let from = if is_whole[group] { first } else { group };
            poses.measure(&Context::serial(), &self.faces(&before[from]), &self.faces(&after[group]))
        })?;
        let margin = ROUNDING * self.size();
        let paths = context.map(self.character.points.len(), |vertex| {
            let [low, high] = poses.path(vertex as u32);
            [low.map(|value| value - margin), high.map(|value| value + margin)]
        });
        for [low, high] in &paths {
            (made.low, made.high) = (lower(made.low, *low), upper(made.high, *high));
        }
        let mut base = None;
        // Groups come after those below them.
        for (number, added) in measured.into_iter().enumerate() {
            let mut group = self.groups[number];
            let mut sum = 0.0f32;
            for cluster in &before[number] {
                for vertex in self.triangles(*cluster).as_flattened() {
                    let [low, high] = paths[*vertex as usize];
                    (group.low, group.high) = (lower(group.low, low), upper(group.high, high));
                }
                if let Some(below) = made.groups.get(self.clusters[*cluster as usize].made_by as usize) {
                    sum = sum.max(below.error);
                    (group.low, group.high) = (lower(group.low, below.low), upper(group.high, below.high));
                }
            }
            let mut from = sum;
            if is_whole[number] {
                from = match base {
                    Some(base) => base,
                    None => *base.insert(poses.base(context, &before[number], sum)?),
                };
            }
            // Rounding must not bring the sum below what it bounds.
            let added = added?;
            let error = if added > 0.0 { (from + added).next_up() } else { from };
            made.groups[number] = Group { error: group.error.max(sum).max(error), ..group };
        }
        progress.step(1.0, "measure")?;
        Ok(made)
    }
}

impl Poses<'_> {
    /// Returns the distance of clusters of the whole surface from the input, at most `sum`.
    fn base(&self, context: &Context, clusters: &[u32], sum: f32) -> Result<f32> {
        let model = self.model;
        let input = model.clusters.iter().zip(0..).filter(|(cluster, _)| cluster.made_by == NONE);
        let input = model.faces(&input.map(|(_, number)| number).collect::<Vec<u32>>());
        if sum == 0.0 {
            return Ok(sum);
        }
        Ok(sum.min(self.measure(context, &input, &model.faces(clusters))?))
    }
}
