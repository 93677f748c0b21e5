//! Imprints of colliders on a graphics device: which are made there, several at a time, and what happens where it fails.
//!
//! Imprints that push, and what they raise as rims or smooth, are submitted together, since each can start from what those
//! before it left on the device. Their grids seldom depend on that: inwards all reach equally far, and what reaches
//! outwards stays; where a rim raises it by a step, those that follow are made again.

use relievo_core::{Context, Error, ErrorKind, Result};
use relievo_tiles::Field;

use super::chain::{DeviceChain, Target};
use super::link::Link;
use crate::collider::Collider;
use crate::grid::Grid;
use crate::imprint::{Cast, ImprintSettings, Imprinter, Moment, Report, overlap_grid};
use crate::knots::block_edge;
use crate::layered::LayeredObject;
use crate::object::DisplacedObject;
use crate::raycast::TileDents;
use crate::rim::outwards;

/// Whether imprints of the given settings on `object` are for its device: those of tiles that are culled. Colliders that
/// are too far from a grid are besides, see [`Link::new`].
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
    /// How far outwards the boxes reach that it was found by.
    most: f32,
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
            self.links.push(link.smoothed(settings).raising(settings));
        }
        let most = outwards(object.reach()[1], settings);
        self.all.push(Ready { target, settings: *settings, grid, most });
        Ok(true)
    }

    /// Whether something is smoothed on one of the objects.
    fn smooths(&self, target: usize) -> bool {
        let smooths = |ready: &Ready| ready.grid.is_some() && ready.settings.smoothing > 0.0;
        self.all.iter().any(|ready| ready.target == target && smooths(ready))
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
            Some(casts) => {
                let first = reports.len();
                self.take_up(context, objects, &batch, casts, reports)?;
                let made = batch.all.iter().zip(&reports[first..]).filter(|(ready, _)| ready.grid.is_some());
                // What is smoothed is not what the device keeps.
                let made: Vec<(usize, &[u32])> = made
                    .map(|(ready, report)| {
                        let tiles = if batch.smooths(ready.target) { &[][..] } else { &report.changed };
                        (ready.target, tiles)
                    })
                    .collect();
                self.follow(context, objects, &made);
                Ok(())
            }
            None => Ok(()),
        }
    }

    /// Has the device write what the imprints of the last submission changed, of each of which `made` tells the object and
    /// the tiles, ascending. An object for which that fails loses its device, and tells.
    pub(crate) fn follow(&mut self, context: &Context, objects: &mut [&mut DisplacedObject], made: &[(usize, &[u32])]) {
        let Some(chain) = &self.chain else { return };
        let _stage = context.stats().begin("imprint.device.follow");
        for (index, object) in objects.iter_mut().enumerate() {
            if !made.iter().any(|(target, tiles)| *target == index && !tiles.is_empty()) {
                continue;
            }
            let Some(mut state) = object.device.take() else { continue };
            let stays = |link: usize, tile: u32| {
                made.get(link).is_some_and(|(target, tiles)| *target == index && tiles.binary_search(&tile).is_ok())
            };
            match chain.write(&mut state, object.displacement().field(), stays) {
                Ok(()) => object.device = Some(state),
                Err(fault) => object.lose_device(fault),
            }
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
        let link = Link::new(context, 0, collider, grid, &settings.limits())?.raising(settings);
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
    /// one of which the budget refused tiles, whose coefficients the ring update changed, as it does where those of several
    /// tiles meet at an extraordinary vertex, or after which the boxes of others reach further. Of objects on which something
    /// is smoothed the device makes what the ring update does too.
    fn take_up(
        &mut self,
        context: &Context,
        objects: &mut [&mut DisplacedObject],
        batch: &Batch,
        casts: Vec<Cast>,
        reports: &mut Vec<Report>,
    ) -> Result<()> {
        let mut casts = casts.into_iter();
        for ready in &batch.all {
            let object = &mut *objects[ready.target];
            if outwards(object.reach()[1], &ready.settings) != ready.most {
                break;
            }
            let mut report = Report { bytes: object.displacement().bytes(), sub_steps: 1, ..Report::default() };
            let mut stays = true;
            if let Some(grid) = &ready.grid {
                let mut cast = casts.next().ok_or_else(|| Error::internal("an imprint was not made"))?;
                report.voxel_diagonal = grid.diagonal();
                self.finish(context, object, &mut cast, &ready.settings, &mut report)?;
                let field = object.displacement().field();
                let written = || cast.dents.iter().all(|dents| is_written(field, dents));
                stays = report.refused.is_empty() && (batch.smooths(ready.target) || written());
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::device::cull::tests::object;
    use crate::raycast::key;
    use crate::row::Press;
    use crate::shapes;
    use glam::{DAffine3, DVec3};
    use relievo_testing::device;

    #[test]
    fn tiles_on_the_device_are_what_imprints_made_of_them() {
        let Some(device) = device() else { return };
        let context = Context::serial();
        let (points, triangles) = shapes::sphere(0.8, 32, 16, 0.0);
        let mut imprinter = Imprinter::new();
        let mut objects = [object(&context), object(&context)];
        let settings = ImprintSettings { voxels: 1 << 16, ..ImprintSettings::default() };
        let at = |object: &DisplacedObject, pair: u32| {
            let place = DVec3::new(2.1 + 0.5 * f64::from(pair), 2.6 + 0.4 * f64::from(pair), 0.4);
            let transform = DAffine3::from_translation(object.transform().transform_point3(place));
            Collider::new(&context, points.clone(), triangles.clone(), transform).unwrap()
        };
        let colliders: Vec<Collider> = (0..6).map(|pair| at(&objects[0], pair)).collect();
        for object in &mut objects {
            object.use_device(Some(&device)).unwrap();
        }
        let presses: Vec<Press<'_>> = colliders
            .iter()
            .zip(0..)
            .map(|(collider, pair)| {
                let moment = Moment { pair, ..Moment::default() };
                Press { into: pair as usize % 2, collider, settings: &settings, moment }
            })
            .collect();
        // Together, and one by one.
        imprinter.imprint_all(&context, &mut objects.each_mut(), &presses[..4]).unwrap();
        for press in &presses[4..] {
            imprinter.imprint(&context, &mut objects[press.into], press.collider, &settings, press.moment).unwrap();
        }
        let (mut texels, mut apart) = (0, 0);
        for object in &mut objects {
            assert!(object.take_device_fault().is_none());
            let (state, field) = (object.device.as_ref().unwrap(), object.displacement().field());
            // Nothing is left to be sent.
            assert!(field.differing(state.tiles.field()).is_empty());
            for (tile, there) in state.tiles.read_back(&device).unwrap() {
                for (a, b) in field.block(tile).unwrap().iter().zip(there) {
                    texels += 1;
                    apart += u32::from(*a != b);
                    // Means at vertices may be rounded the other way.
                    assert!(key(*a).abs_diff(key(b)) <= 1, "tile {tile}: {a} {b}");
                }
            }
        }
        assert!(texels > 50_000 && apart * 1000 < texels, "{apart} of {texels}");
    }
}
