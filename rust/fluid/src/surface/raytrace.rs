//! Rays against the surface of a fluid itself, without a mesh (Morgenroth, Weiskopf, Eberhardt 2013, Section 5): boxes
//! of particles that a ray meets are sorted, the ray is marched through them, and where the sign changes the place is
//! halved. What lies well within the fluid is leapt over, where no particle moves.
//!
//! Boxes hold their particles from the opening of the shutter to its close, and each ray sees them where they are at
//! its time. Hits where blind particles have most of the weight are dropped: there the surface is that of the layer
//! that was kept and not of the fluid. Weights decide and not numbers of particles, of which wide supports see many
//! from afar.

use std::sync::Arc;

use glam::{Vec3, Vec3A};
use relievo_core::simd::Level;
use relievo_core::{Context, Error, Result};

use crate::surface::Surface;
use crate::surface::chords::{Chords, Piece};
use crate::surface::hierarchy::{Bounds, Entry, Hierarchy};
use crate::surface::interior::Interior;
use crate::surface::probe::Probe;
use crate::surface::profile::WIDEST;

/// The piece of a ray, in reaches, whose boxes are listed first; each one after it is twice as long. Most rays hit
/// early.
const PIECE: f32 = 2.0;
/// Particles of a box: one after the other in a row of cells, and a vector at most.
const BOX: usize = 16;
/// A leap through the fluid is at least so many steps long.
const LEAP: f32 = 2.0;
/// Rays of one task.
const CHUNK_LEN: usize = 256;

/// What particles have besides their positions, in the order of those.
#[derive(Clone, Copy, Debug, Default)]
pub struct Motion<'a> {
    /// Velocities in metres a second, or none.
    pub velocities: &'a [[f32; 3]],
    /// Opening and close of the shutter, in seconds from where positions are.
    pub shutter: [f32; 2],
}

/// How rays are marched.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct March {
    /// Steps of a support radius, 1 to 1,024: what is thinner than a step may be missed.
    pub steps: f32,
}

impl Default for March {
    fn default() -> Self {
        Self { steps: 12.0 }
    }
}

/// A ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Where it starts, in metres.
    pub origin: [f32; 3],
    /// Where it goes, of any length.
    pub direction: [f32; 3],
    /// The distances between which hits count, in metres.
    pub near: f32,
    /// See `near`; may be infinite.
    pub far: f32,
    /// The time in seconds, held within the shutter.
    pub time: f32,
}

/// Where a ray meets the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// The distance from the origin, in metres.
    pub distance: f32,
    /// The place.
    pub point: [f32; 3],
    /// The unit normal, which points out of the fluid.
    pub normal: [f32; 3],
    /// The velocity of the fluid there, the mean by weights; 0 without velocities.
    pub velocity: [f32; 3],
    /// Whether the ray enters the fluid here, or leaves it.
    pub enters: bool,
}

/// A surface prepared for rays: some 16 bytes a particle more, 20 where particles move.
#[derive(Clone, Debug)]
pub struct RayCaster {
    surface: Arc<Surface>,
    hierarchy: Hierarchy,
    /// The first particle of each box, and how many there are.
    firsts: Vec<u32>,
    /// Of particles that do not move while the shutter is open.
    interior: Option<Interior>,
    /// As [`Surface::centres`]; empty where nothing moves.
    velocities: [Vec<f32>; 3],
    /// In the order of the surface; empty where none is.
    blind: Vec<bool>,
    shutter: [f32; 2],
    step: f32,
    /// How long the first piece of a ray is.
    first: f32,
    level: Level,
}

impl RayCaster {
    /// Of a surface whose particles move, or not, and are blind, or not, both in the order of the positions it was made
    /// of.
    ///
    /// # Errors
    /// Fails if there are not as many velocities or flags as particles, none at all left aside, if a velocity or a time
    /// is not finite, if the shutter closes before it opens, or if steps are out of range.
    pub fn new(
        context: &Context,
        surface: &Arc<Surface>,
        motion: Motion<'_>,
        blind: &[bool],
        march: March,
    ) -> Result<Self> {
        let count = surface.len();
        for (name, given) in [("velocities", motion.velocities.len()), ("flags", blind.len())] {
            if given != 0 && given != count {
                return Err(Error::invalid(format!("{given} {name} for {count} particles"))
                    .advise("give one for each particle of the surface, or none"));
            }
        }
        if let Some(at) = motion.velocities.iter().position(|velocity| !Vec3::from(*velocity).is_finite()) {
            return Err(Error::invalid("a velocity is not a finite number").at(format!("particle {at}")));
        }
        let [open, close] = motion.shutter;
        if !(open.is_finite() && close.is_finite() && open <= close) {
            return Err(Error::invalid(format!("the shutter is open from {open} to {close}"))
                .advise("use finite times, the first not after the second"));
        }
        if !(1.0..=1024.0).contains(&march.steps) {
            return Err(Error::invalid(format!("{} steps of a support radius", march.steps)).advise("use 1 to 1,024"));
        }
        let order = &surface.order;
        let velocities = std::array::from_fn(|axis| {
            let sorted =
                order.iter().filter_map(|at| motion.velocities.get(*at as usize)).map(|velocity| velocity[axis]);
            let mut column: Vec<f32> = sorted.collect();
            if !column.is_empty() {
                column.resize(count + WIDEST, 0.0);
            }
            column
        });
        let blind = if blind.is_empty() { Vec::new() } else { order.iter().map(|at| blind[*at as usize]).collect() };
        let firsts = surface.rows.pieces(BOX);
        let boxes = context.map(firsts.len() - 1, |number| {
            (firsts[number] as usize..firsts[number + 1] as usize).fold(Bounds::NONE, |bounds, at| {
                let centre = Vec3A::from(surface.centre(at));
                let velocity = Vec3A::from(velocity(&velocities, at));
                let ends = [centre + velocity * open, centre + velocity * close];
                // More by what rounding of the coordinates may be.
                let reach = 1.001 * Vec3A::from(surface.extent(at)) + 1e-6 * (ends[0].abs() + ends[1].abs());
                let swept = Bounds { low: ends[0].min(ends[1]) - reach, high: ends[0].max(ends[1]) + reach };
                bounds.with(swept)
            })
        });
        Ok(Self {
            surface: surface.clone(),
            hierarchy: Hierarchy::new(&boxes),
            firsts,
            interior: (velocities[0].is_empty() || [open, close] == [0.0; 2]).then(|| Interior::new(surface)),
            velocities,
            blind,
            shutter: motion.shutter,
            step: surface.function().support() / march.steps,
            first: PIECE * surface.reach,
            level: context.level(),
        })
    }

    /// The smallest and largest coordinates of what rays can meet while the shutter is open; none without particles.
    pub fn bounds(&self) -> Option<[[f32; 3]; 2]> {
        self.hierarchy.bounds().map(|bounds| [bounds.low.to_array(), bounds.high.to_array()])
    }

    /// The surface.
    pub fn surface(&self) -> &Arc<Surface> {
        &self.surface
    }

    /// For tracing one ray after the other. Rays ask for no memory once a trail is long enough.
    pub fn tracer<'a>(&'a self, trail: &'a mut Trail) -> Tracer<'a> {
        Tracer { caster: self, trail, probe: Probe::new(&self.surface, self.level) }
    }

    /// As [`Tracer::intersect`], of many rays on all threads of a context.
    pub fn intersect_all(&self, context: &Context, rays: &[Ray]) -> Vec<Option<Hit>> {
        let parts: Vec<&[Ray]> = rays.chunks(CHUNK_LEN).collect();
        let hits = context.map(parts.len(), |part| {
            let mut trail = context.scratch().lend::<Trail>();
            let mut tracer = self.tracer(&mut trail);
            parts[part].iter().map(|ray| tracer.intersect(ray)).collect::<Vec<_>>()
        });
        hits.concat()
    }
}

/// The velocity of a particle by columns.
fn velocity(velocities: &[Vec<f32>; 3], at: usize) -> Vec3 {
    Vec3::from([0, 1, 2].map(|axis: usize| velocities[axis].get(at).copied().unwrap_or(0.0)))
}

/// What a ray meets on its way. What is left of one ray does not matter to the next, of whatever surface.
#[derive(Clone, Debug, Default)]
pub struct Trail {
    met: Vec<Entry>,
    chords: Chords,
}

/// How far a ray is marched, by distances from its origin.
#[derive(Clone, Copy, Debug)]
struct Way {
    /// Where the next piece begins, and where the ray ends.
    from: f64,
    end: f64,
    /// How long the next piece is.
    length: f32,
    /// The value where it begins, if it is known.
    value: Option<f32>,
    /// From where on leaps through the fluid are tried.
    again: f64,
    /// The beginning of a leap that ends where the piece begins, and the value there.
    leapt: Option<(f64, f32)>,
}

/// Traces rays.
#[derive(Debug)]
pub struct Tracer<'a> {
    caster: &'a RayCaster,
    trail: &'a mut Trail,
    probe: Probe<'a>,
}

impl Tracer<'_> {
    /// The first place where a ray enters or leaves the fluid. A ray that is no number, has no direction or ends before
    /// it starts meets nothing.
    pub fn intersect(&mut self, ray: &Ray) -> Option<Hit> {
        let caster = self.caster;
        let (origin, direction) = (Vec3::from(ray.origin), Vec3::from(ray.direction).try_normalize()?);
        let near = ray.near.max(0.0);
        if !(origin.is_finite() && near.is_finite() && ray.far > near && !ray.time.is_nan()) {
            return None;
        }
        let time = ray.time.clamp(caster.shutter[0], caster.shutter[1]);
        let [from, end] = caster.hierarchy.extent(origin, direction, [near, ray.far])?;
        let (origin, direction) = (origin.as_dvec3(), Vec3::from(ray.direction).as_dvec3().normalize());
        // Far away distances to the box around all are rounded by more than a step.
        let (from, end) =
            (f64::from((from - 1e-6 * from.abs()).max(near)), f64::from((end + 1e-6 * end.abs()).min(ray.far)));
        let mut way = Way { from, end, length: caster.first, value: None, again: from, leapt: None };
        while way.from < way.end {
            let piece = Piece::new(origin, direction, way.from, time);
            let last = way.length.min((way.end - way.from) as f32);
            caster.hierarchy.meet(piece.anchor, piece.direction, [0.0, last], &mut self.trail.met);
            if let Some(hit) = self.march(&piece, last, &mut way) {
                return Some(hit);
            }
        }
        None
    }

    /// Marches through a piece of a ray, whose boxes are listed, and says where the next one begins. Distances are from the
    /// beginning of the piece.
    fn march(&mut self, piece: &Piece, last: f32, way: &mut Way) -> Option<Hit> {
        let caster = self.caster;
        self.trail.chords.clear();
        let (mut next, mut from) = (0, 0.0f32);
        self.admit(&mut next, [from, from], piece);
        let mut value = way.value.unwrap_or_else(|| self.value(piece, from));
        if let Some((before, value_there)) = way.leapt.take().filter(|_| value <= 0.0) {
            // There is a hollow: the ray is marched to it after all.
            *way = Way { from: before, length: caster.first, value: Some(value_there), again: way.from, ..*way };
            return None;
        }
        // From where on leaps through the fluid are tried.
        let mut again = (way.again - way.from) as f32;
        while from < last {
            if value <= 0.0 {
                // Nothing counts before the next particle or box begins.
                let particle = self.trail.chords.next(caster.level, from);
                let space = self.trail.met.get(next).map_or(f32::INFINITY, |entry| entry.enter);
                let skip = particle.min(space);
                if skip > from {
                    if skip >= last {
                        break;
                    }
                    from = skip;
                    self.admit(&mut next, [from, from], piece);
                    if self.trail.chords.next(caster.level, from) > from {
                        continue;
                    }
                }
            } else if let Some(interior) = caster.interior.as_ref().filter(|it| value >= it.depth && from >= again) {
                let [end, after] = interior.stretch(&mut self.probe, piece, from, (way.end - way.from) as f32);
                again = after;
                if end - from >= LEAP * caster.step {
                    let leapt = Some((way.from + f64::from(from), value));
                    *way = Way { from: way.from + f64::from(end), length: caster.first, value: None, leapt, ..*way };
                    return None;
                }
            }
            let to = (from + caster.step).max(from.next_up()).min(last);
            self.admit(&mut next, [from, to], piece);
            let after = self.value(piece, to);
            if (after > 0.0) != (value > 0.0) {
                let distance = self.close_in(piece, [from, to], [value, after]);
                if let Some(hit) = self.shade(piece, distance, after > 0.0) {
                    return Some(Hit { distance: (way.from + f64::from(distance)) as f32, ..hit });
                }
            }
            self.trail.chords.forget(to);
            (from, value) = (to, after);
        }
        let again = way.from + f64::from(again);
        *way = Way { from: way.from + f64::from(last), length: 2.0 * way.length, value: Some(value), again, ..*way };
        None
    }

    fn value(&self, piece: &Piece, at: f32) -> f32 {
        self.trail.chords.value(self.caster.level, &self.caster.surface, piece.direction, at)
    }

    /// Adds the particles of boxes that begin up to a distance, without boxes that end before another.
    fn admit(&mut self, next: &mut usize, [from, to]: [f32; 2], piece: &Piece) {
        let caster = self.caster;
        while let Some(entry) = self.trail.met.get(*next).filter(|entry| entry.enter <= to) {
            *next += 1;
            if entry.exit >= from {
                let [first, after] = [0, 1].map(|more| caster.firsts[entry.leaf as usize + more] as usize);
                let chords = &mut self.trail.chords;
                chords.admit(caster.level, &caster.surface, &caster.velocities, piece, first..after);
            }
        }
    }

    /// The distance at which the sign changes, from between two with their values: where a straight line between these says,
    /// or in the middle when that is slow.
    fn close_in(&self, piece: &Piece, [mut from, mut to]: [f32; 2], [mut before, mut after]: [f32; 2]) -> f32 {
        let close = 1e-6 * self.caster.surface.function().support();
        let inside = before > 0.0;
        // Which end the last place was taken for, and how many places there were.
        let (mut side, mut count) = (None, 0);
        loop {
            let middle = 0.5 * (from + to);
            if to - from <= close || middle <= from || middle >= to {
                return middle;
            }
            let straight = from + (to - from) * (before / (before - after));
            let at = if count % 3 == 2 || straight.is_nan() {
                middle
            } else {
                straight.clamp(from + 0.5 * close, to - 0.5 * close)
            };
            let at = if at > from && at < to { at } else { middle };
            let value = self.value(piece, at);
            if (value > 0.0) == inside {
                (from, before) = (at, value);
                // An end that stays counts for less (Dowell, Jarratt 1971).
                after *= if side == Some(false) { 0.5 } else { 1.0 };
                side = Some(false);
            } else {
                (to, after) = (at, value);
                before *= if side == Some(true) { 0.5 } else { 1.0 };
                side = Some(true);
            }
            count += 1;
        }
    }

    /// The hit at a distance, unless it is of blind particles.
    fn shade(&self, piece: &Piece, distance: f32, enters: bool) -> Option<Hit> {
        let caster = self.caster;
        let (mut weights, mut blind, mut velocity) = (0.0, 0.0, Vec3::ZERO);
        let (surface, direction) = (&caster.surface, piece.direction);
        let sums = self.trail.chords.sums(surface, direction, distance, |particle, weight| {
            weights += weight;
            if caster.blind.get(particle as usize) == Some(&true) {
                blind += weight;
            }
            velocity += weight * self::velocity(&caster.velocities, particle as usize);
        });
        if 2.0 * blind > weights {
            return None;
        }
        let gradient = sums.gradient(surface.combination);
        let outwards = if enters { -direction } else { direction };
        Some(Hit {
            distance,
            point: (piece.anchor + (piece.offset + distance * direction)).to_array(),
            normal: (-gradient).normalize_or(outwards).to_array(),
            velocity: if weights > 0.0 { (velocity / weights).to_array() } else { [0.0; 3] },
            enters,
        })
    }
}
