//! Surfaces of a description: mesh files, boxes, balls, and curved patches with a thickness.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use relievo_core::{Context, Error, Result};
use relievo_tissue::Shape;
use serde::Deserialize;

/// A surface: one of a mesh file, a box, a sphere and a shell.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Body {
    /// A mesh file.
    mesh: Option<PathBuf>,
    #[serde(rename = "box")]
    cuboid: Option<Cuboid>,
    sphere: Option<Sphere>,
    shell: Option<Shell>,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Cuboid {
    low: [f32; 3],
    high: [f32; 3],
    /// A side alone: `x-` to `z+`.
    side: Option<String>,
    /// Squares along every edge.
    #[serde(default = "one")]
    divisions: u32,
}

fn one() -> u32 {
    1
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Sphere {
    middle: [f32; 3],
    radius: f32,
}

/// A patch of an ellipsoid about the origin, which looks along −y, with a thickness inwards.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Shell {
    /// Half axes of the outer side.
    radii: [f32; 3],
    thickness: f32,
    /// Angles to both sides and up and down, in radians.
    angles: [f32; 2],
    /// A side alone: `outer` or `inner`; its normals point out of the shell.
    side: Option<String>,
}

/// Quads along a side of a shell, and rings of a sphere.
const FINE: u32 = 64;

type Triangles = (Vec<[f32; 3]>, Vec<[u32; 3]>);

impl Body {
    /// Returns a ball about the origin.
    pub fn sphere(radius: f32) -> Self {
        Self { mesh: None, cuboid: None, sphere: Some(Sphere { middle: [0.0; 3], radius }), shell: None }
    }

    /// Returns the mesh file, if it is one.
    pub fn file(&self) -> Option<&Path> {
        self.mesh.as_deref()
    }

    /// Returns the surface under a name. Files are named from a folder.
    ///
    /// # Errors
    /// Fails as [`Self::triangles`]; the error says the name.
    pub fn shape(&self, context: &Context, folder: &Path, name: &str) -> Result<Shape> {
        let (points, triangles) = self.triangles(context, folder).map_err(|error| error.at(format!("`{name}`")))?;
        Ok(Shape { name: name.to_owned(), points, triangles })
    }

    /// Returns the triangles, counter-clockwise seen from outside.
    ///
    /// # Errors
    /// Fails with `Invalid` if it has no shape or more than one, a number of a box or shell is out of range, or there
    /// is no such side, and as [`relievo_meshio::read`] if its mesh file cannot be read.
    pub fn triangles(&self, context: &Context, folder: &Path) -> Result<Triangles> {
        match (&self.mesh, &self.cuboid, &self.sphere, &self.shell) {
            (Some(mesh), None, None, None) => {
                let mesh = relievo_meshio::read(context, &folder.join(mesh))?;
                let triangles = mesh.triangles();
                Ok((mesh.points, triangles))
            }
            (None, Some(cuboid), None, None) => cuboid.triangles(),
            (None, None, Some(sphere), None) => Ok(sphere.triangles()),
            (None, None, None, Some(shell)) => shell.triangles(),
            _ => Err(Error::invalid("it has no shape, or more than one")
                .advise("give it one of mesh, box, sphere and shell")),
        }
    }
}

/// Squares along an edge of a box at most.
const FINEST: u32 = 1024;

impl Cuboid {
    fn triangles(&self) -> Result<Triangles> {
        if !(1..=FINEST).contains(&self.divisions) {
            return Err(Error::invalid(format!("{} divisions of a box cannot be", self.divisions))
                .advise(format!("use 1 to {FINEST}")));
        }
        let sides = ["x-", "x+", "y-", "y+", "z-", "z+"];
        let chosen = match self.side.as_deref() {
            None => 0..6,
            Some(side) => {
                let at = sides.iter().position(|name| *name == side).ok_or_else(|| unknown_side(side, &sides))?;
                at..at + 1
            }
        };
        let mut points = Vec::new();
        let mut numbers = HashMap::new();
        let mut number = |place: [u32; 3]| {
            *numbers.entry(place).or_insert_with(|| {
                points.push(self.point(place));
                points.len() as u32 - 1
            })
        };
        let mut triangles = Vec::new();
        for side in chosen {
            // The other two axes, so that a turn from the first to the second looks outwards.
            let (axis, is_high) = (side / 2, side % 2 == 1);
            let (first, second) =
                if is_high { ((axis + 1) % 3, (axis + 2) % 3) } else { ((axis + 2) % 3, (axis + 1) % 3) };
            for (v, u) in (0..self.divisions).flat_map(|v| (0..self.divisions).map(move |u| (v, u))) {
                let [a, b, c, d] = [(0, 0), (1, 0), (1, 1), (0, 1)].map(|(along, across)| {
                    let mut place = [if is_high { self.divisions } else { 0 }; 3];
                    (place[first], place[second]) = (u + along, v + across);
                    number(place)
                });
                triangles.extend([[a, b, c], [a, c, d]]);
            }
        }
        Ok((points, triangles))
    }

    /// Returns a point by its number along each axis.
    fn point(&self, place: [u32; 3]) -> [f32; 3] {
        std::array::from_fn(|axis| {
            let share = place[axis] as f32 / self.divisions as f32;
            self.low[axis] * (1.0 - share) + self.high[axis] * share
        })
    }
}

impl Sphere {
    fn triangles(&self) -> Triangles {
        let around = 2 * FINE;
        let point = |polar: f32, angle: f32| {
            let unit = [polar.sin() * angle.cos(), polar.sin() * angle.sin(), -polar.cos()];
            std::array::from_fn(|axis| self.middle[axis] + self.radius * unit[axis])
        };
        let mut points = vec![point(0.0, 0.0), point(std::f32::consts::PI, 0.0)];
        for ring in 1..FINE {
            let polar = std::f32::consts::PI * ring as f32 / FINE as f32;
            points.extend((0..around).map(|at| point(polar, std::f32::consts::TAU * at as f32 / around as f32)));
        }
        let id = |ring: u32, at: u32| 2 + (ring - 1) * around + at % around;
        let mut triangles = Vec::new();
        for at in 0..around {
            triangles.push([0, id(1, at + 1), id(1, at)]);
            triangles.push([1, id(FINE - 1, at), id(FINE - 1, at + 1)]);
            for ring in 1..FINE - 1 {
                triangles.push([id(ring, at), id(ring, at + 1), id(ring + 1, at + 1)]);
                triangles.push([id(ring, at), id(ring + 1, at + 1), id(ring + 1, at)]);
            }
        }
        (points, triangles)
    }
}

impl Shell {
    fn triangles(&self) -> Result<Triangles> {
        let least = self.radii.iter().copied().fold(f32::INFINITY, f32::min);
        let is_sound = self.thickness > 0.0
            && self.thickness < least
            && self.angles[0] > 0.0
            && self.angles[0] < 3.0
            && self.angles[1] > 0.0
            && self.angles[1] < 1.5;
        if !is_sound {
            return Err(Error::invalid("a shell has no thickness or angles, or is thicker than its radii")
                .advise("use angles above 0, to 3 sideways and 1.5 upwards"));
        }
        let stride = FINE + 1;
        let mut points: Vec<[f32; 3]> = Vec::new();
        for inwards in [0.0, self.thickness] {
            for v in 0..stride {
                for u in 0..stride {
                    let [a, b] =
                        [(u, 0), (v, 1)].map(|(at, axis)| self.angles[axis] * (2.0 * at as f32 / FINE as f32 - 1.0));
                    let unit = [a.sin() * b.cos(), -a.cos() * b.cos(), b.sin()];
                    points.push(std::array::from_fn(|axis| (self.radii[axis] - inwards) * unit[axis]));
                }
            }
        }
        let layer = stride * stride;
        let id = |side: u32, u: u32, v: u32| side * layer + v * stride + u;
        let quad = |a: u32, b: u32, c: u32, d: u32| [[a, b, c], [a, c, d]];
        let (mut outer, mut inner, mut rim) = (Vec::new(), Vec::new(), Vec::new());
        for v in 0..FINE {
            for u in 0..FINE {
                outer.extend(quad(id(0, u, v), id(0, u + 1, v), id(0, u + 1, v + 1), id(0, u, v + 1)));
                inner.extend(quad(id(1, u, v), id(1, u, v + 1), id(1, u + 1, v + 1), id(1, u + 1, v)));
            }
        }
        for at in 0..FINE {
            rim.extend(quad(id(1, at, 0), id(1, at + 1, 0), id(0, at + 1, 0), id(0, at, 0)));
            rim.extend(quad(id(0, at, FINE), id(0, at + 1, FINE), id(1, at + 1, FINE), id(1, at, FINE)));
            rim.extend(quad(id(0, 0, at), id(0, 0, at + 1), id(1, 0, at + 1), id(1, 0, at)));
            rim.extend(quad(id(1, FINE, at), id(1, FINE, at + 1), id(0, FINE, at + 1), id(0, FINE, at)));
        }
        let triangles = match self.side.as_deref() {
            None => [outer, inner, rim].concat(),
            Some("outer") => outer,
            Some("inner") => inner,
            Some("rim") => rim,
            Some(side) => return Err(unknown_side(side, &["outer", "inner", "rim"])),
        };
        Ok((points, triangles))
    }
}

fn unknown_side(side: &str, sides: &[&str]) -> Error {
    Error::invalid(format!("there is no side `{side}`")).advise(format!("use one of {}", sides.join(", ")))
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;

    #[test]
    fn a_box_of_any_division_is_closed_and_looks_outwards() {
        for divisions in [1, 3] {
            let cuboid = Cuboid { low: [-1.0, 0.0, 2.0], high: [1.0, 3.0, 6.0], side: None, divisions };
            let (points, triangles) = cuboid.triangles().unwrap();
            assert_eq!(points.len() as u32, 6 * divisions * divisions + 2);
            assert_eq!(triangles.len() as u32, 12 * divisions * divisions);
            let at = |point: u32| Vec3::from(points[point as usize]);
            let volume: f32 = triangles.iter().map(|[a, b, c]| at(*a).dot(at(*b).cross(at(*c))) / 6.0).sum();
            assert!((volume - 24.0).abs() < 1e-4, "{volume}");
            let side = Cuboid { side: Some("z+".into()), ..cuboid };
            let (points, triangles) = side.triangles().unwrap();
            assert_eq!(points.len() as u32, (divisions + 1).pow(2));
            assert_eq!(triangles.len() as u32, 2 * divisions * divisions);
        }
    }
}
