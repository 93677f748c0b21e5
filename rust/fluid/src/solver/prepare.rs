//! The first pass of a step: densities, slopes towards neighbours, and the accelerations that need no pressure.

use glam::Vec4;
use relievo_core::lanes::Lanes;
use relievo_core::{Context, dispatch_simd};

use crate::solver::constants::{Constants, KernelLanes};
use crate::solver::neighbours::{CHUNK_LEN, Neighbours, Part};
use crate::solver::pairs::{Rows, Vectors, around};

/// What a step begins with.
pub struct Begin<'a> {
    pub constants: Constants,
    pub places: Rows<'a>,
    pub velocities: Rows<'a>,
}

/// What the pass finds of a particle.
#[derive(Clone, Copy, Default)]
pub struct Neighborhood {
    /// kg/m³
    pub density: f32,
    /// By which a particle's density follows its pressure: Σ |m ∇W|² + |Σ m ∇W|², over walls too, with the kernel of
    /// pressures (as the factor of Bender, Koschier 2017, Equation 8).
    pub diagonal: f32,
    /// A third of the sum of forces times distances, for a pressure of 1 and the particle's volume. Half of what is between
    /// it and a wall is the wall's.
    pub virial: f32,
}

/// Finds densities and accelerations of all particles, and the slopes towards their neighbours and walls.
pub fn prepare(
    context: &Context,
    begin: &Begin,
    [near, walls]: [&mut Neighbours; 2],
    found: &mut [Neighborhood],
    accelerations: &mut [Vec4],
) {
    let lists = near.parts_mut().iter_mut().zip(walls.parts_mut());
    let mut parts: Vec<_> = lists.zip(found.chunks_mut(CHUNK_LEN)).zip(accelerations.chunks_mut(CHUNK_LEN)).collect();
    context.for_each_mut(&mut parts, |part, (((near, walls), found), accelerations)| {
        prepare_part(context.level(), begin, part * CHUNK_LEN, [near, walls], found, accelerations);
    });
}

#[inline(always)]
fn prepare_body<A: Lanes>(
    v: A,
    begin: &Begin,
    first: usize,
    [near, walls]: [&mut Part; 2],
    found: &mut [Neighborhood],
    accelerations: &mut [Vec4],
) {
    let Constants { kernels, mass, density, wall, viscosity, friction, cohesion, .. } = begin.constants;
    let smoothing = KernelLanes::new(v, &begin.constants);
    let zero = v.splat(0.0);
    for part in [&mut *near, &mut *walls] {
        part.slopes.clear();
        part.slopes.resize(part.indices.len(), 0.0);
    }
    let [mut near_slopes, mut wall_slopes] = [std::mem::take(&mut near.slopes), std::mem::take(&mut walls.slopes)];
    for (particle, (found, acceleration)) in found.iter_mut().zip(accelerations).enumerate() {
        let own = begin.places.fluid[first + particle];
        let velocity = Vectors::splat(v, begin.velocities.fluid[first + particle]);
        let [mut sum, mut squares, mut beside, mut inner, mut outer] = [zero; 5];
        let [mut gradient, mut drag, mut pull, mut behind, mut rub] = [Vectors::zero(v); 5];
        around(v, near, particle, begin.places.fluid, own, |from, _, at| {
            let square = from.dot(v, from);
            let [slope, rest] = smoothing.slope(v.sqrt(square));
            let kernel = smoothing.density(square);
            v.store(slope, &mut near_slopes[at..]);
            sum = v.add(sum, kernel);
            let steep = v.mul(slope, square);
            squares = v.fused(slope, steep, squares);
            inner = v.add(inner, steep);
            gradient = gradient.plus(v, slope, from);
            pull = pull.plus(v, kernel, from);
            let [x, y, z, _] = v.gather_rows(bytemuck::cast_slice(begin.velocities.fluid), &near.indices[at..]);
            drag = drag.plus(v, rest, Vectors([x, y, z]).minus(v, velocity));
        });
        around(v, walls, particle, begin.places.walls, own, |from, mass, at| {
            let distance = v.sqrt(from.dot(v, from));
            let [slope, rest] = smoothing.wall_slope(distance);
            v.store(slope, &mut wall_slopes[at..]);
            beside = v.fused(mass, smoothing.wall(distance), beside);
            outer = v.fused(v.mul(mass, slope), v.mul(distance, distance), outer);
            behind = behind.plus(v, v.mul(mass, slope), from);
            let [x, y, z, _] = v.gather_rows(bytemuck::cast_slice(begin.velocities.walls), &walls.indices[at..]);
            rub = rub.plus(v, v.mul(mass, rest), Vectors([x, y, z]).minus(v, velocity));
        });
        found.density = kernels.density * mass * (1.0 + v.sum(sum)) + wall * v.sum(beside);
        let all = mass * gradient.sum(v) + behind.sum(v);
        found.diagonal = mass * mass * v.sum(squares) + all.length_squared();
        found.virial = (mass * v.sum(inner) + 0.5 * v.sum(outer)) / (-3.0 * density);
        *acceleration = kernels.spiky / density * (viscosity * mass * drag.sum(v) + friction * rub.sum(v))
            - cohesion * mass * kernels.density * pull.sum(v);
    }
    (near.slopes, walls.slopes) = (near_slopes, wall_slopes);
}

dispatch_simd! {
    fn prepare_part = prepare_body(
        begin: &Begin,
        first: usize,
        lists: [&mut Part; 2],
        found: &mut [Neighborhood],
        accelerations: &mut [Vec4],
    )
}
