//! Bézier patches on a device: records of their control points in one of three kinds of memory, maps for as many as a
//! draw takes, and the draws (Concheiro et al. 2013, Sections 3 and 4; `shaders/bezier_draw.wgsl`).

use std::collections::BTreeMap;

use glam::DVec3;
use relievo_core::{Error, Result};
use relievo_gpu::{Access, Buffer, Charge, Device, KernelSpec, groups, wgpu};
use relievo_surface::bezier::{BezierSurface, CONTROLS, Levels, ParametricMap, VirtualVertex};

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
const RECORD: usize = CONTROLS + 1;
/// Bytes of a record.
const RECORD_BYTES: u64 = RECORD as u64 * 16;
/// Patches of a row of the texture.
const TEXTURE_ROW: u32 = 120;
/// Whole numbers below this are themselves in f32.
const MOST_PATCHES: usize = 1 << 24;

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
    pub fn vertices(&self) -> Result<u32> {
        let vertices = ParametricMap::new(self.level)?.strip_vertices() * u64::from(self.count);
        u32::try_from(vertices).map_err(|_| Error::unsupported("a draw has more vertices than 32 bits count"))
    }
}

/// What holds the records.
#[derive(Debug)]
pub(super) enum Records {
    Uniform(wgpu::Buffer),
    Texture(wgpu::Texture),
    Buffer(Buffer<[f32; 4]>),
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
        if surface.count() >= MOST_PATCHES {
            return Err(Error::unsupported(format!("{} patches are too many to be drawn", surface.count()))
                .advise(format!("draw fewer than {MOST_PATCHES} at a time")));
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
        let (records, charge) = match storage {
            Storage::Uniform => {
                let (buffer, charge) = uniform_blocks(device, &records, &draws, per_draw)?;
                (Records::Uniform(buffer), Some(charge))
            }
            Storage::Texture => {
                let (texture, charge) = texture(device, records)?;
                (Records::Texture(texture), Some(charge))
            }
            Storage::Buffer => (Records::Buffer(Buffer::of(device, "patches", &records)?), None),
        };
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

    /// Bytes from one uniform block to the next.
    pub(super) fn block_stride(&self) -> u64 {
        block_stride(self.per_draw)
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
            immediates: 12,
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
            let immediates = [count, start, draw.first];
            let groups = groups(count.div_ceil(64));
            frame.pass("samples").run(&kernel, &[&bindings], bytemuck::bytes_of(&immediates), groups)?;
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

fn block_stride(per_draw: u32) -> u64 {
    // What dynamic offsets are aligned to on every device.
    (u64::from(per_draw) * RECORD_BYTES).next_multiple_of(256)
}

fn uniform_blocks(
    device: &Device,
    records: &[[f32; 4]],
    draws: &[DrawCall],
    per_draw: u32,
) -> Result<(wgpu::Buffer, Charge)> {
    let stride = block_stride(per_draw);
    // A binding is as long as the block in the shader, also at the last draw.
    let size = stride * draws.len().saturating_sub(1) as u64 + u64::from(UNIFORM_PATCHES) * RECORD_BYTES;
    let charge = device.charge(size)?;
    let mut bytes = vec![0u8; size as usize];
    for draw in draws {
        let from = draw.first as usize * RECORD..(draw.first + draw.count) as usize * RECORD;
        let source: &[u8] = bytemuck::cast_slice(&records[from]);
        let start = (stride * u64::from(draw.block)) as usize;
        bytes[start..start + source.len()].copy_from_slice(source);
    }
    let buffer = device.guard(|| {
        let buffer = device.wgpu().create_buffer(&wgpu::BufferDescriptor {
            label: Some("patches"),
            size,
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        device.queue().write_buffer(&buffer, 0, &bytes);
        buffer
    })?;
    Ok((buffer, charge))
}

fn texture(device: &Device, mut records: Vec<[f32; 4]>) -> Result<(wgpu::Texture, Charge)> {
    let width = TEXTURE_ROW * RECORD as u32;
    let rows = (records.len() as u32).div_ceil(width);
    let most = device.limits().max_texture_dimension_2d;
    if width > most || rows > most {
        return Err(Error::unsupported(format!("a texture of {width}×{rows} texels is too large for the device"))
            .advise("use the storage `buffer`"));
    }
    records.resize(rows as usize * width as usize, [0.0; 4]);
    let charge = device.charge(records.len() as u64 * 16)?;
    let size = wgpu::Extent3d { width, height: rows, depth_or_array_layers: 1 };
    let texture = device.guard(|| {
        let texture = device.wgpu().create_texture(&wgpu::TextureDescriptor {
            label: Some("patches"),
            size,
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: wgpu::TextureFormat::Rgba32Float,
            usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
            view_formats: &[],
        });
        let layout =
            wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(16 * width), rows_per_image: Some(rows) };
        device.queue().write_texture(texture.as_image_copy(), bytemuck::cast_slice(&records), layout, size);
        texture
    })?;
    Ok((texture, charge))
}
