//! Rigid bodies that float.

use glam::{Quat, Vec3, Vec4};
use relievo_core::Context;
use relievo_fluid::{Bodies, BodyOptions, Fluid, FluidOptions, Solid, basin, block, cuboid};

#[test]
fn a_box_floats_as_deep_as_its_density() {
    let (context, spacing) = (Context::serial(), 0.04);
    let side = Vec3::new(0.72, 0.72, 0.4);
    for density in [300.0, 600.0] {
        let mut fluid = Fluid::new(FluidOptions { spacing, viscosity: 0.01, ..FluidOptions::default() }).unwrap();
        fluid.set_walls(&context, &basin(Vec3::ZERO, Vec3::new(0.72, 0.72, 0.8), spacing).unwrap()).unwrap();
        let (low, high) = (Vec3::new(0.24, 0.24, 0.28), Vec3::new(0.48, 0.48, 0.52));
        let (points, triangles) = cuboid(low, high);
        let mut bodies = Bodies::new(Vec3::new(0.0, 0.0, -9.81), Some([Vec3::ZERO, Vec3::new(0.72, 0.72, 2.0)]));
        let options = BodyOptions { density, ..BodyOptions::default() };
        bodies.add(&context, &mut fluid, (&points, &triangles), &options).unwrap();
        let places = block(Vec3::ZERO, side, spacing).unwrap();
        let solid = Solid::new(&points, &triangles).unwrap();
        let outside: Vec<Vec3> = places.into_iter().filter(|place| !solid.is_inside(*place)).collect();
        let places = fluid.beside_walls(&context, &outside).unwrap();
        fluid.add(&places, Vec3::ZERO).unwrap();
        bodies.advance(&context, &mut fluid, 1.5, |_, _| Ok(())).unwrap();
        // The mean over a while, since it goes up and down.
        let (mut depth, mut count) = (0.0, 0.0f32);
        for _ in 0..25 {
            bodies.advance(&context, &mut fluid, 0.02, |_, _| Ok(())).unwrap();
            let bottom = fluid.collider_points(0).iter().map(|point| point.z).sum::<f32>() / 8.0 - 0.12;
            // Beside the box, fluid is from the floor to the surface.
            let is_beside = |place: &&Vec4| (place.truncate() - 0.36).truncate().abs().max_element() > 0.16;
            let heights: Vec<f32> = fluid.places().iter().filter(is_beside).map(|place| place.z).collect();
            let surface = 2.0 * heights.iter().sum::<f32>() / heights.len() as f32;
            depth += surface - bottom;
            count += 1.0;
        }
        let share = depth / count / 0.24;
        println!("{density} kg/m³: {share:.3} of the box is below the surface");
        assert!((share - density / 1000.0).abs() < 0.06, "{share}");
        let (turn, _) = bodies.pose(0).unwrap();
        assert!(turn.is_finite() && bodies.pose(1).is_none());
    }
}

#[test]
fn what_cannot_be_a_body_is_refused() {
    let (context, mut fluid) = (Context::serial(), Fluid::new(FluidOptions::default()).unwrap());
    let mut bodies = Bodies::new(Vec3::ZERO, None);
    let (points, triangles) = cuboid(Vec3::ZERO, Vec3::splat(0.1));
    let options = BodyOptions::default();
    let mut refused = |triangles: &[[u32; 3]], options: &BodyOptions| {
        assert!(bodies.add(&context, &mut fluid, (&points, triangles), options).is_err());
    };
    refused(&triangles, &BodyOptions { density: 0.0, ..options });
    refused(&triangles, &BodyOptions { spin: Vec3::NAN, ..options });
    refused(&triangles[1..], &options);
    refused(&[], &options);
}

#[test]
fn a_body_stays_on_an_obstacle_that_moves() {
    let (context, mut fluid) = (Context::serial(), Fluid::new(FluidOptions::default()).unwrap());
    let mut bodies = Bodies::new(Vec3::Z * -9.81, None);
    let (floor, faces) = cuboid(Vec3::new(-1.0, -1.0, -0.2), Vec3::new(1.0, 1.0, 0.0));
    assert_eq!(bodies.add_obstacle(&floor, &faces).unwrap(), 0);
    assert!(bodies.add_obstacle(&floor, &[]).is_err());
    let (points, triangles) = cuboid(Vec3::new(-0.1, -0.1, 0.0), Vec3::splat(0.1));
    bodies.add(&context, &mut fluid, (&points, &triangles), &BodyOptions::default()).unwrap();
    for frame in 0..20 {
        let rise = |frame: i32| (Quat::IDENTITY, Vec3::Z * 0.01 * frame as f32);
        bodies.move_obstacle(0, [rise(frame), rise(frame + 1)]).unwrap();
        bodies.advance(&context, &mut fluid, 0.02, |_, _| Ok(())).unwrap();
    }
    let (_, moved) = bodies.pose(0).unwrap();
    assert!(moved.distance(Vec3::Z * 0.2) < 0.01, "{moved}");
    assert!(bodies.move_obstacle(1, [(Quat::IDENTITY, Vec3::ZERO); 2]).is_err());
    assert!(bodies.move_obstacle(0, [(Quat::IDENTITY, Vec3::NAN); 2]).is_err());
}

#[test]
fn bodies_go_on_from_states_to_the_bit() {
    let (context, spacing) = (Context::serial(), 0.05);
    let begin = || {
        let mut fluid = Fluid::new(FluidOptions { spacing, ..FluidOptions::default() }).unwrap();
        fluid.set_walls(&context, &basin(Vec3::ZERO, Vec3::new(0.6, 0.4, 0.8), spacing).unwrap()).unwrap();
        let mut bodies = Bodies::new(Vec3::new(0.0, 0.0, -9.81), Some([Vec3::ZERO, Vec3::new(0.6, 0.4, 2.0)]));
        for low in [Vec3::new(0.1, 0.1, 0.3), Vec3::new(0.14, 0.12, 0.52)] {
            let (points, triangles) = cuboid(low, low + 0.2);
            let options = BodyOptions { density: 700.0, spin: Vec3::new(0.3, -1.0, 2.0), ..BodyOptions::default() };
            bodies.add(&context, &mut fluid, (&points, &triangles), &options).unwrap();
        }
        (fluid, bodies)
    };
    let (mut fluid, mut bodies) = begin();
    fluid.add(&block(Vec3::ZERO, Vec3::new(0.6, 0.4, 0.3), spacing).unwrap(), Vec3::ZERO).unwrap();
    let advance = |(fluid, bodies): (&mut Fluid, &mut Bodies)| {
        bodies.advance(&context, fluid, 0.02, |_, _| Ok(())).unwrap();
    };
    (0..12).for_each(|_| advance((&mut fluid, &mut bodies)));
    let (mut resumed, mut others) = begin();
    resumed.set_state(fluid.state()).unwrap();
    others.set_states(&bodies.states()).unwrap();
    for _ in 0..12 {
        advance((&mut fluid, &mut bodies));
        advance((&mut resumed, &mut others));
    }
    assert!(bodies.states() == others.states() && fluid.state() == resumed.state());
    let moved = bodies.pose(0).unwrap().1;
    assert!(moved.length() > 0.02, "{moved}");
    assert!(others.set_states(&bodies.states()[..1]).is_err());
    let mut wrong = bodies.states();
    wrong[1].spin.x = f32::NAN;
    assert!(others.set_states(&wrong).is_err() && others.states() == bodies.states());
}

/// A floor of 12 by 12 cells that goes up and down by 0.4 m, and becomes a bowl meanwhile.
fn floor(seconds: f32) -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let places =
        (0..169u32).map(|number| Vec3::new((number % 13) as f32 - 6.0, (number / 13) as f32 - 6.0, 0.0) / 12.0);
    let points = places.map(|place| place + Vec3::Z * height(place, seconds)).collect();
    let corners = (0..144u32).map(|cell| cell % 12 + cell / 12 * 13);
    (points, corners.flat_map(|at| [[at, at + 1, at + 14], [at, at + 14, at + 13]]).collect())
}

fn height(place: Vec3, seconds: f32) -> f32 {
    0.2 * (1.0 - (2.0 * seconds).cos()) + seconds.min(1.0) * place.truncate().length_squared()
}

#[test]
fn a_body_goes_up_and_down_with_a_floor_that_bends_and_goes_on_to_the_bit() {
    let context = Context::serial();
    let begin = || {
        let mut fluid = Fluid::new(FluidOptions { spacing: 0.1, ..FluidOptions::default() }).unwrap();
        let mut bodies = Bodies::new(Vec3::Z * -9.81, None);
        let (points, triangles) = floor(0.0);
        bodies.add_obstacle(&points, &triangles).unwrap();
        let (points, triangles) = cuboid(Vec3::new(-0.13, -0.1, 0.0), Vec3::new(0.12, 0.11, 0.2));
        bodies.add(&context, &mut fluid, (&points, &triangles), &BodyOptions::default()).unwrap();
        (fluid, bodies)
    };
    let advance = |fluid: &mut Fluid, bodies: &mut Bodies, frame: u32| {
        let ends = [frame, frame + 1].map(|frame| floor(0.02 * frame as f32).0);
        bodies.bend_obstacle(0, [&ends[0], &ends[1]]).unwrap();
        bodies.advance(&context, fluid, 0.02, |_, _| Ok(())).unwrap();
    };
    let ((mut fluid, mut bodies), (mut resumed, mut others)) = (begin(), begin());
    let mut far = 0.0f32;
    for frame in 0..400 {
        if frame == 150 {
            resumed.set_state(fluid.state()).unwrap();
            others.set_states(&bodies.states()).unwrap();
        }
        advance(&mut fluid, &mut bodies, frame);
        if frame >= 150 {
            advance(&mut resumed, &mut others, frame);
        }
        let (now, (turn, moved)) = (0.02 * (frame + 1) as f32, bodies.pose(0).unwrap());
        let [low, high] = [Vec3::new(-0.13, -0.1, 0.0), Vec3::new(0.12, 0.11, 0.0)];
        let corners = [low, Vec3::new(high.x, low.y, 0.0), Vec3::new(low.x, high.y, 0.0), high];
        let above = corners.map(|corner| turn * corner + moved).map(|corner| corner.z - height(corner, now));
        let (least, most) = above.iter().fold((f32::MAX, f32::MIN), |(low, high), at| (low.min(*at), high.max(*at)));
        // The floor is chords of the bowl, up to 3.5 mm above it.
        assert!(least > -0.006 && most < 0.02, "frame {frame}: {above:?}");
        far = far.max(moved.length());
    }
    assert!(far > 0.4 && bodies.states() == others.states() && fluid.state() == resumed.state());
    let (points, _) = floor(0.0);
    assert!(bodies.bend_obstacle(1, [&points, &points]).is_err());
    assert!(bodies.bend_obstacle(0, [&points, &points[1..]]).is_err());
    assert!(bodies.bend_obstacle(0, [&points, &[Vec3::NAN; 169]]).is_err());
}
