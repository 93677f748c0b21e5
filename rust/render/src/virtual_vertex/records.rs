//! The records of Bézier patches in each of three kinds of memory (Concheiro et al. 2013, Section 4).

use relievo_core::{Error, Result};
use relievo_gpu::{Buffer, Charge, Device, wgpu};

use super::patches::{DrawCall, RECORD, Storage, UNIFORM_PATCHES};

/// Bytes of a record.
const RECORD_BYTES: u64 = RECORD as u64 * 16;
/// Patches of a row of the texture.
const TEXTURE_ROW: u32 = 120;

/// What holds the records.
#[derive(Debug)]
pub(super) enum Records {
    Uniform(wgpu::Buffer),
    Texture(wgpu::Texture),
    Buffer(Buffer<[f32; 4]>),
}

impl Records {
    /// Writes `records`, of which every draw takes at most `per_draw`, to the memory that `storage` names.
    ///
    /// # Errors
    /// The device has no room.
    pub fn new(
        device: &Device,
        storage: Storage,
        records: Vec<[f32; 4]>,
        draws: &[DrawCall],
        per_draw: u32,
    ) -> Result<(Self, Option<Charge>)> {
        Ok(match storage {
            Storage::Uniform => {
                let (buffer, charge) = uniform_blocks(device, &records, draws, per_draw)?;
                (Self::Uniform(buffer), Some(charge))
            }
            Storage::Texture => {
                let (texture, charge) = texture(device, records)?;
                (Self::Texture(texture), Some(charge))
            }
            Storage::Buffer => (Self::Buffer(Buffer::of(device, "patches", &records)?), None),
        })
    }
}

/// Returns the bytes from one uniform block to the next.
pub(super) fn block_stride(per_draw: u32) -> u64 {
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
