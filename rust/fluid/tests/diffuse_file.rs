//! Diffuse particles in files: all that they have comes back, runs go on from them, and velocities are found where a file
//! has none.

use glam::Vec3;
use relievo_core::Context;
use relievo_core::progress::Silent;
use relievo_fluid::{Diffuse, DiffuseKind, DiffuseOptions, DiffuseParticles, FluidFrame, differences};
use relievo_particleio::{Format, Particles, encode_frame, read, read_frame, write};

fn collision() -> (Vec<Vec3>, Vec<Vec3>) {
    let place = |n: u32| 0.02 * Vec3::new((n % 24) as f32, (n / 24 % 12) as f32, (n / 288) as f32);
    let positions: Vec<_> = (0..24 * 12 * 12).map(place).collect();
    let velocities = positions.iter().map(|at| Vec3::new(if at.x < 0.23 { 4.0 } else { -4.0 }, 0.0, 0.0)).collect();
    (positions, velocities)
}

fn run() -> Diffuse {
    let (positions, velocities) = collision();
    let frame = FluidFrame { positions: &positions, velocities: &velocities };
    let mut run = Diffuse::new(DiffuseOptions::default()).unwrap();
    for _ in 0..3 {
        run.advance(&Context::serial(), frame, 0.04, &mut Silent).unwrap();
    }
    assert!(run.particles().len() > 1000);
    run
}

#[test]
fn every_format_has_id_type_age_and_lifetime() {
    let (run, context, folder) = (run(), Context::serial(), tempfile::tempdir().unwrap());
    let particles = run.particles().to_file(0.12, 0.02).unwrap();
    for format in [Format::Cache, Format::Bgeo, Format::Vtk] {
        let path = folder.path().join("frame").with_extension(format.extension());
        write(&context, &path, &particles).unwrap();
        let found = read(&context, &path).unwrap().particles;
        assert_eq!(&DiffuseParticles::of_file(&found).unwrap(), run.particles(), "{format}");
    }
}

#[test]
fn a_run_goes_on_from_a_frame_and_other_frames_are_refused() {
    let (before, context) = (run(), Context::serial());
    let particles = before.particles().to_file(0.12, 0.02).unwrap();
    let encoded = encode_frame(&context, &particles, Some(&before.state("dam"))).unwrap();
    let frame = read_frame(&context, &encoded).unwrap();
    assert!(Diffuse::has_state(&frame));
    let (identity, after) = Diffuse::resume(DiffuseOptions::default(), &frame).unwrap().unwrap();
    assert_eq!((identity.as_str(), after.progress()), ("dam", before.progress()));
    assert_eq!(after.particles(), before.particles());
    let state = before.state("dam");
    for length in 0..state.len() {
        let cut = relievo_particleio::Frame { state: Some(state[..length].to_vec()), ..frame.clone() };
        assert!(Diffuse::resume(DiffuseOptions::default(), &cut).is_err());
    }
    let stateless = relievo_particleio::Frame { state: None, ..frame.clone() };
    assert!(Diffuse::resume(DiffuseOptions::default(), &stateless).unwrap().is_none());
    let spoil = |change: &dyn Fn(&mut Particles)| {
        let mut spoilt = particles.clone();
        change(&mut spoilt);
        DiffuseParticles::of_file(&spoilt)
    };
    assert!(spoil(&|it| it.numbers = None).is_err());
    assert!(spoil(&|it| drop(it.channels.remove(1))).is_err());
    assert!(spoil(&|it| it.channels[1].values[7] = 3.0).is_err());
    let many = DiffuseParticles {
        positions: vec![Vec3::ZERO],
        velocities: vec![Vec3::ZERO],
        kinds: vec![DiffuseKind::Foam],
        ages: vec![0.0],
        lifetimes: vec![1.0],
        ids: vec![1 << 32],
    };
    assert!(many.to_file(0.0, 0.02).is_err());
}

#[test]
fn velocities_are_differences_of_the_particles_in_both_frames() {
    let frame = |points: &[[f32; 3]], numbers: &[u32]| Particles {
        points: points.to_vec(),
        numbers: Some(numbers.to_vec()),
        ..Particles::default()
    };
    let before = frame(&[[0.0; 3], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]], &[5, 9, 2]);
    let after = frame(&[[2.5, 0.0, 0.0], [7.0, 7.0, 7.0], [0.0, 1.0, 0.0]], &[2, 11, 5]);
    let (positions, velocities) = differences(&before, &after, 0.5).unwrap();
    assert_eq!(positions, [Vec3::new(2.5, 0.0, 0.0), Vec3::new(0.0, 1.0, 0.0)]);
    assert_eq!(velocities, [Vec3::new(1.0, 0.0, 0.0), Vec3::new(0.0, 2.0, 0.0)]);
    let unnumbered = Particles { numbers: None, ..after };
    assert!(differences(&before, &unnumbered, 0.5).is_err());
}
