//! A rendered picture, and what is behind its pixels.

use crate::image::Image;

/// Object number where there is none.
pub const NO_OBJECT: u32 = u32::MAX;

/// A rendered picture and what is behind its pixels. All but the colour is for the middle of each pixel.
#[derive(Clone, Debug)]
pub struct Frame {
    /// Radiance, scene-linear Rec.709.
    pub color: Image,
    /// Distance along the direction of view, infinite where nothing is hit.
    pub depth: Image,
    /// Unit normal in world space, to the side that is seen; zero where nothing is hit.
    pub normal: Image,
    /// Diffuse reflectance, false colours and lines left out; zero where nothing is hit.
    pub albedo: Image,
    /// Number of the object, [`NO_OBJECT`] where nothing is hit.
    pub object: Vec<u32>,
}
