//! Fluids in a build without the feature `fluid`: an object of particles is an error.

use std::convert::Infallible;

use relievo_core::{Context, Mesh, Result};
use relievo_render::Implicit;

use crate::format::diagnostic::Diagnostic;
use crate::format::povray_form::PovrayForm;
use crate::format::reader::{Name, Reader, Table};

/// `[objects.NAME.fluid]`, which no object of this build has.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FluidEntry {
    /// The size of the cells of a mesh.
    pub cell: Option<f32>,
    /// What scenes for POV-Ray have of it.
    pub povray: PovrayForm,
    absent: Infallible,
}

impl FluidEntry {
    /// Returns nothing, since there is no fluid.
    pub fn implicit(&self, _: &Context, _: &[[f32; 3]]) -> Result<Box<dyn Implicit>> {
        match self.absent {}
    }

    /// Returns nothing, since there is no fluid.
    pub fn mesh(&self, _: &Context, _: &[[f32; 3]]) -> Result<Mesh> {
        match self.absent {}
    }
}

pub(crate) fn read_fluid(reader: &mut Reader, _: &Name, table: Table) -> Option<FluidEntry> {
    if table.has("fluid") {
        let fault = Diagnostic::new(table.span_of("fluid"), "this build has no fluids");
        reader.fault(fault.advise("build with the feature `fluid`"));
    }
    None
}
