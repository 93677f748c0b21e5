//! How finely tiles are divided: powers of two, chosen by an error on the picture, and equal on both sides of an edge.
//!
//! A tile of power p is a grid of 2^p cells a side, so that cells are those of its texels or of whole numbers of them,
//! and that two sub-tiles divide the edge of a quad in its middle. As with Bézier patches an edge is divided as the
//! coarsest tile at it is, and samples of a finer grid move to the nearest sample of the edge: triangles without area,
//! but no cracks. Errors are estimated from second derivatives of the surface and second differences of the texels
//! (Filip, Magedson, Markot 1986, *Surface algorithms using bounds on derivatives*).

use std::sync::Arc;

use relievo_core::{Context, Error, Result};
use relievo_surface::bezier::Viewpoint;
use relievo_surface::{Grid, Link, Order, Placement, Samples, TileTopology};
use relievo_tiles::Displaced;

/// The highest power: 256 cells a side.
pub const MOST_POWER: u8 = 8;

/// The powers of all tiles and of their edges.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TileRates {
    tiles: Vec<u8>,
    edges: Vec<[u8; 4]>,
}

impl TileRates {
    /// `cells` along an edge of the cage, half of it on sub-tiles, but at least two.
    ///
    /// # Errors
    /// It is not a power of two from 2 to 256.
    pub fn uniform(topology: &Arc<TileTopology>, cells: u32) -> Result<Self> {
        if !cells.is_power_of_two() {
            return Err(Error::invalid(format!("tiles cannot be divided into {cells} cells a side"))
                .advise("use a power of two from 2 to 256"));
        }
        let power = cells.trailing_zeros() as u8;
        let of = |tile: u32| power.saturating_sub(u8::from(topology.is_sub(tile))).max(1);
        Self::new(topology, (0..topology.tile_count() as u32).map(of).collect())
    }

    /// These powers of tiles; edges get the lowest of the tiles they belong to.
    ///
    /// # Errors
    /// There is not one power for every tile, or one is not from 1 to [`MOST_POWER`].
    pub fn new(topology: &Arc<TileTopology>, tiles: Vec<u8>) -> Result<Self> {
        if tiles.len() != topology.tile_count() {
            let what = format!("{} rates are given for {} tiles", tiles.len(), topology.tile_count());
            return Err(Error::invalid(what));
        }
        if let Some(tile) = tiles.iter().position(|power| !(1..=MOST_POWER).contains(power)) {
            let what = format!("2 to the power of {} cells a side", tiles[tile]);
            return Err(Error::invalid(what)
                .at(format!("tile {tile}"))
                .advise(format!("use powers from 1 to {MOST_POWER}")));
        }
        let mut edges = vec![[0; 4]; tiles.len()];
        for (tile, edges) in (0..).zip(&mut edges) {
            for (number, edge) in (0..).zip(edges) {
                *edge = whole_edge(topology, &tiles, tile, number) - u8::from(topology.is_sub(tile));
            }
        }
        Ok(Self { tiles, edges })
    }

    /// The power of `tile`.
    ///
    /// # Panics
    /// It does not exist.
    pub fn tile(&self, tile: u32) -> u8 {
        self.tiles[tile as usize]
    }

    /// The powers of its edges, none above its own.
    ///
    /// # Panics
    /// It does not exist.
    pub fn edges(&self, tile: u32) -> [u8; 4] {
        self.edges[tile as usize]
    }

    /// How many tiles there are.
    pub fn count(&self) -> usize {
        self.tiles.len()
    }
}

/// The power that the edge of the cage at an edge of a tile is divided by: the lowest of all tiles along it, where
/// sub-tiles count one more, since they have half of the edge.
fn whole_edge(topology: &TileTopology, tiles: &[u8], tile: u32, edge: u8) -> u8 {
    let of = |tile: u32| tiles[tile as usize] + u8::from(topology.is_sub(tile));
    let own = of(tile);
    match topology.link(tile, edge) {
        Link::Boundary => own,
        Link::Whole { side, .. } => own.min(of(side.tile)),
        Link::Halves { first, second, .. } => own.min(of(first.tile)).min(of(second.tile)),
        // The quad's edge decides, which looks at both halves.
        Link::Half { side, .. } => whole_edge(topology, tiles, side.tile, side.edge),
        Link::Pinned { edge } => topology.pinned_sides(edge).map(|side| of(side.tile)).fold(own, u8::min),
    }
}

/// How far triangles of a tile are from it, and where it is.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Relief {
    /// Object units of the surface at one cell; a quarter of it at each further power.
    bend: f32,
    /// As [`Self::bend`], of the displacement, which is never more than `range`.
    bump: f32,
    range: f32,
    pub low: [f32; 3],
    pub high: [f32; 3],
}

/// Samples along a side of a tile from which its bend is estimated.
const SAMPLES: u32 = 5;

impl Relief {
    /// Of `tile`.
    pub fn new(context: &Context, displaced: &Displaced<'_>, tile: u32) -> Self {
        let (low, high) = displaced.tile_bounds(tile);
        let mut samples = Samples::default();
        let grid = Grid::whole(SAMPLES - 1, Placement::Lattice);
        displaced.surface().grid(context.level(), tile, &grid, Order::Second, &mut samples);
        let length = |of: &[Vec<f32>; 3], at: usize| glam::Vec3::new(of[0][at], of[1][at], of[2][at]).length();
        let second = |at: usize| length(&samples.duu, at) + 2.0 * length(&samples.duv, at) + length(&samples.dvv, at);
        let bend = 0.125 * (0..samples.len()).map(second).fold(0.0, f32::max);
        let field = displaced.field();
        let mut relief = Self { bend, low, high, ..Self::default() };
        if let Some(block) = field.block(tile) {
            let size = field.size(tile) as usize;
            let texel = |i: usize, j: usize| block[j * (size + 2) + i].to_f32();
            let mut most = 0.0f32;
            for j in 0..size {
                for i in 0..size {
                    let (here, right, up) = (texel(i, j), texel(i + 1, j), texel(i, j + 1));
                    let uu = texel(i + 2, j) - 2.0 * right + here;
                    let vv = texel(i, j + 2) - 2.0 * up + here;
                    let uv = texel(i + 1, j + 1) - right - up + here;
                    most = most.max(uu.abs() + 2.0 * uv.abs() + vv.abs());
                }
            }
            relief.bump = 0.125 * most * (size * size) as f32;
            let [least, greatest] = field.range(tile);
            relief.range = greatest - least;
        }
        relief
    }

    /// How far triangles are from the tile where it is divided by 2^power and its edges are by 2^edges.
    fn error(&self, power: u8, edges: [u8; 4]) -> f64 {
        let step = |power: u8| (-f64::from(power)).exp2();
        let inner = step(power);
        // Beside a coarser edge triangles reach from its samples to the inner one that is nearest.
        let long = edges.into_iter().filter(|edge| *edge < power).map(|edge| step(edge) + inner).fold(inner, f64::max);
        let square = long * long;
        f64::from(self.bend) * square + (f64::from(self.bump) * square).min(f64::from(self.range))
    }
}

/// The lowest powers whose triangles are nowhere farther than `tolerance` pixels from the surface as the picture shows
/// it, by the estimate of `reliefs`. Tiles for which the highest power is not enough get it, and so do those that reach
/// behind the camera; those out of its sight get the lowest.
pub(super) fn select(
    topology: &Arc<TileTopology>,
    reliefs: &[Relief],
    view: &Viewpoint,
    tolerance: f64,
) -> Result<TileRates> {
    if !(tolerance > 0.0 && tolerance.is_finite()) {
        return Err(Error::invalid(format!("the tolerance of {tolerance} pixels cannot be met"))
            .advise("use a number above zero"));
    }
    let reach: Vec<f64> = reliefs.iter().map(|relief| view.reach(relief.low, relief.high, tolerance)).collect();
    let enough = |tile: usize, power: u8, edges: [u8; 4]| reliefs[tile].error(power, edges) <= reach[tile];
    let lowest = |tile: usize| (1..MOST_POWER).find(|power| enough(tile, *power, [*power; 4])).unwrap_or(MOST_POWER);
    let mut rates = TileRates::new(topology, (0..reliefs.len()).map(lowest).collect())?;
    // Triangles beside an edge that is coarser than a tile are longer: where they are too long, the tiles that make it
    // coarse get finer. Powers only grow, so this ends.
    loop {
        let mut raised = rates.tiles.clone();
        for tile in 0..reliefs.len() {
            let (power, edges) = (rates.tiles[tile], rates.edges[tile]);
            if edges == [power; 4] || enough(tile, power, edges) {
                continue;
            }
            let sub = |tile: u32| u8::from(topology.is_sub(tile));
            for (number, edge) in (0..).zip(edges) {
                // One more than the whole edge has, on every tile along it.
                let wanted = edge + sub(tile as u32) + 1;
                let mut raise = |beside: u32| {
                    let power = &mut raised[beside as usize];
                    *power = (*power).max((wanted - sub(beside)).min(MOST_POWER));
                };
                if edge >= power {
                    continue;
                }
                match topology.link(tile as u32, number) {
                    Link::Boundary => {}
                    Link::Whole { side, .. } => raise(side.tile),
                    Link::Halves { first, second, .. } => [first, second].iter().for_each(|side| raise(side.tile)),
                    Link::Half { side, .. } => {
                        raise(side.tile);
                        if let Link::Halves { first, second, .. } = topology.link(side.tile, side.edge) {
                            [first, second].iter().for_each(|side| raise(side.tile));
                        }
                    }
                    Link::Pinned { edge } => topology.pinned_sides(edge).for_each(|side| raise(side.tile)),
                }
            }
        }
        if raised == rates.tiles {
            return Ok(rates);
        }
        rates = TileRates::new(topology, raised)?;
    }
}
