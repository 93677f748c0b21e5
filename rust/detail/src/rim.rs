//! Rims: a share of what an imprint pushes away rises around it, as snow and sand do (Sumner, O'Brien, Hodgins 1999,
//! *Animating Sand, Mud, and Snow*, Section 3). There, columns are displaced outwards and slide until no slope is too
//! steep. Here, values within a distance of the contact are raised by a profile of bounded slope, which needs no
//! iteration and no order of the faces. Distances are those between points of the undisplaced surface.
//!
//! Every patch of contact has a rim of its own, whose height follows from the volume that was pushed away there. The
//! height ends where the slope would exceed the angle of repose; what then finds no place is lost, and the volumes that
//! are returned say so. They are volumes over the surface without its displacement, without regard of its curvature.
//!
//! [`rise`] knows places with areas, whatever surface they are on; [`raise`] takes it to the coefficients of tiles, and
//! `triangle::rim` to the values of triangle meshes.

use std::collections::BTreeMap;
use std::iter::Sum;
use std::ops::{Add, AddAssign};

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

impl Add for Volumes {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self { pushed: self.pushed + other.pushed, raised: self.raised + other.raised }
    }
}

impl AddAssign for Volumes {
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl Sum for Volumes {
    fn sum<I: Iterator<Item = Self>>(volumes: I) -> Self {
        volumes.fold(Self::default(), Self::add)
    }
}

/// Up to 256 places of a surface in the contact or around it.
pub(crate) struct Piece {
    pub count: usize,
    /// What the values there are to be after the imprint.
    pub values: [f16; BLOCK_KNOTS],
    /// How far they are pushed.
    pub depth: [f32; BLOCK_KNOTS],
    /// Whether they may rise: neither pushed nor under the collider.
    pub free: [bool; BLOCK_KNOTS],
    /// Whether they are pushed and have a neighbour that may not be.
    pub border: [bool; BLOCK_KNOTS],
    /// Their points on the undisplaced surface.
    pub p: [[f32; BLOCK_KNOTS]; 3],
    /// The area of the surface that each stands for.
    pub area: [f32; BLOCK_KNOTS],
    /// No neighbours are further apart.
    pub spacing: f32,
}

/// Bytes that the pieces around a contact may take.
const MOST_BYTES: u64 = 1 << 31;

/// Fails if `count` pieces exceed the context's memory limit, or 2 GiB.
pub(crate) fn check_bytes(context: &Context, count: usize) -> Result<()> {
    let bytes = (count * size_of::<Piece>()) as u64;
    if bytes <= context.memory_limit().min(MOST_BYTES) {
        return Ok(());
    }
    Err(Error::memory(format!("the surface within the width of the rim takes {bytes} bytes"))
        .at("rim_width")
        .advise("make the rim narrower or the surface's values coarser"))
}

/// What the values of every piece are to be when a share of what is pushed away has risen; `None` where nothing rises.
/// Values that do not rise stay as they are in the piece.
pub(crate) fn rise(context: &Context, pieces: &[Piece], settings: &ImprintSettings) -> Vec<Option<[f16; BLOCK_KNOTS]>> {
    let width = settings.rim_width;
    // Neighbours are in neighbouring cells.
    let edge = f64::from(pieces.iter().map(|piece| piece.spacing).fold(width, f32::max));
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
    for piece in pieces {
        for k in (0..piece.count).filter(|k| piece.border[*k]) {
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
    let risen = pieces.iter().zip(&profiles).map(|(piece, profile)| {
        let mut values = piece.values;
        let mut any = false;
        for (k, height) in profile.rising() {
            let old = piece.values[k].to_f32();
            let height = f64::from(height);
            let new = (f64::from(old) + heights[profile.patch[k] as usize] * height).min(highest * height);
            let new = f16::from_f64(new);
            if new.to_f32() > old {
                values[k] = new;
                any = true;
            }
        }
        any.then_some(values)
    });
    risen.collect()
}

/// Raises rims around what `dents` push away. `dents` are those of `voxels`, ascending by tile; they get the
/// coefficients that rise as well. Returns what every tile pushed and raised, ascending.
///
/// Fails if the blocks of coefficients within the rim's width exceed the context's memory limit, or 2 GiB.
pub fn raise(
    context: &Context,
    object: &mut DisplacedObject,
    dents: &mut Vec<TileDents>,
    voxels: &Voxels,
    settings: &ImprintSettings,
) -> Result<Vec<(u32, Volumes)>> {
    let (places, pieces) = pieces(context, object, dents, voxels, f64::from(settings.rim_width))?;
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

/// A place at the border of the contact.
#[derive(Clone, Copy)]
struct Border {
    point: [f32; 3],
    patch: u32,
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
    width: f64,
) -> Result<(Vec<Place>, Vec<Piece>)> {
    let scale = object.transform().matrix3;
    let stretch = scale.x_axis.length().max(scale.y_axis.length()).max(scale.z_axis.length());
    let obb = voxels.grid().obb.enlarged(width * stretch);
    let mut culled = cull::cull(context, object, &Grid::new(&obb, 4096, None));
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
    /// Places of which nothing is known yet.
    pub const EMPTY: Self = Self {
        count: 0,
        values: [f16::ZERO; BLOCK_KNOTS],
        depth: [0.0; BLOCK_KNOTS],
        free: [false; BLOCK_KNOTS],
        border: [false; BLOCK_KNOTS],
        p: [[0.0; BLOCK_KNOTS]; 3],
        area: [0.0; BLOCK_KNOTS],
        spacing: 0.0,
    };

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
            let place = p + cross * (piece.values[k].to_f32() / length.max(f32::MIN_POSITIVE));
            piece.free[k] = length > 0.0 && piece.depth[k] <= 0.0 && !voxels.contains(frame.place(place.to_array()));
        }
        (Place { tile, index, blocks: size / edge, edge: edge as usize }, piece)
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
        for k in (0..self.count).filter(|k| self.depth[*k] > 0.0) {
            let (cell, volume) = (self.cell(k, edge), f64::from(self.depth[k] * self.area[k]));
            match volumes.iter_mut().find(|(other, _)| *other == cell) {
                Some((_, sum)) => *sum += volume,
                None => volumes.push((cell, volume)),
            }
        }
        volumes
    }

    /// What place `k` moves where its value rises to what it is in `risen`.
    pub fn moved_at(&self, k: usize, risen: Option<&[f16; BLOCK_KNOTS]>) -> Volumes {
        let up = risen.map_or(0.0, |risen| risen[k].to_f32() - self.values[k].to_f32());
        let area = self.area[k];
        Volumes { pushed: f64::from(self.depth[k].max(0.0) * area), raised: f64::from(up * area) }
    }

    fn moved(&self, risen: Option<&[f16; BLOCK_KNOTS]>) -> Volumes {
        (0..self.count).map(|k| self.moved_at(k, risen)).sum()
    }
}

/// The rim's profile over a piece: the share of its height, and of which patch.
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
        for k in 0..piece.count {
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
        for k in (0..piece.count).filter(|k| piece.free[*k] && nearest[*k] < width * width) {
            let s = nearest[k].sqrt() / width;
            profile.height[k] = (1.0 - s) * (1.0 - s) * (1.0 + 2.0 * s);
        }
        profile
    }

    /// The places that rise, and their share of the height.
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
