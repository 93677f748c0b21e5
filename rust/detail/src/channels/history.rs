//! Undo, redo and the journal of an object: every edit is kept as what it changed, block by block.
//!
//! Which blocks an edit changed is found by comparing the fields of the object before and after, so that strokes,
//! imprints and whatever else writes tiles are recorded alike. What an edit costs is what it changed, see
//! [`relievo_document::edit`]. Edits stay in memory up to a budget; beyond it the oldest are read back from the
//! journal of the document, or from a temporary file where there is no document. Units: bytes.

use std::borrow::Cow;
use std::path::Path;
use std::sync::Arc;

use relievo_core::budget::Budget;
use relievo_core::{Context, Error, Result};
use relievo_document::record::Location;
use relievo_document::{
    Block, Change, Direction, Document, Edit, Entry, Head, Journal, Layer, Log, Recipe, Settings, Stamps, Storage,
    recipe,
};
use relievo_tiles::Blocks;

/// A layer at one moment.
#[derive(Clone, Debug)]
pub struct LayerState {
    /// Its number, which it keeps.
    pub id: u32,
    /// Its name.
    pub name: Arc<str>,
    /// How it takes part in what is seen.
    pub settings: Settings,
    /// Its blocks.
    pub blocks: Arc<dyn Blocks>,
    /// The texel that is seen behind all layers of its kind, if it is the lowest and documents hold that; else none.
    pub behind: Vec<u8>,
    /// What its times belong to, if it is one of stamps.
    pub stamps: Option<Stamps>,
    /// Whether its blocks change with time, without edits.
    pub fades: bool,
}

impl LayerState {
    /// A layer that is seen as a whole, in the mode of its kind, and does not fade.
    pub fn new(id: u32, name: &str, blocks: Arc<dyn Blocks>) -> Self {
        let settings = Settings::of(blocks.kind());
        Self { id, name: name.into(), settings, blocks, behind: Vec::new(), stamps: None, fades: false }
    }

    /// What documents say of it.
    pub fn head(&self) -> Head {
        let blocks = &self.blocks;
        Head {
            settings: self.settings,
            given_sizes: blocks.given_sizes(),
            behind: self.behind.clone(),
            stamps: self.stamps,
            ..Head::new(self.id, &self.name, blocks.kind(), blocks.blank(), blocks.face_sizes())
        }
    }

    fn is_headed_as(&self, other: &Self) -> bool {
        (self.id, &self.name, self.settings) == (other.id, &other.name, other.settings)
            && (&self.behind, self.stamps) == (&other.behind, other.stamps)
            && self.blocks.is_shaped_as(&*other.blocks)
    }
}

/// All layers of an object at one moment, from the lowest to the highest.
pub type LayerStates = Vec<LayerState>;

/// A block to be put back: the number of its layer, its own, and its bytes if it is to be there.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BlockState {
    /// The number of its layer.
    pub layer: u32,
    /// Its number.
    pub block: u32,
    /// Its bytes, if it is there.
    pub bytes: Option<Vec<u8>>,
}

/// What a history records.
pub trait Recorded {
    /// All that edits change, as it is now.
    ///
    /// # Errors
    /// Objects with layers fail as [`LayeredObject::settle`](crate::LayeredObject::settle) and
    /// [`DecayingObject::stamp`](crate::DecayingObject::stamp) do.
    fn states(&mut self, context: &Context) -> Result<LayerStates>;

    /// Gives it the layers `heads`, unless they stay, and then `blocks`; all others stay. Budgets do not count: what is
    /// put back was there before.
    ///
    /// # Errors
    /// Fails with `Invalid` if a head or a block does not fit the object, with `Memory` if a budget does not hold the
    /// stamps that every channel needs, and as the page store does if a page cannot be read or written; what was put
    /// back by then stays.
    fn restore(&mut self, context: &Context, heads: Option<&[Head]>, blocks: Vec<BlockState>) -> Result<()>;
}

/// Bytes that are in memory, in a file, or both.
#[derive(Debug)]
struct Kept {
    bytes: Option<Vec<u8>>,
    /// Where it is in the journal, or in the temporary file of a history without one.
    place: Option<Location>,
}

/// An edit that can be undone or made again.
#[derive(Debug)]
struct Step {
    input: Kept,
    edit: Kept,
    /// Its number in the journal.
    sequence: u64,
    /// What was changed without the history of layers that the edit changes too, in the states before and after it.
    strays: [Vec<Stray>; 2],
}

/// How a layer was seen and what it was called where an edit found it otherwise than it left it.
#[derive(Clone, Debug)]
struct Stray {
    layer: u32,
    settings: Settings,
    name: String,
}

impl Stray {
    fn of(head: &Head) -> Self {
        Self { layer: head.id, settings: head.settings, name: head.name.clone() }
    }
}

/// The layers after `edit` goes in `direction` from `now`, if it changes them, and what of the layers it changes was changed
/// without the history. Settings and names that the edit does not change stay as they are now; the ones that it changes
/// become what `known` says of their state, or else what the edit says.
fn merged(edit: &Edit, direction: Direction, now: &[Head], known: &[Stray]) -> Option<(Vec<Head>, Vec<Stray>)> {
    let mut heads = edit.layers_after(direction, now)?;
    let from = edit.layers().map_or(&[][..], |layers| &layers[direction as usize]);
    let mut strays = Vec::new();
    for before in from {
        let Some(current) = now.iter().find(|head| head.id == before.id) else { continue };
        let after = heads.iter_mut().find(|head| head.id == before.id);
        let is_settled =
            after.as_ref().is_some_and(|after| after.settings == before.settings && after.name == before.name);
        if !is_settled && (current.settings != before.settings || current.name != before.name) {
            strays.push(Stray::of(current));
        }
        let Some(after) = after else { continue };
        if after.settings == before.settings {
            after.settings = current.settings;
        }
        if after.name == before.name {
            after.name.clone_from(&current.name);
        }
    }
    for stray in known {
        if let Some(head) = heads.iter_mut().find(|head| head.id == stray.layer) {
            head.settings = stray.settings;
            head.name.clone_from(&stray.name);
        }
    }
    Some((heads, strays))
}

/// An edit that is being made.
#[derive(Debug)]
struct Open {
    before: LayerStates,
    recipes: Vec<Recipe>,
    input: String,
    place: Option<Location>,
}

/// What an edit, or its undoing, changed.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Changed {
    /// What the edit was.
    pub input: String,
    /// The layers whose blocks changed, by number, and those blocks, ascending.
    pub blocks: Vec<(u32, Vec<u32>)>,
    /// Whether layers were added, removed or changed as a whole.
    pub layers: bool,
    /// The recipes that changed, by number, ascending.
    pub recipes: Vec<u32>,
    /// Bytes of the record.
    pub bytes: u64,
}

/// A journal of all edits, and where the input and the edit of each are in it, with its number.
type Written = (Journal, Vec<(Location, (Location, u64))>);

/// The edits of an object. See the [module](self).
#[derive(Debug)]
pub struct History {
    done: Vec<Step>,
    undone: Vec<Step>,
    memory: u64,
    used: u64,
    /// Edits before this one are not in memory.
    first: usize,
    journal: Option<Journal>,
    /// Where edits go that memory has no room for, if there is no journal.
    spill: Option<Journal>,
    open: Option<Open>,
    /// The layers that the journal has, while it is not known whether the object has the same.
    known: Option<Vec<Head>>,
    /// The numbers of the layers that the journal has, once that is known.
    told: Vec<u32>,
    /// Those of them that the object cannot have.
    foreign: Vec<Head>,
    /// What things on the layers were made of, ascending by number.
    recipes: Vec<Recipe>,
}

impl History {
    /// A history without edits, which may occupy `memory` bytes.
    pub fn new(memory: u64) -> Self {
        Self {
            done: Vec::new(),
            undone: Vec::new(),
            memory,
            used: 0,
            first: 0,
            journal: None,
            spill: None,
            open: None,
            known: None,
            told: Vec::new(),
            foreign: Vec::new(),
            recipes: Vec::new(),
        }
    }

    /// Opens the document at `path`, which may occupy `limit` bytes with what is made of it, to go on working on it:
    /// its edits can be undone, new ones go to its journal. Notes of the document say what was under way when it was
    /// left.
    ///
    /// # Errors
    /// Fails with `NotFound` or `Io` if the file does not exist or cannot be opened, read or written, with `Busy` if
    /// another program works on it, with `Invalid` if it is no file or no document or is damaged, with `Unsupported` if
    /// its format is newer than this build, and with `Memory` if it needs more than `limit`.
    pub fn open(path: &Path, limit: u64, memory: u64) -> Result<(Document, Self)> {
        Ok(Self::opened(Journal::open(path, limit)?, memory))
    }

    /// Opens the document in `storage`, as [`Self::open`] does with a file.
    ///
    /// # Errors
    /// It is damaged, or the storage cannot be read or written.
    pub fn open_in(storage: Box<dyn Storage>, limit: u64, memory: u64) -> Result<(Document, Self)> {
        Ok(Self::opened(Journal::open_in(storage, limit)?, memory))
    }

    fn opened((document, log, journal): (Document, Log, Journal), memory: u64) -> (Document, Self) {
        let step = |entry: &Entry| Step {
            input: Kept { bytes: entry.input.is_none().then(Vec::new), place: entry.input },
            edit: Kept { bytes: None, place: Some(entry.edit) },
            sequence: entry.sequence,
            strays: Default::default(),
        };
        let mut history = Self::new(memory);
        history.done = log.done.iter().map(step).collect();
        history.undone = log.undone.iter().map(step).collect();
        history.first = history.done.len();
        history.journal = Some(journal);
        history.known = Some(heads(&document));
        history.recipes = document.recipes().to_vec();
        (document, history)
    }

    /// Writes `document`, the object in its present state, to `path` with all its edits and recipes, and journals to it
    /// from now on. Where it does already, nothing but [`Self::sync`] is left to do.
    ///
    /// # Errors
    /// Fails, and journals on to where it did, with `Invalid` if an edit is under way, `path` is not a file, the input
    /// of an edit has more than 16 MiB or another program changed the journal; with `Busy` if another program works on
    /// the file; with `NotFound` or `Io` if it cannot be written or edits cannot be read back; and with `Memory` if the
    /// system has no memory for one of them. A file that was at `path` may have been replaced by then.
    pub fn save(&mut self, path: &Path, document: &Document) -> Result<()> {
        if self.path() == Some(path) && self.open.is_none() {
            return self.sync();
        }
        let written = self.written(document, |document| Journal::create(path, document))?;
        self.go_on(written, document);
        Ok(())
    }

    /// As [`Self::save`], to `storage`.
    ///
    /// # Errors
    /// The storage cannot be written; edits then go to where they went.
    pub fn save_in(&mut self, storage: Box<dyn Storage>, document: &Document) -> Result<()> {
        let written = self.written(document, |document| Journal::create_in(storage, document))?;
        self.go_on(written, document);
        Ok(())
    }

    /// The bytes of a file that [`Self::save`] would write. Edits go on to where they went.
    ///
    /// # Errors
    /// An edit is under way, or the system has no memory for them.
    pub fn to_bytes(&mut self, document: &Document) -> Result<Vec<u8>> {
        let blocks = document.layers().iter().flat_map(Layer::blocks);
        let mut bytes = Vec::new();
        let room = bytes.try_reserve(blocks.map(Block::packed_bytes).sum());
        room.map_err(|_| Error::memory("the system has no memory for the document"))?;
        let memory = Box::new(std::io::Cursor::new(bytes));
        self.written(document, |document| Journal::create_in(memory, document))?.0.into_bytes()
    }

    /// A journal that `create` makes of `document`, with all edits and recipes, and where they are in it.
    fn written(&mut self, document: &Document, create: impl FnOnce(&Document) -> Result<Journal>) -> Result<Written> {
        if self.open.is_some() {
            return Err(Error::invalid("an edit is under way").advise("end it first"));
        }
        let mut journal = if document.recipes() == self.recipes {
            create(document)?
        } else {
            let mut document = document.clone();
            let changes = recipe::difference(document.recipes(), &self.recipes);
            changes.into_iter().try_for_each(|change| {
                let [_, after] = change.states;
                document.put_recipe(change.id, after)
            })?;
            create(&document)?
        };
        let lists = [&self.done, &self.undone].map(Vec::len);
        let mut edits = Vec::with_capacity(lists[0] + lists[1]);
        for index in 0..lists[0] + lists[1] {
            let (input, payload) = (self.text(index)?, self.payload(index)?);
            let input = journal.input(&input)?;
            edits.push((input, journal.carry(&payload, index < lists[0])?));
        }
        Ok((journal, edits))
    }

    /// Journals to what was written of `document` from now on.
    fn go_on(&mut self, (journal, edits): Written, document: &Document) {
        for (step, (input, (edit, sequence))) in self.done.iter_mut().chain(&mut self.undone).zip(edits) {
            (step.input.place, step.edit.place, step.sequence) = (Some(input), Some(edit), sequence);
        }
        self.journal = Some(journal);
        self.known = Some(heads(document));
        self.spill = None;
    }

    /// The document it journals to.
    pub fn path(&self) -> Option<&Path> {
        self.journal.as_ref()?.path()
    }

    /// Whether an edit was begun and not ended.
    pub fn is_under_way(&self) -> bool {
        self.open.is_some()
    }

    /// Edits that can be undone.
    pub fn undo_count(&self) -> usize {
        self.done.len()
    }

    /// Edits that can be made again.
    pub fn redo_count(&self) -> usize {
        self.undone.len()
    }

    /// Bytes of edits in memory.
    pub fn bytes(&self) -> u64 {
        self.used
    }

    /// Waits until all edits are on the disk, where a failure of power does not reach them.
    ///
    /// # Errors
    /// Fails with `Io` if the system or the storage cannot bring them there. Without a journal there is nothing to wait
    /// for.
    pub fn sync(&self) -> Result<()> {
        self.journal.as_ref().map_or(Ok(()), Journal::sync)
    }

    /// Begins an edit of `object`; `input` says what it is going to be.
    ///
    /// # Errors
    /// Fails with `Invalid` if an edit is under way or, where there is a journal, `input` has more than 16 MiB; as
    /// [`Recorded::states`]; with `Unsupported` if a block of a layer that the journal lacks is too large for a record;
    /// and with `Io` if the journal cannot be written.
    #[inline(never)]
    pub fn begin<R: Recorded>(&mut self, context: &Context, object: &mut R, input: &str) -> Result<()> {
        if self.open.is_some() {
            return Err(Error::invalid("an edit is under way").advise("end it before the next"));
        }
        let before = object.states(context)?;
        self.tell_layers(context, &before)?;
        let place = self.journal.as_mut().map(|journal| journal.input(input)).transpose()?;
        self.open = Some(Open { before, recipes: self.recipes.clone(), input: input.to_string(), place });
        Ok(())
    }

    /// What things on the layers were made of, ascending by number.
    pub fn recipes(&self) -> &[Recipe] {
        &self.recipes
    }

    /// Puts a recipe in place of the one with the number `id`, or removes that without `bytes`, as a part of the edit that
    /// is under way.
    ///
    /// # Errors
    /// No edit is under way, or as [`recipe::put`].
    pub fn put_recipe(&mut self, id: u32, bytes: Option<Vec<u8>>) -> Result<()> {
        if self.open.is_none() {
            return Err(Error::invalid("no edit was begun").advise("begin one first"));
        }
        recipe::put(&mut self.recipes, id, bytes)
    }

    /// Tells the journal the layers of the object, if they differ from the layers that it has: documents may be opened
    /// on objects that have more than they hold, or see them otherwise, and objects may be given more at any time.
    fn tell_layers(&mut self, context: &Context, states: &LayerStates) -> Result<()> {
        let Some(journal) = &mut self.journal else { return Ok(()) };
        let is_told = |state: &&LayerState| self.told.contains(&state.id);
        let known: Vec<Head> = match &self.known {
            Some(known) => known.clone(),
            None if states.iter().all(|state| is_told(&state)) => return Ok(()),
            None => states.iter().filter(is_told).map(LayerState::head).chain(self.foreign.iter().cloned()).collect(),
        };
        // What the object cannot have stays in the document.
        let foreign: Vec<Head> = known.iter().filter(|head| find(states, head.id).is_none()).cloned().collect();
        let there: Vec<Head> = states.iter().map(LayerState::head).chain(foreign.iter().cloned()).collect();
        if known != there {
            // Blocks of layers that the journal does not have are not in the document yet.
            let strange = |state: &&LayerState| known.iter().all(|head| head.id != state.id);
            let blocks: Vec<(&LayerState, u32)> = states
                .iter()
                .filter(strange)
                .flat_map(|state| state.blocks.numbers().into_iter().map(move |block| (state, block)))
                .collect();
            let payload = Edit::encode(context, Some([&known, &there]), blocks.len(), |index| {
                let (state, block) = blocks[index];
                let after = state.blocks.bytes(block);
                Change { layer: state.id, block, before: None, after, blank: state.blocks.blank(), fades: state.fades }
            })?;
            journal.layers(&payload)?;
        }
        self.told = there.iter().map(|head| head.id).collect();
        self.foreign = foreign;
        self.known = None;
        Ok(())
    }

    /// Ends the edit that was begun: it is confirmed, and what was undone before it cannot be made again. `None` if it
    /// changed nothing.
    ///
    /// # Errors
    /// Fails with `Invalid` if no edit was begun, as [`Recorded::states`], as the page store does if a block is on a
    /// page that cannot be read, with `Unsupported` if a block is too large for a record, and with `NotFound` or `Io`
    /// if the journal, or the temporary file in place of one, cannot be written. `object` is then as it was when the
    /// edit began; where it cannot be put back either, that error is returned.
    #[inline(never)]
    pub fn end<R: Recorded>(&mut self, context: &Context, object: &mut R) -> Result<Option<Changed>> {
        let open = self.open.take().ok_or_else(|| Error::invalid("no edit was begun").advise("begin one first"))?;
        match self.record(context, object, &open) {
            Ok(changed) => Ok(changed),
            Err(error) => {
                self.put_back(context, object, open)?;
                Err(error)
            }
        }
    }

    /// Takes back the edit that was begun, as if it had not been.
    ///
    /// # Errors
    /// Fails with `Invalid` if no edit was begun, as [`Recorded::states`] and [`Recorded::restore`], and with `Io` if
    /// the journal cannot be cut off. The edit is no longer under way then, though what it changed may be there.
    #[inline(never)]
    pub fn abandon<R: Recorded>(&mut self, context: &Context, object: &mut R) -> Result<()> {
        let open = self.open.take().ok_or_else(|| Error::invalid("no edit was begun").advise("begin one first"))?;
        self.put_back(context, object, open)
    }

    fn put_back(&mut self, context: &Context, object: &mut impl Recorded, open: Open) -> Result<()> {
        self.recipes.clone_from(&open.recipes);
        let now = object.states(context)?;
        let (blocks, layers) = difference(&open.before, &now);
        let state = |(layer, block): &(u32, u32)| BlockState {
            layer: *layer,
            block: *block,
            bytes: find(&open.before, *layer).and_then(|layer| layer.blocks.bytes(*block)).map(Cow::into_owned),
        };
        let heads: Option<Vec<Head>> = layers.then(|| open.before.iter().map(LayerState::head).collect());
        // What cannot be read stays what it is.
        let readable = |(layer, block): &&(u32, u32)| {
            find(&open.before, *layer).is_none_or(|layer| layer.blocks.try_bytes(*block).is_ok())
        };
        object.restore(context, heads.as_deref(), blocks.iter().filter(readable).map(state).collect())?;
        match (&mut self.journal, open.place) {
            (Some(journal), Some(place)) => journal.withdraw(place),
            _ => Ok(()),
        }
    }

    fn record(&mut self, context: &Context, object: &mut impl Recorded, open: &Open) -> Result<Option<Changed>> {
        let after = object.states(context)?;
        let (blocks, layers) = difference(&open.before, &after);
        let recipes = recipe::difference(&open.recipes, &self.recipes);
        if blocks.is_empty() && !layers && recipes.is_empty() {
            if let (Some(journal), Some(place)) = (&mut self.journal, open.place) {
                journal.withdraw(place)?;
            }
            return Ok(None);
        }
        // What cannot be read is not recorded as blank.
        for (layer, block) in &blocks {
            for state in [find(&open.before, *layer), find(&after, *layer)].into_iter().flatten() {
                state.blocks.try_bytes(*block)?;
            }
        }
        let heads = layers
            .then(|| [&open.before, &after].map(|states| states.iter().map(LayerState::head).collect::<Vec<_>>()));
        let heads = heads.as_ref().map(|[before, after]| [before.as_slice(), after.as_slice()]);
        let payload = Edit::encode_with(context, heads, &recipes, blocks.len(), |index| {
            let (layer, block) = blocks[index];
            let both = [find(&open.before, layer), find(&after, layer)];
            let [before, after] = both.map(|state| state.and_then(|state| state.blocks.bytes(block)));
            let blank = both.into_iter().flatten().next().map_or(&[][..], |state| state.blocks.blank());
            let fades = both.into_iter().flatten().any(|state| state.fades);
            Change { layer, block, before, after, blank, fades }
        })?;
        let written = self.journal.as_mut().map(|journal| journal.edit(&payload)).transpose()?;
        self.told.extend(after.iter().map(|layer| layer.id).filter(|id| find(&open.before, *id).is_none()));
        let changed = Changed {
            input: open.input.clone(),
            blocks: grouped(&blocks),
            layers,
            recipes: recipes.iter().map(|change| change.id).collect(),
            bytes: payload.len() as u64,
        };
        let undone = std::mem::take(&mut self.undone);
        self.used -= undone.iter().map(Step::bytes).sum::<u64>();
        let step = Step {
            input: Kept { bytes: Some(open.input.clone().into_bytes()), place: open.place },
            edit: Kept { bytes: Some(payload), place: written.map(|(location, _)| location) },
            sequence: written.map_or(0, |(_, sequence)| sequence),
            strays: Default::default(),
        };
        self.used += step.bytes();
        self.done.push(step);
        self.make_room()?;
        Ok(Some(changed))
    }

    /// Undoes the last edit on `object`; `None` if there is none. Every block is then as it was, to the bit. Settings
    /// and names of layers that were changed without the history stay where the edit does not change them, and come
    /// back with [`Self::redo`] where it does.
    ///
    /// # Errors
    /// Fails, and changes nothing, with `Invalid` if an edit is under way, the object was changed without the history
    /// or the journal by another program, with `Io` if a file cannot be read or written, with `Memory` if the system
    /// has no memory for the edit, and as the page store does if a block is on a page that cannot be read. Fails too as
    /// [`Recorded::states`], and as [`Recorded::restore`], when a journal says already that the edit was undone.
    #[inline(never)]
    pub fn undo<R: Recorded>(&mut self, context: &Context, object: &mut R) -> Result<Option<Changed>> {
        let Some(last) = self.done.len().checked_sub(1) else { return Ok(None) };
        let changed = self.go(context, object, last, Direction::Back)?;
        self.undone.extend(self.done.pop());
        self.first = self.first.min(self.done.len());
        Ok(Some(changed))
    }

    /// Makes the edit that was undone last again; `None` if there is none.
    ///
    /// # Errors
    /// Fails as [`Self::undo`] does.
    #[inline(never)]
    pub fn redo<R: Recorded>(&mut self, context: &Context, object: &mut R) -> Result<Option<Changed>> {
        let Some(last) = (self.done.len() + self.undone.len()).checked_sub(1).filter(|_| !self.undone.is_empty())
        else {
            return Ok(None);
        };
        let changed = self.go(context, object, last, Direction::Forward)?;
        self.done.extend(self.undone.pop());
        Ok(Some(changed))
    }

    fn go(
        &mut self,
        context: &Context,
        object: &mut impl Recorded,
        index: usize,
        direction: Direction,
    ) -> Result<Changed> {
        if self.open.is_some() {
            return Err(Error::invalid("an edit is under way").advise("end it first"));
        }
        let (input, payload) = (self.text(index)?, self.payload(index)?);
        let bytes = payload.len() as u64;
        let states = object.states(context)?;
        let faces = states.first().map_or(0, |layer| layer.blocks.face_sizes().len());
        let edit = Edit::decode(payload, faces, &mut Budget::new(u64::MAX))?;
        let foreign = || {
            Error::invalid("the object was changed without its history, so that the edit does not fit it any more")
                .at(input.clone())
                .advise("begin and end an edit around every change")
        };
        let now: Vec<Head> = edit.layers().map_or_else(Vec::new, |_| states.iter().map(LayerState::head).collect());
        let (from, to) = (direction as usize, 1 - direction as usize);
        let known = self.step(index).map_or(&[][..], |step| &step.strays[to]);
        let (heads, strays) = merged(&edit, direction, &now, known).unzip();
        let deltas = edit.deltas();
        for delta in deltas {
            find(&states, delta.layer).map_or(Ok(None), |layer| layer.blocks.try_bytes(delta.block))?;
        }
        let put = context.map(deltas.len(), |index| {
            let delta = &deltas[index];
            let there = find(&states, delta.layer);
            let state = there.and_then(|layer| layer.blocks.bytes(delta.block));
            let state = state.as_deref();
            let blank = edit.blank(delta.layer).or(there.map(|layer| layer.blocks.blank()));
            let bytes = edit.apply(delta, direction, state, blank.unwrap_or(&[]))?;
            Ok(BlockState { layer: delta.layer, block: delta.block, bytes })
        });
        let put = put.into_iter().collect::<Result<Vec<_>>>().map_err(|_| foreign())?;
        let mut blocks: Vec<(u32, u32)> = deltas.iter().map(|delta| (delta.layer, delta.block)).collect();
        blocks.sort_unstable();
        let mut recipes = self.recipes.clone();
        edit.change_recipes(&mut recipes, direction)?;
        let sequence = self.step(index).map_or(0, |step| step.sequence);
        match (&mut self.journal, direction) {
            (Some(journal), Direction::Back) => journal.undo(sequence)?,
            (Some(journal), Direction::Forward) => journal.redo(sequence)?,
            (None, _) => {}
        }
        object.restore(context, heads.as_deref(), put)?;
        self.recipes = recipes;
        if self.journal.is_some() && heads.is_some() {
            // What was changed without the history is said with the next edit.
            self.known = edit.layers_after(direction, &now);
        }
        let done = self.done.len();
        let step = if index < done { self.done.get_mut(index) } else { self.undone.get_mut(index - done) };
        if let (Some(step), Some(strays)) = (step, strays) {
            step.strays[from] = strays;
        }
        let recipes = edit.recipes().iter().map(|change| change.id).collect();
        Ok(Changed { input, blocks: grouped(&blocks), layers: heads.is_some(), recipes, bytes })
    }

    /// An edit, by its place among done edits and then undone edits.
    fn step(&self, index: usize) -> Option<&Step> {
        self.done.get(index).or_else(|| self.undone.get(index.checked_sub(self.done.len())?))
    }

    fn bytes_of(&mut self, index: usize, part: fn(&Step) -> &Kept) -> Result<Vec<u8>> {
        let lost = || Error::internal(format!("edit {index} is nowhere"));
        let kept = part(self.step(index).ok_or_else(lost)?);
        if let Some(bytes) = &kept.bytes {
            return Ok(bytes.clone());
        }
        let place = kept.place.ok_or_else(lost)?;
        self.journal.as_mut().or(self.spill.as_mut()).ok_or_else(lost)?.read(place)
    }

    fn payload(&mut self, index: usize) -> Result<Vec<u8>> {
        self.bytes_of(index, |step| &step.edit)
    }

    fn text(&mut self, index: usize) -> Result<String> {
        Ok(String::from_utf8_lossy(&self.bytes_of(index, |step| &step.input)?).into_owned())
    }

    /// Drops the oldest edits until the others have room in memory.
    fn make_room(&mut self) -> Result<()> {
        while self.used > self.memory && self.first < self.done.len() {
            let step = &mut self.done[self.first];
            let freed = step.bytes();
            if step.edit.place.is_none() {
                let spill = match &mut self.spill {
                    Some(spill) => spill,
                    none => none.insert(Journal::temporary()?),
                };
                let text = String::from_utf8_lossy(step.input.bytes.as_deref().unwrap_or_default()).into_owned();
                step.input.place = Some(spill.input(&text)?);
                step.edit.place = Some(spill.edit(step.edit.bytes.as_deref().unwrap_or_default())?.0);
            }
            for kept in [&mut step.input, &mut step.edit] {
                // What has no place is nothing at all.
                if kept.place.is_some() {
                    kept.bytes = None;
                }
            }
            self.used -= freed - step.bytes();
            self.first += 1;
        }
        Ok(())
    }
}

impl Step {
    /// Bytes it occupies in memory.
    fn bytes(&self) -> u64 {
        [&self.input, &self.edit].map(|kept| kept.bytes.as_ref().map_or(0, |bytes| bytes.len() as u64)).iter().sum()
    }
}

fn heads(document: &Document) -> Vec<Head> {
    document.layers().iter().map(|layer| layer.head().clone()).collect()
}

fn find(states: &LayerStates, id: u32) -> Option<&LayerState> {
    states.iter().find(|layer| layer.id == id)
}

/// The blocks that differ, by layer and number, and whether the layers themselves do.
fn difference(before: &LayerStates, after: &LayerStates) -> (Vec<(u32, u32)>, bool) {
    let mut blocks = Vec::new();
    for layer in after {
        let numbers = match find(before, layer.id) {
            Some(old) => layer.blocks.changed(&*old.blocks),
            None => layer.blocks.numbers(),
        };
        blocks.extend(numbers.into_iter().map(|block| (layer.id, block)));
    }
    for layer in before.iter().filter(|layer| find(after, layer.id).is_none()) {
        blocks.extend(layer.blocks.numbers().into_iter().map(|block| (layer.id, block)));
    }
    let layers = before.len() != after.len() || before.iter().zip(after).any(|(a, b)| !a.is_headed_as(b));
    (blocks, layers)
}

/// Blocks, by layer and number, layer by layer.
fn grouped(blocks: &[(u32, u32)]) -> Vec<(u32, Vec<u32>)> {
    let mut sorted = blocks.to_vec();
    sorted.sort_unstable();
    sorted
        .chunk_by(|a, b| a.0 == b.0)
        .filter_map(|layer| Some((layer.first()?.0, layer.iter().map(|(_, block)| *block).collect())))
        .collect()
}
