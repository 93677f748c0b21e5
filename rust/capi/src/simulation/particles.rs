//! Particles at a time, and their files; see `include/relievo/particles.h`.

use std::ffi::c_char;
use std::path::PathBuf;
use std::sync::Arc;

use relievo_core::{Error, ErrorKind, Result};
use relievo_fluid::ParticleChannel;
use relievo_particleio::{Channel, Particles, VELOCITY, read, write};

use crate::border::array::{Input, Output, present, put, text};
use crate::border::descriptor::{read_descriptor, write_descriptor};
use crate::border::making::Making;
use crate::border::registry::{self, handle};
use crate::runtime::context::{ContextObject, RlvContext};
use crate::simulation::channel::{self, channels};
use crate::simulation::isosurface::{
    Carried, IsosurfaceObject, RLV_ISOSURFACE_BLIND, RLV_ISOSURFACE_HIDDEN, RlvIsosurface, RlvIsosurfaceOptions,
};
use crate::surfaces::mesh::{RlvAttributeArrays, RlvAttributeInfo};

handle!(RlvParticles, 23, ParticlesObject);

/// The channel that tells blind particles, 1, from those at the surface, 0.
const BLIND: &str = "blind";

descriptor! {
    pub struct RlvParticlesArrays {
        struct_size: u32,
        has_time: u32,
        time: f64,
        spacing: f32,
        reserved: u32,
        count: usize,
        points: *const f32,
        point_stride: usize,
        numbers: *const u32,
        number_stride: usize,
        channels: *const RlvAttributeArrays,
        channel_count: usize,
        channel_stride: usize,
    }
}

descriptor! {
    pub struct RlvParticlesInfo {
        struct_size: u32,
        channel_count: u32,
        count: usize,
        has_numbers: u32,
        has_time: u32,
        time: f64,
        spacing: f32,
        reserved: u32,
    }
}

/// Particles and the context they belong to. They never change.
pub struct ParticlesObject {
    context: Arc<ContextObject>,
    particles: Particles,
}

/// Registers particles that are sound.
///
/// # Errors
/// Fails with `Memory` if there are too many objects.
pub fn register(context: Arc<ContextObject>, particles: Particles) -> Result<RlvParticles> {
    registry::insert(ParticlesObject { context, particles })
}

impl ParticlesObject {
    pub fn context(&self) -> &Arc<ContextObject> {
        &self.context
    }

    pub fn particles(&self) -> &Particles {
        &self.particles
    }

    /// Particles that may be added to a fluid: places, velocities and what they carry beside those.
    pub fn carried(&self) -> Carried {
        let Particles { points, channels, .. } = &self.particles;
        let channels = channels.iter().filter(|channel| !is_known(channel));
        let owned = |Channel { name, width, values }: &Channel| ParticleChannel {
            name: name.clone(),
            width: *width as usize,
            values: values.clone(),
        };
        Carried {
            points: points.clone(),
            velocities: self.particles.velocities().unwrap_or_default().to_vec(),
            channels: channels.map(owned).collect(),
        }
    }

    /// Which of them are blind; none if they do not say.
    fn blind(&self) -> Vec<bool> {
        let flags = self.particles.channel(BLIND).filter(|channel| channel.width == 1);
        flags.map_or(Vec::new(), |channel| channel.values.iter().map(|value| *value > 0.5).collect())
    }

    fn channel(&self, index: u32) -> Result<&Channel> {
        let there = &self.particles.channels;
        there.get(index as usize).ok_or_else(|| {
            Error::invalid(format!("channel {index} does not exist"))
                .at("channel")
                .advise(format!("there are {}", there.len()))
        })
    }
}

/// Whether a channel has another place where particles are not in files. Normals are those of a surface.
fn is_known(channel: &Channel) -> bool {
    matches!(channel.name.as_str(), VELOCITY | BLIND | "normal")
}

/// Reads what particles are read from.
///
/// # Errors
/// Fails with `Invalid` if the handle is not alive or the path is no text. What the work refuses, it returns: a file
/// that cannot be read or is damaged, or `Cancelled`.
///
/// # Safety
/// `path` is NULL or a NUL-terminated text.
pub unsafe fn reading(context: RlvContext, path: *const c_char) -> Result<Making<RlvParticles>> {
    let context = registry::get(context)?;
    // SAFETY: promised by the caller.
    let path = PathBuf::from(unsafe { text("path", path) }?);
    Ok(Making::new(context.clone(), move |progress| {
        progress.step(0.0, "read")?;
        let mut particles = read(&context.context, &path)?.particles;
        progress.step(0.8, "sort")?;
        particles.sort();
        progress.step(1.0, "sort")?;
        register(context, particles)
    }))
}

/// Reads where particles are written to.
///
/// # Errors
/// Fails with `Invalid` if the handle is not alive or the path is no text. What the work refuses, it returns: a file
/// that cannot be written, or `Cancelled`.
///
/// # Safety
/// As for [`reading`].
pub unsafe fn writing(particles: RlvParticles, path: *const c_char) -> Result<Making<()>> {
    let object = registry::get(particles)?;
    // SAFETY: promised by the caller.
    let path = PathBuf::from(unsafe { text("path", path) }?);
    Ok(Making::new(object.context.clone(), move |progress| {
        progress.step(0.0, "write")?;
        write(&object.context.context, &path, &object.particles)?;
        // The file is there: too late to stop.
        progress.report(1.0, "write");
        Ok(())
    }))
}

entry! {
    fn rlv_particles_create(context: RlvContext, arrays: *const RlvParticlesArrays, out: *mut RlvParticles) {
        present("out", out)?;
        let context = registry::get(context)?;
        let limit = context.context.memory_limit();
        // SAFETY: a descriptor of nothing but numbers and NULL pointers.
        let default: RlvParticlesArrays = unsafe { std::mem::zeroed() };
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        let given = unsafe { read_descriptor(arrays, default) }?;
        // SAFETY: the caller promises `count` elements of each that is not NULL, and channels of their counts.
        let (points, numbers, carried) = unsafe {
            (
                Input::new("points", given.points.cast::<[f32; 3]>(), given.count, given.point_stride)?,
                Input::optional("numbers", given.numbers, given.count, given.number_stride)?,
                channels(given.channels, given.channel_count, given.channel_stride, limit)?,
            )
        };
        let channel = |ParticleChannel { name, width, values }| Channel { name, width: width as u32, values };
        let time = match given.has_time {
            0 => None,
            1 => Some(given.time),
            other => return Err(Error::invalid(format!("has_time is {other}")).at("has_time").advise("use 0 or 1")),
        };
        let particles = Particles {
            points: points.to_vec("points", limit)?,
            time,
            spacing: (given.spacing != 0.0).then_some(given.spacing),
            numbers: numbers.map(|numbers| numbers.to_vec("numbers", limit)).transpose()?,
            channels: carried.into_iter().map(channel).collect(),
        };
        particles.check()?;
        let made = register(context, particles)?;
        // SAFETY: checked above.
        unsafe { put(out, made) };
        Ok(())
    }

    fn rlv_particles_read(context: RlvContext, path: *const c_char, out: *mut RlvParticles) {
        present("out", out)?;
        // SAFETY: the caller promises NULL or a NUL-terminated string.
        let made = unsafe { reading(context, path) }?.now()?;
        // SAFETY: checked above.
        unsafe { put(out, made) };
        Ok(())
    }

    fn rlv_particles_write(particles: RlvParticles, path: *const c_char) {
        // SAFETY: the caller promises NULL or a NUL-terminated string.
        unsafe { writing(particles, path) }?.now()
    }

    fn rlv_particles_retain(particles: RlvParticles) {
        registry::retain(particles)
    }

    fn rlv_particles_release(particles: RlvParticles) {
        registry::release(particles)
    }

    fn rlv_particles_info(particles: RlvParticles, out: *mut RlvParticlesInfo) {
        let object = registry::get(particles)?;
        let Particles { points, time, spacing, numbers, channels } = &object.particles;
        let info = RlvParticlesInfo {
            struct_size: 0,
            channel_count: channels.len() as u32,
            count: points.len(),
            has_numbers: u32::from(numbers.is_some()),
            has_time: u32::from(time.is_some()),
            time: time.unwrap_or_default(),
            spacing: spacing.unwrap_or_default(),
            reserved: 0,
        };
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        unsafe { write_descriptor(out, info) }
    }

    fn rlv_particles_get_points(particles: RlvParticles, points: *mut f32, capacity: usize, stride: usize) {
        let object = registry::get(particles)?;
        let there = &object.particles.points;
        // SAFETY: the caller promises room for `capacity` points.
        let out = unsafe { Output::new("points", points.cast::<[f32; 3]>(), capacity, stride) }?;
        out.holds("points", there.len())?.fill(there.iter().copied());
        Ok(())
    }

    fn rlv_particles_get_numbers(particles: RlvParticles, numbers: *mut u32, capacity: usize, stride: usize) {
        let object = registry::get(particles)?;
        let there = object.particles.numbers.as_ref();
        let there = there.ok_or_else(|| Error::new(ErrorKind::NotFound, "particles have no numbers"))?;
        // SAFETY: the caller promises room for `capacity` numbers.
        let out = unsafe { Output::new("numbers", numbers, capacity, stride) }?;
        out.holds("numbers", there.len())?.fill(there.iter().copied());
        Ok(())
    }

    fn rlv_particles_find_channel(particles: RlvParticles, name: *const c_char, out: *mut u32) {
        present("out", out)?;
        let object = registry::get(particles)?;
        // SAFETY: the caller promises NULL or a NUL-terminated string.
        let name = unsafe { text("name", name) }?;
        let found = channel::find(object.particles.channels.iter().map(|channel| channel.name.as_str()), name)?;
        // SAFETY: checked above.
        unsafe { put(out, found) };
        Ok(())
    }

    fn rlv_particles_channel_info(particles: RlvParticles, index: u32, out: *mut RlvAttributeInfo) {
        let object = registry::get(particles)?;
        let Channel { name, width, .. } = object.channel(index)?;
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        unsafe { write_descriptor(out, channel::info(name, *width, object.particles.points.len())) }
    }

    fn rlv_particles_get_channel(particles: RlvParticles, index: u32, values: *mut f32, capacity: usize, stride: usize) {
        let object = registry::get(particles)?;
        let Channel { width, values: there, .. } = object.channel(index)?;
        // SAFETY: the caller promises room for `capacity` values.
        unsafe { channel::write(there, *width as usize, (values, capacity, stride)) }
    }

    fn rlv_particles_keep(particles: RlvParticles, classes: *const u8, count: usize, stride: usize, out: *mut RlvParticles) {
        present("out", out)?;
        let object = registry::get(particles)?;
        // SAFETY: the caller promises `count` classes.
        let classes = unsafe { Input::new("classes", classes, count, stride) }?;
        let there = object.particles.points.len();
        if count != there {
            return Err(Error::invalid(format!("{count} classes are given for {there} particles")).at("classes"));
        }
        let classes = classes.to_vec("classes", object.context.context.memory_limit())?;
        if let Some(at) = classes.iter().position(|class| u32::from(*class) > RLV_ISOSURFACE_HIDDEN) {
            return Err(Error::invalid(format!("{} is no class", classes[at])).at(format!("classes, element {at}")));
        }
        let places: Vec<usize> = (0..count).filter(|at| u32::from(classes[*at]) != RLV_ISOSURFACE_HIDDEN).collect();
        let mut kept = object.particles.subset(&places);
        kept.channels.retain(|channel| channel.name != BLIND);
        let flag = |at: &usize| f32::from(u8::from(u32::from(classes[*at]) == RLV_ISOSURFACE_BLIND));
        kept.channels.push(Channel { name: BLIND.into(), width: 1, values: places.iter().map(flag).collect() });
        kept.check()?;
        let made = register(object.context.clone(), kept)?;
        // SAFETY: checked above.
        unsafe { put(out, made) };
        Ok(())
    }

    fn rlv_particles_isosurface(particles: RlvParticles, options: *const RlvIsosurfaceOptions, out: *mut RlvIsosurface) {
        present("out", out)?;
        let object = registry::get(particles)?;
        let radius = object.particles.spacing.map_or(0.01, |spacing| 0.5 * spacing);
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        let made = unsafe { IsosurfaceObject::new(object.context.clone(), object.carried(), &object.blind(), options, radius) }?;
        let made = registry::insert(made)?;
        // SAFETY: checked above.
        unsafe { put(out, made) };
        Ok(())
    }
}
