// import common
// import surface
// The boxes of the tiles of a surface in its pose, without displacement: those of the control points of their patches.

// Two of each tile: the least and the largest coordinates. Of a tile without patches the least are above the largest.
@group(0) @binding(0) var<storage, read_write> boxes: array<vec4<f32>>;
var<immediate> tiles: u32;

const FAR: f32 = 3.0e38;

@compute @workgroup_size(GROUP)
fn bound(id: Invocation) {
    let tile = linear_group(id) * GROUP + id.local;
    if tile >= tiles {
        return;
    }
    var low = vec3(FAR);
    var high = vec3(-FAR);
    for (var k = surface_tiles[tile].x; k < surface_tiles[tile + 1u].x; k++) {
        let it = surface_patches[k];
        let count = select(16u, 20u, it.form == 1u);
        let x = it.first + SURFACE_ORIGIN;
        let origin = vec3(surface_number(it.first), surface_number(it.first + 1u), surface_number(it.first + 2u));
        for (var i = x; i < x + count; i++) {
            let p = origin + vec3(surface_number(i), surface_number(i + count), surface_number(i + 2u * count));
            low = min(low, p);
            high = max(high, p);
        }
    }
    boxes[2u * tile] = vec4(low, 0.0);
    boxes[2u * tile + 1u] = vec4(high, 0.0);
}
