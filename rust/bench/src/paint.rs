//! Bench `paint`: what a dab of a brush costs, stage by stage and in all, and the look-up of colour. The figures of
//! Schäfer et al. 2015, Local Painting and Deformation of Meshes on the GPU, Table 1, stand beside ours where the
//! number of faces is the same; its models are not public, so ours are terrains, and every face is one element. For
//! triangle meshes see [`crate::triangles`].

use glam::{DAffine3, DMat3, DVec3, Vec4};
use relievo_core::{Context, ContextOptions, Result};
use relievo_detail::{Action, Brush, Dab, DisplacedObject, Falloff, PaintMode, SculptMode};
use relievo_surface::{Place, Surface, SurfaceOptions};
use relievo_tiles::{ChannelOptions, Displacement, Paint};

use crate::measure::{Sample, sample, seconds};
use crate::report::{Goal, Report};
use crate::shapes;

/// Whose figures stand beside ours.
const PAPER: &str = "Schäfer 2015, GTX Titan";
/// Faces along a side of the terrains, the model of the paper that has as many elements, and its milliseconds of
/// intersecting, scanning and managing.
const SIDES: [(u32, &str, f64); 4] = [
    (190, "dragon", 0.25 + 0.025 + 0.006),
    (205, "frog", 0.27 + 0.028 + 0.006),
    (276, "dragon subdivided once", 0.78 + 0.028 + 0.006),
    (456, "dragon subdivided twice", 2.31 + 0.049 + 0.006),
];
/// Runs of each.
const RUNS: usize = 31;
/// Places that are looked up at a time.
const PLACES: u32 = 1 << 16;

/// Measures every case into `report`.
pub fn run(report: &mut Report) -> Result<()> {
    let context = Context::new(&ContextOptions::default())?;
    let mut medians = Vec::new();
    for (side, model, paper) in SIDES {
        let mut object = object(&context, side, 8)?;
        let paint = dab(3.9, Action::Paint { mode: PaintMode::Mix, color: [0.8, 0.1, 0.1, 1.0] })?;
        let mut times = Vec::new();
        let mut tiles = 0;
        for _ in 0..=RUNS {
            context.stats().take();
            // Each run allocates: what the one before painted is erased first, which is not counted.
            tiles = paint.apply(&context, &mut object)?.changed.len();
            let stages = context.stats().take();
            let managing = |stage: &&str| ["dab.intersect", "dab.manage"].contains(stage);
            times.push(
                stages
                    .iter()
                    .filter(|event| managing(&event.stage))
                    .map(|event| 1e3 * event.length.as_secs_f64())
                    .sum(),
            );
            let erase = Action::Paint { mode: PaintMode::Erase, color: [0.0; 4] };
            Dab { strength: 1.0, ..dab(9.0, erase)? }.apply(&context, &mut object)?;
        }
        times.remove(0);
        let times = Sample::new(times);
        medians.push(times.median());
        let case = format!("intersect, scan, manage: {tiles} of {} faces ({model})", side * side);
        report.add(&case, &times, Some((PAPER, &Sample::new(vec![paper]))), "ms", Goal::AtMost(0.2));
    }
    if let [first, .., last] = medians[..] {
        report.add("largest over smallest", &Sample::new(vec![last / first]), None, "", Goal::AtMost(2.0));
    }
    crate::triangles::run(report, &context)?;
    // Whole dabs on tiles that are there. Colours alternate, so that every run changes every texel.
    let mut object = object(&context, 16, 128)?;
    let mut wide = self::object(&context, 16, 128)?;
    let options = ChannelOptions { size: 128, ..ChannelOptions::default() };
    let blank = Vec4::new(0.5, 0.5, 0.5, 1.0);
    wide.set_half_paint(Paint::of_color(wide.surface().topology().clone(), blank, &options)?)?;
    let mut turn = false;
    let mut whole = |object: &mut DisplacedObject, name: &str, goal: f64, action: &dyn Fn(bool) -> Action| {
        let [first, second] = [dab(3.999, action(true))?, dab(3.999, action(false))?];
        let tiles = first.apply(&context, object)?.changed.len();
        let times = sample(RUNS, || {
            turn = !turn;
            let dab = if turn { &first } else { &second };
            1e3 * seconds(|| dab.apply(&context, object))
        });
        report.add(&format!("{name}: {tiles} tiles at 128²"), &times, None, "ms", Goal::AtMost(goal));
        Result::Ok(())
    };
    let paint = |turn| {
        let color = if turn { [0.8, 0.1, 0.1, 1.0] } else { [0.1, 0.1, 0.8, 1.0] };
        Action::Paint { mode: PaintMode::Mix, color }
    };
    whole(&mut object, "dab of colour", 6.0, &paint)?;
    whole(&mut wide, "dab of colour, 16 bits", 6.0, &paint)?;
    whole(&mut object, "dab of displacement", 8.0, &|turn| {
        let height = if turn { 0.1 } else { -0.1 };
        Action::Sculpt { mode: SculptMode::Draw, height }
    })?;
    // Where there is displacement, points and normals are needed under colours too.
    whole(&mut object, "dab of colour over displacement", 6.0, &paint)?;
    look_up(report, &object);
    Ok(())
}

/// A terrain of `side` × `side` faces that can be painted, with tiles of `size`.
fn object(context: &Context, side: u32, size: u32) -> Result<DisplacedObject> {
    let cage = shapes::terrain(side);
    let surface = Surface::new(context, &cage, &SurfaceOptions::default())?;
    let options = ChannelOptions { size, ..ChannelOptions::default() };
    let displacement = Displacement::new(surface.topology().clone(), &options)?;
    let paint = Paint::of_color(surface.topology().clone(), Vec4::new(0.5, 0.5, 0.5, 1.0), &options)?;
    let mut object = DisplacedObject::new(context, surface, &cage.points, displacement, DAffine3::IDENTITY)?;
    object.set_paint(paint)?;
    Ok(object)
}

fn dab(half: f64, action: Action) -> Result<Dab> {
    let half = DVec3::new(half, half, 2.0);
    let brush = Brush::new(DVec3::ZERO, DMat3::IDENTITY, half, Falloff::Constant)?;
    Ok(Dab { brush, action, strength: 0.5 })
}

/// Bilinear look-up on one thread, at places that do not follow the memory.
fn look_up(report: &mut Report, object: &DisplacedObject) {
    let Some(paint) = object.paint() else { return };
    let field = paint.field();
    let tiles: Vec<u32> = field.allocated().collect();
    let places: Vec<Place> = (0..PLACES)
        .map(|k| {
            let part = |factor: u32| k.wrapping_mul(factor) as f32 / u32::MAX as f32;
            let tile = tiles[k.wrapping_mul(2_654_435_761) as usize % tiles.len()];
            Place::new(tile, part(3_242_174_889), part(2_447_445_413))
        })
        .collect();
    let rates = sample(RUNS, || {
        let time = seconds(|| places.iter().map(|place| field.color(*place)).sum::<Vec4>());
        1e-6 * f64::from(PLACES) / time
    });
    report.add("look-up of colour, one thread", &rates, None, "M/s", Goal::AtLeast(20.0));
    // Footprints of one to eight texels, square.
    let squares: Vec<[[f32; 2]; 2]> = (0..PLACES)
        .map(|k| {
            let width = (1 + k % 8) as f32 / field.size(tiles[0]) as f32;
            [[width, 0.0], [0.0, width]]
        })
        .collect();
    let rates = sample(RUNS, || {
        let filtered = || places.iter().zip(&squares).map(|(place, square)| field.filtered(*place, *square));
        let time = seconds(|| filtered().sum::<Vec4>());
        1e-6 * f64::from(PLACES) / time
    });
    report.add("filtered look-up of colour, one thread, one by one", &rates, None, "M/s", Goal::None);
    let mut colors = vec![Vec4::ZERO; places.len()];
    let rates = sample(RUNS, || {
        let time = seconds(|| field.filtered_many(&places, &squares, &mut colors));
        1e-6 * f64::from(PLACES) / time
    });
    report.add("filtered look-up of colour, one thread, many at a time", &rates, None, "M/s", Goal::AtLeast(20.0));
}
