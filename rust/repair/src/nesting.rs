//! How many closed components each closed component lies within.

use glam::DVec3;
use relievo_core::Context;

use crate::corners::Corners;
use crate::orient::Components;

/// Tests of a ray against a face that are made in all. Components beyond count as outermost.
const MAX_TESTS: usize = 1 << 28;

/// Directions of the rays, far from directions that models are aligned with; the majority decides.
const DIRECTIONS: [DVec3; 3] =
    [DVec3::new(0.5477, 0.6123, 0.5703), DVec3::new(-0.7219, 0.2411, 0.6487), DVec3::new(0.3119, -0.8537, 0.4171)];

/// Returns for every component the number of closed components around it; 0 for components that are not closed.
pub fn depths(context: &Context, corners: &Corners, components: &Components) -> Vec<usize> {
    let mut depths = vec![0; components.count()];
    let closed: Vec<usize> = (0..components.count()).filter(|component| components.is_closed[*component]).collect();
    if closed.len() < 2 {
        return depths;
    }
    let mut faces: Vec<Vec<u32>> = vec![Vec::new(); components.count()];
    (0..).zip(&components.of).for_each(|(face, component)| faces[*component as usize].push(face));
    let boxes: Vec<[DVec3; 2]> = context.map(components.count(), |component| {
        let places = faces[component].iter().flat_map(|face| corners.face_points(*face)).map(|it| corners.place(*it));
        places.fold([DVec3::INFINITY, DVec3::NEG_INFINITY], |[low, high], place| [low.min(place), high.max(place)])
    });
    let contains = |outer: usize, inner: usize| {
        boxes[outer][0].cmple(boxes[inner][0]).all() && boxes[outer][1].cmpge(boxes[inner][1]).all()
    };
    // The largest boxes first, so that a scan ends where boxes are smaller than the one in question.
    let size = |component: usize| (boxes[component][1] - boxes[component][0]).length_squared();
    let mut by_size = closed.clone();
    by_size.sort_by(|a, b| size(*b).total_cmp(&size(*a)).then(a.cmp(b)));
    let mut tests = 0;
    for inner in &closed {
        let outer = by_size.iter().take_while(|outer| size(**outer) >= size(*inner));
        for outer in outer.filter(|outer| *outer != inner && contains(**outer, *inner)) {
            tests += DIRECTIONS.len() * faces[*outer].len();
            if tests > MAX_TESTS {
                return depths;
            }
            let place = corners.place(corners.face_points(components.first[*inner])[0]);
            depths[*inner] += usize::from(is_inside(context, corners, &faces[*outer], place));
        }
    }
    depths
}

/// Returns whether most rays from a place cross faces an odd number of times.
fn is_inside(context: &Context, corners: &Corners, faces: &[u32], place: DVec3) -> bool {
    let odd = DIRECTIONS.iter().filter(|direction| {
        let parts = context.map(faces.len().div_ceil(4096), |part| {
            let faces = &faces[part * 4096..faces.len().min((part + 1) * 4096)];
            faces.iter().map(|face| crossings(corners, *face, place, **direction)).sum::<usize>()
        });
        parts.iter().sum::<usize>() % 2 == 1
    });
    odd.count() > DIRECTIONS.len() / 2
}

/// Returns how many triangles of a face a ray crosses (Möller and Trumbore 1997).
fn crossings(corners: &Corners, face: u32, place: DVec3, direction: DVec3) -> usize {
    let points = corners.face_points(face);
    let first = corners.place(points[0]);
    let is_crossed = |pair: &&[u32]| {
        let (edge_a, edge_b) = (corners.place(pair[0]) - first, corners.place(pair[1]) - first);
        let p = direction.cross(edge_b);
        let determinant = edge_a.dot(p);
        if determinant == 0.0 {
            return false;
        }
        let s = place - first;
        let q = s.cross(edge_a);
        let (u, v) = (s.dot(p) / determinant, direction.dot(q) / determinant);
        u >= 0.0 && v >= 0.0 && u + v <= 1.0 && edge_b.dot(q) / determinant > 0.0
    };
    points[1..].windows(2).filter(is_crossed).count()
}
