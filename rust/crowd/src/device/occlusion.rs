//! Culling by occlusion on a device (Section 5.2, `shaders/crowd/crowd_occlusion.wgsl`): agents that others hide are not drawn.
//!
//! Agents that were seen in the last frame are cut, posed and drawn as depths at the middles of pixels first. Of these a pyramid is
//! made, whose levels have the farthest of two by two depths below. An agent is hidden if a level on which its box has few
//! places is nearer than the front of its box at all of them. The box is a pixel wider on each side, and has to begin a share of
//! 1e-4 behind the depths, so that a picture with one sample in the middle of each pixel is the same as without culling. It
//! rests where occluders have more triangles than they hide, as the processor's [`Occlusion`](crate::Occlusion).

use std::sync::Arc;

use bytemuck::{Pod, Zeroable};
use relievo_core::{Context, Error, Result};
use relievo_gpu::{Access, Buffer, Device, Frame, GROUP, Kernel, KernelSpec, groups};
use relievo_render::Camera;
use relievo_render::virtual_vertex::DepthMap;

use super::pose::DevicePoser;
use super::{DeviceCounted, DeviceCrowd, Part};
use crate::crowd::Crowd;
use crate::occlusion::{Culled, PixelView, Rest};
use crate::view::CrowdView;

/// As in the kernels.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
struct Call {
    agents: u32,
    planes: u32,
    options: u32,
    stride: u32,
    level: u32,
}

/// Levels of a pyramid: where each begins, its width and its height.
#[derive(Debug)]
struct Pyramid {
    size: [u32; 2],
    sizes: Vec<[u32; 3]>,
    levels: Buffer<[u32; 3]>,
    numbers: Buffer<f32>,
}

impl Pyramid {
    fn new(device: &Device, size: [u32; 2]) -> Result<Self> {
        let mut sizes = vec![[0, size[0], size[1]]];
        let (mut next, mut total) = (size, 0);
        while next != [1, 1] {
            next = next.map(|side| side.div_ceil(2));
            sizes.push([total, next[0], next[1]]);
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

/// The state of culling between frames on a device.
#[derive(Debug)]
pub struct DeviceOcclusion {
    device: Device,
    depths: DepthMap,
    camera: Buffer<[f32; 4]>,
    pyramid: Option<Pyramid>,
    kernels: [Arc<Kernel>; 2],
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
                groups: &[&[Read; 3], &[Read; 3], &[Write; 2]],
                immediates: size_of::<Call>() as u32,
                constants: &[],
            })
        };
        Ok(Self {
            depths: DepthMap::new(device)?,
            camera: Buffer::new(device, "occlusion camera", 4)?,
            pyramid: None,
            kernels: [kernel("reduce")?, kernel("test_agents")?],
            rest: Rest::default(),
            device: device.clone(),
        })
    }

    /// Cuts a view at `time` seconds without the agents that others hide, and leaves the draws on the device. Makes room for more
    /// draws where there are more. In the first frame all agents in view count as seen in the frame before.
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
        pixels.check()?;
        if crowd.agents().is_empty() || self.rest.is_resting() {
            on.forget_seen()?;
            let counted = on.update(context, crowd, view, time)?;
            return Ok((counted, Culled { is_resting: true, ..Culled::default() }));
        }
        self.depths.resize(pixels.size)?;
        if self.pyramid.as_ref().is_none_or(|pyramid| pyramid.size != pixels.size) {
            self.pyramid = Some(Pyramid::new(&self.device, pixels.size)?);
        }
        loop {
            on.send(context, crowd, (view, time))?;
            poser.fit(crowd, on.room())?;
            let mut frame = self.device.frame()?;
            on.record_part(Part::Occluders, &mut frame)?;
            let occluders = frame.read(on.counts(), 0..4)?;
            poser.record(on, &mut frame)?;
            let ends = poser.read_ends(&mut frame)?;
            self.record(on, poser, pixels, &mut frame)?;
            on.record_part(Part::Hidden, &mut frame)?;
            let hidden = frame.read(on.counts(), 0..4)?;
            on.record_part(Part::Visible, &mut frame)?;
            let visible = frame.read(on.counts(), 0..4)?;
            let _ = frame.submit()?;
            let [occluders, hidden, visible] =
                [occluders, hidden, visible].map(|counts| DeviceCounted::read(counts.get(&self.device)?));
            let (occluders, hidden, visible) = (occluders?, hidden?, visible?);
            let draws = occluders.draws.max(visible.draws);
            if draws > on.room() {
                on.make_room(draws)?;
                continue;
            }
            // Occluders that were left out hide nothing: the frame is right, and may have more than it needs.
            if poser.grow(ends.get(&self.device)?)? {
                continue;
            }
            let triangles = |counted: DeviceCounted| u64::from(counted.triangles) + 2 * u64::from(counted.impostors);
            let culled = Culled {
                hidden: hidden.agents + hidden.impostors,
                hidden_triangles: triangles(hidden),
                occluder_triangles: triangles(occluders),
                is_resting: false,
            };
            self.rest.count(&culled);
            return Ok((visible, culled));
        }
    }

    /// Records depths, the pyramid, and which agents are hidden.
    fn record(&self, on: &DeviceCrowd, poser: &DevicePoser, pixels: &PixelView, frame: &mut Frame) -> Result<()> {
        let camera = Camera { eye: pixels.eye, axes: pixels.axes, fov: pixels.fov };
        let factor = self.depths.record(frame, &poser.mesh(on), &camera)?;
        let (Some(depths), Some(pyramid)) = (self.depths.depths(), &self.pyramid) else {
            return Err(Error::internal("culling has no room for depths"));
        };
        let [width, height] = pixels.size.map(|side| side as f32);
        let [right, up, back] = [pixels.axes.x_axis, pixels.axes.y_axis, pixels.axes.z_axis].map(|axis| axis.as_vec3());
        let eye = pixels.eye.as_vec3().extend(pixels.pixels() as f32);
        let rows = [eye, right.extend(width), up.extend(height), back.extend(factor)];
        self.camera.write(&self.device, 0, &rows.map(|row| row.to_array()))?;
        let (agents, [planes, options]) = (on.work.states.len() as u32, on.view);
        let [reduce, test_agents] = &self.kernels;
        let read = [self.camera.wgpu(), pyramid.levels.wgpu(), depths.wgpu()];
        let read = self.device.bind(reduce, 1, &read)?;
        let written = self.device.bind(reduce, 2, &[pyramid.numbers.wgpu(), on.work.states.wgpu()])?;
        let bound = [&on.work.bindings[0], &read, &written];
        let call = |level: u32| Call { agents, planes, options, stride: self.depths.stride(), level };
        let mut pass = frame.pass("crowd occlusion");
        for (level, [_, width, height]) in (0..).zip(&pyramid.sizes).skip(1) {
            let count = (width * height).div_ceil(GROUP);
            pass.run(reduce, &bound, bytemuck::bytes_of(&call(level)), groups(count))?;
        }
        pass.run(test_agents, &bound, bytemuck::bytes_of(&call(0)), groups(agents.div_ceil(GROUP)))
    }
}
