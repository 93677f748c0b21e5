//! Light: suns, which have a direction and an angular size, and a sky, which lights from everywhere.

use glam::Vec3;
use relievo_core::{Error, Result};

use crate::color::Color;

/// A distant light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sun {
    /// Direction to the light, of any length but zero.
    pub direction: [f32; 3],
    /// Light that arrives on a surface facing it (irradiance): a white diffuse surface then has the radiance
    /// irradiance / π.
    pub irradiance: Color,
    /// Half its angular diameter, radians, 0 to π/2: 0 makes hard shadows, the sun over the Earth has 0.00465.
    pub angular_radius: f32,
}

/// The light of all directions, and the background.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sky {
    /// Direction upwards, of any length but zero.
    pub up: [f32; 3],
    /// Radiance straight above.
    pub zenith: Color,
    /// Radiance at the horizon.
    pub horizon: Color,
    /// Radiance from below.
    pub ground: Color,
}

/// What lights a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Lights {
    /// Distant lights.
    pub suns: Vec<Sun>,
    /// The sky.
    pub sky: Sky,
}

impl Sky {
    /// A sky of the same radiance everywhere.
    pub fn uniform(radiance: Color) -> Self {
        Self { up: [0.0, 0.0, 1.0], zenith: radiance, horizon: radiance, ground: radiance }
    }

    /// Radiance from `direction`; `up` and `direction` have unit length.
    pub(crate) fn radiance(&self, up: Vec3, direction: Vec3) -> Vec3 {
        let height = direction.dot(up);
        let horizon = Vec3::from(self.horizon);
        if height >= 0.0 {
            horizon.lerp(Vec3::from(self.zenith), height.sqrt())
        } else {
            // A narrow band of haze, so that the horizon has no hard edge.
            horizon.lerp(Vec3::from(self.ground), (-8.0 * height).min(1.0))
        }
    }
}

impl Lights {
    /// Checks that every direction has a length and every number is finite and in range.
    ///
    /// # Errors
    /// Fails with `Invalid` if a direction has no length, light is negative or not finite, or an angular radius is not
    /// 0 to π/2.
    pub fn check(&self) -> Result<()> {
        let direction = |v: [f32; 3]| Vec3::from(v).try_normalize().is_some();
        let color = |v: Color| v.iter().all(|value| *value >= 0.0 && value.is_finite());
        for (index, sun) in self.suns.iter().enumerate() {
            let radius = (0.0..=std::f32::consts::FRAC_PI_2).contains(&sun.angular_radius);
            if !(direction(sun.direction) && color(sun.irradiance) && radius) {
                return Err(Error::invalid("its direction, irradiance or angular radius cannot be used")
                    .at(format!("sun {index}"))
                    .advise("use a direction that is not zero, finite light and a radius of 0 to 90 degrees"));
            }
        }
        let sky = &self.sky;
        if !(direction(sky.up) && [sky.zenith, sky.horizon, sky.ground].into_iter().all(color)) {
            return Err(Error::invalid("the sky's up direction or radiance cannot be used")
                .advise("use a direction that is not zero and finite light"));
        }
        Ok(())
    }
}

impl Default for Lights {
    /// A low warm sun and a blue sky over z-up ground: dents read well in it.
    fn default() -> Self {
        Self {
            suns: vec![Sun { direction: [-0.55, -0.45, 0.5], irradiance: [2.6, 2.35, 2.0], angular_radius: 0.015 }],
            sky: Sky {
                up: [0.0, 0.0, 1.0],
                zenith: [0.16, 0.26, 0.45],
                horizon: [0.50, 0.56, 0.62],
                ground: [0.20, 0.19, 0.18],
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_default_is_valid_and_bad_lights_are_refused() {
        assert_eq!(Lights::default().check(), Ok(()));
        let mut lights = Lights::default();
        lights.suns[0].direction = [0.0; 3];
        assert!(lights.check().unwrap_err().to_string().contains("sun 0"));
        let mut lights = Lights::default();
        lights.sky.zenith[1] = f32::NAN;
        assert!(lights.check().is_err());
    }
}
