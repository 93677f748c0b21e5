//! What a hierarchy has at each level, with the distances of its simplifications.

use crate::hierarchy::CrowdModel;

/// The median and the largest of some distances, in units of the model.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Spread {
    /// The median; of an even number the larger in the middle.
    pub median: f32,
    /// The largest.
    pub largest: f32,
}

/// Groups of equally many simplifications.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Level {
    /// Simplifications of the groups, at least 1.
    pub depth: u32,
    /// How many groups there are.
    pub groups: u32,
    /// Triangles that the groups leave.
    pub triangles: u64,
    /// Distances that the simplifications add over the representative poses.
    pub chosen: Spread,
    /// The same over all poses.
    pub all: Spread,
    /// Groups whose distance over all poses exceeds that over the representative ones.
    pub exceeding: u32,
}

impl CrowdModel {
    /// Returns the levels of the hierarchy, the finest first; none for models of older files, which have no distances.
    pub fn level_distances(&self) -> Vec<Level> {
        let deepest = self.groups.iter().map(|group| group.depth).max().unwrap_or_default();
        let mut levels: Vec<Level> = (1..=deepest).map(|depth| Level { depth, ..Level::default() }).collect();
        for cluster in &self.clusters {
            if let Some(group) = self.groups.get(cluster.made_by as usize) {
                levels[group.depth as usize - 1].triangles += u64::from(cluster.count);
            }
        }
        for level in &mut levels {
            let groups = self.groups.iter().zip(&self.distances).filter(|(group, _)| group.depth == level.depth);
            let (mut chosen, mut all) = (Vec::new(), Vec::new());
            for (_, distances) in groups {
                chosen.push(distances.chosen);
                all.push(distances.all);
                level.exceeding += u32::from(distances.all > distances.chosen);
            }
            level.groups = chosen.len() as u32;
            (level.chosen, level.all) = (spread(chosen), spread(all));
        }
        levels.retain(|level| level.groups > 0);
        levels
    }
}

fn spread(mut values: Vec<f32>) -> Spread {
    values.sort_unstable_by(f32::total_cmp);
    let at = |index: usize| values.get(index).copied().unwrap_or_default();
    Spread { median: at(values.len() / 2), largest: at(values.len().saturating_sub(1)) }
}
