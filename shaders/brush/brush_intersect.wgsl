// import common
// import surface
// import brush
// Which tiles the box of a brush may reach, and what is to be done with the memory of each (Schäfer et al. 2015, Sections
// 3 and 4): first the box of a tile, grown by its displacement, then those of its patches in the brush's coordinates.

// As `brush_bounds` makes them.
@group(0) @binding(0) var<storage, read> boxes: array<vec4<f32>>;
@group(0) @binding(1) var<storage, read> brush_tiles: array<BrushTile>;
// The block of every tile.
@group(0) @binding(2) var<storage, read> pointers: array<u32>;
@group(0) @binding(3) var<storage, read> states: array<u32>;
// The sets of every tile.
@group(0) @binding(4) var<storage, read_write> masks: array<u32>;
var<immediate> work: Intersect;

fn box_meets(low: vec3<f32>, high: vec3<f32>, reach: f32) -> bool {
    if low.x > high.x {
        return false;
    }
    let middle = 0.5 * low + 0.5 * high - work.origin;
    let half = 0.5 * high - 0.5 * low + ROUNDING * max(abs(low), abs(high));
    let rows = array<vec4<f32>, 3>(work.row_x, work.row_y, work.row_z);
    for (var axis = 0u; axis < 3u; axis++) {
        let row = rows[axis];
        let far = abs(dot(row, vec4(middle, 1.0)));
        if far > dot(abs(row.xyz), half) + reach * length(row.xyz) + 1.0 + SLACK {
            return false;
        }
    }
    return true;
}

fn patch_meets(patch_index: u32, reach: f32, rounding: vec3<f32>) -> bool {
    let it = surface_patches[patch_index];
    let count = select(16u, 20u, it.form == 1u);
    let shift = vec3(surface_number(it.first), surface_number(it.first + 1u), surface_number(it.first + 2u)) - work.origin;
    let x = it.first + SURFACE_ORIGIN;
    var low = vec3(3.0e38);
    var high = vec3(-3.0e38);
    for (var i = x; i < x + count; i++) {
        let p = vec4(shift + vec3(surface_number(i), surface_number(i + count), surface_number(i + 2u * count)), 1.0);
        let place = vec3(dot(work.row_x, p), dot(work.row_y, p), dot(work.row_z, p));
        low = min(low, place);
        high = max(high, place);
    }
    let sizes = vec3(length(work.row_x.xyz), length(work.row_y.xyz), length(work.row_z.xyz));
    let widths = vec3(
        dot(abs(work.row_x.xyz), rounding),
        dot(abs(work.row_y.xyz), rounding),
        dot(abs(work.row_z.xyz), rounding),
    );
    let limit = reach * sizes + widths + 1.0 + SLACK;
    return all(low <= limit) && all(high >= -limit);
}

fn meets(tile: u32) -> bool {
    let low = boxes[2u * tile].xyz;
    let high = boxes[2u * tile + 1u].xyz;
    let reach = brush_tiles[tile].reach;
    if !box_meets(low, high, reach) {
        return false;
    }
    let rounding = ROUNDING * max(abs(low), abs(high));
    for (var k = surface_tiles[tile].x; k < surface_tiles[tile + 1u].x; k++) {
        if patch_meets(k, reach, rounding) {
            return true;
        }
    }
    return false;
}

@compute @workgroup_size(GROUP)
fn intersect(id: Invocation) {
    let tile = linear_group(id) * GROUP + id.local;
    if tile >= work.tiles {
        return;
    }
    let block = pointers[tile];
    let unchanged = block != BLOCK_NONE && states[BLOCK_WORDS * block + BLOCK_CHANGES] == 0u;
    masks[tile] = sets_of(meets(tile), block != BLOCK_NONE, unchanged);
}
