// import fluid
// import fluid_noise
// Forces on all particles, as `force.rs`.

const GRAVITY: u32 = 0u;
const WIND: u32 = 1u;
const DRAG: u32 = 2u;
const VORTEX: u32 = 3u;
const ATTRACTOR: u32 = 4u;
/// The share of a velocity that a drag takes away in a second, at most.
const FASTEST: f32 = 100.0;

struct ForceRow {
    /// An acceleration in m/s², a velocity in m/s, or a place in m.
    place: vec3<f32>,
    /// The last number is turbulence's.
    kind: u32,
    /// Of the length 1.
    axis: vec3<f32>,
    /// In m/s², or a share in 1/s.
    strength: f32,
    /// In m; of a drag the share that grows with the speed, in 1/m.
    radius: f32,
    seed: u32,
    /// The slice of time that was passed last, and how much of the next one there is.
    slice: i32,
    later: f32,
}

/// The acceleration of a particle, in m/s².
fn acceleration_by(force: ForceRow, place: vec3<f32>, velocity: vec3<f32>) -> vec3<f32> {
    switch force.kind {
        case GRAVITY: {
            return force.place;
        }
        case WIND: {
            return force.strength * (force.place - velocity);
        }
        case DRAG: {
            return -min(force.strength + force.radius * length(velocity), FASTEST) * velocity;
        }
        case VORTEX: {
            let around = cross(force.axis, place - force.place);
            let square = max(dot(around, around), force.radius * force.radius);
            return around * (force.strength * force.radius / square);
        }
        case ATTRACTOR: {
            let to = force.place - place;
            let distance = length(to);
            let fall = force.radius / max(distance, force.radius);
            return select(vec3(0.0), to * (force.strength * fall * fall / distance), distance > 0.0);
        }
        default: {
            let slices = vec2(force.slice, force.slice + 1);
            return force.strength * noise_curl(place / force.radius, slices, force.later, force.seed);
        }
    }
}
