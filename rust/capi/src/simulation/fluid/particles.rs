//! Particles that come and go one by one or as a fill, what hosts push them by, and what they have.

use std::collections::HashSet;

use glam::Vec3;
use relievo_core::Error;
use relievo_fluid::{Batch, ParticleChannel, Solid, block};

use super::arrays::{Places, RlvFluidArrays, place, vector, vectors};
use super::sources::placed;
use super::{RlvFluid, Simulation, width};
use crate::border::array::{Input, put_optional};
use crate::border::descriptor::read_descriptor;
use crate::border::registry::{self, try_read};
use crate::simulation::channel::channels;
use crate::surfaces::mesh::{RlvAttributeArrays, RlvMesh};

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
        channels: *const RlvAttributeArrays,
        channel_count: usize,
        channel_stride: usize,
    }
}

entry! {
    fn rlv_fluid_add(fluid: RlvFluid, particles: *const RlvFluidParticles) {
        let object = registry::get(fluid)?;
        // SAFETY: a descriptor of nothing but numbers and NULL pointers.
        let default: RlvFluidParticles = unsafe { std::mem::zeroed() };
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        let given = unsafe { read_descriptor(particles, default) }?;
        let limit = object.context.context.memory_limit();
        // SAFETY: the caller promises `count` elements of each that is not NULL, and channels of their counts.
        let (places, velocities, carried) = unsafe {
            let places = vectors("points", given.points, given.count, given.point_stride, limit)?;
            let velocities = if given.velocities.is_null() {
                vec![given.velocity.into()]
            } else {
                vectors("velocities", given.velocities, given.count, given.velocity_stride, limit)?
            };
            (places, velocities, channels(given.channels, given.channel_count, given.channel_stride, limit)?)
        };
        let carried: Vec<_> = carried.iter().map(ParticleChannel::view).collect();
        let more: usize = carried.iter().map(|channel| channel.width).sum();
        let lifetime = if given.lifetime == 0.0 { f32::INFINITY } else { given.lifetime };
        let batch = Batch { places: &places, velocities: &velocities, lifetime, channels: &carried };
        object.change(|simulation| {
            let count = simulation.fluid.len() + places.len();
            object.holds("particles", count, width(&simulation.fluid) + more)?;
            simulation.fluid.add_batch(&batch)
        })
    }

    fn rlv_fluid_add_box(fluid: RlvFluid, low: *const f64, high: *const f64, velocity: *const f32) {
        let object = registry::get(fluid)?;
        // SAFETY: the caller gives three numbers each, or NULL.
        let (corners, velocity) = unsafe {
            let velocity = if velocity.is_null() { Vec3::ZERO } else { vector("velocity", velocity)? };
            ([place("low", low)?, place("high", high)?], velocity)
        };
        object.change(|simulation| {
            object.holds_box(corners, &simulation.fluid)?;
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
            object.holds_box([low, high], &simulation.fluid)?;
            let places = solid.fill(context, object.spacing)?;
            let places = simulation.fluid.beside_walls(context, &places)?;
            simulation.fluid.add(&places, velocity)?;
            Ok(places.len())
        })?;
        // SAFETY: the caller promises a place, or NULL.
        unsafe { put_optional(added, count) };
        Ok(())
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
        // SAFETY: the caller promises a place, or NULL.
        unsafe { put_optional(removed, count) };
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
}
