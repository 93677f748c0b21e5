//! Growth of the patch until it covers the sticker (the paper's Section 5).
//!
//! The paper maps the patch conformally and warps the image region onto it. Here the patch is mapped into the image with
//! its pins exact, so that the region stays what it is and cannot overlap itself: no warp and no groups of influence are
//! needed. Rounds of growth and relaxation alternate until no boundary edge with a face beyond touches the region. A round
//! whose faces cannot be mapped without flips is undone and made again with fewer rings, and at last with the faces only
//! that lie upright from the start. No face is added where another part of the patch lies in the plane already, so that no
//! part of the image appears twice. Where two parts of the boundary meet on the surface, as behind a handle, the faces
//! between them are added last, along a seam.

use std::collections::HashSet;
use std::ops::Range;

use relievo_core::{Error, Progress, Result};

use crate::artwork::outline::Outline;
use crate::map::energy::{Rest, Vec2, distance};
use crate::map::factor::System;
use crate::map::front::Faces;
use crate::map::patch::Patch;
use crate::map::region::{is_covered, once};
use crate::map::relax::{Map, Part, Relaxed, Stop, spread};
use crate::map::seed::Seed;
use crate::map::turns::turned_twice;
use crate::pins::name;

/// Rounds after which growth gives up: the map does not settle.
const ROUNDS: usize = 240;
/// Passes of removal, relaxation and growth at the end.
const PASSES: usize = 4;
/// Rings of faces that a round adds at most.
const RINGS: u32 = 6;
/// How far from where its neighbour says a pin may be attached to a sticker that overlaps itself, as a share of the way to
/// that neighbour.
const ASTRAY: f64 = 0.75;
/// The largest change of the scale of a free patch, which comes from its first pin and the neighbours of that pin.
const LARGER: f64 = 2.0;
/// How much more energy a patch may have once its seams are closed.
const WORSE: f64 = 1.05;

/// When to stop while the patch grows.
const ROUGH: Stop = Stop { steps: 8, decrease: 0.02, enough: 4.05, pulling: 1e-4, lowering: 1e-3, is_trial: false };
/// As [`ROUGH`], after pins pulled: what they bend beside them is a small share of the energy of a patch, and fronts go on from
/// there.
const PULLED: Stop = Stop { decrease: 2e-3, ..ROUGH };
/// How much more energy than the mean one, for each unit of area, a new face may have without a relaxation.
const DISTORTED: f64 = 2.0;
/// New faces of a patch of this many times their number are relaxed with those around them alone, and not at all at the end.
const LOCAL_RATIO: usize = 64;
/// Rings around new faces that move to lower the distortion of these.
const NEAR: usize = 3;

/// Why a patch cannot cover a sticker.
#[derive(Debug)]
pub enum Fault {
    /// Triangles near this pin stay flipped.
    Folded(usize),
    /// The patch does not reach this pin.
    Unreached(usize),
    /// As [`Fault::Folded`], and the paths between the pins cross: the error says where.
    Crossed(usize, Error),
    /// Anything else.
    Other(Error),
}

impl From<Error> for Fault {
    fn from(error: Error) -> Self {
        Self::Other(error)
    }
}

/// The result of growth.
pub type Grown<T> = std::result::Result<T, Fault>;

/// What is wrong with a pin at which triangles stay flipped.
pub const FOLDED: &str = "no map without folds was found: the sticker folds near it";
/// What is wrong with a pin that the patch does not reach.
pub const UNREACHED: &str = "the patch does not reach its place on the surface";

impl Fault {
    /// Turns the fault into an error that names the pin.
    pub fn into_error(self) -> Error {
        let (pin, what) = match self {
            Self::Other(error) | Self::Crossed(_, error) => return error,
            Self::Folded(pin) => (pin, FOLDED),
            Self::Unreached(pin) => (pin, UNREACHED),
        };
        Error::invalid(what).at(name(pin)).advise("move it towards the places of the other pins, or remove it")
    }
}

/// What came of a round of growth.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Advance {
    /// There are no faces to add.
    None,
    /// The patch has new faces.
    Made,
    /// The new faces could not be mapped without flips and were removed again.
    Undone,
}

/// Bounds of the growth.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    /// The most faces of a patch.
    pub faces: usize,
    /// Whether the patch may lie on a part of the surface more than once.
    pub can_overlap: bool,
}

/// A patch on its way to cover a sticker.
pub struct Growth<'a> {
    /// The surface, the patch and its pins.
    pub seed: &'a mut Seed,
    /// Vertices of the surface of all pins.
    pub vertices: &'a [u32],
    /// Points of all pins in the plane.
    pub places: &'a [Vec2],
    /// The region.
    pub outline: &'a Outline,
    /// The direction in the plane of a half-edge that leaves the only pin, where there is one pin.
    pub heading: Option<(u32, Vec2)>,
    /// Whether the patch grows with the pins of the seed alone at first, and is pulled to the others at the end.
    pub is_free: bool,
    /// Faces of the surface beyond the region that lead to pins.
    pub towards: HashSet<u32>,
    /// Bounds.
    pub limits: Limits,
    /// The memory of the factor of the last relaxation of the whole patch. It is kept, as allocators keep freed blocks of this
    /// size that a larger one does not fit into.
    pub factor: Vec<f32>,
    /// Is called after each change of the faces.
    pub watch: &'a dyn Fn(&Patch),
}

impl Growth<'_> {
    /// Grows the patch over the region, removes what lies outside, and lowers the distortion.
    ///
    /// # Errors
    /// A pin cannot be reached or makes triangles flip, the patch grows beyond its limit, or the caller cancels.
    pub fn run(&mut self, stop: Stop, progress: &mut dyn Progress) -> Grown<()> {
        // Pins that pull at a patch which covers the sticker say where it grows on. One that is stuck needs faces before it is
        // bent, as its fronts meet elsewhere then.
        let is_pulled = if self.is_free {
            self.cover(progress)?;
            let is_whole = is_covered(self.seed, self.outline);
            self.align(1.0);
            if is_whole && self.approach() {
                self.cover(progress)?;
                self.towards.clear();
                self.align(LARGER);
                self.cover(progress)?;
            }
            self.is_free = false;
            if is_whole {
                self.attach();
            }
            is_whole && self.seed.pins.len() == self.places.len()
        } else {
            true
        };
        if is_pulled {
            self.relax(ROUGH, progress)?;
        }
        // Pins that are reached pull the patch, which may grow towards others then. Faces that they pulled out of the region
        // would stop fronts.
        let mut before = None;
        loop {
            self.cover(progress)?;
            self.attach();
            if !self.is_arrived() {
                self.relax(PULLED, progress)?;
            }
            let held = self.seed.pins.len();
            if held == self.places.len() || before == Some(held) {
                break;
            }
            before = Some(held);
            self.peel();
        }
        if let Some(missing) = (0..self.places.len()).find(|pin| self.seed.pins.iter().all(|other| other.0 != *pin)) {
            return Err(Fault::Unreached(missing));
        }
        self.finish(stop, progress)
    }

    /// Lays a patch that covered the sticker anew after its pins or its surface moved.
    ///
    /// # Errors
    /// As [`Self::run`].
    pub fn settle(&mut self, stop: Stop, progress: &mut dyn Progress) -> Grown<()> {
        self.relax(stop, progress)?;
        self.cover(progress)?;
        self.finish(stop, progress)
    }

    /// Removes what lies outside, lowers the distortion, and adds what came into the region meanwhile.
    fn finish(&mut self, stop: Stop, progress: &mut dyn Progress) -> Grown<()> {
        self.peel();
        self.relax(stop, progress)?;
        for _ in 1..PASSES {
            let before = self.seed.patch.faces.len();
            if is_covered(self.seed, self.outline) {
                break;
            }
            self.cover(progress)?;
            let added = self.seed.patch.faces.len() - before;
            self.peel();
            // A few faces, which lie as rigidly as the others let them, change nothing elsewhere.
            if LOCAL_RATIO * added <= before {
                break;
            }
            self.relax(stop, progress)?;
        }
        self.peel();
        self.zip(stop, progress)
    }

    /// Closes seams where the map stays without flips and shows more of the sticker once, without much more distortion.
    fn zip(&mut self, stop: Stop, progress: &mut dyn Progress) -> Grown<()> {
        let mut is_fixed = vec![false; self.seed.patch.vertices.len()];
        for (_, vertex) in &self.seed.pins {
            is_fixed[*vertex as usize] = true;
        }
        let Some((patch, number)) = self.seed.patch.zipped(&self.seed.surface, &is_fixed)? else { return Ok(()) };
        let (before, energy) = (once(self.seed, self.outline), self.energy(0..self.seed.patch.faces.len()));
        let kept = (std::mem::replace(&mut self.seed.patch, patch), self.seed.pins.clone());
        for (_, vertex) in &mut self.seed.pins {
            *vertex = number[*vertex as usize];
        }
        (self.watch)(&self.seed.patch);
        let done = self.relax(stop, progress).and_then(|()| {
            if !is_covered(self.seed, self.outline) {
                self.cover(progress)?;
            }
            self.peel();
            Ok(())
        });
        let is_better = done.is_ok()
            && once(self.seed, self.outline) > before
            && self.energy(0..self.seed.patch.faces.len()) <= WORSE * energy;
        if !is_better {
            (self.seed.patch, self.seed.pins) = kept;
            (self.watch)(&self.seed.patch);
        }
        match done {
            Err(Fault::Other(error)) => Err(error.into()),
            _ => Ok(()),
        }
    }

    /// The mean energy of some faces for each unit of area: 4 at an isometric map.
    fn energy(&self, faces: Range<usize>) -> f64 {
        self.energies(faces).0
    }

    /// The mean and the largest energy of some faces for each unit of area.
    fn energies(&self, faces: Range<usize>) -> (f64, f64) {
        let Seed { surface, patch, scale, .. } = &*self.seed;
        let (mut energy, mut area, mut largest) = (0.0, 0.0, 0.0_f64);
        for (face, triangle) in patch.faces[faces.clone()].iter().zip(&patch.triangles[faces]) {
            let rest = Rest::new(surface.corners(*triangle), *scale);
            let own = rest.energy(face.map(|vertex| patch.positions[vertex as usize]), 0.0);
            energy += own;
            area += rest.area();
            largest = largest.max(own / rest.area());
        }
        (energy / area, largest)
    }

    /// Adds faces until no boundary edge with a face beyond touches the region.
    fn cover(&mut self, progress: &mut dyn Progress) -> Grown<()> {
        let mut faces = Faces::Rings(RINGS);
        // Faces of an upright ring may let the next whole ring through.
        let mut is_eased = false;
        for round in 0..ROUNDS {
            progress.step((round as f32 / ROUNDS as f32).sqrt(), "growing the patch")?;
            let advance = self.advance(faces, progress)?;
            let was_eased = std::mem::replace(&mut is_eased, faces == Faces::Upright && advance == Advance::Made);
            faces = match (faces, advance) {
                (Faces::Rings(rings), Advance::Made) => Faces::Rings((2 * rings).min(RINGS)),
                (Faces::Rings(1), Advance::Undone) => Faces::Upright,
                (Faces::Rings(rings), Advance::Undone) => Faces::Rings((rings / 4).max(1)),
                (Faces::Upright, Advance::Made) => Faces::Upright,
                (Faces::Upright, Advance::None) if was_eased => Faces::Rings(1),
                (Faces::Rings(_) | Faces::Upright, _) => Faces::Seam,
                (Faces::Seam, Advance::Made) => Faces::Rings(1),
                (Faces::Seam, _) => break,
            };
        }
        Ok(())
    }

    /// Adds faces, and lowers the distortion where they are more distorted than the others, unless that leaves flipped
    /// triangles: then the patch stays what it was.
    fn advance(&mut self, faces: Faces, progress: &mut dyn Progress) -> Grown<Advance> {
        let before = self.seed.patch.faces.len();
        let (mark, pins) = (self.seed.patch.mark(), self.seed.pins.clone());
        self.grow(faces)?;
        if self.seed.patch.faces.len() == before {
            return Ok(Advance::None);
        }
        (self.watch)(&self.seed.patch);
        if faces != Faces::Upright {
            self.extend(before)?;
            if !self.is_free {
                self.attach();
            }
        }
        let most = self.energy(0..before).max(ROUGH.enough);
        if self.is_arrived() {
            let faces = before..self.seed.patch.faces.len();
            let is_few = LOCAL_RATIO * faces.len() <= before;
            let is_smooth = self.is_smooth(before, most) || (is_few && self.smooth(before, most, progress)?);
            if is_smooth && self.turned_twice().is_none() {
                return Ok(Advance::Made);
            }
        }
        let stop = if self.is_arrived() { ROUGH } else { PULLED };
        match self.relax(Stop { is_trial: true, ..stop }, progress) {
            Ok(()) => Ok(Advance::Made),
            Err(Fault::Folded(_)) => {
                self.seed.patch.revert(mark);
                self.seed.pins = pins;
                (self.watch)(&self.seed.patch);
                Ok(Advance::Undone)
            }
            Err(fault) => Err(fault),
        }
    }

    /// Whether the faces from `first` on are hardly more distorted than `most`, an energy for each unit of area.
    fn is_smooth(&self, first: usize, most: f64) -> bool {
        let (mean, largest) = self.energies(first..self.seed.patch.faces.len());
        mean <= most && largest <= DISTORTED * most
    }

    /// Lowers the distortion of the faces from `first` on by moving the vertices within some rings of them. Returns whether
    /// they are smooth then.
    fn smooth(&mut self, first: usize, most: f64, progress: &mut dyn Progress) -> Result<bool> {
        let Seed { surface, patch, pins, scale } = &mut *self.seed;
        let mut is_free = vec![false; patch.vertices.len()];
        for vertex in patch.faces[first..].as_flattened() {
            is_free[*vertex as usize] = true;
        }
        spread(&patch.faces, &mut is_free, NEAR);
        for (_, vertex) in pins {
            is_free[*vertex as usize] = false;
        }
        let rest = |face: usize| Rest::new(surface.corners(patch.triangles[face]), *scale);
        let Some(mut part) = Part::new(&patch.faces, &patch.positions, &is_free, rest)? else { return Ok(false) };
        if part.relax(ROUGH, progress)? != Relaxed::Valid {
            return Ok(false);
        }
        part.move_back(&mut patch.positions);
        Ok(self.is_smooth(first, most))
    }

    /// Where the patch holds a vertex of a pin. A free patch, which is aligned with all pins, stays where it is.
    fn target(&self, pin: usize, vertex: u32) -> Vec2 {
        if self.is_free { self.seed.patch.positions[vertex as usize] } else { self.places[pin] }
    }

    /// Whether each pin that the patch holds is at its place.
    fn is_arrived(&self) -> bool {
        let mut pins = self.seed.pins.iter();
        pins.all(|(pin, vertex)| self.seed.patch.positions[*vertex as usize] == self.target(*pin, *vertex))
    }

    /// Moves, turns and scales the patch, by `most` times at most, so that the pins come near to their places (Umeyama 1991,
    /// with the ratio of both spreads as scale, which favours neither).
    fn align(&mut self, most: f64) {
        let held = self.seed.pins.clone();
        self.attach();
        let patch = &mut self.seed.patch;
        let pairs: Vec<(Vec2, Vec2)> =
            self.seed.pins.iter().map(|(pin, vertex)| (patch.positions[*vertex as usize], self.places[*pin])).collect();
        self.seed.pins = held;
        let count = pairs.len() as f64;
        let mean = |pick: fn(&(Vec2, Vec2)) -> Vec2| -> Vec2 {
            std::array::from_fn(|axis| pairs.iter().map(|pair| pick(pair)[axis]).sum::<f64>() / count)
        };
        let (from, to) = (mean(|pair| pair.0), mean(|pair| pair.1));
        let (mut cos, mut sin, mut before, mut after) = (0.0, 0.0, 0.0, 0.0);
        for (a, b) in &pairs {
            let (a, b) = ([a[0] - from[0], a[1] - from[1]], [b[0] - to[0], b[1] - to[1]]);
            cos += a[0] * b[0] + a[1] * b[1];
            sin += a[0] * b[1] - a[1] * b[0];
            before += a[0] * a[0] + a[1] * a[1];
            after += b[0] * b[0] + b[1] * b[1];
        }
        let norm = cos.hypot(sin);
        let (cos, sin) = if norm > 0.0 { (cos / norm, sin / norm) } else { (1.0, 0.0) };
        let scale = if before > 0.0 { (after / before).sqrt().clamp(most.recip(), most) } else { 1.0 };
        self.seed.scale *= scale;
        for position in &mut patch.positions {
            let [x, y] = [scale * (position[0] - from[0]), scale * (position[1] - from[1])];
            *position = [to[0] + cos * x - sin * y, to[1] + sin * x + cos * y];
        }
    }

    /// Pins whose vertices the patch has reached are pins of it from now on.
    fn attach(&mut self) {
        for pin in 0..self.places.len() {
            if self.seed.pins.iter().any(|(other, _)| *other == pin) {
                continue;
            }
            let Seed { patch, pins, .. } = &*self.seed;
            let place = self.places[pin];
            let far = |copy: &u32| distance(patch.positions[*copy as usize], place);
            let way = |other: &&(usize, u32)| distance(self.places[other.0], place);
            let beside = pins.iter().min_by(|a, b| way(a).total_cmp(&way(b))).filter(|_| self.limits.can_overlap);
            // A copy on another layer of the sticker lies elsewhere beside the nearest pin than the point of the image does.
            let is_on_layer = |copy: &u32| {
                beside.is_none_or(|other| {
                    let (at, from) = (patch.positions[*copy as usize], patch.positions[other.1 as usize]);
                    let target = self.places[other.0];
                    let astray = [0, 1].map(|axis| (at[axis] - from[axis]) - (place[axis] - target[axis]));
                    astray[0].hypot(astray[1]) <= ASTRAY * way(&other)
                })
            };
            let copies = patch.copies(self.vertices[pin]).filter(is_on_layer);
            let nearest = copies.min_by(|a, b| far(a).total_cmp(&far(b)));
            if let Some(copy) = nearest {
                self.seed.pins.push((pin, copy));
            }
        }
    }

    /// Lowers the distortion with the pins at their targets.
    fn relax(&mut self, stop: Stop, progress: &mut dyn Progress) -> Grown<()> {
        let target = |(pin, vertex): &(usize, u32)| (*vertex, self.target(*pin, *vertex));
        let targets: Vec<(u32, Vec2)> = self.seed.pins.iter().map(target).collect();
        let Seed { surface, patch, scale, .. } = &mut *self.seed;
        let rest: Vec<Rest> =
            patch.triangles.iter().map(|triangle| Rest::new(surface.corners(*triangle), *scale)).collect();
        let mut is_pinned = vec![false; patch.vertices.len()];
        for (vertex, _) in &targets {
            is_pinned[*vertex as usize] = true;
        }
        if patch.vertices.len() == targets.len() {
            return Ok(());
        }
        let mut map =
            Map { faces: &patch.faces, rest: &rest, positions: &mut patch.positions, pins: &targets, hook: None };
        if map.is_good(stop.enough) {
            self.turn();
            return self.check_turns();
        }
        let factor = std::mem::take(&mut self.factor);
        let mut system = System::within(factor, is_pinned.len(), map.faces, &is_pinned)?;
        let relaxed = map.relax(&mut system, stop, progress)?;
        self.factor = system.into_factor();
        if let Relaxed::Flipped(face) = relaxed {
            return Err(self.folded(self.seed.patch.faces[face][0]));
        }
        self.turn();
        self.check_turns()
    }

    /// The fault at a vertex where triangles fold.
    fn folded(&self, vertex: u32) -> Fault {
        let place = self.seed.patch.positions[vertex as usize];
        let far = |pin: &&(usize, u32)| distance(self.places[pin.0], place);
        let nearest = self.seed.pins.iter().min_by(|a, b| far(a).total_cmp(&far(b)));
        Fault::Folded(nearest.map_or(0, |nearest| nearest.0))
    }

    /// A vertex inside around which faces turn twice, if there is one.
    fn turned_twice(&self) -> Option<u32> {
        let patch = &self.seed.patch;
        turned_twice(&patch.faces, &patch.positions, |vertex| !patch.is_boundary(vertex))
    }

    /// Fails where faces turn twice around a vertex.
    fn check_turns(&self) -> Grown<()> {
        self.turned_twice().map_or(Ok(()), |vertex| Err(self.folded(vertex)))
    }

    /// With one pin: turns the patch about it until it has its heading again.
    fn turn(&mut self) {
        let Some((half, heading)) = self.heading else {
            return;
        };
        let Seed { surface, patch, pins, .. } = &mut *self.seed;
        let Some((_, center)) = pins.first() else {
            return;
        };
        let center = patch.positions[*center as usize];
        let target = surface.target(half);
        let Some(other) = patch.copies(target).next() else {
            return;
        };
        let other = patch.positions[other as usize];
        let way = [other[0] - center[0], other[1] - center[1]];
        let norm = way[0].hypot(way[1]) * heading[0].hypot(heading[1]);
        if norm <= 0.0 {
            return;
        }
        let cos = (way[0] * heading[0] + way[1] * heading[1]) / norm;
        let sin = (way[0] * heading[1] - way[1] * heading[0]) / norm;
        for position in &mut patch.positions {
            let [x, y] = [position[0] - center[0], position[1] - center[1]];
            *position = [center[0] + cos * x - sin * y, center[1] + sin * x + cos * y];
        }
    }
}
