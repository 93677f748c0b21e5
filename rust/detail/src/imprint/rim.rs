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

use glam::DAffine3;
use half::f16;
use relievo_core::simd::{Arithmetic, Level};
use relievo_core::{Context, Error, Result, dispatch_simd};

use crate::channels::knots::BLOCK_KNOTS;
use crate::geometry::grid::Grid;
use crate::geometry::obb::Obb;
use crate::imprint::settings::ImprintSettings;

mod tiles;

pub use tiles::raise;

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

/// The grid of nothing but the box in which something rises, `width` object units around that of an imprint.
pub(crate) fn surroundings(obb: &Obb, transform: &DAffine3, width: f32) -> Grid {
    let scale = transform.matrix3;
    let stretch = scale.x_axis.length().max(scale.y_axis.length()).max(scale.z_axis.length());
    Grid::new(&obb.enlarged(f64::from(width) * stretch), 4096, None)
}

/// Bytes that the pieces around a contact may take.
const MAX_BYTES: u64 = 1 << 31;

/// Fails if `count` pieces exceed the context's memory limit, or 2 GiB.
pub(crate) fn check_bytes(context: &Context, count: usize) -> Result<()> {
    let bytes = (count * size_of::<Piece>()) as u64;
    if bytes <= context.memory_limit().min(MAX_BYTES) {
        return Ok(());
    }
    Err(Error::memory(format!("the surface within the width of the rim takes {bytes} bytes"))
        .at("rim_width")
        .advise("make the rim narrower or the surface's values coarser"))
}

/// How far boxes of imprints reach outwards on a surface that is displaced to `most`: where rims rise, in steps of up to
/// a quarter, so that imprints find the same voxels whether or not others before them raised a little more.
pub(crate) fn outwards(most: f32, settings: &ImprintSettings) -> f32 {
    if settings.rim <= 0.0 {
        return most;
    }
    const STEP: u32 = 1 << (f32::MANTISSA_DIGITS - 3);
    most.max(f32::from_bits((most.max(0.0).to_bits() + STEP - 1) & !(STEP - 1)))
}

/// Where the slope would be steeper than that of repose. The profile is steepest half-way out, where it falls by 3/2 of
/// its height per width.
pub(crate) fn highest(settings: &ImprintSettings) -> f32 {
    (f64::from(settings.rim_width) * f64::from(settings.repose).tan() / 1.5) as f32
}

/// What the values of every piece are to be when a share of what is pushed away has risen; `None` where nothing rises.
/// Values that do not rise stay as they are in the piece.
///
/// No number depends on an order: cells are as large as a power of two, so that places are exactly in one of them, and
/// volumes are sums of whole numbers. A graphics device so does the same.
pub(crate) fn rise(context: &Context, pieces: &[Piece], settings: &ImprintSettings) -> Vec<Option<[f16; BLOCK_KNOTS]>> {
    let width = settings.rim_width;
    let spacing = pieces.iter().filter(|piece| piece.pushed().next().is_some()).map(|piece| piece.spacing);
    let cells = Cells::new(spacing.fold(width, f32::max));
    let mut pushed: BTreeMap<Cell, u64> = BTreeMap::new();
    for (cell, volume) in context.map(pieces.len(), |index| pieces[index].volumes(&cells)).into_iter().flatten() {
        let sum = pushed.entry(cell).or_default();
        *sum = sum.saturating_add(volume);
    }
    let patches = patches(&pushed);
    let mut volumes = vec![0u64; patches.values().max().map_or(0, |last| *last as usize + 1)];
    for (cell, volume) in &pushed {
        let sum = &mut volumes[patches[cell] as usize];
        *sum = sum.saturating_add(*volume);
    }
    let mut border: BTreeMap<Cell, Vec<Border>> = BTreeMap::new();
    for piece in pieces {
        for k in (0..piece.count).filter(|k| piece.border[*k]) {
            let cell = cells.of(piece.point(k));
            border.entry(cell).or_default().push(Border { point: piece.point(k), patch: patches[&cell] });
        }
    }
    let level = context.level();
    let profiles = context.map(pieces.len(), |index| Profile::new(level, &pieces[index], &border, &cells, width));
    let mut room = vec![0u64; volumes.len()];
    for (piece, profile) in pieces.iter().zip(&profiles) {
        for (k, height) in profile.rising() {
            let sum = &mut room[profile.patch[k] as usize];
            *sum = sum.saturating_add(cells.area(height * piece.area[k]));
        }
    }
    let highest = highest(settings);
    let sums = volumes.into_iter().zip(room);
    let heights: Vec<f32> = sums.map(|(volume, room)| cells.height(volume, room) * settings.rim).collect();
    context.map(pieces.len(), |index| {
        let (piece, profile) = (&pieces[index], &profiles[index]);
        let mut values = piece.values;
        let mut any = false;
        for (k, height) in profile.rising() {
            let old = piece.values[k].to_f32();
            let new = (old + heights[profile.patch[k] as usize] * height).min(highest * height);
            let new = f16::from_f32(new);
            if new.to_f32() > old {
                values[k] = new;
                any = true;
            }
        }
        any.then_some(values)
    })
}

/// A cell of space.
type Cell = [i32; 3];

/// Cells of space as large as a power of two.
struct Cells {
    edge: f32,
}

impl Cells {
    /// Cells that are at least as large as `size`.
    fn new(size: f32) -> Self {
        const MANTISSA: u32 = (1 << (f32::MANTISSA_DIGITS - 1)) - 1;
        // Powers of their edge have to be normal numbers.
        let size = size.clamp(2.0f32.powi(-40), 2.0f32.powi(40));
        Self { edge: f32::from_bits((size.to_bits() + MANTISSA) & !MANTISSA) }
    }

    /// The cell of a point.
    fn of(&self, point: [f32; 3]) -> Cell {
        point.map(|value| (value / self.edge).floor() as i32)
    }

    /// A volume in units of 2⁻³² cells, downwards.
    fn volume(&self, volume: f32) -> u64 {
        whole(volume / (self.edge * self.edge * self.edge))
    }

    /// An area in units of 2⁻³² of a cell's side.
    fn area(&self, area: f32) -> u64 {
        whole(area / (self.edge * self.edge))
    }

    /// How high a volume is over an area, in units of these.
    fn height(&self, volume: u64, area: u64) -> f32 {
        leading(volume) / leading(area.max(1)) * self.edge
    }
}

/// A number in units of 2⁻³², downwards; 2¹² at most, so that so many can be summed up that they fill no memory.
fn whole(number: f32) -> u64 {
    (number.min(4096.0) * 2.0f32.powi(32)) as u64
}

/// A sum's leading 24 bits.
fn leading(sum: u64) -> f32 {
    let shift = 40u32.saturating_sub(sum.leading_zeros());
    (sum >> shift) as f32 * 2.0f32.powi(shift as i32)
}

fn around([x, y, z]: Cell) -> impl Iterator<Item = Cell> {
    let near = |value: i32| value.saturating_sub(1)..=value.saturating_add(1);
    near(x).flat_map(move |x| near(y).flat_map(move |y| near(z).map(move |z| [x, y, z])))
}

/// The patches of contact: connected cells, numbered in their order.
fn patches(cells: &BTreeMap<Cell, u64>) -> BTreeMap<Cell, u32> {
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

    fn point(&self, k: usize) -> [f32; 3] {
        [self.p[0][k], self.p[1][k], self.p[2][k]]
    }

    /// The places that are pushed.
    fn pushed(&self) -> impl Iterator<Item = usize> {
        (0..self.count).filter(|k| self.depth[*k] > 0.0)
    }

    /// The volumes that are pushed away, by cell.
    fn volumes(&self, cells: &Cells) -> Vec<(Cell, u64)> {
        let mut volumes: Vec<(Cell, u64)> = Vec::new();
        for k in self.pushed() {
            let (cell, volume) = (cells.of(self.point(k)), cells.volume(self.depth[k] * self.area[k]));
            match volumes.iter_mut().find(|(other, _)| *other == cell) {
                Some((_, sum)) => *sum = sum.saturating_add(volume),
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
    fn new(level: Level, piece: &Piece, border: &BTreeMap<Cell, Vec<Border>>, cells: &Cells, width: f32) -> Self {
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
        let (first, last) = (cells.of(low), cells.of(high));
        let (first, last) = (first.map(|place| place.saturating_sub(1)), last.map(|place| place.saturating_add(1)));
        let near = |cell: &Cell| (0..3).all(|axis| cell[axis] >= first[axis] && cell[axis] <= last[axis]);
        let beside = |at: &Border| {
            (0..3).all(|axis| at.point[axis] >= low[axis] - width && at.point[axis] <= high[axis] + width)
        };
        let cells = border.range([first[0], i32::MIN, i32::MIN]..=[last[0], i32::MAX, i32::MAX]);
        let border = cells.filter(|(cell, _)| near(cell)).flat_map(|(_, border)| border).copied();
        let mut border: Vec<Border> = border.filter(beside).collect();
        // Of borders that are equally near the one of the first patch counts.
        border.sort_unstable_by_key(|border| border.patch);
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
    _: A,
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
        let patches = patches(&cells.map(|cell| (cell, 1)).into());
        assert_eq!(cells.map(|cell| patches[&cell]), [0, 0, 0, 1, 1, 1]);
    }

    #[test]
    fn boxes_reach_outwards_in_steps_where_rims_rise() {
        let rimmed = ImprintSettings { rim: 0.5, ..ImprintSettings::default() };
        for (most, reach) in [(0.0, 0.0), (-0.0, 0.0), (0.25, 0.25), (0.26, 0.3125), (0.43, 0.4375), (0.9, 1.0)] {
            assert_eq!(outwards(most, &rimmed), reach);
            assert_eq!(outwards(most, &ImprintSettings::default()), most);
        }
    }

    #[test]
    fn cells_are_as_large_as_the_next_power_of_two() {
        for (size, edge) in [(1.0, 1.0), (1.1, 2.0), (0.13, 0.25), (0.25, 0.25), (3000.0, 4096.0)] {
            assert_eq!(Cells::new(size).edge, edge);
        }
        let cells = Cells::new(0.2);
        assert_eq!(cells.of([0.25, -0.1, 0.249]), [1, -1, 0]);
        assert_eq!((cells.volume(cells.edge.powi(3)), cells.area(2.0 * cells.edge.powi(2))), (1 << 32, 1 << 33));
        assert_eq!(cells.height(3 << 40, 1 << 41), 1.5 * cells.edge);
        assert_eq!((leading(u64::MAX), leading(5)), (((1u64 << 24) - 1) as f32 * 2.0f32.powi(40), 5.0));
    }

    /// Places around two holes of different depth on a plane, in pieces of a row each.
    fn plane() -> Vec<Piece> {
        let distance = |p: [f32; 2], hole: f32| ((p[0] - hole).powi(2) + p[1].powi(2)).sqrt();
        let row = |j: usize| {
            let mut piece = Piece { count: 128, spacing: 0.1, ..Piece::EMPTY };
            for k in 0..piece.count {
                let p = [0.05 * k as f32 - 3.2, 0.05 * j as f32 - 1.6];
                (piece.p[0][k], piece.p[1][k]) = (p[0], p[1]);
                let near = distance(p, -1.5).min(distance(p, 1.5));
                piece.depth[k] = if near < 0.5 { (0.5 - near) * (2.0 + p[0]) } else { 0.0 };
                piece.values[k] = f16::from_f32(-piece.depth[k]);
                (piece.free[k], piece.border[k]) = (near >= 0.5, near < 0.5 && near > 0.45);
                piece.area[k] = 0.0025;
            }
            piece
        };
        (0..64).map(row).collect()
    }

    #[test]
    fn what_rises_does_not_depend_on_the_order_of_the_places() {
        let settings = ImprintSettings { rim: 0.6, rim_width: 0.4, repose: 1.3, ..ImprintSettings::default() };
        let context = Context::serial();
        let mut pieces = plane();
        let risen = rise(&context, &pieces, &settings);
        let sum = |pieces: &[Piece], risen: &[Option<[f16; BLOCK_KNOTS]>]| {
            pieces.iter().zip(risen).map(|(piece, risen)| piece.moved(risen.as_ref())).sum::<Volumes>()
        };
        let volumes = sum(&pieces, &risen);
        assert!((volumes.raised / volumes.pushed - 0.6).abs() < 0.002, "{volumes:?}");
        pieces.reverse();
        let mut others = rise(&context, &pieces, &settings);
        others.reverse();
        assert!(others == risen);
    }
}
