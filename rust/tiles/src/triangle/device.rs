//! Values of a triangle mesh on a graphics device, in one pattern (`shaders/triangles/triangles.wgsl`).
//!
//! Schäfer, Keinert, Nießner and Stamminger 2015, *Local Painting and Deformation of Meshes on the GPU*, Section 6. A
//! triangle that is not blank has a block with all that is read in the pattern: inside, along its sides and at its
//! corners. So a kernel needs neither a second table nor the rules by which triangles without a block are read, for 6 %
//! more values at 64 segments a side and 13 % at 16. Freed room is taken again, last in, first out.

use half::f16;
use relievo_core::{Error, Result};
use relievo_gpu::{Access, Bindings, Buffer, Device, wgpu};

use super::block::TriangleBlock;
use super::field::TriangleField;
use super::pattern::{Pattern, Slot};
use crate::texel::Texel;

/// What kernels have as a group for values of triangles: the first word of every triangle, and the words.
pub const TRIANGLES_GROUP: [Access; 2] = [Access::Read; 2];

/// The first word of a triangle without a block.
const NONE: u32 = u32::MAX;

/// Values of a triangle mesh on a device: scalar displacement, or colours.
#[derive(Debug)]
pub struct DeviceTriangles<T: Texel = f16> {
    /// What the device has.
    field: TriangleField<T>,
    pattern: Pattern,
    entries: Vec<u32>,
    /// Where there is room for blocks.
    free: Vec<u32>,
    /// Words in use, freed ones among them.
    end: u32,
    on_device: Buffer<u32>,
    values: Buffer<u32>,
    group: Bindings,
}

impl<T: Texel> DeviceTriangles<T> {
    /// Brings `field` to a device, read in `pattern`.
    ///
    /// # Errors
    /// Fails where the device is lost or has no room for it, or a block is on a page that cannot be read.
    pub fn new(device: &Device, field: &TriangleField<T>, pattern: Pattern) -> Result<Self> {
        let topology = field.topology();
        let entries = vec![NONE; topology.face_count()];
        let on_device = Buffer::of(device, "triangles with values", &entries)?;
        let values = Buffer::new(device, "values of triangles", 1)?;
        let group = device.bind_as(&TRIANGLES_GROUP, &[on_device.wgpu(), values.wgpu()])?;
        let blank = TriangleField::new(topology.clone(), field.pattern(), field.blank());
        let mut made = Self { field: blank, pattern, entries, free: Vec::new(), end: 0, on_device, values, group };
        made.take(device, field)?;
        Ok(made)
    }

    /// Makes the device have what `field` has, a later or earlier state over the same mesh. Returns the faces that read
    /// otherwise, ascending.
    ///
    /// # Errors
    /// Fails as [`Self::new`], and for the field of another mesh.
    pub fn update(&mut self, device: &Device, field: &TriangleField<T>) -> Result<Vec<u32>> {
        let (found, own) = (field.topology(), self.field.topology());
        if (found.face_count(), found.vertex_count()) != (own.face_count(), own.vertex_count()) {
            let what = format!("values of {} triangles for {}", found.face_count(), own.face_count());
            return Err(Error::invalid(what).advise("give the values of the same mesh"));
        }
        self.take(device, field)
    }

    fn take(&mut self, device: &Device, field: &TriangleField<T>) -> Result<Vec<u32>> {
        let shown = field.changes(&self.field).faces_shown(field.topology());
        let mut written = Vec::new();
        for face in &shown {
            let block = read(field, self.pattern, *face)?;
            let entry = &mut self.entries[*face as usize];
            if block.is_none() && *entry != NONE {
                self.free.push(std::mem::replace(entry, NONE));
            }
            written.push((*face, block));
        }
        let room = Self::words(self.pattern);
        for (face, _) in written.iter().filter(|(_, block)| block.is_some()) {
            let entry = &mut self.entries[*face as usize];
            if *entry == NONE {
                let end = self.end.checked_add(room);
                *entry = match (self.free.pop(), end) {
                    (Some(first), _) => first,
                    (None, Some(end)) => std::mem::replace(&mut self.end, end),
                    (None, None) => return Err(Error::memory("the values are too large for a graphics device")),
                };
            }
        }
        self.grow(device)?;
        for (face, block) in written {
            let first = self.entries[face as usize];
            self.on_device.write(device, face as usize, &[first])?;
            if let Some(block) = block {
                self.values.write(device, first as usize, &block)?;
            }
        }
        self.field = field.clone();
        Ok(shown)
    }

    /// Makes room for all words in use, with half as much again, and moves what is there.
    fn grow(&mut self, device: &Device) -> Result<()> {
        let (old, needed) = (self.values.len(), self.end as usize);
        if needed <= old {
            return Ok(());
        }
        let values = Buffer::new(device, "values of triangles", needed + needed / 2)?;
        let mut frame = device.frame()?;
        frame.copy(&self.values, 0..old, &values, 0)?;
        let _ = frame.submit()?;
        self.group = device.bind_as(&TRIANGLES_GROUP, &[self.on_device.wgpu(), values.wgpu()])?;
        self.values = values;
        Ok(())
    }

    /// What is bound as the group. An update may replace it.
    pub fn group(&self) -> &Bindings {
        &self.group
    }

    /// The buffers of [`Self::group`] in the order of their bindings.
    pub fn buffers(&self) -> [&wgpu::Buffer; 2] {
        [self.on_device.wgpu(), self.values.wgpu()]
    }

    /// The pattern that it is read in.
    pub fn pattern(&self) -> Pattern {
        self.pattern
    }

    /// Words of a block.
    pub fn words(pattern: Pattern) -> u32 {
        (value_count(pattern) * size_of::<T>()).div_ceil(4) as u32
    }

    /// The parts of a block's values: inside, along the sides and at the corners. Panics if there are fewer.
    pub fn parts(pattern: Pattern, values: &[T]) -> (&[T], [&[T]; 3], &[T]) {
        let (inside, rest) = values.split_at(pattern.face_values());
        let side = |k: usize| &rest[k * pattern.edge_values()..][..pattern.edge_values()];
        (inside, [side(0), side(1), side(2)], &rest[3 * pattern.edge_values()..][..3])
    }
}

/// Values of a block: those inside, those of the three sides from the lower vertex of each edge, and the corners.
fn value_count(pattern: Pattern) -> usize {
    pattern.face_values() + 3 * pattern.edge_values() + 3
}

/// The words of what is read in a face; `None` if it is blank.
fn read<T: Texel>(field: &TriangleField<T>, pattern: Pattern, face: u32) -> Result<Option<Vec<u32>>> {
    let topology = field.topology();
    let own = field.try_held(TriangleBlock::Face(face))?;
    let edges = topology.edges_of(face);
    for edge in edges {
        field.try_held(TriangleBlock::Edge(edge))?;
    }
    if field.is_blank(face) {
        return Ok(None);
    }
    let texel = |slot: Slot| field.texel(face, pattern, pattern.at_slot(slot));
    let mut values: Vec<T> = Vec::with_capacity(value_count(pattern) + 1);
    match own.filter(|_| field.face_pattern(face) == Some(pattern)) {
        Some(block) => values.extend(block),
        None => values.extend((0..pattern.face_values() as u32).map(|at| texel(Slot::Inside(at)))),
    }
    for (side, edge) in (0..).zip(edges) {
        match field.edge(edge).filter(|_| field.edge_pattern(edge) == Some(pattern)) {
            Some(block) => values.extend(block),
            None => {
                let (segments, reversed) = (pattern.segments(), topology.side(face, side).reversed);
                let step = |step: u32| if reversed { segments - step } else { step };
                values.extend((1..segments).map(|at| texel(Slot::Side(side, step(at)))));
            }
        }
    }
    values.extend((0..3).map(|corner| texel(Slot::Corner(corner))));
    let bytes: &[u8] = bytemuck::cast_slice(&values);
    let word = |bytes: &[u8]| bytes.iter().rev().fold(0, |word, byte| word << 8 | u32::from(*byte));
    Ok(Some(bytes.chunks(4).map(word).collect()))
}
