//! Moves the new points of a filling so that it continues the surface around the hole, after Liepa 2003, Section 5: they
//! minimise the sum of squared Laplacians at the new vertices and of squared second differences across the loop.

use glam::DVec3;

use crate::refine::Filling;

/// The most steps of conjugate gradients.
const STEPS: usize = 500;
/// The part of the first residual at which they end.
const PRECISION: f64 = 1e-7;

/// Moves the vertices after the first `border`. `around` are the positions of the mesh next to each vertex of the loop,
/// without those of the loop itself.
pub fn fair(filling: &mut Filling, border: usize, around: &[Vec<DVec3>]) {
    let count = filling.places.len();
    if count == border {
        return;
    }
    let rows = rows(filling, border, around);
    // The residuals of all rows, of values that vanish outside.
    let apply = |values: &[DVec3]| -> Vec<DVec3> {
        let row = |(vertex, row): (usize, &Row)| {
            let sum: DVec3 = row.terms.iter().map(|(other, weight)| *weight * values[*other as usize]).sum();
            row.weight * values[vertex] - sum
        };
        rows.iter().enumerate().map(row).collect()
    };
    let transposed = |values: &[DVec3]| -> Vec<DVec3> {
        let mut sums: Vec<DVec3> = rows.iter().zip(values).map(|(row, value)| row.weight * *value).collect();
        for (row, value) in rows.iter().zip(values) {
            row.terms.iter().for_each(|(other, weight)| sums[*other as usize] -= *weight * *value);
        }
        sums[..border].fill(DVec3::ZERO);
        sums
    };
    let mut start = filling.places.clone();
    let mut given = apply(&start);
    given.iter_mut().zip(&rows).for_each(|(value, row)| *value -= row.constant);
    let mut residual: Vec<DVec3> = transposed(&given).iter().map(|value| -*value).collect();
    let mut direction = residual.clone();
    let square = |values: &[DVec3]| values.iter().map(|value| value.length_squared()).sum::<f64>();
    let first = square(&residual);
    let mut current = first;
    for _ in 0..STEPS {
        if current <= first * PRECISION * PRECISION {
            break;
        }
        let image = apply(&direction);
        let step = current / square(&image).max(f64::MIN_POSITIVE);
        let change = transposed(&image);
        for vertex in border..count {
            start[vertex] += step * direction[vertex];
            residual[vertex] -= step * change[vertex];
        }
        let next = square(&residual);
        for vertex in border..count {
            direction[vertex] = residual[vertex] + next / current * direction[vertex];
        }
        current = next;
    }
    if start.iter().all(|place| place.is_finite()) {
        filling.places = start;
    }
}

/// A vector that is to be small: a vertex, less the weighted sum of others and a constant.
struct Row {
    weight: f64,
    terms: Vec<(u32, f64)>,
    constant: DVec3,
}

/// At new vertices the Laplacian with uniform weights. At those of the loop, half of the mean of the neighbours in the
/// filling and half of that of the neighbours outside: their numbers differ, and must not pull the filling to either side.
fn rows(filling: &Filling, border: usize, around: &[Vec<DVec3>]) -> Vec<Row> {
    let mut near: Vec<Vec<u32>> = vec![Vec::new(); filling.places.len()];
    for [a, b, c] in &filling.triangles {
        for (from, to) in [(a, b), (b, c), (c, a)] {
            near[*from as usize].push(*to);
            near[*to as usize].push(*from);
        }
    }
    let row = |(vertex, near): (usize, &mut Vec<u32>)| {
        near.sort_unstable();
        near.dedup();
        if vertex >= border {
            let weight = 1.0 / near.len() as f64;
            return Row {
                weight: 1.0,
                terms: near.iter().map(|other| (*other, weight)).collect(),
                constant: DVec3::ZERO,
            };
        }
        near.retain(|other| *other as usize >= border);
        let outside = &around[vertex];
        if near.is_empty() || outside.is_empty() {
            return Row { weight: 0.0, terms: Vec::new(), constant: DVec3::ZERO };
        }
        let weight = 0.5 / near.len() as f64;
        let constant = outside.iter().sum::<DVec3>() * (0.5 / outside.len() as f64);
        Row { weight: 1.0, terms: near.iter().map(|other| (*other, weight)).collect(), constant }
    };
    near.iter_mut().enumerate().map(row).collect()
}
