//! Decals of a scene, laid at their time.
//!
//! A decal lies on triangles of the displaced surface or triangle mesh of its frame, and is written into a layer of the
//! object, as a stroke is.

use relievo_core::progress::Silent;
use relievo_core::{Context, Error, Mesh, Result};
use relievo_decal::{Decal, DecalSettings, Pin, Pose, TrianglePrint, emboss, lay, nearest, paint, strip};
use relievo_document::{Kind, Settings};
use relievo_tiles::triangle::TriangleTessellation;
use relievo_tiles::{Tessellation, uniform_rates};

use crate::format::description::DecalEntry;
use crate::run::refusals::Refusals;
use crate::run::strokes::{activate, choose_layer};
use crate::state::stickers::Loaded;
use crate::state::world::{Item, World};

/// Lays a sticker on the triangles of the surface that its object shows.
fn lay_sticker(loaded: &Loaded, world: &World, entry: &DecalEntry, mesh: &Mesh) -> Result<Decal> {
    let inverse = world.transforms()[entry.object].inverse();
    let sticker = loaded.artwork.sticker();
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
        let upward = |[x, y]: [f64; 2]| [x, loaded.size[1] - y];
        pairs.filter_map(|(pin, place)| Some(Pin { image: upward(pin.image?), place })).collect()
    };
    let pose = entry.width.map(|width| Pose {
        width: width * inverse.matrix3.determinant().abs().cbrt(),
        up: inverse.transform_vector3(entry.up).to_array(),
    });
    let settings = DecalSettings { overlap: entry.overlap, ..DecalSettings::default() };
    lay(mesh, sticker, &pins, pose, &settings, &mut Silent)
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

/// What a decal is laid on: the displaced triangles of its object.
enum Ground {
    Surface(Tessellation),
    Triangles(TriangleTessellation),
}

impl Ground {
    fn of(context: &Context, world: &mut World, entry: &DecalEntry) -> Result<Self> {
        if let Some(item) = world.triangles_mut(entry.object) {
            item.object.renew(context)?;
        }
        let cage = world.cage(entry.object);
        match world.items().get(entry.object) {
            Some(Item::Surface(surface)) => {
                let rates = uniform_rates(surface.surface().topology(), entry.cells);
                Ok(Self::Surface(surface.displaced()?.tessellate(context, cage, &rates)?))
            }
            Some(Item::Triangles(item)) => {
                let (object, displaced) = (&item.object, item.object.displaced()?);
                let rates = |face: u32| object.rates(face);
                let whole = TriangleTessellation::new(context, &displaced, object.normals(), cage, rates)?;
                Ok(Self::Triangles(whole))
            }
            _ => Err(Error::internal("a decal lies on an object without a surface")),
        }
    }

    fn mesh(&self) -> &Mesh {
        match self {
            Self::Surface(ground) => &ground.mesh,
            Self::Triangles(ground) => &ground.mesh,
        }
    }
}

/// Lays a decal and writes it into its layer.
fn put(context: &Context, world: &mut World, index: usize, entry: &DecalEntry, refusals: &mut Refusals) -> Result<()> {
    let ground = Ground::of(context, world, entry)?;
    let decal = lay_sticker(world.sticker(index)?, world, entry, ground.mesh())?;
    let depths: Vec<f64> = match entry.strip {
        true => Vec::new(),
        false => entry.pins.iter().map(|pin| pin.depth).collect(),
    };
    let active = match &entry.layer {
        Some(name) => choose_layer(context, world, &[entry.object], name, entry.height.is_none())?,
        None => Vec::new(),
    };
    let (item, Loaded { artwork, .. }) = world.item_and_sticker(entry.object, index)?;
    let printed = match (item, &ground) {
        (Item::Surface(surface), Ground::Surface(ground)) => match entry.height {
            Some(height) => emboss(context, surface, ground, &decal, artwork, &depths, height),
            None => paint(context, surface, ground, &decal, artwork, &depths, entry.opacity),
        },
        (Item::Triangles(item), Ground::Triangles(ground)) => {
            let print = TrianglePrint { context, ground, decal: &decal, artwork, depths: &depths };
            let opacity = entry.opacity;
            match entry.height {
                Some(height) => print.emboss(&mut item.object, height, &Settings::of(Kind::Scalar)),
                None => print.paint(&mut item.object, &Settings { opacity, ..Settings::of(Kind::Rgba8) }),
            }
        }
        _ => Err(Error::internal("a decal lies on another kind of surface")),
    };
    activate(context, world, &active)?;
    refusals.add(entry.object, &printed?.refused);
    Ok(())
}
