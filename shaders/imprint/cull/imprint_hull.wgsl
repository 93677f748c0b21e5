// import common
// import halves
// import imprint_meet
// import imprint_tile
// import surface
// Bounds of displaced patches in the voxel coordinates of an imprint: hulls of Bézier points, widened by the displacement
// along cones of normals (Sederberg and Meyers 1988).

// What imprints of the submission left, see `Link`.
@group(0) @binding(1) var<storage, read> slots: array<u32>;
@group(2) @binding(0) var<storage, read> tiles: array<CullTile>;
// The unit axis and the cosine of the half angle of every patch's normals.
@group(2) @binding(1) var<storage, read> cones: array<vec4<f32>>;
// Of every tile the imprints whose grids its patches may meet, a bit each in two words, and whether there is one.
@group(2) @binding(2) var<storage, read_write> masks: array<atomic<u32>>;

const MASK_WORDS: u32 = 3u;

// Control points along a voxel axis; Bézier patches have four rows, the fifth again the last.
struct Points {
    rows: mat4x4<f32>,
    last: vec4<f32>,
}

fn four(at: u32) -> vec4<f32> {
    return surface_data[at / 4u];
}

fn points_along(it: SurfacePatch, row: vec4<f32>) -> Points {
    let at = it.first;
    let shift = vec3(surface_number(at), surface_number(at + 1u), surface_number(at + 2u)) - work.origin;
    let base = vec4(dot(row, vec4(shift, 1.0)));
    let count = select(16u, 20u, it.form == 1u);
    let x = at + SURFACE_ORIGIN;
    let y = x + count;
    let z = y + count;
    var all: Points;
    for (var k = 0u; k < 4u; k++) {
        all.rows[k] = base + row.x * four(x + 4u * k) + row.y * four(y + 4u * k) + row.z * four(z + 4u * k);
    }
    all.last = all.rows[3];
    if it.form == 1u {
        all.last = base + row.x * four(x + 16u) + row.y * four(y + 16u) + row.z * four(z + 16u);
    }
    return all;
}

// The least and the largest of some points.
fn ends(points: Points) -> vec2<f32> {
    let r = points.rows;
    let low = min(min(min(r[0], r[1]), min(r[2], r[3])), points.last);
    let high = max(max(max(r[0], r[1]), max(r[2], r[3])), points.last);
    return vec2(min(min(low.x, low.y), min(low.z, low.w)), max(max(high.x, high.y), max(high.z, high.w)));
}

// The least and the largest of row · N over unit normals in a cone.
fn span(cone: vec4<f32>, row: vec3<f32>) -> vec2<f32> {
    let size = length(row);
    if cone.w <= -1.0 || size == 0.0 {
        return vec2(-size, size);
    }
    let along = clamp(dot(cone.xyz, row) / size, -1.0, 1.0);
    let sine = sqrt(max(1.0 - cone.w * cone.w, 0.0));
    let across = sqrt(max(1.0 - along * along, 0.0));
    let most = select(along * cone.w + across * sine, 1.0, along >= cone.w);
    let least = select(along * cone.w - across * sine, -1.0, along <= -cone.w);
    return size * vec2(least, most);
}

// How far displacements reach along a voxel axis, and vectors, which reach as far in any direction.
fn spread(tile: CullTile, cone: vec4<f32>, row: vec3<f32>) -> vec2<f32> {
    if tile.least == 0.0 && tile.most == 0.0 && tile.length == 0.0 {
        return vec2(0.0);
    }
    let reach = span(cone, row);
    let corners = vec4(tile.least * reach, tile.most * reach);
    let least = min(min(corners.x, corners.y), min(corners.z, corners.w));
    let most = max(max(corners.x, corners.y), max(corners.z, corners.w));
    let around = tile.length * length(row);
    return vec2(least - around, most + around);
}

fn whole(tile: CullTile, patch_index: u32) -> Bounds {
    let it = surface_patches[patch_index];
    let cone = cones[patch_index];
    let x = ends(points_along(it, work.x)) + spread(tile, cone, work.x.xyz);
    let y = ends(points_along(it, work.y)) + spread(tile, cone, work.y.xyz);
    let z = ends(points_along(it, work.z)) + spread(tile, cone, work.z.xyz);
    return Bounds(vec3(x.x, y.x, z.x), vec3(x.y, y.y, z.y));
}

// A tile as imprints of earlier dispatches left it.
fn tile_before(index: u32) -> CullTile {
    var tile = tiles[index];
    let first = links[step.link];
    if (first.flags & WORKED) != 0u {
        let at = first.slots + index * first.stride;
        if is_block(slots[at + SLOT_BLOCK]) {
            tile.least = value(half_of(bitcast<i32>(slots[at + SLOT_LEAST])));
            tile.most = value(half_of(bitcast<i32>(slots[at + SLOT_MOST])));
        }
    } else if (first.flags & CHAINED) != 0u {
        let lowered = slots[first.slots + index * first.stride];
        if lowered > 0u {
            tile.least = min(tile.least, value(half_of(-i32(lowered))));
        }
        let raised = slots[first.slots + index * first.stride + first.stride - 1u];
        if raised > 0u {
            tile.most = max(tile.most, value(raised));
        }
    }
    return tile;
}

// How low the imprint that is worked on may leave a coefficient.
fn lowest(least: f32) -> f32 {
    return min(least, value(half_of(work.deepest)));
}
