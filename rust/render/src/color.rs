//! Colour: the sRGB transfer curve of IEC 61966-2-1 and palettes that colour-blind readers can tell apart.
//!
//! Colours are scene-linear Rec.709 triples unless a name says otherwise.

/// A scene-linear Rec.709 colour.
pub type Color = [f32; 3];

/// The sRGB-encoded value in 0..=1 of a linear one. Values outside are clamped, NaN becomes 0.
pub fn encode_srgb(linear: f32) -> f32 {
    let linear = if linear > 0.0 { linear.min(1.0) } else { 0.0 };
    if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
}

/// The linear value of an sRGB-encoded one in 0..=1.
pub fn decode_srgb(encoded: f32) -> f32 {
    if encoded <= 0.040_45 { encoded / 12.92 } else { ((encoded + 0.055) / 1.055).powf(2.4) }
}

/// The byte of a linear value, sRGB-encoded.
pub fn srgb_byte(linear: f32) -> u8 {
    (encode_srgb(linear) * 255.0 + 0.5) as u8
}

/// The linear colour of three sRGB bytes, `0xRRGGBB`.
pub fn from_hex(hex: u32) -> Color {
    [16, 8, 0].map(|shift| decode_srgb((hex >> shift & 0xFF) as f32 / 255.0))
}

/// Relative luminance of a linear colour.
pub fn luminance(color: Color) -> f32 {
    0.2126 * color[0] + 0.7152 * color[1] + 0.0722 * color[2]
}

/// Seven distinct colours and a grey, after Okabe and Ito 2008, "Color Universal Design".
pub fn categories() -> [Color; 8] {
    [0xBBBBBB, 0xE69F00, 0x56B4E9, 0x009E73, 0xF0E442, 0x0072B2, 0xD55E00, 0xCC79A7].map(from_hex)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_byte_survives_decoding_and_encoding() {
        for byte in 0..=255u8 {
            assert_eq!(srgb_byte(decode_srgb(f32::from(byte) / 255.0)), byte);
        }
        assert_eq!((srgb_byte(f32::NAN), srgb_byte(-1.0), srgb_byte(f32::INFINITY)), (0, 0, 255));
        assert!((encode_srgb(0.214_041_14) - 0.5).abs() < 1e-6);
    }

    #[test]
    fn categories_differ_in_luminance_or_hue_for_everyone() {
        // A dichromat of the red-green kinds keeps luminance and the blue-yellow difference.
        let kept = categories().map(|color| {
            let yellow = 0.7 * color[1] + 0.3 * color[0];
            (encode_srgb(luminance(color)), encode_srgb(color[2]) - encode_srgb(yellow))
        });
        for (index, a) in kept.iter().enumerate() {
            for b in &kept[..index] {
                assert!((a.0 - b.0).abs() + (a.1 - b.1).abs() > 0.08, "{a:?} {b:?}");
            }
        }
    }
}
