//! Signed distances to triangle meshes by a hierarchy of boxes.
//!
//! The sign is that of the normal at the closest point, which is angle-weighted at vertices and edges (Bærentzen and
//! Aanæs 2005), so that it is right on closed meshes everywhere.

use std::collections::HashMap;

use glam::Vec3;
use relievo_core::{Error, Result};

/// Triangles of a leaf at most.
const LEAF: usize = 4;

/// A triangle mesh that is asked for closest points.
#[derive(Clone, Debug)]
pub struct DistanceField {
    triangles: Vec<[Vec3; 3]>,
    /// The triangle at each place of the leaves.
    order: Vec<u32>,
    boxes: Vec<BoxNode>,
    /// Normals of each triangle: its own, those of its corners and those of its edges from corner 0, 1 and 2.
    normals: Vec<[Vec3; 7]>,
}

#[derive(Clone, Copy, Debug)]
struct BoxNode {
    low: Vec3,
    high: Vec3,
    /// The first place of a leaf, or the second child; the first child comes next.
    first: u32,
    /// Triangles of a leaf; 0 of a node with children.
    count: u32,
}

/// The point of a mesh that is closest to a place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Closest {
    /// The triangle, by its number among those with an area.
    pub triangle: u32,
    /// The point.
    pub point: Vec3,
    /// Unit normal of the mesh there.
    pub normal: Vec3,
    /// Distance, negative on the side against the normals.
    pub distance: f32,
}

impl DistanceField {
    /// Makes the field of a mesh. Triangles without area are left out.
    ///
    /// # Errors
    /// Fails if an index does not exist, a point is not finite or no triangle has an area.
    pub fn new(points: &[[f32; 3]], triangles: &[[u32; 3]]) -> Result<Self> {
        if let Some(point) = points.iter().position(|point| !point.iter().all(|at| at.is_finite())) {
            return Err(Error::invalid("a coordinate is not finite").at(format!("point {point}")));
        }
        let missing = |corners: &[u32; 3]| corners.iter().any(|point| *point as usize >= points.len());
        if let Some(triangle) = triangles.iter().position(missing) {
            return Err(Error::invalid("a point does not exist").at(format!("triangle {triangle}")));
        }
        let at = |corners: &[u32; 3]| corners.map(|point| Vec3::from(points[point as usize]));
        let normal = |[a, b, c]: [Vec3; 3]| (b - a).cross(c - a).normalize_or_zero();
        let kept: Vec<&[u32; 3]> = triangles.iter().filter(|corners| normal(at(corners)) != Vec3::ZERO).collect();
        if kept.is_empty() {
            return Err(Error::invalid("no triangle of the surface has an area").advise("give it a surface"));
        }
        let normals = normals(points, &kept);
        let triangles: Vec<[Vec3; 3]> = kept.into_iter().map(at).collect();
        let mut order: Vec<u32> = (0..triangles.len() as u32).collect();
        let mut boxes = Vec::with_capacity(triangles.len());
        split(&triangles, &mut order, 0, &mut boxes);
        Ok(Self { triangles, order, boxes, normals })
    }

    /// Returns the box around the mesh.
    pub fn bounds(&self) -> [Vec3; 2] {
        [self.boxes[0].low, self.boxes[0].high]
    }

    /// Appends the boxes and triangles as a device reads them (`shaders/tissue/tissue_move.wgsl`) and returns the row where they
    /// begin. A box has two rows: its low and high corners, and behind them the row of its second child or first triangle, and
    /// how many triangles it has. A triangle has ten, in the order of the leaves: its corners, behind the first its number, and
    /// its seven normals. Floats are bits. Fails if there are too many rows.
    pub(crate) fn pack(&self, rows: &mut Vec<[u32; 4]>) -> Result<u32> {
        let root = rows.len();
        let triangles = root + 2 * self.boxes.len();
        if triangles + 10 * self.order.len() > u32::MAX as usize {
            return Err(Error::memory("the surface has too many triangles for a device").advise("use the processor"));
        }
        let row = |place: Vec3, last: u32| [place.x.to_bits(), place.y.to_bits(), place.z.to_bits(), last];
        for node in &self.boxes {
            let first = node.first as usize;
            let first = if node.count > 0 { triangles + 10 * first } else { root + 2 * first };
            rows.extend([row(node.low, first as u32), row(node.high, node.count)]);
        }
        for number in &self.order {
            let [a, b, c] = self.triangles[*number as usize];
            rows.extend([row(a, *number), row(b, 0), row(c, 0)]);
            rows.extend(self.normals[*number as usize].map(|normal| row(normal, 0)));
        }
        Ok(root as u32)
    }

    /// Returns the closest point. A triangle that is near, such as that of a neighbouring place, makes it faster.
    pub fn closest(&self, place: Vec3, near: Option<u32>) -> Closest {
        let mut best = (f32::INFINITY, 0u32, Vec3::ZERO, 0usize);
        let test = |best: &mut (f32, u32, Vec3, usize), triangle: u32| {
            let (point, feature) = closest_on(&self.triangles[triangle as usize], place);
            let square = point.distance_squared(place);
            // The lowest number among equals, so that the way through the tree does not matter.
            if square < best.0 || (square == best.0 && triangle < best.1) {
                *best = (square, triangle, point, feature);
            }
        };
        if let Some(near) = near.filter(|near| (*near as usize) < self.triangles.len()) {
            test(&mut best, near);
        }
        let mut stack = [0u32; 64];
        let mut depth = 1;
        while depth > 0 {
            depth -= 1;
            let at = stack[depth] as usize;
            let node = &self.boxes[at];
            if node.reach(place) > best.0 {
                continue;
            }
            if node.count > 0 {
                for place in node.first..node.first + node.count {
                    test(&mut best, self.order[place as usize]);
                }
                continue;
            }
            let (one, other) = (at as u32 + 1, node.first);
            let is_first = self.boxes[one as usize].reach(place) <= self.boxes[other as usize].reach(place);
            let (near, far) = if is_first { (one, other) } else { (other, one) };
            (stack[depth], stack[depth + 1]) = (far, near);
            depth += 2;
        }
        let (square, triangle, point, feature) = best;
        let normal = self.normals[triangle as usize][feature];
        let distance = square.sqrt();
        Closest {
            triangle,
            point,
            normal,
            distance: if normal.dot(place - point) < 0.0 { -distance } else { distance },
        }
    }
}

impl BoxNode {
    /// Returns the squared distance to a place.
    fn reach(&self, place: Vec3) -> f32 {
        place.clamp(self.low, self.high).distance_squared(place)
    }
}

/// Sorts the triangles of `order`, which begin at `first`, into a hierarchy. Halves keep the depth below 32.
fn split(triangles: &[[Vec3; 3]], order: &mut [u32], first: usize, boxes: &mut Vec<BoxNode>) {
    let corners = || order.iter().flat_map(|triangle| triangles[*triangle as usize]);
    let low = corners().fold(Vec3::INFINITY, Vec3::min);
    let high = corners().fold(Vec3::NEG_INFINITY, Vec3::max);
    let at = boxes.len();
    boxes.push(BoxNode { low, high, first: first as u32, count: order.len() as u32 });
    if order.len() <= LEAF {
        return;
    }
    let axis = (high - low).max_position();
    let centre = |triangle: u32| triangles[triangle as usize].iter().map(|corner| corner[axis]).sum::<f32>();
    let half = order.len() / 2;
    order.select_nth_unstable_by(half, |a, b| centre(*a).total_cmp(&centre(*b)).then(a.cmp(b)));
    let (lower, upper) = order.split_at_mut(half);
    split(triangles, lower, first, boxes);
    let second = boxes.len() as u32;
    split(triangles, upper, first + half, boxes);
    (boxes[at].first, boxes[at].count) = (second, 0);
}

/// Returns the normals of each triangle, its corners and its edges. Points at the same place count as one.
fn normals(points: &[[f32; 3]], triangles: &[&[u32; 3]]) -> Vec<[Vec3; 7]> {
    let mut first = HashMap::with_capacity(points.len());
    // Adding 0 makes −0 the same as 0.
    let key = |point: &[f32; 3]| point.map(|at| (at + 0.0).to_bits());
    let joined: Vec<u32> = (0u32..).zip(points).map(|(number, at)| *first.entry(key(at)).or_insert(number)).collect();
    let mut corners = vec![Vec3::ZERO; points.len()];
    let mut edges: HashMap<[u32; 2], Vec3> = HashMap::with_capacity(2 * triangles.len());
    let edge = |a: u32, b: u32| if a < b { [a, b] } else { [b, a] };
    let mut own = Vec::with_capacity(triangles.len());
    for triangle in triangles {
        let ids = triangle.map(|point| joined[point as usize]);
        let at = ids.map(|point| Vec3::from(points[point as usize]));
        let normal = (at[1] - at[0]).cross(at[2] - at[0]).normalize_or_zero();
        for corner in 0..3 {
            let sides = [1, 2].map(|side| at[(corner + side) % 3] - at[corner]);
            corners[ids[corner] as usize] += normal * sides[0].angle_between(sides[1]);
            *edges.entry(edge(ids[corner], ids[(corner + 1) % 3])).or_default() += normal;
        }
        own.push((ids, normal));
    }
    let all = own.into_iter().map(|(ids, normal)| {
        let unit = |sum: Vec3| sum.normalize_or(normal);
        let corner = |at: usize| unit(corners[ids[at] as usize]);
        let side = |at: usize| unit(edges.get(&edge(ids[at], ids[(at + 1) % 3])).copied().unwrap_or(normal));
        [normal, corner(0), corner(1), corner(2), side(0), side(1), side(2)]
    });
    all.collect()
}

/// Returns the closest point of a triangle and where it is: 0 inside, 1 to 3 a corner, 4 to 6 an edge (Ericson 2005,
/// Section 5.1.5).
fn closest_on([a, b, c]: &[Vec3; 3], place: Vec3) -> (Vec3, usize) {
    let (ab, ac, ap) = (*b - *a, *c - *a, place - *a);
    let (d1, d2) = (ab.dot(ap), ac.dot(ap));
    if d1 <= 0.0 && d2 <= 0.0 {
        return (*a, 1);
    }
    let bp = place - *b;
    let (d3, d4) = (ab.dot(bp), ac.dot(bp));
    if d3 >= 0.0 && d4 <= d3 {
        return (*b, 2);
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        return (*a + ab * (d1 / (d1 - d3)), 4);
    }
    let cp = place - *c;
    let (d5, d6) = (ab.dot(cp), ac.dot(cp));
    if d6 >= 0.0 && d5 <= d6 {
        return (*c, 3);
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        return (*a + ac * (d2 / (d2 - d6)), 6);
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0 {
        let share = (d4 - d3) / ((d4 - d3) + (d5 - d6));
        return (*b + (*c - *b) * share, 5);
    }
    let scale = 1.0 / (va + vb + vc);
    (*a + ab * (vb * scale) + ac * (vc * scale), 0)
}
