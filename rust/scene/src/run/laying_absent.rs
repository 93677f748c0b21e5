//! Decals in a build without the feature `decal`: no scene has one.

use relievo_core::{Context, Result};

use crate::format::description::DecalEntry;
use crate::run::refusals::Refusals;
use crate::state::world::World;

/// Does nothing.
pub(crate) fn make(_: &Context, _: &mut World, _: u32, _: &mut Refusals) -> Result<()> {
    Ok(())
}

/// Does nothing.
pub(crate) fn make_due(_: &Context, _: &mut World, _: impl Fn(&DecalEntry) -> bool, _: &mut Refusals) -> Result<()> {
    Ok(())
}
