//! The place of the displaced surface that is nearest to a point of the world, where a brush is put.
//!
//! Tiles come from the hierarchy. Each is sampled on a lattice; from the best samples Gauss-Newton steps go to the
//! place itself, whose tangents are differences of displaced points. Units: world units.

use glam::{DMat3, DVec2, DVec3};
use relievo_core::{Context, Result};
use relievo_surface::{Grid, Place, Placement};
use relievo_tiles::{Displaced, Points};

use crate::obb::Obb;
use crate::object::DisplacedObject;

/// A place of a displaced surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfacePoint {
    /// The place.
    pub place: Place,
    /// Where it is in the world.
    pub point: DVec3,
    /// The unit normal.
    pub normal: DVec3,
    /// The unit direction in which u grows; zero where there is none.
    pub tangent: DVec3,
    /// How far it is from the point that was asked for.
    pub distance: f64,
}

/// Cells along a side of a tile from which the steps start.
const CELLS: u32 = 8;
/// Tiles that are looked at closely.
const CLOSEST: usize = 4;
/// Shares of the reach within which the place is looked for first.
const NEARER: [f64; 3] = [1.0 / 64.0, 1.0 / 16.0, 1.0 / 4.0];
/// The parameter difference that tangents are taken over.
const STEP: f32 = 1.0 / 512.0;
/// Steps toward the place.
const STEPS: usize = 24;

impl DisplacedObject {
    /// The place of the displaced surface nearest to `point`, if one is no further than `within`. `None` too if a
    /// number is not finite. Where the surface bends strongly within a tenth of a tile, a place nearly as near may be
    /// found instead.
    pub fn nearest(&self, context: &Context, point: DVec3, within: f64) -> Result<Option<SurfacePoint>> {
        self.nearest_of(context, &self.displaced()?, point, within)
    }

    /// As [`Self::nearest`], of the surface with displacements it had before, which reach no further than those it has.
    pub(crate) fn nearest_of(
        &self,
        context: &Context,
        displaced: &Displaced<'_>,
        point: DVec3,
        within: f64,
    ) -> Result<Option<SurfacePoint>> {
        if !point.is_finite() || !within.is_finite() || within < 0.0 {
            return Ok(None);
        }
        // Whatever is found within a box around the point is the nearest if it is no further than the box reaches, so
        // that a point on a surface of many tiles costs a few of them.
        for share in NEARER {
            if let Some(found) = self.nearest_within(context, displaced, point, share * within)? {
                return Ok(Some(found));
            }
        }
        self.nearest_within(context, displaced, point, within)
    }

    /// The nearest place of the tiles in reach.
    fn nearest_within(
        &self,
        context: &Context,
        displaced: &Displaced<'_>,
        point: DVec3,
        within: f64,
    ) -> Result<Option<SurfacePoint>> {
        let around = Obb { center: point, axes: DMat3::IDENTITY, half: DVec3::splat(within) };
        let mut tiles = self.tiles_near(context, &around);
        tiles.sort_unstable();
        let grid = Grid::whole(CELLS, Placement::Lattice);
        let starts = context.map(tiles.len(), |index| -> Result<(f64, Place)> {
            let mut points = Points::default();
            displaced.grid(context, tiles[index], &grid, &mut points)?;
            let distances = points.p.iter().map(|p| self.world(*p).distance_squared(point));
            let (at, least) = distances
                .enumerate()
                .fold((0, f64::INFINITY), |best, (at, distance)| if distance < best.1 { (at, distance) } else { best });
            let side = CELLS + 1;
            let [u, v] = [at as u32 % side, at as u32 / side].map(|i| i as f32 / CELLS as f32);
            Ok((least, Place::new(tiles[index], u, v)))
        });
        let mut starts = starts.into_iter().collect::<Result<Vec<_>>>()?;
        starts.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut best: Option<SurfacePoint> = None;
        for (_, place) in starts.into_iter().take(CLOSEST) {
            let found = self.descend(context, displaced, place, point)?;
            if best.is_none_or(|best| found.distance < best.distance) {
                best = Some(found);
            }
        }
        Ok(best.filter(|found| found.distance <= within))
    }

    fn world(&self, point: [f32; 3]) -> DVec3 {
        self.transform.transform_point3(DVec3::from(point.map(f64::from)))
    }

    /// Gauss-Newton steps from `start` toward `point`; the best place on the way.
    fn descend(
        &self,
        context: &Context,
        displaced: &Displaced<'_>,
        start: Place,
        point: DVec3,
    ) -> Result<SurfacePoint> {
        let outwards = self.transform.matrix3.inverse().transpose();
        let mut points = Points::default();
        let mut look = |place: Place| -> Result<(SurfacePoint, [DVec3; 2])> {
            // Differences go inwards, so that they stay in the tile.
            let [h, k] = [place.u, place.v].map(|t| if t > 0.5 { -STEP } else { STEP });
            let places = [place, Place { u: place.u + h, ..place }, Place { v: place.v + k, ..place }];
            displaced.evaluate(context, &places, &mut points)?;
            let at = [0, 1, 2].map(|index| self.world(points.p[index]));
            let tangents = [(at[1] - at[0]) / f64::from(h), (at[2] - at[0]) / f64::from(k)];
            let normal = outwards * DVec3::from(points.normal[0].map(f64::from));
            let found = SurfacePoint {
                place,
                point: at[0],
                normal: normal.normalize_or_zero(),
                tangent: tangents[0].normalize_or_zero(),
                distance: at[0].distance(point),
            };
            Ok((found, tangents))
        };
        let (mut best, mut tangents) = look(start)?;
        let mut damping = 1.0;
        for _ in 0..STEPS {
            let [du, dv] = tangents;
            let off = point - best.point;
            let (a, b, c) = (du.length_squared(), du.dot(dv), dv.length_squared());
            let determinant = a * c - b * b;
            if determinant <= 1e-12 * a * c {
                break;
            }
            let (p, q) = (du.dot(off), dv.dot(off));
            let here = DVec2::new(f64::from(best.place.u), f64::from(best.place.v));
            let mut step = DVec2::new(p * c - q * b, q * a - p * b) / determinant;
            // At an edge of the tile only the way along the edge is left.
            let leaves = |at: f64, step: f64| at <= 0.0 && step < 0.0 || at >= 1.0 && step > 0.0;
            if leaves(here.x, step.x) {
                step = DVec2::new(0.0, q / c);
            } else if leaves(here.y, step.y) {
                step = DVec2::new(p / a, 0.0);
            }
            let next = (here + step * damping).clamp(DVec2::ZERO, DVec2::ONE);
            if (next - here).abs().max_element() < 1e-7 {
                break;
            }
            let (found, others) = look(Place::new(best.place.tile, next.x as f32, next.y as f32))?;
            if found.distance < best.distance {
                (best, tangents) = (found, others);
            } else {
                damping *= 0.4;
            }
        }
        Ok(best)
    }
}
