// import brush_tiles
// import brush_sculpt_modes
// A brush at every texel of the tiles to modify: their new coefficients of displacement, and how many of them change
// (Schäfer et al. 2015, *Local Painting and Deformation of Meshes on the GPU*, Section 5.2).

/// A texel of a block as it was before the dab, of modes that look at neighbours (`brush_still`).
fn kept(block: u32, index: u32) -> f32 {
    let pair = unpack2x16float(blocks[arrayLength(&blocks) / 2u + block * work.room + index / 2u]);
    return select(pair.x, pair.y, (index & 1u) == 1u);
}

/// The displacement at texel (i, j) of a tile when the stroke began.
fn begun_at(tile: u32, size: u32, cell: vec2<u32>) -> f32 {
    let start = tiles_entries[tile];
    if start.first == TILES_NONE {
        return 0.0;
    }
    return tiles_texel(start.first, (cell.y + 1u) * (size + 2u) + cell.x + 1u);
}

fn place_at(tile: u32, size: u32, cell: vec2<u32>) -> BrushPlace {
    return brush_at(tile, (vec2<f32>(cell) + vec2(0.5)) / f32(size), begun_at(tile, size, cell));
}

/// The new coefficient at texel (i, j) of a tile that has `now` there.
fn edited(tile: u32, block: u32, size: u32, cell: vec2<u32>, now: f32) -> f32 {
    let at_place = place_at(tile, size, cell);
    var amount = vec2(at_place.share, work.height);
    if edit_is(STAMPED) && amount.x > 0.0 {
        let next = cells_beside(cell, size);
        let beside = place_at(tile, size, vec2(next.x, cell.y)).place;
        let over = place_at(tile, size, vec2(cell.x, next.y)).place;
        amount = sculpt_stamped(at_place.place, amount.x, tile_footprint(at_place.place, beside, over));
    }
    if !(amount.x > 0.0) {
        return now;
    }
    var it = Sculpted(now, now - begun_at(tile, size, cell), now, 1.0);
    if work.mode == SCULPT_SMOOTH {
        let stride = size + 2u;
        let at = (cell.y + 1u) * stride + cell.x + 1u;
        let rows = kept(block, at - stride) + kept(block, at + stride);
        let columns = kept(block, at - 1u) + kept(block, at + 1u);
        it.mean = 0.25 * (rows + columns);
    }
    if work.mode == SCULPT_INFLATE {
        let uv = (vec2<f32>(cell) + vec2(0.5)) / f32(size);
        it.facing = dot(vectors_displaced(tile, uv).normal, at_place.normal);
    }
    return sculpted(at_place, amount.x, amount.y, it);
}

// One word, two texels of a row, of the block of one tile.
@compute @workgroup_size(GROUP)
fn edit(id: Invocation) {
    let found = begin_edit(id.group.x + id.groups.x * id.group.z, id.local);
    let size = brush_tiles[found.x].size;
    if found.y != BLOCK_NONE {
        let count = edit_word(found.x, found.y, id.group.y * GROUP + id.local);
        note_texels(count, count);
    }
    finish_edit(found.y, size * size, id.group.y == 0u, id.local);
}

/// Makes two texels anew; returns how many of them change.
fn edit_word(tile: u32, block: u32, word: u32) -> u32 {
    let size = brush_tiles[tile].size;
    let stride = size + 2u;
    if word >= stride * stride / 2u {
        return 0u;
    }
    let at = block * work.room + word;
    let taken = is_new(block) && work.mode != SCULPT_SMOOTH;
    var old = 0u;
    if !taken {
        old = blocks[at];
    } else if entries[tile].first != TILES_NONE {
        old = texels[entries[tile].first + word];
    }
    let values = unpack2x16float(old);
    let row = 2u * word / stride;
    let column = 2u * word % stride;
    var new_word = 0u;
    var count = 0u;
    for (var k = 0u; k < 2u; k++) {
        let half = (old >> (16u * k)) & 0xffffu;
        var bits = half;
        let i = column + k;
        if row >= 1u && row <= size && i >= 1u && i <= size {
            let now = values[k];
            let value = edited(tile, block, size, vec2(i - 1u, row - 1u), now);
            if value != now {
                bits = half_bits(value);
            }
            if bits != half {
                note_corner(block, size, i, row);
                count++;
            }
        }
        new_word |= bits << (16u * k);
    }
    if taken || count > 0u {
        blocks[at] = new_word;
    }
    return count;
}
