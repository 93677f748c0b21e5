//! Documents that are worked on; see `include/relievo/document.h`.

use std::ffi::{c_char, c_void};
use std::io::Cursor;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard};

use relievo_bake::transfer::{TransferOptions, transfer_watched};
use relievo_core::progress::Silent;
use relievo_core::{Context, Error, ErrorKind, Mesh, Progress, Result};
use relievo_detail::history::Changed;
use relievo_detail::{AnyObject, History, LayeredObject, Recorded, with_object};
use relievo_document::Document;

use crate::border::array::{present, put, text};
use crate::border::descriptor::{check_optional, read_optional, write_descriptor, write_optional};
use crate::border::making::Making;
use crate::border::registry::{self, handle, try_lock, try_read};
use crate::border::work::Held;
use crate::details::detail::{DetailObject, RlvDetail, fit_traces};
use crate::runtime::bytes::{self, RlvBytes};
use crate::runtime::context::{ContextObject, HostProgress, RLV_LOG_WARNING, RlvContext, RlvProgress};
use crate::runtime::stream::{HostStream, RlvStream};
use crate::surfaces::mesh::{self, RlvMesh};

handle!(RlvDocument, 10, DocumentObject);

descriptor! {
    pub struct RlvDocumentInfo {
        struct_size: u32,
        is_open: u32,
        undo_count: usize,
        redo_count: usize,
        bytes: u64,
    }
}

descriptor! {
    pub struct RlvDocumentChanges {
        struct_size: u32,
        is_done: u32,
        layer_count: usize,
        block_count: usize,
        bytes: u64,
    }
}

descriptor! {
    pub struct RlvTransferOptions {
        struct_size: u32,
        reserved: u32,
        from: RlvMesh,
        reach: f64,
    }
}

descriptor! {
    pub struct RlvTransferReport {
        struct_size: u32,
        layer_count: u32,
        area: f64,
        uncovered_area: f64,
        edited_area: f64,
        lost_area: f64,
        reach: f64,
    }
}

/// The history of a detail, in a file or not.
pub struct DocumentObject {
    pub detail: Arc<DetailObject>,
    history: Mutex<History>,
}

/// Bytes of edits that a history keeps in memory, if the host does not say.
const MEMORY: u64 = 256 << 20;

impl DocumentObject {
    /// The history for a call that changes it.
    ///
    /// # Errors
    /// Fails with `Busy` while another call changes it, and with `Internal` if an earlier panic left it broken.
    pub fn history(&self) -> Result<Held<MutexGuard<'_, History>>> {
        try_lock(&self.history, "document")
    }
}

/// Makes a document of the layers of a detail.
fn document_of(detail: &DetailObject, object: &AnyObject) -> Result<Document> {
    object.document(&detail.context.context, &detail.view().cage)
}

/// Makes a document of what `open` returns, whose layers the detail takes up; messages name it `place`.
fn opened(
    detail: &Arc<DetailObject>,
    place: &str,
    open: impl FnOnce() -> Result<(Document, History)>,
    progress: &mut dyn Progress,
) -> Result<RlvDocument> {
    let context = &detail.context.context;
    let mut editor = detail.edit()?;
    progress.step(0.0, "read")?;
    let (document, history) = open()?;
    let mut notes = document.notes.clone();
    let cage = detail.view().cage.clone();
    notes.extend(editor.object.fit(&document, &cage).map_err(|error| error.at(place))?);
    let budget = editor.budget();
    // The last moment at which all is as it was.
    progress.step(0.5, "layers")?;
    let unknown = with_object!(&mut editor.object, object => object.take_up(context, &document, budget))?;
    if let AnyObject::Tiles(object) = &mut editor.object {
        fit_traces(context, object)?;
    }
    notes.extend(unknown.into_iter().map(|name| format!("layer `{name}` of the document is left out")));
    progress.report(1.0, "layers");
    // The log may call back.
    drop(editor);
    notes.iter().for_each(|note| detail.context.log(RLV_LOG_WARNING, &format!("{place}: {note}")));
    registry::insert(DocumentObject { detail: detail.clone(), history: Mutex::new(history) })
}

/// The mesh that a document was made on.
fn mesh_of(document: &Document) -> Result<Mesh> {
    document.mesh().ok_or_else(|| Error::new(ErrorKind::NotFound, "the document does not have the points of its mesh"))
}

fn or_default(memory: u64) -> u64 {
    if memory == 0 { MEMORY } else { memory }
}

/// What a history does.
enum Task<'a> {
    Begin(&'a str),
    End,
    Abandon,
    Undo,
    Redo,
}

impl Task<'_> {
    fn run(self, history: &mut History, context: &Context, object: &mut impl Recorded) -> Result<Option<Changed>> {
        match self {
            Task::Begin(input) => history.begin(context, object, input).map(|()| None),
            Task::End => history.end(context, object),
            Task::Abandon => history.abandon(context, object).map(|()| None),
            Task::Undo => history.undo(context, object),
            Task::Redo => history.redo(context, object),
        }
    }
}

/// Lets the history of `document` work on its detail, and says what that changed.
///
/// # Safety
/// As for [`write_optional`].
unsafe fn work(document: RlvDocument, to: *mut RlvDocumentChanges, task: Task<'_>) -> Result<()> {
    let document = registry::get(document)?;
    // SAFETY: promised by the caller.
    unsafe { check_optional(to) }?;
    let (mut history, mut editor) = (document.history()?, document.detail.edit()?);
    let context = &document.detail.context.context;
    let changed = with_object!(&mut editor.object, object => task.run(&mut history, context, &mut **object))?;
    let changes = RlvDocumentChanges {
        struct_size: 0,
        is_done: u32::from(changed.is_some()),
        layer_count: changed.as_ref().map_or(0, |changed| changed.blocks.len()),
        block_count: changed.as_ref().map_or(0, |changed| changed.blocks.iter().map(|(_, list)| list.len()).sum()),
        bytes: changed.map_or(0, |changed| changed.bytes),
    };
    // SAFETY: promised by the caller.
    unsafe { write_optional(to, changes) }
}

/// A document whose layers another mesh takes.
pub struct Transfer {
    path: String,
    to_path: PathBuf,
    from: Option<Mesh>,
    to: Mesh,
    reach: Option<f64>,
}

impl Transfer {
    /// Copies the meshes and the paths.
    ///
    /// # Errors
    /// Fails with `Invalid` if a handle is not alive, a path is no text or `struct_size` is none of the type, and with
    /// `Busy` if a mesh is being changed.
    ///
    /// # Safety
    /// The paths are NUL-terminated texts, `options` is NULL or a descriptor that starts with its size.
    pub unsafe fn read(
        mesh: RlvMesh,
        path: *const c_char,
        to_path: *const c_char,
        options: *const RlvTransferOptions,
    ) -> Result<Self> {
        let none = RlvTransferOptions { struct_size: 0, reserved: 0, from: RlvMesh { id: 0 }, reach: 0.0 };
        // SAFETY: promised by the caller.
        let (path, to_path, given) = unsafe {
            (text("path", path)?.to_owned(), PathBuf::from(text("to_path", to_path)?), read_optional(options, none)?)
        };
        let copy = |handle: RlvMesh| -> Result<Mesh> { Ok(try_read(&registry::get(handle)?.mesh, "mesh")?.clone()) };
        let from = if given.from.id == 0 { None } else { Some(copy(given.from)?) };
        let reach = (given.reach != 0.0).then_some(given.reach);
        Ok(Self { path, to_path, from, to: copy(mesh)?, reach })
    }

    /// Writes the document of the other mesh.
    ///
    /// # Errors
    /// Fails with `NotFound` or `Io` if the document cannot be read or the other one written, with `Invalid` if it is
    /// damaged, of another mesh or without its points, with `Memory` above the context's memory limit, and with
    /// `Cancelled` if `progress` asks to stop.
    pub fn run(&self, context: &ContextObject, progress: &mut dyn Progress) -> Result<RlvTransferReport> {
        let (executor, path) = (&context.context, &self.path);
        let document = Document::open(Path::new(path), executor.memory_limit())?;
        let options = TransferOptions { reach: self.reach, isolation: None };
        let (made, done) = transfer_watched(executor, &document, self.from.as_ref(), &self.to, &options, progress)
            .map_err(|error| error.at(path.clone()))?;
        // Windows does not replace a file that is open.
        let notes = document.notes.clone();
        drop(document);
        made.write(&self.to_path)?;
        for note in notes.iter().chain(&done.notes) {
            context.log(RLV_LOG_WARNING, &format!("{path}: {note}"));
        }
        let sum = |part: usize| done.layers.iter().map(|(_, areas)| areas[part]).sum();
        Ok(RlvTransferReport {
            struct_size: 0,
            layer_count: done.layers.len() as u32,
            area: done.area[0],
            uncovered_area: done.area[1],
            edited_area: sum(0),
            lost_area: sum(1),
            reach: done.reach,
        })
    }
}

/// Reads what a document is made of, and where it is written to.
///
/// # Errors
/// Fails with `Invalid` if the handle is not alive or the path is no text. What the work refuses, it returns: a detail
/// that is busy, a file that cannot be written, or `Cancelled`.
///
/// # Safety
/// `path` is NULL or a NUL-terminated text.
pub unsafe fn creating(detail: RlvDetail, path: *const c_char, memory: u64) -> Result<Making<RlvDocument>> {
    let detail = registry::get(detail)?;
    // SAFETY: promised by the caller.
    let path = if path.is_null() { None } else { Some(PathBuf::from(unsafe { text("path", path) }?)) };
    Ok(Making::new(detail.context.clone(), move |progress| {
        let mut history = History::new(or_default(memory));
        if let Some(path) = path {
            let document = document_watched(&detail, progress)?;
            history.save(&path, &document)?;
        }
        progress.report(1.0, "write");
        registry::insert(DocumentObject { detail, history: Mutex::new(history) })
    }))
}

/// Reads which document is opened.
///
/// # Errors
/// Fails with `Invalid` if the handle is not alive or the path is no text. What the work refuses, it returns: a detail
/// that is busy, a file that cannot be read, is damaged or of another mesh, or `Cancelled`.
///
/// # Safety
/// As for [`creating`].
pub unsafe fn opening(detail: RlvDetail, path: *const c_char, memory: u64) -> Result<Making<RlvDocument>> {
    let detail = registry::get(detail)?;
    // SAFETY: promised by the caller.
    let path = unsafe { text("path", path) }?.to_owned();
    Ok(Making::new(detail.context.clone(), move |progress| {
        let limit = detail.context.context.memory_limit();
        opened(&detail, &path, || History::open(Path::new(&path), limit, or_default(memory)), progress)
    }))
}

/// Copies the bytes of the document that is opened.
///
/// # Errors
/// As for [`opening`]; and with `Memory` if the bytes are more than the context's memory limit.
///
/// # Safety
/// The caller promises `size` bytes, or NULL if `size` is 0.
pub unsafe fn opening_bytes(
    detail: RlvDetail,
    bytes: *const u8,
    size: usize,
    memory: u64,
) -> Result<Making<RlvDocument>> {
    let detail = registry::get(detail)?;
    let limit = detail.context.context.memory_limit();
    // SAFETY: promised by the caller.
    let bytes = Box::new(Cursor::new(unsafe { bytes::take(bytes, size, limit) }?));
    Ok(Making::new(detail.context.clone(), move |progress| {
        opened(&detail, "bytes", || History::open_in(bytes, limit, or_default(memory)), progress)
    }))
}

/// Reads which document is made bytes of.
///
/// # Errors
/// Fails with `Invalid` if the handle is not alive. What the work refuses, it returns: a document that is busy, or
/// `Cancelled`.
pub fn saving_bytes(document: RlvDocument) -> Result<Making<RlvBytes>> {
    let document = registry::get(document)?;
    Ok(Making::new(document.detail.context.clone(), move |progress| {
        let mut history = document.history()?;
        let made = document_watched(&document.detail, progress)?;
        let bytes = bytes::register(history.to_bytes(&made)?)?;
        progress.report(1.0, "write");
        Ok(bytes)
    }))
}

/// Reads where a document is written to.
///
/// # Errors
/// Fails with `Invalid` if the handle is not alive or the path is no text. What the work refuses, it returns: a
/// document that is busy, a file that cannot be written, or `Cancelled`.
///
/// # Safety
/// As for [`creating`].
pub unsafe fn saving(document: RlvDocument, path: *const c_char) -> Result<Making<()>> {
    let document = registry::get(document)?;
    // SAFETY: promised by the caller.
    let path = PathBuf::from(unsafe { text("path", path) }?);
    Ok(Making::new(document.detail.context.clone(), move |progress| {
        let mut history = document.history()?;
        let made = document_watched(&document.detail, progress)?;
        history.save(&path, &made)?;
        progress.report(1.0, "write");
        Ok(())
    }))
}

/// Reads which file is compacted.
///
/// # Errors
/// Fails with `Invalid` if the handle is not alive or the path is no text. What the work refuses, it returns: a file
/// that cannot be read, is damaged or cannot be replaced, or `Cancelled`.
///
/// # Safety
/// As for [`creating`].
pub unsafe fn compacting(context: RlvContext, path: *const c_char, keep: usize) -> Result<Making<()>> {
    let context = registry::get(context)?;
    // SAFETY: promised by the caller.
    let path = unsafe { text("path", path) }?.to_owned();
    Ok(Making::new(context.clone(), move |progress| {
        progress.step(0.0, "compact")?;
        let done = relievo_document::journal::compact(Path::new(&path), context.context.memory_limit(), keep)?;
        progress.report(1.0, "compact");
        if let Some(note) = done.note {
            context.log(RLV_LOG_WARNING, &format!("{path}: {note}"));
        }
        Ok(())
    }))
}

/// The document that a detail is now, which is about to be written.
fn document_watched(detail: &DetailObject, progress: &mut dyn Progress) -> Result<Document> {
    let editor = detail.edit()?;
    progress.step(0.0, "layers")?;
    let document = document_of(detail, &editor.object)?;
    progress.step(0.5, "write")?;
    Ok(document)
}

entry! {
    fn rlv_document_create(detail: RlvDetail, path: *const c_char, memory: u64, out: *mut RlvDocument) {
        present("out", out)?;
        // SAFETY: the caller gives NULL or a NUL-terminated text.
        let handle = unsafe { creating(detail, path, memory) }?.now()?;
        // SAFETY: checked above.
        unsafe { put(out, handle) };
        Ok(())
    }

    fn rlv_document_open(detail: RlvDetail, path: *const c_char, memory: u64, out: *mut RlvDocument) {
        present("out", out)?;
        // SAFETY: the caller gives a NUL-terminated text.
        let handle = unsafe { opening(detail, path, memory) }?.now()?;
        // SAFETY: checked above.
        unsafe { put(out, handle) };
        Ok(())
    }

    fn rlv_document_create_stream(detail: RlvDetail, stream: *const RlvStream, memory: u64, out: *mut RlvDocument) {
        // SAFETY: the caller gives NULL or a descriptor that starts with its size, with callbacks as the header demands.
        let stream = unsafe { HostStream::read(stream) }?;
        present("out", out)?;
        let detail = registry::get(detail)?;
        let mut history = History::new(or_default(memory));
        let document = document_of(&detail, &detail.edit()?.object)?;
        history.save_in(stream, &document)?;
        let handle = registry::insert(DocumentObject { detail, history: Mutex::new(history) })?;
        // SAFETY: checked above.
        unsafe { put(out, handle) };
        Ok(())
    }

    fn rlv_document_open_stream(detail: RlvDetail, stream: *const RlvStream, memory: u64, out: *mut RlvDocument) {
        // SAFETY: as for `rlv_document_create_stream`.
        let stream = unsafe { HostStream::read(stream) }?;
        present("out", out)?;
        let detail = registry::get(detail)?;
        let limit = detail.context.context.memory_limit();
        let handle = opened(&detail, "stream", || History::open_in(stream, limit, or_default(memory)), &mut Silent)?;
        // SAFETY: checked above.
        unsafe { put(out, handle) };
        Ok(())
    }

    fn rlv_document_open_bytes(
        detail: RlvDetail,
        bytes: *const u8,
        size: usize,
        memory: u64,
        out: *mut RlvDocument,
    ) {
        present("out", out)?;
        // SAFETY: the caller promises `size` bytes.
        let handle = unsafe { opening_bytes(detail, bytes, size, memory) }?.now()?;
        // SAFETY: checked above.
        unsafe { put(out, handle) };
        Ok(())
    }

    fn rlv_document_retain(document: RlvDocument) {
        registry::retain(document)
    }

    fn rlv_document_release(document: RlvDocument) {
        registry::release(document)
    }

    fn rlv_document_info(document: RlvDocument, out: *mut RlvDocumentInfo) {
        let document = registry::get(document)?;
        let history = document.history()?;
        let info = RlvDocumentInfo {
            struct_size: 0,
            is_open: u32::from(history.is_under_way()),
            undo_count: history.undo_count(),
            redo_count: history.redo_count(),
            bytes: history.bytes(),
        };
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        unsafe { write_descriptor(out, info) }
    }

    fn rlv_document_begin(document: RlvDocument, input: *const c_char) {
        // SAFETY: the caller gives NULL or a NUL-terminated text.
        let input = if input.is_null() { "" } else { unsafe { text("input", input) }? };
        // SAFETY: NULL.
        unsafe { work(document, std::ptr::null_mut(), Task::Begin(input)) }
    }

    fn rlv_document_end(document: RlvDocument, changes: *mut RlvDocumentChanges) {
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        unsafe { work(document, changes, Task::End) }
    }

    fn rlv_document_abandon(document: RlvDocument) {
        // SAFETY: NULL.
        unsafe { work(document, std::ptr::null_mut(), Task::Abandon) }
    }

    fn rlv_document_undo(document: RlvDocument, changes: *mut RlvDocumentChanges) {
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        unsafe { work(document, changes, Task::Undo) }
    }

    fn rlv_document_redo(document: RlvDocument, changes: *mut RlvDocumentChanges) {
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        unsafe { work(document, changes, Task::Redo) }
    }

    fn rlv_document_save(document: RlvDocument, path: *const c_char) {
        // SAFETY: the caller gives a NUL-terminated text.
        unsafe { saving(document, path) }?.now()
    }

    fn rlv_document_save_stream(document: RlvDocument, stream: *const RlvStream) {
        // SAFETY: as for `rlv_document_create_stream`.
        let stream = unsafe { HostStream::read(stream) }?;
        let document = registry::get(document)?;
        let mut history = document.history()?;
        let made = document_of(&document.detail, &document.detail.edit()?.object)?;
        history.save_in(stream, &made)
    }

    fn rlv_document_save_bytes(document: RlvDocument, out: *mut RlvBytes) {
        present("out", out)?;
        let made = saving_bytes(document)?.now()?;
        // SAFETY: checked above.
        unsafe { put(out, made) };
        Ok(())
    }

    fn rlv_document_sync(document: RlvDocument) {
        registry::get(document)?.history()?.sync()
    }

    fn rlv_document_compact(context: RlvContext, path: *const c_char, keep: usize) {
        // SAFETY: the caller gives a NUL-terminated text.
        unsafe { compacting(context, path, keep) }?.now()
    }

    fn rlv_document_mesh(context: RlvContext, path: *const c_char, out: *mut RlvMesh) {
        present("out", out)?;
        let context = registry::get(context)?;
        // SAFETY: the caller gives a NUL-terminated text.
        let path = unsafe { text("path", path) }?;
        let document = Document::open(Path::new(path), context.context.memory_limit())?;
        let mesh = mesh_of(&document).map_err(|error| error.at(path))?;
        let handle = mesh::register(context, mesh)?;
        // SAFETY: checked above.
        unsafe { put(out, handle) };
        Ok(())
    }

    fn rlv_document_mesh_bytes(context: RlvContext, bytes: *const u8, size: usize, out: *mut RlvMesh) {
        present("out", out)?;
        let context = registry::get(context)?;
        let limit = context.context.memory_limit();
        // SAFETY: the caller promises `size` bytes.
        let bytes = unsafe { bytes::take(bytes, size, limit) }?;
        let mesh = Document::parse(&bytes, limit).and_then(|document| mesh_of(&document)).map_err(|error| error.at("bytes"))?;
        let handle = mesh::register(context, mesh)?;
        // SAFETY: checked above.
        unsafe { put(out, handle) };
        Ok(())
    }

    fn rlv_document_transfer(
        context: RlvContext,
        mesh: RlvMesh,
        path: *const c_char,
        to_path: *const c_char,
        options: *const RlvTransferOptions,
        progress: RlvProgress,
        user: *mut c_void,
        report: *mut RlvTransferReport,
    ) {
        let context = registry::get(context)?;
        // SAFETY: the caller gives NUL-terminated texts, and NULL or descriptors that start with their size.
        let transfer = unsafe {
            check_optional(report)?;
            Transfer::read(mesh, path, to_path, options)?
        };
        let done = transfer.run(&context, &mut HostProgress { callback: progress, user })?;
        // SAFETY: as above.
        unsafe { write_optional(report, done) }
    }
}

/// A history that is not ended is given up: what its edit did stays, unrecorded, as if the program had been killed.
impl Drop for DocumentObject {
    fn drop(&mut self) {
        if let Ok(history) = self.history.get_mut() {
            // Nobody is left to be told.
            let _ = history.sync();
        }
    }
}
