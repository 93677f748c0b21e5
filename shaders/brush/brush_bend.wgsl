// import brush_tiles
// import brush_bend_modes
// A brush at every texel of the tiles to modify: their new vectors, and how many of them change (Schäfer et al. 2015, *Local
// Painting and Deformation of Meshes on the GPU*, Sections 3 and 5.2). The same as `vector` of rust/detail.

/// A texel of a block as it was before the dab, of modes that look at neighbours (`brush_still`).
fn kept(block: u32, index: u32) -> vec3<f32> {
    let first = arrayLength(&blocks) / 2u + block * work.room;
    var texel: vec3<f32>;
    for (var axis = 0u; axis < 3u; axis++) {
        let half = 3u * index + axis;
        let pair = unpack2x16float(blocks[first + half / 2u]);
        texel[axis] = select(pair.x, pair.y, (half & 1u) == 1u);
    }
    return texel;
}

/// The vector at a texel of a tile when the stroke began.
fn begun_at(tile: u32, size: u32, cell: vec2<u32>) -> vec3<f32> {
    let start = vectors_entries[tile];
    if start.first == TILES_NONE {
        return vec3(0.0);
    }
    return vectors_texel(start.first, (cell.y + 1u) * (size + 2u) + cell.x + 1u);
}

/// Where a texel of a tile is in the brush.
fn place_of(tile: u32, size: u32, cell: vec2<u32>) -> vec2<f32> {
    let uv = (vec2<f32>(cell) + vec2(0.5)) / f32(size);
    let at = framed_at(tile, uv);
    return brush_over(at.p + framed_out(at, begun_at(tile, size, cell)), at.n, tiles_jet(tile, uv).d).place.xy;
}

struct Bent {
    // Whether it has a share of the edit.
    shares: bool,
    vector: vec3<f32>,
}

/// The new vector at texel (i, j) of a tile that has `now` there.
fn edited(tile: u32, block: u32, size: u32, cell: vec2<u32>, now: vec3<f32>) -> Bent {
    let uv = (vec2<f32>(cell) + vec2(0.5)) / f32(size);
    let at = framed_at(tile, uv);
    let begun = begun_at(tile, size, cell);
    let found = brush_over(at.p + framed_out(at, begun), at.n, tiles_jet(tile, uv).d);
    var amount = vec4(0.0, 0.0, work.height, select(0.0, found.share, at.there));
    if edit_is(STAMPED) && amount.w > 0.0 {
        let next = cells_beside(cell, size);
        let beside = place_of(tile, size, vec2(next.x, cell.y));
        let over = place_of(tile, size, vec2(cell.x, next.y));
        let footprint = max(distance(found.place.xy, beside), distance(found.place.xy, over));
        amount = bend_stamped(found.place, amount.w, footprint);
    }
    if !(amount.w > 0.0) {
        return Bent(false, now);
    }
    var mean = now;
    if work.mode == SCULPT_SMOOTH {
        let stride = size + 2u;
        let index = (cell.y + 1u) * stride + cell.x + 1u;
        let rows = kept(block, index - stride) + kept(block, index + stride);
        mean = 0.25 * (rows + (kept(block, index - 1u) + kept(block, index + 1u)));
    }
    let change = framed_in(at, bend_change(found.place, amount.xyz, framed_out(at, now - begun)));
    return Bent(true, bent(now, change, mean, amount.w));
}

// Two texels of a row, three words, of the block of one tile.
@compute @workgroup_size(GROUP)
fn edit(id: Invocation) {
    let found = begin_edit(id.group.x + id.groups.x * id.group.z, id.local);
    let size = brush_tiles[found.x].size;
    if found.y != BLOCK_NONE {
        let count = edit_pair(found.x, found.y, id.group.y * GROUP + id.local);
        note_texels(count, count);
    }
    finish_edit(found.y, size * size, id.group.y == 0u, id.local);
}

/// Makes two texels anew; returns how many of them change.
fn edit_pair(tile: u32, block: u32, pair: u32) -> u32 {
    let size = brush_tiles[tile].size;
    let stride = size + 2u;
    if 2u * pair >= stride * stride {
        return 0u;
    }
    let at = block * work.room + 3u * pair;
    let taken = is_new(block) && work.mode != SCULPT_SMOOTH;
    var halves: array<u32, 6>;
    for (var word = 0u; word < 3u; word++) {
        var old = 0u;
        if !taken {
            old = blocks[at + word];
        } else if entries[tile].first != TILES_NONE {
            old = texels[entries[tile].first + 3u * pair + word];
        }
        halves[2u * word] = old & 0xffffu;
        halves[2u * word + 1u] = old >> 16u;
    }
    let row = 2u * pair / stride;
    let column = 2u * pair % stride;
    var count = 0u;
    for (var k = 0u; k < 2u; k++) {
        let i = column + k;
        if row >= 1u && row <= size && i >= 1u && i <= size {
            var now: vec3<f32>;
            for (var axis = 0u; axis < 3u; axis++) {
                now[axis] = unpack2x16float(halves[3u * k + axis]).x;
            }
            let made = edited(tile, block, size, vec2(i - 1u, row - 1u), now);
            var differs = false;
            for (var axis = 0u; axis < 3u && made.shares; axis++) {
                // Zeros are positive.
                let bits = half_bits(made.vector[axis]);
                let new_half = select(bits, 0u, (bits & 0x7fffu) == 0u);
                differs = differs || new_half != halves[3u * k + axis];
                halves[3u * k + axis] = new_half;
            }
            if differs {
                note_corner(block, size, i, row);
                count++;
            }
        }
    }
    if taken || count > 0u {
        for (var word = 0u; word < 3u; word++) {
            blocks[at + word] = halves[2u * word] | (halves[2u * word + 1u] << 16u);
        }
    }
    return count;
}
