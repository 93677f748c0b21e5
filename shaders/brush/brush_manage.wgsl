// import common
// import brush
// Memory of the tiles that an event works on: blocks are taken from the end of a table of free ones and given back there, a
// list at a time, without synchronisation but the scan that made the lists (Schäfer et al. 2015, Section 4).

struct Manage {
    // Blocks there are.
    capacity: u32,
    // Room of a list.
    stride: u32,
    // The dab, from 1.
    dab: u32,
    // Workgroups that edit a block.
    parts: u32,
}

struct Memory {
    // Blocks that are free, and the fewest that were.
    free: u32,
    fewest: u32,
    // Tiles that got none.
    refused: u32,
    // Workgroups of the edit: tiles, parts, and rows of tiles.
    edit: vec3<u32>,
}

@group(0) @binding(0) var<storage, read> lists: array<u32>;
// For each set how many tiles it has, and workgroups.
@group(0) @binding(1) var<storage, read> counts: array<u32>;
@group(0) @binding(2) var<storage, read_write> pointers: array<u32>;
@group(0) @binding(3) var<storage, read_write> states: array<u32>;
@group(0) @binding(4) var<storage, read_write> free_table: array<u32>;
@group(0) @binding(5) var<storage, read_write> memory: Memory;
var<immediate> work: Manage;

const ROW: u32 = 32768u;

// All blocks are free.
@compute @workgroup_size(GROUP)
fn reset(id: Invocation) {
    let index = linear_group(id) * GROUP + id.local;
    if index == 0u {
        memory.free = work.capacity;
        memory.fewest = work.capacity;
        memory.refused = 0u;
    }
    if index >= work.capacity {
        return;
    }
    // The first to be taken is block 0.
    free_table[index] = work.capacity - 1u - index;
    let state = BLOCK_WORDS * index;
    if states[state + BLOCK_TAKEN] != 0u {
        pointers[states[state + BLOCK_TILE]] = BLOCK_NONE;
        states[state + BLOCK_TAKEN] = 0u;
    }
}

@compute @workgroup_size(GROUP)
fn deallocate(id: Invocation) {
    let index = linear_group(id) * GROUP + id.local;
    if index >= counts[8] {
        return;
    }
    let tile = lists[2u * work.stride + index];
    free_table[memory.free + index] = pointers[tile];
    pointers[tile] = BLOCK_NONE;
}

@compute @workgroup_size(GROUP)
fn allocate(id: Invocation) {
    let index = linear_group(id) * GROUP + id.local;
    let there = memory.free + counts[8];
    if index >= counts[4] || index >= there {
        return;
    }
    let tile = lists[work.stride + index];
    let block = free_table[there - 1u - index];
    pointers[tile] = block;
    let state = BLOCK_WORDS * block;
    states[state + BLOCK_TILE] = tile;
    states[state + BLOCK_TAKEN] = work.dab;
    for (var k = BLOCK_CHANGES; k < BLOCK_WORDS; k++) {
        states[state + k] = 0u;
    }
}

// What was taken and given back is counted.
@compute @workgroup_size(1)
fn finish() {
    let there = memory.free + counts[8];
    let taken = min(counts[4], there);
    memory.free = there - taken;
    memory.fewest = min(memory.fewest, there - taken);
    memory.refused += counts[4] - taken;
    memory.edit = vec3(min(counts[0], ROW), work.parts, (counts[0] + ROW - 1u) / ROW);
}
