//! What a dab of a brush costs on triangle meshes, for the bench `paint`. The figures of Schäfer et al. 2015, Local
//! Painting and Deformation of Meshes on the GPU, Table 1, stand beside ours for as many elements, which are faces and
//! edges; its models are not public, so ours are terrains.

use glam::{DAffine3, DMat3, DVec3, Vec4};
use relievo_core::{Context, Mesh, Result};
use relievo_detail::{Action, Brush, Dab, Falloff, PaintMode, TriangleObject};
use relievo_surface::TriangleSurface;
use relievo_tiles::triangle::{TriangleChannel, TriangleOptions};

use crate::measure::Sample;
use crate::report::{Goal, Report};
use crate::shapes;

/// Whose figures stand beside ours.
const PAPER: &str = "Schäfer 2015, GTX Titan";
/// Squares along a side of the terrains, and the paper's milliseconds of intersecting, scanning and managing the
/// kitten, the horse and the armadillo.
const SIDES: [(u32, f64); 3] =
    [(114, 0.017 + 0.038 + 0.006), (244, 0.058 + 0.122 + 0.006), (318, 0.068 + 0.203 + 0.006)];
/// Runs of each.
const RUNS: usize = 31;

/// Measures every case into `report`.
pub fn run(report: &mut Report, context: &Context) -> Result<()> {
    let mut medians = Vec::new();
    for (side, paper) in SIDES {
        let mut object = object(context, side)?;
        let topology = object.surface().topology();
        let elements = topology.face_count() + topology.edge_count();
        let brush = Brush::new(DVec3::ZERO, DMat3::IDENTITY, DVec3::new(2.9, 2.9, 2.0), Falloff::Constant)?;
        let action = |mode| Action::Paint { mode, color: [0.8, 0.1, 0.1, 1.0] };
        let paint = Dab { brush: brush.clone(), action: action(PaintMode::Mix), strength: 0.5 };
        let erase = Dab { action: action(PaintMode::Erase), strength: 1.0, ..paint.clone() };
        let (mut times, mut wholes) = (Vec::new(), Vec::new());
        let mut faces = 0;
        for _ in 0..=RUNS {
            context.stats().take();
            // Each run allocates: what the one before painted is erased first, which is not counted.
            let start = std::time::Instant::now();
            faces = object.dab(context, &paint)?.allocated;
            wholes.push(1e3 * start.elapsed().as_secs_f64());
            let stages = context.stats().take();
            let managing = stages.iter().filter(|event| ["dab.intersect", "dab.manage"].contains(&event.stage));
            times.push(managing.map(|event| 1e3 * event.length.as_secs_f64()).sum());
            object.dab(context, &erase)?;
        }
        times.remove(0);
        wholes.remove(0);
        let times = Sample::new(times);
        medians.push(times.median());
        let case = format!("triangles: intersect, scan, manage: {faces} faces, {elements} elements");
        let paper = Sample::new(vec![paper]);
        report.add(&case, &times, Some((PAPER, &paper)), "ms", Goal::AtMost(0.2));
        report.add(
            &format!("triangles: dab of colour: {faces} faces at 16"),
            &Sample::new(wholes),
            None,
            "ms",
            Goal::None,
        );
    }
    if let [first, .., last] = medians[..] {
        let ratio = Sample::new(vec![last / first]);
        report.add("triangles: largest over smallest", &ratio, None, "", Goal::AtMost(2.0));
    }
    Ok(())
}

/// A terrain of `side` × `side` squares cut in two, that can be painted.
fn object(context: &Context, side: u32) -> Result<TriangleObject> {
    let cage = shapes::terrain(side);
    let triangles = cage.triangles();
    let mesh = Mesh::from_triangles(cage.points, &triangles);
    let surface = TriangleSurface::new(context, &mesh)?;
    let options = TriangleOptions { segments: 16, ..Default::default() };
    let topology = surface.topology().clone();
    let displacement = TriangleChannel::displacement(topology.clone(), &options)?;
    let mut object = TriangleObject::new(context, surface, displacement, DAffine3::IDENTITY)?;
    object.set_paint(TriangleChannel::of_color(topology, Vec4::new(0.5, 0.5, 0.5, 1.0), &options)?)?;
    Ok(object)
}
