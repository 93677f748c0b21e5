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

/// Bilinear in a reduction.
fn stamp_bilinear(reduction: u32, st: vec2<f32>) -> vec4<f32> {
    let level = stamp[STAMP_HEAD + reduction];
    let size = vec2<i32>(level.yz);
    let place = st * level.yz - vec2(0.5);
    let low = floor(place);
    let part = place - low;
    var sum = vec4(0.0);
    for (var k = 0; k < 4; k++) {
        let step = vec2(k & 1, k >> 1u);
        let i = stamp_address(i32(low.x) + step.x, size.x);
        let j = stamp_address(i32(low.y) + step.y, size.y);
        if i < 0 || j < 0 {
            continue;
        }
        let across = select(1.0 - part.x, part.x, step.x == 1);
        let down = select(1.0 - part.y, part.y, step.y == 1);
        sum += down * across * stamp[u32(level.x) + u32(j * size.x + i)];
    }
    return sum;
}

/// The pixel at a place of the brush, whose neighbours are `footprint` away there, not multiplied by alpha.
fn stamp_at(place: vec2<f32>, footprint: f32) -> vec4<f32> {
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
    let pixel = mix(stamp_bilinear(low, st), stamp_bilinear(min(low + 1u, last), st), reduction - f32(low));
    return select(vec4(0.0), vec4(pixel.xyz / pixel.w, pixel.w), pixel.w > 0.0);
}
