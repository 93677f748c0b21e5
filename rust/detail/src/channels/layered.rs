//! The layers of an object: stacks of displacement and of colour, and how they are recorded and kept in documents.

use std::sync::Arc;

use glam::Vec4;
use half::f16;
use relievo_core::{Context, Error, Result};
use relievo_document::head::STAMPS_OF;
use relievo_document::{self as document, Document, Head, Kind, MAX_LAYERS, PageStore, Settings};
use relievo_gpu::Device;
use relievo_tiles::{
    Blocks, ByFormat, Channel, ColorTexel, DecayOptions, Displacement, Paint, Rgba8, Rgba16, StoredTexel, Traces,
    VectorDisplacement, by_format,
};

use crate::channels::fading::{
    DecayingObject, add_stamp_states, find_stamps, name_expendable, put_stamps, stamp_numbers,
};
use crate::channels::history::{BlockState, LayerState, LayerStates, Recorded};
use crate::channels::layer_channel::{BlockChannel, LayerChannel};
use crate::channels::layers::{Stack, no_layer};
use crate::device::DeviceObject;
use crate::object::DisplacedObject;
use crate::object::transform::check_time;

/// The numbers of the layers that every object may have.
const DISPLACEMENT: u32 = 0;
const COLOUR: u32 = 1;
const TRACES: u32 = 2;
const VECTORS: u32 = 3;
/// The first number of added layers.
const ADDED: u32 = 16;

/// The stacks of an object.
#[derive(Debug)]
pub struct Layers<H: LayerChannel = Displacement, C: LayerChannel = Paint, W: LayerChannel = Paint<Rgba16>> {
    /// Those of displacement.
    pub(crate) displacement: Stack<H>,
    /// Those of colour, of 8 bits or of half floats, if it has colours.
    pub(crate) colors: Option<Colors<C, W>>,
    /// How the object's own displacement and colours, the lowest layers, fade, and the bytes that stamps may occupy.
    pub(crate) decay: Option<(DecayOptions, u64)>,
    /// Tiles or faces that were lost, and ones that got no stamps, since [`DecayingObject`] was asked last.
    pub(crate) lost: u64,
    pub(crate) unstamped: u64,
    /// When edits are made now, in seconds.
    pub(crate) time: f64,
    /// What blocks page to, if they do.
    pub(crate) pages: Option<Arc<dyn PageStore>>,
    /// The numbers of its traces and of its vectors.
    others: [u32; 2],
    /// What [`LayeredObject::read_sizes`] gave when sizes were committed.
    sizes: Vec<(u32, Vec<u8>)>,
}

/// The layers of colour of an object, which have one format.
pub type Colors<C, W> = ByFormat<Stack<C>, Stack<W>>;

/// The stacks of an object of the kind `O`.
pub type LayersOf<O> =
    Layers<<O as LayeredObject>::Displacement, <O as LayeredObject>::Paint, <O as LayeredObject>::HalfPaint>;

impl<H: LayerChannel<Texel = f16>, C: LayerChannel, W: LayerChannel> Layers<H, C, W> {
    /// Makes the layers of an object that has `displacement` and no colours.
    pub(crate) fn new(displacement: H) -> Self {
        Self {
            displacement: Stack::new((DISPLACEMENT, "displacement"), displacement, f16::ZERO),
            colors: None,
            decay: None,
            lost: 0,
            unstamped: 0,
            time: 0.0,
            pages: None,
            others: [TRACES, VECTORS],
            sizes: Vec::new(),
        }
    }

    /// Takes colours in place of those it may have.
    pub(crate) fn set_colors(&mut self, paint: ByFormat<C, W>) {
        self.colors = Some(match paint {
            ByFormat::Rgba8(paint) => ByFormat::Rgba8(colors(paint)),
            ByFormat::Rgba16(paint) => ByFormat::Rgba16(colors(paint)),
        });
    }

    /// Returns the colours of 8 bits and the ones of half floats, of which an object has one at most.
    pub(crate) fn paints(&self) -> (Option<&C>, Option<&W>) {
        match &self.colors {
            None => (None, None),
            Some(ByFormat::Rgba8(stack)) => (Some(stack.composite()), None),
            Some(ByFormat::Rgba16(stack)) => (None, Some(stack.composite())),
        }
    }

    /// As [`Self::paints`], for writing.
    pub(crate) fn paints_mut(&mut self) -> (Option<&mut C>, Option<&mut W>) {
        match &mut self.colors {
            None => (None, None),
            Some(ByFormat::Rgba8(stack)) => (Some(stack.composite_mut()), None),
            Some(ByFormat::Rgba16(stack)) => (None, Some(stack.composite_mut())),
        }
    }

    /// Returns the colours at this moment.
    pub(crate) fn color_fields(&self) -> Option<ByFormat<&C::Field, &W::Field>> {
        let (bytes, halves) = self.paints();
        bytes.map(|paint| ByFormat::Rgba8(paint.field())).or(halves.map(|paint| ByFormat::Rgba16(paint.field())))
    }
}

/// Makes a stack of one layer of colour.
fn colors<C: LayerChannel>(paint: C) -> Stack<C> {
    let background = bytemuck::pod_read_unaligned(paint.field().blank());
    Stack::new((COLOUR, "colour"), paint, background)
}

/// What a layer is, for people and hosts.
#[derive(Clone, Debug, PartialEq)]
pub struct LayerInfo {
    /// Its number, which it keeps.
    pub id: u32,
    /// Its name.
    pub name: String,
    /// What its texels are.
    pub kind: Kind,
    /// How it takes part in what is seen.
    pub settings: Settings,
    /// Whether edits of its kind go to it.
    pub active: bool,
    /// Its tiles.
    pub tiles: usize,
}

/// Does the same with the stacks of `Layers`, that of displacement first.
macro_rules! each_stack {
    ($layers:expr, $stack:ident => $work:expr) => {{
        let Layers { displacement: $stack, colors, .. } = $layers;
        $work;
        if let Some(colors) = colors {
            by_format!(colors, $stack => $work);
        }
    }};
}
pub(crate) use each_stack;

/// Does something with the stack of colours of `Layers`, whichever format they have, or something else without colours.
macro_rules! with_colors {
    ($layers:expr, $stack:ident => $done:expr, $none:expr) => {
        match $layers {
            Layers { colors: Some(ByFormat::Rgba8($stack)), .. } => $done,
            Layers { colors: Some(ByFormat::Rgba16($stack)), .. } => $done,
            _ => $none,
        }
    };
}

/// Does something with the stack of an object that the layer `id` is in, or that of displacement if there is none.
macro_rules! with_stack_of {
    ($object:expr, $id:expr, $stack:ident => $done:expr) => {
        if $object.is_color($id) {
            with_colors!($object.stacks_mut(), $stack => $done, Err(no_colors()))
        } else {
            let $stack = $object.heights_mut();
            $done
        }
    };
}

fn no_colors() -> Error {
    Error::invalid("the object has no colours").advise("give it some first")
}

/// A channel that a document held.
#[derive(Debug)]
pub enum Stored<O: LayeredObject> {
    /// Scalar displacement.
    Displacement(O::Displacement),
    /// Colours of 8 bits.
    Paint(O::Paint),
    /// Colours of half floats.
    HalfPaint(O::HalfPaint),
    /// Traces of contact.
    Traces(O::Traces),
    /// Vector displacement.
    Vectors(O::Vectors),
}

/// An object whose displacement and colours are in layers, over whatever kind of surface.
pub trait LayeredObject: Sized {
    /// What displacement is kept in.
    type Displacement: LayerChannel<Texel = f16>;
    /// What colours of 8 bits are kept in.
    type Paint: LayerChannel<Texel = Rgba8>;
    /// What colours of half floats are kept in.
    type HalfPaint: LayerChannel<Texel = Rgba16>;
    /// What traces are kept in.
    type Traces: BlockChannel;
    /// What vectors are kept in.
    type Vectors: BlockChannel;

    /// The graphics device that edits are made on, if there is one.
    fn device_in_use(&self) -> Option<&Device>;

    /// Has edits made on the processor from now on, because of `fault`.
    fn lose_device(&mut self, fault: Error);

    /// Notes that displacement looks different in and around tiles or faces, because it has faded or was lost.
    fn note_shown(&mut self, _tiles: &[u32]) {}

    /// Returns the stacks of layers.
    fn stacks(&self) -> &LayersOf<Self>;

    /// Returns the stacks of layers, for writing. Displacement is written through [`Self::heights_mut`].
    fn stacks_mut(&mut self) -> &mut LayersOf<Self>;

    /// Returns the layers of displacement, for writing: whatever was measured of it is measured anew.
    fn heights_mut(&mut self) -> &mut Stack<Self::Displacement>;

    /// Traces and vectors, if it has them.
    fn others(&self) -> (Option<&Self::Traces>, Option<&Self::Vectors>);

    /// Traces and vectors, if it has them, to be written.
    fn others_mut(&mut self) -> (Option<&mut Self::Traces>, Option<&mut Self::Vectors>);

    /// The channel that `document` holds as `layer`, in `budget` bytes; `None` where an object has none of its kind.
    ///
    /// # Errors
    /// Fails with `Invalid` if the document is for another mesh or the layer is damaged, with `Memory` if the budget is
    /// too small for what does not go to pages, and as the page store does if a page cannot be read or written.
    fn stored(
        &self,
        context: &Context,
        document: &Document,
        layer: &document::Layer,
        budget: u64,
    ) -> Result<Option<Stored<Self>>>;

    /// Takes the place of its channel of the same kind. Colours become one layer.
    ///
    /// # Errors
    /// Fails with `Invalid` if it is that of another surface, which is not checked for the displacement of a
    /// [`DisplacedObject`]; with `Memory` if the budget of a decay does not hold what the stamps of colours need; and
    /// as the page store does if a page cannot be read or written.
    fn set_channel(&mut self, channel: Stored<Self>) -> Result<()>;

    /// Says when edits are made now, in seconds.
    fn time(&self) -> f64 {
        self.stacks().time
    }

    /// Sets when edits are made from now on, in seconds; 0 at first.
    ///
    /// # Errors
    /// Fails with `Invalid` if the time is not finite or beyond [`f32::MAX`].
    fn set_time(&mut self, time: f64) -> Result<()> {
        check_time(time)?;
        self.stacks_mut().time = time;
        Ok(())
    }

    /// Makes tiles, or blocks of faces and edges, of all channels and layers leave memory for `pages` when their
    /// budgets are spent, the ones edited longest ago first, see [`relievo_tiles::paging`] and
    /// [`relievo_tiles::triangle::paging`]; without, all come back. [`Self::settle`] is to be done before. Normals,
    /// vectors in object space, and the texels and stamps of edits that fade stay in memory.
    ///
    /// # Errors
    /// Fails as the page store does if a block cannot be read back or written; some channels and layers may page to
    /// `pages` then.
    #[inline(never)]
    fn page_to(&mut self, pages: Option<Arc<dyn PageStore>>) -> Result<()> {
        let to = pages.as_ref();
        self.heights_mut();
        each_stack!(self.stacks_mut(), stack => stack.page_to(to)?);
        let (traces, vectors) = self.others_mut();
        traces.map_or(Ok(()), |traces| traces.page_to(to))?;
        vectors.map_or(Ok(()), |vectors| vectors.page_to(to))?;
        self.stacks_mut().pages = pages;
        Ok(())
    }

    /// Says where blocks page to, if they do.
    fn page_store(&self) -> Option<&Arc<dyn PageStore>> {
        self.stacks().pages.as_ref()
    }

    /// Reports a failure of the page store, once for each channel and layer.
    ///
    /// # Errors
    /// Fails with the error of the page store about what could not be read back from a page, or written to one, since
    /// this was called last: a block that is blank to readers, or one that stays in memory beyond its budget.
    #[inline(never)]
    fn report_fault(&self) -> Result<()> {
        each_stack!(self.stacks(), stack => stack.report_fault()?);
        let (traces, vectors) = self.others();
        traces.map_or(Ok(()), BlockChannel::report_fault)?;
        vectors.map_or(Ok(()), BlockChannel::report_fault)
    }

    /// The layers, from the lowest: those of displacement, then those of colour. What is evaluated is
    /// [`Self::displacement`] and [`Self::paint`], to which they come.
    #[inline(never)]
    fn layers(&self) -> Vec<LayerInfo> {
        let info = |state: LayerState, active: u32| LayerInfo {
            id: state.id,
            name: state.name.to_string(),
            kind: state.blocks.kind(),
            settings: state.settings,
            active: state.id == active,
            tiles: state.blocks.numbers().len(),
        };
        let mut layers = Vec::new();
        each_stack!(self.stacks(), stack => {
            layers.extend(stack.states().into_iter().map(|state| info(state, stack.active())));
        });
        layers
    }

    /// The number of the layer called `name`.
    fn layer(&self, name: &str) -> Option<u32> {
        self.layers().into_iter().find(|layer| layer.name == name).map(|layer| layer.id)
    }

    /// Adds a layer of displacement ([`Kind::Scalar`]) or colour (of either kind: it gets the texels of the object's
    /// colours) above those of its kind, with `size` texels along an edge of every face; edits of its kind go to it.
    /// Returns its number and the tiles that the budget refused to the composite.
    ///
    /// # Errors
    /// Fails as [`Self::check_name`] and [`Self::settle`]; with `Invalid` if the settings are not for its kind, there
    /// is no such size, the object has no colours or it cannot have more layers; with `Unsupported` if layers cannot
    /// hold the kind; and as the page store does if a page cannot be read or written.
    #[inline(never)]
    fn add_layer(
        &mut self,
        context: &Context,
        kind: Kind,
        name: &str,
        settings: Settings,
        size: u32,
    ) -> Result<(u32, Vec<u32>)> {
        self.check_name(name)?;
        self.settle(context)?;
        if self.layers().len() >= MAX_LAYERS {
            return Err(Error::invalid(format!("an object has at most {MAX_LAYERS} layers")));
        }
        let faces = self.stacks().displacement.composite().field().face_sizes().len();
        let (id, faces) = (self.free_number(), vec![size; faces]);
        let head = (id, name, settings);
        let refused = match kind {
            Kind::Scalar => self.heights_mut().add(context, head, &faces),
            kind if kind.is_color() => {
                with_colors!(self.stacks_mut(), stack => stack.add(context, head, &faces), Err(no_colors()))
            }
            _ => Err(Error::unsupported(format!("layers cannot hold {}", kind.name()))
                .advise("add layers of scalar displacement or colour")),
        };
        Ok((id, refused.map_err(|error| error.at(format!("layer `{name}`")))?))
    }

    /// A number that no layer has.
    fn free_number(&self) -> u32 {
        let numbers = self.layers().into_iter().map(|layer| layer.id).chain(self.stacks().others);
        numbers.chain(stamp_numbers(self)).map(|id| id + 1).max().unwrap_or(0).max(ADDED)
    }

    /// Checks that a layer can be called `name`.
    ///
    /// # Errors
    /// Fails with `Invalid` unless the name is 1 to 255 bytes without control characters, and if a layer has it already
    /// or it is reserved for traces, vectors or stamps.
    fn check_name(&self, name: &str) -> Result<()> {
        let place = || format!("layer `{name}`");
        if name.is_empty() || name.len() > usize::from(u8::MAX) || name.contains(char::is_control) {
            return Err(Error::invalid("the name of a layer is 1 to 255 bytes of text").at(place()));
        }
        if self.layer(name).is_some() || ["traces", "vectors"].contains(&name) || name.starts_with(STAMPS_OF) {
            return Err(Error::invalid("there is a layer of that name").at(place()).advise("name it otherwise"));
        }
        Ok(())
    }

    /// Whether `id` is the number of a layer of colour.
    fn is_color(&self, id: u32) -> bool {
        with_colors!(self.stacks(), stack => stack.channel(id).is_some(), false)
    }

    /// Makes `id` the layer that edits of its kind go to.
    ///
    /// # Errors
    /// Fails with `Invalid` if there is no such layer, and as [`Self::settle`].
    #[inline(never)]
    fn set_active_layer(&mut self, context: &Context, id: u32) -> Result<()> {
        self.settle(context)?;
        with_stack_of!(self, id, stack => stack.set_active(id))
    }

    /// Names a layer.
    ///
    /// # Errors
    /// Fails with `Invalid` if there is no such layer, and as [`Self::check_name`] if the name is a new one.
    fn rename_layer(&mut self, id: u32, name: &str) -> Result<()> {
        let there = self.layers().into_iter().find(|layer| layer.id == id);
        let there = there.ok_or_else(|| no_layer(id))?;
        if there.name != name {
            self.check_name(name)?;
            each_stack!(self.stacks_mut(), stack => stack.rename(id, name));
        }
        Ok(())
    }

    /// Changes how a layer is seen. Returns the tiles that the budget refused to the composite.
    ///
    /// # Errors
    /// Fails with `Invalid` if there is no such layer or its kind cannot be seen so, as [`Self::settle`], and as the
    /// page store does if a page cannot be read or written.
    #[inline(never)]
    fn set_layer(&mut self, context: &Context, id: u32, to: Settings) -> Result<Vec<u32>> {
        self.settle(context)?;
        with_stack_of!(self, id, stack => stack.set(context, id, to))
    }

    /// Puts a layer at a place among those of its kind, counted from the lowest. Returns the tiles that the budget
    /// refused to the composite.
    ///
    /// # Errors
    /// Fails with `Invalid` if there is no such layer, as [`Self::settle`], and as the page store does if a page cannot
    /// be read or written.
    #[inline(never)]
    fn place_layer(&mut self, context: &Context, id: u32, place: usize) -> Result<Vec<u32>> {
        self.settle(context)?;
        with_stack_of!(self, id, stack => stack.place(context, id, place))
    }

    /// Removes a layer with all that is on it. Returns the tiles that the budget refused to the composite.
    ///
    /// # Errors
    /// Fails with `Invalid` if there is no such layer or it is the last of its kind, as [`Self::settle`], and as the
    /// page store does if a page cannot be read or written.
    #[inline(never)]
    fn remove_layer(&mut self, context: &Context, id: u32) -> Result<Vec<u32>> {
        self.settle(context)?;
        let done = with_stack_of!(self, id, stack => stack.remove(context, id))?;
        name_expendable(self);
        Ok(done)
    }

    /// Puts a layer and the one below it into one that looks as both did, but for rounding; it has the number and the
    /// name of the lower one, and fades no more. Returns the tiles that the budget refused.
    ///
    /// # Errors
    /// Fails, and changes nothing, with `Invalid` if there is no such layer or none below it, one of the two is hidden,
    /// or no one layer would look as both. Fails too as [`Self::settle`], and as the page store does if a page cannot
    /// be read or written.
    #[inline(never)]
    fn merge_layer(&mut self, context: &Context, id: u32) -> Result<Vec<u32>> {
        self.settle(context)?;
        let done = with_stack_of!(self, id, stack => stack.merge_down(context, id))?;
        name_expendable(self);
        Ok(done)
    }

    /// Makes one layer of displacement and one of colour of all: what is seen, to the bit. Where there were several,
    /// the one fades no more.
    ///
    /// # Errors
    /// Fails, and flattens nothing, as [`Self::settle`] does.
    #[inline(never)]
    fn flatten_layers(&mut self, context: &Context) -> Result<Vec<u32>> {
        let refused = self.settle(context)?;
        let mut several = false;
        each_stack!(self.stacks_mut(), stack => {
            several |= stack.layers().len() > 1;
            stack.flatten();
        });
        if several {
            name_expendable(self);
        }
        Ok(refused)
    }

    /// Brings layers and composites together after edits: what was changed in displacement goes to its active layer,
    /// and composites are computed anew where layers changed. Strokes do it themselves. Returns the tiles that budgets
    /// refused. With one plain layer of each kind there is nothing to do.
    ///
    /// # Errors
    /// Fails with `Invalid` if displacement was edited while its active layer is hidden or its opacity below 1/256;
    /// what was edited is then undone. Fails with `Memory` if the budget of the active layer does not allow the sizes
    /// that the edit gave to faces, and as the page store does if a page cannot be read or written.
    #[inline(never)]
    fn settle(&mut self, context: &Context) -> Result<Vec<u32>> {
        let mut refused = Vec::new();
        if !self.stacks().displacement.is_plain() {
            refused = self.heights_mut().settle(context)?;
        }
        refused.extend(self.settle_colors(context)?);
        refused.sort_unstable();
        refused.dedup();
        Ok(refused)
    }

    /// As [`Self::settle`], of colours alone, whose layers hold what was painted already: to look at a stroke that is
    /// still being made.
    ///
    /// # Errors
    /// Fails as the page store does if a page cannot be read or written.
    #[inline(never)]
    fn settle_colors(&mut self, context: &Context) -> Result<Vec<u32>> {
        with_colors!(self.stacks_mut(), stack => stack.settle(context), Ok(Vec::new()))
    }

    /// Takes away the layers of colour, of which the active one is painted on, see [`Stack::active_mut`].
    ///
    /// # Errors
    /// Fails, and takes nothing, with `Invalid` if there are no colours, or the active layer is hidden or its opacity
    /// below 1/256.
    fn take_paint(&mut self) -> Result<Colors<Self::Paint, Self::HalfPaint>> {
        with_colors!(self.stacks(), stack => stack.check_editable()?, ());
        let colors = self.stacks_mut().colors.take();
        colors.ok_or_else(|| Error::invalid("the object has no colours to paint on").advise("give it some first"))
    }

    /// Puts back what [`Self::take_paint`] took.
    fn put_paint(&mut self, paint: Colors<Self::Paint, Self::HalfPaint>) {
        self.stacks_mut().colors = Some(paint);
    }

    /// Lists the layers of displacement and of colour as they are.
    fn stack_states(&self) -> LayerStates {
        let mut states = Vec::new();
        each_stack!(self.stacks(), stack => states.extend(stack.states()));
        states
    }

    /// All layers as they are, traces and vectors too; [`Self::settle`] is to be done before.
    #[inline(never)]
    fn layer_states(&self) -> LayerStates {
        let mut states = self.stack_states();
        let mut add = |id: u32, name: &str, blocks: Arc<dyn Blocks>| states.push(LayerState::new(id, name, blocks));
        let ([traces, vectors], others) = (self.stacks().others, self.others());
        if let Some(channel) = others.0 {
            add(traces, "traces", Arc::new(channel.field().clone()));
        }
        if let Some(channel) = others.1 {
            add(vectors, "vectors", Arc::new(channel.field().clone()));
        }
        add_stamp_states(self, &mut states);
        states
    }

    /// Adds all layers to `document`; [`Self::settle`] is to be done before.
    ///
    /// # Errors
    /// Fails with `Invalid` if the document is for another mesh, has a layer of the name or number of one of these, or
    /// would get more layers than a document may have; and as the page store does if a block is on a page that cannot
    /// be read. Layers before the one that fails are added.
    #[inline(never)]
    fn store(&self, context: &Context, document: &mut Document) -> Result<()> {
        document.time = self.stacks().time;
        for state in self.layer_states() {
            let tiles = state.blocks.numbers();
            let read = |tile| Ok(state.blocks.try_bytes(tile)?.unwrap_or_default().into_owned());
            document.pack_layer(context, state.head(), &tiles, read)?;
        }
        Ok(())
    }

    /// The displacement of `tile` as caches keep it: of all layers, see [`Stack::read`].
    ///
    /// # Errors
    /// Fails as [`Stack::read`] does.
    fn read_displacement(&self, tile: u32) -> Result<Option<Vec<u8>>> {
        self.stacks().displacement.read(tile)
    }

    /// Puts back what [`Self::read_displacement`] gave; [`Self::settle`] is to follow.
    ///
    /// # Errors
    /// Fails as [`Stack::write`] does.
    fn write_displacement(&mut self, tile: u32, bytes: Option<&[u8]>) -> Result<()> {
        self.heights_mut().write(tile, bytes)
    }

    /// The tiles that have displacement in any layer, ascending.
    fn displaced_tiles(&self) -> Vec<u32> {
        self.stacks().displacement.allocated()
    }

    /// Makes displacement visible to readers. Returns the tiles that changed in it or in one of its layers, ascending.
    fn commit_displacement(&mut self) -> Vec<u32> {
        self.heights_mut().commit()
    }

    /// The colours of `tile` as caches keep them, see [`Stack::read`]; `None` too if the object has no colours at all.
    ///
    /// # Errors
    /// Fails as [`Stack::read`] does.
    fn read_paint(&self, tile: u32) -> Result<Option<Vec<u8>>> {
        with_colors!(self.stacks(), stack => stack.read(tile), Ok(None))
    }

    /// Puts back what [`Self::read_paint`] gave; [`Self::settle`] is to follow.
    ///
    /// # Errors
    /// Fails with `Invalid` if the object has no colours, and as [`Stack::write`].
    fn write_paint(&mut self, tile: u32, bytes: Option<&[u8]>) -> Result<()> {
        with_colors!(self.stacks_mut(), stack => stack.write(tile, bytes), Err(no_colors()))
    }

    /// The tiles that have colours in any layer, ascending.
    fn painted_tiles(&self) -> Vec<u32> {
        with_colors!(self.stacks(), stack => stack.allocated(), Vec::new())
    }

    /// Makes colours visible to readers. Returns the tiles that changed in them or in one of their layers, ascending.
    fn commit_paint(&mut self) -> Vec<u32> {
        with_colors!(self.stacks_mut(), stack => stack.commit(), Vec::new())
    }

    /// The sizes of the faces of the layer `id` as caches keep them, the power of two of each, if edits at other levels
    /// changed any; `None` if not, or there is no such layer.
    fn read_sizes(&self, id: u32) -> Option<Vec<u8>> {
        if let Some(vectors) = self.others().1.filter(|_| id == self.stacks().others[1]) {
            let sizes = || vectors.field().face_sizes().into_iter().map(|size| size.ilog2() as u8).collect();
            return (!vectors.field().given_sizes().is_empty()).then(sizes);
        }
        let state = self.stack_states().into_iter().find(|state| state.id == id)?;
        let sizes = || state.blocks.face_sizes().into_iter().map(|size| size.ilog2() as u8).collect();
        (!state.blocks.given_sizes().is_empty()).then(sizes)
    }

    /// Puts back what [`Self::read_sizes`] gave, before the blocks of the layer; [`Self::settle`] is to follow.
    ///
    /// # Errors
    /// Fails, and changes nothing, with `Invalid` if there is no such layer, a size does not exist or the sizes are not
    /// those of its faces, and as the page store does if a page cannot be read or written.
    fn write_sizes(&mut self, id: u32, sizes: Option<&[u8]>) -> Result<()> {
        if let Some(bits) = sizes.into_iter().flatten().find(|bits| **bits > 8) {
            return Err(Error::invalid(format!("a face cannot have 2^{bits} texels along an edge")));
        }
        let sizes = sizes.map(|sizes| sizes.iter().map(|bits| 1 << bits).collect::<Vec<u32>>());
        if id == self.stacks().others[1]
            && let Some(vectors) = self.others_mut().1
        {
            return reshape(vectors, sizes);
        }
        with_stack_of!(self, id, stack => reshape(stack.channel_mut(id).ok_or_else(|| no_layer(id))?, sizes))
    }

    /// The layers for which [`Self::read_sizes`] gives some, that of vectors too.
    fn sized_layers(&self) -> Vec<u32> {
        let ids = self.layers().into_iter().map(|layer| layer.id);
        let vectors = self.stacks().others[1];
        ids.chain([vectors]).filter(|id| self.read_sizes(*id).is_some()).collect()
    }

    /// The layers for which [`Self::read_sizes`] gives other sizes than when this was called last.
    fn commit_sizes(&mut self) -> Vec<u32> {
        let ids = self.sized_layers();
        let now: Vec<(u32, Vec<u8>)> = ids.into_iter().filter_map(|id| Some((id, self.read_sizes(id)?))).collect();
        let sizes = &mut self.stacks_mut().sizes;
        let before = std::mem::replace(sizes, now);
        let now = &*sizes;
        let both = before
            .iter()
            .filter(|layer| !now.contains(layer))
            .chain(now.iter().filter(|layer| !before.contains(layer)));
        let mut changed: Vec<u32> = both.map(|(id, _)| *id).collect();
        changed.sort_unstable();
        changed.dedup();
        changed
    }

    /// Takes over the layers of `document`, each of which may occupy `budget` bytes. Kinds of which it has none stay as
    /// they are. Returns the names of layers that an object cannot have.
    ///
    /// # Errors
    /// Fails with `Invalid` if the document is for another mesh or a layer is damaged, with `Memory` if the budget is
    /// too small, and as the page store does if a page cannot be read or written; what was taken over by then stays.
    #[inline(never)]
    fn take_up(&mut self, context: &Context, document: &Document, budget: u64) -> Result<Vec<String>> {
        let (mut heights, mut paints, mut halves, mut unknown) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        let mut others = [None; 2];
        for layer in document.layers() {
            if layer.kind() == Kind::Stamps {
                continue;
            }
            match self.stored(context, document, layer, budget)? {
                Some(Stored::Displacement(channel)) => heights.push((layer.head(), channel)),
                // Colours have one format, that of their lowest layer.
                Some(Stored::Paint(channel)) if halves.is_empty() => paints.push((layer.head(), channel)),
                Some(Stored::HalfPaint(channel)) if paints.is_empty() => halves.push((layer.head(), channel)),
                Some(channel @ Stored::Traces(_)) if others[0].is_none() => {
                    others[0] = Some(layer.id());
                    self.set_channel(channel)?;
                }
                Some(channel @ Stored::Vectors(_)) if others[1].is_none() => {
                    others[1] = Some(layer.id());
                    self.set_channel(channel)?;
                }
                _ => unknown.push(layer.name().to_string()),
            }
        }
        // What the document does not have gets numbers that it has not.
        let free = document.free_id().max(ADDED);
        let stay = [heights.is_empty(), paints.is_empty() && halves.is_empty()];
        if let Some((_, first)) = heights.first() {
            self.set_channel(Stored::Displacement(first.clone()))?;
            self.heights_mut().take_up(context, heights)?;
        }
        let behind = with_colors!(self.stacks(), stack => Some(stack.background().color()), None);
        if let Some((_, first)) = paints.first() {
            self.set_channel(Stored::Paint(first.clone()))?;
        }
        if let Some((_, first)) = halves.first() {
            self.set_channel(Stored::HalfPaint(first.clone()))?;
        }
        match &mut self.stacks_mut().colors {
            Some(ByFormat::Rgba8(stack)) if !paints.is_empty() => take_up_colors(context, stack, behind, paints)?,
            Some(ByFormat::Rgba16(stack)) if !halves.is_empty() => take_up_colors(context, stack, behind, halves)?,
            _ => {}
        }
        let layers = self.stacks_mut();
        layers.others = [others[0].unwrap_or(free), others[1].unwrap_or(free + 1)];
        if stay[0] {
            layers.displacement.renumber(free + 2);
        }
        if stay[1] {
            let first = free + 2 + MAX_LAYERS as u32;
            with_colors!(layers, stack => stack.renumber(first), ());
        }
        find_stamps(self, context, document, budget, stay)?;
        Ok(unknown)
    }
}

impl<O: LayeredObject> Recorded for O {
    #[inline(never)]
    fn states(&mut self, context: &Context) -> Result<LayerStates> {
        self.settle(context)?;
        let refused = self.stamp(context)?.len();
        self.stacks_mut().unstamped += refused as u64;
        // What is lost for want of room changes what is seen.
        self.settle(context)?;
        Ok(self.layer_states())
    }

    #[inline(never)]
    fn restore(&mut self, context: &Context, heads: Option<&[Head]>, blocks: Vec<BlockState>) -> Result<()> {
        self.heights_mut();
        each_stack!(self.stacks_mut(), stack => put_layers(context, stack, heads.unwrap_or(&[]), &blocks)?);
        let ids = self.stacks().others;
        let head = |id: u32| heads.into_iter().flatten().find(|head| head.id == id);
        let (traces, vectors) = self.others_mut();
        traces.map_or(Ok(()), |traces| put_whole(context, traces, (ids[0], head(ids[0])), &blocks))?;
        vectors.map_or(Ok(()), |vectors| put_whole(context, vectors, (ids[1], head(ids[1])), &blocks))?;
        put_stamps(self, context, heads, &blocks)
    }
}

/// Gives a stack of colours `layers` that were read, over the colour `behind` if there is one.
fn take_up_colors<C: LayerChannel<Texel: ColorTexel>>(
    context: &Context,
    stack: &mut Stack<C>,
    behind: Option<Vec4>,
    layers: Vec<(&Head, C)>,
) -> Result<()> {
    behind.into_iter().for_each(|color| stack.set_background(C::Texel::of_color(color)));
    stack.take_up(context, layers).map(drop)
}

/// Gives a stack the layers of `heads` that are of its kind, if any, and `blocks`.
#[inline(never)]
fn put_layers<C: LayerChannel>(
    context: &Context,
    stack: &mut Stack<C>,
    heads: &[Head],
    blocks: &[BlockState],
) -> Result<()> {
    let is_own = |kind: Kind| kind == C::Texel::KIND || kind.is_color() && C::Texel::KIND.is_color();
    let heads: Vec<&Head> = heads.iter().filter(|head| is_own(head.kind)).collect();
    if !heads.is_empty() {
        stack.arrange(&heads)?;
    }
    let ids: Vec<u32> = stack.layers().iter().map(|layer| layer.id()).collect();
    for id in ids {
        if let Some(channel) = stack.channel_mut(id) {
            put(context, channel, id, blocks)?;
        }
    }
    if heads.is_empty() { stack.settle(context) } else { stack.refresh(context) }.map(drop)
}

/// Gives the faces of a layer `sizes`, or those they were given.
fn reshape(channel: &mut impl BlockChannel, sizes: Option<Vec<u32>>) -> Result<()> {
    let field = channel.field();
    let given = field.given_sizes();
    let given = if given.is_empty() { field.face_sizes() } else { given };
    channel.reshape(sizes.as_ref().unwrap_or(&given), &given)
}

/// Gives a channel that is a layer of its own the sizes of `head`, unless they stay, and its blocks.
fn put_whole(
    context: &Context,
    channel: &mut impl BlockChannel,
    (layer, head): (u32, Option<&Head>),
    blocks: &[BlockState],
) -> Result<()> {
    if let Some(head) = head {
        channel.reshape(&head.face_sizes, &head.given_sizes)?;
    }
    put(context, channel, layer, blocks)
}

/// Puts back the blocks of `layer`, whatever the budget says: blocks that go first, so that others have room.
#[inline(never)]
fn put(context: &Context, channel: &mut impl BlockChannel, layer: u32, blocks: &[BlockState]) -> Result<()> {
    let budget = channel.budget();
    channel.set_budget(u64::MAX);
    let own = || blocks.iter().filter(|block| block.layer == layer);
    let done = own().try_for_each(|block| channel.write(block.block, block.bytes.as_deref()));
    channel.set_budget(budget);
    done?;
    let numbers: Vec<u32> = own().map(|block| block.block).collect();
    channel.mend(context, &numbers)
}

impl LayeredObject for DisplacedObject {
    type Displacement = Displacement;
    type Paint = Paint;
    type HalfPaint = Paint<Rgba16>;
    type Traces = Traces;
    type Vectors = VectorDisplacement;

    fn device_in_use(&self) -> Option<&Device> {
        self.device.as_ref().map(DeviceObject::device)
    }

    fn lose_device(&mut self, fault: Error) {
        (self.device, self.device_fault) = (None, Some(fault));
    }

    fn stacks(&self) -> &Layers {
        &self.layers
    }

    fn stacks_mut(&mut self) -> &mut Layers {
        &mut self.layers
    }

    fn heights_mut(&mut self) -> &mut Stack<Displacement> {
        self.displacement_mut();
        &mut self.layers.displacement
    }

    fn others(&self) -> (Option<&Traces>, Option<&VectorDisplacement>) {
        (self.traces(), self.vectors())
    }

    fn others_mut(&mut self) -> (Option<&mut Traces>, Option<&mut VectorDisplacement>) {
        self.vectors_mut();
        (self.traces.as_mut(), self.vectors.as_mut())
    }

    fn stored(
        &self,
        context: &Context,
        document: &Document,
        layer: &document::Layer,
        budget: u64,
    ) -> Result<Option<Stored<Self>>> {
        let (topology, name, pages) = (self.surface().topology().clone(), layer.name(), self.page_store());
        Ok(match layer.kind() {
            Kind::Scalar => {
                Channel::stored_with(context, topology, document, name, budget, pages)?.map(Stored::Displacement)
            }
            Kind::Rgba8 => Channel::stored_with(context, topology, document, name, budget, pages)?.map(Stored::Paint),
            Kind::Trace => Channel::stored_with(context, topology, document, name, budget, pages)?.map(Stored::Traces),
            Kind::Vector => {
                let surface = self.surface();
                VectorDisplacement::stored_on(context, surface, document, name, budget, pages)?.map(Stored::Vectors)
            }
            Kind::Rgba16 => {
                Channel::stored_with(context, topology, document, name, budget, pages)?.map(Stored::HalfPaint)
            }
            Kind::Stamps => None,
        })
    }

    fn set_channel(&mut self, channel: Stored<Self>) -> Result<()> {
        match channel {
            Stored::Displacement(displacement) => *self.displacement_mut() = displacement,
            Stored::Paint(paint) => self.set_paint(paint)?,
            Stored::HalfPaint(paint) => self.set_half_paint(paint)?,
            Stored::Traces(traces) => self.set_traces(traces)?,
            Stored::Vectors(vectors) => self.set_vectors(vectors)?,
        }
        Ok(())
    }
}
