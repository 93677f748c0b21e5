//! Impostors: an agent of a few pixels is one quad with a picture of its model, in its pose, from nearly the direction it is
//! seen from.
//!
//! The picture is an orthographic one of 32 × 32 texels along one of 1,536 directions, on a square through the middle of the
//! pose. A texel is covered where triangles fill half of it, or reach into it and no texel beside it is covered: so thin limbs stay,
//! and covered texels have about the area of the surface. A place of the surface and the nearest covered texel, and any place of
//! a covered texel and the surface, are then apart in the picture by no more than the sum of the diagonal of a texel, the error of
//! the triangles that were drawn, and the radius times the angle between the direction of the picture and that of the view.
//! [`error`] is that sum. Depths are those of the square, off by the radius at most.

use std::collections::HashMap;
use std::f32::consts::{FRAC_PI_4, SQRT_2};
use std::sync::Arc;

use glam::{DVec3, Vec2, Vec3};
use relievo_core::{Context, Result};

use crate::crowd::{Crowd, Frame, PoseKey};
use crate::hierarchy::{CrowdModel, NONE};
use crate::skinning::{skin, skin_normals};

/// Texels along a side of a picture.
pub const SIDE: usize = 32;
/// Directions along a side of a face of the cube.
const ACROSS: u32 = 16;
/// The largest angle between a direction and that of its picture, radians: the corner of a cell in the middle of a face.
const ANGLE: f32 = SQRT_2 * FRAC_PI_4 / ACROSS as f32;
/// Places along a side of a texel at which it is tested whether a triangle fills it.
const SAMPLES: usize = 4;
/// Error of the triangles in a picture, in texels.
const FINE: f32 = 0.25;
/// Pictures that are kept; all are forgotten where there would be more.
const MAX: usize = 1 << 13;

/// What a picture shows at a texel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Texel {
    /// The cluster, [`NONE`] where there is nothing.
    pub cluster: u32,
    /// The material.
    pub material: u32,
    /// The normal in the space of the model, of length 1.
    pub normal: [f32; 3],
}

/// A picture of a model in a pose, on a square in the space of the model.
#[derive(Clone, Debug, PartialEq)]
pub struct Impostor {
    /// Its number among all that were made; a picture that is still there has the same number in later frames.
    pub number: u64,
    /// The model.
    pub model: u32,
    /// The middle of the square.
    pub center: Vec3,
    /// Directions to the right, up and towards the viewer.
    pub axes: [Vec3; 3],
    /// Half a side of the square, which is the radius of a sphere around the model.
    pub radius: f32,
    /// Texels, row after row from the lowest.
    pub texels: Vec<Texel>,
}

/// Pictures that were made for views.
#[derive(Debug, Default)]
pub struct Impostors {
    made: HashMap<(PoseKey, u32), Arc<Impostor>>,
    /// How many were ever made.
    count: u64,
}

/// Returns the error of an impostor, in units of the model: of what is in a sphere of `radius`, seen from a place that is
/// `near` before that sphere.
pub(crate) fn error(radius: f32, near: f32) -> f32 {
    let texel = 2.0 / SIDE as f32;
    // The sine of the angle under which the radius is seen is at most radius / near.
    let turned = ANGLE + 1.1 * radius / near.max(f32::MIN_POSITIVE);
    radius * (texel * (SQRT_2 + FINE) + turned)
}

impl Impostor {
    /// Returns the corners of a texel, counter-clockwise for the viewer.
    pub fn corners(&self, index: usize) -> [[f32; 3]; 4] {
        let [row, column] = [index / SIDE, index % SIDE];
        let at = |column: usize, row: usize| {
            let [x, y] = [column, row].map(|it| self.radius * (2.0 * it as f32 / SIDE as f32 - 1.0));
            (self.center + x * self.axes[0] + y * self.axes[1]).to_array()
        };
        [at(column, row), at(column + 1, row), at(column + 1, row + 1), at(column, row + 1)]
    }

    /// Returns the covered texels with their numbers.
    pub fn covered(&self) -> impl Iterator<Item = (usize, &Texel)> {
        self.texels.iter().enumerate().filter(|(_, texel)| texel.cluster != NONE)
    }
}

impl Impostors {
    /// Returns the pictures of the agents of a frame that are drawn as impostors, seen from `eye` at `time` seconds, in the order
    /// of the frame.
    ///
    /// # Errors
    /// As [`skin`].
    pub fn of_frame(
        &mut self,
        context: &Context,
        (crowd, frame, time): (&Crowd, &Frame, f64),
        eye: DVec3,
    ) -> Result<Vec<(u32, Arc<Impostor>)>> {
        self.of_agents(context, (crowd, &frame.impostors(), time), eye)
    }

    /// Returns the pictures of some agents, seen from `eye` at `time` seconds, in the same order.
    ///
    /// # Errors
    /// As [`skin`].
    pub fn of_agents(
        &mut self,
        context: &Context,
        (crowd, agents, time): (&Crowd, &[u32], f64),
        eye: DVec3,
    ) -> Result<Vec<(u32, Arc<Impostor>)>> {
        let keys: Vec<(u32, (PoseKey, u32))> = agents
            .iter()
            .map(|agent| {
                let found = &crowd.agents()[*agent as usize];
                let model = &crowd.models()[found.model as usize];
                let middle = 0.5 * (Vec3::from(model.low) + Vec3::from(model.high));
                let local = found.transform.inverse().transform_point3(eye) - middle.as_dvec3();
                (*agent, (crowd.clip_key(*agent, time), number(local.normalize_or(DVec3::Z).as_vec3())))
            })
            .collect();
        let mut missing: Vec<(PoseKey, u32)> =
            keys.iter().map(|(_, key)| *key).filter(|key| !self.made.contains_key(key)).collect();
        missing.sort_unstable();
        missing.dedup();
        if self.made.len() + missing.len() > MAX {
            self.made.clear();
            missing = keys.iter().map(|(_, key)| *key).collect();
            missing.sort_unstable();
            missing.dedup();
        }
        for alike in missing.chunk_by(|a, b| a.0 == b.0) {
            let key = alike[0].0;
            let model = &crowd.models()[key.model as usize];
            let pose = crowd.posed(&key);
            let points = skin(context, &model.character, &pose, model.blend)?;
            let normals = skin_normals(context, &model.character, &pose, model.blend)?;
            let first = self.count;
            let made = context.map(alike.len(), |at| {
                let own = picture(model, (&points, &normals), alike[at].1);
                Arc::new(Impostor { number: first + at as u64, model: key.model, ..own })
            });
            self.count += alike.len() as u64;
            self.made.extend(alike.iter().copied().zip(made));
        }
        Ok(keys.into_iter().map(|(agent, key)| (agent, Arc::clone(&self.made[&key]))).collect())
    }
}

/// Returns the number of the direction of a picture that is nearest to a direction.
fn number(direction: Vec3) -> u32 {
    let size = direction.abs();
    let axis = if size.x >= size.y && size.x >= size.z {
        0
    } else if size.y >= size.z {
        1
    } else {
        2
    };
    let main = direction[axis];
    let cell = |value: f32| {
        let along = (value / main.abs()).atan() / FRAC_PI_4;
        (((0.5 * (along + 1.0)) * ACROSS as f32) as u32).min(ACROSS - 1)
    };
    let face = 2 * axis as u32 + u32::from(main < 0.0);
    (face * ACROSS + cell(direction[(axis + 1) % 3])) * ACROSS + cell(direction[(axis + 2) % 3])
}

/// Returns the direction of a picture.
fn direction(number: u32) -> Vec3 {
    let (face, cells) = (number / (ACROSS * ACROSS), [number / ACROSS % ACROSS, number % ACROSS]);
    let axis = (face / 2) as usize;
    let [a, b] = cells.map(|cell| (FRAC_PI_4 * (2.0 * (cell as f32 + 0.5) / ACROSS as f32 - 1.0)).tan());
    let mut made = Vec3::ZERO;
    made[axis] = if face % 2 == 0 { 1.0 } else { -1.0 };
    (made[(axis + 1) % 3], made[(axis + 2) % 3]) = (a, b);
    made.normalize()
}

/// Draws the picture of a model in a pose for a direction.
fn picture(model: &CrowdModel, (points, normals): (&[[f32; 3]], &[[f32; 3]]), number: u32) -> Impostor {
    let (low, high) = points.iter().fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), point| {
        (low.min(Vec3::from(*point)), high.max(Vec3::from(*point)))
    });
    let (center, radius) = (0.5 * (low + high), (0.5 * (high - low).length()).max(f32::MIN_POSITIVE));
    let towards = direction(number);
    let right = towards.any_orthonormal_vector();
    let axes = [right, towards.cross(right), towards];
    let nothing = Texel { cluster: NONE, material: 0, normal: [0.0; 3] };
    let mut made = Impostor { number: 0, model: 0, center, axes, radius, texels: vec![nothing; SIDE * SIDE] };
    // Triangles at the middle of a texel come first: others in it are often narrow, and would have too large a share.
    let mut nearest = vec![(false, f32::NEG_INFINITY); SIDE * SIDE];
    let mut filled = vec![0u16; SIDE * SIDE];
    let scale = 0.5 * SIDE as f32 / radius;
    let place = |vertex: u32| {
        let from = Vec3::from(points[vertex as usize]) - center;
        let [x, y, z] = axes.map(|axis| axis.dot(from));
        Vec3::new(x * scale + 0.5 * SIDE as f32, y * scale + 0.5 * SIDE as f32, z)
    };
    for cluster in model.cut(FINE / scale) {
        let first = model.clusters[cluster as usize].first as usize;
        for (triangle, material) in model.triangles(cluster).iter().zip(&model.character.materials[first..]) {
            let corners = triangle.map(place);
            let own = triangle.map(|vertex| normals.get(vertex as usize).map_or(Vec3::ZERO, |it| Vec3::from(*it)));
            for Touched { texel, weights, has_middle, samples } in touched(&corners) {
                filled[texel] |= samples;
                let depth: f32 = corners.iter().zip(weights).map(|(corner, weight)| weight * corner.z).sum();
                if (has_middle, depth) > nearest[texel] {
                    nearest[texel] = (has_middle, depth);
                    let normal: Vec3 = own.into_iter().zip(weights).map(|(normal, weight)| weight * normal).sum();
                    let [a, b, c] = triangle.map(|vertex| Vec3::from(points[vertex as usize]));
                    let normal = normal.try_normalize().unwrap_or((b - a).cross(c - a).normalize_or(towards));
                    made.texels[texel] = Texel { cluster, material: *material, normal: normal.to_array() };
                }
            }
        }
    }
    uncover(&mut made.texels, &filled);
    made
}

/// Uncovers texels that are filled by less than half, unless none beside them is covered.
fn uncover(texels: &mut [Texel], filled: &[u16]) {
    let is_filled = |at: usize| filled[at].count_ones() as usize >= SAMPLES * SAMPLES / 2;
    let mut is_covered: Vec<bool> = (0..texels.len()).map(is_filled).collect();
    for at in 0..texels.len() {
        let [row, column] = [at / SIDE, at % SIDE];
        let mut beside = (row.saturating_sub(1)..(row + 2).min(SIDE))
            .flat_map(|row| (column.saturating_sub(1)..(column + 2).min(SIDE)).map(move |column| row * SIDE + column));
        is_covered[at] |= texels[at].cluster != NONE && !beside.any(|other| is_covered[other]);
        if !is_covered[at] {
            texels[at].cluster = NONE;
        }
    }
}

/// A texel that a triangle reaches into.
struct Touched {
    texel: usize,
    /// Weights of the triangle's corners near the middle of the texel.
    weights: [f32; 3],
    /// Whether the middle is in the triangle.
    has_middle: bool,
    /// A bit for each sample that is in the triangle.
    samples: u16,
}

/// Returns the texels that a triangle reaches into.
fn touched(corners: &[Vec3; 3]) -> impl Iterator<Item = Touched> {
    let flat = corners.map(|corner| corner.truncate());
    let low = flat[0].min(flat[1]).min(flat[2]).floor().max(Vec2::ZERO);
    let high = flat[0].max(flat[1]).max(flat[2]).floor().min(Vec2::splat(SIDE as f32 - 1.0));
    let rows = low.y as usize..(high.y + 1.0).max(0.0) as usize;
    let columns = low.x as usize..(high.x + 1.0).max(0.0) as usize;
    let texels = rows.flat_map(move |row| columns.clone().map(move |column| (row, column)));
    texels.filter_map(move |(row, column)| {
        let middle = Vec2::new(column as f32 + 0.5, row as f32 + 0.5);
        // The square and the triangle are apart only if an edge has them on its two sides.
        for at in 0..3 {
            let edge = flat[(at + 1) % 3] - flat[at];
            let across = edge.perp();
            let along = [0, 1, 2].map(|corner| across.dot(flat[corner] - middle));
            let reach = 0.5 * (across.x.abs() + across.y.abs());
            let least = along[0].min(along[1]).min(along[2]);
            let most = along[0].max(along[1]).max(along[2]);
            if least > reach || most < -reach {
                return None;
            }
        }
        let area = (flat[1] - flat[0]).perp_dot(flat[2] - flat[0]);
        let shares = |place: Vec2| {
            [(1, 2), (2, 0), (0, 1)].map(|(from, to)| {
                let share = (flat[from] - place).perp_dot(flat[to] - place) / area;
                if share.is_finite() { share } else { -1.0 }
            })
        };
        let has = |shares: [f32; 3]| shares.iter().all(|share| *share >= 0.0);
        let mut samples = 0;
        for sample in 0..SAMPLES * SAMPLES {
            let [x, y] = [sample % SAMPLES, sample / SAMPLES].map(|at| (at as f32 + 0.5) / SAMPLES as f32);
            samples |= u16::from(has(shares(Vec2::new(column as f32 + x, row as f32 + y)))) << sample;
        }
        let at_middle = shares(middle);
        let weights = at_middle.map(|share| share.max(0.0));
        let sum: f32 = weights.iter().sum();
        let weights = weights.map(|weight| if sum > 0.0 { weight / sum } else { 1.0 / 3.0 });
        Some(Touched { texel: row * SIDE + column, weights, has_middle: has(at_middle), samples })
    })
}
