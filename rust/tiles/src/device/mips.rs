//! The mips of colours on a graphics device, made there from the tiles that it has (`shaders/tiles/ring.wgsl`).
//!
//! Schäfer, Keinert, Nießner and Stamminger 2015, *Local Painting and Deformation of Meshes on the GPU*, Section 5, with the
//! rules of [`crate::quads::mip`]: levels of half, a quarter, … of a tile's texels a side, down to two, each with its own ring.
//! Means of 8 bits are the processor's to the bit, by the same tables: it adds whole numbers, and what each level rounds
//! would else add up. Rings are its within 1/255.

use relievo_core::{Error, Result};
use relievo_gpu::{Buffer, Device, wgpu};

use crate::device::ring::DeviceRing;
use crate::device::{DeviceTiles, read_texels};
use crate::quads::channel::neighbours;
use crate::quads::field::Field;
use crate::store::heap::{CLASS_COUNT, MAX_SIZE, SizeClass};
use crate::texel::Texel;

/// Mips on a device. Of every tile its levels follow one another, finest first, row by row with their rings.
#[derive(Debug)]
pub struct DeviceMips<T: Texel> {
    /// That whose mips the device has.
    field: Option<Field<T>>,
    firsts: Vec<u32>,
    sizes: Vec<[u32; 2]>,
    pointers: Buffer<u32>,
    sizes_there: Buffer<[u32; 2]>,
    /// Where there is room, by class.
    free: [Vec<u32>; CLASS_COUNT],
    /// Words in use, freed ones among them.
    end: u32,
    mips: Buffer<u32>,
}

/// The word of a tile without mips.
const NONE: u32 = u32::MAX;

impl<T: Texel> DeviceMips<T> {
    /// The mips of `tiles`, by the rules of `ring`.
    ///
    /// # Errors
    /// Fails if `ring` is not one for the texels of `tiles`, and where the device is lost or has no room.
    pub fn new(device: &Device, ring: &DeviceRing, tiles: &DeviceTiles<T>) -> Result<Self> {
        let count = tiles.field().tile_count();
        let (firsts, sizes) = (vec![NONE; count], vec![[0; 2]; count]);
        let mut made = Self {
            field: None,
            pointers: Buffer::of(device, "mips of tiles", &firsts)?,
            sizes_there: Buffer::of(device, "sizes of tiles", &sizes)?,
            firsts,
            sizes,
            free: std::array::from_fn(|_| Vec::new()),
            end: 0,
            mips: Buffer::new(device, "mips", 1)?,
        };
        made.update(device, ring, tiles)?;
        Ok(made)
    }

    /// Brings the mips up to date with `tiles`, of the same surface.
    ///
    /// # Errors
    /// Fails if `tiles` are those of another surface, `ring` is not one for their texels, or the device is lost or has
    /// no room.
    pub fn update(&mut self, device: &Device, ring: &DeviceRing, tiles: &DeviceTiles<T>) -> Result<()> {
        let field = tiles.field();
        if field.tile_count() != self.firsts.len() {
            return Err(Error::internal("mips of the tiles of another surface"));
        }
        let all = || field.allocated().collect();
        let mut changed: Vec<u32> = self.field.as_ref().map_or_else(all, |known| field.differing(known));
        let resized = self.field.as_ref().is_none_or(|known| !field.has_sizes_of(known));
        if resized {
            self.sizes = (0..field.tile_count() as u32).map(|tile| [0, field.size(tile)]).collect();
            self.sizes_there.write(device, 0, &self.sizes)?;
        }
        self.place(device, field, &changed)?;
        let topology = field.topology();
        let mut around: Vec<u32> = changed.iter().flat_map(|tile| neighbours(topology, *tile)).collect();
        if resized {
            around.extend(field.allocated());
        }
        around.sort_unstable();
        around.dedup();
        around.retain(|tile| field.is_allocated(*tile));
        changed.retain(|tile| field.is_allocated(*tile));
        self.make(device, ring, tiles, &changed, &around)?;
        self.field = Some(field.clone());
        Ok(())
    }

    /// Gives the changed tiles the room that they need in `field`.
    fn place(&mut self, device: &Device, field: &Field<T>, changed: &[u32]) -> Result<()> {
        let class_before = |tile: u32| self.field.as_ref().map(|known| known.class(tile));
        for tile in changed {
            let at = *tile as usize;
            let stays = field.is_allocated(*tile) && class_before(*tile) == Some(field.class(*tile));
            if let Some(class) = class_before(*tile).filter(|_| self.firsts[at] != NONE && !stays) {
                self.free[class.index()].push(std::mem::replace(&mut self.firsts[at], NONE));
            }
        }
        for tile in changed.iter().filter(|tile| field.is_allocated(**tile)) {
            let class = field.class(*tile);
            if self.firsts[*tile as usize] == NONE {
                let end = u32::try_from(words::<T>(class)).ok().and_then(|words| self.end.checked_add(words));
                let end = end.ok_or_else(|| Error::memory("the mips are too large for a graphics device"))?;
                let freed = self.free[class.index()].pop();
                self.firsts[*tile as usize] = freed.unwrap_or_else(|| std::mem::replace(&mut self.end, end));
            }
        }
        let needed = self.end as usize;
        if needed > self.mips.len() {
            let mips = Buffer::new(device, "mips", needed + needed / 2)?;
            let mut frame = device.frame()?;
            frame.copy(&self.mips, 0..self.mips.len(), &mips, 0)?;
            let _ = frame.submit()?;
            self.mips = mips;
        }
        changed.iter().try_for_each(|tile| {
            self.pointers.write(device, *tile as usize, &self.firsts[*tile as usize..=*tile as usize])
        })
    }

    /// Makes the levels of `changed` anew, and the rings of those of `around`.
    fn make(
        &self,
        device: &Device,
        ring: &DeviceRing,
        tiles: &DeviceTiles<T>,
        changed: &[u32],
        around: &[u32],
    ) -> Result<()> {
        let (blank, largest) = (tiles.field().blank(), |list: &[u32]| list.iter().map(|tile| self.size(*tile)).max());
        let mut frame = device.frame()?;
        let mut pass = frame.pass("tiles.mips");
        let of = |list: &[u32]| -> Result<_> {
            let listed = Buffer::of(device, "tiles whose mips change", list)?;
            let counts = Buffer::of(device, "how many they are", &[list.len() as u32])?;
            let worked = (&self.pointers, &self.mips, self.sizes_there.wgpu());
            ring.bind_mips(device, tiles, (listed.wgpu(), counts.wgpu()), worked)
        };
        if let Some(size) = largest(changed) {
            let bound = of(changed)?;
            for level in 1..size.ilog2() {
                ring.make_mips(&mut pass, &bound, blank, level, (changed.len() as u32, size >> level))?;
            }
        }
        if let Some(size) = largest(around) {
            let bound = of(around)?;
            for density in (1..=MAX_SIZE.ilog2()).map(|power| 1 << power) {
                ring.update_mips(&mut pass, &bound, blank, density, (around.len() as u32, size.min(density)))?;
            }
        }
        drop(pass);
        frame.submit().map(drop)
    }

    fn size(&self, tile: u32) -> u32 {
        self.sizes[tile as usize][1]
    }

    /// The first word of every tile's mips, or `u32::MAX`, and their words, for pipelines that look up colours.
    pub fn buffers(&self) -> [&wgpu::Buffer; 2] {
        [self.pointers.wgpu(), self.mips.wgpu()]
    }

    /// Level `level` of a tile, from 1, if it has that.
    ///
    /// # Errors
    /// Fails where the device is lost or has no memory.
    pub fn read(&self, device: &Device, tile: u32, level: u32) -> Result<Option<Vec<T>>> {
        let first = self.firsts.get(tile as usize).copied().filter(|first| *first != NONE);
        let Some((field, first)) = self.field.as_ref().zip(first) else { return Ok(None) };
        let class = field.class(tile);
        if level == 0 || level > class.mips() {
            return Ok(None);
        }
        let before = (class.level_start(level) * size_of::<T>() / 4) as u32;
        let side = (class.size() >> level) as usize + 2;
        read_texels(device, &self.mips, first + before, side * side).map(Some)
    }

    /// All levels of the tiles that have some, ascending.
    ///
    /// # Errors
    /// Fails where the device is lost or has no memory.
    pub fn read_back(&self, device: &Device) -> Result<Vec<(u32, Vec<T>)>> {
        let mut frame = device.frame()?;
        let back = frame.read(&self.mips, 0..self.mips.len())?;
        let _ = frame.submit()?;
        let words = back.get(device)?;
        let bytes: &[u8] = bytemuck::cast_slice(&words);
        let Some(field) = &self.field else { return Ok(Vec::new()) };
        let of = |tile: u32| {
            let (first, texels) = (4 * self.firsts[tile as usize] as usize, field.class(tile).mip_texels());
            (tile, bytemuck::pod_collect_to_vec(&bytes[first..][..texels * size_of::<T>()]))
        };
        Ok(field.allocated().map(of).collect())
    }
}

/// Words of the mips of a tile of this class.
fn words<T>(class: SizeClass) -> usize {
    (class.mip_texels() * size_of::<T>()).div_ceil(4)
}
