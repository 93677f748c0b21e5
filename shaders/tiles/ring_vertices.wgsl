// import ring_links
// import ring_means
// The values of vertices, which all texels around them get where they are not copied. The same as `vertex` in `ring` of
// rust/tiles.

const RING_REGULAR: u32 = 0u;
const RING_TEE: u32 = 1u;
const RING_BOUNDARY: u32 = 3u;
const RING_PINNED: u32 = 4u;

struct Vertex {
    // Whether all texels around it get one value; else they are copied.
    single: bool,
    // In the frame of the ring's first tile.
    words: vec2<u32>,
}

fn vertex_of(ring: u32) -> Vertex {
    let at = VERTEX_WORDS * ring_number(ring);
    return Vertex(
        atomicLoad(&vertices[at + 1u]) == 1u,
        vec2(atomicLoad(&vertices[at + 2u]), atomicLoad(&vertices[at + 3u])),
    );
}

/// The value at the vertex of `ring`, as a tile has that is at a corner of it. In the middle of an edge, where no corner is,
/// there is none but the blank one, which all see.
fn end_of(ring: u32, tile: u32, corner: u32) -> Vertex {
    let vertex = vertex_of(ring);
    return Vertex(vertex.single, words_seen(vertex.words, turn_at(tile, corner, FROM_FIRST, ring_flips(ring))));
}

/// A border texel as it is once its tile's corners have the values of their vertices.
fn settled_at(tile: u32, edge: u32, k: u32) -> vec2<u32> {
    let last = size_of(tile) - 1u;
    if k == 0u || k == last {
        let corner = select(edge + 1u, edge, k == 0u);
        let end = end_of(ring_at(tile, corner), tile, corner);
        if end.single {
            return end.words;
        }
    }
    return border_at(tile, edge, k);
}

/// How many turns an inner loop makes: rings may have as many entries as lavapipe's loops have turns.
const TURNS: u32 = 1024u;

fn make_vertex(ring: u32) -> Vertex {
    let first = topology[work.rings + 2u * ring];
    let kind = topology[work.rings + 2u * ring + 1u];
    let end = topology[work.rings + 2u * ring + 2u];
    let blank = Vertex(true, words_near(work.blank));
    if kind == RING_PINNED {
        return blank;
    }
    let density = density_of(topology[work.entries + 2u * first]);
    let flips = topology[work.entries + 2u * first + 1u];
    var even = true;
    var there = true;
    // Whether all tiles have what the first one has, as they see it.
    var same = FRAMED == 1u;
    var whole = vec2(0u);
    var sum: Sum;
    for (var start = first; start < end; start += TURNS) {
        for (var i = start; i < min(start + TURNS, end); i++) {
            let tile = topology[work.entries + 2u * i];
            let place = topology[work.entries + 2u * i + 1u];
            there = there && is_there(tile);
            even = even && density_of(tile) == density;
            if there && (place & 4u) == 0u {
                let corner = place & 3u;
                let turns_over = ((place ^ flips) & 8u) != 0u;
                let own = corner_of(tile, corner);
                if i == first {
                    whole = own;
                }
                if same && i > first {
                    let expected = words_seen(whole, turn_at(tile, corner, FROM_FIRST, turns_over));
                    same = all(value_of(expected) == value_of(own));
                }
                sum = added(sum, seen(own, turn_at(tile, corner, TO_FIRST, turns_over)));
            }
        }
    }
    if !there {
        return blank;
    }
    let few = kind == RING_REGULAR || (kind == RING_BOUNDARY && end - first <= 2u);
    if kind == RING_TEE || (even && few) {
        return Vertex(false, vec2(0u));
    }
    // Frames that are turned round otherwise: what was made equal already stays as it is.
    if same {
        return Vertex(true, whole);
    }
    return Vertex(true, mean_words(sum, end - first));
}
