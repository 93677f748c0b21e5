//! Which tiles the box of a brush may reach, found on a graphics device (`shaders/brush/brush_bounds.wgsl`,
//! `brush_intersect.wgsl`).
//!
//! Schäfer, Keinert, Nießner and Stamminger 2015, *Local Painting and Deformation of Meshes on the GPU*, Section 3. All
//! tiles are looked at; nothing that has a point in the box is missed. How far tiles are displaced is kept, and renewed by
//! what changed. Units: object units.

use std::sync::Arc;

use relievo_core::{Error, Result};
use relievo_gpu::wgsl::brush::{BrushTile, Intersect};
use relievo_gpu::{Access, Bindings, Buffer, Device, GROUP, Kernel, KernelSpec, Pass, groups};
use relievo_surface::{DeviceSurface, SURFACE_GROUP};
use relievo_tiles::{Field, Texel, Vector};

use super::memory::DeviceMemory;
use crate::paint::ground::Ground;
use crate::paint::weights::BrushParameters;

/// Returns the work of a brush against so many tiles or triangles.
pub(super) fn work(brush: &BrushParameters, tiles: u32) -> Intersect {
    let ([row_x, row_y, row_z], [x, y, z, _]) = (brush.rows, brush.origin);
    Intersect { row_x, row_y, row_z, origin: [x, y, z], tiles }
}

/// Boxes of tiles, and how far they are displaced.
#[derive(Debug)]
pub(crate) struct DeviceIntersection<T> {
    bound: Arc<Kernel>,
    intersect: Arc<Kernel>,
    boxes: Buffer<[f32; 4]>,
    bounding: Bindings,
    tiles: Buffer<BrushTile>,
    /// What the device has of them.
    known: Vec<BrushTile>,
    /// The displacement that they are of, and the tiles whose sizes they have.
    seen: Option<(Field, Option<Field<Vector>>, Field<T>)>,
    buffers: Bindings,
}

impl<T: Texel> DeviceIntersection<T> {
    /// Boxes of so many `tiles`, which are to be measured first, and whose sets go to `memory`.
    pub fn new(device: &Device, tiles: usize, memory: &DeviceMemory) -> Result<Self> {
        use Access::{Read, Write};
        let bound = device.kernel(&KernelSpec {
            module: "brush_bounds",
            entry: "bound",
            groups: &[&[Write], &SURFACE_GROUP],
            immediates: size_of::<u32>() as u32,
            constants: &[],
        })?;
        let intersect = device.kernel(&KernelSpec {
            module: "brush_intersect",
            entry: "intersect",
            groups: &[&[Read, Read, Read, Read, Write], &SURFACE_GROUP],
            immediates: size_of::<Intersect>() as u32,
            constants: &[],
        })?;
        let boxes = Buffer::new(device, "boxes of tiles", 2 * tiles)?;
        let bounding = device.bind(&bound, 0, &[boxes.wgpu()])?;
        let known = vec![BrushTile { reach: 0.0, size: 0 }; tiles];
        let on_device = Buffer::of(device, "tiles of brushes", &known)?;
        let buffers = Self::bind(device, &intersect, (&boxes, &on_device), memory)?;
        Ok(Self { bound, intersect, boxes, bounding, tiles: on_device, known, seen: None, buffers })
    }

    fn bind(
        device: &Device,
        kernel: &Kernel,
        (boxes, tiles): (&Buffer<[f32; 4]>, &Buffer<BrushTile>),
        memory: &DeviceMemory,
    ) -> Result<Bindings> {
        let bound = [boxes.wgpu(), tiles.wgpu(), memory.pointers.wgpu(), memory.states.wgpu(), memory.masks.wgpu()];
        device.bind(kernel, 0, &bound)
    }

    /// Has sets go to another memory.
    pub fn rebind(&mut self, device: &Device, memory: &DeviceMemory) -> Result<()> {
        self.buffers = Self::bind(device, &self.intersect, (&self.boxes, &self.tiles), memory)?;
        Ok(())
    }

    /// What is known of tiles.
    pub fn tiles(&self) -> &relievo_gpu::wgpu::Buffer {
        self.tiles.wgpu()
    }

    /// Records the boxes of `surface` in its pose.
    pub fn measure(&self, pass: &mut Pass<'_>, surface: &DeviceSurface) -> Result<()> {
        let count = self.known.len() as u32;
        let size = groups(count.div_ceil(GROUP));
        pass.run(&self.bound, &[&self.bounding, surface.group()], bytemuck::bytes_of(&count), size)
    }

    /// Takes on how far tiles are displaced by `ground`, and the sizes of those of `field`. Returns the largest size where
    /// sizes may be others than before.
    pub fn update(&mut self, device: &Device, ground: Ground<'_>, field: &Field<T>) -> Result<Option<u32>> {
        let count = self.known.len();
        let Ground { heights, vectors } = ground;
        if [Some(heights.tile_count()), vectors.map(Field::tile_count), Some(field.tile_count())]
            .into_iter()
            .flatten()
            .any(|tiles| tiles != count)
        {
            return Err(Error::internal("another displacement than that of the boxes"));
        }
        let of = |tile: u32| {
            let [least, most] = heights.range(tile);
            let length = vectors.map_or(0.0, |vectors| vectors.length(tile));
            BrushTile { reach: most.max(-least).max(0.0) + length, size: field.size(tile) }
        };
        let before = self.seen.replace((heights.clone(), vectors.cloned(), field.clone()));
        let same_kind = |(_, before, sizes): &(_, Option<Field<Vector>>, _)| {
            field.has_sizes_of(sizes) && before.is_some() == vectors.is_some()
        };
        let Some((before, bent_before, _)) = before.filter(same_kind) else {
            self.known = (0..count as u32).map(of).collect();
            self.tiles.write(device, 0, &self.known)?;
            return Ok(self.known.iter().map(|tile| tile.size).max());
        };
        let bent = vectors.zip(bent_before.as_ref()).map(|(vectors, before)| vectors.touched(before));
        for tile in heights.touched(&before).chain(bent.into_iter().flatten()) {
            let new = of(tile);
            if std::mem::replace(&mut self.known[tile as usize], new) != new {
                self.tiles.write(device, tile as usize, &[new])?;
            }
        }
        Ok(None)
    }

    /// Records which sets tiles of `surface` are in for a brush.
    pub fn intersect(&self, pass: &mut Pass<'_>, surface: &DeviceSurface, brush: &BrushParameters) -> Result<()> {
        let tiles = self.known.len() as u32;
        let work = work(brush, tiles);
        let size = groups(tiles.div_ceil(GROUP));
        pass.run(&self.intersect, &[&self.buffers, surface.group()], bytemuck::bytes_of(&work), size)
    }
}
