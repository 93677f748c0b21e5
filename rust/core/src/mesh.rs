//! Polygon meshes with points, corners, faces, named attributes on them, and subdivision tags.

use std::collections::HashMap;

use crate::{Error, Result};

/// Where an attribute's values sit.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Domain {
    /// One value per point.
    Point,
    /// One value per face corner.
    Corner,
    /// One value per face.
    Face,
}

/// The numbers of an attribute, `width` per element.
#[derive(Clone, Debug, PartialEq)]
pub enum Values {
    /// Floats.
    F32(Vec<f32>),
    /// Unsigned integers: material slots, joints, groups.
    U32(Vec<u32>),
}

impl Values {
    /// How many numbers there are.
    pub fn len(&self) -> usize {
        match self {
            Values::F32(values) => values.len(),
            Values::U32(values) => values.len(),
        }
    }

    /// Whether it has no number.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// A named attribute of 1 to 4 numbers per element.
#[derive(Clone, Debug, PartialEq)]
pub struct Attribute {
    /// Name: `uv`, `normal`, `color`, `velocity`, `joints`, `weights`, `material`, or the user's own.
    pub name: String,
    /// What it sits on.
    pub domain: Domain,
    /// Numbers per value, 1 to 4.
    pub width: u32,
    /// The numbers. With `indices` they are a list of values that corners refer to.
    pub values: Values,
    /// For corner attributes whose values are shared (face-varying topology): the value of each corner.
    pub indices: Option<Vec<u32>>,
}

/// The sharpness of an edge between two points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Crease {
    /// The two points of the edge.
    pub points: [u32; 2],
    /// Sharpness as OpenSubdiv counts: 0 is smooth, 10 and more infinitely sharp.
    pub sharpness: f32,
}

/// A polygon mesh.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// Positions.
    pub points: Vec<[f32; 3]>,
    /// Number of corners of every face.
    pub face_sizes: Vec<u32>,
    /// Point of every corner, face after face.
    pub corners: Vec<u32>,
    /// Attributes; names are unique.
    pub attributes: Vec<Attribute>,
    /// Sharp edges.
    pub creases: Vec<Crease>,
    /// Sharp points and their sharpness.
    pub sharp_points: Vec<(u32, f32)>,
    /// Faces that are holes: they shape their neighbours and have no surface.
    pub holes: Vec<u32>,
}

/// The sharpness at and above which an edge or point is infinitely sharp.
pub const INFINITE_SHARPNESS: f32 = 10.0;

impl Mesh {
    /// A mesh of points and faces without attributes.
    pub fn new(points: Vec<[f32; 3]>, face_sizes: Vec<u32>, corners: Vec<u32>) -> Self {
        Self { points, face_sizes, corners, ..Self::default() }
    }

    /// A triangle mesh, three corners per face.
    pub fn from_triangles(points: Vec<[f32; 3]>, triangles: &[[u32; 3]]) -> Self {
        Self::new(points, vec![3; triangles.len()], triangles.as_flattened().to_vec())
    }

    /// Number of faces.
    pub fn face_count(&self) -> usize {
        self.face_sizes.len()
    }

    /// The first corner of every face, and at the end the number of corners.
    pub fn face_offsets(&self) -> Vec<u32> {
        let mut offsets = Vec::with_capacity(self.face_sizes.len() + 1);
        let mut sum = 0;
        offsets.push(0);
        for size in &self.face_sizes {
            sum += size;
            offsets.push(sum);
        }
        offsets
    }

    /// The points of every face.
    pub fn faces(&self) -> impl Iterator<Item = &[u32]> {
        let mut rest = self.corners.as_slice();
        self.face_sizes.iter().map(move |size| {
            let (face, tail) = rest.split_at(*size as usize);
            rest = tail;
            face
        })
    }

    /// The faces as triangles, fanned from the first corner of each; holes are left out.
    pub fn triangles(&self) -> Vec<[u32; 3]> {
        let mut hole = vec![false; self.face_count()];
        for face in &self.holes {
            hole[*face as usize] = true;
        }
        let mut triangles = Vec::with_capacity(self.corners.len());
        for (face, _) in self.faces().zip(hole).filter(|(_, hole)| !hole) {
            triangles.extend((2..face.len()).map(|last| [face[0], face[last - 1], face[last]]));
        }
        triangles
    }

    /// The attribute called `name`.
    pub fn attribute(&self, name: &str) -> Option<&Attribute> {
        self.attributes.iter().find(|attribute| attribute.name == name)
    }

    /// Smallest and largest coordinates, `None` for a mesh without points.
    pub fn bounds(&self) -> Option<([f32; 3], [f32; 3])> {
        let first = *self.points.first()?;
        Some(self.points.iter().fold((first, first), |(low, high), point| {
            (
                std::array::from_fn(|axis| low[axis].min(point[axis])),
                std::array::from_fn(|axis| high[axis].max(point[axis])),
            )
        }))
    }

    /// Checks that the mesh can be used: it has faces of at least three corners, every index exists, no face repeats a
    /// point, every number is finite, attributes have as many values as their domain, and tags refer to what exists.
    ///
    /// # Errors
    /// Fails with `Invalid`, and names the element, if one of these does not hold, if the mesh is empty or has 2³² or
    /// more points or corners, or if two attributes share a name.
    pub fn check(&self) -> Result<()> {
        if self.points.is_empty() || self.face_sizes.is_empty() {
            return Err(Error::invalid("the mesh is empty").advise("give it at least three points and one face"));
        }
        if u32::try_from(self.points.len()).is_err() || u32::try_from(self.corners.len()).is_err() {
            return Err(Error::invalid("the mesh has 2^32 or more points or corners").advise("split it"));
        }
        if let Some(index) = self.points.iter().position(|point| !point.iter().all(|value| value.is_finite())) {
            return Err(Error::invalid("a coordinate is not a finite number")
                .at(format!("point {index}"))
                .advise("remove the point or repair its position"));
        }
        let total: u64 = self.face_sizes.iter().map(|size| u64::from(*size)).sum();
        if total != self.corners.len() as u64 {
            return Err(Error::invalid(format!(
                "face sizes add up to {total}, but there are {} corners",
                self.corners.len()
            ))
            .advise("give as many corners as the face sizes say"));
        }
        let mut seen = HashMap::new();
        for (index, face) in self.faces().enumerate() {
            let place = || format!("face {index}");
            if face.len() < 3 {
                return Err(Error::invalid(format!("it has {} corners", face.len()))
                    .at(place())
                    .advise("a face needs at least three"));
            }
            for (corner, point) in face.iter().enumerate() {
                if *point as usize >= self.points.len() {
                    return Err(Error::invalid(format!("point {point} does not exist"))
                        .at(format!("face {index}, corner {corner}"))
                        .advise(format!("use indices from 0 to {}", self.points.len() - 1)));
                }
            }
            let repeated = if face.len() <= 8 {
                (1..face.len()).find(|last| face[..*last].contains(&face[*last]))
            } else {
                seen.clear();
                (0..face.len()).find(|last| seen.insert(face[*last], ()).is_some())
            };
            if let Some(corner) = repeated {
                return Err(Error::invalid(format!("point {} is repeated", face[corner]))
                    .at(place())
                    .advise("remove the repeated corner"));
            }
        }
        self.check_attributes()?;
        self.check_tags()
    }

    fn check_attributes(&self) -> Result<()> {
        for (index, attribute) in self.attributes.iter().enumerate() {
            let place = || format!("attribute `{}`", attribute.name);
            if self.attributes[..index].iter().any(|other| other.name == attribute.name) {
                return Err(Error::invalid("the name is used twice").at(place()).advise("rename one of them"));
            }
            if !(1..=4).contains(&attribute.width) {
                return Err(Error::invalid(format!("its width is {}", attribute.width))
                    .at(place())
                    .advise("use 1 to 4 numbers per value"));
            }
            let width = attribute.width as usize;
            let elements = match attribute.domain {
                Domain::Point => self.points.len(),
                Domain::Corner => self.corners.len(),
                Domain::Face => self.face_sizes.len(),
            };
            let values = attribute.values.len() / width;
            if attribute.values.len() % width != 0 || (attribute.indices.is_none() && values != elements) {
                return Err(Error::invalid(format!(
                    "it has {} numbers for {elements} elements of width {width}",
                    attribute.values.len()
                ))
                .at(place())
                .advise("give width times elements numbers"));
            }
            if let Some(indices) = &attribute.indices {
                if attribute.domain != Domain::Corner || indices.len() != self.corners.len() {
                    return Err(
                        Error::invalid("only corner attributes may be indexed, one index per corner").at(place())
                    );
                }
                if let Some(corner) = indices.iter().position(|value| *value as usize >= values) {
                    return Err(Error::invalid(format!("value {} does not exist", indices[corner]))
                        .at(format!("{}, corner {corner}", place())));
                }
            }
            if let Values::F32(numbers) = &attribute.values
                && let Some(at) = numbers.iter().position(|value| !value.is_finite())
            {
                return Err(Error::invalid("a number is not finite").at(format!("{}, value {}", place(), at / width)));
            }
        }
        Ok(())
    }

    fn check_tags(&self) -> Result<()> {
        let count = self.points.len();
        for (index, crease) in self.creases.iter().enumerate() {
            let [a, b] = crease.points;
            if a as usize >= count || b as usize >= count || a == b {
                return Err(Error::invalid(format!("there is no edge between points {a} and {b}"))
                    .at(format!("crease {index}")));
            }
            if !(crease.sharpness >= 0.0 && crease.sharpness.is_finite()) {
                return Err(Error::invalid(format!("its sharpness is {}", crease.sharpness))
                    .at(format!("crease {index}"))
                    .advise("use 0 or more; 10 and more is infinitely sharp"));
            }
        }
        for (index, (point, sharpness)) in self.sharp_points.iter().enumerate() {
            if *point as usize >= count || !(*sharpness >= 0.0 && sharpness.is_finite()) {
                return Err(Error::invalid(format!("point {point} with sharpness {sharpness} cannot be used"))
                    .at(format!("sharp point {index}"))
                    .advise("use an existing point and a sharpness of 0 or more; 10 and more is infinitely sharp"));
            }
        }
        if let Some(face) = self.holes.iter().find(|face| **face as usize >= self.face_count()) {
            return Err(Error::invalid(format!("face {face} does not exist")).at("holes"));
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn quad() -> Mesh {
        Mesh::new(vec![[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]], vec![4], vec![0, 1, 2, 3])
    }

    #[test]
    fn a_quad_is_valid_and_makes_two_triangles() {
        assert_eq!(quad().check(), Ok(()));
        assert_eq!(quad().triangles(), [[0, 1, 2], [0, 2, 3]]);
        assert_eq!(quad().bounds(), Some(([0.0; 3], [1.0, 1.0, 0.0])));
    }

    #[test]
    fn every_kind_of_bad_mesh_is_refused_with_its_place() {
        type Change = fn(&mut Mesh);
        let cases: [(Change, &str); 9] = [
            (|mesh| mesh.points.clear(), "empty"),
            (|mesh| mesh.points[2][1] = f32::NAN, "point 2"),
            (|mesh| mesh.corners[3] = 4, "face 0, corner 3"),
            (|mesh| mesh.corners[3] = 0, "repeated"),
            (|mesh| mesh.face_sizes[0] = 5, "add up to 5"),
            (|mesh| mesh.creases.push(Crease { points: [0, 9], sharpness: 1.0 }), "crease 0"),
            (|mesh| mesh.sharp_points.push((0, f32::NAN)), "sharp point 0"),
            (|mesh| mesh.holes.push(1), "holes"),
            (
                |mesh| {
                    let values = Values::F32(vec![0.0; 3]);
                    mesh.attributes.push(Attribute {
                        name: "uv".into(),
                        domain: Domain::Point,
                        width: 2,
                        values,
                        indices: None,
                    });
                },
                "attribute `uv`",
            ),
        ];
        for (spoil, expected) in cases {
            let mut mesh = quad();
            spoil(&mut mesh);
            let message = mesh.check().unwrap_err().to_string();
            assert!(message.contains(expected), "{message} should contain {expected}");
        }
    }
}
