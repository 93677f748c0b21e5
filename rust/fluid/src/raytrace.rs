//! Rays against the surface of a fluid itself, without a mesh (Morgenroth, Weiskopf, Eberhardt 2013, Section 5): boxes
//! of particles that a ray meets are sorted, the ray is marched through them, and where the sign changes the place is
//! halved. What lies well within the fluid is leapt over, where no particle moves.
//!
//! Boxes hold their particles from the opening of the shutter to its close, and each ray sees them where they are at
//! its time. Hits where blind particles have most of the weight are dropped: there the surface is that of the layer
//! that was kept and not of the fluid. Weights decide and not numbers of particles, of which wide supports see many
//! from afar.

use std::sync::Arc;

use glam::{DVec3, Vec3, Vec3A};
use relievo_core::simd::Level;
use relievo_core::{Context, Error, Result};

use crate::chords::{Chord, Chords};
use crate::hierarchy::{Bounds, Entry, Hierarchy};
use crate::interior::Interior;
use crate::probe::Probe;
use crate::surface::Surface;

/// The piece of a ray, in reaches, whose boxes are listed first; each one after it is twice as long. Most rays hit
/// early.
const PIECE: f32 = 4.0;
/// A leap through the fluid is at least so many steps long.
const LEAP: f32 = 2.0;
/// Rays of one task.
const PART: usize = 256;

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
    /// Of particles that do not move.
    interior: Option<Interior>,
    /// In the order of the surface; empty where nothing moves.
    velocities: Vec<[f32; 3]>,
    /// In the order of the surface; empty where none is.
    blind: Vec<bool>,
    shutter: [f32; 2],
    step: f32,
    level: Level,
}

impl RayCaster {
    /// Of a surface whose particles move, or not, and are blind, or not, both in the order of the positions it was made
    /// of.
    ///
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
        let sorted = |at: &u32| motion.velocities[*at as usize];
        let velocities: Vec<_> =
            if motion.velocities.is_empty() { Vec::new() } else { order.iter().map(sorted).collect() };
        let blind = if blind.is_empty() { Vec::new() } else { order.iter().map(|at| blind[*at as usize]).collect() };
        let boxes = context.map(surface.rows.len(), |cell| {
            surface.rows.particles(cell).fold(Bounds::NONE, |bounds, at| {
                let centre = Vec3A::from(surface.centre(at));
                let velocity = velocities.get(at).map_or(Vec3A::ZERO, |velocity| Vec3A::from(*velocity));
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
            interior: velocities.is_empty().then(|| Interior::new(surface)),
            velocities,
            blind,
            shutter: motion.shutter,
            step: surface.function().support() / march.steps,
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
        let parts: Vec<&[Ray]> = rays.chunks(PART).collect();
        let hits = context.map(parts.len(), |part| {
            let mut trail = context.scratch().lend::<Trail>();
            let mut tracer = self.tracer(&mut trail);
            parts[part].iter().map(|ray| tracer.intersect(ray)).collect::<Vec<_>>()
        });
        hits.concat()
    }

    fn velocity(&self, at: usize) -> DVec3 {
        self.velocities.get(at).map_or(DVec3::ZERO, |velocity| Vec3::from(*velocity).as_dvec3())
    }

    fn centre(&self, at: usize, time: f32) -> DVec3 {
        Vec3::from(self.surface.centre(at)).as_dvec3() + self.velocity(at) * f64::from(time)
    }
}

/// What a ray meets on its way. What is left of one ray does not matter to the next, of whatever surface.
#[derive(Clone, Debug, Default)]
pub struct Trail {
    met: Vec<Entry>,
    chords: Chords,
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
        let [mut from, end] = caster.hierarchy.extent(origin, direction, [near, ray.far])?;
        let (mut value, mut length) = (None, PIECE * caster.surface.reach);
        while from < end {
            let to = (from + length).max(from.next_up()).min(end);
            caster.hierarchy.meet(origin, direction, [from, to], &mut self.trail.met);
            if let Some(hit) = self.march((origin, direction), time, [from, to], &mut value) {
                return Some(hit);
            }
            (from, length) = (to, 2.0 * length);
        }
        None
    }

    /// Marches through a piece of a ray, whose boxes are listed; `value` is that at its beginning, and then at its end.
    fn march(
        &mut self,
        (origin, direction): (Vec3, Vec3),
        time: f32,
        [mut from, last]: [f32; 2],
        value: &mut Option<f32>,
    ) -> Option<Hit> {
        let caster = self.caster;
        self.trail.chords.clear();
        let mut next = 0;
        self.admit(&mut next, [from, from], (origin, direction), time);
        let first = value.unwrap_or_else(|| self.trail.chords.value(caster.level, &caster.surface, direction, from));
        let value = value.insert(first);
        // From where on leaps through the fluid are tried.
        let mut again = from;
        while from < last {
            if *value <= 0.0 {
                // Nothing counts before the next particle or box begins.
                let particle = self.trail.chords.next(from);
                let space = self.trail.met.get(next).map_or(f32::INFINITY, |entry| entry.enter);
                let skip = particle.min(space);
                if skip > from {
                    if skip >= last {
                        return None;
                    }
                    from = skip;
                    self.admit(&mut next, [from, from], (origin, direction), time);
                    if self.trail.chords.next(from) > from {
                        continue;
                    }
                }
            } else if let Some(interior) = caster.interior.as_ref().filter(|it| *value >= it.depth && from >= again) {
                let ray = (origin.as_dvec3(), direction.as_dvec3());
                let [end, after] = interior.stretch(&mut self.probe, ray, from, last);
                again = after;
                if end - from >= LEAP * caster.step {
                    self.admit(&mut next, [end, end], (origin, direction), time);
                    let after = self.trail.chords.value(caster.level, &caster.surface, direction, end);
                    if after > 0.0 {
                        self.trail.chords.forget(end);
                        (from, *value) = (end, after);
                        continue;
                    }
                    // There is a hollow: boxes that were passed over are looked at after all.
                    (next, again) = (0, end);
                    self.trail.chords.clear();
                    self.admit(&mut next, [from, from], (origin, direction), time);
                }
            }
            // Far from the origin a step may be less than what a distance is rounded by.
            let to = (from + caster.step).max(from.next_up()).min(last);
            self.admit(&mut next, [from, to], (origin, direction), time);
            let after = self.trail.chords.value(caster.level, &caster.surface, direction, to);
            if (after > 0.0) != (*value > 0.0) {
                let distance = self.halve(direction, [from, to], *value > 0.0);
                if let Some(hit) = self.shade((origin, direction), distance, after > 0.0) {
                    return Some(hit);
                }
            }
            self.trail.chords.forget(to);
            (from, *value) = (to, after);
        }
        None
    }

    /// Adds the particles of boxes that begin up to a distance, without those that end before another.
    fn admit(&mut self, next: &mut usize, [from, to]: [f32; 2], (origin, direction): (Vec3, Vec3), time: f32) {
        let surface = &self.caster.surface;
        let (origin, along) = (origin.as_dvec3(), direction.as_dvec3());
        while let Some(entry) = self.trail.met.get(*next).filter(|entry| entry.enter <= to) {
            *next += 1;
            if entry.exit < from {
                continue;
            }
            for at in surface.rows.particles(entry.leaf as usize) {
                let d = self.caster.centre(at, time) - origin;
                let (quadratic, middle, least, aside) = match &surface.shapes {
                    None => {
                        let middle = d.dot(along);
                        let aside = d - middle * along;
                        let sphere = f64::from(surface.sphere);
                        (sphere, middle, aside.length_squared() * sphere, aside)
                    }
                    Some(shapes) => {
                        let entry = |entry: usize| f64::from(shapes[entry][at]);
                        let rows = [[0, 1, 2], [1, 3, 4], [2, 4, 5]].map(|row| DVec3::from(row.map(entry)));
                        let image = |v: DVec3| DVec3::new(rows[0].dot(v), rows[1].dot(v), rows[2].dot(v));
                        let quadratic = along.dot(image(along));
                        let middle = along.dot(image(d)) / quadratic;
                        let aside = d - middle * along;
                        (quadratic, middle, aside.dot(image(aside)), aside)
                    }
                };
                if least < 1.0 {
                    let half = ((1.0 - least) / quadratic).sqrt();
                    self.trail.chords.push(Chord {
                        span: [(middle - half) as f32, (middle + half) as f32],
                        quadratic: quadratic as f32,
                        middle: middle as f32,
                        least: least as f32,
                        aside: aside.as_vec3(),
                        amplitude: surface.amplitudes[at],
                        particle: at as u32,
                    });
                }
            }
        }
    }

    /// The distance at which the sign changes, from between two.
    fn halve(&mut self, direction: Vec3, [mut from, mut to]: [f32; 2], inside: bool) -> f32 {
        let caster = self.caster;
        let close = 1e-6 * caster.surface.function().support();
        loop {
            let middle = 0.5 * (from + to);
            if to - from <= close || middle <= from || middle >= to {
                return middle;
            }
            if (self.trail.chords.value(caster.level, &caster.surface, direction, middle) > 0.0) == inside {
                from = middle;
            } else {
                to = middle;
            }
        }
    }

    /// The hit at a distance, unless it is of blind particles.
    fn shade(&self, (origin, direction): (Vec3, Vec3), distance: f32, enters: bool) -> Option<Hit> {
        let caster = self.caster;
        let (mut weights, mut blind, mut velocity) = (0.0, 0.0, Vec3::ZERO);
        let surface = &caster.surface;
        let sums = self.trail.chords.sums(surface, direction, distance, |particle, weight| {
            weights += weight;
            if caster.blind.get(particle as usize) == Some(&true) {
                blind += weight;
            }
            velocity += weight * caster.velocity(particle as usize).as_vec3();
        });
        if 2.0 * blind > weights {
            return None;
        }
        let gradient = sums.gradient(surface.combination);
        let outwards = if enters { -direction } else { direction };
        Some(Hit {
            distance,
            point: (origin + distance * direction).to_array(),
            normal: (-gradient).normalize_or(outwards).to_array(),
            velocity: if weights > 0.0 { (velocity / weights).to_array() } else { [0.0; 3] },
            enters,
        })
    }
}
