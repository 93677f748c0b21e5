// import tissue
// The forces of elements on their corners, as `element.rs` and `stress.rs`. A node adds them afterwards in a fixed order, so
// that a device gives the same bits in every run.

@group(0) @binding(0) var<storage, read> displacements: array<vec4<f32>>;
@group(0) @binding(1) var<storage, read> corners: array<u32>;
@group(0) @binding(2) var<storage, read> moduli: array<f32>;
/// Of elements that are no boxes: gradients, 24 each, and then hourglass patterns over 8, 32 each.
@group(0) @binding(3) var<storage, read> shapes: array<f32>;
/// Layers of fibres by block: directions, stiffnesses and strengths times volume, five numbers each.
@group(0) @binding(4) var<storage, read> layers: array<u32>;
@group(0) @binding(5) var<storage, read> fibres: array<f32>;
@group(0) @binding(6) var<storage, read> fibre_muscles: array<u32>;
/// What changes with time, row after row.
@group(0) @binding(7) var<storage, read> timeline: array<vec4<f32>>;
@group(1) @binding(0) var<storage, read_write> forces: array<vec4<f32>>;
/// One more than the largest slot of an element that is inside out.
@group(1) @binding(1) var<storage, read_write> broken: array<atomic<u32>>;

/// Stretch from rest at which a muscle no longer contracts.
const REACH: f32 = 0.5;

alias Eight = array<vec3<f32>, 8>;

/// The Walsh–Hadamard transform; twice gives the numbers eightfold.
fn transform(m: Eight) -> Eight {
    let a = array(
        m[0] + m[1], m[1] - m[0], m[2] + m[3], m[3] - m[2], m[4] + m[5], m[5] - m[4], m[6] + m[7], m[7] - m[6],
    );
    let b = array(
        a[0] + a[2], a[1] + a[3], a[2] - a[0], a[3] - a[1], a[4] + a[6], a[5] + a[7], a[6] - a[4], a[7] - a[5],
    );
    return array(
        b[0] + b[4], b[1] + b[5], b[2] + b[6], b[3] + b[7], b[4] - b[0], b[5] - b[1], b[6] - b[2], b[7] - b[3],
    );
}

/// Its inverse up to scale.
fn transform_back(m: Eight) -> Eight {
    let a = array(
        m[0] - m[1], m[0] + m[1], m[2] - m[3], m[2] + m[3], m[4] - m[5], m[4] + m[5], m[6] - m[7], m[6] + m[7],
    );
    let b = array(
        a[0] - a[2], a[1] - a[3], a[0] + a[2], a[1] + a[3], a[4] - a[6], a[5] - a[7], a[4] + a[6], a[5] + a[7],
    );
    return array(
        b[0] - b[4], b[1] - b[5], b[2] - b[6], b[3] - b[7], b[0] + b[4], b[1] + b[5], b[2] + b[6], b[3] + b[7],
    );
}

/// The displacement of a corner.
fn moved(slot: u32, corner: u32) -> vec3<f32> {
    return displacements[corners[place(slot, 8u, corner)]].xyz;
}

@compute @workgroup_size(GROUP)
fn press(id: Invocation) {
    let slot = linear_item(id);
    if slot >= call.elements {
        return;
    }
    // Gradient of the displacement: a column for each axis at rest. Hourglass modes.
    var h: mat3x3<f32>;
    var q: array<vec3<f32>, 4>;
    if call.boxes != 0u {
        // The corners in the order of binary numbers, x in bit 0.
        let modes = transform(array(
            moved(slot, 0u), moved(slot, 1u), moved(slot, 3u), moved(slot, 2u),
            moved(slot, 4u), moved(slot, 5u), moved(slot, 7u), moved(slot, 6u),
        ));
        h = mat3x3(modes[1] * call.scale_x, modes[2] * call.scale_y, modes[4] * call.scale_z);
        q = array(modes[3] * 0.125, modes[6] * 0.125, modes[5] * 0.125, modes[7] * 0.125);
    } else {
        for (var corner = 0u; corner < 8u; corner++) {
            let u = moved(slot, corner);
            let at = 3u * corner;
            h[0] += u * shapes[place(slot, 24u, at)];
            h[1] += u * shapes[place(slot, 24u, at + 1u)];
            h[2] += u * shapes[place(slot, 24u, at + 2u)];
            for (var mode = 0u; mode < 4u; mode++) {
                q[mode] += u * shapes[24u * call.slots + place(slot, 32u, 4u * corner + mode)];
            }
        }
    }
    var p = neo_hookean(h, slot);
    let block = slot / BLOCK;
    for (var layer = layers[block]; layer < layers[block + 1u]; layer++) {
        let own = slot % BLOCK;
        let at = layer * BLOCK * 5u;
        let direction = vec3(
            fibres[at + place(own, 5u, 0u)],
            fibres[at + place(own, 5u, 1u)],
            fibres[at + place(own, 5u, 2u)],
        );
        let muscle = fibre_muscles[layer * BLOCK + own];
        let contraction = fibres[at + place(own, 5u, 4u)] * timeline[call.row + muscle].x;
        p += fibre(h, direction, fibres[at + place(own, 5u, 3u)], contraction);
    }
    let stiffness = moduli[place(slot, 3u, 2u)];
    if call.boxes != 0u {
        let eighth = 0.125 * stiffness;
        let out = transform_back(array(
            vec3<f32>(0.0), p[0] * call.scale_x, p[1] * call.scale_y, q[0] * eighth,
            p[2] * call.scale_z, q[2] * eighth, q[1] * eighth, q[3] * eighth,
        ));
        let first = 8u * slot;
        forces[first] = vec4(out[0], 0.0);
        forces[first + 1u] = vec4(out[1], 0.0);
        forces[first + 2u] = vec4(out[3], 0.0);
        forces[first + 3u] = vec4(out[2], 0.0);
        forces[first + 4u] = vec4(out[4], 0.0);
        forces[first + 5u] = vec4(out[5], 0.0);
        forces[first + 6u] = vec4(out[7], 0.0);
        forces[first + 7u] = vec4(out[6], 0.0);
        return;
    }
    for (var corner = 0u; corner < 8u; corner++) {
        let at = 3u * corner;
        var force = p[0] * shapes[place(slot, 24u, at)];
        force += p[1] * shapes[place(slot, 24u, at + 1u)];
        force += p[2] * shapes[place(slot, 24u, at + 2u)];
        for (var mode = 0u; mode < 4u; mode++) {
            force += q[mode] * (stiffness * shapes[24u * call.slots + place(slot, 32u, 4u * corner + mode)]);
        }
        forces[8u * slot + corner] = vec4(force, 0.0);
    }
}

/// The first Piola–Kirchhoff stress times volume, from the gradient of the displacement itself: sums that begin with 1 would
/// lose the digits of small strains.
fn neo_hookean(h: mat3x3<f32>, slot: u32) -> mat3x3<f32> {
    let shear = moduli[place(slot, 3u, 0u)];
    let bulk = moduli[place(slot, 3u, 1u)];
    // The cofactors of H by columns, which are minors.
    let minors = mat3x3(cross(h[1], h[2]), cross(h[2], h[0]), cross(h[0], h[1]));
    let trace = h[0].x + h[1].y + h[2].z;
    let squares = dot(h[0], h[0]) + dot(h[1], h[1]) + dot(h[2], h[2]);
    let determinant = dot(h[0], minors[0]);
    let grown = trace + (minors[0].x + minors[1].y + minors[2].z + determinant);
    let volume = 1.0 + grown;
    // Also where it is no number.
    if !(volume > 0.0 && volume < 3e38) {
        atomicMax(&broken[0], slot + 1u);
    }
    // The cofactors of F = I + H without those of I: of H, and tr H I − Hᵀ.
    var cofactor = minors - transpose(h);
    cofactor[0].x += trace;
    cofactor[1].y += trace;
    cofactor[2].z += trace;
    let bounded = clamp(volume, 0.04, 12.0);
    var root = pow(bounded, -1.0 / 3.0);
    // To rounding, for powers of devices are not.
    root += root * (1.0 / 3.0) * (1.0 - bounded * (root * root * root));
    let square = root * root;
    let isochoric = shear * square;
    let excess = square * root * ((2.0 * trace + squares) * (1.0 / 3.0) - grown);
    let spherical = bulk * grown - isochoric * excess;
    var p = isochoric * (h - cofactor) + spherical * cofactor;
    p[0].x += spherical;
    p[1].y += spherical;
    p[2].z += spherical;
    return p;
}

/// The stress of fibres along a unit vector at rest, or 0.
fn fibre(h: mat3x3<f32>, direction: vec3<f32>, stiffness: f32, contraction: f32) -> mat3x3<f32> {
    let moved = h * direction;
    let over = dot(moved, 2.0 * direction + moved);
    let stretch = sqrt(max(1.0 + over, 1e-6));
    let off = (stretch - 1.0) / REACH;
    let tension = contraction * max(1.0 - off * off, 0.0) / stretch + 2.0 * stiffness * max(over, 0.0);
    let pull = tension * (direction + moved);
    return mat3x3(pull * direction.x, pull * direction.y, pull * direction.z);
}
