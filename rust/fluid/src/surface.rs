//! The surface function of a set of particles: values, gradients and weights at any place, from the particles near it.

use std::ops::Range;

use glam::Vec3;
use relievo_core::simd::{Arithmetic, Level};
use relievo_core::{Context, Result, dispatch_simd};

use crate::anisotropy;
use crate::function::{Combination, SurfaceFunction};
use crate::profile::{Profile, Weight, with_weight};
use crate::rows::{Cell, Rows};

/// Particles that are looked at together.
const LANES: usize = 8;
/// Cells are wider than what particles reach by this factor, so that rounding hides none.
const MARGIN: f32 = 1.0001;

/// A function of particles, prepared: particles in the order of cells, with the amplitude and the shape of the kernel of
/// each. Some 30 bytes a particle, 54 with anisotropic kernels.
#[derive(Clone, Debug)]
pub struct Surface {
    pub(crate) function: SurfaceFunction,
    pub(crate) profile: Profile,
    pub(crate) combination: Combination,
    /// The distance from which on no particle counts.
    pub(crate) reach: f32,
    pub(crate) rows: Rows,
    /// The place of every particle in the list it came from.
    pub(crate) order: Vec<u32>,
    /// Coordinates of the centres, and at the end some of no particle, for lanes.
    pub(crate) centres: [Vec<f32>; 3],
    pub(crate) amplitudes: Vec<f32>,
    /// What the squared distance is measured by, of spheres.
    pub(crate) sphere: f32,
    /// Symmetric matrices M = [xx, xy, xz, yy, yz, zz] of anisotropic kernels: s = dᵀ M d. Empty for spheres.
    pub(crate) shapes: Vec<[f32; 6]>,
}

/// A place in the field.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sample {
    /// The value, positive inside.
    pub value: f32,
    /// Its gradient, which points inwards.
    pub gradient: [f32; 3],
}

impl Surface {
    /// Of particles at these positions, in metres. Fails if a parameter is out of range, if a position is not finite, or if
    /// there are 2³² particles or such as are more than a million support radii apart.
    pub fn new(context: &Context, positions: &[[f32; 3]], function: SurfaceFunction) -> Result<Self> {
        function.check()?;
        let mut surface = Self::spheres(context, positions, function)?;
        match function {
            SurfaceFunction::Blobs { .. } | SurfaceFunction::ZhuBridson { .. } => Ok(surface),
            SurfaceFunction::Density { .. } => {
                surface.amplitudes = surface.volumes(context);
                Ok(surface)
            }
            SurfaceFunction::Anisotropic { support, centring, .. } => {
                let amplitudes = surface.volumes(context);
                let kernels: Vec<_> = context
                    .map(surface.rows.len(), |cell| {
                        let mut probe = surface.probe(context);
                        let kernel = |at| anisotropy::kernel(&surface, at, centring, probe.seek(surface.centre(at)));
                        surface.rows.particles(cell).map(kernel).collect::<Vec<_>>()
                    })
                    .concat();
                let centres: Vec<[f32; 3]> = kernels.iter().map(|kernel| kernel.centre).collect();
                let widest = kernels.iter().fold(1.0f32, |widest, kernel| widest.max(kernel.widest()));
                let (rows, order) = Rows::new(context, &centres, widest * support * MARGIN)?;
                let shape = |at: &u32| kernels[*at as usize].matrix(support);
                let amplitude = |at: &u32| amplitudes[*at as usize] * kernels[*at as usize].amplitude();
                surface.shapes = order.iter().map(shape).chain([[0.0; 6]; LANES]).collect();
                surface.amplitudes = order.iter().map(amplitude).chain([0.0; LANES]).collect();
                surface.centres = columns(&centres, &order);
                surface.order = order.iter().map(|at| surface.order[*at as usize]).collect();
                surface.reach = widest * support;
                surface.rows = rows;
                Ok(surface)
            }
        }
    }

    /// Spheres of amplitude 1.
    fn spheres(context: &Context, positions: &[[f32; 3]], function: SurfaceFunction) -> Result<Self> {
        let support = function.support();
        let (rows, order) = Rows::new(context, positions, support * MARGIN)?;
        Ok(Self {
            function,
            profile: function.profile(),
            combination: function.combination(),
            reach: support,
            rows,
            centres: columns(positions, &order),
            amplitudes: vec![1.0; positions.len() + LANES],
            order,
            sphere: 1.0 / (support * support),
            shapes: Vec::new(),
        })
    }

    /// 1 / Σ w at every particle, of weights that are 1 in the middle: its volume times the middle of its kernel.
    fn volumes(&self, context: &Context) -> Vec<f32> {
        let mut volumes = vec![0.0; self.amplitudes.len()];
        let mut parts = Vec::with_capacity(self.rows.len());
        let mut rest = volumes.as_mut_slice();
        for cell in 0..self.rows.len() {
            let (part, after) = rest.split_at_mut(self.rows.particles(cell).len());
            parts.push(part);
            rest = after;
        }
        context.for_each_mut(&mut parts, |cell, volumes| {
            let mut probe = self.probe(context);
            for (at, volume) in self.rows.particles(cell).zip(volumes.iter_mut()) {
                *volume = 1.0 / probe.sums(self.centre(at)).weight;
            }
        });
        volumes
    }

    /// How many particles there are.
    pub fn len(&self) -> usize {
        self.order.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.order.is_empty()
    }

    /// The function.
    pub fn function(&self) -> SurfaceFunction {
        self.function
    }

    /// The distance from the centre of a kernel from which on it is 0, of all kernels the largest: the support radius, more
    /// with anisotropic kernels.
    pub fn reach(&self) -> f32 {
        self.reach
    }

    /// For looking at many places, one after the other.
    pub fn probe(&self, context: &Context) -> Probe<'_> {
        Probe { surface: self, level: context.level(), cell: None, ranges: Vec::new(), weights: Vec::new() }
    }

    /// The centre of the kernel at this place of the order.
    pub(crate) fn centre(&self, at: usize) -> [f32; 3] {
        [self.centres[0][at], self.centres[1][at], self.centres[2][at]]
    }
}

/// Coordinates in an order, and at the end some that are far from everything.
fn columns(points: &[[f32; 3]], order: &[u32]) -> [Vec<f32>; 3] {
    let far = [f32::MAX; LANES];
    std::array::from_fn(|axis| order.iter().map(|at| points[*at as usize][axis]).chain(far).collect())
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

/// Looks at one place after the other; near ones are found faster.
#[derive(Clone, Debug)]
pub struct Probe<'a> {
    surface: &'a Surface,
    level: Level,
    /// The cell that `ranges` are around.
    cell: Option<Cell>,
    ranges: Vec<Range<usize>>,
    weights: Vec<f32>,
}

impl Probe<'_> {
    /// Value and gradient at a place, in metres. Where no particle is near the gradient is 0.
    pub fn sample(&mut self, at: [f32; 3]) -> Sample {
        let sums = self.sums(at);
        let value = self.surface.combination.value(sums.weight, sums.moment.to_array());
        let gradient = match self.surface.combination {
            Combination::Sum { .. } => sums.slope,
            Combination::Mean { .. } if sums.weight > 0.0 => {
                let mean = sums.moment / sums.weight;
                let distance = mean.length();
                let [xx, xy, xz, yy, yz, zz] = sums.spread;
                let spread = Vec3::new(
                    mean.dot(Vec3::new(xx, xy, xz)),
                    mean.dot(Vec3::new(xy, yy, yz)),
                    mean.dot(Vec3::new(xz, yz, zz)),
                );
                let turn = (spread - distance * distance * sums.slope) / sums.weight;
                if distance > 0.0 { (mean - turn) / distance } else { Vec3::ZERO }
            }
            Combination::Mean { .. } => Vec3::ZERO,
        };
        Sample { value, gradient: gradient.to_array() }
    }

    /// Calls `each` with the index of every particle that counts at a place and its weight, which is positive, in the
    /// order of the surface.
    pub fn weights(&mut self, at: [f32; 3], mut each: impl FnMut(u32, f32)) {
        self.sums(at);
        let mut weights = self.weights.chunks(LANES);
        for range in &self.ranges {
            for first in range.clone().step_by(LANES) {
                let weights = weights.next().unwrap_or_default();
                for (order, weight) in self.surface.order[first..range.end].iter().zip(weights) {
                    if *weight > 0.0 {
                        each(*order, *weight);
                    }
                }
            }
        }
    }

    pub(crate) fn sums(&mut self, at: [f32; 3]) -> Sums {
        self.seek(at);
        let mut sums = Sums::default();
        sum(self.level, self.surface, at, &self.ranges, &mut self.weights, &mut sums);
        sums
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
fn sum_body<A: Arithmetic>(
    surface: &Surface,
    at: [f32; 3],
    ranges: &[Range<usize>],
    weights: &mut Vec<f32>,
    sums: &mut Sums,
) {
    with_weight!(surface.profile, weight => match surface.combination {
        Combination::Mean { .. } => sum_of::<A, _, true, false>(surface, weight, at, ranges, weights, sums),
        Combination::Sum { .. } if surface.shapes.is_empty() => {
            sum_of::<A, _, false, false>(surface, weight, at, ranges, weights, sums);
        }
        Combination::Sum { .. } => sum_of::<A, _, false, true>(surface, weight, at, ranges, weights, sums),
    });
}

/// Sums of the particles of ranges, with those that a mean needs, for kernels that are spheres or have shapes. Leaves the
/// weights, [`LANES`] for every so many particles of a range.
#[inline(always)]
fn sum_of<A: Arithmetic, W: Weight, const MEAN: bool, const SHAPES: bool>(
    surface: &Surface,
    weight: W,
    [x, y, z]: [f32; 3],
    ranges: &[Range<usize>],
    weights: &mut Vec<f32>,
    sums: &mut Sums,
) {
    weights.clear();
    let mut total = [[0.0f32; LANES]; 13];
    for range in ranges {
        for first in range.clone().step_by(LANES) {
            let lanes = first..first + LANES;
            let [xs, ys, zs] = [0, 1, 2].map(|axis| &surface.centres[axis][lanes.clone()]);
            let amplitudes = &surface.amplitudes[lanes.clone()];
            let left = (range.end - first).min(LANES) as u32;
            let mut found = [0.0f32; LANES];
            for lane in 0..LANES {
                let (dx, dy, dz) = (xs[lane] - x, ys[lane] - y, zs[lane] - z);
                let (s, mx, my, mz);
                if SHAPES {
                    let [xx, xy, xz, yy, yz, zz] = surface.shapes[first + lane];
                    mx = A::fma(xx, dx, A::fma(xy, dy, xz * dz));
                    my = A::fma(xy, dx, A::fma(yy, dy, yz * dz));
                    mz = A::fma(xz, dx, A::fma(yz, dy, zz * dz));
                    s = A::fma(mx, dx, A::fma(my, dy, mz * dz));
                } else {
                    s = A::fma(dx, dx, A::fma(dy, dy, dz * dz)) * surface.sphere;
                    (mx, my, mz) = (dx * surface.sphere, dy * surface.sphere, dz * surface.sphere);
                }
                let counts = (s < 1.0) & ((lane as u32) < left);
                // What does not count may be no number.
                let s = if counts { s } else { 1.0 };
                let amplitude = if counts { amplitudes[lane] } else { 0.0 };
                let w = amplitude * weight.weight::<A>(s);
                let slope = -2.0 * amplitude * weight.slope::<A>(s);
                let [mx, my, mz] = [mx, my, mz].map(|m| if counts { m } else { 0.0 });
                found[lane] = w;
                total[0][lane] += w;
                total[1][lane] = A::fma(slope, mx, total[1][lane]);
                total[2][lane] = A::fma(slope, my, total[2][lane]);
                total[3][lane] = A::fma(slope, mz, total[3][lane]);
                if MEAN {
                    let [dx, dy, dz] = [dx, dy, dz].map(|d| if counts { d } else { 0.0 });
                    let products = [dx * mx, dx * my, dx * mz, dy * my, dy * mz, dz * mz];
                    total[4][lane] = A::fma(w, dx, total[4][lane]);
                    total[5][lane] = A::fma(w, dy, total[5][lane]);
                    total[6][lane] = A::fma(w, dz, total[6][lane]);
                    for (product, total) in products.iter().zip(&mut total[7..]) {
                        total[lane] = A::fma(slope, *product, total[lane]);
                    }
                }
            }
            weights.extend_from_slice(&found);
        }
    }
    let total = total.map(|lanes| lanes.iter().sum::<f32>());
    sums.weight = total[0];
    sums.slope = Vec3::new(total[1], total[2], total[3]);
    sums.moment = Vec3::new(total[4], total[5], total[6]);
    sums.spread.copy_from_slice(&total[7..]);
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const FUNCTIONS: [fn(f32) -> SurfaceFunction; 4] =
        [SurfaceFunction::blobs, SurfaceFunction::zhu_bridson, SurfaceFunction::density, SurfaceFunction::anisotropic];

    fn value(surface: &Surface, at: [f32; 3]) -> f32 {
        surface.probe(&Context::serial()).sample(at).value
    }

    #[test]
    fn a_particle_alone_is_a_sphere() {
        let (context, centre) = (Context::serial(), [3.0, -1.0, 0.5]);
        let at = |r: f32| [3.0 + 0.6 * r, -1.0 - 0.8 * r, 0.5];
        for function in [SurfaceFunction::blobs(0.1), SurfaceFunction::zhu_bridson(0.1)] {
            let surface = Surface::new(&context, &[centre], function).unwrap();
            assert!(value(&surface, at(0.0999)) > 0.0 && value(&surface, at(0.1001)) < 0.0, "{function:?}");
        }
        let surface = Surface::new(&context, &[centre], SurfaceFunction::zhu_bridson(0.1)).unwrap();
        for r in [0.05, 0.2, 0.39, 0.41, 1.0] {
            assert!((value(&surface, at(r)) - (0.1 - r.min(0.4))).abs() < 1e-6);
        }
        let surface = Surface::new(&context, &[centre], SurfaceFunction::density(0.1)).unwrap();
        assert!((value(&surface, centre) - 0.4).abs() < 1e-6 && value(&surface, at(0.4)) == -0.6);
    }

    #[test]
    fn blobs_are_a_sum_of_gaussians() {
        let function = SurfaceFunction::Blobs { support: 1.0, radius: 0.3, sharpness: 8.0 };
        let surface = Surface::new(&Context::serial(), &[[0.0; 3], [0.5, 0.0, 0.0]], function).unwrap();
        let expected = 2.0 * (-8.0f32 * 0.0625).exp() - (-8.0f32 * 0.09).exp() - (-8.0f32).exp();
        assert!((value(&surface, [0.25, 0.0, 0.0]) - expected).abs() < 1e-6);
    }

    #[test]
    fn within_a_lattice_kernels_are_spheres_and_the_density_is_that_at_rest() {
        let cells = |count: i32| (0..count).map(|at| at as f32 * 0.2);
        let points: Vec<[f32; 3]> =
            cells(11).flat_map(|z| cells(11).flat_map(move |y| cells(11).map(move |x| [x, y, z]))).collect();
        for function in [SurfaceFunction::density(0.1), SurfaceFunction::anisotropic(0.1)] {
            let surface = Surface::new(&Context::serial(), &points, function).unwrap();
            for at in [[1.0; 3], [1.1; 3], [1.0, 1.1, 1.05]] {
                assert!((value(&surface, at) - 0.4).abs() < 0.06, "{function:?} {}", value(&surface, at));
            }
        }
        let surface = Surface::new(&Context::serial(), &points, SurfaceFunction::anisotropic(0.1)).unwrap();
        let middle = (0..points.len()).find(|at| points[surface.order[*at] as usize] == [1.0; 3]).unwrap();
        let [xx, xy, _, yy, _, zz] = surface.shapes[middle];
        assert!((xx - yy).abs() < 1e-3 * xx && (xx - zz).abs() < 1e-3 * xx && xy.abs() < 1e-3 * xx);
        assert!((xx / surface.sphere - 1.0).abs() < 0.2, "{}", xx / surface.sphere);
    }

    #[test]
    fn particles_at_one_point_are_one() {
        for function in FUNCTIONS {
            let surface = Surface::new(&Context::serial(), &[[1.0; 3]; 1000], function(0.1)).unwrap();
            let sample = surface.probe(&Context::serial()).sample([1.01, 1.0, 1.0]);
            assert!(sample.value > 0.0 && sample.gradient.iter().all(|slope| slope.is_finite()));
            assert!(value(&surface, [2.0; 3]) < 0.0);
        }
    }

    #[test]
    fn what_is_out_of_range_is_refused() {
        for function in [
            SurfaceFunction::blobs(0.0),
            SurfaceFunction::zhu_bridson(f32::NAN),
            SurfaceFunction::ZhuBridson { support: 1.0, radius: 1.0 },
            SurfaceFunction::Density { support: 1.0, iso: 0.0 },
            SurfaceFunction::Anisotropic { support: 1.0, iso: 0.5, centring: 2.0 },
            SurfaceFunction::Blobs { support: 1.0, radius: 0.5, sharpness: 1e9 },
        ] {
            assert!(Surface::new(&Context::serial(), &[[0.0; 3]], function).is_err(), "{function:?}");
        }
        assert!(Surface::new(&Context::serial(), &[[f32::INFINITY; 3]], SurfaceFunction::blobs(1.0)).is_err());
        assert!(Surface::new(&Context::serial(), &[], SurfaceFunction::blobs(1.0)).unwrap().is_empty());
    }

    proptest! {
        #[test]
        fn gradients_and_weights_are_those_of_the_values(
            points in prop::collection::vec(prop::array::uniform3(0.0f32..1.0), 1..150),
            at in prop::array::uniform3(0.0f32..1.0),
        ) {
            let context = Context::serial();
            for function in FUNCTIONS {
                let surface = Surface::new(&context, &points, function(0.1)).unwrap();
                let mut probe = surface.probe(&context);
                let sample = probe.sample(at);
                for axis in 0..3 {
                    let step = |step: f32| {
                        let mut moved = at;
                        moved[axis] += step;
                        value(&surface, moved)
                    };
                    let [wide, fine] = [1e-3, 5e-4].map(|width| (step(width) - step(-width)) / (2.0 * width));
                    // Values have kinks where a mean is at a place and where the first particle comes near.
                    if (wide - fine).abs() < 0.01 * fine.abs().max(1.0) {
                        let close = (sample.gradient[axis] - fine).abs() < 0.05 * fine.abs().max(1.0);
                        prop_assert!(close, "{:?} {} {}", surface.function(), sample.gradient[axis], fine);
                    }
                }
                let (mut sum, mut seen) = (0.0, 0);
                probe.weights(at, |particle, weight| {
                    sum += weight;
                    seen += 1;
                    assert!((particle as usize) < points.len());
                });
                if let Combination::Sum { iso } = surface.combination {
                    prop_assert!((sum - iso - sample.value).abs() < 1e-5);
                }
                if surface.shapes.is_empty() {
                    let near = |point: &&[f32; 3]| Vec3::from(**point).distance(Vec3::from(at)) < 0.4;
                    let expected = points.iter().filter(near).count() as i32;
                    // At the rim weights are rounded to 0.
                    prop_assert!((expected - 2..=expected).contains(&seen), "{} {}", seen, expected);
                }
            }
        }
    }
}
