//! The quads of agents of a few pixels.

use std::collections::HashMap;
use std::sync::Arc;

use glam::DVec3;
use relievo_core::{Context, Result};
use relievo_crowd::{Crowd, Impostor, Impostors, NONE, Texel};

use super::draws::flat;
use super::{RlvCrowd, fill};
use crate::border::array::{Output, Plain};
use crate::border::descriptor::read_descriptor;
use crate::border::registry::{self, try_read};

/// Texels along a side of a picture.
pub const RLV_CROWD_PICTURE_SIDE: usize = relievo_crowd::SIDE;

#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct RlvCrowdImpostor {
    pub agent: u32,
    pub picture: u32,
    pub transform: [f32; 12],
}

#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct RlvCrowdPicture {
    pub number: u64,
    pub model: u32,
    pub radius: f32,
    pub center: [f32; 3],
    pub axes: [f32; 9],
}

#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct RlvCrowdTexel {
    pub cluster: u32,
    pub material: u32,
    pub normal: [f32; 3],
}

descriptor! {
    pub struct RlvCrowdImpostors {
        struct_size: u32,
        reserved: u32,
        impostors: *mut RlvCrowdImpostor,
        impostor_capacity: usize,
        impostor_stride: usize,
        pictures: *mut RlvCrowdPicture,
        picture_capacity: usize,
        picture_stride: usize,
        texels: *mut RlvCrowdTexel,
        texel_capacity: usize,
    }
}

// SAFETY: integers and floats of four bytes without padding.
unsafe impl Plain for RlvCrowdImpostor {}
// SAFETY: an integer of eight bytes, then fourteen numbers of four, without padding.
unsafe impl Plain for RlvCrowdPicture {}
// SAFETY: integers and floats of four bytes without padding.
unsafe impl Plain for RlvCrowdTexel {}

impl Default for RlvCrowdImpostor {
    fn default() -> Self {
        Self { agent: 0, picture: 0, transform: [0.0; 12] }
    }
}

impl Default for RlvCrowdPicture {
    fn default() -> Self {
        Self { number: 0, model: 0, radius: 0.0, center: [0.0; 3], axes: [0.0; 9] }
    }
}

impl Default for RlvCrowdTexel {
    fn default() -> Self {
        Self { cluster: NONE, material: 0, normal: [0.0; 3] }
    }
}

/// The impostors of the last cut.
#[derive(Default)]
pub struct ShownImpostors {
    made: Impostors,
    pictures: Vec<Arc<Impostor>>,
    quads: Vec<RlvCrowdImpostor>,
}

impl ShownImpostors {
    /// Finds the pictures of agents at `time` seconds, seen from `eye`. Returns how many impostors and pictures there are.
    ///
    /// # Errors
    /// As [`Impostors::of_agents`].
    pub fn update(
        &mut self,
        context: &Context,
        (crowd, agents, time): (&Crowd, &[u32], f64),
        eye: DVec3,
    ) -> Result<[u32; 2]> {
        self.pictures.clear();
        self.quads.clear();
        let mut places: HashMap<u64, u32> = HashMap::new();
        for (agent, impostor) in self.made.of_agents(context, (crowd, agents, time), eye)? {
            let picture = *places.entry(impostor.number).or_insert_with(|| {
                self.pictures.push(impostor);
                self.pictures.len() as u32 - 1
            });
            let transform = flat(crowd.agents()[agent as usize].rows());
            self.quads.push(RlvCrowdImpostor { agent, picture, transform });
        }
        Ok([self.quads.len() as u32, self.pictures.len() as u32])
    }

    /// Writes the impostors to the arrays of C.
    ///
    /// # Errors
    /// There is too little room in an array; nothing is written then.
    ///
    /// # Safety
    /// There is room for the capacities in each array that is not NULL.
    pub unsafe fn write(&self, given: &RlvCrowdImpostors) -> Result<()> {
        let Self { pictures, quads, .. } = self;
        // SAFETY: the caller promises room for the capacities in each array that is not NULL.
        let (to_quads, to_pictures, to_texels) = unsafe {
            (
                Output::optional("impostors", given.impostors, given.impostor_capacity, given.impostor_stride)?,
                Output::optional("pictures", given.pictures, given.picture_capacity, given.picture_stride)?,
                Output::optional("texels", given.texels, given.texel_capacity, 0)?,
            )
        };
        let texels: Vec<RlvCrowdTexel> = match to_texels {
            Some(_) => pictures.iter().flat_map(|picture| picture.texels.iter().map(texel_of)).collect(),
            None => Vec::new(),
        };
        // Nothing is written unless there is room for all.
        to_quads.map(|out| out.holds("impostors", quads.len())).transpose()?;
        to_pictures.map(|out| out.holds("pictures", pictures.len())).transpose()?;
        to_texels.map(|out| out.holds("texels", texels.len())).transpose()?;
        fill(to_quads, "impostors", Some(quads.iter().copied()))?;
        fill(to_pictures, "pictures", Some(pictures.iter().map(picture_of)))?;
        fill(to_texels, "texels", Some(texels.iter().copied()))
    }
}

fn picture_of(picture: &Arc<Impostor>) -> RlvCrowdPicture {
    let Impostor { number, model, center, axes, radius, .. } = **picture;
    let axes = std::array::from_fn(|at| axes[at / 3][at % 3]);
    RlvCrowdPicture { number, model, radius, center: center.to_array(), axes }
}

fn texel_of(texel: &Texel) -> RlvCrowdTexel {
    let Texel { cluster, material, normal } = *texel;
    RlvCrowdTexel { cluster, material, normal }
}

entry! {
    fn rlv_crowd_get_impostors(crowd: RlvCrowd, impostors: *const RlvCrowdImpostors) {
        let object = registry::get(crowd)?;
        // SAFETY: a descriptor of nothing but numbers and NULL pointers.
        let default: RlvCrowdImpostors = unsafe { std::mem::zeroed() };
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        let given = unsafe { read_descriptor(impostors, default) }?;
        let state = try_read(&object.state, "crowd")?;
        // SAFETY: the caller promises room for the capacities in each array that is not NULL.
        unsafe { state.shown()?.write(&given) }
    }
}
