// import common
// import tiles
// A brush at every texel of tiles: their new coefficients of displacement, and how many of them change (Schäfer et al.
// 2015, *Local Painting and Deformation of Meshes on the GPU*, Sections 3 and 5.2). The same as `weights` and `mode` of
// rust/detail. The tiles of group 2 are those from when the stroke began: they say where places are.

struct Sculpt {
    // From object space, less the origin, to the brush's coordinates: rows with their shift.
    row_x: vec4<f32>,
    row_y: vec4<f32>,
    row_z: vec4<f32>,
    origin: vec3<f32>,
    falloff: u32,
    strength: f32,
    // What is drawn where the share is 1.
    height: f32,
    // By how much the third coordinate grows over one object unit along the brush's third axis.
    unit: f32,
    mode: u32,
    // First of the tiles, and how many words a block's room has.
    first: u32,
    room: u32,
}

@group(0) @binding(0) var<storage, read> tiles: array<u32>;
// Sizes of tiles, allocated or not.
@group(0) @binding(1) var<storage, read> sizes: array<u32>;
// New blocks, rings as they were.
@group(0) @binding(2) var<storage, read_write> blocks: array<u32>;
@group(0) @binding(3) var<storage, read_write> changes: array<atomic<u32>>;
// The tiles as they are now.
@group(3) @binding(0) var<storage, read> entries: array<TileEntry>;
@group(3) @binding(1) var<storage, read> texels: array<u32>;
var<immediate> sculpt: Sculpt;

const DRAW: u32 = 0u;
const SMOOTH: u32 = 1u;
const FLATTEN: u32 = 2u;
const ERASE: u32 = 3u;
const CLAY: u32 = 4u;
const SCRAPE: u32 = 5u;
const LAYER: u32 = 6u;
const INFLATE: u32 = 7u;

// The largest half float, the bell at its rim, and the least cosine that inflating divides by.
const MOST: f32 = 65504.0;
const RIM: f32 = 0.011108997;
const LEAST_FACING: f32 = 0.25;

fn share_of(square: f32) -> f32 {
    if sculpt.falloff == 0u {
        return 1.0;
    }
    if square >= 1.0 {
        return 0.0;
    }
    let r = sqrt(square);
    switch sculpt.falloff {
        case 1u: {
            return 1.0 - r;
        }
        case 2u: {
            return (1.0 - r) * (1.0 - r) * (1.0 + 2.0 * r);
        }
        case 3u: {
            return sqrt(1.0 - square);
        }
        default: {
            return (exp(-4.5 * square) - RIM) / (1.0 - RIM);
        }
    }
}

fn along(row: vec4<f32>, p: vec3<f32>) -> f32 {
    return fma(row.x, p.x, fma(row.y, p.y, fma(row.z, p.z, row.w)));
}

fn turned(row: vec4<f32>, n: vec3<f32>) -> f32 {
    return fma(row.x, n.x, fma(row.y, n.y, row.z * n.z));
}

fn texel(first: u32, index: u32) -> f32 {
    let pair = unpack2x16float(texels[first + index / 2u]);
    return select(pair.x, pair.y, (index & 1u) == 1u);
}

/// How far a place that has risen is under the plane `height` over the middle of the box, along its normal; 0 where that
/// does not rise.
fn under(height: f32, level: f32, rise: f32, risen: f32) -> f32 {
    return select(0.0, fma(height, sculpt.unit, -level) / rise - risen, rise > 0.0);
}

fn held(value: f32) -> f32 {
    return clamp(value, -MOST, MOST);
}

/// The new coefficient at texel (i, j) of a tile that has `now` there.
fn edited(tile: u32, size: u32, cell: vec2<u32>, now: f32) -> f32 {
    let uv = (vec2<f32>(cell) + vec2(0.5)) / f32(size);
    let found = surface_find(tile, uv);
    if found == SURFACE_NONE {
        return now;
    }
    let sample = surface_evaluate(found, uv);
    let across = cross(sample.du, sample.dv);
    let square = dot(across, across);
    let normal = across * select(0.0, 1.0 / sqrt(square), square > 0.0);
    let p = sample.p - sculpt.origin;
    let rises = vec3(turned(sculpt.row_x, normal), turned(sculpt.row_y, normal), turned(sculpt.row_z, normal));
    // Where the place was when the stroke began.
    var begun = 0.0;
    let start = tiles_entries[tile];
    let at = (cell.y + 1u) * (size + 2u) + cell.x + 1u;
    if start.first != TILES_NONE {
        begun = tiles_texel(start.first, at);
    }
    let risen = now - begun;
    let place = fma(
        vec3(begun),
        rises,
        vec3(along(sculpt.row_x, p), along(sculpt.row_y, p), along(sculpt.row_z, p)),
    );
    if any(abs(place) > vec3(1.0)) {
        return now;
    }
    let share = sculpt.strength * share_of(fma(place.z, place.z, fma(place.y, place.y, place.x * place.x)));
    if !(share > 0.0) {
        return now;
    }
    let height = sculpt.height;
    switch sculpt.mode {
        case DRAW: {
            return held(fma(height, share, now));
        }
        case SMOOTH: {
            let entry = entries[tile];
            if entry.first == TILES_NONE {
                return now;
            }
            let stride = size + 2u;
            let rows = texel(entry.first, at - stride) + texel(entry.first, at + stride);
            let columns = texel(entry.first, at - 1u) + texel(entry.first, at + 1u);
            return fma(0.25 * (rows + columns) - now, share, now);
        }
        case FLATTEN: {
            return held(fma(under(0.0, place.z, rises.z, risen), share, now));
        }
        case ERASE: {
            return fma(-now, share, now);
        }
        case CLAY: {
            let far = under(height, place.z, rises.z, risen);
            return held(fma(select(max(far, 0.0), min(far, 0.0), height < 0.0), share, now));
        }
        case SCRAPE: {
            return held(fma(min(under(0.0, place.z, rises.z, risen), 0.0), share, now));
        }
        case LAYER: {
            let far = fma(height, share, -risen);
            return held(now + select(max(far, 0.0), min(far, 0.0), height < 0.0));
        }
        case INFLATE: {
            let facing = dot(tiles_displaced(tile, uv).normal, normal);
            return held(fma(height / max(facing, LEAST_FACING), share, now));
        }
        default: {
            return now;
        }
    }
}

// One word, two texels of a row, of the block of one tile.
@compute @workgroup_size(GROUP)
fn edit(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let slot = group.x;
    let tile = tiles[sculpt.first + slot];
    let size = sizes[sculpt.first + slot];
    let stride = size + 2u;
    let word = group.y * GROUP + local;
    if word >= stride * stride / 2u {
        return;
    }
    let entry = entries[tile];
    var old = 0u;
    if entry.first != TILES_NONE {
        old = texels[entry.first + word];
    }
    let values = unpack2x16float(old);
    let row = 2u * word / stride;
    let column = 2u * word % stride;
    var new_word = 0u;
    var changed = 0u;
    for (var k = 0u; k < 2u; k++) {
        let half = (old >> (16u * k)) & 0xffffu;
        var bits = half;
        let i = column + k;
        if row >= 1u && row <= size && i >= 1u && i <= size {
            let now = values[k];
            let value = edited(tile, size, vec2(i - 1u, row - 1u), now);
            if value != now {
                bits = half_bits(value);
            }
        }
        changed += select(0u, 1u, bits != half);
        new_word |= bits << (16u * k);
    }
    blocks[slot * sculpt.room + word] = new_word;
    if changed > 0u {
        atomicAdd(&changes[slot], changed);
    }
}
