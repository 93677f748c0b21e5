//! Ptex files; see `include/relievo/ptex.h`.

use std::ffi::{c_char, c_void};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use relievo_bake::ptex::{Imported, PtexImport, PtexKind, PtexTexel, from_ptex_watched, to_ptex_watched};
use relievo_core::{Context, Error, Mesh, Progress, Result};
use relievo_detail::LayeredObject;
use relievo_document::Document;
use relievo_ptex::Reader;
use relievo_tiles::{ChannelOptions, Field, by_format};

use crate::border::array::text;
use crate::border::descriptor::{check_optional, read_optional, write_optional};
use crate::border::registry;
use crate::details::detail::{
    DetailObject, RLV_CHANNEL_COLOR, RLV_CHANNEL_DISPLACEMENT, RLV_CHANNEL_TRACES, RLV_CHANNEL_VECTORS, RlvDetail,
    fit_traces, missing,
};
use crate::details::view::View;
use crate::runtime::context::{HostProgress, RlvProgress};

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

/// A channel that is written to a file.
pub struct Export {
    view: Arc<View>,
    channel: u32,
    path: PathBuf,
}

impl Export {
    /// Of a detail as it was committed last.
    ///
    /// # Errors
    /// Fails with `Invalid` if the path is no text.
    ///
    /// # Safety
    /// `path` is a NUL-terminated text.
    pub unsafe fn read(detail: &DetailObject, channel: u32, path: *const c_char) -> Result<Self> {
        // SAFETY: promised by the caller.
        let path = PathBuf::from(unsafe { text("path", path) }?);
        Ok(Self { view: detail.view(), channel, path })
    }

    /// Writes the file.
    ///
    /// # Errors
    /// Fails with `Unsupported` for triangle meshes and traces, with `Invalid` if the detail has no such channel, with
    /// `NotFound` or `Io` if the file cannot be written, and with `Cancelled` if `progress` asks to stop.
    pub fn write(&self, context: &Context, progress: &mut dyn Progress) -> Result<()> {
        let Self { view, channel, path } = self;
        let (cage, tiles) = (&view.cage, view.tiles("Ptex")?);
        let written = match *channel {
            RLV_CHANNEL_COLOR => tiles
                .paint
                .as_ref()
                .map(|paint| by_format!(paint, it => write(context, cage, it.field(), path, progress))),
            RLV_CHANNEL_VECTORS => tiles.vectors.as_ref().map(|it| write(context, cage, it.field(), path, progress)),
            RLV_CHANNEL_DISPLACEMENT => Some(write(context, cage, tiles.snapshot.field(), path, progress)),
            RLV_CHANNEL_TRACES => {
                return Err(Error::unsupported("traces are not written as Ptex").at("channel").advise("bake them"));
            }
            _ => None,
        };
        written.unwrap_or_else(|| Err(missing(*channel)))
    }
}

/// A file whose texels a detail takes up.
pub struct Import {
    path: String,
    kind: Option<PtexKind>,
    budget: u64,
}

impl Import {
    /// Copies what was asked for.
    ///
    /// # Errors
    /// Fails with `Invalid` if the path is no text, `struct_size` is none of the type or there is no such kind, and
    /// with `Unsupported` if a field that this library lacks is not zero.
    ///
    /// # Safety
    /// `path` is a NUL-terminated text, `options` NULL or a descriptor that starts with its size.
    pub unsafe fn read(path: *const c_char, options: *const RlvPtexOptions) -> Result<Self> {
        let none = RlvPtexOptions { struct_size: 0, kind: RLV_PTEX_STATED, budget: 0 };
        // SAFETY: promised by the caller.
        let (path, given) = unsafe { (text("path", path)?.to_owned(), read_optional(options, none)?) };
        let kind = match given.kind {
            RLV_PTEX_STATED => None,
            RLV_PTEX_DISPLACEMENT => Some(PtexKind::Displacement),
            RLV_PTEX_COLOR => Some(PtexKind::Color),
            RLV_PTEX_VECTORS => Some(PtexKind::Vector),
            other => {
                return Err(Error::invalid(format!("there is no kind {other}"))
                    .at("kind")
                    .advise("use an RLV_PTEX_ value"));
            }
        };
        let budget = if given.budget == 0 { ChannelOptions::default().budget } else { given.budget };
        Ok(Self { path, kind, budget })
    }

    /// Reads the file. The first progress is reported once the detail is there for this alone.
    ///
    /// # Errors
    /// Fails with `Busy` while another call edits the detail, with `Unsupported` for triangle meshes, with `NotFound`
    /// or `Io` if the file cannot be read, with `Invalid` if it is damaged or of another mesh, with `Memory` above the
    /// budget or the memory limit, and with `Cancelled` if `progress` asks to stop.
    pub fn take_up(&self, detail: &DetailObject, progress: &mut dyn Progress) -> Result<RlvPtexReport> {
        let context = &detail.context.context;
        let mut editor = detail.edit()?;
        let object = editor.tiles("Ptex")?;
        let reader = Reader::open(Path::new(&self.path), context.memory_limit())?;
        let import = PtexImport { kind: self.kind, budget: self.budget, eight_bits: true };
        let (imported, done) = from_ptex_watched(context, object.surface(), &reader, &import, progress)
            .map_err(|error| error.at(self.path.clone()))?;
        progress.step(0.9, "ptex.take_up")?;
        // As of a document with that layer alone.
        let mut document = Document::new(&detail.view().cage, context.level().name())?;
        let channel = store(context, &mut document, &imported)?;
        object.take_up(context, &document, self.budget)?;
        fit_traces(context, object)?;
        Ok(RlvPtexReport {
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
        })
    }
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
        let export = unsafe { Export::read(&detail, channel, path) }?;
        export.write(&detail.context.context, &mut HostProgress { callback: progress, user })
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
        let import = unsafe {
            check_optional(report)?;
            Import::read(path, options)?
        };
        let done = import.take_up(&detail, &mut HostProgress { callback: progress, user })?;
        // SAFETY: as above.
        unsafe { write_optional(report, done) }
    }
}
