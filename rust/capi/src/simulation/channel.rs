//! Values of particles, from and to C.

use relievo_core::error::nearest;
use relievo_core::{Attribute, Domain, Error, ErrorKind, Result, Values};
use relievo_fluid::ParticleChannel;

use crate::border::array::{Rows, descriptors, fixed};
use crate::border::descriptor::read_descriptor;
use crate::surfaces::mesh::{RLV_DOMAIN_POINT, RLV_TYPE_F32, RlvAttributeArrays, RlvAttributeInfo, copy_attribute};

/// Copies values of particles.
///
/// # Errors
/// Fails with `Invalid` if an array cannot be used, or a channel is not one of floats on points without indices, and
/// with `Memory` if one takes more than `limit` bytes.
///
/// # Safety
/// The arrays are as the headers demand.
pub unsafe fn channels(
    first: *const RlvAttributeArrays,
    count: usize,
    stride: usize,
    limit: u64,
) -> Result<Vec<ParticleChannel>> {
    // SAFETY: promised by the caller.
    let list = unsafe { descriptors("channels", first, count, stride) }?;
    let copy = |(at, pointer)| {
        // SAFETY: a descriptor of nothing but numbers and NULL pointers.
        let default: RlvAttributeArrays = unsafe { std::mem::zeroed() };
        // SAFETY: the caller promises descriptors that start with their size, with arrays of their counts.
        let given = unsafe { read_descriptor(pointer, default).and_then(|arrays| copy_attribute(&arrays, limit)) };
        let Attribute { name, domain, width, values, indices } =
            given.map_err(|error| error.at(format!("channel {at}")))?;
        match (domain, values, indices) {
            (Domain::Point, Values::F32(values), None) => Ok(ParticleChannel { name, width: width as usize, values }),
            _ => Err(Error::invalid("it is no attribute of floats on points without indices")
                .at(format!("channel `{name}`"))
                .advise("use RLV_DOMAIN_POINT, RLV_TYPE_F32 and no indices")),
        }
    };
    list.enumerate().map(copy).collect()
}

/// The index of a name among others.
///
/// # Errors
/// Fails with `NotFound`, and the nearest name, if it is none of them.
pub fn find<'a>(mut names: impl Iterator<Item = &'a str> + Clone, name: &str) -> Result<u32> {
    let there = names.clone();
    names.position(|other| other == name).map(|at| at as u32).ok_or_else(|| {
        let error = Error::new(ErrorKind::NotFound, format!("particles have no channel `{name}`"));
        match nearest(name, there) {
            Some(near) => error.advise(format!("did you mean `{near}`?")),
            None => error,
        }
    })
}

/// What a channel is.
pub fn info(name: &str, width: u32, count: usize) -> RlvAttributeInfo {
    RlvAttributeInfo {
        struct_size: 0,
        domain: RLV_DOMAIN_POINT,
        type_: RLV_TYPE_F32,
        width,
        value_count: count,
        index_count: 0,
        name: fixed(name),
    }
}

/// Writes rows of a width to a host's array: its first number, the rows it has room for and its stride.
///
/// # Errors
/// Fails with `Invalid` if the pointer is NULL, the stride is less than a row, or there is too little room.
///
/// # Safety
/// If the pointer is not NULL, the rows can be written at the stride from one another.
pub unsafe fn write(values: &[f32], width: usize, (first, capacity, stride): (*mut f32, usize, usize)) -> Result<()> {
    // SAFETY: promised by the caller.
    let room = unsafe { Rows::optional(("values", first.cast(), capacity, stride), width) }?;
    let Some(room) = room else { return Err(Error::invalid("the pointer is NULL").at("values")) };
    room.holds("values", values.len() / width)?;
    for (at, row) in values.chunks(width).enumerate() {
        room.set(at, row.iter().map(|value| value.to_bits()));
    }
    Ok(())
}
