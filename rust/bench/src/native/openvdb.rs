//! The module over OpenVDB: opening it, level sets of a mesh beside our voxeliser on the same lattice, and a large grid of
//! floats through both readers.

use std::process::Command;

use glam::{DAffine3, DMat3, DVec3};
use relievo_core::progress::Silent;
use relievo_core::{Context, Error, Result, file};
use relievo_detail::{Grid as Lattice, Obb, Side, Solid, Voxels};
use relievo_openvdb::{Block, Grid, Kind, Module, Transform, Writing, read, write};
use relievo_particleio::read_grid;

use crate::measure::{Sample, compare, seconds};
use crate::report::{Goal, Report};
use crate::shapes;

/// Runs of each side.
const RUNS: usize = 5;
/// Voxels along each axis of the large grid: 101 MB of floats.
const EDGE: u32 = 294;

/// Measures every case into `report`.
pub fn run(report: &mut Report) -> Result<()> {
    let before = threads();
    let module = match Module::open() {
        Ok(module) => module,
        Err(error) => {
            report.skip("OpenVDB", &error.to_string());
            return Ok(());
        }
    };
    let own = opening(
        &module.path().display().to_string(),
        "library.rlvdb_initialize(1, ctypes.create_string_buffer(65536))",
    );
    let alone = opening("libopenvdb.so.10.0", "");
    match own {
        Some(own) => {
            let peer = alone.as_ref().map(|time| ("libopenvdb alone", time));
            report.add("open the OpenVDB module", &own, peer, "ms", Goal::AtMost(30.0));
        }
        None => report.skip("open the OpenVDB module", "there is no python3 to do it in fresh processes"),
    }
    let more = Sample::new(vec![threads() - before]);
    report.add("threads that opening it leaves", &more, None, "", Goal::AtMost(0.0));
    let context = Context::serial();
    match shapes::model(&context, "meshes/stanford-bunny.obj")? {
        Some(mesh) => {
            for edge in [256, 512] {
                level_set(&context, report, &mesh, edge)?;
            }
        }
        None => report.skip("level sets of the bunny", "the model is not there"),
    }
    reading(&context, report)
}

/// Returns the milliseconds that fresh processes of Python take to load a library and to run a statement on it. Of the
/// distribution's library alone this is what the dynamic linker needs for its relocations.
fn opening(library: &str, statement: &str) -> Option<Sample> {
    let script = format!(
        "import ctypes, time; start = time.perf_counter(); library = ctypes.CDLL({library:?}); {statement}\n\
         print(1e3 * (time.perf_counter() - start))"
    );
    let run = || {
        let made = Command::new("python3").args(["-c", &script]).output().ok()?;
        String::from_utf8(made.stdout).ok()?.trim().parse().ok()
    };
    let times: Option<Vec<f64>> = (0..RUNS).map(|_| run()).collect();
    times.map(Sample::new)
}

fn threads() -> f64 {
    std::fs::read_dir("/proc/self/task").map_or(0, Iterator::count) as f64
}

/// A level set with `edge` voxels along the longest edge of the mesh's box, beside solid voxels of ours.
fn level_set(context: &Context, report: &mut Report, mesh: &relievo_core::Mesh, edge: u32) -> Result<()> {
    let (low, high) = mesh.bounds().ok_or_else(|| Error::invalid("the mesh has no points"))?;
    let [low, high] = [low, high].map(|end| DVec3::from(end.map(f64::from)));
    let voxel = (high - low).max_element() / f64::from(edge);
    let triangles = mesh.triangles();
    let (middle, half) = (0.5 * (low + high), DVec3::splat(0.5 * voxel * f64::from(edge)));
    let lattice = Lattice::new(&Obb { center: middle, axes: DMat3::IDENTITY, half }, u64::from(edge).pow(3), None);
    let solid = Solid {
        points: &mesh.points,
        triangles: &triangles,
        transform: DAffine3::IDENTITY,
        closed: true,
        lattice: None,
    };
    let transform = Transform::uniform(voxel);
    let module = || Grid::of_mesh(context, &mesh.points, &triangles, &transform, [3.0; 2], &mut Silent);
    let mut voxels = Voxels::default();
    // What goes well once goes well every time: the timed calls need no check.
    voxels.fill(context, &lattice, &solid, None, Side::Forward)?;
    module()?;
    let (ours, peer) = compare(
        RUNS,
        || 1e3 * seconds(|| voxels.fill(context, &lattice, &solid, None, Side::Forward)),
        || 1e3 * seconds(module),
    );
    let [x, y, z] = lattice.dims;
    // The scan has holes, so neither has an inside everywhere; the work is the same.
    let case = format!("bunny, solid voxels, {x} x {y} x {z}; level set, {edge} along the longest edge");
    report.add(&case, &ours, Some(("OpenVDB", &peer)), "ms", Goal::None);
    Ok(())
}

/// A grid of floats that vary from voxel to voxel, read from a file by our reader and by the module, checks included.
fn reading(context: &Context, report: &mut Report) -> Result<()> {
    let folder = tempfile::tempdir().map_err(|error| Error::io(&std::env::temp_dir(), &error))?;
    let path = folder.path().join("large.vdb");
    let value = |at: u32| 1.0 + (at.wrapping_mul(2_654_435_761) >> 22) as f32;
    let bytes = (0..EDGE.pow(3)).flat_map(|at| value(at).to_ne_bytes()).collect();
    let mut grid = Grid::new(Kind::Float, [0.0; 3], 0.1)?;
    grid.set_block(context, &Block { low: [0; 3], size: [EDGE; 3], kind: Kind::Float, bytes }, 0.0)?;
    write(context, &path, &[&grid], &Writing::default(), &mut Silent)?;
    drop(grid);
    let limit = 1 << 32;
    let own = || file::load(&path, limit).and_then(|bytes| read_grid(&bytes, None, limit));
    let module = || read(context, &path, None, None, &mut Silent);
    own()?;
    module()?;
    let (ours, peer) = compare(RUNS, || 1e3 * seconds(own), || 1e3 * seconds(module));
    report.add("read 101 MB of floats", &ours, Some(("OpenVDB", &peer)), "ms", Goal::None);
    Ok(())
}
