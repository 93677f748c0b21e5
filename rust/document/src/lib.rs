//! Documents: a file that holds the layers of one surface, to be taken up again.
//!
//! - What a document is: [`Document`], its [`layer`]s of compressed blocks, and the [`topology`] of the mesh they
//!   belong to.
//! - How it lies in a file, and what of a file is damaged: [`format`](mod@format).
//! - How blocks leave memory: [`pages`].
//! - What things on the layers were made of: [`recipe`].
//! - Where it lies otherwise than in a file: [`storage`].
//! - How it is worked on: a [`journal`] of [`record`]s, each [`edit`] one of them, and their [`replay`].
//!
//! A document knows tiles by their numbers and blocks by their bytes; what they mean is for their owners.

pub mod code;
mod copies;
pub mod edit;
pub mod format;
pub mod head;
pub mod journal;
pub mod lattice;
pub mod layer;
mod packing;
pub mod pages;
pub mod recipe;
pub mod record;
pub mod replay;
pub mod storage;
mod summary;
pub mod topology;

pub use edit::{Change, Direction, Edit};
pub use format::{Damage, examine};
pub use head::{Blend, Head, Settings, Stamps};
pub use journal::{Journal, ListedEdit, compact, list_edits, repair};
pub use lattice::Lattice;
pub use layer::{Block, Kind, Layer};
pub use pages::{Page, PageFile, PageStore};
pub use recipe::{Recipe, RecipeChange};
pub use replay::{Entry, Log};
pub use storage::Storage;
pub use topology::{Difference, Topology};

use std::sync::Arc;

use relievo_core::{Context, Error, Mesh, Result};

/// The layers of a surface and the mesh they belong to.
#[derive(Clone, Debug, PartialEq)]
pub struct Document {
    /// The program that wrote it and its version.
    pub writer: String,
    /// Instruction level it was made at: results of levels differ in the last bit.
    pub level: String,
    /// The format version of its file; that of this build where it has none.
    pub version: u32,
    /// When it was written, in the seconds by which edits of its layers fade; its journal may have later ones.
    pub time: f64,
    /// What the user should know of how it was found; not in the file.
    pub notes: Vec<String>,
    topology: Topology,
    /// Of the mesh when the document was made; none in documents of version 1.
    points: Vec<[f32; 3]>,
    layers: Vec<Layer>,
    /// What things on the layers were made of, ascending by number.
    recipes: Vec<Recipe>,
    /// The file it was read from.
    source: pages::Source,
}

/// Layers a document may have.
pub const MAX_LAYERS: usize = 1024;

impl Document {
    /// A document without layers for surfaces over `mesh`, made at the instruction level called `level`.
    ///
    /// The points of the mesh are kept so that layers can be transferred to another one.
    ///
    /// # Errors
    /// Fails as [`Topology::of`], and with `Invalid` if `level` is longer than 255 bytes.
    pub fn new(mesh: &Mesh, level: &str) -> Result<Self> {
        Self::over(Topology::of(mesh)?, mesh, level)
    }

    /// A document without layers for channels over the triangles of `mesh`.
    ///
    /// # Errors
    /// Fails as [`Topology::of_triangles`], and with `Invalid` if `level` is longer than 255 bytes.
    pub fn of_triangles(mesh: &Mesh, level: &str) -> Result<Self> {
        Self::over(Topology::of_triangles(mesh)?, mesh, level)
    }

    fn over(topology: Topology, mesh: &Mesh, level: &str) -> Result<Self> {
        let writer = format!("relievo {}", env!("CARGO_PKG_VERSION"));
        if level.len() > usize::from(u8::MAX) {
            return Err(Error::invalid("the name of the instruction level is longer than 255 bytes"));
        }
        let (level, points, version) = (level.to_string(), mesh.points.clone(), format::VERSION);
        Ok(Self {
            writer,
            level,
            version,
            time: 0.0,
            notes: Vec::new(),
            topology,
            points,
            layers: Vec::new(),
            recipes: Vec::new(),
            source: Default::default(),
        })
    }

    /// The mesh it belongs to.
    pub fn topology(&self) -> &Topology {
        &self.topology
    }

    /// The points of the mesh when the document was made; none if it does not have them.
    pub fn points(&self) -> &[[f32; 3]] {
        &self.points
    }

    /// The mesh it was made on, without what sharpened it; `None` if the document does not have its points.
    pub fn mesh(&self) -> Option<Mesh> {
        let points = Some(self.points()).filter(|points| !points.is_empty())?;
        let [sizes, corners] = [self.topology.face_sizes(), self.topology.corners()].map(<[u32]>::to_vec);
        let mut mesh = Mesh::new(points.to_vec(), sizes, corners);
        mesh.holes = self.topology.holes().to_vec();
        Some(mesh)
    }

    /// Its layers, from the lowest to the highest, in the order they were added.
    pub fn layers(&self) -> &[Layer] {
        &self.layers
    }

    /// What things on the layers were made of, ascending by number.
    pub fn recipes(&self) -> &[Recipe] {
        &self.recipes
    }

    /// Puts a recipe in place of the one with the number `id`, or removes that without `bytes`.
    ///
    /// # Errors
    /// As [`recipe::put`].
    pub fn put_recipe(&mut self, id: u32, bytes: Option<Vec<u8>>) -> Result<()> {
        recipe::put(&mut self.recipes, id, bytes)
    }

    /// The layer called `name`.
    pub fn layer(&self, name: &str) -> Option<&Layer> {
        self.layers.iter().find(|layer| layer.name() == name)
    }

    /// Adds a layer called `name` with the blocks that `read` returns of `tiles`, which ascend. Tiles without one read
    /// as the texel `blank`; `face_sizes` has the texels along an edge of every face.
    ///
    /// # Errors
    /// Fails, and adds nothing, with `Invalid` if there are [`MAX_LAYERS`] layers, the name is taken, empty, longer
    /// than 255 bytes or has control characters, there is not a size from 8 to 256, a power of two, for every face, or
    /// on triangles one from 8 to 64 for all, `blank` is not one texel, a tile does not exist or follow the one before,
    /// or a block has not the bytes of its tile and ring; with the error of `read`; and with `Internal` if zstd fails.
    pub fn pack(
        &mut self,
        context: &Context,
        (name, kind, blank): (&str, Kind, &[u8]),
        face_sizes: Vec<u32>,
        tiles: &[u32],
        read: impl Fn(u32) -> Result<Vec<u8>> + Sync,
    ) -> Result<()> {
        self.pack_layer(context, Head::new(self.free_id(), name, kind, blank, face_sizes), tiles, read)
    }

    /// As [`Self::pack`], with a number and settings of its own.
    ///
    /// # Errors
    /// Fails as [`Self::pack`], and with `Invalid` if the number is taken or above [`head::MAX_ID`], or the settings,
    /// stamps, given sizes or background of `head` do not suit the layer.
    pub fn pack_layer(
        &mut self,
        context: &Context,
        head: Head,
        tiles: &[u32],
        read: impl Fn(u32) -> Result<Vec<u8>> + Sync,
    ) -> Result<()> {
        self.add(Layer::pack(context, &self.topology, head, tiles, read)?)
    }

    /// The block at `index` of layer number `layer` of [`Self::layers`], to be read from the file that it was read
    /// from; `None` if it is not there as it is now.
    pub fn page(&self, layer: usize, index: usize) -> Option<Arc<dyn Page>> {
        let layer = self.layers.get(layer)?;
        let block = layer.blocks.get(index)?;
        let unpacked = usize::try_from(layer.block_bytes(&self.topology, index)).ok()?;
        self.source.page(block.place.0?, block.packed.len() as u64, block.crc, unpacked)
    }

    /// A number that no layer has.
    pub fn free_id(&self) -> u32 {
        self.layers.iter().map(|layer| layer.id().saturating_add(1)).max().unwrap_or(0)
    }

    /// Adds a layer. Fails if there is one of that name or number, it is for a mesh with another number of faces, or a
    /// block belongs to no tile.
    fn add(&mut self, layer: Layer) -> Result<()> {
        layer.check(&self.topology)?;
        if self.layers.len() == MAX_LAYERS {
            let what = format!("a document has at most {MAX_LAYERS} layers");
            return Err(Error::invalid(what).at(layer.head.place()));
        }
        head::check_distinct(&layer.head, self.layers.iter().map(Layer::head))?;
        self.layers.push(layer);
        Ok(())
    }

    /// Checks that it belongs to the triangles of `mesh`.
    ///
    /// # Errors
    /// Fails with `Invalid` if it was made on a Catmull-Clark surface or on other triangles; the error says what
    /// differs.
    pub fn fit_triangles(&self, mesh: &Mesh) -> Result<()> {
        if !self.topology.is_of_triangles() {
            return Err(Error::invalid("the document was made on a Catmull-Clark surface and not on one of triangles")
                .advise("give the object a surface over that mesh without `kind`"));
        }
        let triangles = mesh.triangles();
        let points = mesh.points.len();
        let mesh = Mesh::new(Vec::new(), vec![3; triangles.len()], triangles.into_flattened());
        let mut differs = self.topology.difference(&mesh).map(|difference| difference.to_string());
        if differs.is_none() && self.points.len() != points {
            differs = Some(format!("it has {} points, this one {points}", self.points.len()));
        }
        differs.map_or(Ok(()), |difference| {
            Err(Error::invalid(format!("the document was made on other triangles: {difference}")).advise(
                "give it the mesh it was made on, split as it was, with its triangles in the same order, or take its \
                     layers to this one with `relievo doc transfer`",
            ))
        })
    }

    /// Checks that it belongs to `mesh`. Returns what the user should know if only sharpness differs, which shapes the
    /// surface and does not move tiles.
    ///
    /// # Errors
    /// Fails with `Invalid` if it was made on triangles or on other faces; the error says what differs.
    pub fn fit(&self, mesh: &Mesh) -> Result<Option<String>> {
        if self.topology.is_of_triangles() {
            return Err(Error::invalid(
                "the document was made on a surface of triangles and not on a Catmull-Clark one",
            )
            .advise("give the object a surface over that mesh with `kind = \"triangles\"`"));
        }
        if let Some(difference) = self.topology.difference(mesh) {
            return Err(Error::invalid(format!("the document was made on another mesh: {difference}")).advise(
                "give it the mesh it was made on, with its faces and corners in the same order, or take its layers to \
                     this one with `relievo doc transfer`",
            ));
        }
        Ok((self.topology.sharpness() != topology::sharpness(mesh)).then(|| {
            "creases or sharp points of the mesh are not those the document was made with; its layers then sit on \
             another shape"
                .to_string()
        }))
    }
}
