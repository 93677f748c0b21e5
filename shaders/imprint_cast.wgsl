// import common
// The displacement update: every coefficient's point that lies in the voxels goes along −N until it leaves them (Schäfer
// et al. 2014, Section 6). A workgroup takes a block of 256 coefficients, an invocation two, which share a word.

// What stands for the ends of a column that is solid in more than one piece.
const PIECES: u32 = 0xffffu;

// Further than any ray.
const NEVER: f32 = 1e30;

const PAIRS: u32 = 128u;

struct Cast {
    // From object space to voxels: three numbers of the linear part, and where the origin is.
    x: vec4<f32>,
    y: vec4<f32>,
    z: vec4<f32>,
    // What is subtracted from points first.
    origin: vec3<f32>,
    blocks: u32,
    // Voxels along x, y and z, which the columns run along.
    dims: vec3<u32>,
    // Share of the distance that is applied, and limits in object units.
    share: f32,
    max_displacement: f32,
    depth: f32,
    // The least coefficient, as `key`.
    deepest: i32,
    // 0, or where `counts` has the number of blocks, from 1.
    length: u32,
    // 0, see `rounded`.
    zero: u32,
}

// P, du and dv of every coefficient's place.
@group(0) @binding(0) var<storage, read> samples: array<f32>;
// Coefficients as halves: what they are, and what they were when the depth limit began to count.
@group(0) @binding(1) var<storage, read> heights: array<u32>;
@group(0) @binding(2) var<storage, read> starts: array<u32>;
@group(0) @binding(3) var<storage, read> counts: array<u32>;
// What they are to be.
@group(0) @binding(4) var<storage, read_write> changed: array<u32>;
// Of every block: coefficients that change, rays held at the border of the grid, the least coefficient as `key`, and 0.
@group(0) @binding(5) var<storage, read_write> reports: array<vec4<i32>>;
// Columns: their ends, and the bits of those of several pieces, see `imprint_resolve`.
@group(1) @binding(0) var<storage, read> spans: array<u32>;
@group(1) @binding(1) var<storage, read> words: array<u32>;
var<immediate> work: Cast;

var<workgroup> sum_changed: atomic<i32>;
var<workgroup> sum_clamped: atomic<i32>;
var<workgroup> least: atomic<i32>;

// Halves as whole numbers of the same order.
fn key(half: u32) -> i32 {
    return select(i32(half), -1 - i32(half & 0x7fffu), half >= 0x8000u);
}

fn half_of(key: i32) -> u32 {
    return select(u32(key), 0x8000u | u32(-1 - key), key < 0);
}

fn value(half: u32) -> f32 {
    let size = half & 0x7fffu;
    let normal = bitcast<f32>((size << 13u) + 0x38000000u);
    let magnitude = select(normal, f32(size) * 5.9604645e-8, size < 0x400u);
    return select(magnitude, -magnitude, half >= 0x8000u);
}

// The key of the largest half that is not above a float.
fn key_below(exact: f32) -> i32 {
    let bits = bitcast<u32>(exact);
    let size = bits & 0x7fffffffu;
    var half = 0x7c00u;
    var rest = 0u;
    if size < 0x38800000u {
        let shift = min(126u - (size >> 23u), 31u);
        let digits = (size & 0x7fffffu) | 0x800000u;
        half = digits >> shift;
        rest = select(size, digits & ((1u << shift) - 1u), shift < 25u);
    } else if size < 0x47800000u {
        half = (size - 0x38000000u) >> 13u;
        rest = size & 0x1fffu;
    }
    if bits >= 0x80000000u {
        return -1 - i32(min(half + u32(rest != 0u), 0x7c00u));
    }
    return i32(min(half, 0x7bffu));
}

// A product that is rounded before anything is added to it: compilers may fuse the two. The word is zero.
fn rounded(product: f32) -> f32 {
    return bitcast<f32>(bitcast<u32>(product) ^ work.zero);
}

fn word_of(column: u32, z: u32) -> u32 {
    return words[z / 32u * work.dims.x * work.dims.y + column];
}

fn is_solid(column: u32, z: i32) -> bool {
    let span = spans[column];
    if span == PIECES {
        return ((word_of(column, u32(z)) >> (u32(z) % 32u)) & 1u) == 1u;
    }
    return z >= i32(span & 0xffffu) && z < i32(span >> 16u);
}

// The lower end of the piece of a column that has the solid voxel z, or `stop` if it reaches that far.
fn lower_end(column: u32, z: i32, stop: i32) -> i32 {
    let span = spans[column];
    if span != PIECES {
        return i32(span & 0xffffu);
    }
    var base = u32(z) / 32u * 32u;
    var clear = ~word_of(column, base) & (0xffffffffu >> (31u - u32(z) % 32u));
    // All steps of a ray go the same way along z: together they read a column's words once.
    while clear == 0u && i32(base) > stop && base > 0u {
        base -= 32u;
        clear = ~word_of(column, base);
    }
    if clear == 0u {
        return max(stop, 0);
    }
    return i32(base + 32u - countLeadingZeros(clear));
}

// The upper end, the voxel after the last, or the one after `stop`.
fn upper_end(column: u32, z: i32, stop: i32) -> i32 {
    let span = spans[column];
    if span != PIECES {
        return i32(span >> 16u);
    }
    let nz = i32(work.dims.z);
    var base = u32(z) / 32u * 32u;
    var clear = ~word_of(column, base) & (0xffffffffu << (u32(z) % 32u));
    while clear == 0u && i32(base) + 32 <= stop && i32(base) + 32 < nz {
        base += 32u;
        clear = ~word_of(column, base);
    }
    if clear == 0u {
        return min(stop + 1, nz);
    }
    return min(i32(base + countTrailingZeros(clear)), nz);
}

// How far a ray that starts in the solid goes until it leaves it, at most to `limit`, 0 where it leaves in its first
// voxel; and whether it was held at the border of the grid.
fn follow(start: vec3<f32>, direction: vec3<f32>, limit: f32) -> vec2<f32> {
    let dims = vec3<i32>(work.dims);
    let voxel = vec3<i32>(start);
    let ahead = direction > vec3(0.0);
    let still = direction == vec3(0.0);
    let inverse = 1.0 / select(direction, vec3(1.0), still);
    let face = vec3<f32>(voxel + select(vec3(0), vec3(1), ahead));
    let faces = (face - start) * inverse;
    var next = select(vec3(rounded(faces.x), rounded(faces.y), rounded(faces.z)), vec3(NEVER), still);
    let nearest = min(min(next.x, next.y), next.z);
    let delta = select(abs(inverse), vec3(NEVER), still);
    let step = select(vec2(-1, -dims.x), vec2(1, dims.x), ahead.xy);
    // Columns that are left along x and y before the grid ends.
    var left = select(voxel.xy, dims.xy - 1 - voxel.xy, ahead.xy);
    var column = voxel.y * dims.x + voxel.x;
    var z = voxel.z;
    var far = limit;
    var held = false;
    for (var k = 0; k <= dims.x + dims.y; k++) {
        let by_y = next.y <= next.x;
        let side = select(next.x, next.y, by_y);
        // The voxel in which the ray leaves the column, or reaches the limit; −1 below it and `dims.z` above it.
        let height = clamp(start.z + rounded(min(side, limit) * direction.z), -1.0, f32(dims.z));
        let end = i32(round(height - 0.5));
        if direction.z < 0.0 {
            let before = z;
            z = min(end, z);
            let low = lower_end(u32(column), before, z);
            if low > z {
                far = (f32(low) - start.z) * inverse.z;
                held = low == 0;
                break;
            }
        } else if direction.z > 0.0 {
            let before = z;
            z = max(end, z);
            let high = upper_end(u32(column), before, z);
            if high <= z {
                far = (f32(high) - start.z) * inverse.z;
                held = high >= dims.z;
                break;
            }
        }
        if side >= limit || select(left.x, left.y, by_y) == 0 {
            far = side;
            held = true;
            break;
        }
        if by_y {
            left.y -= 1;
            next.y += delta.y;
            column += step.y;
        } else {
            left.x -= 1;
            next.x += delta.x;
            column += step.x;
        }
        if !is_solid(u32(column), z) {
            far = side;
            break;
        }
    }
    if far <= nearest {
        return vec2(0.0);
    }
    return vec2(min(far, limit), select(0.0, 1.0, held && far < limit));
}

// A row of the map, with the processor's roundings.
fn turned(row: vec4<f32>, v: vec3<f32>, base: f32) -> f32 {
    return fma(row.x, v.x, fma(row.y, v.y, fma(row.z, v.z, base)));
}

// The new key of a coefficient, and whether its ray was held.
fn moved(index: u32, half: u32, start_half: u32) -> vec2<i32> {
    let old = key(half);
    let unchanged = vec2(old, 0);
    let at = 9u * index;
    let p = vec3(samples[at], samples[at + 1u], samples[at + 2u]);
    let du = vec3(samples[at + 3u], samples[at + 4u], samples[at + 5u]);
    let dv = vec3(samples[at + 6u], samples[at + 7u], samples[at + 8u]);
    let across = vec3(
        rounded(du.y * dv.z) - rounded(du.z * dv.y),
        rounded(du.z * dv.x) - rounded(du.x * dv.z),
        rounded(du.x * dv.y) - rounded(du.y * dv.x),
    );
    let square = fma(across.x, across.x, fma(across.y, across.y, across.z * across.z));
    // A degenerate place of the surface has no normal.
    if !(square > 0.0) {
        return unchanged;
    }
    let n = across * (1.0 / sqrt(square));
    let height = value(half);
    let q = p - work.origin;
    let up = vec3(turned(work.x, n, 0.0), turned(work.y, n, 0.0), turned(work.z, n, 0.0));
    let foot = vec3(turned(work.x, q, work.x.w), turned(work.y, q, work.y.w), turned(work.z, q, work.z.w));
    let place = fma(vec3(height), up, foot);
    let inside = all(place >= vec3(0.0)) && all(place < vec3<f32>(work.dims));
    let room = min(height + work.max_displacement, work.depth - (value(start_half) - height));
    let limit = room * (1.0 / work.share);
    if !inside || !(limit > 0.0) || all(up == vec3(0.0)) {
        return unchanged;
    }
    let voxel = vec3<u32>(place);
    if !is_solid(voxel.y * work.dims.x + voxel.x, i32(voxel.z)) {
        return unchanged;
    }
    let far = follow(place, -up, limit);
    if far.x <= 0.0 {
        return unchanged;
    }
    let down = max(key_below(height - work.share * far.x), work.deepest);
    return vec2(min(down, old), i32(far.y));
}

@compute @workgroup_size(PAIRS)
fn cast_rays(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let block = linear_group(group, groups);
    var blocks = work.blocks;
    if work.length > 0u {
        blocks = min(blocks, counts[work.length - 1u]);
    }
    if local == 0u {
        atomicStore(&sum_changed, 0);
        atomicStore(&sum_clamped, 0);
        atomicStore(&least, 0);
    }
    workgroupBarrier();
    if block < blocks {
        let pair = block * PAIRS + local;
        let old = heights[pair];
        let start = starts[pair];
        let low = moved(2u * pair, old & 0xffffu, start & 0xffffu);
        let high = moved(2u * pair + 1u, old >> 16u, start >> 16u);
        changed[pair] = half_of(low.x) | (half_of(high.x) << 16u);
        let differ = i32(low.x != key(old & 0xffffu)) + i32(high.x != key(old >> 16u));
        if differ > 0 {
            atomicAdd(&sum_changed, differ);
        }
        if low.y + high.y > 0 {
            atomicAdd(&sum_clamped, low.y + high.y);
        }
        atomicMin(&least, min(low.x, high.x));
    }
    workgroupBarrier();
    if local == 0u && block < blocks {
        reports[block] = vec4(atomicLoad(&sum_changed), atomicLoad(&sum_clamped), atomicLoad(&least), 0);
    }
}
