// import common
// The workgroups of the pass over all chunks, from the sum of the triangles' work.

struct Arrange {
    // Where the sum of all is.
    last: u32,
}

const ROW: u32 = 32768u;
const TOO_MUCH: u32 = 2u;

@group(0) @binding(0) var<storage, read> sums: array<u32>;
// The number of chunks, and the workgroups in x, y and z.
@group(0) @binding(1) var<storage, read_write> arguments: array<u32>;
@group(0) @binding(2) var<storage, read_write> state: array<u32>;
var<immediate> work: Arrange;

@compute @workgroup_size(1)
fn arrange() {
    var total = sums[work.last];
    if state[1] >= (1u << 21u) {
        state[0] |= TOO_MUCH;
        total = 0u;
    }
    state[1] = 0u;
    let needed = (total + GROUP - 1u) / GROUP;
    arguments[0] = total;
    arguments[1] = min(needed, ROW);
    arguments[2] = (needed + ROW - 1u) / ROW;
    arguments[3] = 1u;
}
