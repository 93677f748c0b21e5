// import affine
// The depths alone of what `posed_draw.wgsl` draws, at the same places to the bit.

struct Posed {
    p: vec3<f32>,
    normal: u32,
    tag: u32,
    corner: u32,
}

struct Instance {
    number: u32,
    first_matrix: u32,
    first_weight: u32,
    model: u32,
    transform: array<vec4<f32>, 3>,
}

/// From the world to the picture.
struct Call {
    clip: mat4x4<f32>,
}

@group(0) @binding(0) var<storage, read> posed: array<Posed>;
@group(0) @binding(1) var<storage, read> instances: array<Instance>;
var<immediate> call: Call;

struct Placed {
    @builtin(position) @invariant position: vec4<f32>,
}

@vertex
fn vertex_depth(@location(0) corner: vec2<u32>) -> Placed {
    let instance = instances[corner.y];
    let map = Affine(instance.transform[0], instance.transform[1], instance.transform[2]);
    return Placed(call.clip * vec4(affine_point(map, posed[corner.x].p), 1.0));
}
