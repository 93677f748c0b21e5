// import common
// Multi-compaction: the indices of the items of up to four classes, in ascending order, one list per . An item may
// be in several classes: bit c of its mask says that it is in class c (Schäfer et al. 2014, Section 4).

struct Classes {
    count: u32,
    classes: u32,
    // Items of a list's room; the list of class c begins at c times this.
    stride: u32,
}

@group(0) @binding(0) var<storage, read> masks: array<u32>;
@group(0) @binding(1) var<storage, read_write> lists: array<u32>;
// For every class the number of its items and the workgroups that take one item per invocation, in x, y and z.
@group(0) @binding(2) var<storage, read_write> counts: array<u32>;
@group(0) @binding(3) var<storage, read_write> sums: array<vec4<u32>>;
var<immediate> work: Classes;

const EACH: u32 = 8u;
const BLOCK: u32 = GROUP * EACH;
const ROW: u32 = 32768u;

var<workgroup> partial: array<vec4<u32>, GROUP>;

fn bits(mask: u32) -> vec4<u32> {
    return (vec4(mask) >> vec4(0u, 1u, 2u, 3u)) & vec4(1u);
}

fn group_exclusive(own: vec4<u32>, local: u32) -> vec4<u32> {
    partial[local] = own;
    workgroupBarrier();
    for (var step = 1u; step < GROUP; step *= 2u) {
        var lower = vec4(0u);
        if local >= step {
            lower = partial[local - step];
        }
        workgroupBarrier();
        partial[local] += lower;
        workgroupBarrier();
    }
    return partial[local] - own;
}

@compute @workgroup_size(GROUP)
fn reduce(id: Invocation) {
    let block = linear_group(id);
    var sum = vec4(0u);
    for (var k = 0u; k < EACH; k++) {
        // Neighbours read neighbours: the order within a block does not matter here.
        let item = block * BLOCK + k * GROUP + id.local;
        if item < work.count {
            sum += bits(masks[item]);
        }
    }
    partial[id.local] = sum;
    workgroupBarrier();
    for (var step = GROUP / 2u; step > 0u; step /= 2u) {
        if id.local < step {
            partial[id.local] += partial[id.local + step];
        }
        workgroupBarrier();
    }
    if id.local == 0u && block < arrayLength(&sums) {
        sums[block] = partial[0];
    }
}

@compute @workgroup_size(GROUP)
fn spine(@builtin(local_invocation_index) local: u32) {
    let blocks = (work.count + BLOCK - 1u) / BLOCK;
    var before = vec4(0u);
    for (var base = 0u; base < blocks; base += GROUP) {
        let block = base + local;
        var own = vec4(0u);
        if block < blocks {
            own = sums[block];
        }
        let lower = before + group_exclusive(own, local);
        before += partial[GROUP - 1u];
        if block < blocks {
            sums[block] = lower;
        }
        workgroupBarrier();
    }
    if local < work.classes {
        let count = before[local];
        let needed = (count + GROUP - 1u) / GROUP;
        counts[4u * local] = count;
        counts[4u * local + 1u] = min(needed, ROW);
        counts[4u * local + 2u] = (needed + ROW - 1u) / ROW;
        counts[4u * local + 3u] = 1u;
    }
}

@compute @workgroup_size(GROUP)
fn distribute(id: Invocation) {
    let block = linear_group(id);
    let first = block * BLOCK + id.local * EACH;
    var own: array<u32, EACH>;
    var sum = vec4(0u);
    for (var k = 0u; k < EACH; k++) {
        if first + k < work.count {
            own[k] = masks[first + k];
        }
        sum += bits(own[k]);
    }
    var lower = group_exclusive(sum, id.local);
    if block < arrayLength(&sums) {
        lower += sums[block];
    }
    for (var k = 0u; k < EACH; k++) {
        if own[k] == 0u {
            continue;
        }
        for (var c = 0u; c < work.classes; c++) {
            if ((own[k] >> c) & 1u) == 1u {
                lists[c * work.stride + lower[c]] = first + k;
            }
        }
        lower += bits(own[k]);
    }
}
