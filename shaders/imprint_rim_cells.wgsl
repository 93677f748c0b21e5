// import imprint_rim
// What an imprint pushed of the pieces around it, in three passes: the records of the blocks, which coefficients, then the
// cells of space that these are in, and those at the border.

// Cells from the middle of the grid that are told apart.
const REACH: f32 = 512.0;

var<workgroup> mask: array<atomic<u32>, 8>;
var<workgroup> shared_first: u32;

// An invocation takes a record.
@compute @workgroup_size(GROUP)
fn find_records(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    work = links[step.link];
    let index = linear_group(group, groups) * GROUP + local;
    let record = RECORD * index;
    if index >= min(atomicLoad(&told.kept), work.records) || records[record + 1u] >> 16u != step.link {
        return;
    }
    let piece = piece_of(records[record], records[record + 1u] & 0xffffu);
    if piece != NONE {
        pieces[PIECE * piece + RECORD_OF] = index + 1u;
    }
}

@compute @workgroup_size(GROUP)
fn push(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) k: u32,
) {
    let piece = linear_group(group, groups);
    let there = piece < arguments[2u * step.link + 1u].x;
    work = links[step.link];
    if k < 8u {
        atomicStore(&mask[k], 0u);
    }
    workgroupBarrier();
    if there {
        let it = patchwork(listed[piece]);
        let before = pieces[PIECE * piece + k] >> 16u;
        var now = before;
        let record = pieces[PIECE * piece + RECORD_OF];
        if record != 0u && k < it.edge * it.edge {
            now = (records[RECORD * (record - 1u) + HEADER + k / 2u] >> (16u * (k & 1u))) & 0xffffu;
        }
        pieces[PIECE * piece + k] = now | (before << 16u);
        if value(now) < value(before) {
            atomicOr(&mask[k / 32u], 1u << (k % 32u));
            atomicMax(&rims_told[step.link].spacing, pieces[PIECE * piece + SPACING]);
        }
    }
    workgroupBarrier();
    if there && k < 8u {
        pieces[PIECE * piece + PUSHED + k] = atomicLoad(&mask[k]);
    }
}

// Whether a coefficient of a tile is pushed; beyond the tile nothing is known.
fn is_pushed(piece: u32, it: Patchwork, place: vec2<i32>) -> bool {
    if any(place < vec2(0)) || any(place >= vec2(i32(it.size))) {
        return false;
    }
    let at = vec2<u32>(place);
    let block = at.y / it.edge * it.across + at.x / it.edge;
    var other = piece;
    if block != it.block {
        other = piece_of(it.tile, block);
        if other == NONE {
            return false;
        }
    }
    return has_bit(other, PUSHED, at.y % it.edge * it.edge + at.x % it.edge);
}

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
                let index = atomicAdd(&rims_told[step.link].cells, 1u);
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
    atomicOr(&rims_told[step.link].faults, RIM_MANY);
    return NONE;
}

@compute @workgroup_size(GROUP)
fn list_cells(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) k: u32,
) {
    let piece = linear_group(group, groups);
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
        let it = patchwork(listed[piece]);
        point = points[256u * piece + k];
        let inverse = inverse_of(cell_edge());
        let place = floor(point.xyz * inverse) - floor(work.origin * inverse);
        if all(abs(place) < vec3(REACH)) {
            cell = cell_of(cell_key(vec3<i32>(place) + vec3(i32(REACH))));
        } else {
            atomicOr(&rims_told[step.link].faults, RIM_FAR);
        }
        pieces[PIECE * piece + CELLS_OF + k] = cell;
        let own = vec2<i32>(vec2(it.block % it.across, it.block / it.across) * it.edge + vec2(k % it.edge, k / it.edge));
        at_border = !(is_pushed(piece, it, own - vec2(1, 0)) && is_pushed(piece, it, own + vec2(1, 0))
            && is_pushed(piece, it, own - vec2(0, 1)) && is_pushed(piece, it, own + vec2(0, 1)));
        if at_border {
            atomicOr(&mask[k / 32u], 1u << (k % 32u));
        }
    }
    workgroupBarrier();
    if k == 0u {
        var count = 0u;
        for (var word = 0u; word < 8u; word++) {
            count += countOneBits(atomicLoad(&mask[word]));
        }
        if count > 0u {
            let first = atomicAdd(&rims_told[step.link].borders, count);
            shared_first = first;
            if first + count <= rims[step.link].borders {
                let at = atomicAdd(&rims_told[step.link].edges, 1u);
                edges[at] = vec4(piece, first, count, 0u);
            }
        }
    }
    workgroupBarrier();
    if at_border {
        var at = shared_first + countOneBits(atomicLoad(&mask[k / 32u]) & ((1u << (k % 32u)) - 1u));
        for (var word = 0u; word < k / 32u; word++) {
            at += countOneBits(atomicLoad(&mask[word]));
        }
        if at < rims[step.link].borders {
            borders[at] = vec4(point.xyz, bitcast<f32>(cell));
        }
    }
}
