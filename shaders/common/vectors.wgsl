// import tiles
// Vector displacement in tiles, after the scalar one, in the frame of the tangent by u, the direction across it and the
// normal. The same as `displaced` and `frame` of rust/tiles.

/// 1 where there are vectors.
override VECTORS: u32 = 0u;

// Components along the tangent, across it and along the normal, and their derivatives.
struct VectorsJet {
    d: vec3<f32>,
    du: vec3<f32>,
    dv: vec3<f32>,
}

@group(3) @binding(2) var<storage, read> vectors_entries: array<TileEntry>;
// Blocks of (size + 2)² texels of three half floats, row by row.
@group(3) @binding(3) var<storage, read> vectors_texels: array<u32>;

fn vectors_texel(first: u32, index: u32) -> vec3<f32> {
    var texel: vec3<f32>;
    for (var axis = 0u; axis < 3u; axis++) {
        let half = 3u * index + axis;
        let pair = unpack2x16float(vectors_texels[first + half / 2u]);
        texel[axis] = select(pair.x, pair.y, (half & 1u) == 1u);
    }
    return texel;
}

/// The spline of a block at a place of its tile.
fn vectors_jet(entry: TileEntry, uv: vec2<f32>) -> VectorsJet {
    let spline = tiles_spline(entry.size, uv);
    var jet: VectorsJet;
    for (var i = 0u; i < 3u; i++) {
        let index = spline.index + i;
        let low = vectors_texel(entry.first, index);
        let middle = vectors_texel(entry.first, index + spline.stride);
        let high = vectors_texel(entry.first, index + 2u * spline.stride);
        let value = mat3x3(low, middle, high) * spline.value_v;
        let slope = mat3x3(low, middle, high) * spline.slope_v;
        jet.d += spline.value_u[i] * value;
        jet.du += spline.slope_u[i] * value;
        jet.dv += spline.value_u[i] * slope;
    }
    return jet;
}

/// The displaced point and its normal; the normal is zero where the tangents of the surface are parallel.
fn vectors_displace(sample: SurfaceSample, scalar: TilesJet, jet: VectorsJet) -> Displaced {
    let u = sample.du;
    let v = sample.dv;
    let m = cross(u, v);
    let area = dot(m, m);
    let square = dot(u, u);
    var inverse = 0.0;
    var inverse_u = 0.0;
    if area > TILES_PARALLEL * square * dot(v, v) {
        inverse = 1.0 / sqrt(area);
        inverse_u = 1.0 / sqrt(square);
    }
    let n = m * inverse;
    let n_u = inverse * tiles_across(cross(sample.duu, v) + cross(u, sample.duv), n);
    let n_v = inverse * tiles_across(cross(sample.duv, v) + cross(u, sample.dvv), n);
    let t = u * inverse_u;
    let t_u = inverse_u * tiles_across(sample.duu, t);
    let t_v = inverse_u * tiles_across(sample.duv, t);
    let b = cross(n, t);
    let b_u = cross(n_u, t) + cross(n, t_u);
    let b_v = cross(n_v, t) + cross(n, t_v);
    let d = jet.d + vec3(0.0, 0.0, scalar.d);
    let d_u = jet.du + vec3(0.0, 0.0, scalar.du);
    let d_v = jet.dv + vec3(0.0, 0.0, scalar.dv);
    let p_u = u + mat3x3(t, b, n) * d_u + mat3x3(t_u, b_u, n_u) * d;
    let p_v = v + mat3x3(t, b, n) * d_v + mat3x3(t_v, b_v, n_v) * d;
    let facing = cross(p_u, p_v);
    let length = dot(facing, facing);
    var displaced: Displaced;
    displaced.p = sample.p + mat3x3(t, b, n) * d;
    displaced.normal = n;
    if length > TILES_PARALLEL * dot(p_u, p_u) * dot(p_v, p_v) && length < 3.0e38 {
        displaced.normal = facing / sqrt(length);
    }
    return displaced;
}

/// As `tiles_displaced`, and by vectors.
fn vectors_displaced(tile: u32, uv: vec2<f32>) -> Displaced {
    if VECTORS == 0u {
        return tiles_displaced(tile, uv);
    }
    let entry = vectors_entries[tile];
    let found = surface_find(tile, uv);
    if entry.first == TILES_NONE || found == SURFACE_NONE {
        return tiles_displaced(tile, uv);
    }
    let sample = surface_evaluate(found, uv);
    let scalar = tiles_jet(tile, uv);
    let jet = vectors_jet(entry, uv);
    var displaced = vectors_displace(sample, scalar, jet);
    for (var turn = 0u; turn < 2u && all(displaced.normal == vec3(0.0)); turn++) {
        let inner = uv + (vec2(0.5) - uv) * select(0.0625, 0.0009765625, turn == 0u);
        let near = surface_evaluate(surface_find(tile, inner), inner);
        let n = tiles_displace(near, TilesJet(0.0, 0.0, 0.0)).normal;
        if any(n != vec3(0.0)) {
            let t = normalize(near.du);
            displaced.p = sample.p + mat3x3(t, cross(n, t), n) * (jet.d + vec3(0.0, 0.0, scalar.d));
            displaced.normal = vectors_displace(near, tiles_jet(tile, inner), vectors_jet(entry, inner)).normal;
        }
    }
    if all(displaced.normal == vec3(0.0)) {
        displaced.normal = vec3(0.0, 0.0, 1.0);
    }
    return displaced;
}
