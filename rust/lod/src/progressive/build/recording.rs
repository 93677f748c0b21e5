//! What a simplification did, collapse by collapse.

use glam::{Vec3, Vec4};
use relievo_core::Context;

use crate::connectivity::{Connectivity, Fan, NONE, next};
use crate::progressive::files::packing::Normal;
use crate::simplify::wedges::Wedges;

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

/// Two wedges that became one in a collapse.
#[derive(Clone, Copy)]
pub struct Join {
    /// The collapse, by its number among all.
    pub operation: u32,
    /// The wedge of the input under whose number the one wedge goes on, and the one that went.
    pub wedges: [u32; 2],
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
        Self((own.max(around.0 >> 16) << 16) | ((around.0 & 0xffff) + 1))
    }

    /// The larger of each part.
    fn join(self, other: Self) -> Self {
        Self((self.0 >> 16).max(other.0 >> 16) << 16 | self.depth().max(other.depth()))
    }

    /// The largest key of splits that deviate by at most `error`.
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
    /// Of every vertex that is left: the key of the collapse it comes from.
    keys: Vec<Key>,
    /// Numbers in the input of the vertices and of the triangles that are left, while some of them are left out; none before.
    numbers: Option<[Vec<u32>; 2]>,
    deepest: u32,
    /// What became of wedges, in the order of collapses, and the numbers that each of them had then.
    pub joins: Vec<Join>,
    pub values: Vec<f32>,
    /// Numbers of a wedge.
    width: usize,
}

/// A collapse as the simplification has it: its half-edge, where the vertex goes with its deviation, and the sum of the
/// normals about it.
pub type Made = (u32, Vec4, Vec3);

impl Recording {
    /// Of a mesh whose wedges have `width` numbers.
    pub fn new(vertices: usize, width: usize) -> Self {
        let operations = Vec::with_capacity(vertices);
        let keys = vec![Key::default(); vertices];
        Self { operations, keys, numbers: None, deepest: 0, joins: Vec::new(), values: Vec::new(), width }
    }

    /// Whether collapses may come whose depth has no number.
    pub fn is_full(&self) -> bool {
        self.deepest + 1 >= Key::DEPTHS
    }

    /// Adds collapses of one round, before they are made.
    pub fn add(&mut self, context: &Context, mesh: &Connectivity, made: &[Vec<Made>]) {
        let keys = &self.keys;
        let numbers = self.numbers.as_ref().map(|[vertices, triangles]| [vertices.as_slice(), triangles]);
        let [vertices, triangles] =
            [0, 1].map(|of| move |at: u32| numbers.map_or(at, |numbers| numbers[of][at as usize]));
        let added = context.map(made.len(), |part| {
            let mut fan = Fan::default();
            let operation = |&(corner, point, normal): &Made| {
                let ends = [corner, next(corner)].map(|at| mesh.vertex(at));
                let mut around = Key::default();
                for end in ends {
                    mesh.fan(end, &mut fan);
                    around = fan.ring().fold(around, |key, vertex| key.join(keys[vertex as usize]));
                }
                let [kept, gone] = ends.map(vertices);
                let faces = [corner, mesh.mate(corner)].map(|side| match side {
                    NONE => NONE,
                    side => triangles(side / 4),
                });
                let key = Key::above(around, point.w);
                (ends[0], Operation { kept, gone, faces, point: point.truncate(), normal: Normal::new(normal), key })
            };
            made[part].iter().map(operation).collect::<Vec<_>>()
        });
        for (vertex, operation) in added.into_iter().flatten() {
            self.keys[vertex as usize] = operation.key;
            self.deepest = self.deepest.max(operation.key.depth());
            self.operations.push(operation);
        }
    }

    /// Adds what becomes of wedges in the collapses added last, told by their half-edges and whether their ends stay, once
    /// wedges have their new values and before the collapses are made.
    pub fn add_joins<const Q: usize>(
        &mut self,
        context: &Context,
        mesh: &Connectivity,
        wedges: &Wedges<Q>,
        made: &[Vec<(u32, bool)>],
    ) {
        let joined = context.map(made.len(), |part| {
            let joined = |(index, (corner, end_stays)): (usize, &(u32, bool))| {
                wedges.joined(mesh, *corner, *end_stays).map(move |(pair, values)| (index, pair, *values))
            };
            made[part].iter().enumerate().flat_map(joined).collect::<Vec<_>>()
        });
        let mut first = self.operations.len() - made.iter().map(Vec::len).sum::<usize>();
        for (made, joined) in made.iter().zip(joined) {
            for (index, wedges, values) in joined {
                self.joins.push(Join { operation: (first + index) as u32, wedges });
                let numbers = values.iter().flat_map(|four| four.to_array());
                self.values.extend(numbers.take(self.width));
            }
            first += made.len();
        }
    }

    /// Leaves out vertices and triangles that are gone; `rest` and `kept` have the old numbers of what stays.
    pub fn compact(&mut self, context: &Context, rest: &[u32], kept: &[u32]) {
        self.keys = context.map(rest.len(), |new| self.keys[rest[new] as usize]);
        let numbers = self.numbers.take();
        self.numbers = Some([(0, rest), (1, kept)].map(|(of, left)| match &numbers {
            Some(numbers) => context.map(left.len(), |new| numbers[of][left[new] as usize]),
            None => left.to_vec(),
        }));
    }
}
