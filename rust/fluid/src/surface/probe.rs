//! Values, gradients and weights of a surface function at any place, from the particles near it.

use std::ops::Range;

use glam::Vec3;
use relievo_core::dispatch_simd;
use relievo_core::lanes::Lanes;
use relievo_core::simd::Level;

use crate::surface::Surface;
use crate::surface::function::Combination;
use crate::surface::profile::{LANES, WIDEST, Weight, with_weight};
use crate::surface::rows::Cell;

/// A place in the field.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sample {
    /// The value, positive inside.
    pub value: f32,
    /// Its gradient, which points inwards.
    pub gradient: [f32; 3],
}

/// Sums over the particles near a place, with d the vector from it to a particle and w the particle's weight.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Sums {
    /// Σ w
    pub weight: f32,
    /// Σ w d
    moment: Vec3,
    /// Σ ∇w
    slope: Vec3,
    /// Σ d ∇wᵀ, of spheres, in the order of [`Surface::shapes`].
    spread: [f32; 6],
}

impl Sums {
    /// Adds a particle of a weight, with the derivative of that by s; `image` is M d.
    pub fn add(&mut self, d: Vec3, image: Vec3, weight: f32, slope: f32) {
        let slope = -2.0 * slope * image;
        self.weight += weight;
        self.moment += weight * d;
        self.slope += slope;
        let products = [d.x * slope.x, d.x * slope.y, d.x * slope.z, d.y * slope.y, d.y * slope.z, d.z * slope.z];
        self.spread.iter_mut().zip(products).for_each(|(sum, product)| *sum += product);
    }

    /// The gradient of the function.
    pub fn gradient(&self, combination: Combination) -> Vec3 {
        match combination {
            Combination::Sum { .. } => self.slope,
            Combination::Mean { .. } if self.weight > 0.0 => {
                let mean = self.moment / self.weight;
                let distance = mean.length();
                let [xx, xy, xz, yy, yz, zz] = self.spread;
                let spread = Vec3::new(
                    mean.dot(Vec3::new(xx, xy, xz)),
                    mean.dot(Vec3::new(xy, yy, yz)),
                    mean.dot(Vec3::new(xz, yz, zz)),
                );
                let turn = (spread - distance * distance * self.slope) / self.weight;
                if distance > 0.0 { (mean - turn) / distance } else { Vec3::ZERO }
            }
            Combination::Mean { .. } => Vec3::ZERO,
        }
    }
}

/// Looks at one place after the other; near ones are found faster.
#[derive(Clone, Debug)]
pub struct Probe<'a> {
    pub(crate) surface: &'a Surface,
    pub(crate) level: Level,
    /// The cell that `ranges` are around.
    cell: Option<Cell>,
    ranges: Vec<Range<usize>>,
    weights: Vec<f32>,
}

impl<'a> Probe<'a> {
    pub(crate) fn new(surface: &'a Surface, level: Level) -> Self {
        Self { surface, level, cell: None, ranges: Vec::new(), weights: Vec::new() }
    }

    /// Value and gradient at a place, in metres. Where no particle is near the gradient is 0.
    pub fn sample(&mut self, at: [f32; 3]) -> Sample {
        let sums = self.sums(at);
        let value = self.surface.combination.value(sums.weight, sums.moment.to_array());
        let gradient = sums.gradient(self.surface.combination);
        Sample { value, gradient: gradient.to_array() }
    }

    /// Calls `each` with the index of every particle that counts at a place and its weight, which is positive, in the
    /// order of the surface.
    pub fn weights(&mut self, at: [f32; 3], mut each: impl FnMut(u32, f32)) {
        self.sums(at);
        self.near(&mut each);
    }

    /// As [`Self::weights`], of the place that was last looked at.
    pub(crate) fn near(&self, mut each: impl FnMut(u32, f32)) {
        let mut base = 0;
        for range in &self.ranges {
            for (order, weight) in self.surface.order[range.clone()].iter().zip(&self.weights[base..]) {
                if *weight > 0.0 {
                    each(*order, *weight);
                }
            }
            base += range.len().next_multiple_of(WIDEST);
        }
    }

    pub(crate) fn sums(&mut self, at: [f32; 3]) -> Sums {
        self.seek(at);
        let mut sums = Sums::default();
        sum(self.level, self.surface, at, &self.ranges, &mut self.weights, &mut sums);
        sums
    }

    /// The sum of weights at a place, of spheres of amplitude 1.
    pub(crate) fn total(&mut self, at: [f32; 3]) -> f32 {
        self.seek(at);
        total(self.level, self.surface, at, &self.ranges)
    }

    /// Finds the particles around the cell of a place, which are all that reach it, and their ranges.
    pub(crate) fn seek(&mut self, at: [f32; 3]) -> &[Range<usize>] {
        let cell = self.surface.rows.cell(at);
        if self.cell != Some(cell) {
            self.surface.rows.ranges(
                cell.map(|at| at.saturating_sub(1)),
                cell.map(|at| at.saturating_add(1)),
                &mut self.ranges,
            );
            self.cell = Some(cell);
        }
        &self.ranges
    }
}

dispatch_simd! {
    fn sum = sum_body(
        surface: &Surface, at: [f32; 3], ranges: &[Range<usize>], weights: &mut Vec<f32>, sums: &mut Sums,
    )
}

#[inline(always)]
fn sum_body<A: Lanes>(
    v: A,
    surface: &Surface,
    at: [f32; 3],
    ranges: &[Range<usize>],
    weights: &mut Vec<f32>,
    sums: &mut Sums,
) {
    with_weight!(surface.profile, weight => match surface.combination {
        Combination::Mean { .. } => sum_of::<A, _, true, false>(v, surface, weight, at, ranges, weights, sums),
        Combination::Sum { .. } if surface.shapes.is_none() => {
            sum_of::<A, _, false, false>(v, surface, weight, at, ranges, weights, sums);
        }
        Combination::Sum { .. } => sum_of::<A, _, false, true>(v, surface, weight, at, ranges, weights, sums),
    });
}

dispatch_simd! {
    fn total = total_body(surface: &Surface, at: [f32; 3], ranges: &[Range<usize>]) -> f32
}

#[inline(always)]
fn total_body<A: Lanes>(v: A, surface: &Surface, at: [f32; 3], ranges: &[Range<usize>]) -> f32 {
    with_weight!(surface.profile, weight => total_of::<A, _>(v, surface, weight, at, ranges))
}

/// The sum of the weights of the particles of ranges, of spheres of amplitude 1.
#[inline(always)]
fn total_of<A: Lanes, W: Weight>(v: A, surface: &Surface, weight: W, at: [f32; 3], ranges: &[Range<usize>]) -> f32 {
    let lanes = v.load(&LANES);
    let (zero, one, sphere) = (v.splat(0.0), v.splat(1.0), v.splat(surface.sphere));
    let at = [v.splat(at[0]), v.splat(at[1]), v.splat(at[2])];
    let mut total = zero;
    for range in ranges {
        for first in range.clone().step_by(A::WIDTH) {
            let step = |axis: usize| v.sub(v.load(&surface.centres[axis][first..]), at[axis]);
            let (x, y, z) = (step(0), step(1), step(2));
            let s = v.mul(v.fused(x, x, v.fused(y, y, v.mul(z, z))), sphere);
            let left = v.splat((range.end - first).min(WIDEST) as f32);
            let counts = v.both(v.lt(s, one), v.lt(lanes, left));
            total = v.add(total, v.select(counts, weight.weight(v, v.min(s, one)), zero));
        }
    }
    let mut lanes = [0.0; WIDEST];
    v.store(total, &mut lanes);
    lanes[..A::WIDTH].iter().sum::<f32>()
}

/// Sums of the particles of ranges, with the sums that a mean needs, for kernels that are spheres or have shapes.
/// Leaves the weights; those of a range begin at a multiple of [`WIDEST`].
#[inline(always)]
fn sum_of<A: Lanes, W: Weight, const MEAN: bool, const SHAPES: bool>(
    v: A,
    surface: &Surface,
    weight: W,
    at: [f32; 3],
    ranges: &[Range<usize>],
    weights: &mut Vec<f32>,
    sums: &mut Sums,
) {
    let lanes = v.load(&LANES);
    let (zero, one, sphere) = (v.splat(0.0), v.splat(1.0), v.splat(surface.sphere));
    let at = [v.splat(at[0]), v.splat(at[1]), v.splat(at[2])];
    let mut total = [zero; 13];
    weights.resize(ranges.iter().map(|range| range.len().next_multiple_of(WIDEST)).sum(), 0.0);
    let mut base = 0;
    for range in ranges {
        for first in range.clone().step_by(A::WIDTH) {
            let step = |axis: usize| v.sub(v.load(&surface.centres[axis][first..]), at[axis]);
            let product = |a: [A::F; 3], b: [A::F; 3]| v.fused(a[0], b[0], v.fused(a[1], b[1], v.mul(a[2], b[2])));
            let d = [step(0), step(1), step(2)];
            let (s, m) = if let (true, Some(shapes)) = (SHAPES, &surface.shapes) {
                let shape = |entry: usize| v.load(&shapes[entry][first..]);
                let (xx, xy, xz, yy, yz, zz) = (shape(0), shape(1), shape(2), shape(3), shape(4), shape(5));
                let m = [product([xx, xy, xz], d), product([xy, yy, yz], d), product([xz, yz, zz], d)];
                (product(m, d), m)
            } else {
                (v.mul(product(d, d), sphere), [v.mul(d[0], sphere), v.mul(d[1], sphere), v.mul(d[2], sphere)])
            };
            // What does not count may be no number.
            let left = v.splat((range.end - first).min(WIDEST) as f32);
            let counts = v.both(v.lt(s, one), v.lt(lanes, left));
            let s = v.select(counts, s, one);
            let amplitude = v.select(counts, v.load(&surface.amplitudes[first..]), zero);
            let w = v.mul(amplitude, weight.weight(v, s));
            let slope = v.mul(v.mul(amplitude, v.splat(-2.0)), weight.slope(v, s));
            let counted = |a: [A::F; 3]| {
                [v.select(counts, a[0], zero), v.select(counts, a[1], zero), v.select(counts, a[2], zero)]
            };
            let m = counted(m);
            v.store(w, &mut weights[base + first - range.start..]);
            total[0] = v.add(total[0], w);
            for axis in 0..3 {
                total[1 + axis] = v.fused(slope, m[axis], total[1 + axis]);
            }
            if MEAN {
                let d = counted(d);
                for axis in 0..3 {
                    total[4 + axis] = v.fused(w, d[axis], total[4 + axis]);
                }
                for (entry, (row, column)) in [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)].into_iter().enumerate() {
                    total[7 + entry] = v.fused(v.mul(slope, d[row]), m[column], total[7 + entry]);
                }
            }
        }
        base += range.len().next_multiple_of(WIDEST);
    }
    let mut sum = [0.0; 13];
    for (sum, value) in sum.iter_mut().zip(total) {
        let mut lanes = [0.0; WIDEST];
        v.store(value, &mut lanes);
        *sum = lanes[..A::WIDTH].iter().sum::<f32>();
    }
    sums.weight = sum[0];
    sums.slope = Vec3::new(sum[1], sum[2], sum[3]);
    sums.moment = Vec3::new(sum[4], sum[5], sum[6]);
    sums.spread.copy_from_slice(&sum[7..]);
}
