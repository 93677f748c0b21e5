//! Pass 7: shadows and irradiance are filtered, and the foam is laid over a picture (Akinci et al. 2013, Section 2.5).

use glam::Vec3;
use relievo_core::{Context, Error, Result};

use super::layers::FoamLayers;
use crate::image::Image;

/// The radius of the filter in pixels at most: near particles need none that is wider.
const WIDEST: f32 = 16.0;

impl FoamLayers {
    /// Returns a picture, of three channels at least, with the foam over it: C = (1 − ι) C_bg + ι (I − ζ). Further
    /// channels stay. A graphics device that made the layers does this too.
    ///
    /// # Errors
    /// Fails with `Invalid` if the picture has another size than the layers, or fewer channels, and with `Memory` or
    /// `Device` if a device has no memory for it or was lost.
    pub fn composite(&self, context: &Context, background: &Image) -> Result<Image> {
        let [width, height] = self.size();
        if [background.width(), background.height()] != [width, height] || background.channels() < 3 {
            return Err(Error::invalid(format!(
                "the picture has {} × {} pixels of {} channels, and the foam {width} × {height}",
                background.width(),
                background.height(),
                background.channels()
            ))
            .at("background")
            .advise("use a picture in colour of the size of the foam"));
        }
        if let Some(device) = &self.device {
            return device.composite(background);
        }
        // Each shadow is read by all pixels about it.
        let mut shadows = Vec::new();
        context.map_into(self.occlusion.len(), &mut shadows, |pixel| self.shadow(pixel));
        let mut picture = background.clone();
        let channels = background.channels() as usize;
        let mut rows: Vec<_> = picture.data_mut().chunks_mut(channels * width as usize).collect();
        context.for_each_mut(&mut rows, |y, row| {
            let intensities = &self.intensity[y * width as usize..];
            for (x, (pixel, intensity)) in row.chunks_exact_mut(channels).zip(intensities).enumerate() {
                for (value, foam) in pixel.iter_mut().zip(self.foam_color(&shadows, x, y).to_array()) {
                    *value = (1.0 - intensity) * *value + intensity * foam;
                }
            }
        });
        Ok(picture)
    }

    /// Returns the colour I − ζ of the foam of a pixel by the shadows of all pixels.
    fn foam_color(&self, shadows: &[f32], x: usize, y: usize) -> Vec3 {
        let at = y * self.view.width as usize + x;
        if self.intensity[at] == 0.0 {
            return Vec3::ZERO;
        }
        let (shadow, irradiance) = self.filtered(shadows, x, y, at);
        let settings = &self.settings;
        let color = Vec3::new(settings.shadow_red, settings.shadow_green, settings.shadow_blue);
        let shadow = (shadow * (Vec3::ONE - color)).clamp(Vec3::ZERO, Vec3::ONE);
        let light = (settings.irr_scale * irradiance).clamp(Vec3::ZERO, Vec3::ONE);
        // Where shadows are darker than the light, black remains.
        (light - shadow).max(Vec3::ZERO)
    }

    /// Returns shadow and irradiance of a pixel as Gaussian means over the foam around it.
    fn filtered(&self, shadows: &[f32], x: usize, y: usize, at: usize) -> (f32, Vec3) {
        let settings = &self.settings;
        let radius = (settings.filter * settings.ao_init_sr_fac * self.surfaces.search[at]).min(WIDEST);
        let reach = radius as usize;
        // The filter ends at two standard deviations.
        let falloff = -2.0 / (radius * radius).max(1e-6);
        // The weight of a pixel is that of its distance along the row times that along the column.
        let mut along = [1.0; WIDEST as usize + 1];
        for (distance, weight) in along.iter_mut().enumerate().take(reach + 1).skip(1) {
            *weight = (falloff * (distance * distance) as f32).exp();
        }
        let (mut shadow, mut irradiance, mut weights) = (0.0, Vec3::ZERO, 0.0);
        let [width, height] = self.size().map(|size| size as usize);
        for row in y.saturating_sub(reach)..(y + reach + 1).min(height) {
            for column in x.saturating_sub(reach)..(x + reach + 1).min(width) {
                let other = row * width + column;
                if self.intensity[other] == 0.0 {
                    continue;
                }
                let distance = [column.abs_diff(x), row.abs_diff(y)];
                let square = (distance[0].pow(2) + distance[1].pow(2)) as f32;
                if square > radius * radius && other != at {
                    continue;
                }
                let weight = along[distance[0]] * along[distance[1]];
                shadow += weight * shadows[other];
                irradiance += weight * Vec3::from(self.irradiance[other]);
                weights += weight;
            }
        }
        (shadow / weights, irradiance / weights)
    }
}
