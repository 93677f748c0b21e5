//! A displaced surface as a welded triangle mesh without cracks.
//!
//! Every tile has a rate, its number of cells a side. A segment between two tiles is sampled at the higher of both
//! rates, and both tiles use the same samples: inside, a tile is a lattice; the strip between the lattice and the
//! finer edge is stitched, as hardware tessellators do. Vertices on edges are evaluated at their canonical place.
//! Attributes are carried along: bilinear over the tile for corners and points, copied for faces.

use relievo_core::{Attribute, Context, Domain, Error, Mesh, Result, Values};
use relievo_surface::{Grid, Place, Placement, Side, TileTopology};

use crate::displaced::{Displaced, Points};

/// Most cells a side of a tile.
pub const MAX_RATE: u32 = 512;

/// A tessellated surface.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Tessellation {
    /// Triangles, with unit normals as the point attribute `normal` and the attributes of the cage.
    pub mesh: Mesh,
    /// The tile of every triangle, ascending.
    pub tiles: Vec<u32>,
    /// u and v in that tile of every corner.
    pub parameters: Vec<[f32; 2]>,
}

/// The rates of all tiles for `cells` cells along an edge of the cage: sub-tiles have half as many.
pub fn uniform_rates(topology: &TileTopology, cells: u32) -> Vec<u32> {
    (0..topology.tile_count() as u32)
        .map(|tile| if topology.is_sub(tile) { (cells / 2).max(1) } else { cells })
        .collect()
}

/// Where the vertices of the mesh are numbered.
struct Numbering<'a> {
    topology: &'a TileTopology,
    rates: &'a [u32],
    /// Cells along the segment that each side owns, 0 if it owns none, at `4 · tile + edge`.
    cells: Vec<u32>,
    /// The first vertex inside that segment.
    segments: Vec<u32>,
    /// The vertex of each ring.
    rings: Vec<u32>,
    /// The first vertex inside each tile.
    interiors: Vec<u32>,
    /// The first triangle of each tile, and at the end their number.
    triangles: Vec<u32>,
    /// The first of each tile's own vertices, counted tile by tile, and at the end their number.
    locals: Vec<u32>,
    vertices: u32,
}

fn key(side: Side) -> usize {
    4 * side.tile as usize + usize::from(side.edge)
}

fn too_large() -> Error {
    Error::memory("the tessellation has more than 2^32 corners").advise("use lower rates")
}

impl<'a> Numbering<'a> {
    fn new(topology: &'a TileTopology, rates: &'a [u32]) -> Result<Self> {
        let tiles = topology.tile_count();
        let live = || (0..tiles as u32).filter(|tile| !topology.is_hole(*tile));
        let mut numbering = Self {
            topology,
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
                *cells = (*cells).max((rates[side.tile as usize] / count).max(1));
            }
        }
        let mut vertices = 0u64;
        let mut take = |count: u64| {
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
                let row = u64::from(rates[tile as usize]).saturating_sub(2);
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
    fn outer(&self, tile: u32) -> u32 {
        let segments = (0..4).flat_map(|edge| self.topology.segments(Side { tile, edge }));
        segments.flatten().map(|segment| self.cells[key(segment.owner)]).sum()
    }

    /// Vertices inside a tile: its lattice, or its centre if only its edges are divided.
    fn inner(&self, tile: u32) -> u32 {
        match self.rates[tile as usize] {
            1 => u32::from(self.outer(tile) > 4),
            rate => (rate - 1) * (rate - 1),
        }
    }
}

/// The vertices of one tile: around it, then inside.
#[derive(Default)]
struct Local {
    /// Vertices of the mesh.
    vertices: Vec<u32>,
    /// Their parameters.
    parameters: Vec<[f32; 2]>,
    /// Where each edge begins, and at the end the number of vertices around the tile.
    edges: [usize; 5],
}

impl Local {
    fn new(numbering: &Numbering<'_>, tile: u32) -> Self {
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
    fn triangles(&self, rate: u32) -> Vec<[u32; 3]> {
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

impl Displaced<'_> {
    /// Triangles of the displaced surface, `rates[tile]` cells along the sides of each tile: a power of two up to
    /// [`MAX_RATE`]. Attributes come from `cage`. Holes are left out.
    ///
    /// Fails if there is not one rate per tile, a rate is no power of two, the cage has other faces, or the mesh would
    /// have 2³² corners or more.
    pub fn tessellate(&self, context: &Context, cage: &Mesh, rates: &[u32]) -> Result<Tessellation> {
        let topology = self.field().topology();
        cage.check()?;
        let sizes_agree = cage.face_count() == topology.face_count()
            && cage
                .face_sizes
                .iter()
                .zip(0..)
                .all(|(size, face)| topology.tiles_of(face).len() as u32 == if *size == 4 { 1 } else { *size });
        if !sizes_agree {
            return Err(Error::invalid("the cage has other faces than the surface"));
        }
        if rates.len() != topology.tile_count() {
            let message = format!("there are {} rates for {} tiles", rates.len(), topology.tile_count());
            return Err(Error::invalid(message));
        }
        if let Some(tile) = rates.iter().position(|rate| !rate.is_power_of_two() || *rate > MAX_RATE) {
            return Err(Error::invalid(format!("a tile cannot have {} cells a side", rates[tile]))
                .at(format!("tile {tile}"))
                .advise(format!("use a power of two up to {MAX_RATE}")));
        }
        let numbering = Numbering::new(topology, rates)?;
        let mut points = self.shared_points(context, &numbering)?;
        points.p.resize(numbering.vertices as usize, [0.0; 3]);
        points.normal.resize(numbering.vertices as usize, [0.0; 3]);
        let triangle_count = numbering.triangles.last().map_or(0, |count| *count as usize);
        let mut corners = vec![0u32; 3 * triangle_count];
        let mut locals = vec![0u32; 3 * triangle_count];
        let mut tiles = vec![0u32; triangle_count];
        let mut parameters = vec![[0.0; 2]; 3 * triangle_count];
        // Every tile writes its own part of each list.
        struct Part<'a> {
            tile: u32,
            p: &'a mut [[f32; 3]],
            normal: &'a mut [[f32; 3]],
            corners: &'a mut [u32],
            locals: &'a mut [u32],
            tiles: &'a mut [u32],
            parameters: &'a mut [[f32; 2]],
            result: Result<()>,
        }
        let shared = points.p.len()
            - (0..rates.len() as u32)
                .filter(|tile| !topology.is_hole(*tile))
                .map(|tile| numbering.inner(tile) as usize)
                .sum::<usize>();
        let mut parts = Vec::with_capacity(rates.len());
        let (mut p, mut normal) = (&mut points.p[shared..], &mut points.normal[shared..]);
        let (mut corner_rest, mut local_rest, mut tile_rest) = (&mut corners[..], &mut locals[..], &mut tiles[..]);
        let mut parameter_rest = &mut parameters[..];
        for tile in (0..rates.len() as u32).filter(|tile| !topology.is_hole(*tile)) {
            let inner = numbering.inner(tile) as usize;
            let count = (numbering.triangles[tile as usize + 1] - numbering.triangles[tile as usize]) as usize;
            parts.push(Part {
                tile,
                p: p.split_off_mut(..inner).unwrap_or_default(),
                normal: normal.split_off_mut(..inner).unwrap_or_default(),
                corners: corner_rest.split_off_mut(..3 * count).unwrap_or_default(),
                locals: local_rest.split_off_mut(..3 * count).unwrap_or_default(),
                tiles: tile_rest.split_off_mut(..count).unwrap_or_default(),
                parameters: parameter_rest.split_off_mut(..3 * count).unwrap_or_default(),
                result: Ok(()),
            });
        }
        context.for_each_mut(&mut parts, |_, part| {
            let (tile, rate) = (part.tile, rates[part.tile as usize]);
            let local = Local::new(&numbering, tile);
            let first = numbering.locals[tile as usize];
            part.tiles.fill(tile);
            for (slot, index) in local.triangles(rate).as_flattened().iter().enumerate() {
                part.corners[slot] = local.vertices[*index as usize];
                part.locals[slot] = first + index;
                part.parameters[slot] = local.parameters[*index as usize];
            }
            let mut inside = Points::default();
            part.result = if rate == 1 && !part.p.is_empty() {
                self.evaluate_canonical(context, &[Place::new(tile, 0.5, 0.5)], &mut inside)
            } else {
                let grid = Grid { size: rate, placement: Placement::Lattice, columns: 1..rate, rows: 1..rate };
                self.grid(context, tile, &grid, &mut inside)
            };
            if part.result.is_ok() && inside.p.len() == part.p.len() {
                part.p.copy_from_slice(&inside.p);
                part.normal.copy_from_slice(&inside.normal);
            }
        });
        parts.into_iter().try_for_each(|part| part.result)?;
        let mut mesh = Mesh::new(points.p, vec![3; triangle_count], corners);
        mesh.attributes.push(Attribute {
            name: "normal".into(),
            domain: Domain::Point,
            width: 3,
            values: Values::F32(points.normal.into_flattened()),
            indices: None,
        });
        let carried = Carried { context, numbering: &numbering, cage, offsets: cage.face_offsets() };
        for attribute in cage.attributes.iter().filter(|attribute| attribute.name != "normal") {
            mesh.attributes.push(carried.attribute(attribute, &tiles, &locals));
        }
        Ok(Tessellation { mesh, tiles, parameters })
    }

    /// The points of rings, then of segments.
    fn shared_points(&self, context: &Context, numbering: &Numbering<'_>) -> Result<Points> {
        let mut places = Vec::new();
        let topology = numbering.topology;
        let mut next = 0;
        for tile in 0..topology.tile_count() as u32 {
            for corner in 0..4 {
                let ring = topology.rings(tile)[usize::from(corner)];
                if numbering.rings[ring as usize] == next && !topology.is_hole(tile) {
                    next += 1;
                    places.push(self.field().canonical(Place::corner(tile, corner)));
                }
            }
        }
        for tile in 0..topology.tile_count() as u32 {
            for edge in 0..4 {
                let cells = numbering.cells[key(Side { tile, edge })];
                places.extend(
                    (1..cells).map(|k| self.field().canonical(Place::on_edge(tile, edge, k as f32 / cells as f32))),
                );
            }
        }
        let mut points = Points::default();
        self.evaluate_canonical(context, &places, &mut points)?;
        Ok(points)
    }
}

/// Attributes of a cage on their way to a tessellation.
struct Carried<'a> {
    context: &'a Context,
    numbering: &'a Numbering<'a>,
    cage: &'a Mesh,
    offsets: Vec<u32>,
}

impl Carried<'_> {
    fn attribute(&self, attribute: &Attribute, tiles: &[u32], locals: &[u32]) -> Attribute {
        let topology = self.numbering.topology;
        let width = attribute.width as usize;
        let (values, indices) = match attribute.domain {
            Domain::Face => {
                let face = |tile: &u32| topology.face(*tile) as usize * width;
                let values = match &attribute.values {
                    Values::F32(from) => {
                        Values::F32(tiles.iter().flat_map(|tile| &from[face(tile)..][..width]).copied().collect())
                    }
                    Values::U32(from) => {
                        Values::U32(tiles.iter().flat_map(|tile| &from[face(tile)..][..width]).copied().collect())
                    }
                };
                (values, None)
            }
            Domain::Corner => (self.local_values(attribute), Some(locals.to_vec())),
            Domain::Point => (self.point_values(attribute), None),
        };
        let Attribute { name, domain, width, .. } = attribute.clone();
        Attribute { name, domain, width, values, indices }
    }

    /// Values at every tile's own vertices.
    fn local_values(&self, attribute: &Attribute) -> Values {
        let tiles = self.numbering.rates.len();
        let lists = self.context.map(tiles, |tile| {
            let tile = tile as u32;
            if self.numbering.topology.is_hole(tile) {
                return (Vec::new(), Vec::new());
            }
            let parameters = Local::new(self.numbering, tile).parameters;
            self.interpolate(attribute, tile, &parameters)
        });
        match attribute.values {
            Values::F32(_) => Values::F32(lists.into_iter().flat_map(|list| list.0).collect()),
            Values::U32(_) => Values::U32(lists.into_iter().flat_map(|list| list.1).collect()),
        }
    }

    /// Values at every vertex of the mesh: a shared vertex has that of the first tile it belongs to.
    fn point_values(&self, attribute: &Attribute) -> Values {
        let width = attribute.width as usize;
        let count = self.numbering.vertices as usize;
        let mut values = (vec![0f32; count * width], vec![0u32; count * width]);
        let mut done = vec![false; count];
        for tile in (0..self.numbering.rates.len() as u32).filter(|tile| !self.numbering.topology.is_hole(*tile)) {
            let local = Local::new(self.numbering, tile);
            let (floats, integers) = self.interpolate(attribute, tile, &local.parameters);
            for (index, vertex) in local.vertices.iter().enumerate() {
                let (from, to) = (index * width, *vertex as usize * width);
                if std::mem::replace(&mut done[*vertex as usize], true) {
                    continue;
                }
                if floats.is_empty() {
                    values.1[to..to + width].copy_from_slice(&integers[from..from + width]);
                } else {
                    values.0[to..to + width].copy_from_slice(&floats[from..from + width]);
                }
            }
        }
        match attribute.values {
            Values::F32(_) => Values::F32(values.0),
            Values::U32(_) => Values::U32(values.1),
        }
    }

    /// Values at `parameters` of a tile, as floats or as integers. Integers, and the weights that belong to joints,
    /// are those of the nearest corner of the face.
    fn interpolate(&self, attribute: &Attribute, tile: u32, parameters: &[[f32; 2]]) -> (Vec<f32>, Vec<u32>) {
        let topology = self.numbering.topology;
        let width = attribute.width as usize;
        let face = topology.face(tile) as usize;
        let (first, size) = (self.offsets[face] as usize, self.cage.face_sizes[face] as usize);
        let value = |corner: usize| {
            let corner = first + corner % size;
            width
                * match (attribute.domain, &attribute.indices) {
                    (Domain::Corner, Some(indices)) => indices[corner] as usize,
                    (Domain::Corner, None) => corner,
                    _ => self.cage.corners[corner] as usize,
                }
        };
        let (k, sub) = (topology.sub_corner(tile) as usize, topology.is_sub(tile));
        let nearest = |[u, v]: &[f32; 2]| match (sub, *u >= 0.5, *v >= 0.5) {
            (true, ..) => k,
            (false, false, false) => 0,
            (false, true, false) => 1,
            (false, true, true) => 2,
            (false, false, true) => 3,
        };
        match &attribute.values {
            Values::U32(from) => {
                let copied = parameters.iter().flat_map(|place| &from[value(nearest(place))..][..width]);
                (Vec::new(), copied.copied().collect())
            }
            Values::F32(from) if attribute.name == "weights" => {
                let copied = parameters.iter().flat_map(|place| &from[value(nearest(place))..][..width]);
                (copied.copied().collect(), Vec::new())
            }
            Values::F32(from) => {
                let mut out = Vec::with_capacity(parameters.len() * width);
                let corners: Vec<[f32; 4]> = (0..width)
                    .map(|axis| {
                        let at = |corner: usize| from[value(corner) + axis];
                        if sub {
                            let centre = (0..size).map(at).sum::<f32>() / size as f32;
                            [at(k), 0.5 * (at(k) + at(k + 1)), centre, 0.5 * (at(k) + at(k + size - 1))]
                        } else {
                            std::array::from_fn(at)
                        }
                    })
                    .collect();
                for [u, v] in parameters {
                    out.extend(corners.iter().map(|c| {
                        let (low, high) = (c[0] + (c[1] - c[0]) * u, c[3] + (c[2] - c[3]) * u);
                        low + (high - low) * v
                    }));
                }
                (out, Vec::new())
            }
        }
    }
}
