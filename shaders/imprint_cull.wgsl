// import common
// import halves
// import imprint_link
// import imprint_tile
// import surface
// Which tiles, and which blocks of 16 × 16 of their coefficients, may have points in the voxel grid (Schäfer et al. 2014,
// Section 5, Culling Geometry within Overlap): Bézier hulls in voxel coordinates, cut along the borders of blocks and
// widened by the displacement along cones of normals (Sederberg and Meyers 1988). A workgroup takes a tile and lists its
// blocks: the stages that follow take each by itself, in any order.

const THREADS: u32 = 64u;

// Texels along a block at most.
const EDGE: u32 = 16u;

// Voxels by which bounds are widened against rounding.
const SLACK: f32 = 0.05;

@group(0) @binding(1) var<storage, read> slots: array<u32>;
// A tile, and a block of it with the tile's size in the upper half.
@group(0) @binding(2) var<storage, read_write> listed: array<vec2<u32>>;
@group(0) @binding(3) var<storage, read_write> told: AllTold;
// Of every imprint eight words, the last four of which are the number of listed blocks, and the workgroups in x, y and z
// that take one each.
@group(0) @binding(4) var<storage, read_write> arguments: array<atomic<u32>>;
@group(2) @binding(0) var<storage, read> tiles: array<CullTile>;
// The unit axis and the cosine of the half angle of every patch's normals.
@group(2) @binding(1) var<storage, read> cones: array<vec4<f32>>;

var<workgroup> shared_first: u32;
var<workgroup> met: atomic<u32>;
var<workgroup> bits: array<atomic<u32>, 8>;

struct Bounds {
    low: vec3<f32>,
    high: vec3<f32>,
}

// Control points along a voxel axis; Bézier patches have four rows, the fifth again the last.
struct Points {
    rows: mat4x4<f32>,
    last: vec4<f32>,
}

fn four(at: u32) -> vec4<f32> {
    return surface_data[at / 4u];
}

fn points_along(it: SurfacePatch, row: vec4<f32>) -> Points {
    let at = it.first;
    let shift = vec3(surface_number(at), surface_number(at + 1u), surface_number(at + 2u)) - work.origin;
    let base = vec4(dot(row, vec4(shift, 1.0)));
    let count = select(16u, 20u, it.form == 1u);
    let x = at + SURFACE_ORIGIN;
    let y = x + count;
    let z = y + count;
    var all: Points;
    for (var k = 0u; k < 4u; k++) {
        all.rows[k] = base + row.x * four(x + 4u * k) + row.y * four(y + 4u * k) + row.z * four(z + 4u * k);
    }
    all.last = all.rows[3];
    if it.form == 1u {
        all.last = base + row.x * four(x + 16u) + row.y * four(y + 16u) + row.z * four(z + 16u);
    }
    return all;
}

// The least and the largest of some points.
fn ends(points: Points) -> vec2<f32> {
    let r = points.rows;
    let low = min(min(min(r[0], r[1]), min(r[2], r[3])), points.last);
    let high = max(max(max(r[0], r[1]), max(r[2], r[3])), points.last);
    return vec2(min(min(low.x, low.y), min(low.z, low.w)), max(max(high.x, high.y), max(high.z, high.w)));
}

// The least and the largest of row · N over unit normals in a cone.
fn span(cone: vec4<f32>, row: vec3<f32>) -> vec2<f32> {
    let size = length(row);
    if cone.w <= -1.0 || size == 0.0 {
        return vec2(-size, size);
    }
    let along = clamp(dot(cone.xyz, row) / size, -1.0, 1.0);
    let sine = sqrt(max(1.0 - cone.w * cone.w, 0.0));
    let across = sqrt(max(1.0 - along * along, 0.0));
    let most = select(along * cone.w + across * sine, 1.0, along >= cone.w);
    let least = select(along * cone.w - across * sine, -1.0, along <= -cone.w);
    return size * vec2(least, most);
}

// How far displacements reach along a voxel axis.
fn spread(tile: CullTile, cone: vec4<f32>, row: vec3<f32>) -> vec2<f32> {
    if tile.least == 0.0 && tile.most == 0.0 {
        return vec2(0.0);
    }
    let reach = span(cone, row);
    let corners = vec4(tile.least * reach, tile.most * reach);
    let least = min(min(corners.x, corners.y), min(corners.z, corners.w));
    let most = max(max(corners.x, corners.y), max(corners.z, corners.w));
    return vec2(least, most);
}

fn meets(bounds: Bounds) -> bool {
    return all(bounds.low <= vec3<f32>(work.dims) + SLACK) && all(bounds.high >= vec3(-SLACK));
}

fn whole(tile: CullTile, patch_index: u32) -> Bounds {
    let it = surface_patches[patch_index];
    let cone = cones[patch_index];
    let x = ends(points_along(it, work.x)) + spread(tile, cone, work.x.xyz);
    let y = ends(points_along(it, work.y)) + spread(tile, cone, work.y.xyz);
    let z = ends(points_along(it, work.z)) + spread(tile, cone, work.z.xyz);
    return Bounds(vec3(x.x, y.x, z.x), vec3(x.y, y.y, z.y));
}

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

// Takes room in the list for so many blocks of a tile. The arguments of what takes the listed blocks only grow.
fn list(found: u32, edge: u32) {
    let first = atomicAdd(&told.links[step.link].found, found);
    shared_first = first;
    atomicAdd(&told.links[step.link].tiles, 1u);
    atomicAdd(&told.links[step.link].tested, found * edge * edge);
    let count = min(first + found, work.room);
    let at = 8u * step.link + 4u;
    atomicMax(&arguments[at], count);
    atomicMax(&arguments[at + 1u], min(count, ROW));
    atomicMax(&arguments[at + 2u], (count + ROW - 1u) / ROW);
    atomicMax(&arguments[at + 3u], 1u);
}

@compute @workgroup_size(THREADS)
fn cull(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    work = links[step.link];
    let index = linear_group(group, groups);
    let there = index < work.tiles;
    if local < 8u {
        atomicStore(&bits[local], 0u);
    }
    if local == 0u {
        atomicStore(&met, 0u);
        shared_first = 0u;
    }
    workgroupBarrier();
    var tile: CullTile;
    var first = 0u;
    var stop = 0u;
    if there {
        tile = tiles[index];
        if (work.flags & CHAINED) != 0u {
            let lowered = slots[work.slots + index * work.stride];
            if lowered > 0u {
                tile.least = min(tile.least, value(half_of(-i32(lowered))));
            }
        }
        first = surface_tiles[index].x;
        stop = surface_tiles[index + 1u].x;
    }
    for (var k = first + local; k < stop; k += THREADS) {
        if meets(whole(tile, k)) {
            atomicOr(&met, 1u);
        }
    }
    workgroupBarrier();
    let count = max(tile.size / EDGE, 1u);
    if atomicLoad(&met) != 0u {
        for (var block = local; block < count * count; block += THREADS) {
            for (var k = first; k < stop; k++) {
                if block_meets(tile, k, vec2(block % count, block / count), count) {
                    atomicOr(&bits[block / 32u], 1u << (block % 32u));
                    break;
                }
            }
        }
    }
    workgroupBarrier();
    if local == 0u {
        var found = 0u;
        for (var k = 0u; k < 8u; k++) {
            found += countOneBits(atomicLoad(&bits[k]));
        }
        if found > 0u {
            list(found, min(tile.size, EDGE));
        }
    }
    workgroupBarrier();
    if there && local < 8u {
        var at = shared_first;
        for (var k = 0u; k < local; k++) {
            at += countOneBits(atomicLoad(&bits[k]));
        }
        for (var rest = atomicLoad(&bits[local]); rest != 0u; rest &= rest - 1u) {
            if at < work.room {
                listed[at] = vec2(index, (32u * local + countTrailingZeros(rest)) | (tile.size << 16u));
            }
            at++;
        }
    }
}
