// import imprint_link
// import surface
// Places of the surface with the processor's roundings.

// Bernstein polynomials at t.
fn cubic(t: f32) -> vec4<f32> {
    let s = 1.0 - t;
    return vec4(s * s * s, 3.0 * (s * s * t), 3.0 * (t * t * s), t * t * t);
}

// The control points of the curve in u at v, from the basis values there and the Bézier points from `first` on.
fn curve(basis: vec4<f32>, first: u32) -> vec4<f32> {
    var points: vec4<f32>;
    for (var k = 0u; k < 4u; k++) {
        let at = first + k;
        let low = fma(basis.y, surface_number(at + 4u), basis.x * surface_number(at));
        let high = fma(basis.w, surface_number(at + 12u), basis.z * surface_number(at + 8u));
        points[k] = low + high;
    }
    return points;
}

fn combined(basis: vec4<f32>, points: vec4<f32>) -> f32 {
    let sum = fma(basis.z, points.z, fma(basis.y, points.y, basis.x * points.x));
    return fma(basis.w, points.w, sum);
}

// P, du and dv of a regular patch with the processor's sums and products, one by one (`Surface::grid`): where rays graze
// an edge of voxels, the last bit decides. Others are evaluated as everywhere.
fn sample_patch(patch_index: u32, uv: vec2<f32>) -> SurfaceSample {
    let it = surface_patches[patch_index];
    if it.form != 0u {
        return surface_evaluate(patch_index, uv);
    }
    let scale = vec2(1.0) / it.size;
    let st = (uv - it.low) * scale;
    let along = cubic(st.x);
    let across = cubic(st.y);
    let s = vec2(1.0) - st;
    let ss = vec2(rounded(s.x * s.x), rounded(s.y * s.y));
    let mixed = vec2(rounded(s.x * st.x), rounded(s.y * st.y));
    let tt = vec2(rounded(st.x * st.x), rounded(st.y * st.y));
    let by = 3.0 * scale.y;
    let slopes = vec4(-ss.y, ss.y - 2.0 * mixed.y, 2.0 * mixed.y - tt.y, tt.y) * by;
    let quadratic = vec3(ss.x, mixed.x + mixed.x, tt.x);
    var sample: SurfaceSample;
    for (var axis = 0u; axis < 3u; axis++) {
        let first = it.first + SURFACE_ORIGIN + 16u * axis;
        let points = curve(across, first);
        sample.p[axis] = combined(along, points) + surface_number(it.first + axis);
        let steps = (3.0 * scale.x) * (points.yzw - points.xyz);
        sample.du[axis] = fma(quadratic.z, steps.z, fma(quadratic.y, steps.y, quadratic.x * steps.x));
        sample.dv[axis] = combined(along, curve(slopes, first));
    }
    return sample;
}
