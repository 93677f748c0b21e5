//! Imprints of colliders on a graphics device: which are made there, several at a time, and what happens where it fails.
//!
//! Imprints that push, and what they raise as rims or smooth, are submitted together, since each can start from what those
//! before it left on the device. Their grids seldom depend on that: inwards all reach equally far, and what reaches
//! outwards stays; where a rim raises it by a step, later imprints are made again.

mod batches;
mod blocks;
pub(crate) mod chain;
pub(crate) mod cull;
mod ground;
pub(crate) mod job;
pub(crate) mod meshes;
mod rim;
mod rising;
mod shared;
mod slots;
pub(crate) mod smoothing;
mod stages;
mod submitted;
pub(crate) mod triangle_imprint;
pub(crate) mod triangle_press;
mod triangle_rim;
mod triangle_smoothing;
mod voxel;
mod work;

use relievo_core::{Context, Error, ErrorKind, Result};
use relievo_gpu::Device;
use relievo_tiles::Field;

use super::imprint::chain::DeviceChain;
use super::imprint::job::ImprintJob;
use super::imprint::meshes::DeviceMeshes;
use super::imprint::stages::Target;
use super::imprint::triangle_imprint::TriangleChain;
use super::paint::dabs::OnDevice;
use super::state::DeviceObject;
use crate::channels::knots::block_edge;
use crate::channels::layered::LayeredObject;
use crate::geometry::grid::Grid;
use crate::imprint::collider::Collider;
use crate::imprint::dents::TileDents;
use crate::imprint::rim::outwards;
use crate::imprint::settings::{ImprintSettings, Moment, Report};
use crate::imprint::{Cast, Imprinted, Imprinter, Pressed, grid_over};
use crate::object::DisplacedObject;

/// A surface into which a graphics device makes several imprints at a time.
pub(crate) trait DeviceRow: Imprinted + OnDevice {
    /// What the rays of an imprint found.
    type Cast;
    /// What a submission goes by besides that is known of one of its objects.
    type Known;

    /// Whether a device can make what the ring update changes between imprints.
    const RINGS: bool;

    fn field(&self) -> &Self::Field;

    /// Bytes of its blocks.
    fn bytes(&self) -> u64;

    /// Whether imprints of the given settings are for its device, together with others. Colliders that are too far from a
    /// grid are besides, see [`ImprintJob::new`].
    fn is_for_row(&self, settings: &ImprintSettings) -> bool;

    /// The device that a state is on.
    fn device_of(state: &Self::Device) -> &Device;

    /// Makes `jobs` on the device of some objects, of which the states are given.
    fn cast(
        context: &Context,
        imprinter: &mut Imprinter,
        device: &Device,
        objects: Vec<(&mut Self::Device, &Self)>,
        start: Option<&Self::Field>,
        colliders: &[&Collider],
        jobs: &[ImprintJob],
    ) -> Result<Vec<Self::Cast>>;

    /// What is known of it before a submission is written.
    fn known(&self) -> Self::Known;

    /// Writes what an imprint found. Returns whether later ones of the batch found what they would have by themselves.
    fn finish(
        &mut self,
        context: &Context,
        imprinter: &mut Imprinter,
        cast: Self::Cast,
        known: &mut Self::Known,
        place: Standing<'_>,
        report: &mut Report,
    ) -> Result<bool>;

    /// Has the device write what the imprints of the last submission changed, of each of which `made` tells the object and
    /// what changed of it, ascending. An object for which that fails loses its device, and tells.
    fn write_there(context: &Context, imprinter: &mut Imprinter, objects: &mut [&mut Self], made: &[(usize, &[u32])]);
}

/// Where an imprint stands in its submission.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Standing<'a> {
    pub settings: &'a ImprintSettings,
    /// Whether the device makes what smoothing and the ring update change on its object.
    pub works: bool,
    /// Whether none on the same object follows.
    pub is_last: bool,
}

/// Whether imprints of the given settings on `object` are for its device: those of tiles that are culled. Colliders that
/// are too far from a grid are besides, see [`ImprintJob::new`].
pub(crate) fn is_for_device(object: &DisplacedObject, settings: &ImprintSettings) -> bool {
    object.device.is_some() && settings.culling != 0 && settings.share > 0.0
}

/// An imprint whose grid is known.
#[derive(Debug)]
struct Ready {
    target: usize,
    settings: ImprintSettings,
    /// `None` where the two do not meet.
    grid: Option<Grid>,
    /// Open edges of the collider.
    open_edges: u64,
    /// How far outwards the boxes reach that it was found by.
    most: f32,
}

/// Imprints that are to be submitted together.
#[derive(Debug, Default)]
pub(crate) struct Batch {
    all: Vec<Ready>,
    jobs: Vec<ImprintJob>,
    worked: bool,
}

impl Batch {
    /// Of no imprint so far; if it is `worked`, the ring update is made on the device between those on the same object.
    pub fn new(worked: bool) -> Self {
        Self { worked, ..Self::default() }
    }

    /// Adds the imprint of a collider, where it is, on one of the objects; `false`, and nothing is added, if it is not
    /// for the device.
    pub fn add(
        &mut self,
        context: &Context,
        target: usize,
        object: &mut impl Pressed,
        collider: &Collider,
        settings: &ImprintSettings,
        moment: Moment,
    ) -> Result<bool> {
        let grid = context.stats().time("imprint.obb", || grid_over(context, object, collider, settings, moment))?;
        if let Some(grid) = &grid {
            let Some(job) = ImprintJob::new(context, target, collider, grid, &settings.limits()) else {
                return Ok(false);
            };
            self.jobs.push(job.smoothed(settings).raising(settings).worked(self.worked));
        }
        let most = outwards(object.reach()[1], settings);
        let open_edges = collider.open_edges() as u64;
        self.all.push(Ready { target, settings: *settings, grid, open_edges, most });
        Ok(true)
    }

    /// Where imprint `index` stands.
    fn standing(&self, index: usize) -> Standing<'_> {
        let Ready { target, settings, .. } = &self.all[index];
        let there = |ready: &&Ready| ready.target == *target && ready.grid.is_some();
        let mut own = self.all.iter().filter(there);
        let works = self.worked && own.clone().count() > 1 || own.any(|ready| ready.settings.smoothing > 0.0);
        Standing { settings, works, is_last: !self.all[index + 1..].iter().any(|ready| there(&ready)) }
    }
}

impl Imprinter {
    /// Submits imprints together and adds the reports of the imprints that stay: none where the device does not make
    /// them. Returns whether more would have, had the ring update been made on the device between them.
    pub(crate) fn submit<O: DeviceRow>(
        &mut self,
        context: &Context,
        objects: &mut [&mut O],
        start: Option<&O::Field>,
        colliders: &[&Collider],
        batch: &Batch,
        reports: &mut Vec<Report>,
    ) -> Result<bool> {
        let casts = self.cast_together(context, objects, start, colliders, &batch.jobs);
        let Some(casts) = casts else { return Ok(false) };
        let first = reports.len();
        let uneven = self.take_up(context, objects, batch, casts, reports)?;
        let made = batch.all.iter().enumerate().zip(&reports[first..]).filter(|((_, ready), _)| ready.grid.is_some());
        // What is smoothed, or made by rings in between, is not what the device keeps.
        let made: Vec<(usize, &[u32])> = made
            .map(|((index, ready), report)| {
                (ready.target, if batch.standing(index).works { &[][..] } else { &report.changed })
            })
            .collect();
        O::write_there(context, self, objects, &made);
        Ok(uneven)
    }

    /// Makes `jobs` on the device of `objects`, those with one that is the first one's; `None` where it fails, which an
    /// object then tells.
    pub(crate) fn cast_together<O: DeviceRow>(
        &mut self,
        context: &Context,
        objects: &mut [&mut O],
        start: Option<&O::Field>,
        colliders: &[&Collider],
        jobs: &[ImprintJob],
    ) -> Option<Vec<O::Cast>> {
        if jobs.is_empty() {
            return Some(Vec::new());
        }
        let _stage = context.stats().begin("imprint.device");
        // Objects that none meets are left alone.
        let mut met: Vec<usize> = jobs.iter().map(|job| job.target).collect();
        met.sort_unstable();
        met.dedup();
        let jobs = jobs.iter().map(|job| job.of_target(met.partition_point(|index| *index < job.target)));
        let jobs: Vec<ImprintJob> = jobs.collect();
        let mut states: Vec<_> = met.iter().map(|index| objects[*index].device_slot().take()).collect();
        let device = states.iter().flatten().next().map(|state| O::device_of(state).clone())?;
        let there = &*objects;
        let each = states.iter_mut().zip(&met).map(|(state, index)| {
            let state = state.as_mut().filter(|state| O::device_of(state).is_same(&device));
            Ok((state.ok_or_else(|| Error::unsupported("objects on several devices at once"))?, &*there[*index]))
        });
        let made = each.collect::<Result<Vec<_>>>();
        let made = made.and_then(|each| O::cast(context, self, &device, each, start, colliders, &jobs));
        // What has no room there, or is too far, is for the processor; the device goes on with the rest.
        let lost = match &made {
            Ok(_) => false,
            Err(fault) => !matches!(fault.kind, ErrorKind::Unsupported | ErrorKind::Memory) || device.check().is_err(),
        };
        for (index, state) in met.iter().zip(states) {
            *objects[*index].device_slot() = state.filter(|state| !lost || !O::device_of(state).is_same(&device));
        }
        match made {
            Ok(casts) => Some(casts),
            // Several are tried one by one before an error is reported.
            Err(_) if !lost && jobs.len() > 1 => None,
            Err(fault) => {
                objects[met[0]].fault_slot().get_or_insert(fault);
                None
            }
        }
    }

    /// Writes what imprints that were made together found, up to one after which others would have found something else,
    /// or after which the boxes of others reach further. Returns whether it was what the ring update changed.
    fn take_up<O: DeviceRow>(
        &mut self,
        context: &Context,
        objects: &mut [&mut O],
        batch: &Batch,
        casts: Vec<O::Cast>,
        reports: &mut Vec<Report>,
    ) -> Result<bool> {
        let mut known: Vec<O::Known> = objects.iter().map(|object| object.known()).collect();
        let mut casts = casts.into_iter();
        for (index, ready) in batch.all.iter().enumerate() {
            let object = &mut *objects[ready.target];
            if outwards(object.reach()[1], &ready.settings) != ready.most {
                return Ok(false);
            }
            let mut report = Report::before(object.bytes(), ready.open_edges);
            let mut stays = true;
            if let Some(grid) = &ready.grid {
                let cast = casts.next().ok_or_else(|| Error::internal("an imprint was not made"))?;
                report.voxel_diagonal = grid.diagonal();
                let (known, standing) = (&mut known[ready.target], batch.standing(index));
                stays = object.finish(context, self, cast, known, standing, &mut report)?;
            }
            let whole = report.refused.is_empty();
            reports.push(report);
            if !(stays && whole) {
                return Ok(O::RINGS && whole);
            }
        }
        Ok(false)
    }

    /// Culls, voxelises and casts rays on the object's device; `None` if the processor is to do it.
    pub(crate) fn cast_on_device(
        &mut self,
        context: &Context,
        object: &mut DisplacedObject,
        collider: &Collider,
        start: Option<&Field>,
        grid: &Grid,
        settings: &ImprintSettings,
    ) -> Option<Cast> {
        if !is_for_device(object, settings) {
            return None;
        }
        let job = ImprintJob::new(context, 0, collider, grid, &settings.limits())?.raising(settings);
        self.cast_together(context, &mut [object], start, &[collider], &[job])?.pop()
    }

    /// What imprints share on a device, and the meshes of colliders there.
    fn chain_on(&mut self, device: &Device) -> Result<(&mut DeviceChain, &mut DeviceMeshes)> {
        let (meshes, chain, _) = self.turn_to(device)?;
        if chain.is_none() {
            *chain = Some(DeviceChain::new(device)?);
        }
        let chain = chain.as_mut().ok_or_else(|| Error::internal("no room for imprints on a device"))?;
        Ok((chain, meshes))
    }

    /// The meshes of colliders on a device, and what imprints on tiles and on triangles have there besides, if anything. What
    /// is on another one is given back.
    #[allow(clippy::type_complexity)]
    pub(crate) fn turn_to(
        &mut self,
        device: &Device,
    ) -> Result<(&mut DeviceMeshes, &mut Option<DeviceChain>, &mut Option<TriangleChain>)> {
        let meshes = match self.meshes.take().filter(|(on, _)| on.is_same(device)) {
            Some(known) => self.meshes.insert(known),
            None => {
                (self.chain, self.triangles) = (None, None);
                self.meshes.insert((device.clone(), DeviceMeshes::new(device)?))
            }
        };
        Ok((&mut meshes.1, &mut self.chain, &mut self.triangles))
    }
}

impl DeviceRow for DisplacedObject {
    type Cast = Cast;
    type Known = ();

    const RINGS: bool = true;

    fn field(&self) -> &Field {
        self.displacement().field()
    }

    fn bytes(&self) -> u64 {
        self.displacement().bytes()
    }

    fn is_for_row(&self, settings: &ImprintSettings) -> bool {
        is_for_device(self, settings)
    }

    fn device_of(state: &DeviceObject) -> &Device {
        state.device()
    }

    fn cast(
        context: &Context,
        imprinter: &mut Imprinter,
        device: &Device,
        objects: Vec<(&mut DeviceObject, &Self)>,
        start: Option<&Field>,
        colliders: &[&Collider],
        jobs: &[ImprintJob],
    ) -> Result<Vec<Cast>> {
        let mut targets: Vec<_> = objects.into_iter().map(|(state, object)| Target { state, object, start }).collect();
        let (chain, meshes) = imprinter.chain_on(device)?;
        chain.run(context, meshes, &mut targets, colliders, jobs)
    }

    fn known(&self) {}

    /// Others would have found something else after one of which the budget refused tiles, or whose coefficients the ring
    /// update changed, as it does where those of several tiles meet at an extraordinary vertex. Of objects that are worked
    /// on the device makes what the ring update does too.
    fn finish(
        &mut self,
        context: &Context,
        imprinter: &mut Imprinter,
        mut cast: Cast,
        _: &mut (),
        Standing { settings, works, is_last }: Standing<'_>,
        report: &mut Report,
    ) -> Result<bool> {
        imprinter.finish(context, self, &mut cast, settings, report)?;
        let field = self.displacement().field();
        Ok(works || is_last || cast.dents.iter().all(|dents| is_written(field, dents)))
    }

    fn write_there(context: &Context, imprinter: &mut Imprinter, objects: &mut [&mut Self], made: &[(usize, &[u32])]) {
        let Some(chain) = &imprinter.chain else { return };
        let _stage = context.stats().begin("imprint.device.follow");
        for (index, object) in objects.iter_mut().enumerate() {
            if !made.iter().any(|(target, tiles)| *target == index && !tiles.is_empty()) {
                continue;
            }
            let Some(mut state) = object.device.take() else { continue };
            let stays = |job: usize, tile: u32| {
                made.get(job).is_some_and(|(target, tiles)| *target == index && tiles.binary_search(&tile).is_ok())
            };
            match chain.write(&mut state, object.displacement().field(), stays) {
                Ok(()) => object.device = Some(state),
                Err(fault) => object.lose_device(fault),
            }
        }
    }
}

/// Whether a field has the coefficients of blocks.
fn is_written(field: &Field, dents: &TileDents) -> bool {
    let (size, edge) = (field.size(dents.tile) as usize, block_edge(field.size(dents.tile)) as usize);
    let Some(texels) = field.block(dents.tile) else { return false };
    dents.blocks.iter().all(|block| {
        let place = block.index as usize;
        let (column, row) = (place % (size / edge) * edge, place / (size / edge) * edge);
        let mut rows = block.values.chunks(edge).take(edge).enumerate();
        rows.all(|(j, values)| {
            let first = (row + j + 1) * (size + 2) + column + 1;
            texels[first..first + edge] == *values
        })
    })
}
