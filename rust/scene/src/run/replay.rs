//! Replays a recorded list of strokes on a mesh, or on what a document of it holds.
//!
//! A list of strokes is a scene file without objects: `version`, `[[strokes]]` without `object`, `[stamps.NAME]`, and
//! `[details]` where other sizes of tiles are wanted. The mesh is added to it as the one object, at the origin; so
//! every fault of the list is reported as one of a scene, where it is. Strokes are made in the order of the file,
//! whatever their time.

use std::path::{Path, PathBuf};

use relievo_core::{Context, Error, Progress, Result};
use relievo_detail::{Recorded, Stroke, StrokeReport};
use relievo_document::Document;
use relievo_document::format::EXTENSION;
use relievo_gpu::Device;
use relievo_meshio::Instance;

use crate::format::description::StrokeEntry;
use crate::format::diagnostic::Failure;
use crate::format::file;
use crate::out::export;
use crate::out::stages;
use crate::run::refusals::Refusals;
use crate::run::{folds, laying, strokes};
use crate::state::documents;
use crate::state::paths::Paths;
use crate::state::stamps::Loaded;
use crate::state::world::{Item, World};

/// What is replayed on what.
#[derive(Clone, Debug)]
pub struct Replay {
    /// The mesh file, the control cage of a Catmull-Clark surface or triangles.
    pub mesh: PathBuf,
    /// Whether the surface is that of the mesh's own triangles. That of a document is what it was made on.
    pub triangles: bool,
    /// Levels of isolation of a control cage; `None` for the default, or fewer where that exceeds the memory limit.
    pub isolation: Option<u32>,
    /// The list of strokes.
    pub strokes: PathBuf,
    /// The document to start from.
    pub document: Option<PathBuf>,
    /// The files to write: documents and meshes, by their extension.
    pub outputs: Vec<PathBuf>,
    /// Folders besides that of the list that images may be read from.
    pub allowed: Vec<PathBuf>,
    /// The graphics device that evaluates dabs, as far as it can.
    pub device: Option<Device>,
}

/// Extensions of meshes that can be written.
const MESHES: [&str; 7] = ["obj", "ply", "glb", "usd", "usda", "stl", "off"];

/// Makes the strokes and writes the files. Returns what was done, and what the user should know. `progress` is asked
/// before each stroke and each file.
///
/// # Errors
/// Fails, and writes nothing, with [`Failure::Scene`] if the list of strokes has faults, and with [`Failure::Other`] if
/// no output is named, one has another extension than `relievo`, `obj`, `ply`, `glb`, `usd`, `usda`, `stl` or `off`, a
/// file cannot be read or is not what it should be, the list has objects, the device has no room, a stroke cannot be
/// made, or `progress` asks to stop before the first file. Fails, with the files before it written, if a file cannot be
/// written or `progress` asks to stop before it.
pub fn replay(
    context: &Context,
    wanted: &Replay,
    progress: &mut dyn Progress,
) -> std::result::Result<(StrokeReport, Vec<String>), Failure> {
    if wanted.outputs.is_empty() {
        return Err(Error::invalid("there is nothing to write").advise("name a file to write").into());
    }
    for path in &wanted.outputs {
        let known = extension(path).is_some_and(|found| found == EXTENSION || MESHES.contains(&found.as_str()));
        if !known {
            return Err(Error::invalid("it is neither a document nor a mesh")
                .at(path.display().to_string())
                .advise("let it end in .relievo, .obj, .ply, .glb, .usda, .stl or .off")
                .into());
        }
    }
    let text = file::read_text(&wanted.strokes)?;
    let mut allowed = wanted.allowed.clone();
    let mut whole = |path: &Path| -> Result<String> {
        let path = path.canonicalize().map_err(|error| Error::io(path, &error))?;
        allowed.extend(path.parent().map(Path::to_path_buf));
        let name = path.to_str().ok_or_else(|| {
            Error::invalid("its name is not UTF-8").at(path.display().to_string()).advise("rename the file")
        })?;
        Ok(toml::Value::from(name).to_string())
    };
    let mesh = whole(&wanted.mesh)?;
    let (mut document, mut triangles) = (String::new(), wanted.triangles);
    if let Some(path) = &wanted.document {
        document = format!("document = {}\n", whole(path)?);
        triangles |= Document::open(path, context.memory_limit())?.topology().is_of_triangles();
    }
    let kind = match (triangles, wanted.isolation) {
        (true, _) => "kind = \"triangles\"\n".to_owned(),
        (false, Some(levels)) => format!("isolation = {levels}\n"),
        (false, None) => String::new(),
    };
    let object = format!(
        "\n[meshes.replayed]\nfile = {mesh}\n[surfaces.replayed]\nmesh = \"replayed\"\n{kind}\
         [objects.replayed]\nsurface = \"replayed\"\n{document}"
    );
    let scene = file::parse(&wanted.strokes, &format!("{text}{object}"))?;
    if scene.objects.len() != 1 {
        return Err(alone(&wanted.strokes).into());
    }
    let mut world =
        World::new(context, scene, &allowed).map_err(|failure| about_mesh(failure, text.len(), &wanted.mesh))?;
    world.use_device(wanted.device.as_ref())?;
    let (mut done, mut refusals) = (StrokeReport::default(), Refusals::default());
    laying::make_due(context, &mut world, |_| true, &mut refusals)?;
    let (strokes, mut made, mut asked) = (world.scene.strokes.len() as f32, 0.0, Ok(()));
    let go_on = |_: &StrokeEntry| {
        if asked.is_ok() {
            asked = progress.step(0.9 * made / strokes, "strokes");
        }
        made += 1.0;
        asked.is_ok()
    };
    strokes::make_due(context, &mut world, go_on, &mut done, &mut refusals)?;
    asked?;
    // What a document brought goes on fading, and what was added to it.
    if let Some(surface) = world.surface_mut(0) {
        surface.states(context)?;
    }
    if let Some(item) = world.triangles_mut(0) {
        item.object.states(context)?;
        item.object.renew(context)?;
    }
    for (index, path) in wanted.outputs.iter().enumerate() {
        progress.step(0.9 + 0.1 * index as f32 / wanted.outputs.len() as f32, "files")?;
        write(context, &world, path)?;
    }
    // Whoever wrote the list gave the surface no name.
    let named = |note: String| match note.strip_prefix("surface `replayed`: ") {
        Some(rest) => format!("{}: {rest}", wanted.mesh.display()),
        None => note,
    };
    let mut notes: Vec<String> = world.notes().into_iter().map(named).collect();
    notes.extend(world.take_device_faults());
    notes.extend(refusals.notes(&world));
    let folded = folds::count(context, &world)?.into_iter();
    notes.extend(folded.map(|(_, counted)| {
        format!("{} is folded: {counted}; sculpt less deep there, or with less height", wanted.mesh.display())
    }));
    Ok((done, notes))
}

/// The strokes of a list with their images as heights, in the order of the file, to be made on something that is no
/// object of a scene. `allowed` has folders besides that of the list that images may be read from.
///
/// # Errors
/// Fails with [`Failure::Scene`] if the list has faults, and with [`Failure::Other`] if it or an image cannot be read
/// or is not what it should be, or the list has objects.
pub fn strokes(context: &Context, path: &Path, allowed: &[PathBuf]) -> std::result::Result<Vec<Stroke>, Failure> {
    let text = file::read_text(path)?;
    // Strokes are on an object; what it is does not matter.
    let object = "\n[meshes.replayed]\nshape = \"terrain\"\n[surfaces.replayed]\nmesh = \"replayed\"\n\
                  [objects.replayed]\nsurface = \"replayed\"\n";
    let scene = file::parse(path, &format!("{text}{object}"))?;
    if scene.objects.len() != 1 {
        return Err(alone(path).into());
    }
    let paths = Paths::new(&scene.path, allowed)?;
    let stamps: Vec<Loaded> =
        scene.stamps.iter().map(|entry| Loaded::new(context, &paths, entry)).collect::<Result<_>>()?;
    let stroke = |entry: &StrokeEntry| {
        let stamp = entry.stamp.and_then(|index| stamps.get(index)).map(|stamp| stamp.sculpt.clone());
        Stroke { stamp, ..entry.stroke.clone() }
    };
    Ok(scene.strokes.iter().map(stroke).collect())
}

/// Reports a fault of the object that is added to a list of strokes, beyond `end`, as one of the mesh.
fn about_mesh(failure: Failure, end: usize, mesh: &Path) -> Failure {
    match &failure {
        Failure::Scene(faults) => match faults.list.first() {
            Some(first) if first.span.start >= end => {
                Error::invalid(&first.what).at(mesh.display().to_string()).advise(first.remedy.clone()).into()
            }
            _ => failure,
        },
        Failure::Other(_) => failure,
    }
}

fn alone(path: &Path) -> Error {
    Error::invalid("a list of strokes has no objects of its own")
        .at(path.display().to_string())
        .advise("use `relievo scene run` for scenes")
}

/// The extension of a path, in small letters.
fn extension(path: &Path) -> Option<String> {
    Some(path.extension()?.to_str()?.to_ascii_lowercase())
}

/// Writes the one surface as a document or a mesh.
fn write(context: &Context, world: &World, path: &Path) -> Result<()> {
    let extension = extension(path).unwrap_or_default();
    if extension == EXTENSION {
        return documents::document(context, world, 0)?.map_or(Ok(()), |document| document.write(path));
    }
    let (mesh, transform) = match world.items().first() {
        Some(Item::Surface(surface)) => (export::displaced_mesh(context, world, 0, surface)?, *surface.transform()),
        Some(Item::Triangles(item)) => (export::triangle_mesh(context, world, 0, item)?, *item.object.transform()),
        _ => return Ok(()),
    };
    let materials = world.materials(0);
    match extension.as_str() {
        "glb" => relievo_meshio::write_glb(path, &[Instance { name: "mesh", mesh: &mesh, transform, materials }]),
        "usd" | "usda" => {
            let transform = stages::axes(world.scene.up).0 * transform;
            let instance = Instance { name: "mesh", mesh: &mesh, transform, materials };
            relievo_meshio::write_usd(path, &[instance], &stages::options(&world.scene))
        }
        "obj" => relievo_meshio::write_obj(path, &mesh, materials),
        _ => relievo_meshio::write(path, &mesh),
    }
}
