//! Bézier patches on a device: records of their control points in one of three kinds of memory, maps for as many as a
//! draw takes, and the draws (Concheiro et al. 2013, Sections 3 and 4; `shaders/draw/bezier_draw.wgsl`).

use std::collections::BTreeMap;

use glam::DVec3;
use relievo_core::{Error, Result};
use relievo_gpu::wgsl::bezier_samples::Samples;
use relievo_gpu::{Access, Buffer, Charge, Device, KernelSpec, groups};
use relievo_surface::bezier::{BezierSurface, CONTROLS, Levels, ParametricMap, VirtualVertex};

#[cfg(not(feature = "wgpu"))]
use super::absent::Records;
#[cfg(feature = "wgpu")]
use super::records::Records;

/// Where control points are kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Storage {
    /// In a uniform block, of which every draw sees its own patches (Section 4.1).
    Uniform,
    /// In a texture of floats (Section 4.2).
    Texture,
    /// In a storage buffer.
    Buffer,
}

impl Storage {
    /// All kinds.
    pub const ALL: [Self; 3] = [Self::Uniform, Self::Texture, Self::Buffer];

    /// Its name, as the command line has it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Uniform => "uniform",
            Self::Texture => "texture",
            Self::Buffer => "buffer",
        }
    }

    /// Most patches of a draw.
    pub fn most(self) -> u32 {
        match self {
            Self::Uniform => UNIFORM_PATCHES,
            Self::Texture | Self::Buffer => 1 << 16,
        }
    }
}

/// Patches that a uniform block holds.
pub const UNIFORM_PATCHES: u32 = 16;

/// Vectors of a record: control points, then the edges and the patch's number.
pub(super) const RECORD: usize = CONTROLS + 1;
/// Whole numbers below this are themselves in f32.
const MAX_PATCHES: usize = 1 << 24;

/// A draw of copies of one map.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DrawCall {
    /// The level of the map.
    pub level: u32,
    /// The first of its patches, in the order of records.
    pub first: u32,
    /// How many patches.
    pub count: u32,
    /// Which of the uniform blocks, counted from 0.
    pub block: u32,
    /// The first vertex of the triangles that close gaps beside finer edges of these patches, and how many vertices: none
    /// where levels are uniform.
    pub stitches: [u32; 2],
}

impl DrawCall {
    /// Vertices of its strip.
    ///
    /// # Errors
    /// Fails with `Invalid` if there is no such level, and with `Unsupported` if there are 2³² vertices or more.
    pub fn vertices(&self) -> Result<u32> {
        let vertices = ParametricMap::new(self.level)?.strip_vertices() * u64::from(self.count);
        u32::try_from(vertices).map_err(|_| Error::unsupported("a draw has more vertices than 32 bits count"))
    }
}

/// Patches, maps and draws on a device.
#[derive(Debug)]
pub struct VirtualVertices {
    pub(super) records: Records,
    pub(super) maps: BTreeMap<u32, Buffer<VirtualVertex>>,
    /// Three vertices for every triangle.
    pub(super) stitches: Option<Buffer<VirtualVertex>>,
    _charge: Option<Charge>,
    storage: Storage,
    per_draw: u32,
    rational: bool,
    draws: Vec<DrawCall>,
    order: Vec<u32>,
    bounds: (DVec3, DVec3),
}

impl VirtualVertices {
    /// The patches of `surface` at `levels`, with at most `per_draw` (N_d) in a draw. Patches are sorted by their
    /// level, since a draw has one map.
    ///
    /// # Errors
    /// The levels are those of another surface, the storage has no room for so many patches in a draw, or the device
    /// has no memory.
    pub fn new(
        device: &Device,
        surface: &BezierSurface,
        levels: &Levels,
        storage: Storage,
        per_draw: u32,
    ) -> Result<Self> {
        if levels.count() != surface.count() {
            return Err(Error::invalid(format!("{} levels are given for {} patches", levels.count(), surface.count())));
        }
        if surface.count() >= MAX_PATCHES {
            return Err(Error::unsupported(format!("{} patches are too many to be drawn", surface.count()))
                .advise(format!("draw fewer than {MAX_PATCHES} at a time")));
        }
        if !(1..=storage.most()).contains(&per_draw) {
            return Err(Error::invalid(format!("a draw cannot have {per_draw} patches")).advise(format!(
                "use 1 to {} with the storage `{}`",
                storage.most(),
                storage.name()
            )));
        }
        let mut order: Vec<u32> = (0..surface.count() as u32).collect();
        order.sort_by_key(|patch| levels.patch(*patch as usize));
        let room = stitch_bytes(surface, levels);
        if room > device.limits().max_buffer_size {
            return Err(
                Error::memory(format!("triangles beside finer edges need {room} bytes")).advise("use lower levels")
            );
        }
        let mut draws = Vec::new();
        let mut maps = BTreeMap::new();
        let mut stitches = Vec::new();
        let mut first = 0;
        for run in order.chunk_by(|a, b| levels.patch(*a as usize) == levels.patch(*b as usize)) {
            let level = levels.patch(run[0] as usize);
            let map = ParametricMap::new(level)?;
            for chunk in run.chunks(per_draw as usize) {
                let start = stitches.len();
                for (patch, index) in (0..).zip(chunk) {
                    for (edge, finer) in levels.edges(*index as usize).into_iter().enumerate() {
                        if finer > level {
                            stitches.extend(map.stitched(patch, edge, ParametricMap::new(finer)?));
                        }
                    }
                }
                // A buffer has fewer than 2³² of them.
                let stitches = [start as u32, (stitches.len() - start) as u32];
                draws.push(DrawCall { level, first, count: chunk.len() as u32, block: draws.len() as u32, stitches });
                first += chunk.len() as u32;
            }
            let copies = per_draw.min(run.len() as u32);
            let bytes = map.strip_bytes(u64::from(copies));
            if bytes > device.limits().max_buffer_size {
                return Err(Error::memory(format!("{copies} copies of the map of level {level} need {bytes} bytes"))
                    .advise("put fewer patches in a draw, or use lower levels"));
            }
            maps.insert(level, Buffer::of(device, "parametric map", &map.vertices(copies))?);
        }
        let stitches = if stitches.is_empty() { None } else { Some(Buffer::of(device, "stitches", &stitches)?) };
        let records = packed(surface, &order);
        let (records, charge) = Records::new(device, storage, records, &draws, per_draw)?;
        let rational = surface.is_rational();
        let (low, high) = surface.total_bounds();
        let bounds = [low, high].map(|corner| DVec3::from(corner.map(f64::from))).into();
        Ok(Self { records, maps, stitches, _charge: charge, storage, per_draw, rational, draws, order, bounds })
    }

    /// Where the control points are.
    pub fn storage(&self) -> Storage {
        self.storage
    }

    /// The draws, whose number is N_DP.
    pub fn draws(&self) -> &[DrawCall] {
        &self.draws
    }

    /// Patches by the order of records.
    pub fn order(&self) -> &[u32] {
        &self.order
    }

    /// Smallest and largest coordinates.
    pub(super) fn bounds(&self) -> (DVec3, DVec3) {
        self.bounds
    }

    pub(super) fn is_rational(&self) -> bool {
        self.rational
    }

    /// Patches that a draw takes at most.
    pub(super) fn per_draw(&self) -> u32 {
        self.per_draw
    }

    /// Points and normals of all vertices of `draw`'s strip, then of its triangles beside finer edges, computed by a kernel
    /// as the vertex stage does: what tests read.
    ///
    /// # Errors
    /// The control points are not in a storage buffer, or the device fails.
    pub fn samples(&self, device: &Device, draw: &DrawCall) -> Result<Vec<[[f32; 4]; 2]>> {
        let (Records::Buffer(records), Some(map)) = (&self.records, self.maps.get(&draw.level)) else {
            return Err(Error::unsupported("samples are read from patches in a storage buffer"));
        };
        let constants = [("RATIONAL", f64::from(u8::from(self.rational)))];
        let kernel = device.kernel(&KernelSpec {
            module: "bezier_samples",
            entry: "evaluate",
            groups: &[&[Access::Read, Access::Read, Access::Write]],
            immediates: size_of::<Samples>() as u32,
            constants: &constants,
        })?;
        let mut all = Vec::new();
        let [start, more] = draw.stitches;
        let lists = [(Some(map), 0, draw.vertices()?), (self.stitches.as_ref(), start, more)];
        for (vertices, start, count) in lists {
            let Some(vertices) = vertices.filter(|_| count > 0) else { continue };
            let out = Buffer::<[[f32; 4]; 2]>::new(device, "samples", count as usize)?;
            let bindings = device.bind(&kernel, 0, &[records.wgpu(), vertices.wgpu(), out.wgpu()])?;
            let mut frame = device.frame()?;
            let samples = Samples { count, start, first: draw.first };
            let groups = groups(count.div_ceil(64));
            frame.pass("samples").run(&kernel, &[&bindings], bytemuck::bytes_of(&samples), groups)?;
            let read = frame.read(&out, 0..count as usize)?;
            let _submitted = frame.submit()?;
            all.extend(read.get(device)?);
        }
        Ok(all)
    }
}

/// Bytes of the triangles that close gaps beside finer edges.
fn stitch_bytes(surface: &BezierSurface, levels: &Levels) -> u64 {
    let segments = |level: u32| (2u64 << level) - 1;
    let of = |patch: usize| {
        let level = levels.patch(patch);
        let finer = levels.edges(patch).into_iter().filter(move |edge| *edge > level);
        finer.map(move |edge| 3 * (segments(edge) + segments(level) - 2)).sum::<u64>()
    };
    (0..surface.count()).map(of).sum::<u64>() * size_of::<VirtualVertex>() as u64
}

/// The records of patches in `order`.
fn packed(surface: &BezierSurface, order: &[u32]) -> Vec<[f32; 4]> {
    let mut records = Vec::with_capacity(order.len() * RECORD);
    for patch in order {
        let index = *patch as usize;
        records.extend_from_slice(surface.controls(index));
        let senses = surface.edges().senses(index);
        let edges = (0..4).fold(0u32, |bits, edge| bits | (senses[edge] as u32) << (2 * edge));
        // As numbers and not as bits, which loads may flush; below 2²⁴ they are themselves.
        records.push([edges as f32, *patch as f32, 0.0, 0.0]);
    }
    records
}
