// import imprint_rim
// import triangle_imprint_note
// What rose of a triangle is noted like what was pushed, for the imprints that follow.

var<workgroup> noted: atomic<u32>;

@compute @workgroup_size(GROUP)
fn note_risen(id: Invocation) {
    let k = id.local;
    let piece = linear_group(id);
    work = links[step.link];
    let there = piece < arguments[2u * step.link + 1u].x && (work.flags & CHAINED) != 0u;
    if k == 0u {
        atomicStore(&noted, 0u);
    }
    workgroupBarrier();
    var it: Patchwork;
    if there {
        it = patchwork(listed[piece]);
        let record = pieces[PIECE * piece + RECORD_OF];
        let index = 256u * it.block + k;
        if record != 0u && index < value_count(SEGMENTS) {
            let now = (records[RECORD * (record - 1u) + HEADER + k / 2u] >> (16u * (k & 1u))) & 0xffffu;
            if now != pieces[PIECE * piece + k] >> 16u {
                atomicOr(&noted, note_of(index));
            }
        }
    }
    workgroupBarrier();
    if there && k == 0u && atomicLoad(&noted) != 0u {
        atomicOr(&slots[state_of(it.tile)], atomicLoad(&noted));
    }
}
