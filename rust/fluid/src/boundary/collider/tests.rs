use glam::{Quat, Vec4Swizzles};

use super::*;
use crate::{Fluid, FluidOptions, PressureSolver, block, cuboid};

fn constants(spacing: f32) -> Constants {
    Constants::new(&FluidOptions { spacing, ..FluidOptions::default() })
}

fn made(points: &[Vec3], triangles: &[[u32; 3]], is_container: bool) -> Result<Collider> {
    let options = ColliderOptions { is_container, ..ColliderOptions::default() };
    Collider::new(&Context::serial(), &constants(0.1), points, triangles, options)
}

#[test]
fn a_collider_that_goes_says_when_it_arrives() {
    let (points, triangles) = cuboid(Vec3::ZERO, Vec3::ONE);
    let mut collider = made(&points, &triangles, false).unwrap();
    assert_eq!(collider.left(), f32::INFINITY);
    let moved: Vec<Vec3> = points.iter().map(|point| *point + Vec3::X).collect();
    collider.go(&Context::serial(), &constants(0.1), [&points, &moved], 0.25).unwrap();
    assert_eq!(collider.left(), 0.25);
    assert!(!collider.arrive(0.125));
    assert_eq!(collider.left(), 0.125);
    assert!(collider.arrive(0.125));
    assert_eq!(collider.left(), f32::INFINITY);
}

#[test]
fn particles_lie_behind_closed_surfaces_and_on_others() {
    let (points, mut triangles) = cuboid(Vec3::ZERO, Vec3::new(1.0, 0.8, 0.6));
    // How far particles are from the middle of the box, in its half sizes, along the axis where that is most.
    let reach = |triangles: &[[u32; 3]], is_container| {
        let collider = made(&points, triangles, is_container).unwrap();
        let places = collider.particles();
        let out = places.iter().map(|place| (place.xyz() - Vec3::new(0.5, 0.4, 0.3)).abs() - Vec3::new(0.5, 0.4, 0.3));
        let reach: Vec<f32> = out.map(|out| out.max_element()).collect();
        let (least, most) = reach.iter().fold((f32::MAX, f32::MIN), |(low, high), at| (low.min(*at), high.max(*at)));
        assert!(most - least < 1e-5, "{least} {most}");
        (100.0 * most).round()
    };
    let inner = made(&points, &triangles, false).unwrap().count();
    // 0.9 m by 0.7 m by 0.5 m, at a little more than one in a square of the spacing.
    assert!((240..450).contains(&inner), "{inner}");
    assert!(reach(&triangles, false) == -5.0 && reach(&triangles, true) == 5.0);
    triangles.iter_mut().for_each(|triangle| triangle.reverse());
    assert!(reach(&triangles, false) == -5.0 && reach(&triangles, true) == 5.0);
    triangles.pop();
    assert_eq!(reach(&triangles, false), 0.0);
    // Every corner has its own points, as files with normals have them; and one triangle is nothing.
    let apart: Vec<Vec3> = triangles.iter().flatten().map(|corner| points[*corner as usize]).collect();
    let mut own: Vec<[u32; 3]> = (0..triangles.len() as u32).map(|at| [3 * at, 3 * at + 1, 3 * at + 2]).collect();
    own.push([0, 0, 1]);
    assert_eq!(made(&apart, &own, false).unwrap().count(), made(&points, &triangles, false).unwrap().count());
}

#[test]
fn what_cannot_be_a_collider_is_refused() {
    let (points, triangles) = cuboid(Vec3::ZERO, Vec3::ONE);
    assert!(made(&points, &[[0, 1, 8]], false).is_err());
    assert!(made(&points, &[[0, 1, 1]], false).is_err());
    assert!(made(&points, &[], false).is_err());
    assert!(made(&[Vec3::NAN, Vec3::X, Vec3::Y], &[[0, 1, 2]], false).is_err());
    assert!(made(&[Vec3::ZERO, Vec3::X * 1e30, Vec3::Y * 1e30], &[[0, 1, 2]], false).is_err());
    let (context, mut fluid) =
        (Context::serial(), Fluid::new(FluidOptions { spacing: 0.1, ..FluidOptions::default() }));
    let fluid = fluid.as_mut().unwrap();
    let bad = ColliderOptions { contact: Contact::Friction(f32::NAN), is_container: false };
    assert!(fluid.add_collider(&context, &points, &triangles, bad).is_err());
    assert_eq!(fluid.add_collider(&context, &points, &triangles, ColliderOptions::default()).unwrap(), 0);
    assert!(fluid.move_collider(&context, 1, [&points, &points], 1.0).is_err());
    assert!(fluid.move_collider(&context, 0, [&points, &points[1..]], 1.0).is_err());
    assert!(fluid.move_collider(&context, 0, [&points, &points], f32::NAN).is_err());
    assert!(fluid.move_collider(&context, 0, [&points, &[Vec3::NAN; 8]], 1.0).is_err());
    assert!(fluid.move_collider(&context, 0, [&points, &points], 1.0).is_ok());
}

#[test]
fn nothing_goes_through_what_moves_in_a_thousand_frames() {
    let (context, spacing) = (Context::serial(), 0.1);
    let mut fluid = Fluid::new(FluidOptions { spacing, ..FluidOptions::default() }).unwrap();
    let size = Vec3::new(1.2, 0.6, 1.2);
    fluid.add(&block(Vec3::ZERO, Vec3::new(1.2, 0.6, 0.4), spacing).unwrap(), Vec3::ZERO).unwrap();
    let (points, triangles) = cuboid(Vec3::ZERO, size);
    let container = ColliderOptions { contact: Contact::Stop, is_container: true };
    fluid.add_collider(&context, &points, &triangles, container).unwrap();
    // A board that turns about a line in its middle and goes to and fro, above the fluid at first.
    let half = Vec3::new(0.04, 0.14, 0.18);
    let (points, triangles) = cuboid(-half, half);
    let pose = |frame: u32| {
        let time = frame as f32 / 50.0;
        let height = 0.35 + 0.45 * (-time).exp();
        let turn = Quat::from_rotation_x(0.3 * (2.0 * time).sin()) * Quat::from_rotation_y(3.0 * time);
        (turn, Vec3::new(0.6 + 0.25 * (2.5 * time).sin(), 0.3, height))
    };
    let placed = |frame: u32| {
        let (turn, middle) = pose(frame);
        points.iter().map(|point| turn * *point + middle).collect::<Vec<Vec3>>()
    };
    let options = ColliderOptions { contact: Contact::Friction(0.1), is_container: false };
    let board = fluid.add_collider(&context, &placed(0), &triangles, options).unwrap();
    let inside = |fluid: &Fluid, frame: u32| {
        let (turn, middle) = pose(frame);
        let is_in = |place: &&Vec4| (turn.inverse() * (place.xyz() - middle)).abs().cmplt(half - 1e-4).all();
        fluid.places().iter().filter(is_in).count()
    };
    assert_eq!(inside(&fluid, 0), 0);
    let mut fast = 0.0f32;
    for frame in 0..1000 {
        fluid.move_collider(&context, board, [&placed(frame), &placed(frame + 1)], 0.02).unwrap();
        fluid.advance(&context, 0.02, |_, _| Ok(())).unwrap();
        assert_eq!(inside(&fluid, frame + 1), 0, "frame {frame}");
        let is_kept =
            |place: &Vec4| place.xyz().cmpge(Vec3::splat(-1e-4)).all() && place.xyz().cmple(size + 1e-4).all();
        assert!(fluid.places().iter().all(is_kept), "frame {frame}");
        fast = fast.max((2.0 * fluid.kinetic_energy() / (fluid.mass() * fluid.len() as f32)).sqrt());
    }
    assert!(fast > 0.1, "the board stirs: {fast} m/s");
}

#[test]
fn a_collider_goes_on_where_walls_are_set_anew() {
    let (context, spacing) = (Context::serial(), 0.1);
    let steps = |walls: bool| {
        let mut fluid = Fluid::new(FluidOptions { spacing, gravity: Vec3::ZERO, ..FluidOptions::default() }).unwrap();
        let (points, triangles) = cuboid(Vec3::ZERO, Vec3::ONE);
        let options = ColliderOptions { contact: Contact::Slip, is_container: false };
        let number = fluid.add_collider(&context, &points, &triangles, options).unwrap();
        let target: Vec<Vec3> = points.iter().map(|point| *point + Vec3::X).collect();
        fluid.move_collider(&context, number, [&points, &target], 1.0).unwrap();
        if walls {
            fluid.set_walls(&context, &[Vec3::splat(9.0)]).unwrap();
        }
        fluid.add(&[Vec3::splat(5.0)], Vec3::ZERO).unwrap();
        fluid.time_step()
    };
    // Steps follow from the speed of what is moving.
    assert_eq!(steps(true), steps(false));
}

#[test]
fn an_open_sheet_that_bends_holds_what_falls_on_it() {
    let (context, spacing) = (Context::serial(), 0.05);
    let mut fluid = Fluid::new(FluidOptions { spacing, ..FluidOptions::default() }).unwrap();
    fluid.add(&block(Vec3::new(0.3, 0.3, 0.1), Vec3::new(0.7, 0.7, 0.3), spacing).unwrap(), -Vec3::Z).unwrap();
    // Wound against each other, which does not matter where there are two sides.
    let side = |at: u32| at as f32 / 8.0;
    let sheet = |bend: f32| {
        let numbers = (0..81u32).map(|number| (side(number % 9), side(number / 9)));
        let rise = |x: f32, y: f32| 4.0 * bend * ((x - 0.5).powi(2) + (y - 0.5).powi(2));
        numbers.map(|(x, y)| Vec3::new(x, y, rise(x, y))).collect::<Vec<Vec3>>()
    };
    let cells = (0..64u32).map(|cell| cell % 8 + cell / 8 * 9);
    let triangles: Vec<[u32; 3]> = cells.flat_map(|at| [[at, at + 1, at + 10], [at, at + 9, at + 10]]).collect();
    let options = ColliderOptions { contact: Contact::Slip, is_container: false };
    let number = fluid.add_collider(&context, &sheet(0.2), &triangles, options).unwrap();
    for frame in 0..20 {
        let bend = |frame: u32| 0.2 + 0.02 * frame as f32;
        fluid.move_collider(&context, number, [&sheet(bend(frame)), &sheet(bend(frame + 1))], 0.02).unwrap();
        fluid.advance(&context, 0.02, |_, _| Ok(())).unwrap();
        for place in
            fluid.places().iter().filter(|place| place.xy().min_element() > 0.01 && place.xy().max_element() < 0.99)
        {
            // Below the sheet where it is lowest: its triangles are chords of the bowl.
            let [x, y] = [place.x, place.y].map(|at| (8.0 * (at - 0.5)).abs().floor() / 8.0);
            let floor = 4.0 * bend(frame + 1) * (x * x + y * y);
            assert!(place.z > floor - 1e-4, "{place} {floor}");
        }
    }
}

#[test]
fn momentum_goes_from_the_fluid_to_what_it_meets() {
    [PressureSolver::Pcisph, PressureSolver::Dfsph].into_iter().for_each(meet);
}

/// Asserts that what a fluid loses to a collider is what that is given.
fn meet(solver: PressureSolver) {
    let (context, spacing) = (Context::serial(), 0.05);
    let gravity = Vec3::new(0.0, 0.0, -5.0);
    let mut fluid = Fluid::new(FluidOptions { spacing, gravity, solver, ..FluidOptions::default() }).unwrap();
    fluid.add(&block(Vec3::ZERO, Vec3::new(0.4, 0.4, 0.4), spacing).unwrap(), Vec3::new(1.0, 0.0, 0.0)).unwrap();
    let (points, triangles) = cuboid(Vec3::new(0.45, 0.0, -0.2), Vec3::new(0.8, 0.4, 0.5));
    let target: Vec<Vec3> = points.iter().map(|point| *point + Vec3::new(-0.1, 0.02, 0.0)).collect();
    let number = fluid.add_collider(&context, &points, &triangles, ColliderOptions::default()).unwrap();
    fluid.move_collider(&context, number, [&points, &target], 0.2).unwrap();
    let before = fluid.momentum();
    let (mut given, mut turned, mut seconds) = (glam::DVec3::ZERO, glam::DVec3::ZERO, 0.0);
    let watch = |fluid: &mut Fluid, done: &crate::StepStatistics| {
        assert!(fluid.impulses()[0] == crate::Impulse::default());
        given += fluid.impulses()[number + 1].linear;
        turned += fluid.impulses()[number + 1].angular;
        seconds += done.seconds;
        Ok(())
    };
    fluid.advance(&context, 0.2, watch).unwrap();
    assert!(fluid.collider_points(number).iter().zip(&target).all(|(now, then)| now.distance(*then) < 1e-6));
    let pulled = fluid.mass() * fluid.len() as f32 * seconds * gravity;
    let lost = before + pulled - fluid.momentum();
    println!("{solver:?}: given {given}, lost {lost}");
    assert!(lost.as_dvec3().distance(given) < 1e-4 * given.length() && given.length() > 10.0, "{given} {lost}");
    // It is hit in its middle or below, at about where the fluid is.
    assert!((turned.y / given.x - 0.2).abs() < 0.1, "{turned}");
}
