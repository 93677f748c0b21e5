//! Where imprints of a submission leave what others of it look at: which objects have slots, and how many.

use relievo_tiles::Field;

use super::job::{ImprintJob, Slots};
use super::smoothing::SLOTS;
use super::stages::Target;
use crate::channels::knots::block_edge;

/// The targets whose tiles are worked on: the targets that several imprints meet, of which one or more are smoothed or
/// made with rings in between.
pub(super) fn works(targets: usize, jobs: &[ImprintJob]) -> Vec<bool> {
    let own = |target| jobs.iter().filter(move |job| job.target == target);
    let several = |target| own(target).count() > 1;
    (0..targets).map(|target| several(target) && own(target).any(|job| job.smoothing.1 > 0 || job.worked)).collect()
}

/// Where the blocks of every target are noted that imprints change before others look at them: of targets that several
/// imprints meet, or that rise. And how many such places there are.
pub(super) fn slots(targets: &[Target<'_>], jobs: &[ImprintJob], works: &[bool]) -> (Vec<Option<Slots>>, usize) {
    let mut count = 0;
    let each = targets.iter().enumerate().map(|(index, target)| {
        let own = || jobs.iter().filter(|job| job.target == index);
        if own().count() < 2 && own().all(|job| job.rising.is_none()) {
            return None;
        }
        let field = target.object.displacement().field();
        let stride = if works[index] { SLOTS } else { 2 + most_blocks(field) };
        let base = count;
        count += field.tile_count() * stride as usize;
        Some(Slots { base: base as u32, stride })
    });
    (each.collect(), count.max(1))
}

/// Blocks of a tile at most.
fn most_blocks(field: &Field) -> u32 {
    let blocks = |tile| (field.size(tile) / block_edge(field.size(tile))).pow(2);
    (0..field.tile_count() as u32).map(blocks).max().unwrap_or(1)
}

/// Where the blocks of every target are on which something rises, and how many a tile has. And how many there are.
pub(crate) fn places(targets: &[Target<'_>], jobs: &[ImprintJob]) -> (Vec<[u32; 2]>, usize) {
    let mut count = 0;
    let each = targets.iter().enumerate().map(|(index, target)| {
        if !jobs.iter().any(|job| job.target == index && job.rising.is_some()) {
            return [0; 2];
        }
        let field = target.object.displacement().field();
        let (base, blocks) = (count, most_blocks(field));
        count += field.tile_count() * blocks as usize;
        [base as u32, blocks]
    });
    (each.collect(), count)
}
