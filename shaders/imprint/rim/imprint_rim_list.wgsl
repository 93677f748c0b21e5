// import imprint_rim
// needs is_at_border
// The cells of space that what is pushed of a piece is in, and the places of it at the border.

// Cells from the middle of the grid that the list distinguishes.
const REACH: f32 = 512.0;

// Which places are at the border, and where the first of these is kept.
var<workgroup> mask: array<atomic<u32>, 8>;
var<workgroup> shared_first: u32;

// The cell with a key, which is added if it is new; NONE where there is no room.
fn cell_of(key: u32) -> u32 {
    let count = rims[step.link].cells;
    var at = cell_start(key);
    for (var k = 0u; k < PROBES; k++) {
        at &= count - 1u;
        let found = atomicLoad(&cells[CELL * at]);
        if found == key {
            return at;
        }
        if found == EMPTY {
            let had = atomicCompareExchangeWeak(&cells[CELL * at], EMPTY, key);
            if had.exchanged {
                let index = atomicAdd(&rim_counters[step.link].cells, 1u);
                atomicStore(&cells[CELL * index + LISTED], at);
                atomicStore(&cells[CELL * at + FOLLOWS], at);
                for (var word = 0u; word < 4u; word++) {
                    atomicStore(&cells[CELL * at + VOLUME + word], 0u);
                }
                return at;
            }
            if had.old_value == key {
                return at;
            }
            // Another took it, or nothing did: it is looked at again.
            continue;
        }
        at++;
    }
    atomicOr(&rim_counters[step.link].faults, RIM_MANY);
    return NONE;
}

// Puts a place that is pushed into its cell, which is returned, or NONE where it has none.
fn cell_at(piece: u32, k: u32, point: vec3<f32>) -> u32 {
    let inverse = inverse_of(cell_edge());
    let place = floor(point * inverse) - floor(work.origin * inverse);
    var cell = NONE;
    if all(abs(place) < vec3(REACH)) {
        cell = cell_of(cell_key(vec3<i32>(place) + vec3(i32(REACH))));
    } else {
        atomicOr(&rim_counters[step.link].faults, RIM_FAR);
    }
    pieces[PIECE * piece + CELLS_OF + k] = cell;
    return cell;
}

// Takes room for the places of a piece at the border; one invocation does.
fn take_borders(piece: u32) {
    var count = 0u;
    for (var word = 0u; word < 8u; word++) {
        count += countOneBits(atomicLoad(&mask[word]));
    }
    if count == 0u {
        return;
    }
    let first = atomicAdd(&rim_counters[step.link].borders, count);
    shared_first = first;
    if first + count <= rims[step.link].borders {
        let at = atomicAdd(&rim_counters[step.link].edges, 1u);
        edges[at] = vec4(piece, first, count, 0u);
    }
}

// Keeps a place at the border.
fn put_border(k: u32, point: vec3<f32>, cell: u32) {
    var at = shared_first + countOneBits(atomicLoad(&mask[k / 32u]) & ((1u << (k % 32u)) - 1u));
    for (var word = 0u; word < k / 32u; word++) {
        at += countOneBits(atomicLoad(&mask[word]));
    }
    if at < rims[step.link].borders {
        borders[at] = vec4(point, bitcast<f32>(cell));
    }
}

@compute @workgroup_size(GROUP)
fn list_cells(id: Invocation) {
    let k = id.local;
    let piece = linear_group(id);
    let there = piece < arguments[2u * step.link + 1u].x;
    work = links[step.link];
    if k < 8u {
        atomicStore(&mask[k], 0u);
    }
    workgroupBarrier();
    var at_border = false;
    var cell = NONE;
    var point = vec4(0.0);
    if there && has_bit(piece, PUSHED, k) {
        point = points[256u * piece + k];
        cell = cell_at(piece, k, point.xyz);
        at_border = is_at_border(piece, patchwork(listed[piece]), k);
        if at_border {
            atomicOr(&mask[k / 32u], 1u << (k % 32u));
        }
    }
    workgroupBarrier();
    if k == 0u {
        take_borders(piece);
    }
    workgroupBarrier();
    if at_border {
        put_border(k, point.xyz, cell);
    }
}
