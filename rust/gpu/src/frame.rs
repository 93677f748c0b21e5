//! A frame: commands that are recorded, submitted at once, and timed per pass.

use std::fmt;
use std::marker::PhantomData;
use std::ops::Range;

use bytemuck::Pod;
use relievo_core::{Error, Result};

use crate::buffer::Buffer;
use crate::device::Device;
use crate::kernel::{Bindings, Kernel};
use crate::pass_time::PassTime;
use crate::readback::{self, Readback, read};
use crate::timing::{BYTES, MAX, TimingSet, give, take, times};

/// Commands that are being recorded.
pub struct Frame {
    device: Device,
    encoder: wgpu::CommandEncoder,
    timing: Option<TimingSet>,
    names: Vec<&'static str>,
}

impl fmt::Debug for Frame {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.debug_struct("Frame").field("passes", &self.names).finish_non_exhaustive()
    }
}

/// A sequence of kernels with a name. Each sees what those before it wrote.
pub struct Pass<'a> {
    pass: wgpu::ComputePass<'a>,
}

impl fmt::Debug for Pass<'_> {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.debug_struct("Pass").finish_non_exhaustive()
    }
}

/// A frame that the device works on.
#[must_use]
pub struct Submission {
    device: Device,
    index: wgpu::SubmissionIndex,
    timing: Option<TimingSet>,
    names: Vec<&'static str>,
}

impl fmt::Debug for Submission {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.debug_struct("Submission").field("passes", &self.names).finish_non_exhaustive()
    }
}

impl Device {
    /// Begins a frame.
    ///
    /// # Errors
    /// Fails as [`Device::check`] does, or if the device has no memory for the queries of times.
    pub fn frame(&self) -> Result<Frame> {
        self.check()?;
        let timing = if self.is_timed() { Some(take(self)?) } else { None };
        let encoder = self.wgpu().create_command_encoder(&wgpu::CommandEncoderDescriptor { label: None });
        Ok(Frame { device: self.clone(), encoder, timing, names: Vec::new() })
    }
}

impl Frame {
    /// Begins a pass, which ends when it is dropped.
    pub fn pass(&mut self, name: &'static str) -> Pass<'_> {
        let stamps = self.stamps(name);
        let writes = self.timing.as_ref().zip(stamps).map(|(set, [begin, end])| wgpu::ComputePassTimestampWrites {
            query_set: &set.queries,
            beginning_of_pass_write_index: Some(begin),
            end_of_pass_write_index: Some(end),
        });
        let descriptor = wgpu::ComputePassDescriptor { label: Some(name), timestamp_writes: writes };
        Pass { pass: self.encoder.begin_compute_pass(&descriptor) }
    }

    /// Begins a pass that draws into what `descriptor` names; its times are this frame's to set.
    pub fn draw(&mut self, name: &'static str, descriptor: &wgpu::RenderPassDescriptor<'_>) -> wgpu::RenderPass<'_> {
        let stamps = self.stamps(name);
        let writes = self.timing.as_ref().zip(stamps).map(|(set, [begin, end])| wgpu::RenderPassTimestampWrites {
            query_set: &set.queries,
            beginning_of_pass_write_index: Some(begin),
            end_of_pass_write_index: Some(end),
        });
        let descriptor = wgpu::RenderPassDescriptor { timestamp_writes: writes, ..descriptor.clone() };
        self.encoder.begin_render_pass(&descriptor)
    }

    /// The queries of the next pass, if it is timed.
    fn stamps(&mut self, name: &'static str) -> Option<[u32; 2]> {
        let index = self.names.len() as u32;
        if self.timing.is_none() || index == MAX {
            return None;
        }
        self.names.push(name);
        Some([2 * index, 2 * index + 1])
    }

    /// The encoder, for copies of textures.
    pub fn encoder(&mut self) -> &mut wgpu::CommandEncoder {
        &mut self.encoder
    }

    /// Sets all items of a buffer to zero.
    pub fn clear<T: Pod>(&mut self, buffer: &Buffer<T>) {
        self.encoder.clear_buffer(buffer.wgpu(), 0, None);
    }

    /// Copies items of one buffer to another, from its item `first` on.
    ///
    /// # Errors
    /// Fails with `Internal` if a range is not within its buffer, or does not lie on whole words of 4 bytes.
    pub fn copy<T: Pod>(&mut self, from: &Buffer<T>, range: Range<usize>, to: &Buffer<T>, first: usize) -> Result<()> {
        let target = to.bytes(first..first.saturating_add(range.len()))?;
        let source = from.bytes(range)?;
        let length = (source.end - source.start).next_multiple_of(4);
        self.encoder.copy_buffer_to_buffer(from.wgpu(), source.start, to.wgpu(), target.start, Some(length));
        Ok(())
    }

    /// Copies items on their way back to the host.
    ///
    /// # Errors
    /// Fails with `Internal` if the range is not within the buffer, or does not lie on whole words of 4 bytes, and with
    /// `Memory` or `Device` if the device has no memory for the copy or was lost.
    pub fn read<T: Pod>(&mut self, buffer: &Buffer<T>, range: Range<usize>) -> Result<Readback<T>> {
        let len = range.len();
        let bytes = buffer.bytes(range)?;
        let size = (bytes.end - bytes.start).next_multiple_of(4);
        let host = readback::host(&self.device, size)?;
        if size > 0 {
            self.encoder.copy_buffer_to_buffer(buffer.wgpu(), bytes.start, &host, 0, Some(size));
        }
        Ok(Readback { host, len, item: PhantomData })
    }

    /// Hands the commands to the device.
    ///
    /// # Errors
    /// Fails with `Device` if the device was lost and with `Internal` if one of the commands is faulty; what was
    /// recorded is then not done.
    pub fn submit(mut self) -> Result<Submission> {
        if let Some(set) = self.timing.as_ref().filter(|_| !self.names.is_empty()) {
            let used = 2 * self.names.len() as u32;
            self.encoder.resolve_query_set(&set.queries, 0..used, &set.resolved, 0);
            self.encoder.copy_buffer_to_buffer(&set.resolved, 0, &set.host, 0, Some(BYTES));
        }
        let Self { device, encoder, timing, names } = self;
        let index = device.guard(|| device.queue().submit([encoder.finish()]))?;
        Ok(Submission { device, index, timing, names })
    }
}

impl Pass<'_> {
    /// Runs a kernel with its groups of buffers and its immediate data, of which there are as many bytes as it declares,
    /// in `size` workgroups.
    ///
    /// # Errors
    /// Fails with `Internal` if there are not as many bytes of immediate data as the kernel declares.
    pub fn run(&mut self, kernel: &Kernel, groups: &[&Bindings], immediates: &[u8], size: [u32; 3]) -> Result<()> {
        if size.contains(&0) {
            return Ok(());
        }
        self.set(kernel, groups, immediates)?;
        self.pass.dispatch_workgroups(size[0], size[1], size[2]);
        Ok(())
    }

    /// Runs as many workgroups as three numbers of `arguments` from index `first` on say.
    ///
    /// # Errors
    /// Fails with `Internal` if the three numbers are not within `arguments`, or there are not as many bytes of
    /// immediate data as the kernel declares.
    pub fn run_indirect(
        &mut self,
        kernel: &Kernel,
        groups: &[&Bindings],
        immediates: &[u8],
        arguments: &Buffer<u32>,
        first: usize,
    ) -> Result<()> {
        let offset = arguments.bytes(first..first.saturating_add(3))?.start;
        self.set(kernel, groups, immediates)?;
        self.pass.dispatch_workgroups_indirect(arguments.wgpu(), offset);
        Ok(())
    }

    fn set(&mut self, kernel: &Kernel, groups: &[&Bindings], immediates: &[u8]) -> Result<()> {
        if immediates.len() != kernel.immediates as usize {
            let what = format!("{} bytes of immediate data for {kernel:?}", immediates.len());
            return Err(Error::internal(what));
        }
        self.pass.set_pipeline(&kernel.pipeline);
        for (index, bindings) in (0..).zip(groups) {
            self.pass.set_bind_group(index, &bindings.group, &[]);
        }
        if !immediates.is_empty() {
            self.pass.set_immediates(0, immediates);
        }
        Ok(())
    }
}

impl Submission {
    /// Waits until the device has done it and returns the times of its passes, none if the device does not time.
    ///
    /// # Errors
    /// Fails with `Device` if the device was lost or does not end in time, and with `Internal` if its times cannot be
    /// read.
    pub fn wait(self) -> Result<Vec<PassTime>> {
        self.device.wait(Some(self.index.clone()))?;
        let Some(set) = &self.timing else { return Ok(Vec::new()) };
        let mut ticks = vec![0; 2 * self.names.len()];
        read(&self.device, &set.host, bytemuck::cast_slice_mut(&mut ticks))?;
        Ok(times(&self.names, &ticks, f64::from(self.device.queue().get_timestamp_period())))
    }
}

impl Drop for Submission {
    /// Also the queries of a frame that nobody waits for are used again: the device does frames in order.
    fn drop(&mut self) {
        if let Some(set) = self.timing.take() {
            give(&self.device, set);
        }
    }
}
