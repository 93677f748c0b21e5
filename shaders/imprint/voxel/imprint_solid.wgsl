// import imprint_link
// The solid voxels of imprints.

// Columns: their ends, and the bits of those of several pieces, see `imprint_resolve`.
@group(0) @binding(3) var<storage, read> spans: array<u32>;
@group(0) @binding(4) var<storage, read> words: array<u32>;

fn word_of(column: u32, z: u32) -> u32 {
    return words[work.first_word + z / 32u * work.dims.x * work.dims.y + column];
}

fn is_solid(column: u32, z: i32) -> bool {
    let span = spans[work.first_column + column];
    if span == PIECES {
        return ((word_of(column, u32(z)) >> (u32(z) % 32u)) & 1u) == 1u;
    }
    return z >= i32(span & 0xffffu) && z < i32(span >> 16u);
}
