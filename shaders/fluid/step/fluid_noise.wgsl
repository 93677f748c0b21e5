// The noise of turbulence, as `noise.rs`.

/// What makes the curl as long as 1 in the mean square.
const LENGTH: f32 = 0.61;

/// A number in −1..1 for a corner of a lattice in space and time.
fn noise_value(at: vec4<i32>, seed: u32) -> f32 {
    var mixed = (seed * 0x9e3779b1u) ^ 0x85ebca6bu;
    for (var axis = 0u; axis < 4u; axis++) {
        mixed = (mixed ^ bitcast<u32>(at[axis])) * 0xcc9e2d51u;
        mixed = (mixed ^ (mixed >> 15u)) * 0x1b873593u;
        mixed ^= mixed >> 13u;
    }
    return f32(mixed >> 8u) / 8388608.0 - 1.0;
}

/// Weights from 0 to 1 with no slope or bend at their ends, and their slopes.
fn fade(at: vec3<f32>) -> vec3<f32> {
    return at * at * at * (at * (6.0 * at - 15.0) + 10.0);
}

fn fade_slope(at: vec3<f32>) -> vec3<f32> {
    let bend = at * (at - 1.0);
    return 30.0 * bend * bend;
}

/// The slope of noise on a lattice of a unit, between two slices of time, the second of a weight.
fn noise_slope(place: vec3<f32>, slices: vec2<i32>, later: f32, seed: u32) -> vec3<f32> {
    let cell = floor(place);
    let low = vec3<i32>(cell);
    let within = fade(place - cell);
    let steep = fade_slope(place - cell);
    var sum = vec3(0.0);
    for (var k = 0; k < 8; k++) {
        let side = vec3(k & 1, (k >> 1u) & 1, k >> 2u);
        let corner = low + side;
        let now = noise_value(vec4(corner, slices.x), seed);
        let height = now + later * (noise_value(vec4(corner, slices.y), seed) - now);
        let is_far = side == vec3(1);
        let weight = select(1.0 - within, within, is_far);
        let slope = select(-steep, steep, is_far);
        sum += height * slope * weight.yxx * weight.zzy;
    }
    return sum;
}

/// The curl of three such noises, of about the length 1 in the mean.
fn noise_curl(place: vec3<f32>, slices: vec2<i32>, later: f32, seed: u32) -> vec3<f32> {
    let x = noise_slope(place, slices, later, seed * 3u);
    let y = noise_slope(place, slices, later, seed * 3u + 1u);
    let z = noise_slope(place, slices, later, seed * 3u + 2u);
    return LENGTH * vec3(z.y - y.z, x.z - z.x, y.x - x.y);
}
