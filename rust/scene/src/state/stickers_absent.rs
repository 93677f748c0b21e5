//! Stickers in a build without the feature `decal`: scenes with one are refused.

use relievo_core::{Context, Error, Result};

use crate::format::description::DecalEntry;
use crate::state::paths::Paths;

/// The sticker of a decal, which cannot be made.
#[derive(Debug)]
pub(crate) struct Loaded;

impl Loaded {
    /// Fails: there are no decals.
    pub fn new(_: &Context, _: &Paths, _: &DecalEntry) -> Result<Self> {
        Err(Error::unsupported("this build has no decals").advise("build with the feature `decal`"))
    }

    /// Returns 0.
    pub fn checksum(&self) -> u32 {
        0
    }
}
