//! How far two meshes are apart: distances of places that are spread evenly over the area of each from the other. What is
//! near is found by parry's triangle meshes.

use glam::{DVec3, Vec2, Vec3};
use rapier3d::parry::query::{PointQuery, PointQueryWithLocation};
use rapier3d::parry::shape::TriMesh;
use relievo_core::{Context, Error, Result};
use relievo_testing::Random;

use crate::lod::Triangles;
use crate::textured::Textured;

/// Places on each mesh.
const PLACES: usize = 200_000;
/// Places of one task.
const CHUNK_LEN: usize = 1000;

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
        let (low, high) = box_of(&first.0);
        let squares = [squares(context, first, second)?, squares(context, second, first)?].concat();
        let sum: f64 = squares.iter().sum();
        let largest = squares.iter().copied().fold(0.0, f64::max);
        let share = 100.0 / f64::from(low.distance(high));
        Ok(Self { mean: share * (sum / squares.len() as f64).sqrt(), largest: share * largest.sqrt() })
    }
}

/// The corners of the box of points.
pub fn box_of(points: &[[f32; 3]]) -> (Vec3, Vec3) {
    let points = points.iter().map(|point| Vec3::from(*point));
    points.fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), point| (low.min(point), high.max(point)))
}

/// How far the texture at a place of the first mesh is from that at the nearest of the second, in hundredths of its side,
/// for nineteen of twenty places. What is left may have been taken over a seam. The texture repeats.
pub fn texture_shift(context: &Context, first: &Textured, second: &Textured) -> Result<f64> {
    let shape = shape(&second.0)?;
    let at = |(triangles, uvs): &Textured, triangle: usize, shares: [f32; 3]| -> Vec2 {
        let corners = triangles.1[triangle].into_iter().zip(shares);
        corners.map(|(vertex, share)| share * Vec2::from(uvs[vertex as usize])).sum()
    };
    let mut shifts = over_places(context, &first.0, |place| {
        let (_, (triangle, location)) =
            shape.project_local_point_and_get_location(place.point.to_array().into(), false);
        let shares = location.barycentric_coordinates().unwrap_or([1.0 / 3.0; 3]);
        let apart = at(first, place.triangle, place.shares) - at(second, triangle as usize, shares);
        f64::from((apart - apart.round()).length())
    });
    shifts.sort_unstable_by(f64::total_cmp);
    Ok(100.0 * shifts[shifts.len() * 19 / 20])
}

fn shape(mesh: &Triangles) -> Result<TriMesh> {
    let points = mesh.0.iter().map(|point| (*point).into()).collect();
    TriMesh::new(points, mesh.1.clone())
        .map_err(|error| Error::internal(format!("the mesh that is measured on: {error}")))
}

/// Squared distances of places on one mesh from the other.
fn squares(context: &Context, from: &Triangles, to: &Triangles) -> Result<Vec<f64>> {
    let shape = shape(to)?;
    Ok(over_places(context, from, |place| {
        let near = shape.project_local_point(place.point.to_array().into(), false).point;
        DVec3::new(f64::from(near.x), f64::from(near.y), f64::from(near.z)).distance_squared(place.point.as_dvec3())
    }))
}

/// A place on a triangle, and the shares of its corners.
struct Place {
    point: Vec3,
    triangle: usize,
    shares: [f32; 3],
}

/// What `of` says of every one of the places on a mesh.
fn over_places(context: &Context, mesh: &Triangles, of: impl Fn(&Place) -> f64 + Sync) -> Vec<f64> {
    let places = places(mesh);
    let parts = context.map(places.len().div_ceil(CHUNK_LEN), |part| {
        places[part * CHUNK_LEN..places.len().min((part + 1) * CHUNK_LEN)].iter().map(&of).collect::<Vec<_>>()
    });
    parts.into_iter().flatten().collect()
}

/// Places spread over the area of a mesh.
fn places(mesh: &Triangles) -> Vec<Place> {
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
        let shares = [1.0 - root, root * (1.0 - across), root * across];
        Place { point: a * shares[0] + b * shares[1] + c * shares[2], triangle, shares }
    };
    (0..PLACES).map(place).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_texture_is_shifted_by_what_its_coordinates_are() {
        let square = |shift: f32| -> Textured {
            let uvs = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
            let points = uvs.map(|[x, y]| [x, y, 0.0]);
            ((points.to_vec(), vec![[0, 1, 2], [0, 2, 3]]), uvs.map(|[u, v]| [u + shift, v]).to_vec())
        };
        let shift = |shift: f32| texture_shift(&Context::serial(), &square(0.0), &square(shift)).unwrap();
        assert!((shift(0.25) - 25.0).abs() < 1e-3 && (shift(3.25) - 25.0).abs() < 1e-3 && shift(2.0) < 1e-3);
    }

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
