// import brush_tiles
// import brush_smear
// A brush at every texel of the colours to modify: their new colours, and how many of them change (Schäfer et al. 2015,
// *Local Painting and Deformation of Meshes on the GPU*, Section 5.2).

/// The words of texel `index` of the block of a tile before the event.
fn before(first: u32, index: u32) -> vec2<u32> {
    if edit_is(WIDE) {
        return vec2(texels[first + 2u * index], texels[first + 2u * index + 1u]);
    }
    return vec2(texels[first + index], 0u);
}

/// A texel of a block as it was before the dab, of modes that look at neighbours (`brush_still`).
fn kept(block: u32, index: u32) -> vec4<f32> {
    let wide = work.flags & WIDE;
    let at = arrayLength(&blocks) / 2u + block * work.room + index * (1u + wide);
    return decoded(vec2(blocks[at], select(0u, blocks[at + wide], wide == 1u)));
}

fn place_at(tile: u32, size: u32, cell: vec2<u32>) -> BrushPlace {
    let uv = (vec2<f32>(cell) + vec2(0.5)) / f32(size);
    return brush_at(tile, uv, tiles_jet(tile, uv).d);
}

/// The new colour of the texel in column `i` and row `j`, the ring counted, of a tile that has `now` there.
fn edited(tile: u32, block: u32, size: u32, i: u32, j: u32, now: vec4<f32>) -> vec4<f32> {
    let cell = vec2(i - 1u, j - 1u);
    let at_place = place_at(tile, size, cell);
    var tint = Tint(work.color, at_place.share);
    if edit_is(STAMPED) && tint.share > 0.0 {
        let next = cells_beside(cell, size);
        let beside = place_at(tile, size, vec2(next.x, cell.y)).place;
        let over = place_at(tile, size, vec2(cell.x, next.y)).place;
        tint = paint_stamped(at_place.place, tint.share, tile_footprint(at_place.place, beside, over));
    }
    if work.mode == PAINT_SMEAR {
        return smeared_over(at_place, tint.share, now, true);
    }
    if !(tint.share > 0.0) {
        return now;
    }
    var mean = now;
    if work.mode == PAINT_BLUR {
        let stride = size + 2u;
        let at = j * stride + i;
        let rows = kept(block, at - stride) + kept(block, at + stride);
        let columns = kept(block, at - 1u) + kept(block, at + 1u);
        mean = 0.25 * (rows + columns);
    }
    return painted(tint, now, mean);
}

// One texel of the block of one tile.
@compute @workgroup_size(GROUP)
fn edit(id: Invocation) {
    let found = begin_edit(id.group.x + id.groups.x * id.group.z, id.local);
    let size = brush_tiles[found.x].size;
    if found.y != BLOCK_NONE {
        let count = select(0u, 1u, edit_texel(found.x, found.y, id.group.y * GROUP + id.local));
        note_texels(count, count);
    }
    finish_edit(found.y, size * size, id.group.y == 0u, id.local);
}

/// Makes a texel anew; returns whether it changes.
fn edit_texel(tile: u32, block: u32, index: u32) -> bool {
    let size = brush_tiles[tile].size;
    let stride = size + 2u;
    if index >= stride * stride {
        return false;
    }
    let at = block * work.room + index * (1u + (work.flags & WIDE));
    let taken = is_new(block) && work.mode != PAINT_BLUR;
    var old = coded(work.blank);
    if !taken {
        old = vec2(blocks[at], 0u);
        if edit_is(WIDE) {
            old.y = blocks[at + 1u];
        }
    } else if entries[tile].first != TILES_NONE {
        old = before(entries[tile].first, index);
    }
    let j = index / stride;
    let i = index % stride;
    var new_words = old;
    if j >= 1u && j <= size && i >= 1u && i <= size {
        let now = decoded(old);
        let color = edited(tile, block, size, i, j, now);
        if any(color != now) {
            new_words = coded(color);
        }
    }
    let differs = any(new_words != old);
    if differs {
        note_corner(block, size, i, j);
    }
    if taken || differs {
        blocks[at] = new_words.x;
        if edit_is(WIDE) {
            blocks[at + 1u] = new_words.y;
        }
    }
    return differs;
}
