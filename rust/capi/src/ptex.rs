//! Ptex files; see `include/relievo/ptex.h`.

use std::ffi::{c_char, c_void};
use std::path::Path;

use relievo_bake::ptex::{Imported, PtexImport, PtexKind, PtexTexel, from_ptex_watched, to_ptex_watched};
use relievo_core::{Context, Error, Mesh, Progress, Result};
use relievo_detail::LayeredObject;
use relievo_document::Document;
use relievo_ptex::Reader;
use relievo_tiles::{ChannelOptions, Field, by_format};

use crate::array::text;
use crate::context::{HostProgress, RlvProgress};
use crate::descriptor::{check_optional, read_optional, write_descriptor};
use crate::detail::{
    RLV_CHANNEL_COLOR, RLV_CHANNEL_DISPLACEMENT, RLV_CHANNEL_TRACES, RLV_CHANNEL_VECTORS, RlvDetail, fit_traces,
    missing,
};
use crate::registry;

constants! {
    u32:
    RLV_PTEX_STATED = 0,
    RLV_PTEX_DISPLACEMENT = 1,
    RLV_PTEX_COLOR = 2,
    RLV_PTEX_VECTORS = 3,
}

descriptor! {
    pub struct RlvPtexOptions {
        struct_size: u32,
        kind: u32,
        budget: u64,
    }
}

descriptor! {
    pub struct RlvPtexReport {
        struct_size: u32,
        channel: u32,
        face_count: usize,
        constant_count: usize,
        squared_count: usize,
        reduced_count: usize,
        enlarged_count: usize,
        ignored_numbers: usize,
        deviation: f32,
        reserved: u32,
    }
}

fn write<T: PtexTexel>(
    context: &Context,
    cage: &Mesh,
    field: &Field<T>,
    path: &Path,
    progress: &mut dyn Progress,
) -> Result<()> {
    to_ptex_watched(context, cage, field, progress)?.write(path)
}

/// Adds the channel of a file to `document` as a layer.
fn store(context: &Context, document: &mut Document, imported: &Imported) -> Result<u32> {
    match imported {
        Imported::Displacement(made) => made.field().store(context, document, "displacement")?,
        Imported::Vector(made) => made.field().store(context, document, "vectors")?,
        Imported::Rgba8(made) => made.field().store(context, document, "colour")?,
        Imported::Rgba16(made) => made.field().store(context, document, "colour")?,
    }
    Ok(match imported {
        Imported::Displacement(_) => RLV_CHANNEL_DISPLACEMENT,
        Imported::Vector(_) => RLV_CHANNEL_VECTORS,
        Imported::Rgba8(_) | Imported::Rgba16(_) => RLV_CHANNEL_COLOR,
    })
}

entry! {
    fn rlv_ptex_write(
        detail: RlvDetail,
        channel: u32,
        path: *const c_char,
        progress: RlvProgress,
        user: *mut c_void,
    ) {
        let detail = registry::get(detail)?;
        // SAFETY: the caller gives a NUL-terminated text.
        let path = Path::new(unsafe { text("path", path) }?);
        let (context, view) = (&detail.context.context, detail.view());
        let (cage, view) = (&view.cage, view.tiles("Ptex")?);
        let progress = &mut HostProgress { callback: progress, user };
        match channel {
            RLV_CHANNEL_DISPLACEMENT => Some(write(context, cage, view.snapshot.field(), path, progress)),
            RLV_CHANNEL_COLOR => view
                .paint
                .as_ref()
                .map(|paint| by_format!(paint, it => write(context, cage, it.field(), path, progress))),
            RLV_CHANNEL_VECTORS => view.vectors.as_ref().map(|it| write(context, cage, it.field(), path, progress)),
            RLV_CHANNEL_TRACES => {
                return Err(Error::unsupported("traces are not written as Ptex").at("channel").advise("bake them"));
            }
            _ => None,
        }
        .ok_or_else(|| missing(channel))?
    }

    fn rlv_ptex_read(
        detail: RlvDetail,
        path: *const c_char,
        options: *const RlvPtexOptions,
        progress: RlvProgress,
        user: *mut c_void,
        report: *mut RlvPtexReport,
    ) {
        let detail = registry::get(detail)?;
        // SAFETY: the caller gives a NUL-terminated text, and NULL or descriptors that start with their size.
        let (path, given) = unsafe {
            check_optional(report)?;
            let none = RlvPtexOptions { struct_size: 0, kind: RLV_PTEX_STATED, budget: 0 };
            (text("path", path)?, read_optional(options, none)?)
        };
        let kind = match given.kind {
            RLV_PTEX_STATED => None,
            RLV_PTEX_DISPLACEMENT => Some(PtexKind::Displacement),
            RLV_PTEX_COLOR => Some(PtexKind::Color),
            RLV_PTEX_VECTORS => Some(PtexKind::Vector),
            other => {
                return Err(Error::invalid(format!("there is no kind {other}")).at("kind").advise("use an RLV_PTEX_ value"));
            }
        };
        let budget = if given.budget == 0 { ChannelOptions::default().budget } else { given.budget };
        let context = &detail.context.context;
        let mut editor = detail.edit()?;
        let object = editor.tiles("Ptex")?;
        let named = |error: Error| error.at(path.to_string());
        let reader = Reader::open(Path::new(path), context.memory_limit())?;
        let progress = &mut HostProgress { callback: progress, user };
        let import = PtexImport { kind, budget, eight_bits: true };
        let (imported, done) =
            from_ptex_watched(context, object.surface(), &reader, &import, progress).map_err(named)?;
        progress.step(0.9, "ptex.take_up")?;
        // As of a document with that layer alone.
        let mut document = Document::new(&detail.view().cage, context.level().name())?;
        let channel = store(context, &mut document, &imported)?;
        object.take_up(context, &document, budget)?;
        fit_traces(context, object)?;
        if report.is_null() {
            return Ok(());
        }
        let made = RlvPtexReport {
            struct_size: 0,
            channel,
            face_count: done.faces,
            constant_count: done.constant,
            squared_count: done.squared,
            reduced_count: done.reduced,
            enlarged_count: done.enlarged,
            ignored_numbers: done.ignored,
            deviation: done.deviation,
            reserved: 0,
        };
        // SAFETY: as above.
        unsafe { write_descriptor(report, made) }
    }
}
