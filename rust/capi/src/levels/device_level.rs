//! Levels of progressive meshes on a graphics device; see `include/relievo/device_level.h`.

use std::sync::{Arc, Mutex, MutexGuard, RwLock};

use relievo_core::Result;
use relievo_gpu::Frame;
use relievo_lod::progressive::{Buffers, Cut, DeviceFront, DeviceLevel, KeyedEdit, Update};

use crate::border::array::{present, put, put_optional};
use crate::border::descriptor::{check_optional, read_descriptor, write_descriptor, write_optional};
use crate::border::registry::{self, handle, try_read, try_write};
use crate::border::work::broken;
use crate::levels::level::{
    HostBuffers, RlvLevelBuffers, RlvLevelEdit, RlvLevelMotion, RlvLevelUpdate, RlvLevelView, cut_of_error, edit,
    nothing, read_view,
};
use crate::levels::progressive::{ProgressiveObject, RlvProgressive};
use crate::runtime::buffer::{objects, settle, vulkan_objects};

handle!(RlvDeviceLevel, 20, DeviceLevelObject);

descriptor! {
    pub struct RlvDeviceLevelInfo {
        struct_size: u32,
        undo_count: u32,
        redo_count: u32,
        reserved: u32,
        vertex_count: usize,
        triangle_count: usize,
        wedge_count: usize,
    }
}

vulkan_objects! {
    pub struct RlvDeviceLevelVulkan {
        vertices: u64,
        triangles: u64,
        arguments: u64,
        wedges: u64,
        wedge_values: u64,
        face_values: u64,
    }
}

pub struct DeviceLevelObject {
    whole: Arc<ProgressiveObject>,
    level: RwLock<DeviceLevel>,
    /// Edits over time, each of a mesh. Taken after the level.
    motions: Mutex<Vec<(DeviceFront, KeyedEdit)>>,
}

impl DeviceLevelObject {
    /// Has the mesh for itself while it changes, and waits until the device has done it.
    fn change<T>(&self, work: impl FnOnce(&mut DeviceLevel) -> Result<T>) -> Result<T> {
        let device = self.whole.context.opened_device()?;
        device.check()?;
        let done = work(&mut *try_write(&self.level, "level")?)?;
        settle(device)?;
        Ok(done)
    }

    /// The same of what is recorded in a frame.
    fn record(&self, work: impl FnOnce(&mut DeviceLevel, &mut Frame) -> Result<()>) -> Result<()> {
        self.change(|level| {
            let mut frame = self.whole.context.opened_device()?.frame()?;
            work(level, &mut frame)?;
            frame.submit().map(drop)
        })
    }

    fn motions(&self) -> Result<MutexGuard<'_, Vec<(DeviceFront, KeyedEdit)>>> {
        self.motions.lock().map_err(|_| broken("level"))
    }
}

entry! {
    fn rlv_device_level_create(progressive: RlvProgressive, out: *mut RlvDeviceLevel) {
        present("out", out)?;
        let whole = registry::get(progressive)?;
        let level = RwLock::new(DeviceLevel::new(&whole.on_device()?)?);
        let made = DeviceLevelObject { whole, level, motions: Mutex::default() };
        made.record(|level, frame| level.adapt(frame, Cut::BASE))?;
        let handle = registry::insert(made)?;
        // SAFETY: checked above.
        unsafe { put(out, handle) };
        Ok(())
    }

    fn rlv_device_level_retain(level: RlvDeviceLevel) {
        registry::retain(level)
    }

    fn rlv_device_level_release(level: RlvDeviceLevel) {
        registry::release(level)
    }

    fn rlv_device_level_info(level: RlvDeviceLevel, out: *mut RlvDeviceLevelInfo) {
        let object = registry::get(level)?;
        let level = try_read(&object.level, "level")?;
        let [undo, redo] = level.edits();
        let [vertex_count, triangle_count, wedge_count] = level.counts()?;
        let info = RlvDeviceLevelInfo {
            struct_size: 0,
            undo_count: undo as u32,
            redo_count: redo as u32,
            reserved: 0,
            vertex_count,
            triangle_count,
            wedge_count,
        };
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        unsafe { write_descriptor(out, info) }
    }

    fn rlv_device_level_set_error(level: RlvDeviceLevel, error: f32) {
        let object = registry::get(level)?;
        let cut = cut_of_error(error)?;
        object.record(|level, frame| level.adapt(frame, cut))
    }

    fn rlv_device_level_set_triangles(level: RlvDeviceLevel, triangles: usize) {
        let object = registry::get(level)?;
        let cut = Cut::of_faces(&object.whole.mesh, triangles);
        object.record(|level, frame| level.adapt(frame, cut))
    }

    fn rlv_device_level_set_view(level: RlvDeviceLevel, view: *const RlvLevelView) {
        let object = registry::get(level)?;
        // SAFETY: the caller gives NULL or a descriptor that starts with its size, with an array of its count.
        let view = unsafe { read_view(&object.whole.context, view) }?;
        object.record(|level, frame| level.adapt_to(frame, &view))
    }

    fn rlv_device_level_edit(level: RlvDeviceLevel, edit: *const RlvLevelEdit, reached: *mut usize) {
        let object = registry::get(level)?;
        // SAFETY: the caller gives NULL or a descriptor that starts with its size, with arrays of their counts.
        let edit = unsafe { edit::read_edit(edit) }?;
        let count = object.change(|level| level.edit(&edit))?;
        // SAFETY: the caller promises a place, or NULL.
        unsafe { put_optional(reached, count) };
        Ok(())
    }

    fn rlv_device_level_undo(level: RlvDeviceLevel) {
        let object = registry::get(level)?;
        if object.change(DeviceLevel::undo)? { Ok(()) } else { Err(nothing("take back")) }
    }

    fn rlv_device_level_redo(level: RlvDeviceLevel) {
        let object = registry::get(level)?;
        if object.change(DeviceLevel::redo)? { Ok(()) } else { Err(nothing("make again")) }
    }

    fn rlv_device_level_add_motion(level: RlvDeviceLevel, motion: *const RlvLevelMotion) {
        let object = registry::get(level)?;
        // SAFETY: the caller gives NULL or a descriptor that starts with its size, with arrays of their counts.
        let motion = unsafe { edit::read_motion(motion) }?;
        object.change(|level| {
            object.motions()?.push((level.front()?, motion));
            Ok(())
        })
    }

    fn rlv_device_level_set_time(level: RlvDeviceLevel, time: f64, reached: *mut usize) {
        let object = registry::get(level)?;
        let count = object.change(|level| level.pose(&object.motions()?, time))?;
        // SAFETY: the caller promises a place, or NULL.
        unsafe { put_optional(reached, count) };
        Ok(())
    }

    fn rlv_device_level_clear_motions(level: RlvDeviceLevel) {
        let object = registry::get(level)?;
        object.change(|level| {
            object.motions()?.clear();
            level.rest()
        })
    }

    fn rlv_device_level_read(level: RlvDeviceLevel, buffers: *const RlvLevelBuffers, out: *mut RlvLevelUpdate) {
        let object = registry::get(level)?;
        // SAFETY: a descriptor of nothing but numbers and NULL pointers.
        let default: RlvLevelBuffers = unsafe { std::mem::zeroed() };
        // SAFETY: the caller gives NULL or descriptors that start with their size.
        let given = unsafe {
            check_optional(out)?;
            read_descriptor(buffers, default)?
        };
        let whole = &object.whole.mesh;
        // SAFETY: the caller promises room for the capacities.
        let mut buffers = unsafe { HostBuffers::new(&given, whole) }?;
        let level = try_read(&object.level, "level")?;
        let [vertices, triangles, _] = level.counts()?;
        buffers.points.holds("points", vertices)?;
        buffers.triangles.holds("triangles", triangles)?;
        let made = level.extract()?;
        for (place, (point, normal)) in made.points.iter().zip(&made.normals).enumerate() {
            buffers.set_vertex(place, *point, *normal);
        }
        for (place, triangle) in made.triangles.iter().enumerate() {
            buffers.set_triangle(place, *triangle);
        }
        let [width, face_width] = whole.attribute_widths();
        let wedges = made.values.len() / width.max(1);
        for (place, values) in made.values.chunks_exact(width.max(1)).enumerate() {
            buffers.set_wedge(place, values);
        }
        for (place, wedges) in made.wedges.iter().enumerate() {
            buffers.set_corners(place, *wedges, &made.face_values[place * face_width..(place + 1) * face_width]);
        }
        let all = |count: usize| (count > 0).then_some(0..count as u32).into_iter().collect();
        let update = Update {
            vertices,
            triangles,
            changed_vertices: all(vertices),
            changed_triangles: all(triangles),
            wedges,
            changed_wedges: all(wedges),
        };
        // SAFETY: checked above.
        unsafe { write_optional(out, RlvLevelUpdate::of(&update)) }
    }

    fn rlv_device_level_vulkan(level: RlvDeviceLevel, out: *mut RlvDeviceLevelVulkan) {
        let object = registry::get(level)?;
        let device = object.whole.context.opened_device()?;
        device.check()?;
        let level = try_read(&object.level, "level")?;
        let (vertices, attributes) = (level.vertices().wgpu(), level.wedges().is_some());
        let buffers = [
            vertices,
            level.indices().wgpu(),
            level.arguments().wgpu(),
            level.wedges().map_or(vertices, |wedges| wedges.wgpu()),
            level.wedge_values().map_or(vertices, |values| values.wgpu()),
            level.face_values().map_or(vertices, |values| values.wgpu()),
        ];
        let found = objects(device, buffers, "level", "copy the mesh with rlv_device_level_read")?;
        let mut told = RlvDeviceLevelVulkan::of(found);
        if !attributes {
            (told.wedges, told.wedge_values, told.face_values) = (0, 0, 0);
        }
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        unsafe { write_descriptor(out, told) }
    }
}
