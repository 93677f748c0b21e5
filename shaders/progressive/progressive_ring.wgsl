// import progressive_edited
// import progressive_bits
// What is beside vertices of a mesh that is marked and shown, if they have moved. A vertex has all leaves from its own up to
// that of the next one, so that corners in the order of leaves are by vertices in every mesh: those of triangles that are
// shown are listed without gaps.

struct RingCall {
    triangles: u32,
}

/// Corners of the triangles in the order of the input, three times the triangle and the side, by their leaves.
@group(0) @binding(0) var<storage, read> order: array<u32>;
@group(1) @binding(0) var<storage, read_write> shown: array<u32>;
@group(1) @binding(1) var<storage, read_write> shown_ranks: array<u32>;
@group(1) @binding(2) var<storage, read_write> indices: array<u32>;
/// As `progressive_write.wgsl` has them.
@group(1) @binding(3) var<storage, read_write> arguments: array<u32>;
/// Which corners are shown, how many before those of a word, and where in `indices` they are.
@group(1) @binding(4) var<storage, read_write> corners: array<u32>;
@group(1) @binding(5) var<storage, read_write> ranks: array<u32>;
@group(1) @binding(6) var<storage, read_write> list: array<u32>;
/// Of vertices that are drawn, the nodes.
@group(1) @binding(7) var<storage, read_write> nodes: array<u32>;
/// As `progressive_directions.wgsl` has them.
@group(1) @binding(8) var<storage, read_write> ends: array<vec2<u32>>;
@group(1) @binding(9) var<storage, read_write> ring: array<u32>;
var<immediate> sizes: RingCall;

fn is_shown(triangle: u32) -> bool {
    return (shown[triangle / 32u] >> (triangle % 32u) & 1u) == 1u;
}

/// Which corners are shown, and how many each word has.
@compute @workgroup_size(GROUP)
fn mark_corners(id: Invocation) {
    let item = linear_item(id);
    var is_there = false;
    if item < 3u * sizes.triangles {
        is_there = is_shown(order[item] / 3u);
    }
    let word = gathered(id.local, is_there);
    if item < 3u * sizes.triangles && id.local % 32u == 0u {
        corners[item / 32u] = word;
        ranks[item / 32u] = countOneBits(word);
    }
}

@compute @workgroup_size(GROUP)
fn list_corners(id: Invocation) {
    let item = linear_item(id);
    if item >= 3u * sizes.triangles || (corners[item / 32u] >> (item % 32u) & 1u) == 0u {
        return;
    }
    let triangle = order[item] / 3u;
    let place = shown_ranks[triangle / 32u] + countOneBits(shown[triangle / 32u] & bits_to(triangle % 32u)) - 1u;
    let rank = ranks[item / 32u] + countOneBits(corners[item / 32u] & bits_to(item % 32u)) - 1u;
    list[rank] = 3u * place + order[item] % 3u;
}

/// The other two vertices of a triangle at a corner, or twice the same if it has no area.
fn others(corner: u32) -> vec2<u32> {
    let first = corner - corner % 3u;
    let own = indices[corner];
    let after = indices[first + (corner + 1u) % 3u];
    let before = indices[first + (corner + 2u) % 3u];
    return select(vec2(after, before), vec2(own), after == own || before == own || after == before);
}

/// Of both other vertices at a corner whether no corner of its vertex before has it: those are what is beside.
@compute @workgroup_size(GROUP)
fn find_ring(id: Invocation) {
    let rank = linear_item(id);
    let count = arguments[0];
    if rank >= count {
        return;
    }
    let corner = list[rank];
    let own = indices[corner];
    if place_of(nodes[own]).moved == 0u {
        return;
    }
    let found = others(corner);
    var is_new = found != vec2(own);
    var first = rank;
    while first > 0u && indices[list[first - 1u]] == own {
        first -= 1u;
        let met = others(list[first]);
        is_new = is_new & (met.xx != found) & (met.yy != found);
        if !any(is_new) {
            break;
        }
    }
    if first == rank {
        ends[own].x = rank;
    }
    if rank + 1u == count || indices[list[min(rank + 1u, count - 1u)]] != own {
        ends[own].y = rank + 1u;
    }
    ring[rank] = corner | select(0u, AFTER, is_new.x) | select(0u, AFTER << 1u, is_new.y);
}
