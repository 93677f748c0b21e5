//! What is around splits when they are made: what they stand on, for meshes that are made for a view, and what their
//! vertices follow, when the mesh is edited.

use std::sync::Arc;

use bytemuck::{Pod, Zeroable};
use relievo_core::{Context, Error, Result};
use relievo_gpu::{Access, Bindings, Buffer, Device, Kernel, KernelSpec, Pass, groups};

use super::{SplitBlock, by_depth};
use crate::progressive::active::ActiveMesh;
use crate::progressive::cut::Cut;
use crate::progressive::hierarchy::Progressive;
use crate::progressive::stars::{HEAD, Stars};
use crate::progressive::view::Extents;

/// Splits of a depth that one workgroup takes along with other depths, and so many of those.
const FEW: u32 = 1024;
const RUN: usize = 128;

/// As in `progressive_spread.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
struct Depths {
    last: u32,
    count: u32,
}

/// In `stars`, above the node of a vertex around: its edge to the first vertex of the split is a border; shifted by 1, that
/// to the second.
const BORDER: u32 = 1 << 30;

/// What is around splits, of all that are there.
fn stars(context: &Context, mesh: &Arc<Progressive>, splits: &[(u32, u32)]) -> Result<[Vec<u32>; 2]> {
    let mut active = ActiveMesh::new(mesh);
    active.adapt(context, Cut::FINEST);
    let mut stars = Stars::new(mesh.vertex_count());
    context.within(|| stars.complete(context, &active));
    let (starts, numbers) = stars.parts();
    if u32::try_from(numbers.len()).is_err() {
        return Err(Error::unsupported("what is around splits is too much for a graphics device"));
    }
    let (starts, mut numbers): (Vec<u32>, _) = (starts.iter().map(|start| *start as u32).collect(), numbers.to_vec());
    let mut counts = Vec::new();
    for (_, split) in splits {
        let star = stars.star(*split);
        if star.is_wide {
            return Err(Error::unsupported("a vertex has more than 65,533 neighbours, too many for a graphics device"));
        }
        let ring = starts[*split as usize] as usize + HEAD;
        for side in 0..2 {
            counts.clear();
            counts.resize(star.ring.len() + 2, 0u32);
            star.spokes(side).flatten().for_each(|number| counts[number] += 1);
            let borders = counts[..star.ring.len()].iter().enumerate().filter(|(_, count)| **count == 1);
            borders.for_each(|(number, _)| numbers[ring + number] |= BORDER << side);
        }
    }
    Ok([starts, numbers])
}

/// What is around splits, on a device.
#[derive(Debug)]
pub struct DeviceAround {
    /// Splits by depth, the deepest first.
    pub order: Buffer<u32>,
    /// Where those of each depth begin, and all end.
    pub ends: Vec<u32>,
    depths: Buffer<u32>,
    /// Of every split where its numbers begin in `stars`.
    pub starts: Buffer<u32>,
    /// As [`Stars`] has them, with [`BORDER`].
    pub stars: Buffer<u32>,
    pub extents: Buffer<f32>,
    steps: Vec<Step>,
    kernels: [Arc<Kernel>; 2],
    bindings: Bindings,
}

/// A dispatch of the closure.
#[derive(Clone, Copy, Debug)]
struct Step {
    depths: Depths,
    /// Splits of the only depth, or 0 where one workgroup takes several depths.
    splits: u32,
}

impl DeviceAround {
    /// Of a mesh whose splits are on the device.
    pub fn new(
        context: &Context,
        device: &Device,
        (mesh, blocks): (&Arc<Progressive>, &Buffer<SplitBlock>),
        extents: &Extents,
    ) -> Result<Self> {
        if extents.0.len() != mesh.vertex_count() {
            return Err(Error::invalid("they are of another mesh").at("extents"));
        }
        let splits = by_depth(mesh);
        let [starts, stars] = stars(context, mesh, &splits)?;
        let order: Vec<u32> = splits.iter().map(|(_, split)| *split).collect();
        let mut ends = vec![0];
        for level in splits.chunk_by(|a, b| a.0 == b.0) {
            ends.push(ends[ends.len() - 1] + level.len() as u32);
        }
        let kernel = |entry| {
            device.kernel(&KernelSpec {
                module: "progressive_spread",
                entry,
                groups: &[&[Access::Read; 5], &[Access::Write]],
                immediates: size_of::<Depths>() as u32,
                constants: &[],
            })
        };
        let kernels = [kernel("spread")?, kernel("spread_all")?];
        let order = Buffer::of(device, "splits by depth", &order)?;
        let depths = Buffer::of(device, "depths", &ends)?;
        let starts = Buffer::of(device, "starts of stars", &starts)?;
        let stars = Buffer::of(device, "stars", &stars)?;
        let buffers = [blocks.wgpu(), order.wgpu(), depths.wgpu(), starts.wgpu(), stars.wgpu()];
        let bindings = device.bind(&kernels[0], 0, &buffers)?;
        let extents = Buffer::of(device, "extents", &extents.0)?;
        let steps = steps(&ends);
        Ok(Self { order, ends, depths, starts, stars, extents, steps, kernels, bindings })
    }

    /// Bytes on the device.
    pub fn bytes(&self) -> usize {
        4 * (self.order.len() + self.depths.len() + self.starts.len() + self.stars.len() + self.extents.len())
    }

    /// Records the closure of what is marked in `there`.
    pub fn close(&self, pass: &mut Pass<'_>, there: &Bindings) -> Result<()> {
        let [one, several] = &self.kernels;
        for Step { depths, splits } in &self.steps {
            let (kernel, size) = match splits {
                0 => (several, [1, 1, 1]),
                splits => (one, groups(splits.div_ceil(relievo_gpu::GROUP))),
            };
            pass.run(kernel, &[&self.bindings, there], bytemuck::bytes_of(depths), size)?;
        }
        Ok(())
    }
}

/// The depths from the least on, of which those of few splits go together.
fn steps(depths: &[u32]) -> Vec<Step> {
    let mut steps = Vec::new();
    let sizes: Vec<(u32, u32)> = (0..).zip(depths.windows(2).map(|ends| ends[1] - ends[0])).collect();
    for run in sizes.chunk_by(|a, b| a.1 <= FEW && b.1 <= FEW).rev() {
        for part in run.rchunks(RUN) {
            let (last, size) = part[part.len() - 1];
            let splits = if size > FEW { size } else { 0 };
            steps.push(Step { depths: Depths { last, count: part.len() as u32 }, splits });
        }
    }
    steps
}

#[cfg(test)]
mod tests {
    use super::*;
    use relievo_testing::wgsl::assert_layout;
    use std::mem::offset_of;

    #[test]
    fn layouts_are_those_of_the_shaders() {
        let depths = [("last", offset_of!(Depths, last)), ("count", offset_of!(Depths, count))];
        assert_layout("progressive_spread", "Depths", size_of::<Depths>(), &depths);
    }

    #[test]
    fn depths_are_looked_at_from_the_least_and_small_ones_together() {
        let ends: Vec<u32> = (0..=300).chain([2000, 4000, 4001, 4003]).collect();
        let steps = steps(&ends);
        let passed = steps.iter().flat_map(|step| (0..step.depths.count).map(|k| step.depths.last - k));
        assert!(passed.eq((0..304).rev()));
        let sizes: Vec<_> = steps.iter().map(|step| (step.depths.count, step.splits)).collect();
        assert_eq!(sizes, [(2, 0), (1, 2000), (1, 1700), (128, 0), (128, 0), (44, 0)]);
    }
}
