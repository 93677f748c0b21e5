// import common
// import brush
// The blocks that an event works on as they are before a dab: blocks that were taken for it get what their tiles have, and
// what a mode reads of neighbours is kept apart from what the edit writes.

struct Still {
    // What two words of tiles without a block hold.
    blank: vec2<u32>,
    // The dab, from 1, and how many words a block's room has.
    dab: u32,
    room: u32,
    // Half words of a texel.
    halves: u32,
}

// The tiles to modify come first, and how many they are.
@group(0) @binding(0) var<storage, read> lists: array<u32>;
@group(0) @binding(1) var<storage, read> counts: array<u32>;
@group(0) @binding(2) var<storage, read> pointers: array<u32>;
@group(0) @binding(3) var<storage, read> states: array<u32>;
// Blocks, and in the second half blocks that are kept.
@group(0) @binding(4) var<storage, read_write> blocks: array<u32>;
@group(0) @binding(5) var<storage, read> brush_tiles: array<BrushTile>;
// The tiles as they were before the event: the first word of each, and those.
@group(0) @binding(6) var<storage, read> entries: array<vec2<u32>>;
@group(0) @binding(7) var<storage, read> texels: array<u32>;
var<immediate> work: Still;

/// The tile of a workgroup, its block, and a word in that; none where there is no such.
fn word_of(id: Invocation) -> vec3<u32> {
    let index = id.group.x + id.groups.x * id.group.z;
    if index >= counts[0] {
        return vec3(BLOCK_NONE);
    }
    let tile = lists[index];
    let stride = brush_tiles[tile].size + 2u;
    let word = id.group.y * GROUP + id.local;
    let there = pointers[tile] != BLOCK_NONE && word < stride * stride * work.halves / 2u;
    return select(vec3(BLOCK_NONE), vec3(tile, pointers[tile], word), there);
}

@compute @workgroup_size(GROUP)
fn fill(id: Invocation) {
    let found = word_of(id);
    if found.y == BLOCK_NONE || states[BLOCK_WORDS * found.y + BLOCK_TAKEN] != work.dab {
        return;
    }
    let first = entries[found.x].x;
    var word = work.blank[found.z & 1u];
    if first != BLOCK_NONE {
        word = texels[first + found.z];
    }
    blocks[found.y * work.room + found.z] = word;
}

@compute @workgroup_size(GROUP)
fn keep(id: Invocation) {
    let found = word_of(id);
    if found.y == BLOCK_NONE {
        return;
    }
    let at = found.y * work.room + found.z;
    blocks[arrayLength(&blocks) / 2u + at] = blocks[at];
}
