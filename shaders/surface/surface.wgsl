// The patches of a surface, and their evaluation by (tile, u, v). The same as `find` and `evaluate` of rust/surface.

struct SurfacePatch {
    // Lower corner and size in the tile's parameters.
    low: vec2<f32>,
    size: vec2<f32>,
    // First number of its control data, a multiple of four: the origin and one that is not used, then all x, all y, all z.
    first: u32,
    // 0: 16 bicubic Bézier points, row by row in v. 1: 20 Gregory points.
    form: u32,
}

struct Place {
    tile: u32,
    u: f32,
    v: f32,
}

// P, its derivatives per unit of the tile's parameters.
struct SurfaceSample {
    p: vec3<f32>,
    du: vec3<f32>,
    dv: vec3<f32>,
    duu: vec3<f32>,
    duv: vec3<f32>,
    dvv: vec3<f32>,
}

@group(1) @binding(0) var<storage, read> surface_patches: array<SurfacePatch>;
// Leaves of the tiles' quadtrees in Morton order: key and first patch.
@group(1) @binding(1) var<storage, read> surface_leaves: array<vec2<u32>>;
// First patch and first leaf of every tile, and those after the last.
@group(1) @binding(2) var<storage, read> surface_tiles: array<vec2<u32>>;
@group(1) @binding(3) var<storage, read> surface_data: array<vec4<f32>>;

const SURFACE_NONE: u32 = 0xffffffffu;
const SURFACE_CELLS: u32 = 1024u;
// Numbers before the points of a patch.
const SURFACE_ORIGIN: u32 = 4u;

/// A number of control data.
fn surface_number(at: u32) -> f32 {
    return surface_data[at / 4u][at % 4u];
}

fn surface_spread(cell: u32) -> u32 {
    var bits = cell;
    bits = (bits | (bits << 8u)) & 0x00ff00ffu;
    bits = (bits | (bits << 4u)) & 0x0f0f0f0fu;
    bits = (bits | (bits << 2u)) & 0x33333333u;
    return (bits | (bits << 1u)) & 0x55555555u;
}

/// The patch at (u, v) of a tile; SURFACE_NONE in a hole, outside the unit square, and for a tile that is not there.
fn surface_find(tile: u32, uv: vec2<f32>) -> u32 {
    let inside = all(uv >= vec2(0.0)) && all(uv <= vec2(1.0));
    if !inside || tile >= arrayLength(&surface_tiles) - 1u {
        return SURFACE_NONE;
    }
    let start = surface_tiles[tile];
    let stop = surface_tiles[tile + 1u];
    if stop.x - start.x <= 1u {
        return select(SURFACE_NONE, start.x, stop.x > start.x);
    }
    let cell = min(vec2<u32>(uv * f32(SURFACE_CELLS)), vec2(SURFACE_CELLS - 1u));
    let key = surface_spread(cell.x) | (surface_spread(cell.y) << 1u);
    // The last leaf whose key is not above, of which there is one.
    var low = start.y;
    var high = stop.y;
    while high - low > 1u {
        let middle = (low + high) / 2u;
        if surface_leaves[middle].x <= key {
            low = middle;
        } else {
            high = middle;
        }
    }
    let first = surface_leaves[low].y;
    let end = select(surface_leaves[min(low + 1u, arrayLength(&surface_leaves) - 1u)].y, stop.x, low + 1u == stop.y);
    // A leaf's pieces ascend along one axis; the last one that starts at or before the place has it.
    for (var patch_index = end; patch_index > first + 1u; patch_index--) {
        if all(surface_patches[patch_index - 1u].low <= uv) {
            return patch_index - 1u;
        }
    }
    return first;
}

fn surface_cubic(t: f32) -> vec4<f32> {
    let s = 1.0 - t;
    return vec4(s * s * s, 3.0 * t * s * s, 3.0 * t * t * s, t * t * t);
}

fn surface_cubic_first(t: f32) -> vec4<f32> {
    let s = 1.0 - t;
    return vec4(-3.0 * s * s, 3.0 * s * (s - 2.0 * t), 3.0 * t * (2.0 * s - t), 3.0 * t * t);
}

fn surface_cubic_second(t: f32) -> vec4<f32> {
    let s = 1.0 - t;
    return vec4(6.0 * s, 6.0 * (t - 2.0 * s), 6.0 * (s - 2.0 * t), 6.0 * t);
}

fn surface_dot(weights: vec4<f32>, values: vec4<f32>) -> f32 {
    return fma(weights.x, values.x, fma(weights.y, values.y, fma(weights.z, values.z, weights.w * values.w)));
}

/// Dots of the weights with four rows.
fn surface_along(weights: vec4<f32>, rows: mat4x4<f32>) -> vec4<f32> {
    return vec4(
        surface_dot(weights, rows[0]),
        surface_dot(weights, rows[1]),
        surface_dot(weights, rows[2]),
        surface_dot(weights, rows[3]),
    );
}

fn surface_share(a: f32, b: f32) -> f32 {
    return select(0.0, a / (a + b), a + b > 0.0);
}

/// The rows of one axis, in Bézier form at (s, t), from four numbers at a time. Derivatives of a Gregory patch take its
/// blended points as fixed (Loop, Schaefer, Ni, Castaño 2009).
fn surface_rows(form: u32, first: u32, st: vec2<f32>) -> mat4x4<f32> {
    let a = surface_data[first];
    let b = surface_data[first + 1u];
    let c = surface_data[first + 2u];
    let d = surface_data[first + 3u];
    if form == 0u {
        return mat4x4(a, b, c, d);
    }
    let e = surface_data[first + 4u];
    let rest = vec2(1.0) - st;
    let shares = vec4(
        surface_share(st.x, st.y),
        surface_share(st.y, rest.x),
        surface_share(rest.y, st.x),
        surface_share(rest.x, rest.y),
    );
    let other = vec4(b.x, c.y, e.w, d.z);
    let inner = fma(shares, vec4(a.w, c.x, e.z, d.y) - other, other);
    return mat4x4(
        vec4(a.xy, b.w, b.y),
        vec4(a.z, inner.xy, b.z),
        vec4(e.x, inner.zw, d.x),
        vec4(d.w, e.y, c.w, c.z),
    );
}

fn surface_evaluate(patch_index: u32, uv: vec2<f32>) -> SurfaceSample {
    let it = surface_patches[patch_index];
    let scale = vec2(1.0) / it.size;
    let st = (uv - it.low) * scale;
    let b_s = surface_cubic(st.x);
    let b_t = surface_cubic(st.y);
    let d_s = surface_cubic_first(st.x);
    let d_t = surface_cubic_first(st.y);
    let dd_s = surface_cubic_second(st.x);
    let dd_t = surface_cubic_second(st.y);
    // In fours.
    let count = select(4u, 5u, it.form == 1u);
    let base = it.first / 4u;
    let origin = surface_data[base];
    var sample: SurfaceSample;
    for (var axis = 0u; axis < 3u; axis++) {
        let rows = surface_rows(it.form, base + 1u + axis * count, st);
        let curve = surface_along(b_s, rows);
        let slope = surface_along(d_s, rows);
        sample.p[axis] = origin[axis] + surface_dot(b_t, curve);
        sample.du[axis] = scale.x * surface_dot(b_t, slope);
        sample.dv[axis] = scale.y * surface_dot(d_t, curve);
        sample.duu[axis] = scale.x * scale.x * surface_dot(b_t, surface_along(dd_s, rows));
        sample.duv[axis] = scale.x * scale.y * surface_dot(d_t, slope);
        sample.dvv[axis] = scale.y * scale.y * surface_dot(dd_t, curve);
    }
    return sample;
}
