//! Screen-space foam against closed forms: one particle of each kind, occlusion, irradiance and composition; order and
//! threads; and what is refused.

use std::process::Command;

use glam::DVec3;
use relievo_core::parameter::Switch;
use relievo_core::progress::Silent;
use relievo_core::simd::Level;
use relievo_core::{Context, ContextOptions, ErrorKind};
use relievo_render::foam::{
    Environment, Extinction, Foam, FoamKind, FoamLayers, FoamParticle, FoamSettings, FoamView, Lens, Scenery,
};
use relievo_render::{Camera, Content, Image, Lights, read_exr, write_exr};

const SIZE: u32 = 65;
/// The number of the pixel in the middle.
const MIDDLE: usize = (SIZE * SIZE / 2) as usize;

/// A view straight down on the origin from a height of 5, x to the right and y up.
fn view() -> FoamView {
    let camera = Camera::look_at(DVec3::new(0.0, 0.0, 5.0), DVec3::ZERO, DVec3::Y, 0.8).unwrap();
    FoamView { camera, lens: Lens::Perspective, width: SIZE, height: SIZE }
}

/// Pixels of a metre at a depth.
fn scale(depth: f32) -> f32 {
    0.5 * SIZE as f32 / 0.4f32.tan() / depth
}

fn particle(position: [f32; 3], id: u32, kind: FoamKind) -> FoamParticle {
    FoamParticle { position, life: 0.0, id, kind }
}

fn large() -> FoamSettings {
    FoamSettings { radius: 0.5, ..FoamSettings::default() }
}

fn white() -> Environment {
    Environment::uniform([1.0; 3]).unwrap()
}

fn layers(settings: FoamSettings, scenery: &Scenery, particles: &[FoamParticle]) -> FoamLayers {
    let context = Context::serial();
    let mut foam = Foam::new(&context, settings, view(), scenery).unwrap();
    foam.add(&context, particles).unwrap();
    foam.finish(&context, &white(), &mut Silent).unwrap()
}

/// Depths by the column of a pixel, −1 to 1 across the picture.
fn depths(of: impl Fn(f32) -> f32) -> Option<Image> {
    let column = |x: u32| (x as f32 + 0.5) / (0.5 * SIZE as f32) - 1.0;
    let data = (0..SIZE * SIZE).map(|at| of(column(at % SIZE))).collect();
    Some(Image::from_data(SIZE, SIZE, 1, data).unwrap())
}

/// Numbers from 0 to 1, the same in every run.
fn numbers() -> impl FnMut() -> f32 {
    let mut state = 1u32;
    move || {
        state = state.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
        (state >> 8) as f32 / (1 << 24) as f32
    }
}

#[test]
fn a_particle_of_each_kind_has_depth_thickness_and_intensity_in_closed_form() {
    let kinds = [(FoamKind::Spray, 0.5, 1.5), (FoamKind::Foam, 0.5, 2.25), (FoamKind::Bubble, 0.25, 2.0)];
    for (kind, radius, n) in kinds {
        for id in 0..7 {
            let radius = radius / (id % 5 + 1) as f32;
            let found = layers(large(), &Scenery::default(), &[particle([0.0; 3], id, kind)]);
            let pixels = radius * scale(5.0);
            let mut covered = 0;
            for at in 0..(SIZE * SIZE) as usize {
                let [x, y] = [at % SIZE as usize, at / SIZE as usize].map(|at| (at as f32 - 32.0) / pixels);
                let square = x * x + y * y;
                if square > 1.0 {
                    assert!(found.thickness()[at] == 0.0 && found.depth()[at].is_infinite());
                    continue;
                }
                covered += 1;
                let depth = 5.0 - (1.0 - square).sqrt() * radius;
                assert!((found.depth()[at] - depth).abs() < 1e-5);
                let falloff = 1.0 - square.sqrt().powf(n);
                let expected = if kind == FoamKind::Bubble { 1.0 - falloff } else { falloff };
                assert!((found.thickness()[at] - expected).abs() < 1e-4, "{kind:?} {square}");
                let powered = found.thickness()[at].powf(1.25);
                assert!((found.intensity()[at] - powered / (3.0 + powered)).abs() < 1e-6);
                let [nx, ny, nz] = found.normal(at);
                assert!((nx - x).abs() < 1e-4 && (ny + y).abs() < 1e-4 && nz >= 0.0);
                assert!((found.search_radius()[at] - pixels).abs() < 1e-3);
            }
            assert!(covered > 0);
        }
    }
}

#[test]
fn lifetimes_and_the_fluid_fade_particles_and_solids_hide_them() {
    let old = FoamParticle { life: 0.5, ..particle([0.0; 3], 0, FoamKind::Spray) };
    let faded = layers(large(), &Scenery::default(), &[old]);
    assert!((faded.thickness()[MIDDLE] - 0.75f32.powf(0.4)).abs() < 1e-5);
    let gone = FoamParticle { life: 1.0, ..old };
    assert_eq!(layers(large(), &Scenery::default(), &[gone]).thickness()[MIDDLE], 0.0);
    // The front of the particle is 0.2 behind the surface of the fluid.
    let fluid = Scenery { fluid: depths(|_| 4.3), solids: None };
    let attenuated = layers(large(), &fluid, &[particle([0.0; 3], 0, FoamKind::Spray)]);
    assert!((attenuated.thickness()[MIDDLE] - (1.0 - 0.2f32 / 0.5).powi(2)).abs() < 1e-4);
    let deep = Scenery { fluid: depths(|_| 3.0), solids: None };
    assert_eq!(layers(large(), &deep, &[particle([0.0; 3], 0, FoamKind::Spray)]).thickness()[MIDDLE], 0.0);
    let half = Scenery { fluid: None, solids: depths(|x| if x < 0.0 { 4.0 } else { f32::INFINITY }) };
    let hidden = layers(large(), &half, &[particle([0.0; 3], 0, FoamKind::Spray)]);
    assert_eq!(hidden.thickness()[MIDDLE - 3], 0.0);
    assert!(hidden.thickness()[MIDDLE + 3] > 0.5);
}

#[test]
fn sprites_below_a_pixel_keep_their_mean_thickness() {
    // Particles of a tenth of a pixel have the thickness of their falloff's mean times their area.
    let settings = FoamSettings { radius: 0.1 / scale(5.0), ..FoamSettings::default() };
    let (count, mut number) = (160_000, numbers());
    // Over a whole number of pixels, so that all places within a pixel are as frequent.
    let mut place = || 16.0 / scale(5.0) * (number() - 0.5);
    let grid = (0..count).map(|n| particle([place(), place(), 0.0], 5 * n, FoamKind::Spray));
    let found = layers(settings, &Scenery::default(), &grid.collect::<Vec<_>>());
    let sum: f64 = found.thickness().iter().map(|thickness| f64::from(*thickness)).sum();
    // The mean of 1 − x^1.5 over the disc is 1 − 2/3.5.
    let expected = f64::from(count) * std::f64::consts::PI * 0.01 * (1.0 - 2.0 / 3.5);
    assert!((sum / expected - 1.0).abs() < 0.01, "{sum} {expected}");
}

#[test]
fn layers_have_the_same_bits_in_any_order_and_for_any_number_of_threads() {
    let (mut cloud, mut number) = (Vec::new(), numbers());
    for id in 0..20_000 {
        let position = [0, 1, 2].map(|_| 3.0 * number() - 1.5);
        let kind = [FoamKind::Spray, FoamKind::Foam, FoamKind::Bubble][id as usize % 3];
        // Numbers come twice.
        cloud.push(FoamParticle { position, life: number(), id: id / 2, kind });
    }
    let scenery = Scenery { fluid: depths(|x| 5.0 + x), solids: depths(|x| 5.5 - x) };
    let render = |threads: usize, particles: &[FoamParticle], chunk: usize| {
        let context = Context::new(&ContextOptions { threads, memory_limit: 0 }).unwrap();
        let settings = FoamSettings { radius: 0.1, ..FoamSettings::default() };
        let mut foam = Foam::new(&context, settings, view(), &scenery).unwrap();
        particles.chunks(chunk).for_each(|chunk| foam.add(&context, chunk).unwrap());
        assert_eq!(foam.particles(), 20_000);
        let layers = foam.finish(&context, &white(), &mut Silent).unwrap();
        let background = Image::new(SIZE, SIZE, 3).unwrap();
        (layers.exr_layer(), layers.composite(&context, &background).unwrap())
    };
    let first = render(1, &cloud, usize::MAX);
    let reversed: Vec<_> = cloud.iter().rev().copied().collect();
    for (threads, particles, chunk) in [(3, &cloud, usize::MAX), (2, &reversed, 777), (1, &reversed, 19_999)] {
        let other = render(threads, particles, chunk);
        let bits = |image: &Image| image.data().iter().map(|value| value.to_bits()).collect::<Vec<_>>();
        assert_eq!(bits(&other.1), bits(&first.1));
        for (a, b) in first.0.channels.iter().zip(&other.0.channels) {
            assert_eq!(format!("{:?}", a.samples), format!("{:?}", b.samples), "{}", a.name);
        }
    }
}

#[test]
fn a_flat_sheet_is_not_occluded_and_a_corner_is_the_more_the_further_it_closes() {
    // The middles of particles on a lattice of pixels show the sheet's own normal.
    let pixel = scale(5.0).recip();
    let lattice = |at: u32| 4.0 * pixel * (at as f32 - 6.0);
    let sheet: Vec<_> =
        (0..169).map(|n| particle([lattice(n % 13), lattice(n / 13), 0.0], 5 * n, FoamKind::Foam)).collect();
    let settings = FoamSettings { radius: 3.0 * pixel, ..FoamSettings::default() };
    let fluid = Scenery { fluid: depths(|_| 5.0), solids: None };
    for scenery in [Scenery::default(), fluid] {
        let found = layers(settings, &scenery, &sheet);
        for (row, column) in (0..13).flat_map(|row| (0..13).map(move |column| (row, column))) {
            let at = (8 + 4 * row) * SIZE as usize + 8 + 4 * column;
            assert!(found.intensity()[at] > 0.0);
            assert_eq!(found.occlusion()[at], 0.0, "{row} {column}");
        }
    }
    let corner = |slope: f32| {
        let walls = Scenery { fluid: None, solids: depths(|x| 5.0 - slope * x.abs()) };
        let settings = FoamSettings { radius: 0.08, ..FoamSettings::default() };
        layers(settings, &walls, &[particle([0.0, 0.0, 0.09], 0, FoamKind::Foam)]).occlusion()[MIDDLE]
    };
    let found = [0.0, 1.0, 2.0, 4.0, 8.0].map(corner);
    assert_eq!(found[0], 0.0);
    assert!(found.is_sorted_by(|a, b| a < b) && found[4] > 0.3, "{found:?}");
    // With samples on both sides, as in the paper, half of those about a flat place are behind it.
    let both =
        FoamSettings { ao_hemisphere: Switch::OFF, ao_solid_opacity: 1.0, radius: 0.08, ..FoamSettings::default() };
    let wall = Scenery { fluid: None, solids: depths(|_| 4.9201) };
    let found = layers(both, &wall, &[particle([0.0; 3], 0, FoamKind::Foam)]).occlusion()[MIDDLE];
    assert!((found - 0.5).abs() < 0.05, "{found}");
}

/// Returns the digits of an index mirrored at the point.
fn mirrored(mut index: u32, base: u32) -> f64 {
    let (mut value, mut digit) = (0.0, 1.0);
    while index > 0 {
        digit /= f64::from(base);
        value += digit * f64::from(index % base);
        index /= base;
    }
    value
}

/// Occlusion of a pixel of `view()` or of its parallel form by the formulas of Section 2.4.1, sample by sample in f64.
fn occlusion_of(
    settings: &FoamSettings,
    view: &FoamView,
    found: &FoamLayers,
    [fluid, solids]: [&Image; 2],
    at: usize,
) -> f64 {
    let half = 0.5 * f64::from(SIZE);
    let scale_at = |depth: f64| match view.lens {
        Lens::Perspective => half / 0.4f64.tan() / depth,
        Lens::Orthographic(metres) => f64::from(SIZE) / metres,
    };
    let depth = f64::from(found.depth()[at]);
    let [x, y] = [at % SIZE as usize, at / SIZE as usize].map(|at| at as f64 + 0.5);
    let metres = scale_at(depth).recip();
    let place = DVec3::new((x - half) * metres, (half - y) * metres, depth);
    let [nx, ny, nz] = found.normal(at).map(f64::from);
    let share = |there: f64, front: f32, opacity: f32| {
        let behind = there - f64::from(front);
        let near = (1.0 - behind / f64::from(settings.ao_max_occl_dist)).max(0.0);
        if behind > 0.0 { near * near * f64::from(opacity) } else { 0.0 }
    };
    let (mut sum, mut weights) = (0.0, 0.0);
    for pass in 0..settings.ao_passes {
        let radius = found.search_radius()[at] * (settings.ao_init_sr_fac + settings.ao_sr_inc_fac * pass as f32);
        let count = (0.75 * std::f64::consts::PI * f64::from(radius).powi(3) * f64::from(settings.ao_s_dens)) as u32;
        for index in 1..=count.min(settings.ao_max_samp).max(settings.ao_min_samp) {
            let mut offset = DVec3::from([2, 3, 5].map(|base| 2.0 * mirrored(index, base) - 1.0));
            if offset.length() > 1.0 {
                continue;
            }
            let weight = (1.0 - offset.length()).powi(2);
            if settings.ao_hemisphere.is_on() && offset.dot(DVec3::new(nx, ny, -nz)) < 0.0 {
                offset = -offset;
            }
            let there = place + f64::from(radius) * metres * offset;
            let [column, row] = [half + scale_at(there.z) * there.x, half - scale_at(there.z) * there.y];
            if there.z <= 0.0 || column.min(row) < 0.0 || column.max(row) >= f64::from(SIZE) {
                continue;
            }
            let pixel = row as usize * SIZE as usize + column as usize;
            let foam = share(there.z, found.depth()[pixel], found.intensity()[pixel]);
            let fluid = share(there.z, fluid.data()[pixel], settings.ao_fluid_opacity);
            let solids = share(there.z, solids.data()[pixel], settings.ao_solid_opacity);
            weights += weight;
            sum += weight * (foam + fluid + solids).min(1.0);
        }
    }
    if weights > 0.0 { sum / weights } else { 0.0 }
}

#[test]
fn occlusion_is_that_of_the_formulas_sample_by_sample() {
    // Over the whole picture and its border, so that samples leave it, and near the camera, so that they come behind that.
    let (mut cloud, mut number) = (vec![particle([0.1, 0.08, 4.6], 9, FoamKind::Spray)], numbers());
    for id in 0..300 {
        cloud.push(particle([0; 3].map(|_| 4.4 * number() - 2.2), id, FoamKind::Foam));
    }
    let solids = depths(|x| if x < 0.3 { f32::INFINITY } else { 7.0 - x });
    let scenes = [Scenery::default(), Scenery { fluid: depths(|x| 5.0 + x), solids }];
    let nothing = Image::from_data(SIZE, SIZE, 1, vec![f32::INFINITY; (SIZE * SIZE) as usize]).unwrap();
    let context = Context::serial();
    for (settings, lens) in [
        (FoamSettings { radius: 0.2, ao_max_samp: 100, ..FoamSettings::default() }, Lens::Perspective),
        (
            FoamSettings { radius: 0.2, ao_max_samp: 41, ao_min_samp: 41, ao_passes: 2, ..FoamSettings::default() },
            // Not a height at which many samples lie at the borders of pixels.
            Lens::Orthographic(3.917),
        ),
        (
            FoamSettings {
                radius: 0.2,
                ao_max_samp: 64,
                ao_hemisphere: Switch::OFF,
                ao_max_occl_dist: 0.5,
                ..FoamSettings::default()
            },
            Lens::Perspective,
        ),
    ] {
        let view = FoamView { lens, ..view() };
        for scenery in &scenes {
            let mut foam = Foam::new(&context, settings, view, scenery).unwrap();
            foam.add(&context, &cloud).unwrap();
            let found = foam.finish(&context, &white(), &mut Silent).unwrap();
            let lists = [&scenery.fluid, &scenery.solids].map(|image| image.as_ref().unwrap_or(&nothing));
            let covered: Vec<_> = (0..(SIZE * SIZE) as usize).filter(|at| found.intensity()[*at] > 0.0).collect();
            let far = covered.iter().filter(|at| {
                let expected = occlusion_of(&settings, &view, &found, lists, **at);
                (f64::from(found.occlusion()[**at]) - expected).abs() > 1e-4
            });
            // A sample at the border of two pixels may be in either.
            let (far, mean) = (far.count(), found.occlusion().iter().sum::<f32>() / covered.len() as f32);
            assert!(covered.len() > 500 && mean > 0.01, "{} {mean}", covered.len());
            assert!(far <= covered.len() / 200, "{far} of {} pixels", covered.len());
        }
    }
}

#[test]
fn occlusion_is_the_same_at_every_instruction_level() {
    let name = "occlusion_is_that_of_the_formulas_sample_by_sample";
    for (level, level_name) in Level::NAMES.into_iter().filter(|(level, _)| *level < Level::best()) {
        // The level of a context is that of its process.
        let mut again = Command::new(std::env::current_exe().unwrap());
        let found =
            again.args(["--exact", &format!("passes::{name}")]).env("RELIEVO_SIMD", level_name).output().unwrap();
        let text = String::from_utf8_lossy(&found.stdout).into_owned();
        assert!(found.status.success() && text.contains("1 passed"), "{level:?}: {text}");
    }
}

#[test]
fn a_white_environment_lights_with_one_and_a_sun_from_its_side() {
    let sphere = [particle([0.0; 3], 0, FoamKind::Foam)];
    for map in [Switch::ON, Switch::OFF] {
        let found = layers(FoamSettings { irradiance_map: map, ..large() }, &Scenery::default(), &sphere);
        for (irradiance, intensity) in found.irradiance().iter().zip(found.intensity()) {
            let expected = if *intensity > 0.0 { 1.0 } else { 0.0 };
            assert!(irradiance.iter().all(|value| (value - expected).abs() < 1e-5), "{irradiance:?}");
        }
    }
    // A white surface that faces the sun has the radiance of the irradiance divided by π.
    let mut lights = Lights::default();
    (lights.sky.zenith, lights.sky.horizon, lights.sky.ground) = ([0.0; 3], [0.0; 3], [0.0; 3]);
    (lights.suns[0].direction, lights.suns[0].irradiance) = ([0.0, 0.0, 1.0], [3.0, 2.0, 1.0]);
    let context = Context::serial();
    let mut foam = Foam::new(&context, large(), view(), &Scenery::default()).unwrap();
    foam.add(&context, &sphere).unwrap();
    let found = foam.finish(&context, &Environment::of_lights(&lights).unwrap(), &mut Silent).unwrap();
    let [r, g, b] = found.irradiance()[MIDDLE].map(|value| value * std::f32::consts::PI);
    assert!((r - 3.0).abs() < 0.1 && (g - 2.0).abs() < 0.1 && (b - 1.0).abs() < 0.1, "{r} {g} {b}");
    let left = found.irradiance()[MIDDLE - 5][0];
    assert!(left < found.irradiance()[MIDDLE][0]);
}

#[test]
fn composition_is_that_of_the_paper_and_no_particles_change_nothing() {
    let context = Context::serial();
    let background = Image::from_data(SIZE, SIZE, 4, [0.1, 0.2, 0.4, 0.9].repeat((SIZE * SIZE) as usize)).unwrap();
    let nothing = layers(large(), &Scenery::default(), &[]);
    assert_eq!(nothing.composite(&context, &background).unwrap(), background);
    // A shadow everywhere, by the offset alone.
    let settings = FoamSettings { ao_passes: 0, ao_sh_offset: 0.25, ..large() };
    let found = layers(settings, &Scenery::default(), &[particle([0.0; 3], 0, FoamKind::Foam)]);
    let picture = found.composite(&context, &background).unwrap();
    for at in [MIDDLE, MIDDLE + 2, 0] {
        let intensity = found.intensity()[at];
        let foam = [1.0 - 0.25, 1.0 - 0.25, 1.0 - 0.25 * 0.8];
        for (part, foam) in foam.into_iter().enumerate() {
            let expected = (1.0 - intensity) * background.data()[4 * at + part] + intensity * foam;
            assert!((picture.data()[4 * at + part] - expected).abs() < 1e-5);
        }
        assert_eq!(picture.data()[4 * at + 3], 0.9);
    }
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("layers.exr");
    write_exr(&path, &[found.exr_layer()], Content::Data).unwrap();
    let layer = read_exr(&path, u64::MAX).unwrap().remove(0);
    assert_eq!(layer.channel("foam.intensity").unwrap().to_f32(), found.intensity());
    assert_eq!(layer.channel("foam.normal.Z").unwrap().to_f32()[MIDDLE], found.normal(MIDDLE)[2]);
    let mut noise = background.clone();
    noise.data_mut()[0] = 0.3;
    assert_eq!(found.composite(&context, &noise).unwrap().data()[0], 0.3);
}

#[test]
fn an_orthographic_camera_shows_all_depths_in_one_size() {
    let context = Context::serial();
    let view = FoamView { lens: Lens::Orthographic(4.0), ..view() };
    for z in [-20.0, 0.0, 3.0] {
        let mut foam = Foam::new(&context, large(), view, &Scenery::default()).unwrap();
        foam.add(&context, &[particle([1.0, 0.0, z], 0, FoamKind::Foam)]).unwrap();
        let found = foam.finish(&context, &white(), &mut Silent).unwrap();
        let row: Vec<usize> = (0..SIZE as usize).filter(|x| found.thickness()[32 * SIZE as usize + x] > 0.0).collect();
        // A metre has 16.25 pixels: the middle is at 48.75, the radius 8.125.
        assert_eq!((row[0], row[row.len() - 1]), (41, 56));
        assert!((found.depth()[32 * SIZE as usize + 48] - (5.0 - z - 0.5)).abs() < 1e-3);
    }
}

#[test]
fn bad_input_is_refused_and_cameras_within_foam_see_a_picture() {
    let context = Context::serial();
    let make = |settings, view, scenery: &Scenery| Foam::new(&context, settings, view, scenery).map(drop);
    let small = Scenery { solids: Some(Image::new(8, 8, 1).unwrap()), fluid: None };
    assert!(make(large(), view(), &small).unwrap_err().to_string().contains("solids"));
    assert!(make(FoamSettings { rho_mod: f32::NAN, ..large() }, view(), &Scenery::default()).is_err());
    assert!(make(large(), FoamView { width: 0, ..view() }, &Scenery::default()).is_err());
    assert!(make(large(), FoamView { lens: Lens::Orthographic(f64::NAN), ..view() }, &Scenery::default()).is_err());
    let bounded = Context::new(&ContextOptions { threads: 1, memory_limit: 1 << 20 }).unwrap();
    let error = Foam::new(&bounded, large(), view(), &Scenery::default()).unwrap_err();
    assert_eq!(error.kind, ErrorKind::Memory);
    let mut foam = Foam::new(&context, large(), view(), &Scenery::default()).unwrap();
    for wrong in [[f32::NAN, 0.0, 0.0], [0.0, f32::INFINITY, 0.0]] {
        let pair = [particle([0.0; 3], 0, FoamKind::Foam), particle(wrong, 1, FoamKind::Foam)];
        assert!(foam.add(&context, &pair).unwrap_err().to_string().contains("particle 1"));
    }
    assert_eq!(foam.particles(), 0);
    // At the camera, behind it, beside it, and as far away as numbers go.
    let places =
        [[0.0, 0.0, 5.0], [0.0, 0.0, 4.9], [0.0, 0.0, 9.0], [3e38, 0.0, 0.0], [0.0, 0.0, -3e38], [9.0, 0.0, 4.9]];
    let all: Vec<_> = places.into_iter().zip(0..).map(|(at, id)| particle(at, id, FoamKind::Foam)).collect();
    foam.add(&context, &all).unwrap();
    let found = foam.finish(&context, &white(), &mut Silent).unwrap();
    let picture = found.composite(&context, &Image::new(SIZE, SIZE, 3).unwrap()).unwrap();
    assert!(picture.data().iter().all(|value| (0.0..=1.0).contains(value)));
    assert!(found.composite(&context, &Image::new(SIZE, SIZE, 1).unwrap()).is_err());
    assert!(found.composite(&context, &Image::new(SIZE, 3, 3).unwrap()).is_err());
    let environment = |value: f32, width: u32| {
        let data = vec![value; 3 * (width * 16) as usize];
        Environment::of_image(&Image::from_data(width, 16, 3, data).unwrap(), [0.0, 0.0, 1.0])
    };
    assert!(environment(f32::NAN, 32).is_err() && environment(-1.0, 32).is_err() && environment(1.0, 16).is_err());
    assert!(environment(f32::INFINITY, 32).is_ok());
    let cancelled = Foam::new(&context, large(), view(), &Scenery::default()).unwrap();
    let error = cancelled.finish(&context, &white(), &mut |_: f32, _: &str| false).unwrap_err();
    assert_eq!(error.kind, ErrorKind::Cancelled);
}

/// Returns the sum of thickness and the number of pixels that have some.
fn spread(layers: &FoamLayers) -> (f64, usize) {
    let thickness = layers.thickness();
    (thickness.iter().map(|value| f64::from(*value)).sum(), thickness.iter().filter(|value| **value > 0.0).count())
}

#[test]
fn a_lens_spreads_what_is_out_of_focus_and_keeps_its_thickness() {
    let at = |aperture: f32, focus: f32| FoamSettings { aperture, focus, ..large() };
    let one = [particle([0.0; 3], 1, FoamKind::Spray)];
    let of = |settings| layers(settings, &Scenery::default(), &one);
    let pinhole = of(large());
    assert!(of(at(1.0, 5.0)).thickness() == pinhole.thickness());
    let (sum, pixels) = spread(&pinhole);
    for focus in [3.0, 12.0] {
        let (blurred, more) = spread(&of(at(0.5, focus)));
        assert!((blurred / sum - 1.0).abs() < 0.03 && 4 * more > 5 * pixels, "{blurred} {sum} {more} {pixels}");
    }
    // The circle of confusion: 0.5 · 1 m · |5 − 2| / 5 of the plane at 2 m, beside a radius of 0.25 m at 5 m.
    let wide = spread(&of(at(1.0, 2.0))).1 as f32;
    let radius = (0.3 * scale(2.0)).hypot(0.25 * scale(5.0));
    assert!((wide / (std::f32::consts::PI * radius * radius) - 1.0).abs() < 0.03, "{wide} {radius}");
}

#[test]
fn an_open_shutter_draws_particles_along_their_way() {
    let settings = FoamSettings { shutter: 0.5, shutter_samples: 32, ..large() };
    let context = Context::serial();
    let of = |velocity: [f32; 3]| {
        let mut foam = Foam::new(&context, settings, view(), &Scenery::default()).unwrap();
        foam.add_moving(&context, &[particle([-0.5, 0.0, 0.0], 1, FoamKind::Spray)], &[velocity]).unwrap();
        assert_eq!(foam.particles(), 1);
        foam.finish(&context, &white(), &mut Silent).unwrap()
    };
    let still = layers(large(), &Scenery::default(), &[particle([-0.5, 0.0, 0.0], 1, FoamKind::Spray)]);
    let rest = of([0.0; 3]);
    assert!(rest.thickness().iter().zip(still.thickness()).all(|(a, b)| (a - b).abs() < 1e-4));
    let moving = of([2.0, 0.0, 0.0]);
    let (sum, pixels) = spread(&still);
    let (moved, more) = spread(&moving);
    assert!((moved / sum - 1.0).abs() < 0.02 && more > 2 * pixels, "{moved} {sum} {more} {pixels}");
    // The mean column is half of the way farther.
    let mean = |layers: &FoamLayers| {
        let columns = layers.thickness().iter().enumerate().map(|(at, value)| (at % SIZE as usize) as f32 * value);
        columns.sum::<f32>() / layers.thickness().iter().sum::<f32>()
    };
    assert!((mean(&moving) - mean(&still) - 0.5 * scale(5.0)).abs() < 0.5);
    let mut foam = Foam::new(&context, settings, view(), &Scenery::default()).unwrap();
    let one = [particle([0.0; 3], 1, FoamKind::Spray)];
    assert!(
        foam.add_moving(&context, &one, &[]).is_err() && foam.add_moving(&context, &one, &[[f32::NAN; 3]]).is_err()
    );
}

#[test]
fn extinction_is_the_cross_sections_of_particles_over_the_volume_of_cells() {
    let context = Context::serial();
    let settings = FoamSettings { radius: 0.01, ..FoamSettings::default() };
    let corners = [DVec3::ZERO, DVec3::new(1.0, 0.5, 0.25)];
    let mut grid = Extinction::new(&context, settings, corners, 0.1).unwrap();
    assert_eq!((grid.size(), grid.cell()), ([13, 8, 6], 0.1));
    assert!(grid.low().distance(DVec3::splat(-0.1)) < 1e-12);
    // A particle on a point of the grid is in one value: number 5 has the whole radius.
    grid.add(&[particle([0.3, 0.2, 0.1], 5, FoamKind::Foam)]);
    let section = std::f64::consts::PI * 0.01 * 0.01 / 1e-3;
    let values: Vec<f64> = grid.coefficients().collect();
    let at = (2 * 8 + 3) * 13 + 4;
    assert!((values[at] / section - 1.0).abs() < 1e-5, "{} {section}", values[at]);
    // A bubble between points is shared by eight; one of the second size has a sixteenth of the section.
    grid.add(&[particle([0.55, 0.45, 0.15], 1, FoamKind::Bubble), particle([9.0, 0.0, 0.0], 0, FoamKind::Spray)]);
    let sum: f64 = grid.coefficients().sum();
    assert!((sum / section - 1.0 - 1.0 / 16.0).abs() < 1e-5);
    // Places between points are rounded, so that neighbours have next to nothing.
    assert_eq!(grid.coefficients().filter(|value| *value > 1e-3 * section).count(), 9);
    for cell in [0.0, -1.0, f64::NAN, 1e-6] {
        assert!(Extinction::new(&context, settings, corners, cell).is_err(), "{cell}");
    }
    let little = Context::new(&ContextOptions { threads: 1, memory_limit: 4096 }).unwrap();
    let error = Extinction::new(&little, settings, corners, 0.1).unwrap_err();
    assert_eq!(error.kind, ErrorKind::Memory);
}
