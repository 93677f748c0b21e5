//! `relievo doc import`

use std::path::PathBuf;
use std::process::ExitCode;

use clap::ValueEnum;
use relievo_bake::gather::from_atlas;
use relievo_bake::ptex::{Imported, PtexImport, PtexKind, from_ptex_watched};
use relievo_core::{Context, Error};
use relievo_document::Document;
use relievo_ptex::Reader;
use relievo_surface::{Surface, SurfaceOptions};

use crate::Outcome;
use crate::bar::Bar;

#[derive(clap::Args)]
pub struct Arguments {
    /// The Ptex file, or the table (.toml) that was written beside an atlas.
    file: PathBuf,
    /// The mesh it was made for.
    mesh: PathBuf,
    /// The document to write.
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// What the texels are; as the file says if none is given, or else displacement for one float and colour for all
    /// else.
    #[arg(long, value_name = "KIND")]
    kind: Option<KindName>,
    /// The name of the layer; without it `displacement`, `vectors` or `colour`, which
    /// scenes take up.
    #[arg(long, value_name = "NAME")]
    layer: Option<String>,
    /// Bytes that files and what is made of them may occupy, with K, M or G; 0 for no limit.
    #[arg(long, value_name = "BYTES", value_parser = crate::bytes, default_value = "8G")]
    memory_limit: u64,
}

#[derive(Clone, Copy, ValueEnum)]
enum KindName {
    /// Along the normal, in object units.
    Displacement,
    /// Along the tangent by u of each face, across it, and along the normal, in object units.
    Vector,
    /// Grey, grey and alpha, RGB, or RGB and alpha.
    Colour,
}

pub fn run(arguments: &Arguments) -> Outcome {
    let context = crate::context(arguments.memory_limit)?;
    let named = |error: Error| error.at(arguments.file.display().to_string());
    let mesh = relievo_meshio::read(&context, &arguments.mesh)?;
    let surface = Surface::new(&context, &mesh, &SurfaceOptions::default());
    let surface = surface.map_err(|error| error.at(arguments.mesh.display().to_string()))?;
    let budget = context.memory_limit();
    let (imported, report) = match arguments.file.extension() {
        Some(extension) if extension.eq_ignore_ascii_case("toml") => {
            if arguments.kind.is_some() {
                return Err(named(
                    Error::invalid("a table says itself what the texels are").advise("leave --kind out"),
                )
                .into());
            }
            let imported = from_atlas(&context, &surface, &arguments.file, budget)?;
            (imported, String::new())
        }
        _ => {
            let reader = Reader::open(&arguments.file, context.memory_limit())?;
            let kind = arguments.kind.map(|kind| match kind {
                KindName::Displacement => PtexKind::Displacement,
                KindName::Vector => PtexKind::Vector,
                KindName::Colour => PtexKind::Color,
            });
            let options = PtexImport { kind, budget, eight_bits: false };
            let (imported, report) =
                from_ptex_watched(&context, &surface, &reader, &options, &mut Bar::new()).map_err(named)?;
            (imported, format!("{}: {report}\n", arguments.file.display()))
        }
    };
    let mut document = Document::new(&mesh, context.level().name())?;
    let layer = store(&context, &mut document, &imported, arguments.layer.as_deref())?;
    document.write(&arguments.output)?;
    let bytes = imported.bytes();
    crate::print(&format!("{report}{}: layer `{layer}`, {bytes} bytes\n", arguments.output.display()))?;
    Ok(ExitCode::SUCCESS)
}

/// Adds the channel to the document. Returns the name of its layer.
fn store<'a>(
    context: &Context,
    document: &mut Document,
    imported: &Imported,
    name: Option<&'a str>,
) -> relievo_core::Result<&'a str> {
    match imported {
        Imported::Displacement(made) => {
            let name = name.unwrap_or("displacement");
            made.field().store(context, document, name).map(|()| name)
        }
        Imported::Vector(made) => {
            let name = name.unwrap_or("vectors");
            made.field().store(context, document, name).map(|()| name)
        }
        Imported::Rgba8(paint) => {
            let name = name.unwrap_or("colour");
            paint.field().store(context, document, name).map(|()| name)
        }
        Imported::Rgba16(paint) => {
            let name = name.unwrap_or("colour");
            paint.field().store(context, document, name).map(|()| name)
        }
    }
}
