//! Which triangle is seen at a pixel, and what its corners weigh there: barycentric coordinates in homogeneous space
//! (Olano and Greer 1997, Section 3), so that corners behind the eye need no clipping.

/// Barycentric coordinates this far below 0, in shares of the largest, still count, so that no pixel falls between two
/// triangles that share an edge.
const SLACK: f64 = 1e-9;

/// What is seen at a pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Cover {
    /// The indices of the corners.
    pub corners: [usize; 3],
    /// What each corner weighs: the share with which its outputs reach the fragment shader, correct in perspective. They
    /// sum to 1.
    pub shares: [f32; 3],
    depth: f64,
}

/// A triangle whose coordinates are asked for at many pixels.
struct Triangle {
    /// For each corner the plane that is 1 there and 0 at the others, in x, y and w.
    planes: [[f64; 3]; 3],
    depths: [f64; 3],
}

impl Triangle {
    fn of(corners: [[f32; 4]; 3]) -> Option<Self> {
        let [a, b, c] = corners.map(|[x, y, _, w]| [x, y, w].map(f64::from));
        let cross = |p: [f64; 3], q: [f64; 3]| {
            [p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]]
        };
        let planes = [cross(b, c), cross(c, a), cross(a, b)];
        let determinant: f64 = a.iter().zip(planes[0]).map(|(p, q)| p * q).sum();
        let is_sound = determinant != 0.0 && determinant.is_finite();
        let planes = planes.map(|plane| plane.map(|value| value / determinant));
        is_sound.then(|| Self { planes, depths: corners.map(|[_, _, z, _]| f64::from(z)) })
    }

    /// Returns shares of the corners and depth at a place of the screen, each axis from -1 to 1, if it is covered.
    fn at(&self, [x, y]: [f64; 2]) -> Option<([f32; 3], f64)> {
        let weights = self.planes.map(|plane| plane[0] * x + plane[1] * y + plane[2]);
        let slack = SLACK * weights.iter().fold(0.0, |most: f64, weight| most.max(weight.abs()));
        if !weights.iter().all(|weight| *weight >= -slack) {
            return None;
        }
        let weights = weights.map(|weight| weight.max(0.0));
        let sum: f64 = weights.iter().sum();
        // Where all weights are 0 or less, the triangle is behind the eye.
        if sum.is_nan() || sum <= 0.0 {
            return None;
        }
        let depth: f64 = weights.iter().zip(self.depths).map(|(weight, depth)| weight * depth).sum();
        (0.0..=1.0).contains(&depth).then(|| (weights.map(|weight| (weight / sum) as f32), depth))
    }
}

/// Returns what is seen at each pixel of an area, row after row. `place` returns the position in clip space of a vertex;
/// `count` has the vertices of an instance, three to a triangle, and the instances, whose vertices follow one another. Of two
/// triangles the nearer is seen, of two at one depth the later.
pub(super) fn covers(
    place: impl Fn(usize) -> [f32; 4],
    [count, instances]: [usize; 2],
    size: [u32; 2],
    area: [std::ops::Range<u32>; 2],
) -> Vec<Option<Cover>> {
    let [columns, rows] = &area;
    let mut seen: Vec<Option<Cover>> = vec![None; columns.len() * rows.len()];
    let triangles = (0..instances).flat_map(|instance| (0..count / 3).map(move |at| instance * count + 3 * at));
    for first in triangles {
        let corners = &[place(first), place(first + 1), place(first + 2)];
        // For one pixel nearly all triangles end here.
        let [across, down] = bounds(corners, size, &area);
        if across.is_empty() || down.is_empty() {
            continue;
        }
        let Some(triangle) = Triangle::of(*corners) else { continue };
        for row in down {
            for column in across.clone() {
                let place = [(column, size[0], 1.0), (row, size[1], -1.0)]
                    .map(|(at, edge, sign)| sign * ((2.0 * f64::from(at) + 1.0) / f64::from(edge) - 1.0));
                let Some((shares, depth)) = triangle.at(place) else { continue };
                let index = (row - rows.start) as usize * columns.len() + (column - columns.start) as usize;
                if seen[index].is_none_or(|other| depth <= other.depth) {
                    seen[index] = Some(Cover { corners: [first, first + 1, first + 2], shares, depth });
                }
            }
        }
    }
    seen
}

/// Returns the columns and rows of an area in which a triangle can be seen.
fn bounds(corners: &[[f32; 4]; 3], size: [u32; 2], area: &[std::ops::Range<u32>; 2]) -> [std::ops::Range<u32>; 2] {
    if !corners.iter().all(|corner| corner[3] > 0.0) {
        return area.clone();
    }
    [0, 1].map(|axis| {
        let edge = f64::from(size[axis]);
        let sign = if axis == 0 { 1.0 } else { -1.0 };
        let at = |corner: &[f32; 4]| (sign * f64::from(corner[axis]) / f64::from(corner[3]) + 1.0) * 0.5 * edge;
        let low = corners.iter().map(at).fold(f64::INFINITY, f64::min);
        let high = corners.iter().map(at).fold(f64::NEG_INFINITY, f64::max);
        // Conversions saturate.
        let (low, high) = ((low - 1.0).floor() as u32, (high + 1.0).ceil() as u32);
        let own = &area[axis];
        low.clamp(own.start, own.end)..high.clamp(own.start, own.end)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn covers(
        places: &[[f32; 4]],
        count: usize,
        size: [u32; 2],
        area: [std::ops::Range<u32>; 2],
    ) -> Vec<Option<Cover>> {
        super::covers(|vertex| places[vertex], [count, places.len() / count], size, area)
    }

    #[test]
    fn shares_are_those_of_the_perspective_and_the_nearest_triangle_is_seen() {
        // A floor from the eye's feet to the horizon: z = w - 1 in clip space, rows are places of 1 / w.
        let corner = |x: f32, w: f32| [x, -1.0, 0.5 * w, w];
        let floor = [corner(-9.0, 1.0), corner(9.0, 1.0), corner(0.0, 8.0)];
        let cover = covers(&floor, 3, [1, 8], [0..1, 0..8]);
        for (row, found) in cover.iter().enumerate() {
            // y / w = -1 / w at the middle of the row.
            let w = 1.0 / ((2.0 * row as f64 + 1.0) / 8.0 - 1.0);
            match found {
                Some(cover) => {
                    let far = (w - 1.0) / 7.0;
                    assert!((f64::from(cover.shares[2]) - far).abs() < 1e-6, "row {row}: {cover:?} is not {far}");
                    assert!((cover.shares.iter().sum::<f32>() - 1.0).abs() < 1e-6);
                }
                None => assert!(!(1.0..=8.0).contains(&w), "row {row}"),
            }
        }
        // A corner behind the eye clips nothing that is before it; a triangle behind the eye is not seen.
        let behind = [corner(-9.0, 1.0), corner(9.0, 1.0), corner(0.0, -8.0)];
        assert!(covers(&behind, 3, [1, 8], [0..1, 7..8])[0].is_none());
        let sheet = |z: f32| [[-1.0, -1.0, z, 1.0], [3.0, -1.0, z, 1.0], [-1.0, 3.0, z, 1.0]];
        let sheets = [sheet(0.5), sheet(0.25), sheet(0.75), sheet(0.25), sheet(1.5)].concat();
        let middle = covers(&sheets, sheets.len(), [2, 2], [1..2, 0..1])[0].unwrap();
        assert_eq!(middle.corners, [9, 10, 11]);
        // Instances follow one another.
        assert_eq!(covers(&sheets, 3, [2, 2], [1..2, 0..1])[0].unwrap().corners, [9, 10, 11]);
        let nothing = [[f32::NAN; 4], [0.0; 4], [1.0; 4]];
        assert!(covers(&nothing, 3, [2, 2], [0..2, 0..2]).iter().all(Option::is_none));
    }

    #[test]
    fn two_triangles_of_a_square_leave_no_gap() {
        let [a, b, c, d] = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(|[x, y]| [x, y, 0.3, 1.0]);
        let seen = covers(&[a, b, c, a, c, d], 6, [64, 64], [0..64, 0..64]);
        assert!(seen.iter().all(Option::is_some));
    }
}
