//! What is around splits when they are made: what they stand on, for meshes that are made for a view, and what their
//! vertices follow, when the mesh is edited.

use std::sync::Arc;

use relievo_core::{Context, Error, Result};
use relievo_gpu::wgsl::progressive_spread::Depths;
use relievo_gpu::{Access, Bindings, Buffer, GROUP, Kernel, KernelSpec, Pass, groups};

use super::hierarchy::{DeviceHierarchy, by_depth};
use super::windows::Windows;
use crate::progressive::build::cut::Cut;
use crate::progressive::build::hierarchy::Progressive;
use crate::progressive::edit::stars::{HEAD, Star, Stars};
use crate::progressive::mesh::active::ActiveMesh;
use crate::progressive::mesh::view::Extents;

/// Neighbours of a vertex at most: kernels look at them some ten times over, and drivers end loops of an invocation without
/// a word when they have taken 65,535 turns together.
const NEIGHBOURS: usize = 4096;
/// Splits of a depth that one workgroup takes along with other depths, and turns that its invocations take at most.
const SMALL_SIZE: u32 = 1024;
const TURNS: u32 = 1 << 15;

/// In `stars`, above the node of a vertex around: its edge to the first vertex of the split is a border; shifted by 1, that
/// to the second.
const BORDER: u32 = 1 << 30;

/// What is around splits, as a device has it.
struct Around {
    starts: Vec<u32>,
    numbers: Vec<u32>,
    /// Of each depth where its splits begin and how many vertices are around one of them at most.
    depths: Vec<(u32, u32)>,
}

impl Around {
    /// Of the splits of a mesh by their depths.
    fn new(context: &Context, mesh: &Arc<Progressive>, splits: &[(u32, u32)]) -> Result<Self> {
        let mut active = ActiveMesh::new(mesh);
        active.adapt(context, Cut::FINEST);
        let mut stars = Stars::new(mesh.vertex_count());
        context.within(|| stars.complete(context, &active));
        let (starts, numbers) = stars.parts();
        if u32::try_from(numbers.len()).is_err() {
            return Err(Error::unsupported("what is around splits is too much for a graphics device"));
        }
        let starts = starts.iter().map(|start| *start as u32).collect();
        let mut made = Self { starts, numbers: numbers.to_vec(), depths: Vec::new() };
        let (mut counts, mut first) = (Vec::new(), 0);
        for level in splits.chunk_by(|a, b| a.0 == b.0) {
            let mut most = 0;
            for (_, split) in level {
                let star = stars.star(*split);
                most = most.max(star.ring.len());
                made.mark_borders(*split, &star, &mut counts);
            }
            if most > NEIGHBOURS {
                let error = format!("a vertex has {most} neighbours; on a graphics device it has at most {NEIGHBOURS}");
                return Err(Error::unsupported(error).advise("use the processor"));
            }
            made.depths.push((first, most as u32));
            first += level.len() as u32;
        }
        Ok(made)
    }

    fn mark_borders(&mut self, split: u32, star: &Star<'_>, counts: &mut Vec<u32>) {
        let ring = self.starts[split as usize] as usize + HEAD;
        for side in 0..2 {
            counts.clear();
            counts.resize(star.ring.len() + 2, 0);
            star.spokes(side).flatten().for_each(|number| counts[number] += 1);
            let borders = counts[..star.ring.len()].iter().enumerate().filter(|(_, count)| **count == 1);
            borders.for_each(|(number, _)| self.numbers[ring + number] |= BORDER << side);
        }
    }
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
    starts: Buffer<u32>,
    /// As [`Stars`] has them, with [`BORDER`].
    stars: Windows<u32, 3>,
    /// Of both, as in `progressive_stars.wgsl`.
    pub around: Bindings,
    pub extents: Buffer<f32>,
    steps: Vec<Step>,
    kernels: [Arc<Kernel>; 2],
    splits: Bindings,
    by_depth: Bindings,
}

/// A dispatch of the closure.
#[derive(Clone, Copy, Debug)]
struct Step {
    depths: Depths,
    /// Splits of the only depth, or 0 where one workgroup takes all that it has.
    splits: u32,
    /// Turns that loops of an invocation of that workgroup take.
    turns: u32,
}

impl DeviceAround {
    /// Of a mesh whose splits are on the device.
    pub fn new(context: &Context, whole: &DeviceHierarchy, mesh: &Arc<Progressive>, extents: &Extents) -> Result<Self> {
        if extents.0.len() != mesh.vertex_count() {
            return Err(Error::invalid("they are of another mesh").at("extents"));
        }
        let (device, splits) = (&whole.device, by_depth(mesh));
        let Around { starts, numbers, depths: levels } = Around::new(context, mesh, &splits)?;
        let order: Vec<u32> = splits.iter().map(|(_, split)| *split).collect();
        let ends: Vec<u32> = levels.iter().map(|level| level.0).chain([order.len() as u32]).collect();
        let order = Buffer::of(device, "splits by depth", &order)?;
        let depths = Buffer::of(device, "depths", &ends)?;
        let starts = Buffer::of(device, "starts of stars", &starts)?;
        let stars = Windows::of(device, "stars", &numbers, whole.window)?;
        let buffers = [&[starts.wgpu()], &stars.wgpu()[..]].concat();
        let around = device.bind_as(&[Access::Read; 4], &buffers)?;
        let kernel = |entry| {
            device.kernel(&KernelSpec {
                module: "progressive_spread",
                entry,
                groups: &[&[Access::Read], &[Access::Write], &[Access::Read; 2], &[Access::Read; 4]],
                immediates: size_of::<Depths>() as u32,
                constants: &[("STARS", stars.size())],
            })
        };
        let kernels = [kernel("spread")?, kernel("spread_all")?];
        let blocks = device.bind(&kernels[0], 0, &[whole.splits.wgpu()])?;
        let by_depth = device.bind(&kernels[0], 2, &[order.wgpu(), depths.wgpu()])?;
        let extents = Buffer::of(device, "extents", &extents.0)?;
        let rings: Vec<u32> = levels.iter().map(|level| level.1).collect();
        let steps = steps(&ends, &rings);
        Ok(Self { order, ends, depths, starts, stars, around, extents, steps, kernels, splits: blocks, by_depth })
    }

    /// Bytes on the device.
    pub fn bytes(&self) -> usize {
        4 * (self.order.len() + self.depths.len() + self.starts.len() + self.extents.len()) + self.stars.bytes()
    }

    /// The constants of the bindings of what is around.
    pub fn constants(&self) -> [(&'static str, f64); 1] {
        [("STARS", self.stars.size())]
    }

    /// Records the closure of what is marked in `there`.
    pub fn close(&self, pass: &mut Pass<'_>, there: &Bindings) -> Result<()> {
        let [one, several] = &self.kernels;
        for Step { depths, splits, .. } in &self.steps {
            let (kernel, size) = match splits {
                0 => (several, [1, 1, 1]),
                splits => (one, groups(splits.div_ceil(GROUP))),
            };
            pass.run(kernel, &[&self.splits, there, &self.by_depth, &self.around], bytemuck::bytes_of(depths), size)?;
        }
        Ok(())
    }
}

/// The depths from the least on, of which those of few splits go together, given how many vertices are around a split of
/// each at most.
fn steps(ends: &[u32], rings: &[u32]) -> Vec<Step> {
    let mut steps: Vec<Step> = Vec::new();
    for depth in (0..rings.len()).rev() {
        let size = ends[depth + 1] - ends[depth];
        let turns = 1 + size.div_ceil(GROUP) * (rings[depth] + 2);
        let is_small = size <= SMALL_SIZE && turns <= TURNS;
        match steps.last_mut() {
            Some(step) if is_small && step.splits == 0 && step.turns + turns <= TURNS => {
                step.depths.count += 1;
                step.turns += turns;
            }
            _ => {
                let depths = Depths { last: depth as u32, count: 1 };
                steps.push(Step { depths, splits: if is_small { 0 } else { size }, turns });
            }
        }
    }
    steps
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn depths_are_looked_at_from_the_least_and_small_ones_together() {
        let ends: Vec<u32> = (0..=300).chain([2000, 4000, 4001, 4003]).collect();
        // One with many neighbours in the middle, and a few before it.
        let rings: Vec<u32> = (0..304).map(|depth| if (100..120).contains(&depth) { 4096 } else { 6 }).collect();
        let steps = steps(&ends, &rings);
        let passed = steps.iter().flat_map(|step| (0..step.depths.count).map(|k| step.depths.last - k));
        assert!(passed.eq((0..304).rev()));
        let sizes: Vec<_> = steps.iter().map(|step| (step.depths.count, step.splits)).collect();
        // Seven times 4,099 turns are below 2¹⁵; those of six neighbours fill up what is left of them.
        assert_eq!(sizes, [(2, 0), (1, 2000), (1, 1700), (187, 0), (7, 0), (106, 0)]);
        assert!(steps.iter().all(|step| step.splits > 0 || step.turns <= TURNS));
    }
}
