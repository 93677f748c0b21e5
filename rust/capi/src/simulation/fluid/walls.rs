//! What fluids do not pass: walls of particles and colliders, and the momentum that these were given.

use relievo_core::{Error, Result};
use relievo_fluid::{ColliderOptions, Contact, basin};

use super::arrays::{place, vectors};
use super::sources::placed;
use super::{RLV_FLUID_FRICTION, RLV_FLUID_SLIP, RLV_FLUID_STOP, RLV_FLUID_WALLS, RlvFluid, check_seconds};
use crate::border::array::{Output, present, put};
use crate::border::descriptor::read_optional;
use crate::border::registry::{self, try_read};
use crate::surfaces::mesh::RlvMesh;

descriptor! {
    pub struct RlvFluidColliderOptions {
        struct_size: u32,
        contact: u32,
        friction: f32,
        is_container: u32,
    }
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
    fn rlv_fluid_set_walls(fluid: RlvFluid, points: *const f32, count: usize, stride: usize) {
        let object = registry::get(fluid)?;
        let context = &object.context.context;
        object.holds("points", count, 0)?;
        // SAFETY: the caller promises `count` points.
        let places = unsafe { vectors("points", points, count, stride, context.memory_limit()) }?;
        object.change(|simulation| {
            simulation.fluid.set_walls(context, &places)?;
            simulation.walls = places.len();
            Ok(())
        })
    }

    fn rlv_fluid_set_basin(fluid: RlvFluid, low: *const f64, high: *const f64) {
        let object = registry::get(fluid)?;
        // SAFETY: the caller gives three doubles each, or NULL.
        let corners = unsafe { [place("low", low)?, place("high", high)?] };
        object.change(|simulation| {
            object.holds_basin(corners)?;
            let places = basin(corners[0], corners[1], object.spacing)?;
            simulation.fluid.set_walls(&object.context.context, &places)?;
            simulation.walls = places.len();
            Ok(())
        })
    }

    fn rlv_fluid_set_wall_points(
        fluid: RlvFluid,
        points: *const f32,
        count: usize,
        stride: usize,
        velocities: *const f32,
        velocity_stride: usize,
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
}
