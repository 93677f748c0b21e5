//! Placements of objects in a scene, and the axis of it that points up.

use glam::{DAffine3, DMat3, DVec3};

use crate::format::reader::{Reader, Table};

/// The axis that points up.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Up {
    /// x
    X,
    /// y
    Y,
    /// z
    Z,
}

impl Up {
    /// The direction.
    pub fn direction(self) -> DVec3 {
        match self {
            Up::X => DVec3::X,
            Up::Y => DVec3::Y,
            Up::Z => DVec3::Z,
        }
    }

    /// The rotation that brings what stands on y to the scene's.
    pub fn from_y_up(self) -> DMat3 {
        let turn = |up: Self| {
            let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
            DMat3::from_cols_array_2d(&axes.map(|axis| up.from_z_up(axis).map(f64::from)))
        };
        turn(self) * turn(Self::Y).transpose()
    }

    /// Takes a vector from a frame in which z is up to the scene's, by a rotation.
    pub fn from_z_up(self, v: [f32; 3]) -> [f32; 3] {
        match self {
            Up::X => [v[2], v[0], v[1]],
            Up::Y => [v[0], v[2], -v[1]],
            Up::Z => v,
        }
    }
}

/// Where an object is: scale, then shear, then rotation about x, y and z, then translation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placement {
    /// Where its origin is.
    pub translation: DVec3,
    /// Turn about x, then y, then z, radians; more than a turn is kept for keyframes.
    pub rotation: DVec3,
    /// Size along its own axes.
    pub scale: DVec3,
    /// How far x goes along with y, x with z, and y with z.
    pub shear: DVec3,
}

impl Placement {
    /// The rotation as a quaternion.
    pub fn quaternion(&self) -> glam::DQuat {
        glam::DQuat::from_rotation_z(self.rotation.z)
            * glam::DQuat::from_rotation_y(self.rotation.y)
            * glam::DQuat::from_rotation_x(self.rotation.x)
    }

    /// Scale and shear: the transform before rotation and translation.
    pub fn stretch(&self) -> DMat3 {
        let [xy, xz, yz] = self.shear.to_array();
        let shear = DMat3::from_cols(DVec3::X, DVec3::new(xy, 1.0, 0.0), DVec3::new(xz, yz, 1.0));
        shear * DMat3::from_diagonal(self.scale)
    }

    /// The transform from object to world.
    pub fn transform(&self) -> DAffine3 {
        let matrix3 = DMat3::from_quat(self.quaternion()) * self.stretch();
        DAffine3 { matrix3, translation: self.translation }
    }
}

pub(crate) fn read_placement(reader: &mut Reader, table: Table, before: Placement) -> Placement {
    Placement {
        translation: reader.optional_vector(table, "translation").map_or(before.translation, DVec3::from),
        rotation: reader
            .optional_vector(table, "rotation")
            .map_or(before.rotation, |turn| DVec3::from(turn.map(f64::to_radians))),
        scale: reader.scale(table, "scale").map_or(before.scale, DVec3::from),
        shear: reader.optional_vector(table, "shear").map_or(before.shear, DVec3::from),
    }
}

pub(crate) const AT_ORIGIN: Placement =
    Placement { translation: DVec3::ZERO, rotation: DVec3::ZERO, scale: DVec3::ONE, shear: DVec3::ZERO };
