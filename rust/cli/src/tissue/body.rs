//! Surfaces of a description: mesh files, boxes, balls, and curved patches with a thickness.

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

    /// Returns the surface under a name. Files are named from a folder.
    pub fn shape(&self, context: &Context, folder: &Path, name: &str) -> Result<Shape> {
        let (points, triangles) = self.triangles(context, folder).map_err(|error| error.at(format!("`{name}`")))?;
        Ok(Shape { name: name.to_owned(), points, triangles })
    }

    /// Returns the triangles, counter-clockwise seen from outside.
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

impl Cuboid {
    fn triangles(&self) -> Result<Triangles> {
        let Self { low, high, side } = self;
        let corner = |at: usize| std::array::from_fn(|axis| if at >> axis & 1 != 0 { high[axis] } else { low[axis] });
        let quads = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
        let sides = ["x-", "x+", "y-", "y+", "z-", "z+"];
        let chosen = match side.as_deref() {
            None => 0..6,
            Some(side) => {
                let at = sides.iter().position(|name| *name == side).ok_or_else(|| unknown_side(side, &sides))?;
                at..at + 1
            }
        };
        let triangles = quads[chosen].iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).collect();
        Ok(((0..8).map(corner).collect(), triangles))
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
