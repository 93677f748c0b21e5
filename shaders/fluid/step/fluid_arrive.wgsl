// import fluid_sums
// Takes the particles of a step to where they were predicted to be, but none farther than they may go.

@group(0) @binding(0) var<storage, read> sorted_places: array<vec4<f32>>;
@group(0) @binding(1) var<storage, read> sorted_velocities: array<vec4<f32>>;
@group(0) @binding(2) var<storage, read> sorted_tags: array<vec4<u32>>;
@group(0) @binding(3) var<storage, read> predicted: array<vec4<f32>>;
@group(0) @binding(4) var<storage, read> diagonals: array<vec2<f32>>;
/// Velocities after a collider was met, with 1.
@group(0) @binding(5) var<storage, read> held: array<vec4<f32>>;
@group(1) @binding(1) var<storage, read_write> places: array<vec4<f32>>;
/// With the pressures that are reported.
@group(1) @binding(2) var<storage, read_write> velocities: array<vec4<f32>>;
@group(1) @binding(3) var<storage, read_write> tags: array<vec4<u32>>;
/// The squares of the greatest speed and of the greatest change of a velocity.
@group(1) @binding(4) var<storage, read_write> greatest: vec2<f32>;

@compute @workgroup_size(GROUP)
fn arrive(id: Invocation) {
    let particle = linear_item(id);
    var own = vec4(0.0);
    if particle < fluid.count {
        let place = sorted_places[particle];
        var moved = predicted[particle].xyz - place.xyz;
        let far = length(moved);
        if far > fluid.farthest {
            moved *= fluid.farthest / far;
        }
        var velocity = moved / fluid.step;
        let change = velocity - sorted_velocities[particle].xyz;
        if fluid.spacing > 0.0 && held[particle].w > 0.0 {
            moved = predicted[particle].xyz - place.xyz;
            velocity = held[particle].xyz;
        }
        own = vec4(dot(velocity, velocity), 0.0, dot(change, change), 0.0);
        places[particle] = vec4(place.xyz + moved, place.w);
        velocities[particle] = vec4(velocity, predicted[particle].w * diagonals[particle].y);
        tags[particle] = sorted_tags[particle];
    }
    note_group(own, linear_group(id), id.local);
}

@compute @workgroup_size(GROUP)
fn conclude(@builtin(local_invocation_index) local: u32) {
    let all = joined_all(local);
    if local == 0u {
        greatest = all.xz;
    }
}
