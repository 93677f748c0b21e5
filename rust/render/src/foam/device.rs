//! Foam on a graphics device: the seven passes as compute kernels (`shaders/foam`), which the processor's are the
//! reference of.
//!
//! Particles are sent in chunks and drawn into all pixels by atomic operations: thickness by sums in fixed point of 2⁻³², and
//! the nearest fragment by minima of its depth, its number and its place on the disc, one after the other. Neither the
//! order of particles nor the device's own order matters. A sprite of up to 1,024 pixels is one invocation's, and 64 rows of a
//! larger one are a workgroup's.
//!
//! A pixel has 64 bytes on the device, and 4 bytes more for each channel of the picture while foam is laid over it. A chunk
//! has 8 MiB, and two more may be on their way, of 6 MiB each.

mod layers;
mod look;

use std::collections::VecDeque;
use std::sync::Arc;

use relievo_core::{Context, Result};
use relievo_gpu::wgsl::foam::{FoamLook, FoamPixel};
use relievo_gpu::wgsl::foam_splat::{FoamChunk, FoamRow};
use relievo_gpu::{Access, Bindings, Buffer, Device, GROUP, Kernel, KernelSpec, PassTime, Submission, groups};

pub use self::layers::DeviceLayers;
use super::FoamParticle;
use super::projection::{FoamView, Projection};
use super::scenery::Depths;
use super::settings::FoamSettings;
use super::thickness::Thickness;

/// Particles on the device at a time, and those of a task of the processor.
const CHUNK: usize = 1 << 18;
const CHUNK_LEN: usize = 1 << 13;
/// Chunks that the device has not drawn yet, at most.
const AHEAD: usize = 2;
/// The steps of a chunk, as in `foam_splat.wgsl`.
const STEPS: u32 = 4;
/// What is behind everything, as in `foam.wgsl`.
const FARTHEST_DEPTH: f32 = 3e38;
/// The number of pixels where nothing was drawn, as in `foam_splat.wgsl`.
const NONE: u32 = u32::MAX;

/// Accesses of what all kernels share: the look, pixels and fronts.
const SHARED: &[Access] = &[Access::Read, Access::Write, Access::Write];
const SPLATTED: &[Access] = &[Access::Read, Access::Read, Access::Write, Access::Write];

/// The pixels of a picture on a device, to which particles are added.
#[derive(Debug)]
pub struct Splats {
    device: Device,
    look: Buffer<FoamLook>,
    pixels: Buffer<FoamPixel>,
    fronts: Buffer<[f32; 4]>,
    rows: Buffer<FoamRow>,
    counts: Buffer<u32>,
    arguments: Buffer<u32>,
    /// What kernels are bound to but the host does not write again.
    _tables: Buffer<f32>,
    _lists: Buffer<u32>,
    shared: Bindings,
    chunk: Bindings,
    arranged: Bindings,
    narrow: Arc<Kernel>,
    arrange: Arc<Kernel>,
    wide: Arc<Kernel>,
    submissions: VecDeque<Submission>,
    times: Vec<PassTime>,
}

impl Splats {
    /// Makes a picture without foam on a device. Fails if it has no memory for it, or is lost.
    pub fn new(
        device: &Device,
        settings: &FoamSettings,
        view: &FoamView,
        thickness: &Thickness,
        depths: &Depths,
    ) -> Result<Self> {
        let count = view.pixels();
        let look = Buffer::of(device, "look of foam", &[look::look(settings, view)])?;
        let pixels = Buffer::new(device, "pixels of foam", count)?;
        let finite = |depth: f32| depth.min(FARTHEST_DEPTH);
        let fronts = depths.fluid.iter().zip(&depths.solids);
        let fronts: Vec<_> =
            fronts.map(|(fluid, solid)| [FARTHEST_DEPTH, 0.0, finite(*fluid), finite(*solid)]).collect();
        let fronts = Buffer::of(device, "fronts of foam", &fronts)?;
        let tables = Buffer::of(device, "falloffs of foam", &thickness.tables())?;
        let rows = Buffer::new(device, "particles of foam", CHUNK)?;
        let lists = Buffer::new(device, "lists of foam", 2 * CHUNK)?;
        let counts = Buffer::new(device, "counts of foam", 2)?;
        let arguments = Buffer::new(device, "arguments of foam", 6)?;
        let kernel = |entry, groups: &[&[Access]], immediates| {
            device.kernel(&KernelSpec { module: "foam_splat", entry, groups, immediates, constants: &[] })
        };
        let bytes = size_of::<FoamChunk>() as u32;
        let begin = kernel("begin", &[SHARED], 0)?;
        let narrow = kernel("narrow", &[SHARED, SPLATTED], bytes)?;
        let wide = kernel("wide", &[SHARED, SPLATTED], bytes)?;
        let arrange = kernel("arrange", &[SHARED, SPLATTED, &[Access::Write]], 0)?;
        let shared = device.bind(&begin, 0, &[look.wgpu(), pixels.wgpu(), fronts.wgpu()])?;
        let chunk = device.bind(&narrow, 1, &[tables.wgpu(), rows.wgpu(), lists.wgpu(), counts.wgpu()])?;
        let arranged = device.bind(&arrange, 2, &[arguments.wgpu()])?;
        let mut frame = device.frame()?;
        frame.pass("begin").run(&begin, &[&shared], &[], groups((count as u32).div_ceil(GROUP)))?;
        let submissions = VecDeque::from([frame.submit()?]);
        Ok(Self {
            device: device.clone(),
            look,
            pixels,
            fronts,
            rows,
            counts,
            arguments,
            _tables: tables,
            _lists: lists,
            shared,
            chunk,
            arranged,
            narrow,
            arrange,
            wide,
            submissions,
            times: Vec::new(),
        })
    }

    /// Draws particles with a share of their thickness. Fails if the device is lost.
    pub fn draw(
        &mut self,
        context: &Context,
        projection: &Projection,
        particles: &[FoamParticle],
        share: f32,
    ) -> Result<()> {
        let row = |particle: &FoamParticle| {
            let [x, y, z] = projection.to_eye(particle.position).to_array();
            FoamRow { x, y, z, life: particle.life, id: particle.id, kind: particle.kind as u32 }
        };
        let mut rows = vec![FoamRow::default(); particles.len().min(CHUNK)];
        for particles in particles.chunks(CHUNK) {
            let rows = &mut rows[..particles.len()];
            let mut parts: Vec<_> = rows.chunks_mut(CHUNK_LEN).zip(particles.chunks(CHUNK_LEN)).collect();
            context.for_each_mut(&mut parts, |_, (rows, particles)| {
                rows.iter_mut().zip(*particles).for_each(|(to, particle)| *to = row(particle));
            });
            // Chunks on their way take memory too.
            while self.submissions.len() >= AHEAD {
                self.wait()?;
            }
            self.rows.write(&self.device, 0, rows)?;
            self.submit(rows.len() as u32, share)?;
        }
        Ok(())
    }

    /// Submits the steps of the chunk that was written.
    fn submit(&mut self, count: u32, share: f32) -> Result<()> {
        let call = |step| FoamChunk { count, step, share, room: CHUNK as u32 };
        let bindings = [&self.shared, &self.chunk];
        let mut frame = self.device.frame()?;
        frame.clear(&self.counts);
        let mut pass = frame.pass("depth and thickness");
        let first = call(0);
        pass.run(&self.narrow, &bindings, bytemuck::bytes_of(&first), groups(count.div_ceil(GROUP)))?;
        pass.run(&self.arrange, &[&self.shared, &self.chunk, &self.arranged], &[], [1, 1, 1])?;
        pass.run_indirect(&self.wide, &bindings, bytemuck::bytes_of(&first), &self.arguments, 3)?;
        drop(pass);
        // Wide sprites may have lowered depths too, and are drawn in every step.
        let mut pass = frame.pass("nearest particles");
        for step in 1..STEPS {
            let call = call(step);
            pass.run_indirect(&self.narrow, &bindings, bytemuck::bytes_of(&call), &self.arguments, 0)?;
            pass.run_indirect(&self.wide, &bindings, bytemuck::bytes_of(&call), &self.arguments, 3)?;
        }
        drop(pass);
        self.submissions.push_back(frame.submit()?);
        Ok(())
    }

    /// Waits for the oldest submission.
    fn wait(&mut self) -> Result<()> {
        if let Some(submission) = self.submissions.pop_front() {
            add_times(&mut self.times, submission.wait()?);
        }
        Ok(())
    }
}

/// Adds times of passes to those of the same names.
fn add_times(times: &mut Vec<PassTime>, more: Vec<PassTime>) {
    for time in more {
        match times.iter_mut().find(|it| it.name == time.name) {
            Some(found) => found.length += time.length,
            None => times.push(time),
        }
    }
}
