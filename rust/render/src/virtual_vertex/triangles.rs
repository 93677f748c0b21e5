//! A displaced triangle mesh drawn from virtual vertices in the pattern of its values: which parts of which triangles a
//! draw has (`shaders/draw/triangles_draw.wgsl`).
//!
//! Schäfer, Keinert, Nießner and Stamminger 2015, *Local Painting and Deformation of Meshes on the GPU*, Section 6. A face
//! is drawn as the rings inside its pattern and three strips between the outermost ring and its sides, or as a fan; the
//! same triangles as [`FaceRates::triangles`]. Coarser patterns are subsets, so that every face and every edge may be
//! drawn at its own, with the values that are there.

use std::collections::BTreeMap;
use std::sync::Arc;

use glam::DVec3;
use relievo_core::{Context, Error, Result};
use relievo_gpu::{Buffer, Device, wgpu};
use relievo_surface::TriangleTopology;
use relievo_surface::bezier::Viewpoint;
use relievo_surface::triangle::DeviceMesh;
use relievo_tiles::triangle::{Node, Pattern, Slot, TriangleDisplaced, TriangleNormals, border_strip};

use super::coat::{Tint, TriangleCoat};
use super::indices::cornered;
use super::triangle_values::{Kind, TriangleValues};

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

/// A displaced triangle mesh on a device, with its colours and traces.
#[derive(Debug)]
pub struct VirtualTriangles {
    topology: Arc<TriangleTopology>,
    pub(super) mesh: DeviceMesh,
    values: TriangleValues,
    tint: Tint,
    tags: Vec<u32>,
    rates: TriangleRates,
    parts: Vec<(TrianglePart, u32, u32)>,
    draws: Vec<TriangleDraw>,
    drawn: Buffer<[u32; 2]>,
    pub(super) indices: BTreeMap<TrianglePart, Buffer<u32>>,
}

impl VirtualTriangles {
    /// Brings a mesh with its displacement, its normals, its colours and traces to a device, divided as finely as values
    /// are kept.
    ///
    /// # Errors
    /// The colours or traces are those of another mesh, or the device has no memory.
    pub fn new(
        context: &Context,
        device: &Device,
        displaced: &TriangleDisplaced<'_>,
        normals: &TriangleNormals,
        coat: TriangleCoat<'_>,
    ) -> Result<Self> {
        let topology = displaced.field().topology().clone();
        let faces = topology.face_count();
        let mut made = Self {
            mesh: DeviceMesh::new(device, displaced.surface())?,
            values: TriangleValues::new(device, &topology, Kind::of(displaced, coat))?,
            tint: Tint::default(),
            tags: vec![0; faces],
            rates: TriangleRates::default(),
            parts: Vec::new(),
            draws: Vec::new(),
            drawn: Buffer::new(device, "drawn triangles", faces.max(1))?,
            indices: BTreeMap::new(),
            topology,
        };
        made.update(context, device, displaced, normals, coat, &(0..faces as u32).collect::<Vec<_>>())?;
        made.divide(device, made.finest())?;
        Ok(made)
    }

    /// Takes over that `changed` faces, ascending, look different than before, and the time of a tint. It is to be divided
    /// anew where [`Self::finest`] is another.
    ///
    /// # Errors
    /// The mesh is another one, it has colours, vectors or traces where it had none or the other way round, or the device
    /// has no memory.
    pub fn update(
        &mut self,
        context: &Context,
        device: &Device,
        displaced: &TriangleDisplaced<'_>,
        normals: &TriangleNormals,
        coat: TriangleCoat<'_>,
        changed: &[u32],
    ) -> Result<()> {
        let (topology, found) = (&self.topology, displaced.field().topology());
        if (found.face_count(), found.vertex_count()) != (topology.face_count(), topology.vertex_count())
            || !self.shows(displaced, coat)
        {
            return Err(Error::invalid("the triangles that are drawn are those of another mesh")
                .advise("give the mesh that is drawn, with colours, vectors and traces if it had some"));
        }
        self.tint = coat.traces.map_or(Tint::default(), |(_, tint)| tint);
        if changed.is_empty() {
            return Ok(());
        }
        self.values.update(context, device, topology, displaced, normals, coat, changed)
    }

    /// Whether it has the channels that these are states of.
    pub(super) fn shows(&self, displaced: &TriangleDisplaced<'_>, coat: TriangleCoat<'_>) -> bool {
        self.values.kind() == Kind::of(displaced, coat)
    }

    /// What its values have.
    pub(super) fn kind(&self) -> Kind {
        self.values.kind()
    }

    /// How its traces tint it.
    pub(super) fn tint(&self) -> Tint {
        self.tint
    }

    /// As finely as values are kept.
    pub fn finest(&self) -> TriangleRates {
        let (faces, edges) = self.values.powers();
        TriangleRates { faces, edges }
    }

    /// Divides faces and edges as `rates` says, but no finer than values are kept; a face is divided where two of its
    /// edges are.
    ///
    /// # Errors
    /// There are not as many rates, or the device fails.
    pub fn divide(&mut self, device: &Device, mut rates: TriangleRates) -> Result<()> {
        let count = self.topology.face_count();
        if (rates.faces.len(), rates.edges.len()) != (count, self.topology.edge_count()) {
            return Err(Error::invalid(format!("{} rates for {count} triangles", rates.faces.len())));
        }
        let most = self.finest();
        let (mine, theirs) = (rates.edges.iter_mut().chain(&mut rates.faces), most.edges.iter().chain(&most.faces));
        mine.zip(theirs).for_each(|(rate, most)| *rate = (*rate).min(*most));
        self.parts.clear();
        for face in 0..count as u32 {
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
        let lowest = |element: usize| self.values.thinning(element).lowest(view, tolerance);
        let (count, edges) = (self.topology.face_count(), self.topology.edge_count());
        let faces: Vec<u8> = (0..count).map(lowest).collect();
        let mut edges: Vec<u8> = (count..count + edges).map(lowest).collect();
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
        let tags: Vec<u32> = (0..self.topology.face_count() as u32).map(tag).collect();
        if tags.iter().any(|tag| *tag >= super::tiles::TAGS) {
            return Err(Error::invalid(format!("tags of faces go up to {}", super::tiles::TAGS - 1)));
        }
        if tags == self.tags {
            return Ok(());
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
        let all = (0..self.topology.face_count()).map(|face| self.values.thinning(face));
        all.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), face| {
            let [a, b] = [face.low, face.high].map(|corner| DVec3::from(corner.map(f64::from)));
            (low.min(a), high.max(b))
        })
    }

    /// What is bound as group 2.
    pub(super) fn buffers(&self) -> [&wgpu::Buffer; 3] {
        let [held, values] = self.values.buffers();
        [held, values, self.drawn.wgpu()]
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
