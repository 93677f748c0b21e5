// import imprint_solid
// Whether points are under the collider.

// A row of the map, with the processor's roundings.
fn along(row: vec4<f32>, d: vec3<f32>) -> f32 {
    return ((rounded(row.x * d.x) + rounded(row.y * d.y)) + rounded(row.z * d.z)) + row.w;
}

fn is_under(p: vec3<f32>) -> bool {
    let d = p - work.origin;
    let place = vec3(along(work.x, d), along(work.y, d), along(work.z, d));
    if !(all(place >= vec3(0.0)) && all(place < vec3<f32>(work.dims))) {
        return false;
    }
    let voxel = vec3<u32>(place);
    return is_solid(voxel.y * work.dims.x + voxel.x, i32(voxel.z));
}
