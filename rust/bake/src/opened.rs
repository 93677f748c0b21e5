//! What a document says of a mesh: its surface, and what its layers come to, alone or together.

use std::sync::Arc;

use relievo_core::error::nearest;
use relievo_core::{Context, Error, ErrorKind, Mesh, Result};
use relievo_document::{Document, Kind, Layer, Settings};
use relievo_surface::{Surface, SurfaceOptions, TileTopology};
use relievo_tiles::{
    Channel, ChannelOptions, Displacement, Field, Layered, Paint, Rgba8, Rgba16, Sheet, StoredTexel, Traces,
    VectorDisplacement,
};

use crate::quantity::Colors;

/// A document and the surface of its mesh.
#[derive(Debug)]
pub struct Opened<'a> {
    document: &'a Document,
    surface: Surface,
    options: SurfaceOptions,
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

/// Of several layers of vectors or traces, the one with the name that scenes give is meant.
const VECTORS: &str = "vectors";
const TRACES: &str = "traces";

impl<'a> Opened<'a> {
    /// Makes the surface of `mesh` for a document, with so many levels of isolation; `None` for the default, or fewer
    /// where that exceeds the memory limit.
    ///
    /// # Errors
    /// The document was made on another mesh, or the mesh cannot be subdivided.
    pub fn new(context: &Context, document: &'a Document, mesh: &Mesh, isolation: Option<u32>) -> Result<Self> {
        let mut notes: Vec<String> = document.fit(mesh)?.into_iter().chain(document.notes.iter().cloned()).collect();
        let (options, lowered) = Surface::choose_isolation(context, mesh, &SurfaceOptions::default(), isolation)?;
        notes.extend(lowered);
        Ok(Self { document, surface: Surface::new(context, mesh, &options)?, options, notes })
    }

    /// Returns how the mesh became the surface.
    pub fn options(&self) -> &SurfaceOptions {
        &self.options
    }

    /// The surface.
    pub fn surface(&self) -> &Surface {
        &self.surface
    }

    /// What the layer called `name` is; `None` if none was named.
    ///
    /// # Errors
    /// Fails with `NotFound`, and the names that exist, if there is no such layer.
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

    /// The layer of one of `kinds` that is meant: the one called `name` if it is one, or the only one, or the one
    /// called `usual`. Fails if there are several and none of these.
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
        channel(context, self.document, self.surface.topology(), layer)
    }

    fn composite<T: Layered>(&self, context: &Context, layers: &[&Layer], named: bool) -> Result<Channel<T>> {
        composite(context, self.document, self.surface.topology(), layers, named)
    }

    /// The layers of `kinds`: the one called `name` alone, and true, if it is one of them, or else all.
    fn layers(&self, kinds: &[Kind], name: Option<&str>) -> Result<(Vec<&'a Layer>, bool)> {
        self.kind(name)?;
        let of_kind: Vec<&Layer> =
            self.document.layers().iter().filter(|layer| kinds.contains(&layer.kind())).collect();
        match of_kind.iter().copied().find(|layer| Some(layer.name()) == name) {
            Some(layer) => Ok((vec![layer], true)),
            None => Ok((of_kind, false)),
        }
    }

    /// The scalar displacement of the layer called `name`, or what all layers of displacement come to; `None` without
    /// such layers.
    ///
    /// # Errors
    /// Fails with `NotFound` if there is no layer called `name`, with `Invalid` if a layer is damaged, and with
    /// `Memory` if the layers do not fit the context's memory limit.
    pub fn displacement(&self, context: &Context, name: Option<&str>) -> Result<Option<Displacement>> {
        match self.layers(&[Kind::Scalar], name)? {
            (layers, _) if layers.is_empty() => Ok(None),
            (layers, named) => self.composite(context, &layers, named).map(Some),
        }
    }

    /// The vector displacement of the layer called `name`, if the document has vector displacement.
    ///
    /// # Errors
    /// Fails with `NotFound` if there is no layer called `name`, with `Invalid` if the layer is damaged or one of
    /// several is to be named, and with `Memory` if it does not fit the context's memory limit.
    pub fn vectors(&self, context: &Context, name: Option<&str>) -> Result<Option<VectorDisplacement>> {
        let Some(layer) = self.layer(&[Kind::Vector], name, VECTORS)? else { return Ok(None) };
        VectorDisplacement::stored_on(context, &self.surface, self.document, layer.name(), context.memory_limit(), None)
    }

    /// A displacement of zero everywhere.
    ///
    /// # Errors
    /// Fails only as [`Displacement::new`] does with the default options.
    pub fn undisplaced(&self) -> Result<Displacement> {
        Displacement::new(self.surface.topology().clone(), &ChannelOptions::default())
    }

    /// The colours of the layer called `name`, or what all layers of colour come to; `None` without such layers.
    ///
    /// # Errors
    /// Fails with `NotFound` if there is no layer called `name`, with `Unsupported` if some of several are bytes and
    /// others half floats, with `Invalid` if a layer is damaged, and with `Memory` if they do not fit the context's
    /// memory limit.
    pub fn colors(&self, context: &Context, name: Option<&str>) -> Result<Option<ColorLayer>> {
        let (layers, named) = self.layers(&[Kind::Rgba8, Kind::Rgba16], name)?;
        let bytes = layers.iter().filter(|layer| layer.kind() == Kind::Rgba8).count();
        if layers.is_empty() {
            Ok(None)
        } else if bytes == layers.len() {
            Ok(Some(ColorLayer::Rgba8(self.composite(context, &layers, named)?)))
        } else if bytes == 0 {
            Ok(Some(ColorLayer::Rgba16(self.composite(context, &layers, named)?)))
        } else {
            Err(Error::unsupported("some layers of colour are bytes and others half floats").advise("name one layer"))
        }
    }

    /// The traces of the layer called `name`, if the document has traces.
    ///
    /// # Errors
    /// Fails with `NotFound` if there is no layer called `name`, with `Invalid` if the layer is damaged or one of
    /// several is to be named, and with `Memory` if it does not fit the context's memory limit.
    pub fn traces(&self, context: &Context, name: Option<&str>) -> Result<Option<Traces>> {
        let layer = self.layer(&[Kind::Trace], name, TRACES)?;
        layer.map(|layer| self.channel(context, layer)).transpose()
    }
}

/// The channel of one layer.
pub(crate) fn channel<T: StoredTexel>(
    context: &Context,
    document: &Document,
    topology: &Arc<TileTopology>,
    layer: &Layer,
) -> Result<Channel<T>> {
    let channel = Channel::stored(context, topology.clone(), document, layer.name(), context.memory_limit())?;
    channel.ok_or_else(|| Error::internal("a layer that was there is not"))
}

/// What `layers`, of one kind, come to: one alone as it is if `named`, or else as all are seen together.
pub(crate) fn composite<T: Layered>(
    context: &Context,
    document: &Document,
    topology: &Arc<TileTopology>,
    layers: &[&Layer],
    named: bool,
) -> Result<Channel<T>> {
    let mut channels = Vec::with_capacity(layers.len());
    for layer in layers {
        channels.push(channel::<T>(context, document, topology, layer)?);
    }
    if let ([_], true) = (layers, named || layers.iter().all(|layer| is_plain(layer))) {
        return channels.pop().ok_or_else(|| Error::internal("a layer that was there is not"));
    }
    let sheets: Vec<Sheet<'_, Field<T>>> = channels
        .iter()
        .zip(layers)
        .map(|(channel, layer)| Sheet { field: channel.field(), settings: layer.settings() })
        .collect();
    let lowest = channels.first().ok_or_else(|| Error::internal("there are no layers to put together"))?;
    let behind = layers.first().map_or(&[][..], |layer| &layer.head().behind);
    let background = if behind.is_empty() { lowest.field().blank() } else { bytemuck::pod_read_unaligned(behind) };
    let (made, refused) = lowest.recomposed(context, &sheets, background)?;
    match refused.len() {
        0 => Ok(made),
        count => Err(Error::memory(format!("{count} tiles of the layers together do not fit the memory limit"))
            .advise("raise it, or name one layer")),
    }
}

/// Whether a layer looks alone as its texels are.
pub(crate) fn is_plain(layer: &Layer) -> bool {
    layer.settings() == Settings::of(layer.kind())
}
