//! Vertices that move from cut to cut: nothing jumps, nothing opens, and the error stays near what may be seen.

use std::collections::HashMap;
use std::sync::Arc;

use glam::{DAffine3, DVec3, Vec3};
use relievo_core::Context;
use relievo_core::progress::Silent;
use relievo_crowd::{Agent, Blend, Crowd, CrowdModel, CrowdView, Frame, NONE, skin};
use relievo_lod::distance;
use relievo_testing::Random;

use crate::arm::{built, walking};
use crate::cuts::{borders, places};

/// A model with one agent in one of its poses.
struct Stage {
    model: Arc<CrowdModel>,
    crowd: Crowd,
    places: Vec<u32>,
    points: Vec<[f32; 3]>,
}

/// What a view shows: clusters with blends, and their triangles with the places of their corners.
struct Seen {
    clusters: Vec<u32>,
    blends: Vec<f32>,
    corners: Vec<([u32; 3], [[f32; 3]; 3])>,
}

impl Stage {
    fn new(model: CrowdModel, pose: usize) -> Self {
        let model = Arc::new(model);
        let mut crowd = Crowd::new(vec![Arc::clone(&model)]);
        crowd.add(Agent { model: 0, clip: 0, phase: 0.0, transform: DAffine3::IDENTITY }).unwrap();
        let points = skin(&Context::serial(), &model.character, &model.clips[0].poses[pose], Blend::Linear).unwrap();
        Self { places: places(&model.character), points, crowd, model }
    }

    fn see(&mut self, view: &CrowdView) -> Seen {
        let mut frame = Frame::default();
        self.crowd.cut(&Context::serial(), view, &mut frame).unwrap();
        let drawn = frame.drawn[0];
        let clusters = self.crowd.clusters(&frame, drawn).to_vec();
        let mut blends = self.crowd.blends(&frame, drawn).to_vec();
        blends.resize(clusters.len(), 0.0);
        let mut corners = Vec::new();
        for of in clusters.iter().copied().zip(blends.iter().copied()) {
            for triangle in self.model.triangles(of.0) {
                let place = |vertex: u32| self.model.blended(of, vertex, &self.points);
                corners.push((*triangle, triangle.map(place)));
            }
        }
        Seen { clusters, blends, corners }
    }

    /// Returns where every vertex of the input is shown: its place, or that of the vertex that it went to.
    fn shown(&self, seen: &Seen) -> Vec<Vec3> {
        let mut at = HashMap::new();
        for (triangle, corners) in &seen.corners {
            for (vertex, corner) in triangle.iter().zip(corners) {
                let place = self.places[*vertex as usize];
                let known = *at.entry(place).or_insert(Vec3::from(*corner));
                assert!(known.distance(Vec3::from(*corner)) < 1e-5 * self.model.size(), "place {place} is torn");
            }
        }
        let follow = |vertex: usize| {
            let mut vertex = vertex;
            loop {
                if let Some(found) = at.get(&self.places[vertex]) {
                    return *found;
                }
                let next = self.model.collapses[vertex];
                assert_ne!(next.group, NONE, "vertex {vertex} is nowhere");
                vertex = next.target as usize;
            }
        };
        (0..self.points.len()).map(follow).collect()
    }

    /// Returns the largest distance of a vertex between two views.
    fn jump(&self, one: &Seen, other: &Seen) -> f32 {
        let pairs = self.shown(one).into_iter().zip(self.shown(other));
        pairs.map(|(one, other)| one.distance(other)).fold(0.0, f32::max)
    }

    /// Returns the largest jump, as a share of the model's size, where the cut changes while the tolerance grows, and the
    /// number of changes.
    fn largest_jump(&mut self, view: &CrowdView, tolerances: [f32; 2]) -> (f32, usize) {
        let at = |tolerance: f32| CrowdView { tolerance, ..view.clone() };
        let (mut low, mut largest, mut changes) = (tolerances[0], 0.0f32, 0);
        let mut before = self.see(&at(low));
        while low < tolerances[1] {
            let mut high = 1.03 * low;
            let next = self.see(&at(high));
            let mut after = None;
            if next.clusters != before.clusters {
                // The last change of the step, to a hair.
                let mut first = low;
                while high / first > 1.000_001 && 0.5 * (first + high) > first && 0.5 * (first + high) < high {
                    let middle = self.see(&at(0.5 * (first + high)));
                    if middle.clusters == next.clusters {
                        (high, after) = (0.5 * (first + high), Some(middle));
                    } else {
                        first = 0.5 * (first + high);
                    }
                }
                let end = after.unwrap_or_else(|| self.see(&at(high)));
                let start = self.see(&at(first));
                largest = largest.max(self.jump(&start, &end) / self.model.size());
                changes += 1;
            }
            low *= 1.03;
            before = self.see(&at(low));
        }
        (largest, changes)
    }
}

#[test]
fn no_vertex_jumps_where_the_cut_changes() {
    let mut stage = Stage::new(built(60, 24), 7);
    let plain = CrowdView { eye: [0.4, 1.0, 6.0], pixels: 1000.0, ..CrowdView::default() };
    let moving = CrowdView { geomorph: true, ..plain.clone() };
    let (jump, changes) = stage.largest_jump(&moving, [0.2, 80.0]);
    assert!(jump < 1e-4 && changes > 20, "{jump} in {changes} changes");
    let (jump, changes) = stage.largest_jump(&plain, [0.2, 80.0]);
    assert!(jump > 0.01 && changes > 20, "{jump} in {changes} changes");
}

#[test]
fn surfaces_stay_closed_while_vertices_move() {
    let mut stage = Stage::new(built(60, 24), 5);
    let mut random = Random(19);
    let mut moving = 0;
    for round in 0..150 {
        let mut spread = |from: f32, to: f32| from + (to - from) * random.unit();
        let eye = [spread(-4.0, 4.0), spread(-2.0, 5.0), spread(-4.0, 4.0)];
        let tolerance = 0.2 * 600.0f32.powf(spread(0.0, 1.0));
        let view = CrowdView { eye, pixels: 1000.0, tolerance, geomorph: true, ..CrowdView::default() };
        let seen = stage.see(&view);
        moving += seen.blends.iter().filter(|blend| (0.01..0.99).contains(*blend)).count();
        // Edges between places in space, not of vertices: what moves apart opens them.
        let mut known = HashMap::new();
        let triangles: Vec<[u32; 3]> = seen
            .corners
            .iter()
            .map(|(_, corners)| {
                corners.map(|corner| {
                    let next = known.len() as u32;
                    *known.entry(corner.map(|value| (value + 0.0).to_bits())).or_insert(next)
                })
            })
            .collect();
        let same: Vec<u32> = (0..known.len() as u32).collect();
        let open = borders(&same, triangles.iter());
        assert!(open.is_empty(), "round {round}: {open:?}");
    }
    assert!(moving > 300, "{moving}");
}

#[test]
fn what_is_on_its_way_is_near_what_may_be_seen() {
    let mut stage = Stage::new(built(40, 20), 3);
    let input: Vec<[u32; 3]> =
        stage.model.input_clusters().iter().flat_map(|it| stage.model.triangles(*it)).copied().collect();
    let mut largest = 0.0f32;
    for step in 0..60 {
        // From far away all groups have nearly the same distance.
        let tolerance = 1.1f32.powi(step);
        let view =
            CrowdView { eye: [0.0, 1.5, 200.0], pixels: 10_000.0, tolerance, geomorph: true, ..CrowdView::default() };
        let seen = stage.see(&view);
        let points: Vec<[f32; 3]> = seen.corners.iter().flat_map(|(_, corners)| *corners).collect();
        let triangles: Vec<[u32; 3]> =
            (0..seen.corners.len() as u32).map(|at| [3 * at, 3 * at + 1, 3 * at + 2]).collect();
        let found =
            distance(&Context::serial(), [(&stage.points, &input), (&points, &triangles)], &mut Silent).unwrap();
        largest = largest.max(found.at_least / (tolerance / view.pixels * 200.0));
    }
    assert!(largest < 1.5, "{largest}");
}

#[test]
fn characters_with_seams_do_not_tear_and_old_files_are_refused() {
    if let Some((_, model)) = walking("robot", "Robot_Walking") {
        let size = model.size();
        let mut stage = Stage::new(model, 2);
        let plain = CrowdView { eye: [0.0, 0.5 * size, 2.0 * size], pixels: 1000.0, ..CrowdView::default() };
        let (jump, changes) = stage.largest_jump(&CrowdView { geomorph: true, ..plain }, [1.0, 20.0]);
        assert!(jump < 1e-4 && changes > 5, "{jump} in {changes} changes");
    }
    let old = CrowdModel { collapses: Vec::new(), distances: Vec::new(), ..built(12, 8) };
    let mut bytes = Vec::new();
    old.write(&mut bytes).unwrap();
    let read = CrowdModel::from_bytes(&bytes, u64::MAX).unwrap();
    assert!(bytes[8] == 1 && read == old && !read.has_collapses());
    let mut crowd = Crowd::new(vec![Arc::new(read)]);
    let transform = DAffine3::from_translation(DVec3::Z);
    crowd.add(Agent { model: 0, clip: 0, phase: 0.0, transform }).unwrap();
    let view = CrowdView { geomorph: true, ..CrowdView::default() };
    let refused = crowd.cut(&Context::serial(), &view, &mut Frame::default()).unwrap_err().to_string();
    assert!(refused.contains("where vertices move"), "{refused}");
    // A vertex that goes to one that is removed no later may go in a circle.
    let mut wrong = built(12, 8);
    let gone = wrong.collapses.iter().position(|found| found.group != NONE).unwrap();
    wrong.collapses[gone].target = gone as u32;
    assert!(wrong.check().is_err());
}
