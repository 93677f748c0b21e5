//! The tiles that a dab edits: the brush at every texel of the blocks in its box, and then the sets of the edit, their
//! memory, the new texels and the rings.
//!
//! Schäfer, Keinert, Nießner and Stamminger 2015, Local Painting and Deformation of Meshes on the GPU, Sections 4
//! and 5. Stages report their time under `dab.evaluate`, `dab.manage` and `dab.ring`. Displacement is in object units.

use std::sync::Arc;

use half::f16;
use relievo_core::simd::Level;
use relievo_core::{Context, List, Result};
use relievo_surface::{Grid, Placement, Surface};
use relievo_tiles::{Applied, Candidate, Channel, Displaced, Field, Points, Sets, Texel};

use crate::channels::frame::{Frames, STILL, Vectors};
use crate::channels::knots::{BLOCK_KNOTS, KnotBlock, PerKnot, block_edge};
use crate::channels::window::{PlaceShift, Window};
use crate::imprint::culled::CulledTile;
use crate::paint::report::DabReport;
use crate::paint::spot::Spot;
use crate::paint::vector::Framed;
use crate::paint::weights::{BrushParameters, Weights};

/// A block of texels, and what the brush says of it.
pub(crate) struct Site<'a, T> {
    window: Window,
    weights: Weights,
    places: KnotBlock,
    /// The displacement that the weights were evaluated with, and the vectors in the frames.
    heights: PerKnot,
    vectors: Vectors,
    frames: Frames,
    /// The tile's texels, if it has some.
    source: Option<&'a [T]>,
}

impl<T: Texel> Spot<T> for Site<'_, T> {
    fn weights(&self) -> &Weights {
        &self.weights
    }

    fn weights_mut(&mut self) -> &mut Weights {
        &mut self.weights
    }

    fn heights(&self) -> &PerKnot {
        &self.heights
    }

    /// The mean of the four neighbours.
    fn means<const N: usize>(&self, read: impl Fn(T) -> [f32; N], mut set: impl FnMut(usize, [f32; N])) -> bool {
        let Some(source) = self.source else { return false };
        let around = [(0, -1), (0, 1), (-1, 0), (1, 0)].map(|(columns, rows)| self.window.rows(columns, rows));
        let [down, up, left, right] = around;
        let mut at = 0;
        for (((down, up), left), right) in down.zip(up).zip(left).zip(right) {
            for k in 0..down.len() {
                let [d, u, l, r] = [&down, &up, &left, &right].map(|row| read(source[row.start + k]));
                set(at, std::array::from_fn(|i| 0.25 * ((d[i] + u[i]) + (l[i] + r[i]))));
                at += 1;
            }
        }
        true
    }

    fn footprints(&self) -> PerKnot {
        let edge = self.window.edge();
        let mut far = [0.0; BLOCK_KNOTS];
        for k in 0..self.window.count() {
            // The last column and row look back.
            let beside = if k % edge + 1 < edge { k + 1 } else { k - 1 };
            let over = if k + edge < self.window.count() { k + edge } else { k - edge };
            far[k] = [beside, over].iter().fold(0.0, |far: f32, other| {
                let [x, y] = [0, 1].map(|axis| self.weights.across[axis][*other] - self.weights.across[axis][k]);
                far.max((x * x + y * y).sqrt())
            });
        }
        far
    }
}

impl<T> Site<'_, T> {
    /// The cosines between the normals of the surface and of the displaced one, `displaced` by what the weights were
    /// evaluated with.
    pub fn facing(&self, context: &Context, displaced: &Displaced<'_>, out: &mut PerKnot) {
        let (tile, [column, row], edge) = (self.window.tile, self.window.first(), self.window.edge() as u32);
        let (columns, rows) = (column..column + edge, row..row + edge);
        let grid = Grid { size: self.window.size(), placement: Placement::Centred, columns, rows };
        let mut points = context.scratch().lend::<Points>();
        if displaced.grid(context, tile, &grid, &mut points).is_ok() {
            for (k, normal) in points.normal.iter().enumerate() {
                out[k] = (0..3).map(|axis| normal[axis] * self.places.n[axis][k]).sum();
            }
        }
    }
}

/// The new texels of a tile.
#[derive(Clone, Debug)]
pub(crate) struct TileEdit<T> {
    pub tile: u32,
    /// The whole block, its ring as it was.
    pub texels: Arc<[T]>,
    /// Texels that change.
    pub count: u64,
}

impl<T> Framed for Site<'_, T> {
    fn vectors(&self) -> &Vectors {
        &self.vectors
    }

    fn to_object(&self, level: Level, vectors: &mut Vectors) {
        self.frames.to_object(level, &self.places.n, vectors);
    }

    fn from_object(&self, level: Level, vectors: &mut Vectors) {
        self.frames.from_object(level, &self.places.n, vectors);
    }
}

/// The second pass: the brush at every texel of the blocks. `ground` sets what moves a window's texels; `change` makes
/// new texels of old ones. Only tiles that change are returned.
pub(crate) fn evaluate<T: Texel>(
    context: &Context,
    surface: &Surface,
    field: &Field<T>,
    culled: &[CulledTile],
    brush: &BrushParameters,
    ground: impl Fn(&Window, &mut PerKnot, &mut Vectors) -> PlaceShift + Sync,
    change: impl Fn(&mut Site<'_, T>, &mut [T]) + Sync,
) -> Vec<TileEdit<T>> {
    let mut stage = context.stats().begin("dab.evaluate");
    let level = context.level();
    let mut made = context.scratch().list();
    context.map_into(culled.len(), &mut made, |index| {
        let CulledTile { tile, blocks } = &culled[index];
        let source = field.block(*tile);
        let (mut block_of, mut changed): (Option<Arc<[T]>>, u64) = (None, 0);
        let mut site = Site {
            window: Window::new(*tile, field.size(*tile), 0),
            weights: Weights::default(),
            places: KnotBlock::ZERO,
            heights: [0.0; BLOCK_KNOTS],
            vectors: STILL,
            frames: Frames::ZERO,
            source,
        };
        let mut old = [field.blank(); BLOCK_KNOTS];
        for block in blocks.iter() {
            let window = Window::new(*tile, field.size(*tile), block.index);
            site.window = window;
            let moved = ground(&window, &mut site.heights, &mut site.vectors);
            if moved == PlaceShift::Vectors || T::FRAMED {
                site.places.evaluate_framed(level, surface, (*tile, window.size(), block.index), &mut site.frames);
            } else if moved == PlaceShift::Heights {
                site.places.evaluate(level, surface, *tile, window.size(), block.index);
            } else {
                site.places.evaluate_points(level, surface, (*tile, window.size(), block.index));
            }
            if moved == PlaceShift::Vectors {
                site.places.shift(level, &site.frames, &site.vectors);
            }
            if moved == PlaceShift::Still && !T::FRAMED {
                site.weights.evaluate_points(level, brush, &site.places);
            } else {
                site.weights.evaluate(level, brush, &site.places, &site.heights);
            }
            if !site.weights.share[..window.count()].iter().any(|share| *share > 0.0) {
                continue;
            }
            let count = window.count();
            let edge = window.edge();
            if let Some(source) = source {
                old.chunks_exact_mut(edge)
                    .zip(window.rows(0, 0))
                    .for_each(|(to, row)| to.copy_from_slice(&source[row]));
            }
            let mut texels = old;
            change(&mut site, &mut texels[..count]);
            let differ = texels[..count].iter().zip(&old).filter(|(new, old)| !new.same(**old)).count();
            if differ > 0 {
                let block = block_of.get_or_insert_with(|| field.copied(*tile));
                if let Some(block) = Arc::get_mut(block) {
                    texels
                        .chunks_exact(edge)
                        .zip(window.rows(0, 0))
                        .for_each(|(from, row)| block[row].copy_from_slice(from));
                }
                changed += differ as u64;
            }
        }
        block_of.map(|texels| TileEdit { tile: *tile, texels, count: changed })
    });
    stage.count("texels", culled.iter().map(|tile| tested(field, tile)).sum());
    let mut edits = context.scratch().take_list();
    edits.extend(made.drain(..).flatten());
    edits
}

/// Texels of a tile's blocks.
fn tested<T: Texel>(field: &Field<T>, tile: &CulledTile) -> u64 {
    let edge = u64::from(block_edge(field.size(tile.tile)));
    tile.blocks.len() as u64 * edge * edge
}

/// The least and the largest texel of the edited tiles, and 0.
pub(crate) fn range(context: &Context, edits: &[TileEdit<f16>]) -> [f32; 2] {
    let mut ranges = context.scratch().list();
    context.map_into(edits.len(), &mut ranges, |index| crate::object::ranges::range(&edits[index].texels));
    ranges.iter().fold([0.0f32; 2], |sum, range| [sum[0].min(range[0]), sum[1].max(range[1])])
}

/// The third and fourth pass: the sets of the edit, their memory, the texels, and the rings.
pub(crate) fn write<T: Texel>(
    context: &Context,
    channel: &mut Channel<T>,
    culled: &[CulledTile],
    edits: Vec<TileEdit<T>>,
    reclaim: bool,
) -> Result<DabReport> {
    write_at(context, channel, None, culled, edits, reclaim)
}

/// As [`write`], of an edit that was made at the level of `coarse`, which is what the channel has there.
pub(crate) fn write_at<T: Texel>(
    context: &Context,
    channel: &mut Channel<T>,
    coarse: Option<&Field<T>>,
    culled: &[CulledTile],
    mut edits: Vec<TileEdit<T>>,
    reclaim: bool,
) -> Result<DabReport> {
    let field = coarse.unwrap_or(channel.field());
    let mut report = DabReport {
        tested_tiles: culled.len() as u64,
        tested_texels: culled.iter().map(|tile| tested(field, tile)).sum(),
        ..DabReport::default()
    };
    let before = channel.allocated_count() as u64;
    let mut stage = context.stats().begin("dab.manage");
    let scratch = context.scratch();
    let blocks = |mut edits: Vec<TileEdit<T>>| {
        let mut blocks = scratch.take_list();
        blocks.extend(edits.drain(..).map(|edit| (edit.tile, edit.texels)));
        scratch.keep_list(edits);
        blocks
    };
    let count = |edits: &[TileEdit<T>]| edits.iter().map(|edit| edit.count).sum();
    let (mut applied, mut tiles) = (scratch.lend::<Applied>(), scratch.take_list());
    let mut changes = match coarse {
        None => {
            let mut candidates = scratch.list();
            candidates.extend(edits.iter().map(|edit| Candidate { tile: edit.tile, decision: Candidate::MODIFY }));
            let sets = Sets::scan(context, &candidates, |tile| field.is_allocated(tile));
            let done = channel.apply_into(&sets, &mut applied);
            sets.give_back(context);
            done?;
            edits.retain(|edit| applied.refused.binary_search(&edit.tile).is_err());
            tiles.extend(edits.iter().map(|edit| edit.tile));
            report.changed_texels = count(&edits);
            channel.put(context, blocks(edits))?
        }
        Some(coarse) => {
            report.changed_texels = count(&edits);
            *applied = channel.put_at(context, coarse, blocks(edits))?;
            tiles.extend(applied.changes.iter().map(|change| change.tile));
            tiles.sort_unstable();
            tiles.dedup();
            scratch.take_list()
        }
    };
    stage.count("tiles", tiles.len() as u64);
    drop(stage);
    let mut stage = context.stats().begin("dab.ring");
    changes.extend_from_slice(&applied.changes);
    let mut refused = scratch.take_list();
    refused.extend_from_slice(&applied.refused);
    refused.extend(channel.settle(context, &changes)?);
    scratch.keep_list(changes);
    refused.sort_unstable();
    refused.dedup();
    if reclaim {
        // What is around an erased tile may have waited for it.
        let mut reached = around(context, channel.field(), &tiles);
        reached.extend(culled.iter().map(|tile| tile.tile));
        report.freed = channel.reclaim(context, &reached)?.len() as u64;
    }
    report.changed = tiles;
    report.refused = refused;
    report.bytes = channel.bytes();
    report.allocated = (channel.allocated_count() as u64 + report.freed).saturating_sub(before);
    stage.count("allocated", report.allocated);
    stage.count("freed", report.freed);
    Ok(report)
}

/// The tiles that share a vertex with one of `tiles`.
pub(crate) fn around<'c, T: Texel>(context: &'c Context, field: &Field<T>, tiles: &[u32]) -> List<'c, u32> {
    let topology = field.topology();
    let rings = tiles.iter().flat_map(|tile| topology.rings(*tile));
    let mut found = context.scratch().list();
    found.extend(rings.flat_map(|ring| topology.ring(*ring)).map(|entry| entry.tile));
    found.sort_unstable();
    found.dedup();
    found
}

/// The tiles whose boxes are others after an edit: rings and borders of neighbours changed too, and so did what was
/// given back.
pub(crate) fn stale<'c, T: Texel>(
    context: &'c Context,
    field: &Field<T>,
    culled: &[CulledTile],
    report: &DabReport,
) -> List<'c, u32> {
    let mut tiles = around(context, field, &report.changed);
    tiles.extend(culled.iter().map(|tile| tile.tile));
    if report.freed > 0 {
        tiles = around(context, field, &tiles);
    }
    tiles.sort_unstable();
    tiles.dedup();
    tiles
}
