//! Attributes of a mesh that is simplified (Hoppe 1999, memoryless).
//!
//! A vertex has a wedge for each set of values that its triangles have there. What a wedge knows of its triangles is the
//! quadric of how far values deviate from the values that the triangles have, extended over their planes: seen from the
//! vertex and from its values, so that all of it goes through the origin. The best values of a place follow from the
//! quadrics of both wedges that are merged; without the values, the rest is a quadric of the place alone.

use std::sync::atomic::{AtomicU32, Ordering::Relaxed};

use glam::{Vec2, Vec3, Vec4, Vec4Swizzles};
use relievo_core::Context;

use crate::connectivity::{BOUNDARY, Connectivity, FIXED, Fan, NONE, SEAM, next, previous};

/// Least squared sine at a corner of a triangle whose values are treated as different.
const FLAT: f32 = 1e-8;

/// Wedges with four numbers of attributes `Q` times. With none of them all of it is empty.
#[derive(Default)]
pub struct Wedges<const Q: usize> {
    /// Those of every triangle's corners, and the triangle's number in the input.
    corners: Vec<[AtomicU32; 4]>,
    /// Numbers of every wedge.
    values: Vec<[Vec4; Q]>,
    /// What the wedges of every vertex know: one of them, and the other one where there are two.
    sums: [Vec<[Sums; Q]>; 2],
    range: Range<Q>,
}

/// What bounds the numbers.
#[derive(Clone)]
pub struct Range<const Q: usize> {
    /// Squares of the lengths that differences of 1 count as.
    pub squares: [Vec4; Q],
    pub low: [Vec4; Q],
    pub high: [Vec4; Q],
    /// Where directions start, of three numbers each.
    pub directions: Vec<usize>,
    /// Where texture coordinates start, of two numbers each.
    pub uvs: Vec<usize>,
}

impl<const Q: usize> Default for Range<Q> {
    fn default() -> Self {
        Self {
            squares: [Vec4::ZERO; Q],
            low: [Vec4::MIN; Q],
            high: [Vec4::MAX; Q],
            directions: Vec::new(),
            uvs: Vec::new(),
        }
    }
}

/// What a wedge knows of its triangles, of four numbers.
#[derive(Clone, Copy, Default)]
pub struct Sums {
    /// Gradients times areas.
    gradients: [Vec4; 3],
    /// Σ g gᵀ times areas and squared weights, of all four: xx, yy, zz, xy, xz, yz.
    squares: [f32; 6],
    /// Areas.
    area: f32,
    /// Whose it is.
    wedge: u32,
}

/// A quadric of places from the middle of an edge: xᵀ A x − 2 bᵀ x + c.
#[derive(Clone, Copy, Default)]
pub struct Quadric {
    /// A as xx, yy, zz, xy, xz, yz.
    pub square: [f32; 6],
    pub linear: Vec3,
    pub constant: f32,
    /// What the trace of A was before values were taken out of it, which tells how large its rounding is.
    pub trace: f32,
}

/// A symmetric matrix times a vector.
fn times(m: &[f32; 6], x: Vec3) -> Vec3 {
    let [xx, yy, zz, xy, xz, yz] = *m;
    Vec3::new(xx * x.x + xy * x.y + xz * x.z, xy * x.x + yy * x.y + yz * x.z, xz * x.x + yz * x.y + zz * x.z)
}

/// Four gradients along a vector.
fn along(gradients: &[Vec4; 3], x: Vec3) -> Vec4 {
    gradients[0] * x.x + gradients[1] * x.y + gradients[2] * x.z
}

/// An edge, its vertices and from the first to the second.
#[derive(Clone, Copy)]
pub struct Span {
    pub corner: u32,
    pub ends: [u32; 2],
    pub along: Vec3,
}

impl<const Q: usize> Wedges<Q> {
    /// Bytes of it, and of what it is made from, for a triangle with a vertex, at most; with room for compaction.
    pub const BYTES: u64 = (4 * size_of::<[Sums; Q]>() + 2 * size_of::<[Vec4; Q]>() + 64) as u64;

    /// Of triangles that have wedges with values.
    pub fn new(
        context: &Context,
        vertices: usize,
        wedges: &[[u32; 3]],
        values: Vec<[Vec4; Q]>,
        range: Range<Q>,
    ) -> Self {
        let corners = |index: usize| {
            let [a, b, c] = wedges[index];
            [a, b, c, index as u32].map(AtomicU32::new)
        };
        let sums = [(); 2].map(|()| vec![[Sums::default(); Q]; vertices]);
        Self { corners: context.map(wedges.len(), corners), values, sums, range }
    }

    /// Nothing, of so many vertices.
    pub fn none(vertices: usize) -> Self {
        let sums = [(); 2].map(|()| vec![[Sums::default(); Q]; vertices]);
        Self { sums, ..Self::default() }
    }

    /// The wedge of a corner.
    fn wedge(&self, corner: u32) -> u32 {
        self.corners.as_flattened()[corner as usize].load(Relaxed)
    }

    /// The wedges of a triangle, and its number in the input.
    pub fn triangle(&self, triangle: usize) -> ([u32; 3], u32) {
        let [a, b, c, number] = self.corners[triangle].each_ref().map(|wedge| wedge.load(Relaxed));
        ([a, b, c], number)
    }

    /// The numbers of a wedge.
    pub fn values(&self, wedge: u32) -> &[Vec4; Q] {
        &self.values[wedge as usize]
    }

    /// Whether triangles on both sides of a half-edge have different wedges there.
    #[inline(always)]
    pub fn is_seam(&self, mesh: &Connectivity, corner: u32) -> bool {
        if Q == 0 {
            return false;
        }
        let mate = mesh.mate(corner);
        mate != NONE && (self.wedge(corner) != self.wedge(next(mate)) || self.wedge(next(corner)) != self.wedge(mate))
    }

    /// Marks vertices at seams. Vertices that are not where exactly one seam passes, away from boundaries, are fixed.
    pub fn mark(&self, context: &Context, mesh: &mut Connectivity) {
        let known = &*mesh;
        let flags = context.map(mesh.flags.len(), |vertex| {
            let (mut found, mut wedges, mut seams) = ([NONE; 2], 0, 0);
            for corner in known.around(vertex as u32) {
                seams += usize::from(self.is_seam(known, corner));
                let wedge = self.wedge(corner);
                if !found.contains(&wedge) {
                    found[wedges.min(1)] = wedge;
                    wedges += 1;
                }
            }
            let old = known.flags[vertex];
            match (seams, wedges) {
                (0, 0 | 1) => old,
                (2, 2) if old & BOUNDARY == 0 => old | SEAM,
                _ => old | SEAM | FIXED,
            }
        });
        mesh.flags = flags;
    }

    /// The lists of sums, to be renewed for parts of the vertices, and what that needs.
    pub fn split(&mut self) -> (&mut [[Sums; Q]], &mut [[Sums; Q]], Sight<'_, Q>) {
        let Self { corners, values, sums: [first, second], range } = self;
        (first, second, Sight { corners, values, squares: &range.squares })
    }

    fn sums(&self, vertex: u32, wedge: u32) -> &[Sums; Q] {
        let first = &self.sums[0][vertex as usize];
        if first[0].wedge == wedge { first } else { &self.sums[1][vertex as usize] }
    }

    /// The wedges that become one each when a half-edge is collapsed, of its start and its end.
    fn pairs(&self, mesh: &Connectivity, corner: u32) -> impl Iterator<Item = [u32; 2]> {
        let pair = [corner, next(corner)].map(|corner| self.wedge(corner));
        let mate = mesh.mate(corner);
        let other = (mate != NONE).then(|| [next(mate), mate].map(|corner| self.wedge(corner)));
        [Some(pair), other.filter(|other| *other != pair)].into_iter().flatten()
    }

    /// What collapsing an edge costs by its attributes; `pinned` as in a batch.
    pub fn quadric(&self, mesh: &Connectivity, span: &Span, pinned: f32) -> Quadric {
        let mut whole = Quadric::default();
        for pair in self.pairs(mesh, span.corner) {
            if pinned == 0.0 {
                self.add_free(&mut whole, span, pair);
            } else {
                let stays = usize::from(pinned > 0.0);
                whole.constant += self.moved(span, pair, stays);
            }
        }
        whole
    }

    /// How values deviate if one of two wedges goes to where the other one is, and takes its values.
    fn moved(&self, span: &Span, pair: [u32; 2], stays: usize) -> f32 {
        let goes = 1 - stays;
        let to = if stays == 0 { -span.along } else { span.along };
        let sums = self.sums(span.ends[goes], pair[goes]);
        let mut cost = 0.0;
        for (q, Sums { gradients, squares, area, .. }) in sums.iter().enumerate() {
            let weights = self.range.squares[q];
            let change = self.values(pair[stays])[q] - self.values(pair[goes])[q];
            let foreseen = along(gradients, to);
            cost += to.dot(times(squares, to)) + (weights * change).dot(change * *area - 2.0 * foreseen);
        }
        cost.max(0.0)
    }

    /// Adds the quadric of places of two wedges that are merged with the values that are best at each place.
    fn add_free(&self, whole: &mut Quadric, span: &Span, [start, end]: [u32; 2]) {
        let half = 0.5 * span.along;
        let (u, v) = (self.sums(span.ends[0], start), self.sums(span.ends[1], end));
        for q in 0..Q {
            let (weights, d) = (self.range.squares[q], 0.5 * (self.values(end)[q] - self.values(start)[q]));
            let Merged { sum, difference, area, offset } = Merged::new(&u[q], &v[q], d, half);
            let squares: [f32; 6] = std::array::from_fn(|k| u[q].squares[k] + v[q].squares[k]);
            let turned: [f32; 6] = std::array::from_fn(|k| v[q].squares[k] - u[q].squares[k]);
            let shared = weights / area.max(f32::MIN_POSITIVE);
            for (k, (x, y)) in [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)].into_iter().enumerate() {
                whole.square[k] += squares[k] - (shared * sum[x]).dot(sum[y]);
            }
            let linear = |axis: usize| (weights * d).dot(difference[axis]) + (shared * offset).dot(sum[axis]);
            whole.linear += times(&turned, half) + Vec3::new(linear(0), linear(1), linear(2));
            whole.constant += half.dot(times(&squares, half)) - 2.0 * (weights * d).dot(along(&sum, half))
                + area * (weights * d).dot(d)
                - (shared * offset).dot(offset);
            whole.trace += squares[0] + squares[1] + squares[2];
        }
    }

    /// The values that wedges have after a collapse to `place`, from the middle of the edge.
    pub fn merged(&self, mesh: &Connectivity, span: Span, place: Vec3) -> impl Iterator<Item = (u32, [Vec4; Q])> {
        let half = 0.5 * span.along;
        self.pairs(mesh, span.corner).map(move |[start, end]| {
            let (u, v) = (self.sums(span.ends[0], start), self.sums(span.ends[1], end));
            let mut values = std::array::from_fn(|q| {
                let (from, to) = (self.values(start)[q], self.values(end)[q]);
                let Merged { sum, area, offset, .. } = Merged::new(&u[q], &v[q], 0.5 * (to - from), half);
                let change = (along(&sum, place) + offset) / area.max(f32::MIN_POSITIVE);
                (0.5 * (from + to) + change).clamp(self.range.low[q], self.range.high[q])
            });
            for first in &self.range.directions {
                let at = [*first, first + 1, first + 2].map(|number| (number / 4, number % 4));
                let direction = Vec3::from(at.map(|(q, lane)| values[q][lane]));
                // Opposite ones leave nothing to go by.
                let unit = direction.try_normalize().unwrap_or(Vec3::from(at.map(|(q, k)| self.values(start)[q][k])));
                at.into_iter().zip(unit.to_array()).for_each(|((q, lane), number)| values[q][lane] = number);
            }
            (start, values)
        })
    }

    /// Whether there are texture coordinates among the numbers.
    pub fn has_textures(&self) -> bool {
        !self.range.uvs.is_empty()
    }

    /// Whether no triangle is turned over in a texture, or vanishes there, when a half-edge is collapsed. `merged` are the
    /// values of the wedges that become one, as [`Self::merged`] has them, where both vertices move; otherwise the end
    /// stays, or the start.
    pub fn keeps_textures(
        &self,
        mesh: &Connectivity,
        (corner, end_stays): (u32, bool),
        fans: &[Fan; 2],
        merged: [Option<[Vec4; Q]>; 2],
    ) -> bool {
        let stays = usize::from(end_stays);
        let mut renewed = [None; 2];
        for ((pair, values), renewed) in self.pairs(mesh, corner).zip(merged).zip(&mut renewed) {
            *renewed = Some((pair, values.unwrap_or(*self.values(pair[stays]))));
        }
        let gone = [corner, mesh.mate(corner)].map(|side| side / 4);
        let spokes = fans.iter().enumerate().flat_map(|(end, fan)| fan.spokes().iter().map(move |spoke| (end, spoke)));
        spokes.filter(|(_, spoke)| !gone.contains(&(spoke.corner / 4))).all(|(end, spoke)| {
            let own = self.wedge(spoke.corner);
            let new = renewed.iter().flatten().find(|(pair, _)| pair[end] == own);
            let Some((_, new)) = new else { return true };
            let others = [next(spoke.corner), previous(spoke.corner)].map(|at| self.values(self.wedge(at)));
            self.range.uvs.iter().all(|first| {
                let place =
                    |values: &[Vec4; Q]| Vec2::from([*first, first + 1].map(|number| values[number / 4][number % 4]));
                let [a, b] = others.map(place);
                let area = |values: &[Vec4; Q]| (a - place(values)).perp_dot(b - place(values));
                let (before, after) = (area(self.values(own)), area(new));
                before == 0.0 || (after != 0.0 && (before > 0.0) == (after > 0.0))
            })
        })
    }

    /// Gives wedges new values.
    pub fn set(&mut self, renewed: Vec<(u32, [Vec4; Q])>) {
        renewed.into_iter().for_each(|(wedge, values)| self.values[wedge as usize] = values);
    }

    /// Merges the wedges of a half-edge before it is collapsed, into those of its start, or of its end if that stays.
    pub fn collapse(&self, mesh: &Connectivity, corner: u32, end_stays: bool) {
        let vertex = mesh.vertex(if end_stays { corner } else { next(corner) });
        let (stays, goes) = if end_stays { (1, 0) } else { (0, 1) };
        for pair in self.pairs(mesh, corner).collect::<Vec<_>>() {
            for at in mesh.around(vertex).filter(|at| self.wedge(*at) == pair[goes]) {
                self.corners.as_flattened()[at as usize].store(pair[stays], Relaxed);
            }
        }
    }

    /// The wedges that become one each when a half-edge is collapsed, once [`Self::set`] has their values: that which goes
    /// on and that which goes, with the values.
    pub fn joined(
        &self,
        mesh: &Connectivity,
        corner: u32,
        end_stays: bool,
    ) -> impl Iterator<Item = ([u32; 2], &[Vec4; Q])> {
        let (stays, goes) = if end_stays { (1, 0) } else { (0, 1) };
        let mut last = NONE;
        // What goes into one wedge is not there for another.
        let pairs = self.pairs(mesh, corner).filter(move |pair| std::mem::replace(&mut last, pair[goes]) != pair[goes]);
        pairs.map(move |pair| ([pair[stays], pair[goes]], self.values(pair[stays])))
    }

    /// Leaves out all triangles but those `kept`, and all vertices but the `rest`.
    pub fn compact(&mut self, context: &Context, kept: &[u32], rest: &[u32]) {
        if Q > 0 {
            let corners =
                |index: usize| self.corners[kept[index] as usize].each_ref().map(|it| it.load(Relaxed).into());
            self.corners = context.map(kept.len(), corners);
        }
        let sums = |list: &Vec<[Sums; Q]>| context.map(rest.len(), |index| list[rest[index] as usize]);
        self.sums = self.sums.each_ref().map(sums);
    }
}

/// Four numbers of two wedges that become one.
struct Merged {
    /// Gradients of both, and of the start less those of the end.
    sum: [Vec4; 3],
    difference: [Vec4; 3],
    area: f32,
    /// The best values in the middle of the edge, less their mean, times the area.
    offset: Vec4,
}

impl Merged {
    /// With half of what values change from the start to the end, and half of the edge.
    fn new(u: &Sums, v: &Sums, d: Vec4, half: Vec3) -> Self {
        let difference = std::array::from_fn(|axis| u.gradients[axis] - v.gradients[axis]);
        Self {
            sum: std::array::from_fn(|axis| u.gradients[axis] + v.gradients[axis]),
            difference,
            area: u.area + v.area,
            offset: along(&difference, half) - d * (u.area - v.area),
        }
    }
}

/// What wedges see of the mesh.
#[derive(Clone, Copy)]
pub struct Sight<'a, const Q: usize> {
    corners: &'a [[AtomicU32; 4]],
    values: &'a [[Vec4; Q]],
    squares: &'a [Vec4; Q],
}

impl<const Q: usize> Sight<'_, Q> {
    /// As [`Wedges::is_seam`].
    #[inline(always)]
    pub fn is_seam(&self, mesh: &Connectivity, corner: u32) -> bool {
        let wedge = |corner: u32| self.corners.as_flattened()[corner as usize].load(Relaxed);
        let mate = mesh.mate(corner);
        Q > 0 && mate != NONE && (wedge(corner) != wedge(next(mate)) || wedge(next(corner)) != wedge(mate))
    }

    /// Finds what the wedges of a vertex know, which are two at most.
    #[inline(always)]
    pub fn renew(&self, mesh: &Connectivity, points: &[Vec4], vertex: u32, sums: [&mut [Sums; Q]; 2]) {
        let wedge = |corner: u32| self.corners.as_flattened()[corner as usize].load(Relaxed);
        let place = |corner: u32| points[mesh.vertex(corner) as usize].xyz();
        let here = points[vertex as usize].xyz();
        let mut found = [[Sums { wedge: NONE, ..Sums::default() }; Q]; 2];
        for corner in mesh.around(vertex) {
            let (after, before) = (next(corner), previous(corner));
            let own = wedge(corner);
            let slot = usize::from(found[0][0].wedge != NONE && found[0][0].wedge != own);
            let (a, b) = (place(after) - here, place(before) - here);
            let normal = a.cross(b);
            let area = normal.length();
            let is_flat = !(normal.length_squared() > FLAT * a.length_squared() * b.length_squared());
            let (to_after, to_before) = (b.cross(normal) / area, normal.cross(a) / area);
            let [values, at_after, at_before] = [own, wedge(after), wedge(before)].map(|it| &self.values[it as usize]);
            for (q, sums) in found[slot].iter_mut().enumerate() {
                sums.wedge = own;
                sums.area += area;
                if is_flat {
                    continue;
                }
                let changes = [at_after[q] - values[q], at_before[q] - values[q]];
                let gradient = |axis: usize| changes[0] * to_after[axis] + changes[1] * to_before[axis];
                let gradient: [Vec4; 3] = std::array::from_fn(gradient);
                let weighted = gradient.map(|row| row * self.squares[q] / area);
                for (k, (x, y)) in [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)].into_iter().enumerate() {
                    sums.squares[k] += weighted[x].dot(gradient[y]);
                }
                (0..3).for_each(|axis| sums.gradients[axis] += gradient[axis]);
            }
        }
        let [first, second] = sums;
        [*first, *second] = found;
    }
}
