// import common
// import crowd_agents
// The cut of a crowd on a device, as `rust/crowd/src/crowd.rs`, and its indexed draws, as `draws.rs`: every agent gets a bucket
// by its model and step; sorted by bucket and pose, agents are instances, and their numbers of draws are added up to where each
// writes. Agents that are impostors come after them.

struct Call {
    agents: u32,
    planes: u32,
    /// Buckets of all models; those of impostors and of agents out of view come after them.
    buckets: u32,
    /// Draws that there is room for.
    capacity: u32,
    /// GEOMORPH and IMPOSTORS.
    options: u32,
    /// Which agents: VISIBLE or all.
    which: u32,
}

struct Cluster {
    indices: u32,
    first_index: u32,
    made_by: u32,
    used_by: u32,
}

struct Group {
    low: vec3<f32>,
    high: vec3<f32>,
}

/// An agent in view.
struct Instance {
    /// The agent.
    agent: u32,
    /// The first of the matrices of its pose in those of all poses.
    first_matrix: u32,
    /// The first of the weights of its morph targets in those of all poses.
    first_weight: u32,
    /// The model.
    model: u32,
    /// From the model to the world, by rows.
    transform: array<vec4<f32>, 3>,
}

@group(1) @binding(0) var<storage, read> clusters: array<Cluster>;
@group(1) @binding(1) var<storage, read> model_groups: array<Group>;
/// The error of each step, as bits, then where the clusters of each begin, and their end, then the clusters.
@group(1) @binding(2) var<storage, read> ladders: array<u32>;
/// The first matrix and the first weight of the pose of each agent.
@group(1) @binding(3) var<storage, read> poses: array<vec2<u32>>;
/// The error of each group, and the errors that may be seen from which its vertices move, and from which it is coarse where they
/// do; then the same of agents with weights of their own.
@group(1) @binding(4) var<storage, read> limits: array<vec4<f32>>;
/// For each agent SEEN if it was in the last frame, and HIDDEN.
@group(1) @binding(5) var<storage, read> states: array<u32>;
@group(2) @binding(0) var<storage, read_write> keys: array<u32>;
@group(2) @binding(1) var<storage, read_write> values: array<u32>;
/// How many draws each agent in view begins, then where its draws begin.
@group(2) @binding(2) var<storage, read_write> starts: array<u32>;
/// Agents in view without impostors, draws, triangles of all instances, and impostors.
@group(2) @binding(3) var<storage, read_write> counts: array<atomic<u32>, 4>;
@group(2) @binding(4) var<storage, read_write> draws: array<u32>;
@group(2) @binding(5) var<storage, read_write> drawn: array<vec2<u32>>;
@group(2) @binding(6) var<storage, read_write> instances: array<Instance>;
/// How far the vertices of each draw are on their way, 0 to 1.
@group(2) @binding(7) var<storage, read_write> blends: array<f32>;
var<immediate> call: Call;

/// As in `crowd.rs`.
const DEEP: f32 = 0.25;
const SLACK: f32 = 1e-6;
/// Looks at the agents that no others hide; otherwise at all.
const VISIBLE: u32 = 2u;

/// Lists all agents with the first matrices of their poses, by which they are sorted before buckets; those with weights of their
/// own come first.
@compute @workgroup_size(GROUP)
fn enlist(id: Invocation) {
    let index = linear_item(id);
    if index < call.agents {
        keys[index] = 2u * poses[index].x + u32(agents[index].own == NONE);
        values[index] = index;
    }
}

fn is_chosen(agent: u32) -> bool {
    return call.which != VISIBLE || (states[agent] & HIDDEN) == 0u;
}

/// Gives every agent its bucket.
@compute @workgroup_size(GROUP)
fn choose(id: Invocation) {
    let at = linear_item(id);
    if at >= call.agents {
        return;
    }
    let index = values[at];
    keys[at] = call.buckets + 1u;
    if !is_chosen(index) || is_out(index, call.planes) {
        return;
    }
    let near = near_of(index);
    if is_quad(index, near, call.options) {
        keys[at] = call.buckets;
        return;
    }
    let model = model_of(index);
    let is_near = 2.0 * agents[index].radius > DEEP * near;
    if (call.options & GEOMORPH) != 0u || agents[index].own != NONE || is_near {
        keys[at] = model.first_bucket + model.steps;
        return;
    }
    let allowed = view[0].w * (near * agents[index].inverse[0].w);
    // The first step whose error is larger; an error of 0 is always allowed.
    var low = 1u;
    var high = model.steps;
    while low < high {
        let middle = (low + high) / 2u;
        if bitcast<f32>(ladders[model.first_step + middle]) <= allowed {
            low = middle + 1u;
        } else {
            high = middle;
        }
    }
    keys[at] = model.first_bucket + low - 1u;
}

/// The place of the first key from `start` on that is at least `key`.
fn first_of(key: u32, start: u32) -> u32 {
    var low = start;
    var high = call.agents;
    while low < high {
        let middle = (low + high) / 2u;
        if keys[middle] < key {
            low = middle + 1u;
        } else {
            high = middle;
        }
    }
    return low;
}

/// Finds how many agents are in view, which come first, and how many impostors there are, which come next.
@compute @workgroup_size(1)
fn count_seen() {
    let seen = first_of(call.buckets, 0u);
    atomicStore(&counts[0], seen);
    atomicStore(&counts[3], first_of(call.buckets + 1u, seen) - seen);
}

/// The eye in the space of the model of an agent, and the error that may be seen at a distance of 1 there.
fn eye_of(agent: u32) -> vec4<f32> {
    let x = view[0].x - agents[agent].transform[0].w;
    let y = view[0].y - agents[agent].transform[1].w;
    let z = view[0].z - agents[agent].transform[2].w;
    var eye = vec4(0.0, 0.0, 0.0, view[0].w * agents[agent].inverse[1].w);
    for (var axis = 0u; axis < 3u; axis++) {
        let row = agents[agent].inverse[axis];
        eye[axis] = row.x * x + row.y * y + row.z * z;
    }
    return eye;
}

/// The error that may be seen of a group of an agent, in units of its model.
fn allowed_of(group: u32, agent: u32, eye: vec4<f32>) -> f32 {
    let beyond = max(max(model_groups[group].low - eye.xyz, eye.xyz - model_groups[group].high), vec3(0.0));
    let distance = sqrt(beyond.x * beyond.x + beyond.y * beyond.y + beyond.z * beyond.z);
    return eye.w * max(distance - agents[agent].moved, 0.0);
}

/// The limits of a group of an agent, which is given by its number in its model.
fn limits_of(number: u32, model: Model, agent: u32) -> vec4<f32> {
    let own = agents[agent].own;
    return limits[number + select(own, model.first_group, own == NONE)];
}

fn is_coarse(number: u32, model: Model, agent: u32, eye: vec4<f32>) -> bool {
    let found = limits_of(number, model, agent);
    let error = select(found.x, found.z, (call.options & GEOMORPH) != 0u);
    return error <= allowed_of(model.first_group + number, agent, eye);
}

/// How far the vertices of a cluster are on their way, 0 to 1.
fn blend_of(cluster: u32, model: Model, agent: u32, eye: vec4<f32>) -> f32 {
    let number = clusters[model.first_cluster + cluster].used_by;
    if (call.options & GEOMORPH) == 0u || number == NONE {
        return 0.0;
    }
    let found = limits_of(number, model, agent);
    let allowed = allowed_of(model.first_group + number, agent, eye);
    return select(0.0, clamp((allowed - found.y) / (found.z - found.y), 0.0, 1.0), allowed > found.y);
}

/// Whether a group of the model of an agent reaches to the inner side of all planes.
fn is_seen(group: u32, agent: u32) -> bool {
    let rows = agents[agent].transform;
    let low = model_groups[group].low;
    let high = model_groups[group].high;
    for (var at = 1u; at <= call.planes; at++) {
        let plane = view[at];
        let normal = plane.x * rows[0].xyz + plane.y * rows[1].xyz + plane.z * rows[2].xyz;
        let x = plane.x * rows[0].w;
        let y = plane.y * rows[1].w;
        let z = plane.z * rows[2].w;
        let length = sqrt(normal.x * normal.x + normal.y * normal.y + normal.z * normal.z);
        let rounded = SLACK * (abs(x) + abs(y) + abs(z) + abs(plane.w));
        let offset = x + y + z + plane.w + rounded + agents[agent].moved * length;
        let far = normal * select(low, high, normal > vec3(0.0));
        if far.x + far.y + far.z + offset < 0.0 {
            return false;
        }
    }
    return true;
}

/// Whether a cluster of an agent that is cut group by group is drawn.
fn is_drawn(cluster: u32, model: Model, agent: u32, eye: vec4<f32>) -> bool {
    let found = clusters[model.first_cluster + cluster];
    if found.made_by != NONE && !is_coarse(found.made_by, model, agent, eye) {
        return false;
    }
    if found.used_by == NONE {
        return true;
    }
    return !is_coarse(found.used_by, model, agent, eye) && is_seen(model.first_group + found.used_by, agent);
}

/// Where the clusters of a step begin, and their end.
fn step_range(model: Model, bucket: u32) -> vec2<u32> {
    let at = model.first_start + bucket - model.first_bucket;
    return vec2(ladders[at], ladders[at + 1u]);
}

/// Whether the agent at a place draws for its bucket: the first of a step, and all that are cut group by group.
fn begins(at: u32) -> bool {
    return at == 0u || keys[at - 1u] != keys[at];
}

var<workgroup> sums: array<u32, GROUP>;
var<workgroup> base: u32;
var<workgroup> work: vec4<u32>;

/// Sets what a workgroup has to do for the agent at a place: clusters to look at, whether it cuts group by group, the agent.
fn plan(at: u32, local: u32) -> vec4<u32> {
    if local == 0u {
        work = vec4(0u);
        if at < atomicLoad(&counts[0]) {
            let agent = values[at];
            let model = model_of(agent);
            if keys[at] == model.first_bucket + model.steps {
                work = vec4(model.clusters, 1u, agent, 0u);
            } else if begins(at) {
                let range = step_range(model, keys[at]);
                work = vec4(range.y - range.x, 0u, agent, range.x);
            }
        }
    }
    return workgroupUniformLoad(&work);
}

@compute @workgroup_size(GROUP)
fn count_draws(id: Invocation) {
    let at = linear_group(id);
    let task = plan(at, id.local);
    var found = 0u;
    if task.y == 1u {
        let model = model_of(task.z);
        let eye = eye_of(task.z);
        for (var cluster = id.local; cluster < task.x; cluster += GROUP) {
            found += u32(is_drawn(cluster, model, task.z, eye));
        }
    }
    sums[id.local] = found;
    workgroupBarrier();
    for (var half = GROUP / 2u; half > 0u; half /= 2u) {
        if id.local < half {
            sums[id.local] += sums[id.local + half];
        }
        workgroupBarrier();
    }
    if id.local == 0u && at < atomicLoad(&counts[0]) {
        starts[at] = select(task.x, sums[0], task.y == 1u);
    }
}

/// Writes a draw of a cluster for instances from `first` on.
fn write(place: u32, model: Model, number: u32, cluster: u32, first: u32, count: u32, blend: f32) {
    let found = clusters[model.first_cluster + cluster];
    atomicAdd(&counts[2], found.indices / 3u * count);
    if place >= call.capacity {
        return;
    }
    draws[5u * place] = found.indices;
    draws[5u * place + 1u] = count;
    draws[5u * place + 2u] = found.first_index;
    draws[5u * place + 3u] = model.base_vertex;
    draws[5u * place + 4u] = first;
    drawn[place] = vec2(number, cluster);
    blends[place] = blend;
}

@compute @workgroup_size(GROUP)
fn write_draws(id: Invocation) {
    let at = linear_group(id);
    let task = plan(at, id.local);
    let seen = atomicLoad(&counts[0]);
    let is_in = at < seen;
    let agent = values[min(at, call.agents - 1u)];
    let number = bitcast<u32>(agents[agent].inverse[2].w);
    let model = models[number];
    if id.local == 0u {
        base = 0u;
        if is_in {
            base = starts[at];
        }
        if at < seen + atomicLoad(&counts[3]) {
            let pose = poses[agent];
            instances[at] = Instance(agent, pose.x, pose.y, number, agents[agent].transform);
        }
        if at == 0u {
            // The prefix sum after the last agent.
            atomicStore(&counts[1], starts[call.agents]);
        }
    }
    let first = workgroupUniformLoad(&base);
    if task.y == 0u {
        var count = 0u;
        if task.x > 0u {
            count = first_of(keys[at] + 1u, at) - at;
        }
        for (var it = id.local; it < task.x; it += GROUP) {
            write(first + it, model, number, ladders[task.w + it], at, count, 0.0);
        }
        return;
    }
    let eye = eye_of(agent);
    var before = first;
    for (var start = 0u; start < task.x; start += GROUP) {
        let cluster = start + id.local;
        var mine = 0u;
        if cluster < task.x {
            mine = u32(is_drawn(cluster, model, agent, eye));
        }
        sums[id.local] = mine;
        workgroupBarrier();
        for (var step = 1u; step < GROUP; step *= 2u) {
            var lower = 0u;
            if id.local >= step {
                lower = sums[id.local - step];
            }
            workgroupBarrier();
            sums[id.local] += lower;
            workgroupBarrier();
        }
        if mine == 1u {
            let blend = blend_of(cluster, model, agent, eye);
            write(before + sums[id.local] - 1u, model, number, cluster, at, 1u, blend);
        }
        before += sums[GROUP - 1u];
        workgroupBarrier();
    }
}
