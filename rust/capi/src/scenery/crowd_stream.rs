//! Crowds whose clusters are read while they are drawn; see `include/relievo/crowd_stream.h`.

use std::ffi::c_char;
use std::sync::Arc;

use relievo_core::{Error, Result};
use relievo_crowd::{Crowd, Stream};

use crate::border::array::{Input, Output, Plain, present, put, text};
use crate::border::descriptor::{read_optional, write_descriptor};
use crate::border::registry;
use crate::runtime::context::RlvContext;
use crate::scenery::crowd::{CrowdModelObject, CrowdObject, RlvCrowd, RlvCrowdModel};

descriptor! {
    pub struct RlvCrowdStreamFile {
        path: *const c_char,
    }
}

descriptor! {
    pub struct RlvCrowdStreamSettings {
        struct_size: u32,
        most_read: u32,
        budget: u64,
    }
}

descriptor! {
    pub struct RlvCrowdStreamInfo {
        struct_size: u32,
        slot_triangles: u32,
        slot_count: u32,
        resident: u32,
        read: u32,
        dropped: u32,
        missing: u32,
        reserved: u32,
        wanted_triangles: u64,
    }
}

#[repr(C)]
#[derive(Clone, Copy, Debug, Default)]
pub struct RlvCrowdStreamCluster {
    pub model: u32,
    pub cluster: u32,
    pub slot: u32,
    pub triangle_count: u32,
}

impl Default for RlvCrowdStreamFile {
    fn default() -> Self {
        Self { path: std::ptr::null() }
    }
}

impl Default for RlvCrowdStreamSettings {
    fn default() -> Self {
        Self { struct_size: 0, most_read: 1024, budget: 64 << 20 }
    }
}

// SAFETY: a pointer without padding.
unsafe impl Plain for RlvCrowdStreamFile {}
// SAFETY: integers of four bytes without padding.
unsafe impl Plain for RlvCrowdStreamCluster {}

/// Works with the stream of a crowd.
fn with_stream<T>(crowd: RlvCrowd, work: impl FnOnce(&Stream) -> Result<T>) -> Result<T> {
    registry::get(crowd)?.with_crowd(|crowd| match crowd.stream() {
        Some(stream) => work(stream),
        None => Err(Error::invalid("the crowd is no stream").at("crowd").advise("open one by rlv_crowd_stream_open")),
    })
}

entry! {
    fn rlv_crowd_stream_open(
        context: RlvContext,
        files: *const RlvCrowdStreamFile,
        count: usize,
        settings: *const RlvCrowdStreamSettings,
        out: *mut RlvCrowd,
    ) {
        present("out", out)?;
        let context = registry::get(context)?;
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        let settings = unsafe { read_optional(settings, RlvCrowdStreamSettings::default()) }?;
        // SAFETY: the caller promises `count` files.
        let files = unsafe { Input::new("files", files, count, 0) }?.to_vec("files", context.context.memory_limit())?;
        // SAFETY: the caller gives NUL-terminated texts.
        let paths = files.iter().map(|file| unsafe { text("files", file.path) });
        let paths = paths.collect::<Result<Vec<_>>>()?;
        let stream = Stream::open(&context.context, &paths, settings.budget, settings.most_read)?;
        let handle = registry::insert(CrowdObject::new(context, Crowd::streamed(stream)))?;
        // SAFETY: checked above.
        unsafe { put(out, handle) };
        Ok(())
    }

    fn rlv_crowd_stream_model(crowd: RlvCrowd, model: u32, out: *mut RlvCrowdModel) {
        present("out", out)?;
        let object = registry::get(crowd)?;
        let found = object.with_crowd(|crowd| {
            crowd.models().get(model as usize).map(Arc::clone).ok_or_else(|| {
                Error::invalid(format!("model {model} does not exist"))
                    .at("model")
                    .advise(format!("the crowd has {} models counted from 0", crowd.models().len()))
            })
        })?;
        let handle = registry::insert(CrowdModelObject::new(object.context().clone(), found))?;
        // SAFETY: checked above.
        unsafe { put(out, handle) };
        Ok(())
    }

    fn rlv_crowd_stream_info(crowd: RlvCrowd, out: *mut RlvCrowdStreamInfo) {
        let info = with_stream(crowd, |stream| {
            let counts = stream.counts();
            Ok(RlvCrowdStreamInfo {
                struct_size: 0,
                slot_triangles: stream.slot_triangles(),
                slot_count: stream.slot_count(),
                resident: counts.resident,
                read: stream.read().len() as u32,
                dropped: counts.dropped,
                missing: counts.missing,
                reserved: 0,
                wanted_triangles: counts.wanted_triangles,
            })
        })?;
        // SAFETY: the caller gives a descriptor that starts with its size.
        unsafe { write_descriptor(out, info) }
    }

    fn rlv_crowd_stream_get_read(
        crowd: RlvCrowd,
        clusters: *mut RlvCrowdStreamCluster,
        capacity: usize,
        stride: usize,
    ) {
        // SAFETY: the caller promises room for `capacity` clusters.
        let out = unsafe { Output::new("clusters", clusters, capacity, stride) }?;
        with_stream(crowd, |stream| {
            let read = stream.read().iter().map(|[model, cluster]| RlvCrowdStreamCluster {
                model: *model,
                cluster: *cluster,
                slot: stream.slot(*model, *cluster).unwrap_or_default(),
                triangle_count: stream.triangles(*model, *cluster).map_or(0, |it| it.0.len() as u32),
            });
            out.holds("clusters", read.len())?.fill(read);
            Ok(())
        })
    }

    fn rlv_crowd_stream_get_triangles(
        crowd: RlvCrowd,
        slot: u32,
        triangles: *mut u32,
        materials: *mut u32,
        capacity: usize,
    ) {
        // SAFETY: the caller promises room for `capacity` triangles, or NULL for what is not wanted.
        let (corners, slots) = unsafe {
            (
                Output::<[u32; 3]>::optional("triangles", triangles.cast(), capacity, 0)?,
                Output::<u32>::optional("materials", materials, capacity, 0)?,
            )
        };
        with_stream(crowd, |stream| {
            let found = stream.content(slot).and_then(|[model, cluster]| stream.triangles(model, cluster));
            let (triangles, materials) =
                found.ok_or_else(|| Error::invalid(format!("slot {slot} is empty or does not exist")).at("slot"))?;
            let slots = slots.map(|out| out.holds("materials", materials.len())).transpose()?;
            if let Some(out) = corners {
                out.holds("triangles", triangles.len())?.fill(triangles.iter().copied());
            }
            if let Some(out) = slots {
                out.fill(materials.iter().copied());
            }
            Ok(())
        })
    }
}
