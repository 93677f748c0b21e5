//! Which half-edges of a mesh are mates, found vertex by vertex.

use std::sync::atomic::Ordering::Relaxed;

use relievo_core::{Context, Result};

use crate::connectivity::{BOUNDARY, CHUNK_LEN, Connectivity, FIXED, NONE, next, previous};

/// Finds the mates of all half-edges of a mesh that has none yet, and the flags of its vertices.
pub fn find(context: &Context, mesh: &Connectivity, vertices: usize) -> Result<Vec<u8>> {
    let mut flags = vec![0; vertices];
    context.for_each_part(flags.as_mut_slice(), CHUNK_LEN, |first, flags| {
        let (mut leaving, mut join) = (Leaving::default(), Join::default());
        for (vertex, flags) in (first as u32..).zip(flags) {
            *flags = if leaving.close(mesh, vertex) { 0 } else { join.describe(mesh, vertex) };
        }
        Ok(())
    })?;
    Ok(flags)
}

/// The half-edges that leave a vertex, each at a place that follows from where it ends.
struct Leaving {
    /// The vertex that it leaves and where it ends, and its corner.
    places: Vec<([u32; 2], u32)>,
}

impl Default for Leaving {
    fn default() -> Self {
        Self { places: vec![([NONE; 2], NONE); 1 << Self::BITS] }
    }
}

impl Leaving {
    /// Bits of the number of places. Seldom do two of a vertex have the same one.
    const BITS: u32 = 10;

    #[inline(always)]
    fn place(&mut self, end: u32) -> &mut ([u32; 2], u32) {
        &mut self.places[(end.wrapping_mul(0x9e37_79b1) >> (u32::BITS - Self::BITS)) as usize]
    }

    /// Finds the mates of the half-edges that leave `vertex` if its triangles are one closed fan, as nearly everywhere.
    /// Returns whether they are; it may say no where they are.
    fn close(&mut self, mesh: &Connectivity, vertex: u32) -> bool {
        let span = mesh.span(vertex);
        for corner in span {
            let corner = corner.load(Relaxed);
            let end = mesh.vertex(next(corner));
            let place = self.place(end);
            if place.0[0] == vertex || end == vertex {
                return false;
            }
            *place = ([vertex, end], corner);
        }
        let Some(first) = span.first().map(|corner| corner.load(Relaxed)) else { return false };
        let mut corner = first;
        for seen in 1..=span.len() {
            let arriving = previous(corner);
            let end = mesh.vertex(arriving);
            let (known, leaving) = *self.place(end);
            // A way through all of them goes to each once: no end is there twice.
            if known != [vertex, end] || (leaving == first) != (seen == span.len()) {
                self.open(mesh, vertex);
                return false;
            }
            mesh.set_mate(leaving, arriving);
            corner = leaving;
        }
        true
    }

    /// Forgets the mates of the half-edges that leave `vertex`.
    #[cold]
    fn open(&self, mesh: &Connectivity, vertex: u32) {
        for corner in mesh.span(vertex) {
            mesh.set_mate(corner.load(Relaxed), NONE);
        }
    }
}

/// Finds the mates of half-edges round a vertex: what leaves it and what arrives, in the order of the other ends.
#[derive(Default)]
struct Join {
    corners: Vec<u32>,
    /// The other end of the half-edge that leaves at each corner, and the corner's place in `corners`.
    leaving: Vec<(u32, u32)>,
    /// The same of the half-edge that arrives.
    arriving: Vec<(u32, u32)>,
    /// For every corner the place of the one across the half-edge that leaves there.
    across: Vec<u32>,
}

impl Join {
    /// Finds the mates of the half-edges that leave `vertex`. Returns its flags: whether it is at a boundary; and
    /// whether it has an edge whose half-edges cannot be mates, or several fans.
    fn describe(&mut self, mesh: &Connectivity, vertex: u32) -> u8 {
        let Self { corners, leaving, arriving, across } = self;
        corners.clear();
        corners.extend(mesh.around(vertex));
        let ends = |ends: &mut Vec<(u32, u32)>, side: fn(u32) -> u32| {
            ends.clear();
            ends.extend(corners.iter().map(|corner| mesh.vertex(side(*corner))).zip(0..));
            ends.sort_unstable();
        };
        ends(leaving, next);
        ends(arriving, previous);
        across.clear();
        across.resize(corners.len(), NONE);
        let (mut flags, mut start, mut open) = (0, 0, 0);
        let (mut leave, mut arrive) = (leaving.as_slice(), arriving.as_slice());
        while let Some(end) = [leave, arrive].iter().filter_map(|list| list.first()).map(|(end, _)| *end).min() {
            let count = |list: &[(u32, u32)]| list.iter().take_while(|(other, _)| *other == end).count();
            let counts = [count(leave), count(arrive)];
            match counts {
                _ if end == vertex || counts.iter().any(|count| *count > 1) => flags |= BOUNDARY | FIXED,
                [1, 1] => {
                    across[leave[0].1 as usize] = arrive[0].1;
                    let mate = previous(corners[arrive[0].1 as usize]);
                    mesh.set_mate(corners[leave[0].1 as usize], mate);
                }
                [1, _] => flags |= BOUNDARY,
                _ => {
                    flags |= BOUNDARY;
                    start = arrive[0].1;
                    open += 1;
                }
            }
            (leave, arrive) = (&leave[counts[0]..], &arrive[counts[1]..]);
        }
        let (mut place, mut seen) = (start, 1);
        while let Some(after) = across.get(place as usize).filter(|after| **after != NONE && **after != start) {
            (place, seen) = (*after, seen + 1);
        }
        if open > 1 || seen < corners.len() { flags | FIXED } else { flags }
    }
}
