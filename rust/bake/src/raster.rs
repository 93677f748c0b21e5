//! Which place of the surface lies at the centre of every sample of a window of a picture.
//!
//! The lattice of a tile, two triangles a cell, says which samples may lie in it and about where; Newton's method on
//! the texture coordinates' own limit says where exactly, and a sample counts only if it is there, to within a few
//! thousandths of itself. So places are exact, and the outline is that of the limit and not of the lattice: along the
//! border of a tile samples just beyond the lattice are tried as well. Units: samples, whose centres are at whole
//! numbers.

use std::ops::Range;

use relievo_core::{Context, Result};
use relievo_surface::{Order, Place, Samples};

use crate::layout::{Chunk, Layout};

/// No tile.
pub(crate) const NONE: u32 = u32::MAX;

/// From texture coordinates to samples of a picture.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Mapping {
    scale: [f64; 2],
    offset: [f64; 2],
}

impl Mapping {
    /// The picture of UDIM tile (k, l), whose top row is the one of the largest t.
    pub fn new(samples: [u32; 2], [k, l]: [i32; 2]) -> Self {
        let [width, height] = samples.map(f64::from);
        Self { scale: [width, -height], offset: [-f64::from(k) * width - 0.5, (1.0 + f64::from(l)) * height - 0.5] }
    }

    pub fn apply(&self, p: [f32; 2]) -> [f64; 2] {
        [0, 1].map(|axis| self.scale[axis] * f64::from(p[axis]) + self.offset[axis])
    }
}

/// A rectangle of samples and what lies there.
pub(crate) struct Window {
    /// Columns and rows of the picture.
    pub columns: Range<u32>,
    pub rows: Range<u32>,
    /// The tile at each sample, row by row, or [`NONE`].
    pub tiles: Vec<u32>,
    /// Where in it.
    pub parameters: Vec<[f32; 2]>,
    /// Whether more than a twentieth of a sample away from its border.
    inside: Vec<bool>,
    /// Whether several tiles lie there.
    pub overlapping: Vec<bool>,
}

/// A sample that may lie in a tile.
#[derive(Clone, Copy, Debug)]
struct Candidate {
    index: u32,
    target: [f64; 2],
    uv: [f64; 2],
}

/// How far from its place a sample may be, beyond the rounding of texture coordinates.
const NEAR: f64 = 0.002;
/// How far from the border of a tile, in samples, a second tile overlaps it rather than touches it.
const TOUCH: f64 = 0.05;
const STEPS: usize = 10;

impl Window {
    pub fn new(columns: Range<u32>, rows: Range<u32>) -> Self {
        let count = columns.len() * rows.len();
        Self {
            columns,
            rows,
            tiles: vec![NONE; count],
            parameters: vec![[0.0; 2]; count],
            inside: vec![false; count],
            overlapping: vec![false; count],
        }
    }

    /// Enters the samples that lie in a chunk; samples of an earlier tile stay.
    pub fn enter(&mut self, context: &Context, layout: &Layout<'_>, mapping: &Mapping, chunk: &Chunk) -> Result<()> {
        let mut corners = Samples::default();
        layout.limit.grid(context.level(), chunk.tile, &chunk.grid(), Order::Position, &mut corners);
        let points: Vec<[f64; 2]> =
            corners.p[0].iter().zip(&corners.p[1]).map(|(s, t)| mapping.apply([*s, *t])).collect();
        let mut candidates = Vec::new();
        self.cover(chunk, &points, &mut candidates);
        self.fringe(chunk, &points, &mut candidates);
        self.invert(context, layout, mapping, chunk.tile, candidates)
    }

    /// The samples in the triangles of the cells.
    fn cover(&self, chunk: &Chunk, points: &[[f64; 2]], out: &mut Vec<Candidate>) {
        let (size, cells) = (chunk.size() as usize, f64::from(chunk.cells));
        let stride = size + 1;
        for j in 0..size {
            for i in 0..size {
                let at = |i: usize, j: usize| {
                    let uv = [
                        (f64::from(chunk.first[0]) + i as f64) / cells,
                        (f64::from(chunk.first[1]) + j as f64) / cells,
                    ];
                    (points[j * stride + i], uv)
                };
                let corners = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
                self.triangle(chunk.tile, [corners[0], corners[1], corners[2]], out);
                self.triangle(chunk.tile, [corners[0], corners[2], corners[3]], out);
            }
        }
    }

    /// The samples in a triangle, its edges included.
    fn triangle(&self, tile: u32, corners: [([f64; 2], [f64; 2]); 3], out: &mut Vec<Candidate>) {
        let [(a, _), (b, _), (c, _)] = corners;
        let cross = |p: [f64; 2], q: [f64; 2]| p[0] * q[1] - p[1] * q[0];
        let to = |p: [f64; 2]| [p[0] - a[0], p[1] - a[1]];
        let (e, f) = (to(b), to(c));
        let area = cross(e, f);
        let range = |axis: usize, window: &Range<u32>| {
            let (low, high) = (a[axis].min(b[axis]).min(c[axis]), a[axis].max(b[axis]).max(c[axis]));
            whole(low - 1e-6, high + 1e-6, window)
        };
        if area.abs() < 1e-9 {
            return;
        }
        for y in range(1, &self.rows) {
            for x in range(0, &self.columns) {
                let p = to([f64::from(x), f64::from(y)]);
                let (s, t) = (cross(p, f) / area, cross(e, p) / area);
                if s < -1e-6 || t < -1e-6 || s + t > 1.0 + 1e-6 {
                    continue;
                }
                let uv = [0, 1].map(|axis| {
                    let [q, r, w] = [0, 1, 2].map(|corner| corners[corner].1[axis]);
                    q + s * (r - q) + t * (w - q)
                });
                self.push(tile, [x, y], uv, out);
            }
        }
    }

    /// The samples beside the border of the tile, as far off as the limit may bulge out of the lattice.
    fn fringe(&self, chunk: &Chunk, points: &[[f64; 2]], out: &mut Vec<Candidate>) {
        let (size, cells) = (chunk.size() as usize, f64::from(chunk.cells));
        let stride = size + 1;
        for edge in 0..4 {
            // Edges of the chunk that are edges of the tile.
            let (axis, end) = (edge % 2, edge / 2);
            let across = chunk.first[axis] + if end == 0 { 0 } else { chunk.size() };
            if across != if end == 0 { 0 } else { chunk.cells } {
                continue;
            }
            let fixed = if end == 0 { 0 } else { size };
            let point = |k: usize| if axis == 0 { points[k * stride + fixed] } else { points[fixed * stride + k] };
            for k in 0..size {
                let (a, b) = (point(k), point(k + 1));
                let bend = |k: usize| {
                    let [p, q, r] = [k - 1, k, k + 1].map(point);
                    length([p[0] - 2.0 * q[0] + r[0], p[1] - 2.0 * q[1] + r[1]])
                };
                let bent = [k, k + 1].into_iter().filter(|k| (1..size).contains(k)).map(bend).fold(0.0, f64::max);
                let reach = 0.05 + 0.5 * bent.min(4.0);
                let range = |axis: usize, window: &Range<u32>| {
                    whole(a[axis].min(b[axis]) - reach, a[axis].max(b[axis]) + reach, window)
                };
                let along = [b[0] - a[0], b[1] - a[1]];
                let square = along[0] * along[0] + along[1] * along[1];
                for y in range(1, &self.rows) {
                    for x in range(0, &self.columns) {
                        let p = [f64::from(x) - a[0], f64::from(y) - a[1]];
                        let dot = p[0] * along[0] + p[1] * along[1];
                        let t = if square > 0.0 { (dot / square).clamp(0.0, 1.0) } else { 0.0 };
                        if length([p[0] - t * along[0], p[1] - t * along[1]]) > reach {
                            continue;
                        }
                        let mut uv = [0.0; 2];
                        uv[axis] = f64::from(across) / cells;
                        uv[1 - axis] = (f64::from(chunk.first[1 - axis]) + k as f64 + t) / cells;
                        self.push(chunk.tile, [x, y], uv, out);
                    }
                }
            }
        }
    }

    fn push(&self, tile: u32, [x, y]: [u32; 2], uv: [f64; 2], out: &mut Vec<Candidate>) {
        let index = (y - self.rows.start) as usize * self.columns.len() + (x - self.columns.start) as usize;
        if self.tiles[index] != tile {
            out.push(Candidate { index: index as u32, target: [f64::from(x), f64::from(y)], uv });
        }
    }

    /// Finds the places of candidates and enters the places inside the tile.
    fn invert(
        &mut self,
        context: &Context,
        layout: &Layout<'_>,
        mapping: &Mapping,
        tile: u32,
        mut candidates: Vec<Candidate>,
    ) -> Result<()> {
        let mut samples = Samples::default();
        let mut places = Vec::new();
        for _ in 0..STEPS {
            places.clear();
            places.extend(candidates.iter().map(|candidate| {
                let [u, v] = candidate.uv.map(|t| t.clamp(0.0, 1.0) as f32);
                Place::new(tile, u, v)
            }));
            layout.limit.evaluate(context, &places, Order::First, &mut samples)?;
            let mut left = Vec::new();
            for (k, mut candidate) in candidates.into_iter().enumerate() {
                let here = mapping.apply([samples.p[0][k], samples.p[1][k]]);
                let slope =
                    |values: &[Vec<f32>; 3]| [0, 1].map(|axis| mapping.scale[axis] * f64::from(values[axis][k]));
                let (du, dv) = (slope(&samples.du), slope(&samples.dv));
                let off = [0, 1].map(|axis| candidate.target[axis] - here[axis]);
                let det = du[0] * dv[1] - du[1] * dv[0];
                let step = if det.abs() > 1e-12 * (length(du) * length(dv)) && det != 0.0 {
                    [(off[0] * dv[1] - off[1] * dv[0]) / det, (du[0] * off[1] - du[1] * off[0]) / det]
                } else {
                    [0.0; 2]
                };
                let before = candidate.uv.map(|t| t.clamp(0.0, 1.0));
                let after = [0, 1].map(|axis| (before[axis] + step[axis]).clamp(0.0, 1.0));
                let rounding = (samples.p[0][k].abs() + samples.p[1][k].abs()) * 1.2e-7;
                let near = NEAR + f64::from(rounding) * mapping.scale[0].abs().max(mapping.scale[1].abs());
                if length(off) <= near {
                    let margin = |axis: usize, slope: [f64; 2]| before[axis].min(1.0 - before[axis]) * length(slope);
                    let inside = margin(0, du).min(margin(1, dv)) > TOUCH;
                    self.hit(candidate.index as usize, tile, before.map(|t| t as f32), inside);
                } else if after != before {
                    candidate.uv = after;
                    left.push(candidate);
                }
            }
            candidates = left;
            if candidates.is_empty() {
                break;
            }
        }
        Ok(())
    }

    fn hit(&mut self, index: usize, tile: u32, uv: [f32; 2], inside: bool) {
        if self.tiles[index] == NONE {
            (self.tiles[index], self.parameters[index], self.inside[index]) = (tile, uv, inside);
        } else if self.tiles[index] != tile && inside && self.inside[index] {
            self.overlapping[index] = true;
        }
    }
}

fn length([x, y]: [f64; 2]) -> f64 {
    (x * x + y * y).sqrt()
}

/// The whole numbers from `low` to `high` that are in a window.
fn whole(low: f64, high: f64, window: &Range<u32>) -> Range<u32> {
    let first = low.ceil().max(f64::from(window.start));
    let end = (high.floor() + 1.0).min(f64::from(window.end));
    if first < end { first as u32..end as u32 } else { 0..0 }
}

#[cfg(test)]
mod tests {
    use relievo_core::{Attribute, Domain, Mesh, Values};
    use relievo_surface::{Surface, SurfaceOptions};

    use super::*;

    /// A sheet of `n` × `n` quads, some of them split into triangles, whose texture coordinates are bent.
    fn bent(n: u32) -> Mesh {
        let point = |i: u32| [(i % (n + 1)) as f32 / n as f32, (i / (n + 1)) as f32 / n as f32];
        let points: Vec<[f32; 3]> = (0..(n + 1) * (n + 1)).map(|i| [point(i)[0], point(i)[1], 0.0]).collect();
        let mut mesh = Mesh { points, ..Mesh::default() };
        for face in 0..n * n {
            let [a, b] = [face % n + face / n * (n + 1), face % n + (face / n + 1) * (n + 1)];
            if face % 3 == 1 {
                mesh.face_sizes.extend([3, 3]);
                mesh.corners.extend([a, a + 1, b + 1, a, b + 1, b]);
            } else {
                mesh.face_sizes.push(4);
                mesh.corners.extend([a, a + 1, b + 1, b]);
            }
        }
        let turned = |point: &[f32; 3]| {
            let (radius, angle) = (0.15 + 0.3 * point[0], 4.5 * point[1]);
            [0.5 + radius * angle.cos(), 0.5 + radius * angle.sin()]
        };
        let values = mesh.corners.iter().flat_map(|corner| turned(&mesh.points[*corner as usize]));
        let values = Values::F32(values.collect());
        mesh.attributes.push(Attribute { name: "uv".into(), domain: Domain::Corner, width: 2, values, indices: None });
        mesh
    }

    #[test]
    fn samples_are_where_their_places_are_and_none_is_missed() {
        let context = Context::serial();
        let limit = Surface::face_varying(&context, &bent(4), "uv", &SurfaceOptions::default()).unwrap();
        for size in [50, 130] {
            let layout = Layout::new(&context, &limit, [size; 2], |_| false).unwrap();
            let mapping = Mapping::new([size; 2], [0, 0]);
            let mut window = Window::new(0..size, 0..size);
            layout.chunks.iter().for_each(|chunk| window.enter(&context, &layout, &mapping, chunk).unwrap());
            let mut covered = 0;
            for (index, tile) in window.tiles.iter().enumerate().filter(|(_, tile)| **tile != NONE) {
                let [u, v] = window.parameters[index];
                let p = limit.sample(context.level(), Place::new(*tile, u, v)).unwrap().p;
                let [x, y] = mapping.apply([p[0], p[1]]);
                let (i, j) = ((index as u32 % size) as f64, (index as u32 / size) as f64);
                assert!((x - i).hypot(y - j) < 0.005, "({i}, {j}) is at ({x}, {y})");
                covered += 1;
            }
            assert!(covered > size * size / 4 && !window.overlapping.contains(&true));
            // Where the surface is on all four sides of a sample's centre and near it, the sample is covered.
            let mut quadrants = vec![0u8; (size * size) as usize];
            for tile in 0..limit.tile_count() as u32 {
                for k in 0..400 * 400 {
                    let (u, v) = ((k % 400) as f32 / 399.0, (k / 400) as f32 / 399.0);
                    let p = limit.sample(context.level(), Place::new(tile, u, v)).unwrap().p;
                    let [x, y] = mapping.apply([p[0], p[1]]);
                    let (dx, dy) = (x - x.round(), y - y.round());
                    if dx.hypot(dy) < 0.1 {
                        let quadrant = 1 << (2 * u8::from(dx > 0.0) + u8::from(dy > 0.0));
                        quadrants[y.round() as usize * size as usize + x.round() as usize] |= quadrant;
                    }
                }
            }
            assert!(quadrants.iter().filter(|all| **all == 15).count() > covered as usize / 2);
            for (index, all) in quadrants.iter().enumerate() {
                assert!(*all != 15 || window.tiles[index] != NONE, "{size}: sample {index} is missing");
            }
        }
    }
}
