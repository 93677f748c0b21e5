//! What an edit changed: the state of every block it touched before and after, as the difference of their bytes.
//!
//! The difference is the exclusive or of the bytes, so that the same record goes from before to after, for redo and
//! replay, and back, for undo; it costs what changed. A block that is not there counts as blank texels, so its
//! differences are small too; bytes past the end of the shorter state count as zero, for tiles that changed their size.
//! Checksums of both states tell whether a difference fits. An edit that changes the layers themselves carries them as
//! they were and as they are: to merge two layers is one edit.
//!
//! Blocks of layers that fade change with time, and not by edits alone. Of them both states are kept as a whole, so
//! that they can be put back whatever has become of them since.
//!
//! Little-endian: flags (u8, 0; 1 or 3 if the layers change and their heads have the form of version 2 or 3; 4 more if
//! recipes change), then, if layers do, bytes of the packed and the unpacked heads (u32 each) and the heads (zstd), and if
//! recipes do, the same of them (number of recipes, and of each its number, its bytes before and after, the largest number
//! where it is not there, u32 each, and then the bytes); number of blocks (u32); of every
//! block layer, block, bytes before and after (0 if it is not there), CRC-32 before and after, bytes of the packed
//! difference, with the highest bit set if it is both states instead, one after the other (u32 each); the differences
//! (zstd each).

use std::borrow::Cow;
use std::ops::Range;

use relievo_core::budget::Budget;
use relievo_core::{Context, Error, Result};

use crate::code::{Decoder, Encoder};
use crate::head::{self, Head};
use crate::recipe::{self, MAX_RECIPE, MAX_RECIPES, Recipe, RecipeChange};
use crate::{MAX_LAYERS, format, packing};

/// The level of zstd: edits are written while somebody waits, and are mostly zeros.
const COMPRESSION: i32 = 1;
/// No block is larger: 258² texels of 8 bytes, with room for other kinds.
pub const MAX_BLOCK: u32 = 1 << 22;
/// Bytes of a block in the list.
const ENTRY: u64 = 28;
/// The flags of an edit that has heads of layers, by the version of their form.
const HEADS: [(u8, u32); 2] = [(1, 2), (3, 3)];
/// The flag of an edit that changes recipes.
const RECIPES: u8 = 4;
/// The length of a recipe that is not there.
const ABSENT: u32 = u32::MAX;
/// Beside the length of a block's bytes: they are both of its states.
const WHOLE: u32 = 1 << 31;

/// Which way an edit goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Direction {
    /// From before to after.
    Forward,
    /// From after to before.
    Back,
}

/// A block that an edit changed.
#[derive(Clone, Debug)]
pub struct Change<'a> {
    /// The number of its layer.
    pub layer: u32,
    /// The number of the block: of a tile, an edge or a face.
    pub block: u32,
    /// Its bytes before, if it was there.
    pub before: Option<Cow<'a, [u8]>>,
    /// Its bytes after, if it is there.
    pub after: Option<Cow<'a, [u8]>>,
    /// The texel that blocks read as that are not there.
    pub blank: &'a [u8],
    /// Whether the block may change otherwise than by edits, because its layer fades.
    pub fades: bool,
}

/// What an edit did to one block.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Delta {
    /// The number of its layer.
    pub layer: u32,
    /// The number of the block.
    pub block: u32,
    /// Bytes before and after, 0 where it is not there.
    lengths: [u32; 2],
    crcs: [u32; 2],
    /// Whether both states are kept, and not their difference.
    whole: bool,
    packed: Range<usize>,
}

impl Delta {
    /// Whether the block is there after going in `direction`.
    pub fn is_there(&self, direction: Direction) -> bool {
        self.lengths[1 - direction as usize] > 0
    }
}

/// What an edit changed.
#[derive(Clone, Debug, PartialEq)]
pub struct Edit {
    /// The layers before and after, if it changed them.
    layers: Option<[Vec<Head>; 2]>,
    recipes: Vec<RecipeChange>,
    deltas: Vec<Delta>,
    /// The differences, packed.
    bytes: Vec<u8>,
}

impl Edit {
    /// The payload of a record about an edit that changed `count` blocks, of which `change` tells, and the `layers`
    /// from what they were before to what they are after, if it did.
    ///
    /// # Errors
    /// Fails with `Unsupported` if a block is larger than [`MAX_BLOCK`] or there are 2³² blocks or more, and with
    /// `Internal` if zstd fails.
    pub fn encode<'a>(
        context: &Context,
        layers: Option<[&[Head]; 2]>,
        count: usize,
        change: impl Fn(usize) -> Change<'a> + Sync,
    ) -> Result<Vec<u8>> {
        Self::encode_with(context, layers, &[], count, change)
    }

    /// As [`Self::encode`], of an edit that changed `recipes` too.
    ///
    /// # Errors
    /// Fails as [`Self::encode`].
    pub fn encode_with<'a>(
        context: &Context,
        layers: Option<[&[Head]; 2]>,
        recipes: &[RecipeChange],
        count: usize,
        change: impl Fn(usize) -> Change<'a> + Sync,
    ) -> Result<Vec<u8>> {
        let mut out = Encoder::default();
        out.0.push(if layers.is_some() { HEADS[1].0 } else { 0 } | if recipes.is_empty() { 0 } else { RECIPES });
        if let Some(layers) = layers {
            let mut heads = Encoder::default();
            for list in layers {
                heads.u32(list.len() as u32);
                list.iter().for_each(|head| head.encode(&mut heads));
            }
            put_packed(&mut out, &heads.0)?;
        }
        if !recipes.is_empty() {
            put_packed(&mut out, &encode_recipes(recipes).0)?;
        }
        out.u32(u32::try_from(count).map_err(|_| Error::unsupported("an edit changed 4294967296 blocks or more"))?);
        let packed = context.map(count, |index| {
            let Change { layer, block, before, after, blank, fades } = change(index);
            let states = [before.as_deref(), after.as_deref()];
            let length = states.iter().flatten().map(|state| state.len()).max().unwrap_or(0);
            if length > MAX_BLOCK as usize {
                let what = format!("block {block} has {length} bytes, more than an edit can keep");
                return Err(Error::unsupported(what));
            }
            let difference = if fades {
                states.into_iter().flatten().collect::<Vec<_>>().concat()
            } else {
                let mut difference = state_bytes(states[0], blank, length);
                xor(&mut difference, &state_bytes(states[1], blank, length));
                difference
            };
            let crcs = states.map(|state| state.map_or(0, crc32fast::hash));
            let lengths = states.map(|state| state.map_or(0, |state| state.len() as u32));
            Ok(([layer, block, lengths[0], lengths[1], crcs[0], crcs[1]], pack(&difference)?, fades))
        });
        let packed = packed.into_iter().collect::<Result<Vec<_>>>()?;
        out.0.reserve(packed.iter().map(|(_, packed, _)| packed.len() + ENTRY as usize).sum());
        for (entry, packed, whole) in &packed {
            entry.iter().for_each(|number| out.u32(*number));
            out.u32(packed.len() as u32 | if *whole { WHOLE } else { 0 });
        }
        packed.iter().for_each(|(_, packed, _)| out.0.extend_from_slice(packed));
        Ok(out.0)
    }

    /// Reads what [`Self::encode`] wrote, for a mesh of `faces` faces.
    ///
    /// # Errors
    /// Fails with `Invalid` if it is damaged, and with `Memory` if it needs more than `budget`.
    pub fn decode(mut payload: Vec<u8>, faces: usize, budget: &mut Budget) -> Result<Self> {
        let mut from = Decoder(&payload);
        let flags = from.u8()?;
        let layers = match flags & !RECIPES {
            0 => None,
            flags => match HEADS.into_iter().find(|(known, _)| *known == flags) {
                Some((_, version)) => Some(decode_layers(&mut from, version, faces, budget)?),
                None => return Err(format::damaged("an edit of the journal is of an unknown form")),
            },
        };
        let recipes = if flags & RECIPES != 0 { decode_recipes(&mut from, budget)? } else { Vec::new() };
        let count = from.u32()?;
        from.expect(u64::from(count) * ENTRY)?;
        let mut deltas = Vec::new();
        budget.reserve(&mut deltas, count as usize)?;
        let mut at = 0usize;
        for _ in 0..count {
            let mut number = || from.u32();
            let (layer, block) = (number()?, number()?);
            let (lengths, crcs) = ([number()?, number()?], [number()?, number()?]);
            let length = number()?;
            let (length, whole) = ((length & !WHOLE) as usize, length & WHOLE != 0);
            if lengths == [0; 2] || lengths.iter().any(|length| *length > MAX_BLOCK) {
                return Err(format::damaged("a block of the journal has an impossible size"));
            }
            deltas.push(Delta { layer, block, lengths, crcs, whole, packed: at..at.saturating_add(length) });
            at = at.saturating_add(length);
        }
        if from.0.len() != at {
            return Err(format::damaged("an edit of the journal has not the length it says"));
        }
        let start = payload.len() - at;
        payload.drain(..start);
        Ok(Self { layers, recipes, deltas, bytes: payload })
    }

    /// The layers before and after, if it changed them.
    pub fn layers(&self) -> Option<&[Vec<Head>; 2]> {
        self.layers.as_ref()
    }

    /// The recipes that it changed.
    pub fn recipes(&self) -> &[RecipeChange] {
        &self.recipes
    }

    /// The layers after going in `direction` from `now`, if it changes them. Layers that it does not know of stay: they
    /// came without an edit, when a document was opened on an object that has more than it.
    pub fn layers_after(&self, direction: Direction, now: &[Head]) -> Option<Vec<Head>> {
        let layers = self.layers.as_ref()?;
        let knows = |head: &Head| layers.iter().flatten().any(|known| known.id == head.id);
        let mut after = layers[1 - direction as usize].clone();
        after.extend(now.iter().filter(|head| !knows(head)).cloned());
        Some(after)
    }

    /// Takes its changes of recipes in `direction`.
    ///
    /// # Errors
    /// There are more recipes than a document may have.
    pub fn change_recipes(&self, recipes: &mut Vec<Recipe>, direction: Direction) -> Result<()> {
        recipe::go(recipes, &self.recipes, direction)
    }

    /// The texel that blocks of `layer` read as that are not there, if it changed the layers: what it was before, where
    /// the layer was there. [`Self::apply`] wants it.
    pub fn blank(&self, layer: u32) -> Option<&[u8]> {
        let heads = self.layers.as_ref()?.iter().flatten();
        heads.into_iter().find(|head| head.id == layer).map(|head| head.blank.as_slice())
    }

    /// The blocks it changed.
    pub fn deltas(&self) -> &[Delta] {
        &self.deltas
    }

    /// The bytes of the block of `delta`, one of [`Self::deltas`], after going in `direction` from `state`; `None`
    /// where it is not there. `blank` is the texel of the layer.
    ///
    /// # Errors
    /// Fails with `Invalid` if `state` is not what the edit met, unless its layer fades, or the difference is damaged.
    pub fn apply(
        &self,
        delta: &Delta,
        direction: Direction,
        state: Option<&[u8]>,
        blank: &[u8],
    ) -> Result<Option<Vec<u8>>> {
        let (from, to) = (direction as usize, 1 - direction as usize);
        let crc = |state: Option<&[u8]>| state.map_or(0, crc32fast::hash);
        if delta.whole {
            return self.state_of(delta, to);
        }
        if state.map_or(0, <[u8]>::len) != delta.lengths[from] as usize || crc(state) != delta.crcs[from] {
            return Err(format::damaged("a block is not as the edit met it"));
        }
        if delta.lengths[to] == 0 {
            return Ok(None);
        }
        let length = delta.lengths[0].max(delta.lengths[1]) as usize;
        let mut bytes = self.unpack(delta, length)?;
        xor(&mut bytes, &state_bytes(state, blank, length));
        bytes.truncate(delta.lengths[to] as usize);
        if crc32fast::hash(&bytes) != delta.crcs[to] {
            return Err(wrong_block());
        }
        Ok(Some(bytes))
    }

    fn unpack(&self, delta: &Delta, length: usize) -> Result<Vec<u8>> {
        let packed = self.bytes.get(delta.packed.clone()).unwrap_or(&[]);
        match packing::unpack(packed, length) {
            Ok(bytes) if bytes.len() == length => Ok(bytes),
            _ => Err(format::damaged("a difference of the journal does not unpack to its size")),
        }
    }

    /// The first or second state of `delta`, which has both.
    fn state_of(&self, delta: &Delta, which: usize) -> Result<Option<Vec<u8>>> {
        let lengths = delta.lengths.map(|length| length as usize);
        if lengths[which] == 0 {
            return Ok(None);
        }
        let both = self.unpack(delta, lengths[0] + lengths[1])?;
        let (before, after) = both.split_at(lengths[0]);
        let bytes = [before, after][which];
        if crc32fast::hash(bytes) != delta.crcs[which] {
            return Err(wrong_block());
        }
        Ok(Some(bytes.to_vec()))
    }
}

fn wrong_block() -> Error {
    format::damaged("a block of the journal has a wrong checksum")
}

fn decode_layers(from: &mut Decoder, version: u32, faces: usize, budget: &mut Budget) -> Result<[Vec<Head>; 2]> {
    let raw = take_packed(from, budget)?;
    let mut heads = Decoder(&raw);
    let mut lists: [Vec<Head>; 2] = Default::default();
    for list in &mut lists {
        let count = heads.u32()?;
        if count as usize > MAX_LAYERS {
            return Err(format::damaged("it claims too many layers"));
        }
        for _ in 0..count {
            let head = Head::decode(&mut heads, version, 0, faces, budget)?;
            let sound = head.check(faces).and_then(|()| head::check_distinct(&head, list.iter()));
            sound.map_err(|error| format::damaged(&error.what).at(error.place))?;
            list.push(head);
        }
    }
    if !heads.0.is_empty() {
        return Err(format::damaged("the layers of an edit are longer than they say"));
    }
    Ok(lists)
}

fn encode_recipes(recipes: &[RecipeChange]) -> Encoder {
    let mut out = Encoder::default();
    out.u32(recipes.len() as u32);
    for RecipeChange { id, states } in recipes {
        out.u32(*id);
        states.iter().for_each(|state| out.u32(state.as_ref().map_or(ABSENT, |bytes| bytes.len() as u32)));
        states.iter().flatten().for_each(|bytes| out.0.extend_from_slice(bytes));
    }
    out
}

fn decode_recipes(from: &mut Decoder, budget: &mut Budget) -> Result<Vec<RecipeChange>> {
    let raw = take_packed(from, budget)?;
    let mut from = Decoder(&raw);
    let count = from.u32()? as usize;
    from.expect(3 * count as u64 * size_of::<u32>() as u64)?;
    if count > 2 * MAX_RECIPES {
        return Err(format::damaged("an edit claims too many recipes"));
    }
    let mut recipes = Vec::new();
    budget.reserve(&mut recipes, count)?;
    for _ in 0..count {
        let (id, lengths) = (from.u32()?, [from.u32()?, from.u32()?]);
        let mut states = [None, None];
        for (state, length) in states.iter_mut().zip(lengths).filter(|(_, length)| *length != ABSENT) {
            let bytes = from.bytes(length as usize)?;
            if bytes.len() > MAX_RECIPE {
                return Err(format::damaged("a recipe of an edit is too long"));
            }
            budget.charge(bytes.len() as u64)?;
            *state = Some(bytes.to_vec());
        }
        recipes.push(RecipeChange { id, states });
    }
    if !from.0.is_empty() {
        return Err(format::damaged("the recipes of an edit are longer than they say"));
    }
    Ok(recipes)
}

/// Writes bytes packed, after their packed and unpacked number.
fn put_packed(out: &mut Encoder, bytes: &[u8]) -> Result<()> {
    let packed = pack(bytes)?;
    out.u32(packed.len() as u32);
    out.u32(bytes.len() as u32);
    out.0.extend(packed);
    Ok(())
}

/// Reads what [`put_packed`] wrote.
fn take_packed(from: &mut Decoder, budget: &mut Budget) -> Result<Vec<u8>> {
    let (packed, length) = (from.u32()? as usize, from.u32()? as usize);
    let packed = from.bytes(packed)?;
    let mut raw = budget.filled(length, 0u8)?;
    if zstd::bulk::decompress_to_buffer(packed, raw.as_mut_slice()).ok() != Some(length) {
        return Err(format::damaged("the layers or recipes of an edit do not unpack to their size"));
    }
    Ok(raw)
}

fn pack(bytes: &[u8]) -> Result<Vec<u8>> {
    packing::pack(bytes, COMPRESSION).map_err(|error| Error::internal(format!("an edit cannot be compressed: {error}")))
}

/// The bytes of a state as `length` bytes: blank texels if there is none, and zeros after its end.
fn state_bytes(state: Option<&[u8]>, blank: &[u8], length: usize) -> Vec<u8> {
    let mut bytes = match state {
        Some(state) => state.to_vec(),
        None => blank.iter().copied().cycle().take(if blank.is_empty() { 0 } else { length }).collect(),
    };
    bytes.resize(length, 0);
    bytes
}

fn xor(bytes: &mut [u8], other: &[u8]) {
    bytes.iter_mut().zip(other).for_each(|(byte, other)| *byte ^= other);
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn state() -> impl Strategy<Value = Option<Vec<u8>>> {
        prop::option::of(prop::collection::vec(prop_oneof![Just(0u8), any::<u8>()], 1..300))
    }

    proptest! {
        #[test]
        fn an_edit_goes_forward_and_back(states in prop::collection::vec((state(), state()), 0..6), blank in any::<[u8; 4]>()) {
            let states: Vec<_> = states.into_iter().filter(|(a, b)| a.is_some() || b.is_some()).collect();
            let change = |index: usize| Change {
                layer: 3,
                block: index as u32,
                before: states[index].0.as_deref().map(Cow::Borrowed),
                after: states[index].1.as_deref().map(Cow::Borrowed),
                blank: &blank,
                fades: false,
            };
            let payload = Edit::encode(&Context::serial(), None, states.len(), change).unwrap();
            let edit = Edit::decode(payload, 1, &mut Budget::new(1 << 20)).unwrap();
            for (delta, (before, after)) in edit.deltas().iter().zip(&states) {
                let there = edit.apply(delta, Direction::Forward, before.as_deref(), &blank).unwrap();
                prop_assert_eq!(&there, after);
                let back = edit.apply(delta, Direction::Back, after.as_deref(), &blank).unwrap();
                prop_assert_eq!(&back, before);
                if before != after {
                    prop_assert!(edit.apply(delta, Direction::Back, before.as_deref(), &blank).is_err());
                }
            }
        }
    }

    fn change<'a>(before: Option<&'a [u8]>, after: Option<&'a [u8]>, fades: bool) -> Change<'a> {
        let [before, after] = [before, after].map(|state| state.map(Cow::Borrowed));
        Change { layer: 0, block: 0, before, after, blank: &[0, 0], fades }
    }

    #[test]
    fn blocks_that_fade_are_put_back_whatever_became_of_them() {
        let (before, after) = (vec![1u8; 40], vec![2u8; 60]);
        for (before, after) in [(Some(&before), Some(&after)), (None, Some(&after)), (Some(&before), None)] {
            let states = [before, after].map(|state| state.map(Vec::as_slice));
            let payload = Edit::encode(&Context::serial(), None, 1, |_| change(states[0], states[1], true)).unwrap();
            let edit = Edit::decode(payload, 1, &mut Budget::new(1 << 20)).unwrap();
            for state in [None, Some(&[7u8; 9][..])] {
                let go = |direction| edit.apply(&edit.deltas()[0], direction, state, &[0, 0]).unwrap();
                assert_eq!((go(Direction::Back).as_ref(), go(Direction::Forward).as_ref()), (before, after));
            }
        }
    }

    #[test]
    fn an_edit_costs_what_it_changed() {
        let before = vec![9; 130 * 130 * 2];
        let mut after = before.clone();
        after[500..600].fill(3);
        let change = |_| change(Some(&before), Some(&after), false);
        assert!(Edit::encode(&Context::serial(), None, 1, change).unwrap().len() < 100);
    }

    #[test]
    fn payloads_that_are_cut_or_changed_are_refused_or_do_not_apply() {
        let head = |name: &str, id| Head::new(id, name, crate::Kind::Scalar, &[0; 2], vec![8]);
        let (one, two) = ([head("a", 0)], [head("a", 0), head("b", 1)]);
        let (before, after) = (vec![1u8; 40], vec![2u8; 40]);
        let change = |_| change(Some(&before), Some(&after), false);
        let payload = Edit::encode(&Context::serial(), Some([&one, &two]), 1, change).unwrap();
        let read = |payload: &[u8]| Edit::decode(payload.to_vec(), 1, &mut Budget::new(1 << 20));
        let whole = read(&payload).unwrap();
        assert_eq!(whole.layers_after(Direction::Forward, &one).unwrap(), two);
        assert_eq!(whole.layers_after(Direction::Back, &two).unwrap(), one);
        let more = [head("a", 0), head("c", 9)];
        let all = whole.layers_after(Direction::Forward, &more).unwrap();
        assert_eq!(all, [head("a", 0), head("b", 1), head("c", 9)], "what the edit does not know stays");
        for cut in 0..payload.len() {
            assert!(read(&payload[..cut]).is_err(), "{cut}");
        }
        for at in 0..payload.len() {
            let mut bytes = payload.clone();
            bytes[at] ^= 0x10;
            if let Ok(edit) = read(&bytes) {
                let there = edit.apply(&edit.deltas()[0], Direction::Forward, Some(&before), &[0, 0]);
                assert!(edit.layers() != whole.layers() || there.is_err() || there.unwrap() == Some(after.clone()));
            }
        }
        let same = Edit::encode(&Context::serial(), Some([&one, &[head("a", 0), head("a", 1)]]), 0, change).unwrap();
        assert!(read(&same).unwrap_err().to_string().contains("of that name"));
    }
}
