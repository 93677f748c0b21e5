//! Objects that a graphics device draws frame after frame: what [`Scene`](crate::Scene) is to the ray caster.

use std::collections::BTreeMap;

use glam::DAffine3;
use relievo_core::{Context, Error, Result};
use relievo_gpu::Device;
use relievo_tiles::Displaced;
use relievo_tiles::triangle::{TriangleDisplaced, TriangleNormals};

use super::Rasterizer;
use super::coat::{Coat, TriangleCoat};
use super::placed::{DeviceMesh, Placed, Shape};
use super::rates::TileRates;
use super::surface::DrawnSurface;
use super::triangles::VirtualTriangles;
use crate::frame::Frame;
use crate::scene::{Material, Mesh, ObjectId};
use crate::settings::View;

/// Objects, each a displaced surface, a displaced triangle mesh, a number of meshes, or all of them.
#[derive(Debug)]
pub struct Stage {
    device: Device,
    rasterizer: Rasterizer,
    objects: Vec<Entry>,
}

#[derive(Debug)]
struct Entry {
    transform: DAffine3,
    material: Material,
    surface: Option<DrawnSurface>,
    triangles: Option<VirtualTriangles>,
    meshes: BTreeMap<u32, DeviceMesh>,
}

impl Stage {
    /// An empty stage on `device`.
    ///
    /// # Errors
    /// As of [`Rasterizer::new`].
    pub fn new(device: &Device) -> Result<Self> {
        Ok(Self { device: device.clone(), rasterizer: Rasterizer::new(device)?, objects: Vec::new() })
    }

    /// Adds an object that shows nothing yet. Its number in pictures counts from 0.
    pub fn add_object(&mut self, transform: DAffine3, material: Material) -> ObjectId {
        self.objects.push(Entry { transform, material, surface: None, triangles: None, meshes: BTreeMap::new() });
        ObjectId::of(self.objects.len() as u32 - 1)
    }

    /// Places an object.
    ///
    /// # Errors
    /// There is no such object, or the transform is singular or not finite.
    pub fn set_transform(&mut self, object: ObjectId, transform: DAffine3) -> Result<()> {
        if !transform.is_finite() || !transform.inverse().is_finite() {
            return Err(Error::invalid("the transform of an object is singular or not finite")
                .advise("give it a scale that is not zero on every axis"));
        }
        self.object(object)?.transform = transform;
        Ok(())
    }

    /// Sets mesh `number` of an object in place of what it was. A mesh without triangles is none.
    ///
    /// # Errors
    /// There is no such object, triangles name points that do not exist, or the device has no room.
    pub fn set_mesh(&mut self, object: ObjectId, number: u32, mesh: &Mesh) -> Result<()> {
        let device = self.device.clone();
        let entry = self.object(object)?;
        if mesh.triangles.is_empty() {
            entry.meshes.remove(&number);
        } else {
            entry.meshes.insert(number, DeviceMesh::new(&device, mesh, &entry.material)?);
        }
        Ok(())
    }

    /// Makes an object show a displaced surface with its colours and traces, or brings what it shows up to date: what changed in a
    /// channel is found and sent. `moved` says that the cage is in another pose. Tiles are divided as `rates` says, and
    /// tagged for false colours by `tag`.
    ///
    /// # Errors
    /// There is no such object, the surface has other tiles, or the device fails.
    pub fn set_surface(
        &mut self,
        context: &Context,
        object: ObjectId,
        (displaced, coat): (&Displaced<'_>, Coat<'_>),
        moved: bool,
        rates: TileRates,
        tag: impl Fn(u32) -> u32,
    ) -> Result<()> {
        let device = self.device.clone();
        let slot = &mut self.object(object)?.surface;
        if let Some(surface) = slot.as_mut().filter(|_| !moved) {
            surface.update(context, &device, displaced, coat)?;
        } else {
            *slot = Some(DrawnSurface::new(context, &device, displaced, coat)?);
        }
        let Some(surface) = slot else { return Ok(()) };
        if *surface.tiles().rates() != rates {
            surface.tiles_mut().divide(&device, rates)?;
        }
        surface.tiles_mut().tag(&device, tag)
    }

    /// Makes an object show a displaced triangle mesh with its colours and traces, as finely as values are kept, or brings what it
    /// shows up to date where `changed` faces, ascending, look different: all of it, in another pose too, if that is
    /// `None`. Faces are tagged for false colours by `tag`.
    ///
    /// # Errors
    /// There is no such object, the mesh is another one, or the device fails.
    pub fn set_triangles(
        &mut self,
        context: &Context,
        object: ObjectId,
        (displaced, normals, coat): (&TriangleDisplaced<'_>, &TriangleNormals, TriangleCoat<'_>),
        changed: Option<&[u32]>,
        tag: impl Fn(u32) -> u32,
    ) -> Result<()> {
        let device = self.device.clone();
        let slot = &mut self.object(object)?.triangles;
        let kept = slot.as_mut().filter(|triangles| triangles.shows(displaced, coat));
        if let (Some(triangles), Some(changed)) = (kept, changed) {
            triangles.update(context, &device, displaced, normals, coat, changed)?;
            let finest = triangles.finest();
            if *triangles.rates() != finest {
                triangles.divide(&device, finest)?;
            }
        } else {
            *slot = Some(VirtualTriangles::new(context, &device, displaced, normals, coat)?);
        }
        slot.as_mut().map_or(Ok(()), |triangles| triangles.tag(&device, tag))
    }

    /// Draws a picture. Objects have the numbers of their ids.
    ///
    /// # Errors
    /// As of [`Rasterizer::render`].
    pub fn render(&mut self, view: &View) -> Result<Frame> {
        let mut placed = Vec::new();
        for (number, entry) in (0..).zip(&self.objects) {
            let (transform, material) = (entry.transform, entry.material);
            placed.extend(entry.surface.iter().map(|surface| surface.placed(transform, material, Some(number))));
            let triangles = entry.triangles.iter().map(Shape::Triangles);
            let shapes = triangles.chain(entry.meshes.values().map(Shape::Mesh));
            placed.extend(shapes.map(|shape| Placed {
                transform,
                number: Some(number),
                ..Placed::new(shape, material)
            }));
        }
        self.rasterizer.render(&placed, view)
    }

    fn object(&mut self, object: ObjectId) -> Result<&mut Entry> {
        let number = object.number();
        self.objects.get_mut(number as usize).ok_or_else(|| Error::invalid(format!("there is no object {number}")))
    }
}
