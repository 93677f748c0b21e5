//! The frames of vector displacement at the knots of a block: to object space and back.
//!
//! A vector has the components along T, along N × T and along N, where T is the unit tangent by u and N the unit normal
//! of the surface, see [`relievo_tiles::frame`]. Units: object units.

use relievo_core::dispatch_simd;
use relievo_core::simd::{Arithmetic, Level};

use crate::channels::knots::{BLOCK_KNOTS, PerKnot};

/// Three components for each knot of a block.
pub(crate) type Vectors = [PerKnot; 3];

/// Vectors of zero.
pub(crate) const STILL: Vectors = [[0.0; BLOCK_KNOTS]; 3];

/// The frames at the knots of a block, given their normals.
#[derive(Clone, Debug)]
pub(crate) struct Frames {
    /// Unit tangents by u; zero where there is no frame.
    pub t: Vectors,
}

impl Frames {
    /// No frames.
    pub const ZERO: Self = Self { t: STILL };

    /// From components in the frames to object space. `n` are the normals.
    pub fn to_object(&self, level: Level, n: &Vectors, vectors: &mut Vectors) {
        outwards(level, &self.t, n, vectors);
    }

    /// From object space to components in the frames. `n` are the normals.
    pub fn from_object(&self, level: Level, n: &Vectors, vectors: &mut Vectors) {
        inwards(level, &self.t, n, vectors);
    }
}

dispatch_simd! {
    fn outwards = outwards_body(t: &Vectors, n: &Vectors, vectors: &mut Vectors)
}

dispatch_simd! {
    fn inwards = inwards_body(t: &Vectors, n: &Vectors, vectors: &mut Vectors)
}

/// N × T at knot `k`.
#[inline(always)]
fn across(t: &Vectors, n: &Vectors, k: usize) -> [f32; 3] {
    [
        n[1][k] * t[2][k] - n[2][k] * t[1][k],
        n[2][k] * t[0][k] - n[0][k] * t[2][k],
        n[0][k] * t[1][k] - n[1][k] * t[0][k],
    ]
}

#[inline(always)]
fn outwards_body<A: Arithmetic>(_: A, t: &Vectors, n: &Vectors, vectors: &mut Vectors) {
    for k in 0..BLOCK_KNOTS {
        let (v, b) = ([vectors[0][k], vectors[1][k], vectors[2][k]], across(t, n, k));
        for axis in 0..3 {
            vectors[axis][k] = A::fma(v[0], t[axis][k], A::fma(v[1], b[axis], v[2] * n[axis][k]));
        }
    }
}

#[inline(always)]
fn inwards_body<A: Arithmetic>(_: A, t: &Vectors, n: &Vectors, vectors: &mut Vectors) {
    for k in 0..BLOCK_KNOTS {
        let (v, b) = ([vectors[0][k], vectors[1][k], vectors[2][k]], across(t, n, k));
        vectors[0][k] = A::fma(v[0], t[0][k], A::fma(v[1], t[1][k], v[2] * t[2][k]));
        vectors[1][k] = A::fma(v[0], b[0], A::fma(v[1], b[1], v[2] * b[2]));
        vectors[2][k] = A::fma(v[0], n[0][k], A::fma(v[1], n[1][k], v[2] * n[2][k]));
    }
}
