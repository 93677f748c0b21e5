//! Groups of neighbouring clusters with similar deformation levels, which are simplified together (Section 4.3).

use std::collections::HashMap;

use glam::Vec3;

use crate::build::places::Places;
use crate::hierarchy::CrowdModel;

/// Difference of levels, as a share of the higher one, that halves what a common edge counts.
const SIMILAR: f32 = 0.1;
/// Share of the model's size that is added to it.
const NEGLIGIBLE: f32 = 1e-3;

/// Clusters with what they have in common.
struct Neighbours {
    /// For each cluster its neighbours and what they count: common edges, less where levels differ.
    of: Vec<Vec<(u32, f32)>>,
    centers: Vec<Vec3>,
}

/// Divides clusters into groups of about `size` that share edges; clusters without a neighbour are grouped by distance.
/// Every cluster of `front` is in one group.
pub(crate) fn grouped(model: &CrowdModel, places: &Places, front: &[u32], size: usize, extent: f32) -> Vec<Vec<u32>> {
    let neighbours = neighbours(model, places, front, extent);
    let mut group_of: Vec<Option<usize>> = vec![None; front.len()];
    let mut groups: Vec<Vec<usize>> = Vec::new();
    for seed in 0..front.len() {
        if group_of[seed].is_some() {
            continue;
        }
        let mut group = vec![seed];
        group_of[seed] = Some(groups.len());
        while group.len() < size {
            let Some(next) = neighbours.best(&group, &group_of).or_else(|| neighbours.nearest(&group, &group_of))
            else {
                break;
            };
            group_of[next] = Some(groups.len());
            group.push(next);
        }
        groups.push(group);
    }
    join_single(&neighbours, &mut groups, &mut group_of, size);
    let named = |group: Vec<usize>| group.into_iter().map(|index| front[index]).collect::<Vec<u32>>();
    groups.into_iter().filter(|group| !group.is_empty()).map(named).collect()
}

/// Adds groups of one cluster to the neighbouring group that shares most with it, if that has room.
fn join_single(neighbours: &Neighbours, groups: &mut [Vec<usize>], group_of: &mut [Option<usize>], size: usize) {
    for number in 0..groups.len() {
        let [single] = groups[number][..] else { continue };
        let mut best: Option<(usize, f32)> = None;
        for (other, weight) in &neighbours.of[single] {
            let Some(group) = group_of[*other as usize] else { continue };
            let has_room = group != number && groups[group].len() < 2 * size;
            if has_room && best.is_none_or(|(_, most)| *weight > most) {
                best = Some((group, *weight));
            }
        }
        if let Some((group, _)) = best {
            groups[number].clear();
            groups[group].push(single);
            group_of[single] = Some(group);
        }
    }
}

impl Neighbours {
    /// Returns the free cluster that has most in common with a group.
    fn best(&self, group: &[usize], group_of: &[Option<usize>]) -> Option<usize> {
        let mut sums: Vec<(u32, f32)> = Vec::new();
        for (other, weight) in group.iter().flat_map(|cluster| &self.of[*cluster]) {
            if group_of[*other as usize].is_some() {
                continue;
            }
            match sums.iter_mut().find(|known| known.0 == *other) {
                Some(known) => known.1 += weight,
                None => sums.push((*other, *weight)),
            }
        }
        let better = |a: &&(u32, f32), b: &&(u32, f32)| a.1.total_cmp(&b.1).then(b.0.cmp(&a.0));
        sums.iter().max_by(better).map(|(cluster, _)| *cluster as usize)
    }

    /// Returns the nearest free cluster, if the group has no neighbours at all.
    fn nearest(&self, group: &[usize], group_of: &[Option<usize>]) -> Option<usize> {
        let own = |cluster: &u32| group.contains(&(*cluster as usize));
        if group.iter().flat_map(|cluster| &self.of[*cluster]).any(|(other, _)| !own(other)) {
            return None;
        }
        let first = *group.first()?;
        let free = (first + 1..group_of.len()).filter(|cluster| group_of[*cluster].is_none());
        let squared = |cluster: &usize| self.centers[*cluster].distance_squared(self.centers[first]);
        free.min_by(|a, b| squared(a).total_cmp(&squared(b)).then(a.cmp(b)))
    }
}

fn neighbours(model: &CrowdModel, places: &Places, front: &[u32], extent: f32) -> Neighbours {
    let mut edges: Vec<(u32, u32, u32)> = Vec::new();
    let mut centers = Vec::with_capacity(front.len());
    for (index, cluster) in front.iter().enumerate() {
        let mut sum = Vec3::ZERO;
        for triangle in model.triangles(*cluster) {
            for (from, to) in [(0, 1), (1, 2), (2, 0)] {
                let (a, b) = (places.of[triangle[from] as usize], places.of[triangle[to] as usize]);
                edges.push((a.min(b), a.max(b), index as u32));
            }
            sum += Vec3::from(crate::build::partition::center(&model.character, *triangle));
        }
        centers.push(sum / (3 * model.triangles(*cluster).len()).max(1) as f32);
    }
    edges.sort_unstable();
    edges.dedup();
    let mut counts: HashMap<(u32, u32), u32> = HashMap::new();
    for edge in edges.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
        // Where more than two meet, each counts as a neighbour of the next.
        edge.windows(2).for_each(|pair| *counts.entry((pair[0].2, pair[1].2)).or_default() += 1);
    }
    let mut of: Vec<Vec<(u32, f32)>> = vec![Vec::new(); front.len()];
    let level = |index: u32| model.clusters[front[index as usize] as usize].deformation;
    for ((one, other), count) in counts {
        let (a, b) = (level(one), level(other));
        let likeness = 1.0 / (1.0 + (a - b).abs() / (SIMILAR * a.max(b) + NEGLIGIBLE * extent).max(f32::MIN_POSITIVE));
        let weight = count as f32 * likeness;
        of[one as usize].push((other, weight));
        of[other as usize].push((one, weight));
    }
    of.iter_mut().for_each(|list| list.sort_unstable_by_key(|(other, _)| *other));
    Neighbours { of, centers }
}
