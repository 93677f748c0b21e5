//! Files of pictures, images and textures.

pub(crate) mod exr_file;
pub(crate) mod image_file;
mod output;
pub(crate) mod png_file;
pub(crate) mod texture_file;
