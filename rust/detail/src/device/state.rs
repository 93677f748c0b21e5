//! What a device keeps of an object: its surface in its pose, its displacement, and what edits need besides.

use half::f16;
use relievo_core::{Context, Error, Result};
use relievo_gpu::Device;
use relievo_surface::DeviceSurface;
use relievo_tiles::{DeviceRing, DeviceTiles, Field, Rgba8, Rgba16, Texel, Vector};

use super::imprint::cull::DeviceCull;
use super::imprint::smoothing::WorkedTiles;
use super::paint::brush::{DeviceBrush, DeviceGround};
use super::paint::colors::DeviceColors;
use crate::object::DisplacedObject;
use crate::paint::ground::Ground;

/// The state of an object on a device, which edits share.
#[derive(Debug)]
pub(crate) struct DeviceObject {
    pub(super) device: Device,
    pub(super) surface: DeviceSurface,
    /// The displacement along the normals, as it was when somebody last needed it.
    pub(super) tiles: DeviceTiles,
    pub(super) ring: DeviceRing,
    /// The rings of vectors, once dabs that look at neighbours were made together.
    pub(super) turning: Option<DeviceRing>,
    /// The displacement from when a stroke began, once there is one.
    begun: Option<DeviceTiles>,
    /// The displacement at a coarser level, and as it was when the stroke began, once a dab needed them.
    pub(super) coarse: [Option<DeviceTiles>; 2],
    /// The vectors, as `tiles`, `begun` and `coarse` have the displacement, once a dab needed them.
    pub(super) vectors: Option<DeviceTiles<Vector>>,
    begun_vectors: Option<DeviceTiles<Vector>>,
    pub(super) coarse_vectors: [Option<DeviceTiles<Vector>>; 2],
    pub(super) bending: Option<DeviceBrush<Vector>>,
    /// What sculpts and what paints, once something did.
    pub(super) sculpting: Option<DeviceBrush<f16>>,
    pub(super) painting: Option<DeviceColors<Rgba8>>,
    pub(super) half_painting: Option<DeviceColors<Rgba16>>,
    /// What culls tiles, once there was an imprint, with the displacement and the vectors that it knows.
    culling: Option<(DeviceCull, Field, Option<Field<Vector>>)>,
    /// What blocks of tiles that imprints smooth need, once some did.
    pub(super) worked: Option<WorkedTiles>,
    /// Whether it lacks the normals of the pose.
    posed: bool,
}

impl DisplacedObject {
    /// Has dabs and imprints made on a graphics device from now on, or on the processor again.
    ///
    /// # Errors
    /// Fails, and changes nothing, with `Memory` if the device has no room for the object, with `Unsupported` if the
    /// stencils of its surface have weights too large for a device, with `Device` if the device is lost or its driver
    /// fails, and as the page store does if a tile is on a page that cannot be read. Never fails without a device.
    pub fn use_device(&mut self, device: Option<&Device>) -> Result<()> {
        self.device = device.map(|device| DeviceObject::new(device, self)).transpose()?;
        Ok(())
    }

    /// Returns the displacement along the normals that the device holds, as it was after the last edit there; nothing
    /// without a device.
    pub fn device_displacement(&self) -> Option<&DeviceTiles> {
        self.device.as_ref().map(|state| &state.tiles)
    }

    /// Returns the vectors that the device holds, as they were after the last edit there; nothing before the first edit
    /// of vectors.
    pub fn device_vectors(&self) -> Option<&DeviceTiles<Vector>> {
        self.device.as_ref().and_then(|state| state.vectors.as_ref())
    }

    /// The failure after which the processor took over, told once.
    pub fn take_device_fault(&mut self) -> Option<Error> {
        self.device_fault.take()
    }
}

/// Makes the device have `field`, in place of what it had of another state or size.
pub(super) fn bring<'a, T: Texel>(
    tiles: &'a mut Option<DeviceTiles<T>>,
    device: &Device,
    field: &Field<T>,
) -> Result<&'a DeviceTiles<T>> {
    Ok(match tiles.take() {
        Some(mut known) => {
            known.update(device, field)?;
            tiles.insert(known)
        }
        None => tiles.insert(DeviceTiles::new(device, field)?),
    })
}

impl DeviceObject {
    fn new(device: &Device, object: &DisplacedObject) -> Result<Self> {
        let surface = DeviceSurface::new(device, &object.surface)?;
        let tiles = DeviceTiles::new(device, object.displacement().field())?;
        let (coarse, sculpting, painting, half_painting) = ([None, None], None, None, None);
        Ok(Self {
            device: device.clone(),
            surface,
            tiles,
            ring: DeviceRing::new(device, object.surface.topology())?,
            turning: None,
            begun: None,
            coarse,
            vectors: None,
            begun_vectors: None,
            coarse_vectors: [None, None],
            bending: None,
            sculpting,
            painting,
            half_painting,
            culling: None,
            worked: None,
            posed: false,
        })
    }

    /// The device that it is on.
    pub fn device(&self) -> &Device {
        &self.device
    }

    /// Brings the surface to another pose.
    pub fn pose(&mut self, cage: &[[f32; 3]]) -> Result<()> {
        self.posed = true;
        self.surface.set_points(&self.device, cage)?;
        let mut frame = self.device.frame()?;
        self.surface.pose(&mut frame.pass("surface.patches"))?;
        let mut pass = frame.pass("surface.boxes");
        if let Some(brush) = &self.sculpting {
            brush.measure(&mut pass, &self.surface)?;
        }
        if let Some(brush) = &self.bending {
            brush.measure(&mut pass, &self.surface)?;
        }
        if let Some(brush) = self.painting.as_ref().and_then(|colors| colors.brush.as_ref()) {
            brush.measure(&mut pass, &self.surface)?;
        }
        if let Some(brush) = self.half_painting.as_ref().and_then(|colors| colors.brush.as_ref()) {
            brush.measure(&mut pass, &self.surface)?;
        }
        drop(pass);
        frame.submit().map(drop)
    }

    /// Makes the device have the displacement of `object`, whose state this is, and `start`, that of when a stroke began.
    pub(super) fn follow(&mut self, object: &DisplacedObject, start: Option<&Field>) -> Result<()> {
        self.tiles.update(&self.device, object.displacement().field())?;
        start.map_or(Ok(()), |start| bring(&mut self.begun, &self.device, start).map(drop))
    }

    /// As [`Self::follow`], with the vectors that there are.
    pub(super) fn follow_ground(&mut self, object: &DisplacedObject, start: Option<Ground<'_>>) -> Result<()> {
        self.follow(object, start.map(|start| start.heights))?;
        self.follow_vectors(object, start)
    }

    /// As [`Self::follow_ground`], of the vectors alone.
    pub(super) fn follow_vectors(&mut self, object: &DisplacedObject, start: Option<Ground<'_>>) -> Result<()> {
        let follow = |held: &mut Option<DeviceTiles<Vector>>, vectors: Option<&Field<Vector>>| match vectors {
            Some(vectors) => bring(held, &self.device, vectors).map(drop),
            None => {
                *held = None;
                Ok(())
            }
        };
        follow(&mut self.vectors, object.vectors.as_ref().map(|vectors| vectors.field()))?;
        start.map_or(Ok(()), |start| follow(&mut self.begun_vectors, start.vectors))
    }

    /// Makes ready for rings of vectors of `tiles` in the frames of `field`.
    pub(super) fn follow_frames(
        &mut self,
        context: &Context,
        field: &Field<Vector>,
        tiles: impl IntoIterator<Item = u32>,
    ) -> Result<()> {
        let mut ring = match self.turning.take().filter(|ring| ring.is_of(field)) {
            Some(ring) => ring,
            None => self.ring.framed(&self.device, field)?,
        };
        ring.turn(context, &self.device, tiles)?;
        self.turning = Some(ring);
        Ok(())
    }

    /// The displacement that places go by, which it was made to follow: that of the start if there is one.
    pub(super) fn ground<'a>(
        &'a self,
        object: &'a DisplacedObject,
        start: Option<Ground<'a>>,
    ) -> (DeviceGround<'a>, Ground<'a>) {
        match start.zip(self.begun.as_ref()) {
            Some((start, heights)) => (DeviceGround { heights, vectors: self.begun_vectors.as_ref() }, start),
            None => (DeviceGround { heights: &self.tiles, vectors: self.vectors.as_ref() }, object.ground()),
        }
    }

    /// The displacement that [`Self::follow`] was given as the start.
    pub(super) fn begun(&self) -> Option<&DeviceTiles> {
        self.begun.as_ref()
    }

    /// Makes ready to cull tiles of `object`, whose state this is.
    pub(super) fn prepare_culling(&mut self, object: &DisplacedObject) -> Result<()> {
        let (device, ground) = (&self.device, object.ground());
        let Ground { heights, vectors } = ground;
        match &mut self.culling {
            Some((culling, known, bent)) => {
                let mut changed = heights.differing(known);
                match (vectors, &*bent) {
                    (Some(vectors), Some(bent)) => changed.extend(vectors.differing(bent)),
                    (Some(some), None) => changed.extend(some.allocated()),
                    (None, Some(some)) => changed.extend(some.allocated()),
                    (None, None) => {}
                }
                culling.update(device, ground, &changed)?;
                if self.posed {
                    culling.pose(device, &object.surface)?;
                }
                (*known, *bent) = (heights.clone(), vectors.cloned());
            }
            none => {
                *none = Some((DeviceCull::new(device, &object.surface, ground)?, heights.clone(), vectors.cloned()))
            }
        }
        self.posed = false;
        Ok(())
    }

    /// What culls its tiles, after [`Self::prepare_culling`].
    pub(super) fn culling(&self) -> Result<&DeviceCull> {
        let ready = self.culling.as_ref().map(|(culling, ..)| culling);
        ready.ok_or_else(|| Error::internal("an object whose tiles are not ready to be culled"))
    }

    /// Makes ready to work on tiles of `object`, whose state this is. Returns the texels a side of the largest.
    pub(super) fn prepare_work(&mut self, object: &DisplacedObject) -> Result<u32> {
        let worked = WorkedTiles::ready(self.worked.take(), &self.device, object.displacement().field())?;
        Ok(self.worked.insert(worked).largest())
    }

    /// Notes that what culls its tiles knows their displacement.
    pub(super) fn settle_culling(&mut self) {
        if let Some((culling, ..)) = &mut self.culling {
            culling.settle();
        }
    }
}
