//! How finely tiles and their edges are divided: powers of two, chosen by an error on the picture.
//!
//! A tile of power p has the inner points of a grid of 2^p cells a side, so that cells are those of its texels or of
//! whole numbers of them. An edge has a power of its own, which all tiles along it share and which depends on what is
//! along it alone; between it and the inner points runs a strip of triangles. So a tile that needs many triangles makes
//! the strips beside it finer, and nothing farther away. Errors are estimated from second differences of the surface
//! and of the texels (Filip, Magedson, Markot 1986, *Surface algorithms using bounds on derivatives*).

use std::sync::Arc;

use glam::Vec3;
use relievo_core::{Context, Error, Result};
use relievo_surface::bezier::Viewpoint;
use relievo_surface::{Grid, Link, Order, Placement, Samples, Side, TileTopology};
use relievo_tiles::{Displaced, Points};

/// The highest power: 256 cells a side.
pub const MAX_POWER: u8 = 8;

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

    /// These powers of tiles; edges get the highest of the tiles they belong to.
    ///
    /// # Errors
    /// There is not one power for every tile, or one is not from 1 to [`MAX_POWER`].
    pub fn new(topology: &Arc<TileTopology>, tiles: Vec<u8>) -> Result<Self> {
        if tiles.len() != topology.tile_count() {
            let what = format!("{} rates are given for {} tiles", tiles.len(), topology.tile_count());
            return Err(Error::invalid(what));
        }
        if let Some(tile) = tiles.iter().position(|power| !(1..=MAX_POWER).contains(power)) {
            let what = format!("2 to the power of {} cells a side", tiles[tile]);
            return Err(Error::invalid(what)
                .at(format!("tile {tile}"))
                .advise(format!("use powers from 1 to {MAX_POWER}")));
        }
        let sides = tiles.iter().map(|power| [*power; 4]).collect();
        Ok(Self::of_sides(topology, tiles, sides))
    }

    /// These powers of tiles; edges get the highest that one of their sides wants.
    fn of_sides(topology: &TileTopology, tiles: Vec<u8>, wanted: Vec<[u8; 4]>) -> Self {
        let sub = |tile: u32| u8::from(topology.is_sub(tile));
        // A sub-tile has half of an edge of the cage.
        let of = |side: Side| wanted[side.tile as usize][usize::from(side.edge)] + sub(side.tile);
        let edge = |tile: u32, edge: u8| {
            let mut most = of(Side { tile, edge });
            along(topology, tile, edge, |side| most = most.max(of(side)));
            most.min(MAX_POWER) - sub(tile)
        };
        let edges = (0..tiles.len() as u32).map(|tile| [0, 1, 2, 3].map(|number| edge(tile, number))).collect();
        Self { tiles, edges }
    }

    /// The power of `tile`.
    ///
    /// # Panics
    /// It does not exist.
    pub fn tile(&self, tile: u32) -> u8 {
        self.tiles[tile as usize]
    }

    /// The powers of its edges, which all tiles along them divide alike.
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

/// Tells of the other sides along the edge of the cage at an edge of a tile.
fn along(topology: &TileTopology, tile: u32, edge: u8, mut tell: impl FnMut(Side)) {
    match topology.link(tile, edge) {
        Link::Boundary => {}
        Link::Whole { side, .. } => tell(side),
        Link::Halves { first, second, .. } => [first, second].into_iter().for_each(tell),
        Link::Half { side, .. } => {
            tell(side);
            if let Link::Halves { first, second, .. } = topology.link(side.tile, side.edge) {
                [first, second].into_iter().for_each(tell);
            }
        }
        Link::Pinned { edge } => topology.pinned_sides(edge).for_each(tell),
    }
}

/// How far triangles of a tile are from it, and where it is.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Relief {
    surface: Bends,
    displacement: Bends,
    /// How far apart displacements of the tile are.
    range: f32,
    pub low: [f32; 3],
    pub high: [f32; 3],
}

/// How far one triangle of half a tile would be from it, in object units.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Bends {
    /// Anywhere.
    inside: f32,
    /// Along an edge and in the strip beside it.
    edges: [f32; 4],
    /// What the twist of the strip adds.
    twists: [f32; 4],
}

impl Bends {
    /// By second differences of a lattice of `side` points a side, whose cells have `unit` of a tile's side; what is
    /// along an edge is looked for in the `rows` rows that are nearest to it.
    fn new(side: usize, rows: usize, unit: f32, at: impl Fn(usize, usize) -> Vec3) -> Self {
        let mut bends = Self::default();
        let inner = 1..side - 1;
        for j in 0..side {
            for i in 0..side {
                let here = at(i, j);
                let [mut uu, mut vv, mut uv] = [Vec3::ZERO; 3];
                if inner.contains(&i) {
                    uu = at(i - 1, j) - 2.0 * here + at(i + 1, j);
                }
                if inner.contains(&j) {
                    vv = at(i, j - 1) - 2.0 * here + at(i, j + 1);
                }
                if i + 1 < side && j + 1 < side {
                    uv = here + at(i + 1, j + 1) - at(i + 1, j) - at(i, j + 1);
                }
                let [bend_u, bend_v, twist] = [uu, vv, 2.0 * uv].map(Vec3::length);
                bends.inside = bends.inside.max(bend_u).max(bend_v).max((uu + vv).length() + twist);
                let away = [j, side - 1 - i, side - 1 - j, i];
                for ((edge, away), bend) in (0..).zip(away).zip([bend_u, bend_v, bend_u, bend_v]) {
                    if away < rows {
                        bends.edges[edge] = bends.edges[edge].max(bend);
                    }
                    if away <= rows {
                        bends.twists[edge] = bends.twists[edge].max(twist);
                    }
                }
            }
        }
        let scale = 0.125 * MARGIN / (unit * unit);
        let Self { inside, edges, twists } = bends;
        Self {
            inside: scale * inside,
            edges: edges.map(|bend| scale * (bend + STRIP * inside)),
            twists: twists.map(|twist| scale * twist),
        }
    }

    fn add(&mut self, other: Self) {
        self.inside += other.inside;
        for edge in 0..4 {
            self.edges[edge] += other.edges[edge];
            self.twists[edge] += other.twists[edge];
        }
    }

    fn max(self, other: Self) -> Self {
        let of = |a: [f32; 4], b: [f32; 4]| std::array::from_fn(|edge| a[edge].max(b[edge]));
        Self {
            inside: self.inside.max(other.inside),
            edges: of(self.edges, other.edges),
            twists: of(self.twists, other.twists),
        }
    }

    /// Of a tile divided by 2^power.
    fn error(&self, power: u8) -> f64 {
        f64::from(self.inside) * step(power) * step(power)
    }

    /// Of the strip between it and an edge divided by 2^along.
    fn edge_error(&self, edge: usize, power: u8, along: u8) -> f64 {
        let [bend, twist] = [self.edges[edge], self.twists[edge]].map(f64::from);
        step(along) * (bend * step(along) + twist * step(power))
    }
}

fn step(power: u8) -> f64 {
    (-f64::from(power)).exp2()
}

/// Cells along a side of the lattice from which the bend of a surface is measured.
const CELLS: usize = 8;
/// How much of the bend inside a tile is seen in the strip beside an edge: the most of (1 − h)² h, where h goes from the
/// edge to the tips of the triangles that stand on it.
const STRIP: f32 = 4.0 / 27.0;
/// The reserve for what lies between the points of the lattice, and for triangles of strips that lean.
const MARGIN: f32 = 1.25;

impl Relief {
    /// Of `tile`.
    pub fn new(context: &Context, displaced: &Displaced<'_>, tile: u32) -> Self {
        let (low, high) = displaced.tile_bounds(tile);
        let field = displaced.field();
        let block = field.block(tile);
        let [least, most] = if block.is_some() { field.range(tile) } else { [0.0; 2] };
        let away = if most > -least { most } else { least };
        let order = if away == 0.0 { Order::Position } else { Order::First };
        let grid = Grid::whole(CELLS as u32, Placement::Lattice);
        let mut samples = Samples::default();
        displaced.surface().grid(context.level(), tile, &grid, order, &mut samples);
        let vector = |of: &[Vec<f32>; 3], at: usize| Vec3::new(of[0][at], of[1][at], of[2][at]);
        let number = |i: usize, j: usize| j * (CELLS + 1) + i;
        let unit = 1.0 / CELLS as f32;
        let mut surface = Bends::new(CELLS + 1, 1, unit, |i, j| vector(&samples.p, number(i, j)));
        if order == Order::First {
            // What is away from the surface bends as the parallel surface there.
            let moved = |at: usize| {
                let normal = vector(&samples.du, at).cross(vector(&samples.dv, at)).normalize_or_zero();
                vector(&samples.p, at) + away * normal
            };
            let parallel: Vec<Vec3> = (0..samples.len()).map(moved).collect();
            surface = surface.max(Bends::new(CELLS + 1, 1, unit, |i, j| parallel[number(i, j)]));
        }
        // On an edge the spline is between the ring and the first row.
        let of_texels = |size: u32, texel: &dyn Fn(usize) -> Vec3| {
            let side = size as usize + 2;
            Bends::new(side, 3, 1.0 / size as f32, |i, j| texel(j * side + i))
        };
        let mut displacement = block.map_or(Bends::default(), |block| {
            of_texels(field.size(tile), &|at| Vec3::new(block[at].to_f32(), 0.0, 0.0))
        });
        let mut range = most - least;
        if let Some((vectors, block)) = displaced.vectors().and_then(|vectors| Some((vectors, vectors.block(tile)?))) {
            displacement.add(of_texels(vectors.size(tile), &|at| Vec3::from(block[at].0.map(|part| part.to_f32()))));
            range += 2.0 * vectors.length(tile);
            // Their frames turn with the surface.
            let mut points = Points::default();
            if displaced.grid(context, tile, &grid, &mut points).is_ok() {
                surface = surface.max(Bends::new(CELLS + 1, 1, unit, |i, j| Vec3::from(points.p[number(i, j)])));
            }
        }
        Self { surface, displacement, range, low, high }
    }

    fn error(&self, of: impl Fn(&Bends) -> f64) -> f64 {
        of(&self.surface) + of(&self.displacement).min(f64::from(self.range))
    }
}

/// The lowest powers whose triangles are nowhere farther than `tolerance` pixels from the surface as the picture shows
/// it, by the estimate of `reliefs`. What the highest power is not enough for gets it, and so does what reaches behind
/// the camera; tiles out of its sight get the lowest.
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
    let (mut tiles, mut sides) = (Vec::with_capacity(reliefs.len()), Vec::with_capacity(reliefs.len()));
    for relief in reliefs {
        let reach = view.reach(relief.low, relief.high, tolerance);
        let lowest =
            |error: &dyn Fn(u8) -> f64| (1..MAX_POWER).find(|power| error(*power) <= reach).unwrap_or(MAX_POWER);
        let power = lowest(&|power| relief.error(|bends| bends.error(power)));
        let side = |edge: usize| lowest(&|along| relief.error(|bends| bends.edge_error(edge, power, along)));
        tiles.push(power);
        sides.push(std::array::from_fn(side));
    }
    Ok(TileRates::of_sides(topology, tiles, sides))
}
