//! The connectivity under repair: faces as corners that remember where they come from.

use glam::DVec3;
use relievo_core::{Error, Mesh, Result};

use crate::report::{Element, Finding};

/// Faces under repair. A half-edge has the number of the corner at which it begins.
///
/// Points of the input keep their numbers until the end; copies and points of fillings follow after them. The origin of
/// a corner is a corner of the input or, from `input_corners` on, a blend; likewise for points from `input_points` on.
pub struct Corners {
    /// First corner of every face, and at the end the number of corners.
    pub starts: Vec<u32>,
    /// Point of every corner.
    pub points: Vec<u32>,
    /// Origin of every corner.
    pub origins: Vec<u32>,
    /// Face of the input whose attributes each face has.
    pub face_origins: Vec<u32>,
    /// Position of every point.
    pub places: Vec<[f32; 3]>,
    /// Origin of every point.
    pub place_origins: Vec<u32>,
    /// Three corner origins of which a new point takes the mean.
    pub blends: Vec<[u32; 3]>,
    /// Number of corners of the input.
    pub input_corners: u32,
    /// Number of points of the input.
    pub input_points: u32,
    /// The first face of fillings.
    pub first_filling: u32,
    /// Face of every corner; empty where all faces are triangles.
    face_of: Vec<u32>,
}

impl Corners {
    /// Takes the faces of a mesh, without faces that use points that do not exist or are not finite, which are added to
    /// `invalid`.
    ///
    /// # Errors
    /// Face sizes do not add up, or there are 2³¹ points or corners.
    pub fn of(mesh: &Mesh, invalid: &mut Finding, listed: u32) -> Result<Self> {
        let total: u64 = mesh.face_sizes.iter().map(|size| u64::from(*size)).sum();
        if total != mesh.corners.len() as u64 {
            return Err(Error::invalid(format!(
                "face sizes add up to {total}, but there are {} corners",
                mesh.corners.len()
            ))
            .advise("give as many corners as the face sizes say"));
        }
        if i32::try_from(mesh.points.len()).is_err() || i32::try_from(mesh.corners.len()).is_err() {
            return Err(Error::unsupported("the mesh has 2^31 or more points or corners").advise("split it"));
        }
        let is_finite: Vec<bool> =
            mesh.points.iter().map(|point| point.iter().all(|value| value.is_finite())).collect();
        let is_usable = |point: &u32| is_finite.get(*point as usize).copied().unwrap_or(false);
        let mut made = Self {
            starts: mesh.face_offsets(),
            points: mesh.corners.clone(),
            origins: (0..mesh.corners.len() as u32).collect(),
            face_origins: (0..mesh.face_count() as u32).collect(),
            places: mesh.points.clone(),
            place_origins: (0..mesh.points.len() as u32).collect(),
            blends: Vec::new(),
            input_corners: mesh.corners.len() as u32,
            input_points: mesh.points.len() as u32,
            first_filling: u32::MAX,
            face_of: Vec::new(),
        };
        if !mesh.corners.iter().all(is_usable) {
            let keep: Vec<bool> = mesh.faces().map(|face| face.iter().all(is_usable)).collect();
            *invalid =
                Finding::of((0..).zip(&keep).filter(|(_, keep)| !**keep).map(|(it, _)| Element::Face(it)), listed);
            made.retain(&keep);
        }
        made.number_faces();
        Ok(made)
    }

    /// The number of faces.
    pub fn face_count(&self) -> usize {
        self.face_origins.len()
    }

    /// The face of a corner.
    pub fn face(&self, corner: u32) -> u32 {
        if self.face_of.is_empty() { corner / 3 } else { self.face_of[corner as usize] }
    }

    /// The corners of a face.
    pub fn range(&self, face: u32) -> std::ops::Range<usize> {
        self.starts[face as usize] as usize..self.starts[face as usize + 1] as usize
    }

    /// The points of a face.
    pub fn face_points(&self, face: u32) -> &[u32] {
        &self.points[self.range(face)]
    }

    /// The corner after one in its face.
    pub fn next(&self, corner: u32) -> u32 {
        let face = self.face(corner) as usize;
        if corner + 1 == self.starts[face + 1] { self.starts[face] } else { corner + 1 }
    }

    /// The corner before one in its face.
    pub fn previous(&self, corner: u32) -> u32 {
        let face = self.face(corner) as usize;
        if corner == self.starts[face] { self.starts[face + 1] - 1 } else { corner - 1 }
    }

    /// The point at which a half-edge begins.
    pub fn from(&self, half: u32) -> u32 {
        self.points[half as usize]
    }

    /// The point at which a half-edge ends.
    pub fn to(&self, half: u32) -> u32 {
        self.points[self.next(half) as usize]
    }

    /// The position of a point.
    pub fn place(&self, point: u32) -> DVec3 {
        DVec3::from_array(self.places[point as usize].map(f64::from))
    }

    /// Twice the area of a face times its unit normal (Newell).
    pub fn area_vector(&self, face: u32) -> DVec3 {
        let points = self.face_points(face);
        let first = points.first().map_or(DVec3::ZERO, |point| self.place(*point));
        points
            .windows(2)
            .skip(1)
            .fold(DVec3::ZERO, |sum, pair| sum + (self.place(pair[0]) - first).cross(self.place(pair[1]) - first))
    }

    /// The point of the input that a point is or was copied from; for points of fillings `None`.
    pub fn input_point(&self, point: u32) -> Option<u32> {
        let origin = self.place_origins[point as usize];
        (origin < self.input_points).then_some(origin)
    }

    /// An edge in numbers of the input.
    pub fn edge(&self, half: u32) -> Element {
        let [from, to] = [self.from(half), self.to(half)].map(|point| self.place_origins[point as usize]);
        Element::Edge([from.min(to), from.max(to)])
    }

    /// A face in numbers of the input.
    pub fn named(&self, face: u32) -> Element {
        Element::Face(self.face_origins[face as usize])
    }

    /// Makes a copy of a point and returns its number.
    pub fn copy_point(&mut self, point: u32) -> u32 {
        self.places.push(self.places[point as usize]);
        self.place_origins.push(self.place_origins[point as usize]);
        self.places.len() as u32 - 1
    }

    /// Drops the faces that are not to be kept.
    pub fn retain(&mut self, keep: &[bool]) {
        let (mut corner, mut face, mut start) = (0, 0, 0);
        for (old, keep) in keep.iter().enumerate() {
            // The start of this face may be overwritten by now.
            let range = start..self.starts[old + 1] as usize;
            start = range.end;
            if *keep {
                self.points.copy_within(range.clone(), corner);
                self.origins.copy_within(range.clone(), corner);
                self.face_origins[face] = self.face_origins[old];
                corner += range.len();
                face += 1;
                self.starts[face] = corner as u32;
            }
        }
        self.points.truncate(corner);
        self.origins.truncate(corner);
        self.face_origins.truncate(face);
        self.starts.truncate(face + 1);
        self.number_faces();
    }

    /// Replaces faces: `make` is given the corners of each face, and returns the corners of the faces that replace it,
    /// or `None` where the face stays.
    pub fn replace(&mut self, make: impl Fn(&[u32]) -> Option<Vec<Vec<u32>>>) {
        let (mut points, mut origins) = (Vec::with_capacity(self.points.len()), Vec::with_capacity(self.points.len()));
        let (mut starts, mut face_origins) = (Vec::with_capacity(self.starts.len()), Vec::new());
        starts.push(0);
        for face in 0..self.face_count() as u32 {
            let range = self.range(face);
            let start = range.start;
            let mut add = |corners: &mut dyn Iterator<Item = usize>| {
                for corner in corners {
                    points.push(self.points[corner]);
                    origins.push(self.origins[corner]);
                }
                starts.push(points.len() as u32);
                face_origins.push(self.face_origins[face as usize]);
            };
            match make(&self.points[range.clone()]) {
                None => add(&mut range.into_iter()),
                Some(faces) => faces.iter().for_each(|face| add(&mut face.iter().map(|it| start + *it as usize))),
            }
        }
        (self.points, self.origins) = (points, origins);
        (self.starts, self.face_origins) = (starts, face_origins);
        self.number_faces();
    }

    /// Adds a triangle.
    pub fn add_triangle(&mut self, points: [u32; 3], origins: [u32; 3], face_origin: u32) {
        self.points.extend(points);
        self.origins.extend(origins);
        if !self.face_of.is_empty() {
            self.face_of.extend([self.face_origins.len() as u32; 3]);
        }
        self.starts.push(self.points.len() as u32);
        self.face_origins.push(face_origin);
    }

    fn number_faces(&mut self) {
        self.face_of.clear();
        if self.starts.windows(2).any(|face| face[1] - face[0] != 3) {
            self.face_of.reserve(self.points.len());
            for (face, range) in (0..).zip(self.starts.windows(2)) {
                self.face_of.resize(range[1] as usize, face);
            }
        }
    }
}
