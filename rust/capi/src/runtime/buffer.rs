//! Buffers: triangles of tessellations on a graphics device, and the objects behind them; see `include/relievo/buffer.h`.

use std::sync::{Arc, RwLock};

use relievo_core::{Error, Result};
use relievo_gpu::{Buffer, Device, wgpu};

use crate::border::array::{Output, present, put};
use crate::border::descriptor::{check_optional, write_descriptor, write_optional};
use crate::border::registry::{self, handle, try_read, try_write};
use crate::surfaces::tessellate::{RlvTessellation, TessellationObject, Vertices};

handle!(RlvBuffer, 15, BufferObject);

descriptor! {
    pub struct RlvBufferInfo {
        struct_size: u32,
        rebuilt: u32,
        point_count: usize,
        triangle_count: usize,
        written_count: usize,
        bytes: u64,
    }
}

/// Defines the descriptor of a noun's Vulkan objects: those of the device, and then its buffers.
macro_rules! vulkan_objects {
    (pub struct $name:ident { $($buffer:ident: u64,)* }) => {
        descriptor! {
            pub struct $name {
                struct_size: u32,
                queue_family: u32,
                queue_index: u32,
                reserved: u32,
                instance: u64,
                physical_device: u64,
                device: u64,
                queue: u64,
                $($buffer: u64,)*
            }
        }

        impl $name {
            /// Those of `found`, whose buffers are in the order of the fields.
            fn of(found: $crate::runtime::buffer::Objects<{ [$(stringify!($buffer)),*].len() }>) -> Self {
                let [$($buffer),*] = found.buffers;
                Self {
                    struct_size: 0,
                    queue_family: found.queue_family,
                    queue_index: found.queue_index,
                    reserved: 0,
                    instance: found.instance,
                    physical_device: found.physical_device,
                    device: found.device,
                    queue: found.queue,
                    $($buffer,)*
                }
            }
        }
    };
}

pub(crate) use vulkan_objects;

vulkan_objects! {
    pub struct RlvBufferVulkan {
        points: u64,
        triangles: u64,
    }
}

/// Points between two ranges that are written with them: fewer writes take less time than a few more bytes.
const GAP: u32 = 128;

/// Position and unit normal.
type Point = [f32; 6];

/// What is on the device.
struct Uploaded {
    points: Buffer<Point>,
    triangles: Buffer<u32>,
    /// Whether the buffers are the host's, which may be larger than needed.
    lent: bool,
    /// Points, and numbers of points of triangles.
    counts: [usize; 2],
    /// Which update of the tessellation it is of; `None` before the first.
    serial: Option<u64>,
    rebuilt: bool,
    written: usize,
}

pub struct BufferObject {
    device: Device,
    tessellation: Arc<TessellationObject>,
    uploaded: RwLock<Uploaded>,
}

fn point_of(position: &[f32; 3], normal: &[f32; 3]) -> Point {
    let ([x, y, z], [a, b, c]) = (*position, *normal);
    [x, y, z, a, b, c]
}

/// Waits until what was written has arrived.
///
/// # Errors
/// Fails with `Device` if the device was lost, and with `Internal` if it refuses a command.
pub fn settle(device: &Device) -> Result<()> {
    device.frame()?.submit()?.wait().map(drop)
}

/// Fails if a buffer of the host that holds `len` items is too small for `count`.
fn fits(name: &str, len: usize, count: usize, size: usize) -> Result<()> {
    if count > len {
        return Err(Error::memory(format!("the tessellation needs {} bytes there", count * size))
            .at(name)
            .advise("make a larger VkBuffer, and a buffer on it with rlv_vulkan_create_buffer"));
    }
    Ok(())
}

impl Uploaded {
    fn new(device: &Device, vertices: &Vertices<'_>) -> Result<Self> {
        let counts = [vertices.points.len(), vertices.corners.len()];
        let points = Buffer::new(device, "points of a tessellation", counts[0])?;
        let triangles = Buffer::new(device, "triangles of a tessellation", counts[1])?;
        let mut made = Self::of(points, triangles, false);
        made.fill(device, vertices)?;
        Ok(made)
    }

    fn of(points: Buffer<Point>, triangles: Buffer<u32>, lent: bool) -> Self {
        Self { points, triangles, lent, counts: [0; 2], serial: None, rebuilt: true, written: 0 }
    }

    /// Writes all points and triangles.
    fn fill(&mut self, device: &Device, vertices: &Vertices<'_>) -> Result<()> {
        fits("point_bytes", self.points.len(), vertices.points.len(), size_of::<Point>())?;
        fits("triangle_bytes", self.triangles.len(), vertices.corners.len(), size_of::<u32>())?;
        let made: Vec<Point> = vertices.points.iter().zip(vertices.normals).map(|(p, n)| point_of(p, n)).collect();
        self.points.write(device, 0, &made)?;
        self.triangles.write(device, 0, vertices.corners)?;
        settle(device)?;
        self.counts = [made.len(), vertices.corners.len()];
        (self.serial, self.rebuilt, self.written) = (Some(vertices.serial), true, made.len());
        Ok(())
    }

    fn update(&mut self, device: &Device, vertices: &Vertices<'_>) -> Result<()> {
        let same = [vertices.points.len(), vertices.corners.len()] == self.counts;
        if self.serial == Some(vertices.serial) {
            (self.rebuilt, self.written) = (false, 0);
            return device.check();
        }
        let Some(serial) = self.serial.filter(|serial| same && !vertices.rebuilt_since(*serial)) else {
            if self.lent {
                return self.fill(device, vertices);
            }
            *self = Self::new(device, vertices)?;
            return Ok(());
        };
        (self.rebuilt, self.written) = (false, 0);
        let all = [[0, vertices.points.len() as u32]];
        let ranges = if vertices.serial == serial + 1 { vertices.ranges } else { &all };
        let mut room = Vec::new();
        for run in ranges.chunk_by(|[first, count], [next, _]| next - (first + count) <= GAP) {
            let ([first, _], [last, count]) = (run[0], run[run.len() - 1]);
            let range = first as usize..(last + count) as usize;
            room.clear();
            room.extend(
                vertices.points[range.clone()].iter().zip(&vertices.normals[range]).map(|(p, n)| point_of(p, n)),
            );
            self.points.write(device, first as usize, &room)?;
            self.written += room.len();
        }
        settle(device)?;
        self.serial = Some(vertices.serial);
        Ok(())
    }

    fn info(&self) -> RlvBufferInfo {
        RlvBufferInfo {
            struct_size: 0,
            rebuilt: u32::from(self.rebuilt),
            point_count: self.counts[0],
            triangle_count: self.counts[1] / 3,
            written_count: self.written,
            bytes: (self.counts[0] * size_of::<Point>() + self.counts[1] * size_of::<u32>()) as u64,
        }
    }
}

/// Buffers of the host, each with its bytes, that follow a tessellation: points, then triangles.
///
/// # Errors
/// Fails with `Unsupported` if the context has no graphics device or one that is not reached through Vulkan, with
/// `Invalid` if a buffer is NULL or without an item, with `Memory` if one is too small for the tessellation, with
/// `Busy` while that changes, and with `Device` if the device was lost.
///
/// # Safety
/// They are buffers of the context's device as the header says.
pub unsafe fn on_host(tessellation: Arc<TessellationObject>, places: [(u64, u64); 2]) -> Result<BufferObject> {
    let device = tessellation.context().opened_device()?.clone();
    let [points, triangles] = places;
    // SAFETY: promised by the caller.
    let (points, triangles) = unsafe {
        (
            Buffer::import(&device, "points", points.0, points.1)?,
            Buffer::import(&device, "triangles", triangles.0, triangles.1)?,
        )
    };
    let mut uploaded = Uploaded::of(points, triangles, true);
    tessellation.with_vertices(|vertices| uploaded.fill(&device, vertices))?;
    Ok(BufferObject { device, tessellation, uploaded: RwLock::new(uploaded) })
}

/// Vulkan's objects of a device, as numbers, and some buffers there.
pub struct Objects<const N: usize> {
    pub queue_family: u32,
    pub queue_index: u32,
    pub instance: u64,
    pub physical_device: u64,
    pub device: u64,
    pub queue: u64,
    pub buffers: [u64; N],
}

/// Returns those of `buffers`.
///
/// # Errors
/// Fails with `Unsupported` at `place`, and with `advice`, where the device is reached by another interface.
pub fn objects<const N: usize>(
    device: &Device,
    buffers: [&wgpu::Buffer; N],
    place: &str,
    advice: &str,
) -> Result<Objects<N>> {
    handed_out(device, buffers).ok_or_else(|| {
        Error::unsupported(format!("{} hands out no Vulkan objects", device.summary())).at(place).advise(advice)
    })
}

#[cfg(all(feature = "wgpu", not(target_vendor = "apple")))]
fn handed_out<const N: usize>(device: &Device, buffers: [&wgpu::Buffer; N]) -> Option<Objects<N>> {
    use ash::vk::Handle;
    use relievo_gpu::wgpu::hal::api::Vulkan;

    let mut handles = [0; N];
    // SAFETY: nothing that is reached through these is destroyed here, and the guards end with the function; what the
    // host may do with the handles is said in the header.
    unsafe {
        for (handle, buffer) in handles.iter_mut().zip(buffers) {
            *handle = buffer.as_hal::<Vulkan>()?.raw_handle().as_raw();
        }
        let hal = device.wgpu().as_hal::<Vulkan>()?;
        Some(Objects {
            queue_family: hal.queue_family_index(),
            queue_index: hal.queue_index(),
            instance: hal.shared_instance().raw_instance().handle().as_raw(),
            physical_device: hal.raw_physical_device().as_raw(),
            device: hal.raw_device().handle().as_raw(),
            queue: hal.raw_queue().as_raw(),
            buffers: handles,
        })
    }
}

#[cfg(not(all(feature = "wgpu", not(target_vendor = "apple"))))]
fn handed_out<const N: usize>(_: &Device, _: [&wgpu::Buffer; N]) -> Option<Objects<N>> {
    None
}

entry! {
    fn rlv_buffer_create(tessellation: RlvTessellation, out: *mut RlvBuffer) {
        present("out", out)?;
        let tessellation = registry::get(tessellation)?;
        let device = tessellation.context().opened_device()?.clone();
        let uploaded = tessellation.with_vertices(|vertices| Uploaded::new(&device, vertices))?;
        let handle = registry::insert(BufferObject { device, tessellation, uploaded: RwLock::new(uploaded) })?;
        // SAFETY: checked above.
        unsafe { put(out, handle) };
        Ok(())
    }

    fn rlv_buffer_retain(buffer: RlvBuffer) {
        registry::retain(buffer)
    }

    fn rlv_buffer_release(buffer: RlvBuffer) {
        registry::release(buffer)
    }

    fn rlv_buffer_update(buffer: RlvBuffer, out: *mut RlvBufferInfo) {
        let object = registry::get(buffer)?;
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        unsafe { check_optional(out) }?;
        let mut uploaded = try_write(&object.uploaded, "buffer")?;
        object.tessellation.with_vertices(|vertices| uploaded.update(&object.device, vertices))?;
        // SAFETY: as above.
        unsafe { write_optional(out, uploaded.info()) }
    }

    fn rlv_buffer_info(buffer: RlvBuffer, out: *mut RlvBufferInfo) {
        let object = registry::get(buffer)?;
        let info = try_read(&object.uploaded, "buffer")?.info();
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        unsafe { write_descriptor(out, info) }
    }

    fn rlv_buffer_vulkan(buffer: RlvBuffer, out: *mut RlvBufferVulkan) {
        let object = registry::get(buffer)?;
        object.device.check()?;
        let uploaded = try_read(&object.uploaded, "buffer")?;
        let buffers = [uploaded.points.wgpu(), uploaded.triangles.wgpu()];
        let advice = "copy the points with rlv_buffer_read or rlv_tessellation_get_points";
        let found = objects(&object.device, buffers, "buffer", advice)?;
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        unsafe { write_descriptor(out, RlvBufferVulkan::of(found)) }
    }

    fn rlv_buffer_read(buffer: RlvBuffer, first: usize, count: usize, points: *mut f32, stride: usize) {
        let object = registry::get(buffer)?;
        // SAFETY: the caller promises room for `count` points.
        let out = unsafe { Output::<[f32; 6]>::new("points", points.cast(), count, stride) }?;
        let uploaded = try_read(&object.uploaded, "buffer")?;
        let len = uploaded.counts[0];
        let end = first.checked_add(count).filter(|end| *end <= len).ok_or_else(|| {
            Error::invalid(format!("there are {len} points, not {count} from {first} on")).at("count")
        })?;
        let mut frame = object.device.frame()?;
        let read = frame.read(&uploaded.points, first..end)?;
        let _ = frame.submit()?;
        out.fill(read.get(&object.device)?);
        Ok(())
    }
}
