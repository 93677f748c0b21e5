//! The peers of screen-space foam: ray casting through a volume of the particles' density, with absorption and emission
//! alone (Ihmsen et al. 2012, Section 4; Fraedrich et al. 2010 resample to a grid likewise), or with light that is
//! scattered once from a white sky.

use glam::{DVec3, Vec3};
use relievo_core::Context;
use relievo_render::Image;
use relievo_render::foam::{FoamParticle, FoamView};

/// Voxels along the longest side of the volume.
const VOXELS: f32 = 256.0;
/// Steps of a ray in a voxel.
const STEPS: f32 = 2.0;
/// Transmittance below which a ray ends.
const MIN: f32 = 0.005;
/// Voxels between the steps of a ray of light.
const LIGHT_STEP: f32 = 2.0;

/// What light does within foam.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Transport {
    /// It is absorbed, and foam glows white.
    AbsorptionEmission,
    /// It is scattered once, from the sky straight above.
    Scattering,
}

/// A volume of density.
pub struct Volume {
    low: Vec3,
    voxel: f32,
    size: [usize; 3],
    density: Vec<f32>,
}

impl Volume {
    /// Makes the volume of particles of one radius: each adds its cross section to eight voxels.
    pub fn new(particles: &[FoamParticle], radius: f32) -> Self {
        let places = || particles.iter().map(|particle| Vec3::from(particle.position));
        let (low, high) = places().fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(l, h), at| (l.min(at), h.max(at)));
        let voxel = ((high - low).max_element() / VOXELS).max(radius);
        let low = low - Vec3::splat(voxel);
        let size = ((high - low) / voxel + 2.0).to_array().map(|side| side as usize + 1);
        let mut density = vec![0.0; size.iter().product()];
        let section = std::f32::consts::PI * radius * radius / voxel.powi(3);
        for place in places() {
            let at = (place - low) / voxel;
            let (cell, share) = (at.floor(), at - at.floor());
            for corner in 0..8 {
                let step = Vec3::from([0, 1, 2].map(|axis| (corner >> axis & 1) as f32));
                let weight = (step * share + (1.0 - step) * (1.0 - share)).to_array().iter().product::<f32>();
                let [x, y, z] = (cell + step).to_array().map(|index| index as usize);
                density[(z * size[1] + y) * size[0] + x] += weight * section;
            }
        }
        Self { low, voxel, size, density }
    }

    /// Returns the density between voxels, in one over metres.
    fn at(&self, place: Vec3) -> f32 {
        let at = (place - self.low) / self.voxel;
        let cell = at.floor();
        let inside = [0, 1, 2].iter().all(|axis| cell[*axis] >= 0.0 && cell[*axis] + 1.0 < self.size[*axis] as f32);
        if !inside {
            return 0.0;
        }
        let share = at - cell;
        let [x, y, z] = cell.to_array().map(|index| index as usize);
        let start = (z * self.size[1] + y) * self.size[0] + x;
        let row = |from: usize| self.density[from] + share.x * (self.density[from + 1] - self.density[from]);
        let plane = |from: usize| {
            let (near, far) = (row(from), row(from + self.size[0]));
            near + share.y * (far - near)
        };
        let (near, far) = (plane(start), plane(start + self.size[0] * self.size[1]));
        near + share.z * (far - near)
    }

    /// Returns the share of a ray that is left at the border of the volume.
    fn open(&self, from: Vec3, direction: Vec3) -> f32 {
        let step = LIGHT_STEP * self.voxel;
        let high = self.low + self.voxel * Vec3::from(self.size.map(|side| side as f32));
        let (mut depth, mut place) = (0.0, from + step * direction);
        while place.cmpge(self.low).all() && place.cmple(high).all() && depth < 8.0 {
            depth += self.at(place) * step;
            place += step * direction;
        }
        (-depth).exp()
    }

    /// Returns a picture of the volume over black, as a perspective view shows it.
    pub fn render(&self, context: &Context, view: &FoamView, transport: Transport) -> Image {
        let (width, height) = (view.width as usize, view.height as usize);
        let half = (0.5 * view.camera.fov).tan();
        let high = self.low + self.voxel * Vec3::from(self.size.map(|side| side as f32));
        let eye = view.camera.eye.as_vec3();
        let rows = context.map(height, |y| {
            let pixel = |x: usize| {
                let across = (2.0 * (x as f64 + 0.5) - width as f64) / height as f64;
                let along = 1.0 - 2.0 * (y as f64 + 0.5) / height as f64;
                let direction = view.camera.axes * DVec3::new(half * across, half * along, -1.0);
                let direction = direction.normalize().as_vec3();
                let [a, b] = [self.low, high].map(|corner| (corner - eye) / direction);
                let (near, far) = (a.min(b).max_element().max(0.0), a.max(b).min_element());
                let step = self.voxel / STEPS;
                let (mut light, mut left, mut distance) = (0.0, 1.0, near + 0.5 * step);
                while distance < far && left > MIN {
                    let place = eye + distance * direction;
                    let density = self.at(place);
                    if density > 0.0 {
                        let stopped = 1.0 - (-density * step).exp();
                        let source = match transport {
                            Transport::AbsorptionEmission => 1.0,
                            Transport::Scattering => self.open(place, Vec3::Z),
                        };
                        light += left * stopped * source;
                        left *= 1.0 - stopped;
                    }
                    distance += step;
                }
                [light; 3]
            };
            (0..width).flat_map(pixel).collect::<Vec<f32>>()
        });
        Image::from_data(view.width, view.height, 3, rows.concat()).expect("as many numbers as pixels")
    }
}
