// import shade
// import octahedron
// Triangles that kernels have written.

struct Corner {
    @location(0) p: vec3<f32>,
    @location(1) normal: u32,
}

@vertex
fn vertex_indirect(corner: Corner) -> Shaded {
    return shaded(corner.p, octahedral_normal(corner.normal), vec3(0.5), vec2(0.0), 0u, 0xffffffffu);
}

@fragment
fn fragment(in: Shaded, @builtin(front_facing) front: bool) -> Pixel {
    return pixel(in, front, object.base_color);
}
