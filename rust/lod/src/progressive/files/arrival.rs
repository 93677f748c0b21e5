//! Progressive meshes that arrive piece by piece, as over a network, and meshes of them that become finer while more comes.

use std::sync::Arc;

use relievo_core::{Context, Error, Result};

use super::format::damaged;
use super::reading::{Reading, unsound};
use crate::progressive::build::hierarchy::Progressive;
use crate::progressive::mesh::active::ActiveMesh;

/// A progressive mesh whose file arrives piece by piece ([`file`](mod@super::file)). As soon as the base has arrived there is
/// a progressive mesh of what is there; its finest mesh is that of the whole file with as many splits.
pub struct Arrival {
    reading: Reading,
    /// Bytes of a part that is not complete yet.
    waiting: Vec<u8>,
    /// What has arrived, with the finest mesh of it: every split has to be one that can be made.
    finest: Option<ActiveMesh>,
    is_refused: bool,
}

impl Arrival {
    /// Nothing yet. What it takes is held against the context's memory limit, as in [`Progressive::read`].
    pub fn new(context: &Context) -> Self {
        Self { reading: Reading::new(context), waiting: Vec::new(), finest: None, is_refused: false }
    }

    /// Takes the next bytes of the file, however many. Returns how many triangles the finest mesh has that is there, 0
    /// before the base is. Bytes after the end of the file are not looked at.
    ///
    /// # Errors
    /// Fails as [`Progressive::read`], and after an earlier failure; nothing is there then, nor taken any more, and
    /// meshes in use stay as they are.
    pub fn push(&mut self, context: &Context, bytes: &[u8]) -> Result<usize> {
        if self.is_refused {
            return Err(damaged("what came before was refused"));
        }
        let taken = self.take(context, bytes);
        if taken.is_err() {
            (self.is_refused, self.finest, self.waiting) = (true, None, Vec::new());
        }
        taken.map(|()| self.finest.as_ref().map_or(0, ActiveMesh::triangle_count))
    }

    fn take(&mut self, context: &Context, mut bytes: &[u8]) -> Result<()> {
        while !self.reading.is_complete() {
            let more = self.reading.needs(&self.waiting)?.saturating_sub(self.waiting.len());
            let (now, later) = bytes.split_at(more.min(bytes.len()));
            self.waiting.extend_from_slice(now);
            bytes = later;
            if now.len() < more {
                return Ok(());
            }
            // The head of a chunk tells of more.
            if self.reading.needs(&self.waiting)? == self.waiting.len() {
                let part = std::mem::take(&mut self.waiting);
                self.part(context, &part)?;
            }
        }
        Ok(())
    }

    /// Takes in a part that is complete.
    fn part(&mut self, context: &Context, mut bytes: &[u8]) -> Result<()> {
        let Some(finest) = &mut self.finest else {
            let mut made = None;
            self.reading.part(&mut bytes, &mut made)?;
            self.finest = made.map(|mesh| ActiveMesh::new(&Arc::new(mesh)));
            return Ok(());
        };
        // Meshes in use keep what they have: it is copied once for all that comes until the next of them takes it up.
        self.reading.splits(&mut bytes, Arc::make_mut(&mut finest.whole))?;
        let splits = self.reading.last_splits();
        finest.take_leaves(splits.iter().flat_map(|split| [2 * split, 2 * split + 1]));
        if finest.is_sound_with(context, splits) { Ok(()) } else { Err(unsound()) }
    }

    /// The progressive mesh of what has arrived, if that is the base or more. It does not change when more does: a mesh of it
    /// goes on by [`ActiveMesh::take_up`] with one that is asked for later.
    pub fn mesh(&self) -> Option<&Arc<Progressive>> {
        self.finest.as_ref().map(|finest| &finest.whole)
    }

    /// Whether all has arrived.
    pub fn is_complete(&self) -> bool {
        self.reading.is_complete() && !self.is_refused
    }
}

impl ActiveMesh {
    /// Goes on as a mesh of a progressive mesh of which more has arrived ([`Arrival::mesh`]). It has the splits it had,
    /// and its edits; what is finer can be made from now on.
    ///
    /// # Errors
    /// Fails, and changes nothing, if `whole` is of another progressive mesh, or less of it has arrived.
    pub fn take_up(&mut self, whole: &Arc<Progressive>) -> Result<()> {
        if !self.whole.is_beginning_of(whole) {
            return Err(Error::invalid("it is another progressive mesh, or less of it has arrived")
                .advise("take up the one that this is a mesh of"));
        }
        self.whole = whole.clone();
        self.take_leaves(0..self.whole.faces.len() as u32);
        Ok(())
    }

    /// Takes the leaves of triangles over.
    fn take_leaves(&mut self, faces: impl Iterator<Item = u32>) {
        for face in faces {
            for (corner, leaf) in (3 * face as usize..).zip(self.whole.faces[face as usize]) {
                self.corners[corner].leaf = leaf;
            }
        }
    }
}

impl Progressive {
    /// Whether another one has all that this has.
    fn is_beginning_of(&self, other: &Self) -> bool {
        let is_same = |split: u32| {
            let place = split as usize;
            let faces = [2 * place, 2 * place + 1];
            let [own, theirs] = [self, other].map(|mesh| (mesh.splits[place], faces.map(|face| mesh.faces[face])));
            (own.0.key, own.0.children, own.1) == (theirs.0.key, theirs.0.children, theirs.1)
        };
        self.vertex_count() == other.vertex_count()
            && self.faces.len() == other.faces.len()
            && self.base_vertices == other.base_vertices
            && self.base_faces == other.base_faces
            && self.wedge_count() == other.wedge_count()
            && self.splits().all(|(split, ..)| is_same(split))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::progressive::BuildOptions;
    use relievo_core::progress::Silent;

    #[test]
    fn meshes_that_differ_in_one_triangle_of_a_split_are_two() {
        let points: Vec<[f32; 3]> = (0..81u8).map(|k| [k % 9, k / 9, k % 4].map(f32::from)).collect();
        let squares = (0..64).map(|k| k / 8 * 9 + k % 8);
        let triangles: Vec<[u32; 3]> = squares.flat_map(|a| [[a, a + 1, a + 10], [a, a + 10, a + 9]]).collect();
        let options = BuildOptions { faces: 20, ..BuildOptions::default() };
        let mesh = Progressive::build(&Context::serial(), &points, &triangles, &options, &mut Silent).unwrap();
        assert!(mesh.is_beginning_of(&mesh.clone()));
        let (split, ..) = mesh.splits().next().unwrap();
        for face in [2 * split, 2 * split + 1] {
            let mut other = mesh.clone();
            other.faces[face as usize].rotate_left(1);
            other.faces[face as usize][0] ^= 1;
            assert!(!mesh.is_beginning_of(&other), "{face}");
        }
    }
}
