//! Pass 6, first part: ambient occlusion in screen space, in passes of growing search radii (Akinci et al. 2013,
//! Section 2.4.1, after Mittring 2007).

use std::f32::consts::PI;

use glam::Vec3;
use relievo_core::{Context, Progress, Result};

use super::depth::normal;
use super::halton::Ball;
use super::layers::Shading;
use super::settings::FoamSettings;

/// Finds the occlusion of pixels.
struct Search<'a> {
    of: &'a Shading<'a>,
    ball: Ball,
}

/// Returns the occlusion ω of every pixel, 0 where there is no foam. Fails if `progress` asks to stop.
pub fn occlusion(context: &Context, of: &Shading<'_>, progress: &mut dyn Progress) -> Result<Vec<f32>> {
    let search = Search { of, ball: Ball::new(of.settings.ao_max_samp.max(of.settings.ao_min_samp)) };
    let width = of.view.width as usize;
    let rows = context.map_watched(of.view.height as usize, progress, ("occlusion of foam", [0.0, 1.0]), |y| {
        (0..width).map(|x| search.of_pixel(x, y)).collect::<Vec<f32>>()
    })?;
    Ok(rows.concat())
}

impl Search<'_> {
    fn of_pixel(&self, x: usize, y: usize) -> f32 {
        let at = y * self.of.view.width as usize + x;
        if self.of.intensity[at] == 0.0 {
            return 0.0;
        }
        let (depth, search) = (self.of.surfaces.depth[at], self.of.surfaces.search[at]);
        let [u, v] = self.of.surfaces.disc[at];
        // In eye space depth grows away from the camera.
        let outward = normal(u, v) * Vec3::new(1.0, 1.0, -1.0);
        let place = self.of.projection.from_picture(x as f32 + 0.5, y as f32 + 0.5, depth);
        let metres = self.of.projection.scale(depth).recip();
        let (mut sum, mut weights) = (0.0, 0.0);
        for pass in 0..self.of.settings.ao_passes {
            let radius = search * (self.of.settings.ao_init_sr_fac + self.of.settings.ao_sr_inc_fac * pass as f32);
            for sample in self.ball.of(samples(self.of.settings, radius)) {
                let mut offset = sample.place;
                if self.of.settings.ao_hemisphere.is_on() && offset.dot(outward) < 0.0 {
                    offset = -offset;
                }
                let there = place + radius * metres * offset;
                let Some(other) = self.pixel_of(there) else { continue };
                weights += sample.weight;
                sum += sample.weight * self.occluded(other, there.z);
            }
        }
        if weights > 0.0 { sum / weights } else { 0.0 }
    }

    /// Returns the pixel that shows a place in eye space; `None` outside of the picture.
    #[inline]
    fn pixel_of(&self, place: Vec3) -> Option<usize> {
        if place.z <= 0.0 {
            return None;
        }
        let at = self.of.projection.to_picture(place);
        let is_inside =
            at.x >= 0.0 && at.y >= 0.0 && at.x < self.of.view.width as f32 && at.y < self.of.view.height as f32;
        is_inside.then(|| at.y as usize * self.of.view.width as usize + at.x as usize)
    }

    /// Returns δ·k·a of a sample at a depth, summed over what is in front of it in a pixel, at most 1.
    #[inline]
    fn occluded(&self, pixel: usize, depth: f32) -> f32 {
        let share = |front: f32, opacity: f32| {
            if depth > front {
                let near = (1.0 - (depth - front) / self.of.settings.ao_max_occl_dist).max(0.0);
                near * near * opacity
            } else {
                0.0
            }
        };
        let foam = share(self.of.surfaces.depth[pixel], self.of.intensity[pixel]);
        let fluid = share(self.of.depths.fluid[pixel], self.of.settings.ao_fluid_opacity);
        let solid = share(self.of.depths.solids[pixel], self.of.settings.ao_solid_opacity);
        (foam + fluid + solid).min(1.0)
    }
}

/// Returns the number ν of samples in the cube for a search radius in pixels.
pub fn samples(settings: &FoamSettings, radius: f32) -> u32 {
    let count = 0.75 * PI * radius.powi(3) * settings.ao_s_dens;
    // A limit below the other gives way.
    (count.min(4e9) as u32).min(settings.ao_max_samp).max(settings.ao_min_samp)
}

/// Returns the shadow ζ of an occlusion ω, 0 to 1.
pub fn shadow(settings: &FoamSettings, occlusion: f32) -> f32 {
    let scaled = (occlusion * settings.ao_sh_scale).powf(settings.ao_sh_exp);
    (scaled + settings.ao_sh_offset).clamp(0.0, 1.0)
}
