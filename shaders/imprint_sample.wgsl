// import common
// import tiles
// What the rays of listed blocks start from: the surface at the places of their coefficients, what these are, and what
// they were when the depth limit began to count. A workgroup takes a block, an invocation two coefficients, which share
// a word.

const PAIRS: u32 = 128u;

// Words of a record, see `imprint_keep`, and those before its coefficients.
const RECORD: u32 = 132u;
const HEADER: u32 = 4u;

// Texels along a block at most.
const EDGE: u32 = 16u;

const STARTED: u32 = 1u;
const CHAINED: u32 = 2u;

struct Sampling {
    flags: u32,
    // Where the object's slots begin, and how many a tile has.
    base: u32,
    stride: u32,
}

@group(0) @binding(0) var<storage, read> listed: array<vec2<u32>>;
@group(0) @binding(1) var<storage, read> arguments: array<u32>;
// Blocks that imprints before this one changed, and of every block of an object its last record, from 1.
@group(0) @binding(2) var<storage, read> records: array<u32>;
@group(0) @binding(3) var<storage, read> slots: array<u32>;
// P, du and dv.
@group(0) @binding(4) var<storage, read_write> samples: array<f32>;
@group(0) @binding(5) var<storage, read_write> heights: array<u32>;
@group(0) @binding(6) var<storage, read_write> starts: array<u32>;
// The tiles from when the depth limit began to count.
@group(3) @binding(0) var<storage, read> start_entries: array<TileEntry>;
@group(3) @binding(1) var<storage, read> start_texels: array<u32>;
var<immediate> work: Sampling;

@compute @workgroup_size(PAIRS)
fn sample(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let index = linear_group(group, groups);
    if index >= arguments[0] {
        return;
    }
    let tile = listed[index].x;
    let block = listed[index].y & 0xffffu;
    let size = listed[index].y >> 16u;
    let edge = min(size, EDGE);
    let across = size / edge;
    let corner = vec2(block % across, block / across) * edge;
    let entry = tiles_entries[tile];
    var start_first = TILES_NONE;
    if (work.flags & STARTED) != 0u {
        start_first = start_entries[tile].first;
    }
    var height = 0u;
    var start = 0u;
    for (var k = 0u; k < 2u; k++) {
        let knot = 2u * local + k;
        let there = knot < edge * edge;
        let cell = corner + vec2(knot % edge, knot / edge);
        let uv = (vec2<f32>(cell) + vec2(0.5)) / f32(size);
        var found = SURFACE_NONE;
        if there {
            found = surface_find(tile, uv);
        }
        // Without a normal nothing changes: beyond the coefficients of a small tile, and in holes.
        var it: SurfaceSample;
        if found != SURFACE_NONE {
            it = surface_evaluate(found, uv);
        }
        let at = 9u * (index * 2u * PAIRS + knot);
        for (var axis = 0u; axis < 3u; axis++) {
            samples[at + axis] = it.p[axis];
            samples[at + 3u + axis] = it.du[axis];
            samples[at + 6u + axis] = it.dv[axis];
        }
        let texel = (cell.y + 1u) * (size + 2u) + cell.x + 1u;
        let lane = 16u * (texel & 1u);
        if there && entry.first != TILES_NONE {
            height |= ((tiles_texels[entry.first + texel / 2u] >> lane) & 0xffffu) << (16u * k);
        }
        if there && start_first != TILES_NONE {
            start |= ((start_texels[start_first + texel / 2u] >> lane) & 0xffffu) << (16u * k);
        }
    }
    if (work.flags & CHAINED) != 0u {
        let slot = slots[work.base + tile * work.stride + block];
        if slot != 0u {
            height = records[RECORD * (slot - 1u) + HEADER + local];
        }
    }
    heights[index * PAIRS + local] = height;
    starts[index * PAIRS + local] = select(height, start, (work.flags & STARTED) != 0u);
}
