//! Documents: a file that holds the layers of one surface, to be taken up again.
//!
//! - What a document is: [`Document`], its [`layer`]s of compressed blocks, and the [`topology`] of the mesh they
//!   belong to.
//! - How it lies in a file, and what of a file is damaged: [`format`](mod@format).
//!
//! A document knows tiles by their numbers and blocks by their bytes; what they mean is for those who own them.

mod code;
pub mod format;
pub mod layer;
mod summary;
pub mod topology;

pub use format::{Damage, examine};
pub use layer::{Block, Kind, Layer};
pub use topology::{Difference, Topology};

use relievo_core::{Context, Error, Mesh, Result};

/// The layers of a surface and the mesh they belong to.
#[derive(Clone, Debug, PartialEq)]
pub struct Document {
    /// The program that wrote it and its version.
    pub writer: String,
    /// Instruction level it was made at: results of levels differ in the last bit.
    pub level: String,
    topology: Topology,
    layers: Vec<Layer>,
}

/// Layers a document may have.
pub const MAX_LAYERS: usize = 1024;

impl Document {
    /// A document without layers for surfaces over `mesh`, made at the instruction level called `level`.
    ///
    /// Fails if the mesh has more tiles than a number of 32 bits counts, or `level` is longer than 255 bytes.
    pub fn new(mesh: &Mesh, level: &str) -> Result<Self> {
        let writer = format!("relievo {}", env!("CARGO_PKG_VERSION"));
        if level.len() > usize::from(u8::MAX) {
            return Err(Error::invalid("the name of the instruction level is longer than 255 bytes"));
        }
        Ok(Self { writer, level: level.to_string(), topology: Topology::of(mesh)?, layers: Vec::new() })
    }

    /// The mesh it belongs to.
    pub fn topology(&self) -> &Topology {
        &self.topology
    }

    /// Its layers, in the order they were added.
    pub fn layers(&self) -> &[Layer] {
        &self.layers
    }

    /// The layer called `name`.
    pub fn layer(&self, name: &str) -> Option<&Layer> {
        self.layers.iter().find(|layer| layer.name == name)
    }

    /// Adds a layer called `name` with the blocks that `read` returns of `tiles`, which ascend. Tiles without one read as
    /// the texel `blank`; `face_sizes` has the texels along an edge of every face.
    ///
    /// Fails, and adds nothing, if the name is taken, empty or longer than 255 bytes, there is not a size from 8 to 256,
    /// a power of two, for every face, `blank` is not one texel, a tile does not exist, a block has not the bytes of its
    /// tile and ring, or `read` fails.
    pub fn pack(
        &mut self,
        context: &Context,
        (name, kind, blank): (&str, Kind, &[u8]),
        face_sizes: Vec<u32>,
        tiles: &[u32],
        read: impl Fn(u32) -> Result<Vec<u8>> + Sync,
    ) -> Result<()> {
        self.add(Layer::pack(context, &self.topology, (name, kind, blank), face_sizes, tiles, read)?)
    }

    /// Adds a layer. Fails if there is one of that name, it is for a mesh with another number of faces, or a block
    /// belongs to no tile.
    fn add(&mut self, layer: Layer) -> Result<()> {
        layer.check(&self.topology)?;
        let place = || format!("layer `{}`", layer.name);
        if self.layer(&layer.name).is_some() {
            return Err(Error::invalid("the document has a layer of that name")
                .at(place())
                .advise("name it otherwise"));
        }
        if self.layers.len() == MAX_LAYERS {
            return Err(Error::invalid(format!("a document has at most {MAX_LAYERS} layers")).at(place()));
        }
        self.layers.push(layer);
        Ok(())
    }

    /// Whether it belongs to `mesh`. Fails with what differs if faces do; returns what the user should know if only
    /// sharpness does, which shapes the surface and does not move tiles.
    pub fn fit(&self, mesh: &Mesh) -> Result<Option<String>> {
        if let Some(difference) = self.topology.difference(mesh) {
            return Err(Error::invalid(format!("the document was made on another mesh: {difference}"))
                .advise("give it the mesh it was made on, with its faces and corners in the same order"));
        }
        Ok((self.topology.sharpness() != topology::sharpness(mesh)).then(|| {
            "creases or sharp points of the mesh are not those the document was made with; its layers then sit on \
             another shape"
                .to_string()
        }))
    }
}
