//! Stickers of the decals of a scene, cut out of their images.

use relievo_core::{Context, Result};
use relievo_decal::{Artwork, Contour, Sticker};
use relievo_render::{Image, read_image};

use crate::format::description::DecalEntry;
use crate::state::paths::Paths;

/// The sticker of a decal with its image, and a number for what its pixels are.
#[derive(Debug)]
pub(crate) struct Loaded {
    /// The sticker and its pixels.
    pub artwork: Artwork,
    /// Columns and rows of the image.
    pub size: [f64; 2],
    checksum: u32,
}

impl Loaded {
    /// Reads the image of `entry` and cuts the sticker out of it.
    ///
    /// # Errors
    /// The file cannot be read or is no usable image, or its outline is unusable.
    pub fn new(context: &Context, paths: &Paths, entry: &DecalEntry) -> Result<Self> {
        let path = paths.resolve(&entry.image.text)?;
        let checksum = crate::state::checksum::checksum(&path)?;
        let image = read_image(&path, context.memory_limit())?;
        let made = sticker(entry, &image).and_then(|sticker| Artwork::new(&sticker, &image));
        let artwork = made.map_err(|error| error.at(path.display().to_string()))?;
        Ok(Self { artwork, size: [image.width(), image.height()].map(f64::from), checksum })
    }

    /// Returns the CRC-32 of the image's file.
    pub fn checksum(&self) -> u32 {
        self.checksum
    }
}

fn sticker(entry: &DecalEntry, image: &Image) -> Result<Sticker> {
    let size = [image.width(), image.height()];
    if let Some([level, tolerance]) = entry.contour {
        return Sticker::of_alpha(image, &Contour { level, tolerance });
    }
    if entry.outline.is_empty() {
        return Sticker::whole(size);
    }
    let height = f64::from(size[1]);
    Sticker::new(size, entry.outline.iter().map(|[x, y]| [*x, height - y]).collect())
}
