//! A displaced triangle mesh drawn from virtual vertices in the pattern of its values: which parts of which triangles a
//! draw has, and what the device has of the values (`shaders/triangles_draw.wgsl`).
//!
//! Schäfer, Keinert, Nießner and Stamminger 2015, *Local Painting and Deformation of Meshes on the GPU*, Section 6. A face
//! is drawn as the rings inside its pattern and three strips between the outermost ring and its sides, or as a fan; the
//! same triangles as [`FaceRates::triangles`]. Coarser patterns are subsets, so that every face and every edge may be
//! drawn at its own, with the values that are there.

use std::collections::BTreeMap;
use std::sync::Arc;

use glam::{DVec3, Vec3};
use half::f16;
use relievo_core::{Context, Error, Result};
use relievo_gpu::{Buffer, Device, wgpu};
use relievo_surface::TriangleTopology;
use relievo_surface::bezier::Viewpoint;
use relievo_surface::triangle::DeviceMesh;
use relievo_tiles::triangle::{Node, Pattern, Slot, TriangleDisplaced, TriangleField, TriangleNormals, border_strip};
use relievo_tiles::{ByFormat, ColorTexel, Rgba8, Rgba16};

use super::indices::cornered;
use super::thinning::Thinning;

/// Colours of a triangle mesh.
pub type TriangleColors<'a> = ByFormat<&'a TriangleField<Rgba8>, &'a TriangleField<Rgba16>>;

/// What is drawn of faces.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum TrianglePart {
    /// The rings inside a pattern of 2^power segments.
    Inside(u8),
    /// The strip between a pattern of 2^power segments, the first, and a side of 2^power, the second.
    Strip(u8, u8),
    /// The fan from a corner over the other side, of 2^power segments.
    Fan(u8),
}

impl TrianglePart {
    fn triangles(self) -> Vec<[u32; 3]> {
        match self {
            Self::Inside(power) => {
                let Ok(pattern) = Pattern::new(1 << power) else { return Vec::new() };
                let number = |node: Node| match pattern.slot(node) {
                    Slot::Inside(index) => index,
                    // Only rings inside are asked for.
                    Slot::Corner(_) | Slot::Side(..) => 0,
                };
                let strips =
                    (1..pattern.center()).flat_map(|ring| (0..3).flat_map(move |side| pattern.strip(ring, side)));
                strips.map(|triangle| triangle.map(number)).collect()
            }
            Self::Strip(power, side) => {
                Pattern::new(1 << power).map_or(Vec::new(), |pattern| border_strip(pattern, 1 << side))
            }
            Self::Fan(side) => (0..1 << side).map(|k| [k, k + 1, (1 << side) + 1]).collect(),
        }
    }
}

/// A draw of parts of one kind.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TriangleDraw {
    /// What is drawn.
    pub part: TrianglePart,
    /// The first of its parts, in the order of the draws.
    pub first: u32,
    /// How many parts.
    pub count: u32,
    /// Triangles of one part.
    pub triangles: u32,
}

/// The powers of two that faces and edges are divided into: 0 for a face that is one triangle or a fan, and for an edge
/// of one segment.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct TriangleRates {
    /// By face.
    pub faces: Vec<u8>,
    /// By edge.
    pub edges: Vec<u8>,
}

/// What a device has of the values of an element.
#[derive(Clone, Copy, Debug, Default)]
struct Held {
    first: u32,
    /// 0 if there are none inside.
    power: u8,
}

/// A displaced triangle mesh on a device, with its colours.
#[derive(Debug)]
pub struct VirtualTriangles {
    topology: Arc<TriangleTopology>,
    pub(super) mesh: DeviceMesh,
    pub(super) painted: bool,
    faces: Vec<Held>,
    edges: Vec<Held>,
    thinning: Vec<Thinning>,
    /// Where there is room, by the number of values.
    free: BTreeMap<u32, Vec<u32>>,
    end: u32,
    tags: Vec<u32>,
    rates: TriangleRates,
    parts: Vec<(TrianglePart, u32, u32)>,
    draws: Vec<TriangleDraw>,
    held: Buffer<[u32; 2]>,
    values: Buffer<[u32; 4]>,
    drawn: Buffer<[u32; 2]>,
    pub(super) indices: BTreeMap<TrianglePart, Buffer<u32>>,
}

/// What a value is made of.
struct Source<'a> {
    displaced: &'a TriangleDisplaced<'a>,
    normals: &'a TriangleNormals,
    colors: Option<TriangleColors<'a>>,
}

impl Source<'_> {
    fn color(&self, face: u32, pattern: Pattern, node: Node) -> Vec3 {
        fn of<T: ColorTexel>(field: &TriangleField<T>, face: u32, pattern: Pattern, node: Node) -> Vec3 {
            let color = field.at(face, pattern, node).as_vec4();
            color.truncate()
        }
        match self.colors {
            Some(ByFormat::Rgba8(field)) => of(field, face, pattern, node),
            Some(ByFormat::Rgba16(field)) => of(field, face, pattern, node),
            None => Vec3::ZERO,
        }
    }

    fn value(&self, face: u32, pattern: Pattern, node: Node) -> [u32; 4] {
        let (_, height) = self.displaced.at(face, pattern, node);
        let normal = self.normals.at(self.displaced.surface(), face, pattern, node);
        let [r, g, b] =
            self.color(face, pattern, node).to_array().map(|value| u32::from(f16::from_f32(value).to_bits()));
        [height.to_bits(), folded(normal), r | g << 16, b]
    }

    fn face_power(&self, face: u32) -> u8 {
        let painted = match self.colors {
            Some(ByFormat::Rgba8(field)) => field.face_pattern(face),
            Some(ByFormat::Rgba16(field)) => field.face_pattern(face),
            None => None,
        };
        power(self.displaced.field().face_pattern(face).max(painted))
    }

    fn edge_power(&self, edge: u32) -> u8 {
        let painted = match self.colors {
            Some(ByFormat::Rgba8(field)) => field.edge_pattern(edge),
            Some(ByFormat::Rgba16(field)) => field.edge_pattern(edge),
            None => None,
        };
        power(self.displaced.edge_pattern(edge).max(painted))
    }
}

fn power(pattern: Option<Pattern>) -> u8 {
    pattern.map_or(0, |pattern| pattern.segments().ilog2() as u8)
}

/// A unit vector on an octahedron that is unfolded to a square, in two numbers of 16 bits; the corner of the square for
/// none. The inverse of `unfolded` in the shader.
fn folded(normal: Vec3) -> u32 {
    let sum = normal.abs().element_sum();
    if !(sum > 0.0 && sum.is_finite()) {
        return 0x7fff_7fff;
    }
    let v = normal / sum;
    let sign = |value: f32| if value >= 0.0 { 1.0 } else { -1.0 };
    let [x, y] = if v.z >= 0.0 { [v.x, v.y] } else { [(1.0 - v.y.abs()) * sign(v.x), (1.0 - v.x.abs()) * sign(v.y)] };
    // The corner itself stands for none; the direction straight down has three others.
    let [x, y] = if x >= 1.0 && y >= 1.0 { [-1.0, -1.0] } else { [x, y] };
    let bits = |value: f32| u32::from((value * 32767.0).round() as i16 as u16);
    bits(x) | bits(y) << 16
}

impl VirtualTriangles {
    /// Brings a mesh with its displacement, its normals and its colours to a device, divided as finely as values are
    /// kept.
    ///
    /// # Errors
    /// The mesh has vector displacement, the colours are those of another mesh, or the device has no memory.
    pub fn new(
        context: &Context,
        device: &Device,
        displaced: &TriangleDisplaced<'_>,
        normals: &TriangleNormals,
        colors: Option<TriangleColors<'_>>,
    ) -> Result<Self> {
        let topology = displaced.field().topology().clone();
        let (faces, edges, vertices) = (topology.face_count(), topology.edge_count(), topology.vertex_count());
        let end = u32::try_from(vertices).map_err(|_| Error::unsupported("so many vertices cannot be drawn"))?;
        let mut made = Self {
            mesh: DeviceMesh::new(device, displaced.surface())?,
            painted: colors.is_some(),
            faces: vec![Held::default(); faces],
            edges: vec![Held::default(); edges],
            thinning: vec![Thinning::default(); faces + edges],
            free: BTreeMap::new(),
            end,
            tags: vec![0; faces],
            rates: TriangleRates::default(),
            parts: Vec::new(),
            draws: Vec::new(),
            held: Buffer::new(device, "triangles with values", (faces + edges).max(1))?,
            values: Buffer::new(device, "values of triangles", vertices.max(1))?,
            drawn: Buffer::new(device, "drawn triangles", faces.max(1))?,
            indices: BTreeMap::new(),
            topology,
        };
        made.update(context, device, displaced, normals, colors, &(0..faces as u32).collect::<Vec<_>>())?;
        made.divide(device, made.finest())?;
        Ok(made)
    }

    /// Takes over that `changed` faces, ascending, look different than before. It is to be divided anew afterwards.
    ///
    /// # Errors
    /// The mesh is another one or has vector displacement, it has colours where it had none or the other way round, or
    /// the device has no memory.
    pub fn update(
        &mut self,
        context: &Context,
        device: &Device,
        displaced: &TriangleDisplaced<'_>,
        normals: &TriangleNormals,
        colors: Option<TriangleColors<'_>>,
        changed: &[u32],
    ) -> Result<()> {
        let (topology, found) = (self.topology.clone(), displaced.field().topology());
        if (found.face_count(), found.vertex_count()) != (topology.face_count(), topology.vertex_count())
            || colors.is_some() != self.painted
        {
            return Err(Error::invalid("the triangles that are drawn are those of another mesh")
                .advise("give the mesh that is drawn, with colours if it had some"));
        }
        if displaced.vector_reach() > 0.0 {
            return Err(Error::unsupported("vector displacement is not drawn by graphics devices")
                .advise("use the device `cpu`"));
        }
        let source = Source { displaced, normals, colors };
        let faces: Vec<u32> = changed.iter().copied().filter(|face| (*face as usize) < self.faces.len()).collect();
        let mut edges: Vec<u32> = faces.iter().flat_map(|face| topology.edges_of(*face)).collect();
        let mut vertices: Vec<(u32, (u32, u32))> =
            faces.iter().flat_map(|face| topology.face(*face).into_iter().zip((0..3).map(|at| (*face, at)))).collect();
        edges.sort_unstable();
        edges.dedup();
        vertices.sort_unstable();
        vertices.dedup_by_key(|(vertex, _)| *vertex);
        let at_edges = context.map(edges.len(), |at| along_edge(&source, &topology, edges[at]));
        // Where two edges are divided a face has a value in its middle.
        let divided =
            |face: u32| topology.edges_of(face).iter().filter(|edge| source.edge_power(**edge) > 0).count() > 1;
        let own = |face: u32| source.face_power(face).max(u8::from(divided(face)));
        let at_faces = context.map(faces.len(), |at| in_face(&source, &topology, faces[at], own(faces[at])));
        let mut blocks = Vec::with_capacity(faces.len() + edges.len());
        for (elements, found, offset) in [(&faces, at_faces, 0), (&edges, at_edges, self.faces.len())] {
            for (element, (power, values, thinning)) in elements.iter().zip(found) {
                self.thinning[offset + *element as usize] = thinning;
                blocks.push((offset + *element as usize, power, values));
            }
        }
        self.keep(device, blocks)?;
        let corners = context.map(vertices.len(), |at| {
            let (face, corner) = vertices[at].1;
            source.value(face, Pattern::COARSEST, Pattern::COARSEST.node(0, corner, 0))
        });
        write_runs(device, &self.values, vertices.iter().map(|(vertex, _)| *vertex).zip(corners))
    }

    /// Writes values of elements, faces before edges, to where there is room for them.
    fn keep(&mut self, device: &Device, blocks: Vec<(usize, u8, Vec<[u32; 4]>)>) -> Result<()> {
        let count = self.faces.len();
        let mut sizes = Vec::with_capacity(blocks.len());
        for (element, power, values) in &blocks {
            let face = *element < count;
            let held = if face { &mut self.faces[*element] } else { &mut self.edges[*element - count] };
            let before = value_count(face, held.power);
            let needed = values.len() as u32;
            if before != needed {
                if before > 0 {
                    self.free.entry(before).or_default().push(held.first);
                }
                let room = self.free.get_mut(&needed).and_then(Vec::pop);
                held.first = match (room, self.end.checked_add(needed)) {
                    (Some(first), _) => first,
                    (None, Some(end)) => std::mem::replace(&mut self.end, end),
                    (None, None) => return Err(Error::memory("the values are too large for a graphics device")),
                };
            }
            held.power = *power;
            sizes.push((*element as u32, [held.first, u32::from(*power)]));
        }
        let (old, needed) = (self.values.len(), self.end as usize);
        if needed > old {
            let values = Buffer::new(device, "values of triangles", needed + needed / 4)?;
            let mut frame = device.frame()?;
            frame.copy(&self.values, 0..old, &values, 0)?;
            let _ = frame.submit()?;
            self.values = values;
        }
        for ((_, _, values), (_, [first, _])) in blocks.iter().zip(&sizes) {
            if !values.is_empty() {
                self.values.write(device, *first as usize, values)?;
            }
        }
        write_runs(device, &self.held, sizes.into_iter())
    }

    /// As finely as values are kept.
    pub fn finest(&self) -> TriangleRates {
        let powers = |list: &[Held]| list.iter().map(|held| held.power).collect();
        TriangleRates { faces: powers(&self.faces), edges: powers(&self.edges) }
    }

    /// Divides faces and edges as `rates` says, but no finer than values are kept; a face is divided where two of its
    /// edges are.
    ///
    /// # Errors
    /// There are not as many rates, or the device fails.
    pub fn divide(&mut self, device: &Device, mut rates: TriangleRates) -> Result<()> {
        if (rates.faces.len(), rates.edges.len()) != (self.faces.len(), self.edges.len()) {
            return Err(Error::invalid(format!("{} rates for {} triangles", rates.faces.len(), self.faces.len())));
        }
        for (rate, held) in rates.edges.iter_mut().zip(&self.edges).chain(rates.faces.iter_mut().zip(&self.faces)) {
            *rate = (*rate).min(held.power);
        }
        self.parts.clear();
        for face in 0..self.faces.len() as u32 {
            let sides = self.topology.edges_of(face).map(|edge| rates.edges[edge as usize]);
            let long = sides.iter().filter(|side| **side > 0).count();
            let power = &mut rates.faces[face as usize];
            // A vertex inside takes more than the one segment of two or three sides.
            *power = if long > 1 { (*power).max(1) } else { *power };
            if *power == 0 {
                let side = sides.iter().position(|side| *side > 0).unwrap_or(0);
                self.parts.push((TrianglePart::Fan(sides[side]), face, 4 + side as u32));
                continue;
            }
            if *power > 1 {
                self.parts.push((TrianglePart::Inside(*power), face, 0));
            }
            let strip = |side: usize| (TrianglePart::Strip(*power, sides[side]), face, 1 + side as u32);
            self.parts.extend([0, 1, 2].map(strip));
        }
        self.parts.sort_unstable();
        self.draws.clear();
        let mut first = 0;
        for run in self.parts.chunk_by(|a, b| a.0 == b.0) {
            let (part, count) = (run[0].0, run.len() as u32);
            if let std::collections::btree_map::Entry::Vacant(entry) = self.indices.entry(part) {
                let indices = cornered(&part.triangles());
                let buffer = Buffer::vertices(device, "pattern", indices.len())?;
                buffer.write(device, 0, &indices)?;
                entry.insert(buffer);
            }
            let triangles = self.indices.get(&part).map_or(0, Buffer::len) as u32 / 3;
            self.draws.push(TriangleDraw { part, first, count, triangles });
            first += count;
        }
        self.rates = rates;
        self.write(device)
    }

    /// Divides faces so that triangles are at most about `tolerance` pixels from the finest ones as `view`, in its space,
    /// shows them, and colours at most two of 255 steps, or the triangles are smaller than a pixel.
    ///
    /// # Errors
    /// The tolerance is not above zero, or the device fails.
    pub fn adapt(&mut self, device: &Device, view: &Viewpoint, tolerance: f64) -> Result<()> {
        if !(tolerance > 0.0 && tolerance.is_finite()) {
            return Err(Error::invalid(format!("the tolerance of {tolerance} pixels cannot be met"))
                .advise("use a number above zero"));
        }
        let count = self.faces.len();
        let lowest = |at: usize| self.thinning[at].lowest(view, tolerance);
        let faces: Vec<u8> = (0..count).map(lowest).collect();
        let mut edges: Vec<u8> = (count..count + self.edges.len()).map(lowest).collect();
        // A strip sees half of what is beside it: its edge has at least half as many segments as the face.
        for (face, power) in (0..).zip(&faces) {
            for edge in self.topology.edges_of(face) {
                let edge = &mut edges[edge as usize];
                *edge = (*edge).max(power.saturating_sub(1));
            }
        }
        let rates = TriangleRates { faces, edges };
        if rates == self.rates { Ok(()) } else { self.divide(device, rates) }
    }

    /// Says which false colour faces get where a view has some.
    ///
    /// # Errors
    /// A tag is 4,096 or above, or the device fails.
    pub fn tag(&mut self, device: &Device, tag: impl Fn(u32) -> u32) -> Result<()> {
        let tags: Vec<u32> = (0..self.faces.len() as u32).map(tag).collect();
        if tags.iter().any(|tag| *tag >= super::tiles::TAGS) {
            return Err(Error::invalid(format!("tags of faces go up to {}", super::tiles::TAGS - 1)));
        }
        self.tags = tags;
        self.write(device)
    }

    /// How faces and edges are divided.
    pub fn rates(&self) -> &TriangleRates {
        &self.rates
    }

    /// The draws: one for each kind of part.
    pub fn draws(&self) -> &[TriangleDraw] {
        &self.draws
    }

    /// Triangles of all draws.
    pub fn triangle_count(&self) -> u64 {
        self.draws.iter().map(|draw| u64::from(draw.count) * u64::from(draw.triangles)).sum()
    }

    /// Smallest and largest coordinates.
    pub(super) fn bounds(&self) -> (DVec3, DVec3) {
        let all = self.thinning[..self.faces.len()].iter();
        all.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), face| {
            let [a, b] = [face.low, face.high].map(|corner| DVec3::from(corner.map(f64::from)));
            (low.min(a), high.max(b))
        })
    }

    /// What is bound as group 2.
    pub(super) fn buffers(&self) -> [&wgpu::Buffer; 3] {
        [self.held.wgpu(), self.values.wgpu(), self.drawn.wgpu()]
    }

    fn write(&mut self, device: &Device) -> Result<()> {
        let record = |(part, face, kind): &(TrianglePart, u32, u32)| {
            let (power, side) = match *part {
                TrianglePart::Inside(power) => (power, 0),
                TrianglePart::Strip(power, side) => (power, side),
                TrianglePart::Fan(side) => (0, side),
            };
            let bits = u32::from(power) | u32::from(side) << 4 | kind << 8;
            [*face, bits | self.tags[*face as usize] << 20]
        };
        let records: Vec<[u32; 2]> = self.parts.iter().map(record).collect();
        if self.drawn.len() < records.len() {
            self.drawn = Buffer::new(device, "drawn triangles", records.len() + records.len() / 4)?;
        }
        self.drawn.write(device, 0, &records)
    }
}

/// Values inside an element of 2^power segments.
fn value_count(face: bool, power: u8) -> u32 {
    match (Pattern::new(1 << power), face) {
        _ if power == 0 => 0,
        (Ok(pattern), true) => pattern.face_values() as u32,
        (Ok(pattern), false) => pattern.edge_values() as u32,
        (Err(_), _) => 0,
    }
}

/// Writes what belongs to ascending places, run by run.
fn write_runs<T: bytemuck::Pod>(
    device: &Device,
    buffer: &Buffer<T>,
    items: impl Iterator<Item = (u32, T)>,
) -> Result<()> {
    let items: Vec<(u32, T)> = items.collect();
    for run in items.chunk_by(|a, b| a.0 + 1 == b.0) {
        let values: Vec<T> = run.iter().map(|(_, value)| *value).collect();
        buffer.write(device, run[0].0 as usize, &values)?;
    }
    Ok(())
}

/// The values inside an edge, from its lower vertex, and what coarser patterns leave out.
fn along_edge(source: &Source<'_>, topology: &TriangleTopology, edge: u32) -> (u8, Vec<[u32; 4]>, Thinning) {
    let Some((face, side)) = topology.faces_along(edge).next() else { return (0, Vec::new(), Thinning::default()) };
    let power = source.edge_power(edge);
    let Ok(pattern) = Pattern::new(1 << power.max(1)) else { return (0, Vec::new(), Thinning::default()) };
    let segments = pattern.segments();
    let reversed = topology.side(face, side).reversed;
    let node = |step: u32| pattern.node(0, side, if reversed { segments - step } else { step });
    let point = |step: u32| source.displaced.point(face, pattern, node(step));
    let points: Vec<Vec3> = (0..=segments).map(point).collect();
    let colors: Vec<Vec3> = (0..=segments).map(|step| source.color(face, pattern, node(step))).collect();
    let values = if power == 0 {
        Vec::new()
    } else {
        (1..segments).map(|step| source.value(face, pattern, node(step))).collect()
    };
    (power, values, Thinning::along(power, &points, &colors))
}

/// The values inside a face of 2^power segments, and what coarser patterns leave out.
fn in_face(source: &Source<'_>, topology: &TriangleTopology, face: u32, power: u8) -> (u8, Vec<[u32; 4]>, Thinning) {
    // The sides of a face may be finer than its inside: how far they reach is seen at them.
    let finest = topology.edges_of(face).iter().map(|edge| source.edge_power(*edge)).fold(power, u8::max).max(1);
    let Ok(pattern) = Pattern::new(1 << power.max(1)) else { return (0, Vec::new(), Thinning::default()) };
    let at = |slot: Slot| {
        let node = pattern.at_slot(slot);
        (source.displaced.point(face, pattern, node), source.color(face, pattern, node))
    };
    let mut thinning = Thinning::inside(power, pattern, at);
    if let Ok(border) = Pattern::new(1 << finest) {
        let sides = (0..3).flat_map(|side| (0..border.segments()).map(move |step| border.node(0, side, step)));
        sides.for_each(|node| thinning.reach(source.displaced.point(face, border, node)));
    }
    let inside = (0..pattern.face_values() as u32).map(|index| pattern.at_slot(Slot::Inside(index)));
    let values = if power == 0 { Vec::new() } else { inside.map(|node| source.value(face, pattern, node)).collect() };
    (power, values, thinning)
}
