// import imprint_rim
// What an imprint pushed of the pieces around it: the records of the blocks, then which coefficients.

var<workgroup> mask: array<atomic<u32>, 8>;

// An invocation takes a record.
@compute @workgroup_size(GROUP)
fn find_records(id: Invocation) {
    work = links[step.link];
    let index = linear_group(id) * GROUP + id.local;
    let record = RECORD * index;
    if index >= min(atomicLoad(&counters.kept), work.records) || records[record + 1u] >> 16u != step.link {
        return;
    }
    let piece = piece_of(records[record], records[record + 1u] & 0xffffu);
    if piece != NONE {
        pieces[PIECE * piece + RECORD_OF] = index + 1u;
    }
}

@compute @workgroup_size(GROUP)
fn push(id: Invocation) {
    let k = id.local;
    let piece = linear_group(id);
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
            atomicMax(&rim_counters[step.link].spacing, pieces[PIECE * piece + SPACING]);
        }
    }
    workgroupBarrier();
    if there && k < 8u {
        pieces[PIECE * piece + PUSHED + k] = atomicLoad(&mask[k]);
    }
}
