// import imprint_rim
// The patches of contact: cells that touch, directly or through others, follow the one with the least key (after Jaiganesh
// and Burtscher 2018, *A High-Performance Connected Components Implementation for GPUs*, Section 3). One workgroup takes
// all cells.

// Steps along cells that follow each other, and tries to join two, at most; with all cells of an invocation far fewer than
// the iterations at which some devices stop.
const STEPS: u32 = 4096u;
// Rounds that halve the way to the first: enough for as many cells as there may be.
const ROUNDS: u32 = 16u;

fn key_of(cell: u32) -> u32 {
    return atomicLoad(&cells[CELL * cell]);
}

// The cell with a key, or NONE.
fn find_cell(key: u32) -> u32 {
    let count = rims[step.link].cells;
    var at = cell_start(key);
    for (var k = 0u; k < PROBES; k++) {
        at &= count - 1u;
        let found = key_of(at);
        if found == key {
            return at;
        }
        if found == EMPTY {
            return NONE;
        }
        at++;
    }
    return NONE;
}

// The cell that one follows in the end; the way there gets shorter.
fn first_of(cell: u32) -> u32 {
    var at = cell;
    for (var k = 0u; k < STEPS; k++) {
        let next = atomicLoad(&cells[CELL * at + FOLLOWS]);
        if next == at {
            return at;
        }
        let after = atomicLoad(&cells[CELL * next + FOLLOWS]);
        if after != next {
            atomicStore(&cells[CELL * at + FOLLOWS], after);
        }
        at = next;
    }
    atomicOr(&rim_counters[step.link].faults, RIM_MANY);
    return at;
}

fn join(one: u32, other: u32) {
    for (var k = 0u; k < STEPS; k++) {
        let a = first_of(one);
        let b = first_of(other);
        if a == b {
            return;
        }
        let swap = key_of(a) < key_of(b);
        let later = select(a, b, swap);
        let had = atomicCompareExchangeWeak(&cells[CELL * later + FOLLOWS], later, select(b, a, swap));
        if had.exchanged {
            return;
        }
    }
    atomicOr(&rim_counters[step.link].faults, RIM_MANY);
}

@compute @workgroup_size(GROUP)
fn join_cells(@builtin(local_invocation_index) local: u32) {
    let count = atomicLoad(&rim_counters[step.link].cells);
    // With more it is made again with more room.
    if count > rims[step.link].cells / 2u {
        return;
    }
    for (var index = local; index < count; index += GROUP) {
        let cell = atomicLoad(&cells[CELL * index + LISTED]);
        let key = key_of(cell);
        let own = vec3<i32>(vec3(key >> 20u, key >> 10u, key) & vec3(1023u));
        // Half of those around it; the others find it.
        for (var side = 14; side < 27; side++) {
            let at = own + vec3(side / 9, side / 3 % 3, side % 3) - vec3(1);
            if any(at < vec3(0)) || any(at > vec3(1023)) {
                continue;
            }
            let next = find_cell(cell_key(at));
            if next != NONE {
                join(cell, next);
            }
        }
    }
    for (var round = 0u; round < ROUNDS; round++) {
        storageBarrier();
        for (var index = local; index < count; index += GROUP) {
            let cell = atomicLoad(&cells[CELL * index + LISTED]);
            let next = atomicLoad(&cells[CELL * cell + FOLLOWS]);
            atomicStore(&cells[CELL * cell + FOLLOWS], atomicLoad(&cells[CELL * next + FOLLOWS]));
        }
    }
}
