//! Edits, and how they are taken back and made again.

use relievo_core::{Context, Error, Result};

use super::coarser::Replaced;
use super::handle::Edit;
use super::moves::Moves;
use super::place::Place;
use crate::connectivity::NONE;
use crate::progressive::build::cut::Front;
use crate::progressive::mesh::active::ActiveMesh;

/// What was before edits, and after edits that were taken back.
#[derive(Default)]
pub struct History {
    done: Vec<State>,
    undone: Vec<State>,
    /// What was made for a time, after all that is done.
    pub(crate) posed: Vec<State>,
}

/// What was replaced by an edit, and when.
pub struct State {
    /// The mesh that was edited.
    pub(crate) front: Front,
    /// The mesh that was there, if it stayed: all of it has followed, and is part of what was replaced.
    pub(crate) shown: Option<Front>,
    pub(crate) replaced: Replaced,
}

/// Fails if no vertex is reached, or one would go where there is no number.
pub fn check_reached(reached: &[(u32, Place)]) -> Result<()> {
    if reached.is_empty() {
        return Err(Error::invalid("no vertex is in a region of influence")
            .at("handles")
            .advise("move it to the surface, or make its radius larger"));
    }
    check_finite(reached)
}

fn check_finite(reached: &[(u32, Place)]) -> Result<()> {
    if reached.iter().all(|(_, place)| place.point.is_finite()) {
        return Ok(());
    }
    Err(Error::invalid("vertices would go where there is no number").advise("use smaller translations"))
}

impl ActiveMesh {
    /// Moves and turns regions of this mesh. Coarser levels follow, and finer ones when it is refined. Returns how many
    /// vertices were reached.
    ///
    /// # Errors
    /// Fails if no vertex is reached, one would go where there is no number, or a handle or anchor is not usable;
    /// nothing has changed then.
    pub fn edit(&mut self, context: &Context, edit: &Edit) -> Result<usize> {
        self.rest(context);
        let reached = self.reached(context, edit)?;
        self.change(context, reached)
    }

    /// The vertices that an edit reaches, and where it puts them.
    pub(crate) fn reached(&mut self, context: &Context, edit: &Edit) -> Result<Vec<(u32, Place)>> {
        edit.check()?;
        let moved = |mesh: &Self, vertex| Some((vertex, edit.moved(mesh.place(vertex, mesh.child(vertex)?))?));
        let reached: Vec<(u32, Place)> = self.find_near(context, |low, high| edit.reaches(low, high), moved);
        check_reached(&reached)?;
        Ok(reached)
    }

    /// Puts vertices where an edit wants them, which can be taken back. Returns how many.
    pub(crate) fn change(&mut self, context: &Context, reached: Vec<(u32, Place)>) -> Result<usize> {
        let state = self.replace(context, &reached)?;
        self.history.done.push(state);
        self.history.undone.clear();
        Ok(reached.len())
    }

    /// Puts vertices elsewhere. Returns what was before.
    pub(crate) fn replace(&mut self, context: &Context, reached: &[(u32, Place)]) -> Result<State> {
        check_finite(reached)?;
        self.note_moved(reached.iter().map(|(vertex, _)| *vertex));
        let mut moves = self.moves.take().unwrap_or_else(|| Moves::new(self.whole.vertex_count()));
        let nodes: Vec<_> = reached.iter().map(|(vertex, place)| (self.node(*vertex), *place)).collect();
        let mesh = &*self;
        let around = |index: usize| mesh.spokes(reached[index].0).flatten().map(move |vertex| mesh.node(vertex));
        let replaced = context.within(|| moves.edit(context, mesh, &nodes, around));
        self.moves = Some(moves);
        Ok(State { front: self.front(), shown: None, replaced })
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
    pub(crate) fn forget_undone(&mut self) {
        self.history.undone.clear();
    }

    /// Takes the last edit back. Returns whether there was one. The mesh keeps its splits.
    pub fn undo(&mut self, context: &Context) -> bool {
        self.rest(context);
        let Some(state) = self.history.done.pop() else { return false };
        let now = self.restore(context, state);
        self.history.undone.push(now);
        true
    }

    /// Makes the edit again that was taken back last. Returns whether there was one.
    pub fn redo(&mut self, context: &Context) -> bool {
        self.rest(context);
        let Some(state) = self.history.undone.pop() else { return false };
        let now = self.restore(context, state);
        self.history.done.push(now);
        true
    }

    /// Has what was edited be what it was in a state, at whatever level the mesh is. Returns the state before that.
    pub(crate) fn restore(&mut self, context: &Context, state: State) -> State {
        let front = self.front();
        let is_coarser = match (&state.front, &front) {
            (_, now) if state.shown.as_ref() == Some(now) => false,
            (Front::Cut(then), Front::Cut(now)) => then > now,
            (then, now) => then != now,
        };
        // What is finer than the mesh of the edit has followed it, and follows what was before.
        if is_coarser {
            self.take_back(context, &state.front);
        }
        let mut replaced = Replaced::default();
        if let Some(moves) = &mut self.moves {
            let places = state.replaced.places.into_iter().map(|(node, place)| (node, moves.places.set(node, place)));
            replaced.places = places.collect();
            let built = state.replaced.built.into_iter().map(|(split, built)| (split, moves.built.set(split, built)));
            replaced.built = built.collect();
        }
        self.note_replaced(&replaced);
        if is_coarser {
            self.make_again(context, &front);
        }
        State { front: state.front, shown: state.shown, replaced }
    }

    /// Notes vertices whose places were replaced.
    pub(super) fn note_replaced(&mut self, replaced: &Replaced) {
        let vertices: Vec<u32> = replaced.places.iter().filter_map(|(node, _)| self.vertex_of(*node)).collect();
        self.note_moved(vertices.iter().copied());
    }

    /// The vertex of a node, if it is there.
    pub(crate) fn vertex_of(&self, node: u32) -> Option<u32> {
        let vertex = self.first_leaf(node);
        (self.node(vertex) == node).then_some(vertex)
    }

    /// The first of the leaves of a node, whose split is made or which is a base vertex: its number as a vertex.
    pub(super) fn first_leaf(&self, node: u32) -> u32 {
        let target = if node.is_multiple_of(2) { self.target(node / 2) } else { NONE };
        if target == NONE { node / 2 } else { target }
    }
}
