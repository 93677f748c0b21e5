//! A displaced surface as primitives for a renderer's own ray hierarchy: blocks of cells with tight bounds, which are
//! intersected on demand (`block.rs`).
//!
//! Every tile is a square of cells, as fine as its coefficients (`tiles.rs`), every triangle three (`faces.rs`). A
//! primitive is a block of at most 16 by 16 cells. A second moment makes it move: corners and bounds go straight from one
//! place to the other. Units: object units; time from 0 to 1 between the moments.

mod block;
mod faces;
mod square;
mod tiles;

use relievo_core::simd::Level;
use relievo_core::{Context, Error, Result};

use crate::block::{BLOCK, CORNERS, Header, LANES, LEAF, MAX_OFFSET, Pose, Stored, View, intersect};
pub use crate::block::{BlockHit, BlockRay, MIN_RATE};
pub use crate::faces::MAX_SEGMENTS;
use crate::square::{Chart, Lattice, Square};
pub use crate::tiles::procedural_rates;

/// The largest number of cells along a tile.
pub const MAX_CELLS: u32 = 512;
/// Steps that a coordinate may be from the origin: single precision holds them and their sums exactly.
const MAX_STEPS: f32 = 4_194_304.0;

/// Blocks in one pose.
#[derive(Debug, Default)]
struct Moment {
    poses: Vec<Pose>,
    corners: Vec<u16>,
    boxes: Vec<u8>,
}

/// A displaced surface as primitives. It does not change.
#[derive(Debug)]
pub struct Procedural {
    level: Level,
    origin: [f32; 3],
    step: f32,
    headers: Vec<Header>,
    begin: Moment,
    end: Option<Moment>,
    tiles: Vec<u32>,
    /// Whether squares are other than tiles.
    has_charts: bool,
}

impl Procedural {
    /// The primitives of squares, of which `lattice` makes the corners, at the end if its second argument is true.
    ///
    /// Fails if it does not fit the memory limit.
    fn of_squares(
        context: &Context,
        squares: &[Square],
        moves: bool,
        lattice: impl Fn(&Square, bool) -> Result<Lattice> + Sync,
    ) -> Result<Self> {
        let moments = 1 + u64::from(moves);
        // While it is made, corners are there as floats too.
        let bytes: u64 = squares.iter().map(|square| 40 * u64::from(square.rate).pow(2)).sum::<u64>();
        let bytes = bytes.saturating_mul(moments);
        if bytes > context.memory_limit() {
            return Err(Error::memory(format!("the procedural takes {bytes} bytes while it is made"))
                .advise("use fewer cells or raise the memory limit of the context"));
        }
        let lattices = |at_end: bool| -> Result<Vec<Lattice>> {
            let made = context.map(squares.len(), |index| -> Result<Lattice> {
                let mut made = lattice(&squares[index], at_end)?;
                squares[index].chords(&mut made);
                Ok(made)
            });
            made.into_iter().collect()
        };
        let first = lattices(false)?;
        let second = moves.then(|| lattices(true)).transpose()?;
        let all = || first.iter().chain(second.iter().flatten());
        let (origin, step) = scale(all().flatten(), all().zip(squares.iter().chain(squares)));
        let mut blocks = Vec::new();
        let (mut corners, mut boxes) = (0_u64, 0_u64);
        for (index, square) in squares.iter().enumerate() {
            let rate = square.rate;
            let edge = BLOCK.min(rate);
            let [down, right, up, left] = square.seams();
            for row in (0..rate).step_by(edge as usize) {
                for column in (0..rate).step_by(edge as usize) {
                    let is_seam = (row == 0 && down)
                        || (column + edge == rate && right)
                        || (row + edge == rate && up)
                        || (column == 0 && left);
                    let header = Header {
                        tile: square.tile,
                        column: column as u16,
                        row: row as u16,
                        rate: rate as u16,
                        edge: edge as u8,
                        is_seam,
                        chart: square.chart,
                        corners,
                        boxes,
                    };
                    blocks.push((index, header));
                    corners += Header::corner_numbers(edge) as u64;
                    boxes += 6 * Header::leaves(edge) as u64;
                }
            }
        }
        if u32::try_from(blocks.len()).is_err() {
            return Err(Error::unsupported("a procedural of 2^32 blocks or more").advise("use fewer cells"));
        }
        let begin = Moment::of(context, &blocks, &first, origin, step)?;
        drop(first);
        let end = second.map(|second| Moment::of(context, &blocks, &second, origin, step)).transpose()?;
        let headers: Vec<Header> = blocks.into_iter().map(|(_, header)| header).collect();
        let tiles = headers.iter().map(|header| header.tile).collect();
        let has_charts = squares.iter().any(|square| square.chart != Chart::Tile);
        Ok(Self { level: context.level(), origin, step, headers, begin, end, tiles, has_charts })
    }

    /// The tile of every primitive.
    pub fn tiles(&self) -> &[u32] {
        &self.tiles
    }

    /// Whether there is a second moment.
    pub fn moves(&self) -> bool {
        self.end.is_some()
    }

    /// Cells of all primitives.
    pub fn cell_count(&self) -> u64 {
        self.headers.iter().map(|header| u64::from(header.edge).pow(2)).sum()
    }

    /// Bytes it occupies.
    pub fn bytes(&self) -> u64 {
        let moment = |moment: &Moment| {
            size_of_val(&moment.poses[..]) + size_of_val(&moment.corners[..]) + size_of_val(&moment.boxes[..])
        };
        let parts = size_of_val(&self.headers[..]) + size_of_val(&self.tiles[..]);
        (parts + moment(&self.begin) + self.end.as_ref().map_or(0, moment)) as u64
    }

    /// What corners are rounded to.
    pub fn step(&self) -> f32 {
        self.step
    }

    /// Bounds of a primitive at the beginning, or at the end if it moves; those between go straight from one to the
    /// other. `None` if there is no such primitive.
    pub fn bounds(&self, primitive: u32, at_end: bool) -> Option<([f32; 3], [f32; 3])> {
        let moment = self.end.as_ref().filter(|_| at_end).unwrap_or(&self.begin);
        let pose = moment.poses.get(primitive as usize)?;
        let low = [0, 1, 2].map(|axis| (self.origin[axis] + pose.base[axis] as f32 * self.step).next_down());
        let high = [0, 1, 2].map(|axis| {
            let last = pose.base[axis] + i32::from(pose.extent[axis]);
            (self.origin[axis] + last as f32 * self.step).next_up()
        });
        Some((low, high))
    }

    /// Bounds of all primitives at all times; zeros without primitives.
    pub fn all_bounds(&self) -> ([f32; 3], [f32; 3]) {
        let ends = [false, true];
        let all = (0..self.headers.len() as u32).flat_map(|primitive| ends.map(|end| self.bounds(primitive, end)));
        let merged = all.flatten().reduce(|a, b| {
            ([0, 1, 2].map(|axis| a.0[axis].min(b.0[axis])), [0, 1, 2].map(|axis| a.1[axis].max(b.1[axis])))
        });
        merged.unwrap_or_default()
    }

    fn view(&self, primitive: u32) -> Option<View<'_>> {
        let header = self.headers.get(primitive as usize)?;
        let begin = self.begin.stored(header, primitive)?;
        let end = match &self.end {
            Some(end) => Some(end.stored(header, primitive)?),
            None => None,
        };
        Some(View { header, begin, end, step: self.step })
    }

    /// Where a ray meets a primitive first; `None` if it does not, or there is no such primitive.
    pub fn intersect(&self, primitive: u32, ray: &BlockRay) -> Option<BlockHit> {
        if self.has_charts {
            return self.intersect_part(primitive, ray);
        }
        intersect(self.level, &self.view(primitive)?, ray, self.origin, false)
    }

    /// As [`Self::intersect`], of a primitive that may be a part of its tile. By itself, since the few instructions more
    /// cost tiles three rays in a hundred.
    #[inline(never)]
    fn intersect_part(&self, primitive: u32, ray: &BlockRay) -> Option<BlockHit> {
        let view = self.view(primitive)?;
        let hit = intersect(self.level, &view, ray, self.origin, false)?;
        Some(BlockHit { uv: view.header.chart.place(hit.uv), ..hit })
    }

    /// Whether a ray meets a primitive.
    pub fn occluded(&self, primitive: u32, ray: &BlockRay) -> bool {
        self.view(primitive).is_some_and(|view| intersect(self.level, &view, ray, self.origin, true).is_some())
    }
}

/// The origin and the step of all corners: a power of two, at which every block's offsets fit 16 bits and coordinates
/// are exact.
fn scale<'a>(
    points: impl Iterator<Item = &'a [f32; 3]>,
    lattices: impl Iterator<Item = (&'a Lattice, &'a Square)>,
) -> ([f32; 3], f32) {
    let (mut low, mut high) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
    for point in points {
        for axis in 0..3 {
            (low[axis], high[axis]) = (low[axis].min(point[axis]), high[axis].max(point[axis]));
        }
    }
    if low[0] > high[0] {
        return ([0.0; 3], 1.0);
    }
    let largest = |values: [f32; 3]| values.into_iter().fold(0.0_f32, f32::max);
    let extent = largest([0, 1, 2].map(|axis| high[axis] - low[axis]));
    let farthest = largest([0, 1, 2].map(|axis| low[axis].abs().max(high[axis].abs())));
    // Rays are taken to the origin, which rounds them where it is not zero.
    let origin = if farthest <= 4.0 * extent { [0.0; 3] } else { [0, 1, 2].map(|axis| 0.5 * (low[axis] + high[axis])) };
    let reach = if farthest <= 4.0 * extent { farthest } else { extent };
    let mut widest = 0.0_f32;
    for (lattice, square) in lattices {
        let (rate, edge) = (square.rate as usize, BLOCK.min(square.rate) as usize);
        let stride = rate + 1;
        for row in (0..rate).step_by(edge) {
            for column in (0..rate).step_by(edge) {
                let (mut low, mut high) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
                for corners in lattice.chunks_exact(stride).skip(row).take(edge + 1) {
                    for corner in &corners[column..=column + edge] {
                        for axis in 0..3 {
                            (low[axis], high[axis]) = (low[axis].min(corner[axis]), high[axis].max(corner[axis]));
                        }
                    }
                }
                widest = widest.max(largest([0, 1, 2].map(|axis| high[axis] - low[axis])));
            }
        }
    }
    // With the margins of seams.
    let least = (1.01 * widest / (MAX_OFFSET - 8) as f32).max(reach / MAX_STEPS).max(f32::MIN_POSITIVE);
    (origin, least.log2().ceil().clamp(-120.0, 120.0).exp2())
}

impl Moment {
    /// Of blocks, each with the number of its lattice.
    fn of(
        context: &Context,
        blocks: &[(usize, Header)],
        lattices: &[Lattice],
        origin: [f32; 3],
        step: f32,
    ) -> Result<Self> {
        /// Blocks of one item of parallel work.
        const CHUNK: usize = 64;
        let parts = context.map(blocks.len().div_ceil(CHUNK), |chunk| {
            let mut part = Self::default();
            for (lattice, header) in blocks.iter().skip(chunk * CHUNK).take(CHUNK) {
                part.add(header, &lattices[*lattice], origin, step)?;
            }
            Ok(part)
        });
        let mut all = Self::default();
        let edges = || blocks.iter().map(|(_, header)| u32::from(header.edge));
        let numbers: usize = edges().map(Header::corner_numbers).sum();
        all.corners.reserve_exact(numbers + LANES);
        all.boxes.reserve_exact(edges().map(|edge| 6 * Header::leaves(edge)).sum());
        all.poses.reserve_exact(blocks.len());
        for part in parts {
            let part: Self = part?;
            all.poses.extend(part.poses);
            all.corners.extend(part.corners);
            all.boxes.extend(part.boxes);
        }
        // Leaves are read in whole vectors.
        all.corners.resize(numbers + LANES, 0);
        Ok(all)
    }

    fn add(&mut self, header: &Header, lattice: &[[f32; 3]], origin: [f32; 3], step: f32) -> Result<()> {
        let (edge, stride) = (usize::from(header.edge), usize::from(header.rate) + 1);
        let whole = |value: f32, axis: usize| ((value - origin[axis]) / step).round() as i32;
        let mut corners = Vec::with_capacity((edge + 1) * (edge + 1));
        for row in 0..=edge {
            let first = (usize::from(header.row) + row) * stride + usize::from(header.column);
            for point in &lattice[first..=first + edge] {
                corners.push([0, 1, 2].map(|axis| whole(point[axis], axis)));
            }
        }
        let least = |list: &mut dyn Iterator<Item = [i32; 3]>| {
            list.fold(([i32::MAX; 3], [i32::MIN; 3]), |(low, high), corner| {
                ([0, 1, 2].map(|axis| low[axis].min(corner[axis])), [0, 1, 2].map(|axis| high[axis].max(corner[axis])))
            })
        };
        let (base, high) = least(&mut corners.iter().copied());
        // Triangles at seams are met beside their edges too.
        let span = [0, 1, 2].map(|axis| high[axis].saturating_sub(base[axis]));
        let margin = if header.is_seam { span.into_iter().max().unwrap_or(0) / 512 + 2 } else { 0 };
        let base = base.map(|base| base - margin);
        let extent = span.map(|span| span + 2 * margin);
        let most = extent.into_iter().max().unwrap_or(0);
        if most > MAX_OFFSET {
            return Err(Error::internal("a block of a procedural is wider than its step allows"));
        }
        // So that 255 units reach from end to end.
        let shift = (0_u8..8).find(|shift| most <= 255 << *shift).unwrap_or(8);
        let mut sides = [const { Vec::new() }; 6];
        for row in (0..edge).step_by(LEAF as usize) {
            for column in (0..edge).step_by(LEAF as usize) {
                let mut leaf = Vec::with_capacity(CORNERS);
                for row in row..=row + LEAF as usize {
                    let first = row * (edge + 1) + column;
                    leaf.extend_from_slice(&corners[first..=first + LEAF as usize]);
                }
                let (low, high) = least(&mut leaf.iter().copied());
                for axis in 0..3 {
                    self.corners.extend(leaf.iter().map(|corner| (corner[axis] - base[axis]) as u16));
                    sides[axis].push(((low[axis] - margin - base[axis]) >> shift) as u8);
                    sides[axis + 3].push(((high[axis] + margin - base[axis] + (1 << shift) - 1) >> shift) as u8);
                }
            }
        }
        self.boxes.extend(sides.concat());
        self.poses.push(Pose { base, extent: extent.map(|extent| extent as u16), shift });
        Ok(())
    }

    fn stored(&self, header: &Header, primitive: u32) -> Option<Stored<'_>> {
        let edge = u32::from(header.edge);
        let (corners, boxes) = (header.corners as usize, header.boxes as usize);
        Some(Stored {
            pose: self.poses.get(primitive as usize)?,
            corners: self.corners.get(corners..corners + Header::corner_numbers(edge) + LANES)?,
            boxes: self.boxes.get(boxes..boxes + 6 * Header::leaves(edge))?,
        })
    }
}
