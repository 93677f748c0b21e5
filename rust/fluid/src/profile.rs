//! How the weight of a particle falls off, over s, the square of the distance divided by that of the support radius: from
//! 1 at the particle (of Gaussians nearly) to 0 at s = 1. Written for loops over lanes, which take both sides of a branch.

use relievo_core::simd::Arithmetic;

/// A profile of weights.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Profile {
    /// exp(−a s) − exp(−a), with this a (Blinn 1982, cut at the support radius and lowered to 0 there).
    Gaussian(f32),
    /// The cubic spline (Monaghan 1992) divided by its value at 0.
    Spline,
    /// (1 − s)³ (Zhu, Bridson 2005, Section 5).
    Cubic,
}

/// What the loops over particles are compiled for.
pub(crate) trait Weight: Copy {
    /// The weight at s, from 0 to 1.
    fn weight<A: Arithmetic>(self, s: f32) -> f32;

    /// The derivative of the weight by s. At the particle that of the spline is the limit.
    fn slope<A: Arithmetic>(self, s: f32) -> f32;
}

/// Evaluates an expression in which `$weight` is the [`Weight`] of a [`Profile`].
macro_rules! with_weight {
    ($profile:expr, $weight:ident => $work:expr) => {
        match $profile {
            $crate::profile::Profile::Gaussian(sharpness) => {
                let $weight = $crate::profile::Gaussian { sharpness, floor: (-sharpness).exp() };
                $work
            }
            $crate::profile::Profile::Spline => {
                let $weight = $crate::profile::Spline;
                $work
            }
            $crate::profile::Profile::Cubic => {
                let $weight = $crate::profile::Cubic;
                $work
            }
        }
    };
}
pub(crate) use with_weight;

impl Profile {
    /// The weight at s, 0 from 1 on.
    pub fn at(self, s: f32) -> f32 {
        if s < 1.0 { with_weight!(self, weight => weight.weight::<relievo_core::simd::Baseline>(s)) } else { 0.0 }
    }
}

/// See [`Profile::Gaussian`].
#[derive(Clone, Copy)]
pub(crate) struct Gaussian {
    pub sharpness: f32,
    pub floor: f32,
}

/// See [`Profile::Spline`].
#[derive(Clone, Copy)]
pub(crate) struct Spline;

/// See [`Profile::Cubic`].
#[derive(Clone, Copy)]
pub(crate) struct Cubic;

/// exp(x) within some 1e-7 of it, for −80 ≤ x ≤ 0: 2ⁿ times a polynomial, without a branch.
#[inline(always)]
fn exp<A: Arithmetic>(x: f32) -> f32 {
    // Adding this leaves the nearest whole number in the lowest bits.
    const ROUND: f32 = 12_582_912.0;
    let scaled = x * std::f32::consts::LOG2_E;
    let round = scaled + ROUND;
    let rest = (scaled - (round - ROUND)) * std::f32::consts::LN_2;
    // Taylor's series: |rest| is at most ln 2 / 2.
    let mut sum = 1.0 / 5040.0;
    for factor in [1.0 / 720.0, 1.0 / 120.0, 1.0 / 24.0, 1.0 / 6.0, 0.5, 1.0, 1.0] {
        sum = A::fma(sum, rest, factor);
    }
    sum * f32::from_bits((round.to_bits() << 23).wrapping_add(1.0f32.to_bits()))
}

impl Weight for Gaussian {
    #[inline(always)]
    fn weight<A: Arithmetic>(self, s: f32) -> f32 {
        (exp::<A>(-self.sharpness * s) - self.floor).max(0.0)
    }

    #[inline(always)]
    fn slope<A: Arithmetic>(self, s: f32) -> f32 {
        -self.sharpness * exp::<A>(-self.sharpness * s)
    }
}

impl Weight for Spline {
    #[inline(always)]
    fn weight<A: Arithmetic>(self, s: f32) -> f32 {
        let q = s.sqrt();
        let rest = 1.0 - q;
        let near = A::fma(6.0 * s, q - 1.0, 1.0);
        let far = 2.0 * rest * rest * rest;
        if s <= 0.25 { near } else { far }
    }

    #[inline(always)]
    fn slope<A: Arithmetic>(self, s: f32) -> f32 {
        let q = s.sqrt();
        let rest = 1.0 - q;
        let near = A::fma(9.0, q, -6.0);
        let far = -3.0 * rest * rest / q;
        if s <= 0.25 { near } else { far }
    }
}

impl Weight for Cubic {
    #[inline(always)]
    fn weight<A: Arithmetic>(self, s: f32) -> f32 {
        let rest = 1.0 - s;
        rest * rest * rest
    }

    #[inline(always)]
    fn slope<A: Arithmetic>(self, s: f32) -> f32 {
        let rest = 1.0 - s;
        -3.0 * rest * rest
    }
}

#[cfg(test)]
mod tests {
    use relievo_core::simd::Baseline;

    use super::*;
    use crate::Kernels;

    #[test]
    fn the_exponential_is_that_of_the_library() {
        for step in 0..=80_000 {
            let x = step as f32 * -1e-3;
            let (found, expected) = (exp::<Baseline>(x), x.exp());
            assert!((found - expected).abs() <= 1e-5 * expected, "{x}: {found} {expected}");
        }
    }

    #[test]
    fn the_spline_is_the_kernel_and_slopes_are_those_of_the_weights() {
        let kernels = Kernels::new(1.0);
        for s in [0.01f32, 0.1, 0.24, 0.26, 0.5, 0.9, 0.99] {
            assert!((Profile::Spline.at(s) - kernels.spline(s.sqrt()) / kernels.spline(0.0)).abs() < 1e-6);
            for profile in [Profile::Gaussian(8.0), Profile::Spline, Profile::Cubic] {
                let slope = (profile.at(s + 1e-3) - profile.at(s - 1e-3)) / 2e-3;
                let found = with_weight!(profile, weight => weight.slope::<Baseline>(s));
                assert!((found - slope).abs() < 0.01, "{profile:?} {s}: {found} {slope}");
            }
        }
        for profile in [Profile::Gaussian(8.0), Profile::Spline, Profile::Cubic] {
            assert!((profile.at(0.0) - 1.0).abs() < 1e-3 && profile.at(1.0 - 1e-7) < 1e-6 && profile.at(1.0) == 0.0);
        }
    }
}
