//! Reductions of faces to half as many texels along u and v, and their means.
//!
//! Texels of files with an alpha channel are multiplied by it before they are averaged, and reductions are stored so.
//! The channels it covers are those in front of it, or all others where it is the first.

use half::f16;

use crate::format::{DataType, Format, MeshType, Resolution};

/// A number of a texel.
trait Number {
    const SIZE: usize;
    /// What stands for 1.
    const ONE: f64;
    fn load(bytes: &[u8]) -> f64;
    fn store(value: f64, bytes: &mut [u8]);
}

impl Number for u8 {
    const SIZE: usize = 1;
    const ONE: f64 = 255.0;

    fn load(bytes: &[u8]) -> f64 {
        f64::from(bytes[0])
    }

    fn store(value: f64, bytes: &mut [u8]) {
        bytes[0] = value.round() as u8;
    }
}

impl Number for u16 {
    const SIZE: usize = 2;
    const ONE: f64 = 65535.0;

    fn load(bytes: &[u8]) -> f64 {
        f64::from(u16::from_le_bytes([bytes[0], bytes[1]]))
    }

    fn store(value: f64, bytes: &mut [u8]) {
        bytes.copy_from_slice(&(value.round() as u16).to_le_bytes());
    }
}

impl Number for f16 {
    const SIZE: usize = 2;
    const ONE: f64 = 1.0;

    fn load(bytes: &[u8]) -> f64 {
        f16::from_le_bytes([bytes[0], bytes[1]]).to_f64()
    }

    fn store(value: f64, bytes: &mut [u8]) {
        bytes.copy_from_slice(&f16::from_f64(value).to_le_bytes());
    }
}

impl Number for f32 {
    const SIZE: usize = 4;
    const ONE: f64 = 1.0;

    fn load(bytes: &[u8]) -> f64 {
        f64::from(f32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]))
    }

    fn store(value: f64, bytes: &mut [u8]) {
        bytes.copy_from_slice(&(value as f32).to_le_bytes());
    }
}

/// Calls a function that is generic in the type of numbers.
macro_rules! typed {
    ($data_type:expr, $function:ident($($argument:expr),*)) => {
        match $data_type {
            DataType::U8 => $function::<u8>($($argument),*),
            DataType::U16 => $function::<u16>($($argument),*),
            DataType::F16 => $function::<f16>($($argument),*),
            DataType::F32 => $function::<f32>($($argument),*),
        }
    };
}

/// Texels with half as many along u and v, rounded to the nearest; `None` where there is only one along either.
pub(crate) fn halve(texels: &[u8], format: &Format, resolution: Resolution) -> Option<(Resolution, Vec<u8>)> {
    let smaller = resolution.halved(1)?;
    Some((smaller, typed!(format.data_type, halve_numbers(texels, format, resolution, smaller))))
}

fn halve_numbers<T: Number>(texels: &[u8], format: &Format, resolution: Resolution, smaller: Resolution) -> Vec<u8> {
    let texel = format.texel_size();
    let width = resolution.width();
    let mut out = vec![0; smaller.texels() as usize * texel];
    for (row, to) in out.chunks_exact_mut(smaller.width() * texel).enumerate() {
        for (column, to) in to.chunks_exact_mut(texel).enumerate() {
            let (u, v) = (2 * column, 2 * row);
            // The middle one of four triangles stands on its side: it is folded in from the far corner.
            let last = match format.mesh {
                MeshType::Quad => (u + 1, v + 1),
                MeshType::Triangle => (width - 1 - v, width - 1 - u),
            };
            let parts =
                [(u, v), (u + 1, v), (u, v + 1), last].map(|(u, v)| &texels[(v * width + u) * texel..][..texel]);
            for (channel, to) in to.chunks_exact_mut(T::SIZE).enumerate() {
                let sum: f64 = parts.iter().map(|part| T::load(&part[channel * T::SIZE..])).sum();
                T::store(sum / 4.0, to);
            }
        }
    }
    out
}

/// The channels that alpha covers.
fn covered(format: &Format, alpha: u16) -> std::ops::Range<usize> {
    if alpha == 0 { 1..usize::from(format.channels) } else { 0..usize::from(alpha) }
}

/// Multiplies colours by alpha, if there is an alpha channel.
pub(crate) fn premultiply(texels: &mut [u8], format: &Format) {
    if let Some(alpha) = format.alpha {
        typed!(format.data_type, scale_numbers(texels, format, alpha, |alpha| alpha));
    }
}

/// Divides colours by alpha, if there is an alpha channel, except where it is 0.
fn unmultiply(texels: &mut [u8], format: &Format) {
    if let Some(alpha) = format.alpha {
        typed!(
            format.data_type,
            scale_numbers(texels, format, alpha, |alpha| if alpha == 0.0 { 1.0 } else { 1.0 / alpha })
        );
    }
}

fn scale_numbers<T: Number>(texels: &mut [u8], format: &Format, alpha: u16, scale: impl Fn(f64) -> f64) {
    let channels = covered(format, alpha);
    for texel in texels.chunks_exact_mut(format.texel_size()) {
        let scale = scale(T::load(&texel[usize::from(alpha) * T::SIZE..]) / T::ONE);
        for value in texel[channels.start * T::SIZE..channels.end * T::SIZE].chunks_exact_mut(T::SIZE) {
            T::store(T::load(value) * scale, value);
        }
    }
}

/// The mean of texels that are multiplied by alpha, divided by it again.
pub(crate) fn mean(premultiplied: &[u8], format: &Format) -> Vec<u8> {
    let mut mean = typed!(format.data_type, mean_of_numbers(premultiplied, format));
    unmultiply(&mut mean, format);
    mean
}

fn mean_of_numbers<T: Number>(texels: &[u8], format: &Format) -> Vec<u8> {
    let mut sums = vec![0.0; usize::from(format.channels)];
    for texel in texels.chunks_exact(format.texel_size()) {
        for (sum, value) in sums.iter_mut().zip(texel.chunks_exact(T::SIZE)) {
            *sum += T::load(value);
        }
    }
    let count = (texels.len() / format.texel_size()).max(1) as f64;
    let mut out = vec![0; format.texel_size()];
    for (to, sum) in out.chunks_exact_mut(T::SIZE).zip(sums) {
        T::store(sum / count, to);
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    fn format(mesh: MeshType, data_type: DataType, channels: u16, alpha: Option<u16>) -> Format {
        Format { mesh, data_type, channels, alpha }
    }

    #[test]
    fn a_quad_is_halved_in_blocks_and_rounded_to_the_nearest() {
        let bytes = format(MeshType::Quad, DataType::U8, 1, None);
        let (smaller, texels) = halve(&[0, 1, 10, 20, 1, 1, 30, 43], &bytes, Resolution::new(2, 1)).unwrap();
        assert_eq!((smaller, texels.as_slice()), (Resolution::new(1, 0), [1, 26].as_slice()));
        assert!(halve(&[1, 2], &bytes, Resolution::new(1, 0)).is_none());
        for data_type in [DataType::U16, DataType::F16, DataType::F32] {
            let format = format(MeshType::Quad, data_type, 2, None);
            let values = [0.25, 0.5, 0.75, 1.0, 0.0, 0.5, 1.0, 0.0].map(|value: f32| value);
            let (_, texels) = halve(&data_type.encode(&values), &format, Resolution::new(1, 1)).unwrap();
            let close = data_type.decode(&texels);
            assert!((close[0] - 0.5).abs() < 1e-4 && (close[1] - 0.5).abs() < 1e-4, "{close:?}");
        }
    }

    /// A linear function over the triangle is reduced to itself: every coarse texel's value is that at its centre.
    #[test]
    fn a_triangle_is_halved_as_triangles() {
        let linear = |resolution: Resolution| {
            let n = resolution.width() as f32;
            let mut values = Vec::new();
            for v in 0..resolution.height() {
                for u in 0..resolution.width() {
                    let (u, v) = (u as f32, v as f32);
                    // Upright texels have their centre a third from their corner; the others are folded in.
                    let (u, v) =
                        if u + v < n { (u + 1.0 / 3.0, v + 1.0 / 3.0) } else { (n - 1.0 / 3.0 - v, n - 1.0 / 3.0 - u) };
                    values.push(3.0 * u / n - 2.0 * v / n + 0.5);
                }
            }
            values
        };
        let format = format(MeshType::Triangle, DataType::F32, 1, None);
        for power in 1..5 {
            let resolution = Resolution::new(power, power);
            let texels = DataType::F32.encode(&linear(resolution));
            let (smaller, reduced) = halve(&texels, &format, resolution).unwrap();
            for (found, expected) in DataType::F32.decode(&reduced).iter().zip(linear(smaller)) {
                assert!((found - expected).abs() < 1e-5, "{found} is not {expected}");
            }
        }
    }

    #[test]
    fn means_are_weighted_by_alpha() {
        for (alpha, texels) in [(2, [200u8, 100, 255, 0, 0, 0]), (0, [255, 200, 100, 0, 0, 0])] {
            let format = format(MeshType::Quad, DataType::U8, 3, Some(alpha));
            let mut premultiplied = texels.to_vec();
            premultiply(&mut premultiplied, &format);
            assert_eq!(premultiplied, texels);
            // The transparent texel has no colour to add: half the coverage, all of the colour.
            let expected = if alpha == 0 { [128, 199, 100] } else { [199, 100, 128] };
            assert_eq!(mean(&premultiplied, &format), expected);
        }
        let format = format(MeshType::Quad, DataType::F32, 2, Some(1));
        let mut texels = DataType::F32.encode(&[8.0, 0.25]);
        premultiply(&mut texels, &format);
        assert_eq!(DataType::F32.decode(&texels), [2.0, 0.25]);
        assert_eq!(DataType::F32.decode(&mean(&texels, &format)), [8.0, 0.25]);
    }
}
