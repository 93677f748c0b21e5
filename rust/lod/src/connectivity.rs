//! Triangles as corners in lists round their vertices, for meshes that are manifold or not.
//!
//! A corner is a triangle's place at a vertex, and stands for the half-edge from its vertex to that of the next corner.
//! Half-edges of the same edge in opposite directions are mates, where they are two; vertices at any other edge, or at
//! which several fans of triangles meet, are fixed. Numbers are atomic so that collapses whose triangles have nothing in
//! common are made at the same time.

use std::sync::atomic::{AtomicU8, AtomicU32, Ordering::Relaxed};

use relievo_core::{Context, Result};

/// No corner, no triangle, no vertex.
pub const NONE: u32 = u32::MAX;

/// A vertex with an edge of one triangle.
pub const BOUNDARY: u8 = 1;
/// A vertex that stays where it is.
pub const FIXED: u8 = 2;

/// Vertices or triangles that are worked on by one task.
pub const PART: usize = 4096;

/// The corners of a mesh.
#[derive(Default)]
pub struct Connectivity {
    vertex: Vec<AtomicU32>,
    following: Vec<AtomicU32>,
    mate: Vec<AtomicU32>,
    first: Vec<AtomicU32>,
    /// [`BOUNDARY`] and [`FIXED`] of every vertex.
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
    spokes: [Spoke; Self::MOST],
    open: [u32; Self::MOST],
    size: usize,
    opened: usize,
}

impl Fan {
    /// Corners of a fan at most.
    pub const MOST: usize = 32;

    /// Whether there may be more corners than these.
    pub fn is_full(&self) -> bool {
        self.size == Self::MOST
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
    pub fn new(context: &Context, vertices: usize, triangles: &[[u32; 3]]) -> Self {
        let mut first = vec![NONE; vertices];
        let mut following = vec![NONE; 4 * triangles.len()];
        for (index, triangle) in triangles.iter().enumerate().rev() {
            for side in [2, 1, 0] {
                let (corner, head) = (4 * index + side, &mut first[triangle[side] as usize]);
                following[corner] = std::mem::replace(head, corner as u32);
            }
        }
        let made = Self {
            vertex: triangles.iter().flat_map(|[a, b, c]| [*a, *b, *c, NONE].map(AtomicU32::new)).collect(),
            following: following.into_iter().map(AtomicU32::new).collect(),
            mate: (0..4 * triangles.len()).map(|_| AtomicU32::new(NONE)).collect(),
            first: first.into_iter().map(AtomicU32::new).collect(),
            flags: Vec::new(),
        };
        let mut degrees = vec![0u32; vertices];
        triangles.as_flattened().iter().for_each(|vertex| degrees[*vertex as usize] += 1);
        let flags: Vec<AtomicU8> = (0..vertices).map(|_| AtomicU8::new(0)).collect();
        let parts = vertices.div_ceil(PART);
        let range = |part| (part * PART..vertices.min((part + 1) * PART)).map(|vertex| vertex as u32);
        context.for_each(parts, |part| range(part).for_each(|vertex| made.join(vertex, &degrees, &flags)));
        context.for_each(parts, |part| {
            for vertex in range(part) {
                flags[vertex as usize].fetch_or(made.describe(vertex, degrees[vertex as usize]), Relaxed);
            }
        });
        Self { flags: flags.into_iter().map(AtomicU8::into_inner).collect(), ..made }
    }

    /// Finds the mates of the half-edges that leave `vertex`, and fixes the ends of those that cannot have one.
    fn join(&self, vertex: u32, degrees: &[u32], flags: &[AtomicU8]) {
        for corner in self.around(vertex).filter(|corner| self.mate(*corner) == NONE) {
            let to = self.vertex(next(corner));
            // All triangles of the edge are at both of its ends: the shorter list tells.
            let here = degrees[vertex as usize] <= degrees[to as usize];
            let (at, other) = if here { (vertex, to) } else { (to, vertex) };
            let (mut same, mut opposite, mut mate) = (0, 0, NONE);
            for spoke in self.around(at) {
                let before = previous(spoke);
                let (leaves, arrives) = (self.vertex(next(spoke)) == other, self.vertex(before) == other);
                let (along, against) = if here { (leaves, arrives) } else { (arrives, leaves) };
                same += u32::from(along);
                if against {
                    opposite += 1;
                    mate = if here { before } else { spoke };
                }
            }
            if vertex == to || same != 1 || opposite > 1 {
                flags[vertex as usize].fetch_or(FIXED, Relaxed);
                flags[to as usize].fetch_or(FIXED, Relaxed);
            } else if opposite == 1 {
                self.mate[corner as usize].store(mate, Relaxed);
                self.mate[mate as usize].store(corner, Relaxed);
            }
        }
    }

    /// Whether `vertex` is at a boundary, and whether its triangles are one fan.
    fn describe(&self, vertex: u32, degree: u32) -> u8 {
        let Some(mut start) = self.around(vertex).next() else { return 0 };
        let (mut flags, mut open) = (0, 0);
        for corner in self.around(vertex) {
            if self.mate(previous(corner)) == NONE {
                flags |= BOUNDARY;
                start = corner;
                open += 1;
            }
            if self.mate(corner) == NONE {
                flags |= BOUNDARY;
            }
        }
        let (mut corner, mut seen) = (start, 1);
        while seen < degree && self.mate(corner) != NONE {
            corner = next(self.mate(corner));
            seen += 1;
        }
        if open > 1 || seen < degree { flags | FIXED } else { flags }
    }

    /// Number of triangles, with those that are gone.
    pub fn triangles(&self) -> usize {
        self.vertex.len() / 4
    }

    /// The vertices of all triangles, [`NONE`] where one is gone, and the mates of their half-edges; the last of four
    /// means nothing.
    pub fn sides(&self) -> (&[[AtomicU32; 4]], &[[AtomicU32; 4]]) {
        (self.vertex.as_chunks().0, self.mate.as_chunks().0)
    }

    /// The vertex of a corner, [`NONE`] where the triangle is gone.
    #[inline(always)]
    pub fn vertex(&self, corner: u32) -> u32 {
        self.vertex[corner as usize].load(Relaxed)
    }

    /// Whether a vertex has no triangle.
    pub fn is_gone(&self, vertex: u32) -> bool {
        self.first[vertex as usize].load(Relaxed) == NONE
    }

    /// The vertices of a triangle.
    #[inline(always)]
    pub fn triangle(&self, triangle: usize) -> [u32; 3] {
        let [a, b, c, _] = &self.vertex.as_chunks().0[triangle];
        [a.load(Relaxed), b.load(Relaxed), c.load(Relaxed)]
    }

    /// The half-edge on the other side, if there is one.
    #[inline(always)]
    pub fn mate(&self, corner: u32) -> u32 {
        self.mate[corner as usize].load(Relaxed)
    }

    /// The corners at a vertex. Where triangles have gone, after [`Self::clean`] only.
    #[inline(always)]
    pub fn around(&self, vertex: u32) -> impl Iterator<Item = u32> {
        let mut corner = self.first[vertex as usize].load(Relaxed);
        std::iter::from_fn(move || {
            if corner == NONE {
                return None;
            }
            let found = corner;
            corner = self.following[found as usize].load(Relaxed);
            Some(found)
        })
    }

    /// Puts the corners at a vertex into `fan`, as [`Self::around`], until it is full.
    #[inline(always)]
    pub fn fan(&self, vertex: u32, fan: &mut Fan) {
        let inner = self.flags[vertex as usize] == 0;
        let mut corner = self.first[vertex as usize].load(Relaxed);
        let mut size = 0;
        let mut open = 0;
        while corner != NONE && size < Fan::MOST {
            let before = previous(corner);
            let spoke = Spoke { corner, to: self.vertex(next(corner)), from: self.vertex(before) };
            fan.spokes[size] = spoke;
            if !inner && self.mate(before) == NONE {
                fan.open[open] = spoke.from;
                open += 1;
            }
            size += 1;
            corner = self.following[corner as usize].load(Relaxed);
        }
        (fan.size, fan.opened) = (size, open);
    }

    /// Visits the corners at a vertex, and takes those whose triangles are gone out of its list.
    #[inline(always)]
    pub fn clean(&self, vertex: u32, mut visit: impl FnMut(u32)) {
        let mut link = &self.first[vertex as usize];
        loop {
            let corner = link.load(Relaxed);
            if corner == NONE {
                return;
            }
            let following = &self.following[corner as usize];
            if self.vertex(corner) == NONE {
                link.store(following.load(Relaxed), Relaxed);
            } else {
                visit(corner);
                link = following;
            }
        }
    }

    /// Collapses the half-edge of `corner`: the vertex where it ends becomes that where it starts, and the triangles of
    /// the edge go. Returns how many.
    pub fn collapse(&self, corner: u32) -> usize {
        let (kept, gone) = (self.vertex(corner), self.vertex(next(corner)));
        let mut last = NONE;
        for at in self.around(gone) {
            self.vertex[at as usize].store(kept, Relaxed);
            last = at;
        }
        let head = &self.first[kept as usize];
        self.following[last as usize].store(head.load(Relaxed), Relaxed);
        head.store(self.first[gone as usize].swap(NONE, Relaxed), Relaxed);
        let sides = [corner, self.mate(corner)];
        for side in sides.into_iter().filter(|side| *side != NONE) {
            let (after, before) = (self.mate(next(side)), self.mate(previous(side)));
            for (one, other) in [(after, before), (before, after)] {
                if one != NONE {
                    self.mate[one as usize].store(other, Relaxed);
                }
            }
            for at in [side, next(side), previous(side)] {
                self.vertex[at as usize].store(NONE, Relaxed);
            }
        }
        1 + usize::from(sides[1] != NONE)
    }

    /// Leaves out what is gone. `triangles` and `vertices` have the new number of each that stays, and otherwise
    /// [`NONE`]; the lists are clean.
    pub fn compact(
        &mut self,
        context: &Context,
        (triangles, kept): (&[u32], &[u32]),
        (vertices, rest): (&[u32], &[u32]),
    ) -> Result<()> {
        let corner = |old: u32| if old == NONE { NONE } else { 4 * triangles[old as usize / 4] + old % 4 };
        self.vertex = renumber(context, &self.vertex, kept, |old| vertices[old as usize])?;
        self.following = renumber(context, &self.following, kept, corner)?;
        self.mate = renumber(context, &self.mate, kept, corner)?;
        self.first = rest.iter().map(|old| AtomicU32::new(corner(self.first[*old as usize].load(Relaxed)))).collect();
        self.flags = rest.iter().map(|old| self.flags[*old as usize]).collect();
        Ok(())
    }
}

/// The numbers of the triangles that are kept.
fn renumber(
    context: &Context,
    list: &[AtomicU32],
    kept: &[u32],
    new: impl Fn(u32) -> u32 + Sync,
) -> Result<Vec<AtomicU32>> {
    let mut made: Vec<AtomicU32> = (0..4 * kept.len()).map(|_| AtomicU32::new(NONE)).collect();
    let list: &[[AtomicU32; 4]] = list.as_chunks().0;
    context.for_each_part((made.as_chunks_mut().0, kept), PART, |_, (made, kept)| {
        for (made, old) in made.iter_mut().zip(kept) {
            let [a, b, c, _] = &list[*old as usize];
            *made = [new(a.load(Relaxed)), new(b.load(Relaxed)), new(c.load(Relaxed)), NONE].map(AtomicU32::new);
        }
        Ok(())
    })?;
    Ok(made)
}
