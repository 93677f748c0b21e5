//! Contact of a model with itself, with Coulomb friction (McAdams et al. 2011, Section 6, without their penalty forces).
//!
//! A node of the outer surface that lies in an element is carried back to the shape at rest by the element's map. The signed
//! distance to the outer surface at rest has there the closest face, whose nodes give the face at present. Node and face
//! are moved apart along its normal, and their velocities lose what brings them together: the moves and impulses of both
//! sides cancel out, so that contact changes no momentum.

use std::collections::HashMap;

use glam::Vec3;
use relievo_core::{Context, Result};

use crate::block::Row;
use crate::distance::DistanceField;
use crate::hexahedron::{locate, trilinear};
use crate::model::{Lists, Model};
use crate::simulation::State;

/// Share of an edge by which nodes move before elements are sorted into cells anew.
const MARGIN: f32 = 0.2;

/// The outer surface of a model and the elements below it.
#[derive(Debug)]
pub(crate) struct SelfContact {
    friction: f32,
    /// The outer surface at rest, and the nodes of its triangles.
    field: DistanceField,
    triangles: Vec<[u32; 3]>,
    nodes: Vec<u32>,
    /// The nodes that share an element with each of `nodes`, in rising order. It does not touch their faces.
    rings: Lists<u32>,
    /// Elements with an outer face.
    elements: Vec<u32>,
    /// Edge of an element, in metres.
    edge: f32,
    /// Outer elements by the cells that their boxes touch, and where the nodes were then.
    cells: HashMap<[i32; 3], Vec<u32>>,
    sorted_at: Vec<Vec3>,
}

/// A node that is behind a face.
struct Touch {
    node: u32,
    corners: [u32; 3],
    weights: Vec3,
    normal: Vec3,
    depth: f32,
}

impl SelfContact {
    /// Prepares a model. Fails if its outer surface has no area.
    pub fn new(model: &Model, friction: f32) -> Result<Self> {
        let place = |node: u32| Vec3::from(model.nodes[node as usize]);
        let (mut triangles, mut elements, mut edges) = (Vec::new(), Vec::new(), 0f64);
        for (element, [a, b, c, d]) in model.outer_faces() {
            elements.push(element);
            edges += f64::from(place(a).distance(place(b)));
            triangles.extend([[a, b, c], [a, c, d]]);
        }
        let edge = (edges / elements.len().max(1) as f64) as f32;
        // The field leaves out triangles without area, and numbers the others.
        triangles
            .retain(|[a, b, c]| (place(*b) - place(*a)).cross(place(*c) - place(*a)).normalize_or_zero() != Vec3::ZERO);
        elements.dedup();
        let mut nodes = triangles.concat();
        nodes.sort_unstable();
        nodes.dedup();
        let mut around = vec![Vec::new(); nodes.len()];
        for corners in &model.elements {
            for node in corners {
                if let Ok(at) = nodes.binary_search(node) {
                    around[at].extend(corners);
                }
            }
        }
        let mut rings = Lists::default();
        for mut ring in around {
            ring.sort_unstable();
            ring.dedup();
            rings.push(ring);
        }
        Ok(Self {
            friction,
            field: DistanceField::new(&model.nodes, &triangles)?,
            triangles,
            nodes,
            rings,
            elements,
            edge,
            cells: HashMap::new(),
            sorted_at: Vec::new(),
        })
    }

    /// Moves nodes out of elements, and takes from velocities what brings them together.
    pub fn keep(&mut self, context: &Context, model: &Model, masses: &[Row], state: &mut State) {
        let place =
            |node: u32| Vec3::from(model.nodes[node as usize]) + Vec3::from_slice(&state.displacements[node as usize]);
        self.sort(model, &place);
        let found = context.map(self.nodes.len(), |at| self.touch(model, &place, at));
        for touch in found.into_iter().flatten() {
            touch.part(masses, state, self.friction);
        }
    }

    /// Sorts the outer elements into cells if nodes moved far since it was done last. Elements of a cell that do not
    /// matter do not change what is found.
    fn sort(&mut self, model: &Model, place: &impl Fn(u32) -> Vec3) {
        let margin = MARGIN * self.edge;
        let now: Vec<Vec3> = self.nodes.iter().map(|node| place(*node)).collect();
        let is_near = |(now, before): (&Vec3, &Vec3)| now.distance_squared(*before) < margin * margin;
        if self.sorted_at.len() == now.len() && now.iter().zip(&self.sorted_at).all(is_near) {
            return;
        }
        self.sorted_at = now;
        self.cells.clear();
        for element in &self.elements {
            let corners = model.elements[*element as usize].map(place);
            let low = corners.into_iter().fold(Vec3::INFINITY, Vec3::min) - margin;
            let high = corners.into_iter().fold(Vec3::NEG_INFINITY, Vec3::max) + margin;
            let (low, high) = (self.cell(low), self.cell(high));
            // An element that is drawn out over many cells is found too late rather than filling memory.
            if (0..3).any(|axis| high[axis].saturating_sub(low[axis]) > 64) {
                continue;
            }
            for x in low[0]..=high[0] {
                for y in low[1]..=high[1] {
                    for z in low[2]..=high[2] {
                        self.cells.entry([x, y, z]).or_default().push(*element);
                    }
                }
            }
        }
    }

    fn cell(&self, place: Vec3) -> [i32; 3] {
        (place / (2.0 * self.edge)).floor().to_array().map(|at| at as i32)
    }

    /// Finds the face that outer node `index` is behind.
    fn touch(&self, model: &Model, place: &impl Fn(u32) -> Vec3, index: usize) -> Option<Touch> {
        let (node, ring) = (self.nodes[index], self.rings.get(index));
        let at = place(node);
        for element in self.cells.get(&self.cell(at))? {
            let corners = model.elements[*element as usize];
            let moved = corners.map(place);
            let low = moved.into_iter().fold(Vec3::INFINITY, Vec3::min);
            let high = moved.into_iter().fold(Vec3::NEG_INFINITY, Vec3::max);
            if corners.contains(&node) || at.cmplt(low).any() || at.cmpgt(high).any() {
                continue;
            }
            let inside = locate(&moved.map(Vec3::as_dvec3), at.as_dvec3()).as_vec3();
            if inside.cmplt(Vec3::ZERO).any() || inside.cmpgt(Vec3::ONE).any() {
                continue;
            }
            let rest = corners.iter().zip(trilinear(inside.to_array()));
            let rest: Vec3 = rest.map(|(corner, share)| share * Vec3::from(model.nodes[*corner as usize])).sum();
            let closest = self.field.closest(rest, None);
            let corners = self.triangles[closest.triangle as usize];
            if closest.distance >= 0.0 || corners.iter().any(|corner| ring.binary_search(corner).is_ok()) {
                continue;
            }
            let weights = barycentric(corners.map(|corner| Vec3::from(model.nodes[corner as usize])), closest.point);
            let [a, b, c] = corners.map(place);
            let normal = (b - a).cross(c - a).try_normalize()?;
            let depth = (a * weights.x + b * weights.y + c * weights.z - at).dot(normal);
            if depth > 0.0 && depth < 2.0 * self.edge {
                return Some(Touch { node, corners, weights, normal, depth });
            }
        }
        None
    }
}

impl Touch {
    /// Moves node and face apart by the depth and stops their approach; friction stops them along at most as much.
    fn part(&self, masses: &[Row], state: &mut State, friction: f32) {
        let shares = [
            (self.node, 1.0),
            (self.corners[0], -self.weights.x),
            (self.corners[1], -self.weights.y),
            (self.corners[2], -self.weights.z),
        ];
        // How far node and face part along a direction for an impulse of 1.
        let yielding = |direction: Vec3| {
            let of = |(node, share): (u32, f32)| {
                let inverse = Vec3::from_slice(&masses[node as usize]);
                share * share * (direction * direction * inverse).element_sum()
            };
            shares.map(of).iter().sum::<f32>()
        };
        let along_normal = yielding(self.normal);
        if along_normal <= 0.0 {
            return;
        }
        let give = |rows: &mut [Row], impulse: Vec3| {
            for (node, share) in shares {
                let inverse = &masses[node as usize];
                (0..3).for_each(|axis| rows[node as usize][axis] += share * impulse[axis] * inverse[axis]);
            }
        };
        give(&mut state.displacements, self.normal * (self.depth / along_normal));
        let relative: Vec3 =
            shares.map(|(node, share)| share * Vec3::from_slice(&state.velocities[node as usize])).iter().sum();
        let into = relative.dot(self.normal);
        if into >= 0.0 {
            return;
        }
        let stop = -into / along_normal;
        let mut impulse = self.normal * stop;
        let along = relative - self.normal * into;
        if let Some(direction) = along.try_normalize() {
            let rubbed = (along.length() / yielding(direction).max(f32::MIN_POSITIVE)).min(friction * stop);
            impulse -= direction * rubbed;
        }
        give(&mut state.velocities, impulse);
    }
}

/// Returns the weights of the corners of a triangle at a point of it.
fn barycentric([a, b, c]: [Vec3; 3], point: Vec3) -> Vec3 {
    let normal = (b - a).cross(c - a);
    let area = normal.length_squared().max(f32::MIN_POSITIVE);
    let of = |from: Vec3, to: Vec3| (to - from).cross(point - from).dot(normal) / area;
    let (v, w) = (of(c, a).clamp(0.0, 1.0), of(a, b).clamp(0.0, 1.0));
    Vec3::new((1.0 - v - w).max(0.0), v, w)
}
