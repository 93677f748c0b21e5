//! What a scene file says of the foam of a fluid.

use relievo_fluid::{Diffuse, DiffuseOptions, DiffuseSettings};
use relievo_render::foam::FoamSettings;

use crate::format::diagnostic::Diagnostic;
use crate::format::reader::{Reader, Table};

/// `[objects.NAME.fluid.foam]`
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FoamEntry {
    /// How particles are born, move and dissolve.
    pub settings: DiffuseSettings,
    /// How they are drawn; lengths are in scene units.
    pub look: FoamSettings,
    /// Whether the file gives the radius of particles; if not, it is half the spacing of the fluid.
    pub has_radius: bool,
}

/// Returns the foam of the table of a fluid; `None` if it has none.
pub(crate) fn read_foam(reader: &mut Reader, fluid: Table) -> Option<FoamEntry> {
    if !fluid.has("foam") {
        return None;
    }
    let table = reader.sub_table(fluid, "foam");
    let mut settings = DiffuseSettings::default();
    reader.parameters(table, |parameter, value| settings.set(parameter.name, value).is_ok());
    // Limits that contradict each other.
    if let Err(error) = Diffuse::new(DiffuseOptions { settings, ..DiffuseOptions::default() }) {
        reader.fault(Diagnostic::from_error(fluid.span_of("foam"), &error));
    }
    let look_table = reader.sub_table(table, "look");
    let mut look = FoamSettings::default();
    reader.parameters(look_table, |parameter, value| look.set(parameter.name, value).is_ok());
    Some(FoamEntry { settings, look, has_radius: look_table.has("radius") })
}
