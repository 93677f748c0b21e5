// import progressive_places
// How vertices follow those around them, at finer and coarser levels: the linear map that fits best, as
// `Surroundings` of rust/lod.

/// Depths of splits, one a dispatch.
struct Call {
    first: u32,
    count: u32,
    /// How far a vertex has moved at least.
    least: f32,
    /// What coordinates are multiplied by so that squares of areas are numbers.
    scale: f32,
}

@group(0) @binding(3) var<storage, read> order: array<u32>;
@group(0) @binding(4) var<storage, read> starts: array<u32>;
/// As `Stars` of rust/lod has them.
@group(0) @binding(5) var<storage, read> stars: array<u32>;
/// Of every node where it would have been built, if `moved` is 1.
@group(1) @binding(2) var<storage, read_write> notes: array<Place>;
var<immediate> work: Call;

const UPRIGHT: f32 = 0.5;
const RIGID: f32 = 5e-2;
const FLAT: f32 = 1e-2;
const LEAST_TURN: f32 = 1e-4;

/// Where in `stars` the nodes begin that are beside the first vertex of a split alone, beside both and beside the second
/// alone, and where they end, from which on the triangles at the first vertex are.
fn ring_of(split: u32) -> vec4<u32> {
    let start = starts[split];
    let first = start + HEAD;
    let both = first + stars[start];
    let second = both + stars[start + 1u];
    return vec4(first, both, second, second + stars[start + 2u]);
}

/// Those beside a vertex of the split.
fn beside(ring: vec4<u32>, side: u32) -> vec2<u32> {
    return select(ring.xz, ring.yw, side == 1u);
}

struct Surroundings {
    built: vec3<f32>,
    now: vec3<f32>,
    map: mat3x3<f32>,
}

fn outer(a: vec3<f32>, b: vec3<f32>) -> mat3x3<f32> {
    return mat3x3(a * b.x, a * b.y, a * b.z);
}

fn inverted(m: mat3x3<f32>) -> mat3x3<f32> {
    let x = cross(m[1], m[2]);
    let cofactors = transpose(mat3x3(x, cross(m[2], m[0]), cross(m[0], m[1])));
    return cofactors * (1.0 / dot(m[0], x));
}

fn unit_or(vector: vec3<f32>, otherwise: vec3<f32>) -> vec3<f32> {
    let square = dot(vector, vector);
    return select(otherwise, vector * inverseSqrt(max(square, 1e-37)), square > 1e-37);
}

/// The turn of a quaternion of any length.
fn turn_of(quaternion: vec4<f32>) -> mat3x3<f32> {
    let q = normalize(quaternion);
    let d = q.xyz + q.xyz;
    let xx = q.x * d.x;
    let yy = q.y * d.y;
    let zz = q.z * d.z;
    let xy = q.x * d.y;
    let xz = q.x * d.z;
    let yz = q.y * d.z;
    let w = q.w * d;
    return mat3x3(
        vec3(1.0 - yy - zz, xy + w.z, xz - w.y),
        vec3(xy - w.z, 1.0 - xx - zz, yz + w.x),
        vec3(xz + w.y, yz - w.x, 1.0 - xx - yy),
    );
}

/// The shortest turn from one unit vector to another.
fn arc(a: vec3<f32>, b: vec3<f32>) -> mat3x3<f32> {
    let cosine = 1.0 + dot(a, b);
    let away = unit_or(select(cross(a, vec3(1.0, 0.0, 0.0)), cross(a, vec3(0.0, 1.0, 0.0)), abs(a.x) > 0.7), vec3(1.0));
    return turn_of(select(vec4(cross(a, b), cosine), vec4(away, 0.0), cosine < 1e-6));
}

/// Of a vertex of a split, given where what is beside it is in `stars`, and where the one vertex was built and is.
fn surroundings(range: vec2<u32>, vertex: array<Place, 2>) -> Surroundings {
    var old = vec3(0.0);
    var fresh = vec3(0.0);
    var old_normal = 2.0 * vertex[0].normal;
    var new_normal = 2.0 * vertex[1].normal;
    var count = 2.0;
    for (var k = range.x; k < range.y; k++) {
        let was = built(stars[k] & NODE);
        let is = now(stars[k] & NODE);
        old += was.point - vertex[0].point;
        fresh += is.point - vertex[1].point;
        old_normal += was.normal;
        new_normal += is.normal;
        count += 1.0;
    }
    old = vertex[0].point + old / count;
    fresh = vertex[1].point + fresh / count;
    old_normal = unit_or(old_normal, vec3(0.0, 0.0, 1.0));
    new_normal = unit_or(new_normal, vec3(0.0, 0.0, 1.0));
    let upright = arc(old_normal, new_normal);
    var sine = 0.0;
    var cosine = 0.0;
    var squares = 0.0;
    var spread = mat3x3<f32>();
    // Σ after beforeᵀ, of which what the turn leaves is taken.
    var both = mat3x3<f32>();
    // The vertex counts twice, in place of what is before the first.
    for (var k = range.x; k <= range.y; k++) {
        var was = vertex[0].point;
        var is = vertex[1].point;
        var weight = 2.0;
        if k < range.y {
            was = built(stars[k] & NODE).point;
            is = now(stars[k] & NODE).point;
            weight = 1.0;
        }
        was -= old;
        is -= fresh;
        let turned = upright * was;
        let flat = turned - new_normal * dot(turned, new_normal);
        sine += weight * dot(new_normal, cross(flat, is));
        cosine += weight * dot(flat, is);
        squares += weight * dot(was, was);
        spread += weight * outer(was, was);
        both += weight * outer(is, was);
    }
    let half = 0.5 * atan2(sine, select(cosine, 1.0, sine == 0.0 && cosine == 0.0));
    let turn = turn_of(vec4(new_normal * sin(half), cos(half))) * upright;
    if squares == 0.0 {
        return Surroundings(old, fresh, turn);
    }
    let scale = 1.0 / squares;
    let left = (transpose(turn) * both - spread) * scale;
    let unit = mat3x3(vec3(1.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0), vec3(0.0, 0.0, 1.0));
    let fitted = spread * scale + outer(old_normal, old_normal) * UPRIGHT + unit * RIGID;
    let map = turn + turn * (left * inverted(fitted));
    if determinant(map) > FLAT {
        return Surroundings(old, fresh, map);
    }
    return Surroundings(old, fresh, turn);
}

/// Where a vertex is now that was built at `place`.
fn forward(s: Surroundings, place: Place) -> Place {
    let normal = transpose(inverted(s.map)) * place.normal;
    return Place(s.now + s.map * (place.point - s.built), 1u, unit_or(normal, vec3(0.0)));
}

/// Where a vertex would have been built that is at `place` now.
fn back(s: Surroundings, place: Place) -> Place {
    let normal = transpose(s.map) * place.normal;
    return Place(s.built + inverted(s.map) * (place.point - s.now), 1u, unit_or(normal, vec3(0.0)));
}
