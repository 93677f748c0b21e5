//! Culling and compaction on a graphics device (`shaders/imprint_cull.wgsl`), as [`crate::cull`] and
//! [`crate::imprint::compact`] do them. All tiles are looked at, without a hierarchy: a device has the threads for it, and
//! a hierarchy of an animated surface would have to be refitted first.

use std::sync::Arc;

use bytemuck::{Pod, Zeroable};
use relievo_core::{Error, Result};
use relievo_gpu::{Access, Bindings, Buffer, Compaction, Device, Frame, Kernel, KernelSpec, Pass, groups};
use relievo_surface::{DeviceSurface, SURFACE_GROUP};

use super::blocks::{keep_kernel, list_kernel};
use crate::cull::{VoxelFrame, range};
use crate::object::DisplacedObject;

/// As in `imprint_cull.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
struct CullTile {
    least: f32,
    most: f32,
    length: f32,
    state: u32,
}

/// As in `imprint_cull.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
struct Cull {
    x: [f32; 4],
    y: [f32; 4],
    z: [f32; 4],
    origin: [f32; 3],
    tiles: u32,
    dims: [f32; 3],
    padding: u32,
}

const ALLOCATED: u32 = 0x10000;

/// Words of a tile's blocks: 16 × 16 at most.
const WORDS: usize = 8;

/// The classes that tiles are compacted into.
const MODIFY: usize = 0;
const ALLOCATE: usize = 1;

/// A displaced surface's tiles, culled on a device.
#[derive(Debug)]
pub struct DeviceCull {
    kernel: Arc<Kernel>,
    buffers: Bindings,
    tiles: Buffer<CullTile>,
    cones: Buffer<[f32; 4]>,
    masks: Buffer<u32>,
    blocks: Buffer<u32>,
    compaction: Compaction,
    /// What imprints that are submitted together leave of every tile; zeros in between.
    lowered: Buffer<i32>,
    /// What was culled, for the list of blocks, and what imprints lower.
    pub(super) culled: Bindings,
    pub(super) lowering: Bindings,
}

fn cull_tile(object: &DisplacedObject, tile: u32) -> CullTile {
    let field = object.displacement().field();
    let [least, most] = field.block(tile).map_or([0.0; 2], range);
    let length = object.vectors().map_or(0.0, |vectors| vectors.field().length(tile));
    let allocated = if field.is_allocated(tile) { ALLOCATED } else { 0 };
    CullTile { least, most, length, state: field.size(tile) | allocated }
}

fn cones(object: &DisplacedObject) -> Vec<[f32; 4]> {
    let surface = object.surface();
    let patches = (0..surface.tile_count() as u32).flat_map(|tile| surface.patches(tile));
    let cone = |cone: relievo_surface::Cone| [cone.axis[0], cone.axis[1], cone.axis[2], cone.cosine];
    patches.map(|patch| cone(patch.normals())).collect()
}

impl DeviceCull {
    /// Culling of the tiles of `object`, in its pose and as they are displaced. Fails where the device has no room.
    pub fn new(device: &Device, object: &DisplacedObject) -> Result<Self> {
        use Access::{Read, Write};
        let kernel = device.kernel(&KernelSpec {
            module: "imprint_cull",
            entry: "cull",
            groups: &[&[Read, Read, Write, Write, Read], &SURFACE_GROUP],
            immediates: size_of::<Cull>() as u32,
            constants: &[],
        })?;
        let count = object.surface().tile_count() as u32;
        let tiles: Vec<CullTile> = (0..count).map(|tile| cull_tile(object, tile)).collect();
        let tiles = Buffer::of(device, "tiles", &tiles)?;
        let cones = Buffer::of(device, "cones of normals", &cones(object))?;
        let masks = Buffer::new(device, "tiles' classes", tiles.len())?;
        let blocks = Buffer::new(device, "tiles' blocks", WORDS * tiles.len())?;
        let lowered = Buffer::new(device, "tiles' least coefficients", tiles.len())?;
        let compaction = Compaction::new(device, &masks, 2)?;
        let buffers = [tiles.wgpu(), cones.wgpu(), masks.wgpu(), blocks.wgpu(), lowered.wgpu()];
        let buffers = device.bind(&kernel, 0, &buffers)?;
        let culled = [compaction.lists().wgpu(), compaction.counts().wgpu(), blocks.wgpu(), tiles.wgpu()];
        let culled = device.bind(&*list_kernel(device, "list")?, 0, &culled)?;
        let lowering = device.bind(&*keep_kernel(device)?, 1, &[lowered.wgpu()])?;
        Ok(Self { kernel, buffers, tiles, cones, masks, blocks, compaction, lowered, culled, lowering })
    }

    /// Writes how `tiles` of `object` are displaced now. Fails unless it is the same object.
    pub fn update(&self, device: &Device, object: &DisplacedObject, tiles: &[u32]) -> Result<()> {
        for run in tiles.chunk_by(|a, b| a + 1 == *b) {
            let entries: Vec<CullTile> = run.iter().map(|tile| cull_tile(object, *tile)).collect();
            self.tiles.write(device, run[0] as usize, &entries)?;
        }
        Ok(())
    }

    /// Writes the normals of the pose of `object`. Fails unless it is the same object.
    pub fn pose(&self, device: &Device, object: &DisplacedObject) -> Result<()> {
        let cones = cones(object);
        if cones.len() != self.cones.len() {
            return Err(Error::internal("another surface than the one that is culled"));
        }
        self.cones.write(device, 0, &cones)
    }

    /// Records that what imprints that were submitted together left is forgotten.
    pub(super) fn forget(&self, frame: &mut Frame) {
        frame.clear(&self.lowered);
    }

    /// Records the culling of `surface`, the object's, against the grid of `frame`.
    pub fn cull(&self, pass: &mut Pass<'_>, surface: &DeviceSurface, frame: &VoxelFrame) -> Result<()> {
        let row = |axis: usize| {
            let [x, y, z] = frame.rows[axis];
            [x, y, z, frame.shift[axis]]
        };
        let count = self.tiles.len() as u32;
        let dims = frame.dims;
        let work = Cull { x: row(0), y: row(1), z: row(2), origin: frame.origin, tiles: count, dims, padding: 0 };
        pass.run(&self.kernel, &[&self.buffers, surface.group()], bytemuck::bytes_of(&work), groups(count))
    }

    /// Records the lists of tiles from what was culled.
    pub fn compact(&self, pass: &mut Pass<'_>) -> Result<()> {
        self.compaction.run(pass, self.masks.len() as u32)
    }

    /// The lists: tiles that may be modified come first, those of them that need a block begin at the number of tiles.
    pub fn lists(&self) -> &Buffer<u32> {
        self.compaction.lists()
    }

    /// For tiles to modify, then for those to allocate: how many there are, and the workgroups of an indirect dispatch
    /// in which every invocation takes one.
    pub fn counts(&self) -> &Buffer<u32> {
        self.compaction.counts()
    }

    /// Where the arguments of an indirect dispatch over the tiles to modify and those to allocate are in the counts.
    pub fn arguments(&self) -> [usize; 2] {
        [MODIFY, ALLOCATE].map(|class| self.compaction.arguments(class))
    }

    /// Of every tile the blocks that may have points in the grid, as bits of eight words.
    pub fn blocks(&self) -> &Buffer<u32> {
        &self.blocks
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cull;
    use crate::grid::Grid;
    use crate::imprint::compact;
    use crate::obb::Obb;
    use glam::{DAffine3, DMat3, DVec3, EulerRot};
    use relievo_core::{Context, Mesh};
    use relievo_surface::{Surface, SurfaceOptions};
    use relievo_testing::{Random, device, grid, wgsl::assert_layout};
    use relievo_tiles::{Candidate, Displacement, DisplacementOptions, Sets};
    use std::mem::offset_of;

    #[test]
    fn the_layouts_are_those_of_the_kernel() {
        let tile = [
            ("least", offset_of!(CullTile, least)),
            ("most", offset_of!(CullTile, most)),
            ("length", offset_of!(CullTile, length)),
            ("state", offset_of!(CullTile, state)),
        ];
        assert_layout("imprint_cull", "CullTile", size_of::<CullTile>(), &tile);
        let work = [
            ("x", offset_of!(Cull, x)),
            ("y", offset_of!(Cull, y)),
            ("z", offset_of!(Cull, z)),
            ("origin", offset_of!(Cull, origin)),
            ("tiles", offset_of!(Cull, tiles)),
            ("dims", offset_of!(Cull, dims)),
        ];
        assert_layout("imprint_cull", "Cull", size_of::<Cull>(), &work);
    }

    /// A wavy sheet with faces of all kinds, of which every third tile is displaced.
    fn object(context: &Context) -> DisplacedObject {
        let mesh: Mesh = grid(9, false, &[3, 1, 7, 2, 0, 3, 11, 2, 5], false);
        let surface = Surface::new(context, &mesh, &SurfaceOptions::default()).unwrap();
        let options = DisplacementOptions { size: 64, ..DisplacementOptions::default() };
        let displacement = Displacement::new(surface.topology().clone(), &options).unwrap();
        let mut object =
            DisplacedObject::new(context, surface, &mesh.points, displacement, DAffine3::from_rotation_z(0.4)).unwrap();
        let tiles: Vec<u32> = (0..object.displacement().field().tile_count() as u32).step_by(3).collect();
        let candidates: Vec<_> =
            tiles.iter().map(|tile| Candidate { tile: *tile, decision: Candidate::MODIFY }).collect();
        let sets = Sets::scan(context, &candidates, |_| false);
        let displacement = object.displacement_mut();
        displacement.apply(&sets).unwrap();
        let changes = displacement
            .edit(context, &tiles, |tile, texels| {
                let mut random = Random(u64::from(tile));
                for row in 0..texels.size() {
                    texels.row_mut(row).fill_with(|| half::f16::from_f32(0.3 * random.unit() - 0.2));
                }
            })
            .unwrap();
        displacement.settle(context, &changes).unwrap();
        object
    }

    #[test]
    fn sets_and_blocks_are_those_of_the_processor() {
        let Some(device) = device() else { return };
        let context = Context::serial();
        let mut object = object(&context);
        let surface = DeviceSurface::new(&device, object.surface()).unwrap();
        let culling = DeviceCull::new(&device, &object).unwrap();
        culling.pose(&device, &object).unwrap();
        culling.update(&device, &object, &[0, 1, 2, 5, 7, 8]).unwrap();
        let count = culling.tiles.len();
        let mut random = Random(3);
        let mut kept = 0;
        for round in 0..6 {
            let mut unit = || f64::from(random.unit());
            let axes = DMat3::from_euler(EulerRot::XYZ, unit(), unit(), unit());
            let half = DVec3::new(0.3 + 2.0 * unit(), 0.2 + unit(), 0.1 + 0.3 * unit());
            let center = object.transform().transform_point3(DVec3::new(9.0 * unit(), 9.0 * unit(), 0.2));
            let grid = Grid::new(&Obb { center, axes, half }, 1 << 20, None);
            let frame = VoxelFrame::new(&grid, object.transform());
            let mut commands = device.frame().unwrap();
            culling.cull(&mut commands.pass("culling"), &surface, &frame).unwrap();
            culling.compact(&mut commands.pass("compaction")).unwrap();
            let lists = commands.read(culling.lists(), 0..2 * count).unwrap();
            let counts = commands.read(culling.counts(), 0..8).unwrap();
            let blocks = commands.read(culling.blocks(), 0..WORDS * count).unwrap();
            let _ = commands.submit().unwrap();
            let (lists, counts) = (lists.get(&device).unwrap(), counts.get(&device).unwrap());
            let blocks = blocks.get(&device).unwrap();

            let culled = cull::cull(&context, &mut object, &grid);
            let mut expected: Vec<_> = compact(&context, &object, culled);
            expected.sort_unstable_by_key(|tile| tile.tile);
            let field = object.displacement().field();
            let modify: Vec<u32> = expected.iter().map(|tile| tile.tile).collect();
            let allocate: Vec<u32> = modify.iter().copied().filter(|tile| !field.is_allocated(*tile)).collect();
            assert_eq!(lists[..counts[0] as usize], modify, "round {round}");
            assert_eq!(lists[count..count + counts[4] as usize], allocate, "round {round}");
            for tile in &expected {
                let words = &blocks[WORDS * tile.tile as usize..][..WORDS];
                let bits: Vec<u32> =
                    (0..256).filter(|bit| words[bit / 32] >> (bit % 32) & 1 != 0).map(|bit| bit as u32).collect();
                let here: Vec<u32> = tile.blocks.iter().map(|block| block.index).collect();
                assert_eq!(bits, here, "tile {} of round {round}", tile.tile);
                kept += here.len();
            }
        }
        assert!(kept > 200, "{kept}");
    }
}
