//! Dabs that sculpt, evaluated on a graphics device (`shaders/brush_sculpt.wgsl`).
//!
//! The brush is evaluated at every texel of the tiles in its box by the device; new blocks come back, and what follows is
//! that of the processor: sets, memory, rings, history. So a stroke has the same undo and journal on either. Coefficients
//! are those of the processor up to one unit in the last place of a half float.

use std::sync::Arc;

use bytemuck::{Pod, Zeroable};
use half::f16;
use relievo_core::{Context, Error, Result};
use relievo_gpu::{Access, Buffer, Device, GROUP, Kernel, KernelSpec};
use relievo_surface::{DeviceSurface, SURFACE_GROUP};
use relievo_tiles::{DeviceTiles, Field, TILES_GROUP};

use crate::cull::CulledTile;
use crate::dab::Dab;
use crate::edit::TileEdit;
use crate::ground::Ground;
use crate::mode::SculptMode;
use crate::object::DisplacedObject;
use crate::weights::BrushParameters;

/// As in `brush_sculpt.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
struct Sculpt {
    row_x: [f32; 4],
    row_y: [f32; 4],
    row_z: [f32; 4],
    origin: [f32; 3],
    falloff: u32,
    strength: f32,
    height: f32,
    unit: f32,
    mode: u32,
    first: u32,
    room: u32,
    /// To the alignment of the rows.
    padding: [u32; 2],
}

/// Words of new blocks that are on their way at once.
const BATCH: usize = 1 << 22;

/// A brush on a device, with the surface of an object, as it is posed, and its displacement.
#[derive(Debug)]
pub(crate) struct DeviceBrush {
    device: Device,
    surface: DeviceSurface,
    tiles: DeviceTiles,
    /// The displacement from when the stroke began, once there is a stroke.
    begun: Option<DeviceTiles>,
    kernel: Arc<Kernel>,
}

impl DisplacedObject {
    /// Has dabs that sculpt evaluated on a graphics device from now on, or on the processor again. What a device does not
    /// do (stamps, vector displacement, edits at other levels, colours), the processor does.
    ///
    /// Fails, and changes nothing, where the device has no room for the object.
    pub fn use_device(&mut self, device: Option<&Device>) -> Result<()> {
        self.device = device.map(|device| DeviceBrush::new(device, self)).transpose()?;
        Ok(())
    }

    /// The failure after which the processor took over, told once.
    pub fn take_device_fault(&mut self) -> Option<Error> {
        self.device_fault.take()
    }

    /// The new blocks of the tiles that a dab changes, from the device; `None` if the processor is to make them.
    pub(crate) fn sculpt_on_device(
        &mut self,
        context: &Context,
        (dab, mode, height): (&Dab, SculptMode, f32),
        start: Option<Ground<'_>>,
        culled: &[CulledTile],
        brush: &BrushParameters,
    ) -> Option<Vec<TileEdit<f16>>> {
        if mode.needs_vectors() || self.vectors.is_some() || dab.brush.stamp().is_some() {
            return None;
        }
        let mut device = self.device.take()?;
        let start = start.map(|ground| ground.heights);
        let made = context.stats().time("dab.device", || device.evaluate(self, start, culled, brush, (mode, height)));
        match made {
            Ok(edits) => {
                self.device = Some(device);
                Some(edits)
            }
            Err(error) => {
                self.device_fault = Some(error);
                None
            }
        }
    }
}

impl DeviceBrush {
    fn new(device: &Device, object: &DisplacedObject) -> Result<Self> {
        let kernel = device.kernel(&KernelSpec {
            module: "brush_sculpt",
            entry: "edit",
            groups: &[
                &[Access::Read, Access::Read, Access::Write, Access::Write],
                &SURFACE_GROUP,
                &TILES_GROUP,
                &TILES_GROUP,
            ],
            immediates: size_of::<Sculpt>() as u32,
            constants: &[],
        })?;
        let surface = DeviceSurface::new(device, &object.surface)?;
        let tiles = DeviceTiles::new(device, object.displacement.field())?;
        Ok(Self { device: device.clone(), surface, tiles, begun: None, kernel })
    }

    /// Brings the surface to another pose.
    pub fn pose(&mut self, cage: &[[f32; 3]]) -> Result<()> {
        self.surface.set_points(&self.device, cage)?;
        let mut frame = self.device.frame()?;
        self.surface.pose(&mut frame.pass("surface.patches"))?;
        frame.submit().map(drop)
    }

    /// The new blocks of the tiles that change.
    fn evaluate(
        &mut self,
        object: &DisplacedObject,
        start: Option<&Field>,
        culled: &[CulledTile],
        brush: &BrushParameters,
        (mode, height): (SculptMode, f32),
    ) -> Result<Vec<TileEdit<f16>>> {
        let (device, field) = (&self.device, object.displacement.field());
        self.tiles.update(device, field)?;
        match (start, &mut self.begun) {
            (Some(start), Some(begun)) => drop(begun.update(device, start)?),
            (Some(start), begun) => *begun = Some(DeviceTiles::new(device, start)?),
            (None, _) => {}
        }
        let ground = self.begun.as_ref().filter(|_| start.is_some()).unwrap_or(&self.tiles);
        let tiles: Vec<u32> = culled.iter().map(|tile| tile.tile).collect();
        let sizes: Vec<u32> = tiles.iter().map(|tile| field.size(*tile)).collect();
        let Some(largest) = sizes.iter().max() else { return Ok(Vec::new()) };
        let room = ((largest + 2) * (largest + 2) / 2) as usize;
        let batch = (BATCH / room).clamp(1, tiles.len());
        let listed = Buffer::of(device, "culled tiles", &tiles)?;
        let measured = Buffer::of(device, "sizes of culled tiles", &sizes)?;
        let blocks = Buffer::<u32>::new(device, "new blocks", batch * room)?;
        let changes = Buffer::<u32>::new(device, "changed texels", batch)?;
        let buffers = [listed.wgpu(), measured.wgpu(), blocks.wgpu(), changes.wgpu()];
        let bound = device.bind(&self.kernel, 0, &buffers)?;
        let [row_x, row_y, row_z] = brush.rows;
        let [x, y, z, _] = brush.origin;
        let mut sculpt = Sculpt {
            row_x,
            row_y,
            row_z,
            origin: [x, y, z],
            falloff: brush.falloff,
            strength: brush.strength,
            height,
            unit: brush.unit(),
            mode: mode as u32,
            first: 0,
            room: room as u32,
            padding: [0; 2],
        };
        let mut edits = Vec::new();
        for first in (0..tiles.len()).step_by(batch) {
            let count = batch.min(tiles.len() - first);
            sculpt.first = first as u32;
            let mut frame = device.frame()?;
            frame.clear(&changes);
            let size = [count as u32, (room as u32).div_ceil(GROUP), 1];
            let groups = [&bound, self.surface.group(), ground.group(), self.tiles.group()];
            frame.pass("dab.evaluate").run(&self.kernel, &groups, bytemuck::bytes_of(&sculpt), size)?;
            let changed = frame.read(&changes, 0..count)?;
            let made = frame.read(&blocks, 0..count * room)?;
            let _ = frame.submit()?;
            let (changed, made) = (changed.get(device)?, made.get(device)?);
            for (slot, count) in changed.iter().enumerate().filter(|(_, count)| **count > 0) {
                let tile = tiles[first + slot];
                let texels = &bytemuck::cast_slice::<u32, f16>(&made[slot * room..])[..field.class(tile).texels()];
                edits.push(TileEdit { tile, texels: texels.into(), count: u64::from(*count) });
            }
        }
        Ok(edits)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::brush::Brush;
    use crate::dab::Action;
    use crate::falloff::Falloff;
    use crate::path::StrokePoint;
    use crate::stroke::{Stroke, StrokeSettings};
    use glam::{DAffine3, DMat3, DVec3};
    use relievo_surface::{Surface, SurfaceOptions};
    use relievo_testing::wgsl::assert_layout;
    use relievo_testing::{device, grid};
    use relievo_tiles::{Displacement, DisplacementOptions};
    use std::mem::offset_of;

    #[test]
    fn the_layout_is_that_of_the_kernel() {
        let fields = [
            ("row_x", offset_of!(Sculpt, row_x)),
            ("row_y", offset_of!(Sculpt, row_y)),
            ("row_z", offset_of!(Sculpt, row_z)),
            ("origin", offset_of!(Sculpt, origin)),
            ("falloff", offset_of!(Sculpt, falloff)),
            ("strength", offset_of!(Sculpt, strength)),
            ("height", offset_of!(Sculpt, height)),
            ("unit", offset_of!(Sculpt, unit)),
            ("mode", offset_of!(Sculpt, mode)),
            ("first", offset_of!(Sculpt, first)),
            ("room", offset_of!(Sculpt, room)),
        ];
        assert_layout("brush_sculpt", "Sculpt", size_of::<Sculpt>(), &fields);
    }

    fn object(context: &Context) -> DisplacedObject {
        let mesh = grid(6, true, &[2, 3, 2, 1], false);
        let surface = Surface::new(context, &mesh, &SurfaceOptions::default()).unwrap();
        let options = DisplacementOptions { size: 32, face_sizes: vec![(3, 64), (8, 8)], ..Default::default() };
        let displacement = Displacement::new(surface.topology().clone(), &options).unwrap();
        let turn = DAffine3::from_scale_rotation_translation(
            DVec3::splat(1.5),
            glam::DQuat::from_rotation_y(0.4),
            DVec3::new(0.3, -1.0, 2.0),
        );
        DisplacedObject::new(context, surface, &mesh.points, displacement, turn).unwrap()
    }

    /// Coefficients of two objects: how many differ, and the largest difference in steps of half floats.
    fn difference(a: &DisplacedObject, b: &DisplacedObject) -> (usize, i32) {
        let (a, b) = (a.displacement.field(), b.displacement.field());
        let tiles = |field: &relievo_tiles::Field| field.allocated().collect::<Vec<_>>();
        assert_eq!(tiles(a), tiles(b), "the tiles that are allocated");
        // Half floats in order, so that neighbours are one apart.
        let order = |half: f16| {
            let bits = i32::from(half.to_bits());
            if bits & 0x8000 == 0 { bits } else { 0x8000 - bits }
        };
        let pairs = tiles(a).into_iter().flat_map(|tile| a.block(tile).unwrap().iter().zip(b.block(tile).unwrap()));
        pairs.fold((0, 0), |(count, most), (a, b)| {
            let apart = (order(*a) - order(*b)).abs();
            (count + usize::from(apart > 0), most.max(apart))
        })
    }

    #[test]
    fn dabs_of_a_device_are_those_of_the_processor() {
        let Some(device) = device() else { return };
        let context = Context::serial();
        let modes = [
            (SculptMode::Draw, 0.2),
            (SculptMode::Smooth, 0.0),
            (SculptMode::Flatten, 0.0),
            (SculptMode::Erase, 0.0),
            (SculptMode::Clay, 0.1),
            (SculptMode::Scrape, 0.0),
            (SculptMode::Layer, -0.1),
            (SculptMode::Inflate, 0.05),
        ];
        let (mut differing, mut changed) = (0, 0);
        for (falloff, _) in Falloff::NAMES {
            for (mode, height) in modes {
                // Something to begin with, the same for both.
                let (mut here, mut there) = (object(&context), object(&context));
                let place = here.transform.transform_point3(DVec3::new(3.6, 0.4, 0.6));
                let axes = DMat3::from_euler(glam::EulerRot::XYZ, 0.3, 1.2, 0.1);
                let dab = |mode, height, size, falloff| Dab {
                    brush: Brush::new(place, axes, DVec3::splat(size), falloff).unwrap(),
                    action: Action::Sculpt { mode, height },
                    strength: 0.8,
                };
                let base = dab(SculptMode::Draw, 0.15, 1.2, Falloff::Gaussian);
                for object in [&mut here, &mut there] {
                    base.apply(&context, object).unwrap();
                }
                there.use_device(Some(&device)).unwrap();
                for size in [1.0, 1.7] {
                    let dab = dab(mode, height, size, falloff);
                    let expected = dab.apply(&context, &mut here).unwrap();
                    let found = dab.apply(&context, &mut there).unwrap();
                    assert_eq!(found.changed, expected.changed, "{mode:?} {falloff:?}");
                    let (differ, apart) = difference(&here, &there);
                    assert!(
                        apart <= 1 || mode == SculptMode::Inflate && apart <= 8,
                        "{mode:?} {falloff:?}: {apart} steps"
                    );
                    differing += differ;
                    changed += expected.changed_texels as usize;
                }
            }
        }
        println!("{differing} of {changed} coefficients differ");
        assert!(differing * 100 < changed, "{differing} of {changed} coefficients differ");
    }

    #[test]
    fn strokes_of_a_device_are_those_of_the_processor() {
        let Some(device) = device() else { return };
        let context = Context::serial();
        for (mode, height) in [(SculptMode::Draw, 0.1), (SculptMode::Layer, 0.1), (SculptMode::Clay, 0.05)] {
            let [mut here, mut there] = [object(&context), object(&context)];
            there.use_device(Some(&device)).unwrap();
            // A pose that was made on the device.
            let cage: Vec<[f32; 3]> = grid(6, true, &[2, 3, 2, 1], false).points;
            let cage: Vec<_> = cage.iter().map(|p| [p[0], p[1] + 0.1 * p[0], 1.2 * p[2]]).collect();
            for object in [&mut here, &mut there] {
                object.pose(&context, &cage).unwrap();
            }
            let points = (0..5).map(|k| {
                let place = DVec3::new(3.4, 0.34 + 0.3 * f64::from(k), 0.6);
                StrokePoint::new(here.transform.transform_point3(place), 1.0)
            });
            let settings = StrokeSettings { radius: 0.9, spacing: 0.5, ..StrokeSettings::default() };
            let stroke = Stroke::new(points.collect(), settings, Falloff::Smooth, Action::Sculpt { mode, height });
            for _ in 0..2 {
                let expected = stroke.apply(&context, &mut here).unwrap();
                let found = stroke.apply(&context, &mut there).unwrap();
                assert_eq!((found.dabs, found.missed), (expected.dabs, expected.missed));
                assert!(expected.report.changed_texels > 1000, "{expected:?}");
                assert_eq!(found.report.changed, expected.report.changed);
            }
            let (differ, apart) = difference(&here, &there);
            println!("{mode:?}: {differ} coefficients of strokes differ, by {apart} steps at most");
            assert!(apart <= 4, "{mode:?}: {apart} steps");
            assert!(there.take_device_fault().is_none());
        }
    }

    #[test]
    fn the_processor_takes_over_from_a_lost_device() {
        let Some(device) = device() else { return };
        let context = Context::serial();
        let [mut here, mut there] = [object(&context), object(&context)];
        there.use_device(Some(&device)).unwrap();
        let place = here.transform.transform_point3(DVec3::new(3.6, 0.4, 0.6));
        let dab = Dab {
            brush: Brush::new(place, DMat3::IDENTITY, DVec3::ONE, Falloff::Smooth).unwrap(),
            action: Action::Sculpt { mode: SculptMode::Draw, height: 0.1 },
            strength: 1.0,
        };
        device.abandon();
        for object in [&mut here, &mut there] {
            assert!(!dab.apply(&context, object).unwrap().changed.is_empty());
        }
        assert_eq!(difference(&here, &there), (0, 0));
        let fault = there.take_device_fault().expect("it is told");
        assert_eq!(fault.kind, relievo_core::ErrorKind::Device, "{fault}");
        assert!(there.take_device_fault().is_none(), "once");
    }
}
