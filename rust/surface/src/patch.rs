//! The patches of a surface: a parametric rectangle of a tile and control points in Bézier or Gregory form.
//!
//! Control points are computed in f64 and stored in f32 relative to the patch's own origin, so that a small patch far
//! from the object's origin keeps its shape.

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
    /// Which record it was made from, and which of the record's pieces it is.
    record: u32,
    piece: u8,
}

/// Numbers of the origin, before the control points.
pub(crate) const ORIGIN: usize = 3;

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

/// The pieces of a record across its crease, in ascending parameter: `(from, to, conversion)`.
fn pieces(kind: PatchKind) -> Vec<(f64, f64, Conversion)> {
    match kind {
        PatchKind::SingleCrease { edge, sharpness } => {
            let mut pieces = crease_pieces(f64::from(sharpness));
            if edge == 1 || edge == 2 {
                // The crease is at the far side: mirror points, pieces and parameters.
                pieces = pieces
                    .into_iter()
                    .rev()
                    .map(|(from, to, conversion)| (1.0 - to, 1.0 - from, mirror(&conversion)))
                    .collect();
            }
            pieces
        }
        _ => vec![(0.0, 1.0, SMOOTH)],
    }
}

fn mirror(conversion: &Conversion) -> Conversion {
    std::array::from_fn(|row| std::array::from_fn(|i| conversion[3 - row][3 - i]))
}

/// The patches of one record, with their control data starting at number `first`.
pub(crate) fn patches_of(record: &PatchRecord, index: u32, first: &mut u32) -> Vec<Patch> {
    let scale = (-f64::from(record.depth)).exp2();
    let across_u = matches!(record.kind, PatchKind::SingleCrease { edge: 1 | 3, .. });
    let form = if record.kind == PatchKind::Gregory { PatchForm::Gregory } else { PatchForm::Bezier };
    let place = |piece: usize, from: f64, to: f64| {
        let (mut low, mut size) = ([f64::from(record.u), f64::from(record.v)], [1.0, 1.0]);
        let axis = usize::from(!across_u);
        low[axis] += from;
        size[axis] = to - from;
        Patch {
            low: low.map(|value| (value * scale) as f32),
            size: size.map(|value| (value * scale) as f32),
            form,
            first: 0,
            record: index,
            piece: piece as u8,
        }
    };
    let mut patches: Vec<Patch> =
        pieces(record.kind).iter().enumerate().map(|(piece, (from, to, _))| place(piece, *from, *to)).collect();
    for patch in &mut patches {
        patch.first = *first;
        *first += patch.data_len() as u32;
    }
    patches
}

/// Writes the control data of `patch` for the points of a pose.
pub(crate) fn fill(patch: &Patch, records: &[PatchRecord], indices: &[i32], points: &[[f64; 3]], out: &mut [f32]) {
    let record = &records[patch.record as usize];
    let first = record.first as usize;
    let point = |i: usize| points[indices[first + i] as usize];
    match record.kind {
        PatchKind::Gregory => store(std::array::from_fn::<_, 20, _>(point), out),
        PatchKind::Regular { boundary } => {
            let grid = extrapolate(std::array::from_fn(point), boundary);
            store(convert(&grid, &SMOOTH, &SMOOTH), out);
        }
        PatchKind::SingleCrease { edge, .. } => {
            let grid = std::array::from_fn(point);
            let across = pieces(record.kind)[usize::from(patch.piece)].2;
            let bezier = if edge == 1 || edge == 3 {
                convert(&grid, &across, &SMOOTH)
            } else {
                convert(&grid, &SMOOTH, &across)
            };
            store(bezier, out);
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
    out[..ORIGIN].copy_from_slice(&origin);
    for axis in 0..3 {
        for (i, point) in points.iter().enumerate() {
            out[ORIGIN + axis * N + i] = (point[axis] - f64::from(origin[axis])) as f32;
        }
    }
}
