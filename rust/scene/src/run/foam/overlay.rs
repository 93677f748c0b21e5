//! Foam over a picture of a scene: the depths about it, its layers, and their composition.

use relievo_core::progress::Silent;
use relievo_core::{Context, Result};
use relievo_gpu::Device;
use relievo_render::foam::{Environment, Foam, FoamView, Lens, Scenery};
use relievo_render::{Frame, Image, ObjectId, View};

use super::run::FoamRun;
use crate::out::output::Folder;
use crate::state::world::World;

/// The foam of all fluids of a scene that have some.
#[derive(Debug, Default)]
pub(crate) struct Overlay {
    runs: Vec<(usize, FoamRun)>,
    /// What draws, in place of the processor.
    device: Option<Device>,
}

impl Overlay {
    /// Makes the foam of the objects of a world, before the first frame, with frames in the folder of the scene's cache, for a
    /// graphics device to draw, or the processor. Fails as [`FoamRun::new`] does.
    pub fn new(context: &Context, world: &World, device: Option<&Device>, cache: &Folder) -> Result<Self> {
        let mut runs = Vec::new();
        for object in 0..world.scene.objects.len() {
            if let Some(run) = FoamRun::new(context, world, object, cache)? {
                runs.push((object, run));
            }
        }
        Ok(Self { runs, device: device.cloned() })
    }

    /// Returns whether no fluid has foam.
    pub fn is_empty(&self) -> bool {
        self.runs.is_empty()
    }

    /// Returns what the user should know since the last call.
    pub fn take_notes(&mut self) -> Vec<String> {
        self.runs.iter_mut().flat_map(|(_, run)| run.take_notes()).collect()
    }

    /// Lays the foam at the end of a frame of the scene over its picture. `solids` holds the depths of the scene without
    /// fluids, and `ids` the objects of the picture by those of the scene.
    pub fn draw(
        &mut self,
        context: &Context,
        (view, number): (&View, usize),
        ids: &[Option<ObjectId>],
        solids: &Image,
        picture: &mut Frame,
    ) -> Result<()> {
        let (width, height) = (view.settings.width, view.settings.height);
        let from = FoamView { camera: view.camera, lens: Lens::Perspective, width, height };
        let environment = Environment::of_lights(&view.lights)?;
        for (object, run) in &mut self.runs {
            let mut stage = context.stats().begin("foam");
            run.go_to(context, number)?;
            let fluid = depths_of(picture, ids[*object])?;
            let scenery = Scenery { solids: Some(solids.clone()), fluid: Some(fluid) };
            let mut foam = Foam::on(context, self.device.as_ref(), *run.look(), from, &scenery)?;
            run.draw(context, &mut foam)?;
            stage.count("particles", foam.particles());
            let layers = foam.finish(context, &environment, &mut Silent)?;
            picture.color = layers.composite(context, &picture.color)?;
        }
        Ok(())
    }
}

/// Returns the depths of an object in a picture, infinite where another one is seen.
fn depths_of(picture: &Frame, object: Option<ObjectId>) -> Result<Image> {
    let (width, height) = (picture.depth.width(), picture.depth.height());
    let number = object.map(ObjectId::number);
    let depths = picture.depth.data().iter().zip(&picture.object);
    let depths = depths.map(|(depth, seen)| if Some(*seen) == number { *depth } else { f32::INFINITY });
    Image::from_data(width, height, 1, depths.collect())
}
