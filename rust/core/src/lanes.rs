//! Vectors of f32 and i32 at each instruction level, for kernels whose lanes take different ways: rays that take
//! different numbers of steps, look-ups from different places. Kernels whose lanes do the same need no more than loops.
//!
//! A kernel is `#[inline(always)]` and generic in [`Lanes`], and [`dispatch_simd!`](crate::dispatch_simd) compiles it
//! at each level. Minimum and maximum give the second argument where one is not a number, at every level.

/// The operations on masks that are truth values or have a bit for each lane.
macro_rules! plain_masks {
    () => {
        #[inline(always)]
        fn both(self, a: Self::M, b: Self::M) -> Self::M {
            a & b
        }

        #[inline(always)]
        fn either(self, a: Self::M, b: Self::M) -> Self::M {
            a | b
        }

        #[inline(always)]
        fn without(self, a: Self::M, b: Self::M) -> Self::M {
            a & !b
        }

        #[inline(always)]
        fn mask(self, value: Self::M) -> u32 {
            u32::from(value)
        }
    };
}

#[cfg(target_arch = "aarch64")]
mod neon;
#[cfg(target_arch = "x86_64")]
mod x86;

use half::f16;

use crate::simd::{Arithmetic, Baseline};

/// The vectors of an instruction level. A value of the implementing type stands for the processor having it.
pub trait Lanes: Arithmetic {
    /// Lanes of a vector.
    const WIDTH: usize;
    /// Floats.
    type F: Copy;
    /// Integers.
    type I: Copy;
    /// Truth values.
    type M: Copy;

    /// The vectors of this level.
    ///
    /// # Safety
    /// The processor has the instructions of this level, as it has inside of what `dispatch_simd!` defines.
    #[allow(unsafe_code)]
    unsafe fn assume() -> Self;

    /// The same float in every lane.
    fn splat(self, value: f32) -> Self::F;
    /// The first floats of a slice. Panics if there are fewer than lanes.
    fn load(self, from: &[f32]) -> Self::F;
    /// Writes the first floats of a slice. Panics if there are fewer than lanes.
    fn store(self, value: Self::F, to: &mut [f32]);
    /// a + b
    fn add(self, a: Self::F, b: Self::F) -> Self::F;
    /// a − b
    fn sub(self, a: Self::F, b: Self::F) -> Self::F;
    /// a · b
    fn mul(self, a: Self::F, b: Self::F) -> Self::F;
    /// a / b
    fn div(self, a: Self::F, b: Self::F) -> Self::F;
    /// a · b + c, fused where the level has it.
    fn fused(self, a: Self::F, b: Self::F, c: Self::F) -> Self::F;
    /// The lesser; b where one is not a number.
    fn min(self, a: Self::F, b: Self::F) -> Self::F;
    /// The greater; b where one is not a number.
    fn max(self, a: Self::F, b: Self::F) -> Self::F;
    /// a < b
    fn lt(self, a: Self::F, b: Self::F) -> Self::M;
    /// a ≤ b
    fn le(self, a: Self::F, b: Self::F) -> Self::M;
    /// a where the mask is set, else b.
    fn select(self, mask: Self::M, a: Self::F, b: Self::F) -> Self::F;
    /// The whole part; any number where it does not fit.
    fn trunc(self, value: Self::F) -> Self::I;
    /// Integers as floats.
    fn float(self, value: Self::I) -> Self::F;
    /// The bits of floats.
    fn bits(self, value: Self::F) -> Self::I;
    /// The same integer in every lane.
    fn isplat(self, value: i32) -> Self::I;
    /// a + b, wrapping.
    fn iadd(self, a: Self::I, b: Self::I) -> Self::I;
    /// a − b, wrapping.
    fn isub(self, a: Self::I, b: Self::I) -> Self::I;
    /// a · b, wrapping.
    fn imul(self, a: Self::I, b: Self::I) -> Self::I;
    /// The lesser.
    fn imin(self, a: Self::I, b: Self::I) -> Self::I;
    /// The greater.
    fn imax(self, a: Self::I, b: Self::I) -> Self::I;
    /// Bits set in both.
    fn iand(self, a: Self::I, b: Self::I) -> Self::I;
    /// The first integers of a slice. Panics if there are fewer than lanes.
    fn iload(self, from: &[u32]) -> Self::I;
    /// Writes the first integers of a slice. Panics if there are fewer than lanes.
    fn istore(self, value: Self::I, to: &mut [u32]);
    /// The upper 16 bits.
    fn high(self, value: Self::I) -> Self::I;
    /// The lower 16 bits as the upper ones.
    fn raised(self, value: Self::I) -> Self::I;
    /// a < b
    fn ilt(self, a: Self::I, b: Self::I) -> Self::M;
    /// a = b
    fn ieq(self, a: Self::I, b: Self::I) -> Self::M;
    /// a where the mask is set, else b.
    fn iselect(self, mask: Self::M, a: Self::I, b: Self::I) -> Self::I;
    /// Set in both.
    fn both(self, a: Self::M, b: Self::M) -> Self::M;
    /// Set in one of them.
    fn either(self, a: Self::M, b: Self::M) -> Self::M;
    /// Set in a but not in b.
    fn without(self, a: Self::M, b: Self::M) -> Self::M;
    /// The mask as bits, lane 0 lowest.
    fn mask(self, value: Self::M) -> u32;
    /// The entries of a table at the indices, the last where they exceed it. Panics if it is empty.
    fn gather(self, table: &[u32], index: Self::I) -> Self::I;
    /// The four numbers of the rows that the first indices of a slice name, a vector a column. Panics if there are fewer
    /// indices than lanes, or one is out of range.
    fn gather_rows(self, table: &[[f32; 4]], indices: &[u32]) -> [Self::F; 4];
    /// The square root.
    fn sqrt(self, value: Self::F) -> Self::F;
    /// The sum of all lanes.
    fn sum(self, value: Self::F) -> f32;
    /// Half floats as numbers.
    fn widen(self, from: &[f16]) -> Self::F;
    /// The nearest half floats, ties to the even one.
    fn narrow(self, value: Self::F, to: &mut [f16]);

    /// As [`Self::widen`], of as many half floats as there are places in `to`. Panics if there are fewer.
    #[inline(always)]
    fn widen_all(self, from: &[f16], to: &mut [f32]) {
        let whole = to.len() - to.len() % Self::WIDTH;
        let from = &from[..to.len()];
        for at in (0..whole).step_by(Self::WIDTH) {
            self.store(self.widen(&from[at..]), &mut to[at..]);
        }
        for (from, to) in from[whole..].iter().zip(&mut to[whole..]) {
            *to = from.to_f32();
        }
    }

    /// As [`Self::narrow`], of as many numbers as there are places in `to`. Panics if there are fewer.
    #[inline(always)]
    fn narrow_all(self, from: &[f32], to: &mut [f16]) {
        let whole = to.len() - to.len() % Self::WIDTH;
        let from = &from[..to.len()];
        for at in (0..whole).step_by(Self::WIDTH) {
            self.narrow(self.load(&from[at..]), &mut to[at..]);
        }
        for (from, to) in from[whole..].iter().zip(&mut to[whole..]) {
            *to = f16::from_f32(*from);
        }
    }
}

impl Lanes for Baseline {
    const WIDTH: usize = 1;
    type F = f32;
    type I = i32;
    type M = bool;

    #[inline(always)]
    #[allow(unsafe_code)]
    unsafe fn assume() -> Self {
        Baseline(())
    }

    #[inline(always)]
    fn splat(self, value: f32) -> Self::F {
        value
    }

    #[inline(always)]
    fn load(self, from: &[f32]) -> Self::F {
        from[0]
    }

    #[inline(always)]
    fn store(self, value: Self::F, to: &mut [f32]) {
        to[0] = value;
    }

    #[inline(always)]
    fn add(self, a: Self::F, b: Self::F) -> Self::F {
        a + b
    }

    #[inline(always)]
    fn sub(self, a: Self::F, b: Self::F) -> Self::F {
        a - b
    }

    #[inline(always)]
    fn mul(self, a: Self::F, b: Self::F) -> Self::F {
        a * b
    }

    #[inline(always)]
    fn div(self, a: Self::F, b: Self::F) -> Self::F {
        a / b
    }

    #[inline(always)]
    fn fused(self, a: Self::F, b: Self::F, c: Self::F) -> Self::F {
        Self::fma(a, b, c)
    }

    #[inline(always)]
    fn min(self, a: Self::F, b: Self::F) -> Self::F {
        if a < b { a } else { b }
    }

    #[inline(always)]
    fn max(self, a: Self::F, b: Self::F) -> Self::F {
        if a > b { a } else { b }
    }

    #[inline(always)]
    fn lt(self, a: Self::F, b: Self::F) -> Self::M {
        a < b
    }

    #[inline(always)]
    fn le(self, a: Self::F, b: Self::F) -> Self::M {
        a <= b
    }

    #[inline(always)]
    fn select(self, mask: Self::M, a: Self::F, b: Self::F) -> Self::F {
        if mask { a } else { b }
    }

    #[inline(always)]
    fn trunc(self, value: Self::F) -> Self::I {
        value as i32
    }

    #[inline(always)]
    fn float(self, value: Self::I) -> Self::F {
        value as f32
    }

    #[inline(always)]
    fn bits(self, value: Self::F) -> Self::I {
        value.to_bits() as i32
    }

    #[inline(always)]
    fn isplat(self, value: i32) -> Self::I {
        value
    }

    #[inline(always)]
    fn iadd(self, a: Self::I, b: Self::I) -> Self::I {
        a.wrapping_add(b)
    }

    #[inline(always)]
    fn isub(self, a: Self::I, b: Self::I) -> Self::I {
        a.wrapping_sub(b)
    }

    #[inline(always)]
    fn imul(self, a: Self::I, b: Self::I) -> Self::I {
        a.wrapping_mul(b)
    }

    #[inline(always)]
    fn imin(self, a: Self::I, b: Self::I) -> Self::I {
        a.min(b)
    }

    #[inline(always)]
    fn imax(self, a: Self::I, b: Self::I) -> Self::I {
        a.max(b)
    }

    #[inline(always)]
    fn iand(self, a: Self::I, b: Self::I) -> Self::I {
        a & b
    }

    #[inline(always)]
    fn high(self, value: Self::I) -> Self::I {
        (value as u32 >> 16) as i32
    }

    #[inline(always)]
    fn iload(self, from: &[u32]) -> Self::I {
        from[0] as i32
    }

    #[inline(always)]
    fn istore(self, value: Self::I, to: &mut [u32]) {
        to[0] = value as u32;
    }

    #[inline(always)]
    fn raised(self, value: Self::I) -> Self::I {
        value << 16
    }

    #[inline(always)]
    fn ilt(self, a: Self::I, b: Self::I) -> Self::M {
        a < b
    }

    #[inline(always)]
    fn ieq(self, a: Self::I, b: Self::I) -> Self::M {
        a == b
    }

    #[inline(always)]
    fn iselect(self, mask: Self::M, a: Self::I, b: Self::I) -> Self::I {
        if mask { a } else { b }
    }

    plain_masks!();

    #[inline(always)]
    fn gather(self, table: &[u32], index: Self::I) -> Self::I {
        table[(index as u32 as usize).min(table.len() - 1)] as i32
    }

    #[inline(always)]
    fn gather_rows(self, table: &[[f32; 4]], indices: &[u32]) -> [Self::F; 4] {
        table[indices[0] as usize]
    }

    #[inline(always)]
    fn sqrt(self, value: Self::F) -> Self::F {
        value.sqrt()
    }

    #[inline(always)]
    fn sum(self, value: Self::F) -> f32 {
        value
    }

    #[inline(always)]
    fn widen(self, from: &[f16]) -> Self::F {
        from[0].to_f32()
    }

    #[inline(always)]
    fn narrow(self, value: Self::F, to: &mut [f16]) {
        to[0] = f16::from_f32(value);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dispatch_simd;
    use crate::simd::Level;

    /// Follows the table from every start until it says 0, and counts the steps.
    #[inline(always)]
    fn chase_body<A: Lanes>(v: A, table: &[u32], steps: &mut [f32; 16]) {
        let places: [f32; 16] = std::array::from_fn(|i| i as f32 + 0.75);
        for (from, to) in places.chunks(A::WIDTH).zip(steps.chunks_mut(A::WIDTH)) {
            let mut place = v.trunc(v.load(from));
            let mut count = v.isplat(0);
            let none = v.isplat(0);
            let mut active = v.ilt(none, v.isplat(1));
            while v.mask(active) != 0 {
                place = v.gather(table, place);
                active = v.without(active, v.ieq(place, none));
                count = v.iselect(active, v.iadd(count, v.isplat(1)), count);
            }
            v.store(v.float(count), to);
        }
    }

    dispatch_simd! { fn chase = chase_body(table: &[u32], steps: &mut [f32; 16]) }

    #[inline(always)]
    fn compare_body<A: Lanes>(v: A, a: &[f32; 16], b: &[f32; 16], out: &mut [[f32; 16]; 4]) {
        for at in (0..16).step_by(A::WIDTH) {
            let (x, y) = (v.load(&a[at..]), v.load(&b[at..]));
            v.store(v.min(x, y), &mut out[0][at..]);
            v.store(v.max(x, y), &mut out[1][at..]);
            v.store(v.select(v.either(v.lt(x, y), v.le(y, x)), v.splat(1.0), v.splat(0.0)), &mut out[2][at..]);
            v.store(v.float(v.high(v.bits(x))), &mut out[3][at..]);
        }
    }

    dispatch_simd! { fn compare = compare_body(a: &[f32; 16], b: &[f32; 16], out: &mut [[f32; 16]; 4]) }

    #[test]
    fn lanes_take_their_own_ways_at_every_level() {
        let table: Vec<u32> = (0..16u32).map(|i| i / 2).collect();
        for (level, name) in Level::NAMES {
            let mut steps = [0.0; 16];
            chase(level, &table, &mut steps);
            let expected: [f32; 16] = std::array::from_fn(|i| (i as f32).max(1.0).log2().floor());
            assert_eq!(steps, expected, "{name}");
        }
    }

    #[inline(always)]
    fn rows_body<A: Lanes>(v: A, table: &[[f32; 4]], indices: &[u32; 16], out: &mut [[f32; 16]; 5]) {
        for at in (0..16).step_by(A::WIDTH) {
            let rows = v.gather_rows(table, &indices[at..]);
            (0..4).for_each(|k| v.store(rows[k], &mut out[k][at..]));
            out[4][0] += v.sum(v.sqrt(rows[3]));
        }
    }

    dispatch_simd! { fn rows = rows_body(table: &[[f32; 4]], indices: &[u32; 16], out: &mut [[f32; 16]; 5]) }

    #[test]
    fn rows_are_gathered_by_columns_at_every_level() {
        let table: Vec<[f32; 4]> = (0..40).map(|i| [i, i + 100, i + 200, i * i].map(|n| n as f32)).collect();
        let indices: [u32; 16] = std::array::from_fn(|i| (i as u32 * 7 + 39) % 40);
        for (level, name) in Level::NAMES {
            let mut out = [[0.0; 16]; 5];
            rows(level, &table, &indices, &mut out);
            for (lane, index) in indices.iter().enumerate() {
                assert_eq!(std::array::from_fn::<_, 4, _>(|k| out[k][lane]), table[*index as usize], "{name}");
            }
            assert_eq!(out[4][0], indices.iter().sum::<u32>() as f32, "{name}");
        }
    }

    #[test]
    #[should_panic(expected = "out of")]
    fn rows_out_of_range_are_not_read() {
        let mut indices = [0; 16];
        indices[9] = 3;
        rows(Level::best(), &[[0.0; 4]; 3], &indices, &mut [[0.0; 16]; 5]);
    }

    #[test]
    fn indices_beyond_a_table_read_its_last_entry() {
        for (level, name) in Level::NAMES {
            let mut steps = [9.0; 16];
            chase(level, &[0, 0], &mut steps);
            assert_eq!(steps, [0.0; 16], "{name}");
        }
    }

    #[inline(always)]
    fn halves_body<A: Lanes>(v: A, numbers: &[f32], halves: &mut [f16], back: &mut [f32]) {
        v.narrow_all(numbers, halves);
        v.widen_all(halves, back);
    }

    dispatch_simd! { fn to_halves = halves_body(numbers: &[f32], halves: &mut [f16], back: &mut [f32]) }

    #[test]
    fn half_floats_are_the_nearest_at_every_level() {
        // Every half float, and numbers half way to the next and beside that.
        let halves = (0..=u16::MAX).map(f16::from_bits).filter(|half| half.is_finite());
        let numbers: Vec<f32> = halves
            .flat_map(|half| {
                let middle = half.to_f32() + 0.5 * (f16::from_bits(half.to_bits() + 1).to_f32() - half.to_f32());
                [half.to_f32(), middle, f32::from_bits(middle.to_bits() + 1), f32::from_bits(middle.to_bits() - 1)]
            })
            .filter(|number| number.is_finite())
            .collect();
        let nearest: Vec<f16> = numbers.iter().map(|number| f16::from_f32(*number)).collect();
        for (level, name) in Level::NAMES {
            for count in [numbers.len(), 37, 7, 1] {
                let (mut found, mut back) = (vec![f16::ZERO; count], vec![0.0; count]);
                to_halves(level, &numbers, &mut found, &mut back);
                assert!(found == nearest[..count], "{name}");
                assert!(back.iter().zip(&found).all(|(back, half)| *back == half.to_f32()), "{name}");
            }
        }
    }

    #[test]
    fn what_is_not_a_number_compares_alike_at_every_level() {
        let mut a: [f32; 16] = std::array::from_fn(|i| i as f32 - 7.5);
        let mut b = [0.25; 16];
        (a[3], b[5]) = (f32::NAN, f32::NAN);
        for (level, name) in Level::NAMES {
            let mut out = [[0.0; 16]; 4];
            compare(level, &a, &b, &mut out);
            for i in 0..16 {
                let (least, most) = (if a[i] < b[i] { a[i] } else { b[i] }, if a[i] > b[i] { a[i] } else { b[i] });
                assert_eq!(out[0][i].to_bits(), least.to_bits(), "{name} {i}");
                assert_eq!(out[1][i].to_bits(), most.to_bits(), "{name} {i}");
                assert_eq!(out[2][i], f32::from(i != 3 && i != 5), "{name} {i}");
                assert_eq!(out[3][i], (a[i].to_bits() >> 16) as f32, "{name} {i}");
            }
        }
    }
}
