//! Imprints; see `include/relievo/imprint.h`.

use std::ffi::c_void;
use std::sync::{Arc, OnceLock};

use relievo_core::{Error, Progress, Result};
use relievo_detail::{
    AnyObject, Deformable, ImprintSettings, LayeredObject, Moment, Motion, Pose, Report, with_object,
};
use relievo_tiles::trace::Trace;
use relievo_tiles::triangle::TriangleChannel;
use relievo_tiles::{Displacement, Traces};

use crate::border::array::Input;
use crate::border::descriptor::{check_optional, read_optional, write_optional};
use crate::border::registry::{self, try_read, try_write};
use crate::details::collider::{ColliderObject, RlvCollider};
use crate::details::detail::{DetailObject, Editor, RlvDetail, log_refusal, tiles, transform};
use crate::runtime::context::{HostProgress, RlvProgress};
use crate::runtime::parameter::{RlvParameter, Table, settings, write_table};

settings!(RlvImprintSettings, ImprintSettings);

descriptor! {
    pub struct RlvImprintMoment {
        struct_size: u32,
        pair: u32,
        frame: u64,
        step: u32,
        reserved: u32,
    }
}

descriptor! {
    pub struct RlvImprintReport {
        struct_size: u32,
        reserved: u32,
        steps: u64,
        wanted_steps: u64,
        tested_tiles: u64,
        tested_coefficients: u64,
        changed_tiles: u64,
        changed_coefficients: u64,
        allocated_tiles: u64,
        refused_tiles: u64,
        clamped_rays: u64,
        triangles: u64,
        bytes: u64,
        voxel_diagonal: f64,
        pushed_volume: f64,
        raised_volume: f64,
        open_edges: u64,
    }
}

/// The settings and the moment of an imprint.
///
/// # Errors
/// Fails with `Invalid` if a setting is out of range or `struct_size` is none of the type, and with `Unsupported` if a
/// field that this library lacks is not zero.
///
/// # Safety
/// Both are NULL or descriptors that start with their size.
pub unsafe fn how(
    settings: *const RlvImprintSettings,
    moment: *const RlvImprintMoment,
) -> Result<(ImprintSettings, Moment)> {
    // SAFETY: promised by the caller.
    unsafe { Ok((RlvImprintSettings::read(settings)?, moment_of(moment)?)) }
}

/// # Safety
/// `moment` is NULL or a descriptor that starts with its size.
unsafe fn moment_of(moment: *const RlvImprintMoment) -> Result<Moment> {
    let first = RlvImprintMoment { struct_size: 0, pair: 0, frame: 0, step: 0, reserved: 0 };
    // SAFETY: promised by the caller.
    let moment = unsafe { read_optional(moment, first) }?;
    Ok(Moment { frame: moment.frame, step: moment.step, pair: moment.pair })
}

/// What an imprint did, as C has it.
pub fn report_of(report: &Report) -> RlvImprintReport {
    RlvImprintReport {
        struct_size: 0,
        reserved: 0,
        steps: report.sub_steps,
        wanted_steps: report.sub_steps_wanted.max(report.sub_steps),
        tested_tiles: report.tested_tiles,
        tested_coefficients: report.tested_coefficients,
        changed_tiles: report.changed.len() as u64,
        changed_coefficients: report.changed_coefficients,
        allocated_tiles: report.allocated,
        refused_tiles: report.refused.len() as u64,
        clamped_rays: report.clamped,
        triangles: report.triangles,
        bytes: report.bytes,
        voxel_diagonal: report.voxel_diagonal,
        pushed_volume: report.volumes.pushed,
        raised_volume: report.volumes.raised,
        open_edges: report.open_edges,
    }
}

/// What an imprint may change of an object.
enum Before {
    Tiles(Displacement, Option<Traces>),
    Triangles(TriangleChannel, Option<TriangleChannel<Trace>>),
}

impl Before {
    fn of(object: &AnyObject) -> Self {
        match object {
            AnyObject::Tiles(object) => Self::Tiles(object.displacement().clone(), object.traces().cloned()),
            AnyObject::Triangles(object) => Self::Triangles(object.displacement().clone(), object.traces().cloned()),
        }
    }

    /// Puts the object back to what it was before a call that failed half-way.
    fn restore(self, object: &mut AnyObject) {
        match (self, object) {
            (Self::Tiles(displacement, traces), AnyObject::Tiles(object)) => {
                *object.displacement_mut() = displacement;
                object.traces_mut().into_iter().zip(traces).for_each(|(to, from)| *to = from);
            }
            (Self::Triangles(displacement, traces), AnyObject::Triangles(object)) => {
                *object.displacement_mut() = displacement;
                object.traces_mut().into_iter().zip(traces).for_each(|(to, from)| *to = from);
            }
            _ => {}
        }
    }
}

/// Where a deforming collider starts and ends: transforms, and points of its mesh, at both moments.
///
/// # Errors
/// Fails with `Invalid` if an array of points is NULL and `count` is not 0 or its stride is too small, and with
/// `Memory` if the points exceed the context's memory limit.
///
/// # Safety
/// A matrix is NULL or has twelve doubles; `from_points` and `to_points` have `count` points.
pub unsafe fn poses_of(
    collider: &ColliderObject,
    [from, to]: [*const f64; 2],
    [from_points, to_points]: [*const f32; 2],
    count: usize,
    stride: usize,
) -> Result<[Pose; 2]> {
    let limit = collider.context.context.memory_limit();
    let pose = |matrix, name, points: *const f32| -> Result<Pose> {
        // SAFETY: promised by the caller.
        let (transform, points) =
            unsafe { (transform(matrix)?, Input::new(name, points.cast::<[f32; 3]>(), count, stride)?) };
        Ok(Pose { transform, points: Some(points.to_vec(name, limit)?.into()) })
    };
    Ok([pose(from, "from_points", from_points)?, pose(to, "to_points", to_points)?])
}

/// As [`sweep`], for a call.
///
/// # Safety
/// The pointers are NULL or to descriptors that start with their size.
unsafe fn sweep_now(
    detail: RlvDetail,
    collider: RlvCollider,
    poses: [Pose; 2],
    (settings, moment): (*const RlvImprintSettings, *const RlvImprintMoment),
    mut progress: HostProgress,
    report: *mut RlvImprintReport,
) -> Result<()> {
    let (detail, collider) = (registry::get(detail)?, registry::get(collider)?);
    // SAFETY: promised by the caller.
    let how = unsafe { how(settings, moment) }?;
    // SAFETY: as above.
    unsafe { check_optional(report) }?;
    let done = sweep(&detail, &collider, poses, &how, &mut progress)?;
    // SAFETY: as above.
    unsafe { write_optional(report, report_of(&done)) }
}

/// Moves a collider from one pose to another and presses it in on the way. After a failure both are as before. Reports
/// progress only while it has both for itself; the last report, of the whole, can still cancel.
///
/// # Errors
/// Fails with `Busy` if another call is at work on the collider or the detail, with `Invalid` if a pose or the settings
/// cannot be used, with `Memory` if the rim exceeds the memory limit, and with `Cancelled` if `progress` asks to stop.
pub fn sweep(
    detail: &DetailObject,
    collider: &ColliderObject,
    poses: [Pose; 2],
    (settings, moment): &(ImprintSettings, Moment),
    progress: &mut dyn Progress,
) -> Result<Report> {
    let moment = *moment;
    let mut collider = try_write(&collider.collider, "collider")?;
    let mut editor = detail.edit()?;
    let Editor { object, imprinter, .. } = &mut *editor;
    let context = &detail.context.context;
    let [from, to] = poses;
    let rest = from.points.is_some().then(|| Arc::from(collider.points()));
    let motion = Motion::new(&collider, from, to)?;
    let (before, place) = (Before::of(object), Pose { transform: *collider.transform(), points: rest });
    let done = with_object!(&mut *object, object => {
        imprinter.sweep_watched(context, &mut **object, &mut collider, &motion, settings, moment, progress)
    });
    let settled = done.and_then(|done| Ok((with_object!(&mut *object, object => object.settle(context))?, done)));
    let done = match settled.and_then(|settled| progress.step(1.0, "imprint").map(|()| settled)) {
        Ok((refused, mut done)) => {
            done.refused.extend(refused);
            done
        }
        Err(error) => {
            before.restore(object);
            collider.set_pose(context, &place)?;
            return Err(error);
        }
    };
    let budget = editor.budget();
    drop(collider);
    detail.leave(editor);
    log_refusal(detail, &done.refused, budget);
    Ok(done)
}

entry! {
    fn rlv_imprint_params(params: *mut *const RlvParameter, count: *mut usize) {
        static TABLE: OnceLock<Table> = OnceLock::new();
        // SAFETY: the caller gives pointers to which a value may be written, or NULL.
        unsafe { write_table(&TABLE, ImprintSettings::PARAMETERS, params, count) }
    }

    fn rlv_imprint_run(
        detail: RlvDetail,
        collider: RlvCollider,
        settings: *const RlvImprintSettings,
        moment: *const RlvImprintMoment,
        report: *mut RlvImprintReport,
    ) {
        let detail = registry::get(detail)?;
        let collider = registry::get(collider)?;
        // SAFETY: the caller gives NULL or descriptors that start with their size.
        let (settings, moment) = unsafe { (RlvImprintSettings::read(settings)?, moment_of(moment)?) };
        // SAFETY: as above.
        unsafe { check_optional(report) }?;
        let collider = try_read(&collider.collider, "collider")?;
        let mut editor = detail.edit()?;
        let Editor { object, imprinter, .. } = &mut *editor;
        let context = &detail.context.context;
        let mut done = with_object!(&mut *object, object => imprinter.imprint(context, &mut **object, &collider, &settings, moment))?;
        done.refused.extend(with_object!(object, object => object.settle(context))?);
        let budget = editor.budget();
        drop(collider);
        detail.leave(editor);
        log_refusal(&detail, &done.refused, budget);
        // SAFETY: as above.
        let written = unsafe { write_optional(report, report_of(&done)) };
        done.give_back(&detail.context.context);
        written
    }

    fn rlv_imprint_sweep(
        detail: RlvDetail,
        collider: RlvCollider,
        from: *const f64,
        to: *const f64,
        settings: *const RlvImprintSettings,
        moment: *const RlvImprintMoment,
        progress: RlvProgress,
        user: *mut c_void,
        report: *mut RlvImprintReport,
    ) {
        // SAFETY: the caller gives NULL or twelve doubles.
        let poses = unsafe { [Pose::rigid(transform(from)?), Pose::rigid(transform(to)?)] };
        // SAFETY: the caller gives NULL or descriptors that start with their size.
        unsafe { sweep_now(detail, collider, poses, (settings, moment), HostProgress { callback: progress, user }, report) }
    }

    fn rlv_imprint_sweep_points(
        detail: RlvDetail,
        collider: RlvCollider,
        from: *const f64,
        to: *const f64,
        from_points: *const f32,
        to_points: *const f32,
        count: usize,
        stride: usize,
        settings: *const RlvImprintSettings,
        moment: *const RlvImprintMoment,
        progress: RlvProgress,
        user: *mut c_void,
        report: *mut RlvImprintReport,
    ) {
        let object = registry::get(collider)?;
        // SAFETY: the caller gives NULL or twelve doubles, and `count` points.
        let poses = unsafe { poses_of(&object, [from, to], [from_points, to_points], count, stride) }?;
        // SAFETY: the caller gives NULL or descriptors that start with their size.
        unsafe { sweep_now(detail, collider, poses, (settings, moment), HostProgress { callback: progress, user }, report) }
    }

    fn rlv_imprint_collide(
        first: RlvDetail,
        second: RlvDetail,
        first_settings: *const RlvImprintSettings,
        second_settings: *const RlvImprintSettings,
        moment: *const RlvImprintMoment,
        first_report: *mut RlvImprintReport,
        second_report: *mut RlvImprintReport,
    ) {
        if first.id == second.id {
            return Err(Error::invalid("a detail cannot collide with itself").at("second"));
        }
        let (first, second) = (registry::get(first)?, registry::get(second)?);
        // SAFETY: the caller gives NULL or descriptors that start with their size.
        let (one, other, moment) = unsafe {
            (RlvImprintSettings::read(first_settings)?, RlvImprintSettings::read(second_settings)?, moment_of(moment)?)
        };
        // SAFETY: as above.
        unsafe {
            check_optional(first_report)?;
            check_optional(second_report)?;
        }
        let cages = [first.view().cage.clone(), second.view().cage.clone()];
        let (mut first_editor, mut second_editor) = (first.edit()?, second.edit()?);
        let before = [Before::of(&first_editor.object), Before::of(&second_editor.object)];
        let Editor { object, imprinter, .. } = &mut *first_editor;
        let first_object = tiles(object, "imprints into each other")?;
        let second_object = second_editor.tiles("imprints into each other")?;
        let done = imprinter.collide(
            &first.context.context,
            &mut Deformable { object: first_object, cage: &cages[0], settings: one },
            &mut Deformable { object: second_object, cage: &cages[1], settings: other },
            moment,
        );
        let [one, other] = match done {
            Ok(done) => done,
            Err(error) => {
                let [one, other] = before;
                one.restore(&mut first_editor.object);
                other.restore(&mut second_editor.object);
                return Err(error);
            }
        };
        first_object.settle(&first.context.context)?;
        second_object.settle(&second.context.context)?;
        let budgets = [first_object.displacement().budget(), second_object.displacement().budget()];
        first.leave(first_editor);
        second.leave(second_editor);
        log_refusal(&first, &one.refused, budgets[0]);
        log_refusal(&second, &other.refused, budgets[1]);
        // SAFETY: as above.
        unsafe {
            write_optional(first_report, report_of(&one))?;
            write_optional(second_report, report_of(&other))
        }
    }
}
