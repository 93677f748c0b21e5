//! The layers of an object: stacks of displacement and of colour, and how they are recorded and kept in documents.

use std::sync::Arc;

use half::f16;
use relievo_core::{Context, Error, Result};
use relievo_document::{Document, Head, Kind, MAX_LAYERS, Settings};
use relievo_tiles::{Blocks, Channel, Displacement, Paint, Rgba8, StoredTexel, Texel, Traces, VectorDisplacement};

use crate::history::{BlockState, LayerState, LayerStates, Recorded};
use crate::layers::{Absorb, Stack};
use crate::object::DisplacedObject;

/// The numbers of the layers that every object may have.
const DISPLACEMENT: u32 = 0;
const COLOUR: u32 = 1;
const TRACES: u32 = 2;
const VECTORS: u32 = 3;
/// The first number of those that are added.
const ADDED: u32 = 16;

/// The stacks of an object.
#[derive(Debug)]
pub struct Layers {
    /// Those of displacement.
    pub(crate) displacement: Stack<f16>,
    /// Those of colour, if it has colours.
    pub(crate) colors: Option<Stack<Rgba8>>,
    /// The numbers of its traces and of its vectors.
    others: [u32; 2],
}

impl Default for Layers {
    fn default() -> Self {
        Self {
            displacement: Stack::new(DISPLACEMENT, "displacement", f16::ZERO),
            colors: None,
            others: [TRACES, VECTORS],
        }
    }
}

/// One layer of colour.
pub(crate) fn colors(paint: &Paint) -> Stack<Rgba8> {
    Stack::new(COLOUR, "colour", paint.field().blank())
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

impl DisplacedObject {
    /// The layers, from the lowest: those of displacement, then those of colour. What is evaluated is
    /// [`Self::displacement`] and [`Self::paint`], to which they come.
    pub fn layers(&self) -> Vec<LayerInfo> {
        let info = |state: LayerState, active: u32| LayerInfo {
            id: state.id,
            name: state.name.to_string(),
            kind: state.blocks.kind(),
            settings: state.settings,
            active: state.id == active,
            tiles: state.blocks.numbers().len(),
        };
        let stack = &self.layers.displacement;
        let heights = stack.states(&self.displacement).into_iter().map(|state| info(state, stack.active()));
        let colors = self.layers.colors.iter().zip(&self.paint).flat_map(|(stack, paint)| {
            stack.states(paint).into_iter().map(|state| info(state, stack.active())).collect::<Vec<_>>()
        });
        heights.chain(colors).collect()
    }

    /// The number of the layer called `name`.
    pub fn layer(&self, name: &str) -> Option<u32> {
        self.layers().into_iter().find(|layer| layer.name == name).map(|layer| layer.id)
    }

    /// Adds a layer of displacement ([`Kind::Scalar`]) or colour ([`Kind::Rgba8`]) above those of its kind, with `size`
    /// texels along an edge of every face; edits of its kind go to it. Returns its number and the tiles that the budget
    /// refused to the composite.
    ///
    /// Fails if the name is taken or none, the settings are not for its kind, there is no such size, the object has no
    /// colours, or its edits fade.
    pub fn add_layer(
        &mut self,
        context: &Context,
        kind: Kind,
        name: &str,
        settings: Settings,
        size: u32,
    ) -> Result<(u32, Vec<u32>)> {
        self.check_name(name)?;
        if self.fading().is_some() {
            return Err(Error::unsupported("edits that fade are on one layer")
                .at(format!("layer `{name}`"))
                .advise("leave out the layers or the decay"));
        }
        self.settle(context)?;
        let others = self.layers.others;
        let used = self.layers().into_iter().map(|layer| layer.id).chain(others).map(|id| id + 1).max().unwrap_or(0);
        if self.layers().len() >= MAX_LAYERS {
            return Err(Error::invalid(format!("an object has at most {MAX_LAYERS} layers")));
        }
        let (id, faces) = (used.max(ADDED), vec![size; self.surface().topology().face_count()]);
        let head = (id, name, settings);
        let refused = match kind {
            Kind::Scalar => self.edit_heights(|stack, composite| stack.add(context, composite, head, &faces)),
            Kind::Rgba8 => self.edit_colors(|stack, composite| stack.add(context, composite, head, &faces)),
            _ => Err(Error::unsupported(format!("layers cannot hold {}", kind.name()))
                .advise("add layers of scalar displacement or 8-bit colour")),
        };
        Ok((id, refused.map_err(|error| error.at(format!("layer `{name}`")))?))
    }

    fn check_name(&self, name: &str) -> Result<()> {
        let place = || format!("layer `{name}`");
        if name.is_empty() || name.len() > usize::from(u8::MAX) || name.contains(char::is_control) {
            return Err(Error::invalid("the name of a layer is 1 to 255 bytes of text").at(place()));
        }
        if self.layer(name).is_some() || ["traces", "vectors"].contains(&name) {
            return Err(Error::invalid("there is a layer of that name").at(place()).advise("name it otherwise"));
        }
        Ok(())
    }

    fn edit_heights(
        &mut self,
        edit: impl FnOnce(&mut Stack<f16>, &mut Displacement) -> Result<Vec<u32>>,
    ) -> Result<Vec<u32>> {
        let mut stack = std::mem::take(&mut self.layers);
        let done = edit(&mut stack.displacement, self.displacement_mut());
        self.layers = stack;
        done
    }

    fn edit_colors(
        &mut self,
        edit: impl FnOnce(&mut Stack<Rgba8>, &mut Paint) -> Result<Vec<u32>>,
    ) -> Result<Vec<u32>> {
        match (&mut self.layers.colors, &mut self.paint) {
            (Some(stack), Some(paint)) => edit(stack, paint),
            _ => Err(Error::invalid("the object has no colours").advise("give it some first")),
        }
    }

    /// Does the same for whichever kind the layer `id` is of.
    fn edit_either(
        &mut self,
        context: &Context,
        id: u32,
        heights: impl FnOnce(&mut Stack<f16>, &mut Displacement) -> Result<Vec<u32>>,
        colors: impl FnOnce(&mut Stack<Rgba8>, &mut Paint) -> Result<Vec<u32>>,
    ) -> Result<Vec<u32>> {
        self.settle(context)?;
        let in_colors =
            self.layers.colors.as_ref().is_some_and(|stack| stack.layers().iter().any(|layer| layer.id() == id));
        if in_colors { self.edit_colors(colors) } else { self.edit_heights(heights) }
    }

    /// Makes `id` the layer that edits of its kind go to. Fails if there is no such layer.
    pub fn set_active_layer(&mut self, context: &Context, id: u32) -> Result<()> {
        let none = |set: Result<()>| set.map(|()| Vec::new());
        self.edit_either(context, id, |stack, _| none(stack.set_active(id)), |stack, _| none(stack.set_active(id)))
            .map(drop)
    }

    /// Names a layer. Fails if there is no such layer, or the name is taken or none.
    pub fn rename_layer(&mut self, id: u32, name: &str) -> Result<()> {
        let there = self.layers().into_iter().find(|layer| layer.id == id);
        let there = there.ok_or_else(|| Error::invalid(format!("there is no layer with the number {id}")))?;
        if there.name != name {
            self.check_name(name)?;
            self.layers.displacement.rename(id, name);
            self.layers.colors.iter_mut().for_each(|stack| stack.rename(id, name));
        }
        Ok(())
    }

    /// Changes how a layer is seen. Returns the tiles that the budget refused to the composite. Fails if there is no such
    /// layer or its kind cannot be seen so.
    pub fn set_layer(&mut self, context: &Context, id: u32, to: Settings) -> Result<Vec<u32>> {
        self.edit_either(
            context,
            id,
            |stack, composite| stack.set(context, composite, id, to),
            |stack, composite| stack.set(context, composite, id, to),
        )
    }

    /// Puts a layer at a place among those of its kind, counted from the lowest. As [`Self::set_layer`] otherwise.
    pub fn place_layer(&mut self, context: &Context, id: u32, place: usize) -> Result<Vec<u32>> {
        self.edit_either(
            context,
            id,
            |stack, composite| stack.place(context, composite, id, place),
            |stack, composite| stack.place(context, composite, id, place),
        )
    }

    /// Removes a layer with all that is on it. Fails if there is no such layer, or it is the last of its kind.
    pub fn remove_layer(&mut self, context: &Context, id: u32) -> Result<Vec<u32>> {
        self.edit_either(
            context,
            id,
            |stack, composite| stack.remove(context, composite, id),
            |stack, composite| stack.remove(context, composite, id),
        )
    }

    /// Puts a layer and the one below it into one that looks as both did, but for rounding; it has the number and the
    /// name of the lower one. Fails, and changes nothing, where no one layer would look so, or one of them is hidden.
    pub fn merge_layer(&mut self, context: &Context, id: u32) -> Result<Vec<u32>> {
        self.edit_either(
            context,
            id,
            |stack, composite| stack.merge_down(context, composite, id),
            |stack, composite| stack.merge_down(context, composite, id),
        )
    }

    /// Makes one layer of displacement and one of colour of all: what is seen, to the bit.
    pub fn flatten_layers(&mut self, context: &Context) -> Result<Vec<u32>> {
        let refused = self.settle(context)?;
        self.layers.displacement.flatten();
        self.layers.colors.iter_mut().for_each(Stack::flatten);
        Ok(refused)
    }

    /// Brings layers and composites together after edits: what was changed in displacement goes to its active layer, and
    /// composites are computed anew where layers changed. Strokes do it themselves. Returns the tiles that budgets
    /// refused. With one plain layer of each kind there is nothing to do.
    ///
    /// Fails if the active layer cannot be seen; what was edited is then undone.
    pub fn settle(&mut self, context: &Context) -> Result<Vec<u32>> {
        let mut refused = Vec::new();
        if !self.layers.displacement.is_plain() {
            refused = self.edit_heights(|stack, composite| stack.settle(context, composite))?;
        }
        refused.extend(self.settle_colors(context)?);
        refused.sort_unstable();
        refused.dedup();
        Ok(refused)
    }

    /// As [`Self::settle`], of colours alone, whose layers hold what was painted already: to look at a stroke that is
    /// still being made.
    pub fn settle_colors(&mut self, context: &Context) -> Result<Vec<u32>> {
        match (&mut self.layers.colors, &mut self.paint) {
            (Some(stack), Some(paint)) => stack.settle(context, paint),
            _ => Ok(Vec::new()),
        }
    }

    /// Takes away what is painted on: the active layer. Fails if there are no colours, or it cannot be seen.
    pub(crate) fn take_paint(&mut self) -> Result<Paint> {
        if let Some(stack) = &mut self.layers.colors {
            stack.check_editable()?;
            if let Some(active) = stack.take_active() {
                return Ok(active);
            }
        }
        self.paint
            .take()
            .ok_or_else(|| Error::invalid("the object has no colours to paint on").advise("give it some first"))
    }

    /// Puts back what [`Self::take_paint`] took.
    pub(crate) fn put_paint(&mut self, paint: Paint) {
        match &mut self.layers.colors {
            Some(stack) if !stack.is_plain() => stack.put_active(paint),
            _ => self.paint = Some(paint),
        }
    }

    /// All layers as they are, traces and vectors too; [`Self::settle`] is to be done before.
    pub fn layer_states(&self) -> LayerStates {
        let mut states = self.layers.displacement.states(&self.displacement);
        if let (Some(stack), Some(paint)) = (&self.layers.colors, &self.paint) {
            states.extend(stack.states(paint));
        }
        let mut add = |id: u32, name: &str, blocks: Arc<dyn Blocks>| {
            states.push(LayerState { id, name: name.into(), settings: Settings::of(blocks.kind()), blocks });
        };
        let [traces, vectors] = self.layers.others;
        if let Some(channel) = self.traces() {
            add(traces, "traces", Arc::new(channel.field().clone()));
        }
        if let Some(channel) = self.vectors() {
            add(vectors, "vectors", Arc::new(channel.field().clone()));
        }
        states
    }

    /// Adds all layers to `document`; [`Self::settle`] is to be done before. Fails if it is for another mesh or has
    /// layers.
    pub fn store(&self, context: &Context, document: &mut Document) -> Result<()> {
        for state in self.layer_states() {
            let tiles = state.blocks.numbers();
            let read = |tile| Ok(state.blocks.bytes(tile).unwrap_or_default().to_vec());
            document.pack_layer(context, state.head(), &tiles, read)?;
        }
        Ok(())
    }

    /// The displacement of `tile` as caches keep it: of all layers, see [`Stack::read`].
    pub fn read_displacement(&self, tile: u32) -> Result<Option<Vec<u8>>> {
        self.layers.displacement.read(&self.displacement, tile)
    }

    /// Puts back what [`Self::read_displacement`] gave; [`Self::settle`] is to follow.
    pub fn write_displacement(&mut self, tile: u32, bytes: Option<&[u8]>) -> Result<()> {
        self.edit_heights(|stack, composite| stack.write(composite, tile, bytes).map(|()| Vec::new())).map(drop)
    }

    /// The tiles that have displacement in any layer, ascending.
    pub fn displaced_tiles(&self) -> Vec<u32> {
        self.layers.displacement.allocated(&self.displacement)
    }

    /// Makes displacement visible to readers. Returns the tiles that changed in it or in one of its layers, ascending.
    pub fn commit_displacement(&mut self) -> Vec<u32> {
        // Reached for writing, so that its reach is measured anew.
        let displacement = self.displacement_mut().commit();
        let mut tiles = self.layers.displacement.commit(&mut self.displacement);
        tiles.extend(displacement.changed());
        tiles.sort_unstable();
        tiles.dedup();
        tiles
    }

    /// The colours of `tile` as caches keep them, see [`Stack::read`]; `None` too if there are none at all.
    pub fn read_paint(&self, tile: u32) -> Result<Option<Vec<u8>>> {
        match (&self.layers.colors, &self.paint) {
            (Some(stack), Some(paint)) => stack.read(paint, tile),
            _ => Ok(None),
        }
    }

    /// Puts back what [`Self::read_paint`] gave; [`Self::settle`] is to follow. Fails too if the object has no colours.
    pub fn write_paint(&mut self, tile: u32, bytes: Option<&[u8]>) -> Result<()> {
        self.edit_colors(|stack, composite| stack.write(composite, tile, bytes).map(|()| Vec::new())).map(drop)
    }

    /// The tiles that have colours in any layer, ascending.
    pub fn painted_tiles(&self) -> Vec<u32> {
        match (&self.layers.colors, &self.paint) {
            (Some(stack), Some(paint)) => stack.allocated(paint),
            _ => Vec::new(),
        }
    }

    /// Makes colours visible to readers. Returns the tiles that changed in them or in one of their layers, ascending.
    pub fn commit_paint(&mut self) -> Vec<u32> {
        match (&mut self.layers.colors, &mut self.paint) {
            (Some(stack), Some(paint)) => stack.commit(paint),
            _ => Vec::new(),
        }
    }

    /// Takes over the layers of `document`, each of which may occupy `budget` bytes. Kinds of which it has none stay as
    /// they are. Returns the names of layers that an object cannot have.
    ///
    /// Fails if the document is for another mesh, a layer is damaged, or the budget is too small.
    pub fn take_up(&mut self, context: &Context, document: &Document, budget: u64) -> Result<Vec<String>> {
        let (mut heights, mut paints, mut unknown) = (Vec::new(), Vec::new(), Vec::new());
        let topology = self.surface().topology().clone();
        let mut others = [None; 2];
        for layer in document.layers() {
            let (name, is) = (layer.name(), |kind| layer.kind() == kind);
            if is(Kind::Scalar) {
                heights.extend(
                    Channel::stored(context, topology.clone(), document, name, budget)?.map(|c| (layer.head(), c)),
                );
            } else if is(Kind::Rgba8) {
                paints.extend(
                    Channel::stored(context, topology.clone(), document, name, budget)?.map(|c| (layer.head(), c)),
                );
            } else if is(Traces::kind()) && others[0].is_none() {
                others[0] = Some(layer.id());
                if let Some(traces) = Traces::stored(context, topology.clone(), document, name, budget)? {
                    self.set_traces(traces)?;
                }
            } else if is(VectorDisplacement::kind()) && others[1].is_none() {
                others[1] = Some(layer.id());
                let surface = self.surface();
                if let Some(vectors) = VectorDisplacement::stored_on(context, surface, document, name, budget)? {
                    self.set_vectors(vectors)?;
                }
            } else {
                unknown.push(name.to_string());
            }
        }
        // What the document does not have gets numbers that it has not.
        let free = document.free_id().max(ADDED);
        let kept = (heights.is_empty(), paints.is_empty());
        if let Some((_, first)) = heights.first() {
            *self.displacement_mut() = first.clone();
            self.edit_heights(|stack, composite| stack.take_up(context, composite, heights))?;
        }
        if let Some((_, first)) = paints.first() {
            let before = self.layers.colors.take();
            self.set_paint(first.clone())?;
            self.layers.colors = before.or(self.layers.colors.take());
            self.edit_colors(|stack, composite| stack.take_up(context, composite, paints))?;
        }
        self.layers.others = [others[0].unwrap_or(free), others[1].unwrap_or(free + 1)];
        if kept.0 {
            self.layers.displacement.renumber(free + 2);
        }
        if let (true, Some(stack)) = (kept.1, &mut self.layers.colors) {
            stack.renumber(free + 2 + MAX_LAYERS as u32);
        }
        Ok(unknown)
    }
}

impl Recorded for DisplacedObject {
    fn states(&mut self, context: &Context) -> Result<LayerStates> {
        self.settle(context)?;
        Ok(self.layer_states())
    }

    fn restore(&mut self, context: &Context, heads: Option<&[Head]>, blocks: Vec<BlockState>) -> Result<()> {
        let of_kind = |kind: Kind| heads.into_iter().flatten().filter(|head| head.kind == kind).collect::<Vec<_>>();
        let whole = heads.is_some();
        let (heights, colors) = (of_kind(Kind::Scalar), of_kind(Kind::Rgba8));
        self.edit_heights(|stack, composite| {
            put_layers(context, stack, composite, whole.then_some(&heights), &blocks)
        })?;
        if self.paint.is_some() {
            let heads = whole.then_some(colors.as_slice());
            self.edit_colors(|stack, composite| put_layers(context, stack, composite, heads, &blocks))?;
        }
        let others = self.layers.others;
        if let Some(traces) = self.traces_mut() {
            put(traces, others[0], &blocks)?;
        }
        if let Some(vectors) = self.vectors_mut() {
            put(vectors, others[1], &blocks)?;
        }
        Ok(())
    }
}

/// Gives a stack the layers `heads`, unless they stay, and `blocks`.
fn put_layers<T: Absorb>(
    context: &Context,
    stack: &mut Stack<T>,
    composite: &mut Channel<T>,
    heads: Option<&[&Head]>,
    blocks: &[BlockState],
) -> Result<Vec<u32>> {
    if let Some(heads) = heads {
        stack.arrange(composite, heads)?;
    }
    let ids: Vec<u32> = stack.layers().iter().map(|layer| layer.id()).collect();
    for id in ids {
        if let Some(channel) = stack.channel_mut(id, composite) {
            put(channel, id, blocks)?;
        }
    }
    if heads.is_some() { stack.refresh(context, composite) } else { stack.settle(context, composite) }
}

/// Puts back the blocks of `layer`, whatever the budget says: those that go first, so that others have room.
fn put<T: Texel>(channel: &mut Channel<T>, layer: u32, blocks: &[BlockState]) -> Result<()> {
    let budget = channel.budget();
    channel.set_budget(u64::MAX);
    let mut own = blocks.iter().filter(|block| block.layer == layer);
    let done = own.try_for_each(|block| channel.write(block.block, block.bytes.as_deref()));
    channel.set_budget(budget);
    done
}

/// What documents call the texels of a channel.
trait Kinded {
    fn kind() -> Kind;
}

impl<T: StoredTexel> Kinded for Channel<T> {
    fn kind() -> Kind {
        T::KIND
    }
}
