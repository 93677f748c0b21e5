// import fluid_sums
// Pressures by prediction and correction, as `pcisph.rs`.

/// As in `pcisph.rs`.
const RELAXATION: f32 = 0.5;
/// An excess of a particle that is nowhere.
const LOST: f32 = 3e38;

/// What is known of a step.
struct Report {
    /// The neighbours that a particle has, where there is no room for them; nothing is corrected then.
    crowd: u32,
    /// Corrections made, and 1 when they are enough.
    corrections: u32,
    is_enough: u32,
    /// The greatest and mean excess, as shares of the density at rest.
    most: f32,
    mean: f32,
    /// The same beyond what may be kept.
    over_most: f32,
    over_mean: f32,
}

@group(0) @binding(0) var<storage, read> accelerations: array<vec4<f32>>;
@group(0) @binding(1) var<storage, read> velocities: array<vec4<f32>>;
@group(0) @binding(2) var<storage, read> wall_places: array<vec4<f32>>;
@group(0) @binding(3) var<storage, read> wall_velocities: array<vec4<f32>>;
@group(0) @binding(4) var<storage, read> lists: array<u32>;
@group(0) @binding(5) var<storage, read> ends: array<vec2<u32>>;
@group(0) @binding(6) var<storage, read> diagonals: array<vec2<f32>>;
/// With pressures; those of what is predicted moved it.
@group(1) @binding(1) var<storage, read_write> places: array<vec4<f32>>;
@group(1) @binding(2) var<storage, read_write> predicted: array<vec4<f32>>;
@group(2) @binding(0) var<storage, read_write> report: Report;
/// Workgroups of the next correction, and of what follows the last.
@group(2) @binding(1) var<storage, read_write> arguments: array<u32, 6>;

fn is_lost(place: vec3<f32>) -> bool {
    let bits = bitcast<vec3<u32>>(place) & vec3(0x7f800000u);
    return any(bits == vec3(0x7f800000u));
}

/// Begins with a share of the pressures that there are.
@compute @workgroup_size(GROUP)
fn carry(id: Invocation) {
    let particle = linear_item(id);
    if particle < fluid.count {
        places[particle].w *= fluid.carried;
    }
    if particle == 0u {
        report.corrections = 0u;
        report.is_enough = 0u;
        arguments[0] = select(id.groups.x, 0u, report.crowd > 0u);
        arguments[1] = id.groups.y;
        arguments[2] = 1u;
        arguments[3] = 0u;
        arguments[4] = id.groups.y;
        arguments[5] = 1u;
    }
}

@compute @workgroup_size(GROUP)
fn predict(id: Invocation) {
    let particle = linear_item(id);
    if particle >= fluid.count {
        return;
    }
    let own = places[particle];
    let end = ends[particle];
    var push = vec3(0.0);
    var back = vec3(0.0);
    var at = particle;
    for (var k = 0u; k < end.x; k++) {
        let other = places[lists[at]];
        at += fluid.count;
        let apart = own.xyz - other.xyz;
        push += pressure_slope(length(apart)) * (own.w + other.w) * apart;
    }
    for (var k = end.x; k < end.y; k++) {
        let wall = wall_places[lists[at]];
        at += fluid.count;
        let apart = own.xyz - wall.xyz;
        back += wall.w * wall_slope(length(apart)) * apart;
    }
    let pressed = (fluid.mass * push + own.w * back) / -(fluid.density * fluid.density);
    let velocity = velocities[particle].xyz + fluid.step * (accelerations[particle].xyz + pressed);
    predicted[particle] = vec4(own.xyz + fluid.step * velocity, own.w);
}

@compute @workgroup_size(GROUP)
fn correct(id: Invocation) {
    let particle = linear_item(id);
    var own_sums = vec4(0.0);
    if particle < fluid.count {
        let own = predicted[particle].xyz;
        let end = ends[particle];
        var sum = 0.0;
        var beside = 0.0;
        var at = particle;
        for (var k = 0u; k < end.x; k++) {
            sum += density_kernel(distance(own, predicted[lists[at]].xyz));
            at += fluid.count;
        }
        for (var k = end.x; k < end.y; k++) {
            let other = lists[at];
            at += fluid.count;
            let wall = wall_places[other] + fluid.step * wall_velocities[other];
            beside += wall.w * wall_kernel(distance(own, wall.xyz));
        }
        let here = fluid.kernel * fluid.mass * (1.0 + sum) + fluid.wall * beside;
        let kept = fluid.allowed_share * max(accelerations[particle].w - fluid.begun_limit, 0.0);
        let over = here - fluid.density - kept;
        let stiffness = RELAXATION * (fluid.density / fluid.step) * (fluid.density / fluid.step);
        places[particle].w =
            max(places[particle].w + stiffness / max(diagonals[particle].x, fluid.diagonal) * over, 0.0);
        let shares = max(vec2(here - fluid.density, over) / fluid.density, vec2(0.0));
        own_sums = shares.xxyy;
        if is_lost(own) {
            own_sums = vec4(LOST, 0.0, LOST, 0.0);
        }
    }
    note_group(own_sums, linear_group(id), id.local);
}

/// Whether corrections are enough; the next ones have no workgroups then.
@compute @workgroup_size(GROUP)
fn judge(@builtin(local_invocation_index) local: u32) {
    let all = joined_all(local);
    if local != 0u || arguments[0] == 0u {
        return;
    }
    let made = report.corrections + 1u;
    report.corrections = made;
    report.most = all.x;
    report.mean = all.y / f32(fluid.count);
    report.over_most = all.z;
    report.over_mean = all.w / f32(fluid.count);
    let is_enough = report.over_most <= fluid.most && report.over_mean <= fluid.mean;
    report.is_enough = u32(is_enough);
    if is_enough && made >= fluid.least || made >= fluid.corrections {
        if is_enough {
            arguments[3] = arguments[0];
        }
        arguments[0] = 0u;
    }
}
