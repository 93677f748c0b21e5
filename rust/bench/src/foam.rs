//! Bench `foam`: Table 1 of Akinci et al. 2013 anew, on the processor and on a graphics device: pictures of 0.82 to 29
//! million particles, the intensity alone and all passes, beside ray casting through a volume of the same particles; the
//! time of the passes behind the splatting, also for each pixel that foam covers; the memory of a process that draws, beside
//! its bound; and the rates at which diffuse particles are made and moved.

mod ray_caster;

use glam::{DVec3, Vec3};
use relievo_comparison::{PIXELS_PER_DEGREE, compare};
use relievo_core::progress::Silent;
use relievo_core::{Context, ContextOptions, Error, Result};
use relievo_fluid::{Diffuse, DiffuseOptions, DiffuseParticles, DiffuseSettings, FluidFrame};
use relievo_gpu::{AdapterKind, Device, DeviceOptions, PassTime};
use relievo_render::foam::{Environment, Foam, FoamKind, FoamParticle, FoamSettings, FoamView, Lens, Scenery};
use relievo_render::{Camera, Image, Picture, write_png};

use self::ray_caster::{Transport, Volume};
use crate::measure::{Sample, core_seconds, memory, peak_of, seconds};
use crate::report::{Goal, Report};

const PAPER: &str = "Akinci 2013, GTX 480";

/// A scene of Table 1: its name, particles, size, the paper's milliseconds of the intensity alone and of all.
const SCENES: [(&str, usize, [u32; 2], [f64; 2]); 4] = [
    ("Wave", 820_000, [800, 600], [8.0, 52.0]),
    ("Ship", 9_000_000, [800, 600], [16.0, 102.0]),
    ("Lighthouse", 15_000_000, [800, 600], [21.0, 150.0]),
    ("Flood", 29_000_000, [1280, 960], [33.0, 235.0]),
];

/// Sizes in which the processor draws every scene.
const SIZES: [[u32; 2]; 2] = [[800, 600], [1280, 960]];

/// Particles that are made at a time, as a reader of a frame would.
const CHUNK: usize = 1 << 18;
/// Bytes of a particle of a chunk, and of a pixel, that drawing may take.
const BOUND: [usize; 2] = [24, 64];
const RADIUS: f32 = 0.01;
/// Particles at most where the graphics device is the processor itself.
const SOFTWARE: usize = 1_000_000;

/// Measures every case into `report`.
pub fn run(report: &mut Report) -> Result<()> {
    let context = &Context::new(&ContextOptions::default())?;
    for size in SIZES {
        let mut fewest = None;
        for scene in SCENES {
            table(report, context, scene, size, &mut fewest)?;
        }
    }
    drawing(report)?;
    generation(report)?;
    // A device that is the processor itself takes memory of the process, of which the rows above have the peak.
    match Device::open(&DeviceOptions { timing: true, ..DeviceOptions::default() }) {
        Ok(device) => SCENES
            .into_iter()
            .try_for_each(|(name, count, size, paper)| on_device(report, context, &device, (name, count, size), paper)),
        Err(error) => {
            report.skip("graphics devices", &error.to_string());
            Ok(())
        }
    }
}

/// Returns one of `count` particles: a ring of foam on the ground with spray above it, by hashes of its number.
fn particle(number: usize) -> FoamParticle {
    let random = |stream: u64| {
        let mut state =
            (number as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ stream.wrapping_mul(0xbf58_476d_1ce4_e5b9);
        state = (state ^ state >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        state = (state ^ state >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((state ^ state >> 31) >> 40) as f32 / (1u64 << 24) as f32
    };
    let angle = std::f32::consts::TAU * random(1);
    let radius = 2.0 + 1.2 * (random(2) + random(3) - 1.0) + 0.2 * (7.0 * angle).sin();
    let height = random(4).powi(4);
    let kind = match height {
        height if height > 0.1 => FoamKind::Spray,
        height if height < 0.001 => FoamKind::Bubble,
        _ => FoamKind::Foam,
    };
    let position = [radius * angle.cos(), radius * angle.sin(), 0.6 * height];
    FoamParticle { position, life: 0.9 * random(5), id: number as u32, kind }
}

/// Returns the view of all scenes.
fn view_of([width, height]: [u32; 2]) -> Result<FoamView> {
    let camera = Camera::look_at(DVec3::new(0.0, -6.0, 3.5), DVec3::ZERO, DVec3::Z, 0.8)?;
    Ok(FoamView { camera, lens: Lens::Perspective, width, height })
}

fn case(name: &str, count: usize, [width, height]: [u32; 2], what: &str) -> String {
    format!("{name}, {:.2} M, {width} × {height}: {what}", count as f64 / 1e6)
}

/// Measures a scene on a graphics device by its own clock, without the time in which particles are made and sent.
fn on_device(
    report: &mut Report,
    context: &Context,
    device: &Device,
    (name, count, size): (&str, usize, [u32; 2]),
    paper: [f64; 2],
) -> Result<()> {
    let is_software = device.summary().kind == AdapterKind::Software;
    if is_software && count > SOFTWARE {
        report.skip(&case(name, count, size, "device, total"), "the graphics device is the processor itself");
        return Ok(());
    }
    let settings = FoamSettings { radius: RADIUS, ..FoamSettings::default() };
    let mut foam = Foam::on(context, Some(device), settings, view_of(size)?, &Scenery::default())?;
    for first in (0..count).step_by(CHUNK) {
        let chunk: Vec<_> = (first..count.min(first + CHUNK)).map(particle).collect();
        foam.add(context, &chunk)?;
    }
    let memory = device.memory();
    let layers = foam.finish(context, &Environment::uniform([1.0; 3])?, &mut Silent)?;
    layers.composite(context, &Image::new(size[0], size[1], 3)?)?;
    let times = layers.times();
    if times.is_empty() {
        report.skip(&case(name, count, size, "device, total"), "the graphics device does not time passes");
        return Ok(());
    }
    let milliseconds = |is_part: &dyn Fn(&str) -> bool| {
        let parts = times.iter().filter(|time| is_part(time.name));
        1000.0 * parts.map(|PassTime { length, .. }| length.as_secs_f64()).sum::<f64>()
    };
    let intensity = ["begin", "depth and thickness", "nearest particles", "intensity"];
    let peer = |paper: f64| Sample::new(vec![paper]);
    let mut row = |what: &str, value: f64, paper: Option<f64>, goal| {
        let paper = paper.map(peer);
        let paper = paper.as_ref().map(|paper| (PAPER, paper));
        report.add(&case(name, count, size, what), &Sample::new(vec![value]), paper, "ms", goal);
    };
    let goal = if is_software || count < 29_000_000 { Goal::None } else { Goal::AtMost(10.0) };
    row("device, intensity", milliseconds(&|name| intensity.contains(&name)), Some(paper[0]), Goal::None);
    row("device, total", milliseconds(&|_| true), Some(paper[1]), goal);
    for part in times.iter().map(|time| time.name) {
        row(&format!("device, {part}"), milliseconds(&|name| name == part), None, Goal::None);
    }
    let bytes = Sample::new(vec![memory as f64 / 1e6]);
    report.add(&case(name, count, size, "memory of the device while drawing"), &bytes, None, "MB", Goal::None);
    Ok(())
}

/// Makes the particles of a scene in chunks and adds them. Returns the seconds and the core-seconds that adding takes.
fn add(context: &Context, foam: &mut Foam, count: usize) -> Result<[f64; 2]> {
    let (mut time, mut worked, mut result) = (0.0, 0.0, Ok(()));
    for first in (0..count).step_by(CHUNK) {
        let chunk: Vec<_> = (first..count.min(first + CHUNK)).map(particle).collect();
        let before = core_seconds();
        time += seconds(|| result = foam.add(context, &chunk));
        worked += core_seconds() - before;
        result?;
        result = Ok(());
    }
    Ok([time, worked])
}

/// Measures a scene by the processor in one size. `fewest` has the processor's nanoseconds behind the splatting for each
/// covered pixel of the scene that came first in this size.
fn table(
    report: &mut Report,
    context: &Context,
    (name, count, size_of_paper, paper): (&str, usize, [u32; 2], [f64; 2]),
    size: [u32; 2],
    fewest: &mut Option<Sample>,
) -> Result<()> {
    let view = view_of(size)?;
    let settings = FoamSettings { radius: RADIUS, ..FoamSettings::default() };
    let light = Environment::uniform([1.0; 3])?;
    let background = Image::new(size[0], size[1], 3)?;
    let mut foam = Foam::new(context, settings, view, &Scenery::default())?;
    let [splatting, added] = add(context, &mut foam, count)?;
    // Depth, thickness and intensity without the passes behind them.
    let worked = core_seconds();
    let (mut layers, mut picture) = (None, None);
    let mut shading = seconds(|| layers = Some(foam.finish(context, &light, &mut Silent)));
    let layers = layers.ok_or_else(|| Error::internal("nothing was drawn"))??;
    shading += seconds(|| picture = Some(layers.composite(context, &background)));
    let worked = core_seconds() - worked;
    let picture = picture.transpose()?;
    let covered = layers.intensity().iter().filter(|intensity| **intensity > 0.0).count();
    drop(layers);
    let milliseconds = |seconds: f64| Sample::new(vec![1000.0 * seconds]);
    let case = |what: &str| case(name, count, size, what);
    let peer = |paper: f64| Sample::new(vec![paper]);
    let [first, all] = paper.map(peer);
    let paper = |sample| (size == size_of_paper).then_some((PAPER, sample));
    report.add(&case("intensity"), &milliseconds(splatting), paper(&first), "ms", Goal::None);
    let goal = if count == 9_000_000 { Goal::AtMost(3000.0) } else { Goal::None };
    report.add(&case("total"), &milliseconds(splatting + shading), paper(&all), "ms", goal);
    let share = (added + worked) / context.threads() as f64;
    let what = format!("the same by the processor's clock, each of {} threads", context.threads());
    report.add(&case(&what), &milliseconds(share), None, "ms", Goal::None);
    report.add(&case("radiance and composition"), &milliseconds(shading), None, "ms", Goal::None);
    // Both threads together, so that other programs on the machine do not count.
    let each = Sample::new(vec![1e9 * worked / covered.max(1) as f64]);
    let what = format!("the same by the processor's clock, each of {covered} covered pixels");
    match fewest {
        Some(fewest) => {
            report.add(&case(&what), &each, Some(("fewest particles", fewest)), "ns", Goal::RatioAtMost(1.1));
        }
        None => report.add(&case(&what), &each, None, "ns", Goal::None),
    }
    fewest.get_or_insert(each);
    // The peers need all particles at once, and are measured where that is little.
    if count <= 1_000_000 && size == size_of_paper {
        let all: Vec<_> = (0..count).map(particle).collect();
        let mut volume = None;
        let made = seconds(|| volume = Some(Volume::new(&all, RADIUS)));
        let (Some(volume), Some(picture)) = (volume, picture) else { return Ok(()) };
        let mut cast = Vec::new();
        for (what, transport) in
            [("absorption and emission", Transport::AbsorptionEmission), ("scattering", Transport::Scattering)]
        {
            let mut image = None;
            let time = milliseconds(made + seconds(|| image = Some(volume.render(context, &view, transport))));
            let name = format!("ray casting, {what}");
            report.add(&case("total"), &milliseconds(splatting + shading), Some((&name, &time)), "ms", Goal::None);
            cast.extend(image.map(|image| (what, image)));
        }
        pictures(report, &case, &picture, &cast)?;
    }
    Ok(())
}

/// Holds the memory that a process takes to draw the larger scenes against its bound.
fn drawing(report: &mut Report) -> Result<()> {
    for (row, size) in SIZES.into_iter().enumerate() {
        for (column, (name, count, ..)) in SCENES.into_iter().enumerate().filter(|(_, scene)| scene.1 != 15_000_000) {
            let case = case(name, count, size, "memory of drawing, with a chunk of 262,144 particles");
            let Some(bytes) = peak_of("drawing", "--row", &(row * SCENES.len() + column).to_string()) else {
                report.skip(&case, "the system does not tell the peak of a process");
                continue;
            };
            let bound = BOUND[0] * CHUNK + BOUND[1] * size[0] as usize * size[1] as usize;
            let [ours, bound] = [bytes, bound as f64].map(|bytes| Sample::new(vec![bytes / 1e6]));
            report.add(
                &case,
                &ours,
                Some(("24 bytes a particle of it and 64 a pixel", &bound)),
                "MB",
                Goal::RatioAtMost(1.0),
            );
        }
    }
    Ok(())
}

/// Prints how many bytes drawing a row of the table takes at the peak: those of the renderer, of its picture, and of the chunk
/// of particles that it is given.
pub fn peak(row: usize) -> Result<()> {
    let place = || Error::invalid(format!("there is no row {row}"));
    let size = *SIZES.get(row / SCENES.len()).ok_or_else(place)?;
    let count = SCENES[row % SCENES.len()].1;
    let context = &Context::new(&ContextOptions::default())?;
    let light = Environment::uniform([1.0; 3])?;
    let draw = |count: usize, size: [u32; 2], background: &Image| -> Result<Image> {
        let settings = FoamSettings { radius: RADIUS, ..FoamSettings::default() };
        let mut foam = Foam::new(context, settings, view_of(size)?, &Scenery::default())?;
        add(context, &mut foam, count)?;
        foam.finish(context, &light, &mut Silent)?.composite(context, background)
    };
    // Code and tables are in memory before.
    draw(1000, [64, 64], &Image::new(64, 64, 3)?)?;
    let background = Image::from_data(size[0], size[1], 3, vec![0.5; 3 * size[0] as usize * size[1] as usize])?;
    let before = memory("VmRSS");
    let picture = draw(count, size, &background)?;
    let peak = memory("VmHWM").zip(before).map(|(peak, before)| peak - before);
    drop(picture);
    peak.iter().for_each(|bytes| println!("{bytes}"));
    Ok(())
}

/// Compares the picture with those of the peers, and these with each other, by the mean FLIP error. The folder
/// `RELIEVO_FOAM_PICTURES`, where it is set, gets the pictures.
fn pictures(report: &mut Report, case: &dyn Fn(&str) -> String, ours: &Image, peers: &[(&str, Image)]) -> Result<()> {
    let picture = |image: &Image| Picture { color: image.clone(), alpha: None, depth: None, normal: None };
    let flip = |reference: &Image, image: &Image| -> Result<Sample> {
        let found = compare(&picture(reference), &picture(image), PIXELS_PER_DEGREE)?;
        Ok(Sample::new(vec![found.flip.mean]))
    };
    for (what, peer) in peers {
        report.add(&case(&format!("FLIP beside ray casting, {what}")), &flip(peer, ours)?, None, "", Goal::None);
    }
    if let [(_, first), (_, second)] = peers {
        report.add(&case("FLIP of both ray castings"), &flip(first, second)?, None, "", Goal::None);
    }
    if let Some(folder) = std::env::var_os("RELIEVO_FOAM_PICTURES") {
        let folder = std::path::Path::new(&folder);
        write_png(&folder.join("screen space.png"), ours)?;
        peers.iter().try_for_each(|(what, image)| write_png(&folder.join(format!("{what}.png")), image))?;
    }
    Ok(())
}

/// Rates of a core: particles of a fluid whose potentials are found, and diffuse particles that are moved.
fn generation(report: &mut Report) -> Result<()> {
    let context = &Context::serial();
    let spacing = 0.02;
    let side = 64;
    let place = |n: usize| spacing * Vec3::new((n % side) as f32, (n / side % side) as f32, (n / side / side) as f32);
    let positions: Vec<_> = (0..side * side * side).map(place).collect();
    let velocities: Vec<_> = positions.iter().map(|at| Vec3::new(6.0 * (9.0 * at.y).sin(), 0.0, -4.0)).collect();
    let fluid = FluidFrame { positions: &positions, velocities: &velocities };
    let settings = DiffuseSettings { steps: 1, air_rate: 0.0, crest_rate: 0.0, ..DiffuseSettings::default() };
    let options = DiffuseOptions { settings, ..DiffuseOptions::default() };
    let count = 1_000_000;
    let range = spacing * side as f32;
    let at = |n: usize| Vec3::from([3, 5, 7].map(|base| range * ((n * base * 7919 % 100_003) as f32 / 100_003.0)));
    let diffuse = |count: usize| DiffuseParticles {
        positions: (0..count).map(at).collect(),
        velocities: vec![Vec3::ZERO; count],
        ages: vec![0.0; count],
        lifetimes: vec![100.0; count],
        kinds: vec![Default::default(); count],
        ids: (0..count as u64).collect(),
    };
    let step = |particles: DiffuseParticles| -> Result<f64> {
        let mut run = Diffuse::restore(options, particles, 0, 0)?;
        let mut result = Ok(Default::default());
        let time = seconds(|| result = run.advance(context, fluid, 0.01, &mut Silent));
        result.map(|_| time)
    };
    step(diffuse(1))?;
    let (without, with) = (step(diffuse(1))?, step(diffuse(count))?);
    let rate = |count: usize, seconds: f64| Sample::new(vec![count as f64 / seconds.max(1e-9) / 1e6]);
    let potentials = rate(positions.len(), without);
    report.add("potentials of a fluid, a core", &potentials, None, "M/s", Goal::AtLeast(3.0));
    report.add("advection, a core", &rate(count, with - without), None, "M/s", Goal::AtLeast(2.0));
    Ok(())
}
