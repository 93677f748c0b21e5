//! Numbers of virtual vertices in index buffers: above the number of a vertex is which of the three corners it is of all
//! triangles that it belongs to, from which the vertex stage makes the lines of a wireframe.

/// Bits of the number of a vertex.
pub(super) const VERTEX_BITS: u32 = 20;
/// The number of a vertex.
pub(super) const VERTEX: u32 = (1 << VERTEX_BITS) - 1;

/// The indices of triangles that hang together by edges and have an even number around every inner vertex, so that three
/// kinds of corners suffice.
pub(super) fn cornered(triangles: &[[u32; 3]]) -> Vec<u32> {
    let count = triangles.iter().flatten().max().map_or(0, |most| *most as usize + 1);
    let mut corner = vec![u32::MAX; count];
    let mut left: Vec<usize> = (0..triangles.len()).collect();
    if let Some(first) = triangles.first() {
        (0..).zip(first).for_each(|(number, vertex)| corner[*vertex as usize] = number);
    }
    loop {
        let before = left.len();
        left.retain(|at| {
            let known: Vec<u32> =
                triangles[*at].iter().map(|vertex| corner[*vertex as usize]).filter(|it| *it < 3).collect();
            if known.len() == 2 {
                let missing = triangles[*at].iter().find(|vertex| corner[**vertex as usize] > 2);
                missing.into_iter().for_each(|vertex| corner[*vertex as usize] = 3 - known[0] - known[1]);
            }
            known.len() < 2
        });
        if left.len() == before {
            break;
        }
    }
    triangles.iter().flatten().map(|vertex| *vertex | corner[*vertex as usize].min(2) << VERTEX_BITS).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use relievo_tiles::triangle::{Pattern, Slot, border_strip};

    fn check(triangles: &[[u32; 3]]) {
        for corners in cornered(triangles).as_chunks::<3>().0 {
            let mut kinds = corners.map(|index| index >> VERTEX_BITS);
            kinds.sort_unstable();
            assert_eq!(kinds, [0, 1, 2], "{triangles:?}");
        }
    }

    #[test]
    fn triangles_of_patterns_have_corners_of_three_kinds() {
        for segments in [2, 4, 8, 16, 64] {
            let pattern = Pattern::new(segments).unwrap();
            for side in [1, 2, 4, 32, 64] {
                let strip = border_strip(pattern, side);
                assert_eq!(strip.len() as u32, side + segments - 2);
                check(&strip);
            }
            let inside: Vec<[u32; 3]> = pattern
                .triangles()
                .filter(|triangle| triangle.iter().all(|node| node.ring > 0))
                .map(|triangle| {
                    triangle.map(|node| match pattern.slot(node) {
                        Slot::Inside(index) => index,
                        slot => panic!("{slot:?}"),
                    })
                })
                .collect();
            check(&inside);
        }
    }
}
