//! Colours of many texels at once, channel by channel: to linear numbers and back.
//!
//! Exactly what [`ColorTexel::color`] and [`ColorTexel::of_color`] say of one texel. For bytes the sRGB curve is a
//! table both ways (IEC 61966-2-1), looked up side by side. On the way back a table entry covers the numbers that share
//! their upper 16 bits: within it the byte goes up by one at most, where the lower 16 bits pass a threshold, so that
//! one addition carries into it. Units: linear Rec.709 and alpha, 0 to 1.

use std::sync::LazyLock;

use half::f16;
use relievo_core::dispatch_simd;
use relievo_core::lanes::Lanes;
use relievo_core::simd::Level;

use crate::texel::{BYTES, Bytes, ColorTexel, DARKEST, LINEAR, Rgba8, Rgba16};

/// Texels at a time.
pub const PLANE: usize = 256;
/// Red, green, blue and alpha of as many texels.
pub type Planes = [[f32; PLANE]; 4];

/// Texels whose colours are read and written many at a time.
pub trait ColorPlanes: ColorTexel {
    /// The colours of up to 256 texels.
    ///
    /// # Panics
    /// If there are more.
    fn read(level: Level, texels: &[Self], colors: &mut Planes);

    /// Makes up to 256 texels of their colours.
    ///
    /// # Panics
    /// If there are more.
    fn write(level: Level, colors: &Planes, texels: &mut [Self]);
}

impl ColorPlanes for Rgba16 {
    fn read(level: Level, texels: &[Self], colors: &mut Planes) {
        part(level, bytemuck::cast_slice(texels), colors);
    }

    fn write(level: Level, colors: &Planes, texels: &mut [Self]) {
        join(level, colors, bytemuck::cast_slice_mut(texels));
    }
}

dispatch_simd! {
    /// Four numbers a texel to four planes.
    fn part = part_body(halves: &[f16], colors: &mut Planes)
}

#[inline(always)]
fn part_body<A: Lanes>(v: A, halves: &[f16], colors: &mut Planes) {
    let mut numbers = [0.0; 4 * PLANE];
    v.widen_all(halves, &mut numbers[..halves.len()]);
    for k in 0..PLANE {
        for channel in 0..4 {
            colors[channel][k] = numbers[4 * k + channel];
        }
    }
}

dispatch_simd! {
    /// Four planes to four numbers a texel that half floats can hold.
    fn join = join_body(colors: &Planes, halves: &mut [f16])
}

#[inline(always)]
fn join_body<A: Lanes>(v: A, colors: &Planes, halves: &mut [f16]) {
    let mut numbers = [0.0; 4 * PLANE];
    for k in 0..PLANE {
        for channel in 0..4 {
            let value = colors[channel][k];
            numbers[4 * k + channel] = if value.is_nan() { 0.0 } else { value.clamp(-65504.0, 65504.0) };
        }
    }
    v.narrow_all(&numbers, halves);
}

impl ColorPlanes for Rgba8 {
    fn read(level: Level, texels: &[Self], colors: &mut Planes) {
        let mut packed = [0u32; PLANE];
        bytemuck::cast_slice_mut::<u32, u8>(&mut packed[..texels.len()]).copy_from_slice(bytemuck::cast_slice(texels));
        unpack(level, &*LINEAR_BITS, &packed, colors);
    }

    fn write(level: Level, colors: &Planes, texels: &mut [Self]) {
        let mut packed = [0u32; PLANE];
        pack(level, &STEPS, colors, &mut packed);
        let bytes = bytemuck::cast_slice_mut::<Self, u8>(texels);
        bytes.copy_from_slice(&bytemuck::cast_slice(&packed)[..bytes.len()]);
    }
}

/// The bits of the linear value of every byte.
static LINEAR_BITS: LazyLock<[u32; 256]> = LazyLock::new(|| LINEAR.map(f32::to_bits));

/// By the upper 16 bits of a number, from [`DARKEST`] to 1: the byte in the upper half, less what the lower bits must
/// reach for the next one in the lower.
static STEPS: LazyLock<Vec<u32>> = LazyLock::new(|| {
    let Bytes { first, least } = &*BYTES;
    let step = |(place, byte): (u32, &u8)| {
        let start = DARKEST + (place << 16);
        let next = least[usize::from(*byte) + 1].to_bits();
        u32::from(*byte) << 16 | (0x1_0000 - next.saturating_sub(start).min(0x1_0000))
    };
    (0..).zip(first).map(step).chain([255 << 16]).collect()
});

dispatch_simd! {
    fn unpack = unpack_body(linear: &[u32], packed: &[u32; PLANE], colors: &mut Planes)
}

#[inline(always)]
fn unpack_body<A: Lanes>(v: A, linear: &[u32], packed: &[u32; PLANE], colors: &mut Planes) {
    let (byte, shift) = (v.isplat(255), v.isplat(256));
    let [red, green, blue, alpha] = colors;
    let scale = v.splat(255.0);
    for at in (0..PLANE).step_by(A::WIDTH) {
        let low = v.iload(&packed[at..]);
        let high = v.high(low);
        let second = v.iand(v.high(v.imul(low, shift)), byte);
        let third = v.iand(high, byte);
        let last = v.high(v.imul(high, shift));
        v.istore(v.gather(linear, v.iand(low, byte)), bytemuck::cast_slice_mut(&mut red[at..at + A::WIDTH]));
        v.istore(v.gather(linear, second), bytemuck::cast_slice_mut(&mut green[at..at + A::WIDTH]));
        v.istore(v.gather(linear, third), bytemuck::cast_slice_mut(&mut blue[at..at + A::WIDTH]));
        v.store(v.div(v.float(last), scale), &mut alpha[at..]);
    }
}

dispatch_simd! {
    fn pack = pack_body(steps: &[u32], colors: &Planes, packed: &mut [u32; PLANE])
}

#[inline(always)]
fn pack_body<A: Lanes>(v: A, steps: &[u32], colors: &Planes, packed: &mut [u32; PLANE]) {
    let (none, one, half, scale) = (v.splat(0.0), v.splat(1.0), v.splat(0.5), v.splat(255.0));
    let (darkest, lower, shift) = (v.isplat(DARKEST as i32), v.isplat(0xffff), v.isplat(256));
    for at in (0..PLANE).step_by(A::WIDTH) {
        let mut word = v.isplat(0);
        // What is not a number becomes 0.
        let alpha = v.min(v.max(v.load(&colors[3][at..]), none), one);
        word = v.iadd(word, v.trunc(v.add(v.mul(alpha, scale), half)));
        for channel in [2, 1, 0] {
            let value = v.min(v.max(v.load(&colors[channel][at..]), none), one);
            let above = v.isub(v.imax(v.bits(value), darkest), darkest);
            let step = v.gather(steps, v.high(above));
            let byte = v.high(v.iadd(step, v.iand(above, lower)));
            word = v.iadd(v.imul(word, shift), byte);
        }
        v.istore(word, &mut packed[at..]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec4;

    #[test]
    fn planes_are_the_colours_of_single_texels_at_every_level() {
        let texels: Vec<Rgba8> =
            (0..PLANE as u32).map(|k| Rgba8([k, k * 7 + 3, 255 - k, k * 31 + 1].map(|byte| byte as u8))).collect();
        for (level, name) in Level::NAMES {
            for count in [PLANE, 64, 5] {
                let mut colors: Planes = [[9.0; PLANE]; 4];
                Rgba8::read(level, &texels[..count], &mut colors);
                for (k, texel) in texels[..count].iter().enumerate() {
                    assert_eq!(texel.color().to_array(), [0, 1, 2, 3].map(|c: usize| colors[c][k]), "{name} {k}");
                }
                let mut back = vec![Rgba8::default(); count];
                Rgba8::write(level, &colors, &mut back);
                assert_eq!(back, texels[..count], "{name}");
            }
        }
        let wide: Vec<Rgba16> =
            (0..64).map(|k| Rgba16([0.1, 3.0, -1.0, 0.5].map(|x| f16::from_f32(x * k as f32)))).collect();
        let mut colors: Planes = [[0.0; PLANE]; 4];
        Rgba16::read(Level::Baseline, &wide, &mut colors);
        let mut back = vec![Rgba16::default(); 64];
        Rgba16::write(Level::Baseline, &colors, &mut back);
        assert_eq!(back, wide);
    }

    #[test]
    fn numbers_round_as_those_of_single_texels_whatever_they_are() {
        let odd = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -0.0, 1e-30, 1.0, 2.0, 0.999_999_94];
        let values = |first: u32| -> [f32; PLANE] {
            std::array::from_fn(|k| {
                odd.get(k).copied().filter(|_| first == 0).unwrap_or((first * 256 + k as u32) as f32 * 1e-5)
            })
        };
        for (level, name) in Level::NAMES {
            for first in 0..400 {
                let red = values(first);
                let colors = [red, red.map(|x| x * x), red.map(|x| 1.0 - x), red];
                let mut found = vec![Rgba8::default(); PLANE];
                Rgba8::write(level, &colors, &mut found);
                for (k, found) in found.into_iter().enumerate() {
                    let color = Vec4::from([0, 1, 2, 3].map(|channel: usize| colors[channel][k]));
                    assert_eq!(found, Rgba8::of_color(color), "{name} {color}");
                }
            }
        }
    }
}
