//! Edits, and how they are taken back and made again.

use relievo_core::{Context, Error, Result};

use super::active::ActiveMesh;
use super::cut::Cut;
use super::handle::Edit;
use super::moves::{Moves, Snapshot};
use super::place::Place;

/// What was before edits, and after those that were taken back.
#[derive(Default)]
pub struct History {
    done: Vec<State>,
    undone: Vec<State>,
}

/// The mesh that was edited, and all that had been edited of it.
struct State {
    cut: Cut,
    moves: Option<Snapshot>,
}

impl ActiveMesh {
    /// Moves and turns regions of this mesh. Finer levels follow when it is refined, coarser ones when it is coarsened.
    /// Returns how many vertices were reached. Fails if no vertex is, or a handle is not usable; nothing has changed then.
    pub fn edit(&mut self, edit: &Edit) -> Result<usize> {
        if let Some(fault) = edit.fault() {
            return Err(Error::invalid("it needs finite numbers, a radius above 0 and an axis of length 1").at(fault));
        }
        if self.is_mixed {
            return Err(
                Error::invalid("a mesh that is made for a view has no level to edit").advise("adapt it to a cut first")
            );
        }
        let mesh = &*self;
        let moved = |vertex| Some((vertex, edit.moved(mesh.place(vertex, mesh.child(vertex)?))?));
        let reached: Vec<(u32, Place)> = self.vertices().filter_map(moved).collect();
        if reached.is_empty() {
            return Err(Error::invalid("no vertex is in a region of influence")
                .at("handles")
                .advise("move it to the surface, or make its radius larger"));
        }
        if !reached.iter().all(|(_, place)| place.point.is_finite()) {
            return Err(Error::invalid("vertices would go where there is no number").advise("use smaller translations"));
        }
        self.history.done.push(self.state());
        self.history.undone.clear();
        self.note_moved(reached.iter().map(|(vertex, _)| *vertex));
        let vertices = self.whole.vertex_count();
        self.moves.get_or_insert_with(|| Moves::new(vertices)).edit(&reached);
        Ok(reached.len())
    }

    /// Edits that can be taken back, and that were and can be made again.
    pub fn edits(&self) -> [usize; 2] {
        [self.history.done.len(), self.history.undone.len()]
    }

    /// Takes the last edit back. Returns whether there was one. A mesh that was made for a view becomes its cut.
    pub fn undo(&mut self, context: &Context) -> bool {
        let Some(state) = self.history.done.pop() else { return false };
        let now = self.restore(context, &state);
        self.history.undone.push(now);
        true
    }

    /// Makes the edit again that was taken back last. Returns whether there was one.
    pub fn redo(&mut self, context: &Context) -> bool {
        let Some(state) = self.history.undone.pop() else { return false };
        let now = self.restore(context, &state);
        self.history.done.push(now);
        true
    }

    fn state(&self) -> State {
        State { cut: self.cut(), moves: self.moves.as_ref().map(Moves::snapshot) }
    }

    /// Has what was edited be what it was in a state, at whatever level the mesh is. Returns the state before that, at the
    /// level of the other.
    fn restore(&mut self, context: &Context, state: &State) -> State {
        let cut = self.cut();
        self.adapt(context, state.cut);
        let now = self.state();
        let vertices = self.whole.vertex_count();
        self.moves = state.moves.as_ref().map(|snapshot| Moves::of_snapshot(vertices, snapshot));
        let snapshots = [&state.moves, &now.moves].into_iter().flatten();
        self.note_moved(snapshots.flat_map(Snapshot::moved));
        self.adapt(context, cut);
        now
    }
}
