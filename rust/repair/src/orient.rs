//! Orients faces: neighbours agree, and closed components face outwards.

use glam::DVec3;
use relievo_core::Context;

use crate::corners::Corners;
use crate::edges::{BOUNDARY, Edges};
use crate::nesting;
use crate::report::Finding;
use crate::sets::Sets;

/// Turns faces over until the two faces of every edge agree. Of each component the smaller part is turned; where both
/// are equal, the first face stays. Edges of parts that have one side only are cut. Returns the number of faces that
/// were turned and the edges that were cut.
pub fn agree(corners: &mut Corners, edges: &mut Edges, listed: u32) -> (Vec<bool>, Finding) {
    let faces = corners.face_count();
    let mut sets = Sets::new(faces);
    for (half, mate) in inner_edges(edges) {
        // Half-edges of two faces that agree run in opposite directions.
        let is_turned = corners.from(half) == corners.from(mate);
        sets.join(corners.face(half), corners.face(mate), is_turned);
    }
    let sides: Vec<(u32, bool)> = (0..faces as u32).map(|face| sets.root(face)).collect();
    let mut balance = vec![0i64; faces];
    sides.iter().for_each(|(root, turned)| balance[*root as usize] += if *turned { -1 } else { 1 });
    let turn: Vec<bool> = sides.iter().map(|(root, turned)| *turned != (balance[*root as usize] < 0)).collect();
    let mut one_sided = Finding::default();
    let disagree: Vec<u32> = inner_edges(edges)
        .filter(|(half, mate)| {
            let is_turned = corners.from(*half) == corners.from(*mate);
            is_turned != (turn[corners.face(*half) as usize] != turn[corners.face(*mate) as usize])
        })
        .map(|(half, _)| half)
        .collect();
    for half in disagree {
        one_sided.add(corners.edge(half), listed);
        edges.cut(half);
    }
    turn_over(corners, edges, &turn);
    (turn, one_sided)
}

/// Edges of two different faces, by their half-edges, each once.
fn inner_edges(edges: &Edges) -> impl Iterator<Item = (u32, u32)> {
    let halves = (0..).zip(&edges.mates);
    halves.filter(|(half, mate)| *half < **mate && edges.mate(*half).is_some()).map(|(half, mate)| (half, *mate))
}

/// Reverses faces, and renumbers half-edges to fit.
fn turn_over(corners: &mut Corners, edges: &mut Edges, turn: &[bool]) {
    if !turn.contains(&true) {
        return;
    }
    // The half-edge from corner i to i + 1 of n becomes the one from n - 2 - i.
    let renumbered = |corners: &Corners, half: u32| {
        let face = corners.face(half);
        if !turn[face as usize] {
            return half;
        }
        let range = corners.range(face);
        let (start, size) = (range.start as u32, range.len() as u32);
        start + (2 * size - 2 - (half - start)) % size
    };
    let mut mates = vec![BOUNDARY; edges.mates.len()];
    for (half, mate) in (0..).zip(&edges.mates) {
        let to = edges.mate(half).map_or(*mate, |mate| renumbered(corners, mate));
        mates[renumbered(corners, half) as usize] = to;
    }
    edges.mates = mates;
    for half in edges.branching.iter_mut().flatten() {
        *half = renumbered(corners, *half);
    }
    for face in (0..).zip(turn).filter(|(_, turn)| **turn).map(|(face, _)| face) {
        let range = corners.range(face);
        corners.points[range.clone()].reverse();
        corners.origins[range].reverse();
    }
}

/// Components of faces that share edges.
pub struct Components {
    /// The component of every face.
    pub of: Vec<u32>,
    /// The first face of each component.
    pub first: Vec<u32>,
    /// Whether each component has no boundary.
    pub is_closed: Vec<bool>,
    /// Six times the signed volume of each component.
    pub volumes: Vec<f64>,
    /// The area of each component.
    pub areas: Vec<f64>,
}

impl Components {
    /// Finds components and measures them.
    pub fn of(context: &Context, corners: &Corners, edges: &Edges) -> Self {
        let faces = corners.face_count();
        let mut sets = Sets::new(faces);
        inner_edges(edges).for_each(|(half, mate)| {
            sets.join(corners.face(half), corners.face(mate), false);
        });
        for group in &edges.branching {
            group.windows(2).for_each(|pair| {
                sets.join(corners.face(pair[0]), corners.face(pair[1]), false);
            });
        }
        let (of, count) = sets.labels();
        let mut made = Self {
            of,
            first: vec![u32::MAX; count],
            is_closed: vec![true; count],
            volumes: vec![0.0; count],
            areas: vec![0.0; count],
        };
        // Relative to a place nearby, so that far meshes lose no digits.
        let origin = corners.points.first().map_or(DVec3::ZERO, |point| corners.place(*point));
        let measures = context.map(faces, |face| {
            let vector = corners.area_vector(face as u32);
            let points = corners.face_points(face as u32);
            let center: DVec3 = points.first().map_or(DVec3::ZERO, |point| corners.place(*point) - origin);
            // Triangles fanned from the first point all have that point against their area vectors.
            (center.dot(vector), 0.5 * vector.length())
        });
        for (face, (volume, area)) in (0..).zip(measures) {
            let component = made.of[face as usize] as usize;
            made.first[component] = made.first[component].min(face);
            made.volumes[component] += volume;
            made.areas[component] += area;
        }
        for (half, mate) in (0..).zip(&edges.mates) {
            if *mate >= crate::edges::BRANCHING {
                made.is_closed[made.of[corners.face(half) as usize] as usize] = false;
            }
        }
        made
    }

    /// The number of components.
    pub fn count(&self) -> usize {
        self.first.len()
    }
}

/// Turns closed components so that they face outwards. One within others keeps its sense if its faces agreed from the
/// start, and else faces outwards or inwards in turn, as the shells of a hollow body do. Returns which faces were turned,
/// the components at fault, and all components as they are now.
pub fn outward(
    context: &Context,
    corners: &mut Corners,
    edges: &mut Edges,
    was_turned: &[bool],
    listed: u32,
) -> (Vec<bool>, Finding, Components) {
    let mut components = Components::of(context, corners, edges);
    let mut had_agreed = vec![true; components.count()];
    let mut seen: Vec<Option<bool>> = vec![None; components.count()];
    for (component, turned) in components.of.iter().zip(was_turned) {
        let first = *seen[*component as usize].get_or_insert(*turned);
        had_agreed[*component as usize] &= first == *turned;
    }
    let depths = nesting::depths(context, corners, &components);
    let mut inverted = Finding::default();
    let turn: Vec<bool> = (0..components.count())
        .map(|component| {
            let volume = components.volumes[component];
            if !components.is_closed[component] || volume == 0.0 {
                return false;
            }
            let depth = depths[component];
            let outside = depth == 0 || (!had_agreed[component] && depth.is_multiple_of(2));
            let inside = depth > 0 && !had_agreed[component] && depth % 2 == 1;
            (outside && volume < 0.0) || (inside && volume > 0.0)
        })
        .collect();
    for component in (0..components.count()).filter(|component| turn[*component]) {
        inverted.add(corners.named(components.first[component]), listed);
        components.volumes[component] = -components.volumes[component];
    }
    let faces: Vec<bool> = components.of.iter().map(|component| turn[*component as usize]).collect();
    turn_over(corners, edges, &faces);
    (faces, inverted, components)
}
