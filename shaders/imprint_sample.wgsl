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
    // 0, see `rounded`.
    zero: u32,
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

// A product that is rounded before anything is added to it: compilers may fuse the two. The word is zero.
fn rounded(product: f32) -> f32 {
    return bitcast<f32>(bitcast<u32>(product) ^ work.zero);
}

// Bernstein polynomials at t.
fn cubic(t: f32) -> vec4<f32> {
    let s = 1.0 - t;
    return vec4(s * s * s, 3.0 * (s * s * t), 3.0 * (t * t * s), t * t * t);
}

// The control points of the curve in u at v, from the basis values there and the Bézier points from `first` on.
fn curve(basis: vec4<f32>, first: u32) -> vec4<f32> {
    var points: vec4<f32>;
    for (var k = 0u; k < 4u; k++) {
        let at = first + k;
        let low = fma(basis.y, surface_data[at + 4u], basis.x * surface_data[at]);
        let high = fma(basis.w, surface_data[at + 12u], basis.z * surface_data[at + 8u]);
        points[k] = low + high;
    }
    return points;
}

fn combined(basis: vec4<f32>, points: vec4<f32>) -> f32 {
    let sum = fma(basis.z, points.z, fma(basis.y, points.y, basis.x * points.x));
    return fma(basis.w, points.w, sum);
}

// P, du and dv of a regular patch with the processor's sums and products, one by one (`Surface::grid`): where rays graze
// an edge of voxels, the last bit decides. Others are evaluated as everywhere.
fn sample_patch(patch_index: u32, uv: vec2<f32>) -> SurfaceSample {
    let it = surface_patches[patch_index];
    if it.form != 0u {
        return surface_evaluate(patch_index, uv);
    }
    let scale = vec2(1.0) / it.size;
    let st = (uv - it.low) * scale;
    let along = cubic(st.x);
    let across = cubic(st.y);
    let s = vec2(1.0) - st;
    let ss = vec2(rounded(s.x * s.x), rounded(s.y * s.y));
    let mixed = vec2(rounded(s.x * st.x), rounded(s.y * st.y));
    let tt = vec2(rounded(st.x * st.x), rounded(st.y * st.y));
    let by = 3.0 * scale.y;
    let slopes = vec4(-ss.y, ss.y - 2.0 * mixed.y, 2.0 * mixed.y - tt.y, tt.y) * by;
    let quadratic = vec3(ss.x, mixed.x + mixed.x, tt.x);
    var sample: SurfaceSample;
    for (var axis = 0u; axis < 3u; axis++) {
        let first = it.first + 3u + 16u * axis;
        let points = curve(across, first);
        sample.p[axis] = combined(along, points) + surface_data[it.first + axis];
        let steps = (3.0 * scale.x) * (points.yzw - points.xyz);
        sample.du[axis] = fma(quadratic.z, steps.z, fma(quadratic.y, steps.y, quadratic.x * steps.x));
        sample.dv[axis] = combined(along, curve(slopes, first));
    }
    return sample;
}

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
            it = sample_patch(found, uv);
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
