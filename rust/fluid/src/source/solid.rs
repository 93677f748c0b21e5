//! What is inside of a triangle mesh: where fluid begins, and where it is taken away.
//!
//! Lines along the three axes are counted in and out of the triangles that they cross, by the way these are wound, and a
//! place is inside where two of the three say so: a mesh may have holes, or triangles too many, and shells may overlap.

use glam::{DVec2, DVec3, IVec3, Vec3, Vec3A};
use relievo_core::{Context, Error, Result};

use crate::boundary::collider::{join, volume};
use crate::surface::hierarchy::{Bounds, Entry, Hierarchy};

/// Places of a fill that are looked at, at most.
const MAX: f32 = (1u32 << 28) as f32;
/// How far lines are beside the places that they are for, in spacings, so that they do not meet points of meshes that lie
/// in the same lattice.
const BESIDE: [f32; 2] = [2.713e-4, 1.927e-4];

/// Places a spacing apart, from half a spacing beside the low sides of a box on.
pub struct Lattice {
    low: Vec3,
    spacing: f32,
    count: IVec3,
}

impl Lattice {
    /// Those in a box by its corners. Fails if there are too many, or a number is not finite.
    pub fn new(low: Vec3, high: Vec3, spacing: f32) -> Result<Self> {
        let size = ((high - low) / spacing + 1e-3).floor();
        // What is not a number is refused too.
        if !(spacing > 0.0 && size.is_finite() && size.max(Vec3::ONE).element_product() <= MAX) {
            return Err(
                Error::memory("a fill has too many particles").advise("take a larger spacing or a smaller shape")
            );
        }
        Ok(Self { low, spacing, count: size.as_ivec3() })
    }

    /// How many there are along each axis.
    pub fn counts(&self) -> [usize; 3] {
        self.count.to_array().map(|count| count.max(0) as usize)
    }

    /// The place of these numbers along the axes.
    pub fn at(&self, cell: [usize; 3]) -> Vec3 {
        self.low + self.spacing * (Vec3::from(cell.map(|at| at as f32)) + 0.5)
    }
}

/// A triangle mesh with an inside.
pub struct Solid {
    points: Vec<Vec3>,
    triangles: Vec<[u32; 3]>,
    bounds: Bounds,
    hierarchy: Hierarchy,
}

impl Solid {
    /// Of points in metres and triangles of them, wound either way.
    ///
    /// # Errors
    /// Fails if a number is not finite, a point does not exist, or there is no triangle.
    pub fn new(points: &[Vec3], triangles: &[[u32; 3]]) -> Result<Self> {
        if let Some(number) = points.iter().position(|point| !point.is_finite()) {
            return Err(Error::invalid("a place is not finite").at(format!("point {number}")));
        }
        if let Some(number) = triangles.iter().position(|triangle| triangle.iter().any(|p| *p as usize >= points.len()))
        {
            return Err(Error::invalid("a point does not exist").at(format!("triangle {number}")));
        }
        if triangles.is_empty() {
            return Err(Error::invalid("a mesh without triangles has no inside"));
        }
        let around = |triangle: &[u32; 3]| {
            triangle.iter().fold(Bounds::NONE, |all, point| {
                let at = Vec3A::from(points[*point as usize]);
                all.with(Bounds { low: at, high: at })
            })
        };
        let boxes: Vec<Bounds> = triangles.iter().map(around).collect();
        Ok(Self {
            bounds: boxes.iter().fold(Bounds::NONE, |all, other| all.with(*other)),
            hierarchy: Hierarchy::new(&boxes),
            points: points.to_vec(),
            triangles: triangles.to_vec(),
        })
    }

    /// Its volume in m³; `None` if it has holes, or triangles that are wound against each other.
    pub fn volume(&self) -> Option<f64> {
        volume(&self.points, &self.triangles, &join(&self.points)).map(|six| six.abs() / 6.0)
    }

    /// Whether a place is inside.
    pub fn is_inside(&self, place: Vec3) -> bool {
        let at = Vec3A::from(place);
        if !(at.cmpge(self.bounds.low) & at.cmple(self.bounds.high)).all() {
            return false;
        }
        let mut room = Room::default();
        let votes = (0..3).filter(|axis| {
            self.cross(place, *axis, 1e-3, &mut room);
            winding(&room.crossings, f64::from(place[*axis])) != 0
        });
        votes.count() > 1
    }

    /// The places of particles that fill it, in metres: those of a lattice of a spacing that are inside and half a
    /// spacing or more from its surface. The lattice begins half a spacing from the low sides of its box, so that a box
    /// is filled as [`crate::surface::block`] does.
    ///
    /// # Errors
    /// Fails if the spacing is not positive, or the box of the solid has more than 2²⁸ places
    /// ([`ErrorKind::Memory`](relievo_core::ErrorKind)).
    pub fn fill(&self, context: &Context, spacing: f32) -> Result<Vec<Vec3>> {
        let (low, high) = (Vec3::from(self.bounds.low), Vec3::from(self.bounds.high));
        let lattice = Lattice::new(low, high, spacing)?;
        let at = |cell: IVec3| lattice.at(cell.to_array().map(|at| at as usize));
        let [nx, ny, nz] = lattice.counts();
        let mut layers = context.map(nz, |z| {
            let mut room = Room::default();
            let mut votes = vec![0u8; nx * ny];
            for axis in 0..2 {
                for row in 0..if axis == 0 { ny } else { nx } {
                    let first = if axis == 0 { [0, row, z] } else { [row, 0, z] };
                    self.cross(at(IVec3::from(first.map(|at| at as i32))), axis, spacing, &mut room);
                    for step in 0..if axis == 0 { nx } else { ny } {
                        let (x, y) = if axis == 0 { (step, row) } else { (row, step) };
                        let place = at(IVec3::new(x as i32, y as i32, z as i32));
                        votes[y * nx + x] += u8::from(winding(&room.crossings, f64::from(place[axis])) != 0);
                    }
                }
            }
            votes
        });
        let mut room = Room::default();
        for y in 0..ny {
            for x in 0..nx {
                self.cross(at(IVec3::new(x as i32, y as i32, 0)), 2, spacing, &mut room);
                for (z, votes) in layers.iter_mut().enumerate() {
                    let place = at(IVec3::new(x as i32, y as i32, z as i32));
                    votes[y * nx + x] += u8::from(winding(&room.crossings, f64::from(place.z)) != 0);
                }
            }
        }
        let inside = context.map(nz, |z| {
            let cells = (0..nx * ny).filter(|cell| layers[z][*cell] > 1);
            let places = cells.map(|cell| at(IVec3::new((cell % nx) as i32, (cell / nx) as i32, z as i32)));
            let mut near = Vec::new();
            places.filter(|place| !self.is_near(*place, 0.499 * spacing, &mut near)).collect::<Vec<Vec3>>()
        });
        Ok(inside.concat())
    }

    /// Whether a triangle is nearer to a place than a distance.
    fn is_near(&self, place: Vec3, distance: f32, near: &mut Vec<u32>) -> bool {
        let bounds = Bounds { low: (place - distance).into(), high: (place + distance).into() };
        self.hierarchy.overlap(&bounds, near);
        near.iter().any(|triangle| {
            let corners = self.triangles[*triangle as usize].map(|point| self.points[point as usize] - place);
            nearest(corners).length_squared() < distance * distance
        })
    }

    /// Finds where the line through a place along an axis crosses triangles, in order, and which way.
    fn cross(&self, place: Vec3, axis: usize, spacing: f32, room: &mut Room) {
        let [u, v] = [(axis + 1) % 3, (axis + 2) % 3];
        let mut origin = place;
        origin[u] += BESIDE[0] * spacing;
        origin[v] += BESIDE[1] * spacing;
        let flat = |at: Vec3| DVec2::new(f64::from(at[u]), f64::from(at[v]));
        let line = flat(origin);
        self.hierarchy.meet(origin, Vec3::AXES[axis], [f32::MIN, f32::MAX], &mut room.met);
        room.crossings.clear();
        for entry in &room.met {
            let corners = self.triangles[entry.leaf as usize].map(|point| self.points[point as usize]);
            let sides =
                [0, 1, 2].map(|side| beside(flat(corners[(side + 1) % 3]), flat(corners[(side + 2) % 3]), line));
            if sides.iter().all(|(_, is_left)| *is_left) || !sides.iter().any(|(_, is_left)| *is_left) {
                let whole: f64 = sides.iter().map(|(area, _)| area).sum();
                let at: f64 = sides.iter().zip(corners).map(|((area, _), corner)| area * f64::from(corner[axis])).sum();
                let way = if sides[0].1 { 1 } else { -1 };
                // A triangle along the line is crossed nowhere.
                if whole != 0.0 {
                    room.crossings.push((at / whole, way));
                }
            }
        }
        room.crossings.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    }
}

/// What looking along a line needs.
#[derive(Default)]
struct Room {
    met: Vec<Entry>,
    /// How far along the axis, and 1 or −1.
    crossings: Vec<(f64, i32)>,
}

/// How often a line has gone in and not out before a place along it.
fn winding(crossings: &[(f64, i32)], place: f64) -> i32 {
    crossings.iter().take_while(|(at, _)| *at < place).map(|(_, way)| way).sum()
}

/// Twice the area that an edge spans with a point, and whether the point is to its left; the other way round it is the
/// opposite, to the bit, so that of two neighbours just one has a point on their edge.
fn beside(a: DVec2, b: DVec2, point: DVec2) -> (f64, bool) {
    let is_turned = (b.x, b.y) < (a.x, a.y);
    let (from, to) = if is_turned { (b, a) } else { (a, b) };
    let area = (to - from).perp_dot(point - from);
    if is_turned { (-area, area < 0.0) } else { (area, area >= 0.0) }
}

/// The place of a triangle that is nearest to the origin (Ericson 2004, Section 5.1.5).
pub fn nearest(corners: [Vec3; 3]) -> Vec3 {
    let [a, b, c] = corners.map(|corner| corner.as_dvec3());
    let (ab, ac) = (b - a, c - a);
    let [d1, d2, d3, d4, d5, d6] = [-ab.dot(a), -ac.dot(a), -ab.dot(b), -ac.dot(b), -ab.dot(c), -ac.dot(c)];
    let [va, vb, vc] = [d3 * d6 - d5 * d4, d5 * d2 - d1 * d6, d1 * d4 - d3 * d2];
    let at: DVec3 = if d1 <= 0.0 && d2 <= 0.0 {
        a
    } else if d3 >= 0.0 && d4 <= d3 {
        b
    } else if d6 >= 0.0 && d5 <= d6 {
        c
    } else if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        a + ab * (d1 / (d1 - d3))
    } else if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        a + ac * (d2 / (d2 - d6))
    } else if va <= 0.0 && d4 >= d3 && d5 >= d6 {
        b + (c - b) * ((d4 - d3) / ((d4 - d3) + (d5 - d6)))
    } else {
        a + (ab * vb + ac * vc) / (va + vb + vc)
    };
    at.as_vec3()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::block;
    use crate::cuboid;

    #[test]
    fn a_box_is_filled_as_a_block() {
        let (low, high) = (Vec3::new(0.1, -0.2, 0.0), Vec3::new(0.6, 0.2, 0.7));
        let (points, mut triangles) = cuboid(low, high);
        let expected = block(low, high, 0.1).unwrap();
        let fill =
            |triangles: &[[u32; 3]]| Solid::new(&points, triangles).unwrap().fill(&Context::serial(), 0.1).unwrap();
        let same = |found: Vec<Vec3>| {
            found.len() == expected.len() && found.iter().zip(&expected).all(|(a, b)| a.distance(*b) < 1e-5)
        };
        assert!(same(fill(&triangles)));
        assert!((Solid::new(&points, &triangles).unwrap().volume().unwrap() - 0.14).abs() < 1e-6);
        assert!(Solid::new(&points, &triangles[1..]).unwrap().volume().is_none());
        triangles.iter_mut().for_each(|triangle| triangle.reverse());
        assert!(same(fill(&triangles)));
        // A hole is seen along one axis alone.
        assert!(same(fill(&triangles[1..])));
    }

    #[test]
    fn a_ball_is_filled_up_to_half_a_spacing_from_its_surface() {
        let (points, triangles) = crate::sphere(Vec3::ZERO, 1.0);
        let solid = Solid::new(&points, &triangles).unwrap();
        let spacing = 0.08;
        let filled = solid.fill(&Context::serial(), spacing).unwrap();
        assert!(filled.iter().all(|place| place.length() < 1.0 - 0.49 * spacing));
        let volume = filled.len() as f32 * spacing.powi(3);
        let expected = 4.0 / 3.0 * std::f32::consts::PI * (1.0 - 0.5 * spacing).powi(3);
        assert!((volume / expected - 1.0).abs() < 0.03, "{volume} {expected}");
        let inside = filled.iter().step_by(7).all(|place| solid.is_inside(*place));
        assert!(inside && !solid.is_inside(Vec3::splat(0.6)) && !solid.is_inside(Vec3::new(2.0, 0.0, 0.0)));
    }

    #[test]
    fn what_has_no_inside_is_refused() {
        let (points, triangles) = cuboid(Vec3::ZERO, Vec3::ONE);
        assert!(Solid::new(&points, &[]).is_err() && Solid::new(&points, &[[0, 1, 9]]).is_err());
        assert!(Solid::new(&[Vec3::NAN, Vec3::X, Vec3::Y], &[[0, 1, 2]]).is_err());
        let solid = Solid::new(&points, &triangles).unwrap();
        assert!(solid.fill(&Context::serial(), 1e-4).is_err());
        assert!(solid.fill(&Context::serial(), f32::NAN).is_err());
        assert!(Solid::new(&points, &[[0, 0, 0]]).unwrap().fill(&Context::serial(), 0.1).unwrap().is_empty());
    }
}
