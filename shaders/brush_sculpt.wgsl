// import brush_stamp
// A brush at every texel of the tiles to modify: their new coefficients of displacement, and how many of them change
// (Schäfer et al. 2015, *Local Painting and Deformation of Meshes on the GPU*, Section 5.2). The same as `mode` of
// rust/detail.

const DRAW: u32 = 0u;
const SMOOTH: u32 = 1u;
const FLATTEN: u32 = 2u;
const ERASE: u32 = 3u;
const CLAY: u32 = 4u;
const SCRAPE: u32 = 5u;
const LAYER: u32 = 6u;
const INFLATE: u32 = 7u;

// The least cosine that inflating divides by.
const LEAST_FACING: f32 = 0.25;

fn texel(first: u32, index: u32) -> f32 {
    let pair = unpack2x16float(texels[first + index / 2u]);
    return select(pair.x, pair.y, (index & 1u) == 1u);
}

/// How far a place that has risen is under the plane `height` over the middle of the box, along its normal; 0 where that
/// does not rise.
fn under(height: f32, level: f32, rise: f32, risen: f32) -> f32 {
    return select(0.0, fma(height, work.unit, -level) / rise - risen, rise > 0.0);
}

fn held(value: f32) -> f32 {
    return clamp(value, -MOST, MOST);
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
fn edited(tile: u32, size: u32, cell: vec2<u32>, now: f32) -> f32 {
    let uv = (vec2<f32>(cell) + vec2(0.5)) / f32(size);
    let at = (cell.y + 1u) * (size + 2u) + cell.x + 1u;
    let risen = now - begun_at(tile, size, cell);
    let at_place = place_at(tile, size, cell);
    let place = at_place.place;
    let rises = at_place.rises;
    var share = at_place.share;
    if !(share > 0.0) {
        return now;
    }
    var height = work.height;
    if edit_is(STAMPED) {
        let next = stamp_beside(cell, size);
        let beside = place_at(tile, size, vec2(next.x, cell.y)).place;
        let over = place_at(tile, size, vec2(cell.x, next.y)).place;
        let pixel = stamp_at(place.xy, stamp_footprint(place, beside, over));
        let channel = u32(stamp[1].z);
        let value = stamp[1].y * (pixel[channel] - stamp[1].x);
        share *= select(pixel.w, 1.0, channel == 3u);
        // Modes without a height are masked by it.
        if work.mode == DRAW || work.mode == CLAY || work.mode == LAYER || work.mode == INFLATE {
            height *= value;
        } else {
            share *= clamp(value, 0.0, 1.0);
        }
        if !(share > 0.0) {
            return now;
        }
    }
    switch work.mode {
        case DRAW: {
            return held(fma(height, share, now));
        }
        case SMOOTH: {
            let entry = entries[tile];
            if entry.first == TILES_NONE {
                return now;
            }
            let stride = size + 2u;
            let rows = texel(entry.first, at - stride) + texel(entry.first, at + stride);
            let columns = texel(entry.first, at - 1u) + texel(entry.first, at + 1u);
            return fma(0.25 * (rows + columns) - now, share, now);
        }
        case FLATTEN: {
            return held(fma(under(0.0, place.z, rises.z, risen), share, now));
        }
        case ERASE: {
            return fma(-now, share, now);
        }
        case CLAY: {
            let far = under(height, place.z, rises.z, risen);
            return held(fma(select(max(far, 0.0), min(far, 0.0), height < 0.0), share, now));
        }
        case SCRAPE: {
            return held(fma(min(under(0.0, place.z, rises.z, risen), 0.0), share, now));
        }
        case LAYER: {
            let far = fma(height, share, -risen);
            return held(now + select(max(far, 0.0), min(far, 0.0), height < 0.0));
        }
        case INFLATE: {
            let facing = dot(tiles_displaced(tile, uv).normal, at_place.normal);
            return held(fma(height / max(facing, LEAST_FACING), share, now));
        }
        default: {
            return now;
        }
    }
}

// One word, two texels of a row, of the block of one tile.
@compute @workgroup_size(GROUP)
fn edit(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let found = edited_block(group.x + groups.x * group.z);
    if local == 0u {
        atomicStore(&changed, 0u);
    }
    workgroupBarrier();
    if found.y != BLOCK_NONE {
        let count = edit_word(found.x, found.y, group.y * GROUP + local);
        if count > 0u {
            atomicAdd(&changed, count);
        }
    }
    workgroupBarrier();
    if local == 0u && found.y != BLOCK_NONE {
        note_block(found.x, found.y, atomicLoad(&changed), group.y == 0u);
    }
}

/// Makes two texels anew; returns how many of them change.
fn edit_word(tile: u32, block: u32, word: u32) -> u32 {
    let size = brush_tiles[tile].size;
    let stride = size + 2u;
    if word >= stride * stride / 2u {
        return 0u;
    }
    let at = block * work.room + word;
    let taken = is_new(block);
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
            let value = edited(tile, size, vec2(i - 1u, row - 1u), now);
            if value != now {
                bits = half_bits(value);
            }
            if bits != half {
                note_texel(block, size, i, row);
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
