//! The particles along a ray by the chords of their kernels, where s of a particle is a quadratic function of the
//! distance along the ray: values there need no positions.

use glam::Vec3;
use relievo_core::dispatch_simd;
use relievo_core::lanes::Lanes;
use relievo_core::simd::Level;

use crate::function::Combination;
use crate::probe::Sums;
use crate::profile::{WIDEST, Weight, with_weight};
use crate::surface::Surface;

/// A particle's kernel along a ray: at a distance t, s = quadratic · (t − middle)² + least.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Chord {
    /// Where s is below 1.
    pub span: [f32; 2],
    pub quadratic: f32,
    pub middle: f32,
    pub least: f32,
    /// From the ray at `middle` to the particle.
    pub aside: Vec3,
    pub amplitude: f32,
    /// In the order of the surface.
    pub particle: u32,
}

/// Chords that have not ended, and some that have.
#[derive(Clone, Debug, Default)]
pub(crate) struct Chords {
    particles: Vec<u32>,
    /// Quadratic, middle, least, amplitude, the coordinates of `aside` and the span of each, and room after them for lanes
    /// of no particle, where s is 2.
    columns: [Vec<f32>; 9],
    /// How many there may be before those that have ended are dropped.
    most: usize,
}

/// Places of [`Chords::columns`].
const LEAST: usize = 2;
const BEGIN: usize = 7;
const END: usize = 8;

impl Chords {
    pub fn clear(&mut self) {
        self.truncate(0);
    }

    pub fn push(&mut self, chord: Chord) {
        let Chord { span: [begin, end], quadratic, middle, least, amplitude, aside, particle } = chord;
        let count = self.particles.len();
        self.particles.push(particle);
        self.make_room();
        let values = [quadratic, middle, least, amplitude, aside.x, aside.y, aside.z, begin, end];
        self.columns.iter_mut().zip(values).for_each(|(column, value)| column[count] = value);
    }

    fn make_room(&mut self) {
        let room = self.particles.len() + WIDEST;
        if self.columns[LEAST].len() < room {
            self.columns.iter_mut().for_each(|column| column.resize(2 * room, 2.0));
        }
    }

    fn truncate(&mut self, count: usize) {
        let before = self.particles.len();
        self.particles.truncate(count);
        self.make_room();
        self.columns[LEAST][count..before.max(count)].fill(2.0);
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
    pub fn next(&self, from: f32) -> f32 {
        let mut next = f32::INFINITY;
        let ends = self.columns[BEGIN].iter().zip(&self.columns[END]).take(self.particles.len());
        for (begin, _) in ends.filter(|(_, end)| **end >= from) {
            if *begin <= from {
                return from;
            }
            next = next.min(*begin);
        }
        next
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
                self.columns.each_ref().map(|column| column[place]);
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
    fn sum = sum_body(surface: &Surface, chords: &Chords, at: f32, sums: &mut [f32; 5])
}

#[inline(always)]
fn sum_body<A: Lanes>(surface: &Surface, chords: &Chords, at: f32, sums: &mut [f32; 5]) {
    with_weight!(surface.profile, weight => match surface.combination {
        Combination::Mean { .. } => sum_of::<A, _, true>(weight, chords, at, sums),
        Combination::Sum { .. } => sum_of::<A, _, false>(weight, chords, at, sums),
    });
}

/// Σ w, and of means Σ w (middle − t) and Σ w aside.
#[inline(always)]
fn sum_of<A: Lanes, W: Weight, const MEAN: bool>(weight: W, chords: &Chords, at: f32, sums: &mut [f32; 5]) {
    // SAFETY: defined by `dispatch_simd!`.
    #[allow(unsafe_code)]
    let v = unsafe { A::assume() };
    let count = chords.particles.len();
    // Of one length, so that one look at the end of a vector does for all.
    let [quadratic, middle, least, amplitude, x, y, z, ..] =
        chords.columns.each_ref().map(|column| &column[..count.next_multiple_of(A::WIDTH)]);
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
    for (sum, value) in sums.iter_mut().zip(total) {
        let mut lanes = [0.0; WIDEST];
        v.store(value, &mut lanes);
        *sum = lanes[..A::WIDTH].iter().sum::<f32>();
    }
}
