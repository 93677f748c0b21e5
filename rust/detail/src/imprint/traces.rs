//! What an imprint notes down of itself: the traces of contact of the coefficients that it pushes. Rims are no contact.

use half::f16;
use relievo_core::{Context, Error, Result};
use relievo_tiles::{Applied, Candidate, Field, Sets, Traces};

use crate::channels::knots::block_edge;
use crate::imprint::dents::TileDents;

/// Fails if tiles of the traces have other sizes than those of the displacement.
pub(crate) fn check<'a>(field: &Field, mut dents: impl Iterator<Item = &'a TileDents>, traces: &Traces) -> Result<()> {
    match dents.find(|dents| traces.field().size(dents.tile) != field.size(dents.tile)) {
        None => Ok(()),
        Some(dents) => Err(Error::invalid("its traces have another size than its displacement")
            .at(format!("tile {}", dents.tile))
            .advise("make the traces anew after the displacement was given other sizes")),
    }
}

/// Notes in `traces` that those of `dents` that are named, ascending by tile, are being pushed at `time`. `field` is the
/// displacement before it is. Returns the tiles that the budget refused.
pub(crate) fn record(
    context: &Context,
    field: &Field,
    (dents, order): (&[TileDents], &[usize]),
    traces: &mut Traces,
    time: f64,
) -> Result<Vec<u32>> {
    let scratch = context.scratch();
    let mut pushes = scratch.list();
    context.map_into(order.len(), &mut pushes, |index| Pushes::new(context, field, &dents[order[index]]));
    let pushing = || pushes.iter().filter(|pushes| !pushes.depths.is_empty()).map(|pushes| pushes.tile);
    let mut candidates = scratch.list();
    candidates.extend(pushing().map(|tile| Candidate { tile, decision: Candidate::MODIFY }));
    let sets = Sets::scan(context, &candidates, |tile| traces.field().is_allocated(tile));
    let mut applied = scratch.lend::<Applied>();
    let done = traces.apply_into(&sets, &mut applied);
    sets.give_back(context);
    done?;
    let refused = |tile: u32| applied.refused.binary_search(&tile).is_ok();
    let mut tiles = scratch.list();
    tiles.extend(pushing().filter(|tile| !refused(*tile)));
    let mut changes = traces.edit(context, &tiles, |tile, texels| {
        let Ok(index) = pushes.binary_search_by_key(&tile, |pushes| pushes.tile) else { return };
        let size = texels.size();
        for (at, depth) in &pushes[index].depths {
            let texel = &mut texels.row_mut(*at as usize / size)[*at as usize % size];
            *texel = texel.pushed(*depth, time as f32);
        }
    })?;
    changes.extend_from_slice(&applied.changes);
    pushes.drain(..).for_each(|pushes| scratch.keep_list(pushes.depths));
    let mut refused = std::mem::take(&mut applied.refused);
    refused.extend(traces.settle(context, &changes)?);
    scratch.keep_list(changes);
    Ok(refused)
}

/// The coefficients of a tile that are pushed.
struct Pushes {
    tile: u32,
    /// Number of the coefficient, row by row, and how far it is pushed.
    depths: Vec<(u32, f32)>,
}

impl Pushes {
    fn new(context: &Context, field: &Field, dents: &TileDents) -> Self {
        let size = field.size(dents.tile);
        let edge = block_edge(size);
        let source = field.block(dents.tile);
        let mut depths = context.scratch().take_list();
        // With room for the whole tile, so that whoever gets the list next has enough.
        depths.reserve(size.pow(2) as usize);
        for block in &dents.blocks {
            let (column, row) = (block.index % (size / edge) * edge, block.index / (size / edge) * edge);
            for (k, new) in (0..edge * edge).zip(&block.values) {
                let (i, j) = (column + k % edge, row + k / edge);
                let old = source.map_or(f16::ZERO, |source| source[((j + 1) * (size + 2) + i + 1) as usize]);
                let depth = old.to_f32() - new.to_f32();
                if depth > 0.0 {
                    depths.push((j * size + i, depth));
                }
            }
        }
        Self { tile: dents.tile, depths }
    }
}
