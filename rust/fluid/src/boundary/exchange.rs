//! The momentum that walls and colliders get from the fluid in a step: what it loses to them, and what bodies move by
//! (Akinci et al. 2012, Section 3).

use glam::{DVec3, Vec4, Vec4Swizzles};
use relievo_core::lanes::Lanes;
use relievo_core::{Context, dispatch_simd};

use crate::solver::constants::Constants;
use crate::solver::neighbours::{CHUNK_LEN, Neighbours};
use crate::solver::pairs::{Rows, Vectors, around};

/// Momentum that something was given.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Impulse {
    /// kg m/s
    pub linear: DVec3,
    /// About the origin, in kg m²/s.
    pub angular: DVec3,
}

impl Impulse {
    /// Adds momentum that is given at a place.
    pub fn add(&mut self, place: DVec3, momentum: DVec3) {
        self.linear += momentum;
        self.angular += place.cross(momentum);
    }
}

/// Momentum that a fluid was given in a step, in kg m/s. What its particles give each other adds up to nothing.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Given {
    /// By the gravity of its options.
    pub gravity: DVec3,
    /// By the accelerations of the host.
    pub host: DVec3,
    /// By its forces.
    pub forces: DVec3,
    /// By walls and colliders.
    pub walls: DVec3,
}

/// What forces between fluid and walls follow from.
pub struct Exchange<'a> {
    pub constants: Constants,
    /// When the step began.
    pub places: Rows<'a>,
    pub velocities: Rows<'a>,
    pub near: &'a Neighbours,
    /// With the pressures by which particles were moved.
    pub predicted: &'a [Vec4],
    /// The number of each particle of walls, and that of the first one of each group.
    pub numbers: &'a [u32],
    pub groups: &'a [usize],
    pub seconds: f32,
}

/// What each group of walls got.
pub fn exchange(context: &Context, given: &Exchange) -> Vec<Impulse> {
    let parts = context.map(given.near.parts().len(), |part| {
        if given.groups.len() == 1 {
            return vec![all_of_part(context.level(), given, part)];
        }
        let mut impulses = vec![Impulse::default(); given.groups.len()];
        let lists = &given.near.parts()[part];
        let Constants { kernels, mass, density, friction, .. } = given.constants;
        let [push, rub] = [mass / (density * density), mass * kernels.spiky / density * friction];
        for particle in 0..lists.starts.len() - 1 {
            let number = part * CHUNK_LEN + particle;
            let (place, velocity) = (given.places.fluid[number], given.velocities.fluid[number]);
            let pressure = given.predicted[number].w;
            for at in lists.range(particle) {
                let wall = lists.indices[at] as usize;
                let Some(set) = given.numbers.get(wall) else { break };
                let other = given.places.walls[wall];
                let from = (place - other).xyz();
                let left = (kernels.support - from.length()).max(0.0);
                let slip = (velocity - given.velocities.walls[wall]).xyz();
                let force = other.w * (push * pressure * lists.slopes[at] * from + rub * left * slip);
                let group = given.groups.partition_point(|first| *first <= *set as usize) - 1;
                impulses[group].add(other.xyz().as_dvec3(), (given.seconds * force).as_dvec3());
            }
        }
        impulses
    });
    let mut all = vec![Impulse::default(); given.groups.len()];
    for part in parts {
        for (all, part) in all.iter_mut().zip(part) {
            all.linear += part.linear;
            all.angular += part.angular;
        }
    }
    all
}

/// What the particles of a part give to all walls together. Each gives it where it is itself: pressure acts along the line
/// to the wall's particle, so that makes no difference to it.
#[inline(always)]
fn all_body<A: Lanes>(v: A, given: &Exchange, part: usize) -> Impulse {
    let lists = &given.near.parts()[part];
    let Constants { kernels, mass, density, friction, .. } = given.constants;
    let [push, rub] = [mass / (density * density), mass * kernels.spiky / density * friction];
    let support = v.splat(kernels.support);
    let mut impulse = Impulse::default();
    for particle in 0..lists.starts.len() - 1 {
        if lists.range(particle).is_empty() {
            continue;
        }
        let number = part * CHUNK_LEN + particle;
        let own = given.places.fluid[number];
        let velocity = Vectors::splat(v, given.velocities.fluid[number]);
        let [mut pushed, mut rubbed] = [Vectors::zero(v); 2];
        around(v, lists, particle, given.places.walls, own, |from, mass, at| {
            let left = v.max(v.sub(support, v.sqrt(from.dot(v, from))), v.splat(0.0));
            pushed = pushed.plus(v, v.mul(mass, v.load(&lists.slopes[at..])), from);
            let [x, y, z, _] = v.gather_rows(bytemuck::cast_slice(given.velocities.walls), &lists.indices[at..]);
            rubbed = rubbed.plus(v, v.mul(mass, left), velocity.minus(v, Vectors([x, y, z])));
        });
        let force = push * given.predicted[number].w * pushed.sum(v) + rub * rubbed.sum(v);
        impulse.add(own.xyz().as_dvec3(), (given.seconds * force).xyz().as_dvec3());
    }
    impulse
}

dispatch_simd! { fn all_of_part = all_body(given: &Exchange<'_>, part: usize) -> Impulse }
