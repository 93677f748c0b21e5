// import common
// Prefix sums of the numbers that the invocations of a workgroup pass. A few of them sum up rows: three barriers in all,
// since barriers are dear where the device is the processor.

// Invocations of a row, and rows.
const ROW_SUMS: u32 = 16u;

var<workgroup> partial: array<u32, GROUP>;
var<workgroup> rows: array<u32, ROW_SUMS>;

/// The sum of what all lower invocations of the workgroup pass; `partial[GROUP - 1]` is then the sum of all.
fn group_exclusive(own: u32, local: u32) -> u32 {
    partial[local] = own;
    workgroupBarrier();
    let first = local * ROW_SUMS;
    var sum = 0u;
    if local < ROW_SUMS {
        for (var k = 0u; k < ROW_SUMS; k++) {
            sum += partial[first + k];
            partial[first + k] = sum;
        }
        rows[local] = sum;
    }
    workgroupBarrier();
    if local < ROW_SUMS {
        var lower = 0u;
        for (var k = 0u; k < local; k++) {
            lower += rows[k];
        }
        for (var k = 0u; k < ROW_SUMS; k++) {
            partial[first + k] += lower;
        }
    }
    workgroupBarrier();
    return partial[local] - own;
}
