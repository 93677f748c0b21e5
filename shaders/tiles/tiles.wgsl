// import surface
// Scalar displacement in tiles, and the surface displaced by it. The same as `spline` and `displaced` of rust/tiles.

struct TileEntry {
    // First word of its block, or TILES_NONE.
    first: u32,
    // Texels a side, without the ring.
    size: u32,
}

// Displacement and its derivatives per unit of the tile's parameters.
struct TilesJet {
    d: f32,
    du: f32,
    dv: f32,
}

struct Displaced {
    p: vec3<f32>,
    normal: vec3<f32>,
}

@group(2) @binding(0) var<storage, read> tiles_entries: array<TileEntry>;
// Blocks of (size + 2)² half floats, row by row, two a word.
@group(2) @binding(1) var<storage, read> tiles_texels: array<u32>;

const TILES_NONE: u32 = 0xffffffffu;
// The squared sine of the angle between tangents at and below which they count as parallel.
const TILES_PARALLEL: f32 = 1e-12;

fn tiles_texel(first: u32, index: u32) -> f32 {
    let pair = unpack2x16float(tiles_texels[first + index / 2u]);
    return select(pair.x, pair.y, (index & 1u) == 1u);
}

/// The biquadratic spline at a place of a tile.
struct TilesSpline {
    // The first of nine texels, and texels of a row.
    index: u32,
    stride: u32,
    // Weights of the columns and rows for values and for derivatives.
    value_u: vec3<f32>,
    value_v: vec3<f32>,
    slope_u: vec3<f32>,
    slope_v: vec3<f32>,
}

fn tiles_spline(size: u32, uv: vec2<f32>) -> TilesSpline {
    let n = f32(size);
    let x = uv * n;
    let cell = min(vec2<u32>(x), vec2(size - 1u));
    let f = x - vec2<f32>(cell);
    let a = 0.5 * (vec2(1.0) - f) * (vec2(1.0) - f);
    let c = 0.5 * f * f;
    let b = vec2(1.0) - a - c;
    var spline: TilesSpline;
    spline.stride = size + 2u;
    spline.index = cell.y * spline.stride + cell.x;
    spline.value_u = vec3(a.x, b.x, c.x);
    spline.value_v = vec3(a.y, b.y, c.y);
    spline.slope_u = n * vec3(f.x - 1.0, 1.0 - 2.0 * f.x, f.x);
    spline.slope_v = n * vec3(f.y - 1.0, 1.0 - 2.0 * f.y, f.y);
    return spline;
}

/// Three texels of a row from `index` on, which are in two words.
fn tiles_row(first: u32, index: u32) -> vec3<f32> {
    let low = unpack2x16float(tiles_texels[first + index / 2u]);
    let high = unpack2x16float(tiles_texels[first + index / 2u + 1u]);
    return select(vec3(low, high.x), vec3(low.y, high), (index & 1u) == 1u);
}

fn tiles_combine(weights: vec3<f32>, c: vec3<f32>) -> f32 {
    return fma(weights.x, c.x, fma(weights.y, c.y, weights.z * c.z));
}

/// The spline in the tile's own block; zeros where it has none.
fn tiles_jet(tile: u32, uv: vec2<f32>) -> TilesJet {
    let entry = tiles_entries[tile];
    var jet: TilesJet;
    if entry.first == TILES_NONE {
        return jet;
    }
    let spline = tiles_spline(entry.size, uv);
    // By columns, as the processor sums.
    let columns = transpose(mat3x3(
        tiles_row(entry.first, spline.index),
        tiles_row(entry.first, spline.index + spline.stride),
        tiles_row(entry.first, spline.index + 2u * spline.stride),
    ));
    var value: vec3<f32>;
    var slope: vec3<f32>;
    for (var i = 0u; i < 3u; i++) {
        value[i] = tiles_combine(spline.value_v, columns[i]);
        slope[i] = tiles_combine(spline.slope_v, columns[i]);
    }
    jet.d = tiles_combine(spline.value_u, value);
    jet.du = tiles_combine(spline.slope_u, value);
    jet.dv = tiles_combine(spline.value_u, slope);
    return jet;
}

/// The part of `a` across the unit vector `n`.
fn tiles_across(a: vec3<f32>, n: vec3<f32>) -> vec3<f32> {
    return a - n * dot(n, a);
}

/// The displaced point and its normal; the normal is zero where the tangents of the surface are parallel.
fn tiles_displace(sample: SurfaceSample, jet: TilesJet) -> Displaced {
    let u = sample.du;
    let v = sample.dv;
    let m = cross(u, v);
    let area = dot(m, m);
    var inverse = 0.0;
    if area > TILES_PARALLEL * dot(u, u) * dot(v, v) {
        inverse = 1.0 / sqrt(area);
    }
    let n = m * inverse;
    let n_u = inverse * tiles_across(cross(sample.duu, v) + cross(u, sample.duv), n);
    let n_v = inverse * tiles_across(cross(sample.duv, v) + cross(u, sample.dvv), n);
    let p_u = u + (n * jet.du + n_u * jet.d);
    let p_v = v + (n * jet.dv + n_v * jet.d);
    let facing = cross(p_u, p_v);
    let length = dot(facing, facing);
    var displaced: Displaced;
    displaced.p = fma(vec3(jet.d), n, sample.p);
    displaced.normal = n;
    // Neither parallel nor beyond what an f32 holds.
    if length > TILES_PARALLEL * dot(p_u, p_u) * dot(p_v, p_v) && length < 3.0e38 {
        displaced.normal = facing / sqrt(length);
    }
    return displaced;
}

/// The displaced surface at a place that is on it, in the very tile. Where the tangents are parallel, the directions are
/// those a little further inside; a hole has zeros.
fn tiles_displaced(tile: u32, uv: vec2<f32>) -> Displaced {
    let found = surface_find(tile, uv);
    var displaced: Displaced;
    if found == SURFACE_NONE {
        displaced.normal = vec3(0.0, 0.0, 1.0);
        return displaced;
    }
    let sample = surface_evaluate(found, uv);
    let jet = tiles_jet(tile, uv);
    displaced = tiles_displace(sample, jet);
    for (var turn = 0u; turn < 2u && all(displaced.normal == vec3(0.0)); turn++) {
        let inner = uv + (vec2(0.5) - uv) * select(0.0625, 0.0009765625, turn == 0u);
        let near = surface_evaluate(surface_find(tile, inner), inner);
        let still = tiles_displace(near, TilesJet(0.0, 0.0, 0.0));
        if any(still.normal != vec3(0.0)) {
            displaced.p = sample.p + jet.d * still.normal;
            displaced.normal = tiles_displace(near, tiles_jet(tile, inner)).normal;
        }
    }
    if all(displaced.normal == vec3(0.0)) {
        displaced.normal = vec3(0.0, 0.0, 1.0);
    }
    return displaced;
}
