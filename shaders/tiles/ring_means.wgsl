// import ring_turns
// Means of texels as the processor rounds them, and the mips that are made of them (Schäfer et al. 2015, *Local Painting and
// Deformation of Meshes on the GPU*, Section 5). The same as `mip` of rust/tiles.

/// The half float nearest to `sum`, less than whose last digit is in `low`, over `n`, where `near` is the device's quotient.
fn mean_half(sum: f32, low: f32, n: f32, near: u32) -> u32 {
    let bits = near & 0x7fffu;
    if bits == 0u {
        return near;
    }
    // Devices' quotients are not the nearest: on which side of the middles beside it the mean is, products say exactly.
    let here = unpack2x16float(bits).x;
    let above = (abs(sum) - 0.5 * (here + unpack2x16float(min(bits + 1u, 0x7bffu)).x) * n) + select(low, -low, sum < 0.0);
    let below = (abs(sum) - 0.5 * (here + unpack2x16float(bits - 1u).x) * n) + select(low, -low, sum < 0.0);
    let odd = (bits & 1u) == 1u;
    var held = bits;
    if bits < 0x7bffu && (above > 0.0 || (above == 0.0 && odd)) {
        held = bits + 1u;
    } else if below < 0.0 || (below == 0.0 && odd) {
        held = bits - 1u;
    }
    return (near & 0x8000u) | held;
}

/// The texel nearest to the mean of `count` texels that sum to `sum`.
fn mean_words(sum: Sum, count: u32) -> vec2<u32> {
    let n = f32(count);
    let near = words_near(sum.high / n);
    if FRAMED == 1u {
        let held = sum_of(sum.high, sum.low);
        let halves = vec3(near.x & 0xffffu, near.x >> 16u, near.y);
        var made: vec3<u32>;
        for (var axis = 0u; axis < 3u; axis++) {
            made[axis] = mean_half(held.high[axis], held.low[axis], n, halves[axis]);
        }
        return words_of_halves(made);
    }
    if work.format != 0u {
        return near;
    }
    return vec2(mean_half(sum.high.x, 0.0, n, near.x), 0u);
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
