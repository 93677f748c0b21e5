//! Walks through the nodes of a tree in a file: counts what OpenVDB will allocate, and checks every size on the way.
//!
//! A tree (Museth 2013, Section 4) has a root, nodes of 32³ and 16³ children, and leaves of 8³ voxels. A file has first
//! all nodes with the masks of leaves, then the values of the leaves in the same order.

use std::collections::HashSet;

use relievo_core::{Budget, Result};

use crate::cursor::{Cursor, damaged};
use crate::info::Kind;

/// Flags of how values are packed: by zlib, those of active voxels alone, by Blosc.
const ZIP: u32 = 1;
const ACTIVE: u32 = 2;
const BLOSC: u32 = 4;
/// All values of a node follow, active or not.
const ALL_VALUES: u8 = 6;
/// Bytes of the object and the masks of a leaf, and of the memory manager's own.
const LEAF_OVERHEAD: u64 = 192;
/// Bytes of an empty grid.
const TREE_OVERHEAD: u64 = 4096;
/// Voxels from 0 at most.
const FARTHEST: u32 = 1 << 30;

/// A level of nodes: binary logarithms of its children along an edge and of its voxels along an edge.
#[derive(Clone, Copy)]
struct Level {
    children: u32,
    edge: u32,
}

const UPPER: Level = Level { children: 5, edge: 12 };
const LOWER: Level = Level { children: 4, edge: 7 };

impl Level {
    fn len(self) -> u64 {
        1 << (3 * self.children)
    }

    fn child_edge(self) -> u32 {
        self.edge - self.children
    }

    /// Returns the lowest voxel of a child.
    fn origin(self, origin: [i32; 3], child: usize) -> [i32; 3] {
        let mask = (1 << self.children) - 1;
        let at = [child >> (2 * self.children), child >> self.children & mask, child & mask];
        [0, 1, 2].map(|axis| origin[axis] + ((at[axis] as i32) << self.child_edge()))
    }
}

/// How the values of a grid are stored.
pub(crate) struct Storage {
    pub kind: Kind,
    pub is_half: bool,
    pub packing: u32,
}

/// Counts of a tree.
#[derive(Default)]
pub(crate) struct Topology {
    pub active_voxels: u64,
    pub bounds: Option<[[i32; 3]; 2]>,
    /// Active voxels of each leaf, in the order of the file.
    pub leaves: Vec<u16>,
    pub memory_bytes: u64,
}

impl Topology {
    fn cover(&mut self, low: [i32; 3], high: [i32; 3]) {
        let [lowest, highest] = self.bounds.get_or_insert([low, high]);
        for axis in 0..3 {
            lowest[axis] = lowest[axis].min(low[axis]);
            highest[axis] = highest[axis].max(high[axis]);
        }
    }

    fn active_tile(&mut self, origin: [i32; 3], edge: u32) {
        self.active_voxels += 1 << (3 * edge);
        self.cover(origin, origin.map(|at| at + ((1 << edge) - 1)));
    }

    fn active_leaf(&mut self, origin: [i32; 3], mask: &[u8; 64]) {
        let (mut ys, mut zs) = (0u8, 0u8);
        let (mut low, mut high) = (8, 0);
        for (x, rows) in mask.chunks_exact(8).enumerate() {
            for (y, row) in rows.iter().enumerate().filter(|(_, row)| **row != 0) {
                ys |= 1 << y;
                zs |= row;
                low = low.min(x as i32);
                high = high.max(x as i32);
            }
        }
        if zs != 0 {
            let ends = |bits: u8| [bits.trailing_zeros() as i32, 7 - bits.leading_zeros() as i32];
            let ([y0, y1], [z0, z1]) = (ends(ys), ends(zs));
            let [x, y, z] = origin;
            self.cover([x + low, y + y0, z + z0], [x + high, y + y1, z + z1]);
        }
    }
}

fn ones(mask: &[u8]) -> u64 {
    mask.iter().map(|byte| u64::from(byte.count_ones())).sum()
}

impl Storage {
    /// Walks through the nodes of a tree. Memory that OpenVDB will allocate, and that of the counts, is charged.
    pub fn topology(&self, file: &mut Cursor, budget: &mut Budget) -> Result<Topology> {
        let mut found = Topology { memory_bytes: TREE_OVERHEAD, ..Default::default() };
        if file.u32()? != 1 {
            return Err(damaged("leaves have more than one buffer"));
        }
        let value = self.kind.value_bytes();
        file.skip(value)?;
        let (tiles, children) = (file.u32()?, file.u32()?);
        let mut origins = HashSet::new();
        for _ in 0..tiles {
            let origin = self.root_entry(file, &mut origins, budget)?;
            file.skip(value)?;
            match file.array()? {
                [0] => {}
                [1] => found.active_tile(origin, UPPER.edge),
                _ => return Err(damaged("a tile is neither active nor not")),
            }
            found.memory_bytes += 128;
        }
        for _ in 0..children {
            let origin = self.root_entry(file, &mut origins, budget)?;
            found.memory_bytes += 128;
            for child in self.node(file, UPPER, origin, &mut found, budget)? {
                for child in self.node(file, LOWER, child, &mut found, budget)? {
                    let mask: [u8; 64] = file.array()?;
                    let bytes = self.leaf_bytes();
                    budget.charge(bytes)?;
                    found.memory_bytes += bytes;
                    let active = ones(&mask);
                    found.active_voxels += active;
                    found.active_leaf(child, &mask);
                    budget.push(&mut found.leaves, active as u16)?;
                }
            }
        }
        Ok(found)
    }

    /// Reads the lowest voxel of a tile or node of the root.
    fn root_entry(&self, file: &mut Cursor, origins: &mut HashSet<[i32; 3]>, budget: &mut Budget) -> Result<[i32; 3]> {
        let mut number = || file.array().map(i32::from_le_bytes);
        let origin = [number()?, number()?, number()?];
        let is_lowest = origin.iter().all(|at| at.trailing_zeros() >= UPPER.edge && at.unsigned_abs() < FARTHEST);
        // An entry here and one of OpenVDB's map.
        budget.charge(160)?;
        if is_lowest && origins.insert(origin) { Ok(origin) } else { Err(damaged("a node is where none can be")) }
    }

    /// Walks through a node, without its children, and returns their lowest voxels.
    fn node(
        &self,
        file: &mut Cursor,
        level: Level,
        origin: [i32; 3],
        found: &mut Topology,
        budget: &mut Budget,
    ) -> Result<Vec<[i32; 3]>> {
        let bytes = level.len() / 8;
        // The node, and the values that OpenVDB unpacks beside it.
        let size = level.len() * self.kind.value_bytes().next_multiple_of(8) + 2 * bytes + 64;
        budget.charge(size)?;
        found.memory_bytes += size;
        let mut children = vec![0; bytes as usize];
        let mut active = children.clone();
        file.fill(&mut children)?;
        file.fill(&mut active)?;
        self.values(file, level.len(), ones(&active), budget)?;
        let bit = |mask: &[u8], at: usize| mask[at / 8] >> (at % 8) & 1 == 1;
        for child in (0..level.len() as usize).filter(|child| bit(&active, *child) && !bit(&children, *child)) {
            found.active_tile(level.origin(origin, child), level.child_edge());
        }
        let there = (0..level.len() as usize).filter(|child| bit(&children, *child));
        Ok(there.map(|child| level.origin(origin, child)).collect())
    }

    fn leaf_bytes(&self) -> u64 {
        match self.kind {
            Kind::Bool | Kind::Mask => 128 + LEAF_OVERHEAD,
            kind => 512 * kind.value_bytes() + LEAF_OVERHEAD,
        }
    }

    /// Walks through the values of all leaves.
    pub fn leaves(&self, file: &mut Cursor, topology: &Topology, budget: &mut Budget) -> Result<()> {
        for active in &topology.leaves {
            match self.kind {
                // The mask and the lowest voxel, and the values of bools.
                Kind::Mask => file.skip(64 + 12)?,
                Kind::Bool => file.skip(64 + 12 + 64)?,
                _ => {
                    // OpenVDB reads as many values as this second mask has.
                    let mask: [u8; 64] = file.array()?;
                    if ones(&mask) != u64::from(*active) {
                        return Err(damaged("a leaf has two different masks"));
                    }
                    self.values(file, 512, (*active).into(), budget)?;
                }
            }
        }
        Ok(())
    }

    /// Walks through the values of a node, `active` of which are of active voxels.
    fn values(&self, file: &mut Cursor, count: u64, active: u64, budget: &mut Budget) -> Result<()> {
        let value = self.kind.value_bytes();
        let [form] = file.array()?;
        file.skip(match form {
            2 | 4 => value,
            5 => 2 * value,
            0 | 1 | 3 | ALL_VALUES => 0,
            _ => return Err(damaged("values have an unknown form")),
        })?;
        if matches!(form, 3..=5) {
            file.skip(count / 8)?;
        }
        let count = if self.packing & ACTIVE != 0 && form != ALL_VALUES { active } else { count };
        let is_half = self.is_half && self.kind.is_real();
        if is_half && count == 0 {
            return Ok(());
        }
        let bytes = count * if is_half { 2 * self.kind.components() as u64 } else { value };
        if self.packing & (ZIP | BLOSC) == 0 {
            return file.skip(bytes);
        }
        let packed = file.i64()?;
        match u64::try_from(packed) {
            // OpenVDB allocates as much as is stated before it reads.
            Ok(packed) if packed > 0 => {
                if packed > budget.left() {
                    budget.charge(packed)?;
                }
                file.skip(packed)
            }
            _ if packed.unsigned_abs() == bytes => file.skip(bytes),
            _ => Err(damaged("a node has fewer or more values than its size")),
        }
    }
}
