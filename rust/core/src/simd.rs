//! The instruction level of SIMD kernels, chosen at run time.
//!
//! A kernel is written once as an `#[inline(always)]` function over slices, generic in [`Arithmetic`], and compiled at
//! each level by [`dispatch_simd!`](crate::dispatch_simd). Levels differ in the last bit where they fuse multiply and
//! add, so journals and caches record the level; within one level results are bit-identical.

use crate::{Error, Result};

/// Asks for `values[index]` to be brought from memory to the caches; nothing happens beyond the end, or where
/// processors are not known to have an instruction for it.
#[inline(always)]
pub fn prefetch<T>(values: &[T], index: usize) {
    #[cfg(target_arch = "x86_64")]
    if let Some(value) = values.get(index) {
        use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        // SAFETY: a hint, of an address that may be read; every 64-bit processor of this kind has it.
        #[allow(unsafe_code)]
        unsafe {
            _mm_prefetch::<_MM_HINT_T0>(std::ptr::from_ref(value).cast());
        }
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = (values, index);
}

/// Numbers that [`stream`] stores at a time.
pub const STREAMED: usize = 16;

/// Writes `values` to `out` past the caches where `out` has as many numbers and starts at a multiple of 16 bytes, and
/// as usual elsewhere. [`finish_streams`] makes the numbers visible to other threads. Panics if the lengths differ
/// otherwise.
#[inline(always)]
pub fn stream(out: &mut [f32], values: &[f32; STREAMED]) {
    #[cfg(target_arch = "x86_64")]
    if out.len() == STREAMED && out.as_ptr().addr().is_multiple_of(16) {
        use std::arch::x86_64::{_mm_loadu_ps, _mm_stream_ps};
        for quarter in (0..STREAMED).step_by(4) {
            // SAFETY: SSE is part of x86-64; `out` has STREAMED numbers and starts at a multiple of 16 bytes.
            #[allow(unsafe_code)]
            unsafe {
                _mm_stream_ps(out.as_mut_ptr().add(quarter), _mm_loadu_ps(values.as_ptr().add(quarter)));
            }
        }
        return;
    }
    out.copy_from_slice(values);
}

/// Makes the numbers that [`stream`] stored visible to other threads.
pub fn finish_streams() {
    #[cfg(target_arch = "x86_64")]
    // SAFETY: SSE is part of x86-64.
    #[allow(unsafe_code)]
    unsafe {
        std::arch::x86_64::_mm_sfence();
    }
}

/// An instruction level.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Level {
    /// What every 64-bit processor of the target has.
    Baseline,
    /// NEON, which every AArch64 processor has.
    Neon,
    /// AVX2, FMA and F16C.
    Avx2,
    /// AVX-512 F, DQ, BW and VL on top of AVX2.
    Avx512,
}

impl Level {
    /// The levels of this architecture and their names, lowest first, as the environment variable `RELIEVO_SIMD` takes
    /// them.
    #[cfg(target_arch = "x86_64")]
    pub const NAMES: [(Level, &'static str); 3] =
        [(Level::Baseline, "baseline"), (Level::Avx2, "avx2"), (Level::Avx512, "avx512")];
    /// The levels of this architecture and their names, lowest first, as the environment variable `RELIEVO_SIMD` takes
    /// them.
    #[cfg(target_arch = "aarch64")]
    pub const NAMES: [(Level, &'static str); 2] = [(Level::Baseline, "baseline"), (Level::Neon, "neon")];
    /// The levels of this architecture and their names, lowest first, as the environment variable `RELIEVO_SIMD` takes
    /// them.
    #[cfg(not(any(target_arch = "x86_64", target_arch = "aarch64")))]
    pub const NAMES: [(Level, &'static str); 1] = [(Level::Baseline, "baseline")];

    /// The name of this level.
    pub fn name(self) -> &'static str {
        match self {
            Level::Baseline => "baseline",
            Level::Neon => "neon",
            Level::Avx2 => "avx2",
            Level::Avx512 => "avx512",
        }
    }

    /// The best level of this processor.
    pub fn best() -> Self {
        #[cfg(target_arch = "x86_64")]
        {
            let avx2 =
                is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma") && is_x86_feature_detected!("f16c");
            let avx512 = is_x86_feature_detected!("avx512f")
                && is_x86_feature_detected!("avx512dq")
                && is_x86_feature_detected!("avx512bw")
                && is_x86_feature_detected!("avx512vl");
            if avx2 && avx512 {
                return Level::Avx512;
            }
            if avx2 {
                return Level::Avx2;
            }
        }
        if cfg!(target_arch = "aarch64") { Level::Neon } else { Level::Baseline }
    }

    /// The level that `RELIEVO_SIMD` names, or the best one.
    ///
    /// # Errors
    /// Fails with `Invalid` if the name is unknown, and with `Unsupported` if the processor lacks the level.
    pub fn detect() -> Result<Self> {
        let Ok(name) = std::env::var("RELIEVO_SIMD") else { return Ok(Self::best()) };
        let best = Self::best();
        let found = Self::NAMES.iter().find(|(_, known)| *known == name);
        match found {
            Some((level, _)) if *level <= best => Ok(*level),
            Some(_) => Err(Error::unsupported(format!("this processor has no {name}"))
                .at("RELIEVO_SIMD")
                .advise(format!("use {} or less", best.name()))),
            None => Err(Error::invalid(format!("unknown instruction level {name:?}"))
                .at("RELIEVO_SIMD")
                .advise(format!("use one of {}", Self::NAMES.map(|(_, name)| name).join(", ")))),
        }
    }
}

/// The one operation in which levels differ.
pub trait Arithmetic: Copy {
    /// `a·b + c`, fused where the level has it.
    fn fma(a: f32, b: f32, c: f32) -> f32;
}

/// [`Level::Baseline`]: multiplies, rounds, adds, rounds.
#[derive(Clone, Copy, Debug)]
pub struct Baseline(pub(crate) ());

/// [`Level::Neon`]: multiplies and adds with one rounding.
#[derive(Clone, Copy, Debug)]
pub struct Neon(pub(crate) ());

/// [`Level::Avx2`]: multiplies and adds with one rounding.
#[derive(Clone, Copy, Debug)]
pub struct Avx2(pub(crate) ());

/// [`Level::Avx512`]: multiplies and adds with one rounding.
#[derive(Clone, Copy, Debug)]
pub struct Avx512(pub(crate) ());

impl Baseline {
    /// The vectors that every processor has.
    pub const VECTORS: Self = Self(());
}

#[cfg(target_arch = "aarch64")]
impl Neon {
    /// The vectors that every processor of the architecture has.
    pub const VECTORS: Self = Self(());
}

impl Arithmetic for Baseline {
    #[inline(always)]
    fn fma(a: f32, b: f32, c: f32) -> f32 {
        a * b + c
    }
}

impl Arithmetic for Neon {
    #[inline(always)]
    fn fma(a: f32, b: f32, c: f32) -> f32 {
        a.mul_add(b, c)
    }
}

impl Arithmetic for Avx2 {
    #[inline(always)]
    fn fma(a: f32, b: f32, c: f32) -> f32 {
        a.mul_add(b, c)
    }
}

impl Arithmetic for Avx512 {
    #[inline(always)]
    fn fma(a: f32, b: f32, c: f32) -> f32 {
        a.mul_add(b, c)
    }
}

/// Defines `fn name(level, arguments…)` that calls `#[inline(always)] fn body<A: Lanes>(vectors: A, arguments…)`
/// compiled for the given level. The macro alone makes `vectors`, so a kernel that has it runs where the processor has
/// the level.
///
/// ```
/// use relievo_core::lanes::Lanes;
/// use relievo_core::simd::Level;
/// #[inline(always)]
/// fn axpy_body<A: Lanes>(_: A, a: f32, x: &[f32], y: &mut [f32]) {
///     for (y, x) in y.iter_mut().zip(x) {
///         *y = A::fma(a, *x, *y);
///     }
/// }
/// relievo_core::dispatch_simd! { fn axpy = axpy_body(a: f32, x: &[f32], y: &mut [f32]) }
/// let mut y = [1.0; 4];
/// axpy(Level::best(), 2.0, &[1.0; 4], &mut y);
/// assert_eq!(y, [3.0; 4]);
/// ```
#[macro_export]
macro_rules! dispatch_simd {
    ($(#[$meta:meta])* $vis:vis fn $name:ident = $body:ident($($arg:ident: $ty:ty),* $(,)?) $(-> $ret:ty)?) => {
        $(#[$meta])*
        #[allow(clippy::too_many_arguments)]
        $vis fn $name(level: $crate::simd::Level, $($arg: $ty),*) $(-> $ret)? {
            // Fuzz targets are compiled for one level, which takes a third of the time.
            #[cfg(all(target_arch = "x86_64", not(fuzzing)))]
            {
                #[target_feature(enable = "avx2,fma,f16c")]
                #[allow(clippy::too_many_arguments)]
                fn avx2($($arg: $ty),*) $(-> $ret)? {
                    // SAFETY: this function is compiled for, and called at, this level alone.
                    #[allow(unsafe_code)]
                    let vectors = unsafe { <$crate::simd::Avx2 as $crate::lanes::Lanes>::assume() };
                    $body(vectors, $($arg),*)
                }
                #[target_feature(enable = "avx2,fma,f16c,avx512f,avx512dq,avx512bw,avx512vl")]
                #[allow(clippy::too_many_arguments)]
                fn avx512($($arg: $ty),*) $(-> $ret)? {
                    // SAFETY: this function is compiled for, and called at, this level alone.
                    #[allow(unsafe_code)]
                    let vectors = unsafe { <$crate::simd::Avx512 as $crate::lanes::Lanes>::assume() };
                    $body(vectors, $($arg),*)
                }
                // A level can be forced but never above what the processor has.
                #[allow(unsafe_code)]
                match level.min($crate::simd::Level::best()) {
                    // SAFETY: `best()` found AVX-512 F, DQ, BW, VL, AVX2, FMA and F16C on this processor.
                    $crate::simd::Level::Avx512 => return unsafe { avx512($($arg),*) },
                    // SAFETY: `best()` found AVX2, FMA and F16C on this processor.
                    $crate::simd::Level::Avx2 => return unsafe { avx2($($arg),*) },
                    $crate::simd::Level::Baseline | $crate::simd::Level::Neon => {}
                }
            }
            // Every processor of this architecture has the level, so that it needs no function of its own.
            #[cfg(all(target_arch = "aarch64", not(fuzzing)))]
            if level > $crate::simd::Level::Baseline {
                return $body($crate::simd::Neon::VECTORS, $($arg),*);
            }
            let _ = level;
            $body($crate::simd::Baseline::VECTORS, $($arg),*)
        }
    };
}
