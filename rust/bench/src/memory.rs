//! Bench `memory`, a part of `hosts`: the estimate of the memory that a surface of a cage takes, beside the peak of a process
//! that makes it.

use relievo_core::{Context, ContextOptions, Crease, Error, Mesh, Result};
use relievo_surface::{Surface, SurfaceOptions};

use crate::measure::{Sample, memory, peak_of};
use crate::report::{Goal, Report};
use crate::shapes;

/// Names of the cages: generated ones, and files of the folder of models.
const CAGES: [&str; 6] = [
    "regular torus, 16,384 quads",
    "creased plane, 1,024 quads",
    "knot, 3,200 triangles",
    "knot, 12,000 triangles",
    "cages/armorguy.obj",
    "cages/beast.obj",
];

/// Bytes of a megabyte, as error messages count them.
const MEGABYTE: f64 = 1e6;

/// Measures every case into `report`.
pub fn run(report: &mut Report) -> Result<()> {
    let context = context()?;
    for name in CAGES {
        let Some(cage) = cage(&context, name)? else {
            report.skip(name, "the file is not there");
            continue;
        };
        let estimated = Surface::expected_bytes(&context, &cage, &SurfaceOptions::default())? / MEGABYTE;
        let Some(used) = peak_of("cage", "--cage", name) else {
            report.skip(name, "the system does not tell the peak of a process");
            continue;
        };
        let [estimated, used] = [estimated, used / MEGABYTE].map(|value| Sample::new(vec![value]));
        let case = format!("{name}: memory of its surface, estimated");
        report.add(&case, &estimated, Some(("used", &used)), "MB", Goal::RatioAtMost(1.3));
    }
    Ok(())
}

/// Prints how many bytes making the surface of a cage takes at the peak.
pub fn peak(name: &str) -> Result<()> {
    let context = context()?;
    let cage = cage(&context, name)?.ok_or_else(|| Error::invalid(format!("there is no cage `{name}`")))?;
    let before = memory("VmRSS");
    let surface = Surface::new(&context, &cage, &SurfaceOptions::default())?;
    let peak = memory("VmHWM").zip(before).map(|(peak, before)| peak - before);
    drop(surface);
    peak.iter().for_each(|bytes| println!("{bytes}"));
    Ok(())
}

fn context() -> Result<Context> {
    Context::new(&ContextOptions { memory_limit: 0, ..ContextOptions::default() })
}

/// Returns a cage by its name, `None` where its file is not there.
fn cage(context: &Context, name: &str) -> Result<Option<Mesh>> {
    Ok(Some(match name {
        "regular torus, 16,384 quads" => shapes::torus(128, 128),
        "creased plane, 1,024 quads" => creased(32),
        "knot, 3,200 triangles" => shapes::knot(80, 20),
        "knot, 12,000 triangles" => shapes::knot(150, 40),
        file => return shapes::model(context, file),
    }))
}

/// Returns a plane of `side` × `side` quads with creases along every fourth row.
fn creased(side: u32) -> Mesh {
    let mut plane = shapes::terrain(side);
    let row = side + 1;
    for line in (4..side).step_by(4) {
        plane.creases.extend((0..side).map(|at| {
            let from = line * row + at;
            Crease { points: [from, from + 1], sharpness: 2.5 }
        }));
    }
    plane
}
