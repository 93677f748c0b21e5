//! What passes over pairs of neighbours share.

use glam::Vec4;
use relievo_core::lanes::Lanes;

use crate::solver::neighbours::Part;

/// Numbers of the particles of a part and of what is around them.
#[derive(Clone, Copy)]
pub struct Rows<'a> {
    /// A row a particle, and [`crate::solver::neighbours::NOWHERE`] after the last.
    pub fluid: &'a [Vec4],
    pub walls: &'a [Vec4],
}

/// Vectors of three dimensions, one in each lane.
#[derive(Clone, Copy)]
pub struct Vectors<A: Lanes>(pub [A::F; 3]);

impl<A: Lanes> Vectors<A> {
    #[inline(always)]
    pub fn zero(v: A) -> Self {
        Self([v.splat(0.0); 3])
    }

    #[inline(always)]
    pub fn splat(v: A, value: Vec4) -> Self {
        Self([v.splat(value.x), v.splat(value.y), v.splat(value.z)])
    }

    /// From columns, those from a place on.
    #[inline(always)]
    pub fn load(v: A, [x, y, z]: &[Vec<f32>; 3], first: usize) -> Self {
        Self([v.load(&x[first..]), v.load(&y[first..]), v.load(&z[first..])])
    }

    #[inline(always)]
    pub fn times(self, v: A, factor: A::F) -> Self {
        Self(std::array::from_fn(|k| v.mul(factor, self.0[k])))
    }

    #[inline(always)]
    pub fn minus(self, v: A, other: Self) -> Self {
        Self(std::array::from_fn(|k| v.sub(self.0[k], other.0[k])))
    }

    /// `self + factor · other`
    #[inline(always)]
    pub fn plus(self, v: A, factor: A::F, other: Self) -> Self {
        Self(std::array::from_fn(|k| v.fused(factor, other.0[k], self.0[k])))
    }

    #[inline(always)]
    pub fn dot(self, v: A, other: Self) -> A::F {
        let [a, b] = [self.0, other.0];
        v.fused(a[0], b[0], v.fused(a[1], b[1], v.mul(a[2], b[2])))
    }

    /// The sum of all lanes.
    #[inline(always)]
    pub fn sum(self, v: A) -> Vec4 {
        let [x, y, z] = self.0.map(|axis| v.sum(axis));
        Vec4::new(x, y, z, 0.0)
    }
}

/// Calls `work` for the neighbours of a particle, as many as there are lanes at a time: with the vectors from them, the
/// fourth numbers of their rows, and where they are in the part.
#[inline(always)]
pub fn around<A: Lanes>(
    v: A,
    part: &Part,
    particle: usize,
    rows: &[Vec4],
    own: Vec4,
    mut work: impl FnMut(Vectors<A>, A::F, usize),
) {
    let rows: &[[f32; 4]] = bytemuck::cast_slice(rows);
    let own = Vectors::splat(v, own);
    let range = part.range(particle);
    for at in range.step_by(A::WIDTH) {
        let [x, y, z, w] = v.gather_rows(rows, &part.indices[at..]);
        work(own.minus(v, Vectors([x, y, z])), w, at);
    }
}
