//! The patches of a surface: a parametric rectangle of a tile and control points in Bézier or Gregory form.
//!
//! Control points are computed in f64 and stored in f32 relative to the patch's own origin, so that a small patch far
//! from the object's origin keeps its shape.

use std::collections::BTreeMap;
use std::ops::Range;

use relievo_opensubdiv::{PatchKind, PatchRecord};

use crate::bezier::{Conversion, SMOOTH, crease_pieces};

/// How a patch's control points are to be read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PatchForm {
    /// 16 bicubic Bézier points, row by row in v.
    Bezier,
    /// 20 Gregory points, five a corner in the order of the corners: P, E+, E−, F+, F− (Loop, Schaefer, Ni, Castaño
    /// 2009).
    Gregory,
}

/// Where a patch lies and where its points are; it does not change with the pose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Patch {
    /// Lower corner in the tile's parameters.
    pub low: [f32; 2],
    /// Size in the tile's parameters, powers of two.
    pub size: [f32; 2],
    /// The form of its points.
    pub form: PatchForm,
    /// First number of its control data: the origin, then all x, all y, all z.
    pub(crate) first: u32,
    /// Which record it was made from.
    pub(crate) record: u32,
    /// Which of the [`Pieces`] it is.
    pub(crate) piece: u32,
}

/// Numbers before the control points: the origin and one that is not used, so that devices read four at a time.
pub(crate) const ORIGIN: usize = 4;

impl Patch {
    /// Number of control points.
    pub fn point_count(&self) -> usize {
        match self.form {
            PatchForm::Bezier => 16,
            PatchForm::Gregory => 20,
        }
    }

    /// Numbers of its control data.
    pub(crate) fn data_len(&self) -> usize {
        ORIGIN + 3 * self.point_count()
    }
}

/// The pieces into which patches are cut across their creases, each kept once for all patches that need it: a crease's
/// pieces depend on its sharpness and on the side it is at.
#[derive(Default)]
pub(crate) struct Pieces {
    all: Vec<Piece>,
    known: BTreeMap<Option<(u32, bool)>, Range<usize>>,
}

/// A part of a patch across its crease, from one parameter to another, and its conversion to Bézier form.
struct Piece {
    from: f64,
    to: f64,
    across: Conversion,
}

impl Pieces {
    /// The conversions of all pieces, by their numbers.
    pub(crate) fn conversions(&self) -> impl Iterator<Item = &Conversion> {
        self.all.iter().map(|piece| &piece.across)
    }

    /// The pieces of a kind of patch, in ascending parameter.
    fn of(&mut self, kind: PatchKind) -> Range<usize> {
        let (crease, far) = match kind {
            PatchKind::SingleCrease { edge, sharpness } => (Some(sharpness), edge == 1 || edge == 2),
            _ => (None, false),
        };
        let all = &mut self.all;
        let known = self.known.entry(crease.map(|sharpness| (sharpness.to_bits(), far))).or_insert_with(|| {
            let mut pieces = crease.map_or(vec![(0.0, 1.0, SMOOTH)], |sharpness| crease_pieces(f64::from(sharpness)));
            if far {
                // The crease is at the far side: mirror points, pieces and parameters.
                pieces.reverse();
                pieces.iter_mut().for_each(|piece| *piece = (1.0 - piece.1, 1.0 - piece.0, mirror(&piece.2)));
            }
            let first = all.len();
            all.extend(pieces.into_iter().map(|(from, to, across)| Piece { from, to, across }));
            first..all.len()
        });
        known.clone()
    }
}

fn mirror(conversion: &Conversion) -> Conversion {
    std::array::from_fn(|row| std::array::from_fn(|i| conversion[3 - row][3 - i]))
}

/// The patches of one record, with their control data starting at number `first`.
pub(crate) fn patches_of(record: &PatchRecord, index: u32, pieces: &mut Pieces, first: &mut u32) -> Vec<Patch> {
    let scale = (-f64::from(record.depth)).exp2();
    let axis = usize::from(!matches!(record.kind, PatchKind::SingleCrease { edge: 1 | 3, .. }));
    let form = if record.kind == PatchKind::Gregory { PatchForm::Gregory } else { PatchForm::Bezier };
    let mut patches = Vec::with_capacity(3);
    for number in pieces.of(record.kind) {
        let Piece { from, to, .. } = pieces.all[number];
        let (mut low, mut size) = ([f64::from(record.u), f64::from(record.v)], [1.0, 1.0]);
        low[axis] += from;
        size[axis] = to - from;
        let patch = Patch {
            low: low.map(|value| (value * scale) as f32),
            size: size.map(|value| (value * scale) as f32),
            form,
            first: *first,
            record: index,
            piece: number as u32,
        };
        *first += patch.data_len() as u32;
        patches.push(patch);
    }
    patches
}

/// What the control data of all poses is made from.
pub(crate) struct Source<'a> {
    pub records: &'a [PatchRecord],
    pub indices: &'a [i32],
    pub pieces: &'a Pieces,
}

/// Writes the control data of `patch` for the points of a pose.
pub(crate) fn fill(patch: &Patch, source: &Source<'_>, points: &[[f64; 3]], out: &mut [f32]) {
    let record = &source.records[patch.record as usize];
    let first = record.first as usize;
    let point = |i: usize| points[source.indices[first + i] as usize];
    match record.kind {
        PatchKind::Gregory => store(std::array::from_fn::<_, 20, _>(point), out),
        PatchKind::Regular { boundary } => {
            let grid = extrapolate(std::array::from_fn(point), boundary);
            store(convert(&grid, &SMOOTH, &SMOOTH), out);
        }
        PatchKind::SingleCrease { edge, .. } => {
            let across = &source.pieces.all[patch.piece as usize].across;
            let (in_u, in_v) = if edge == 1 || edge == 3 { (across, &SMOOTH) } else { (&SMOOTH, across) };
            store(convert(&std::array::from_fn(point), in_u, in_v), out);
        }
    }
}

/// Replaces the phantom points beyond boundary edges: p₋₁ = 2·p₀ − p₁.
fn extrapolate(mut grid: [[f64; 3]; 16], boundary: u8) -> [[f64; 3]; 16] {
    let beyond = |near: [f64; 3], far: [f64; 3]| std::array::from_fn(|axis| 2.0 * near[axis] - far[axis]);
    for k in 0..4 {
        if boundary & 1 != 0 {
            grid[k] = beyond(grid[4 + k], grid[8 + k]);
        }
        if boundary & 4 != 0 {
            grid[12 + k] = beyond(grid[8 + k], grid[4 + k]);
        }
    }
    for k in (0..16).step_by(4) {
        if boundary & 2 != 0 {
            grid[k + 3] = beyond(grid[k + 2], grid[k + 1]);
        }
        if boundary & 8 != 0 {
            grid[k] = beyond(grid[k + 1], grid[k + 2]);
        }
    }
    grid
}

/// Bézier points of a tensor-product patch from its B-spline points.
fn convert(grid: &[[f64; 3]; 16], in_u: &Conversion, in_v: &Conversion) -> [[f64; 3]; 16] {
    let mut rows = [[0.0; 3]; 16];
    for v in 0..4 {
        for u in 0..4 {
            rows[4 * v + u] = std::array::from_fn(|axis| (0..4).map(|k| in_u[u][k] * grid[4 * v + k][axis]).sum());
        }
    }
    std::array::from_fn(|i| {
        let (v, u) = (i / 4, i % 4);
        std::array::from_fn(|axis| (0..4).map(|k| in_v[v][k] * rows[4 * k + u][axis]).sum())
    })
}

fn store<const N: usize>(points: [[f64; 3]; N], out: &mut [f32]) {
    let origin: [f32; 3] = std::array::from_fn(|axis| points[0][axis] as f32);
    out[..3].copy_from_slice(&origin);
    for axis in 0..3 {
        for (i, point) in points.iter().enumerate() {
            out[ORIGIN + axis * N + i] = (point[axis] - f64::from(origin[axis])) as f32;
        }
    }
}
