//! Catmull-Clark limit surfaces: a cage refined once per topology, its patches posed by the cage's points.

use std::ops::Range;
use std::sync::{Arc, Mutex, PoisonError};

use relievo_core::{ArcPool, Context, Error, Mesh, Parts, Result};
use relievo_opensubdiv::{BoundaryRule, Options, Table};

use crate::TileTopology;
use crate::cone::Cone;
use crate::patch::{self, ORIGIN, Patch, Pieces, Source};

/// How a cage becomes a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceOptions {
    /// The boundary rule.
    pub boundary: BoundaryRule,
    /// Levels of isolation of extraordinary features, 1 to 10. Raised to the largest finite sharpness of the cage.
    pub isolation: u32,
    /// Most patches to expect from a cage before it is refused.
    pub patch_limit: u32,
}

impl Default for SurfaceOptions {
    fn default() -> Self {
        Self { boundary: BoundaryRule::EdgesAndCorners, isolation: 6, patch_limit: 8_000_000 }
    }
}

/// A Catmull-Clark limit surface. Cloning it is cheap; poses share the topology.
#[derive(Clone)]
pub struct Surface {
    pub(crate) layout: Arc<Layout>,
    /// Control data of all patches, see [`Patch::first`].
    pub(crate) data: Arc<Vec<f32>>,
    bounds: ([f32; 3], [f32; 3]),
}

impl std::fmt::Debug for Surface {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let counts = (self.tile_count(), self.patch_count());
        out.debug_struct("Surface").field("tiles", &counts.0).field("patches", &counts.1).finish_non_exhaustive()
    }
}

/// What all poses of a cage share.
pub(crate) struct Layout {
    pub(crate) table: Table,
    pub(crate) topology: Arc<TileTopology>,
    pub(crate) patches: Vec<Patch>,
    pub(crate) pieces: Pieces,
    /// The patches of every tile, as a range of `patches`.
    pub(crate) tile_first: Vec<u32>,
    /// Quadtree leaves of every tile in Morton order: the key of the leaf's lower corner and its first patch.
    pub(crate) leaves: Vec<Leaf>,
    pub(crate) leaf_first: Vec<u32>,
    /// Where the stencil of every point beyond the cage's starts.
    pub(crate) stencil_first: Vec<usize>,
    pub(crate) data_len: usize,
    /// The control data of poses, for the next one where nobody has a surface of a pose any more.
    poses: Mutex<ArcPool<Vec<f32>>>,
}

/// A quadtree leaf of a tile. It is one patch, or the pieces of a single-crease patch.
#[derive(Clone, Copy)]
pub(crate) struct Leaf {
    pub(crate) key: u32,
    pub(crate) patch: u32,
}

/// Quadtree depth that Morton keys resolve.
const KEY_DEPTH: u32 = 10;

/// The Morton key of a cell at depth [`KEY_DEPTH`].
fn morton(u: u32, v: u32) -> u32 {
    let spread = |mut bits: u32| {
        bits = (bits | (bits << 8)) & 0x00ff_00ff;
        bits = (bits | (bits << 4)) & 0x0f0f_0f0f;
        bits = (bits | (bits << 2)) & 0x3333_3333;
        (bits | (bits << 1)) & 0x5555_5555
    };
    spread(u) | (spread(v) << 1)
}

/// Levels that the largest finite sharpness of a cage needs.
fn sharpness_levels(mesh: &Mesh) -> u32 {
    let creases = mesh.creases.iter().map(|crease| crease.sharpness);
    let values = creases.chain(mesh.sharp_points.iter().map(|(_, sharpness)| *sharpness));
    let finite = values.filter(|sharpness| *sharpness < relievo_core::mesh::INFINITE_SHARPNESS);
    finite.fold(0.0_f32, f32::max).ceil() as u32
}

fn refinement(context: &Context, mesh: &Mesh, options: &SurfaceOptions) -> Options {
    Options {
        boundary: options.boundary,
        isolation: options.isolation.max(sharpness_levels(mesh)),
        single_crease: true,
        patch_limit: f64::from(options.patch_limit),
        memory_limit: context.memory_limit(),
    }
}

/// Points per item of parallel work.
const CHUNK: usize = 4096;

impl Surface {
    /// Refines `mesh` and poses it at the mesh's own points.
    ///
    /// # Errors
    /// Fails with `Invalid` if the mesh does not pass [`Mesh::check`] or the isolation is not 1 to 10, with
    /// `Unsupported` above the limit of patches or for a face or point with more than 65,535 neighbours, with `Memory`
    /// if the patches are expected to exceed the context's memory limit, and with `NotFound` if OpenSubdiv cannot be
    /// opened.
    pub fn new(context: &Context, mesh: &Mesh, options: &SurfaceOptions) -> Result<Self> {
        mesh.check()?;
        let refinement = refinement(context, mesh, options);
        let table = context.stats().time("surface.refine", || Table::new(mesh, &refinement))?;
        let topology = TileTopology::new(mesh)?;
        if topology.tile_count() != table.tile_count() {
            return Err(Error::internal("OpenSubdiv and the mesh disagree on the number of tiles"));
        }
        let layout = Layout::new(table, topology)?;
        Self::pose(context, Arc::new(layout), &mesh.points)
    }

    /// Estimates how many bytes making the surface of `mesh` takes at its peak, within 30 % above what is used.
    ///
    /// # Errors
    /// The mesh does not pass [`Mesh::check`].
    pub fn expected_bytes(context: &Context, mesh: &Mesh, options: &SurfaceOptions) -> Result<f64> {
        mesh.check()?;
        let expected = Table::expected(mesh, &refinement(context, mesh, options))?;
        Ok(expected.last().map_or(0.0, |expected| expected.bytes))
    }

    /// The most levels of isolation, up to those of `options`, at which `mesh` is expected to make no more patches than
    /// the limit and than fit the context's memory limit. `None` if one level is too many.
    ///
    /// # Errors
    /// Fails with `Invalid` if the mesh does not pass [`Mesh::check`] or the isolation is not 1 to 10, with
    /// `Unsupported` if OpenSubdiv cannot refine it, and with `NotFound` if OpenSubdiv cannot be opened.
    pub fn affordable_isolation(context: &Context, mesh: &Mesh, options: &SurfaceOptions) -> Result<Option<u32>> {
        mesh.check()?;
        let refinement = refinement(context, mesh, options);
        let expected = Table::expected(mesh, &refinement)?;
        let least = sharpness_levels(mesh);
        let fits = |levels: &u32| {
            let count = expected.get(*levels.max(&least) as usize - 1);
            count.is_some_and(|count| refinement.check(count).is_ok())
        };
        Ok((1..=options.isolation).rev().find(fits))
    }

    /// Chooses the isolation of `mesh`: `wanted`, or where that is `None` the isolation of `options`, lowered until the
    /// surface fits the limits. Returns the options to use, and a note where the isolation was lowered.
    ///
    /// # Errors
    /// The mesh does not pass [`Mesh::check`].
    pub fn choose_isolation(
        context: &Context,
        mesh: &Mesh,
        options: &SurfaceOptions,
        wanted: Option<u32>,
    ) -> Result<(SurfaceOptions, Option<String>)> {
        if let Some(isolation) = wanted {
            return Ok((SurfaceOptions { isolation, ..*options }, None));
        }
        let most = options.isolation;
        // Where nothing fits, making the surface fails with the sizes.
        let isolation = Self::affordable_isolation(context, mesh, options)?.unwrap_or(most);
        let note = (isolation < most).then(|| {
            format!(
                "irregular points are isolated by {isolation} levels: {most} would exceed the memory limit or that of \
                 patches; raise the memory limit, or choose the isolation"
            )
        });
        Ok((SurfaceOptions { isolation, ..*options }, note))
    }

    /// The surface of the same cage with other points.
    ///
    /// # Errors
    /// Fails with `Invalid` unless there are as many points as the cage has, and all are finite.
    pub fn posed(&self, context: &Context, points: &[[f32; 3]]) -> Result<Self> {
        let count = self.layout.table.cage_point_count();
        if points.len() != count {
            return Err(Error::invalid(format!("the pose has {} points, the cage {count}", points.len())));
        }
        if let Some(index) = points.iter().position(|point| !point.iter().all(|value| value.is_finite())) {
            return Err(Error::invalid("a coordinate is not a finite number").at(format!("point {index}")));
        }
        Self::pose(context, self.layout.clone(), points)
    }

    fn pose(context: &Context, layout: Arc<Layout>, points: &[[f32; 3]]) -> Result<Self> {
        let mut all = context.scratch().lend::<Vec<[f64; 3]>>();
        context.stats().time("surface.points", || layout.points(context, points, &mut all))?;
        let poses = || layout.poses.lock().unwrap_or_else(PoisonError::into_inner);
        let mut data = poses().take().unwrap_or_else(|| Arc::new(vec![0.0; layout.data_len]));
        context.stats().time("surface.patches", || {
            let (records, indices) = (layout.table.patches(), layout.table.indices());
            let source = Source { records, indices, pieces: &layout.pieces };
            let room: &mut Vec<f32> = Arc::make_mut(&mut data);
            let posed = Posed { patches: &layout.patches, data: room };
            context.for_each_part(posed, CHUNK, |_, Posed { patches, data }| {
                let first = patches.first().map_or(0, |patch| patch.first);
                for patch in patches {
                    let start = (patch.first - first) as usize;
                    patch::fill(patch, &source, &all, &mut data[start..start + patch.data_len()]);
                }
                Ok(())
            })
        })?;
        poses().watch(&data);
        let mut surface = Self { layout, data, bounds: ([0.0; 3], [0.0; 3]) };
        surface.bounds = merge((0..surface.tile_count() as u32).filter_map(|tile| surface.hull(tile)))
            .unwrap_or(([0.0; 3], [0.0; 3]));
        Ok(surface)
    }

    /// How the tiles meet.
    pub fn topology(&self) -> &Arc<TileTopology> {
        &self.layout.topology
    }

    /// OpenSubdiv's tables of this cage.
    pub fn table(&self) -> &Table {
        &self.layout.table
    }

    /// Number of tiles, those of hole faces included.
    pub fn tile_count(&self) -> usize {
        self.layout.tile_first.len() - 1
    }

    /// Number of patches of all tiles.
    pub fn patch_count(&self) -> usize {
        self.layout.patches.len()
    }

    /// Bytes of the control data of this pose.
    pub fn bytes(&self) -> u64 {
        4 * self.data.len() as u64
    }

    /// Bounds of the whole surface, conservative.
    pub fn bounds(&self) -> ([f32; 3], [f32; 3]) {
        self.bounds
    }

    /// The diagonal of the bounds.
    pub fn extent(&self) -> f32 {
        let (low, high) = self.bounds;
        (0..3).map(|axis| (high[axis] - low[axis]).powi(2)).sum::<f32>().sqrt()
    }

    /// Bounds of a tile's limit surface, conservative. A hole has a point as its bounds.
    ///
    /// # Panics
    /// If there is no such tile.
    pub fn tile_bounds(&self, tile: u32) -> ([f32; 3], [f32; 3]) {
        self.hull(tile).unwrap_or((self.bounds.0, self.bounds.0))
    }

    /// The patches of a tile; a hole has none.
    ///
    /// # Panics
    /// If there is no such tile.
    pub fn patches(&self, tile: u32) -> impl ExactSizeIterator<Item = PatchView<'_>> {
        self.layout.patches[self.range(tile)].iter().map(|patch| self.view(patch))
    }

    pub(crate) fn range(&self, tile: u32) -> Range<usize> {
        let first = &self.layout.tile_first;
        first[tile as usize] as usize..first[tile as usize + 1] as usize
    }

    fn view<'a>(&'a self, patch: &'a Patch) -> PatchView<'a> {
        PatchView { patch, data: self.data_of(patch) }
    }

    pub(crate) fn data_of(&self, patch: &Patch) -> &[f32] {
        let first = patch.first as usize;
        &self.data[first..first + patch.data_len()]
    }

    pub(crate) fn tile_patches(&self, tile: u32) -> &[Patch] {
        &self.layout.patches[self.range(tile)]
    }

    fn hull(&self, tile: u32) -> Option<([f32; 3], [f32; 3])> {
        merge(self.patches(tile).map(|patch| patch.bounds()))
    }

    /// The patch at (u, v) of a tile, `None` for a hole or outside the unit square.
    pub(crate) fn find(&self, tile: u32, u: f32, v: f32) -> Option<&Patch> {
        let layout = &*self.layout;
        if !((0.0..=1.0).contains(&u) && (0.0..=1.0).contains(&v)) {
            return None;
        }
        let patches = self.layout.patches.get(self.range(tile))?;
        if patches.len() == 1 {
            return patches.first();
        }
        let cells = (1 << KEY_DEPTH) as f32;
        let cell = |value: f32| ((value * cells) as u32).min((1 << KEY_DEPTH) - 1);
        let key = morton(cell(u), cell(v));
        let leaves =
            &layout.leaves[layout.leaf_first[tile as usize] as usize..layout.leaf_first[tile as usize + 1] as usize];
        let leaf = leaves.partition_point(|leaf| leaf.key <= key).checked_sub(1)?;
        let end = leaves.get(leaf + 1).map_or(self.range(tile).end, |next| next.patch as usize);
        let pieces = &layout.patches[leaves[leaf].patch as usize..end];
        // A leaf's pieces ascend along one axis; the last one that starts at or before the place has it.
        pieces.iter().rev().find(|patch| patch.low[0] <= u && patch.low[1] <= v).or(pieces.first())
    }
}

fn merge(boxes: impl Iterator<Item = ([f32; 3], [f32; 3])>) -> Option<([f32; 3], [f32; 3])> {
    boxes.reduce(|a, b| {
        (std::array::from_fn(|axis| a.0[axis].min(b.0[axis])), std::array::from_fn(|axis| a.1[axis].max(b.1[axis])))
    })
}

/// A patch of a pose.
#[derive(Clone, Copy, Debug)]
pub struct PatchView<'a> {
    /// Where it lies in its tile.
    pub patch: &'a Patch,
    data: &'a [f32],
}

impl PatchView<'_> {
    /// The control points, whose convex hull contains the patch.
    pub fn points(&self) -> impl ExactSizeIterator<Item = [f32; 3]> {
        let count = self.patch.point_count();
        (0..count).map(move |i| std::array::from_fn(|axis| self.data[axis] + self.data[ORIGIN + axis * count + i]))
    }

    /// Bounds of the control points.
    pub fn bounds(&self) -> ([f32; 3], [f32; 3]) {
        let count = self.patch.point_count();
        let span = |axis: usize| {
            let values = &self.data[ORIGIN + axis * count..ORIGIN + (axis + 1) * count];
            let fold = |pick: fn(f32, f32) -> f32| values.iter().copied().fold(values[0], pick);
            (self.data[axis] + fold(f32::min), self.data[axis] + fold(f32::max))
        };
        let spans = [span(0), span(1), span(2)];
        (spans.map(|span| span.0), spans.map(|span| span.1))
    }

    /// A cone that contains the normals of the patch.
    pub fn normals(&self) -> Cone {
        crate::cone::of_patch(self.patch.form, &self.data[ORIGIN..])
    }
}

impl Layout {
    fn new(table: Table, topology: TileTopology) -> Result<Self> {
        let records = table.patches();
        let mut order: Vec<(u32, u32, u32)> = records
            .iter()
            .enumerate()
            .map(|(index, record)| {
                let shift = KEY_DEPTH.saturating_sub(u32::from(record.depth));
                (record.tile, morton(u32::from(record.u) << shift, u32::from(record.v) << shift), index as u32)
            })
            .collect();
        order.sort_unstable();
        let tiles = table.tile_count();
        let mut patches = Vec::with_capacity(records.len());
        let mut leaves = Vec::with_capacity(records.len());
        let (mut tile_first, mut leaf_first) = (vec![0; tiles + 1], vec![0; tiles + 1]);
        let (mut pieces, mut first) = (Pieces::default(), 0_u32);
        for (tile, key, index) in order {
            leaves.push(Leaf { key, patch: patches.len() as u32 });
            patches.extend(patch::patches_of(&records[index as usize], index, &mut pieces, &mut first));
            tile_first[tile as usize + 1] = patches.len() as u32;
            leaf_first[tile as usize + 1] = leaves.len() as u32;
            if first > u32::MAX / 2 {
                return Err(Error::memory("the surface has too many patches").advise("lower the isolation"));
            }
        }
        // Tiles without patches start where the one before ended.
        for tile in 0..tiles {
            tile_first[tile + 1] = tile_first[tile + 1].max(tile_first[tile]);
            leaf_first[tile + 1] = leaf_first[tile + 1].max(leaf_first[tile]);
        }
        let mut stencil_first = Vec::with_capacity(table.stencil_sizes().len() + 1);
        let mut sum = 0;
        stencil_first.push(0);
        for size in table.stencil_sizes() {
            sum += *size as usize;
            stencil_first.push(sum);
        }
        let topology = Arc::new(topology);
        let data_len = first as usize;
        let poses = Mutex::default();
        Ok(Self { table, topology, patches, pieces, tile_first, leaves, leaf_first, stencil_first, data_len, poses })
    }

    /// Makes `all` all points of the table in f64: the cage's, then one per stencil.
    fn points(&self, context: &Context, cage: &[[f32; 3]], all: &mut Vec<[f64; 3]>) -> Result<()> {
        all.clear();
        all.resize(self.table.point_count(), [0.0; 3]);
        let (own, made) = all.split_at_mut(cage.len());
        for (own, cage) in own.iter_mut().zip(cage) {
            *own = cage.map(f64::from);
        }
        let own = &*own;
        let (indices, weights) = self.table.stencil_weights();
        context.for_each_part(made, CHUNK, |first, points| {
            for (i, point) in points.iter_mut().enumerate() {
                let stencil = first + i;
                let range = self.stencil_first[stencil]..self.stencil_first[stencil + 1];
                let mut sum = [0.0; 3];
                for (index, weight) in indices[range.clone()].iter().zip(&weights[range]) {
                    let source = own[*index as usize];
                    for axis in 0..3 {
                        sum[axis] += weight * source[axis];
                    }
                }
                *point = sum;
            }
            Ok(())
        })
    }
}

/// Patches one after another, and where their control data is written.
struct Posed<'a> {
    patches: &'a [Patch],
    data: &'a mut [f32],
}

impl Parts for Posed<'_> {
    fn len(&self) -> usize {
        self.patches.len()
    }

    fn split_at(self, at: usize) -> (Self, Self) {
        let (low, high) = self.patches.split_at(at.min(self.patches.len()));
        let cut = match (low.first(), high.first()) {
            (Some(from), Some(to)) => (to.first - from.first) as usize,
            (None, _) => 0,
            (_, None) => self.data.len(),
        };
        let (low_data, high_data) = self.data.split_at_mut(cut.min(self.data.len()));
        (Self { patches: low, data: low_data }, Self { patches: high, data: high_data })
    }
}

/// All points of a surface's table at the given cage points, for comparison with OpenSubdiv's own evaluators.
impl Surface {
    /// See [`relievo_opensubdiv::reference`].
    pub fn table_points(&self, context: &Context, cage: &[[f32; 3]]) -> Vec<[f64; 3]> {
        let mut all = Vec::new();
        // Working on parts of these lists has no errors.
        self.layout.points(context, cage, &mut all).map_or_else(|_| Vec::new(), |()| all)
    }
}
