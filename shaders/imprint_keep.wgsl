// import common
// The blocks that an imprint changes, on their way back to the host and for the imprints after it. A workgroup takes a
// listed block.

const PAIRS: u32 = 128u;
const NONE: u32 = 0xffffffffu;

// Words of a record: tile, block with the number of the imprint in the upper half, coefficients that change, the least
// of all as `key`, and the coefficients.
const RECORD: u32 = 132u;
const HEADER: u32 = 4u;

// Words that are told of an imprint, see `imprint_list`.
const TOLD: u32 = 8u;

const CHAINED: u32 = 2u;

struct Keeping {
    flags: u32,
    base: u32,
    stride: u32,
    // Records that there is room for.
    room: u32,
    link: u32,
}

@group(0) @binding(0) var<storage, read> listed: array<vec2<u32>>;
@group(0) @binding(1) var<storage, read> arguments: array<u32>;
@group(0) @binding(2) var<storage, read> reports: array<vec4<i32>>;
@group(0) @binding(3) var<storage, read> changed: array<u32>;
@group(0) @binding(4) var<storage, read_write> told: array<atomic<u32>>;
@group(0) @binding(5) var<storage, read_write> records: array<u32>;
@group(0) @binding(6) var<storage, read_write> slots: array<u32>;
// The least coefficient of every tile of the object that imprints left, as `key`, 0 at most.
@group(1) @binding(0) var<storage, read_write> lowered: array<atomic<i32>>;
var<immediate> work: Keeping;

var<workgroup> shared_place: u32;

@compute @workgroup_size(PAIRS)
fn keep(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let index = linear_group(group, groups);
    let there = index < arguments[0];
    var report = vec4(0);
    if there {
        report = reports[index];
    }
    if local == 0u {
        var place = NONE;
        if report.y > 0 {
            atomicAdd(&told[4u + TOLD * work.link + 1u], u32(report.y));
        }
        if report.x > 0 {
            place = atomicAdd(&told[0], 1u);
        }
        shared_place = place;
    }
    workgroupBarrier();
    let place = shared_place;
    if place < work.room {
        let first = RECORD * place;
        records[first + HEADER + local] = changed[index * PAIRS + local];
        if local == 0u {
            let tile = listed[index].x;
            let block = listed[index].y & 0xffffu;
            records[first] = tile;
            records[first + 1u] = block | (work.link << 16u);
            records[first + 2u] = u32(report.x);
            records[first + 3u] = u32(report.z);
            if (work.flags & CHAINED) != 0u {
                slots[work.base + tile * work.stride + block] = place + 1u;
                atomicMin(&lowered[tile], report.z);
            }
        }
    }
}
