//! What particles carry beside what fluids need: colours and values of hosts.

use std::ffi::c_char;

use relievo_core::{Error, Result};
use relievo_fluid::{Fluid, ParticleChannel};

use super::{RlvFluid, width};
use crate::border::array::{present, put, text};
use crate::border::descriptor::write_descriptor;
use crate::border::registry::{self, try_read};
use crate::simulation::channel::{self, channels};
use crate::surfaces::mesh::{RlvAttributeArrays, RlvAttributeInfo};

fn there(fluid: &Fluid, index: u32) -> Result<&ParticleChannel> {
    let there = fluid.channels();
    there.get(index as usize).ok_or_else(|| {
        Error::invalid(format!("channel {index} does not exist"))
            .at("channel")
            .advise(format!("the fluid has {}", there.len()))
    })
}

entry! {
    fn rlv_fluid_set_channel(fluid: RlvFluid, channel: *const RlvAttributeArrays) {
        let object = registry::get(fluid)?;
        // SAFETY: the caller gives NULL or a descriptor that starts with its size, with arrays of their counts.
        let given = unsafe { channels(channel, 1, 0, object.context.context.memory_limit()) }?;
        object.change(|simulation| {
            for ParticleChannel { name, width: numbers, values } in given {
                let count = simulation.fluid.len();
                object.holds("channel", count, width(&simulation.fluid) + numbers)?;
                let mut sorted = values.clone();
                if values.len() == count * numbers {
                    for (at, row) in simulation.order().iter().zip(values.chunks(numbers)) {
                        sorted[*at as usize * numbers..][..numbers].copy_from_slice(row);
                    }
                }
                simulation.fluid.set_channel(&name, numbers, &sorted)?;
            }
            Ok(())
        })
    }

    fn rlv_fluid_find_channel(fluid: RlvFluid, name: *const c_char, out: *mut u32) {
        present("out", out)?;
        let object = registry::get(fluid)?;
        // SAFETY: the caller promises NULL or a NUL-terminated string.
        let name = unsafe { text("name", name) }?;
        let simulation = try_read(&object.simulation, "fluid")?;
        let found = channel::find(simulation.fluid.channels().iter().map(|channel| channel.name.as_str()), name)?;
        // SAFETY: checked above.
        unsafe { put(out, found) };
        Ok(())
    }

    fn rlv_fluid_channel_info(fluid: RlvFluid, index: u32, out: *mut RlvAttributeInfo) {
        let object = registry::get(fluid)?;
        let simulation = try_read(&object.simulation, "fluid")?;
        let ParticleChannel { name, width, .. } = there(&simulation.fluid, index)?;
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        unsafe { write_descriptor(out, channel::info(name, *width as u32, simulation.fluid.len())) }
    }

    fn rlv_fluid_get_channel(fluid: RlvFluid, index: u32, values: *mut f32, capacity: usize, stride: usize) {
        let object = registry::get(fluid)?;
        let simulation = try_read(&object.simulation, "fluid")?;
        let sorted = simulation.channel_by_number(there(&simulation.fluid, index)?);
        // SAFETY: the caller promises room for `capacity` values.
        unsafe { channel::write(&sorted.values, sorted.width, (values, capacity, stride)) }
    }
}
