//! The largest distance between two meshes that share their points, in many poses.
//!
//! In the first pose the triangles of each mesh are cut into pieces, each bounded by one triangle of the other mesh, as
//! [`distance`](crate::distance()) does. The pieces are stored in barycentric coordinates, with the place of the other
//! triangle that is nearest to each corner. In another pose the distances of the corners from the same places bound the
//! piece, and take sums of products alone, for several poses at once. Only pieces whose bound exceeds the largest known
//! distance are measured against the triangle, then searched and cut again.

use std::sync::OnceLock;

use glam::DVec3;
use relievo_core::progress::Silent;
use relievo_core::{Context, Error, Result};
use relievo_surface::triangle::closest;

use crate::connectivity::NONE;
use crate::distance::{Farthest, MeasuredMesh, Piece, WHOLE, exact, gap};

/// Pieces of a triangle on average up to which finer pieces of another pose replace those of the first one.
const MAX_PIECES: usize = 64;
/// Pieces of the first pose are cut until their bounds are this share of the largest distance, so that they still fit
/// in poses that differ little.
const MARGIN: f64 = 0.75;
/// Poses that are looked at together.
const LANES: usize = 8;
/// What sums of six products in single precision are wrong at most, as a share of the largest coordinate.
const SUM: f32 = 2e-6;
/// Pieces of one task.
const CHUNK_LEN: usize = 8192;

/// A piece of a triangle, and a triangle of the other mesh near it. Both are numbers of the meshes.
#[derive(Clone, Copy)]
struct Patch {
    triangle: u32,
    near: u32,
    weights: [DVec3; 3],
    /// Barycentric coordinates of the place of the other triangle near each corner.
    anchors: [[f32; 3]; 3],
}

impl Patch {
    /// Makes a patch of a piece whose corners are at `corners`, near a triangle of the other mesh at `other`.
    fn new((triangle, near): (u32, u32), piece: &Piece, other: [DVec3; 3]) -> Self {
        let anchors = piece.corners.map(|corner| closest(corner, other).map(|weight| weight as f32));
        Self { triangle, near, weights: piece.weights, anchors }
    }
}

/// A number in each of several poses.
type Lanes = [f32; LANES];

/// A block of poses that are measured together, with the points of both meshes in each.
struct Block<'a> {
    poses: &'a [Vec<[f32; 3]>],
    /// The coordinates of every point in all poses.
    points: Vec<[Lanes; 3]>,
    /// The largest coordinate of each pose.
    extents: [f32; LANES],
    triangles: [&'a [[u32; 3]]; 2],
    /// Both meshes in each pose.
    surfaces: [[OnceLock<Result<MeasuredMesh<'a>>>; 2]; LANES],
}

impl<'a> Block<'a> {
    fn new(poses: &'a [Vec<[f32; 3]>], triangles: [&'a [[u32; 3]]; 2]) -> Self {
        let mut points = vec![[[0.0; LANES]; 3]; poses.first().map_or(0, Vec::len)];
        let mut extents = [0.0f32; LANES];
        for (lane, pose) in poses.iter().enumerate() {
            for (to, from) in points.iter_mut().zip(pose) {
                (0..3).for_each(|axis| to[axis][lane] = from[axis]);
                extents[lane] = from.iter().fold(extents[lane], |most, value| most.max(value.abs()));
            }
        }
        Self { poses, points, extents, triangles, surfaces: Default::default() }
    }

    /// Returns a mesh in a pose.
    fn surface(&self, lane: usize, side: usize) -> Result<&MeasuredMesh<'a>> {
        let made = self.surfaces[lane][side]
            .get_or_init(|| MeasuredMesh::new(&Context::serial(), (&self.poses[lane], self.triangles[side])));
        made.as_ref().map_err(Clone::clone)
    }

    /// Returns the largest squared distance of the corners of a piece from their places on the other triangle, in each pose.
    fn squared(&self, patch: &Patch, (own, other): ([u32; 3], [u32; 3])) -> Lanes {
        let mut most = [0.0f32; LANES];
        for (weights, anchors) in patch.weights.iter().zip(&patch.anchors) {
            let mut sums = [[0.0f32; LANES]; 3];
            let own = own.into_iter().zip(weights.to_array().map(|weight| weight as f32));
            for (vertex, weight) in own.chain(other.into_iter().zip(anchors.map(|weight| -weight))) {
                for (sum, values) in sums.iter_mut().zip(&self.points[vertex as usize]) {
                    (0..LANES).for_each(|lane| sum[lane] += weight * values[lane]);
                }
            }
            for lane in 0..LANES {
                let [x, y, z] = [sums[0][lane], sums[1][lane], sums[2][lane]];
                let squared = x * x + y * y + z * z;
                // A number that is none stays.
                most[lane] = if squared <= most[lane] { most[lane] } else { squared };
            }
        }
        most
    }
}

/// Two meshes that share their points, with the pieces of their triangles.
pub struct PosedDistance<'a> {
    triangles: [&'a [[u32; 3]]; 2],
    patches: [Vec<Patch>; 2],
}

/// What pieces of one task came to.
struct Found {
    /// The bound in each pose, at least the floor.
    most: [f64; LANES],
    /// Pieces, by their number, with the finer ones in their place.
    finer: Vec<(usize, Vec<Patch>)>,
}

impl<'a> PosedDistance<'a> {
    /// Measures the distance in a first pose. Returns the pieces, and a bound that no point of either surface exceeds, at
    /// most 1 % above the true distance or `least`. Surfaces that nearly coincide take far more pieces without a `least`.
    ///
    /// # Errors
    /// A coordinate is not finite, an index is too large, or a mesh has no triangle with area.
    pub fn new(
        context: &Context,
        points: &[[f32; 3]],
        triangles: [&'a [[u32; 3]]; 2],
        least: f32,
    ) -> Result<(Self, f32)> {
        let [first, second] = triangles.map(|triangles| MeasuredMesh::new(context, (points, triangles)));
        let surfaces = [first?, second?];
        if surfaces.iter().any(|surface| surface.solid.is_empty()) {
            return Err(Error::invalid("a mesh has no triangle with area"));
        }
        let rounding = surfaces[0].rounding();
        let ends = [[0.0, 0.25], [0.25, 0.5]];
        let own = surfaces[0].vertices_near(context, &surfaces[1], &mut Silent, ends[0])?;
        let back = surfaces[1].vertices_near(context, &surfaces[0], &mut Silent, ends[1])?;
        let known = own.iter().chain(&back).fold(0.0, |most: f64, near| most.max(near.distance));
        let floor = f64::max(MARGIN * (known + rounding), f64::from(least));
        let mut made = Self { triangles, patches: [Vec::new(), Vec::new()] };
        let mut most = known;
        for (side, near) in [own, back].into_iter().enumerate() {
            let (from, to) = (&surfaces[side], &surfaces[1 - side]);
            let count = triangles[side].len();
            let parts = context.map(count.div_ceil(CHUNK_LEN), |part| {
                let (mut most, mut waiting, mut patches) = (0.0f64, Vec::new(), Vec::new());
                for triangle in part * CHUNK_LEN..count.min((part + 1) * CHUNK_LEN) {
                    let vertices = triangles[side][triangle];
                    let triangle = triangle as u32;
                    let Ok(index) = from.solid.binary_search(&triangle) else {
                        // It may have area in another pose.
                        let corners = vertices.map(|vertex| exact(points[vertex as usize]));
                        let near = to.nearest(corners[0], NONE).triangle;
                        let piece = Piece { corners, weights: WHOLE, near };
                        patches.push(Patch::new((triangle, to.solid[near as usize]), &piece, to.corners(near)));
                        continue;
                    };
                    let near = vertices.map(|vertex| near[vertex as usize]);
                    let corners = from.corners(index as u32);
                    let found = to.farthest(corners, near, [floor, f64::INFINITY], &mut waiting, |piece| {
                        let near = to.solid[piece.near as usize];
                        patches.push(Patch::new((triangle, near), &piece, to.corners(piece.near)));
                    });
                    most = most.max(found.at_most);
                }
                (most, patches)
            });
            for (found, mut patches) in parts {
                most = most.max(found);
                made.patches[side].append(&mut patches);
            }
        }
        Ok((made, bound(most, rounding)))
    }

    /// Bounds the distance in each of some other poses. A bound is `floor` where the distance is no larger, otherwise no point
    /// of either surface exceeds it, and it is at most 1 % above the true distance. It is infinite where only one of the
    /// meshes has a triangle with area.
    ///
    /// # Errors
    /// A coordinate is not finite.
    pub fn at_most(&mut self, context: &Context, poses: &[Vec<[f32; 3]>], floor: f32) -> Result<Vec<f32>> {
        let mut bounds = Vec::with_capacity(poses.len());
        for poses in poses.chunks(LANES) {
            bounds.extend_from_slice(&self.block(context, poses, (floor, false))?[..poses.len()]);
        }
        Ok(bounds)
    }

    /// Bounds the largest distance in some other poses, as [`Self::at_most`] does in each, with less work.
    ///
    /// # Errors
    /// As [`Self::at_most`].
    pub fn largest(&mut self, context: &Context, poses: &[Vec<[f32; 3]>], floor: f32) -> Result<f32> {
        poses.chunks(LANES).try_fold(floor, |floor, poses| {
            Ok(self.block(context, poses, (floor, true))?.into_iter().fold(floor, f32::max))
        })
    }

    /// Bounds the distance in up to [`LANES`] poses, or the largest of them.
    fn block(
        &mut self,
        context: &Context,
        poses: &[Vec<[f32; 3]>],
        (floor, is_largest): (f32, bool),
    ) -> Result<[f32; LANES]> {
        let block = Block::new(poses, self.triangles);
        let mut most = [f64::from(floor); LANES];
        for side in 0..2 {
            let count = self.patches[side].len();
            let start = if is_largest { [most.into_iter().fold(0.0, f64::max); LANES] } else { most };
            let parts = context.map(count.div_ceil(CHUNK_LEN), |part| {
                let range = part * CHUNK_LEN..count.min((part + 1) * CHUNK_LEN);
                self.part(&block, (side, range), (start, is_largest))
            });
            for found in parts {
                let Found { most: part, finer } = found?;
                most.iter_mut().zip(part).for_each(|(most, part)| *most = most.max(part));
                let patches = &mut self.patches[side];
                for (index, mut finer) in finer {
                    if patches.len() + finer.len() <= MAX_PIECES * self.triangles[side].len()
                        && let Some(last) = finer.pop()
                    {
                        patches[index] = last;
                        patches.append(&mut finer);
                    }
                }
            }
        }
        Ok(most.map(|most| most as f32))
    }

    /// Bounds some of the pieces of a mesh.
    fn part(
        &self,
        block: &Block<'_>,
        (side, range): (usize, std::ops::Range<usize>),
        (start, is_largest): ([f64; LANES], bool),
    ) -> Result<Found> {
        let mut found = Found { most: start, finer: Vec::new() };
        let limit = |most: f64, lane: usize| {
            let limit = most as f32 * (1.0 - 1e-6) - SUM * block.extents[lane];
            if limit > 0.0 { limit * limit } else { -1.0 }
        };
        let mut limits: Lanes = std::array::from_fn(|lane| limit(found.most[lane], lane));
        let vertices = |patch: &Patch| {
            (self.triangles[side][patch.triangle as usize], self.triangles[1 - side][patch.near as usize])
        };
        let mut open = Vec::new();
        for index in range {
            let patch = &self.patches[side][index];
            let squared = block.squared(patch, vertices(patch));
            if !(0..LANES).all(|lane| squared[lane] <= limits[lane]) {
                open.push((squared.into_iter().fold(0.0, f32::max), squared, index));
            }
        }
        // The farthest come first, since nothing nearer has to be searched then.
        open.sort_unstable_by(|a, b| b.0.total_cmp(&a.0).then(a.2.cmp(&b.2)));
        let mut waiting = Vec::new();
        for (_, squared, index) in open {
            let patch = &self.patches[side][index];
            let (own, other) = vertices(patch);
            let mut replaced = Vec::new();
            for (lane, points) in block.poses.iter().enumerate() {
                if squared[lane] <= limits[lane] {
                    continue;
                }
                let rounding = MeasuredMesh::rounding_of(block.extents[lane]);
                let [a, b, c] = own.map(|vertex| exact(points[vertex as usize]));
                let places = patch.weights.map(|weight| a * weight.x + b * weight.y + c * weight.z);
                let near = other.map(|vertex| exact(points[vertex as usize]));
                let most = found.most[lane];
                if places.iter().all(|place| gap(*place, near) * (1.0 + 1e-9) + 1e-6 * rounding <= most) {
                    continue;
                }
                let to = block.surface(lane, 1 - side)?;
                if to.solid.is_empty() {
                    if !block.surface(lane, side)?.solid.is_empty() {
                        found.most[lane] = f64::INFINITY;
                        limits[lane] = f32::INFINITY;
                    }
                    continue;
                }
                let near = match to.solid.binary_search(&patch.near) {
                    Ok(near) => near as u32,
                    Err(_) => to.nearest(places[0], NONE).triangle,
                };
                waiting.clear();
                waiting.push(Piece { corners: places, weights: patch.weights, near });
                let mut finer = Vec::new();
                let start = Farthest { at_least: 0.0, at_most: 0.0, near, place: DVec3::ZERO };
                let refined = to.refine(start, [most, f64::INFINITY], &mut waiting, |piece| {
                    let numbers = (patch.triangle, to.solid[piece.near as usize]);
                    finer.push(Patch::new(numbers, &piece, to.corners(piece.near)));
                });
                replaced = finer;
                if refined.at_most > most {
                    let most = f64::from(bound(refined.at_most, rounding));
                    let lanes = if is_largest { 0..LANES } else { lane..lane + 1 };
                    for lane in lanes {
                        found.most[lane] = found.most[lane].max(most);
                        limits[lane] = limit(found.most[lane], lane);
                    }
                }
            }
            if !replaced.is_empty() {
                found.finer.push((index, replaced));
            }
        }
        Ok(found)
    }
}

/// Returns a distance in single precision that holds it with the rounding of pieces.
fn bound(distance: f64, rounding: f64) -> f32 {
    ((distance * (1.0 + 1e-9) + 1e-6 * rounding) as f32).next_up()
}
