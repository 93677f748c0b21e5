//! Dabs of an object that a graphics device makes, and which those are.

use half::f16;
use relievo_core::{Context, Error, Result};
use relievo_gpu::PassTime;
use relievo_tiles::{Channel, Field, Vector, by_format};

use super::brush::Event;
use super::channels::DeviceColor;
use super::events::DeviceTile;
use super::follow::kept;
use super::memory::Tested;
use crate::channels::layered::LayeredObject;
use crate::device::state::DeviceObject;
use crate::imprint::culled::{BlockList, CulledTile};
use crate::object::DisplacedObject;
use crate::paint::dab::{Dab, Kind, no_vectors};
use crate::paint::edit::{self, TileEdit};
use crate::paint::ground::Ground;
use crate::paint::mode::{PaintMode, SculptMode};
use crate::paint::report::DabReport;

impl DisplacedObject {
    /// Makes a dab that sculpts on the device and keeps nothing of it. Returns how long its passes took there, by the
    /// device's clock: `dab.intersect`, `dab.scan`, `dab.manage` and `dab.edit` among them; none if the device does not
    /// time.
    ///
    /// # Errors
    /// Fails with `Invalid` if a number of the dab is out of range; with `Unsupported` if the object uses no device or
    /// the device does not make such a dab; with `Memory` if the device has no room; with `Device` if it is lost or its
    /// driver fails; and as the page store does if a tile is on a page that cannot be read.
    pub fn time_dab(&mut self, dab: &Dab) -> Result<Vec<PassTime>> {
        dab.check()?;
        let none = || Error::unsupported("the dab is none that a graphics device makes for this object");
        let Some(Kind::Sculpt(mode)) = self.kind_on_device(dab) else { return Err(none()) };
        let mut device = self.device.take().ok_or_else(none)?;
        let made = device.sculpt(self, std::slice::from_ref(dab), None, mode);
        self.device = Some(device);
        Ok(made?.map_or_else(Vec::new, |event| event.times))
    }

    /// Makes the first of `dabs`, or the first few at once, on the device. Returns what each did, what is known of several
    /// together with the last; `None` if the processor is to make the first.
    ///
    /// Fails as [`Dab::make`] does.
    pub(crate) fn dab_on_device(
        &mut self,
        context: &Context,
        dabs: &[Dab],
        start: Option<Ground<'_>>,
    ) -> Result<Option<Vec<DabReport>>> {
        if start.is_some()
            && self.device.is_some()
            && let Some((Kind::Sculpt(mode), dabs)) =
                Kind::first(dabs, |dab| Kind::of_both(dab, self.vectors.is_some()))?
        {
            return self.both_on_device(context, mode, dabs, start);
        }
        let Some((kind, dabs)) = Kind::first(dabs, |dab| self.kind_on_device(dab))? else { return Ok(None) };
        self.made_on_device(context, kind, dabs, start)
    }

    /// As [`Self::made_on_device`], of dabs that change displacement and vectors: first the one and then the other, since
    /// either goes by what both were when the stroke began.
    fn both_on_device(
        &mut self,
        context: &Context,
        mode: SculptMode,
        dabs: &[Dab],
        start: Option<Ground<'_>>,
    ) -> Result<Option<Vec<DabReport>>> {
        let Some(mut reports) = self.made_on_device(context, Kind::Sculpt(mode), dabs, start)? else { return Ok(None) };
        let mut at = 0;
        while at < reports.len() {
            let left = &dabs[at..reports.len()];
            let bent = match self.made_on_device(context, Kind::Bend(mode), left, start)? {
                Some(bent) => bent,
                // A height is nothing to modes that change both.
                None => vec![left[0].bend(context, self, (start, 0), mode, 0.0)?],
            };
            for bent in bent {
                let bytes = reports[at].bytes;
                reports[at].merge(&bent);
                reports[at].bytes += bytes;
                bent.give_back(context);
                at += 1;
            }
        }
        Ok(Some(reports))
    }

    /// As [`Self::dab_on_device`], of dabs of one kind with the same image of the brush.
    pub(crate) fn made_on_device(
        &mut self,
        context: &Context,
        kind: Kind,
        dabs: &[Dab],
        start: Option<Ground<'_>>,
    ) -> Result<Option<Vec<DabReport>>> {
        match kind {
            Kind::Bend(mode) => {
                let make = |device: &mut DeviceObject, object: &Self| {
                    device.bend(context, object, dabs, start, (None, None), mode)
                };
                let Some(event) = on_device(context, "dab.device", self, make) else { return Ok(None) };
                let vectors = self.vectors.as_mut().ok_or_else(no_vectors)?;
                let (firsts, erases) = (event.firsts.clone(), mode == SculptMode::Erase);
                let (report, reports, culled) = take(context, vectors, event, erases)?;
                let tiles = edit::stale(context, vectors.field(), &culled, &report);
                on_device(context, "dab.follow", self, |device: &mut DeviceObject, object| {
                    let vectors = object.vectors.as_ref().ok_or_else(no_vectors)?;
                    device.follow_bent(context, vectors.field(), &kept(&firsts, &report))
                });
                self.refit(context, start, &tiles);
                Ok(Some(reports))
            }
            Kind::Sculpt(mode) => {
                self.layers.displacement.check_editable()?;
                let make = |device: &mut DeviceObject, object: &Self| device.sculpt(object, dabs, start, mode);
                let Some(event) = on_device(context, "dab.device", self, make) else { return Ok(None) };
                self.widen(edit::range(context, &event.edits));
                let (firsts, erases) = (event.firsts.clone(), mode == SculptMode::Erase);
                let (report, reports, culled) = take(context, self.layers.displacement.composite_mut(), event, erases)?;
                on_device(context, "dab.follow", self, |device: &mut DeviceObject, object| {
                    device.follow_sculpted(object.displacement().field(), &kept(&firsts, &report))
                });
                self.refit_after(context, start, &culled, &report, false);
                Ok(Some(reports))
            }
            Kind::Paint(mode) => {
                let mut paint = self.take_paint()?;
                let done = by_format!(&mut paint, stack => {
                    let paint = stack.active_mut();
                    let make =
                        |device: &mut DeviceObject, object: &Self| device.paint(object, (paint, None), dabs, start, mode);
                    match on_device(context, "dab.device", self, make) {
                        Some(event) => {
                            let firsts = event.firsts.clone();
                            take(context, paint, event, mode == PaintMode::Erase).map(|(report, reports, _)| {
                                on_device(context, "dab.follow", self, |device: &mut DeviceObject, _| {
                                    device.follow_painted(paint.field(), &kept(&firsts, &report))
                                });
                                Some(reports)
                            })
                        }
                        None => Ok(None),
                    }
                });
                self.put_paint(paint);
                done
            }
        }
    }

    /// The second pass of a dab that sculpts at a level, on the device: `coarse` is the displacement there, and `before` that
    /// of when the stroke began. `None` if the processor is to.
    pub(crate) fn raised_on_device(
        &mut self,
        context: &Context,
        dab: &Dab,
        start: Option<Ground<'_>>,
        levels: (&Field, Option<&Field>),
    ) -> Option<Vec<TileEdit<f16>>> {
        let Some(Kind::Sculpt(mode)) = Kind::of(dab) else { return None };
        let make = |device: &mut DeviceObject, object: &Self| device.sculpt_at(object, dab, start, levels, mode);
        on_device(context, "dab.device", self, make).map(|event| event.edits)
    }

    /// As [`Self::raised_on_device`], of the vectors.
    pub(crate) fn bent_on_device(
        &mut self,
        context: &Context,
        dab: &Dab,
        start: Option<Ground<'_>>,
        (coarse, before): (&Field<Vector>, Option<&Field<Vector>>),
        mode: SculptMode,
    ) -> Option<Vec<TileEdit<Vector>>> {
        let (dabs, levels) = (std::slice::from_ref(dab), (Some(coarse), before));
        let make = |device: &mut DeviceObject, object: &Self| device.bend(context, object, dabs, start, levels, mode);
        on_device(context, "dab.device", self, make).map(|event| event.edits)
    }

    /// As [`Self::raised_on_device`], of a dab that paints `channel`, whose colours at the level are `coarse`.
    pub(crate) fn painted_on_device<T: DeviceColor>(
        &mut self,
        context: &Context,
        dab: &Dab,
        (channel, coarse): (&Channel<T>, &Field<T>),
        start: Option<Ground<'_>>,
    ) -> Option<Vec<TileEdit<T>>> {
        let Some(Kind::Paint(mode)) = Kind::of(dab) else { return None };
        let make = |device: &mut DeviceObject, object: &Self| {
            device.paint(object, (channel, Some(coarse)), std::slice::from_ref(dab), start, mode)
        };
        on_device(context, "dab.device", self, make).map(|event| event.edits)
    }

    /// What a dab does, if there is a device that does it and nothing else.
    fn kind_on_device(&self, dab: &Dab) -> Option<Kind> {
        Kind::on(dab, self.vectors.is_some()).filter(|_| self.device.is_some())
    }
}

/// An object that may have a device, and what that keeps of it.
pub(crate) trait OnDevice: LayeredObject {
    type Device;

    fn device_slot(&mut self) -> &mut Option<Self::Device>;

    /// Why the processor took over, until that is reported.
    fn fault_slot(&mut self) -> &mut Option<Error>;
}

impl OnDevice for DisplacedObject {
    type Device = DeviceObject;

    fn device_slot(&mut self) -> &mut Option<DeviceObject> {
        &mut self.device
    }

    fn fault_slot(&mut self) -> &mut Option<Error> {
        &mut self.device_fault
    }
}

/// What the device of `object` makes, timed as `stage`; `None` if the processor is to.
pub(crate) fn on_device<O: OnDevice, E>(
    context: &Context,
    stage: &'static str,
    object: &mut O,
    make: impl FnOnce(&mut O::Device, &O) -> Result<Option<E>>,
) -> Option<E> {
    let mut device = object.device_slot().take()?;
    match context.stats().time(stage, || make(&mut device, object)) {
        Ok(made) => {
            *object.device_slot() = Some(device);
            made
        }
        Err(error) => {
            object.lose_device(error);
            None
        }
    }
}

/// Makes what came back of an event the channel's: memory, texels, rings. Returns what its dabs did together, and each of
/// them, and the tiles that were looked at.
fn take<T: DeviceTile>(
    context: &Context,
    channel: &mut Channel<T>,
    event: Event<T>,
    erases: bool,
) -> Result<(DabReport, Vec<DabReport>, Vec<CulledTile>)> {
    let blocks = || BlockList::Many(Vec::new());
    let culled: Vec<CulledTile> = event.looked.into_iter().map(|tile| CulledTile { tile, blocks: blocks() }).collect();
    let whole = edit::write(context, channel, &culled, event.edits, erases)?;
    let reports = reports_of(&event.tested, &whole);
    Ok((whole, reports, culled))
}

/// What each dab of an event did, by what they found and what they did together, which the last one reports.
pub(crate) fn reports_of(tested: &[Tested], whole: &DabReport) -> Vec<DabReport> {
    let report = |it: &Tested| DabReport {
        tested_tiles: u64::from(it.tiles),
        tested_texels: u64::from(it.texels),
        changed_texels: u64::from(it.changed),
        bytes: whole.bytes,
        ..DabReport::default()
    };
    let mut reports: Vec<DabReport> = tested.iter().map(report).collect();
    // Texels of tiles that the budget refused did not change.
    let all: u64 = reports.iter().map(|report| report.changed_texels).sum();
    let mut excess = all.saturating_sub(whole.changed_texels);
    for dab in reports.iter_mut().rev() {
        let less = excess.min(dab.changed_texels);
        dab.changed_texels -= less;
        excess -= less;
    }
    if let Some(last) = reports.last_mut() {
        let DabReport { tested_tiles, tested_texels, changed_texels, .. } = *last;
        *last = DabReport { tested_tiles, tested_texels, changed_texels, ..whole.clone() };
    }
    reports
}
