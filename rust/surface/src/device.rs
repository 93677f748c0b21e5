//! A surface on a graphics device: its control data from the points of a cage, and its evaluation by place
//! (`shaders/surface`).
//!
//! The data of a pose stays on the device. Points of patches are exact sums of integers, see `surface_pose.wgsl`, so
//! that they are the same on every device; they differ from [`Surface::posed`], which has f64, by less than f32 resolves.

use std::sync::Arc;

use relievo_core::{Error, Result};
use relievo_gpu::wgsl::surface::SurfacePatch;
use relievo_gpu::wgsl::surface_pose::{Pose, Source};
use relievo_gpu::{Access, Bindings, Buffer, Device, GROUP, Kernel, KernelSpec, Pass, groups, wgpu};
use relievo_opensubdiv::PatchKind;

use crate::bezier::{Conversion, SMOOTH};
use crate::patch::PatchForm;
use crate::{Order, Place, Surface};

/// What kernels that import `surface` have as their group 1.
pub const SURFACE_GROUP: [Access; 4] = [Access::Read; 4];

/// Bits behind the point of coordinates and weights on the device.
const BITS: i32 = 30;

/// A surface whose control data is on a device.
#[derive(Debug)]
pub struct DeviceSurface {
    cage: Buffer<f32>,
    points: Buffer<[u32; 2]>,
    kernels: [Arc<Kernel>; 2],
    pose: Pose,
    making: Bindings,
    group: Bindings,
    kept: Kept,
}

/// What the kernels read.
#[derive(Debug)]
struct Kept {
    patches: Buffer<SurfacePatch>,
    leaves: Buffer<[u32; 2]>,
    tiles: Buffer<[u32; 2]>,
    data: Buffer<f32>,
    stencils: Buffer<u32>,
    weights: Buffer<[u32; 2]>,
    sources: Buffer<Source>,
    indices: Buffer<u32>,
    conversions: Buffer<[f32; 16]>,
}

/// Kernels that evaluate a surface at the places of a buffer.
#[derive(Debug)]
pub struct Evaluation {
    kernel: Arc<Kernel>,
    buffers: Bindings,
    places: usize,
}

impl DeviceSurface {
    /// Brings a surface to a device, in its pose.
    ///
    /// # Errors
    /// Fails with `Unsupported` if the weights of a stencil are too large for the integers of the device, with `Memory`
    /// if the device has no room for the surface, and with `Device` if it was lost.
    pub fn new(device: &Device, surface: &Surface) -> Result<Self> {
        let layout = &*surface.layout;
        let table = &layout.table;
        let flat = layout.patches.iter().map(|patch| SurfacePatch {
            low: patch.low,
            size: patch.size,
            first: patch.first,
            form: u32::from(patch.form == PatchForm::Gregory),
        });
        let (mut conversions, mut sources) = (vec![matrix(&SMOOTH)], Vec::with_capacity(layout.patches.len()));
        conversions.extend(layout.pieces.conversions().map(matrix));
        for patch in &layout.patches {
            let record = &table.patches()[patch.record as usize];
            let (flags, across) = match record.kind {
                PatchKind::Gregory => (16, 0),
                PatchKind::Regular { boundary } => (u32::from(boundary), 0),
                PatchKind::SingleCrease { edge, .. } => (32 * u32::from(edge & 1), patch.piece + 1),
            };
            sources.push(Source { points: record.first, first: patch.first, flags, across });
        }
        let (stencils, weights) = stencils(surface)?;
        let leaves: Vec<_> = layout.leaves.iter().map(|leaf| [leaf.key, leaf.patch]).collect();
        let tiles: Vec<_> = layout.tile_first.iter().zip(&layout.leaf_first).map(|(a, b)| [*a, *b]).collect();
        let indices: Vec<_> = table.indices().iter().map(|index| *index as u32).collect();
        let (cage, all) = (table.cage_point_count(), table.point_count());
        let cage_points = Buffer::new(device, "cage", 3 * cage)?;
        let points = Buffer::new(device, "surface points", 3 * all)?;
        let kept = Kept {
            patches: Buffer::of(device, "surface patches", &flat.collect::<Vec<_>>())?,
            leaves: Buffer::of(device, "surface leaves", &leaves)?,
            tiles: Buffer::of(device, "surface tiles", &tiles)?,
            data: Buffer::of(device, "surface data", &surface.data)?,
            stencils: Buffer::of(device, "stencils", &stencils)?,
            weights: Buffer::of(device, "stencil weights", &weights)?,
            sources: Buffer::of(device, "patch sources", &sources)?,
            indices: Buffer::of(device, "patch points", &indices)?,
            conversions: Buffer::of(device, "conversions", &conversions)?,
        };
        use Access::{Read, Write};
        let kernel = |entry| {
            device.kernel(&KernelSpec {
                module: "surface_pose",
                entry,
                groups: &[&[Read, Read, Read, Write, Read, Read, Read, Write]],
                immediates: size_of::<Pose>() as u32,
                constants: &[],
            })
        };
        let kernels = [kernel("make_points")?, kernel("make_patches")?];
        let making = [
            cage_points.wgpu(),
            kept.stencils.wgpu(),
            kept.weights.wgpu(),
            points.wgpu(),
            kept.sources.wgpu(),
            kept.indices.wgpu(),
            kept.conversions.wgpu(),
            kept.data.wgpu(),
        ];
        let making = device.bind(&kernels[0], 0, &making)?;
        let evaluate = evaluation_kernel(device, Order::Second)?;
        let evaluated = [kept.patches.wgpu(), kept.leaves.wgpu(), kept.tiles.wgpu(), kept.data.wgpu()];
        let group = device.bind(&evaluate, 1, &evaluated)?;
        let pose = Pose { cage: cage as u32, points: all as u32, patches: layout.patches.len() as u32, scale: 1.0 };
        Ok(Self { cage: cage_points, points, kernels, pose, making, group, kept })
    }

    /// What is bound as group 1 of kernels that import `surface`.
    pub fn group(&self) -> &Bindings {
        &self.group
    }

    /// The buffers of [`Self::group`] in the order of their bindings, for pipelines that draw.
    pub fn buffers(&self) -> [&wgpu::Buffer; 4] {
        let kept = &self.kept;
        [kept.patches.wgpu(), kept.leaves.wgpu(), kept.tiles.wgpu(), kept.data.wgpu()]
    }

    /// Writes the points of a pose, which [`Self::pose`] then turns into control data.
    ///
    /// # Errors
    /// Fails with `Invalid` unless there are as many points as the cage has, all finite, and with `Device` if the
    /// device was lost.
    pub fn set_points(&mut self, device: &Device, points: &[[f32; 3]]) -> Result<()> {
        if points.len() != self.pose.cage as usize {
            return Err(Error::invalid(format!("the pose has {} points, the cage {}", points.len(), self.pose.cage)));
        }
        let finite = |point: &[f32; 3]| point.iter().all(|value| value.is_finite());
        if let Some(index) = points.iter().position(|point| !finite(point)) {
            return Err(Error::invalid("a coordinate is not a finite number").at(format!("point {index}")));
        }
        let largest = points.iter().flatten().fold(0.0_f32, |most, value| most.max(value.abs()));
        self.pose.scale = scale(largest);
        self.cage.write(device, 0, bytemuck::cast_slice(points))
    }

    /// Records the control data of the points that were set.
    ///
    /// # Errors
    /// Returns the errors of [`Pass::run`]; the immediate data that it passes have the declared size.
    pub fn pose(&self, pass: &mut Pass<'_>) -> Result<()> {
        let immediates = bytemuck::bytes_of(&self.pose);
        let size = |count: u32| groups(count.div_ceil(GROUP));
        pass.run(&self.kernels[0], &[&self.making], immediates, size(self.pose.points))?;
        pass.run(&self.kernels[1], &[&self.making], immediates, size(3 * self.pose.patches))
    }

    /// Bytes of the points that control data is made of.
    pub fn point_bytes(&self) -> u64 {
        8 * self.points.len() as u64
    }

    /// The evaluation of the surface at `places`. Samples are P, du, dv, duu, duv, dvv, as many as `order` asks for, three
    /// numbers each; those in a hole, outside a tile or of no tile are zeros.
    ///
    /// # Errors
    /// Fails with `Internal` if `samples` is shorter than that, and with `Memory` or `Device` if the device has no
    /// memory for the kernel or was lost.
    pub fn evaluation(
        &self,
        device: &Device,
        places: &Buffer<Place>,
        order: Order,
        samples: &Buffer<f32>,
    ) -> Result<Evaluation> {
        let needed = 3 * order.quantities() * places.len();
        if samples.len() < needed {
            return Err(Error::internal(format!("room for {} of {needed} numbers of samples", samples.len())));
        }
        let kernel = evaluation_kernel(device, order)?;
        let buffers = device.bind(&kernel, 0, &[places.wgpu(), samples.wgpu()])?;
        Ok(Evaluation { kernel, buffers, places: places.len() })
    }

    /// Records an evaluation at the first `count` places.
    ///
    /// # Errors
    /// Returns the errors of [`Pass::run`]; the immediate data that it passes have the declared size.
    pub fn evaluate(&self, pass: &mut Pass<'_>, evaluation: &Evaluation, count: u32) -> Result<()> {
        let count = count.min(evaluation.places as u32);
        let size = groups(count.div_ceil(GROUP));
        pass.run(&evaluation.kernel, &[&evaluation.buffers, &self.group], bytemuck::bytes_of(&count), size)
    }
}

fn evaluation_kernel(device: &Device, order: Order) -> Result<Arc<Kernel>> {
    device.kernel(&KernelSpec {
        module: "surface_evaluate",
        entry: "evaluate",
        groups: &[&[Access::Read, Access::Write], &SURFACE_GROUP],
        immediates: size_of::<u32>() as u32,
        constants: &[("QUANTITIES", order.quantities() as f64)],
    })
}

/// The power of two that brings coordinates up to `largest` to [`BITS`] bits, within what an f32 can hold of it and of
/// its reciprocal.
fn scale(largest: f32) -> f32 {
    let exponent = if largest > 0.0 { largest.log2().ceil() as i32 } else { 0 };
    // The logarithm is rounded: one bit is left for it.
    2.0_f32.powi((BITS - 1 - exponent).clamp(-90, 90))
}

/// Columns of a matrix of WGSL are our rows.
fn matrix(conversion: &Conversion) -> [f32; 16] {
    std::array::from_fn(|i| conversion[i / 4][i % 4] as f32)
}

/// The first weight of every stencil, and all weights with the cage's points they are for. Those of a stencil sum to 1
/// exactly, so that a point moves with its cage.
fn stencils(surface: &Surface) -> Result<(Vec<u32>, Vec<[u32; 2]>)> {
    let layout = &*surface.layout;
    let (indices, weights) = layout.table.stencil_weights();
    let one = f64::from(1 << BITS);
    let mut all = Vec::with_capacity(weights.len());
    let mut firsts = Vec::with_capacity(layout.stencil_first.len());
    firsts.push(0);
    for (stencil, range) in layout.stencil_first.windows(2).enumerate() {
        let range = range[0]..range[1];
        let mut rounded: Vec<i64> = weights[range.clone()].iter().map(|weight| (weight * one).round() as i64).collect();
        let missing = (1_i64 << BITS) - rounded.iter().sum::<i64>();
        if let Some(largest) = rounded.iter_mut().max_by_key(|weight| weight.abs()) {
            *largest += missing;
        }
        // Sums of 64 bits hold coordinates of 30 bits times this.
        let small = rounded.iter().map(|weight| weight.abs()).sum::<i64>() < 7 << BITS;
        if !small || rounded.iter().any(|weight| i32::try_from(*weight).is_err()) {
            return Err(Error::unsupported("the weights of a stencil are too large for a graphics device")
                .at(format!("stencil {stencil}"))
                .advise("use the device `cpu`"));
        }
        all.extend(indices[range].iter().zip(rounded).map(|(index, weight)| [*index as u32, weight as i32 as u32]));
        firsts.push(all.len() as u32);
    }
    Ok((firsts, all))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coordinates_fit_their_bits() {
        for largest in [0.0, 1e-30, 0.999, 1.0, 1.001, 3.0e7, 1e30] {
            let scaled = largest * scale(largest);
            assert!(scaled <= 2.0_f32.powi(BITS), "{largest}: {scaled}");
            assert!(largest == 0.0 || scaled >= 2.0_f32.powi(BITS - 3) || largest < 1e-15, "{largest}: {scaled}");
        }
    }
}
