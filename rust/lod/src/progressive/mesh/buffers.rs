//! A mesh in its user's buffers, in place: vertices and triangles keep their places for as long as they are there, the
//! places are without gaps, and what is written is what has changed.

use std::ops::Range;
use std::sync::atomic::Ordering::Relaxed;

use super::active::{ActiveMesh, Extract};
use super::buffer_places::Places;
use crate::connectivity::NONE;
use crate::progressive::edit::turning::Turning;

/// What vertices and triangles are written to.
pub trait Buffers {
    /// Puts a vertex at a place: its point, and its normal of length 1, or 0 without triangles.
    fn set_vertex(&mut self, place: usize, point: [f32; 3], normal: [f32; 3]);

    /// Puts a triangle at a place: the places of its vertices.
    fn set_triangle(&mut self, place: usize, vertices: [u32; 3]);

    /// Puts a wedge at a place: its numbers, as [`Extract::values`].
    fn set_wedge(&mut self, _place: usize, _values: &[f32]) {}

    /// Puts attributes of a triangle at its place: the places of its wedges, and its numbers as [`Extract::face_values`].
    fn set_corners(&mut self, _place: usize, _wedges: [u32; 3], _values: &[u32]) {}
}

/// What an update has left in buffers.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Update {
    /// Vertices, from place 0 on.
    pub vertices: usize,
    /// Triangles, from place 0 on.
    pub triangles: usize,
    /// Places of the vertices that were written, as [`Marks::take`](relievo_core::Marks::take) lists them.
    pub changed_vertices: Vec<Range<u32>>,
    /// The same of triangles.
    pub changed_triangles: Vec<Range<u32>>,
    /// Places of wedges, from place 0 on; some may be free.
    pub wedges: usize,
    /// The same of wedges.
    pub changed_wedges: Vec<Range<u32>>,
}

impl ActiveMesh {
    /// Writes to `buffers` what has changed of the mesh since the last time, or all of it if `is_whole` or there was no
    /// time before. There has to be room for as many vertices and triangles as the mesh has now.
    pub fn update(&mut self, buffers: &mut impl Buffers, is_whole: bool) -> Update {
        let [count, faces] = [self.slots.len(), self.corners.len() / 3];
        let wedges = self.whole.wedges.as_ref().map_or(0, |wedges| wedges.count());
        let mut places = self.places.take().unwrap_or_else(|| Places::new(count, faces, wedges));
        if is_whole || places.is_whole {
            self.place_all(&mut places);
        } else {
            self.place_changed(&mut places);
        }
        places.is_whole = false;
        let mut update = Update {
            vertices: places.vertices.items.len(),
            triangles: places.triangles.items.len(),
            wedges: places.wedges.items.len(),
            ..Update::default()
        };
        for (place, vertex) in places.vertices.take_written() {
            let Some(child) = self.child(vertex) else { continue };
            let found = self.place(vertex, child);
            buffers.set_vertex(place as usize, found.point.to_array(), found.normal.to_array());
            places.vertices.marks.mark(place as usize);
        }
        for (place, face) in places.triangles.take_written() {
            let vertices = self.face(face).map(|vertex| places.vertices.places[vertex as usize]);
            buffers.set_triangle(place as usize, vertices);
            if let Some((wedges, values)) = self.wedges_of(face) {
                let wedges = wedges.map(|wedge| places.wedges.places[wedge as usize]);
                buffers.set_corners(place as usize, wedges, values);
            }
            places.triangles.marks.mark(place as usize);
        }
        let mut turning = Turning::new(self);
        for (place, wedge) in places.wedges.take_written().into_iter().filter(|(place, _)| *place != NONE) {
            let Some(values) = turning.values_of(wedge) else { continue };
            buffers.set_wedge(place as usize, values);
            places.wedges.marks.mark(place as usize);
        }
        places.vertices.marks.take(&mut update.changed_vertices);
        places.triangles.marks.take(&mut update.changed_triangles);
        places.wedges.marks.take(&mut update.changed_wedges);
        self.places = Some(places);
        update
    }

    /// Notes vertices that are elsewhere, for the next update and the next edit.
    pub(crate) fn note_moved(&mut self, vertices: impl Iterator<Item = u32> + Clone) {
        vertices.clone().for_each(|vertex| self.blocks.note(vertex));
        if let Some(places) = &mut self.places {
            places.note_moved(vertices);
        }
    }

    fn place_all(&self, places: &mut Places) {
        places.splits.clear();
        places.moved.clear();
        places.vertices.clear();
        places.triangles.clear();
        places.wedges.clear();
        self.wedges().for_each(|wedge| places.wedges.add(wedge));
        self.vertices().for_each(|vertex| places.vertices.add(vertex));
        let faces = 0..self.corners.len() as u32 / 3;
        faces.filter(|face| self.has_face(*face)).for_each(|face| places.triangles.add(face));
    }

    fn place_changed(&self, places: &mut Places) {
        let splits = std::mem::take(&mut places.splits);
        let is_there = |vertex: u32| self.child(vertex).is_some();
        let faces = |split: u32| [2 * split, 2 * split + 1];
        // What is gone leaves its place to what is new.
        for [split, _] in &splits {
            if !is_there(*split) {
                places.vertices.remove(*split);
            }
            faces(*split)
                .into_iter()
                .filter(|face| !self.has_face(*face))
                .for_each(|face| places.triangles.remove(face));
        }
        for [split, vertex] in &splits {
            for vertex in [*split, *vertex].into_iter().filter(|vertex| is_there(*vertex)) {
                places.vertices.add(vertex);
            }
            faces(*split).into_iter().filter(|face| self.has_face(*face)).for_each(|face| places.triangles.add(face));
        }
        // Triangles around the two vertices of a split may have been given from one to the other. What is around comes in
        // no order that could give places.
        for vertex in splits.iter().flatten().filter(|vertex| is_there(**vertex)) {
            self.faces_at(*vertex).for_each(|face| places.triangles.write(face));
        }
        let parts: Vec<u32> = splits.iter().flat_map(|[split, _]| self.parts_of(*split)).collect();
        parts.iter().filter(|wedge| !self.is_wedge(**wedge)).for_each(|wedge| places.wedges.remove(*wedge));
        for wedge in parts {
            if self.is_wedge(wedge) {
                places.wedges.add(wedge);
            }
            // What the one before has, up to this one, is other than it was.
            if let Some(before) = self.wedge_before(wedge) {
                places.wedges.write(before);
            }
        }
        let moved: Vec<u32> = places.moved.drain(..).filter(|vertex| is_there(*vertex)).collect();
        moved.iter().for_each(|vertex| places.vertices.write(*vertex));
        let changed = splits.iter().flatten().filter(|vertex| is_there(**vertex)).chain(&moved);
        self.turned_by(changed.copied()).into_iter().for_each(|wedge| places.wedges.write(wedge));
        for vertex in places.vertices.close() {
            places.vertices.write(vertex);
            self.faces_at(vertex).for_each(|face| places.triangles.write(face));
        }
        for face in places.triangles.close() {
            places.triangles.write(face);
        }
    }

    pub(super) fn has_face(&self, face: u32) -> bool {
        self.corners[3 * face as usize].vertex.load(Relaxed) != NONE
    }

    /// The vertices of a triangle.
    pub(crate) fn face(&self, face: u32) -> [u32; 3] {
        [0, 1, 2].map(|side| self.corners[3 * face as usize + side].vertex.load(Relaxed))
    }
}

impl Buffers for Extract {
    fn set_vertex(&mut self, place: usize, point: [f32; 3], normal: [f32; 3]) {
        if place >= self.points.len() {
            self.points.resize(place + 1, [0.0; 3]);
            self.normals.resize(place + 1, [0.0; 3]);
        }
        (self.points[place], self.normals[place]) = (point, normal);
    }

    fn set_triangle(&mut self, place: usize, vertices: [u32; 3]) {
        if place >= self.triangles.len() {
            self.triangles.resize(place + 1, [0; 3]);
        }
        self.triangles[place] = vertices;
    }

    fn set_wedge(&mut self, place: usize, values: &[f32]) {
        let end = (place + 1) * values.len();
        self.values.resize(self.values.len().max(end), 0.0);
        self.values[end - values.len()..end].copy_from_slice(values);
    }

    fn set_corners(&mut self, place: usize, wedges: [u32; 3], values: &[u32]) {
        if place >= self.wedges.len() {
            self.wedges.resize(place + 1, [0; 3]);
            self.face_values.resize((place + 1) * values.len(), 0);
        }
        self.wedges[place] = wedges;
        self.face_values[place * values.len()..(place + 1) * values.len()].copy_from_slice(values);
    }
}
