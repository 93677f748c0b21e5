//! Face-varying attributes such as UVs, subdivided as smoothly as the surface: the values and the faces that share them
//! are a cage of their own, whose seams are boundaries. Its limit has the tiles of the surface and the numbers of the
//! attribute as coordinates; it is OpenSubdiv's rule `FVAR_LINEAR_CORNERS_ONLY`.

use std::collections::HashMap;
use std::hash::Hash;

use relievo_core::{Context, Crease, Domain, Error, Mesh, Result, Values};

use crate::{Surface, SurfaceOptions};

impl Surface {
    /// The limit of the corner attribute `name` of `mesh`, of width 1 to 3: at (tile, u, v) its position has the
    /// attribute's numbers, and zeros beyond its width. Creases of the mesh hold for the attribute too.
    ///
    /// # Errors
    /// Fails with `Invalid` if the mesh does not pass [`Mesh::check`] or has no such attribute of floats on corners,
    /// and as [`Surface::new`] does for the cage that its values make.
    pub fn face_varying(context: &Context, mesh: &Mesh, name: &str, options: &SurfaceOptions) -> Result<Self> {
        Surface::new(context, &cage(mesh, name)?, options).map_err(|error| error.at(format!("attribute `{name}`")))
    }
}

/// The cage whose points are the values of a corner attribute.
fn cage(mesh: &Mesh, name: &str) -> Result<Mesh> {
    mesh.check()?;
    let attribute =
        mesh.attribute(name).ok_or_else(|| Error::invalid(format!("there is no attribute `{name}`")).at("mesh"))?;
    let (Domain::Corner, Values::F32(values), 1..=3) = (attribute.domain, &attribute.values, attribute.width) else {
        return Err(Error::invalid("only floats on corners, up to three per corner, can be subdivided")
            .at(format!("attribute `{name}`")));
    };
    let width = attribute.width as usize;
    let values: Vec<[f32; 3]> =
        values.chunks_exact(width).map(|value| std::array::from_fn(|i| value.get(i).copied().unwrap_or(0.0))).collect();
    let (points, corners) = match &attribute.indices {
        Some(indices) => share(&mesh.corners, |corner| indices[corner], |corner| values[indices[corner] as usize]),
        None => share(&mesh.corners, |corner| values[corner].map(f32::to_bits), |corner| values[corner]),
    };
    let mut cage = Mesh::new(points, mesh.face_sizes.clone(), corners);
    cage.holes = mesh.holes.clone();
    carry_tags(mesh, &mut cage);
    Ok(cage)
}

/// One value for all corners that agree in their point and in `key`; the values, and the index of each corner's. The
/// same value at two points is two values: faces that all have the same square of a texture do not meet because of it.
pub(crate) fn share<K: Hash + Eq, T>(
    points: &[u32],
    key: impl Fn(usize) -> K,
    value: impl Fn(usize) -> T,
) -> (Vec<T>, Vec<u32>) {
    let (mut first, mut values) = (HashMap::new(), Vec::new());
    let corners = points.iter().enumerate().map(|(corner, point)| {
        *first.entry((*point, key(corner))).or_insert_with(|| {
            values.push(value(corner));
            values.len() as u32 - 1
        })
    });
    let corners = corners.collect();
    (values, corners)
}

/// Gives the attribute's cage the creases and sharp points of the mesh, wherever its values stand for their points.
fn carry_tags(mesh: &Mesh, cage: &mut Mesh) {
    let edge = |a: u32, b: u32| (a.min(b), a.max(b));
    let sharp: HashMap<(u32, u32), f32> =
        mesh.creases.iter().map(|crease| (edge(crease.points[0], crease.points[1]), crease.sharpness)).collect();
    let sharp_points: HashMap<u32, f32> = mesh.sharp_points.iter().copied().collect();
    if sharp.is_empty() && sharp_points.is_empty() {
        return;
    }
    let mut first = 0;
    for size in &mesh.face_sizes {
        let size = *size as usize;
        for corner in 0..size {
            let (here, next) = (first + corner, first + (corner + 1) % size);
            if let Some(sharpness) = sharp.get(&edge(mesh.corners[here], mesh.corners[next])) {
                let points = [cage.corners[here], cage.corners[next]];
                cage.creases.push(Crease { points, sharpness: *sharpness });
            }
            if let Some(sharpness) = sharp_points.get(&mesh.corners[here]) {
                cage.sharp_points.push((cage.corners[here], *sharpness));
            }
        }
        first += size;
    }
}

#[cfg(test)]
mod tests {
    use relievo_core::Attribute;

    use super::*;
    use crate::Place;

    /// A cube whose UVs are `map` of its points, one value per point or one per corner.
    fn cube(map: impl Fn([f32; 3]) -> [f32; 2], per_corner: bool) -> Mesh {
        let points: Vec<[f32; 3]> =
            (0..8).map(|i| [(i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2 & 1) as f32]).collect();
        let corners = vec![0, 2, 3, 1, 4, 5, 7, 6, 0, 1, 5, 4, 2, 6, 7, 3, 0, 4, 6, 2, 1, 3, 7, 5];
        let mut mesh = Mesh::new(points, vec![4; 6], corners);
        mesh.creases.push(Crease { points: [0, 1], sharpness: 2.0 });
        let (values, indices): (Vec<_>, _) = if per_corner {
            (mesh.corners.iter().map(|point| map(mesh.points[*point as usize])).collect(), None)
        } else {
            (mesh.points.iter().map(|point| map(*point)).collect(), Some(mesh.corners.clone()))
        };
        let values = Values::F32(values.as_flattened().to_vec());
        mesh.attributes.push(Attribute { name: "uv".into(), domain: Domain::Corner, width: 2, values, indices });
        mesh
    }

    #[test]
    fn an_affine_function_of_the_points_stays_one_on_the_limit() {
        let context = Context::serial();
        let map = |p: [f32; 3]| [2.0 * p[0] - p[1] + 0.5 * p[2] + 3.0, p[1] + 0.25 * p[0]];
        for per_corner in [false, true] {
            let mesh = cube(map, per_corner);
            let options = SurfaceOptions::default();
            let surface = Surface::new(&context, &mesh, &options).unwrap();
            let uv = Surface::face_varying(&context, &mesh, "uv", &options).unwrap();
            for tile in 0..6 {
                for (u, v) in [(0.0, 0.0), (0.3, 0.9), (0.01, 0.5), (1.0, 0.6)] {
                    let place = Place::new(tile, u, v);
                    let expected = map(surface.sample(context.level(), place).unwrap().p);
                    let got = uv.sample(context.level(), place).unwrap().p;
                    for axis in 0..2 {
                        assert!((got[axis] - expected[axis]).abs() < 1e-5, "{place:?}: {got:?} and {expected:?}");
                    }
                }
            }
        }
    }

    #[test]
    fn seams_keep_their_corners_and_collapsed_faces_are_accepted() {
        let context = Context::serial();
        // Every face has the unit square to itself.
        let square = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        let mut mesh = cube(|_| [0.0; 2], true);
        mesh.attributes[0].values = Values::F32(square.as_flattened().repeat(6));
        mesh.attributes[0].indices = None;
        let uv = Surface::face_varying(&context, &mesh, "uv", &SurfaceOptions::default()).unwrap();
        for (place, expected) in
            [((0.0, 0.0), [0.0, 0.0, 0.0]), ((0.25, 0.0), [0.25, 0.0, 0.0]), ((1.0, 1.0), [1.0, 1.0, 0.0])]
        {
            let got = uv.sample(context.level(), Place::new(3, place.0, place.1)).unwrap().p;
            assert!((0..3).all(|axis| (got[axis] - expected[axis]).abs() < 0.05), "{got:?}");
        }
        let collapsed = cube(|_| [0.5, 0.5], false);
        let mut indexed = collapsed.clone();
        indexed.attributes[0].values = Values::F32(vec![0.5, 0.5]);
        indexed.attributes[0].indices = Some(vec![0; 24]);
        for mesh in [collapsed, indexed] {
            let uv = Surface::face_varying(&context, &mesh, "uv", &SurfaceOptions::default()).unwrap();
            let p = uv.sample(context.level(), Place::new(0, 0.4, 0.7)).unwrap().p;
            assert!((p[0] - 0.5).abs() < 1e-6 && (p[1] - 0.5).abs() < 1e-6 && p[2] == 0.0, "{p:?}");
        }
        assert!(Surface::face_varying(&context, &mesh, "st", &SurfaceOptions::default()).is_err());
    }

    #[test]
    fn faces_that_share_one_square_of_a_texture_do_not_meet_there() {
        let context = Context::serial();
        let side = 24u32;
        let points = (0..(side + 1) * (side + 1)).map(|i| [(i % (side + 1)) as f32, (i / (side + 1)) as f32, 0.0]);
        let faces = (0..side * side).map(|i| i % side + i / side * (side + 1));
        let corners = faces.flat_map(|first| [first, first + 1, first + side + 2, first + side + 1]).collect();
        let mut mesh = Mesh::new(points.collect(), vec![4; (side * side) as usize], corners);
        mesh.attributes.push(Attribute {
            name: "uv".into(),
            domain: Domain::Corner,
            width: 2,
            values: Values::F32(vec![0.0, 0.0, 1.0, 0.0, 1.0, 1.0, 0.0, 1.0]),
            indices: Some([0, 1, 2, 3].repeat((side * side) as usize)),
        });
        // As seams, the borders of all faces are refined alike. Were the four values four points of 576 faces each,
        // this would be refused for its patches.
        let options = SurfaceOptions { patch_limit: 20 * side * side, ..Default::default() };
        let uv = Surface::face_varying(&context, &mesh, "uv", &options).unwrap();
        for tile in [0, 100, side * side - 1] {
            let p = uv.sample(context.level(), Place::new(tile, 1.0, 0.5)).unwrap().p;
            assert!((p[0] - 1.0).abs() < 1e-6 && (p[1] - 0.5).abs() < 1e-6, "{p:?}");
        }
    }
}
