//! Bench `surface`: evaluation of limit surfaces over tile grids, beside OpenSubdiv's evaluators and beside the time
//! that merely storing as many numbers takes, which is the floor: P, du and dv are 36 bytes a sample and 33
//! multiply-adds.

use std::hint::black_box;

use relievo_core::simd::Level;
use relievo_core::{Context, Mesh, Result};
use relievo_opensubdiv::reference::{Bfr, far_grid};
use relievo_surface::{Destination, Grid, Order, Placement, SampleSlices, Surface, SurfaceOptions};

use crate::measure::{compare, sample, seconds};
use crate::report::{Goal, Report};
use crate::shapes;

/// Floats of the buffer stored to: 256 MiB, more than any cache holds.
const BUFFER: usize = (256 << 20) / size_of::<f32>();

/// Samples along a tile's edge.
const SIZE: usize = 128;

/// Floats of a tile's P, du and dv.
const TILE: usize = 9 * SIZE * SIZE;

/// Runs of each side.
const RUNS: usize = 5;

/// Measures every case into `report`.
pub fn run(report: &mut Report) -> Result<()> {
    let context = Context::serial();
    let mut buffer = vec![0.0; BUFFER];
    regular(report, &context, &mut buffer)?;
    for name in ["monsterfrog", "car", "bishop", "suzanne"] {
        match shapes::model(&context, &format!("cages/{name}.obj"))? {
            Some(mesh) => model(report, &context, name, &mesh, &mut buffer)?,
            None => eprintln!("skipped: cages/{name}.obj is not there"),
        }
    }
    Ok(())
}

/// A torus has regular tiles only, so that nothing but storing is left to do.
fn regular(report: &mut Report, context: &Context, buffer: &mut [f32]) -> Result<()> {
    let surface = Surface::new(context, &shapes::torus(32, 16), &SurfaceOptions::default())?;
    let buffer = std::cell::RefCell::new(buffer);
    let mut value = 0.0;
    let bytes = (surface.tile_count().min(BUFFER / TILE) * TILE * size_of::<f32>()) as f64;
    let (ours, floor) = compare(
        2 * RUNS,
        || bytes / seconds(|| grids(context.level(), &surface, &mut buffer.borrow_mut())) / 1e9,
        || {
            value += 1.0;
            let end = bytes as usize / size_of::<f32>();
            bytes / seconds(|| black_box(&mut buffer.borrow_mut()[..end]).fill(black_box(value))) / 1e9
        },
    );
    report.add("regular tiles, stores", &ours, Some(("constants", &floor)), "GB/s", Goal::RatioAtLeast(0.5));
    Ok(())
}

fn model(report: &mut Report, context: &Context, name: &str, mesh: &Mesh, buffer: &mut [f32]) -> Result<()> {
    let surface = Surface::new(context, mesh, &SurfaceOptions::default())?;
    let samples = (surface.tile_count() * SIZE * SIZE) as f64;
    let buffer = std::cell::RefCell::new(buffer);
    let ours = || samples / seconds(|| grids(context.level(), &surface, &mut buffer.borrow_mut())) / 1e6;
    // As precise as the table beside it is at its isolation.
    let mut bfr = Bfr::new(surface.table(), 6)?;
    let rate = |samples: Result<u64>, time: f64| samples.map_or(f64::NAN, |samples| samples as f64 / time / 1e6);
    let (mine, peer) = compare(RUNS, ours, || {
        let mut count = Ok(0);
        let time = seconds(|| count = bfr.grid(&mesh.points, SIZE, &mut buffer.borrow_mut()));
        rate(count, time)
    });
    report.add(&format!("{name}, P du dv"), &mine, Some(("Bfr", &peer)), "M/s", Goal::RatioAtLeast(15.0));
    let points: Vec<[f32; 3]> =
        surface.table_points(context, &mesh.points).iter().map(|point| point.map(|value| value as f32)).collect();
    let (mine, peer) = compare(RUNS, ours, || {
        let mut count = Ok(0);
        let time = seconds(|| count = far_grid(surface.table(), &points, SIZE, &mut buffer.borrow_mut()));
        rate(count, time)
    });
    report.add(&format!("{name}, P du dv"), &mine, Some(("Far", &peer)), "M/s", Goal::None);
    let build = sample(RUNS, || 1e3 * seconds(|| Surface::new(context, mesh, &SurfaceOptions::default())));
    report.add(&format!("{name}, {} patches, build", surface.patch_count()), &build, None, "ms", Goal::None);
    let pose = sample(RUNS, || 1e3 * seconds(|| surface.posed(context, &mesh.points)));
    report.add(&format!("{name}, new pose"), &pose, None, "ms", Goal::None);
    Ok(())
}

/// Evaluates every tile into the buffer, from its start again when it is full.
fn grids(level: Level, surface: &Surface, buffer: &mut [f32]) {
    let grid = Grid::whole(SIZE as u32, Placement::Centred);
    for tile in 0..surface.tile_count() {
        let first = tile % (BUFFER / TILE) * TILE;
        let mut values = SampleSlices::default();
        for (index, values_of) in buffer[first..first + TILE].chunks_exact_mut(SIZE * SIZE).enumerate() {
            values.values[index / 3][index % 3] = values_of;
        }
        surface.grid_into(level, tile as u32, &grid, Order::First, Destination::Memory, &mut values);
    }
}
