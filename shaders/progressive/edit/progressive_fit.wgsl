// import progressive_places
// The linear map that fits best what is around a vertex, from where it was built to where it is, as `Surroundings` of
// rust/lod. Neighbours are met one after the other, first for the middles and then for how they lie about those.

const UPRIGHT: f32 = 0.5;
const FLAT: f32 = 1e-2;

struct Surroundings {
    built: vec3<f32>,
    now: vec3<f32>,
    map: mat3x3<f32>,
}

struct Fit {
    /// The vertex as it was built and as it is.
    vertex: array<Place, 2>,
    /// Middles as built and as they are, and average normals: sums, until all neighbours are met.
    built: vec3<f32>,
    now: vec3<f32>,
    built_normal: vec3<f32>,
    now_normal: vec3<f32>,
    count: f32,
    /// Takes one average normal to the other.
    upright: mat3x3<f32>,
    sine: f32,
    cosine: f32,
    squares: f32,
    spread: mat3x3<f32>,
    /// Σ after beforeᵀ, of which what the turn leaves is taken.
    both: mat3x3<f32>,
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

/// Of a vertex as it was built and as it is, which counts twice, before any neighbour is met.
fn fit_of(vertex: array<Place, 2>) -> Fit {
    var fit: Fit;
    fit.vertex = vertex;
    fit.built_normal = 2.0 * vertex[0].normal;
    fit.now_normal = 2.0 * vertex[1].normal;
    fit.count = 2.0;
    return fit;
}

/// Meets a neighbour.
fn meet(fit: ptr<function, Fit>, was: Place, is: Place) {
    (*fit).built += was.point - (*fit).vertex[0].point;
    (*fit).now += is.point - (*fit).vertex[1].point;
    (*fit).built_normal += was.normal;
    (*fit).now_normal += is.normal;
    (*fit).count += 1.0;
}

/// Finds middles and average normals when all have been met.
fn find_middles(fit: ptr<function, Fit>) {
    (*fit).built = (*fit).vertex[0].point + (*fit).built / (*fit).count;
    (*fit).now = (*fit).vertex[1].point + (*fit).now / (*fit).count;
    (*fit).built_normal = unit_or((*fit).built_normal, vec3(0.0, 0.0, 1.0));
    (*fit).now_normal = unit_or((*fit).now_normal, vec3(0.0, 0.0, 1.0));
    (*fit).upright = arc((*fit).built_normal, (*fit).now_normal);
}

/// Takes in how a neighbour lies about the middles.
fn weigh(fit: ptr<function, Fit>, built_point: vec3<f32>, now_point: vec3<f32>, weight: f32) {
    let was = built_point - (*fit).built;
    let is = now_point - (*fit).now;
    let normal = (*fit).now_normal;
    let turned = (*fit).upright * was;
    let flat = turned - normal * dot(turned, normal);
    (*fit).sine += weight * dot(normal, cross(flat, is));
    (*fit).cosine += weight * dot(flat, is);
    (*fit).squares += weight * dot(was, was);
    (*fit).spread += weight * outer(was, was);
    (*fit).both += weight * outer(is, was);
}

/// The map when all have been taken in, which wants to be a turn by `rigid`.
fn solved(fit: ptr<function, Fit>, rigid: f32) -> Surroundings {
    weigh(fit, (*fit).vertex[0].point, (*fit).vertex[1].point, 2.0);
    let sine = (*fit).sine;
    let cosine = (*fit).cosine;
    let half = 0.5 * atan2(sine, select(cosine, 1.0, sine == 0.0 && cosine == 0.0));
    let turn = turn_of(vec4((*fit).now_normal * sin(half), cos(half))) * (*fit).upright;
    if (*fit).squares == 0.0 {
        return Surroundings((*fit).built, (*fit).now, turn);
    }
    let scale = 1.0 / (*fit).squares;
    let left = (transpose(turn) * (*fit).both - (*fit).spread) * scale;
    let unit = mat3x3(vec3(1.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0), vec3(0.0, 0.0, 1.0));
    let normal = (*fit).built_normal;
    let fitted = (*fit).spread * scale + outer(normal, normal) * UPRIGHT + unit * rigid;
    let map = turn + turn * (left * inverted(fitted));
    if determinant(map) > FLAT {
        return Surroundings((*fit).built, (*fit).now, map);
    }
    return Surroundings((*fit).built, (*fit).now, turn);
}
