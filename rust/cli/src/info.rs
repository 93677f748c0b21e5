//! `relievo info`

use std::path::PathBuf;
use std::process::ExitCode;

use relievo_core::Context;
use relievo_document::Document;
use relievo_document::format::EXTENSION;
use relievo_meshio::Summary;
use relievo_ptex::{Reader, Resolution};
use relievo_surface::bezier::{BezierSurface, EdgeSense};
use serde_json::{Value, json};

use crate::Outcome;

#[derive(clap::Args)]
pub struct Arguments {
    /// The mesh file, a file of Bézier patches, a Ptex file by the extension .ptx or .ptex, a document by .relievo, a
    /// progressive mesh by .rlvpm, a crowd model by .rcrowd, soft tissue by .rtissue or .rtstate, or particles by .rlvfluid,
    /// .bgeo, .vtk or .vdb, or a folder of their frames.
    file: PathBuf,
    /// Print JSON for programs.
    #[arg(long)]
    json: bool,
    /// Bytes that the file and what is made of it may occupy, with K, M or G; 0 for no limit.
    #[arg(long, value_name = "BYTES", value_parser = crate::bytes, default_value = "8G")]
    memory_limit: u64,
}

/// Ends with 1 if the mesh, the texture or the document cannot be used.
pub fn run(arguments: &Arguments) -> Outcome {
    let extension = arguments.file.extension().map(|extension| extension.to_string_lossy().to_ascii_lowercase());
    if matches!(extension.as_deref(), Some("ptx" | "ptex")) {
        return texture(arguments);
    }
    if extension.as_deref() == Some(EXTENSION) {
        return document(arguments);
    }
    let context = crate::context(arguments.memory_limit)?;
    match extension.as_deref() {
        Some("rlvpm") => return crate::progressive::tell(&context, &arguments.file, arguments.json),
        Some("rcrowd") => return crate::crowd::tell(&context, &arguments.file, arguments.json),
        Some("rtissue" | "rtstate") => return crate::tissue::tell(&context, &arguments.file, arguments.json),
        _ => {}
    }
    if matches!(extension.as_deref(), Some("rlvfluid" | "bgeo" | "vtk" | "vdb")) || arguments.file.is_dir() {
        return crate::fluid::tell(&context, &arguments.file, arguments.json);
    }
    if relievo_meshio::holds_patches(&arguments.file)? {
        return patches(&context, arguments);
    }
    let place = arguments.file.display().to_string();
    let model = relievo_meshio::read_model(&context, &arguments.file)?;
    let summary = Summary::of_model(&context, &model).map_err(|error| error.at(&place))?;
    let text = match arguments.json {
        true => format!("{:#}\n", machine_readable(&summary)),
        false => format!("{place}\n{summary}\n"),
    };
    crate::print(&text)?;
    Ok(if summary.problem.is_some() { ExitCode::FAILURE } else { ExitCode::SUCCESS })
}

fn patches(context: &Context, arguments: &Arguments) -> Outcome {
    let place = arguments.file.display().to_string();
    let patches = relievo_meshio::read_patches(context, &arguments.file)?;
    let weights = patches.weights.as_deref();
    let surface = BezierSurface::new(context, &patches.points, Some(&patches.indices), weights)
        .map_err(|error| error.at(&place))?;
    let edges = surface.edges();
    let senses = (0..surface.count()).flat_map(|patch| edges.senses(patch));
    let collapsed = senses.filter(|sense| *sense == EdgeSense::Collapsed).count();
    let shared = (0..edges.curve_count()).filter(|curve| edges.sharing(*curve).count() > 1).count();
    let border = edges.curve_count() - shared - collapsed;
    let (low, high) = surface.total_bounds();
    let text = match arguments.json {
        true => format!(
            "{:#}\n",
            json!({
                "patches": surface.count(),
                "rational": surface.is_rational(),
                "control_points": patches.points.len(),
                "shared_edges": shared,
                "border_edges": border,
                "collapsed_edges": collapsed,
                "bounds": [low, high],
            })
        ),
        false => format!(
            "{place}\n{patches}\n  edges: {shared} shared, {border} on the border, {collapsed} collapsed\n  \
             bounds {low:?} to {high:?}\n"
        ),
    };
    crate::print(&text)?;
    Ok(ExitCode::SUCCESS)
}

fn texture(arguments: &Arguments) -> Outcome {
    let limit = if arguments.memory_limit == 0 { u64::MAX } else { arguments.memory_limit };
    let summary = relievo_ptex::Summary::of(&Reader::open(&arguments.file, limit)?);
    let text = match arguments.json {
        true => format!("{:#}\n", machine_readable_texture(&summary)),
        false => format!("{}\n{summary}\n", arguments.file.display()),
    };
    crate::print(&text)?;
    Ok(if summary.problem.is_some() { ExitCode::FAILURE } else { ExitCode::SUCCESS })
}

fn document(arguments: &Arguments) -> Outcome {
    let limit = if arguments.memory_limit == 0 { u64::MAX } else { arguments.memory_limit };
    let document = Document::open(&arguments.file, limit)?;
    let (edits, _) = relievo_document::list_edits(&arguments.file, limit)?;
    let done = edits.iter().filter(|edit| edit.is_done).count();
    let undone = edits.len() - done;
    let text = match arguments.json {
        true => {
            let mut value = machine_readable_document(&document);
            value["edits"] = json!({ "done": done, "undone": undone });
            format!("{value:#}\n")
        }
        false => format!(
            "{}\n{document}\n  edits: {done} can be undone, {undone} can be made again\n",
            arguments.file.display()
        ),
    };
    crate::print(&text)?;
    Ok(ExitCode::SUCCESS)
}

fn machine_readable_document(document: &Document) -> Value {
    let topology = document.topology();
    let layers = document.layers().iter().map(|layer| {
        json!({
            "name": layer.name(),
            "kind": layer.kind().name(),
            "opacity": layer.settings().opacity,
            "blend": layer.settings().blend.name(),
            "visible": layer.settings().visible,
            "largest_tile": layer.face_sizes().iter().max(),
            "smallest_tile": layer.face_sizes().iter().min(),
            "tiles": layer.blocks().len(),
            "bytes": layer.bytes(topology),
            "packed_bytes": layer.blocks().iter().map(|block| block.packed_bytes()).sum::<usize>(),
        })
    });
    json!({
        "version": document.version,
        "writer": document.writer,
        "level": document.level,
        "faces": topology.face_count(),
        "corners": topology.corners().len(),
        "holes": topology.holes().len(),
        "tiles": topology.tile_count(),
        "fingerprint": format!("{:016x}", topology.fingerprint()),
        "points": document.points().len(),
        "notes": document.notes,
        "layers": layers.collect::<Vec<_>>(),
    })
}

fn machine_readable_texture(summary: &relievo_ptex::Summary) -> Value {
    let resolution = |(resolution, count): (&Resolution, &usize)| json!({ "width": resolution.width(), "height": resolution.height(), "faces": count });
    let meta = |(key, kind, length): &(String, &str, usize)| json!({ "key": key, "type": kind, "length": length });
    let lower = |value: &dyn std::fmt::Debug| format!("{value:?}").to_lowercase();
    json!({
        "mesh": lower(&summary.format.mesh),
        "data_type": summary.format.data_type.name(),
        "channels": summary.format.channels,
        "alpha": summary.format.alpha,
        "faces": summary.faces,
        "constant_faces": summary.constant_faces,
        "edited_faces": summary.edited_faces,
        "subfaces": summary.subfaces,
        "boundary_edges": summary.boundary_edges,
        "resolutions": summary.faces_by_resolution.iter().map(resolution).collect::<Vec<_>>(),
        "levels": summary.levels,
        "borders": [lower(&summary.borders.u), lower(&summary.borders.v)],
        "edge_filter": lower(&summary.borders.edge_filter),
        "edits": summary.edits,
        "meta": summary.meta.iter().map(meta).collect::<Vec<_>>(),
        "texels": summary.texels,
        "texel_bytes": summary.texel_bytes,
        "file_bytes": summary.file_bytes,
        "problem": summary.problem,
    })
}

fn machine_readable(summary: &Summary) -> Value {
    let sizes: serde_json::Map<String, Value> =
        summary.faces_by_size.iter().map(|(size, count)| (size.to_string(), (*count).into())).collect();
    let attributes: Vec<Value> = summary
        .attributes
        .iter()
        .map(|(name, domain, width, count)| {
            json!({ "name": name, "domain": format!("{domain:?}").to_lowercase(), "width": width, "values": count })
        })
        .collect();
    let animations: Vec<Value> =
        summary.animations.iter().map(|(name, from, to)| json!({ "name": name, "from": from, "to": to })).collect();
    json!({
        "points": summary.points,
        "unused_points": summary.unused_points,
        "faces": summary.faces,
        "faces_by_size": sizes,
        "edges": summary.edges,
        "boundary_edges": summary.boundary_edges,
        "non_manifold_edges": summary.non_manifold_edges,
        "turned_edges": summary.turned_edges,
        "components": summary.components,
        "extraordinary_points": summary.extraordinary_points,
        "largest_valence": summary.largest_valence,
        "creases": summary.creases,
        "sharp_points": summary.sharp_points,
        "holes": summary.holes,
        "attributes": attributes,
        "bounds": summary.bounds.map(|(low, high)| [low, high]),
        "problem": summary.problem,
        "skins": summary.skins.iter().map(|(name, joints)| json!({ "name": name, "joints": joints })).collect::<Vec<_>>(),
        "animations": animations,
        "materials": summary.materials,
        "notes": summary.notes,
    })
}
