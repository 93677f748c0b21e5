//! The particles along a piece of a ray by the chords of their kernels, where s of a particle is a quadratic function of
//! the distance along the ray: at a distance t, s = quadratic · (t − middle)² + least. Values there need no positions.

use std::ops::Range;

use glam::{DVec3, Vec3};
use relievo_core::dispatch_simd;
use relievo_core::lanes::Lanes;
use relievo_core::simd::Level;

use crate::solver::pairs::Vectors;
use crate::surface::Surface;
use crate::surface::function::Combination;
use crate::surface::probe::Sums;
use crate::surface::profile::{LANES, WIDEST, Weight, with_weight};

/// A piece of a ray, in coordinates around its beginning so that f32 is fine enough however far the ray comes from.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Piece {
    /// A place near the beginning.
    pub anchor: Vec3,
    /// From there to the beginning, less than what coordinates are rounded by.
    pub offset: Vec3,
    /// A unit vector.
    pub direction: Vec3,
    /// The time in seconds.
    pub time: f32,
}

impl Piece {
    /// Of a ray, from a distance from its origin on.
    pub fn new(origin: DVec3, direction: DVec3, distance: f64, time: f32) -> Self {
        let begin = origin + distance * direction;
        let anchor = begin.as_vec3();
        Self { anchor, offset: (begin - anchor.as_dvec3()).as_vec3(), direction: direction.as_vec3(), time }
    }
}

/// Chords that have not ended, and some that have.
#[derive(Clone, Debug, Default)]
pub(crate) struct Chords {
    particles: Vec<u32>,
    /// Quadratic, middle, least, amplitude, the coordinates of `aside` and the span of each, and room after them for lanes
    /// of no particle, where s is 2.
    columns: [Vec<f32>; 9],
    /// How many there may be before ended ones are dropped.
    most: usize,
}

/// Places of [`Chords::columns`].
const MIN: usize = 2;
const BEGIN: usize = 7;
const END: usize = 8;

impl Chords {
    pub fn clear(&mut self) {
        self.truncate(0);
    }

    /// Adds those of the particles in a range of the order whose kernels the ray meets. Velocities are columns, as the
    /// centres of the surface, or empty.
    pub fn admit(
        &mut self,
        level: Level,
        surface: &Surface,
        velocities: &[Vec<f32>; 3],
        piece: &Piece,
        range: Range<usize>,
    ) {
        admit(level, surface, velocities, piece, range, self);
    }

    /// Adds the chords of lanes, as [`Self::columns`], that a mask names.
    #[inline(always)]
    fn push(&mut self, lanes: &[[f32; WIDEST]; 9], first: usize, mut mask: u32) {
        let count = self.particles.len();
        if self.columns[MIN].len() < count + 2 * WIDEST {
            self.make_room(count + WIDEST);
        }
        let mut places = [0u8; WIDEST];
        let mut more = 0;
        while mask != 0 {
            let lane = mask.trailing_zeros();
            mask &= mask - 1;
            places[more] = lane as u8;
            more += 1;
            self.particles.push(first as u32 + lane);
        }
        for (column, lanes) in self.columns.iter_mut().zip(lanes) {
            let column = &mut column[count..count + WIDEST];
            for (value, place) in column.iter_mut().zip(&places[..more]) {
                *value = lanes[usize::from(*place) % WIDEST];
            }
        }
    }

    fn make_room(&mut self, count: usize) {
        self.columns.iter_mut().for_each(|column| column.resize(2 * (count + WIDEST), 2.0));
    }

    fn truncate(&mut self, count: usize) {
        let before = self.particles.len();
        self.particles.truncate(count);
        if self.columns[MIN].is_empty() {
            self.make_room(0);
        }
        self.columns[MIN][count..before.max(count)].fill(2.0);
        self.most = count + count / 4 + WIDEST;
    }

    /// Drops chords that end before a distance once there are many: they change no value.
    pub fn forget(&mut self, from: f32) {
        if self.particles.len() < self.most {
            return;
        }
        let mut kept = 0;
        for at in 0..self.particles.len() {
            if self.columns[END][at] >= from {
                self.columns.iter_mut().for_each(|column| column[kept] = column[at]);
                self.particles[kept] = self.particles[at];
                kept += 1;
            }
        }
        self.truncate(kept);
    }

    /// The distance from which on a particle counts, not before `from`; infinite if there is none.
    pub fn next(&self, level: Level, from: f32) -> f32 {
        next(level, self, from)
    }

    /// The value of the function at a distance along the ray.
    pub fn value(&self, level: Level, surface: &Surface, direction: Vec3, at: f32) -> f32 {
        let mut sums = [0.0; 5];
        sum(level, surface, self, at, &mut sums);
        let [weight, along, x, y, z] = sums;
        surface.combination.value(weight, (Vec3::new(x, y, z) + along * direction).to_array())
    }

    /// All sums at a distance along the ray; calls `each` with every particle that counts and its weight.
    pub fn sums(&self, surface: &Surface, direction: Vec3, at: f32, mut each: impl FnMut(u32, f32)) -> Sums {
        let mut sums = Sums::default();
        for (place, particle) in self.particles.iter().enumerate() {
            let [quadratic, middle, least, amplitude, x, y, z, ..] =
                std::array::from_fn::<_, 9, _>(|column| self.columns[column][place]);
            let along = middle - at;
            let s = quadratic * along * along + least;
            if s < 1.0 {
                let [weight, slope] = surface.profile.both(s);
                let d = Vec3::new(x, y, z) + along * direction;
                let weight = amplitude * weight;
                sums.add(d, surface.image(*particle as usize, d), weight, amplitude * slope);
                each(*particle, weight);
            }
        }
        sums
    }
}

dispatch_simd! {
    fn admit = admit_body(
        surface: &Surface, velocities: &[Vec<f32>; 3], piece: &Piece, range: Range<usize>, chords: &mut Chords,
    )
}

#[inline(always)]
fn admit_body<A: Lanes>(
    v: A,
    surface: &Surface,
    velocities: &[Vec<f32>; 3],
    piece: &Piece,
    range: Range<usize>,
    chords: &mut Chords,
) {
    let (numbers, one) = (v.load(&LANES), v.splat(1.0));
    let [anchor, offset, along] =
        [piece.anchor, piece.offset, piece.direction].map(|vector| Vectors::splat(v, vector.extend(0.0)));
    let moves = !velocities[0].is_empty();
    for first in range.clone().step_by(A::WIDTH) {
        let mut d = Vectors::load(v, &surface.centres, first).minus(v, anchor).minus(v, offset);
        if moves {
            d = d.plus(v, v.splat(piece.time), Vectors::load(v, velocities, first));
        }
        let (quadratic, middle, least, aside) = match &surface.shapes {
            None => {
                let sphere = v.splat(surface.sphere);
                let middle = d.dot(v, along);
                let aside = d.minus(v, along.times(v, middle));
                (sphere, middle, v.mul(aside.dot(v, aside), sphere), aside)
            }
            Some([xx, xy, xz, yy, yz, zz]) => {
                let [xx, xy, xz] = [v.load(&xx[first..]), v.load(&xy[first..]), v.load(&xz[first..])];
                let [yy, yz, zz] = [v.load(&yy[first..]), v.load(&yz[first..]), v.load(&zz[first..])];
                let rows = [Vectors([xx, xy, xz]), Vectors([xy, yy, yz]), Vectors([xz, yz, zz])];
                let ahead = Vectors([rows[0].dot(v, along), rows[1].dot(v, along), rows[2].dot(v, along)]);
                let quadratic = along.dot(v, ahead);
                let middle = v.div(ahead.dot(v, d), quadratic);
                let aside = d.minus(v, along.times(v, middle));
                let image = Vectors([rows[0].dot(v, aside), rows[1].dot(v, aside), rows[2].dot(v, aside)]);
                (quadratic, middle, aside.dot(v, image), aside)
            }
        };
        // What does not count may be no number.
        let left = v.splat((range.end - first).min(WIDEST) as f32);
        let mask = v.mask(v.both(v.lt(least, one), v.lt(numbers, left)));
        if mask != 0 {
            let half = v.sqrt(v.div(v.sub(one, least), quadratic));
            let amplitude = v.load(&surface.amplitudes[first..]);
            let Vectors([x, y, z]) = aside;
            let values = [quadratic, middle, least, amplitude, x, y, z, v.sub(middle, half), v.add(middle, half)];
            let mut lanes = [[0.0; WIDEST]; 9];
            for (lanes, value) in lanes.iter_mut().zip(values) {
                v.store(value, lanes);
            }
            chords.push(&lanes, first, mask);
        }
    }
}

dispatch_simd! { fn next = next_body(chords: &Chords, from: f32) -> f32 }

#[inline(always)]
fn next_body<A: Lanes>(v: A, chords: &Chords, from: f32) -> f32 {
    let (here, never) = (v.splat(from), v.splat(f32::INFINITY));
    let mut next = never;
    let count = chords.particles.len();
    let numbers = v.load(&LANES);
    for first in (0..count).step_by(A::WIDTH) {
        let (begin, end) = (v.load(&chords.columns[BEGIN][first..]), v.load(&chords.columns[END][first..]));
        let left = v.splat((count - first).min(WIDEST) as f32);
        let lasts = v.both(v.le(here, end), v.lt(numbers, left));
        if v.mask(v.both(lasts, v.le(begin, here))) != 0 {
            return from;
        }
        next = v.min(next, v.select(lasts, begin, never));
    }
    let mut lanes = [f32::INFINITY; WIDEST];
    v.store(next, &mut lanes);
    lanes.into_iter().fold(f32::INFINITY, f32::min)
}

dispatch_simd! {
    fn sum = sum_body(surface: &Surface, chords: &Chords, at: f32, sums: &mut [f32; 5])
}

#[inline(always)]
fn sum_body<A: Lanes>(v: A, surface: &Surface, chords: &Chords, at: f32, sums: &mut [f32; 5]) {
    with_weight!(surface.profile, weight => match surface.combination {
        Combination::Mean { .. } => sum_of::<A, _, true>(v, weight, chords, at, sums),
        Combination::Sum { .. } => sum_of::<A, _, false>(v, weight, chords, at, sums),
    });
}

/// Σ w, and of means Σ w (middle − t) and Σ w aside.
#[inline(always)]
fn sum_of<A: Lanes, W: Weight, const MEAN: bool>(v: A, weight: W, chords: &Chords, at: f32, sums: &mut [f32; 5]) {
    let count = chords.particles.len();
    // Of one length, so that one look at the end of a vector does for all.
    let [quadratic, middle, least, amplitude, x, y, z, _, _] = &chords.columns;
    let end = count.next_multiple_of(A::WIDTH);
    let (quadratic, middle, least, amplitude) = (&quadratic[..end], &middle[..end], &least[..end], &amplitude[..end]);
    let (x, y, z) = (&x[..end], &y[..end], &z[..end]);
    let (zero, one) = (v.splat(0.0), v.splat(1.0));
    let mut total = [zero; 5];
    for first in (0..count).step_by(A::WIDTH) {
        let along = v.sub(v.load(&middle[first..]), v.splat(at));
        let s = v.fused(v.mul(v.load(&quadratic[first..]), along), along, v.load(&least[first..]));
        let w = v.mul(v.load(&amplitude[first..]), weight.weight(v, v.min(s, one)));
        let w = v.select(v.lt(s, one), w, zero);
        total[0] = v.add(total[0], w);
        if MEAN {
            total[1] = v.fused(w, along, total[1]);
            total[2] = v.fused(w, v.load(&x[first..]), total[2]);
            total[3] = v.fused(w, v.load(&y[first..]), total[3]);
            total[4] = v.fused(w, v.load(&z[first..]), total[4]);
        }
    }
    let of_all = [v.sum(total[0]), v.sum(total[1]), v.sum(total[2]), v.sum(total[3]), v.sum(total[4])];
    *sums = of_all;
}
