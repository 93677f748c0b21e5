//! Where a tool meets a surface: the place at which a line comes upon the front of the limit surface. A tool pressed by
//! a force is put there and sinks (Schäfer et al. 2014, Section 7, Sculpting Demo).
//!
//! The line picks its tiles from the hierarchy. Each is cut into a few cells; the cell that the line passes gives the
//! parameters from which Newton's iteration goes to the surface itself.

use glam::{DAffine3, DMat3, DVec2, DVec3};
use relievo_core::Context;
use relievo_surface::{Grid, Order, Place, Placement, Samples};

use crate::geometry::hierarchy::Region;
use crate::object::DisplacedObject;

/// Cells along a side of a tile from which Newton's iteration starts.
const CELLS: u32 = 8;

/// A place of a surface in the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// The point.
    pub point: DVec3,
    /// The unit normal of the surface.
    pub normal: DVec3,
}

impl DisplacedObject {
    /// Where the line through `origin` along `direction`, both in the world, meets the front of the surface without its
    /// displacement; the place nearest to `origin` if there are several. `None` if it meets none, or a number is not
    /// finite or the direction is zero.
    pub fn met_by_line(&self, context: &Context, origin: DVec3, direction: DVec3) -> Option<Contact> {
        let along = direction.try_normalize().filter(|_| origin.is_finite())?;
        let (x, y) = along.any_orthonormal_pair();
        // The line becomes the z axis.
        let inverse = DMat3::from_cols(x, y, along).transpose();
        let map = DAffine3 { matrix3: inverse, translation: -(inverse * origin) } * self.transform;
        let size = self.hierarchy.bounds();
        let size = [size.low, size.high].map(|corner| map.transform_point3(DVec3::from(corner.map(f64::from))));
        let thin = 1e-7 * (size[1] - size[0]).length();
        let mut tiles = Vec::new();
        let low = DVec3::new(-thin, -thin, f64::NEG_INFINITY);
        self.hierarchy.query(context, &Region::new(map, low, -low), &mut tiles);
        tiles.sort_unstable();
        let mut best: Option<(f64, Contact)> = None;
        for tile in tiles {
            for contact in self.tile_met(context, tile, &map) {
                let far = (contact.point - origin).dot(along).abs();
                if contact.normal.dot(along) < 0.0 && best.is_none_or(|(least, _)| far < least) {
                    best = Some((far, contact));
                }
            }
        }
        best.map(|(_, contact)| contact)
    }

    /// The places of a tile on the z axis of the space that `map` leads to.
    fn tile_met(&self, context: &Context, tile: u32, map: &DAffine3) -> Vec<Contact> {
        let grid = Grid::whole(CELLS, Placement::Lattice);
        let mut samples = Samples::default();
        self.surface.grid(context.level(), tile, &grid, Order::Position, &mut samples);
        let side = CELLS + 1;
        let at = |i: u32, j: u32| {
            let index = (j * side + i) as usize;
            let point = samples.p.each_ref().map(|values| f64::from(values[index]));
            map.transform_point3(DVec3::from(point)).truncate()
        };
        let mut found: Vec<Contact> = Vec::new();
        for j in 0..CELLS {
            for i in 0..CELLS {
                for (corners, far) in [([(0, 0), (1, 0), (1, 1)], true), ([(0, 0), (1, 1), (0, 1)], false)] {
                    let [a, b, c] = corners.map(|(di, dj)| at(i + di, j + dj));
                    let Some([wb, wc]) = weights(a, b, c) else { continue };
                    let (u, v) = if far { (wb + wc, wc) } else { (wb, wb + wc) };
                    let start = DVec2::new(f64::from(i) + u, f64::from(j) + v) / f64::from(CELLS);
                    found.extend(self.refined(context, tile, start, map));
                }
            }
        }
        found
    }

    /// Newton's iteration from the parameters `start` to the z axis.
    fn refined(&self, context: &Context, tile: u32, start: DVec2, map: &DAffine3) -> Option<Contact> {
        let vector = |v: [f32; 3]| DVec3::from(v.map(f64::from));
        let mut place = start.clamp(DVec2::ZERO, DVec2::ONE);
        let mut contact = None;
        for _ in 0..8 {
            let sample = Place { tile, u: place.x as f32, v: place.y as f32 };
            let sample = self.surface.sample(context.level(), sample).ok()?;
            let outwards = self.transform.matrix3.inverse().transpose() * vector(sample.normal());
            let point = self.transform.transform_point3(vector(sample.p));
            contact = Some(Contact { point, normal: outwards.try_normalize()? });
            let off = map.transform_point3(vector(sample.p)).truncate();
            let [du, dv] = [sample.du, sample.dv].map(|d| (map.matrix3 * vector(d)).truncate());
            let area = du.perp_dot(dv);
            if area.abs() <= 1e-12 * du.length() * dv.length() {
                break;
            }
            let step = DVec2::new(off.perp_dot(dv), du.perp_dot(off)) / area;
            let next = (place - step).clamp(DVec2::ZERO, DVec2::ONE);
            if next == place {
                break;
            }
            place = next;
        }
        contact
    }
}

/// The weights of `b` and `c` that make the origin from a triangle; `None` if it is outside, with a little slack so
/// that lines through common edges are not lost.
fn weights(a: DVec2, b: DVec2, c: DVec2) -> Option<[f64; 2]> {
    let area = (b - a).perp_dot(c - a);
    let [wb, wc] = [(-a).perp_dot(c - a) / area, (b - a).perp_dot(-a) / area];
    let slack = -1e-3;
    (wb >= slack && wc >= slack && wb + wc <= 1.0 - slack).then_some([wb, wc])
}

#[cfg(test)]
mod tests {
    use super::*;
    use relievo_core::Mesh;
    use relievo_surface::{Surface, SurfaceOptions};
    use relievo_tiles::{Displacement, DisplacementOptions};

    #[test]
    fn lines_meet_the_nearest_front_where_it_is() {
        let context = Context::serial();
        let points = (0..8).map(|i| [0, 1, 2].map(|axis| if i >> axis & 1 == 0 { -1.0 } else { 1.0 })).collect();
        let corners = vec![0, 4, 6, 2, 1, 3, 7, 5, 0, 1, 5, 4, 2, 6, 7, 3, 0, 2, 3, 1, 4, 5, 7, 6];
        let cube = Mesh::new(points, vec![4; 6], corners);
        let surface = Surface::new(&context, &cube, &SurfaceOptions::default()).unwrap();
        let displacement = Displacement::new(surface.topology().clone(), &DisplacementOptions::default()).unwrap();
        let transform = DAffine3::from_translation(DVec3::new(5.0, -2.0, 1.0))
            * DAffine3::from_rotation_z(0.4)
            * DAffine3::from_scale(DVec3::new(2.0, 1.0, 3.0));
        let object = DisplacedObject::new(&context, surface, &cube.points, displacement, transform).unwrap();
        let middle = transform.translation;
        for k in 0..200 {
            let direction = DVec3::new((1.3 * k as f64).sin(), (0.7 * k as f64).cos(), (2.1 * k as f64).sin());
            let aim = middle + 0.3 * DVec3::new((0.9 * k as f64).cos(), (1.1 * k as f64).sin(), 0.2);
            let contact = object.met_by_line(&context, aim - 20.0 * direction.normalize(), direction).unwrap();
            let off = contact.point - aim;
            assert!((off - direction * off.dot(direction) / direction.length_squared()).length() < 1e-4, "{k}");
            assert!(contact.normal.dot(direction) < 0.0 && off.dot(direction) < 0.0, "{k}: {contact:?}");
            // The back is never met, also not from inside.
            let again = object.met_by_line(&context, aim + 20.0 * direction, direction).unwrap();
            assert!((again.point - contact.point).length() < 1e-4, "{k}: {again:?} {contact:?}");
        }
        assert_eq!(object.met_by_line(&context, middle + DVec3::X * 9.0, DVec3::Z), None);
        assert_eq!(object.met_by_line(&context, middle, DVec3::ZERO), None);
    }
}
