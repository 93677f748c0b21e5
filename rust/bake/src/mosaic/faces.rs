//! As [`super`], of documents of triangle meshes: every triangle has a cell, in which u and v are the barycentric
//! coordinates of its second and third corner, so that it is the half u + v ≤ 1.
//!
//! A layer with T segments a side has T texels a side. Those of the diagonal have their centres on the side between the
//! second and third corner, those along the other sides are half a texel from them; all three sides are sampled at the
//! same places, which both of their faces have. Beyond a side lies as much more as the last texel is before it, so that
//! bilinear look-up gives the side's values on it from both faces; at corners to within what changes in a texel. A texel
//! of a level is the mean of those of the level before that lie in the triangle.

use std::fmt::Debug;

use glam::{DVec3, DVec4};
use half::f16;
use relievo_core::{Context, Error, Result};
use relievo_document::{Document, Kind, Layer};
use relievo_surface::{TriangleSurface, TriangleTopology};
use relievo_tiles::texel::Vector;
use relievo_tiles::triangle::vectors::face_frame;
use relievo_tiles::triangle::{Offset, TriangleChannel, TriangleField, TriangleSheet, foot_at};
use relievo_tiles::{Layered, Rgba8, Rgba16, StoredTexel, Texel, Trace};
use std::sync::Arc;

use super::Sampler;
use crate::opened::is_plain;

/// The numbers of a place.
type Numbers = [f32; 4];

/// Values of a triangle mesh.
pub(super) trait Faces: Debug + Send + Sync {
    /// Number of triangles.
    fn count(&self) -> usize;

    /// Whether all of a triangle, its sides and corners reads the same.
    fn is_blank(&self, face: u32) -> bool;

    /// What is read at a place of a triangle, from barycentric coordinates.
    fn numbers(&self, face: u32, at: [f32; 3]) -> Numbers;
}

/// Values that are the same wherever they are kept.
#[derive(Debug)]
struct Values<T: Texel> {
    channel: TriangleChannel<T>,
    numbers: fn(T::Value) -> Numbers,
}

impl<T: StoredTexel> Faces for Values<T> {
    fn count(&self) -> usize {
        self.channel.field().topology().face_count()
    }

    fn is_blank(&self, face: u32) -> bool {
        self.channel.field().is_blank(face)
    }

    fn numbers(&self, face: u32, at: [f32; 3]) -> Numbers {
        (self.numbers)(self.channel.field().value(face, at))
    }
}

/// Vectors, in the frame of the triangle they are read in.
#[derive(Debug)]
struct Directions {
    surface: TriangleSurface,
    channel: TriangleChannel<Vector>,
    offsets: TriangleField<Offset>,
}

impl Faces for Directions {
    fn count(&self) -> usize {
        self.surface.topology().face_count()
    }

    fn is_blank(&self, face: u32) -> bool {
        self.channel.field().is_blank(face)
    }

    fn numbers(&self, face: u32, at: [f32; 3]) -> Numbers {
        let normal = foot_at(&self.surface, face, at).normal;
        let offset: DVec3 = self.offsets.value(face, at);
        let [along, across, up] = (face_frame(&self.surface, face, normal).transpose() * offset.as_vec3()).to_array();
        [along, across, up, 0.0]
    }
}

/// Texels along the side of a triangle in a layer.
pub(super) fn segments(layer: &Layer) -> Option<u32> {
    layer.face_sizes().first().copied().filter(|_| !layer.blocks().is_empty())
}

/// Unpacks layers of one kind: one as it is if it is `alone`, or what all come to. Fails if they are damaged or do not
/// fit the memory limit.
pub(super) fn unpacked(
    context: &Context,
    document: &Document,
    topology: &Arc<TriangleTopology>,
    layers: &[&Layer],
    alone: bool,
) -> Result<Box<dyn Faces>> {
    let opened = Opened { context, document, topology, layers, alone };
    let kind = layers.first().map(|layer| layer.kind());
    Ok(match kind {
        Some(Kind::Scalar) => {
            Box::new(Values::<f16> { channel: opened.composite()?, numbers: |value| [value as f32, 0.0, 0.0, 0.0] })
        }
        Some(Kind::Rgba8) => Box::new(Values::<Rgba8> { channel: opened.composite()?, numbers: four }),
        Some(Kind::Rgba16) => Box::new(Values::<Rgba16> { channel: opened.composite()?, numbers: four }),
        Some(Kind::Trace) => Box::new(Values::<Trace> { channel: opened.first()?, numbers: four }),
        Some(Kind::Vector) => {
            let mesh = document.mesh().ok_or_else(crate::transfer::without_points)?;
            let (surface, channel) = (TriangleSurface::new(context, &mesh)?, opened.first::<Vector>()?);
            let offsets = channel.field().in_object_space(context, &surface);
            Box::new(Directions { surface, channel, offsets })
        }
        _ => return Err(Error::unsupported("times of edits are no picture")),
    })
}

fn four(value: DVec4) -> Numbers {
    value.as_vec4().to_array()
}

struct Opened<'a> {
    context: &'a Context,
    document: &'a Document,
    topology: &'a Arc<TriangleTopology>,
    layers: &'a [&'a Layer],
    alone: bool,
}

impl Opened<'_> {
    fn channel<T: StoredTexel>(&self, layer: &Layer) -> Result<TriangleChannel<T>> {
        let limit = self.context.memory_limit();
        TriangleChannel::stored(self.context, self.topology.clone(), self.document, layer.name(), limit)?
            .ok_or_else(|| Error::internal("a layer that was there is not"))
    }

    fn first<T: StoredTexel>(&self) -> Result<TriangleChannel<T>> {
        self.channel(self.layers.first().ok_or_else(|| Error::internal("a picture has layers"))?)
    }

    fn composite<T: Layered + StoredTexel>(&self) -> Result<TriangleChannel<T>> {
        if let ([layer], true) = (self.layers, self.alone || self.layers.iter().all(|layer| is_plain(layer))) {
            return self.channel(layer);
        }
        let channels = self.layers.iter().map(|layer| self.channel::<T>(layer)).collect::<Result<Vec<_>>>()?;
        let sheets: Vec<TriangleSheet<'_, T>> = channels
            .iter()
            .zip(self.layers)
            .map(|(channel, layer)| TriangleSheet { field: channel.field(), settings: layer.settings() })
            .collect();
        let lowest = channels.first().ok_or_else(|| Error::internal("a picture has layers"))?;
        let behind = self.layers.first().map_or(&[][..], |layer| &layer.head().behind);
        let background = if behind.is_empty() { lowest.field().blank() } else { bytemuck::pod_read_unaligned(behind) };
        let (made, refused) = lowest.recomposed(self.context, &sheets, background)?;
        match refused.len() {
            0 => Ok(made),
            count => {
                Err(Error::memory(format!("{count} triangles of the layers together do not fit the memory limit"))
                    .advise("raise it, or name one layer"))
            }
        }
    }
}

/// The cell of a triangle.
pub(super) struct Cell<'a> {
    values: &'a dyn Faces,
    face: u32,
    /// Texels along a side of the finest level.
    full: usize,
    /// What is shown of numbers.
    shown: fn(Numbers) -> Numbers,
    level: Level,
}

/// A level of a cell.
#[derive(Default)]
struct Level {
    side: usize,
    /// Row by row; those with i + j < side are in the triangle, the others mean nothing.
    texels: Vec<Numbers>,
    /// What is on v = 0 and on u = 0 beside each texel.
    sides: [Vec<Numbers>; 2],
    corners: [Numbers; 3],
}

/// The cell of a triangle whose finest level has `full` texels a side; `None` if there is no such triangle.
pub(super) fn cell(values: &dyn Faces, face: u32, full: u32, shown: fn(Numbers) -> Numbers) -> Option<Cell<'_>> {
    let there = (face as usize) < values.count();
    there.then(|| Cell { values, face, full: full as usize, shown, level: Level::default() })
}

/// Numbers as they are.
pub(super) fn plain(numbers: Numbers) -> Numbers {
    numbers
}

/// Traces: contact, depth and time.
pub(super) fn marks([contact, depth, moment, _]: Numbers) -> Numbers {
    let time = if contact > 0.0 { moment / contact } else { -1.0 };
    [contact.clamp(0.0, 1.0), depth, time, 0.0]
}

fn sum<const N: usize>(terms: [(f32, Numbers); N]) -> Numbers {
    [0, 1, 2, 3].map(|axis| terms.iter().map(|(weight, numbers)| weight * numbers[axis]).sum())
}

impl Level {
    /// The finest level of a triangle.
    fn of(values: &dyn Faces, face: u32, side: usize) -> Self {
        let corners = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        if values.is_blank(face) {
            let blank = values.numbers(face, corners[0]);
            return Self {
                side,
                texels: vec![blank; side * side],
                sides: [vec![blank; side], vec![blank; side]],
                corners: [blank; 3],
            };
        }
        let middle = |k: usize| (k as f32 + 0.5) / side as f32;
        let mut texels = vec![[0.0; 4]; side * side];
        for j in 0..side {
            for i in 0..side - j {
                // On the diagonal exactly.
                let (u, v) = (middle(i), middle(j));
                let rest = if i + j + 1 == side { 0.0 } else { 1.0 - u - v };
                texels[j * side + i] = values.numbers(face, [rest, u, v]);
            }
        }
        let along = |place: fn(f32) -> [f32; 3]| (0..side).map(|k| values.numbers(face, place(middle(k)))).collect();
        let sides = [along(|u| [1.0 - u, u, 0.0]), along(|v| [1.0 - v, 0.0, v])];
        Self { side, texels, sides, corners: corners.map(|at| values.numbers(face, at)) }
    }

    /// The level with half as many texels a side.
    fn halved(&self) -> Self {
        let side = self.side / 2;
        let mut texels = vec![[0.0; 4]; side * side];
        for j in 0..side {
            for i in 0..side - j {
                let at = |a: usize, b: usize| self.at(2 * i + a, 2 * j + b);
                texels[j * side + i] = if i + j + 1 == side {
                    sum([(0.5, at(1, 0)), (0.5, at(0, 1))])
                } else {
                    sum([(0.25, at(0, 0)), (0.25, at(1, 0)), (0.25, at(0, 1)), (0.25, at(1, 1))])
                };
            }
        }
        let mean = |pair: &[Numbers]| sum([(0.5, pair[0]), (0.5, pair[1])]);
        let sides = self.sides.each_ref().map(|side| side.chunks_exact(2).map(mean).collect());
        Self { side, texels, sides, corners: self.corners }
    }

    fn at(&self, i: usize, j: usize) -> Numbers {
        self.texels[j * self.side + i]
    }

    /// The texel at (i, j), each from −1 to the number of texels.
    fn ringed(&self, i: i64, j: i64) -> Numbers {
        let (side, last) = (self.side as i64, self.side - 1);
        let beyond = |edge: usize, k: usize, near: Numbers| sum([(2.0, self.sides[edge][k]), (-1.0, near)]);
        // Beyond the ends of the diagonal, so that the mean of the four texels there is the corner.
        let end = |edge: usize, corner: usize, near: Numbers| {
            sum([(4.0, self.corners[corner]), (-2.0, self.sides[edge][last]), (-1.0, near)])
        };
        match (i, j) {
            (-1, -1) => {
                let first = self.at(0, 0);
                let [below, before] = [beyond(0, 0, first), beyond(1, 0, first)];
                sum([(4.0, self.corners[0]), (-1.0, first), (-1.0, below), (-1.0, before)])
            }
            (i, -1) if i < side => beyond(0, i as usize, self.at(i as usize, 0)),
            (-1, j) if j < side => beyond(1, j as usize, self.at(0, j as usize)),
            (_, -1) => end(0, 1, self.at(last, 0)),
            (-1, _) => end(1, 2, self.at(0, last)),
            (i, 0) if i == side => self.at(last, 0),
            (0, j) if j == side => self.at(0, last),
            (i, j) if i + j < side => self.at(i as usize, j as usize),
            (i, j) => {
                // The nearest that is just beyond the diagonal.
                let i = (i - j + side).div_euclid(2).clamp(1, last as i64) as usize;
                let j = self.side - i;
                sum([(1.0, self.at(i - 1, j)), (1.0, self.at(i, j - 1)), (-1.0, self.at(i - 1, j - 1))])
            }
        }
    }
}

impl Sampler for Cell<'_> {
    fn come_to(&mut self, side: u32) {
        self.level = Level::of(self.values, self.face, self.full);
        while self.level.side > side as usize {
            self.level = self.level.halved();
        }
    }

    fn texel(&self, i: i64, j: i64, side: u32) -> [f32; 4] {
        let clamped = |k: i64| k.clamp(-1, i64::from(side));
        (self.shown)(self.level.ringed(clamped(i), clamped(j)))
    }
}
