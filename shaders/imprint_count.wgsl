// import imprint_facet
// How much work every triangle is: the rows it covers times the chunks of columns it may cover in one.

@group(1) @binding(0) var<storage, read_write> counts: array<u32>;
// Faults, and the work of all triangles in units of 1,024, rounded up: sums of words may wrap round, this does not.
@group(1) @binding(1) var<storage, read_write> state: array<atomic<u32>>;

@compute @workgroup_size(GROUP)
fn count(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let triangle = linear_group(group, groups) * GROUP + local;
    if triangle >= work.triangles {
        return;
    }
    let f = facet(triangle);
    var items = 0u;
    if f.turn != 0 {
        let rows = clipped_rows(f);
        items = u32(rows.y - rows.x) * chunks(f);
        atomicAdd(&state[1], (items + 1023u) >> 10u);
    }
    counts[triangle] = items;
}
