// import imprint_link
// import triangles
// Places of the values of triangles' blocks with the processor's roundings.

/// Segments of a side.
override SEGMENTS: u32 = 64u;
/// 1 where there are vectors.
override VECTORS: u32 = 0u;

// Barycentric coordinates of the values inside, three numbers each: a device's quotients may be others.
@group(0) @binding(8) var<storage, read> inside: array<f32>;
// First words of the vectors of triangles' blocks, in object space, and three words a value; something where no vectors exist.
@group(0) @binding(9) var<storage, read> way_entries: array<u32>;
@group(0) @binding(10) var<storage, read> way_values: array<u32>;

fn scaled(v: vec3<f32>, by: f32) -> vec3<f32> {
    return vec3(rounded(v.x * by), rounded(v.y * by), rounded(v.z * by));
}

// As `normalize_or_zero` of the processor.
fn unit(v: vec3<f32>) -> vec3<f32> {
    let square = rounded(v.x * v.x) + rounded(v.y * v.y) + rounded(v.z * v.z);
    if !(square > 0.0 && square < 3.4e38) {
        return vec3(0.0);
    }
    return scaled(v, 1.0 / sqrt(square));
}

// The undisplaced surface at value `index` of a triangle's block, with the processor's roundings.
fn exact_foot(face: u32, index: u32) -> Foot {
    let inner = inner_count(SEGMENTS);
    if index < inner {
        let a = mesh_foot(mesh_corner(face, 0u));
        let b = mesh_foot(mesh_corner(face, 1u));
        let c = mesh_foot(mesh_corner(face, 2u));
        let at = vec3(inside[3u * index], inside[3u * index + 1u], inside[3u * index + 2u]);
        let p = scaled(a.p, at.x) + scaled(b.p, at.y) + scaled(c.p, at.z);
        return Foot(p, unit(scaled(a.normal, at.x) + scaled(b.normal, at.y) + scaled(c.normal, at.z)));
    }
    let along = index - inner;
    if along >= 3u * (SEGMENTS - 1u) {
        return mesh_foot(mesh_corner(face, along - 3u * (SEGMENTS - 1u)));
    }
    let side = along / (SEGMENTS - 1u);
    let reversed = mesh_side(face, side) & 1u;
    let low = mesh_foot(mesh_corner(face, (side + reversed) % 3u));
    let high = mesh_foot(mesh_corner(face, (side + 1u - reversed) % 3u));
    let part = f32(along % (SEGMENTS - 1u) + 1u);
    let rest = f32(SEGMENTS) - part;
    // One by a power of two is exact.
    let share = 1.0 / f32(SEGMENTS);
    let p = (scaled(low.p, rest) + scaled(high.p, part)) * share;
    return Foot(p, unit((scaled(low.normal, rest) + scaled(high.normal, part)) * share));
}

/// How far vectors move value `index` of a triangle's block.
fn way_at(face: u32, index: u32) -> vec3<f32> {
    if VECTORS == 0u {
        return vec3(0.0);
    }
    let first = way_entries[face];
    if first == TRIANGLE_NONE {
        return vec3(0.0);
    }
    let at = first + 3u * index;
    return bitcast<vec3<f32>>(vec3(way_values[at], way_values[at + 1u], way_values[at + 2u]));
}
