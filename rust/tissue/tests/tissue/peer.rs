//! Models beside CalculiX, whose program `ccx` runs the files that we write. Without it they are skipped.

use std::fmt::Write as _;
use std::path::Path;
use std::process::Command;

use relievo_core::Context;
use relievo_core::progress::Silent;
use relievo_tissue::{Held, Material, Model, NodeSet, Simulation, SimulationOptions};

use crate::bodies::block;

/// Young's modulus, in Pa.
const YOUNG: f32 = 1e5;

/// A beam of 10 × 1 × 1 m that is held at one end, and the loads of 1 N in all at the other.
fn cantilever() -> (Model, Vec<[f32; 3]>) {
    let mut model = block([10.0, 1.0, 1.0], [20, 2, 2], Material::of_young("rubber", YOUNG, 0.3, 1000.0).unwrap());
    let held = model.nodes_within([-0.01, -1.0, -1.0], [0.01, 2.0, 2.0]);
    model.held = held.into_iter().map(|node| Held { node, axes: 7 }).collect();
    let end = model.nodes_within([9.99, -1.0, -1.0], [11.0, 2.0, 2.0]);
    let mut loads = vec![[0.0; 3]; model.nodes.len()];
    for node in &end {
        // The load of a node is its share of the end face.
        let is_inner = |axis: usize| (0.01..=0.99).contains(&model.nodes[*node as usize][axis]);
        loads[*node as usize][2] = [1, 2].map(|axis| if is_inner(axis) { 0.5 } else { 0.25 }).iter().product();
    }
    model.sets.push(NodeSet { name: "tip".into(), nodes: end });
    (model, loads)
}

/// The mean deflection of the tip that CalculiX finds for the text of a model.
fn calculix(folder: &Path, text: &str, loads: &[[f32; 3]], step: &str) -> f64 {
    let mut input = text.to_owned() + step + "*CLOAD\n";
    for (node, load) in (1..).zip(loads).filter(|(_, load)| load[2] != 0.0) {
        let _ = writeln!(input, "{node}, 3, {}", load[2]);
    }
    input += "*NODE PRINT, NSET=TIP\nU\n*END STEP\n";
    std::fs::write(folder.join("beam.inp"), input).unwrap();
    let run = Command::new("ccx").arg("beam").current_dir(folder).env("OMP_NUM_THREADS", "1").output().unwrap();
    let said = String::from_utf8_lossy(&run.stdout).into_owned();
    assert!(run.status.success(), "{said}");
    let printed = std::fs::read_to_string(folder.join("beam.dat")).unwrap();
    let rows = printed.lines().filter_map(|line| {
        let numbers: Vec<f64> = line.split_whitespace().map_while(|word| word.parse().ok()).collect();
        (numbers.len() == 4).then(|| numbers[3])
    });
    // Of increments the last counts.
    let deflections: Vec<f64> = rows.collect();
    assert!(deflections.len() >= 9, "{printed}\n{said}");
    deflections[deflections.len() - 9..].iter().sum::<f64>() / 9.0
}

#[test]
fn a_cantilever_bends_as_in_calculix() {
    if Command::new("ccx").arg("-v").output().is_err() {
        println!("skipped: no ccx (Debian's calculix-ccx)");
        return;
    }
    let (model, loads) = cantilever();
    let folder = tempfile::tempdir().unwrap();
    let written = model.to_inp();
    // As it was written: reduced integration and a hyperelastic material, so with large displacements.
    let reduced = calculix(folder.path(), &written, &loads, "*STEP, NLGEOM\n*STATIC\n");
    // Incompatible modes bend without locking.
    let (before, after) = written.split_once("*HYPERELASTIC, NEO HOOKE\n").unwrap();
    let rest = after.split_once('\n').unwrap().1;
    let linear = format!("{before}*ELASTIC\n{YOUNG}, 0.3\n{rest}").replace("C3D8R", "C3D8I");
    let full = calculix(folder.path(), &linear, &loads, "*STEP\n*STATIC\n");
    let options = SimulationOptions { gravity: [0.0; 3], ..SimulationOptions::default() };
    let tip = model.set("tip").unwrap().nodes.clone();
    let mut simulation = Simulation::new(model, &options).unwrap();
    simulation.load(&loads).unwrap();
    simulation.relax(&Context::serial(), 1e-7, 12_000, &mut Silent).unwrap();
    let moved = tip.iter().map(|node| f64::from(simulation.state().displacements[*node as usize][2]));
    let ours = moved.sum::<f64>() / tip.len() as f64;
    println!(
        "a tip of 20 × 2 × 2 elements: {ours:.6} m, CalculiX's C3D8I {full:.6} m, its C3D8R {reduced:.6} m; Timoshenko \
         0.040306 m"
    );
    assert!((full / 0.040306 - 1.0).abs() < 0.02, "{full}");
    assert!((ours / full - 1.0).abs() < 0.04, "{ours} {full}");
    assert!(reduced > full && reduced < 1.5 * full, "{reduced} {full}");
}
