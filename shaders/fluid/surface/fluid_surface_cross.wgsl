// import fluid_surface_bricks
// Vertices of the surface: places on the edges of cells between corners inside and outside, where a line between their values is 0.
// A brick has those of the edges that begin at its corners, and of the edges that end there where no brick is before it.

const NONE: u32 = 0xffffffffu;

@group(0) @binding(1) var<storage, read> values: array<f32>;
/// How many vertices a corner has, then how many those before it have.
@group(1) @binding(0) var<storage, read_write> counts: array<u32>;
@group(2) @binding(0) var<storage, read_write> vertices: array<vec4<f32>>;

/// The bricks after and before along the axes.
var<workgroup> beside: array<u32, 6>;

fn find_beside(number: u32, side: u32) -> u32 {
    let stride = strides()[side % 3u];
    let other = select(number - stride, number + stride, side < 3u);
    let found = first_brick(other);
    if found < surface.bricks && bricks[found] == other {
        return found;
    }
    return NONE;
}

/// The value beside a corner of a brick.
fn value_beside(brick: u32, corner: u32, axis: u32) -> f32 {
    let step = 1u << (2u * axis);
    if corner / step % SIDE + 1u < SIDE {
        return values[brick * CORNERS + corner + step];
    }
    let other = beside[axis];
    if other == NONE {
        return value_of(0.0, vec3(0.0));
    }
    return values[other * CORNERS + corner - (SIDE - 1u) * step];
}

/// Whether the edge along an axis that ends at a corner is this brick's.
fn has_before(corner: u32, axis: u32) -> bool {
    return (corner >> (2u * axis)) % SIDE == 0u && beside[axis + 3u] == NONE;
}

fn is_crossed(a: f32, b: f32) -> bool {
    return (a > 0.0) != (b > 0.0);
}

@compute @workgroup_size(CORNERS)
fn count_vertices(id: Invocation) {
    let brick = linear_group(id);
    if brick >= surface.bricks {
        return;
    }
    if id.local < 6u {
        beside[id.local] = find_beside(bricks[brick], id.local);
    }
    workgroupBarrier();
    let own = values[brick * CORNERS + id.local];
    var count = 0u;
    for (var axis = 0u; axis < 3u; axis++) {
        count += u32(is_crossed(own, value_beside(brick, id.local, axis)));
        count += u32(own > 0.0 && has_before(id.local, axis));
    }
    counts[brick * CORNERS + id.local] = count;
}

/// The vertex between a corner and the next one along an axis.
fn vertex(corner: vec3<i32>, axis: u32, here: f32, there: f32) -> vec4<f32> {
    var next = corner;
    next[axis] += 1;
    let begin = vec3<f32>(corner) * surface.cell;
    let to = vec3<f32>(next) * surface.cell;
    return vec4(begin + here / (here - there) * (to - begin), 0.0);
}

@compute @workgroup_size(CORNERS)
fn place_vertices(id: Invocation) {
    let brick = linear_group(id);
    if brick >= surface.bricks {
        return;
    }
    if id.local < 6u {
        beside[id.local] = find_beside(bricks[brick], id.local);
    }
    workgroupBarrier();
    let own = values[brick * CORNERS + id.local];
    let corner = corner_of(bricks[brick], id.local);
    let outside = value_of(0.0, vec3(0.0));
    var at = counts[brick * CORNERS + id.local];
    for (var axis = 0u; axis < 3u; axis++) {
        let after = value_beside(brick, id.local, axis);
        if is_crossed(own, after) {
            vertices[at] = vertex(corner, axis, own, after);
            at++;
        }
        if own > 0.0 && has_before(id.local, axis) {
            var before = corner;
            before[axis] -= 1;
            vertices[at] = vertex(before, axis, outside, own);
            at++;
        }
    }
}
