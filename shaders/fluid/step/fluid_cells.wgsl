// import fluid
// Particles into the order of their cells, and where those of a cell are.

@group(0) @binding(0) var<storage, read> places: array<vec4<f32>>;
@group(0) @binding(1) var<storage, read> velocities: array<vec4<f32>>;
/// What hosts accelerate a particle by, as bits, and its number.
@group(0) @binding(2) var<storage, read> tags: array<vec4<u32>>;
@group(1) @binding(0) var<storage, read_write> keys: array<u32>;
@group(1) @binding(1) var<storage, read_write> order: array<u32>;
@group(1) @binding(2) var<storage, read_write> sorted_places: array<vec4<f32>>;
@group(1) @binding(3) var<storage, read_write> sorted_velocities: array<vec4<f32>>;
@group(1) @binding(4) var<storage, read_write> sorted_tags: array<vec4<u32>>;
/// Of every cell its first particle and the one after its last.
@group(1) @binding(5) var<storage, read_write> cells: array<vec2<u32>>;

@compute @workgroup_size(GROUP)
fn number_cells(id: Invocation) {
    let particle = linear_item(id);
    if particle < fluid.count {
        keys[particle] = number_of(cell_of(places[particle].xyz));
        order[particle] = particle;
    }
}

@compute @workgroup_size(GROUP)
fn arrange(id: Invocation) {
    let particle = linear_item(id);
    if particle >= fluid.count {
        return;
    }
    let earlier = order[particle];
    sorted_places[particle] = places[earlier];
    sorted_velocities[particle] = velocities[earlier];
    sorted_tags[particle] = tags[earlier];
    let key = keys[particle];
    if particle == 0u || keys[particle - 1u] != key {
        cells[key].x = particle;
    }
    if particle + 1u == fluid.count || keys[particle + 1u] != key {
        cells[key].y = particle + 1u;
    }
}
