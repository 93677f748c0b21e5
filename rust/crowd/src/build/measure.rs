//! Measured distances between the surface before and after a simplification, in every pose.

use relievo_core::{Context, ErrorKind, Result};
use relievo_lod::PosedDistance;

use crate::build::{Builder, Face, RIGID, lower, upper};
use crate::clip::Skeleton;
use crate::hierarchy::{CrowdModel, Distances};

/// Distances that are not told apart, as a share of the size of the model: a hundredth of a pixel where it has a thousand pixels.
pub(crate) const NEGLIGIBLE: f32 = 1e-5;
/// Poses whose vertices are placed together.
pub(crate) const BLOCK: usize = 8;

/// What was measured of a simplification.
#[derive(Clone, Copy)]
pub(crate) struct Gauged {
    pub distances: Distances,
    /// Poses, and those whose distance exceeds that of the representative ones.
    poses: u64,
    exceeded: u64,
}

impl Gauged {
    /// Adds the distances of the next group to a model.
    pub fn note(&self, made: &mut CrowdModel) {
        made.distances.push(self.distances);
        made.report.measured += self.poses;
        made.report.exceeded += self.exceeded;
    }
}

impl Builder<'_> {
    /// Measures the largest distance, both ways, between a group before and after its simplification, over the representative
    /// poses and over all.
    pub fn measure(&self, context: &Context, before: &[Face], after: &[Face]) -> Result<Gauged> {
        let (vertices, [before, after]) = numbered(before, after);
        let place = |skeleton: &Skeleton, vertex: &u32| skeleton.place(self.character, *vertex as usize);
        let points = |skeleton: &Skeleton| -> Vec<[f32; 3]> {
            vertices.iter().map(|vertex| place(skeleton, vertex).as_vec3().to_array()).collect()
        };
        let least = NEGLIGIBLE * self.size;
        let mut gauge = Gauge::new(context, [&before, &after], least);
        let poses = self.skeletons.len() as u64;
        if self.is_rigid(&vertices) {
            // The distance is the same in all poses, up to rounding.
            let distance = gauge.largest(&[points(self.skeletons[0])], least)? * (1.0 + 2.0 * RIGID as f32);
            return Ok(Gauged { distances: Distances { chosen: distance, all: distance }, poses, exceeded: 0 });
        }
        let of = |is_seen: bool| -> Vec<&Skeleton> {
            let poses = self.skeletons.iter().zip(&self.is_representative);
            poses.filter(|(_, is_representative)| **is_representative == is_seen).map(|(it, _)| *it).collect()
        };
        let (mut chosen, mut others) = (least, Vec::new());
        for skeletons in of(true).chunks(BLOCK) {
            let poses: Vec<_> = skeletons.iter().map(|skeleton| points(skeleton)).collect();
            chosen = gauge.largest(&poses, chosen)?;
        }
        for skeletons in of(false).chunks(BLOCK) {
            let poses: Vec<_> = skeletons.iter().map(|skeleton| points(skeleton)).collect();
            others.extend(gauge.at_most(&poses, chosen)?);
        }
        let exceeded = others.iter().filter(|distance| **distance > chosen).count() as u64;
        let all = others.into_iter().fold(chosen, f32::max);
        Ok(Gauged { distances: Distances { chosen, all }, poses, exceeded })
    }

    /// Whether all vertices follow one bone that keeps all lengths.
    fn is_rigid(&self, vertices: &[u32]) -> bool {
        let bone = |vertex: &u32| {
            if !self.character.morphs.of(*vertex as usize).is_empty() {
                return None;
            }
            let influence = &self.character.influences[*vertex as usize];
            let mut used = influence.bones.iter().zip(influence.weights).filter(|(_, weight)| *weight > 0.0);
            used.next().map(|(bone, _)| *bone).filter(|_| used.next().is_none())
        };
        let Some(Some(first)) = vertices.first().map(bone) else { return false };
        self.is_rigid[usize::from(first)] && vertices.iter().all(|vertex| bone(vertex) == Some(first))
    }
}

/// Returns the vertices of two lists of faces, in order, and the triangles of both by the places of their vertices in it.
pub(crate) fn numbered(before: &[Face], after: &[Face]) -> (Vec<u32>, [Vec<[u32; 3]>; 2]) {
    let mut vertices: Vec<u32> = before.iter().chain(after).flat_map(|face| face.0).collect();
    vertices.sort_unstable();
    vertices.dedup();
    let place = |vertex: u32| vertices.binary_search(&vertex).unwrap_or_default() as u32;
    let triangles = [before, after].map(|faces| faces.iter().map(|face| face.0.map(place)).collect());
    (vertices, triangles)
}

/// Measures distances between two lists of triangles, before and after a simplification, in many poses.
pub(crate) struct Gauge<'a> {
    context: &'a Context,
    triangles: [&'a [[u32; 3]]; 2],
    /// Distances below it are not told apart.
    least: f32,
    /// What was measured in the first pose in which both have area.
    posed: Option<PosedDistance<'a>>,
}

impl<'a> Gauge<'a> {
    pub fn new(context: &'a Context, triangles: [&'a [[u32; 3]]; 2], least: f32) -> Self {
        Self { context, triangles, least, posed: None }
    }

    /// Returns `floor`, or a bound of the largest distance in some poses if that may be larger.
    pub fn largest(&mut self, poses: &[Vec<[f32; 3]>], floor: f32) -> Result<f32> {
        let (floor, rest) = self.begin(poses, floor)?;
        let Some(posed) = &mut self.posed else { return Ok(floor) };
        let found = posed.largest(self.context, rest, floor)?;
        if found.is_finite() {
            return Ok(found);
        }
        Ok(self.at_most(rest, floor)?.into_iter().fold(floor, f32::max))
    }

    /// Returns for each pose `floor`, or a bound of the distance if that may be larger.
    fn at_most(&mut self, poses: &[Vec<[f32; 3]>], floor: f32) -> Result<Vec<f32>> {
        let Some(posed) = &mut self.posed else {
            return poses.iter().map(|points| self.largest(std::slice::from_ref(points), floor)).collect();
        };
        let mut found = posed.at_most(self.context, poses, floor)?;
        for (found, points) in found.iter_mut().zip(poses) {
            // One of both has no area in this pose: the box holds both.
            if found.is_infinite() {
                *found = diagonal(points).max(floor);
            }
        }
        Ok(found)
    }

    /// Measures the first poses, up to one in which both have area. Returns the largest distance in them and the other poses.
    fn begin<'b>(&mut self, poses: &'b [Vec<[f32; 3]>], floor: f32) -> Result<(f32, &'b [Vec<[f32; 3]>])> {
        let (mut most, mut rest) = (floor, poses);
        while let (None, [points, next @ ..]) = (&self.posed, rest) {
            rest = next;
            match PosedDistance::new(self.context, points, self.triangles, self.least) {
                Ok((posed, found)) => {
                    self.posed = Some(posed);
                    most = most.max(found);
                }
                Err(error) if error.kind == ErrorKind::Invalid => most = most.max(diagonal(points)),
                Err(error) => return Err(error),
            }
        }
        Ok((most, rest))
    }
}

/// Returns the diagonal of the box of some points.
fn diagonal(points: &[[f32; 3]]) -> f32 {
    let (low, high) = points.iter().fold(([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]), |(low, high), point| {
        (lower(low, *point), upper(high, *point))
    });
    glam::Vec3::from(high).distance(low.into())
}
