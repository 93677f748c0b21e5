// import common
// import wide
// The control data of all patches for the points of a cage.
//
// Devices have no f64. Coordinates and weights are therefore integers with 30 bits behind the point, sums have 64 bits and
// are exact, and the weights of a stencil sum to 1 exactly: a point of a patch is the same to the bit on every device,
// and a small patch keeps its shape because its points are rounded only after its origin was subtracted.

struct Pose {
    // Points of the cage, and points of all patches: those of the cage, then one per stencil.
    cage: u32,
    points: u32,
    patches: u32,
    // Coordinates times this have 30 bits; a power of two.
    scale: f32,
}

struct Source {
    // First of its point numbers in `indices`, and of its control data.
    points: u32,
    first: u32,
    // Bits 0 to 3: boundary edges. Bit 4: a Gregory patch. Bit 5: `across` holds for u, not for v.
    flags: u32,
    // The conversion across its crease; 0 is that of a smooth B-spline.
    across: u32,
}

@group(0) @binding(0) var<storage, read> cage: array<f32>;
// First weight of every stencil, and the one after the last.
@group(0) @binding(1) var<storage, read> stencils: array<u32>;
// Point of the cage and weight, which is signed.
@group(0) @binding(2) var<storage, read> weights: array<vec2<u32>>;
// x, y and z of every point, 64 bits each, the low word first.
@group(0) @binding(3) var<storage, read_write> points: array<vec2<u32>>;
@group(0) @binding(4) var<storage, read> sources: array<Source>;
@group(0) @binding(5) var<storage, read> indices: array<u32>;
// Rows are Bézier points as sums of four B-spline points.
@group(0) @binding(6) var<storage, read> conversions: array<mat4x4<f32>>;
@group(0) @binding(7) var<storage, read_write> data: array<f32>;
var<immediate> pose: Pose;

const BITS: u32 = 30u;

/// The number with only its leading 24 bits, which an f32 holds exactly.
fn leading(a: vec2<u32>) -> vec2<u32> {
    let negative = wide_negative(a);
    var size = a;
    if negative {
        size = wide_neg(a);
    }
    if size.y != 0u {
        let top = firstLeadingBit(size.y);
        if top >= 23u {
            size = vec2(0u, size.y & ~((1u << (top - 23u)) - 1u));
        } else {
            size.x &= ~((1u << (top + 9u)) - 1u);
        }
    } else if size.x >= 0x1000000u {
        size.x &= ~((1u << (firstLeadingBit(size.x) - 23u)) - 1u);
    }
    if negative {
        return wide_neg(size);
    }
    return size;
}

@compute @workgroup_size(GROUP)
fn make_points(id: Invocation) {
    let index = linear_group(id) * GROUP + id.local;
    if index >= pose.points {
        return;
    }
    var sum: array<vec2<u32>, 3>;
    if index < pose.cage {
        for (var axis = 0u; axis < 3u; axis++) {
            sum[axis] = wide_product(i32(round(cage[3u * index + axis] * pose.scale)), 1 << BITS);
        }
    } else {
        let stencil = index - pose.cage;
        for (var k = stencils[stencil]; k < stencils[stencil + 1u]; k++) {
            let term = weights[k];
            for (var axis = 0u; axis < 3u; axis++) {
                let value = i32(round(cage[3u * term.x + axis] * pose.scale));
                sum[axis] = wide_add(sum[axis], wide_product(value, bitcast<i32>(term.y)));
            }
        }
    }
    for (var axis = 0u; axis < 3u; axis++) {
        points[3u * index + axis] = sum[axis];
    }
}

fn converted(row: vec4<f32>, values: vec4<f32>) -> f32 {
    return fma(row.x, values.x, fma(row.y, values.y, fma(row.z, values.z, row.w * values.w)));
}

// One axis of one patch.
@compute @workgroup_size(GROUP)
fn make_patches(id: Invocation) {
    let index = linear_group(id) * GROUP + id.local;
    if index >= 3u * pose.patches {
        return;
    }
    let source = sources[index / 3u];
    let axis = index % 3u;
    let gregory = (source.flags & 16u) != 0u;
    // The origin is a control point, rounded to what an f32 holds.
    let middle = indices[source.points + select(5u, 0u, gregory)];
    let origin = leading(points[3u * middle + axis]);
    let unit = 1.0 / (pose.scale * f32(1u << BITS));
    data[source.first + axis] = wide_float(origin) * unit;
    let count = select(16u, 20u, gregory);
    // After the origin comes a number that is not used.
    let out = source.first + 4u + axis * count;
    let lower = wide_neg(origin);
    var values: array<f32, 20>;
    for (var k = 0u; k < count; k++) {
        values[k] = wide_float(wide_add(points[3u * indices[source.points + k] + axis], lower)) * unit;
    }
    if gregory {
        for (var k = 0u; k < 20u; k++) {
            data[out + k] = values[k];
        }
        return;
    }
    var rows: mat4x4<f32>;
    for (var k = 0u; k < 16u; k++) {
        rows[k / 4u][k % 4u] = values[k];
    }
    // Phantom points beyond boundary edges: 2·p₀ − p₁.
    if (source.flags & 1u) != 0u {
        rows[0] = 2.0 * rows[1] - rows[2];
    }
    if (source.flags & 4u) != 0u {
        rows[3] = 2.0 * rows[2] - rows[1];
    }
    for (var k = 0u; k < 4u; k++) {
        if (source.flags & 2u) != 0u {
            rows[k].w = 2.0 * rows[k].z - rows[k].y;
        }
        if (source.flags & 8u) != 0u {
            rows[k].x = 2.0 * rows[k].y - rows[k].z;
        }
    }
    let across_u = (source.flags & 32u) != 0u;
    let in_u = conversions[select(0u, source.across, across_u)];
    let in_v = conversions[select(source.across, 0u, across_u)];
    var half: mat4x4<f32>;
    for (var row = 0u; row < 4u; row++) {
        for (var k = 0u; k < 4u; k++) {
            half[row][k] = converted(in_u[k], rows[row]);
        }
    }
    for (var k = 0u; k < 4u; k++) {
        let column = vec4(half[0][k], half[1][k], half[2][k], half[3][k]);
        for (var row = 0u; row < 4u; row++) {
            data[out + 4u * row + k] = converted(in_v[row], column);
        }
    }
}
