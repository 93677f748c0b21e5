//! Edits, and how they are taken back and made again.

use relievo_core::{Context, Error, Result};

use super::active::ActiveMesh;
use super::coarser::Replaced;
use super::cut::Cut;
use super::handle::Edit;
use super::moves::Moves;
use super::place::Place;
use crate::connectivity::NONE;

/// What was before edits, and after those that were taken back.
#[derive(Default)]
pub struct History {
    done: Vec<State>,
    undone: Vec<State>,
}

/// The mesh that was edited, and what was replaced of it.
struct State {
    cut: Cut,
    replaced: Replaced,
}

impl ActiveMesh {
    /// Moves and turns regions of this mesh. Coarser levels follow, and finer ones when it is refined. Returns how many
    /// vertices were reached. Fails if no vertex is, or a handle is not usable; nothing has changed then.
    pub fn edit(&mut self, context: &Context, edit: &Edit) -> Result<usize> {
        if let Some(fault) = edit.fault() {
            return Err(Error::invalid("it needs finite numbers, a radius above 0 and an axis of length 1").at(fault));
        }
        self.check_level()?;
        let moved = |mesh: &Self, vertex| Some((vertex, edit.moved(mesh.place(vertex, mesh.child(vertex)?))?));
        let reached: Vec<(u32, Place)> = self.find_near(context, |low, high| edit.reaches(low, high), moved);
        if reached.is_empty() {
            return Err(Error::invalid("no vertex is in a region of influence")
                .at("handles")
                .advise("move it to the surface, or make its radius larger"));
        }
        self.change(context, reached)
    }

    /// Fails if the mesh is of no level.
    pub(super) fn check_level(&self) -> Result<()> {
        if self.is_mixed {
            return Err(
                Error::invalid("a mesh that is made for a view has no level to edit").advise("adapt it to a cut first")
            );
        }
        Ok(())
    }

    /// Puts vertices where an edit wants them. Returns how many.
    pub(super) fn change(&mut self, context: &Context, reached: Vec<(u32, Place)>) -> Result<usize> {
        if !reached.iter().all(|(_, place)| place.point.is_finite()) {
            return Err(Error::invalid("vertices would go where there is no number").advise("use smaller translations"));
        }
        self.note_moved(reached.iter().map(|(vertex, _)| *vertex));
        let mut moves = self.moves.take().unwrap_or_else(|| Moves::new(self.whole.vertex_count()));
        let replaced = context.within(|| moves.edit(context, self, &reached));
        self.moves = Some(moves);
        self.history.done.push(State { cut: self.cut(), replaced });
        self.history.undone.clear();
        Ok(reached.len())
    }

    /// Edits that can be taken back, and that were and can be made again.
    pub fn edits(&self) -> [usize; 2] {
        [self.history.done.len(), self.history.undone.len()]
    }

    /// Vertices that the last edit moved, of the mesh it was made at and of coarser ones; 0 without one.
    pub fn moved_last(&self) -> usize {
        self.history.done.last().map_or(0, |state| state.replaced.places.len())
    }

    /// Forgets the edits that were taken back.
    pub(super) fn forget_undone(&mut self) {
        self.history.undone.clear();
    }

    /// Takes the last edit back. Returns whether there was one. A mesh that was made for a view becomes its cut.
    pub fn undo(&mut self, context: &Context) -> bool {
        let Some(state) = self.history.done.pop() else { return false };
        let now = self.restore(context, state);
        self.history.undone.push(now);
        true
    }

    /// Makes the edit again that was taken back last. Returns whether there was one.
    pub fn redo(&mut self, context: &Context) -> bool {
        let Some(state) = self.history.undone.pop() else { return false };
        let now = self.restore(context, state);
        self.history.done.push(now);
        true
    }

    /// Has what was edited be what it was in a state, at whatever level the mesh is. Returns the state before that.
    fn restore(&mut self, context: &Context, state: State) -> State {
        let cut = self.cut();
        // What is finer than the level of the edit has followed it, and follows what was before.
        self.adapt(context, cut.max(state.cut));
        let mut replaced = Replaced::default();
        if let Some(moves) = &mut self.moves {
            let places = state.replaced.places.into_iter().map(|(node, place)| (node, moves.places.set(node, place)));
            replaced.places = places.collect();
            let built = state.replaced.built.into_iter().map(|(split, built)| (split, moves.built.set(split, built)));
            replaced.built = built.collect();
        }
        let vertices: Vec<u32> = replaced.places.iter().filter_map(|(node, _)| self.vertex_of(*node)).collect();
        self.note_moved(vertices.iter().copied());
        self.adapt(context, cut);
        State { cut: state.cut, replaced }
    }

    /// The vertex that is told by a node, if it is there.
    fn vertex_of(&self, node: u32) -> Option<u32> {
        let target = if node % 2 == 0 { self.target(node / 2) } else { NONE };
        let vertex = if target == NONE { node / 2 } else { target };
        (self.node(vertex) == node).then_some(vertex)
    }
}
