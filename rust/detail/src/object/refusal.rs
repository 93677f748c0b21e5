//! Which faces have tiles that a budget refused, for hosts and people.

use relievo_surface::TileTopology;

/// Faces that a message names.
const NAMED: usize = 12;

/// The faces of `tiles`, ascending.
///
/// # Panics
/// If there is no such tile.
pub fn faces(topology: &TileTopology, tiles: &[u32]) -> Vec<u32> {
    let mut faces: Vec<u32> = tiles.iter().map(|tile| topology.face(*tile)).collect();
    faces.sort_unstable();
    faces.dedup();
    faces
}

/// Faces by their numbers: all of them, or the first and how many there are besides.
pub fn named(faces: &[u32]) -> String {
    let list = |faces: &[u32]| faces.iter().map(u32::to_string).collect::<Vec<_>>().join(", ");
    match faces {
        [one] => format!("face {one}"),
        few if few.len() <= NAMED => format!("faces {}", list(few)),
        many => format!("faces {} and {} more", list(&many[..NAMED]), many.len() - NAMED),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn many_faces_are_counted() {
        assert_eq!(named(&[7]), "face 7");
        assert_eq!(named(&[7, 9]), "faces 7, 9");
        let many: Vec<u32> = (0..20).collect();
        assert_eq!(named(&many), "faces 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11 and 8 more");
    }
}
