//! Diffuse particles: spray, foam and bubbles of a fluid; see `include/relievo/diffuse.h`.

use std::ffi::{c_char, c_void};
use std::path::Path;
use std::sync::{Arc, OnceLock, RwLock};

use glam::Vec3;
use relievo_core::{Error, Result, file};
use relievo_fluid::{Diffuse, DiffuseOptions, DiffuseSettings, FluidFrame};
use relievo_particleio::{read_frame, write_frame};

use crate::border::array::{Input, Output, Plain, narrow, present, put, text};
use crate::border::descriptor::{check_optional, read_descriptor, read_optional, write_descriptor, write_optional};
use crate::border::registry::{self, handle, try_read, try_write};
use crate::runtime::context::{ContextObject, HostProgress, RlvContext, RlvProgress};
use crate::runtime::parameter::{RlvParameter, Table, settings, write_table};
use crate::simulation::particles::{self, RlvParticles};

handle!(RlvDiffuse, 31, DiffuseObject);

settings!(RlvDiffuseSettings, DiffuseSettings);

descriptor! {
    pub struct RlvDiffuseOptions {
        struct_size: u32,
        spacing: f32,
        gravity: [f32; 3],
        has_bounds: u32,
        low: [f64; 3],
        high: [f64; 3],
    }
}

descriptor! {
    pub struct RlvDiffuseFluid {
        struct_size: u32,
        reserved: u32,
        count: usize,
        positions: *const f32,
        position_stride: usize,
        velocities: *const f32,
        velocity_stride: usize,
    }
}

descriptor! {
    pub struct RlvDiffuseInfo {
        struct_size: u32,
        reserved: u32,
        count: usize,
        frames: u64,
        births: u64,
    }
}

descriptor! {
    pub struct RlvDiffuseReport {
        struct_size: u32,
        reserved: u32,
        born: u64,
        gone: u64,
        refused: u64,
    }
}

descriptor! {
    pub struct RlvDiffusePotentials {
        struct_size: u32,
        reserved: u32,
        capacity: usize,
        air: *mut f32,
        crests: *mut f32,
        energies: *mut f32,
    }
}

descriptor! {
    pub struct RlvDiffuseArrays {
        struct_size: u32,
        reserved: u32,
        capacity: usize,
        positions: *mut f32,
        velocities: *mut f32,
        ids: *mut u32,
        kinds: *mut u32,
        ages: *mut f32,
        lifetimes: *mut f32,
        lives: *mut f32,
    }
}

/// What states that are saved here are of, where the command names settings and frames.
const IDENTITY: &str = "host";

/// A run of diffuse particles and the context it belongs to.
pub struct DiffuseObject {
    context: Arc<ContextObject>,
    run: RwLock<Diffuse>,
}

/// A fluid as vectors.
struct Fluid {
    positions: Vec<Vec3>,
    velocities: Vec<Vec3>,
}

impl Fluid {
    /// Copies the fluid of the host.
    ///
    /// # Safety
    /// `fluid` is NULL or a descriptor whose arrays are as the header demands.
    unsafe fn read(fluid: *const RlvDiffuseFluid, limit: u64) -> Result<Self> {
        // SAFETY: a descriptor of nothing but numbers and NULL pointers.
        let default: RlvDiffuseFluid = unsafe { std::mem::zeroed() };
        // SAFETY: promised by the caller.
        let given = unsafe { read_descriptor(fluid, default) }?;
        let copy = |name: &str, pointer: *const f32, stride: usize| {
            // SAFETY: the caller promises `count` vectors of each.
            let list = unsafe { Input::<[f32; 3]>::new(name, pointer.cast(), given.count, stride) }?;
            let copied = list.to_vec(name, limit)?;
            Ok::<_, Error>(copied.into_iter().map(Vec3::from).collect())
        };
        Ok(Self {
            positions: copy("positions", given.positions, given.position_stride)?,
            velocities: copy("velocities", given.velocities, given.velocity_stride)?,
        })
    }

    fn frame(&self) -> FluidFrame<'_> {
        FluidFrame { positions: &self.positions, velocities: &self.velocities }
    }
}

/// Returns the options of C, with the settings that go with them.
///
/// # Safety
/// `options` is NULL or a descriptor that starts with its size.
unsafe fn read_options(options: *const RlvDiffuseOptions, settings: DiffuseSettings) -> Result<DiffuseOptions> {
    let default = RlvDiffuseOptions {
        struct_size: 0,
        spacing: 0.02,
        gravity: [0.0, 0.0, -9.81],
        has_bounds: 0,
        low: [0.0; 3],
        high: [0.0; 3],
    };
    // SAFETY: promised by the caller.
    let given = unsafe { read_optional(options, default) }?;
    let bounds = match given.has_bounds {
        0 => None,
        1 => Some([given.low, given.high].map(|corner| narrow(corner).into())),
        other => return Err(Error::invalid(format!("has_bounds is {other}")).at("has_bounds").advise("use 0 or 1")),
    };
    Ok(DiffuseOptions { spacing: given.spacing, gravity: given.gravity.into(), bounds, settings })
}

/// Returns the host's packed array, with room for `needed` elements; `None` for NULL.
///
/// # Safety
/// The pointer is NULL or has room for `capacity` elements.
unsafe fn room<T: Plain>((name, pointer, capacity): (&str, *mut T, usize), needed: usize) -> Result<Option<Output<T>>> {
    // SAFETY: promised by the caller.
    let out = unsafe { Output::optional(name, pointer, capacity, 0) }?;
    out.map(|out| out.holds(name, needed)).transpose()
}

/// Writes values where the host wants them.
fn fill<T: Plain>(out: Option<Output<T>>, values: impl IntoIterator<Item = T>) {
    if let Some(out) = out {
        out.fill(values);
    }
}

entry! {
    fn rlv_diffuse_params(params: *mut *const RlvParameter, count: *mut usize) {
        static TABLE: OnceLock<Table> = OnceLock::new();
        // SAFETY: the caller gives pointers to which a value may be written, or NULL.
        unsafe { write_table(&TABLE, DiffuseSettings::PARAMETERS, params, count) }
    }

    fn rlv_diffuse_create(
        context: RlvContext,
        options: *const RlvDiffuseOptions,
        settings: *const RlvDiffuseSettings,
        out: *mut RlvDiffuse,
    ) {
        present("out", out)?;
        let context = registry::get(context)?;
        // SAFETY: the caller gives NULL or descriptors that start with their sizes.
        let options = unsafe { read_options(options, RlvDiffuseSettings::read(settings)?) }?;
        let run = RwLock::new(Diffuse::new(options)?);
        let made = registry::insert(DiffuseObject { context, run })?;
        // SAFETY: checked above.
        unsafe { put(out, made) };
        Ok(())
    }

    fn rlv_diffuse_retain(diffuse: RlvDiffuse) {
        registry::retain(diffuse)
    }

    fn rlv_diffuse_release(diffuse: RlvDiffuse) {
        registry::release(diffuse)
    }

    fn rlv_diffuse_info(diffuse: RlvDiffuse, out: *mut RlvDiffuseInfo) {
        let object = registry::get(diffuse)?;
        let run = try_read(&object.run, "diffuse")?;
        let (frames, births) = run.progress();
        let info = RlvDiffuseInfo { struct_size: 0, reserved: 0, count: run.particles().len(), frames, births };
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        unsafe { write_descriptor(out, info) }
    }

    fn rlv_diffuse_advance(
        diffuse: RlvDiffuse,
        fluid: *const RlvDiffuseFluid,
        seconds: f32,
        report: *mut RlvDiffuseReport,
        progress: RlvProgress,
        user: *mut c_void,
    ) {
        let object = registry::get(diffuse)?;
        let context = &object.context.context;
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        unsafe { check_optional(report) }?;
        // SAFETY: the caller's arrays are as the header demands.
        let fluid = unsafe { Fluid::read(fluid, context.memory_limit()) }?;
        let mut run = try_write(&object.run, "diffuse")?;
        let mut progress = HostProgress { callback: progress, user };
        let done = run.advance(context, fluid.frame(), seconds, &mut progress)?;
        let (born, gone, refused) = (done.born, done.gone, done.refused);
        // SAFETY: as above.
        unsafe { write_optional(report, RlvDiffuseReport { struct_size: 0, reserved: 0, born, gone, refused }) }
    }

    fn rlv_diffuse_potentials(
        diffuse: RlvDiffuse,
        fluid: *const RlvDiffuseFluid,
        potentials: *const RlvDiffusePotentials,
    ) {
        let object = registry::get(diffuse)?;
        let context = &object.context.context;
        // SAFETY: a descriptor of nothing but numbers and NULL pointers.
        let default: RlvDiffusePotentials = unsafe { std::mem::zeroed() };
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        let given = unsafe { read_descriptor(potentials, default) }?;
        // SAFETY: the caller's arrays are as the header demands.
        let fluid = unsafe { Fluid::read(fluid, context.memory_limit()) }?;
        let (count, capacity) = (fluid.positions.len(), given.capacity);
        // SAFETY: the caller promises room for `capacity` numbers of each.
        let [air, crests, energies] = unsafe {
            [
                room(("air", given.air, capacity), count)?,
                room(("crests", given.crests, capacity), count)?,
                room(("energies", given.energies, capacity), count)?,
            ]
        };
        let found = try_read(&object.run, "diffuse")?.potentials(context, fluid.frame())?;
        fill(air, found.iter().map(|found| found.air));
        fill(crests, found.iter().map(|found| found.crest));
        fill(energies, found.iter().map(|found| found.energy));
        Ok(())
    }

    fn rlv_diffuse_get(diffuse: RlvDiffuse, arrays: *const RlvDiffuseArrays) {
        let object = registry::get(diffuse)?;
        // SAFETY: a descriptor of nothing but numbers and NULL pointers.
        let default: RlvDiffuseArrays = unsafe { std::mem::zeroed() };
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        let given = unsafe { read_descriptor(arrays, default) }?;
        let run = try_read(&object.run, "diffuse")?;
        let particles = run.particles();
        let (count, capacity) = (particles.len(), given.capacity);
        let ids = match given.ids.is_null() {
            true => Vec::new(),
            false => particles.numbers()?,
        };
        // SAFETY: the caller promises room for `capacity` elements of each.
        unsafe {
            let positions = room(("positions", given.positions.cast::<[f32; 3]>(), capacity), count)?;
            let velocities = room(("velocities", given.velocities.cast::<[f32; 3]>(), capacity), count)?;
            let numbers = room(("ids", given.ids, capacity), count)?;
            let kinds = room(("kinds", given.kinds, capacity), count)?;
            let ages = room(("ages", given.ages, capacity), count)?;
            let lifetimes = room(("lifetimes", given.lifetimes, capacity), count)?;
            let lives = room(("lives", given.lives, capacity), count)?;
            fill(positions, particles.positions.iter().map(|position| position.to_array()));
            fill(velocities, particles.velocities.iter().map(|velocity| velocity.to_array()));
            fill(numbers, ids);
            fill(kinds, particles.kinds.iter().map(|kind| *kind as u32));
            fill(ages, particles.ages.iter().copied());
            fill(lifetimes, particles.lifetimes.iter().copied());
            fill(lives, (0..count).map(|at| particles.life(at)));
        }
        Ok(())
    }

    fn rlv_diffuse_particles(diffuse: RlvDiffuse, time: f64, out: *mut RlvParticles) {
        present("out", out)?;
        let object = registry::get(diffuse)?;
        let run = try_read(&object.run, "diffuse")?;
        let found = run.particles().to_file(time, run.options().spacing)?;
        found.check()?;
        let made = particles::register(object.context.clone(), found)?;
        // SAFETY: checked above.
        unsafe { put(out, made) };
        Ok(())
    }

    fn rlv_diffuse_save(diffuse: RlvDiffuse, path: *const c_char, time: f64) {
        let object = registry::get(diffuse)?;
        // SAFETY: the caller promises NULL or a NUL-terminated string.
        let path = unsafe { text("path", path) }?;
        let run = try_read(&object.run, "diffuse")?;
        let particles = run.particles().to_file(time, run.options().spacing)?;
        particles.check()?;
        write_frame(&object.context.context, Path::new(path), &particles, Some(&run.state(IDENTITY)))
    }

    fn rlv_diffuse_restore(diffuse: RlvDiffuse, path: *const c_char) {
        let object = registry::get(diffuse)?;
        // SAFETY: the caller promises NULL or a NUL-terminated string.
        let path = unsafe { text("path", path) }?;
        let context = &object.context.context;
        let mut run = try_write(&object.run, "diffuse")?;
        let options = *run.options();
        let restored = || {
            let frame = read_frame(context, &file::load(Path::new(path), context.memory_limit())?)?;
            if frame.particles.spacing != Some(options.spacing) {
                return Err(Error::invalid(format!("its fluid is not one of particles {} m apart", options.spacing))
                    .advise("make the run with the options of the one that was saved"));
            }
            let resumed = Diffuse::resume(options, &frame)?;
            resumed.map(|(_, run)| run).ok_or_else(|| {
                Error::invalid("the frame has no state of diffuse particles")
                    .advise("take what rlv_diffuse_save or `relievo foam generate` wrote")
            })
        };
        *run = restored().map_err(|error| error.at(path))?;
        Ok(())
    }
}
