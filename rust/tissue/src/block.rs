//! Blocks of elements, and which sums of forces make up the force of a node.
//!
//! Elements are sorted along a Morton curve and cut into blocks of equal size. A block sums the forces of its elements
//! in rows of its own, a row for each of its nodes, and a node adds its rows in a fixed order. Neither depends on the
//! threads, so forces have the same bits for any number of them.

use std::ops::Range;

use glam::Vec3;
use relievo_core::{Error, Parts, Result};

use crate::model::Model;

/// Elements of a block.
pub(crate) const BLOCK: usize = 512;
/// Elements whose numbers lie side by side: the most lanes of a vector.
pub(crate) const GROUP: usize = 16;

/// A sum of forces: x, y, z and 0.
pub(crate) type Row = [f32; 4];

/// How elements and nodes are spread over blocks.
#[derive(Clone, Debug)]
pub(crate) struct Blocks {
    /// The elements in the order of the blocks.
    pub order: Vec<u32>,
    /// Where the rows of each block begin, and at the end the number of rows.
    pub rows: Vec<u32>,
    /// The node of each row, rising within a block: neighbours lie side by side in memory then.
    pub nodes: Vec<u32>,
    /// For each slot of an element the row in the block of each corner: groups of eight lists of `GROUP` numbers.
    pub corners: Vec<u16>,
    /// Where the rows of each node begin in `copies`, and at the end their number.
    pub starts: Vec<u32>,
    /// The rows of each node.
    pub copies: Vec<u32>,
}

impl Blocks {
    /// Sorts the elements of a model and cuts them into blocks. Fails if there are too many.
    pub fn new(model: &Model) -> Result<Self> {
        let count = model.elements.len();
        if count > (u32::MAX / 8) as usize - BLOCK {
            return Err(Error::memory(format!("{count} elements are too many")).advise("take larger voxels"));
        }
        let order = sorted(model);
        let blocks = count.div_ceil(BLOCK);
        let mut rows = vec![0];
        let mut nodes: Vec<u32> = Vec::new();
        let mut corners = vec![0u16; blocks * BLOCK * 8];
        // The row of a node in the block that is being made.
        let mut row_of = vec![u32::MAX; model.nodes.len()];
        for (block, elements) in order.chunks(BLOCK).enumerate() {
            let first = nodes.len();
            for node in elements.iter().flat_map(|element| model.elements[*element as usize]) {
                if std::mem::replace(&mut row_of[node as usize], 0) == u32::MAX {
                    nodes.push(node);
                }
            }
            nodes[first..].sort_unstable();
            (0u32..).zip(&nodes[first..]).for_each(|(row, node)| row_of[*node as usize] = row);
            for (slot, element) in elements.iter().enumerate() {
                for (corner, node) in model.elements[*element as usize].iter().enumerate() {
                    // At most eight rows an element, 4096.
                    corners[place(block * BLOCK + slot, 8, corner)] = row_of[*node as usize] as u16;
                }
            }
            nodes[first..].iter().for_each(|node| row_of[*node as usize] = u32::MAX);
            rows.push(nodes.len() as u32);
        }
        let mut starts = vec![0u32; model.nodes.len() + 1];
        nodes.iter().for_each(|node| starts[*node as usize + 1] += 1);
        for node in 0..model.nodes.len() {
            starts[node + 1] += starts[node];
        }
        let mut next = starts.clone();
        let mut copies = vec![0; nodes.len()];
        for (row, node) in (0u32..).zip(&nodes) {
            copies[next[*node as usize] as usize] = row;
            next[*node as usize] += 1;
        }
        Ok(Self { order, rows, nodes, corners, starts, copies })
    }

    /// Returns the number of blocks.
    pub fn len(&self) -> usize {
        self.rows.len() - 1
    }

    /// Returns how many elements block `block` has.
    pub fn elements(&self, block: usize) -> usize {
        (self.order.len() - block * BLOCK).min(BLOCK)
    }

    /// Returns the nodes of the rows of a block.
    pub fn nodes(&self, block: usize) -> &[u32] {
        &self.nodes[self.rows[block] as usize..self.rows[block + 1] as usize]
    }

    /// Returns the rows of a node.
    pub fn copies(&self, node: usize) -> &[u32] {
        &self.copies[self.copies_range(node)]
    }

    /// Returns where the rows of a node are in `copies`.
    pub fn copies_range(&self, node: usize) -> Range<usize> {
        self.starts[node] as usize..self.starts[node + 1] as usize
    }
}

/// Returns where number `which` of `width` of the element in `slot` is stored: groups of `width` lists of `GROUP`.
pub(crate) fn place(slot: usize, width: usize, which: usize) -> usize {
    (slot / GROUP * width + which) * GROUP + slot % GROUP
}

/// Returns the elements in the order of the Morton codes of their centres.
fn sorted(model: &Model) -> Vec<u32> {
    let centre =
        |corners: &[u32; 8]| corners.iter().map(|node| Vec3::from(model.nodes[*node as usize])).sum::<Vec3>() / 8.0;
    let centres: Vec<Vec3> = model.elements.iter().map(centre).collect();
    let low = centres.iter().copied().reduce(Vec3::min).unwrap_or_default();
    let high = centres.iter().copied().reduce(Vec3::max).unwrap_or_default();
    let size = model.cell.map_or(Vec3::splat((high - low).max_element() / 1023.0), Vec3::from);
    let size = size.max(Vec3::splat(f32::MIN_POSITIVE));
    let code = |centre: &Vec3| {
        let at = ((*centre - low) / size + 0.5).to_array();
        // More than 21 bits an axis do not fit; what is beyond shares a code.
        at.iter().enumerate().fold(0u64, |code, (axis, at)| code | spread(at.clamp(0.0, 2_097_151.0) as u64) << axis)
    };
    let mut keys: Vec<(u64, u32)> = centres.iter().map(code).zip(0..).collect();
    keys.sort_unstable();
    keys.into_iter().map(|(_, element)| element).collect()
}

/// Puts two zeros before each of 21 bits.
fn spread(mut bits: u64) -> u64 {
    for (shift, mask) in [
        (32, 0x001f_0000_0000_ffff),
        (16, 0x001f_0000_ff00_00ff),
        (8, 0x100f_00f0_0f00_f00f),
        (4, 0x10c3_0c30_c30c_30c3),
        (2, 0x1249_2492_4924_9249),
    ] {
        bits = (bits | bits << shift) & mask;
    }
    bits
}

/// The rows and verdicts of consecutive blocks, cut between blocks.
pub(crate) struct Sums<'a> {
    /// Where the rows of these blocks begin, and those of the block after them.
    pub starts: &'a [u32],
    /// The rows of these blocks.
    pub rows: &'a mut [Row],
    /// Whether an element of each block is inside out.
    pub broken: &'a mut [bool],
}

impl Parts for Sums<'_> {
    fn len(&self) -> usize {
        self.broken.len()
    }

    fn split_at(self, at: usize) -> (Self, Self) {
        let at = at.min(self.broken.len());
        let (rows, other_rows) = self.rows.split_at_mut((self.starts[at] - self.starts[0]) as usize);
        let (broken, other_broken) = self.broken.split_at_mut(at);
        let (starts, other_starts) = (&self.starts[..=at], &self.starts[at..]);
        (Self { starts, rows, broken }, Self { starts: other_starts, rows: other_rows, broken: other_broken })
    }
}
