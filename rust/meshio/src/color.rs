//! The transfer curve of sRGB (IEC 61966-2-1), with which colours in whole numbers are encoded.

/// The linear value of an encoded one, both 0 to 1.
pub(crate) fn linear_from_srgb(value: f32) -> f32 {
    if value <= 0.04045 { value / 12.92 } else { ((value + 0.055) / 1.055).powf(2.4) }
}

/// The encoded value of a linear one, both 0 to 1.
pub(crate) fn srgb_from_linear(value: f32) -> f32 {
    if value <= 0.003_130_8 { value * 12.92 } else { 1.055 * value.powf(1.0 / 2.4) - 0.055 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_byte_survives_the_round_trip() {
        for byte in 0..=255u8 {
            let linear = linear_from_srgb(f32::from(byte) / 255.0);
            assert_eq!((srgb_from_linear(linear) * 255.0).round(), f32::from(byte));
        }
        // The middle of the encoded range is about a fifth of the light.
        assert!((linear_from_srgb(0.5) - 0.214_041).abs() < 1e-6);
    }
}
