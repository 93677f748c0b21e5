//! Edits that come from a device to the processor, and that go there.

use std::sync::Arc;

use relievo_core::{Context, Error, Result};

use super::history::{DeviceFront, History};
use super::level::{DeviceLevel, Shown};
use super::places::{received, sent};
use super::windows::gathered;
use crate::progressive::build::cut::Cut;
use crate::progressive::build::hierarchy::Progressive;
use crate::progressive::edit::moves::Moves;
use crate::progressive::mesh::active::ActiveMesh;

impl DeviceLevel {
    /// The finest mesh on the processor, at rest, with the edits of this one at all levels, to the bit. They cannot be
    /// taken back there. `mesh` is what was sent to the device. Waits for the device, which gives 64 bytes a triangle.
    ///
    /// # Errors
    /// Fails if the mesh is another one, and where the device is lost or has no memory.
    pub fn to_active(&mut self, context: &Context, mesh: &Arc<Progressive>) -> Result<ActiveMesh> {
        self.is_of(mesh)?;
        self.rest()?;
        let mut active = ActiveMesh::new(mesh);
        active.adapt(context, Cut::FINEST);
        if self.edits.is_none() {
            return Ok(active);
        }
        // What is finer than the edits follows when it is made.
        let front = self.front()?;
        self.go_to(&DeviceFront::Cut(Cut::FINEST))?;
        if let Some(edits) = &self.edits {
            let device = &self.hierarchy.device;
            let mut frame = device.frame()?;
            let places = edits.places.nodes.read(&mut frame, 2 * mesh.vertex_count())?;
            let notes = edits.notes.read(&mut frame, 2 * mesh.vertex_count())?;
            let _ = frame.submit()?;
            let mut moves = Moves::new(mesh.vertex_count());
            for (node, place) in (0..).zip(gathered(device, places)?) {
                moves.places.set(node, received(&place));
            }
            for (split, [first, second]) in (0..).zip(gathered(device, notes)?.as_chunks::<2>().0) {
                moves.built.set(split, received(first).zip(received(second)).map(|(first, second)| [first, second]));
            }
            active.moves = Some(moves);
        }
        self.go_to(&front)?;
        Ok(active)
    }

    /// Has the edits of a mesh on the processor in place of its own, at all levels, to the bit; they cannot be taken
    /// back here. Both stay as fine as they are, at rest.
    ///
    /// # Errors
    /// Fails if the mesh is of another progressive mesh or this one was sent without what edits need, and where the
    /// device is lost or has no memory.
    pub fn take(&mut self, context: &Context, active: &mut ActiveMesh) -> Result<()> {
        self.is_of(&active.whole)?;
        self.rest()?;
        active.rest(context);
        let whole = self.hierarchy.clone();
        if self.edits.is_none() {
            self.prepare_edits(whole.for_edits()?)?;
        }
        let (places, notes) = active.at_finest(context, |mesh| {
            let moves = mesh.moves.as_ref();
            let nodes = 0..2 * mesh.whole.vertex_count() as u32;
            let place = |node: u32| sent(moves.and_then(|moves| moves.place(node)));
            let note = |node: u32| {
                let both = moves.and_then(|moves| moves.built.get(node / 2));
                sent(both.map(|both| both[node as usize % 2]))
            };
            (nodes.clone().map(place).collect::<Vec<_>>(), nodes.map(note).collect::<Vec<_>>())
        });
        if let Some(edits) = &self.edits {
            edits.places.nodes.write(&whole.device, &places)?;
            edits.notes.write(&whole.device, &notes)?;
        }
        self.history = History::default();
        self.is_followed = true;
        if matches!(self.shown, Shown::Nothing) { Ok(()) } else { self.show() }
    }

    fn is_of(&self, mesh: &Progressive) -> Result<()> {
        if (mesh.vertex_count(), mesh.triangle_count()) == (self.hierarchy.vertices, self.hierarchy.triangles) {
            return Ok(());
        }
        Err(Error::invalid("it is not the progressive mesh that was sent").at("mesh"))
    }
}
