// import fluid
// The greatest and the sum of what invocations pass: first of each workgroup, and then of all.

/// Those of each workgroup.
@group(1) @binding(0) var<storage, read_write> sums: array<vec4<f32>>;

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

/// Notes what the invocations of a workgroup pass.
fn note_group(own: vec4<f32>, group: u32, local: u32) {
    let all = joined_group(own, local);
    if local == 0u {
        sums[group] = all;
    }
}

/// What all workgroups of a pass over particles have noted; at invocation 0 of the only workgroup.
fn joined_all(local: u32) -> vec4<f32> {
    var own = vec4(0.0);
    for (var k = local; k < (fluid.count + GROUP - 1u) / GROUP; k += GROUP) {
        own = joined(own, sums[k]);
    }
    return joined_group(own, local);
}
