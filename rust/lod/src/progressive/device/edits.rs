//! Edits of a mesh on a device: handles at its vertices, and how finer and coarser levels follow, as `moves` and `coarser`
//! have them on the processor, depth by depth. Splits of one depth do not touch each other, so all of them are looked at at
//! the same time.

use std::sync::Arc;

use relievo_core::{Error, Result};
use relievo_gpu::wgsl::progressive::Place;
use relievo_gpu::wgsl::progressive_edit::{EditCall, RegionBlock};
use relievo_gpu::wgsl::progressive_follow::FollowCall;
use relievo_gpu::wgsl::progressive_touch::DepthCall;
use relievo_gpu::{Access, Bindings, Buffer, GROUP, Kernel, KernelSpec, Pass, groups};

use super::around::DeviceAround;
use super::hierarchy::DeviceHierarchy;
use super::places::Places;
use super::records::{Record, Records};
use super::windows::Windows;
use crate::progressive::edit::handle::{Edit, Handle, Region};
use crate::progressive::edit::moves::MIN_MOVE;

/// What was edited.
#[derive(Debug)]
pub struct Edits {
    pub places: Places,
    /// Of nodes, where they would have been built.
    pub notes: Windows<Place, 2>,
    before: Buffer<u32>,
    reached: Buffer<u32>,
    /// Of the vertices before, for kernels that mark.
    pub marking: Bindings,
    records: Records,
    reach: [Arc<Kernel>; 2],
    touch: Arc<Kernel>,
    refine: Arc<Kernel>,
    coarsen: Arc<Kernel>,
    /// Of what is built, with splits by their depths or without; of splits alone, and their order alone.
    built: [Bindings; 2],
    splits: [Bindings; 2],
    /// Of edits, of what they touch, of refining and of coarsening.
    states: [Bindings; 4],
    /// What is around splits.
    stars: Bindings,
}

/// An edit that is to be made.
#[derive(Debug)]
pub struct Reaching {
    call: EditCall,
    regions: Bindings,
    /// Vertices that it reaches.
    pub reached: usize,
    /// What it replaces.
    pub record: Record,
}

impl Edits {
    /// Nothing is edited yet. `there` says which vertices there are.
    pub fn new(hierarchy: &DeviceHierarchy, around: &DeviceAround, there: &Buffer<u32>) -> Result<Self> {
        let device = &hierarchy.device;
        let places = Places::new(hierarchy)?;
        let notes = Windows::<Place, 2>::new(device, "notes of splits", 2 * hierarchy.vertices, hierarchy.window)?;
        let (of_places, of_stars) = (places.constants(), around.constants());
        let both = [of_places, of_stars].concat();
        let before = Buffer::new(device, "vertices before", there.len())?;
        let reached = Buffer::new(device, "reached", 2)?;
        let kernel = |module, entry, groups: &[&[Access]], immediates: usize, constants: &[(&str, f64)]| {
            device.kernel(&KernelSpec { module, entry, groups, immediates: immediates as u32, constants })
        };
        let (read, write) = (Access::Read, Access::Write);
        let edited: &[&[Access]] = &[&[read; 3], &[write], &[write; 2], &[write, read, write]];
        let edit = |entry| kernel("progressive_edit", entry, edited, size_of::<EditCall>(), &of_places);
        let reach = [edit("reach")?, edit("move_reached")?];
        let near: &[&[Access]] = &[&[read], &[write; 2], &[read], &[read; 4]];
        let touch = kernel("progressive_touch", "touch", near, size_of::<DepthCall>(), &of_stars)?;
        let followed: &[&[Access]] = &[&[read; 4], &[write; 4], &[write; 2], &[read; 4]];
        let follow = |module, entry| kernel(module, entry, followed, size_of::<FollowCall>(), &both);
        let refine = follow("progressive_refine", "refine")?;
        let coarsen = follow("progressive_coarsen", "coarsen")?;
        let built = [hierarchy.splits.wgpu(), hierarchy.inner.wgpu(), hierarchy.leaves.wgpu()];
        let [splits, inner, leaves] = built;
        let order = around.order.wgpu();
        let records = Records::new(hierarchy, &places, &notes)?;
        let touched = records.touched.wgpu();
        let there = there.wgpu();
        let [one, more] = notes.wgpu();
        let states = [
            device.bind(&reach[0], 1, &[there])?,
            device.bind(&touch, 1, &[there, touched])?,
            device.bind(&refine, 1, &[there, before.wgpu(), one, more])?,
            device.bind(&coarsen, 1, &[there, touched, one, more])?,
        ];
        let built = [device.bind(&reach[0], 0, &built)?, device.bind(&refine, 0, &[splits, inner, leaves, order])?];
        let splits = [device.bind(&touch, 0, &[splits])?, device.bind(&touch, 2, &[order])?];
        let stars = around.around.clone();
        let marking = device.bind_as(&[write; 2], &[before.wgpu(), reached.wgpu()])?;
        Ok(Self {
            places,
            notes,
            before,
            reached,
            marking,
            records,
            reach,
            touch,
            refine,
            coarsen,
            built,
            splits,
            states,
            stars,
        })
    }

    /// Finds what an edit reaches of the vertices that there are, and what it replaces at coarser levels, and waits for it.
    /// Fails if it reaches none, or one would go where there is no number; nothing has changed then.
    pub fn reach(&self, hierarchy: &DeviceHierarchy, ends: &[u32], edit: &Edit) -> Result<Reaching> {
        // Nor is a buffer without anything bound.
        if edit.handles.is_empty() {
            return Err(reaches_nothing());
        }
        let device = &hierarchy.device;
        let handles = edit.handles.iter().map(block);
        let held =
            |anchor: &Region| block(&Handle { region: *anchor, translation: [0.0; 3], axis: [0.0; 3], angle: 0.0 });
        let blocks: Vec<RegionBlock> = handles.chain(edit.anchors.iter().map(held)).collect();
        let regions = Buffer::of(device, "regions", &blocks)?;
        let touched = &self.records.touched;
        let regions = device.bind(&self.reach[0], 3, &[self.reached.wgpu(), regions.wgpu(), touched.wgpu()])?;
        let call = EditCall {
            vertices: hierarchy.vertices as u32,
            handles: edit.handles.len() as u32,
            anchors: edit.anchors.len() as u32,
        };
        let mut frame = device.frame()?;
        frame.clear(&self.reached);
        frame.clear(touched);
        let mut pass = frame.pass("reach");
        let bindings = [&self.built[0], &self.states[0], &self.places.bindings, &regions];
        pass.run(&self.reach[0], &bindings, bytemuck::bytes_of(&call), nodes(hierarchy))?;
        let [splits, order] = &self.splits;
        let near = [splits, &self.states[1], order, &self.stars];
        for depth in ends.windows(2).rev() {
            let depth = DepthCall { first: depth[0], count: depth[1] - depth[0] };
            let size = groups(depth.count.div_ceil(GROUP));
            pass.run(&self.touch, &near, bytemuck::bytes_of(&depth), size)?;
        }
        self.records.count(&mut pass)?;
        drop(pass);
        let reached = frame.read(&self.reached, 0..2)?;
        let replaced = self.records.read_count(&mut frame)?;
        let _ = frame.submit()?;
        match reached.get(device)?[..] {
            [0, _] => Err(reaches_nothing()),
            [reached, 0] => {
                let count = replaced.get(device)?.first().copied().unwrap_or_default();
                let record = self.records.record(device, count)?;
                Ok(Reaching { call, regions, reached: reached as usize, record })
            }
            _ => Err(Error::invalid("vertices would go where there is no number").advise("use smaller translations")),
        }
    }

    /// Records that an edit is made that was the last to reach something: the vertices move, and coarser levels follow.
    pub fn make(
        &self,
        pass: &mut Pass<'_>,
        hierarchy: &DeviceHierarchy,
        ends: &[u32],
        reaching: &Reaching,
    ) -> Result<()> {
        self.records.keep(pass, &reaching.record)?;
        let bindings = [&self.built[0], &self.states[0], &self.places.bindings, &reaching.regions];
        pass.run(&self.reach[1], &bindings, bytemuck::bytes_of(&reaching.call), nodes(hierarchy))?;
        self.follow(pass, hierarchy, ends, false)
    }

    /// Records that what an edit has replaced is there again, or what it made in place of that.
    pub fn swap(&self, pass: &mut Pass<'_>, record: &Record) -> Result<()> {
        self.records.swap(pass, record)
    }

    /// What refining takes as the vertices that there were.
    pub fn before(&self) -> &Buffer<u32> {
        &self.before
    }

    /// Records that vertices follow where there are splits that were not there before, depth by depth.
    pub fn refine(&self, pass: &mut Pass<'_>, hierarchy: &DeviceHierarchy, ends: &[u32]) -> Result<()> {
        self.follow(pass, hierarchy, ends, true)
    }

    /// Records that finer levels follow, or coarser ones an edit, depth by depth.
    fn follow(&self, pass: &mut Pass<'_>, hierarchy: &DeviceHierarchy, ends: &[u32], is_finer: bool) -> Result<()> {
        let (kernel, state) = if is_finer { (&self.refine, &self.states[2]) } else { (&self.coarsen, &self.states[3]) };
        let bindings = [&self.built[1], state, &self.places.bindings, &self.stars];
        let depths = ends.windows(2).map(|ends| FollowCall {
            first: ends[0],
            count: ends[1] - ends[0],
            least: MIN_MOVE / hierarchy.scale,
            scale: hierarchy.scale,
        });
        let depths: Vec<_> = if is_finer { depths.collect() } else { depths.rev().collect() };
        for call in depths {
            let size = groups(call.count.div_ceil(GROUP));
            pass.run(kernel, &bindings, bytemuck::bytes_of(&call), size)?;
        }
        Ok(())
    }
}

fn reaches_nothing() -> Error {
    Error::invalid("no vertex is in a region of influence")
        .at("handles")
        .advise("move it to the surface, or make its radius larger")
}

/// Workgroups for all nodes.
fn nodes(hierarchy: &DeviceHierarchy) -> [u32; 3] {
    groups(2 * (hierarchy.vertices as u32).div_ceil(GROUP))
}

fn block(handle: &Handle) -> RegionBlock {
    let Handle { region, translation, axis, angle } = *handle;
    // An axis is of length 1 but for roundings; it may be none where nothing turns.
    let axis = glam::Vec3::from(axis).normalize_or_zero().to_array();
    RegionBlock {
        center: region.center,
        radius: region.radius,
        axis,
        angle,
        translation,
        falloff: region.falloff as u32,
    }
}
