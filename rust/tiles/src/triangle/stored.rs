//! Channels over triangles in histories and documents: blocks by number, see [`super::block`], with the segments an
//! edge that the mesh has at its finest as the size of every face.

use std::any::Any;
use std::borrow::Cow;
use std::sync::Arc;

use relievo_core::{Context, Error, Result};
use relievo_document::{Document, Kind, Lattice, PageStore};
use relievo_surface::TriangleTopology;

use super::block::TriangleBlock;
use super::change::TriangleChange;
use super::channel::{TriangleChannel, TriangleOptions};
use super::field::{CHUNK, Entry, TriangleField};
use super::pattern::Pattern;
use crate::store::blocks::{Blocks, of_both};
use crate::store::pages::CowBlocks;
use crate::store::paging::Paged;
use crate::store::stored::{StoredTexel, layer_of};
use crate::texel::Texel;

/// Blocks that are unpacked at a time.
const BATCH: usize = 256;

/// The elements whose blocks differ, to the bit, ascending. Those of `related` channels are equal where their versions
/// are.
fn differing<'a, T: Texel>(
    a: &'a CowBlocks<Entry<T>>,
    b: &'a CowBlocks<Entry<T>>,
    related: bool,
) -> impl Iterator<Item = u32> + 'a {
    a.unshared(b).filter(move |element| match (a.entry(*element), b.entry(*element)) {
        (Some(a), Some(b)) => {
            !a.texels.is_same(&b.texels)
                && !(related && a.version == b.version)
                && bytemuck::cast_slice::<T, u8>(&a.texels) != bytemuck::cast_slice::<T, u8>(&b.texels)
        }
        (a, b) => a.is_some() || b.is_some(),
    })
}

impl<T: StoredTexel> Blocks for TriangleField<T> {
    fn kind(&self) -> Kind {
        T::KIND
    }

    fn blank(&self) -> &[u8] {
        bytemuck::bytes_of(self.blank_ref())
    }

    fn face_sizes(&self) -> Vec<u32> {
        vec![self.pattern().segments(); self.topology().face_count()]
    }

    fn is_sized_as(&self, other: &dyn Blocks) -> bool {
        let any: &dyn Any = other;
        any.downcast_ref::<Self>().is_some_and(|other| other.pattern() == self.pattern())
    }

    fn bytes(&self, block: u32) -> Option<Cow<'_, [u8]>> {
        let values = self.held(TriangleBlock::of(self.topology(), block)?)?;
        Some(Cow::Borrowed(bytemuck::cast_slice(values)))
    }

    fn try_bytes(&self, block: u32) -> Result<Option<Cow<'_, [u8]>>> {
        let Some(block) = TriangleBlock::of(self.topology(), block) else { return Ok(None) };
        Ok(self.try_held(block)?.map(|values| Cow::Borrowed(bytemuck::cast_slice(values))))
    }

    fn numbers(&self) -> Vec<u32> {
        self.blocks()
    }

    fn changed(&self, other: &dyn Blocks) -> Vec<u32> {
        let any: &dyn Any = other;
        let Some(other) = any.downcast_ref::<Self>() else { return of_both(self, other) };
        self.changes(other).blocks(self.topology())
    }

    fn is_shaped_as(&self, other: &dyn Blocks) -> bool {
        let any: &dyn Any = other;
        any.downcast_ref::<Self>()
            .is_some_and(|other| self.pattern() == other.pattern() && self.blank().same(other.blank()))
    }
}

impl<T: Texel> TriangleField<T> {
    /// What is not, to the bit, as in `other`, which is over the same mesh; what both share costs next to nothing.
    pub fn changes(&self, other: &Self) -> TriangleChange {
        // Of one channel: what is on pages need not be read.
        let related = self.pager.as_ref().zip(other.pager.as_ref()).is_some_and(|(a, b)| Arc::ptr_eq(a, b));
        let chunks = (0..).step_by(CHUNK).zip(self.vertices().zip(other.vertices()));
        let vertices = chunks.filter(|(_, (a, b))| !std::ptr::eq::<[T]>(*a, *b)).flat_map(|(first, (a, b))| {
            let differing = (first..).zip(a.iter().zip(b)).filter(|(_, (a, b))| !a.same(**b));
            differing.map(|(vertex, _): (u32, _)| vertex)
        });
        TriangleChange {
            faces: differing(&self.faces, &other.faces, related).collect(),
            edges: differing(&self.edges, &other.edges, related).collect(),
            vertices: vertices.collect(),
        }
    }
}

impl<T: StoredTexel> TriangleField<T> {
    /// Adds its blocks to `document` as the layer called `name`.
    ///
    /// # Errors
    /// Fails, and adds nothing, if the document is for another mesh or has a layer of that name, or a block is on a
    /// page that cannot be read.
    pub fn store(&self, context: &Context, document: &mut Document, name: &str) -> Result<()> {
        check(self.topology(), document)?;
        let read = |block: u32| Ok(self.try_bytes(block)?.unwrap_or_default().to_vec());
        let head = (name, T::KIND, Blocks::blank(self));
        document.pack(context, head, self.face_sizes(), &self.numbers(), read)
    }
}

impl<T: StoredTexel> TriangleChannel<T> {
    /// The channel that was stored in `document` as the layer called `name`, which may occupy `budget` bytes; `None` if
    /// there is no such layer. Where a damaged document lost edges of faces, they read as what they are between.
    ///
    /// # Errors
    /// Fails if the document is for another mesh, the layer is of another kind or damaged, or `budget` is too small.
    #[inline(never)]
    pub fn stored(
        context: &Context,
        topology: Arc<TriangleTopology>,
        document: &Document,
        name: &str,
        budget: u64,
    ) -> Result<Option<Self>> {
        Self::stored_with(context, topology, document, name, budget, None)
    }

    /// As [`Self::stored`], of a channel that pages to `pages`: what exceeds the budget stays in the file of the
    /// document, as far as that has it.
    ///
    /// # Errors
    /// Fails as [`Self::stored`], and if a page cannot be read or written.
    pub fn stored_with(
        context: &Context,
        topology: Arc<TriangleTopology>,
        document: &Document,
        name: &str,
        budget: u64,
        pages: Option<&Arc<dyn PageStore>>,
    ) -> Result<Option<Self>> {
        let Some((number, layer, blank)) = layer_of::<T>(document, name)? else { return Ok(None) };
        let place = |error: Error| error.at(format!("layer `{name}`"));
        check(&topology, document).map_err(place)?;
        let segments = layer.face_sizes().first().copied().unwrap_or(0);
        let mut channel = Self::blank(topology, blank, &TriangleOptions { segments, budget }).map_err(place)?;
        channel.page_to(pages.cloned())?;
        for first in (0..layer.blocks().len()).step_by(BATCH) {
            let count = BATCH.min(layer.blocks().len() - first);
            let unpacked = context.map(count, |at| layer.unpack(document.topology(), first + at));
            for ((index, block), bytes) in (first..).zip(&layer.blocks()[first..]).zip(unpacked) {
                channel.write_block(block.tile(), Some(&bytes?)).map_err(place)?;
                if let Some(page) = document.page(number, index) {
                    channel.set_clean(block.tile(), page);
                }
            }
            channel.report_fault().map_err(place)?;
        }
        channel.mend(context).map_err(place)?;
        Ok(Some(channel))
    }
}

impl<T: Texel> TriangleChannel<T> {
    /// The blocks of `before` that this channel can have too are put into it.
    ///
    /// # Errors
    /// Fails if the budget does not allow a block, this mesh does not have it, or it is on a page that cannot be read.
    #[inline(never)]
    pub fn keep(&mut self, before: &TriangleField<T>) -> Result<()> {
        let pattern = self.field().pattern();
        let fits = |own: Option<Pattern>| own.is_none_or(|own| own <= pattern && own >= pattern.coarser(2));
        let topology = before.topology();
        for number in before.blocks() {
            let Some(block) = TriangleBlock::of(topology, number) else { continue };
            let own = match block {
                TriangleBlock::Face(face) => before.face_pattern(face),
                TriangleBlock::Edge(edge) => before.edge_pattern(edge),
                TriangleBlock::Vertices(_) => None,
            };
            if fits(own) {
                self.write_block(number, before.try_held(block)?.map(bytemuck::cast_slice))?;
            }
        }
        Ok(())
    }

    /// Changes the segments that an edge has at its finest. Blocks that had more than that, or less than a quarter of
    /// it, go.
    ///
    /// # Errors
    /// Fails, and changes nothing, if the number of segments is not allowed, or a page cannot be read.
    #[inline(never)]
    pub fn set_segments(&mut self, segments: u32) -> Result<()> {
        if segments == self.field().pattern().segments() {
            return Ok(());
        }
        let field = self.field();
        let options = TriangleOptions { segments, budget: u64::MAX };
        let mut fresh = Self::blank(field.topology().clone(), field.blank(), &options)?;
        fresh.page_to(self.page_store().cloned())?;
        fresh.keep(field)?;
        fresh.set_budget(self.budget());
        *self = fresh;
        Ok(())
    }
}

/// Fails unless `document` is one of these triangles.
fn check(topology: &TriangleTopology, document: &Document) -> Result<()> {
    let own = [topology.face_count(), topology.edge_count(), topology.vertex_count()].map(|count| count as u32);
    match document.topology().lattice() {
        Lattice::Triangles { faces, edges, points } if own == [faces, edges, points] => Ok(()),
        Lattice::Triangles { .. } => Err(Error::invalid("the document was made on other triangles")),
        Lattice::Tiles => {
            Err(Error::invalid("the document was made on a Catmull-Clark surface and not on one of triangles"))
        }
    }
}

impl<T: Texel> TriangleField<T> {
    /// The values of a block that holds something: of vertices, those of which one is not blank.
    pub(super) fn held(&self, block: TriangleBlock) -> Option<&[T]> {
        match block {
            TriangleBlock::Face(face) => self.face(face),
            TriangleBlock::Edge(edge) => self.edge(edge),
            TriangleBlock::Vertices(chunk) => {
                self.chunk(chunk).filter(|values| values.iter().any(|value| !value.same(self.blank())))
            }
        }
    }

    /// As [`Self::held`]. Fails if the block is on a page that cannot be read.
    pub(super) fn try_held(&self, block: TriangleBlock) -> Result<Option<&[T]>> {
        self.block(block).map_or(Ok(()), |entry| entry.texels.check())?;
        Ok(self.held(block))
    }

    /// The numbers of the blocks that hold something, ascending.
    pub fn blocks(&self) -> Vec<u32> {
        let faces = self.allocated().map(TriangleBlock::Face);
        let edges = self.allocated_edges().map(TriangleBlock::Edge);
        let chunks = self.topology().vertex_count().div_ceil(CHUNK) as u32;
        let vertices = (0..chunks).map(TriangleBlock::Vertices).filter(|block| self.held(*block).is_some());
        faces.chain(edges).chain(vertices).map(|block| block.number(self.topology())).collect()
    }
}
