//! From the text of a scene file to its [`Scene`]: values by the schema, names resolved, contradictions found.

use std::io::Read;
use std::path::Path;
use std::sync::Arc;

use glam::DVec3;
use relievo_core::Error;
use toml::de::DeTable;

use crate::format::bodies::read_body;
use crate::format::colliders::{Known, check_colliders, read_colliders};
use crate::format::crowds::read_crowd;
use crate::format::decals::read_decal;
use crate::format::description::*;
use crate::format::diagnostic::{Diagnostic, Failure, Faults};
use crate::format::dielectric::read_dielectric;
use crate::format::layers::{read_decay, read_layers};
use crate::format::names::Names;
use crate::format::placement::Up;
use crate::format::placement::{AT_ORIGIN, read_placement};
use crate::format::reader::{Name, Reader, Table};
use crate::format::riders::read_rider;
use crate::format::schema;
use crate::format::sequence::Pattern;
use crate::format::stamps::read_stamp;
use crate::format::strokes::read_stroke;
use crate::format::tissues::read_tissue;
use crate::format::views::{read_camera, read_output, read_sky, read_sun};
use crate::state::isosurface::read_fluid;
use crate::state::shapes;

/// Scene files larger than this are refused before they are parsed.
pub const MAX_BYTES: u64 = 16 << 20;

/// Reads the scene file at `path`.
///
/// # Errors
/// Fails with [`Failure::Other`] if the file cannot be read, has more than [`MAX_BYTES`] or is not UTF-8, and with
/// [`Failure::Scene`] as [`parse`].
pub fn read_file(path: &Path) -> Result<Scene, Failure> {
    let text = read_text(path)?;
    Ok(parse(path, &text)?)
}

/// The text of the scene file at `path`.
pub(crate) fn read_text(path: &Path) -> relievo_core::Result<String> {
    let failed = |error: std::io::Error| Error::io(path, &error);
    let metadata = std::fs::metadata(path).map_err(failed)?;
    let place = path.display().to_string();
    if !metadata.is_file() {
        return Err(Error::invalid("it is not a file").at(place).advise("name a scene file"));
    }
    let mut bytes = Vec::new();
    let file = std::fs::File::open(path).map_err(failed)?;
    file.take(MAX_BYTES + 1).read_to_end(&mut bytes).map_err(failed)?;
    if bytes.len() as u64 > MAX_BYTES {
        return Err(Error::invalid(format!("a scene file of more than {MAX_BYTES} bytes"))
            .at(place)
            .advise("keep meshes and other data in files of their own"));
    }
    String::from_utf8(bytes).map_err(|error| {
        let line =
            error.as_bytes()[..error.utf8_error().valid_up_to()].iter().filter(|byte| **byte == b'\n').count() + 1;
        Error::invalid("the file is not UTF-8").at(format!("{place}:{line}")).advise("save it as UTF-8")
    })
}

/// Reads a scene from `text`, which came from `path`.
///
/// # Errors
/// Fails with all faults found: the text is not TOML, a key is unknown, missing or twice there, a value is out of
/// range, a name does not exist, or entries contradict each other.
pub fn parse(path: &Path, text: &str) -> Result<Scene, Faults> {
    let text: Arc<str> = text.into();
    let fail = |list: Vec<Diagnostic>| Faults { name: path.display().to_string(), text: text.clone(), list };
    let (root, errors) = DeTable::parse_recoverable(&text);
    if !errors.is_empty() {
        let list = errors.iter().map(|error| {
            let remedy = match error.message() {
                message if message.contains("duplicate") => "keep one of them",
                _ => "write `key = value` with texts in quotes, below [headers] in brackets; `relievo scene schema` shows every key",
            };
            let what = format!("the file is not TOML: {}", error.message());
            Diagnostic::new(error.span().unwrap_or(0..0), what).advise(remedy)
        });
        return Err(fail(list.collect()));
    }
    let mut reader = Reader::default();
    let table = reader.table(&schema::SCENE, root.get_ref(), 0..text.len().min(1));
    let scene = read(&mut reader, table, path, &text);
    match scene {
        Some(scene) if reader.faults.is_empty() => Ok(scene),
        _ => {
            reader.faults.sort_by_key(|fault| fault.span.start);
            Err(fail(reader.faults))
        }
    }
}

fn read(reader: &mut Reader, root: Table, path: &Path, text: &Arc<str>) -> Option<Scene> {
    if !root.has("version") {
        reader.fault(
            Diagnostic::new(root.span(), "the scene does not say its version").advise("begin with `version = 1`"),
        );
    }
    reader.optional_number(root, "version");
    let up = match reader.choice(root, "up") {
        Some("x") => Up::X,
        Some("y") => Up::Y,
        _ => Up::Z,
    };
    let metres = match reader.choice(root, "units") {
        Some("mm") => 0.001,
        Some("cm") => 0.01,
        Some("dm") => 0.1,
        Some("in") => 0.0254,
        Some("ft") => 0.3048,
        _ => 1.0,
    };
    let fps = reader.number(root, "fps");
    let seed = reader.whole(root, "seed") as u32;

    let mesh_tables = reader.named(root, "meshes");
    let surface_tables = reader.named(root, "surfaces");
    let before = reader.faults.len();
    let object_tables = reader.named(root, "objects");
    let refused = reader.faults.len() > before;
    let body_tables = reader.named(root, "bodies");
    let collider_tables = reader.named(root, "colliders");
    let mesh_names = Names::new("meshes", &mesh_tables);
    let surface_names = Names::new("surfaces", &surface_tables);
    let object_names = Names::new("objects", &object_tables);
    // Objects that cannot be used, or may stand in a misspelt section, are reported already.
    if object_tables.is_empty() && !refused && !root.has_unknown_table() {
        reader.fault(Diagnostic::new(root.span(), "the scene has no objects").advise("add [objects.NAME]"));
    }

    // Entries that cannot be made leave a gap, so later indices would be off: with any gap the scene is not returned.
    let tissue = reader.list(root, "tissue");
    let tissue: Vec<_> = tissue.into_iter().map(|table| read_tissue(reader, table, &object_names)).collect();
    let tissue_names: Vec<_> = tissue.iter().map(|entry| entry.as_ref().map(|entry| entry.name.clone())).collect();
    check_names(reader, "tissues", &tissue_names);
    let meshes: Vec<_> =
        mesh_tables.iter().map(|(name, table)| read_mesh(reader, name, *table, &tissue_names)).collect();
    let surfaces: Vec<_> =
        surface_tables.iter().map(|(name, table)| read_surface(reader, name, *table, &mesh_names)).collect();
    let details = reader.sub_table(root, "details");
    let details = read_detail(reader, details, None);
    let objects: Vec<_> = object_tables
        .iter()
        .map(|(name, table)| read_object(reader, name, *table, &mesh_names, &surface_names, &details))
        .collect();
    let bodies: Vec<_> = body_tables
        .iter()
        .map(|(name, table)| read_body(reader, name, *table, &object_names, &objects, metres))
        .collect();
    for (at, body) in bodies.iter().enumerate() {
        let Some(body) = body else { continue };
        if let Some(other) = bodies[..at].iter().flatten().find(|other| other.object == body.object) {
            reader.fault(
                Diagnostic::new(body.name.span.clone(), "two bodies move the same object")
                    .relate(other.name.span.clone(), "the other one")
                    .advise("remove one of them"),
            );
        }
    }
    let imprints = reader.sub_table(root, "imprints");
    let mut settings = relievo_detail::ImprintSettings { seed, ..Default::default() };
    reader.parameters(imprints, |parameter, value| settings.set(parameter.name, value).is_ok());
    let crowds = reader.list(root, "crowds");
    let crowds: Vec<_> = crowds.into_iter().map(|table| read_crowd(reader, table)).collect();
    let crowd_names: Vec<_> = crowds.iter().map(|entry| entry.as_ref().and_then(|entry| entry.name.clone())).collect();
    check_names(reader, "crowds", &crowd_names);
    let known = Known { objects: &object_names, entries: &objects, crowds: &crowd_names };
    let (colliders, crowd_colliders) = read_colliders(reader, &collider_tables, &known, settings);
    check_colliders(reader, &colliders, &crowd_colliders, &bodies);
    let stamp_tables = reader.named(root, "stamps");
    let stamp_names = Names::new("stamps", &stamp_tables);
    let stamps: Vec<_> = stamp_tables.iter().map(|(name, table)| read_stamp(reader, name, *table)).collect();
    let strokes = reader.list(root, "strokes");
    let strokes: Vec<_> =
        strokes.into_iter().map(|table| read_stroke(reader, table, &object_names, &objects, &stamp_names)).collect();
    let riders = reader.list(root, "brushes");
    let riders: Vec<_> =
        riders.into_iter().map(|table| read_rider(reader, table, &object_names, &objects, &stamp_names)).collect();
    let decals = reader.list(root, "decals");
    let decals: Vec<_> =
        decals.into_iter().map(|table| read_decal(reader, table, &object_names, &objects, up)).collect();
    let physics = reader.sub_table(root, "physics");
    let physics = PhysicsEntry {
        gravity: reader.optional_vector(physics, "gravity").map_or(up.direction() * (-9.81 / metres), DVec3::from),
        sub_steps: reader.whole(physics, "sub_steps") as u32,
    };
    let camera = reader.sub_table(root, "camera");
    let camera = read_camera(reader, camera, &object_names);
    let sun = reader.sub_table(root, "sun");
    let sun = read_sun(reader, sun, up);
    let sky = reader.sub_table(root, "sky");
    let sky = read_sky(reader, sky);
    let output = reader.sub_table(root, "output");
    let output = read_output(reader, output);
    Some(Scene {
        path: path.to_path_buf(),
        text: text.clone(),
        fps,
        metres,
        up,
        seed,
        meshes: meshes.into_iter().collect::<Option<_>>()?,
        surfaces: surfaces.into_iter().collect::<Option<_>>()?,
        objects: objects.into_iter().collect::<Option<_>>()?,
        bodies: bodies.into_iter().collect::<Option<_>>()?,
        colliders: colliders.into_iter().collect::<Option<_>>()?,
        crowd_colliders: crowd_colliders.into_iter().collect::<Option<_>>()?,
        strokes: strokes.into_iter().collect::<Option<_>>()?,
        riders: riders.into_iter().collect::<Option<_>>()?,
        stamps: stamps.into_iter().collect::<Option<_>>()?,
        decals: decals.into_iter().collect::<Option<_>>()?,
        crowds: crowds.into_iter().collect::<Option<_>>()?,
        tissue: tissue.into_iter().collect::<Option<_>>()?,
        physics,
        camera,
        sun,
        sky,
        output,
    })
}

/// Notes entries of a list that have the same name.
fn check_names(reader: &mut Reader, kind: &str, names: &[Option<Name>]) {
    for (at, name) in names.iter().enumerate() {
        let Some(name) = name else { continue };
        if let Some(other) = names[..at].iter().flatten().find(|other| other.text == name.text) {
            reader.fault(
                Diagnostic::new(name.span.clone(), format!("two {kind} are called `{}`", name.text))
                    .relate(other.span.clone(), "the other one")
                    .advise("give each a name of its own"),
            );
        }
    }
}

fn read_mesh(reader: &mut Reader, name: &Name, table: Table, tissues: &[Option<Name>]) -> Option<MeshEntry> {
    let sources: Vec<_> = ["file", "sequence", "shape", "simulated"].into_iter().filter(|key| table.has(key)).collect();
    let source = match sources[..] {
        [source] => source,
        [] => {
            reader.fault(
                Diagnostic::new(name.span.clone(), format!("mesh `{}` has no source", name.text))
                    .advise("give it `file`, `sequence`, `shape` or `simulated`"),
            );
            return None;
        }
        [first, second, ..] => {
            reader.fault(
                Diagnostic::new(table.span_of(second), format!("mesh `{}` has two sources", name.text))
                    .relate(table.span_of(first), "the other one")
                    .advise("keep one of `file`, `sequence`, `shape` and `simulated`"),
            );
            return None;
        }
    };
    let fitting: &[&str] = match source {
        "file" => &["file", "animation"],
        "sequence" if table.has("tissue") => &["sequence", "first", "count", "tissue", "bound"],
        "sequence" => &["sequence", "first", "count", "tissue"],
        "simulated" => &["simulated", "bound"],
        _ => match reader.choice(table, "shape")? {
            "plane" => &["shape", "size", "faces"],
            "terrain" => &["shape", "size", "faces", "seed"],
            "box" => &["shape", "size", "faces"],
            "sphere" => &["shape", "radius", "faces"],
            "cylinder" => &["shape", "radius", "width", "segments"],
            "wheel" => &["shape", "radius", "width", "lugs", "lug_height"],
            _ => &["shape", "radius", "spikes", "spike_length", "spike_radius"],
        },
    };
    for key in schema::MESH.names().filter(|key| table.has(key) && !fitting.contains(key)) {
        let whose = if source == "shape" { "this shape" } else { "a mesh that is read" };
        reader.fault(
            Diagnostic::new(table.span_of(key), format!("`{key}` means nothing for {whose}"))
                .advise(format!("it takes {}", fitting.join(", "))),
        );
    }
    let source = match source {
        "file" => MeshSource::File { path: reader.text(table, "file")?, animation: reader.text(table, "animation") },
        "sequence" => {
            let pattern = reader.text(table, "sequence")?;
            if let Err(error) = Pattern::new(&pattern.text) {
                reader.fault(Diagnostic::from_error(pattern.span.clone(), &error));
            }
            MeshSource::Sequence {
                pattern,
                first: reader.whole(table, "first"),
                count: reader.whole(table, "count"),
                tissue: reader.text(table, "tissue"),
                bound: reader.text(table, "bound"),
            }
        }
        "simulated" => {
            let (name, bound) = (reader.text(table, "simulated")?, reader.text(table, "bound"));
            let found = tissues.iter().position(|known| known.as_ref().is_some_and(|known| known.text == name.text));
            let Some(tissue) = found else {
                let names: Vec<_> = tissues.iter().flatten().map(|known| format!("`{}`", known.text)).collect();
                let advice = match names.is_empty() {
                    true => "add [[tissue]]".to_owned(),
                    false => format!("use {}", names.join(" or ")),
                };
                let what = format!("there is no `{}` in [[tissue]]", name.text);
                reader.fault(Diagnostic::new(name.span.clone(), what).advise(advice));
                return None;
            };
            MeshSource::Tissue { name, tissue, bound }
        }
        _ => MeshSource::Shape(read_shape(reader, table)?),
    };
    Some(MeshEntry { name: name.clone(), source })
}

fn read_shape(reader: &mut Reader, table: Table) -> Option<shapes::Shape> {
    use shapes::Shape;
    let size = reader.vector(table, "size").map(|value| value as f32);
    if table.has("size") && size.iter().any(|value| *value <= 0.0) {
        reader.fault(Diagnostic::new(table.span_of("size"), "`size` must be positive"));
        return None;
    }
    let faces = reader.whole(table, "faces") as u32;
    let radius = reader.number(table, "radius") as f32;
    let width = reader.number(table, "width") as f32;
    let segments = reader.whole(table, "segments") as u32;
    let seed = reader.whole(table, "seed") as u32;
    let lugs = reader.whole(table, "lugs") as u32;
    let lug_height = reader.number(table, "lug_height") as f32;
    let spikes = reader.whole(table, "spikes") as u32;
    let spike_length = reader.number(table, "spike_length") as f32;
    let spike_radius = reader.number(table, "spike_radius") as f32;
    let too_large = |key: &str| {
        Diagnostic::new(table.span_of(key), format!("`{key}` is too large for the radius"))
            .advise(format!("use less than {}", radius * 0.5))
    };
    Some(match reader.choice(table, "shape")? {
        "plane" => Shape::Plane { size: [size[0], size[1]], faces },
        "terrain" => Shape::Terrain { size, faces, seed },
        "box" => Shape::Box { size, faces },
        "sphere" => Shape::Sphere { radius, faces },
        "cylinder" => Shape::Cylinder { radius, width, segments },
        "wheel" => {
            if lug_height >= radius * 0.5 {
                reader.fault(too_large("lug_height"));
                return None;
            }
            Shape::Wheel { radius, width, lugs, lug_height }
        }
        _ => {
            if spike_radius >= radius * 0.5 {
                reader.fault(too_large("spike_radius"));
                return None;
            }
            Shape::SpikedBall { radius, spikes, spike_length, spike_radius }
        }
    })
}

fn read_surface(reader: &mut Reader, name: &Name, table: Table, meshes: &Names) -> Option<SurfaceEntry> {
    let isolation = reader.optional_number(table, "isolation").map(|levels| levels as u32);
    let sharp_corners = reader.choice(table, "boundary") == Some("edge_and_corner");
    let longest_edge = reader.optional_number(table, "longest_edge");
    let triangles = (reader.choice(table, "kind") == Some("triangles")).then_some(TrianglesEntry { longest_edge });
    let (unfit, kind): (&[&str], _) = match triangles {
        Some(_) => (&["isolation", "boundary"], "triangles"),
        None => (&["longest_edge"], "a Catmull-Clark surface"),
    };
    for key in unfit.iter().filter(|key| table.has(key)) {
        reader.fault(
            Diagnostic::new(table.span_of(key), format!("`{key}` means nothing for {kind}")).advise("remove it"),
        );
    }
    let Some(mesh) = reader.text(table, "mesh") else {
        if !table.has("mesh") {
            reader.fault(
                Diagnostic::new(name.span.clone(), format!("surface `{}` has no control cage", name.text))
                    .advise("give it `mesh`"),
            );
        }
        return None;
    };
    Some(SurfaceEntry { name: name.clone(), mesh: meshes.find(reader, &mesh)?, isolation, sharp_corners, triangles })
}

fn read_detail(reader: &mut Reader, table: Table, general: Option<&DetailEntry>) -> DetailEntry {
    let mut own = DetailEntry {
        tile_size: reader.whole(table, "tile_size") as u32,
        paint_size: reader.whole(table, "paint_size") as u32,
        halves: reader.choice(table, "paint_format") == Some("rgba16f"),
        segments: reader.whole(table, "segments") as u32,
        budget: reader.whole(table, "budget"),
        page: reader.flag(table, "page"),
    };
    if let Some(general) = general {
        if !table.has("tile_size") {
            own.tile_size = general.tile_size;
        }
        if !table.has("paint_size") {
            own.paint_size = general.paint_size;
        }
        if !table.has("paint_format") {
            own.halves = general.halves;
        }
        if !table.has("segments") {
            own.segments = general.segments;
        }
        if !table.has("budget") {
            own.budget = general.budget;
        }
        if !table.has("page") {
            own.page = general.page;
        }
    }
    own
}

fn read_object(
    reader: &mut Reader,
    name: &Name,
    table: Table,
    meshes: &Names,
    surfaces: &Names,
    details: &DetailEntry,
) -> Option<ObjectEntry> {
    let placement = read_placement(reader, table, AT_ORIGIN);
    let colour = reader.colour(table, "colour");
    let specular = reader.number(table, "specular") as f32;
    let roughness = reader.number(table, "roughness") as f32;
    let visible = reader.flag(table, "visible");
    let detail = reader.sub_table(table, "detail");
    let detail = read_detail(reader, detail, Some(details));
    let document = reader.text(table, "document");
    let layers = read_layers(reader, table);
    let decay = read_decay(reader, table);
    let traces = table.has("traces").then(|| {
        let table = reader.sub_table(table, "traces");
        TintEntry {
            colour: reader.colour(table, "colour"),
            depth: reader.number(table, "depth") as f32,
            fade: reader.number(table, "fade") as f32,
        }
    });
    let fluid = read_fluid(reader, name, table);
    let dielectric = read_dielectric(reader, table);
    let role = if table.has("role") { reader.choice(table, "role") } else { None };
    let geometry = match (table.has("surface"), table.has("mesh")) {
        (true, false) => {
            let surface = reader.text(table, "surface")?;
            Geometry::Surface(surfaces.find(reader, &surface)?)
        }
        (false, true) => {
            let mesh = reader.text(table, "mesh")?;
            Geometry::Mesh(meshes.find(reader, &mesh)?)
        }
        (true, true) => {
            reader.fault(
                Diagnostic::new(table.span_of("mesh"), format!("object `{}` has a surface and a mesh", name.text))
                    .relate(table.span_of("surface"), "the surface")
                    .advise("keep one of them"),
            );
            return None;
        }
        (false, false) => {
            reader.fault(
                Diagnostic::new(name.span.clone(), format!("object `{}` shows nothing", name.text))
                    .advise("give it `surface` or `mesh`"),
            );
            return None;
        }
    };
    let deformable = role.map_or(matches!(geometry, Geometry::Surface(_)), |role| role == "deformable");
    if deformable && matches!(geometry, Geometry::Mesh(_)) {
        reader.fault(
            Diagnostic::new(table.span_of("role"), "a mesh cannot be deformable")
                .advise("make a surface over the mesh and give the object that `surface`"),
        );
    }
    if !layers.is_empty() && matches!(geometry, Geometry::Mesh(_)) {
        reader.fault(
            Diagnostic::new(table.span_of("layers"), "a mesh has no layers")
                .advise("make a surface over the mesh and give the object that `surface`"),
        );
    }
    if decay.is_some() && matches!(geometry, Geometry::Mesh(_)) {
        reader.fault(
            Diagnostic::new(table.span_of("decay"), "a mesh has no edits that could fade")
                .advise("make a surface over the mesh and give the object that `surface`"),
        );
    }
    if traces.is_some() && matches!(geometry, Geometry::Mesh(_)) {
        reader.fault(
            Diagnostic::new(table.span_of("traces"), "nothing leaves traces on a mesh")
                .advise("make a surface over the mesh and give the object that `surface`"),
        );
    }
    if table.has("fluid") && matches!(geometry, Geometry::Surface(_)) {
        reader.fault(
            Diagnostic::new(table.span_of("fluid"), "the points of a surface are no fluid")
                .advise("give the object the `mesh` whose points are the particles"),
        );
    }
    if let (Some(document), Geometry::Mesh(_)) = (&document, geometry) {
        reader.fault(
            Diagnostic::new(document.span.clone(), "a mesh has no tiles that a document could fill")
                .advise("make a surface over the mesh and give the object that `surface`"),
        );
    }
    Some(ObjectEntry {
        name: name.clone(),
        geometry,
        placement,
        colour,
        specular,
        roughness,
        deformable,
        decay,
        traces,
        fluid,
        dielectric,
        visible,
        layers,
        detail,
        document,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const GOOD: &str = r##"version = 1
[meshes.ground]
shape = "plane"
[meshes.tool]
shape = "sphere"
[surfaces.ground]
mesh = "ground"
[objects.ground]
surface = "ground"
colour = "#ff8000"
[objects.tool]
mesh = "tool"
translation = [0, 0, 0.4]
[bodies.tool]
keyframes = [{ time = 0 }, { time = 1, translation = [1, 0, 0.4], rotation = [0, 720, 0] }]
[colliders.tool]
into = "ground"
"##;

    fn faults(text: &str) -> Vec<Diagnostic> {
        parse(Path::new("a.toml"), text).map_or_else(|faults| faults.list, |_| Vec::new())
    }

    #[test]
    fn a_good_scene_is_read_with_its_defaults() {
        let scene = parse(Path::new("a.toml"), GOOD).unwrap();
        assert_eq!(scene.fps, 24.0);
        assert!(scene.objects[0].deformable && !scene.objects[1].deformable);
        assert_eq!(scene.colliders[0].into, [0]);
        assert_eq!(scene.bodies[0].motion, Motion::Keyframed);
        let last = scene.bodies[0].keyframes[1].placement;
        assert!((last.rotation.y - 4.0 * std::f64::consts::PI).abs() < 1e-12);
        assert!((scene.objects[0].colour[0] - 1.0).abs() < 1e-6 && scene.objects[0].colour[2] == 0.0);
        assert!((scene.physics.gravity - DVec3::new(0.0, 0.0, -9.81)).length() < 1e-12);
    }

    /// Replaces `from` in the good scene, and expects a fault whose span reads `at` and whose message or remedy
    /// contains `says`.
    #[test]
    fn bad_scenes_are_refused_at_the_right_place_with_advice() {
        let cases: &[(&str, &str, &str, &str)] = &[
            ("version = 1", "version = 2", "2", "whole number from 1 to 1"),
            ("version = 1", "", "", "does not say its version"),
            ("version = 1", "version = 1\nfpz = 25", "fpz", "did you mean `fps`?"),
            ("version = 1", "version = 1\nfps = \"fast\"", "\"fast\"", "must be a number"),
            ("version = 1", "version = 1\nfps = nan", "nan", "not a finite number"),
            ("version = 1", "version = 1\nfps = 0", "0", "out of range"),
            ("version = 1", "version = 1\nup = \"w\"", "\"w\"", "use one of x, y, z"),
            ("version = 1", "version = 1\n[camera]\nposition = [1, 2]", "[1, 2]", "give three"),
            ("version = 1", "version = 1\n[camera]\nposition = [1, 2, 3]\ntarget = [1, 2, 3]", "[1, 2, 3]", "looks at"),
            ("version = 1", "version = 1\n[sky]\nzenith = \"#12345\"", "\"#12345\"", "rrggbb"),
            ("version = 1", "version = 1\n[details]\ntile_size = 100", "100", "power of two"),
            ("shape = \"plane\"", "shape = \"plain\"", "\"plain\"", "did you mean \"plane\"?"),
            ("shape = \"plane\"", "", "ground", "has no source"),
            ("shape = \"plane\"", "shape = \"plane\"\nfile = \"a.obj\"", "\"plane\"", "two sources"),
            ("shape = \"plane\"", "shape = \"plane\"\nlugs = 8", "8", "means nothing for this shape"),
            ("shape = \"plane\"", "sequence = \"a.obj\"", "\"a.obj\"", "\"walk.%04d.obj\""),
            ("shape = \"plane\"", "sequence = \"a.%02d.#.obj\"", "\"a.%02d.#.obj\"", "two places for the number"),
            ("mesh = \"ground\"", "mesh = \"grund\"", "\"grund\"", "did you mean `ground`?"),
            ("mesh = \"ground\"", "", "ground", "no control cage"),
            ("surface = \"ground\"", "surface = \"ground\"\nmesh = \"ground\"", "\"ground\"", "keep one"),
            ("surface = \"ground\"", "", "ground", "shows nothing"),
            ("mesh = \"tool\"", "mesh = \"tool\"\nrole = \"deformable\"", "\"deformable\"", "make a surface"),
            ("mesh = \"tool\"", "mesh = \"tool\"\nfluid = { cell = 0.5 }", "{ cell", "not said"),
            ("mesh = \"tool\"", "mesh = \"tool\"\nfluid = { spacing = 1, function = \"blob\" }", "\"blob\"", "blobs"),
            ("surface = \"ground\"", "surface = \"ground\"\nfluid = { spacing = 1 }", "{ spacing", "no fluid"),
            (
                "mesh = \"tool\"",
                "mesh = \"tool\"\ndielectric = { absorption = [-1, 0, 0] }",
                "[-1, 0, 0]",
                "index of refraction",
            ),
            ("mesh = \"tool\"", "mesh = \"tool\"\nscale = -1", "-1", "mirrored"),
            ("mesh = \"tool\"", "mesh = \"tool\"\nmesh = \"tool\"", "mesh", "duplicate key"),
            ("[bodies.tool]", "[bodies.tool]\nmass = 3", "3", "forces do not move"),
            ("[bodies.tool]", "[bodies.tool]\nmotion = \"dynamic\"", "[{ time = 0 }", "contradict"),
            ("[bodies.tool]", "[bodies.tools]", "tools", "did you mean `tool`?"),
            ("[bodies.tool]", "[bodies.other]\nobject = \"tool\"\n[bodies.tool]", "tool", "two bodies"),
            ("time = 1,", "time = 0,", "0", "sort keyframes"),
            ("{ time = 0 }", "{ tyme = 0 }", "tyme", "did you mean `time`?"),
            ("into = \"ground\"", "into = \"tool\"", "\"tool\"", "itself"),
            ("into = \"ground\"", "into = [\"ground\", \"ground\"]", "\"ground\"", "listed twice"),
            ("into = \"ground\"", "from = 2\nuntil = 1", "1", "ends before"),
            ("into = \"ground\"", "[colliders.more]\nobject = \"tool\"", "more", "two colliders"),
            ("version = 1", "version = 1\n[bodies.ground]\nshape = \"trimesh\"", "\"trimesh\"", "must be convex"),
            ("version = 1", "version = 1\n[bodies.ground]\nmass = 1\ndensity = 1", "1", "either a mass or a density"),
            ("version = 1", "version = 1\n[bodies.ground]\nmotor_speed = 1", "1", "no axis"),
            ("version = 1", "version = 1\n[bodies.ground]\nlocked = [\"rq\"]", "\"rq\"", "cannot be"),
            ("version = 1", "version = 1\n[output]\nframes = 1e99", "1e99", "out of range"),
            ("into = \"ground\"", "tool = { }", "{ }", "has no force"),
            ("into = \"ground\"", "tool = { force = [0, 0, 0] }", "[0, 0, 0]", "no direction"),
            ("into = \"ground\"", "tool = { forse = [0, 0, -1] }", "forse", "did you mean `force`?"),
            ("into = \"ground\"", "tool = { force = [0, 0, -1], stiffness = 0 }", "0", "newtons per cubic scene unit"),
            (
                "[bodies.tool]",
                "[colliders.ground]\ntool = { force = [0, 0, -1] }\ninto = []\n[bodies.tool]",
                "{ force",
                "must be rigid",
            ),
            (
                "into = \"ground\"",
                "into = \"ground\"\ntool = { force = [0, 0, -1] }\n[colliders.more]\nobject = \"tool\"\ninto = []",
                "tool",
                "one object at a time",
            ),
            (
                "keyframes = [{ time = 0 }, { time = 1, translation = [1, 0, 0.4], rotation = [0, 720, 0] }]\n\
                 [colliders.tool]",
                "[colliders.tool]\ntool = { force = [0, 0, -1] }",
                "tool",
                "physics and the force",
            ),
            ("[bodies.tool]", "[[strokes]]\nobject = \"ground\"\n[bodies.tool]", "", "does nothing"),
            (
                "[bodies.tool]",
                "[[strokes]]\nobject = \"ground\"\npaint = \"mix\"\n[bodies.tool]",
                "",
                "it has no points",
            ),
            (
                "[bodies.tool]",
                "[[strokes]]\nobject = \"tool\"\npaint = \"mix\"\npoints = [{ position = [0, 0, 0] }]\n[bodies.tool]",
                "\"tool\"",
                "make a surface",
            ),
            (
                "[bodies.tool]",
                "[[strokes]]\nobject = \"ground\"\npaint = \"mixx\"\npoints = [{ position = [0, 0, 0] }]\n[bodies.tool]",
                "\"mixx\"",
                "did you mean \"mix\"?",
            ),
            (
                "[bodies.tool]",
                "[[strokes]]\nobject = \"ground\"\nsculpt = \"draw\"\npoints = [{ position = [0, 0, 0], pressure = nan }]\n[bodies.tool]",
                "nan",
                "not a finite number",
            ),
            (
                "[bodies.tool]",
                "[[strokes]]\nobject = \"ground\"\nsculpt = \"draw\"\nradius = 0.0001\nspacing = 0.01\n\
                 points = [{ position = [0, 0, 0] }, { position = [9, 0, 0] }]\n[bodies.tool]",
                "[{ position",
                "over a million dabs",
            ),
            (
                "[bodies.tool]",
                "[[strokes]]\nobject = \"ground\"\nsculpt = \"draw\"\ncolour = [1, 1, 1]\npoints = [{ position = [0, 0, 0] }]\n[bodies.tool]",
                "[1, 1, 1]",
                "means nothing",
            ),
            (
                "[bodies.tool]",
                "[[strokes]]\npaint = \"mix\"\nsize_curve = [[0, 0], [0, 1]]\npoints = [{ position = [0, 0, 0] }]\n[bodies.tool]",
                "[[0, 0]",
                "sort the points by pressure",
            ),
            (
                "[bodies.tool]",
                "[[strokes]]\npaint = \"mix\"\nsize_curve = [[0, 0, 1]]\npoints = [{ position = [0, 0, 0] }]\n[bodies.tool]",
                "[0, 0, 1]",
                "a pair of numbers",
            ),
            (
                "[bodies.tool]",
                "[[strokes]]\npaint = \"mix\"\nrate = 10\npoints = [{ position = [0, 0, 0] }]\n[bodies.tool]",
                "[{ position",
                "an airbrush",
            ),
            (
                "[bodies.tool]",
                "[stamps.a]\npattern = \"star\"\n[[strokes]]\npaint = \"mix\"\nstamp = \"b\"\npoints = [{ position = [0, 0, 0] }]\n[bodies.tool]",
                "\"b\"",
                "did you mean `a`?",
            ),
            ("[bodies.tool]", "[stamps.a]\n[bodies.tool]", "a", "the stamp has no image"),
            (
                "[bodies.tool]",
                "[stamps.a]\nimage = \"a.png\"\npattern = \"star\"\n[bodies.tool]",
                "\"star\"",
                "cannot be a file and a pattern",
            ),
            ("[bodies.tool]", "[[brushes]]\npaint = \"mix\"\n[bodies.tool]", "", "rides on nothing"),
            (
                "[bodies.tool]",
                "[[brushes]]\nby = \"ground\"\nobject = \"ground\"\npaint = \"mix\"\n[bodies.tool]",
                "\"ground\"",
                "rides on what it is made on",
            ),
            (
                "mesh = \"tool\"",
                "mesh = \"tool\"\ndocument = \"a.relievo\"",
                "\"a.relievo\"",
                "make a surface over the mesh",
            ),
            ("version = 1", "version = ", "", "not TOML"),
        ];
        for (from, to, at, says) in cases {
            let text = GOOD.replacen(from, to, 1);
            let found = faults(&text);
            let fits = |fault: &Diagnostic| {
                let said = format!("{}; {}", fault.what, fault.remedy);
                said.contains(says) && text.get(fault.span.clone()).is_some_and(|bytes| bytes.starts_with(at))
            };
            let advises = |fault: &Diagnostic| !fault.remedy.is_empty() || !fault.label.is_empty();
            assert!(found.iter().all(advises), "{to:?} should say what to do: {found:#?}");
            assert!(found.iter().any(fits), "{to:?} should say {says:?} at {at:?}, but said {found:#?}");
        }
    }

    #[test]
    fn all_faults_of_a_file_are_told_at_once_in_its_order() {
        let text = GOOD.replace("\"plane\"", "\"plain\"").replace("into = \"ground\"", "into = \"gruond\"");
        let found = faults(&text);
        assert!(found.len() >= 2 && found.windows(2).all(|pair| pair[0].span.start <= pair[1].span.start));
    }

    #[test]
    fn objects_that_are_refused_are_not_said_to_be_missing() {
        let missing = |text: &str| faults(text).iter().any(|fault| fault.what.contains("no objects"));
        for text in [
            "version = 1\n[object.a]\nmesh = \"a\"\n",
            "version = 1\n[objects]\na = 3\n",
            "version = 1\n[objects.\"?\"]\nmesh = \"a\"\n",
            "version = 1\nobjects = 3\n",
        ] {
            assert!(!missing(text) && !faults(text).is_empty(), "{text}");
        }
        assert!(missing("version = 1\n") && missing("version = 1\nfpz = 3\n[objects]\n"));
    }

    #[test]
    fn deep_nesting_is_an_error() {
        let text = format!("version = {}{}", "[".repeat(100_000), "]".repeat(100_000));
        assert!(!faults(&text).is_empty());
    }

    proptest::proptest! {
        #[test]
        fn no_text_panics(text in ".{0,200}", cut in 0usize..600, junk in "[\\[\\]={}\"#0-9a-z\\n.,-]{0,12}") {
            drop(parse(Path::new("a.toml"), &text));
            let mut spoiled = GOOD.to_string();
            let cut = cut.min(spoiled.len());
            if spoiled.is_char_boundary(cut) {
                spoiled.insert_str(cut, &junk);
            }
            if let Err(faults) = parse(Path::new("a.toml"), &spoiled) {
                proptest::prop_assert!(!faults.to_string().is_empty());
            }
        }
    }
}
