//! Imprints of colliders on a graphics device: which are made there, several at a time, and what happens where it fails.
//!
//! Imprints that only push are submitted together, since each can start from what those before it left on the device, and
//! their grids do not depend on that: what reaches outwards stays, and inwards all reach equally far. Where rims rise or
//! what changed is smoothed, which the processor does, they are submitted one by one.

use relievo_core::{Context, Error, ErrorKind, Result};
use relievo_tiles::Field;

use super::chain::{DeviceChain, Target};
use super::link::Link;
use crate::collider::Collider;
use crate::grid::Grid;
use crate::imprint::{Cast, ImprintSettings, Imprinter, Moment, Report, overlap_grid};
use crate::knots::block_edge;
use crate::object::DisplacedObject;
use crate::raycast::TileDents;

/// Whether imprints of the given settings on `object` are for its device: displacement along normals, of tiles that are
/// culled. Colliders that are too far from a grid are besides, see [`Link::new`].
fn is_for_device(object: &DisplacedObject, settings: &ImprintSettings) -> bool {
    object.device.is_some() && object.vectors.is_none() && settings.culling != 0 && settings.share > 0.0
}

/// Whether imprints of the given settings can be submitted with others: what rises or is smoothed is the processor's.
pub(crate) fn is_for_batch(object: &DisplacedObject, settings: &ImprintSettings) -> bool {
    is_for_device(object, settings) && settings.rim <= 0.0 && settings.smoothing <= 0.0
}

/// An imprint whose grid is known.
#[derive(Debug)]
struct Ready {
    target: usize,
    settings: ImprintSettings,
    /// `None` where the two do not meet.
    grid: Option<Grid>,
}

/// Imprints that are to be submitted together.
#[derive(Debug, Default)]
pub(crate) struct Batch {
    all: Vec<Ready>,
    links: Vec<Link>,
}

impl Batch {
    /// Adds the imprint of a collider, where it is, on one of the objects; `false`, and nothing is added, if it is not
    /// for the device.
    pub fn add(
        &mut self,
        context: &Context,
        target: usize,
        object: &mut DisplacedObject,
        collider: &Collider,
        settings: &ImprintSettings,
        moment: Moment,
    ) -> Result<bool> {
        let grid = context.stats().time("imprint.obb", || overlap_grid(context, object, collider, settings, moment))?;
        if let Some(grid) = &grid {
            let Some(link) = Link::new(context, target, collider, grid, &settings.limits()) else { return Ok(false) };
            self.links.push(link);
        }
        self.all.push(Ready { target, settings: *settings, grid });
        Ok(true)
    }
}

impl Imprinter {
    /// Submits imprints together and adds the reports of those that stay: none where the device does not make them.
    pub(crate) fn submit(
        &mut self,
        context: &Context,
        objects: &mut [&mut DisplacedObject],
        start: Option<&Field>,
        colliders: &[&Collider],
        batch: Batch,
        reports: &mut Vec<Report>,
    ) -> Result<()> {
        match self.cast_together(context, objects, start, colliders, &batch.links) {
            Some(casts) => self.take_up(context, objects, &batch.all, casts, reports),
            None => Ok(()),
        }
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
        let link = Link::new(context, 0, collider, grid, &settings.limits())?;
        self.cast_together(context, &mut [object], start, &[collider], &[link])?.pop()
    }

    /// Makes `links` on the device of `objects`, those with one that is the first one's; `None` where it fails, which an
    /// object then tells.
    fn cast_together(
        &mut self,
        context: &Context,
        objects: &mut [&mut DisplacedObject],
        start: Option<&Field>,
        colliders: &[&Collider],
        links: &[Link],
    ) -> Option<Vec<Cast>> {
        if links.is_empty() {
            return Some(Vec::new());
        }
        let _stage = context.stats().begin("imprint.device");
        let mut states: Vec<_> = objects.iter_mut().map(|object| object.device.take()).collect();
        let device = states.iter().flatten().next().map(|state| state.device().clone())?;
        let made = self.chain_on(&device).and_then(|chain| {
            let each = states.iter_mut().zip(&*objects).map(|(state, object)| {
                let state = state.as_mut().filter(|state| state.device().is_same(&device));
                let state = state.ok_or_else(|| Error::unsupported("objects on several devices at once"))?;
                Ok(Target { state, object: &**object, start })
            });
            let mut targets = each.collect::<Result<Vec<_>>>()?;
            chain.run(context, &mut targets, colliders, links)
        });
        // What has no room there, or is too far, is for the processor; the device goes on with the rest.
        let lost = match &made {
            Ok(_) => false,
            Err(fault) => !matches!(fault.kind, ErrorKind::Unsupported | ErrorKind::Memory) || device.check().is_err(),
        };
        for (object, state) in objects.iter_mut().zip(states) {
            object.device = state.filter(|state| !lost || !state.device().is_same(&device));
        }
        match made {
            Ok(casts) => Some(casts),
            // Several are tried one by one before anything is told.
            Err(_) if !lost && links.len() > 1 => None,
            Err(fault) => {
                objects[0].device_fault.get_or_insert(fault);
                None
            }
        }
    }

    /// Writes what imprints that were made together found, up to one after which others would have found something else:
    /// one of which the budget refused tiles, or whose coefficients the ring update changed, as it does where those of
    /// several tiles meet at an extraordinary vertex.
    fn take_up(
        &mut self,
        context: &Context,
        objects: &mut [&mut DisplacedObject],
        all: &[Ready],
        casts: Vec<Cast>,
        reports: &mut Vec<Report>,
    ) -> Result<()> {
        let mut casts = casts.into_iter();
        for ready in all {
            let object = &mut *objects[ready.target];
            let mut report = Report { bytes: object.displacement().bytes(), sub_steps: 1, ..Report::default() };
            let mut stays = true;
            if let Some(grid) = &ready.grid {
                let mut cast = casts.next().ok_or_else(|| Error::internal("an imprint was not made"))?;
                report.voxel_diagonal = grid.diagonal();
                self.finish(context, object, &mut cast, &ready.settings, &mut report)?;
                let field = object.displacement().field();
                stays = report.refused.is_empty() && cast.dents.iter().all(|dents| is_written(field, dents));
            }
            reports.push(report);
            if !stays {
                break;
            }
        }
        Ok(())
    }

    /// What imprints share on a device.
    fn chain_on(&mut self, device: &relievo_gpu::Device) -> Result<&mut DeviceChain> {
        if !self.chain.as_ref().is_some_and(|chain| chain.is_on(device)) {
            self.chain = Some(DeviceChain::new(device)?);
        }
        self.chain.as_mut().ok_or_else(|| Error::internal("no room for imprints on a device"))
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
