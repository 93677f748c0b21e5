//! What was edited, and how coarser and finer levels follow (Derzapf, Grund, Guthe 2014, Section 4.2).
//!
//! A progressive mesh stays as it was built; the vertices of a mesh that are elsewhere have a place of their own. Where a
//! vertex is split that has moved, or one around it, the two vertices are as far from the vertices around them as they were
//! built, turned as those have turned. Where such a split is taken back, the one vertex returns to where it was, unless
//! one of the two or around them was edited meanwhile: then it goes where the quadrics of the triangles as they are now
//! want it, and where the two would have had to be built is noted, so that to split the vertex again puts them back. Both
//! ways look at the same vertices: those that share an edge with one of the two.

use std::sync::atomic::{AtomicU8, AtomicU32, Ordering::Relaxed};

use glam::{Vec3, Vec4Swizzles};
use relievo_core::Context;

use super::active::ActiveMesh;
use super::hierarchy::Child;
use super::place::{Place, Surroundings};
use crate::connectivity::NONE;
use crate::decimation::normal;
use crate::placement::{BATCH, Batch, Star, place};

/// How far a vertex has moved at least, in extents of the mesh, and how far its normal has turned, that follows others. An
/// influence would otherwise go on from neighbour to neighbour, less at every level, to where no one sees it.
const LEAST_MOVE: f32 = 1e-7;
const LEAST_TURN: f32 = 1e-4;

/// What was edited.
pub struct Moves {
    /// Places of the vertices that have moved, as bits.
    places: Vec<[AtomicU32; 6]>,
    moved: Vec<AtomicU8>,
    /// The last edit that reached a vertex, also through finer ones; 0 for none.
    edited: Vec<AtomicU32>,
    /// Counts edits.
    edits: u32,
    /// Of every split, the number of its note.
    notes_of: Vec<u32>,
    notes: Vec<Note>,
    /// Numbers of notes that are free.
    free: Vec<u32>,
}

/// What is known of a split near an edit.
#[derive(Clone, Copy)]
pub struct Note {
    /// Where its two vertices would have been built, if not where they were.
    built: Option<[Place; 2]>,
    /// Where the one vertex was that was split, if not where it was built, and the last edit that reached it.
    merged: (Option<Place>, u32),
    /// The last edit before the split was made.
    edit: u32,
}

/// What is known of all vertices and splits near edits.
pub struct Snapshot {
    edits: u32,
    places: Vec<(u32, Place, u32)>,
    notes: Vec<(u32, Note)>,
}

impl Snapshot {
    /// Vertices that were not where they were built.
    pub fn moved(&self) -> impl Iterator<Item = u32> {
        self.places.iter().map(|(vertex, ..)| *vertex)
    }
}

/// A split and what is to be known of it from now on.
pub type Noted = (u32, Option<Note>);

impl Moves {
    pub fn new(vertices: usize) -> Self {
        Self {
            places: (0..vertices).map(|_| std::array::from_fn(|_| AtomicU32::new(0))).collect(),
            moved: (0..vertices).map(|_| AtomicU8::new(0)).collect(),
            edited: (0..vertices).map(|_| AtomicU32::new(0)).collect(),
            edits: 0,
            notes_of: vec![NONE; vertices],
            notes: Vec::new(),
            free: Vec::new(),
        }
    }

    fn has_moved(&self, vertex: u32) -> bool {
        self.moved[vertex as usize].load(Relaxed) != 0
    }

    /// Where a vertex is, if it has moved.
    pub fn place(&self, vertex: u32) -> Option<Place> {
        self.has_moved(vertex).then(|| {
            let [x, y, z, i, j, k] = &self.places[vertex as usize];
            let vector = |x: &AtomicU32, y: &AtomicU32, z: &AtomicU32| {
                Vec3::from_array([x, y, z].map(|bits| f32::from_bits(bits.load(Relaxed))))
            };
            Place { point: vector(x, y, z), normal: vector(i, j, k) }
        })
    }

    /// Puts a vertex somewhere, or back where it was built, with the last edit that reached it.
    fn set(&self, vertex: u32, place: Option<Place>, edit: u32) {
        self.moved[vertex as usize].store(place.is_some().into(), Relaxed);
        self.edited[vertex as usize].store(edit, Relaxed);
        if let Some(place) = place {
            let values = place.point.to_array().into_iter().chain(place.normal.to_array());
            for (bits, value) in self.places[vertex as usize].iter().zip(values) {
                bits.store(value.to_bits(), Relaxed);
            }
        }
    }

    /// Puts vertices where an edit wants them.
    pub fn edit(&mut self, places: &[(u32, Place)]) {
        self.edits += 1;
        places.iter().for_each(|(vertex, place)| self.set(*vertex, Some(*place), self.edits));
    }

    /// Where the vertex was that a split has split, if not where it was built.
    pub fn merged(&self, split: u32) -> Option<Place> {
        self.note(split).and_then(|note| note.merged.0)
    }

    /// All that is known.
    pub fn snapshot(&self) -> Snapshot {
        let vertices = 0..self.moved.len() as u32;
        let places = vertices.clone().filter_map(|vertex| Some((vertex, self.place(vertex)?, self.edited(vertex))));
        let notes = vertices.filter_map(|split| Some((split, *self.note(split)?)));
        Snapshot { edits: self.edits, places: places.collect(), notes: notes.collect() }
    }

    /// Of a mesh with so many vertices, all that was known.
    pub fn of_snapshot(vertices: usize, snapshot: &Snapshot) -> Self {
        let mut made = Self { edits: snapshot.edits, ..Self::new(vertices) };
        snapshot.places.iter().for_each(|(vertex, place, edit)| made.set(*vertex, Some(*place), *edit));
        made.keep(snapshot.notes.iter().map(|(split, note)| (*split, Some(*note))).collect());
        made
    }

    fn edited(&self, vertex: u32) -> u32 {
        self.edited[vertex as usize].load(Relaxed)
    }

    fn note(&self, split: u32) -> Option<&Note> {
        self.notes.get(self.notes_of[split as usize] as usize)
    }

    /// Takes notes of splits that were made or taken back.
    pub fn keep(&mut self, noted: Vec<Noted>) {
        for (split, note) in noted {
            let number = &mut self.notes_of[split as usize];
            match note {
                Some(note) if *number != NONE => self.notes[*number as usize] = note,
                Some(note) => match self.free.pop() {
                    Some(free) => {
                        *number = free;
                        self.notes[free as usize] = note;
                    }
                    None => {
                        *number = self.notes.len() as u32;
                        self.notes.push(note);
                    }
                },
                None if *number != NONE => self.free.push(std::mem::replace(number, NONE)),
                None => {}
            }
        }
    }
}

/// A vertex as built and as it is now.
fn places(mesh: &ActiveMesh, moves: &Moves, vertex: u32) -> [Place; 2] {
    let built = mesh.built(vertex);
    [built, moves.place(vertex).unwrap_or(built)]
}

/// The vertices that share an edge with `vertex`, but for one, in their order.
fn ring(mesh: &ActiveMesh, vertex: u32, without: u32, ring: &mut Vec<u32>) {
    ring.clear();
    ring.extend(mesh.spokes(vertex).flatten().filter(|other| *other != without && *other != vertex));
    ring.sort_unstable();
    ring.dedup();
}

/// What is needed to make splits.
pub struct Refining<'a> {
    mesh: &'a ActiveMesh,
    moves: &'a Moves,
    least: f32,
    ring: Vec<u32>,
    neighbours: Vec<[Place; 2]>,
    /// Splits near an edit, with their notes.
    pub noted: Vec<Noted>,
}

impl<'a> Refining<'a> {
    pub fn new(mesh: &'a ActiveMesh, moves: &'a Moves) -> Self {
        let least = LEAST_MOVE / mesh.whole.scale();
        Self { mesh, moves, least, ring: Vec::new(), neighbours: Vec::new(), noted: Vec::new() }
    }

    /// A vertex that is to be split, if that or one around has moved.
    pub fn before(&mut self, vertex: u32) -> Option<[Place; 2]> {
        let is_near = self.moves.has_moved(vertex)
            || self.mesh.spokes(vertex).flatten().any(|other| self.moves.has_moved(other))
            || matches!(self.mesh.child(vertex), Some(Child::Split(split)) if self.moves.note(split).is_some());
        if !is_near {
            return None;
        }
        if let Some(Child::Split(split)) = self.mesh.child(vertex) {
            let built = self.moves.note(split).and_then(|note| note.built);
            let merged = (self.moves.place(vertex), self.moves.edited(vertex));
            self.noted.push((split, Some(Note { built, merged, edit: self.moves.edits })));
        }
        Some(places(self.mesh, self.moves, vertex))
    }

    /// Puts the two vertices of a split where they belong.
    pub fn split(&mut self, before: [Place; 2], ends: [u32; 2]) {
        let made = [0, 1].map(|side| {
            let around =
                surroundings(self.mesh, self.moves, (ends, side), before, &mut self.ring, &mut self.neighbours);
            let built = self.mesh.built(ends[side]);
            let noted = self.moves.note(ends[1]).and_then(|note| note.built);
            around.forward(noted.map_or(built, |places| places[side]))
        });
        for (end, place) in ends.into_iter().zip(made) {
            let built = self.mesh.built(end);
            let is_elsewhere = place.point.distance_squared(built.point) > self.least * self.least
                || place.normal.distance_squared(built.normal) > LEAST_TURN * LEAST_TURN;
            self.moves.set(end, is_elsewhere.then_some(place), 0);
        }
    }
}

/// The surroundings of one of the two vertices of a split, whose one vertex is at `vertex`.
fn surroundings(
    mesh: &ActiveMesh,
    moves: &Moves,
    (ends, side): ([u32; 2], usize),
    vertex: [Place; 2],
    around: &mut Vec<u32>,
    neighbours: &mut Vec<[Place; 2]>,
) -> Surroundings {
    ring(mesh, ends[side], ends[1 - side], around);
    neighbours.clear();
    neighbours.extend(around.iter().map(|other| places(mesh, moves, *other)));
    Surroundings::new(vertex, neighbours)
}

/// What is needed to take splits back.
pub struct Coarsening<'a> {
    context: &'a Context,
    mesh: &'a ActiveMesh,
    moves: &'a Moves,
    scale: f32,
    batch: Batch,
    /// Splits of the batch, with their two vertices.
    splits: Vec<[u32; 2]>,
    around: Vec<u32>,
    neighbours: Vec<[Place; 2]>,
    noted: Vec<Noted>,
}

impl<'a> Coarsening<'a> {
    pub fn new(context: &'a Context, mesh: &'a ActiveMesh, moves: &'a Moves) -> Self {
        Self {
            context,
            mesh,
            moves,
            scale: mesh.whole.scale(),
            batch: Batch::default(),
            splits: Vec::with_capacity(BATCH),
            around: Vec::new(),
            neighbours: Vec::new(),
            noted: Vec::new(),
        }
    }

    /// Puts the one vertex of each split, which is about to be taken back, where it belongs.
    pub fn merge(mut self, splits: &[u32]) -> Vec<Noted> {
        for split in splits {
            let ends = [self.mesh.target(*split), *split];
            let note = self.moves.note(*split).copied();
            let since = note.map_or(0, |note| note.edit);
            if self.near(ends).any(|vertex| self.moves.edited(vertex) > since) {
                self.gather(ends);
                self.splits.push(ends);
                if self.splits.len() == BATCH {
                    self.finish();
                }
            } else {
                let (place, edit) = note.map_or((None, 0), |note| note.merged);
                self.moves.set(ends[1], None, 0);
                self.moves.set(ends[0], place, edit);
                self.noted.push((*split, note.filter(|note| note.built.is_some())));
            }
        }
        self.finish();
        self.noted
    }

    /// The two vertices of a split and those around them.
    fn near(&self, ends: [u32; 2]) -> impl Iterator<Item = u32> {
        ends.into_iter().chain(ends.into_iter().flat_map(|end| self.mesh.spokes(end).flatten()))
    }

    fn point(&self, vertex: u32) -> Vec3 {
        self.moves.place(vertex).unwrap_or_else(|| self.mesh.built(vertex)).point
    }

    /// The normal of a triangle at a vertex, as simplification weighs it.
    fn normal(&self, here: Vec3, [after, before]: [u32; 2]) -> Vec3 {
        normal((self.point(after) - here) * self.scale, (self.point(before) - here) * self.scale).xyz()
    }

    /// What a vertex knows of its triangles and borders.
    fn star(&mut self, vertex: u32) -> Star {
        let here = self.point(vertex);
        let mut star = [0.0; 9];
        let mut add = |normal: Vec3, share: f32| {
            let [x, y, z] = normal.to_array();
            for (entry, value) in star.iter_mut().zip([x * x, y * y, z * z, x * y, x * z, y * z]) {
                *entry += share * value;
            }
        };
        let mut sum = Vec3::ZERO;
        self.around.clear();
        for ends in self.mesh.spokes(vertex) {
            let normal = self.normal(here, ends);
            add(normal, 1.0);
            sum += normal;
            self.around.extend(ends);
        }
        self.around.sort_unstable();
        for run in self.around.chunk_by(|a, b| a == b).filter(|run| run.len() == 1) {
            let along = (self.point(run[0]) - here) * self.scale;
            let length = along.length();
            [Vec3::X, Vec3::Y, Vec3::Z].into_iter().for_each(|axis| add(axis * length, 1.0));
            add(along, -1.0);
        }
        star[6..].copy_from_slice(&sum.to_array());
        star
    }

    /// Puts the edge between the vertices of a split into the batch.
    fn gather(&mut self, ends: [u32; 2]) {
        let lane = self.splits.len();
        let stars = ends.map(|end| self.star(end));
        for (side, star) in stars.iter().enumerate() {
            for (entry, value) in star.iter().enumerate() {
                self.batch.star[side][entry][lane] = *value;
            }
        }
        let [start, end] = ends.map(|end| self.point(end));
        let mut sides = [Vec3::ZERO; 2];
        let mut count = 0;
        for spoke in self.mesh.spokes(ends[0]).filter(|spoke| spoke.contains(&ends[1])) {
            if let Some(side) = sides.get_mut(count) {
                *side = self.normal(start, spoke);
                count += 1;
            }
        }
        let edge = (end - start) * self.scale;
        for axis in 0..3 {
            self.batch.edge[axis][lane] = edge[axis];
            self.batch.side[0][axis][lane] = sides[0][axis];
            self.batch.side[1][axis][lane] = sides[1][axis];
        }
        // A vertex that stayed when the mesh was built still does.
        let whole = &self.mesh.whole;
        let built = whole.place(Child::Split(ends[1]), NONE).point;
        let [stays, goes] = ends.map(|end| self.mesh.built(end).point == built);
        self.batch.pinned[lane] = if stays { -1.0 } else { f32::from(u8::from(goes)) };
        self.batch.open[lane] = f32::from(u8::from(count == 1));
        self.batch.before[lane] = 0.0;
    }

    fn finish(&mut self) {
        if self.splits.is_empty() {
            return;
        }
        place(self.context.level(), &mut self.batch);
        let (mesh, moves) = (self.mesh, self.moves);
        for (lane, ends) in std::mem::take(&mut self.splits).into_iter().enumerate() {
            let [start, end] = ends.map(|end| self.point(end));
            let [x, y, z] = self.batch.place;
            let offset = Vec3::new(x[lane], y[lane], z[lane]) / self.scale;
            let point = match self.batch.pinned[lane] {
                pinned if pinned < 0.0 => start,
                pinned if pinned > 0.0 => end,
                _ => 0.5 * (start + end) + offset,
            };
            let triangles = [0, 1]
                .into_iter()
                .flat_map(|side| mesh.spokes(ends[side]).filter(move |spoke| !spoke.contains(&ends[1 - side])));
            let sum: Vec3 = triangles.map(|spoke| self.normal(point, spoke)).sum();
            let built = mesh.whole.place(Child::Split(ends[1]), NONE);
            let now = Place { point, normal: sum.try_normalize().unwrap_or(built.normal) };
            let built = [0, 1].map(|side| {
                let around =
                    surroundings(mesh, moves, (ends, side), [built, now], &mut self.around, &mut self.neighbours);
                around.back(places(mesh, moves, ends[side])[1])
            });
            let edit = self.near(ends).map(|vertex| moves.edited(vertex)).max().unwrap_or(0);
            self.noted.push((ends[1], Some(Note { built: Some(built), merged: (None, 0), edit: 0 })));
            moves.set(ends[1], None, 0);
            moves.set(ends[0], Some(now), edit);
        }
    }
}
