// import fluid
// The greatest and the sum of what the invocations of a workgroup pass.

// Invocations of a row, and rows: two barriers in all, since they are dear where the device is the processor.
const ROW: u32 = 16u;

var<workgroup> passed: array<vec4<f32>, GROUP>;
var<workgroup> rows: array<vec4<f32>, ROW>;

/// Of the first and third numbers the greatest, of the second and fourth the sum; at invocation 0.
fn joined(a: vec4<f32>, b: vec4<f32>) -> vec4<f32> {
    return vec4(max(a.x, b.x), a.y + b.y, max(a.z, b.z), a.w + b.w);
}

fn joined_group(own: vec4<f32>, local: u32) -> vec4<f32> {
    passed[local] = own;
    workgroupBarrier();
    if local < ROW {
        var all = vec4(0.0);
        for (var k = 0u; k < ROW; k++) {
            all = joined(all, passed[local * ROW + k]);
        }
        rows[local] = all;
    }
    workgroupBarrier();
    var all = vec4(0.0);
    if local == 0u {
        for (var k = 0u; k < ROW; k++) {
            all = joined(all, rows[k]);
        }
    }
    return all;
}
