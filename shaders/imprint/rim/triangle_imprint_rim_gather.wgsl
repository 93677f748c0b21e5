// import imprint_rim
// import imprint_under
// import triangle_imprint_foot
// The pieces around a contact on a triangle mesh before the imprint: places, areas, values, and which are under the collider.
// Of a value that several triangles have, the first one's stands for the area.

// First words of the triangles' blocks, and their words.
@group(2) @binding(0) var<storage, read> entries: array<u32>;
@group(2) @binding(1) var<storage, read> values: array<u32>;

var<workgroup> low: array<vec3<f32>, 256>;
var<workgroup> high: array<vec3<f32>, 256>;
var<workgroup> free: array<atomic<u32>, 8>;

// A value as imprints of earlier dispatches left it.
fn value_before(it: Patchwork, index: u32) -> u32 {
    let shift = 16u * (index & 1u);
    if (work.flags & CHAINED) != 0u {
        let slot = atomicLoad(&slots[block_slot(it)]);
        if slot != 0u {
            return (records[RECORD * (slot - 1u) + HEADER + index % 256u / 2u] >> shift) & 0xffffu;
        }
    }
    let first = entries[it.tile];
    return select((values[first + index / 2u] >> shift) & 0xffffu, 0u, first == TRIANGLE_NONE);
}

// A third of a triangle of the pattern in a face, as seen along a normal, and no distance of neighbours is longer than the
// second number.
fn share_of(face: u32, n: vec3<f32>) -> vec2<f32> {
    let a = mesh_foot(mesh_corner(face, 0u)).p;
    let b = mesh_foot(mesh_corner(face, 1u)).p;
    let c = mesh_foot(mesh_corner(face, 2u)).p;
    let segments = f32(SEGMENTS);
    let normal = cross(b - a, c - a) / (9.0 * segments * segments);
    let longest = max(distance(a, b), max(distance(b, c), distance(c, a)));
    return vec2(max(dot(normal, n), 0.0), longest / (0.75 * segments));
}

// The area that a value stands for in all triangles that have it, none of those that another one stands for.
fn area_of(face: u32, node: Node, n: vec3<f32>) -> f32 {
    let others = sharing(face, node);
    if others.count == 0u {
        return 6.0 * share_of(face, n).x;
    }
    var sum = 0.0;
    var first = face;
    for (var k = 0u; k < others.count; k++) {
        let other = mesh_words[others.first + k] / 3u;
        sum += share_of(other, n).x;
        first = min(first, other);
    }
    return select(0.0, f32(ring_count(SEGMENTS, node) - 1u) * sum, first == face);
}

@compute @workgroup_size(GROUP)
fn gather(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) k: u32,
) {
    let piece = linear_group(group, groups);
    let there = piece < arguments[2u * step.link + 1u].x;
    work = links[step.link];
    if k < 8u {
        atomicStore(&free[k], 0u);
    }
    low[k] = vec3(1e38);
    high[k] = vec3(-1e38);
    workgroupBarrier();
    var it: Patchwork;
    if there {
        it = patchwork(listed[piece]);
        let index = 256u * it.block + k;
        var point = vec4(0.0);
        var half = 0u;
        if index < value_count(SEGMENTS) {
            let foot = exact_foot(it.tile, index);
            half = value_before(it, index);
            point = vec4(foot.p, area_of(it.tile, node_of(it.tile, SEGMENTS, index), foot.normal));
            let up = scaled(foot.normal, value(half));
            if any(foot.normal != vec3(0.0)) && !is_under(foot.p + way_at(it.tile, index) + up) {
                atomicOr(&free[k / 32u], 1u << (k % 32u));
            }
            low[k] = point.xyz;
            high[k] = point.xyz;
        }
        points[256u * piece + k] = point;
        pieces[PIECE * piece + k] = half << 16u;
        if k == 0u {
            places[place_of(it.tile, it.block)] = piece | ((step.link + 1u) << 24u);
        }
    }
    // The box of the points.
    for (var reach = 128u; reach > 0u; reach /= 2u) {
        workgroupBarrier();
        if k < reach {
            low[k] = min(low[k], low[k + reach]);
            high[k] = max(high[k], high[k + reach]);
        }
    }
    workgroupBarrier();
    if !there {
        return;
    }
    let first = PIECE * piece;
    if k < 3u {
        pieces[first + BOX + k] = bitcast<u32>(low[0][k]);
        pieces[first + BOX + 3u + k] = bitcast<u32>(high[0][k]);
    }
    if k < 8u {
        pieces[first + FREE + k] = atomicLoad(&free[k]);
    }
    if k == 0u {
        pieces[first + SPACING] = bitcast<u32>(share_of(it.tile, vec3(0.0)).y);
        pieces[first + RECORD_OF] = 0u;
    }
}
