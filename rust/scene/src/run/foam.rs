//! Foam of fluids in scenes: `[objects.NAME.fluid.foam]`. It is generated from the files of the object's mesh, frame after
//! frame, and laid over pictures of the scene (Ihmsen et al. 2012; Akinci et al. 2013).

mod cache;
mod entry;
mod frame;
mod overlay;
mod run;

pub use cache::Identity;
pub(crate) use cache::truncate;
pub use entry::FoamEntry;
pub(crate) use entry::read_foam;
pub use frame::{add_frame, for_each_part};
pub(crate) use overlay::Overlay;

/// The parameters of particles of foam.
pub(crate) const PARAMETERS: &[relievo_core::Parameter] = relievo_fluid::DiffuseSettings::PARAMETERS;
