//! Numbers of leaves in the trees of collapses: those of a tree follow each other.

use crate::connectivity::NONE;

/// The leaves' numbers.
pub(super) struct Numbers {
    /// Of every vertex of the input.
    pub leaves: Vec<u32>,
    /// What the two vertices of each collapse came from: the vertex that went in the collapse before, or [`NONE`].
    pub children: Vec<[u32; 2]>,
    /// Of every vertex of the input, the one that went in the last collapse of its tree, or [`NONE`].
    pub last: Vec<u32>,
    /// Vertices of the input that are left.
    pub base: Vec<u32>,
}

impl Numbers {
    /// Of so many vertices, and of the vertices that collapses keep and take away.
    pub fn new(count: usize, collapses: impl DoubleEndedIterator<Item = [u32; 2]> + ExactSizeIterator + Clone) -> Self {
        let mut last = vec![NONE; count];
        let mut sizes = vec![1u32; count];
        let mut children = Vec::with_capacity(collapses.len());
        let mut firsts = Vec::with_capacity(collapses.len());
        for ends in collapses.clone() {
            let [kept, gone] = ends.map(|vertex| vertex as usize);
            children.push([last[kept], last[gone]]);
            firsts.push(sizes[kept]);
            sizes[kept] += sizes[gone];
            sizes[gone] = 0;
            last[kept] = ends[1];
        }
        let base: Vec<u32> = (0..count as u32).filter(|vertex| sizes[*vertex as usize] > 0).collect();
        let mut leaves = vec![0; count];
        let mut sum = 0;
        for vertex in &base {
            leaves[*vertex as usize] = sum;
            sum += sizes[*vertex as usize];
        }
        for ([kept, gone], first) in collapses.zip(firsts).rev() {
            leaves[gone as usize] = leaves[kept as usize] + first;
        }
        Self { leaves, children, last, base }
    }
}
