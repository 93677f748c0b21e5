//! The vectors of AVX2 and AVX-512.

#![allow(unsafe_code)]

use std::arch::x86_64::*;

use half::f16;

use super::Lanes;
use crate::simd::{Avx2, Avx512};

/// Evaluates an expression of intrinsics.
macro_rules! intrinsics {
    ($value:expr) => {
        // SAFETY: values of the level exist only where the processor has its instructions, and slices were checked
        // to hold what is read or written.
        unsafe { $value }
    };
}

/// Four numbers of the row that an index in range names.
macro_rules! row {
    ($table:ident, $indices:ident, $lane:expr) => {
        _mm_loadu_ps($table.as_ptr().add($indices[$lane] as usize).cast())
    };
}

/// The rows of a lane and of that four after it. Not a function: functions that closures call are not compiled for the
/// level.
macro_rules! two {
    ($table:ident, $indices:ident, $lane:expr) => {
        intrinsics!({
            let first = _mm256_castps128_ps256(row!($table, $indices, $lane));
            _mm256_insertf128_ps::<1>(first, row!($table, $indices, $lane + 4))
        })
    };
}

/// The rows of a lane and of every fourth after it.
macro_rules! four {
    ($table:ident, $indices:ident, $lane:expr) => {
        intrinsics!({
            let first = _mm512_castps128_ps512(row!($table, $indices, $lane));
            let second = _mm512_insertf32x4::<1>(first, row!($table, $indices, $lane + 4));
            let third = _mm512_insertf32x4::<2>(second, row!($table, $indices, $lane + 8));
            _mm512_insertf32x4::<3>(third, row!($table, $indices, $lane + 12))
        })
    };
}

impl Lanes for Avx2 {
    const WIDTH: usize = 8;
    type F = __m256;
    type I = __m256i;
    type M = __m256i;

    #[inline(always)]
    unsafe fn assume() -> Self {
        Avx2(())
    }

    #[inline(always)]
    fn splat(self, value: f32) -> Self::F {
        intrinsics!(_mm256_set1_ps(value))
    }

    #[inline(always)]
    fn load(self, from: &[f32]) -> Self::F {
        let from = &from[..Self::WIDTH];
        intrinsics!(_mm256_loadu_ps(from.as_ptr()))
    }

    #[inline(always)]
    fn store(self, value: Self::F, to: &mut [f32]) {
        let to = &mut to[..Self::WIDTH];
        intrinsics!(_mm256_storeu_ps(to.as_mut_ptr(), value))
    }

    #[inline(always)]
    fn add(self, a: Self::F, b: Self::F) -> Self::F {
        intrinsics!(_mm256_add_ps(a, b))
    }

    #[inline(always)]
    fn sub(self, a: Self::F, b: Self::F) -> Self::F {
        intrinsics!(_mm256_sub_ps(a, b))
    }

    #[inline(always)]
    fn mul(self, a: Self::F, b: Self::F) -> Self::F {
        intrinsics!(_mm256_mul_ps(a, b))
    }

    #[inline(always)]
    fn div(self, a: Self::F, b: Self::F) -> Self::F {
        intrinsics!(_mm256_div_ps(a, b))
    }

    #[inline(always)]
    fn fused(self, a: Self::F, b: Self::F, c: Self::F) -> Self::F {
        intrinsics!(_mm256_fmadd_ps(a, b, c))
    }

    #[inline(always)]
    fn min(self, a: Self::F, b: Self::F) -> Self::F {
        intrinsics!(_mm256_min_ps(a, b))
    }

    #[inline(always)]
    fn max(self, a: Self::F, b: Self::F) -> Self::F {
        intrinsics!(_mm256_max_ps(a, b))
    }

    #[inline(always)]
    fn lt(self, a: Self::F, b: Self::F) -> Self::M {
        intrinsics!(_mm256_castps_si256(_mm256_cmp_ps::<_CMP_LT_OQ>(a, b)))
    }

    #[inline(always)]
    fn le(self, a: Self::F, b: Self::F) -> Self::M {
        intrinsics!(_mm256_castps_si256(_mm256_cmp_ps::<_CMP_LE_OQ>(a, b)))
    }

    #[inline(always)]
    fn select(self, mask: Self::M, a: Self::F, b: Self::F) -> Self::F {
        intrinsics!(_mm256_blendv_ps(b, a, _mm256_castsi256_ps(mask)))
    }

    #[inline(always)]
    fn trunc(self, value: Self::F) -> Self::I {
        intrinsics!(_mm256_cvttps_epi32(value))
    }

    #[inline(always)]
    fn float(self, value: Self::I) -> Self::F {
        intrinsics!(_mm256_cvtepi32_ps(value))
    }

    #[inline(always)]
    fn bits(self, value: Self::F) -> Self::I {
        intrinsics!(_mm256_castps_si256(value))
    }

    #[inline(always)]
    fn isplat(self, value: i32) -> Self::I {
        intrinsics!(_mm256_set1_epi32(value))
    }

    #[inline(always)]
    fn iadd(self, a: Self::I, b: Self::I) -> Self::I {
        intrinsics!(_mm256_add_epi32(a, b))
    }

    #[inline(always)]
    fn isub(self, a: Self::I, b: Self::I) -> Self::I {
        intrinsics!(_mm256_sub_epi32(a, b))
    }

    #[inline(always)]
    fn imul(self, a: Self::I, b: Self::I) -> Self::I {
        intrinsics!(_mm256_mullo_epi32(a, b))
    }

    #[inline(always)]
    fn imin(self, a: Self::I, b: Self::I) -> Self::I {
        intrinsics!(_mm256_min_epi32(a, b))
    }

    #[inline(always)]
    fn imax(self, a: Self::I, b: Self::I) -> Self::I {
        intrinsics!(_mm256_max_epi32(a, b))
    }

    #[inline(always)]
    fn iand(self, a: Self::I, b: Self::I) -> Self::I {
        intrinsics!(_mm256_and_si256(a, b))
    }

    #[inline(always)]
    fn high(self, value: Self::I) -> Self::I {
        intrinsics!(_mm256_srli_epi32::<16>(value))
    }

    #[inline(always)]
    fn iload(self, from: &[u32]) -> Self::I {
        let from = &from[..Self::WIDTH];
        intrinsics!(_mm256_loadu_si256(from.as_ptr().cast()))
    }

    #[inline(always)]
    fn istore(self, value: Self::I, to: &mut [u32]) {
        let to = &mut to[..Self::WIDTH];
        intrinsics!(_mm256_storeu_si256(to.as_mut_ptr().cast(), value))
    }

    #[inline(always)]
    fn raised(self, value: Self::I) -> Self::I {
        intrinsics!(_mm256_slli_epi32::<16>(value))
    }

    #[inline(always)]
    fn ilt(self, a: Self::I, b: Self::I) -> Self::M {
        intrinsics!(_mm256_cmpgt_epi32(b, a))
    }

    #[inline(always)]
    fn ieq(self, a: Self::I, b: Self::I) -> Self::M {
        intrinsics!(_mm256_cmpeq_epi32(a, b))
    }

    #[inline(always)]
    fn iselect(self, mask: Self::M, a: Self::I, b: Self::I) -> Self::I {
        intrinsics!(_mm256_blendv_epi8(b, a, mask))
    }

    #[inline(always)]
    fn both(self, a: Self::M, b: Self::M) -> Self::M {
        intrinsics!(_mm256_and_si256(a, b))
    }

    #[inline(always)]
    fn either(self, a: Self::M, b: Self::M) -> Self::M {
        intrinsics!(_mm256_or_si256(a, b))
    }

    #[inline(always)]
    fn without(self, a: Self::M, b: Self::M) -> Self::M {
        intrinsics!(_mm256_andnot_si256(b, a))
    }

    #[inline(always)]
    fn mask(self, value: Self::M) -> u32 {
        intrinsics!(_mm256_movemask_ps(_mm256_castsi256_ps(value))) as u32
    }

    #[inline(always)]
    fn gather(self, table: &[u32], index: Self::I) -> Self::I {
        assert!(!table.is_empty(), "a table to look up in has entries");
        let last = (table.len() - 1).min(i32::MAX as usize) as i32;
        intrinsics!({
            let index = _mm256_min_epu32(index, _mm256_set1_epi32(last));
            _mm256_i32gather_epi32::<4>(table.as_ptr().cast(), index)
        })
    }

    #[inline(always)]
    fn gather_rows(self, table: &[[f32; 4]], indices: &[u32]) -> [Self::F; 4] {
        let indices = &indices[..Self::WIDTH];
        let last = table.len().wrapping_sub(1).min(i32::MAX as usize) as u32;
        let greatest = indices.iter().fold(0, |greatest, index| greatest.max(*index));
        assert!(!table.is_empty() && greatest <= last, "a row to gather is out of range");
        // Four rows are transposed in each half: the columns of the lower half are those of rows 0 to 3.
        let [a, b, c, d] =
            [two!(table, indices, 0), two!(table, indices, 1), two!(table, indices, 2), two!(table, indices, 3)];
        intrinsics!({
            let (ab_low, ab_high) = (_mm256_unpacklo_ps(a, b), _mm256_unpackhi_ps(a, b));
            let (cd_low, cd_high) = (_mm256_unpacklo_ps(c, d), _mm256_unpackhi_ps(c, d));
            [
                _mm256_shuffle_ps::<0x44>(ab_low, cd_low),
                _mm256_shuffle_ps::<0xee>(ab_low, cd_low),
                _mm256_shuffle_ps::<0x44>(ab_high, cd_high),
                _mm256_shuffle_ps::<0xee>(ab_high, cd_high),
            ]
        })
    }

    #[inline(always)]
    fn sqrt(self, value: Self::F) -> Self::F {
        intrinsics!(_mm256_sqrt_ps(value))
    }

    #[inline(always)]
    fn sum(self, value: Self::F) -> f32 {
        intrinsics!({
            let four = _mm_add_ps(_mm256_castps256_ps128(value), _mm256_extractf128_ps::<1>(value));
            let two = _mm_add_ps(four, _mm_movehl_ps(four, four));
            _mm_cvtss_f32(_mm_add_ss(two, _mm_shuffle_ps::<1>(two, two)))
        })
    }

    #[inline(always)]
    fn widen(self, from: &[f16]) -> Self::F {
        let from = &from[..Self::WIDTH];
        intrinsics!(_mm256_cvtph_ps(_mm_loadu_si128(from.as_ptr().cast())))
    }

    #[inline(always)]
    fn narrow(self, value: Self::F, to: &mut [f16]) {
        let to = &mut to[..Self::WIDTH];
        intrinsics!(_mm_storeu_si128(to.as_mut_ptr().cast(), _mm256_cvtps_ph::<_MM_FROUND_TO_NEAREST_INT>(value)))
    }
}

impl Lanes for Avx512 {
    const WIDTH: usize = 16;
    type F = __m512;
    type I = __m512i;
    type M = __mmask16;

    #[inline(always)]
    unsafe fn assume() -> Self {
        Avx512(())
    }

    #[inline(always)]
    fn splat(self, value: f32) -> Self::F {
        intrinsics!(_mm512_set1_ps(value))
    }

    #[inline(always)]
    fn load(self, from: &[f32]) -> Self::F {
        let from = &from[..Self::WIDTH];
        intrinsics!(_mm512_loadu_ps(from.as_ptr()))
    }

    #[inline(always)]
    fn store(self, value: Self::F, to: &mut [f32]) {
        let to = &mut to[..Self::WIDTH];
        intrinsics!(_mm512_storeu_ps(to.as_mut_ptr(), value))
    }

    #[inline(always)]
    fn add(self, a: Self::F, b: Self::F) -> Self::F {
        intrinsics!(_mm512_add_ps(a, b))
    }

    #[inline(always)]
    fn sub(self, a: Self::F, b: Self::F) -> Self::F {
        intrinsics!(_mm512_sub_ps(a, b))
    }

    #[inline(always)]
    fn mul(self, a: Self::F, b: Self::F) -> Self::F {
        intrinsics!(_mm512_mul_ps(a, b))
    }

    #[inline(always)]
    fn div(self, a: Self::F, b: Self::F) -> Self::F {
        intrinsics!(_mm512_div_ps(a, b))
    }

    #[inline(always)]
    fn fused(self, a: Self::F, b: Self::F, c: Self::F) -> Self::F {
        intrinsics!(_mm512_fmadd_ps(a, b, c))
    }

    #[inline(always)]
    fn min(self, a: Self::F, b: Self::F) -> Self::F {
        intrinsics!(_mm512_min_ps(a, b))
    }

    #[inline(always)]
    fn max(self, a: Self::F, b: Self::F) -> Self::F {
        intrinsics!(_mm512_max_ps(a, b))
    }

    #[inline(always)]
    fn lt(self, a: Self::F, b: Self::F) -> Self::M {
        intrinsics!(_mm512_cmp_ps_mask::<_CMP_LT_OQ>(a, b))
    }

    #[inline(always)]
    fn le(self, a: Self::F, b: Self::F) -> Self::M {
        intrinsics!(_mm512_cmp_ps_mask::<_CMP_LE_OQ>(a, b))
    }

    #[inline(always)]
    fn select(self, mask: Self::M, a: Self::F, b: Self::F) -> Self::F {
        intrinsics!(_mm512_mask_blend_ps(mask, b, a))
    }

    #[inline(always)]
    fn trunc(self, value: Self::F) -> Self::I {
        intrinsics!(_mm512_cvttps_epi32(value))
    }

    #[inline(always)]
    fn float(self, value: Self::I) -> Self::F {
        intrinsics!(_mm512_cvtepi32_ps(value))
    }

    #[inline(always)]
    fn bits(self, value: Self::F) -> Self::I {
        intrinsics!(_mm512_castps_si512(value))
    }

    #[inline(always)]
    fn isplat(self, value: i32) -> Self::I {
        intrinsics!(_mm512_set1_epi32(value))
    }

    #[inline(always)]
    fn iadd(self, a: Self::I, b: Self::I) -> Self::I {
        intrinsics!(_mm512_add_epi32(a, b))
    }

    #[inline(always)]
    fn isub(self, a: Self::I, b: Self::I) -> Self::I {
        intrinsics!(_mm512_sub_epi32(a, b))
    }

    #[inline(always)]
    fn imul(self, a: Self::I, b: Self::I) -> Self::I {
        intrinsics!(_mm512_mullo_epi32(a, b))
    }

    #[inline(always)]
    fn imin(self, a: Self::I, b: Self::I) -> Self::I {
        intrinsics!(_mm512_min_epi32(a, b))
    }

    #[inline(always)]
    fn imax(self, a: Self::I, b: Self::I) -> Self::I {
        intrinsics!(_mm512_max_epi32(a, b))
    }

    #[inline(always)]
    fn iand(self, a: Self::I, b: Self::I) -> Self::I {
        intrinsics!(_mm512_and_si512(a, b))
    }

    #[inline(always)]
    fn high(self, value: Self::I) -> Self::I {
        intrinsics!(_mm512_srli_epi32::<16>(value))
    }

    #[inline(always)]
    fn iload(self, from: &[u32]) -> Self::I {
        let from = &from[..Self::WIDTH];
        intrinsics!(_mm512_loadu_si512(from.as_ptr().cast()))
    }

    #[inline(always)]
    fn istore(self, value: Self::I, to: &mut [u32]) {
        let to = &mut to[..Self::WIDTH];
        intrinsics!(_mm512_storeu_si512(to.as_mut_ptr().cast(), value))
    }

    #[inline(always)]
    fn raised(self, value: Self::I) -> Self::I {
        intrinsics!(_mm512_slli_epi32::<16>(value))
    }

    #[inline(always)]
    fn ilt(self, a: Self::I, b: Self::I) -> Self::M {
        intrinsics!(_mm512_cmplt_epi32_mask(a, b))
    }

    #[inline(always)]
    fn ieq(self, a: Self::I, b: Self::I) -> Self::M {
        intrinsics!(_mm512_cmpeq_epi32_mask(a, b))
    }

    #[inline(always)]
    fn iselect(self, mask: Self::M, a: Self::I, b: Self::I) -> Self::I {
        intrinsics!(_mm512_mask_blend_epi32(mask, b, a))
    }

    plain_masks!();

    #[inline(always)]
    fn gather(self, table: &[u32], index: Self::I) -> Self::I {
        assert!(!table.is_empty(), "a table to look up in has entries");
        let last = (table.len() - 1).min(i32::MAX as usize) as i32;
        intrinsics!({
            let index = _mm512_min_epu32(index, _mm512_set1_epi32(last));
            _mm512_i32gather_epi32::<4>(index, table.as_ptr().cast())
        })
    }

    #[inline(always)]
    fn gather_rows(self, table: &[[f32; 4]], indices: &[u32]) -> [Self::F; 4] {
        let indices = &indices[..Self::WIDTH];
        let last = table.len().wrapping_sub(1).min(i32::MAX as usize) as i32;
        let greatest =
            intrinsics!(_mm512_cmpgt_epu32_mask(_mm512_loadu_si512(indices.as_ptr().cast()), _mm512_set1_epi32(last)));
        assert!(!table.is_empty() && greatest == 0, "a row to gather is out of range");
        // Four rows are transposed in each quarter: the columns of the first are those of rows 0 to 3.
        let [a, b, c, d] =
            [four!(table, indices, 0), four!(table, indices, 1), four!(table, indices, 2), four!(table, indices, 3)];
        intrinsics!({
            let (ab_low, ab_high) = (_mm512_unpacklo_ps(a, b), _mm512_unpackhi_ps(a, b));
            let (cd_low, cd_high) = (_mm512_unpacklo_ps(c, d), _mm512_unpackhi_ps(c, d));
            [
                _mm512_shuffle_ps::<0x44>(ab_low, cd_low),
                _mm512_shuffle_ps::<0xee>(ab_low, cd_low),
                _mm512_shuffle_ps::<0x44>(ab_high, cd_high),
                _mm512_shuffle_ps::<0xee>(ab_high, cd_high),
            ]
        })
    }

    #[inline(always)]
    fn sqrt(self, value: Self::F) -> Self::F {
        intrinsics!(_mm512_sqrt_ps(value))
    }

    #[inline(always)]
    fn sum(self, value: Self::F) -> f32 {
        intrinsics!(_mm512_reduce_add_ps(value))
    }

    #[inline(always)]
    fn widen(self, from: &[f16]) -> Self::F {
        let from = &from[..Self::WIDTH];
        intrinsics!(_mm512_cvtph_ps(_mm256_loadu_si256(from.as_ptr().cast())))
    }

    #[inline(always)]
    fn narrow(self, value: Self::F, to: &mut [f16]) {
        let to = &mut to[..Self::WIDTH];
        intrinsics!(_mm256_storeu_si256(to.as_mut_ptr().cast(), _mm512_cvtps_ph::<_MM_FROUND_TO_NEAREST_INT>(value)))
    }
}
