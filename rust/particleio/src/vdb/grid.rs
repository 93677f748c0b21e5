//! Grids of floats: level sets and fog.

use std::collections::{HashMap, HashSet};

use relievo_core::{Budget, Error, Result};

use super::reader::{Head, damaged, entries};
use super::tree::Tree;
use super::{FLOATS, LEAF, LOWER, UPPER};

/// A grid of floats in voxels, somewhere in space.
pub struct Grid {
    /// Its name.
    pub name: String,
    /// Whether it has distances to a surface, negative inside, and not how dense something is.
    pub is_level_set: bool,
    /// From voxels to metres: what the axes go to, and the origin.
    pub transform: [[f64; 3]; 4],
    tree: Tree,
    leaves: HashMap<[i32; 3], Vec<f32>>,
}

/// Reads a grid of floats of an OpenVDB file: the one of a name, or the first. `memory_limit` bounds in bytes what is allocated
/// for it.
///
/// # Errors
/// Fails with `Invalid` if the file is damaged or has no such grid; with `Unsupported` if it is older than OpenVDB 2, a
/// stream, or the grid has a transform that is not linear or values packed in another way than by zlib, or Blosc with
/// LZ4, zlib or zstd; and with `Memory` above the limit.
pub fn read_grid(file: &[u8], name: Option<&str>, memory_limit: u64) -> Result<Grid> {
    let mut budget = Budget::new(memory_limit);
    let mut entries = entries(file)?;
    let wanted = entries.iter().position(|entry| entry.kind == FLOATS && name.is_none_or(|name| name == entry.name));
    let Some(wanted) = wanted else {
        let told: Vec<String> = entries.iter().map(|entry| format!("{} ({})", entry.name, entry.kind)).collect();
        let what = format!("the file has no such grid of floats; it has {}", told.join(", "));
        return Err(Error::invalid(what).advise("name a level set or a fog volume"));
    };
    let mut entry = entries.swap_remove(wanted);
    let head = Head::read(&mut entry.bytes)?;
    let tree = Tree::read(&mut entry.bytes, &head, entry.is_half, &mut budget)?;
    let mut leaves = HashMap::new();
    for (origin, _) in &tree.leaves {
        let mask: [u8; 64] = entry.bytes.array()?;
        // An entry of a table beside the values.
        budget.charge(64)?;
        let values = head.values(&mut entry.bytes, &mut budget, &mask, tree.background, entry.is_half)?;
        leaves.insert(*origin, values);
    }
    let nodes = tree.upper.values().chain(tree.lower.values()).chain(leaves.values());
    if nodes.flatten().chain(tree.tiles.values()).chain([&tree.background]).any(|value| value.is_nan()) {
        return Err(damaged("a value is no number"));
    }
    let is_level_set = head.metadata("class") == Some(b"level set");
    Ok(Grid { name: entry.name, is_level_set, transform: head.transform, tree, leaves })
}

impl Grid {
    /// The value of a voxel.
    pub fn voxel(&self, at: [i32; 3]) -> f32 {
        if let Some(values) = self.leaves.get(&LEAF.around(at)) {
            return values[LEAF.child(at)];
        }
        if let Some(values) = self.tree.lower.get(&LOWER.around(at)) {
            return values[LOWER.child(at)];
        }
        let top = UPPER.around(at);
        match self.tree.upper.get(&top) {
            Some(values) => values[UPPER.child(at)],
            None => *self.tree.tiles.get(&top).unwrap_or(&self.tree.background),
        }
    }

    /// The value at a place in voxels, between those of the eight voxels around it.
    pub fn sample(&self, place: [f64; 3]) -> f32 {
        let low = place.map(|at| at.floor().clamp(-1e9, 1e9));
        let share = [0, 1, 2].map(|axis| (place[axis] - low[axis]).clamp(0.0, 1.0) as f32);
        let first = low.map(|at| at as i32);
        let line = |y: i32, z: i32| {
            let [a, b] = [0, 1].map(|x| self.voxel([first[0] + x, first[1] + y, first[2] + z]));
            a + share[0] * (b - a)
        };
        let plane = |z: i32| {
            let [a, b] = [line(0, z), line(1, z)];
            a + share[1] * (b - a)
        };
        let [a, b] = [plane(0), plane(1)];
        a + share[2] * (b - a)
    }

    /// The ends, in voxels, of where values between voxels are below a number, or above it; `None` where none is, or all are.
    pub fn bounds(&self, limit: f32, is_below: bool) -> Option<[[f64; 3]; 2]> {
        let excess = |value: f32| if is_below { value - limit } else { limit - value };
        if excess(self.tree.background) < 0.0 {
            return None;
        }
        let (mut low, mut high) = ([i32::MAX; 3], [i32::MIN; 3]);
        let mut add = |from: [i32; 3], edge: i32| {
            for axis in 0..3 {
                low[axis] = low[axis].min(from[axis]);
                high[axis] = high[axis].max(from[axis] + edge - 1);
            }
        };
        for (origin, value) in &self.tree.tiles {
            if excess(*value) < 0.0 {
                add(*origin, 1 << UPPER.edge);
            }
        }
        for (nodes, children, node) in [
            (&self.tree.upper, self.tree.lower.keys().copied().collect::<Vec<_>>(), UPPER),
            (&self.tree.lower, self.leaves.keys().copied().collect(), LOWER),
        ] {
            let children: HashSet<[i32; 3]> = children.into_iter().collect();
            for (origin, values) in nodes {
                for (child, _) in values.iter().enumerate().filter(|(_, value)| excess(**value) < 0.0) {
                    let from = node.origin(*origin, child);
                    if !children.contains(&from) {
                        add(from, 1 << node.child_edge());
                    }
                }
            }
        }
        for (origin, values) in &self.leaves {
            for (child, _) in values.iter().enumerate().filter(|(_, value)| excess(**value) < 0.0) {
                add(LEAF.origin(*origin, child), 1);
            }
        }
        if low[0] > high[0] {
            return None;
        }
        // From the outermost voxels the ends are as far as values go to the number.
        let mut ends = [low.map(f64::from), high.map(f64::from)];
        for (origin, values) in &self.leaves {
            for (child, value) in values.iter().enumerate().filter(|(_, value)| excess(**value) < 0.0) {
                let at = LEAF.origin(*origin, child);
                for axis in 0..3 {
                    for (end, extreme, step) in [(0, low, -1), (1, high, 1)] {
                        if at[axis] == extreme[axis] {
                            let mut beside = at;
                            beside[axis] += step;
                            let (within, without) = (f64::from(-excess(*value)), f64::from(excess(self.voxel(beside))));
                            let reached = f64::from(at[axis]) + f64::from(step) * within / (within + without.max(0.0));
                            let pick = if end == 0 { f64::min } else { f64::max };
                            ends[end][axis] = pick(ends[end][axis], reached);
                        }
                    }
                }
            }
        }
        Some(ends)
    }
}
