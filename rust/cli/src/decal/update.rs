//! `relievo decal update`

use std::path::PathBuf;
use std::process::ExitCode;

use glam::{DAffine3, Vec4};
use relievo_core::{Error, Mesh, Result};
use relievo_decal::{Ground, Pin, Recipe, nearest, recipes, triangulated};
use relievo_detail::{DisplacedObject, History, LayeredObject};
use relievo_document::Kind;
use relievo_render::read_image;
use relievo_surface::{Surface, SurfaceOptions};
use relievo_tiles::{ChannelOptions, Displacement, Paint, Rgba8, uniform_rates};
use serde_json::json;

use super::Pair;
use crate::Outcome;
use crate::bar::Bar;
use crate::limits::{Isolation, Limits};
use crate::numbers::numbers;

const EXAMPLE: &str =
    "Example: relievo decal update spot.obj spot.relievo --layer logo --image logo.png --move 2@0,0.15,0.9";

/// Bytes of edits that are kept in memory.
const MEMORY: u64 = 64 << 20;

#[derive(clap::Args)]
#[command(after_help = EXAMPLE)]
pub struct Arguments {
    /// The control cage: OBJ, PLY, GLB, glTF, USD, STL or OFF.
    file: PathBuf,
    /// The document that `relievo decal apply` wrote, which is changed: an edit of its journal, that can be undone.
    document: PathBuf,
    /// The layer of the decal.
    #[arg(long, value_name = "NAME", default_value = "decal")]
    layer: String,
    /// The image of the decal, a PNG or EXR file.
    #[arg(long, value_name = "FILE")]
    image: PathBuf,
    /// Take this image in place of that of the decal, if they differ; it has the same size.
    #[arg(long)]
    replace: bool,
    /// A pin, by its number from 0, and the point of space whose nearest place on the surface it belongs to now. May be
    /// repeated.
    #[arg(long = "move", value_name = "PIN@X,Y,Z", value_parser = moved, allow_hyphen_values = true)]
    moves: Vec<Move>,
    /// One more pin, as of `relievo decal apply`. May be repeated.
    #[arg(long = "pin", value_name = "X,Y@X,Y,Z", value_parser = super::pin, allow_hyphen_values = true)]
    pins: Vec<Pair>,
    /// How much of the sticker is seen from now on, 0 to 1.
    #[arg(long, value_name = "SHARE")]
    opacity: Option<f32>,
    /// Print JSON for programs.
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    isolation: Isolation,
    #[command(flatten)]
    limits: Limits,
}

/// A pin and a point of space.
#[derive(Clone, Copy, Debug)]
struct Move {
    pin: usize,
    space: [f64; 3],
}

fn moved(text: &str) -> std::result::Result<Move, String> {
    let (pin, space) = text.split_once('@').ok_or_else(|| format!("{text:?} has no @ between pin and place"))?;
    let pin = pin.trim().parse().map_err(|_| format!("{pin:?} is not the number of a pin"))?;
    Ok(Move { pin, space: numbers(space)? })
}

pub fn run(arguments: &Arguments) -> Outcome {
    let place = |error: Error| error.at(arguments.document.display().to_string());
    let context = arguments.limits.context()?;
    let limit = context.memory_limit();
    let cage = relievo_meshio::read(&context, &arguments.file)?;
    let image = read_image(&arguments.image, limit)?;
    let isolation = arguments.isolation.isolation;
    let (options, lowered) = Surface::choose_isolation(&context, &cage, &SurfaceOptions::default(), isolation)?;
    let mut notes: Vec<String> = lowered.into_iter().collect();
    let surface = Surface::new(&context, &cage, &options)?;
    let topology = surface.topology().clone();
    let channel = ChannelOptions { budget: limit, ..ChannelOptions::default() };
    let displacement = Displacement::new(topology.clone(), &channel)?;
    let mut object = DisplacedObject::new(&context, surface, &cage.points, displacement, DAffine3::IDENTITY)?;
    let (document, mut history) = History::open(&arguments.document, limit, MEMORY)?;
    notes.extend(document.fit(&cage).map_err(place)?);
    notes.extend(document.notes.iter().cloned());
    let has = |kind: fn(Kind) -> bool| document.layers().iter().any(|layer| kind(layer.kind()));
    if has(|kind| kind == Kind::Rgba8) {
        object.set_paint(Paint::<Rgba8>::of_color(topology, Vec4::ZERO, &channel)?)?;
    } else if has(|kind| kind == Kind::Rgba16) {
        object.set_half_paint(Paint::of_color(topology, Vec4::ZERO, &channel)?)?;
    }
    let left = object.take_up(&context, &document, limit).map_err(place)?;
    notes.extend(left.into_iter().map(|name| format!("layer `{name}` of the document is left as it is")));
    let layer = object.layer(&arguments.layer);
    let mut found = None;
    for (id, recipe) in recipes(&history) {
        let recipe = recipe.map_err(place)?;
        if Some(recipe.layer) == layer {
            found = Some((id, recipe));
        }
    }
    let (id, mut recipe) = found.ok_or_else(|| {
        let error = Error::invalid(format!("no decal lies in a layer `{}` of its own", arguments.layer));
        place(error).advise("name the layer that `relievo decal apply` added")
    })?;
    if !arguments.replace {
        recipe.check_image(&image).map_err(|error| error.at(arguments.image.display().to_string()))?;
    }
    let rates = uniform_rates(object.surface().topology(), recipe.cells);
    let ground = triangulated(&object.displaced()?.tessellate(&context, &cage, &rates)?.mesh);
    arguments.change(&mut recipe, &ground, f64::from(image.height()))?;
    let mut ground = Ground { context: &context, object: &mut object, cage: &cage, history: &mut history };
    let done = ground.update(id, recipe, &image, &mut Bar::new()).map_err(place)?;
    history.sync()?;
    if !done.printed.refused.is_empty() {
        notes.push(format!(
            "the memory limit refused {} tiles: the sticker is missing there",
            done.printed.refused.len()
        ));
    }
    let (tiles, texels) = (done.printed.tiles.len(), done.printed.texels);
    let output = arguments.document.display().to_string();
    let text = if arguments.json {
        let quality = &done.quality;
        let value = json!({
            "file": output, "decal": done.id, "tiles": tiles, "texels": texels, "triangles": quality.triangles,
            "l2": quality.l2, "coverage": quality.coverage, "doubled": quality.doubled, "flips": quality.flips,
        });
        format!("{value:#}\n")
    } else {
        let notes: String = notes.iter().map(|note| format!("note: {note}\n")).collect();
        format!(
            "{notes}{output}\n{}texels                 {texels} in {tiles} tiles\n",
            super::described(&done.quality)
        )
    };
    crate::print(&text)?;
    Ok(ExitCode::SUCCESS)
}

impl Arguments {
    /// Moves and adds pins of a recipe on a mesh; points of the image count pixels downwards from `height`.
    fn change(&self, recipe: &mut Recipe, mesh: &Mesh, height: f64) -> Result<()> {
        let count = recipe.pins.len();
        for Move { pin, space } in &self.moves {
            let moved = recipe.pins.get_mut(*pin).ok_or_else(|| {
                Error::invalid(format!("the decal has {count} pins, counted from 0")).at(format!("pin {pin}"))
            })?;
            moved.place = nearest(mesh, *space).map_err(|error| error.at(format!("pin {pin}")))?.0;
        }
        for Pair { image: [x, y], space } in &self.pins {
            let place = nearest(mesh, *space)?.0;
            recipe.pins.push(Pin { image: [*x, height - y], place });
            if !recipe.depths.is_empty() {
                recipe.depths.push(0.0);
            }
        }
        if let Some(opacity) = self.opacity {
            recipe.seen.opacity = opacity;
        }
        Ok(())
    }
}
