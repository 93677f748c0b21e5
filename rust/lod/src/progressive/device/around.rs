//! What splits stand on, for meshes that are made for a view: with a split come those that made the vertices around its
//! own.

use std::sync::Arc;
use std::sync::atomic::Ordering::Relaxed;

use bytemuck::{Pod, Zeroable};
use relievo_core::{Context, Error, Result};
use relievo_gpu::{Access, Bindings, Buffer, Device, Kernel, KernelSpec, Pass, groups};

use super::{by_depth, split_vertices};
use crate::progressive::active::ActiveMesh;
use crate::progressive::hierarchy::Progressive;
use crate::progressive::view::Extents;

/// Splits that are looked at by one task.
const BATCH: usize = 256;
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

/// Splits by depth, the deepest first, and the vertices around each when it is made, which are always the same.
struct Around {
    order: Vec<u32>,
    /// Where the splits of each depth begin, and all end.
    depths: Vec<u32>,
    /// Where the vertices around each split begin, and all end.
    starts: Vec<u32>,
    /// As twice the split that a vertex comes from, or its own number in the base, and 1 if it is the second of that. The
    /// vertex that is split is the first of a list.
    nodes: Vec<u32>,
}

impl Around {
    fn new(context: &Context, mesh: &Arc<Progressive>) -> Self {
        let splits = by_depth(mesh);
        let vertices = split_vertices(mesh, &splits);
        let mut made =
            Self { order: Vec::with_capacity(splits.len()), depths: vec![0], starts: vec![0], nodes: Vec::new() };
        let mut active = ActiveMesh::new(mesh);
        for level in splits.chunk_by(|a, b| a.0 == b.0) {
            let targets: Vec<u32> = level.iter().map(|(_, split)| vertices[*split as usize]).collect();
            let lists = context.map(targets.len().div_ceil(BATCH), |part| {
                let batch = &targets[part * BATCH..targets.len().min((part + 1) * BATCH)];
                batch.iter().map(|vertex| nodes_around(&active, *vertex)).collect::<Vec<_>>()
            });
            for list in lists.into_iter().flatten() {
                made.nodes.extend(list);
                made.starts.push(made.nodes.len() as u32);
            }
            active.make(context, &targets, |_, _| None::<()>);
            made.order.extend(level.iter().map(|(_, split)| *split));
            made.depths.push(made.order.len() as u32);
        }
        made
    }
}

/// Where a vertex and those around it come from.
fn nodes_around(mesh: &ActiveMesh, vertex: u32) -> Vec<u32> {
    let mut ring: Vec<u32> = mesh.spokes(vertex).flatten().filter(|other| *other != vertex).collect();
    ring.sort_unstable();
    ring.dedup();
    let node = |vertex: u32| mesh.slots[vertex as usize].node.load(Relaxed);
    std::iter::once(vertex).chain(ring).map(node).collect()
}

/// The same on a device, with the extents of splits.
#[derive(Debug)]
pub struct DeviceAround {
    order: Buffer<u32>,
    depths: Buffer<u32>,
    starts: Buffer<u32>,
    nodes: Buffer<u32>,
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
    pub fn new(context: &Context, device: &Device, mesh: &Arc<Progressive>, extents: &Extents) -> Result<Self> {
        if extents.0.len() != mesh.vertex_count() {
            return Err(Error::invalid("they are of another mesh").at("extents"));
        }
        let around = context.within(|| Around::new(context, mesh));
        let kernel = |entry| {
            device.kernel(&KernelSpec {
                module: "progressive_spread",
                entry,
                groups: &[&[Access::Read; 4], &[Access::Write]],
                immediates: size_of::<Depths>() as u32,
                constants: &[],
            })
        };
        let kernels = [kernel("spread")?, kernel("spread_all")?];
        let order = Buffer::of(device, "splits by depth", &around.order)?;
        let depths = Buffer::of(device, "depths", &around.depths)?;
        let starts = Buffer::of(device, "starts of rings", &around.starts)?;
        let nodes = Buffer::of(device, "rings", &around.nodes)?;
        let buffers = [order.wgpu(), depths.wgpu(), starts.wgpu(), nodes.wgpu()];
        let bindings = device.bind(&kernels[0], 0, &buffers)?;
        let extents = Buffer::of(device, "extents", &extents.0)?;
        Ok(Self { order, depths, starts, nodes, extents, steps: steps(&around.depths), kernels, bindings })
    }

    /// Bytes on the device.
    pub fn bytes(&self) -> usize {
        4 * (self.order.len() + self.depths.len() + self.starts.len() + self.nodes.len() + self.extents.len())
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
