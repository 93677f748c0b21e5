//! The vectors of NEON.

#![allow(unsafe_code)]

use std::arch::aarch64::*;

use half::f16;

use super::Lanes;
use crate::simd::Neon;

/// Evaluates an expression of intrinsics.
macro_rules! intrinsics {
    ($value:expr) => {
        // SAFETY: NEON is part of AArch64, and slices were checked to hold what is read or written.
        #[allow(unused_unsafe)]
        unsafe {
            $value
        }
    };
}

impl Lanes for Neon {
    const WIDTH: usize = 4;
    type F = float32x4_t;
    type I = int32x4_t;
    type M = uint32x4_t;

    #[inline(always)]
    unsafe fn assume() -> Self {
        Neon::VECTORS
    }

    #[inline(always)]
    fn splat(self, value: f32) -> Self::F {
        intrinsics!(vdupq_n_f32(value))
    }

    #[inline(always)]
    fn load(self, from: &[f32]) -> Self::F {
        let from = &from[..Self::WIDTH];
        intrinsics!(vld1q_f32(from.as_ptr()))
    }

    #[inline(always)]
    fn store(self, value: Self::F, to: &mut [f32]) {
        let to = &mut to[..Self::WIDTH];
        intrinsics!(vst1q_f32(to.as_mut_ptr(), value))
    }

    #[inline(always)]
    fn add(self, a: Self::F, b: Self::F) -> Self::F {
        intrinsics!(vaddq_f32(a, b))
    }

    #[inline(always)]
    fn sub(self, a: Self::F, b: Self::F) -> Self::F {
        intrinsics!(vsubq_f32(a, b))
    }

    #[inline(always)]
    fn mul(self, a: Self::F, b: Self::F) -> Self::F {
        intrinsics!(vmulq_f32(a, b))
    }

    #[inline(always)]
    fn div(self, a: Self::F, b: Self::F) -> Self::F {
        intrinsics!(vdivq_f32(a, b))
    }

    #[inline(always)]
    fn fused(self, a: Self::F, b: Self::F, c: Self::F) -> Self::F {
        intrinsics!(vfmaq_f32(c, a, b))
    }

    // The instructions for the lesser and the greater return what is not a number, so these are choices.
    #[inline(always)]
    fn min(self, a: Self::F, b: Self::F) -> Self::F {
        intrinsics!(vbslq_f32(vcltq_f32(a, b), a, b))
    }

    #[inline(always)]
    fn max(self, a: Self::F, b: Self::F) -> Self::F {
        intrinsics!(vbslq_f32(vcgtq_f32(a, b), a, b))
    }

    #[inline(always)]
    fn lt(self, a: Self::F, b: Self::F) -> Self::M {
        intrinsics!(vcltq_f32(a, b))
    }

    #[inline(always)]
    fn le(self, a: Self::F, b: Self::F) -> Self::M {
        intrinsics!(vcleq_f32(a, b))
    }

    #[inline(always)]
    fn select(self, mask: Self::M, a: Self::F, b: Self::F) -> Self::F {
        intrinsics!(vbslq_f32(mask, a, b))
    }

    #[inline(always)]
    fn trunc(self, value: Self::F) -> Self::I {
        intrinsics!(vcvtq_s32_f32(value))
    }

    #[inline(always)]
    fn float(self, value: Self::I) -> Self::F {
        intrinsics!(vcvtq_f32_s32(value))
    }

    #[inline(always)]
    fn bits(self, value: Self::F) -> Self::I {
        intrinsics!(vreinterpretq_s32_f32(value))
    }

    #[inline(always)]
    fn isplat(self, value: i32) -> Self::I {
        intrinsics!(vdupq_n_s32(value))
    }

    #[inline(always)]
    fn iadd(self, a: Self::I, b: Self::I) -> Self::I {
        intrinsics!(vaddq_s32(a, b))
    }

    #[inline(always)]
    fn isub(self, a: Self::I, b: Self::I) -> Self::I {
        intrinsics!(vsubq_s32(a, b))
    }

    #[inline(always)]
    fn imul(self, a: Self::I, b: Self::I) -> Self::I {
        intrinsics!(vmulq_s32(a, b))
    }

    #[inline(always)]
    fn imin(self, a: Self::I, b: Self::I) -> Self::I {
        intrinsics!(vminq_s32(a, b))
    }

    #[inline(always)]
    fn imax(self, a: Self::I, b: Self::I) -> Self::I {
        intrinsics!(vmaxq_s32(a, b))
    }

    #[inline(always)]
    fn iand(self, a: Self::I, b: Self::I) -> Self::I {
        intrinsics!(vandq_s32(a, b))
    }

    #[inline(always)]
    fn iload(self, from: &[u32]) -> Self::I {
        let from = &from[..Self::WIDTH];
        intrinsics!(vreinterpretq_s32_u32(vld1q_u32(from.as_ptr())))
    }

    #[inline(always)]
    fn istore(self, value: Self::I, to: &mut [u32]) {
        let to = &mut to[..Self::WIDTH];
        intrinsics!(vst1q_u32(to.as_mut_ptr(), vreinterpretq_u32_s32(value)))
    }

    #[inline(always)]
    fn high(self, value: Self::I) -> Self::I {
        intrinsics!(vreinterpretq_s32_u32(vshrq_n_u32::<16>(vreinterpretq_u32_s32(value))))
    }

    #[inline(always)]
    fn raised(self, value: Self::I) -> Self::I {
        intrinsics!(vshlq_n_s32::<16>(value))
    }

    #[inline(always)]
    fn ilt(self, a: Self::I, b: Self::I) -> Self::M {
        intrinsics!(vcltq_s32(a, b))
    }

    #[inline(always)]
    fn ieq(self, a: Self::I, b: Self::I) -> Self::M {
        intrinsics!(vceqq_s32(a, b))
    }

    #[inline(always)]
    fn iselect(self, mask: Self::M, a: Self::I, b: Self::I) -> Self::I {
        intrinsics!(vbslq_s32(mask, a, b))
    }

    #[inline(always)]
    fn both(self, a: Self::M, b: Self::M) -> Self::M {
        intrinsics!(vandq_u32(a, b))
    }

    #[inline(always)]
    fn either(self, a: Self::M, b: Self::M) -> Self::M {
        intrinsics!(vorrq_u32(a, b))
    }

    #[inline(always)]
    fn without(self, a: Self::M, b: Self::M) -> Self::M {
        intrinsics!(vbicq_u32(a, b))
    }

    #[inline(always)]
    fn mask(self, value: Self::M) -> u32 {
        const BITS: [u32; 4] = [1, 2, 4, 8];
        intrinsics!(vaddvq_u32(vandq_u32(value, vld1q_u32(BITS.as_ptr()))))
    }

    #[inline(always)]
    fn gather(self, table: &[u32], index: Self::I) -> Self::I {
        assert!(!table.is_empty(), "a table to look up in has entries");
        // No instruction looks up in tables of this size.
        let last = (table.len() - 1).min(i32::MAX as usize);
        let mut entries = [0; Self::WIDTH];
        self.istore(index, &mut entries);
        for entry in &mut entries {
            *entry = table[(*entry as usize).min(last)];
        }
        self.iload(&entries)
    }

    #[inline(always)]
    fn gather_rows(self, table: &[[f32; 4]], indices: &[u32]) -> [Self::F; 4] {
        let indices = &indices[..Self::WIDTH];
        let greatest = indices.iter().fold(0, |greatest, index| greatest.max(*index));
        assert!((greatest as usize) < table.len(), "a row to gather is out of range");
        intrinsics!({
            let row = |lane: usize| vld1q_f32(table[indices[lane] as usize].as_ptr());
            let (a, b, c, d) = (row(0), row(1), row(2), row(3));
            // The transpose of four rows: numbers of even columns, those of odd ones, and then halves.
            let (ab_even, ab_odd) = (vtrn1q_f32(a, b), vtrn2q_f32(a, b));
            let (cd_even, cd_odd) = (vtrn1q_f32(c, d), vtrn2q_f32(c, d));
            let halves = |first: Self::F, second: Self::F| {
                let (first, second) = (vreinterpretq_f64_f32(first), vreinterpretq_f64_f32(second));
                let columns = (vzip1q_f64(first, second), vzip2q_f64(first, second));
                (vreinterpretq_f32_f64(columns.0), vreinterpretq_f32_f64(columns.1))
            };
            let ((zero, two), (one, three)) = (halves(ab_even, cd_even), halves(ab_odd, cd_odd));
            [zero, one, two, three]
        })
    }

    #[inline(always)]
    fn sqrt(self, value: Self::F) -> Self::F {
        intrinsics!(vsqrtq_f32(value))
    }

    #[inline(always)]
    fn sum(self, value: Self::F) -> f32 {
        intrinsics!({
            let two = vadd_f32(vget_low_f32(value), vget_high_f32(value));
            vget_lane_f32::<0>(two) + vget_lane_f32::<1>(two)
        })
    }

    #[inline(always)]
    fn widen(self, from: &[f16]) -> Self::F {
        let from = &from[..Self::WIDTH];
        intrinsics!(vcvt_f32_f16(vreinterpret_f16_u16(vld1_u16(from.as_ptr().cast()))))
    }

    #[inline(always)]
    fn narrow(self, value: Self::F, to: &mut [f16]) {
        let to = &mut to[..Self::WIDTH];
        intrinsics!(vst1_u16(to.as_mut_ptr().cast(), vreinterpret_u16_f16(vcvt_f16_f32(value))))
    }
}
