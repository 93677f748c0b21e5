//! What a fluid meets: walls of particles, colliders, rigid bodies, and the momentum that they exchange with it.

#[cfg(feature = "rapier3d")]
pub(crate) mod body;
#[cfg(not(feature = "rapier3d"))]
pub(crate) mod body_absent;
pub(crate) mod body_state;
pub(crate) mod collider;
pub(crate) mod exchange;
pub(crate) mod lattice;
#[cfg(feature = "rapier3d")]
mod obstacle;
pub(crate) mod sampling;
pub(crate) mod sweep;
pub(crate) mod wall;
