// import block_sums
// import imprint_link
// Where the work of every workgroup of triangles begins, and from that the workgroups of the passes over all chunks of
// imprints whose winding numbers are there at once. One workgroup does it, and begins the lists of what culling finds.
// `sums` has how much every workgroup has, then what lies before it; one more than there are.

// Units of 1,024 chunks that are too many to be counted.
const MAX_UNITS: u32 = 1u << 21u;

// Of the first imprint the number of chunks and the workgroups in x, y and z, and of each the same of its blocks.
@group(0) @binding(2) var<storage, read_write> arguments: array<vec4<u32>>;
@group(0) @binding(3) var<storage, read_write> counters: AllCounters;
// Of every imprint the number of listed tiles and the workgroups that take them.
@group(0) @binding(4) var<storage, read_write> candidates: array<vec4<u32>>;

// Where the workgroups of imprint `link` begin, and those after its last.
fn first_of(link: u32) -> u32 {
    return links[link].first_work / COUNTED;
}

fn end_of(link: u32) -> u32 {
    return first_of(link) + (links[link].triangles + COUNTED - 1u) / COUNTED;
}

@compute @workgroup_size(GROUP)
fn arrange(@builtin(local_invocation_index) local: u32) {
    let end = step.link + step.count;
    // Nothing is listed so far.
    if local < step.count {
        arguments[2u * (step.link + local) + 1u] = vec4(0u);
        candidates[step.link + local] = vec4(0u);
    }
    sum_up(end_of(end - 1u), local);
    storageBarrier();
    if local != 0u {
        return;
    }
    var first = step.link;
    while first < end {
        var stop = first;
        var units = 0u;
        while stop < end && links[stop].wave == first {
            let own = atomicLoad(&counters.links[stop].work);
            units = select(units + own, MAX_UNITS, own >= MAX_UNITS || units >= MAX_UNITS);
            stop++;
        }
        // Sums of words may wrap round, but not those of the imprints that are taken together.
        var total = sums[end_of(stop - 1u)] - sums[first_of(first)];
        if units >= MAX_UNITS {
            for (var link = first; link < stop; link++) {
                atomicOr(&counters.links[link].faults, TOO_MUCH);
            }
            total = 0u;
        }
        let needed = (total + GROUP - 1u) / GROUP;
        arguments[2u * first] = vec4(total, min(needed, ROW), (needed + ROW - 1u) / ROW, 1u);
        first = stop;
    }
}
