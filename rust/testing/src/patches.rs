//! Newell's tea set.

use relievo_core::Context;
use relievo_meshio::Patches;

use crate::{Random, file};

/// Reads the teapot and the teacup where the folder of models has them, each as it is and with weights, which are equal
/// where points are, as files repeat points. Returns them with their names.
///
/// # Panics
/// If a file cannot be read.
pub fn tea_set(context: &Context) -> Vec<(String, Patches)> {
    let mut models = Vec::new();
    for name in ["teapot", "teacup"] {
        let Some(path) = file(&format!("patches/{name}")) else { continue };
        let plain = relievo_meshio::read_patches(context, &path).unwrap_or_else(|error| panic!("{error}"));
        let weight = |point: &[f32; 3]| {
            let bits = point.iter().fold(3, |sum, value| 31 * (sum % (1 << 32)) + u64::from((value + 0.0).to_bits()));
            0.3 + 2.0 * Random(bits).unit()
        };
        let weights = Some(plain.points.iter().map(weight).collect());
        models.push((name.to_string(), Patches { weights: None, ..plain.clone() }));
        models.push((format!("rational {name}"), Patches { weights, ..plain }));
    }
    models
}
