//! Colliders of fluids on a graphics device, against the processor's.

use glam::{Quat, Vec3, Vec4, Vec4Swizzles};
use relievo_core::Context;
use relievo_fluid::{ColliderOptions, Contact, DeviceFluid, Fluid, FluidOptions, State, TimeStep, block, cuboid};
use relievo_testing::device;

const SPACING: f32 = 0.05;
const SIZE: Vec3 = Vec3::new(0.6, 0.3, 0.6);
const HALF: Vec3 = Vec3::new(0.02, 0.07, 0.09);

/// Fluid in a box that it is inside of, and a board that turns and goes to and fro.
struct Stirred {
    fluid: Fluid,
    board: usize,
}

impl Stirred {
    fn new(contact: Contact, options: FluidOptions) -> Self {
        let context = Context::serial();
        let mut fluid = Fluid::new(FluidOptions { spacing: SPACING, ..options }).unwrap();
        fluid.add(&block(Vec3::ZERO, Vec3::new(0.6, 0.3, 0.2), SPACING).unwrap(), Vec3::ZERO).unwrap();
        let (points, triangles) = cuboid(Vec3::ZERO, SIZE);
        let container = ColliderOptions { contact, is_container: true };
        fluid.add_collider(&context, &points, &triangles, container).unwrap();
        let (points, triangles) = (Self::board(0), cuboid(-HALF, HALF).1);
        let board = fluid.add_collider(&context, &points, &triangles, ColliderOptions { contact, is_container: false });
        Self { fluid, board: board.unwrap() }
    }

    fn pose(frame: u32) -> (Quat, Vec3) {
        let time = frame as f32 / 50.0;
        let turn = Quat::from_rotation_x(0.3 * (2.0 * time).sin()) * Quat::from_rotation_y(3.0 * time);
        let height = 0.15 + 0.25 * (-4.0 * time).exp();
        (turn, Vec3::new(0.3 + 0.12 * (2.5 * time).sin(), 0.15, height))
    }

    fn board(frame: u32) -> Vec<Vec3> {
        let (turn, middle) = Self::pose(frame);
        cuboid(-HALF, HALF).0.iter().map(|point| turn * *point + middle).collect()
    }

    /// Has the board go to where it is in a frame.
    fn go(&mut self, frame: u32) {
        let path = [&Self::board(frame - 1)[..], &Self::board(frame)];
        self.fluid.move_collider(&Context::serial(), self.board, path, 0.02).unwrap();
    }
}

/// Whether no particle is in the board as it is in a frame, and all are in the box.
fn is_kept(state: &State, frame: u32) -> bool {
    let (turn, middle) = Stirred::pose(frame);
    let is_in = |place: &Vec4| (turn.inverse() * (place.xyz() - middle)).abs().cmplt(HALF - 1e-4).all();
    let is_out = |place: &Vec4| place.xyz().cmplt(Vec3::splat(-1e-4)).any() || place.xyz().cmpgt(SIZE + 1e-4).any();
    !state.places.iter().any(|place| is_in(place) || is_out(place))
}

fn places(state: &State) -> Vec<Vec3> {
    let mut places = vec![Vec3::ZERO; state.numbers.len()];
    state.numbers.iter().zip(&state.places).for_each(|(number, place)| places[*number as usize] = place.xyz());
    places
}

#[test]
fn particles_meet_colliders_on_a_device_as_on_the_processor() {
    let Some(device) = device() else { return };
    let context = Context::serial();
    for contact in [Contact::Stop, Contact::Slip, Contact::Friction(0.3)] {
        let mut stirred = Stirred::new(contact, FluidOptions::default());
        for frame in 1..=12 {
            stirred.go(frame);
            stirred.fluid.advance(&context, 0.02, |_, _| Ok(())).unwrap();
        }
        let mut state = stirred.fluid.state();
        // Thrown at the board and the box, so far that many meet them in a step.
        let (step, middle) = (0.01, Stirred::pose(12).1);
        for (at, (place, velocity)) in state.places.iter().zip(&mut state.velocities).enumerate() {
            let way = (middle - place.xyz()).normalize() * if at % 2 == 0 { 4.0 } else { -4.0 };
            *velocity = way.extend(0.0);
        }
        let options = FluidOptions { time_step: TimeStep::Fixed(step), corrections: [2, 2], ..FluidOptions::default() };
        let mut stirred = Stirred::new(contact, options);
        stirred.go(13);
        let fluid = &mut stirred.fluid;
        fluid.set_state(state).unwrap();
        let mut sent = DeviceFluid::new(&device, fluid).unwrap();
        let before = places(&fluid.state());
        let (made, expected) = (sent.step(step).unwrap(), fluid.step(&context, step).unwrap());
        assert!(made.seconds == expected.seconds && made.corrections.abs_diff(expected.corrections) <= 1, "{made:?}");
        // What stops at the box has no velocity.
        let stopped = fluid.velocities().iter().filter(|velocity| velocity.xyz() == Vec3::ZERO).count();
        assert!(contact != Contact::Stop || stopped > 20, "{stopped}");
        let off = made.given.walls.distance(expected.given.walls) / expected.given.walls.length();
        let (made, expected) = (places(&sent.state().unwrap()), places(&fluid.state()));
        let moved = expected.iter().zip(&before).map(|(a, b)| a.distance(*b)).fold(0.0, f32::max);
        let apart = made.iter().zip(&expected).map(|(a, b)| a.distance(*b)).fold(0.0, f32::max);
        println!("{contact:?}: given {off:.1e}, {apart:.1e} of {moved:.1e}");
        assert!(off < 1e-2 && apart < 1e-2 * moved, "{contact:?}: given {off}, {apart} of {moved}");
    }
}

#[test]
fn nothing_goes_through_what_moves_on_a_device() {
    let Some(device) = device() else { return };
    let context = Context::serial();
    let [mut stirred, mut other] = [(); 2].map(|()| Stirred::new(Contact::Friction(0.1), FluidOptions::default()));
    let energy = |fluid: &Fluid| fluid.kinetic_energy();
    let mut sums = [0.0f32; 2];
    for frame in 1..=40 {
        stirred.go(frame);
        let mut sent = DeviceFluid::new(&device, &stirred.fluid).unwrap();
        sent.advance(0.02, |_, _| Ok(())).unwrap();
        let state = sent.state().unwrap();
        assert!(is_kept(&state, frame), "frame {frame}");
        stirred.fluid.set_state(state).unwrap();
        other.go(frame);
        other.fluid.advance(&context, 0.02, |_, _| Ok(())).unwrap();
        sums[0] += energy(&stirred.fluid);
        sums[1] += energy(&other.fluid);
    }
    assert!(sums[1] > 0.0 && (sums[0] / sums[1] - 1.0).abs() < 0.1, "{sums:?}");
}

#[test]
fn colliders_of_a_device_come_to_rest_and_too_many_triangles_are_refused() {
    let Some(device) = device() else { return };
    let context = Context::serial();
    let mut fluid =
        Fluid::new(FluidOptions { spacing: SPACING, gravity: Vec3::ZERO, ..FluidOptions::default() }).unwrap();
    fluid.add(&block(Vec3::ZERO, Vec3::splat(0.2), SPACING).unwrap(), Vec3::ZERO).unwrap();
    let (points, triangles) = cuboid(Vec3::new(0.5, -0.2, -0.2), Vec3::new(0.9, 0.4, 0.4));
    let number = fluid.add_collider(&context, &points, &triangles, ColliderOptions::default()).unwrap();
    let there: Vec<Vec3> = points.iter().map(|point| *point - 0.2 * Vec3::X).collect();
    fluid.move_collider(&context, number, [&points, &there], 0.05).unwrap();
    let mut sent = DeviceFluid::new(&device, &fluid).unwrap();
    sent.advance(0.1, |_, _| Ok(())).unwrap();
    // It has come as far as 0.3, with what it pushed before it, and no farther.
    let most = sent.state().unwrap().places.iter().map(|place| place.x).fold(0.0, f32::max);
    assert!((0.1..0.3).contains(&most), "{most}");
    let at = |index: usize| 1e-3 * index as f32;
    let points: Vec<Vec3> = (0..41 * 41).map(|index| Vec3::new(at(index % 41), at(index / 41), -1.0)).collect();
    let corner = |index: usize| (index / 40 * 41 + index % 40) as u32;
    let squares = (0..1600).map(corner);
    let triangles: Vec<[u32; 3]> = squares.flat_map(|at| [[at, at + 1, at + 41], [at + 1, at + 42, at + 41]]).collect();
    fluid.add_collider(&context, &points, &triangles, ColliderOptions::default()).unwrap();
    let refused = DeviceFluid::new(&device, &fluid).unwrap_err().to_string();
    assert!(refused.contains("triangles are within"), "{refused}");
}
