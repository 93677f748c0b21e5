//! Level sets.

use std::io::Write;
use std::path::Path;

use relievo_core::{Context, Error, Result, file};

use super::{FARTHEST, FLOATS, Head, encode, packed, topology};

/// Voxels along an edge of a block.
pub const BLOCK: usize = 8;
/// A block of voxels: its lowest voxel, of multiples of 8, and its values, z fastest and x slowest.
pub type Block = ([i32; 3], Box<[f32; BLOCK * BLOCK * BLOCK]>);

/// Distances to a surface on a lattice of voxels, negative inside. Voxel (i, j, k) is at (i, j, k) times its size.
#[derive(Clone, Debug, Default)]
pub struct LevelSet {
    /// Edge of a voxel in metres.
    pub voxel: f32,
    /// Distances are known up to so many metres; beyond, values are this number or minus it.
    pub band: f32,
    /// Blocks that the band touches, sorted, each once.
    pub blocks: Vec<Block>,
}

/// Writes a level set. `is_inside` tells of a place in voxels, in parts where no block is, whether it is inside.
///
/// # Errors
/// Fails, and leaves no file: with `Invalid` if a number is not finite or blocks are not sorted or farther than 2³⁰
/// voxels from 0, and with `NotFound` or `Io` if the system refuses.
pub fn write_vdb(
    context: &Context,
    path: &Path,
    level_set: &LevelSet,
    is_inside: &(dyn Fn([f64; 3]) -> bool + Sync),
) -> Result<()> {
    level_set.check().map_err(|error| error.at(path.display().to_string()))?;
    let leaves: Vec<_> = level_set.blocks.iter().map(|(origin, values)| (*origin, level_set.mask(values))).collect();
    let (topology, order) = topology(context, &leaves, level_set.band, is_inside);
    let values = context.map(order.len(), |at| packed(level_set.blocks[order[at]].1.as_slice()));
    let masked = order.iter().zip(&values).flat_map(|(leaf, values)| leaves[*leaf].1.iter().chain(values));
    let buffers: Vec<u8> = masked.copied().collect();
    let told = |text: &str| text.as_bytes().to_vec();
    let metadata = [("class", "level set"), ("creator", "Relievo"), ("name", "surface")];
    let metadata = metadata.map(|(name, value)| (name, "string", told(value)));
    let head = Head { name: "surface", kind: FLOATS, metadata: &metadata, voxel: level_set.voxel.into() };
    let bytes = encode(&head, &topology, &buffers);
    file::store(path, |out| out.write_all(&bytes))
}

impl LevelSet {
    fn check(&self) -> Result<()> {
        let is_positive = |value: f32| value.is_finite() && value > 0.0;
        if !is_positive(self.voxel) || !is_positive(self.band) {
            return Err(Error::invalid(format!("voxels of {} m and a band of {} m cannot be", self.voxel, self.band)));
        }
        let is_near = |(origin, _): &Block| origin.iter().all(|at| at % BLOCK as i32 == 0 && at.abs() < FARTHEST);
        if !self.blocks.iter().all(is_near) || !self.blocks.windows(2).all(|pair| pair[0].0 < pair[1].0) {
            return Err(Error::invalid("blocks of a level set are not sorted, or more than 2³⁰ voxels from 0"));
        }
        match self.blocks.iter().find(|(_, values)| values.iter().any(|value| !value.is_finite())) {
            Some((origin, _)) => Err(Error::invalid("a distance is not finite").at(format!("block {origin:?}"))),
            None => Ok(()),
        }
    }

    /// Which voxels of a block are active.
    fn mask(&self, values: &[f32; BLOCK * BLOCK * BLOCK]) -> [u8; 64] {
        let mut mask = [0u8; 64];
        for (voxel, _) in values.iter().enumerate().filter(|(_, value)| value.abs() < self.band) {
            mask[voxel / 8] |= 1 << (voxel % 8);
        }
        mask
    }
}
