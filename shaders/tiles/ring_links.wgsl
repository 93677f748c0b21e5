// import ring_tiles
// What lies across the edges of tiles and at their corners. The same as `spans` in `ring` of rust/tiles.

const BOUNDARY: u32 = 0u;
const PINNED: u32 = 1u;
const WHOLE: u32 = 2u;
const HALF: u32 = 3u;
const HALVES: u32 = 4u;

// What is across an edge.
struct Link {
    kind: u32,
    reversed: bool,
    // Of half an edge, whether it is the second half.
    second: bool,
    sub: bool,
    tiles: vec2<u32>,
    edges: vec2<u32>,
    middle: u32,
}

fn link_of(tile: u32, edge: u32) -> Link {
    let at = TILE_WORDS * tile + 4u * edge;
    let bits = topology[at];
    var link: Link;
    link.kind = bits & 7u;
    link.reversed = (bits & 8u) != 0u;
    link.edges = vec2((bits >> 4u) & 3u, (bits >> 6u) & 3u);
    link.second = (bits & 0x100u) != 0u;
    link.sub = (bits & 0x200u) != 0u;
    link.tiles = vec2(topology[at + 1u], topology[at + 2u]);
    link.middle = topology[at + 3u];
    return link;
}

/// The ring at a corner of a tile; the last bit is set where the tile is wound against the ring's first one.
fn ring_at(tile: u32, corner: u32) -> u32 {
    return topology[TILE_WORDS * tile + 16u + (corner & 3u)];
}

fn ring_number(ring: u32) -> u32 {
    return ring & 0x7fffffffu;
}

fn ring_flips(ring: u32) -> bool {
    return (ring >> 31u) != 0u;
}

// A part of a tile's edge and what lies across it.
struct Span {
    // Texels of this tile: the first and how many; none where nothing is across.
    start: u32,
    count: u32,
    // The neighbour's side, and its texels.
    tile: u32,
    edge: u32,
    first: u32,
    length: u32,
    reversed: bool,
    // The rings at both ends, as this tile has them.
    ends: vec2<u32>,
}

/// The part `which` of an edge.
fn span_of(tile: u32, edge: u32, which: u32) -> Span {
    let link = link_of(tile, edge);
    var span: Span;
    if link.kind < WHOLE || (which == 1u && link.kind != HALVES) {
        return span;
    }
    let size = size_of(tile);
    span.count = size;
    span.tile = link.tiles[which];
    span.edge = link.edges[which];
    span.length = size_of(span.tile);
    span.reversed = link.reversed;
    span.ends = vec2(ring_at(tile, edge), ring_at(tile, edge + 1u));
    if link.kind == HALF {
        span.length /= 2u;
        span.first = select(0u, span.length, link.second);
    }
    if link.kind == HALVES {
        span.count = size / 2u;
        span.start = which * span.count;
        span.ends = select(vec2(span.ends.x, link.middle), vec2(link.middle, span.ends.y), which == 1u);
    }
    return span;
}

/// The span that texel `k` of an edge is in.
fn span_with(tile: u32, edge: u32, k: u32) -> Span {
    let second = link_of(tile, edge).kind == HALVES && k >= size_of(tile) / 2u;
    return span_of(tile, edge, select(0u, 1u, second));
}

/// Where on the neighbour's edge texel `q` of a span is.
fn across(span: Span, q: u32) -> u32 {
    return span.first + select(span.length - 1u - q, q, span.reversed);
}

/// The corner of the neighbour that an end of a span is at, unless that is in the middle of its edge.
fn corner_across(span: Span, end: u32) -> u32 {
    return (span.edge + select(1u - end, end, span.reversed)) & 3u;
}

/// The ring at an end of a span as the neighbour has it.
fn ring_across(span: Span, end: u32) -> u32 {
    let ring = ring_at(span.tile, corner_across(span, end));
    return select(span.ends[end], ring, ring_number(ring) == ring_number(span.ends[end]));
}
