//! What a device has of the values of a displaced triangle mesh, by face, edge and vertex (`held_values` of
//! `shaders/draw/triangles_draw.wgsl`), and what coarser patterns leave out of them.
//!
//! A value is 4 words: displacement, normal, colour; then 3 of a vector in object space and 2 of a trace, where there are
//! some.

use glam::Vec3;
use half::f16;
use relievo_core::{Context, Error, Result};
use relievo_gpu::{Buffer, Device, wgpu};
use relievo_surface::TriangleTopology;
use relievo_tiles::triangle::{Node, Pattern, Slot, TriangleDisplaced, TriangleField, TriangleNormals};
use relievo_tiles::{ColorTexel, by_format};

use super::coat::TriangleCoat;
use super::heap::{Heap, write_runs};
use super::thinning::Thinning;

/// What values have beside displacements and normals.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Kind {
    pub colors: bool,
    pub vectors: bool,
    pub traces: bool,
}

impl Kind {
    pub fn of(displaced: &TriangleDisplaced<'_>, coat: TriangleCoat<'_>) -> Self {
        Self { colors: coat.colors.is_some(), vectors: displaced.vectors().is_some(), traces: coat.traces.is_some() }
    }

    /// Words of a value.
    fn words(self) -> u32 {
        4 + 3 * u32::from(self.vectors) + 2 * u32::from(self.traces)
    }
}

/// What a device has of the values of an element.
#[derive(Clone, Copy, Debug, Default)]
struct Held {
    /// The first word.
    first: u32,
    /// 0 without values inside.
    power: u8,
}

/// The values of an element inside, its power of two, and what coarser patterns leave out.
type Found = (u8, Vec<u32>, Thinning);

/// Values on a device.
#[derive(Debug)]
pub(super) struct TriangleValues {
    kind: Kind,
    faces: usize,
    /// Of faces, then of edges.
    held: Vec<Held>,
    thinning: Vec<Thinning>,
    on_device: Buffer<[u32; 2]>,
    /// Those of the vertices of the mesh, then those of elements.
    values: Heap<u32>,
}

/// What a value is made of.
struct Source<'a> {
    displaced: &'a TriangleDisplaced<'a>,
    normals: &'a TriangleNormals,
    coat: TriangleCoat<'a>,
}

impl Source<'_> {
    fn color(&self, face: u32, pattern: Pattern, node: Node) -> Vec3 {
        fn of<T: ColorTexel>(field: &TriangleField<T>, face: u32, pattern: Pattern, node: Node) -> Vec3 {
            field.at(face, pattern, node).as_vec4().truncate()
        }
        self.coat.colors.map_or(Vec3::ZERO, |colors| by_format!(colors, field => of(field, face, pattern, node)))
    }

    /// The colour by which coarser patterns are judged: under the tint that is left at once.
    fn seen(&self, face: u32, pattern: Pattern, node: Node) -> Vec3 {
        let base = self.color(face, pattern, node);
        let Some((traces, tint)) = self.coat.traces else { return base };
        let mark = traces.mark(face, pattern, node);
        let deep = if tint.depth > 0.0 { (mark.depth / tint.depth).min(1.0) } else { 1.0 };
        base.lerp(Vec3::from(tint.color), mark.contact * deep)
    }

    /// Adds the words of a value.
    fn value(&self, face: u32, pattern: Pattern, node: Node, words: &mut Vec<u32>) {
        let (_, height) = self.displaced.at(face, pattern, node);
        let normal = self.normals.at(self.displaced.surface(), face, pattern, node);
        let half = |value: f32| u32::from(f16::from_f32(value).to_bits());
        let color = self.color(face, pattern, node);
        words.extend([height.to_bits(), folded(normal), half(color.x) | half(color.y) << 16, half(color.z)]);
        if let Some(vectors) = self.displaced.vectors() {
            words.extend(vectors.at(face, pattern, node).as_vec3().to_array().map(f32::to_bits));
        }
        if let Some((traces, _)) = self.coat.traces {
            let trace = traces.at(face, pattern, node).as_vec4();
            words.extend([half(trace.x) | half(trace.y) << 16, trace.z.to_bits()]);
        }
    }

    fn face_power(&self, face: u32) -> u8 {
        let painted = self.coat.colors.and_then(|colors| by_format!(colors, field => field.face_pattern(face)));
        let traced = self.coat.traces.and_then(|(traces, _)| traces.face_pattern(face));
        let moved = self.displaced.vectors().and_then(|vectors| vectors.face_pattern(face));
        power(self.displaced.field().face_pattern(face).max(painted).max(traced).max(moved))
    }

    fn edge_power(&self, edge: u32) -> u8 {
        let painted = self.coat.colors.and_then(|colors| by_format!(colors, field => field.edge_pattern(edge)));
        let traced = self.coat.traces.and_then(|(traces, _)| traces.edge_pattern(edge));
        power(self.displaced.edge_pattern(edge).max(painted).max(traced))
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

impl TriangleValues {
    /// Room for the values of the vertices of a mesh.
    pub fn new(device: &Device, topology: &TriangleTopology, kind: Kind) -> Result<Self> {
        let (faces, elements) = (topology.face_count(), topology.face_count() + topology.edge_count());
        let fixed = topology.vertex_count().checked_mul(kind.words() as usize);
        let fixed = fixed.ok_or_else(|| Error::unsupported("so many vertices cannot be drawn"))?;
        Ok(Self {
            kind,
            faces,
            held: vec![Held::default(); elements],
            thinning: vec![Thinning::default(); elements],
            on_device: Buffer::new(device, "triangles with values", elements.max(1))?,
            values: Heap::new(device, "values of triangles", fixed)?,
        })
    }

    /// What they have.
    pub fn kind(&self) -> Kind {
        self.kind
    }

    /// The powers of two of the patterns that are kept, by face and by edge.
    pub fn powers(&self) -> (Vec<u8>, Vec<u8>) {
        let (faces, edges) = self.held.split_at(self.faces);
        let powers = |list: &[Held]| list.iter().map(|held| held.power).collect();
        (powers(faces), powers(edges))
    }

    /// What coarser patterns leave out of an element, faces before edges.
    pub fn thinning(&self, element: usize) -> &Thinning {
        &self.thinning[element]
    }

    /// What is bound: where values are, and the values.
    pub fn buffers(&self) -> [&wgpu::Buffer; 2] {
        [self.on_device.wgpu(), self.values.wgpu()]
    }

    /// Takes over that `changed` faces, ascending, are others. Fails if the device has no memory.
    #[expect(clippy::too_many_arguments, reason = "all that a value is made of")]
    pub fn update(
        &mut self,
        context: &Context,
        device: &Device,
        topology: &TriangleTopology,
        displaced: &TriangleDisplaced<'_>,
        normals: &TriangleNormals,
        coat: TriangleCoat<'_>,
        changed: &[u32],
    ) -> Result<()> {
        let source = Source { displaced, normals, coat };
        let faces: Vec<u32> = changed.iter().copied().filter(|face| (*face as usize) < self.faces).collect();
        let mut edges: Vec<u32> = faces.iter().flat_map(|face| topology.edges_of(*face)).collect();
        let mut vertices: Vec<(u32, (u32, u32))> =
            faces.iter().flat_map(|face| topology.face(*face).into_iter().zip((0..3).map(|at| (*face, at)))).collect();
        edges.sort_unstable();
        edges.dedup();
        vertices.sort_unstable();
        vertices.dedup_by_key(|(vertex, _)| *vertex);
        let at_edges = context.map(edges.len(), |at| along_edge(&source, topology, edges[at]));
        // Where two edges are divided a face has a value in its middle.
        let divided =
            |face: u32| topology.edges_of(face).iter().filter(|edge| source.edge_power(**edge) > 0).count() > 1;
        let own = |face: u32| source.face_power(face).max(u8::from(divided(face)));
        let at_faces = context.map(faces.len(), |at| in_face(&source, topology, faces[at], own(faces[at])));
        let elements = faces.iter().copied().chain(edges.iter().map(|edge| self.faces as u32 + edge));
        self.keep(device, elements.zip(at_faces.into_iter().chain(at_edges)).collect())?;
        let words = self.kind.words();
        let corners = context.map(vertices.len(), |at| {
            let (face, corner) = vertices[at].1;
            let mut value = Vec::with_capacity(words as usize);
            source.value(face, Pattern::COARSEST, Pattern::COARSEST.node(0, corner, 0), &mut value);
            value
        });
        let at = |vertex: u32, word: usize| vertex * words + word as u32;
        let items: Vec<(u32, u32)> = vertices
            .iter()
            .zip(&corners)
            .flat_map(|((vertex, _), value)| (0..).zip(value).map(move |(word, bits)| (at(*vertex, word), *bits)))
            .collect();
        write_runs(device, &items, |device, first, values| self.values.write(device, first, values))
    }

    /// Writes values of elements, ascending, to where there is room for them.
    fn keep(&mut self, device: &Device, found: Vec<(u32, Found)>) -> Result<()> {
        let words = self.kind.words();
        let mut heads = Vec::with_capacity(found.len());
        let mut blocks = Vec::with_capacity(found.len());
        for (element, (power, values, thinning)) in found {
            let index = element as usize;
            let held = &mut self.held[index];
            let before = words * value_count(index < self.faces, held.power);
            held.first = self.values.place(held.first, before, values.len() as u32)?;
            held.power = power;
            self.thinning[index] = thinning;
            heads.push((element, [held.first / words, u32::from(power)]));
            blocks.push((held.first, values));
        }
        self.values.grow(device)?;
        blocks.iter().try_for_each(|(first, values)| self.values.write(device, *first, values))?;
        write_runs(device, &heads, |device, first, values| self.on_device.write(device, first as usize, values))
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

/// The values inside an edge, from its lower vertex, and what coarser patterns leave out.
fn along_edge(source: &Source<'_>, topology: &TriangleTopology, edge: u32) -> Found {
    let Some((face, side)) = topology.faces_along(edge).next() else { return (0, Vec::new(), Thinning::default()) };
    let power = source.edge_power(edge);
    let Ok(pattern) = Pattern::new(1 << power.max(1)) else { return (0, Vec::new(), Thinning::default()) };
    let segments = pattern.segments();
    let reversed = topology.side(face, side).reversed;
    let node = |step: u32| pattern.node(0, side, if reversed { segments - step } else { step });
    let point = |step: u32| source.displaced.point(face, pattern, node(step));
    let points: Vec<Vec3> = (0..=segments).map(point).collect();
    let colors: Vec<Vec3> = (0..=segments).map(|step| source.seen(face, pattern, node(step))).collect();
    let mut values = Vec::new();
    if power > 0 {
        (1..segments).for_each(|step| source.value(face, pattern, node(step), &mut values));
    }
    (power, values, Thinning::along(power, &points, &colors))
}

/// The values inside a face of 2^power segments, and what coarser patterns leave out.
fn in_face(source: &Source<'_>, topology: &TriangleTopology, face: u32, power: u8) -> Found {
    // The sides of a face may be finer than its inside: how far they reach is seen at them.
    let finest = topology.edges_of(face).iter().map(|edge| source.edge_power(*edge)).fold(power, u8::max).max(1);
    let Ok(pattern) = Pattern::new(1 << power.max(1)) else { return (0, Vec::new(), Thinning::default()) };
    let at = |slot: Slot| {
        let node = pattern.at_slot(slot);
        (source.displaced.point(face, pattern, node), source.seen(face, pattern, node))
    };
    let mut thinning = Thinning::inside(power, pattern, at);
    if let Ok(border) = Pattern::new(1 << finest) {
        let sides = (0..3).flat_map(|side| (0..border.segments()).map(move |step| border.node(0, side, step)));
        sides.for_each(|node| thinning.reach(source.displaced.point(face, border, node)));
    }
    let inside = (0..pattern.face_values() as u32).map(|index| pattern.at_slot(Slot::Inside(index)));
    let mut values = Vec::new();
    if power > 0 {
        inside.for_each(|node| source.value(face, pattern, node, &mut values));
    }
    (power, values, thinning)
}
