// The shaders of the viewport. SPIR-V of them is in viewport_shader.hpp, which viewport_shader.cmake makes.

struct Placed {
    /// From the object to what the camera sees.
    clip: mat4x4<f32>,
    /// From directions of the object to those of the world.
    turn: mat3x3<f32>,
}

var<immediate> placed: Placed;

struct Seen {
    @builtin(position) place: vec4<f32>,
    @location(0) normal: vec3<f32>,
    @location(1) color: vec3<f32>,
}

@vertex
fn point(
    @location(0) position: vec3<f32>,
    @location(1) normal: vec3<f32>,
    @location(2) color: vec3<f32>,
) -> Seen {
    return Seen(placed.clip * vec4(position, 1.0), placed.turn * normal, color);
}

// The light of renderer.cpp, without shadows. Alpha is 1 where an object is seen.
@fragment
fn light(seen: Seen) -> @location(0) vec4<f32> {
    let normal = normalize(seen.normal);
    let sun = max(dot(normal, normalize(vec3(0.5, -0.6, 0.6))), 0.0);
    let sky = 0.6 + 0.4 * normal.z;
    return vec4(seen.color * (vec3(0.9, 0.82, 0.7) * sun + vec3(0.25, 0.3, 0.4) * sky), 1.0);
}
