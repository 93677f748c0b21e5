// import triangles
// What is read inside a triangle without a block: the fan that its corners and sides say, as `in_fans` of rust/tiles. Sides
// add what they read above what is linear between their ends.

// Values of a triangle's block that say what a place on a side reads: those at the ends of the side, from the lower vertex of
// the edge, and those next to the place; how far it is between these, and along the side.
struct Between {
    start: u32,
    end: u32,
    low: u32,
    high: u32,
    part: f32,
    along: f32,
}

/// The place of side `side` over a place inside with barycentric coordinates `at`.
fn side_below(face: u32, segments: u32, side: u32, at: vec3<f32>) -> Between {
    let a = at[side];
    let b = at[(side + 1u) % 3u];
    let reversed = mesh_side(face, side) & 1u;
    let along = select(b, a, reversed == 1u) / (a + b);
    let first = inner_count(segments) + side * (segments - 1u);
    let corners = inner_count(segments) + 3u * (segments - 1u);
    var it: Between;
    it.start = corners + (side + reversed) % 3u;
    it.end = corners + (side + 1u - reversed) % 3u;
    let x = clamp(along, 0.0, 1.0) * f32(segments);
    let step = min(u32(x), segments - 1u);
    it.low = select(first + step - 1u, it.start, step == 0u);
    it.high = select(first + step, it.end, step == segments - 1u);
    it.part = x - f32(step);
    it.along = along;
    return it;
}

/// What is read there above what is linear between the ends, of the values in the order of `Between`.
fn bulge(it: Between, values: vec4<f32>) -> f32 {
    let straight = values.x + (values.y - values.x) * it.along;
    return values.z + (values.w - values.z) * it.part - straight;
}
