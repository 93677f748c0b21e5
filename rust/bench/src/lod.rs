//! Bench `lod`: simplification beside meshoptimizer's, which moves vertices too. Deviations are root mean squares of
//! distances of places, both ways, in hundredths of the diagonal: what is near is found by parry's triangle meshes.

use glam::{DVec3, Vec3};
use rapier3d::parry::query::PointQuery;
use rapier3d::parry::shape::TriMesh;
use relievo_core::progress::Silent;
use relievo_core::{Context, ContextOptions, Error, Result};
use relievo_lod::{SimplifyOptions, simplify};
use relievo_testing::Random;

use crate::measure::{Sample, compare, sample, seconds};
use crate::report::{Goal, Report};
use crate::{progressive, shapes};

/// The share of triangles that is left.
const LEFT: f64 = 0.1;
/// Places on each mesh that deviations are measured at.
const PLACES: usize = 200_000;
/// Runs of each side.
const RUNS: usize = 5;

pub type Triangles = (Vec<[f32; 3]>, Vec<[u32; 3]>);

/// Measures every case into `report`.
pub fn run(report: &mut Report) -> Result<()> {
    let context = Context::new(&ContextOptions::default())?;
    let knot = shapes::knot(640, 256);
    let wave = |p: Vec3| p.x.sin() * (1.1 * p.y + 1.3).sin() * (0.9 * p.z + 0.7).cos();
    let noisy = |point: &[f32; 3]| {
        let point = Vec3::from(*point);
        let octaves = (0..5).map(|octave| 2.0f32.powi(octave));
        let noise: f32 = octaves.map(|octave| 0.03 / octave * wave(point * 4.0 * octave)).sum();
        (point * (1.0 + noise)).to_array()
    };
    let noisy_knot: Triangles = (knot.points.iter().map(noisy).collect(), knot.triangles());
    let rate = case(report, &context, "noisy knot, 327,680 triangles", &noisy_knot)?;
    let flat = shapes::terrain(404);
    let points = flat.points.iter().map(|[x, y, _]| [*x, *y, 0.0]).collect();
    let flat = (points, flat.triangles());
    let time = sample(RUNS, || seconds(|| ours(&context, &flat)));
    let curved = Sample::new(vec![noisy_knot.1.len() as f64 / rate / 1e6]);
    let name = "flat grid, 326,432 triangles: time beside a curved mesh";
    report.add(name, &time, Some(("the noisy knot", &curved)), "s", Goal::RatioAtMost(1.5));
    for name in ["horse.ply", "igea.ply", "ogre.obj", "stanford-bunny.obj", "fandisk.obj"] {
        match shapes::model(&context, &format!("meshes/{name}"))? {
            Some(mesh) => {
                let triangles = mesh.triangles();
                case(report, &context, &format!("{name}, {} triangles", triangles.len()), &(mesh.points, triangles))?;
            }
            None => eprintln!("skipped: meshes/{name} is not there"),
        }
    }
    progressive_cases(report, &context, noisy)
}

/// Progressive meshes: the paper's horse, and meshes of ours of the sizes of two of its dragons.
fn progressive_cases(report: &mut Report, context: &Context, noisy: impl Fn(&[f32; 3]) -> [f32; 3]) -> Result<()> {
    match shapes::model(context, "meshes/horse.ply")? {
        Some(mesh) => {
            let (told, triangles) = ([0.3, 0.162, 0.595, 0.443, 0.384], mesh.triangles());
            progressive::case(report, context, "horse.ply", &(mesh.points, triangles), (Some(told), Some(0.15)))?;
        }
        None => eprintln!("skipped: meshes/horse.ply is not there"),
    }
    for (around, across, told) in
        [(1050, 415, [1.4, 0.313, 1.201, 0.882, 0.674]), (3000, 1204, [10.4, 0.347, 0.760, 0.379, 0.335])]
    {
        let knot = shapes::knot(around, across);
        let mesh = (knot.points.iter().map(&noisy).collect(), knot.triangles());
        progressive::case(report, context, "noisy knot", &mesh, (Some(told), None))?;
    }
    let knot = shapes::knot(1200, 420);
    progressive::editing(report, context, "noisy knot", &(knot.points.iter().map(&noisy).collect(), knot.triangles()))
}

/// Measures a mesh, and returns our rate in millions of triangles a second.
fn case(report: &mut Report, context: &Context, name: &str, mesh: &Triangles) -> Result<f64> {
    let millions = mesh.1.len() as f64 / 1e6;
    let (mine, peer) =
        compare(RUNS, || millions / seconds(|| ours(context, mesh)), || millions / seconds(|| theirs(mesh)));
    report.add(name, &mine, Some(("meshoptimizer", &peer)), "Mtri/s", Goal::RatioAtLeast(1.0));
    let (mine_left, peer_left) = (deviation(mesh, &ours(context, mesh)?)?, deviation(mesh, &theirs(mesh))?);
    let samples = [Sample::new(vec![mine_left]), Sample::new(vec![peer_left])];
    let peer = Some(("meshoptimizer", &samples[1]));
    report.add(&format!("{name}: deviation"), &samples[0], peer, "% of diagonal", Goal::RatioAtMost(0.85));
    Ok(mine.median())
}

fn left(mesh: &Triangles) -> usize {
    (mesh.1.len() as f64 * LEFT) as usize
}

fn ours(context: &Context, mesh: &Triangles) -> Result<Triangles> {
    let options = SimplifyOptions { faces: left(mesh), ..SimplifyOptions::default() };
    let made = simplify(context, &mesh.0, &mesh.1, &options, &mut Silent)?;
    Ok((made.points, made.triangles))
}

fn theirs(mesh: &Triangles) -> Triangles {
    let (mut points, mut indices) = (mesh.0.clone(), mesh.1.as_flattened().to_vec());
    let options = meshopt::SimplifyOptions::None;
    let count = 3 * left(mesh);
    let count =
        meshopt::simplify_with_update(&mut indices, &mut points, &mut [], &[], 0, None, count, f32::MAX, options, None);
    (points, indices[..count].as_chunks().0.to_vec())
}

/// The root mean square distance between two meshes, both ways, in hundredths of the first one's diagonal.
fn deviation(first: &Triangles, second: &Triangles) -> Result<f64> {
    let (low, high) = first.0.iter().fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), point| {
        (low.min(Vec3::from(*point)), high.max(Vec3::from(*point)))
    });
    let sum = squares(first, second)? + squares(second, first)?;
    Ok(100.0 * (sum / (2 * PLACES) as f64).sqrt() / f64::from(low.distance(high)))
}

/// The sum of squared distances of places on one mesh from the other.
fn squares(from: &Triangles, to: &Triangles) -> Result<f64> {
    let corner = |mesh: &Triangles, vertex: u32| Vec3::from(mesh.0[vertex as usize]);
    let points = to.0.iter().map(|point| (*point).into()).collect();
    let shape = TriMesh::new(points, to.1.clone())
        .map_err(|error| Error::internal(format!("the mesh that is measured on: {error}")))?;
    let mut sum = 0.0;
    let areas: Vec<f64> = from
        .1
        .iter()
        .map(|triangle| {
            let [a, b, c] = triangle.map(|vertex| corner(from, vertex).as_dvec3());
            sum += (b - a).cross(c - a).length();
            sum
        })
        .collect();
    let mut random = Random(1);
    let distances = (0..PLACES).map(|_| {
        let at = f64::from(random.unit()) * sum;
        let triangle = areas.partition_point(|area| *area < at).min(areas.len() - 1);
        let [a, b, c] = from.1[triangle].map(|vertex| corner(from, vertex));
        let (root, across) = (random.unit().sqrt(), random.unit());
        let place = a * (1.0 - root) + b * (root * (1.0 - across)) + c * (root * across);
        let near = shape.project_local_point(place.to_array().into(), false).point;
        DVec3::new(f64::from(near.x), f64::from(near.y), f64::from(near.z)).distance_squared(place.as_dvec3())
    });
    Ok(distances.sum())
}
