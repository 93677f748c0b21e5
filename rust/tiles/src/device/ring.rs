//! The ring update on a graphics device (`shaders/tiles`).
//!
//! Schäfer, Keinert, Nießner, Buchenau, Guthe and Stamminger 2014, *Real-Time Deformation of Subdivision Surfaces from
//! Object Collisions*, Section 6, with the rules of [`crate::quads::ring`], for displacement and for colours. What is copied is the
//! same to the bit, and so are vectors that are turned into the frame of a neighbour, averages at vertices, and mips of 8
//! bits; what lies between tiles of different density is the processor's up to one unit in the last place of a half float,
//! or 2⁻²² of the largest number that it is made of, colours of 8 bits within 1/255.

use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};

use relievo_core::{Context, Error, Result};
use relievo_gpu::wgsl::ring_tiles::Ring;
use relievo_gpu::{Access, Bindings, Buffer, Device, GROUP, Kernel, KernelSpec, Pass, wgpu};
use relievo_surface::{Link, RingClass, TileTopology};

use crate::device::DeviceTiles;
use crate::quads::field::Field;
use crate::quads::frame::{Frames, TURN_NUMBERS};
use crate::texel::{Texel, Vector, mean_tables};

/// Blocks that are worked on, in place of those of the tiles that have one.
#[derive(Clone, Copy, Debug)]
pub struct WorkedBlocks<'a> {
    /// The block of every tile, or `u32::MAX`.
    pub pointers: &'a Buffer<u32>,
    /// Words of the blocks.
    pub blocks: &'a Buffer<u32>,
    /// Of every tile two words, of which the second is how many texels a side it has or would have.
    pub sizes: &'a wgpu::Buffer,
    /// Words of a block.
    pub room: u32,
}

/// What a ring update is bound to.
#[derive(Debug)]
pub struct BoundRing {
    bindings: Bindings,
    room: Option<u32>,
}

/// Workgroups that a dispatch has along one dimension at most.
const ROW: u32 = 32_768;

/// Kernels in the order in which they run, the one that makes blocks blank, and the one of mips.
const ENTRIES: [&str; 5] = ["make_vertices", "settle_borders", "make_rings", "make_blank", "make_mips"];
const BLANK: usize = 3;
const MIPS: usize = 4;

/// The format of vectors, which have kernels of their own.
const FRAMED: u32 = 3;

/// The ring update of the tiles of one cage: of vectors, or of all other texels.
#[derive(Debug)]
pub struct DeviceRing {
    kernels: Vec<Arc<Kernel>>,
    topology: Arc<Buffer<u32>>,
    vertices: Buffer<u32>,
    /// The frames of vectors and their tiles, and the turns between them, see [`Frames::packed`], of which those of some
    /// tiles are there; anything for other texels.
    frames: Option<(Arc<Frames>, Arc<TileTopology>)>,
    turns: Buffer<f32>,
    turned: Vec<bool>,
    /// Where rings and entries begin in the topology.
    rings: u32,
    entries: u32,
    runs: AtomicU32,
    /// What is bound where no blocks are worked on.
    none: Buffer<u32>,
    unused: Buffer<u32>,
}

impl DeviceRing {
    /// For tiles of `topology` whose texels are no vectors.
    ///
    /// # Errors
    /// Fails where the device is lost or has no room, and if the surface has more tiles than a device counts.
    pub fn new(device: &Device, topology: &TileTopology) -> Result<Self> {
        let (words, starts) = flattened(topology)?;
        let words = Arc::new(Buffer::of(device, "topology of tiles", &words)?);
        Self::with(device, (words, starts), topology.ring_count(), (None, Buffer::new(device, "no turns", 1)?))
    }

    /// For vectors of `field`, on the tiles that this is for. The turns between its frames are the turns that the
    /// processor makes rings with, of the pose in which the channel was made, so that no later pose changes them;
    /// [`Self::turn`] brings them over.
    ///
    /// # Errors
    /// Fails where the device is lost or has no room, and for a field of vectors without frames.
    pub fn framed(&self, device: &Device, field: &Field<Vector>) -> Result<Self> {
        let frames = field.frames.clone().ok_or_else(|| Error::internal("vectors without frames on a device"))?;
        let turns = Buffer::new(device, "turns of frames", TURN_NUMBERS * field.tile_count())?;
        let topology = (self.topology.clone(), [self.rings, self.entries]);
        Self::with(device, topology, field.topology().ring_count(), (Some((frames, field.topology().clone())), turns))
    }

    /// Brings over the turns that the rings of `tiles` need.
    ///
    /// # Errors
    /// Fails where the device is lost or has no memory.
    pub fn turn(&mut self, context: &Context, device: &Device, tiles: impl IntoIterator<Item = u32>) -> Result<()> {
        let Some((frames, topology)) = &self.frames else { return Ok(()) };
        let at_vertex = |ring: &u32| topology.ring(*ring).iter().map(|it| it.tile);
        let around = |tile: u32| topology.rings(tile).iter().flat_map(at_vertex).chain([tile]);
        let there = tiles.into_iter().filter(|tile| !topology.is_hole(*tile));
        let mut lacking: Vec<u32> = there.flat_map(around).filter(|tile| !self.turned[*tile as usize]).collect();
        lacking.sort_unstable();
        lacking.dedup();
        let numbers = frames.packed(context, &lacking);
        let mut numbers = &numbers[..];
        for run in lacking.chunk_by(|a, b| a + 1 == *b) {
            let (own, rest) = numbers.split_at(run.len());
            self.turns.write(device, TURN_NUMBERS * run[0] as usize, own.as_flattened())?;
            numbers = rest;
        }
        lacking.iter().for_each(|tile| self.turned[*tile as usize] = true);
        Ok(())
    }

    /// Whether this is for vectors in the frames of `field`.
    pub fn is_of(&self, field: &Field<Vector>) -> bool {
        self.frames.as_ref().zip(field.frames.as_ref()).is_some_and(|((own, _), frames)| Arc::ptr_eq(own, frames))
    }

    fn with(
        device: &Device,
        (topology, [rings, entries]): (Arc<Buffer<u32>>, [u32; 2]),
        ring_count: usize,
        (frames, turns): (Option<(Arc<Frames>, Arc<TileTopology>)>, Buffer<f32>),
    ) -> Result<Self> {
        use Access::{Read, Write};
        let kernel = |entry| {
            device.kernel(&KernelSpec {
                module: "ring",
                entry,
                groups: &[&[Read, Read, Read, Write, Read, Read, Write, Read, Write, Read]],
                immediates: size_of::<Ring>() as u32,
                constants: &[("FRAMED", f64::from(u8::from(frames.is_some())))],
            })
        };
        // Vectors have no mips.
        let entry_points = &ENTRIES[..if frames.is_some() { MIPS } else { ENTRIES.len() }];
        Ok(Self {
            kernels: entry_points.iter().copied().map(kernel).collect::<Result<_>>()?,
            topology,
            vertices: Buffer::new(device, "values of vertices", 4 * ring_count.max(1))?,
            turned: vec![false; turns.len() / TURN_NUMBERS],
            frames,
            turns,
            rings,
            entries,
            runs: AtomicU32::new(0),
            none: Buffer::of(device, "no blocks", &[u32::MAX])?,
            unused: Buffer::new(device, "no blocks' words", 1)?,
        })
    }

    /// The topology that kernels read, and where rings and their entries begin in it.
    pub fn topology(&self) -> (&Buffer<u32>, [u32; 2]) {
        (&self.topology, [self.rings, self.entries])
    }

    /// Binds the update of the tiles in `listed`, of which there are as many as the first word of `counts` says. Rings
    /// of `worked` blocks are made there, and tiles without any block count as blank ones; without such blocks it is
    /// those of `tiles` that change, and what is beside a tile without one is blank.
    ///
    /// # Errors
    /// Fails where the device is lost or has no memory.
    pub fn bind<T: Texel>(
        &self,
        device: &Device,
        tiles: &DeviceTiles<T>,
        (listed, counts): (&wgpu::Buffer, &wgpu::Buffer),
        worked: Option<WorkedBlocks<'_>>,
    ) -> Result<BoundRing> {
        let [entries, texels] = tiles.buffers();
        let (pointers, blocks, sizes) = match &worked {
            Some(worked) => (worked.pointers.wgpu(), worked.blocks.wgpu(), worked.sizes),
            None => (self.none.wgpu(), self.unused.wgpu(), entries),
        };
        let own = [self.topology.wgpu(), self.vertices.wgpu(), self.turns.wgpu()];
        let bound = [&[listed, counts, pointers, blocks, entries, sizes, texels][..], &own].concat();
        let bindings = device.bind(&self.kernels[0], 0, &bound)?;
        Ok(BoundRing { bindings, room: worked.map(|worked| worked.room) })
    }

    /// The parameters of the kernels, of tiles that read as `blank` where they have no block. Fails for texels that
    /// they do not know.
    fn work<T: Texel>(&self, bound: &BoundRing, blank: T) -> Result<Ring> {
        let (format, blank) =
            blank.on_device().ok_or_else(|| Error::internal("the ring update of texels that no kernel knows"))?;
        if (format == FRAMED) != self.frames.is_some() {
            return Err(Error::internal("the ring update of vectors by what is for others, or of others"));
        }
        // Never that of a vertex that nothing made yet.
        let run = self.runs.fetch_add(1, Ordering::Relaxed) % (u32::MAX - 1) + 1;
        let (room, loose) = (bound.room.unwrap_or(0), u32::from(bound.room.is_some()));
        let (rings, entries) = (self.rings, self.entries);
        Ok(Ring { blank, rings, entries, run, format, room, loose, ..Ring::default() })
    }

    /// Records the update of so many listed tiles of at most so many texels a side.
    ///
    /// # Errors
    /// Fails with [`ErrorKind::Internal`](relievo_core::ErrorKind) if no kernel knows the texels, or if they are
    /// vectors and this is not [`Self::framed`], or the reverse; what the device refuses comes back where the frame is
    /// submitted.
    pub fn update<T: Texel>(&self, pass: &mut Pass<'_>, bound: &BoundRing, blank: T, tiles: (u32, u32)) -> Result<()> {
        let work = self.work(bound, blank)?;
        self.make(pass, bound, &work, tiles)
    }

    /// Records the update of rings as `work` tells it.
    fn make(&self, pass: &mut Pass<'_>, bound: &BoundRing, work: &Ring, (count, size): (u32, u32)) -> Result<()> {
        let groups = groups_of(count, 4 * (size + 1));
        self.kernels[..BLANK]
            .iter()
            .try_for_each(|kernel| pass.run(kernel, &[&bound.bindings], bytemuck::bytes_of(work), groups))
    }

    /// As [`Self::update`]; workgroups along x and z are tiles, of which each has enough along y for its block, as three
    /// words of `arguments` from `first` on say.
    ///
    /// # Errors
    /// Fails as [`Self::update`], and if `arguments` has not three words from `first` on.
    pub fn update_indirect<T: Texel>(
        &self,
        pass: &mut Pass<'_>,
        bound: &BoundRing,
        blank: T,
        (arguments, first): (&Buffer<u32>, usize),
    ) -> Result<()> {
        let work = self.work(bound, blank)?;
        self.kernels[..BLANK].iter().try_for_each(|kernel| {
            pass.run_indirect(kernel, &[&bound.bindings], bytemuck::bytes_of(&work), arguments, first)
        })
    }

    /// Binds the mips of the listed tiles: where they begin, they, and the sizes of all tiles, see [`WorkedBlocks`].
    pub(crate) fn bind_mips<T: Texel>(
        &self,
        device: &Device,
        tiles: &DeviceTiles<T>,
        (listed, counts): (&wgpu::Buffer, &wgpu::Buffer),
        (pointers, blocks, sizes): (&Buffer<u32>, &Buffer<u32>, &wgpu::Buffer),
    ) -> Result<BoundRing> {
        // There are no blocks that are worked on: level 0 is that of the tiles.
        self.bind(device, tiles, (listed, counts), Some(WorkedBlocks { pointers, blocks, sizes, room: 0 }))
    }

    /// Records that level `level` of `count` listed tiles, of at most `size` texels a side there, is made of the one below.
    pub(crate) fn make_mips<T: Texel>(
        &self,
        pass: &mut Pass<'_>,
        bound: &BoundRing,
        blank: T,
        level: u32,
        (count, size): (u32, u32),
    ) -> Result<()> {
        let work = Ring { level, ..self.work(bound, blank)? };
        let groups = groups_of(count, size * size);
        pass.run(&self.kernels[MIPS], &[&bound.bindings], bytemuck::bytes_of(&work), groups)
    }

    /// Records the update of the rings of those mips of `count` listed tiles that have `density` texels along an edge of the
    /// cage, at most `size` a side.
    pub(crate) fn update_mips<T: Texel>(
        &self,
        pass: &mut Pass<'_>,
        bound: &BoundRing,
        blank: T,
        density: u32,
        (count, size): (u32, u32),
    ) -> Result<()> {
        let work = Ring { density, ..self.work(bound, blank)? };
        self.make(pass, bound, &work, (count, size))
    }

    /// Records that the blocks of `count` listed tiles, of at most `size` texels a side, are blank.
    pub(crate) fn clear<T: Texel>(
        &self,
        pass: &mut Pass<'_>,
        bound: &BoundRing,
        blank: T,
        (count, size): (u32, u32),
    ) -> Result<()> {
        let work = self.work(bound, blank)?;
        let groups = groups_of(count, (size + 2) * (size + 2));
        pass.run(&self.kernels[BLANK], &[&bound.bindings], bytemuck::bytes_of(&work), groups)
    }
}

/// Workgroups for so many tiles with so many items each.
fn groups_of(tiles: u32, items: u32) -> [u32; 3] {
    [tiles.min(ROW), items.div_ceil(GROUP), tiles.div_ceil(ROW)]
}

/// The topology as the kernels read it, and where its rings and entries begin. Of a tile: four links of four words (kind
/// in 3 bits, whether reversed, two edges of 2 bits, whether it is the second half, whether the tile is a sub-tile; two
/// tiles; the ring in the middle) and the rings at its corners, whose last bits say whether it is wound against their
/// first tiles. Before the rings come the tables of means.
fn flattened(topology: &TileTopology) -> Result<(Vec<u32>, [u32; 2])> {
    let tiles = topology.tile_count() as u32;
    let rings = topology.ring_count() as u32;
    let entries: usize = (0..rings).map(|ring| topology.ring(ring).len()).sum();
    let words = 20 * tiles as usize + 2 * (rings as usize + 1) + 2 * entries + 512;
    if u32::try_from(words).is_err() || rings >= 1 << 31 {
        return Err(Error::memory("a surface of too many tiles for a graphics device"));
    }
    let mut made = Vec::with_capacity(words);
    // By tile the rings at its corners and in the middles of its edges.
    let mut known = vec![[None; 8]; tiles as usize];
    for ring in 0..rings {
        let entries = topology.ring(ring);
        for entry in entries {
            let place = usize::from(entry.corner) + if entry.middle { 4 } else { 0 };
            let flips = u32::from(entry.flipped != entries[0].flipped);
            known[entry.tile as usize][place] = Some(ring | flips << 31);
        }
    }
    for tile in 0..tiles {
        let sub = u32::from(topology.is_sub(tile)) << 9;
        for (edge, link) in topology.links(tile).iter().enumerate() {
            let turned = |reversed: bool| u32::from(reversed) << 3;
            let at = |edge: u8, place: u32| u32::from(edge) << place;
            made.extend(match *link {
                Link::Boundary => [sub, 0, 0, 0],
                Link::Pinned { .. } => [1 | sub, 0, 0, 0],
                Link::Whole { side, reversed } => [2 | turned(reversed) | at(side.edge, 4) | sub, side.tile, 0, 0],
                Link::Half { side, second, reversed } => {
                    [3 | turned(reversed) | at(side.edge, 4) | u32::from(second) << 8 | sub, side.tile, 0, 0]
                }
                Link::Halves { first, second, reversed, middle } => {
                    let bits = 4 | turned(reversed) | at(first.edge, 4) | at(second.edge, 6) | sub;
                    [bits, first.tile, second.tile, known[tile as usize][4 + edge].unwrap_or(middle)]
                }
            });
        }
        for (corner, ring) in topology.rings(tile).iter().enumerate() {
            made.push(known[tile as usize][corner].unwrap_or(*ring));
        }
    }
    made.extend(mean_tables());
    let first_ring = made.len() as u32;
    let mut first = 0;
    for ring in 0..rings {
        made.extend([first, topology.ring_class(ring) as u32]);
        first += topology.ring(ring).len() as u32;
    }
    made.extend([first, RingClass::Regular as u32]);
    let first_entry = made.len() as u32;
    for entry in (0..rings).flat_map(|ring| topology.ring(ring)) {
        let bits = u32::from(entry.corner) | u32::from(entry.middle) << 2 | u32::from(entry.flipped) << 3;
        made.extend([entry.tile, bits]);
    }
    Ok((made, [first_ring, first_entry]))
}
