//! The place of a displaced triangle mesh that is nearest to a point of the world, where a brush is put. Units: world
//! units.

use glam::{DMat3, DVec3, Vec3};
use relievo_core::{Context, Result};
use relievo_surface::Place;
use relievo_tiles::triangle::TriangleField;

use super::object::{TriangleObject, field_range};
use crate::nearest::SurfacePoint;
use crate::obb::Obb;

impl TriangleObject {
    /// The place of the displaced mesh nearest to `point`, if one is no further than `within`: the face as the tile, and
    /// the barycentric coordinates of its second and third corner. `None` too if a number is not finite. Normals are as
    /// they were renewed last.
    pub fn nearest(&self, context: &Context, point: DVec3, within: f64) -> Result<Option<SurfacePoint>> {
        self.nearest_of(context, self.displacement.field(), point, within)
    }

    /// As [`Self::nearest`], of the surface with a displacement it had before, which reaches no further than the one it
    /// has, and with the normals as they were renewed last.
    pub(crate) fn nearest_of(
        &self,
        context: &Context,
        field: &TriangleField,
        point: DVec3,
        within: f64,
    ) -> Result<Option<SurfacePoint>> {
        if !point.is_finite() || !within.is_finite() || within < 0.0 {
            return Ok(None);
        }
        // Most often it is much nearer, and then there are fewer faces to look at.
        for part in [64.0, 8.0] {
            if let Some(found) = self.nearest_within(context, field, point, within / part)? {
                return Ok(Some(found));
            }
        }
        self.nearest_within(context, field, point, within)
    }

    fn nearest_within(
        &self,
        context: &Context,
        field: &TriangleField,
        point: DVec3,
        within: f64,
    ) -> Result<Option<SurfacePoint>> {
        let around = Obb { center: point, axes: DMat3::IDENTITY, half: DVec3::splat(within) };
        let faces = self.faces_near(context, &around, Some(field));
        let displaced = self.displaced_by(field)?;
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
                let [least, most] = field_range(field, face);
                let far = stretch * f64::from(most.max(-least) + self.vector_reach());
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

/// The shares of the corners at the point of a triangle that is nearest to `p`, by the region of the plane `p` is in
/// (Ericson 2004, Real-Time Collision Detection, Section 5.1.5). A triangle without an area is one of its sides.
fn closest(p: DVec3, [a, b, c]: [DVec3; 3]) -> [f64; 3] {
    let (ab, ac, ap) = (b - a, c - a, p - a);
    let (d1, d2) = (ab.dot(ap), ac.dot(ap));
    if d1 <= 0.0 && d2 <= 0.0 {
        return [1.0, 0.0, 0.0];
    }
    let bp = p - b;
    let (d3, d4) = (ab.dot(bp), ac.dot(bp));
    if d3 >= 0.0 && d4 <= d3 {
        return [0.0, 1.0, 0.0];
    }
    let part = |part: f64, whole: f64| if whole > 0.0 { (part / whole).clamp(0.0, 1.0) } else { 0.0 };
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        let t = part(d1, d1 - d3);
        return [1.0 - t, t, 0.0];
    }
    let cp = p - c;
    let (d5, d6) = (ab.dot(cp), ac.dot(cp));
    if d6 >= 0.0 && d5 <= d6 {
        return [0.0, 0.0, 1.0];
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        let t = part(d2, d2 - d6);
        return [1.0 - t, 0.0, t];
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0 {
        let t = part(d4 - d3, (d4 - d3) + (d5 - d6));
        return [0.0, 1.0 - t, t];
    }
    let sum = va + vb + vc;
    let (v, w) = (part(vb, sum), part(vc, sum));
    [1.0 - v - w, v, w]
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn no_place_of_a_triangle_is_nearer(numbers in prop::array::uniform12(-1.0f64..1.0)) {
            let [p, a, b, c] = [0, 3, 6, 9].map(|at| DVec3::from_slice(&numbers[at..]));
            let shares = closest(p, [a, b, c]);
            prop_assert!(shares.iter().all(|share| *share >= -1e-12) && (shares.iter().sum::<f64>() - 1.0).abs() < 1e-12);
            let best = (a * shares[0] + b * shares[1] + c * shares[2]).distance(p);
            for (i, j) in (0..=20).flat_map(|i| (0..=20 - i).map(move |j| (i, j))) {
                let [u, v] = [i, j].map(|k| f64::from(k) / 20.0);
                prop_assert!((a * (1.0 - u - v) + b * u + c * v).distance(p) >= best - 1e-9);
            }
        }
    }

    #[test]
    fn triangles_without_an_area_have_a_nearest_place_too() {
        for corners in [[DVec3::ZERO; 3], [DVec3::ZERO, DVec3::X, 2.0 * DVec3::X], [DVec3::X, DVec3::X, DVec3::Y]] {
            let shares = closest(DVec3::new(0.3, 0.4, 0.5), corners);
            assert!((shares.iter().sum::<f64>() - 1.0).abs() < 1e-12 && shares.iter().all(|share| share.is_finite()));
        }
    }
}
