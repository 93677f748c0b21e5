//! Nouns of crowds, pictures and shaders.

pub mod crowd;
pub mod crowd_stream;
pub mod device_crowd;
pub mod picture;
#[cfg_attr(not(feature = "shader"), path = "scenery/shader_absent.rs")]
pub mod shader;
