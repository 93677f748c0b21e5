// import common
// import imprint_link
// The workgroups of the pass over all chunks of an imprint, from the sum of its triangles' work. A workgroup takes an
// imprint.

@group(0) @binding(1) var<storage, read> starts: array<u32>;
// Of every imprint the number of chunks and the workgroups in x, y and z, and the same of its blocks.
@group(0) @binding(2) var<storage, read_write> arguments: array<vec4<u32>>;
@group(0) @binding(3) var<storage, read_write> told: AllTold;

@compute @workgroup_size(1)
fn arrange(@builtin(workgroup_id) group: vec3<u32>) {
    let link = step.link + group.x;
    let first = links[link].first_work;
    var total = starts[first + links[link].triangles] - starts[first];
    if atomicLoad(&told.links[link].work) >= (1u << 21u) {
        atomicOr(&told.links[link].faults, TOO_MUCH);
        total = 0u;
    }
    let needed = (total + GROUP - 1u) / GROUP;
    arguments[2u * link] = vec4(total, min(needed, ROW), (needed + ROW - 1u) / ROW, 1u);
}
