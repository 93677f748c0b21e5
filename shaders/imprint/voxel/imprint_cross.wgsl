// import imprint_facet
// The crossings of columns with triangles: every invocation looks at a chunk of columns of a row of one triangle and
// counts, at the first voxel whose centre is not below the triangle, by what the winding number changes, and notes how high
// the crossing is. Sums and extrema of whole numbers do not depend on the order they come in.

// Where the work of every triangle begins in that of its workgroup, and where that begins.
@group(0) @binding(3) var<storage, read> starts: array<u32>;
@group(0) @binding(6) var<storage, read> sums: array<u32>;
@group(0) @binding(4) var<storage, read> arguments: array<vec4<u32>>;
// Of step z of column c at z times the columns plus c; one step more than there are voxels. Where they are narrow, of
// steps 2z and, in the upper half, 2z + 1. Then of every column `NO_HEIGHT` less the height of the lowest crossing, and the
// same more than that of the highest.
@group(0) @binding(5) var<storage, read_write> turns: array<atomic<i32>>;

// How far the plane over a column is above the centre of the voxel below `step` in snapped units, times its area, by 96
// bits: A·dx + B·dy + (z − ½ − step)·area.
fn above(a: vec2<u32>, b: vec2<u32>, area: vec2<u32>, d: vec2<i32>, z: i32, step: i32) -> vec3<u32> {
    let flat = wider_add(wider_product(a, d.x), wider_product(b, d.y));
    return wider_add(flat, wider_product(area, z - HALF - SUB * step));
}

// Whether it is not above.
fn not_above(a: vec2<u32>, b: vec2<u32>, area: vec2<u32>, d: vec2<i32>, z: i32, step: i32) -> bool {
    let sum = above(a, b, area, d, z, step);
    return wider_negative(sum) || all(sum == vec3(0u));
}

// The place of a centre against a side: negative where it is left of it.
fn against(start: vec3<i32>, stop: vec3<i32>, center: vec2<i32>) -> vec2<u32> {
    return wide_cross(center.x - start.x, stop.y - start.y, center.y - start.y, stop.x - start.x);
}

@compute @workgroup_size(GROUP)
fn cross_columns(id: Invocation) {
    let item = linear_group(id) * GROUP + id.local;
    if item >= arguments[2u * step.link].x {
        return;
    }
    let base = sums[links[step.link].first_work / COUNTED];
    // The last imprint, of that the last workgroup, and of that the last triangle, that starts not after the item.
    var low = step.link;
    var high = step.link + step.count;
    while high - low > 1u {
        let middle = (low + high) / 2u;
        if sums[links[middle].first_work / COUNTED] - base <= item {
            low = middle;
        } else {
            high = middle;
        }
    }
    work = links[low];
    let first_sum = work.first_work / COUNTED;
    low = 0u;
    high = (work.triangles + COUNTED - 1u) / COUNTED;
    while high - low > 1u {
        let middle = (low + high) / 2u;
        if sums[first_sum + middle] - base <= item {
            low = middle;
        } else {
            high = middle;
        }
    }
    let in_group = item - (sums[first_sum + low] - base);
    low = low * COUNTED;
    high = min(low + COUNTED, work.triangles);
    while high - low > 1u {
        let middle = (low + high) / 2u;
        if starts[work.first_work + middle] <= in_group {
            low = middle;
        } else {
            high = middle;
        }
    }
    var f = facet(low);
    let in_row = chunks(f);
    let inner = in_group - starts[work.first_work + low];
    let row = clipped_rows(f).x + i32(inner / in_row);
    let first = f.columns.x + CHUNK * i32(inner % in_row);
    let end = min(first + CHUNK, f.columns.y);
    let center = vec2(first, row) * SUB + HALF;
    let long = against(f.a, f.c, center);
    let long_step = wide_product(f.c.y - f.a.y, SUB);
    var start = f.a;
    var stop = f.b;
    if row >= f.rows.y {
        start = f.b;
        stop = f.c;
    }
    let short = against(start, stop, center);
    let short_step = wide_product(stop.y - start.y, SUB);
    // From the left side on, before the right one.
    let mirrored = wide_negative(f.area);
    var left = select(long, short, mirrored);
    var right = select(short, long, mirrored);
    let left_step = select(long_step, short_step, mirrored);
    let right_step = select(short_step, long_step, mirrored);
    // The plane: its steps along x and y times the area, which is made positive.
    let up = f.b - f.a;
    let on = f.c - f.a;
    var a = wide_cross(up.z, on.y, on.z, up.y);
    var b = wide_cross(on.z, up.x, up.z, on.x);
    var area = f.area;
    if mirrored {
        a = wide_neg(a);
        b = wide_neg(b);
        area = wide_neg(area);
    }
    let slopes = vec2(wide_float(a), wide_float(b)) / wide_float(area);
    let dy = center.y - f.a.y;
    let range = vec2<f32>(f.range);
    let halves = select(0u, 1u, (work.flags & NARROW) != 0u);
    for (var column = first; column < end; column++) {
        if !wide_negative(left) && wide_negative(right) {
            let d = vec2(column * SUB + HALF - f.a.x, dy);
            // Floats say between which steps it is, whether or not products and sums are fused; integers say which.
            let parts = slopes * vec2<f32>(d);
            let place = (f32(f.a.z - HALF) + parts.x + parts.y) / 256.0;
            let size = f32(abs(f.a.z) + HALF) + abs(parts.x) + abs(parts.y);
            let margin = size * 7.450581e-9;
            let bounds = vec2<i32>(clamp(ceil(vec2(place - margin, place + margin)), range.xx, range.yy));
            var step = bounds.x;
            var most = bounds.y;
            while step < most {
                let middle = (step + most) / 2;
                if not_above(a, b, area, d, f.a.z, middle) {
                    most = middle;
                } else {
                    step = middle + 1;
                }
            }
            let layer = u32(step) >> halves;
            let at = work.first_turn + (layer * work.dims.y + u32(row)) * work.dims.x + u32(column);
            atomicAdd(&turns[at], f.turn << (16u * (u32(step) & halves)));
            let rest = wider_float(above(a, b, area, d, f.a.z, step)) / (256.0 * wide_float(area));
            let height = HEIGHT_UNITS * step + i32(floor(clamp(rest, -2.0, 1.0) * f32(HEIGHT_UNITS)));
            let top = ((work.dims.z >> halves) + 1u) * work.dims.y + u32(row);
            let noted = work.first_turn + top * work.dims.x + u32(column);
            atomicMax(&turns[noted], NO_HEIGHT - height);
            atomicMax(&turns[noted + work.dims.x * work.dims.y], NO_HEIGHT + height);
        }
        left = wide_add(left, left_step);
        right = wide_add(right, right_step);
    }
}
