//! The directed edges of triangles by the vertex that they leave, as half-edges: three times the face plus the corner.

/// Half-edges, grouped by a vertex.
#[derive(Debug)]
pub struct Edges {
    starts: Vec<u32>,
    halves: Vec<u32>,
}

impl Edges {
    /// Groups the half-edges of triangles by the vertex that `group` returns for both ends, below `count`; none is left out.
    pub fn new(
        triangles: &[[u32; 3]],
        count: usize,
        is_left_out: impl Fn(usize) -> bool,
        group: impl Fn(u32, u32) -> u32,
    ) -> Self {
        let of = |face: usize| {
            let [a, b, c] = triangles[face];
            [group(a, b), group(b, c), group(c, a)]
        };
        let faces = || (0..triangles.len()).filter(|face| !is_left_out(*face));
        let mut starts = vec![0_u32; count + 1];
        for vertex in faces().flat_map(of) {
            starts[vertex as usize + 1] += 1;
        }
        for vertex in 0..count {
            starts[vertex + 1] += starts[vertex];
        }
        let mut halves = vec![0; starts[count] as usize];
        // The start of each group moves to its end, which is the start of the next one.
        for face in faces() {
            for (corner, vertex) in of(face).into_iter().enumerate() {
                let place = &mut starts[vertex as usize];
                halves[*place as usize] = (3 * face + corner) as u32;
                *place += 1;
            }
        }
        starts.copy_within(0..count, 1);
        starts[0] = 0;
        Self { starts, halves }
    }

    /// Returns the half-edges of a vertex, ascending.
    pub fn of(&self, vertex: u32) -> &[u32] {
        let at = vertex as usize;
        &self.halves[self.starts[at] as usize..self.starts[at + 1] as usize]
    }
}

/// Returns the vertex that a half-edge of triangles leads to.
pub fn target(triangles: &[[u32; 3]], half: u32) -> u32 {
    triangles[half as usize / 3][(half as usize + 1) % 3]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn half_edges_are_found_by_the_vertex_that_they_leave() {
        let triangles = [[0, 1, 2], [2, 1, 3], [1, 0, 4]];
        let edges = Edges::new(&triangles, 5, |_| false, |from, _| from);
        let found: Vec<&[u32]> = (0..5).map(|vertex| edges.of(vertex)).collect();
        assert_eq!(found, [&[0_u32, 7][..], &[1, 4, 6], &[2, 3], &[5], &[8]]);
        assert_eq!(edges.of(1).iter().map(|half| target(&triangles, *half)).collect::<Vec<_>>(), [2, 3, 0]);
        let edges = Edges::new(&triangles, 5, |face| face == 1, u32::min);
        assert_eq!((edges.of(0), edges.of(1), edges.of(3)), (&[0, 2, 6, 7][..], &[1, 8][..], &[][..]));
    }
}
