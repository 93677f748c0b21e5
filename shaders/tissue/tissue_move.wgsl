// import tissue
// Motion of nodes, as `simulation.rs`: forces of elements in a fixed order, central differences, sets that are driven,
// bodies that nodes do not enter, as `collider.rs`, and surfaces that nodes slide on, as `slide.rs`.

@group(0) @binding(0) var<storage, read> forces: array<vec4<f32>>;
/// Where the corners of each node begin in `list`, and at the end their number.
@group(0) @binding(1) var<storage, read> starts: array<u32>;
@group(0) @binding(2) var<storage, read> list: array<u32>;
/// Inverse masses by axis, 0 where a node is held or driven.
@group(0) @binding(3) var<storage, read> masses: array<vec4<f32>>;
/// At rest, in m; and the distance from the surface that the node slides on.
@group(0) @binding(4) var<storage, read> rest: array<vec4<f32>>;
/// In N.
@group(0) @binding(5) var<storage, read> loads: array<vec4<f32>>;
/// One more than the set that drives each node along each axis; and one more than where the boxes of the surface begin that
/// it slides on.
@group(0) @binding(6) var<storage, read> driven: array<vec4<u32>>;
@group(0) @binding(7) var<storage, read> timeline: array<vec4<f32>>;
/// Of each body: radius, −1 of a floor and 0 of a mesh, friction, and where the boxes of a mesh begin. Then the boxes and
/// triangles of meshes, as `DistanceField::pack` writes them. Floats are bits.
@group(0) @binding(8) var<storage, read> shapes: array<vec4<u32>>;
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

/// The point of a mesh that is closest to a place, the normal there, and the signed distance.
struct Closest {
    point: vec3<f32>,
    normal: vec3<f32>,
    distance: f32,
}

/// The closest point of a triangle, and where it is: 0 inside, 1 to 3 a corner, 4 to 6 an edge.
struct OnTriangle {
    point: vec3<f32>,
    feature: u32,
}

/// Boxes that wait while others are searched; a hierarchy is less than 32 deep.
const WAITING: u32 = 40u;

fn vector_at(row: u32) -> vec3<f32> {
    return bitcast<vec3<f32>>(shapes[row].xyz);
}

/// The squared distance of a place to a box.
fn reach(box: u32, place: vec3<f32>) -> f32 {
    let apart = clamp(place, vector_at(box), vector_at(box + 1u)) - place;
    return dot(apart, apart);
}

fn closest_on(a: vec3<f32>, b: vec3<f32>, c: vec3<f32>, place: vec3<f32>) -> OnTriangle {
    let ab = b - a;
    let ac = c - a;
    let ap = place - a;
    let d1 = dot(ab, ap);
    let d2 = dot(ac, ap);
    if d1 <= 0.0 && d2 <= 0.0 {
        return OnTriangle(a, 1u);
    }
    let bp = place - b;
    let d3 = dot(ab, bp);
    let d4 = dot(ac, bp);
    if d3 >= 0.0 && d4 <= d3 {
        return OnTriangle(b, 2u);
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        return OnTriangle(a + ab * (d1 / (d1 - d3)), 4u);
    }
    let cp = place - c;
    let d5 = dot(ab, cp);
    let d6 = dot(ac, cp);
    if d6 >= 0.0 && d5 <= d6 {
        return OnTriangle(c, 3u);
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        return OnTriangle(a + ac * (d2 / (d2 - d6)), 6u);
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0 {
        return OnTriangle(b + (c - b) * ((d4 - d3) / ((d4 - d3) + (d5 - d6))), 5u);
    }
    let scale = 1.0 / (va + vb + vc);
    return OnTriangle(a + ab * (vb * scale) + ac * (vc * scale), 0u);
}

/// The closest point of the mesh whose boxes begin at `root`, as `DistanceField::closest`.
fn closest(root: u32, place: vec3<f32>) -> Closest {
    var best = 3.0e38;
    var number = 0xffffffffu;
    var triangle = 0u;
    var on = OnTriangle(vec3(0.0), 0u);
    var waiting: array<u32, WAITING>;
    waiting[0] = root;
    var depth = 1u;
    while depth > 0u {
        depth--;
        let box = waiting[depth];
        if reach(box, place) > best {
            continue;
        }
        let first = shapes[box].w;
        let count = shapes[box + 1u].w;
        for (var leaf = 0u; leaf < count; leaf++) {
            let row = first + 10u * leaf;
            let found = closest_on(vector_at(row), vector_at(row + 1u), vector_at(row + 2u), place);
            let apart = found.point - place;
            let square = dot(apart, apart);
            let own = shapes[row].w;
            if square < best || (square == best && own < number) {
                best = square;
                number = own;
                triangle = row;
                on = found;
            }
        }
        if count == 0u && depth + 2u <= WAITING {
            let one = box + 2u;
            let is_first = reach(one, place) <= reach(first, place);
            waiting[depth] = select(one, first, is_first);
            waiting[depth + 1u] = select(first, one, is_first);
            depth += 2u;
        }
    }
    let normal = vector_at(triangle + 3u + on.feature);
    let distance = sqrt(best);
    return Closest(on.point, normal, select(distance, -distance, dot(normal, place - on.point) < 0.0));
}

@compute @workgroup_size(GROUP)
fn move_nodes(id: Invocation) {
    let node = linear_item(id);
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
            let shape = shapes[body];
            let radius = bitcast<f32>(shape.x);
            var distance = own.z;
            var normal = vec3(0.0, 0.0, 1.0);
            if radius > 0.0 {
                let far = length(own);
                distance = far - radius;
                if far > 0.0 {
                    normal = own / far;
                }
            } else if radius == 0.0 {
                if any(own < vector_at(shape.z)) || any(own > vector_at(shape.z + 1u)) {
                    continue;
                }
                let near = closest(shape.z, own);
                distance = near.distance;
                let out = near.point - own;
                let far = length(out);
                normal = near.normal;
                if far > 1e-30 {
                    normal = out / far;
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
            let rubbed = bitcast<f32>(shape.y) * max(-along, 0.0);
            let left = side * (1.0 - min(rubbed / max(length(side), 1e-30), 1.0));
            let after = pace + left + normal * max(along, 0.0);
            u = select(u, u + moved, mass > vec3(0.0));
            v = select(v, after, mass > vec3(0.0));
        }
    }
    if sets.w != 0u {
        let place = rest[node];
        let before = u;
        // Where the surface is curved one correction is not exact; the second is to rounding.
        for (var turn = 0u; turn < 2u; turn++) {
            let near = closest(sets.w - 1u, place.xyz + u);
            var along = near.normal;
            if abs(near.distance) > 1e-9 {
                along = (place.xyz + u - near.point) / near.distance;
            }
            u += along * (place.w - near.distance);
        }
        v += (u - before) / call.step;
    }
    displacements[node] = vec4(u, 0.0);
    velocities[node] = vec4(v, 0.0);
}
