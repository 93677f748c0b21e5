//! What a simplification did, collapse by collapse.

use glam::{Vec3, Vec4};
use relievo_core::Context;

use super::packing::Normal;
use crate::connectivity::{Connectivity, Fan, NONE, next};

/// A collapse: two vertices became one.
#[derive(Clone, Copy)]
pub struct Operation {
    /// The vertex of the input under whose number the one vertex goes on.
    pub kept: u32,
    /// The vertex of the input that went.
    pub gone: u32,
    /// Triangles of the input that went, [`NONE`] for a second one at a boundary.
    pub faces: [u32; 2],
    /// Where the one vertex is.
    pub point: Vec3,
    pub normal: Normal,
    pub key: Key,
}

/// How much a collapse deviates, rounded up to 8 bits of precision, above how deep it stands on others.
///
/// Of two collapses whose vertices share an edge, the key of the later is the greater one, in both parts: the deviation
/// is at least that of all vertices around, the depth one more than theirs (Derzapf, Grund, Guthe 2014, Section 2.2, where
/// the error alone is multiplied by 1 + ε, which leaves 0 at 0).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct Key(pub u32);

impl Key {
    /// Depths a key can tell apart.
    pub const DEPTHS: u32 = 1 << 16;

    /// The next key above those of `around`, of a collapse that deviates by `error`.
    fn above(around: Key, error: f32) -> Self {
        let own = (error.to_bits() + 0xffff) >> 16;
        Self(own.max(around.0 >> 16) << 16 | (around.0 & 0xffff) + 1)
    }

    /// The larger of each part.
    fn join(self, other: Self) -> Self {
        Self((self.0 >> 16).max(other.0 >> 16) << 16 | self.depth().max(other.depth()))
    }

    /// The largest key of those that deviate by at most `error`.
    pub fn up_to(error: f32) -> Self {
        Self(error.to_bits() | 0xffff)
    }

    /// The deviation, never less than it was.
    pub fn error(self) -> f32 {
        f32::from_bits(self.0 & 0xffff_0000)
    }

    /// The number of collapses, at least, that have to come before.
    pub fn depth(self) -> u32 {
        self.0 & 0xffff
    }

    /// The same with another unit of length.
    pub fn scaled(self, scale: f32) -> Self {
        Self((self.error() * scale).to_bits() & 0xffff_0000 | self.depth())
    }
}

/// The collapses so far, in their order.
pub struct Recording {
    pub operations: Vec<Operation>,
    /// Of every vertex that is left: its number in the input, and the key of the collapse it comes from.
    vertices: Vec<(u32, Key)>,
    /// Numbers in the input of the triangles that are left.
    triangles: Vec<u32>,
    deepest: u32,
}

/// A collapse as the simplification has it: its half-edge, where the vertex goes with its deviation, and the sum of the
/// normals about it.
pub type Made = (u32, Vec4, Vec3);

impl Recording {
    pub fn new(vertices: usize, triangles: usize) -> Self {
        Self {
            operations: Vec::with_capacity(vertices),
            vertices: (0..vertices as u32).map(|vertex| (vertex, Key::default())).collect(),
            triangles: (0..triangles as u32).collect(),
            deepest: 0,
        }
    }

    /// Whether collapses may come whose depth has no number.
    pub fn is_full(&self) -> bool {
        self.deepest + 1 >= Key::DEPTHS
    }

    /// Adds collapses of one round, before they are made.
    pub fn add(&mut self, context: &Context, mesh: &Connectivity, made: &[Vec<Made>]) {
        let (vertices, triangles) = (&self.vertices, &self.triangles);
        let added = context.map(made.len(), |part| {
            let mut fan = Fan::default();
            let operation = |&(corner, point, normal): &Made| {
                let ends = [corner, next(corner)].map(|at| mesh.vertex(at));
                let mut around = Key::default();
                for end in ends {
                    mesh.fan(end, &mut fan);
                    around = fan.ring().fold(around, |key, vertex| key.join(vertices[vertex as usize].1));
                }
                let [kept, gone] = ends.map(|end| vertices[end as usize].0);
                let faces = [corner, mesh.mate(corner)].map(|side| match side {
                    NONE => NONE,
                    side => triangles[side as usize / 4],
                });
                let key = Key::above(around, point.w);
                (ends[0], Operation { kept, gone, faces, point: point.truncate(), normal: Normal::new(normal), key })
            };
            made[part].iter().map(operation).collect::<Vec<_>>()
        });
        for (vertex, operation) in added.into_iter().flatten() {
            self.vertices[vertex as usize].1 = operation.key;
            self.deepest = self.deepest.max(operation.key.depth());
            self.operations.push(operation);
        }
    }

    /// Leaves out vertices and triangles that are gone; `rest` and `kept` have the old numbers of those that stay.
    pub fn compact(&mut self, rest: &[u32], kept: &[u32]) {
        self.vertices = rest.iter().map(|old| self.vertices[*old as usize]).collect();
        self.triangles = kept.iter().map(|old| self.triangles[*old as usize]).collect();
    }
}
