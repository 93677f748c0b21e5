//! Triangles as corners in lists round their vertices, for meshes that are manifold or not.
//!
//! The corners at a vertex are side by side, in a span of one long list: what reads them waits for memory once. A vertex
//! that takes those of another over has a new span at the end.
//!
//! A corner is a triangle's place at a vertex, and stands for the half-edge from its vertex to that of the next corner.
//! Half-edges of the same edge in opposite directions are mates, where they are two; vertices at any other edge, or at
//! which several fans of triangles meet, are fixed. Numbers are atomic so that collapses whose triangles have nothing in
//! common are made at the same time.

use std::sync::atomic::{AtomicU32, Ordering::Relaxed};

use relievo_core::simd::prefetch;
use relievo_core::{Context, Result};

use crate::mates;

/// No corner, no triangle, no vertex.
pub const NONE: u32 = u32::MAX;

/// A vertex with an edge of one triangle.
pub const BOUNDARY: u8 = 1;
/// A vertex that stays where it is.
pub const FIXED: u8 = 2;

/// A vertex where values of attributes differ from one triangle to the next.
pub const SEAM: u8 = 4;
/// A vertex some of whose triangles are in other patches.
pub const OUTSIDE: u8 = 8;

/// Vertices or triangles that are worked on by one task.
pub const CHUNK_LEN: usize = 4096;

/// Room in the list of corners, for each triangle, for three and for corners that move until what is gone is left out.
const ROOM: usize = 5;

/// The part of [`CHUNK_LEN`] triangles that a vertex belongs to, that of one of its triangles, and how many of the last bits of
/// the numbers of parts must not count for it to be in the same one as those around were when parts were made.
#[derive(Clone, Copy)]
pub struct Part(u32);

impl Part {
    /// The bits of the number.
    const NUMBER: u32 = (1 << 24) - 1;

    fn of(corner: u32) -> Self {
        Self(corner / (4 * CHUNK_LEN as u32))
    }

    fn reaching(self, bits: u32) -> Self {
        Self(self.0 | bits << 24)
    }

    /// The number, without so many of its last bits.
    #[inline(always)]
    pub fn number(self, bits: u32) -> u32 {
        (self.0 & Self::NUMBER) >> bits
    }

    /// Whether those around had the same number, without so many of its last bits.
    #[inline(always)]
    pub fn is_inner(self, bits: u32) -> bool {
        self.0 >> 24 <= bits
    }
}

/// The corners of a mesh.
#[derive(Default)]
pub struct Connectivity {
    vertex: Vec<[AtomicU32; 3]>,
    mate: Vec<[AtomicU32; 3]>,
    /// The corners at vertices, [`NONE`] for those whose triangles are gone.
    corners: Vec<AtomicU32>,
    /// Where those of every vertex start, and how many they are.
    spans: Vec<[AtomicU32; 2]>,
    /// [`BOUNDARY`], [`FIXED`] and [`SEAM`] of every vertex.
    pub flags: Vec<u8>,
}

/// The corner after `corner` in its triangle.
#[inline(always)]
pub fn next(corner: u32) -> u32 {
    corner + 1 - if corner & 3 == 2 { 3 } else { 0 }
}

/// The corner before `corner` in its triangle.
#[inline(always)]
pub fn previous(corner: u32) -> u32 {
    corner + if corner & 3 == 0 { 3 } else { 0 } - 1
}

/// The number of a corner in a list of all corners.
#[inline(always)]
pub fn slot(corner: u32) -> usize {
    (corner - corner / 4) as usize
}

/// A corner, the vertex after it and the vertex before it.
#[derive(Clone, Copy, Default)]
pub struct Spoke {
    pub corner: u32,
    pub to: u32,
    pub from: u32,
}

/// The corners at a vertex.
#[derive(Default)]
pub struct Fan {
    spokes: [Spoke; Self::MAX],
    open: [u32; Self::MAX],
    size: usize,
    opened: usize,
}

impl Fan {
    /// Corners of a fan at most.
    pub const MAX: usize = 32;

    /// Whether there may be more corners than these.
    pub fn is_full(&self) -> bool {
        self.size == Self::MAX
    }

    /// The corners.
    #[inline(always)]
    pub fn spokes(&self) -> &[Spoke] {
        &self.spokes[..self.size]
    }

    /// The vertices that share an edge with that of the fan. Those of a fixed vertex may come twice.
    #[inline(always)]
    pub fn ring(&self) -> impl Iterator<Item = u32> {
        self.spokes().iter().map(|spoke| spoke.to).chain(self.open[..self.opened].iter().copied())
    }
}

impl Connectivity {
    /// Of triangles whose indices are below `vertices`.
    pub fn new(context: &Context, vertices: usize, triangles: &[[u32; 3]]) -> Result<Self> {
        let mut spans = vec![[0u32; 2]; vertices];
        triangles.as_flattened().iter().for_each(|vertex| spans[*vertex as usize][1] += 1);
        let mut start = 0;
        for span in &mut spans {
            let size = span[1];
            *span = [start, start];
            start += size;
        }
        let mut corners = Vec::with_capacity(ROOM * triangles.len());
        corners.resize(3 * triangles.len(), 0);
        for (index, triangle) in (0..).zip(triangles) {
            for (side, vertex) in (0..).zip(triangle) {
                let end = &mut spans[*vertex as usize][1];
                corners[*end as usize] = 4 * index + side;
                *end += 1;
            }
        }
        let mut made = Self {
            vertex: context.map(triangles.len(), |triangle| {
                let [a, b, c] = triangles[triangle];
                [a, b, c].map(AtomicU32::new)
            }),
            mate: context.map(triangles.len(), |_| [NONE; 3].map(AtomicU32::new)),
            corners: corners.into_iter().map(AtomicU32::new).collect(),
            spans: spans.into_iter().map(|[start, end]| [start, end - start].map(AtomicU32::new)).collect(),
            flags: Vec::new(),
        };
        made.flags = mates::find(context, &made, vertices)?;
        Ok(made)
    }

    /// Number of triangles, with triangles that are gone.
    pub fn triangles(&self) -> usize {
        self.vertex.len()
    }

    /// The part of every vertex.
    pub fn parts(&self, context: &Context) -> Vec<Part> {
        let part = |vertex| self.around(vertex as u32).next().map_or(Part(Part::NUMBER), Part::of);
        let own = context.map(self.spans.len(), part);
        context.map(own.len(), |vertex| {
            let end = |corner| own[self.vertex(next(corner)) as usize].0 ^ own[vertex].0;
            let other = self.around(vertex as u32).map(end).fold(0, |other, end| other | end);
            own[vertex].reaching(u32::BITS - other.leading_zeros())
        })
    }

    /// The vertex of a corner, [`NONE`] where the triangle is gone.
    #[inline(always)]
    pub fn vertex(&self, corner: u32) -> u32 {
        self.vertex.as_flattened()[slot(corner)].load(Relaxed)
    }

    /// How many corners there are at a vertex, with corners that went since they were looked at.
    pub fn valence(&self, vertex: u32) -> usize {
        self.span(vertex).len()
    }

    /// Whether a vertex has no triangle.
    pub fn is_gone(&self, vertex: u32) -> bool {
        self.spans[vertex as usize][1].load(Relaxed) == 0
    }

    /// Where the corners at a vertex are.
    #[inline(always)]
    pub fn span(&self, vertex: u32) -> &[AtomicU32] {
        let [start, size] = &self.spans[vertex as usize];
        let start = start.load(Relaxed) as usize;
        &self.corners[start..start + size.load(Relaxed) as usize]
    }

    /// The vertices of a triangle.
    #[inline(always)]
    pub fn triangle(&self, triangle: usize) -> [u32; 3] {
        let [a, b, c] = &self.vertex[triangle];
        [a.load(Relaxed), b.load(Relaxed), c.load(Relaxed)]
    }

    /// The half-edge on the other side, if there is one.
    #[inline(always)]
    pub fn mate(&self, corner: u32) -> u32 {
        self.mate.as_flattened()[slot(corner)].load(Relaxed)
    }

    /// Notes which half-edge is on the other side.
    #[inline(always)]
    pub fn set_mate(&self, corner: u32, mate: u32) {
        self.mate.as_flattened()[slot(corner)].store(mate, Relaxed);
    }

    /// The corners at a vertex.
    #[inline(always)]
    pub fn around(&self, vertex: u32) -> impl Iterator<Item = u32> {
        self.span(vertex).iter().map(|corner| corner.load(Relaxed)).filter(|corner| *corner != NONE)
    }

    /// Puts the corners at a vertex into `fan`, as [`Self::around`], until it is full.
    #[inline(always)]
    pub fn fan(&self, vertex: u32, fan: &mut Fan) {
        let inner = self.flags[vertex as usize] == 0;
        (fan.size, fan.opened) = (0, 0);
        for (spoke, corner) in fan.spokes.iter_mut().zip(self.around(vertex)) {
            let before = previous(corner);
            *spoke = Spoke { corner, to: self.vertex(next(corner)), from: self.vertex(before) };
            if !inner && self.mate(before) == NONE {
                fan.open[fan.opened] = spoke.from;
                fan.opened += 1;
            }
            fan.size += 1;
        }
    }

    /// Visits the corners at a vertex, and takes those whose triangles are gone out of its list.
    #[inline(always)]
    pub fn clean(&self, vertex: u32, mut visit: impl FnMut(u32)) {
        let span = self.span(vertex);
        let mut left = 0;
        for corner in span {
            let corner = corner.load(Relaxed);
            if corner != NONE {
                visit(corner);
                span[left].store(corner, Relaxed);
                left += 1;
            }
        }
        self.spans[vertex as usize][1].store(left as u32, Relaxed);
    }

    /// Asks for where the corners at a vertex are to be brought near.
    #[inline(always)]
    pub fn prefetch(&self, vertex: u32) {
        prefetch(&self.spans, vertex as usize);
    }

    /// Asks for a corner's vertex to be brought near.
    #[inline(always)]
    pub fn prefetch_corner(&self, corner: u32) {
        prefetch(&self.vertex, corner as usize / 4);
    }

    /// Makes room for so many more corners. Returns where it starts.
    pub fn grow(&mut self, more: usize) -> usize {
        let start = self.corners.len();
        self.corners.resize_with(start + more, || AtomicU32::new(NONE));
        start
    }

    /// As [`Self::grow`], where nothing else is worked on: what is left of the list is moved together if there is no room.
    pub fn grow_alone(&mut self, more: usize) -> usize {
        if self.corners.len() + more > self.corners.capacity() {
            let mut corners = Vec::with_capacity(self.corners.capacity());
            for vertex in 0..self.spans.len() {
                let start = corners.len();
                corners.extend(self.around(vertex as u32).map(AtomicU32::new));
                self.spans[vertex] = [start, corners.len() - start].map(|number| AtomicU32::new(number as u32));
            }
            self.corners = corners;
        }
        self.grow(more)
    }

    /// Collapses the half-edge of `corner`: the vertex where it ends becomes that where it starts, whose corners are
    /// put at `start`, where there is room for one more, and the triangles of the edge go. Returns how many.
    pub fn collapse(&self, corner: u32, start: usize) -> usize {
        let (kept, gone) = (self.vertex(corner), self.vertex(next(corner)));
        let sides = [corner, self.mate(corner)];
        let mut size = 0;
        for at in self.around(kept).chain(self.around(gone)) {
            self.vertex.as_flattened()[slot(at)].store(kept, Relaxed);
            // What goes is not foreseen: no branch. Beyond the last one is room for another.
            self.corners[start + size].store(at, Relaxed);
            size += usize::from(sides.iter().all(|side| at / 4 != side / 4));
        }
        let [from, count] = &self.spans[kept as usize];
        from.store(start as u32, Relaxed);
        count.store(size as u32, Relaxed);
        self.spans[gone as usize][1].store(0, Relaxed);
        for side in sides.into_iter().filter(|side| *side != NONE) {
            let (after, before) = (self.mate(next(side)), self.mate(previous(side)));
            for (one, other) in [(after, before), (before, after)] {
                if one != NONE {
                    self.set_mate(one, other);
                }
            }
            let opposite = previous(side);
            for at in self.span(self.vertex(opposite)).iter().filter(|at| at.load(Relaxed) == opposite) {
                at.store(NONE, Relaxed);
            }
            for at in &self.vertex[side as usize / 4] {
                at.store(NONE, Relaxed);
            }
        }
        1 + usize::from(sides[1] != NONE)
    }

    /// Leaves out what is gone. `kept` and `rest` have the numbers of the triangles and the vertices that stay.
    pub fn compact(&mut self, context: &Context, kept: &[u32], rest: &[u32]) -> Result<()> {
        let renumbered = |count: usize, stay: &[u32]| {
            let mut new = vec![NONE; count];
            (0..).zip(stay).for_each(|(number, old)| new[*old as usize] = number);
            new
        };
        let vertices = renumbered(self.spans.len(), rest);
        self.vertex = renumber(context, &self.vertex, kept, |old| vertices[old as usize]);
        drop(vertices);
        let triangles = renumbered(self.mate.len(), kept);
        let corner = |old: u32| if old == NONE { NONE } else { 4 * triangles[old as usize / 4] + old % 4 };
        self.mate = renumber(context, &self.mate, kept, corner);
        let size = |new: usize| [0, self.around(rest[new]).count() as u32].map(AtomicU32::new);
        let mut spans = context.map(rest.len(), size);
        let mut end = 0;
        for [start, size] in &mut spans {
            *start.get_mut() = end;
            end += *size.get_mut();
        }
        let mut corners = Vec::with_capacity(ROOM * kept.len());
        corners.resize_with(end as usize, || AtomicU32::new(NONE));
        context.for_each_part((spans.as_slice(), rest), CHUNK_LEN, |_, (spans, rest)| {
            for ([start, _], old) in spans.iter().zip(rest) {
                let moved = &corners[start.load(Relaxed) as usize..];
                moved.iter().zip(self.around(*old)).for_each(|(new, old)| new.store(corner(old), Relaxed));
            }
            Ok(())
        })?;
        (self.corners, self.spans) = (corners, spans);
        self.flags = context.map(rest.len(), |new| self.flags[rest[new] as usize]);
        Ok(())
    }
}

/// The numbers of the triangles that are kept.
fn renumber(
    context: &Context,
    list: &[[AtomicU32; 3]],
    kept: &[u32],
    new: impl Fn(u32) -> u32 + Sync,
) -> Vec<[AtomicU32; 3]> {
    context.map(kept.len(), |index| {
        let [a, b, c] = &list[kept[index] as usize];
        [new(a.load(Relaxed)), new(b.load(Relaxed)), new(c.load(Relaxed))].map(AtomicU32::new)
    })
}
