// import common
// import imprint_record
// What imprints left of blocks, written into the tiles of an object, without rings, which neighbours make. A workgroup takes
// a block, an invocation two coefficients, which need not share a word in the tile.

struct Writing {
    blocks: u32,
}

// The records of the blocks as the last imprint left them.
@group(0) @binding(0) var<storage, read> chosen: array<u32>;
@group(0) @binding(1) var<storage, read> records: array<u32>;
// Of every tile the first word of its block, and its texels a side.
@group(0) @binding(2) var<storage, read> entries: array<vec2<u32>>;
@group(0) @binding(3) var<storage, read_write> texels: array<atomic<u32>>;
var<immediate> work: Writing;

@compute @workgroup_size(PAIRS)
fn write_blocks(id: Invocation) {
    let index = linear_group(id);
    if index >= work.blocks {
        return;
    }
    let record = RECORD * chosen[index];
    let entry = entries[records[record]];
    let edge = min(entry.y, EDGE);
    if entry.x == NONE || 2u * id.local >= edge * edge {
        return;
    }
    let block = records[record + 1u] & 0xffffu;
    let across = entry.y / edge;
    let row = block / across * edge + 2u * id.local / edge;
    let column = block % across * edge + 2u * id.local % edge;
    let pair = records[record + HEADER + id.local];
    for (var k = 0u; k < 2u; k++) {
        let texel = (row + 1u) * (entry.y + 2u) + column + k + 1u;
        let shift = 16u * (texel & 1u);
        let word = entry.x + texel / 2u;
        atomicAnd(&texels[word], ~(0xffffu << shift));
        atomicOr(&texels[word], ((pair >> (16u * k)) & 0xffffu) << shift);
    }
}
