//! Tiles of a Catmull-Clark surface as squares of cells. Along an edge where tiles of different rate meet, the finer one
//! has its corners on the chords of the coarser one, so that nothing opens.

use relievo_core::{Context, Error, Result};
use relievo_surface::{Grid, Link, Placement, TileTopology};
use relievo_tiles::{Displaced, Points};

use crate::square::{Chart, Square, rate};
use crate::{MAX_CELLS, Procedural};

/// Cells along every tile, from those along an edge of the cage: powers of two from 4 to 512, half for sub-tiles; 0 for
/// holes.
pub fn procedural_rates(topology: &TileTopology, cells: impl Fn(u32) -> u32) -> Vec<u32> {
    let of = |tile: u32| match topology.is_hole(tile) {
        true => 0,
        false => rate(cells(tile) >> u32::from(topology.is_sub(tile)), MAX_CELLS),
    };
    (0..topology.tile_count() as u32).map(of).collect()
}

impl Procedural {
    /// The primitives of a surface with `rates[tile]` cells along each tile ([`procedural_rates`]); if `end` is given,
    /// of one that moves from the first to the second.
    ///
    /// # Errors
    /// Fails with `Invalid` if the surfaces have other tiles than there are rates, and with `Memory` if it does not fit
    /// the context's memory limit.
    pub fn new(context: &Context, begin: &Displaced<'_>, end: Option<&Displaced<'_>>, rates: &[u32]) -> Result<Self> {
        let topology = begin.field().topology();
        let fits = |displaced: &Displaced<'_>| displaced.field().tile_count() == rates.len();
        if !fits(begin) || !end.is_none_or(fits) {
            return Err(Error::invalid("the surface at the end has other tiles than at the beginning")
                .advise("use the same cage in another pose"));
        }
        let there = (0_u32..).zip(rates).filter(|(_, rate)| **rate > 0);
        let squares: Vec<Square> = there
            .map(|(tile, rate)| Square { tile, chart: Chart::Tile, rate: *rate, ruled: ruled(topology, rates, tile) })
            .collect();
        Self::of_squares(context, &squares, end.is_some(), |square, at_end| {
            let displaced = end.filter(|_| at_end).unwrap_or(begin);
            let mut points = Points::default();
            displaced.grid(context, square.tile, &Grid::whole(square.rate, Placement::Lattice), &mut points)?;
            Ok(points.p)
        })
    }
}

/// How many cells along each edge of a tile a coarser neighbour rules, half by half; 0 where none does.
fn ruled(topology: &TileTopology, rates: &[u32], tile: u32) -> [[u32; 2]; 4] {
    let half = rates[tile as usize] / 2;
    let of = |tile: u32| rates.get(tile as usize).copied().filter(|rate| *rate > 0).unwrap_or(u32::MAX);
    // The cells of a neighbour along half of the edge, if they are fewer than its own.
    let ruled = |cells: u32| if cells < half { cells } else { 0 };
    [0, 1, 2, 3].map(|edge| match topology.link(tile, edge) {
        Link::Boundary | Link::Pinned { .. } => [0; 2],
        Link::Whole { side, .. } => [ruled(of(side.tile) / 2); 2],
        // Half of this edge is a quarter of the other's.
        Link::Half { side, .. } => [ruled(of(side.tile) / 4); 2],
        Link::Halves { first, second, .. } => [ruled(of(first.tile)), ruled(of(second.tile))],
    })
}
