//! The blocks of a channel at one moment as histories and documents see them: bytes by number, whatever the texels.

use std::any::Any;
use std::borrow::Cow;
use std::fmt::Debug;
use std::sync::Arc;

use relievo_core::Result;
use relievo_document::Kind;
use relievo_surface::TileTopology;

use crate::quads::field::Field;
use crate::store::heap::{MAX_SIZE, SizeClass};
use crate::store::stored::StoredTexel;

/// Blocks by number at one moment. Cheap to keep, since what is not written afterwards is shared.
pub trait Blocks: Any + Debug + Send + Sync {
    /// What the texels are.
    fn kind(&self) -> Kind;

    /// The texel that blocks read as that are not there.
    fn blank(&self) -> &[u8];

    /// Of every face, texels along an edge of it.
    fn face_sizes(&self) -> Vec<u32>;

    /// Of every face, the size it was given, if an edit of another level changed that of any; else nothing.
    fn given_sizes(&self) -> Vec<u32> {
        Vec::new()
    }

    /// Whether all faces have the sizes that they have in `other`.
    fn is_sized_as(&self, other: &dyn Blocks) -> bool {
        self.face_sizes() == other.face_sizes()
    }

    /// The block with a number, if it is there.
    fn bytes(&self, block: u32) -> Option<Cow<'_, [u8]>>;

    /// As [`Self::bytes`].
    ///
    /// # Errors
    /// Fails if the block is on a page that cannot be read.
    fn try_bytes(&self, block: u32) -> Result<Option<Cow<'_, [u8]>>> {
        Ok(self.bytes(block))
    }

    /// The numbers of the blocks that are there, ascending.
    fn numbers(&self) -> Vec<u32>;

    /// The blocks that are not as in `other`, ascending; what both share costs next to nothing. All blocks of both if
    /// the two are not of one kind.
    fn changed(&self, other: &dyn Blocks) -> Vec<u32>;

    /// Whether faces have and were given the sizes that they have in `other`, and what is not there reads the same.
    fn is_shaped_as(&self, other: &dyn Blocks) -> bool;
}

/// The numbers of the blocks of two channels of different kinds, ascending.
pub(crate) fn of_both(first: &dyn Blocks, second: &dyn Blocks) -> Vec<u32> {
    let mut numbers = [first.numbers(), second.numbers()].concat();
    numbers.sort_unstable();
    numbers.dedup();
    numbers
}

impl<T: StoredTexel> Blocks for Field<T> {
    fn kind(&self) -> Kind {
        T::KIND
    }

    fn blank(&self) -> &[u8] {
        bytemuck::bytes_of(self.blank_ref())
    }

    fn face_sizes(&self) -> Vec<u32> {
        face_sizes(self.topology(), self.classes())
    }

    fn given_sizes(&self) -> Vec<u32> {
        if self.given() == self.classes() { Vec::new() } else { face_sizes(self.topology(), self.given()) }
    }

    fn bytes(&self, block: u32) -> Option<Cow<'_, [u8]>> {
        self.block(block).map(|texels| Cow::Borrowed(bytemuck::cast_slice(texels)))
    }

    fn try_bytes(&self, block: u32) -> Result<Option<Cow<'_, [u8]>>> {
        Ok(self.try_block(block)?.map(|texels| Cow::Borrowed(bytemuck::cast_slice(texels))))
    }

    fn numbers(&self) -> Vec<u32> {
        self.allocated().collect()
    }

    fn changed(&self, other: &dyn Blocks) -> Vec<u32> {
        let any: &dyn Any = other;
        match any.downcast_ref::<Self>() {
            Some(other) => self.differing(other),
            None => of_both(self, other),
        }
    }

    fn is_sized_as(&self, other: &dyn Blocks) -> bool {
        let any: &dyn Any = other;
        let sized = |other: &Self| Arc::ptr_eq(self.classes(), other.classes()) || self.classes() == other.classes();
        any.downcast_ref::<Self>().is_some_and(sized)
    }

    fn is_shaped_as(&self, other: &dyn Blocks) -> bool {
        let any: &dyn Any = other;
        any.downcast_ref::<Self>().is_some_and(|other| {
            let same = |a: &Arc<[SizeClass]>, b: &Arc<[SizeClass]>| Arc::ptr_eq(a, b) || a == b;
            same(self.classes(), other.classes())
                && same(self.given(), other.given())
                && self.blank().same(other.blank())
        })
    }
}

/// Of every face, texels along an edge of it, where tiles have the sizes `classes`.
fn face_sizes(topology: &TileTopology, classes: &[SizeClass]) -> Vec<u32> {
    let size = |face| {
        let tile = topology.tiles_of(face).start;
        let size = classes[tile as usize].size();
        // Sub-tiles have half the size of their face.
        if topology.is_sub(tile) { (2 * size).min(MAX_SIZE) } else { size }
    };
    (0..topology.face_count() as u32).map(size).collect()
}
