//! What a window is about: an object with its layers, its history and its file. It knows no window.

mod decal;
mod files;
mod layers;
mod press;

use std::ops::Range;
use std::path::{Path, PathBuf};

use glam::DVec3;
use relievo_core::{Context, Error, Mesh, Result};
use relievo_detail::{AnyObject, History, OpenStroke, StrokePoint, StrokeReport, with_object};
use relievo_document::Document;
use relievo_document::format::EXTENSION;

use super::brush::{Brush, Held};
use super::costs::Costs;
use super::object::{SurfaceKind, affordable_cells, kind_of, open_object};
use super::picker::{Picked, Picker};
use super::triangles::{Shades, Triangles};
pub use decal::HandDecal;
use press::Press;

/// Bytes of edits that stay in memory.
const HISTORY: u64 = 256 << 20;

/// What the name of the file ends with that edits are kept in until they are saved.
const AUTOSAVE: &str = "autosave.relievo";

/// Extensions of meshes that are looked for beside a document.
const MESHES: [&str; 9] = ["obj", "ply", "glb", "gltf", "usda", "usd", "usdc", "stl", "off"];

/// Number of a stage in [`super::costs::STAGES`].
const PICK: usize = 0;
const DABS: usize = 1;
const TRIANGLES: usize = 2;

/// What a session begins with.
#[derive(Clone, Debug)]
pub struct Opening {
    /// A mesh or a document.
    pub file: PathBuf,
    /// The mesh that the document was made on; without it the one beside it that has the same name.
    pub mesh: Option<PathBuf>,
    /// What the mesh is taken for: its triangles if it has no other faces and nothing is said. That of a document is what
    /// it was made on.
    pub kind: Option<SurfaceKind>,
    /// Cells along an edge of a face, a power of two from 1 to 256; as many as some hundred thousand triangles allow if
    /// nothing is said.
    pub cells: Option<u32>,
}

/// An object that is looked at and edited.
pub struct Session {
    context: Context,
    mesh: Mesh,
    mesh_path: PathBuf,
    object: AnyObject,
    triangles: Triangles,
    picker: Picker,
    history: History,
    /// The names of edits, done ones and then undone ones.
    labels: Vec<String>,
    /// The file that edits go to.
    document: Option<PathBuf>,
    /// The file that edits are kept in until they are saved.
    autosave: Option<PathBuf>,
    /// Whether edits cannot be kept so.
    is_autosave_refused: bool,
    /// What an earlier session left that was not saved.
    recoverable: Option<PathBuf>,
    stroke: Option<OpenStroke>,
    /// The mesh that is pressed into the surface.
    press: Option<Press>,
    /// The image that is laid on the surface.
    decal: Option<Box<HandDecal>>,
    /// What the edit under way is called.
    label: String,
    /// Points that may be others than the view has.
    changed: Vec<Range<u32>>,
    /// Points that may be others than the caster has.
    moved: Vec<Range<u32>>,
    /// Counts changes of what is seen.
    changes: u64,
    /// The triangles that the caster is of.
    picked_serial: u64,
    /// The brush.
    pub brush: Brush,
    /// What events cost.
    pub costs: Costs,
    /// What the user should know.
    pub message: Option<String>,
    /// Smallest and largest coordinates.
    bounds: [DVec3; 2],
}

impl std::fmt::Debug for Session {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        out.debug_struct("Session").field("mesh", &self.mesh_path).finish_non_exhaustive()
    }
}

/// Whether a file is a document.
fn is_document(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case(EXTENSION))
}

/// The mesh beside a document that has the same name.
fn mesh_beside(document: &Path) -> Result<PathBuf> {
    let found = MESHES.iter().map(|extension| document.with_extension(extension)).find(|path| path.is_file());
    found.ok_or_else(|| {
        Error::invalid("no mesh of the same name is beside the document")
            .at(document.display().to_string())
            .advise("name the mesh after the document")
    })
}

impl Session {
    /// Opens a mesh or a document.
    ///
    /// # Errors
    /// A file cannot be read, the document was made on another mesh or another program works on it, or memory runs out.
    pub fn open(context: Context, opening: &Opening) -> Result<Self> {
        let (mesh_path, document) = match (is_document(&opening.file), &opening.mesh) {
            (true, Some(mesh)) => (mesh.clone(), Some(opening.file.clone())),
            (true, None) => (mesh_beside(&opening.file)?, Some(opening.file.clone())),
            (false, None) => (opening.file.clone(), None),
            (false, Some(_)) => {
                return Err(Error::invalid("a second file is the mesh of a document")
                    .at(opening.file.display().to_string())
                    .advise("name a document, then its mesh"));
            }
        };
        let mesh = relievo_meshio::read(&context, &mesh_path)?;
        let named = |error: Error| error.at(mesh_path.display().to_string());
        let (opened, history) = match &document {
            Some(path) => {
                let (opened, history) = History::open(path, context.memory_limit(), HISTORY)?;
                (Some(opened), history)
            }
            None => (None, History::new(HISTORY)),
        };
        let kind = match &opened {
            Some(document) if document.topology().is_of_triangles() => SurfaceKind::Triangles,
            Some(_) => SurfaceKind::Surface,
            None => opening.kind.unwrap_or_else(|| kind_of(&mesh)),
        };
        let cells = opening.cells.unwrap_or_else(|| affordable_cells(&mesh, kind));
        let (object, notes) = open_object(&context, &mesh, kind, opened.as_ref(), cells).map_err(named)?;
        let triangles = Triangles::new(&context, &object, &mesh, cells).map_err(named)?;
        let picker = Picker::new(triangles.points(), triangles.corners())?;
        let bounds = bounds(triangles.points());
        let autosave = mesh_path.with_extension(AUTOSAVE);
        let recoverable = (document.is_none() && autosave.is_file()).then_some(autosave);
        let edits = history.undo_count() + history.redo_count();
        Ok(Self {
            brush: Brush::new(size(bounds), mean_side(&mesh)),
            labels: (1..=edits).map(|number| format!("edit {number}")).collect(),
            message: (!notes.is_empty()).then(|| notes.join("; ")),
            context,
            mesh,
            mesh_path,
            object,
            triangles,
            picker,
            history,
            document,
            autosave: None,
            is_autosave_refused: false,
            recoverable,
            stroke: None,
            press: None,
            decal: None,
            label: String::new(),
            changed: Vec::new(),
            moved: Vec::new(),
            changes: 0,
            picked_serial: 0,
            costs: Costs::default(),
            bounds,
        })
    }

    /// Smallest and largest coordinates of the triangles as they were opened.
    pub(crate) fn bounds(&self) -> [DVec3; 2] {
        self.bounds
    }

    /// The diagonal of that box, above 0, and the side of a square as large as the mean face.
    pub(crate) fn scale(&self) -> (f64, f64) {
        (size(self.bounds), mean_side(&self.mesh))
    }

    /// Smallest and largest coordinates of the triangles as they are.
    pub(crate) fn extent(&self) -> [DVec3; 2] {
        bounds(self.triangles.points())
    }

    /// The triangles that show the object.
    pub(crate) fn triangles(&self) -> &Triangles {
        &self.triangles
    }

    /// The number of triangles.
    pub fn triangle_count(&self) -> usize {
        self.triangles.corners().len() / 3
    }

    /// The faces of the mesh.
    pub fn face_count(&self) -> usize {
        self.mesh.face_sizes.len()
    }

    /// Takes the points that may be others since this was called last, ascending in parts.
    pub(crate) fn take_changed(&mut self) -> Vec<Range<u32>> {
        std::mem::take(&mut self.changed)
    }

    /// Whether pinching and other changes of vectors can be made.
    pub(crate) fn is_bendable(&mut self) -> bool {
        self.object.canvas().is_bendable()
    }

    /// What a ray meets first on the surface; while a stroke is drawn, on the one that it began on.
    ///
    /// # Errors
    /// The caster has no memory for what changed.
    pub fn pick(&mut self, ray: (DVec3, DVec3)) -> Result<Option<Picked>> {
        if !self.is_drawing() {
            self.follow()?;
        }
        self.costs.stage(PICK, || self.picker.pick(ray))
    }

    /// Brings the caster to the triangles.
    fn follow(&mut self) -> Result<()> {
        if self.picked_serial != self.triangles.serial {
            let made = Picker::new(self.triangles.points(), self.triangles.corners());
            (self.picker, self.picked_serial) = (made?, self.triangles.serial);
        } else if !self.moved.is_empty() {
            self.picker.update(self.triangles.points(), &self.moved)?;
        }
        self.moved.clear();
        Ok(())
    }

    /// Whether a stroke is being drawn, or a tool is being pressed.
    pub fn is_drawing(&self) -> bool {
        self.stroke.is_some() || self.press.as_ref().is_some_and(Press::is_pressing)
    }

    /// A number that is another one whenever what is seen is.
    pub(crate) fn changes(&self) -> u64 {
        self.changes + self.triangles.serial
    }

    /// What colours stand for.
    pub fn shades(&self) -> Shades {
        self.triangles.shades()
    }

    /// Has colours stand for something else.
    pub fn set_shades(&mut self, shades: Shades) {
        self.triangles.set_shades(&self.object, shades, &mut self.changed);
        self.changes += 1;
    }

    /// Begins a stroke with the brush.
    ///
    /// # Errors
    /// The layer that is edited is hidden, another edit is under way, or the journal cannot be written.
    pub fn begin_stroke(&mut self, held: Held) -> Result<()> {
        self.follow()?;
        let label = self.brush.label(held);
        let Self { context, object, history, costs, brush, .. } = self;
        let begun = costs.other("begin", || {
            with_object!(&mut *object, it => history.begin(context, &mut **it, &label))?;
            OpenStroke::begin(context, brush.stroke(held), &mut [object.canvas()])
        });
        match begun {
            Ok(stroke) => {
                self.stroke = Some(stroke);
                self.label = label;
                Ok(())
            }
            Err(error) => {
                if self.history.is_under_way() {
                    with_object!(&mut self.object, it => self.history.abandon(&self.context, &mut **it))?;
                }
                Err(error)
            }
        }
    }

    /// Goes on with the stroke along rays, each with the pressure of the pen from 0 to 1. Rays that miss are left out.
    ///
    /// # Errors
    /// No stroke was begun, or a channel has no memory.
    pub fn extend_stroke(&mut self, rays: &[((DVec3, DVec3), f64)]) -> Result<()> {
        let Some(mut stroke) = self.stroke.take() else {
            return Err(Error::invalid("no stroke was begun").advise("begin one first"));
        };
        self.costs.end_event(false);
        let done = self.extend(&mut stroke, rays);
        self.stroke = Some(stroke);
        self.costs.end_event(done.as_ref().is_ok_and(|dabs| *dabs > 0));
        done.map(drop)
    }

    fn extend(&mut self, stroke: &mut OpenStroke, rays: &[((DVec3, DVec3), f64)]) -> Result<u64> {
        let mut points = Vec::with_capacity(rays.len());
        for (ray, pressure) in rays {
            if let Some(picked) = self.pick(*ray)? {
                points.push(StrokePoint::new(picked.point, pressure.clamp(0.0, 1.0)));
            }
        }
        if points.is_empty() {
            return Ok(0);
        }
        let Self { context, object, costs, .. } = self;
        let reports = costs.stage(DABS, || stroke.extend(context, &mut [object.canvas()], &points))?;
        let dabs = reports.iter().map(|report| report.dabs).sum();
        self.report(reports);
        self.show()?;
        Ok(dabs)
    }

    /// Notes what budgets refused.
    fn report(&mut self, reports: Vec<StrokeReport>) {
        let refused: usize = reports.iter().map(|report| report.report.refused.len()).sum();
        if refused > 0 {
            self.message = Some(format!("{refused} faces got no detail: the budget of memory is used up"));
        }
        StrokeReport::give_back(&self.context, reports);
    }

    /// Ends the stroke: it can be undone from now on.
    ///
    /// # Errors
    /// No stroke was begun, or the journal cannot be written; the stroke is then undone.
    pub fn end_stroke(&mut self) -> Result<()> {
        let Some(stroke) = self.stroke.take() else {
            return Err(Error::invalid("no stroke was begun").advise("begin one first"));
        };
        let Self { context, object, costs, .. } = self;
        let is_drawn = !stroke.stroke().points.is_empty();
        let reports = costs.other("end", || match is_drawn {
            true => stroke.end(context, &mut [object.canvas()], &[]),
            false => Ok(Vec::new()),
        })?;
        self.report(reports);
        self.end_edit()
    }

    /// Takes back the stroke that is being drawn, or what a tool pressed since it was put down.
    ///
    /// # Errors
    /// No stroke was begun, or the journal cannot be written.
    pub fn cancel_stroke(&mut self) -> Result<()> {
        self.stroke = None;
        self.press.iter_mut().for_each(Press::lift);
        let done = with_object!(&mut self.object, it => self.history.abandon(&self.context, &mut **it));
        self.show()?;
        done
    }

    fn end_edit(&mut self) -> Result<()> {
        let Self { context, object, history, costs, .. } = self;
        let ended = costs.other("record", || with_object!(&mut *object, it => history.end(context, &mut **it)));
        self.show()?;
        if ended?.is_some() {
            self.labels.truncate(self.history.undo_count().saturating_sub(1));
            self.labels.push(std::mem::take(&mut self.label));
            self.keep();
        }
        Ok(())
    }

    /// Brings the triangles to the object.
    fn show(&mut self) -> Result<()> {
        let Self { context, object, triangles, costs, .. } = self;
        let mut ranges = Vec::new();
        costs.stage(TRIANGLES, || {
            if let AnyObject::Triangles(object) = object {
                object.renew(context)?;
            }
            triangles.update(context, object, &mut ranges)
        })?;
        self.changes += u64::from(!ranges.is_empty());
        self.moved.extend(ranges.iter().cloned());
        self.changed.extend(ranges);
        Ok(())
    }

    /// Divides faces anew whose details are finer than they show, while no stroke is drawn and no image laid. Returns whether
    /// there are other triangles now.
    ///
    /// # Errors
    /// Memory runs out.
    pub fn refine(&mut self) -> Result<bool> {
        if self.is_drawing() || self.is_laid() {
            return Ok(false);
        }
        let Self { context, object, triangles, costs, mesh, .. } = self;
        costs.other("refine", || triangles.refine(context, object, mesh))
    }

    /// Makes an edit of the layers that can be undone.
    fn edit(&mut self, label: &str, edit: impl FnOnce(&Context, &mut AnyObject) -> Result<()>) -> Result<()> {
        let Self { context, object, history, .. } = self;
        with_object!(&mut *object, it => history.begin(context, &mut **it, label))?;
        let done = edit(context, object);
        self.finish(label, done)
    }

    /// Ends an edit that was made, or takes it back where it failed.
    fn finish(&mut self, label: &str, done: Result<()>) -> Result<()> {
        match done {
            Ok(()) => {
                self.label = label.to_owned();
                self.object.settle(&self.context)?;
                self.end_edit()
            }
            Err(error) => {
                with_object!(&mut self.object, it => self.history.abandon(&self.context, &mut **it))?;
                self.show()?;
                Err(error)
            }
        }
    }

    /// The names of edits, done ones and then undone ones, and how many are done.
    pub fn edits(&self) -> (&[String], usize) {
        (&self.labels, self.history.undo_count())
    }

    /// Undoes or makes again edits until `count` are done.
    ///
    /// # Errors
    /// A stroke is being drawn, or the journal cannot be read or written.
    pub fn go_to(&mut self, count: usize) -> Result<()> {
        let before = self.history.undo_count();
        loop {
            let Self { context, object, history, .. } = self;
            let gone = match history.undo_count().cmp(&count) {
                std::cmp::Ordering::Greater => with_object!(&mut *object, it => history.undo(context, &mut **it))?,
                std::cmp::Ordering::Less => with_object!(&mut *object, it => history.redo(context, &mut **it))?,
                std::cmp::Ordering::Equal => break,
            };
            if gone.is_none() {
                break;
            }
        }
        if self.history.undo_count() == before {
            return Ok(());
        }
        self.object.settle(&self.context)?;
        self.show()
    }

    /// Undoes the last edit, if there is one.
    ///
    /// # Errors
    /// Fails as [`Self::go_to`] does.
    pub fn undo(&mut self) -> Result<()> {
        self.go_to(self.history.undo_count().saturating_sub(1))
    }

    /// Makes the edit that was undone last again, if there is one.
    ///
    /// # Errors
    /// Fails as [`Self::go_to`] does.
    pub fn redo(&mut self) -> Result<()> {
        self.go_to(self.history.undo_count() + 1)
    }

    /// Returns the object as a document.
    ///
    /// # Errors
    /// A block cannot be read.
    pub fn to_document(&mut self) -> Result<Document> {
        self.object.settle(&self.context)?;
        self.object.document(&self.context, &self.mesh)
    }
}

/// The diagonal of a box, above 0.
fn size([low, high]: [DVec3; 2]) -> f64 {
    (high - low).length().max(1e-6)
}

/// The side of a square as large as the mean face of a mesh, above 0.
fn mean_side(mesh: &Mesh) -> f64 {
    let (mut sum, mut start) = (0.0, 0);
    for size in mesh.face_sizes.iter().map(|size| *size as usize) {
        let face = mesh.corners.get(start..start + size).unwrap_or_default();
        let place = |corner: &u32| mesh.points.get(*corner as usize).map(|point| glam::Vec3::from(*point).as_dvec3());
        let places: Vec<DVec3> = face.iter().filter_map(place).collect();
        let double = |pair: &[DVec3]| (pair[0] - places[0]).cross(pair[1] - places[0]);
        sum += places.windows(2).skip(1).map(double).sum::<DVec3>().length() / 2.0;
        start += size;
    }
    (sum / mesh.face_sizes.len().max(1) as f64).sqrt().max(1e-9)
}

/// The box of points.
fn bounds(points: &[[f32; 3]]) -> [DVec3; 2] {
    let places = || points.iter().map(|point| glam::Vec3::from(*point).as_dvec3());
    let (low, high) = (places().fold(DVec3::INFINITY, DVec3::min), places().fold(DVec3::NEG_INFINITY, DVec3::max));
    if low.is_finite() && high.is_finite() { [low, high] } else { [DVec3::ZERO; 2] }
}
