//! Refits: a model that was sculpted or has other clips gets new errors and boxes, and keeps its clusters.
//!
//! The triangles of all clusters stay. The distance that each simplification adds is measured again in the new poses, so
//! that the bounds of cuts hold. Collapses that were cheap before may cost more now, which the change of the cuts shows.

use relievo_core::{Context, Error, Progress, Result};
use relievo_meshio::Model;

use crate::build::Builder;
use crate::build::places::Places;
use crate::character::Character;
use crate::clip;
use crate::hierarchy::{BuildSettings, CrowdModel, NONE};
use crate::skinning::Blend;

/// Errors whose cuts are compared before and after, as shares of the model's size.
const SHARES: [f32; 4] = [0.001, 0.003, 0.01, 0.03];
/// Growth of the triangles of a cut from which a rebuild is due.
const DUE: f64 = 1.5;

/// What a refit changed.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Refit {
    /// Groups whose simplification has a larger error than before.
    pub grown: u32,
    /// The largest ratio of the triangles of a cut after and before, at equal errors.
    pub growth: f64,
}

impl Refit {
    /// Whether a new hierarchy would draw clearly fewer triangles: some cut has half as many again.
    pub fn is_rebuild_due(&self) -> bool {
        self.growth >= DUE
    }
}

impl CrowdModel {
    /// Returns this model with the vertices, the skeleton and the clips of another file of it, for the animations given by
    /// index, with new errors and bounds for bones that are blended as matrices. Of the settings the poses count. Results do not depend on the number of threads.
    ///
    /// # Errors
    /// The file has other triangles, or vertices that were at one place with the same bones are apart now; clusters
    /// of the model are read while it is drawn; as [`Self::build`].
    pub fn refit(
        &self,
        context: &Context,
        source: &Model,
        animations: &[usize],
        settings: &BuildSettings,
        progress: &mut dyn Progress,
    ) -> Result<(Self, Refit)> {
        settings.check()?;
        self.check_triangles()?;
        progress.step(0.0, "read poses")?;
        let (character, morphs) = Character::animated(context, source, animations)?;
        self.check_same(&character)?;
        let clips = clip::sample(context, source, (&character, &morphs), animations, settings.pose_rate)?;
        let builder = Builder::new(context, &character, &clips, settings)?;
        let (before, after) = self.joined();
        // Distances are from where they were measured when the hierarchy was built.
        let is_whole = self.whole(&before, &after);
        let first = is_whole.iter().position(|is_whole| *is_whole).unwrap_or_default();
        let measured = context.map_watched(self.groups.len(), progress, ("measure", [0.0, 1.0]), |group| {
            let from = if is_whole[group] { first } else { group };
            builder.measure(&Context::serial(), &self.faces(&before[from]), &self.faces(&after[group]))
        })?;
        let mut made = Self {
            character: Character {
                triangles: self.character.triangles.clone(),
                materials: self.character.materials.clone(),
                ..character.clone()
            },
            groups: Vec::with_capacity(self.groups.len()),
            distances: Vec::with_capacity(self.groups.len()),
            report: builder.report(),
            blend: Blend::Linear,
            ..self.clone()
        };
        for cluster in 0..made.clusters.len() as u32 {
            let deformation = builder.deformation(made.triangles(cluster).iter().flatten());
            made.clusters[cluster as usize].deformation = deformation;
        }
        let mut found = Refit::default();
        let mut base = None;
        // Groups come after those below them.
        for (number, result) in measured.into_iter().enumerate() {
            let gauged = result?;
            if is_whole[number] && base.is_none() {
                base = Some(builder.base(context, &made, &before[number])?);
            }
            let group = builder.group(
                &made,
                &before[number],
                (gauged.distances.all, base.as_ref().filter(|_| is_whole[number])),
            );
            found.grown += u32::from(group.error > self.groups[number].error);
            gauged.note(&mut made);
            made.groups.push(group);
        }
        if !self.has_collapses() {
            // Files without collapses are of a version that has no distances either.
            made.distances.clear();
        }
        let made = builder.finished(made, &clips);
        let triangles = |model: &Self, share: f32| model.triangle_count(&model.cut(share * model.size())) as f64;
        found.growth =
            SHARES.into_iter().map(|share| triangles(&made, share) / triangles(self, share)).fold(0.0, f64::max);
        progress.step(1.0, "measure")?;
        Ok((made, found))
    }

    /// Returns the clusters that each group is made of, and the clusters that it makes.
    pub(crate) fn joined(&self) -> (Vec<Vec<u32>>, Vec<Vec<u32>>) {
        let mut before: Vec<Vec<u32>> = vec![Vec::new(); self.groups.len()];
        let mut after = before.clone();
        for (cluster, number) in self.clusters.iter().zip(0..) {
            if let Some(list) = before.get_mut(cluster.used_by as usize) {
                list.push(number);
            }
            if let Some(list) = after.get_mut(cluster.made_by as usize) {
                list.push(number);
            }
        }
        (before, after)
    }

    /// Returns which groups have all clusters of a level.
    pub(crate) fn whole(&self, before: &[Vec<u32>], after: &[Vec<u32>]) -> Vec<bool> {
        let mut open = self.clusters.iter().filter(|cluster| cluster.made_by == NONE).count();
        let lists = before.iter().zip(after);
        lists
            .map(|(before, after)| {
                let is_whole = before.len() == open;
                open = open + after.len() - before.len();
                is_whole
            })
            .collect()
    }

    /// Fails unless a character has the triangles of the input, and one place wherever the input has one.
    fn check_same(&self, character: &Character) -> Result<()> {
        let differs = |what: &str| {
            Err(Error::invalid(what)
                .advise("build the hierarchy anew: `relievo crowd build`, or rlv_crowd_model_build"))
        };
        let input = self.clusters.iter().zip(0..).filter(|(cluster, _)| cluster.made_by == NONE);
        let mut own: Vec<[u32; 3]> = input.flat_map(|(_, number)| self.triangles(number)).copied().collect();
        let mut other = character.triangles.clone();
        own.sort_unstable();
        other.sort_unstable();
        if own != other || self.character.points.len() != character.points.len() {
            return differs("the file has other triangles or vertices than the crowd model");
        }
        let (old, new) = (Places::of(&self.character), Places::of(character));
        let is_apart = |vertex: usize| {
            let first = old.vertices[old.of[vertex] as usize] as usize;
            new.of[vertex] != new.of[first]
        };
        match (0..character.points.len()).find(|vertex| is_apart(*vertex)) {
            Some(vertex) => {
                differs(&format!("vertex {vertex} is no longer at the place of a vertex that it was joined to"))
            }
            None => Ok(()),
        }
    }
}
