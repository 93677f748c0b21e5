//! Strokes; see `include/relievo/stroke.h`.

use std::sync::{Arc, Mutex, MutexGuard};

use glam::DVec3;
use relievo_core::{Context, Error, List, Result};
use relievo_detail::{Canvas, OpenStroke, StrokePoint, StrokeReport};

use crate::border::array::{Input, Plain, present, put, reserve};
use crate::border::descriptor::{check_optional, write_optional};
use crate::border::registry::{self, handle, try_lock, try_read};
use crate::border::work::Held;
use crate::details::brush::RlvBrush;
use crate::details::detail::{DetailObject, RlvDetail, log_refusal};

handle!(RlvStroke, 9, StrokeObject);

descriptor! {
    pub struct RlvStrokePoint {
        position: [f64; 3],
        pressure: f64,
        time: f64,
    }
}

// SAFETY: five doubles without padding.
unsafe impl Plain for RlvStrokePoint {}

impl Default for RlvStrokePoint {
    fn default() -> Self {
        Self { position: [0.0; 3], pressure: 1.0, time: -1.0 }
    }
}

descriptor! {
    pub struct RlvStrokeReport {
        struct_size: u32,
        reserved: u32,
        dabs: u64,
        missed_dabs: u64,
        tested_tiles: u64,
        tested_texels: u64,
        changed_tiles: u64,
        changed_texels: u64,
        allocated_tiles: u64,
        freed_tiles: u64,
        refused_tiles: u64,
        bytes: u64,
    }
}

/// A stroke under way, until it is ended, and the detail it is on.
pub struct StrokeObject {
    detail: Arc<DetailObject>,
    open: Mutex<Option<OpenStroke>>,
}

impl StrokeObject {
    fn open(&self) -> Result<Held<MutexGuard<'_, Option<OpenStroke>>>> {
        try_lock(&self.open, "stroke")
    }
}

fn ended() -> Error {
    Error::invalid("it has ended").at("stroke").advise("begin another one")
}

/// Copies the points of a stroke into a list that is lent.
///
/// # Errors
/// Fails with `Invalid` if the pointer is NULL and `count` is not 0 or the stride is too small, and with `Memory` if
/// the points exceed the context's memory limit.
///
/// # Safety
/// `count` points can be read at `stride` bytes from one another.
pub unsafe fn points_of(
    context: &Context,
    points: *const RlvStrokePoint,
    count: usize,
    stride: usize,
) -> Result<List<'_, StrokePoint>> {
    // SAFETY: promised by the caller.
    let points = unsafe { Input::new("points", points, count, stride) }?;
    let mut list = context.scratch().list();
    if list.capacity() < count {
        *list = reserve("points", count, context.memory_limit())?;
    }
    list.extend(points.iter().map(|point| StrokePoint {
        // A time below 0 is none; what is not a number is refused with the stroke.
        time: (point.time >= 0.0 || point.time.is_nan()).then_some(point.time),
        ..StrokePoint::new(DVec3::from(point.position), point.pressure)
    }));
    Ok(list)
}

/// Edits the detail with `edit`, and says what that did.
///
/// # Safety
/// As for [`write_optional`].
unsafe fn edit(
    detail: &DetailObject,
    to: *mut RlvStrokeReport,
    edit: impl FnOnce(&mut dyn Canvas) -> Result<Vec<StrokeReport>>,
) -> Result<()> {
    let mut editor = detail.edit()?;
    let reports = edit(editor.canvas())?;
    let budget = editor.budget();
    detail.leave(editor);
    let nothing = StrokeReport::default();
    let done = reports.first().unwrap_or(&nothing);
    log_refusal(detail, &done.report.refused, budget);
    let made = RlvStrokeReport {
        struct_size: 0,
        reserved: 0,
        dabs: done.dabs,
        missed_dabs: done.missed,
        tested_tiles: done.report.tested_tiles,
        tested_texels: done.report.tested_texels,
        changed_tiles: done.report.changed.len() as u64,
        changed_texels: done.report.changed_texels,
        allocated_tiles: done.report.allocated,
        freed_tiles: done.report.freed,
        refused_tiles: done.report.refused.len() as u64,
        bytes: done.report.bytes,
    };
    StrokeReport::give_back(&detail.context.context, reports);
    // SAFETY: promised by the caller.
    unsafe { write_optional(to, made) }
}

entry! {
    fn rlv_stroke_run(
        detail: RlvDetail,
        brush: RlvBrush,
        points: *const RlvStrokePoint,
        count: usize,
        stride: usize,
        report: *mut RlvStrokeReport,
    ) {
        let (detail, brush) = (registry::get(detail)?, registry::get(brush)?);
        // SAFETY: the caller promises `count` points, and NULL or a descriptor that starts with its size.
        let points = unsafe {
            check_optional(report)?;
            points_of(&detail.context.context, points, count, stride)?
        };
        let mut stroke = try_read(&brush.stroke, "brush")?.clone();
        stroke.points = points.detach();
        // SAFETY: as above.
        unsafe { edit(&detail, report, |object| stroke.apply_all(&detail.context.context, &mut [object])) }
    }

    fn rlv_stroke_begin(detail: RlvDetail, brush: RlvBrush, out: *mut RlvStroke) {
        present("out", out)?;
        let (detail, brush) = (registry::get(detail)?, registry::get(brush)?);
        let stroke = try_read(&brush.stroke, "brush")?.clone();
        let open = OpenStroke::begin(&detail.context.context, stroke, &mut [detail.edit()?.canvas()])?;
        let handle = registry::insert(StrokeObject { detail, open: Mutex::new(Some(open)) })?;
        // SAFETY: checked above.
        unsafe { put(out, handle) };
        Ok(())
    }

    fn rlv_stroke_retain(stroke: RlvStroke) {
        registry::retain(stroke)
    }

    fn rlv_stroke_release(stroke: RlvStroke) {
        registry::release(stroke)
    }

    fn rlv_stroke_extend(stroke: RlvStroke, points: *const RlvStrokePoint, count: usize, stride: usize, report: *mut RlvStrokeReport) {
        let stroke = registry::get(stroke)?;
        let detail = &stroke.detail;
        // SAFETY: the caller promises `count` points, and NULL or a descriptor that starts with its size.
        let points = unsafe {
            check_optional(report)?;
            points_of(&detail.context.context, points, count, stride)?
        };
        let mut open = stroke.open()?;
        let open = open.as_mut().ok_or_else(ended)?;
        // SAFETY: as above.
        unsafe { edit(detail, report, |object| open.extend(&detail.context.context, &mut [object], &points)) }
    }

    fn rlv_stroke_end(stroke: RlvStroke, report: *mut RlvStrokeReport) {
        let stroke = registry::get(stroke)?;
        let detail = &stroke.detail;
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        unsafe { check_optional(report) }?;
        let mut open = stroke.open()?;
        let last = open.as_ref().ok_or_else(ended)?.clone();
        // SAFETY: as above.
        unsafe { edit(detail, report, |object| last.end(&detail.context.context, &mut [object], &[])) }?;
        open.take().into_iter().for_each(|done| done.give_back(&detail.context.context));
        Ok(())
    }
}
