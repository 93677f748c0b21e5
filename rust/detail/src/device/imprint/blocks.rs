//! Blocks of coefficients between culling and the host on a graphics device: the list of blocks that culling leaves, and
//! the blocks that rays change (`shaders/imprint/cast/imprint_cast.wgsl`), as [`crate::imprint::raycast`] does.
//!
//! There is room for so many blocks; the numbers that come back say whether it was enough.

use std::sync::Arc;

use bytemuck::{Pod, Zeroable};
use relievo_core::{Error, Result};
use relievo_gpu::wgsl::imprint_link::Step;
use relievo_gpu::{Access, Bindings, Buffer, Device, Frame, Kernel, KernelSpec, Pass, groups};
use relievo_surface::{DeviceSurface, SURFACE_GROUP};
use relievo_tiles::{DeviceTiles, TILES_GROUP};

use super::cull::{LISTING, MEETING};
use super::ground::{BoundGround, GROUND_GROUP, WITHOUT_AND_WITH_VECTORS};
use super::shared::{Shared, step};
use super::voxel::DeviceVoxels;
use crate::channels::knots::BLOCK_KNOTS;

/// A block that an imprint changed. As stored in buffers.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(super) struct Record {
    pub tile: u32,
    /// The block, and in the upper half which of the imprints it was that were submitted together.
    block: u32,
    /// Coefficients that change.
    pub changed: u32,
    /// The least coefficient, 0 at most, as the key of `imprint_cast.wgsl`.
    pub least: i32,
    /// The coefficients, two a word.
    pub values: [u32; BLOCK_KNOTS / 2],
}

impl Record {
    pub fn job(&self) -> u32 {
        self.block >> 16
    }

    pub fn block(&self) -> u32 {
        self.block & 0xffff
    }
}

/// Room for blocks on a device.
#[derive(Debug)]
pub(super) struct DeviceBlocks {
    /// For objects without vectors and, if there are some, for those with.
    kernels: Vec<Arc<Kernel>>,
    casting: Bindings,
    listing: [Bindings; 2],
    listed: Buffer<[u32; 4]>,
    records: Buffer<Record>,
    slots: Buffer<u32>,
    writing: Arc<Kernel>,
}

impl DeviceBlocks {
    /// Room for so many blocks of an imprint, changed ones of all, and slots; `worked` are blocks of tiles. It is for
    /// objects with vectors too if these `bend`. Fails where the device has none.
    pub fn new(
        device: &Device,
        shared: &Shared,
        voxels: &DeviceVoxels,
        (worked, [room, records, slots]): (&Buffer<u32>, [usize; 3]),
        bend: bool,
    ) -> Result<Self> {
        use Access::{Read, Write};
        let kernel = |constants| {
            device.kernel(&KernelSpec {
                module: "imprint_cast",
                entry: "cast_rays",
                groups: &[
                    &[Read, Read, Read, Read, Read, Write, Write, Write, Read],
                    &SURFACE_GROUP,
                    &GROUND_GROUP,
                    &TILES_GROUP,
                ],
                immediates: size_of::<Step>() as u32,
                constants,
            })
        };
        let variants = WITHOUT_AND_WITH_VECTORS.iter().take(1 + usize::from(bend));
        let kernels = variants.map(|constants| kernel(constants)).collect::<Result<Vec<_>>>()?;
        let writing = device.kernel(&KernelSpec {
            module: "imprint_write",
            entry: "write_blocks",
            groups: &[&[Read, Read, Read, Write]],
            immediates: size_of::<u32>() as u32,
            constants: &[],
        })?;
        let listed = Buffer::new(device, "listed blocks", room)?;
        let records = Buffer::new(device, "changed blocks", records)?;
        let slots = Buffer::new(device, "blocks' slots", slots)?;
        let Shared { jobs, counters, arguments, .. } = shared;
        let listing = Self::list_into(device, shared, &slots, &listed)?;
        let from = [jobs.wgpu(), listed.wgpu(), arguments.wgpu(), voxels.spans().wgpu(), voxels.words().wgpu()];
        let to = [slots.wgpu(), counters.wgpu(), records.wgpu(), worked.wgpu()];
        let casting = device.bind(&kernels[0], 0, &[&from[..], &to[..]].concat())?;
        Ok(Self { kernels, casting, listing, listed, records, slots, writing })
    }

    /// Blocks that an imprint may look at, blocks that imprints which are submitted together may change, and slots.
    pub fn room(&self) -> [usize; 3] {
        [self.listed.len(), self.records.len(), self.slots.len()]
    }

    /// Blocks that changed.
    pub fn records(&self) -> &Buffer<Record> {
        &self.records
    }

    /// Slots of tiles, see `imprint_link.wgsl`.
    pub fn slots(&self) -> &Buffer<u32> {
        &self.slots
    }

    /// What culling lists tiles and blocks with where `shared` tells of the imprints and the blocks go to `listed`.
    pub fn list_into(
        device: &Device,
        shared: &Shared,
        slots: &Buffer<u32>,
        listed: &Buffer<[u32; 4]>,
    ) -> Result<[Bindings; 2]> {
        let Shared { jobs, counters, arguments, boxes, candidates } = shared;
        let known = [jobs.wgpu(), slots.wgpu(), boxes.wgpu()];
        let meeting = device.bind_as(&MEETING, &[&known[..], &[candidates.wgpu()]].concat())?;
        let bound = [listed.wgpu(), counters.wgpu(), arguments.wgpu(), candidates.wgpu()];
        Ok([meeting, device.bind_as(&LISTING, &[&known[..], &bound[..]].concat())?])
    }

    /// What culling lists tiles with, and blocks of them.
    pub fn listing(&self) -> &[Bindings; 2] {
        &self.listing
    }

    /// The list: tiles, blocks of them with the tile's size in the upper half, and a bit for every imprint.
    #[cfg(test)]
    pub fn listed(&self) -> &Buffer<[u32; 4]> {
        &self.listed
    }

    /// Records that nothing has a slot.
    pub fn clear_slots(&self, frame: &mut Frame) {
        frame.clear(&self.slots);
    }

    /// Records the rays of the blocks that were listed for the row that begins with `job`, and that those which changed
    /// are kept: of the displacement there is, and that from which the depth limit counts.
    pub fn cast(
        &self,
        pass: &mut Pass<'_>,
        shared: &Shared,
        surface: &DeviceSurface,
        (ground, start): (&BoundGround, &DeviceTiles),
        job: usize,
    ) -> Result<()> {
        let kernel = self.kernels.get(usize::from(ground.has_vectors));
        let kernel = kernel.ok_or_else(|| Error::internal("no kernel for rays of an object with vectors"))?;
        let groups = [&self.casting, surface.group(), &ground.group, start.group()];
        let jobs = step(job..job + 1);
        pass.run_indirect(kernel, &groups, bytemuck::bytes_of(&jobs), &shared.arguments, Shared::blocks(job))
    }

    /// Records that the `chosen` records are written into `tiles`.
    pub fn write(&self, device: &Device, frame: &mut Frame, tiles: &DeviceTiles, chosen: &[u32]) -> Result<()> {
        let count = chosen.len() as u32;
        let chosen = Buffer::of(device, "blocks that stay", chosen)?;
        let [entries, texels] = tiles.buffers();
        let bound = device.bind(&self.writing, 0, &[chosen.wgpu(), self.records.wgpu(), entries, texels])?;
        frame.pass("imprint.device.write").run(&self.writing, &[&bound], &count.to_ne_bytes(), groups(count))
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use crate::device::imprint::chain::DeviceChain;
    use crate::device::imprint::cull::tests::object;
    use crate::device::imprint::job::ImprintJob;
    use crate::device::imprint::meshes::DeviceMeshes;
    use crate::device::imprint::stages::Target;
    use crate::geometry::grid::Grid;
    use crate::geometry::obb::Obb;
    use crate::imprint::Imprinter;
    use crate::imprint::collider::Collider;
    use crate::imprint::dents::{TileDents, key};
    use crate::imprint::settings::ImprintSettings;
    use crate::object::shapes;
    use glam::{DAffine3, DMat3, DVec3};
    use half::f16;
    use relievo_core::Context;
    use relievo_testing::device;
    use relievo_tiles::Field;
    use std::collections::BTreeMap;

    /// The blocks that change, by tile and number.
    pub(in crate::device) fn changed(dents: &[TileDents]) -> BTreeMap<(u32, u32), Vec<f16>> {
        let blocks = dents.iter().flat_map(|it| it.blocks.iter().map(|block| (it.tile, block)));
        blocks.map(|(tile, block)| ((tile, block.index), block.values.to_vec())).collect()
    }

    #[test]
    fn coefficients_are_those_of_the_processor() {
        let Some(device) = device() else { return };
        let context = Context::serial();
        let mut object = object(&context);
        // Rings side by side and above each other, so that some columns are solid in pieces.
        let rings = shapes::joined(
            shapes::torus(1.0, 0.4, 48, 24),
            shapes::moved(shapes::torus(0.5, 0.15, 24, 12), [0.0, 0.0, 0.5]),
        );
        let place = object.transform().transform_point3(DVec3::new(3.4, 3.6, 0.1));
        let transform = DAffine3::from_translation(place) * DAffine3::from_rotation_x(1.2);
        let collider = Collider::new(&context, rings.0, rings.1, transform).unwrap();
        let begun = object.displacement().field().clone();
        let plain = ImprintSettings { max_displacement: 60_000.0, ..ImprintSettings::default() };
        let tight = ImprintSettings { share: 0.4, max_displacement: 0.15, depth_limit: 0.12, ..plain };
        let (mut chain, mut meshes) = (DeviceChain::new(&device).unwrap(), DeviceMeshes::new(&device).unwrap());
        let (mut rays, mut apart, mut clamped) = (0, 0, 0);
        for (settings, start, roomy) in
            [(plain, None::<&Field>, false), (tight, Some(&begun), false), (plain, None, true)]
        {
            let half = DVec3::new(1.3, 1.2, 0.9) * if roomy { 2.0 } else { 1.0 };
            let obb = Obb { center: place, axes: DMat3::from_rotation_x(0.4), half };
            let grid = Grid::new(&obb, 1 << 18, Some(2));
            let here = Imprinter::new().cast_here(&context, &mut object, &collider, start, &grid, &settings).unwrap();
            let job = ImprintJob::new(&context, 0, &collider, &grid, &settings.limits()).unwrap();
            object.use_device(Some(&device)).unwrap();
            let mut state = object.device.take().unwrap();
            let mut target = [Target { state: &mut state, object: &object, start }];
            let there = chain.run(&context, &mut meshes, &mut target, &[&collider], &[job]).unwrap().pop().unwrap();
            // Of a grid that is larger than the collider, its box along the axes of the grid leaves some out.
            let fewer = if roomy { there.tiles < here.tiles } else { there.tiles <= here.tiles };
            assert!(fewer, "{} of {} tiles", there.tiles, here.tiles);
            assert!(there.clamped.abs_diff(here.clamped) <= 1 + here.clamped / 1000);
            clamped += here.clamped;
            let (here, there) = (changed(&here.dents), changed(&there.dents));
            assert!(here.keys().eq(there.keys()));
            for (a, b) in here.values().flatten().zip(there.values().flatten()) {
                rays += 1;
                apart += u32::from(key(*a).abs_diff(key(*b)) > 1);
            }
        }
        println!("{apart} of {rays} coefficients are more than one half apart, {clamped} held");
        assert!(rays > 5_000 && clamped > 20, "{rays} {clamped}");
        assert!(apart * 10_000 < rays, "{apart} of {rays}");
    }
}
