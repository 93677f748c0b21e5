//! Edits of a mesh on a device, how they are taken back and made again, and edits over time: as `history` and `keyed` have
//! them on the processor.

use std::sync::Arc;

use relievo_core::{Error, Result};
use relievo_gpu::{Buffer, Frame};

use super::level::{DeviceLevel, Shown};
use super::records::Record;
use crate::progressive::build::cut::Cut;
use crate::progressive::edit::handle::{Edit, Handle};
use crate::progressive::edit::keyed::{KeyedEdit, check_time};

/// A mesh on a device, by its splits.
#[derive(Clone, Debug)]
pub enum DeviceFront {
    /// Those of a cut.
    Cut(Cut),
    /// Those of a mesh that was made for a view, a bit each, on the device.
    View(Arc<Buffer<u32>>),
}

/// The mesh that was edited, and what was replaced of it.
#[derive(Debug)]
struct State {
    front: DeviceFront,
    record: Record,
}

/// What was before edits, and after edits that were taken back.
#[derive(Debug, Default)]
pub struct History {
    done: Vec<State>,
    undone: Vec<State>,
    /// What was made for a time, after all that is done.
    posed: Vec<State>,
}

fn nothing_yet() -> Error {
    Error::invalid("it has no level to edit").advise("adapt it to a cut or a view first")
}

impl DeviceLevel {
    /// Moves and turns regions of this mesh, also where it was made for a view, and waits until it is known what is
    /// reached; finer and coarser levels follow when it becomes those. Returns how many vertices were reached. With the
    /// first edit it takes 65 bytes a triangle more, 96 with normals or tangents among attributes, and with each 36
    /// bytes for every place of a vertex that it changes, at any level.
    ///
    /// # Errors
    /// Fails as [`ActiveMesh::edit`](crate::progressive::ActiveMesh::edit), and if the progressive mesh was not sent
    /// with what edits need, or has normals or tangents among attributes and a vertex of more than 4,096 triangles;
    /// nothing has changed then but that it is at rest. Fails too where the device is lost or has no memory.
    pub fn edit(&mut self, edit: &Edit) -> Result<usize> {
        self.rest()?;
        let (reached, state) = self.change(edit)?;
        self.history.done.push(state);
        self.history.undone.clear();
        self.show()?;
        Ok(reached)
    }

    /// Edits that can be taken back, and that were and can be made again.
    pub fn edits(&self) -> [usize; 2] {
        [self.history.done.len(), self.history.undone.len()]
    }

    /// Takes the last edit back. Returns whether there was one. The mesh keeps its splits. Where it has not become another
    /// since the edit it is what it was, to the bit, and so is the base and every mesh that is made finer from that; what has
    /// followed the edit at finer levels follows what was before, but for roundings.
    ///
    /// # Errors
    /// Fails where the device is lost or has no memory.
    pub fn undo(&mut self) -> Result<bool> {
        self.rest()?;
        let Some(state) = self.history.done.pop() else { return Ok(false) };
        self.restore(&state)?;
        self.history.undone.push(state);
        self.show()?;
        Ok(true)
    }

    /// Makes the edit again that was taken back last. Returns whether there was one.
    ///
    /// # Errors
    /// Fails where the device is lost or has no memory.
    pub fn redo(&mut self) -> Result<bool> {
        self.rest()?;
        let Some(state) = self.history.undone.pop() else { return Ok(false) };
        self.restore(&state)?;
        self.history.done.push(state);
        self.show()?;
        Ok(true)
    }

    /// The mesh that it is.
    ///
    /// # Errors
    /// Fails if it is nothing yet, and where the device is lost or has no memory.
    pub fn front(&self) -> Result<DeviceFront> {
        match self.shown {
            Shown::Nothing => Err(nothing_yet()),
            Shown::Cut(cut) => Ok(DeviceFront::Cut(cut)),
            Shown::View => {
                let (device, there) = (&self.hierarchy.device, self.there());
                let bits = Buffer::new(device, "splits of a view", there.len())?;
                self.submit(|_, frame| frame.copy(there, 0..there.len(), &bits, 0))?;
                Ok(DeviceFront::View(Arc::new(bits)))
            }
        }
    }

    /// Makes edits as they are at a time in seconds, one after the other, each of the mesh that its front is, in place
    /// of what was made for another time. Then it is the mesh again that it was. They are no edits to be taken back.
    /// Returns how many vertices were reached.
    ///
    /// # Errors
    /// Fails, and is at rest, as [`ActiveMesh::pose`](crate::progressive::ActiveMesh::pose) and [`Self::edit`].
    pub fn pose(&mut self, edits: &[(DeviceFront, KeyedEdit)], time: f64) -> Result<usize> {
        self.rest()?;
        check_time(time)?;
        let at = |number: usize| move |error: Error| error.at(format!("edit {number}"));
        let made = edits.iter().enumerate().map(|(number, (_, edit))| edit.at(time).map_err(at(number)));
        let made = made.collect::<Result<Vec<_>>>()?;
        let (own, mut reached) = (self.front()?, 0);
        let mut work = || {
            for (number, ((front, _), edit)) in edits.iter().zip(&made).enumerate() {
                if edit.handles.iter().any(Handle::is_moving) {
                    self.go_to(front).map_err(at(number))?;
                    let (count, state) = self.change(edit).map_err(at(number))?;
                    self.history.posed.push(state);
                    reached += count;
                }
            }
            Ok(())
        };
        let done = work();
        self.go_to(&own)?;
        if done.is_err() {
            self.rest()?;
        }
        self.show()?;
        done.map(|()| reached)
    }

    /// Takes back what [`Self::pose`] has made.
    ///
    /// # Errors
    /// Fails where the device is lost or has no memory.
    pub fn rest(&mut self) -> Result<()> {
        if self.history.posed.is_empty() {
            return Ok(());
        }
        while let Some(state) = self.history.posed.pop() {
            self.restore(&state)?;
        }
        self.show()
    }

    /// Makes an edit of this mesh. Returns how many vertices it reached, and what it has replaced.
    fn change(&mut self, edit: &Edit) -> Result<(usize, State)> {
        edit.check()?;
        let front = self.front()?;
        let whole = self.hierarchy.clone();
        let around = whole.for_edits()?;
        if self.edits.is_none() {
            self.prepare_edits(around)?;
        }
        let Some(edits) = &self.edits else { return Err(Error::internal("nothing to edit")) };
        let reaching = edits.reach(&whole, &around.ends, edit)?;
        self.submit(|_, frame| edits.make(&mut frame.pass("edit"), &whole, &around.ends, &reaching))?;
        self.is_followed = false;
        Ok((reaching.reached, State { front, record: reaching.record }))
    }

    /// Has what was edited be what it was in a state, at whatever level the mesh is, and the state be what is now.
    fn restore(&mut self, state: &State) -> Result<()> {
        // What is finer than the mesh of the edit has followed it, and follows what was before.
        let is_finer = match (self.shown, &state.front) {
            (Shown::Cut(now), DeviceFront::Cut(then)) => now < *then,
            _ => true,
        };
        self.submit(|level, frame| {
            let Some((edits, around)) = level.edits.as_ref().zip(level.hierarchy.around.as_ref()) else {
                return Err(Error::internal("nothing was edited"));
            };
            if is_finer {
                level.mark(frame, &state.front, Some(edits))?;
            }
            let mut pass = frame.pass("restore");
            edits.swap(&mut pass, &state.record)?;
            if is_finer { edits.refine(&mut pass, &level.hierarchy, &around.ends) } else { Ok(()) }
        })?;
        self.is_followed = false;
        Ok(())
    }

    /// Becomes the mesh of a front, which is not written yet.
    pub(super) fn go_to(&mut self, front: &DeviceFront) -> Result<()> {
        if matches!(front, DeviceFront::View(bits) if bits.len() != self.there().len()) {
            return Err(Error::invalid("it is of another mesh").at("front"));
        }
        let mut frame = self.hierarchy.device.frame()?;
        self.turn_to(&mut frame, front)?;
        frame.submit().map(drop)
    }

    /// Writes the mesh.
    pub(super) fn show(&self) -> Result<()> {
        self.submit(|level, frame| level.write(&mut frame.pass("write")))
    }

    fn submit(&self, record: impl FnOnce(&Self, &mut Frame) -> Result<()>) -> Result<()> {
        let mut frame = self.hierarchy.device.frame()?;
        record(self, &mut frame)?;
        frame.submit().map(drop)
    }
}
