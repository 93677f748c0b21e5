//! The surface in a block of cells: weights of particles added up at its corners, and triangles where values change
//! sign.
//!
//! Neighbours share the corners between them, and each computes the same bits there: the particles that reach a corner
//! are added in the same order, at the same coordinates, whichever block it is. An edge of cells belongs to the block
//! that its first corner is in, on its lower sides; others name it by its block and code.

use std::ops::Range;

use glam::Vec3;
use relievo_core::dispatch_simd;
use relievo_core::lanes::Lanes;

use crate::surface::Surface;
use crate::surface::function::Combination;
use crate::surface::isosurface::Channel;
use crate::surface::marching;
use crate::surface::probe::Probe;
use crate::surface::profile::{WIDEST, Weight, with_weight};

/// Cells of a block along each axis, and its corners: a row of them is one vector of the widest.
pub(crate) const CELLS: usize = 15;
const CORNERS: usize = CELLS + 1;
/// Corners of a row, with the corners by which vectors may exceed it.
const STRIDE: usize = CORNERS + WIDEST - 1;
/// Rows are sought this much wider, in cells, than a kernel is: more than what rounding may hide. What counts is then
/// decided by numbers that do not depend on the block.
const SLACK: f32 = 0.25;

/// What a block needs while it is made.
#[derive(Debug, Default)]
pub(crate) struct Block {
    /// Coordinates of the corners along each axis.
    axes: [Vec<f32>; 3],
    /// Σ w at each corner, and Σ w d of means.
    weights: Vec<f32>,
    moments: [Vec<f32>; 3],
    /// Inside corners of each row, by z and y.
    inside: Vec<u32>,
    /// Crossed edges of each row along x, y and z, and how many come before them.
    crossed: Vec<[(u32, u32); 3]>,
    /// For each crossed edge its vertex, or [`FOREIGN`] and the place in the list of those.
    vertices: Vec<u32>,
    ranges: Vec<Range<usize>>,
}

/// Set in numbers of vertices that are another block's.
pub(crate) const FOREIGN: u32 = 1 << 31;

/// A vertex by the block it belongs to, as steps along each axis, and its code there.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Foreign {
    pub steps: [u8; 3],
    pub code: u16,
}

/// The mesh in a block.
#[derive(Debug, Default)]
pub(crate) struct Part {
    pub points: Vec<[f32; 3]>,
    pub normals: Vec<[f32; 3]>,
    /// Values of each channel.
    pub channels: Vec<Vec<f32>>,
    /// Codes of vertices that other blocks use, rising, and their numbers.
    pub shared: Vec<(u16, u32)>,
    pub foreign: Vec<Foreign>,
    pub corners: Vec<u32>,
}

/// An edge of cells by its row, axis and first corner.
fn code([x, y, z]: [usize; 3], axis: usize) -> u16 {
    (((z * CORNERS + y) * 3 + axis) * CORNERS + x) as u16
}

impl Block {
    /// The mesh in the block whose lower corner has these coordinates in cells, of cells of this size, with normals and
    /// channels if they are asked for.
    pub fn make(&mut self, probe: &mut Probe<'_>, low: [i64; 3], cell: f32, channels: Option<&[Channel<'_>]>) -> Part {
        let surface = probe.surface;
        for (axis, low) in self.axes.iter_mut().zip(low) {
            axis.clear();
            axis.extend((low..).take(STRIDE).map(|at| (at as f64 * f64::from(cell)) as f32));
        }
        let reach = f64::from(surface.reach) * 1.001;
        let side = |corner: usize, reach: f64| {
            surface.rows.cell_at(std::array::from_fn(|axis| f64::from(self.axes[axis][corner]) + reach))
        };
        surface.rows.ranges(side(0, -reach), side(CELLS, reach), &mut self.ranges);
        let size = CORNERS * CORNERS * STRIDE;
        self.weights.clear();
        self.weights.resize(size, 0.0);
        for moments in &mut self.moments {
            moments.clear();
            if matches!(surface.combination, Combination::Mean { .. }) {
                moments.resize(size, 0.0);
            }
        }
        let ranges = std::mem::take(&mut self.ranges);
        splat(probe.level, surface, &ranges, self, 1.0 / cell);
        self.ranges = ranges;
        let mut part = Part::default();
        if self.classify(surface.combination) {
            self.place(probe, channels, &mut part);
            self.triangulate(&mut part);
        }
        part
    }

    /// Finds the inside corners. Returns whether there are corners on both sides.
    fn classify(&mut self, combination: Combination) -> bool {
        self.inside.clear();
        let (mut any, mut all) = (0, u32::MAX);
        for row in 0..CORNERS * CORNERS {
            let bit = |x: usize| u32::from(self.value(combination, row * STRIDE + x) > 0.0) << x;
            let inside = (0..CORNERS).map(bit).fold(0, |bits, bit| bits | bit);
            any |= inside;
            all &= inside;
            self.inside.push(inside);
        }
        any != 0 && all != (1 << CORNERS) - 1
    }

    #[inline(always)]
    fn value(&self, combination: Combination, at: usize) -> f32 {
        let moment = match combination {
            Combination::Sum { .. } => [0.0; 3],
            Combination::Mean { .. } => [self.moments[0][at], self.moments[1][at], self.moments[2][at]],
        };
        combination.value(self.weights[at], moment)
    }

    fn corner(&self, [x, y, z]: [usize; 3]) -> [f32; 3] {
        [self.axes[0][x], self.axes[1][y], self.axes[2][z]]
    }

    /// Places a vertex on every crossed edge.
    fn place(&mut self, probe: &mut Probe<'_>, channels: Option<&[Channel<'_>]>, part: &mut Part) {
        let combination = probe.surface.combination;
        part.channels = vec![Vec::new(); channels.map_or(0, <[_]>::len)];
        self.vertices.clear();
        let mut crossed = std::mem::take(&mut self.crossed);
        crossed.clear();
        for (z, y) in (0..CORNERS).flat_map(|z| (0..CORNERS).map(move |y| (z, y))) {
            let row = z * CORNERS + y;
            let here = self.inside[row];
            let along = [
                (here ^ here >> 1) & ((1 << CELLS) - 1),
                if y < CELLS { here ^ self.inside[row + 1] } else { 0 },
                if z < CELLS { here ^ self.inside[row + CORNERS] } else { 0 },
            ];
            let mut entry = [(0, 0); 3];
            for (axis, bits) in along.into_iter().enumerate() {
                entry[axis] = (bits, self.vertices.len() as u32);
                let mut rest = bits;
                while rest != 0 {
                    let from = [rest.trailing_zeros() as usize, y, z];
                    rest &= rest - 1;
                    let number = if from.contains(&CELLS) {
                        let steps = from.map(|at| u8::from(at == CELLS));
                        part.foreign.push(Foreign { steps, code: code(from.map(|at| at % CELLS), axis) });
                        FOREIGN | (part.foreign.len() - 1) as u32
                    } else {
                        if from.contains(&0) {
                            part.shared.push((code(from, axis), part.points.len() as u32));
                        }
                        let (point, inside) = self.cross(combination, from, axis);
                        part.points.push(point);
                        if let Some(channels) = channels {
                            shade(probe, point, inside, channels, part);
                        }
                        (part.points.len() - 1) as u32
                    };
                    self.vertices.push(number);
                }
            }
            crossed.push(entry);
        }
        self.crossed = crossed;
    }

    /// Where a line between the values of the edge from a corner along an axis is 0, and its end that is inside.
    fn cross(&self, combination: Combination, from: [usize; 3], axis: usize) -> ([f32; 3], [f32; 3]) {
        let step = [1, STRIDE, CORNERS * STRIDE][axis];
        let at = (from[2] * CORNERS + from[1]) * STRIDE + from[0];
        let values = [self.value(combination, at), self.value(combination, at + step)];
        let mut to = from;
        to[axis] += 1;
        let ends = [from, to].map(|corner| self.corner(corner));
        let mut point = ends[0];
        point[axis] += values[0] / (values[0] - values[1]) * (ends[1][axis] - ends[0][axis]);
        (point, ends[usize::from(values[1] > 0.0)])
    }

    fn triangulate(&self, part: &mut Part) {
        for (z, y) in (0..CELLS).flat_map(|z| (0..CELLS).map(move |y| (z, y))) {
            let row = z * CORNERS + y;
            let rows = [row, row + 1, row + CORNERS, row + CORNERS + 1].map(|row| self.inside[row]);
            let any = rows[0] | rows[1] | rows[2] | rows[3];
            let all = rows[0] & rows[1] & rows[2] & rows[3];
            let mut rest = (any | any >> 1) & !(all & all >> 1) & ((1 << CELLS) - 1);
            while rest != 0 {
                let x = rest.trailing_zeros();
                rest &= rest - 1;
                let case = (0..4).fold(0, |case, at| case | (rows[at] >> x & 3) << (2 * at));
                for edge in marching::CASES[case as usize].triangles().as_flattened() {
                    let ([dx, dy, dz], axis) = marching::edge(*edge as usize);
                    let (bits, before) = self.crossed[(z + dz) * CORNERS + y + dy][axis];
                    let below = bits & ((1 << (x + dx as u32)) - 1);
                    part.corners.push(self.vertices[(before + below.count_ones()) as usize]);
                }
            }
        }
    }
}

/// Adds the normal and the channels of a vertex, from a corner beside it that is inside.
fn shade(probe: &mut Probe<'_>, point: [f32; 3], inside: [f32; 3], channels: &[Channel<'_>], part: &mut Part) {
    let mut gradient = Vec3::from(probe.sample(point).gradient);
    if gradient == Vec3::ZERO {
        // The line misses the surface where the function has a step, so no particle may be here.
        gradient = Vec3::from(probe.sample(inside).gradient);
    }
    let outwards = (Vec3::from(point) - Vec3::from(inside)).normalize_or(Vec3::Z);
    part.normals.push((-gradient).normalize_or(outwards).to_array());
    for (channel, values) in channels.iter().zip(&mut part.channels) {
        let (first, mut sum) = (values.len(), 0.0);
        values.resize(first + channel.width, 0.0);
        probe.near(|particle, weight| {
            sum += weight;
            let (from, share) = (particle as usize * channel.width, weight / sum);
            for (mean, value) in values[first..].iter_mut().zip(&channel.values[from..]) {
                *mean += (*value - *mean) * share;
            }
        });
    }
}

dispatch_simd! {
    fn splat = splat_body(surface: &Surface, ranges: &[Range<usize>], block: &mut Block, inverse: f32)
}

#[inline(always)]
fn splat_body<A: Lanes>(v: A, surface: &Surface, ranges: &[Range<usize>], block: &mut Block, inverse: f32) {
    with_weight!(surface.profile, weight => match surface.combination {
        Combination::Mean { .. } => splat_of::<A, _, true, false>(v, surface, weight, ranges, block, inverse),
        Combination::Sum { .. } if surface.shapes.is_none() => {
            splat_of::<A, _, false, false>(v, surface, weight, ranges, block, inverse);
        }
        Combination::Sum { .. } => splat_of::<A, _, false, true>(v, surface, weight, ranges, block, inverse),
    });
}

/// Adds the particles of ranges to the corners, row by row, each from where the row enters its kernel to where it
/// leaves it: with dx the step along x from its centre, s = xx dx² + b dx + c.
#[inline(always)]
fn splat_of<A: Lanes, W: Weight, const MEAN: bool, const SHAPES: bool>(
    v: A,
    surface: &Surface,
    weight: W,
    ranges: &[Range<usize>],
    block: &mut Block,
    inverse: f32,
) {
    let (zero, one) = (v.splat(0.0), v.splat(1.0));
    let Block { axes: [xs, ys, zs], weights, moments: [mxs, mys, mzs], .. } = block;
    let rows = |centre: f32, half: f32, low: f32| {
        let first = ((centre - half - low) * inverse - SLACK).ceil().max(0.0) as usize;
        let last = ((centre + half - low) * inverse + SLACK).floor();
        first..(last.min(CELLS as f32) + 1.0).max(0.0) as usize
    };
    for at in ranges.iter().cloned().flatten() {
        let [cx, cy, cz] = surface.centre(at);
        let amplitude = surface.amplitudes[at];
        let [xx, xy, xz, yy, yz, zz] = match &surface.shapes {
            Some(shapes) if SHAPES => [0, 1, 2, 3, 4, 5].map(|entry| shapes[entry][at]),
            _ => [surface.sphere, 0.0, 0.0, surface.sphere, 0.0, surface.sphere],
        };
        let half = if SHAPES { surface.half_extents(at) } else { [surface.reach; 3] };
        let (over, root) = (1.0 / xx, (1.0 / xx).sqrt());
        let (widest, heights) = (rows(cx, half[0], xs[0]), rows(cy, half[1], ys[0]));
        for z in rows(cz, half[2], zs[0]) {
            let dz = zs[z] - cz;
            for y in heights.clone() {
                let dy = ys[y] - cy;
                let b = if SHAPES { 2.0 * A::fma(xy, dy, xz * dz) } else { 0.0 };
                let c = A::fma(yy * dy, dy, A::fma(2.0 * yz * dy, dz, zz * dz * dz));
                let middle = -0.5 * b * over;
                // More by what s may be wrong by.
                let left = 1.0001 - A::fma(middle, 0.5 * b, c);
                if left <= 0.0 {
                    continue;
                }
                // Where two vectors have all of the widest row, to seek where each row begins costs more.
                let columns = if widest.len() <= 2 * A::WIDTH {
                    widest.clone()
                } else {
                    rows(cx + middle, left.sqrt() * root, xs[0])
                };
                let row = (z * CORNERS + y) * STRIDE;
                let (across, b, c) = (v.splat(xx), v.splat(b), v.splat(c));
                for first in columns.step_by(A::WIDTH) {
                    let x = v.load(&xs[first..]);
                    let dx = v.sub(x, v.splat(cx));
                    let s = v.fused(v.fused(across, dx, b), dx, c);
                    let counts = v.lt(s, one);
                    let w = weight.weight(v, v.max(v.min(s, one), zero));
                    let w = v.select(counts, v.mul(v.splat(amplitude), w), zero);
                    let at = row + first;
                    let add = |sums: &mut [f32], d: A::F| v.store(v.fused(w, d, v.load(sums)), sums);
                    add(&mut weights[at..], one);
                    if MEAN {
                        add(&mut mxs[at..], v.sub(v.splat(cx), x));
                        add(&mut mys[at..], v.splat(-dy));
                        add(&mut mzs[at..], v.splat(-dz));
                    }
                }
            }
        }
    }
}
