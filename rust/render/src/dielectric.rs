//! Bodies that light goes through: how much a surface reflects (Fresnel's equations), where the rest goes (Snell's law),
//! and what a body leaves of it (Beer's and Lambert's law). Bodies are closed; one within another is not known of.

use glam::Vec3;
use relievo_core::{Error, Result};

use crate::color::Color;

/// What is within a body that light goes through.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dielectric {
    /// Index of refraction by that of what is around it, 1 to 4; water has 1.33.
    pub index: f32,
    /// How much is absorbed: over a world unit exp(−absorption) of the light is left; 0 to 1e6.
    pub absorption: Color,
}

impl Dielectric {
    /// Clear water, where a world unit is a metre.
    pub const WATER: Self = Self { index: 1.333, absorption: [0.45, 0.09, 0.06] };

    /// Checks that the numbers are in range.
    ///
    /// # Errors
    /// Fails with `Invalid` if the index of refraction is not 1 to 4, or an absorption is not 0 to 1e6.
    pub fn check(&self) -> Result<()> {
        let absorbs = |value: f32| (0.0..=1e6).contains(&value);
        if (1.0..=4.0).contains(&self.index) && self.absorption.into_iter().all(absorbs) {
            return Ok(());
        }
        Err(Error::invalid("a dielectric's index of refraction or absorption is out of range")
            .advise("use an index of 1 to 4, and absorption of 0 to 1e6"))
    }

    /// What is left of light after a length within, in world units.
    pub(crate) fn left(&self, length: f32) -> Vec3 {
        (Vec3::from(self.absorption) * -length).exp()
    }

    /// What of straight light a surface lets through, either way: bent light leaves at the angle that straight light has
    /// outside, so nothing is reflected in whole.
    pub(crate) fn through(&self, cos: f32) -> f32 {
        1.0 - fresnel(cos.abs(), self.index)
    }
}

/// The share of unpolarised light that is reflected, where `cos` is of the angle to the normal and `index` that of what
/// is behind the surface by that of what is before it.
pub(crate) fn fresnel(cos: f32, index: f32) -> f32 {
    let square = index * index - 1.0 + cos * cos;
    if square <= 0.0 {
        return 1.0;
    }
    let behind = square.sqrt();
    let across = (cos - behind) / (cos + behind);
    let along = (index * index * cos - behind) / (index * index * cos + behind);
    0.5 * (across * across + along * along)
}

/// The unit direction behind a surface of light of a unit direction; `normal` is to the side it comes from. None where
/// all is reflected.
pub(crate) fn refract(direction: Vec3, normal: Vec3, index: f32) -> Option<Vec3> {
    let cos = -direction.dot(normal);
    let square = index * index - 1.0 + cos * cos;
    (square > 0.0).then(|| ((direction + normal * (cos - square.sqrt())) / index).normalize())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn light_is_bent_by_snells_law_and_reflected_by_fresnels_equations() {
        // Straight on, at the angle of Brewster, along the surface, and beyond the angle of total reflection.
        assert!((fresnel(1.0, 1.5) - 0.04).abs() < 1e-6 && (fresnel(0.0, 1.5) - 1.0).abs() < 1e-6);
        let brewster = 1.5f32.atan();
        let across = ((brewster.cos() - 1.5 * brewster.sin()) / (brewster.cos() + 1.5 * brewster.sin())).powi(2);
        let behind = (1.0 - (brewster.sin() / 1.5).powi(2)).sqrt();
        let across_by_definition = ((brewster.cos() - 1.5 * behind) / (brewster.cos() + 1.5 * behind)).powi(2);
        assert!((fresnel(brewster.cos(), 1.5) - 0.5 * across_by_definition).abs() < 1e-6, "{across}");
        assert_eq!(fresnel(0.3, 1.0 / 1.5), 1.0);
        assert_eq!(refract(Vec3::new(0.9, 0.0, -0.19f32.sqrt()), Vec3::Z, 1.0 / 1.5), None);
        for sine in [0.0f32, 0.2, 0.6] {
            let direction = Vec3::new(sine, 0.0, -(1.0 - sine * sine).sqrt());
            let bent = refract(direction, Vec3::Z, 1.5).unwrap();
            assert!((bent.x - sine / 1.5).abs() < 1e-6 && bent.z < 0.0);
            let back = refract(bent, Vec3::Z, 1.0 / 1.5).unwrap();
            assert!((back - direction).length() < 1e-6);
            let [out, into] = [fresnel(-direction.z, 1.5), fresnel(-bent.z, 1.0 / 1.5)];
            assert!((out - into).abs() < 1e-6, "the same from both sides");
        }
    }
}
