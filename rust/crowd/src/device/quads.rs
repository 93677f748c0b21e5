//! Impostors on a device: quads with the pictures that [`Impostors`] makes, each sent once (`shaders/draw/quad_draw.wgsl`).

use std::collections::HashMap;
use std::sync::Arc;

use glam::{DVec3, Vec3};
use relievo_core::{Context, Result};
use relievo_gpu::{Buffer, Device};
use relievo_render::virtual_vertex::{INSTANCE_TAG, PicturedQuads, QuadPicture};

use super::{DeviceCounted, DeviceCrowd, Look};
use crate::crowd::Crowd;
use crate::hierarchy::{CrowdModel, NONE};
use crate::impostor::{Impostor, Impostors, SIDE, Texel};

/// Pictures that there is room for at first.
const ROOM: usize = 16;

/// The quads of a view, with their pictures.
#[derive(Debug)]
pub struct DeviceQuads {
    device: Device,
    impostors: Impostors,
    /// For each model the false colours of its clusters, for all of its materials each.
    tags: Vec<Vec<u32>>,
    /// Where the pictures are that were sent, by their numbers.
    places: HashMap<u64, u32>,
    pictures: Buffer<QuadPicture>,
    texels: Buffer<[f32; 4]>,
    quads: Buffer<[u32; 2]>,
    count: u32,
    bounds: [[f32; 3]; 2],
}

impl DeviceQuads {
    /// Makes room for a few pictures of the models of a crowd.
    ///
    /// # Errors
    /// The device has no memory.
    pub fn new(device: &Device, crowd: &Crowd, look: Look<'_>) -> Result<Self> {
        let tags = crowd.models().iter().map(|model| {
            let materials = materials(model);
            let of = |cluster: u32| (0..materials).map(move |material| (cluster, material));
            let tag = |(cluster, material)| look.tag.map_or(INSTANCE_TAG, |tag| tag(model, cluster, material));
            (0..model.clusters.len() as u32).flat_map(of).map(tag).collect()
        });
        Ok(Self {
            impostors: Impostors::default(),
            tags: tags.collect(),
            places: HashMap::new(),
            pictures: Buffer::new(device, "impostor pictures", ROOM)?,
            texels: Buffer::new(device, "impostor texels", ROOM * SIDE * SIDE)?,
            quads: Buffer::new(device, "impostors", 1)?,
            count: 0,
            bounds: [[0.0; 3]; 2],
            device: device.clone(),
        })
    }

    /// Finds the quads of the last cut at `time` seconds, seen from `eye`, without those of some agents, which ascend, and sends
    /// pictures that were not sent yet.
    ///
    /// # Errors
    /// The device has no memory or is lost, or as [`Impostors::of_agents`].
    pub fn update(
        &mut self,
        context: &Context,
        (crowd, on, counted): (&Crowd, &DeviceCrowd, DeviceCounted),
        (eye, time): (DVec3, f64),
        hidden: &[u32],
    ) -> Result<()> {
        let listed = on.impostors(counted)?.into_iter().zip(counted.agents..);
        let (agents, places): (Vec<u32>, Vec<u32>) =
            listed.filter(|(agent, _)| hidden.binary_search(agent).is_err()).unzip();
        let found = self.impostors.of_agents(context, (crowd, &agents, time), eye)?;
        let is_new = |impostor: &Impostor, places: &HashMap<u64, u32>| !places.contains_key(&impostor.number);
        let mut new: Vec<&Arc<Impostor>> = found.iter().map(|it| &it.1).filter(|it| is_new(it, &self.places)).collect();
        new.sort_unstable_by_key(|impostor| impostor.number);
        new.dedup_by_key(|impostor| impostor.number);
        if self.places.len() + new.len() > self.pictures.len() {
            // Pictures of frames before go, and those of this one are sent again.
            self.places.clear();
            new = found.iter().map(|it| &it.1).collect();
            new.sort_unstable_by_key(|impostor| impostor.number);
            new.dedup_by_key(|impostor| impostor.number);
            let room = (2 * new.len()).next_power_of_two().max(self.pictures.len());
            if room > self.pictures.len() {
                self.pictures = Buffer::new(&self.device, "impostor pictures", room)?;
                self.texels = Buffer::new(&self.device, "impostor texels", room * SIDE * SIDE)?;
            }
        }
        for impostor in new {
            self.send(crowd, impostor)?;
        }
        let quads: Vec<[u32; 2]> =
            found.iter().zip(places).map(|((_, impostor), at)| [self.places[&impostor.number], at]).collect();
        if quads.len() > self.quads.len() {
            self.quads = Buffer::new(&self.device, "impostors", quads.len().next_power_of_two())?;
        }
        self.quads.write(&self.device, 0, &quads)?;
        self.count = quads.len() as u32;
        self.bounds = bounds(crowd, &agents);
        Ok(())
    }

    /// Sends a picture.
    fn send(&mut self, crowd: &Crowd, impostor: &Impostor) -> Result<()> {
        let place = self.places.len();
        let [right, up, _] = impostor.axes.map(|axis| axis.to_array());
        let picture = QuadPicture {
            center: impostor.center.to_array(),
            radius: impostor.radius,
            right,
            up,
            ..QuadPicture::default()
        };
        let materials = materials(&crowd.models()[impostor.model as usize]);
        let tags = &self.tags[impostor.model as usize];
        let texel = |texel: &Texel| match texel.cluster {
            NONE => [0.0; 4],
            cluster => {
                let tag = tags[(cluster * materials + texel.material) as usize];
                Vec3::from(texel.normal).extend(f32::from_bits(tag)).to_array()
            }
        };
        let texels: Vec<[f32; 4]> = impostor.texels.iter().map(texel).collect();
        self.pictures.write(&self.device, place, &[picture])?;
        self.texels.write(&self.device, place * SIDE * SIDE, &texels)?;
        self.places.insert(impostor.number, place as u32);
        Ok(())
    }

    /// Returns what is drawn of a crowd whose quads were found last.
    pub fn mesh<'a>(&'a self, on: &'a DeviceCrowd) -> PicturedQuads<'a> {
        PicturedQuads {
            quads: &self.quads,
            count: self.count,
            instances: on.instances().wgpu(),
            pictures: &self.pictures,
            texels: &self.texels,
            side: SIDE as u32,
            bounds: self.bounds,
        }
    }
}

/// Returns how many materials the triangles of a model may have.
fn materials(model: &CrowdModel) -> u32 {
    model.character.materials.iter().max().map_or(1, |largest| largest + 1)
}

/// Returns a box around the squares of some agents in the world.
fn bounds(crowd: &Crowd, agents: &[u32]) -> [[f32; 3]; 2] {
    let (mut low, mut high) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
    for agent in agents {
        let reach = &crowd.reaches().0[*agent as usize];
        // The corner of a square that is in the sphere of the box.
        let far = Vec3::splat(std::f32::consts::SQRT_2 * reach.radius);
        (low, high) = (low.min(reach.center - far), high.max(reach.center + far));
    }
    if agents.is_empty() { [[0.0; 3]; 2] } else { [low.to_array(), high.to_array()] }
}
