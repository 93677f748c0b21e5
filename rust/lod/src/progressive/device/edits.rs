//! Edits of a mesh on a device: handles at its vertices, and how finer and coarser levels follow, as `moves` and `coarser`
//! have them on the processor, depth by depth. Splits of one depth do not touch each other, so all of them are looked at at
//! the same time.

use std::sync::Arc;

use bytemuck::{Pod, Zeroable};
use relievo_core::{Error, Result};
use relievo_gpu::{Access, Bindings, Buffer, Frame, GROUP, Kernel, KernelSpec, Pass, groups};

use super::DeviceHierarchy;
use super::around::DeviceAround;
use crate::progressive::handle::{Edit, Handle, Region};
use crate::progressive::moves::LEAST_MOVE;

/// As in `progressive.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct Place {
    point: [f32; 3],
    edited: u32,
    normal: [f32; 3],
    moved: u32,
}

/// As in `progressive_edit.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
struct RegionBlock {
    center: [f32; 3],
    radius: f32,
    axis: [f32; 3],
    angle: f32,
    translation: [f32; 3],
    falloff: u32,
}

/// As in `progressive_edit.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
struct EditCall {
    vertices: u32,
    handles: u32,
    anchors: u32,
    edit: u32,
}

/// As in `progressive_follow.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
struct FollowCall {
    first: u32,
    count: u32,
    edit: u32,
    least: f32,
    scale: f32,
}

/// What was edited.
#[derive(Debug)]
pub struct Edits {
    /// Of nodes.
    pub places: Buffer<Place>,
    before: Buffer<u32>,
    reached: Buffer<u32>,
    _notes: Buffer<Place>,
    /// Counts edits.
    edits: u32,
    reach: [Arc<Kernel>; 2],
    refine: Arc<Kernel>,
    coarsen: Arc<Kernel>,
    /// Of edits, of refining and of coarsening.
    bindings: [[Bindings; 2]; 3],
}

impl Edits {
    /// Nothing is edited yet. `there` says which vertices there are.
    pub fn new(hierarchy: &DeviceHierarchy, around: &DeviceAround, there: &Buffer<u32>) -> Result<Self> {
        let device = &hierarchy.device;
        let places = Buffer::new(device, "places", 2 * hierarchy.vertices)?;
        let notes = Buffer::new(device, "notes of splits", 2 * hierarchy.vertices)?;
        let before = Buffer::new(device, "vertices before", there.len())?;
        let reached = Buffer::new(device, "reached", 2)?;
        let kernel = |module, entry, groups: &[&[Access]], immediates: usize| {
            device.kernel(&KernelSpec { module, entry, groups, immediates: immediates as u32, constants: &[] })
        };
        let (read, write) = (Access::Read, Access::Write);
        let edited: &[&[Access]] = &[&[read; 3], &[write; 2], &[write, read]];
        let edit = |entry| kernel("progressive_edit", entry, edited, size_of::<EditCall>());
        let reach = [edit("reach")?, edit("move_reached")?];
        let follow = size_of::<FollowCall>();
        let refine = kernel("progressive_refine", "refine", &[&[read; 6], &[write; 4]], follow)?;
        let coarsen = kernel("progressive_coarsen", "coarsen", &[&[read; 6], &[write; 3]], follow)?;
        let built = [hierarchy.splits.wgpu(), hierarchy.inner.wgpu(), hierarchy.leaves.wgpu()];
        let [splits, inner, leaves] = built;
        let all = [splits, inner, leaves, around.order.wgpu(), around.starts.wgpu(), around.stars.wgpu()];
        let state = [there.wgpu(), places.wgpu(), notes.wgpu(), before.wgpu()];
        let bindings = [
            [device.bind(&reach[0], 0, &built)?, device.bind(&reach[0], 1, &state[..2])?],
            [device.bind(&refine, 0, &all)?, device.bind(&refine, 1, &state)?],
            [device.bind(&coarsen, 0, &all)?, device.bind(&coarsen, 1, &state[..3])?],
        ];
        Ok(Self { places, before, reached, _notes: notes, edits: 0, reach, refine, coarsen, bindings })
    }

    /// Moves and turns regions of the vertices that there are, has coarser levels follow, and waits for it. Returns how many
    /// were reached. Fails if none is, or one would go where there is no number; nothing has changed then.
    pub fn edit(&mut self, hierarchy: &DeviceHierarchy, ends: &[u32], edit: &Edit) -> Result<usize> {
        let device = &hierarchy.device;
        let handles = edit.handles.iter().map(block);
        let held =
            |anchor: &Region| block(&Handle { region: *anchor, translation: [0.0; 3], axis: [0.0; 3], angle: 0.0 });
        let blocks: Vec<RegionBlock> = handles.chain(edit.anchors.iter().map(held)).collect();
        let regions = Buffer::of(device, "regions", &blocks)?;
        let bindings = device.bind(&self.reach[0], 2, &[self.reached.wgpu(), regions.wgpu()])?;
        let call = EditCall {
            vertices: hierarchy.vertices as u32,
            handles: edit.handles.len() as u32,
            anchors: edit.anchors.len() as u32,
            edit: self.edits + 1,
        };
        let mut frame = device.frame()?;
        frame.clear(&self.reached);
        let mut pass = frame.pass("edit");
        let [built, state] = &self.bindings[0];
        let size = groups(2 * call.vertices.div_ceil(GROUP));
        for kernel in &self.reach {
            pass.run(kernel, &[built, state, &bindings], bytemuck::bytes_of(&call), size)?;
        }
        self.follow(&mut pass, hierarchy, (ends, call.edit), false)?;
        drop(pass);
        let reached = frame.read(&self.reached, 0..2)?;
        let _ = frame.submit()?;
        match reached.get(device)?[..] {
            [0, _] => Err(Error::invalid("no vertex is in a region of influence")
                .at("handles")
                .advise("move it to the surface, or make its radius larger")),
            [reached, 0] => {
                self.edits += 1;
                Ok(reached as usize)
            }
            _ => Err(Error::invalid("vertices would go where there is no number").advise("use smaller translations")),
        }
    }

    /// Records that the vertices that there are will be known as those before.
    pub fn keep(&self, frame: &mut Frame, there: &Buffer<u32>) -> Result<()> {
        frame.copy(there, 0..there.len(), &self.before, 0)
    }

    /// Records that vertices follow where splits were made since they were kept.
    pub fn refine(&self, pass: &mut Pass<'_>, hierarchy: &DeviceHierarchy, ends: &[u32]) -> Result<()> {
        self.follow(pass, hierarchy, (ends, self.edits), true)
    }

    /// Records that finer levels follow, or coarser ones an edit, depth by depth.
    fn follow(
        &self,
        pass: &mut Pass<'_>,
        hierarchy: &DeviceHierarchy,
        (ends, edit): (&[u32], u32),
        is_finer: bool,
    ) -> Result<()> {
        let (kernel, [built, state]) =
            if is_finer { (&self.refine, &self.bindings[1]) } else { (&self.coarsen, &self.bindings[2]) };
        let depths = ends.windows(2).map(|ends| FollowCall {
            first: ends[0],
            count: ends[1] - ends[0],
            edit,
            least: LEAST_MOVE / hierarchy.scale,
            scale: hierarchy.scale,
        });
        let depths: Vec<_> = if is_finer { depths.collect() } else { depths.rev().collect() };
        for call in depths {
            let size = groups(call.count.div_ceil(GROUP));
            pass.run(kernel, &[built, state], bytemuck::bytes_of(&call), size)?;
        }
        Ok(())
    }
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

#[cfg(test)]
mod tests {
    use super::*;
    use relievo_testing::wgsl::assert_layout;
    use std::mem::offset_of;

    #[test]
    fn layouts_are_those_of_the_shaders() {
        let place = [
            ("point", offset_of!(Place, point)),
            ("edited", offset_of!(Place, edited)),
            ("normal", offset_of!(Place, normal)),
            ("moved", offset_of!(Place, moved)),
        ];
        assert_layout("progressive", "Place", size_of::<Place>(), &place);
        let region = [
            ("center", offset_of!(RegionBlock, center)),
            ("radius", offset_of!(RegionBlock, radius)),
            ("axis", offset_of!(RegionBlock, axis)),
            ("angle", offset_of!(RegionBlock, angle)),
            ("translation", offset_of!(RegionBlock, translation)),
            ("falloff", offset_of!(RegionBlock, falloff)),
        ];
        assert_layout("progressive_edit", "Region", size_of::<RegionBlock>(), &region);
        let call = [
            ("vertices", offset_of!(EditCall, vertices)),
            ("handles", offset_of!(EditCall, handles)),
            ("anchors", offset_of!(EditCall, anchors)),
            ("edit", offset_of!(EditCall, edit)),
        ];
        assert_layout("progressive_edit", "Call", size_of::<EditCall>(), &call);
        let call = [
            ("first", offset_of!(FollowCall, first)),
            ("count", offset_of!(FollowCall, count)),
            ("edit", offset_of!(FollowCall, edit)),
            ("least", offset_of!(FollowCall, least)),
            ("scale", offset_of!(FollowCall, scale)),
        ];
        assert_layout("progressive_follow", "Call", size_of::<FollowCall>(), &call);
    }
}
