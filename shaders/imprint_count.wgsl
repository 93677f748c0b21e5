// import imprint_facet
// How much work every triangle is: the rows it covers times the chunks of columns it may cover in one. Workgroups of a row
// take an imprint; one item more than there are triangles makes their sum that of all.

@group(0) @binding(3) var<storage, read_write> counts: array<u32>;
@group(0) @binding(4) var<storage, read_write> told: AllTold;

@compute @workgroup_size(GROUP)
fn count(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let link = step.link + group.y;
    work = links[link];
    let triangle = group.x * GROUP + local;
    if triangle > work.triangles {
        return;
    }
    var items = 0u;
    if triangle < work.triangles {
        let f = facet(triangle);
        if f.turn != 0 {
            let rows = clipped_rows(f);
            items = u32(rows.y - rows.x) * chunks(f);
            atomicAdd(&told.links[link].work, (items + 1023u) >> 10u);
        }
    }
    counts[work.first_work + triangle] = items;
}
