//! The ring update: what tiles know of their neighbours, brought up to date after an edit.
//!
//! Schäfer, Keinert, Nießner, Buchenau, Guthe and Stamminger 2014, Real-Time Deformation of Subdivision Surfaces from
//! Object Collisions, Section 6 and Figure 4, for any topology and for neighbours of other sizes:
//!
//! - Across an edge, the ring is the neighbour's border row. That makes the displacement C¹.
//! - At a regular vertex the ring's corner is the border corner of the tile opposite. In the middle of a quad's edge,
//!   where two sub-tiles meet it, the texels are as regular as anywhere.
//! - At any other vertex, and at a regular one whose tiles differ in density, the border corners of all tiles are
//!   averaged, and all four texels around the vertex get the average in every tile: displacement is then continuous
//!   and its derivatives vanish there. The average is made in f64 and rounded once, so that it does not drift.
//! - At a border of the surface the ring repeats the border row.
//! - Between tiles of different density the coarser one's edge curve rules: its ring is the mean of the finer border
//!   texels, and the finer ring is twice the subdivided edge curve less the finer border. That makes the displacement
//!   continuous.
//! - Beside a tile that is not allocated, and at non-manifold edges, the border row and the ring are blank: what tiles
//!   without a block read as, which for displacement is zero.
//! - Across a reversed link displacements change sign, because the normals do; colours stay. Vectors are re-expressed
//!   in the frame of the tile that receives them, at the point of the edge that the texel is beside, see
//!   [`crate::quads::frame`].
//!
//! Colours are looked up bilinearly, and the same rules make that continuous across edges of equal density.
//!
//! The first pass equalises border corners and clears borders, from border corners alone; the second derives rings
//! from borders alone. So nothing depends on the order of tiles, and a second update changes nothing.

use std::ops::Range;

use relievo_core::{Context, List};
use relievo_surface::{Incidence, Link, RingClass, Side, TileTopology};

use crate::quads::field::{Field, Line};
use crate::quads::frame::{Turn, entry_of, opposite};
use crate::quads::mip;
use crate::quads::spline::{restrict_curve, subdivide_curve};
use crate::store::heap::MAX_SIZE;
use crate::texel::Texel;

/// What an edit changed of a tile.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Change {
    /// The tile.
    pub tile: u32,
    /// Bit `e` is set if a coefficient of the border row along edge `e` changed, its corners included.
    pub borders: u8,
}

impl Change {
    /// Everything about `tile` may have changed: it was written, allocated or deallocated.
    pub fn all(tile: u32) -> Self {
        Self { tile, borders: 0xf }
    }
}

/// Coefficients to write to one tile: index in the block and value.
#[derive(Debug)]
pub(crate) struct Writes<T>(Vec<Piece<T>>);

/// What one item of parallel work writes.
#[derive(Debug)]
struct Piece<T> {
    /// Tiles, and theirs among the texels.
    tiles: Vec<(u32, Range<usize>)>,
    texels: Vec<(u32, T)>,
}

/// Where the list of a tile is: its piece, and its number there.
pub(crate) type WritesAt = (usize, usize);

impl<T> Default for Writes<T> {
    fn default() -> Self {
        Self(Vec::new())
    }
}

impl<T> Writes<T> {
    /// Where the list of every tile is, the tile, and the list.
    pub fn iter(&self) -> impl Iterator<Item = (WritesAt, u32, &[(u32, T)])> {
        self.0.iter().enumerate().flat_map(|(index, piece)| {
            let tiles = piece.tiles.iter().enumerate();
            tiles.map(move |(at, (tile, range))| ((index, at), *tile, &piece.texels[range.clone()]))
        })
    }

    /// The list that is there.
    pub fn list(&self, (piece, at): WritesAt) -> &[(u32, T)] {
        let Piece { tiles, texels } = &self.0[piece];
        &texels[tiles[at].1.clone()]
    }
}

/// A part of a tile's edge and what lies across it.
#[derive(Clone, Copy, Debug)]
struct Span {
    /// First texel and number of texels of this tile.
    own: (usize, usize),
    /// The neighbour's side, and first texel and number of texels on it.
    side: Side,
    other: (usize, usize),
    reversed: bool,
    /// The rings at both ends of the span.
    ends: [u32; 2],
}

/// What is known of a vertex: every tile gets this value at all four texels, or each copies its neighbours' texels.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Vertex<T> {
    Set(T),
    Copy,
}

/// The sides and vertices to bring up to date, by tile.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Work {
    tile: u32,
    edges: u8,
    corners: u8,
}

/// From the frame of entry `from` of `ring` to that of entry `to`.
fn around<T: Texel>(field: &View<'_, T>, ring: u32, from: usize, to: usize) -> Turn {
    match &field.field.frames {
        Some(frames) if T::FRAMED => frames.around(ring, from, to),
        _ => {
            let entries = field.topology().ring(ring);
            Turn::plain(entries[from].flipped != entries[to].flipped)
        }
    }
}

/// The tiles that are not allocated but that `changes` reach: across a border that is not blank, or at a vertex whose
/// corner texel is not blank. Ascending, in place of what `tiles` holds.
#[inline(never)]
pub fn reached<T: Texel>(field: &Field<T>, changes: &[Change], tiles: &mut Vec<u32>) {
    let field = &View::whole(field);
    tiles.clear();
    for change in changes {
        let tile = change.tile;
        let Some(block) = field.block(tile) else { continue };
        let size = field.size(tile);
        let topology = field.topology();
        for edge in (0..4u8).filter(|edge| change.borders >> edge & 1 != 0) {
            let line = Line::new(size, edge, 0);
            let set = |k: usize| !block[line.at(k as isize)].is_blank(field.blank());
            for span in spans(field, Side { tile, edge }).into_iter().flatten() {
                if !field.is_allocated(span.side.tile) && (span.own.0..span.own.0 + span.own.1).any(set) {
                    tiles.push(span.side.tile);
                }
            }
            let ends = [
                (topology.rings(tile)[usize::from(edge)], set(0)),
                (topology.rings(tile)[usize::from((edge + 1) & 3)], set(size as usize - 1)),
            ];
            let half = size as usize / 2;
            let middle = match topology.link(tile, edge) {
                Link::Halves { middle, .. } => Some((middle, set(half - 1) || set(half))),
                _ => None,
            };
            for (ring, _) in ends.into_iter().chain(middle).filter(|(_, set)| *set) {
                if topology.ring_class(ring) != RingClass::Pinned {
                    let others = topology.ring(ring).iter().map(|entry| entry.tile);
                    tiles.extend(others.filter(|other| !field.is_allocated(*other)));
                }
            }
        }
    }
    tiles.sort_unstable();
    tiles.dedup();
}

/// The sides and vertices that an update concerns.
#[derive(Default)]
pub(crate) struct Plan {
    /// By ascending tile.
    work: Vec<Work>,
    /// Rings of so many tiles that their value is made once for all.
    poles: Vec<u32>,
}

/// The number of tiles above which a ring is a pole.
const POLE: usize = 16;

/// The tiles as one pass sees them: as they are, or each at the mip that is nearest to a density.
pub(crate) struct View<'a, T: Texel> {
    field: &'a Field<T>,
    /// Texels along an edge of the cage, at most; `u32::MAX` for the tiles themselves.
    density: u32,
    /// The values of poles, ascending, if they are known.
    poles: Option<List<'a, (u32, Vertex<T>)>>,
}

impl<'a, T: Texel> View<'a, T> {
    /// The tiles as they are.
    pub fn whole(field: &'a Field<T>) -> Self {
        Self::at(field, u32::MAX)
    }

    /// Tiles of at most `density` texels along an edge of the cage, where they have such a mip.
    pub fn at(field: &'a Field<T>, density: u32) -> Self {
        Self { field, density, poles: None }
    }

    /// Knows the values at the poles of `plan`.
    pub fn with_poles(mut self, context: &'a Context, plan: &Plan) -> Self {
        let mut poles = context.scratch().list();
        context.map_into(plan.poles.len(), &mut poles, |index| (plan.poles[index], vertex(&self, plan.poles[index])));
        self.poles = Some(poles);
        self
    }

    fn topology(&self) -> &'a TileTopology {
        self.field.topology()
    }

    fn blank(&self) -> T {
        self.field.blank()
    }

    /// Whether these are mips. Tiles without a block then count as blank ones.
    fn is_mip(&self) -> bool {
        self.density != u32::MAX
    }

    /// The level of `tile`.
    pub fn level(&self, tile: u32) -> u32 {
        if !self.is_mip() {
            return 0;
        }
        let class = self.field.class(tile);
        let own = class.size() << u32::from(self.topology().is_sub(tile));
        (own / self.density).max(1).ilog2().min(class.mips())
    }

    fn size(&self, tile: u32) -> u32 {
        self.field.size(tile) >> self.level(tile)
    }

    fn is_allocated(&self, tile: u32) -> bool {
        self.is_mip() || self.field.is_allocated(tile)
    }

    fn block(&self, tile: u32) -> Option<&'a [T]> {
        self.field.level(tile, self.level(tile))
    }

    /// Texels along an edge of the cage, 0 for a tile that is not there.
    fn density(&self, tile: u32) -> u32 {
        if self.is_allocated(tile) { self.size(tile) << u32::from(self.topology().is_sub(tile)) } else { 0 }
    }
}

/// The first pass: border corners and cleared border rows. Only coefficients that differ are listed.
#[inline(never)]
pub(crate) fn borders<T: Texel>(context: &Context, field: &Field<T>, plan: &Plan, writes: &mut Writes<T>) {
    let field = &View::whole(field).with_poles(context, plan);
    collect(context, &plan.work, writes, |work, out| {
        let Some(block) = field.block(work.tile) else { return };
        let size = field.size(work.tile);
        let mut write = |line: &Line, k: usize, value: T| {
            let index = line.at(k as isize);
            if block[index] != value {
                out.push((index as u32, value));
            }
        };
        for edge in (0..4).filter(|edge| work.edges >> edge & 1 != 0) {
            let line = Line::new(size, edge, 0);
            let link = field.topology().link(work.tile, edge);
            if let Link::Pinned { .. } = link {
                (0..size as usize).for_each(|k| write(&line, k, field.blank()));
            }
            for span in spans(field, Side { tile: work.tile, edge }).into_iter().flatten() {
                if !field.is_allocated(span.side.tile) {
                    (span.own.0..span.own.0 + span.own.1).for_each(|k| write(&line, k, field.blank()));
                }
            }
            if let Link::Halves { middle, .. } = link
                && vertex(field, middle) != Vertex::Copy
            {
                let half = size as usize / 2;
                write(&line, half - 1, field.blank());
                write(&line, half, field.blank());
            }
        }
        for corner in (0..4).filter(|corner| work.corners >> corner & 1 != 0) {
            if let Some(value) = corner_value(field, work.tile, corner) {
                write(&Line::new(size, corner, 0), 0, value);
            }
        }
    })
}

/// The second pass: ring coefficients, from borders that the first pass has made consistent.
#[inline(never)]
pub(crate) fn rings<T: Texel>(context: &Context, field: &Field<T>, plan: &Plan, writes: &mut Writes<T>) {
    let field = &View::whole(field).with_poles(context, plan);
    collect(context, &plan.work, writes, |work, out| {
        ring_of(field, *work, |at, value| out.push((at as u32, value)));
    })
}

/// The ring of a tile, where `work` says: index in the block and value of what differs.
fn ring_of<T: Texel>(field: &View<'_, T>, work: Work, mut write_at: impl FnMut(usize, T)) {
    let Some(block) = field.block(work.tile) else { return };
    let size = field.size(work.tile);
    let last = size as usize - 1;
    let mut write = |line: &Line, k: isize, value: T| {
        let index = line.at(k);
        if !block[index].same(value) {
            write_at(index, value);
        }
    };
    for edge in (0..4).filter(|edge| work.edges >> edge & 1 != 0) {
        let line = Line::new(size, edge, -1);
        ring_row(field, Side { tile: work.tile, edge }, |k, value| write(&line, k as isize, value));
    }
    for corner in (0..4).filter(|corner| work.corners >> corner & 1 != 0) {
        let (after, before) = (Line::new(size, corner, -1), Line::new(size, (corner + 3) & 3, -1));
        let (tile, ends) = (work.tile, [(corner, 0), ((corner + 3) & 3, last)]);
        if let Some(value) = corner_value(field, tile, corner) {
            write(&after, -1, value);
            write(&after, 0, value);
            write(&before, last as isize, value);
            continue;
        }
        write(&after, -1, diagonal(field, tile, corner));
        // Rows that are not brought up to date as a whole end here as well.
        for ((edge, k), line) in ends.into_iter().zip([after, before]) {
            if work.edges >> edge & 1 == 0 {
                write(&line, k as isize, ring_texel(field, Side { tile, edge }, k));
            }
        }
    }
}

/// The rings and equalised corners of the mips of the tiles in `plan`: index among the mips and value.
///
/// Each mip has neighbours of its own density, as tiles have, and follows the same rules but two: a tile without a
/// block counts as a blank one, so that borders beside it keep what they are, and vertices are made from the means of
/// the tiles' corners, which is not what they hold once they are equalised.
#[inline(never)]
pub(crate) fn mip_rings<T: Texel>(context: &Context, field: &Field<T>, plan: &Plan, writes: &mut Writes<T>) {
    let views: [View<'_, T>; MAX_SIZE.ilog2() as usize] =
        std::array::from_fn(|power| View::at(field, 2 << power).with_poles(context, plan));
    collect(context, &plan.work, writes, |work, out| {
        let class = field.class(work.tile);
        let sub = u32::from(field.topology().is_sub(work.tile));
        for level in 1..=class.mips() {
            let density = (class.size() >> level) << sub;
            let Some(view) = views.get(density.ilog2() as usize - 1) else { continue };
            let Some(block) = view.block(work.tile) else { continue };
            let start = class.level_start(level);
            ring_of(view, *work, |at, value| out.push(((start + at) as u32, value)));
            for corner in (0..4).filter(|corner| work.corners >> corner & 1 != 0) {
                let at = Line::new(view.size(work.tile), corner, 0).at(0);
                if let Some(value) = corner_value(view, work.tile, corner)
                    && !block[at].same(value)
                {
                    out.push(((start + at) as u32, value));
                }
            }
        }
    })
}

/// A texel of a mip of a tile without a block: blank but for what its neighbours do to its ring and corners. `i` and
/// `j` are columns and rows of the block, ring included.
pub(crate) fn texel_of_none<T: Texel>(view: &View<'_, T>, tile: u32, i: usize, j: usize) -> T {
    let last = view.size(tile) as usize + 1;
    let inner = |k: usize| k.clamp(1, last - 1);
    // The corner that a texel of the ring or the border is at, if it is at one.
    let end = |k: usize| {
        if k <= 1 {
            Some(false)
        } else if k + 1 >= last {
            Some(true)
        } else {
            None
        }
    };
    if let (Some(right), Some(up)) = (end(i), end(j)) {
        let corner = match (right, up) {
            (false, false) => 0,
            (true, false) => 1,
            (true, true) => 2,
            (false, true) => 3,
        };
        if let Some(value) = corner_value(view, tile, corner) {
            return value;
        }
        if inner(i) != i && inner(j) != j {
            return diagonal(view, tile, corner);
        }
    }
    let side = |edge: u8| Side { tile, edge };
    if j == 0 {
        ring_texel(view, side(0), i - 1)
    } else if i == last {
        ring_texel(view, side(1), j - 1)
    } else if j == last {
        ring_texel(view, side(2), last - 1 - i)
    } else if i == 0 {
        ring_texel(view, side(3), last - 1 - j)
    } else {
        view.blank()
    }
}

/// Tiles below which waking threads costs more than they save.
const MIN_PARALLEL: usize = 64;

/// Items of `work` that are done together.
const TOGETHER: usize = 16;

/// Runs `of` for every item of `work` and keeps in `writes` the lists that are not empty.
fn collect<T: Texel>(
    context: &Context,
    work: &[Work],
    writes: &mut Writes<T>,
    of: impl Fn(&Work, &mut Vec<(u32, T)>) + Sync,
) {
    let pieces = &mut writes.0;
    let count = work.len().div_ceil(TOGETHER);
    if pieces.len() < count {
        pieces.resize_with(count, || Piece { tiles: Vec::new(), texels: Vec::new() });
    }
    for piece in pieces.iter_mut() {
        piece.tiles.clear();
        piece.texels.clear();
    }
    let fill = |index: usize, piece: &mut Piece<T>| {
        for work in work.iter().skip(index * TOGETHER).take(TOGETHER) {
            let start = piece.texels.len();
            of(work, &mut piece.texels);
            if piece.texels.len() > start {
                piece.tiles.push((work.tile, start..piece.texels.len()));
            }
        }
    };
    if work.len() < MIN_PARALLEL {
        pieces[..count].iter_mut().enumerate().for_each(|(index, piece)| fill(index, piece));
    } else {
        context.for_each_mut(&mut pieces[..count], fill);
    }
}

/// The sides and vertices that `changes` concern, of allocated tiles, in place of what `plan` holds.
#[inline(never)]
pub(crate) fn plan<T: Texel>(field: &View<'_, T>, changes: impl Iterator<Item = Change>, plan: &mut Plan) {
    let topology = field.topology();
    let Plan { work, poles: vertices } = plan;
    work.clear();
    vertices.clear();
    let side = |side: Side| Work { tile: side.tile, edges: 1 << side.edge, corners: 0 };
    for change in changes {
        let tile = change.tile;
        for edge in (0..4u8).filter(|edge| change.borders >> edge & 1 != 0) {
            work.push(side(Side { tile, edge }));
            vertices.push(topology.rings(tile)[usize::from(edge)]);
            vertices.push(topology.rings(tile)[usize::from((edge + 1) & 3)]);
            match topology.link(tile, edge) {
                Link::Boundary | Link::Pinned { .. } => {}
                Link::Whole { side: other, .. } | Link::Half { side: other, .. } => work.push(side(other)),
                Link::Halves { first, second, middle, .. } => {
                    work.extend([side(first), side(second)]);
                    vertices.push(middle);
                }
            }
        }
    }
    vertices.sort_unstable();
    vertices.dedup();
    for ring in vertices.iter().copied() {
        let entries = topology.ring(ring);
        // Between tiles of different density the value of a vertex reaches further along the row than one texel.
        let even = entries.iter().all(|entry| field.density(entry.tile) == field.density(entries[0].tile));
        for entry in entries.iter().filter(|entry| !entry.middle) {
            let edges = if even { 0 } else { 1 << entry.corner | 1 << ((entry.corner + 3) & 3) };
            work.push(Work { tile: entry.tile, edges, corners: 1 << entry.corner });
        }
        // The rows that meet in the middle of an edge may each depend on the others.
        if let Some(quad) = entries.iter().find(|entry| entry.middle) {
            work.push(Work { tile: quad.tile, edges: 1 << quad.corner, corners: 0 });
            if let Link::Halves { first, second, .. } = topology.link(quad.tile, quad.corner) {
                work.extend([side(first), side(second)]);
            }
        }
    }
    work.retain(|work| field.is_allocated(work.tile));
    work.sort_unstable_by_key(|work| work.tile);
    work.dedup_by(|next, kept| {
        let same = next.tile == kept.tile;
        if same {
            kept.edges |= next.edges;
            kept.corners |= next.corners;
        }
        same
    });
    vertices.retain(|ring| topology.ring(*ring).len() > POLE);
}

/// The parts of a side that have a neighbour: one, or two beside sub-tiles; none at borders and non-manifold edges.
fn spans<T: Texel>(field: &View<'_, T>, side: Side) -> [Option<Span>; 2] {
    let topology = field.topology();
    let size = field.size(side.tile) as usize;
    let size_of = |side: Side| field.size(side.tile) as usize;
    let rings = topology.rings(side.tile);
    let ends = [rings[usize::from(side.edge)], rings[usize::from((side.edge + 1) & 3)]];
    match topology.link(side.tile, side.edge) {
        Link::Boundary | Link::Pinned { .. } => [None, None],
        Link::Whole { side: other, reversed } => {
            [Some(Span { own: (0, size), side: other, other: (0, size_of(other)), reversed, ends }), None]
        }
        Link::Half { side: other, second, reversed } => {
            let half = size_of(other) / 2;
            let other_span = (if second { half } else { 0 }, half);
            [Some(Span { own: (0, size), side: other, other: other_span, reversed, ends }), None]
        }
        Link::Halves { first, second, reversed, middle } => {
            let half = size / 2;
            let part = |start: usize, side: Side, ends: [u32; 2]| {
                Some(Span { own: (start, half), side, other: (0, size_of(side)), reversed, ends })
            };
            [part(0, first, [ends[0], middle]), part(half, second, [middle, ends[1]])]
        }
    }
}

impl Span {
    /// The neighbour's texel, along its edge, at position `q` of the span counted in this tile's direction.
    fn across(&self, q: usize) -> usize {
        self.other.0 + if self.reversed { q } else { self.other.1 - 1 - q }
    }
}

/// The border row of the neighbour along a span, in this tile's direction.
fn across<'a, T: Texel>(field: &View<'a, T>, span: &'a Span) -> impl Fn(usize) -> T + use<'a, T> {
    let (block, blank) = (field.block(span.side.tile), field.blank());
    let line = Line::new(field.size(span.side.tile), span.side.edge, 0);
    move |q: usize| block.map_or(blank, |block| block[line.at(span.across(q) as isize)])
}

/// From the neighbour's frame to that of `side` at texel `q` of `count` of their span.
fn turn_across<T: Texel>(field: &View<'_, T>, side: Side, span: &Span, q: usize, count: usize) -> Turn {
    let Some(frames) = field.field.frames.as_ref().filter(|_| T::FRAMED) else { return Turn::plain(span.reversed) };
    let along = (q as f32 + 0.5) / count as f32;
    let place = |(start, texels): (usize, usize), along: f32, tile: u32| {
        (start as f32 + along * texels as f32) / field.size(tile) as f32
    };
    let own = place(span.own, along, side.tile);
    let other = place(span.other, if span.reversed { along } else { 1.0 - along }, span.side.tile);
    frames.across((side, own), (span.side, other), span.reversed)
}

/// The ring row along a side, texel by texel.
fn ring_row<T: Texel>(field: &View<'_, T>, side: Side, mut write: impl FnMut(usize, T)) {
    let size = field.size(side.tile) as usize;
    let block = field.block(side.tile);
    let border = Line::new(size as u32, side.edge, 0);
    let own = |k: usize| block.map_or(field.blank(), |block| block[border.at(k as isize)]);
    match field.topology().link(side.tile, side.edge) {
        Link::Boundary => {
            let ends = [side.edge, (side.edge + 1) & 3].map(|corner| corner_value(field, side.tile, corner));
            write(0, ends[0].unwrap_or(own(0)));
            (1..size - 1).for_each(|k| write(k, own(k)));
            write(size - 1, ends[1].unwrap_or(own(size - 1)));
        }
        Link::Pinned { .. } => (0..size).for_each(|k| write(k, field.blank())),
        _ => {
            let spans = spans(field, side);
            for span in spans.iter().flatten() {
                span_row(field, side, span, &mut write);
            }
        }
    }
}

/// The part of a ring row along a span.
fn span_row<T: Texel>(field: &View<'_, T>, side: Side, span: &Span, write: &mut impl FnMut(usize, T)) {
    let (start, count) = span.own;
    if !field.is_allocated(span.side.tile) {
        return (start..start + count).for_each(|k| write(k, field.blank()));
    }
    let neighbour = across(field, span);
    let ends = [(0, side.edge), (1, (side.edge + 1) & 3)]
        .map(|(end, corner)| end_value(field, side.tile, span.ends[end], corner));
    let inner = usize::from(ends[0].is_some())..count - usize::from(ends[1].is_some());
    let turn = |q: usize, count: usize| turn_across(field, side, span, q, count);
    if count == span.other.1 {
        inner.for_each(|k| write(start + k, neighbour(k).turned(turn(k, count))));
    } else if count < span.other.1 {
        let fine: Vec<T::Value> = (0..span.other.1).map(|q| neighbour(q).seen(turn(q, span.other.1))).collect();
        let row = restrict_curve(&fine, span.other.1 / count);
        inner.for_each(|k| write(start + k, T::nearest(row[k])));
    } else {
        let block = field.block(side.tile);
        let border = Line::new(field.size(side.tile), side.edge, 0);
        let mut curve = ended_curve(field, side, span);
        while curve.len() < count + 2 {
            curve = subdivide_curve(&curve);
        }
        inner.for_each(|k| {
            let own = block.map_or(field.blank(), |block| block[border.at((start + k) as isize)]).value();
            write(start + k, T::nearest(T::turn_value(curve[k + 1], turn(k, count)) * 2.0 - own));
        });
    }
    if let Some(value) = ends[0] {
        write(start, value);
    }
    if let Some(value) = ends[1] {
        write(start + count - 1, value);
    }
}

/// The edge curve of the coarser neighbour along a span of the finer side, in the neighbour's frame: the mean of its
/// border and of its ring.
fn edge_curve<T: Texel>(field: &View<'_, T>, side: Side, span: &Span) -> Vec<T::Value> {
    if !field.is_allocated(span.side.tile) || !field.is_allocated(side.tile) {
        return vec![field.blank().value(); span.other.1];
    }
    let (neighbour, block) = (across(field, span), field.block(side.tile));
    let border = Line::new(field.size(side.tile), side.edge, 0);
    let own = |k: usize| {
        let turn = turn_across(field, side, span, k, span.own.1).inverse();
        block.map_or(field.blank(), |block| block[border.at((span.own.0 + k) as isize)]).seen(turn)
    };
    let fine: Vec<T::Value> = (0..span.own.1).map(own).collect();
    let ring = restrict_curve(&fine, span.own.1 / span.other.1);
    ring.into_iter().enumerate().map(|(q, ring)| (neighbour(q).value() + T::nearest(ring).value()) * 0.5).collect()
}

/// As [`edge_curve`], with one coefficient more at each end.
fn ended_curve<T: Texel>(field: &View<'_, T>, side: Side, span: &Span) -> Vec<T::Value> {
    let mut curve = edge_curve(field, side, span);
    let ends = [0, 1].map(|end| {
        let corner = (span.side.edge + u8::from((end == 1) == span.reversed)) & 3;
        end_value(field, span.side.tile, span.ends[end], corner)
    });
    let last = curve.len() - 1;
    for (end, at) in ends.into_iter().zip([0, last]) {
        if let Some(value) = end {
            curve[at] = value.value();
        }
    }
    // The curve goes on beyond the middle of a quad's edge; everywhere else the vertex has a value.
    let beyond = |end: usize| match ends[end] {
        Some(value) => value.value(),
        None => {
            let other = continuation(field, side, span, end == 1);
            let (ring, tile) = (span.ends[end], span.side.tile);
            other.map_or(curve[if end == 0 { 0 } else { last }], |(side, span, at_start)| {
                let curve = edge_curve(field, side, &span);
                let value = if at_start { curve[0] } else { curve[curve.len() - 1] };
                T::turn_value(value, between(field, ring, span.side.tile, tile))
            })
        }
    };
    let (before, after) = (beyond(0), beyond(1));
    std::iter::once(before).chain(curve).chain(std::iter::once(after)).collect()
}

/// The finer side and span that continue a span beyond its start or end, which is the middle of a quad's edge, and
/// whether the continuation begins there.
fn continuation<T: Texel>(field: &View<'_, T>, side: Side, span: &Span, at_end: bool) -> Option<(Side, Span, bool)> {
    match field.topology().link(side.tile, side.edge) {
        Link::Halves { .. } => {
            let [first, second] = spans(field, side);
            if at_end { Some((side, second?, true)) } else { Some((side, first?, false)) }
        }
        Link::Half { side: quad, second, .. } => {
            let Link::Halves { first: a, second: b, .. } = field.topology().link(quad.tile, quad.edge) else {
                return None;
            };
            let sibling = if second { a } else { b };
            let [other, _] = spans(field, sibling);
            let other = other?;
            // Both sub-tiles have one face, so that their edges run on in the same direction.
            let at_start = other.ends[0] == span.ends[usize::from(at_end)];
            Some((sibling, other, at_start))
        }
        _ => None,
    }
}

/// One texel of a ring row.
fn ring_texel<T: Texel>(field: &View<'_, T>, side: Side, k: usize) -> T {
    let mut found = field.blank();
    for span in spans(field, side).iter().flatten() {
        let (start, count) = span.own;
        if (start..start + count).contains(&k) && count == span.other.1 {
            let turn = turn_across(field, side, span, k - start, count);
            return if field.is_allocated(span.side.tile) {
                across(field, span)(k - start).turned(turn)
            } else {
                field.blank()
            };
        }
    }
    ring_row(field, side, |at, value| {
        if at == k {
            found = value;
        }
    });
    found
}

/// The ring's corner at a vertex where texels are copied.
fn diagonal<T: Texel>(field: &View<'_, T>, tile: u32, corner: u8) -> T {
    let topology = field.topology();
    let ring = topology.rings(tile)[usize::from(corner)];
    let entries = topology.ring(ring);
    let Some(own) = entries.iter().position(|entry| (entry.tile, entry.corner) == (tile, corner)) else {
        return field.blank();
    };
    let Some(at) = opposite(topology, ring, own) else { return field.blank() };
    let (other, turn) = (&entries[at], around(field, ring, at, own));
    if topology.ring_class(ring) != RingClass::Tee {
        return border_corner(field, other).turned(turn);
    }
    // What the other sub-tile has across its half of the quad's edge. Corner 1 ends edge 0, corner 3 begins edge 3: the two
    // halves of an edge of a face.
    let last = field.size(other.tile) as usize - 1;
    let (edge, k) = if other.corner == 1 { (0, last) } else { (3, 0) };
    ring_texel(field, Side { tile: other.tile, edge }, k).turned(turn)
}

/// The texel of a tile's border at a vertex, blank if it is not allocated; of a mip, before it is equalised.
fn border_corner<T: Texel>(field: &View<'_, T>, entry: &Incidence) -> T {
    let Some(block) = field.field.block(entry.tile) else { return field.blank() };
    let mut size = field.field.size(entry.tile);
    let mut corner = block[Line::new(size, entry.corner, 0).at(0)];
    for level in 0..field.level(entry.tile) {
        let Some(block) = field.field.level(entry.tile, level) else { return corner };
        corner = mip::corner_mean(block, size as usize, entry.corner, corner);
        size /= 2;
    }
    corner
}

/// How the texels around a vertex are made. A value is in the frame of the ring's first tile.
fn vertex<T: Texel>(field: &View<'_, T>, ring: u32) -> Vertex<T> {
    let topology = field.topology();
    let entries = topology.ring(ring);
    if entries.len() > POLE
        && let Some(poles) = &field.poles
        && let Ok(index) = poles.binary_search_by_key(&ring, |(pole, _)| *pole)
    {
        return poles[index].1;
    }
    let class = topology.ring_class(ring);
    if class == RingClass::Pinned || !entries.iter().all(|entry| field.is_allocated(entry.tile)) {
        return Vertex::Set(field.blank());
    }
    let density = |entry: &Incidence| field.density(entry.tile);
    let even = entries.iter().all(|entry| density(entry) == density(&entries[0]));
    match class {
        RingClass::Tee => Vertex::Copy,
        RingClass::Regular if even => Vertex::Copy,
        RingClass::Boundary if even && entries.len() <= 2 => Vertex::Copy,
        _ => {
            let corner = |index: usize| border_corner(field, &entries[index]);
            // Frames that are turned round otherwise: what was made equal already stays as it is.
            if T::FRAMED && (1..entries.len()).all(|i| corner(0).turned(around(field, ring, 0, i)) == corner(i)) {
                return Vertex::Set(corner(0));
            }
            let sum: T::Value = (0..entries.len()).map(|i| corner(i).seen(around(field, ring, i, 0))).sum();
            Vertex::Set(T::nearest(sum / entries.len() as f64))
        }
    }
}

/// The value of all four texels around a corner in the tile's frame, or `None` where they are copied.
fn corner_value<T: Texel>(field: &View<'_, T>, tile: u32, corner: u8) -> Option<T> {
    end_value(field, tile, field.topology().rings(tile)[usize::from(corner)], corner)
}

/// The value that `ring`'s vertex gives all its texels in the frame of `tile`, at its `corner` if that is there, or `None`
/// where they are copied.
fn end_value<T: Texel>(field: &View<'_, T>, tile: u32, ring: u32, corner: u8) -> Option<T> {
    match vertex(field, ring) {
        Vertex::Copy => None,
        Vertex::Set(value) => {
            let to = entry_of(field.topology(), ring, tile, Some(corner));
            Some(value.turned(around(field, ring, 0, to)))
        }
    }
}

/// From the frame of tile `from` to that of tile `to` at the vertex of `ring`.
fn between<T: Texel>(field: &View<'_, T>, ring: u32, from: u32, to: u32) -> Turn {
    let entry = |tile: u32| entry_of(field.topology(), ring, tile, None);
    around(field, ring, entry(from), entry(to))
}
