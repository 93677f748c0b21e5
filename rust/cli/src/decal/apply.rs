//! `relievo decal apply`

mod triangles;

use std::path::PathBuf;
use std::process::ExitCode;

use glam::{DAffine3, Vec4};
use relievo_core::{Context, Error, Mesh, Result};
use relievo_decal::{Artwork, Ink, Pin, Printed, Recipe, emboss, hash, next_recipe, paint, triangulated};
use relievo_detail::{DisplacedObject, LayeredObject};
use relievo_document::{self as document, Document, Kind, Settings};
use relievo_surface::{Surface, SurfaceOptions};
use relievo_tiles::{ChannelOptions, Displacement, Paint, Rgba8, Tessellation, uniform_rates};
use serde_json::json;

use super::common::{Common, Depths};
use super::picture;
use crate::Outcome;
use crate::args::limits::Isolation;

const EXAMPLE: &str = "Example: relievo decal apply spot.obj -o spot.relievo --image logo.png --pin 20,30@-0.2,0.3,0.8 \
    --pin 236,30@0.2,0.3,0.8 --pin 128,220@0,0.1,0.9 --layer logo --picture spot.png";

/// Cells along an edge of the cage of the surface that a painted picture shows.
const SHOWN: u32 = 16;

#[derive(clap::Args)]
#[command(after_help = EXAMPLE)]
pub struct Arguments {
    #[command(flatten)]
    common: Common,
    /// The document to write.
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// Write into the triangles of the mesh themselves, not into the limit surface of which the mesh is the cage. So it is
    /// also where `--document` is of triangles.
    #[arg(long)]
    triangles: bool,
    /// The document of the mesh to go on from; left out, a new one.
    #[arg(long, value_name = "FILE")]
    document: Option<PathBuf>,
    /// The layer to write into; one is added where there is none of this name. The document keeps what the decal in an added
    /// layer was made of, for `relievo decal update`.
    #[arg(long, value_name = "NAME", default_value = "decal")]
    layer: String,
    /// How much of the sticker is seen, 0 to 1.
    #[arg(long, value_name = "SHARE", default_value_t = 1.0)]
    opacity: f32,
    /// Raise the surface by this much where the image is white, in units of the mesh, instead of painting it.
    #[arg(long, value_name = "LENGTH", allow_hyphen_values = true)]
    height: Option<f32>,
    #[command(flatten)]
    depths: Depths,
    /// Texels along each edge of a face, of a layer that is added: a power of two; on triangles 8 to 64.
    #[arg(long, value_name = "TEXELS", default_value_t = 64)]
    texels: u32,
    /// Cells along each edge of a face that the sticker is laid on: a power of two. Triangles have those of their layers.
    #[arg(long, value_name = "CELLS", default_value_t = 8)]
    cells: u32,
    #[command(flatten)]
    isolation: Isolation,
}

pub fn run(arguments: &Arguments) -> Outcome {
    let common = &arguments.common;
    if common.image.is_none() {
        return Err(Error::invalid("there is no image to write into the layer").advise("give --image").into());
    }
    let context = common.limits.context()?;
    let cage = relievo_meshio::read(&context, &common.file)?;
    let opened = arguments.document.as_ref().map(|path| Document::open(path, context.memory_limit())).transpose()?;
    if arguments.triangles || opened.as_ref().is_some_and(|document| document.topology().is_of_triangles()) {
        return triangles::run(arguments, context, &cage, opened);
    }
    let Opened { mut object, mut notes, recipes, layer, is_new } = arguments.object(&context, &cage, opened)?;
    let tessellation = tessellate(&context, &object, &cage, arguments.cells)?;
    let laid = common.lay_on(context, triangulated(&tessellation.mesh))?;
    let context = &laid.context;
    let printed = arguments.print(context, &mut object, &tessellation, &laid)?;
    if !printed.refused.is_empty() {
        notes.push(format!("the memory limit refused {} tiles: the sticker is missing there", printed.refused.len()));
    }
    let mut document = Document::new(&cage, context.level().name())?;
    object.store(context, &mut document)?;
    for recipe in recipes {
        document.put_recipe(recipe.id, Some(recipe.bytes))?;
    }
    if is_new {
        let id = next_recipe(document.recipes())?;
        let recipe = arguments.recipe(&laid, laid.pins.clone(), arguments.cells, layer);
        document.put_recipe(id, recipe.map(|recipe| recipe.encode()))?;
    }
    document.write(&arguments.output)?;
    if let Some(file) = &common.picture {
        let surface = tessellate(context, &object, &cage, SHOWN)?;
        picture::draw_painted(&laid, &surface, object.colors(), file)?;
    }
    report(arguments, &laid, &printed, &notes)
}

/// Prints what was written.
fn report(arguments: &Arguments, laid: &super::common::Laid, printed: &Printed, notes: &[String]) -> Outcome {
    let output = arguments.output.display().to_string();
    let text = if arguments.common.json {
        let mut value = super::common::machine_readable(&arguments.common, laid);
        value["output"] = json!(output);
        value["tiles"] = json!(printed.tiles.len());
        value["texels"] = json!(printed.texels);
        value["refused"] = json!(printed.refused.len());
        format!("{value:#}\n")
    } else {
        let notes: String = notes.iter().map(|note| format!("note: {note}\n")).collect();
        format!(
            "{notes}{output}\n{}texels                 {} in {} tiles\n",
            super::common::described(&laid.decal.quality),
            printed.texels,
            printed.tiles.len()
        )
    };
    crate::print(&text)?;
    Ok(ExitCode::SUCCESS)
}

/// The displaced surface as triangles.
fn tessellate(context: &Context, object: &DisplacedObject, cage: &Mesh, cells: u32) -> Result<Tessellation> {
    let rates = uniform_rates(object.surface().topology(), cells);
    object.displaced()?.tessellate(context, cage, &rates)
}

/// The surface with the layers of the document.
struct Opened {
    object: DisplacedObject,
    notes: Vec<String>,
    /// What other things on the layers were made of.
    recipes: Vec<document::Recipe>,
    /// The layer to be written into.
    layer: u32,
    /// Whether the document did not have it.
    is_new: bool,
}

impl Arguments {
    /// The surface with the layers of the document, the one to be written into active.
    fn object(&self, context: &Context, cage: &Mesh, document: Option<Document>) -> Result<Opened> {
        let isolation = self.isolation.isolation;
        let (options, lowered) = Surface::choose_isolation(context, cage, &SurfaceOptions::default(), isolation)?;
        let surface = Surface::new(context, cage, &options)?;
        let mut notes: Vec<String> = lowered.into_iter().collect();
        let topology = surface.topology().clone();
        let budget = context.memory_limit();
        let channel = ChannelOptions { size: self.texels, budget, ..ChannelOptions::default() };
        let displacement = Displacement::new(topology.clone(), &channel)?;
        let mut object = DisplacedObject::new(context, surface, &cage.points, displacement, DAffine3::IDENTITY)?;
        let mut recipes = Vec::new();
        if let (Some(path), Some(document)) = (&self.document, document) {
            let place = |error: Error| error.at(path.display().to_string());
            notes.extend(document.fit(cage).map_err(place)?);
            notes.extend(document.notes.iter().cloned());
            let left = object.take_up(context, &document, budget).map_err(place)?;
            recipes = document.recipes().to_vec();
            notes.extend(left.into_iter().map(|name| format!("layer `{name}` of the document is left out")));
        }
        if self.height.is_none() && object.colors().is_none() {
            object.set_paint(Paint::<Rgba8>::of_color(topology, Vec4::new(0.5, 0.5, 0.5, 1.0), &channel)?)?;
        }
        let (layer, is_new) = self.choose_layer(context, &mut object)?;
        Ok(Opened { object, notes, recipes, layer, is_new })
    }

    /// Makes the layer to be written into the active one, and adds it where there is none of its name. Returns its number,
    /// and whether it was added.
    fn choose_layer(&self, context: &Context, object: &mut impl LayeredObject) -> Result<(u32, bool)> {
        let kind = if self.height.is_some() { Kind::Scalar } else { Kind::Rgba8 };
        let found = object.layers().into_iter().find(|layer| layer.name == self.layer);
        let is_new = found.is_none();
        let layer = match found {
            Some(layer) if layer.kind.is_color() != kind.is_color() => {
                return Err(Error::invalid(format!("the layer holds {}", layer.kind.name()))
                    .at(format!("layer `{}`", self.layer))
                    .advise("name another layer, or write its kind: --height is for displacement"));
            }
            Some(layer) => layer.id,
            None => object.add_layer(context, kind, &self.layer, Settings::of(kind), self.texels)?.0,
        };
        object.set_active_layer(context, layer)?;
        Ok((layer, is_new))
    }

    /// What the decal in a layer of its own was made of, with pins as recipes keep them.
    fn recipe(&self, laid: &super::common::Laid, pins: Vec<Pin>, cells: u32, layer: u32) -> Option<Recipe> {
        let ink = self.height.map_or(Ink::Color, Ink::Relief);
        Some(Recipe {
            sticker: laid.sticker.clone(),
            image: hash(laid.image.as_ref()?),
            pins,
            depths: self.depths.depths.clone(),
            pose: laid.pose,
            settings: laid.settings,
            cells,
            layer,
            ink,
            seen: match ink {
                Ink::Color => Settings { opacity: self.opacity, ..Settings::of(Kind::Rgba8) },
                Ink::Relief(_) => Settings::of(Kind::Scalar),
            },
        })
    }

    fn print(
        &self,
        context: &Context,
        object: &mut DisplacedObject,
        tessellation: &Tessellation,
        laid: &super::common::Laid,
    ) -> Result<Printed> {
        let Some(image) = &laid.image else {
            return Err(Error::internal("the image is missing"));
        };
        let artwork = Artwork::new(&laid.sticker, image)?;
        match self.height {
            Some(height) => emboss(context, object, tessellation, &laid.decal, &artwork, &self.depths.depths, height),
            None => paint(context, object, tessellation, &laid.decal, &artwork, &self.depths.depths, self.opacity),
        }
    }
}
