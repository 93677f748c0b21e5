// import common
// A fluid of particles on a device. What is beside a particle is found in cells as wide as the support radius. A cell's
// number is a z-curve's over a cube of cells that repeats itself in space: cells that share a number are far from each other.

/// Bits of a cell's number along an axis.
const BITS: u32 = 7u;
const CELLS: u32 = 1u << (3u * BITS);
/// Wendland's kernels for density and pressure; the other set is that of Müller, Charypar and Gross.
const WENDLAND: u32 = 0u;

struct FluidCall {
    /// m/s²
    gravity: vec3<f32>,
    /// m
    support: f32,
    /// The kernel of densities at no distance, in 1/m³, the factor of the spiky kernel and of viscosity's, and a wall's at no
    /// distance.
    kernel: f32,
    spiky: f32,
    wall: f32,
    kernels: u32,
    /// kg, and kg/m³ at rest.
    mass: f32,
    density: f32,
    /// Of a particle in a full lattice.
    diagonal: f32,
    viscosity: f32,
    friction: f32,
    cohesion: f32,
    /// How far a particle may go in the step, in m.
    farthest: f32,
    /// s
    step: f32,
    /// The density up to which a particle may be when the step ends, and the share that may stay of what it has more than
    /// that when it begins.
    begun_limit: f32,
    allowed_share: f32,
    /// The greatest and the mean excess of density with which a step may end, as shares.
    most: f32,
    mean: f32,
    /// Particles, those of walls, neighbours that there is room for, and the corrections of a step at least and at most.
    count: u32,
    walls: u32,
    room: u32,
    least: u32,
    corrections: u32,
    /// The share of the pressures of the last step that this one begins with.
    carried: f32,
    forces: u32,
    /// m, or 0 where there are no colliders.
    spacing: f32,
}

var<immediate> fluid: FluidCall;

/// The lowest bits of a number with two zeros after each.
fn spread(number: u32) -> u32 {
    var bits = number & ((1u << BITS) - 1u);
    bits = (bits | (bits << 8u)) & 0x0300f00fu;
    bits = (bits | (bits << 4u)) & 0x030c30c3u;
    return (bits | (bits << 2u)) & 0x09249249u;
}

fn cell_of(place: vec3<f32>) -> vec3<i32> {
    return vec3<i32>(floor(place / fluid.support));
}

fn number_of(cell: vec3<i32>) -> u32 {
    let bits = vec3<u32>(cell);
    return spread(bits.x) | (spread(bits.y) << 1u) | (spread(bits.z) << 2u);
}

/// 1 − r / h, and 0 beyond the support.
fn rest_of(distance: f32) -> f32 {
    return max(1.0 - distance / fluid.support, 0.0);
}

/// The kernel of densities, relative to no distance.
fn density_kernel(distance: f32) -> f32 {
    let rest = rest_of(distance);
    if fluid.kernels == WENDLAND {
        let square = rest * rest;
        return square * square * (5.0 - 4.0 * rest);
    }
    let share = rest * (1.0 + distance / fluid.support);
    return share * share * share;
}

/// The slope of pressure's kernel, as a factor of the vector from the other particle.
fn pressure_slope(distance: f32) -> f32 {
    let rest = rest_of(distance);
    let square = fluid.support * fluid.support;
    if fluid.kernels == WENDLAND {
        return -20.0 * fluid.kernel / square * (rest * rest * rest);
    }
    return -fluid.spiky * square * (rest * rest) / max(distance, 1e-6 * fluid.support);
}

fn sixth(rest: f32) -> f32 {
    let cube = rest * rest * rest;
    return cube * cube;
}

/// A wall's kernel, relative to no distance, and its slope.
fn wall_kernel(distance: f32) -> f32 {
    let rest = rest_of(distance);
    return sixth(rest) * rest;
}

fn wall_slope(distance: f32) -> f32 {
    return -7.0 * fluid.wall / fluid.support * sixth(rest_of(distance)) / max(distance, 1e-6 * fluid.support);
}
