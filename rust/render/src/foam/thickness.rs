//! Pass 4: how much foam each pixel has, summed over all particles (Akinci et al. 2013, Section 2.2).

use super::depth::{Fragment, Sprite};
use super::falloff::{Table, falloff};
use super::settings::FoamSettings;

/// One unit of thickness in fixed point. A particle gives at most 1, and 2³² particles still fit.
const UNIT: f64 = (1u64 << 32) as f64;

/// The falloffs of particles.
#[derive(Clone, Debug)]
pub struct Thickness {
    kinds: [Table; 3],
    attenuation: Table,
    eta_max: f32,
    lifetime: [f32; 2],
}

impl Thickness {
    /// Makes the falloffs of the settings.
    pub fn new(settings: &FoamSettings) -> Self {
        Self {
            kinds: [
                Table::new(settings.spray_n, settings.spray_m, false),
                Table::new(settings.foam_n, settings.foam_m, false),
                Table::new(settings.bubble_n, settings.bubble_m, true),
            ],
            attenuation: Table::new(settings.eta_n, settings.eta_m, false),
            eta_max: settings.eta_max,
            lifetime: [settings.lifetime_n, settings.lifetime_m],
        }
    }

    /// Returns the tables of spray, foam and bubbles, and that of the attenuation within the fluid, one after the other.
    pub fn tables(&self) -> Vec<f32> {
        self.kinds.iter().chain([&self.attenuation]).flat_map(Table::entries).copied().collect()
    }

    /// Returns the factor of a particle by the share of its life that has passed.
    #[inline]
    pub fn of_life(&self, life: f32) -> f32 {
        let [n, m] = self.lifetime;
        if life > 0.0 { falloff(life, 1.0, n, m) } else { 1.0 }
    }

    /// Returns the thickness of a fragment in fixed point, where the surface of the fluid has a depth.
    #[inline]
    pub fn of_fragment(&self, sprite: &Sprite, fragment: &Fragment, fluid: f32) -> u64 {
        let mut value = sprite.share * self.kinds[sprite.kind as usize].at(fragment.square.sqrt());
        let behind = fragment.depth - fluid;
        if behind > 0.0 {
            value *= if behind < self.eta_max { self.attenuation.at(behind / self.eta_max) } else { 0.0 };
        }
        (f64::from(value) * UNIT) as u64
    }
}

/// Returns a sum in fixed point as a number.
pub fn of_sum(sum: u64) -> f32 {
    (sum as f64 / UNIT) as f32
}
