//! A brush: an oriented box, which bounds what it reaches, and a function of the place in the box.
//!
//! Schäfer, Keinert, Nießner and Stamminger 2015, Local Painting and Deformation of Meshes on the GPU, Section 3. The
//! third axis of the box points out of the surface. Units: world units.

use glam::{DAffine3, DMat3, DVec3};
use relievo_core::{Error, Result};

use crate::geometry::obb::Obb;
use crate::paint::smudge::Smudge;
use crate::paint::stamp::Stamp;
use relievo_core::Falloff;

/// A box with a function: a formula, times an image if it has one.
#[derive(Clone, Debug, PartialEq)]
pub struct Brush {
    obb: Obb,
    falloff: Falloff,
    stamp: Option<Stamp>,
    smudge: Option<Smudge>,
}

/// How far the axes may be from orthonormal.
const TOLERANCE: f64 = 1e-6;
/// The largest ratio between half extents, beyond which single precision cannot hold the box.
const SLENDER: f64 = 1e6;

impl Brush {
    /// A brush around `center` with the directions `axes` as columns and half extents `half` along them.
    ///
    /// # Errors
    /// Fails with `Invalid` if a number is not finite, the axes are not orthonormal and right-handed, or an extent is
    /// not positive, over a million times smaller than another, or outside 1e-12 to 1e12.
    pub fn new(center: DVec3, axes: DMat3, half: DVec3, falloff: Falloff) -> Result<Self> {
        let fault = |what: &str, remedy: &str| Err(Error::invalid(what).at("brush").advise(remedy));
        if !(center.is_finite() && axes.is_finite() && half.is_finite()) {
            return fault("its box is not finite", "give finite numbers");
        }
        let off = (axes.transpose() * axes - DMat3::IDENTITY).to_cols_array();
        if off.iter().any(|value| value.abs() > TOLERANCE) || axes.determinant() < 0.0 {
            return fault("its axes are not orthonormal and right-handed", "give three unit vectors at right angles");
        }
        if half.min_element() <= 0.0 || half.max_element() > SLENDER * half.min_element() {
            return fault("its box is degenerate", "give positive half extents of similar size");
        }
        if half.max_element() > 1e12 || half.min_element() < 1e-12 {
            return fault("its box is too large or too small", "use half extents from 1e-12 to 1e12");
        }
        Ok(Self { obb: Obb { center, axes, half }, falloff, stamp: None, smudge: None })
    }

    /// A brush at a point of a surface: its third axis is the `normal`, its first as near to `along` as that allows.
    ///
    /// # Errors
    /// Fails as [`Self::new`], and with `Invalid` if the normal is zero or not finite.
    pub fn on_surface(point: DVec3, normal: DVec3, along: DVec3, half: DVec3, falloff: Falloff) -> Result<Self> {
        let up = normal.try_normalize().ok_or_else(|| Error::invalid("its normal has no direction").at("brush"))?;
        let across = up.cross(along.normalize_or_zero());
        let y = if across.length() > 1e-6 { across.normalize() } else { up.any_orthonormal_vector() };
        Self::new(point, DMat3::from_cols(y.cross(up), y, up), half, falloff)
    }

    /// The same with an image.
    pub fn with_stamp(self, stamp: Stamp) -> Self {
        Self { stamp: Some(stamp), ..self }
    }

    /// The same with what it carries while it smears.
    pub(crate) fn with_smudge(self, smudge: Smudge) -> Self {
        Self { smudge: Some(smudge), ..self }
    }

    /// What it carries while it smears.
    pub(crate) fn smudge(&self) -> Option<&Smudge> {
        self.smudge.as_ref()
    }

    /// The same turned about its third axis by `angle` radians, from the first axis to the second.
    pub fn turned(mut self, angle: f64) -> Self {
        if angle != 0.0 {
            self.obb.axes *= DMat3::from_rotation_z(angle);
        }
        self
    }

    /// The image.
    pub fn stamp(&self) -> Option<&Stamp> {
        self.stamp.as_ref()
    }

    /// The box.
    pub fn obb(&self) -> &Obb {
        &self.obb
    }

    /// The directions of the box, as columns.
    pub fn axes(&self) -> &DMat3 {
        &self.obb.axes
    }

    /// The function.
    pub fn falloff(&self) -> Falloff {
        self.falloff
    }

    /// From the world to the brush's coordinates, −1 to 1 in the box.
    pub fn map(&self) -> DAffine3 {
        let matrix = DMat3::from_diagonal(self.obb.half.recip()) * self.obb.axes.transpose();
        DAffine3 { matrix3: matrix, translation: -(matrix * self.obb.center) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_brush_maps_its_box_to_the_unit_cube() {
        let axes = DMat3::from_euler(glam::EulerRot::XYZ, 0.3, -1.2, 2.0);
        let half = DVec3::new(2.0, 0.5, 0.25);
        let brush = Brush::new(DVec3::new(5.0, -3.0, 1.0), axes, half, Falloff::Linear).unwrap();
        for corner in brush.obb().corners() {
            assert!((brush.map().transform_point3(corner).abs() - 1.0).abs().max_element() < 1e-12);
        }
    }

    #[test]
    fn a_turn_goes_from_the_first_axis_to_the_second() {
        let brush = Brush::new(DVec3::ZERO, DMat3::IDENTITY, DVec3::ONE, Falloff::Linear).unwrap();
        assert_eq!(brush.clone().turned(0.0).obb(), brush.obb());
        let turned = brush.turned(std::f64::consts::FRAC_PI_2);
        assert!((turned.obb().axes.x_axis - DVec3::Y).length() < 1e-12);
    }

    #[test]
    fn a_brush_on_a_surface_stands_on_its_normal() {
        let normal = DVec3::new(0.3, -0.2, 2.0);
        for along in [DVec3::X, DVec3::Z, DVec3::ZERO, normal] {
            let brush = Brush::on_surface(DVec3::ONE, normal, along, DVec3::ONE, Falloff::Smooth).unwrap();
            assert!((brush.obb().axes.z_axis - normal.normalize()).length() < 1e-12);
        }
        let brush = Brush::on_surface(DVec3::ONE, DVec3::Z, DVec3::new(1.0, 1.0, 9.0), DVec3::ONE, Falloff::Smooth);
        assert!((brush.unwrap().obb().axes.x_axis - DVec3::new(0.5, 0.5, 0.0).normalize()).length() < 1e-12);
    }

    #[test]
    fn brushes_that_cannot_be_are_refused() {
        let unit = DMat3::IDENTITY;
        let skew = DMat3::from_cols(DVec3::X, DVec3::new(0.1, 1.0, 0.0).normalize(), DVec3::Z);
        let mirrored = DMat3::from_cols(DVec3::X, DVec3::Y, DVec3::NEG_Z);
        let nan = DVec3::splat(f64::NAN);
        let cases = [
            (nan, unit, DVec3::ONE),
            (DVec3::ZERO, unit, nan),
            (DVec3::ZERO, DMat3::from_cols(nan, DVec3::Y, DVec3::Z), DVec3::ONE),
            (DVec3::ZERO, skew, DVec3::ONE),
            (DVec3::ZERO, mirrored, DVec3::ONE),
            (DVec3::ZERO, 2.0 * unit, DVec3::ONE),
            (DVec3::ZERO, unit, DVec3::new(1.0, 0.0, 1.0)),
            (DVec3::ZERO, unit, DVec3::new(1.0, -1.0, 1.0)),
            (DVec3::ZERO, unit, DVec3::new(1.0, 1e-9, 1.0)),
            (DVec3::ZERO, unit, DVec3::splat(1e300)),
        ];
        for (center, axes, half) in cases {
            assert!(Brush::new(center, axes, half, Falloff::Constant).is_err(), "{center} {axes} {half}");
        }
        assert!(Brush::on_surface(DVec3::ONE, DVec3::ZERO, DVec3::X, DVec3::ONE, Falloff::Smooth).is_err());
    }
}
