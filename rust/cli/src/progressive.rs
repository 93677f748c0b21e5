//! `relievo progressive`

mod device;
mod edits;
mod picture;

use std::collections::VecDeque;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;

use clap::Subcommand;
use relievo_core::{Context, Error, Result};
use relievo_gpu::Device;
use relievo_lod::Progressive;
use relievo_lod::progressive::{ActiveMesh, BuildOptions, Cut, Edit as MeshEdit, EditJournal, Front, Input};
use serde_json::json;

use self::edits::Change;
use self::picture::{Drawing, Panel};
use crate::Outcome;
use crate::args::device::{Adapter, Device as Kind};
use crate::args::limits::Limits;
use crate::bar::Bar;
use crate::mesh::simplify::{Attributes, SEAMS, faces};

#[derive(clap::Args)]
pub struct Arguments {
    #[command(subcommand)]
    task: Task,
}

#[derive(Subcommand)]
enum Task {
    /// Builds a progressive mesh of a mesh.
    Build(Build),
    /// Says what a progressive mesh has, and what one of its levels.
    Show(Show),
    /// Writes one of the levels of a progressive mesh as a mesh.
    Export(Export),
    /// Moves and turns regions of a progressive mesh at levels of their own; all other levels follow.
    Edit(Edit),
    /// Says where the levels of a progressive mesh deviate more than they tell, as they may after large edits.
    Check(Check),
}

#[derive(clap::Args)]
struct Build {
    /// The mesh; its polygons are taken as triangles, and points at the same place as one.
    mesh: PathBuf,
    /// The progressive mesh to write.
    #[arg(short, long, value_name = "FILE.rlvpm")]
    output: PathBuf,
    /// Triangles of the coarsest level.
    #[arg(long, value_name = "N", default_value_t = BuildOptions::default().faces)]
    faces: usize,
    #[command(flatten)]
    attributes: Attributes,
    #[command(flatten)]
    limits: Limits,
}

#[derive(clap::Args)]
struct Show {
    /// The progressive mesh.
    file: PathBuf,
    #[command(flatten)]
    level: Level,
    /// A list of edits, as of `relievo progressive edit`, for the picture.
    #[arg(long, value_name = "FILE", requires = "picture")]
    script: Option<PathBuf>,
    #[command(flatten)]
    moment: Moment,
    #[command(flatten)]
    drawing: Drawing,
    #[command(flatten)]
    limits: Limits,
}

#[derive(clap::Args)]
struct Export {
    /// The progressive mesh.
    file: PathBuf,
    /// The mesh to write: .ply, .glb, .obj, .usda, .stl or .off.
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// A coarse level whose surface is nowhere farther from that of the finest, nor that from it, in units of the mesh. The
    /// distances of some levels are measured.
    #[arg(long, value_name = "E", conflicts_with_all = ["error_relative", "error_estimate", "faces", "ratio"])]
    error: Option<f32>,
    /// As --error, as a share of the diagonal of the mesh's box.
    #[arg(long, value_name = "R", conflicts_with_all = ["error_estimate", "faces", "ratio"])]
    error_relative: Option<f32>,
    /// The coarsest level whose estimated deviation is no more, in units of the mesh. Its distance may be several times as
    /// much.
    #[arg(long, value_name = "E", conflicts_with_all = ["faces", "ratio"])]
    error_estimate: Option<f32>,
    /// The finest level of at most so many triangles.
    #[arg(long, value_name = "N", conflicts_with = "ratio")]
    faces: Option<usize>,
    /// The finest level of at most this share of the triangles, from 0 to 1.
    #[arg(long, value_name = "R")]
    ratio: Option<f64>,
    /// A list of edits, as of `relievo progressive edit`, that are made before.
    #[arg(long, value_name = "FILE")]
    script: Option<PathBuf>,
    #[command(flatten)]
    moment: Moment,
    #[command(flatten)]
    limits: Limits,
}

#[derive(clap::Args)]
struct Moment {
    /// The time in seconds that a list of edits whose handles have keys is taken at.
    #[arg(long, value_name = "S", allow_negative_numbers = true, requires = "script")]
    time: Option<f64>,
}

#[derive(clap::Args)]
struct Edit {
    /// The progressive mesh.
    file: PathBuf,
    /// The list of edits, TOML. Each `[[edit]]` has `error`, `faces` or `ratio` for the level it is made at, or none for
    /// the finest. Each of its `[[edit.handle]]` has `center` and `radius` of what it grabs, `translation`, `axis` and
    /// `angle` in degrees, and `falloff`: constant, linear, smooth, sphere or gaussian. Or it has `[[edit.handle.key]]`,
    /// each with `time` in seconds, `translation`, `axis` and `angle`. Each of its `[[edit.anchor]]`, which
    /// stays, has `center`, `radius` and `falloff`. Or it has `strokes`: a list of strokes that sculpt, as `relievo doc stroke`
    /// takes it, beside this one.
    #[arg(long, value_name = "FILE")]
    script: PathBuf,
    #[command(flatten)]
    moment: Moment,
    /// The progressive mesh to write. Until it is written, edits that are made are kept in a journal beside it, called as it
    /// is with `.journal` after its name: after a kill the same command goes on from there.
    #[arg(short, long, value_name = "FILE.rlvpm")]
    output: PathBuf,
    /// Build it anew of its finest level with the edits, which takes as long as the first time: levels then have their
    /// triangles where the surface needs them now, and deviate by what they tell.
    #[arg(long)]
    rebuild: bool,
    /// What makes the edits. The processor makes strokes in any case. Edits on a graphics device are not kept in a journal.
    #[arg(long, value_enum, default_value = "cpu")]
    device: Kind,
    #[command(flatten)]
    adapter: Adapter,
    #[command(flatten)]
    limits: Limits,
}

#[derive(clap::Args)]
struct Check {
    /// The progressive mesh.
    file: PathBuf,
    #[command(flatten)]
    limits: Limits,
}

/// Without any of these: the finest.
#[derive(clap::Args)]
#[group(multiple = false)]
pub struct Level {
    /// The coarsest level whose estimated deviation is no more, in units of the mesh. Its distance from the finest may be
    /// several times as much.
    #[arg(long, value_name = "E")]
    pub error: Option<f32>,
    /// The finest level of at most so many triangles.
    #[arg(long, value_name = "N")]
    pub faces: Option<usize>,
    /// The finest level of at most this share of the triangles, from 0 to 1.
    #[arg(long, value_name = "R")]
    pub ratio: Option<f64>,
}

impl Level {
    pub fn cut(&self, mesh: &Progressive) -> Result<Cut> {
        if let Some(error) = self.error {
            if error.is_nan() || error < 0.0 {
                return Err(Error::invalid(format!("{error} is no length")).at("--error").advise("use 0 or more"));
            }
            return Ok(Cut::of_error(error));
        }
        let faces = faces(self.faces, self.ratio, mesh.triangle_count())?;
        Ok(faces.map_or(Cut::FINEST, |faces| Cut::of_faces(mesh, faces)))
    }
}

pub fn run(arguments: &Arguments) -> Outcome {
    match &arguments.task {
        Task::Build(arguments) => build(arguments),
        Task::Show(arguments) => show(arguments),
        Task::Export(arguments) => export(arguments),
        Task::Edit(arguments) => edit(arguments),
        Task::Check(arguments) => check(arguments),
    }
}

fn build(arguments: &Build) -> Outcome {
    let context = arguments.limits.context()?;
    let mesh = relievo_meshio::read(&context, &arguments.mesh)?;
    let options = BuildOptions { faces: arguments.faces, ..BuildOptions::default() };
    let attributes = arguments.attributes.options();
    let (built, left_out) =
        Progressive::build_mesh(&context, &mesh, &options, &attributes, &mut Bar::new()).map_err(|error| {
            crate::mesh::advice::offered(error, &mesh, &arguments.mesh).at(arguments.mesh.display().to_string())
        })?;
    left_out.iter().for_each(|name| eprintln!("note: {name} is left out"));
    built.save(&context, &arguments.output)?;
    let base = built.base_faces().len();
    if base > options.faces.max(1) {
        if !built.attributes().is_empty() {
            eprintln!("note: {SEAMS}");
        }
        crate::mesh::advice::note_non_manifold(&mesh, &arguments.mesh);
    }
    crate::print(&format!("{} triangles, {base} in the base\n", built.triangle_count()))?;
    Ok(ExitCode::SUCCESS)
}

fn show(arguments: &Show) -> Outcome {
    let context = arguments.limits.context()?;
    let mesh = Arc::new(Progressive::open(&context, &arguments.file, usize::MAX)?);
    let cut = arguments.level.cut(&mesh)?;
    let mut active = ActiveMesh::new(&mesh);
    active.adapt(&context, cut);
    let splits = mesh.splits();
    let error =
        splits.filter(|(split, key, _)| !cut.has(*key, *split)).map(|(_, key, _)| key.error()).fold(0.0, f32::max);
    tell_levels(&mesh, &arguments.file, false)?;
    crate::print(&format!(
        "  this level: {} vertices, {} triangles, estimated deviation {error}\n",
        active.vertex_count(),
        active.triangle_count(),
    ))?;
    if arguments.drawing.is_wanted() {
        let device = arguments.drawing.device(arguments.limits.memory_limit)?;
        let panels = panels(&context, arguments, device.as_ref(), &mesh, active)?;
        arguments.drawing.draw(&context, device.as_ref(), &panels)?;
    }
    Ok(ExitCode::SUCCESS)
}

/// Prints what is in the progressive mesh at `path`, `for_programs` as JSON.
pub fn tell(context: &Context, path: &Path, for_programs: bool) -> Outcome {
    tell_levels(&Progressive::open(context, path, usize::MAX)?, path, for_programs)?;
    Ok(ExitCode::SUCCESS)
}

fn tell_levels(mesh: &Progressive, path: &Path, for_programs: bool) -> Result<()> {
    let names: Vec<&str> = mesh.attributes().iter().map(|attribute| attribute.name.as_str()).collect();
    let finest = (mesh.vertex_count(), mesh.triangle_count());
    let base = (mesh.base_vertices().len(), mesh.base_faces().len());
    let text = match for_programs {
        true => {
            let level = |(vertices, triangles)| json!({ "vertices": vertices, "triangles": triangles });
            let value = json!({ "attributes": names, "finest": level(finest), "base": level(base) });
            format!("{value:#}\n")
        }
        false => {
            let attributes =
                if names.is_empty() { String::new() } else { format!("  attributes: {}\n", names.join(", ")) };
            format!(
                "{}\n{attributes}  finest: {} vertices, {} triangles\n  base: {} vertices, {} triangles\n",
                path.display(),
                finest.0,
                finest.1,
                base.0,
                base.1,
            )
        }
    };
    crate::print(&text)
}

/// The level that is asked for, or what a list of edits does.
fn panels(
    context: &Context,
    arguments: &Show,
    device: Option<&Device>,
    mesh: &Arc<Progressive>,
    mut active: ActiveMesh,
) -> Result<Vec<Panel>> {
    let Some(script) = &arguments.script else {
        let level = device.map(|device| device::level(device, mesh, active.cut())).transpose()?;
        return Ok(vec![Panel { mesh: active.extract(), level, edit: None }]);
    };
    let list = (&**script, self::edits::read(context, script, arguments.moment.time)?);
    active.adapt(context, Cut::FINEST);
    let mut panels = vec![Panel { mesh: active.extract(), level: None, edit: None }];
    edit_by(context, (&mut active, None), mesh, list, |active, edit, _| {
        panels.push(Panel { mesh: active.extract(), level: None, edit: Some(edit.clone()) });
        Ok(())
    })?;
    active.adapt(context, Cut::FINEST);
    panels.push(Panel { mesh: active.extract(), level: None, edit: None });
    Ok(panels)
}

/// A journal, and the edits that were in it.
struct Kept {
    journal: EditJournal,
    found: VecDeque<(Front, Input)>,
}

impl Kept {
    /// The journal at `path`, whose edits are made again.
    fn open(context: &Context, path: &Path, active: &mut ActiveMesh) -> Result<Self> {
        let (journal, found) = EditJournal::open(context, path, active)?;
        if let Some(note) = found.note {
            eprintln!("note: {}: {note}", path.display());
        }
        Ok(Self { journal, found: found.edits.into() })
    }
}

/// Makes an edit at a level unless it is the next edit of the journal. Returns how many vertices it
/// reached, if it was made.
fn make(
    context: &Context,
    active: &mut ActiveMesh,
    kept: &mut Option<Kept>,
    (cut, input): (Cut, Input),
) -> Result<Option<usize>> {
    if let Some(found) = kept.as_mut().and_then(|kept| kept.found.pop_front()) {
        if found == (Front::Cut(cut), input) {
            return Ok(None);
        }
        return Err(other_edits());
    }
    active.adapt(context, cut);
    let made = match (kept, &input) {
        (None, input) => input.make(context, active)?,
        (Some(kept), Input::Edit(edit)) => kept.journal.edit(context, active, edit)?,
        (Some(kept), Input::Stroke(stroke)) => kept.journal.sculpt(context, active, stroke)?.vertices,
    };
    Ok(Some(made))
}

/// Makes the edits of a list at their levels. `then` gets the mesh after each, and how many vertices it reached; `None`
/// of edits that were in the journal.
fn edit_by(
    context: &Context,
    (active, mut kept): (&mut ActiveMesh, Option<Kept>),
    mesh: &Progressive,
    (script, list): (&Path, Vec<(Level, Change)>),
    mut then: impl FnMut(&ActiveMesh, &MeshEdit, Option<usize>) -> Result<()>,
) -> Result<()> {
    for (index, (level, change)) in list.into_iter().enumerate() {
        let place = || format!("{}: edit {}", script.display(), index + 1);
        let cut = level.cut(mesh).map_err(|error| error.at(place()))?;
        let mut make = |input| make(context, active, &mut kept, (cut, input)).map_err(|error| error.at(place()));
        let (edit, reached) = match change {
            Change::Edit(edit) => {
                let reached = make(Input::Edit(edit.clone()))?;
                (edit, reached)
            }
            Change::Strokes(strokes) => {
                let mut reached = None;
                for stroke in strokes {
                    if let Some(more) = make(Input::Stroke(Box::new(stroke)))? {
                        reached = Some(reached.unwrap_or(0) + more);
                    }
                }
                (MeshEdit::default(), reached)
            }
        };
        then(active, &edit, reached)?;
    }
    // The mesh has all edits of the journal, the list may not.
    if kept.is_some_and(|kept| !kept.found.is_empty()) { Err(other_edits()) } else { Ok(()) }
}

fn other_edits() -> Error {
    Error::invalid("the journal beside the output has other edits")
        .advise("use the list of edits it was begun with, or remove it")
}

fn export(arguments: &Export) -> Outcome {
    let context = arguments.limits.context()?;
    // Edits reach what is finer too.
    let faces = arguments.faces.filter(|_| arguments.script.is_none());
    let mesh = Arc::new(Progressive::open(&context, &arguments.file, faces.unwrap_or(usize::MAX))?);
    let mut active = ActiveMesh::new(&mesh);
    if let Some(script) = &arguments.script {
        let list = (&**script, self::edits::read(&context, script, arguments.moment.time)?);
        edit_by(&context, (&mut active, None), &mesh, list, |_, _, _| Ok(()))?;
    }
    let bound = if arguments.error.or(arguments.error_relative).is_some() {
        active.adapt(&context, Cut::FINEST);
        crate::mesh::simplify::bound(arguments.error, arguments.error_relative, &active.to_mesh().0.points)?
    } else {
        None
    };
    let distance = match bound {
        Some(bound) => format!(", distance at most {}", active.adapt_within(&context, bound, &mut Bar::new())?),
        None => {
            let Export { error_estimate: error, faces, ratio, .. } = *arguments;
            active.adapt(&context, Level { error, faces, ratio }.cut(&mesh)?);
            String::new()
        }
    };
    let (made, _) = active.to_mesh();
    let (vertices, triangles) = (active.vertex_count(), active.triangle_count());
    relievo_meshio::write(&arguments.output, &made)?;
    crate::print(&format!("{triangles} triangles, {vertices} vertices{distance}\n"))?;
    Ok(ExitCode::SUCCESS)
}

fn edit(arguments: &Edit) -> Outcome {
    let context = arguments.limits.context()?;
    let device = arguments.adapter.open(arguments.device, arguments.limits.memory_limit)?;
    let list = (&*arguments.script, self::edits::read(&context, &arguments.script, arguments.moment.time)?);
    let mesh = Arc::new(Progressive::open(&context, &arguments.file, usize::MAX)?);
    let mut journal = arguments.output.clone().into_os_string();
    journal.push(".journal");
    let journal = PathBuf::from(journal);
    let told = |index: usize, [reached, vertices]: [usize; 2]| {
        crate::print(&format!("edit {index}: {reached} of {vertices} vertices\n"))
    };
    let mut active = match &device {
        Some(_) if journal.exists() => {
            return Err(Error::invalid("the processor has begun a journal of edits there")
                .at(journal.display().to_string())
                .advise("go on from it with --device cpu, or remove it")
                .into());
        }
        Some(device) => device::edited(&context, device, &mesh, list, told)?,
        None => {
            let mut active = ActiveMesh::new(&mesh);
            let kept = Kept::open(&context, &journal, &mut active)?;
            let mut index = 0;
            edit_by(&context, (&mut active, Some(kept)), &mesh, list, |active, _, reached| {
                index += 1;
                match reached {
                    Some(reached) => told(index, [reached, active.vertex_count()]),
                    None => crate::print(&format!("edit {index}: from the journal\n")),
                }
            })?;
            active
        }
    };
    let made = if arguments.rebuild {
        let options = BuildOptions { faces: mesh.base_faces().len(), ..BuildOptions::default() };
        active.rebuilt(&context, &options, &mut Bar::new())?
    } else {
        let misplaced = active.misplaced(&context).len();
        if misplaced > 0 {
            eprintln!(
                "note: {misplaced} splits deviate more than twice as much as they tell; --rebuild puts them in order"
            );
        }
        active.settled(&context)
    };
    made.save(&context, &arguments.output)?;
    if device.is_none() {
        std::fs::remove_file(&journal).map_err(|error| Error::io(&journal, &error))?;
    }
    Ok(ExitCode::SUCCESS)
}

/// How many splits are listed one by one.
const TOLD: usize = 5;

fn check(arguments: &Check) -> Outcome {
    let context = arguments.limits.context()?;
    let mesh = Arc::new(Progressive::open(&context, &arguments.file, usize::MAX)?);
    let misplaced = ActiveMesh::new(&mesh).misplaced(&context);
    crate::print(&format!(
        "{}: {} of {} splits deviate more than twice as much as they tell\n",
        arguments.file.display(),
        misplaced.len(),
        mesh.splits().count()
    ))?;
    for split in misplaced.iter().take(TOLD) {
        let [x, y, z] = split.point;
        crate::print(&format!("  {} at {x} {y} {z}, {} is told\n", split.now, split.told))?;
    }
    Ok(ExitCode::SUCCESS)
}
