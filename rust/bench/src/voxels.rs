//! Solid voxelisation of whole closed meshes beside OpenVDB's `meshToVolume` on the same lattice.

use glam::{DAffine3, DMat3, DVec3, EulerRot};
use relievo_core::{Context, Mesh, Result};
use relievo_detail::{Grid, Obb, Side, Solid, Voxels};
use relievo_openvdb::peer::LevelSet;

use crate::measure::{compare, seconds};
use crate::report::{Goal, Report};
use crate::shapes;

/// Voxels of the whole mesh, the default of an overlap.
const VOXELS: u64 = 1 << 24;
/// Half the width of OpenVDB's band in voxels: the narrowest that gives it signs, and so its fastest.
const BAND: f32 = 1.0;
/// Runs of each.
const RUNS: usize = 9;

/// Measures generated and public closed meshes.
pub fn run(context: &Context, report: &mut Report) -> Result<()> {
    measure(context, report, "knot", &shapes::knot(200, 50))?;
    for name in ["cages/bigguy.obj", "meshes/horse.ply"] {
        match shapes::model(context, name)? {
            Some(mesh) => measure(context, report, name, &mesh)?,
            None => report.skip(name, "the model is not there"),
        }
    }
    Ok(())
}

fn measure(context: &Context, report: &mut Report, name: &str, mesh: &Mesh) -> Result<()> {
    let triangles = mesh.triangles();
    let axes = DMat3::from_euler(EulerRot::XYZ, 0.4, 0.2, -0.7);
    let obb = Obb::of_points(&mesh.points)?.realigned(axes);
    let grid = Grid::new(&obb.enlarged(0.02 * obb.half.max_element()), VOXELS, None);
    let local = |point: &[f32; 3]| grid.map.transform_point3(DVec3::from(point.map(f64::from))) - 0.5;
    let points: Vec<[f32; 3]> = mesh.points.iter().map(|point| local(point).as_vec3().to_array()).collect();
    let solid = Solid {
        points: &mesh.points,
        triangles: &triangles,
        transform: DAffine3::IDENTITY,
        closed: true,
        lattice: None,
    };
    let mut voxels = Voxels::default();
    // What goes well once goes well every time: the timed calls need no check.
    voxels.fill(context, &grid, &solid, None, Side::Forward)?;
    LevelSet::of_mesh(&points, &triangles, BAND)?;
    let (ours, peer) = compare(
        RUNS,
        || 1.0 / seconds(|| voxels.fill(context, &grid, &solid, None, Side::Forward)),
        || 1.0 / seconds(|| LevelSet::of_mesh(&points, &triangles, BAND)),
    );
    let case = format!(
        "voxelise {name}, {} triangles, {} x {} x {} voxels",
        triangles.len(),
        grid.dims[0],
        grid.dims[1],
        grid.dims[2]
    );
    report.add(&case, &ours, Some(("OpenVDB meshToVolume", &peer)), "1/s", Goal::RatioAtLeast(20.0));
    Ok(())
}
