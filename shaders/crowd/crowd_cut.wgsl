// import common
// The cut of a crowd on a device, as `rust/crowd/src/crowd.rs`, and its indexed draws, as `draws.rs`: every agent gets a bucket
// by its model and step; sorted by bucket and pose, agents are instances, and their numbers of draws are added up to where each
// writes.

struct Call {
    agents: u32,
    planes: u32,
    /// Buckets of all models; that of agents out of view comes after them.
    buckets: u32,
    /// Draws that there is room for.
    capacity: u32,
}

/// A model: where its parts begin in the lists of all models.
struct Model {
    /// Its steps.
    first_step: u32,
    steps: u32,
    /// Its first bucket: one for each step, then that of agents that are cut group by group.
    first_bucket: u32,
    first_cluster: u32,
    clusters: u32,
    first_group: u32,
    base_vertex: u32,
    /// Where its list of starts begins.
    first_start: u32,
}

struct Agent {
    /// A sphere that it does not leave.
    center: vec3<f32>,
    radius: f32,
    /// The inverse of its linear part, by rows; and one over the largest factor of lengths, the smallest by the largest, and the
    /// bits of the number of its model.
    inverse: array<vec4<f32>, 3>,
    /// From the model to the world, by rows.
    transform: array<vec4<f32>, 3>,
}

struct Cluster {
    indices: u32,
    first_index: u32,
    made_by: u32,
    used_by: u32,
}

struct Group {
    low: vec3<f32>,
    error: f32,
    high: vec3<f32>,
    padding: f32,
}

struct Instance {
    agent: u32,
    first_matrix: u32,
    first_weight: u32,
    model: u32,
    transform: array<vec4<f32>, 3>,
}

@group(0) @binding(0) var<storage, read> models: array<Model>;
@group(0) @binding(1) var<storage, read> clusters: array<Cluster>;
@group(0) @binding(2) var<storage, read> model_groups: array<Group>;
/// The error of each step, as bits, then where the clusters of each begin, and their end, then the clusters.
@group(0) @binding(3) var<storage, read> ladders: array<u32>;
@group(0) @binding(4) var<storage, read> agents: array<Agent>;
/// The first matrix and the first weight of the pose of each agent.
@group(0) @binding(5) var<storage, read> poses: array<vec2<u32>>;
/// The eye and the error that may be seen at a distance of 1, then planes.
@group(0) @binding(6) var<storage, read> view: array<vec4<f32>>;
@group(1) @binding(0) var<storage, read_write> keys: array<u32>;
@group(1) @binding(1) var<storage, read_write> values: array<u32>;
/// How many draws each agent in view begins, then where its draws begin.
@group(1) @binding(2) var<storage, read_write> starts: array<u32>;
/// Agents in view, and draws.
@group(1) @binding(3) var<storage, read_write> counts: array<u32>;
@group(1) @binding(4) var<storage, read_write> draws: array<u32>;
@group(1) @binding(5) var<storage, read_write> drawn: array<vec2<u32>>;
@group(1) @binding(6) var<storage, read_write> instances: array<Instance>;
var<immediate> call: Call;

/// As in `crowd.rs`.
const DEEP: f32 = 0.25;
const SLACK: f32 = 1e-6;
const NONE: u32 = 0xffffffffu;

/// Lists all agents with the first matrices of their poses, by which they are sorted before buckets.
@compute @workgroup_size(GROUP)
fn enlist(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let index = linear_item(group, groups, local);
    if index < call.agents {
        keys[index] = poses[index].x;
        values[index] = index;
    }
}

/// Gives every agent its bucket.
@compute @workgroup_size(GROUP)
fn choose(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let at = linear_item(group, groups, local);
    if at >= call.agents {
        return;
    }
    let index = values[at];
    let center = agents[index].center;
    let radius = agents[index].radius;
    keys[at] = call.buckets;
    for (var number = 1u; number <= call.planes; number++) {
        let plane = view[number];
        if plane.x * center.x + plane.y * center.y + plane.z * center.z + plane.w < -radius {
            return;
        }
    }
    let away = center - view[0].xyz;
    let near = sqrt(away.x * away.x + away.y * away.y + away.z * away.z) - radius;
    let model = models[bitcast<u32>(agents[index].inverse[2].w)];
    if 2.0 * radius > DEEP * near {
        keys[at] = model.first_bucket + model.steps;
        return;
    }
    let allowed = view[0].w * near * agents[index].inverse[0].w;
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

/// Finds how many agents are in view, which come first.
@compute @workgroup_size(GROUP)
fn count_seen(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let at = linear_item(group, groups, local);
    if at >= call.agents || keys[at] == call.buckets {
        return;
    }
    if at + 1u == call.agents || keys[at + 1u] == call.buckets {
        counts[0] = at + 1u;
    }
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

fn is_coarse(group: u32, eye: vec4<f32>) -> bool {
    let beyond = max(max(model_groups[group].low - eye.xyz, eye.xyz - model_groups[group].high), vec3(0.0));
    let distance = sqrt(beyond.x * beyond.x + beyond.y * beyond.y + beyond.z * beyond.z);
    return model_groups[group].error <= eye.w * distance;
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
        let offset = x + y + z + plane.w + SLACK * (abs(x) + abs(y) + abs(z) + abs(plane.w));
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
    if found.made_by != NONE && !is_coarse(model.first_group + found.made_by, eye) {
        return false;
    }
    if found.used_by == NONE {
        return true;
    }
    let user = model.first_group + found.used_by;
    return !is_coarse(user, eye) && is_seen(user, agent);
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
        if at < counts[0] {
            let agent = values[at];
            let model = models[bitcast<u32>(agents[agent].inverse[2].w)];
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
fn count_draws(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let at = linear_group(group, groups);
    let task = plan(at, local);
    var found = 0u;
    if task.y == 1u {
        let model = models[bitcast<u32>(agents[task.z].inverse[2].w)];
        let eye = eye_of(task.z);
        for (var cluster = local; cluster < task.x; cluster += GROUP) {
            found += u32(is_drawn(cluster, model, task.z, eye));
        }
    }
    sums[local] = found;
    workgroupBarrier();
    for (var half = GROUP / 2u; half > 0u; half /= 2u) {
        if local < half {
            sums[local] += sums[local + half];
        }
        workgroupBarrier();
    }
    if local == 0u && at < counts[0] {
        starts[at] = select(task.x, sums[0], task.y == 1u);
    }
}

/// Writes a draw of a cluster for instances from `first` on.
fn write(place: u32, model: Model, number: u32, cluster: u32, first: u32, count: u32) {
    if place >= call.capacity {
        return;
    }
    let found = clusters[model.first_cluster + cluster];
    draws[5u * place] = found.indices;
    draws[5u * place + 1u] = count;
    draws[5u * place + 2u] = found.first_index;
    draws[5u * place + 3u] = model.base_vertex;
    draws[5u * place + 4u] = first;
    drawn[place] = vec2(number, cluster);
}

/// The place after the last agent of the bucket of that at `at`.
fn bucket_end(at: u32) -> u32 {
    var low = at + 1u;
    var high = counts[0];
    while low < high {
        let middle = (low + high) / 2u;
        if keys[middle] == keys[at] {
            low = middle + 1u;
        } else {
            high = middle;
        }
    }
    return low;
}

@compute @workgroup_size(GROUP)
fn write_draws(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let at = linear_group(group, groups);
    let task = plan(at, local);
    let is_in = at < counts[0];
    let agent = values[min(at, call.agents - 1u)];
    let number = bitcast<u32>(agents[agent].inverse[2].w);
    let model = models[number];
    if local == 0u {
        base = 0u;
        if is_in {
            base = starts[at];
            let pose = poses[agent];
            instances[at] = Instance(agent, pose.x, pose.y, number, agents[agent].transform);
        }
        if at == 0u {
            // The prefix sum after the last agent.
            counts[1] = starts[call.agents];
        }
    }
    let first = workgroupUniformLoad(&base);
    if task.y == 0u {
        var count = 0u;
        if task.x > 0u {
            count = bucket_end(at) - at;
        }
        for (var it = local; it < task.x; it += GROUP) {
            write(first + it, model, number, ladders[task.w + it], at, count);
        }
        return;
    }
    let eye = eye_of(agent);
    var before = first;
    for (var start = 0u; start < task.x; start += GROUP) {
        let cluster = start + local;
        var mine = 0u;
        if cluster < task.x {
            mine = u32(is_drawn(cluster, model, agent, eye));
        }
        sums[local] = mine;
        workgroupBarrier();
        for (var step = 1u; step < GROUP; step *= 2u) {
            var lower = 0u;
            if local >= step {
                lower = sums[local - step];
            }
            workgroupBarrier();
            sums[local] += lower;
            workgroupBarrier();
        }
        if mine == 1u {
            write(before + sums[local] - 1u, model, number, cluster, at, 1u);
        }
        before += sums[GROUP - 1u];
        workgroupBarrier();
    }
}
