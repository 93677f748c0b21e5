// import common
// import triangle_imprint_slot
// import triangles
// Which triangles smoothing looks at after an imprint: triangles that have a value which it may smooth, and so all around them.
// An invocation takes a triangle.

// Of every triangle whether it has a block, as `HELD_NONE` and others.
@group(0) @binding(1) var<storage, read> held: array<u32>;
// Of every triangle what smoothing knows of it, and its place in the list, from 1.
@group(0) @binding(2) var<storage, read_write> marks: array<vec2<u32>>;
@group(0) @binding(3) var<storage, read_write> listed: array<u32>;
// Of every imprint how many are listed, and the arguments of what takes their values, 256 a workgroup.
@group(0) @binding(4) var<storage, read_write> arguments: array<atomic<u32>>;
@group(0) @binding(5) var<storage, read> slots: array<u32>;
@group(0) @binding(6) var<storage, read_write> counters: AllCounters;

// That a triangle has a block of as many segments, or any; that values in and around it are smoothed.
const FINE: u32 = 1u;
const ALLOCATED: u32 = 2u;
const SHOWN: u32 = 4u;
const SOURCE: u32 = 5u;

// Whether a triangle had a block of as many segments before the imprint.
fn was_whole(face: u32) -> bool {
    return held[face] == HELD_WHOLE || (slots[state_of(face)] & TAKEN) != 0u;
}

// Whether a triangle looks different after the imprint, as `TriangleChange::faces_shown` of rust/tiles has it: a new block
// divides the sides of those beside it.
fn is_shown(face: u32) -> bool {
    if (slots[state_of(face)] & CHANGED) != 0u {
        return true;
    }
    for (var side = 0u; side < 3u; side++) {
        let along = mesh_along(mesh_side(face, side) / 2u);
        for (var k = 0u; k < along.count; k++) {
            let other = mesh_words[along.first + k] / 3u;
            let state = slots[state_of(other)];
            if (state & INNER) != 0u || ((state & SIDES) != 0u && !was_whole(other)) {
                return true;
            }
        }
    }
    return false;
}

@compute @workgroup_size(GROUP)
fn mark(id: Invocation) {
    let face = linear_group(id) * GROUP + id.local;
    work = links[step.link];
    if face >= work.tiles {
        return;
    }
    let whole = was_whole(face) || (slots[state_of(face)] & CHANGED) != 0u;
    var bits = select(0u, FINE, whole) | select(0u, ALLOCATED, whole || held[face] != HELD_NONE);
    bits |= select(0u, SHOWN, is_shown(face));
    marks[face] = vec2(bits, 0u);
}

@compute @workgroup_size(GROUP)
fn list(id: Invocation) {
    let face = linear_group(id) * GROUP + id.local;
    work = links[step.link];
    if face >= work.tiles {
        return;
    }
    var beside = false;
    for (var corner = 0u; corner < 3u && !beside; corner++) {
        let around = mesh_around(mesh_corner(face, corner));
        for (var k = 0u; k < around.count; k++) {
            beside = beside || (marks[mesh_words[around.first + k] / 3u].x & SOURCE) == SOURCE;
        }
    }
    if !beside {
        return;
    }
    let at = 4u * step.link;
    let place = atomicAdd(&arguments[at], 1u);
    atomicMax(&counters.taken, place + 1u);
    if place >= work.blocks {
        return;
    }
    listed[place] = face;
    marks[face].y = place + 1u;
    atomicMax(&arguments[at + 1u], min(place + 1u, ROW));
    atomicMax(&arguments[at + 2u], place / ROW + 1u);
    atomicMax(&arguments[at + 3u], PARTS);
}
