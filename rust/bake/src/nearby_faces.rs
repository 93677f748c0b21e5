//! The place of a triangle mesh that is nearest to a point, by a hierarchy of boxes. Units: object units.

use glam::{DVec3, Vec3};
use relievo_surface::TriangleSurface;
use relievo_surface::triangle::closest;

/// Faces of a triangle mesh that are looked for near points.
#[derive(Debug)]
pub(crate) struct NearbyFaces<'a> {
    surface: &'a TriangleSurface,
    faces: Vec<u32>,
    /// Parents before their children, the first child right after its parent.
    boxes: Vec<FaceBox>,
}

/// The bounds of a part of the faces.
#[derive(Clone, Copy, Debug)]
struct FaceBox {
    low: Vec3,
    high: Vec3,
    from: usize,
    to: usize,
    /// The second child, or 0 without children.
    second: usize,
}

/// A place that was found.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FoundFace {
    pub face: u32,
    /// Barycentric coordinates.
    pub at: [f32; 3],
    pub distance: f64,
}

/// Faces of a box that is not divided.
const LEAF_FACES: usize = 4;

impl<'a> NearbyFaces<'a> {
    pub fn new(surface: &'a TriangleSurface, faces: Vec<u32>) -> Self {
        let mut nearby = Self { surface, faces, boxes: Vec::new() };
        nearby.divide(0, nearby.faces.len());
        nearby
    }

    fn divide(&mut self, from: usize, to: usize) {
        let surface = self.surface;
        let points = self.faces[from..to].iter().flat_map(|face| surface.corner_points(*face)).map(Vec3::from);
        let (low, high) = points.fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), p| (low.min(p), high.max(p)));
        let index = self.boxes.len();
        self.boxes.push(FaceBox { low, high, from, to, second: 0 });
        if to - from <= LEAF_FACES {
            return;
        }
        let middle = (from + to) / 2;
        let axis = (high - low).max_position();
        let along = |face: u32| surface.corner_points(face).iter().map(|point| point[axis]).sum::<f32>();
        self.faces[from..to]
            .select_nth_unstable_by(middle - from, |a, b| along(*a).total_cmp(&along(*b)).then(a.cmp(b)));
        self.divide(from, middle);
        self.boxes[index].second = self.boxes.len();
        self.divide(middle, to);
    }

    /// The nearest place within a distance of `point`, of faces that look as `normal` does if there is one.
    pub fn find(&self, point: Vec3, normal: Option<Vec3>, within: f64) -> Option<FoundFace> {
        let mut best = None;
        if !self.faces.is_empty() {
            self.search(0, point.as_dvec3(), normal.map(Vec3::as_dvec3), within, &mut best);
        }
        best
    }

    fn distance(&self, index: usize, point: DVec3) -> f64 {
        let FaceBox { low, high, .. } = self.boxes[index];
        point.clamp(low.as_dvec3(), high.as_dvec3()).distance(point)
    }

    fn search(&self, index: usize, point: DVec3, normal: Option<DVec3>, within: f64, best: &mut Option<FoundFace>) {
        let FaceBox { from, to, second, .. } = self.boxes[index];
        if self.distance(index, point) > best.map_or(within, |best| best.distance) {
            return;
        }
        if second > 0 {
            let mut children = [index + 1, second];
            if self.distance(children[1], point) < self.distance(children[0], point) {
                children.swap(0, 1);
            }
            children.into_iter().for_each(|child| self.search(child, point, normal, within, best));
            return;
        }
        for face in &self.faces[from..to] {
            let corners @ [a, b, c] = self.surface.corner_points(*face).map(|p| Vec3::from(p).as_dvec3());
            if normal.is_some_and(|normal| (b - a).cross(c - a).dot(normal) <= 0.0) {
                continue;
            }
            let shares = closest(point, corners);
            let distance = (a * shares[0] + b * shares[1] + c * shares[2]).distance(point);
            if best.map_or(distance <= within, |best| distance < best.distance) {
                *best = Some(FoundFace { face: *face, at: shares.map(|share| share as f32), distance });
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use relievo_core::{Context, Mesh};
    use relievo_testing::Random;

    use super::*;

    #[test]
    fn no_face_is_nearer_and_those_that_look_away_are_none() {
        let mut random = Random(5);
        let points: Vec<[f32; 3]> = (0..90).map(|_| [(); 3].map(|()| random.unit())).collect();
        let mesh = Mesh::new(points, vec![3; 30], (0..90).collect());
        let surface = TriangleSurface::new(&Context::serial(), &mesh).unwrap();
        let nearby = NearbyFaces::new(&surface, (0..30).collect());
        for _ in 0..200 {
            let point = Vec3::from([(); 3].map(|()| 2.0 * random.unit() - 0.5));
            let normal = (random.below(2) == 0).then_some(Vec3::from([(); 3].map(|()| random.unit() - 0.5)));
            let within = 2.0 * f64::from(random.unit());
            let one_by_one = (0..30).filter_map(|face| {
                let corners @ [a, b, c] = surface.corner_points(face).map(|p| Vec3::from(p).as_dvec3());
                let shares = closest(point.as_dvec3(), corners);
                let distance = (a * shares[0] + b * shares[1] + c * shares[2]).distance(point.as_dvec3());
                let faces = normal.is_none_or(|normal| (b - a).cross(c - a).dot(normal.as_dvec3()) > 0.0);
                (faces && distance <= within).then_some(distance)
            });
            let expected = one_by_one.min_by(f64::total_cmp);
            assert_eq!(nearby.find(point, normal, within).map(|found| found.distance), expected);
        }
        assert!(NearbyFaces::new(&surface, Vec::new()).find(Vec3::ZERO, None, 9.0).is_none());
    }
}
