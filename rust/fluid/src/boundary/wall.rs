//! Walls of particles that fluid is kept away by (Akinci et al. 2012).
//!
//! A wall's particles lie half a spacing behind its surface, and fluid that begins half a spacing before it sees as much of
//! them as of a lattice that goes on. A particle counts less where they are denser.

use glam::{IVec3, Vec3, Vec4};
use relievo_core::{Context, Error, Result};

use crate::solver::cells::Cells;
use crate::solver::constants::Constants;
use crate::solver::neighbours::{CHUNK_LEN, NOWHERE, Neighbours};

/// The particles of walls, in the order of cells.
#[derive(Clone, Debug)]
pub struct Wall {
    /// Places with masses, and velocities, each with a row after the last.
    pub places: Vec<Vec4>,
    pub velocities: Vec<Vec4>,
    pub cells: Cells,
    /// The number that each had when it was set.
    pub numbers: Vec<u32>,
    /// The speed of the fastest, in m/s. Nothing is done for walls at rest.
    pub speed: f32,
    /// The same in the order in which they were set.
    set: Vec<Vec4>,
    paces: Vec<Vec4>,
    /// Where they are when a step ends, in the order of cells.
    ends: Vec<Vec4>,
    /// Whether the order of cells is that of where they are.
    is_sorted: bool,
}

impl Default for Wall {
    fn default() -> Self {
        Self {
            places: vec![NOWHERE],
            velocities: vec![Vec4::ZERO],
            cells: Cells::default(),
            numbers: Vec::new(),
            speed: 0.0,
            set: Vec::new(),
            paces: Vec::new(),
            ends: Vec::new(),
            is_sorted: true,
        }
    }
}

impl Wall {
    /// Of places with masses, at rest, for a support radius. Fails if one is not finite, or they are too far from each other.
    pub fn new(context: &Context, support: f32, set: Vec<Vec4>) -> Result<Self> {
        if set.is_empty() {
            return Ok(Self::default());
        }
        let mut wall = Self { paces: vec![Vec4::ZERO; set.len()], set, is_sorted: false, ..Self::default() };
        wall.sort(context, support)?;
        Ok(wall)
    }

    /// Puts those from a number on at places in metres with masses, with velocities in m/s.
    pub fn put(&mut self, first: usize, places: impl Iterator<Item = Vec4>, velocities: impl Iterator<Item = Vec4>) {
        self.set[first..].iter_mut().zip(places).for_each(|(set, place)| *set = place);
        self.paces[first..].iter_mut().zip(velocities).for_each(|(pace, velocity)| *pace = velocity);
        self.speed = self.paces.iter().map(|pace| pace.length_squared()).fold(0.0, f32::max).sqrt();
        self.is_sorted = false;
    }

    /// Their places with masses, in the order in which they were set.
    pub fn set(&self) -> &[Vec4] {
        &self.set
    }

    /// Their velocities, in the same order.
    pub fn paces(&self) -> &[Vec4] {
        &self.paces
    }

    /// Finds where they are after so many seconds.
    pub fn predict(&mut self, seconds: f32) {
        if self.speed > 0.0 {
            self.ends.clone_from(&self.places);
            self.ends.iter_mut().zip(&self.velocities).for_each(|(end, velocity)| *end += seconds * *velocity);
        }
    }

    /// Where they are when the step ends that was predicted.
    pub fn ends(&self) -> &[Vec4] {
        if self.speed > 0.0 { &self.ends } else { &self.places }
    }

    /// Goes on by so many seconds.
    pub fn arrive(&mut self, seconds: f32) {
        if self.speed > 0.0 && seconds > 0.0 {
            self.set.iter_mut().zip(&self.paces).for_each(|(place, pace)| *place += seconds * *pace);
            self.is_sorted = false;
        }
    }

    /// Puts them into the order of cells of a side, if they have moved. That order follows from where they are alone.
    pub fn sort(&mut self, context: &Context, side: f32) -> Result<()> {
        if self.is_sorted {
            return Ok(());
        }
        self.cells.fill(context, side, &self.set).map_err(|error| error.at("walls"))?;
        self.numbers = self.cells.order().collect();
        let moved = |rows: &[Vec4], last: Vec4| -> Vec<Vec4> {
            self.numbers.iter().map(|number| rows[*number as usize]).chain([last]).collect()
        };
        self.places = moved(&self.set, NOWHERE);
        self.velocities = moved(&self.paces, Vec4::ZERO);
        self.is_sorted = true;
        Ok(())
    }
}

/// Places with what a particle of a wall weighs there, in kg: less where they are dense. Fails if a place is not finite, or
/// too many are near one.
pub fn weigh(context: &Context, constants: &Constants, places: &[Vec3]) -> Result<Vec<Vec4>> {
    let Constants { kernels, spacing, mass, .. } = *constants;
    let named = |error: Error| error.at("walls");
    let mut points: Vec<Vec4> = places.iter().map(|place| place.extend(0.0)).collect();
    let mut cells = Cells::default();
    cells.fill(context, kernels.support, &points).map_err(named)?;
    let sorted: Vec<Vec4> = cells.order().map(|number| points[number as usize]).chain([NOWHERE]).collect();
    let count = points.len();
    let mut near = Neighbours::default();
    near.find(context, &sorted[..count], (&sorted, &cells), kernels.support, true, &[])
        .map_err(|error| Error { place: "walls".into(), ..error })?;
    let reach = (kernels.support / spacing).ceil() as i32;
    let plane = (-reach..=reach).flat_map(|x| (-reach..=reach).map(move |y| Vec3::new(x as f32, y as f32, 0.0)));
    let flat: f32 = plane.map(|place| kernels.density(place.length() * spacing)).sum();
    let around = context.map(count, |place| {
        let part = &near.parts()[place / CHUNK_LEN];
        let others = part.indices[part.range(place % CHUNK_LEN)].iter();
        others.map(|other| kernels.density(sorted[*other as usize].distance(sorted[place]))).sum::<f32>()
    });
    for (number, around) in cells.order().zip(around) {
        points[number as usize].w = mass * flat / (kernels.density + around);
    }
    Ok(points)
}

/// The places of the particles of a basin, in metres: behind the six sides of a box from `low` to `high`, a spacing
/// from each other.
///
/// # Errors
/// Fails if a side is shorter than half a spacing, the diagonal is 4,096 spacings or more, or a number is not finite.
pub fn basin(low: Vec3, high: Vec3, spacing: f32) -> Result<Vec<Vec3>> {
    let count = ((high - low) / spacing).round();
    if !(count.min_element() >= 1.0 && count.length_squared() < (1 << 24) as f32) {
        return Err(Error::invalid(format!("no basin goes from {low} to {high} by {spacing}"))
            .advise("let its sides be at least a spacing, and at most a few thousand"));
    }
    let step = (high - low) / count;
    let end = count.as_ivec3() + 1;
    let mut places = Vec::new();
    for z in 0..=end.z {
        for y in 0..=end.y {
            let is_side = z == 0 || z == end.z || y == 0 || y == end.y;
            let row = (0..=end.x).step_by(if is_side { 1 } else { end.x as usize });
            places.extend(row.map(|x| low + step * (IVec3::new(x, y, z).as_vec3() - 0.5)));
        }
    }
    Ok(places)
}

/// The places of particles that fill a box from `low` to `high`, in metres, half a spacing from its sides.
///
/// # Errors
/// Fails if a side is shorter than half a spacing, there would be 2²⁶ particles or more, or a number is not finite.
pub fn block(low: Vec3, high: Vec3, spacing: f32) -> Result<Vec<Vec3>> {
    let count = ((high - low) / spacing).round();
    if !(count.min_element() >= 1.0 && count.element_product() < (1 << 26) as f32) {
        return Err(Error::invalid(format!("no block goes from {low} to {high} by {spacing}"))
            .advise("let its sides be at least a spacing, and its particles less than 67 million"));
    }
    let step = (high - low) / count;
    let count = count.as_ivec3();
    let rows = (0..count.z).flat_map(|z| (0..count.y).map(move |y| (y, z)));
    let places = rows.flat_map(|(y, z)| (0..count.x).map(move |x| IVec3::new(x, y, z).as_vec3()));
    Ok(places.map(|place| low + step * (place + 0.5)).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::FluidOptions;
    use crate::solver::kernel::KernelSet;

    #[test]
    fn particles_of_a_flat_wall_count_as_much_as_those_of_the_fluid() {
        let places = basin(Vec3::ZERO, Vec3::new(1.0, 0.8, 0.6), 0.1).unwrap();
        assert_eq!(places.len(), 12 * 10 * 8 - 10 * 8 * 6);
        let constants = Constants::new(&FluidOptions { spacing: 0.1, ..FluidOptions::default() });
        let wall = weigh(&Context::serial(), &constants, &places).unwrap();
        let at = |place: Vec3| wall.iter().find(|other| other.truncate().distance(place) < 1e-5).unwrap().w;
        assert!((at(Vec3::new(0.45, 0.35, -0.05)) / constants.mass - 1.0).abs() < 1e-4);
    }

    #[test]
    fn a_particle_has_less_mass_than_its_cell_of_the_lattice_by_what_kernels_count_too_much() {
        for (kernels, less) in [(KernelSet::Wendland, 0.033), (KernelSet::Mueller, 0.010)] {
            let options = FluidOptions { kernels, spacing: 0.02, density: 1300.0, ..FluidOptions::default() };
            let cell = options.density * options.spacing.powi(3);
            let share = 1.0 - Constants::new(&options).mass / cell;
            assert!((share - less).abs() < 5e-4, "{kernels:?}: {share}");
        }
    }

    #[test]
    fn basins_and_blocks_that_cannot_be_are_refused() {
        for high in [Vec3::ZERO, Vec3::NAN, Vec3::INFINITY, Vec3::splat(1e9), Vec3::new(1.0, -1.0, 1.0)] {
            assert!(basin(Vec3::ZERO, high, 0.1).is_err(), "{high}");
            assert!(block(Vec3::ZERO, high, 0.1).is_err(), "{high}");
        }
        assert!(block(Vec3::ZERO, Vec3::ONE, f32::NAN).is_err());
        assert_eq!(block(Vec3::ZERO, Vec3::new(1.0, 0.5, 0.3), 0.1).unwrap().len(), 150);
    }
}
