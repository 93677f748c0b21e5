//! Color buffers: colours of details with their mips on a graphics device, and the objects behind them; see
//! `include/relievo/color_buffer.h`.

use std::ffi::c_void;
use std::sync::{Arc, RwLock};

use relievo_core::Result;
use relievo_gpu::{Device, wgpu};
use relievo_tiles::{ByFormat, ColorTexel, DeviceMips, DeviceRing, DeviceTiles, Field, Rgba8, Rgba16, by_format};

use crate::border::array::{Output, present, put};
use crate::border::descriptor::{check_optional, write_descriptor, write_optional};
use crate::border::registry::{self, handle, try_read, try_write};
use crate::details::detail::{DetailObject, RLV_CHANNEL_COLOR, RLV_COLOR_RGBA8, RLV_COLOR_RGBA16F, RlvDetail, missing};
use crate::details::view::{View, ViewKind};
use crate::runtime::buffer::{objects, settle, vulkan_objects};
use crate::surfaces::shape::only_cages;

handle!(RlvColorBuffer, 18, ColorBufferObject);

descriptor! {
    pub struct RlvColorBufferInfo {
        struct_size: u32,
        rebuilt: u32,
        format: u32,
        reserved: u32,
        tile_count: usize,
        allocated_count: usize,
        written_count: usize,
        bytes: u64,
        color: [f32; 4],
    }
}

vulkan_objects! {
    pub struct RlvColorBufferVulkan {
        tiles: u64,
        texels: u64,
        mip_firsts: u64,
        mips: u64,
    }
}

/// Colours on the device.
struct Colors<T: ColorTexel> {
    ring: DeviceRing,
    tiles: DeviceTiles<T>,
    mips: DeviceMips<T>,
}

/// What is on the device.
struct Uploaded {
    colors: ByFormat<Colors<Rgba8>, Colors<Rgba16>>,
    rebuilt: bool,
    written: usize,
}

pub struct ColorBufferObject {
    device: Device,
    detail: Arc<DetailObject>,
    uploaded: RwLock<Uploaded>,
}

/// What of the committed colours is looked at.
type Seen<'a> = ByFormat<&'a Field<Rgba8>, &'a Field<Rgba16>>;

/// The colours of `view`; fails without colours that a device has in tiles.
fn colors_of(view: &View) -> Result<Seen<'_>> {
    let ViewKind::Tiles(tiles) = &view.layers else { return Err(only_cages("colours in tiles on a device")) };
    match &tiles.paint {
        Some(ByFormat::Rgba8(paint)) => Ok(ByFormat::Rgba8(paint.field())),
        Some(ByFormat::Rgba16(paint)) => Ok(ByFormat::Rgba16(paint.field())),
        None => Err(missing(RLV_CHANNEL_COLOR)),
    }
}

impl<T: ColorTexel> Colors<T> {
    fn new(device: &Device, field: &Field<T>) -> Result<Self> {
        let ring = DeviceRing::new(device, field.topology())?;
        let tiles = DeviceTiles::new(device, field)?;
        let mips = DeviceMips::new(device, &ring, &tiles)?;
        Ok(Self { ring, tiles, mips })
    }

    /// Returns how many tiles were written or freed.
    fn update(&mut self, device: &Device, field: &Field<T>) -> Result<usize> {
        let changed = self.tiles.update(device, field)?;
        self.mips.update(device, &self.ring, &self.tiles)?;
        Ok(changed.len())
    }

    /// In the order of [`RlvColorBufferVulkan`].
    fn buffers(&self) -> [&wgpu::Buffer; 4] {
        let ([tiles, texels], [firsts, mips]) = (self.tiles.buffers(), self.mips.buffers());
        [tiles, texels, firsts, mips]
    }

    fn block(&self, device: &Device, tile: u32, level: u32) -> Result<Option<Vec<u8>>> {
        let texels = match level {
            0 => self.tiles.read(device, tile)?,
            _ => self.mips.read(device, tile, level)?,
        };
        Ok(texels.map(|texels| bytemuck::cast_slice(&texels).to_vec()))
    }
}

impl Uploaded {
    fn new(device: &Device, seen: Seen<'_>) -> Result<Self> {
        let colors = match seen {
            ByFormat::Rgba8(field) => ByFormat::Rgba8(Colors::new(device, field)?),
            ByFormat::Rgba16(field) => ByFormat::Rgba16(Colors::new(device, field)?),
        };
        settle(device)?;
        let written = by_format!(seen, field => field.allocated().count());
        Ok(Self { colors, rebuilt: true, written })
    }

    fn update(&mut self, device: &Device, seen: Seen<'_>) -> Result<()> {
        let before = self.buffers().map(wgpu::Buffer::clone);
        let written = match (&mut self.colors, seen) {
            (ByFormat::Rgba8(colors), ByFormat::Rgba8(field)) => colors.update(device, field),
            (ByFormat::Rgba16(colors), ByFormat::Rgba16(field)) => colors.update(device, field),
            // Colours of the other format are others.
            (_, seen) => {
                *self = Self::new(device, seen)?;
                return Ok(());
            }
        }?;
        settle(device)?;
        self.written = written;
        self.rebuilt = self.buffers() != before.each_ref();
        Ok(())
    }

    fn buffers(&self) -> [&wgpu::Buffer; 4] {
        by_format!(&self.colors, colors => colors.buffers())
    }

    fn info(&self) -> RlvColorBufferInfo {
        let (count, allocated, color) = by_format!(&self.colors, colors => {
            let field = colors.tiles.field();
            (field.tile_count(), field.allocated().count(), field.blank().color())
        });
        RlvColorBufferInfo {
            struct_size: 0,
            rebuilt: u32::from(self.rebuilt),
            format: if matches!(self.colors, ByFormat::Rgba8(_)) { RLV_COLOR_RGBA8 } else { RLV_COLOR_RGBA16F },
            reserved: 0,
            tile_count: count,
            allocated_count: allocated,
            written_count: self.written,
            bytes: self.buffers().into_iter().map(wgpu::Buffer::size).sum(),
            color: color.to_array(),
        }
    }
}

entry! {
    fn rlv_color_buffer_create(detail: RlvDetail, out: *mut RlvColorBuffer) {
        present("out", out)?;
        let detail = registry::get(detail)?;
        let device = detail.context.opened_device()?.clone();
        let uploaded = Uploaded::new(&device, colors_of(&detail.view())?)?;
        let handle = registry::insert(ColorBufferObject { device, detail, uploaded: RwLock::new(uploaded) })?;
        // SAFETY: checked above.
        unsafe { put(out, handle) };
        Ok(())
    }

    fn rlv_color_buffer_retain(buffer: RlvColorBuffer) {
        registry::retain(buffer)
    }

    fn rlv_color_buffer_release(buffer: RlvColorBuffer) {
        registry::release(buffer)
    }

    fn rlv_color_buffer_update(buffer: RlvColorBuffer, out: *mut RlvColorBufferInfo) {
        let object = registry::get(buffer)?;
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        unsafe { check_optional(out) }?;
        let mut uploaded = try_write(&object.uploaded, "color buffer")?;
        uploaded.update(&object.device, colors_of(&object.detail.view())?)?;
        // SAFETY: as above.
        unsafe { write_optional(out, uploaded.info()) }
    }

    fn rlv_color_buffer_info(buffer: RlvColorBuffer, out: *mut RlvColorBufferInfo) {
        let object = registry::get(buffer)?;
        let info = try_read(&object.uploaded, "color buffer")?.info();
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        unsafe { write_descriptor(out, info) }
    }

    fn rlv_color_buffer_vulkan(buffer: RlvColorBuffer, out: *mut RlvColorBufferVulkan) {
        let object = registry::get(buffer)?;
        object.device.check()?;
        let advice = "copy the texels with rlv_color_buffer_read or rlv_detail_read_block";
        let found = objects(&object.device, try_read(&object.uploaded, "color buffer")?.buffers(), "buffer", advice)?;
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        unsafe { write_descriptor(out, RlvColorBufferVulkan::of(found)) }
    }

    fn rlv_color_buffer_read(
        buffer: RlvColorBuffer,
        tile: u32,
        level: u32,
        bytes: *mut c_void,
        capacity: usize,
        size: *mut usize,
    ) {
        present("size", size)?;
        let object = registry::get(buffer)?;
        object.detail.view().shape().check_tile(tile)?;
        let uploaded = try_read(&object.uploaded, "color buffer")?;
        let block = by_format!(&uploaded.colors, colors => colors.block(&object.device, tile, level))?;
        let block = block.unwrap_or_default();
        // SAFETY: checked above.
        unsafe { put(size, block.len()) };
        // SAFETY: the caller promises `capacity` bytes, or NULL to ask for the size alone.
        if let Some(out) = unsafe { Output::<u8>::optional("bytes", bytes.cast(), capacity, 0) }? {
            out.holds("bytes", block.len())?.fill(block.iter().copied());
        }
        Ok(())
    }
}
