// import vectors
// import brush_edit
// A brush at places of tiles. The tiles of group 2 are those from when the stroke began, as are the vectors: they say where
// places are.

@group(0) @binding(7) var<storage, read> brush_tiles: array<BrushTile>;
// The tiles that are edited as they were before the event.
@group(3) @binding(0) var<storage, read> entries: array<TileEntry>;
@group(3) @binding(1) var<storage, read> texels: array<u32>;

// A place of the surface with the frame of its vectors, which is absent if it is zeros.
struct FramedPlace {
    there: bool,
    p: vec3<f32>,
    t: vec3<f32>,
    b: vec3<f32>,
    n: vec3<f32>,
}

/// (u, v) of a tile, without displacement.
fn framed_at(tile: u32, uv: vec2<f32>) -> FramedPlace {
    let patch_index = surface_find(tile, uv);
    if patch_index == SURFACE_NONE {
        return FramedPlace();
    }
    let sample = surface_evaluate(patch_index, uv);
    let across = cross(sample.du, sample.dv);
    let square = dot(across, across);
    let n = across * select(0.0, 1.0 / sqrt(square), square > 0.0);
    let t = sample.du * select(0.0, 1.0 / sqrt(dot(sample.du, sample.du)), any(n != vec3(0.0)));
    return FramedPlace(true, sample.p, t, cross(n, t), n);
}

/// From components in the frame of a place to object space.
fn framed_out(at: FramedPlace, vector: vec3<f32>) -> vec3<f32> {
    return fma(vec3(vector.x), at.t, fma(vec3(vector.y), at.b, vector.z * at.n));
}

/// From object space to components in the frame of a place.
fn framed_in(at: FramedPlace, vector: vec3<f32>) -> vec3<f32> {
    return vec3(turned(vec4(at.t, 0.0), vector), turned(vec4(at.b, 0.0), vector), turned(vec4(at.n, 0.0), vector));
}

/// The brush at (u, v) of a tile, displaced by the vectors there and by `height` along the normal; the share is 0 where
/// there is no surface.
fn brush_at(tile: u32, uv: vec2<f32>, height: f32) -> BrushPlace {
    let at = framed_at(tile, uv);
    if !at.there {
        return BrushPlace();
    }
    var p = at.p;
    if VECTORS == 1u && vectors_entries[tile].first != TILES_NONE {
        p += framed_out(at, vectors_jet(vectors_entries[tile], uv).d);
    }
    return brush_over(p, at.n, height);
}

/// Notes that the texel in column `i` and row `j` of a block, its ring counted, changed.
fn note_corner(block: u32, size: u32, i: u32, j: u32) {
    if (j == 1u || j == size) && (i == 1u || i == size) {
        note_dab(block, BLOCK_CORNERS + select(select(3u, 2u, i == size), select(0u, 1u, i == size), j == 1u));
    }
}

/// The columns and rows of the two neighbours, by which the footprint of a texel is measured: in blocks of 16 × 16 the next
/// ones, of the last ones those before.
fn cells_beside(cell: vec2<u32>, size: u32) -> vec2<u32> {
    let edge = min(size, 16u);
    return select(cell - vec2(1u), cell + vec2(1u), cell % edge + vec2(1u) < vec2(edge));
}

/// How far the neighbours of a place are away across the brush.
fn tile_footprint(place: vec3<f32>, beside: vec3<f32>, over: vec3<f32>) -> f32 {
    return max(distance(place.xy, beside.xy), distance(place.xy, over.xy));
}
