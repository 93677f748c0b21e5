// import grid
// Bicubic Bézier patches at virtual vertices (Concheiro et al. 2013, Section 4 and Figure 3), with normals and with
// edges whose points are equal to the bit from both sides. The same as `rust/surface/src/bezier` computes.
//
// A patch is a record of 17 vectors: 16 control points (x, y, z, weight) row by row, then what is known of its edges,
// as whole numbers: two bits of sense for each edge, and its number.

/// Vectors of a record.
const RECORD: u32 = 17u;
/// Senses of edges.
const AGAINST: u32 = 1u;
const FOLDED: u32 = 2u;
const COLLAPSED: u32 = 3u;
/// By how much of the way to the middle a place is moved where the tangents vanish and no limit is known.
const NUDGE: f32 = 0.015625;
/// Squares of sines of angles between tangents below which they count as parallel.
const FLAT: f32 = 1e-8;

/// Whether control points have weights.
override RATIONAL: bool = false;

/// Where a virtual vertex is evaluated.
struct Place {
    /// Which control point is the first, and the steps to the next along the edge and inwards: the patch is seen from
    /// the edge the vertex is on, in the edge's one direction.
    frame: vec3<i32>,
    /// Parameters along the edge and inwards.
    at: vec2<f32>,
    /// The parameter at which the edge's curve has the point, or −1 inside.
    curve: f32,
    /// −1 if the frame is a mirror image.
    turn: f32,
    /// Whether the edge is a point.
    collapsed: bool,
}

/// A point of a patch and its unit normal, which is zero where it has no area.
struct Sample {
    p: vec3<f32>,
    normal: vec3<f32>,
}

fn cubic(t: f32) -> vec4<f32> {
    let s = 1.0 - t;
    return vec4<f32>(s * s * s, 3.0 * t * s * s, 3.0 * t * t * s, t * t * t);
}

/// The derivative at `t` of the curve with these control points, which is nothing but zero where they are equal.
fn slope(t: f32, a: vec4<f32>, b: vec4<f32>, c: vec4<f32>, d: vec4<f32>) -> vec4<f32> {
    let s = 1.0 - t;
    return 3.0 * (s * s * (b - a) + 2.0 * s * t * (c - b) + t * t * (d - c));
}

/// Which sample of its map a virtual vertex is along u and v.
fn sample_place(sample: u32) -> vec2<u32> {
    return vec2(sample & 0xfffu, (sample >> 12u) & 0xfffu);
}

/// The place of a virtual vertex, whose parameters are `uv`, on a patch with these edges. Its number is that of the sample
/// along u, times 2¹² along v, and times 2²⁴ the level of the map.
fn place_of(sample: u32, uv: vec2<f32>, edges: u32) -> Place {
    let n = (2u << ((sample >> 24u) & 15u)) - 1u;
    let i = sample_place(sample).x;
    let j = sample_place(sample).y;
    var place = Place(vec3<i32>(0, 1, 4), uv, -1.0, 1.0, false);
    let found = grid_edge(i, j, n);
    var edge = found.x;
    var k = found.y;
    if edge == GRID_INSIDE {
        return place;
    }
    // Where an edge begins the one before it ends: if that is a point, it has the limit of the normal.
    let before = (edge + 3u) % 4u;
    if k == 0u && ((edges >> (2u * before)) & 3u) == COLLAPSED {
        edge = before;
        k = n;
    }
    let sense = (edges >> (2u * edge)) & 3u;
    var number = k;
    var along = k;
    switch edge {
        case 0u: { place.frame = vec3<i32>(0, 1, 4); }
        case 1u: { place.frame = vec3<i32>(3, 4, -1); }
        case 2u: { place.frame = vec3<i32>(15, -1, -4); }
        default: { place.frame = vec3<i32>(12, -4, 1); }
    }
    if sense == AGAINST {
        place.frame = vec3<i32>(place.frame.x + 3 * place.frame.y, -place.frame.y, place.frame.z);
        place.turn = -1.0;
        number = n - k;
        along = number;
    } else if sense == FOLDED {
        number = min(k, n - k);
    } else if sense == COLLAPSED {
        number = 0u;
        place.collapsed = true;
    }
    place.curve = f32(number) / f32(n);
    place.at = vec2<f32>(f32(along) / f32(n), 0.0);
    return place;
}

/// The number of the control point `i` along the edge and `j` inwards.
fn control_number(frame: vec3<i32>, i: i32, j: i32) -> u32 {
    return u32(frame.x + frame.y * i + frame.z * j);
}

/// What a control point adds to sums: itself, or from `origin` on, weighted, and its weight.
fn form(control: vec4<f32>, origin: vec3<f32>) -> vec4<f32> {
    if RATIONAL {
        return vec4<f32>((control.xyz - origin) * control.w, control.w);
    }
    return vec4<f32>(control.xyz, 1.0);
}

fn combine(basis: vec4<f32>, a: vec4<f32>, b: vec4<f32>, c: vec4<f32>, d: vec4<f32>) -> vec4<f32> {
    return basis.x * a + basis.y * b + basis.z * c + basis.w * d;
}

/// A tangent from the derivative of the sums, where they are `sum`.
fn tangent(first: vec4<f32>, sum: vec4<f32>) -> vec3<f32> {
    if RATIONAL {
        return (first.xyz - sum.xyz / sum.w * first.w) / sum.w;
    }
    return first.xyz;
}

/// The unit vector across two tangents, zero where they vanish or are parallel.
fn across(a: vec3<f32>, b: vec3<f32>) -> vec3<f32> {
    // Tangents of any length: squares of their products need the room.
    let size = max(max(max(abs(a.x), abs(a.y)), abs(a.z)), max(max(abs(b.x), abs(b.y)), abs(b.z)));
    if size == 0.0 {
        return vec3<f32>(0.0);
    }
    let n = cross(a / size, b / size);
    let square = dot(n, n);
    if square <= FLAT * dot(a / size, a / size) * dot(b / size, b / size) || square == 0.0 {
        return vec3<f32>(0.0);
    }
    return n * inverseSqrt(square);
}

/// The sample at `place`, whose control points are those of its frame.
fn sample_of(c: array<vec4<f32>, 16>, place: Place) -> Sample {
    var origin = vec3<f32>(0.0);
    if RATIONAL {
        // Both ends of an edge are control points to the bit.
        origin = select(c[3].xyz, c[0].xyz, max(place.curve, place.at.x) < 0.5 || place.collapsed);
    }
    var f: array<vec4<f32>, 16>;
    for (var k = 0u; k < 16u; k++) {
        f[k] = form(c[k], origin);
    }
    let b = cubic(place.at.x);
    let t = place.at.x;
    let r0 = combine(b, f[0], f[1], f[2], f[3]);
    let r1 = combine(b, f[4], f[5], f[6], f[7]);
    let r2 = combine(b, f[8], f[9], f[10], f[11]);
    let r3 = combine(b, f[12], f[13], f[14], f[15]);
    let d0 = slope(t, f[0], f[1], f[2], f[3]);
    let d1 = slope(t, f[4], f[5], f[6], f[7]);
    let d2 = slope(t, f[8], f[9], f[10], f[11]);
    let d3 = slope(t, f[12], f[13], f[14], f[15]);
    let bs = cubic(place.at.y);
    let sum = combine(bs, r0, r1, r2, r3);
    let along = tangent(combine(bs, d0, d1, d2, d3), sum);
    let inwards = tangent(slope(place.at.y, r0, r1, r2, r3), sum);
    var sample: Sample;
    sample.normal = across(along, inwards);
    if place.collapsed {
        // The edge does not move along itself: the row behind it does.
        sample.normal = across(tangent(d1, r1), r1.xyz / r1.w - r0.xyz / r0.w);
    }
    var point = sum;
    if place.curve >= 0.0 {
        // Of the edge's own control points alone.
        point = combine(cubic(place.curve), f[0], f[1], f[2], f[3]);
    }
    if RATIONAL {
        sample.p = origin + point.xyz / point.w;
    } else {
        sample.p = point.xyz;
    }
    if dot(sample.normal, sample.normal) == 0.0 {
        let near = mix(place.at, vec2<f32>(0.5), NUDGE);
        let bt = cubic(near.x);
        let q0 = combine(bt, f[0], f[1], f[2], f[3]);
        let q1 = combine(bt, f[4], f[5], f[6], f[7]);
        let q2 = combine(bt, f[8], f[9], f[10], f[11]);
        let q3 = combine(bt, f[12], f[13], f[14], f[15]);
        let e0 = slope(near.x, f[0], f[1], f[2], f[3]);
        let e1 = slope(near.x, f[4], f[5], f[6], f[7]);
        let e2 = slope(near.x, f[8], f[9], f[10], f[11]);
        let e3 = slope(near.x, f[12], f[13], f[14], f[15]);
        let basis = cubic(near.y);
        let whole = combine(basis, q0, q1, q2, q3);
        let a = tangent(combine(basis, e0, e1, e2, e3), whole);
        let i = tangent(slope(near.y, q0, q1, q2, q3), whole);
        sample.normal = across(a, i);
    }
    sample.normal = sample.normal * place.turn;
    return sample;
}
