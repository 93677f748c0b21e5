//! Rims: a share of what an imprint pushes away rises around it, as snow and sand do (Sumner, O'Brien, Hodgins 1999,
//! *Animating Sand, Mud, and Snow*, Section 3). There, columns are displaced outwards and slide until no slope is too
//! steep. Here, coefficients within a distance of the contact are raised by a profile of bounded slope, which needs no
//! iteration and no order of the tiles. Distances are those between points of the undisplaced surface.
//!
//! Every patch of contact has a rim of its own, whose height follows from the volume that was pushed away there. The
//! height ends where the slope would exceed the angle of repose; what then finds no place is lost, and the volumes that
//! are returned say so. They are volumes over the limit surface, without regard of its curvature.

use std::collections::BTreeMap;
use std::ops::AddAssign;

use half::f16;
use relievo_core::simd::{Arithmetic, Level};
use relievo_core::{Context, Error, Result, dispatch_simd};
use relievo_surface::{Grid as SampleGrid, Order, Placement, Samples};

use crate::cull::{self, CulledTile, VoxelFrame};
use crate::grid::Grid;
use crate::imprint::ImprintSettings;
use crate::knots::{BLOCK_KNOTS, block_edge};
use crate::object::DisplacedObject;
use crate::raycast::{DentBlock, TileDents};
use crate::voxel::Voxels;

/// What an imprint moved, in object units cubed.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Volumes {
    /// What was pushed away.
    pub pushed: f64,
    /// What rose.
    pub raised: f64,
}

impl AddAssign for Volumes {
    fn add_assign(&mut self, other: Self) {
        self.pushed += other.pushed;
        self.raised += other.raised;
    }
}

/// Raises rims around what `dents` push away. `dents` are those of `voxels`, ascending by tile; they get the
/// coefficients that rise as well.
///
/// Fails if the blocks of coefficients within the rim's width exceed the context's memory limit, or 2 GiB.
pub fn raise(
    context: &Context,
    object: &mut DisplacedObject,
    dents: &mut Vec<TileDents>,
    voxels: &Voxels,
    settings: &ImprintSettings,
) -> Result<Volumes> {
    let width = settings.rim_width;
    let pieces = pieces(context, object, dents, voxels, f64::from(width))?;
    let widest = pieces.iter().flat_map(|piece| &piece.area).fold(0.0f32, |most, area| most.max(*area));
    // Neighbouring coefficients are in neighbouring cells.
    let edge = f64::from(width.max(2.0 * widest.sqrt()));
    let mut pushed: BTreeMap<Cell, f64> = BTreeMap::new();
    for (cell, volume) in context.map(pieces.len(), |index| pieces[index].volumes(edge)).into_iter().flatten() {
        *pushed.entry(cell).or_default() += volume;
    }
    let patches = patches(&pushed);
    let mut volumes = vec![0.0; patches.values().max().map_or(0, |last| *last as usize + 1)];
    for (cell, volume) in &pushed {
        volumes[patches[cell] as usize] += volume;
    }
    let mut border: BTreeMap<Cell, Vec<Border>> = BTreeMap::new();
    for piece in &pieces {
        for k in piece.border(&pieces) {
            let cell = piece.cell(k, edge);
            border.entry(cell).or_default().push(Border { point: piece.point(k), patch: patches[&cell] });
        }
    }
    let level = context.level();
    let profiles = context.map(pieces.len(), |index| Profile::new(level, &pieces[index], &border, edge, width));
    let mut room = vec![0.0; volumes.len()];
    for (piece, profile) in pieces.iter().zip(&profiles) {
        for (k, height) in profile.rising() {
            room[profile.patch[k] as usize] += f64::from(height * piece.area[k]);
        }
    }
    // The profile is steepest half-way out, where it falls by 3/2 of its height per width.
    let highest = f64::from(width) * f64::from(settings.repose).tan() / 1.5;
    let share = f64::from(settings.rim);
    let heights: Vec<f64> = volumes.iter().zip(&room).map(|(volume, room)| share * volume / room.max(1e-300)).collect();
    let mut sum = Volumes { pushed: volumes.iter().sum(), raised: 0.0 };
    for (piece, profile) in pieces.iter().zip(&profiles) {
        let mut block = DentBlock { index: piece.index, values: piece.values };
        let mut raised = TileDents { tile: piece.tile, ..TileDents::default() };
        for (k, height) in profile.rising() {
            let old = piece.values[k].to_f32();
            let height = f64::from(height);
            let new = (f64::from(old) + heights[profile.patch[k] as usize] * height).min(highest * height);
            let new = f16::from_f64(new);
            if new.to_f32() > old {
                block.values[k] = new;
                raised.changed += 1;
                raised.most = raised.most.max(new);
                sum.raised += f64::from((new.to_f32() - old) * piece.area[k]);
            }
        }
        if raised.changed > 0 {
            raised.blocks.push(block);
            merge(dents, raised);
        }
    }
    Ok(sum)
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

/// A cell of space.
type Cell = [i64; 3];

fn cell(point: [f32; 3], edge: f64) -> Cell {
    point.map(|value| (f64::from(value) / edge).floor() as i64)
}

fn around([x, y, z]: Cell) -> impl Iterator<Item = Cell> {
    let near = |value: i64| value.saturating_sub(1)..=value.saturating_add(1);
    near(x).flat_map(move |x| near(y).flat_map(move |y| near(z).map(move |z| [x, y, z])))
}

/// The patches of contact: connected cells, numbered in their order.
fn patches(cells: &BTreeMap<Cell, f64>) -> BTreeMap<Cell, u32> {
    let mut patches = BTreeMap::new();
    let mut count = 0;
    let mut open = Vec::new();
    for cell in cells.keys() {
        if patches.contains_key(cell) {
            continue;
        }
        patches.insert(*cell, count);
        open.push(*cell);
        while let Some(cell) = open.pop() {
            for next in around(cell).filter(|next| cells.contains_key(next)) {
                patches.entry(next).or_insert_with(|| {
                    open.push(next);
                    count
                });
            }
        }
        count += 1;
    }
    patches
}

/// A coefficient at the border of the contact.
#[derive(Clone, Copy)]
struct Border {
    point: [f32; 3],
    patch: u32,
}

/// Bytes that the blocks around a contact may take.
const MOST_BYTES: u64 = 1 << 31;

/// A block of coefficients in the contact or around it.
struct Piece {
    tile: u32,
    /// Its number in the tile.
    index: u32,
    /// Blocks along the tile, and coefficients along a block.
    blocks: u32,
    edge: usize,
    /// What the coefficients are to be after the imprint.
    values: [f16; BLOCK_KNOTS],
    /// How far they are pushed.
    depth: [f32; BLOCK_KNOTS],
    /// Whether they may rise: neither pushed nor under the collider.
    free: [bool; BLOCK_KNOTS],
    /// Their points on the undisplaced surface.
    p: [[f32; BLOCK_KNOTS]; 3],
    /// The area of the surface that each stands for.
    area: [f32; BLOCK_KNOTS],
}

/// The blocks within `width` of what `dents` push away, ascending by tile and number.
fn pieces(
    context: &Context,
    object: &mut DisplacedObject,
    dents: &[TileDents],
    voxels: &Voxels,
    width: f64,
) -> Result<Vec<Piece>> {
    let scale = object.transform().matrix3;
    let stretch = scale.x_axis.length().max(scale.y_axis.length()).max(scale.z_axis.length());
    let obb = voxels.grid().obb.enlarged(width * stretch);
    let mut culled = cull::cull(context, object, &Grid::new(&obb, 4096, None));
    culled.sort_unstable_by_key(|culled| culled.tile);
    let count: usize = culled.iter().map(|culled| culled.blocks.len()).sum();
    let bytes = (count * size_of::<Piece>()) as u64;
    if bytes > context.memory_limit().min(MOST_BYTES) {
        return Err(Error::memory(format!("the surface within the width of the rim takes {bytes} bytes"))
            .at("rim_width")
            .advise("make the rim narrower or the tiles coarser"));
    }
    let frame = VoxelFrame::new(voxels.grid(), object.transform());
    let object = &*object;
    let pieces = context.map(culled.len(), |index| {
        let CulledTile { tile, blocks } = &culled[index];
        let dents = dents.binary_search_by_key(tile, |dents| dents.tile).ok().map(|at| &dents[at]);
        let mut samples = Samples::default();
        let piece = |index| Piece::new(context, object, *tile, index, dents, &frame, voxels, &mut samples);
        blocks.iter().map(|block| block.index).map(piece).collect::<Vec<_>>()
    });
    Ok(pieces.into_iter().flatten().collect())
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
    ) -> Self {
        let field = object.displacement().field();
        let size = field.size(tile);
        let edge = block_edge(size);
        let (column, row) = (index % (size / edge) * edge, index / (size / edge) * edge);
        let grid =
            SampleGrid { size, placement: Placement::Centred, columns: column..column + edge, rows: row..row + edge };
        object.surface().grid(context.level(), tile, &grid, Order::First, samples);
        let mut piece = Self {
            tile,
            index,
            blocks: size / edge,
            edge: edge as usize,
            values: [f16::ZERO; BLOCK_KNOTS],
            depth: [0.0; BLOCK_KNOTS],
            free: [false; BLOCK_KNOTS],
            p: [[0.0; BLOCK_KNOTS]; 3],
            area: [0.0; BLOCK_KNOTS],
        };
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
            for axis in 0..3 {
                piece.p[axis][k] = p[axis];
            }
            let place = p + cross * (piece.values[k].to_f32() / length.max(f32::MIN_POSITIVE));
            piece.free[k] = length > 0.0 && piece.depth[k] <= 0.0 && !voxels.contains(frame.place(place.to_array()));
        }
        piece
    }

    fn count(&self) -> usize {
        self.edge * self.edge
    }

    fn point(&self, k: usize) -> [f32; 3] {
        [self.p[0][k], self.p[1][k], self.p[2][k]]
    }

    fn cell(&self, k: usize, edge: f64) -> Cell {
        cell(self.point(k), edge)
    }

    /// The volumes that are pushed away, by cell.
    fn volumes(&self, edge: f64) -> Vec<(Cell, f64)> {
        let mut volumes: Vec<(Cell, f64)> = Vec::new();
        for k in (0..self.count()).filter(|k| self.depth[*k] > 0.0) {
            let (cell, volume) = (self.cell(k, edge), f64::from(self.depth[k] * self.area[k]));
            match volumes.iter_mut().find(|(other, _)| *other == cell) {
                Some((_, sum)) => *sum += volume,
                None => volumes.push((cell, volume)),
            }
        }
        volumes
    }

    /// Pushed coefficients beside which others may not be. `pieces` are all, in their order; beyond the tile nothing is
    /// known.
    fn border<'a>(&'a self, pieces: &'a [Piece]) -> impl Iterator<Item = usize> + 'a {
        let (edge, blocks) = (self.edge as i32, self.blocks as i32);
        let (column, row) = (self.index as i32 % blocks * edge, self.index as i32 / blocks * edge);
        let pushed = move |i: i32, j: i32| {
            if i < 0 || j < 0 || i >= blocks * edge || j >= blocks * edge {
                return false;
            }
            let index = (j / edge * blocks + i / edge) as u32;
            let k = (j % edge * edge + i % edge) as usize;
            if index == self.index {
                return self.depth[k] > 0.0;
            }
            let found = pieces.binary_search_by_key(&(self.tile, index), |piece| (piece.tile, piece.index));
            found.is_ok_and(|at| pieces[at].depth[k] > 0.0)
        };
        (0..self.count()).filter(move |k| {
            let (i, j) = (column + *k as i32 % edge, row + *k as i32 / edge);
            self.depth[*k] > 0.0 && !(pushed(i - 1, j) && pushed(i + 1, j) && pushed(i, j - 1) && pushed(i, j + 1))
        })
    }
}

/// The rim's profile over a block: the share of its height, and of which patch.
struct Profile {
    height: [f32; BLOCK_KNOTS],
    patch: [u32; BLOCK_KNOTS],
}

impl Profile {
    /// Falls from 1 at the nearest of `border` to 0 at `width`, with the slope 0 at both.
    fn new(level: Level, piece: &Piece, border: &BTreeMap<Cell, Vec<Border>>, edge: f64, width: f32) -> Self {
        let mut profile = Self { height: [0.0; BLOCK_KNOTS], patch: [0; BLOCK_KNOTS] };
        if !piece.free.contains(&true) {
            return profile;
        }
        let mut low = [f32::INFINITY; 3];
        let mut high = [f32::NEG_INFINITY; 3];
        for k in 0..piece.count() {
            for axis in 0..3 {
                low[axis] = low[axis].min(piece.p[axis][k]);
                high[axis] = high[axis].max(piece.p[axis][k]);
            }
        }
        let (first, last) = (cell(low, edge), cell(high, edge));
        let (first, last) = (first.map(|place| place.saturating_sub(1)), last.map(|place| place.saturating_add(1)));
        let near = |cell: &Cell| (0..3).all(|axis| cell[axis] >= first[axis] && cell[axis] <= last[axis]);
        let beside = |at: &Border| {
            (0..3).all(|axis| at.point[axis] >= low[axis] - width && at.point[axis] <= high[axis] + width)
        };
        let cells = border.range([first[0], i64::MIN, i64::MIN]..=[last[0], i64::MAX, i64::MAX]);
        let border = cells.filter(|(cell, _)| near(cell)).flat_map(|(_, border)| border).copied();
        let border: Vec<Border> = border.filter(beside).collect();
        let mut nearest = [width * width; BLOCK_KNOTS];
        find_nearest(level, &piece.p, &border, &mut nearest, &mut profile.patch);
        for k in (0..piece.count()).filter(|k| piece.free[*k] && nearest[*k] < width * width) {
            let s = nearest[k].sqrt() / width;
            profile.height[k] = (1.0 - s) * (1.0 - s) * (1.0 + 2.0 * s);
        }
        profile
    }

    /// The coefficients that rise, and their share of the height.
    fn rising(&self) -> impl Iterator<Item = (usize, f32)> + use<'_> {
        self.height.iter().enumerate().filter(|(_, height)| **height > 0.0).map(|(k, height)| (k, *height))
    }
}

dispatch_simd! {
    /// Lowers `nearest` to the squares of the distances to the nearest of `border`, and notes its patch.
    fn find_nearest = find_nearest_body(
        p: &[[f32; BLOCK_KNOTS]; 3], border: &[Border], nearest: &mut [f32; BLOCK_KNOTS], patch: &mut [u32; BLOCK_KNOTS]
    )
}

#[inline(always)]
fn find_nearest_body<A: Arithmetic>(
    p: &[[f32; BLOCK_KNOTS]; 3],
    border: &[Border],
    nearest: &mut [f32; BLOCK_KNOTS],
    patch: &mut [u32; BLOCK_KNOTS],
) {
    for border in border {
        for k in 0..BLOCK_KNOTS {
            let (x, y, z) = (p[0][k] - border.point[0], p[1][k] - border.point[1], p[2][k] - border.point[2]);
            let square = A::fma(x, x, A::fma(y, y, z * z));
            let nearer = square < nearest[k];
            nearest[k] = if nearer { square } else { nearest[k] };
            patch[k] = if nearer { border.patch } else { patch[k] };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_that_touch_are_one_patch() {
        let cells = [[0, 0, 0], [1, 1, 1], [2, 1, 0], [5, 0, 0], [5, 2, 0], [6, 1, 0]];
        let patches = patches(&cells.map(|cell| (cell, 1.0)).into());
        assert_eq!(cells.map(|cell| patches[&cell]), [0, 0, 0, 1, 1, 1]);
    }
}
