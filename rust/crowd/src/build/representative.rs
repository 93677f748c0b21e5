//! Representative poses of clips (Section 4.1).
//!
//! A pose is the list of places of its bones, each in the middle of the vertices that it moves, without the movement of
//! the whole. Poses are brought to nine dimensions by classical scaling (after Assa, Caspi, Cohen-Or 2005), joined while
//! two are nearer than a distance d, and groups wider than 1.5 d are halved. The pose nearest to the centre of a group
//! stands for it.

use glam::DVec3;

use crate::build::eigen::symmetric_eigen;
use crate::build::partition::Regions;
use crate::character::Character;
use crate::clip::Skeleton;

/// Dimensions that poses are brought to.
const DIMENSIONS: usize = 9;
/// Width of a group above which it is halved, in distances d.
const WIDEST: f64 = 1.5;

/// Returns the indices of the poses that stand for all, in order. `distance` is d, in units of the model.
pub(crate) fn representatives(character: &Character, skeletons: &[&Skeleton], distance: f64) -> Vec<usize> {
    let places = scaled(&bone_places(character, skeletons));
    let mut chosen: Vec<usize> = clustered(&places, distance)
        .into_iter()
        .flat_map(|group| halved(&places, group, WIDEST * distance))
        .map(|group| central(&places, &group))
        .collect();
    chosen.sort_unstable();
    chosen
}

/// Returns the places of all bones that move vertices, for each pose, relative to their mean; then how far each morph target
/// moves a vertex.
fn bone_places(character: &Character, skeletons: &[&Skeleton]) -> Vec<Vec<f64>> {
    let mut centers = vec![(DVec3::ZERO, 0.0); character.bones.len()];
    for (point, influence) in character.points.iter().zip(&character.influences) {
        for (bone, weight) in influence.bones.iter().zip(influence.weights) {
            let center = &mut centers[usize::from(*bone)];
            center.0 += DVec3::from(point.map(f64::from)) * f64::from(weight);
            center.1 += f64::from(weight);
        }
    }
    let extents = character.morphs.extents();
    let place = |skeleton: &Skeleton| {
        let used = centers.iter().zip(&skeleton.bones).filter(|((_, weight), _)| *weight > 0.0);
        let places: Vec<DVec3> = used.map(|((sum, weight), bone)| bone.transform_point3(*sum / *weight)).collect();
        let mean = places.iter().sum::<DVec3>() / places.len().max(1) as f64;
        let morphs = extents.iter().zip(&skeleton.weights).map(|(extent, weight)| extent * f64::from(*weight));
        places.iter().flat_map(|place| (*place - mean).to_array()).chain(morphs).collect()
    };
    skeletons.iter().map(|skeleton| place(skeleton)).collect()
}

/// Brings points to the dimensions in which they differ most. For Euclidean distances classical scaling is the
/// projection on principal axes, which the smaller of two symmetric matrices gives.
fn scaled(points: &[Vec<f64>]) -> Vec<[f64; DIMENSIONS]> {
    let (count, width) = (points.len(), points.first().map_or(0, Vec::len));
    let mean: Vec<f64> = (0..width).map(|k| points.iter().map(|point| point[k]).sum::<f64>() / count as f64).collect();
    let centered: Vec<Vec<f64>> =
        points.iter().map(|point| point.iter().zip(&mean).map(|(value, mean)| value - mean).collect()).collect();
    let mut made = vec![[0.0; DIMENSIONS]; count];
    if count <= width {
        let gram = |i: usize, j: usize| centered[i].iter().zip(&centered[j]).map(|(a, b)| a * b).sum();
        for (axis, (value, vector)) in symmetric_eigen(count, gram).into_iter().take(DIMENSIONS).enumerate() {
            for (point, part) in made.iter_mut().zip(vector) {
                point[axis] = part * value.max(0.0).sqrt();
            }
        }
    } else {
        let covariance = |i: usize, j: usize| centered.iter().map(|point| point[i] * point[j]).sum();
        for (axis, (_, vector)) in symmetric_eigen(width, covariance).into_iter().take(DIMENSIONS).enumerate() {
            for (point, from) in made.iter_mut().zip(&centered) {
                point[axis] = from.iter().zip(&vector).map(|(a, b)| a * b).sum();
            }
        }
    }
    made
}

/// Joins points while two of different groups are nearer than `distance`. Neighbours are sought along the first axis, in
/// which points differ most, so that few pairs are looked at.
fn clustered(points: &[[f64; DIMENSIONS]], distance: f64) -> Vec<Vec<usize>> {
    let mut order: Vec<usize> = (0..points.len()).collect();
    order.sort_by(|a, b| points[*a][0].total_cmp(&points[*b][0]).then(a.cmp(b)));
    let mut regions = Regions::new(points.len());
    for (rank, &one) in order.iter().enumerate() {
        for &other in &order[rank + 1..] {
            if points[other][0] - points[one][0] > distance {
                break;
            }
            let squared: f64 = points[one].iter().zip(&points[other]).map(|(a, b)| (a - b) * (a - b)).sum();
            if squared <= distance * distance {
                regions.join(one, other);
            }
        }
    }
    let mut groups: Vec<Vec<usize>> = vec![Vec::new(); points.len()];
    for index in 0..points.len() {
        groups[regions.root(index)].push(index);
    }
    groups.retain(|group| !group.is_empty());
    groups
}

/// Halves a group in the middle of the longest side of its box until the diagonals of all boxes are at most `width`.
fn halved(points: &[[f64; DIMENSIONS]], group: Vec<usize>, width: f64) -> Vec<Vec<usize>> {
    let (mut done, mut open) = (Vec::new(), vec![group]);
    while let Some(group) = open.pop() {
        let range = |axis: usize| {
            let values = group.iter().map(|index| points[*index][axis]);
            values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| (low.min(value), high.max(value)))
        };
        let ranges: [(f64, f64); DIMENSIONS] = std::array::from_fn(range);
        let diagonal = ranges.iter().map(|(low, high)| (high - low) * (high - low)).sum::<f64>().sqrt();
        if !(diagonal > width) {
            done.push(group);
            continue;
        }
        let extent = |axis: &usize| ranges[*axis].1 - ranges[*axis].0;
        let axis = (0..DIMENSIONS).max_by(|a, b| extent(a).total_cmp(&extent(b)).then(b.cmp(a))).unwrap_or_default();
        let middle = 0.5 * (ranges[axis].0 + ranges[axis].1);
        let (low, high): (Vec<_>, Vec<_>) = group.into_iter().partition(|index| points[*index][axis] <= middle);
        open.extend([high, low]);
    }
    done
}

/// Returns the point of a group that is nearest to the middle of its box.
fn central(points: &[[f64; DIMENSIONS]], group: &[usize]) -> usize {
    let middle: [f64; DIMENSIONS] = std::array::from_fn(|axis| {
        let values = group.iter().map(|index| points[*index][axis]);
        let (low, high) =
            values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| (low.min(value), high.max(value)));
        0.5 * (low + high)
    });
    let squared = |index: &usize| points[*index].iter().zip(middle).map(|(a, b)| (a - b) * (a - b)).sum::<f64>();
    let nearest = group.iter().min_by(|a, b| squared(a).total_cmp(&squared(b)).then(a.cmp(b)));
    nearest.copied().unwrap_or_default()
}
