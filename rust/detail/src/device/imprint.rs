//! Imprints of colliders on a graphics device: which are made there, several at a time, and what happens where it fails.
//!
//! Imprints that only push are submitted together, since each can start from what those before it left on the device, and
//! their grids do not depend on that: what reaches outwards stays, and inwards all reach equally far. Where rims rise or
//! what changed is smoothed, which the processor does, they are submitted one by one.

use relievo_core::{Context, Error, ErrorKind, Progress, Result};
use relievo_tiles::Field;

use super::blocks::MOST_LINKS;
use super::chain::{DeviceChain, Link, Target};
use crate::collider::Collider;
use crate::grid::Grid;
use crate::imprint::{Cast, ImprintSettings, Imprinter, Moment, Report, overlap_grid};
use crate::knots::block_edge;
use crate::motion::Motion;
use crate::object::DisplacedObject;
use crate::raycast::TileDents;

/// One of several imprints that are made in a row.
#[derive(Clone, Copy, Debug)]
pub struct Press<'a> {
    /// Which of the objects is pressed into.
    pub into: usize,
    /// The collider, where it is.
    pub collider: &'a Collider,
    /// How.
    pub settings: &'a ImprintSettings,
    /// When.
    pub moment: Moment,
}

/// Sub-steps of a motion that are submitted together.
const TOGETHER: u32 = 8;

/// Whether imprints of the given settings on `object` are for its device: displacement along normals, of tiles that are
/// culled. Colliders that are too far from a grid are besides, see [`Link::is_near`].
fn is_for_device(object: &DisplacedObject, settings: &ImprintSettings) -> bool {
    object.device.is_some() && object.vectors.is_none() && settings.culling != 0 && settings.share > 0.0
}

/// Whether several such imprints can be submitted together.
fn only_pushes(settings: &ImprintSettings) -> bool {
    settings.rim <= 0.0 && settings.smoothing <= 0.0
}

/// An imprint whose grid is known.
struct Ready {
    target: usize,
    settings: ImprintSettings,
    /// `None` where the two do not meet.
    grid: Option<Grid>,
}

impl Imprinter {
    /// Presses colliders into `objects` where they stand, each after those before it. On a graphics device they are one
    /// submission, unless rims or smoothing are asked for, or objects are on several devices.
    ///
    /// Fails as [`Imprinter::imprint`] does, and where an object does not exist; those before stay made.
    pub fn imprint_all(
        &mut self,
        context: &Context,
        objects: &mut [&mut DisplacedObject],
        presses: &[Press<'_>],
    ) -> Result<Vec<Report>> {
        for (index, press) in presses.iter().enumerate() {
            press.settings.check()?;
            if press.into >= objects.len() {
                return Err(Error::invalid("the object does not exist").at(format!("imprint {index}")));
            }
        }
        context.within(|| {
            let mut reports = Vec::with_capacity(presses.len());
            while let Some((press, more)) = presses[reports.len()..].split_first() {
                let done = reports.len();
                let rest = &presses[done..presses.len().min(done + MOST_LINKS)];
                let together = |press: &Press<'_>| {
                    is_for_device(objects[press.into], press.settings) && only_pushes(press.settings)
                };
                if !more.is_empty() && rest.iter().all(together) {
                    self.press_rest(context, objects, rest, &mut reports)?;
                }
                // What cannot be made together is made one by one.
                if reports.len() == done {
                    let object = &mut *objects[press.into];
                    reports.push(self.step(context, object, press.collider, press.settings, press.moment, None)?);
                }
            }
            Ok(reports)
        })
    }

    /// Submits imprints together and adds the reports of those that stay.
    fn press_rest(
        &mut self,
        context: &Context,
        objects: &mut [&mut DisplacedObject],
        presses: &[Press<'_>],
        reports: &mut Vec<Report>,
    ) -> Result<()> {
        let (mut all, mut links) = (Vec::with_capacity(presses.len()), Vec::with_capacity(presses.len()));
        for press in presses {
            let (object, settings) = (&mut *objects[press.into], press.settings);
            let ready = ready(context, press.into, object, press.collider, settings, press.moment)?;
            links.extend(ready.link(context, press.collider));
            all.push(ready);
        }
        let colliders: Vec<&Collider> = presses.iter().map(|press| press.collider).collect();
        match self.cast_together(context, objects, None, &colliders, &links) {
            Some(casts) => self.take_up(context, objects, &all, casts, reports),
            None => Ok(()),
        }
    }

    /// Makes the sub-steps of [`Imprinter::sweep_watched`] on the object's device, `count` in all, several at a time.
    /// Returns how many were made and adds what they did to the report; the rest is to be made one by one.
    #[allow(clippy::too_many_arguments)]
    pub(crate) fn sweep_on_device(
        &mut self,
        context: &Context,
        object: &mut DisplacedObject,
        collider: &mut Collider,
        (motion, count): (&Motion, u32),
        settings: &ImprintSettings,
        moment: Moment,
        start: Option<&Field>,
        progress: &mut dyn Progress,
        report: &mut Report,
    ) -> Result<u32> {
        let mut made = 0;
        while count - made > 1 && motion.is_rigid() && is_for_device(object, settings) && only_pushes(settings) {
            let (mut until, mut stopped) = (made, Ok(()));
            while until < count.min(made + TOGETHER) && stopped.is_ok() {
                stopped = progress.step(until as f32 / count as f32, "imprint");
                until += u32::from(stopped.is_ok());
            }
            let reports = context.within(|| {
                let (mut all, mut links, mut reports) = (Vec::new(), Vec::new(), Vec::new());
                for step in made..until {
                    collider.set_pose(context, &motion.at(f64::from(step + 1) / f64::from(count)))?;
                    let moment = Moment { step: moment.step + step, ..moment };
                    let ready = ready(context, 0, object, collider, settings, moment)?;
                    links.extend(ready.link(context, collider));
                    all.push(ready);
                }
                if let Some(casts) = self.cast_together(context, &mut [&mut *object], start, &[collider], &links) {
                    self.take_up(context, &mut [&mut *object], &all, casts, &mut reports)?;
                }
                Ok::<_, Error>(reports)
            })?;
            let done = reports.len() as u32;
            reports.into_iter().for_each(|it| report.merge(it));
            made += done;
            stopped?;
            if done == 0 {
                break;
            }
        }
        Ok(made)
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
        let link = Link::new(context, 0, collider, grid, &settings.limits());
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
        if !links.iter().all(Link::is_near) {
            return None;
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

fn ready(
    context: &Context,
    target: usize,
    object: &mut DisplacedObject,
    collider: &Collider,
    settings: &ImprintSettings,
    moment: Moment,
) -> Result<Ready> {
    let grid = context.stats().time("imprint.obb", || overlap_grid(context, object, collider, settings, moment))?;
    Ok(Ready { target, settings: *settings, grid })
}

impl Ready {
    fn link(&self, context: &Context, collider: &Collider) -> Option<Link> {
        let limits = self.settings.limits();
        self.grid.as_ref().map(|grid| Link::new(context, self.target, collider, grid, &limits))
    }
}
