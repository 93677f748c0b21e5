// import imprint_rim_measure
// import imprint_under
// import triangle_imprint_foot
// The pieces around a contact on a triangle mesh before the imprint: places, areas, values, and which are under the collider.
// Of a value that several triangles have, the first one's stands for the area.

// First words of the triangles' blocks, and their words.
@group(2) @binding(0) var<storage, read> entries: array<u32>;
@group(2) @binding(1) var<storage, read> values: array<u32>;

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

// The area that a value stands for in all triangles that have it, without the area that another one stands for.
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

// Value k of a piece, of the undisplaced mesh, and whether it may rise.
fn measured(it: Patchwork, k: u32) -> Measured {
    var made: Measured;
    let index = 256u * it.block + k;
    made.is_there = index < value_count(SEGMENTS);
    if !made.is_there {
        return made;
    }
    let foot = exact_foot(it.tile, index);
    made.half = value_before(it, index);
    made.point = vec4(foot.p, area_of(it.tile, node_of(it.tile, SEGMENTS, index), foot.normal));
    let up = scaled(foot.normal, value(made.half));
    made.is_free = any(foot.normal != vec3(0.0)) && !is_under(foot.p + way_at(it.tile, index) + up);
    return made;
}

// The largest distance of neighbours on a piece.
fn spacing_of(it: Patchwork, _area: f32) -> f32 {
    return share_of(it.tile, vec3(0.0)).y;
}
