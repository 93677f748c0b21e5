//! The table of marching cubes (Lorensen, Cline 1987): the triangles of a cell for each of 256 sets of corners that are
//! inside. It is made by rules that two cells agree on at their common face, so that what they make is watertight and
//! manifold, corner sets of any kind:
//!
//! - On a face every run of inside corners is cut off by one segment: where two opposite corners are inside, each is cut
//!   off by itself. The corners of the face alone decide that.
//! - Segments of the six faces make loops, and loops are cut into triangles by diagonals that lie on no face, so that the
//!   other cell has no such edge.
//!
//! Corner c of a cell is at (c & 1, c >> 1 & 1, c >> 2). Edges are numbered by axis: 4 · axis + the bits of the corner
//! they start at along the two other axes, the lower axis first.

/// Triangles of a cell at most.
const MAX: usize = 5;
/// Vertices of a loop at most.
const LONGEST: usize = 12;

/// The triangles of a set of corners that are inside, by the edges that their vertices lie on, counter-clockwise seen
/// from outside.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Case {
    count: u8,
    triangles: [[u8; 3]; MAX],
}

impl Case {
    /// The triangles.
    pub fn triangles(&self) -> &[[u8; 3]] {
        &self.triangles[..self.count as usize]
    }
}

/// The cases by the bits of their inside corners.
pub(crate) static CASES: [Case; 256] = cases();

/// The corner that an edge starts at, as the offset along each axis, and the axis.
pub(crate) const fn edge(number: usize) -> ([usize; 3], usize) {
    let (axis, low, high) = (number / 4, number & 1, number >> 1 & 1);
    match axis {
        0 => ([0, low, high], 0),
        1 => ([low, 0, high], 1),
        _ => ([low, high, 0], 2),
    }
}

/// The edge between two corners that differ along one axis.
const fn between(a: usize, b: usize) -> usize {
    let corner = a & b;
    match a ^ b {
        1 => corner >> 1,
        2 => 4 + (corner & 1 | corner >> 1 & 2),
        _ => 8 + (corner & 3),
    }
}

/// Whether two edges lie on one face.
const fn share_face(a: usize, b: usize) -> bool {
    let mut axis = 0;
    while axis < 3 {
        let ((from, along), (other, other_along)) = (edge(a), edge(b));
        if along != axis && other_along != axis && from[axis] == other[axis] {
            return true;
        }
        axis += 1;
    }
    false
}

const fn cases() -> [Case; 256] {
    let mut cases = [Case { count: 0, triangles: [[0; 3]; MAX] }; 256];
    let mut inside = 0;
    while inside < 256 {
        cases[inside] = case(inside);
        inside += 1;
    }
    cases
}

/// No edge.
const NONE: usize = usize::MAX;

/// For each crossed edge the one that the surface goes to from there, around each loop.
const fn follow(inside: usize) -> [usize; 12] {
    let mut next = [NONE; 12];
    let mut face = 0;
    while face < 6 {
        let (axis, side) = (face >> 1, face & 1);
        let (u, v) = (1 << ((axis + 1) % 3), 1 << ((axis + 2) % 3));
        let base = side << axis;
        // Counter-clockwise seen from outside.
        let ring =
            if side == 1 { [base, base | u, base | u | v, base | v] } else { [base, base | v, base | u | v, base | u] };
        let mut first = 0;
        while first < 4 {
            // A run of inside corners starts here.
            if inside >> ring[first] & 1 == 1 && inside >> ring[(first + 3) % 4] & 1 == 0 {
                let mut last = first;
                while inside >> ring[(last + 1) % 4] & 1 == 1 {
                    last += 1;
                }
                let from = between(ring[(first + 3) % 4], ring[first]);
                next[from] = between(ring[last % 4], ring[(last + 1) % 4]);
            }
            first += 1;
        }
        face += 1;
    }
    next
}

const fn case(inside: usize) -> Case {
    let mut next = follow(inside);
    let mut made = Case { count: 0, triangles: [[0; 3]; MAX] };
    let mut start = 0;
    while start < 12 {
        let (mut ring, mut count, mut at) = ([0; LONGEST], 0, start);
        while next[at] != NONE {
            ring[count] = at;
            count += 1;
            at = std::mem::replace(&mut next[at], NONE);
        }
        if count > 0 {
            made = triangulate(ring, count, made);
        }
        start += 1;
    }
    made
}

/// Adds the triangles of a loop, whose diagonals lie on no face.
const fn triangulate(ring: [usize; LONGEST], count: usize, mut made: Case) -> Case {
    // The third vertex of the triangle at each diagonal of a part of the loop that can be cut up.
    let mut split = [[NONE; LONGEST]; LONGEST];
    let mut length = 2;
    while length < count {
        let mut low = 0;
        while low + length < count {
            let high = low + length;
            let mut middle = low + 1;
            while middle < high && (length + 1 == count || !share_face(ring[low], ring[high])) {
                let left = middle == low + 1 || split[low][middle] != NONE;
                let right = high == middle + 1 || split[middle][high] != NONE;
                if left && right && split[low][high] == NONE {
                    split[low][high] = middle;
                }
                middle += 1;
            }
            low += 1;
        }
        length += 1;
    }
    let mut open = [[0; 2]; LONGEST];
    let mut waiting = 1;
    open[0] = [0, count - 1];
    while waiting > 0 {
        waiting -= 1;
        let [low, high] = open[waiting];
        if high > low + 1 {
            let middle = split[low][high];
            assert!(middle != NONE, "a loop cannot be cut up without a diagonal on a face");
            made.triangles[made.count as usize] = [ring[low] as u8, ring[middle] as u8, ring[high] as u8];
            made.count += 1;
            open[waiting] = [low, middle];
            open[waiting + 1] = [middle, high];
            waiting += 2;
        }
    }
    made
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;

    /// Directed edges of the triangles of a case that no triangle has the other way round.
    fn rim(inside: usize) -> Vec<[u8; 2]> {
        let sides = |[a, b, c]: &[u8; 3]| [[*a, *b], [*b, *c], [*c, *a]];
        let edges: Vec<[u8; 2]> = CASES[inside].triangles().iter().flat_map(sides).collect();
        edges.iter().copied().filter(|[a, b]| !edges.contains(&[*b, *a])).collect()
    }

    #[test]
    fn edges_are_those_between_corners() {
        for number in 0..12 {
            let ([x, y, z], axis) = edge(number);
            let corner = x | y << 1 | z << 2;
            assert_eq!(between(corner, corner | 1 << axis), number);
        }
    }

    #[test]
    fn every_crossed_edge_has_a_vertex_and_rims_lie_on_faces() {
        for (inside, case) in CASES.iter().enumerate() {
            let mut seen = BTreeMap::new();
            case.triangles().iter().flatten().for_each(|edge| *seen.entry(*edge).or_insert(0) += 1);
            for number in 0..12 {
                let ([x, y, z], axis) = edge(number);
                let corner = x | y << 1 | z << 2;
                let crossed = inside >> corner & 1 != inside >> (corner | 1 << axis) & 1;
                assert_eq!(seen.contains_key(&(number as u8)), crossed, "{inside} {number}");
            }
            // Each vertex is left once and reached once by the rim: one fan of triangles.
            let rim = rim(inside);
            assert_eq!(rim.len(), seen.len());
            for vertex in seen.keys() {
                assert_eq!(rim.iter().filter(|[from, _]| from == vertex).count(), 1);
                assert_eq!(rim.iter().filter(|[_, to]| to == vertex).count(), 1);
            }
            for [a, b] in &rim {
                assert!(share_face(*a as usize, *b as usize));
            }
            // No other edge lies on a face, and none occurs twice.
            let edges = case.triangles().iter().flat_map(|[a, b, c]| [[*a, *b], [*b, *c], [*c, *a]]);
            let mut all: Vec<[u8; 2]> = edges.collect();
            all.sort_unstable();
            assert!(all.windows(2).all(|pair| pair[0] != pair[1]));
            assert!(all.iter().all(|[a, b]| rim.contains(&[*a, *b]) || !share_face(*a as usize, *b as usize)));
        }
    }

    #[test]
    fn neighbours_have_the_segments_of_their_common_face_in_opposite_directions() {
        // All pairs of cells beside each other along an axis: 12 corners.
        for axis in 0..3 {
            for corners in 0..1 << 12 {
                let (mut low, mut high) = (0, 0);
                for corner in 0..8 {
                    let plane = corner >> axis & 1;
                    let rest = (corner & ((1 << axis) - 1)) | corner >> (axis + 1) << axis;
                    low |= (corners >> (plane * 4 + rest) & 1) << corner;
                    high |= (corners >> ((plane + 1) * 4 + rest) & 1) << corner;
                }
                let on = |inside: usize, side: usize| {
                    let edges = rim(inside).into_iter();
                    let on_face = move |number: u8| {
                        let (from, along) = edge(number as usize);
                        along != axis && from[axis] == side
                    };
                    // Without the coordinate along the axis, which differs.
                    let name = move |number: u8| {
                        let (mut from, along) = edge(number as usize);
                        from[axis] = 0;
                        (from, along)
                    };
                    let both = edges.filter(move |[a, b]| on_face(*a) && on_face(*b));
                    both.map(move |[a, b]| (name(a), name(b))).collect::<Vec<_>>()
                };
                let mut low = on(low, 1);
                let mut high: Vec<_> = on(high, 0).into_iter().map(|(a, b)| (b, a)).collect();
                low.sort_unstable();
                high.sort_unstable();
                assert_eq!(low, high, "{axis} {corners:b}");
            }
        }
    }
}
