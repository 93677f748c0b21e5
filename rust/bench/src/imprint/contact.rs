//! A flattened ball of 20,000 triangles pressed into a surface: the pair that imprints are measured on.

use std::collections::BTreeMap;

use glam::{DAffine3, DQuat, DVec3};
use relievo_core::{Context, Mesh, Result};
use relievo_detail::{
    Collider, DisplacedObject, ImprintSettings, Imprinter, Moment, Motion, Pose, Report, Sweep, TriangleObject,
};
use relievo_surface::{Place, Surface, SurfaceOptions, TriangleSurface};
use relievo_tiles::triangle::{TriangleChannel, TriangleOptions};
use relievo_tiles::{Displacement, DisplacementOptions};

use crate::measure::seconds;
use crate::shapes;

/// A surface, and a ball in proportion to its faces.
pub struct Contact {
    cage: Mesh,
    surface: Surface,
    collider: Collider,
    imprinter: Imprinter,
    radius: f64,
    settings: ImprintSettings,
}

/// One imprint: seconds of every stage by name, of all, and what was done.
pub struct Press {
    /// Seconds of each stage.
    pub stages: BTreeMap<&'static str, f64>,
    /// Seconds in all.
    pub sum: f64,
    /// What was done.
    pub report: Report,
}

/// Height of the ball in parts of its width.
const HEIGHT: f64 = 0.5;
/// How deep the ball goes, in parts of its height. With what the turned voxel grid adds, a tenth of its triangles.
const DEPTH: f64 = 0.04;

impl Contact {
    /// A surface of `cage` and a ball of `radius` in its units.
    pub fn new(context: &Context, cage: Mesh, radius: f64) -> Result<Self> {
        let surface = Surface::new(context, &cage, &SurfaceOptions::default())?;
        let ball = shapes::ball(radius as f32, 100, 101);
        let collider = Collider::of_mesh(context, &ball, DAffine3::IDENTITY)?;
        let settings =
            ImprintSettings { max_displacement: (1.2 * DEPTH * radius) as f32, ..ImprintSettings::default() };
        Ok(Self { cage, surface, collider, imprinter: Imprinter::new(), radius, settings })
    }

    /// The surface.
    pub fn surface(&self) -> &Surface {
        &self.surface
    }

    /// The cage.
    pub fn cage(&self) -> &Mesh {
        &self.cage
    }

    /// The settings of imprints.
    pub fn settings(&self) -> &ImprintSettings {
        &self.settings
    }

    /// The settings of the next imprints.
    pub fn settings_mut(&mut self) -> &mut ImprintSettings {
        &mut self.settings
    }

    /// The surface without a dent, in tiles of `size`.
    pub fn object(&self, context: &Context, size: u32) -> Result<DisplacedObject> {
        let options = DisplacementOptions { size, budget: 1 << 34, ..DisplacementOptions::default() };
        let displacement = Displacement::new(self.surface.topology().clone(), &options)?;
        DisplacedObject::new(context, self.surface.clone(), &self.cage.points, displacement, DAffine3::IDENTITY)
    }

    /// Presses the ball into the surface at `place`, along the normal there and, the second time at a place, a little
    /// deeper.
    pub fn press(
        &mut self,
        context: &Context,
        object: &mut DisplacedObject,
        place: Place,
        again: bool,
    ) -> Result<Press> {
        self.collider.set_transform(self.above(context, place, again)?)?;
        let moment = Moment { frame: u64::from(place.tile), ..Moment::default() };
        let (imprinter, collider, settings) = (&mut self.imprinter, &self.collider, &self.settings);
        timed(context, object, |object| imprinter.imprint(context, object, collider, settings, moment))
    }

    /// Presses balls into the surface at all `places`, a frame's pairs at once. Reports what the last one did.
    pub fn press_all(&mut self, context: &Context, object: &mut DisplacedObject, places: &[Place]) -> Result<Press> {
        let mut colliders = vec![self.collider.clone(); places.len()];
        for (collider, place) in colliders.iter_mut().zip(places) {
            collider.set_transform(self.above(context, *place, false)?)?;
        }
        let settings = &self.settings;
        let moment = |pair| Moment { pair: pair as u32, ..Moment::default() };
        let presses = colliders.iter().enumerate();
        let presses =
            presses.map(|(pair, collider)| relievo_detail::Press { into: 0, collider, settings, moment: moment(pair) });
        let presses: Vec<_> = presses.collect();
        let imprinter = &mut self.imprinter;
        timed(context, object, |object| {
            let reports = imprinter.imprint_all(context, &mut [object], &presses)?;
            Ok(reports.into_iter().next_back().unwrap_or_default())
        })
    }

    /// The cage as a triangle mesh without a dent, with so many segments along an edge.
    pub fn mesh(&self, context: &Context, segments: u32) -> Result<TriangleObject> {
        let surface = TriangleSurface::new(context, &self.cage)?;
        let options = TriangleOptions { segments, budget: 1 << 34 };
        let displacement = TriangleChannel::displacement(surface.topology().clone(), &options)?;
        TriangleObject::new(context, surface, displacement, DAffine3::IDENTITY)
    }

    /// Presses balls into a triangle mesh of the cage at all `places`, a frame's pairs at once. Reports what the last one
    /// did.
    pub fn press_triangles(
        &self,
        context: &Context,
        mesh: &mut TriangleObject,
        places: &[Place],
        settings: &ImprintSettings,
    ) -> Result<Press> {
        let mut colliders = vec![self.collider.clone(); places.len()];
        let still = |(collider, place): (&mut Collider, &Place)| {
            let pose = Pose::rigid(self.above(context, *place, false)?);
            Motion::new(collider, pose.clone(), pose)
        };
        let motions = colliders.iter_mut().zip(places).map(still).collect::<Result<Vec<_>>>()?;
        let sweeps = motions.iter().enumerate().map(|(by, motion)| Sweep {
            into: 0,
            by,
            motion,
            settings,
            moment: Moment { pair: by as u32, ..Moment::default() },
        });
        let sweeps: Vec<_> = sweeps.collect();
        let mut imprinter = Imprinter::new();
        context.stats().take();
        let mut reports = Ok(Vec::new());
        let mut colliders: Vec<&mut Collider> = colliders.iter_mut().collect();
        let sum = seconds(|| {
            reports = imprinter.sweep_all(context, &mut [mesh], &mut colliders, &sweeps);
        });
        let report = reports?.into_iter().next_back().unwrap_or_default();
        Ok(Press { stages: stages(context), sum, report })
    }

    /// Where the ball is that is pressed in at `place`.
    fn above(&self, context: &Context, place: Place, again: bool) -> Result<DAffine3> {
        let sample = self.surface.sample(context.level(), place)?;
        let lift = HEIGHT * self.radius * (1.0 - 2.0 * if again { 1.1 * DEPTH } else { DEPTH });
        let normal = DVec3::from(sample.normal().map(f64::from));
        let center = DVec3::from(sample.p.map(f64::from)) + normal * lift;
        let turn = DQuat::from_rotation_arc(DVec3::Z, normal);
        let flat = DVec3::new(1.0, 1.0, HEIGHT);
        Ok(DAffine3::from_scale_rotation_translation(flat, turn, center))
    }
}

/// Times what `work` does, and the commit after it.
fn timed(
    context: &Context,
    object: &mut DisplacedObject,
    work: impl FnOnce(&mut DisplacedObject) -> Result<Report>,
) -> Result<Press> {
    context.stats().take();
    let mut report = Ok(Report::default());
    let sum = seconds(|| {
        report = work(object);
        object.commit()
    });
    Ok(Press { stages: stages(context), sum, report: report? })
}

/// Seconds of every stage since stages were taken last.
fn stages(context: &Context) -> BTreeMap<&'static str, f64> {
    let mut stages = BTreeMap::new();
    for event in context.stats().take() {
        *stages.entry(event.stage).or_default() += event.length.as_secs_f64();
    }
    stages
}
