//! Screen-space foam: particles of spray, foam and bubbles composited over a finished picture (Akinci, Dippel, Akinci,
//! Teschner 2013, *Screen Space Foam Rendering*, Section 2).
//!
//! Seven passes make the layers of a picture: [`Scenery`] holds the depths of solids and of the fluid (passes 1 and 2);
//! [`Foam::add`] splats particles into the depth of the nearest one (pass 3, `depth`) and into thickness (pass 4,
//! `thickness`); [`Foam::finish`] turns thickness into intensity (pass 5, `intensity`) and finds occlusion and irradiance
//! (pass 6, `occlusion` and `irradiance`); [`FoamLayers::composite`] filters both and lays the foam over a picture
//! (pass 7, `composition`). [`Extinction`] is for renderers that draw foam as a medium themselves.
//!
//! The processor does all passes, and so do graphics devices ([`Foam::on`], `device`), with the same picture but for the last
//! bits of numbers.
//!
//! Particles come in chunks of any size and in any order. The layers have the same bits for any order and any number of
//! threads, because the nearest particle is found by depth and then number, and thickness is summed in fixed point.
//! Depths are metres along the direction of view, larger farther away and infinite where nothing is, as in
//! [`crate::Frame`].

mod bins;
mod composition;
mod depth;
mod device;
mod environment;
mod extinction;
mod falloff;
mod halton;
mod intensity;
mod irradiance;
mod layers;
mod occlusion;
mod projection;
mod scenery;
mod settings;
mod splatting;
mod thickness;

pub use depth::radius;
pub use environment::Environment;
pub use extinction::Extinction;
pub use falloff::falloff;
pub use intensity::intensity;
pub use layers::FoamLayers;
pub use projection::{FoamView, Lens};
pub use scenery::Scenery;
pub use settings::FoamSettings;
pub use splatting::Foam;

/// The kind of a particle of foam, which decides its size and its falloff.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(u32)]
pub enum FoamKind {
    /// Flies through air.
    Spray = 0,
    /// Floats on the surface.
    #[default]
    Foam = 1,
    /// Rises within the fluid.
    Bubble = 2,
}

/// A particle of foam.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C)]
pub struct FoamParticle {
    /// Position in the world, in metres.
    pub position: [f32; 3],
    /// The share of its life that has passed, 0 to 1.
    pub life: f32,
    /// Its number, of which its size depends.
    pub id: u32,
    /// Its kind.
    pub kind: FoamKind,
}
