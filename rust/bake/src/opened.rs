//! What a document says of a mesh: its surface, and channels by the names of layers.

use relievo_core::error::nearest;
use relievo_core::{Context, Error, ErrorKind, Mesh, Result};
use relievo_document::{Document, Kind, Layer};
use relievo_surface::{Surface, SurfaceOptions};
use relievo_tiles::{
    Channel, ChannelOptions, Displacement, Field, Paint, Rgba8, Rgba16, StoredTexel, Traces, VectorDisplacement,
};

use crate::quantity::Colors;

/// A document and the surface of its mesh.
#[derive(Debug)]
pub struct Opened<'a> {
    document: &'a Document,
    surface: Surface,
    /// What the user should know.
    pub notes: Vec<String>,
}

/// Colours of a layer.
#[derive(Debug)]
pub enum ColorLayer {
    /// Of bytes.
    Rgba8(Paint<Rgba8>),
    /// Of half floats.
    Rgba16(Paint<Rgba16>),
}

impl ColorLayer {
    /// For look-up.
    pub fn colors(&self) -> &dyn Colors {
        match self {
            ColorLayer::Rgba8(paint) => paint.field() as &Field<Rgba8>,
            ColorLayer::Rgba16(paint) => paint.field() as &Field<Rgba16>,
        }
    }
}

/// Of several layers of a kind, the one with the name that scenes give is meant.
const DISPLACEMENT: &str = "displacement";
const VECTORS: &str = "vectors";
const COLOR: &str = "colour";
const TRACES: &str = "traces";

impl<'a> Opened<'a> {
    /// Fails if the document was made on another mesh, or the mesh cannot be subdivided.
    pub fn new(context: &Context, document: &'a Document, mesh: &Mesh, options: &SurfaceOptions) -> Result<Self> {
        let notes = document.fit(mesh)?.into_iter().chain(document.notes.iter().cloned()).collect();
        Ok(Self { document, surface: Surface::new(context, mesh, options)?, notes })
    }

    /// The surface.
    pub fn surface(&self) -> &Surface {
        &self.surface
    }

    /// What the layer called `name` is; `None` if none was named. Fails if there is no such layer.
    pub fn kind(&self, name: Option<&str>) -> Result<Option<Kind>> {
        let Some(name) = name else { return Ok(None) };
        match self.document.layer(name) {
            Some(layer) => Ok(Some(layer.kind())),
            None => {
                let names: Vec<&str> = self.document.layers().iter().map(Layer::name).collect();
                let guess = nearest(name, names.iter().copied());
                let guess = guess.map_or(String::new(), |guess| format!(", perhaps `{guess}`"));
                Err(Error::new(ErrorKind::NotFound, format!("the document has no layer `{name}`"))
                    .advise(format!("name one of {}{guess}", names.join(", "))))
            }
        }
    }

    /// The layer of one of `kinds` that is meant: the one called `name` if it is one, or the only one, or the one called
    /// `usual`. Fails if there are several and none of these.
    fn layer(&self, kinds: &[Kind], name: Option<&str>, usual: &str) -> Result<Option<&'a Layer>> {
        self.kind(name)?;
        let of_kind: Vec<&Layer> =
            self.document.layers().iter().filter(|layer| kinds.contains(&layer.kind())).collect();
        let named = |name: &str| of_kind.iter().copied().find(|layer| layer.name() == name);
        match (name.and_then(named).or_else(|| named(usual)), &of_kind[..]) {
            (Some(layer), _) => Ok(Some(layer)),
            (None, []) => Ok(None),
            (None, [layer]) => Ok(Some(layer)),
            (None, several) => {
                let names: Vec<&str> = several.iter().map(|layer| layer.name()).collect();
                Err(Error::invalid(format!("the document has {} layers of that kind", several.len()))
                    .advise(format!("name one of {}", names.join(", "))))
            }
        }
    }

    fn channel<T: StoredTexel>(&self, context: &Context, layer: &Layer) -> Result<Channel<T>> {
        let topology = self.surface.topology().clone();
        let channel = Channel::stored(context, topology, self.document, layer.name(), context.memory_limit())?;
        channel.ok_or_else(|| Error::internal("a layer that was there is not"))
    }

    /// The scalar displacement of the layer called `name`, if the document has displacement.
    pub fn displacement(&self, context: &Context, name: Option<&str>) -> Result<Option<Displacement>> {
        let layer = self.layer(&[Kind::Scalar], name, DISPLACEMENT)?;
        layer.map(|layer| self.channel(context, layer)).transpose()
    }

    /// The vector displacement of the layer called `name`, if the document has vector displacement.
    pub fn vectors(&self, context: &Context, name: Option<&str>) -> Result<Option<VectorDisplacement>> {
        let Some(layer) = self.layer(&[Kind::Vector], name, VECTORS)? else { return Ok(None) };
        VectorDisplacement::stored_on(context, &self.surface, self.document, layer.name(), context.memory_limit())
    }

    /// A displacement of zero everywhere.
    pub fn undisplaced(&self) -> Result<Displacement> {
        Displacement::new(self.surface.topology().clone(), &ChannelOptions::default())
    }

    /// The colours of the layer called `name`, if the document has colours.
    pub fn colors(&self, context: &Context, name: Option<&str>) -> Result<Option<ColorLayer>> {
        let Some(layer) = self.layer(&[Kind::Rgba8, Kind::Rgba16], name, COLOR)? else { return Ok(None) };
        Ok(Some(match layer.kind() {
            Kind::Rgba8 => ColorLayer::Rgba8(self.channel(context, layer)?),
            _ => ColorLayer::Rgba16(self.channel(context, layer)?),
        }))
    }

    /// The traces of the layer called `name`, if the document has traces.
    pub fn traces(&self, context: &Context, name: Option<&str>) -> Result<Option<Traces>> {
        let layer = self.layer(&[Kind::Trace], name, TRACES)?;
        layer.map(|layer| self.channel(context, layer)).transpose()
    }
}
