//! The surface function of a set of particles, prepared for looking at places: sorted, with the kernels of all
//! particles.

mod anisotropy;
pub(crate) mod blind;
pub(crate) mod block;
mod chords;
pub(crate) mod function;
pub(crate) mod hierarchy;
mod interior;
pub(crate) mod isosurface;
pub(crate) mod level_set;
mod marching;
pub(crate) mod probe;
pub(crate) mod profile;
pub(crate) mod raytrace;
pub(crate) mod rows;
pub(crate) mod smoothing;

use glam::{DVec3, Vec3};
use relievo_core::{Context, Error, Result};

use crate::surface::anisotropy::Kernel;
use crate::surface::function::{Combination, SurfaceFunction};
use crate::surface::probe::Probe;
use crate::surface::profile::{Profile, WIDEST};
use crate::surface::rows::Rows;

/// Cells are wider than what particles reach by this factor, so that rounding hides none.
const MARGIN: f32 = 1.0001;
/// Pairs of particles of the same cell at most.
const MAX_PAIRS: u64 = 1 << 33;

/// A function of particles, prepared: particles in the order of cells, with the amplitude and the shape of the kernel
/// of each. Some 22 bytes a particle, 46 with anisotropic kernels.
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
    /// The entries xx, xy, xz, yy, yz, zz of symmetric matrices M of anisotropic kernels: s = dᵀ M d.
    pub(crate) shapes: Option<[Vec<f32>; 6]>,
}

impl Surface {
    /// Of particles at these positions, in metres.
    ///
    /// # Errors
    /// Fails if a parameter is out of range, if a position is not finite, or if there are 2³² particles or such as are
    /// more than a million support radii apart; of densities and anisotropic kernels, if so many particles lie on each
    /// other that their pairs, cell by cell, are more than 2³³.
    pub fn new(context: &Context, positions: &[[f32; 3]], function: SurfaceFunction) -> Result<Self> {
        function.check()?;
        let mut surface = Self::spheres(context, positions, function)?;
        if matches!(function, SurfaceFunction::Density { .. } | SurfaceFunction::Anisotropic { .. }) {
            surface.check_pairs()?;
        }
        match function {
            SurfaceFunction::Blobs { .. } | SurfaceFunction::ZhuBridson { .. } => Ok(surface),
            SurfaceFunction::Density { .. } => {
                surface.amplitudes = surface.volumes(context);
                Ok(surface)
            }
            SurfaceFunction::Anisotropic { support, centring, .. } => {
                let amplitudes = surface.volumes(context);
                let kernels = surface.by_cell(context, Kernel::default(), |probe, at| {
                    anisotropy::kernel(&surface, at, centring, probe.seek(surface.centre(at)))
                });
                let centres: Vec<[f32; 3]> = kernels.iter().map(|kernel| kernel.centre).collect();
                let widest = kernels.iter().fold(1.0f32, |widest, kernel| widest.max(kernel.widest));
                let (rows, order) = Rows::new(context, &centres, widest * support * MARGIN)?;
                let amplitude = |at: &u32| amplitudes[*at as usize] * kernels[*at as usize].amplitude;
                let mut shapes = [(); 6].map(|()| Vec::with_capacity(order.len() + WIDEST));
                for at in &order {
                    let matrix = kernels[*at as usize].matrix;
                    shapes.iter_mut().zip(matrix).for_each(|(shapes, entry)| shapes.push(entry));
                }
                shapes.iter_mut().for_each(|shapes| shapes.extend([0.0; WIDEST]));
                surface.shapes = Some(shapes);
                surface.amplitudes = order.iter().map(amplitude).chain([0.0; WIDEST]).collect();
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
            amplitudes: vec![1.0; positions.len() + WIDEST],
            order,
            sphere: 1.0 / (support * support),
            shapes: None,
        })
    }

    /// 1 / Σ w at every particle, of weights that are 1 in the middle: its volume times the middle of its kernel.
    fn volumes(&self, context: &Context) -> Vec<f32> {
        let volume = |probe: &mut Probe<'_>, at: usize| 1.0 / probe.total(self.centre(at));
        let mut volumes = self.by_cell(context, 0.0, volume);
        volumes.extend([0.0; WIDEST]);
        volumes
    }

    /// A value for every particle, in the order of the surface, computed cell by cell.
    fn by_cell<T: Copy + Send>(
        &self,
        context: &Context,
        blank: T,
        work: impl Fn(&mut Probe<'_>, usize) -> T + Sync,
    ) -> Vec<T> {
        let mut values = Vec::with_capacity(self.len() + WIDEST);
        values.resize(self.len(), blank);
        let mut parts = Vec::with_capacity(self.rows.len());
        let mut rest = values.as_mut_slice();
        for cell in 0..self.rows.len() {
            let (part, after) = rest.split_at_mut(self.rows.particles(cell).len());
            parts.push(part);
            rest = after;
        }
        context.for_each_mut(&mut parts, |cell, values| {
            let mut probe = self.probe(context);
            for (at, value) in self.rows.particles(cell).zip(values.iter_mut()) {
                *value = work(&mut probe, at);
            }
        });
        values
    }

    /// Fails where so many particles are in one cell that looking at all pairs would take minutes.
    fn check_pairs(&self) -> Result<()> {
        let crowd = |cell: usize| self.rows.particles(cell).len() as u64;
        let pairs = (0..self.rows.len()).fold(0u64, |pairs, cell| pairs.saturating_add(crowd(cell) * crowd(cell)));
        if pairs <= MAX_PAIRS {
            return Ok(());
        }
        let most = (0..self.rows.len()).map(crowd).max().unwrap_or(0);
        Err(Error::invalid(format!("{most} particles lie within a support radius of {}", self.reach))
            .advise("use a smaller support radius, or remove particles that lie on each other"))
    }

    /// How many particles there are.
    pub fn len(&self) -> usize {
        self.order.len()
    }

    /// Whether it has no particle.
    pub fn is_empty(&self) -> bool {
        self.order.is_empty()
    }

    /// The function.
    pub fn function(&self) -> SurfaceFunction {
        self.function
    }

    /// The distance from the centre of a kernel from which on it is 0, of all kernels the largest: the support radius,
    /// more with anisotropic kernels.
    pub fn reach(&self) -> f32 {
        self.reach
    }

    /// The distance from which on a particle does not change the value at a place: the reach, and how far the volumes,
    /// shapes and centres of kernels see.
    pub fn influence(&self) -> f32 {
        self.reach + self.function.sight()
    }

    /// For looking at many places, one after the other.
    pub fn probe(&self, context: &Context) -> Probe<'_> {
        Probe::new(self, context.level())
    }

    /// The centre of the kernel at this place of the order.
    pub(crate) fn centre(&self, at: usize) -> [f32; 3] {
        [self.centres[0][at], self.centres[1][at], self.centres[2][at]]
    }

    /// How far the kernel at this place of the order reaches along the axes.
    pub(crate) fn extent(&self, at: usize) -> Vec3 {
        let Some(shapes) = &self.shapes else { return Vec3::splat(self.reach) };
        let [xx, xy, xz, yy, yz, zz] = [0, 1, 2, 3, 4, 5].map(|entry| f64::from(shapes[entry][at]));
        // The roots of the diagonal of the inverse of M.
        let minors = DVec3::new(yy * zz - yz * yz, xx * zz - xz * xz, xx * yy - xy * xy);
        let determinant = xx * minors.x - xy * (xy * zz - xz * yz) + xz * (xy * yz - xz * yy);
        (minors / determinant).map(f64::sqrt).as_vec3()
    }

    /// M d of the kernel at this place of the order.
    pub(crate) fn image(&self, at: usize, d: Vec3) -> Vec3 {
        let Some(shapes) = &self.shapes else { return self.sphere * d };
        let [xx, xy, xz, yy, yz, zz] = [0, 1, 2, 3, 4, 5].map(|entry| shapes[entry][at]);
        Vec3::new(Vec3::new(xx, xy, xz).dot(d), Vec3::new(xy, yy, yz).dot(d), Vec3::new(xz, yz, zz).dot(d))
    }

    /// Half the extents of the box around a kernel: roots of the diagonal of the inverse of its matrix.
    #[inline(always)]
    pub(crate) fn half_extents(&self, at: usize) -> [f32; 3] {
        let Some(shapes) = &self.shapes else { return [self.reach; 3] };
        let [xx, xy, xz, yy, yz, zz] = [0, 1, 2, 3, 4, 5].map(|entry| shapes[entry][at]);
        let (first, second, third) = (yy * zz - yz * yz, xx * zz - xz * xz, xx * yy - xy * xy);
        let determinant = xx * first - xy * (xy * zz - yz * xz) + xz * (xy * yz - yy * xz);
        [first, second, third].map(|minor| (minor / determinant).max(0.0).sqrt())
    }
}

/// Coordinates in an order, and at the end some that are far from everything.
fn columns(points: &[[f32; 3]], order: &[u32]) -> [Vec<f32>; 3] {
    let far = [f32::MAX; WIDEST];
    std::array::from_fn(|axis| order.iter().map(|at| points[*at as usize][axis]).chain(far).collect())
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
        let shapes = surface.shapes.as_ref().unwrap();
        let [xx, xy, yy, zz] = [0, 1, 3, 5].map(|entry| shapes[entry][middle]);
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
    fn too_many_particles_at_one_point_are_refused_where_pairs_are_looked_at() {
        let points = vec![[1.0; 3]; 100_000];
        let error = Surface::new(&Context::serial(), &points, SurfaceFunction::density(0.1)).unwrap_err();
        assert!(error.to_string().contains("100000 particles"), "{error}");
        let surface = Surface::new(&Context::serial(), &points, SurfaceFunction::zhu_bridson(0.1)).unwrap();
        assert!(value(&surface, [1.05, 1.0, 1.0]) > 0.0);
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
                if surface.shapes.is_none() {
                    let near = |point: &&[f32; 3]| Vec3::from(**point).distance(Vec3::from(at)) < 0.4;
                    let expected = points.iter().filter(near).count() as i32;
                    // At the rim weights are rounded to 0.
                    prop_assert!((expected - 2..=expected).contains(&seen), "{} {}", seen, expected);
                }
            }
        }
    }
}
