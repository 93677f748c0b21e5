//! Values of a grid: at points, of voxels, and of dense blocks.

use relievo_core::progress::Silent;
use relievo_core::{Budget, Context, Error, Result};

use crate::call;
use crate::grid::Grid;
use crate::info::Kind;
use crate::module::Module;

/// A dense block of voxels. Values are in the bytes of the grid's kind, native byte order, and x varies slowest: floats,
/// doubles, bytes (0 or 1, of bools and masks), integers, or three numbers a voxel.
#[derive(Clone, Debug, PartialEq)]
pub struct Block {
    /// The lowest voxel.
    pub low: [i32; 3],
    /// Voxels along each axis.
    pub size: [u32; 3],
    /// The kind of values.
    pub kind: Kind,
    /// Their bytes.
    pub bytes: Vec<u8>,
}

impl Block {
    /// Returns the bytes of a block. Fails if it is empty, too far from 0 or larger than `limit` bytes.
    fn length(low: [i32; 3], size: [u32; 3], kind: Kind, limit: u64) -> Result<usize> {
        let is_near = |axis: usize| {
            let last = i64::from(low[axis]) + i64::from(size[axis]) - 1;
            size[axis] > 0 && low[axis] >= -(1 << 30) && last <= 1 << 30
        };
        if !(0..3).all(is_near) {
            let error = Error::invalid("the block is empty, or more than 2³⁰ voxels from 0");
            return Err(error.at("size").advise("give it at least one voxel along each axis"));
        }
        let bytes = size.iter().try_fold(kind.value_bytes(), |bytes, edge| bytes.checked_mul(u64::from(*edge)));
        let bytes = bytes.filter(|bytes| *bytes <= limit).and_then(|bytes| usize::try_from(bytes).ok());
        bytes.ok_or_else(|| {
            Error::memory(format!("the block needs more than the memory limit of {limit} bytes"))
                .advise("take a smaller block, or raise the memory limit")
        })
    }
}

impl Grid {
    /// Returns the values at world positions, as many numbers a point as a value has; trilinear between voxels where
    /// `is_linear`, otherwise of the nearest voxel. Integers above 2⁵³ are rounded.
    ///
    /// # Errors
    /// Fails with `Invalid` if a position is not finite.
    pub fn sample(&self, points: &[[f64; 3]], is_linear: bool) -> Result<Vec<f64>> {
        if let Some(index) = points.iter().position(|point| point.iter().any(|at| !at.is_finite())) {
            return Err(Error::invalid("the position is not finite").at(format!("point {index}")));
        }
        let module = Module::open()?;
        let mut values = vec![0.0; points.len() * self.kind()?.components()];
        let mut error = call::record();
        // SAFETY: the grid is alive, there are three numbers of each point and room for the values of all.
        let result = unsafe {
            let (places, count) = (points.as_flattened().as_ptr(), points.len());
            let table = module.table();
            table.rlvdb_sample(self.pointer(), places, count, is_linear.into(), values.as_mut_ptr(), &mut error)
        };
        call::check(result, &error)?;
        Ok(values)
    }

    /// Returns the values of voxels, as many numbers a voxel as a value has.
    ///
    /// # Errors
    /// Fails only as [`Self::kind`] does; voxels outside of all leaves have the background.
    pub fn voxels(&self, voxels: &[[i32; 3]]) -> Result<Vec<f64>> {
        let module = Module::open()?;
        let mut values = vec![0.0; voxels.len() * self.kind()?.components()];
        let mut error = call::record();
        // SAFETY: the grid is alive, there are three numbers of each voxel and room for the values of all.
        let result = unsafe {
            let (places, count) = (voxels.as_flattened().as_ptr(), voxels.len());
            module.table().rlvdb_voxels(self.pointer(), places, count, values.as_mut_ptr(), &mut error)
        };
        call::check(result, &error)?;
        Ok(values)
    }

    /// Copies a block of voxels: `low` is the lowest one, `size` how many there are along each axis.
    ///
    /// # Errors
    /// Fails with `Invalid` if the block is empty or more than 2³⁰ voxels from 0, and with `Memory` if it is larger
    /// than the memory limit.
    pub fn block(&self, context: &Context, low: [i32; 3], size: [u32; 3]) -> Result<Block> {
        let module = Module::open()?;
        let kind = self.kind()?;
        let length = Block::length(low, size, kind, context.memory_limit())?;
        let mut bytes = Budget::new(u64::MAX).filled(length, 0u8)?;
        call::run(context, "copy block", &mut Silent, |how, error| {
            let (out, count) = (bytes.as_mut_ptr().cast(), bytes.len());
            // SAFETY: the grid is alive, three numbers are read of both arrays, and the block is as long as stated.
            unsafe {
                module.table().rlvdb_dense_get(self.pointer(), low.as_ptr(), size.as_ptr(), out, count, how, error)
            }
        })?;
        Ok(Block { low, size, kind, bytes })
    }

    /// Sets a block of voxels. Values within `tolerance` of the background become the background and are not active.
    ///
    /// # Errors
    /// Fails with `Invalid` if the block is of another kind, does not have its size, is empty or more than 2³⁰ voxels
    /// from 0, has a number that is not finite, or the tolerance is negative or not finite, and with `Memory` if it is
    /// larger than the memory limit.
    pub fn set_block(&mut self, context: &Context, block: &Block, tolerance: f64) -> Result<()> {
        let module = Module::open()?;
        let kind = self.kind()?;
        let Block { low, size, ref bytes, .. } = *block;
        let length = Block::length(low, size, kind, context.memory_limit())?;
        if block.kind != kind || bytes.len() != length {
            let what = format!("the block has {} bytes of {}", bytes.len(), block.kind.name());
            return Err(Error::invalid(what).at("block").advise(format!("give it {length} bytes of {}", kind.name())));
        }
        if !(tolerance >= 0.0 && tolerance.is_finite()) {
            return Err(Error::invalid(format!("{tolerance} is no tolerance")).at("tolerance").advise("use 0 or more"));
        }
        let is_sound = match kind {
            Kind::Bool | Kind::Mask => bytes.iter().all(|byte| *byte <= 1),
            Kind::Float | Kind::Vec3s => bytes.chunks_exact(4).all(|at| f32_of(at).is_finite()),
            Kind::Double | Kind::Vec3d => bytes.chunks_exact(8).all(|at| f64_of(at).is_finite()),
            _ => true,
        };
        if !is_sound {
            let error = Error::invalid("a value is not finite, or a truth value is neither 0 nor 1").at("block");
            return Err(error.advise("replace such values first"));
        }
        let grid = self.pointer_mut();
        call::run(context, "set block", &mut Silent, |how, error| {
            let (values, count) = (bytes.as_ptr().cast(), bytes.len());
            // SAFETY: the grid is alive and ours alone, three numbers are read of both arrays, the block is as long as
            // stated, and its truth values are 0 or 1.
            unsafe {
                let (low, size) = (low.as_ptr(), size.as_ptr());
                module.table().rlvdb_dense_set(grid, low, size, values, count, tolerance, how, error)
            }
        })
    }
}

fn f32_of(bytes: &[u8]) -> f32 {
    bytes.try_into().map(f32::from_ne_bytes).unwrap_or(f32::NAN)
}

fn f64_of(bytes: &[u8]) -> f64 {
    bytes.try_into().map(f64::from_ne_bytes).unwrap_or(f64::NAN)
}
