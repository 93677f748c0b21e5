//! Binary solid voxelisation of the part of a triangle mesh in a box (Schäfer et al. 2014, Section 5, after Schwarz
//! 2012, Practical Binary Surface and Solid Voxelization, and Nießner et al. 2013 for clipped geometry).
//!
//! A voxel is solid where the winding number of the mesh around its centre is not zero: overlapping closed shells are
//! a union, shells turned inside out are solid as well. Only the triangles in the box's prism, extended along the
//! columns to one side, are needed: forward from −z, backward from +z. What lies before the box counts in the winding
//! number with which its columns are entered.
//!
//! A sheet ([`crate::geometry::closure`]) has no winding number. Columns then count as outside on the front of the first sheet they
//! meet, so that a sheet is solid behind its front and closed shells stay what they are.
//!
//! Nearly all columns are solid in one piece or none. Of those only the ends are kept, four bytes instead of a bit per
//! voxel, which is also what rays ask for; columns of more pieces keep their bits. Beside them every column has the
//! heights of its lowest and its highest crossing, between which rays find the surface that was voxelised.
//!
//! Floor: twelve bytes are written per column (3 MiB for 2²⁴ voxels in columns of 64) and every crossing of a column with
//! the mesh moves 12 bytes in and out of the first-level cache.

use glam::DAffine3;
use relievo_core::simd::Arithmetic;
use relievo_core::{Context, Error, Parts, Result, dispatch_simd};

use crate::geometry::dda::APART;
use crate::geometry::grid::Grid;
use crate::geometry::lattice::Lattice;
use crate::geometry::scanline::{self, FINE, Facet, NO_HEIGHT, PADDING, Shape, Slab, height_stride, snap};

/// A triangle mesh to be voxelised.
#[derive(Clone, Copy, Debug)]
pub struct Solid<'a> {
    /// Positions in object space.
    pub points: &'a [[f32; 3]],
    /// Point indices of the triangles, counter-clockwise seen from outside.
    pub triangles: &'a [[u32; 3]],
    /// From object space to the world.
    pub transform: DAffine3,
    /// Whether every edge is met as often in one direction as in the other; if not, the mesh is solid behind its front.
    pub closed: bool,
    /// The lattice of the grid for it, if its points are to be where graphics devices put them.
    pub lattice: Option<Lattice>,
}

/// The end of the columns that the triangles around are taken from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// Triangles before the box, from z = −∞.
    Forward,
    /// Triangles beyond the box, to z = ∞.
    Backward,
}

/// The voxels of a grid, kept between uses so that memory is allocated once.
#[derive(Clone, Debug)]
pub struct Voxels {
    grid: Grid,
    /// Of column (x, y), at `y · dims[0] + x`: the lowest solid voxel, and the one after the highest in the upper half.
    spans: Vec<u32>,
    /// The bits of columns that are [`PIECES`]: voxel z of column c is bit `z % 64` of word `c · words + z / 64`.
    words: Vec<u64>,
    records: Vec<u32>,
    /// Row by row the heights of columns, see [`Columns::heights`].
    heights: Vec<u32>,
    facets: Vec<Facet>,
    lists: Lists,
    /// Lowest solid voxel and the one after the highest, of every [`CELL`] columns of every slab.
    cells: Vec<[u16; 2]>,
    slab_rows: u32,
}

/// What stands for the ends of a column that is solid in more than one piece.
pub(crate) const PIECES: u32 = 0xffff;

/// How steep a surface may be against the columns, as a tangent, to be followed from one to the next. Steeper ones are walls.
const STEEPEST: f64 = 2.5;

/// Slabs of rows the work is cut into.
const SLABS: u32 = 32;

/// Columns of a coarse cell.
pub(crate) const CELL: u32 = 16;

/// Triangles set up at a time by one thread.
const CHUNK: usize = 256;

/// Coordinates in voxels beyond which a triangle cannot be placed exactly.
const FAR: f64 = (1u64 << 40) as f64;

impl Default for Voxels {
    fn default() -> Self {
        let point = crate::Obb { center: glam::DVec3::ZERO, axes: glam::DMat3::IDENTITY, half: glam::DVec3::ONE };
        Self {
            grid: Grid::new(&point, 1, None),
            spans: vec![0],
            words: vec![0],
            records: Vec::new(),
            heights: vec![NO_HEIGHT; 2 * height_stride(1)],
            facets: Vec::new(),
            lists: Lists::default(),
            cells: vec![[0; 2]],
            slab_rows: 1,
        }
    }
}

impl Voxels {
    /// The grid of the last voxelisation.
    pub fn grid(&self) -> &Grid {
        &self.grid
    }

    /// The columns, as rays see them.
    pub(crate) fn columns(&self) -> Columns<'_> {
        Columns {
            dims: self.grid.dims,
            spans: &self.spans,
            words: &self.words,
            stride: self.grid.words() as usize,
            heights: &self.heights,
            steep: steep(&self.grid),
        }
    }

    /// Whether a voxel is solid; voxels outside the grid are not.
    pub fn get(&self, [x, y, z]: [u32; 3]) -> bool {
        let [nx, ny, nz] = self.grid.dims;
        x < nx && y < ny && z < nz && self.columns().solid(y as usize * nx as usize + x as usize, z)
    }

    /// Whether a box of voxel coordinates may hold a solid voxel, or one next to it along its column; looked up in few coarse
    /// cells.
    pub fn may_meet(&self, low: [f32; 3], high: [f32; 3]) -> bool {
        let [nx, ny, nz] = self.grid.dims;
        let dims = [nx, ny, nz].map(|count| count as f32);
        // What is not a number meets everything.
        if (0..3).any(|axis| high[axis] < 0.0 || low[axis] > dims[axis]) {
            return false;
        }
        let place = |value: f32, count: u32| (value.max(0.0) as u32).min(count - 1);
        let columns = place(low[0], nx) / CELL..=place(high[0], nx) / CELL;
        let mut slabs = place(low[1], ny) / self.slab_rows..=place(high[1], ny) / self.slab_rows;
        let (from, to) = (place(low[2] - 1.0, nz) as u16, place(high[2] + 1.0, nz) as u16);
        let cells = nx.div_ceil(CELL);
        slabs.any(|slab| {
            columns.clone().any(|column| {
                let [least, most] = self.cells[(slab * cells + column) as usize];
                least <= to && most > from
            })
        })
    }

    /// Number of solid voxels.
    pub fn count(&self) -> u64 {
        let columns = self.columns();
        (0..self.spans.len())
            .map(|column| match self.spans[column] {
                PIECES => columns.bits(column).iter().map(|word| u64::from(word.count_ones())).sum(),
                span => u64::from((span >> 16) - (span & 0xffff)),
            })
            .sum()
    }

    /// Voxelises `solid` in `grid`.
    ///
    /// `selection` names the triangles to look at: at least those in the box's prism extended to `side`, or all of them
    /// where it is `None`.
    ///
    /// # Errors
    /// Fails, and leaves the voxels as they are, with `Invalid` if a triangle that `selection` names or one of its
    /// points does not exist, and with `Unsupported` if a corner of one has a coordinate in the grid that is not
    /// finite, or is 2⁴⁰ voxels or more.
    pub fn fill(
        &mut self,
        context: &Context,
        grid: &Grid,
        solid: &Solid<'_>,
        selection: Option<&[u32]>,
        side: Side,
    ) -> Result<()> {
        set_up_all(context, grid, solid, selection, side, &mut self.facets)?;
        let facets = &self.facets;
        self.grid = *grid;
        let [nx, ny, nz] = grid.dims;
        let words = grid.words();
        let shape = Shape { nx, nz, words, backward: side == Side::Backward, open: !solid.closed };
        let rows = ny.div_ceil(SLABS);
        bin(facets, rows, ny, &mut self.lists);
        let lists = &self.lists;
        self.spans.resize(nx as usize * ny as usize, 0);
        self.words.resize(nx as usize * ny as usize * words as usize, 0);
        let columns = nx as usize * rows as usize;
        let cells = nx.div_ceil(CELL) as usize;
        let count = ny.div_ceil(rows) as usize;
        self.records.resize(count * (columns + PADDING), 0);
        self.heights.resize(2 * height_stride(nx as usize) * ny as usize, NO_HEIGHT);
        self.slab_rows = rows;
        self.cells.clear();
        self.cells.resize(cells * count, [u16::MAX, 0]);
        let (spans, words) = (self.spans.as_mut_slice(), self.words.as_mut_slice());
        let all = Slab { spans, words, records: &mut self.records, heights: &mut self.heights, cells: &mut self.cells };
        let heights = 2 * height_stride(nx as usize) * rows as usize;
        let slabs = Slabs { all, count, columns, words: shape.words as usize, heights, cells };
        let level = context.level();
        context.for_each_part(slabs, 1, |index, mut slab| {
            scanline::fill(level, facets, lists.of(index), shape, index as u32 * rows, &mut slab.all);
            Ok(())
        })
    }
}

/// Slabs that follow one another.
struct Slabs<'a> {
    all: Slab<'a>,
    count: usize,
    /// Columns of a slab, words of a column, and heights and coarse cells of a slab. The last slab may have fewer columns.
    columns: usize,
    words: usize,
    heights: usize,
    cells: usize,
}

impl Parts for Slabs<'_> {
    fn len(&self) -> usize {
        self.count
    }

    fn split_at(self, at: usize) -> (Self, Self) {
        let Self { all, count, columns, words, heights, cells } = self;
        let slabs = |all, count| Slabs { all, count, columns, words, heights, cells };
        let (spans, spans_left) = Parts::split_at(all.spans, at * columns);
        let (bits, bits_left) = Parts::split_at(all.words, at * columns * words);
        let (records, records_left) = Parts::split_at(all.records, at * (columns + PADDING));
        let (ends, ends_left) = Parts::split_at(all.heights, at * heights);
        let (coarse, coarse_left) = Parts::split_at(all.cells, at * cells);
        let first = Slab { spans, words: bits, records, heights: ends, cells: coarse };
        let rest =
            Slab { spans: spans_left, words: bits_left, records: records_left, heights: ends_left, cells: coarse_left };
        (slabs(first, at.min(count)), slabs(rest, count.saturating_sub(at)))
    }
}

/// The columns of a grid.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Columns<'a> {
    /// Voxels along x, y and z.
    pub dims: [u32; 3],
    /// The ends of every column, as [`Voxels`] keeps them.
    pub spans: &'a [u32],
    words: &'a [u64],
    stride: usize,
    /// The heights of the columns' lowest ends, and of the highest ones negated, [`NO_HEIGHT`] where they are not known: of
    /// row y those from `2 · y · height_stride`, and one stride further. They count from the centre of the lowest voxel in
    /// units of 1/[`FINE`] voxel.
    pub heights: &'a [u32],
    /// Voxels by which the surface may rise from column to column to be taken for one.
    pub steep: f32,
}

/// Voxels that a surface as steep as [`STEEPEST`] rises from column to column.
pub(crate) fn steep(grid: &Grid) -> f32 {
    let across = grid.size.x.max(grid.size.y);
    (STEEPEST * across / grid.size.z).clamp(1.0, 1000.0) as f32
}

impl Columns<'_> {
    /// The bits of a column that is solid in pieces.
    #[inline(always)]
    pub fn bits(&self, column: usize) -> &[u64] {
        &self.words[column * self.stride..(column + 1) * self.stride]
    }

    /// Whether voxel z of a column is solid.
    #[inline(always)]
    pub fn solid(&self, column: usize, z: u32) -> bool {
        match self.spans[column] {
            PIECES => self.bits(column)[z as usize / 64] >> (z % 64) & 1 != 0,
            span => (span & 0xffff..span >> 16).contains(&z),
        }
    }

    /// The ends of the piece of a column that voxel z, which is solid, belongs to.
    #[inline(always)]
    pub fn piece(&self, column: usize, z: u32) -> [u32; 2] {
        match self.spans[column] {
            PIECES => {
                let bits = self.bits(column);
                [lower_end(bits, z), upper_end(bits, z).min(self.dims[2])]
            }
            span => [span & 0xffff, span >> 16],
        }
    }
}

impl Columns<'_> {
    /// Whether the height of the end of a piece of a column is known: not of ends within the column, nor where the solid goes
    /// on beyond the grid.
    #[inline(always)]
    pub fn knows(&self, column: usize, end: i32, upper: bool) -> bool {
        let nx = self.dims[0] as usize;
        let [x, y] = [column % nx, column / nx];
        let height = self.heights[(2 * y + usize::from(upper)) * height_stride(nx) + x] as i32;
        let rest = FINE * end - if upper { -height } else { height };
        // It is rounded up, and no height is far away.
        (-FINE / 2..=3 * FINE / 2).contains(&rest)
    }

    /// Voxels along the column at `place`, where a ray is in its voxel z, which is clear, to its solid, and whether that is
    /// below; [`APART`] for a column that is not solid in one piece.
    #[inline(always)]
    pub fn side_gap(&self, column: usize, z: i32, place: f32) -> (f32, bool) {
        let span = self.spans[column];
        if span == PIECES || span == 0 {
            return (APART, false);
        }
        let upper = z >= (span >> 16) as i32;
        let end = if upper { span >> 16 } else { span & 0xffff };
        ((end as f32 - place).abs(), upper)
    }
}

/// The lowest voxel from which on all are solid up to the solid voxel z.
fn lower_end(bits: &[u64], z: u32) -> u32 {
    let mut word = z as usize / 64;
    let mut clear = !bits[word] & (u64::MAX >> (63 - z % 64));
    while clear == 0 && word > 0 {
        word -= 1;
        clear = !bits[word];
    }
    if clear == 0 { 0 } else { word as u32 * 64 + 64 - clear.leading_zeros() }
}

/// The first clear voxel above the solid voxel z.
fn upper_end(bits: &[u64], z: u32) -> u32 {
    let mut word = z as usize / 64;
    let mut clear = !bits[word] & (u64::MAX << (z % 64));
    while clear == 0 && word + 1 < bits.len() {
        word += 1;
        clear = !bits[word];
    }
    if clear == 0 { bits.len() as u32 * 64 } else { word as u32 * 64 + clear.trailing_zeros() }
}

/// Makes the selected triangles ready for scan conversion. `facets` are overwritten; those of triangles that do not
/// matter meet no row.
fn set_up_all(
    context: &Context,
    grid: &Grid,
    solid: &Solid<'_>,
    selection: Option<&[u32]>,
    side: Side,
    facets: &mut Vec<Facet>,
) -> Result<()> {
    facets.resize(selection.map_or(solid.triangles.len(), <[u32]>::len), Facet::NONE);
    let level = context.level();
    context.for_each_part(facets.as_mut_slice(), CHUNK, |first, facets| {
        set_up(level, grid, solid, selection, side, first, facets)
    })
}

dispatch_simd! {
    /// Sets up the selected triangles from number `first` on.
    fn set_up = set_up_body(
        grid: &Grid, solid: &Solid<'_>, selection: Option<&[u32]>, side: Side, first: usize, facets: &mut [Facet]
    ) -> Result<()>
}

#[inline(always)]
fn set_up_body<A: Arithmetic>(
    _: A,
    grid: &Grid,
    solid: &Solid<'_>,
    selection: Option<&[u32]>,
    side: Side,
    first: usize,
    facets: &mut [Facet],
) -> Result<()> {
    let map = grid.map * solid.transform;
    let mirrored = map.matrix3.determinant() < 0.0;
    let dims = grid.dims.map(i64::from);
    for (index, facet) in facets.iter_mut().enumerate() {
        let triangle = match selection {
            Some(selection) => selection[first + index] as usize,
            None => first + index,
        };
        let missing =
            || Error::invalid("the triangle or one of its points does not exist").at(format!("triangle {triangle}"));
        let corners = solid.triangles.get(triangle).ok_or_else(missing)?;
        let mut places = [[0; 3]; 3];
        for (place, corner) in places.iter_mut().zip(corners) {
            let point = *solid.points.get(*corner as usize).ok_or_else(missing)?;
            if let Some(near) = solid.lattice.and_then(|lattice| lattice.place(point)) {
                *place = near;
                continue;
            }
            let far = map.transform_point3(glam::DVec3::from(point.map(f64::from)));
            // Not a number fails this as well.
            if !(far.abs().max_element() < FAR) {
                return Err(Error::unsupported("the collider reaches too far beyond the overlap to be voxelised")
                    .at(format!("triangle {triangle}"))
                    .advise("cut the collider down, or make the objects that collide closer in size"));
            }
            *place = far.to_array().map(snap);
        }
        *facet = Facet::new(&places, mirrored, dims, side == Side::Backward).unwrap_or(Facet::NONE);
    }
    Ok(())
}

/// The facets of every slab.
#[derive(Clone, Debug, Default)]
struct Lists {
    starts: Vec<u32>,
    items: Vec<u32>,
    /// Where the next facet of every slab goes.
    next: Vec<u32>,
}

impl Lists {
    fn of(&self, slab: usize) -> &[u32] {
        &self.items[self.starts[slab] as usize..self.starts[slab + 1] as usize]
    }
}

/// Sorts facets by the slabs that they meet, into `lists`.
fn bin(facets: &[Facet], rows: u32, ny: u32, lists: &mut Lists) {
    let Lists { starts, items, next } = lists;
    let count = ny.div_ceil(rows) as usize;
    let range = |facet: &Facet| {
        let [first, end] = facet.row_range(ny);
        (first / rows) as usize..end.div_ceil(rows) as usize
    };
    starts.clear();
    starts.resize(count + 1, 0);
    for facet in facets {
        for slab in range(facet) {
            starts[slab + 1] += 1;
        }
    }
    for slab in 0..count {
        starts[slab + 1] += starts[slab];
    }
    next.clone_from(starts);
    items.clear();
    items.resize(starts[count] as usize, 0);
    for (index, facet) in facets.iter().enumerate() {
        for slab in range(facet) {
            items[next[slab] as usize] = index as u32;
            next[slab] += 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::hierarchy::{Bounds, Hierarchy, Region};
    use crate::geometry::obb::Obb;
    use crate::object::shapes::{self, Soup};
    use glam::{DMat3, DVec3, EulerRot};
    use proptest::prelude::*;
    use relievo_core::ContextOptions;

    /// All bits, column by column.
    fn bits(voxels: &Voxels) -> Vec<bool> {
        let [nx, ny, nz] = voxels.grid().dims;
        (0..ny).flat_map(|y| (0..nx).flat_map(move |x| (0..nz).map(move |z| voxels.get([x, y, z])))).collect()
    }

    fn fill(soup: &Soup, grid: &Grid, selection: Option<&[u32]>, side: Side, closed: bool, threads: usize) -> Voxels {
        let context = Context::new(&ContextOptions { threads, memory_limit: 0 }).unwrap();
        let solid = Solid { points: &soup.0, triangles: &soup.1, transform: DAffine3::IDENTITY, closed, lattice: None };
        let mut voxels = Voxels::default();
        voxels.fill(&context, grid, &solid, selection, side).unwrap();
        voxels
    }

    fn around(center: [f64; 3], half: [f64; 3], angle: f64) -> Obb {
        let axes = DMat3::from_euler(EulerRot::XYZ, angle, 0.6 * angle, -angle);
        Obb { center: DVec3::from(center), axes, half: DVec3::from(half) }
    }

    /// Triangles in the prism of the grid, extended to one side.
    fn select(soup: &Soup, grid: &Grid, side: Side) -> Vec<u32> {
        let context = Context::serial();
        let bounds =
            |index: u32| Bounds::of_points(soup.1[index as usize].iter().map(|point| &soup.0[*point as usize]));
        let hierarchy = Hierarchy::build(&context, soup.1.len(), bounds).unwrap();
        let mut low = DVec3::ZERO;
        let mut high = DVec3::from(grid.dims.map(f64::from));
        match side {
            Side::Forward => low.z = f64::NEG_INFINITY,
            Side::Backward => high.z = f64::INFINITY,
        }
        let mut found = Vec::new();
        hierarchy.query(&context, &Region::new(grid.map, low - 0.01, high + 0.01), &mut found);
        found
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(24))]
        #[test]
        fn clipping_side_and_threads_change_no_bit(
            center in prop::array::uniform3(-1.0f64..1.0), half in prop::array::uniform3(0.05f64..0.8), angle in -3.0f64..3.0, log in 10u32..18
        ) {
            let soup = shapes::joined(shapes::torus(1.0, 0.4, 40, 30), shapes::sphere(0.8, 20, 12, 0.1));
            let grid = Grid::new(&around(center, half, angle), 1 << log, None);
            let whole = bits(&fill(&soup, &grid, None, Side::Forward, true, 1));
            for side in [Side::Forward, Side::Backward] {
                let selection = select(&soup, &grid, side);
                for closed in [true, false] {
                    prop_assert!(bits(&fill(&soup, &grid, Some(&selection), side, closed, 1)) == whole);
                }
                prop_assert!(bits(&fill(&soup, &grid, Some(&selection), side, true, 2)) == whole);
            }
            prop_assert!(bits(&fill(&shapes::inverted(soup), &grid, None, Side::Backward, true, 1)) == whole);
        }

        #[test]
        fn a_turned_cube_is_solid_exactly_where_centres_are_inside(angle in -3.0f64..3.0, shift in prop::array::uniform3(-0.1f64..0.1)) {
            let soup = shapes::cube(0.5);
            let grid = Grid::new(&around(shift, [0.9, 0.8, 1.1], angle), 1 << 15, None);
            let voxels = fill(&soup, &grid, None, Side::Forward, true, 1);
            let [nx, ny, nz] = grid.dims;
            // Columns are moved by at most half a snapped unit to a side.
            let slack = grid.diagonal() / 256.0;
            for x in 0..nx {
                for y in 0..ny {
                    for z in 0..nz {
                        let distance = grid.center([x, y, z]).abs().max_element() - 0.5;
                        prop_assert!(distance.abs() <= slack || (distance < 0.0) == voxels.get([x, y, z]));
                    }
                }
            }
        }
    }

    #[test]
    fn a_window_of_a_lattice_has_the_bits_of_the_whole() {
        let soup = shapes::torus(1.0, 0.35, 61, 37);
        let whole_box = around([0.0; 3], [1.5, 1.5, 0.75], 0.0);
        let grid = Grid { dims: [192, 96, 192], ..Grid::new(&whole_box, 1 << 20, None) };
        let edge = 3.0 / 192.0;
        let grid = lattice(grid, [0.0; 3], edge);
        let whole = fill(&soup, &grid, None, Side::Forward, true, 1);
        let window = lattice(Grid { dims: [50, 31, 64], ..grid }, [20.0, 40.0, 64.0], edge);
        let part = fill(&soup, &window, None, Side::Backward, true, 1);
        assert!(part.count() > 0 && part.count() < 50 * 31 * 64);
        for x in 0..50 {
            for y in 0..31 {
                for z in 0..64 {
                    assert_eq!(part.get([x, y, z]), whole.get([x + 20, y + 40, z + 64]));
                }
            }
        }
    }

    /// The grid with cubic voxels of the given edge whose corner is `shift` voxels into a box around the origin.
    fn lattice(grid: Grid, shift: [f64; 3], edge: f64) -> Grid {
        let matrix3 =
            DMat3::from_cols(DVec3::X, DVec3::Z, DVec3::Y).transpose() * DMat3::from_diagonal(DVec3::splat(1.0 / edge));
        let translation = DVec3::new(96.0, 48.0, 96.0) - DVec3::from(shift);
        Grid { map: DAffine3 { matrix3, translation }, size: DVec3::splat(edge), ..grid }
    }

    #[test]
    fn shells_nested_overlapping_and_apart_are_a_union() {
        let ball = |radius: f32, x: f32| shapes::moved(shapes::sphere(radius, 40, 20, 0.0), [x, 0.0, 0.0]);
        let grid = Grid::new(&around([0.0; 3], [1.4, 0.9, 0.95], 0.2), 1 << 16, None);
        let one = |soup: &Soup| fill(soup, &grid, None, Side::Forward, true, 1);
        let parts = [
            ball(0.8, -0.3),
            ball(0.7, 0.4),
            ball(0.3, -0.3),
            ball(0.2, 1.1),
            ball(0.75, -0.3),
            ball(0.7, -0.25),
            ball(0.6, -0.2),
        ];
        let all = parts.iter().cloned().reduce(shapes::joined).unwrap();
        let union = one(&all);
        let single: Vec<Voxels> = parts.iter().map(one).collect();
        let single: Vec<_> = single.iter().map(bits).collect();
        for (index, bit) in bits(&union).into_iter().enumerate() {
            assert_eq!(bit, single.iter().any(|bits| bits[index]));
        }
        let pieces = |voxels: &Voxels| voxels.spans.iter().filter(|span| **span == PIECES).count();
        assert!(pieces(&union) > 0);
        // A shell turned inside out within another is a hollow: 1 − 1 = 0.
        let hollow = one(&shapes::joined(ball(0.8, 0.0), shapes::inverted(ball(0.5, 0.0))));
        let (outer, inner) = (one(&ball(0.8, 0.0)), one(&ball(0.5, 0.0)));
        for ((hollow, outer), inner) in bits(&hollow).into_iter().zip(bits(&outer)).zip(bits(&inner)) {
            assert_eq!(hollow, outer && !inner);
        }
    }

    #[test]
    fn coarse_cells_miss_no_solid_voxel() {
        let soup =
            shapes::joined(shapes::torus(1.0, 0.2, 40, 20), shapes::moved(shapes::torus(0.7, 0.1, 30, 9), [0.2; 3]));
        let grid = Grid::new(&around([0.1; 3], [1.3, 1.1, 0.9], 0.4), 1 << 16, None);
        let voxels = fill(&soup, &grid, None, Side::Forward, true, 1);
        let mut empty = 0;
        for index in 0..4000u32 {
            let corner = [index * 7 % grid.dims[0], index * 13 % grid.dims[1], index * 29 % grid.dims[2]];
            let low = corner.map(|v| v as f32 - 3.5);
            let high = corner.map(|v| v as f32 + 2.5);
            let range = |axis: usize| corner[axis].saturating_sub(3)..(corner[axis] + 3).min(grid.dims[axis]);
            let solid = range(0).any(|x| range(1).any(|y| range(2).any(|z| voxels.get([x, y, z]))));
            assert!(!solid || voxels.may_meet(low, high), "{corner:?}");
            empty += u32::from(!voxels.may_meet(low, high));
        }
        assert!(empty > 500, "{empty}");
    }

    #[test]
    fn boxes_of_slabs_without_a_solid_voxel_meet_none() {
        let ring = shapes::moved(shapes::torus(0.1, 0.08, 24, 12), [-0.7, -0.6, -0.5]);
        let grid = Grid::new(&around([0.0; 3], [1.0; 3], 0.0), 1 << 18, None);
        let voxels = fill(&ring, &grid, None, Side::Forward, true, 1);
        let [nx, ny, nz] = grid.dims;
        let solid = |y: u32| (0..nx).any(|x| (0..nz).any(|z| voxels.get([x, y, z])));
        let mut met = 0;
        for y in 0..ny {
            let first = y / voxels.slab_rows * voxels.slab_rows;
            let slab = (first..(first + voxels.slab_rows).min(ny)).any(solid);
            let place = y as f32 + 0.5;
            assert_eq!(voxels.may_meet([0.0, place, 0.0], [nx as f32, place, nz as f32]), slab, "{y}");
            met += u32::from(slab);
        }
        assert!(met > 0 && met < ny / 2, "{met} of {ny}");
    }

    #[test]
    fn an_open_sheet_is_solid_behind_its_front() {
        let points = vec![[-9.0, -9.0, 0.1], [9.0, -9.0, 0.1], [9.0, 9.0, 0.1], [-9.0, 9.0, 0.1]];
        let sheet = (points, vec![[0, 1, 2], [0, 2, 3]]);
        let obb = around([0.0; 3], [1.0, 1.0, 1.0], 0.0);
        for (soup, below) in [(sheet.clone(), true), (shapes::inverted(sheet), false)] {
            for side in [Side::Forward, Side::Backward] {
                let grid = Grid::new(&obb, 1 << 15, Some(2));
                let voxels = fill(&soup, &grid, None, side, false, 1);
                for z in 0..grid.dims[2] {
                    let under = grid.center([0, 0, z]).z < 0.1;
                    assert_eq!(voxels.get([3, 3, z]), under == below);
                }
            }
        }
    }

    #[test]
    fn triangles_far_larger_than_the_box_leave_no_leak() {
        let mut soup = shapes::sphere(1.0, 6, 5, 0.0);
        for point in &mut soup.0 {
            *point = point.map(|value| value * 3.0e5);
        }
        let grid = Grid::new(&around([0.1, 0.2, 0.3], [1e-3; 3], 0.5), 1 << 15, None);
        let voxels = fill(&soup, &grid, None, Side::Forward, true, 1);
        assert_eq!(voxels.count(), grid.dims.iter().map(|n| u64::from(*n)).product::<u64>());
        let mut far = soup.clone();
        far.0[0] = [1e30; 3];
        let solid =
            Solid { points: &far.0, triangles: &far.1, transform: DAffine3::IDENTITY, closed: true, lattice: None };
        let error = Voxels::default().fill(&Context::serial(), &grid, &solid, None, Side::Forward).unwrap_err();
        assert!(error.to_string().contains("too far"), "{error}");
        let solid = Solid { points: &soup.0, triangles: &[[0, 1, 99]], ..solid };
        assert!(Voxels::default().fill(&Context::serial(), &grid, &solid, None, Side::Forward).is_err());
        assert!(Voxels::default().fill(&Context::serial(), &grid, &solid, Some(&[7]), Side::Forward).is_err());
    }
}
