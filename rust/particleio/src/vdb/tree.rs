//! Reads the topology of a tree: its nodes with the values of tiles, and its leaves.

use std::collections::HashMap;

use relievo_core::{Budget, Result};

use super::reader::{Head, damaged, u32};
use super::{FARTHEST, LOWER, Node, UPPER};
use crate::bytes::Bytes;

/// A tree without the values of its leaves.
pub(super) struct Tree {
    pub background: f32,
    /// Values of parts of the root, as large as an upper node.
    pub tiles: HashMap<[i32; 3], f32>,
    /// Values of the children of nodes; where a child is a node they mean nothing.
    pub upper: HashMap<[i32; 3], Vec<f32>>,
    pub lower: HashMap<[i32; 3], Vec<f32>>,
    /// Lowest voxels and masks of active voxels, in the order of the file.
    pub leaves: Vec<([i32; 3], [u8; 64])>,
}

impl Tree {
    pub fn read(bytes: &mut Bytes, head: &Head, is_half: bool, budget: &mut Budget) -> Result<Self> {
        if u32(bytes)? != 1 {
            return Err(damaged("its leaves have other values than one"));
        }
        let background = f32::from_le_bytes(bytes.array()?);
        let (tiles, children) = (u32(bytes)?, u32(bytes)?);
        let (upper, lower) = (HashMap::new(), HashMap::new());
        let mut tree = Self { background, tiles: HashMap::new(), upper, lower, leaves: Vec::new() };
        for _ in 0..tiles {
            let origin = place(bytes, UPPER)?;
            let value = f32::from_le_bytes(bytes.array()?);
            let [_] = bytes.array()?;
            budget.charge(32)?;
            tree.tiles.insert(origin, value);
        }
        let mut reading = Reading { head, is_half, budget, tree: &mut tree };
        for _ in 0..children {
            let origin = place(bytes, UPPER)?;
            for origin in reading.node(bytes, UPPER, origin)? {
                for origin in reading.node(bytes, LOWER, origin)? {
                    let mask = bytes.array()?;
                    reading.budget.push(&mut reading.tree.leaves, (origin, mask))?;
                }
            }
        }
        Ok(tree)
    }
}

/// The lowest voxel of a node.
fn place(bytes: &mut Bytes, node: Node) -> Result<[i32; 3]> {
    let mut number = || bytes.array().map(i32::from_le_bytes);
    let origin = [number()?, number()?, number()?];
    if origin == node.around(origin) && origin.iter().all(|at| at.unsigned_abs() < FARTHEST as u32) {
        Ok(origin)
    } else {
        Err(damaged("a node is where none can be"))
    }
}

struct Reading<'a> {
    head: &'a Head,
    is_half: bool,
    budget: &'a mut Budget,
    tree: &'a mut Tree,
}

impl Reading<'_> {
    /// Reads a node, but not its children, and returns where these are.
    fn node(&mut self, bytes: &mut Bytes, node: Node, origin: [i32; 3]) -> Result<Vec<[i32; 3]>> {
        let children = bytes.take(node.len() as u64 / 8)?;
        let active = bytes.take(node.len() as u64 / 8)?;
        let values = self.head.values(bytes, self.budget, active, self.tree.background, self.is_half)?;
        let nodes = if node.edge == UPPER.edge { &mut self.tree.upper } else { &mut self.tree.lower };
        if nodes.insert(origin, values).is_some() {
            return Err(damaged("a node is there twice"));
        }
        let is_there = |child: &usize| children[child / 8] >> (child % 8) & 1 == 1;
        Ok((0..node.len()).filter(is_there).map(|child| node.origin(origin, child)).collect())
    }
}
