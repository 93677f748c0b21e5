// import tissue
// Motion of nodes, as `simulation.rs`: forces of elements in a fixed order, central differences, sets that are driven, and
// bodies that nodes do not enter, as `collider.rs`.

@group(0) @binding(0) var<storage, read> forces: array<vec4<f32>>;
/// Where the corners of each node begin in `list`, and at the end their number.
@group(0) @binding(1) var<storage, read> starts: array<u32>;
@group(0) @binding(2) var<storage, read> list: array<u32>;
/// Inverse masses by axis, 0 where a node is held or driven.
@group(0) @binding(3) var<storage, read> masses: array<vec4<f32>>;
/// At rest, in m.
@group(0) @binding(4) var<storage, read> rest: array<vec4<f32>>;
/// In N.
@group(0) @binding(5) var<storage, read> loads: array<vec4<f32>>;
/// One more than the set that drives each node along each axis.
@group(0) @binding(6) var<storage, read> driven: array<vec4<u32>>;
@group(0) @binding(7) var<storage, read> timeline: array<vec4<f32>>;
/// Radius, or −1 of a floor; friction.
@group(0) @binding(8) var<storage, read> bodies: array<vec4<f32>>;
@group(1) @binding(0) var<storage, read_write> displacements: array<vec4<f32>>;
@group(1) @binding(1) var<storage, read_write> velocities: array<vec4<f32>>;

/// A vector turned by a unit quaternion.
fn turned(q: vec4<f32>, v: vec3<f32>) -> vec3<f32> {
    let twice = 2.0 * cross(q.xyz, v);
    return v + q.w * twice + cross(q.xyz, twice);
}

fn turned_back(q: vec4<f32>, v: vec3<f32>) -> vec3<f32> {
    return turned(vec4(-q.xyz, q.w), v);
}

@compute @workgroup_size(GROUP)
fn move_nodes(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let node = linear_item(group, groups, local);
    if node >= call.nodes {
        return;
    }
    let mass = masses[node].xyz;
    let free = select(vec3(0.0), vec3(1.0), mass > vec3(0.0));
    var force = vec3(0.0);
    if call.loads != 0u {
        force = loads[node].xyz;
    }
    for (var at = starts[node]; at < starts[node + 1u]; at++) {
        force -= forces[list[at]].xyz;
    }
    var u = displacements[node].xyz;
    var v = (velocities[node].xyz * call.kept + (force * mass + call.gravity * free) * call.gained) * free;
    u += call.step * v;
    let sets = driven[node];
    let first = call.row + call.muscles;
    for (var axis = 0u; axis < 3u; axis++) {
        if sets[axis] != 0u {
            let to = timeline[first + sets[axis] - 1u][axis];
            v[axis] = (to - u[axis]) / call.step;
            u[axis] = to;
        }
    }
    if any(mass > vec3(0.0)) {
        for (var body = 0u; body < call.bodies; body++) {
            let at = first + call.drives + 4u * body;
            let rotation = timeline[at];
            let translation = timeline[at + 1u].xyz;
            let origin = rest[node].xyz + u;
            let own = turned_back(rotation, origin - translation);
            let shape = bodies[body];
            var distance = own.z;
            var normal = vec3(0.0, 0.0, 1.0);
            if shape.x > 0.0 {
                let far = length(own);
                distance = far - shape.x;
                if far > 0.0 {
                    normal = own / far;
                }
            }
            if distance >= 0.0 {
                continue;
            }
            let surface = own - normal * distance;
            normal = turned(rotation, normal);
            let moved = -distance * normal;
            // How fast the body moves there.
            let pace = (turned(rotation, surface) + translation
                - (turned(timeline[at + 2u], surface) + timeline[at + 3u].xyz)) / call.step;
            let relative = v - pace;
            let along = dot(relative, normal);
            let side = relative - normal * along;
            let rubbed = shape.y * max(-along, 0.0);
            let left = side * (1.0 - min(rubbed / max(length(side), 1e-30), 1.0));
            let after = pace + left + normal * max(along, 0.0);
            u = select(u, u + moved, mass > vec3(0.0));
            v = select(v, after, mass > vec3(0.0));
        }
    }
    displacements[node] = vec4(u, 0.0);
    velocities[node] = vec4(v, 0.0);
}
