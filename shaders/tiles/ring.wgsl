// import ring_curves
// The ring update: what tiles know of their neighbours (Schäfer et al. 2014, *Real-Time Deformation of Subdivision Surfaces
// from Object Collisions*, Section 6). The same as `ring` of rust/tiles, in three dispatches: the values of vertices, the
// borders, and the rings. Each reads what the ones before it wrote, and texels that it does not write itself.

/// The ring beside a span, at its texel `q`, wherever its ends are.
fn beside_span(tile: u32, edge: u32, span: Span, q: u32) -> vec2<u32> {
    if !is_there(span.tile) {
        return words_near(work.blank);
    }
    if FRAMED == 0u && span.count == span.length {
        return words_seen(border_at(span.tile, span.edge, across(span, q)), plain(span.reversed));
    }
    if span.count > span.length {
        return finer_ring(tile, edge, span, q);
    }
    let ratio = span.length / span.count;
    var sum: Sum;
    for (var k = q * ratio; k < (q + 1u) * ratio; k++) {
        let other = settled_at(span.tile, span.edge, across(span, k));
        sum = added(sum, seen(other, turn_across(tile, edge, span, k, span.length)));
    }
    return words_near_sum(sum, ratio);
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
                let vertex = end_of(span.ends[end], tile, edge + end);
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
    var beside = Seen(topology[at], topology[at + 1u] & 3u, 0u, flips, true);
    if tee {
        // What the other sub-tile has across its half of the quad's edge.
        let at_end = beside.edge == 1u;
        beside.edge = select(3u, 0u, at_end);
        beside.k = select(0u, size_of(beside.tile) - 1u, at_end);
        beside.border = false;
    }
    return beside;
}

/// Tile `group` of the list, or none.
fn tile_of(id: Invocation) -> u32 {
    let index = id.group.x + id.groups.x * id.group.z;
    return select(NONE, listed[min(index, arrayLength(&listed) - 1u)], index < counts[0]);
}

// The values of the vertices of a tile and of those across its edges.
@compute @workgroup_size(64)
fn make_vertices(id: Invocation) {
    let tile = tile_of(id);
    if tile == NONE || id.group.y > 0u || id.local >= 40u {
        return;
    }
    var ring = NONE;
    if id.local < 4u {
        ring = ring_at(tile, id.local);
    } else if id.local < 8u {
        let link = link_of(tile, id.local - 4u);
        ring = select(NONE, link.middle, link.kind == HALVES);
    } else {
        let link = link_of(tile, (id.local - 8u) / 8u);
        let which = (id.local / 4u) % 2u;
        if link.kind >= WHOLE && (which == 0u || link.kind == HALVES) {
            ring = ring_at(link.tiles[which], id.local);
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
fn settle_borders(id: Invocation) {
    let tile = tile_of(id);
    if tile == NONE {
        return;
    }
    let size = size_of(tile);
    let edge = (id.group.y * GROUP + id.local) / size;
    let k = (id.group.y * GROUP + id.local) % size;
    if edge >= 4u || !is_updated(tile) {
        return;
    }
    let index = line_at(size, edge, 0, i32(k));
    if k == 0u {
        let end = end_of(ring_at(tile, edge), tile, edge);
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
fn make_rings(id: Invocation) {
    let tile = tile_of(id);
    if tile == NONE {
        return;
    }
    let size = size_of(tile);
    let edge = (id.group.y * GROUP + id.local) / (size + 1u);
    let k = i32((id.group.y * GROUP + id.local) % (size + 1u)) - 1;
    if edge >= 4u || !is_updated(tile) {
        return;
    }
    let index = line_at(size, edge, -1, k);
    var beside = Seen(tile, edge, u32(max(k, 0)), false, false);
    if k < 0 {
        let end = end_of(ring_at(tile, edge), tile, edge);
        if end.single {
            write_texel(tile, index, end.words);
            return;
        }
        beside = diagonal(tile, edge);
    }
    var texel = words_near(work.blank);
    if beside.tile != NONE && beside.border {
        texel = border_at(beside.tile, beside.edge, beside.k);
    } else if beside.tile != NONE {
        texel = ring_texel(beside.tile, beside.edge, beside.k);
    }
    if k < 0 {
        texel = words_seen(texel, turn_at(tile, edge, FROM_OPPOSITE, beside.flips));
    }
    write_texel(tile, index, texel);
}

// A level of mips: means of two by two texels of the level below (Schäfer et al. 2015, *Local Painting and Deformation of
// Meshes on the GPU*, Section 5). The same as `mip` of rust/tiles.
@compute @workgroup_size(GROUP)
fn make_mips(id: Invocation) {
    let tile = tile_of(id);
    if tile == NONE {
        return;
    }
    let size = sizes[tile].y >> work.level;
    let at = id.group.y * GROUP + id.local;
    if size < 2u || at >= size * size {
        return;
    }
    let cell = vec2(at % size, at / size);
    let mean = mean_of(tile, work.level - 1u, 2u * cell + vec2(1u), NONE, vec2(0u));
    write_in(tile, work.level, (cell.y + 1u) * (size + 2u) + cell.x + 1u, mean);
}

// Blank blocks of the tiles.
@compute @workgroup_size(GROUP)
fn make_blank(id: Invocation) {
    let tile = tile_of(id);
    if tile == NONE {
        return;
    }
    let stride = size_of(tile) + 2u;
    let at = id.group.y * GROUP + id.local;
    let blank = words_near(work.blank);
    if FRAMED == 1u {
        if 2u * at < stride * stride {
            for (var word = 0u; word < 3u; word++) {
                atomicStore(&texels[entries[tile].x + 3u * at + word], 0u);
            }
        }
        return;
    }
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
