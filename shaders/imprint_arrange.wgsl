// import common
// import imprint_link
// The workgroups of the passes over all chunks of imprints whose winding numbers are there at once, from the sums of their
// triangles' work.

// Units of 1,024 chunks that are too many to be counted.
const MOST_UNITS: u32 = 1u << 21u;

@group(0) @binding(1) var<storage, read> starts: array<u32>;
// Of the first imprint the number of chunks and the workgroups in x, y and z, and of each the same of its blocks.
@group(0) @binding(2) var<storage, read_write> arguments: array<vec4<u32>>;
@group(0) @binding(3) var<storage, read_write> told: AllTold;

// Where the work of imprint `link` and of those after it begins.
fn start_of(link: u32) -> u32 {
    return starts[links[link].first_work];
}

@compute @workgroup_size(1)
fn arrange() {
    let end = step.link + step.count;
    var first = step.link;
    while first < end {
        var stop = first;
        var units = 0u;
        while stop < end && links[stop].wave == first {
            let own = atomicLoad(&told.links[stop].work);
            units = select(units + own, MOST_UNITS, own >= MOST_UNITS || units >= MOST_UNITS);
            stop++;
        }
        let last = links[stop - 1u];
        // Sums of words may wrap round, but not those of the imprints that are taken together.
        var total = starts[last.first_work + last.triangles] - start_of(first);
        if units >= MOST_UNITS {
            for (var link = first; link < stop; link++) {
                atomicOr(&told.links[link].faults, TOO_MUCH);
            }
            total = 0u;
        }
        let needed = (total + GROUP - 1u) / GROUP;
        arguments[2u * first] = vec4(total, min(needed, ROW), (needed + ROW - 1u) / ROW, 1u);
        first = stop;
    }
}
