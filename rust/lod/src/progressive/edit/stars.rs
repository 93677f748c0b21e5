//! The triangles around the two vertices of splits.
//!
//! Of two splits whose vertices share an edge one always comes first (Derzapf, Grund, Guthe 2014, Section 2.2), so a split
//! has the same vertices and triangles around it whatever way a mesh has come. They are found once, from those around the
//! splits that its two vertices become, and kept while a mesh is edited: what a coarser level is needs no mesh of that
//! level then.

use relievo_core::Context;
use relievo_core::simd::prefetch;

use crate::connectivity::NONE;
use crate::progressive::build::hierarchy::{Child, Progressive};
use crate::progressive::mesh::active::{ActiveMesh, Waiting};

/// Splits of one task.
const CHUNK_LEN: usize = 256;
/// Numbers ahead of those of vertices and triangles.
pub const HEAD: usize = 5;

/// Numbers that come from memory at once. Most splits have no more than two times as many.
const LINE: usize = 16;

/// What is around splits.
pub struct Stars {
    /// Of every split where its numbers begin, if they are known.
    starts: Vec<usize>,
    /// How many vertices are beside the first vertex alone, beside both and beside the second alone, how many triangles
    /// are at the first and at the second; the vertices' nodes; and the triangles.
    numbers: Vec<u32>,
    /// Splits may have been made that are not known.
    is_behind: bool,
}

/// What is around a split. A node is twice the number of the split that a vertex comes from, and 1 if it is the second.
#[derive(Clone, Copy)]
pub struct Star<'a> {
    counts: [usize; 3],
    /// Nodes of the vertices around.
    pub ring: &'a [u32],
    /// Of each triangle at each vertex the vertices after and before it, by their numbers in the ring; the vertices of the
    /// split come after those.
    spokes: [&'a [u32]; 2],
    is_wide: bool,
}

/// Whether numbers in the ring need all bits of a number, and those of a triangle two of them.
fn is_wide(vertices: usize) -> bool {
    vertices + 2 > 1 << 16
}

impl Star<'_> {
    /// Which of the ring are beside a vertex of the split.
    pub fn beside(&self, side: usize) -> std::ops::Range<usize> {
        let [first, both, _] = self.counts;
        if side == 0 { 0..first + both } else { first..self.ring.len() }
    }

    /// The number in the ring that a vertex of the split has.
    pub fn end(&self, side: usize) -> usize {
        self.ring.len() + side
    }

    /// The vertices after and before one of the split in its triangles.
    #[inline(always)]
    pub fn spokes(&self, side: usize) -> impl Iterator<Item = [usize; 2]> + use<'_> {
        let (spokes, is_wide) = (self.spokes[side], self.is_wide);
        let count = if is_wide { spokes.len() / 2 } else { spokes.len() };
        (0..count).map(move |index| {
            if is_wide {
                [spokes[2 * index] as usize, spokes[2 * index + 1] as usize]
            } else {
                [spokes[index] as usize & 0xffff, spokes[index] as usize >> 16]
            }
        })
    }
}

impl Stars {
    pub fn new(vertices: usize) -> Self {
        Self { starts: vec![usize::MAX; vertices], numbers: Vec::new(), is_behind: true }
    }

    /// Splits have been made.
    pub fn note_splits(&mut self) {
        self.is_behind = true;
    }

    /// Of every split where its numbers begin, if they are known, and all numbers: as the fields say.
    pub fn parts(&self) -> (&[usize], &[u32]) {
        (&self.starts, &self.numbers)
    }

    /// What is around a split, which has to be known.
    #[inline(always)]
    pub fn star(&self, split: u32) -> Star<'_> {
        let start = self.starts[split as usize];
        let [first, both, second, at_first, at_second] =
            std::array::from_fn(|index| self.numbers[start + index] as usize);
        let vertices = first + both + second;
        let is_wide = is_wide(vertices);
        let width = if is_wide { 2 } else { 1 };
        let (ring, rest) = self.numbers[start + HEAD..].split_at(vertices);
        let (at_first, rest) = rest.split_at(width * at_first);
        Star { counts: [first, both, second], ring, spokes: [at_first, &rest[..width * at_second]], is_wide }
    }

    /// Asks for what is around splits, which has to be known.
    pub fn ask_ahead(&self, splits: &[u32]) {
        splits.iter().for_each(|split| prefetch(&self.starts, *split as usize));
        for split in splits {
            let start = self.starts[*split as usize];
            [0, LINE].into_iter().for_each(|line| prefetch(&self.numbers, start + line));
        }
    }

    /// Finds what is around the splits that are made and not known yet.
    pub fn complete(&mut self, context: &Context, mesh: &ActiveMesh) {
        if !std::mem::take(&mut self.is_behind) {
            return;
        }
        let unknown = |mesh: &ActiveMesh, split: u32| {
            let is_made = mesh.target(split) != NONE && self.starts[split as usize] == usize::MAX;
            is_made.then(|| (mesh.whole.splits[split as usize].key.depth(), split))
        };
        let mut waiting = Waiting::default();
        mesh.scan(context, unknown).into_iter().for_each(|(depth, split)| waiting.add(depth, split));
        for splits in waiting.0 {
            let found = context.map(splits.len().div_ceil(CHUNK_LEN), |part| {
                let (mut numbers, mut lengths, mut finding) = (Vec::new(), Vec::new(), Finding::default());
                for split in &splits[part * CHUNK_LEN..splits.len().min((part + 1) * CHUNK_LEN)] {
                    let before = numbers.len();
                    finding.find(mesh, self, *split, &mut numbers);
                    lengths.push(numbers.len() - before);
                }
                (numbers, lengths)
            });
            let mut splits = splits.into_iter();
            for (numbers, lengths) in found {
                let mut start = self.numbers.len();
                for (split, length) in splits.by_ref().take(lengths.len()).zip(lengths) {
                    self.starts[split as usize] = start;
                    start += length;
                }
                self.numbers.extend(numbers);
            }
        }
    }
}

/// The depth of the split a vertex comes from: it goes when the mesh is made coarser than that. Base vertices never do.
#[inline(always)]
pub fn depth(whole: &Progressive, node: u32) -> u32 {
    whole.splits[node as usize / 2].key.depth().wrapping_sub(1)
}

/// Room for finding what is around a split.
#[derive(Default)]
struct Finding {
    spokes: [Vec<[u32; 2]>; 2],
    beside: [Vec<u32>; 2],
}

impl Finding {
    fn find(&mut self, mesh: &ActiveMesh, stars: &Stars, split: u32, numbers: &mut Vec<u32>) {
        let whole = &*mesh.whole;
        let ends = [2 * split, 2 * split + 1];
        let own = depth(whole, ends[0]);
        // What stands on nothing of this split is merged before it.
        let climb = |mut node: u32| {
            while depth(whole, node) < own {
                node = whole.parent(node / 2);
            }
            node
        };
        for (side, spokes) in self.spokes.iter_mut().enumerate() {
            spokes.clear();
            let end = ends[side];
            let mut add = |spoke: [u32; 2]| {
                let [after, before] = spoke.map(climb);
                if after != before && after != end && before != end {
                    spokes.push([after, before]);
                }
            };
            let vertex = if side == 0 { mesh.target(split) } else { split };
            if mesh.node(vertex) == end {
                mesh.spokes(vertex).for_each(|spoke| add(spoke.map(|vertex| mesh.node(vertex))));
            } else if let Child::Split(next) = whole.child(end) {
                let star = stars.star(next);
                for side in 0..2 {
                    let other = star.end(1 - side);
                    let outer = star.spokes(side).filter(|spoke| !spoke.contains(&other));
                    outer.for_each(|spoke| add(spoke.map(|number| star.ring[number])));
                }
            }
            let beside = &mut self.beside[side];
            beside.clear();
            beside.extend(spokes.iter().flatten().filter(|node| **node != ends[1 - side]));
            beside.sort_unstable();
            beside.dedup();
        }
        let [first, second] = &self.beside;
        let is_both = |node: &&u32| second.binary_search(node).is_ok();
        let both = first.iter().filter(is_both).count();
        let start = numbers.len() + HEAD;
        let counts = [first.len() - both, both, second.len() - both, self.spokes[0].len(), self.spokes[1].len()];
        numbers.extend(counts.map(|count| count as u32));
        numbers.extend(first.iter().filter(|node| !is_both(node)));
        numbers.extend(first.iter().filter(is_both));
        numbers.extend(second.iter().filter(|node| first.binary_search(node).is_err()));
        let end = numbers.len();
        let is_wide = is_wide(end - start);
        let bounds = [start, start + counts[0], start + counts[0] + counts[1], end];
        for spoke in self.spokes.iter().flatten() {
            let number = |node: u32| match ends.iter().position(|end| *end == node) {
                Some(side) => end + side - start,
                None => {
                    let found = bounds
                        .windows(2)
                        .find_map(|bounds| Some(bounds[0] + numbers[bounds[0]..bounds[1]].binary_search(&node).ok()?));
                    found.map_or(0, |at| at - start)
                }
            };
            let [after, before] = spoke.map(|node| number(node) as u32);
            if is_wide {
                numbers.extend([after, before]);
            } else {
                numbers.push(after | before << 16);
            }
        }
    }
}
