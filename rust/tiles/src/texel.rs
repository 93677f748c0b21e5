//! What the tiles of a channel hold: half floats for scalar displacement, three of them for vector displacement, four
//! bytes or four half floats for colour.
//!
//! Colours are linear Rec.709 with alpha, as values; [`Rgba8`] keeps them sRGB-encoded (IEC 61966-2-1) and alpha as it
//! is. Neighbours are averaged as values, so colours are mixed in linear light. Units: object units for displacement,
//! none for colour.

use std::fmt::Debug;
use std::iter::Sum;
use std::ops::{Add, Div, Mul, Sub};
use std::sync::LazyLock;

use bytemuck::{Pod, Zeroable};
use glam::{DVec3, DVec4, Vec4};
use half::f16;
use relievo_core::dispatch_simd;
use relievo_core::lanes::Lanes;
use relievo_core::simd::Level;

use crate::quads::frame::Turn;

/// What texels are averaged as: a number, or several that do not know of each other.
pub trait Value:
    Copy
    + Default
    + Debug
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<f64, Output = Self>
    + Div<f64, Output = Self>
    + Sum
    + Send
    + Sync
{
}

impl Value for f64 {}
impl Value for DVec3 {}
impl Value for DVec4 {}

/// One texel of a tile.
pub trait Texel: Pod + PartialEq + Debug + Send + Sync {
    /// What it is averaged as.
    type Value: Value;

    /// Whether it has a direction, so that neighbours, whose frames are turned, see other numbers of it.
    const FRAMED: bool = false;

    /// What the difference of two of it is kept as.
    type Difference: Texel<Value = Self::Value>;

    /// Whether tiles of it keep mips, for look-ups that are filtered.
    const MIPS: bool = false;

    /// Its value.
    fn value(self) -> Self::Value;

    /// The nearest texel to `value`, which is finite: clamped to what a texel can hold.
    fn nearest(value: Self::Value) -> Self;

    /// What a neighbour that is wound the other way sees of it.
    fn flipped(self) -> Self;

    /// The value that a neighbour sees of it, whose frame is turned by `turn`.
    #[inline]
    fn seen(self, turn: Turn) -> Self::Value {
        if turn.flipped { self.flipped().value() } else { self.value() }
    }

    /// The nearest texel to what a neighbour sees of it.
    #[inline]
    fn turned(self, turn: Turn) -> Self {
        if turn.flipped { self.flipped() } else { self }
    }

    /// A value as a neighbour sees it.
    #[inline]
    fn turn_value(value: Self::Value, turn: Turn) -> Self::Value {
        if turn.flipped { Self::flip_value(value) } else { value }
    }

    /// As [`Self::flipped`], of a value.
    fn flip_value(value: Self::Value) -> Self::Value {
        value
    }

    /// The means of two by two texels of the rows `above` and `below`: one for each place of `out`.
    fn shrink(_: Level, above: &[Self], below: &[Self], out: &mut [Self]) {
        for ((out, a), b) in out.iter_mut().zip(above.chunks_exact(2)).zip(below.chunks_exact(2)) {
            *out = Self::nearest((a[0].value() + a[1].value() + (b[0].value() + b[1].value())) * 0.25);
        }
    }

    /// Whether all numbers of `texels` are finite.
    fn all_finite(texels: &[Self]) -> bool;

    /// How far `texels` displace: from the first to the second along the normal, or at most the second in any
    /// direction. Zeros for what displaces nothing.
    fn bound(_: &[Self]) -> [f32; 2] {
        [0.0; 2]
    }

    /// The format that kernels know such texels by, and its numbers; `None` of texels that they do not know.
    fn on_device(self) -> Option<(u32, [f32; 4])> {
        None
    }

    /// Whether two texels are the same, to the bit.
    fn same(self, other: Self) -> bool {
        bytemuck::bytes_of(&self) == bytemuck::bytes_of(&other)
    }

    /// Whether it holds what an unallocated tile reads as. −0 is 0.
    fn is_blank(self, blank: Self) -> bool {
        self == blank
    }
}

impl Texel for f16 {
    type Value = f64;
    type Difference = Self;

    fn on_device(self) -> Option<(u32, [f32; 4])> {
        Some((0, [self.to_f32(), 0.0, 0.0, 0.0]))
    }

    #[inline]
    fn value(self) -> f64 {
        self.to_f64()
    }

    #[inline]
    fn nearest(value: f64) -> Self {
        f16::from_f64(value.clamp(-65504.0, 65504.0))
    }

    /// The other sign, because the normal is the other one.
    #[inline]
    fn flipped(self) -> Self {
        if self.to_bits() & 0x7fff == 0 { self } else { -self }
    }

    #[inline]
    fn flip_value(value: f64) -> f64 {
        -value
    }

    fn all_finite(texels: &[Self]) -> bool {
        texels.chunks(256).all(finite_halves)
    }

    fn bound(texels: &[Self]) -> [f32; 2] {
        // Half floats of one sign are ordered as their bits are.
        let ordered = |c: &f16| {
            let bits = c.to_bits() as i16;
            bits ^ ((bits >> 15) & 0x7fff)
        };
        let value = |ordered: i16| f16::from_bits((ordered ^ ((ordered >> 15) & 0x7fff)) as u16).to_f32();
        let low = texels.iter().map(ordered).fold(i16::MAX, i16::min);
        let high = texels.iter().map(ordered).fold(i16::MIN, i16::max);
        [value(low), value(high)]
    }

    #[inline]
    fn same(self, other: Self) -> bool {
        self.to_bits() == other.to_bits()
    }
}

/// Zero without its sign.
fn unsigned(half: f16) -> f16 {
    if half.to_bits() & 0x7fff == 0 { f16::ZERO } else { half }
}

/// Whether up to 256 half floats are finite. Counted in 16 bits, which compiles to wide comparisons.
fn finite_halves(texels: &[f16]) -> bool {
    texels.iter().map(|c| u16::from(c.to_bits() & 0x7c00 == 0x7c00)).sum::<u16>() == 0
}

/// Vector displacement: B-spline coefficients along the tile's tangent by u, across it, and along the normal, in the
/// orthonormal frame of [`crate::quads::frame`]. Object units.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Vector(pub [f16; 3]);

impl Vector {
    /// No displacement.
    pub const ZERO: Self = Self([f16::ZERO; 3]);
}

impl Texel for Vector {
    type Value = DVec3;
    type Difference = Self;

    const FRAMED: bool = true;

    fn on_device(self) -> Option<(u32, [f32; 4])> {
        let [x, y, z] = self.0.map(f16::to_f32);
        Some((3, [x, y, z, 0.0]))
    }

    #[inline]
    fn value(self) -> DVec3 {
        DVec3::from(self.0.map(f16::to_f64))
    }

    /// Zeros are positive, whatever way they were turned.
    #[inline]
    fn nearest(value: DVec3) -> Self {
        Self(value.to_array().map(|value| unsigned(f16::nearest(value))))
    }

    /// As seen in a frame whose T is the same and whose normal is the other one.
    fn flipped(self) -> Self {
        let [x, y, z] = self.0;
        Self([x, y.flipped(), z.flipped()])
    }

    fn flip_value(value: DVec3) -> DVec3 {
        DVec3::new(value.x, -value.y, -value.z)
    }

    #[inline]
    fn seen(self, turn: Turn) -> DVec3 {
        turn.apply(self.value())
    }

    #[inline]
    fn turned(self, turn: Turn) -> Self {
        Self::nearest(self.seen(turn))
    }

    #[inline]
    fn turn_value(value: DVec3, turn: Turn) -> DVec3 {
        turn.apply(value)
    }

    fn bound(texels: &[Self]) -> [f32; 2] {
        let longest = |longest: [f32; 3], vector: &Self| {
            std::array::from_fn(|axis| longest[axis].max(vector.0[axis].to_f32().abs()))
        };
        let longest = texels.iter().fold([0.0f32; 3], longest);
        [0.0, longest.iter().map(|value| value * value).sum::<f32>().sqrt()]
    }

    fn all_finite(texels: &[Self]) -> bool {
        f16::all_finite(bytemuck::cast_slice(texels))
    }
}

/// A texel that holds a colour.
pub trait ColorTexel: Texel<Value = DVec4> {
    /// The colour: linear Rec.709 and alpha.
    fn color(self) -> Vec4;

    /// Those of four texels.
    fn colors(texels: [Self; 4]) -> [Vec4; 4] {
        texels.map(Self::color)
    }

    /// The nearest texel to a colour, clamped to what it can hold. Numbers that are not a number become 0.
    fn of_color(color: Vec4) -> Self;
}

/// Colour in four bytes: red, green and blue encoded as sRGB, alpha as it is. Values are 0 to 1.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub struct Rgba8(pub [u8; 4]);

/// Colour in four half floats: linear red, green, blue, and alpha. Values may exceed 1.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Rgba16(pub [f16; 4]);

/// The linear value of every sRGB byte.
pub(crate) static LINEAR: LazyLock<[f32; 256]> =
    LazyLock::new(|| std::array::from_fn(|byte| linear(byte as f32 / 255.0)));

/// Bits of a number that are dropped to find its place in [`Bytes::first`]: 128 places per factor of two.
const DROPPED: u32 = 16;
/// 2⁻¹³, below which every value is byte 0.
pub(crate) const DARKEST: u32 = (127 - 13) << 23;

/// From linear values to sRGB bytes without a power: within a place the byte goes up by one at most.
pub(crate) struct Bytes {
    /// The byte of the least value of each place.
    pub first: [u8; 13 * 128],
    /// The least value of each byte.
    pub least: [f32; 257],
}

pub(crate) static BYTES: LazyLock<Bytes> = LazyLock::new(|| {
    let least = std::array::from_fn(|byte| match byte {
        0 => 0.0,
        256 => f32::INFINITY,
        byte => linear((byte as f32 - 0.5) / 255.0),
    });
    let first = std::array::from_fn(|place| {
        let value = f32::from_bits(DARKEST + ((place as u32) << DROPPED));
        (least.partition_point(|least: &f32| *least <= value) - 1) as u8
    });
    Bytes { first, least }
});

/// The linear value of an sRGB-encoded one.
fn linear(encoded: f32) -> f32 {
    if encoded <= 0.04045 { encoded / 12.92 } else { ((encoded + 0.055) / 1.055).powf(2.4) }
}

/// The byte of a linear value from 0 to 1.
#[inline]
fn encoded(bytes: &Bytes, linear: f32) -> u8 {
    let place = linear.to_bits().saturating_sub(DARKEST) >> DROPPED;
    match bytes.first.get(place as usize) {
        Some(byte) => byte + u8::from(linear >= bytes.least[usize::from(*byte) + 1]),
        None => 255,
    }
}

/// Bits of a sum of four numbers from 0 to 65,535.
const FIELD: u32 = 18;

/// Of red, green and blue, the linear value of every sRGB byte in 65,535ths, each in a field of its own: so four texels
/// are added as a whole, and four of one channel make a place in [`MEANS`].
static FIELDS: LazyLock<[[u64; 256]; 3]> = LazyLock::new(|| {
    let whole = LINEAR.map(|value| (65535.0 * value).round() as u64);
    std::array::from_fn(|channel| whole.map(|value| value << (FIELD * channel as u32)))
});

/// The byte of every sum of four numbers of [`FIELDS`], in steps of 16.
static MEANS: LazyLock<[u8; 1 << 14]> =
    LazyLock::new(|| std::array::from_fn(|place| encoded(&BYTES, (16.0 * place as f32 + 8.0) / (4.0 * 65535.0))));

/// What means of [`Rgba8`] go by, for kernels: of every byte its linear value in 65,535ths, and the least place in [`MEANS`]
/// that has it.
pub(crate) fn mean_tables() -> impl Iterator<Item = u32> {
    let values = FIELDS[0].iter().map(|value| *value as u32);
    values.chain((0..=255u8).map(|byte| MEANS.partition_point(|mean| *mean < byte) as u32))
}

impl Texel for Rgba8 {
    type Value = DVec4;
    type Difference = Rgba16;

    const MIPS: bool = true;

    fn on_device(self) -> Option<(u32, [f32; 4])> {
        Some((1, self.value().as_vec4().to_array()))
    }

    fn shrink(_: Level, above: &[Self], below: &[Self], out: &mut [Self]) {
        let (fields, means) = (&*FIELDS, &*MEANS);
        // Alpha has the ten bits that are left.
        let numbers = |Self([r, g, b, a]): Self| {
            let color = fields[0][usize::from(r)] + fields[1][usize::from(g)] + fields[2][usize::from(b)];
            color + (u64::from(a) << (3 * FIELD))
        };
        for ((out, a), b) in out.iter_mut().zip(above.chunks_exact(2)).zip(below.chunks_exact(2)) {
            let sum = numbers(a[0]) + numbers(a[1]) + numbers(b[0]) + numbers(b[1]);
            let color = |channel: u32| means[(sum >> (FIELD * channel + 4)) as usize & 0x3fff];
            let alpha = ((sum >> (3 * FIELD)) + 2) >> 2;
            *out = Self([color(0), color(1), color(2), alpha as u8]);
        }
    }

    #[inline]
    fn same(self, other: Self) -> bool {
        u32::from_ne_bytes(self.0) == u32::from_ne_bytes(other.0)
    }

    fn value(self) -> DVec4 {
        self.color().as_dvec4()
    }

    fn nearest(value: DVec4) -> Self {
        Self::of_color(value.as_vec4())
    }

    fn flipped(self) -> Self {
        self
    }

    fn all_finite(_: &[Self]) -> bool {
        true
    }
}

/// Every byte in 255ths.
static PARTS: [f32; 256] = {
    let mut parts = [0.0; 256];
    let mut byte = 0;
    while byte < 256 {
        parts[byte] = byte as f32 / 255.0;
        byte += 1;
    }
    parts
};

#[inline(always)]
fn decoded(linear: &[f32; 256], Rgba8([r, g, b, a]): Rgba8) -> Vec4 {
    // A table for alpha too: the conversion from an integer waits for what was in its register.
    Vec4::new(linear[usize::from(r)], linear[usize::from(g)], linear[usize::from(b)], PARTS[usize::from(a)])
}

impl ColorTexel for Rgba8 {
    #[inline]
    fn color(self) -> Vec4 {
        decoded(&LINEAR, self)
    }

    #[inline(always)]
    fn colors([a, b, c, d]: [Self; 4]) -> [Vec4; 4] {
        // The table is looked for once.
        let linear = &*LINEAR;
        [decoded(linear, a), decoded(linear, b), decoded(linear, c), decoded(linear, d)]
    }

    #[inline]
    fn of_color(color: Vec4) -> Self {
        // A maximum with a number that is not one is the other.
        let [r, g, b, a] = color.to_array().map(|value| value.max(0.0).min(1.0));
        let bytes = &*BYTES;
        Self([encoded(bytes, r), encoded(bytes, g), encoded(bytes, b), (255.0 * a + 0.5) as u8])
    }
}

impl Texel for Rgba16 {
    type Value = DVec4;
    type Difference = Self;

    const MIPS: bool = true;

    fn on_device(self) -> Option<(u32, [f32; 4])> {
        Some((2, self.value().as_vec4().to_array()))
    }

    fn shrink(level: Level, above: &[Self], below: &[Self], out: &mut [Self]) {
        let [above, below] = [above, below].map(bytemuck::cast_slice);
        shrink_halves(level, above, below, bytemuck::cast_slice_mut(out));
    }

    fn value(self) -> DVec4 {
        DVec4::from(self.0.map(f16::to_f64))
    }

    fn nearest(value: DVec4) -> Self {
        Self(value.to_array().map(f16::nearest))
    }

    fn flipped(self) -> Self {
        self
    }

    fn all_finite(texels: &[Self]) -> bool {
        f16::all_finite(bytemuck::cast_slice(texels))
    }
}

dispatch_simd! {
    /// The means of two by two texels of four numbers.
    fn shrink_halves = shrink_halves_body(above: &[f16], below: &[f16], out: &mut [f16])
}

#[inline(always)]
fn shrink_halves_body<A: Lanes>(v: A, above: &[f16], below: &[f16], out: &mut [f16]) {
    /// Numbers of a row at a time.
    const RUN: usize = 128;
    let (mut a, mut b, mut means) = ([0f32; RUN], [0f32; RUN], [0f32; RUN / 2]);
    for ((out, above), below) in out.chunks_mut(RUN / 2).zip(above.chunks(RUN)).zip(below.chunks(RUN)) {
        v.widen_all(above, &mut a[..above.len()]);
        v.widen_all(below, &mut b[..below.len()]);
        for ((mean, a), b) in means.chunks_exact_mut(4).zip(a.chunks_exact(8)).zip(b.chunks_exact(8)) {
            (0..4).for_each(|k| mean[k] = 0.25 * ((a[k] + a[k + 4]) + (b[k] + b[k + 4])));
        }
        v.narrow_all(&means, out);
    }
}

impl ColorTexel for Rgba16 {
    #[inline]
    fn color(self) -> Vec4 {
        Vec4::from(self.0.map(f16::to_f32))
    }

    #[inline]
    fn of_color(color: Vec4) -> Self {
        let held = |value: f32| if value.is_nan() { 0.0 } else { value.clamp(-65504.0, 65504.0) };
        Self(color.to_array().map(|value| f16::from_f32(held(value))))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texels_have_the_bytes_they_say_and_survive_their_value() {
        assert_eq!([size_of::<f16>(), size_of::<Vector>(), size_of::<Rgba8>(), size_of::<Rgba16>()], [2, 6, 4, 8]);
        for byte in 0..=255u8 {
            let texel = Rgba8([byte, 255 - byte, byte ^ 0x55, byte]);
            assert_eq!(Rgba8::nearest(texel.value()), texel);
            // So that averages of equal corners do not drift.
            assert_eq!(Rgba8::nearest((0..5).map(|_| texel.value()).sum::<DVec4>() / 5.0), texel);
        }
        let texel = Rgba16([0.5, -3.25, 100.0, 1.0].map(f16::from_f32));
        assert_eq!(Rgba16::nearest(texel.value()), texel);
    }

    #[test]
    fn colours_that_cannot_be_held_are_clamped() {
        assert_eq!(Rgba8::of_color(Vec4::new(f32::NAN, -1.0, f32::INFINITY, 2.0)), Rgba8([0, 0, 255, 255]));
        let texel = Rgba16::of_color(Vec4::new(f32::NAN, f32::INFINITY, 1e9, -1e9));
        assert!(Rgba16::all_finite(&[texel]));
        assert!(!Rgba16::all_finite(&[Rgba16([f16::ZERO, f16::NAN, f16::ONE, f16::ONE])]));
        assert!(!f16::all_finite(&[f16::INFINITY]) && f16::all_finite(&[f16::MAX; 1000]));
    }

    #[test]
    fn bytes_from_the_table_are_those_of_the_curve() {
        for k in 0..=1_000_000u32 {
            let value = (k as f32 * 1e-6).powi(2);
            let curve = if value <= 0.003_130_8 { 12.92 * value } else { 1.055 * value.powf(1.0 / 2.4) - 0.055 };
            let found = f32::from(encoded(&BYTES, value));
            // Half way between two bytes rounding decides.
            assert!((found - 255.0 * curve).abs() <= 0.5 + 1e-3, "{value}: {found} {}", 255.0 * curve);
        }
        assert_eq!((encoded(&BYTES, 0.0), encoded(&BYTES, 1.0), encoded(&BYTES, 1e-30)), (0, 255, 0));
    }

    #[test]
    fn means_are_those_of_values_and_equal_texels_stay() {
        for byte in 0..=255u8 {
            let texels = [Rgba8([byte, 255 - byte, byte / 2, byte]); 2];
            let mut out = [Rgba8::default()];
            Rgba8::shrink(Level::Baseline, &texels, &texels, &mut out);
            assert_eq!(out[0], texels[0]);
            let (above, below) = ([texels[0], Rgba8([7, 90, 255, 0])], [Rgba8([200, byte, 3, 9]), Rgba8([0; 4])]);
            Rgba8::shrink(Level::Baseline, &above, &below, &mut out);
            let mean = (above[0].value() + above[1].value() + below[0].value() + below[1].value()) / 4.0;
            let exact = Rgba8::nearest(mean);
            assert!((0..4).all(|k| exact.0[k].abs_diff(out[0].0[k]) <= 1), "{exact:?} {out:?}");
        }
        let row = |start: usize| -> Vec<Rgba16> {
            (0..70).map(|k| Rgba16([start + k, 2 * k, 5, 1].map(|value| f16::from_f32(value as f32)))).collect()
        };
        for (level, name) in Level::NAMES {
            let mut out = vec![Rgba16::default(); 35];
            Rgba16::shrink(level, &row(0), &row(4), &mut out);
            for (k, texel) in out.iter().enumerate() {
                let expected = [2 * k as i32 * 2 + 5, 8 * k as i32 + 2, 10, 2].map(|n| n as f32 / 2.0);
                assert_eq!(texel.0.map(f16::to_f32), expected, "{name}");
            }
        }
    }

    #[test]
    fn middle_grey_is_encoded_as_srgb() {
        assert_eq!(Rgba8::of_color(Vec4::new(0.214_041_14, 0.0, 1.0, 0.5)), Rgba8([128, 0, 255, 128]));
    }
}
