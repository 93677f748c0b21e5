//! A mesh of a progressive mesh, refined and coarsened in place (Derzapf, Grund, Guthe 2014, Section 5).
//!
//! Splits are made in the order of their depths, the deepest first, and taken back in the opposite one. No two of the
//! same depth have vertices that share an edge, so all of a depth are made at the same time, and none has to be checked:
//! whatever a split stands on is deeper and deviates no less, so a cut that has the one has the other.

use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering::Relaxed};

use relievo_core::{Context, Error, Result};

use super::bitset::BitSet;
use super::blocks::Blocks;
use super::buffer_places::Places;
use super::splits::{Corner, Slot};
use crate::connectivity::NONE;
use crate::progressive::build::cut::{Cut, Front, ViewSplits};
use crate::progressive::build::hierarchy::{Child, Progressive};
use crate::progressive::build::recording::Key;
use crate::progressive::build::wedges;
use crate::progressive::edit::history::History;
use crate::progressive::edit::moves::{Moves, Refining};
use crate::progressive::edit::place::Place;

/// Words of [`BitSet`] whose vertices are looked at by one task.
const CHUNK_LEN: usize = 64;
/// Splits that are made by one task.
const BATCH: usize = 128;

/// A mesh of a progressive mesh.
pub struct ActiveMesh {
    pub(crate) whole: Arc<Progressive>,
    pub(crate) cut: Cut,
    /// It has other splits than its cut.
    pub(super) is_mixed: bool,
    /// Vertices, by the first of their leaves.
    pub(super) slots: Vec<Slot>,
    /// Which of them begin a vertex.
    pub(crate) there: BitSet,
    /// Wedges, by the first of their leaves, if there are attributes.
    pub(crate) wedges: Option<BitSet>,
    /// Three a triangle.
    pub(crate) corners: Vec<Corner>,
    /// Counts rounds of coarsening.
    pub(crate) round: u32,
    pub(crate) triangles: usize,
    pub(crate) vertices: usize,
    /// What was edited, if anything was.
    pub(crate) moves: Option<Moves>,
    pub(crate) history: History,
    pub(crate) blocks: Blocks,
    /// Where it is in buffers, if it was written to any.
    pub(crate) places: Option<Places>,
}

/// The places, normals and triangles of a mesh.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Extract {
    /// Positions. The finest mesh has the vertices of the input in their order, others go along the surface.
    pub points: Vec<[f32; 3]>,
    /// Normals of length 1, or 0 at vertices without triangles.
    pub normals: Vec<[f32; 3]>,
    /// Vertices of every triangle, in the order of the input.
    pub triangles: Vec<[u32; 3]>,
    /// Wedges of every triangle: what its corners have of attributes on points and corners. None without attributes.
    pub wedges: Vec<[u32; 3]>,
    /// Numbers of every wedge, of all attributes on points and corners, in the order of [`Progressive::attributes`].
    pub values: Vec<f32>,
    /// Numbers of every triangle, of all attributes on faces; of floats their bits.
    pub face_values: Vec<u32>,
}

impl ActiveMesh {
    /// The base mesh.
    pub fn new(whole: &Arc<Progressive>) -> Self {
        let corner = |leaf: &u32| Corner { vertex: AtomicU32::new(NONE), following: AtomicU32::new(NONE), leaf: *leaf };
        let made = Self {
            whole: whole.clone(),
            cut: Cut::BASE,
            is_mixed: false,
            slots: (0..whole.vertex_count()).map(|_| Slot::default()).collect(),
            there: BitSet::new(whole.vertex_count()),
            wedges: wedges::of_base(whole),
            corners: whole.faces.iter().flatten().map(corner).collect(),
            round: 0,
            triangles: whole.base_faces().len(),
            vertices: whole.base_vertices().len(),
            moves: None,
            history: History::default(),
            blocks: Blocks::default(),
            places: None,
        };
        for leaf in whole.base_vertices() {
            made.slots[*leaf as usize].node.store(2 * leaf, Relaxed);
            made.there.insert(*leaf);
        }
        // Base vertices come in the order of their leaves.
        let vertex_of = |leaf: u32| {
            let above = whole.base_vertices().partition_point(|first| *first <= leaf);
            whole.base_vertices()[above - 1]
        };
        for face in whole.base_faces() {
            for (side, leaf) in (0..).zip(whole.faces[*face as usize]) {
                made.insert(3 * face + side, vertex_of(leaf));
            }
        }
        made
    }

    /// Bytes that a mesh of `whole` takes besides it, at any level, before it is edited.
    pub fn bytes(whole: &Progressive) -> u64 {
        let vertices = whole.vertex_count();
        let sets = BitSet::bytes(vertices) + whole.wedges.as_ref().map_or(0, |wedges| BitSet::bytes(wedges.count()));
        (vertices * size_of::<Slot>() + sets + 3 * whole.faces.len() * size_of::<Corner>()) as u64
    }

    /// What it is a mesh of.
    pub fn progressive(&self) -> &Arc<Progressive> {
        &self.whole
    }

    /// Triangles of this mesh.
    pub fn triangle_count(&self) -> usize {
        self.triangles
    }

    /// Vertices of this mesh.
    pub fn vertex_count(&self) -> usize {
        self.vertices
    }

    /// The mesh this is, or was before it was made for a view.
    pub fn cut(&self) -> Cut {
        self.cut
    }

    /// The mesh this is, by its splits.
    pub fn front(&self) -> Front {
        if !self.is_mixed {
            return Front::Cut(self.cut);
        }
        Front::View(ViewSplits((0..self.there.word_count() as u32).map(|word| self.there.word(word)).collect()))
    }

    /// Becomes the mesh of a front. Fails if that has splits that stand on others which it has not; the mesh is coarser then.
    pub(crate) fn adapt_front(&mut self, context: &Context, front: &Front) -> Result<()> {
        match front {
            Front::Cut(cut) => _ = self.adapt(context, *cut),
            Front::View(_) => {
                // Whatever is made there is made in order.
                self.adapt(context, Cut::BASE);
                self.is_mixed = true;
                let has = |key, split| front.has(key, split);
                let made = context.within(|| self.refine(context, has, Self::stands));
                made.ok_or_else(|| Error::invalid("these are no splits of a mesh"))?;
            }
        }
        Ok(())
    }

    /// What `work` makes of the finest mesh. Then it is the mesh again that it was before.
    pub(crate) fn at_finest<T>(&mut self, context: &Context, work: impl FnOnce(&mut Self) -> T) -> T {
        let (front, cut) = (self.front(), self.cut);
        self.adapt(context, Cut::FINEST);
        let made = work(self);
        self.return_to(context, &front, cut);
        made
    }

    /// Becomes a mesh again that it was, with its cut.
    pub(crate) fn return_to(&mut self, context: &Context, front: &Front, cut: Cut) {
        match front {
            Front::Cut(cut) => _ = self.adapt(context, *cut),
            Front::View(_) => {
                self.take_back(context, front);
                self.make_again(context, front);
                (self.cut, self.is_mixed) = (cut, true);
            }
        }
    }

    /// Takes back the splits that a front has not.
    pub(crate) fn take_back(&mut self, context: &Context, front: &Front) {
        context.within(|| self.coarsen(context, |key, split| front.has(key, split)));
    }

    /// Makes the splits of a front that are not there.
    pub(crate) fn make_again(&mut self, context: &Context, front: &Front) {
        context.within(|| self.refine(context, |key, split| front.has(key, split), |_, _| true));
    }

    /// Becomes another mesh, or the finest that was read. Returns how many splits were made and taken back.
    pub fn adapt(&mut self, context: &Context, cut: Cut) -> [usize; 2] {
        let cut = cut.max(self.whole.floor);
        let (finer, coarser) = (self.is_mixed || cut < self.cut, self.is_mixed || cut > self.cut);
        (self.cut, self.is_mixed) = (cut, false);
        context.within(|| match self.far(context) {
            Some(far) => self.jump(context, far),
            None => self.walk(context, finer, coarser),
        })
    }

    /// Becomes the mesh of its cut, split by split, where there are splits to be made or taken back.
    pub(super) fn walk(&mut self, context: &Context, finer: bool, coarser: bool) -> [usize; 2] {
        let cut = self.cut;
        let has = |key, split| cut.has(key, split);
        let splits = if finer { self.refine(context, has, |_, _| true).unwrap_or(0) } else { 0 };
        [splits, if coarser { self.coarsen(context, has) } else { 0 }]
    }

    /// Becomes the finest mesh, and tells whether on that way every split comes after those it stands on.
    pub(crate) fn is_sound(&mut self, context: &Context) -> bool {
        self.cut = self.whole.floor;
        context.within(|| self.refine(context, |_, _| true, Self::stands).is_some())
    }

    /// As [`Self::is_sound`], of a mesh that has all splits but these.
    pub(crate) fn is_sound_with(&mut self, context: &Context, splits: &[u32]) -> bool {
        self.cut = self.whole.floor;
        let vertices = splits.iter().filter_map(|split| self.vertex_of(self.whole.parent(*split)));
        let mut waiting = Waiting::default();
        vertices.filter_map(|vertex| self.wanted(vertex, |_, _| true)).for_each(|(depth, at)| waiting.add(depth, at));
        context.within(|| self.refine_waiting(context, waiting, |_, _| true, Self::stands).is_some())
    }

    /// What `find` finds among the vertices, in their order. Splits have the numbers of their second vertices.
    pub(crate) fn scan<T: Send>(&self, context: &Context, find: impl Fn(&Self, u32) -> Option<T> + Sync) -> Vec<T> {
        let words = self.there.words();
        let parts = context.map(words.len().div_ceil(CHUNK_LEN), |part| {
            let words = &words[part * CHUNK_LEN..words.len().min((part + 1) * CHUNK_LEN)];
            let vertices = words.iter().flat_map(|word| self.there.numbers(*word));
            vertices.filter_map(|vertex| find(self, vertex)).collect::<Vec<_>>()
        });
        parts.into_iter().flatten().collect()
    }

    /// Makes the splits that `has` names, which stand on no others, or some of them if `check` finds a vertex that must not
    /// be split.
    fn refine(
        &mut self,
        context: &Context,
        has: impl Fn(Key, u32) -> bool + Sync,
        check: impl Fn(&Self, u32) -> bool + Sync,
    ) -> Option<usize> {
        let mut waiting = Waiting::default();
        let found = self.scan(context, |mesh, vertex| mesh.wanted(vertex, &has));
        found.into_iter().for_each(|(depth, vertex)| waiting.add(depth, vertex));
        self.refine_waiting(context, waiting, has, check)
    }

    /// As [`Self::refine`], where it is known which vertices are split first.
    fn refine_waiting(
        &mut self,
        context: &Context,
        mut waiting: Waiting,
        has: impl Fn(Key, u32) -> bool + Sync,
        check: impl Fn(&Self, u32) -> bool + Sync,
    ) -> Option<usize> {
        let wanted = |mesh: &Self, vertex: u32| mesh.wanted(vertex, &has);
        let mut splits = 0;
        for depth in (0..waiting.0.len()).rev() {
            let vertices = std::mem::take(&mut waiting.0[depth]);
            let mesh = &*self;
            let may = |part: usize| batch(&vertices, part).iter().all(|vertex| check(mesh, *vertex));
            if !context.map(vertices.len().div_ceil(BATCH), may).into_iter().all(|may| may) {
                return None;
            }
            splits += vertices.len();
            let next = self.make(context, &vertices, wanted);
            next.into_iter().for_each(|(depth, vertex)| waiting.add(depth, vertex));
        }
        Some(splits)
    }

    /// Splits vertices that share no edge. Returns what `find` finds among those they become.
    pub(crate) fn make<T: Send>(
        &mut self,
        context: &Context,
        vertices: &[u32],
        find: impl Fn(&Self, u32) -> Option<T> + Sync,
    ) -> Vec<T> {
        self.blocks.clear();
        let mesh = &*self;
        let made = context.map(vertices.len().div_ceil(BATCH), |part| {
            let batch = batch(vertices, part);
            let (mut next, mut triangles) = (Vec::with_capacity(2 * batch.len()), 0);
            let mut refining = mesh.moves.as_ref().map(|moves| Refining::new(mesh, moves));
            for (index, vertex) in batch.iter().enumerate() {
                mesh.ask_ahead(batch, index);
                let before = refining.as_mut().and_then(|moves| moves.before(*vertex));
                let (second, made) = mesh.split(*vertex);
                if let Some((refining, before)) = refining.as_mut().zip(before) {
                    refining.split(before, [*vertex, second]);
                }
                next.extend([*vertex, second].into_iter().filter_map(|vertex| find(mesh, vertex)));
                triangles += made;
            }
            (next, triangles, refining.map(|refining| refining.placed))
        });
        self.vertices += vertices.len();
        if let Some(places) = &mut self.places {
            let split_of = |vertex: &u32| self.slots[*vertex as usize].node.load(Relaxed) / 2;
            places.note_splits(vertices.iter().map(|vertex| [split_of(vertex), *vertex]));
        }
        if let Some(moves) = &mut self.moves {
            moves.stars.note_splits();
        }
        let mut all = Vec::new();
        for (next, triangles, placed) in made {
            self.triangles += triangles;
            if let Some((moves, placed)) = self.moves.as_mut().zip(placed) {
                placed.into_iter().for_each(|(node, place)| _ = moves.places.set(node, place));
            }
            all.extend(next);
        }
        all
    }

    /// The depth of the split that is next at a vertex, and the vertex, if that split is one that `has` names.
    #[inline(always)]
    fn wanted(&self, vertex: u32, has: impl Fn(Key, u32) -> bool) -> Option<(u32, u32)> {
        let Some(Child::Split(split)) = self.child(vertex) else { return None };
        let key = self.whole.splits[split as usize].key;
        (key.depth() > 0 && has(key, split)).then(|| (key.depth(), vertex))
    }

    /// Takes back all splits but the ones that `has` names.
    fn coarsen(&mut self, context: &Context, has: impl Fn(Key, u32) -> bool + Sync) -> usize {
        let unwanted = |mesh: &Self, split: u32| mesh.unwanted(split, &has);
        let mut waiting = Waiting::default();
        self.scan(context, unwanted).into_iter().for_each(|(depth, split)| waiting.add(depth, split));
        let (mut splits, mut depth) = (0, 0);
        while depth < waiting.0.len() {
            let mut list = std::mem::take(&mut waiting.0[depth]);
            // Both vertices of a split may have told that it can be taken back.
            list.sort_unstable();
            list.dedup();
            splits += list.len();
            let next = self.unmake(context, &list, unwanted);
            next.into_iter().for_each(|(depth, split)| waiting.add(depth, split));
            depth += 1;
        }
        splits
    }

    /// Takes splits back whose vertices share no edge. Returns what `find` finds among the splits that they were made
    /// on; one split may be found twice.
    pub(super) fn unmake<T: Send>(
        &mut self,
        context: &Context,
        splits: &[u32],
        find: impl Fn(&Self, u32) -> Option<T> + Sync,
    ) -> Vec<T> {
        self.round += 1;
        self.blocks.clear();
        if let Some(mut places) = self.places.take() {
            places.note_splits(splits.iter().map(|split| [*split, self.target(*split)]));
            self.places = Some(places);
        }
        let mesh = &*self;
        let parts = splits.len().div_ceil(BATCH);
        let gone = context.map(parts, |part| batch(splits, part).iter().map(|split| mesh.merge(*split)).sum::<usize>());
        let next = context.map(parts, |part| {
            let found = batch(splits, part).iter().filter_map(|split| find(mesh, mesh.finish_merge(*split)));
            found.collect::<Vec<_>>()
        });
        self.vertices -= splits.len();
        self.triangles -= gone.into_iter().sum::<usize>();
        next.into_iter().flatten().collect()
    }

    /// Whether a split is made, and its vertices are not split further.
    #[inline(always)]
    pub(crate) fn is_whole(&self, split: u32) -> bool {
        let target = self.slots[split as usize].target.load(Relaxed);
        target != NONE
            && self.slots[split as usize].node.load(Relaxed) == 2 * split + 1
            && self.slots[target as usize].node.load(Relaxed) == 2 * split
    }

    /// The depth of a split and the split, if it is whole and none that `has` names.
    #[inline(always)]
    fn unwanted(&self, split: u32, has: impl Fn(Key, u32) -> bool) -> Option<(u32, u32)> {
        let key = self.whole.splits[split as usize].key;
        (self.is_whole(split) && !has(key, split)).then(|| (key.depth(), split))
    }

    /// The key of the split that a vertex comes from, or none of a base vertex.
    pub(super) fn made_by(&self, vertex: u32) -> Option<Key> {
        let split = self.slots[vertex as usize].node.load(Relaxed) / 2;
        let key = self.whole.splits[split as usize].key;
        (key.depth() > 0).then_some(key)
    }

    /// Where the vertex was that a split has split.
    pub(crate) fn before_split(&self, split: u32) -> Place {
        let built = || self.whole.place(Child::Split(split), split);
        self.moves.as_ref().and_then(|moves| moves.place(self.whole.parent(split))).unwrap_or_else(built)
    }

    /// Vertices of this mesh.
    pub(crate) fn vertices(&self) -> impl Iterator<Item = u32> {
        self.there.iter()
    }

    /// Where a vertex is now.
    pub(crate) fn place(&self, vertex: u32, child: Child) -> Place {
        let moved = self.moves.as_ref().and_then(|moves| moves.place(self.node(vertex)));
        moved.unwrap_or_else(|| self.whole.place(child, vertex))
    }

    /// Where a vertex was built.
    pub(crate) fn built(&self, vertex: u32) -> Place {
        self.child(vertex).map_or_else(Place::default, |child| self.whole.place(child, vertex))
    }

    /// Twice the number of the split that a vertex comes from, and 1 if it is the second, or [`NONE`] if it is not there.
    #[inline(always)]
    pub(crate) fn node(&self, vertex: u32) -> u32 {
        self.slots[vertex as usize].node.load(Relaxed)
    }

    pub(crate) fn child(&self, vertex: u32) -> Option<Child> {
        let node = self.node(vertex);
        (node != NONE).then(|| self.whole.child(node))
    }

    /// The mesh as lists.
    pub fn extract(&self) -> Extract {
        let whole = &self.whole;
        let mut order: Vec<(u32, Child)> =
            self.vertices().filter_map(|vertex| Some((vertex, self.child(vertex)?))).collect();
        if order.len() == whole.vertex_count() {
            order.sort_unstable_by_key(|(_, child)| match child {
                Child::Leaf(number) | Child::Split(number) => *number,
            });
        }
        let mut made = Extract::default();
        let mut numbers = vec![NONE; whole.vertex_count()];
        for (vertex, child) in order {
            let place = self.place(vertex, child);
            numbers[vertex as usize] = made.points.len() as u32;
            made.points.push(place.point.to_array());
            made.normals.push(place.normal.to_array());
        }
        let mut faces = vec![NONE; whole.triangle_count()];
        for face in (0..whole.faces.len() as u32).filter(|face| self.has_face(*face)) {
            faces[whole.face_id(face) as usize] = face;
        }
        faces.retain(|face| *face != NONE);
        made.triangles = faces.iter().map(|face| self.face(*face).map(|vertex| numbers[vertex as usize])).collect();
        self.extract_wedges(&faces, &mut made);
        made
    }
}

/// What one task has of a list.
fn batch(list: &[u32], part: usize) -> &[u32] {
    &list[part * BATCH..list.len().min((part + 1) * BATCH)]
}

/// Splits or vertices by depth.
#[derive(Default)]
pub struct Waiting(pub Vec<Vec<u32>>);

impl Waiting {
    /// Adds one of a depth.
    pub fn add(&mut self, depth: u32, number: u32) {
        let depth = depth as usize;
        if depth >= self.0.len() {
            self.0.resize_with(depth + 1, Vec::new);
        }
        self.0[depth].push(number);
    }
}
