// import brush_stamp
// A brush at every texel of the colours to modify: their new colours, and how many of them change (Schäfer et al. 2015,
// *Local Painting and Deformation of Meshes on the GPU*, Section 5.2). The same as `mode` of rust/detail. Colours are
// linear Rec.709 with alpha; of 8 bits they are kept sRGB-encoded (IEC 61966-2-1), alpha as it is.

const MIX: u32 = 0u;
const ADD: u32 = 1u;
const MULTIPLY: u32 = 2u;
const ERASE: u32 = 3u;
const BLUR: u32 = 4u;

fn linear_of(encoded: vec3<f32>) -> vec3<f32> {
    let power = pow((encoded + vec3(0.055)) / 1.055, vec3(2.4));
    return select(power, encoded / 12.92, encoded <= vec3(0.04045));
}

fn encoded_of(linear: vec3<f32>) -> vec3<f32> {
    let power = 1.055 * pow(linear, vec3(1.0 / 2.4)) - vec3(0.055);
    return select(power, 12.92 * linear, linear <= vec3(0.0031308));
}

/// A texel's colour: of 8 bits it is the first word.
fn decoded(words: vec2<u32>) -> vec4<f32> {
    if edit_is(WIDE) {
        return vec4(unpack2x16float(words.x), unpack2x16float(words.y));
    }
    let bytes = unpack4x8unorm(words.x);
    return vec4(linear_of(bytes.xyz), bytes.w);
}

fn coded(color: vec4<f32>) -> vec2<u32> {
    // What is not a number becomes 0.
    let known = select(vec4(0.0), color, color == color);
    if edit_is(WIDE) {
        let held = clamp(known, vec4(-MOST), vec4(MOST));
        let red = half_bits(held.x) | (half_bits(held.y) << 16u);
        return vec2(red, half_bits(held.z) | (half_bits(held.w) << 16u));
    }
    let held = clamp(known, vec4(0.0), vec4(1.0));
    let bytes = vec4<u32>(vec4(encoded_of(held.xyz), held.w) * 255.0 + vec4(0.5));
    return vec2(bytes.x | (bytes.y << 8u) | (bytes.z << 16u) | (bytes.w << 24u), 0u);
}

/// The words of texel `index` of the block of a tile before the event.
fn before(first: u32, index: u32) -> vec2<u32> {
    if edit_is(WIDE) {
        return vec2(texels[first + 2u * index], texels[first + 2u * index + 1u]);
    }
    return vec2(texels[first + index], 0u);
}

fn place_at(tile: u32, size: u32, cell: vec2<u32>) -> BrushPlace {
    let uv = (vec2<f32>(cell) + vec2(0.5)) / f32(size);
    return brush_at(tile, uv, tiles_jet(tile, uv).d);
}

/// The new colour of the texel in column `i` and row `j`, the ring counted, of a tile that has `now` there.
fn painted(tile: u32, size: u32, i: u32, j: u32, now: vec4<f32>) -> vec4<f32> {
    let cell = vec2(i - 1u, j - 1u);
    let at_place = place_at(tile, size, cell);
    var share = at_place.share;
    if !(share > 0.0) {
        return now;
    }
    var color = work.color;
    if edit_is(STAMPED) {
        let next = stamp_beside(cell, size);
        let beside = place_at(tile, size, vec2(next.x, cell.y)).place;
        let over = place_at(tile, size, vec2(cell.x, next.y)).place;
        let pixel = stamp_at(at_place.place.xy, stamp_footprint(at_place.place, beside, over));
        color *= vec4(pixel.xyz, 1.0);
        share *= pixel.w;
        if !(share > 0.0) {
            return now;
        }
    }
    switch work.mode {
        case MIX: {
            return fma(color - now, vec4(share), now);
        }
        case ADD: {
            return vec4(fma(color.xyz, vec3(share), now.xyz), now.w);
        }
        case MULTIPLY: {
            return vec4(now.xyz * fma(color.xyz - vec3(1.0), vec3(share), vec3(1.0)), now.w);
        }
        case ERASE: {
            return fma(work.blank - now, vec4(share), now);
        }
        case BLUR: {
            let first = entries[tile].first;
            if first == TILES_NONE {
                return now;
            }
            let stride = size + 2u;
            let at = j * stride + i;
            let rows = decoded(before(first, at - stride)) + decoded(before(first, at + stride));
            let columns = decoded(before(first, at - 1u)) + decoded(before(first, at + 1u));
            return fma(0.25 * (rows + columns) - now, vec4(share), now);
        }
        default: {
            return now;
        }
    }
}

// One texel of the block of one tile.
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
    if found.y != BLOCK_NONE && edit_texel(found.x, found.y, group.y * GROUP + local) {
        atomicAdd(&changed, 1u);
    }
    workgroupBarrier();
    if local == 0u && found.y != BLOCK_NONE {
        note_block(found.x, found.y, atomicLoad(&changed), group.y == 0u);
    }
}

/// Makes a texel anew; returns whether it changes.
fn edit_texel(tile: u32, block: u32, index: u32) -> bool {
    let size = brush_tiles[tile].size;
    let stride = size + 2u;
    if index >= stride * stride {
        return false;
    }
    let at = block * work.room + index * (1u + (work.flags & WIDE));
    let taken = is_new(block);
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
        let color = painted(tile, size, i, j, now);
        if any(color != now) {
            new_words = coded(color);
        }
    }
    let differs = any(new_words != old);
    if differs {
        note_texel(block, size, i, j);
    }
    if taken || differs {
        blocks[at] = new_words.x;
        if edit_is(WIDE) {
            blocks[at + 1u] = new_words.y;
        }
    }
    return differs;
}
