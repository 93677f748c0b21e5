//! The methods of the protocol: their names, parameters, results and limits. `docs/protocol.md` is their manual.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::chunk::Packing;
use crate::hash::Hash;

/// Version of the protocol. A server and a client whose first numbers agree understand each other.
pub const VERSION: [u32; 2] = [1, 1];
/// Bytes of a message at most.
pub const MAX_MESSAGE: usize = 16 << 20;
/// Bytes of a message at most before the server has accepted a token.
pub const MAX_GREETING: usize = 4096;
/// Lists and maps within each other in a message at most.
pub const MAX_DEPTH: usize = 16;
/// Bytes of the settings of a surface at most.
pub const MAX_SETTINGS: usize = 4096;
/// Bytes of a part of a file in a message at most.
pub const MAX_PART: usize = 4 << 20;
/// Particles of a chunk of a frame at most.
pub const MAX_CHUNK: u32 = 1 << 17;
/// Bytes of the name of a scene at most.
pub const MAX_NAME: usize = 128;
/// Seconds that a call to `scene.wait` waits at most.
pub const MAX_WAIT: f64 = 30.0;

/// Parameters or a result without content.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub struct Nothing {}

/// Parameters of `hello`, the first call on each connection.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Hello {
    /// The protocol that the client speaks.
    pub version: [u32; 2],
    /// The name of the client, for the log.
    #[serde(default)]
    pub client: String,
    /// The user's token; empty where the server has no token file.
    #[serde(default)]
    pub token: String,
}

/// Result of `hello`.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Welcome {
    /// The protocol that the server speaks.
    pub version: [u32; 2],
    /// The name and version of the server.
    pub server: String,
    /// The user that the token belongs to.
    pub user: String,
    /// The kinds of simulations that the server makes.
    #[serde(default)]
    pub kinds: Vec<String>,
}

/// A file of a scene by the name that its description gives it.
pub type FileMap = BTreeMap<String, Hash>;

/// Parameters of `file.missing`, and its result: the files that the server lacks.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct FileList {
    /// Files by their names. Of a name only the extension counts.
    pub files: FileMap,
}

/// Parameters of `file.put`.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct FilePut {
    /// The name of the file, of which the extension counts.
    pub name: String,
    /// The hash of the whole file.
    pub hash: Hash,
    /// Bytes of the whole file.
    pub size: u64,
    /// Where the part lies in the file. Parts come in order, from 0 on.
    pub offset: u64,
    /// The bytes of the part.
    #[serde(with = "serde_bytes")]
    pub data: Vec<u8>,
}

/// Result of `file.put`.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct FilePutResult {
    /// Bytes of the file that the server has; the next part begins there.
    pub received: u64,
}

/// Parameters of `scene.submit`.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Submit {
    /// The name of the scene among those of the user. Submitting the same content under the same name again changes
    /// nothing.
    pub scene: String,
    /// The kind of the simulation: `fluid` or `foam`.
    pub kind: String,
    /// The description: of a fluid, the text that `relievo fluid sim` reads; of foam, that text with a table `foam`.
    pub description: String,
    /// The files that the description names.
    #[serde(default)]
    pub files: FileMap,
    /// Whether the simulation waits for accelerations by the host before each frame.
    #[serde(default)]
    pub forced: bool,
}

/// Parameters of `scene.status`, `scene.pause`, `scene.resume`, `scene.cancel` and `scene.remove`.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct SceneName {
    /// The name of the scene.
    pub scene: String,
}

/// What a scene is doing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Activity {
    /// Frames are computed, or will be when it is the scene's turn.
    #[default]
    Running,
    /// The next frame waits for accelerations by the host.
    Forces,
    /// Paused by the user.
    Paused,
    /// All frames are there.
    Done,
    /// Cancelled by the user.
    Cancelled,
    /// The simulation failed.
    Failed,
}

/// Result of `scene.submit`, `scene.status`, `scene.wait` and the other methods of a scene.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Status {
    /// The name of the scene.
    pub scene: String,
    /// What it is doing.
    pub state: Activity,
    /// Frames that are stored, from frame 0 on.
    pub ready: u64,
    /// Frames that there will be: the first and those of the description.
    pub frames: u64,
    /// The part of the frame after them that is computed.
    pub fraction: f32,
    /// Estimated seconds of computation until the last frame; absent until a frame was computed.
    pub seconds_left: Option<f64>,
    /// Particles in the last frame.
    pub particles: u64,
    /// Why the simulation failed.
    pub error: Option<crate::message::Failure>,
}

/// Result of `scene.list`.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct SceneList {
    /// The scenes of the user by name.
    pub scenes: Vec<Status>,
}

/// Parameters of `scene.wait`.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Wait {
    /// The name of the scene.
    pub scene: String,
    /// The call returns as soon as this frame is stored, or the scene stops.
    pub frame: u64,
    /// Seconds after which it returns at the latest; [`MAX_WAIT`] at most.
    pub seconds: f64,
}

/// Parameters of `scene.steer`.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Steer {
    /// The name of the scene.
    pub scene: String,
    /// The last frame that stays; those after it are computed anew.
    pub frame: u64,
    /// Keys of the description with their new values, in the format of the description.
    pub changes: String,
}

/// Parameters of `scene.force`.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Force {
    /// The name of the scene.
    pub scene: String,
    /// The frame whose particles are accelerated on their way to the next frame.
    pub frame: u64,
    /// The first particle of this part, in the order of the frame.
    pub first: u64,
    /// Accelerations in m/s² of particles: three floats each, little-endian. Parts come in order.
    #[serde(with = "serde_bytes")]
    pub accelerations: Vec<u8>,
}

/// Parameters of `frame.info`.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct FrameName {
    /// The name of the scene.
    pub scene: String,
    /// The number of the frame; 0 is the first.
    pub frame: u64,
}

/// A channel of a frame.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ChannelInfo {
    /// The name: `position`, `velocity`, `number`, or that of a channel of the simulation.
    pub name: String,
    /// Numbers per particle.
    pub width: u32,
}

/// Result of `frame.info`.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct FrameInfo {
    /// Particles.
    pub count: u64,
    /// Seconds since the beginning of the simulation.
    pub seconds: f64,
    /// Metres between particles at rest.
    pub spacing: f32,
    /// What the particles carry.
    pub channels: Vec<ChannelInfo>,
    /// The key of the frame in the server's cache: frames with the same key are the same to the bit.
    pub key: String,
    /// Bytes of the frame's file.
    pub bytes: u64,
}

/// Which particles are fetched.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Particles {
    /// All.
    #[default]
    All,
    /// Those at the surface, and blind ones beside them (Morgenroth et al. 2013, Section 4.3). A channel `blind` is 1 for
    /// these and 0 for those at the surface.
    Blind,
    /// Those at the surface.
    Surface,
}

/// Parameters of `frame.fetch`.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Fetch {
    /// The name of the scene.
    pub scene: String,
    /// The number of the frame.
    pub frame: u64,
    /// The first particle.
    #[serde(default)]
    pub first: u64,
    /// Particles at most; [`MAX_CHUNK`] at most.
    #[serde(default)]
    pub count: u32,
    /// The channels to send; all where the list is empty.
    #[serde(default)]
    pub channels: Vec<String>,
    /// Which particles.
    #[serde(default)]
    pub particles: Particles,
    /// How numbers are packed.
    #[serde(default)]
    pub packing: Packing,
    /// Whether positions become 16-bit fractions of the chunk's box and other floats halves.
    #[serde(default)]
    pub half: bool,
    /// Whether numbers are stored as differences from the particle before, which pack better.
    #[serde(default)]
    pub differences: bool,
}

/// Parameters of `frame.file`.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct FilePart {
    /// The name of the scene.
    pub scene: String,
    /// The number of the frame.
    pub frame: u64,
    /// Where the part begins in the file.
    pub offset: u64,
    /// Bytes at most; [`MAX_PART`] at most.
    pub length: u32,
}

/// What the server makes of the surface of a frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum SurfaceForm {
    /// A mesh of triangles, in binary PLY.
    #[default]
    Mesh,
    /// A level set, in OpenVDB's format.
    LevelSet,
}

/// Parameters of `frame.surface`, whose result is that of `frame.file`.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct SurfacePart {
    /// The name of the scene.
    pub scene: String,
    /// The number of the frame.
    pub frame: u64,
    /// What is made.
    #[serde(default)]
    pub form: SurfaceForm,
    /// Keys and values of the kind of the simulation, in TOML; [`MAX_SETTINGS`] bytes at most.
    #[serde(default)]
    pub settings: String,
    /// Where the part begins in the file.
    pub offset: u64,
    /// Bytes at most; [`MAX_PART`] at most.
    pub length: u32,
}

/// Result of `frame.file` and `frame.surface`.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct FilePartResult {
    /// Bytes of the whole file.
    pub size: u64,
    /// The key of the file in the server's cache. Parts with other keys are of other files.
    #[serde(default)]
    pub key: String,
    /// The bytes of the part.
    #[serde(with = "serde_bytes")]
    pub data: Vec<u8>,
}

/// Result of `stats`.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Stats {
    /// Counters and gauges by their Prometheus names.
    pub values: BTreeMap<String, f64>,
}
