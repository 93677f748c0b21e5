//! How the weight of a particle falls off, over s, the square of the distance divided by that of the support radius:
//! from 1 at the particle (of Gaussians nearly) to 0 at s = 1. Vectors take both sides of a branch.

use relievo_core::dispatch_simd;
use relievo_core::lanes::Lanes;
use relievo_core::simd::Level;

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
    fn weight<A: Lanes>(self, v: A, s: A::F) -> A::F;

    /// The derivative of the weight by s. At the particle that of the spline is the limit.
    fn slope<A: Lanes>(self, v: A, s: A::F) -> A::F;
}

/// Evaluates an expression in which `$weight` is the [`Weight`] of a [`Profile`].
macro_rules! with_weight {
    ($profile:expr, $weight:ident => $work:expr) => {
        match $profile {
            $crate::surface::profile::Profile::Gaussian(sharpness) => {
                let $weight = $crate::surface::profile::Gaussian::new(sharpness);
                $work
            }
            $crate::surface::profile::Profile::Spline => {
                let $weight = $crate::surface::profile::Spline;
                $work
            }
            $crate::surface::profile::Profile::Cubic => {
                let $weight = $crate::surface::profile::Cubic;
                $work
            }
        }
    };
}
pub(crate) use with_weight;

impl Profile {
    /// The weight at s, 0 from 1 on.
    pub fn at(self, s: f32) -> f32 {
        if s < 1.0 { self.both(s)[0] } else { 0.0 }
    }

    /// The weight and its slope at s, from 0 to 1.
    pub fn both(self, s: f32) -> [f32; 2] {
        both(Level::Baseline, self, s)
    }
}

dispatch_simd! { fn both = both_body(profile: Profile, s: f32) -> [f32; 2] }

/// The weight and its slope.
#[inline(always)]
fn both_body<A: Lanes>(v: A, profile: Profile, s: f32) -> [f32; 2] {
    let s = v.splat(s);
    let both = with_weight!(profile, weight => [weight.weight(v, s), weight.slope(v, s)]);
    both.map(|value| first(v, value))
}

/// The value of the first lane.
#[inline(always)]
fn first<A: Lanes>(v: A, value: A::F) -> f32 {
    let mut lanes = [0.0; WIDEST];
    v.store(value, &mut lanes);
    lanes[0]
}

/// Lanes of the widest vectors.
pub(crate) const WIDEST: usize = 16;

/// The numbers of lanes.
pub(crate) const LANES: [f32; WIDEST] =
    [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 10.0, 11.0, 12.0, 13.0, 14.0, 15.0];

/// See [`Profile::Gaussian`].
#[derive(Clone, Copy)]
pub(crate) struct Gaussian {
    /// How often what is small enough for a series is squared.
    squarings: u32,
    /// What s is multiplied by for that.
    scale: f32,
    sharpness: f32,
    floor: f32,
}

/// See [`Profile::Spline`].
#[derive(Clone, Copy)]
pub(crate) struct Spline;

/// See [`Profile::Cubic`].
#[derive(Clone, Copy)]
pub(crate) struct Cubic;

impl Gaussian {
    pub fn new(sharpness: f32) -> Self {
        let squarings = (2.0 * sharpness).log2().ceil().max(0.0) as u32;
        Self { squarings, scale: -sharpness / (1 << squarings) as f32, sharpness, floor: (-sharpness).exp() }
    }

    /// exp(−sharpness · s), within 1e-7 for every squaring.
    #[inline(always)]
    fn exp<A: Lanes>(self, v: A, s: A::F) -> A::F {
        let x = v.mul(s, v.splat(self.scale));
        // Taylor's series: x is at most 1/2.
        let mut sum = v.splat(1.0 / 5040.0);
        for factor in [1.0 / 720.0, 1.0 / 120.0, 1.0 / 24.0, 1.0 / 6.0, 0.5, 1.0, 1.0] {
            sum = v.fused(sum, x, v.splat(factor));
        }
        for _ in 0..self.squarings {
            sum = v.mul(sum, sum);
        }
        sum
    }
}

impl Weight for Gaussian {
    #[inline(always)]
    fn weight<A: Lanes>(self, v: A, s: A::F) -> A::F {
        v.max(v.sub(self.exp(v, s), v.splat(self.floor)), v.splat(0.0))
    }

    #[inline(always)]
    fn slope<A: Lanes>(self, v: A, s: A::F) -> A::F {
        v.mul(self.exp(v, s), v.splat(-self.sharpness))
    }
}

impl Weight for Spline {
    #[inline(always)]
    fn weight<A: Lanes>(self, v: A, s: A::F) -> A::F {
        let q = v.sqrt(s);
        let rest = v.sub(v.splat(1.0), q);
        let near = v.fused(v.mul(v.splat(-6.0), s), rest, v.splat(1.0));
        let far = v.mul(v.mul(v.add(rest, rest), rest), rest);
        v.select(v.le(s, v.splat(0.25)), near, far)
    }

    #[inline(always)]
    fn slope<A: Lanes>(self, v: A, s: A::F) -> A::F {
        let q = v.sqrt(s);
        let rest = v.sub(v.splat(1.0), q);
        let near = v.fused(v.splat(9.0), q, v.splat(-6.0));
        let far = v.div(v.mul(v.mul(v.splat(-3.0), rest), rest), q);
        v.select(v.le(s, v.splat(0.25)), near, far)
    }
}

impl Weight for Cubic {
    #[inline(always)]
    fn weight<A: Lanes>(self, v: A, s: A::F) -> A::F {
        let rest = v.sub(v.splat(1.0), s);
        v.mul(v.mul(rest, rest), rest)
    }

    #[inline(always)]
    fn slope<A: Lanes>(self, v: A, s: A::F) -> A::F {
        let rest = v.sub(v.splat(1.0), s);
        v.mul(v.mul(v.splat(-3.0), rest), rest)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gaussians_are_those_of_the_library_at_every_level() {
        for (level, name) in Level::NAMES {
            for sharpness in [0.3f32, 1.0, 8.0, 20.0, 63.0] {
                for step in 0..1000 {
                    let s = step as f32 * 1e-3;
                    let [weight, slope] = both(level, Profile::Gaussian(sharpness), s);
                    let expected = (-sharpness * s).exp();
                    assert!((weight - expected + (-sharpness).exp()).abs() < 1e-5, "{name} {sharpness} {s}");
                    assert!((slope + sharpness * expected).abs() < 1e-5 * sharpness, "{name} {sharpness} {s}");
                }
            }
        }
    }

    #[test]
    fn the_spline_is_monaghans_and_slopes_are_those_of_the_weights() {
        // The cubic spline (Monaghan 1992), relative to no distance.
        let cubic = |q: f32| if q <= 0.5 { 6.0 * q * q * (q - 1.0) + 1.0 } else { 2.0 * (1.0 - q).powi(3) };
        for (level, _) in Level::NAMES {
            for s in [0.0, 0.01f32, 0.1, 0.24, 0.26, 0.5, 0.9, 0.99] {
                let spline = both(level, Profile::Spline, s)[0];
                assert!((spline - cubic(s.sqrt())).abs() < 1e-6);
                for profile in [Profile::Gaussian(8.0), Profile::Spline, Profile::Cubic] {
                    let slope = (profile.at(s + 1e-3) - profile.at((s - 1e-3).max(0.0))) / (1e-3 + s.min(1e-3));
                    let found = both(level, profile, s)[1];
                    assert!((found - slope).abs() < 0.3f32.min(0.01 + 0.01 / s), "{profile:?} {s}: {found} {slope}");
                }
            }
        }
        for profile in [Profile::Gaussian(8.0), Profile::Spline, Profile::Cubic] {
            assert!((profile.at(0.0) - 1.0).abs() < 1e-3 && profile.at(1.0 - 1e-7) < 1e-6 && profile.at(1.0) == 0.0);
        }
    }
}
