//! How an influence falls: how much of an edit a place of a brush's box gets, or of a handle's region, from 1 in the middle
//! to 0.
//!
//! Schäfer, Keinert, Nießner and Stamminger 2015, Local Painting and Deformation of Meshes on the GPU, Section 3. The
//! place is given in the brush's own coordinates, −1 to 1 along each axis of the box; r is its distance from the
//! middle, so that r = 1 is the ellipsoid that touches the box from inside.

/// A formula for the share of an edit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(u32)]
pub enum Falloff {
    /// 1 in the whole box.
    Constant = 0,
    /// 1 − r.
    Linear = 1,
    /// 1 − 3r² + 2r³, flat in the middle and at the rim.
    #[default]
    Smooth = 2,
    /// √(1 − r²), a half ball.
    Sphere = 3,
    /// A bell whose standard deviation is a third of r = 1, lowered and scaled so that it ends at 0.
    Gaussian = 4,
}

/// The bell at r = 1, before it is lowered: e^−4.5.
const RIM: f32 = 0.011_108_997;

impl Falloff {
    /// All formulas and their names in scene files.
    pub const NAMES: [(Falloff, &'static str); 5] = [
        (Falloff::Constant, "constant"),
        (Falloff::Linear, "linear"),
        (Falloff::Smooth, "smooth"),
        (Falloff::Sphere, "sphere"),
        (Falloff::Gaussian, "gaussian"),
    ];

    /// The share at a place of the brush, 0 to 1; 0 outside the box.
    pub fn share(self, place: [f32; 3]) -> f32 {
        let inside = place.iter().all(|value| value.abs() <= 1.0);
        if inside { self.of_square(place.iter().map(|value| value * value).sum()) } else { 0.0 }
    }

    /// The share at a distance of `r` from the middle of a ball whose radius is 1; 0 outside the ball.
    pub fn at(self, r: f32) -> f32 {
        if (0.0..=1.0).contains(&r) { self.of_square(r * r) } else { 0.0 }
    }

    /// The share at a place inside the box whose r² is `square`.
    #[inline(always)]
    pub fn of_square(self, square: f32) -> f32 {
        let r = square.sqrt();
        if self == Falloff::Constant {
            return 1.0;
        }
        if square >= 1.0 {
            return 0.0;
        }
        match self {
            Falloff::Constant => 1.0,
            Falloff::Linear => 1.0 - r,
            Falloff::Smooth => (1.0 - r) * (1.0 - r) * (1.0 + 2.0 * r),
            Falloff::Sphere => (1.0 - square).sqrt(),
            Falloff::Gaussian => ((-4.5 * square).exp() - RIM) / (1.0 - RIM),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    /// Over the square from −1 to 1 in the plane through the middle.
    fn integral(falloff: Falloff) -> f64 {
        let n = 1000;
        let at = |k: i32| (f64::from(k) + 0.5) / f64::from(n) * 2.0 - 1.0;
        let places = (0..n).flat_map(|j| (0..n).map(move |i| [at(i) as f32, at(j) as f32, 0.0]));
        places.map(|place| f64::from(falloff.share(place))).sum::<f64>() * 4.0 / f64::from(n * n)
    }

    #[test]
    fn integrals_over_the_disc_are_those_of_the_formulas() {
        let rim = (-4.5f64).exp();
        let bell = 2.0 * PI * ((1.0 - rim) / 9.0 - rim / 2.0) / (1.0 - rim);
        let expected = [4.0, PI / 3.0, 0.3 * PI, 2.0 * PI / 3.0, bell];
        for ((falloff, name), expected) in Falloff::NAMES.into_iter().zip(expected) {
            let found = integral(falloff);
            assert!((found - expected).abs() < 1e-4 * expected, "{name}: {found} {expected}");
        }
    }

    #[test]
    fn shares_begin_at_one_and_end_at_zero() {
        for (falloff, name) in Falloff::NAMES {
            assert!((falloff.share([0.0; 3]) - 1.0).abs() < 1e-6, "{name}");
            assert_eq!(falloff.share([0.0, 1.0001, 0.0]), 0.0, "{name}");
            assert_eq!(falloff.share([f32::NAN, 0.0, 0.0]), 0.0, "{name}");
            assert_eq!(falloff.at(0.3), falloff.share([0.0, 0.3, 0.0]), "{name}");
            assert_eq!([falloff.at(1.0001), falloff.at(f32::NAN)], [0.0; 2], "{name}");
            let ends = if falloff == Falloff::Constant { 1.0 } else { 0.0 };
            assert_eq!(falloff.share([1.0, 0.0, 0.0]), ends, "{name}");
            // Never more on the way out.
            let shares: Vec<f32> = (0..=100).map(|k| falloff.share([0.0, 0.0, k as f32 / 100.0])).collect();
            assert!(shares.windows(2).all(|pair| pair[0] >= pair[1] && pair[1] >= 0.0), "{name}");
        }
    }
}
