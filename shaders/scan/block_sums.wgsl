// import group_sums
// Exclusive prefix sums of a list that one workgroup goes through.

@group(0) @binding(1) var<storage, read_write> sums: array<u32>;

// Items of an invocation.
const EACH: u32 = 8u;

/// Puts what lies before them in place of the first `count` sums, and the sum of all after them.
fn sum_up(count: u32, local: u32) {
    var before = 0u;
    for (var base = 0u; base < count; base += EACH * GROUP) {
        let first = base + local * EACH;
        var own: array<u32, EACH>;
        var sum = 0u;
        for (var k = 0u; k < EACH; k++) {
            if first + k < count {
                own[k] = sums[first + k];
            }
            sum += own[k];
        }
        var lower = before + group_exclusive(sum, local);
        before += partial[GROUP - 1u];
        for (var k = 0u; k < EACH; k++) {
            if first + k < count {
                sums[first + k] = lower;
            }
            lower += own[k];
        }
        workgroupBarrier();
    }
    if local == 0u {
        sums[count] = before;
    }
}
