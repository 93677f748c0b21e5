//! Culling by occlusion on a device (Section 5.2, `shaders/crowd/crowd_occlusion.wgsl`): agents that others hide are not drawn.
//!
//! Agents in view that were seen in the last frame are posed and drawn as depths at the middles of pixels first. Of these a pyramid
//! is made, whose levels have the farthest of two by two depths below. An agent is hidden if a level on which its box has few places
//! is nearer than the front of its box at all of them. The box is a pixel wider on each side, and has to begin a share of
//! 1e-4 behind the depths, so that a picture with one sample in the middle of each pixel is the same as without culling. Clusters
//! that only one agent shows, as near ones do, are tested by the boxes of their groups. Then what is missing of all that is not
//! hidden is posed. Culling rests where it costs more than it saves, which is counted in
//! vertices, triangles and pixels, not in time.

use std::sync::Arc;

use relievo_core::{Context, Error, Result};
use relievo_gpu::wgsl::crowd_occlusion::{Call, Level};
use relievo_gpu::{Access, Bindings, Buffer, Device, Frame, GROUP, Kernel, KernelSpec, Readback, groups};
use relievo_render::Camera;
use relievo_render::virtual_vertex::DepthMap;

use super::pose::{DevicePosed, DevicePoser, larger};
use super::room::Ends;
use super::{DeviceCounted, DeviceCrowd, Part};
use crate::crowd::Crowd;
use crate::occlusion::{Culled, PixelView, Rest};
use crate::view::CrowdView;

/// What a device in software does for a posed vertex, a triangle of a picture, one of depths, and a pixel of depths and pyramid, in
/// 64ths of what it does for a vertex.
const VERTEX: u64 = 64;
const TRIANGLE: u64 = 128;
const DEPTHS: u64 = 112;
const PIXEL: u64 = 4;

/// Levels of a pyramid.
#[derive(Debug)]
struct Pyramid {
    size: [u32; 2],
    sizes: Vec<Level>,
    levels: Buffer<Level>,
    numbers: Buffer<f32>,
}

impl Pyramid {
    fn new(device: &Device, size: [u32; 2]) -> Result<Self> {
        let mut sizes = vec![Level { first: 0, width: size[0], height: size[1] }];
        let (mut next, mut total) = (size, 0);
        while next != [1, 1] {
            next = next.map(|side| side.div_ceil(2));
            sizes.push(Level { first: total, width: next[0], height: next[1] });
            total += next[0] * next[1];
        }
        Ok(Self {
            size,
            levels: Buffer::of(device, "occlusion levels", &sizes)?,
            numbers: Buffer::new(device, "occlusion pyramid", total as usize)?,
            sizes,
        })
    }
}

/// What is drawn of a view without the agents that others hide, posed on a device.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct DeviceUnhidden {
    /// What the lists on the device have: all agents in view, hidden ones too.
    pub listed: DeviceCounted,
    /// What is drawn. Its draws are those of the lists.
    pub drawn: DeviceCounted,
    /// What was posed, occluders included.
    pub posed: DevicePosed,
    /// What culling did.
    pub culled: Culled,
    /// Agents among the listed impostors that others hide, ascending.
    pub hidden_quads: Vec<u32>,
}

/// The state of culling between frames on a device.
#[derive(Debug)]
pub struct DeviceOcclusion {
    device: Device,
    depths: DepthMap,
    camera: Buffer<[f32; 4]>,
    pyramid: Option<Pyramid>,
    kernels: [Arc<Kernel>; 3],
    rest: Rest,
}

impl DeviceOcclusion {
    /// Compiles the kernels.
    ///
    /// # Errors
    /// The device fails.
    pub fn new(device: &Device) -> Result<Self> {
        use Access::{Read, Write};
        let kernel = |entry| {
            device.kernel(&KernelSpec {
                module: "crowd_occlusion",
                entry,
                groups: &[&[Read; 3], &[Read; 7], &[Write; 5]],
                immediates: size_of::<Call>() as u32,
                constants: &[],
            })
        };
        Ok(Self {
            depths: DepthMap::new(device)?,
            camera: Buffer::new(device, "occlusion camera", 4)?,
            pyramid: None,
            kernels: [kernel("reduce")?, kernel("test_agents")?, kernel("test_draws")?],
            rest: Rest::default(),
            device: device.clone(),
        })
    }

    /// Cuts a view at `time` seconds without the agents that others hide, and leaves the draws on the device. Makes room for more
    /// draws where there are more. In the first frame all agents in view count as seen in the frame before. What the poser had
    /// is lost.
    ///
    /// # Errors
    /// As [`DeviceCrowd::record`], or the view has no pixels or more than the device can draw.
    pub fn update(
        &mut self,
        context: &Context,
        (crowd, on, poser): (&Crowd, &mut DeviceCrowd, &mut DevicePoser),
        (view, time): (&CrowdView, f64),
        pixels: &PixelView,
    ) -> Result<(DeviceCounted, Culled)> {
        if self.rests(crowd, on, pixels)? {
            let counted = on.update(context, crowd, view, time)?;
            return Ok((counted, Culled { is_resting: true, ..Culled::default() }));
        }
        loop {
            on.send(context, crowd, (view, time))?;
            poser.fit(crowd, on.room())?;
            let mut frame = self.device.frame()?;
            let (all, first) = self.test(on, poser, pixels, &mut frame)?;
            on.record_part(Part::Visible, &mut frame)?;
            self.record_draws(on, 1, &mut frame)?;
            let visible = frame.read(on.counts(), 0..4)?;
            let hidden = self.read_hidden_draws(on, &mut frame)?;
            let _ = frame.submit()?;
            let hidden_clusters = self.hidden_draws(hidden)?;
            let [all, visible] = [all, visible].map(|counts| DeviceCounted::read(counts.get(&self.device)?));
            let (all, visible, first) = (all?, visible?, first.get(&self.device)?);
            let needed = DevicePosed { vertices: first.vertices, corners: first.corners };
            if make_room(on, poser, (all, needed))? {
                continue;
            }
            let culled = Culled {
                hidden: all.agents + all.impostors - visible.agents - visible.impostors,
                hidden_clusters,
                hidden_triangles: triangles(all) - triangles(visible),
                occluder_triangles: u64::from(first.corners / 3),
                is_resting: false,
            };
            // The host poses what is drawn, so occluders were posed for depths alone.
            let share = culled.hidden_triangles as f64 / triangles(all).max(1) as f64;
            let hidden_vertices = (share * f64::from(first.all_vertices)) as u64;
            self.rest.count(saved(&culled, hidden_vertices), spent(&culled, u64::from(first.vertices), pixels));
            return Ok((visible, culled));
        }
    }

    /// Cuts a view at `time` seconds and poses it without the agents that others hide: first what was seen in the last frame, then
    /// what is missing, so that no vertex is posed twice. The lists on the device are those of all agents in view. Makes room where
    /// there is too little.
    ///
    /// # Errors
    /// As [`Self::update`].
    pub fn pose(
        &mut self,
        context: &Context,
        (crowd, on, poser): (&Crowd, &mut DeviceCrowd, &mut DevicePoser),
        (view, time): (&CrowdView, f64),
        pixels: &PixelView,
    ) -> Result<DeviceUnhidden> {
        if self.rests(crowd, on, pixels)? {
            let (listed, posed) = poser.update(context, (crowd, on), (view, time))?;
            let culled = Culled { is_resting: true, ..Culled::default() };
            return Ok(DeviceUnhidden { listed, drawn: listed, posed, culled, hidden_quads: Vec::new() });
        }
        loop {
            on.send(context, crowd, (view, time))?;
            poser.fit(crowd, on.room())?;
            let mut frame = self.device.frame()?;
            let (all, first) = self.test(on, poser, pixels, &mut frame)?;
            self.record_draws(on, 0, &mut frame)?;
            poser.record(on, (Part::Visible, 1), &mut frame)?;
            let second = poser.read_ends(1, &mut frame)?;
            let hidden = self.read_hidden_draws(on, &mut frame)?;
            let _ = frame.submit()?;
            let hidden_clusters = self.hidden_draws(hidden)?;
            let listed = DeviceCounted::read(all.get(&self.device)?)?;
            let (first, second) = (first.get(&self.device)?, second.get(&self.device)?);
            let vertices = first.vertices.saturating_add(second.vertices);
            let needed = DevicePosed { vertices, corners: first.corners.max(second.corners) };
            if make_room(on, poser, (listed, needed))? {
                continue;
            }
            let hidden = if listed.impostors > 0 { on.hidden()? } else { Vec::new() };
            let mut hidden_quads = on.impostors(listed)?;
            hidden_quads.retain(|agent| hidden.binary_search(agent).is_ok());
            hidden_quads.sort_unstable();
            let drawn = DeviceCounted {
                agents: second.agents,
                triangles: second.corners / 3,
                impostors: listed.impostors - hidden_quads.len() as u32,
                ..listed
            };
            let culled = Culled {
                hidden: listed.agents + listed.impostors - drawn.agents - drawn.impostors,
                hidden_clusters,
                hidden_triangles: triangles(listed) - triangles(drawn),
                occluder_triangles: u64::from(first.corners / 3),
                is_resting: false,
            };
            let hidden_vertices = u64::from(first.all_vertices.saturating_sub(vertices));
            self.rest.count(saved(&culled, hidden_vertices), spent(&culled, 0, pixels));
            let posed = DevicePosed { vertices, corners: second.corners };
            return Ok(DeviceUnhidden { listed, drawn, posed, culled, hidden_quads });
        }
    }

    /// Returns whether culling rests in this frame. If not, makes room for the picture.
    fn rests(&mut self, crowd: &Crowd, on: &DeviceCrowd, pixels: &PixelView) -> Result<bool> {
        pixels.check()?;
        if crowd.agents().is_empty() || self.rest.is_resting() {
            on.forget_seen()?;
            return Ok(true);
        }
        self.depths.resize(pixels.size)?;
        if self.pyramid.as_ref().is_none_or(|pyramid| pyramid.size != pixels.size) {
            self.pyramid = Some(Pyramid::new(&self.device, pixels.size)?);
        }
        Ok(false)
    }

    /// Records the cut of all agents, the posing of occluders, which were seen in the last frame, and which agents they hide.
    /// Returns what will be counted.
    fn test(
        &self,
        on: &DeviceCrowd,
        poser: &DevicePoser,
        pixels: &PixelView,
        frame: &mut Frame,
    ) -> Result<(Readback<u32>, Ends)> {
        on.record_part(Part::All, frame)?;
        let all = frame.read(on.counts(), 0..4)?;
        poser.record(on, (Part::Occluders, 0), frame)?;
        let first = poser.read_ends(0, frame)?;
        self.record(on, poser, pixels, frame)?;
        Ok((all, first))
    }

    /// Records depths, the pyramid, and which agents are hidden.
    fn record(&self, on: &DeviceCrowd, poser: &DevicePoser, pixels: &PixelView, frame: &mut Frame) -> Result<()> {
        let camera = Camera { eye: pixels.eye, axes: pixels.axes, fov: pixels.fov };
        let factor = self.depths.record(frame, &poser.mesh(on), &camera)?;
        let Some(pyramid) = &self.pyramid else {
            return Err(Error::internal("culling has no room for depths"));
        };
        let [width, height] = pixels.size.map(|side| side as f32);
        let [right, up, back] = [pixels.axes.x_axis, pixels.axes.y_axis, pixels.axes.z_axis].map(|axis| axis.as_vec3());
        let eye = pixels.eye.as_vec3().extend(pixels.pixels() as f32);
        let rows = [eye, right.extend(width), up.extend(height), back.extend(factor)];
        self.camera.write(&self.device, 0, &rows.map(|row| row.to_array()))?;
        let bindings = self.bindings(on)?;
        let bound = bindings.each_ref();
        let [reduce, test_agents, _] = &self.kernels;
        let mut pass = frame.pass("crowd occlusion");
        for (level, Level { width, height, .. }) in (0..).zip(&pyramid.sizes).skip(1) {
            let count = (width * height).div_ceil(GROUP);
            pass.run(reduce, &bound, bytemuck::bytes_of(&self.call(on, level, 0)), groups(count))?;
        }
        let agents = on.work.states.len() as u32;
        pass.run(test_agents, &bound, bytemuck::bytes_of(&self.call(on, 0, 0)), groups(agents.div_ceil(GROUP)))
    }

    /// Records which draws of the lists show hidden clusters. `removes` is 1 to leave these without an instance.
    fn record_draws(&self, on: &DeviceCrowd, removes: u32, frame: &mut Frame) -> Result<()> {
        frame.clear(&on.work.draw_states);
        let [_, _, test_draws] = &self.kernels;
        let bindings = self.bindings(on)?;
        let mut pass = frame.pass("crowd occlusion of clusters");
        let count = on.room().div_ceil(GROUP);
        pass.run(test_draws, &bindings.each_ref(), bytemuck::bytes_of(&self.call(on, 0, removes)), groups(count))
    }

    fn call(&self, on: &DeviceCrowd, level: u32, removes: u32) -> Call {
        let (agents, [planes, options]) = (on.work.states.len() as u32, on.view);
        Call { agents, planes, options, stride: self.depths.stride(), level, draws: on.room(), removes }
    }

    fn bindings(&self, on: &DeviceCrowd) -> Result<[Bindings; 3]> {
        let (Some(depths), Some(pyramid)) = (self.depths.depths(), &self.pyramid) else {
            return Err(Error::internal("culling has no room for depths"));
        };
        let (work, shared) = (&on.work, &on.shared);
        let agents = [shared.models.wgpu(), work.agents.wgpu(), shared.view.wgpu()];
        let read = [
            self.camera.wgpu(),
            pyramid.levels.wgpu(),
            depths.wgpu(),
            shared.clusters.wgpu(),
            shared.groups.wgpu(),
            work.order().wgpu(),
            work.drawn.wgpu(),
        ];
        let written = [
            pyramid.numbers.wgpu(),
            work.states.wgpu(),
            work.draws.wgpu(),
            work.counts.wgpu(),
            work.draw_states.wgpu(),
        ];
        let bind = |group, buffers: &[_]| self.device.bind(&self.kernels[0], group, buffers);
        Ok([bind(0, &agents)?, bind(1, &read)?, bind(2, &written)?])
    }

    /// Records that the number of hidden clusters is read back.
    fn read_hidden_draws(&self, on: &DeviceCrowd, frame: &mut Frame) -> Result<Readback<u32>> {
        let at = on.room() as usize;
        frame.read(&on.work.draw_states, at..at + 1)
    }

    fn hidden_draws(&self, counted: Readback<u32>) -> Result<u64> {
        Ok(counted.get(&self.device)?.first().copied().unwrap_or_default().into())
    }
}

/// Makes room for draws, vertices and corners. Returns whether there was too little.
fn make_room(
    on: &mut DeviceCrowd,
    poser: &mut DevicePoser,
    (listed, needed): (DeviceCounted, DevicePosed),
) -> Result<bool> {
    if listed.draws > on.room() {
        on.make_room(larger(listed.draws))?;
        return Ok(true);
    }
    poser.grow(needed)
}

fn triangles(counted: DeviceCounted) -> u64 {
    u64::from(counted.triangles) + 2 * u64::from(counted.impostors)
}

/// Returns what hidden agents would have cost.
fn saved(culled: &Culled, vertices: u64) -> u64 {
    VERTEX * vertices + TRIANGLE * culled.hidden_triangles
}

/// Returns what culling cost: vertices that were posed for it alone, triangles of depths, and a pyramid.
fn spent(culled: &Culled, vertices: u64, pixels: &PixelView) -> u64 {
    let [width, height] = pixels.size.map(u64::from);
    VERTEX * vertices + DEPTHS * culled.occluder_triangles + PIXEL * width * height
}
