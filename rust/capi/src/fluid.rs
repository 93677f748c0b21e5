//! Fluids of particles; see `include/relievo/fluid.h`.

mod arrays;
mod sources;

use std::collections::HashSet;
use std::ffi::c_void;
use std::sync::{Arc, OnceLock, RwLock};

use glam::{DVec3, Vec3};
use relievo_core::{Error, Progress, Result};
use relievo_fluid::{
    Batch, ColliderOptions, Contact, Excess, Fluid, FluidOptions, Given, KernelSet, Overflow, PressureSolver, Sink,
    Solid, Sources, StepStatistics, TimeStep, basin, block,
};

use self::arrays::{Places, vector, vectors};
use self::sources::{emitter, force, placed};
use crate::array::{Input, Output, present, put};
use crate::context::{ContextObject, HostProgress, RlvContext, RlvProgress};
use crate::descriptor::{check_optional, numbered, read_descriptor, read_optional, write_descriptor, write_optional};
use crate::isosurface::{self, RlvIsosurface, RlvIsosurfaceOptions};
use crate::mesh::RlvMesh;
use crate::registry::{self, handle, try_read, try_write};

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

/// Kernels by their numbers.
const KERNELS: [(KernelSet, &str); 2] = [(KernelSet::Wendland, "wendland"), (KernelSet::Mueller, "mueller")];

/// Solvers of pressures by their numbers.
const SOLVERS: [(PressureSolver, &str); 2] = [(PressureSolver::Pcisph, "pcisph"), (PressureSolver::Dfsph, "dfsph")];

descriptor! {
    pub struct RlvFluidOptions {
        struct_size: u32,
        kernels: u32,
        spacing: f32,
        density: f32,
        viscosity: f32,
        friction: f32,
        cohesion: f32,
        gravity: [f32; 3],
        max_excess: f32,
        mean_excess: f32,
        min_corrections: u32,
        max_corrections: u32,
        steps: u32,
        courant: f32,
        step: f32,
        solver: u32,
    }
}

descriptor! {
    pub struct RlvFluidInfo {
        struct_size: u32,
        reserved: u32,
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
    pub struct RlvFluidParticles {
        struct_size: u32,
        lifetime: f32,
        count: usize,
        points: *const f32,
        point_stride: usize,
        velocities: *const f32,
        velocity_stride: usize,
        velocity: [f32; 3],
        reserved: u32,
    }
}

descriptor! {
    pub struct RlvFluidArrays {
        struct_size: u32,
        reserved: u32,
        capacity: usize,
        points: *mut f32,
        point_stride: usize,
        velocities: *mut f32,
        velocity_stride: usize,
        numbers: *mut u32,
        number_stride: usize,
        pressures: *mut f32,
        pressure_stride: usize,
        densities: *mut f32,
        density_stride: usize,
        births: *mut f64,
        birth_stride: usize,
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

descriptor! {
    pub struct RlvFluidForce {
        kind: u32,
        seed: u32,
        vector: [f32; 3],
        place: [f32; 3],
        strength: f32,
        radius: f32,
        rate: f32,
    }
}

descriptor! {
    pub struct RlvFluidEmitterOptions {
        struct_size: u32,
        shape: u32,
        middle: [f32; 3],
        u: [f32; 3],
        v: [f32; 3],
        radius: f32,
        speed: f32,
        lifetime: f32,
        begin: f64,
        end: f64,
    }
}

descriptor! {
    pub struct RlvFluidColliderOptions {
        struct_size: u32,
        contact: u32,
        friction: f32,
        is_container: u32,
    }
}

/// Bytes that a particle takes, with what a step needs: lists of neighbours most of all.
const PARTICLE: u64 = 700;

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
}

impl FluidObject {
    /// Has the fluid for itself while it changes.
    fn change<T>(&self, work: impl FnOnce(&mut Simulation) -> Result<T>) -> Result<T> {
        let mut simulation = try_write(&self.simulation, "fluid")?;
        simulation.order.take();
        work(&mut simulation)
    }

    /// Fails unless so many particles fit the memory limit.
    fn holds(&self, name: &str, count: usize) -> Result<()> {
        let bytes = (count as u64).saturating_mul(PARTICLE);
        if bytes <= self.context.context.memory_limit() {
            return Ok(());
        }
        Err(Error::memory(format!("{count} particles take {bytes} bytes, more than the memory limit"))
            .at(name)
            .advise("raise the memory limit of the context, or take a larger spacing"))
    }

    /// Fails unless particles that fill a box fit the memory limit beside those that there are. What is no box is refused by
    /// who fills it.
    fn holds_box(&self, corners: [Vec3; 2], there: usize) -> Result<()> {
        self.holds("box", (self.cells(corners).element_product() as usize).saturating_add(there))
    }

    /// The same of the particles around a box.
    fn holds_basin(&self, corners: [Vec3; 2]) -> Result<()> {
        let cells = self.cells(corners);
        self.holds("basin", ((cells + 2.0).element_product() - cells.element_product()) as usize)
    }

    /// How many spacings the sides of a box have; 0 of what is none.
    fn cells(&self, [low, high]: [Vec3; 2]) -> DVec3 {
        let cells = ((high - low).as_dvec3() / f64::from(self.spacing)).round();
        if cells.is_finite() { cells.max(DVec3::ZERO) } else { DVec3::ZERO }
    }

    /// Simulates so many seconds.
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
                self.holds("fluid", fluid.len())?;
                progress.step((report.seconds / seconds).min(1.0) as f32, "fluid")
            })?;
            Ok(report)
        })
    }
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

/// What is asked for.
///
/// # Safety
/// `options` is NULL or a descriptor that starts with its size.
unsafe fn read_options(options: *const RlvFluidOptions) -> Result<FluidOptions> {
    let usual = FluidOptions::default();
    let (courant, step) = match usual.time_step {
        TimeStep::Courant { number, most } => (number, most),
        TimeStep::Fixed(step) => (1.0, step),
    };
    let default = RlvFluidOptions {
        struct_size: 0,
        kernels: RLV_FLUID_WENDLAND,
        spacing: usual.spacing,
        density: usual.density,
        viscosity: usual.viscosity,
        friction: usual.friction,
        cohesion: usual.cohesion,
        gravity: usual.gravity.to_array(),
        max_excess: usual.excess.most,
        mean_excess: usual.excess.mean,
        min_corrections: usual.corrections[0],
        max_corrections: usual.corrections[1],
        steps: RLV_FLUID_COURANT,
        courant,
        step,
        solver: RLV_FLUID_PCISPH,
    };
    // SAFETY: promised by the caller.
    let given = unsafe { read_optional(options, default) }?;
    let time_step = match given.steps {
        RLV_FLUID_COURANT => TimeStep::Courant { number: given.courant, most: given.step },
        RLV_FLUID_FIXED => TimeStep::Fixed(given.step),
        other => {
            return Err(Error::invalid(format!("there are no steps {other}")).at("steps").advise("use 0 or 1"));
        }
    };
    Ok(FluidOptions {
        spacing: given.spacing,
        density: given.density,
        viscosity: given.viscosity,
        friction: given.friction,
        cohesion: given.cohesion,
        gravity: given.gravity.into(),
        kernels: numbered("kernels", &KERNELS, given.kernels)?,
        excess: Excess { most: given.max_excess, mean: given.mean_excess },
        corrections: [given.min_corrections, given.max_corrections],
        time_step,
        solver: numbered("solver", &SOLVERS, given.solver)?,
    })
}

/// How a collider behaves.
///
/// # Safety
/// `options` is NULL or a descriptor that starts with its size.
unsafe fn read_collider(options: *const RlvFluidColliderOptions) -> Result<ColliderOptions> {
    let default = RlvFluidColliderOptions { struct_size: 0, contact: RLV_FLUID_SLIP, friction: 0.0, is_container: 0 };
    // SAFETY: promised by the caller.
    let given = unsafe { read_optional(options, default) }?;
    if !(given.friction >= 0.0 && given.friction.is_finite()) {
        return Err(Error::invalid(format!("{} is no friction", given.friction))
            .at("friction")
            .advise("use 0 or more"));
    }
    let contact = match given.contact {
        RLV_FLUID_SLIP => Contact::Slip,
        RLV_FLUID_STOP => Contact::Stop,
        RLV_FLUID_FRICTION => Contact::Friction(given.friction),
        other => return Err(Error::invalid(format!("there is no contact {other}")).at("contact").advise("use 0 to 2")),
    };
    let is_container = match given.is_container {
        0 => false,
        1 => true,
        other => {
            let error = Error::invalid(format!("is_container is {other}")).at("is_container");
            return Err(error.advise("use 0 or 1"));
        }
    };
    Ok(ColliderOptions { contact, is_container })
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
            reserved: 0,
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

    fn rlv_fluid_add(fluid: RlvFluid, particles: *const RlvFluidParticles) {
        let object = registry::get(fluid)?;
        // SAFETY: a descriptor of nothing but numbers and NULL pointers.
        let default: RlvFluidParticles = unsafe { std::mem::zeroed() };
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        let given = unsafe { read_descriptor(particles, default) }?;
        let limit = object.context.context.memory_limit();
        // SAFETY: the caller promises `count` elements of each that is not NULL.
        let (places, velocities) = unsafe {
            let places = vectors("points", given.points, given.count, given.point_stride, limit)?;
            let velocities = if given.velocities.is_null() {
                vec![given.velocity.into()]
            } else {
                vectors("velocities", given.velocities, given.count, given.velocity_stride, limit)?
            };
            (places, velocities)
        };
        let lifetime = if given.lifetime == 0.0 { f32::INFINITY } else { given.lifetime };
        let batch = Batch { places: &places, velocities: &velocities, lifetime, channels: &[] };
        object.change(|simulation| {
            object.holds("particles", simulation.fluid.len() + places.len())?;
            simulation.fluid.add_batch(&batch)
        })
    }

    fn rlv_fluid_add_box(fluid: RlvFluid, low: *const f32, high: *const f32, velocity: *const f32) {
        let object = registry::get(fluid)?;
        // SAFETY: the caller gives three floats each, or NULL.
        let (corners, velocity) = unsafe {
            let velocity = if velocity.is_null() { Vec3::ZERO } else { vector("velocity", velocity)? };
            ([vector("low", low)?, vector("high", high)?], velocity)
        };
        object.change(|simulation| {
            object.holds_box(corners, simulation.fluid.len())?;
            let places = block(corners[0], corners[1], object.spacing)?;
            simulation.fluid.add(&places, velocity)
        })
    }

    fn rlv_fluid_fill(fluid: RlvFluid, mesh: RlvMesh, matrix: *const f64, velocity: *const f32, added: *mut usize) {
        let (object, mesh) = (registry::get(fluid)?, registry::get(mesh)?);
        let context = &object.context.context;
        // SAFETY: the caller promises NULL or twelve doubles, and NULL or three floats.
        let ((points, triangles), velocity) = unsafe {
            let velocity = if velocity.is_null() { Vec3::ZERO } else { vector("velocity", velocity)? };
            (placed(&*try_read(&mesh.mesh, "mesh")?, matrix)?, velocity)
        };
        let solid = Solid::new(&points, &triangles)?;
        let low = points.iter().copied().fold(Vec3::INFINITY, Vec3::min);
        let high = points.iter().copied().fold(Vec3::NEG_INFINITY, Vec3::max);
        let count = object.change(|simulation| {
            object.holds_box([low, high], simulation.fluid.len())?;
            let places = solid.fill(context, object.spacing)?;
            let places = simulation.fluid.beside_walls(context, &places)?;
            simulation.fluid.add(&places, velocity)?;
            Ok(places.len())
        })?;
        if !added.is_null() {
            // SAFETY: it is not NULL, and the caller promises a place.
            unsafe { put(added, count) };
        }
        Ok(())
    }

    fn rlv_fluid_add_emitter(
        fluid: RlvFluid,
        options: *const RlvFluidEmitterOptions,
        mesh: RlvMesh,
        matrix: *const f64,
    ) {
        let object = registry::get(fluid)?;
        // SAFETY: a descriptor of nothing but numbers.
        let default: RlvFluidEmitterOptions = unsafe { std::mem::zeroed() };
        // SAFETY: the caller gives NULL or a descriptor that starts with its size, and NULL or twelve doubles.
        let made = unsafe {
            let given = read_descriptor(options, default)?;
            emitter(&given, mesh, matrix, object.spacing)?
        };
        object.change(|simulation| {
            simulation.sources.emitters.push(made);
            Ok(())
        })
    }

    fn rlv_fluid_add_sink(fluid: RlvFluid, low: *const f32, high: *const f32, is_outside: u32) {
        let object = registry::get(fluid)?;
        // SAFETY: the caller gives three floats each, or NULL.
        let corners = unsafe { [vector("low", low)?, vector("high", high)?] };
        if !corners.iter().all(|corner| corner.is_finite()) {
            return Err(Error::invalid("a corner is not finite").at("sink"));
        }
        let sink = match is_outside {
            0 => Sink::Inside(corners),
            1 => Sink::Outside(corners),
            other => return Err(Error::invalid(format!("is_outside is {other}")).at("is_outside").advise("use 0 or 1")),
        };
        object.change(|simulation| {
            simulation.sources.sinks.push(sink);
            Ok(())
        })
    }

    fn rlv_fluid_add_sink_mesh(fluid: RlvFluid, mesh: RlvMesh, matrix: *const f64) {
        let (object, mesh) = (registry::get(fluid)?, registry::get(mesh)?);
        // SAFETY: the caller promises NULL or twelve doubles.
        let (points, triangles) = unsafe { placed(&*try_read(&mesh.mesh, "mesh")?, matrix) }?;
        let sink = Sink::Mesh(Solid::new(&points, &triangles)?);
        object.change(|simulation| {
            simulation.sources.sinks.push(sink);
            Ok(())
        })
    }

    fn rlv_fluid_clear_sources(fluid: RlvFluid) {
        registry::get(fluid)?.change(|simulation| {
            simulation.sources.emitters.clear();
            simulation.sources.sinks.clear();
            Ok(())
        })
    }

    fn rlv_fluid_set_budget(fluid: RlvFluid, particles: usize, stops: u32) {
        let object = registry::get(fluid)?;
        let overflow = match stops {
            0 => Overflow::Refuse,
            1 => Overflow::Stop,
            other => return Err(Error::invalid(format!("stops is {other}")).at("stops").advise("use 0 or 1")),
        };
        object.change(|simulation| {
            simulation.sources.budget = (particles > 0).then_some(particles);
            simulation.sources.overflow = overflow;
            Ok(())
        })
    }

    fn rlv_fluid_set_forces(fluid: RlvFluid, forces: *const RlvFluidForce, count: usize, stride: usize) {
        let object = registry::get(fluid)?;
        // SAFETY: the caller promises `count` forces.
        let forces = unsafe { Input::new("forces", forces, count, stride) }?;
        let forces = forces.to_vec("forces", object.context.context.memory_limit())?;
        let named = |(at, given)| force(given).map_err(|error| error.at(format!("force {at}")));
        let forces = forces.iter().enumerate().map(named).collect::<Result<Vec<_>>>()?;
        object.change(|simulation| simulation.fluid.set_forces(&forces))
    }

    fn rlv_fluid_remove(fluid: RlvFluid, numbers: *const u32, count: usize, stride: usize, removed: *mut usize) {
        let object = registry::get(fluid)?;
        // SAFETY: the caller promises `count` numbers.
        let numbers = unsafe { Input::new("numbers", numbers, count, stride) }?;
        let gone: HashSet<u32> = numbers.to_vec("numbers", object.context.context.memory_limit())?.into_iter().collect();
        let count = object.change(|simulation| {
            let there = simulation.fluid.numbers().to_vec();
            Ok(simulation.fluid.remove(|at| gone.contains(&there[at])))
        })?;
        if !removed.is_null() {
            // SAFETY: it is not NULL, and the caller promises a place.
            unsafe { put(removed, count) };
        }
        Ok(())
    }

    fn rlv_fluid_set_walls(fluid: RlvFluid, points: *const f32, count: usize, stride: usize) {
        let object = registry::get(fluid)?;
        let context = &object.context.context;
        object.holds("points", count)?;
        // SAFETY: the caller promises `count` points.
        let places = unsafe { vectors("points", points, count, stride, context.memory_limit()) }?;
        object.change(|simulation| {
            simulation.fluid.set_walls(context, &places)?;
            simulation.walls = places.len();
            Ok(())
        })
    }

    fn rlv_fluid_set_basin(fluid: RlvFluid, low: *const f32, high: *const f32) {
        let object = registry::get(fluid)?;
        // SAFETY: the caller gives three floats each, or NULL.
        let corners = unsafe { [vector("low", low)?, vector("high", high)?] };
        object.change(|simulation| {
            object.holds_basin(corners)?;
            let places = basin(corners[0], corners[1], object.spacing)?;
            simulation.fluid.set_walls(&object.context.context, &places)?;
            simulation.walls = places.len();
            Ok(())
        })
    }

    fn rlv_fluid_move_walls(
        fluid: RlvFluid,
        points: *const f32,
        stride: usize,
        velocities: *const f32,
        velocity_stride: usize,
        count: usize,
    ) {
        let object = registry::get(fluid)?;
        let limit = object.context.context.memory_limit();
        // SAFETY: the caller promises `count` elements of each.
        let (places, velocities) = unsafe {
            (vectors("points", points, count, stride, limit)?, vectors("velocities", velocities, count, velocity_stride, limit)?)
        };
        object.change(|simulation| simulation.fluid.move_walls(&places, &velocities))
    }

    fn rlv_fluid_add_collider(
        fluid: RlvFluid,
        mesh: RlvMesh,
        matrix: *const f64,
        options: *const RlvFluidColliderOptions,
        out: *mut u32,
    ) {
        present("out", out)?;
        let (object, mesh) = (registry::get(fluid)?, registry::get(mesh)?);
        // SAFETY: the caller promises NULL or twelve doubles, and NULL or a descriptor that starts with its size.
        let ((points, triangles), options) =
            unsafe { (placed(&*try_read(&mesh.mesh, "mesh")?, matrix)?, read_collider(options)?) };
        let number = object.change(|simulation| {
            simulation.fluid.add_collider(&object.context.context, &points, &triangles, options)
        })?;
        // SAFETY: checked above.
        unsafe { put(out, number as u32) };
        Ok(())
    }

    fn rlv_fluid_move_collider(
        fluid: RlvFluid,
        collider: u32,
        from: *const f32,
        to: *const f32,
        count: usize,
        stride: usize,
        seconds: f32,
    ) {
        let object = registry::get(fluid)?;
        let context = &object.context.context;
        // SAFETY: the caller promises `count` points of each that is not NULL.
        let (from, to) = unsafe {
            let path = |name, points| vectors(name, points, count, stride, context.memory_limit());
            ((!from.is_null()).then(|| path("from", from)).transpose()?, path("to", to)?)
        };
        check_seconds(f64::from(seconds))?;
        object.change(|simulation| {
            let number = collider as usize;
            let from = from.unwrap_or_else(|| simulation.fluid.collider_points(number).to_vec());
            simulation.fluid.move_collider(context, number, [&from, &to], seconds)
        })
    }

    fn rlv_fluid_impulse(fluid: RlvFluid, collider: u32, linear: *mut f64, angular: *mut f64) {
        let object = registry::get(fluid)?;
        // SAFETY: the caller promises NULL or three doubles each.
        let (linear, angular) =
            unsafe { (Output::optional("linear", linear, 3, 0)?, Output::optional("angular", angular, 3, 0)?) };
        let simulation = try_read(&object.simulation, "fluid")?;
        if collider != RLV_FLUID_WALLS && simulation.fluid.collider_points(collider as usize).is_empty() {
            return Err(Error::invalid("it does not exist").at(format!("collider {collider}")));
        }
        // Nothing was given before the first step.
        let given = simulation.fluid.impulses().get(collider.wrapping_add(1) as usize).copied().unwrap_or_default();
        for (out, impulse) in [(linear, given.linear), (angular, given.angular)] {
            if let Some(out) = out {
                out.fill(impulse.to_array());
            }
        }
        Ok(())
    }

    fn rlv_fluid_accelerate(fluid: RlvFluid, accelerations: *const f32, count: usize, stride: usize) {
        let object = registry::get(fluid)?;
        // SAFETY: the caller promises `count` vectors.
        let given = unsafe { vectors("accelerations", accelerations, count, stride, object.context.context.memory_limit()) }?;
        object.change(|simulation| {
            let mut sorted = given.clone();
            if count == simulation.fluid.len() {
                simulation.order().iter().zip(&given).for_each(|(at, given)| sorted[*at as usize] = *given);
            }
            simulation.fluid.accelerate(&sorted)
        })
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
            object.holds("fluid", simulation.fluid.len())
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

    fn rlv_fluid_get(fluid: RlvFluid, arrays: *const RlvFluidArrays) {
        let object = registry::get(fluid)?;
        // SAFETY: a descriptor of nothing but numbers and NULL pointers.
        let default: RlvFluidArrays = unsafe { std::mem::zeroed() };
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        let given = unsafe { read_descriptor(arrays, default) }?;
        // SAFETY: the caller promises room for the capacity.
        let places = unsafe { Places::new(&given) }?;
        let holds = |simulation: &Simulation| {
            let (room, needed) = (given.capacity, simulation.fluid.len());
            if needed <= room {
                return Ok(());
            }
            Err(Error::invalid(format!("there is room for {room} particles, but there are {needed}"))
                .at("capacity")
                .advise("ask for the count first and pass arrays of that size"))
        };
        let Some(out) = places.densities else {
            let simulation = try_read(&object.simulation, "fluid")?;
            holds(&simulation)?;
            places.fill(&simulation);
            return Ok(());
        };
        object.change(|simulation| {
            holds(simulation)?;
            let densities: Vec<f32> = simulation.fluid.densities(&object.context.context)?.collect();
            out.fill(simulation.by_number(|at| densities[at]));
            places.fill(simulation);
            Ok(())
        })
    }

    fn rlv_fluid_isosurface(fluid: RlvFluid, options: *const RlvIsosurfaceOptions, out: *mut RlvIsosurface) {
        present("out", out)?;
        let object = registry::get(fluid)?;
        let particles = {
            let simulation = try_read(&object.simulation, "fluid")?;
            let fluid = &simulation.fluid;
            [fluid.places(), fluid.velocities()].map(|rows| simulation.by_number(|at| rows[at].truncate().to_array()).collect())
        };
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        let made = unsafe { isosurface::register(object.context.clone(), particles, options, 0.5 * object.spacing) }?;
        // SAFETY: checked above.
        unsafe { put(out, made) };
        Ok(())
    }
}
