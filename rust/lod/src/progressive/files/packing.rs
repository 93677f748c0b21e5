//! Unit vectors and places in fewer bits.

use glam::Vec3;

/// A unit vector on an octahedron that is unfolded to a square, in two numbers of 16 bits; 0 for none.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Normal(pub u32);

impl Normal {
    /// Of a vector of any length, which may be 0.
    pub fn new(vector: Vec3) -> Self {
        let sum = vector.abs().element_sum();
        if !(sum > 0.0 && sum.is_finite()) {
            return Self(0);
        }
        let v = vector / sum;
        let sign = |value: f32| if value >= 0.0 { 1.0 } else { -1.0 };
        let [x, y] =
            if v.z >= 0.0 { [v.x, v.y] } else { [(1.0 - v.y.abs()) * sign(v.x), (1.0 - v.x.abs()) * sign(v.y)] };
        // From 1 on, so that 0 is free.
        let number = |value: f32| ((value * 32767.0).round() as i32 + 32768) as u32;
        Self(number(x) | number(y) << 16)
    }

    /// The vector, of length 1 or 0.
    pub fn vector(self) -> Vec3 {
        if self.0 == 0 {
            return Vec3::ZERO;
        }
        let number = |bits: u32| (bits as i32 - 32768) as f32 / 32767.0;
        let (x, y) = (number(self.0 & 0xffff), number(self.0 >> 16));
        let fold = (x.abs() + y.abs() - 1.0).max(0.0);
        Vec3::new(x - fold.copysign(x), y - fold.copysign(y), 1.0 - x.abs() - y.abs()).normalize()
    }
}

/// A lattice of 2²¹ places along each axis of a box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lattice {
    origin: Vec3,
    step: Vec3,
}

const BITS: u32 = 21;
const LAST: u64 = (1 << BITS) - 1;

impl Lattice {
    /// Over the box of points.
    pub fn around(mut points: impl Iterator<Item = Vec3>) -> Self {
        let first = points.next().unwrap_or_default();
        let (low, high) = points.fold((first, first), |(low, high), point| (low.min(point), high.max(point)));
        Self { origin: low, step: (high - low) / LAST as f32 }
    }

    /// Of an origin and the distances of places, if they are finite.
    pub fn from_parts(origin: Vec3, step: Vec3) -> Option<Self> {
        (origin.is_finite() && step.is_finite()).then_some(Self { origin, step })
    }

    /// The origin, and the distances of places.
    pub fn parts(&self) -> (Vec3, Vec3) {
        (self.origin, self.step)
    }

    /// A power of two that makes its extent about 1.
    pub fn scale(&self) -> f32 {
        let extent = (self.step * LAST as f32).max_element();
        if extent > 0.0 && extent.is_finite() { (-extent.log2().ceil()).clamp(-120.0, 120.0).exp2() } else { 1.0 }
    }

    /// The nearest place of the lattice.
    pub fn pack(&self, point: Vec3) -> u64 {
        let steps = (point - self.origin) / self.step;
        let number = |steps: f32| (steps.round() as u64).min(LAST);
        number(steps.x) | number(steps.y) << BITS | number(steps.z) << (2 * BITS)
    }

    /// Where a place of the lattice is.
    pub fn point(&self, packed: u64) -> Vec3 {
        let steps = |axis: u32| (packed >> (axis * BITS) & LAST) as f32;
        self.origin + self.step * Vec3::new(steps(0), steps(1), steps(2))
    }
}
