//! Tessellation of Bézier patches on the CPU through the same maps and rates as in vertex shaders.
//!
//! Every patch is the grid of its map, in f32 like in a shader. Samples on edges are evaluated from the control points of
//! the edge alone, at the rate of the edge, in its one direction: so both sides have the same points, to the bit.

use std::ops::Range;

use relievo_core::simd::Arithmetic;
use relievo_core::{Context, Error, Result};

use super::edge::curve;
use super::evaluate::Forms;
use super::{BezierSurface, EdgeSense, Levels, ParametricMap, cubic, cubic_first};

/// Triangles of all patches.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BezierTessellation {
    /// Positions: grids of samples, row by row, patch after patch.
    pub points: Vec<[f32; 3]>,
    /// Unit normals, each that of its patch.
    pub normals: Vec<[f32; 3]>,
    /// The first point of every patch, and their number at the end.
    pub first: Vec<u32>,
    /// Triangles that have an area in the map, counter-clockwise from the front.
    pub triangles: Vec<[u32; 3]>,
    /// The first triangle of every patch, and their number at the end.
    pub first_triangle: Vec<u32>,
}

/// Where, in numbers of `n` segments, sample `k` of an edge is, if the map has `fine` segments and the edge `coarse`.
#[inline]
pub fn snapped(k: u32, fine: u32, coarse: u32) -> u32 {
    (2 * k * coarse + fine) / (2 * fine)
}

impl BezierSurface {
    /// How many points and triangles [`Self::tessellate`] makes.
    ///
    /// # Errors
    /// The levels are those of another surface.
    pub fn tessellated_counts(&self, levels: &Levels) -> Result<[usize; 2]> {
        self.check_levels(levels)?;
        let mut counts = [0; 2];
        for patch in 0..self.count() {
            let map = ParametricMap::new(levels.patch(patch))?;
            counts[0] += map.samples() as usize;
            counts[1] += (map.triangles() - flat_count(map, levels.edges(patch))) as usize;
        }
        Ok(counts)
    }

    fn check_levels(&self, levels: &Levels) -> Result<()> {
        if levels.count() == self.count() {
            return Ok(());
        }
        Err(Error::invalid(format!("{} levels are given for {} patches", levels.count(), self.count())))
    }

    /// The triangles of all patches at `levels`.
    ///
    /// # Errors
    /// The levels are those of another surface, or there are more points or triangles than 32 bits count or the memory
    /// limit allows.
    pub fn tessellate(&self, context: &Context, levels: &Levels) -> Result<BezierTessellation> {
        self.check_levels(levels)?;
        let (mut points, mut triangles) = (0u64, 0u64);
        let mut first = Vec::with_capacity(self.count() + 1);
        for patch in 0..self.count() {
            first.push(points as u32);
            let map = ParametricMap::new(levels.patch(patch))?;
            points += map.samples();
            triangles += map.triangles();
            if points.max(3 * triangles) > u64::from(u32::MAX) {
                return Err(
                    Error::invalid("the surface has more triangles than 32 bits count").advise("use lower levels")
                );
            }
        }
        first.push(points as u32);
        let bytes = 24 * points + 12 * triangles;
        if bytes > context.memory_limit() {
            return Err(Error::memory(format!("the triangles need {bytes} bytes, more than the memory limit"))
                .advise("use lower levels, or raise the memory limit"));
        }
        let tables: Vec<Table> = (1..=super::MOST_LEVEL).map(Table::new).collect::<Result<_>>()?;
        let mut tessellation = BezierTessellation {
            points: vec![[0.0; 3]; points as usize],
            normals: vec![[0.0; 3]; points as usize],
            first,
            ..BezierTessellation::default()
        };
        let mut pieces = Vec::with_capacity(self.count());
        let (mut rest, mut normals) = (&mut tessellation.points[..], &mut tessellation.normals[..]);
        for patch in 0..self.count() {
            let count = ParametricMap::new(levels.patch(patch))?.samples() as usize;
            let (points, others) = rest.split_at_mut(count);
            let (here, behind) = normals.split_at_mut(count);
            (rest, normals) = (others, behind);
            pieces.push((points, here, Vec::new()));
        }
        context.for_each_mut(&mut pieces, |patch, (points, normals, triangles)| {
            let table = &tables[levels.patch(patch) as usize - 1];
            grid(context.level(), self.controls(patch), self.is_rational(), table, points, normals);
            self.finish_grid(patch, levels, table, points, normals);
            *triangles = grid_triangles(table.map, levels.edges(patch), tessellation.first[patch]);
        });
        tessellation.first_triangle = Vec::with_capacity(pieces.len() + 1);
        tessellation.first_triangle.push(0);
        let mut all = Vec::with_capacity(triangles as usize);
        for (_, _, triangles) in &pieces {
            all.extend_from_slice(triangles);
            tessellation.first_triangle.push(all.len() as u32);
        }
        tessellation.triangles = all;
        Ok(tessellation)
    }

    /// Puts the samples of edges where their rates want them, and normals that have no length at their limits.
    fn finish_grid(
        &self,
        patch: usize,
        levels: &Levels,
        table: &Table,
        points: &mut [[f32; 3]],
        normals: &mut [[f32; 3]],
    ) {
        let (side, n) = (table.map.side() as usize, table.map.segments());
        let controls = self.controls(patch);
        let senses = self.edges().senses(patch);
        let place = |edge: usize, k: u32| match edge {
            0 => k as usize,
            1 => side - 1 + side * k as usize,
            2 => side * side - 1 - k as usize,
            _ => side * (side - 1 - k as usize),
        };
        // Collapsed edges last: their ends are corners whose limit is theirs.
        let mut order = [0, 1, 2, 3];
        order.sort_by_key(|edge| senses[*edge] == EdgeSense::Collapsed);
        for edge in order {
            let level = levels.edges(patch)[edge];
            let coarse = (2 << level) - 1;
            let mut canonical = curve(controls, edge);
            if senses[edge] == EdgeSense::Against {
                canonical.reverse();
            }
            for k in 0..=n {
                let at = snapped(k, n, coarse);
                let number = senses[edge].segment(at, coarse);
                points[place(edge, k)] = curve_point(&canonical, number, coarse);
                // Where an edge is a point its tangents are rounding, and so they may be at corners.
                let degenerate = senses[edge] == EdgeSense::Collapsed || k == 0;
                if level < table.map.level() || degenerate {
                    let t = f64::from(at) / f64::from(coarse);
                    let (u, v) = [(t, 0.0), (1.0, t), (1.0 - t, 1.0), (0.0, 1.0 - t)][edge];
                    normals[place(edge, k)] = self.limit_normal(patch, &Forms::new(controls, u, v), u, v);
                }
            }
        }
        for (at, normal) in normals.iter_mut().enumerate().filter(|(_, normal)| **normal == [0.0; 3]) {
            let [u, v] = [at % side, at / side].map(|k| k as f64 / f64::from(n));
            *normal = self.limit_normal(patch, &Forms::new(controls, u, v), u, v);
        }
    }
}

/// The point of an edge at parameter `number` / `n` of its one direction.
pub(super) fn curve_point(curve: &[[f32; 4]; 4], number: u32, n: u32) -> [f32; 3] {
    if number == n {
        return [curve[3][0], curve[3][1], curve[3][2]];
    }
    let basis = cubic(number as f32 / n as f32);
    let shares: [f32; 4] = std::array::from_fn(|k| basis[k] * curve[k][3]);
    let weight = shares[0] + shares[1] + shares[2] + shares[3];
    // From the first point on, so that both ends are control points to the bit.
    std::array::from_fn(|axis| {
        let sum = shares[1] * (curve[1][axis] - curve[0][axis])
            + shares[2] * (curve[2][axis] - curve[0][axis])
            + shares[3] * (curve[3][axis] - curve[0][axis]);
        curve[0][axis] + sum / weight
    })
}

/// Basis values of the samples of a level.
struct Table {
    map: ParametricMap,
    value: [Vec<f32>; 4],
    slope: [Vec<f32>; 4],
}

impl Table {
    fn new(level: u32) -> Result<Self> {
        let map = ParametricMap::new(level)?;
        let basis =
            |k: usize, basis: fn(f32) -> [f32; 4]| (0..map.side()).map(|i| basis(map.parameter(i))[k]).collect();
        Ok(Self {
            map,
            value: std::array::from_fn(|k| basis(k, cubic)),
            slope: std::array::from_fn(|k| basis(k, cubic_first)),
        })
    }
}

relievo_core::dispatch_simd! {
    fn grid = grid_body(
        controls: &[[f32; 4]; 16], rational: bool, table: &Table, points: &mut [[f32; 3]], normals: &mut [[f32; 3]]
    )
}

/// Samples evaluated together.
const LANES: usize = 16;

/// Evaluates all samples of a patch, 16 columns at a time: rows of control points to a curve for each column, then along
/// the columns. Normals without a length become zero.
#[inline(always)]
fn grid_body<A: Arithmetic>(
    controls: &[[f32; 4]; 16],
    rational: bool,
    table: &Table,
    points: &mut [[f32; 3]],
    normals: &mut [[f32; 3]],
) {
    let side = table.map.side() as usize;
    // w·x, w·y, w·z, w.
    let mut forms = [[0.0f32; 4]; 16];
    for (form, control) in forms.iter_mut().zip(controls) {
        let weight = if rational { control[3] } else { 1.0 };
        *form = [control[0] * weight, control[1] * weight, control[2] * weight, weight];
    }
    let axes = if rational { 4 } else { 3 };
    for first in (0..side).step_by(LANES) {
        let columns: Range<usize> = first..(first + LANES).min(side);
        let mut value = [[0.0f32; LANES]; 4];
        let mut slope = [[0.0f32; LANES]; 4];
        for k in 0..4 {
            value[k][..columns.len()].copy_from_slice(&table.value[k][columns.clone()]);
            slope[k][..columns.len()].copy_from_slice(&table.slope[k][columns.clone()]);
        }
        let mut curves = [[[0.0f32; LANES]; 4]; 4];
        let mut slopes = [[[0.0f32; LANES]; 4]; 4];
        for row in 0..4 {
            for axis in 0..axes {
                for lane in 0..LANES {
                    let control = [0, 1, 2, 3].map(|k| forms[4 * row + k][axis]);
                    let mut sum = control[0] * value[0][lane];
                    let mut first = control[0] * slope[0][lane];
                    for k in 1..4 {
                        sum = A::fma(control[k], value[k][lane], sum);
                        first = A::fma(control[k], slope[k][lane], first);
                    }
                    curves[row][axis][lane] = sum;
                    slopes[row][axis][lane] = first;
                }
            }
        }
        for row in 0..side {
            let basis = [0, 1, 2, 3].map(|k| table.value[k][row]);
            let rise = [0, 1, 2, 3].map(|k| table.slope[k][row]);
            let mut p = [[0.0f32; LANES]; 4];
            let mut du = [[0.0f32; LANES]; 4];
            let mut dv = [[0.0f32; LANES]; 4];
            for axis in 0..axes {
                for lane in 0..LANES {
                    let mut sums = [basis[0] * curves[0][axis][lane], basis[0] * slopes[0][axis][lane]];
                    let mut along = rise[0] * curves[0][axis][lane];
                    for k in 1..4 {
                        sums[0] = A::fma(basis[k], curves[k][axis][lane], sums[0]);
                        sums[1] = A::fma(basis[k], slopes[k][axis][lane], sums[1]);
                        along = A::fma(rise[k], curves[k][axis][lane], along);
                    }
                    p[axis][lane] = sums[0];
                    du[axis][lane] = sums[1];
                    dv[axis][lane] = along;
                }
            }
            if rational {
                for lane in 0..LANES {
                    let w = p[3][lane];
                    let one = if w > 0.0 { 1.0 / w } else { 0.0 };
                    for axis in 0..3 {
                        p[axis][lane] *= one;
                        // The factor 1/w of both tangents turns no normal.
                        du[axis][lane] -= p[axis][lane] * du[3][lane];
                        dv[axis][lane] -= p[axis][lane] * dv[3][lane];
                    }
                }
            }
            let mut normal = [[0.0f32; LANES]; 3];
            for lane in 0..LANES {
                let (du, dv) = ([0, 1, 2].map(|axis| du[axis][lane]), [0, 1, 2].map(|axis| dv[axis][lane]));
                let n = [du[1] * dv[2] - du[2] * dv[1], du[2] * dv[0] - du[0] * dv[2], du[0] * dv[1] - du[1] * dv[0]];
                let square = n[0] * n[0] + n[1] * n[1] + n[2] * n[2];
                let sizes =
                    (du[0] * du[0] + du[1] * du[1] + du[2] * du[2]) * (dv[0] * dv[0] + dv[1] * dv[1] + dv[2] * dv[2]);
                // Parallel to rounding, or none, or one whose square is not a number of f32: a limit instead.
                let good = square > 1e-8 * sizes && sizes > f32::MIN_POSITIVE && square < f32::INFINITY;
                let scale = if good { 1.0 / square.sqrt() } else { 0.0 };
                for axis in 0..3 {
                    normal[axis][lane] = n[axis] * scale;
                }
            }
            let start = row * side + first;
            for (lane, at) in (start..start + columns.len()).enumerate() {
                points[at] = [p[0][lane], p[1][lane], p[2][lane]];
                normals[at] = [normal[0][lane], normal[1][lane], normal[2][lane]];
            }
        }
    }
}

/// Corners of the two triangles of a cell of a grid.
const CELL: [[[u32; 2]; 3]; 2] = [[[0, 0], [1, 0], [0, 1]], [[1, 0], [1, 1], [0, 1]]];

/// Whether a triangle of a patch's grid has no area in the map when its edges have the levels `edges`.
fn is_flat(map: ParametricMap, edges: [u32; 4], corners: [[u32; 2]; 3]) -> bool {
    let n = map.segments();
    // The place of a sample in the map.
    let place = |[i, j]: [u32; 2]| {
        let along = |k: u32, edge: usize| {
            let coarse = (2 << edges[edge]) - 1;
            (u64::from(snapped(k, n, coarse)) << 32) / u64::from(coarse)
        };
        let fine = |k: u32| (u64::from(k) << 32) / u64::from(n);
        // Edges 2 and 3 count from the other end, where snapping is symmetric.
        match (i, j) {
            (i, 0) => [along(i, 0), 0],
            (i, j) if i == n => [1 << 32, along(j, 1)],
            (i, j) if j == n => [along(i, 2), 1 << 32],
            (0, j) => [0, along(j, 3)],
            (i, j) => [fine(i), fine(j)],
        }
    };
    let [a, b, c] = corners.map(place);
    a == b || b == c || a == c
}

/// The corners of the triangles of cell (i, j).
fn cell(i: u32, j: u32) -> [[[u32; 2]; 3]; 2] {
    CELL.map(|corners| corners.map(|[right, up]| [i + right, j + up]))
}

/// How many triangles of a patch's grid have no area in the map: only those at edges may.
fn flat_count(map: ParametricMap, edges: [u32; 4]) -> u64 {
    if edges == [map.level(); 4] {
        return 0;
    }
    let n = map.segments();
    let border = (0..n).flat_map(|j| {
        let step = if j == 0 || j + 1 == n { 1 } else { n as usize - 1 };
        (0..n).step_by(step).map(move |i| cell(i, j))
    });
    border.flatten().filter(|corners| is_flat(map, edges, *corners)).count() as u64
}

/// The triangles of a patch's grid that have an area in the map when its edges have the levels `edges`.
fn grid_triangles(map: ParametricMap, edges: [u32; 4], first: u32) -> Vec<[u32; 3]> {
    let (side, n) = (map.side(), map.segments());
    let whole = edges == [map.level(); 4];
    let mut triangles = Vec::with_capacity(map.triangles() as usize);
    for j in 0..n {
        for i in 0..n {
            let border = !whole && (i == 0 || j == 0 || i + 1 == n || j + 1 == n);
            for corners in cell(i, j) {
                if border && is_flat(map, edges, corners) {
                    continue;
                }
                triangles.push(corners.map(|[i, j]| first + j * side + i));
            }
        }
    }
    triangles
}
