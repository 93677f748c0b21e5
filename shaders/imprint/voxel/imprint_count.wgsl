// import group_sums
// import imprint_facet
// How much work every triangle is: the rows it covers times the chunks of columns it may cover in one. Workgroups of a row
// take an imprint, and each leaves where the work of its triangles begins in its own, and how much that is.

@group(0) @binding(3) var<storage, read_write> starts: array<u32>;
@group(0) @binding(4) var<storage, read_write> counters: AllCounters;
// Of every workgroup of all imprints, one after the other.
@group(0) @binding(5) var<storage, read_write> sums: array<u32>;

const EACH: u32 = COUNTED / GROUP;

@compute @workgroup_size(GROUP)
fn count(id: Invocation) {
    let link = step.link + id.group.y;
    work = links[link];
    let first = id.group.x * COUNTED + EACH * id.local;
    var items: array<u32, EACH>;
    var sum = 0u;
    for (var k = 0u; k < EACH && first + k < work.triangles; k++) {
        let f = facet(first + k);
        if f.turn != 0 {
            let rows = clipped_rows(f);
            items[k] = u32(rows.y - rows.x) * chunks(f);
            sum += items[k];
            atomicAdd(&counters.links[link].work, (items[k] + 1023u) >> 10u);
        }
    }
    var start = group_exclusive(sum, id.local);
    for (var k = 0u; k < EACH && first + k < work.triangles; k++) {
        starts[work.first_work + first + k] = start;
        start += items[k];
    }
    if id.local == 0u && first < work.triangles {
        sums[work.first_work / COUNTED + id.group.x] = partial[GROUP - 1u];
    }
}
