//! Scalar displacement and colours on a graphics device, and the surface displaced by the one (`shaders/tiles`).
//!
//! The blocks of a field are copied to one heap on the device, by what changed since the last time. As on the processor a
//! block keeps its room until its tile is freed or has another size, and freed room is taken again, last in, first out
//! (Schäfer et al. 2015, *Local Painting and Deformation of Meshes on the GPU*, Section 4).

pub(crate) mod mips;
pub(crate) mod ring;

use std::sync::Arc;

use half::f16;
use relievo_core::{Error, Result};
use relievo_gpu::wgsl::tiles::TileEntry;
use relievo_gpu::{Access, Bindings, Buffer, Device, Frame, GROUP, Kernel, KernelSpec, Pass, groups, wgpu};
use relievo_surface::{DeviceSurface, Place, SURFACE_GROUP};

use crate::device::ring::{BoundRing, DeviceRing};
use crate::quads::field::Field;
use crate::store::heap::{CLASS_COUNT, SizeClass};
use crate::texel::Texel;

/// What kernels that import `tiles` have as their group 2.
pub const TILES_GROUP: [Access; 2] = [Access::Read; 2];

/// The first word of a tile without a block.
const NONE: u32 = u32::MAX;

/// The tiles of a surface on a device: scalar displacement, or colours.
#[derive(Debug)]
pub struct DeviceTiles<T: Texel = f16> {
    /// What the device has.
    field: Field<T>,
    entries: Vec<TileEntry>,
    /// Where there is room for blocks, by class.
    free: [Vec<u32>; CLASS_COUNT],
    /// Words in use, freed ones among them.
    end: u32,
    on_device: Buffer<TileEntry>,
    texels: Buffer<u32>,
    kernel: Arc<Kernel>,
    group: Bindings,
}

/// The displaced surface at the places of a buffer.
#[derive(Debug)]
pub struct DisplacedEvaluation {
    buffers: Bindings,
    places: usize,
}

/// Words of a block of this class. Sides are even: blocks are whole words.
fn words<T>(class: SizeClass) -> u32 {
    (class.texels() * size_of::<T>() / 4) as u32
}

impl<T: Texel> DeviceTiles<T> {
    /// Brings `field` to a device.
    ///
    /// # Errors
    /// Fails where the device is lost or has no room for it, or a block is on a page that cannot be read.
    pub fn new(device: &Device, field: &Field<T>) -> Result<Self> {
        let tiles = field.tile_count();
        let entries = vec![TileEntry { first: NONE, size: 0 }; tiles];
        let on_device = Buffer::of(device, "tiles", &entries)?;
        let needed: u64 = field.allocated().map(|tile| u64::from(words::<T>(field.class(tile)))).sum();
        let texels = Buffer::new(device, "tile blocks", needed.max(1) as usize)?;
        let kernel = device.kernel(&KernelSpec {
            module: "tiles_evaluate",
            entry: "evaluate",
            groups: &[&[Access::Read, Access::Write], &SURFACE_GROUP, &TILES_GROUP],
            immediates: size_of::<u32>() as u32,
            constants: &[],
        })?;
        let group = device.bind(&kernel, 2, &[on_device.wgpu(), texels.wgpu()])?;
        let blank = field.like(field.classes().to_vec(), field.blank(), Vec::new());
        let free = std::array::from_fn(|_| Vec::new());
        let mut made = Self { field: blank, entries, free, end: 0, on_device, texels, kernel, group };
        let all: Vec<u32> = field.allocated().collect();
        made.take(device, field, &all)?;
        Ok(made)
    }

    /// Makes the device have what `field` has, a later or earlier state of the same channel. Returns the tiles that
    /// were written or freed, ascending.
    ///
    /// # Errors
    /// Fails as [`Self::new`], and for the field of another cage.
    pub fn update(&mut self, device: &Device, field: &Field<T>) -> Result<Vec<u32>> {
        self.check(field)?;
        let changed = field.differing(&self.field);
        self.take(device, field, &changed)?;
        Ok(changed)
    }

    /// As [`Self::update`] after an edit whose texels are on the device: `written` tells of tiles from which word of `from`
    /// on their blocks are there, rings left out. Those of all others that differ are what neighbours make them, so that
    /// nothing comes from the processor. The rings are those of [`crate::device::ring`], which says how equal they are to
    /// `field`'s.
    ///
    /// # Errors
    /// Fails as [`Self::follow_with`], and with [`ErrorKind::Internal`](relievo_core::ErrorKind) if `from` ends before
    /// a block that `written` names.
    pub fn follow(
        &mut self,
        device: &Device,
        ring: &DeviceRing,
        field: &Field<T>,
        (written, from): (&[(u32, u32)], &Buffer<u32>),
    ) -> Result<Vec<u32>> {
        self.follow_with(device, ring, field, |frame, tiles| {
            let there = |(tile, _): &&(u32, u32)| tiles.entries[*tile as usize].first != NONE;
            written.iter().filter(there).try_for_each(|(tile, first)| {
                let (first, words) = (*first as usize, words::<T>(field.class(*tile)) as usize);
                let to = tiles.entries[*tile as usize].first as usize;
                frame.copy(from, first..first + words, &tiles.texels, to)
            })
        })
    }

    /// As [`Self::follow`], of an edit whose texels `write` records, rings left out, where this has the tiles of `field`:
    /// blocks that it had not before are blank.
    ///
    /// # Errors
    /// Fails for the field of another cage, with the error of `write`, if `ring` is not one for these texels, and where
    /// the device is lost or has no room.
    pub fn follow_with(
        &mut self,
        device: &Device,
        ring: &DeviceRing,
        field: &Field<T>,
        write: impl FnOnce(&mut Frame, &Self) -> Result<()>,
    ) -> Result<Vec<u32>> {
        self.check(field)?;
        let changed = field.differing(&self.field);
        let fresh = self.place(device, field, &changed)?;
        let there: Vec<u32> = changed.iter().copied().filter(|tile| field.is_allocated(*tile)).collect();
        let mut frame = device.frame()?;
        self.record(device, &mut frame, ring, &fresh, |bound, pass, work| {
            ring.clear(pass, bound, field.blank(), work)
        })?;
        write(&mut frame, self)?;
        self.record(device, &mut frame, ring, &there, |bound, pass, work| {
            ring.update(pass, bound, field.blank(), work)
        })?;
        let _ = frame.submit()?;
        self.field = field.clone();
        Ok(changed)
    }

    /// Records what `run` does with a list of tiles of this, how many they are and how large the largest is.
    fn record(
        &self,
        device: &Device,
        frame: &mut Frame,
        ring: &DeviceRing,
        tiles: &[u32],
        run: impl Fn(&BoundRing, &mut Pass<'_>, (u32, u32)) -> Result<()>,
    ) -> Result<()> {
        let count = tiles.len() as u32;
        let Some(size) = tiles.iter().map(|tile| self.entries[*tile as usize].size).max() else { return Ok(()) };
        let listed = Buffer::of(device, "tiles whose rings change", tiles)?;
        let counts = Buffer::of(device, "how many they are", &[count])?;
        let bound = ring.bind(device, self, (listed.wgpu(), counts.wgpu()), None)?;
        run(&bound, &mut frame.pass("tiles.ring"), (count, size))
    }

    fn check(&self, field: &Field<T>) -> Result<()> {
        if field.tile_count() == self.entries.len() {
            return Ok(());
        }
        let what = format!("a field of {} tiles on one of {}", field.tile_count(), self.entries.len());
        Err(Error::invalid(what).advise("give the field of the same surface"))
    }

    /// Gives the changed `tiles` the room that they have in `field`. Returns the tiles that had none of that size
    /// before.
    fn place(&mut self, device: &Device, field: &Field<T>, tiles: &[u32]) -> Result<Vec<u32>> {
        // Freed blocks first, so that others find their room.
        for tile in tiles {
            let entry = &mut self.entries[*tile as usize];
            let stays = field.is_allocated(*tile) && field.size(*tile) == entry.size;
            if entry.first != NONE && !stays {
                self.free[SizeClass::of(entry.size)?.index()].push(entry.first);
                *entry = TileEntry { first: NONE, size: 0 };
            }
        }
        let mut fresh = Vec::new();
        for tile in tiles.iter().filter(|tile| field.is_allocated(**tile)) {
            let class = field.class(*tile);
            let entry = &mut self.entries[*tile as usize];
            if entry.first == NONE {
                let first = self.free[class.index()].pop();
                let end = self.end.checked_add(words::<T>(class));
                let first = match (first, end) {
                    (Some(first), _) => first,
                    (None, Some(end)) => std::mem::replace(&mut self.end, end),
                    (None, None) => return Err(Error::memory("the tiles are too large for a graphics device")),
                };
                *entry = TileEntry { first, size: class.size() };
                fresh.push(*tile);
            }
        }
        self.grow(device)?;
        tiles
            .iter()
            .try_for_each(|tile| self.on_device.write(device, *tile as usize, &[self.entries[*tile as usize]]))?;
        Ok(fresh)
    }

    fn take(&mut self, device: &Device, field: &Field<T>, tiles: &[u32]) -> Result<()> {
        self.place(device, field, tiles)?;
        for tile in tiles {
            if let Some(block) = field.try_block(*tile)? {
                let bytes: &[u8] = bytemuck::cast_slice(block);
                let word = |bytes: &[u8]| bytes.iter().rev().fold(0, |word, byte| word << 8 | u32::from(*byte));
                let words: Vec<u32> = bytes.chunks_exact(4).map(word).collect();
                self.texels.write(device, self.entries[*tile as usize].first as usize, &words)?;
            }
        }
        self.field = field.clone();
        Ok(())
    }

    /// Makes room for all words in use, with half as much again, and moves what is there.
    fn grow(&mut self, device: &Device) -> Result<()> {
        let (old, needed) = (self.texels.len(), self.end as usize);
        if needed <= old {
            return Ok(());
        }
        let texels = Buffer::new(device, "tile blocks", needed + needed / 2)?;
        let mut frame = device.frame()?;
        frame.copy(&self.texels, 0..old, &texels, 0)?;
        let _ = frame.submit()?;
        self.group = device.bind(&self.kernel, 2, &[self.on_device.wgpu(), texels.wgpu()])?;
        self.texels = texels;
        Ok(())
    }

    /// What is bound as group 2 of kernels that import `tiles`. An update may replace it.
    pub fn group(&self) -> &Bindings {
        &self.group
    }

    /// The blocks of all tiles as the device has them, ascending.
    ///
    /// # Errors
    /// Fails where the device is lost or has no memory.
    pub fn read_back(&self, device: &Device) -> Result<Vec<(u32, Vec<T>)>> {
        let mut frame = device.frame()?;
        let back = frame.read(&self.texels, 0..self.texels.len())?;
        let _ = frame.submit()?;
        let words = back.get(device)?;
        let bytes: &[u8] = bytemuck::cast_slice(&words);
        let block = |tile: u32| {
            let (first, texels) = (4 * self.entries[tile as usize].first as usize, self.field.class(tile).texels());
            (tile, bytemuck::pod_collect_to_vec(&bytes[first..][..texels * size_of::<T>()]))
        };
        Ok(self.field.allocated().map(block).collect())
    }

    /// The block of a tile as the device has it, if it has one.
    ///
    /// # Errors
    /// Fails where the device is lost or has no memory.
    pub fn read(&self, device: &Device, tile: u32) -> Result<Option<Vec<T>>> {
        let entry = self.entries.get(tile as usize).filter(|entry| entry.first != NONE);
        entry.map(|entry| read_texels(device, &self.texels, entry.first, self.field.class(tile).texels())).transpose()
    }

    /// The state that the device has.
    pub fn field(&self) -> &Field<T> {
        &self.field
    }

    /// The buffers of [`Self::group`] in the order of their bindings, for pipelines that draw.
    pub fn buffers(&self) -> [&wgpu::Buffer; 2] {
        [self.on_device.wgpu(), self.texels.wgpu()]
    }

    /// Bytes of the blocks' room on the device.
    pub fn bytes(&self) -> u64 {
        4 * self.texels.len() as u64
    }
}

/// So many texels from word `first` of `words` on. Fails where the device does.
pub(crate) fn read_texels<T: Texel>(device: &Device, words: &Buffer<u32>, first: u32, texels: usize) -> Result<Vec<T>> {
    let first = first as usize;
    let mut frame = device.frame()?;
    let back = frame.read(words, first..first + texels * size_of::<T>() / 4)?;
    let _ = frame.submit()?;
    Ok(bytemuck::pod_collect_to_vec(bytemuck::cast_slice::<u32, u8>(&back.get(device)?)))
}

impl DeviceTiles {
    /// The evaluation of the displaced surface at `places`, in the very tiles that they name: position and unit normal,
    /// six numbers each. Places must be on the surface; of a tile that does not exist, zeros come out.
    ///
    /// # Errors
    /// Fails if `points` has fewer than six numbers a place, and where the device is lost or has no memory.
    pub fn evaluation(
        &self,
        device: &Device,
        places: &Buffer<Place>,
        points: &Buffer<f32>,
    ) -> Result<DisplacedEvaluation> {
        let needed = 6 * places.len();
        if points.len() < needed {
            return Err(Error::internal(format!("room for {} of {needed} numbers of points", points.len())));
        }
        let buffers = device.bind(&self.kernel, 0, &[places.wgpu(), points.wgpu()])?;
        Ok(DisplacedEvaluation { buffers, places: places.len() })
    }

    /// Records an evaluation at the first `count` places of `surface` displaced by this.
    ///
    /// # Errors
    /// Fails with [`ErrorKind::Internal`](relievo_core::ErrorKind) if the command does not fit the kernel; what the
    /// device refuses comes back where the frame is submitted.
    pub fn evaluate(
        &self,
        pass: &mut Pass<'_>,
        surface: &DeviceSurface,
        evaluation: &DisplacedEvaluation,
        count: u32,
    ) -> Result<()> {
        let count = count.min(evaluation.places as u32);
        let bound = [&evaluation.buffers, surface.group(), &self.group];
        pass.run(&self.kernel, &bound, bytemuck::bytes_of(&count), groups(count.div_ceil(GROUP)))
    }
}
