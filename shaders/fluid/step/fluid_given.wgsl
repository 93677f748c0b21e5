// import fluid_forces
// What a step gave to the particles, as `exchange.rs`: by forces, and by walls with the pressures that moved the particles.

@group(0) @binding(0) var<storage, read> places: array<vec4<f32>>;
@group(0) @binding(1) var<storage, read> velocities: array<vec4<f32>>;
@group(0) @binding(2) var<storage, read> wall_places: array<vec4<f32>>;
@group(0) @binding(3) var<storage, read> wall_velocities: array<vec4<f32>>;
@group(0) @binding(4) var<storage, read> lists: array<u32>;
@group(0) @binding(5) var<storage, read> ends: array<vec2<u32>>;
@group(0) @binding(6) var<storage, read> predicted: array<vec4<f32>>;
@group(0) @binding(7) var<storage, read> forces: array<ForceRow>;
/// Velocities after a collider was met, with 1, and by how much they have changed.
@group(0) @binding(8) var<storage, read> held: array<vec4<f32>>;
@group(0) @binding(9) var<storage, read> changes: array<vec4<f32>>;
/// Of each workgroup what forces and what walls accelerate by, in m/s².
@group(1) @binding(0) var<storage, read_write> sums: array<array<vec4<f32>, 2>>;
/// The same of all.
@group(1) @binding(1) var<storage, read_write> given: array<vec4<f32>, 2>;

// As in `fluid_sums.wgsl`.
const ROW: u32 = 16u;

var<workgroup> passed: array<array<vec4<f32>, 2>, GROUP>;
var<workgroup> rows: array<array<vec4<f32>, 2>, ROW>;

fn sum_of_group(own: array<vec4<f32>, 2>, local: u32) -> array<vec4<f32>, 2> {
    passed[local] = own;
    workgroupBarrier();
    if local < ROW {
        var all = array(vec4(0.0), vec4(0.0));
        for (var k = 0u; k < ROW; k++) {
            all[0] += passed[local * ROW + k][0];
            all[1] += passed[local * ROW + k][1];
        }
        rows[local] = all;
    }
    workgroupBarrier();
    var all = array(vec4(0.0), vec4(0.0));
    for (var k = 0u; k < ROW; k++) {
        all[0] += rows[k][0];
        all[1] += rows[k][1];
    }
    return all;
}

@compute @workgroup_size(GROUP)
fn give(id: Invocation) {
    let particle = linear_item(id);
    var own = array(vec4(0.0), vec4(0.0));
    if particle < fluid.count {
        let place = places[particle].xyz;
        let velocity = velocities[particle].xyz;
        for (var k = 0u; k < fluid.forces; k++) {
            own[0] += vec4(acceleration_by(forces[k], place, velocity), 0.0);
        }
        let end = ends[particle];
        var back = vec3(0.0);
        var rub = vec3(0.0);
        for (var k = end.x; k < end.y; k++) {
            let other = lists[k * fluid.count + particle];
            let wall = wall_places[other];
            let apart = place - wall.xyz;
            let distance = length(apart);
            back += wall.w * wall_slope(distance) * apart;
            rub += wall.w * rest_of(distance) * (wall_velocities[other].xyz - velocity);
        }
        let rubbed = fluid.spiky * fluid.support / fluid.density * fluid.friction * rub;
        own[1] = vec4(rubbed - predicted[particle].w / (fluid.density * fluid.density) * back, 0.0);
        if fluid.spacing > 0.0 && held[particle].w > 0.0 {
            own[1] += changes[particle] / fluid.step;
        }
    }
    let all = sum_of_group(own, id.local);
    if id.local == 0u {
        sums[linear_group(id)] = all;
    }
}

@compute @workgroup_size(GROUP)
fn give_all(@builtin(local_invocation_index) local: u32) {
    var own = array(vec4(0.0), vec4(0.0));
    for (var k = local; k < (fluid.count + GROUP - 1u) / GROUP; k += GROUP) {
        own[0] += sums[k][0];
        own[1] += sums[k][1];
    }
    let all = sum_of_group(own, local);
    if local == 0u {
        given = all;
    }
}
