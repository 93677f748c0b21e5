//! Foam as a medium, for renderers that march through media: how much light particles take from a ray, in a grid.

use std::f64::consts::PI;

use glam::DVec3;
use relievo_core::{Context, Error, Result};

use super::FoamParticle;
use super::depth::radius;
use super::falloff::falloff;
use super::settings::FoamSettings;

/// Values of a grid at most.
const MAX: f64 = 67_108_864.0;
/// Values along an axis at most, which files count in 16 bits.
const MAX_ALONG: f64 = 65_535.0;
/// One cross section π r² in fixed point, so that sums do not depend on the order of particles.
const UNIT: f64 = (1u64 << 32) as f64;

/// Coefficients of extinction at the points of a grid.
#[derive(Clone, Debug)]
pub struct Extinction {
    settings: FoamSettings,
    low: DVec3,
    cell: f64,
    size: [usize; 3],
    sums: Vec<u64>,
}

impl Extinction {
    /// Makes a grid without foam that covers a box and a cell around it, of cubic cells with this edge.
    ///
    /// # Errors
    /// Fails with `Invalid` if a setting is out of range, or the grid has more than 2²⁶ values or 65,535 along an axis,
    /// and with `Memory` if it has more than the memory limit has room for.
    pub fn new(context: &Context, settings: FoamSettings, [low, high]: [DVec3; 2], cell: f64) -> Result<Self> {
        settings.check()?;
        let counts = ((high - low) / cell).ceil() + 3.0;
        let is_possible = cell > 0.0 && (counts.cmpge(DVec3::splat(3.0)) & counts.cmple(DVec3::splat(MAX_ALONG))).all();
        let count = counts.element_product();
        if !is_possible || count > MAX {
            return Err(Error::invalid(format!(
                "a grid of {} × {} × {} values cannot be made",
                counts.x, counts.y, counts.z
            ))
            .at("cell")
            .advise("use larger cells"));
        }
        if 8.0 * count > context.memory_limit() as f64 {
            return Err(Error::memory(format!("a grid of foam needs {} bytes", 8.0 * count))
                .advise("use larger cells, or make the memory limit larger"));
        }
        let size = counts.to_array().map(|count| count as usize);
        Ok(Self { settings, low: low - cell, cell, size, sums: vec![0; size.iter().product()] })
    }

    /// Adds particles, each to the eight points about it. Particles beyond the grid are left out.
    pub fn add(&mut self, particles: &[FoamParticle]) {
        for particle in particles {
            let place = (DVec3::from(particle.position.map(f64::from)) - self.low) / self.cell;
            let first = place.floor();
            let last = DVec3::from(self.size.map(|size| size as f64 - 2.0));
            if !(first.cmpge(DVec3::ZERO) & first.cmple(last)).all() {
                continue;
            }
            let share = f64::from(radius(&self.settings, particle) / self.settings.radius).powi(2);
            let life = match particle.life {
                life if life > 0.0 => falloff(life, 1.0, self.settings.lifetime_n, self.settings.lifetime_m),
                _ => 1.0,
            };
            let after = place - first;
            let [x, y, z] = first.to_array().map(|at| at as usize);
            for corner in 0..8 {
                let [i, j, k] = [corner & 1, corner >> 1 & 1, corner >> 2];
                let weight = |after: f64, is_next: usize| if is_next == 1 { after } else { 1.0 - after };
                let weight = weight(after.x, i) * weight(after.y, j) * weight(after.z, k);
                let at = ((z + k) * self.size[1] + y + j) * self.size[0] + x + i;
                self.sums[at] += (UNIT * share * f64::from(life) * weight) as u64;
            }
        }
    }

    /// Returns the number of values along x, y and z.
    pub fn size(&self) -> [usize; 3] {
        self.size
    }

    /// Returns the place of the first value.
    pub fn low(&self) -> DVec3 {
        self.low
    }

    /// Returns the distance between values.
    pub fn cell(&self) -> f64 {
        self.cell
    }

    /// Returns the coefficients in 1/m, row after row along x, then y, then z.
    pub fn coefficients(&self) -> impl ExactSizeIterator<Item = f64> + '_ {
        let unit = PI * f64::from(self.settings.radius).powi(2) / self.cell.powi(3) / UNIT;
        self.sums.iter().map(move |sum| unit * *sum as f64)
    }
}
