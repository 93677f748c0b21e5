// Affine maps by rows.

struct Affine {
    x: vec4<f32>,
    y: vec4<f32>,
    z: vec4<f32>,
}

fn affine_point(map: Affine, p: vec3<f32>) -> vec3<f32> {
    let at = vec4(p, 1.0);
    return vec3(dot(map.x, at), dot(map.y, at), dot(map.z, at));
}

/// A normal by the inverse transpose up to a factor above 0; cross products exist where the inverse does not.
fn affine_normal(map: Affine, normal: vec3<f32>) -> vec3<f32> {
    let x = vec3(map.x.x, map.y.x, map.z.x);
    let y = vec3(map.x.y, map.y.y, map.z.y);
    let z = vec3(map.x.z, map.y.z, map.z.z);
    let made = cross(y, z) * normal.x + cross(z, x) * normal.y + cross(x, y) * normal.z;
    return select(made, -made, dot(x, cross(y, z)) < 0.0);
}

fn affine_is_mirror(map: Affine) -> bool {
    return dot(map.x.xyz, cross(map.y.xyz, map.z.xyz)) < 0.0;
}
