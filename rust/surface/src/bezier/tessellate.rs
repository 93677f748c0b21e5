//! Tessellation of Bézier patches on the CPU through the same maps and rates as in vertex shaders.
//!
//! Every patch is the grid of its map, in f32 like in a shader. Samples on edges are evaluated from the control points of
//! the edge alone, in its one direction: so both sides have the same points, to the bit. Where an edge is finer than a
//! patch, triangles between both divisions close the gap.

use std::ops::Range;

use relievo_core::simd::Arithmetic;
use relievo_core::{Context, Error, Result};

use super::edge::curve;
use super::evaluate::Forms;
use super::stitch::{Stitch, stitches};
use super::{BezierSurface, EdgeSense, Levels, ParametricMap, cubic, cubic_first};

/// Triangles of all patches.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BezierTessellation {
    /// Positions: grids of samples, row by row, patch after patch; then those of finer edges, patch after patch.
    pub points: Vec<[f32; 3]>,
    /// Unit normals, each that of its patch.
    pub normals: Vec<[f32; 3]>,
    /// The first point of every patch's grid, and where the last ends.
    pub first: Vec<u32>,
    /// Triangles, counter-clockwise from the front: those of the map, then those beside finer edges.
    pub triangles: Vec<[u32; 3]>,
    /// The first triangle of every patch, and their number at the end.
    pub first_triangle: Vec<u32>,
}

/// Points and triangles that edges of `levels` add to a map: of each finer edge its inner points and what closes the gap.
fn added(map: ParametricMap, levels: [u32; 4]) -> [u64; 2] {
    let finer = levels.into_iter().filter(|level| *level > map.level()).map(|level| (2u64 << level) - 1);
    finer.fold([0; 2], |[points, triangles], n| [points + n - 1, triangles + n + u64::from(map.segments()) - 2])
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
            let [points, triangles] = added(map, levels.edges(patch));
            counts[0] += (map.samples() + points) as usize;
            counts[1] += (map.triangles() + triangles) as usize;
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
        let (mut grids, mut finer, mut triangles) = (0u64, 0u64, 0u64);
        let mut first = Vec::with_capacity(self.count() + 1);
        for patch in 0..self.count() {
            first.push(grids as u32);
            let map = ParametricMap::new(levels.patch(patch))?;
            let [more, beside] = added(map, levels.edges(patch));
            grids += map.samples();
            finer += more;
            triangles += map.triangles() + beside;
            if (grids + finer).max(3 * triangles) > u64::from(u32::MAX) {
                return Err(
                    Error::invalid("the surface has more triangles than 32 bits count").advise("use lower levels")
                );
            }
        }
        first.push(grids as u32);
        let points = grids + finer;
        let bytes = 24 * points + 12 * triangles;
        if bytes > context.memory_limit() {
            return Err(Error::memory(format!("the triangles need {bytes} bytes, more than the memory limit"))
                .advise("use lower levels, or raise the memory limit"));
        }
        let tables: Vec<Table> = (1..=super::MAX_LEVEL).map(Table::new).collect::<Result<_>>()?;
        let mut tessellation = BezierTessellation {
            points: vec![[0.0; 3]; points as usize],
            normals: vec![[0.0; 3]; points as usize],
            first,
            ..BezierTessellation::default()
        };
        let mut pieces = Vec::with_capacity(self.count());
        let (mut rest, mut beside) = tessellation.points.split_at_mut(grids as usize);
        let (mut normals, mut normals_beside) = tessellation.normals.split_at_mut(grids as usize);
        let mut next = grids as u32;
        for patch in 0..self.count() {
            let map = ParametricMap::new(levels.patch(patch))?;
            let [more, _] = added(map, levels.edges(patch));
            let grid = Cut { points: front(&mut rest, map.samples()), normals: front(&mut normals, map.samples()) };
            let finer = Cut { points: front(&mut beside, more), normals: front(&mut normals_beside, more) };
            pieces.push((grid, finer, next, Vec::new()));
            next += more as u32;
        }
        context.for_each_mut(&mut pieces, |patch, (grid, finer, next, triangles)| {
            let table = &tables[levels.patch(patch) as usize - 1];
            let first = tessellation.first[patch];
            evaluate_grid(context.level(), self.controls(patch), self.is_rational(), table, grid.points, grid.normals);
            self.finish_grid(patch, table, grid);
            triangles.extend(grid_triangles(table.map, first));
            self.stitch(patch, levels.edges(patch), table.map, [first, *next], finer, triangles);
        });
        tessellation.first_triangle = Vec::with_capacity(pieces.len() + 1);
        tessellation.first_triangle.push(0);
        let mut all = Vec::with_capacity(triangles as usize);
        for (_, _, _, triangles) in &pieces {
            all.extend_from_slice(triangles);
            tessellation.first_triangle.push(all.len() as u32);
        }
        tessellation.triangles = all;
        Ok(tessellation)
    }

    /// Puts the samples of edges where both sides have them, and normals that have no length at their limits.
    fn finish_grid(&self, patch: usize, table: &Table, Cut { points, normals }: &mut Cut<'_>) {
        let (side, n) = (table.map.side(), table.map.segments());
        let controls = self.controls(patch);
        let senses = self.edges().senses(patch);
        // Collapsed edges last: their ends are corners whose limit is theirs.
        let mut order = [0, 1, 2, 3];
        order.sort_by_key(|edge| senses[*edge] == EdgeSense::Collapsed);
        for edge in order {
            let canonical = canonical_curve(controls, edge, senses[edge]);
            for k in 0..=n {
                let [i, j] = table.map.along(edge, k);
                let at = (j * side + i) as usize;
                points[at] = curve_point(&canonical, senses[edge].segment(k, n), n);
                // Where an edge is a point its tangents are rounding, and so they may be at corners.
                if senses[edge] == EdgeSense::Collapsed || k == 0 {
                    normals[at] = self.normal_on_edge(patch, edge, f64::from(k) / f64::from(n));
                }
            }
        }
        for (at, normal) in normals.iter_mut().enumerate().filter(|(_, normal)| **normal == [0.0; 3]) {
            let [u, v] = [at % side as usize, at / side as usize].map(|k| k as f64 / f64::from(n));
            *normal = self.limit_normal(patch, &Forms::new(controls, u, v), u, v);
        }
    }

    fn normal_on_edge(&self, patch: usize, edge: usize, t: f64) -> [f32; 3] {
        let (u, v) = [(t, 0.0), (1.0, t), (1.0 - t, 1.0), (0.0, 1.0 - t)][edge & 3];
        self.limit_normal(patch, &Forms::new(self.controls(patch), u, v), u, v)
    }

    /// The points of finer edges, numbered from the second of `first` on, and the triangles between them and the grid,
    /// whose points are numbered from the first.
    fn stitch(
        &self,
        patch: usize,
        levels: [u32; 4],
        map: ParametricMap,
        [grid, mut next]: [u32; 2],
        Cut { points, normals }: &mut Cut<'_>,
        triangles: &mut Vec<[u32; 3]>,
    ) {
        let mut at = 0;
        for (edge, level) in levels.into_iter().enumerate().filter(|(_, level)| *level > map.level()) {
            let (sense, n) = (self.edges().senses(patch)[edge], (2 << level) - 1);
            let canonical = canonical_curve(self.controls(patch), edge, sense);
            for k in 1..n {
                points[at] = curve_point(&canonical, sense.segment(k, n), n);
                normals[at] = self.normal_on_edge(patch, edge, f64::from(k) / f64::from(n));
                at += 1;
            }
            let number = |corner: Stitch| match corner {
                Stitch::Own(k) => {
                    let [i, j] = map.along(edge, k);
                    grid + j * map.side() + i
                }
                Stitch::Finer(k) => next + k - 1,
            };
            triangles.extend(stitches(map.segments(), n).map(|corners| corners.map(number)));
            next += n - 1;
        }
    }
}

/// Points and normals of a part of a patch.
struct Cut<'a> {
    points: &'a mut [[f32; 3]],
    normals: &'a mut [[f32; 3]],
}

/// Takes the first `count` items of a list away.
fn front<'a>(list: &mut &'a mut [[f32; 3]], count: u64) -> &'a mut [[f32; 3]] {
    list.split_off_mut(..count as usize).unwrap_or_default()
}

/// The control points along an edge, in its one direction.
fn canonical_curve(controls: &[[f32; 4]; 16], edge: usize, sense: EdgeSense) -> [[f32; 4]; 4] {
    let mut canonical = curve(controls, edge);
    if sense == EdgeSense::Against {
        canonical.reverse();
    }
    canonical
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
    fn evaluate_grid = grid_body(
        controls: &[[f32; 4]; 16], rational: bool, table: &Table, points: &mut [[f32; 3]], normals: &mut [[f32; 3]]
    )
}

/// Samples evaluated together.
const LANES: usize = 16;

/// Evaluates all samples of a patch, 16 columns at a time: rows of control points to a curve for each column, then along
/// the columns. Normals without a length become zero.
#[inline(always)]
fn grid_body<A: Arithmetic>(
    _: A,
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

/// The triangles of a patch's grid, whose points are numbered from `first` on.
fn grid_triangles(map: ParametricMap, first: u32) -> impl Iterator<Item = [u32; 3]> {
    let (side, n) = (map.side(), map.segments());
    let cells = (0..n).flat_map(move |j| (0..n).map(move |i| [i, j]));
    cells.flat_map(move |[i, j]| CELL.map(|corners| corners.map(|[right, up]| first + (j + up) * side + i + right)))
}
