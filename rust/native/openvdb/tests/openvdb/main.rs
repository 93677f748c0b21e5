//! Grids of OpenVDB through the module.

mod damaged;
mod edits;
mod files;
mod opening;
mod shapes;
mod surfaces;
