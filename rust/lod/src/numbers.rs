//! Numbers of a patch's own vertices, in the order in which they are first met.

use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

use crate::connectivity::NONE;

/// Which patch met a vertex first, and its number there: most vertices are met by one alone. Who is first depends on
/// threads where several patches have a vertex, numbers do not.
pub struct Claims<'a> {
    /// Number of the patch among all so far, in the upper half, and of the vertex in it.
    pub of: &'a [AtomicU64],
    /// Patches with lesser numbers are of earlier cuts.
    pub first: u32,
}

/// Numbers of a patch's vertices.
pub struct Numbers<'a> {
    claims: &'a Claims<'a>,
    /// The patch's own number, as claims have it.
    patch: u32,
    /// Vertices that other patches claimed, there and here, at a place that follows from the former, or after others.
    shared: Vec<[u32; 2]>,
    /// How many of them there are.
    count: usize,
    /// The vertices.
    pub met: Vec<u32>,
}

impl<'a> Numbers<'a> {
    /// Of a patch by its number in this cut, which has about so many vertices.
    pub fn new(claims: &'a Claims<'a>, patch: u32, about: usize) -> Self {
        let shared = vec![[NONE; 2]; (about / 2 + 2).next_power_of_two()];
        Self { claims, patch: claims.first + patch, shared, count: 0, met: Vec::with_capacity(about + about / 8) }
    }

    /// The number here of a vertex.
    #[inline(always)]
    pub fn number(&mut self, vertex: u32) -> u32 {
        let claim = self.claims.of[vertex as usize].load(Relaxed);
        if (claim >> u32::BITS) as u32 == self.patch { claim as u32 } else { self.unclaimed(vertex, claim) }
    }

    /// The number of a vertex that this patch did not claim before.
    #[inline(never)]
    fn unclaimed(&mut self, vertex: u32, claim: u64) -> u32 {
        let next = self.met.len() as u32;
        let own = u64::from(self.patch) << u32::BITS | u64::from(next);
        let is_free = (claim >> u32::BITS) < u64::from(self.claims.first);
        if is_free && self.claims.of[vertex as usize].compare_exchange(claim, own, Relaxed, Relaxed).is_ok() {
            self.met.push(vertex);
            return next;
        }
        let at = place(&self.shared, vertex);
        if self.shared[at][0] == vertex {
            return self.shared[at][1];
        }
        self.shared[at] = [vertex, next];
        self.met.push(vertex);
        self.count += 1;
        if 2 * self.count > self.shared.len() {
            let more = vec![[NONE; 2]; 2 * self.shared.len()];
            for known in std::mem::replace(&mut self.shared, more).into_iter().filter(|known| known[0] != NONE) {
                let at = place(&self.shared, known[0]);
                self.shared[at] = known;
            }
        }
        next
    }
}

/// Where a vertex is, or would be; some place is free.
fn place(shared: &[[u32; 2]], vertex: u32) -> usize {
    let mask = shared.len() - 1;
    let mut at = vertex.wrapping_mul(0x9e37_79b1).rotate_right(16) as usize & mask;
    while shared[at][0] != NONE && shared[at][0] != vertex {
        at = (at + 1) & mask;
    }
    at
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn more_vertices_of_other_patches_than_were_expected_have_numbers() {
        // Another patch of the same cut has met all of them first.
        let of: Vec<AtomicU64> = (0..100).map(|vertex| AtomicU64::new(2 << u32::BITS | vertex)).collect();
        let claims = Claims { of: &of, first: 1 };
        let mut numbers = Numbers::new(&claims, 0, 0);
        let vertices: Vec<u32> = (0..100).rev().collect();
        for _ in 0..2 {
            let given: Vec<u32> = vertices.iter().map(|vertex| numbers.number(*vertex)).collect();
            assert_eq!(given, (0..100).collect::<Vec<u32>>());
        }
        assert_eq!(numbers.met, vertices);
    }
}
