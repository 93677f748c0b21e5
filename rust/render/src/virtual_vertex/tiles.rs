//! A displaced Catmull-Clark surface drawn from virtual vertices: which tiles a draw has, how they and their edges are
//! divided, and where places on edges are evaluated (`shaders/draw/tiles_draw.wgsl`).
//!
//! The vertices of a grid have no data: the vertex stage finds the cell from their number. An index buffer goes through
//! the grid in bands of few columns, so that devices evaluate a vertex about once and not at each of its six triangles.
//! A tile whose edges are divided otherwise than its inside is drawn as its inner cells and four strips beside them.
//! Places on edges and at vertices are evaluated at the canonical place that the processor has too
//! ([`Displaced::canonical`]), in the one tile that it names, so that all tiles there get the same bits.

use std::collections::BTreeMap;
use std::sync::Arc;

use glam::DVec3;
use relievo_core::{Context, Error, Result};
use relievo_gpu::{Buffer, Device};
use relievo_surface::bezier::Viewpoint;
use relievo_surface::{Place, TileTopology};
use relievo_tiles::{Displaced, Points};

use super::indices::{VERTEX, VERTEX_BITS};
use super::placed::{DeviceMesh, MeshVertex, NO_TAG};
use super::rates::{Relief, TileRates, select};
use crate::scene::Material;

/// Columns of cells of a band.
const BAND: u32 = 8;
/// Places of a tile that are evaluated elsewhere: halves of edges, then corners and middles of edges.
const JOINTS: usize = 16;
/// Tags that false colours tell apart at most.
pub(super) const TAGS: u32 = 1 << 12;

/// What is drawn of tiles.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum TilePart {
    /// All cells of the grid.
    Whole,
    /// Cells that touch no edge.
    Inside,
    /// A strip between the cells inside and an edge of 2^power segments.
    Strip(u8),
}

/// A draw of parts of one kind of tiles of one power.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TileDraw {
    /// Grids have 2^power cells a side.
    pub power: u8,
    /// What is drawn of them.
    pub part: TilePart,
    /// The first of its parts, in the order of the draws.
    pub first: u32,
    /// How many parts.
    pub count: u32,
}

impl TileDraw {
    /// Triangles of the draw: two for every cell of grids, one for every segment of both sides of strips.
    pub fn triangles(&self) -> u64 {
        let cells = 1u64 << self.power;
        let part = match self.part {
            TilePart::Whole => 2 * cells * cells,
            TilePart::Inside => 2 * (cells - 2) * (cells - 2),
            TilePart::Strip(edge) => (1 << edge) + cells - 2,
        };
        u64::from(self.count) * part
    }

    /// Vertices of the draw, those of a part counted once.
    pub fn vertices(&self) -> u64 {
        u64::from(self.count) * u64::from(self.part.vertices(self.power))
    }
}

impl TilePart {
    /// Vertices of a part of a tile of 2^power cells a side.
    fn vertices(self, power: u8) -> u32 {
        let cells = 1u32 << power;
        match self {
            Self::Whole => (cells + 1) * (cells + 1),
            Self::Inside => (cells - 1) * (cells - 1),
            Self::Strip(edge) => (1 << edge) + cells,
        }
    }

    /// Its triangles, counter-clockwise.
    fn triangles(self, power: u8) -> Vec<u32> {
        let cells = 1u32 << power;
        match self {
            Self::Whole => grid(cells, true),
            Self::Inside => grid(cells - 2, false),
            Self::Strip(edge) => strip(cells, 1 << edge),
        }
    }
}

/// A part of a tile that is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Drawn {
    power: u8,
    part: TilePart,
    tile: u32,
    /// The edge of a strip.
    edge: u8,
}

/// How a displaced surface is drawn.
#[derive(Debug)]
pub struct VirtualTiles {
    topology: Arc<TileTopology>,
    reliefs: Vec<Relief>,
    rates: TileRates,
    tags: Vec<u32>,
    draws: Vec<TileDraw>,
    parts: Vec<Drawn>,
    order: Vec<u32>,
    pub(super) joints: Buffer<[u32; 2]>,
    pub(super) drawn: Buffer<[u32; 2]>,
    pub(super) grids: BTreeMap<(u8, TilePart), Buffer<u32>>,
}

impl VirtualTiles {
    /// All tiles of a surface, divided into `cells` along an edge of the cage.
    ///
    /// # Errors
    /// `cells` is not a power of two from 2 to 256, or the device has no memory.
    pub fn new(context: &Context, device: &Device, displaced: &Displaced<'_>, cells: u32) -> Result<Self> {
        let topology = displaced.field().topology().clone();
        let count = topology.tile_count();
        let rates = TileRates::uniform(&topology, cells)?;
        let mut made = Self {
            reliefs: vec![Relief::default(); count],
            tags: vec![0; count],
            draws: Vec::new(),
            parts: Vec::new(),
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
    /// The surface has other tiles, or the device fails.
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
        let joints = context.map(beside.len(), |at| joints_of(displaced, beside[at]));
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
        self.parts.clear();
        for tile in &self.order {
            let (tile, power, edges) = (*tile, rates.tile(*tile), rates.edges(*tile));
            let mut add = |part: TilePart, edge: u8| self.parts.push(Drawn { power, part, tile, edge });
            if edges == [power; 4] {
                add(TilePart::Whole, 0);
                continue;
            }
            if power > 1 {
                add(TilePart::Inside, 0);
            }
            (0..).zip(edges).for_each(|(edge, segments)| add(TilePart::Strip(segments), edge));
        }
        self.parts.sort_by_key(|drawn| (drawn.power, drawn.part));
        self.draws.clear();
        let mut first = 0;
        for run in self.parts.chunk_by(|a, b| (a.power, a.part) == (b.power, b.part)) {
            let (Drawn { power, part, .. }, count) = (run[0], run.len() as u32);
            self.draws.push(TileDraw { power, part, first, count });
            first += count;
            if let std::collections::btree_map::Entry::Vacant(entry) = self.grids.entry((power, part)) {
                let indices = part.triangles(power);
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
        if tags == self.tags {
            return Ok(());
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
        let (places, triangles) = self.triangles(context);
        let mut points = Points::default();
        displaced.evaluate(context, &places, &mut points)?;
        let vertex = |at: usize| MeshVertex {
            p: points.p[at],
            normal: points.normal[at],
            color: material.base_color,
            grid: [0.5; 3],
            tag: NO_TAG,
        };
        let vertices: Vec<MeshVertex> = (0..points.p.len()).map(vertex).collect();
        DeviceMesh::indexed(device, &vertices, triangles.as_flattened())
    }

    /// The places of all vertices, part by part, and the triangles, counter-clockwise, of their numbers.
    pub fn triangles(&self, context: &Context) -> (Vec<Place>, Vec<[u32; 3]>) {
        let places = context.map(self.parts.len(), |at| self.places(self.parts[at]));
        let (mut triangles, mut first) = (Vec::new(), 0);
        for (drawn, places) in self.parts.iter().zip(&places) {
            let indices = drawn.part.triangles(drawn.power);
            let number = |index: u32| first + (index & VERTEX);
            triangles.extend(indices.as_chunks::<3>().0.iter().map(|corners| corners.map(number)));
            first += places.len() as u32;
        }
        (places.concat(), triangles)
    }

    /// The places of the vertices of a part.
    fn places(&self, Drawn { power, part, tile, edge }: Drawn) -> Vec<Place> {
        let cells = 1u32 << power;
        let unit = 1.0 / cells as f32;
        let (low, high) = match part {
            TilePart::Whole => (0, cells),
            TilePart::Inside => (1, cells - 1),
            TilePart::Strip(power) => {
                let along = (0..=1u32 << power).map(|k| k as f32 / (1u32 << power) as f32);
                let border = along.map(|t| Place::on_edge(tile, edge, t));
                let inner = (1..cells).map(|k| {
                    let (t, back) = (k as f32 * unit, (cells - k) as f32 * unit);
                    let (u, v) = [(t, unit), (1.0 - unit, t), (back, 1.0 - unit), (unit, back)][usize::from(edge)];
                    Place::new(tile, u, v)
                });
                return border.chain(inner).collect();
            }
        };
        let place = |i: u32, j: u32| Place::new(tile, i as f32 * unit, j as f32 * unit);
        (low..=high).flat_map(|j| (low..=high).map(move |i| place(i, j))).collect()
    }

    /// How tiles are divided.
    pub fn rates(&self) -> &TileRates {
        &self.rates
    }

    /// The draws: one for each part of each power.
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

    fn write(&mut self, device: &Device) -> Result<()> {
        let record = |drawn: &Drawn| {
            let (kind, edge) = match drawn.part {
                TilePart::Whole => (0, 0),
                TilePart::Inside => (1, 0),
                TilePart::Strip(segments) => (2 + u32::from(drawn.edge), u32::from(segments)),
            };
            [drawn.tile, u32::from(drawn.power) | edge << 4 | kind << 8 | self.tags[drawn.tile as usize] << 20]
        };
        let records: Vec<[u32; 2]> = self.parts.iter().map(record).collect();
        if self.drawn.len() < records.len() {
            self.drawn = Buffer::new(device, "drawn tiles", records.len() + records.len() / 2)?;
        }
        self.drawn.write(device, 0, &records)
    }
}

/// Triangles of a grid of `cells`² cells, counter-clockwise from the front: bands of columns, row by row. `whole` grids
/// are divided beside their edges as [`strip`] does, and with that as tessellations are.
fn grid(cells: u32, whole: bool) -> Vec<u32> {
    let side = cells + 1;
    let mut indices = Vec::with_capacity(6 * (cells * cells) as usize);
    for band in (0..cells).step_by(BAND as usize) {
        for row in 0..cells {
            for column in band..(band + BAND).min(cells) {
                let at = row * side + column;
                let [a, b, c, d] = [at, at + 1, at + side + 1, at + side];
                let bent = row == 0 && column > 0 || row + 1 == cells && column + 1 < cells;
                indices.extend(if whole && bent { [a, b, d, b, c, d] } else { [a, b, c, a, c, d] });
            }
        }
    }
    indices
}

/// Triangles between an edge of `segments` segments and the inner points of a grid beside it, of which there are
/// `cells` − 1, in the order of their parameters. Vertices are those of the edge, then the inner ones. Above their
/// number is which of the three corners they are of all triangles that they belong to, for the lines of a wireframe.
fn strip(cells: u32, segments: u32) -> Vec<u32> {
    let vertex = |number: u32, corner: u32| number | corner << VERTEX_BITS;
    let mut indices = Vec::with_capacity(3 * (segments + cells - 2) as usize);
    let (mut k, mut i) = (0, 1);
    let (mut outer, mut inner) = (vertex(0, 0), vertex(segments + i, 1));
    while k < segments || i + 1 < cells {
        let other = 3 - (outer >> VERTEX_BITS) - (inner >> VERTEX_BITS);
        // Middles of the next segments, times 2 · both numbers.
        if k < segments && (i + 1 == cells || (2 * k + 1) * cells <= (2 * i + 1) * segments) {
            k += 1;
            let next = vertex(k, other);
            indices.extend([outer, next, inner]);
            outer = next;
        } else {
            i += 1;
            let next = vertex(segments + i, other);
            indices.extend([inner, outer, next]);
            inner = next;
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
fn joints_of(displaced: &Displaced<'_>, tile: u32) -> [[u32; 2]; JOINTS] {
    if displaced.field().topology().is_hole(tile) {
        return [[0; 2]; JOINTS];
    }
    // Along a half of an edge the canonical place is linear, with whole numbers of quarters.
    let joint = |start: Place, step: [f32; 2]| {
        let numbers = [start.u, start.v, step[0], step[1]].map(|number| (4.0 * number) as i32 + 128);
        [start.tile, numbers.iter().rev().fold(0, |word, number| word << 8 | *number as u32 & 0xff)]
    };
    let canonical = |edge: u8, t: f32| displaced.canonical(Place::on_edge(tile, edge, t));
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
    fn strips_have_every_segment_of_both_sides_once() {
        for (power, edge) in [(1, 0), (1, 1), (1, 4), (2, 0), (3, 3), (4, 1), (3, 6)] {
            let (cells, segments) = (1u32 << power, 1u32 << edge);
            let part = TilePart::Strip(edge);
            let draw = TileDraw { power, part, first: 0, count: 1 };
            let indices = part.triangles(power);
            assert_eq!(indices.len() as u64, 3 * draw.triangles());
            // In units of 1 / (cells · segments), of an edge from the left to the right.
            let at = |index: &u32| match index & VERTEX {
                number if number <= segments => [(number * cells) as i32, 0],
                number => [((number - segments) * segments) as i32, segments as i32],
            };
            let mut area = 0;
            let mut seen = std::collections::BTreeSet::<u32>::new();
            for triangle in indices.as_chunks::<3>().0 {
                let [[ax, ay], [bx, by], [cx, cy]] = triangle.each_ref().map(at);
                let twice = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax);
                assert!(twice > 0);
                area += twice;
                let mut corners = triangle.map(|index| index >> VERTEX_BITS);
                corners.sort_unstable();
                assert_eq!(corners, [0, 1, 2]);
                seen.extend(triangle);
            }
            // A vertex is the same corner of all its triangles.
            assert_eq!(seen.len() as u64, draw.vertices());
            assert_eq!(area, (segments * (cells * segments + (cells - 2) * segments)) as i32);
        }
    }

    #[test]
    fn grids_have_every_cell_once_and_few_vertices_at_a_time() {
        for cells in [2, 4, 32] {
            let indices = grid(cells, true);
            let power = cells.trailing_zeros() as u8;
            let draw = TileDraw { power, part: TilePart::Whole, first: 0, count: 1 };
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
        for index in grid(64, true) {
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
