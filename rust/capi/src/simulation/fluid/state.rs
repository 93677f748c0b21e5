//! What fluids go on from, as files and bytes, and their particles.

use std::ffi::c_char;
use std::path::Path;

use glam::Vec3;
use relievo_core::{Error, Result, file};
use relievo_fluid::{Batch, Checkpoint, ParticleChannel};
use relievo_particleio::{Particles, encode_frame, read_frame, write_frame};

use super::{FluidObject, RlvFluid, width};
use crate::border::array::{present, put, text};
use crate::border::registry::{self, try_read};
use crate::runtime::bytes::{self, RlvBytes};
use crate::simulation::particles::{self, RlvParticles};

impl FluidObject {
    /// The particles in the order of the solver, and what it needs beside them.
    fn save(&self) -> Result<(Particles, Vec<u8>)> {
        let state = try_read(&self.simulation, "fluid")?.fluid.state();
        let checkpoint = Checkpoint { state, ..Checkpoint::default() };
        Ok((checkpoint.state.particles(self.spacing), checkpoint.encode()))
    }

    /// Goes on from a frame with a state.
    fn restore(&self, bytes: &[u8]) -> Result<()> {
        let frame = read_frame(&self.context.context, bytes)?;
        let spacing = frame.particles.spacing.unwrap_or_default();
        let Some(Checkpoint { state, .. }) = Checkpoint::of(frame)? else {
            return Err(Error::invalid("the frame has no state of a solver")
                .advise("take what rlv_fluid_save wrote; rlv_particles_read reads particles alone"));
        };
        if spacing != self.spacing {
            return Err(Error::invalid(format!(
                "its particles are {spacing} m apart, and those of the fluid {}",
                self.spacing
            ))
            .advise("make the fluid with the options of the one that was saved"));
        }
        let carried = state.channels.iter().map(|channel| channel.width).sum();
        self.holds("state", state.numbers.len(), carried)?;
        self.change(|simulation| simulation.fluid.set_state(state))
    }
}

entry! {
    fn rlv_fluid_save(fluid: RlvFluid, path: *const c_char) {
        let object = registry::get(fluid)?;
        // SAFETY: the caller promises NULL or a NUL-terminated string.
        let path = unsafe { text("path", path) }?;
        let (particles, state) = object.save()?;
        write_frame(&object.context.context, Path::new(path), &particles, Some(&state))
    }

    fn rlv_fluid_restore(fluid: RlvFluid, path: *const c_char) {
        let object = registry::get(fluid)?;
        // SAFETY: the caller promises NULL or a NUL-terminated string.
        let path = unsafe { text("path", path) }?;
        let bytes = file::load(Path::new(path), object.context.context.memory_limit())?;
        object.restore(&bytes).map_err(|error| error.at(path))
    }

    fn rlv_fluid_save_bytes(fluid: RlvFluid, out: *mut RlvBytes) {
        present("out", out)?;
        let object = registry::get(fluid)?;
        let (particles, state) = object.save()?;
        let made = encode_frame(&object.context.context, &particles, Some(&state))?;
        // SAFETY: checked above.
        unsafe { bytes::give(made, out) }
    }

    fn rlv_fluid_restore_bytes(fluid: RlvFluid, bytes: *const u8, size: usize) {
        let object = registry::get(fluid)?;
        // SAFETY: the caller promises `size` bytes.
        let bytes = unsafe { bytes::take(bytes, size, object.context.context.memory_limit()) }?;
        object.restore(&bytes).map_err(|error| error.at("bytes"))
    }

    fn rlv_fluid_particles(fluid: RlvFluid, out: *mut RlvParticles) {
        present("out", out)?;
        let object = registry::get(fluid)?;
        let mut particles = try_read(&object.simulation, "fluid")?.fluid.state().particles(object.spacing);
        particles.sort();
        let made = particles::register(object.context.clone(), particles)?;
        // SAFETY: checked above.
        unsafe { put(out, made) };
        Ok(())
    }

    fn rlv_fluid_add_particles(fluid: RlvFluid, particles: RlvParticles) {
        let object = registry::get(fluid)?;
        let given = registry::get(particles)?.carried();
        let [places, mut velocities] = [given.points, given.velocities].map(|rows| rows.into_iter().map(Vec3::from).collect::<Vec<_>>());
        if velocities.is_empty() {
            velocities.push(Vec3::ZERO);
        }
        let channels: Vec<_> = given.channels.iter().map(ParticleChannel::view).collect();
        let more: usize = channels.iter().map(|channel| channel.width).sum();
        let batch = Batch { places: &places, velocities: &velocities, lifetime: f32::INFINITY, channels: &channels };
        object.change(|simulation| {
            let count = simulation.fluid.len() + places.len();
            object.holds("particles", count, width(&simulation.fluid) + more)?;
            simulation.fluid.add_batch(&batch)
        })
    }
}
