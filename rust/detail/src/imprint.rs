//! The imprint of a collider on a displaced surface, stage by stage (Schäfer et al. 2014, Sections 5 and 6): overlap of
//! the boxes, culling, compaction, voxelisation, ray casting, ring update. Each stage is a public function of its own
//! and reports its time under `imprint.obb`, `imprint.cull`, `imprint.compact`, `imprint.voxelise`, `imprint.raycast`
//! and `imprint.ring`, and where rims are asked for `imprint.rim`.

pub mod collider;
pub mod contact;
pub mod cull;
pub mod culled;
pub mod dents;
pub mod motion;
pub mod pair;
pub mod raycast;
pub mod rim;
pub mod row;
pub mod settings;
pub(crate) mod smoothing;
mod surface_collider;
pub mod tool;
pub(crate) mod traces;

use glam::{DAffine3, DVec3};
use relievo_core::progress::Silent;
use relievo_core::{Context, Error, Progress, Result};
use relievo_gpu::Device;
use relievo_tiles::{Applied, Candidate, Change, Field, Sets};

use crate::channels::knots::block_edge;
use crate::device::{DeviceChain, DeviceMeshes, DeviceRow, TriangleChain};
use crate::geometry::grid::Grid;
use crate::geometry::obb::Obb;
use crate::geometry::overlap::{jittered, overlap};
use crate::geometry::voxel::Voxels;
use crate::imprint::collider::Collider;
use crate::imprint::culled::CulledTile;
use crate::imprint::dents::TileDents;
use crate::imprint::motion::Motion;
use crate::imprint::rim::Volumes;
use crate::imprint::row::Sweep;
use crate::imprint::settings::{ImprintSettings, Moment, Report};
use crate::object::DisplacedObject;

/// The voxel buffer that all imprints of a scene share.
#[derive(Debug, Default)]
pub struct Imprinter {
    pub(crate) voxels: Voxels,
    /// The meshes of colliders on a graphics device.
    pub(crate) meshes: Option<(Device, DeviceMeshes)>,
    /// What imprints on a graphics device share besides.
    pub(crate) chain: Option<DeviceChain>,
    /// The same of those on triangle meshes.
    pub(crate) triangles: Option<TriangleChain>,
}

/// What the rays of an imprint found.
#[derive(Clone, Debug, Default)]
pub(crate) struct Cast {
    /// What changes, in no particular order of the tiles.
    pub dents: Vec<TileDents>,
    /// Tiles and coefficients whose rays were cast, and rays that were held at the border of the grid.
    pub tiles: u64,
    pub tested: u64,
    pub clamped: u64,
    /// Triangles that were voxelised.
    pub triangles: u64,
    /// What tiles pushed and raised, ascending, where rims are raised already.
    pub volumes: Option<Vec<(u32, Volumes)>>,
}

impl Imprinter {
    /// An imprinter; its buffer is allocated by the first imprint.
    pub fn new() -> Self {
        Self::default()
    }

    /// The voxels of the last imprint.
    pub fn voxels(&self) -> &Voxels {
        &self.voxels
    }

    /// The depth limit that limits nothing, because half floats reach no further.
    pub(crate) const NO_LIMIT: f32 = 60000.0;

    /// Culls, voxelises and casts rays on the processor.
    pub(crate) fn cast_here(
        &mut self,
        context: &Context,
        object: &mut DisplacedObject,
        collider: &Collider,
        start: Option<&Field>,
        grid: &Grid,
        settings: &ImprintSettings,
    ) -> Result<Cast> {
        let stats = context.stats();
        let culled = {
            let mut stage = stats.begin("imprint.cull");
            let culled =
                if settings.culling != 0 { cull::cull(context, object, grid) } else { cull::everything(object) };
            stage.count("tiles", culled.len() as u64);
            stage.count("blocks", culled.iter().map(|tile| tile.blocks.len() as u64).sum());
            culled
        };
        let tiles = {
            let mut stage = stats.begin("imprint.compact");
            let tiles = if settings.compaction != 0 { compact(context, object, culled) } else { culled };
            stage.count("tiles", tiles.len() as u64);
            tiles
        };
        if tiles.is_empty() {
            culled::give_back(context, tiles);
            return Ok(Cast::default());
        }
        let triangles = {
            let mut stage = stats.begin("imprint.voxelise");
            let triangles = collider.voxelise(context, grid, &mut self.voxels)? as u64;
            stage.count("triangles", triangles);
            triangles
        };
        let mut stage = stats.begin("imprint.raycast");
        let dents = raycast::cast(context, object, start, &tiles, &self.voxels, settings);
        let sum = |count: fn(&TileDents) -> u32| dents.iter().map(|dents| u64::from(count(dents))).sum::<u64>();
        let tested = sum(|dents| dents.tested);
        stage.count("coefficients", tested);
        stage.count("changed", sum(|dents| dents.changed));
        let clamped = sum(|dents| dents.clamped);
        stage.end();
        let count = tiles.len() as u64;
        culled::give_back(context, tiles);
        Ok(Cast { dents, tiles: count, tested, clamped, triangles, volumes: None })
    }

    /// Raises rims around what rays found, and writes it. Where one is asked for and not raised yet, the voxels are those
    /// of the imprint.
    pub(crate) fn finish(
        &mut self,
        context: &Context,
        object: &mut DisplacedObject,
        cast: &mut Cast,
        settings: &ImprintSettings,
        report: &mut Report,
    ) -> Result<()> {
        let stats = context.stats();
        let Cast { dents, tiles, tested, clamped, triangles, volumes } = cast;
        report.triangles = *triangles;
        report.tested_tiles = *tiles;
        report.tested_coefficients = *tested;
        report.clamped = *clamped;
        if dents.is_empty() {
            return Ok(());
        }
        let mut volumes = volumes.take();
        if settings.rim > 0.0 && volumes.is_none() {
            let _stage = stats.begin("imprint.rim");
            dents.sort_unstable_by_key(|dents| dents.tile);
            volumes = Some(rim::raise(context, object, dents, &self.voxels, settings)?);
        }
        let mut stage = stats.begin("imprint.ring");
        write(context, object, dents, settings, report)?;
        // What the budget refused moved nothing.
        let volumes = volumes.into_iter().flatten().filter(|(tile, _)| report.changed.binary_search(tile).is_ok());
        report.volumes = volumes.map(|(_, volumes)| volumes).sum();
        stage.count("allocated", report.allocated);
        stage.count("refused", report.refused.len() as u64);
        stage.count("clamped", report.clamped);
        Ok(())
    }
}

/// The objects are [`DisplacedObject`] and [`TriangleObject`](crate::triangle::TriangleObject), and no others.
#[allow(private_bounds, private_interfaces)]
impl Imprinter {
    /// Presses `collider` into `object` where it stands, all stages in a row.
    ///
    /// # Errors
    /// Fails, and changes nothing, with `Invalid` if a setting is out of range, the active layer of the displacement
    /// cannot be seen, or traces have another size, of triangle meshes other segments, than the displacement; with `Unsupported` if the collider reaches
    /// too far beyond the overlap to be voxelised; and with `Memory` if the surface within the width of a rim exceeds
    /// the context's memory limit, or 2 GiB. Fails with the error of the page store if a tile cannot be read from its
    /// page or written to one; part of the imprint may be made then.
    pub fn imprint<O: Imprinted>(
        &mut self,
        context: &Context,
        object: &mut O,
        collider: &Collider,
        settings: &ImprintSettings,
        moment: Moment,
    ) -> Result<Report> {
        self.imprint_since(context, object, collider, settings, moment, None)
    }

    /// As [`Imprinter::imprint`], as one of the sub-steps of a motion whose depth limit counts from `start`, the
    /// displacement when it began, if there is one. For motions that [`Imprinter::sweep`] does not make, such as of the
    /// surface itself.
    ///
    /// # Errors
    /// Fails as [`Imprinter::imprint`].
    pub fn imprint_since<O: Imprinted>(
        &mut self,
        context: &Context,
        object: &mut O,
        collider: &Collider,
        settings: &ImprintSettings,
        moment: Moment,
        start: Option<&O::Field>,
    ) -> Result<Report> {
        settings.check()?;
        object.prepare(context)?;
        context.within(|| object.press(context, self, collider, (settings, moment), start))
    }

    /// Moves `collider` along `motion` and presses it into `object` at every sub-step, the end of the motion last.
    ///
    /// There are as many sub-steps as [`Motion::sub_steps`] wants, but no more than the settings allow; the depth limit
    /// counts over all of them. The first frame of a collider is a motion that stays where it is.
    ///
    /// # Errors
    /// Fails as [`Imprinter::imprint`], and with `Invalid` if the motion is of a deforming collider with another number
    /// of points; sub-steps before stay made.
    pub fn sweep<O: Imprinted>(
        &mut self,
        context: &Context,
        object: &mut O,
        collider: &mut Collider,
        motion: &Motion,
        settings: &ImprintSettings,
        moment: Moment,
    ) -> Result<Report> {
        self.sweep_watched(context, object, collider, motion, settings, moment, &mut Silent)
    }

    /// As [`Imprinter::sweep`], with the progress reported before every sub-step.
    ///
    /// # Errors
    /// Fails as [`Imprinter::sweep`], and with `Cancelled` if the progress asks to stop; the sub-steps until then stay
    /// made.
    #[allow(clippy::too_many_arguments)]
    pub fn sweep_watched<O: Imprinted>(
        &mut self,
        context: &Context,
        object: &mut O,
        collider: &mut Collider,
        motion: &Motion,
        settings: &ImprintSettings,
        moment: Moment,
        progress: &mut dyn Progress,
    ) -> Result<Report> {
        settings.check()?;
        let sweep = Sweep { into: 0, by: 0, motion, settings, moment };
        let reports = O::sweep(context, self, &mut [object], &mut [collider], &[sweep], progress)?;
        reports.into_iter().next().ok_or_else(|| Error::internal("a motion without a report"))
    }
}

/// An object that colliders are pressed into: [`DisplacedObject`] or [`TriangleObject`](crate::triangle::TriangleObject).
pub trait Imprintable {
    /// Its displacement, which limits of depth count from.
    type Field: Clone + Send + Sync;
}

impl Imprintable for DisplacedObject {
    type Field = Field;
}

/// A displaced surface that an imprinter presses colliders into.
pub(crate) trait Imprinted: Imprintable + Pressed {
    /// Prepares for a row of imprints. Fails where it cannot have any.
    fn prepare(&mut self, context: &Context) -> Result<()>;

    /// Presses a collider in where it is, whose depth limit counts from `start`, if there is one.
    fn press(
        &mut self,
        context: &Context,
        imprinter: &mut Imprinter,
        collider: &Collider,
        how: (&ImprintSettings, Moment),
        start: Option<&Self::Field>,
    ) -> Result<Report>;

    /// Moves colliders along their motions, of which one alone may have a depth limit, and presses them into `objects`. Rows are
    /// compiled here, once for each kind of object, and not in every crate that calls for one.
    fn sweep(
        context: &Context,
        imprinter: &mut Imprinter,
        objects: &mut [&mut Self],
        colliders: &mut [&mut Collider],
        sweeps: &[Sweep<'_>],
        progress: &mut dyn Progress,
    ) -> Result<Vec<Report>>;
}

impl Imprinted for DisplacedObject {
    fn prepare(&mut self, _: &Context) -> Result<()> {
        self.measure();
        self.layers.displacement.check_editable()
    }

    fn press(
        &mut self,
        context: &Context,
        imprinter: &mut Imprinter,
        collider: &Collider,
        (settings, moment): (&ImprintSettings, Moment),
        start: Option<&Field>,
    ) -> Result<Report> {
        let mut report = Report::before(self.displacement().bytes(), collider.open_edges() as u64);
        let grid = context.stats().time("imprint.obb", || overlap_grid(context, self, collider, settings, moment))?;
        let Some(grid) = grid else { return Ok(report) };
        report.voxel_diagonal = grid.diagonal();
        let there = imprinter.cast_on_device(context, self, collider, start, &grid, settings);
        let follows = there.is_some() && settings.smoothing <= 0.0;
        let mut cast = match there {
            Some(cast) => cast,
            None => imprinter.cast_here(context, self, collider, start, &grid, settings)?,
        };
        imprinter.finish(context, self, &mut cast, settings, &mut report)?;
        if follows {
            DisplacedObject::write_there(context, imprinter, &mut [self], &[(0, &report.changed)]);
        }
        raycast::give_back(context, cast.dents);
        Ok(report)
    }

    fn sweep(
        context: &Context,
        imprinter: &mut Imprinter,
        objects: &mut [&mut Self],
        colliders: &mut [&mut Collider],
        sweeps: &[Sweep<'_>],
        progress: &mut dyn Progress,
    ) -> Result<Vec<Report>> {
        imprinter.sweep_steps(context, objects, colliders, sweeps, progress)
    }
}

/// A displaced surface of any kind that colliders are pressed into.
pub(crate) trait Pressed: Send {
    /// From object space to the world.
    fn transform(&self) -> &DAffine3;

    /// How far it is displaced along its normals at most: inwards and outwards, object units.
    fn reach(&mut self) -> [f32; 2];

    /// The box around it with `margin` object units on all sides, in the world.
    fn obb(&self, margin: f64) -> Obb;

    /// The part of `obb`, along its axes, that holds all faces in it, displaced by `range` object units along their
    /// normals; `None` without such faces.
    fn occupied(&mut self, context: &Context, obb: &Obb, range: [f64; 2]) -> Option<Obb>;

    /// How much the normals of what lies in `obb`, displaced by `range`, run along each of its axes, 0 to 1.
    fn facing(&mut self, context: &Context, obb: &Obb, range: [f64; 2]) -> DVec3;
}

impl Pressed for DisplacedObject {
    fn transform(&self) -> &DAffine3 {
        DisplacedObject::transform(self)
    }

    fn reach(&mut self) -> [f32; 2] {
        DisplacedObject::reach(self)
    }

    fn obb(&self, margin: f64) -> Obb {
        DisplacedObject::obb(self, margin)
    }

    fn occupied(&mut self, context: &Context, obb: &Obb, [from, to]: [f64; 2]) -> Option<Obb> {
        DisplacedObject::occupied(self, context, obb, from, to)
    }

    fn facing(&mut self, context: &Context, obb: &Obb, _: [f64; 2]) -> DVec3 {
        DisplacedObject::facing(self, context, obb)
    }
}

/// The voxel grid of the pair's overlap, turned for this moment; `None` if the two do not meet.
///
/// The surface's box is enlarged by the largest displacement a tile may reach: inwards by the settings, outwards by
/// what there is. The overlap of the boxes is then cut down to what the collider fills of it and to the tiles that
/// reach into it. Fails if the collider is too large for its overlap.
pub fn overlap_grid(
    context: &Context,
    object: &mut DisplacedObject,
    collider: &Collider,
    settings: &ImprintSettings,
    moment: Moment,
) -> Result<Option<Grid>> {
    grid_over(context, object, collider, settings, moment)
}

/// As [`overlap_grid`], of any surface.
pub(crate) fn grid_over(
    context: &Context,
    object: &mut impl Pressed,
    collider: &Collider,
    settings: &ImprintSettings,
    moment: Moment,
) -> Result<Option<Grid>> {
    let [least, most] = object.reach();
    let least = f64::from(least).min(f64::from(-settings.max_displacement));
    let most = f64::from(rim::outwards(most, settings));
    let (range, margin) = ([least, most], most.max(-least));
    // What is solid behind a sheet is outside the sheet's own box.
    let scale = object.transform().matrix3;
    let stretch = scale.x_axis.length().max(scale.y_axis.length()).max(scale.z_axis.length());
    let Some(both) = overlap(&collider.solid_obb(margin * stretch), &object.obb(margin)) else { return Ok(None) };
    // What the collider leaves decides which tiles matter and the other way round; the first round gets most of it.
    let Some(part) = object.occupied(context, &both, range) else { return Ok(None) };
    let Some(part) = collider.occupied(context, &part)? else { return Ok(None) };
    let Some(both) = object.occupied(context, &part, range) else { return Ok(None) };
    let step = moment.frame.wrapping_shl(20).wrapping_add(u64::from(moment.step));
    let turned = jittered(&both, f64::from(settings.jitter), settings.seed, step, moment.pair);
    // Rays along the columns skip whole runs of bits.
    let facing = object.facing(context, &turned, range);
    Ok(Some(collider.grid(context, &turned, u64::from(settings.voxels), facing)))
}

/// The tiles that are left of the cull decisions, by the scan of [`Sets`].
pub fn compact(context: &Context, object: &DisplacedObject, mut culled: Vec<CulledTile>) -> Vec<CulledTile> {
    let decide = |tile: &CulledTile| if tile.blocks.is_empty() { Candidate::KEEP } else { Candidate::MODIFY };
    let mut candidates = context.scratch().list();
    candidates.extend(culled.iter().map(|tile| Candidate { tile: tile.tile, decision: decide(tile) }));
    let field = object.displacement().field();
    let sets = Sets::scan(context, &candidates, |tile| field.is_allocated(tile));
    let mut found = 0;
    culled.retain(|tile| {
        let wanted = sets.modify.get(found) == Some(&tile.tile);
        found += usize::from(wanted);
        wanted
    });
    sets.give_back(context);
    culled
}

/// Writes the dents into the tiles: allocates tiles that need it, notes traces if the object has them, smooths if
/// asked, and brings rings up to date.
pub fn write(
    context: &Context,
    object: &mut DisplacedObject,
    dents: &[TileDents],
    settings: &ImprintSettings,
    report: &mut Report,
) -> Result<()> {
    let scratch = context.scratch();
    let mut order = scratch.list::<usize>();
    order.extend((0..dents.len()).filter(|index| dents[*index].changed > 0));
    order.sort_unstable_by_key(|index| dents[*index].tile);
    if let Some(traces) = &object.traces {
        traces::check(object.displacement().field(), order.iter().map(|index| &dents[*index]), traces)?;
    }
    for index in order.iter() {
        object.widen([dents[*index].least.to_f32(), dents[*index].most.to_f32()]);
    }
    let displacement = object.layers.displacement.composite_mut();
    let (bytes, before) = (displacement.bytes(), displacement.allocated_count() as u64);
    let mut candidates = scratch.list();
    candidates.extend(order.iter().map(|index| Candidate { tile: dents[*index].tile, decision: Candidate::MODIFY }));
    let field = displacement.field();
    let sets = Sets::scan(context, &candidates, |tile| field.is_allocated(tile));
    let mut applied = scratch.lend::<Applied>();
    let done = displacement.apply_into(&sets, &mut applied);
    sets.give_back(context);
    done?;
    order.retain(|index| applied.refused.binary_search(&dents[*index].tile).is_err());
    let mut tiles = scratch.take_list::<u32>();
    tiles.extend(order.iter().map(|index| dents[*index].tile));
    let smoothed = (settings.smoothing > 0.0).then(|| smoothing::masks(context, displacement.field(), dents, &order));
    let mut refused = scratch.take_list();
    refused.extend_from_slice(&applied.refused);
    if let Some(traces) = &mut object.traces {
        refused.extend(traces::record(context, displacement.field(), (dents, &order), traces, object.layers.time)?);
    }
    let mut changes = displacement.edit(context, &tiles, |tile, texels| {
        let Ok(at) = tiles.binary_search(&tile) else { return };
        let size = texels.size();
        let edge = block_edge(size as u32) as usize;
        for block in &dents[order[at]].blocks {
            let place = block.index as usize;
            let (column, row) = (place % (size / edge) * edge, place / (size / edge) * edge);
            for (j, values) in block.values.chunks(edge).take(edge).enumerate() {
                texels.row_mut(row + j)[column..column + edge].copy_from_slice(values);
            }
        }
    })?;
    changes.extend_from_slice(&applied.changes);
    if settings.compaction == 0 {
        changes.extend(displacement.field().allocated().map(Change::all));
    }
    refused.extend(displacement.settle(context, &changes)?);
    scratch.keep_list(changes);
    if let Some(masks) = smoothed {
        let (strength, passes) = (settings.smoothing, settings.smoothing_passes);
        refused.extend(smoothing::smooth(context, displacement, &tiles, &masks, strength, passes)?);
    }
    refused.sort_unstable();
    refused.dedup();
    report.changed_coefficients = order.iter().map(|index| u64::from(dents[*index].changed)).sum();
    report.changed = tiles;
    report.refused = refused;
    report.bytes = displacement.bytes();
    if report.bytes != bytes {
        report.allocated = (displacement.allocated_count() as u64).saturating_sub(before);
    }
    Ok(())
}
