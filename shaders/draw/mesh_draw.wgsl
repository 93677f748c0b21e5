// import shade
// Triangles whose points were computed before.

struct Corner {
    @location(0) p: vec3<f32>,
    @location(1) normal: vec3<f32>,
    @location(2) color: vec3<f32>,
    /// Lines go where one of these is a whole number.
    @location(3) grid: vec3<f32>,
    @location(4) tag: u32,
}

struct Colored {
    @builtin(position) @invariant position: vec4<f32>,
    @location(0) p: vec3<f32>,
    @location(1) normal: vec3<f32>,
    @location(2) grid: vec3<f32>,
    @location(3) color: vec3<f32>,
    @location(4) @interpolate(flat) tag: u32,
}

@vertex
fn vertex_mesh(corner: Corner) -> Colored {
    let out = shaded(corner.p, corner.normal, corner.grid, vec2(0.0), 0u, corner.tag);
    return Colored(out.position, out.p, out.normal, out.grid, corner.color, out.tag);
}

@fragment
fn fragment(in: Colored, @builtin(front_facing) front: bool) -> Pixel {
    let shape = Shaded(in.position, in.p, in.normal, in.grid, vec2(0.0), 0u, in.tag);
    return pixel(shape, front, in.color);
}
