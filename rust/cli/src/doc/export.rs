//! `relievo doc export`

use std::path::PathBuf;
use std::process::ExitCode;

use clap::ValueEnum;
use relievo_bake::atlas::{Atlas, PictureTexel, table_of, write_atlas, write_tiles};
use relievo_bake::opened::{ColorLayer, Opened};
use relievo_bake::ptex::to_ptex_watched;
use relievo_bake::quantity::largest_part;
use relievo_bake::{
    Axes, BakeOptions, Handedness, MapFormat, Meaning, Quantity, Scaling, Space, bake_watched, numbered, write_map,
};
use relievo_core::{Context, Error, Mesh, Result};
use relievo_document::{Document, Kind};
use relievo_meshio::write;
use relievo_surface::Surface;
use relievo_tiles::{Displaced, Displacement, Field, VectorDisplacement};

use super::{displaced, triangles};
use crate::Outcome;
use crate::bar::Bar;

#[derive(clap::Args)]
pub struct Arguments {
    /// The document.
    file: PathBuf,
    /// The mesh it was made on.
    mesh: PathBuf,
    /// What to write: .ptx for a layer as Ptex, .exr or .png for a bake, .ply, .glb, .obj, .usda, .stl or .off for a displaced
    /// mesh with the colours of its vertices.
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// The layer to take, by itself; left out, all layers of its kind as they are seen together.
    #[arg(long, value_name = "NAME")]
    layer: Option<String>,
    /// Write the tiles of a layer as one picture, with a table of where they are beside it.
    #[arg(long, conflicts_with_all = ["bake", "tiles"])]
    atlas: bool,
    /// Write every tile of a layer as a picture, whose number replaces `<TILE>` in the name or follows it.
    #[arg(long, conflicts_with = "bake")]
    tiles: bool,
    /// What to bake to the texture coordinates of the mesh.
    #[arg(long, value_name = "WHAT")]
    bake: Option<What>,
    /// Pixels of a bake: one number, or WIDTHxHEIGHT.
    #[arg(long, value_name = "PIXELS", value_parser = crate::args::numbers::pixels, default_value = "2048")]
    size: [u32; 2],
    /// Bake every UDIM tile to a file of its own, whose number replaces `<UDIM>` in the name or follows it.
    #[arg(long)]
    udim: bool,
    /// Pixels by which a bake goes on around islands.
    #[arg(long, value_name = "PIXELS", default_value_t = 16)]
    dilate: u32,
    /// Samples along the sides of a pixel of a bake, 1 to 8.
    #[arg(long, value_name = "COUNT", default_value_t = 1)]
    samples: u32,
    /// Object units that 1 stands for in a bake of displacement; all of it fits into a PNG if none is given, and in EXR
    /// numbers are object units.
    #[arg(long, value_name = "UNITS")]
    scale: Option<f32>,
    /// The number that stands for no displacement; without it 0 in EXR and 0.5 in PNG.
    #[arg(long, value_name = "NUMBER")]
    mid_level: Option<f32>,
    /// Space of vectors and normals.
    #[arg(long, value_enum, default_value = "tangent")]
    space: SpaceName,
    /// Order of the parts of a vector in tangent space: tangent, normal, bitangent, as Blender and Mudbox take it, or
    /// tangent, bitangent, normal.
    #[arg(long, value_enum, default_value = "tnb")]
    axes: AxesName,
    /// Which way green points in normal maps: up the texture, or down as in DirectX.
    #[arg(long, value_enum, default_value = "opengl")]
    handedness: HandednessName,
    /// The texture coordinates to bake to.
    #[arg(long, value_name = "NAME", default_value = "uv")]
    uv: String,
    /// Cells along an edge of the mesh in a displaced mesh: a power of two up to 512.
    #[arg(long, value_name = "COUNT", default_value_t = 16)]
    cells: u32,
    #[command(flatten)]
    isolation: crate::args::limits::Isolation,
    /// Bytes that files and what is made of them may occupy, with K, M or G; 0 for no limit.
    #[arg(long, value_name = "BYTES", value_parser = crate::bytes, default_value = "8G")]
    memory_limit: u64,
}

#[derive(Clone, Copy, ValueEnum)]
enum What {
    /// Displacement along the normal.
    Displacement,
    /// From the undisplaced to the displaced surface.
    Vector,
    /// Normals of the displaced surface.
    Normal,
    /// Colours.
    Colour,
    /// Alpha of colours, or the contact of a layer of traces.
    Mask,
    /// How far colliders have pushed.
    Depth,
    /// When a collider pushed last, in seconds.
    Time,
}

#[derive(Clone, Copy, ValueEnum)]
enum SpaceName {
    Tangent,
    Object,
}

#[derive(Clone, Copy, ValueEnum)]
enum AxesName {
    Tnb,
    Tbn,
}

#[derive(Clone, Copy, ValueEnum)]
enum HandednessName {
    Opengl,
    Directx,
}

pub fn run(arguments: &Arguments) -> Outcome {
    let extension = arguments.output.extension().map(|extension| extension.to_string_lossy().to_ascii_lowercase());
    let task = match extension.as_deref() {
        Some("ptx" | "ptex") => ptex,
        Some("exr" | "png") if arguments.bake.is_some() => maps,
        Some("exr" | "png") if arguments.atlas || arguments.tiles => pictures,
        Some("exr" | "png") => {
            return Err(Error::invalid("what the picture is to show is not said")
                .advise("add --bake displacement, vector, normal, colour, mask, depth or time, or --atlas, or --tiles")
                .into());
        }
        Some("ply" | "glb" | "obj" | "usd" | "usda" | "stl" | "off") => mesh,
        _ => {
            return Err(Error::unsupported("the format to write is not known")
                .at(arguments.output.display().to_string())
                .advise("use the extension .ptx, .exr, .png, .ply, .glb, .obj, .usda, .stl or .off")
                .into());
        }
    };
    let context = crate::context(arguments.memory_limit)?;
    let document = Document::open(&arguments.file, context.memory_limit())?;
    let cage = relievo_meshio::read(&context, &arguments.mesh)?;
    if document.topology().is_of_triangles() {
        let layer = arguments.layer.as_deref();
        let bake = arguments.bake.map(|what| triangles::Bake {
            meaning: meaning(arguments, what),
            options: bake_options(arguments),
            uv: &arguments.uv,
            scaling: [arguments.scale, arguments.mid_level],
        });
        let text = triangles::export(&context, &document, &cage, layer, &arguments.output, bake.as_ref())?;
        crate::print(&text)?;
        return Ok(ExitCode::SUCCESS);
    }
    let named = |error: Error| error.at(arguments.mesh.display().to_string());
    let opened = Opened::new(&context, &document, &cage, arguments.isolation.isolation).map_err(named)?;
    let notes: String = opened.notes.iter().map(|note| format!("{}: {note}\n", arguments.file.display())).collect();
    let text = task(arguments, &context, &Work { opened: &opened, cage: &cage })?;
    crate::print(&format!("{notes}{text}"))?;
    Ok(ExitCode::SUCCESS)
}

/// What is exported.
struct Work<'a> {
    opened: &'a Opened<'a>,
    cage: &'a Mesh,
}

fn missing(what: &str) -> Error {
    Error::invalid(format!("the document has no {what}")).advise("see `relievo info` for its layers")
}

/// The channel of a layer.
enum Taken {
    Displacement(Displacement),
    Vectors(VectorDisplacement),
    Colors(ColorLayer),
}

/// The layer that was named, or all that a document has if that is of one kind.
fn take(arguments: &Arguments, context: &Context, opened: &Opened<'_>) -> Result<Taken> {
    let name = arguments.layer.as_deref();
    let kind = opened.kind(name)?;
    let wanted = |kinds: &[Kind]| kind.is_none_or(|kind| kinds.contains(&kind));
    if kind == Some(Kind::Trace) {
        return Err(Error::unsupported("traces are written as maps alone").advise("add --bake mask, depth or time"));
    }
    let mut found = Vec::new();
    if wanted(&[Kind::Scalar]) {
        found.extend(opened.displacement(context, name)?.map(Taken::Displacement));
    }
    if wanted(&[Kind::Vector]) {
        found.extend(opened.vectors(context, name)?.map(Taken::Vectors));
    }
    if wanted(&[Kind::Rgba8, Kind::Rgba16]) {
        found.extend(opened.colors(context, name)?.map(Taken::Colors));
    }
    match (found.pop(), found.is_empty()) {
        (Some(taken), true) => Ok(taken),
        (Some(_), false) => Err(Error::invalid("the document has displacement and colours, and the file holds one")
            .advise("name the layer with --layer")),
        (None, _) => Err(missing("displacement and no colours")),
    }
}

fn ptex(arguments: &Arguments, context: &Context, work: &Work<'_>) -> Result<String> {
    let writer = match take(arguments, context, work.opened)? {
        Taken::Displacement(made) => to_ptex_watched(context, work.cage, made.field(), &mut Bar::new())?,
        Taken::Vectors(made) => to_ptex_watched(context, work.cage, made.field(), &mut Bar::new())?,
        Taken::Colors(ColorLayer::Rgba8(paint)) => to_ptex_watched(context, work.cage, paint.field(), &mut Bar::new())?,
        Taken::Colors(ColorLayer::Rgba16(paint)) => {
            to_ptex_watched(context, work.cage, paint.field(), &mut Bar::new())?
        }
    };
    writer.write(&arguments.output)?;
    Ok(format!("{}: {} faces\n", arguments.output.display(), work.opened.surface().tile_count()))
}

fn pictures(arguments: &Arguments, context: &Context, work: &Work<'_>) -> Result<String> {
    match take(arguments, context, work.opened)? {
        Taken::Displacement(made) => {
            let quantity = Quantity::Displacement(made.field());
            let scaling = scaling(arguments, &quantity, quantity.largest())?;
            write_pictures(arguments, context, made.field(), &scaling)
        }
        Taken::Vectors(made) => {
            // As displacement along the normal.
            let undisplaced = work.opened.undisplaced()?;
            let scaling = scaling(arguments, &Quantity::Displacement(undisplaced.field()), largest_part(made.field()))?;
            write_pictures(arguments, context, made.field(), &scaling)
        }
        Taken::Colors(ColorLayer::Rgba8(paint)) => write_pictures(arguments, context, paint.field(), &Scaling::PLAIN),
        Taken::Colors(ColorLayer::Rgba16(paint)) => write_pictures(arguments, context, paint.field(), &Scaling::PLAIN),
    }
}

fn write_pictures<T: PictureTexel>(
    arguments: &Arguments,
    context: &Context,
    field: &Field<T>,
    scaling: &Scaling,
) -> Result<String> {
    let path = &arguments.output;
    if arguments.tiles {
        let written = write_tiles(context, field, scaling, |tile| numbered(path, "<TILE>", tile))?;
        return Ok(match written.as_slice() {
            [first, .., last] => format!("{} to {}: {} tiles\n", first.display(), last.display(), written.len()),
            _ => written.iter().map(|path| format!("{}: 1 tile\n", path.display())).collect(),
        });
    }
    let Atlas { width, height, cells } = write_atlas(context, path, field, scaling)?;
    let (table, count) = (table_of(path), cells.len());
    Ok(format!("{}: {width} x {height} pixels, {count} tiles\n{}\n", path.display(), table.display()))
}

fn maps(arguments: &Arguments, context: &Context, work: &Work<'_>) -> Result<String> {
    let Work { opened, cage } = work;
    let name = arguments.layer.as_deref();
    let kind = opened.kind(name)?;
    let limit = Surface::face_varying(context, cage, &arguments.uv, opened.options()).map_err(|error| {
        let place = arguments.mesh.display().to_string();
        if error.remedy.is_empty() {
            error.at(place).advise("unwrap the mesh, or name its coordinates with --uv")
        } else {
            error.at(place)
        }
    })?;
    let (space, axes, handedness) = conventions(arguments);
    let write = |quantity: &Quantity<'_>| write_maps(arguments, context, &limit, quantity);
    let traces = || opened.traces(context, name)?.ok_or_else(|| missing("traces of contact"));
    let Some(what) = arguments.bake else { return Err(missing("bake")) };
    match what {
        What::Displacement | What::Vector | What::Normal => {
            let (scalar, vectors) = (opened.displacement(context, name)?, opened.vectors(context, name)?);
            let some = match what {
                What::Displacement => scalar.is_some(),
                What::Vector => scalar.is_some() || vectors.is_some(),
                _ => true,
            };
            if !some {
                return Err(missing("displacement"));
            }
            let displacement = scalar.map_or_else(|| opened.undisplaced(), Ok)?;
            let field = displacement.field();
            let mut displaced = Displaced::new(opened.surface(), field)?;
            if let Some(vectors) = &vectors {
                displaced = displaced.with_vectors(vectors.field())?;
            }
            let quantity = match what {
                What::Displacement => Quantity::Displacement(field),
                What::Vector => Quantity::Vector(displaced, space, axes),
                _ => Quantity::Normal(displaced, space, handedness),
            };
            write(&quantity)
        }
        What::Colour => {
            let colors = opened.colors(context, name)?.ok_or_else(|| missing("colours"))?;
            write(&Quantity::Color(colors.colors()))
        }
        What::Mask if kind != Some(Kind::Trace) => match opened.colors(context, name)? {
            Some(colors) => write(&Quantity::Mask(colors.colors())),
            None => write(&Quantity::Contact(traces()?.field())),
        },
        What::Mask => write(&Quantity::Contact(traces()?.field())),
        What::Depth | What::Time => {
            let traces = traces()?;
            if let What::Depth = what {
                return write(&Quantity::Depth(traces.field()));
            }
            write(&Quantity::Time(traces.field()))
        }
    }
}

fn conventions(arguments: &Arguments) -> (Space, Axes, Handedness) {
    let space = match arguments.space {
        SpaceName::Tangent => Space::Tangent,
        SpaceName::Object => Space::Object,
    };
    let axes = match arguments.axes {
        AxesName::Tnb => Axes::Tnb,
        AxesName::Tbn => Axes::Tbn,
    };
    let handedness = match arguments.handedness {
        HandednessName::Opengl => Handedness::OpenGl,
        HandednessName::Directx => Handedness::DirectX,
    };
    (space, axes, handedness)
}

/// What the numbers of a bake are, where a mask is that of colours.
fn meaning(arguments: &Arguments, what: What) -> Meaning {
    let (space, axes, handedness) = conventions(arguments);
    match what {
        What::Displacement => Meaning::Displacement,
        What::Vector => Meaning::Vector(space, axes),
        What::Normal => Meaning::Normal(space, handedness),
        What::Colour => Meaning::Color,
        What::Mask => Meaning::Mask,
        What::Depth => Meaning::Depth,
        What::Time => Meaning::Time,
    }
}

fn bake_options(arguments: &Arguments) -> BakeOptions {
    BakeOptions { size: arguments.size, udim: arguments.udim, gutter: arguments.dilate, samples: arguments.samples }
}

/// What numbers stand for: as the arguments say, or as it fits values up to `largest`.
fn scaling(arguments: &Arguments, quantity: &Quantity<'_>, largest: f32) -> Result<Scaling> {
    let fitting = Scaling::fitting(MapFormat::of(&arguments.output)?, quantity.meaning(), largest);
    let scaling = Scaling {
        scale: arguments.scale.unwrap_or(fitting.scale),
        mid_level: arguments.mid_level.unwrap_or(fitting.mid_level),
    };
    scaling.check().map(|()| scaling)
}

fn write_maps(arguments: &Arguments, context: &Context, limit: &Surface, quantity: &Quantity<'_>) -> Result<String> {
    let scaling = scaling(arguments, quantity, quantity.largest())?;
    let options = bake_options(arguments);
    let mut files = String::new();
    let report = bake_watched(context, limit, quantity, &options, &mut Bar::new(), |map| {
        let path =
            if arguments.udim { numbered(&arguments.output, "<UDIM>", map.udim) } else { arguments.output.clone() };
        write_map(context, &path, &map, quantity.meaning(), &scaling)?;
        files += &format!("{}\n", path.display());
        Ok(())
    })?;
    let scale = match quantity {
        Quantity::Displacement(_) | Quantity::Vector(..) | Quantity::Depth(_) | Quantity::Time(_) => {
            format!("; scale {}, mid-level {}", scaling.scale, scaling.mid_level)
        }
        _ => String::new(),
    };
    Ok(format!("{files}{report}{scale}\n"))
}

fn mesh(arguments: &Arguments, context: &Context, work: &Work<'_>) -> Result<String> {
    let Work { opened, cage } = work;
    let name = arguments.layer.as_deref();
    let mut made = displaced::tessellation(context, opened, cage, name, arguments.cells)?;
    if cage.attribute(&arguments.uv).is_some_and(|uv| uv.domain == relievo_core::Domain::Corner) {
        let limit = Surface::face_varying(context, cage, &arguments.uv, opened.options())?;
        made.smooth_attribute(context, &arguments.uv, &limit)?;
    }
    match opened.colors(context, name)? {
        Some(ColorLayer::Rgba8(paint)) => made.paint(paint.field()),
        Some(ColorLayer::Rgba16(paint)) => made.paint(paint.field()),
        None => {}
    }
    write(&arguments.output, &made.mesh)?;
    let (points, triangles) = (made.mesh.points.len(), made.tiles.len());
    Ok(format!("{}: {points} points, {triangles} triangles\n", arguments.output.display()))
}
