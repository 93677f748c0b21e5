//! Reference ray caster, images and image comparison.

mod camera;
mod caster;
pub mod color;
mod image;
mod light;
mod sampling;
mod scene;
mod settings;

pub use camera::Camera;
pub use caster::{Frame, NO_OBJECT};
pub use image::Image;
pub use light::{Lights, Sky, Sun};
pub use scene::{Material, Mesh, ObjectId, Scene};
pub use settings::{FalseColor, Settings, View};
