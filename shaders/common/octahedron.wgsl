// Unit vectors in 32 bits, as `Normal` of `rust/lod` has them.

/// A unit vector on an octahedron that is unfolded to a square, in two numbers of 16 bits from 1 on; 0 for none.
fn octahedral_normal(bits: u32) -> vec3<f32> {
    if bits == 0u {
        return vec3(0.0);
    }
    let square = (vec2<f32>(vec2(bits & 0xffffu, bits >> 16u)) - 32768.0) / 32767.0;
    let size = abs(square);
    let fold = max(size.x + size.y - 1.0, 0.0);
    let away = select(vec2(fold), vec2(-fold), square < vec2(0.0));
    return normalize(vec3(square - away, 1.0 - size.x - size.y));
}

/// The bits of a vector of any length.
fn octahedral_bits(vector: vec3<f32>) -> u32 {
    let sum = abs(vector.x) + abs(vector.y) + abs(vector.z);
    if sum <= 0.0 {
        return 0u;
    }
    let v = vector / sum;
    let sign = select(vec2(-1.0), vec2(1.0), v.xy >= vec2(0.0));
    let square = select((1.0 - abs(v.yx)) * sign, v.xy, v.z >= 0.0);
    let number = vec2<u32>(vec2<i32>(round(square * 32767.0)) + 32768);
    return number.x | number.y << 16u;
}
