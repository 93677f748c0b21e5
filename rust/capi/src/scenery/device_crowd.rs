//! Crowds on a graphics device; see `include/relievo/device_crowd.h`.

use std::sync::{Arc, RwLock};

use relievo_core::{Error, Result};
use relievo_crowd::{Crowd, Culled, DeviceCounted, DeviceCrowd, DeviceOcclusion, DevicePoser, DrawList, Look};
use relievo_gpu::{Buffer, Device};

use crate::border::array::{present, put};
use crate::border::descriptor::{check_optional, read_descriptor, write_descriptor, write_optional};
use crate::border::registry::{self, handle, try_read, try_write};
use crate::runtime::buffer::{objects, settle, vulkan_objects};
use crate::scenery::crowd::{
    CrowdObject, RlvCrowd, RlvCrowdBuffers, RlvCrowdImpostors, RlvCrowdView, Seen, ShownImpostors, view_of, write_list,
};

handle!(RlvDeviceCrowd, 36, DeviceCrowdObject);

/// Draws that there is room for at first.
const ROOM: u32 = 1 << 12;

descriptor! {
    pub struct RlvDeviceCrowdInfo {
        struct_size: u32,
        agent_count: u32,
        draw_count: u32,
        matrix_count: u32,
        weight_count: u32,
        impostor_count: u32,
        picture_count: u32,
        hidden: u32,
        hidden_triangles: u64,
        occluder_triangles: u64,
        hidden_clusters: u32,
        reserved: u32,
    }
}

vulkan_objects! {
    pub struct RlvDeviceCrowdVulkan {
        draws: u64,
        clusters: u64,
        instances: u64,
        counts: u64,
        matrices: u64,
        weights: u64,
        blends: u64,
    }
}

pub struct DeviceCrowdObject {
    whole: Arc<CrowdObject>,
    state: RwLock<State>,
}

struct State {
    crowd: DeviceCrowd,
    /// What the last cut counted.
    counts: Option<DeviceCounted>,
    shown: ShownImpostors,
    /// Made when it is first asked for.
    culling: Option<Culling>,
}

/// What culls by occlusion, with the vertices of the models.
struct Culling {
    occlusion: DeviceOcclusion,
    poser: DevicePoser,
}

impl Culling {
    fn new(device: &Device, crowd: &Crowd) -> Result<Self> {
        let look = Look { tag: None, lines: false };
        Ok(Self { occlusion: DeviceOcclusion::new(device)?, poser: DevicePoser::new(device, crowd, look)? })
    }
}

impl State {
    /// Fails where there was no cut.
    fn counted(&self) -> Result<DeviceCounted> {
        self.counts.ok_or_else(|| {
            Error::invalid("there was no cut, or the last one failed")
                .at("device crowd")
                .advise("call rlv_device_crowd_cut first")
        })
    }
}

impl DeviceCrowdObject {
    /// Returns the device. Fails if it was lost.
    fn device(&self) -> Result<&Device> {
        let device = self.whole.context().opened_device()?;
        device.check()?;
        Ok(device)
    }
}

/// Copies a buffer back from the device.
fn read_back<T: bytemuck::Pod>(device: &Device, buffer: &Buffer<T>) -> Result<Vec<T>> {
    let mut frame = device.frame()?;
    let reading = frame.read(buffer, 0..buffer.len())?;
    frame.submit()?.wait()?;
    reading.get(device)
}

entry! {
    fn rlv_device_crowd_create(crowd: RlvCrowd, out: *mut RlvDeviceCrowd) {
        present("out", out)?;
        let whole = registry::get(crowd)?;
        let device = whole.context().opened_device()?;
        device.check()?;
        let crowd = whole.with_crowd(|crowd| DeviceCrowd::new(device, crowd, ROOM))?;
        settle(device)?;
        let state = RwLock::new(State { crowd, counts: None, shown: ShownImpostors::default(), culling: None });
        let handle = registry::insert(DeviceCrowdObject { state, whole })?;
        // SAFETY: checked above.
        unsafe { put(out, handle) };
        Ok(())
    }

    fn rlv_device_crowd_retain(crowd: RlvDeviceCrowd) {
        registry::retain(crowd)
    }

    fn rlv_device_crowd_release(crowd: RlvDeviceCrowd) {
        registry::release(crowd)
    }

    fn rlv_device_crowd_cut(crowd: RlvDeviceCrowd, view: *const RlvCrowdView, out: *mut RlvDeviceCrowdInfo) {
        let object = registry::get(crowd)?;
        let mut state = try_write(&object.state, "device crowd")?;
        // Before anything is refused, so that nobody draws the cut before.
        state.counts = None;
        // SAFETY: the caller gives NULL or descriptors that start with their size.
        let Seen { view, eye, pixels, time } = unsafe {
            check_optional(out)?;
            view_of(view)?
        };
        let device = object.device()?;
        let context = &object.whole.context().context;
        let State { crowd: on_device, counts, shown, culling } = &mut *state;
        let (counted, culled, [impostor_count, picture_count]) = object.whole.with_crowd(|crowd| {
            let (counted, culled) = match pixels {
                Some(pixels) => {
                    let Culling { occlusion, poser } = match culling {
                        Some(culling) => culling,
                        empty => empty.insert(Culling::new(device, crowd)?),
                    };
                    occlusion.update(context, (crowd, on_device, poser), (&view, time), &pixels)?
                }
                None => (on_device.update(context, crowd, &view, time)?, Culled::default()),
            };
            let mut agents = on_device.impostors(counted)?;
            agents.sort_unstable();
            Ok((counted, culled, shown.update(context, (crowd, &agents, time), eye)?))
        })?;
        *counts = Some(counted);
        let found = RlvDeviceCrowdInfo {
            struct_size: 0,
            agent_count: counted.agents,
            draw_count: counted.draws,
            matrix_count: on_device.matrices().len() as u32,
            weight_count: on_device.weight_count() as u32,
            impostor_count,
            picture_count,
            hidden: culled.hidden,
            hidden_triangles: culled.hidden_triangles,
            occluder_triangles: culled.occluder_triangles,
            hidden_clusters: u32::try_from(culled.hidden_clusters).unwrap_or(u32::MAX),
            reserved: 0,
        };
        // SAFETY: checked above.
        unsafe { write_optional(out, found) }
    }

    fn rlv_device_crowd_get(crowd: RlvDeviceCrowd, buffers: *const RlvCrowdBuffers) {
        let object = registry::get(crowd)?;
        // SAFETY: a descriptor of nothing but numbers and NULL pointers.
        let default: RlvCrowdBuffers = unsafe { std::mem::zeroed() };
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        let given = unsafe { read_descriptor(buffers, default) }?;
        let device = object.device()?;
        let state = try_read(&object.state, "device crowd")?;
        let made = state.crowd.read(state.counted()?)?;
        let mut list = DrawList {
            draws: made.draws,
            clusters: made.clusters,
            blends: made.blends,
            instances: made.instances,
            first_weights: made.first_weights,
            ..DrawList::default()
        };
        if !(given.matrices.is_null() && given.dual_rows.is_null()) {
            list.matrices = read_back(device, state.crowd.matrices())?;
        }
        if !given.weights.is_null() {
            list.weights = read_back(device, state.crowd.weights())?;
            list.weights.truncate(state.crowd.weight_count());
        }
        // SAFETY: the caller promises room for the capacities in each array that is not NULL.
        unsafe { write_list(&object.whole.context().context, &given, &list) }
    }

    fn rlv_device_crowd_get_impostors(crowd: RlvDeviceCrowd, impostors: *const RlvCrowdImpostors) {
        let object = registry::get(crowd)?;
        // SAFETY: a descriptor of nothing but numbers and NULL pointers.
        let default: RlvCrowdImpostors = unsafe { std::mem::zeroed() };
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        let given = unsafe { read_descriptor(impostors, default) }?;
        let state = try_read(&object.state, "device crowd")?;
        state.counted()?;
        // SAFETY: the caller promises room for the capacities in each array that is not NULL.
        unsafe { state.shown.write(&given) }
    }

    fn rlv_device_crowd_vulkan(crowd: RlvDeviceCrowd, out: *mut RlvDeviceCrowdVulkan) {
        let object = registry::get(crowd)?;
        let device = object.device()?;
        let state = try_read(&object.state, "device crowd")?;
        let made = &state.crowd;
        let buffers = [
            made.draws().wgpu(),
            made.clusters().wgpu(),
            made.instances().wgpu(),
            made.counts().wgpu(),
            made.matrices().wgpu(),
            made.weights().wgpu(),
            made.blends().wgpu(),
        ];
        let found = objects(device, buffers, "device crowd", "copy the draws with rlv_device_crowd_get")?;
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        unsafe { write_descriptor(out, RlvDeviceCrowdVulkan::of(found)) }
    }
}
