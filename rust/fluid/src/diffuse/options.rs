//! The settings of diffuse particles.

use glam::Vec3;
use relievo_core::{Error, Result};

/// The settings of diffuse particles, with the symbols of Ihmsen et al. 2012.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DiffuseOptions {
    /// Distance between particles of the fluid at rest, in metres; positive. Particles within twice that are neighbours.
    pub spacing: f32,
    /// Acceleration of spray, in m/s².
    pub gravity: Vec3,
    /// The limits τ of the potential of trapped air, in m/s.
    pub trapped_air: [f32; 2],
    /// The limits τ of the potential of wave crests.
    pub crests: [f32; 2],
    /// The limits τ of the kinetic energy of a kilogram, in J/kg.
    pub energy: [f32; 2],
    /// Particles that a particle of the fluid makes in a second where it traps as much air as counts (k_ta).
    pub air_rate: f32,
    /// The same of crests (k_wc).
    pub crest_rate: f32,
    /// Seconds that foam of the least and of the greatest potential lives.
    pub lifetime: [f32; 2],
    /// A particle with fewer neighbours is spray.
    pub spray_below: u32,
    /// A particle with more neighbours is a bubble.
    pub bubbles_above: u32,
    /// Acceleration of bubbles against gravity, as a share of it (k_b).
    pub buoyancy: f32,
    /// The share of the difference to the fluid's velocity that a bubble loses in a step (k_d), 0 to 1.
    pub drag: f32,
    /// Steps of a frame, 1 to 1,000.
    pub steps: u32,
    /// Corners of a box in metres; particles outside of it are removed.
    pub bounds: Option<[Vec3; 2]>,
    /// The greatest number of particles at a time; further births are refused and counted.
    pub most: usize,
    /// The seed of all that is random.
    pub seed: u64,
}

impl Default for DiffuseOptions {
    /// Returns the values of the paper's scenes, for particles 2 cm apart.
    fn default() -> Self {
        Self {
            spacing: 0.02,
            gravity: Vec3::new(0.0, -9.81, 0.0),
            trapped_air: [5.0, 20.0],
            crests: [2.0, 8.0],
            energy: [5.0, 50.0],
            air_rate: 4000.0,
            crest_rate: 4000.0,
            lifetime: [2.0, 5.0],
            spray_below: 6,
            bubbles_above: 20,
            buoyancy: 2.0,
            drag: 0.8,
            steps: 2,
            bounds: None,
            most: 100_000_000,
            seed: 1,
        }
    }
}

impl DiffuseOptions {
    /// Checks every setting.
    pub(super) fn check(&self) -> Result<()> {
        let refuse =
            |name: &str, advice: &str| Err(Error::invalid("the setting is out of range").at(name).advise(advice));
        let is_range = |[low, high]: [f32; 2]| low >= 0.0 && low < high && high.is_finite();
        let is_rate = |rate: f32| (0.0..=1e9).contains(&rate);
        if !(self.spacing > 0.0 && self.spacing.is_finite()) {
            return refuse("spacing", "use a length above 0");
        }
        if !self.gravity.is_finite() {
            return refuse("gravity", "use three numbers");
        }
        for (name, limits) in [("trapped_air", self.trapped_air), ("crests", self.crests), ("energy", self.energy)] {
            if !is_range(limits) {
                return refuse(name, "use a limit of at least 0 and a greater one");
            }
        }
        if !is_rate(self.air_rate) || !is_rate(self.crest_rate) {
            return refuse("air_rate, crest_rate", "use 0 to 10⁹ particles a second");
        }
        let [least, greatest] = self.lifetime;
        if !(least > 0.0 && least <= greatest && greatest.is_finite()) {
            return refuse("lifetime", "use a time above 0 and one that is not less");
        }
        if self.spray_below > self.bubbles_above {
            return refuse("spray_below", "use no more than bubbles_above");
        }
        if !(0.0..=1000.0).contains(&self.buoyancy) {
            return refuse("buoyancy", "use 0 to 1000");
        }
        if !(0.0..=1.0).contains(&self.drag) {
            return refuse("drag", "use 0 to 1");
        }
        if !(1..=1000).contains(&self.steps) {
            return refuse("steps", "use 1 to 1000");
        }
        if self.bounds.is_some_and(|[low, high]| !low.cmplt(high).all() || !low.is_finite() || !high.is_finite()) {
            return refuse("bounds", "use a corner, and one that is greater along each axis");
        }
        Ok(())
    }

    /// Returns the radius within which particles are neighbours.
    pub(super) fn support(&self) -> f32 {
        2.0 * self.spacing
    }
}
