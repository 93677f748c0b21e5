//! Where the vertices of a mesh are, roughly: boxes of those whose numbers are near, which are near on the surface too.

use glam::Vec3;
use relievo_core::Context;

use super::active::ActiveMesh;

/// Numbers of a block.
const BLOCK: usize = 64;
/// Blocks of one task.
const CHUNK_LEN: usize = 64;

/// Boxes of blocks of vertices.
#[derive(Default)]
pub struct Blocks {
    /// Lowest and highest coordinates, the wrong way round without vertices; none while nobody has asked.
    boxes: Vec<[Vec3; 2]>,
    /// Blocks whose boxes are to be found anew.
    stale: Vec<u32>,
    is_stale: Vec<bool>,
}

impl Blocks {
    /// Forgets all boxes.
    pub fn clear(&mut self) {
        self.boxes.clear();
    }

    /// Notes that a vertex is elsewhere.
    pub fn note(&mut self, vertex: u32) {
        let block = vertex as usize / BLOCK;
        if !self.boxes.is_empty() && !std::mem::replace(&mut self.is_stale[block], true) {
            self.stale.push(block as u32);
        }
    }
}

impl ActiveMesh {
    /// What `find` finds among the vertices of blocks that `reaches`, told their lowest and highest coordinates.
    pub(crate) fn find_near<T: Send>(
        &mut self,
        context: &Context,
        reaches: impl Fn(Vec3, Vec3) -> bool,
        find: impl Fn(&Self, u32) -> Option<T> + Sync,
    ) -> Vec<T> {
        let count = self.slots.len();
        let range = |block: u32| block * BLOCK as u32..count.min((block as usize + 1) * BLOCK) as u32;
        let mut blocks = std::mem::take(&mut self.blocks);
        if blocks.boxes.is_empty() {
            let all = count.div_ceil(BLOCK);
            blocks.boxes = vec![[Vec3::INFINITY, Vec3::NEG_INFINITY]; all];
            (blocks.stale, blocks.is_stale) = ((0..all as u32).collect(), vec![false; all]);
        }
        let mesh = &*self;
        let part = |list: &[u32], part: usize| part * CHUNK_LEN..list.len().min((part + 1) * CHUNK_LEN);
        let bounds = context.map(blocks.stale.len().div_ceil(CHUNK_LEN), |index| {
            let around = |block: &u32| {
                let places = range(*block).filter_map(|vertex| Some(mesh.place(vertex, mesh.child(vertex)?).point));
                places
                    .fold([Vec3::INFINITY, Vec3::NEG_INFINITY], |[low, high], point| [low.min(point), high.max(point)])
            };
            blocks.stale[part(&blocks.stale, index)].iter().map(around).collect::<Vec<_>>()
        });
        for (block, bounds) in blocks.stale.drain(..).zip(bounds.into_iter().flatten()) {
            blocks.boxes[block as usize] = bounds;
            blocks.is_stale[block as usize] = false;
        }
        let near: Vec<u32> = (0u32..)
            .zip(&blocks.boxes)
            .filter(|(_, [low, high])| reaches(*low, *high))
            .map(|(block, _)| block)
            .collect();
        let found = context.map(near.len().div_ceil(CHUNK_LEN), |index| {
            let vertices = near[part(&near, index)].iter().flat_map(|block| range(*block));
            vertices.filter_map(|vertex| find(mesh, vertex)).collect::<Vec<_>>()
        });
        self.blocks = blocks;
        found.into_iter().flatten().collect()
    }
}
