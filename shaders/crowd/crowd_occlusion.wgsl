// import common
// import crowd_agents
// Culling by occlusion on a device (Section 5.2): agents, and clusters that a single agent shows, whose boxes are behind what was
// seen in the last frame. Depths are one over the distance along the view times a number, so larger ones are nearer; 0 where
// nothing is.

struct Call {
    agents: u32,
    planes: u32,
    options: u32,
    /// Numbers in a row of the depths.
    stride: u32,
    /// The level that is made.
    level: u32,
    /// Draws that there is room for.
    draws: u32,
    /// 1 where draws of hidden clusters lose their instance.
    removes: u32,
}

/// A level of the pyramid: each of its numbers is the smallest of two by two of the level below.
struct Level {
    /// Its first number in the pyramid; the lowest level is the depths.
    first: u32,
    width: u32,
    height: u32,
}

/// The camera: eye and pixels of what has the length of its distance; to the right, and the width; up, and the height; against
/// the direction of view, and the number that depths are multiplied by.
@group(1) @binding(0) var<storage, read> camera: array<vec4<f32>, 4>;
@group(1) @binding(1) var<storage, read> levels: array<Level>;
@group(1) @binding(2) var<storage, read> depths: array<f32>;
/// For each cluster its indices, its first index, and the groups that made and use it; for each group its box.
@group(1) @binding(3) var<storage, read> clusters: array<vec4<u32>>;
@group(1) @binding(4) var<storage, read> boxes: array<array<vec4<f32>, 2>>;
/// The agents of instances; model and cluster of each draw.
@group(1) @binding(5) var<storage, read> order: array<u32>;
@group(1) @binding(6) var<storage, read> drawn: array<vec2<u32>>;
@group(2) @binding(0) var<storage, read_write> pyramid: array<f32>;
@group(2) @binding(1) var<storage, read_write> states: array<u32>;
/// As in `crowd_cut.wgsl`.
@group(2) @binding(2) var<storage, read_write> draws: array<u32>;
@group(2) @binding(3) var<storage, read_write> counts: array<atomic<u32>, 4>;
/// HIDDEN or 0 for each draw, then how many are hidden.
@group(2) @binding(4) var<storage, read_write> draw_states: array<atomic<u32>>;
var<immediate> call: Call;

/// Relative rounding of depths.
const ROUNDING: f32 = 1e-4;
/// Pixels that boxes are widened by, for rounding.
const WIDENED: f32 = 1.0;
/// Numbers of a level along a side of a box at most, less one.
const ACROSS: u32 = 7u;

fn depth_at(level: u32, at: vec2<u32>) -> f32 {
    if level == 0u {
        return depths[at.y * call.stride + at.x];
    }
    return pyramid[levels[level].first + at.y * levels[level].width + at.x];
}

@compute @workgroup_size(GROUP)
fn reduce(id: Invocation) {
    let index = linear_item(id);
    let own = levels[call.level];
    if index >= own.width * own.height {
        return;
    }
    let below = levels[call.level - 1u];
    let low = 2u * vec2(index % own.width, index / own.width);
    let high = min(low + 1u, vec2(below.width, below.height) - 1u);
    var smallest = depth_at(call.level - 1u, low);
    smallest = min(smallest, depth_at(call.level - 1u, vec2(high.x, low.y)));
    smallest = min(smallest, depth_at(call.level - 1u, vec2(low.x, high.y)));
    pyramid[own.first + index] = min(smallest, depth_at(call.level - 1u, high));
}

/// Whether something is before the front of an agent's box at every pixel whose middle the box may cover.
fn is_hidden(agent: u32) -> bool {
    let model = model_of(agent);
    // The square of an impostor is in a sphere around the box of its pose.
    let square = select(0.0, model.radius, is_quad(agent, near_of(agent), call.options));
    return is_box_hidden(agent, model.low, model.high, agents[agent].moved + square);
}

/// The same of a box in the space of the agent's model, widened on all sides.
fn is_box_hidden(agent: u32, box_low: vec3<f32>, box_high: vec3<f32>, wider: f32) -> bool {
    let moved = vec3(wider);
    let rows = agents[agent].transform;
    var low = vec2(1e30);
    var high = vec2(-1e30);
    var front = 0.0;
    for (var corner = 0u; corner < 8u; corner++) {
        let is_high = (vec3(corner) & vec3(1u, 2u, 4u)) != vec3(0u);
        let at = vec4(select(box_low - moved, box_high + moved, is_high), 1.0);
        let away = vec3(dot(rows[0], at), dot(rows[1], at), dot(rows[2], at)) - camera[0].xyz;
        let z = dot(camera[3].xyz, away);
        // A box that reaches behind the camera is seen.
        if !(z < -1e-30) {
            return false;
        }
        let inverse = -1.0 / z;
        let place = vec2(dot(camera[1].xyz, away), -dot(camera[2].xyz, away)) * (camera[0].w * inverse);
        low = min(low, place);
        high = max(high, place);
        front = max(front, inverse);
    }
    let size = vec2(camera[1].w, camera[2].w);
    let first = ceil(0.5 * size + low - WIDENED - 0.5);
    let last = floor(0.5 * size + high + WIDENED - 0.5);
    if any(last < vec2(0.0)) || any(first > size - 1.0) || any(last < first) {
        return false;
    }
    let from_pixel = vec2<u32>(max(first, vec2(0.0)));
    let to_pixel = vec2<u32>(min(last, size - 1.0));
    var level = 0u;
    while any((to_pixel >> vec2(level)) - (from_pixel >> vec2(level)) > vec2(ACROSS)) {
        level++;
    }
    let limit = front * camera[3].w * (1.0 + ROUNDING);
    for (var y = from_pixel.y >> level; y <= to_pixel.y >> level; y++) {
        for (var x = from_pixel.x >> level; x <= to_pixel.x >> level; x++) {
            if depth_at(level, vec2(x, y)) <= limit {
                return false;
            }
        }
    }
    return true;
}

@compute @workgroup_size(GROUP)
fn test_agents(id: Invocation) {
    let index = linear_item(id);
    if index >= call.agents {
        return;
    }
    if is_out(index, call.planes) {
        states[index] = 0u;
    } else {
        states[index] = select(SEEN, HIDDEN, is_hidden(index));
    }
}

/// Finds the draws of a single agent whose clusters are hidden while the agent is not. These are in a group with others, which
/// has the box of all of them in every pose.
@compute @workgroup_size(GROUP)
fn test_draws(id: Invocation) {
    let draw = linear_item(id);
    if draw >= min(atomicLoad(&counts[1]), call.draws) || draws[5u * draw + 1u] != 1u {
        return;
    }
    let agent = order[draws[5u * draw + 4u]];
    let model = models[drawn[draw].x];
    let cluster = clusters[model.first_cluster + drawn[draw].y];
    if (states[agent] & HIDDEN) != 0u || cluster.w == NONE {
        return;
    }
    let box = boxes[model.first_group + cluster.w];
    if !is_box_hidden(agent, box[0].xyz, box[1].xyz, agents[agent].moved) {
        return;
    }
    atomicStore(&draw_states[draw], HIDDEN);
    atomicAdd(&draw_states[call.draws], 1u);
    if call.removes == 1u {
        draws[5u * draw + 1u] = 0u;
        atomicSub(&counts[2], cluster.x / 3u);
    }
}
