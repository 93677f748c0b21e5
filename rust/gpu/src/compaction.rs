//! Multi-compaction: the indices of the items of several classes, one list each (`shaders/scan/compaction.wgsl`).
//!
//! Schäfer et al. 2014 (*Local Painting and Deformation of Meshes on the GPU*), Section 4: faces to allocate, to modify
//! and to free come out of one pass over all faces.

use std::sync::Arc;

use relievo_core::{Error, Result};

use crate::scan::{BLOCK, capacity_of};
use crate::wgsl::compaction::Classes;
use crate::{Access, Bindings, Buffer, Device, Kernel, KernelSpec, Pass, groups};

/// Classes at most.
pub const MAX_CLASSES: usize = 4;

/// Lists of the items of up to four classes.
#[derive(Debug)]
pub struct Compaction {
    kernels: [Arc<Kernel>; 3],
    bindings: Bindings,
    lists: Buffer<u32>,
    counts: Buffer<u32>,
    _sums: Buffer<[u32; 4]>,
    capacity: u32,
    classes: u32,
}

impl Compaction {
    /// Lists for `classes` classes of the items whose masks are in `masks`: bit c says that an item is in class c. Bits
    /// beyond the classes are ignored.
    ///
    /// # Errors
    /// Fails with `Internal` for no class or more than four, with `Unsupported` for more than 2³¹ items, and as
    /// [`Buffer::new`] does.
    pub fn new(device: &Device, masks: &Buffer<u32>, classes: usize) -> Result<Self> {
        if !(1..=MAX_CLASSES).contains(&classes) {
            return Err(Error::internal(format!("a compaction into {classes} classes; there are 1 to {MAX_CLASSES}")));
        }
        let capacity = capacity_of(masks.len())?;
        let sums = Buffer::new(device, "compaction sums", capacity.div_ceil(BLOCK).max(1) as usize)?;
        let lists = Buffer::new(device, "compaction lists", masks.len() * classes)?;
        let counts = Buffer::new(device, "compaction counts", 4 * classes)?;
        let kernel = |entry| {
            device.kernel(&KernelSpec {
                module: "compaction",
                entry,
                groups: &[&[Access::Read, Access::Write, Access::Write, Access::Write]],
                immediates: size_of::<Classes>() as u32,
                constants: &[],
            })
        };
        let kernels = [kernel("reduce")?, kernel("spine")?, kernel("distribute")?];
        let buffers = [masks.wgpu(), lists.wgpu(), counts.wgpu(), sums.wgpu()];
        let bindings = device.bind(&kernels[0], 0, &buffers)?;
        Ok(Self { kernels, bindings, lists, counts, _sums: sums, capacity, classes: classes as u32 })
    }

    /// The lists: that of class c begins at c times the number of masks.
    pub fn lists(&self) -> &Buffer<u32> {
        &self.lists
    }

    /// For every class four numbers: how many items its list has, and the workgroups of an indirect dispatch, in x, y
    /// and z, in which every invocation takes one of them.
    pub fn counts(&self) -> &Buffer<u32> {
        &self.counts
    }

    /// Where the arguments of an indirect dispatch over class `class` are in [`Self::counts`].
    pub fn arguments(&self, class: usize) -> usize {
        4 * class + 1
    }

    /// Records the compaction of the first `count` items.
    ///
    /// # Errors
    /// Returns the errors of [`Pass::run`]; the immediate data that it passes have the declared size.
    pub fn run(&self, pass: &mut Pass<'_>, count: u32) -> Result<()> {
        let count = count.min(self.capacity);
        let work = Classes { count, classes: self.classes, stride: self.capacity };
        let immediates = bytemuck::bytes_of(&work);
        let blocks = groups(count.div_ceil(BLOCK));
        let [reduce, spine, distribute] = &self.kernels;
        pass.run(reduce, &[&self.bindings], immediates, blocks)?;
        pass.run(spine, &[&self.bindings], immediates, [1, 1, 1])?;
        pass.run(distribute, &[&self.bindings], immediates, blocks)
    }
}
