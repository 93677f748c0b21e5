//! Which imprints of a submission share dispatches: those whose colliders are voxelised together, those whose winding
//! numbers are there at once, and those of one object, whose blocks are found and cast together.

use std::ops::Range;

use relievo_core::Result;
use relievo_gpu::Device;

use super::job::JobParams;
use super::voxel::VoxelRoom;

/// Points and triangles that are on the lattices of several imprints at once, and words of winding numbers, unless one
/// alone has more: 320 MiB, which hold eight grids of 2²⁴ voxels.
const MAX_PLACED: usize = 1 << 22;
const MAX_VOXELS: usize = 5 << 24;

/// Imprints whose winding numbers are there at once.
#[derive(Clone, Debug)]
pub(super) struct Wave {
    pub jobs: Range<usize>,
    /// The largest number of columns.
    pub columns: u32,
    /// Winding numbers.
    turns: usize,
}

/// Imprints that are voxelised together, and whose voxels are there at once.
#[derive(Clone, Debug)]
pub(crate) struct Batch {
    pub jobs: Range<usize>,
    /// The largest numbers of points and of triangles.
    pub most: [u32; 2],
    /// Room that they need.
    pub room: VoxelRoom,
    pub waves: Vec<Wave>,
    /// The first imprint of every row: the next of the same object follow it by `ImprintJob.next`, up to one that raises
    /// something, which is a row of its own, as is every imprint of an object whose tiles are worked on.
    pub rows: Vec<usize>,
}

impl Batch {
    /// Of no imprint so far, from `index` on.
    fn from(index: usize) -> Self {
        Self { jobs: index..index, most: [0; 2], room: VoxelRoom::default(), waves: Vec::new(), rows: Vec::new() }
    }
}

/// Winding numbers that are there at once at most: no more than a buffer of `device` holds.
pub(super) fn most_voxels(device: &Device) -> usize {
    let held = device.limits().max_storage_buffer_binding_size / size_of::<u32>() as u64;
    usize::try_from(held).map_or(MAX_VOXELS, |held| held.min(MAX_VOXELS))
}

/// Says where the points, the work and the voxels of every imprint lie, and which is the next one of the same target, of
/// which `targets` tells for every imprint. There are no more winding numbers, and no more words of voxels, at once than
/// `most_voxels`, unless one imprint alone has more. Fails for a grid that is too wide.
pub(super) fn batches(words: &mut [JobParams], targets: &[usize], most_voxels: usize) -> Result<Vec<Batch>> {
    let mut batches: Vec<Batch> = Vec::new();
    for index in 0..words.len() {
        let it = &mut words[index];
        let mesh = it.mesh();
        let VoxelRoom([points, items, turns, columns, bits]) = VoxelRoom::of(mesh, it.dims())?;
        let fits = |batch: &&mut Batch| {
            let VoxelRoom([corners, work, _, _, words]) = batch.room;
            corners + work + points + items <= MAX_PLACED && words + bits <= most_voxels
        };
        let batch = match batches.last_mut().filter(fits) {
            Some(batch) => batch,
            None => {
                batches.push(Batch::from(index));
                let last = batches.len() - 1;
                &mut batches[last]
            }
        };
        let wave = match batch.waves.last_mut().filter(|wave| wave.turns + turns <= most_voxels) {
            Some(wave) => wave,
            None => {
                batch.waves.push(Wave { jobs: index..index, columns: 0, turns: 0 });
                let last = batch.waves.len() - 1;
                &mut batch.waves[last]
            }
        };
        let VoxelRoom([corner, work, _, column, word]) = batch.room;
        it.lie_at([corner, work, wave.turns, column, word], wave.jobs.start);
        batch.most = [0, 1].map(|k| batch.most[k].max(mesh[k]));
        let [nx, ny, _] = it.dims();
        wave.columns = wave.columns.max(nx * ny);
        wave.jobs.end = index + 1;
        wave.turns += turns;
        batch.room =
            batch.room.and(VoxelRoom([points, items, 0, columns, bits])).or(VoxelRoom([0, 0, wave.turns, 0, 0]));
        batch.jobs.end = index + 1;
        match (batch.jobs.start..index).rev().find(|before| targets[*before] == targets[index]) {
            Some(before) if words[before].is_for_row() && words[index].is_for_row() => words[before].go_on_with(index),
            _ => batch.rows.push(index),
        }
    }
    Ok(batches)
}
