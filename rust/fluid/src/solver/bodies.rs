//! Walls and colliders of a fluid.

use glam::{DVec3, Vec3, Vec4, Vec4Swizzles};
use relievo_core::{Context, Error, Result};

use crate::boundary::collider::{Collider, ColliderOptions};
use crate::boundary::exchange::{Exchange, Given, Impulse, exchange};
use crate::boundary::wall::{Wall, weigh};
use crate::solver::Fluid;
use crate::solver::cells::Cells;
use crate::solver::pairs::Rows;

/// The distance from particles of walls at which there is room for fluid, in spacings: it rests at one.
const BESIDE: f32 = 0.9;

impl Fluid {
    /// Takes particles at these places as walls at rest, instead of the former ones.
    ///
    /// # Errors
    /// Fails if a place is not finite, places are too far from each other or from the origin, or more than 4,096
    /// particles are within the support radius of one.
    pub fn set_walls(&mut self, context: &Context, places: &[Vec3]) -> Result<()> {
        let walls = weigh(context, &self.constants, places)?;
        self.build(context, &walls)
    }

    /// Has walls be at other places and go on from there with velocities in m/s, in the order in which they were set,
    /// until told otherwise. Each counts as much as where it was set, so that shapes should stay about what they were.
    ///
    /// # Errors
    /// Fails if there are not as many places and velocities as walls, or a number is not finite.
    pub fn move_walls(&mut self, places: &[Vec3], velocities: &[Vec3]) -> Result<()> {
        let count = self.wall_count;
        if places.len() != count || velocities.len() != count {
            let (given, moved) = (places.len(), velocities.len());
            return Err(Error::invalid(format!("{given} places and {moved} velocities are given for {count} walls")));
        }
        if !places.iter().chain(velocities).all(|vector| vector.is_finite()) {
            return Err(Error::invalid("a place or velocity of a wall is not finite"));
        }
        let masses: Vec<f32> = self.wall.set()[..count].iter().map(|set| set.w).collect();
        let places = places.iter().zip(masses).map(|(place, mass)| place.extend(mass));
        self.wall.put(0, places, velocities.iter().map(|velocity| velocity.extend(0.0)));
        Ok(())
    }

    /// Those of some places, in metres, that have room beside walls and colliders where they are now: nine tenths of a
    /// spacing or more from all of their particles. Fluid that begins nearer is pushed away.
    ///
    /// # Errors
    /// Fails if a place is not finite, or walls are too far from each other or from the origin.
    pub fn beside_walls(&self, context: &Context, places: &[Vec3]) -> Result<Vec<Vec3>> {
        let radius = BESIDE * self.options.spacing;
        let set: Vec<Vec4> = self.wall.set().iter().map(|set| set.xyz().extend(0.0)).collect();
        let mut cells = Cells::default();
        cells.fill(context, radius, &set)?;
        let sorted: Vec<Vec3> = cells.order().map(|number| set[number as usize].xyz()).collect();
        if !places.iter().all(|place| place.is_finite()) {
            return Err(Error::invalid("a place of a particle is not finite"));
        }
        let is_free = context.map(places.len(), |at| {
            let near = cells.around(cells.cell(places[at])).flatten();
            !near.into_iter().any(|other| sorted[other].distance_squared(places[at]) < radius * radius)
        });
        Ok(places.iter().zip(is_free).filter(|(_, is_free)| *is_free).map(|(place, _)| *place).collect())
    }

    /// Adds a collider of points in metres and triangles of them, at rest, and returns its number. Triangles may be
    /// without an area, and the mesh may have holes, but then fluid is on both sides of it, and rests a spacing from
    /// it.
    ///
    /// # Errors
    /// Fails if a number is not finite, the friction is out of range, a point does not exist, no triangle has an area,
    /// the mesh is too large for the spacing, or it is too far from the origin or other walls.
    pub fn add_collider(
        &mut self,
        context: &Context,
        points: &[Vec3],
        triangles: &[[u32; 3]],
        options: ColliderOptions,
    ) -> Result<usize> {
        let number = self.colliders.len();
        let named = |error: Error| error.at(format!("collider {number}"));
        let collider = Collider::new(context, &self.constants, points, triangles, options).map_err(named)?;
        self.colliders.push(collider);
        let walls = self.wall.set()[..self.wall_count].to_vec();
        if let Err(error) = self.build(context, &walls) {
            self.colliders.pop();
            return Err(error);
        }
        Ok(number)
    }

    /// Has a collider go from points to others, in straight lines and within so many seconds from now on, where it
    /// stays; with 0 seconds it is at the first ones, at rest.
    ///
    /// # Errors
    /// Fails if there is no such collider, there are not as many finite points as it has, or the seconds are negative
    /// or not finite.
    pub fn move_collider(&mut self, context: &Context, number: usize, path: [&[Vec3]; 2], seconds: f32) -> Result<()> {
        let named = |error: Error| error.at(format!("collider {number}"));
        let collider = self.colliders.get_mut(number).ok_or_else(|| named(Error::invalid("it does not exist")))?;
        collider.go(context, &self.constants, path, seconds).map_err(named)?;
        self.follow(number);
        Ok(())
    }

    /// Where the points of a collider are now, in metres. Empty if there is no such collider.
    pub fn collider_points(&self, number: usize) -> &[Vec3] {
        self.colliders.get(number).map_or(&[], |collider| &collider.points)
    }

    /// Whether a particle does not stay for ever.
    pub(crate) fn is_mortal(&self) -> bool {
        self.particles.is_mortal()
    }

    /// The colliders, and the first particle of walls of each.
    pub(crate) fn obstacles(&self) -> (&[Collider], Vec<usize>) {
        (&self.colliders, self.groups().split_off(1))
    }

    /// What walls were given by the fluid in the last step, and then each collider.
    pub fn impulses(&self) -> &[Impulse] {
        &self.impulses
    }

    /// Takes these walls, and the particles of colliders, which go on as they move. Nothing has changed where it fails.
    fn build(&mut self, context: &Context, walls: &[Vec4]) -> Result<()> {
        let colliders = self.colliders.iter().flat_map(Collider::particles);
        let set = walls.iter().copied().chain(colliders).collect();
        self.wall = Wall::new(context, self.constants.kernels.support, set)?;
        self.wall_count = walls.len();
        (0..self.colliders.len()).for_each(|number| self.follow(number));
        Ok(())
    }

    /// The first particle of walls of each group: walls, then colliders.
    fn groups(&self) -> Vec<usize> {
        let counts = self.colliders.iter().map(Collider::count);
        let after = counts.scan(self.wall_count, |sum, count| {
            let first = *sum;
            *sum += count;
            Some(first)
        });
        std::iter::once(0).chain(after).collect()
    }

    /// Puts the particles of a collider where it is.
    fn follow(&mut self, number: usize) {
        let first = self.groups()[number + 1];
        let collider = &self.colliders[number];
        self.wall.put(first, collider.particles().into_iter(), collider.velocities().into_iter());
    }

    /// Finds what walls and colliders got in a step that is about to end, from all domains, and returns what all gave to the
    /// fluid. Fails if another domain has ended.
    pub(super) fn exchange(&mut self, context: &Context, seconds: f32) -> Result<Given> {
        let mut impulses = exchange(
            context,
            &Exchange {
                constants: self.constants,
                places: Rows { fluid: &self.particles.places, walls: &self.wall.places },
                velocities: Rows { fluid: &self.particles.velocities, walls: &self.wall.velocities },
                near: &self.near_walls,
                predicted: &self.predicted,
                numbers: &self.wall.numbers,
                groups: &self.groups(),
                seconds,
            },
        );
        for met in self.sweep.met() {
            let momentum = -f64::from(self.constants.mass) * met.change.as_dvec3();
            impulses[met.collider as usize + 1].add(met.place.as_dvec3(), momentum);
        }
        let each = f64::from(self.constants.mass) * f64::from(seconds);
        let is_own = |row: usize| !self.domain.ghosts().get(row).is_some_and(|ghost| *ghost);
        let owned = (0..self.len()).filter(|row| is_own(*row)).count();
        let pushes = self.particles.pushes.iter().take(if self.particles.is_pushed { self.len() } else { 0 });
        let pushes = pushes.enumerate().filter(|(row, _)| is_own(*row));
        let pushes: DVec3 = pushes.map(|(_, push)| push.xyz().as_dvec3()).sum();
        let mut given = Given {
            gravity: each * owned as f64 * self.options.gravity.as_dvec3(),
            host: each * pushes,
            forces: each * self.forced,
            walls: -impulses.iter().map(|impulse| impulse.linear).sum::<DVec3>(),
        };
        let vectors = impulses.iter_mut().flat_map(|impulse| [&mut impulse.linear, &mut impulse.angular]);
        self.domain.sum_vectors(vectors.chain([
            &mut given.gravity,
            &mut given.host,
            &mut given.forces,
            &mut given.walls,
        ]))?;
        self.impulses = impulses;
        Ok(given)
    }

    /// Has walls and colliders go on by so many seconds.
    pub(super) fn carry(&mut self, seconds: f32) {
        self.wall.arrive(seconds);
        for number in 0..self.colliders.len() {
            if self.colliders[number].arrive(seconds) {
                self.follow(number);
            }
        }
    }

    /// The seconds until a collider is where it goes.
    pub(super) fn until_arrival(&self) -> f32 {
        self.colliders.iter().map(Collider::left).fold(f32::INFINITY, f32::min)
    }
}
