//! Scalar displacement: a [`Channel`] of the B-spline coefficients of [`crate::spline`]. Units: object units.

use std::collections::BTreeMap;
use std::sync::Arc;

use half::f16;
use half::slice::HalfFloatSliceExt;
use relievo_core::{Context, Error, Result};
use relievo_surface::TileTopology;

use crate::channel::{Channel, ChannelOptions, class_of};
use crate::field::Entry;
use crate::heap::SizeClass;
use crate::ring::Change;
use crate::spline::{coarsen_block, subdivide_block};

/// Displacements that may be edited.
pub type Displacement = Channel<f16>;

/// How a displacement is made.
pub type DisplacementOptions = ChannelOptions;

impl Displacement {
    /// A displacement of zero everywhere. Fails if a size or face does not exist.
    pub fn new(topology: Arc<TileTopology>, options: &DisplacementOptions) -> Result<Self> {
        Self::blank(topology, f16::ZERO, options)
    }

    /// Gives faces other sizes, texels along an edge of the cage. What is allocated is kept: exactly, but for rounding,
    /// where a face becomes finer, in the least detail where it becomes coarser. Returns tiles that the budget refused
    /// to allocate beside a coarser one, as [`Self::settle`] does.
    ///
    /// Fails, and changes nothing, if a face or size does not exist or the budget does not allow it.
    pub fn resize(&mut self, context: &Context, faces: &[(u32, u32)]) -> Result<Vec<u32>> {
        let topology = self.field.topology().clone();
        let mut sizes = BTreeMap::new();
        for (face, size) in faces {
            if *face as usize >= topology.face_count() {
                return Err(Error::invalid(format!("face {face} does not exist")));
            }
            for tile in topology.tiles_of(*face) {
                let class = SizeClass::of(*size).map_err(|error| error.at(format!("face {face}")))?;
                sizes.insert(tile, class_of(&topology, tile, class)?);
            }
        }
        sizes.retain(|tile, class| *class != self.field.class(*tile) && !topology.is_hole(*tile));
        let allocated: Vec<(u32, SizeClass)> =
            sizes.iter().filter(|(tile, _)| self.field.is_allocated(**tile)).map(|(a, b)| (*a, *b)).collect();
        let old: u64 = allocated.iter().map(|(tile, _)| self.field.class(*tile).bytes(2)).sum();
        let new: u64 = allocated.iter().map(|(_, class)| class.bytes(2)).sum();
        if new > old && self.bytes() - old + new > self.budget() {
            return Err(Error::memory("the tiles need more than their budget")
                .advise(format!("allow at least {} bytes", self.bytes() - old + new)));
        }
        self.revision += 1;
        let field = &self.field;
        let blocks = context.map(allocated.len(), |index| {
            let (tile, class) = allocated[index];
            convert(field.block(tile).unwrap_or(&[]), field.size(tile) as usize, class.size() as usize)
        });
        let freed: Vec<_> =
            allocated.iter().filter_map(|(tile, _)| self.field.entry_mut(*tile).take().map(|entry| entry.id)).collect();
        self.heap.free(&freed);
        for (tile, class) in &sizes {
            self.full_bytes = self.full_bytes - self.field.class(*tile).bytes(2) + class.bytes(2);
            self.field.set_class(*tile, *class);
        }
        let classes: Vec<SizeClass> = allocated.iter().map(|(_, class)| *class).collect();
        // Blocks beyond a budget that was lowered may stay, and so may coarser ones in their place.
        let budget = self.heap.budget();
        self.heap.set_budget(u64::MAX);
        let ids = self.heap.allocate(&classes);
        self.heap.set_budget(budget);
        for (((tile, _), texels), id) in allocated.iter().zip(blocks).zip(ids) {
            *self.field.entry_mut(*tile) =
                id.map(|id| Entry { texels, mips: Arc::default(), id, version: self.revision });
            self.mark(*tile);
        }
        let changes: Vec<Change> = allocated.iter().map(|(tile, _)| Change::all(*tile)).collect();
        self.settle(context, &changes)
    }
}

/// A block of `from` texels a side at `to` texels.
fn convert(block: &[f16], from: usize, to: usize) -> Arc<[f16]> {
    let (mut texels, mut size) = (block.to_f32_vec(), from);
    while size < to {
        texels = subdivide_block(&texels, size);
        size *= 2;
    }
    while size > to {
        texels = coarsen_block(&texels, size);
        size /= 2;
    }
    texels.into_iter().map(|c| f16::from_f32(c.clamp(-65504.0, 65504.0))).collect()
}
