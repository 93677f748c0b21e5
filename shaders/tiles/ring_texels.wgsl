// import colors
// import ring_tiles
// Texels of the blocks that a ring update works on: where they are, and what they are averaged as.

fn value_of(words: vec2<u32>) -> vec4<f32> {
    if FRAMED == 1u {
        return vec4(unpack2x16float(words.x), unpack2x16float(words.y).x, 0.0);
    }
    if work.format == 0u {
        return vec4(unpack2x16float(words.x).x, 0.0, 0.0, 0.0);
    }
    return color_of(words, is_wide());
}

fn words_near(value: vec4<f32>) -> vec2<u32> {
    if FRAMED == 1u {
        let held = clamp(value, vec4(-COLOR_MOST), vec4(COLOR_MOST));
        return words_of_halves(vec3(half_bits(held.x), half_bits(held.y), half_bits(held.z)));
    }
    if work.format == 0u {
        return vec2(half_bits(clamp(value.x, -COLOR_MOST, COLOR_MOST)), 0u);
    }
    return words_of(value, is_wide());
}

/// A vector of three half floats. Zeros are positive, whatever way they were turned.
fn words_of_halves(halves: vec3<u32>) -> vec2<u32> {
    let unsigned = select(halves, vec3(0u), (halves & vec3(0x7fffu)) == vec3(0u));
    return vec2(unsigned.x | (unsigned.y << 16u), unsigned.z);
}

/// A number by a power of two, which is exact; quotients of devices are not.
fn over(value: f32, power: u32) -> f32 {
    return value * bitcast<f32>((127u - firstTrailingBit(power)) << 23u);
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
    if FRAMED == 1u {
        let at = first + 3u * index / 2u;
        let pair = vec2(word_at(worked, at), word_at(worked, at + 1u));
        let later = vec2((pair.x >> 16u) | (pair.y << 16u), pair.y >> 16u);
        return select(vec2(pair.x, pair.y & 0xffffu), later, (index & 1u) == 1u);
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
    if FRAMED == 1u {
        let at = first + 3u * index / 2u;
        let later = (index & 1u) == 1u;
        let low = select(words, vec2(words.x << 16u, (words.x >> 16u) | (words.y << 16u)), later);
        let masks = select(vec2(NONE, 0xffffu), vec2(0xffff0000u, NONE), later);
        write_word(worked, at, low.x, masks.x);
        write_word(worked, at + 1u, low.y, masks.y);
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
