// import imprint_place
// import tiles
// Where vectors bring places of tiles before anything is asked of them, with the processor's roundings (`Ground::vectors`
// and `Frames` of rust/detail). The weights of the spline are exact at coefficients, whatever the sizes of the tiles.

/// 1 where there are vectors.
override VECTORS: u32 = 0u;

// The vectors, laid out as in `vectors`; something where no vectors exist.
@group(2) @binding(2) var<storage, read> way_entries: array<TileEntry>;
@group(2) @binding(3) var<storage, read> way_texels: array<u32>;

// A place of the surface with its unit normal, zero where it is degenerate.
struct Foot {
    p: vec3<f32>,
    n: vec3<f32>,
}

fn foot_of(it: SurfaceSample) -> Foot {
    let du = it.du;
    let dv = it.dv;
    let across = vec3(
        rounded(du.y * dv.z) - rounded(du.z * dv.y),
        rounded(du.z * dv.x) - rounded(du.x * dv.z),
        rounded(du.x * dv.y) - rounded(du.y * dv.x),
    );
    let square = fma(across.x, across.x, fma(across.y, across.y, across.z * across.z));
    if !(square > 0.0) {
        return Foot(it.p, vec3(0.0));
    }
    return Foot(it.p, across * (1.0 / sqrt(square)));
}

fn way_texel(first: u32, index: u32) -> vec3<f32> {
    var texel: vec3<f32>;
    for (var axis = 0u; axis < 3u; axis++) {
        let half = 3u * index + axis;
        let pair = unpack2x16float(way_texels[first + half / 2u]);
        texel[axis] = select(pair.x, pair.y, (half & 1u) == 1u);
    }
    return texel;
}

fn way_combine(weights: vec3<f32>, c: mat3x3<f32>) -> vec3<f32> {
    return fma(vec3(weights.x), c[0], fma(vec3(weights.y), c[1], weights.z * c[2]));
}

/// How far vectors move a place of a tile, whose sample and foot without them are given.
fn way_at(tile: u32, uv: vec2<f32>, it: SurfaceSample, foot: Foot) -> vec3<f32> {
    if VECTORS == 0u {
        return vec3(0.0);
    }
    let entry = way_entries[tile];
    if entry.first == TILES_NONE || all(foot.n == vec3(0.0)) {
        return vec3(0.0);
    }
    let spline = tiles_spline(entry.size, uv);
    var columns: mat3x3<f32>;
    for (var i = 0u; i < 3u; i++) {
        let index = spline.index + i;
        let low = way_texel(entry.first, index);
        let middle = way_texel(entry.first, index + spline.stride);
        let high = way_texel(entry.first, index + 2u * spline.stride);
        columns[i] = way_combine(spline.value_v, mat3x3(low, middle, high));
    }
    let vector = way_combine(spline.value_u, columns);
    let n = foot.n;
    let t = it.du * (1.0 / sqrt(fma(it.du.x, it.du.x, fma(it.du.y, it.du.y, it.du.z * it.du.z))));
    let b = vec3(
        rounded(n.y * t.z) - rounded(n.z * t.y),
        rounded(n.z * t.x) - rounded(n.x * t.z),
        rounded(n.x * t.y) - rounded(n.y * t.x),
    );
    return fma(vec3(vector.x), t, fma(vec3(vector.y), b, vector.z * n));
}
