// import common
// import halves
// import imprint_keep
// import triangle_imprint_slot
// import triangles
// What an imprint changed on a triangle mesh, smoothed (Schäfer et al. 2014, Section 6) for those of the submission that come
// after it, as `triangle::smoothing` of rust/detail does. A workgroup takes 256 values of a listed triangle's block, an
// invocation one. Triangles that share a value come to the same bits.

/// Segments of a side.
override SEGMENTS: u32 = 64u;

// What `triangle_imprint_touch` found.
@group(0) @binding(2) var<storage, read> marks: array<vec2<u32>>;
@group(0) @binding(3) var<storage, read> listed: array<u32>;
@group(0) @binding(4) var<storage, read> arguments: array<u32>;
// Of every value of the listed triangles the half that it is, with the rounds of neighbours after which it is smoothed as
// bits above, and the half that it becomes.
@group(0) @binding(8) var<storage, read_write> worked: array<atomic<u32>>;
// First words of the triangles' blocks, and their words.
@group(2) @binding(0) var<storage, read> entries: array<u32>;
@group(2) @binding(1) var<storage, read> values: array<u32>;

const ALLOCATED: u32 = 2u;
const SOURCE: u32 = 5u;

// The bit of a value that changed, and rounds of neighbours around it that are smoothed as well.
const FIRST_BIT: u32 = 16u;
const REACH: u32 = 2u;

var<workgroup> most: atomic<u32>;
var<workgroup> halves: array<u32, 256>;

// A value of a listed triangle.
struct Item {
    there: bool,
    face: u32,
    // Its place in the triangle's block, and in `worked`.
    index: u32,
    at: u32,
}

fn item_of(id: Invocation) -> Item {
    let piece = linear_group(id);
    work = links[step.link];
    let index = 256u * id.group.z + id.local;
    let there = piece < min(arguments[4u * step.link], work.blocks) && index < value_count(SEGMENTS);
    return Item(there, listed[select(0u, piece, there)], index, 2u * (256u * PARTS * piece + index));
}

fn half_in(word: u32, index: u32) -> u32 {
    return (word >> (16u * (index & 1u))) & 0xffffu;
}

// A value in record `place`, from 1, or before the submission.
fn recorded(face: u32, index: u32, place: u32) -> u32 {
    if place != 0u {
        return half_in(records[RECORD * (place - 1u) + HEADER + index % 256u / 2u], index);
    }
    let first = entries[face];
    return select(half_in(values[first + index / 2u], index), 0u, first == TRIANGLE_NONE);
}

// The record of a part of a triangle's block, from 1, or zero.
fn record_now(face: u32, part: u32) -> u32 {
    return atomicLoad(&slots[slot_of(face) + 1u + part]);
}

fn is_source(face: u32) -> bool {
    return (marks[face].x & SOURCE) == SOURCE;
}

// Whether a value belongs to what may be smoothed: a side or a corner of a triangle that may be if all that have it have
// blocks, since those without would follow it.
fn may_change(face: u32, node: Node) -> bool {
    let others = sharing(face, node);
    if others.count == 0u {
        return is_source(face);
    }
    var any_source = false;
    var all_there = true;
    for (var k = 0u; k < others.count; k++) {
        let other = mesh_words[others.first + k] / 3u;
        any_source = any_source || is_source(other);
        all_there = all_there && (marks[other].x & ALLOCATED) != 0u;
    }
    return any_source && all_there;
}

// What imprints left, and which values this one changed.
@compute @workgroup_size(GROUP)
fn bring(id: Invocation) {
    let it = item_of(id);
    if !it.there {
        return;
    }
    let place = record_now(it.face, id.group.z);
    let half = recorded(it.face, it.index, place);
    var bits = half;
    if place != 0u && records[RECORD * (place - 1u) + 1u] >> 16u == step.link {
        let before = recorded(it.face, it.index, records[RECORD * (place - 1u) + 3u]);
        if before != half && may_change(it.face, node_of(it.face, SEGMENTS, it.index)) {
            bits |= 1u << FIRST_BIT;
        }
    }
    atomicStore(&worked[it.at], bits);
}

// Where neighbour `node` of a value is in `worked`, or NONE.
fn place_of(face: u32, node: Node) -> u32 {
    let piece = marks[face].y;
    if piece == 0u {
        return NONE;
    }
    return 2u * (256u * PARTS * (piece - 1u) + value_of(face, SEGMENTS, node));
}

// Of the neighbours of a value in all triangles that have it: their sum, how many there are, and all their bits.
struct Around {
    sum: f32,
    count: f32,
    bits: u32,
}

fn around_of(face: u32, node: Node) -> Around {
    let others = sharing(face, node);
    var found: Around;
    for (var k = 0u; k < max(others.count, 1u); k++) {
        var seen = node;
        var from_face = face;
        if others.count > 0u {
            let other = mesh_words[others.first + k];
            seen = node_from(face, SEGMENTS, node, other);
            from_face = other / 3u;
        }
        for (var i = 0u; i < ring_count(SEGMENTS, seen); i++) {
            let at = place_of(from_face, ring_node(SEGMENTS, seen, i));
            if at != NONE {
                let bits = atomicLoad(&worked[at]);
                found.sum += value(bits & 0xffffu);
                found.count += 1.0;
                found.bits |= bits;
            }
        }
    }
    return found;
}

// Values beside values that are smoothed are smoothed too. The round is what the step counts.
@compute @workgroup_size(GROUP)
fn spread(id: Invocation) {
    let it = item_of(id);
    if !it.there {
        return;
    }
    let known = 1u << (FIRST_BIT + step.count);
    let own = atomicLoad(&worked[it.at]);
    let node = node_of(it.face, SEGMENTS, it.index);
    if (own & known) != 0u || ((around_of(it.face, node).bits & known) != 0u && may_change(it.face, node)) {
        atomicStore(&worked[it.at], own | (known << 1u));
    }
}

@compute @workgroup_size(GROUP)
fn average(id: Invocation) {
    let it = item_of(id);
    if !it.there {
        return;
    }
    let own = atomicLoad(&worked[it.at]);
    var half = own & 0xffffu;
    if (own & (1u << (FIRST_BIT + REACH))) != 0u {
        let around = around_of(it.face, node_of(it.face, SEGMENTS, it.index));
        let here = value(half);
        half = half_bits(here + rounded(work.strength * (around.sum / max(around.count, 1.0) - here)));
    }
    atomicStore(&worked[it.at + 1u], half);
}

@compute @workgroup_size(GROUP)
fn apply(id: Invocation) {
    let it = item_of(id);
    if !it.there {
        return;
    }
    let own = atomicLoad(&worked[it.at]);
    atomicStore(&worked[it.at], (own & 0xffff0000u) | atomicLoad(&worked[it.at + 1u]));
}

// Keeps what changed for the imprints that follow.
@compute @workgroup_size(GROUP)
fn settle(id: Invocation) {
    let it = item_of(id);
    if id.local == 0u {
        atomicStore(&sum_changed, 0);
        atomicStore(&least, 0);
        atomicStore(&most, 0u);
        shared_place = NONE;
    }
    halves[id.local] = 0u;
    workgroupBarrier();
    if it.there {
        let half = atomicLoad(&worked[it.at]) & 0xffffu;
        halves[id.local] = half;
        if half != recorded(it.face, it.index, record_now(it.face, id.group.z)) {
            atomicAdd(&sum_changed, 1);
        }
        atomicMin(&least, key(half));
        if half < 0x8000u {
            atomicMax(&most, half);
        }
    }
    workgroupBarrier();
    if id.local == 0u && atomicLoad(&sum_changed) > 0 {
        let place = take_record(vec4(it.face, id.group.z | SETTLED | (step.link << 16u), 0u, 0u));
        if place < work.records {
            atomicStore(&slots[slot_of(it.face) + 1u + id.group.z], place + 1u);
            atomicMax(&slots[slot_of(it.face)], u32(-atomicLoad(&least)));
            atomicMax(&slots[highest_of(it.face)], atomicLoad(&most));
        }
    }
    workgroupBarrier();
    let place = shared_place;
    if place < work.records && id.local < PAIRS {
        records[RECORD * place + HEADER + id.local] = halves[2u * id.local] | (halves[2u * id.local + 1u] << 16u);
    }
}
