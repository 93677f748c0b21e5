//! The blocks of a surface, layer by layer, as caches keep them.

use relievo_core::{Error, Result};
use relievo_detail::{DecayingObject, DisplacedObject, LayeredObject};
use relievo_document::Kind;

use crate::run::cache::Layer;

/// The block of `tile`; `None` if it has none, or the surface has no such layer.
pub fn read(surface: &DisplacedObject, layer: Layer, tile: u32) -> Result<Option<Vec<u8>>> {
    Ok(match layer {
        Layer::Displacement => surface.read_displacement(tile)?,
        Layer::Paint => surface.read_paint(tile)?,
        Layer::Traces => surface.traces().map(|traces| traces.read(tile)).transpose()?.flatten(),
        Layer::DisplacementStamps => surface.read_stamps(Kind::Scalar, tile),
        Layer::PaintStamps => surface.read_stamps(Kind::Rgba8, tile),
        Layer::Sizes => surface.read_sizes(tile),
        Layer::Vectors => surface.vectors().map(|vectors| vectors.read(tile)).transpose()?.flatten(),
    })
}

/// Puts a block back, or takes it away. Fails if the surface has no such layer or tile, or the block does not fit it.
pub fn write(surface: &mut DisplacedObject, layer: Layer, tile: u32, bytes: Option<&[u8]>) -> Result<()> {
    let missing = |what: &str| Error::invalid(format!("an object has no {what}"));
    match layer {
        Layer::Displacement => surface.write_displacement(tile, bytes),
        Layer::Paint => surface.write_paint(tile, bytes),
        Layer::Sizes => surface.write_sizes(tile, bytes),
        Layer::Traces => surface.traces_mut().ok_or_else(|| missing("traces"))?.write(tile, bytes),
        Layer::DisplacementStamps => surface.write_stamps(Kind::Scalar, tile, bytes),
        Layer::PaintStamps => surface.write_stamps(Kind::Rgba8, tile, bytes),
        Layer::Vectors => surface.vectors_mut().ok_or_else(|| missing("vectors"))?.write(tile, bytes),
    }
}

/// All blocks there are.
pub fn allocated(surface: &DisplacedObject) -> Vec<(Layer, u32)> {
    let mut list = Vec::new();
    let mut add = |layer: Layer, tiles: &mut dyn Iterator<Item = u32>| list.extend(tiles.map(|tile| (layer, tile)));
    add(Layer::Sizes, &mut surface.sized_layers().into_iter());
    add(Layer::Displacement, &mut surface.displaced_tiles().into_iter());
    add(Layer::Paint, &mut surface.painted_tiles().into_iter());
    add(Layer::Traces, &mut surface.traces().into_iter().flat_map(|traces| traces.field().allocated()));
    add(Layer::Vectors, &mut surface.vectors().into_iter().flat_map(|vectors| vectors.field().allocated()));
    add(Layer::DisplacementStamps, &mut surface.stamped_blocks(Kind::Scalar).into_iter());
    add(Layer::PaintStamps, &mut surface.stamped_blocks(Kind::Rgba8).into_iter());
    list
}

/// Makes what was edited visible to readers. Returns the blocks that changed since this was done last.
pub fn commit(surface: &mut DisplacedObject) -> Vec<(Layer, u32)> {
    let mut list = Vec::new();
    let mut add = |layer: Layer, tiles: &[u32]| list.extend(tiles.iter().map(|tile| (layer, *tile)));
    add(Layer::Sizes, &surface.commit_sizes());
    // Taking it for writing also makes the object measure its reach anew, so that a frame does not depend on whether
    // the frames before were computed or opened.
    add(Layer::Displacement, &surface.commit_displacement());
    add(Layer::Paint, &surface.commit_paint());
    if let Some(traces) = surface.traces_mut() {
        add(Layer::Traces, traces.commit().changed());
    }
    if let Some(vectors) = surface.vectors_mut() {
        add(Layer::Vectors, vectors.commit().changed());
    }
    add(Layer::DisplacementStamps, &surface.commit_stamps(Kind::Scalar));
    add(Layer::PaintStamps, &surface.commit_stamps(Kind::Rgba8));
    list
}
