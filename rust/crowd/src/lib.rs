//! Crowds of articulated models, each drawn with as many triangles as its pixels deserve in the pose it has now.
//!
//! [`CrowdModel::build`] takes a model with a skeleton and animations and makes a hierarchy of clusters of triangles;
//! [`Crowd::cut`] finds the clusters of every agent that a view draws within an error in pixels. The method is that of
//! view-dependent representations of articulated models (Journal of WSCG 21, 2013):
//!
//! 1. Clips are sampled as poses, and some poses chosen that stand for all (Section 4.1): `representative`.
//! 2. Triangles become clusters whose vertices deform alike (Section 4.2): `deformation`, `partition`.
//! 3. Neighbouring clusters are simplified together over the chosen poses, level upon level (Section 4.3): `grouping`,
//!    `collapse`, `build`. Their errors are measured in all poses.
//! 4. A view draws the coarsest clusters whose errors are no larger than it allows (Section 5.1): `ladder`, `crowd`. Agents
//!    that others hide are left out (Section 5.2): `occlusion`. A graphics device does all of it too: `device`. Where larger
//!    errors may be seen, vertices move from cut to cut: `geomorph`. Agents of a few pixels may be quads: `impostor`. Where bones are
//!    blended as dual quaternions, errors are larger: `dual`.
//!
//! Lengths are units of the model, angles radians, times seconds. Results do not depend on the number of threads.

mod agents;
mod build;
mod character;
mod clip;
mod crowd;
mod device;
mod draws;
mod dual;
mod export;
mod file;
mod geomorph;
mod hierarchy;
mod impostor;
mod ladder;
mod levels;
mod mesh;
mod morph;
mod near;
mod occlusion;
mod sharing;
mod skinning;
mod stream;
mod view;
mod weights;

pub use agents::{Walker, clip_index, parse_agents, parse_walkers, read_walkers, square};
pub use build::refit::Refit;
pub use character::{Bone, Character, Influence, MAX_BONES, MAX_TRIANGLES};
pub use clip::{BoneMatrix, Clip, MAX_POSES, Pose};
pub use crowd::{Agent, Crowd, Drawn, Frame, MAX_AGENTS, PoseKey};
pub use device::{
    DeviceCounted, DeviceCrowd, DeviceDraws, DeviceInstance, DeviceOcclusion, DevicePosed, DevicePoser, DeviceQuads,
    DeviceUnhidden, Look,
};
pub use draws::{Draw, DrawList, Instance};
pub use export::{Exported, LevelSettings, MAX_LEVELS};
pub use file::Reader;
pub use geomorph::Collapse;
pub use hierarchy::{BuildSettings, Cluster, CrowdModel, Distances, Group, NONE, Report, Variant};
pub use impostor::{Impostor, Impostors, SIDE, Texel};
pub use ladder::Ladder;
pub use levels::{Level, Spread};
pub use morph::{MAX_MORPHS, MorphOffset, Morphs};
pub use occlusion::{Culled, Occlusion, PixelView};
pub use skinning::{Blend, dual_rows, skin, skin_normals, skin_some};
pub use stream::{Stream, Streamed};
pub use view::{CrowdView, ShadowSun};
