//! Patches stay disks while they grow: after each round of growth, each round that is undone, each removal and each merge.

use std::cell::Cell;

use relievo_core::Mesh;
use relievo_core::progress::Silent;
use relievo_decal::{Decal, DecalSettings, Growing, Pin, Pose, Sticker, lay_watched};

/// What keeps triangles of vertices 0 to `vertices` from being a disk with this boundary, if anything does.
fn defect(vertices: usize, triangles: &[[u32; 3]], boundary: &[u32]) -> Option<String> {
    let mut edges: Vec<(u32, u32)> = triangles.iter().flat_map(|[a, b, c]| [(*a, *b), (*b, *c), (*c, *a)]).collect();
    edges.sort_unstable();
    if let Some(pair) = edges.windows(2).find(|pair| pair[0] == pair[1]) {
        return Some(format!("two triangles have the edge {:?} in the same direction", pair[0]));
    }
    let mut next = vec![None; vertices];
    let mut open = 0;
    for (from, to) in edges.iter().filter(|(from, to)| edges.binary_search(&(*to, *from)).is_err()) {
        if next[*from as usize].replace(*to).is_some() {
            return Some(format!("vertex {from} is twice in the boundary"));
        }
        open += 1;
    }
    // Each edge inside has two directed edges, each one of the boundary has one.
    let euler = vertices as i64 - (edges.len() as i64 + open) / 2 + triangles.len() as i64;
    if euler != 1 {
        return Some(format!("the Euler characteristic is {euler}"));
    }
    let mut roots: Vec<u32> = (0..vertices as u32).collect();
    let mut pieces = vertices;
    for (from, to) in &edges {
        let [from, to] = [*from, *to].map(|vertex| root(&mut roots, vertex));
        pieces -= usize::from(from != to);
        roots[from as usize] = to;
    }
    if pieces != 1 {
        return Some(format!("it is not one piece but {pieces}"));
    }
    let after = boundary.iter().skip(1).chain(boundary.first());
    if let Some((from, to)) = boundary.iter().zip(after).find(|(from, to)| next[**from as usize] != Some(**to)) {
        return Some(format!("the boundary has no edge from {from} to {to}"));
    }
    // The edges of the list lead from vertex to vertex, so that it is one loop, and all of the boundary if it is as long.
    (boundary.len() as i64 != open).then(|| format!("a loop has {} of {open} edges of the boundary", boundary.len()))
}

/// The vertex that stands for the piece of a vertex. Ways to it are halved.
fn root(roots: &mut [u32], mut vertex: u32) -> u32 {
    while roots[vertex as usize] != vertex {
        let above = roots[roots[vertex as usize] as usize];
        roots[vertex as usize] = above;
        vertex = above;
    }
    vertex
}

/// Lays a sticker. Fails if the patch is no disk at any time.
pub fn lay_as_disk(
    mesh: &Mesh,
    sticker: &Sticker,
    pins: &[Pin],
    pose: Option<Pose>,
    settings: &DecalSettings,
) -> relievo_core::Result<Decal> {
    let count = Cell::new(0);
    let watch = |patch: &Growing<'_>| {
        count.set(count.get() + 1);
        if let Some(defect) = defect(patch.vertices, patch.triangles, patch.boundary) {
            panic!("change {} of {} triangles: {defect}", count.get(), patch.triangles.len());
        }
    };
    let decal = lay_watched(mesh, sticker, pins, pose, settings, &watch, &mut Silent)?;
    assert!(count.get() > 2, "only {} changes", count.get());
    Ok(decal)
}

#[test]
fn surfaces_that_are_no_disks_have_a_defect() {
    let check = |vertices: usize, triangles: &[[u32; 3]], boundary: &[u32], expected: &str| {
        let found = defect(vertices, triangles, boundary).unwrap_or_default();
        assert!(if expected.is_empty() { found.is_empty() } else { found.contains(expected) }, "{expected}: {found}");
    };
    let square = [[0, 1, 2], [0, 2, 3]];
    check(4, &square, &[0, 1, 2, 3], "");
    check(5, &square, &[0, 1, 2, 3], "Euler characteristic is 2");
    check(4, &square, &[0, 2, 3], "no edge from 0 to 2");
    check(4, &[[0, 1, 2], [0, 1, 3]], &[0, 1, 2], "same direction");
    // Two triangles that share one vertex.
    check(5, &[[0, 1, 2], [0, 3, 4]], &[0, 1, 2], "vertex 0 is twice");
    // A ring of six triangles around a hole, a closed tetrahedron, and a triangle beside it.
    let ring = [[0, 1, 3], [1, 4, 3], [1, 2, 4], [2, 5, 4], [2, 0, 5], [0, 3, 5]];
    check(6, &ring, &[0, 1, 2], "Euler characteristic is 0");
    let closed = [[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]];
    check(4, &closed, &[], "Euler characteristic is 2");
    // A torus beside a disk has the characteristic of a disk.
    let at = |column: u32, row: u32| 3 * (row % 3) + column % 3;
    let squares = (0..9).map(|at| (at % 3, at / 3));
    let torus = squares.flat_map(|(column, row)| {
        let [a, b] = [at(column, row), at(column + 1, row)];
        let [c, d] = [at(column + 1, row + 1), at(column, row + 1)];
        [[a, b, c], [a, c, d]]
    });
    let both: Vec<[u32; 3]> = torus.chain([[9, 10, 11]]).collect();
    check(12, &both, &[9, 10, 11], "one piece");
}
