// import common
// import halves
// import imprint_keep
// import imprint_ray
// import triangle_imprint_note
// The displacement update of listed triangles: every value's point that lies in the voxels goes along −N until it leaves
// them (Schäfer et al. 2014, Section 6, on the vertices of Schäfer et al. 2015, *Local Painting and Deformation of Meshes on
// the GPU*, Section 6). A workgroup takes 256 values of a triangle's block, which has those of its sides and corners too; an
// invocation takes two, which share a word. Triangles that share a value come to the same bits. The fourth word of a record
// is the slot of what was there before it, from 1, or zero.

@group(0) @binding(1) var<storage, read> listed: array<u32>;
@group(0) @binding(2) var<storage, read> arguments: array<vec4<u32>>;
// Of every triangle whether it has a block, as `HELD_NONE` and others.
@group(0) @binding(9) var<storage, read> held: array<u32>;
// First words of the triangles' blocks, and those from when the depth limit began to count.
@group(2) @binding(0) var<storage, read> entries: array<u32>;
@group(2) @binding(1) var<storage, read> values: array<u32>;
@group(3) @binding(0) var<storage, read> start_entries: array<u32>;
@group(3) @binding(1) var<storage, read> start_values: array<u32>;

// What changed of a triangle, as its state has it.
var<workgroup> noted: atomic<u32>;
// Whether values inside follow those on the sides.
var<workgroup> shared_follows: bool;

// A word of the block of a triangle as imprints of earlier dispatches left it.
fn word_before(face: u32, word: u32) -> u32 {
    if (work.flags & CHAINED) != 0u {
        let slot = atomicLoad(&slots[work.slots + face * work.stride + 1u + word / PAIRS]);
        if slot != 0u {
            return records[RECORD * (slot - 1u) + HEADER + word % PAIRS];
        }
    }
    let first = entries[face];
    return select(values[first + word], 0u, first == TRIANGLE_NONE);
}

@compute @workgroup_size(PAIRS)
fn cast_values(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let index = linear_group(group, groups);
    let there = index < arguments[2u * step.link + 1u].x;
    work = links[step.link];
    if local == 0u {
        atomicStore(&sum_changed, 0);
        atomicStore(&sum_clamped, 0);
        atomicStore(&least, 0);
        atomicStore(&noted, 0u);
        shared_place = NONE;
    }
    workgroupBarrier();
    let word = group.z * PAIRS + local;
    let all = value_count(SEGMENTS);
    var face = 0u;
    var changed = 0u;
    if there && 2u * word < all {
        face = listed[index];
        let before = word_before(face, word);
        var start = before;
        if (work.flags & STARTED) != 0u {
            let first = start_entries[face];
            start = select(start_values[first + word], 0u, first == TRIANGLE_NONE);
        }
        var differ = 0;
        var clamped = 0;
        for (var k = 0u; k < min(all - 2u * word, 2u); k++) {
            let foot = exact_foot(face, 2u * word + k);
            let old = (before >> (16u * k)) & 0xffffu;
            let ray = moved(foot.p + way_at(face, 2u * word + k), foot.normal, old, (start >> (16u * k)) & 0xffffu);
            changed |= half_of(ray.x) << (16u * k);
            if ray.x != key(old) {
                differ += 1;
                atomicOr(&noted, note_of(2u * word + k));
            }
            clamped += ray.y;
            atomicMin(&least, ray.x);
        }
        if differ > 0 {
            atomicAdd(&sum_changed, differ);
        }
        if clamped > 0 {
            atomicAdd(&sum_clamped, clamped);
        }
    }
    workgroupBarrier();
    if local == 0u && there {
        face = listed[index];
        let chained = (work.flags & CHAINED) != 0u;
        var previous = 0u;
        if chained {
            previous = atomicLoad(&slots[slot_of(face) + 1u + group.z]);
        }
        keep(vec4(face, group.z, 0u, 0u), step.link);
        if chained && atomicLoad(&noted) != 0u {
            atomicOr(&slots[state_of(face)], atomicLoad(&noted));
        }
        if shared_place < work.records {
            records[RECORD * shared_place + 3u] = previous;
        }
    }
    workgroupBarrier();
    let place = shared_place;
    if place < work.records {
        records[RECORD * place + HEADER + local] = changed;
    }
}

// A value of a triangle's block as it is now.
fn value_now(face: u32, index: u32) -> f32 {
    return value((word_before(face, index / 2u) >> (16u * (index & 1u))) & 0xffffu);
}

// What is read inside a triangle without a block.
fn fan_at(face: u32, index: u32) -> f32 {
    let at = vec3(inside[3u * index], inside[3u * index + 1u], inside[3u * index + 2u]);
    let corners = inner_count(SEGMENTS) + 3u * (SEGMENTS - 1u);
    var sum = 0.0;
    for (var side = 0u; side < 3u; side++) {
        let it = side_below(face, SEGMENTS, side, at);
        let ends = vec2(value_now(face, it.start), value_now(face, it.end));
        let beside = vec2(value_now(face, it.low), value_now(face, it.high));
        let near = at[side] + at[(side + 1u) % 3u];
        sum += value_now(face, corners + side) * at[side] + bulge(it, vec4(ends, beside)) * near;
    }
    return sum;
}

// Whether a triangle has a block, or gets one by what changed inside or at a corner.
fn has_block(face: u32) -> bool {
    return held[face] == HELD_WHOLE || (atomicLoad(&slots[state_of(face)]) & (TAKEN | INNER)) != 0u;
}

// Whether the sides of a triangle changed that has no block and gets none, as `faces_of` of rust/detail decides: an edge
// none of whose triangles has a block gives its first one.
fn follows(face: u32, part: u32) -> bool {
    let state = atomicLoad(&slots[state_of(face)]);
    if held[face] != HELD_NONE || (state & (TAKEN | INNER)) != 0u {
        return false;
    }
    var any_side = false;
    for (var side = 0u; side < 3u; side++) {
        if (state & (SIDES << side)) == 0u {
            continue;
        }
        any_side = true;
        let along = mesh_along(mesh_side(face, side) / 2u);
        var given = mesh_words[along.first] / 3u == face;
        for (var k = 0u; k < along.count; k++) {
            given = given && !has_block(mesh_words[along.first + k] / 3u);
        }
        if given {
            if part == 0u {
                atomicOr(&slots[state_of(face)], GIVEN);
            }
            return false;
        }
    }
    return any_side;
}

// Takes a record for values inside, that of the imprint if there is one.
fn keep_following(face: u32, part: u32) {
    let lowest = atomicLoad(&least);
    atomicMax(&slots[slot_of(face)], u32(-lowest));
    let slot = atomicLoad(&slots[slot_of(face) + 1u + part]);
    if slot != 0u && records[RECORD * (slot - 1u) + 1u] >> 16u == step.link {
        shared_place = slot - 1u;
        records[RECORD * (slot - 1u) + 1u] |= FANNED;
        return;
    }
    let place = take_record(vec4(face, part | FANNED | (step.link << 16u), 0u, slot));
    if place >= work.records {
        return;
    }
    // Others read the one before meanwhile.
    atomicStore(&slots[state_of(face) + 1u + part], place + 1u);
    atomicOr(&slots[state_of(face)], WAITING);
}

// After an imprint that others of the submission follow: a triangle without a block reads inside what its sides say.
@compute @workgroup_size(PAIRS)
fn follow_sides(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let index = linear_group(group, groups);
    let there = index < arguments[2u * step.link + 1u].x;
    work = links[step.link];
    if local == 0u {
        atomicStore(&sum_changed, 0);
        atomicStore(&least, 0);
        shared_place = NONE;
        shared_follows = there && follows(listed[select(0u, index, there)], group.z);
    }
    workgroupBarrier();
    let word = group.z * PAIRS + local;
    let inner = inner_count(SEGMENTS);
    var face = 0u;
    var made = 0u;
    if shared_follows && 2u * word < value_count(SEGMENTS) {
        face = listed[index];
        let before = word_before(face, word);
        made = before;
        for (var k = 0u; k < 2u; k++) {
            if 2u * word + k < inner {
                let half = half_bits(fan_at(face, 2u * word + k));
                made = (made & ~(0xffffu << (16u * k))) | (half << (16u * k));
                atomicMin(&least, key(half));
            }
        }
        if made != before {
            atomicAdd(&sum_changed, 1);
        }
    }
    workgroupBarrier();
    if local == 0u && atomicLoad(&sum_changed) > 0 {
        face = listed[index];
        keep_following(face, group.z);
    }
    workgroupBarrier();
    let place = shared_place;
    if place < work.records {
        records[RECORD * place + HEADER + local] = made;
    }
}
