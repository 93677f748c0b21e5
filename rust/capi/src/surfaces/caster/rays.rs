//! Rays of hosts, for casters and isosurfaces; see `include/relievo/caster.h`.

use relievo_core::{Error, Result};
use relievo_embree::Ray;

use crate::border::array::Input;
use crate::border::descriptor::read_descriptor;
use crate::surfaces::caster::RlvHit;

descriptor! {
    pub struct RlvRayArrays before masks {
        struct_size: u32,
        reserved: u32,
        count: usize,
        origins: *const f32,
        origin_stride: usize,
        directions: *const f32,
        direction_stride: usize,
        hits: *mut RlvHit,
        hit_stride: usize,
        min_distance: f32,
        max_distance: f32,
        min_distances: *const f32,
        min_distance_stride: usize,
        max_distances: *const f32,
        max_distance_stride: usize,
        masks: *const u32,
        mask_stride: usize,
        times: *const f32,
        time_stride: usize,
    }
}

impl RlvRayArrays {
    /// Reads the arrays that a host gives.
    ///
    /// # Errors
    /// Fails with `Invalid` if `arrays` is NULL or of an unknown size, and with `Unsupported` if it uses fields that this
    /// version lacks.
    ///
    /// # Safety
    /// `arrays` is NULL or a descriptor that starts with its size.
    pub unsafe fn read(arrays: *const Self) -> Result<Self> {
        // SAFETY: a descriptor of nothing but numbers and NULL pointers.
        let default: Self = unsafe { std::mem::zeroed() };
        // SAFETY: promised by the caller.
        unsafe { read_descriptor(arrays, default) }
    }
}

/// The caller's rays.
pub struct Rays {
    origins: Input<[f32; 3]>,
    directions: Input<[f32; 3]>,
    min_distance: f32,
    max_distance: f32,
    min_distances: Option<Input<f32>>,
    max_distances: Option<Input<f32>>,
    masks: Option<Input<u32>>,
    times: Option<Input<f32>>,
}

impl Rays {
    /// Checks the arrays of `given`, of which `hits` is not read.
    ///
    /// # Errors
    /// Fails with `Invalid` if an array that is needed is NULL, a stride is too small, or `min_distance` is negative or above
    /// `max_distance`.
    ///
    /// # Safety
    /// The arrays of `given` are as `caster.h` demands.
    pub unsafe fn new(given: &RlvRayArrays) -> Result<Self> {
        let count = given.count;
        // SAFETY: the caller promises `count` elements of each.
        let rays = unsafe {
            Self {
                origins: Input::new("origins", given.origins.cast(), count, given.origin_stride)?,
                directions: Input::new("directions", given.directions.cast(), count, given.direction_stride)?,
                min_distance: given.min_distance,
                max_distance: unlimited(given.max_distance),
                min_distances: Input::optional("min_distances", given.min_distances, count, given.min_distance_stride)?,
                max_distances: Input::optional("max_distances", given.max_distances, count, given.max_distance_stride)?,
                masks: Input::optional("masks", given.masks, count, given.mask_stride)?,
                times: Input::optional("times", given.times, count, given.time_stride)?,
            }
        };
        if !(rays.min_distance >= 0.0 && rays.min_distance <= rays.max_distance) {
            return Err(Error::invalid(format!(
                "rays cannot run from {} to {}",
                given.min_distance, given.max_distance
            ))
            .at("min_distance")
            .advise("use 0 <= min_distance <= max_distance; a max_distance of 0 is no limit"));
        }
        Ok(rays)
    }

    /// Returns a ray, or `None` if it cannot be cast or shares no bit with `mask`.
    pub fn get(&self, index: usize, mask: u32) -> Option<Ray> {
        let ray = Ray {
            origin: self.origins.get(index),
            direction: self.directions.get(index),
            near: self.min_distances.as_ref().map_or(self.min_distance, |distances| distances.get(index)),
            far: self.max_distances.as_ref().map_or(self.max_distance, |distances| distances.get(index)),
        };
        let own = self.masks.as_ref().map_or(u32::MAX, |masks| masks.get(index));
        (own & mask != 0 && can_cast(&ray)).then_some(ray)
    }

    /// Returns the time of a ray, in seconds.
    pub fn time(&self, index: usize) -> f32 {
        self.times.as_ref().map_or(0.0, |times| times.get(index))
    }
}

/// Returns the largest distance that a host gives, of which 0 is no limit.
pub fn unlimited(max_distance: f32) -> f32 {
    if max_distance == 0.0 { f32::INFINITY } else { max_distance }
}

/// Returns whether a ray can hit something, by the rule in `caster.h`.
pub fn can_cast(ray: &Ray) -> bool {
    // No comparison holds for a number that is not one.
    let mut numbers = ray.origin.iter().chain(&ray.direction);
    numbers.all(|value| value.abs() <= Ray::LARGEST)
        && ray.direction != [0.0; 3]
        && 0.0 <= ray.near
        && ray.near <= ray.far
}
