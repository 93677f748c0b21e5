//! What a device has of a displaced and painted surface, kept up to date from frame to frame.

use glam::DAffine3;
use relievo_core::{Context, Result};
use relievo_gpu::Device;
use relievo_surface::DeviceSurface;
use relievo_surface::bezier::Viewpoint;
use relievo_tiles::{DeviceTiles, Displaced, Field, Vector};

use super::coat::{Coat, DeviceCoat};
use super::placed::{Placed, Shape};
use super::tiles::VirtualTiles;
use crate::scene::Material;
use crate::settings::View;

/// A displaced Catmull-Clark surface that is drawn, with its colours and traces.
#[derive(Debug)]
pub struct DrawnSurface {
    surface: DeviceSurface,
    tiles: DeviceTiles,
    vectors: Option<DeviceTiles<Vector>>,
    coat: DeviceCoat,
    drawn: VirtualTiles,
}

impl DrawnSurface {
    /// Brings a surface to a device. It is divided as coarsely as can be before [`Self::adapt`] or [`Self::divide`].
    ///
    /// # Errors
    /// The device has no room.
    pub fn new(context: &Context, device: &Device, displaced: &Displaced<'_>, coat: Coat<'_>) -> Result<Self> {
        Ok(Self {
            surface: DeviceSurface::new(device, displaced.surface())?,
            tiles: DeviceTiles::new(device, displaced.field())?,
            vectors: displaced.vectors().map(|vectors| DeviceTiles::new(device, vectors)).transpose()?,
            coat: DeviceCoat::new(context, device, coat)?,
            drawn: VirtualTiles::new(context, device, displaced, 2)?,
        })
    }

    /// Makes the device have what `displaced` and `coat` are now: a later or earlier state of the same cage, in the
    /// pose of the surface it was made from or was last [posed](Self::pose) in.
    ///
    /// # Errors
    /// The surface has other tiles, or the device fails.
    pub fn update(
        &mut self,
        context: &Context,
        device: &Device,
        displaced: &Displaced<'_>,
        coat: Coat<'_>,
    ) -> Result<()> {
        let mut changed = self.tiles.update(device, displaced.field())?;
        match (&mut self.vectors, displaced.vectors()) {
            (Some(held), Some(vectors)) => changed.extend(held.update(device, vectors)?),
            (held, vectors) => {
                let of = |vectors: &Field<Vector>| vectors.allocated().collect::<Vec<u32>>();
                changed.extend(held.iter().map(DeviceTiles::field).chain(vectors).flat_map(of));
                *held = vectors.map(|vectors| DeviceTiles::new(device, vectors)).transpose()?;
            }
        }
        changed.sort_unstable();
        changed.dedup();
        self.drawn.update(context, device, displaced, &changed)?;
        self.coat.update(context, device, coat)
    }

    /// Moves the surface to another pose of the cage: `displaced` is of that pose and `points` are its points.
    ///
    /// # Errors
    /// As of [`Self::update`], or there are not as many points as the cage has.
    pub fn pose(
        &mut self,
        context: &Context,
        device: &Device,
        displaced: &Displaced<'_>,
        points: &[[f32; 3]],
    ) -> Result<()> {
        self.surface.set_points(device, points)?;
        let mut frame = device.frame()?;
        self.surface.pose(&mut frame.pass("pose"))?;
        let _submitted = frame.submit()?;
        let all: Vec<u32> = (0..displaced.field().tile_count() as u32).collect();
        self.drawn.update(context, device, displaced, &all)
    }

    /// Divides tiles so that triangles are at most about `tolerance` pixels from the surface as `view` shows it at
    /// `transform`.
    ///
    /// # Errors
    /// The tolerance is not above zero, or the device fails.
    pub fn adapt(&mut self, device: &Device, view: &View, transform: &DAffine3, tolerance: f64) -> Result<()> {
        let viewpoint: Viewpoint = view.viewpoint(transform);
        self.drawn.adapt(device, &viewpoint, tolerance)
    }

    /// How it is divided, to divide it otherwise or to tag tiles.
    pub fn tiles_mut(&mut self) -> &mut VirtualTiles {
        &mut self.drawn
    }

    /// How it is divided.
    pub fn tiles(&self) -> &VirtualTiles {
        &self.drawn
    }

    /// The surface in the world, with the numbers of its tiles in pictures, or with one of its own.
    pub fn placed(&self, transform: DAffine3, material: Material, number: Option<u32>) -> Placed<'_> {
        let shape = Shape::Tiles {
            surface: &self.surface,
            tiles: &self.tiles,
            vectors: self.vectors.as_ref(),
            coat: Some(&self.coat),
            drawn: &self.drawn,
        };
        Placed { transform, number, ..Placed::new(shape, material) }
    }
}
