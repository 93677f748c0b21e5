//! What comes of a world: meshes, tiles, pictures, and scenes for other renderers.

pub(crate) mod blender;
#[cfg(feature = "fluid")]
pub mod df3;
pub mod export;
pub(crate) mod forecast;
pub mod output;
#[cfg(feature = "decal")]
pub mod overlap;
pub mod picture;
pub(crate) mod pictures;
pub mod povray;
#[cfg_attr(not(feature = "fluid"), path = "out/povray_fluid_absent.rs")]
pub(crate) mod povray_fluid;
pub mod showing;
pub mod stages;
pub mod tessellation;
