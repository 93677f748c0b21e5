// import common
// A stable radix sort of u32 keys with u32 values, four bits at a time, the lowest first: histograms of blocks, their
// prefix sums over all blocks (`scan.wgsl`), and the move. The rank of a key within its block comes from counters in
// workgroup memory, so nothing is assumed of subgroups (Satish, Harris, Garland 2009, Sections 4 and 5).

struct Digit {
    count: u32,
    shift: u32,
    blocks: u32,
}

@group(0) @binding(0) var<storage, read> keys_in: array<u32>;
@group(0) @binding(1) var<storage, read> values_in: array<u32>;
@group(0) @binding(2) var<storage, read_write> keys_out: array<u32>;
@group(0) @binding(3) var<storage, read_write> values_out: array<u32>;
// For every digit the counts of all blocks.
@group(0) @binding(4) var<storage, read_write> histogram: array<u32>;
var<immediate> digit: Digit;

const EACH: u32 = 8u;
const BLOCK: u32 = GROUP * EACH;
const DIGITS: u32 = 16u;

var<workgroup> total: array<atomic<u32>, DIGITS>;

@compute @workgroup_size(GROUP)
fn count(id: Invocation) {
    let block = linear_group(id);
    if id.local < DIGITS {
        atomicStore(&total[id.local], 0u);
    }
    workgroupBarrier();
    for (var k = 0u; k < EACH; k++) {
        let item = block * BLOCK + k * GROUP + id.local;
        if item < digit.count {
            atomicAdd(&total[(keys_in[item] >> digit.shift) % DIGITS], 1u);
        }
    }
    workgroupBarrier();
    if id.local < DIGITS && block < digit.blocks {
        histogram[id.local * digit.blocks + block] = atomicLoad(&total[id.local]);
    }
}

// Two counters of 16 bits a word, since a block has 2,048 keys: of digits d and d + 8. Word [d][invocation].
const PAIRS: u32 = DIGITS / 2u;
var<workgroup> counters: array<u32, PAIRS * GROUP>;

@compute @workgroup_size(GROUP)
fn move_keys(id: Invocation) {
    let block = linear_group(id);
    let first = block * BLOCK + id.local * EACH;
    for (var d = 0u; d < PAIRS; d++) {
        counters[d * GROUP + id.local] = 0u;
    }
    // An invocation has consecutive keys, so counting them in order keeps the sort stable.
    var key: array<u32, EACH>;
    var rank: array<u32, EACH>;
    for (var k = 0u; k < EACH; k++) {
        if first + k < digit.count {
            key[k] = keys_in[first + k];
            let d = (key[k] >> digit.shift) % DIGITS;
            let word = (d % PAIRS) * GROUP + id.local;
            let half = (d / PAIRS) * 16u;
            rank[k] = (counters[word] >> half) & 0xffffu;
            counters[word] += 1u << half;
        }
    }
    workgroupBarrier();
    // Prefix sums over the invocations, for all digits at once.
    for (var step = 1u; step < GROUP; step *= 2u) {
        var lower: array<u32, PAIRS>;
        for (var d = 0u; d < PAIRS; d++) {
            if id.local >= step {
                lower[d] = counters[d * GROUP + id.local - step];
            }
        }
        workgroupBarrier();
        for (var d = 0u; d < PAIRS; d++) {
            counters[d * GROUP + id.local] += lower[d];
        }
        workgroupBarrier();
    }
    for (var k = 0u; k < EACH; k++) {
        if first + k < digit.count {
            let d = (key[k] >> digit.shift) % DIGITS;
            var before = 0u;
            if id.local > 0u {
                before = (counters[(d % PAIRS) * GROUP + id.local - 1u] >> ((d / PAIRS) * 16u)) & 0xffffu;
            }
            let place = histogram[d * digit.blocks + block] + before + rank[k];
            keys_out[place] = key[k];
            values_out[place] = values_in[first + k];
        }
    }
}
