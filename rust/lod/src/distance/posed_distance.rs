//! The largest distance between two meshes that share their points, in one pose after the other.
//!
//! In the first pose the triangles of each mesh are cut into pieces, each bounded by one triangle of the other mesh, as
//! [`distance`](crate::distance()) does. The pieces are stored in barycentric coordinates. In another pose the distance
//! of a piece from the same triangle is a bound too, so that only pieces whose bound exceeds the largest known distance
//! are searched and cut again.

use glam::DVec3;
use relievo_core::progress::Silent;
use relievo_core::{Context, Error, Result};

use crate::connectivity::NONE;
use crate::distance::{Farthest, Piece, Surface, WHOLE, exact, gap};

/// Pieces of a triangle on average up to which finer pieces of another pose replace those of the first one.
const MOST_PIECES: usize = 64;
/// Pieces of the first pose are cut until their bounds are this share of the largest distance, so that they still fit
/// in poses that differ little.
const MARGIN: f64 = 0.75;

/// A piece of a triangle, and a triangle of the other mesh near it. Both are numbers of the meshes.
#[derive(Clone, Copy)]
struct Patch {
    triangle: u32,
    near: u32,
    weights: [DVec3; 3],
}

/// Two meshes that share their points, with the pieces of their triangles.
pub struct PosedDistance<'a> {
    triangles: [&'a [[u32; 3]]; 2],
    patches: [Vec<Patch>; 2],
}

impl<'a> PosedDistance<'a> {
    /// Measures the distance in a first pose. Returns the pieces, and a bound that no point of either surface exceeds, at
    /// most 1 % above the true distance.
    ///
    /// # Errors
    /// A coordinate is not finite, an index is too large, or a mesh has no triangle with area.
    pub fn new(context: &Context, points: &[[f32; 3]], triangles: [&'a [[u32; 3]]; 2]) -> Result<(Self, f32)> {
        let [first, second] = triangles.map(|triangles| Surface::new(context, (points, triangles)));
        let surfaces = [first?, second?];
        if surfaces.iter().any(|surface| surface.solid.is_empty()) {
            return Err(Error::invalid("a mesh has no triangle with area"));
        }
        let rounding = surfaces[0].rounding();
        let ends = [[0.0, 0.25], [0.25, 0.5]];
        let own = surfaces[0].vertices_near(context, &surfaces[1], &mut Silent, ends[0])?;
        let back = surfaces[1].vertices_near(context, &surfaces[0], &mut Silent, ends[1])?;
        let known = own.iter().chain(&back).fold(0.0, |most: f64, near| most.max(near.distance));
        let floor = known + rounding;
        let mut made = Self { triangles, patches: [Vec::new(), Vec::new()] };
        let (mut most, mut waiting) = (known, Vec::new());
        for (side, near) in [own, back].into_iter().enumerate() {
            let (from, to) = (&surfaces[side], &surfaces[1 - side]);
            let patches = &mut made.patches[side];
            let mut solid = from.solid.iter().zip(0..).peekable();
            for triangle in 0..triangles[side].len() as u32 {
                let Some((_, index)) = solid.next_if(|(next, _)| **next == triangle) else {
                    // It may have area in another pose.
                    let corner = points[triangles[side][triangle as usize][0] as usize];
                    let near = to.solid[to.nearest(exact(corner), NONE).triangle as usize];
                    patches.push(Patch { triangle, near, weights: WHOLE });
                    continue;
                };
                let near = triangles[side][triangle as usize].map(|vertex| near[vertex as usize]);
                let found =
                    to.farthest(from.corners(index), near, [MARGIN * floor, f64::INFINITY], &mut waiting, |piece| {
                        let near = to.solid[piece.near as usize];
                        patches.push(Patch { triangle, near, weights: piece.weights });
                    });
                most = most.max(found.at_most);
            }
        }
        Ok((made, bound(most, rounding)))
    }

    /// Bounds the distance in another pose. Returns `floor` where the distance is no larger, otherwise a bound that no
    /// point of either surface exceeds, at most 1 % above the true distance.
    ///
    /// # Errors
    /// A coordinate is not finite, or only one of the meshes has a triangle with area in this pose.
    pub fn at_most(&mut self, context: &Context, points: &[[f32; 3]], floor: f32) -> Result<f32> {
        let corners = |[a, b, c]: [u32; 3]| [a, b, c].map(|vertex| exact(points[vertex as usize]));
        let extent = points.iter().flatten().fold(0.0f32, |most, value| most.max(value.abs()));
        let rounding = Surface::rounding_of(extent);
        let mut most = f64::from(floor);
        let mut surfaces: Option<[Surface; 2]> = None;
        let (mut waiting, mut finer) = (Vec::new(), Vec::new());
        for side in 0..2 {
            for index in 0..self.patches[side].len() {
                let patch = self.patches[side][index];
                let [a, b, c] = corners(self.triangles[side][patch.triangle as usize]);
                let places = patch.weights.map(|weight| a * weight.x + b * weight.y + c * weight.z);
                let near = corners(self.triangles[1 - side][patch.near as usize]);
                if places.iter().all(|place| gap(*place, near) * (1.0 + 1e-9) + 1e-6 * rounding <= most) {
                    continue;
                }
                let surfaces = match &surfaces {
                    Some(surfaces) => surfaces,
                    None => {
                        let [first, second] =
                            self.triangles.map(|triangles| Surface::new(context, (points, triangles)));
                        let made = surfaces.insert([first?, second?]);
                        made[0].check(&made[1])?;
                        made
                    }
                };
                let to = &surfaces[1 - side];
                if to.solid.is_empty() {
                    return Ok(floor);
                }
                let near = match to.solid.binary_search(&patch.near) {
                    Ok(near) => near as u32,
                    Err(_) => to.nearest(places[0], NONE).triangle,
                };
                waiting.clear();
                waiting.push(Piece { corners: places, weights: patch.weights, near });
                finer.clear();
                let start = Farthest { at_least: 0.0, at_most: 0.0, near, place: DVec3::ZERO };
                let found = to.refine(start, [most, f64::INFINITY], &mut waiting, |piece| {
                    finer.push(Patch { near: to.solid[piece.near as usize], weights: piece.weights, ..patch });
                });
                if found.at_most > most {
                    most = f64::from(bound(found.at_most, rounding));
                }
                let patches = &mut self.patches[side];
                if patches.len() + finer.len() <= MOST_PIECES * self.triangles[side].len()
                    && let Some(last) = finer.pop()
                {
                    patches[index] = last;
                    patches.append(&mut finer);
                }
            }
        }
        Ok(most as f32)
    }
}

/// Returns a distance in single precision that holds it with the rounding of pieces.
fn bound(distance: f64, rounding: f64) -> f32 {
    ((distance * (1.0 + 1e-9) + 1e-6 * rounding) as f32).next_up()
}
