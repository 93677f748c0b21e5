// Half floats as bits.

// Halves as whole numbers of the same order.
fn key(half: u32) -> i32 {
    return select(i32(half), -1 - i32(half & 0x7fffu), half >= 0x8000u);
}

fn half_of(key: i32) -> u32 {
    return select(u32(key), 0x8000u | u32(-1 - key), key < 0);
}

fn value(half: u32) -> f32 {
    let size = half & 0x7fffu;
    let normal = bitcast<f32>((size << 13u) + 0x38000000u);
    let magnitude = select(normal, f32(size) * 5.9604645e-8, size < 0x400u);
    return select(magnitude, -magnitude, half >= 0x8000u);
}
