//! Screen-space foam on a graphics device against that of the processor, layer by layer: the seven passes, wide and small
//! sprites, chunks in any order, lenses and shutters, and what is refused.

use glam::DVec3;
use relievo_core::parameter::Switch;
use relievo_core::progress::Silent;
use relievo_core::{Context, ContextOptions, ErrorKind};
use relievo_gpu::{AdapterChoice, Device, DeviceOptions};
use relievo_render::foam::{
    Environment, Foam, FoamKind, FoamLayers, FoamParticle, FoamSettings, FoamView, Lens, Scenery,
};
use relievo_render::{Camera, Image, Lights};

const SIZE: [u32; 2] = [90, 65];
const PIXELS: usize = (SIZE[0] * SIZE[1]) as usize;

fn view() -> FoamView {
    let camera = Camera::look_at(DVec3::new(1.0, -2.0, 5.0), DVec3::ZERO, DVec3::Y, 0.8).unwrap();
    FoamView { camera, lens: Lens::Perspective, width: SIZE[0], height: SIZE[1] }
}

/// Particles in a ball, by hashes of their numbers, of which every one comes twice. A few fill much of the picture.
fn cloud(count: u32) -> Vec<FoamParticle> {
    let mut state = 1u32;
    let mut number = move || {
        state = state.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
        (state >> 8) as f32 / (1 << 24) as f32
    };
    let particle = |at: u32| {
        let near = if at % 1000 == 7 { 3.0 } else { 0.0 };
        let [x, y, z] = [0; 3].map(|_| 2.4 * number() - 1.2);
        let kind = [FoamKind::Spray, FoamKind::Foam, FoamKind::Bubble][at as usize % 3];
        let (life, id) = (if at.is_multiple_of(5) { 0.0 } else { number() }, at / 2);
        FoamParticle { position: [x + 0.2 * near, y - 0.4 * near, 0.4 * z + near], life, id, kind }
    };
    (0..count).map(particle).collect()
}

/// Depths of a fluid and of solids that rise across the picture.
fn scenery() -> Scenery {
    let depths = |of: fn(f32) -> f32| {
        let data = (0..PIXELS).map(|at| of((at as u32 % SIZE[0]) as f32 / SIZE[0] as f32)).collect();
        Some(Image::from_data(SIZE[0], SIZE[1], 1, data).unwrap())
    };
    Scenery { fluid: depths(|x| 5.0 + x), solids: depths(|x| if x < 0.2 { f32::INFINITY } else { 6.2 - x }) }
}

fn light() -> Environment {
    Environment::of_lights(&Lights::default()).unwrap()
}

/// Returns the layers of particles in chunks, by a device or the processor.
fn layers(
    device: Option<&Device>,
    (settings, view): (FoamSettings, FoamView),
    particles: &[FoamParticle],
    chunk: usize,
) -> FoamLayers {
    let context = Context::serial();
    let mut foam = Foam::on(&context, device, settings, view, &scenery()).unwrap();
    particles.chunks(chunk).for_each(|chunk| foam.add(&context, chunk).unwrap());
    assert_eq!(foam.particles(), particles.len() as u64);
    foam.finish(&context, &light(), &mut Silent).unwrap()
}

fn background() -> Image {
    Image::from_data(SIZE[0], SIZE[1], 4, [0.1, 0.2, 0.4, 0.9].repeat(PIXELS)).unwrap()
}

/// Checks that at most one pixel of a thousand is further from that of the processor than a tolerance.
fn assert_near<const N: usize>(what: &str, tolerance: f32, pair: impl Fn(usize) -> [[f32; N]; 2]) {
    let is_far = |at: &usize| {
        let [a, b] = pair(*at);
        a.iter().zip(b).any(|(a, b)| *a != b && !((a - b).abs() <= tolerance))
    };
    let far: Vec<_> = (0..PIXELS).filter(is_far).collect();
    let first = far.first().map(|at| pair(*at));
    assert!(far.len() <= PIXELS / 1000, "{what}: {} pixels, as {first:?}", far.len());
}

/// Compares all layers, and the picture.
fn assert_same(case: &str, ours: &FoamLayers, theirs: &FoamLayers) {
    let both = |of: fn(&FoamLayers) -> &[f32], at: usize| [ours, theirs].map(|layers| [of(layers)[at]]);
    assert_near(&format!("{case}: depth"), 1e-5, |at| both(FoamLayers::depth, at));
    assert_near(&format!("{case}: search radius"), 1e-4, |at| both(FoamLayers::search_radius, at));
    assert_near(&format!("{case}: normal"), 1e-3, |at| [ours, theirs].map(|layers| layers.normal(at)));
    assert_near(&format!("{case}: thickness"), 1e-3, |at| both(FoamLayers::thickness, at));
    assert_near(&format!("{case}: intensity"), 2e-4, |at| both(FoamLayers::intensity, at));
    assert_near(&format!("{case}: occlusion"), 2e-3, |at| both(FoamLayers::occlusion, at));
    assert_near(&format!("{case}: irradiance"), 1e-3, |at| [ours, theirs].map(|layers| layers.irradiance()[at]));
    let context = Context::serial();
    let pictures = [ours, theirs].map(|layers| layers.composite(&context, &background()).unwrap());
    let pixel = |image: &Image, at: usize| std::array::from_fn::<f32, 4, _>(|channel| image.data()[4 * at + channel]);
    assert_near(&format!("{case}: picture"), 1.0 / 255.0, |at| [0, 1].map(|which| pixel(&pictures[which], at)));
    let drawn = theirs.intensity().iter().filter(|intensity| **intensity > 0.1).count();
    assert!(drawn > PIXELS / 20, "{case}: foam is in {drawn} pixels");
}

#[test]
fn a_device_makes_the_layers_and_the_picture_of_the_processor() {
    let Some(device) = relievo_testing::device() else { return };
    let particles = cloud(5000);
    let parallel = FoamView { lens: Lens::Orthographic(4.0), ..view() };
    let small = FoamSettings { radius: 0.2, ao_max_samp: 96, ..FoamSettings::default() };
    let other = FoamSettings {
        ao_hemisphere: Switch::OFF,
        irradiance_map: Switch::OFF,
        lifetime_n: 0.0,
        aperture: 0.2,
        focus: 4.0,
        ao_passes: 1,
        ..small
    };
    for (case, settings, view) in [("default", small, view()), ("other", other, view()), ("parallel", small, parallel)]
    {
        let [ours, theirs] =
            [Some(&device), None].map(|device| layers(device, (settings, view), &particles, usize::MAX));
        assert_same(case, &ours, &theirs);
        assert!(theirs.times().is_empty());
        if device.is_timed() {
            let names: Vec<_> = ours.times().iter().map(|time| time.name).collect();
            let passes = ["depth and thickness", "nearest particles", "intensity", "occlusion", "irradiance"];
            assert_eq!(names, [&["begin"], passes.as_slice(), &["composition"]].concat());
        }
    }
}

#[test]
fn a_device_gives_the_same_bits_for_any_order_and_chunks() {
    let Some(device) = relievo_testing::device() else { return };
    let particles = cloud(4000);
    let reversed: Vec<_> = particles.iter().rev().copied().collect();
    let settings = FoamSettings { radius: 0.1, ao_max_samp: 32, ..FoamSettings::default() };
    let bits = |particles: &[FoamParticle], chunk: usize| {
        let found = layers(Some(&device), (settings, view()), particles, chunk);
        let picture = found.composite(&Context::serial(), &background()).unwrap();
        (format!("{:?}", found.exr_layer().channels.iter().map(|it| &it.samples).collect::<Vec<_>>()), picture)
    };
    let first = bits(&particles, usize::MAX);
    for (particles, chunk) in [(&particles, 700), (&reversed, 1999)] {
        let other = bits(particles, chunk);
        assert!(other.0 == first.0 && other.1.data() == first.1.data(), "{chunk}");
    }
}

#[test]
fn a_device_sums_more_than_a_word_and_draws_moving_particles() {
    let Some(device) = relievo_testing::device() else { return };
    let context = Context::serial();
    // A hundred particles at one place have a hundred times the thickness of one.
    let one = FoamParticle { position: [0.0; 3], life: 0.0, id: 0, kind: FoamKind::Foam };
    let settings = FoamSettings { radius: 0.6, ao_passes: 0, ..FoamSettings::default() };
    let clear = |particles: &[FoamParticle]| {
        let mut foam = Foam::on(&context, Some(&device), settings, view(), &Scenery::default()).unwrap();
        foam.add(&context, particles).unwrap();
        foam.finish(&context, &light(), &mut Silent).unwrap()
    };
    let (single, many) = (clear(&[one]), clear(&[one; 100]));
    assert!(single.thickness().iter().any(|value| *value > 0.9));
    let pairs = || single.thickness().iter().zip(many.thickness());
    assert!(pairs().all(|(one, all)| (all - 100.0 * one).abs() <= 1e-5 * all));
    assert!(single.depth() == many.depth());
    let settings = FoamSettings { shutter: 0.1, shutter_samples: 4, ao_passes: 0, radius: 0.12, ..settings };
    let particles = cloud(1000);
    let velocities: Vec<_> = particles.iter().map(|particle| particle.position.map(|at| 4.0 * at)).collect();
    let [ours, theirs] = [Some(&device), None].map(|device| {
        let mut foam = Foam::on(&context, device, settings, view(), &scenery()).unwrap();
        foam.add_moving(&context, &particles, &velocities).unwrap();
        foam.finish(&context, &light(), &mut Silent).unwrap()
    });
    assert_same("moving", &ours, &theirs);
}

#[test]
fn bad_input_is_refused_and_a_device_without_memory_says_so() {
    let Some(device) = relievo_testing::device() else { return };
    let context = Context::serial();
    let make = |context: &Context, device: &Device| {
        Foam::on(context, Some(device), FoamSettings::default(), view(), &Scenery::default())
    };
    let mut foam = make(&context, &device).unwrap();
    let far = |position| FoamParticle { position, life: 0.5, id: 3, kind: FoamKind::Spray };
    assert!(foam.add(&context, &[far([f32::NAN, 0.0, 0.0])]).is_err());
    // At the camera, behind it, and as far away as numbers go.
    let places = [[1.0, -2.0, 5.0], [1.0, -2.0, 9.0], [3e38, 0.0, 0.0], [0.0, 0.0, -3e38], [-3e38; 3]];
    foam.add(&context, &places.map(far)).unwrap();
    foam.add(&context, &[]).unwrap();
    let found = foam.finish(&context, &light(), &mut Silent).unwrap();
    assert!(found.thickness().iter().all(|value| *value == 0.0) && found.depth().iter().all(|at| at.is_infinite()));
    assert_eq!(found.composite(&context, &background()).unwrap().data(), background().data());
    assert!(found.composite(&context, &Image::new(3, 3, 3).unwrap()).is_err());
    let error = make(&context, &device).unwrap().finish(&context, &light(), &mut |_: f32, _: &str| false).unwrap_err();
    assert_eq!(error.kind, ErrorKind::Cancelled);
    let bounded = Context::new(&ContextOptions { threads: 1, memory_limit: 1 << 17 }).unwrap();
    assert_eq!(make(&bounded, &device).unwrap_err().kind, ErrorKind::Memory);
    let adapter = AdapterChoice::Named(device.summary().name.clone());
    let small = Device::open(&DeviceOptions { adapter, timing: false, memory_limit: 1 << 20 }).unwrap();
    assert_eq!(make(&context, &small).unwrap_err().kind, ErrorKind::Memory);
    // What is stated: 48 bytes a pixel before it is shaded, and 8 MiB for a chunk, beside tables.
    let before = device.memory();
    let foam = make(&context, &device).unwrap();
    let used = device.memory() - before;
    assert!(used <= 48 * PIXELS as u64 + (8 << 20) + (1 << 15), "{used}");
    drop(foam);
    assert_eq!(device.memory(), before);
    small.abandon();
    assert_eq!(make(&context, &small).unwrap_err().kind, ErrorKind::Device);
}
