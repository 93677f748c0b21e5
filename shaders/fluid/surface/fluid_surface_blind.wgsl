// import fluid_surface_bricks
// What particles are for the surface, by the nearest of its vertices, as `blind.rs`.

@group(0) @binding(1) var<storage, read> places: array<vec4<f32>>;
@group(0) @binding(2) var<storage, read> order: array<u32>;
/// How many vertices those of the corners before have.
@group(0) @binding(3) var<storage, read> counts: array<u32>;
@group(0) @binding(4) var<storage, read> vertices: array<vec4<f32>>;
/// 0 of particles at the surface, 1 of blind ones, 2 of the rest, in the order in which they were given.
@group(1) @binding(0) var<storage, read_write> classes: array<u32>;

/// Whether a vertex within so many bricks is nearer than the root of a square.
fn is_near(place: vec3<f32>, reach: i32, square: f32) -> bool {
    let middle = brick_of(place);
    for (var z = -reach; z <= reach; z++) {
        for (var y = -reach; y <= reach; y++) {
            let begin = number_of(middle + vec3(-reach, y, z));
            let first = first_brick(begin);
            var last = first;
            while last < surface.bricks && bricks[last] - begin <= 2u * u32(reach) {
                last++;
            }
            let end = vertex_of(last);
            for (var at = vertex_of(first); at < end; at++) {
                let apart = vertices[at].xyz - place;
                if dot(apart, apart) <= square {
                    return true;
                }
            }
        }
    }
    return false;
}

/// The first vertex of a brick, or the end of all.
fn vertex_of(brick: u32) -> u32 {
    if brick < surface.bricks {
        return counts[brick * CORNERS];
    }
    return surface.vertices;
}

@compute @workgroup_size(GROUP)
fn classify(id: Invocation) {
    let particle = linear_item(id);
    if particle >= surface.particles {
        return;
    }
    let own = places[particle].xyz;
    var kind = 2u;
    if is_near(own, 1, surface.layer) {
        kind = 0u;
    } else if is_near(own, surface.reach, surface.farthest) {
        kind = 1u;
    }
    classes[order[particle]] = kind;
}
