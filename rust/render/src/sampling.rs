//! Sample places: low-discrepancy sequences that depend on the pixel and nothing else, so that a picture is the same
//! for any number of threads and from run to run.
//!
//! Units are fractions of 2³², whose wrapping addition is the addition modulo 1 that these sequences need.

use glam::{Vec2, Vec3};

/// 2³² divided by the plastic number and by its square: the steps of the R₂ sequence (Roberts 2018, "The Unreasonable
/// Effectiveness of Quasirandom Sequences").
const PLASTIC: [u32; 2] = [3_242_174_889, 2_447_445_414];
/// 2³² divided by the golden ratio.
const GOLDEN: u32 = 2_654_435_769;

/// Place of sample `index` in its pixel, in 0..1; the first is the middle.
pub fn in_pixel(index: u32) -> Vec2 {
    const HALF: u32 = 1 << 31;
    Vec2::from(PLASTIC.map(|step| fraction(HALF.wrapping_add(index.wrapping_mul(step)))))
}

/// The shifts of a pixel's samples.
#[derive(Clone, Copy, Debug)]
pub struct Shift(u32, u32);

impl Shift {
    /// The shift of pixel (x, y) for the light `stream`. Neighbouring pixels lie far apart in the first dimension,
    /// which leaves no clumps of noise.
    pub fn new(x: u32, y: u32, stream: u32) -> Self {
        let first = x.wrapping_mul(PLASTIC[0]).wrapping_add(y.wrapping_mul(PLASTIC[1]));
        Self(first.wrapping_add(hash(stream)), hash(hash(x ^ hash(stream)) ^ y))
    }

    /// Sample `index` of `count` in the unit square: a golden lattice, shifted.
    pub fn sample(self, index: u32, count: u32) -> Vec2 {
        let step = (u64::from(index) << 32) / u64::from(count.max(1));
        Vec2::new(fraction(self.0.wrapping_add(step as u32)), fraction(self.1.wrapping_add(index.wrapping_mul(GOLDEN))))
    }
}

fn fraction(value: u32) -> f32 {
    // 24 bits, so that the result is below 1.
    (value >> 8) as f32 / (1 << 24) as f32
}

/// A permutation of the 32-bit integers without visible pattern.
fn hash(value: u32) -> u32 {
    let state = value.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
    let word = ((state >> ((state >> 28) + 4)) ^ state).wrapping_mul(277_803_737);
    (word >> 22) ^ word
}

/// A direction about `normal` with density cos θ / π.
pub fn cosine_hemisphere(normal: Vec3, place: Vec2) -> Vec3 {
    let (sin, cos) = (std::f32::consts::TAU * place.y).sin_cos();
    let radius = place.x.sqrt();
    let (a, b) = normal.any_orthonormal_pair();
    a * (radius * cos) + b * (radius * sin) + normal * (1.0 - place.x).max(0.0).sqrt()
}

/// A direction within the angle whose cosine is `cos_max` of `axis`, uniform in solid angle.
pub fn cone(axis: Vec3, cos_max: f32, place: Vec2) -> Vec3 {
    let (sin, cos) = (std::f32::consts::TAU * place.y).sin_cos();
    let z = 1.0 - place.x * (1.0 - cos_max);
    let radius = (1.0 - z * z).max(0.0).sqrt();
    let (a, b) = axis.any_orthonormal_pair();
    a * (radius * cos) + b * (radius * sin) + axis * z
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_sample_is_the_middle_and_all_are_inside() {
        assert_eq!(in_pixel(0), Vec2::splat(0.5));
        for index in 0..4096 {
            for place in [in_pixel(index), Shift::new(17, 5, 1).sample(index, 4096)] {
                assert!(place.min_element() >= 0.0 && place.max_element() < 1.0);
            }
        }
    }

    #[test]
    fn directions_have_the_moments_of_their_densities() {
        let normal = Vec3::new(1.0, 2.0, -2.0) / 3.0;
        let (count, shift) = (4096, Shift::new(3, 4, 0));
        let mean = |f: &dyn Fn(Vec2) -> f32| {
            (0..count).map(|index| f64::from(f(shift.sample(index, count)))).sum::<f64>() / f64::from(count)
        };
        // The mean of cos θ over the density cos θ / π is 2/3, over a cone to cos θ = c it is (1 + c)/2.
        assert!((mean(&|place| cosine_hemisphere(normal, place).dot(normal)) - 2.0 / 3.0).abs() < 2e-3);
        assert!((mean(&|place| cone(normal, 0.5, place).dot(normal)) - 0.75).abs() < 2e-3);
        assert!((mean(&|place| cosine_hemisphere(normal, place).length()) - 1.0).abs() < 1e-5);
    }
}
