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

/// Chords that have not ended.
#[derive(Clone, Debug, Default)]
pub(crate) struct Chords {
    chords: Vec<Chord>,
    /// Room for those that stay when others are dropped.
    kept: Vec<Chord>,
    /// Where the first of them ends.
    end: f32,
    /// Quadratic, middle, least, amplitude and the coordinates of `aside` of each, and at the end some of no particle.
    columns: [Vec<f32>; 7],
}

impl Chords {
    pub fn clear(&mut self) {
        self.chords.clear();
        self.end = f32::INFINITY;
        self.columns.iter_mut().for_each(Vec::clear);
    }

    pub fn push(&mut self, chord: Chord) {
        self.columns.iter_mut().for_each(|column| column.truncate(self.chords.len()));
        self.end = self.end.min(chord.span[1]);
        self.chords.push(chord);
        let Chord { quadratic, middle, least, amplitude, aside, .. } = chord;
        let values = [quadratic, middle, least, amplitude, aside.x, aside.y, aside.z];
        self.columns.iter_mut().zip(values).for_each(|(column, value)| column.push(value));
    }

    /// Drops chords that end before a distance.
    pub fn forget(&mut self, from: f32) {
        if self.end < from {
            let mut kept = std::mem::take(&mut self.kept);
            std::mem::swap(&mut kept, &mut self.chords);
            self.clear();
            kept.iter().filter(|chord| chord.span[1] >= from).for_each(|chord| self.push(*chord));
            self.kept = kept;
        }
    }

    /// The distance from which on a particle counts, not before `from`; infinite if there is none.
    pub fn next(&self, from: f32) -> f32 {
        let mut next = f32::INFINITY;
        for chord in self.chords.iter().filter(|chord| chord.span[1] >= from) {
            if chord.span[0] <= from {
                return from;
            }
            next = next.min(chord.span[0]);
        }
        next
    }

    /// The value of the function at a distance along the ray.
    pub fn value(&mut self, level: Level, surface: &Surface, direction: Vec3, at: f32) -> f32 {
        // Chords of no particle are where s is 2.
        for (column, value) in self.columns.iter_mut().zip([0.0, 0.0, 2.0, 0.0, 0.0, 0.0, 0.0]) {
            column.resize(self.chords.len() + WIDEST, value);
        }
        let mut sums = [0.0; 5];
        sum(level, surface, self, at, &mut sums);
        let [weight, along, x, y, z] = sums;
        surface.combination.value(weight, (Vec3::new(x, y, z) + along * direction).to_array())
    }

    /// All sums at a distance along the ray; calls `each` with every particle that counts and its weight.
    pub fn sums(&self, surface: &Surface, direction: Vec3, at: f32, mut each: impl FnMut(u32, f32)) -> Sums {
        let mut sums = Sums::default();
        for chord in &self.chords {
            let along = chord.middle - at;
            let s = chord.quadratic * along * along + chord.least;
            if s < 1.0 {
                let [weight, slope] = surface.profile.both(s);
                let d = chord.aside + along * direction;
                let weight = chord.amplitude * weight;
                sums.add(d, surface.image(chord.particle as usize, d), weight, chord.amplitude * slope);
                each(chord.particle, weight);
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
    let [quadratic, middle, least, amplitude, x, y, z] = &chords.columns;
    let (zero, one) = (v.splat(0.0), v.splat(1.0));
    let mut total = [zero; 5];
    for first in (0..chords.chords.len()).step_by(A::WIDTH) {
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
