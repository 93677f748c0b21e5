//! A displaced Catmull-Clark surface drawn from virtual vertices: which tiles a draw has, how they and their edges are
//! divided, and where places on edges are evaluated (`shaders/tiles_draw.wgsl`).
//!
//! The vertices of a grid have no data: the vertex stage finds the cell from their number. An index buffer goes through
//! the grid in bands of few columns, so that devices evaluate a vertex about once and not at each of its six triangles.
//! Places on edges and at vertices are evaluated at the canonical place that the processor has too
//! ([`Field::canonical`]), in the one tile that it names, so that all tiles there get the same bits.

use std::collections::BTreeMap;
use std::sync::Arc;

use glam::DVec3;
use relievo_core::{Context, Error, Result};
use relievo_gpu::{Buffer, Device};
use relievo_surface::bezier::Viewpoint;
use relievo_surface::{Place, TileTopology};
use relievo_tiles::{Displaced, Field, Points};

use super::placed::{DeviceMesh, MeshVertex, NO_TAG};
use super::rates::{Relief, TileRates, select};
use crate::scene::Material;

/// Columns of cells of a band.
const BAND: u32 = 8;
/// Places of a tile that are evaluated elsewhere: halves of edges, then corners and middles of edges.
const JOINTS: usize = 16;
/// Tags that false colours tell apart at most.
const TAGS: u32 = 1 << 12;

/// A draw of grids of one power.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TileDraw {
    /// Grids have 2^power cells a side.
    pub power: u8,
    /// The first of its tiles, in the order of the draws.
    pub first: u32,
    /// How many tiles.
    pub count: u32,
}

impl TileDraw {
    /// Triangles of the draw, those without area counted: two for every cell.
    pub fn triangles(&self) -> u64 {
        u64::from(self.count) * (2u64 << (2 * self.power))
    }

    /// Vertices of the draw, each counted once: 2^power + 1 along both sides of a grid.
    pub fn vertices(&self) -> u64 {
        u64::from(self.count) * ((1u64 << self.power) + 1).pow(2)
    }
}

/// How a displaced surface is drawn.
#[derive(Debug)]
pub struct VirtualTiles {
    topology: Arc<TileTopology>,
    reliefs: Vec<Relief>,
    rates: TileRates,
    tags: Vec<u32>,
    draws: Vec<TileDraw>,
    order: Vec<u32>,
    pub(super) joints: Buffer<[u32; 2]>,
    pub(super) drawn: Buffer<[u32; 2]>,
    pub(super) grids: BTreeMap<u8, Buffer<u32>>,
}

impl VirtualTiles {
    /// All tiles of a surface, divided into `cells` along an edge of the cage.
    ///
    /// # Errors
    /// `cells` is not a power of two from 2 to 256, the surface has vector displacement, or the device has no memory.
    pub fn new(context: &Context, device: &Device, displaced: &Displaced<'_>, cells: u32) -> Result<Self> {
        let topology = displaced.field().topology().clone();
        let count = topology.tile_count();
        let rates = TileRates::uniform(&topology, cells)?;
        let mut made = Self {
            reliefs: vec![Relief::default(); count],
            tags: vec![0; count],
            draws: Vec::new(),
            order: Vec::new(),
            joints: Buffer::new(device, "joints", JOINTS * count.max(1))?,
            drawn: Buffer::new(device, "drawn tiles", count.max(1))?,
            grids: BTreeMap::new(),
            rates: rates.clone(),
            topology,
        };
        made.update(context, device, displaced, &(0..count as u32).collect::<Vec<_>>())?;
        made.divide(device, rates)?;
        Ok(made)
    }

    /// Takes over that `changed` tiles, ascending, were edited, allocated or freed, or moved with the cage. What the
    /// device has of the surface and its displacement is to be updated apart.
    ///
    /// # Errors
    /// The surface has other tiles or vector displacement, or the device fails.
    pub fn update(
        &mut self,
        context: &Context,
        device: &Device,
        displaced: &Displaced<'_>,
        changed: &[u32],
    ) -> Result<()> {
        let field = displaced.field();
        if field.tile_count() != self.reliefs.len() {
            let what = format!("a surface of {} tiles instead of {}", field.tile_count(), self.reliefs.len());
            return Err(Error::invalid(what).advise("give the surface that is drawn"));
        }
        if displaced.vectors().is_some_and(|vectors| vectors.allocated().next().is_some()) {
            return Err(Error::unsupported("vector displacement is not drawn by graphics devices")
                .advise("use the device `cpu`"));
        }
        let live = |tile: &u32| (*tile as usize) < self.reliefs.len() && !self.topology.is_hole(*tile);
        let changed: Vec<u32> = changed.iter().copied().filter(live).collect();
        let reliefs = context.map(changed.len(), |at| Relief::new(context, displaced, changed[at]));
        for (tile, relief) in changed.iter().zip(reliefs) {
            self.reliefs[*tile as usize] = relief;
        }
        // Tiles around them may be evaluated in another one now.
        let mut beside: Vec<u32> = changed.iter().flat_map(|tile| around(&self.topology, *tile)).collect();
        beside.sort_unstable();
        beside.dedup();
        let joints = context.map(beside.len(), |at| joints_of(field, beside[at]));
        let mut first = 0;
        for run in beside.chunk_by(|a, b| a + 1 == *b) {
            let lists = &joints[first..first + run.len()];
            self.joints.write(device, JOINTS * run[0] as usize, lists.as_flattened())?;
            first += run.len();
        }
        Ok(())
    }

    /// Divides tiles as `rates` says.
    ///
    /// # Errors
    /// There are not as many, or the device fails.
    pub fn divide(&mut self, device: &Device, rates: TileRates) -> Result<()> {
        if rates.count() != self.reliefs.len() {
            return Err(Error::invalid(format!("{} rates for {} tiles", rates.count(), self.reliefs.len())));
        }
        let topology = &self.topology;
        self.order = (0..rates.count() as u32).filter(|tile| !topology.is_hole(*tile)).collect();
        self.order.sort_by_key(|tile| rates.tile(*tile));
        self.draws.clear();
        let mut first = 0;
        for run in self.order.chunk_by(|a, b| rates.tile(*a) == rates.tile(*b)) {
            let (power, count) = (rates.tile(run[0]), run.len() as u32);
            self.draws.push(TileDraw { power, first, count });
            first += count;
            if let std::collections::btree_map::Entry::Vacant(entry) = self.grids.entry(power) {
                let indices = grid(1 << power);
                let buffer = Buffer::vertices(device, "grid", indices.len())?;
                buffer.write(device, 0, &indices)?;
                entry.insert(buffer);
            }
        }
        self.rates = rates;
        self.write(device)
    }

    /// Divides tiles so that triangles are at most about `tolerance` pixels from the surface as `view`, in its space,
    /// shows it.
    ///
    /// # Errors
    /// The tolerance is not above zero, or the device fails.
    pub fn adapt(&mut self, device: &Device, view: &Viewpoint, tolerance: f64) -> Result<()> {
        let rates = select(&self.topology, &self.reliefs, view, tolerance)?;
        if rates == self.rates { Ok(()) } else { self.divide(device, rates) }
    }

    /// Says which false colour tiles get where a view has some.
    ///
    /// # Errors
    /// A tag is 4,096 or above, or the device fails.
    pub fn tag(&mut self, device: &Device, tag: impl Fn(u32) -> u32) -> Result<()> {
        let tags: Vec<u32> = (0..self.reliefs.len() as u32).map(tag).collect();
        if tags.iter().any(|tag| *tag >= TAGS) {
            return Err(Error::invalid(format!("tags of tiles go up to {}", TAGS - 1)));
        }
        self.tags = tags;
        self.write(device)
    }

    /// The very vertices and triangles with points that the processor computes: what drawing them costs by itself.
    ///
    /// # Errors
    /// The surface has other tiles, there are 2³² vertices or more, or the device has no memory.
    pub fn passed(
        &self,
        context: &Context,
        device: &Device,
        displaced: &Displaced<'_>,
        material: &Material,
    ) -> Result<DeviceMesh> {
        let count: u64 = self.draws.iter().map(TileDraw::vertices).sum();
        if u32::try_from(count).is_err() || displaced.field().tile_count() != self.reliefs.len() {
            return Err(Error::unsupported(format!("{count} vertices of these tiles cannot be passed through")));
        }
        let places = context.map(self.order.len(), |at| self.places(self.order[at]));
        let mut points = Points::default();
        displaced.evaluate(context, places.concat().as_slice(), &mut points)?;
        let vertex = |at: usize| MeshVertex {
            p: points.p[at],
            normal: points.normal[at],
            color: material.base_color,
            grid: [0.5; 3],
            tag: NO_TAG,
        };
        let vertices: Vec<MeshVertex> = (0..points.p.len()).map(vertex).collect();
        let (mut indices, mut first) = (Vec::new(), 0);
        for (tile, places) in self.order.iter().zip(&places) {
            indices.extend(grid(1 << self.rates.tile(*tile)).into_iter().map(|index| first + index));
            first += places.len() as u32;
        }
        DeviceMesh::indexed(device, &vertices, &indices)
    }

    /// The places of the vertices of a tile, row by row.
    fn places(&self, tile: u32) -> Vec<Place> {
        let cells = 1u32 << self.rates.tile(tile);
        let edges = self.rates.edges(tile);
        let place = |i: u32, j: u32| {
            let (edge, along) = match (i, j) {
                (i, 0) if i < cells => (0, i),
                (i, j) if i == cells && j < cells => (1, j),
                (i, j) if j == cells && i > 0 => (2, cells - i),
                (0, j) => (3, cells - j),
                _ => return Place::new(tile, i as f32 / cells as f32, j as f32 / cells as f32),
            };
            let segments = 1u32 << edges[usize::from(edge)];
            let nearest = (2 * along * segments + cells) / (2 * cells);
            Place::on_edge(tile, edge, nearest as f32 / segments as f32)
        };
        (0..=cells).flat_map(|j| (0..=cells).map(move |i| (i, j))).map(|(i, j)| place(i, j)).collect()
    }

    /// How tiles are divided.
    pub fn rates(&self) -> &TileRates {
        &self.rates
    }

    /// The draws: one for each power that tiles have.
    pub fn draws(&self) -> &[TileDraw] {
        &self.draws
    }

    /// Tiles in the order of the draws; holes are left out.
    pub fn order(&self) -> &[u32] {
        &self.order
    }

    /// Smallest and largest coordinates.
    pub(super) fn bounds(&self) -> (DVec3, DVec3) {
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for relief in self.order.iter().map(|tile| &self.reliefs[*tile as usize]) {
            low = low.min(DVec3::from(relief.low.map(f64::from)));
            high = high.max(DVec3::from(relief.high.map(f64::from)));
        }
        (low, high)
    }

    fn write(&self, device: &Device) -> Result<()> {
        let record = |tile: &u32| {
            let edges = self.rates.edges(*tile);
            let powers = (0..4)
                .fold(u32::from(self.rates.tile(*tile)), |bits, edge| bits | u32::from(edges[edge]) << (4 + 4 * edge));
            [*tile, powers | self.tags[*tile as usize] << 20]
        };
        self.drawn.write(device, 0, &self.order.iter().map(record).collect::<Vec<_>>())
    }
}

/// Triangles of a grid of `cells`² cells, counter-clockwise from the front: bands of columns, row by row.
fn grid(cells: u32) -> Vec<u32> {
    let side = cells + 1;
    let mut indices = Vec::with_capacity(6 * (cells * cells) as usize);
    for band in (0..cells).step_by(BAND as usize) {
        for row in 0..cells {
            for column in band..(band + BAND).min(cells) {
                let at = row * side + column;
                indices.extend([at, at + 1, at + side + 1, at, at + side + 1, at + side]);
            }
        }
    }
    indices
}

/// `tile` and all that touch it.
fn around(topology: &TileTopology, tile: u32) -> impl Iterator<Item = u32> {
    let rings = topology.rings(tile).iter();
    let corners = rings.flat_map(|ring| topology.ring(*ring)).map(|entry| entry.tile);
    let middles = (0..4).filter_map(move |edge| match topology.link(tile, edge) {
        relievo_surface::Link::Halves { first, second, .. } => Some([first.tile, second.tile]),
        _ => None,
    });
    // A sub-tile's ring in the middle of a quad's edge has the quad.
    corners.chain(middles.flatten()).chain([tile])
}

/// Where places on the edges of `tile` are evaluated.
fn joints_of(field: &Field, tile: u32) -> [[u32; 2]; JOINTS] {
    if field.topology().is_hole(tile) {
        return [[0; 2]; JOINTS];
    }
    // Along a half of an edge the canonical place is linear, with whole numbers of quarters.
    let joint = |start: Place, step: [f32; 2]| {
        let numbers = [start.u, start.v, step[0], step[1]].map(|number| (4.0 * number) as i32 + 128);
        [start.tile, numbers.iter().rev().fold(0, |word, number| word << 8 | *number as u32 & 0xff)]
    };
    let canonical = |edge: u8, t: f32| field.canonical(Place::on_edge(tile, edge, t));
    std::array::from_fn(|number| {
        let edge = (number % 8 / 2) as u8;
        let second = number % 2 == 1;
        if number >= 8 {
            return joint(canonical(edge, if second { 0.5 } else { 0.0 }), [0.0; 2]);
        }
        let t = if second { 0.625 } else { 0.125 };
        let (a, b) = (canonical(edge, t), canonical(edge, t + 0.25));
        let step = [4.0 * (b.u - a.u), 4.0 * (b.v - a.v)];
        joint(Place::new(a.tile, a.u - step[0] * t, a.v - step[1] * t), step)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn grids_have_every_cell_once_and_few_vertices_at_a_time() {
        for cells in [2, 4, 32] {
            let indices = grid(cells);
            let draw = TileDraw { power: cells.trailing_zeros() as u8, first: 0, count: 1 };
            assert_eq!(indices.len() as u64, 3 * draw.triangles());
            assert_eq!(u64::from(*indices.iter().max().unwrap()) + 1, draw.vertices());
            let mut seen = vec![0; (cells * cells) as usize];
            for [a, b, c] in indices.as_chunks::<3>().0 {
                let at = |index: u32| [(index % (cells + 1)) as i32, (index / (cells + 1)) as i32];
                let ([ax, ay], [bx, by], [cx, cy]) = (at(*a), at(*b), at(*c));
                assert_eq!((bx - ax) * (cy - ay) - (by - ay) * (cx - ax), 1);
                seen[(ay.min(by) as u32 * cells + ax.min(cx) as u32) as usize] += 1;
            }
            assert!(seen.iter().all(|count| *count == 2));
        }
        // A cache of the 32 vertices that were used last misses about once a vertex.
        let (mut cache, mut misses) = (std::collections::VecDeque::new(), 0);
        for index in grid(64) {
            if !cache.contains(&index) {
                misses += 1;
                cache.push_back(index);
                if cache.len() > 32 {
                    cache.pop_front();
                }
            }
        }
        assert!(misses < 65 * 65 * 6 / 5, "{misses}");
    }
}
