// import brush_stamp
// What a brush makes of colours, given its weights. The same as `mode` of rust/detail. Colours are linear Rec.709 with
// alpha; of 8 bits they are kept sRGB-encoded (IEC 61966-2-1), alpha as it is.

const PAINT_MIX: u32 = 0u;
const PAINT_ADD: u32 = 1u;
const PAINT_MULTIPLY: u32 = 2u;
const PAINT_ERASE: u32 = 3u;
const PAINT_BLUR: u32 = 4u;

fn linear_of(encoded: vec3<f32>) -> vec3<f32> {
    let power = pow((encoded + vec3(0.055)) / 1.055, vec3(2.4));
    return select(power, encoded / 12.92, encoded <= vec3(0.04045));
}

fn encoded_of(linear: vec3<f32>) -> vec3<f32> {
    let power = 1.055 * pow(linear, vec3(1.0 / 2.4)) - vec3(0.055);
    return select(power, 12.92 * linear, linear <= vec3(0.0031308));
}

/// A texel's colour: of 8 bits it is the first word.
fn decoded(words: vec2<u32>) -> vec4<f32> {
    if edit_is(WIDE) {
        return vec4(unpack2x16float(words.x), unpack2x16float(words.y));
    }
    let bytes = unpack4x8unorm(words.x);
    return vec4(linear_of(bytes.xyz), bytes.w);
}

fn coded(color: vec4<f32>) -> vec2<u32> {
    // What is not a number becomes 0.
    let known = select(vec4(0.0), color, color == color);
    if edit_is(WIDE) {
        let held = clamp(known, vec4(-MOST), vec4(MOST));
        let red = half_bits(held.x) | (half_bits(held.y) << 16u);
        return vec2(red, half_bits(held.z) | (half_bits(held.w) << 16u));
    }
    let held = clamp(known, vec4(0.0), vec4(1.0));
    let bytes = vec4<u32>(vec4(encoded_of(held.xyz), held.w) * 255.0 + vec4(0.5));
    return vec2(bytes.x | (bytes.y << 8u) | (bytes.z << 16u) | (bytes.w << 24u), 0u);
}

/// What the brush paints with, and the share of the edit.
struct Tint {
    color: vec4<f32>,
    share: f32,
}

/// The brush with its image, where neighbours are `footprint` away.
fn paint_stamped(place: vec3<f32>, share: f32, footprint: f32) -> Tint {
    let pixel = stamp_at(place.xy, footprint);
    return Tint(work.color * vec4(pixel.xyz, 1.0), share * pixel.w);
}

/// The new colour of a place with a share of the edit; `mean` is that of the neighbours, for the mode that needs it.
fn painted(tint: Tint, now: vec4<f32>, mean: vec4<f32>) -> vec4<f32> {
    let share = tint.share;
    switch work.mode {
        case PAINT_MIX: {
            return fma(tint.color - now, vec4(share), now);
        }
        case PAINT_ADD: {
            return vec4(fma(tint.color.xyz, vec3(share), now.xyz), now.w);
        }
        case PAINT_MULTIPLY: {
            return vec4(now.xyz * fma(tint.color.xyz - vec3(1.0), vec3(share), vec3(1.0)), now.w);
        }
        case PAINT_ERASE: {
            return fma(work.blank - now, vec4(share), now);
        }
        case PAINT_BLUR: {
            return fma(mean - now, vec4(share), now);
        }
        default: {
            return now;
        }
    }
}
