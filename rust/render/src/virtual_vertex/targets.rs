//! Textures that pictures and shadow maps are drawn into.

use relievo_core::{Error, Result};
use relievo_gpu::{Buffer, Charge, Device, wgpu};

/// Pixels of a picture's side at most.
const MAX_SIDE: u32 = 16_384;
/// Texels along a side of a shadow map.
pub(super) const SHADOW_SIDE: u32 = 2048;

const WIDE: wgpu::TextureFormat = wgpu::TextureFormat::Rgba32Float;
const NUMBER: wgpu::TextureFormat = wgpu::TextureFormat::R32Uint;
const HALF: wgpu::TextureFormat = wgpu::TextureFormat::Rgba16Float;
pub(super) const DEPTH: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;
/// What is drawn at once: colours, normals with depths, numbers, reflectances.
pub(super) const FORMATS: [wgpu::TextureFormat; 4] = [WIDE, WIDE, NUMBER, HALF];
/// What a pixel of them takes.
pub(super) const PIXEL_BYTES: u32 = 44;

/// Which of the targets.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Target {
    Color,
    Geometry,
    Number,
    Albedo,
}

impl Target {
    /// Words of a pixel.
    fn words(self) -> u32 {
        match self {
            Self::Color | Self::Geometry => 4,
            Self::Number => 1,
            Self::Albedo => 2,
        }
    }
}

/// What a picture is drawn into.
#[derive(Debug)]
pub(super) struct Targets {
    pub size: [u32; 2],
    textures: [wgpu::Texture; 4],
    depth: wgpu::Texture,
    _charge: Charge,
}

fn texture(
    device: &Device,
    label: &str,
    [width, height, layers]: [u32; 3],
    format: wgpu::TextureFormat,
    usage: wgpu::TextureUsages,
) -> Result<wgpu::Texture> {
    device.guard(|| {
        device.wgpu().create_texture(&wgpu::TextureDescriptor {
            label: Some(label),
            size: wgpu::Extent3d { width, height, depth_or_array_layers: layers },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT | usage,
            view_formats: &[],
        })
    })
}

impl Targets {
    /// Of a picture of `size` pixels.
    pub fn new(device: &Device, size: [u32; 2]) -> Result<Self> {
        let [width, height] = size;
        let most = device.limits().max_texture_dimension_2d.min(MAX_SIDE);
        if width == 0 || height == 0 || width.max(height) > most {
            return Err(Error::unsupported(format!("a picture of {width}×{height} pixels cannot be drawn"))
                .advise(format!("use up to {most} pixels a side, or fewer samples a pixel")));
        }
        let charge = device.charge(u64::from(width) * u64::from(height) * u64::from(PIXEL_BYTES + 4))?;
        let of = |label, format, usage| texture(device, label, [width, height, 1], format, usage);
        let copied = wgpu::TextureUsages::COPY_SRC;
        let [color, geometry, number, albedo] = FORMATS;
        let textures = [
            of("colours", color, copied)?,
            of("normals and depths", geometry, copied)?,
            of("numbers", number, copied)?,
            of("reflectances", albedo, copied)?,
        ];
        Ok(Self { size, textures, depth: of("depth", DEPTH, copied)?, _charge: charge })
    }

    /// Views of the four targets and of the depths.
    pub fn views(&self) -> ([wgpu::TextureView; 4], wgpu::TextureView) {
        let view = |texture: &wgpu::Texture| texture.create_view(&wgpu::TextureViewDescriptor::default());
        (self.textures.each_ref().map(view), view(&self.depth))
    }

    /// The words of a target, row by row.
    pub fn read(&self, device: &Device, target: Target) -> Result<Vec<u32>> {
        let [width, height] = self.size;
        let words = target.words();
        let row = (width * words).next_multiple_of(64);
        let buffer = Buffer::<u32>::new(device, "picture", row as usize * height as usize)?;
        let mut frame = device.frame()?;
        let layout =
            wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(4 * row), rows_per_image: Some(height) };
        frame.encoder().copy_texture_to_buffer(
            self.textures[target as usize].as_image_copy(),
            wgpu::TexelCopyBufferInfo { buffer: buffer.wgpu(), layout },
            wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        );
        let read = frame.read(&buffer, 0..buffer.len())?;
        let _submitted = frame.submit()?;
        let padded = read.get(device)?;
        Ok(padded.chunks_exact(row as usize).flat_map(|line| &line[..(width * words) as usize]).copied().collect())
    }
}

/// Shadow maps of suns, a layer each.
#[derive(Debug)]
pub(super) struct ShadowMaps {
    texture: wgpu::Texture,
    layers: u32,
    _charge: Charge,
}

impl ShadowMaps {
    /// Of `suns` suns; one texel without suns, since something must be bound.
    pub fn new(device: &Device, suns: u32) -> Result<Self> {
        let (side, layers) = if suns > 0 { (SHADOW_SIDE, suns) } else { (1, 1) };
        let charge = device.charge(4 * u64::from(side) * u64::from(side) * u64::from(layers))?;
        let usage = wgpu::TextureUsages::TEXTURE_BINDING;
        Ok(Self {
            texture: texture(device, "shadows", [side, side, layers], DEPTH, usage)?,
            layers: suns,
            _charge: charge,
        })
    }

    /// How many suns have one.
    pub fn suns(&self) -> u32 {
        self.layers
    }

    /// All layers, to look up.
    pub fn view(&self) -> wgpu::TextureView {
        self.texture.create_view(&wgpu::TextureViewDescriptor {
            dimension: Some(wgpu::TextureViewDimension::D2Array),
            ..wgpu::TextureViewDescriptor::default()
        })
    }

    /// The layer of a sun, to draw into.
    pub fn layer(&self, sun: u32) -> wgpu::TextureView {
        self.texture.create_view(&wgpu::TextureViewDescriptor {
            dimension: Some(wgpu::TextureViewDimension::D2),
            base_array_layer: sun,
            array_layer_count: Some(1),
            ..wgpu::TextureViewDescriptor::default()
        })
    }
}
