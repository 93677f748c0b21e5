//! Meshes of all frames of a run as one stage in USD, with frames as time codes.
//!
//! Touched tiles are divided more finely, so that the triangles of a surface change from frame to frame. On a stage they
//! are the same in all frames, as fine as any frame needs: then points have velocities, and others can follow them. So
//! frames are only noted while a run goes, and opened again from the cache when it is done.

use std::collections::BTreeMap;
use std::path::PathBuf;

use glam::DAffine3;
use relievo_core::{Context, Result};
use relievo_meshio::{Instance, StageOptions, StageWriter};
use relievo_tiles::triangle::FaceRates;

use crate::format::description::Scene;
use crate::format::placement::Up;
use crate::out::export::shown;
use crate::out::output::Folder;
use crate::out::tessellation::Rates;
use crate::state::world::{Item, World};

/// The format of meshes that holds all frames of a run.
pub const STAGE: &str = "usda";

/// How finely a surface is divided.
#[derive(Clone, Debug)]
pub enum Division {
    /// By tile.
    Tiles(Rates),
    /// By face of a triangle mesh.
    Faces(Vec<FaceRates>),
}

/// The frames that go to a stage, and how finely the surfaces of all of them are divided.
#[derive(Debug, Default)]
pub struct Stages {
    frames: Vec<u32>,
    /// By the index of the object.
    divisions: BTreeMap<usize, Division>,
}

impl Stages {
    /// Notes that the world is in a frame that goes to a stage, if the scene asks for one.
    ///
    /// # Errors
    /// Fails with `Invalid` only if the displacement of an object is that of another surface, which the object refuses
    /// when it is set.
    pub fn note(&mut self, world: &World, frame: u32) -> Result<()> {
        let scene = &world.scene;
        if !scene.output.mesh_formats.contains(&STAGE) {
            return Ok(());
        }
        self.frames.push(frame);
        for (index, item) in world.items().iter().enumerate().filter(|(index, _)| scene.objects[*index].visible) {
            let division = match item {
                Item::Mesh(_) => continue,
                Item::Surface(surface) => {
                    let coat = world.coat(index);
                    let (coarse, most) = (scene.output.rate, scene.output.mesh_rate);
                    Division::Tiles(Rates::new(&surface.displaced()?, coat.as_ref(), coarse, most))
                }
                Item::Triangles(item) => {
                    let faces = 0..item.object.surface().topology().face_count() as u32;
                    Division::Faces(faces.map(|face| item.object.rates(face)).collect())
                }
            };
            match (self.divisions.get_mut(&index), division) {
                (Some(Division::Tiles(known)), Division::Tiles(rates)) => known.refine(&rates),
                (Some(Division::Faces(known)), Division::Faces(rates)) => {
                    known.iter_mut().zip(rates).for_each(|(known, rates)| *known = known.with(rates));
                }
                (_, division) => drop(self.divisions.insert(index, division)),
            }
        }
        Ok(())
    }

    /// The frames, in order.
    pub fn frames(&self) -> &[u32] {
        &self.frames
    }

    /// How finely an object is divided.
    pub fn division(&self, object: usize) -> Option<&Division> {
        self.divisions.get(&object)
    }

    /// Adds the meshes of a frame, which the world is in.
    ///
    /// # Errors
    /// Fails with `Memory` if all frames together need more than the limit of `writer` or a mesh would have 2³² corners
    /// or points, and with `Invalid` if `frame` does not follow the frame before, no object is visible, or a mesh does
    /// not pass [`Mesh::check`](relievo_core::Mesh::check).
    pub fn add(&self, context: &Context, world: &World, frame: u32, writer: &mut StageWriter) -> Result<()> {
        let _stage = context.stats().begin("export.meshes");
        let turn = axes(world.scene.up).0;
        let list = shown(context, world, Some(self))?;
        let placed = list.iter().map(|(name, materials, mesh, transform)| {
            let transform = turn * *transform;
            Instance { name, mesh, transform, materials }
        });
        writer.frame(f64::from(frame), &placed.collect::<Vec<_>>())
    }

    /// Writes the stage. Returns the file.
    ///
    /// # Errors
    /// Fails with `Invalid` if no frame was added or the library for USD refuses the stage, and with `NotFound` or `Io`
    /// if the file cannot be written.
    pub fn finish(&self, writer: StageWriter, folder: &Folder) -> Result<PathBuf> {
        let range = match self.frames[..] {
            [first, .., last] => format!("{first:06}-{last:06}"),
            [frame] => format!("{frame:06}"),
            [] => String::new(),
        };
        let path = folder.file(&format!("mesh-{range}.{STAGE}"));
        writer.finish(&path).map(|()| path)
    }
}

/// What lengths, axes and times are on stages of a scene.
pub fn options(scene: &Scene) -> StageOptions {
    StageOptions { meters_per_unit: scene.metres, z_up: axes(scene.up).1, time_codes_per_second: scene.fps }
}

/// The turn that brings a scene to an axis that USD knows, and whether it then is z that points up: x cannot.
pub fn axes(up: Up) -> (DAffine3, bool) {
    match up {
        Up::X => (DAffine3::from_mat3(up.from_y_up().transpose()), false),
        Up::Y => (DAffine3::IDENTITY, false),
        Up::Z => (DAffine3::IDENTITY, true),
    }
}
