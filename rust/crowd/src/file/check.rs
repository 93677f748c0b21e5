//! What holds of all models, of files or built.

use relievo_core::Result;

use super::damaged;
use crate::clip::Pose;
use crate::geomorph::Collapse;
use crate::hierarchy::{CrowdModel, Distances, Group, NONE};

impl CrowdModel {
    /// Checks that all parts fit together and that errors and boxes grow upwards, on which cuts without cracks rest.
    ///
    /// # Errors
    /// Says what does not fit.
    pub fn check(&self) -> Result<()> {
        self.character.check()?;
        let input: u64 = self.clusters.iter().filter(|it| it.made_by == NONE).map(|it| u64::from(it.count)).sum();
        if input != u64::from(self.input_triangles) {
            return Err(damaged("the clusters of the input have another number of triangles"));
        }
        if self.clips.is_empty() {
            return Err(damaged("there is no clip"));
        }
        let fits = |pose: &Pose| {
            let character = &self.character;
            pose.bones.len() == character.bones.len() && pose.weights.len() == character.morphs.count as usize
        };
        if !self.clips.iter().all(|clip| clip.rate > 0.0 && !clip.poses.is_empty() && clip.poses.iter().all(fits)) {
            return Err(damaged("a clip does not fit the bones"));
        }
        // Targets are removed later, so that a vertex that goes on comes to an end.
        let goes_on = |found: &Collapse| {
            let target = self.collapses.get(found.target as usize);
            let is_known = (found.group as usize) < self.groups.len();
            found.group == NONE || (is_known && target.is_some_and(|target| target.group > found.group))
        };
        if !(self.collapses.is_empty() || self.has_collapses()) || !self.collapses.iter().all(goes_on) {
            return Err(damaged("a vertex goes nowhere when it is removed"));
        }
        let is_right = |it: &Distances| 0.0 <= it.chosen && it.chosen <= it.all;
        let has_all = [0, self.groups.len()].contains(&self.distances.len());
        if !has_all
            || !self.distances.iter().all(is_right)
            || !self.groups.iter().all(|it| (1..=self.groups.len()).contains(&(it.depth as usize)))
        {
            return Err(damaged("the distances or depths of groups are wrong"));
        }
        let nested = |inner: ([f32; 3], [f32; 3]), low: [f32; 3], high: [f32; 3]| {
            (0..3).all(|axis| low[axis] <= inner.0[axis] && inner.1[axis] <= high[axis])
        };
        for (index, cluster) in self.clusters.iter().enumerate() {
            let group = |number: u32| self.groups.get(number as usize);
            let (made, used) = (group(cluster.made_by), group(cluster.used_by));
            let missing = |number: u32, group: Option<&Group>| number != NONE && group.is_none();
            if missing(cluster.made_by, made) || missing(cluster.used_by, used) || cluster.count == 0 {
                return Err(damaged("it has no triangles, or its group does not exist").at(format!("cluster {index}")));
            }
            let (Some(below), Some(above)) = (made, used) else { continue };
            let grows = below.error <= above.error && nested((below.low, below.high), above.low, above.high);
            if cluster.made_by >= cluster.used_by || !grows {
                return Err(damaged("errors or boxes do not grow upwards").at(format!("cluster {index}")));
            }
        }
        Ok(())
    }
}
