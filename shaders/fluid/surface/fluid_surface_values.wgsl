// import fluid_surface_cells
// The values of a surface function at the corners of bricks, by looking at the particles around each.

@group(0) @binding(2) var<storage, read> places: array<vec4<f32>>;
@group(0) @binding(3) var<storage, read> bricks: array<u32>;
/// What the weights of particles are multiplied by.
@group(1) @binding(0) var<storage, read_write> amplitudes: array<f32>;
@group(1) @binding(1) var<storage, read_write> values: array<f32>;

var<workgroup> ranges: array<vec2<u32>, 9>;

/// Of a density 1 / Σ w, the particle's volume times the middle of its kernel.
@compute @workgroup_size(GROUP)
fn measure(id: Invocation) {
    let particle = linear_item(id);
    if particle >= surface.particles {
        return;
    }
    var sum = 1.0;
    if surface.profile == SPLINE {
        sum = 0.0;
        let own = places[particle].xyz;
        let number = number_of(brick_of(own));
        for (var row = 0u; row < 9u; row++) {
            let range = particles_of(number, row);
            for (var other = range.x; other < range.y; other++) {
                let apart = (places[other].xyz - own) / surface.support;
                sum += weight_of(dot(apart, apart));
            }
        }
    }
    amplitudes[particle] = 1.0 / sum;
}

@compute @workgroup_size(CORNERS)
fn evaluate(id: Invocation) {
    let brick = linear_group(id);
    if brick >= surface.bricks {
        return;
    }
    let number = bricks[brick];
    if id.local < 9u {
        ranges[id.local] = particles_of(number, id.local);
    }
    workgroupBarrier();
    let own = vec3<f32>(corner_of(number, id.local)) * surface.cell;
    var weight = 0.0;
    var moment = vec3(0.0);
    for (var row = 0u; row < 9u; row++) {
        let range = ranges[row];
        for (var other = range.x; other < range.y; other++) {
            let apart = places[other].xyz - own;
            let share = apart / surface.support;
            let part = amplitudes[other] * weight_of(dot(share, share));
            weight += part;
            moment += part * apart;
        }
    }
    values[brick * CORNERS + id.local] = value_of(weight, moment);
}
