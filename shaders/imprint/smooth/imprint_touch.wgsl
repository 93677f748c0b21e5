// import common
// import imprint_link
// import imprint_record
// The tiles that an imprint changed and those around them, whose borders and rings follow by it, where imprints that come
// after it meet what is smoothed: each has a block of its own from then on. An invocation takes a record.

// Words of the topology of a tile, and those of them before its rings, see `ring`.
const TILE_WORDS: u32 = 20u;
const TILE_RINGS: u32 = 16u;

// Words of an imprint's arguments, see `DeviceSmoothing`: of the parts of blocks of listed tiles, of their rings, of the
// tiles, of which the first says how many there are, and of the records.
const STAGE: u32 = 12u;

@group(0) @binding(1) var<storage, read_write> counters: AllCounters;
@group(0) @binding(2) var<storage, read_write> slots: array<atomic<u32>>;
@group(0) @binding(3) var<storage, read> records: array<u32>;
// The tiles, each once, and the records of the imprint.
@group(0) @binding(4) var<storage, read_write> listed: array<u32>;
@group(0) @binding(5) var<storage, read_write> changed: array<u32>;
@group(0) @binding(6) var<storage, read_write> stages: array<atomic<u32>>;
// Of every tile its block, for the ring update.
@group(0) @binding(7) var<storage, read_write> pointers: array<u32>;
@group(0) @binding(8) var<storage, read> topology: array<u32>;

fn grow(at: u32, x: u32, y: u32) {
    atomicMax(&stages[at], x);
    atomicMax(&stages[at + 1u], y);
    atomicMax(&stages[at + 2u], 1u);
}

// Lists a tile, once for this imprint, if there is a block for it.
fn list(tile: u32) {
    let slot = work.slots + tile * work.stride;
    if atomicExchange(&slots[slot + SLOT_LISTED], step.link + 1u) == step.link + 1u {
        return;
    }
    var block = atomicLoad(&slots[slot + SLOT_BLOCK]);
    if block == 0u {
        let taken = atomicAdd(&counters.taken, 1u);
        block = select(NO_ROOM, taken + 1u, taken < work.blocks);
        atomicStore(&slots[slot + SLOT_BLOCK], block);
        atomicStore(&slots[slot + SLOT_TAKEN], step.link + 1u);
        if is_block(block) {
            pointers[tile] = taken;
        }
    }
    if !is_block(block) {
        return;
    }
    let first = STAGE * step.link;
    let place = atomicAdd(&stages[first + 6u], 1u);
    listed[place] = tile;
    grow(first, place + 1u, work.parts);
    grow(first + 3u, place + 1u, work.ring_parts);
    atomicMax(&stages[first + 7u], 1u);
    atomicMax(&stages[first + 8u], 1u);
}

@compute @workgroup_size(GROUP)
fn touch(id: Invocation) {
    work = links[step.link];
    let index = linear_group(id) * GROUP + id.local;
    let record = RECORD * index;
    if index >= min(atomicLoad(&counters.kept), work.records) || (records[record + 1u] >> 16u) != step.link {
        return;
    }
    let place = atomicAdd(&counters.links[step.link].changed, 1u);
    changed[place] = index;
    grow(STAGE * step.link + 9u, min(place + 1u, ROW), place / ROW + 1u);
    let tile = records[record];
    let slot = work.slots + tile * work.stride;
    if atomicExchange(&slots[slot + SLOT_TOUCHED], step.link + 1u) == step.link + 1u {
        return;
    }
    list(tile);
    for (var corner = 0u; corner < 4u; corner++) {
        let ring = work.rings + 2u * (topology[TILE_WORDS * tile + TILE_RINGS + corner] & 0x7fffffffu);
        let end = topology[ring + 2u];
        for (var entry = topology[ring]; entry < end; entry++) {
            list(topology[work.entries + 2u * entry]);
        }
    }
}
