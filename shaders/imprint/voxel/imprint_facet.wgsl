// import common
// import imprint_link
// import imprint_step
// import wide
// Triangles on the lattice of 1/256 voxel over the columns of a grid (Schäfer et al. 2014, Section 5, after Schwarz
// 2012). All that decides which voxels are solid is exact, so results are the processor's to the bit.

// Columns that an invocation looks at.
const CHUNK: i32 = 32;

// Corners of all imprints in snapped units, of at most 2²⁴; the fourth number is unused.
@group(0) @binding(1) var<storage, read> corners: array<vec4<i32>>;
@group(0) @binding(2) var<storage, read> triangles: array<u32>;

struct Facet {
    // From the lowest corner to the highest.
    a: vec3<i32>,
    b: vec3<i32>,
    c: vec3<i32>,
    // The rows of the corners, not clipped, and of its columns the first and the one after the last, clipped.
    rows: vec3<i32>,
    columns: vec2<i32>,
    // The steps of a column that it reaches, clipped.
    range: vec2<i32>,
    // Twice its area, signed.
    area: vec2<u32>,
    // What a column's winding number changes by: 1 where it enters, 0 if no column meets it or it does not matter.
    turn: i32,
}

fn facet(triangle: u32) -> Facet {
    var f: Facet;
    let first = work.first_index + 3u * triangle;
    f.a = corners[work.first_corner + triangles[first]].xyz;
    f.b = corners[work.first_corner + triangles[first + 1u]].xyz;
    f.c = corners[work.first_corner + triangles[first + 2u]].xyz;
    var odd = (work.flags & MIRRORED) != 0u;
    if f.b.y < f.a.y {
        let t = f.a;
        f.a = f.b;
        f.b = t;
        odd = !odd;
    }
    if f.c.y < f.b.y {
        let t = f.b;
        f.b = f.c;
        f.c = t;
        odd = !odd;
    }
    if f.b.y < f.a.y {
        let t = f.a;
        f.a = f.b;
        f.b = t;
        odd = !odd;
    }
    f.rows = vec3(step_of(f.a.y), step_of(f.b.y), step_of(f.c.y));
    let low = min(f.a, min(f.b, f.c));
    let high = max(f.a, max(f.b, f.c));
    f.columns = vec2(max(step_of(low.x), 0), min(step_of(high.x), i32(work.dims.x)));
    let nz = i32(work.dims.z);
    let steps = vec2(step_of(low.z), step_of(high.z));
    f.range = clamp(steps, vec2(0), vec2(nz));
    f.area = wide_cross(f.b.x - f.a.x, f.c.y - f.a.y, f.c.x - f.a.x, f.b.y - f.a.y);
    let backward = (work.flags & BACKWARD) != 0u;
    let matters = select((f.range.x < nz), (f.range.y > 0), backward);
    let met = f.rows.x < f.rows.z && f.rows.z > 0 && f.rows.x < i32(work.dims.y) && f.columns.x < f.columns.y;
    if matters && met && any(f.area != vec2(0u)) {
        // The solid is left, going up, where the normal's z is positive.
        f.turn = select(-1, 1, wide_negative(f.area) != odd);
    }
    return f;
}

// Of its rows the first and the one after the last, clipped.
fn clipped_rows(f: Facet) -> vec2<i32> {
    return clamp(f.rows.xz, vec2(0), vec2(i32(work.dims.y)));
}

fn chunks(f: Facet) -> u32 {
    return u32((f.columns.y - f.columns.x + CHUNK - 1) / CHUNK);
}
