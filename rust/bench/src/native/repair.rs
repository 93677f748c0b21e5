//! Repair of meshes: a soup of a million triangles, and models that users import, beside MeshLib.

use relievo_core::progress::Silent;
use relievo_core::{Context, ContextOptions, Mesh, Result};
use relievo_repair::{RepairSettings, repair};
use relievo_testing::Random;

use crate::lod::{Triangles, noisy_knot};
use crate::measure::{Sample, sample, seconds};
use crate::peers::Peer;
use crate::report::{Goal, Report};

/// Runs of each case.
const RUNS: usize = 3;
/// Models with defects.
const MODELS: [&str; 13] = [
    "beetle.obj",
    "bunny_zippered.ply",
    "chair_model.obj",
    "cow.obj",
    "cycloidal.ply",
    "featuretype.ply",
    "joined_tetrahedra.obj",
    "multibody.stl",
    "not_convex.obj",
    "octagonal_pocket.ply",
    "shared.STL",
    "soup.stl",
    "teapot_unwelded.obj",
];

/// Measures every case into `report`, on two threads, beside the programs in `peers`.
pub fn run(report: &mut Report, peers: &[Peer]) -> Result<()> {
    let context = Context::new(&ContextOptions { threads: 2, memory_limit: 0 })?;
    let soup = soup();
    let mesh = Mesh::from_triangles(soup.0.clone(), &soup.1);
    let name = format!("repair of a soup, {} triangles: weld, orient, fill", soup.1.len());
    case(report, &context, &name, &mesh, peers, Goal::AtMost(2.0))?;
    for model in MODELS {
        let Some(path) = relievo_testing::file(&format!("ugly/{model}")) else { continue };
        let mesh = relievo_meshio::read(&context, &path)?;
        case(report, &context, &format!("repair of {model}, {} faces", mesh.face_count()), &mesh, peers, Goal::None)?;
    }
    Ok(())
}

/// Measures the repair of a mesh by us, and by each peer in one run.
fn case(report: &mut Report, context: &Context, name: &str, mesh: &Mesh, peers: &[Peer], goal: Goal) -> Result<()> {
    let settings = RepairSettings::default();
    let made = repair(context, mesh, &settings, &mut Silent)?.report;
    let time = sample(RUNS, || seconds(|| repair(context, mesh, &settings, &mut Silent)));
    let given: Triangles = (mesh.points.clone(), mesh.triangles());
    let name = format!("{name}; {} holes filled, {} left", made.filled_holes, made.open_holes.count);
    let mut is_alone = true;
    for peer in peers {
        match peer.run(&given, &[]) {
            Ok((_, seconds)) => {
                report.add(&name, &time, Some((&peer.name, &Sample::new(vec![seconds]))), "s", goal);
                is_alone = false;
            }
            Err(error) => eprintln!("skipped: {} for {name}: {error}", peer.name),
        }
    }
    if is_alone {
        report.add(&name, &time, None, "s", goal);
    }
    Ok(())
}

/// A knot of about a million triangles that share no point, a third of them turned over, in an order without any, with
/// holes.
fn soup() -> Triangles {
    let (points, mut triangles) = noisy_knot(1260, 400);
    let mut random = Random(7);
    // Around a hundred places the triangles of a square of the grid are missing.
    let squares = triangles.len() / 2;
    let mut is_missing = vec![false; squares];
    for _ in 0..100 {
        let corner = random.below(squares - 8 * 400);
        for row in 0..6 {
            (0..6).for_each(|column| is_missing[corner + row * 400 + column] = true);
        }
    }
    let mut square = 0;
    triangles.retain(|_| {
        square += 1;
        !is_missing[(square - 1) / 2]
    });
    for at in (1..triangles.len()).rev() {
        triangles.swap(at, random.below(at + 1));
    }
    for triangle in &mut triangles {
        if random.below(3) == 0 {
            triangle.swap(0, 1);
        }
    }
    let corners: Vec<[f32; 3]> = triangles.as_flattened().iter().map(|point| points[*point as usize]).collect();
    let apart = (0..triangles.len() as u32).map(|triangle| [3 * triangle, 3 * triangle + 1, 3 * triangle + 2]);
    (corners, apart.collect())
}
