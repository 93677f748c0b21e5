//! Grids of OpenVDB from and to models. Without the module they are skipped.

use relievo_core::Context;
use relievo_core::progress::Silent;
use relievo_openvdb::{Grid, Module, Transform};
use relievo_testing::ball;
use relievo_tissue::{Labels, Range, Scan, Simulation, SimulationOptions};

use crate::bodies::gel;

#[test]
fn a_level_set_of_a_ball_becomes_a_model_of_its_volume_and_that_a_grid_of_labels() {
    if Module::open().is_err() {
        println!("skipped: no OpenVDB");
        return;
    }
    let context = Context::serial();
    let (points, triangles) = ball(0.1, 40);
    let voxels = Transform::uniform(0.005);
    let sphere = Grid::of_mesh(&context, &points, &triangles, &voxels, [3.0; 2], &mut Silent).unwrap();
    let fog = sphere.fog(&context, &mut Silent).unwrap();
    let range = |low: f32, high: f32| Labels {
        block: 2,
        share: 0.5,
        materials: vec![gel()],
        ranges: vec![Range { material: 0, low, high }],
    };
    let expected = 4.0 / 3.0 * std::f64::consts::PI * 0.1f64.powi(3);
    let mut models = Vec::new();
    for (grid, labels) in [(&sphere, range(-1e9, 0.0)), (&fog, range(0.5, 1.0))] {
        let scan = Scan::of_grid(&context, grid).unwrap();
        let (model, report) = labels.build(&context, &scan).unwrap();
        // Of fog a voxel and a half from the surface inwards is thinner than a half.
        assert!(report.volume < 1.02 * expected && report.volume > 0.75 * expected, "{report:?}");
        models.push(model);
    }
    let model = models.swap_remove(0);
    let middle = model.nodes.iter().map(|node| f64::from(node[0])).sum::<f64>() / model.nodes.len() as f64;
    assert!(middle.abs() < 2e-3, "{middle}");

    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("ball.vdb");
    let simulation = Simulation::new(model.clone(), &SimulationOptions::default()).unwrap();
    simulation.write_vdb(&context, &path, &simulation.element_states(&context).unwrap()).unwrap();
    let scan = Scan::read_grid(&context, &path, Some("material")).unwrap();
    let labels = Labels { block: 1, ..range(1.0, 1.0) };
    let (again, _) = labels.build(&context, &scan).unwrap();
    assert_eq!(again.elements.len(), model.elements.len());
    let mut places = [&model, &again].map(|model| {
        let mut places: Vec<[i64; 3]> =
            model.nodes.iter().map(|node| node.map(|at| (f64::from(at) * 1e5).round() as i64)).collect();
        places.sort_unstable();
        places
    });
    let second = places[1].clone();
    assert_eq!(places[0].len(), second.len());
    let off =
        places[0].iter_mut().zip(second).map(|(a, b)| (0..3).map(|axis| (a[axis] - b[axis]).abs()).max().unwrap());
    assert!(off.max().unwrap() <= 1);
    let volume = Scan::read_grid(&context, &path, Some("volume")).unwrap();
    assert!(volume.values.iter().all(|value| *value == 0.0 || (*value - 1.0).abs() < 1e-5));
    assert!(Scan::read_grid(&context, &path, Some("strain")).is_err());
}
