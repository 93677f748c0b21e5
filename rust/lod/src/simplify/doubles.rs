//! Parts of a mesh whose triangles are all there twice, back to back, as models have them that are seen from both sides.
//!
//! No edge there has two triangles, so nothing could collapse. One triangle of each pair is simplified, and gets its other
//! side back at the end.

use crate::connectivity::NONE;

/// A mesh without the other sides of its double parts.
pub struct Doubles {
    /// Triangles in order; those of double parts turned so that neighbours go the same way round.
    pub triangles: Vec<[u32; 3]>,
    /// Vertices of double parts.
    is_double: Vec<bool>,
}

impl Doubles {
    /// Takes the other sides away from a mesh of so many points, whose indices are in range. `None` if no part is double.
    pub fn find(points: usize, triangles: &[[u32; 3]]) -> Option<Self> {
        let mut is_double = candidates(points, triangles);
        let mut pairs: Vec<([u32; 3], bool, u32)> = Vec::new();
        for (number, triangle) in (0..).zip(triangles) {
            if triangle.iter().all(|vertex| is_double[*vertex as usize]) {
                let (key, is_even) = sorted(*triangle);
                pairs.push((key, is_even, number));
            }
        }
        if pairs.is_empty() {
            return None;
        }
        pairs.sort_unstable_by_key(|pair| (pair.0, pair.2));
        // Vertices of a part, each with a lower one of it, or the lowest.
        let mut lower: Vec<u32> = (0..points as u32).collect();
        let lowest = |lower: &mut [u32], mut vertex: u32| {
            while lower[vertex as usize] != vertex {
                lower[vertex as usize] = lower[lower[vertex as usize] as usize];
                vertex = lower[vertex as usize];
            }
            vertex
        };
        for [a, b, c] in triangles {
            for [one, other] in [[a, b], [b, c]] {
                let ends = [one, other].map(|vertex| lowest(&mut lower, *vertex));
                lower[ends[0].max(ends[1]) as usize] = ends[0].min(ends[1]);
            }
        }
        let mut is_part = vec![true; points];
        for triangle in triangles.iter().filter(|it| !it.iter().all(|vertex| is_double[*vertex as usize])) {
            is_part[lowest(&mut lower, triangle[0]) as usize] = false;
        }
        let mut first = vec![NONE; triangles.len()];
        for same in pairs.chunk_by(|one, other| one.0 == other.0) {
            let even = same.iter().filter(|pair| pair.1).count();
            let [a, b, c] = same[0].0;
            if 2 * even != same.len() || a == b || b == c {
                is_part[lowest(&mut lower, a) as usize] = false;
            }
            same.iter().for_each(|pair| first[pair.2 as usize] = same[0].2);
        }
        for vertex in 0..points as u32 {
            is_double[vertex as usize] &= is_part[lowest(&mut lower, vertex) as usize];
        }
        let is_in = |triangle: &[u32; 3]| is_double[triangle[0] as usize];
        if !triangles.iter().any(is_in) {
            return None;
        }
        let numbered = (0..).zip(triangles).zip(&first);
        let is_kept = |((number, triangle), first): &((u32, &[u32; 3]), &u32)| !is_in(triangle) || *first == number;
        let mut left: Vec<[u32; 3]> = numbered.filter(is_kept).map(|((_, triangle), _)| *triangle).collect();
        orient(&mut left, |triangle| is_double[triangle[0] as usize]);
        Some(Self { triangles: left, is_double })
    }

    /// Whether a triangle of one side, by a vertex of it, has another.
    pub fn is_double(&self, vertex: u32) -> bool {
        self.is_double[vertex as usize]
    }

    /// Returns how many triangles of one side may be left for `faces` of both.
    pub fn faces(&self, faces: usize) -> usize {
        let double = self.triangles.iter().filter(|triangle| self.is_double(triangle[0])).count();
        let [one, both] = [self.triangles.len(), self.triangles.len() + double].map(|count| count as u128);
        (faces as u128 * one / both) as usize
    }
}

/// Returns the vertices of a triangle in order, and whether they are an even permutation.
fn sorted([a, b, c]: [u32; 3]) -> ([u32; 3], bool) {
    let mut key = [a, b, c];
    key.sort_unstable();
    (key, [[a, b, c], [b, c, a], [c, a, b]].contains(&key))
}

/// Returns the vertices whose triangles may all be there twice.
fn candidates(points: usize, triangles: &[[u32; 3]]) -> Vec<bool> {
    // The sum over triangles changes its sign with their side, so that it vanishes.
    let [one, other] = [0x9e37_79b1, 0x85eb_ca6b].map(|factor: u32| {
        move |vertex: u32| (vertex.wrapping_add(1).wrapping_mul(factor)).rotate_left(15).wrapping_mul(factor)
    });
    let mut sums = vec![0u32; points];
    for [a, b, c] in triangles {
        let [x, y] = [[a, b, c].map(|vertex| one(*vertex)), [a, b, c].map(|vertex| other(*vertex))];
        let turn = |i: usize, j: usize| x[i].wrapping_mul(y[j]).wrapping_sub(x[j].wrapping_mul(y[i]));
        let sum = turn(0, 1).wrapping_add(turn(1, 2)).wrapping_add(turn(2, 0));
        [a, b, c].iter().for_each(|vertex| sums[**vertex as usize] = sums[**vertex as usize].wrapping_add(sum));
    }
    sums.into_iter().map(|sum| sum == 0).collect()
}

/// Turns triangles that `may` be turned so that they go the same way round as those beside them, over edges of two.
fn orient(triangles: &mut [[u32; 3]], may: impl Fn(&[u32; 3]) -> bool) {
    let mut edges: Vec<([u32; 2], u32)> = Vec::new();
    for (number, triangle) in (0..).zip(&*triangles).filter(|(_, triangle)| may(triangle)) {
        let [a, b, c] = *triangle;
        edges.extend([[a, b], [b, c], [c, a]].map(|[a, b]| ([a.min(b), a.max(b)], number)));
    }
    edges.sort_unstable();
    let mut beside: Vec<[u32; 2]> = Vec::new();
    for edge in edges.chunk_by(|one, other| one.0 == other.0) {
        if let [(_, one), (_, other)] = edge {
            beside.extend([[*one, *other], [*other, *one]]);
        }
    }
    beside.sort_unstable();
    let mut is_done = vec![false; triangles.len()];
    let mut waiting = Vec::new();
    for start in 0..triangles.len() {
        if std::mem::replace(&mut is_done[start], true) {
            continue;
        }
        waiting.push(start as u32);
        while let Some(triangle) = waiting.pop() {
            let from = beside.partition_point(|pair| pair[0] < triangle);
            for [_, other] in beside[from..].iter().take_while(|pair| pair[0] == triangle) {
                if !std::mem::replace(&mut is_done[*other as usize], true) {
                    if goes_against(triangles[triangle as usize], triangles[*other as usize]) {
                        triangles[*other as usize].swap(1, 2);
                    }
                    waiting.push(*other);
                }
            }
        }
    }
}

/// Whether two triangles have an edge in the same direction.
fn goes_against([a, b, c]: [u32; 3], [d, e, f]: [u32; 3]) -> bool {
    let others = [[d, e], [e, f], [f, d]];
    [[a, b], [b, c], [c, a]].iter().any(|edge| others.contains(edge))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn strip(first: u32) -> Vec<[u32; 3]> {
        (first..first + 6).map(|a| if a % 2 == 0 { [a, a + 1, a + 2] } else { [a + 1, a, a + 2] }).collect()
    }

    #[test]
    fn parts_of_two_sides_are_halved_and_others_stay() {
        let double: Vec<[u32; 3]> = strip(0).into_iter().flat_map(|[a, b, c]| [[b, c, a], [a, c, b]]).collect();
        let single = strip(8);
        let mut all = [double.clone(), single.clone()].concat();
        // In no order, and some first by their other side.
        all[..12].reverse();
        all.swap(2, 3);
        let doubles = Doubles::find(16, &all).unwrap();
        assert_eq!(doubles.triangles.len(), 12);
        assert_eq!(doubles.triangles[6..], single);
        assert_eq!(doubles.faces(9), 6);
        for (at, one) in doubles.triangles[..6].iter().enumerate() {
            assert!(doubles.is_double(one[0]));
            assert!(doubles.triangles[..at].iter().all(|other| !goes_against(*one, *other)));
        }
        assert!(Doubles::find(16, &single).is_none());
        // One triangle of a part without its other side.
        assert!(Doubles::find(16, &all[1..]).is_none());
    }
}
