//! The wedges that an active mesh has now.

use super::active::{ActiveMesh, Extract};
use super::bitset::BitSet;
use crate::connectivity::NONE;
use crate::progressive::edit::turning::Turning;

impl ActiveMesh {
    /// Splits the wedges of a split.
    #[inline(always)]
    pub(super) fn split_wedges(&self, split: u32) {
        if let Some((trees, there)) = self.whole.wedges.as_ref().zip(self.wedges.as_ref()) {
            trees.parts_of(split).for_each(|wedge| _ = there.insert(wedge));
        }
    }

    /// Takes the splits of the wedges of a split back.
    #[inline(always)]
    pub(super) fn merge_wedges(&self, split: u32) {
        if let Some((trees, there)) = self.whole.wedges.as_ref().zip(self.wedges.as_ref()) {
            trees.parts_of(split).for_each(|wedge| there.remove(wedge));
        }
    }

    /// Wedges of this mesh, and such as none of its triangles has.
    pub(crate) fn wedges(&self) -> impl Iterator<Item = u32> {
        self.wedges.iter().flat_map(BitSet::iter)
    }

    /// The splits of wedges that a split has.
    pub(crate) fn parts_of(&self, split: u32) -> impl Iterator<Item = u32> {
        self.whole.wedges.iter().flat_map(move |trees| trees.parts_of(split))
    }

    /// Whether there is a wedge of a number.
    pub(crate) fn is_wedge(&self, wedge: u32) -> bool {
        self.wedges.as_ref().is_some_and(|there| there.last_up_to(wedge) == Some(wedge))
    }

    /// The wedge before a number.
    pub(super) fn wedge_before(&self, number: u32) -> Option<u32> {
        self.wedges.as_ref()?.last_up_to(number.checked_sub(1)?)
    }

    /// The wedges of a triangle that is there, and its numbers.
    pub(crate) fn wedges_of(&self, face: u32) -> Option<([u32; 3], &[u32])> {
        let (trees, there) = self.whole.wedges.as_ref().zip(self.wedges.as_ref())?;
        let (place, [_, width]) = (face as usize, trees.widths);
        let wedges = trees.corners[place].map(|leaf| there.last_up_to(leaf).unwrap_or_default());
        Some((wedges, &trees.faces[place * width..(place + 1) * width]))
    }

    /// Puts wedges and what triangles have into an extract whose triangles are in the places `faces`.
    pub(super) fn extract_wedges(&self, faces: &[u32], made: &mut Extract) {
        let Some((trees, there)) = self.whole.wedges.as_ref().zip(self.wedges.as_ref()) else { return };
        for (wedges, values) in faces.iter().filter_map(|face| self.wedges_of(*face)) {
            made.wedges.push(wedges);
            made.face_values.extend(values);
        }
        let mut numbers = vec![NONE; trees.count()];
        made.wedges.as_flattened().iter().for_each(|wedge| numbers[*wedge as usize] = 0);
        let (mut list, mut turning) = (there.iter().peekable(), Turning::new(self));
        let mut count = 0;
        while let Some(wedge) = list.next() {
            let number = &mut numbers[wedge as usize];
            if *number != NONE {
                *number = count;
                count += 1;
                made.values.extend_from_slice(turning.values(trees, wedge, list.peek().copied()));
            }
        }
        made.wedges.as_flattened_mut().iter_mut().for_each(|wedge| *wedge = numbers[*wedge as usize]);
    }
}
