//! Lowers the distortion of a map with exact pins by projected Newton steps that never flip a triangle.
//!
//! The positions of pins are no unknowns: a pin that is not at its target yet moves along with each Newton step, as far as
//! the step can go without a flip. When no step gets further, the pins jump to their targets. Flipped triangles are turned
//! back with the regularised energy of Garanzha et al. 2021: at first by vertices near them alone, then by all of a small map,
//! or of one whose pins jumped and that is no trial.

use std::collections::HashMap;

use relievo_core::{Progress, Result};

use crate::map::energy::{Rest, Vec2};
use crate::map::factor::{PINNED, Pairs, System};

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
const MAX_MOVED_FACES: usize = 4096;

/// That of steps that follow a dragged pin or turn triangles back, after which others come.
const ROUGH: f64 = 1e-4;
/// That of the moves that a force at a dragged pin makes.
const HELD: f64 = 1e-3;

/// When to stop.
#[derive(Clone, Copy, Debug)]
pub struct Stop {
    /// Newton steps after the pins have arrived.
    pub steps: usize,
    /// The expected decrease, as a share of the energy, that is not worth another step.
    pub decrease: f64,
    /// The energy for each unit of area, 4 at an isometric map, that needs no step at all.
    pub enough: f64,
    /// The residual of the linear system of a step that pulls pins, as a share of that of no step.
    pub pulling: f64,
    /// That of a step that lowers the distortion. Maps of a surface before and after it is turned differ by about as much, since
    /// one may take a step of conjugate gradients more than the other.
    pub lowering: f64,
    /// Whether another map is made where this one folds: then no large map moves as a whole to turn triangles back.
    pub is_trial: bool,
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

    fn step(&mut self, direction: &Pairs, length: f64) {
        for (position, step) in self.positions.iter_mut().zip(direction) {
            position[0] += length * f64::from(step[0]);
            position[1] += length * f64::from(step[1]);
        }
    }

    /// The step at which the first triangle loses its area.
    fn first_flip(&self, direction: &Pairs) -> f64 {
        let mut first = f64::INFINITY;
        for face in self.faces {
            let [a, b, c] = face.map(|vertex| self.positions[vertex as usize]);
            let [u, v, w] = face.map(|vertex| direction[vertex as usize].map(f64::from));
            let (p, q) = (minus(b, a), minus(c, a));
            let (r, s) = (minus(v, u), minus(w, u));
            // Twice the area after a step of length t: constant + linear t + square t².
            let (constant, square) = (cross(p, q), cross(r, s));
            let linear = cross(p, s) + cross(r, q);
            first = first.min(smallest_root(square, linear, constant));
        }
        first
    }

    /// Computes the Newton direction at the current positions and returns energy and slope along it. There is no slope of
    /// pins on their way.
    fn direction(
        &self,
        system: &mut System,
        epsilon: f64,
        tolerance: f64,
        direction: &mut Pairs,
    ) -> Result<(f64, f64)> {
        direction.fill([0.0; 2]);
        let mut is_pulled = false;
        for (vertex, target) in self.pins {
            let way = minus(*target, self.positions[*vertex as usize]);
            is_pulled |= way != [0.0; 2];
            direction[*vertex as usize] = way.map(|value| value as f32);
        }
        let mut side = vec![[0.0_f32; 2]; system.free()];
        let mut energy = 0.0;
        system.clear();
        for (face, rest) in self.rest.iter().enumerate() {
            let found = rest.derivatives(self.corners(face), epsilon);
            energy += found.energy;
            let vertices = self.faces[face];
            system.add(vertices, &found.couplings);
            let rows = vertices.map(|vertex| system.row(vertex as usize));
            for (row, slopes) in rows.into_iter().zip(found.gradient).filter(|(row, _)| *row != PINNED) {
                let force = &mut side[row as usize];
                *force = [force[0] - slopes[0] as f32, force[1] - slopes[1] as f32];
            }
            for corner in (0..3).filter(|corner| is_pulled && rows[*corner] == PINNED) {
                let [x, y] = direction[vertices[corner] as usize].map(f64::from);
                let (after, before) = ((corner + 1) % 3, (corner + 2) % 3);
                let ([p, q, r, s], [a, b, c, d]) = (found.couplings[corner], found.couplings[before]);
                let forces = [(after, [p * x + r * y, q * x + s * y]), (before, [a * x + b * y, c * x + d * y])];
                for (other, [x, y]) in forces.into_iter().filter(|(other, _)| rows[*other] != PINNED) {
                    let force = &mut side[rows[other] as usize];
                    *force = [force[0] - x as f32, force[1] - y as f32];
                }
            }
        }
        system.prepare()?;
        let mut slope = -system.solve(&mut side, tolerance);
        if let Some(hook) = self.hook {
            slope += self.hold(hook, system, &mut side);
        }
        for (vertex, step) in direction.iter_mut().enumerate() {
            let row = system.row(vertex);
            if row != PINNED {
                *step = side[row as usize];
            }
        }
        Ok((energy, slope))
    }

    /// Changes a Newton step so that the point of the hook moves to its target: adds the least change, in the metric of the
    /// matrix, that does so. Returns the change of the slope.
    fn hold(&self, hook: Hook, system: &mut System, side: &mut Pairs) -> f64 {
        let rows = self.faces[hook.face].map(|vertex| system.row(vertex as usize));
        let free = || rows.into_iter().zip(hook.weights).filter(|(row, _)| *row != PINNED);
        let point = |values: &Pairs, axis: usize| -> f64 {
            free().map(|(row, weight)| weight * f64::from(values[row as usize][axis])).sum()
        };
        let mut columns = [vec![[0.0; 2]; side.len()], vec![[0.0; 2]; side.len()]];
        for (axis, column) in columns.iter_mut().enumerate() {
            for (row, weight) in free() {
                column[row as usize][axis] = weight as f32;
            }
            system.solve(column, HELD);
        }
        let (way, moved) = (minus(hook.target, self.hooked(hook)), [point(side, 0), point(side, 1)]);
        let missing = minus(way, moved);
        let [[a, b], [c, d]] = [0, 1].map(|row| [0, 1].map(|column| point(&columns[column], row)));
        let determinant = a * d - b * c;
        if !(determinant > 0.0) {
            // Every vertex of the face is pinned.
            return 0.0;
        }
        let shares = [(d * missing[0] - b * missing[1]) / determinant, (a * missing[1] - c * missing[0]) / determinant];
        for (column, share) in columns.iter().zip(shares) {
            for (step, change) in side.iter_mut().zip(column) {
                *step = [0, 1].map(|axis| step[axis] + (share * f64::from(change[axis])) as f32);
            }
        }
        // The forces along a column are what the step without it moves the point by, as the matrix is symmetric.
        -(shares[0] * moved[0] + shares[1] * moved[1])
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
        let mut direction = vec![[0.0_f32; 2]; self.positions.len()];
        let mut left = steps;
        for _ in 0..PULLING_STEPS {
            let is_held = crate::map::energy::distance(self.hooked(hook), hook.target) <= tolerance;
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
        let mut direction = vec![[0.0_f32; 2]; self.positions.len()];
        // New faces fold where they are: they are turned back before pins pull.
        let mut is_valid = self.worst().1 > 0.0 || self.untangle_around(progress)?;
        let mut pulls = 0;
        while is_valid && !self.is_arrived() {
            progress.step(0.0, "pulling pins")?;
            self.direction(system, 0.0, stop.pulling, &mut direction)?;
            let length = (SAFE * self.first_flip(&direction)).min(1.0);
            self.step(&direction, length);
            system.renew();
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
            let has_jumped = !self.is_arrived();
            self.arrive();
            let is_mended = has_jumped && self.untangle_around(progress)?;
            // Pins that jump may bend the whole map.
            let is_bent = has_jumped && !stop.is_trial;
            if !is_mended && !is_bent && self.faces.len() > MAX_MOVED_FACES {
                return Ok(Relaxed::Flipped(self.worst().0));
            }
            if let Relaxed::Flipped(face) = self.untangle(system, &mut direction, progress)? {
                return Ok(Relaxed::Flipped(face));
            }
        }
        let mut before = None;
        for step in 0..stop.steps {
            progress.step(step as f32 / stop.steps as f32, "lowering the distortion")?;
            let (energy, slope) = self.direction(system, 0.0, stop.lowering, &mut direction)?;
            let longest = (SAFE * self.first_flip(&direction)).min(1.0);
            if !self.search(&direction, longest, energy, slope, 0.0) {
                break;
            }
            // The next decrease is at most as large a share of this one as this one is of the last one.
            let share = before.map_or(1.0, |before: f64| (slope / before).min(1.0));
            if -slope * share <= stop.decrease * energy {
                break;
            }
            before = Some(slope);
        }
        Ok(Relaxed::Valid)
    }

    /// Turns flipped triangles back by the vertices around them alone. Returns whether none is flipped any more; otherwise
    /// nothing has moved.
    fn untangle_around(&mut self, progress: &mut dyn Progress) -> Result<bool> {
        RINGS.into_iter().try_fold(false, |is_mended, rings| Ok(is_mended || self.untangle_near(rings, progress)?))
    }

    /// As [`Self::untangle_around`], by vertices within some rings of them.
    fn untangle_near(&mut self, rings: usize, progress: &mut dyn Progress) -> Result<bool> {
        let mut is_near = vec![false; self.positions.len()];
        for (face, rest) in self.rest.iter().enumerate() {
            if rest.determinant(self.corners(face)) <= 0.0 {
                self.faces[face].iter().for_each(|vertex| is_near[*vertex as usize] = true);
            }
        }
        spread(self.faces, &mut is_near, rings);
        for (vertex, _) in self.pins {
            is_near[*vertex as usize] = false;
        }
        let Some(mut part) = Part::new(self.faces, self.positions, &is_near, |face| self.rest[face])? else {
            return Ok(false);
        };
        if 2 * part.faces.len() > self.faces.len() {
            return Ok(false);
        }
        let mut direction = vec![[0.0; 2]; part.vertices.len()];
        let (mut map, system) = part.map();
        if map.untangle(system, &mut direction, progress)? != Relaxed::Valid {
            return Ok(false);
        }
        part.move_back(self.positions);
        Ok(self.worst().1 > 0.0)
    }

    /// Turns flipped triangles back.
    fn untangle(&mut self, system: &mut System, direction: &mut Pairs, progress: &mut dyn Progress) -> Result<Relaxed> {
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
    fn search(&mut self, direction: &Pairs, longest: f64, energy: f64, slope: f64, epsilon: f64) -> bool {
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

/// Adds the vertices within some rings of faces.
pub fn spread(faces: &[[u32; 3]], is_near: &mut [bool], rings: usize) {
    for _ in 0..rings {
        let before = is_near.to_vec();
        for face in faces.iter().filter(|face| face.iter().any(|vertex| before[*vertex as usize])) {
            face.iter().for_each(|vertex| is_near[*vertex as usize] = true);
        }
    }
}

/// The faces of a map around its free vertices, as a map of its own that holds all other vertices.
pub struct Part {
    vertices: Vec<u32>,
    faces: Vec<[u32; 3]>,
    rest: Vec<Rest>,
    positions: Vec<Vec2>,
    held: Vec<(u32, Vec2)>,
    system: System,
}

impl Part {
    /// Makes the part of a map whose faces have the shapes that `rest` returns. There is none without free vertices.
    ///
    /// # Errors
    /// Memory does not suffice.
    pub fn new(
        faces: &[[u32; 3]],
        positions: &[Vec2],
        is_free: &[bool],
        rest: impl Fn(usize) -> Rest,
    ) -> Result<Option<Self>> {
        let is_near = |face: &usize| faces[*face].iter().any(|vertex| is_free[*vertex as usize]);
        let near: Vec<usize> = (0..faces.len()).filter(is_near).collect();
        if near.is_empty() {
            return Ok(None);
        }
        let mut number = HashMap::new();
        let mut vertices = Vec::new();
        let mut local = |vertex: u32| {
            *number.entry(vertex).or_insert_with(|| {
                vertices.push(vertex);
                vertices.len() as u32 - 1
            })
        };
        let faces: Vec<[u32; 3]> = near.iter().map(|face| faces[*face].map(&mut local)).collect();
        let positions: Vec<Vec2> = vertices.iter().map(|vertex| positions[*vertex as usize]).collect();
        let is_held: Vec<bool> = vertices.iter().map(|vertex| !is_free[*vertex as usize]).collect();
        let held = (0..).zip(&positions).filter(|(vertex, _)| is_held[*vertex as usize]);
        let held = held.map(|(vertex, place)| (vertex, *place)).collect();
        let system = System::new(vertices.len(), &faces, &is_held)?;
        Ok(Some(Self { vertices, faces, rest: near.into_iter().map(rest).collect(), positions, held, system }))
    }

    fn map(&mut self) -> (Map<'_>, &mut System) {
        let Self { faces, rest, positions, held, system, .. } = self;
        (Map { faces, rest, positions, pins: held, hook: None }, system)
    }

    /// Lowers the distortion, as [`Map::relax`] does.
    ///
    /// # Errors
    /// As [`Map::relax`].
    pub fn relax(&mut self, stop: Stop, progress: &mut dyn Progress) -> Result<Relaxed> {
        let (mut map, system) = self.map();
        map.relax(system, stop, progress)
    }

    /// Moves the vertices of the map that the part was taken out of.
    pub fn move_back(&self, positions: &mut [Vec2]) {
        for (vertex, position) in self.vertices.iter().zip(&self.positions) {
            positions[*vertex as usize] = *position;
        }
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
