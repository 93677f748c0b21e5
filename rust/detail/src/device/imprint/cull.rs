//! Culling and compaction on a graphics device (`shaders/imprint/cull/imprint_patches.wgsl`, `shaders/imprint/cull/imprint_cull.wgsl`), as
//! [`crate::imprint::cull`] and [`crate::imprint::compact`] do them: the list of blocks that may have points in the grids of
//! imprints. All patches are looked at, without a hierarchy: a device has the threads for it, and a hierarchy of an
//! animated surface would have to be refitted first. The range of a tile's displacement is found there too
//! (`shaders/imprint/cull/imprint_range.wgsl`).

use std::sync::Arc;

use relievo_core::{Error, Result};
use relievo_gpu::wgsl::imprint_link::Step;
use relievo_gpu::wgsl::imprint_tile::CullTile;
use relievo_gpu::{Access, Bindings, Buffer, Device, Kernel, KernelSpec, Pass, groups};
use relievo_surface::{DeviceSurface, SURFACE_GROUP, Surface};
use relievo_tiles::{DeviceTiles, TILES_GROUP};

use super::shared::{Shared, step};
use crate::paint::ground::Ground;

/// A displaced surface's tiles, culled on a device.
#[derive(Debug)]
pub(crate) struct DeviceCull {
    /// What lists tiles, and what lists blocks of them.
    kernels: [Arc<Kernel>; 2],
    buffers: [Bindings; 2],
    cones: Buffer<[f32; 4]>,
    measure: Arc<Kernel>,
    measured: Bindings,
    /// Tiles whose range of displacement is to be found, their sizes, and as bits the lengths of vectors over them.
    changed: Buffer<[u32; 4]>,
    pending: Vec<u32>,
    /// The tiles; the tiles of patches, which imprints tiles may meet, and the tiles that meet one.
    _kept: (Buffer<CullTile>, [Buffer<u32>; 3]),
}

/// What the kernels have of a submission: its imprints, what those before left, the boxes of colliders, and the arguments of
/// the second; that then has the list of blocks, the counters, and arguments before the arguments that the first left.
pub(super) const MEETING: [Access; 4] = [Access::Read, Access::Read, Access::Read, Access::Write];
pub(super) const LISTING: [Access; 7] =
    [Access::Read, Access::Read, Access::Read, Access::Write, Access::Write, Access::Write, Access::Read];

/// Patches of a workgroup.
const PATCHES: u32 = 64;

/// Words of a tile's mask, as in `imprint_hull.wgsl`.
const MASK: usize = 3;

fn cones(surface: &Surface) -> Vec<[f32; 4]> {
    let patches = (0..surface.tile_count() as u32).flat_map(|tile| surface.patches(tile));
    let cone = |cone: relievo_surface::Cone| [cone.axis[0], cone.axis[1], cone.axis[2], cone.cosine];
    patches.map(|patch| cone(patch.normals())).collect()
}

impl DeviceCull {
    /// Culling of the tiles of `surface`, in its pose and as they are displaced. Fails where the device has no room.
    pub fn new(device: &Device, surface: &Surface, ground: Ground<'_>) -> Result<Self> {
        use Access::{Read, Write};
        let kernel = |module, entry, groups: &[&[Access]]| {
            let immediates = size_of::<Step>() as u32;
            device.kernel(&KernelSpec { module, entry, groups, immediates, constants: &[] })
        };
        let of_patches: [&[Access]; 3] = [&MEETING, &SURFACE_GROUP, &[Read, Read, Write, Write, Read]];
        let of_blocks: [&[Access]; 3] = [&LISTING, &SURFACE_GROUP, &[Read, Read, Write, Read]];
        let kernels = [
            kernel("imprint_patches", "cull_patches", &of_patches)?,
            kernel("imprint_cull", "cull_blocks", &of_blocks)?,
        ];
        let measure = device.kernel(&KernelSpec {
            module: "imprint_range",
            entry: "measure",
            groups: &[&[Access::Read, Access::Write], &SURFACE_GROUP, &TILES_GROUP],
            immediates: size_of::<u32>() as u32,
            constants: &[],
        })?;
        let field = ground.heights;
        let tile = |tile: u32| CullTile { least: 0.0, most: 0.0, size: field.size(tile), length: 0.0 };
        let tiles: Vec<CullTile> = (0..surface.tile_count() as u32).map(tile).collect();
        let tiles = Buffer::of(device, "tiles", &tiles)?;
        let cones = Buffer::of(device, "cones of normals", &cones(surface))?;
        let changed = Buffer::new(device, "tiles to measure", tiles.len())?;
        let owners: Vec<u32> =
            (0..tiles.len() as u32).flat_map(|tile| std::iter::repeat_n(tile, surface.patches(tile).count())).collect();
        let owners = Buffer::of(device, "tiles of patches", &owners)?;
        let masks = Buffer::<u32>::new(device, "imprints of tiles", MASK * tiles.len())?;
        let listed = Buffer::<u32>::new(device, "listed tiles", tiles.len())?;
        let bound = [tiles.wgpu(), cones.wgpu(), masks.wgpu(), listed.wgpu(), owners.wgpu()];
        let buffers = [device.bind(&kernels[0], 2, &bound)?, device.bind(&kernels[1], 2, &bound[..4])?];
        let measured = device.bind(&measure, 0, &[changed.wgpu(), tiles.wgpu()])?;
        let _kept = (tiles, [owners, masks, listed]);
        let mut made = Self { kernels, buffers, cones, measure, measured, changed, pending: Vec::new(), _kept };
        let bent = ground.vectors.into_iter().flat_map(|vectors| vectors.allocated());
        made.update(device, ground, &field.allocated().chain(bent).collect::<Vec<_>>())?;
        Ok(made)
    }

    /// Says which `tiles` are displaced otherwise than before, by `ground`. Fails unless it is of the same surface.
    pub fn update(&mut self, device: &Device, ground: Ground<'_>, tiles: &[u32]) -> Result<()> {
        if tiles.is_empty() {
            return Ok(());
        }
        self.pending.extend_from_slice(tiles);
        self.pending.sort_unstable();
        self.pending.dedup();
        let field = ground.heights;
        let length = |tile| ground.vectors.map_or(0.0, |vectors| vectors.length(tile));
        let entry = |tile| [tile, field.size(tile), length(tile).to_bits(), 0];
        let entries: Vec<_> = self.pending.iter().map(|tile| entry(*tile)).collect();
        self.changed.write(device, 0, &entries)
    }

    /// Records that the ranges of the displacement of what changed are found in `tiles`, the object's.
    pub fn measure(&self, pass: &mut Pass<'_>, surface: &DeviceSurface, tiles: &DeviceTiles) -> Result<()> {
        let count = self.pending.len() as u32;
        let bound = [&self.measured, surface.group(), tiles.group()];
        pass.run(&self.measure, &bound, &count.to_ne_bytes(), groups(count))
    }

    /// Notes that what was recorded is done.
    pub fn settle(&mut self) {
        self.pending.clear();
    }

    /// Writes the normals of the pose of `surface`. Fails unless it is the same surface.
    pub fn pose(&self, device: &Device, surface: &Surface) -> Result<()> {
        let cones = cones(surface);
        if cones.len() != self.cones.len() {
            return Err(Error::internal("another surface than the one that is culled"));
        }
        self.cones.write(device, 0, &cones)
    }

    /// Records the list of the blocks of `surface`, the object's, that may have points in the grids of the row of imprints
    /// that begins with `job`.
    pub fn cull(
        &self,
        pass: &mut Pass<'_>,
        shared: &Shared,
        [meeting, listing]: &[Bindings; 2],
        surface: &DeviceSurface,
        job: usize,
    ) -> Result<()> {
        let jobs = step(job..job + 1);
        let jobs = bytemuck::bytes_of(&jobs);
        let count = groups((self.cones.len() as u32).div_ceil(PATCHES));
        let [patches, blocks] = &self.kernels;
        pass.run(patches, &[meeting, surface.group(), &self.buffers[0]], jobs, count)?;
        let bound = [listing, surface.group(), &self.buffers[1]];
        pass.run_indirect(blocks, &bound, jobs, &shared.candidates, Shared::tiles(job))
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::device::imprint::blocks::DeviceBlocks;
    use crate::device::imprint::job::{self, ImprintJob, JobParams};
    use crate::device::imprint::meshes::DeviceMeshes;
    use crate::device::imprint::shared::{Shared, parse};
    use crate::device::imprint::voxel::{DeviceVoxels, VoxelRoom};
    use crate::geometry::grid::Grid;
    use crate::geometry::lattice::Lattice;
    use crate::geometry::obb::Obb;
    use crate::geometry::voxel::Side;
    use crate::imprint::collider::Collider;
    use crate::imprint::compact;
    use crate::imprint::cull;
    use crate::imprint::settings::ImprintSettings;
    use crate::object::{DisplacedObject, shapes};
    use glam::{DAffine3, DMat3, DVec3, EulerRot};
    use relievo_core::{Context, Mesh};
    use relievo_surface::SurfaceOptions;
    use relievo_testing::{Random, device, grid};
    use relievo_tiles::{Candidate, Displacement, DisplacementOptions, Sets, Vector, VectorDisplacement};

    /// A wavy sheet with faces of all kinds, of which every third tile is displaced.
    pub(crate) fn object(context: &Context) -> DisplacedObject {
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
    fn blocks_are_those_of_the_processor() {
        let Some(device) = device() else { return };
        let context = Context::serial();
        let straight = compare(&device, &context, object(&context));
        let mut object = object(&context);
        let options = DisplacementOptions { size: 16, ..DisplacementOptions::default() };
        let mut vectors = VectorDisplacement::on(object.surface(), &options).unwrap();
        let tiles: Vec<u32> = (0..object.surface().tile_count() as u32).step_by(2).collect();
        vectors.apply(&Sets { allocate: tiles.clone(), ..Sets::default() }).unwrap();
        let vector = Vector([0.1, -0.25, 0.2].map(half::f16::from_f32));
        let changes = vectors.edit(&context, &tiles, |_, texels| texels.row_mut(7).fill(vector)).unwrap();
        vectors.settle(&context, &changes).unwrap();
        object.set_vectors(vectors).unwrap();
        let bent = compare(&device, &context, object);
        assert!(straight > 200 && bent > straight + 50, "{straight} {bent}");
    }

    /// Culls `object` with some grids on both, and returns how many blocks are left.
    fn compare(device: &Device, context: &Context, mut object: DisplacedObject) -> usize {
        let surface = DeviceSurface::new(device, object.surface()).unwrap();
        let fields = DeviceTiles::new(device, object.displacement().field()).unwrap();
        let mut culling = DeviceCull::new(device, object.surface(), object.ground()).unwrap();
        culling.pose(device, object.surface()).unwrap();
        culling.update(device, object.ground(), &[0, 1, 2, 5, 7, 8]).unwrap();
        let (points, triangles) = shapes::cube(1.0);
        let collider = Collider::new(context, points, triangles, DAffine3::IDENTITY).unwrap();
        let shared = Shared::new(device).unwrap();
        let mut meshes = DeviceMeshes::new(device).unwrap();
        meshes.bring(device, &[&collider]).unwrap();
        let place = meshes.place(collider.identity[0]).unwrap();
        let mut voxels = None;
        let room = VoxelRoom::default();
        DeviceVoxels::prepare(&mut voxels, device, &shared, &meshes, room).unwrap();
        let worked = Buffer::new(device, "no blocks", 1).unwrap();
        let blocks = DeviceBlocks::new(device, &shared, &voxels.unwrap(), (&worked, [4096, 1, 1]), false).unwrap();
        let mut random = Random(3);
        let mut kept = 0;
        for round in 0..6 {
            let mut unit = || f64::from(random.unit());
            let axes = DMat3::from_euler(EulerRot::XYZ, unit(), unit(), unit());
            let half = DVec3::new(0.3 + 2.0 * unit(), 0.2 + unit(), 0.1 + 0.3 * unit());
            let center = object.transform().transform_point3(DVec3::new(9.0 * unit(), 9.0 * unit(), 0.2));
            let grid = Grid::new(&Obb { center, axes, half }, 1 << 20, None);
            let lattice = Lattice::new(&grid, &DAffine3::from_translation(center), collider.object_obb()).unwrap();
            let limits = ImprintSettings::default().limits();
            let job = ImprintJob::of(0, &collider, &grid, &limits, Side::Forward, lattice);
            let tiles = object.surface().tile_count();
            let ground = job::Ground { transform: object.transform(), tiles, started: false, slots: None };
            let mut words = [JobParams::new(&job, place, &ground)];
            words[0].set_room([4096, 1, 0]);
            let mut commands = device.frame().unwrap();
            shared.begin(device, &mut commands, &words).unwrap();
            shared.begin_lists(&mut commands);
            culling.measure(&mut commands.pass("ranges"), &surface, &fields).unwrap();
            culling.cull(&mut commands.pass("culling"), &shared, blocks.listing(), &surface, 0).unwrap();
            let ranges = commands.read(&culling._kept.0, 0..tiles).unwrap();
            let listed = commands.read(blocks.listed(), 0..4096).unwrap();
            let arguments = commands.read(&shared.arguments, 4..8).unwrap();
            let counters = shared.read_counters(&mut commands, 1).unwrap();
            let _ = commands.submit().unwrap();
            let counters = parse(&counters.get(device).unwrap()).1[0];
            let mut found = listed.get(device).unwrap();
            found.truncate(counters.found as usize);
            assert!(found.iter().all(|it| it[2..] == [1, 0]));
            found.sort_unstable_by_key(|[tile, block, ..]| (*tile, block & 0xffff));

            let culled = cull::cull(context, &mut object, &grid);
            let mut expected: Vec<_> = compact(context, &object, culled);
            expected.sort_unstable_by_key(|tile| tile.tile);
            let field = object.displacement().field();
            let size = |tile| field.size(tile);
            for (tile, found) in (0..).zip(ranges.get(device).unwrap()) {
                assert_eq!(([found.least, found.most], found.size), (field.range(tile), size(tile)), "tile {tile}");
            }
            // They stay until something else changes.
            culling.settle();
            let here = expected.iter().flat_map(|it| {
                it.blocks.iter().map(|block| [it.tile, block.index | size(it.tile) << 16, 1, 0]).collect::<Vec<_>>()
            });
            assert_eq!(found, here.collect::<Vec<_>>(), "round {round}");
            assert_eq!(counters.tiles as usize, expected.len());
            assert_eq!(counters.tested, found.iter().map(|[tile, ..]| size(*tile).min(16).pow(2)).sum::<u32>());
            let some = u32::from(counters.found > 0);
            assert_eq!(arguments.get(device).unwrap(), [counters.found, counters.found, some, some]);
            kept += found.len();
        }
        kept
    }
}
