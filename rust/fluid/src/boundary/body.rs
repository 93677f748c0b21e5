//! Rigid bodies that a fluid moves, and that move it: colliders with a mass, whose motion is rapier3d's.
//!
//! Bodies and fluid take turns (Akinci et al. 2012, Section 3.3): a body moves by what it was given so far, for as long as the
//! fluid's next step, and the fluid is simulated while it moves. A body that is lighter than the fluid around it would be
//! thrown to and fro by that, as what it is given lags behind. So it gets a share of what is due at a time, and the rest
//! later; none is lost.
//!
//! rapier3d's world is made anew whenever fluid and bodies are to advance, of where bodies are and how they move. What it
//! keeps from step to step beside that, such as contacts, is no part of a state then, and a run that goes on from states
//! is to the bit what it would have been.

use glam::{Quat, Vec3};
use rapier3d::prelude::{ColliderBuilder, PhysicsWorld, RigidBodyBuilder, RigidBodyHandle, SharedShape, Vector};
use relievo_core::{Context, Error, Result};

use crate::boundary::body_state::{BodyOptions, BodyState};
use crate::boundary::obstacle::{Obstacle, placed, vector};
use crate::solver::pace::within;
use crate::{ColliderOptions, Fluid, Solid, StepStatistics};

/// The share of what is due that a body gets before a step.
const SHARE: f64 = 0.3;
/// What is left of a time by rounding, as a share of a step.
const ROUNDING: f32 = 1e-5;

struct Body {
    shape: SharedShape,
    /// kg
    mass: f32,
    /// The number of its collider.
    collider: usize,
    /// Its points at first.
    points: Vec<Vec3>,
    state: BodyState,
}

/// The rigid bodies of a fluid. They meet each other as their convex hulls, obstacles, and the sides of a box.
pub struct Bodies {
    gravity: Vec3,
    sides: Option<[Vec3; 2]>,
    bodies: Vec<Body>,
    obstacles: Vec<Obstacle>,
}

/// Bodies and obstacles while they advance.
struct World {
    physics: PhysicsWorld,
    bodies: Vec<RigidBodyHandle>,
    /// The rigid ones.
    obstacles: Vec<Option<RigidBodyHandle>>,
    /// Triangles of the others, of one step.
    pieces: Vec<RigidBodyHandle>,
    /// How much of their way obstacles have gone.
    share: f32,
    /// Seconds until bodies are where they go.
    left: f32,
}

impl Bodies {
    /// None, with an acceleration by gravity in m/s² and, if there is one, the box that they do not leave, by its corners.
    pub fn new(gravity: Vec3, sides: Option<[Vec3; 2]>) -> Self {
        Self { gravity, sides, bodies: Vec::new(), obstacles: Vec::new() }
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.bodies.len()
    }

    /// Whether it has no body.
    pub fn is_empty(&self) -> bool {
        self.bodies.is_empty()
    }

    /// Adds a body of points in metres and triangles of them, as a collider of the fluid, and returns its number.
    ///
    /// # Errors
    /// Fails if the density or a velocity is out of range, the mesh does not close or has no volume, or as
    /// [`Fluid::add_collider`].
    pub fn add(
        &mut self,
        context: &Context,
        fluid: &mut Fluid,
        (points, triangles): (&[Vec3], &[[u32; 3]]),
        options: &BodyOptions,
    ) -> Result<usize> {
        let number = self.bodies.len();
        let named = |error: Error| error.at(format!("body {number}"));
        let BodyOptions { density, velocity, spin, contact } = *options;
        if !(density > 0.0 && density < 1e9 && velocity.is_finite() && spin.is_finite()) {
            return Err(named(
                Error::invalid("its density or a velocity is out of range").advise("use 1000 for water"),
            ));
        }
        let volume = Solid::new(points, triangles).map_err(named)?.volume();
        let hull: Vec<Vector> = points.iter().map(|point| vector(*point)).collect();
        let (Some(volume), Some(hull)) = (volume, ColliderBuilder::convex_hull(&hull)) else {
            return Err(named(
                Error::invalid("it has no volume")
                    .advise("close the holes of its mesh: `relievo mesh repair FILE -o FILE`, or rlv_repair_mesh"),
            ));
        };
        let collider = fluid
            .add_collider(context, points, triangles, ColliderOptions { contact, is_container: false })
            .map_err(named)?;
        let state = BodyState { velocity, spin, ..BodyState::default() };
        let mass = density * volume as f32;
        self.bodies.push(Body { shape: hull.shape, mass, collider, points: points.to_vec(), state });
        Ok(number)
    }

    /// Adds a mesh that bodies do not pass, where it is, and returns its number.
    ///
    /// # Errors
    /// Fails if rapier3d cannot make a triangle mesh of it.
    pub fn add_obstacle(&mut self, points: &[Vec3], triangles: &[[u32; 3]]) -> Result<usize> {
        let number = self.obstacles.len();
        self.obstacles.push(Obstacle::new(points, triangles).map_err(|error| error.at(format!("obstacle {number}")))?);
        Ok(number)
    }

    /// Has an obstacle go from a pose to another while [`Self::advance`] is called next: turned about the origin from
    /// where it was added, and then moved by so many metres.
    ///
    /// # Errors
    /// Fails if there is no such obstacle, a turn is not of length 1, or a number is not finite.
    pub fn move_obstacle(&mut self, number: usize, path: [(Quat, Vec3); 2]) -> Result<()> {
        self.obstacle(number)
            .and_then(|obstacle| obstacle.go(path))
            .map_err(|error| error.at(format!("obstacle {number}")))
    }

    /// Has an obstacle go from points in metres to others, in straight lines, while [`Self::advance`] is called next.
    /// Bodies meet its triangles with their velocities, but for what they stretch.
    ///
    /// # Errors
    /// Fails if there is no such obstacle, or there are not as many finite points as it has.
    pub fn bend_obstacle(&mut self, number: usize, path: [&[Vec3]; 2]) -> Result<()> {
        self.obstacle(number)
            .and_then(|obstacle| obstacle.bend(path))
            .map_err(|error| error.at(format!("obstacle {number}")))
    }

    fn obstacle(&mut self, number: usize) -> Result<&mut Obstacle> {
        self.obstacles.get_mut(number).ok_or_else(|| Error::invalid("it does not exist"))
    }

    /// Where a body is: how it is turned about the origin from where it began, and by how many metres it has moved then.
    /// `None` if there is no such body.
    pub fn pose(&self, number: usize) -> Option<(Quat, Vec3)> {
        Some(self.bodies.get(number)?.state.pose)
    }

    /// All that bodies go on from, in the order in which they were added.
    pub fn states(&self) -> Vec<BodyState> {
        self.bodies.iter().map(|body| body.state).collect()
    }

    /// Goes on from states.
    ///
    /// # Errors
    /// Fails if there are not as many states as bodies, a turn is not of length 1, or a number is not finite; nothing
    /// has changed then.
    pub fn set_states(&mut self, states: &[BodyState]) -> Result<()> {
        if states.len() != self.bodies.len() {
            let (given, count) = (states.len(), self.bodies.len());
            return Err(Error::invalid(format!("{given} states are given for {count} bodies")));
        }
        if let Some(number) = states.iter().position(|state| !state.is_sound()) {
            return Err(Error::invalid("its state is out of range").at(format!("body {number}")));
        }
        self.bodies.iter_mut().zip(states).for_each(|(body, state)| body.state = *state);
        Ok(())
    }

    /// Simulates a fluid and its bodies for so many seconds, and calls `watch` after each step of the fluid.
    ///
    /// # Errors
    /// Fails as [`Fluid::move_collider`] where a body has gone to places that are not finite, as [`Fluid::step`], and
    /// with the error that `watch` returns.
    pub fn advance(
        &mut self,
        context: &Context,
        fluid: &mut Fluid,
        seconds: f32,
        mut watch: impl FnMut(&mut Fluid, &StepStatistics) -> Result<()>,
    ) -> Result<()> {
        let mut world = self.world();
        for body in &self.bodies {
            let points = body.at(body.state.pose);
            fluid.move_collider(context, body.collider, [&points, &points], 0.0)?;
        }
        let mut left = seconds;
        while left > 1e-6 * seconds {
            if world.left <= 0.0 {
                let step = within(fluid.time_step(), left);
                self.go(context, fluid, &mut world, step, 1.0 - (left - step) / seconds)?;
            }
            let done = fluid.step(context, world.left.min(left))?;
            for (body, handle) in self.bodies.iter_mut().zip(&world.bodies) {
                let given = fluid.impulses()[body.collider + 1];
                let middle = world.physics.bodies.get(*handle).map_or(Vector::ZERO, |rigid| rigid.center_of_mass());
                let middle = Vec3::from_array(middle.to_array()).as_dvec3();
                body.state.due[0] += given.linear;
                body.state.due[1] += given.angular - middle.cross(given.linear);
            }
            left -= done.seconds;
            world.left -= done.seconds;
            if world.left <= ROUNDING * done.seconds {
                world.left = 0.0;
            }
            watch(fluid, &done)?;
        }
        Ok(())
    }

    /// The world as it is now.
    fn world(&self) -> World {
        let mut physics = PhysicsWorld { gravity: vector(self.gravity), ..PhysicsWorld::default() };
        for (at, inner) in self.sides.into_iter().flat_map(|[low, high]| [(low, 1.0), (high, -1.0)]) {
            for axis in Vec3::AXES {
                let side = RigidBodyBuilder::fixed().translation(vector(at));
                // A half space is a plane that is solid behind.
                let normal = vector(inner * axis);
                physics.insert(side, ColliderBuilder::new(SharedShape::halfspace(normal)));
            }
        }
        let obstacles = self.obstacles.iter().map(|obstacle| obstacle.insert(&mut physics)).collect();
        let bodies = self.bodies.iter().map(|Body { shape, mass, state, .. }| {
            let rigid = RigidBodyBuilder::dynamic().pose(placed(state.pose)).can_sleep(false);
            let rigid = rigid.linvel(vector(state.velocity)).angvel(vector(state.spin));
            let (handle, _) = physics.insert(rigid, ColliderBuilder::new(shape.clone()).mass(*mass));
            // Impulses come before the first step, which would find the mass.
            if let Some(rigid) = physics.bodies.get_mut(handle) {
                rigid.recompute_mass_properties_from_colliders(&physics.colliders);
            }
            handle
        });
        let bodies = bodies.collect();
        World { physics, bodies, obstacles, pieces: Vec::new(), share: 0.0, left: 0.0 }
    }

    /// Moves bodies by what they were given, and has their colliders follow within so many seconds, after which obstacles
    /// have gone so much of their way.
    fn go(&mut self, context: &Context, fluid: &mut Fluid, world: &mut World, seconds: f32, share: f32) -> Result<()> {
        let physics = &mut world.physics;
        world.pieces.drain(..).for_each(|piece| drop(physics.remove_body(piece)));
        let boxes: Vec<[Vec3; 2]> = self.bodies.iter().map(|body| body.reach(seconds)).collect();
        for (obstacle, handle) in self.obstacles.iter().zip(&world.obstacles) {
            let rigid = handle.and_then(|handle| physics.bodies.get_mut(handle));
            if let (Some(rigid), Some(pose)) = (rigid, obstacle.pose(share)) {
                rigid.set_next_kinematic_position(pose);
            }
            let pieces = obstacle.pieces([world.share, share], seconds, &boxes).into_iter();
            world.pieces.extend(pieces.map(|(rigid, collider)| physics.insert(rigid, collider).0));
        }
        world.share = share;
        for (body, handle) in self.bodies.iter_mut().zip(&world.bodies) {
            let Some(rigid) = physics.bodies.get_mut(*handle) else { continue };
            let due = &mut body.state.due;
            let [push, turn] = due.map(|due| vector((SHARE * due).as_vec3()));
            *due = due.map(|due| (1.0 - SHARE) * due);
            rigid.apply_impulse(push, true);
            rigid.apply_torque_impulse(turn, true);
        }
        physics.integration_parameters.dt = seconds;
        physics.step();
        for (body, handle) in self.bodies.iter_mut().zip(&world.bodies) {
            let Some(rigid) = physics.bodies.get(*handle) else { continue };
            let (position, ours) = (rigid.position(), |v: Vector| Vec3::from_array(v.to_array()));
            let turn = Quat::from_array(position.rotation.to_array()).normalize();
            body.state.pose = (turn, ours(position.translation));
            (body.state.velocity, body.state.spin) = (ours(rigid.linvel()), ours(rigid.angvel()));
            let from = fluid.collider_points(body.collider).to_vec();
            fluid.move_collider(context, body.collider, [&from, &body.at(body.state.pose)], seconds)?;
        }
        world.left = seconds;
        Ok(())
    }
}

impl Body {
    /// Its points in a pose.
    fn at(&self, (turn, moved): (Quat, Vec3)) -> Vec<Vec3> {
        self.points.iter().map(|point| turn * *point + moved).collect()
    }

    /// The low and high corner of a box that it does not leave within so many seconds, with something to spare for what
    /// makes it faster.
    fn reach(&self, seconds: f32) -> [Vec3; 2] {
        let points = self.at(self.state.pose);
        let low = points.iter().fold(Vec3::INFINITY, |low, point| low.min(*point));
        let high = points.iter().fold(Vec3::NEG_INFINITY, |high, point| high.max(*point));
        let size = low.distance(high);
        let spare = 0.1 * size + 2.0 * seconds * (self.state.velocity.length() + size * self.state.spin.length());
        [low - spare, high + spare]
    }
}
