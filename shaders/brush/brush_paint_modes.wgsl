// import colors
// import brush_stamp
// What a brush makes of colours, given its weights. The same as `mode` of rust/detail.

const PAINT_MIX: u32 = 0u;
const PAINT_ADD: u32 = 1u;
const PAINT_MULTIPLY: u32 = 2u;
const PAINT_ERASE: u32 = 3u;
const PAINT_BLUR: u32 = 4u;
const PAINT_SMEAR: u32 = 5u;

/// A texel's colour: of 8 bits it is the first word.
fn decoded(words: vec2<u32>) -> vec4<f32> {
    return color_of(words, edit_is(WIDE));
}

fn coded(color: vec4<f32>) -> vec2<u32> {
    return words_of(color, edit_is(WIDE));
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
        case PAINT_MIX, PAINT_SMEAR: {
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
