//! Fluids of particles in pictures: the points of a mesh, of which the surface is traced itself or a mesh is made.

use std::sync::Arc;

use relievo_core::progress::Silent;
use relievo_core::{Context, Mesh, Result};
use relievo_fluid::{March, Motion, Ray, RayCaster, Surface, SurfaceFunction, Trail};
use relievo_render::{Implicit, ImplicitHit, ImplicitRay, ImplicitTracer};

use crate::format::diagnostic::Diagnostic;
use crate::format::povray_form::PovrayForm;
use crate::format::reader::{Name, Reader, Table};
use crate::run::foam::{FoamEntry, read_foam};

/// `[objects.NAME.fluid]`
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FluidEntry {
    /// What the surface is of.
    pub function: SurfaceFunction,
    /// Distance between particles at rest, in object units.
    pub spacing: f32,
    /// The size of the cells of a mesh in object units; `None` if the surface is traced itself.
    pub cell: Option<f32>,
    /// What scenes for POV-Ray have of it.
    pub povray: PovrayForm,
    /// Its foam; `None` if it has none.
    pub foam: Option<FoamEntry>,
}

impl FluidEntry {
    /// The surface itself, of particles at these places.
    ///
    /// # Errors
    /// Fails as [`Surface::new`].
    pub fn implicit(&self, context: &Context, points: &[[f32; 3]]) -> Result<Box<dyn Implicit>> {
        let surface = Arc::new(Surface::new(context, points, self.function)?);
        let caster = RayCaster::new(context, &surface, Motion::default(), &[], March::default())?;
        Ok(Box::new(Isosurface(caster)))
    }

    /// A mesh of the surface with the point attribute `normal`, of cells of an eighth of the support radius where no
    /// size is given.
    ///
    /// # Errors
    /// Fails as [`Surface::new`], with `Invalid` if the cells are below 1/128 of the support radius or above all of it
    /// or a coordinate is more than 1,048,576 cells from 0, and with `Memory` if the mesh exceeds the memory limit.
    pub fn mesh(&self, context: &Context, points: &[[f32; 3]]) -> Result<Mesh> {
        let surface = Surface::new(context, points, self.function)?;
        let cell = self.cell.unwrap_or(self.function.support() / 8.0);
        relievo_fluid::mesh(context, &surface, cell, &[], &mut Silent)
    }
}

/// The surface of particles as the ray caster takes it.
#[derive(Debug)]
pub struct Isosurface(pub RayCaster);

/// How far from the surface rays begin that leave it, in support radii.
const MARGIN: f32 = 1e-4;

impl Implicit for Isosurface {
    fn tracer(&self) -> Box<dyn ImplicitTracer + '_> {
        Box::new(Tracer { caster: &self.0, trail: Trail::default() })
    }
}

struct Tracer<'a> {
    caster: &'a RayCaster,
    trail: Trail,
}

impl ImplicitTracer for Tracer<'_> {
    fn intersect(&mut self, ray: &ImplicitRay) -> Option<ImplicitHit> {
        let ImplicitRay { origin, direction, far, time } = *ray;
        let hit = self.caster.tracer(&mut self.trail).intersect(&Ray { origin, direction, near: 0.0, far, time })?;
        let margin = MARGIN * self.caster.surface().function().support();
        Some(ImplicitHit { distance: hit.distance, normal: hit.normal, enters: hit.enters, margin })
    }
}

/// The function of a name, of particles that lie `spacing` apart at rest; `None` if there is no such.
pub fn function(name: &str, spacing: f32) -> Option<SurfaceFunction> {
    let radius = 0.5 * spacing;
    match name {
        "blobs" => Some(SurfaceFunction::blobs(radius)),
        "zhu_bridson" => Some(SurfaceFunction::zhu_bridson(radius)),
        "density" => Some(SurfaceFunction::density(radius)),
        "anisotropic" => Some(SurfaceFunction::anisotropic(radius)),
        _ => None,
    }
}

pub(crate) fn read_fluid(reader: &mut Reader, name: &Name, table: Table) -> Option<FluidEntry> {
    if !table.has("fluid") {
        return None;
    }
    let span = table.span_of("fluid");
    let table = reader.sub_table(table, "fluid");
    let Some(spacing) = reader.optional_number(table, "spacing") else {
        reader.fault(
            Diagnostic::new(span, format!("how far apart the particles of `{}` lie is not said", name.text))
                .advise("give the spacing of the simulation: `spacing = 0.02`"),
        );
        return None;
    };
    let function = function(reader.choice(table, "function")?, spacing as f32)?;
    let cell = reader.optional_number(table, "cell").map(|cell| (cell * spacing) as f32);
    let povray = match reader.choice(table, "povray")? {
        "blobs" => PovrayForm::Blobs,
        "df3" => PovrayForm::Grid,
        _ => PovrayForm::Mesh,
    };
    let foam = read_foam(reader, table);
    Some(FluidEntry { function, spacing: spacing as f32, cell, povray, foam })
}
