//! Fills holes.

use std::collections::HashMap;

use glam::DVec3;
use relievo_core::{Context, ErrorKind, Progress, Result};

use crate::corners::Corners;
use crate::edges::Edges;
use crate::fair::fair;
use crate::loops::Loop;
use crate::orient::Components;
use crate::refine::{Filling, refine};
use crate::report::{Finding, Report};
use crate::settings::RepairSettings;
use crate::triangulate::Polygon;

/// Holes that are filled between two reports of progress.
const BATCH: usize = 64;

/// Fills the holes of an oriented manifold, and adds what was done to the report.
///
/// # Errors
/// OpenMesh is not installed or refuses a filling, or the caller cancels.
pub fn fill(
    context: &Context,
    corners: &mut Corners,
    (edges, components): (&Edges, &Components),
    settings: &RepairSettings,
    report: &mut Report,
    progress: &mut dyn Progress,
    span: [f32; 2],
) -> Result<()> {
    let (loops, tangled) = Loop::all(corners, edges);
    corners.first_filling = corners.face_count() as u32;
    let listed = settings.listed;
    report.open_holes = Finding::of(tangled.iter().map(|half| corners.edge(*half)), listed);
    for (batch, part) in loops.chunks(BATCH).enumerate() {
        let done = (batch * BATCH) as f32 / loops.len() as f32;
        progress.step(span[0] + (span[1] - span[0]) * done, "filling holes")?;
        let fillings = context.map(part.len(), |index| {
            let hole = &part[index];
            let component = components.of[corners.face(hole.halves[0]) as usize] as usize;
            let most = components.areas[component] * f64::from(settings.hole_area);
            filling(corners, edges, settings, hole, most)
        });
        for (hole, filling) in part.iter().zip(fillings) {
            match filling? {
                None => report.open_holes.add(corners.edge(hole.halves[0]), listed),
                Some(filling) => {
                    report.filled_holes += 1;
                    report.filling_points += filling.parents.len();
                    report.filling_faces += filling.triangles.len();
                    add(corners, hole, &filling);
                }
            }
        }
    }
    Ok(())
}

/// Makes the filling of a hole, or nothing if the hole is to stay open.
fn filling(
    corners: &Corners,
    edges: &Edges,
    settings: &RepairSettings,
    hole: &Loop,
    most_area: f64,
) -> Result<Option<Filling>> {
    let count = hole.points.len();
    let first_face = corners.face(hole.halves[0]);
    // Around a single face there is nothing to fill.
    let is_lonely = hole.halves.iter().all(|half| corners.face(*half) == first_face);
    if is_lonely || (settings.hole_edges > 0 && count > settings.hole_edges as usize) {
        return Ok(None);
    }
    let places: Vec<DVec3> = hole.points.iter().map(|point| corners.place(*point)).collect();
    let near = hole.neighbours(corners, edges);
    let number: HashMap<u32, u32> = hole.points.iter().copied().zip(0..).collect();
    let is_taken = |a: u32, b: u32| near[a as usize].binary_search(&hole.points[b as usize]).is_ok();
    let normals = hole.normals(corners);
    let polygon = Polygon { places: &places, normals: &normals, is_taken: &is_taken };
    let Some(triangles) = polygon.triangulate() else { return Ok(None) };
    let area: f64 = triangles
        .iter()
        .map(|triangle| {
            let [a, b, c] = triangle.map(|vertex| places[vertex as usize]);
            0.5 * (b - a).cross(c - a).length()
        })
        .sum();
    if area > most_area {
        return Ok(None);
    }
    let mut filling = Filling { places, triangles, parents: Vec::new() };
    if settings.refine.is_on() {
        let scale = |(near, place): (&Vec<u32>, &DVec3)| {
            near.iter().map(|point| corners.place(*point).distance(*place)).sum::<f64>() / near.len().max(1) as f64
        };
        let scales: Vec<f64> = near.iter().zip(&filling.places).map(scale).collect();
        refine(&mut filling, &scales, &is_taken).map_err(|error| match error.kind {
            ErrorKind::NotFound => {
                let remedy = format!("{}, or leave the refinement of fillings out", error.remedy);
                error.advise(remedy)
            }
            _ => error,
        })?;
        if settings.fair.is_on() {
            let outside = |point: &&u32| !number.contains_key(point);
            let around: Vec<Vec<DVec3>> = near
                .iter()
                .map(|near| near.iter().filter(outside).map(|point| corners.place(*point)).collect())
                .collect();
            fair(&mut filling, count, &around);
        }
    }
    Ok(Some(filling))
}

/// Adds the faces of a filling. Each has the attributes of the face beside the loop from which one reaches it first.
fn add(corners: &mut Corners, hole: &Loop, filling: &Filling) {
    let border = hole.points.len();
    let mut points = hole.points.clone();
    let mut origins = hole.origins(corners);
    for (place, parents) in filling.places[border..].iter().zip(&filling.parents) {
        let blend = corners.blends.len() as u32;
        corners.blends.push(parents.map(|parent| origins[parent as usize]));
        points.push(corners.places.len() as u32);
        origins.push(corners.input_corners + blend);
        corners.places.push(place.as_vec3().to_array());
        corners.place_origins.push(corners.input_points + blend);
    }
    let faces = beside(corners, hole, filling);
    for (triangle, face) in filling.triangles.iter().zip(faces) {
        let of = |numbers: &[u32]| triangle.map(|vertex| numbers[vertex as usize]);
        corners.add_triangle(of(&points), of(&origins), face);
    }
}

/// Returns for every triangle of a filling the origin of the face beside the loop that is nearest across triangles.
fn beside(corners: &Corners, hole: &Loop, filling: &Filling) -> Vec<u32> {
    let border = hole.points.len() as u32;
    let mut across: HashMap<[u32; 2], usize> = HashMap::with_capacity(3 * filling.triangles.len());
    let sides = |triangle: &[u32; 3]| [0, 1, 2].map(|side| [triangle[side], triangle[(side + 1) % 3]]);
    for (index, triangle) in filling.triangles.iter().enumerate() {
        across.extend(sides(triangle).map(|side| (side, index)));
    }
    let mut found: Vec<Option<u32>> = vec![None; filling.triangles.len()];
    let mut reached = Vec::with_capacity(filling.triangles.len());
    for (vertex, half) in (0..border).zip(&hole.halves) {
        if let Some(index) = across.get(&[vertex, (vertex + 1) % border])
            && found[*index].is_none()
        {
            found[*index] = Some(corners.face_origins[corners.face(*half) as usize]);
            reached.push(*index);
        }
    }
    let mut next = 0;
    while next < reached.len() {
        let index = reached[next];
        next += 1;
        for [from, to] in sides(&filling.triangles[index]) {
            if let Some(other) = across.get(&[to, from])
                && found[*other].is_none()
            {
                found[*other] = found[index];
                reached.push(*other);
            }
        }
    }
    let default = corners.face_origins[corners.face(hole.halves[0]) as usize];
    found.into_iter().map(|face| face.unwrap_or(default)).collect()
}
