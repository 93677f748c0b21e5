//! Cubic Bézier curves: basis functions, restriction to an interval, and the exact Bézier form of uniform cubic
//! B-splines with and without a crease.
//!
//! The crease form restates the single-crease patches of Nießner, Loop, Greiner 2012 (*Efficient Evaluation of
//! Semi-Smooth Creases in Catmull-Clark Subdivision Surfaces*) as at most three Bézier pieces per patch.

/// Rows are Bézier points as sums of four B-spline points.
pub type Conversion = [[f64; 4]; 4];

/// Uniform cubic B-spline to Bézier.
pub const SMOOTH: Conversion = [
    [1.0 / 6.0, 4.0 / 6.0, 1.0 / 6.0, 0.0],
    [0.0, 4.0 / 6.0, 2.0 / 6.0, 0.0],
    [0.0, 2.0 / 6.0, 4.0 / 6.0, 0.0],
    [0.0, 1.0 / 6.0, 4.0 / 6.0, 1.0 / 6.0],
];

/// Bernstein polynomials of degree 3 at `t`.
#[inline(always)]
pub fn cubic(t: f32) -> [f32; 4] {
    let s = 1.0 - t;
    [s * s * s, 3.0 * t * s * s, 3.0 * t * t * s, t * t * t]
}

/// First derivatives of the Bernstein polynomials of degree 3 at `t`.
#[inline(always)]
pub fn cubic_first(t: f32) -> [f32; 4] {
    let s = 1.0 - t;
    [-3.0 * s * s, 3.0 * s * (s - 2.0 * t), 3.0 * t * (2.0 * s - t), 3.0 * t * t]
}

/// Second derivatives of the Bernstein polynomials of degree 3 at `t`.
#[inline(always)]
pub fn cubic_second(t: f32) -> [f32; 4] {
    let s = 1.0 - t;
    [6.0 * s, 6.0 * (t - 2.0 * s), 6.0 * (s - 2.0 * t), 6.0 * t]
}

/// The piece over `[from, to]` of the curve that `curve` describes.
pub fn restrict(curve: &Conversion, from: f64, to: f64) -> Conversion {
    // The blossom at three of the interval's ends.
    let blossom = |parameters: [f64; 3]| {
        let mut points = *curve;
        for (round, t) in parameters.iter().enumerate() {
            for k in 0..3 - round {
                points[k] = std::array::from_fn(|i| (1.0 - t) * points[k][i] + t * points[k + 1][i]);
            }
        }
        points[0]
    };
    [blossom([from, from, from]), blossom([from, from, to]), blossom([from, to, to]), blossom([to, to, to])]
}

/// Bézier pieces `(from, to, conversion)` over [0, 1] of the limit of a B-spline with points c0 … c3 whose point c1 (at
/// parameter 0) lies on a crease of the given sharpness.
///
/// After k sharp steps the points around the crease are smooth again, so near it (up to 2^-k) the limit is a uniform
/// B-spline of those points, and beyond it the curve does not know that the crease will end. A fractional step blends
/// the rules and therefore the limits linearly.
pub fn crease_pieces(sharpness: f64) -> Vec<(f64, f64, Conversion)> {
    let sharp = {
        let mut conversion = SMOOTH;
        for row in &mut conversion {
            // The phantom point that keeps the crease on c1: c0 = 2·c1 − c2.
            row[1] += 2.0 * row[0];
            row[2] -= row[0];
            row[0] = 0.0;
        }
        conversion
    };
    if sharpness >= 10.0 {
        return vec![(0.0, 1.0, sharp)];
    }
    let low = sharpness.max(0.0).floor();
    let share = sharpness.max(0.0) - low;
    let piece = |steps: f64, from: f64, to: f64| {
        let end = (-steps).exp2();
        if from >= end {
            restrict(&sharp, from, to)
        } else {
            restrict(&near_crease(steps as u32), from / end, to / end)
        }
    };
    let (near, far) = ((-(low + share.ceil())).exp2(), (-low).exp2());
    let mut pieces = Vec::with_capacity(3);
    for (from, to) in [(0.0, near), (near, far), (far, 1.0)] {
        if from < to {
            let (floor, ceiling) = (piece(low, from, to), piece(low + share.ceil(), from, to));
            let blend = |row: usize, i: usize| (1.0 - share) * floor[row][i] + share * ceiling[row][i];
            pieces.push((from, to, std::array::from_fn(|row| std::array::from_fn(|i| blend(row, i)))));
        }
    }
    pieces
}

/// The Bézier form, over [0, 2^-steps], of the B-spline whose points are c0 … c3 after `steps` sharp subdivisions.
fn near_crease(steps: u32) -> Conversion {
    let mut points = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]];
    for _ in 0..steps {
        let [d0, d1, d2, d3]: [[f64; 4]; 4] = points;
        points = [
            std::array::from_fn(|i| (d0[i] + d1[i]) / 2.0),
            d1,
            std::array::from_fn(|i| (d1[i] + d2[i]) / 2.0),
            std::array::from_fn(|i| (d1[i] + 6.0 * d2[i] + d3[i]) / 8.0),
        ];
    }
    std::array::from_fn(|row| std::array::from_fn(|i| (0..4).map(|k| SMOOTH[row][k] * points[k][i]).sum()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn value(curve: &Conversion, points: [f64; 4], t: f64) -> f64 {
        let s = 1.0 - t;
        let basis = [s * s * s, 3.0 * t * s * s, 3.0 * t * t * s, t * t * t];
        (0..4).map(|row| basis[row] * (0..4).map(|i| curve[row][i] * points[i]).sum::<f64>()).sum()
    }

    /// Subdivides a long control polygon with a crease at its middle and returns limit points.
    fn subdivided(points: &[f64], middle: usize, sharpness: f64, levels: u32) -> (Vec<f64>, usize) {
        let (mut points, mut middle) = (points.to_vec(), middle);
        let mut sharpness = if sharpness >= 10.0 { f64::INFINITY } else { sharpness };
        for _ in 0..levels {
            let mut next = Vec::with_capacity(2 * points.len());
            for i in 0..points.len() - 1 {
                let vertex = if i == 0 { points[0] } else { (points[i - 1] + 6.0 * points[i] + points[i + 1]) / 8.0 };
                let share = if i == middle { sharpness.clamp(0.0, 1.0) } else { 0.0 };
                next.push((1.0 - share) * vertex + share * points[i]);
                next.push((points[i] + points[i + 1]) / 2.0);
            }
            next.push(points[points.len() - 1]);
            middle *= 2;
            sharpness -= 1.0;
            points = next;
        }
        (points, middle)
    }

    #[test]
    fn crease_pieces_are_the_limit_of_subdivision() {
        let polygon = [0.3, -1.0, 2.0, 0.5, 1.5, -0.7, 0.2, 0.9, -0.4];
        let levels = 12;
        for sharpness in [0.0, 0.3, 1.0, 1.75, 2.0, 3.5, 10.0] {
            let (fine, middle) = subdivided(&polygon, 4, sharpness, levels);
            let c = [polygon[3], polygon[4], polygon[5], polygon[6]];
            let pieces = crease_pieces(sharpness);
            assert!(pieces.len() <= 3);
            for (from, to, curve) in pieces {
                for step in 0..=8 {
                    let t = from + (to - from) * f64::from(step) / 8.0;
                    let got = value(&curve, c, (t - from) / (to - from));
                    let at = t * f64::from(1 << levels);
                    let near = middle + at as usize;
                    let expected = fine[near] + (at - at.floor()) * (fine[near + 1] - fine[near]);
                    assert!((got - expected).abs() < 2e-6, "sharpness {sharpness}, t {t}: {got} and {expected}");
                }
            }
        }
    }

    #[test]
    fn basis_functions_sum_to_one_and_their_derivatives_to_zero() {
        for t in [0.0, 0.25, 0.7, 1.0] {
            assert!((cubic(t).iter().sum::<f32>() - 1.0).abs() < 1e-6);
            assert!(cubic_first(t).iter().sum::<f32>().abs() < 1e-5);
            assert!(cubic_second(t).iter().sum::<f32>().abs() < 1e-5);
        }
    }
}
