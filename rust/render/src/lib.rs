//! Reference ray caster, rasteriser of virtual vertices, screen-space foam, images, and the geometry behind two pictures
//! compared.

mod camera;
mod caster;
mod chromaticities;
pub mod color;
mod dielectric;
mod facet;
mod files;
pub mod foam;
mod frame;
mod geometry;
mod gloss;
mod image;
mod implicit;
mod legend;
mod light;
mod picture;
mod sampling;
mod scene;
mod settings;
mod sheet;
mod sky;
mod tracing;
#[cfg_attr(not(feature = "wgpu"), allow(dead_code, reason = "only the rasteriser reads some of it"))]
pub mod virtual_vertex;

pub use camera::Camera;
pub use chromaticities::{Chromaticities, REC_709};
pub use dielectric::Dielectric;
pub use files::exr_file::{Channel, Content, Layer, Samples, Value, decode_exr, read_exr, write_exr};
pub use files::image_file::read_image;
pub use files::png_file::{decode_png, read_png, write_png};
pub use files::texture_file::{Depth, Texture, write_texture};
pub use frame::{Frame, NO_OBJECT};
pub use geometry::{GeometryDifference, Quantiles, compare_geometry};
pub use image::Image;
pub use implicit::{Implicit, ImplicitHit, ImplicitRay, ImplicitTracer};
pub use legend::{draw_legend, draw_text};
pub use light::{Lights, Sky, Sun};
pub use picture::{Picture, angle, check_sizes};
pub use scene::{Material, Mesh, ObjectId, Scene};
pub use settings::{FalseColor, Settings, View};
pub use sheet::{Row, contact_sheet};
