//! Wedges in files of progressive meshes.
//!
//! A chunk after the head has the numbers of wedges and of those of the base, and how many attributes there are; of each its
//! domain, whether its numbers are whole, how many they are, and the bytes of its name with their count. The other chunks
//! have more columns: numbers of splits of wedges, as differences to those of vertices; of every number of a wedge what the
//! first of two has, changed by the bits of the second, then the second; leaves at corners, as differences to those of
//! vertices; and numbers of triangles.

use relievo_core::budget::Budget;
use relievo_core::{Attribute, Domain, Result, Values};
use relievo_document::code::{Decoder, Encoder};

use super::format::{Reader, Writer, damaged};
use crate::connectivity::NONE;
use crate::progressive::build::attributed::{FACE_NUMBERS, NAME};
use crate::progressive::build::hierarchy::Progressive;
use crate::progressive::build::wedges::{WedgeTrees, widths};
use crate::simplify::attributes::Attributes;

/// Bytes of the chunk of attributes at most.
pub const MAX: usize = 12 + (Attributes::MAX + FACE_NUMBERS) * (16 + NAME);
/// Beside the tag of a split of a vertex: it has one of a wedge; one bit higher, another one.
pub const HAS_WEDGE: u32 = 64;
/// Domains by their numbers.
const DOMAINS: [Domain; 3] = [Domain::Point, Domain::Corner, Domain::Face];

/// What the chunk of attributes tells.
pub struct Told {
    pub attributes: Vec<Attribute>,
    pub widths: [usize; 2],
    pub wedges: usize,
    pub base: usize,
}

impl WedgeTrees {
    /// The chunk of attributes.
    pub fn head(&self) -> Vec<u8> {
        let mut out = Encoder(Vec::new());
        [self.count(), self.base.len(), self.attributes.len()].into_iter().for_each(|count| out.u32(count as u32));
        for attribute in &self.attributes {
            let domain = (0..).zip(DOMAINS).find(|(_, domain)| *domain == attribute.domain);
            out.u32(domain.map_or(0, |(number, _)| number));
            out.u32(u32::from(matches!(attribute.values, Values::U32(_))));
            out.u32(attribute.width);
            out.text(&attribute.name);
        }
        out.0
    }
}

impl Told {
    /// Reads the chunk of attributes of a mesh with so many splits.
    pub fn read(bytes: &[u8], splits: usize) -> Result<Self> {
        let mut from = Decoder(bytes);
        let [wedges, base, count] = [from.u32()?, from.u32()?, from.u32()?].map(|count| count as usize);
        let mut attributes = Vec::new();
        for _ in 0..count.min(Attributes::MAX + FACE_NUMBERS) {
            let domain = DOMAINS.get(from.u32()? as usize).copied();
            let is_whole = from.u32()? != 0;
            let (width, name) = (from.u32()?, from.text()?);
            let values = if is_whole { Values::U32(Vec::new()) } else { Values::F32(Vec::new()) };
            let is_known = attributes.iter().any(|known: &Attribute| known.name == name);
            let (1..=4, Some(domain), false) = (width, domain, is_known) else {
                return Err(damaged("an attribute is none that there could be"));
            };
            if is_whole && domain != Domain::Face {
                return Err(damaged("wedges have whole numbers"));
            }
            attributes.push(Attribute { name, domain, width, values, indices: None });
        }
        let widths = widths(&attributes);
        let fits = wedges >= base
            && wedges - base <= 2 * splits
            && attributes.len() == count
            && widths[0] <= Attributes::MAX
            && widths[1] <= FACE_NUMBERS;
        if !fits {
            return Err(damaged("attributes have numbers that do not fit each other"));
        }
        Ok(Self { attributes, widths, wedges, base })
    }

    /// Bytes that the columns of so many wedges or splits of wedges and of so many triangles have.
    pub fn bytes(&self, wedges: usize, faces: usize) -> usize {
        4 * (wedges * (1 + 2 * self.widths[0]) + faces * (3 + self.widths[1]))
    }
}

/// Wedges of a chunk by columns.
pub struct Columns {
    numbers: Vec<u32>,
    values: [Vec<Vec<u32>>; 2],
    corners: [Vec<u32>; 3],
    faces: Vec<Vec<u32>>,
}

impl Columns {
    pub fn new(trees: &WedgeTrees) -> Self {
        let [width, face_width] = trees.widths;
        Self {
            numbers: Vec::new(),
            values: [vec![Vec::new(); width], vec![Vec::new(); width]],
            corners: Default::default(),
            faces: vec![Vec::new(); face_width],
        }
    }

    /// Adds a base wedge.
    pub fn add_base(&mut self, trees: &WedgeTrees, wedge: u32) {
        self.numbers.push(wedge);
        let [_, second] = trees.values_of(wedge);
        self.values[1].iter_mut().zip(second).for_each(|(column, value)| column.push(value.to_bits()));
    }

    /// Adds the splits of wedges of a split. Returns their tag.
    pub fn add_split(&mut self, trees: &WedgeTrees, split: u32) -> u32 {
        let mut tag = 0;
        for part in trees.parts_of(split) {
            self.numbers.push(part.wrapping_sub(split));
            let values = trees.values_of(part);
            for (number, (first, second)) in values[0].iter().zip(values[1]).enumerate() {
                self.values[0][number].push(first.to_bits() ^ second.to_bits());
                self.values[1][number].push(second.to_bits());
            }
            tag = 2 * tag + HAS_WEDGE;
        }
        tag
    }

    /// Adds a triangle.
    pub fn add_face(&mut self, trees: &WedgeTrees, mesh: &Progressive, face: u32) {
        let (face, width) = (face as usize, trees.widths[1]);
        let leaves = trees.corners[face].into_iter().zip(mesh.faces[face]);
        for (column, (wedge, leaf)) in self.corners.iter_mut().zip(leaves) {
            column.push(wedge.wrapping_sub(leaf));
        }
        let values = &trees.faces[face * width..(face + 1) * width];
        self.faces.iter_mut().zip(values).for_each(|(column, value)| column.push(*value));
    }

    pub fn write(&self, out: &mut Writer) {
        let columns = [&self.numbers].into_iter().chain(self.values.iter().flatten());
        columns.chain(&self.corners).chain(&self.faces).for_each(|column| out.column(column));
    }

    /// Of so many first and second wedges of splits, and so many triangles.
    pub fn read(from: &mut Reader, widths: [usize; 2], [firsts, seconds]: [usize; 2], faces: usize) -> Result<Self> {
        let mut columns =
            |width: usize, count: usize| (0..width).map(|_| from.column(count)).collect::<Result<Vec<_>>>();
        let numbers = columns(1, seconds)?.concat();
        let values = [columns(widths[0], firsts)?, columns(widths[0], seconds)?];
        let corners = [columns(1, faces)?.concat(), columns(1, faces)?.concat(), columns(1, faces)?.concat()];
        Ok(Self { numbers, values, corners, faces: columns(widths[1], faces)? })
    }
}

/// Wedges that are read.
pub struct Loading {
    pub trees: WedgeTrees,
}

impl Loading {
    /// The wedges of the base of a mesh whose triangles are there.
    pub fn base(told: Told, columns: &Columns, mesh: &Progressive, budget: &mut Budget) -> Result<Self> {
        let mut trees = WedgeTrees::empty(told.attributes, mesh, told.wedges, budget)?;
        let is_sound = columns.numbers.first().map_or(told.wedges == 0, |first| *first == 0)
            && columns.numbers.is_sorted_by(|one, other| one < other)
            && columns.numbers.last().is_none_or(|last| (*last as usize) < told.wedges);
        if !is_sound {
            return Err(damaged("base wedges are out of order"));
        }
        for (index, wedge) in columns.numbers.iter().enumerate() {
            trees.set_values(1, *wedge, columns.values[1].iter().map(|column| column[index]))?;
        }
        trees.base = columns.numbers.clone();
        let mut made = Self { trees };
        for (index, face) in mesh.base_faces().iter().enumerate() {
            made.face(columns, index, *face, mesh)?;
        }
        Ok(made)
    }

    /// The wedges that were read, of which what was found before is forgotten.
    pub fn finished(mut self) -> WedgeTrees {
        self.trees.homes.take();
        self.trees
    }

    /// The splits of wedges that a split has by its tag, from a place in the columns on.
    pub fn split(&mut self, columns: &Columns, next: &mut usize, tag: u32, split: u32) -> Result<()> {
        for _ in 0..count(tag) {
            let wedge = columns.numbers[*next].wrapping_add(split);
            let is_new = self.trees.owners.get(wedge as usize).is_some_and(|owner| *owner == NONE);
            if !is_new || self.trees.base.binary_search(&wedge).is_ok() {
                return Err(damaged("a split of a wedge is out of place"));
            }
            self.trees.own(split, wedge);
            let [first, second] = &columns.values;
            let both = first.iter().zip(second).map(|(first, second)| first[*next] ^ second[*next]);
            self.trees.set_values(0, wedge, both)?;
            self.trees.set_values(1, wedge, second.iter().map(|column| column[*next]))?;
            *next += 1;
        }
        Ok(())
    }

    /// The triangle of a place.
    pub fn face(&mut self, columns: &Columns, index: usize, place: u32, mesh: &Progressive) -> Result<()> {
        let leaves = mesh.faces[place as usize];
        let wedges = [0, 1, 2].map(|side| columns.corners[side][index].wrapping_add(leaves[side]));
        if wedges.iter().any(|wedge| *wedge as usize >= self.trees.count()) {
            return Err(damaged("a corner has a wedge that is not there"));
        }
        let values: Vec<u32> = columns.faces.iter().map(|column| column[index]).collect();
        self.trees.set_face(place, wedges, &values);
        Ok(())
    }
}

/// How many splits of wedges a tag tells.
pub fn count(tag: u32) -> usize {
    (tag & (HAS_WEDGE | HAS_WEDGE << 1)).count_ones() as usize
}
