//! OpenSubdiv through cxx beside the same calls made in C++ alone: a cage is refined, its patches and stencils are
//! copied out, the points of the stencils are computed and places are evaluated.

use std::cell::RefCell;

use relievo_core::{Context, Crease, Mesh, Result};
use relievo_opensubdiv::reference::{Evaluation, evaluate};
use relievo_opensubdiv::{BoundaryRule, Options, Table};

use crate::measure::{Sample, compare, seconds};
use crate::report::{Goal, Report};
use crate::shapes;

/// Runs of each side.
const RUNS: usize = 15;

/// Places along each edge of a tile.
const PLACES: u32 = 8;

const OPTIONS: Options = Options {
    boundary: BoundaryRule::EdgesAndCorners,
    isolation: 6,
    single_crease: true,
    patch_limit: 1e8,
    memory_limit: u64::MAX,
};

/// P and its first and second derivatives.
type Values = Vec<[[f64; 3]; 6]>;

/// Measures every case into `report`.
pub fn run(report: &mut Report) -> Result<()> {
    case(report, "creased sheet", &creased())?;
    for name in ["monsterfrog", "armorguy"] {
        match shapes::model(&Context::serial(), &format!("cages/{name}.obj"))? {
            Some(mesh) => case(report, name, &mesh)?,
            None => eprintln!("skipped: cages/{name}.obj is not there"),
        }
    }
    Ok(())
}

/// A plane with boundaries, a hole and a row of creases.
fn creased() -> Mesh {
    const SIDE: u32 = 40;
    let mut mesh = shapes::terrain(SIDE);
    let first = 20 * (SIDE + 1);
    mesh.creases = (0..SIDE).map(|x| Crease { points: [first + x, first + x + 1], sharpness: 2.5 }).collect();
    mesh.holes = vec![5 * SIDE + 5];
    mesh
}

fn case(report: &mut Report, name: &str, mesh: &Mesh) -> Result<()> {
    let places = places(mesh);
    let native = Evaluation::new(mesh, &OPTIONS, &places)?;
    let (ours, peer) = (RefCell::new(bound(mesh, &places)), RefCell::new(native.run()));
    let (mine, other) = compare(
        RUNS,
        || 1e3 * seconds(|| *ours.borrow_mut() = bound(mesh, &places)),
        || 1e3 * seconds(|| *peer.borrow_mut() = native.run()),
    );
    report.add(&format!("{name}, refine and evaluate"), &mine, Some(("C++", &other)), "ms", Goal::RatioAtMost(1.05));
    let (ours, peer) = (ours.into_inner()?, peer.into_inner()?);
    let numbers = |values: &Values| values.as_flattened().as_flattened().to_vec();
    let pairs = numbers(&ours).into_iter().zip(numbers(&peer));
    let different = pairs.filter(|(a, b)| a.to_bits() != b.to_bits()).count();
    let different = Sample::new(vec![different as f64]);
    report.add(&format!("{name}, numbers with other bits"), &different, None, "", Goal::AtMost(0.0));
    Ok(())
}

/// Returns a lattice of places on every tile.
fn places(mesh: &Mesh) -> Vec<(u32, f64, f64)> {
    let tiles = mesh.face_sizes.iter().map(|size| if *size == 4 { 1 } else { *size }).sum();
    let at = |index: u32| f64::from(index) / f64::from(PLACES - 1);
    let of_tile = |tile| (0..PLACES * PLACES).map(move |k| (tile, at(k % PLACES), at(k / PLACES)));
    (0..tiles).flat_map(of_tile).collect()
}

/// Refines and evaluates through the binding.
fn bound(mesh: &Mesh, places: &[(u32, f64, f64)]) -> Result<Values> {
    let table = Table::new(mesh, &OPTIONS)?;
    let cage: Vec<[f64; 3]> = mesh.points.iter().map(|point| point.map(f64::from)).collect();
    let mut points = cage.clone();
    points.reserve(table.stencil_sizes().len());
    let (sources, weights) = table.stencil_weights();
    let mut first = 0;
    for size in table.stencil_sizes() {
        let range = first..first + *size as usize;
        first = range.end;
        let mut sum = [0.0; 3];
        for (source, weight) in sources[range.clone()].iter().zip(&weights[range]) {
            let point = cage[*source as usize];
            for axis in 0..3 {
                sum[axis] += weight * point[axis];
            }
        }
        points.push(sum);
    }
    evaluate(&table, &points, places)
}
