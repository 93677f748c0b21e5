//! Lowers the distortion of a map with exact pins by projected Newton steps that never flip a triangle.
//!
//! The positions of pins are no unknowns: a pin that is not at its target yet moves along with each Newton step, as far as
//! the step can go without a flip. When no step gets further, the pins jump to their targets, and the flipped triangles are
//! turned back with the regularised energy of Garanzha et al. 2021: at first by vertices near them alone, then by all of a
//! small map, or of one whose pins jumped.

use std::collections::HashMap;

use relievo_core::{Error, Progress, Result};

use crate::energy::{Rest, Vec2};
use crate::factor::{PINNED, System};

/// The share of the way to the first flip that a step may go.
const SAFE: f64 = 0.9;
/// The shortest step that counts as progress of the pins.
const STALLED: f64 = 0.02;
/// Steps that untangling may take.
const UNTANGLING_STEPS: usize = 60;
/// Steps that pins may take to their targets.
const PULLING_STEPS: usize = 40;
/// Rings around flipped triangles that may move to turn them back, before the whole map moves.
const RINGS: [usize; 2] = [5, 15];
/// Faces of a map that moves as a whole to turn back triangles that its pins did not flip.
const FEW: usize = 4096;

/// The residual of the linear system of a step, as a share of that of no step. Maps of a surface before and after it is turned
/// differ by about as much, since one may take a step of conjugate gradients more than the other.
const TOLERANCE: f64 = 1e-5;
/// That of steps that follow a dragged pin or turn triangles back, after which others come.
const ROUGH: f64 = 1e-4;

/// When to stop.
#[derive(Clone, Copy, Debug)]
pub struct Stop {
    /// Newton steps after the pins have arrived.
    pub steps: usize,
    /// The expected decrease, as a share of the energy, that is not worth another step.
    pub decrease: f64,
    /// The energy for each unit of area, 4 at an isometric map, that needs no step at all.
    pub enough: f64,
}

/// The outcome of a relaxation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Relaxed {
    /// No triangle is flipped, and every pin is at its target.
    Valid,
    /// This face is still flipped.
    Flipped(usize),
}

/// A pin within a face, where no vertex is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hook {
    /// The face of the map.
    pub face: usize,
    /// The weights of its three vertices.
    pub weights: [f64; 3],
    /// Where the point belongs in the plane.
    pub target: Vec2,
}

/// A map of triangles into the plane with its pins.
pub struct Map<'a> {
    /// Vertices of the triangles.
    pub faces: &'a [[u32; 3]],
    /// Flat shapes of the triangles.
    pub rest: &'a [Rest],
    /// Positions in the plane.
    pub positions: &'a mut [Vec2],
    /// Vertices that are no unknowns, with their targets.
    pub pins: &'a [(u32, Vec2)],
    /// A pin that each Newton step brings to its target, as a linear constraint of the step.
    pub hook: Option<Hook>,
}

impl Map<'_> {
    fn corners(&self, face: usize) -> [Vec2; 3] {
        self.faces[face].map(|vertex| self.positions[vertex as usize])
    }

    /// Returns whether the pins are at their targets, no triangle is flipped and the mean energy is at most `enough`.
    pub fn is_good(&self, enough: f64) -> bool {
        let area: f64 = self.rest.iter().map(Rest::area).sum();
        self.is_arrived() && self.energy(0.0) <= enough * area
    }

    fn energy(&self, epsilon: f64) -> f64 {
        let mut sum = 0.0;
        for (face, rest) in self.rest.iter().enumerate() {
            sum += rest.energy(self.corners(face), epsilon);
            if sum == f64::INFINITY {
                break;
            }
        }
        sum
    }

    /// The face of the smallest determinant, and that.
    fn worst(&self) -> (usize, f64) {
        let determinants =
            self.rest.iter().enumerate().map(|(face, rest)| (face, rest.determinant(self.corners(face))));
        determinants.fold((0, f64::INFINITY), |worst, other| if other.1 < worst.1 { other } else { worst })
    }

    fn step(&mut self, direction: &[Vec2], length: f64) {
        for (position, step) in self.positions.iter_mut().zip(direction) {
            position[0] += length * step[0];
            position[1] += length * step[1];
        }
    }

    /// The step at which the first triangle loses its area.
    fn first_flip(&self, direction: &[Vec2]) -> f64 {
        let mut first = f64::INFINITY;
        for face in self.faces {
            let [a, b, c] = face.map(|vertex| self.positions[vertex as usize]);
            let [u, v, w] = face.map(|vertex| direction[vertex as usize]);
            let (p, q) = (minus(b, a), minus(c, a));
            let (r, s) = (minus(v, u), minus(w, u));
            // Twice the area after a step of length t: constant + linear t + square t².
            let (constant, square) = (cross(p, q), cross(r, s));
            let linear = cross(p, s) + cross(r, q);
            first = first.min(smallest_root(square, linear, constant));
        }
        first
    }

    /// Computes the Newton direction at the current positions and returns energy and slope along it.
    fn direction(
        &self,
        system: &mut System,
        epsilon: f64,
        tolerance: f64,
        direction: &mut [Vec2],
    ) -> Result<(f64, f64)> {
        for step in direction.iter_mut() {
            *step = [0.0; 2];
        }
        for (vertex, target) in self.pins {
            direction[*vertex as usize] = minus(*target, self.positions[*vertex as usize]);
        }
        let mut side = vec![0.0; system.unknowns()];
        let mut gradient = vec![0.0; system.unknowns()];
        let mut energy = 0.0;
        let area = self.rest.iter().map(Rest::area).sum::<f64>();
        // Rotations of an isometric map cost nothing to second order; the shift keeps the matrix definite.
        system.clear(1e-7 * area / self.rest.len().max(1) as f64 + 1e-9);
        for (face, rest) in self.rest.iter().enumerate() {
            let found = rest.derivatives(self.corners(face), epsilon);
            energy += found.energy;
            let vertices = self.faces[face];
            system.add(vertices, &found.hessian);
            let moves = vertices.map(|vertex| direction[vertex as usize]);
            let rows = vertices.map(|vertex| system.row(vertex as usize));
            let moved = (0..3).filter(|corner| rows[*corner] == PINNED && moves[*corner] != [0.0; 2]);
            let moved: u32 = moved.map(|corner| 1 << corner).sum();
            for corner in 0..3 {
                if rows[corner] == PINNED {
                    continue;
                }
                for part in 0..2 {
                    let row = 2 * rows[corner] as usize + part;
                    gradient[row] += found.gradient[2 * corner + part];
                    for other in (0..3).filter(|other| moved & 1 << other != 0) {
                        let entries = &found.hessian[2 * corner + part][2 * other..];
                        side[row] -= entries[0] * moves[other][0] + entries[1] * moves[other][1];
                    }
                }
            }
        }
        for (side, gradient) in side.iter_mut().zip(&gradient) {
            *side -= gradient;
        }
        system.factorise()?;
        system.solve(&mut side, tolerance);
        if let Some(hook) = self.hook {
            self.hold(hook, system, &mut side);
        }
        let slope = side.iter().zip(&gradient).map(|(step, gradient)| step * gradient).sum();
        for (vertex, step) in direction.iter_mut().enumerate() {
            let row = system.row(vertex);
            if row != PINNED {
                *step = [side[2 * row as usize], side[2 * row as usize + 1]];
            }
        }
        Ok((energy, slope))
    }

    /// Changes a Newton step so that the point of the hook moves to its target: adds the least change, in the metric of the
    /// matrix, that does so.
    fn hold(&self, hook: Hook, system: &mut System, side: &mut [f64]) {
        let rows = self.faces[hook.face].map(|vertex| system.row(vertex as usize));
        let free = || rows.into_iter().zip(hook.weights).filter(|(row, _)| *row != PINNED);
        let point = |values: &[f64], axis: usize| -> f64 {
            free().map(|(row, weight)| weight * values[2 * row as usize + axis]).sum()
        };
        let mut columns = [vec![0.0; side.len()], vec![0.0; side.len()]];
        for (axis, column) in columns.iter_mut().enumerate() {
            for (row, weight) in free() {
                column[2 * row as usize + axis] = weight;
            }
            system.solve(column, ROUGH);
        }
        let way = minus(hook.target, self.hooked(hook));
        let missing = [way[0] - point(side, 0), way[1] - point(side, 1)];
        let [[a, b], [c, d]] = [0, 1].map(|row| [0, 1].map(|column| point(&columns[column], row)));
        let determinant = a * d - b * c;
        if determinant <= 0.0 {
            // Every vertex of the face is pinned.
            return;
        }
        let shares = [(d * missing[0] - b * missing[1]) / determinant, (a * missing[1] - c * missing[0]) / determinant];
        for (column, share) in columns.iter().zip(shares) {
            for (step, change) in side.iter_mut().zip(column) {
                *step += share * change;
            }
        }
    }

    /// Where the point of the hook is in the plane.
    fn hooked(&self, hook: Hook) -> Vec2 {
        let corners = self.corners(hook.face);
        std::array::from_fn(|axis| (0..3).map(|corner| hook.weights[corner] * corners[corner][axis]).sum())
    }

    /// Brings the point of the hook to its target, and then lowers the distortion by some steps. The other pins are at their
    /// targets. Returns whether the point is within `tolerance` of its target.
    ///
    /// # Errors
    /// The map degenerates, or memory does not suffice.
    pub fn follow(&mut self, system: &mut System, steps: usize, tolerance: f64) -> Result<bool> {
        let Some(hook) = self.hook else { return Ok(true) };
        let mut direction = vec![[0.0; 2]; self.positions.len()];
        let mut left = steps;
        for _ in 0..PULLING_STEPS {
            let is_held = crate::energy::distance(self.hooked(hook), hook.target) <= tolerance;
            if is_held && left == 0 {
                return Ok(true);
            }
            let (energy, slope) = self.direction(system, 0.0, ROUGH, &mut direction)?;
            let longest = (SAFE * self.first_flip(&direction)).min(1.0);
            if is_held {
                left -= 1;
                if !self.search(&direction, longest, energy, slope, 0.0) {
                    return Ok(true);
                }
            } else if longest < STALLED {
                return Ok(false);
            } else {
                self.step(&direction, longest);
            }
        }
        Ok(false)
    }

    fn is_arrived(&self) -> bool {
        self.pins.iter().all(|(vertex, target)| self.positions[*vertex as usize] == *target)
    }

    fn arrive(&mut self) {
        for (vertex, target) in self.pins {
            self.positions[*vertex as usize] = *target;
        }
    }

    /// Moves pins to their targets and lowers the distortion.
    ///
    /// # Errors
    /// The caller cancels, or memory does not suffice.
    pub fn relax(&mut self, system: &mut System, stop: Stop, progress: &mut dyn Progress) -> Result<Relaxed> {
        let mut direction = vec![[0.0; 2]; self.positions.len()];
        let mut is_valid = self.worst().1 > 0.0;
        let mut pulls = 0;
        while is_valid && !self.is_arrived() {
            progress.step(0.0, "pulling pins")?;
            self.direction(system, 0.0, TOLERANCE, &mut direction)?;
            let length = (SAFE * self.first_flip(&direction)).min(1.0);
            self.step(&direction, length);
            if length == 1.0 {
                self.arrive();
            }
            pulls += 1;
            is_valid = self.worst().1 > 0.0;
            if length < STALLED || pulls == PULLING_STEPS {
                break;
            }
        }
        if !is_valid || !self.is_arrived() {
            // Pins that jump may bend the whole map; new faces fold where they are.
            let has_jumped = !self.is_arrived();
            self.arrive();
            let is_mended = RINGS.into_iter().try_fold(false, |is_mended, rings| {
                Ok::<bool, Error>(is_mended || self.untangle_near(rings, progress)?)
            })?;
            if !is_mended && !has_jumped && self.faces.len() > FEW {
                return Ok(Relaxed::Flipped(self.worst().0));
            }
            if let Relaxed::Flipped(face) = self.untangle(system, &mut direction, progress)? {
                return Ok(Relaxed::Flipped(face));
            }
        }
        for step in 0..stop.steps {
            progress.step(step as f32 / stop.steps as f32, "lowering the distortion")?;
            let (energy, slope) = self.direction(system, 0.0, TOLERANCE, &mut direction)?;
            if -slope <= stop.decrease * energy {
                break;
            }
            let longest = (SAFE * self.first_flip(&direction)).min(1.0);
            if !self.search(&direction, longest, energy, slope, 0.0) {
                break;
            }
        }
        Ok(Relaxed::Valid)
    }

    /// Turns flipped triangles back by moving only vertices within some rings of them. Returns whether none is flipped any
    /// more; otherwise nothing has moved.
    fn untangle_near(&mut self, rings: usize, progress: &mut dyn Progress) -> Result<bool> {
        let mut is_near = vec![false; self.positions.len()];
        for (face, rest) in self.rest.iter().enumerate() {
            if rest.determinant(self.corners(face)) <= 0.0 {
                self.faces[face].iter().for_each(|vertex| is_near[*vertex as usize] = true);
            }
        }
        for _ in 0..rings {
            let before = is_near.clone();
            for face in self.faces.iter().filter(|face| face.iter().any(|vertex| before[*vertex as usize])) {
                face.iter().for_each(|vertex| is_near[*vertex as usize] = true);
            }
        }
        let mut is_free = is_near;
        for (vertex, _) in self.pins {
            is_free[*vertex as usize] = false;
        }
        let near: Vec<usize> = (0..self.faces.len())
            .filter(|face| self.faces[*face].iter().any(|vertex| is_free[*vertex as usize]))
            .collect();
        if near.is_empty() || 2 * near.len() > self.faces.len() {
            return Ok(false);
        }
        let mut number = HashMap::new();
        let mut vertices = Vec::new();
        let faces: Vec<[u32; 3]> = near
            .iter()
            .map(|face| {
                self.faces[*face].map(|vertex| {
                    *number.entry(vertex).or_insert_with(|| {
                        vertices.push(vertex as usize);
                        vertices.len() as u32 - 1
                    })
                })
            })
            .collect();
        let rest: Vec<Rest> = near.iter().map(|face| self.rest[*face]).collect();
        let mut positions: Vec<Vec2> = vertices.iter().map(|vertex| self.positions[*vertex]).collect();
        let is_held: Vec<bool> = vertices.iter().map(|vertex| !is_free[*vertex]).collect();
        let held = (0..).zip(&positions).filter(|(vertex, _)| is_held[*vertex as usize]);
        let pins: Vec<(u32, Vec2)> = held.map(|(vertex, place)| (vertex, *place)).collect();
        let mut system = System::new(vertices.len(), &faces, &is_held)?;
        let mut direction = vec![[0.0; 2]; vertices.len()];
        let mut map = Map { faces: &faces, rest: &rest, positions: &mut positions, pins: &pins, hook: None };
        if map.untangle(&mut system, &mut direction, progress)? != Relaxed::Valid {
            return Ok(false);
        }
        for (vertex, position) in vertices.iter().zip(&positions) {
            self.positions[*vertex] = *position;
        }
        Ok(self.worst().1 > 0.0)
    }

    /// Turns flipped triangles back.
    fn untangle(
        &mut self,
        system: &mut System,
        direction: &mut [Vec2],
        progress: &mut dyn Progress,
    ) -> Result<Relaxed> {
        let (_, smallest) = self.worst();
        if smallest > 0.0 {
            return Ok(Relaxed::Valid);
        }
        let mut epsilon = (1e-6 + 0.04 * smallest * smallest).sqrt();
        for step in 0..UNTANGLING_STEPS {
            progress.step(step as f32 / UNTANGLING_STEPS as f32, "turning flipped triangles back")?;
            let (energy, slope) = self.direction(system, epsilon, ROUGH, direction)?;
            let is_lower = self.search(direction, 1.0, energy, slope, epsilon);
            let (_, smallest) = self.worst();
            if smallest > 0.0 {
                return Ok(Relaxed::Valid);
            }
            // The barrier grows steeper once the energy has settled.
            let decrease = if is_lower { 1.0 - self.energy(epsilon) / energy } else { 0.0 };
            if decrease < 0.05 {
                let root = smallest.hypot(epsilon);
                epsilon *= 1.0 - decrease.max(0.5) * root / (smallest.abs() + root);
            }
            if epsilon < 1e-7 {
                break;
            }
        }
        Ok(Relaxed::Flipped(self.worst().0))
    }

    /// Steps along a direction of descent until the energy decreases enough (Armijo 1966). Returns whether it did.
    fn search(&mut self, direction: &[Vec2], longest: f64, energy: f64, slope: f64, epsilon: f64) -> bool {
        let mut length = longest;
        self.step(direction, length);
        for _ in 0..40 {
            if self.energy(epsilon) <= energy + 1e-4 * length * slope {
                return true;
            }
            self.step(direction, -0.5 * length);
            length *= 0.5;
        }
        self.step(direction, -length);
        false
    }
}

fn minus(a: Vec2, b: Vec2) -> Vec2 {
    [a[0] - b[0], a[1] - b[1]]
}

fn cross(a: Vec2, b: Vec2) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}

/// The smallest positive root of `square t² + linear t + constant`, or infinity.
fn smallest_root(square: f64, linear: f64, constant: f64) -> f64 {
    if constant <= 0.0 {
        return if linear < 0.0 || (linear == 0.0 && square <= 0.0) { 0.0 } else { f64::INFINITY };
    }
    let discriminant = linear * linear - 4.0 * square * constant;
    if discriminant < 0.0 || (linear >= 0.0 && square >= 0.0) {
        return f64::INFINITY;
    }
    // The form without cancellation: both roots from the sum of equal signs.
    let sum = -0.5 * (linear + discriminant.sqrt().copysign(linear));
    let roots = [sum / square, constant / sum];
    roots.into_iter().filter(|root| *root > 0.0).fold(f64::INFINITY, f64::min)
}
