//! Subdivision surfaces as OpenSubdiv has them: Catmull-Clark, Loop and bilinear cages with attributes of every
//! interpolation, evaluated at places with derivatives, and refined to meshes.
//!
//! The surfaces that hold detail are those of [`crate::Surface`]; these are evaluated by OpenSubdiv itself.

use std::collections::{HashMap, HashSet};
use std::ops::Range;
use std::sync::Arc;

use relievo_core::mesh::INFINITE_SHARPNESS;
use relievo_core::{Attribute, Context, Crease, Domain, Error, ErrorKind, Mesh, Parts, Result, Values};
use relievo_opensubdiv::subdivision::{self as native, Channel, Interpolation, Spot};
pub use relievo_opensubdiv::subdivision::{Boundary, FaceVarying, Rules, Scheme};

use crate::Place;
use crate::face_varying::share;

/// Places that one thread evaluates at a time.
const CHUNK: usize = 1024;

/// Bytes beside the cage that OpenSubdiv's topology takes for each corner, and for each corner of a refined mesh with its
/// attributes: upper estimates.
const CORNER_BYTES: u64 = 250;

/// How the values of points are interpolated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PointRule {
    /// As smoothly as the surface.
    Vertex,
    /// Bilinearly over tiles, linearly over triangles.
    Varying,
}

/// What is evaluated.
#[derive(Clone, Copy, Debug)]
pub enum Primvar<'a> {
    /// Points of the cage, given as x, y and z.
    Points(&'a [[f32; 3]]),
    /// An attribute of the cage: of points by the rule, of corners face-varying, of faces uniform.
    Attribute(&'a str, PointRule),
}

/// A cage under a scheme, with its attributes.
pub struct Subdivision {
    native: native::Subdivision,
    rules: Rules,
    mesh: Arc<Mesh>,
    /// The face-varying channels, and for each the attribute it is and its values.
    channels: Vec<Channel>,
    channel_values: Vec<(usize, Vec<f32>)>,
    /// First tile of every face, and at the end the number of tiles.
    tile_first: Vec<u32>,
}

impl std::fmt::Debug for Subdivision {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        out.debug_struct("Subdivision")
            .field("rules", &self.rules)
            .field("tiles", &self.tile_count())
            .finish_non_exhaustive()
    }
}

/// Places and where their results go, cut together.
struct Job<'a> {
    places: &'a [Place],
    out: &'a mut [f32],
    width: usize,
}

impl Parts for Job<'_> {
    fn len(&self) -> usize {
        self.places.len()
    }

    fn split_at(self, at: usize) -> (Self, Self) {
        let (places, rest) = self.places.split_at(at.min(self.places.len()));
        let (out, others) = self.out.split_at_mut(6 * self.width * places.len());
        (Self { places, out, width: self.width }, Self { places: rest, out: others, width: self.width })
    }
}

impl Subdivision {
    /// Prepares `mesh` for evaluation under `rules`. Its attributes of floats are its primvars.
    ///
    /// # Errors
    /// The mesh does not pass [`Mesh::check`], a face is no triangle under [`Scheme::Loop`], a face or point has more than
    /// 65,535 neighbours, or there is too little memory within the limit of the context.
    pub fn new(context: &Context, mesh: Arc<Mesh>, rules: &Rules) -> Result<Self> {
        mesh.check()?;
        let corner_attributes = mesh.attributes.iter().filter(|it| it.domain == Domain::Corner).count() as u64;
        check_memory(context, mesh.corners.len() as u64, 1 + corner_attributes)?;
        let (channels, channel_values) = channels(&mesh);
        let native = native::Subdivision::new(&mesh, rules, &channels)?;
        let mut tile_first = Vec::with_capacity(mesh.face_count() + 1);
        let mut tiles = 0_u32;
        for size in &mesh.face_sizes {
            tile_first.push(tiles);
            tiles += if rules.scheme == Scheme::Loop || *size == 4 { 1 } else { *size };
        }
        tile_first.push(tiles);
        Ok(Self { native, rules: *rules, mesh, channels, channel_values, tile_first })
    }

    /// Returns the rules it was made with.
    pub fn rules(&self) -> &Rules {
        &self.rules
    }

    /// Returns the cage.
    pub fn mesh(&self) -> &Arc<Mesh> {
        &self.mesh
    }

    /// Number of tiles: one for each triangle under Loop and for each quad, n for every other face.
    pub fn tile_count(&self) -> usize {
        self.tile_first[self.tile_first.len() - 1] as usize
    }

    /// Returns the tiles of a face, `None` if there is no such face.
    pub fn tiles(&self, face: u32) -> Option<Range<u32>> {
        let face = face as usize;
        (face + 1 < self.tile_first.len()).then(|| self.tile_first[face]..self.tile_first[face + 1])
    }

    /// Returns the face of a tile, and which of the face's tiles it is.
    fn face(&self, tile: u32) -> (u32, u32) {
        let face = self.tile_first.partition_point(|first| *first <= tile) - 1;
        (face as u32, tile - self.tile_first[face])
    }

    /// Checks that a place exists.
    ///
    /// # Errors
    /// There is no such tile, or u and v are outside of it.
    pub fn check_place(&self, place: Place) -> Result<()> {
        let Place { tile, u, v } = place;
        if tile as usize >= self.tile_count() {
            return Err(Error::invalid(format!("tile {tile} does not exist"))
                .advise(format!("there are {} tiles", self.tile_count())));
        }
        let inside = (0.0..=1.0).contains(&u) && (0.0..=1.0).contains(&v);
        if !inside || (self.rules.scheme == Scheme::Loop && u + v > 1.0 + f32::EPSILON) {
            return Err(Error::invalid(format!("({u}, {v}) is outside of tile {tile}"))
                .advise("u and v are from 0 to 1, and at most 1 together in the triangles of the Loop scheme"));
        }
        Ok(())
    }

    /// Returns the attribute called `name` and its index.
    fn attribute(&self, name: &str) -> Result<(usize, &Attribute)> {
        let found = self.mesh.attributes.iter().enumerate().find(|(_, attribute)| attribute.name == name);
        found.ok_or_else(|| {
            Error::new(ErrorKind::NotFound, format!("the cage has no attribute `{name}`")).at("attribute")
        })
    }

    /// Returns the face-varying channel of the attribute with that index, and its values.
    fn channel(&self, attribute: usize) -> Option<(u32, &[f32])> {
        let found = self.channel_values.iter().position(|(index, _)| *index == attribute)?;
        Some((found as u32, self.channel_values[found].1.as_slice()))
    }

    /// Returns how many numbers each value of `primvar` has.
    ///
    /// # Errors
    /// There is no such attribute, or it does not hold floats.
    pub fn width(&self, primvar: Primvar<'_>) -> Result<usize> {
        let Primvar::Attribute(name, _) = primvar else { return Ok(3) };
        let (_, attribute) = self.attribute(name)?;
        if !matches!(attribute.values, Values::F32(_)) {
            return Err(Error::unsupported("integers cannot be interpolated").at(format!("attribute `{name}`")));
        }
        Ok(attribute.width as usize)
    }

    /// Evaluates `primvar` at `places`: for each one its value, du, dv, duu, duv and dvv per unit of the tile's parameters,
    /// as many numbers each as [`Self::width`] says. `derivatives` is 0, 1 or 2; what is beyond it is 0, and so is
    /// everything where there is no surface.
    ///
    /// # Errors
    /// As [`Self::width`] and [`Self::check_place`], and if there are not as many points as the cage has.
    pub fn evaluate(
        &self,
        context: &Context,
        primvar: Primvar<'_>,
        places: &[Place],
        derivatives: u32,
        out: &mut Vec<f32>,
    ) -> Result<()> {
        let width = self.width(primvar)?;
        for (index, place) in places.iter().enumerate() {
            self.check_place(*place).map_err(|error| error.at(format!("place {index}")))?;
        }
        out.clear();
        out.resize(6 * width * places.len(), 0.0);
        let (interpolation, values) = match primvar {
            Primvar::Points(points) => (Interpolation::Vertex, points.as_flattened()),
            Primvar::Attribute(name, rule) => {
                let (index, attribute) = self.attribute(name)?;
                let Values::F32(values) = &attribute.values else {
                    return Err(Error::internal("the attribute was checked to hold floats"));
                };
                match (attribute.domain, rule) {
                    (Domain::Point, PointRule::Vertex) => (Interpolation::Vertex, values.as_slice()),
                    (Domain::Point, PointRule::Varying) => (Interpolation::Varying, values.as_slice()),
                    (Domain::Corner, _) => {
                        let found = self.channel(index);
                        let (channel, values) = found.ok_or_else(|| Error::internal("the attribute has no channel"))?;
                        (Interpolation::FaceVarying(channel), values)
                    }
                    (Domain::Face, _) => {
                        for (place, found) in places.iter().zip(out.chunks_exact_mut(6 * width)) {
                            let face = self.face(place.tile).0 as usize;
                            found[..width].copy_from_slice(&values[width * face..width * (face + 1)]);
                        }
                        return Ok(());
                    }
                }
            }
        };
        let job = Job { places, out, width };
        context.for_each_part(job, CHUNK, |_, Job { places, out, width }| {
            let spots: Vec<Spot> = places
                .iter()
                .map(|place| {
                    let (face, part) = self.face(place.tile);
                    Spot { face, part, u: place.u, v: place.v }
                })
                .collect();
            self.native.evaluate(interpolation, (values, width as u32), &spots, derivatives, out)
        })
    }

    /// Refines the cage `level` times, 1 to 10, and moves its points to the limit surface. Attributes of floats are
    /// subdivided with it, those of faces are handed on. Faces without a surface are left out.
    ///
    /// # Errors
    /// The level is out of its range, no face has a surface, there are not as many points as the cage has, or the mesh does
    /// not fit the memory limit of the context.
    pub fn refined(&self, context: &Context, points: &[[f32; 3]], level: u32) -> Result<Mesh> {
        let attributes = 1 + self.mesh.attributes.len() as u64;
        let corners = (self.mesh.corners.len() as u64).saturating_mul(4_u64.saturating_pow(level.min(11)));
        check_memory(context, corners, attributes)?;
        let native = native::Refined::new(&self.mesh, &self.rules, &self.channels, level)?;
        let triples = |values: Vec<f32>| values.as_chunks::<3>().0.to_vec();
        let points = triples(native.values(Interpolation::Vertex, points.as_flattened(), 3)?);
        let mut mesh = Mesh::new(points, native.face_sizes().to_vec(), native.corners().to_vec());
        for (index, attribute) in self.mesh.attributes.iter().enumerate() {
            let width = attribute.width as usize;
            let (values, indices) = match (&attribute.values, attribute.domain) {
                (Values::F32(values), Domain::Point) => {
                    (Values::F32(native.values(Interpolation::Vertex, values, attribute.width)?), None)
                }
                (Values::F32(_), Domain::Corner) => {
                    let Some((channel, values)) = self.channel(index) else { continue };
                    let refined = native.values(Interpolation::FaceVarying(channel), values, attribute.width)?;
                    (Values::F32(refined), Some(native.channel_corners(channel)?))
                }
                (Values::F32(values), Domain::Face) => (Values::F32(of_faces(values, width, native.parents())), None),
                (Values::U32(values), Domain::Face) => (Values::U32(of_faces(values, width, native.parents())), None),
                (Values::U32(_), _) => continue,
            };
            let (name, domain) = (attribute.name.clone(), attribute.domain);
            mesh.attributes.push(Attribute { name, domain, width: attribute.width, values, indices });
        }
        mesh.check().map_err(|error| error.at("refined cage"))?;
        Ok(mesh)
    }
}

/// The values of the faces that `parents` names.
fn of_faces<T: Copy>(values: &[T], width: usize, parents: &[u32]) -> Vec<T> {
    parents.iter().flat_map(|face| &values[width * *face as usize..width * (*face as usize + 1)]).copied().collect()
}

/// Checks that a topology of so many corners with so many arrays of values fits the memory limit.
fn check_memory(context: &Context, corners: u64, arrays: u64) -> Result<()> {
    let bytes = corners.saturating_mul(CORNER_BYTES + 32 * arrays);
    if bytes > context.memory_limit() {
        return Err(Error::memory(format!(
            "about {:.0} MB are needed, more than the memory limit",
            bytes as f64 / 1e6
        ))
        .at("subdivision")
        .advise("raise the memory limit, lower the level, or use a coarser cage"));
    }
    Ok(())
}

/// The attributes of floats on corners as channels, and for each its index and values: the same value at the same point is one
/// value.
fn channels(mesh: &Mesh) -> (Vec<Channel>, Vec<(usize, Vec<f32>)>) {
    let (mut channels, mut all) = (Vec::new(), Vec::new());
    for (index, attribute) in mesh.attributes.iter().enumerate() {
        let (Domain::Corner, Values::F32(numbers)) = (attribute.domain, &attribute.values) else { continue };
        let width = attribute.width as usize;
        let value =
            |at: usize| -> [f32; 4] { std::array::from_fn(|k| if k < width { numbers[width * at + k] } else { 0.0 }) };
        let (values, corners) = match &attribute.indices {
            Some(indices) => share(&mesh.corners, |corner| indices[corner], |corner| value(indices[corner] as usize)),
            None => share(&mesh.corners, |corner| value(corner).map(f32::to_bits), value),
        };
        let flat = values.iter().flat_map(|value| value[..width].iter().copied()).collect();
        channels.push(Channel { count: values.len(), corners });
        all.push((index, flat));
    }
    (channels, all)
}

/// Returns `mesh`, which must have passed [`Mesh::check`], with all its edges and points infinitely sharp: its
/// Catmull-Clark surface is the bilinear one.
///
/// # Errors
/// A face has another number of corners than four: the tiles of such a face would be smooth where they meet in its middle.
pub fn sharpened(mesh: &Mesh) -> Result<Mesh> {
    if let Some(face) = mesh.face_sizes.iter().position(|size| *size != 4) {
        return Err(Error::unsupported(format!(
            "a bilinear surface takes quads, not {} corners",
            mesh.face_sizes[face]
        ))
        .at(format!("face {face}"))
        .advise("refine the cage once under the bilinear scheme, which makes quads"));
    }
    let mut sharp = mesh.clone();
    let edges: HashSet<[u32; 2]> = sides(mesh).collect();
    sharp.creases = edges.into_iter().map(|points| Crease { points, sharpness: INFINITE_SHARPNESS }).collect();
    sharp.creases.sort_unstable_by_key(|crease| crease.points);
    sharp.sharp_points = (0..mesh.points.len() as u32).map(|point| (point, INFINITE_SHARPNESS)).collect();
    Ok(sharp)
}

/// Returns `mesh`, which must have passed [`Mesh::check`], with the faces at boundary points as holes: its surface is that
/// of the boundary rule `none`.
pub fn without_boundary(mesh: &Mesh) -> Mesh {
    let mut faces: HashMap<[u32; 2], u32> = HashMap::new();
    sides(mesh).for_each(|edge| *faces.entry(edge).or_default() += 1);
    let boundary: HashSet<u32> = faces.iter().filter(|(_, count)| **count == 1).flat_map(|(edge, _)| *edge).collect();
    let at_boundary = |face: &[u32]| face.iter().any(|point| boundary.contains(point));
    let found = (0..).zip(mesh.faces()).filter(|(_, face)| at_boundary(face)).map(|(face, _)| face);
    let mut inner = mesh.clone();
    inner.holes = found.chain(mesh.holes.iter().copied()).collect();
    inner.holes.sort_unstable();
    inner.holes.dedup();
    inner
}

/// The points of the sides of all faces, the lower first.
fn sides(mesh: &Mesh) -> impl Iterator<Item = [u32; 2]> {
    mesh.faces().flat_map(|face| face.iter().zip(face.iter().cycle().skip(1)).map(|(a, b)| [*a.min(b), *a.max(b)]))
}
