// import fluid_surface
// Particles into the order of the bricks they are in, and a list of these.

@group(0) @binding(0) var<storage, read> places: array<vec4<f32>>;
/// The complements of the least coordinates, the greatest, as numbers of the same order, how many bricks have particles, and the
/// most particles of one.
@group(1) @binding(0) var<storage, read_write> report: array<atomic<u32>, 8>;
@group(1) @binding(1) var<storage, read_write> keys: array<u32>;
@group(1) @binding(2) var<storage, read_write> order: array<u32>;
@group(1) @binding(3) var<storage, read_write> sorted: array<vec4<f32>>;
/// Whether a particle is the first of a brick, then how many before it are.
@group(1) @binding(4) var<storage, read_write> firsts: array<u32>;
@group(1) @binding(5) var<storage, read_write> cells: array<u32>;
@group(1) @binding(6) var<storage, read_write> starts: array<u32>;

/// A number that grows as a float does; values that are no numbers come first or last.
fn rising(value: f32) -> u32 {
    let bits = bitcast<u32>(value);
    return select(bits | 0x80000000u, ~bits, bits >= 0x80000000u);
}

@compute @workgroup_size(GROUP)
fn bound(id: Invocation) {
    var low = vec3(0u);
    var high = vec3(0u);
    for (var k = linear_item(id); k < surface.particles; k += id.groups.x * GROUP) {
        let place = places[k];
        let at = vec3(rising(place.x), rising(place.y), rising(place.z));
        low = max(low, ~at);
        high = max(high, at);
    }
    for (var axis = 0u; axis < 3u; axis++) {
        atomicMax(&report[axis], low[axis]);
        atomicMax(&report[axis + 3u], high[axis]);
    }
}

@compute @workgroup_size(GROUP)
fn number_particles(id: Invocation) {
    let particle = linear_item(id);
    if particle < surface.particles {
        keys[particle] = number_of(brick_of(places[particle].xyz));
        order[particle] = particle;
    }
}

fn is_first(particle: u32) -> bool {
    return particle == 0u || keys[particle - 1u] != keys[particle];
}

@compute @workgroup_size(GROUP)
fn arrange(id: Invocation) {
    let particle = linear_item(id);
    if particle < surface.particles {
        sorted[particle] = places[order[particle]];
        firsts[particle] = u32(is_first(particle));
    }
}

@compute @workgroup_size(GROUP)
fn note_cells(id: Invocation) {
    let particle = linear_item(id);
    if particle >= surface.particles {
        return;
    }
    let cell = firsts[particle];
    let is_new = is_first(particle);
    if is_new {
        cells[cell] = keys[particle];
        starts[cell] = particle;
    }
    if particle + 1u == surface.particles {
        let count = cell + u32(is_new);
        starts[count] = surface.particles;
        atomicStore(&report[6], count);
    }
}
