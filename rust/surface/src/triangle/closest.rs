//! The point of a triangle that is nearest to another point.

use glam::DVec3;

/// The shares of the corners at the point of a triangle that is nearest to `p`, by the region of the plane `p` is in
/// (Ericson 2004, Real-Time Collision Detection, Section 5.1.5). A triangle without an area is one of its sides.
pub fn closest(p: DVec3, [a, b, c]: [DVec3; 3]) -> [f64; 3] {
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
    use proptest::prelude::*;

    use super::*;

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
