//! Grids of points in files.

use std::ffi::{CString, c_char, c_int};
use std::path::Path;

use relievo_core::{Error, Result};

use crate::{Message, Packing, failure, name_of};

unsafe extern "C" {
    fn relievo_points_read(
        path: *const c_char,
        name: *const c_char,
        values: *mut f32,
        capacity: usize,
        count: *mut usize,
        message: *mut c_char,
        message_size: usize,
    ) -> c_int;
    fn relievo_points_write(
        path: *const c_char,
        points: *const f32,
        velocities: *const f32,
        count: usize,
        voxel: f64,
        is_fixed: c_int,
        packing: u32,
        message: *mut c_char,
        message_size: usize,
    ) -> c_int;
}

/// Points with velocities, of which OpenVDB makes a grid.
#[derive(Clone, Copy, Debug)]
pub struct Points<'a> {
    /// Where they are.
    pub places: &'a [[f32; 3]],
    /// One for each.
    pub velocities: &'a [[f32; 3]],
    /// Edge of a voxel.
    pub voxel: f64,
    /// Places have 16 bits.
    pub is_fixed: bool,
    /// How values are packed.
    pub packing: Packing,
}

/// The numbers of an attribute of the points of a file, in the order of the file: places, of `P`, in the world.
///
/// Fails if the file has not one grid of points, or OpenVDB throws.
pub fn read_points(path: &Path, attribute: &str) -> Result<Vec<f32>> {
    let (name, attribute) = (name_of(path)?, CString::new(attribute));
    let attribute = attribute.map_err(|_| Error::invalid("the name of the attribute has a zero in it"))?;
    let mut values = Vec::new();
    loop {
        let (mut message, mut count): (Message, usize) = ([0; 256], 0);
        // SAFETY: the names end with a zero and live through the call, at most as many numbers are written as there is room
        // for, and the message buffer is as large as said.
        let status = unsafe {
            relievo_points_read(
                name.as_ptr(),
                attribute.as_ptr(),
                values.as_mut_ptr(),
                values.len(),
                &mut count,
                message.as_mut_ptr().cast(),
                message.len(),
            )
        };
        match status {
            0 if count == values.len() => return Ok(values),
            0 => values.resize(count, 0.0),
            _ => return Err(failure(&message)),
        }
    }
}

/// Writes points as the only grid of a file: velocities `v` in 16 bits, and the radius `pscale` of 0.25.
///
/// Fails if there are not as many velocities as places, or OpenVDB throws.
pub fn write_points(path: &Path, points: &Points) -> Result<()> {
    let Points { places, velocities, voxel, is_fixed, packing } = *points;
    if places.len() != velocities.len() {
        return Err(Error::invalid("there are not as many velocities as places"));
    }
    let name = name_of(path)?;
    let mut message: Message = [0; 256];
    // SAFETY: the name ends with a zero, both arrays have three numbers of each point, all live through the call, and the
    // message buffer is as large as said.
    let status = unsafe {
        relievo_points_write(
            name.as_ptr(),
            places.as_ptr().cast(),
            velocities.as_ptr().cast(),
            places.len(),
            voxel,
            is_fixed.into(),
            packing.bits(),
            message.as_mut_ptr().cast(),
            message.len(),
        )
    };
    if status == 0 { Ok(()) } else { Err(failure(&message)) }
}
