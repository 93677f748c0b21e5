//! What the server simulates: anything that makes one frame after the other and goes on from a frame that was stored.

use std::path::Path;

use relievo_client::{Particles as Wanted, SurfaceForm};
use relievo_core::{Context, Result};
use relievo_particleio::Particles;
use relievo_simulation::Source;

/// What a simulation is opened with.
pub struct Opening<'a> {
    /// The description.
    pub description: &'a str,
    /// The files that it names.
    pub files: Source,
    /// Elements, such as particles, that it may begin with at most. More are refused before they are allocated.
    pub elements: u64,
}

/// A kind of simulation.
pub trait Kind: Send + Sync {
    /// Returns the name by which scenes ask for this kind.
    fn name(&self) -> &'static str;

    /// Opens a simulation at its first frame. Fails where the description or a file cannot be used, or where the simulation
    /// would begin with too many elements.
    fn open(&self, context: &Context, opening: &Opening<'_>) -> Result<Box<dyn Simulation>>;

    /// Returns a description with changed keys. Fails where the changes do not fit it.
    fn change(&self, description: &str, changes: &str) -> Result<String>;

    /// Reads the particles of a frame. Fails where the frame is damaged.
    fn particles(&self, context: &Context, frame: &[u8]) -> Result<Particles>;

    /// Returns those of the particles that are wanted. Fails where the kind has no others than all.
    fn select(&self, context: &Context, particles: &Particles, wanted: Wanted) -> Result<Particles>;

    /// Writes the surface of a frame to the file `to`. `settings` are keys and values in TOML. Fails where the frame is
    /// damaged, a setting is unknown or out of range, or the kind has no surface.
    fn surface(&self, context: &Context, frame: &[u8], wish: (SurfaceForm, &str), to: &Path) -> Result<()>;
}

/// A simulation that makes frames. The same simulation makes the same bytes, whether it went on from a stored frame or not.
pub trait Simulation: Send {
    /// Returns all that decides the bytes of its frames, but not how many there are.
    fn identity(&self) -> &str;

    /// Returns the number of its last frame; the first is 0.
    fn last(&self) -> u64;

    /// Returns the number of the frame that it is at.
    fn frame(&self) -> u64;

    /// Returns how many elements, such as particles, it has.
    fn elements(&self) -> u64;

    /// Returns the bytes that it occupies in memory, estimated.
    fn memory(&self) -> u64;

    /// Goes on from a frame of a simulation with the same, or steered, description. Fails where the frame does not fit.
    fn restore(&mut self, context: &Context, frame: &[u8]) -> Result<()>;

    /// Accelerates each element by so many m/s² on the way to the next frames. Fails if there are not as many as elements.
    fn accelerate(&mut self, accelerations: &[[f32; 3]]) -> Result<()>;

    /// Simulates to the next frame. `watch` hears the part that is done, 0 to 1, and may stop it by an error; after an
    /// error the simulation is not used again.
    fn advance(&mut self, context: &Context, watch: &mut dyn FnMut(f32) -> Result<()>) -> Result<()>;

    /// Returns the frame that it is at, from which it can be restored.
    fn encode(&self, context: &Context) -> Result<Vec<u8>>;
}
