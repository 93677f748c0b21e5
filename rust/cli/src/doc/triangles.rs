//! `relievo doc export` of documents of triangle meshes: the displaced mesh with the colours of its vertices, and
//! bakes. Pictures of tiles and Ptex are of squares, and are not for them.

use std::path::Path;

use glam::DAffine3;
use relievo_bake::triangles::{TriangleColors, TriangleQuantity, bake_triangles};
use relievo_bake::{BakeOptions, MapFormat, Meaning, Scaling, numbered, write_map};
use relievo_core::{Context, Error, Mesh, Result};
use relievo_detail::{LayeredObject, TriangleObject};
use relievo_document::{Document, Settings};
use relievo_meshio::write;
use relievo_surface::TriangleSurface;
use relievo_tiles::by_format;
use relievo_tiles::triangle::{TriangleChannel, TriangleOptions, TriangleTessellation};

use crate::bar::Bar;

/// A bake that is asked for.
pub struct Bake<'a> {
    /// What its numbers are.
    pub meaning: Meaning,
    /// How it is made.
    pub options: BakeOptions,
    /// The name of the texture coordinates.
    pub uv: &'a str,
    /// What 1 stands for in a file, and the number that stands for 0, where they are not to fit.
    pub scaling: [Option<f32>; 2],
}

/// Writes to `path` the displaced mesh, or `bake`, of the layer called `layer` alone or all as they are seen together.
/// Returns what was written.
///
/// Fails if the document was made on other triangles, has no such layer, or the format is not one of these.
pub fn export(
    context: &Context,
    document: &Document,
    mesh: &Mesh,
    layer: Option<&str>,
    path: &Path,
    bake: Option<&Bake<'_>>,
) -> Result<String> {
    let extension = path.extension().map(|extension| extension.to_string_lossy().to_ascii_lowercase());
    let bake = match (extension.as_deref(), bake) {
        (Some("ply" | "glb" | "obj" | "usd" | "usda" | "stl" | "off"), _) => None,
        (Some("exr" | "png"), Some(bake)) => Some(bake),
        _ => {
            return Err(Error::unsupported("documents of triangle meshes are exported as meshes and bakes alone")
                .at(path.display().to_string())
                .advise("use the extension .ply, .glb, .obj, .usda, .stl or .off, or .exr or .png and --bake"));
        }
    };
    let object = shown(context, document, mesh, layer)?;
    if let Some(bake) = bake {
        return write_maps(context, &object, mesh, path, bake);
    }
    let mut made = tessellation(context, &object, mesh)?;
    if let Some(colors) = object.colors() {
        by_format!(colors, it => made.paint(it))?;
    }
    write(path, &made.mesh)?;
    let (points, triangles) = (made.mesh.points.len(), made.tiles.len());
    Ok(format!("{}: {points} points, {triangles} triangles\n", path.display()))
}

/// Bakes to files.
fn write_maps(context: &Context, object: &TriangleObject, mesh: &Mesh, path: &Path, bake: &Bake<'_>) -> Result<String> {
    let Bake { meaning, options, uv, scaling: [scale, mid_level] } = bake;
    let quantity = TriangleQuantity {
        meaning: *meaning,
        displaced: object.displaced()?,
        normals: object.normals(),
        colors: object.colors().map(|colors| by_format!(colors, it => it as &dyn TriangleColors)),
        traces: object.traces().map(|traces| traces.field()),
    };
    let fitting = Scaling::fitting(MapFormat::of(path)?, *meaning, quantity.largest());
    let scaling = Scaling { scale: scale.unwrap_or(fitting.scale), mid_level: mid_level.unwrap_or(fitting.mid_level) };
    scaling.check()?;
    let mut files = String::new();
    let report = bake_triangles(context, (mesh, uv), &quantity, options, &mut Bar::new(), |map| {
        let udim = options.udim.then(|| numbered(path, "<UDIM>", map.udim));
        let path = udim.as_deref().unwrap_or(path);
        write_map(context, path, &map, *meaning, &scaling)?;
        files += &format!("{}\n", path.display());
        Ok(())
    })?;
    Ok(format!("{files}{report}; scale {}, mid-level {}\n", scaling.scale, scaling.mid_level))
}

/// The mesh with the layer called `layer` alone, or all as they are seen together. Fails as [`export`].
pub fn shown(context: &Context, document: &Document, mesh: &Mesh, layer: Option<&str>) -> Result<TriangleObject> {
    document.fit_triangles(mesh)?;
    let mut object = opened(context, document, mesh)?;
    if let Some(name) = layer {
        show_alone(context, &mut object, name)?;
    }
    object.renew(context)?;
    Ok(object)
}

/// Its displaced triangles.
pub fn tessellation(context: &Context, object: &TriangleObject, mesh: &Mesh) -> Result<TriangleTessellation> {
    let rates = |face| object.rates(face);
    TriangleTessellation::new(context, &object.displaced()?, object.normals(), mesh, rates)
}

/// The mesh with all that the document holds.
pub fn opened(context: &Context, document: &Document, mesh: &Mesh) -> Result<TriangleObject> {
    let surface = TriangleSurface::new(context, mesh)?;
    let options = TriangleOptions { segments: 16, budget: u64::MAX };
    let displacement = TriangleChannel::displacement(surface.topology().clone(), &options)?;
    let mut object = TriangleObject::new(context, surface, displacement, DAffine3::IDENTITY)?;
    object.take_up(context, document, context.memory_limit())?;
    object.settle(context)?;
    Ok(object)
}

/// Hides the layers of the same kind as the one called `name`, which is seen as it is.
fn show_alone(context: &Context, object: &mut TriangleObject, name: &str) -> Result<()> {
    let layers = object.layers();
    let Some(wanted) = layers.iter().find(|layer| layer.name == name) else {
        let names: Vec<&str> = layers.iter().map(|layer| layer.name.as_str()).collect();
        return Err(Error::invalid(format!("the document has no layer `{name}` of displacement or colour"))
            .advise(format!("name one of {}", names.join(", "))));
    };
    for layer in layers.iter().filter(|layer| layer.kind == wanted.kind) {
        let settings = Settings { visible: layer.id == wanted.id, ..Settings::of(layer.kind) };
        object.set_layer(context, layer.id, settings)?;
    }
    Ok(())
}
