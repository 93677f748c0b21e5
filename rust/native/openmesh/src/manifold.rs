//! Finds faces at which triangles are no oriented manifold. OpenMesh would refuse them one by one with lines on stderr.

use relievo_core::{Error, Result};

/// The most faces that an error names.
const NAMED: usize = 8;

/// Fails, with the numbers of the faces at fault, unless the triangles form an oriented manifold with or without
/// boundary: their vertices exist and differ, no directed edge occurs twice, and the faces around each vertex form one
/// fan. Coordinates must be finite.
pub fn check(points: &[[f32; 3]], triangles: &[[u32; 3]]) -> Result<()> {
    if i32::try_from(3 * points.len().max(2 * triangles.len())).is_err() {
        return Err(Error::unsupported("the patch is too large for OpenMesh").advise("take a smaller part of the mesh"));
    }
    if let Some(point) = points.iter().position(|point| !point.iter().all(|value| value.is_finite())) {
        return Err(Error::invalid("a coordinate is not a finite number").at(format!("vertex {point}")));
    }
    let is_usable = |[a, b, c]: &[u32; 3]| {
        let exist = [a, b, c].iter().all(|vertex| (**vertex as usize) < points.len());
        exist && a != b && b != c && c != a
    };
    refuse("their vertices do not exist or repeat", faces_where(triangles.len(), |face| !is_usable(&triangles[face])))?;

    // Directed edges, sorted, with the corner at which each begins.
    let corners = triangles.as_flattened();
    let next = |corner: u32| if corner % 3 == 2 { corner - 2 } else { corner + 1 };
    let mut edges: Vec<(u32, u32, u32)> = (0..corners.len() as u32)
        .map(|corner| (corners[corner as usize], corners[next(corner) as usize], corner))
        .collect();
    edges.sort_unstable();
    let doubled = edges.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)).filter(|edge| edge.len() > 1);
    let doubled: Vec<u32> = doubled.flatten().map(|edge| edge.2 / 3).collect();
    refuse("they share an edge in the same direction or with more than one other", doubled)?;

    // Corners that follow each other around a vertex are joined; two fans at one vertex stay apart.
    let mut above: Vec<u32> = (0..corners.len() as u32).collect();
    for (from, to, corner) in &edges {
        if let Ok(found) = edges.binary_search_by_key(&(*to, *from), |edge| (edge.0, edge.1)) {
            let mate = edges[found].2;
            join(&mut above, *corner, next(mate));
            join(&mut above, next(*corner), mate);
        }
    }
    let mut fan = vec![NO_FAN; points.len()];
    let mut apart = Vec::new();
    for corner in 0..corners.len() as u32 {
        let (vertex, root) = (corners[corner as usize] as usize, root(&mut above, corner));
        if fan[vertex] == NO_FAN {
            fan[vertex] = root;
        } else if fan[vertex] != root {
            apart.push(corner / 3);
        }
    }
    refuse("they meet others in a single vertex", apart)
}

const NO_FAN: u32 = u32::MAX;

fn faces_where(count: usize, is_bad: impl Fn(usize) -> bool) -> Vec<u32> {
    (0..count).filter(|face| is_bad(*face)).map(|face| face as u32).collect()
}

fn refuse(what: &str, mut faces: Vec<u32>) -> Result<()> {
    if faces.is_empty() {
        return Ok(());
    }
    faces.sort_unstable();
    faces.dedup();
    let mut names: Vec<String> = faces.iter().take(NAMED).map(u32::to_string).collect();
    if faces.len() > NAMED {
        names.push(format!("and {} more", faces.len() - NAMED));
    }
    Err(Error::invalid(format!("{} faces are not part of an oriented manifold: {what}", faces.len()))
        .at(format!("faces {}", names.join(", ")))
        .advise("repair the mesh first"))
}

/// The representative of a set, with halved paths (Tarjan 1975).
fn root(above: &mut [u32], mut item: u32) -> u32 {
    while above[item as usize] != item {
        let next = above[above[item as usize] as usize];
        above[item as usize] = next;
        item = next;
    }
    item
}

fn join(above: &mut [u32], a: u32, b: u32) {
    let (a, b) = (root(above, a), root(above, b));
    above[a.max(b) as usize] = a.min(b);
}
