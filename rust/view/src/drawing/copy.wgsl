// A picture that is drawn once more, pixel by pixel.

@group(0) @binding(0) var picture: texture_2d<f32>;

// A triangle that covers the target.
@vertex
fn copy_corner(@builtin(vertex_index) corner: u32) -> @builtin(position) vec4<f32> {
    return vec4(f32(corner & 1u) * 4.0 - 1.0, f32(corner >> 1u) * 4.0 - 1.0, 0.0, 1.0);
}

@fragment
fn copy_color(@builtin(position) position: vec4<f32>) -> @location(0) vec4<f32> {
    return textureLoad(picture, vec2<u32>(position.xy), 0);
}
