//! How far two meshes are apart: distances of places that are spread evenly over the area of each from the other. What is
//! near is found by parry's triangle meshes.

use glam::{DVec3, Vec3};
use rapier3d::parry::query::PointQuery;
use rapier3d::parry::shape::TriMesh;
use relievo_core::{Context, Error, Result};
use relievo_testing::Random;

use crate::lod::Triangles;

/// Places on each mesh.
const PLACES: usize = 200_000;
/// Places of one task.
const PART: usize = 1000;

/// Distances both ways, in hundredths of the diagonal of the first mesh.
pub struct Deviation {
    /// The root of the mean square.
    pub mean: f64,
    /// The largest: Hausdorff's distance.
    pub largest: f64,
}

impl Deviation {
    /// Between two meshes, whose corners have to be in range.
    pub fn between(context: &Context, first: &Triangles, second: &Triangles) -> Result<Self> {
        let (low, high) = first.0.iter().fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), point| {
            (low.min(Vec3::from(*point)), high.max(Vec3::from(*point)))
        });
        let squares = [squares(context, first, second)?, squares(context, second, first)?].concat();
        let sum: f64 = squares.iter().sum();
        let largest = squares.iter().copied().fold(0.0, f64::max);
        let share = 100.0 / f64::from(low.distance(high));
        Ok(Self { mean: share * (sum / squares.len() as f64).sqrt(), largest: share * largest.sqrt() })
    }
}

/// Squared distances of places on one mesh from the other.
fn squares(context: &Context, from: &Triangles, to: &Triangles) -> Result<Vec<f64>> {
    let points = to.0.iter().map(|point| (*point).into()).collect();
    let shape = TriMesh::new(points, to.1.clone())
        .map_err(|error| Error::internal(format!("the mesh that is measured on: {error}")))?;
    let places = places(from);
    let parts = context.map(places.len().div_ceil(PART), |part| {
        let places = places[part * PART..places.len().min((part + 1) * PART)].iter();
        let squared = |place: &Vec3| {
            let near = shape.project_local_point(place.to_array().into(), false).point;
            DVec3::new(f64::from(near.x), f64::from(near.y), f64::from(near.z)).distance_squared(place.as_dvec3())
        };
        places.map(squared).collect::<Vec<_>>()
    });
    Ok(parts.into_iter().flatten().collect())
}

/// Places spread over the area of a mesh.
fn places(mesh: &Triangles) -> Vec<Vec3> {
    let corners = |triangle: &[u32; 3]| triangle.map(|vertex| Vec3::from(mesh.0[vertex as usize]));
    let mut sum = 0.0;
    let areas = mesh.1.iter().map(|triangle| {
        let [a, b, c] = corners(triangle).map(|corner| corner.as_dvec3());
        sum += (b - a).cross(c - a).length();
        sum
    });
    let areas: Vec<f64> = areas.collect();
    let mut random = Random(1);
    let place = |_| {
        let at = f64::from(random.unit()) * sum;
        let triangle = areas.partition_point(|area| *area < at).min(areas.len() - 1);
        let [a, b, c] = corners(&mesh.1[triangle]);
        let (root, across) = (random.unit().sqrt(), random.unit());
        a * (1.0 - root) + b * (root * (1.0 - across)) + c * (root * across)
    };
    (0..PLACES).map(place).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn squares_apart_are_as_far_as_they_are() {
        let square = |height: f32, side: f32| -> Triangles {
            let points = [[0.0, 0.0], [side, 0.0], [side, side], [0.0, side]].map(|[x, y]| [x, y, height]);
            (points.to_vec(), vec![[0, 1, 2], [0, 2, 3]])
        };
        let context = Context::serial();
        let same = Deviation::between(&context, &square(0.0, 1.0), &square(0.1, 1.0)).unwrap();
        let diagonal = 2.0f64.sqrt();
        assert!((same.mean - 10.0 / diagonal).abs() < 1e-4 && (same.largest - 10.0 / diagonal).abs() < 1e-4);
        // One way only there is something that is far.
        let larger = Deviation::between(&context, &square(0.0, 1.0), &square(0.0, 2.0)).unwrap();
        assert!((larger.largest - 100.0).abs() < 1.0);
    }
}
