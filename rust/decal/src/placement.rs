//! A sticker that lies on a surface and follows: pins that are dragged, and a surface that is posed.
//!
//! While a pin is dragged, the triangles stay what they are. The pin is a point within one of them, which each Newton step
//! brings to its place in the image as a linear constraint; the factor of the linear system keeps its structure from update
//! to update. [`Placement::settle`] makes the point a vertex and lets the patch grow and shrink.

use std::collections::{HashMap, HashSet};
use std::sync::Arc;

use relievo_core::{Error, Mesh, Progress, Result};

use crate::decal::{Decal, DecalSettings, Laying, Pose, Sticker, check};
use crate::map::energy::{Rest, Vec2};
use crate::map::factor::System;
use crate::map::grow::Growth;
use crate::map::patch::Patch;
use crate::map::relax::{Hook, Map};
use crate::map::seed::Seed;
use crate::pins::{Pin, Place, insert, name};
use crate::surface::{Surface, Vec3, cross, dot, minus};

/// Newton steps of an update after the pin arrived.
const STEPS: usize = 1;
/// How near a dragged pin comes to its place in the image, in widths of the image.
const NEAR: f64 = 1e-8;

/// A sticker on a surface.
#[derive(Debug)]
pub struct Placement {
    mesh: Mesh,
    sticker: Sticker,
    settings: DecalSettings,
    seed: Seed,
    /// Vertices of the surface of all pins, with their places in the plane.
    vertices: Vec<u32>,
    places: Vec<Vec2>,
    drag: Option<Drag>,
}

/// A pin that is being dragged.
#[derive(Debug)]
struct Drag {
    pin: usize,
    /// Targets of the other pins.
    pins: Vec<(u32, Vec2)>,
    rest: Vec<Rest>,
    system: System,
    /// The faces of the patch on each face of the mesh.
    faces: HashMap<u32, Vec<u32>>,
    hook: Hook,
}

impl Placement {
    /// Lays a sticker as [`lay`](crate::lay) does.
    ///
    /// # Errors
    /// As [`lay`](crate::lay).
    pub fn new(
        mesh: &Mesh,
        sticker: &Sticker,
        pins: &[Pin],
        pose: Option<Pose>,
        settings: &DecalSettings,
        progress: &mut dyn Progress,
    ) -> Result<Self> {
        Self::watched(mesh, sticker, pins, pose, settings, &|_| {}, progress)
    }

    /// As [`Self::new`], and calls `watch` after each change of the faces of the patch.
    pub(crate) fn watched(
        mesh: &Mesh,
        sticker: &Sticker,
        pins: &[Pin],
        pose: Option<Pose>,
        settings: &DecalSettings,
        watch: &dyn Fn(&Patch),
        progress: &mut dyn Progress,
    ) -> Result<Self> {
        check(pins, settings)?;
        progress.step(0.0, "reading the surface")?;
        let places: Vec<_> = pins.iter().map(|pin| pin.place).collect();
        let (surface, vertices) = insert(Surface::new(mesh)?, &places)?;
        let surface = Arc::new(surface);
        let places: Vec<Vec2> = pins.iter().map(|pin| sticker.place(pin.image)).collect();
        let laying = Laying { surface: &surface, sticker, vertices, places, pose, settings, watch };
        let seed = match laying.attempt(progress) {
            Ok(seed) => seed,
            Err(fault) => return Err(laying.explain(fault, progress)),
        };
        let Laying { vertices, places, .. } = laying;
        let (mesh, sticker) = (mesh.clone(), sticker.clone());
        Ok(Self { mesh, sticker, settings: *settings, seed, vertices, places, drag: None })
    }

    /// Returns the decal as it lies now. A pin that is being dragged has the vertex that it had before.
    pub fn decal(&self) -> Decal {
        Decal::of(&self.seed, &self.sticker, self.places.len())
    }

    /// Returns the mesh that the sticker lies on.
    pub fn mesh(&self) -> &Mesh {
        &self.mesh
    }

    /// Returns the pins as they are now; one that is being dragged is where it was dragged to.
    pub fn pins(&self) -> Vec<Pin> {
        let Seed { surface, patch, .. } = &self.seed;
        let held = |(pin, vertex): (usize, &u32)| {
            let dragged = self.drag.as_ref().filter(|drag| drag.pin == pin).map(|drag| drag.hook);
            let (triangle, point) = match dragged {
                Some(Hook { face, weights, .. }) => {
                    let corners = surface.corners(patch.triangles[face]);
                    let point = std::array::from_fn(|axis| (0..3).map(|at| weights[at] * corners[at][axis]).sum());
                    (patch.triangles[face], point)
                }
                None => (surface.leaving[*vertex as usize] / 3, surface.points[*vertex as usize]),
            };
            let face = surface.sources.get(triangle as usize).copied().unwrap_or_default();
            let barycentric = self.corners(face).and_then(|corners| weights(corners, point)).unwrap_or([1.0, 0.0, 0.0]);
            let image = self.places[pin].map(|value| value * self.sticker.size[0]);
            Pin { image, place: Place { face, barycentric: barycentric.map(|weight| weight.max(0.0)) } }
        };
        self.vertices.iter().enumerate().map(held).collect()
    }

    /// Returns the point of the mesh at a place.
    ///
    /// # Errors
    /// There is no such face.
    pub fn position(&self, Place { face, barycentric }: Place) -> Result<Vec3> {
        let corners = self.corners(face).ok_or_else(|| Error::invalid(format!("face {face} does not exist")))?;
        Ok(std::array::from_fn(|axis| (0..3).map(|corner| barycentric[corner] * corners[corner][axis]).sum()))
    }

    /// Returns how it is laid.
    pub fn settings(&self) -> &DecalSettings {
        &self.settings
    }

    /// Returns the sticker.
    pub fn sticker(&self) -> &Sticker {
        &self.sticker
    }

    /// Moves a pin to another place of the mesh. The map follows from its last state; its triangles stay.
    ///
    /// # Errors
    /// There is no such pin or place; the place is not under the sticker; or the sticker cannot follow without folds: it
    /// stays what it was.
    pub fn drag(&mut self, pin: usize, place: Place) -> Result<()> {
        if pin >= self.places.len() {
            return Err(Error::invalid(format!("there are {} pins", self.places.len())).at(name(pin)));
        }
        if self.drag.as_ref().is_some_and(|drag| drag.pin != pin) {
            self.drop_pin()?;
        }
        if self.drag.is_none() {
            self.drag = Some(self.start(pin)?);
        }
        let Some((face, weights)) = self.locate(pin, place)? else {
            return Err(Error::invalid("the place is not under the sticker")
                .at(name(pin))
                .advise("move the pin in smaller steps, and settle the sticker in between"));
        };
        let kept = self.seed.patch.positions.clone();
        let Some(drag) = &mut self.drag else { return Ok(()) };
        let hook = Hook { face, weights, target: self.places[pin] };
        let patch = &mut self.seed.patch;
        let mut map = Map {
            faces: &patch.faces,
            rest: &drag.rest,
            positions: &mut patch.positions,
            pins: &drag.pins,
            hook: Some(hook),
        };
        if map.follow(&mut drag.system, STEPS, NEAR)? {
            drag.hook = hook;
            return Ok(());
        }
        patch.positions = kept;
        Err(Error::invalid("the sticker cannot follow without folds")
            .at(name(pin))
            .advise("move the pin in smaller steps, or move its neighbours first"))
    }

    /// Moves the point of the image that a pin belongs to, in pixels from the lower left corner, and settles the sticker.
    ///
    /// # Errors
    /// There is no such pin, the point is not within the outline, or as [`Self::settle`].
    pub fn move_image(&mut self, pin: usize, image: Vec2, progress: &mut dyn Progress) -> Result<()> {
        if pin >= self.places.len() {
            return Err(Error::invalid(format!("there are {} pins", self.places.len())).at(name(pin)));
        }
        self.sticker.check(&image).map_err(|error| error.at(name(pin)))?;
        self.drop_pin()?;
        let kept = std::mem::replace(&mut self.places[pin], self.sticker.place(image));
        self.settle(progress).inspect_err(|_| self.places[pin] = kept)
    }

    /// Gives the mesh other points and settles the sticker on them.
    ///
    /// # Errors
    /// There are more or fewer points, one is not finite, or as [`Self::settle`].
    pub fn pose(&mut self, points: &[[f32; 3]], progress: &mut dyn Progress) -> Result<()> {
        if points.len() != self.mesh.points.len() {
            return Err(Error::invalid(format!(
                "{} points were given, the mesh has {}",
                points.len(),
                self.mesh.points.len()
            ))
            .at("points"));
        }
        if let Some(point) = points.iter().position(|point| point.iter().any(|value| !value.is_finite())) {
            return Err(Error::invalid("it is not finite").at(format!("point {point}")).advise("give three numbers"));
        }
        self.drop_pin()?;
        let kept = (Arc::clone(&self.seed.surface), self.seed.scale);
        let before = self.area();
        let posed = self.posed(points);
        Arc::make_mut(&mut self.seed.surface).points = posed;
        // The sticker grows with the surface as a whole.
        let growth = (before / self.area()).sqrt();
        self.seed.scale *= if growth.is_finite() && growth > 0.0 { growth } else { 1.0 };
        self.settle(progress).inspect_err(|_| (self.seed.surface, self.seed.scale) = kept)?;
        self.mesh.points.copy_from_slice(points);
        Ok(())
    }

    /// Lowers the distortion after changes, lets the patch grow and shrink, and makes a dragged pin a vertex.
    ///
    /// # Errors
    /// The sticker cannot be laid without folds, the patch grows beyond its limit, or the caller cancels. It stays what it
    /// was.
    pub fn settle(&mut self, progress: &mut dyn Progress) -> Result<()> {
        self.drop_pin()?;
        let kept = (self.seed.patch.clone(), self.seed.pins.clone());
        let limits = self.settings.limits();
        let mut growth = Growth {
            seed: &mut self.seed,
            vertices: &self.vertices,
            places: &self.places,
            outline: &self.sticker.outline,
            heading: None,
            is_free: false,
            towards: HashSet::new(),
            limits,
            factor: Vec::new(),
            watch: &|_| {},
        };
        match growth.settle(self.settings.stop(), progress) {
            Ok(()) => Ok(()),
            Err(fault) => {
                (self.seed.patch, self.seed.pins) = kept;
                Err(fault.into_error())
            }
        }
    }

    fn start(&self, pin: usize) -> Result<Drag> {
        let Seed { surface, patch, pins, scale } = &self.seed;
        let rest = patch.triangles.iter().map(|triangle| Rest::new(surface.corners(*triangle), *scale)).collect();
        let others = pins.iter().filter(|(other, _)| *other != pin);
        let others: Vec<(u32, Vec2)> = others.map(|(other, vertex)| (*vertex, self.places[*other])).collect();
        let mut is_pinned = vec![false; patch.vertices.len()];
        for (vertex, _) in &others {
            is_pinned[*vertex as usize] = true;
        }
        let system = System::new(is_pinned.len(), &patch.faces, &is_pinned)?;
        let mut faces: HashMap<u32, Vec<u32>> = HashMap::new();
        for (face, triangle) in patch.triangles.iter().enumerate() {
            faces.entry(surface.sources[*triangle as usize]).or_default().push(face as u32);
        }
        let vertex = pins.iter().find(|(other, _)| *other == pin).map_or(0, |(_, vertex)| *vertex);
        let face = patch.faces.iter().position(|face| face.contains(&vertex)).unwrap_or_default();
        let weights = patch.faces[face].map(|corner| f64::from(u8::from(corner == vertex)));
        let hook = Hook { face, weights, target: self.places[pin] };
        Ok(Drag { pin, pins: others, rest, system, faces, hook })
    }

    /// The face of the patch at a place of the mesh, with weights; of several copies the one that is nearest to the pin's
    /// point in the image. None where the sticker does not lie.
    fn locate(&self, pin: usize, place: Place) -> Result<Option<(usize, [f64; 3])>> {
        let Some(corners) = self.corners(place.face) else {
            return Err(Error::invalid(format!("face {} does not exist", place.face)).at(name(pin)));
        };
        let sum: f64 = place.barycentric.iter().sum();
        if !place.barycentric.iter().all(|weight| *weight >= -1e-6) || !(sum > 1e-6 && sum.is_finite()) {
            return Err(Error::invalid(format!("the weights {:?} are no place", place.barycentric))
                .at(name(pin))
                .advise("give three weights that are not negative and do not vanish together"));
        }
        let point: Vec3 = std::array::from_fn(|axis| {
            (0..3).map(|corner| place.barycentric[corner] / sum * corners[corner][axis]).sum()
        });
        let Some(faces) = self.drag.as_ref().and_then(|drag| drag.faces.get(&place.face)) else {
            return Ok(None);
        };
        let Seed { surface, patch, .. } = &self.seed;
        let target = self.places[pin];
        let mut best: Option<(f64, usize, [f64; 3])> = None;
        for face in faces.iter().map(|face| *face as usize) {
            let Some(weights) = weights(surface.corners(patch.triangles[face]), point) else { continue };
            let outside = weights.into_iter().fold(0.0, |outside: f64, weight| outside.max(-weight));
            let places = patch.faces[face].map(|vertex| patch.positions[vertex as usize]);
            let at: Vec2 =
                std::array::from_fn(|axis| (0..3).map(|corner| weights[corner] * places[corner][axis]).sum());
            // A place outside of a part of the face belongs to another part.
            let far = 1e6 * (outside - 1e-9).max(0.0) + crate::map::energy::distance(at, target);
            if best.is_none_or(|best| far < best.0) {
                best = Some((far, face, weights));
            }
        }
        Ok(best.map(|(_, face, weights)| (face, weights.map(|weight| weight.max(0.0)))))
    }

    fn corners(&self, face: u32) -> Option<[Vec3; 3]> {
        let corners = self.mesh.corners.as_chunks::<3>().0.get(face as usize)?;
        Some(corners.map(|corner| self.mesh.points[corner as usize].map(f64::from)))
    }

    /// Makes the place of a dragged pin a vertex of the surface and of the patch.
    fn drop_pin(&mut self) -> Result<()> {
        let Some(Drag { pin, hook, .. }) = self.drag.take() else { return Ok(()) };
        let old = &self.seed.surface;
        let triangle = self.seed.patch.triangles[hook.face];
        let place = Place { face: triangle, barycentric: hook.weights };
        let (surface, made) = insert(Surface::clone(old), &[place])?;
        let vertex = made.first().copied().ok_or_else(|| Error::internal("a place has no vertex"))?;
        let (patch, at) = if vertex < old.points.len() as u32 {
            let corner = old.triangles[triangle as usize].iter().position(|other| *other == vertex).unwrap_or_default();
            (self.seed.patch.clone(), self.seed.patch.faces[hook.face][corner])
        } else {
            divided(&self.seed.patch, old, &surface, vertex, hook.face)?
        };
        self.seed.patch = patch;
        self.seed.patch.positions[at as usize] = self.places[pin];
        self.seed.surface = Arc::new(surface);
        self.vertices[pin] = vertex;
        for (other, vertex) in &mut self.seed.pins {
            if *other == pin {
                *vertex = at;
            }
        }
        Ok(())
    }

    /// The area of the surface under the patch.
    fn area(&self) -> f64 {
        self.seed.patch.triangles.iter().map(|triangle| self.seed.surface.area(*triangle)).sum()
    }

    /// The points of the surface after those of the mesh moved: each keeps its place on its face.
    fn posed(&self, points: &[[f32; 3]]) -> Vec<Vec3> {
        let surface = &self.seed.surface;
        let mut posed = surface.points.clone();
        for (triangle, vertices) in surface.triangles.iter().enumerate() {
            let source = surface.sources[triangle];
            let (Some(before), Some(corners)) =
                (self.corners(source), self.mesh.corners.as_chunks::<3>().0.get(source as usize))
            else {
                continue;
            };
            let after = corners.map(|corner| points[corner as usize].map(f64::from));
            for vertex in vertices.map(|vertex| vertex as usize) {
                let Some(weights) = weights(before, surface.points[vertex]) else { continue };
                posed[vertex] =
                    std::array::from_fn(|axis| (0..3).map(|corner| weights[corner] * after[corner][axis]).sum());
            }
        }
        posed
    }
}

/// The barycentric coordinates of a point in the plane of a triangle; none of one without area.
fn weights([a, b, c]: [Vec3; 3], point: Vec3) -> Option<[f64; 3]> {
    let normal = cross(minus(b, a), minus(c, a));
    let whole = dot(normal, normal);
    let share = |from: Vec3, to: Vec3| dot(normal, cross(minus(to, from), minus(point, from))) / whole;
    let weights = [share(b, c), share(c, a), share(a, b)];
    weights.iter().all(|weight| weight.is_finite()).then_some(weights)
}

/// The patch on a surface in which triangles were divided at a new vertex, and the vertex of the patch there in `face`.
fn divided(patch: &Patch, old: &Surface, new: &Surface, vertex: u32, face: usize) -> Result<(Patch, u32)> {
    let (mut vertices, mut positions) = (patch.vertices.clone(), patch.positions.clone());
    let (mut faces, mut triangles) = (Vec::new(), Vec::new());
    // New vertices of the patch: of a face, or of an edge of two faces, by its smallest two vertices.
    let mut made: HashMap<[u32; 2], u32> = HashMap::new();
    let mut at = 0;
    let added = old.triangles.len() as u32..new.triangles.len() as u32;
    for (index, corners) in patch.faces.iter().enumerate() {
        let triangle = patch.triangles[index];
        let before = old.triangles[triangle as usize];
        let parts: Vec<u32> = std::iter::once(triangle)
            .filter(|part| new.triangles[*part as usize].contains(&vertex))
            .chain(added.clone())
            .filter(|part| {
                new.triangles[*part as usize].iter().all(|corner| *corner == vertex || before.contains(corner))
            })
            .collect();
        if !new.triangles[triangle as usize].contains(&vertex) {
            faces.push(*corners);
            triangles.push(triangle);
            continue;
        }
        let place = weights(old.corners(triangle), new.points[vertex as usize])
            .ok_or_else(|| Error::internal("a face without area was divided"))?;
        let on_edge = (0..3).find(|corner| parts.len() == 2 && place[*corner] < 1e-6);
        let key = match on_edge {
            Some(corner) => {
                let (a, b) = (corners[(corner + 1) % 3], corners[(corner + 2) % 3]);
                [a.min(b), a.max(b)]
            }
            None => [index as u32, u32::MAX],
        };
        let own = *made.entry(key).or_insert_with(|| {
            vertices.push(vertex);
            positions.push(std::array::from_fn(|axis| {
                (0..3).map(|corner| place[corner] * patch.positions[corners[corner] as usize][axis]).sum()
            }));
            vertices.len() as u32 - 1
        });
        if index == face {
            at = own;
        }
        for part in parts {
            let local = |corner: u32| {
                before.iter().position(|other| *other == corner).map_or(own, |position| corners[position])
            };
            faces.push(new.triangles[part as usize].map(local));
            triangles.push(part);
        }
    }
    Ok((Patch::new(vertices, positions, faces, triangles)?, at))
}
