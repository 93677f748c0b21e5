//! Imprints; see `include/relievo/imprint.h`.

use std::ffi::{CString, c_char};
use std::mem::{offset_of, size_of};
use std::sync::OnceLock;

use relievo_core::Result;
use relievo_core::parameter::ParameterKind;
use relievo_detail::{ImprintSettings, Moment, Report};

use crate::array::{present, put};
use crate::collider::RlvCollider;
use crate::descriptor::{Descriptor, Layout, check_descriptor, read_optional, write_descriptor};
use crate::detail::{Editor, RlvDetail, log_refusal};
use crate::registry::{self, try_read};

constants! {
    u32:
    RLV_PARAMETER_F32 = 0,
    RLV_PARAMETER_U32 = 1,
    RLV_PARAMETER_BOOL = 2,
}

descriptor! {
    pub struct RlvParameter {
        name: *const c_char,
        unit: *const c_char,
        help: *const c_char,
        kind: u32,
        offset: u32,
        min: f64,
        max: f64,
        value: f64,
    }
}

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
        steps: u32,
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
    }
}

/// The settings behind their size, field for field as [`ImprintSettings::PARAMETERS`] has them.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct RlvImprintSettings {
    struct_size: u32,
    settings: ImprintSettings,
}

// SAFETY: the struct is `#[repr(C)]`, begins with a `u32` and goes on with numbers of four bytes only.
unsafe impl Descriptor for RlvImprintSettings {
    const NAME: &'static str = "RlvImprintSettings";
    const FIRST_SIZE: usize = size_of::<Self>();
}

impl RlvImprintSettings {
    /// The layout, for comparison with the header.
    pub fn layout() -> Layout {
        let start = offset_of!(Self, settings);
        let fields = ImprintSettings::PARAMETERS.iter().map(|parameter| (parameter.name, start + parameter.offset, 4));
        Layout {
            name: Self::NAME,
            size: size_of::<Self>(),
            fields: [("struct_size", 0, 4)].into_iter().chain(fields).collect(),
        }
    }
}

/// The table that C reads; its texts live as long as the process.
struct Table(Vec<RlvParameter>, #[allow(dead_code)] Vec<CString>);

// SAFETY: the pointers are to texts that the table owns and nobody changes.
unsafe impl Send for Table {}
// SAFETY: as above.
unsafe impl Sync for Table {}

fn table() -> &'static Table {
    static TABLE: OnceLock<Table> = OnceLock::new();
    TABLE.get_or_init(|| {
        let mut texts = Vec::new();
        let mut text = |text: &str| {
            let text = CString::new(text).unwrap_or_default();
            // The heap allocation stays where it is when the string moves.
            let pointer = text.as_ptr();
            texts.push(text);
            pointer
        };
        let rows = ImprintSettings::PARAMETERS.iter().map(|parameter| RlvParameter {
            name: text(parameter.name),
            unit: text(parameter.unit),
            help: text(parameter.help),
            kind: match parameter.kind {
                ParameterKind::F32 => RLV_PARAMETER_F32,
                ParameterKind::U32 => RLV_PARAMETER_U32,
                ParameterKind::Bool => RLV_PARAMETER_BOOL,
            },
            offset: (offset_of!(RlvImprintSettings, settings) + parameter.offset) as u32,
            min: parameter.min,
            max: parameter.max,
            value: parameter.default,
        });
        let rows = rows.collect();
        Table(rows, texts)
    })
}

/// # Safety
/// Both are NULL or descriptors that start with their size.
unsafe fn inputs(
    settings: *const RlvImprintSettings,
    moment: *const RlvImprintMoment,
) -> Result<(ImprintSettings, Moment)> {
    let default = RlvImprintSettings { struct_size: 0, settings: ImprintSettings::default() };
    // SAFETY: promised by the caller.
    let settings = unsafe { read_optional(settings, default) }?.settings;
    settings.check()?;
    let first = RlvImprintMoment { struct_size: 0, pair: 0, frame: 0, step: 0, reserved: 0 };
    // SAFETY: promised by the caller.
    let moment = unsafe { read_optional(moment, first) }?;
    Ok((settings, Moment { frame: moment.frame, step: moment.step, pair: moment.pair }))
}

fn report_of(report: &Report, steps: u32) -> RlvImprintReport {
    RlvImprintReport {
        struct_size: 0,
        steps,
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
    }
}

entry! {
    fn rlv_imprint_params(params: *mut *const RlvParameter, count: *mut usize) {
        present("params", params)?;
        present("count", count)?;
        let Table(rows, _) = table();
        // SAFETY: both were checked above.
        unsafe {
            put(params, rows.as_ptr());
            put(count, rows.len());
        }
        Ok(())
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
        let (settings, moment) = unsafe { inputs(settings, moment) }?;
        if !report.is_null() {
            // SAFETY: as above.
            unsafe { check_descriptor(report) }?;
        }
        let (context, collider) = (&detail.context.context, try_read(&collider.collider, "collider")?);
        let mut editor = detail.edit()?;
        let Editor { object, imprinter, .. } = &mut *editor;
        let done = imprinter.imprint(context, object, &collider, &settings, moment)?;
        let budget = object.displacement().budget();
        // The log may call back.
        drop((editor, collider));
        log_refusal(&detail.context, done.refused.len(), budget);
        if report.is_null() {
            return Ok(());
        }
        // SAFETY: as above.
        unsafe { write_descriptor(report, report_of(&done, 1)) }
    }
}
