//! Decals of a scene: their stickers loaded, and laid at their time.
//!
//! A decal lies on triangles of the displaced surface as it is then, and is written into a layer of the object, as a
//! stroke is.

use relievo_core::progress::Silent;
use relievo_core::{Context, Error, Result};
use relievo_decal::{Artwork, Contour, Decal, DecalSettings, Pin, Pose, Sticker, emboss, lay, nearest, paint, strip};
use relievo_render::{Image, read_png};
use relievo_tiles::{Tessellation, uniform_rates};

use crate::description::DecalEntry;
use crate::paths::Paths;
use crate::refusals::Refusals;
use crate::stamps::exr;
use crate::strokes::{activate, choose_layer};
use crate::world::{Item, World};

/// The sticker of a decal with its image, and a number for what its pixels are.
#[derive(Debug)]
pub(crate) struct Loaded {
    artwork: Artwork,
    height: f64,
    checksum: u32,
}

impl Loaded {
    /// Reads the image of `entry` and cuts the sticker out of it.
    ///
    /// # Errors
    /// The file cannot be read or is no usable image, or its outline is unusable.
    pub fn new(context: &Context, paths: &Paths, entry: &DecalEntry) -> Result<Self> {
        let path = paths.resolve(&entry.image.text)?;
        let checksum = crate::assets::checksum(&path)?;
        let is_exr = path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("exr"));
        let limit = context.memory_limit();
        let image = if is_exr { exr(&path, limit)? } else { read_png(&path, limit)? };
        let made = sticker(entry, &image).and_then(|sticker| Artwork::new(&sticker, &image));
        let artwork = made.map_err(|error| error.at(path.display().to_string()))?;
        Ok(Self { artwork, height: f64::from(image.height()), checksum })
    }

    /// Returns the CRC-32 of the image's file.
    pub fn checksum(&self) -> u32 {
        self.checksum
    }

    /// Lays the sticker on the triangles of the surface that shows `object`.
    fn lay(&self, world: &World, entry: &DecalEntry, ground: &Tessellation) -> Result<Decal> {
        let inverse = world.transforms()[entry.object].inverse();
        let mesh = &ground.mesh;
        let sticker = self.artwork.sticker();
        let mut places = Vec::with_capacity(entry.pins.len());
        for (index, pin) in entry.pins.iter().enumerate() {
            let position = inverse.transform_point3(pin.position).to_array();
            places.push(nearest(mesh, position).map_err(|error| error.at(format!("pin {index}")))?.0);
        }
        let pins = if entry.strip {
            strip(mesh, sticker, &places)?.pins
        } else {
            let pairs = entry.pins.iter().zip(places);
            // Scene files count pixels downwards.
            let upward = |[x, y]: [f64; 2]| [x, self.height - y];
            pairs.filter_map(|(pin, place)| Some(Pin { image: upward(pin.image?), place })).collect()
        };
        let pose = entry.width.map(|width| Pose {
            width: width * inverse.matrix3.determinant().abs().cbrt(),
            up: inverse.transform_vector3(entry.up).to_array(),
        });
        let settings = DecalSettings { overlap: entry.overlap, ..DecalSettings::default() };
        lay(mesh, sticker, &pins, pose, &settings, &mut Silent)
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

/// Lays the decals of `frame`: those whose time is after the frame before, and at the first frame those of time 0 too.
pub(crate) fn make(context: &Context, world: &mut World, frame: u32, refusals: &mut Refusals) -> Result<()> {
    let (before, now) = (world.scene.time(frame.saturating_sub(1)), world.scene.time(frame));
    make_due(context, world, |entry| entry.time <= now && (frame == 0 || entry.time > before), refusals)
}

/// Lays the decals that are `due`, in the order of the file, and adds what was refused.
pub(crate) fn make_due(
    context: &Context,
    world: &mut World,
    due: impl Fn(&DecalEntry) -> bool,
    refusals: &mut Refusals,
) -> Result<()> {
    for index in 0..world.scene.decals.len() {
        let entry = &world.scene.decals[index];
        if due(entry) {
            let entry = entry.clone();
            let made = context.stats().time("decal", || put(context, world, index, &entry, refusals));
            made.map_err(|error| error.at(format!("decal {}", index + 1)))?;
        }
    }
    Ok(())
}

/// Lays a decal and writes it into its layer.
fn put(context: &Context, world: &mut World, index: usize, entry: &DecalEntry, refusals: &mut Refusals) -> Result<()> {
    let Some(Item::Surface(surface)) = world.items().get(entry.object) else {
        return Err(Error::unsupported("its object shows a surface of triangles")
            .advise("give the object a surface over its mesh without `kind`"));
    };
    let rates = uniform_rates(surface.surface().topology(), entry.cells);
    let ground = surface.displaced()?.tessellate(context, world.cage(entry.object), &rates)?;
    let decal = world.sticker(index)?.lay(world, entry, &ground)?;
    let depths: Vec<f64> = match entry.strip {
        true => Vec::new(),
        false => entry.pins.iter().map(|pin| pin.depth).collect(),
    };
    let active = match &entry.layer {
        Some(name) => choose_layer(context, world, &[entry.object], name, entry.height.is_none())?,
        None => Vec::new(),
    };
    let (surface, sticker) = world.surface_and_sticker(entry.object, index)?;
    let artwork = &sticker.artwork;
    let printed = match entry.height {
        Some(height) => emboss(context, surface, &ground, &decal, artwork, &depths, height),
        None => paint(context, surface, &ground, &decal, artwork, &depths, entry.opacity),
    };
    activate(context, world, &active)?;
    refusals.add(entry.object, &printed?.refused);
    Ok(())
}
