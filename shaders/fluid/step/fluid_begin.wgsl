// import fluid_forces
// The first pass of a step, as `prepare.rs`: densities, and the accelerations that need no pressure.

@group(0) @binding(0) var<storage, read> places: array<vec4<f32>>;
@group(0) @binding(1) var<storage, read> velocities: array<vec4<f32>>;
@group(0) @binding(2) var<storage, read> tags: array<vec4<u32>>;
@group(0) @binding(3) var<storage, read> wall_places: array<vec4<f32>>;
@group(0) @binding(4) var<storage, read> wall_velocities: array<vec4<f32>>;
@group(0) @binding(5) var<storage, read> lists: array<u32>;
@group(0) @binding(6) var<storage, read> ends: array<vec2<u32>>;
@group(0) @binding(7) var<storage, read> forces: array<ForceRow>;
/// Accelerations with densities.
@group(1) @binding(0) var<storage, read_write> accelerations: array<vec4<f32>>;
/// By which a density follows the particle's pressure, and what a pressure of 1 adds to the virial over the volume.
@group(1) @binding(1) var<storage, read_write> diagonals: array<vec2<f32>>;

@compute @workgroup_size(GROUP)
fn begin(id: Invocation) {
    let particle = linear_item(id);
    if particle >= fluid.count {
        return;
    }
    let own = places[particle].xyz;
    let velocity = velocities[particle].xyz;
    let end = ends[particle];
    var sum = 0.0;
    var squares = 0.0;
    var virial = 0.0;
    var gradient = vec3(0.0);
    var drag = vec3(0.0);
    var pull = vec3(0.0);
    var at = particle;
    for (var k = 0u; k < end.x; k++) {
        let other = lists[at];
        at += fluid.count;
        let apart = own - places[other].xyz;
        let distance = length(apart);
        let slope = pressure_slope(distance);
        let kernel = density_kernel(distance);
        sum += kernel;
        squares += slope * slope * distance * distance;
        virial += fluid.mass * slope * distance * distance;
        gradient += slope * apart;
        pull += kernel * apart;
        drag += rest_of(distance) * (velocities[other].xyz - velocity);
    }
    var beside = 0.0;
    var behind = vec3(0.0);
    var rub = vec3(0.0);
    for (var k = end.x; k < end.y; k++) {
        let other = lists[at];
        at += fluid.count;
        let wall = wall_places[other];
        let apart = own - wall.xyz;
        let distance = length(apart);
        beside += wall.w * wall_kernel(distance);
        let slope = wall_slope(distance);
        virial += 0.5 * wall.w * slope * distance * distance;
        behind += wall.w * slope * apart;
        rub += wall.w * rest_of(distance) * (wall_velocities[other].xyz - velocity);
    }
    let all = fluid.mass * gradient + behind;
    let diagonal = fluid.mass * fluid.mass * squares + dot(all, all);
    diagonals[particle] = vec2(diagonal, virial / (-3.0 * fluid.density));
    let rubbed = fluid.viscosity * fluid.mass * drag + fluid.friction * rub;
    let own_acceleration = fluid.spiky * fluid.support / fluid.density * rubbed
        - fluid.cohesion * fluid.mass * fluid.kernel * pull;
    let density = fluid.kernel * fluid.mass * (1.0 + sum) + fluid.wall * beside;
    let push = bitcast<vec3<f32>>(tags[particle].xyz);
    var pulled = own_acceleration + push + fluid.gravity;
    for (var k = 0u; k < fluid.forces; k++) {
        pulled += acceleration_by(forces[k], own, velocity);
    }
    accelerations[particle] = vec4(pulled, density);
}
