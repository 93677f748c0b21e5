//! The place of a displaced triangle mesh that is nearest to a point of the world, where a brush is put. Units: world
//! units.

use glam::{DMat3, DVec3, Vec3};
use relievo_core::{Context, Result};
use relievo_surface::Place;
use relievo_surface::triangle::closest;

use super::object::{TriangleGround, TriangleObject};
use crate::geometry::obb::Obb;
use crate::object::nearest::SurfacePoint;

impl TriangleObject {
    /// The place of the displaced mesh nearest to `point`, if one is no further than `within`: the face as the tile,
    /// and the barycentric coordinates of its second and third corner. `None` too if a number is not finite. Normals
    /// are as they were renewed last.
    ///
    /// # Errors
    /// Fails as [`Self::displaced`].
    pub fn nearest(&self, context: &Context, point: DVec3, within: f64) -> Result<Option<SurfacePoint>> {
        self.nearest_of(context, self.ground(), point, within)
    }

    /// As [`Self::nearest`], of the surface with a displacement it had before, which reaches no further than the one it
    /// has, and with the normals as they were renewed last.
    pub(crate) fn nearest_of(
        &self,
        context: &Context,
        ground: TriangleGround<'_>,
        point: DVec3,
        within: f64,
    ) -> Result<Option<SurfacePoint>> {
        if !point.is_finite() || !within.is_finite() || within < 0.0 {
            return Ok(None);
        }
        // Most often it is much nearer, and then there are fewer faces to look at.
        for part in [64.0, 8.0] {
            if let Some(found) = self.nearest_within(context, ground, point, within / part)? {
                return Ok(Some(found));
            }
        }
        self.nearest_within(context, ground, point, within)
    }

    fn nearest_within(
        &self,
        context: &Context,
        ground: TriangleGround<'_>,
        point: DVec3,
        within: f64,
    ) -> Result<Option<SurfacePoint>> {
        let around = Obb { center: point, axes: DMat3::IDENTITY, half: DVec3::splat(within) };
        let faces = self.faces_near(context, &around, Some(ground));
        let displaced = self.displaced_by(ground)?;
        let scale = self.transform.matrix3;
        let stretch =
            (scale.x_axis.length_squared() + scale.y_axis.length_squared() + scale.z_axis.length_squared()).sqrt();
        // No point of a face is nearer than its sphere.
        let mut bounds: Vec<(f64, u32)> = faces
            .into_iter()
            .map(|face| {
                let corners = self.surface.corner_points(face).map(|p| self.world(Vec3::from(p)));
                let center = (corners[0] + corners[1] + corners[2]) / 3.0;
                let radius = corners.iter().map(|corner| corner.distance(center)).fold(0.0, f64::max);
                let far = stretch * f64::from(ground.reach(face));
                (center.distance(point) - radius - far, face)
            })
            .collect();
        bounds.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let mut best: Option<(f64, u32, DVec3, DVec3)> = None;
        for (bound, face) in bounds {
            if bound > best.map_or(within, |best| best.0) {
                break;
            }
            let rates = displaced.rates(face);
            let places = rates.places();
            let points: Vec<DVec3> =
                places.iter().map(|(pattern, node)| self.world(displaced.point(face, *pattern, *node))).collect();
            for triangle in rates.triangles() {
                let corners = triangle.map(|at| points[at as usize]);
                let shares = closest(point, corners);
                let found = corners[0] * shares[0] + corners[1] * shares[1] + corners[2] * shares[2];
                let distance = found.distance(point);
                if distance <= within && best.is_none_or(|best| distance < best.0) {
                    let at = triangle.iter().zip(shares).map(|(at, share)| {
                        let (pattern, node) = places[*at as usize];
                        let unit = 1.0 / (3.0 * f64::from(pattern.segments()));
                        DVec3::from(pattern.weights(node).map(f64::from)) * (unit * share)
                    });
                    best = Some((distance, face, found, at.sum()));
                }
            }
        }
        Ok(best.map(|(distance, face, found, at)| {
            let at = at.as_vec3().to_array();
            let normals = self.surface.corner_normals(face).map(Vec3::from);
            let smooth = (normals[0] * at[0] + normals[1] * at[1] + normals[2] * at[2]).normalize_or_zero();
            let normal = self.normals.value(smooth, face, at).as_dvec3();
            let corners = self.surface.corner_points(face).map(|p| self.world(Vec3::from(p)));
            SurfacePoint {
                place: Place::new(face, at[1], at[2]),
                point: found,
                normal: (self.transform.matrix3.inverse().transpose() * normal).normalize_or_zero(),
                tangent: (corners[1] - corners[0]).normalize_or_zero(),
                distance,
            }
        }))
    }

    fn world(&self, point: Vec3) -> DVec3 {
        self.transform.transform_point3(point.as_dvec3())
    }
}
