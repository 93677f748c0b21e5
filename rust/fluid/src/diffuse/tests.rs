use glam::{Quat, Vec3};
use proptest::prelude::*;
use relievo_core::progress::Silent;
use relievo_core::{Context, ContextOptions};

use super::potential::potentials;
use super::*;

const SPACING: f32 = 0.02;

fn options() -> DiffuseOptions {
    with(DiffuseSettings::default())
}

fn with(settings: DiffuseSettings) -> DiffuseOptions {
    DiffuseOptions { spacing: SPACING, settings: DiffuseSettings { steps: 1, ..settings }, ..DiffuseOptions::default() }
}

/// A block of so many particles along each axis, from a corner.
fn block(corner: Vec3, [nx, ny, nz]: [u32; 3]) -> Vec<Vec3> {
    let places = (0..nx * ny * nz).map(|n| Vec3::new((n % nx) as f32, (n / nx % ny) as f32, (n / nx / ny) as f32));
    places.map(|place| corner + SPACING * place).collect()
}

fn of(options: &DiffuseOptions, positions: &[Vec3], velocities: &[Vec3]) -> Vec<potential::Potentials> {
    let fluid = Surroundings::new(&Context::serial(), options, positions, velocities).unwrap();
    potentials(&Context::serial(), options, &fluid)
}

/// Two blocks that meet at 8 m/s.
fn collision() -> (Vec<Vec3>, Vec<Vec3>) {
    let (mut positions, right) = (block(Vec3::ZERO, [12; 3]), block(Vec3::new(0.24, 0.0, 0.0), [12; 3]));
    let mut velocities = vec![Vec3::new(4.0, 0.0, 0.0); positions.len()];
    velocities.extend(right.iter().map(|_| Vec3::new(-4.0, 0.0, 0.0)));
    positions.extend(right);
    (positions, velocities)
}

#[test]
fn a_pair_traps_air_as_in_closed_form() {
    let limits = with(DiffuseSettings {
        air_min: 0.0,
        air_max: 100.0,
        energy_min: 0.0,
        energy_max: 1.0,
        ..DiffuseSettings::default()
    });
    let positions = [Vec3::ZERO, Vec3::new(SPACING, 0.0, 0.0)];
    let air = |velocity: Vec3| of(&limits, &positions, &[velocity, -velocity])[0].air;
    // The weight of neighbours at half the support radius is one half; towards each other the factor is 2.
    assert!((air(Vec3::new(3.0, 0.0, 0.0)) - 0.06).abs() < 1e-6);
    assert!((air(Vec3::new(0.0, 3.0, 0.0)) - 0.03).abs() < 1e-6);
    assert!(air(Vec3::new(-3.0, 0.0, 0.0)).abs() < 1e-6);
}

#[test]
fn potentials_are_shares_for_any_velocity_that_is_taken() {
    let (positions, mut velocities) = collision();
    let run = Diffuse::new(options()).unwrap();
    for fast in [1e9, 1e15, 1.1e15, 5e33, f32::MAX, f32::NAN] {
        velocities.iter_mut().step_by(2).for_each(|velocity| *velocity = Vec3::new(fast, -fast, fast));
        let frame = FluidFrame { positions: &positions, velocities: &velocities };
        match run.potentials(&Context::serial(), frame) {
            Ok(found) => {
                let shares = found.iter().flat_map(|found| [found.air, found.crest, found.energy]);
                assert!(fast <= 1e15 && shares.into_iter().all(|share| (0.0..=1.0).contains(&share)), "{fast}");
            }
            Err(error) => assert!(!(fast <= 1e15) && error.to_string().contains("velocit"), "{fast}: {error}"),
        }
    }
}

#[test]
fn potentials_are_in_the_order_of_the_particles() {
    let (positions, velocities) = collision();
    let run = Diffuse::new(options()).unwrap();
    let potentials = |positions: &[Vec3], velocities: &[Vec3]| {
        run.potentials(&Context::serial(), FluidFrame { positions, velocities }).unwrap()
    };
    let found = potentials(&positions, &velocities);
    // Fluid is fast everywhere, and traps air where the blocks meet.
    assert!(found.iter().all(|found| found.energy > 0.0));
    let is_near = |at: &Vec3| (at.x - 0.23).abs() < 0.5 * SPACING + 1e-3;
    assert!(positions.iter().zip(&found).all(|(at, found)| is_near(at) || found.air < 0.5));
    assert!(positions.iter().zip(&found).any(|(at, found)| is_near(at) && found.air > 0.9));
    let reversed = |list: &[Vec3]| list.iter().rev().copied().collect::<Vec<_>>();
    let other = potentials(&reversed(&positions), &reversed(&velocities));
    let near = |a: f32, b: f32| (a - b).abs() < 1e-4;
    let pairs = found.iter().zip(other.iter().rev());
    assert!(pairs.into_iter().all(|(a, b)| near(a.air, b.air) && near(a.crest, b.crest) && a.energy == b.energy));
}

#[test]
fn a_block_that_moves_as_one_makes_no_particles() {
    let positions = block(Vec3::ZERO, [16, 8, 16]);
    for velocity in [Vec3::new(7.0, 0.0, 0.0), Vec3::new(3.0, -6.0, 4.0)] {
        let mut diffuse = Diffuse::new(options()).unwrap();
        let velocities = vec![velocity; positions.len()];
        let frame = FluidFrame { positions: &positions, velocities: &velocities };
        let report = diffuse.advance(&Context::serial(), frame, 0.04, &mut Silent).unwrap();
        assert_eq!(report, DiffuseReport::default());
    }
}

#[test]
fn a_thin_crest_that_runs_ahead_breaks() {
    let limits = with(DiffuseSettings { crest_min: 0.5, ..DiffuseSettings::default() });
    let mut positions = block(Vec3::ZERO, [20, 4, 12]);
    let ridge = positions.len();
    positions.extend(block(Vec3::new(0.2, 0.08, 0.0), [2, 3, 12]));
    let velocities = vec![Vec3::new(0.0, 5.0, 0.0); positions.len()];
    let crests: Vec<_> = of(&limits, &positions, &velocities);
    let down: Vec<_> = velocities.iter().map(|velocity| -*velocity).collect();
    assert!(crests.iter().any(|found| found.crest > 0.0));
    // What moves away from the side of its normal does not break.
    let fluid = Surroundings::new(&Context::serial(), &limits, &positions, &down).unwrap();
    let found = potentials(&Context::serial(), &limits, &fluid);
    let top = 0.08 + 1.5 * SPACING;
    assert!(found.iter().enumerate().all(|(at, found)| fluid.place(at).y < top || found.crest == 0.0));
    assert!(ridge < positions.len());
}

#[test]
fn spray_flies_along_a_parabola() {
    let started = DiffuseParticles {
        positions: vec![Vec3::new(0.5, 2.0, 0.25)],
        velocities: vec![Vec3::new(1.0, 3.0, -2.0)],
        kinds: vec![DiffuseKind::Spray],
        ages: vec![0.0],
        lifetimes: vec![1.0],
        ids: vec![7],
    };
    let mut diffuse = Diffuse::restore(options(), started, 4, 8).unwrap();
    let nothing = FluidFrame { positions: &[], velocities: &[] };
    for _ in 0..30 {
        diffuse.advance(&Context::serial(), nothing, 1.0 / 30.0, &mut Silent).unwrap();
    }
    let found = diffuse.particles();
    let expected = Vec3::new(1.5, 2.0 + 3.0 - 0.5 * 9.81, -1.75);
    assert!(found.positions[0].distance(expected) < 1e-4);
    assert!((found.ages[0] - 1.0).abs() < 1e-5);
    assert_eq!((found.ids[0], found.lifetimes[0], diffuse.progress()), (7, 1.0, (34, 8)));
}

#[test]
fn foam_floats_and_dissolves_and_bubbles_rise() {
    let positions = block(Vec3::ZERO, [16, 8, 16]);
    let velocities = vec![Vec3::new(0.5, 0.0, 0.0); positions.len()];
    let frame = FluidFrame { positions: &positions, velocities: &velocities };
    let at = [Vec3::new(0.15, 0.15, 0.15), Vec3::new(0.15, 0.08, 0.15), Vec3::new(0.15, 0.5, 0.15)];
    let started = DiffuseParticles {
        positions: at.to_vec(),
        velocities: vec![Vec3::ZERO; 3],
        kinds: vec![DiffuseKind::Spray; 3],
        ages: vec![0.0; 3],
        lifetimes: vec![0.05; 3],
        ids: vec![0, 1, 2],
    };
    let mut diffuse = Diffuse::restore(options(), started, 0, 3).unwrap();
    let report = diffuse.advance(&Context::serial(), frame, 0.02, &mut Silent).unwrap();
    let found = diffuse.particles();
    assert_eq!(found.kinds, [DiffuseKind::Foam, DiffuseKind::Bubble, DiffuseKind::Spray]);
    assert!(found.positions[0].distance(at[0] + 0.02 * velocities[0]) < 1e-6);
    assert!(found.positions[1].y > at[1].y && found.velocities[1].x > 0.3);
    assert!(found.positions[2].y < at[2].y);
    assert_eq!(report.gone, 0);
    for _ in 0..2 {
        diffuse.advance(&Context::serial(), frame, 0.02, &mut Silent).unwrap();
    }
    assert_eq!(diffuse.particles().ids, [1, 2]);
}

#[test]
fn runs_are_the_same_for_any_threads_and_resumed_and_every_birth_is_accounted_for() {
    let (positions, velocities) = collision();
    let frame = FluidFrame { positions: &positions, velocities: &velocities };
    let settings = DiffuseSettings { lifetime_min: 0.01, lifetime_max: 0.1, steps: 2, ..DiffuseSettings::default() };
    let options = DiffuseOptions { settings, ..options() };
    let run = |context: &Context, frames: usize, mut diffuse: Diffuse| {
        let mut total = DiffuseReport::default();
        for _ in 0..frames {
            let report = diffuse.advance(context, frame, 0.04, &mut Silent).unwrap();
            total.born += report.born;
            total.gone += report.gone;
        }
        (diffuse, total)
    };
    let context = Context::new(&ContextOptions { threads: 3, memory_limit: 0 }).unwrap();
    let (all, total) = run(&Context::serial(), 6, Diffuse::new(options).unwrap());
    assert!(total.born > 1000 && total.gone > 0);
    assert_eq!(total.born, total.gone + all.particles().len() as u64);
    assert_eq!(run(&context, 6, Diffuse::new(options).unwrap()).0.particles(), all.particles());
    let (half, _) = run(&context, 3, Diffuse::new(options).unwrap());
    let (frames, births) = half.progress();
    let resumed = Diffuse::restore(options, half.particles().clone(), frames, births).unwrap();
    assert_eq!(run(&context, 3, resumed).0.particles(), all.particles());
    let other = run(
        &context,
        6,
        Diffuse::new(DiffuseOptions { settings: DiffuseSettings { seed: 2, ..settings }, ..options }).unwrap(),
    )
    .0;
    assert_ne!(other.particles(), all.particles());
}

#[test]
fn the_greatest_number_is_never_exceeded() {
    let (positions, velocities) = collision();
    let frame = FluidFrame { positions: &positions, velocities: &velocities };
    let mut diffuse = Diffuse::new(with(DiffuseSettings { most: 500, ..DiffuseSettings::default() })).unwrap();
    let mut refused = 0;
    for _ in 0..4 {
        refused += diffuse.advance(&Context::serial(), frame, 0.04, &mut Silent).unwrap().refused;
        assert!(diffuse.particles().len() <= 500);
    }
    assert!(refused > 0);
}

#[test]
fn births_beyond_the_room_are_counted_and_those_beyond_the_memory_refused() {
    let (positions, velocities) = collision();
    let frame = FluidFrame { positions: &positions, velocities: &velocities };
    let settings = DiffuseSettings { air_rate: 1e9, crest_rate: 1e9, most: 100, ..DiffuseSettings::default() };
    let mut diffuse = Diffuse::new(with(settings)).unwrap();
    let report = diffuse.advance(&Context::serial(), frame, 0.04, &mut Silent).unwrap();
    // Making them all would take gigabytes.
    assert!(report.born == 100 && report.refused > 1 << 20, "{report:?}");
    // The first of them are those of a run with more room.
    let mut wider = Diffuse::new(with(DiffuseSettings { most: 150, ..settings })).unwrap();
    wider.advance(&Context::serial(), frame, 0.04, &mut Silent).unwrap();
    assert_eq!(diffuse.particles().positions, wider.particles().positions[..100]);
    let limited = Context::new(&ContextOptions { memory_limit: 1 << 24, ..ContextOptions::default() }).unwrap();
    let mut greedy = Diffuse::new(with(DiffuseSettings { most: 1_000_000_000, ..settings })).unwrap();
    let error = greedy.advance(&limited, frame, 0.04, &mut Silent).unwrap_err();
    assert_eq!(error.kind, relievo_core::ErrorKind::Memory);
    assert_eq!(greedy.progress(), (0, 0));
}

#[test]
fn frames_that_are_no_frames_are_refused_and_change_nothing() {
    let (positions, velocities) = collision();
    let mut diffuse = Diffuse::new(options()).unwrap();
    diffuse
        .advance(&Context::serial(), FluidFrame { positions: &positions, velocities: &velocities }, 0.04, &mut Silent)
        .unwrap();
    let before = diffuse.clone();
    let mut spoilt = velocities.clone();
    spoilt[5].y = f32::NAN;
    let far = [Vec3::ZERO, Vec3::splat(1e30)];
    let cases: [(&[Vec3], &[Vec3], f32); 5] = [
        (&positions, &velocities[1..], 0.04),
        (&positions, &spoilt, 0.04),
        (&spoilt, &velocities, 0.04),
        (&far, &velocities[..2], 0.04),
        (&positions, &velocities, f32::NAN),
    ];
    for (positions, velocities, seconds) in cases {
        let frame = FluidFrame { positions, velocities };
        assert!(diffuse.advance(&Context::serial(), frame, seconds, &mut Silent).is_err());
        assert_eq!((diffuse.particles(), diffuse.progress()), (before.particles(), before.progress()));
    }
    for wrong in [
        DiffuseOptions { spacing: 0.0, ..options() },
        with(DiffuseSettings { air_min: 30.0, ..DiffuseSettings::default() }),
        with(DiffuseSettings { lifetime_min: 0.0, ..DiffuseSettings::default() }),
        with(DiffuseSettings { lifetime_min: 6.0, ..DiffuseSettings::default() }),
        with(DiffuseSettings { bubbles_above: 5, ..DiffuseSettings::default() }),
        with(DiffuseSettings { drag: f32::NAN, ..DiffuseSettings::default() }),
        DiffuseOptions { settings: DiffuseSettings { steps: 0, ..DiffuseSettings::default() }, ..options() },
        DiffuseOptions { bounds: Some([Vec3::ONE, Vec3::ZERO]), ..options() },
    ] {
        assert!(Diffuse::new(wrong).is_err());
    }
}

#[test]
fn kinds_and_flows_are_the_sums_of_their_definitions() {
    let (fluid, velocities) = collision();
    let options = with(DiffuseSettings { air_rate: 0.0, crest_rate: 0.0, ..DiffuseSettings::default() });
    let spread = |at: u32, base: u32| (at * base % 997) as f32 / 997.0;
    let positions: Vec<Vec3> = (0..400)
        .map(|at| Vec3::new(0.7 * spread(at, 37) - 0.1, 0.4 * spread(at, 91) - 0.1, 0.4 * spread(at, 193) - 0.1))
        .collect();
    let count = positions.len();
    let start = DiffuseParticles {
        positions: positions.clone(),
        velocities: vec![Vec3::ZERO; count],
        kinds: vec![DiffuseKind::Spray; count],
        ages: vec![0.0; count],
        lifetimes: vec![9.0; count],
        ids: (0..count as u64).collect(),
    };
    let mut run = Diffuse::restore(options, start, 0, 0).unwrap();
    let frame = FluidFrame { positions: &fluid, velocities: &velocities };
    run.advance(&Context::serial(), frame, 0.01, &mut Silent).unwrap();
    let (found, mut kinds) = (run.particles(), [0; 3]);
    for (at, point) in positions.iter().enumerate() {
        let (mut neighbours, mut sum, mut weights) = (0, Vec3::ZERO, 0.0);
        for (place, velocity) in fluid.iter().zip(&velocities) {
            let share = point.distance(*place) / options.support();
            if share < 1.0 {
                let q = 2.0 * share;
                let weight = if q < 1.0 { 1.0 - 1.5 * q * q + 0.75 * q * q * q } else { 0.25 * (2.0 - q).powi(3) };
                (neighbours, sum, weights) = (neighbours + 1, sum + weight * *velocity, weights + weight);
            }
        }
        let kind = match neighbours {
            few if few < options.settings.spray_below => DiffuseKind::Spray,
            many if many > options.settings.bubbles_above => DiffuseKind::Bubble,
            _ => DiffuseKind::Foam,
        };
        assert_eq!(found.kinds[at], kind, "{point}");
        kinds[kind as usize] += 1;
        if kind == DiffuseKind::Foam {
            assert!((found.velocities[at] - sum / weights).length() < 1e-4, "{point}");
        }
    }
    assert!(kinds.iter().all(|count| *count > 0), "{kinds:?}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(16))]
    #[test]
    fn potentials_turn_and_move_with_the_fluid(angle in 0.0f32..6.0, x in -1.0f32..1.0, y in -1.0f32..1.0) {
        let (positions, velocities) = collision();
        let turn = Quat::from_axis_angle(Vec3::new(x, y, 1.0).normalize(), angle);
        let moved: Vec<_> = positions.iter().map(|position| turn * *position + Vec3::new(x, y, 0.5)).collect();
        let turned: Vec<_> = velocities.iter().map(|velocity| turn * *velocity).collect();
        let sum = |found: Vec<potential::Potentials>| found.iter().map(|one| f64::from(one.air * one.energy)).sum::<f64>();
        let (before, after) = (sum(of(&options(), &positions, &velocities)), sum(of(&options(), &moved, &turned)));
        // Particles at exactly the support radius may be within it or not.
        prop_assert!((before - after).abs() <= 2e-3 * before, "{} {}", before, after);
    }
}
