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

    /// Opens a simulation at its first frame.
    ///
    /// # Errors
    /// Fails with `Invalid` if the description or a file that it names cannot be used, with `NotFound` if there is no
    /// such file, with `Unsupported` if it asks for what the kind does not simulate, and with `Memory` if the
    /// simulation would begin with too many elements.
    fn open(&self, context: &Context, opening: &Opening<'_>) -> Result<Box<dyn Simulation>>;

    /// Returns a description with changed keys.
    ///
    /// # Errors
    /// Fails with `Invalid` if the changes are not TOML or do not fit the description.
    fn change(&self, description: &str, changes: &str) -> Result<String>;

    /// Reads the particles of a frame.
    ///
    /// # Errors
    /// Fails with `Invalid` if the frame is damaged, with `Unsupported` if it is of a newer version, and with `Memory`
    /// if it needs more than the context's memory limit.
    fn particles(&self, context: &Context, frame: &[u8]) -> Result<Particles>;

    /// Returns those of the particles that are wanted.
    ///
    /// # Errors
    /// Fails with `Unsupported` if the kind has no others than all, and with `Invalid` if the particles do not say
    /// their spacing.
    fn select(&self, context: &Context, particles: &Particles, wanted: Wanted) -> Result<Particles>;

    /// Writes the surface of a frame to the file `to`. `settings` are keys and values in TOML.
    ///
    /// # Errors
    /// Fails as [`Self::particles`], with `Invalid` if a setting is unknown or out of range, with `Unsupported` if the
    /// kind has no such surface, with `Memory` if the surface needs more than the context's memory limit, and with
    /// `NotFound` or `Io` if the file cannot be written.
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

    /// Goes on from a frame of a simulation with the same, or steered, description.
    ///
    /// # Errors
    /// Fails as [`Kind::particles`], and with `Invalid` if the frame does not fit or has no state to go on from.
    fn restore(&mut self, context: &Context, frame: &[u8]) -> Result<()>;

    /// Accelerates each element by so many m/s² on the way to the next frames.
    ///
    /// # Errors
    /// Fails with `Invalid` if there are not as many as elements or a number is not finite, and with `Unsupported` if
    /// the kind takes none.
    fn accelerate(&mut self, accelerations: &[[f32; 3]]) -> Result<()>;

    /// Simulates to the next frame. `watch` hears the part that is done, 0 to 1, and may stop it by an error; after an
    /// error the simulation is not used again.
    ///
    /// # Errors
    /// Fails with the error of `watch`, and with the error of the solver where a step cannot be made: it does not
    /// converge, an element is where none can be, a file of a moving body cannot be read, or a graphics device is lost
    /// or has no memory.
    fn advance(&mut self, context: &Context, watch: &mut dyn FnMut(f32) -> Result<()>) -> Result<()>;

    /// Returns the frame that it is at, from which it can be restored.
    ///
    /// # Errors
    /// Fails with `Invalid` if a number of the frame is not finite, and with `Unsupported` if it has more elements than
    /// a file can hold.
    fn encode(&self, context: &Context) -> Result<Vec<u8>>;
}
