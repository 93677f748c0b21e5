//! What hosts give to fluids and get from them.

use glam::Vec3;
use relievo_core::{Error, Result};

use super::Simulation;
use crate::border::array::{Input, Output, narrow, reserve};

/// Three floats.
///
/// # Safety
/// `pointer` is NULL or to three floats.
pub unsafe fn vector(name: &str, pointer: *const f32) -> Result<Vec3> {
    // SAFETY: promised by the caller.
    let values = unsafe { Input::new(name, pointer.cast::<[f32; 3]>(), 1, 0) }?;
    Ok(Vec3::from(values.get(0)))
}

/// A place of three doubles.
///
/// # Safety
/// `pointer` is NULL or to three doubles.
pub unsafe fn place(name: &str, pointer: *const f64) -> Result<Vec3> {
    // SAFETY: promised by the caller.
    let values = unsafe { Input::new(name, pointer.cast::<[f64; 3]>(), 1, 0) }?;
    Ok(narrow(values.get(0)).into())
}

/// Vectors of a host, checked against the memory limit.
///
/// # Safety
/// As for [`Input::new`].
pub unsafe fn vectors(name: &str, pointer: *const f32, count: usize, stride: usize, limit: u64) -> Result<Vec<Vec3>> {
    // SAFETY: promised by the caller.
    let values = unsafe { Input::new(name, pointer.cast::<[f32; 3]>(), count, stride) }?;
    let mut room = reserve(name, count, limit)?;
    room.extend(values.iter().map(Vec3::from));
    match room.iter().position(|vector: &Vec3| !vector.is_finite()) {
        Some(at) => Err(Error::invalid("a number is not finite").at(format!("{name}, element {at}"))),
        None => Ok(room),
    }
}

descriptor! {
    pub struct RlvFluidArrays {
        struct_size: u32,
        reserved: u32,
        capacity: usize,
        points: *mut f32,
        point_stride: usize,
        velocities: *mut f32,
        velocity_stride: usize,
        numbers: *mut u32,
        number_stride: usize,
        pressures: *mut f32,
        pressure_stride: usize,
        densities: *mut f32,
        density_stride: usize,
        births: *mut f64,
        birth_stride: usize,
    }
}

/// Where a host wants what particles have.
pub struct Places {
    points: Option<Output<[f32; 3]>>,
    velocities: Option<Output<[f32; 3]>>,
    numbers: Option<Output<u32>>,
    pressures: Option<Output<f32>>,
    pub densities: Option<Output<f32>>,
    births: Option<Output<f64>>,
}

impl Places {
    /// # Safety
    /// The arrays are as `fluid.h` demands.
    pub unsafe fn new(given: &RlvFluidArrays) -> Result<Self> {
        let room = given.capacity;
        // SAFETY: promised by the caller.
        unsafe {
            Ok(Self {
                points: Output::optional("points", given.points.cast(), room, given.point_stride)?,
                velocities: Output::optional("velocities", given.velocities.cast(), room, given.velocity_stride)?,
                numbers: Output::optional("numbers", given.numbers, room, given.number_stride)?,
                pressures: Output::optional("pressures", given.pressures, room, given.pressure_stride)?,
                densities: Output::optional("densities", given.densities, room, given.density_stride)?,
                births: Output::optional("births", given.births, room, given.birth_stride)?,
            })
        }
    }

    pub fn fill(&self, simulation: &Simulation) {
        let fluid = &simulation.fluid;
        if let Some(points) = self.points {
            points.fill(simulation.by_number(|at| fluid.places()[at].truncate().to_array()));
        }
        if let Some(velocities) = self.velocities {
            velocities.fill(simulation.by_number(|at| fluid.velocities()[at].truncate().to_array()));
        }
        if let Some(numbers) = self.numbers {
            numbers.fill(simulation.by_number(|at| fluid.numbers()[at]));
        }
        if let Some(pressures) = self.pressures {
            pressures.fill(simulation.by_number(|at| fluid.pressures()[at]));
        }
        if let Some(births) = self.births {
            births.fill(simulation.by_number(|at| fluid.births()[at]));
        }
    }
}
