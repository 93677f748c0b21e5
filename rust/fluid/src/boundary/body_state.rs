//! Options and states of rigid bodies in a fluid.

use glam::{DVec3, Quat, Vec3};

use crate::Contact;

/// What a body is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BodyOptions {
    /// kg/m³; positive.
    pub density: f32,
    /// m/s
    pub velocity: Vec3,
    /// An axis as long as the speed of the turn, in rad/s.
    pub spin: Vec3,
    /// What becomes of particles that meet it.
    pub contact: Contact,
}

impl Default for BodyOptions {
    fn default() -> Self {
        Self { density: 500.0, velocity: Vec3::ZERO, spin: Vec3::ZERO, contact: Contact::Slip }
    }
}

/// Where a body is, and how it moves.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BodyState {
    /// How it is turned about the origin from where it began, and by how many metres it has moved then.
    pub pose: (Quat, Vec3),
    /// Of its centre, in m/s.
    pub velocity: Vec3,
    /// In rad/s.
    pub spin: Vec3,
    /// Momentum, and that about its centre, which it is yet to get, in kg m/s and kg m²/s.
    pub due: [DVec3; 2],
}

impl BodyState {
    #[cfg(feature = "rapier3d")]
    pub(crate) fn is_sound(&self) -> bool {
        let (turn, moved) = self.pose;
        let is_finite = moved.is_finite() && self.velocity.is_finite() && self.spin.is_finite();
        is_finite && turn.is_normalized() && self.due.iter().all(|due| due.is_finite())
    }
}
