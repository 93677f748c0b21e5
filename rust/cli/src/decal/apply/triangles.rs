//! `relievo decal apply` on the triangles of a mesh.

use glam::{DAffine3, Vec4};
use relievo_core::{Context, Error, Mesh, Result};
use relievo_decal::{Artwork, Pin, Printable, Printed, TrianglePrint, next_recipe, triangulated};
use relievo_detail::{LayeredObject, TriangleObject};
use relievo_document::{Document, Kind, Settings};
use relievo_surface::TriangleSurface;
use relievo_tiles::by_format;
use relievo_tiles::triangle::{TriangleChannel, TriangleOptions, TriangleTessellation};

use super::{Arguments, report};
use crate::Outcome;
use crate::decal::common::Laid;
use crate::decal::picture;
use crate::doc::triangles::tessellation;

/// Lays the sticker on the displaced triangles of a mesh and writes it into a layer of their document.
pub fn run(arguments: &Arguments, context: Context, mesh: &Mesh, document: Option<Document>) -> Outcome {
    let common = &arguments.common;
    let Opened { mut object, mut notes, layer, is_new } = object(arguments, &context, mesh, document.as_ref())?;
    let ground = tessellation(&context, &object, mesh)?;
    let laid = common.lay_on(context, triangulated(&ground.mesh))?;
    let context = &laid.context;
    let printed = print(arguments, &laid, &ground, &mut object)?;
    if !printed.refused.is_empty() {
        notes.push(format!("the memory limit refused {} faces: the sticker is missing there", printed.refused.len()));
    }
    let mut made = Document::of_triangles(mesh, context.level().name())?;
    object.store(context, &mut made)?;
    for recipe in document.iter().flat_map(|document| document.recipes()) {
        made.put_recipe(recipe.id, Some(recipe.bytes.clone()))?;
    }
    if is_new {
        let keep = |pin: &Pin| Ok(Pin { place: TriangleObject::kept(&ground, pin.place)?, ..*pin });
        let pins = laid.pins.iter().map(keep).collect::<Result<Vec<_>>>()?;
        let id = next_recipe(made.recipes())?;
        made.put_recipe(id, arguments.recipe(&laid, pins, 1, layer).map(|recipe| recipe.encode()))?;
    }
    made.write(&arguments.output)?;
    if let Some(file) = &common.picture {
        let mut shown = tessellation(context, &object, mesh)?;
        if let Some(colors) = object.colors() {
            by_format!(colors, it => shown.paint(it))?;
        }
        picture::draw_colored(&laid, shown.mesh, file)?;
    }
    report(arguments, &laid, &printed, &notes)
}

/// The mesh with the layers of the document.
struct Opened {
    object: TriangleObject,
    /// What the user should know.
    notes: Vec<String>,
    /// The layer to be written into.
    layer: u32,
    /// Whether the document did not have it.
    is_new: bool,
}

/// The mesh with the layers of the document, the one to be written into active.
fn object(arguments: &Arguments, context: &Context, mesh: &Mesh, document: Option<&Document>) -> Result<Opened> {
    let surface = TriangleSurface::new(context, mesh)?;
    let topology = surface.topology().clone();
    let options = TriangleOptions { segments: arguments.texels, budget: context.memory_limit() };
    let displacement = TriangleChannel::displacement(topology.clone(), &options)?;
    let mut object = TriangleObject::new(context, surface, displacement, DAffine3::IDENTITY)?;
    let mut notes = Vec::new();
    if let (Some(path), Some(document)) = (&arguments.document, document) {
        let place = |error: Error| error.at(path.display().to_string());
        document.fit_triangles(mesh).map_err(place)?;
        notes.extend(document.notes.iter().cloned());
        let left = object.take_up(context, document, context.memory_limit()).map_err(place)?;
        notes.extend(left.into_iter().map(|name| format!("layer `{name}` of the document is left out")));
    }
    if arguments.height.is_none() && object.colors().is_none() {
        object.set_paint(TriangleChannel::of_color(topology, Vec4::new(0.5, 0.5, 0.5, 1.0), &options)?)?;
    }
    let (layer, is_new) = arguments.choose_layer(context, &mut object)?;
    object.settle(context)?;
    object.renew(context)?;
    Ok(Opened { object, notes, layer, is_new })
}

fn print(
    arguments: &Arguments,
    laid: &Laid,
    ground: &TriangleTessellation,
    object: &mut TriangleObject,
) -> Result<Printed> {
    let Some(image) = &laid.image else {
        return Err(Error::internal("the image is missing"));
    };
    let artwork = Artwork::new(&laid.sticker, image)?;
    let depths = &arguments.depths.depths;
    let print = TrianglePrint { context: &laid.context, ground, decal: &laid.decal, artwork: &artwork, depths };
    match arguments.height {
        Some(height) => print.emboss(object, height, &Settings::of(Kind::Scalar)),
        None => print.paint(object, &Settings { opacity: arguments.opacity, ..Settings::of(Kind::Rgba8) }),
    }
}
