//! Surfaces of fluids of particles; see `include/relievo/isosurface.h`.

use std::cell::RefCell;
use std::ffi::c_void;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;

use glam::Vec3;
use relievo_core::{Error, Progress, Result};
use relievo_embree::Ray as CastRay;
use relievo_fluid::{
    Channel, March, Motion, ParticleChannel, Ray, RayCaster, Smoothing, Surface, SurfaceFunction, Trail, Visibility,
    classify, smooth,
};

use crate::border::array::{Input, Output, Plain, present, put};
use crate::border::descriptor::{check_optional, read_descriptor, read_optional, write_descriptor, write_optional};
use crate::border::registry::{self, handle};
use crate::runtime::context::{ContextObject, HostProgress, RlvContext, RlvProgress};
use crate::simulation::channel::channels;
use crate::surfaces::caster::rays::{self, Rays, RlvRayArrays};
use crate::surfaces::mesh::{self, RlvAttributeArrays, RlvMesh, finite};

handle!(RlvIsosurface, 21, IsosurfaceObject);

constants! {
    u32:
    RLV_ISOSURFACE_BLOBS = 0,
    RLV_ISOSURFACE_ZHU_BRIDSON = 1,
    RLV_ISOSURFACE_DENSITY = 2,
    RLV_ISOSURFACE_ANISOTROPIC = 3,
    RLV_ISOSURFACE_SURFACE = 0,
    RLV_ISOSURFACE_BLIND = 1,
    RLV_ISOSURFACE_HIDDEN = 2,
}

descriptor! {
    pub struct RlvIsosurfaceOptions {
        struct_size: u32,
        function: u32,
        radius: f32,
        support: f32,
        sharpness: f32,
        iso: f32,
        centring: f32,
        shutter_open: f32,
        shutter_close: f32,
        march_steps: f32,
    }
}

descriptor! {
    pub struct RlvIsosurfaceParticles {
        struct_size: u32,
        reserved: u32,
        count: usize,
        points: *const f32,
        point_stride: usize,
        velocities: *const f32,
        velocity_stride: usize,
        blind: *const u8,
        blind_stride: usize,
    }
}

descriptor! {
    pub struct RlvIsosurfaceInfo {
        struct_size: u32,
        has_velocities: u32,
        particle_count: usize,
        support: f32,
        reach: f32,
        influence: f32,
        reserved: f32,
    }
}

descriptor! {
    pub struct RlvIsosurfaceMeshOptions {
        struct_size: u32,
        iterations: u32,
        cell: f32,
        forwards: f32,
        backwards: f32,
        reserved: u32,
        channels: *const RlvAttributeArrays,
        channel_count: usize,
        channel_stride: usize,
    }
}

descriptor! {
    pub struct RlvIsosurfaceClasses {
        struct_size: u32,
        reserved: u32,
        surface_count: usize,
        blind_count: usize,
        hidden_count: usize,
        kept: f64,
    }
}

descriptor! {
    pub struct RlvIsosurfaceRay {
        origin: [f32; 3],
        direction: [f32; 3],
        min_distance: f32,
        max_distance: f32,
        time: f32,
    }
}

descriptor! {
    pub struct RlvIsosurfaceHit {
        distance: f32,
        position: [f32; 3],
        normal: [f32; 3],
        velocity: [f32; 3],
        enters: u32,
    }
}

pub type RlvIsosurfaceIntersect =
    Option<unsafe extern "C" fn(*const c_void, *const RlvIsosurfaceRay, *mut RlvIsosurfaceHit) -> u32>;

descriptor! {
    pub struct RlvIsosurfaceTable {
        struct_size: u32,
        reserved: u32,
        data: *const c_void,
        intersect: RlvIsosurfaceIntersect,
        low: [f32; 3],
        high: [f32; 3],
    }
}

impl Default for RlvIsosurfaceHit {
    fn default() -> Self {
        Self { distance: f32::INFINITY, position: [0.0; 3], normal: [0.0; 3], velocity: [0.0; 3], enters: 0 }
    }
}

// SAFETY: eleven numbers of four bytes, without padding.
unsafe impl Plain for RlvIsosurfaceHit {}

/// Bytes that a particle takes at most, beside what was there of it before.
const PARTICLE: u64 = 80;

/// A surface of particles. It never changes, so any number of threads may look at it.
pub struct IsosurfaceObject {
    context: Arc<ContextObject>,
    surface: Arc<Surface>,
    caster: RayCaster,
    points: Vec<[f32; 3]>,
    /// None where nothing moves.
    velocities: Vec<[f32; 3]>,
    /// What vertices get the mean of beside velocities.
    channels: Vec<ParticleChannel>,
    /// Of a particle.
    radius: f32,
}

/// Particles in the order of the host, and what they carry; velocities and channels may be none.
pub struct Carried {
    pub points: Vec<[f32; 3]>,
    pub velocities: Vec<[f32; 3]>,
    pub channels: Vec<ParticleChannel>,
}

impl IsosurfaceObject {
    /// Of particles; flags of blind ones may be none. `radius` is that of a particle where no
    /// options are given.
    ///
    /// # Errors
    /// Fails with `Invalid` if an option or a particle cannot be used, and with `Memory` if the surface takes more than
    /// the context's memory limit.
    ///
    /// # Safety
    /// `options` is NULL or a descriptor that starts with its size.
    pub unsafe fn new(
        context: Arc<ContextObject>,
        Carried { points, velocities, channels }: Carried,
        blind: &[bool],
        options: *const RlvIsosurfaceOptions,
        radius: f32,
    ) -> Result<Self> {
        let default = RlvIsosurfaceOptions {
            struct_size: 0,
            function: RLV_ISOSURFACE_ZHU_BRIDSON,
            radius,
            support: 0.0,
            sharpness: 8.0,
            iso: 0.6,
            centring: 0.9,
            shutter_open: 0.0,
            shutter_close: 0.0,
            march_steps: 12.0,
        };
        // SAFETY: promised by the caller.
        let given = unsafe { read_optional(options, default) }?;
        let executor = &context.context;
        let bytes = (points.len() as u64).saturating_mul(PARTICLE);
        if bytes > executor.memory_limit() {
            return Err(Error::memory(format!("the surface takes {bytes} bytes, more than the memory limit"))
                .at("particles")
                .advise("raise the memory limit of the context or pass less"));
        }
        let surface = Arc::new(Surface::new(executor, &points, function(&given)?)?);
        let motion = Motion { velocities: &velocities, shutter: [given.shutter_open, given.shutter_close] };
        let march = March { steps: given.march_steps };
        let caster = RayCaster::new(executor, &surface, motion, blind, march)?;
        Ok(Self { context, surface, caster, points, velocities, channels, radius: given.radius })
    }
}

/// The function that is asked for.
fn function(given: &RlvIsosurfaceOptions) -> Result<SurfaceFunction> {
    let RlvIsosurfaceOptions { radius, sharpness, iso, centring, .. } = *given;
    if !(radius > 0.0 && radius.is_finite()) {
        return Err(Error::invalid(format!("{radius} is no radius")).at("radius").advise("use a positive length"));
    }
    let support = if given.support == 0.0 { 4.0 * radius } else { given.support };
    Ok(match given.function {
        RLV_ISOSURFACE_BLOBS => SurfaceFunction::Blobs { support, radius, sharpness },
        RLV_ISOSURFACE_ZHU_BRIDSON => SurfaceFunction::ZhuBridson { support, radius },
        RLV_ISOSURFACE_DENSITY => SurfaceFunction::Density { support, iso },
        RLV_ISOSURFACE_ANISOTROPIC => SurfaceFunction::Anisotropic { support, iso, centring },
        other => {
            return Err(Error::invalid(format!("{other} is no function"))
                .at("function")
                .advise("use an RLV_ISOSURFACE_ value from BLOBS to ANISOTROPIC"));
        }
    })
}

/// Registers a surface of particles in the order of the host, none of which is blind; `radius` is that of a particle where
/// no options are given.
///
/// # Errors
/// Fails with `Invalid` if an option or a particle cannot be used, and with `Memory` if the surface takes more than the
/// context's memory limit.
///
/// # Safety
/// `options` is NULL or a descriptor that starts with its size.
pub unsafe fn register(
    context: Arc<ContextObject>,
    particles: Carried,
    options: *const RlvIsosurfaceOptions,
    radius: f32,
) -> Result<RlvIsosurface> {
    // SAFETY: promised by the caller.
    registry::insert(unsafe { IsosurfaceObject::new(context, particles, &[], options, radius) }?)
}

/// A mesh that is to be made of a surface.
pub struct Meshing {
    object: Arc<IsosurfaceObject>,
    cell: f32,
    smoothing: Smoothing,
    channels: Vec<ParticleChannel>,
}

impl Meshing {
    /// Copies what was asked for.
    ///
    /// # Errors
    /// Fails with `Invalid` if the handle is not alive, or an option or a channel cannot be used, and with `Memory` if
    /// a channel exceeds the context's memory limit.
    ///
    /// # Safety
    /// `options` is NULL or a descriptor whose arrays are as the header demands.
    pub unsafe fn read(isosurface: RlvIsosurface, options: *const RlvIsosurfaceMeshOptions) -> Result<Self> {
        let object = registry::get(isosurface)?;
        let Smoothing { forwards, backwards, .. } = Smoothing::default();
        let default = RlvIsosurfaceMeshOptions {
            struct_size: 0,
            iterations: 0,
            cell: 0.0,
            forwards,
            backwards,
            reserved: 0,
            channels: std::ptr::null(),
            channel_count: 0,
            channel_stride: 0,
        };
        // SAFETY: promised by the caller.
        let given = unsafe { read_optional(options, default) }?;
        let limit = object.context.context.memory_limit();
        // SAFETY: promised by the caller.
        let channels = unsafe { channels(given.channels, given.channel_count, given.channel_stride, limit) }?;
        let cell = if given.cell == 0.0 { object.radius } else { given.cell };
        let smoothing =
            Smoothing { iterations: given.iterations, forwards: given.forwards, backwards: given.backwards };
        Ok(Self { object, cell, smoothing, channels })
    }

    pub fn context(&self) -> &Arc<ContextObject> {
        &self.object.context
    }

    /// Makes it.
    ///
    /// # Errors
    /// Fails with `Invalid` if two channels share a name, or the cell or the smoothing cannot be used, with `Memory` if
    /// the mesh exceeds the memory limit or the host refuses its bytes, and with `Cancelled` if `progress` asks to
    /// stop.
    pub fn run(&self, progress: &mut dyn Progress) -> Result<RlvMesh> {
        let context = &self.object.context.context;
        let velocities = self.object.velocities.as_flattened();
        let velocity = Channel { name: "velocity", width: 3, values: velocities };
        let mut channels: Vec<Channel> = (!velocities.is_empty()).then_some(velocity).into_iter().collect();
        for channel in self.object.channels.iter().chain(&self.channels) {
            if channels.iter().any(|other| other.name == channel.name) {
                return Err(Error::invalid("there are two of this name").at(format!("channel `{}`", channel.name)));
            }
            channels.push(channel.view());
        }
        let mut made = relievo_fluid::mesh(context, &self.object.surface, self.cell, &channels, progress)?;
        if self.smoothing.iterations > 0 {
            smooth(context, &mut made, self.smoothing, progress)?;
        }
        mesh::register(self.object.context.clone(), made)
    }
}

thread_local! {
    /// What rays of this thread met.
    static TRAIL: RefCell<Trail> = RefCell::default();
}

/// The first hit of a ray that can be cast, at a time in seconds.
fn hit(caster: &RayCaster, trail: &mut Trail, ray: &CastRay, time: f32) -> Option<RlvIsosurfaceHit> {
    let CastRay { origin, direction, near, far } = *ray;
    if !time.is_finite() {
        return None;
    }
    let length = Vec3::from(direction).length();
    let (near, far) = (near * length, far * length);
    let found = caster.tracer(trail).intersect(&Ray { origin, direction, near, far, time })?;
    Some(RlvIsosurfaceHit {
        distance: found.distance / length,
        position: found.point,
        normal: found.normal,
        velocity: found.velocity,
        enters: u32::from(found.enters),
    })
}

/// # Safety
/// As `isosurface.h` demands: `data` is that of a table whose isosurface lives, `ray` and `out` are NULL or places for one.
unsafe extern "C" fn intersect(data: *const c_void, ray: *const RlvIsosurfaceRay, out: *mut RlvIsosurfaceHit) -> u32 {
    if data.is_null() || ray.is_null() || out.is_null() {
        return 0;
    }
    // A fault inside meets nothing.
    let found = catch_unwind(AssertUnwindSafe(|| {
        // SAFETY: promised by the caller.
        let (caster, ray) = unsafe { (&*data.cast::<RayCaster>(), ray.read_unaligned()) };
        let RlvIsosurfaceRay { origin, direction, min_distance, max_distance, time } = ray;
        let ray = CastRay { origin, direction, near: min_distance, far: rays::unlimited(max_distance) };
        let trace = |trail: &RefCell<Trail>| hit(caster, &mut trail.borrow_mut(), &ray, time);
        rays::can_cast(&ray).then(|| TRAIL.try_with(trace).ok().flatten()).flatten()
    }));
    let found = found.ok().flatten();
    // SAFETY: it is not NULL, and the caller promises a place.
    unsafe { put(out, found.unwrap_or_default()) };
    u32::from(found.is_some())
}

/// Rays of one item of parallel work.
const CHUNK: usize = 256;
/// Items of work between two writes to the caller's array, which bounds the memory of a call.
const BATCH: usize = 256;

/// Rays of one batch, and what they hit.
#[derive(Default)]
struct Batch {
    /// Rays and their times; None for one that hits nothing whatever there is.
    rays: Vec<Option<(CastRay, f32)>>,
    hits: Vec<RlvIsosurfaceHit>,
}

entry! {
    fn rlv_isosurface_create(
        context: RlvContext,
        particles: *const RlvIsosurfaceParticles,
        options: *const RlvIsosurfaceOptions,
        out: *mut RlvIsosurface,
    ) {
        present("out", out)?;
        let context = registry::get(context)?;
        // SAFETY: a descriptor of nothing but numbers and NULL pointers.
        let default: RlvIsosurfaceParticles = unsafe { std::mem::zeroed() };
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        let given = unsafe { read_descriptor(particles, default) }?;
        let count = given.count;
        // SAFETY: the caller promises `count` elements of each that is not NULL.
        let (points, velocities, blind) = unsafe {
            (
                Input::new("points", given.points.cast::<[f32; 3]>(), count, given.point_stride)?,
                Input::optional("velocities", given.velocities.cast::<[f32; 3]>(), count, given.velocity_stride)?,
                Input::optional("blind", given.blind, count, given.blind_stride)?,
            )
        };
        let limit = context.context.memory_limit();
        let points = points.to_vec("points", limit)?;
        finite("points", &points)?;
        let velocities = velocities.map_or(Ok(Vec::new()), |velocities| velocities.to_vec("velocities", limit))?;
        finite("velocities", &velocities)?;
        let blind = blind.map_or(Ok(Vec::new()), |blind| blind.to_vec("blind", limit))?;
        if let Some(at) = blind.iter().position(|blind| *blind > 1) {
            return Err(Error::invalid(format!("{} is not 0 or 1", blind[at])).at(format!("blind, element {at}")));
        }
        let blind: Vec<bool> = blind.into_iter().map(|blind| blind == 1).collect();
        let particles = Carried { points, velocities, channels: Vec::new() };
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        let made = unsafe { IsosurfaceObject::new(context, particles, &blind, options, 0.01) }?;
        let made = registry::insert(made)?;
        // SAFETY: checked above.
        unsafe { put(out, made) };
        Ok(())
    }

    fn rlv_isosurface_retain(isosurface: RlvIsosurface) {
        registry::retain(isosurface)
    }

    fn rlv_isosurface_release(isosurface: RlvIsosurface) {
        registry::release(isosurface)
    }

    fn rlv_isosurface_info(isosurface: RlvIsosurface, out: *mut RlvIsosurfaceInfo) {
        let object = registry::get(isosurface)?;
        let info = RlvIsosurfaceInfo {
            struct_size: 0,
            has_velocities: u32::from(!object.velocities.is_empty()),
            particle_count: object.surface.len(),
            support: object.surface.function().support(),
            reach: object.surface.reach(),
            influence: object.surface.influence(),
            reserved: 0.0,
        };
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        unsafe { write_descriptor(out, info) }
    }

    fn rlv_isosurface_mesh(
        isosurface: RlvIsosurface,
        options: *const RlvIsosurfaceMeshOptions,
        progress: RlvProgress,
        user: *mut c_void,
        out: *mut RlvMesh,
    ) {
        present("out", out)?;
        // SAFETY: the caller gives NULL or a descriptor that starts with its size, with channels of their counts.
        let meshing = unsafe { Meshing::read(isosurface, options) }?;
        let made = meshing.run(&mut HostProgress { callback: progress, user })?;
        // SAFETY: checked above.
        unsafe { put(out, made) };
        Ok(())
    }

    fn rlv_isosurface_classify(
        isosurface: RlvIsosurface,
        threshold: f32,
        classes: *mut u8,
        capacity: usize,
        stride: usize,
        progress: RlvProgress,
        user: *mut c_void,
        out: *mut RlvIsosurfaceClasses,
    ) {
        let object = registry::get(isosurface)?;
        let count = object.points.len();
        // SAFETY: the caller promises room for `capacity`, and NULL or a descriptor that starts with its size.
        let room = unsafe {
            check_optional(out)?;
            Output::optional("classes", classes, capacity, stride)?
        };
        let room = room.map(|room| room.holds("classes", count)).transpose()?;
        let (threshold, context) = ((threshold.is_nan() || threshold >= 0.0).then_some(threshold), &object.context.context);
        let mut progress = HostProgress { callback: progress, user };
        let found = classify(context, &object.points, &object.surface, threshold, &mut progress)?;
        if let Some(room) = room {
            room.fill(found.of.iter().map(|class| match class {
                Visibility::Surface => RLV_ISOSURFACE_SURFACE as u8,
                Visibility::Blind => RLV_ISOSURFACE_BLIND as u8,
                Visibility::Hidden => RLV_ISOSURFACE_HIDDEN as u8,
            }));
        }
        let told = RlvIsosurfaceClasses {
            struct_size: 0,
            reserved: 0,
            surface_count: found.surface,
            blind_count: found.blind,
            hidden_count: count - found.surface - found.blind,
            kept: found.kept(),
        };
        // SAFETY: checked above.
        unsafe { write_optional(out, told) }
    }

    fn rlv_isosurface_cast(
        isosurface: RlvIsosurface,
        rays: *const RlvRayArrays,
        hits: *mut RlvIsosurfaceHit,
        hit_stride: usize,
    ) {
        let object = registry::get(isosurface)?;
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        let given = unsafe { RlvRayArrays::read(rays) }?;
        // SAFETY: the caller's arrays are as the header demands.
        let (rays, out) = unsafe { (Rays::new(&given)?, Output::new("hits", hits, given.count, hit_stride)?) };
        let count = given.count;
        let context = &object.context.context;
        let mut room = context.scratch().lend::<Batch>();
        let Batch { rays: batch, hits } = &mut *room;
        for first in (0..count).step_by(CHUNK * BATCH) {
            batch.clear();
            batch.extend((first..count.min(first + CHUNK * BATCH)).map(|at| rays.get(at, u32::MAX).map(|ray| (ray, rays.time(at)))));
            hits.clear();
            hits.resize(batch.len(), RlvIsosurfaceHit::default());
            context.for_each_part((batch.as_slice(), hits.as_mut_slice()), CHUNK, |_, (rays, hits)| {
                let mut trail = context.scratch().lend::<Trail>();
                for (out, ray) in hits.iter_mut().zip(rays) {
                    let found = ray.as_ref().and_then(|(ray, time)| hit(&object.caster, &mut trail, ray, *time));
                    *out = found.unwrap_or_default();
                }
                Ok(())
            })?;
            hits.iter().enumerate().for_each(|(at, hit)| out.set(first + at, *hit));
        }
        Ok(())
    }

    fn rlv_isosurface_table(isosurface: RlvIsosurface, out: *mut RlvIsosurfaceTable) {
        let object = registry::get(isosurface)?;
        let [low, high] = object.caster.bounds().unwrap_or([[f32::INFINITY; 3], [f32::NEG_INFINITY; 3]]);
        let table = RlvIsosurfaceTable {
            struct_size: 0,
            reserved: 0,
            data: (&raw const object.caster).cast(),
            intersect: Some(intersect),
            low,
            high,
        };
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        unsafe { write_descriptor(out, table) }
    }
}
