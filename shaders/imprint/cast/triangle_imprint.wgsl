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
// First words of the triangles' blocks, and those from when the depth limit began to count.
@group(2) @binding(0) var<storage, read> entries: array<u32>;
@group(2) @binding(1) var<storage, read> values: array<u32>;
@group(3) @binding(0) var<storage, read> start_entries: array<u32>;
@group(3) @binding(1) var<storage, read> start_values: array<u32>;

// What changed of a triangle, as its state has it.
var<workgroup> noted: atomic<u32>;

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
fn cast_values(id: Invocation) {
    let index = linear_group(id);
    let there = index < arguments[2u * step.link + 1u].x;
    work = links[step.link];
    if id.local == 0u {
        atomicStore(&sum_changed, 0);
        atomicStore(&sum_clamped, 0);
        atomicStore(&least, 0);
        atomicStore(&noted, 0u);
        shared_place = NONE;
    }
    workgroupBarrier();
    let word = id.group.z * PAIRS + id.local;
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
    if id.local == 0u && there {
        face = listed[index];
        let chained = (work.flags & CHAINED) != 0u;
        var previous = 0u;
        if chained {
            previous = atomicLoad(&slots[slot_of(face) + 1u + id.group.z]);
        }
        keep(vec4(face, id.group.z, 0u, 0u), step.link);
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
        records[RECORD * place + HEADER + id.local] = changed;
    }
}
