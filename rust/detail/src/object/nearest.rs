//! The place of the displaced surface that is nearest to a point of the world, where a brush is put.
//!
//! Tiles are looked at by the distances of their boxes, which follow the displacement, until no box is left that is
//! nearer than what was found. Each is sampled on a lattice; from the best sample Gauss-Newton steps go to the place
//! itself, whose tangents are differences of displaced points. Units: world units.

use glam::{DVec2, DVec3};
use relievo_core::{Context, Result};
use relievo_surface::{Grid, Place, Placement};
use relievo_tiles::{Displaced, Points};

use crate::geometry::hierarchy::Target;
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
/// The parameter difference that tangents are taken over.
const STEP: f32 = 1.0 / 512.0;
/// Steps toward the place.
const STEPS: usize = 24;

impl DisplacedObject {
    /// The place of the displaced surface nearest to `point`, if one is no further than `within`. `None` too if a
    /// number is not finite. Where the surface bends strongly within a tenth of a tile, a place nearly as near may be
    /// found instead.
    ///
    /// # Errors
    /// Fails as [`Self::displaced`].
    pub fn nearest(&self, context: &Context, point: DVec3, within: f64) -> Result<Option<SurfacePoint>> {
        self.nearest_of(context, &self.displaced()?, point, within)
    }

    /// As [`Self::nearest`], of the surface with displacements it had before, which reach no further than those it has,
    /// or are those of a stroke that is being drawn.
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
        let (hierarchy, reach) = self.bounds();
        let bounds = hierarchy.bounds();
        let size = bounds.low.iter().chain(&bounds.high).fold(0.0, |size: f32, value| size.max(value.abs()));
        // Boxes hold what is exact, and points are rounded.
        let slack = 8.0 * f32::EPSILON * size + 1e-6 * self.surface.extent();
        let Some(target) = Target::new(&self.transform, point, f64::from(reach + slack)) else { return Ok(None) };
        let mut best: Option<SurfacePoint> = None;
        let mut points = context.scratch().lend::<Points>();
        hierarchy.approach(&target, within, |tile| {
            let found = self.nearest_in(context, displaced, tile, point, &mut points)?;
            // Whatever the order in which tiles are looked at, the first of those equally near is taken.
            let key = |found: &SurfacePoint| (found.distance, found.place.tile);
            if found.distance <= within && best.is_none_or(|best| key(&found) < key(&best)) {
                best = Some(found);
            }
            Ok(best.map_or(within, |best| best.distance))
        })?;
        Ok(best)
    }

    /// The nearest place of one tile.
    fn nearest_in(
        &self,
        context: &Context,
        displaced: &Displaced<'_>,
        tile: u32,
        point: DVec3,
        points: &mut Points,
    ) -> Result<SurfacePoint> {
        displaced.grid(context, tile, &Grid::whole(CELLS, Placement::Lattice), points)?;
        let distances = points.p.iter().map(|p| self.world(*p).distance_squared(point)).enumerate();
        let (at, _) = distances
            .fold((0, f64::INFINITY), |best, (at, distance)| if distance < best.1 { (at, distance) } else { best });
        let side = CELLS + 1;
        let [u, v] = [at as u32 % side, at as u32 / side].map(|i| i as f32 / CELLS as f32);
        self.descend(context, displaced, Place::new(tile, u, v), point)
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
        let mut points = context.scratch().lend::<Points>();
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

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{DAffine3, DMat3};
    use relievo_core::{ContextOptions, Mesh};
    use relievo_surface::{Surface, SurfaceOptions};
    use relievo_tiles::{ChannelOptions, Displacement, VectorDisplacement};

    use crate::object::canvas::{Canvas, Start};
    use crate::paint::dab::Action;
    use crate::paint::mode::SculptMode;
    use crate::paint::open::OpenStroke;
    use crate::paint::path::StrokePoint;
    use crate::paint::stroke::{Stroke, StrokeSettings};
    use relievo_core::Falloff;

    const SIDE: u32 = 9;

    /// A closed ring of quads, radii 2 and 1.
    fn torus() -> Mesh {
        let point = |k: u32| {
            let [a, b] = [k % SIDE, k / SIDE].map(|k| std::f32::consts::TAU * k as f32 / SIDE as f32);
            [(2.0 + b.cos()) * a.cos(), (2.0 + b.cos()) * a.sin(), b.sin()]
        };
        let corner = |i: u32, j: u32| i % SIDE + j % SIDE * SIDE;
        let corners = (0..SIDE * SIDE).flat_map(|k| {
            let (i, j) = (k % SIDE, k / SIDE);
            [corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)]
        });
        Mesh::new((0..SIDE * SIDE).map(point).collect(), vec![4; (SIDE * SIDE) as usize], corners.collect())
    }

    /// Numbers that look random.
    struct Chance(u64);

    impl Chance {
        fn between(&mut self, low: f64, high: f64) -> f64 {
            self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            low + (high - low) * ((self.0 >> 11) as f64 / (1u64 << 53) as f64)
        }

        fn point(&mut self, far: f64) -> DVec3 {
            DVec3::new(self.between(-far, far), self.between(-far, far), self.between(-far, far))
        }
    }

    /// The nearest place of all tiles, looked at one by one.
    fn of_all_tiles(
        context: &Context,
        object: &DisplacedObject,
        start: &Start,
        point: DVec3,
        within: f64,
    ) -> Option<SurfacePoint> {
        let displaced = start.ground().unwrap().displaced(object.surface()).unwrap();
        let tiles = 0..object.surface().tile_count() as u32;
        let found =
            tiles.map(|tile| object.nearest_in(context, &displaced, tile, point, &mut Points::default()).unwrap());
        let nearest = found.min_by(|a, b| a.distance.total_cmp(&b.distance).then(a.place.tile.cmp(&b.place.tile)));
        nearest.filter(|found| found.distance <= within)
    }

    #[test]
    fn what_is_found_is_the_nearest_of_all_tiles_while_a_stroke_is_drawn() {
        let mesh = torus();
        let turn = DMat3::from_euler(glam::EulerRot::XYZ, 0.3, 1.1, -0.4);
        let sheared = DMat3::from_cols(DVec3::new(1.2, 0.5, 0.0), DVec3::Y, DVec3::new(0.0, -0.4, 0.8));
        let transforms = [DMat3::IDENTITY, turn * DMat3::from_diagonal(DVec3::new(0.5, 2.0, 1.0)), sheared];
        let mut results = Vec::new();
        for threads in [1, 3] {
            let context = Context::new(&ContextOptions { threads, memory_limit: 0 }).unwrap();
            let mut chance = Chance(5);
            let (mut found, mut nothing, mut all) = (0, 0, Vec::new());
            for (round, matrix) in transforms.into_iter().cycle().take(9).enumerate() {
                let surface = Surface::new(&context, &mesh, &SurfaceOptions::default()).unwrap();
                let options = ChannelOptions { size: 8, ..ChannelOptions::default() };
                let displacement = Displacement::new(surface.topology().clone(), &options).unwrap();
                let transform = DAffine3 { matrix3: matrix, translation: DVec3::new(0.3, -0.2, 0.1) };
                let vectors = VectorDisplacement::on(&surface, &options).unwrap();
                let mut object =
                    DisplacedObject::new(&context, surface, &mesh.points, displacement, transform).unwrap();
                if round % 2 == 1 {
                    object.set_vectors(vectors).unwrap();
                }
                for stroke in 0..3 {
                    let scale = chance.between(0.8, 1.2) as f32;
                    let cage: Vec<[f32; 3]> = mesh.points.iter().map(|p| [p[0] * scale, p[1], p[2] / scale]).collect();
                    object.pose(&context, &cage).unwrap();
                    let settings = StrokeSettings { radius: 0.5, reach: 20.0, ..Default::default() };
                    let mode = if round % 2 == 1 && stroke == 1 { SculptMode::Pinch } else { SculptMode::Draw };
                    let action = Action::Sculpt { mode, height: chance.between(-0.3, 0.5) as f32 };
                    let stroke = Stroke::new(Vec::new(), settings, Falloff::Smooth, action);
                    let mut open = OpenStroke::begin(&context, stroke, &mut [&mut object]).unwrap();
                    let start = Canvas::begin(&mut object, &context).unwrap();
                    for event in 0..4 {
                        let point = transform.transform_point3(chance.point(2.5));
                        open.extend(&context, &mut [&mut object], &[StrokePoint::new(point, 1.0)]).unwrap();
                        // As a host sees what is drawn; boxes go on following.
                        object.commit();
                        object.commit_vectors();
                        assert!(event == 0 || object.bounds().1 == 0.0);
                        for far in [1.0, 3.0, 9.0] {
                            let point = transform.transform_point3(chance.point(far));
                            let within = chance.between(0.05, 2.0 * far);
                            let near = Canvas::nearest(&object, &context, &start, point, within).unwrap();
                            assert_eq!(near, of_all_tiles(&context, &object, &start, point, within));
                            *if near.is_some() { &mut found } else { &mut nothing } += 1;
                            all.push(near);
                        }
                    }
                    open.end(&context, &mut [&mut object], &[]).unwrap();
                }
            }
            assert!(found > 100 && nothing > 20, "{found} {nothing}");
            results.push(all);
        }
        assert!(results[0] == results[1]);
    }
}
