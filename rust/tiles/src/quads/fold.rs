//! Counts the folds of a displaced surface: places where a displacement goes deeper than the surface is bent, as under a
//! press through a thin part. Meshes overlap themselves there, and pictures show streaks.
//!
//! For a displacement D along the normal N the derivatives of `S + D·N` in the tangent plane are those of S times
//! `I + D·dN`. A triangle is folded where that map has a negative eigenvalue, which shows in its determinant or its
//! trace: D goes beyond a centre of curvature. Slopes of D do not count, so that no height folds a plane. The map is
//! taken from the corners of the triangle before and after. Tiles with vectors are left out: vectors may overhang.

use glam::{DVec3, Vec3};
use relievo_core::{Context, Result};
use relievo_surface::{Grid, Order, Placement, Samples};

use crate::quads::displaced::{Displaced, Points};
use crate::triangle::{FaceRates, TriangleDisplaced};

/// Triangles of displaced tiles, or faces of a triangle mesh, and how many of them are folded.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Folds {
    /// Triangles: two for each coefficient of the tiles that have any, those of the displaced faces of a triangle mesh.
    pub triangles: u64,
    /// Triangles that the displacement turns over.
    pub folded: u64,
    /// The tile or face with most of them, the first of equals; `None` where nothing is folded.
    pub worst: Option<u32>,
}

impl Folds {
    fn sum(counts: impl Iterator<Item = (u32, Count)>) -> Self {
        let (mut all, mut most) = (Self::default(), 0);
        for (tile, count) in counts {
            all.triangles += count.triangles;
            all.folded += count.folded;
            if count.folded > most {
                (all.worst, most) = (Some(tile), count.folded);
            }
        }
        all
    }
}

/// The triangles of one tile.
#[derive(Clone, Copy, Default)]
struct Count {
    triangles: u64,
    folded: u64,
}

impl Count {
    fn add(&mut self, before: [Vec3; 3], after: [Vec3; 3]) {
        self.triangles += 1;
        self.folded += u64::from(is_folded(before, after));
    }
}

/// Whether the map from one triangle to another, seen in the plane of the first, has a negative eigenvalue.
fn is_folded(before: [Vec3; 3], after: [Vec3; 3]) -> bool {
    let sides = |corners: [Vec3; 3]| {
        let [a, b, c] = corners.map(Vec3::as_dvec3);
        [b - a, c - a]
    };
    let [u, v] = sides(before);
    let normal = u.cross(v);
    // A triangle without an area has no inside to be turned out.
    if normal == DVec3::ZERO {
        return false;
    }
    let [s, t] = sides(after);
    let trace = v.dot(v) * u.dot(s) - u.dot(v) * (u.dot(t) + v.dot(s)) + u.dot(u) * v.dot(t);
    normal.dot(s.cross(t)) < 0.0 || trace < 0.0
}

impl Displaced<'_> {
    /// Counts the folds of all tiles with a displacement and without vectors.
    ///
    /// # Errors
    /// If memory for the points of a tile is refused.
    pub fn folds(&self, context: &Context) -> Result<Folds> {
        let has_vectors = |tile: u32| self.vectors().is_some_and(|vectors| vectors.is_allocated(tile));
        let tiles: Vec<u32> = self.field().allocated().filter(|tile| !has_vectors(*tile)).collect();
        let counts: Result<Vec<Count>> =
            context.map(tiles.len(), |index| self.tile_folds(context, tiles[index])).into_iter().collect();
        Ok(Folds::sum(tiles.iter().copied().zip(counts?)))
    }

    fn tile_folds(&self, context: &Context, tile: u32) -> Result<Count> {
        let size = self.field().size(tile);
        let grid = Grid::whole(size, Placement::Lattice);
        let (mut points, mut samples) = (Points::default(), Samples::default());
        self.grid(context, tile, &grid, &mut points)?;
        self.surface().grid(context.level(), tile, &grid, Order::Position, &mut samples);
        let before = |index: usize| Vec3::from([0, 1, 2].map(|axis| samples.p[axis][index]));
        let after = |index: usize| Vec3::from(points.p[index]);
        let row = size as usize + 1;
        let mut count = Count::default();
        for j in 0..size as usize {
            for i in 0..size as usize {
                let corner = j * row + i;
                for triangle in [[corner, corner + 1, corner + row + 1], [corner, corner + row + 1, corner + row]] {
                    count.add(triangle.map(before), triangle.map(after));
                }
            }
        }
        Ok(count)
    }
}

impl TriangleDisplaced<'_> {
    /// Counts the folds of all faces with a displacement and without vectors.
    pub fn folds(&self, context: &Context) -> Folds {
        let faces = self.field().topology().face_count();
        let counts = context.map(faces, |face| self.face_folds(face as u32));
        Folds::sum((0..faces as u32).zip(counts))
    }

    fn face_folds(&self, face: u32) -> Count {
        let has_vectors = self.vectors().is_some_and(|vectors| !FaceRates::of(vectors, face).is_single());
        if has_vectors || !self.is_modified(face) {
            return Count::default();
        }
        let rates = self.rates(face);
        let corners: Vec<[Vec3; 2]> = rates
            .places()
            .into_iter()
            .map(|(pattern, node)| {
                let (foot, height) = self.at(face, pattern, node);
                [foot.point, foot.point + foot.normal * height]
            })
            .collect();
        let mut count = Count::default();
        for triangle in rates.triangles() {
            let [before, after] = [0, 1].map(|moment| triangle.map(|corner| corners[corner as usize][moment]));
            count.add(before, after);
        }
        count
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CORNERS: [Vec3; 3] = [Vec3::ZERO, Vec3::X, Vec3::Y];

    /// The corners as a surface with these principal curvatures moves them: by (1 − depth · k) along each axis.
    fn pressed(depth: f32, curvatures: [f32; 2], slope: f32) -> [Vec3; 3] {
        CORNERS
            .map(|p| Vec3::new(p.x * (1.0 - depth * curvatures[0]), p.y * (1.0 - depth * curvatures[1]), slope * p.x))
    }

    #[test]
    fn what_goes_beyond_a_centre_of_curvature_is_folded() {
        let cases = [
            (0.5, [1.0, 1.0], false),
            (1.5, [1.0, 1.0], true),
            (1.5, [1.0, 0.0], true),
            (1.5, [0.0, 0.5], false),
            (100.0, [0.0, 0.0], false),
            (100.0, [-1.0, -1.0], false),
        ];
        for (depth, curvatures, expected) in cases {
            for slope in [0.0, 50.0] {
                let after = pressed(depth, curvatures, slope);
                assert_eq!(is_folded(CORNERS, after), expected, "{depth} {curvatures:?} {slope}");
            }
        }
        assert!(!is_folded([Vec3::ZERO; 3], pressed(2.0, [1.0, 1.0], 0.0)));
    }
}
