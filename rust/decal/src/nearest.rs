//! The place of a mesh nearest to a point (Ericson 2004, Section 5.1.5).

use relievo_core::{Error, Mesh, Result};

use crate::pins::Place;
use crate::surface::{Vec3, dot, holes, length, minus};

/// Returns the place on a triangle mesh nearest to a point, and its distance. Looks at every face that is no hole.
///
/// # Errors
/// The mesh is unusable or has faces of more than three corners, or the point is not finite.
pub fn nearest(mesh: &Mesh, point: Vec3) -> Result<(Place, f64)> {
    mesh.check()?;
    if !point.iter().all(|value| value.is_finite()) {
        return Err(Error::invalid("the point is not finite").advise("give three numbers"));
    }
    let holes = holes(mesh);
    let mut best: Option<(Place, f64)> = None;
    for (face, corners) in mesh.faces().enumerate().filter(|(face, _)| holes.binary_search(&(*face as u32)).is_err()) {
        let [a, b, c] = *corners else {
            return Err(Error::unsupported(format!("it has {} corners", corners.len()))
                .at(format!("face {face}"))
                .advise("triangulate the mesh, or tessellate its surface"));
        };
        let corners = [a, b, c].map(|corner| mesh.points[corner as usize].map(f64::from));
        let barycentric = weights(corners, point);
        let place: Vec3 =
            std::array::from_fn(|axis| (0..3).map(|corner| barycentric[corner] * corners[corner][axis]).sum());
        let distance = length(minus(place, point));
        if best.is_none_or(|best| distance < best.1) {
            best = Some((Place { face: face as u32, barycentric }, distance));
        }
    }
    best.ok_or_else(|| Error::invalid("the mesh has no faces, or holes alone"))
}

/// Returns the barycentric coordinates of the point of a triangle nearest to another point.
pub fn weights([a, b, c]: [Vec3; 3], point: Vec3) -> [f64; 3] {
    let (ab, ac) = (minus(b, a), minus(c, a));
    let from = |corner: Vec3| {
        let way = minus(point, corner);
        (dot(ab, way), dot(ac, way))
    };
    let ((d1, d2), (d3, d4), (d5, d6)) = (from(a), from(b), from(c));
    if d1 <= 0.0 && d2 <= 0.0 {
        return [1.0, 0.0, 0.0];
    }
    if d3 >= 0.0 && d4 <= d3 {
        return [0.0, 1.0, 0.0];
    }
    if d6 >= 0.0 && d5 <= d6 {
        return [0.0, 0.0, 1.0];
    }
    let (over_a, over_b, over_c) = (d3 * d6 - d5 * d4, d5 * d2 - d1 * d6, d1 * d4 - d3 * d2);
    if over_c <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        let share = d1 / (d1 - d3);
        return [1.0 - share, share, 0.0];
    }
    if over_b <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        let share = d2 / (d2 - d6);
        return [1.0 - share, 0.0, share];
    }
    if over_a <= 0.0 && d4 >= d3 && d5 >= d6 {
        let share = (d4 - d3) / ((d4 - d3) + (d5 - d6));
        return [0.0, 1.0 - share, share];
    }
    let sum = over_a + over_b + over_c;
    [over_a / sum, over_b / sum, over_c / sum]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_place_is_no_farther_than_any_sample() {
        let corners = [[0.0, 0.0, 0.0], [2.0, 0.5, 0.3], [0.4, 1.5, -0.2]];
        let mesh =
            Mesh::from_triangles(corners.map(|corner| corner.map(|value: f64| value as f32)).to_vec(), &[[0, 1, 2]]);
        for index in 0..500 {
            let turn = f64::from(index);
            let point = [1.0 + 2.0 * (1.7 * turn).sin(), 0.5 + 2.0 * (2.3 * turn).cos(), (0.9 * turn).sin()];
            let (place, distance) = nearest(&mesh, point).expect("a mesh");
            assert!(place.barycentric.iter().all(|weight| (-1e-12..=1.0 + 1e-12).contains(weight)));
            for sample in 0..400 {
                let (u, v) = (f64::from(sample % 20) / 19.0, f64::from(sample / 20) / 19.0);
                let weights = [1.0 - u, u * (1.0 - v), u * v];
                let other: Vec3 =
                    std::array::from_fn(|axis| (0..3).map(|corner| weights[corner] * corners[corner][axis]).sum());
                assert!(distance <= length(minus(other, point)) + 1e-6);
            }
        }
    }
}
