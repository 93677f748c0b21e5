//! Fluids in domains do what undivided ones do.

use glam::{Vec3, Vec4Swizzles};
use relievo_core::{Context, Result};
use relievo_fluid::{
    ColliderOptions, Emitter, Fluid, FluidOptions, Force, InProcess, PressureSolver, Sink, Sources, State,
    StepStatistics, TimeStep, Traffic, Transport, basin, block, cuboid,
};

const SPACING: f32 = 0.05;
const STEPS: usize = 50;

/// A dam that breaks over a box, in wind.
fn dam(options: FluidOptions) -> Fluid {
    let context = Context::serial();
    let mut fluid = Fluid::new(FluidOptions { spacing: SPACING, ..options }).unwrap();
    fluid.set_walls(&context, &basin(Vec3::ZERO, Vec3::new(1.5, 0.4, 1.0), SPACING).unwrap()).unwrap();
    let (points, triangles) = cuboid(Vec3::new(0.7, 0.1, 0.0), Vec3::new(0.85, 0.25, 0.2));
    fluid.add_collider(&context, &points, &triangles, ColliderOptions::default()).unwrap();
    fluid.add(&block(Vec3::ZERO, Vec3::new(0.5, 0.4, 0.8), SPACING).unwrap(), Vec3::X).unwrap();
    fluid.set_channel("number", 1, &(0..fluid.len()).map(|at| at as f32).collect::<Vec<_>>()).unwrap();
    fluid.set_forces(&[Force::Wind { velocity: Vec3::X, share: 0.5 }]).unwrap();
    fluid
}

/// Makes steps, which are as long on all ranks.
fn steps(fluid: &mut Fluid, count: usize) -> Result<Vec<StepStatistics>> {
    (0..count).map(|_| fluid.step(&Context::serial(), fluid.time_step())).collect()
}

/// Runs a rank in a thread of its own for each transport.
fn on_ranks<T: Send>(ranks: usize, run: impl Fn(InProcess) -> T + Sync) -> Vec<T> {
    std::thread::scope(|scope| {
        let threads: Vec<_> =
            InProcess::new(ranks).into_iter().map(|transport| scope.spawn(|| run(transport))).collect();
        threads.into_iter().map(|thread| thread.join().unwrap()).collect()
    })
}

fn options(solver: PressureSolver) -> FluidOptions {
    FluidOptions { solver, ..FluidOptions::default() }
}

#[test]
fn one_two_and_four_domains_move_particles_as_one_fluid() {
    let kinds = [
        options(PressureSolver::Pcisph),
        options(PressureSolver::Dfsph),
        FluidOptions { tension: 0.07, time_step: TimeStep::Fixed(1e-3), ..options(PressureSolver::Pcisph) },
    ];
    for kind in kinds {
        let mut whole = dam(kind.clone());
        let expected = steps(&mut whole, STEPS).unwrap();
        let state = whole.state();
        for ranks in [1, 2, 4] {
            let runs = on_ranks(ranks, |transport| {
                let mut fluid = dam(kind.clone());
                fluid.distribute(Box::new(transport)).unwrap();
                let done = steps(&mut fluid, STEPS).unwrap();
                (done, fluid.gather().unwrap(), fluid.traffic())
            });
            assert!(runs.iter().skip(1).all(|(_, state, _)| state.is_none()));
            let gathered = runs[0].1.as_ref().unwrap();
            is_same(gathered, &state, ranks);
            for (done, _, _) in &runs {
                for (done, expected) in done.iter().zip(&expected) {
                    assert_eq!((done.seconds, done.corrections), (expected.seconds, expected.corrections), "{ranks}");
                    let given = [done.given.gravity, done.given.forces, done.given.walls];
                    let before = [expected.given.gravity, expected.given.forces, expected.given.walls];
                    let scale = expected.given.gravity.length();
                    let is_near = given.iter().zip(before).all(|(a, b)| a.distance(b) < 1e-6 * (scale + b.length()));
                    assert!(is_near, "{ranks}: {given:?} {before:?}");
                }
            }
            let traffic: Vec<Traffic> = runs.iter().map(|(_, _, traffic)| *traffic).collect();
            assert_eq!(traffic.iter().map(|traffic| traffic.owned).sum::<usize>(), whole.len());
            // The curve is divided where each rank has about as many particles.
            let fair = whole.len() as f64 / ranks as f64;
            assert!(traffic.iter().all(|traffic| (traffic.owned as f64 / fair - 1.0).abs() < 0.1), "{traffic:?}");
            assert_eq!(traffic.iter().all(|traffic| traffic.refreshed > 0 && traffic.copies > 0), ranks > 1);
        }
    }
}

/// Two jets, of which one has a colour and one lives for a short time, and a sink.
fn sources(budget: usize) -> Sources {
    let disc = |middle, normal, speed| Emitter::disc(middle, normal, 0.12, speed, SPACING).unwrap();
    let mut jet = disc(Vec3::new(0.2, 0.2, 0.9), Vec3::X, 3.0);
    jet.channels.push(("color".into(), vec![0.2, 0.4, 0.8]));
    let mut rain = disc(Vec3::new(1.1, 0.2, 0.8), Vec3::NEG_Z, 4.0);
    (rain.lifetime, rain.time) = (0.08, [0.02, 0.2]);
    let sinks = vec![Sink::Inside([Vec3::new(0.9, 0.0, 0.0), Vec3::new(1.5, 0.4, 0.15)])];
    Sources { emitters: vec![jet, rain], sinks, budget: Some(budget), overflow: relievo_fluid::Overflow::Stop }
}

#[test]
fn emitters_and_sinks_of_domains_do_what_those_of_one_fluid_do() {
    let run = |transport: Option<InProcess>, is_empty: bool, budget: usize| {
        let context = Context::serial();
        let mut fluid = match is_empty {
            true => Fluid::new(FluidOptions { spacing: SPACING, ..options(PressureSolver::Dfsph) }).unwrap(),
            false => dam(options(PressureSolver::Dfsph)),
        };
        if let Some(transport) = transport {
            fluid.distribute(Box::new(transport)).unwrap();
        }
        let (sources, mut added) = (sources(budget), 0);
        let mut since = 0.0;
        let renewed = |fluid: &mut Fluid, _: &StepStatistics| {
            added += sources.renew(fluid, since)?[0];
            since = fluid.seconds();
            Ok(())
        };
        fluid.advance(&context, 0.3, renewed).unwrap();
        (fluid.gather().unwrap(), added)
    };
    for (is_empty, budget) in [(false, usize::MAX), (true, 500)] {
        let (expected, births) = run(None, is_empty, budget);
        let expected = expected.unwrap();
        assert!(births > 100 && (expected.numbers.len() as u32) < expected.next, "{births}");
        for ranks in [1, 2, 3] {
            let runs = on_ranks(ranks, |transport| run(Some(transport), is_empty, budget));
            assert!(runs[0].0.as_ref() == Some(&expected), "{ranks} ranks");
            assert!(runs.iter().all(|(_, added)| *added == births));
        }
    }
}

/// The same particles, at places within 1e-5 of the support radius.
fn is_same(found: &State, expected: &State, ranks: usize) {
    let sorted = |state: &State| {
        let mut rows: Vec<_> = (0..state.numbers.len()).collect();
        rows.sort_by_key(|row| state.numbers[*row]);
        rows
    };
    let (ours, theirs) = (sorted(found), sorted(expected));
    assert_eq!(ours.len(), theirs.len(), "{ranks}");
    let mut farthest = 0.0f32;
    for (a, b) in ours.into_iter().zip(theirs) {
        assert_eq!(found.numbers[a], expected.numbers[b], "{ranks}");
        assert_eq!(found.channels[0].values[a], expected.channels[0].values[b], "{ranks}");
        farthest = farthest.max(found.places[a].xyz().distance(expected.places[b].xyz()));
    }
    println!("{ranks} ranks: {} of the support radius", farthest / (2.0 * SPACING));
    assert!(farthest < 1e-5 * 2.0 * SPACING, "{ranks} ranks: {farthest} m");
    // Sums go over neighbours in the same order, so that not even bits differ.
    assert!(found == expected, "{ranks} ranks");
}

#[test]
fn a_rank_that_ends_is_an_error_on_the_others_and_they_go_on_from_the_last_state() {
    let mut whole = dam(options(PressureSolver::Dfsph));
    steps(&mut whole, 10).unwrap();
    let middle = whole.state();
    steps(&mut whole, 10).unwrap();
    let errors = on_ranks(3, |transport| {
        let ends = transport.rank() == 1;
        let mut fluid = dam(options(PressureSolver::Dfsph));
        fluid.distribute(Box::new(transport)).unwrap();
        steps(&mut fluid, 5).unwrap();
        if ends { String::new() } else { steps(&mut fluid, 5).unwrap_err().to_string() }
    });
    assert!([0, 2].iter().all(|rank| errors[*rank].contains("has ended")), "{errors:?}");
    let states = on_ranks(2, |transport| {
        let mut fluid = dam(options(PressureSolver::Dfsph));
        fluid.distribute(Box::new(transport)).unwrap();
        fluid.set_state(middle.clone()).unwrap();
        steps(&mut fluid, 10).unwrap();
        fluid.gather().unwrap()
    });
    assert!(states[0].as_ref() == Some(&whole.state()));
}

/// A transport that cuts the messages of one exchange.
struct Cutting {
    inner: InProcess,
    left: usize,
}

impl Transport for Cutting {
    fn rank(&self) -> usize {
        self.inner.rank()
    }

    fn ranks(&self) -> usize {
        self.inner.ranks()
    }

    fn exchange(&mut self, sent: Vec<Vec<u8>>) -> Result<Vec<Vec<u8>>> {
        let mut received = self.inner.exchange(sent)?;
        if self.left == 0 {
            received.iter_mut().for_each(|message| message.truncate(message.len().saturating_sub(1)));
        }
        self.left = self.left.wrapping_sub(1);
        Ok(received)
    }
}

#[test]
fn a_message_that_is_cut_is_an_error() {
    for left in 0..40 {
        let ends = on_ranks(2, |inner| {
            let mut fluid = dam(options(PressureSolver::Dfsph));
            fluid.distribute(Box::new(Cutting { inner, left })).unwrap();
            steps(&mut fluid, 3).is_err()
        });
        assert_eq!(ends, [true, true], "{left}");
    }
}

#[test]
fn what_domains_cannot_do_is_refused() {
    on_ranks(2, |transport| {
        let mut fluid = dam(options(PressureSolver::Pcisph));
        fluid.distribute(Box::new(transport)).unwrap();
        assert!(fluid.add(&[Vec3::splat(0.2)], Vec3::ZERO).is_err());
        assert!(fluid.densities(&Context::serial()).is_err());
        let [other] = <[InProcess; 1]>::try_from(InProcess::new(1)).ok().unwrap();
        assert!(fluid.distribute(Box::new(other)).is_err());
        steps(&mut fluid, 1).unwrap();
    });
    let mut alone = InProcess::new(1).remove(0);
    assert!(alone.exchange(Vec::new()).is_err());
    assert_eq!(alone.gather(vec![1, 2]).unwrap(), [[1, 2]]);
}
