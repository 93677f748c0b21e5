// import brush_edit
// The image of a brush, filtered between two of its reductions (Williams 1983, *Pyramidal Parametrics*). The same as
// `stamp` of rust/detail.

// How it lies in the box: cosine and sine of its angle, repeats, and bits; the number that means no height, how many one
// more is, the channel of heights, and how many reductions there are. Then of each of those the first pixel, width and
// height; then pixels, multiplied by alpha.
@group(0) @binding(6) var<storage, read> stamp: array<vec4<f32>>;

const STAMP_MIRROR: u32 = 1u;
const STAMP_ALTERNATE: u32 = 2u;
const STAMP_HEAD: u32 = 2u;

fn stamp_is(bit: u32) -> bool {
    return (u32(stamp[0].w) & bit) != 0u;
}

/// Which pixel of `size` a whole number means; negative for none.
fn stamp_address(k: i32, size: i32) -> i32 {
    let at = ((k % size) + size) % size;
    let turn = (k - at) / size;
    if stamp[0].z <= 1.0 && turn != 0 {
        return -1;
    }
    return select(at, size - 1 - at, stamp_is(STAMP_ALTERNATE) && turn % 2 != 0);
}

/// Whether a whole number means a pixel that is mirrored.
fn stamp_turns(k: i32, size: i32) -> bool {
    let at = ((k % size) + size) % size;
    return stamp_is(STAMP_ALTERNATE) && ((k - at) / size) % 2 != 0;
}

/// Bilinear in a reduction. In a mirrored pixel of `vectors` the first number counts the other way across, the second
/// down.
fn stamp_bilinear(reduction: u32, st: vec2<f32>, vectors: bool) -> vec4<f32> {
    let level = stamp[STAMP_HEAD + reduction];
    let size = vec2<i32>(level.yz);
    let place = st * level.yz - vec2(0.5);
    let low = floor(place);
    let part = place - low;
    var sum = vec4(0.0);
    for (var k = 0; k < 4; k++) {
        let step = vec2(k & 1, k >> 1u);
        let whole = vec2<i32>(low) + step;
        let i = stamp_address(whole.x, size.x);
        let j = stamp_address(whole.y, size.y);
        if i < 0 || j < 0 {
            continue;
        }
        let across = select(1.0 - part.x, part.x, step.x == 1);
        let down = select(1.0 - part.y, part.y, step.y == 1);
        var pixel = stamp[u32(level.x) + u32(j * size.x + i)];
        if vectors {
            let turns = vec2(stamp_turns(whole.x, size.x), stamp_turns(whole.y, size.y));
            pixel = vec4(select(pixel.xy, 2.0 * stamp[1].x * pixel.w - pixel.xy, turns), pixel.zw);
        }
        sum += down * across * pixel;
    }
    return sum;
}

/// The pixel at a place of the brush, whose neighbours are `footprint` away there, not multiplied by alpha.
fn stamp_at(place: vec2<f32>, footprint: f32) -> vec4<f32> {
    return stamp_look(place, footprint, false);
}

/// As `stamp_at`, of an image of colours or of `vectors`.
fn stamp_look(place: vec2<f32>, footprint: f32, vectors: bool) -> vec4<f32> {
    let head = stamp[0];
    let y = select(place.y, -place.y, edit_is(TURNED_OVER));
    var right = head.x * place.x + head.y * y;
    let up = head.x * y - head.y * place.x;
    right = select(right, -right, stamp_is(STAMP_MIRROR));
    let st = vec2(0.5 + 0.5 * right * head.z, 0.5 - 0.5 * up * head.z);
    let whole = stamp[STAMP_HEAD];
    let spread = 0.5 * footprint * head.z * max(whole.y, whole.z);
    let last = u32(stamp[1].w) - 1u;
    let reduction = min(log2(max(spread, 1.0)), f32(last));
    let low = u32(reduction);
    let near = stamp_bilinear(low, st, vectors);
    let pixel = mix(near, stamp_bilinear(min(low + 1u, last), st, vectors), reduction - f32(low));
    return select(vec4(0.0), vec4(pixel.xyz / pixel.w, pixel.w), pixel.w > 0.0);
}

/// The vector along the axes of the box at a place of the brush that the image makes of `height`, and its alpha.
fn stamp_vector(place: vec2<f32>, footprint: f32, height: f32) -> vec4<f32> {
    let head = stamp[0];
    let pixel = stamp_look(place, footprint, true);
    let vector = stamp[1].y * (pixel.xyz - vec3(stamp[1].x)) * height;
    let right = select(vector.x, -vector.x, stamp_is(STAMP_MIRROR));
    let up = head.y * right + head.x * vector.y;
    return vec4(head.x * right - head.y * vector.y, select(up, -up, edit_is(TURNED_OVER)), vector.z, pixel.w);
}
