// import shade
// import octahedron
// import affine
// Triangles of clusters that `crowd_pose.wgsl` has posed, placed in the world by their instances.

/// A vertex that kernels have posed.
struct PosedVertex {
    /// Position in the space of the model.
    p: vec3<f32>,
    /// The normal on an octahedron, in two numbers of 16 bits.
    normal: u32,
    /// Which of the false colours, or INSTANCE_TAG.
    tag: u32,
    /// Where wireframes have lines, the number of this corner in its triangles, 0 to 2; elsewhere 3.
    corner: u32,
}

struct Instance {
    number: u32,
    first_matrix: u32,
    first_weight: u32,
    model: u32,
    transform: array<vec4<f32>, 3>,
}

@group(1) @binding(0) var<storage, read> posed: array<PosedVertex>;
@group(1) @binding(1) var<storage, read> instances: array<Instance>;

/// The false colour that is that of the number of the instance.
const INSTANCE_TAG: u32 = 0xfffffffeu;

/// A corner is the number of its vertex and that of its instance.
@vertex
fn vertex_posed(@location(0) corner: vec2<u32>) -> Shaded {
    let vertex = posed[corner.x];
    let instance = instances[corner.y];
    let map = Affine(instance.transform[0], instance.transform[1], instance.transform[2]);
    let normal = affine_normal(map, octahedral_normal(vertex.normal));
    // The line of an edge goes where its coordinate is 0; it is 1/2 at the corner that the edge does not have.
    let away = (vec3(vertex.corner) + vec3(3u, 2u, 1u)) % 3u;
    let grid = select(vec3(0.0), vec3(0.5), vec3(vertex.corner == 3u) | (away == vec3(2u)));
    let tag = select(vertex.tag, instance.number, vertex.tag == INSTANCE_TAG);
    return shaded(affine_point(map, vertex.p), normal, grid, vec2(0.0), instance.number, tag);
}

@fragment
fn fragment(in: Shaded, @builtin(front_facing) front: bool) -> Pixel {
    return pixel(in, front, object.base_color);
}
