// import block_sums
// Exclusive prefix sums of u32 in three steps: the sum of every block, the prefix sums of those, the prefix sums within
// every block. No invocation waits for another workgroup, as the decoupled look-back does: nothing promises that the
// other one runs (Merrill, Garland 2016, Section 4.4, name the guarantee they need).

// How many items there are: the host's number, or an element of a buffer, of which at most so many count.
struct Length {
    // Number of items, if `indirect` is 0. Else the index of that number in `lengths`, plus 1.
    count: u32,
    indirect: u32,
}

@group(0) @binding(0) var<storage, read_write> items: array<u32>;
@group(0) @binding(2) var<storage, read> lengths: array<u32>;
var<immediate> length: Length;

const BLOCK: u32 = GROUP * EACH;

fn count_of() -> u32 {
    if length.indirect == 0u {
        return length.count;
    }
    return min(length.count, lengths[length.indirect - 1u]);
}

@compute @workgroup_size(GROUP)
fn reduce(id: Invocation) {
    let block = linear_group(id);
    let count = count_of();
    let first = block * BLOCK + id.local * EACH;
    var sum = 0u;
    for (var k = 0u; k < EACH; k++) {
        if first + k < count {
            sum += items[first + k];
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

// One workgroup turns the sums of all blocks into what lies before each block, and puts the sum of all at the end.
@compute @workgroup_size(GROUP)
fn spine(@builtin(local_invocation_index) local: u32) {
    let blocks = (count_of() + BLOCK - 1u) / BLOCK;
    sum_up(blocks, local);
}

@compute @workgroup_size(GROUP)
fn distribute(id: Invocation) {
    let block = linear_group(id);
    let count = count_of();
    let first = block * BLOCK + id.local * EACH;
    var own: array<u32, EACH>;
    var sum = 0u;
    for (var k = 0u; k < EACH; k++) {
        if first + k < count {
            own[k] = items[first + k];
        }
        sum += own[k];
    }
    var lower = group_exclusive(sum, id.local);
    if block < arrayLength(&sums) {
        lower += sums[block];
    }
    for (var k = 0u; k < EACH; k++) {
        if first + k < count {
            items[first + k] = lower;
        }
        lower += own[k];
    }
}
