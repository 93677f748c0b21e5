//! What follows from a fluid's options and does not change while it is simulated.

use relievo_core::lanes::Lanes;

use crate::FluidOptions;
use crate::solver::kernel::{KernelSet, Kernels};

/// Support radius of the kernels, in spacings: 33 neighbours in a lattice.
const SUPPORT: f32 = 2.0;
/// A wall's kernel is (1 − r / h) to this power, by which its slope is twice that of a lattice that goes on: the wall does
/// not move, so all the pressure between it and a particle is the particle's.
pub const WALL: i32 = 7;
/// What two particles pull each other by at most, and by a difference of normals of 1, over tension and spacing. In a fluid
/// without order beside a flat surface the work along it less that across (Fowler 1937) is 0.600 of the first and 2.066 of the
/// second, together 1. More of the first draws the outermost particles in, with less of it drops do not stay together.
pub const TENSION: [f32; 2] = [0.25, 0.41];

/// Masses, kernels and factors of a fluid.
#[derive(Clone, Copy, Debug)]
pub struct Constants {
    pub kernels: Kernels,
    /// m
    pub spacing: f32,
    /// kg of a particle: a full lattice has the density at rest.
    pub mass: f32,
    /// kg/m³ of the fluid at rest.
    pub density: f32,
    /// What a wall's kernel is at no distance, in 1/m³: beside a flat wall a lattice has the density at rest.
    pub wall: f32,
    /// Σ |m ∇W|² of a particle in a full lattice, by which its density follows its pressure.
    pub diagonal: f32,
    /// m²/s between particles, as much more than the fluid's as a full lattice sums up to less, and between these and walls.
    pub viscosity: f32,
    pub friction: f32,
    /// m⁵/(kg s²)
    pub cohesion: f32,
    /// What surface tension accelerates by where the pull of two particles is greatest, and for a difference of normals of 1,
    /// in m/s².
    pub tension: [f32; 2],
}

impl Constants {
    /// Of options that are in range.
    pub fn new(options: &FluidOptions) -> Self {
        let spacing = options.spacing;
        let kernels = Kernels::new(options.kernels, SUPPORT * spacing);
        let reach = SUPPORT.ceil() as i32;
        let axis = -reach..=reach;
        let plane: Vec<i32> = axis.clone().flat_map(|x| axis.clone().map(move |y| x * x + y * y)).collect();
        let distance = |square: i32| (square as f32).sqrt() * spacing;
        let layer = |height: i32| plane.iter().map(move |square| distance(square + height * height));
        let all = || axis.clone().flat_map(layer);
        let mass = options.density / all().map(|r| kernels.density(r)).sum::<f32>();
        let slopes = all().map(|r| kernels.density_slope(r) * kernels.pressure_slope(r) * r * r);
        let beside: f32 = layer(1).map(|r| kernels.density(r)).sum();
        // The second moment of viscosity's kernel, which is 6 where it is the Laplacian.
        let moment = mass / options.density * all().map(|r| kernels.viscosity(r) * r * r).sum::<f32>();
        let wall: f32 = layer(1).map(|r| (1.0 - r / kernels.support).max(0.0).powi(WALL)).sum();
        Self {
            kernels,
            spacing,
            mass,
            density: options.density,
            wall: beside / wall,
            diagonal: mass * mass * slopes.sum::<f32>(),
            viscosity: options.viscosity * 6.0 / moment,
            friction: options.friction,
            cohesion: options.cohesion,
            tension: TENSION.map(|share| share * options.tension * spacing / mass),
        }
    }
}

/// The kernels in lanes.
#[derive(Clone, Copy)]
pub struct KernelLanes<A: Lanes> {
    v: A,
    set: KernelSet,
    zero: A::F,
    one: A::F,
    tiny: A::F,
    support: A::F,
    over: A::F,
    /// What slopes are multiplied by: of the kernel of pressures, and of walls.
    pressure: A::F,
    wall: A::F,
}

impl<A: Lanes> KernelLanes<A> {
    #[inline(always)]
    pub fn new(v: A, constants: &Constants) -> Self {
        let Kernels { set, support, density, spiky } = constants.kernels;
        let pressure = match set {
            KernelSet::Wendland => -20.0 * density / (support * support),
            KernelSet::Mueller => -spiky * support * support,
        };
        Self {
            v,
            set,
            zero: v.splat(0.0),
            one: v.splat(1.0),
            tiny: v.splat(1e-6 * support),
            support: v.splat(support),
            over: v.splat(support.recip()),
            pressure: v.splat(pressure),
            wall: v.splat(-(WALL as f32) * constants.wall / support),
        }
    }

    /// 1 − r / h, and 0 beyond the support.
    #[inline(always)]
    fn left(&self, distance: A::F) -> A::F {
        let v = self.v;
        v.max(v.sub(self.one, v.mul(distance, self.over)), self.zero)
    }

    /// The kernel of densities at the square of a distance, relative to no distance.
    #[inline(always)]
    pub fn density(&self, square: A::F) -> A::F {
        let v = self.v;
        match self.set {
            KernelSet::Wendland => {
                let left = self.left(v.sqrt(square));
                let four = v.mul(v.mul(left, left), v.mul(left, left));
                // (4 q + 1) with q = 1 − left.
                v.mul(four, v.fused(v.splat(-4.0), left, v.splat(5.0)))
            }
            KernelSet::Mueller => {
                let left = v.max(v.sub(self.one, v.mul(square, v.mul(self.over, self.over))), self.zero);
                v.mul(left, v.mul(left, left))
            }
        }
    }

    /// The slope of pressure's kernel at a distance, as a factor of the vector from the other particle, and h − r, which
    /// viscosity's is a multiple of.
    #[inline(always)]
    pub fn slope(&self, distance: A::F) -> [A::F; 2] {
        let v = self.v;
        let left = self.left(distance);
        let share = match self.set {
            KernelSet::Wendland => v.mul(left, v.mul(left, left)),
            KernelSet::Mueller => v.div(v.mul(left, left), v.max(distance, self.tiny)),
        };
        [v.mul(self.pressure, share), v.mul(left, self.support)]
    }

    /// What pulls two particles at a distance together (Akinci, Akinci, Teschner 2013, Equation 2), relative to its most, which
    /// is at half the support, as a factor of the vector between them; and 1 − r / h.
    #[inline(always)]
    pub fn cohesion(&self, distance: A::F) -> [A::F; 2] {
        let v = self.v;
        let left = self.left(distance);
        let q = v.sub(self.one, left);
        let t = v.mul(q, left);
        let cube = v.mul(v.mul(t, t), v.mul(t, v.splat(64.0)));
        let near = v.fused(v.splat(2.0), cube, v.splat(-1.0));
        let share = v.select(v.lt(q, v.splat(0.5)), near, cube);
        [v.div(share, v.max(distance, self.tiny)), left]
    }

    /// A wall's kernel at a distance, relative to no distance.
    #[inline(always)]
    pub fn wall(&self, distance: A::F) -> A::F {
        let v = self.v;
        let left = self.left(distance);
        v.mul(self.six(left), left)
    }

    /// The slope of a wall's kernel at a distance, as a factor of the vector from it, and h − r.
    #[inline(always)]
    pub fn wall_slope(&self, distance: A::F) -> [A::F; 2] {
        let v = self.v;
        let left = self.left(distance);
        [v.div(v.mul(self.wall, self.six(left)), v.max(distance, self.tiny)), v.mul(left, self.support)]
    }

    #[inline(always)]
    fn six(&self, left: A::F) -> A::F {
        let v = self.v;
        let cube = v.mul(left, v.mul(left, left));
        v.mul(cube, cube)
    }
}
