// import common
// import triangles
// import brush
// Which triangles the box of a brush may reach, and what is to be done with the memory of each (Schäfer et al. 2015, *Local
// Painting and Deformation of Meshes on the GPU*, Sections 4 and 6).

// How far every triangle is displaced at most, object units.
@group(0) @binding(0) var<storage, read> reaches: array<f32>;
// The block of every triangle.
@group(0) @binding(1) var<storage, read> pointers: array<u32>;
@group(0) @binding(2) var<storage, read> states: array<u32>;
// The sets of every triangle.
@group(0) @binding(3) var<storage, read_write> masks: array<u32>;
var<immediate> work: Intersect;

fn meets(face: u32) -> bool {
    var low = vec3(3.0e38);
    var high = vec3(-3.0e38);
    var far = vec3(0.0);
    for (var corner = 0u; corner < 3u; corner++) {
        let point = mesh_foot(mesh_corner(face, corner)).p;
        far = max(far, abs(point));
        let p = vec4(point - work.origin, 1.0);
        let place = vec3(dot(work.row_x, p), dot(work.row_y, p), dot(work.row_z, p));
        low = min(low, place);
        high = max(high, place);
    }
    let sizes = vec3(length(work.row_x.xyz), length(work.row_y.xyz), length(work.row_z.xyz));
    let rounding = ROUNDING * far;
    let widths = vec3(
        dot(abs(work.row_x.xyz), rounding),
        dot(abs(work.row_y.xyz), rounding),
        dot(abs(work.row_z.xyz), rounding),
    );
    let limit = reaches[face] * sizes + widths + 1.0 + SLACK;
    return all(low <= limit) && all(high >= -limit);
}

@compute @workgroup_size(GROUP)
fn intersect(id: Invocation) {
    let face = linear_group(id) * GROUP + id.local;
    if face >= work.tiles {
        return;
    }
    let block = pointers[face];
    let unchanged = block != BLOCK_NONE && states[BLOCK_WORDS * block + BLOCK_CHANGES] == 0u;
    masks[face] = sets_of(meets(face), block != BLOCK_NONE, unchanged);
}
