// import imprint_rim
// What rises of a piece: coefficients go up by the share of the height that their patch has, as long as the slope is not
// too steep. Blocks that change are kept with blocks that were pushed, and the volumes of both are reported.

/// 1 where records of triangles tell of the slot of what was there before.
override TRIANGLES: u32 = 0u;

var<workgroup> new_halves: array<u32, 256>;
var<workgroup> sums: array<vec2<f32>, 256>;
var<workgroup> risen: atomic<u32>;
var<workgroup> most: atomic<u32>;
var<workgroup> shared_place: u32;

// The height of a patch's rim.
fn height_of(cell: u32) -> f32 {
    let first = CELL * cell;
    let volume = leading(atomicLoad(&cells[first + VOLUME]), atomicLoad(&cells[first + VOLUME + 1u]));
    let low = atomicLoad(&cells[first + SPACE]);
    let high = atomicLoad(&cells[first + SPACE + 1u]);
    let room = leading(select(low, max(low, 1u), high == 0u), high);
    return volume / room * bitcast<f32>(cell_edge()) * rims[step.link].share;
}

// The record of a piece that changed: the one of what was pushed, or a new one.
fn record_of(piece: u32, it: Patchwork) -> u32 {
    let there = pieces[PIECE * piece + RECORD_OF];
    let count = atomicLoad(&risen);
    if there != 0u {
        records[RECORD * (there - 1u) + 2u] += count;
        return there - 1u;
    }
    if count == 0u {
        return NONE;
    }
    let place = atomicAdd(&counters.kept, 1u);
    if place >= work.records {
        return NONE;
    }
    let first = RECORD * place;
    records[first] = it.tile;
    records[first + 1u] = it.block | (step.link << 16u);
    records[first + 2u] = count;
    records[first + 3u] = 0u;
    pieces[PIECE * piece + RECORD_OF] = place + 1u;
    if (work.flags & CHAINED) != 0u {
        let before = atomicExchange(&slots[block_slot(it)], place + 1u);
        records[first + 3u] = select(0u, before, TRIANGLES == 1u);
    }
    return place;
}

@compute @workgroup_size(GROUP)
fn raise(id: Invocation) {
    let k = id.local;
    let piece = linear_group(id);
    let there = piece < arguments[2u * step.link + 1u].x;
    work = links[step.link];
    if k == 0u {
        atomicStore(&risen, 0u);
        atomicStore(&most, 0u);
        shared_place = NONE;
    }
    // The cells are left empty for the next imprint. There are no more of them than coefficients.
    let index = GROUP * piece + k;
    if there && index < min(atomicLoad(&rim_counters[step.link].cells), rims[step.link].cells) {
        atomicStore(&cells[CELL * atomicLoad(&cells[CELL * index + LISTED])], EMPTY);
    }
    workgroupBarrier();
    var it: Patchwork;
    sums[k] = vec2(0.0);
    if there {
        it = patchwork(listed[piece]);
        let at = PIECE * piece;
        let half = pieces[at + k] & 0xffffu;
        let old = value(half);
        let area = points[256u * piece + k].w;
        let profile = number(piece, PROFILE + k);
        new_halves[k] = half;
        sums[k].x = max(value(pieces[at + k] >> 16u) - old, 0.0) * area;
        if profile > 0.0 {
            let up = rounded(height_of(pieces[at + CELLS_OF + k]) * profile);
            let bits = half_bits(min(old + up, rims[step.link].highest * profile));
            if value(bits) > old {
                new_halves[k] = bits;
                sums[k].y = (value(bits) - old) * area;
                atomicAdd(&risen, 1u);
                if bits < 0x8000u {
                    atomicMax(&most, bits);
                }
            }
        }
    }
    for (var reach = 128u; reach > 0u; reach /= 2u) {
        workgroupBarrier();
        if k < reach {
            sums[k] += sums[k + reach];
        }
    }
    workgroupBarrier();
    if there && k == 0u {
        shared_place = record_of(piece, it);
        let raised = atomicLoad(&most);
        if raised > 0u && (work.flags & CHAINED) != 0u {
            atomicMax(&slots[work.slots + it.tile * work.stride + work.stride - 1u], raised);
        }
    }
    workgroupBarrier();
    let place = shared_place;
    if place == NONE {
        return;
    }
    if k < 128u {
        records[RECORD * place + HEADER + k] = new_halves[2u * k] | (new_halves[2u * k + 1u] << 16u);
    }
    if k == 0u {
        volumes[place] = sums[0];
    }
}
