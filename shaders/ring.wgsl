// import colors
// The ring update: what tiles know of their neighbours (Schäfer et al. 2014, *Real-Time Deformation of Subdivision Surfaces
// from Object Collisions*, Section 6). The same as `ring` of rust/tiles, in three dispatches: the values of vertices, the
// borders, and the rings. Each reads what the ones before it wrote, and texels that it does not write itself.

struct Ring {
    // What tiles without a block read as: a colour, or a coefficient of displacement.
    blank: vec4<f32>,
    // Where rings and their entries begin in the topology.
    rings: u32,
    entries: u32,
    // The number of this update, by which a vertex is made once.
    run: u32,
    // What texels are: 0 half floats, 1 colours of 8 bits, 2 those of half floats.
    format: u32,
    // Words of a block of those that are worked on; 0 where there are none.
    room: u32,
    // 1 where tiles without a block count as blank ones.
    loose: u32,
    // Of mips texels along an edge of the cage, at most: every tile is seen at the level that is nearest to it. 0 for the
    // tiles themselves.
    density: u32,
    // The mips that are made of what is below them.
    level: u32,
}

// The tiles to bring up to date, and first how many.
@group(0) @binding(0) var<storage, read> listed: array<u32>;
@group(0) @binding(1) var<storage, read> counts: array<u32>;
// Of every tile the block that is worked on, if there are such blocks, and those; of mips the first word, and those.
@group(0) @binding(2) var<storage, read> pointers: array<u32>;
@group(0) @binding(3) var<storage, read_write> blocks: array<atomic<u32>>;
// Of every tile the first word of its block, and its texels a side; the latter again, of tiles without a block too if these
// count as blank ones.
@group(0) @binding(4) var<storage, read> entries: array<vec2<u32>>;
@group(0) @binding(5) var<storage, read> sizes: array<vec2<u32>>;
@group(0) @binding(6) var<storage, read_write> texels: array<atomic<u32>>;
// Of every tile four links and four rings, see `DeviceRing`, then what means of bytes go by: of every byte its linear value
// in 65,535ths, and the least sum of four of them, in sixteens, that is the byte. Then of every ring the first entry and
// the class, then of every entry the tile and where it is.
@group(0) @binding(7) var<storage, read> topology: array<u32>;
// Of every ring the update that made it, whether it gives all its texels one value, and that.
@group(0) @binding(8) var<storage, read_write> vertices: array<atomic<u32>>;
var<immediate> work: Ring;

const NONE: u32 = 0xffffffffu;
const TILE_WORDS: u32 = 20u;
const VERTEX_WORDS: u32 = 4u;

const BOUNDARY: u32 = 0u;
const PINNED: u32 = 1u;
const WHOLE: u32 = 2u;
const HALF: u32 = 3u;
const HALVES: u32 = 4u;

const RING_REGULAR: u32 = 0u;
const RING_TEE: u32 = 1u;
const RING_BOUNDARY: u32 = 3u;
const RING_PINNED: u32 = 4u;

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

fn is_there(tile: u32) -> bool {
    return work.loose == 1u || entries[tile].x != NONE;
}

fn is_sub(tile: u32) -> u32 {
    return (topology[TILE_WORDS * tile] >> 9u) & 1u;
}

/// The level at which a tile is seen.
fn level_of(tile: u32) -> u32 {
    if work.density == 0u {
        return 0u;
    }
    let size = sizes[tile].y;
    return min(firstLeadingBit(max((size << is_sub(tile)) / work.density, 1u)), firstTrailingBit(size) - 1u);
}

fn size_of(tile: u32) -> u32 {
    return sizes[tile].y >> level_of(tile);
}

/// Whether what is brought up to date of a tile is of this density.
fn is_updated(tile: u32) -> bool {
    return work.density == 0u || (level_of(tile) > 0u && size_of(tile) << is_sub(tile) == work.density);
}

/// Texels along an edge of the cage.
fn density_of(tile: u32) -> u32 {
    return select(0u, size_of(tile) << is_sub(tile), is_there(tile));
}

fn block_of(tile: u32) -> u32 {
    if work.room == 0u {
        return NONE;
    }
    return pointers[tile];
}

fn is_wide() -> bool {
    return work.format == 2u;
}

fn value_of(words: vec2<u32>) -> vec4<f32> {
    if work.format == 0u {
        return vec4(unpack2x16float(words.x).x, 0.0, 0.0, 0.0);
    }
    return color_of(words, is_wide());
}

fn words_near(value: vec4<f32>) -> vec2<u32> {
    if work.format == 0u {
        return vec2(half_bits(clamp(value.x, -COLOR_MOST, COLOR_MOST)), 0u);
    }
    return words_of(value, is_wide());
}

/// What a neighbour sees that is wound the other way if `flips`.
fn words_seen(words: vec2<u32>, flips: bool) -> vec2<u32> {
    let changes = flips && work.format == 0u && (words.x & 0x7fffu) != 0u;
    return vec2(words.x ^ select(0u, 0x8000u, changes), words.y);
}

fn value_seen(value: vec4<f32>, flips: bool) -> vec4<f32> {
    return select(value, -value, flips && work.format == 0u);
}

/// Word `at` of a block that is worked on, or of the tiles.
fn word_at(worked: bool, at: u32) -> u32 {
    if worked {
        return atomicLoad(&blocks[at]);
    }
    return atomicLoad(&texels[at]);
}

// Where a block is.
struct Home {
    worked: bool,
    first: u32,
}

fn home_of(tile: u32, level: u32) -> Home {
    if level > 0u {
        var texels_before = 0u;
        for (var k = 1u; k < level; k++) {
            let stride = (sizes[tile].y >> k) + 2u;
            texels_before += stride * stride;
        }
        let words = select(texels_before * select(1u, 2u, is_wide()), texels_before / 2u, work.format == 0u);
        return Home(true, select(pointers[tile] + words, NONE, pointers[tile] == NONE));
    }
    let block = block_of(tile);
    return Home(block != NONE, select(block * work.room, entries[tile].x, block == NONE));
}

/// The texel with an index in the block of a tile at a level.
fn texel_in(tile: u32, level: u32, index: u32) -> vec2<u32> {
    let home = home_of(tile, level);
    let worked = home.worked;
    let first = home.first;
    if first == NONE {
        return words_near(work.blank);
    }
    if work.format == 0u {
        let pair = word_at(worked, first + index / 2u);
        return vec2((pair >> (16u * (index & 1u))) & 0xffffu, 0u);
    }
    let words = select(1u, 2u, is_wide());
    var found = vec2(word_at(worked, first + words * index), 0u);
    if is_wide() {
        found.y = word_at(worked, first + words * index + 1u);
    }
    return found;
}

/// Sets the bits `mask` of a word, whose others somebody else may write.
fn write_word(worked: bool, at: u32, bits: u32, mask: u32) {
    if worked {
        atomicAnd(&blocks[at], ~mask);
        atomicOr(&blocks[at], bits);
        return;
    }
    atomicAnd(&texels[at], ~mask);
    atomicOr(&texels[at], bits);
}

fn texel_at(tile: u32, index: u32) -> vec2<u32> {
    return texel_in(tile, level_of(tile), index);
}

fn write_texel(tile: u32, index: u32, words: vec2<u32>) {
    write_in(tile, level_of(tile), index, words);
}

/// Writes a texel at a level.
fn write_in(tile: u32, level: u32, index: u32, words: vec2<u32>) {
    let home = home_of(tile, level);
    let worked = home.worked;
    let first = home.first;
    if first == NONE {
        return;
    }
    if work.format == 0u {
        let shift = 16u * (index & 1u);
        write_word(worked, first + index / 2u, words.x << shift, 0xffffu << shift);
        return;
    }
    let at = first + select(1u, 2u, is_wide()) * index;
    write_word(worked, at, words.x, NONE);
    if is_wide() {
        write_word(worked, at + 1u, words.y, NONE);
    }
}

/// The index of texel `k` along an edge, −1 and `size` among them; `depth` is 0 for the border, −1 for the ring.
fn line_at(size: u32, edge: u32, depth: i32, k: i32) -> u32 {
    let n = i32(size);
    let stride = n + 2;
    switch edge & 3u {
        case 0u: {
            return u32((depth + 1) * stride + 1 + k);
        }
        case 1u: {
            return u32(stride + n - depth + k * stride);
        }
        case 2u: {
            return u32((n - depth) * stride + n - k);
        }
        default: {
            return u32(n * stride + depth + 1 - k * stride);
        }
    }
}

fn border_at(tile: u32, edge: u32, k: u32) -> vec2<u32> {
    return texel_at(tile, line_at(size_of(tile), edge, 0, i32(k)));
}

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

/// The value at the vertex of `ring`, as a tile has that is wound as its bit says.
fn end_of(ring: u32) -> Vertex {
    let vertex = vertex_of(ring);
    return Vertex(vertex.single, words_seen(vertex.words, ring_flips(ring)));
}

/// `ring` as a tile has that is somewhere at it.
fn ring_in(tile: u32, ring: u32) -> u32 {
    for (var corner = 0u; corner < 4u; corner++) {
        let own = ring_at(tile, corner);
        if ring_number(own) == ring_number(ring) {
            return own;
        }
    }
    for (var edge = 0u; edge < 4u; edge++) {
        let link = link_of(tile, edge);
        if link.kind == HALVES && ring_number(link.middle) == ring_number(ring) {
            return link.middle;
        }
    }
    return ring;
}

/// A border texel as it is once its tile's corners have the values of their vertices.
fn settled_at(tile: u32, edge: u32, k: u32) -> vec2<u32> {
    let last = size_of(tile) - 1u;
    if k == 0u || k == last {
        let end = end_of(ring_at(tile, select(edge + 1u, edge, k == 0u)));
        if end.single {
            return end.words;
        }
    }
    return border_at(tile, edge, k);
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

// A coefficient of the edge curve of the coarser neighbour along a span of a finer side.
struct CurvePlace {
    tile: u32,
    edge: u32,
    span: Span,
    q: u32,
}

/// The coefficient as the neighbour sees it: the mean of its border and of its ring.
fn edge_curve(at: CurvePlace) -> vec4<f32> {
    let span = at.span;
    if !is_there(span.tile) || !is_there(at.tile) {
        return work.blank;
    }
    let ratio = span.count / span.length;
    var sum = vec4(0.0);
    var other = vec4(0.0);
    for (var k = 0u; k <= ratio; k++) {
        let own = k < ratio;
        let tile = select(span.tile, at.tile, own);
        let edge = select(span.edge, at.edge, own);
        let texel = settled_at(tile, edge, select(across(span, at.q), span.start + at.q * ratio + k, own));
        if own {
            sum += value_of(words_seen(texel, span.reversed));
        } else {
            other = value_of(texel);
        }
    }
    return 0.5 * (other + value_of(words_near(sum / f32(ratio))));
}

/// What an edge curve goes on with beyond an end of a span, which is the middle of a quad's edge.
fn beyond(at: CurvePlace, end: u32) -> CurvePlace {
    var place = at;
    let link = link_of(at.tile, at.edge);
    place.q = select(0u, at.span.length - 1u, end == 1u);
    if link.kind == HALVES {
        place.span = span_of(at.tile, at.edge, end);
        place.q = select(place.span.length - 1u, 0u, end == 1u);
    } else if link.kind == HALF {
        let quad = link_of(link.tiles.x, link.edges.x);
        let which = select(1u, 0u, link.second);
        place.tile = quad.tiles[which];
        place.edge = quad.edges[which];
        place.span = span_of(place.tile, place.edge, 0u);
        let starts = ring_number(place.span.ends.x) == ring_number(at.span.ends[end]);
        place.q = select(place.span.length - 1u, 0u, starts);
    }
    return place;
}

/// As `edge_curve`, with one coefficient more at each end.
fn ended_curve(tile: u32, edge: u32, span: Span, q: i32) -> vec4<f32> {
    let last = i32(span.length) - 1;
    var place = CurvePlace(tile, edge, span, u32(clamp(q, 0, last)));
    // The later end wins where there is one coefficient.
    for (var k = 2u; k > 0u; k--) {
        let end = k - 1u;
        let outside = select(q < 0, last < q, end == 1u);
        let at_end = select(q == 0, q == last, end == 1u);
        if outside || at_end {
            let vertex = end_of(ring_in(span.tile, span.ends[end]));
            if vertex.single {
                return value_of(vertex.words);
            }
            if outside {
                place = beyond(place, end);
                break;
            }
        }
    }
    return edge_curve(place);
}

/// The ring beside a span whose neighbour is coarser, at its texel `k`: twice the subdivided edge curve less the border.
fn finer_ring(tile: u32, edge: u32, span: Span, k: u32) -> vec2<u32> {
    let steps = firstTrailingBit(span.count / span.length);
    let q = i32(k >> steps);
    var curve: array<vec4<f32>, 3>;
    for (var i = 0; i < 3; i++) {
        curve[i] = ended_curve(tile, edge, span, q + i - 1);
    }
    var before = curve[0];
    var here = curve[1];
    var after = curve[2];
    for (var step = steps; step > 0u; step--) {
        let left = 0.25 * before + 0.75 * here;
        let right = 0.75 * here + 0.25 * after;
        if ((k >> (step - 1u)) & 1u) == 0u {
            before = 0.75 * before + 0.25 * here;
            here = left;
            after = right;
        } else {
            after = 0.25 * here + 0.75 * after;
            before = left;
            here = right;
        }
    }
    let own = value_of(settled_at(tile, edge, span.start + k));
    return words_near(2.0 * value_seen(here, span.reversed) - own);
}

/// The ring beside a span, at its texel `q`, wherever its ends are.
fn beside_span(tile: u32, edge: u32, span: Span, q: u32) -> vec2<u32> {
    if !is_there(span.tile) {
        return words_near(work.blank);
    }
    if span.count == span.length {
        return words_seen(border_at(span.tile, span.edge, across(span, q)), span.reversed);
    }
    if span.count > span.length {
        return finer_ring(tile, edge, span, q);
    }
    let ratio = span.length / span.count;
    var sum = vec4(0.0);
    for (var k = 0u; k < ratio; k++) {
        let other = settled_at(span.tile, span.edge, across(span, q * ratio + k));
        sum += value_of(words_seen(other, span.reversed));
    }
    return words_near(sum / f32(ratio));
}

/// Texel `k` of the ring along an edge.
fn ring_texel(tile: u32, edge: u32, k: u32) -> vec2<u32> {
    let size = size_of(tile);
    let kind = link_of(tile, edge).kind;
    if kind == PINNED {
        return words_near(work.blank);
    }
    if kind == BOUNDARY {
        return settled_at(tile, edge, k);
    }
    let span = span_with(tile, edge, k);
    let q = k - span.start;
    if is_there(span.tile) {
        for (var end = 0u; end < 2u; end++) {
            if q == select(0u, span.count - 1u, end == 1u) {
                let vertex = end_of(span.ends[end]);
                if vertex.single {
                    return vertex.words;
                }
            }
        }
    }
    return beside_span(tile, edge, span, q);
}

// A texel as another tile sees it: of a side's ring, or of its border.
struct Seen {
    tile: u32,
    edge: u32,
    k: u32,
    flips: bool,
    border: bool,
}

/// What the corner of a ring is at a vertex where texels are copied; no tile if nothing.
fn diagonal(tile: u32, corner: u32) -> Seen {
    let ring = ring_number(ring_at(tile, corner));
    let first = topology[work.rings + 2u * ring];
    let count = topology[work.rings + 2u * ring + 2u] - first;
    // Where texels are copied there are few of them.
    var own = NONE;
    for (var i = 0u; i < min(count, 8u); i++) {
        let at = work.entries + 2u * (first + i);
        if own == NONE && topology[at] == tile && (topology[at + 1u] & 7u) == corner {
            own = i;
        }
    }
    if own == NONE {
        return Seen(NONE, 0u, 0u, false, true);
    }
    let tee = topology[work.rings + 2u * ring + 1u] == RING_TEE;
    let other = select((own + count / 2u) % count, select(0u, 1u, own == 0u), tee);
    let at = work.entries + 2u * (first + other);
    let flips = ((topology[at + 1u] ^ topology[work.entries + 2u * (first + own) + 1u]) & 8u) != 0u;
    var seen = Seen(topology[at], topology[at + 1u] & 3u, 0u, flips, true);
    if tee {
        // What the other sub-tile has across its half of the quad's edge.
        let at_end = seen.edge == 1u;
        seen.edge = select(3u, 0u, at_end);
        seen.k = select(0u, size_of(seen.tile) - 1u, at_end);
        seen.border = false;
    }
    return seen;
}

/// The texel nearest to the mean of `count` texels that sum to `sum`.
fn mean_words(sum: vec4<f32>, count: u32) -> vec2<u32> {
    let n = f32(count);
    let near = words_near(sum / n);
    if work.format != 0u || (near.x & 0x7fffu) == 0u {
        return near;
    }
    // Devices' quotients are not the nearest: on which side of the middles beside it the mean is, products say exactly.
    let size = abs(sum.x);
    let bits = near.x & 0x7fffu;
    let here = unpack2x16float(bits).x;
    let above = 0.5 * (here + unpack2x16float(min(bits + 1u, 0x7bffu)).x) * n;
    let below = 0.5 * (here + unpack2x16float(bits - 1u).x) * n;
    let odd = (bits & 1u) == 1u;
    var held = bits;
    if bits < 0x7bffu && (size > above || (size == above && odd)) {
        held = bits + 1u;
    } else if size < below || (size == below && odd) {
        held = bits - 1u;
    }
    return vec2((near.x & 0x8000u) | held, 0u);
}

/// The mean of the two by two texels at a column and a row of the block of a tile at a level, of which `known` is the one of
/// that number.
fn mean_of(tile: u32, level: u32, cell: vec2<u32>, number: u32, known: vec2<u32>) -> vec2<u32> {
    let stride = (sizes[tile].y >> level) + 2u;
    var four: array<vec2<u32>, 4>;
    for (var k = 0u; k < 4u; k++) {
        four[k] = known;
        if k != number {
            four[k] = texel_in(tile, level, (cell.y + k / 2u) * stride + cell.x + k % 2u);
        }
    }
    if work.format == 1u {
        return vec2(mean_of_bytes(vec4(four[0].x, four[1].x, four[2].x, four[3].x)), 0u);
    }
    return words_near(0.25 * ((value_of(four[0]) + value_of(four[1])) + (value_of(four[2]) + value_of(four[3]))));
}

// Bytes, and their two tables in the topology, before the rings.
const BYTES: u32 = 256u;

/// The mean of four colours of bytes, by whole numbers as the processor finds it.
fn mean_of_bytes(four: vec4<u32>) -> u32 {
    let values = work.rings - 2u * BYTES;
    var sum = vec3(0u);
    for (var k = 0u; k < 4u; k++) {
        let word = four[k];
        sum += vec3(
            topology[values + (word & 255u)],
            topology[values + ((word >> 8u) & 255u)],
            topology[values + ((word >> 16u) & 255u)],
        );
    }
    // The last byte that begins at or before the sum.
    var bytes = vec3(0u);
    for (var step = BYTES / 2u; step > 0u; step /= 2u) {
        let next = bytes + vec3(step);
        let at = next + vec3(values + BYTES);
        let least = vec3(topology[at.x], topology[at.y], topology[at.z]);
        bytes = select(bytes, next, least <= sum / 16u);
    }
    let alpha = dot((four >> vec4(24u)), vec4(1u));
    return bytes.x | (bytes.y << 8u) | (bytes.z << 16u) | (((alpha + 2u) / 4u) << 24u);
}

/// The texel of a tile's border at a corner; of a mip, before it is equalised.
fn corner_of(tile: u32, corner: u32) -> vec2<u32> {
    var size = sizes[tile].y;
    var words = texel_in(tile, 0u, line_at(size, corner, 0, 0));
    let right = corner == 1u || corner == 2u;
    let up = corner >= 2u;
    for (var level = 0u; level < level_of(tile); level++) {
        let cell = vec2(select(1u, size - 1u, right), select(1u, size - 1u, up));
        words = mean_of(tile, level, cell, select(0u, 1u, right) + select(0u, 2u, up), words);
        size /= 2u;
    }
    return words;
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
    var sum = vec4(0.0);
    for (var start = first; start < end; start += TURNS) {
        for (var i = start; i < min(start + TURNS, end); i++) {
            let tile = topology[work.entries + 2u * i];
            let place = topology[work.entries + 2u * i + 1u];
            there = there && is_there(tile);
            even = even && density_of(tile) == density;
            if there && (place & 4u) == 0u {
                sum += value_of(words_seen(corner_of(tile, place & 3u), ((place ^ flips) & 8u) != 0u));
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
    return Vertex(true, mean_words(sum, end - first));
}

/// Tile `group` of the list, or none.
fn tile_of(group: vec3<u32>, groups: vec3<u32>) -> u32 {
    let index = group.x + groups.x * group.z;
    return select(NONE, listed[min(index, arrayLength(&listed) - 1u)], index < counts[0]);
}

// The values of the vertices of a tile and of those across its edges.
@compute @workgroup_size(64)
fn make_vertices(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let tile = tile_of(group, groups);
    if tile == NONE || group.y > 0u || local >= 40u {
        return;
    }
    var ring = NONE;
    if local < 4u {
        ring = ring_at(tile, local);
    } else if local < 8u {
        let link = link_of(tile, local - 4u);
        ring = select(NONE, link.middle, link.kind == HALVES);
    } else {
        let link = link_of(tile, (local - 8u) / 8u);
        let which = (local / 4u) % 2u;
        if link.kind >= WHOLE && (which == 0u || link.kind == HALVES) {
            ring = ring_at(link.tiles[which], local);
        }
    }
    if ring == NONE {
        return;
    }
    let at = VERTEX_WORDS * ring_number(ring);
    if atomicExchange(&vertices[at], work.run) == work.run {
        return;
    }
    let made = make_vertex(ring_number(ring));
    atomicStore(&vertices[at + 1u], select(0u, 1u, made.single));
    atomicStore(&vertices[at + 2u], made.words.x);
    atomicStore(&vertices[at + 3u], made.words.y);
}

// Corners that get the value of their vertex, and borders that are blank.
@compute @workgroup_size(GROUP)
fn settle_borders(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let tile = tile_of(group, groups);
    if tile == NONE {
        return;
    }
    let size = size_of(tile);
    let edge = (group.y * GROUP + local) / size;
    let k = (group.y * GROUP + local) % size;
    if edge >= 4u || !is_updated(tile) {
        return;
    }
    let index = line_at(size, edge, 0, i32(k));
    if k == 0u {
        let end = end_of(ring_at(tile, edge));
        if end.single {
            write_texel(tile, index, end.words);
        }
        return;
    }
    if work.density > 0u {
        return;
    }
    let link = link_of(tile, edge);
    var clears = link.kind == PINNED;
    if link.kind >= WHOLE {
        clears = !is_there(span_with(tile, edge, k).tile);
    }
    if link.kind == HALVES && (k + 1u == size / 2u || k == size / 2u) {
        clears = clears || vertex_of(link.middle).single;
    }
    if clears {
        write_texel(tile, index, words_near(work.blank));
    }
}

// The ring, from borders that are settled.
@compute @workgroup_size(GROUP)
fn make_rings(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let tile = tile_of(group, groups);
    if tile == NONE {
        return;
    }
    let size = size_of(tile);
    let edge = (group.y * GROUP + local) / (size + 1u);
    let k = i32((group.y * GROUP + local) % (size + 1u)) - 1;
    if edge >= 4u || !is_updated(tile) {
        return;
    }
    let index = line_at(size, edge, -1, k);
    var seen = Seen(tile, edge, u32(max(k, 0)), false, false);
    if k < 0 {
        let end = end_of(ring_at(tile, edge));
        if end.single {
            write_texel(tile, index, end.words);
            return;
        }
        seen = diagonal(tile, edge);
    }
    var texel = words_near(work.blank);
    if seen.tile != NONE && seen.border {
        texel = border_at(seen.tile, seen.edge, seen.k);
    } else if seen.tile != NONE {
        texel = ring_texel(seen.tile, seen.edge, seen.k);
    }
    write_texel(tile, index, words_seen(texel, seen.flips));
}

// A level of mips: means of two by two texels of the level below (Schäfer et al. 2015, *Local Painting and Deformation of
// Meshes on the GPU*, Section 5). The same as `mip` of rust/tiles.
@compute @workgroup_size(GROUP)
fn make_mips(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let tile = tile_of(group, groups);
    if tile == NONE {
        return;
    }
    let size = sizes[tile].y >> work.level;
    let at = group.y * GROUP + local;
    if size < 2u || at >= size * size {
        return;
    }
    let cell = vec2(at % size, at / size);
    let mean = mean_of(tile, work.level - 1u, 2u * cell + vec2(1u), NONE, vec2(0u));
    write_in(tile, work.level, (cell.y + 1u) * (size + 2u) + cell.x + 1u, mean);
}

// Blank blocks of the tiles.
@compute @workgroup_size(GROUP)
fn make_blank(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let tile = tile_of(group, groups);
    if tile == NONE {
        return;
    }
    let stride = size_of(tile) + 2u;
    let at = group.y * GROUP + local;
    let blank = words_near(work.blank);
    if work.format == 0u {
        if 2u * at < stride * stride {
            atomicStore(&texels[entries[tile].x + at], blank.x | (blank.x << 16u));
        }
        return;
    }
    if at < stride * stride {
        let first = entries[tile].x + select(1u, 2u, is_wide()) * at;
        atomicStore(&texels[first], blank.x);
        if is_wide() {
            atomicStore(&texels[first + 1u], blank.y);
        }
    }
}
