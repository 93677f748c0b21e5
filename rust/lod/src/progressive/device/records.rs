//! What edits on a device have replaced, so that they can be taken back: compacted there by a prefix sum, and kept there.

use std::sync::Arc;

use relievo_core::Result;
use relievo_gpu::wgsl::progressive::Place;
use relievo_gpu::wgsl::progressive_mark::CutCall;
use relievo_gpu::wgsl::progressive_record::RecordCall;
use relievo_gpu::{
    Access, Bindings, Buffer, Device, Frame, GROUP, Kernel, KernelSpec, Pass, Readback, Scan, groups, wgpu,
};

use super::hierarchy::DeviceHierarchy;
use super::places::Places;
use super::windows::Windows;

/// Finds what an edit replaces.
#[derive(Debug)]
pub struct Records {
    /// Of every node whether its place is replaced, and then whether its note is.
    pub touched: Buffer<u32>,
    /// Words of the first of both.
    words: u32,
    scan: Scan,
    count: Arc<Kernel>,
    keep: [Arc<Kernel>; 2],
    counted: [Bindings; 2],
    listed: Bindings,
    places: Bindings,
    notes: [wgpu::Buffer; 2],
}

/// What an edit has replaced: 36 bytes for each place.
#[derive(Debug)]
pub struct Record {
    bindings: Bindings,
    count: u32,
}

impl Records {
    /// Of the places and notes of nodes.
    pub fn new(hierarchy: &DeviceHierarchy, places: &Places, notes: &Windows<Place, 2>) -> Result<Self> {
        let device = &hierarchy.device;
        let words = (2 * hierarchy.vertices).div_ceil(32);
        let touched = Buffer::new(device, "places that are replaced", 2 * words)?;
        let ranks = Buffer::new(device, "ranks of places that are replaced", 2 * words)?;
        let kernel = |module, entry, groups: &[&[Access]], immediates: usize, constants: &[(&str, f64)]| {
            device.kernel(&KernelSpec { module, entry, groups, immediates: immediates as u32, constants })
        };
        let (read, write): (&[Access], &[Access]) = (&[Access::Read; 2], &[Access::Write; 4]);
        let count = kernel("progressive_mark", "count", &[&read[..1], &write[..2]], size_of::<CutCall>(), &[])?;
        let groups = [read, write, &write[..2]];
        let record = |entry| kernel("progressive_record", entry, &groups, size_of::<RecordCall>(), &places.constants());
        let keep = [record("keep")?, record("swap")?];
        Ok(Self {
            counted: [
                device.bind(&count, 0, &[hierarchy.splits.wgpu()])?,
                device.bind(&count, 1, &[touched.wgpu(), ranks.wgpu()])?,
            ],
            listed: device.bind(&keep[0], 0, &[touched.wgpu(), ranks.wgpu()])?,
            places: places.bindings.clone(),
            notes: notes.wgpu().map(wgpu::Buffer::clone),
            // No length comes from a buffer.
            scan: Scan::new(device, &ranks, &Buffer::new(device, "no lengths", 1)?)?,
            touched,
            words: words as u32,
            count,
            keep,
        })
    }

    /// Records that what is touched is counted.
    pub fn count(&self, pass: &mut Pass<'_>) -> Result<()> {
        let words = 2 * self.words;
        let call = CutCall { key: 0, split: 0, vertices: 32 * words };
        let [splits, touched] = &self.counted;
        pass.run(&self.count, &[splits, touched], bytemuck::bytes_of(&call), groups(words.div_ceil(GROUP)))?;
        self.scan.run(pass, words)
    }

    /// Copies how many places are touched on their way to the host.
    pub fn read_count(&self, frame: &mut Frame) -> Result<Readback<u32>> {
        let sums = self.scan.sums();
        frame.read(sums, sums.len() - 1..sums.len())
    }

    /// Room for so many places. Fails where the device has no memory.
    pub fn record(&self, device: &Device, count: u32) -> Result<Record> {
        let numbers = Buffer::<u32>::new(device, "numbers of a record", count as usize)?;
        let values = Buffer::<Place>::new(device, "places of a record", count as usize)?;
        let [one, more] = &self.notes;
        let buffers = [numbers.wgpu(), values.wgpu(), one, more];
        Ok(Record { bindings: device.bind(&self.keep[0], 1, &buffers)?, count })
    }

    /// Records that what is touched is kept before it is replaced.
    pub fn keep(&self, pass: &mut Pass<'_>, record: &Record) -> Result<()> {
        self.run(pass, 0, record, 2 * self.words)
    }

    /// Records that the stored values and the present ones take each other's place.
    pub fn swap(&self, pass: &mut Pass<'_>, record: &Record) -> Result<()> {
        self.run(pass, 1, record, record.count)
    }

    fn run(&self, pass: &mut Pass<'_>, kernel: usize, record: &Record, items: u32) -> Result<()> {
        let call = RecordCall { words: self.words, count: record.count };
        let bindings = [&self.listed, &record.bindings, &self.places];
        pass.run(&self.keep[kernel], &bindings, bytemuck::bytes_of(&call), groups(items.div_ceil(GROUP)))
    }
}
