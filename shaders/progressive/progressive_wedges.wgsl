// import progressive
// import progressive_bits
// What the triangles of a mesh that is marked have of attributes: wedges, by the first of their leaves, without gaps, and
// numbers of triangles. Values are copied, so they are the processor's to the bit.

struct WedgesCall {
    vertices: u32,
    triangles: u32,
    wedges: u32,
    /// Numbers of a wedge, and of a triangle.
    width: u32,
    face_width: u32,
}

@group(0) @binding(0) var<storage, read> splits: array<SplitBlock>;
/// Of every wedge the split of a vertex that its split is part of; `ALWAYS` of wedges of the base, and a number of no split
/// where that is not there.
@group(0) @binding(1) var<storage, read> owners: array<u32>;
/// Of the triangles in the order of the input: the leaves of wedges at the corners, then the triangle's numbers.
@group(0) @binding(2) var<storage, read> rows: array<u32>;
/// What the first wedges of splits have, and then what the second ones have.
@group(0) @binding(3) var<storage, read> values: array<u32>;
@group(1) @binding(0) var<storage, read_write> there: array<u32>;
@group(1) @binding(1) var<storage, read_write> shown: array<u32>;
@group(1) @binding(2) var<storage, read_write> shown_ranks: array<u32>;
/// Which wedges there are, how many before those of a word, and their list.
@group(1) @binding(3) var<storage, read_write> wedges: array<u32>;
@group(1) @binding(4) var<storage, read_write> ranks: array<u32>;
@group(1) @binding(5) var<storage, read_write> list: array<u32>;
/// What is drawn: wedges of triangles, the numbers of wedges, and those of triangles.
@group(1) @binding(6) var<storage, read_write> corners: array<u32>;
@group(1) @binding(7) var<storage, read_write> wedge_values: array<u32>;
@group(1) @binding(8) var<storage, read_write> face_values: array<u32>;
/// As `progressive_write.wgsl` has them.
@group(1) @binding(9) var<storage, read_write> arguments: array<u32>;
var<immediate> sizes: WedgesCall;

/// The number of wedges up to a leaf.
fn wedge_rank(leaf: u32) -> u32 {
    return ranks[leaf / 32u] + countOneBits(wedges[leaf / 32u] & bits_to(leaf % 32u));
}

/// Which wedges there are, and how many each word has.
@compute @workgroup_size(GROUP)
fn mark_wedges(id: Invocation) {
    let wedge = linear_item(id);
    var is_there = false;
    if wedge < sizes.wedges {
        let owner = owners[wedge];
        is_there = owner == ALWAYS;
        if owner < sizes.vertices {
            is_there = (there[owner / 32u] >> (owner % 32u) & 1u) == 1u;
        }
    }
    let word = gathered(id.local, is_there);
    if wedge < sizes.wedges && id.local % 32u == 0u {
        wedges[wedge / 32u] = word;
        ranks[wedge / 32u] = countOneBits(word);
    }
}

@compute @workgroup_size(GROUP)
fn list_wedges(id: Invocation) {
    let wedge = linear_item(id);
    if wedge >= sizes.wedges {
        return;
    }
    let rank = wedge_rank(wedge);
    if wedge == sizes.wedges - 1u {
        arguments[6] = rank;
    }
    if (wedges[wedge / 32u] >> (wedge % 32u) & 1u) == 1u {
        list[rank - 1u] = wedge;
    }
}

/// The key of the split that makes a wedge.
fn key_of(wedge: u32) -> u32 {
    let owner = owners[wedge];
    if owner == ALWAYS {
        return ALWAYS;
    }
    return splits[owner].key;
}

/// Its own split and that of the next wedge are the last ones that have made it what it is: of those the one of lesser key.
@compute @workgroup_size(GROUP)
fn write_wedges(id: Invocation) {
    let item = linear_item(id);
    if item >= arguments[6] {
        return;
    }
    let wedge = list[item];
    var first = (sizes.wedges + wedge) * sizes.width;
    if item + 1u < arguments[6] {
        let next = list[item + 1u];
        // Numbers grow along the list, so that of equal keys the wedge's own is the lesser.
        if key_of(next) < key_of(wedge) {
            first = next * sizes.width;
        }
    }
    for (var k = 0u; k < sizes.width; k++) {
        wedge_values[item * sizes.width + k] = values[first + k];
    }
}

@compute @workgroup_size(GROUP)
fn write_corners(id: Invocation) {
    let triangle = linear_item(id);
    if triangle >= sizes.triangles {
        return;
    }
    let word = shown[triangle / 32u];
    if (word >> (triangle % 32u) & 1u) == 0u {
        return;
    }
    let place = shown_ranks[triangle / 32u] + countOneBits(word & bits_to(triangle % 32u)) - 1u;
    let row = triangle * (3u + sizes.face_width);
    for (var side = 0u; side < 3u; side++) {
        corners[3u * place + side] = wedge_rank(rows[row + side]) - 1u;
    }
    for (var k = 0u; k < sizes.face_width; k++) {
        face_values[place * sizes.face_width + k] = rows[row + 3u + k];
    }
}
