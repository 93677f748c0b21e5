// import common
// import imprint_link
// The workgroups of the pass over all chunks of imprints that are voxelised together, from the sum of their triangles'
// work.

// Units of 1,024 chunks that are too many to be counted.
const MOST_UNITS: u32 = 1u << 21u;

@group(0) @binding(1) var<storage, read> starts: array<u32>;
// Of the first imprint the number of chunks and the workgroups in x, y and z, and of each the same of its blocks.
@group(0) @binding(2) var<storage, read_write> arguments: array<vec4<u32>>;
@group(0) @binding(3) var<storage, read_write> told: AllTold;

@compute @workgroup_size(1)
fn arrange() {
    let end = step.link + step.count;
    var total = starts[links[end - 1u].first_work + links[end - 1u].triangles];
    var units = 0u;
    for (var link = step.link; link < end; link++) {
        let own = atomicLoad(&told.links[link].work);
        units = select(units + own, MOST_UNITS, own >= MOST_UNITS || units >= MOST_UNITS);
    }
    if units >= MOST_UNITS {
        for (var link = step.link; link < end; link++) {
            atomicOr(&told.links[link].faults, TOO_MUCH);
        }
        total = 0u;
    }
    let needed = (total + GROUP - 1u) / GROUP;
    arguments[2u * step.link] = vec4(total, min(needed, ROW), (needed + ROW - 1u) / ROW, 1u);
}
