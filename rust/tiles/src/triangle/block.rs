//! The blocks of a channel over triangles, by number, as caches and documents keep them: first those of faces, then
//! those of edges, then the values of the vertices, 256 by 256. A block is its values, little-endian; how many it has
//! says its pattern.

use relievo_core::{Error, Result};
use relievo_surface::TriangleTopology;

use super::change::TriangleChange;
use super::channel::TriangleChannel;
use super::field::{CHUNK, TriangleClass};
use super::pattern::Pattern;
use crate::store::heap::Class;
use crate::texel::Texel;

/// What a block belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum TriangleBlock {
    /// A face.
    Face(u32),
    /// An edge.
    Edge(u32),
    /// Vertices from 256 times this number on.
    Vertices(u32),
}

impl TriangleBlock {
    /// Number of blocks there can be.
    pub fn count(topology: &TriangleTopology) -> u32 {
        (topology.face_count() + topology.edge_count() + topology.vertex_count().div_ceil(CHUNK)) as u32
    }

    /// What the block with the given number belongs to; `None` if there is none.
    pub fn of(topology: &TriangleTopology, number: u32) -> Option<Self> {
        let [faces, edges] = [topology.face_count(), topology.edge_count()].map(|count| count as u32);
        match number {
            _ if number >= Self::count(topology) => None,
            _ if number < faces => Some(Self::Face(number)),
            _ if number < faces + edges => Some(Self::Edge(number - faces)),
            _ => Some(Self::Vertices(number - faces - edges)),
        }
    }

    /// Its number.
    pub fn number(self, topology: &TriangleTopology) -> u32 {
        let [faces, edges] = [topology.face_count(), topology.edge_count()].map(|count| count as u32);
        match self {
            Self::Face(face) => face,
            Self::Edge(edge) => faces + edge,
            Self::Vertices(chunk) => faces + edges + chunk,
        }
    }

    /// What a change of these blocks is a change of.
    pub fn change(topology: &TriangleTopology, numbers: impl IntoIterator<Item = u32>) -> TriangleChange {
        let mut change = TriangleChange::default();
        for number in numbers {
            match Self::of(topology, number) {
                Some(Self::Face(face)) => change.faces.push(face),
                Some(Self::Edge(edge)) => change.edges.push(edge),
                Some(Self::Vertices(chunk)) => {
                    let first = chunk * CHUNK as u32;
                    let end = (first + CHUNK as u32).min(topology.vertex_count() as u32);
                    change.vertices.extend(first..end);
                }
                None => {}
            }
        }
        change
    }
}

impl TriangleChange {
    /// The numbers of the blocks that changed, ascending.
    pub fn blocks(&self, topology: &TriangleTopology) -> Vec<u32> {
        let faces = self.faces.iter().map(|face| TriangleBlock::Face(*face));
        let edges = self.edges.iter().map(|edge| TriangleBlock::Edge(*edge));
        let vertices = self.vertices.iter().map(|vertex| TriangleBlock::Vertices(vertex / CHUNK as u32));
        let mut blocks: Vec<u32> = faces.chain(edges).chain(vertices).map(|block| block.number(topology)).collect();
        blocks.sort_unstable();
        blocks.dedup();
        blocks
    }
}

impl<T: Texel> TriangleChannel<T> {
    /// The numbers of the blocks that hold something, ascending: those of faces and edges that have one, and those of
    /// vertices of which one is not blank.
    pub fn blocks(&self) -> Vec<u32> {
        self.field().blocks()
    }

    /// The values of a block as bytes; `None` if it holds nothing.
    ///
    /// # Errors
    /// Fails if there is no such block, or it is on a page that cannot be read.
    pub fn read(&self, number: u32) -> Result<Option<Vec<u8>>> {
        let field = self.field();
        let block = TriangleBlock::of(field.topology(), number).ok_or_else(|| missing(number))?;
        Ok(field.try_held(block)?.map(|values| bytemuck::cast_slice(values).to_vec()))
    }

    /// Puts back what [`Self::read`] gave: allocates or deallocates as needed; vertices without bytes become blank.
    /// When all blocks of an edit are put back, faces have blocks with their edges again.
    ///
    /// # Errors
    /// Fails, and changes nothing, if there is no such block, the length is not that of one of the patterns, a number
    /// is not finite, or the budget does not allow it.
    #[inline(never)]
    pub fn write_block(&mut self, number: u32, bytes: Option<&[u8]>) -> Result<()> {
        let topology = self.field().topology().clone();
        let block = TriangleBlock::of(&topology, number).ok_or_else(|| missing(number))?;
        let place = || format!("block {number}");
        let values: Option<Vec<T>> = match bytes {
            Some(bytes) if bytes.len() % size_of::<T>() != 0 => {
                return Err(Error::invalid(format!("a block of {} bytes cannot be put back", bytes.len())).at(place()));
            }
            Some(bytes) => Some(bytes.chunks_exact(size_of::<T>()).map(bytemuck::pod_read_unaligned).collect()),
            None => None,
        };
        if values.as_ref().is_some_and(|values| !T::all_finite(values)) {
            return Err(Error::invalid("a number of the block is not finite").at(place()));
        }
        let face = match block {
            TriangleBlock::Vertices(chunk) => {
                let first = chunk as usize * CHUNK;
                let count = CHUNK.min(topology.vertex_count() - first);
                let values = values.unwrap_or_else(|| vec![self.field().blank(); count]);
                if values.len() != count {
                    return Err(Error::invalid(format!("{} values cannot be put back", values.len()))
                        .at(place())
                        .advise(format!("the block has {count} vertices")));
                }
                self.write_vertices(first as u32, &values);
                return Ok(());
            }
            TriangleBlock::Face(_) => true,
            TriangleBlock::Edge(_) => false,
        };
        let finest = self.field().pattern().segments();
        let class = values.as_ref().map(|values| {
            let classes = [1, 2, 4].map(|part| TriangleClass { face, pattern: Pattern::of_power(finest / part) });
            classes.into_iter().find(|class| class.values() == values.len()).ok_or_else(|| {
                Error::invalid(format!("{} values cannot be put back", values.len())).at(place()).advise(format!(
                    "use those of {finest}, {} or {} segments",
                    finest / 2,
                    finest / 4
                ))
            })
        });
        self.blocks.revision += 1;
        match class.transpose()?.zip(values) {
            Some((class, values)) => {
                if self.put(block, class, values.into(), &[]) {
                    return Ok(());
                }
                self.report_fault()?;
                Err(Error::memory("the blocks need more than their budget")
                    .at(place())
                    .advise("raise the budget of the object's detail"))
            }
            None if self.field().block(block).is_some() => {
                let freed = self.take_block(block);
                self.blocks.heap.free(freed.as_slice());
                self.mark(block);
                Ok(())
            }
            None => Ok(()),
        }
    }
}

impl<T: Texel> TriangleChannel<T> {
    fn write_vertices(&mut self, first: u32, values: &[T]) {
        let Self { field, changed, blocks, .. } = self;
        blocks.revision += 1;
        for (vertex, value) in (first..).zip(values) {
            if !field.vertex(vertex).same(*value) {
                field.set_vertex(vertex, *value);
                changed.vertices.push(vertex);
            }
        }
    }
}

fn missing(number: u32) -> Error {
    Error::invalid(format!("block {number} does not exist"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::triangle::shapes;
    use crate::triangle::{TriangleOptions, TriangleSets, TriangleValues};
    use half::f16;
    use relievo_core::Context;
    use std::sync::Arc;

    #[test]
    fn numbers_of_blocks_are_one_to_one() {
        let topology = TriangleTopology::of_mesh(&shapes::sail(3)).unwrap();
        let count = TriangleBlock::count(&topology);
        for number in 0..count {
            assert_eq!(TriangleBlock::of(&topology, number).unwrap().number(&topology), number);
            assert_eq!(TriangleBlock::change(&topology, [number]).blocks(&topology), [number]);
        }
        assert_eq!(TriangleBlock::of(&topology, count), None);
    }

    #[test]
    fn blocks_put_back_make_the_same_channel() {
        let context = Context::serial();
        let topology = Arc::new(TriangleTopology::of_mesh(&shapes::sail(4)).unwrap());
        let options = TriangleOptions { segments: 16, budget: 1 << 20 };
        let new = || TriangleChannel::displacement(topology.clone(), &options).unwrap();
        let mut channel = new();
        for (segments, faces) in [(16, vec![0, 7]), (8, vec![1, 12]), (4, vec![20])] {
            let sets = TriangleSets { allocate: faces, ..Default::default() };
            channel.apply(&context, Pattern::new(segments).unwrap(), &sets).unwrap();
        }
        let block = (0..169).map(|k| f16::from_f32(k as f32)).collect();
        let values = TriangleValues {
            faces: vec![(7, block)],
            vertices: vec![(3, f16::ONE), (8, f16::NEG_ONE)],
            ..Default::default()
        };
        channel.write(values).unwrap();
        let mut copy = new();
        for number in channel.blocks() {
            copy.write_block(number, channel.read(number).unwrap().as_deref()).unwrap();
        }
        assert_eq!(copy.bytes(), channel.bytes());
        assert_eq!(copy.blocks(), channel.blocks());
        for number in 0..TriangleBlock::count(&topology) {
            assert_eq!(copy.read(number).unwrap(), channel.read(number).unwrap());
        }
        // And taken away again.
        for number in channel.blocks() {
            copy.write_block(number, None).unwrap();
        }
        assert_eq!((copy.bytes(), copy.blocks()), (new().bytes(), Vec::new()));
    }

    #[test]
    fn bytes_that_are_no_block_are_refused() {
        let topology = Arc::new(TriangleTopology::of_mesh(&shapes::sail(2)).unwrap());
        let vertices = 2 * topology.vertex_count() as u64;
        let options = TriangleOptions { segments: 16, budget: vertices + 2 * 37 };
        let mut channel = TriangleChannel::displacement(topology.clone(), &options).unwrap();
        let last = TriangleBlock::count(&topology) - 1;
        let nan = [0x00, 0x7e].repeat(169);
        for (number, bytes) in [(0, vec![0; 3]), (0, vec![0; 30]), (0, vec![0; 2 * 169]), (0, nan), (last, vec![0; 4])]
        {
            assert!(channel.write_block(number, Some(&bytes)).is_err());
        }
        assert!(channel.write_block(last + 1, None).is_err() && channel.read(u32::MAX).is_err());
        channel.write_block(0, Some(&[0; 2 * 37])).unwrap();
        assert_eq!(channel.bytes(), channel.budget());
    }
}
