//! One touch of a brush: the passes that paint or sculpt what is in its box.
//!
//! Schäfer, Keinert, Nießner and Stamminger 2015, Local Painting and Deformation of Meshes on the GPU, Sections 3 to 5:
//! intersect the box with the displaced surface, decide by a scan which tiles to allocate and to modify, evaluate the
//! brush at every texel, bring rings up to date. Here the brush is evaluated before the scan, so that a tile that the
//! box only grazes takes no memory. Tiles that hold nothing any more after an eraser are given back. Stages report
//! their time under `dab.intersect`, `dab.evaluate`, `dab.manage` and `dab.ring`. Displacement is in object units.

use bytemuck::{Pod, Zeroable};
use glam::Vec4;
use half::f16;
use half::slice::HalfFloatSliceExt;
use relievo_core::simd::{Arithmetic, Level};
use relievo_core::{Context, Error, Result, dispatch_simd};
use relievo_surface::{Order, Surface};
use relievo_tiles::spline::{self, Jets};
use relievo_tiles::{Candidate, Channel, ColorTexel, Displacement, Field, Paint, Sets, Texel};

use crate::brush::Brush;
use crate::cull::{self, CulledTile};
use crate::falloff::Falloff;
use crate::knots::{BLOCK_KNOTS, KnotBlock, block_edge};
use crate::object::DisplacedObject;

/// How a brush changes colours.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PaintMode {
    /// Toward the brush's colour.
    #[default]
    Mix,
    /// The brush's colour is added; alpha stays.
    Add,
    /// Multiplied by the brush's colour; alpha stays.
    Multiply,
    /// Toward the colour of what is not painted.
    Erase,
}

impl PaintMode {
    /// All modes and their names in scene files.
    pub const NAMES: [(PaintMode, &'static str); 4] = [
        (PaintMode::Mix, "mix"),
        (PaintMode::Add, "add"),
        (PaintMode::Multiply, "multiply"),
        (PaintMode::Erase, "erase"),
    ];
}

/// How a brush changes displacement.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SculptMode {
    /// Along the surface's normal by the height, against it if that is negative.
    #[default]
    Draw,
    /// Toward the mean of the four neighbours.
    Smooth,
    /// Toward the plane through the middle of the brush's box, across its third axis.
    Flatten,
    /// Toward the surface without displacement.
    Erase,
}

impl SculptMode {
    /// All modes and their names in scene files.
    pub const NAMES: [(SculptMode, &'static str); 4] = [
        (SculptMode::Draw, "draw"),
        (SculptMode::Smooth, "smooth"),
        (SculptMode::Flatten, "flatten"),
        (SculptMode::Erase, "erase"),
    ];
}

/// What a brush does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Action {
    /// Changes colours.
    Paint {
        /// How.
        mode: PaintMode,
        /// Linear Rec.709 and alpha.
        color: [f32; 4],
    },
    /// Changes displacement.
    Sculpt {
        /// How.
        mode: SculptMode,
        /// What is drawn where the share is 1, object units.
        height: f32,
    },
}

/// One touch of a brush.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dab {
    /// Where.
    pub brush: Brush,
    /// What.
    pub action: Action,
    /// How much of it, 0 to 1.
    pub strength: f32,
}

/// What dabs did.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DabReport {
    /// Tiles of which texels were looked at.
    pub tested_tiles: u64,
    /// Texels that were looked at.
    pub tested_texels: u64,
    /// Tiles of which texels changed, ascending.
    pub changed: Vec<u32>,
    /// Texels that changed.
    pub changed_texels: u64,
    /// Tiles that were newly allocated, neighbours included.
    pub allocated: u64,
    /// Tiles that were given back.
    pub freed: u64,
    /// Tiles that the budget refused, ascending.
    pub refused: Vec<u32>,
    /// Bytes of the allocated tiles of the channel afterwards.
    pub bytes: u64,
}

impl DabReport {
    /// Adds what another dab did afterwards.
    pub fn merge(&mut self, other: DabReport) {
        let union = |a: &mut Vec<u32>, b: Vec<u32>| {
            a.extend(b);
            a.sort_unstable();
            a.dedup();
        };
        self.tested_tiles += other.tested_tiles;
        self.tested_texels += other.tested_texels;
        union(&mut self.changed, other.changed);
        self.changed_texels += other.changed_texels;
        self.allocated += other.allocated;
        self.freed += other.freed;
        union(&mut self.refused, other.refused);
        self.bytes = other.bytes;
    }
}

/// What the evaluating kernel knows of a brush. As stored in buffers.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct DabParameters {
    /// From object space, less the origin, to the brush's coordinates: rows with their shift.
    pub rows: [[f32; 4]; 3],
    /// The place in object space that is subtracted first; the fourth number is nothing.
    pub origin: [f32; 4],
    /// The [`Falloff`].
    pub falloff: u32,
    /// The strength.
    pub strength: f32,
    /// Nothing.
    pub padding: [u32; 2],
}

impl DabParameters {
    fn new(dab: &Dab, object: &DisplacedObject) -> Self {
        let map = dab.brush.map() * object.transform;
        let origin = object.transform.inverse().transform_point3(dab.brush.obb().center).as_vec3();
        let shift = map.transform_point3(origin.as_dvec3());
        let row = |axis: usize| map.matrix3.row(axis).as_vec3().extend(shift[axis] as f32).to_array();
        Self {
            rows: [0, 1, 2].map(row),
            origin: origin.extend(0.0).to_array(),
            falloff: dab.brush.falloff() as u32,
            strength: dab.strength,
            padding: [0; 2],
        }
    }

    fn falloff(&self) -> Falloff {
        Falloff::NAMES.get(self.falloff as usize).map_or(Falloff::Constant, |(falloff, _)| *falloff)
    }
}

impl Dab {
    /// Fails if a number is not finite or out of its range.
    pub fn check(&self) -> Result<()> {
        let fault = |what: &str, remedy: &str| Err(Error::invalid(what).at("dab").advise(remedy));
        if !(0.0..=1.0).contains(&self.strength) {
            return fault("its strength is out of range", "use 0 to 1");
        }
        match self.action {
            Action::Paint { color, .. } if color.iter().any(|value| !(0.0..=1e4).contains(value)) => {
                fault("its colour is out of range", "use numbers from 0 to 10000")
            }
            Action::Sculpt { height, .. } if !(-60000.0..=60000.0).contains(&height) => {
                fault("its height is out of range", "use object units from -60000 to 60000")
            }
            _ => Ok(()),
        }
    }

    /// Paints or sculpts `object`, all passes in a row.
    ///
    /// Fails, and changes nothing, if a number is out of range, or the object has no colours and is to be painted.
    pub fn apply(&self, context: &Context, object: &mut DisplacedObject) -> Result<DabReport> {
        self.make(context, object, None)
    }

    /// As [`Self::apply`], as one of the dabs of a stroke: what is in the box, and how much of the edit it gets, goes by
    /// the displacement `start` from when the stroke began. So dabs that overlap add up to an even ridge, rather than
    /// each finding what the one before raised. Only dabs were made since, and the reach was known then.
    pub(crate) fn make(
        &self,
        context: &Context,
        object: &mut DisplacedObject,
        start: Option<&Field>,
    ) -> Result<DabReport> {
        self.check()?;
        match self.action {
            Action::Paint { mode, color } => self.paint(context, object, start, mode, Vec4::from(color)),
            Action::Sculpt { mode, height } => self.sculpt(context, object, start, mode, height),
        }
    }

    fn paint(
        &self,
        context: &Context,
        object: &mut DisplacedObject,
        start: Option<&Field>,
        mode: PaintMode,
        color: Vec4,
    ) -> Result<DabReport> {
        let Some(mut paint) = object.paint.take() else {
            return Err(Error::invalid("the object has no colours to paint on").advise("give it some first"));
        };
        let done = self.paint_channel(context, object, start, &mut paint, mode, color);
        object.paint = Some(paint);
        done
    }

    fn paint_channel(
        &self,
        context: &Context,
        object: &mut DisplacedObject,
        start: Option<&Field>,
        paint: &mut Paint,
        mode: PaintMode,
        color: Vec4,
    ) -> Result<DabReport> {
        let parameters = DabParameters::new(self, object);
        let culled = self.intersect(context, object, start, |_, tile| paint.field().size(tile));
        let blank = paint.field().blank().color();
        let field = paint.field();
        let displacement = start.unwrap_or(object.displacement.field());
        let heights = |window: &Window, out: &mut Scratch| {
            surface_heights(context.level(), displacement, window, &mut out.heights);
        };
        let edits = evaluate(context, &object.surface, field, &culled, &parameters, heights, |_, weights, old| {
            let now = old.color();
            let share = weights.share;
            Some(ColorTexel::of_color(match mode {
                PaintMode::Mix => now + (color - now) * share,
                PaintMode::Add => now + (color * share).truncate().extend(0.0),
                PaintMode::Multiply => now * (Vec4::ONE + (color - Vec4::ONE) * share).truncate().extend(1.0),
                PaintMode::Erase => now + (blank - now) * share,
            }))
        });
        write(context, paint, &culled, &edits, mode == PaintMode::Erase)
    }

    fn sculpt(
        &self,
        context: &Context,
        object: &mut DisplacedObject,
        start: Option<&Field>,
        mode: SculptMode,
        height: f32,
    ) -> Result<DabReport> {
        let parameters = DabParameters::new(self, object);
        let culled = self.intersect(context, object, start, |object, tile| object.displacement.field().size(tile));
        let field = object.displacement.field();
        let read = |field: &Field, window: &Window, out: &mut [f32; BLOCK_KNOTS]| {
            let Some(block) = field.block(window.tile) else { return out.fill(0.0) };
            let edge = window.edge as usize;
            for (at, out) in window.indices().step_by(edge).zip(out.chunks_exact_mut(edge)) {
                block[at..at + edge].convert_to_f32_slice(out);
            }
        };
        let heights = |window: &Window, out: &mut Scratch| {
            read(start.unwrap_or(field), window, &mut out.heights);
            // How far it rose since.
            match start {
                None => out.risen.fill(0.0),
                Some(_) => {
                    read(field, window, &mut out.risen);
                    out.risen.iter_mut().zip(&out.heights).for_each(|(now, then)| *now -= then);
                }
            }
        };
        let edits = evaluate(context, &object.surface, field, &culled, &parameters, heights, |around, weights, old| {
            let now = old.to_f32();
            let wanted = match mode {
                SculptMode::Draw => now + height * weights.share,
                SculptMode::Smooth => {
                    let [down, left, right, up] = around?.map(f16::to_f32);
                    now + weights.share * (0.25 * ((down + up) + (left + right)) - now)
                }
                SculptMode::Flatten => now - weights.share * weights.above?,
                SculptMode::Erase => now - weights.share * now,
            };
            Some(f16::from_f32(wanted.clamp(-65504.0, 65504.0)))
        });
        let ranges = context.map(edits.len(), |index| {
            let ranges = edits[index].blocks.iter().map(|(_, values)| cull::range(values));
            ranges.fold([0.0f32; 2], |sum, range| [sum[0].min(range[0]), sum[1].max(range[1])])
        });
        let range = ranges.iter().fold([0.0f32; 2], |sum, range| [sum[0].min(range[0]), sum[1].max(range[1])]);
        object.widen(range);
        let displacement: &mut Displacement = &mut object.displacement;
        write(context, displacement, &culled, &edits, mode == SculptMode::Erase)
    }

    /// The first pass: tiles and blocks of texels that may be in the box.
    fn intersect(
        &self,
        context: &Context,
        object: &mut DisplacedObject,
        start: Option<&Field>,
        size: impl Fn(&DisplacedObject, u32) -> u32 + Sync,
    ) -> Vec<CulledTile> {
        let mut stage = context.stats().begin("dab.intersect");
        let mut culled = cull::cull_box(context, object, self.brush.obb(), size, start);
        culled.sort_unstable_by_key(|tile| tile.tile);
        stage.count("tiles", culled.len() as u64);
        stage.count("blocks", culled.iter().map(|tile| tile.blocks.len() as u64).sum());
        culled
    }
}

/// A block of texels of a tile.
#[derive(Clone, Copy, Debug)]
struct Window {
    tile: u32,
    size: u32,
    edge: u32,
    column: u32,
    row: u32,
}

impl Window {
    fn new(tile: u32, size: u32, index: u32) -> Self {
        let edge = block_edge(size);
        let blocks = size / edge;
        Self { tile, size, edge, column: index % blocks * edge, row: index / blocks * edge }
    }

    fn stride(&self) -> usize {
        self.size as usize + 2
    }

    /// Where its texels are in the tile's block, row by row.
    fn indices(&self) -> impl Iterator<Item = usize> + use<> {
        let Self { edge, column, row, .. } = *self;
        let stride = self.stride();
        (0..edge * edge).map(move |k| (row + 1 + k / edge) as usize * stride + (column + 1 + k % edge) as usize)
    }
}

/// What the brush says of one texel.
#[derive(Clone, Copy, Debug)]
struct Weights {
    /// Share of the edit, more than 0.
    share: f32,
    /// Object units along the surface's normal above the plane through the middle of the brush; `None` where the
    /// normal does not point out of that plane.
    above: Option<f32>,
}

/// The new texels of a tile.
#[derive(Clone, Debug)]
struct TileEdit<T> {
    tile: u32,
    /// Index of each block that changes, and all its texels.
    blocks: Vec<(u32, Vec<T>)>,
    /// Texels that change.
    count: u64,
}

/// The displacement at the texels of a window of another channel.
fn surface_heights(level: Level, field: &Field, window: &Window, out: &mut [f32; BLOCK_KNOTS]) {
    let Some(block) = field.block(window.tile) else { return out.fill(0.0) };
    let places = |first: u32| -> Vec<f32> {
        (first..first + window.edge).map(|i| (i as f32 + 0.5) / window.size as f32).collect()
    };
    let mut jets = Jets::default();
    let size = field.size(window.tile);
    spline::grid(level, block, size, &places(window.column), &places(window.row), Order::Position, &mut jets);
    jets.d.iter().zip(out).for_each(|(d, out)| *out = *d);
}

/// The second pass: the brush at every texel of the blocks. `heights` sets the displacement of a window's texels,
/// `change` the new texel of an old one and its neighbours, if it changes. Only tiles that change are returned.
fn evaluate<T: Texel>(
    context: &Context,
    surface: &Surface,
    field: &Field<T>,
    culled: &[CulledTile],
    parameters: &DabParameters,
    heights: impl Fn(&Window, &mut Scratch) + Sync,
    change: impl Fn(Option<[T; 4]>, &Weights, T) -> Option<T> + Sync,
) -> Vec<TileEdit<T>> {
    let mut stage = context.stats().begin("dab.evaluate");
    let level = context.level();
    let edits = context.map(culled.len(), |index| {
        let CulledTile { tile, blocks } = &culled[index];
        let source = field.block(*tile);
        let mut edit = TileEdit { tile: *tile, blocks: Vec::new(), count: 0 };
        let mut knots = KnotBlock::ZERO;
        let mut weights = Scratch::default();
        for block in blocks {
            let window = Window::new(*tile, field.size(*tile), block.index);
            knots.evaluate(level, surface, *tile, window.size, block.index);
            heights(&window, &mut weights);
            weigh(level, parameters, &knots, &mut weights);
            let stride = window.stride();
            let mut count = 0;
            let values: Vec<T> = window
                .indices()
                .enumerate()
                .map(|(k, at)| {
                    let old = source.map_or(field.blank(), |source| source[at]);
                    if weights.share[k] <= 0.0 {
                        return old;
                    }
                    let around = source.map(|source| [at - stride, at - 1, at + 1, at + stride].map(|at| source[at]));
                    let weights = Weights {
                        share: weights.share[k],
                        above: (weights.rise[k] > 0.0).then(|| weights.level[k] / weights.rise[k] + weights.risen[k]),
                    };
                    let new = change(around, &weights, old).unwrap_or(old);
                    count += u64::from(!new.same(old));
                    new
                })
                .collect();
            if count > 0 {
                edit.blocks.push((block.index, values));
                edit.count += count;
            }
        }
        edit
    });
    stage.count("texels", culled.iter().map(|tile| tested(field, tile)).sum());
    edits.into_iter().filter(|edit| edit.count > 0).collect()
}

/// Texels of a tile's blocks.
fn tested<T: Texel>(field: &Field<T>, tile: &CulledTile) -> u64 {
    let edge = u64::from(block_edge(field.size(tile.tile)));
    tile.blocks.len() as u64 * edge * edge
}

/// What is computed of a block side by side.
struct Scratch {
    /// Displacements by which places are in the box or not.
    heights: [f32; BLOCK_KNOTS],
    /// By how much displacements are larger than that.
    risen: [f32; BLOCK_KNOTS],
    /// Shares of the edit.
    share: [f32; BLOCK_KNOTS],
    /// Third coordinates in the brush.
    level: [f32; BLOCK_KNOTS],
    /// How much the third coordinate grows along the normal.
    rise: [f32; BLOCK_KNOTS],
}

impl Default for Scratch {
    fn default() -> Self {
        let zero = [0.0; BLOCK_KNOTS];
        Self { heights: zero, risen: zero, share: zero, level: zero, rise: zero }
    }
}

dispatch_simd! {
    /// The brush at the displaced points of a block.
    fn weigh = weigh_body(parameters: &DabParameters, knots: &KnotBlock, weights: &mut Scratch)
}

#[inline(always)]
fn weigh_body<A: Arithmetic>(parameters: &DabParameters, knots: &KnotBlock, weights: &mut Scratch) {
    let DabParameters { rows, origin, strength, .. } = *parameters;
    let Scratch { heights, share, level, rise, .. } = weights;
    // The square of the distance from the middle, or −1 outside.
    for k in 0..BLOCK_KNOTS {
        let from = [0, 1, 2].map(|axis| knots.p[axis][k] - origin[axis]);
        let n = [0, 1, 2].map(|axis| knots.n[axis][k]);
        let (mut inside, mut square) = (true, 0.0);
        for row in rows {
            let along = A::fma(row[0], n[0], A::fma(row[1], n[1], row[2] * n[2]));
            let at = A::fma(row[0], from[0], A::fma(row[1], from[1], A::fma(row[2], from[2], row[3])));
            let at = A::fma(heights[k], along, at);
            inside &= at.abs() <= 1.0;
            square = A::fma(at, at, square);
            (level[k], rise[k]) = (at, along);
        }
        share[k] = if inside { square } else { -1.0 };
    }
    // A loop for each formula, so that none asks which it is.
    match parameters.falloff() {
        Falloff::Constant => fade(share, strength, |square| Falloff::Constant.of_square(square)),
        Falloff::Linear => fade(share, strength, |square| Falloff::Linear.of_square(square)),
        Falloff::Smooth => fade(share, strength, |square| Falloff::Smooth.of_square(square)),
        Falloff::Sphere => fade(share, strength, |square| Falloff::Sphere.of_square(square)),
        Falloff::Gaussian => fade(share, strength, |square| Falloff::Gaussian.of_square(square)),
    }
}

/// Squares of distances, −1 outside, to shares of the edit.
#[inline(always)]
fn fade(share: &mut [f32; BLOCK_KNOTS], strength: f32, formula: impl Fn(f32) -> f32) {
    for value in share {
        *value = if *value >= 0.0 { strength * formula(*value) } else { 0.0 };
    }
}

/// The third and fourth pass: the sets of the edit, their memory, the texels, and the rings.
fn write<T: Texel>(
    context: &Context,
    channel: &mut Channel<T>,
    culled: &[CulledTile],
    edits: &[TileEdit<T>],
    reclaim: bool,
) -> Result<DabReport> {
    let field = channel.field();
    let mut report = DabReport {
        tested_tiles: culled.len() as u64,
        tested_texels: culled.iter().map(|tile| tested(field, tile)).sum(),
        ..DabReport::default()
    };
    let before = channel.allocated_count() as u64;
    let mut stage = context.stats().begin("dab.manage");
    let candidates: Vec<Candidate> =
        edits.iter().map(|edit| Candidate { tile: edit.tile, decision: Candidate::MODIFY }).collect();
    let sets = Sets::scan(context, &candidates, |tile| field.is_allocated(tile));
    let applied = channel.apply(&sets)?;
    let edits: Vec<&TileEdit<T>> =
        edits.iter().filter(|edit| applied.refused.binary_search(&edit.tile).is_err()).collect();
    let tiles: Vec<u32> = edits.iter().map(|edit| edit.tile).collect();
    let mut changes = channel.edit(context, &tiles, |tile, texels| {
        let Ok(index) = tiles.binary_search(&tile) else { return };
        for (block, values) in &edits[index].blocks {
            let window = Window::new(tile, texels.size() as u32, *block);
            for (j, values) in values.chunks_exact(window.edge as usize).enumerate() {
                let row = texels.row_mut(window.row as usize + j);
                row[window.column as usize..][..values.len()].copy_from_slice(values);
            }
        }
    })?;
    stage.count("tiles", tiles.len() as u64);
    drop(stage);
    let mut stage = context.stats().begin("dab.ring");
    changes.extend(applied.changes);
    let mut refused = applied.refused;
    refused.extend(channel.settle(context, &changes)?);
    refused.sort_unstable();
    refused.dedup();
    if reclaim {
        // What is around an erased tile may have waited for it.
        let mut reached: Vec<u32> = culled.iter().map(|tile| tile.tile).collect();
        reached.extend(around(channel.field(), &tiles));
        report.freed = channel.reclaim(context, &reached)?.len() as u64;
    }
    report.changed_texels = edits.iter().map(|edit| edit.count).sum();
    report.changed = tiles;
    report.refused = refused;
    report.bytes = channel.bytes();
    report.allocated = (channel.allocated_count() as u64 + report.freed).saturating_sub(before);
    stage.count("allocated", report.allocated);
    stage.count("freed", report.freed);
    Ok(report)
}

/// The tiles that share a vertex with one of `tiles`.
fn around<T: Texel>(field: &Field<T>, tiles: &[u32]) -> Vec<u32> {
    let topology = field.topology();
    let rings = tiles.iter().flat_map(|tile| topology.rings(*tile));
    let mut found: Vec<u32> = rings.flat_map(|ring| topology.ring(*ring)).map(|entry| entry.tile).collect();
    found.sort_unstable();
    found.dedup();
    found
}
