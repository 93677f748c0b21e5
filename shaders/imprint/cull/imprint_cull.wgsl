// import imprint_hull
// import imprint_record
// Which blocks of 16 × 16 coefficients of the listed tiles may have points in the voxel grids of the imprints of a row
// (Schäfer et al. 2014, Section 5, Culling Geometry within Overlap): hulls cut along the borders of blocks. A workgroup
// takes a tile and lists its blocks: the stages that follow take each by itself, in any order.

const THREADS: u32 = 64u;

// Words of bits of a tile's blocks.
const WORDS: u32 = 8u;

// A tile, a block of it with the tile's size in the upper half, and the imprints that it may meet, a bit each.
@group(0) @binding(3) var<storage, read_write> listed: array<vec4<u32>>;
@group(0) @binding(4) var<storage, read_write> counters: AllCounters;
// Of every imprint eight words, the last four of which are the number of blocks listed for it and those of its row, and
// the workgroups in x, y and z that take one each.
@group(0) @binding(5) var<storage, read_write> arguments: array<atomic<u32>>;
// What `imprint_patches` listed.
@group(0) @binding(6) var<storage, read> counts: array<vec4<u32>>;
@group(2) @binding(3) var<storage, read> candidates: array<u32>;

var<workgroup> shared_first: u32;
// By imprint the blocks that it may meet, and those of all.
var<workgroup> bits: array<atomic<u32>, 512>;
var<workgroup> either: array<u32, 8>;

// The cubic Bézier points of a curve's part from a to b as weights of the curve's own, by blossoming.
fn blossom(r: f32, s: f32, t: f32) -> vec4<f32> {
    let c = 1.0 - vec3(r, s, t);
    return vec4(
        c.x * c.y * c.z,
        r * c.y * c.z + c.x * s * c.z + c.x * c.y * t,
        r * s * c.z + r * c.y * t + c.x * s * t,
        r * s * t,
    );
}

fn restriction(a: f32, b: f32) -> mat4x4<f32> {
    return mat4x4(blossom(a, a, a), blossom(a, a, b), blossom(a, b, b), blossom(b, b, b));
}

fn piece(points: Points, in_u: mat4x4<f32>, in_v: mat4x4<f32>) -> vec2<f32> {
    let r = points.rows;
    let strip = mat4x4(r[0] * in_u, r[1] * in_u, r[2] * in_u, r[3] * in_u);
    let cut = strip * in_v;
    return ends(Points(cut, cut[3]));
}

// Whether a block may have points of a patch in the grid.
fn block_meets(tile: CullTile, patch_index: u32, block: vec2<u32>, count: u32) -> bool {
    let it = surface_patches[patch_index];
    let start = min(vec2<u32>(it.low * f32(count)), vec2(count - 1u));
    let stop = clamp(vec2<u32>(ceil((it.low + it.size) * f32(count))), start + 1u, vec2(count));
    if any(block < start) || any(block >= stop) || !meets(whole(tile, patch_index)) {
        return false;
    }
    if all(start + 1u == stop) || it.form == 1u {
        return true;
    }
    let low = clamp((vec2<f32>(block) / f32(count) - it.low) / it.size, vec2(0.0), vec2(1.0));
    let high = clamp((vec2<f32>(block + 1u) / f32(count) - it.low) / it.size, vec2(0.0), vec2(1.0));
    let in_u = restriction(low.x, high.x);
    let in_v = restriction(low.y, high.y);
    let cone = cones[patch_index];
    let x = piece(points_along(it, work.x), in_u, in_v) + spread(tile, cone, work.x.xyz);
    let y = piece(points_along(it, work.y), in_u, in_v) + spread(tile, cone, work.y.xyz);
    let z = piece(points_along(it, work.z), in_u, in_v) + spread(tile, cone, work.z.xyz);
    return meets(Bounds(vec3(x.x, y.x, z.x), vec3(x.y, y.y, z.y)));
}

// Takes room in the list for so many blocks. The arguments of what takes the listed blocks only grow.
fn list(found: u32) {
    let first = atomicAdd(&counters.links[step.link].found, found);
    shared_first = first;
    let count = min(first + found, links[step.link].room);
    let at = 8u * step.link + 4u;
    atomicMax(&arguments[at], count);
    atomicMax(&arguments[at + 1u], min(count, ROW));
    atomicMax(&arguments[at + 2u], (count + ROW - 1u) / ROW);
    atomicMax(&arguments[at + 3u], 1u);
}

// Notes the blocks of a tile that the imprints `met` may meet.
fn meet(index: u32, before: CullTile, met: vec2<u32>, local: u32) {
    let count = max(before.size / EDGE, 1u);
    let first = surface_tiles[index].x;
    let stop = surface_tiles[index + 1u].x;
    var tile = before;
    for (var link = step.link; link != LINK_NONE; link = work.next) {
        take(link);
        if ((met[link / 32u] >> (link % 32u)) & 1u) == 0u {
            continue;
        }
        for (var block = local; block < count * count; block += THREADS) {
            for (var k = first; k < stop; k++) {
                if block_meets(tile, k, vec2(block % count, block / count), count) {
                    atomicOr(&bits[WORDS * link + block / 32u], 1u << (block % 32u));
                    break;
                }
            }
        }
        tile.least = lowest(tile.least);
    }
}

@compute @workgroup_size(THREADS)
fn cull_blocks(id: Invocation) {
    let number = linear_group(id);
    let there = number < counts[step.link].x;
    for (var k = 0u; k < WORDS; k++) {
        atomicStore(&bits[WORDS * id.local + k], 0u);
    }
    if id.local == 0u {
        shared_first = 0u;
    }
    workgroupBarrier();
    var index = 0u;
    var size = 0u;
    if there {
        index = candidates[number];
        let tile = tile_before(index);
        size = tile.size;
        let at = MASK_WORDS * index;
        meet(index, tile, vec2(atomicLoad(&masks[at]), atomicLoad(&masks[at + 1u])), id.local);
    }
    workgroupBarrier();
    let edge = min(size, EDGE);
    if there {
        // As many invocations as there may be imprints.
        var own = 0u;
        for (var k = 0u; k < WORDS; k++) {
            own += countOneBits(atomicLoad(&bits[WORDS * id.local + k]));
        }
        if own > 0u {
            atomicAdd(&counters.links[id.local].tiles, 1u);
            atomicAdd(&counters.links[id.local].tested, own * edge * edge);
        }
    }
    if id.local < WORDS {
        var all = 0u;
        for (var link = 0u; link < THREADS; link++) {
            all |= atomicLoad(&bits[WORDS * link + id.local]);
        }
        either[id.local] = all;
    }
    workgroupBarrier();
    if there && id.local == 0u {
        var found = 0u;
        for (var k = 0u; k < WORDS; k++) {
            found += countOneBits(either[k]);
        }
        if found > 0u {
            list(found);
        }
        // For the next row of imprints.
        for (var k = 0u; k < MASK_WORDS; k++) {
            atomicStore(&masks[MASK_WORDS * index + k], 0u);
        }
    }
    workgroupBarrier();
    for (var block = id.local; block < 32u * WORDS; block += THREADS) {
        let word = block / 32u;
        let bit = 1u << (block % 32u);
        if !there || (either[word] & bit) == 0u {
            continue;
        }
        var at = shared_first + countOneBits(either[word] & (bit - 1u));
        for (var k = 0u; k < word; k++) {
            at += countOneBits(either[k]);
        }
        var met = vec2(0u);
        for (var link = 0u; link < THREADS; link++) {
            let meets_it = (atomicLoad(&bits[WORDS * link + word]) & bit) != 0u;
            met[link / 32u] |= select(0u, 1u << (link % 32u), meets_it);
        }
        if at < links[step.link].room {
            listed[at] = vec4(index, block | (size << 16u), met);
        }
    }
}
