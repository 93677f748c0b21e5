// import progressive_edited
// import progressive_bits
// import octahedron
// The vertices and triangles of a mesh that is marked, without gaps, in buffers that are drawn.

struct SizesCall {
    vertices: u32,
    triangles: u32,
    /// 1 if vertices may be elsewhere than they were built.
    is_edited: u32,
}

@group(0) @binding(0) var<storage, read> splits: array<SplitBlock>;
/// Of what is split and of leaves, by number: the point, and the normal on an octahedron.
@group(0) @binding(1) var<storage, read> inner: array<vec4<u32>>;
@group(0) @binding(2) var<storage, read> leaves: array<vec4<u32>>;
/// Of the triangles in the order of the input: the split that makes each, and the leaves at its corners.
@group(0) @binding(3) var<storage, read> makers: array<u32>;
@group(0) @binding(4) var<storage, read> corners: array<u32>;
@group(1) @binding(0) var<storage, read_write> there: array<u32>;
/// How many vertices there are before those of a word.
@group(1) @binding(1) var<storage, read_write> ranks: array<u32>;
@group(1) @binding(2) var<storage, read_write> shown: array<u32>;
@group(1) @binding(3) var<storage, read_write> shown_ranks: array<u32>;
@group(1) @binding(4) var<storage, read_write> vertices: array<vec4<u32>>;
@group(1) @binding(5) var<storage, read_write> indices: array<u32>;
/// The arguments of an indirect draw, and the number of vertices.
@group(1) @binding(6) var<storage, read_write> arguments: array<u32>;
var<immediate> sizes: SizesCall;

fn is_there(vertex: u32) -> bool {
    return (there[vertex / 32u] >> (vertex % 32u) & 1u) == 1u;
}

/// The number of vertices up to a leaf.
fn rank(leaf: u32) -> u32 {
    return ranks[leaf / 32u] + countOneBits(there[leaf / 32u] & bits_to(leaf % 32u));
}

/// Which triangles there are.
@compute @workgroup_size(GROUP)
fn show(id: Invocation) {
    let triangle = linear_item(id);
    var is_shown = false;
    if triangle < sizes.triangles {
        let maker = makers[triangle];
        is_shown = maker < sizes.vertices && is_there(maker);
    }
    let word = gathered(id.local, is_shown);
    if triangle < sizes.triangles && id.local % 32u == 0u {
        shown[triangle / 32u] = word;
        shown_ranks[triangle / 32u] = countOneBits(word);
    }
}

/// The vertex at a corner is the last one up to its leaf.
@compute @workgroup_size(GROUP)
fn write_triangles(id: Invocation) {
    let triangle = linear_item(id);
    if triangle >= sizes.triangles {
        return;
    }
    let word = shown[triangle / 32u];
    let before = shown_ranks[triangle / 32u] + countOneBits(word & bits_to(triangle % 32u));
    if triangle == sizes.triangles - 1u {
        arguments[0] = 3u * before;
    }
    if (word >> (triangle % 32u) & 1u) == 1u {
        for (var side = 0u; side < 3u; side++) {
            indices[3u * (before - 1u) + side] = rank(corners[3u * triangle + side]) - 1u;
        }
    }
}

/// Every vertex is a leaf or what is to be split, of a split that is made or of the base.
@compute @workgroup_size(GROUP)
fn write_vertices(id: Invocation) {
    let split = linear_item(id);
    if split == 0u {
        arguments[1] = 1u;
        arguments[5] = rank(sizes.vertices - 1u);
    }
    if split >= sizes.vertices || !is_there(split) {
        return;
    }
    let own = splits[split];
    let ends = array(own.vertex, split);
    for (var side = 0u; side < select(2u, 1u, own.key == ALWAYS); side++) {
        let child = own.children[side];
        let vertex = ends[side];
        if child < LEAF && is_there(child) {
            continue;
        }
        var bits: vec4<u32>;
        if child >= LEAF {
            bits = leaves[vertex];
        } else {
            bits = inner[child];
        }
        if sizes.is_edited == 1u {
            let place = place_of(2u * split + side);
            if place.moved == 1u {
                bits = vec4(bitcast<vec3<u32>>(place.point), octahedral_bits(place.normal));
            }
        }
        vertices[rank(vertex) - 1u] = bits;
    }
}
