//! Paths on a surface: shortest ones, cuts along them, and strips.

pub(crate) mod cut;
pub(crate) mod geodesic;
pub(crate) mod strip;
