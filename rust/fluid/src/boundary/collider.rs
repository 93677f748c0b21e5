//! Colliders: meshes of triangles that fluid does not pass, at rest, moving, or changing their shapes.
//!
//! Particles of walls (Akinci et al. 2012) lie half a spacing behind closed surfaces, and on open surfaces, which
//! have fluid on both sides. They follow the triangles, and what comes through between them is held by [`crate::boundary::sweep`].

use std::collections::HashMap;

use glam::{Vec3, Vec3A, Vec4};
use relievo_core::{Context, Error, Result};

use crate::boundary::sampling::{Sample, sample};
use crate::boundary::wall::weigh;
use crate::solver::constants::Constants;
use crate::surface::hierarchy::{Bounds, Hierarchy};

/// What becomes of a particle that meets a triangle, beside the push of the wall's particles.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Contact {
    /// It stays where it met it, and has its velocity (Morgenroth, Weiskopf, Eberhardt 2013, Section 3).
    Stop,
    /// It keeps what of its velocity is along the surface.
    #[default]
    Slip,
    /// It loses so much of that as this times what it loses across (Coulomb).
    Friction(f32),
}

/// How a collider behaves.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ColliderOptions {
    /// At its surface.
    pub contact: Contact,
    /// Whether fluid is inside of a closed mesh, not around it. How the triangles are wound does not matter.
    pub is_container: bool,
}

/// How much longer or shorter an edge may be than in the shape in which the particles were weighed, as a share.
const BENT: f32 = 1e-3;
/// How far a point may be moved by a corner, in distances of the particles behind the surface.
const MITER: f32 = 2.0;

/// A mesh that fluid does not pass.
#[derive(Clone, Debug)]
pub struct Collider {
    pub options: ColliderOptions,
    /// The triangles that have an area in the shape in which it was made.
    pub triangles: Vec<[u32; 3]>,
    /// Where its points are, in metres, and their velocities in m/s.
    pub points: Vec<Vec3>,
    pub paces: Vec<Vec3>,
    /// Boxes of the triangles from where they are to where they go.
    pub hierarchy: Hierarchy,
    /// Where it goes, and the seconds that are left until it is there.
    target: Vec<Vec3>,
    left: f32,
    /// How far behind the surface the particles are, against the triangles' normals.
    depth: f32,
    /// The first point that is where each is.
    joined: Vec<u32>,
    samples: Vec<Sample>,
    masses: Vec<f32>,
    lengths: Vec<f32>,
}

impl Collider {
    /// Of points in metres and triangles of them. Fails if a number is not finite, a point does not exist, no triangle has an
    /// area, or there are too many particles.
    pub fn new(
        context: &Context,
        constants: &Constants,
        points: &[Vec3],
        triangles: &[[u32; 3]],
        options: ColliderOptions,
    ) -> Result<Self> {
        check(points)?;
        if let Some(index) = triangles.iter().position(|triangle| triangle.iter().any(|p| *p as usize >= points.len()))
        {
            return Err(Error::invalid("a point does not exist").at(format!("triangle {index}")));
        }
        if let Contact::Friction(share) = options.contact
            && !(share >= 0.0 && share.is_finite())
        {
            return Err(Error::invalid(format!("{share} is no friction of a collider")).advise("use 0 or more"));
        }
        let joined = join(points);
        let has_area = |triangle: &&[u32; 3]| {
            let [a, b, c] = triangle.map(|point| points[joined[point as usize] as usize].as_dvec3());
            (b - a).cross(c - a).length_squared() > 0.0
        };
        let triangles: Vec<[u32; 3]> = triangles.iter().filter(has_area).copied().collect();
        if triangles.is_empty() {
            return Err(Error::invalid("no triangle of a collider has an area")
                .advise("give it a surface; `relievo mesh check FILE` lists the faces without area"));
        }
        let depth = match (volume(points, &triangles, &joined), options.is_container) {
            (None, _) => 0.0,
            (Some(volume), is_container) => {
                if (volume > 0.0) == is_container {
                    -0.5 * constants.spacing
                } else {
                    0.5 * constants.spacing
                }
            }
        };
        let mut collider = Self {
            options,
            paces: vec![Vec3::ZERO; points.len()],
            target: points.to_vec(),
            points: points.to_vec(),
            hierarchy: Hierarchy::default(),
            left: 0.0,
            depth,
            joined,
            samples: Vec::new(),
            masses: Vec::new(),
            lengths: Vec::new(),
            triangles,
        };
        collider.samples = sample(&collider.behind(points), &collider.triangles, constants.spacing)?;
        collider.lengths = collider.edges(points).collect();
        collider.weigh(context, constants)?;
        collider.bound();
        Ok(collider)
    }

    /// A triangle where it is and where it goes.
    pub fn shapes(&self, triangle: usize) -> [[Vec3; 3]; 2] {
        [&self.points, &self.target].map(|at| self.triangles[triangle].map(|point| at[point as usize]))
    }

    /// How many particles of walls it has.
    pub fn count(&self) -> usize {
        self.samples.len()
    }

    /// Its particles with their masses, and velocities.
    pub fn particles(&self) -> Vec<Vec4> {
        let behind = self.behind(&self.points);
        let places = self.samples.iter().map(|sample| sample.of(&behind, &self.triangles));
        places.zip(&self.masses).map(|(place, mass)| place.extend(*mass)).collect()
    }

    /// The velocities of its particles, in m/s.
    pub fn velocities(&self) -> Vec<Vec4> {
        if self.left <= 0.0 {
            return vec![Vec4::ZERO; self.count()];
        }
        let (from, to) = (self.behind(&self.points), self.behind(&self.target));
        let moved = |sample: &Sample| sample.of(&to, &self.triangles) - sample.of(&from, &self.triangles);
        self.samples.iter().map(|sample| (moved(sample) / self.left).extend(0.0)).collect()
    }

    /// Puts it elsewhere, or into another shape, from where it goes to a target within so many seconds; 0 is at rest.
    pub fn go(
        &mut self,
        context: &Context,
        constants: &Constants,
        [from, to]: [&[Vec3]; 2],
        seconds: f32,
    ) -> Result<()> {
        let count = self.points.len();
        if let Some(given) = [from.len(), to.len()].into_iter().find(|given| *given != count) {
            return Err(Error::invalid(format!("{given} points are given for a collider of {count}")));
        }
        check(from)?;
        check(to)?;
        if !(seconds >= 0.0 && seconds.is_finite()) {
            return Err(Error::invalid(format!("a collider cannot go anywhere in {seconds} s")));
        }
        self.points.copy_from_slice(from);
        self.target.copy_from_slice(if seconds > 0.0 { to } else { from });
        self.left = seconds;
        let pace = |(from, to): (&Vec3, &Vec3)| if seconds > 0.0 { (*to - *from) / seconds } else { Vec3::ZERO };
        self.paces = self.points.iter().zip(&self.target).map(pace).collect();
        let is_bent = |(now, then): (f32, &f32)| (now - then).abs() > BENT * then;
        if self.edges(from).zip(&self.lengths).any(is_bent) {
            self.weigh(context, constants)?;
        }
        self.bound();
        Ok(())
    }

    /// The seconds until it is where it goes; infinite at rest.
    pub fn left(&self) -> f32 {
        if self.left > 0.0 { self.left } else { f32::INFINITY }
    }

    /// Goes on by so many seconds, and returns whether it has come to rest.
    pub fn arrive(&mut self, seconds: f32) -> bool {
        if self.left <= 0.0 {
            return false;
        }
        self.points.iter_mut().zip(&self.paces).for_each(|(point, pace)| *point += seconds * *pace);
        self.left -= seconds;
        // What is left by rounding is no step.
        let is_there = self.left <= 1e-5 * seconds;
        if is_there {
            self.left = 0.0;
            self.points.clone_from(&self.target);
            self.paces.fill(Vec3::ZERO);
        }
        is_there
    }

    /// The speed of its fastest point, in m/s.
    pub fn speed(&self) -> f32 {
        self.paces.iter().map(|pace| pace.length_squared()).fold(0.0, f32::max).sqrt()
    }

    fn weigh(&mut self, context: &Context, constants: &Constants) -> Result<()> {
        let behind = self.behind(&self.points);
        let places: Vec<Vec3> = self.samples.iter().map(|sample| sample.of(&behind, &self.triangles)).collect();
        self.masses = weigh(context, constants, &places)?.into_iter().map(|place| place.w).collect();
        Ok(())
    }

    fn bound(&mut self) {
        let boxes: Vec<Bounds> = self
            .triangles
            .iter()
            .map(|triangle| {
                let ends = triangle.iter().flat_map(|point| [&self.points, &self.target].map(|at| at[*point as usize]));
                ends.map(Vec3A::from).fold(Bounds::NONE, |all, end| all.with(Bounds { low: end, high: end }))
            })
            .collect();
        self.hierarchy = Hierarchy::new(&boxes);
    }

    fn edges<'a>(&'a self, points: &'a [Vec3]) -> impl Iterator<Item = f32> + 'a {
        let at = |triangle: &[u32; 3], corner: usize| points[triangle[corner % 3] as usize];
        self.triangles
            .iter()
            .flat_map(move |triangle| [0, 1, 2].map(|side| at(triangle, side).distance(at(triangle, side + 1))))
    }

    /// The points, moved behind the surface so far that planes of triangles that meet there are as far from where they were.
    fn behind(&self, points: &[Vec3]) -> Vec<Vec3> {
        if self.depth == 0.0 {
            return points.to_vec();
        }
        let normals = self.triangles.iter().map(|triangle| {
            let [a, b, c] = triangle.map(|point| points[point as usize]);
            (b - a).cross(c - a).normalize_or_zero()
        });
        let normals: Vec<Vec3> = normals.collect();
        let mut sums = vec![Vec3::ZERO; points.len()];
        for (triangle, normal) in self.triangles.iter().zip(&normals) {
            for corner in 0..3 {
                let at = |side: usize| points[triangle[(corner + side) % 3] as usize];
                let angle = (at(1) - at(0)).angle_between(at(2) - at(0));
                // A side without a length has no angle.
                sums[self.joined[triangle[corner] as usize] as usize] +=
                    *normal * if angle.is_finite() { angle } else { 0.0 };
            }
        }
        sums.iter_mut().for_each(|sum| *sum = sum.normalize_or_zero());
        let mut least = vec![1.0f32; points.len()];
        for (triangle, normal) in self.triangles.iter().zip(&normals) {
            for point in triangle {
                let point = self.joined[*point as usize] as usize;
                least[point] = least[point].min(sums[point].dot(*normal));
            }
        }
        let moved = points.iter().zip(&self.joined).map(|(point, joined)| {
            let joined = *joined as usize;
            *point - self.depth / least[joined].max(1.0 / MITER) * sums[joined]
        });
        moved.collect()
    }
}

fn check(points: &[Vec3]) -> Result<()> {
    match points.iter().position(|point| !point.is_finite()) {
        None => Ok(()),
        Some(number) => Err(Error::invalid("a place is not finite").at(format!("point {number}"))),
    }
}

/// The first point at the place of each.
pub fn join(points: &[Vec3]) -> Vec<u32> {
    let mut first = HashMap::with_capacity(points.len());
    // Adding 0 makes −0 the same as 0.
    let key = |point: &Vec3| (*point + Vec3::ZERO).to_array().map(f32::to_bits);
    (0u32..).zip(points).map(|(number, point)| *first.entry(key(point)).or_insert(number)).collect()
}

/// Six times the volume within triangles, negative where they are wound inwards; none where they do not close, or are
/// wound against each other.
pub fn volume(points: &[Vec3], triangles: &[[u32; 3]], joined: &[u32]) -> Option<f64> {
    let mut edges: HashMap<[u32; 2], i32> = HashMap::new();
    for triangle in triangles {
        let corners = triangle.map(|point| joined[point as usize]);
        // One that is a line has no inside, and changes nothing where it is between others.
        if corners[0] == corners[1] || corners[1] == corners[2] || corners[2] == corners[0] {
            continue;
        }
        for side in 0..3 {
            let edge = [corners[side], corners[(side + 1) % 3]];
            // Each way of an edge occurs as often as the other.
            if edge[0] < edge[1] {
                *edges.entry(edge).or_default() += 1;
            } else {
                *edges.entry([edge[1], edge[0]]).or_default() -= 1;
            }
        }
    }
    let origin = points[triangles[0][0] as usize].as_dvec3();
    let six = triangles.iter().map(|triangle| {
        let [a, b, c] = triangle.map(|point| points[point as usize].as_dvec3() - origin);
        a.dot(b.cross(c))
    });
    let six: f64 = six.sum();
    (edges.values().all(|ways| *ways == 0) && six != 0.0).then_some(six)
}

#[cfg(test)]
mod tests;
