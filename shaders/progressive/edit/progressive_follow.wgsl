// import progressive_fit
// import progressive_notes
// import progressive_stars
// How vertices follow those around them, at finer and coarser levels: the linear map that fits best, as
// `Surroundings` of rust/lod.

/// Depths of splits, one a dispatch.
struct FollowCall {
    first: u32,
    count: u32,
    /// How far a vertex has moved at least.
    least: f32,
    /// What coordinates are multiplied by so that squares of areas are numbers.
    scale: f32,
}

@group(0) @binding(3) var<storage, read> order: array<u32>;
var<immediate> work: FollowCall;

const RIGID: f32 = 5e-2;
const MIN_TURN: f32 = 1e-4;

/// Where in `stars` the nodes begin that are beside the first vertex of a split alone, beside both and beside the second
/// alone, and where they end, from which on the triangles at the first vertex are.
fn ring_of(split: u32) -> vec4<u32> {
    let start = starts[split];
    let first = start + HEAD;
    let both = first + star(start);
    let second = both + star(start + 1u);
    return vec4(first, both, second, second + star(start + 2u));
}

/// Those beside a vertex of the split.
fn beside(ring: vec4<u32>, side: u32) -> vec2<u32> {
    return select(ring.xz, ring.yw, side == 1u);
}

/// Of a vertex of a split, given where what is beside it is in `stars`, and where the one vertex was built and is.
fn surroundings(range: vec2<u32>, vertex: array<Place, 2>) -> Surroundings {
    var fit = fit_of(vertex);
    for (var k = range.x; k < range.y; k++) {
        meet(&fit, built(star(k) & NODE), now(star(k) & NODE));
    }
    find_middles(&fit);
    for (var k = range.x; k < range.y; k++) {
        weigh(&fit, built(star(k) & NODE).point, now(star(k) & NODE).point, 1.0);
    }
    return solved(&fit, RIGID);
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
