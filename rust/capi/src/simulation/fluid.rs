//! Fluids of particles; see `include/relievo/fluid.h`.

mod arrays;
pub mod channels;
mod options;
pub mod particles;
pub mod sources;
pub mod state;
pub mod walls;

use std::ffi::c_void;
use std::sync::{Arc, OnceLock, RwLock};

use glam::{DVec3, Vec3, Vec4};
use relievo_core::{Error, Progress, Result};
use relievo_fluid::{Fluid, Given, ParticleChannel, Sources, StepStatistics};

pub use self::arrays::RlvFluidArrays;
pub use self::channels::*;
pub use self::options::RlvFluidOptions;
use self::options::read_options;
pub use self::particles::*;
pub use self::sources::*;
pub use self::state::*;
pub use self::walls::*;
use crate::border::array::{present, put};
use crate::border::descriptor::{check_optional, write_descriptor, write_optional};
use crate::border::registry::{self, handle, try_read, try_write};
use crate::runtime::context::{ContextObject, HostProgress, RlvContext, RlvProgress};
use crate::simulation::isosurface::{self, Carried, RlvIsosurface, RlvIsosurfaceOptions};

handle!(RlvFluid, 22, FluidObject);

constants! {
    u32:
    RLV_FLUID_WENDLAND = 0,
    RLV_FLUID_MUELLER = 1,
    RLV_FLUID_PCISPH = 0,
    RLV_FLUID_DFSPH = 1,
    RLV_FLUID_COURANT = 0,
    RLV_FLUID_FIXED = 1,
    RLV_FLUID_SLIP = 0,
    RLV_FLUID_STOP = 1,
    RLV_FLUID_FRICTION = 2,
    RLV_FLUID_WALLS = u32::MAX,
    RLV_FLUID_GRAVITY = 0,
    RLV_FLUID_WIND = 1,
    RLV_FLUID_DRAG = 2,
    RLV_FLUID_VORTEX = 3,
    RLV_FLUID_ATTRACTOR = 4,
    RLV_FLUID_TURBULENCE = 5,
    RLV_FLUID_DISC = 0,
    RLV_FLUID_RECTANGLE = 1,
    RLV_FLUID_SURFACE = 2,
}

descriptor! {
    pub struct RlvFluidInfo {
        struct_size: u32,
        channel_count: u32,
        particle_count: usize,
        wall_count: usize,
        seconds: f64,
        mass: f32,
        time_step: f32,
        momentum: [f32; 3],
        kinetic_energy: f32,
    }
}

descriptor! {
    pub struct RlvFluidReport {
        struct_size: u32,
        reserved: u32,
        seconds: f64,
        steps: u64,
        corrections: u64,
        max_excess: f32,
        mean_excess: f32,
        gravity: [f64; 3],
        host: [f64; 3],
        forces: [f64; 3],
        walls: [f64; 3],
        added: u64,
        removed: u64,
        divergence_corrections: u64,
    }
}

/// Bytes that a particle takes, with what a step needs: lists of neighbours most of all.
const PARTICLE: u64 = 700;

/// The same of each number of a channel: it is there twice while particles are sorted.
const NUMBER: u64 = 8;

/// A fluid and the context it belongs to.
pub struct FluidObject {
    pub context: Arc<ContextObject>,
    simulation: RwLock<Simulation>,
    spacing: f32,
}

struct Simulation {
    fluid: Fluid,
    walls: usize,
    sources: Sources,
    /// Places of particles in the lists of the fluid by rising numbers, as long as these do not change.
    order: OnceLock<Vec<u32>>,
}

impl Simulation {
    fn order(&self) -> &[u32] {
        self.order.get_or_init(|| {
            let numbers = self.fluid.numbers();
            let mut order: Vec<u32> = (0..numbers.len() as u32).collect();
            order.sort_unstable_by_key(|at| numbers[*at as usize]);
            order
        })
    }

    /// Values in the order of numbers.
    fn by_number<T>(&self, value: impl Fn(usize) -> T) -> impl ExactSizeIterator<Item = T> {
        self.order().iter().map(move |at| value(*at as usize))
    }

    /// A channel in the order of numbers.
    fn channel_by_number(&self, channel: &ParticleChannel) -> ParticleChannel {
        let ParticleChannel { name, width, values } = channel;
        let values = self.order().iter().flat_map(|at| &values[*at as usize * width..][..*width]).copied().collect();
        ParticleChannel { name: name.clone(), width: *width, values }
    }
}

impl FluidObject {
    /// Has the fluid for itself while it changes.
    fn change<T>(&self, work: impl FnOnce(&mut Simulation) -> Result<T>) -> Result<T> {
        let mut simulation = try_write(&self.simulation, "fluid")?;
        simulation.order.take();
        work(&mut simulation)
    }

    /// Fails unless so many particles that carry so many numbers each fit the memory limit.
    fn holds(&self, name: &str, count: usize, width: usize) -> Result<()> {
        let bytes = (count as u64).saturating_mul(PARTICLE + NUMBER * width as u64);
        if bytes <= self.context.context.memory_limit() {
            return Ok(());
        }
        Err(Error::memory(format!("{count} particles take {bytes} bytes, more than the memory limit"))
            .at(name)
            .advise("raise the memory limit of the context, or take a larger spacing"))
    }

    /// Fails unless particles that fill a box fit the memory limit beside the present ones. What is no box is refused
    /// by who fills it.
    fn holds_box(&self, corners: [Vec3; 2], there: &Fluid) -> Result<()> {
        let added = self.cells(corners).element_product() as usize;
        self.holds("box", added.saturating_add(there.len()), width(there))
    }

    /// The same of the particles around a box.
    fn holds_basin(&self, corners: [Vec3; 2]) -> Result<()> {
        let cells = self.cells(corners);
        self.holds("basin", ((cells + 2.0).element_product() - cells.element_product()) as usize, 0)
    }

    /// How many spacings the sides of a box have; 0 of what is none.
    fn cells(&self, [low, high]: [Vec3; 2]) -> DVec3 {
        let cells = ((high - low).as_dvec3() / f64::from(self.spacing)).round();
        if cells.is_finite() { cells.max(DVec3::ZERO) } else { DVec3::ZERO }
    }

    /// Simulates so many seconds.
    ///
    /// # Errors
    /// Fails with `Invalid` if the seconds are negative or not finite, or pressures do not converge, with `Busy` while
    /// another call is at work on the fluid, with `Memory` if its particles exceed the context's memory limit, and with
    /// `Cancelled` if `progress` asks to stop.
    pub fn advance(&self, seconds: f64, progress: &mut dyn Progress) -> Result<RlvFluidReport> {
        check_seconds(seconds)?;
        self.change(|simulation| {
            progress.step(0.0, "fluid")?;
            let mut report = RlvFluidReport::NOTHING;
            let context = &self.context.context;
            let Simulation { fluid, sources, .. } = simulation;
            let mut since = fluid.seconds();
            fluid.advance(context, seconds as f32, |fluid, done| {
                report.add(done);
                report.count(sources.renew(fluid, since)?);
                since = fluid.seconds();
                self.holds("fluid", fluid.len(), width(fluid))?;
                progress.step((report.seconds / seconds).min(1.0) as f32, "fluid")
            })?;
            Ok(report)
        })
    }
}

/// How many numbers a particle carries.
fn width(fluid: &Fluid) -> usize {
    fluid.channels().iter().map(|channel| channel.width).sum()
}

/// Fails unless a time can be simulated.
fn check_seconds(seconds: f64) -> Result<()> {
    if seconds >= 0.0 && (seconds as f32).is_finite() {
        return Ok(());
    }
    Err(Error::invalid(format!("{seconds} seconds cannot be simulated")).at("seconds").advise("use 0 or more"))
}

impl RlvFluidReport {
    const NOTHING: Self = Self {
        struct_size: 0,
        reserved: 0,
        seconds: 0.0,
        steps: 0,
        corrections: 0,
        max_excess: 0.0,
        mean_excess: 0.0,
        gravity: [0.0; 3],
        host: [0.0; 3],
        forces: [0.0; 3],
        walls: [0.0; 3],
        added: 0,
        removed: 0,
        divergence_corrections: 0,
    };

    /// Adds how many particles came and went.
    fn count(&mut self, [added, removed]: [usize; 2]) {
        self.added += added as u64;
        self.removed += removed as u64;
    }

    fn add(&mut self, done: &StepStatistics) {
        self.seconds += f64::from(done.seconds);
        self.steps += 1;
        self.corrections += u64::from(done.corrections);
        self.divergence_corrections += u64::from(done.divergence_corrections);
        self.max_excess = self.max_excess.max(done.excess.most);
        self.mean_excess = self.mean_excess.max(done.excess.mean);
        let sums = [&mut self.gravity, &mut self.host, &mut self.forces, &mut self.walls];
        let Given { gravity, host, forces, walls } = done.given;
        for (sum, given) in sums.into_iter().zip([gravity, host, forces, walls]) {
            *sum = (DVec3::from(*sum) + given).to_array();
        }
    }
}

entry! {
    fn rlv_fluid_create(context: RlvContext, options: *const RlvFluidOptions, out: *mut RlvFluid) {
        present("out", out)?;
        let context = registry::get(context)?;
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        let options = unsafe { read_options(options) }?;
        let spacing = options.spacing;
        let simulation = Simulation { fluid: Fluid::new(options)?, walls: 0, sources: Sources::default(), order: OnceLock::new() };
        let made = registry::insert(FluidObject { context, simulation: RwLock::new(simulation), spacing })?;
        // SAFETY: checked above.
        unsafe { put(out, made) };
        Ok(())
    }

    fn rlv_fluid_retain(fluid: RlvFluid) {
        registry::retain(fluid)
    }

    fn rlv_fluid_release(fluid: RlvFluid) {
        registry::release(fluid)
    }

    fn rlv_fluid_info(fluid: RlvFluid, out: *mut RlvFluidInfo) {
        let object = registry::get(fluid)?;
        let Simulation { fluid, walls, .. } = &*try_read(&object.simulation, "fluid")?;
        let info = RlvFluidInfo {
            struct_size: 0,
            channel_count: fluid.channels().len() as u32,
            particle_count: fluid.len(),
            wall_count: *walls,
            seconds: fluid.seconds(),
            mass: fluid.mass(),
            time_step: fluid.time_step(),
            momentum: fluid.momentum().to_array(),
            kinetic_energy: fluid.kinetic_energy(),
        };
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        unsafe { write_descriptor(out, info) }
    }

    fn rlv_fluid_step(fluid: RlvFluid, seconds: f32, out: *mut RlvFluidReport) {
        let object = registry::get(fluid)?;
        check_seconds(f64::from(seconds))?;
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        unsafe { check_optional(out) }?;
        let mut report = RlvFluidReport::NOTHING;
        object.change(|simulation| {
            let since = simulation.fluid.seconds();
            report.add(&simulation.fluid.step(&object.context.context, seconds)?);
            report.count(simulation.sources.renew(&mut simulation.fluid, since)?);
            object.holds("fluid", simulation.fluid.len(), width(&simulation.fluid))
        })?;
        // SAFETY: as above.
        unsafe { write_optional(out, report) }
    }

    fn rlv_fluid_advance(
        fluid: RlvFluid,
        seconds: f64,
        progress: RlvProgress,
        user: *mut c_void,
        out: *mut RlvFluidReport,
    ) {
        let object = registry::get(fluid)?;
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        unsafe { check_optional(out) }?;
        let report = object.advance(seconds, &mut HostProgress { callback: progress, user })?;
        // SAFETY: as above.
        unsafe { write_optional(out, report) }
    }

    fn rlv_fluid_isosurface(fluid: RlvFluid, options: *const RlvIsosurfaceOptions, out: *mut RlvIsosurface) {
        present("out", out)?;
        let object = registry::get(fluid)?;
        let particles = {
            let simulation = try_read(&object.simulation, "fluid")?;
            let fluid = &simulation.fluid;
            let vectors = |rows: &[Vec4]| simulation.by_number(|at| rows[at].truncate().to_array()).collect();
            // Normals are those of the surface.
            let channels = fluid.channels().iter().filter(|channel| channel.name != "normal");
            Carried {
                points: vectors(fluid.places()),
                velocities: vectors(fluid.velocities()),
                channels: channels.map(|channel| simulation.channel_by_number(channel)).collect(),
            }
        };
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        let made = unsafe { isosurface::register(object.context.clone(), particles, options, 0.5 * object.spacing) }?;
        // SAFETY: checked above.
        unsafe { put(out, made) };
        Ok(())
    }
}
