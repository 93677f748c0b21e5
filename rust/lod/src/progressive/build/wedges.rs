//! Attributes of a progressive mesh: what its vertices have beside places, in wedges (Hoppe 1998).
//!
//! A vertex has a wedge for each set of values about it. A collapse merges up to two pairs of wedges, so wedges are trees,
//! and they are numbered as vertices are ([`hierarchy`](super::hierarchy)): by their leaves, each a range of them, with the
//! number of the first. A split of a wedge is part of the split of a vertex. Which of them are made says a bit each, the
//! wedge at a corner is the last one up to its leaf, and since trees are the Cartesian trees of their keys, its own
//! number and that of the next wedge say what a wedge comes from: nothing else is kept of a level.

use std::sync::OnceLock;

use relievo_core::budget::Budget;
use relievo_core::{Attribute, Domain, Result};

use super::hierarchy::Progressive;
use super::numbers::Numbers;
use super::recording::{Key, Recording};
use crate::connectivity::NONE;
use crate::progressive::edit::directions::Directions;
use crate::progressive::files::format::damaged;
use crate::progressive::mesh::bitset::BitSet;

/// The wedges of a progressive mesh.
#[derive(Clone)]
pub struct WedgeTrees {
    pub attributes: Vec<Attribute>,
    /// Numbers of a wedge, and of a triangle.
    pub widths: [usize; 2],
    /// Leaves at the corners of triangles, in the places of those.
    pub corners: Vec<[u32; 3]>,
    /// What triangles have, in their places.
    pub faces: Vec<u32>,
    /// The split of a vertex that a wedge's split is part of; [`NONE`] in the place of a base wedge, and where it is not
    /// read yet.
    pub owners: Vec<u32>,
    /// The splits of wedges that the split of a vertex has.
    pub parts: Vec<[u32; 2]>,
    /// What the two wedges of a split have. In the place of a base wedge, what that has comes second.
    pub values: [Vec<f32>; 2],
    pub base: Vec<u32>,
    /// Where directions are among the numbers of a wedge.
    pub directions: Directions,
    /// Found when it is first asked for: see [`Self::home`].
    pub(crate) homes: OnceLock<Vec<u32>>,
}

/// What wedges and triangles of a mesh have that a progressive mesh is built of.
pub struct Wedged {
    /// Without values.
    pub attributes: Vec<Attribute>,
    /// The wedge of each corner.
    pub corners: Vec<[u32; 3]>,
    /// Of every wedge.
    pub values: Vec<f32>,
    /// Of every triangle.
    pub faces: Vec<u32>,
}

impl Wedged {
    /// How many wedges there are.
    pub fn count(&self) -> usize {
        self.corners.as_flattened().iter().max().map_or(0, |last| *last as usize + 1)
    }
}

/// Numbers of a wedge, and of a triangle.
pub fn widths(attributes: &[Attribute]) -> [usize; 2] {
    let sum = |is_face: bool| {
        let chosen = attributes.iter().filter(|attribute| (attribute.domain == Domain::Face) == is_face);
        chosen.map(|attribute| attribute.width as usize).sum()
    };
    [sum(false), sum(true)]
}

impl WedgeTrees {
    /// Of what was recorded while `mesh` was built, whose vertices have the numbers `leaves`.
    pub fn new(wedged: Wedged, recording: &Recording, leaves: &[u32], mesh: &Progressive) -> Result<Self> {
        let count = wedged.count();
        let Wedged { attributes, corners, values: mut current, faces } = wedged;
        let [width, face_width] = widths(&attributes);
        let pairs: Vec<[u32; 2]> = recording.joins.iter().map(|join| join.wedges).collect();
        let numbers = Numbers::new(count, pairs.iter().copied());
        let mut made = Self::empty(attributes, mesh, count, &mut Budget::new(u64::MAX))?;
        let mut after = recording.values.chunks(width.max(1));
        for (join, [kept, gone]) in recording.joins.iter().zip(pairs) {
            let split = numbers.leaves[gone as usize];
            let owner = leaves[recording.operations[join.operation as usize].gone as usize];
            made.own(owner, split);
            for (values, wedge) in made.values.iter_mut().zip([kept, gone].map(|wedge| wedge as usize * width)) {
                let place = split as usize * width;
                values[place..place + width].copy_from_slice(&current[wedge..wedge + width]);
            }
            if let Some(after) = after.next() {
                let place = kept as usize * width;
                current[place..place + width].copy_from_slice(&after[..width]);
            }
        }
        made.base = numbers.base.iter().map(|wedge| numbers.leaves[*wedge as usize]).collect();
        for (wedge, leaf) in numbers.base.iter().zip(&made.base) {
            let [from, to] = [wedge, leaf].map(|number| *number as usize * width);
            made.values[1][to..to + width].copy_from_slice(&current[from..from + width]);
        }
        for place in 0..mesh.faces.len() {
            let id = mesh.face_id(place as u32) as usize;
            if let Some(corners) = corners.get(id) {
                let leaves = corners.map(|wedge| numbers.leaves[wedge as usize]);
                made.set_face(place as u32, leaves, &faces[id * face_width..(id + 1) * face_width]);
            }
        }
        Ok(made)
    }

    /// Room for so many wedges of a mesh whose triangles have their places.
    pub fn empty(attributes: Vec<Attribute>, mesh: &Progressive, count: usize, budget: &mut Budget) -> Result<Self> {
        let [width, face_width] = widths(&attributes);
        Ok(Self {
            directions: Directions::of(&attributes),
            homes: OnceLock::new(),
            attributes,
            widths: [width, face_width],
            corners: budget.filled(mesh.faces.len(), [NONE; 3])?,
            faces: budget.filled(face_width * mesh.faces.len(), 0)?,
            owners: budget.filled(count, NONE)?,
            parts: budget.filled(mesh.splits.len(), [NONE; 2])?,
            values: [budget.filled(width * count, 0.0)?, budget.filled(width * count, 0.0)?],
            base: Vec::new(),
        })
    }

    /// Makes the split of a wedge part of that of a vertex, which has at most one.
    pub fn own(&mut self, owner: u32, split: u32) {
        self.owners[split as usize] = owner;
        let [first, second] = &mut self.parts[owner as usize];
        *if *first == NONE { first } else { second } = split;
    }

    /// Puts what a triangle has in the place of that, which is at the end if it is beyond.
    pub fn set_face(&mut self, place: u32, leaves: [u32; 3], values: &[u32]) {
        let (place, width) = (place as usize, values.len());
        if place >= self.corners.len() {
            self.corners.resize(place + 1, [NONE; 3]);
            self.faces.resize((place + 1) * width, 0);
        }
        self.corners[place] = leaves;
        self.faces[place * width..(place + 1) * width].copy_from_slice(values);
    }

    /// How many wedges the finest mesh has.
    pub fn count(&self) -> usize {
        self.owners.len()
    }

    /// The splits of wedges that the split of a vertex has.
    #[inline]
    pub fn parts_of(&self, split: u32) -> impl Iterator<Item = u32> {
        self.parts[split as usize].into_iter().filter(|part| *part != NONE)
    }

    /// Tells which of two splits is made before the other, if one comes from the other: that of the greater key.
    fn order(&self, mesh: &Progressive, split: u32) -> (Key, u32) {
        let owner = self.owners[split as usize];
        (if owner == NONE { Key(u32::MAX) } else { mesh.splits[owner as usize].key }, split)
    }

    /// What a wedge of a level was built with, after which `following` is next there.
    pub fn values(&self, mesh: &Progressive, wedge: u32, following: Option<u32>) -> &[f32] {
        let (split, side) = self.source(mesh, wedge, following);
        self.values_of(split)[side]
    }

    /// The split that has what a wedge of a level was built with, and which of its two that is.
    pub fn source(&self, mesh: &Progressive, wedge: u32, following: Option<u32>) -> (u32, usize) {
        match following {
            Some(next) if self.order(mesh, next) < self.order(mesh, wedge) => (next, 0),
            _ => (wedge, 1),
        }
    }

    /// A leaf of the vertex that a wedge of a level is of.
    pub fn home(&self, mesh: &Progressive, wedge: u32) -> u32 {
        let homes = self.homes.get_or_init(|| {
            let mut homes = vec![NONE; self.count()];
            for (wedge, leaf) in self.corners.as_flattened().iter().zip(mesh.faces.as_flattened()) {
                if let Some(home) = homes.get_mut(*wedge as usize) {
                    *home = *leaf;
                }
            }
            // Where triangles were not read, any leaf of the wedge tells.
            let mut last = 0;
            for home in homes.iter_mut().rev() {
                last = if *home == NONE { last } else { *home };
                *home = last;
            }
            homes
        });
        homes[wedge as usize]
    }

    /// What the two wedges of a split have.
    pub fn values_of(&self, split: u32) -> [&[f32]; 2] {
        let (split, width) = (split as usize, self.widths[0]);
        self.values.each_ref().map(|values| &values[split * width..(split + 1) * width])
    }

    /// What one of the two wedges of a split has, to be changed.
    pub fn values_mut(&mut self, split: u32, side: usize) -> &mut [f32] {
        let (split, width) = (split as usize, self.widths[0]);
        &mut self.values[side][split * width..(split + 1) * width]
    }

    /// Sets what one of the two wedges of a split has, by the bits of numbers. Fails if one is not finite.
    pub fn set_values(&mut self, side: usize, split: u32, bits: impl Iterator<Item = u32>) -> Result<()> {
        let place = split as usize * self.widths[0];
        for (value, bits) in self.values[side][place..].iter_mut().zip(bits) {
            *value = f32::from_bits(bits);
            if !value.is_finite() {
                return Err(damaged("a number of a wedge is not finite"));
            }
        }
        Ok(())
    }

    /// Bytes in memory.
    pub fn bytes(&self) -> usize {
        let lists = [size_of_val(&*self.corners), size_of_val(&*self.faces), size_of_val(&*self.owners)];
        let values: usize = self.values.iter().map(|values| size_of_val(&**values)).sum();
        lists.into_iter().sum::<usize>() + size_of_val(&*self.parts) + size_of_val(&*self.base) + values
    }
}

impl Progressive {
    /// Attributes that it has beside normals, without their values.
    pub fn attributes(&self) -> &[Attribute] {
        self.wedges.as_ref().map_or(&[], |wedges| &wedges.attributes)
    }

    /// How many numbers a wedge has, of all attributes on points and corners, and a triangle of all those on faces.
    pub fn attribute_widths(&self) -> [usize; 2] {
        self.wedges.as_ref().map_or([0; 2], |wedges| wedges.widths)
    }

    /// Wedges of the finest mesh.
    pub fn wedge_count(&self) -> usize {
        self.wedges.as_ref().map_or(0, |wedges| wedges.count())
    }
}

/// The wedges of the base mesh.
pub fn of_base(mesh: &Progressive) -> Option<BitSet> {
    mesh.wedges.as_ref().map(|trees| {
        let there = BitSet::new(trees.count());
        trees.base.iter().for_each(|wedge| _ = there.insert(*wedge));
        there
    })
}
