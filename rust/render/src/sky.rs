//! The sky's light on surfaces: what arrives, what bounces, and how few rays per pixel are made to say it.
//!
//! Light that bounces in hollows is approximated from occlusion and colour (Jimenez et al. 2016, "Practical Real-Time
//! Strategies for Accurate Indirect Occlusion", Section 5), so that dents in snow do not turn black. Occlusion is
//! averaged over neighbouring pixels of the same smooth piece of surface, as with the cross-bilateral filters of
//! Bavoil and Sainz 2008, "Screen Space Ambient Occlusion".

use glam::Vec3;

use crate::camera::Rays;
use crate::frame::Frame;
use crate::light::Sky;
use crate::sampling::{Shift, cosine_hemisphere};

/// Light of the sky on the surfaces of a pixel.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct SkyLight {
    /// What the rays that found nothing in the way bring.
    pub open: Vec3,
    /// What all rays would bring.
    pub all: Vec3,
    /// What an open surface of this inclination gets, without the rays' noise.
    pub clear: Vec3,
    /// The latter, reflected.
    pub reflected: Vec3,
}

/// What an open surface gets of a sky, by its inclination: the mean of the radiance, weighted with the cosine.
pub(crate) struct ClearSky {
    up: Vec3,
    means: Vec<Vec3>,
}

/// Steps of cos θ from −1 to 1 in that table, and directions per entry.
const STEPS: usize = 64;
const DIRECTIONS: u32 = 512;

impl ClearSky {
    /// The table of `sky`.
    pub fn new(sky: &Sky) -> Self {
        let up = Vec3::from(sky.up).normalize();
        let side = up.any_orthonormal_vector();
        let mean = |step: usize| {
            let cos = 2.0 * step as f32 / STEPS as f32 - 1.0;
            let normal = up * cos + side * (1.0 - cos * cos).max(0.0).sqrt();
            let place = |index| Shift::new(0, 0, 0).sample(index, DIRECTIONS);
            let radiance = |index| sky.radiance(up, cosine_hemisphere(normal, place(index)));
            (0..DIRECTIONS).map(radiance).sum::<Vec3>() / DIRECTIONS as f32
        };
        Self { up, means: (0..=STEPS).map(mean).collect() }
    }

    /// The table: by the cosine of the inclination, in equal steps from −1 to 1.
    #[cfg(feature = "wgpu")]
    pub fn means(&self) -> &[Vec3] {
        &self.means
    }

    /// What a surface of this normal gets.
    pub fn mean(&self, normal: Vec3) -> Vec3 {
        let at = (0.5 + 0.5 * normal.dot(self.up)).clamp(0.0, 1.0) * STEPS as f32;
        let low = (at as usize).min(STEPS - 1);
        self.means[low].lerp(self.means[low + 1], at - low as f32)
    }
}

/// Keeps channels without light from dividing by zero.
const TINY: Vec3 = Vec3::splat(f32::MIN_POSITIVE);

impl SkyLight {
    /// Adds what another sample found.
    pub fn add(&mut self, other: &Self) {
        self.open += other.open;
        self.all += other.all;
        self.clear += other.clear;
        self.reflected += other.reflected;
    }

    /// This light, times `factor`.
    pub fn scaled(self, factor: f32) -> Self {
        Self {
            open: self.open * factor,
            all: self.all * factor,
            clear: self.clear * factor,
            reflected: self.reflected * factor,
        }
    }

    /// This light behind a filter.
    pub fn filtered(self, share: Vec3) -> Self {
        Self {
            open: self.open * share,
            all: self.all * share,
            clear: self.clear * share,
            reflected: self.reflected * share,
        }
    }

    /// What the surface gives back if `share` of the light arrives straight: the share that arrives after any number
    /// of bounces depends on it and on the colour.
    fn with_share(&self, share: Vec3) -> Vec3 {
        let albedo = self.reflected / self.clear.max(TINY);
        let (a, b, c) = (2.0404 * albedo - 0.3324, -4.7951 * albedo + 0.6417, 2.7552 * albedo + 0.6903);
        let bounced = (((share * a + b) * share + c) * share).max(share);
        self.reflected * Vec3::select(share.cmpge(Vec3::ONE), Vec3::ONE, bounced)
    }
}

/// The sky's light that row `y` of a picture gives back, where neighbours up to `radius` pixels away help to find the
/// share of light that arrives.
pub(crate) fn reflected_row(frame: &Frame, sky: &[SkyLight], rays: &Rays, radius: u32, y: u32) -> Vec<Vec3> {
    let (width, height) = (frame.color.width(), frame.color.height());
    let (depths, normals) = (frame.depth.data(), frame.normal.data());
    let index = |x: u32, y: u32| y as usize * width as usize + x as usize;
    let normal = |at: usize| Vec3::new(normals[3 * at], normals[3 * at + 1], normals[3 * at + 2]);
    let point = |x: u32, y: u32| rays.direction(x as f32 + 0.5, y as f32 + 0.5) * depths[index(x, y)];
    let pixel = rays.dx.length();
    let share = |x: u32| {
        let at = index(x, y);
        let (mut open, mut all) = (sky[at].open, sky[at].all);
        if radius == 0 || !depths[at].is_finite() {
            return open / all.max(TINY);
        }
        let (here, up) = (point(x, y), normal(at));
        // A neighbour as far above or below the tangent plane as the filter is wide counts no more.
        let reach = (radius as f32 + 1.0) * pixel * depths[at];
        for row in y.saturating_sub(radius)..=(y + radius).min(height - 1) {
            for column in x.saturating_sub(radius)..=(x + radius).min(width - 1) {
                let other = index(column, row);
                if other == at || frame.object[other] != frame.object[at] {
                    continue;
                }
                let height = (point(column, row) - here).dot(up).abs() / reach;
                let alike = normal(other).dot(up).max(0.0).powi(16);
                let weight = alike * (1.0 - height).max(0.0);
                open += sky[other].open * weight;
                all += sky[other].all * weight;
            }
        }
        open / all.max(TINY)
    };
    (0..width).map(|x| sky[index(x, y)].with_share(share(x))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bounces_add_light_up_to_all_of_it_and_black_has_none() {
        let light = |albedo: f32| SkyLight { clear: Vec3::ONE, reflected: Vec3::splat(albedo), ..SkyLight::default() };
        for albedo in [0.0, 0.3, 0.9] {
            let mut last = 0.0;
            for step in 0..=10 {
                let share = step as f32 / 10.0;
                let back = light(albedo).with_share(Vec3::splat(share)).x;
                assert!(
                    back >= albedo * share - 1e-6 && back <= albedo * 1.01 && back >= last,
                    "{albedo} {share} {back}"
                );
                last = back;
            }
            assert_eq!(last, albedo);
        }
        assert_eq!(SkyLight::default().with_share(Vec3::ZERO), Vec3::ZERO);
    }

    #[test]
    fn a_sky_above_black_ground_gives_an_upright_wall_half_of_its_light() {
        let sky = Sky { ground: [0.0; 3], ..Sky::uniform([2.0; 3]) };
        let clear = ClearSky::new(&sky);
        // The haze below the horizon brings a little more than nothing.
        assert!((clear.mean(Vec3::Z) - 2.0).length() < 1e-5);
        assert!((clear.mean(Vec3::X).x - 1.0).abs() < 0.2, "{}", clear.mean(Vec3::X));
        assert!(clear.mean(-Vec3::Z).x < 0.1);
        assert!((ClearSky::new(&Sky::uniform([2.0; 3])).mean(Vec3::X) - 2.0).length() < 1e-5);
    }
}
