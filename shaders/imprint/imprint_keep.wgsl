// import imprint_link
// import imprint_record
// Keeps what rays changed, on its way back to the host and for the imprints of later dispatches. A workgroup takes a block.

@group(0) @binding(5) var<storage, read_write> slots: array<atomic<u32>>;
@group(0) @binding(6) var<storage, read_write> counters: AllCounters;
@group(0) @binding(7) var<storage, read_write> records: array<u32>;

var<workgroup> sum_changed: atomic<i32>;
var<workgroup> sum_clamped: atomic<i32>;
var<workgroup> least: atomic<i32>;
var<workgroup> shared_place: u32;

// Takes a record with a head, if there is room. Returns its place, which is in `shared_place` too.
fn take_record(head: vec4<u32>) -> u32 {
    let place = atomicAdd(&counters.kept, 1u);
    shared_place = place;
    if place < work.records {
        for (var k = 0u; k < 4u; k++) {
            records[RECORD * place + k] = head[k];
        }
    }
    return place;
}

// Takes a record for a block of `listed` that imprint `link` changed, and tells of it.
fn keep(item: vec4<u32>, link: u32) {
    let clamped = atomicLoad(&sum_clamped);
    if clamped > 0 {
        atomicAdd(&counters.links[link].clamped, u32(clamped));
    }
    let changed = atomicLoad(&sum_changed);
    if changed == 0 {
        return;
    }
    let block = item.y & 0xffffu;
    let lowest = atomicLoad(&least);
    let place = take_record(vec4(item.x, block | (link << 16u), u32(changed), u32(lowest)));
    if place < work.records && (work.flags & CHAINED) != 0u {
        let slot = work.slots + item.x * work.stride;
        atomicStore(&slots[slot + 1u + block], place + 1u);
        atomicMax(&slots[slot], u32(-lowest));
    }
}
