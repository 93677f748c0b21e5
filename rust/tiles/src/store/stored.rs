//! Channels in documents: a layer has the sizes of a channel's faces, what tiles without a block read as, and the
//! blocks to the bit, rings and all.

use std::sync::Arc;

use half::f16;
use relievo_core::{Context, Error, Result};
use relievo_document::{Block, Document, Head, Kind, Layer, PageStore};
use relievo_surface::TileTopology;

use crate::layers::trace::Trace;
use crate::quads::channel::{Channel, ChannelOptions};
use crate::quads::field::Field;
use crate::store::blocks::Blocks;
use crate::store::paging::Paged;
use crate::texel::{Rgba8, Rgba16, Texel, Vector};

/// A texel that documents hold.
pub trait StoredTexel: Texel {
    /// What documents call it.
    const KIND: Kind;
}

impl StoredTexel for f16 {
    const KIND: Kind = Kind::Scalar;
}

impl StoredTexel for Rgba8 {
    const KIND: Kind = Kind::Rgba8;
}

impl StoredTexel for Rgba16 {
    const KIND: Kind = Kind::Rgba16;
}

impl StoredTexel for Vector {
    const KIND: Kind = Kind::Vector;
}

impl StoredTexel for Trace {
    const KIND: Kind = Kind::Trace;
}

/// Blocks that are unpacked at a time.
const BATCH: usize = 256;

impl<T: StoredTexel> Field<T> {
    /// Adds its tiles to `document` as the layer called `name`.
    ///
    /// # Errors
    /// Fails, and adds nothing, if the document is for another mesh or has a layer of that name, or a tile is on a page
    /// that cannot be read.
    pub fn store(&self, context: &Context, document: &mut Document, name: &str) -> Result<()> {
        let tiles: Vec<u32> = self.allocated().collect();
        let read = |tile: u32| Ok(bytemuck::cast_slice(self.try_block(tile)?.unwrap_or(&[])).to_vec());
        let blank = self.blank();
        let head = Head::new(document.free_id(), name, T::KIND, bytemuck::bytes_of(&blank), self.face_sizes());
        document.pack_layer(context, Head { given_sizes: self.given_sizes(), ..head }, &tiles, read)
    }
}

/// The number of the layer of `document` that is called `name`, the layer, and what it reads as where it has no block;
/// `None` if there is no such layer.
///
/// # Errors
/// The layer is of another kind, or what it reads as is not a finite number or, of a displacement, not 0.
pub(crate) fn layer_of<'a, T: StoredTexel>(
    document: &'a Document,
    name: &str,
) -> Result<Option<(usize, &'a Layer, T)>> {
    let Some((number, layer)) = document.layers().iter().enumerate().find(|(_, layer)| layer.name() == name) else {
        return Ok(None);
    };
    let bad = |what: &str| Err(Error::invalid(what).at(format!("layer `{name}`")));
    if layer.kind() != T::KIND {
        return bad(&format!("it holds {} and not {}", layer.kind().name(), T::KIND.name()));
    }
    let blank: T = bytemuck::pod_read_unaligned(layer.blank());
    let is_displacement = matches!(T::KIND, Kind::Scalar | Kind::Vector);
    if !T::all_finite(&[blank]) || is_displacement && layer.blank().iter().any(|byte| *byte != 0) {
        return bad("what has no block cannot read as its default");
    }
    Ok(Some((number, layer, blank)))
}

impl<T: StoredTexel> Channel<T> {
    /// The channel that was stored in `document` as the layer called `name`, which may occupy `budget` bytes; `None` if
    /// there is no such layer.
    ///
    /// # Errors
    /// Fails if the document is for another mesh, the layer is of another kind or damaged, or `budget` is too small.
    pub fn stored(
        context: &Context,
        topology: Arc<TileTopology>,
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
    /// Fails as [`Self::stored`], but for the budget where there are pages, and if a page cannot be read or written.
    pub fn stored_with(
        context: &Context,
        topology: Arc<TileTopology>,
        document: &Document,
        name: &str,
        budget: u64,
        pages: Option<&Arc<dyn PageStore>>,
    ) -> Result<Option<Self>> {
        let Some((number, layer, blank)) = layer_of::<T>(document, name)? else { return Ok(None) };
        let place = || format!("layer `{name}`");
        let mesh = document.topology();
        if mesh.tile_count() as usize != topology.tile_count() || mesh.face_count() != topology.face_count() {
            return Err(Error::invalid("the document was made on another mesh").at(place()));
        }
        let face_sizes = (0..).zip(layer.face_sizes().iter().copied()).collect();
        let mut channel = Self::blank(topology, blank, &ChannelOptions { face_sizes, budget, ..Default::default() })?;
        channel.reshape(layer.face_sizes(), &layer.head().given_sizes)?;
        channel.page_to(pages.cloned())?;
        // With mips, which documents leave out.
        let bytes: u64 = layer.blocks().iter().map(|block| channel.field.tile_bytes(block.tile())).sum();
        if bytes > budget && pages.is_none() {
            return Err(Error::memory(format!("its tiles take {bytes} bytes and their budget is {budget}"))
                .at(place())
                .advise(format!("allow at least {bytes} bytes")));
        }
        for first in (0..layer.blocks().len()).step_by(BATCH) {
            let count = BATCH.min(layer.blocks().len() - first);
            let unpacked = context.map(count, |at| layer.unpack(mesh, first + at));
            for (index, bytes) in (first..).zip(unpacked) {
                let Some(tile) = layer.blocks().get(index).map(Block::tile) else { break };
                channel.write(tile, Some(&bytes?)).map_err(|error| error.at(place()))?;
                if let Some(page) = document.page(number, index) {
                    channel.set_clean(tile, page);
                }
            }
            if pages.is_some() {
                // So that mips wait for few tiles at a time.
                channel.update_mips(context);
                channel.trim();
                channel.report_fault().map_err(|error| error.at(place()))?;
            }
        }
        channel.update_mips(context);
        Ok(Some(channel))
    }
}
