//! Blocks and materials that several tests use.

use relievo_tissue::{Material, Model};

pub fn gel() -> Material {
    Material { name: "gel".into(), density: 1000.0, shear: 1006.71, bulk: 5e4 }
}

pub fn block(size: [f32; 3], counts: [u32; 3], material: Material) -> Model {
    let cell = std::array::from_fn(|axis| size[axis] / counts[axis] as f32);
    Model::block([0.0; 3], cell, counts, material).unwrap()
}

/// The same elements without the knowledge that they are boxes, nodes inside moved by up to `most` of an edge.
pub fn distorted(mut model: Model, most: f32) -> Model {
    let cell = model.cell.take().unwrap();
    let high = model.nodes.iter().copied().reduce(|a, b| std::array::from_fn(|axis| a[axis].max(b[axis]))).unwrap();
    let mut random = 1u64;
    for node in &mut model.nodes {
        for axis in 0..3 {
            random = random.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            let shift = (random >> 40) as f32 / (1u64 << 23) as f32 - 1.0;
            if node[axis] > 0.5 * cell[axis] && node[axis] < high[axis] - 0.5 * cell[axis] {
                node[axis] += most * shift * cell[axis];
            }
        }
    }
    model
}

/// A state whose displacement is a function of the place at rest.
pub fn displaced(model: &Model, at: impl Fn([f32; 3]) -> [f32; 3]) -> relievo_tissue::State {
    let displacements = model.nodes.iter().map(|node| {
        let [x, y, z] = at(*node);
        [x, y, z, 0.0]
    });
    relievo_tissue::State {
        displacements: displacements.collect(),
        velocities: vec![[0.0; 4]; model.nodes.len()],
        ..Default::default()
    }
}
