//! What acts on fluids, and where their particles come from: forces, emitters and solids of hosts.

use glam::Vec3;
use relievo_core::{Error, Mesh, Result};
use relievo_fluid::{Emitter, Force, Overflow, Sink, Solid};

use super::arrays::place;
use super::{
    RLV_FLUID_ATTRACTOR, RLV_FLUID_DISC, RLV_FLUID_DRAG, RLV_FLUID_GRAVITY, RLV_FLUID_RECTANGLE, RLV_FLUID_SURFACE,
    RLV_FLUID_TURBULENCE, RLV_FLUID_VORTEX, RLV_FLUID_WIND, RlvFluid,
};
use crate::border::array::{Input, Plain, narrow};
use crate::border::descriptor::read_descriptor;
use crate::border::registry::{self, try_read};
use crate::details::detail::transform;
use crate::simulation::channel::channels;
use crate::surfaces::mesh::{RlvAttributeArrays, RlvMesh};

descriptor! {
    pub struct RlvFluidForce {
        kind: u32,
        seed: u32,
        vector: [f32; 3],
        strength: f32,
        place: [f64; 3],
        radius: f32,
        rate: f32,
    }
}

descriptor! {
    pub struct RlvFluidEmitterOptions {
        struct_size: u32,
        shape: u32,
        center: [f64; 3],
        u: [f32; 3],
        v: [f32; 3],
        radius: f32,
        speed: f32,
        lifetime: f32,
        reserved: u32,
        begin: f64,
        end: f64,
        channels: *const RlvAttributeArrays,
        channel_count: usize,
        channel_stride: usize,
    }
}

impl Default for RlvFluidForce {
    fn default() -> Self {
        Self { kind: 0, seed: 0, vector: [0.0; 3], strength: 0.0, place: [0.0; 3], radius: 0.0, rate: 0.0 }
    }
}

// SAFETY: eight numbers of four bytes and three of eight, without padding.
unsafe impl Plain for RlvFluidForce {}

/// The force that is asked for.
fn force(given: &RlvFluidForce) -> Result<Force> {
    let RlvFluidForce { kind, seed, strength, radius, rate, .. } = *given;
    let (vector, place) = (Vec3::from(given.vector), Vec3::from(narrow(given.place)));
    Ok(match kind {
        RLV_FLUID_GRAVITY => Force::Gravity(vector),
        RLV_FLUID_WIND => Force::Wind { velocity: vector, share: strength },
        RLV_FLUID_DRAG => Force::Drag { share: strength, square: rate },
        RLV_FLUID_VORTEX => Force::Vortex { place, axis: vector, strength, radius },
        RLV_FLUID_ATTRACTOR => Force::Attractor { place, strength, radius },
        RLV_FLUID_TURBULENCE => Force::Turbulence { strength, scale: radius, rate, seed },
        other => return Err(Error::invalid(format!("there is no force {other}")).advise("use 0 to 5")),
    })
}

/// The points of a mesh in the fluid, and its triangles.
///
/// # Errors
/// Fails only as [`transform`] does.
///
/// # Safety
/// `matrix` is NULL or twelve doubles.
pub unsafe fn placed(mesh: &Mesh, matrix: *const f64) -> Result<(Vec<Vec3>, Vec<[u32; 3]>)> {
    // SAFETY: promised by the caller.
    let matrix = unsafe { transform(matrix) }?;
    let place = |point: &[f32; 3]| matrix.transform_point3(Vec3::from(*point).as_dvec3()).as_vec3();
    Ok((mesh.points.iter().map(place).collect(), mesh.triangles()))
}

/// The emitter that is asked for.
///
/// # Safety
/// `matrix` is NULL or twelve doubles, and channels are as `fluid.h` demands.
unsafe fn emitter(
    given: &RlvFluidEmitterOptions,
    mesh: RlvMesh,
    matrix: *const f64,
    (spacing, limit): (f32, u64),
) -> Result<Emitter> {
    let [center, u, v] = [narrow(given.center), given.u, given.v].map(Vec3::from);
    let mut made = match given.shape {
        RLV_FLUID_DISC => Emitter::disc(center, u, given.radius, given.speed, spacing)?,
        RLV_FLUID_RECTANGLE => Emitter::rectangle(center, [u, v], given.speed, spacing)?,
        RLV_FLUID_SURFACE => {
            let object = registry::get(mesh)?;
            // SAFETY: promised by the caller.
            let (points, triangles) = unsafe { placed(&*try_read(&object.mesh, "mesh")?, matrix) }?;
            Emitter::mesh(&points, &triangles, given.speed, spacing)?
        }
        other => return Err(Error::invalid(format!("there is no shape {other}")).at("shape").advise("use 0 to 2")),
    };
    let lifetime = if given.lifetime == 0.0 { f32::INFINITY } else { given.lifetime };
    let end = if given.end == 0.0 { f64::INFINITY } else { given.end };
    if !(lifetime > 0.0 && given.begin.is_finite() && end > given.begin) {
        return Err(Error::invalid("its particles do not live, or it ends before it begins")
            .at("emitter")
            .advise("use positive seconds, or 0 for no end"));
    }
    (made.time, made.lifetime) = ([given.begin, end], lifetime);
    // SAFETY: promised by the caller.
    for carried in unsafe { channels(given.channels, given.channel_count, given.channel_stride, limit) }? {
        if carried.values.len() != carried.width || !carried.values.iter().all(|value| value.is_finite()) {
            return Err(Error::invalid("it has not one finite value")
                .at(format!("channel `{}`", carried.name))
                .advise("give the value that all particles of the emitter have"));
        }
        made.channels.push((carried.name, carried.values));
    }
    Ok(made)
}

entry! {
    fn rlv_fluid_add_emitter(
        fluid: RlvFluid,
        mesh: RlvMesh,
        matrix: *const f64,
        options: *const RlvFluidEmitterOptions,
    ) {
        let object = registry::get(fluid)?;
        // SAFETY: a descriptor of nothing but numbers and NULL pointers.
        let default: RlvFluidEmitterOptions = unsafe { std::mem::zeroed() };
        let limit = object.context.context.memory_limit();
        // SAFETY: the caller gives NULL or a descriptor that starts with its size, with channels of their counts, and NULL
        // or twelve doubles.
        let made = unsafe {
            let given = read_descriptor(options, default)?;
            emitter(&given, mesh, matrix, (object.spacing, limit))?
        };
        object.change(|simulation| {
            simulation.sources.emitters.push(made);
            Ok(())
        })
    }

    fn rlv_fluid_add_sink(fluid: RlvFluid, low: *const f64, high: *const f64, is_outside: u32) {
        let object = registry::get(fluid)?;
        // SAFETY: the caller gives three doubles each, or NULL.
        let corners = unsafe { [place("low", low)?, place("high", high)?] };
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
}
