//! Filtered look-up of colour: trilinear and anisotropic, across the borders of tiles.
//!
//! Schäfer, Keinert, Nießner and Stamminger 2015, Local Painting and Deformation of Meshes on the GPU, Section 5. A
//! footprint is the parallelogram of two derivatives of the tile's parameters. The ellipse with its axes is covered by
//! up to 16 places along the longer axis, each looked up trilinearly at the width of the shorter one. Places beyond an
//! edge are found by walking on straight through the links of [`relievo_surface::TileTopology`]; at borders of the
//! surface and at non-manifold edges a place stays at the edge.
//!
//! Tiles of equal size agree on their common edge because their levels do, see [`crate::quads::ring`]. Where sizes differ,
//! levels differ too, and texels are rounded: there the finer tile's look-up is shifted, close to the edge, by what the
//! coarser one has on the edge less what it has itself there, and at vertices likewise by the coarsest of all tiles. So
//! colours are continuous to rounding whatever the sizes. Units: parameters of the tile, 0 to 1.

use glam::{Vec2, Vec4};
use relievo_core::simd::prefetch;
use relievo_surface::{Link, Place, TileTopology};

use crate::quads::color::{cell, inner_cell};
use crate::quads::field::Field;
use crate::quads::ring::{View, texel_of_none};
use crate::store::heap::MAX_SIZE;
use crate::texel::ColorTexel;

/// Most places that a look-up visits.
const TAPS: f32 = 16.0;
/// Tiles along the longest footprint.
const LONGEST: f32 = 8.0;
/// Places whose texels are fetched before their colours are made.
const BATCH: usize = 16;
/// Edges that one step of a footprint crosses at most.
const CROSSINGS: usize = 64;

impl<T: ColorTexel> Field<T> {
    /// The mean colour of the `footprint` around `place`: two derivatives of (u, v), say by the columns and the rows of
    /// a picture. A footprint longer than 8 tiles is cut to that, one thinner than a sixteenth of its length is
    /// widened, and none is wider than the coarsest level, two texels a tile. One that is no number is taken for 0.
    ///
    /// # Panics
    /// If there is no such tile. Parameters outside 0 to 1 are clamped.
    pub fn filtered(&self, place: Place, footprint: [[f32; 2]; 2]) -> Vec4 {
        let ellipse = Ellipse::new(footprint.map(Vec2::from));
        let place = Place { u: inside(place.u), v: inside(place.v), ..place };
        let (major, minor) = (ellipse.major, ellipse.minor);
        if ellipse.is_round() {
            return self.sample(place, minor.max(major.min(1.0)));
        }
        let axis = ellipse.direction() * major;
        let count = (major / minor).ceil().clamp(1.0, TAPS);
        let sum: Vec4 = (0..count as u32)
            .map(|tap| {
                let along = (tap as f32 + 0.5) / count - 0.5;
                let (place, scale) = walk(self.topology(), place, axis * along);
                self.sample(place, minor * scale)
            })
            .sum();
        sum / count
    }

    /// [`Self::filtered`] of many places with a footprint each, written to `out`: the same colours to the bit, faster
    /// than one by one because texels of several places are on their way from memory at a time.
    ///
    /// # Panics
    /// If there is no such tile, or if the three slices have not as many items.
    pub fn filtered_many(&self, places: &[Place], footprints: &[[[f32; 2]; 2]], out: &mut [Vec4]) {
        assert!(
            places.len() == footprints.len() && places.len() == out.len(),
            "as many footprints and colours as places"
        );
        let chunks = places.chunks(BATCH).zip(footprints.chunks(BATCH)).zip(out.chunks_mut(BATCH));
        for ((places, footprints), out) in chunks {
            let mut fetched = [const { None }; BATCH];
            for ((fetched, place), footprint) in fetched.iter_mut().zip(places).zip(footprints) {
                *fetched = self.fetch(*place, *footprint);
            }
            for (((out, fetched), place), footprint) in out.iter_mut().zip(&fetched).zip(places).zip(footprints) {
                *out = match fetched {
                    Some(fetched) => fetched.color(),
                    None => self.filtered(*place, *footprint),
                };
            }
        }
    }

    /// A look-up that stays in one tile and needs one place of it, its texels on their way; `None` else.
    #[inline(always)]
    fn fetch(&self, place: Place, footprint: [[f32; 2]; 2]) -> Option<Fetch<'_, T>> {
        let ellipse = Ellipse::new(footprint.map(Vec2::from));
        let (major, minor) = (ellipse.major, ellipse.minor);
        if !ellipse.is_round() || self.uneven(place.tile) != 0 {
            return None;
        }
        let entry = self.entry(place.tile)?;
        let class = entry.id.class;
        let (u, v, width) = (inside(place.u), inside(place.v), minor.max(major.min(1.0)));
        let (level, between) = level_of(width * class.size() as f32, class.mips());
        let size = class.size() >> level;
        let start = class.level_start(level);
        let next = start + class.level_texels(level);
        let (block, next) = if level == 0 { (&*entry.texels, 0) } else { (&entry.mips[start..next], next) };
        let fine = Corners::new(block, u, v, size);
        let coarse = if between == 0.0 {
            fine
        } else {
            Corners::new(&entry.mips[next..next + class.level_texels(level + 1)], u, v, size / 2)
        };
        Some(Fetch { fine, coarse, between })
    }

    /// The colour at `place` of its surroundings of `width`, continuous over the whole surface.
    #[inline(always)]
    pub(crate) fn sample(&self, place: Place, width: f32) -> Vec4 {
        let own = self.trilinear(place, width);
        match self.uneven(place.tile) {
            0 => own,
            uneven => own + self.correction(place, width, uneven),
        }
    }

    /// Between the two levels whose texels are nearest to `width`, from the tile alone.
    #[inline(always)]
    fn trilinear(&self, place: Place, width: f32) -> Vec4 {
        let Some(entry) = self.entry(place.tile) else {
            let class = self.class(place.tile);
            let (level, between) = level_of(width * class.size() as f32, class.mips());
            return self.nothing(place, level, between);
        };
        let class = entry.id.class;
        let (level, between) = level_of(width * class.size() as f32, class.mips());
        let size = class.size() >> level;
        if level == 0 {
            let fine = bilinear(&entry.texels, place, size);
            if between == 0.0 {
                return fine;
            }
            return fine.lerp(bilinear(&entry.mips[..class.level_texels(1)], place, size / 2), between);
        }
        let start = class.level_start(level);
        let next = start + class.level_texels(level);
        let fine = bilinear(&entry.mips[start..next], place, size);
        if between == 0.0 {
            return fine;
        }
        fine.lerp(bilinear(&entry.mips[next..next + class.level_texels(level + 1)], place, size / 2), between)
    }

    /// As [`Self::trilinear`], of a tile without a block: blank, but that mips reach over the edge.
    #[cold]
    fn nothing(&self, place: Place, level: u32, between: f32) -> Vec4 {
        let blank = self.blank().color();
        if (level == 0 && between == 0.0) || !self.is_beside(place.tile) {
            return blank;
        }
        let at = |level: u32| {
            if level == 0 {
                return blank;
            }
            let size = self.size(place.tile) >> level;
            let view = View::at(self, size << u32::from(self.topology().is_sub(place.tile)));
            let ((i, s), (j, t)) = (cell(place.u, size), cell(place.v, size));
            let texel = |i: usize, j: usize| texel_of_none(&view, place.tile, i, j).color();
            let low = texel(i, j).lerp(texel(i + 1, j), s);
            low.lerp(texel(i, j + 1).lerp(texel(i + 1, j + 1), s), t)
        };
        let fine = at(level);
        if between == 0.0 { fine } else { fine.lerp(at(level + 1), between) }
    }

    /// Whether a tile that shares a vertex or a part of an edge with `tile` has a block.
    fn is_beside(&self, tile: u32) -> bool {
        let topology = self.topology();
        let middle = |edge: u8| match topology.link(tile, edge) {
            Link::Halves { middle, .. } => Some(middle),
            _ => None,
        };
        let rings = topology.rings(tile).iter().copied().chain((0..4).filter_map(middle));
        rings.flat_map(|ring| topology.ring(ring)).any(|entry| self.is_allocated(entry.tile))
    }

    /// What is added near edges and corners where a coarser tile rules, `uneven` as [`Field::uneven`] has it.
    #[cold]
    fn correction(&self, place: Place, width: f32, uneven: u8) -> Vec4 {
        let reach = self.reach(place.tile, width);
        let weights = [place.v, 1.0 - place.u, 1.0 - place.v, place.u].map(|distance| weight(distance, reach));
        if weights == [0.0; 4] {
            return Vec4::ZERO;
        }
        let along = [place.u, place.v, 1.0 - place.u, 1.0 - place.v];
        let mut sum = Vec4::ZERO;
        for edge in (0..4).filter(|edge| weights[*edge] > 0.0) {
            sum += self.edge_shift(place.tile, edge as u8, along[edge], width, uneven) * weights[edge];
        }
        for at in 0..4 {
            let both = weights[at] * weights[(at + 3) & 3];
            if both > 0.0 {
                sum -= self.corner_shift(place.tile, at as u8, width, uneven) * both;
            }
        }
        sum
    }

    /// How far from an edge of `tile` what rules there is seen.
    fn reach(&self, tile: u32, width: f32) -> f32 {
        (2.0 * width).clamp(4.0 / self.size(tile) as f32, 0.5)
    }

    /// What is added at the point at `t` of an edge.
    pub(crate) fn edge_shift(&self, tile: u32, edge: u8, t: f32, width: f32, uneven: u8) -> Vec4 {
        if uneven >> edge & 1 != 0 {
            return self.beyond(tile, edge, t, width) - self.trilinear(Place::on_edge(tile, edge, t), width);
        }
        let reach = self.reach(tile, width);
        let (start, end) = (weight(t, reach), weight(1.0 - t, reach));
        let part = |share: f32, corner: u8| {
            if share > 0.0 { self.corner_shift(tile, corner, width, uneven) * share } else { Vec4::ZERO }
        };
        part(start, edge) + part(end, (edge + 1) & 3)
    }

    /// What is added at a corner.
    pub(crate) fn corner_shift(&self, tile: u32, corner: u8, width: f32, uneven: u8) -> Vec4 {
        if uneven >> (4 + corner) & 1 == 0 {
            return Vec4::ZERO;
        }
        self.at_vertex(tile, corner, width) - self.trilinear(Place::corner(tile, corner), width)
    }

    /// What the tile across an edge has at the point at `t` of it.
    fn beyond(&self, tile: u32, edge: u8, t: f32, width: f32) -> Vec4 {
        match cross(self.topology(), tile, edge, t) {
            Some(found) => self.sample(found.place, width * found.scale),
            None => self.trilinear(Place::on_edge(tile, edge, t), width),
        }
    }

    /// What the coarsest tile at a vertex has there.
    fn at_vertex(&self, tile: u32, corner: u8, width: f32) -> Vec4 {
        let topology = self.topology();
        let place = topology.canonical(Place::corner(tile, corner), |tile| self.full_density(tile));
        let scale = match (topology.is_sub(tile), topology.is_sub(place.tile)) {
            (true, false) => 0.5,
            (false, true) => 2.0,
            _ => 1.0,
        };
        self.trilinear(place, width * scale)
    }
}

/// How much of what rules an edge is seen at a distance from it.
fn weight(distance: f32, reach: f32) -> f32 {
    (1.0 - distance / reach).max(0.0)
}

/// A parameter in the tile.
#[inline]
pub(crate) fn inside(parameter: f32) -> f32 {
    if parameter > 0.0 { parameter.min(1.0) } else { 0.0 }
}

/// The colour of a block of `size`² texels at a place of the tile.
#[inline(always)]
pub(crate) fn bilinear<T: ColorTexel>(block: &[T], place: Place, size: u32) -> Vec4 {
    let ((i, s), (j, t)) = (inner_cell(place.u, size), inner_cell(place.v, size));
    Corners { block, at: j * (size as usize + 2) + i, stride: size as usize + 2, s, t }.color()
}

/// The four texels around a place of a level, by the first of them, and how far the place is on the way to the last.
#[derive(Clone, Copy)]
struct Corners<'a, T> {
    block: &'a [T],
    at: usize,
    stride: usize,
    s: f32,
    t: f32,
}

impl<'a, T: ColorTexel> Corners<'a, T> {
    #[inline(always)]
    fn new(block: &'a [T], u: f32, v: f32, size: u32) -> Self {
        let ((i, s), (j, t)) = (inner_cell(u, size), inner_cell(v, size));
        let stride = size as usize + 2;
        let at = j * stride + i;
        prefetch(block, at);
        prefetch(block, at + stride);
        Self { block, at, stride, s, t }
    }

    #[inline(always)]
    fn color(&self) -> Vec4 {
        let Self { block, at, stride, s, t } = *self;
        let (low, high) = (&block[at..at + 2], &block[at + stride..at + stride + 2]);
        let [a, b, c, d] = T::colors([low[0], low[1], high[0], high[1]]);
        let (low, high) = (a + (b - a) * s, c + (d - c) * s);
        low + (high - low) * t
    }
}

/// What a trilinear look-up is made of.
#[derive(Clone, Copy)]
struct Fetch<'a, T> {
    fine: Corners<'a, T>,
    coarse: Corners<'a, T>,
    between: f32,
}

impl<T: ColorTexel> Fetch<'_, T> {
    #[inline(always)]
    fn color(&self) -> Vec4 {
        let fine = self.fine.color();
        if self.between == 0.0 { fine } else { fine.lerp(self.coarse.color(), self.between) }
    }
}

/// The finer level for a footprint of `texels` texels, of `mips` levels beyond the tile itself, and how far it is on
/// the way to the next: linear between powers of two.
#[inline(always)]
fn level_of(texels: f32, mips: u32) -> (u32, f32) {
    if texels.is_nan() || texels <= 1.0 {
        return (0, 0.0);
    }
    let bits = texels.to_bits();
    let level = (bits >> 23) - 127;
    if level >= mips {
        return (mips, 0.0);
    }
    (level, f32::from_bits(bits & 0x007f_ffff | 0x3f80_0000) - 1.0)
}

/// The ellipse of a footprint, within the limits of a look-up.
struct Ellipse {
    /// Lengths of the axes.
    major: f32,
    minor: f32,
    /// Of the footprint's matrix times its transpose: half the difference of the diagonal, what is beside it, and half
    /// the difference of the eigenvalues.
    half: f32,
    beside: f32,
    root: f32,
}

impl Ellipse {
    #[inline(always)]
    fn new([a, b]: [Vec2; 2]) -> Self {
        let (xx, xy, yy) = (a.x * a.x + b.x * b.x, a.x * a.y + b.x * b.y, a.y * a.y + b.y * b.y);
        let (mean, half) = (0.5 * (xx + yy), 0.5 * (xx - yy));
        let root = (half * half + xy * xy).sqrt();
        let major = (mean + root).sqrt();
        if !major.is_finite() || major <= 0.0 {
            return Self { major: 0.0, minor: 0.0, half: 0.0, beside: 0.0, root: 0.0 };
        }
        let minor = a.perp_dot(b).abs() / major;
        let length = major.min(LONGEST);
        Self { major: length, minor: minor.clamp(length / TAPS, length), half, beside: xy, root }
    }

    /// Whether one place is enough: it is shorter than any texel, or round.
    #[inline(always)]
    fn is_round(&self) -> bool {
        self.major * (MAX_SIZE as f32) <= 1.0 || self.major <= self.minor
    }

    /// Where the longer axis points.
    fn direction(&self) -> Vec2 {
        let Self { half, beside, root, .. } = *self;
        // Both directions are those of the matrix; the longer one is the more exact.
        let direction = if half >= 0.0 { Vec2::new(half + root, beside) } else { Vec2::new(beside, root - half) };
        direction.normalize_or(Vec2::X)
    }
}

/// Directions along each edge and into the tile.
const ALONG: [Vec2; 4] = [Vec2::X, Vec2::Y, Vec2::NEG_X, Vec2::NEG_Y];
const INWARD: [Vec2; 4] = [Vec2::Y, Vec2::NEG_X, Vec2::NEG_Y, Vec2::X];

/// A point of an edge as the tile across has it.
struct Crossing {
    place: Place,
    /// The edge of that tile.
    edge: usize,
    /// Whether it runs the same way.
    reversed: bool,
    /// How much longer the parameters are there.
    scale: f32,
}

/// The point at `t` of an edge in the tile across, if there is one.
fn cross(topology: &TileTopology, tile: u32, edge: u8, t: f32) -> Option<Crossing> {
    let turn = |t: f32, reversed: bool| if reversed { t } else { 1.0 - t };
    let (side, t, reversed, scale) = match topology.link(tile, edge) {
        Link::Boundary | Link::Pinned { .. } => return None,
        Link::Whole { side, reversed } => (side, turn(t, reversed), reversed, 1.0),
        Link::Half { side, second, reversed } => {
            (side, 0.5 * (turn(t, reversed) + if second { 1.0 } else { 0.0 }), reversed, 0.5)
        }
        Link::Halves { first, second, reversed, .. } => {
            let (side, t) = if t < 0.5 { (first, 2.0 * t) } else { (second, 2.0 * t - 1.0) };
            (side, turn(t, reversed), reversed, 2.0)
        }
    };
    Some(Crossing { place: Place::on_edge(side.tile, side.edge, t), edge: usize::from(side.edge), reversed, scale })
}

/// Where a straight step from `place` ends, through as many tiles as it crosses, and how much longer than at its start
/// the parameters are there.
fn walk(topology: &TileTopology, place: Place, step: Vec2) -> (Place, f32) {
    let (mut tile, mut at, mut step, mut total) = (place.tile, Vec2::new(place.u, place.v), step, 1.0);
    for _ in 0..CROSSINGS {
        let end = at + step;
        if end.cmpge(Vec2::ZERO).all() && end.cmple(Vec2::ONE).all() {
            return (Place::new(tile, end.x, end.y), total);
        }
        // The edge that is met first.
        let mut first = (f32::INFINITY, 0);
        for (edge, inward) in INWARD.iter().enumerate() {
            let speed = -step.dot(*inward);
            let distance = if edge == 0 || edge == 3 { at.dot(*inward) } else { 1.0 + at.dot(*inward) };
            if speed > 0.0 && distance / speed < first.0 {
                first = (distance / speed, edge);
            }
        }
        let (share, edge) = (first.0.clamp(0.0, 1.0), first.1);
        let point = (at + step * share).clamp(Vec2::ZERO, Vec2::ONE);
        let rest = step * (1.0 - share);
        let along = ALONG[edge];
        let t = if edge < 2 { point.dot(along) } else { 1.0 + point.dot(along) };
        match cross(topology, tile, edge as u8, t.clamp(0.0, 1.0)) {
            Some(Crossing { place, edge: other, reversed, scale }) => {
                let forward = if reversed { rest.dot(along) } else { -rest.dot(along) };
                let onward = -rest.dot(INWARD[edge]);
                step = (ALONG[other] * forward + INWARD[other] * onward) * scale;
                (tile, at, total) = (place.tile, Vec2::new(place.u, place.v), total * scale);
            }
            None => {
                at = point;
                step = along * rest.dot(along);
            }
        }
    }
    (Place::new(tile, inside(at.x), inside(at.y)), total)
}

#[cfg(test)]
mod tests {
    use relievo_testing::grid;

    use super::*;

    #[test]
    fn levels_follow_the_width_without_a_step() {
        assert_eq!([0.0, 1.0, f32::NAN, -3.0].map(|texels| level_of(texels, 6)), [(0, 0.0); 4]);
        assert_eq!((level_of(1.5, 6), level_of(2.0, 6), level_of(48.0, 6)), ((0, 0.5), (1, 0.0), (5, 0.5)));
        assert_eq!((level_of(64.0, 6), level_of(f32::INFINITY, 6)), ((6, 0.0), (6, 0.0)));
    }

    #[test]
    fn the_ellipse_of_a_footprint_has_its_axes() {
        let ellipse = |a: Vec2, b: Vec2| {
            let ellipse = Ellipse::new([a, b]);
            (ellipse.direction() * ellipse.major, ellipse.minor)
        };
        let (axis, minor) = ellipse(Vec2::new(0.3, 0.0), Vec2::new(0.0, 0.1));
        assert!((axis.abs() - Vec2::new(0.3, 0.0)).length() < 1e-6 && (minor - 0.1).abs() < 1e-6);
        let turn = Vec2::from_angle(1.1);
        let (axis, minor) = ellipse(turn * 0.05, turn.perp() * 0.4);
        assert!((axis.length() - 0.4).abs() < 1e-5 && axis.dot(turn).abs() < 1e-5 && (minor - 0.05).abs() < 1e-5);
        for odd in [f32::NAN, f32::INFINITY, 0.0, 1e-30] {
            let (axis, minor) = ellipse(Vec2::new(odd, 0.0), Vec2::ZERO);
            assert!(axis.length() < 1e-6 && minor < 1e-6);
        }
        assert_eq!(ellipse(Vec2::new(1e6, 0.0), Vec2::ZERO), (Vec2::new(8.0, 0.0), 0.5));
    }

    #[test]
    fn steps_go_on_straight_through_tiles_however_they_are_turned() {
        let size = 5;
        let mesh = grid(size, true, &[2, 6, 10, 14, 2, 10], false);
        let topology = TileTopology::new(&mesh).unwrap();
        // Where a place is on the grid, in tiles.
        let position = |place: Place| {
            let corner = |k: usize| {
                let point = mesh.corners[4 * place.tile as usize + k];
                Vec2::new((point % size) as f32, (point / size) as f32)
            };
            let near = |a: Vec2, b: Vec2| {
                let wrap = |x: f32| {
                    if x > 1.5 {
                        x - size as f32
                    } else if x < -1.5 {
                        x + size as f32
                    } else {
                        x
                    }
                };
                Vec2::new(wrap(b.x - a.x), wrap(b.y - a.y))
            };
            let origin = corner(0);
            origin + near(origin, corner(1)) * place.u + near(origin, corner(3)) * place.v
        };
        for (tile, x, y) in [(0, 0.3, 0.1), (7, 2.3, -1.7), (12, -0.9, 3.4), (24, 0.5, 0.25), (18, -4.2, -0.1)] {
            let start = Place::new(tile, 0.4, 0.7);
            let (end, scale) = walk(&topology, start, Vec2::new(x, y));
            // The step in the directions of the grid.
            let small = |u: f32, v: f32| position(Place::new(tile, 0.4 + u, 0.7 + v)) - position(start);
            let moved = (small(0.1, 0.0) * x + small(0.0, 0.1) * y) * 10.0;
            let found = position(end) - position(start) - moved;
            let wrapped = found - (found / size as f32).round() * size as f32;
            assert!(wrapped.length() < 1e-4 && scale == 1.0, "{start:?} {end:?} {wrapped}");
        }
        let open = TileTopology::new(&grid(2, false, &[2], false)).unwrap();
        let (end, _) = walk(&open, Place::new(0, 0.5, 0.5), Vec2::new(-0.75, 1.0));
        assert_eq!((end.tile, end.u), (2, 0.0), "stays at the border and goes on along it");
    }
}
