//! Cones of normals (Sederberg and Meyers 1988, *Loop detection in surface patch intersections*): a cheap bound of all
//! normals of a patch from the cones of its two tangent directions.

use glam::DVec3;

use crate::patch::PatchForm;

/// A cone of directions around a unit axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cone {
    /// Unit axis.
    pub axis: [f32; 3],
    /// Cosine of the half angle; −1 if the directions are not bounded.
    pub cosine: f32,
}

impl Cone {
    /// The cone of all directions.
    pub const ALL: Cone = Cone { axis: [0.0, 0.0, 1.0], cosine: -1.0 };

    /// The least and the largest of `direction · n` over unit normals n in the cone, for a direction of any length.
    pub fn span(&self, direction: [f32; 3]) -> (f32, f32) {
        let length = direction.iter().map(|value| value * value).sum::<f32>().sqrt();
        if self.cosine <= -1.0 || length == 0.0 {
            return (-length, length);
        }
        let along = (0..3).map(|i| self.axis[i] * direction[i]).sum::<f32>() / length;
        let along = along.clamp(-1.0, 1.0);
        let sine = (1.0 - self.cosine * self.cosine).max(0.0).sqrt();
        let across = (1.0 - along * along).max(0.0).sqrt();
        // cos(angle ± half), held at ±1 where the direction itself or its opposite is inside the cone.
        let most = if along >= self.cosine { 1.0 } else { along * self.cosine + across * sine };
        let least = if along <= -self.cosine { -1.0 } else { along * self.cosine - across * sine };
        (least * length, most * length)
    }
}

/// The cone of a patch's normals; `points` are all x, all y, all z of its control points.
pub(crate) fn of_patch(form: PatchForm, points: &[f32]) -> Cone {
    let count = points.len() / 3;
    let point = |i: usize| DVec3::from_array(std::array::from_fn(|axis| f64::from(points[axis * count + i])));
    let cones = match form {
        PatchForm::Bezier => {
            let (mut in_u, mut in_v) = ([DVec3::ZERO; EDGES], [DVec3::ZERO; EDGES]);
            for row in 0..4 {
                for k in 0..3 {
                    in_u[3 * row + k] = point(4 * row + k + 1) - point(4 * row + k);
                    in_v[3 * row + k] = point(4 * (k + 1) + row) - point(4 * k + row);
                }
            }
            [of_directions(&in_u), of_directions(&in_v)]
        }
        PatchForm::Gregory => {
            let bezier = |i: usize| GREGORY[i].map(&point);
            // What is left out stays zero, and does not count.
            let (mut in_u, mut in_v) = ([DVec3::ZERO; 4 * EDGES], [DVec3::ZERO; 4 * EDGES]);
            for row in 0..4 {
                for k in 0..3 {
                    let at = 4 * (3 * row + k);
                    differences(bezier(4 * row + k), bezier(4 * row + k + 1), &mut in_u[at..]);
                    differences(bezier(4 * k + row), bezier(4 * (k + 1) + row), &mut in_v[at..]);
                }
            }
            [of_directions(&in_u), of_directions(&in_v)]
        }
    };
    let [Some((u, sine_u)), Some((v, sine_v))] = cones else {
        return Cone::ALL;
    };
    let normal = u.cross(v);
    let sine = normal.length();
    let cosine = u.dot(v).abs();
    if sine < 1e-6 {
        return Cone::ALL;
    }
    let spread = (sine_u * sine_u + 2.0 * sine_u * sine_v * cosine + sine_v * sine_v).sqrt() / sine;
    if spread >= 1.0 {
        return Cone::ALL;
    }
    // Rounded outwards by more than the error of f32.
    let cosine = ((1.0 - spread * spread).sqrt() - 1e-5) as f32;
    Cone { axis: (normal / sine).as_vec3().to_array(), cosine }
}

/// The Gregory points of every Bézier point; interior ones have two, between which the patch blends.
pub(crate) const GREGORY: [[usize; 2]; 16] = [
    [0, 0],
    [1, 1],
    [7, 7],
    [5, 5],
    [2, 2],
    [3, 4],
    [8, 9],
    [6, 6],
    [16, 16],
    [18, 19],
    [13, 14],
    [12, 12],
    [15, 15],
    [17, 17],
    [11, 11],
    [10, 10],
];

/// Edges of a net of 4 × 4 points along one parameter.
const EDGES: usize = 12;

fn differences(from: [DVec3; 2], to: [DVec3; 2], out: &mut [DVec3]) {
    for a in 0..2 {
        for b in 0..2 {
            if (a == 0 || from[0] != from[1]) && (b == 0 || to[0] != to[1]) {
                out[2 * a + b] = to[b] - from[a];
            }
        }
    }
}

/// The axis of a cone around all directions and the sine of its half angle; `None` if it is wider than a half space.
/// Vanishing directions do not count, since they do not turn the tangent.
fn of_directions(directions: &[DVec3]) -> Option<(DVec3, f64)> {
    let axis = directions.iter().filter_map(|d| d.try_normalize()).sum::<DVec3>().try_normalize()?;
    let mut cosine: f64 = 1.0;
    for direction in directions.iter().filter_map(|d| d.try_normalize()) {
        cosine = cosine.min(axis.dot(direction));
    }
    (cosine > 0.0).then(|| (axis, (1.0 - cosine * cosine).max(0.0).sqrt()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_span_of_a_cone_is_that_of_its_directions() {
        let cone = Cone { axis: [0.0, 0.0, 1.0], cosine: 0.8 };
        for direction in [[1.0, 0.0, 0.0], [0.2, 0.3, 2.0], [0.0, 0.0, -3.0], [1.0, 1.0, -1.0]] {
            let (least, most) = cone.span(direction);
            let (mut low, mut high) = (f32::MAX, f32::MIN);
            for step in 0..720 {
                let around = step as f32 * std::f32::consts::PI / 360.0;
                for height in 0..=50 {
                    let z = 0.8 + 0.2 * height as f32 / 50.0;
                    let r = (1.0 - z * z).sqrt();
                    let dot = direction[0] * r * around.cos() + direction[1] * r * around.sin() + direction[2] * z;
                    (low, high) = (low.min(dot), high.max(dot));
                }
            }
            assert!((low - least).abs() < 1e-2 && (high - most).abs() < 1e-2, "{direction:?}");
        }
    }
}
