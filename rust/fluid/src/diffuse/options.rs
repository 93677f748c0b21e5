//! The settings of diffuse particles, with the symbols of Ihmsen et al. 2012.

use glam::Vec3;
use relievo_core::{Error, Result};

relievo_core::parameters! {
    /// How diffuse particles are born, move and dissolve. The defaults are those of the paper's scenes.
    pub struct DiffuseSettings {
        /// Lower limit of the potential of trapped air.
        air_min: f32 = 5.0, 0.0..=1000000, "m/s";
        /// Upper limit of the potential of trapped air, above the lower one.
        air_max: f32 = 20.0, 0.0..=1000000, "m/s";
        /// Lower limit of the potential of wave crests.
        crest_min: f32 = 2.0, 0.0..=1000000, "";
        /// Upper limit of the potential of wave crests, above the lower one.
        crest_max: f32 = 8.0, 0.0..=1000000, "";
        /// Lower limit of the kinetic energy of a kilogram.
        energy_min: f32 = 5.0, 0.0..=1000000000, "J/kg";
        /// Upper limit of the kinetic energy of a kilogram, above the lower one.
        energy_max: f32 = 50.0, 0.0..=1000000000, "J/kg";
        /// Particles that a particle of the fluid makes in a second at the upper limit of trapped air (k_ta).
        air_rate: f32 = 4000.0, 0.0..=1000000000, "1/s";
        /// Particles that a particle of the fluid makes in a second at the upper limit of crests (k_wc).
        crest_rate: f32 = 4000.0, 0.0..=1000000000, "1/s";
        /// Seconds that foam of the least potential lives.
        lifetime_min: f32 = 2.0, 0.000001..=1000000, "s";
        /// Seconds that foam of the greatest potential lives, not below the least.
        lifetime_max: f32 = 5.0, 0.000001..=1000000, "s";
        /// A particle with fewer neighbours in the fluid is spray.
        spray_below: u32 = 6, 0..=1000000, "";
        /// A particle with more neighbours in the fluid is a bubble; not below the limit of spray.
        bubbles_above: u32 = 20, 0..=1000000, "";
        /// Acceleration of bubbles against gravity, as a share of gravity (k_b).
        buoyancy: f32 = 2.0, 0.0..=1000, "";
        /// Share of the difference to the fluid's velocity that a bubble loses in a step (k_d).
        drag: f32 = 0.8, 0.0..=1, "";
        /// Steps of a frame.
        steps: u32 = 2, 1..=1000, "";
        /// Particles at a time; further births are refused and counted.
        most: u32 = 100000000, 0..=4294967295u32, "";
        /// Seed of all random numbers.
        seed: u32 = 1, 0..=4294967295u32, "";
    }
}

/// The fluid that diffuse particles are made of, and their settings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DiffuseOptions {
    /// Distance between particles of the fluid at rest, in metres; positive. Particles within twice that are neighbours.
    pub spacing: f32,
    /// Acceleration of spray, in m/s².
    pub gravity: Vec3,
    /// Corners of a box in metres; particles outside of it are removed.
    pub bounds: Option<[Vec3; 2]>,
    /// How particles are born, move and dissolve.
    pub settings: DiffuseSettings,
}

impl Default for DiffuseOptions {
    /// Returns the values of the paper's scenes, for particles 2 cm apart and y upwards.
    fn default() -> Self {
        Self { spacing: 0.02, gravity: Vec3::new(0.0, -9.81, 0.0), bounds: None, settings: DiffuseSettings::default() }
    }
}

impl DiffuseOptions {
    /// Checks every setting.
    pub(super) fn check(&self) -> Result<()> {
        let refuse =
            |name: &str, advice: &str| Err(Error::invalid("the setting is out of range").at(name).advise(advice));
        if !(self.spacing > 0.0 && self.spacing.is_finite()) {
            return refuse("spacing", "use a length above 0");
        }
        if !self.gravity.is_finite() {
            return refuse("gravity", "use three numbers");
        }
        if self.bounds.is_some_and(|[low, high]| !low.cmplt(high).all() || !low.is_finite() || !high.is_finite()) {
            return refuse("bounds", "use a corner, and one that is greater along each axis");
        }
        let settings = &self.settings;
        settings.check()?;
        for (name, [low, high]) in [
            ("air_max", [settings.air_min, settings.air_max]),
            ("crest_max", [settings.crest_min, settings.crest_max]),
            ("energy_max", [settings.energy_min, settings.energy_max]),
        ] {
            if low >= high {
                return refuse(name, "use an upper limit above the lower one");
            }
        }
        if settings.lifetime_min > settings.lifetime_max {
            return refuse("lifetime_max", "use a time that is not below lifetime_min");
        }
        if settings.spray_below > settings.bubbles_above {
            return refuse("bubbles_above", "use a number that is not below spray_below");
        }
        Ok(())
    }

    /// Returns the radius within which particles are neighbours.
    pub(super) fn support(&self) -> f32 {
        2.0 * self.spacing
    }
}
