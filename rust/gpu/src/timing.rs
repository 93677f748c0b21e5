//! Times of passes by the device's own clock (timestamp queries).

use std::time::Duration;

use relievo_core::Result;

use crate::device::{Device, lock};
use crate::pass_time::PassTime;

/// Passes of a frame that are timed; those beyond are not.
pub(crate) const MAX: u32 = 256;

/// Queries and the buffers their results pass through, reused from frame to frame.
pub(crate) struct TimingSet {
    pub(crate) queries: wgpu::QuerySet,
    pub(crate) resolved: wgpu::Buffer,
    pub(crate) host: wgpu::Buffer,
}

/// Bytes of all results of a set.
pub(crate) const BYTES: u64 = 2 * MAX as u64 * size_of::<u64>() as u64;

/// A set that no frame uses, a new one if there is none.
pub(crate) fn take(device: &Device) -> Result<TimingSet> {
    if let Some(set) = lock(&device.inner().timings).pop() {
        return Ok(set);
    }
    let make = |label, usage| {
        let descriptor = wgpu::BufferDescriptor { label: Some(label), size: BYTES, usage, mapped_at_creation: false };
        device.wgpu().create_buffer(&descriptor)
    };
    device.guard(|| TimingSet {
        queries: device.wgpu().create_query_set(&wgpu::QuerySetDescriptor {
            label: Some("times"),
            ty: wgpu::QueryType::Timestamp,
            count: 2 * MAX,
        }),
        resolved: make("times", wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC),
        host: make("times read", wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST),
    })
}

/// Gives a set back.
pub(crate) fn give(device: &Device, set: TimingSet) {
    lock(&device.inner().timings).push(set);
}

/// The times of `names` from the ticks at their beginnings and ends.
pub(crate) fn times(names: &[&'static str], ticks: &[u64], nanoseconds: f64) -> Vec<PassTime> {
    let length =
        |pair: &[u64]| Duration::from_nanos((pair[1].saturating_sub(pair[0]) as f64 * nanoseconds).round() as u64);
    names.iter().zip(ticks.chunks_exact(2)).map(|(name, pair)| PassTime { name, length: length(pair) }).collect()
}
