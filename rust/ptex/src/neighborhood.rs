//! Which constant faces have neighbours of the same value all around: there, filters need not look further.

use crate::face::{CONSTANT, CONSTANT_NEIGHBORHOOD, Neighbor, Record};
use crate::format::{BorderMode, Borders, MeshType};

/// Faces around a vertex that are looked at. With more, the face counts as one whose neighbours differ.
const LARGEST_VALENCE: usize = 64;

/// Sets the flag of the faces whose value all faces around their corners have. `value` is that of a constant face.
pub(crate) fn flag<'a>(records: &mut [Record], mesh: MeshType, borders: Borders, value: impl Fn(u32) -> &'a [u8]) {
    let clamped = borders.u == BorderMode::Clamp && borders.v == BorderMode::Clamp;
    for face in 0..records.len() as u32 {
        let constant = records[face as usize].has(CONSTANT);
        let around = Around { records, edges: if mesh == MeshType::Triangle { 3 } else { 4 }, face };
        let own = value(face);
        let same = |other: u32| {
            let record = &records[other as usize];
            // Where sub-faces meet whole ones, corners lie within edges: such faces count as different.
            record.has(CONSTANT) && record.face.subface == records[face as usize].face.subface && value(other) == own
        };
        if constant && (0..around.edges).all(|corner| around.corner(corner, clamped, &same)) {
            records[face as usize].flags |= CONSTANT_NEIGHBORHOOD;
        }
    }
}

/// The faces around the corners of a face.
struct Around<'a> {
    records: &'a [Record],
    edges: u8,
    face: u32,
}

impl Around<'_> {
    fn beyond(&self, face: u32, edge: u8) -> Option<Neighbor> {
        self.records[face as usize].face.neighbors[usize::from(edge)]
    }

    /// True if all faces around the vertex that edge `corner` starts at are the `same`.
    fn corner(&self, corner: u8, clamped: bool, same: &impl Fn(u32) -> bool) -> bool {
        // Clockwise the vertex is where the next edge starts, counter-clockwise where it ends.
        match self.turn(corner, 1, same) {
            Turn::Different => false,
            Turn::Closed => true,
            Turn::Border => {
                let before = (corner + self.edges - 1) % self.edges;
                clamped && !matches!(self.turn(before, self.edges - 1, same), Turn::Different)
            }
        }
    }

    /// Goes from face to face around a vertex, first across `edge`, then across the one `step` further.
    fn turn(&self, edge: u8, step: u8, same: &impl Fn(u32) -> bool) -> Turn {
        let mut at = self.beyond(self.face, edge);
        for _ in 0..LARGEST_VALENCE {
            let Some(neighbor) = at else { return Turn::Border };
            if neighbor.face == self.face {
                return Turn::Closed;
            }
            if !same(neighbor.face) {
                return Turn::Different;
            }
            at = self.beyond(neighbor.face, (neighbor.edge + step) % self.edges);
        }
        Turn::Different
    }
}

/// How a turn around a vertex ends.
enum Turn {
    Closed,
    Border,
    Different,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::face::Face;

    /// A grid of `n` by `n` quads, side by side.
    fn grid(n: u32) -> Vec<Record> {
        let at = |u: i64, v: i64, edge| {
            let inside = (0..i64::from(n)).contains(&u) && (0..i64::from(n)).contains(&v);
            inside.then_some(Neighbor { face: (v * i64::from(n) + u) as u32, edge })
        };
        let record = |index: u32| {
            let (u, v) = (i64::from(index % n), i64::from(index / n));
            let neighbors = [at(u, v - 1, 2), at(u + 1, v, 3), at(u, v + 1, 0), at(u - 1, v, 1)];
            Record { face: Face { neighbors, ..Face::new(2, 2) }, flags: CONSTANT }
        };
        (0..n * n).map(record).collect()
    }

    fn flagged(records: &[Record]) -> Vec<usize> {
        (0..records.len()).filter(|face| records[*face].has(CONSTANT_NEIGHBORHOOD)).collect()
    }

    #[test]
    fn a_face_of_another_value_is_seen_across_corners_too() {
        let mut records = grid(5);
        flag(&mut records, MeshType::Quad, Borders::default(), |face| if face == 12 { b"a" } else { b"b" });
        // All around the middle one see it.
        let expected: Vec<usize> =
            (0..25).filter(|face| !(1..4).contains(&(face % 5)) || !(5..20).contains(face)).collect();
        assert_eq!(flagged(&records), expected);
        let mut records = grid(3);
        records[0].flags = 0;
        flag(&mut records, MeshType::Quad, Borders::default(), |_| b"b");
        assert_eq!(flagged(&records), [2, 5, 6, 7, 8]);
    }

    #[test]
    fn black_beyond_the_border_and_sub_faces_are_different() {
        let mut records = grid(4);
        let borders = Borders { u: BorderMode::Black, ..Borders::default() };
        flag(&mut records, MeshType::Quad, borders, |_| b"b");
        assert_eq!(flagged(&records), [5, 6, 9, 10]);
        let mut records = grid(4);
        records[0].face.subface = true;
        flag(&mut records, MeshType::Quad, Borders::default(), |_| b"b");
        assert!(!records[5].has(CONSTANT_NEIGHBORHOOD) && records[6].has(CONSTANT_NEIGHBORHOOD));
    }

    /// Links that lead nowhere back end the turn.
    #[test]
    fn links_in_a_circle_end() {
        let mut records = grid(2);
        for edge in 0..4 {
            records[1].face.neighbors[edge] = Some(Neighbor { face: 2, edge: 0 });
            records[2].face.neighbors[edge] = Some(Neighbor { face: 1, edge: 0 });
        }
        flag(&mut records, MeshType::Quad, Borders::default(), |_| b"b");
        assert!(!records[0].has(CONSTANT_NEIGHBORHOOD));
    }
}
