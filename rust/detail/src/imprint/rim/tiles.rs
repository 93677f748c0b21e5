//! Rims on tiles: the blocks of coefficients around an imprint as pieces, and what rises of them.

use half::f16;
use relievo_core::{Context, Result};
use relievo_surface::{Grid as SampleGrid, Order, Placement, Samples};

use super::{Piece, Volumes, check_bytes, rise, surroundings};
use crate::channels::frame::{Frames, STILL};
use crate::channels::knots::{BLOCK_KNOTS, KnotBlock, block_edge};
use crate::channels::window::Window;
use crate::geometry::voxel::Voxels;
use crate::geometry::voxel_frame::VoxelFrame;
use crate::imprint::cull;
use crate::imprint::culled::CulledTile;
use crate::imprint::dents::{DentBlock, TileDents};
use crate::imprint::settings::ImprintSettings;
use crate::object::DisplacedObject;

/// Raises rims around what `dents` push away. `dents` are those of `voxels`, ascending by tile; they get the
/// coefficients that rise as well. Returns what every tile pushed and raised, ascending.
///
/// # Errors
/// Fails, and leaves `dents` as they are, with `Memory` if the blocks of coefficients within the rim's width exceed the
/// context's memory limit, or 2 GiB.
pub fn raise(
    context: &Context,
    object: &mut DisplacedObject,
    dents: &mut Vec<TileDents>,
    voxels: &Voxels,
    settings: &ImprintSettings,
) -> Result<Vec<(u32, Volumes)>> {
    let (places, pieces) = pieces(context, object, dents, voxels, settings.rim_width)?;
    let mut volumes: Vec<(u32, Volumes)> = Vec::new();
    for ((place, piece), risen) in places.iter().zip(&pieces).zip(rise(context, &pieces, settings)) {
        let sum = piece.moved(risen.as_ref());
        match volumes.last_mut() {
            Some((tile, volumes)) if *tile == place.tile => *volumes += sum,
            _ => volumes.push((place.tile, sum)),
        }
        let Some(values) = risen else { continue };
        let mut raised = TileDents { tile: place.tile, ..TileDents::default() };
        for (new, _) in values.iter().zip(&piece.values).filter(|(new, old)| new > old) {
            raised.changed += 1;
            raised.most = raised.most.max(*new);
        }
        raised.blocks.push(DentBlock { index: place.index, values });
        merge(dents, raised);
    }
    Ok(volumes)
}

/// Adds one block to the dents of its tile.
fn merge(dents: &mut Vec<TileDents>, raised: TileDents) {
    match dents.binary_search_by_key(&raised.tile, |dents| dents.tile) {
        Err(at) => dents.insert(at, raised),
        Ok(at) => {
            let dents = &mut dents[at];
            dents.changed += raised.changed;
            dents.most = dents.most.max(raised.most);
            for block in raised.blocks {
                match dents.blocks.binary_search_by_key(&block.index, |block| block.index) {
                    Ok(at) => dents.blocks[at] = block,
                    Err(at) => dents.blocks.insert(at, block),
                }
            }
        }
    }
}

/// Where a block of coefficients is.
struct Place {
    tile: u32,
    /// Its number in the tile.
    index: u32,
    /// Blocks along the tile, and coefficients along a block.
    blocks: u32,
    edge: usize,
}

/// The blocks within `width` of what `dents` push away, ascending by tile and number.
fn pieces(
    context: &Context,
    object: &mut DisplacedObject,
    dents: &[TileDents],
    voxels: &Voxels,
    width: f32,
) -> Result<(Vec<Place>, Vec<Piece>)> {
    let mut culled = cull::cull(context, object, &surroundings(&voxels.grid().obb, object.transform(), width));
    culled.sort_unstable_by_key(|culled| culled.tile);
    check_bytes(context, culled.iter().map(|culled| culled.blocks.len()).sum())?;
    let frame = VoxelFrame::new(voxels.grid(), object.transform());
    let object = &*object;
    let pieces = context.map(culled.len(), |index| {
        let CulledTile { tile, blocks } = &culled[index];
        let dents = dents.binary_search_by_key(tile, |dents| dents.tile).ok().map(|at| &dents[at]);
        let mut samples = Samples::default();
        let piece = |index| Piece::new(context, object, *tile, index, dents, &frame, voxels, &mut samples);
        blocks.iter().map(|block| block.index).map(piece).collect::<Vec<_>>()
    });
    let (places, mut pieces): (Vec<Place>, Vec<Piece>) = pieces.into_iter().flatten().unzip();
    let borders = context.map(pieces.len(), |at| border(&places, &pieces, at));
    for (piece, border) in pieces.iter_mut().zip(borders) {
        piece.border = border;
    }
    Ok((places, pieces))
}

/// The coefficients of a block that are pushed and beside which others may not be; beyond the tile nothing is known.
fn border(places: &[Place], pieces: &[Piece], at: usize) -> [bool; BLOCK_KNOTS] {
    let (place, piece) = (&places[at], &pieces[at]);
    let (edge, blocks) = (place.edge as i32, place.blocks as i32);
    let (column, row) = (place.index as i32 % blocks * edge, place.index as i32 / blocks * edge);
    let pushed = |i: i32, j: i32| {
        if i < 0 || j < 0 || i >= blocks * edge || j >= blocks * edge {
            return false;
        }
        let index = (j / edge * blocks + i / edge) as u32;
        let k = (j % edge * edge + i % edge) as usize;
        if index == place.index {
            return piece.depth[k] > 0.0;
        }
        let found = places.binary_search_by_key(&(place.tile, index), |place| (place.tile, place.index));
        found.is_ok_and(|at| pieces[at].depth[k] > 0.0)
    };
    std::array::from_fn(|k| {
        let (i, j) = (column + k as i32 % edge, row + k as i32 / edge);
        piece.depth[k] > 0.0 && !(pushed(i - 1, j) && pushed(i + 1, j) && pushed(i, j - 1) && pushed(i, j + 1))
    })
}

impl Piece {
    #[allow(clippy::too_many_arguments)]
    fn new(
        context: &Context,
        object: &DisplacedObject,
        tile: u32,
        index: u32,
        dents: Option<&TileDents>,
        frame: &VoxelFrame,
        voxels: &Voxels,
        samples: &mut Samples,
    ) -> (Place, Self) {
        let field = object.displacement().field();
        let size = field.size(tile);
        let edge = block_edge(size);
        let (column, row) = (index % (size / edge) * edge, index / (size / edge) * edge);
        let grid =
            SampleGrid { size, placement: Placement::Centred, columns: column..column + edge, rows: row..row + edge };
        object.surface().grid(context.level(), tile, &grid, Order::First, samples);
        let mut piece = Self { count: grid.len(), ..Self::EMPTY };
        let mut way = STILL;
        if object.ground().vectors(context.level(), &Window::new(tile, size, index), &mut way) {
            let (mut knots, mut frames) = (KnotBlock::ZERO, Frames::ZERO);
            knots.evaluate_framed(context.level(), object.surface(), (tile, size, index), &mut frames);
            frames.to_object(context.level(), &knots.n, &mut way);
        }
        let old = field.block(tile);
        let dent = dents.and_then(|dents| {
            dents.blocks.binary_search_by_key(&index, |block| block.index).ok().map(|at| &dents.blocks[at])
        });
        for k in 0..grid.len() {
            let (j, i) = (row as usize + k / edge as usize, column as usize + k % edge as usize);
            let before = old.map_or(f16::ZERO, |old| old[(j + 1) * (size as usize + 2) + i + 1]);
            piece.values[k] = dent.map_or(before, |dent| dent.values[k]);
            piece.depth[k] = before.to_f32() - piece.values[k].to_f32();
            let at = |values: &[Vec<f32>; 3]| glam::Vec3::new(values[0][k], values[1][k], values[2][k]);
            let (p, cross) = (at(&samples.p), at(&samples.du).cross(at(&samples.dv)));
            let length = cross.length();
            piece.area[k] = length / (size * size) as f32;
            piece.spacing = piece.spacing.max(2.0 * piece.area[k].sqrt());
            for axis in 0..3 {
                piece.p[axis][k] = p[axis];
            }
            let place = p
                + glam::Vec3::new(way[0][k], way[1][k], way[2][k])
                + cross * (piece.values[k].to_f32() / length.max(f32::MIN_POSITIVE));
            piece.free[k] = length > 0.0 && piece.depth[k] <= 0.0 && !voxels.contains(frame.place(place.to_array()));
        }
        (Place { tile, index, blocks: size / edge, edge: edge as usize }, piece)
    }
}
