//! Crowds that a graphics device cuts, poses and draws (Section 5.2): clusters, and quads for agents of a few pixels.

use glam::Vec3;
use relievo_core::{Context, Result};
use relievo_crowd::{
    Crowd, CrowdView, Culled, DeviceCrowd, DeviceOcclusion, DevicePoser, DeviceQuads, DeviceUnhidden, Look, PixelView,
};
use relievo_gpu::Device;
use relievo_render::Material;
use relievo_render::virtual_vertex::{Placed, Shape};

/// Draws that there is room for at first.
const ROOM: u32 = 1 << 8;

/// What a device drew up for a view.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct DeviceCounts {
    /// Agents in view that are drawn by clusters.
    pub agents: u32,
    /// Clusters in view, each once for all agents that show it by one draw.
    pub draws: u32,
    /// Vertices that were posed, occluders included.
    pub posed: u32,
    /// Triangles of all agents, two for each impostor.
    pub triangles: u32,
    /// Agents that are drawn as impostors.
    pub impostors: u32,
    /// What culling by occlusion did, where it was asked for.
    pub culled: Option<Culled>,
}

/// The triangles of a crowd on a device.
#[derive(Debug)]
pub struct DeviceStandIns {
    device: Device,
    crowd: DeviceCrowd,
    poser: DevicePoser,
    quads: DeviceQuads,
    occlusion: Option<DeviceOcclusion>,
}

impl DeviceStandIns {
    /// Sends the models of a crowd to a device.
    ///
    /// # Errors
    /// The device has no memory, or the models are too large for 32 bits.
    pub fn new(device: &Device, crowd: &Crowd, look: Look<'_>) -> Result<Self> {
        Ok(Self {
            crowd: DeviceCrowd::new(device, crowd, ROOM)?,
            poser: DevicePoser::new(device, crowd, look)?,
            quads: DeviceQuads::new(device, crowd, look)?,
            occlusion: None,
            device: device.clone(),
        })
    }

    /// Cuts and poses the crowd for a view at `time` seconds, without the agents that others hide in a picture with these pixels
    /// if there are some. Hidden agents throw shadows too: give no pixels for a picture with shadows. Makes room where there is too
    /// little.
    ///
    /// # Errors
    /// As [`DeviceCrowd::record`] and [`DeviceOcclusion::update`].
    pub fn update(
        &mut self,
        context: &Context,
        crowd: &Crowd,
        (view, time): (&CrowdView, f64),
        pixels: Option<&PixelView>,
    ) -> Result<DeviceCounts> {
        let found = match pixels {
            None => {
                let (listed, posed) = self.poser.update(context, (crowd, &mut self.crowd), (view, time))?;
                DeviceUnhidden { listed, drawn: listed, posed, ..DeviceUnhidden::default() }
            }
            Some(pixels) => {
                let occlusion = match &mut self.occlusion {
                    Some(occlusion) => occlusion,
                    empty => empty.insert(DeviceOcclusion::new(&self.device)?),
                };
                let on = (crowd, &mut self.crowd, &mut self.poser);
                occlusion.pose(context, on, (view, time), pixels)?
            }
        };
        let eye = Vec3::from(view.eye).as_dvec3();
        self.quads.update(context, (crowd, &self.crowd, found.listed), (eye, time), &found.hidden_quads)?;
        Ok(DeviceCounts {
            agents: found.drawn.agents,
            draws: found.drawn.draws,
            posed: found.posed.vertices,
            triangles: found.posed.corners / 3 + 2 * found.drawn.impostors,
            impostors: found.drawn.impostors,
            culled: pixels.map(|_| found.culled),
        })
    }

    /// Returns what is drawn, made of `material`: clusters, then impostors.
    pub fn placed(&self, material: Material) -> [Placed<'_>; 2] {
        [Shape::Posed(self.poser.mesh(&self.crowd)), Shape::Quads(self.quads.mesh(&self.crowd))]
            .map(|shape| Placed::new(shape, material))
    }
}
