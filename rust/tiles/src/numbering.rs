//! The vertices of a tessellation: how many each tile, segment and ring has, and how they are numbered.
//!
//! First come the rings, then the insides of segments, then the insides of tiles. A segment belongs to all tiles along
//! it and is divided at the highest of their rates; a tile stitches its inner lattice to whatever its edges have.

use std::sync::Arc;

use relievo_core::{Error, Result};
use relievo_surface::{Place, Side, TileTopology};

/// Most cells a side of a tile.
pub const MAX_RATE: u32 = 512;

/// Where the vertices of the mesh are numbered. Holes have none.
pub(crate) struct Numbering {
    pub topology: Arc<TileTopology>,
    pub rates: Vec<u32>,
    /// Cells along the segment that each side owns, 0 if it owns none, at `4 · tile + edge`.
    pub cells: Vec<u32>,
    /// The first vertex inside that segment.
    pub segments: Vec<u32>,
    /// The vertex of each ring.
    pub rings: Vec<u32>,
    /// The first vertex inside each tile.
    pub interiors: Vec<u32>,
    /// The first triangle of each tile, and at the end their number.
    pub triangles: Vec<u32>,
    /// The first of each tile's own vertices, counted tile by tile, and at the end their number.
    pub locals: Vec<u32>,
    pub vertices: u32,
}

pub(crate) fn key(side: Side) -> usize {
    4 * side.tile as usize + usize::from(side.edge)
}

fn too_large() -> Error {
    Error::memory("the tessellation has more than 2^32 corners").advise("use lower rates")
}

impl Numbering {
    /// Fails if there is not one rate per tile, a rate cannot be used, or the mesh would have 2³² corners or more.
    pub fn new(topology: Arc<TileTopology>, rates: Vec<u32>) -> Result<Self> {
        check_rates(&topology, &rates)?;
        let tiles = topology.tile_count();
        let shared = topology.clone();
        let topology = &*shared;
        let live = || (0..tiles as u32).filter(|tile| !topology.is_hole(*tile));
        let mut numbering = Self {
            topology: shared.clone(),
            rates,
            cells: vec![0; 4 * tiles],
            segments: vec![0; 4 * tiles],
            rings: vec![u32::MAX; topology.ring_count()],
            interiors: vec![0; tiles],
            triangles: Vec::with_capacity(tiles + 1),
            locals: Vec::with_capacity(tiles + 1),
            vertices: 0,
        };
        let sides = |tile: u32| (0..4).map(move |edge| Side { tile, edge });
        for side in live().flat_map(sides) {
            let segments = topology.segments(side);
            let count = segments.iter().flatten().count() as u32;
            for segment in segments.iter().flatten() {
                let cells = &mut numbering.cells[key(segment.owner)];
                *cells = (*cells).max((numbering.rates[side.tile as usize] / count).max(1));
            }
        }
        let mut vertices = 0u64;
        let mut take = |count: u64| -> Result<u32> {
            let first = vertices;
            vertices += count;
            u32::try_from(vertices).map(|_| first as u32).map_err(|_| too_large())
        };
        for ring in live().flat_map(|tile| *topology.rings(tile)) {
            if numbering.rings[ring as usize] == u32::MAX {
                numbering.rings[ring as usize] = take(1)?;
            }
        }
        for side in live().flat_map(sides) {
            if numbering.cells[key(side)] > 0 {
                numbering.segments[key(side)] = take(u64::from(numbering.cells[key(side)]) - 1)?;
            }
        }
        let (mut triangles, mut locals) = (0u64, 0u64);
        for tile in 0..tiles as u32 {
            numbering.triangles.push(triangles as u32);
            numbering.locals.push(locals as u32);
            if !topology.is_hole(tile) {
                let (outer, inner) = (u64::from(numbering.outer(tile)), u64::from(numbering.inner(tile)));
                numbering.interiors[tile as usize] = take(inner)?;
                locals += outer + inner;
                let row = u64::from(numbering.rates[tile as usize]).saturating_sub(2);
                triangles += if inner == 0 { 2 } else { outer + 4 * row + 2 * row * row };
                if 3 * triangles > u64::from(u32::MAX) || locals > u64::from(u32::MAX) {
                    return Err(too_large());
                }
            }
        }
        numbering.triangles.push(triangles as u32);
        numbering.locals.push(locals as u32);
        numbering.vertices = take(0)?;
        Ok(numbering)
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
            let segments = numbering.topology.segments(Side { tile, edge });
            let count = segments.iter().flatten().count() as f32;
            for (index, segment) in segments.iter().flatten().enumerate() {
                let cells = numbering.cells[key(segment.owner)];
                let first = numbering.segments[key(segment.owner)];
                for k in 0..cells {
                    local.vertices.push(match k {
                        0 => numbering.rings[segment.ends[0] as usize],
                        k if segment.flipped => first + cells - 1 - k,
                        k => first + k - 1,
                    });
                    let t = (index as f32 + k as f32 / cells as f32) / count;
                    let place = Place::on_edge(tile, edge, t);
                    local.parameters.push([place.u, place.v]);
                }
            }
        }
        local.edges[4] = local.vertices.len();
        let (rate, first) = (numbering.rates[tile as usize], numbering.interiors[tile as usize]);
        local.vertices.extend(first..first + numbering.inner(tile));
        if rate == 1 {
            local.parameters.resize(local.vertices.len(), [0.5; 2]);
        } else {
            let at = |i: u32| i as f32 / rate as f32;
            local.parameters.extend((1..rate).flat_map(|j| (1..rate).map(move |i| [at(i), at(j)])));
        }
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
