// import common
// The surface of particles on a device, in bricks: cubes as wide as the support radius that hold 4³ corners of the cells
// by which the surface is found. Bricks of a box around all particles are numbered row by row along x. Lists of bricks are in
// the order of these numbers, so bricks beside each other along x are side by side.

/// Corners of a brick along an axis, and in all.
const SIDE: u32 = 4u;
const CORNERS: u32 = 64u;
/// How weights fall off: exp(−a s) less its value at 1, (1 − s)³, and the cubic spline.
const GAUSSIAN: u32 = 0u;
const CUBIC: u32 = 1u;
const SPLINE: u32 = 2u;

struct SurfaceCall {
    /// The lowest brick of the box, and bricks along its axes.
    low: vec3<i32>,
    particles: u32,
    size: vec3<u32>,
    /// Bricks that have particles, bricks that particles reach, and how often those were listed.
    cells: u32,
    bricks: u32,
    listed: u32,
    vertices: u32,
    profile: u32,
    /// The support radius and the size of a cell, in m.
    support: f32,
    cell: f32,
    /// Of the Gaussian, and its value at 1.
    sharpness: f32,
    floor: f32,
    /// What sums of weights are lowered by.
    iso: f32,
    /// A mean's radius in m, and its value where no particle is near.
    radius: f32,
    outside: f32,
    /// Squares of the distances up to which a particle is at the surface and blind, in m².
    layer: f32,
    farthest: f32,
    /// How many bricks the second of these distances reaches.
    reach: i32,
}

var<immediate> surface: SurfaceCall;

fn brick_of(place: vec3<f32>) -> vec3<i32> {
    return vec3<i32>(floor(place / surface.support));
}

/// The number of a brick; outside of the box it is one that is far away.
fn number_of(brick: vec3<i32>) -> u32 {
    let at = vec3<u32>(brick - surface.low);
    return (at.z * surface.size.y + at.y) * surface.size.x + at.x;
}

/// Where the brick of a number lies.
fn brick_at(number: u32) -> vec3<i32> {
    let row = number / surface.size.x;
    return surface.low + vec3<i32>(vec3(number % surface.size.x, row % surface.size.y, row / surface.size.y));
}

/// The lattice place of a corner of a brick.
fn corner_of(number: u32, corner: u32) -> vec3<i32> {
    let within = vec3(corner % SIDE, corner / SIDE % SIDE, corner / (SIDE * SIDE));
    return i32(SIDE) * brick_at(number) + vec3<i32>(within);
}

/// What a number grows by from a brick to the next one along an axis.
fn strides() -> vec3<u32> {
    return vec3(1u, surface.size.x, surface.size.x * surface.size.y);
}

/// The weight of a particle at s, the square of its distance over that of the support radius.
fn weight_of(s: f32) -> f32 {
    if s >= 1.0 {
        return 0.0;
    }
    if surface.profile == GAUSSIAN {
        return max(exp(-surface.sharpness * s) - surface.floor, 0.0);
    }
    let rest = 1.0 - s;
    if surface.profile == CUBIC {
        return rest * rest * rest;
    }
    let left = 1.0 - sqrt(s);
    return select(2.0 * left * left * left, 1.0 - 6.0 * s * left, s <= 0.25);
}

/// The value of the function that follows from a sum of weights and one of weights times vectors to particles.
fn value_of(weight: f32, moment: vec3<f32>) -> f32 {
    if surface.profile != CUBIC {
        return weight - surface.iso;
    }
    if weight > 0.0 {
        return surface.radius - length(moment) / weight;
    }
    return surface.outside;
}
