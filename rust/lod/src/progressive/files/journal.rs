//! Journals of edits: what a killed program had made of a mesh of a progressive mesh is made again.
//!
//! Every edit is written down before it is made, with the level it is made at, and confirmed after it, as edits of documents
//! are ([`relievo_document::journal`]). What an edit makes follows from the mesh and from the edits before it, so that is not
//! written: taking the journal up makes the edits again.
//!
//! The head, little-endian: the signature, the version, how many vertices and triangles the finest mesh has, and the sum of
//! what it is (CRC-32). What inputs are is in `inputs`; what confirms one is how many vertices it reached (eight bytes).

use std::path::Path;
use std::sync::Arc;

use relievo_core::{Context, Error, Result};
use relievo_detail::{Action, Stamp, StampImage, Stroke};
use relievo_document::code::{Decoder, Encoder};
use relievo_document::record::Location;
use relievo_document::{Entry, Journal};

use super::inputs::{self, Image, damaged};
use crate::progressive::build::cut::Front;
use crate::progressive::build::hierarchy::Progressive;
use crate::progressive::edit::handle::Edit;
use crate::progressive::edit::history::History;
use crate::progressive::edit::sculpt::Sculpted;
use crate::progressive::mesh::active::ActiveMesh;

const SIGNATURE: &[u8; 8] = b"RLVPEDT\n";
const VERSION: u32 = 1;

/// What is done to a mesh.
#[derive(Clone, Debug, PartialEq)]
pub enum Input {
    /// Regions are moved and turned.
    Edit(Edit),
    /// A brush sculpts.
    Stroke(Box<Stroke>),
}

/// What was found in a journal.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Recovered {
    /// Edits that were made again, and the meshes they were made at.
    pub edits: Vec<(Front, Input)>,
    /// Edits that were taken back, and can be made again.
    pub undone: usize,
    /// What the user should know of how the journal was left.
    pub note: Option<String>,
}

/// The journal of a mesh, whose edits go by way of it.
#[derive(Debug)]
pub struct EditJournal {
    journal: Journal,
    /// Images that inputs have, and where these are.
    images: Vec<(Arc<StampImage>, Location)>,
    /// The numbers of edits that are made, and of edits that were taken back.
    done: Vec<u64>,
    undone: Vec<u64>,
}

impl EditJournal {
    /// The journal at `path` of a mesh that is not edited yet; if it is there already, its edits are made again. The mesh is
    /// at the same level afterwards.
    ///
    /// # Errors
    /// Fails if the mesh has edits, the file cannot be read or written, is that of another mesh or damaged, or another
    /// program works on it. The mesh has no edits then.
    pub fn open(context: &Context, path: &Path, mesh: &mut ActiveMesh) -> Result<(Self, Recovered)> {
        if mesh.edits() != [0, 0] {
            return Err(Error::invalid("it has edits already").advise("begin its journal before the first one"));
        }
        let head = mesh.whole.head();
        if !path.exists() {
            let journal = Journal::beside(path, &head)?;
            return Ok((
                Self { journal, images: Vec::new(), done: Vec::new(), undone: Vec::new() },
                Recovered::default(),
            ));
        }
        let front = mesh.front();
        let made = Self::take_up(context, path, &head, mesh);
        if made.is_err() {
            while mesh.undo(context) {}
            mesh.history = History::default();
        }
        mesh.adapt_front(context, &front)?;
        made.map_err(|error| if error.place.is_empty() { error.at(path.display().to_string()) } else { error })
    }

    fn take_up(context: &Context, path: &Path, head: &[u8], mesh: &mut ActiveMesh) -> Result<(Self, Recovered)> {
        let (log, journal) = Journal::take_up(path, head, context.memory_limit())?;
        let number = |entry: &Entry| entry.sequence;
        let (done, undone) = (log.done.iter().map(number).collect(), log.undone.iter().map(number).collect());
        let mut made = Self { journal, images: Vec::new(), done, undone };
        let mut found = Recovered { undone: log.undone.len(), ..Recovered::default() };
        if log.under_way.is_some() {
            found.note = Some("an edit was under way when the journal was left, and is not made".into());
        }
        for (number, entry) in log.done.iter().chain(log.undone.iter().rev()).enumerate() {
            let at = |error: Error| error.at(format!("{}: edit {}", path.display(), number + 1));
            let input = entry.input.ok_or_else(|| at(damaged()))?;
            let (front, input) = made.decode(context, (input, true), mesh.whole.vertex_count()).map_err(at)?;
            mesh.adapt_front(context, &front).map_err(at)?;
            let reached = (input.make(context, mesh).map_err(at)? as u64).to_le_bytes();
            if made.journal.read(entry.edit)? != reached {
                // Last bits depend on the levels that the mesh went through between edits.
                found.note = Some(format!("edit {} does not reach the vertices that it did at first", number + 1));
            }
            if number < log.done.len() {
                found.edits.push((front, input));
            }
        }
        log.undone.iter().for_each(|_| _ = mesh.undo(context));
        Ok((made, found))
    }

    /// Moves and turns regions; see [`ActiveMesh::edit`].
    ///
    /// # Errors
    /// Fails as [`ActiveMesh::edit`], and if the edit cannot be written down; nothing has changed then.
    pub fn edit(&mut self, context: &Context, mesh: &mut ActiveMesh, edit: &Edit) -> Result<usize> {
        let bytes = inputs::edit(&mesh.front(), edit)?;
        self.made(context, mesh, &bytes, |mesh| mesh.edit(context, edit), |reached| *reached)
            .map(|(reached, _)| reached)
    }

    /// Makes a stroke; see [`ActiveMesh::sculpt`].
    ///
    /// # Errors
    /// Fails as [`ActiveMesh::sculpt`], and if the stroke cannot be written down; nothing has changed then.
    pub fn sculpt(&mut self, context: &Context, mesh: &mut ActiveMesh, stroke: &Stroke) -> Result<Sculpted> {
        let Action::Sculpt { mode, height } = stroke.action else { return mesh.sculpt(context, stroke) };
        let image = stroke.stamp.as_ref().map(Stamp::image);
        let known = image.and_then(|image| self.images.iter().find(|(known, _)| Arc::ptr_eq(known, image)));
        let known = known.map(|(_, location)| *location);
        let bytes = inputs::stroke(&mesh.front(), stroke, (mode, height), known)?;
        let made = self.made(context, mesh, &bytes, |mesh| mesh.sculpt(context, stroke), |done| done.vertices);
        let (done, location) = made?;
        if let (Some(image), None) = (image, known) {
            self.images.push((image.clone(), location));
        }
        Ok(done)
    }

    fn made<T>(
        &mut self,
        context: &Context,
        mesh: &mut ActiveMesh,
        input: &[u8],
        make: impl FnOnce(&mut ActiveMesh) -> Result<T>,
        reached: impl FnOnce(&T) -> usize,
    ) -> Result<(T, Location)> {
        let location = self.journal.input_bytes(input)?;
        let made = match make(mesh) {
            Ok(made) => made,
            Err(error) => {
                // What is left of it is reported as an edit that was under way.
                let _ = self.journal.withdraw(location);
                return Err(error);
            }
        };
        match self.journal.edit(&(reached(&made) as u64).to_le_bytes()) {
            Ok((_, number)) => self.done.push(number),
            Err(error) => {
                mesh.undo(context);
                mesh.forget_undone();
                let _ = self.journal.withdraw(location);
                return Err(error);
            }
        }
        self.undone.clear();
        Ok((made, location))
    }

    /// Takes the last edit back; see [`ActiveMesh::undo`].
    ///
    /// # Errors
    /// Fails, and changes nothing, if the file cannot be written.
    pub fn undo(&mut self, context: &Context, mesh: &mut ActiveMesh) -> Result<bool> {
        let Some(number) = self.done.last().copied() else { return Ok(false) };
        self.journal.undo(number)?;
        self.undone.extend(self.done.pop());
        Ok(mesh.undo(context))
    }

    /// Makes the edit again that was taken back last; see [`ActiveMesh::redo`].
    ///
    /// # Errors
    /// Fails, and changes nothing, if the file cannot be written.
    pub fn redo(&mut self, context: &Context, mesh: &mut ActiveMesh) -> Result<bool> {
        let Some(number) = self.undone.last().copied() else { return Ok(false) };
        self.journal.redo(number)?;
        self.done.extend(self.undone.pop());
        Ok(mesh.redo(context))
    }

    /// Waits until all is on the disk: against a failure of power.
    ///
    /// # Errors
    /// Fails if the system cannot write the file to the disk.
    pub fn sync(&self) -> Result<()> {
        self.journal.sync()
    }

    /// The input at a location. Only one that has its image may be referred to.
    fn decode(
        &mut self,
        context: &Context,
        (location, may_refer): (Location, bool),
        vertices: usize,
    ) -> Result<(Front, Input)> {
        let bytes = self.journal.read(location)?;
        let mut from = Decoder(&bytes);
        let (front, is_stroke) = inputs::take_front(&mut from, vertices)?;
        let input = if is_stroke {
            let mut stroke = inputs::take_stroke(&mut from)?;
            stroke.stamp = match inputs::take_stamp(context, &mut from)? {
                None => None,
                Some((settings, channel, Image::Here(image))) => {
                    if !self.images.iter().any(|(_, known)| *known == location) {
                        self.images.push((image.clone(), location));
                    }
                    Some(Stamp::new(image, settings, channel)?)
                }
                Some((settings, channel, Image::At(there))) if may_refer => {
                    if !self.images.iter().any(|(_, known)| *known == there) {
                        self.decode(context, (there, false), vertices)?;
                    }
                    let image = self.images.iter().find(|(_, known)| *known == there).ok_or_else(damaged)?.0.clone();
                    Some(Stamp::new(image, settings, channel)?)
                }
                Some(_) => return Err(damaged()),
            };
            Input::Stroke(Box::new(stroke))
        } else {
            Input::Edit(inputs::take_edit(&mut from)?)
        };
        if from.0.is_empty() { Ok((front, input)) } else { Err(damaged()) }
    }
}

impl Input {
    /// Makes it on a mesh. Returns how many vertices it reached.
    ///
    /// # Errors
    /// Fails as [`ActiveMesh::edit`] or [`ActiveMesh::sculpt`]; nothing has changed then.
    pub fn make(&self, context: &Context, mesh: &mut ActiveMesh) -> Result<usize> {
        let reached = match self {
            Input::Edit(edit) => mesh.edit(context, edit)?,
            Input::Stroke(stroke) => mesh.sculpt(context, stroke)?.vertices,
        };
        Ok(reached)
    }
}

impl Progressive {
    /// What the journals of its edits begin with.
    fn head(&self) -> Vec<u8> {
        let mut sum = crc32fast::Hasher::new();
        let mut add = |words: &[u32]| words.iter().for_each(|word| sum.update(&word.to_le_bytes()));
        self.splits.iter().for_each(|split| add(&[split.key.0, split.parent, split.children[0], split.children[1]]));
        self.points.iter().for_each(|point| add(&point.map(f32::to_bits)));
        self.inner_points.iter().for_each(|packed| add(&[*packed as u32, (*packed >> 32) as u32]));
        self.faces.iter().for_each(|leaves| add(leaves));
        let mut head = Encoder(SIGNATURE.to_vec());
        [VERSION, self.vertex_count() as u32, self.triangle_count() as u32, sum.finalize()]
            .into_iter()
            .for_each(|word| head.u32(word));
        head.0
    }
}
