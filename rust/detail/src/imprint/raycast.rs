//! The displacement update: every coefficient's point that lies in the voxels is moved along −N until it leaves them
//! (Schäfer et al. 2014, Section 6). Coefficients are constrained, not fitted.
//!
//! Distances are measured along the image of the object's own normal, so they are in object units whatever the
//! object's scale. Results are rounded to half floats away from the collider.

use half::f16;
use half::slice::HalfFloatSliceExt;
use relievo_core::lanes::Lanes;
use relievo_core::{Context, dispatch_simd};
use relievo_tiles::Field;

use crate::channels::frame::{Frames, STILL};
use crate::channels::knots::{BLOCK_KNOTS, KnotBlock, block_edge};
use crate::channels::window::Window;
use crate::geometry::rays::Rays;
use crate::geometry::voxel::{Columns, Voxels};
use crate::geometry::voxel_frame::VoxelFrame;
use crate::imprint::culled::CulledTile;
use crate::imprint::dents::{DentBlock, Limits, TileDents, deepest, key, stepped_down, unkey};
use crate::imprint::settings::ImprintSettings;
use crate::object::DisplacedObject;
use crate::paint::ground::Ground;

/// Casts the rays of all coefficients of `object` in `tiles` into `voxels`, and returns what changes, in the order of `tiles`.
///
/// The depth limit counts from `start`, or from what the displacements are. Where the object has vectors, rays start where
/// these bring the coefficients' points.
pub fn cast(
    context: &Context,
    object: &DisplacedObject,
    start: Option<&Field>,
    tiles: &[CulledTile],
    voxels: &Voxels,
    settings: &ImprintSettings,
) -> Vec<TileDents> {
    let limits = settings.limits();
    if limits.share <= 0.0 {
        return Vec::new();
    }
    let frame = VoxelFrame::new(voxels.grid(), object.transform());
    let mut dents = context.scratch().take_list();
    context.map_into(tiles.len(), &mut dents, |index| {
        cast_tile(context, object, start, &tiles[index], &frame, voxels, &limits)
    });
    dents
}

/// Gives the room of dents back to the context that their rays were cast with.
pub(crate) fn give_back(context: &Context, mut dents: Vec<TileDents>) {
    dents.drain(..).for_each(|dents| context.scratch().keep_list(dents.blocks));
    context.scratch().keep_list(dents);
}

fn cast_tile(
    context: &Context,
    object: &DisplacedObject,
    start: Option<&Field>,
    culled: &CulledTile,
    frame: &VoxelFrame,
    voxels: &Voxels,
    limits: &Limits,
) -> TileDents {
    let (tile, level, surface) = (culled.tile, context.level(), object.surface());
    let ground = object.ground();
    let Ground { heights: field, vectors } = ground;
    let size = field.size(tile);
    let edge = block_edge(size);
    let count = (edge * edge) as usize;
    let columns = voxels.columns();
    // With room for the whole tile, so that whoever gets the list next has enough.
    let mut blocks = context.scratch().take_list();
    blocks.reserve((size / edge).pow(2) as usize);
    let mut dents = TileDents { tile, blocks, ..TileDents::default() };
    // What the coefficients are, and what they were if that matters; unallocated ones are zero.
    let sources = [field.block(tile), start.and_then(|start| start.block(tile))];
    let mut values = [[f16::ZERO; BLOCK_KNOTS]; 2];
    let mut knots = KnotBlock::ZERO;
    let mut scratch = Scratch::default();
    let bent = vectors.is_some_and(|vectors| vectors.is_allocated(tile));
    let (mut frames, mut way) = (Frames::ZERO, STILL);
    for block in culled.blocks.iter().filter(|block| voxels.may_meet(block.low, block.high)) {
        let (column, row) = (block.index % (size / edge) * edge, block.index / (size / edge) * edge);
        for (source, values) in sources.iter().zip(&mut values) {
            let Some(source) = source else { continue };
            for (j, values) in values.chunks_mut(edge as usize).take(edge as usize).enumerate() {
                let first = ((row + 1) as usize + j) * (size as usize + 2) + column as usize + 1;
                values.copy_from_slice(&source[first..first + edge as usize]);
            }
        }
        if bent {
            knots.evaluate_framed(level, surface, (tile, size, block.index), &mut frames);
            ground.vectors(level, &Window::new(tile, size, block.index), &mut way);
            knots.shift(level, &frames, &way);
        } else {
            knots.evaluate(level, surface, tile, size, block.index);
        }
        let changed = cast_block(
            level,
            frame,
            &knots,
            &values[0][..count],
            start.map(|_| &values[1]),
            &columns,
            limits,
            &mut scratch,
            &mut dents,
        );
        if changed > 0 {
            dents.blocks.push(DentBlock { index: block.index, values: scratch.new });
            dents.changed += changed;
        }
        dents.tested += count as u32;
    }
    dents
}

dispatch_simd! {
    /// Casts the rays of a block, leaves the coefficients as they are to be in `scratch` and returns how many change.
    pub(crate) fn cast_block = cast_block_body(
        frame: &VoxelFrame, knots: &KnotBlock, values: &[f16], start: Option<&[f16; BLOCK_KNOTS]>,
        columns: &Columns<'_>, limits: &Limits, scratch: &mut Scratch, dents: &mut TileDents
    ) -> u32
}

#[inline(always)]
#[allow(clippy::too_many_arguments)]
fn cast_block_body<A: Lanes>(
    v: A,
    frame: &VoxelFrame,
    knots: &KnotBlock,
    values: &[f16],
    start: Option<&[f16; BLOCK_KNOTS]>,
    columns: &Columns<'_>,
    limits: &Limits,
    scratch: &mut Scratch,
    dents: &mut TileDents,
) -> u32 {
    let count = values.len();
    let Scratch { heights, starts, distance, nearest, new } = scratch;
    values.convert_to_f32_slice(&mut heights[..count]);
    let starts = match start {
        Some(start) => {
            start[..count].convert_to_f32_slice(&mut starts[..count]);
            &*starts
        }
        None => &*heights,
    };
    let mut any = false;
    for at in (0..count).step_by(A::WIDTH) {
        let p = [v.load(&knots.p[0][at..]), v.load(&knots.p[1][at..]), v.load(&knots.p[2][at..])];
        let n = [v.load(&knots.n[0][at..]), v.load(&knots.n[1][at..]), v.load(&knots.n[2][at..])];
        let height = [v.load(&heights[at..]), v.load(&starts[at..])];
        let ready = Rays::new(v, frame, columns, limits, p, n, height);
        let (distances, clamped) = ready.distances(v, columns);
        any |= v.mask(v.lt(v.splat(0.0), distances)) != 0;
        dents.clamped += clamped;
        v.store(distances, &mut distance[at..]);
    }
    if !any {
        return 0;
    }
    for (distance, height) in distance[..count].iter_mut().zip(&heights[..count]) {
        *distance = height - limits.share * *distance;
    }
    new[..count].convert_from_f32_slice(&distance[..count]);
    new[..count].convert_to_f32_slice(&mut nearest[..count]);
    let deepest = deepest(limits);
    let (mut changed, mut least) = (0, 0);
    for (((new, nearest), exact), old) in new.iter_mut().zip(&*nearest).zip(&*distance).zip(values) {
        let down = stepped_down(*new, *nearest, *exact).max(deepest);
        let old = key(*old);
        changed += u32::from(down < old);
        let key = down.min(old);
        least = least.min(key);
        *new = unkey(key);
    }
    dents.least = dents.least.min(unkey(least));
    changed
}

/// What is computed of a block side by side; kept between blocks so that it need not be cleared.
pub(crate) struct Scratch {
    heights: [f32; BLOCK_KNOTS],
    starts: [f32; BLOCK_KNOTS],
    distance: [f32; BLOCK_KNOTS],
    nearest: [f32; BLOCK_KNOTS],
    new: [f16; BLOCK_KNOTS],
}

impl Default for Scratch {
    fn default() -> Self {
        let zero = [0.0; BLOCK_KNOTS];
        Self { heights: zero, starts: zero, distance: zero, nearest: zero, new: [f16::ZERO; BLOCK_KNOTS] }
    }
}

impl Scratch {
    /// The coefficients as they are to be.
    pub fn new(&self) -> &[f16; BLOCK_KNOTS] {
        &self.new
    }
}
