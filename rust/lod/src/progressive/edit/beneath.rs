//! Edits of a coarser level beneath a finer mesh that stays as it is.
//!
//! What is around a split is the same in every mesh that has it (`stars`). So neither what coarser levels become nor what
//! finer ones do needs a mesh of the level that is edited: nodes identify its vertices, and those of the finer
//! mesh follow depth by depth, only where something near has moved.

use relievo_core::{Context, Result};

use super::coarser::Replaced;
use super::handle::Edit;
use super::history::{State, check_reached};
use super::moves::{Following, Moves, Placed};
use super::place::Place;
use super::stars::depth;
use crate::progressive::build::cut::Front;
use crate::progressive::mesh::active::{ActiveMesh, Waiting};
use crate::progressive::mesh::bitset::BitSet;
use crate::progressive::mesh::jump::words_of_all;

/// Splits of one task, and splits that memory is asked for at once.
const CHUNK_LEN: usize = 128;
const AHEAD: usize = 16;

/// A coarser level of a mesh.
struct Beneath<'a> {
    mesh: &'a ActiveMesh,
    /// Its vertices.
    there: BitSet,
}

impl<'a> Beneath<'a> {
    /// The level of a front, if `mesh` has all its splits.
    pub fn new(context: &Context, mesh: &'a ActiveMesh, front: &Front) -> Option<Self> {
        let words = match front {
            Front::Cut(cut) => words_of_all(context, &mesh.whole, *cut),
            Front::View(splits) => splits.0.to_vec(),
        };
        let is_there = |(at, word): (u32, &u64)| word & !mesh.there.word(at) == 0;
        (words.len() == mesh.there.word_count() && (0..).zip(&words).all(is_there))
            .then(|| Self { mesh, there: BitSet::of_words(words) })
    }

    /// The node of a vertex of the level.
    fn node(&self, vertex: u32) -> u32 {
        let mut node = self.mesh.node(vertex);
        while self.there.last_up_to(node / 2) != Some(node / 2) {
            node = self.mesh.whole.parent(node / 2);
        }
        node
    }

    /// The vertices that an edit reaches; their nodes, and where it puts them.
    fn reached(&self, moves: Option<&Moves>, edit: &Edit) -> (Vec<u32>, Vec<(u32, Place)>) {
        let moved = |vertex: u32| {
            let node = self.node(vertex);
            let now = moves.and_then(|moves| moves.place(node));
            let place = now.unwrap_or_else(|| self.mesh.whole.node_place(node));
            edit.moved(place).map(|place| (vertex, (node, place)))
        };
        self.there.iter().filter_map(moved).unzip()
    }

    /// The vertices of the finer mesh that one of the level has become.
    fn finer(&self, vertex: u32) -> impl Iterator<Item = u32> {
        let end = self.there.first_from(vertex + 1).unwrap_or(u32::MAX);
        let mut next = Some(vertex);
        std::iter::from_fn(move || {
            let at = next.filter(|at| *at < end)?;
            next = self.mesh.there.first_from(at + 1);
            Some(at)
        })
    }

    /// The vertices of the level around one of them, some more than once.
    fn around(&self, vertex: u32) -> impl Iterator<Item = u32> {
        // Where triangles of the finer mesh go from one to another, those of the level do.
        let others = self.finer(vertex).flat_map(move |vertex| self.mesh.spokes(vertex).flatten());
        others.filter_map(move |other| self.there.last_up_to(other).filter(|other| *other != vertex))
    }

    /// Has all that is finer follow where some vertices of the level have moved. Returns what its nodes had before.
    fn follow(&self, context: &Context, moves: &mut Moves, moved: &[u32]) -> Vec<Placed> {
        let whole = &*self.mesh.whole;
        // Vertices of the level whose splits follow, and vertices that have moved, or what is finer there.
        let [seen, told] = [(); 2].map(|()| BitSet::new(whole.vertex_count()));
        let (mut waiting, mut replaced) = (Waiting::default(), Vec::new());
        let near = |moved: u32, waiting: &mut Waiting| {
            if told.insert(moved) {
                for vertex in self.around(moved).chain([moved]).filter(|vertex| seen.insert(*vertex)) {
                    let splits = self.finer(vertex).skip(1);
                    splits.for_each(|split| waiting.add(depth(whole, 2 * split), split));
                }
            }
        };
        moved.iter().for_each(|vertex| near(*vertex, &mut waiting));
        let mut left = waiting.0.len();
        while left > 0 {
            left -= 1;
            let splits = std::mem::take(&mut waiting.0[left]);
            let known = &*moves;
            let placed = context.map(splits.len().div_ceil(CHUNK_LEN), |part| {
                let splits = &splits[part * CHUNK_LEN..splits.len().min((part + 1) * CHUNK_LEN)];
                let mut following = Following::new(self.mesh, known);
                splits.chunks(AHEAD).for_each(|splits| following.follow(splits));
                following.placed
            });
            for (node, place) in placed.into_iter().flatten() {
                let before = moves.places.set(node, place);
                replaced.push((node, before));
                // What is deeper was made before anything near had moved.
                if before != place
                    && let Some(vertex) = self.there.last_up_to(self.mesh.first_leaf(node))
                {
                    near(vertex, &mut waiting);
                }
            }
        }
        replaced
    }
}

impl ActiveMesh {
    /// Makes an edit of the mesh of a front, if this one has all splits of that, and stays this mesh. Returns how many
    /// vertices were reached, and what was before. Fails as [`ActiveMesh::edit`].
    pub(super) fn edit_beneath(
        &mut self,
        context: &Context,
        front: &Front,
        edit: &Edit,
    ) -> Result<Option<(usize, State)>> {
        edit.check()?;
        let mut moves = self.moves.take();
        let made = self.replace_beneath(context, &mut moves, front, edit);
        self.moves = moves;
        let Some((reached, replaced)) = made? else { return Ok(None) };
        self.note_replaced(&replaced);
        Ok(Some((reached, State { front: front.clone(), shown: Some(self.front()), replaced })))
    }

    fn replace_beneath(
        &self,
        context: &Context,
        moves: &mut Option<Moves>,
        front: &Front,
        edit: &Edit,
    ) -> Result<Option<(usize, Replaced)>> {
        let Some(level) = Beneath::new(context, self, front) else { return Ok(None) };
        let (vertices, reached) = level.reached(moves.as_ref(), edit);
        check_reached(&reached)?;
        let moves = moves.get_or_insert_with(|| Moves::new(self.whole.vertex_count()));
        let level = &level;
        let around = |index: usize| level.around(vertices[index]).map(move |vertex| level.node(vertex));
        let replaced = context.within(|| {
            let mut replaced = moves.edit(context, self, &reached, around);
            replaced.places.extend(level.follow(context, moves, &vertices));
            replaced
        });
        Ok(Some((reached.len(), replaced)))
    }
}
