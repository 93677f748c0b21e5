// import brush_stamp
// What a brush makes of displacement, given its weights. The same as `mode` of rust/detail.

const SCULPT_DRAW: u32 = 0u;
const SCULPT_SMOOTH: u32 = 1u;
const SCULPT_FLATTEN: u32 = 2u;
const SCULPT_ERASE: u32 = 3u;
const SCULPT_CLAY: u32 = 4u;
const SCULPT_SCRAPE: u32 = 5u;
const SCULPT_LAYER: u32 = 6u;
const SCULPT_INFLATE: u32 = 7u;
const SCULPT_PINCH: u32 = 8u;
const SCULPT_VECTOR: u32 = 9u;

// The least cosine that inflating divides by.
const MIN_FACING: f32 = 0.25;

/// The share of the edit and its height with the image of the brush, where neighbours are `footprint` away.
fn sculpt_stamped(place: vec3<f32>, share: f32, footprint: f32) -> vec2<f32> {
    let pixel = stamp_at(place.xy, footprint);
    let channel = u32(stamp[1].z);
    let value = stamp[1].y * (pixel[channel] - stamp[1].x);
    let covered = share * select(pixel.w, 1.0, channel == 3u);
    // Modes without a height are masked by it.
    let mode = work.mode;
    if mode == SCULPT_DRAW || mode == SCULPT_CLAY || mode == SCULPT_LAYER || mode == SCULPT_INFLATE {
        return vec2(covered, work.height * value);
    }
    return vec2(covered * clamp(value, 0.0, 1.0), work.height);
}

/// How far a place that has risen is under the plane `height` over the middle of the box, along its normal; 0 where that
/// does not rise.
fn under(height: f32, level: f32, rise: f32, risen: f32) -> f32 {
    return select(0.0, fma(height, work.unit, -level) / rise - risen, rise > 0.0);
}

fn held(value: f32) -> f32 {
    return clamp(value, -MAX, MAX);
}

struct Sculpted {
    now: f32,
    // How much of it is more than when the stroke began.
    risen: f32,
    // The mean of the neighbours, and the cosine between the normals of the surface and of the displaced one, for the modes
    // that need them.
    mean: f32,
    facing: f32,
}

/// The new coefficient of a place with a share of the edit.
fn sculpted(at: BrushPlace, share: f32, height: f32, it: Sculpted) -> f32 {
    let now = it.now;
    let risen = it.risen;
    let level = at.place.z;
    let rise = at.rises.z;
    switch work.mode {
        case SCULPT_DRAW: {
            return held(fma(height, share, now));
        }
        case SCULPT_SMOOTH: {
            return fma(it.mean - now, share, now);
        }
        case SCULPT_FLATTEN: {
            return held(fma(under(0.0, level, rise, risen), share, now));
        }
        case SCULPT_ERASE: {
            return fma(-now, share, now);
        }
        case SCULPT_CLAY: {
            let far = under(height, level, rise, risen);
            return held(fma(select(max(far, 0.0), min(far, 0.0), height < 0.0), share, now));
        }
        case SCULPT_SCRAPE: {
            return held(fma(min(under(0.0, level, rise, risen), 0.0), share, now));
        }
        case SCULPT_LAYER: {
            let far = fma(height, share, -risen);
            return held(now + select(max(far, 0.0), min(far, 0.0), height < 0.0));
        }
        case SCULPT_INFLATE: {
            return held(fma(height / max(it.facing, MIN_FACING), share, now));
        }
        default: {
            return now;
        }
    }
}
