//! Patches against closed forms: Euler numbers, disks, loops, and what every operation leaves.

use std::collections::HashMap;

use proptest::prelude::*;
use relievo_openmesh::{Compact, NONE, Patch};

/// A sheet of squares, each of two triangles.
fn sheet(columns: u32, rows: u32) -> (Vec<[f32; 3]>, Vec<[u32; 3]>) {
    let points = (0..=rows).flat_map(|y| (0..=columns).map(move |x| [x as f32, y as f32, 0.0])).collect();
    let at = |x: u32, y: u32| y * (columns + 1) + x;
    let squares = (0..rows).flat_map(|y| (0..columns).map(move |x| (x, y)));
    let triangles = squares.flat_map(|(x, y)| {
        let [a, b, c, d] = [at(x, y), at(x + 1, y), at(x + 1, y + 1), at(x, y + 1)];
        [[a, b, c], [a, c, d]]
    });
    (points, triangles.collect())
}

const TETRAHEDRON: [[u32; 3]; 4] = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
const CORNERS: [[f32; 3]; 4] = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

fn tetrahedron() -> Patch {
    Patch::new(&CORNERS, &TETRAHEDRON).unwrap()
}

/// Counts boundary edges, and fails if a directed edge occurs twice.
fn boundary(compact: &Compact) -> usize {
    let mut edges = HashMap::new();
    for triangle in &compact.triangles {
        for side in 0..3 {
            let edge = (triangle[side], triangle[(side + 1) % 3]);
            assert_eq!(edges.insert(edge, ()), None, "edge {edge:?} occurs twice");
        }
    }
    edges.keys().filter(|(from, to)| !edges.contains_key(&(*to, *from))).count()
}

#[test]
fn what_is_no_oriented_manifold_is_refused_with_its_faces() {
    let (points, triangles) = sheet(2, 2);
    let message = |more: &[[u32; 3]]| {
        let all = [triangles.as_slice(), more].concat();
        Patch::new(&points, &all).unwrap_err().to_string()
    };
    assert!(message(&[[0, 4, 8]]).contains("faces 1, 7, 8"), "{}", message(&[[0, 4, 8]]));
    assert!(message(&[[0, 1, 9]]).contains("faces 8:"), "{}", message(&[[0, 1, 9]]));
    let mut turned = triangles.clone();
    turned[7].swap(0, 1);
    assert!(Patch::new(&points, &turned).unwrap_err().to_string().contains("faces 4, 6, 7:"));
    // Two triangles that meet in a point.
    let apart = Patch::new(&points, &[[0, 1, 4], [4, 7, 8]]).unwrap_err().to_string();
    assert!(apart.contains("single vertex") && apart.contains("faces 1"), "{apart}");
    assert!(Patch::new(&[[f32::NAN; 3]; 3], &[[0, 1, 2]]).is_err());
}

#[test]
fn removed_faces_open_a_hole_and_come_back() {
    let mut patch = tetrahedron();
    assert_eq!((patch.euler_number().unwrap(), patch.components().unwrap()), (2, 1));
    assert!(patch.boundary_loops().unwrap().is_empty() && !patch.is_disk().unwrap());
    let before = patch.try_clone().unwrap();
    patch.remove_faces(&[2]).unwrap();
    assert!(patch.is_disk().unwrap());
    let loops = patch.boundary_loops().unwrap();
    assert_eq!(loops.len(), 1);
    // The surface is on the right of the loop, so that the missing face runs along it.
    assert!((0..3).any(|shift| [1, 2, 3].map(|it| loops[0][(it - 1 + shift) % 3]) == [1, 2, 3]), "{loops:?}");
    assert_eq!(patch.read().unwrap().old_faces, [0, 1, 3]);
    assert!(patch.remove_faces(&[2]).unwrap_err().to_string().contains("no face 2"));
    assert_eq!(patch.add_faces(&[[1, 2, 3]]).unwrap(), [4]);
    assert_eq!(boundary(&patch.read().unwrap()), 0);
    assert!(patch.add_faces(&[[1, 2, 3]]).unwrap_err().to_string().contains("does not fit"));
    assert_eq!(before.read().unwrap().triangles.len(), 4);
}

#[test]
fn a_path_of_crossed_edges_becomes_a_path_of_edges() {
    let (points, triangles) = sheet(3, 1);
    let mut patch = Patch::new(&points, &triangles).unwrap();
    // Diagonals and uprights from left to right.
    let crossed = [[0, 5], [1, 5], [1, 6], [2, 6], [2, 7]];
    let middles = crossed.map(|ends| {
        let [a, b] = ends.map(|vertex| points[vertex as usize]);
        [0, 1, 2].map(|axis| 0.5 * (a[axis] + b[axis]))
    });
    let made = patch.split_edges(&crossed, &middles).unwrap();
    assert_eq!(made, [8, 9, 10, 11, 12]);
    let edges: Vec<[u32; 2]> = patch.edges().unwrap().iter().map(|edge| edge.ends).collect();
    for pair in made.windows(2) {
        assert!(edges.contains(&[pair[0], pair[1]]) || edges.contains(&[pair[1], pair[0]]), "{pair:?} of {edges:?}");
    }
    assert!(patch.is_disk().unwrap());
    assert_eq!(patch.points(&made).unwrap(), middles);
    assert!(patch.split_edges(&[[0, 7]], &[[0.0; 3]]).unwrap_err().to_string().contains("no edge 0-7"));
    assert!(patch.split_edges(&[[0, 1]], &[]).is_err());
}

#[test]
fn flips_and_collapses_are_made_only_where_a_manifold_stays() {
    let mut patch = tetrahedron();
    // The flipped edge is there already; the link condition forbids the collapse.
    assert_eq!(patch.flip_edges(&[[0, 1]]).unwrap(), [false]);
    assert_eq!(patch.collapse_edges(&[[0, 1]]).unwrap(), [false]);
    let made = patch.split_faces(&[0], &[[0.3, 0.3, 0.0]]).unwrap();
    assert_eq!((made[0], patch.euler_number().unwrap()), (4, 2));
    assert_eq!(patch.collapse_edges(&[[4, 0], [4, 1]]).unwrap(), [true, false]);
    let compact = patch.read().unwrap();
    assert_eq!((compact.points.len(), compact.triangles.len(), boundary(&compact)), (4, 4, 0));
    assert_eq!(compact.old_vertices, [0, 1, 2, 3]);
    let (points, triangles) = sheet(1, 1);
    let mut square = Patch::new(&points, &triangles).unwrap();
    let inner: Vec<_> = square.edges().unwrap().into_iter().filter(|edge| !edge.opposite.contains(&NONE)).collect();
    assert_eq!((inner.len(), square.flip_edges(&[inner[0].ends]).unwrap()), (1, vec![true]));
    assert_eq!(square.flip_edges(&[[0, 1]]).unwrap(), [false]);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]
    /// Whatever is done in whatever order, the patch stays an oriented disk.
    #[test]
    fn any_operations_leave_a_disk(steps in prop::collection::vec((0..4u8, any::<u32>(), any::<u32>()), 0..60)) {
        let (points, triangles) = sheet(4, 3);
        let mut patch = Patch::new(&points, &triangles).unwrap();
        for (kind, number, other) in steps {
            let edges = patch.edges().unwrap();
            let edge = edges[number as usize % edges.len()].ends;
            match kind {
                0 => drop(patch.split_edges(&[edge], &[[other as f32, 0.0, 0.0]]).unwrap()),
                1 => {
                    let faces = patch.read().unwrap().old_faces;
                    drop(patch.split_faces(&[faces[other as usize % faces.len()]], &[[0.0; 3]]).unwrap());
                }
                2 => drop(patch.flip_edges(&[edge]).unwrap()),
                _ => drop(patch.collapse_edges(&[edge]).unwrap()),
            }
        }
        prop_assert!(patch.is_disk().unwrap());
        let compact = patch.read().unwrap();
        let loops = patch.boundary_loops().unwrap();
        prop_assert_eq!(boundary(&compact), loops[0].len());
        prop_assert!(Patch::new(&compact.points, &compact.triangles).is_ok());
    }
}
