//! Decals that documents keep in layers of their own: how these are opened to be changed.

use std::path::{Path, PathBuf};

use glam::{DAffine3, Vec4};
use relievo_core::{Context, Error, Mesh, Result};
use relievo_decal::{Ground, Printable, Recipe, recipes};
use relievo_detail::{AnyObject, DisplacedObject, History, LayeredObject, with_object};
use relievo_document::{Document, Kind};
use relievo_surface::{Surface, SurfaceOptions};
use relievo_tiles::{ChannelOptions, Displacement, Paint, Rgba8};

use crate::args::limits::{Isolation, Limits};
use crate::doc::triangles;

/// Bytes of edits that are kept in memory.
const MEMORY: u64 = 64 << 20;

/// A document, and the layer of a decal of it.
#[derive(clap::Args)]
pub struct Arguments {
    /// The mesh that the decal was applied to: OBJ, PLY, GLB, glTF, USD, STL or OFF.
    file: PathBuf,
    /// The document that `relievo decal apply` wrote, which is changed: an edit of its journal, that can be undone.
    pub document: PathBuf,
    /// The layer of the decal.
    #[arg(long, value_name = "NAME", default_value = "decal")]
    layer: String,
    /// Print JSON for programs.
    #[arg(long)]
    pub json: bool,
    #[command(flatten)]
    isolation: Isolation,
    #[command(flatten)]
    limits: Limits,
}

/// A document with what its layers are on.
pub struct Opened {
    pub context: Context,
    /// The cage, or the triangle mesh.
    pub mesh: Mesh,
    pub object: AnyObject,
    pub history: History,
    /// What the user should know.
    pub notes: Vec<String>,
}

/// Works on a decal, whatever kind of surface it lies on.
pub trait Task {
    /// What comes of it.
    type Done;

    /// Works on the decal with the number `id`, made of `recipe`.
    fn run<O: Printable>(self, ground: &mut Ground<'_, O>, id: u32, recipe: Recipe) -> Result<Self::Done>;
}

impl Arguments {
    /// Opens the document.
    ///
    /// # Errors
    /// A file cannot be read, the document is that of another mesh or is damaged.
    pub fn open(&self) -> Result<Opened> {
        let context = self.limits.context()?;
        let limit = context.memory_limit();
        let mesh = relievo_meshio::read(&context, &self.file)?;
        let (document, history) = History::open(&self.document, limit, MEMORY)?;
        let mut notes = document.notes.clone();
        let object = if document.topology().is_of_triangles() {
            document.fit_triangles(&mesh).map_err(|error| self.named(error))?;
            let object = triangles::opened(&context, &document, &mesh).map_err(|error| self.named(error))?;
            AnyObject::Triangles(Box::new(object))
        } else {
            notes.extend(document.fit(&mesh).map_err(|error| self.named(error))?);
            AnyObject::Tiles(Box::new(self.tiles(&context, &document, &mesh, &mut notes)?))
        };
        Ok(Opened { context, mesh, object, history, notes })
    }

    /// The limit surface of a cage with the layers of the document.
    fn tiles(
        &self,
        context: &Context,
        document: &Document,
        cage: &Mesh,
        notes: &mut Vec<String>,
    ) -> Result<DisplacedObject> {
        let limit = context.memory_limit();
        let isolation = self.isolation.isolation;
        let (options, lowered) = Surface::choose_isolation(context, cage, &SurfaceOptions::default(), isolation)?;
        notes.extend(lowered);
        let surface = Surface::new(context, cage, &options)?;
        let topology = surface.topology().clone();
        let channel = ChannelOptions { budget: limit, ..ChannelOptions::default() };
        let displacement = Displacement::new(topology.clone(), &channel)?;
        let mut object = DisplacedObject::new(context, surface, &cage.points, displacement, DAffine3::IDENTITY)?;
        let has = |kind: Kind| document.layers().iter().any(|layer| layer.kind() == kind);
        if has(Kind::Rgba8) {
            object.set_paint(Paint::<Rgba8>::of_color(topology, Vec4::ZERO, &channel)?)?;
        } else if has(Kind::Rgba16) {
            object.set_half_paint(Paint::of_color(topology, Vec4::ZERO, &channel)?)?;
        }
        let left = object.take_up(context, document, limit).map_err(|error| self.named(error))?;
        notes.extend(left.into_iter().map(|name| format!("layer `{name}` of the document is left as it is")));
        Ok(object)
    }

    /// Lets a task work on the decal in the layer, and waits until what it did is on the disk.
    ///
    /// # Errors
    /// No decal lies in that layer, or as the task.
    pub fn work<T: Task>(&self, opened: &mut Opened, task: T) -> Result<T::Done> {
        let Opened { context, mesh, object, history, .. } = opened;
        let done = with_object!(object, object => {
            let (id, recipe) = self.find(&**object, history)?;
            task.run(&mut Ground { context, object: &mut **object, cage: mesh, history }, id, recipe)
        });
        let done = done.map_err(|error| self.named(error))?;
        history.sync()?;
        Ok(done)
    }

    /// The decal in the layer.
    fn find(&self, object: &impl LayeredObject, history: &History) -> Result<(u32, Recipe)> {
        let layer = object.layer(&self.layer);
        for (id, recipe) in recipes(history) {
            let recipe = recipe.map_err(|error| self.named(error))?;
            if Some(recipe.layer) == layer {
                return Ok((id, recipe));
            }
        }
        let error = Error::invalid(format!("no decal lies in a layer `{}` of its own", self.layer));
        Err(self.named(error).advise("name the layer that `relievo decal apply` added"))
    }

    /// Says that an error is of the document.
    fn named(&self, error: Error) -> Error {
        error.at(path(&self.document))
    }
}

/// A path in messages.
pub fn path(file: &Path) -> String {
    file.display().to_string()
}
