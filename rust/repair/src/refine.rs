//! Refines the triangles of a filling until they are as large as those around the hole (Liepa 2003, Section 4), by
//! splits and flips of a patch of OpenMesh.

use glam::DVec3;
use relievo_core::Result;
use relievo_openmesh::{Patch, PatchEdge};

/// A triangulated filling. Its first vertices are those of the loop.
#[derive(Debug)]
pub struct Filling {
    /// Positions.
    pub places: Vec<DVec3>,
    /// Triangles.
    pub triangles: Vec<[u32; 3]>,
    /// The three vertices in whose middle each vertex after those of the loop was inserted; earlier ones.
    pub parents: Vec<[u32; 3]>,
}

/// The most points that one filling may add. A round hole of n edges of one length gets n²/13.
const MAX_POINTS: usize = 100_000;
/// The most points that a filling adds to a loop of n points, as a multiple of n².
const POINTS_OF_LOOP: usize = 8;
/// The most rounds of splits, each of which may triple the triangles.
const MAX_SPLITS: usize = 64;
/// The most rounds of flips after each round of splits.
const MAX_FLIPS: usize = 32;
/// The smallest scale, as a share of the mean of those above zero: where points coincide, splits would not end.
const SMALLEST: f64 = 0.125;

/// Adds points to a filling. `scales` are the mean lengths of the edges of the mesh at the vertices of the loop, and
/// `is_taken` says which of these are joined by an edge of the mesh.
///
/// # Errors
/// OpenMesh refuses the triangles.
pub fn refine(filling: &mut Filling, scales: &[f64], is_taken: &dyn Fn(u32, u32) -> bool) -> Result<()> {
    let border = filling.places.len();
    let narrow = |place: &DVec3| place.as_vec3().to_array();
    // The patch keeps connectivity alone; positions are relative to the loop, for their digits.
    let origin = filling.places[0];
    let points: Vec<[f32; 3]> = filling.places.iter().map(|place| narrow(&(*place - origin))).collect();
    let mut patch = Patch::new(&points, &filling.triangles)?;
    let count = scales.iter().filter(|scale| **scale > 0.0).count();
    if count == 0 {
        return Ok(());
    }
    let mean = scales.iter().sum::<f64>() / count as f64;
    let mut scales: Vec<f64> = scales.iter().map(|scale| scale.max(SMALLEST * mean)).collect();
    let most = MAX_POINTS.min(POINTS_OF_LOOP * border * border);
    for _ in 0..MAX_SPLITS {
        let mut faces = Vec::new();
        let mut added = Vec::new();
        for (face, triangle) in (0..).zip(&filling.triangles) {
            let corners = triangle.map(|vertex| filling.places[vertex as usize]);
            let center = (corners[0] + corners[1] + corners[2]) / 3.0;
            let scale = triangle.iter().map(|vertex| scales[*vertex as usize]).sum::<f64>() / 3.0;
            let is_coarse = triangle.iter().zip(corners).all(|(vertex, place)| {
                let distance = std::f64::consts::SQRT_2 * center.distance(place);
                distance > scale && distance > scales[*vertex as usize]
            });
            if is_coarse {
                faces.push(face);
                added.push(narrow(&(center - origin)));
                filling.places.push(center);
                filling.parents.push(*triangle);
                scales.push(scale);
            }
        }
        if faces.is_empty() {
            return Ok(());
        }
        patch.split_faces(&faces, &added)?;
        relax(&mut patch, filling, border, is_taken)?;
        filling.triangles = patch.read()?.triangles;
        if filling.places.len() - border > most {
            break;
        }
    }
    Ok(())
}

/// Flips edges until the angles opposite to each add up to no more than half a turn.
fn relax(patch: &mut Patch, filling: &Filling, border: usize, is_taken: &dyn Fn(u32, u32) -> bool) -> Result<()> {
    // Edges away from the flips of a round are as they were when they were tested.
    let mut is_near = vec![true; filling.places.len()];
    for _ in 0..MAX_FLIPS {
        let mut is_touched = vec![false; filling.places.len()];
        let mut chosen = Vec::new();
        for edge in patch.edges()? {
            let [left, right] = edge.opposite;
            if left == relievo_openmesh::NONE || right == relievo_openmesh::NONE {
                continue;
            }
            let four = [edge.ends[0], edge.ends[1], left, right];
            if four.iter().all(|vertex| !is_near[*vertex as usize]) {
                continue;
            }
            let on_border = (left as usize) < border && (right as usize) < border;
            // Flips of one round share no vertex, so that none sees another's.
            if four.iter().any(|vertex| is_touched[*vertex as usize])
                || (on_border && is_taken(left, right))
                || !should_flip(filling, &edge)
            {
                continue;
            }
            four.iter().for_each(|vertex| is_touched[*vertex as usize] = true);
            chosen.push(edge.ends);
        }
        if !patch.flip_edges(&chosen)?.contains(&true) {
            return Ok(());
        }
        is_near = is_touched;
    }
    Ok(())
}

/// Whether the angles opposite to an edge add up to more than half a turn, and a flip does not fold the surface.
fn should_flip(filling: &Filling, edge: &PatchEdge) -> bool {
    let place = |vertex: u32| filling.places[vertex as usize];
    let ([a, b], [c, d]) = (edge.ends.map(place), edge.opposite.map(place));
    let cotangent = |apex: DVec3| {
        let (u, v) = (a - apex, b - apex);
        u.dot(v) / u.cross(v).length().max(f64::MIN_POSITIVE)
    };
    let turned = |p: DVec3, q: DVec3, r: DVec3| (q - p).cross(r - p);
    // Where both are flat or nearly so, rounding must not flip an edge back and forth.
    cotangent(c) + cotangent(d) < -1e-9
        && turned(c, d, b).dot(turned(d, c, a)) > 0.0
        && turned(c, d, b).dot(turned(a, b, c)) > 0.0
}
