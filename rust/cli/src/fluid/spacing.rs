//! How far particles are apart, where their file does not say.

use relievo_core::{Error, Result};
use rstar::RTree;

/// Particles whose nearest neighbours are looked for at most.
const SAMPLES: usize = 4096;

/// Estimates the distance between particles at rest, in metres, by the median of the distances between particles and their
/// nearest neighbours. Of more than 4,096 particles as many are taken at equal steps.
///
/// # Errors
/// There are fewer than two particles, or most of them coincide.
pub fn estimate(points: &[[f32; 3]]) -> Result<f32> {
    let points: Vec<[f32; 3]> =
        points.iter().copied().filter(|point| point.iter().all(|value| value.is_finite())).collect();
    let tree = RTree::bulk_load(points.clone());
    let step = points.len().div_ceil(SAMPLES).max(1);
    let mut distances: Vec<f32> = points
        .iter()
        .step_by(step)
        .filter_map(|point| Some(tree.nearest_neighbor_iter_with_distance_2(*point).nth(1)?.1.sqrt()))
        .collect();
    let middle = distances.len() / 2;
    let median = if distances.is_empty() { 0.0 } else { *distances.select_nth_unstable_by(middle, f32::total_cmp).1 };
    if median > 0.0 && median.is_finite() {
        return Ok(median);
    }
    Err(Error::invalid("the file does not say how far particles are apart, and it cannot be estimated")
        .advise("give --spacing"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_lattice_has_its_own_spacing() {
        let points: Vec<[f32; 3]> =
            (0..8000).map(|at| [at % 20, at / 20 % 20, at / 400].map(|place| 0.25 * place as f32)).collect();
        assert_eq!(estimate(&points), Ok(0.25));
        assert!(estimate(&points[..1]).is_err());
        assert!(estimate(&[[1.0; 3]; 9]).unwrap_err().to_string().contains("--spacing"));
    }
}
