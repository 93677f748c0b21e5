//! A displaced surface as a triangle mesh without cracks, welded but for infinitely sharp edges, whose two sides have
//! vertices of their own for the sake of normals.
//!
//! Every tile has a rate, its number of cells a side. A segment between two tiles is sampled at the higher of both
//! rates, and both tiles use the same samples: inside, a tile is a lattice; the strip between the lattice and the
//! finer edge is stitched, as hardware tessellators do. Vertices on edges are evaluated at their canonical place.
//! Attributes are carried along: bilinear over the tile for corners and points, copied for faces.

use std::ops::Range;
use std::sync::Arc;

use relievo_core::progress::Silent;
use relievo_core::{Attribute, Context, Domain, Error, Marks, Mesh, Parts, Progress, Result, Values};
use relievo_surface::{Grid, Place, Placement, TileTopology};

use crate::layers::trace::Trace;
use crate::quads::carried::Carried;
use crate::quads::displaced::{Displaced, Points};
use crate::quads::field::Field;
pub use crate::quads::numbering::MAX_RATE;
use crate::quads::numbering::{Local, Numbering, check_cage};
use crate::texel::{ColorTexel, Texel};

/// What is being done, for progress.
const STAGE: &str = "tessellate";

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

/// Makes tessellations of one cage at fixed rates, whose triangles stay the same while their points move.
pub struct Tessellator {
    numbering: Numbering,
}

/// What one tile writes of a tessellation.
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

impl Displaced<'_> {
    /// Triangles of the displaced surface at these rates, see [`Tessellator`].
    ///
    /// # Errors
    /// Fails as [`Tessellator::new`] and [`Tessellator::tessellate`].
    pub fn tessellate(&self, context: &Context, cage: &Mesh, rates: &[u32]) -> Result<Tessellation> {
        Tessellator::new(self.field().topology(), cage, rates.to_vec())?.tessellate(context, self, cage)
    }
}

impl Tessellator {
    /// Tessellates with `rates[tile]` cells along the sides of each tile: a power of two up to [`MAX_RATE`]. The faces
    /// and creases are those of `cage`.
    ///
    /// # Errors
    /// Fails if the cage has other faces, there is not one rate per tile, a rate cannot be used, or the mesh would have
    /// 2³² corners or more.
    pub fn new(topology: &Arc<TileTopology>, cage: &Mesh, rates: Vec<u32>) -> Result<Self> {
        Ok(Self { numbering: Numbering::new(topology.clone(), cage, rates)? })
    }

    /// Number of triangles.
    pub fn triangle_count(&self) -> usize {
        self.numbering.triangles.last().map_or(0, |count| *count as usize)
    }

    /// Number of points.
    pub fn point_count(&self) -> usize {
        self.numbering.vertices as usize
    }

    /// Triangles of the displaced surface, with the attributes of `cage`. Holes are left out.
    ///
    /// # Errors
    /// Fails if the cage has other faces, or the surface other tiles.
    pub fn tessellate(&self, context: &Context, displaced: &Displaced<'_>, cage: &Mesh) -> Result<Tessellation> {
        self.tessellate_watched(context, displaced, cage, &mut Silent)
    }

    /// As [`Self::tessellate`], in pieces between which `progress` hears of the stage `tessellate`.
    ///
    /// # Errors
    /// As there, and where `progress` asks to stop.
    pub fn tessellate_watched(
        &self,
        context: &Context,
        displaced: &Displaced<'_>,
        cage: &Mesh,
        progress: &mut dyn Progress,
    ) -> Result<Tessellation> {
        let numbering = &self.numbering;
        let topology = &numbering.topology;
        check_cage(topology, cage)?;
        self.check(displaced)?;
        let outline: Vec<u32> = (0..numbering.outline.len() as u32).collect();
        let mut points = Points::default();
        progress.step(0.0, STAGE)?;
        self.outline(context, displaced, &outline, &mut points)?;
        progress.step(0.1, STAGE)?;
        let shared = points.p.len();
        points.p.resize(self.point_count(), [0.0; 3]);
        points.normal.resize(self.point_count(), [0.0; 3]);
        let triangle_count = self.triangle_count();
        let mut corners = vec![0u32; 3 * triangle_count];
        // Indices of corner attributes, if there are any.
        let indexed = cage.attributes.iter().any(|attribute| attribute.domain == Domain::Corner);
        let mut locals = vec![0u32; if indexed { 3 * triangle_count } else { 0 }];
        let mut tiles = vec![0u32; triangle_count];
        let mut parameters = vec![[0.0; 2]; 3 * triangle_count];
        let mut parts = Vec::with_capacity(numbering.rates.len());
        let (mut p, mut normal) = (&mut points.p[shared..], &mut points.normal[shared..]);
        let (mut corner_rest, mut local_rest, mut tile_rest) = (&mut corners[..], &mut locals[..], &mut tiles[..]);
        let mut parameter_rest = &mut parameters[..];
        for tile in numbering.live() {
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
        let work = |_, part: &mut Part<'_>| {
            let local = Local::new(numbering, part.tile);
            let first = numbering.locals[part.tile as usize];
            part.tiles.fill(part.tile);
            let triangles = local.triangles(numbering.rates[part.tile as usize]);
            let indices = triangles.as_flattened();
            for (slot, index) in indices.iter().enumerate() {
                part.corners[slot] = local.vertices[*index as usize];
                part.parameters[slot] = local.parameters[*index as usize];
            }
            part.locals.iter_mut().zip(indices).for_each(|(slot, index)| *slot = first + index);
            let mut inside = context.scratch().lend::<Points>();
            part.result = self.inside(context, displaced, part.tile, &mut inside).map(|()| {
                part.p.copy_from_slice(&inside.p);
                part.normal.copy_from_slice(&inside.normal);
            });
        };
        let (count, piece) = (parts.len(), parts.len().div_ceil(64).max(2 * context.threads()));
        for (index, parts) in parts.chunks_mut(piece).enumerate() {
            progress.step(0.1 + 0.8 * (index * piece) as f32 / count as f32, STAGE)?;
            context.for_each_mut(parts, work);
        }
        progress.step(0.9, STAGE)?;
        parts.into_iter().try_for_each(|part| part.result)?;
        let mut mesh = Mesh::new(points.p, vec![3; triangle_count], corners);
        mesh.attributes.push(Attribute {
            name: "normal".into(),
            domain: Domain::Point,
            width: 3,
            values: Values::F32(points.normal.into_flattened()),
            indices: None,
        });
        let carried = Carried { context, numbering, cage, offsets: cage.face_offsets() };
        for attribute in cage.attributes.iter().filter(|attribute| attribute.name != "normal") {
            mesh.attributes.push(carried.attribute(attribute, &tiles, &locals));
        }
        Ok(Tessellation { mesh, tiles, parameters })
    }

    /// Moves the points and normals of `changed` tiles to where the displaced surface now is, as
    /// [`Snapshot::changed`](crate::Snapshot::changed) lists them; all else stays. `marks` get the points whose position
    /// or normal differs from before.
    ///
    /// # Errors
    /// Fails, and changes nothing, if a tile does not exist, the tessellation is not one of this tessellator, or the
    /// surface has other tiles.
    pub fn update(
        &self,
        context: &Context,
        displaced: &Displaced<'_>,
        changed: &[u32],
        tessellation: &mut Tessellation,
        marks: &Marks,
    ) -> Result<()> {
        let topology = &self.numbering.topology;
        self.check(displaced)?;
        if let Some(tile) = changed.iter().find(|tile| **tile as usize >= topology.tile_count()) {
            return Err(Error::invalid(format!("tile {tile} does not exist")));
        }
        let Mesh { points, attributes, face_sizes, .. } = &mut tessellation.mesh;
        let normals = attributes.iter_mut().find(|attribute| attribute.name == "normal");
        let normals = normals.and_then(|attribute| match &mut attribute.values {
            Values::F32(normals) => Some(normals),
            Values::U32(_) => None,
        });
        let (count, triangles) = (self.point_count(), self.triangle_count());
        let normals =
            normals.filter(|normals| (normals.len(), points.len(), face_sizes.len()) == (3 * count, count, triangles));
        let normals = normals.ok_or_else(|| Error::invalid("the tessellation is not one of these rates"))?;
        let mut room = context.scratch().lend::<UpdateRoom>();
        let UpdateRoom { live, shared, outside, insides } = &mut *room;
        live.clear();
        live.extend(changed.iter().copied().filter(|tile| !topology.is_hole(*tile)));
        live.sort_unstable();
        live.dedup();
        // What tiles share is evaluated once.
        shared.clear();
        for tile in live.iter() {
            (0..4).for_each(|edge| self.numbering.along(*tile, edge, |vertex, _| shared.push(vertex)));
        }
        shared.sort_unstable();
        shared.dedup();
        self.outline(context, displaced, shared, outside)?;
        let normals = normals.as_chunks_mut::<3>().0;
        for (vertex, (p, normal)) in shared.iter().zip(outside.p.iter().zip(&outside.normal)) {
            let vertex = *vertex as usize;
            marks.renew(vertex, &mut points[vertex..=vertex], &[*p]);
            marks.renew(vertex, &mut normals[vertex..=vertex], &[*normal]);
        }
        // Insides are apart from one another and in the order of their tiles.
        insides.clear();
        for tile in live.iter() {
            let range = self.numbering.inside(*tile);
            if !range.is_empty() {
                insides.push((*tile, range));
            }
        }
        let insides = Insides { tiles: insides, from: 0, p: points, normal: normals };
        context.for_each_part(insides, INSIDES, |_, Insides { tiles, from, p, normal }| {
            let mut inside = context.scratch().lend::<Points>();
            for (tile, range) in tiles {
                self.inside(context, displaced, *tile, &mut inside)?;
                let (first, at) = (range.start as usize, (range.start - from) as usize);
                marks.renew(first, &mut p[at..at + range.len()], &inside.p);
                marks.renew(first, &mut normal[at..at + range.len()], &inside.normal);
            }
            Ok(())
        })
    }

    /// Gives the points of `changed` tiles the colours of `paint`, as [`Tessellation::paint`] gives them to all. What
    /// is seen in a tile may depend on those around it, see [`Field::seen_from`]. `marks` get the points whose colour
    /// differs from before.
    ///
    /// # Errors
    /// Fails, and changes nothing, if the mesh has no colours yet, or the colours are those of another surface.
    pub fn paint<T: ColorTexel>(
        &self,
        paint: &Field<T>,
        changed: &[u32],
        tessellation: &mut Tessellation,
        marks: &Marks,
    ) -> Result<()> {
        let [values] = self.attributes(paint, ["color"], 3, tessellation)?;
        let values = values.as_chunks_mut::<3>().0;
        self.each_point(changed, |vertex, place| {
            let color = paint.color(paint.canonical(place)).truncate().to_array();
            marks.renew(vertex, &mut values[vertex..=vertex], &[color]);
        });
        Ok(())
    }

    /// Gives the points of `changed` tiles what `traces` says, as [`Tessellation::trace`] gives it to all. `marks` get the
    /// points whose contact, depth or age differs from before.
    ///
    /// # Errors
    /// Fails, and changes nothing, if the mesh has no traces yet, or the traces are those of another surface.
    pub fn trace(
        &self,
        traces: &Field<Trace>,
        now: f64,
        changed: &[u32],
        tessellation: &mut Tessellation,
        marks: &Marks,
    ) -> Result<()> {
        let lists = self.attributes(traces, ["contact", "depth", "age"], 1, tessellation)?;
        let mut lists = lists.map(|list| list.as_chunks_mut::<1>().0);
        self.each_point(changed, |vertex, place| {
            let mark = traces.mark(traces.canonical(place));
            for (list, value) in lists.iter_mut().zip([mark.contact, mark.depth, mark.age(now)]) {
                marks.renew(vertex, &mut list[vertex..=vertex], &[[value]]);
            }
        });
        Ok(())
    }

    /// The values of point attributes of `width` numbers.
    fn attributes<'a, T: Texel, const N: usize>(
        &self,
        field: &Field<T>,
        names: [&str; N],
        width: usize,
        tessellation: &'a mut Tessellation,
    ) -> Result<[&'a mut [f32]; N]> {
        let wrong = || Error::invalid("the tessellation has no such attributes, or is that of another surface");
        if field.tile_count() != self.numbering.rates.len() {
            return Err(wrong());
        }
        let count = width * self.point_count();
        let mut found = names.map(|_| None);
        for attribute in &mut tessellation.mesh.attributes {
            let Some(at) = names.iter().position(|name| *name == attribute.name) else { continue };
            if let Values::F32(values) = &mut attribute.values
                && values.len() == count
            {
                found[at] = Some(values.as_mut_slice());
            }
        }
        if found.iter().any(Option::is_none) {
            return Err(wrong());
        }
        Ok(found.map(Option::unwrap_or_default))
    }

    /// Calls `each` with the points of tiles and where they are in one of them.
    fn each_point(&self, tiles: &[u32], mut each: impl FnMut(usize, Place)) {
        let numbering = &self.numbering;
        for tile in tiles.iter().filter(|tile| !numbering.topology.is_hole(**tile)) {
            (0..4).for_each(|edge| numbering.along(*tile, edge, |vertex, place| each(vertex as usize, place)));
            numbering.within(*tile, |vertex, place| each(vertex as usize, place));
        }
    }

    fn check(&self, displaced: &Displaced<'_>) -> Result<()> {
        if displaced.field().tile_count() != self.numbering.rates.len() {
            return Err(Error::invalid("the surface has other tiles than the tessellator"));
        }
        Ok(())
    }

    /// Makes `points` the points inside a tile.
    fn inside(&self, context: &Context, displaced: &Displaced<'_>, tile: u32, points: &mut Points) -> Result<()> {
        let rate = self.numbering.rates[tile as usize];
        if rate > 1 {
            let grid = Grid { size: rate, placement: Placement::Lattice, columns: 1..rate, rows: 1..rate };
            return displaced.grid(context, tile, &grid, points);
        }
        let middle = [Place::new(tile, 0.5, 0.5)];
        let places = if self.numbering.inner(tile) > 0 { &middle[..] } else { &[] };
        displaced.evaluate_in_place(context, places, points)
    }

    /// Makes `points` the points of some vertices of rings and segments.
    fn outline(
        &self,
        context: &Context,
        displaced: &Displaced<'_>,
        vertices: &[u32],
        points: &mut Points,
    ) -> Result<()> {
        let mut room = context.scratch().lend::<OutlineRoom>();
        let OutlineRoom { places, split, own } = &mut *room;
        let source = |vertex: &u32| self.numbering.outline[*vertex as usize];
        places.clear();
        places.extend(vertices.iter().map(|vertex| displaced.canonical(source(vertex).place)));
        displaced.evaluate_in_place(context, places, points)?;
        split.clear();
        split.extend((0..vertices.len()).filter(|index| source(&vertices[*index]).split));
        places.clear();
        places.extend(split.iter().map(|index| source(&vertices[*index]).place));
        displaced.evaluate_in_place(context, places, own)?;
        for (index, normal) in split.iter().zip(&own.normal) {
            points.normal[*index] = *normal;
        }
        Ok(())
    }
}

/// What [`Tessellator::update`] needs on its way.
#[derive(Default)]
struct UpdateRoom {
    live: Vec<u32>,
    shared: Vec<u32>,
    outside: Points,
    /// Tiles with points inside, and which.
    insides: Vec<(u32, Range<u32>)>,
}

/// What [`Tessellator::outline`] needs on its way.
#[derive(Default)]
struct OutlineRoom {
    places: Vec<Place>,
    split: Vec<usize>,
    own: Points,
}

/// Tiles of one item of parallel work.
const INSIDES: usize = 4;

/// Tiles with the points inside them, and all points and normals from the point `from` on.
struct Insides<'a> {
    tiles: &'a [(u32, Range<u32>)],
    from: u32,
    p: &'a mut [[f32; 3]],
    normal: &'a mut [[f32; 3]],
}

impl Parts for Insides<'_> {
    fn len(&self) -> usize {
        self.tiles.len()
    }

    fn split_at(self, at: usize) -> (Self, Self) {
        let (low, high) = self.tiles.split_at(at.min(self.tiles.len()));
        let middle = high.first().map_or(self.from + self.p.len() as u32, |(_, range)| range.start);
        let cut = (middle - self.from) as usize;
        let (p, p_rest) = self.p.split_at_mut(cut);
        let (normal, normal_rest) = self.normal.split_at_mut(cut);
        (
            Self { tiles: low, from: self.from, p, normal },
            Self { tiles: high, from: middle, p: p_rest, normal: normal_rest },
        )
    }
}

impl std::fmt::Debug for Tessellator {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        out.debug_struct("Tessellator")
            .field("points", &self.point_count())
            .field("triangles", &self.triangle_count())
            .finish()
    }
}
