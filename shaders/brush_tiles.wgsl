// import tiles
// import brush_edit
// A brush at places of tiles. The tiles of group 2 are those from when the stroke began: they say where places are.

@group(0) @binding(7) var<storage, read> brush_tiles: array<BrushTile>;
// The tiles that are edited as they were before the event.
@group(3) @binding(0) var<storage, read> entries: array<TileEntry>;
@group(3) @binding(1) var<storage, read> texels: array<u32>;

/// The brush at (u, v) of a tile, displaced by `height` along the normal; the share is 0 where there is no surface.
fn brush_at(tile: u32, uv: vec2<f32>, height: f32) -> BrushPlace {
    let patch_index = surface_find(tile, uv);
    if patch_index == SURFACE_NONE {
        return BrushPlace();
    }
    let sample = surface_evaluate(patch_index, uv);
    let across = cross(sample.du, sample.dv);
    let square = dot(across, across);
    return brush_over(sample.p, across * select(0.0, 1.0 / sqrt(square), square > 0.0), height);
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
