//! Rigid bodies on control cages or simpler stand-ins, with rapier3d (Schäfer et al. 2014, Real-Time Deformation of
//! Subdivision Surfaces from Object Collisions, Section 4). Fine detail does not feed back: bodies meet the
//! undisplaced shapes, made smaller by their `inset`, which is how far they sink into what they rest on.
//!
//! Steps have a fixed length and bodies are inserted in the order of the file, so a run repeats itself exactly.
//! Lengths are in scene units, angles in radians, masses in kilograms.

use glam::{DAffine3, DMat3, DQuat, DVec3, Vec3};
use rapier3d::prelude::{
    Array2, Collider, ColliderBuilder, LockedAxes, PhysicsWorld, Pose, Real, RigidBody, RigidBodyBuilder,
    RigidBodyHandle, Rotation, Vector,
};
use relievo_core::Mesh;

use crate::format::description::{BodyEntry, Mass, Motion, Scene, StandIn};
use crate::format::diagnostic::Diagnostic;
use crate::format::placement::Up;
use crate::state::keyframe::placement_at;

/// The bodies of a scene on their way through time.
pub struct Physics {
    world: PhysicsWorld,
    bodies: Vec<Body>,
    /// Scale and, without a body, place of every object.
    rest: Vec<crate::format::description::Placement>,
    steps: u64,
    sub_steps: u32,
    fps: f64,
}

struct Body {
    object: usize,
    handle: Option<RigidBodyHandle>,
    entry: BodyEntry,
}

impl std::fmt::Debug for Physics {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        out.debug_struct("Physics")
            .field("bodies", &self.bodies.len())
            .field("steps", &self.steps)
            .finish_non_exhaustive()
    }
}

fn vector(v: DVec3) -> Vector {
    Vector::new(v.x as Real, v.y as Real, v.z as Real)
}

fn pose(translation: DVec3, rotation: DQuat) -> Pose {
    let turn = Rotation::from_xyzw(rotation.x as Real, rotation.y as Real, rotation.z as Real, rotation.w as Real);
    Pose::from_parts(vector(translation), turn.normalize())
}

impl Physics {
    /// The bodies of `scene` at time 0. `cages` has the control cage of every object, in its own coordinates.
    ///
    /// # Errors
    /// Fails, with the place of the body in the scene, if its stand-in cannot be made of the cage, or it has none and
    /// is to be moved by forces.
    pub fn new(scene: &Scene, cages: &[&Mesh]) -> Result<Self, Diagnostic> {
        let mut world = PhysicsWorld { gravity: vector(scene.physics.gravity), ..PhysicsWorld::default() };
        world.integration_parameters.dt = (1.0 / (scene.fps * f64::from(scene.physics.sub_steps))) as Real;
        world.integration_parameters.length_unit = (1.0 / scene.metres) as Real;
        let mut bodies = Vec::new();
        for entry in &scene.bodies {
            let (Some(object), Some(cage)) = (scene.objects.get(entry.object), cages.get(entry.object)) else {
                continue;
            };
            let start = placement_at(&entry.keyframes, 0.0).unwrap_or(object.placement);
            let handle = match stand_in(entry, cage, &start.stretch(), scene.up)? {
                None if entry.motion == Motion::Dynamic => {
                    return Err(Diagnostic::new(
                        entry.name.span.clone(),
                        "a body without a shape cannot be moved by forces",
                    )
                    .advise("give it a `shape`, or keyframes"));
                }
                None => None,
                Some(collider) => {
                    let body = rigid_body(entry).pose(pose(start.translation, start.quaternion()));
                    Some(world.insert(body, collider).0)
                }
            };
            bodies.push(Body { object: entry.object, handle, entry: entry.clone() });
        }
        let rest = scene.objects.iter().map(|object| object.placement).collect();
        Ok(Self { world, bodies, rest, steps: 0, sub_steps: scene.physics.sub_steps, fps: scene.fps })
    }

    /// The transforms of all objects now.
    pub fn transforms(&self) -> Vec<DAffine3> {
        let mut all: Vec<DAffine3> = self.rest.iter().map(|placement| placement.transform()).collect();
        for body in &self.bodies {
            let Some(slot) = all.get_mut(body.object) else { continue };
            let keyed = placement_at(&body.entry.keyframes, self.time());
            let moved = body.handle.and_then(|handle| self.world.bodies.get(handle));
            *slot = match (keyed, moved) {
                (Some(placement), _) => placement.transform(),
                (None, Some(rigid)) => {
                    let place = rigid.position();
                    let (at, turn) = (place.translation, place.rotation);
                    let turn = DQuat::from_array(turn.to_array().map(f64::from)).normalize();
                    let at = DVec3::from_array(at.to_array().map(f64::from));
                    DAffine3 { matrix3: DMat3::from_quat(turn) * self.rest[body.object].stretch(), translation: at }
                }
                (None, None) => *slot,
            };
        }
        all
    }

    /// The frame that the bodies have reached.
    pub fn frame(&self) -> u32 {
        (self.steps / u64::from(self.sub_steps)) as u32
    }

    /// Seconds since the start.
    pub fn time(&self) -> f64 {
        self.steps as f64 / (self.fps * f64::from(self.sub_steps))
    }

    /// Goes on by one frame. Returns the transforms of all objects after every sub-step; the last are the new frame's.
    pub fn advance(&mut self) -> Vec<Vec<DAffine3>> {
        (0..self.sub_steps)
            .map(|_| {
                self.step();
                self.transforms()
            })
            .collect()
    }

    fn step(&mut self) {
        self.steps += 1;
        let time = self.time();
        for body in &self.bodies {
            let Some(rigid) = body.handle.and_then(|handle| self.world.bodies.get_mut(handle)) else { continue };
            if let Some(placement) = placement_at(&body.entry.keyframes, time) {
                rigid.set_next_kinematic_position(pose(placement.translation, placement.quaternion()));
            } else if body.entry.motion == Motion::Dynamic {
                push(rigid, &body.entry, self.world.integration_parameters.dt);
            }
        }
        self.world.step();
    }
}

/// Applies the forces of one step.
fn push(rigid: &mut RigidBody, entry: &BodyEntry, dt: Real) {
    rigid.reset_forces(true);
    rigid.reset_torques(true);
    rigid.add_force(vector(entry.force), true);
    let mut torque = vector(entry.torque);
    if let Some(motor) = entry.motor {
        let axis = rigid.rotation().mul_vec3(vector(motor.axis));
        // The torque that reaches the wanted speed in one step, as far as the motor can.
        let inertia = axis.dot(effective_inertia(rigid, axis));
        let missing = motor.speed as Real - rigid.angvel().dot(axis);
        let wanted = inertia * missing / dt;
        torque += axis * wanted.clamp(-motor.torque as Real, motor.torque as Real);
    }
    rigid.add_torque(torque, true);
}

/// The inertia tensor of `rigid` times `axis`.
fn effective_inertia(rigid: &RigidBody, axis: Vector) -> Vector {
    let local = rigid.mass_properties().local_mprops.principal_inertia();
    let frame = *rigid.rotation() * rigid.mass_properties().local_mprops.principal_inertia_local_frame;
    frame.mul_vec3(frame.inverse().mul_vec3(axis) * local)
}

fn rigid_body(entry: &BodyEntry) -> RigidBodyBuilder {
    let builder = match entry.motion {
        Motion::Fixed => RigidBodyBuilder::fixed(),
        Motion::Keyframed => RigidBodyBuilder::kinematic_position_based(),
        Motion::Dynamic => RigidBodyBuilder::dynamic()
            .linvel(vector(entry.velocity))
            .angvel(vector(entry.angular_velocity))
            .linear_damping(entry.damping as Real)
            .angular_damping(entry.angular_damping as Real)
            .allow_fast_rotation(true)
            .ccd_enabled(true),
    };
    let mut locked = LockedAxes::empty();
    for (is_locked, axis) in entry.locked.iter().zip([
        LockedAxes::TRANSLATION_LOCKED_X,
        LockedAxes::TRANSLATION_LOCKED_Y,
        LockedAxes::TRANSLATION_LOCKED_Z,
        LockedAxes::ROTATION_LOCKED_X,
        LockedAxes::ROTATION_LOCKED_Y,
        LockedAxes::ROTATION_LOCKED_Z,
    ]) {
        if *is_locked {
            locked |= axis;
        }
    }
    builder.locked_axes(locked).can_sleep(false)
}

/// What physics sees of a body, in the body's coordinates with its scale and shear.
fn stand_in(entry: &BodyEntry, cage: &Mesh, stretch: &DMat3, up: Up) -> Result<Option<Collider>, Diagnostic> {
    let refuse = |what: &str, remedy: &str| {
        Diagnostic::new(entry.name.span.clone(), format!("body `{}`: {what}", entry.name.text)).advise(remedy)
    };
    let points: Vec<DVec3> =
        cage.points.iter().map(|point| *stretch * DVec3::from_array(point.map(f64::from))).collect();
    let low = points.iter().copied().reduce(DVec3::min).unwrap_or(DVec3::ZERO);
    let high = points.iter().copied().reduce(DVec3::max).unwrap_or(DVec3::ZERO);
    let (centre, half) = ((low + high) * 0.5, (high - low) * 0.5);
    let inset = entry.inset;
    let thin = || refuse("`inset` leaves nothing of it", "use a smaller `inset`");
    let builder = match entry.stand_in {
        StandIn::None => return Ok(None),
        StandIn::Ball => {
            let radius = entry.radius.unwrap_or(half.min_element()) - inset;
            if radius <= 0.0 {
                return Err(thin());
            }
            ColliderBuilder::ball(radius as Real).translation(vector(centre))
        }
        StandIn::Box => {
            let half = half - DVec3::splat(inset);
            if half.min_element() <= 0.0 {
                return Err(thin());
            }
            ColliderBuilder::cuboid(half.x as Real, half.y as Real, half.z as Real).translation(vector(centre))
        }
        StandIn::Cylinder => {
            // Its axis is the one whose two other sides are most alike.
            let ratio = |axis: usize| {
                let (a, b) = (half[(axis + 1) % 3], half[(axis + 2) % 3]);
                a.max(b) / a.min(b).max(1e-12)
            };
            let axis = (0..3).min_by(|a, b| ratio(*a).total_cmp(&ratio(*b))).unwrap_or(0);
            let round = (half[(axis + 1) % 3] + half[(axis + 2) % 3]) * 0.5;
            let radius = entry.radius.unwrap_or(round) - inset;
            if radius <= 0.0 || half[axis] <= 0.0 {
                return Err(thin());
            }
            let turn = DQuat::from_rotation_arc(DVec3::Y, DVec3::AXES[axis]);
            ColliderBuilder::cylinder(half[axis] as Real, radius as Real).position(pose(centre, turn))
        }
        StandIn::Convex => {
            let inner: Vec<Vector> = points
                .iter()
                .map(|point| {
                    let away = *point - centre;
                    let length = away.length();
                    vector(centre + away * ((length - inset).max(0.0) / length.max(1e-12)))
                })
                .collect();
            if inset >= half.min_element() {
                return Err(thin());
            }
            ColliderBuilder::convex_hull(&inner).ok_or_else(|| {
                refuse("its mesh is flat, so it has no convex hull", "use `shape = \"trimesh\"` or `\"box\"`")
            })?
        }
        StandIn::TriMesh => {
            let inner: Vec<Vector> =
                inset_along_normals(cage, &points, inset).into_iter().map(|point| vector(point.as_dvec3())).collect();
            ColliderBuilder::trimesh(inner, cage.triangles())
                .map_err(|error| refuse(&format!("physics cannot use its mesh: {error}"), "use `convex` or `box`"))?
        }
        StandIn::HeightField => {
            let inner = inset_along_normals(cage, &points, inset);
            height_field(cage, &inner, up).ok_or_else(|| {
                refuse("its mesh is no height field", "use a mesh without holes or overhangs, or `trimesh`")
            })?
        }
    };
    let builder = match entry.mass {
        _ if entry.motion != Motion::Dynamic => builder,
        Mass::Total(mass) => builder.mass(mass as Real),
        Mass::Density(density) => builder.density(density as Real),
    };
    Ok(Some(builder.friction(entry.friction as Real).restitution(entry.restitution as Real).build()))
}

/// The points moved inwards by `inset`, against the average of the normals around them.
fn inset_along_normals(cage: &Mesh, points: &[DVec3], inset: f64) -> Vec<Vec3> {
    let mut normals = vec![DVec3::ZERO; points.len()];
    for triangle in cage.triangles() {
        let [a, b, c] = triangle.map(|corner| points[corner as usize]);
        let normal = (b - a).cross(c - a);
        triangle.iter().for_each(|corner| normals[*corner as usize] += normal);
    }
    points.iter().zip(normals).map(|(point, normal)| (*point - normal.normalize_or_zero() * inset).as_vec3()).collect()
}

/// A height field of about as many cells as the cage has faces; `None` if the cage leaves a gap in its rectangle.
fn height_field(cage: &Mesh, points: &[Vec3], up: Up) -> Option<ColliderBuilder> {
    // rapier's height fields have y up; `flat` is (x, −z, y) of that frame.
    let basis = [Vec3::X, Vec3::Y, Vec3::Z].map(|axis| Vec3::from(up.from_z_up([axis.x, -axis.z, axis.y])));
    let local: Vec<Vec3> =
        points.iter().map(|p| Vec3::new(p.dot(basis[0]), p.dot(basis[1]), p.dot(basis[2]))).collect();
    let low = local.iter().copied().reduce(Vec3::min)?;
    let high = local.iter().copied().reduce(Vec3::max)?;
    let side = high - low;
    let cells = ((cage.face_count() as f64).sqrt().ceil() as usize).clamp(2, 1024);
    let samples = cells + 1;
    let mut heights = vec![Real::NAN; samples * samples];
    let step = Vec3::new(side.x, 1.0, side.z) / cells as f32;
    if step.x <= 0.0 || step.z <= 0.0 {
        return None;
    }
    for triangle in cage.triangles() {
        let [a, b, c] = triangle.map(|corner| local[corner as usize]);
        let (from, to) = (a.min(b).min(c), a.max(b).max(c));
        let first = ((from - low) / step).floor().max(Vec3::ZERO);
        let last = ((to - low) / step).ceil().min(Vec3::splat(cells as f32));
        let area = (b.x - a.x) * (c.z - a.z) - (b.z - a.z) * (c.x - a.x);
        if area.abs() < 1e-20 {
            continue;
        }
        for row in first.z as usize..=last.z as usize {
            for column in first.x as usize..=last.x as usize {
                let (x, z) = (low.x + column as f32 * step.x, low.z + row as f32 * step.z);
                let wb = ((x - a.x) * (c.z - a.z) - (z - a.z) * (c.x - a.x)) / area;
                let wc = ((b.x - a.x) * (z - a.z) - (b.z - a.z) * (x - a.x)) / area;
                // A little slack, since samples fall on edges and on the rim.
                if wb >= -1e-3 && wc >= -1e-3 && wb + wc <= 1.0 + 1e-3 {
                    let height = a.y + wb * (b.y - a.y) + wc * (c.y - a.y);
                    let slot = heights.get_mut(column * samples + row)?;
                    *slot = slot.max(height);
                }
            }
        }
    }
    if heights.iter().any(|height| height.is_nan()) {
        return None;
    }
    let centre = (low + high) * 0.5;
    let at = basis[0] * centre.x + basis[2] * centre.z;
    let turn =
        glam::DQuat::from_mat3(&glam::DMat3::from_cols(basis[0].as_dvec3(), basis[1].as_dvec3(), basis[2].as_dvec3()));
    let grid = Array2::new(samples, samples, heights);
    Some(ColliderBuilder::heightfield(grid, Vector::new(side.x, 1.0, side.z)).position(pose(at.as_dvec3(), turn)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    fn scene(text: &str) -> (Scene, Vec<Mesh>) {
        let scene = crate::format::file::parse(Path::new("a.toml"), text).unwrap_or_else(|faults| panic!("{faults}"));
        let cages = scene
            .objects
            .iter()
            .map(|object| match &scene.meshes[scene.cage_of(object)].source {
                crate::format::description::MeshSource::Shape(shape) => shape.mesh(scene.up),
                other => panic!("{other:?}"),
            })
            .collect();
        (scene, cages)
    }

    fn run(text: &str, frames: u32) -> Vec<DAffine3> {
        let (scene, cages) = scene(text);
        let cages: Vec<&Mesh> = cages.iter().collect();
        let mut physics = Physics::new(&scene, &cages).unwrap();
        for _ in 0..frames {
            physics.advance();
        }
        physics.transforms()
    }

    const FALL: &str = r#"version = 1
up = "UP"
[meshes.ground]
shape = "terrain"
size = [8, 8, 0.01]
faces = 10
[meshes.ball]
shape = "sphere"
[surfaces.ground]
mesh = "ground"
[objects.ground]
surface = "ground"
[objects.ball]
mesh = "ball"
translation = START
[bodies.ground]
motion = "fixed"
shape = "GROUND"
[bodies.ball]
shape = "ball"
inset = 0.1
"#;

    #[test]
    fn a_ball_falls_and_rests_as_deep_as_its_inset_on_every_ground_and_axis() {
        for (up, start, axis) in [("x", "[2, 0.3, 0]", 0), ("y", "[0.3, 2, 0]", 1), ("z", "[0, 0.3, 2]", 2)] {
            for ground in ["trimesh", "heightfield"] {
                let text = FALL.replace("UP", up).replace("START", start).replace("GROUND", ground);
                let height = run(&text, 72)[1].translation[axis];
                assert!((height - 0.4).abs() < 0.03, "{up} {ground}: {height}");
            }
        }
    }

    #[test]
    fn free_fall_follows_gravity() {
        let text = FALL.replace("UP", "z").replace("START", "[0, 0, 100]").replace("GROUND", "trimesh");
        let fallen = 100.0 - run(&text, 24)[1].translation.z;
        assert!((fallen - 9.81 / 2.0).abs() < 0.03, "{fallen}");
    }

    #[test]
    fn a_motor_drives_a_wheel_and_runs_repeat_exactly() {
        let text = r#"version = 1
[meshes.ground]
shape = "plane"
size = [40, 40, 1]
[meshes.wheel]
shape = "wheel"
[objects.ground]
mesh = "ground"
[objects.wheel]
mesh = "wheel"
translation = [0, 0, 0.5]
[bodies.ground]
motion = "fixed"
shape = "trimesh"
[bodies.wheel]
shape = "cylinder"
radius = 0.5
mass = 10
motor_axis = [0, 1, 0]
motor_speed = 180
motor_torque = 40
locked = ["rx", "rz"]
"#;
        let end = run(text, 48);
        // Half a turn per second: about π·0.5 units in a second.
        let way = end[1].translation.x;
        assert!((2.0..3.3).contains(&way), "{way}");
        assert!((end[1].translation.z - 0.5).abs() < 0.01);
        assert_eq!(end, run(text, 48));
    }

    #[test]
    fn a_stand_in_that_cannot_be_made_is_said() {
        let text = FALL.replace("UP", "z").replace("START", "[0, 0, 2]").replace("GROUND", "trimesh");
        let (scene, cages) = scene(&text.replace("inset = 0.1", "inset = 0.5"));
        let cages: Vec<&Mesh> = cages.iter().collect();
        let fault = Physics::new(&scene, &cages).unwrap_err();
        assert!(fault.what.contains("body `ball`") && fault.remedy.contains("smaller"), "{fault:?}");
    }
}
