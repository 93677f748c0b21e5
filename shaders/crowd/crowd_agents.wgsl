// Models and agents of a crowd, which are group 0 of all kernels that look at agents, and which of them a view sees at all.

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
    /// The box of all poses, and half its diagonal.
    low: vec3<f32>,
    radius: f32,
    high: vec3<f32>,
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
    /// Where the limits of its groups begin if it has weights of its own, otherwise NONE.
    own: u32,
    /// How far its vertices may be outside the boxes of their groups.
    moved: f32,
}

@group(0) @binding(0) var<storage, read> models: array<Model>;
@group(0) @binding(1) var<storage, read> agents: array<Agent>;
/// The eye and the error that may be seen at a distance of 1, then planes.
@group(0) @binding(2) var<storage, read> view: array<vec4<f32>>;

const NONE: u32 = 0xffffffffu;
/// Options of a view.
const GEOMORPH: u32 = 1u;
const IMPOSTORS: u32 = 2u;
/// States of an agent: it was in the last frame, others hide it.
const SEEN: u32 = 1u;
const HIDDEN: u32 = 2u;
/// As in `impostor.rs`: a texel's diagonal and the error of its triangles by the radius, and the angle to the picture's direction.
const TEXEL: f32 = 0.0625 * (1.41421356 + 0.25);
const ANGLE: f32 = 0.069420047;

fn model_of(agent: u32) -> Model {
    return models[bitcast<u32>(agents[agent].inverse[2].w)];
}

/// Whether an agent is beyond one of the first planes of the view.
fn is_out(agent: u32, planes: u32) -> bool {
    let center = agents[agent].center;
    for (var number = 1u; number <= planes; number++) {
        let plane = view[number];
        if plane.x * center.x + plane.y * center.y + plane.z * center.z + plane.w < -agents[agent].radius {
            return true;
        }
    }
    return false;
}

/// How far the sphere of an agent is from the eye.
fn near_of(agent: u32) -> f32 {
    let away = agents[agent].center - view[0].xyz;
    return sqrt(away.x * away.x + away.y * away.y + away.z * away.z) - agents[agent].radius;
}

/// Whether an agent is an impostor.
fn is_quad(agent: u32, near: f32, options: u32) -> bool {
    let distance = near * agents[agent].inverse[0].w;
    if (options & IMPOSTORS) == 0u || agents[agent].own != NONE || distance <= 0.0 {
        return false;
    }
    let radius = model_of(agent).radius;
    return radius * (TEXEL + (ANGLE + 1.1 * radius / distance)) <= view[0].w * distance;
}
