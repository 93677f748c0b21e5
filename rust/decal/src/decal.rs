//! Decals: stickers laid on a surface.

use std::collections::HashSet;
use std::sync::Arc;

use relievo_core::{Attribute, Domain, Error, ErrorKind, Mesh, Progress, Result, Values};

use crate::artwork::outline::Outline;
use crate::map::energy::{Vec2, distance};
use crate::map::graph::Graph;
use crate::map::grow::{FOLDED, Fault, Grown, Growth, Limits, UNREACHED};
use crate::map::patch::Patch;
use crate::map::quality::{Quality, measure};
use crate::map::region::{is_covered, once};
use crate::map::relax::Stop;
use crate::map::seed::{Seed, at_pin, between_pins, single};
use crate::pins::{Pin, name};
use crate::placement::Placement;
use crate::surface::{Surface, Vec3, cross, dot, length, minus};

/// The part of an image that is laid on a surface.
#[derive(Clone, Debug)]
pub struct Sticker {
    pub(crate) size: [f64; 2],
    pub(crate) outline: Outline,
}

/// Size and direction of a sticker with one pin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// The width of the whole image on the surface, in units of the mesh.
    pub width: f64,
    /// The direction in space that the image's upward direction follows at the pin.
    pub up: [f64; 3],
}

/// How a decal is made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DecalSettings {
    /// Newton steps of the last relaxation, 1 to 1000.
    pub steps: u32,
    /// The expected decrease of the distortion, as a share of it, that is not worth another step.
    pub decrease: f64,
    /// The most triangles of the patch.
    pub triangles: u32,
    /// Whether the sticker may lie on a part of the surface more than once, as around a finger.
    pub overlap: bool,
}

impl Default for DecalSettings {
    fn default() -> Self {
        Self { steps: 30, decrease: 1e-4, triangles: 4_000_000, overlap: false }
    }
}

impl DecalSettings {
    pub(crate) fn limits(&self) -> Limits {
        Limits { faces: self.triangles as usize, can_overlap: self.overlap }
    }

    pub(crate) fn stop(&self) -> Stop {
        let (steps, decrease) = (self.steps as usize, self.decrease);
        Stop { steps, decrease, enough: 0.0, pulling: 1e-5, lowering: 1e-5, is_trial: false }
    }
}

/// A sticker on a surface: triangles with their places in the image.
#[derive(Clone, Debug)]
pub struct Decal {
    /// Positions in space.
    pub points: Vec<Vec3>,
    /// Unit normals of the surface.
    pub normals: Vec<Vec3>,
    /// Places in the image: 0 to 1 from left to right and from bottom to top.
    pub uv: Vec<Vec2>,
    /// Triangles of these.
    pub triangles: Vec<[u32; 3]>,
    /// The face of the mesh that each triangle lies on.
    pub faces: Vec<u32>,
    /// The vertex of each pin.
    pub pins: Vec<u32>,
    /// Widths of the image for a unit of the mesh, on the whole.
    pub scale: f64,
    /// The distortion.
    pub quality: Quality,
}

impl Sticker {
    /// Makes a sticker of an image of `size` pixels and an outline in pixels from its lower left corner.
    ///
    /// # Errors
    /// The image has no pixels or more than 32,768 in a direction, or the outline is unusable ([`Outline::new`]).
    pub fn new(size: [u32; 2], outline: Vec<Vec2>) -> Result<Self> {
        if size.iter().any(|side| !(1..=32_768).contains(side)) {
            return Err(Error::invalid(format!("it has {} x {} pixels", size[0], size[1]))
                .at("image")
                .advise("use an image of 1 to 32,768 pixels in each direction"));
        }
        let width = f64::from(size[0]);
        let outline = outline.into_iter().map(|corner| corner.map(|value| value / width)).collect();
        Ok(Self { size: size.map(f64::from), outline: Outline::new(outline)? })
    }

    /// Makes a sticker of a whole image.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn whole(size: [u32; 2]) -> Result<Self> {
        let [width, height] = size.map(f64::from);
        Self::new(size, vec![[0.0, 0.0], [width, 0.0], [width, height], [0.0, height]])
    }

    /// Fails unless a point of the image is finite and within the outline.
    pub(crate) fn check(&self, image: &Vec2) -> Result<()> {
        if !image.iter().all(|value| value.is_finite()) {
            return Err(Error::invalid("its point of the image is not finite").advise("give two numbers"));
        }
        if !self.outline.contains(self.place(*image)) {
            return Err(Error::invalid("its point of the image lies outside of the outline")
                .advise("move the point into the outline"));
        }
        Ok(())
    }

    /// Returns the corners of the outline, counter-clockwise, in pixels from the lower left corner of the image.
    pub fn corners(&self) -> Vec<Vec2> {
        self.outline.corners().iter().map(|corner| corner.map(|value| value * self.size[0])).collect()
    }

    /// Returns the middle of the outline's bounds, in the plane.
    pub(crate) fn middle(&self) -> Vec2 {
        let (low, high) = self.outline.bounds();
        [0, 1].map(|axis| 0.5 * (low[axis] + high[axis]))
    }

    /// Returns whether a place of the image, 0 to 1 from left to right and from bottom to top, lies within the outline.
    pub fn covers(&self, [u, v]: Vec2) -> bool {
        self.outline.contains([u, v * self.size[1] / self.size[0]])
    }

    /// Returns the columns and rows of the image.
    pub fn pixels(&self) -> [u32; 2] {
        self.size.map(|side| side as u32)
    }

    /// Returns the place of a point of the image in the plane, where the image is one unit wide.
    pub(crate) fn place(&self, image: Vec2) -> Vec2 {
        image.map(|value| value / self.size[0])
    }
}

/// Lays a sticker on a triangle mesh so that each pin's point of the image lies exactly on its place.
///
/// A single pin needs a pose; with more pins it is not used.
///
/// # Errors
/// The mesh, a pin or the pose is unusable; pins lie on different components; paths between pins cross; the sticker folds
/// at a pin; the patch grows beyond its limit; or the caller cancels. The error names the pins and says what to do.
pub fn lay(
    mesh: &Mesh,
    sticker: &Sticker,
    pins: &[Pin],
    pose: Option<Pose>,
    settings: &DecalSettings,
    progress: &mut dyn Progress,
) -> Result<Decal> {
    Ok(Placement::new(mesh, sticker, pins, pose, settings, progress)?.decal())
}

/// The faces of a patch while it grows.
#[derive(Debug)]
pub struct Growing<'a> {
    /// The number of vertices.
    pub vertices: usize,
    /// Vertices of the triangles.
    pub triangles: &'a [[u32; 3]],
    /// The vertices of the boundary, counter-clockwise, as the growth has them.
    pub boundary: &'a [u32],
}

/// Lays a sticker as [`lay`] does, and calls `watch` after each change of the faces of the patch: at the start, and after
/// each round of growth, each round that is undone, each removal of faces and each merge of a seam. It is for checks of the
/// connectivity, which would take longer than the growth.
///
/// # Errors
/// As [`lay`].
pub fn lay_watched(
    mesh: &Mesh,
    sticker: &Sticker,
    pins: &[Pin],
    pose: Option<Pose>,
    settings: &DecalSettings,
    watch: &dyn Fn(&Growing<'_>),
    progress: &mut dyn Progress,
) -> Result<Decal> {
    let watch = |patch: &Patch| {
        watch(&Growing { vertices: patch.vertices.len(), triangles: &patch.faces, boundary: &patch.boundary() });
    };
    Ok(Placement::watched(mesh, sticker, pins, pose, settings, &watch, progress)?.decal())
}

/// The share of a sticker to be shown once, below which a patch is made in another way too.
const ENOUGH: f64 = 0.995;
/// Other sets of pins that are tried where a sticker cannot be laid, to propose a place.
const PROPOSALS: usize = 3;

/// A sticker to be laid.
pub(crate) struct Laying<'a> {
    /// The surface, with a vertex at each pin.
    pub surface: &'a Arc<Surface>,
    pub sticker: &'a Sticker,
    /// The vertices of the pins.
    pub vertices: Vec<u32>,
    /// Their places in the plane.
    pub places: Vec<Vec2>,
    pub pose: Option<Pose>,
    pub settings: &'a DecalSettings,
    /// As [`Growth::watch`].
    pub watch: &'a dyn Fn(&Patch),
}

impl Laying<'_> {
    /// Makes the patch under the sticker.
    pub fn attempt(&self, progress: &mut dyn Progress) -> Grown<Seed> {
        let Self { surface, sticker, vertices, places, pose, settings, watch } = self;
        let outline = &sticker.outline;
        let graph = Graph::new(places, outline)?;
        progress.step(0.0, "joining the pins")?;
        let (limits, stop) = (settings.limits(), settings.stop());
        let mut grow = |mut seed: Seed, heading: Option<(u32, Vec2)>, is_free: bool| -> Grown<Seed> {
            watch(&seed.patch);
            let (towards, factor) = (HashSet::new(), Vec::new());
            Growth { seed: &mut seed, vertices, places, outline, heading, is_free, towards, limits, factor, watch }
                .run(stop, progress)?;
            Ok(seed)
        };
        if places.len() == 1 {
            let pose = pose.ok_or_else(|| {
                Error::invalid("one pin gives no size and direction").at("decal").advise("give a pose, or a second pin")
            })?;
            let (seed, heading) = posed(Arc::clone(surface), vertices[0], places[0], pose)?;
            return grow(seed, heading, false);
        }
        let seed = || at_pin(surface, vertices, places, &graph);
        let free = match (grow(seed()?, None, true), graph.triangles.is_empty()) {
            // Pins on a line enclose nothing: the patch follows them as it grows.
            (Err(Fault::Folded(_) | Fault::Unreached(_)), true) => return grow(seed()?, None, false),
            (free, true) => return free,
            (free, false) => free,
        };
        let pin = match &free {
            Ok(seed) if is_enough(seed, outline) => return free,
            Ok(_) => None,
            Err(Fault::Folded(pin) | Fault::Unreached(pin)) => Some(*pin),
            Err(_) => return free,
        };
        // Paths between the pins say better than a free map where the sticker runs, but cost more.
        let bound = match between_pins(surface, vertices, places, &graph) {
            Ok(seed) => grow(seed, None, false),
            Err(error) if error.kind == ErrorKind::Invalid => Err(Fault::Crossed(pin.unwrap_or_default(), error)),
            Err(error) => Err(error.into()),
        };
        match (free, bound) {
            (Ok(free), Ok(bound)) if once(&bound, outline) > once(&free, outline) => Ok(bound),
            (Ok(_), Err(Fault::Other(error))) => Err(error.into()),
            (Ok(free), _) => Ok(free),
            (Err(_), bound) => bound,
        }
    }

    /// Turns a fault into an error that says where the pin could lie: on its point of the image where the sticker lies
    /// without it.
    pub fn explain(&self, fault: Fault, progress: &mut dyn Progress) -> Error {
        let (pin, what, crossing) = match fault {
            Fault::Other(error) => return error,
            Fault::Folded(pin) => (pin, FOLDED, None),
            Fault::Crossed(pin, error) => (pin, FOLDED, Some(error)),
            Fault::Unreached(pin) => (pin, UNREACHED, None),
        };
        let refuse = |pin: usize| Error::invalid(what).at(name(pin));
        let far = |other: &usize| distance(self.places[*other], self.places[pin]);
        let mut others: Vec<usize> = (0..self.places.len()).collect();
        others.sort_by(|a, b| far(a).total_cmp(&far(b)));
        for candidate in others.into_iter().take(PROPOSALS).filter(|_| self.places.len() > 2) {
            let mut rest = Laying { vertices: self.vertices.clone(), places: self.places.clone(), ..*self };
            rest.vertices.remove(candidate);
            let place = rest.places.remove(candidate);
            match rest.attempt(progress) {
                Ok(seed) => {
                    if let Some([x, y, z]) = seed.point_at(place) {
                        return refuse(candidate).advise(format!(
                            "move its place to ({x:.6}, {y:.6}, {z:.6}), where the sticker lies without it, or remove it"
                        ));
                    }
                }
                Err(Fault::Other(error)) if error.kind == ErrorKind::Cancelled => return error,
                Err(_) => {}
            }
        }
        crossing.unwrap_or_else(|| {
            refuse(pin).advise("move it towards the other pins as they are arranged in the image, or remove it")
        })
    }
}

/// Returns whether a patch covers a sticker as far as the surface goes.
fn is_enough(seed: &Seed, outline: &Outline) -> bool {
    is_covered(seed, outline) || once(seed, outline) >= ENOUGH
}

pub(crate) fn check(pins: &[Pin], settings: &DecalSettings) -> Result<()> {
    if pins.is_empty() {
        return Err(Error::invalid("there are no pins").at("decal").advise("give at least one"));
    }
    for (index, pin) in pins.iter().enumerate() {
        if !pin.image.iter().all(|value| value.is_finite()) {
            return Err(Error::invalid("its point of the image is not finite")
                .at(name(index))
                .advise("give two numbers"));
        }
    }
    let is_usable = (1..=1000).contains(&settings.steps) && settings.decrease >= 0.0 && settings.triangles > 0;
    if !is_usable {
        return Err(Error::invalid("a setting is out of range")
            .at("decal")
            .advise("use 1 to 1000 steps, a decrease of 0 or more, and at least one triangle"));
    }
    Ok(())
}

/// Directions at a vertex: the normal, and the image's upward and right directions in the tangent plane.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Frame {
    pub normal: Vec3,
    pub up: Vec3,
    pub right: Vec3,
}

impl Frame {
    /// Returns the frame of a pose at a vertex.
    pub fn new(surface: &Surface, vertex: u32, pose: Pose) -> Result<Self> {
        let refuse = |what: &str, remedy: &str| Err(Error::invalid(what).at("pose").advise(remedy));
        if !(pose.width > 0.0 && pose.width.is_finite()) {
            return refuse("the width is not a positive number", "give the width in units of the mesh");
        }
        let normal = Self::normal(surface, vertex);
        let height = dot(pose.up, normal);
        let up: Vec3 = std::array::from_fn(|axis| pose.up[axis] - height * normal[axis]);
        let norm = length(up);
        if !(norm.is_finite() && norm > 1e-9 * length(pose.up)) {
            return refuse("the upward direction is not finite or points along the normal", "give another direction");
        }
        let up: Vec3 = up.map(|value| value / norm);
        Ok(Self { normal, up, right: cross(up, normal) })
    }

    /// Returns the frame of a normal whose upward direction follows `up`, turned about the normal by an angle. A normal along
    /// `up` has the upward direction of another axis.
    pub fn turned(normal: Vec3, up: Vec3, angle: f64) -> Option<Self> {
        let across = [up, [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]].into_iter().find_map(|up| {
            let right = cross(up, normal);
            let norm = length(right);
            (norm > 1e-6 * length(up)).then(|| right.map(|value| value / norm))
        })?;
        let above = cross(normal, across);
        let (sin, cos) = angle.sin_cos();
        let right: Vec3 = std::array::from_fn(|axis| cos * across[axis] + sin * above[axis]);
        Some(Self { normal, up: cross(normal, right), right })
    }

    /// Returns the mean of the normals around a vertex, weighted by area.
    pub fn normal(surface: &Surface, vertex: u32) -> Vec3 {
        let mut sum = [0.0; 3];
        for half in surface.fan(vertex) {
            let [a, b, c] = surface.corners(half / 3);
            let normal = cross(minus(b, a), minus(c, a));
            for axis in 0..3 {
                sum[axis] += normal[axis];
            }
        }
        let norm = length(sum);
        if norm > 0.0 { sum.map(|value| value / norm) } else { [0.0, 0.0, 1.0] }
    }
}

/// The seed of a single pin: one face, turned to the pose. Also returns the heading of an edge of that face.
fn posed(surface: Arc<Surface>, vertex: u32, place: Vec2, pose: Pose) -> Result<(Seed, Option<(u32, Vec2)>)> {
    let frame = Frame::new(&surface, vertex, pose)?;
    let Some(half) = surface.fan(vertex).next() else {
        return Err(Error::invalid("no face holds its place").at(name(0)).advise("move it onto a face"));
    };
    let target = surface.points[surface.target(half) as usize];
    let way = minus(target, surface.points[vertex as usize]);
    let heading = [dot(way, frame.right), dot(way, frame.up)];
    let scale = 1.0 / pose.width;
    let patch = single(&surface, half / 3, vertex, place, target, heading, scale)?;
    let at = patch.vertices.iter().position(|other| *other == vertex).unwrap_or_default();
    Ok((Seed { surface, patch, pins: vec![(0, at as u32)], scale }, Some((half, heading))))
}

impl Decal {
    /// Makes the decal of a patch.
    pub(crate) fn of(seed: &Seed, sticker: &Sticker, count: usize) -> Self {
        let Seed { surface, patch, pins, .. } = seed;
        let mut vertices = vec![0; count];
        for (pin, vertex) in pins {
            vertices[*pin] = *vertex;
        }
        let (faces, triangles) = (patch.faces.clone(), &patch.triangles);
        Self::assemble(surface, &patch.vertices, &patch.positions, faces, triangles, vertices, sticker)
    }

    /// Makes a decal of faces with positions in the plane; `vertices` and `triangles` are those of the surface.
    pub(crate) fn assemble(
        surface: &Surface,
        vertices: &[u32],
        positions: &[Vec2],
        faces: Vec<[u32; 3]>,
        triangles: &[u32],
        pins: Vec<u32>,
        sticker: &Sticker,
    ) -> Self {
        let quality = measure(surface, &sticker.outline, &faces, triangles, positions);
        let area: f64 = triangles.iter().map(|triangle| surface.area(*triangle)).sum();
        let flat = faces.iter().map(|face| {
            let [a, b, c] = face.map(|vertex| positions[vertex as usize]);
            0.5 * ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]))
        });
        let scale = (flat.sum::<f64>().max(0.0) / area.max(f64::MIN_POSITIVE)).sqrt();
        let ratio = sticker.size[0] / sticker.size[1];
        Self {
            points: vertices.iter().map(|vertex| surface.points[*vertex as usize]).collect(),
            normals: vertices.iter().map(|vertex| Frame::normal(surface, *vertex)).collect(),
            uv: positions.iter().map(|[x, y]| [*x, y * ratio]).collect(),
            faces: triangles.iter().map(|triangle| surface.sources[*triangle as usize]).collect(),
            triangles: faces,
            pins,
            scale,
            quality,
        }
    }

    /// Returns the depth of a place of the image: the mean of the depths of the pins, weighted by inverse squared
    /// distances (Shepard 1968). 0 without depths.
    pub fn depth(&self, place: Vec2, depths: &[f64]) -> f64 {
        let (mut sum, mut weights) = (0.0, 0.0);
        for (pin, depth) in self.pins.iter().zip(depths) {
            let weight = 1.0 / distance(self.uv[*pin as usize], place).powi(2).max(1e-12);
            sum += weight * depth;
            weights += weight;
        }
        if weights > 0.0 { sum / weights } else { 0.0 }
    }

    /// Fails if there are depths, but not one for each pin.
    ///
    /// # Errors
    /// There are more or fewer, and not none.
    pub fn check_depths(&self, depths: &[f64]) -> Result<()> {
        let pins = self.pins.len();
        if depths.is_empty() || depths.len() == pins {
            return Ok(());
        }
        Err(Error::invalid(format!("there are {} depths for {pins} pins", depths.len()))
            .at("decal")
            .advise("give one depth for each pin, or none"))
    }

    /// Returns a number that orders places of the image that lie on one place of the surface, the largest on top: the
    /// [`Self::depth`], or how far on the right the place is where pins have no depths.
    pub fn height(&self, place: Vec2, depths: &[f64]) -> f64 {
        if depths.is_empty() { place[0] } else { self.depth(place, depths) }
    }

    /// Returns the decal as a mesh with attributes `uv` and `normal` of its points and `decal` of its faces, the face of the
    /// surface under each, lifted off the surface by `offset`.
    pub fn mesh(&self, offset: f64) -> Mesh {
        let lifted = self.points.iter().zip(&self.normals);
        let lifted =
            lifted.map(|(point, normal)| std::array::from_fn(|axis| (point[axis] + offset * normal[axis]) as f32));
        let mut mesh = Mesh::from_triangles(lifted.collect(), &self.triangles);
        let mut add = |name: &str, width: u32, values: Vec<f32>| {
            let values = Values::F32(values);
            mesh.attributes.push(Attribute { name: name.into(), domain: Domain::Point, width, values, indices: None });
        };
        add("uv", 2, self.uv.iter().flatten().map(|value| *value as f32).collect());
        add("normal", 3, self.normals.iter().flatten().map(|value| *value as f32).collect());
        mesh.attributes.push(Attribute {
            name: "decal".into(),
            domain: Domain::Face,
            width: 1,
            values: Values::U32(self.faces.clone()),
            indices: None,
        });
        mesh
    }

    /// Returns whether the triangles form a topological disk, by OpenMesh.
    ///
    /// # Errors
    /// The triangles are no oriented manifold, or OpenMesh is not installed.
    pub fn is_disk(&self) -> Result<bool> {
        let points: Vec<[f32; 3]> = self.points.iter().map(|point| point.map(|value| value as f32)).collect();
        relievo_openmesh::Patch::new(&points, &self.triangles)?.is_disk()
    }
}
