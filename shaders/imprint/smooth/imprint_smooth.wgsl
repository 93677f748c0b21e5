// import common
// import halves
// import imprint_link
// import imprint_record
// What an imprint changed, smoothed (Schäfer et al. 2014, Section 6), where imprints that come after it meet it: in blocks
// of whole tiles, between which the ring update is made. The same as `smoothing` of rust/detail, to the bit.

// Texels around a changed one that are smoothed as well.
const REACH: u32 = 2u;

@group(0) @binding(1) var<storage, read_write> slots: array<u32>;
@group(0) @binding(2) var<storage, read> records: array<u32>;
@group(0) @binding(3) var<storage, read_write> blocks: array<atomic<u32>>;
// Of every texel of the blocks the imprint, from 1, by which it is smoothed, in the upper half, and what it becomes.
@group(0) @binding(4) var<storage, read_write> marks: array<atomic<u32>>;
// What `imprint_touch` found.
@group(0) @binding(5) var<storage, read> listed: array<u32>;
@group(0) @binding(6) var<storage, read> changed: array<u32>;
// Of every tile, as the second word, its texels a side, whether or not it has any.
@group(0) @binding(7) var<storage, read> sizes: array<vec2<u32>>;
// Of every tile the first word of its block before the submission, and its texels a side.
@group(0) @binding(8) var<storage, read> entries: array<vec2<u32>>;
@group(0) @binding(9) var<storage, read> texels: array<u32>;
@group(0) @binding(10) var<storage, read_write> counters: AllCounters;

var<workgroup> least: atomic<i32>;
var<workgroup> most: atomic<i32>;

// A tile that is worked on.
struct Worked {
    tile: u32,
    slot: u32,
    size: u32,
    // The first word of its block.
    first: u32,
}

fn worked(tile: u32) -> Worked {
    let slot = work.slots + tile * work.stride;
    return Worked(tile, slot, sizes[tile].y, (slots[slot + SLOT_BLOCK] - 1u) * work.block_words);
}

// Whether what slot `which` of a tile says is this imprint.
fn is_now(it: Worked, which: u32) -> bool {
    return slots[it.slot + which] == step.link + 1u;
}

fn texel_at(it: Worked, texel: u32) -> u32 {
    return (atomicLoad(&blocks[it.first + texel / 2u]) >> (16u * (texel & 1u))) & 0xffffu;
}

fn words_of(it: Worked) -> u32 {
    return (it.size + 2u) * (it.size + 2u) / 2u;
}

// Blocks that were taken for this imprint are what the tiles were before the submission.
@compute @workgroup_size(GROUP)
fn bring(id: Invocation) {
    work = links[step.link];
    let it = worked(listed[id.group.x]);
    let word = id.group.y * GROUP + id.local;
    if !is_now(it, SLOT_TAKEN) || word >= words_of(it) {
        return;
    }
    let entry = entries[it.tile];
    var pair = 0u;
    if entry.x != NONE {
        pair = texels[entry.x + word];
    }
    atomicStore(&blocks[it.first + word], pair);
    atomicStore(&marks[2u * (it.first + word)], 0u);
    atomicStore(&marks[2u * (it.first + word) + 1u], 0u);
}

// Has what is near a texel smoothed.
fn mark(it: Worked, column: u32, row: u32) {
    let last = it.size - 1u;
    for (var j = max(row, REACH) - REACH; j <= min(row + REACH, last); j++) {
        for (var i = max(column, REACH) - REACH; i <= min(column + REACH, last); i++) {
            let texel = (j + 1u) * (it.size + 2u) + i + 1u;
            atomicStore(&marks[2u * it.first + texel], (step.link + 1u) << 16u);
        }
    }
}

// What rays found of a record's block: an invocation takes two coefficients.
@compute @workgroup_size(PAIRS)
fn take_over(id: Invocation) {
    work = links[step.link];
    let index = linear_group(id);
    if index >= atomicLoad(&counters.links[step.link].changed) {
        return;
    }
    let record = RECORD * changed[index];
    let tile = records[record];
    if !is_block(slots[work.slots + tile * work.stride + SLOT_BLOCK]) {
        return;
    }
    let it = worked(tile);
    let edge = min(it.size, EDGE);
    if 2u * id.local >= edge * edge {
        return;
    }
    let block = records[record + 1u] & 0xffffu;
    let across = it.size / edge;
    let row = block / across * edge + 2u * id.local / edge;
    let column = block % across * edge + 2u * id.local % edge;
    let pair = records[record + HEADER + id.local];
    for (var k = 0u; k < 2u; k++) {
        let texel = (row + 1u) * (it.size + 2u) + column + k + 1u;
        let before = texel_at(it, texel);
        let after = (pair >> (16u * k)) & 0xffffu;
        if before == after {
            continue;
        }
        // Zeros of either sign are the same.
        if ((before | after) & 0x7fffu) != 0u {
            mark(it, column + k, row);
        }
        let shift = 16u * (texel & 1u);
        atomicAnd(&blocks[it.first + texel / 2u], ~(0xffffu << shift));
        atomicOr(&blocks[it.first + texel / 2u], after << shift);
    }
}

// Which of two texels of a word are smoothed, bits of the marks.
fn marked(at: u32) -> vec2<bool> {
    let both = vec2(atomicLoad(&marks[at]), atomicLoad(&marks[at + 1u]));
    return (both >> vec2(16u)) == vec2(step.link + 1u);
}

// What texels become: an invocation takes a word of the block of a tile that changed.
@compute @workgroup_size(GROUP)
fn average(id: Invocation) {
    work = links[step.link];
    let it = worked(listed[id.group.x]);
    let word = id.group.y * GROUP + id.local;
    if !is_now(it, SLOT_TOUCHED) || word >= words_of(it) {
        return;
    }
    let at = 2u * (it.first + word);
    let smoothed = marked(at);
    for (var k = 0u; k < 2u; k++) {
        if !smoothed[k] {
            continue;
        }
        let texel = 2u * word + k;
        let stride = it.size + 2u;
        let columns = value(texel_at(it, texel - 1u)) + value(texel_at(it, texel + 1u));
        let rows = value(texel_at(it, texel - stride)) + value(texel_at(it, texel + stride));
        let here = value(texel_at(it, texel));
        let mean = 0.25 * (rows + columns);
        let after = half_bits(here + rounded(work.strength * (mean - here)));
        atomicStore(&marks[at + k], ((step.link + 1u) << 16u) | after);
    }
}

// They become it.
@compute @workgroup_size(GROUP)
fn apply(id: Invocation) {
    work = links[step.link];
    let it = worked(listed[id.group.x]);
    let word = id.group.y * GROUP + id.local;
    if !is_now(it, SLOT_TOUCHED) || word >= words_of(it) {
        return;
    }
    let at = 2u * (it.first + word);
    let smoothed = marked(at);
    var pair = atomicLoad(&blocks[it.first + word]);
    for (var k = 0u; k < 2u; k++) {
        if smoothed[k] {
            let after = atomicLoad(&marks[at + k]) & 0xffffu;
            pair = (pair & ~(0xffffu << (16u * k))) | (after << (16u * k));
        }
    }
    if any(smoothed) {
        atomicStore(&blocks[it.first + word], pair);
    }
}

// The range of a block, ring included, by which culling goes. A workgroup takes a tile.
@compute @workgroup_size(GROUP)
fn measure(id: Invocation) {
    work = links[step.link];
    let it = worked(listed[id.group.x]);
    if id.local == 0u {
        atomicStore(&least, 0x7fff);
        atomicStore(&most, -0x8000);
    }
    workgroupBarrier();
    var low = 0x7fff;
    var high = -0x8000;
    for (var word = id.local; word < words_of(it); word += GROUP) {
        let pair = atomicLoad(&blocks[it.first + word]);
        let keys = vec2(key(pair & 0xffffu), key(pair >> 16u));
        low = min(low, min(keys.x, keys.y));
        high = max(high, max(keys.x, keys.y));
    }
    atomicMin(&least, low);
    atomicMax(&most, high);
    workgroupBarrier();
    if id.local == 0u {
        slots[it.slot + SLOT_LEAST] = bitcast<u32>(atomicLoad(&least));
        slots[it.slot + SLOT_MOST] = bitcast<u32>(atomicLoad(&most));
    }
}
