//! The vertices of a tessellation: how many each tile, segment and ring has, and how they are numbered.
//!
//! First come the rings, then the insides of segments, then the insides of tiles. A segment belongs to all tiles along
//! it and is divided at the highest of their rates; a tile stitches its inner lattice to whatever its edges have.
//! Along infinitely sharp edges every side has vertices of its own, at the same positions but with its own normals, and
//! so have the sectors between such edges at a vertex.

use std::ops::Range;
use std::sync::Arc;

use relievo_core::mesh::INFINITE_SHARPNESS;
use relievo_core::{Error, Mesh, Result};
use relievo_surface::{Incidence, Link, Place, Side, TileTopology};

/// Most cells a side of a tile.
pub const MAX_RATE: u32 = 512;

/// Where a vertex on the outline of tiles is evaluated.
#[derive(Clone, Copy)]
pub(crate) struct Source {
    pub place: Place,
    /// Whether the normal is that of the place's own tile rather than the canonical one.
    pub split: bool,
}

/// Where the vertices of the mesh are numbered. Holes have none.
pub(crate) struct Numbering {
    pub topology: Arc<TileTopology>,
    pub rates: Vec<u32>,
    /// The vertices of rings and segments, which come before all others.
    pub outline: Vec<Source>,
    /// The first triangle of each tile, and at the end their number.
    pub triangles: Vec<u32>,
    /// The first of each tile's own vertices, counted tile by tile, and at the end their number.
    pub locals: Vec<u32>,
    pub vertices: u32,
    /// Cells along the segment that each side owns, 0 if it owns none, at `4 · tile + edge`.
    cells: Vec<u32>,
    /// The first vertex inside each segment of each side.
    segments: Vec<[u32; 2]>,
    /// The vertex at each corner of each tile.
    corners: Vec<[u32; 4]>,
    /// The vertex in the middle of each side that has two segments.
    middles: Vec<u32>,
    /// The first vertex inside each tile.
    interiors: Vec<u32>,
}

fn key(side: Side) -> usize {
    4 * side.tile as usize + usize::from(side.edge)
}

fn too_large() -> Error {
    Error::memory("the tessellation has more than 2^32 corners").advise("use lower rates")
}

const NONE: u32 = u32::MAX;

impl Numbering {
    /// Fails if the cage has other faces, there is not one rate per tile, a rate cannot be used, or the mesh would have
    /// 2³² corners or more.
    pub fn new(topology: Arc<TileTopology>, cage: &Mesh, rates: Vec<u32>) -> Result<Self> {
        check_rates(&topology, &rates)?;
        check_cage(&topology, cage)?;
        let tiles = topology.tile_count();
        let mut numbering = Self {
            topology,
            rates,
            outline: Vec::new(),
            triangles: Vec::with_capacity(tiles + 1),
            locals: Vec::with_capacity(tiles + 1),
            vertices: 0,
            cells: vec![0; 4 * tiles],
            segments: vec![[NONE; 2]; 4 * tiles],
            corners: vec![[NONE; 4]; tiles],
            middles: vec![NONE; 4 * tiles],
            interiors: vec![0; tiles],
        };
        let sharp = sharp_segments(&numbering.topology, cage);
        numbering.count_cells();
        numbering.number_rings(&sharp);
        numbering.number_segments(&sharp)?;
        numbering.number_interiors()?;
        Ok(numbering)
    }

    /// The tiles that are no holes.
    pub fn live(&self) -> impl Iterator<Item = u32> + use<> {
        let topology = self.topology.clone();
        (0..topology.tile_count() as u32).filter(move |tile| !topology.is_hole(*tile))
    }

    fn sides(&self) -> impl Iterator<Item = Side> + use<> {
        self.live().flat_map(|tile| (0..4).map(move |edge| Side { tile, edge }))
    }

    fn count_cells(&mut self) {
        for side in self.sides() {
            let segments = self.topology.segments(side);
            let count = segments.iter().flatten().count() as u32;
            for segment in segments.iter().flatten() {
                let cells = &mut self.cells[key(segment.owner)];
                *cells = (*cells).max((self.rates[side.tile as usize] / count).max(1));
            }
        }
    }

    fn number_rings(&mut self, sharp: &[bool]) {
        let topology = self.topology.clone();
        for tile in self.live() {
            for corner in 0..4 {
                if self.corners[tile as usize][corner] != NONE {
                    continue;
                }
                let entries = topology.ring(topology.rings(tile)[corner]);
                let sectors = sectors(&topology, entries, sharp);
                let split = sectors.iter().any(|sector| *sector != 0);
                let mut vertices = vec![NONE; entries.len()];
                for (entry, sector) in entries.iter().zip(sectors) {
                    if vertices[sector] == NONE {
                        vertices[sector] = self.outline.len() as u32;
                        self.outline.push(Source { place: entry.place(), split });
                    }
                    if entry.middle {
                        self.middles[key(Side { tile: entry.tile, edge: entry.corner })] = vertices[sector];
                    } else {
                        self.corners[entry.tile as usize][usize::from(entry.corner)] = vertices[sector];
                    }
                }
            }
        }
    }

    fn number_segments(&mut self, sharp: &[bool]) -> Result<()> {
        let mut owned = vec![NONE; self.cells.len()];
        for side in self.sides() {
            let segments = self.topology.segments(side);
            let count = segments.iter().flatten().count() as f32;
            for (index, segment) in segments.iter().flatten().enumerate() {
                let owner = key(segment.owner);
                let (cells, split) = (self.cells[owner], sharp.get(owner).copied().unwrap_or(false));
                let first = if split || owned[owner] == NONE {
                    let first = self.outline.len() as u32;
                    u32::try_from(self.outline.len() + cells as usize).map_err(|_| too_large())?;
                    // Vertices run in the owner's direction.
                    self.outline.extend((1..cells).map(|k| {
                        let place = if split {
                            let k = if segment.flipped { cells - k } else { k };
                            Place::on_edge(side.tile, side.edge, (index as f32 + k as f32 / cells as f32) / count)
                        } else {
                            Place::on_edge(segment.owner.tile, segment.owner.edge, k as f32 / cells as f32)
                        };
                        Source { place, split }
                    }));
                    owned[owner] = first;
                    first
                } else {
                    owned[owner]
                };
                self.segments[key(side)][index] = first;
            }
        }
        Ok(())
    }

    fn number_interiors(&mut self) -> Result<()> {
        let (mut vertices, mut triangles, mut locals) = (self.outline.len() as u64, 0u64, 0u64);
        for tile in 0..self.rates.len() as u32 {
            self.triangles.push(triangles as u32);
            self.locals.push(locals as u32);
            if !self.topology.is_hole(tile) {
                let (outer, inner) = (u64::from(self.outer(tile)), u64::from(self.inner(tile)));
                self.interiors[tile as usize] = vertices as u32;
                vertices += inner;
                locals += outer + inner;
                let row = u64::from(self.rates[tile as usize]).saturating_sub(2);
                triangles += if inner == 0 { 2 } else { outer + 4 * row + 2 * row * row };
                if [3 * triangles, locals, vertices].iter().any(|count| *count >= u64::from(u32::MAX)) {
                    return Err(too_large());
                }
            }
        }
        self.triangles.push(triangles as u32);
        self.locals.push(locals as u32);
        self.vertices = vertices as u32;
        Ok(())
    }

    /// The vertices along an edge of a tile but for its last, and where they are in the tile.
    pub fn along(&self, tile: u32, edge: u8, mut each: impl FnMut(u32, Place)) {
        let side = Side { tile, edge };
        let segments = self.topology.segments(side);
        let count = segments.iter().flatten().count() as f32;
        for (index, segment) in segments.iter().flatten().enumerate() {
            let cells = self.cells[key(segment.owner)];
            let first = self.segments[key(side)][index];
            for k in 0..cells {
                let vertex = match k {
                    0 if index == 0 => self.corners[tile as usize][usize::from(edge)],
                    0 => self.middles[key(side)],
                    k if segment.flipped => first + cells - 1 - k,
                    k => first + k - 1,
                };
                let t = (index as f32 + k as f32 / cells as f32) / count;
                each(vertex, Place::on_edge(tile, edge, t));
            }
        }
    }

    /// The vertices inside a tile, and where they are in it.
    pub fn within(&self, tile: u32, mut each: impl FnMut(u32, Place)) {
        let range = self.inside(tile);
        match self.rates[tile as usize] {
            1 => range.for_each(|vertex| each(vertex, Place::new(tile, 0.5, 0.5))),
            rate => {
                let at = |i: u32| i as f32 / rate as f32;
                let places = (1..rate).flat_map(|j| (1..rate).map(move |i| Place::new(tile, at(i), at(j))));
                range.zip(places).for_each(|(vertex, place)| each(vertex, place));
            }
        }
    }

    /// The vertices inside a tile, row by row.
    pub fn inside(&self, tile: u32) -> Range<u32> {
        let first = self.interiors[tile as usize];
        first..first + self.inner(tile)
    }

    /// Vertices around a tile.
    pub fn outer(&self, tile: u32) -> u32 {
        let segments = (0..4).flat_map(|edge| self.topology.segments(Side { tile, edge }));
        segments.flatten().map(|segment| self.cells[key(segment.owner)]).sum()
    }

    /// Vertices inside a tile: its lattice, or its centre if only its edges are divided.
    pub fn inner(&self, tile: u32) -> u32 {
        match self.rates[tile as usize] {
            1 => u32::from(self.outer(tile) > 4),
            rate => (rate - 1) * (rate - 1),
        }
    }
}

/// Fails unless there is one rate per tile, each a power of two up to [`MAX_RATE`].
fn check_rates(topology: &TileTopology, rates: &[u32]) -> Result<()> {
    if rates.len() != topology.tile_count() {
        return Err(Error::invalid(format!("there are {} rates for {} tiles", rates.len(), topology.tile_count())));
    }
    if let Some(tile) = rates.iter().position(|rate| !rate.is_power_of_two() || *rate > MAX_RATE) {
        return Err(Error::invalid(format!("a tile cannot have {} cells a side", rates[tile]))
            .at(format!("tile {tile}"))
            .advise(format!("use a power of two up to {MAX_RATE}")));
    }
    Ok(())
}

/// Fails unless the cage has the faces of the topology.
pub(crate) fn check_cage(topology: &TileTopology, cage: &Mesh) -> Result<()> {
    cage.check()?;
    let expected = |size: &u32| if *size == 4 { 1 } else { *size };
    let agree = cage.face_count() == topology.face_count()
        && (0..).zip(&cage.face_sizes).all(|(face, size)| topology.tiles_of(face).len() as u32 == expected(size));
    if agree { Ok(()) } else { Err(Error::invalid("the cage has other faces than the surface")) }
}

/// Which segments are infinitely sharp, at `4 · tile + edge` of their owners; empty if none is.
fn sharp_segments(topology: &TileTopology, cage: &Mesh) -> Vec<bool> {
    let creases = cage.creases.iter().filter(|crease| crease.sharpness >= INFINITE_SHARPNESS);
    let mut creases: Vec<_> = creases
        .map(|crease| (crease.points[0].min(crease.points[1]), crease.points[0].max(crease.points[1])))
        .collect();
    creases.sort_unstable();
    if creases.is_empty() && topology.pinned_side_count() == 0 {
        return Vec::new();
    }
    let mut sharp = vec![false; 4 * topology.tile_count()];
    let mut mark = |side: Side| {
        for segment in topology.segments(side).iter().flatten() {
            sharp[key(segment.owner)] = true;
        }
    };
    for (face, points) in (0..).zip(cage.faces()) {
        let tiles = topology.tiles_of(face);
        for corner in 0..points.len() {
            let next = (corner + 1) % points.len();
            let edge = (points[corner].min(points[next]), points[corner].max(points[next]));
            let side = if tiles.len() == 1 {
                Side { tile: tiles.start, edge: corner as u8 }
            } else {
                Side { tile: tiles.start + corner as u32, edge: 0 }
            };
            // Non-manifold edges are sharp as well.
            let pinned = matches!(topology.link(side.tile, side.edge), Link::Pinned { .. });
            if pinned || creases.binary_search(&edge).is_ok() {
                mark(side);
                if tiles.len() > 1 {
                    mark(Side { tile: tiles.start + next as u32, edge: 3 });
                }
            }
        }
    }
    sharp
}

/// The sector of each tile around a vertex, named after the first tile in it: tiles that share an edge that is not
/// sharp are in one sector.
fn sectors(topology: &TileTopology, entries: &[Incidence], sharp: &[bool]) -> Vec<usize> {
    if sharp.is_empty() {
        return vec![0; entries.len()];
    }
    let mut shared = Vec::with_capacity(2 * entries.len());
    for (index, entry) in entries.iter().enumerate() {
        let segments = |edge: u8| topology.segments(Side { tile: entry.tile, edge });
        let (after, before) = if entry.middle {
            let [first, second] = segments(entry.corner);
            (second, first)
        } else {
            let [first, second] = segments((entry.corner + 3) & 3);
            (segments(entry.corner)[0], second.or(first))
        };
        let owners = [after, before].into_iter().flatten().map(|segment| key(segment.owner));
        shared.extend(owners.filter(|owner| !sharp[*owner]).map(|owner| (owner, index)));
    }
    shared.sort_unstable();
    let mut sectors: Vec<usize> = (0..entries.len()).collect();
    fn root(sectors: &[usize], mut at: usize) -> usize {
        while sectors[at] != at {
            at = sectors[at];
        }
        at
    }
    for pair in shared.windows(2).filter(|pair| pair[0].0 == pair[1].0) {
        let (a, b) = (root(&sectors, pair[0].1), root(&sectors, pair[1].1));
        sectors[a.max(b)] = a.min(b);
    }
    (0..entries.len()).map(|index| root(&sectors, index)).collect()
}

/// The vertices of one tile: around it, then inside.
#[derive(Default)]
pub(crate) struct Local {
    /// Vertices of the mesh.
    pub vertices: Vec<u32>,
    /// Their parameters.
    pub parameters: Vec<[f32; 2]>,
    /// Where each edge begins, and at the end the number of vertices around the tile.
    pub edges: [usize; 5],
}

impl Local {
    pub fn new(numbering: &Numbering, tile: u32) -> Self {
        let mut local = Self::default();
        for edge in 0..4u8 {
            local.edges[usize::from(edge)] = local.vertices.len();
            numbering.along(tile, edge, |vertex, place| {
                local.vertices.push(vertex);
                local.parameters.push([place.u, place.v]);
            });
        }
        local.edges[4] = local.vertices.len();
        numbering.within(tile, |vertex, place| {
            local.vertices.push(vertex);
            local.parameters.push([place.u, place.v]);
        });
        local
    }

    /// Triangles between the vertices of the tile.
    pub fn triangles(&self, rate: u32) -> Vec<[u32; 3]> {
        let around = self.edges[4];
        if self.vertices.len() == around {
            return vec![[0, 1, 2], [0, 2, 3]];
        }
        let row = (rate as usize).saturating_sub(1).max(1);
        let inner = |i: usize, j: usize| (around + j * row + i) as u32;
        let mut triangles = Vec::with_capacity(around + 4 * (row - 1) + 2 * (row - 1) * (row - 1));
        for j in 0..row - 1 {
            for i in 0..row - 1 {
                let [a, b, c, d] = [inner(i, j), inner(i + 1, j), inner(i + 1, j + 1), inner(i, j + 1)];
                triangles.extend([[a, b, c], [a, c, d]]);
            }
        }
        for edge in 0..4 {
            let (start, end) = (self.edges[edge], self.edges[edge + 1]);
            let cells = end - start;
            let outer = |k: usize| if start + k == around { 0 } else { (start + k) as u32 };
            let last = row - 1;
            let inner = |k: usize| match edge {
                0 => inner(k, 0),
                1 => inner(last, k),
                2 => inner(last - k, last),
                _ => inner(0, last - k),
            };
            // Advance on the side whose next segment has its middle first. Outer samples are even on each half.
            let along = |k: usize| {
                let [u, v] = self.parameters[outer(k) as usize];
                let t = match edge {
                    0 => u,
                    1 => v,
                    2 => 1.0 - u,
                    _ => 1.0 - v,
                };
                if k == cells { 1.0 } else { t }
            };
            let (mut a, mut b) = (0, 0);
            while a < cells || b < last {
                let outer_next = b == last || {
                    let middle = |k: usize| (k as f32 + 1.5) / rate as f32;
                    a < cells && 0.5 * (along(a) + along(a + 1)) <= middle(b)
                };
                if outer_next {
                    triangles.push([outer(a), outer(a + 1), inner(b)]);
                    a += 1;
                } else {
                    triangles.push([outer(a), inner(b + 1), inner(b)]);
                    b += 1;
                }
            }
        }
        triangles
    }
}
