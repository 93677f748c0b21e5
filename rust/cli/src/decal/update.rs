//! `relievo decal update`

use std::path::PathBuf;
use std::process::ExitCode;

use relievo_core::{Error, Result};
use relievo_decal::{Applied, Ground, Pin, Place, Printable, Recipe, nearest, triangulated};
use relievo_render::{Image, read_image};
use serde_json::json;

use super::common::Pair;
use super::kept::{self, Task, path};
use crate::Outcome;
use crate::args::numbers::numbers;
use crate::bar::Bar;

const EXAMPLE: &str =
    "Example: relievo decal update spot.obj spot.relievo --layer logo --image logo.png --move 2@0,0.15,0.9";

#[derive(clap::Args)]
#[command(after_help = EXAMPLE)]
pub struct Arguments {
    #[command(flatten)]
    kept: kept::Arguments,
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
    #[arg(long = "pin", value_name = "X,Y@X,Y,Z", value_parser = super::common::pin, allow_hyphen_values = true)]
    pins: Vec<Pair>,
    /// How much of the sticker is seen from now on, 0 to 1.
    #[arg(long, value_name = "SHARE")]
    opacity: Option<f32>,
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

/// The changes of the arguments with the image.
struct Update<'a> {
    arguments: &'a Arguments,
    image: &'a Image,
}

pub fn run(arguments: &Arguments) -> Outcome {
    let kept = &arguments.kept;
    let mut opened = kept.open()?;
    let image = read_image(&arguments.image, opened.context.memory_limit())?;
    let done = kept.work(&mut opened, Update { arguments, image: &image })?;
    let Applied { id, printed, quality } = &done;
    let mut notes = opened.notes;
    if !printed.refused.is_empty() {
        notes.push(format!("the memory limit refused {} tiles: the sticker is missing there", printed.refused.len()));
    }
    let (tiles, texels) = (printed.tiles.len(), printed.texels);
    let output = path(&kept.document);
    let text = if kept.json {
        let value = json!({
            "file": output, "decal": id, "tiles": tiles, "texels": texels, "triangles": quality.triangles,
            "l2": quality.l2, "coverage": quality.coverage, "doubled": quality.doubled, "flips": quality.flips,
        });
        format!("{value:#}\n")
    } else {
        let notes: String = notes.iter().map(|note| format!("note: {note}\n")).collect();
        format!(
            "{notes}{output}\n{}texels                 {texels} in {tiles} tiles\n",
            super::common::described(quality)
        )
    };
    crate::print(&text)?;
    Ok(ExitCode::SUCCESS)
}

impl Task for Update<'_> {
    type Done = Applied;

    fn run<O: Printable>(self, ground: &mut Ground<'_, O>, id: u32, mut recipe: Recipe) -> Result<Applied> {
        let Self { arguments, image } = self;
        if !arguments.replace {
            recipe.check_image(image).map_err(|error| error.at(path(&arguments.image)))?;
        }
        let triangles = ground.object.triangles(ground.context, ground.cage, recipe.cells)?;
        let mesh = triangulated(O::mesh(&triangles));
        let place = |space: [f64; 3]| O::kept(&triangles, nearest(&mesh, space)?.0);
        arguments.change(&mut recipe, f64::from(image.height()), place)?;
        ground.update(id, recipe, image, &mut Bar::new())
    }
}

impl Arguments {
    /// Moves and adds pins of a recipe, where `place` finds places; points of the image count pixels downwards from `height`.
    fn change(&self, recipe: &mut Recipe, height: f64, place: impl Fn([f64; 3]) -> Result<Place>) -> Result<()> {
        let count = recipe.pins.len();
        for Move { pin, space } in &self.moves {
            let moved = recipe.pins.get_mut(*pin).ok_or_else(|| {
                Error::invalid(format!("the decal has {count} pins, counted from 0")).at(format!("pin {pin}"))
            })?;
            moved.place = place(*space).map_err(|error| error.at(format!("pin {pin}")))?;
        }
        for Pair { image: [x, y], space } in &self.pins {
            recipe.pins.push(Pin { image: [*x, height - y], place: place(*space)? });
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
