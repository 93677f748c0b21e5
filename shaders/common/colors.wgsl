// import common
// Colours as texels keep them, linear Rec.709 with alpha: of 8 bits sRGB-encoded (IEC 61966-2-1), alpha as it is, in one
// word, or `wide`, of half floats, in two. The same as `texel` of rust/tiles.

const COLOR_MOST: f32 = 65504.0;

fn linear_of(encoded: vec3<f32>) -> vec3<f32> {
    let power = pow((encoded + vec3(0.055)) / 1.055, vec3(2.4));
    return select(power, encoded / 12.92, encoded <= vec3(0.04045));
}

fn encoded_of(linear: vec3<f32>) -> vec3<f32> {
    let power = 1.055 * pow(linear, vec3(1.0 / 2.4)) - vec3(0.055);
    return select(power, 12.92 * linear, linear <= vec3(0.0031308));
}

/// The colour of a texel.
fn color_of(words: vec2<u32>, wide: bool) -> vec4<f32> {
    if wide {
        return vec4(unpack2x16float(words.x), unpack2x16float(words.y));
    }
    let bytes = unpack4x8unorm(words.x);
    return vec4(linear_of(bytes.xyz), bytes.w);
}

/// The words of a colour, the nearest there is.
fn words_of(color: vec4<f32>, wide: bool) -> vec2<u32> {
    // What is not a number becomes 0.
    let known = select(vec4(0.0), color, color == color);
    if wide {
        let held = clamp(known, vec4(-COLOR_MOST), vec4(COLOR_MOST));
        let red = half_bits(held.x) | (half_bits(held.y) << 16u);
        return vec2(red, half_bits(held.z) | (half_bits(held.w) << 16u));
    }
    let held = clamp(known, vec4(0.0), vec4(1.0));
    let bytes = vec4<u32>(vec4(encoded_of(held.xyz), held.w) * 255.0 + vec4(0.5));
    return vec2(bytes.x | (bytes.y << 8u) | (bytes.z << 16u) | (bytes.w << 24u), 0u);
}
