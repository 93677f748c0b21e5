// import fluid
// Lists of the neighbours of particles, first of the fluid and then of walls. Those of a particle lie a row of all particles
// apart, so that invocations side by side read what lies side by side.

@group(0) @binding(0) var<storage, read> places: array<vec4<f32>>;
@group(0) @binding(1) var<storage, read> cells: array<vec2<u32>>;
@group(0) @binding(2) var<storage, read> wall_places: array<vec4<f32>>;
@group(0) @binding(3) var<storage, read> wall_cells: array<vec2<u32>>;
@group(1) @binding(0) var<storage, read_write> lists: array<u32>;
/// How many neighbours are of the fluid, and with those of walls.
@group(1) @binding(1) var<storage, read_write> ends: array<vec2<u32>>;
/// The first number is the most neighbours that a particle has, where that is more than there is room for.
@group(1) @binding(2) var<storage, read_write> report: array<atomic<u32>>;

@compute @workgroup_size(GROUP)
fn find(id: Invocation) {
    let particle = linear_item(id);
    if particle >= fluid.count {
        return;
    }
    let own = places[particle].xyz;
    let middle = cell_of(own);
    let square = fluid.support * fluid.support;
    var count = 0u;
    for (var k = 0; k < 27; k++) {
        let range = cells[number_of(middle + vec3(k % 3, k / 3 % 3, k / 9) - 1)];
        for (var other = range.x; other < range.y; other++) {
            let apart = places[other].xyz - own;
            if dot(apart, apart) < square && other != particle {
                if count < fluid.room {
                    lists[count * fluid.count + particle] = other;
                }
                count++;
            }
        }
    }
    let inner = count;
    if fluid.walls > 0u {
        for (var k = 0; k < 27; k++) {
            let range = wall_cells[number_of(middle + vec3(k % 3, k / 3 % 3, k / 9) - 1)];
            for (var other = range.x; other < range.y; other++) {
                let apart = wall_places[other].xyz - own;
                if dot(apart, apart) < square {
                    if count < fluid.room {
                        lists[count * fluid.count + particle] = other;
                    }
                    count++;
                }
            }
        }
    }
    ends[particle] = min(vec2(inner, count), vec2(fluid.room));
    if count > fluid.room {
        atomicMax(&report[0], count);
    }
}
