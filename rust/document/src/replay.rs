//! A journal is folded into the base of its document: every edit goes forward in order, an undo goes back.
//!
//! A block whose difference does not fit stays as it last was known and is damage; the others go on.

use std::collections::BTreeMap;
use std::io::{Read, Seek};

use relievo_core::Result;
use relievo_core::budget::Budget;

use crate::edit::{Delta, Direction, Edit};
use crate::format::{self, Damage};
use crate::head::Head;
use crate::layer::{Block, Layer};
use crate::recipe::Recipe;
use crate::record::{Item, Location, Reader, RecordKind, failed};
use crate::{Document, Error};

/// An edit of a journal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Entry {
    /// The sequence number of its record.
    pub sequence: u64,
    /// Where what it was going to be is written, if that is there.
    pub input: Option<Location>,
    /// Where what it changed is written.
    pub edit: Location,
}

/// What a journal says.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Log {
    /// Edits that are made, in order; the last is undone first.
    pub done: Vec<Entry>,
    /// Edits that are undone; the last is made again first.
    pub undone: Vec<Entry>,
    /// What was going to be made, and is not, when the journal was left; empty if that is not known.
    pub under_way: Option<String>,
    /// Bytes at the end of the file that belong to no whole record.
    pub torn: u64,
    /// Where the next record goes, and its sequence number.
    pub(crate) end: u64,
    pub(crate) next: u64,
}

impl Log {
    /// What the user should know of how the journal was left.
    pub fn note(&self) -> Option<String> {
        let input = self.under_way.as_ref()?;
        Some(match input.is_empty() {
            true => "an edit was under way when the document was left, and is not in it".into(),
            false => format!("an edit was under way when the document was left, and is not in it: {}", shown(input)),
        })
    }
}

/// The beginning of a text.
fn shown(text: &str) -> String {
    const SHOWN: usize = 200;
    let line = text.split_whitespace().collect::<Vec<_>>().join(" ");
    match line.char_indices().nth(SHOWN) {
        Some((end, _)) => format!("{}…", &line[..end]),
        None => line,
    }
}

/// A block on its way through the edits.
#[derive(Debug)]
struct State {
    bytes: Option<Vec<u8>>,
    /// Whether that is what the edits so far made of it.
    sound: bool,
}

#[derive(Debug)]
struct Replay<'a> {
    base: &'a Document,
    heads: Vec<Head>,
    recipes: Vec<Recipe>,
    /// Blocks that an edit met, by layer and block.
    states: BTreeMap<(u32, u32), State>,
}

/// What a block of the journal takes apart from its bytes.
const OVERHEAD: u64 = 128;

/// Folds the journal that `source` has from byte `start` on into `document`.
pub(crate) fn fold(
    document: &mut Document,
    source: &mut (impl Read + Seek),
    start: u64,
    budget: &mut Budget,
    damage: &mut Vec<Damage>,
) -> Result<Log> {
    let heads = document.layers.iter().map(|layer| layer.head.clone()).collect();
    let recipes = document.recipes.clone();
    let mut replay = Replay { base: document, heads, recipes, states: BTreeMap::new() };
    let mut found = Vec::new();
    let log = walk(source, start, budget.left(), &mut found, |sequence, payload, direction, damage| {
        replay.run(sequence, payload, direction, budget, damage)
    })?;
    let (layers, recipes) = replay.finish()?;
    damage.extend(found);
    (document.layers, document.recipes) = (layers, recipes);
    Ok(log)
}

/// Reads the journal that `source` has from byte `start` on. `run` gets the payload of every edit that is made or taken
/// back, with its number.
pub(crate) fn walk(
    source: &mut (impl Read + Seek),
    start: u64,
    limit: u64,
    damage: &mut Vec<Damage>,
    mut run: impl FnMut(u64, Vec<u8>, Direction, &mut Vec<Damage>) -> Result<()>,
) -> Result<Log> {
    let mut reader = Reader::new(source, start, limit)?;
    let mut log = Log { end: start, ..Log::default() };
    let mut pending: Option<(Location, String)> = None;
    while let Some(item) = reader.read()? {
        let (kind, sequence, location, payload) = match item {
            Item::Record { kind, sequence, location, payload } => (kind, sequence, location, payload),
            Item::Torn { bytes } => {
                log.torn = bytes;
                log.under_way = Some(String::new());
                break;
            }
            Item::Damaged { offset, what, next } => {
                let input =
                    pending.take().map_or_else(String::new, |(_, input)| format!(", an edit: {}", shown(&input)));
                let place = format!("journal: record {next} at byte {offset}");
                damage.push(Damage { lost: true, place, what: format!("{what}{input}") });
                continue;
            }
        };
        match kind {
            RecordKind::Input => {
                pending = Some((location, String::from_utf8_lossy(&payload).into_owned()));
                continue;
            }
            RecordKind::Edit => {
                let input = pending.take().map(|(location, _)| location);
                run(sequence, payload, Direction::Forward, damage)?;
                log.done.push(Entry { sequence, input, edit: location });
                log.undone.clear();
            }
            RecordKind::Layers => run(sequence, payload, Direction::Forward, damage)?,
            RecordKind::Past | RecordKind::Future => {
                let input = pending.take().map(|(location, _)| location);
                let list = if kind == RecordKind::Past { &mut log.done } else { &mut log.undone };
                list.push(Entry { sequence, input, edit: location });
            }
            RecordKind::Undo | RecordKind::Redo => {
                pending = None;
                let (from, to, direction) = match kind {
                    RecordKind::Undo => (&mut log.done, &mut log.undone, Direction::Back),
                    _ => (&mut log.undone, &mut log.done, Direction::Forward),
                };
                let named = payload.try_into().map(u64::from_le_bytes).ok();
                match from.pop_if(|entry| Some(entry.sequence) == named) {
                    Some(entry) => {
                        let payload = reader.payload(entry.edit)?;
                        run(entry.sequence, payload, direction, damage)?;
                        to.push(entry);
                    }
                    None => damage.push(Damage {
                        lost: true,
                        place: format!("journal: record {sequence}"),
                        what: "it undoes or redoes an edit that is not there".into(),
                    }),
                }
            }
        }
        (log.end, log.next) = (reader.position(), reader.next());
    }
    if let Some((_, input)) = pending {
        log.under_way = Some(input);
    }
    Ok(log)
}

impl Replay<'_> {
    /// Takes the edit of record `sequence` in `direction`.
    fn run(
        &mut self,
        sequence: u64,
        payload: Vec<u8>,
        direction: Direction,
        budget: &mut Budget,
        damage: &mut Vec<Damage>,
    ) -> Result<()> {
        let place = || format!("journal: record {sequence}");
        let mut room = Budget::new(budget.left());
        let edit = match Edit::decode(payload, self.base.topology.face_count(), &mut room) {
            Ok(edit) => edit,
            Err(error) if error.kind == relievo_core::ErrorKind::Memory => return Err(error),
            Err(error) => {
                damage.push(Damage { lost: true, place: place(), what: error.what });
                return Ok(());
            }
        };
        let heads = edit.layers_after(direction, &self.heads);
        if let Some([before, after]) = edit.layers() {
            let met = if direction == Direction::Forward { before } else { after };
            let there = |head: &Head| self.heads.iter().any(|own| own.id == head.id && own.kind == head.kind);
            if !met.iter().all(there) {
                damage.push(Damage {
                    lost: true,
                    place: place(),
                    what: "the layers are not as the edit met them".into(),
                });
            }
        }
        let after = heads.as_ref().unwrap_or(&self.heads);
        let (base, states) = (self.base, &mut self.states);
        for delta in edit.deltas() {
            let head = after.iter().chain(&self.heads).find(|head| head.id == delta.layer);
            let Some(head) = head else {
                let what = format!("it changes a layer with the number {}, which there is not", delta.layer);
                damage.push(Damage { lost: true, place: place(), what });
                continue;
            };
            let state = match states.entry((delta.layer, delta.block)) {
                std::collections::btree_map::Entry::Occupied(entry) => entry.into_mut(),
                std::collections::btree_map::Entry::Vacant(entry) => {
                    let state = base_state(base, delta);
                    budget.charge(OVERHEAD + state.bytes.as_ref().map_or(0, |bytes| bytes.len() as u64))?;
                    entry.insert(state)
                }
            };
            let was = state.sound;
            let blank = edit.blank(head.id).unwrap_or(&head.blank);
            let next = edit.apply(delta, direction, state.bytes.as_deref(), blank);
            let fits = |bytes: &Option<Vec<u8>>| {
                let length = bytes.as_ref().map_or(0, |bytes| bytes.len() as u64);
                length == 0 || head.block_sizes(&base.topology, delta.block).contains(&length)
            };
            match next {
                Ok(bytes) if fits(&bytes) => {
                    let [new, old] = [&bytes, &state.bytes].map(|bytes| bytes.as_ref().map_or(0, Vec::len) as u64);
                    budget.charge(new.saturating_sub(old))?;
                    *state = State { bytes, sound: true };
                }
                // Whatever it was, it is gone.
                Err(_) if !delta.is_there(direction) => *state = State { bytes: None, sound: true },
                other => {
                    state.sound = false;
                    if was {
                        let what = match other {
                            Err(error) => error.what,
                            Ok(_) => "a block of the journal has not the size of its tile".into(),
                        };
                        let place = format::place(&base.topology, &head.name, delta.block);
                        let what = format!("{what}; the edit of record {sequence} and later ones are lost there");
                        damage.push(Damage { lost: true, place, what });
                    }
                }
            }
        }
        if let Some(heads) = heads {
            self.heads = heads;
        }
        for change in edit.recipes() {
            budget.charge(change.states.iter().flatten().map(|bytes| bytes.len() as u64).sum())?;
        }
        if let Err(error) = edit.change_recipes(&mut self.recipes, direction) {
            damage.push(Damage { lost: true, place: place(), what: error.what });
        }
        Ok(())
    }

    /// The layers as the edits left them.
    fn finish(self) -> Result<(Vec<Layer>, Vec<Recipe>)> {
        let mut states = self.states;
        let mut layers = Vec::with_capacity(self.heads.len());
        for head in self.heads {
            let base = self.base.layers.iter().find(|layer| layer.id() == head.id);
            let untouched = base.map_or(&[][..], |layer| &layer.blocks).iter();
            let mut blocks: Vec<Block> =
                untouched.filter(|block| !states.contains_key(&(head.id, block.tile))).cloned().collect();
            let touched: Vec<(u32, Vec<u8>)> = states
                .range_mut((head.id, 0)..=(head.id, u32::MAX))
                .filter_map(|((_, block), state)| Some((*block, state.bytes.take()?)))
                .collect();
            for (block, bytes) in touched {
                blocks.push(Block::pack(block, &bytes)?);
            }
            blocks.sort_unstable_by_key(|block| block.tile);
            layers.push(Layer { head, blocks });
        }
        Ok((layers, self.recipes))
    }
}

/// The block of `delta` in the base.
fn base_state(base: &Document, delta: &Delta) -> State {
    let layer = base.layers.iter().find(|layer| layer.id() == delta.layer);
    let found = layer.and_then(|layer| {
        let index = layer.blocks.binary_search_by_key(&delta.block, |block| block.tile).ok()?;
        Some(layer.unpack(&base.topology, index))
    });
    match found {
        None => State { bytes: None, sound: true },
        Some(Ok(bytes)) => State { bytes: Some(bytes), sound: true },
        Some(Err(_)) => State { bytes: None, sound: false },
    }
}

/// What an edit that was under way was, from its record.
pub(crate) fn text(bytes: Vec<u8>) -> Result<String> {
    String::from_utf8(bytes).map_err(|_| Error::invalid("the document is damaged: a text is not UTF-8"))
}

pub(crate) fn length(source: &mut impl Seek) -> Result<u64> {
    source.seek(std::io::SeekFrom::End(0)).map_err(failed)
}
