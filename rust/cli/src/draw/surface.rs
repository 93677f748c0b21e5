//! Drawing of cages, triangle meshes and documents: Catmull-Clark surfaces with their displacement and colours.

use std::path::Path;

use glam::DAffine3;
use relievo_bake::opened::{ColorLayer, Opened};
use relievo_core::{Context, Error, Mesh, Result};
use relievo_document::Document;
use relievo_document::format::EXTENSION;
use relievo_gpu::Device;
use relievo_render::virtual_vertex::{
    Coat, DrawnSurface, Placed, Rasterizer, Shape, TileRates, TriangleCoat, VirtualTriangles,
};
use relievo_render::{FalseColor, Frame, Material, Scene, View, color, draw_legend};
use relievo_scene::showing::Showing;
use relievo_surface::{Surface, SurfaceOptions};
use relievo_tiles::triangle::TriangleTessellation;
use relievo_tiles::{ByFormat, Displaced, Displacement, Tessellation, VectorDisplacement, by_format, uniform_rates};

use super::Arguments;

/// Pixels by which triangles may be away from the surface where nothing else is said.
const TOLERANCE: f64 = 0.5;
/// Cells along an edge of the cage that the processor divides tiles into where nothing else is said.
const CELLS: u32 = 32;

/// False colours of tiles by what they hold, as in Figure 9 of Schäfer et al. 2015.
const STATES: [(&str, u32); 3] = [("free", 0x2E9E3F), ("constant", 0xE3C22B), ("allocated", 0xC92A2A)];

/// Whether a file is a document.
pub fn is_document(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case(EXTENSION))
}

/// What is drawn.
struct Seen {
    cage: Mesh,
    surface: Surface,
    displacement: Displacement,
    vectors: Option<VectorDisplacement>,
    colors: Option<ColorLayer>,
}

impl Seen {
    fn displaced(&self) -> Result<Displaced<'_>> {
        let displaced = Displaced::new(&self.surface, self.displacement.field())?;
        match &self.vectors {
            Some(vectors) => displaced.with_vectors(vectors.field()),
            None => Ok(displaced),
        }
    }

    /// Which of [`STATES`] a tile has.
    fn state(&self, tile: u32) -> u32 {
        let field = self.displacement.field();
        let vectors = self.vectors.as_ref().is_some_and(|vectors| vectors.field().is_allocated(tile));
        let painted = match &self.colors {
            Some(ColorLayer::Rgba8(paint)) => paint.field().is_allocated(tile),
            Some(ColorLayer::Rgba16(paint)) => paint.field().is_allocated(tile),
            None => false,
        };
        let [least, most] = field.range(tile);
        match (field.is_allocated(tile), vectors || painted) {
            (false, false) => 0,
            (true, false) if least == most => 1,
            _ => 2,
        }
    }
}

/// The picture of a mesh's limit surface, or of a document on its mesh.
pub fn drawn(context: &Context, arguments: &Arguments, device: Option<&Device>) -> Result<Frame> {
    let document = match is_document(&arguments.file) {
        true => Some(Document::open(&arguments.file, context.memory_limit())?),
        false => None,
    };
    let path = match (&document, &arguments.mesh) {
        (None, None) => &arguments.file,
        (Some(_), Some(path)) => path,
        (Some(_), None) => {
            return Err(Error::invalid("the mesh that the document was made on is not named")
                .at(arguments.file.display().to_string())
                .advise("name the mesh after the document"));
        }
        (None, Some(_)) => {
            return Err(Error::invalid("a second file is the mesh of a document")
                .at(arguments.file.display().to_string())
                .advise("name a document, then its mesh"));
        }
    };
    let cage = relievo_meshio::read(context, path)?;
    let named = |error: Error| error.at(path.display().to_string());
    let mut frame = match &document {
        Some(document) if document.topology().is_of_triangles() => {
            triangles(context, arguments, document, &cage, device)?
        }
        _ => {
            let seen = seen(context, document.as_ref(), cage, arguments.isolation.isolation).map_err(named)?;
            match device {
                Some(device) => rasterized(context, arguments, &seen, device)?,
                None => cast(context, arguments, &seen)?,
            }
        }
    };
    if arguments.tiles {
        let entries = STATES.map(|(text, hex)| (color::from_hex(hex), text));
        draw_legend(&mut frame.color, &entries);
    }
    Ok(frame)
}

fn seen(context: &Context, document: Option<&Document>, cage: Mesh, isolation: Option<u32>) -> Result<Seen> {
    let Some(document) = document else {
        let (options, lowered) = Surface::choose_isolation(context, &cage, &SurfaceOptions::default(), isolation)?;
        lowered.iter().for_each(|note| eprintln!("note: {note}"));
        let surface = Surface::new(context, &cage, &options)?;
        let displacement = Displacement::new(surface.topology().clone(), &Default::default())?;
        return Ok(Seen { cage, surface, displacement, vectors: None, colors: None });
    };
    let opened = Opened::new(context, document, &cage, isolation)?;
    opened.notes.iter().for_each(|note| eprintln!("{note}"));
    Ok(Seen {
        displacement: opened.displacement(context, None)?.map_or_else(|| opened.undisplaced(), Ok)?,
        vectors: opened.vectors(context, None)?,
        colors: opened.colors(context, None)?,
        surface: opened.surface().clone(),
        cage,
    })
}

/// Where it is seen from, with the false colours that are asked for.
fn view(arguments: &Arguments, bounds: ([f32; 3], [f32; 3])) -> Result<(View, Material)> {
    let showing = Showing::new(bounds, arguments.up.into(), arguments.size)?;
    let mut view = super::view(arguments, &showing);
    if arguments.tiles {
        let palette = STATES.iter().map(|(_, hex)| color::from_hex(*hex)).collect();
        view.false_color = Some(FalseColor { palette });
    }
    Ok((view, showing.material))
}

fn bounds(displaced: &Displaced<'_>) -> ([f32; 3], [f32; 3]) {
    let topology = displaced.field().topology();
    let tiles = (0..topology.tile_count() as u32).filter(|tile| !topology.is_hole(*tile));
    tiles.map(|tile| displaced.tile_bounds(tile)).fold(([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]), |all, one| {
        let of =
            |pick: fn(f32, f32) -> f32, a: [f32; 3], b: [f32; 3]| std::array::from_fn(|axis| pick(a[axis], b[axis]));
        (of(f32::min, all.0, one.0), of(f32::max, all.1, one.1))
    })
}

fn rasterized(context: &Context, arguments: &Arguments, seen: &Seen, device: &Device) -> Result<Frame> {
    let displaced = seen.displaced()?;
    let (view, material) = view(arguments, bounds(&displaced))?;
    let colors = seen.colors.as_ref().map(|colors| match colors {
        ColorLayer::Rgba8(paint) => ByFormat::Rgba8(paint.field()),
        ColorLayer::Rgba16(paint) => ByFormat::Rgba16(paint.field()),
    });
    let mut drawn = DrawnSurface::new(context, device, &displaced, Coat { colors, traces: None })?;
    match arguments.cells {
        Some(cells) => {
            let rates = TileRates::uniform(seen.surface.topology(), cells)?;
            drawn.tiles_mut().divide(device, rates)?;
        }
        None => {
            let tolerance = arguments.tolerance.unwrap_or(TOLERANCE);
            drawn.adapt(device, &view, &DAffine3::IDENTITY, tolerance)?;
        }
    }
    if arguments.tiles {
        drawn.tiles_mut().tag(device, |tile| seen.state(tile))?;
    }
    let tiles = drawn.tiles();
    let triangles: u64 = tiles.draws().iter().map(|draw| draw.triangles()).sum();
    let (count, draws) = (tiles.order().len(), tiles.draws().len());
    eprintln!("{}: {count} tiles, {triangles} triangles in {draws} draws", device.summary());
    Rasterizer::new(device)?.render(&[drawn.placed(DAffine3::IDENTITY, material, None)], &view)
}

/// As triangles, by rays.
fn cast(context: &Context, arguments: &Arguments, seen: &Seen) -> Result<Frame> {
    let displaced = seen.displaced()?;
    let (view, material) = view(arguments, bounds(&displaced))?;
    let rates = uniform_rates(seen.surface.topology(), arguments.cells.unwrap_or(CELLS));
    let Tessellation { mesh, tiles, .. } = {
        let mut made = displaced.tessellate(context, &seen.cage, &rates)?;
        match &seen.colors {
            Some(ColorLayer::Rgba8(paint)) => made.paint(paint.field()),
            Some(ColorLayer::Rgba16(paint)) => made.paint(paint.field()),
            None => {}
        }
        made
    };
    let mut mesh = relievo_render::Mesh::of_tessellation(mesh);
    if arguments.tiles {
        mesh.tags = tiles.iter().map(|tile| seen.state(*tile)).collect();
    }
    let mut scene = Scene::new()?;
    let object = scene.add_object(DAffine3::IDENTITY, material)?;
    scene.set_mesh(object, 0, mesh)?;
    scene.render(context, &view)
}

/// A document of triangles, tessellated where its faces have blocks.
fn triangles(
    context: &Context,
    arguments: &Arguments,
    document: &Document,
    mesh: &Mesh,
    device: Option<&Device>,
) -> Result<Frame> {
    document.fit_triangles(mesh)?;
    let mut object = crate::doc::triangles::opened(context, document, mesh)?;
    object.renew(context)?;
    let displaced = object.displaced()?;
    let rates = |face| object.rates(face);
    let mut made = TriangleTessellation::new(context, &displaced, object.normals(), mesh, rates)?;
    if let Some(colors) = object.colors() {
        by_format!(colors, it => made.paint(it))?;
    }
    let faces = made.tiles;
    let (low, high) = made.mesh.points.iter().fold(([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]), |(low, high), p| {
        (std::array::from_fn(|axis| low[axis].min(p[axis])), std::array::from_fn(|axis| high[axis].max(p[axis])))
    });
    let (view, material) = view(arguments, (low, high))?;
    let mut mesh = relievo_render::Mesh::of_tessellation(made.mesh);
    if arguments.tiles {
        mesh.tags = faces.iter().map(|face| if object.is_allocated(*face) { 2 } else { 0 }).collect();
    }
    match device {
        Some(device) => {
            let coat = TriangleCoat { colors: object.colors(), traces: None };
            let mut drawn = VirtualTriangles::new(context, device, &displaced, object.normals(), coat)?;
            if arguments.tiles {
                drawn.tag(device, |face| if object.is_allocated(face) { 2 } else { 0 })?;
            }
            let viewpoint = view.viewpoint(&DAffine3::IDENTITY);
            drawn.adapt(device, &viewpoint, arguments.tolerance.unwrap_or(TOLERANCE))?;
            let (count, draws) = (drawn.triangle_count(), drawn.draws().len());
            eprintln!("{}: {count} triangles in {draws} draws", device.summary());
            Rasterizer::new(device)?.render(&[Placed::new(Shape::Triangles(&drawn), material)], &view)
        }
        None => {
            let mut scene = Scene::new()?;
            let object = scene.add_object(DAffine3::IDENTITY, material)?;
            scene.set_mesh(object, 0, mesh)?;
            scene.render(context, &view)
        }
    }
}
