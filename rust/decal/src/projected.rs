//! Decals projected onto a surface along a direction.

use relievo_core::{Error, Mesh, Result};

use crate::decal::{Decal, Sticker};
use crate::map::energy::Vec2;
use crate::surface::{Surface, Vec3, cross, dot, length, minus};

/// A plane that an image is projected from, and which faces it reaches.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Projection {
    /// The point in space of the image's centre.
    pub center: Vec3,
    /// The direction from the surface towards the viewer.
    pub towards: Vec3,
    /// The direction in space that is up in the image.
    pub up: Vec3,
    /// The width of the whole image, in units of the mesh.
    pub width: f64,
    /// The largest angle between a face's normal and `towards`, in radians, below π/2.
    pub angle: f64,
    /// The largest distance of a vertex from the plane, in units of the mesh.
    pub depth: f64,
}

/// Projects a sticker onto the faces within the limits of angle and depth. Faces behind others are reached as well.
///
/// # Errors
/// The mesh or the projection is unusable.
pub fn project(mesh: &Mesh, sticker: &Sticker, projection: &Projection) -> Result<Decal> {
    let Projection { center, towards, up, width, angle, depth } = *projection;
    let refuse = |what: &str, remedy: &str| Err(Error::invalid(what).at("projection").advise(remedy));
    let is_finite = [center, towards, up].as_flattened().iter().all(|value| value.is_finite());
    if !is_finite || !(width > 0.0 && width.is_finite() && depth >= 0.0) {
        return refuse("a number is not finite or not positive", "give a positive width and a depth of 0 or more");
    }
    if !(0.0..std::f64::consts::FRAC_PI_2).contains(&angle) {
        return refuse("the angle is out of range", "give an angle of 0 to below pi/2 radians");
    }
    let right = cross(up, towards);
    let (size, norm) = (length(right), length(towards));
    if size <= 1e-9 * length(up) * norm || norm <= 0.0 {
        return refuse("the upward direction points along the projection", "give another upward direction");
    }
    let right = right.map(|value| value / size);
    let towards = towards.map(|value| value / norm);
    let up = cross(towards, right);
    let surface = Surface::new(mesh)?;
    let middle = [0.5, 0.5 * sticker.size[1] / sticker.size[0]];
    let place = |vertex: u32| -> (Vec2, f64) {
        let way = minus(surface.points[vertex as usize], center);
        ([middle[0] + dot(way, right) / width, middle[1] + dot(way, up) / width], dot(way, towards))
    };

    let mut number = vec![u32::MAX; surface.points.len()];
    let (mut old, mut positions) = (Vec::new(), Vec::new());
    let (mut faces, mut triangles) = (Vec::new(), Vec::new());
    for (triangle, corners) in surface.triangles.iter().enumerate() {
        if surface.is_hole(triangle as u32) {
            continue;
        }
        let [a, b, c] = surface.corners(triangle as u32);
        let normal = cross(minus(b, a), minus(c, a));
        if dot(normal, towards) < angle.cos() * length(normal) || dot(normal, towards) <= 0.0 {
            continue;
        }
        let places = corners.map(place);
        if places.iter().any(|place| place.1.abs() > depth) {
            continue;
        }
        let touches = |from: usize, to: usize| sticker.outline.touches(places[from].0, places[to].0);
        if !(touches(0, 1) || touches(1, 2) || touches(2, 0)) {
            continue;
        }
        faces.push(std::array::from_fn(|corner| {
            let number = &mut number[corners[corner] as usize];
            if *number == u32::MAX {
                *number = old.len() as u32;
                old.push(corners[corner]);
                positions.push(places[corner].0);
            }
            *number
        }));
        triangles.push(triangle as u32);
    }
    if faces.is_empty() {
        return refuse("it meets no face", "move the plane, or raise the limits of angle and depth");
    }
    Ok(Decal::assemble(&surface, &old, &positions, faces, &triangles, Vec::new(), sticker))
}
