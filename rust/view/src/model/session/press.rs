//! A mesh that is pressed into the surface by hand (Schäfer et al. 2014, Real-Time Deformation of Subdivision Surfaces from
//! Object Collisions, Section 7, Sculpting Demo): it is put down where the pointer is, as large as the brush, sinks by a share
//! of that size and goes along with the pointer.

use std::path::Path;

use glam::{DAffine3, DMat3, DQuat, DVec3, Vec3};
use relievo_core::{Context, Error, Mesh, Result};
use relievo_detail::tool::foremost;
use relievo_detail::{Collider, ImprintSettings, Imprinter, Moment, Motion, Pose, with_object};

use super::{DABS, Picked, Session};

/// Voxels of an overlap at most: steps of them are finer than the texels that they change.
const VOXELS: u32 = 1 << 20;

/// How far above the surface a tool is put down, as a share of the brush's radius.
const ABOVE: f64 = 0.05;

/// The tool.
pub(super) struct Press {
    name: String,
    collider: Collider,
    /// The middle of its box and half the diagonal, in its own space.
    middle: DVec3,
    reach: f64,
    imprinter: Imprinter,
    /// Where it is, from its own space to the world, while it is shown.
    pose: Option<DAffine3>,
    is_down: bool,
    /// Counts times it was put down.
    count: u64,
    /// Counts events since then.
    step: u32,
}

impl Press {
    /// Whether it is down.
    pub fn is_pressing(&self) -> bool {
        self.is_down
    }

    /// Takes it off the surface.
    pub fn lift(&mut self) {
        self.is_down = false;
    }

    fn new(context: &Context, name: String, mesh: &Mesh) -> Result<Self> {
        let collider = Collider::of_mesh(context, mesh, DAffine3::IDENTITY)?;
        let places = || collider.points().iter().map(|point| Vec3::from(*point).as_dvec3());
        let (low, high) = (places().fold(DVec3::INFINITY, DVec3::min), places().fold(DVec3::NEG_INFINITY, DVec3::max));
        let reach = 0.5 * (high - low).length();
        if !(reach > 0.0 && reach.is_finite()) {
            return Err(Error::invalid("the tool has no size").advise("use a mesh whose points differ"));
        }
        let imprinter = Imprinter::new();
        let middle = 0.5 * (low + high);
        Ok(Self { name, collider, middle, reach, imprinter, pose: None, is_down: false, count: 0, step: 0 })
    }

    /// The pose on a place of a surface, sunk by `depth`, with its z axis along the normal and half its diagonal `radius`.
    fn placed(&mut self, picked: &Picked, radius: f64, depth: f64) -> Result<DAffine3> {
        let turn = DMat3::from_quat(DQuat::from_rotation_arc(DVec3::Z, picked.normal.normalize_or(DVec3::Z)));
        let matrix3 = turn * (radius / self.reach);
        let pose = DAffine3 { matrix3, translation: -(matrix3 * self.middle) };
        self.collider.set_transform(pose)?;
        let front = foremost(&self.collider, -picked.normal).dot(picked.normal);
        let shift = picked.point - picked.normal * (front + depth);
        Ok(DAffine3 { translation: pose.translation + shift, ..pose })
    }
}

impl Session {
    /// Opens a mesh as the tool that is pressed.
    ///
    /// # Errors
    /// The file cannot be read or has no triangles with a size, or a tool is down.
    pub fn open_tool(&mut self, path: &Path) -> Result<()> {
        if self.is_drawing() {
            return Err(Error::invalid("a stroke is being drawn").advise("end it first"));
        }
        let named = |error: Error| error.at(path.display().to_string());
        let mesh = relievo_meshio::read(&self.context, path)?;
        let name = path.file_stem().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
        self.press = Some(Press::new(&self.context, name, &mesh).map_err(named)?);
        Ok(())
    }

    /// The name of the tool, if one was opened.
    pub fn tool(&self) -> Option<&str> {
        self.press.as_ref().map(|press| press.name.as_str())
    }

    /// The tool and where it is, if it is shown.
    pub(crate) fn tool_shown(&self) -> Option<(&Collider, DAffine3)> {
        let press = self.press.as_ref()?;
        Some((&press.collider, press.pose?))
    }

    /// Shows the tool over a place, or hides it.
    ///
    /// # Errors
    /// It cannot be placed there.
    pub(crate) fn hover_tool(&mut self, picked: Option<&Picked>) -> Result<()> {
        let radius = self.brush.radius;
        let Some(press) = self.press.as_mut().filter(|press| !press.is_down) else { return Ok(()) };
        press.pose = picked.map(|picked| press.placed(picked, radius, -ABOVE * radius)).transpose()?;
        Ok(())
    }

    /// Puts the tool down where a ray meets the surface, pressed in by the share of the brush's radius that its strength
    /// times `pressure` says. Returns whether the ray meets it.
    ///
    /// # Errors
    /// There is no tool, the layer that is edited is hidden, another edit is under way, or the journal cannot be written.
    pub fn begin_press(&mut self, ray: (DVec3, DVec3), pressure: f64) -> Result<bool> {
        let Some(picked) = self.pick(ray)? else { return Ok(false) };
        let radius = self.brush.radius;
        let Self { context, object, history, press, .. } = self;
        let Some(press) = press else {
            return Err(Error::invalid("there is no tool to press").advise("open a mesh as the tool first"));
        };
        let label = format!("press {}", press.name);
        with_object!(&mut *object, it => history.begin(context, &mut **it, &label))?;
        press.pose = Some(press.placed(&picked, radius, -ABOVE * radius)?);
        (press.is_down, press.step) = (true, 0);
        press.count += 1;
        self.label = label;
        self.press_at(&picked, pressure)?;
        Ok(true)
    }

    /// Moves the tool to where a ray meets the surface that it was put down on, and presses it in on the way.
    ///
    /// # Errors
    /// The tool is not down, or a channel has no memory.
    pub fn press_to(&mut self, ray: (DVec3, DVec3), pressure: f64) -> Result<()> {
        self.costs.end_event(false);
        match self.pick(ray)? {
            Some(picked) => self.press_at(&picked, pressure),
            None => Ok(()),
        }
    }

    fn press_at(&mut self, picked: &Picked, pressure: f64) -> Result<()> {
        let radius = self.brush.radius;
        let depth = f64::from(self.brush.strength) * pressure.clamp(0.0, 1.0) * radius;
        let Self { context, object, costs, press, .. } = self;
        let Some((press, from)) = press.as_mut().filter(|press| press.is_down).and_then(|press| {
            let from = press.pose?;
            Some((press, from))
        }) else {
            return Err(Error::invalid("no tool is down").advise("put one down first"));
        };
        let to = press.placed(picked, radius, depth)?;
        let settings = ImprintSettings {
            voxels: VOXELS,
            jitter: 0.0,
            max_displacement: (4.0 * radius) as f32,
            ..ImprintSettings::default()
        };
        let moment = Moment { frame: press.count, step: press.step, pair: 0 };
        let report = costs.stage(DABS, || {
            let Press { collider, imprinter, .. } = press;
            let motion = Motion::new(collider, Pose::rigid(from), Pose::rigid(to))?;
            with_object!(object, object => imprinter.sweep(context, &mut **object, collider, &motion, &settings, moment))
        })?;
        (press.pose, press.step) = (Some(to), press.step + 1);
        if !report.refused.is_empty() {
            self.message =
                Some(format!("{} faces got no detail: the budget of memory is used up", report.refused.len()));
        }
        let is_changed = report.changed_coefficients > 0;
        report.give_back(&self.context);
        self.object.settle(&self.context)?;
        self.show()?;
        self.costs.end_event(is_changed);
        Ok(())
    }

    /// Takes the tool off: what it pressed can be undone from now on.
    ///
    /// # Errors
    /// The tool is not down, or the journal cannot be written.
    pub fn end_press(&mut self) -> Result<()> {
        match self.press.as_mut().filter(|press| press.is_down) {
            Some(press) => press.lift(),
            None => return Err(Error::invalid("no tool is down").advise("put one down first")),
        }
        self.end_edit()
    }
}
