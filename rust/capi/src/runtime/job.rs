//! Jobs: long calls on a thread of their own; see `include/relievo/job.h`.
//!
//! A call that runs as a job tells its progress as any other. The first word of it says that it has all that it needs for
//! itself, and is what the function that starts it waits for: so what can be refused is refused there.

mod product;

use std::ffi::{c_char, c_void};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;

use relievo_core::{Error, ErrorKind, Progress, Result};
use relievo_detail::Pose;

use crate::border::array::{fixed, present, put};
use crate::border::caught;
use crate::border::descriptor::{Descriptor, check_optional, write_descriptor, write_optional};
use crate::border::log::{self, Queue};
use crate::border::making::Making;
use crate::border::registry::{self, Handle, handle};
use crate::border::work::{self, busy};
use crate::details::bake::{self, RlvBakeOptions, RlvBakeReport};
use crate::details::collider::{self, RlvCollider};
use crate::details::decal::{Laying, RlvDecal, RlvDecalOptions, RlvDecalPin};
use crate::details::detail::{RlvDetail, transform};
use crate::details::document::{self, RlvDocument, RlvTransferOptions, RlvTransferReport, Transfer};
use crate::details::imprint::{self, RlvImprintMoment, RlvImprintReport, RlvImprintSettings};
use crate::details::object::duration;
use crate::levels::progressive::{self, Build, RlvProgressive, RlvProgressiveOptions};
use crate::levels::simplify::{RlvSimplifyOptions, Simplification};
use crate::runtime::bytes::RlvBytes;
use crate::runtime::context::{ContextObject, RLV_NAME_SIZE, RlvContext};
use crate::runtime::error::{RLV_OK, RlvResult, result_of};
use crate::scenery::crowd::{
    self, CrowdBuild, CrowdRefit, RlvCrowdBuildSettings, RlvCrowdClipName, RlvCrowdModel, RlvCrowdRefitReport,
};
use crate::scenery::picture::{self, RlvPicture};
use crate::simulation::client::{ClientJob, RlvClient, RlvClientFetch, RlvClientScene, RlvClientStatus};
use crate::simulation::fluid::{RlvFluid, RlvFluidReport};
use crate::simulation::isosurface::{Meshing, RlvIsosurface, RlvIsosurfaceMeshOptions};
use crate::simulation::particles::{self, RlvParticles};
use crate::simulation::tissue::{
    self, Building, RlvTissue, RlvTissueDescription, RlvTissueReport, RlvTissueSimulation,
};
use crate::surfaces::caster::{self, RlvCaster};
use crate::surfaces::grid::{self, RlvGrid, RlvGridSettings};
use crate::surfaces::mesh::{self, RlvMesh};
use crate::surfaces::procedural::{self, RlvProcedural, RlvProceduralOptions};
use crate::surfaces::ptex::{Export, Import, RlvPtexOptions, RlvPtexReport};
use crate::surfaces::repair::{RepairJob, RlvRepairReport, RlvRepairSettings};
use crate::surfaces::surface::{self, RlvSurface, RlvSurfaceOptions};
use crate::surfaces::tessellate::{self, RlvTessellateOptions, RlvTessellation};
use product::Product;

handle!(RlvJob, 13, JobObject);

constants! {
    u32:
    RLV_JOB_RUNNING = 0,
    RLV_JOB_DONE = 1,
    RLV_JOB_FAILED = 2,
    RLV_JOB_CANCELLED = 3,
    RLV_JOB_KIND_NONE = 0,
    RLV_JOB_KIND_MESH = 1,
    RLV_JOB_KIND_PROGRESSIVE = 2,
    RLV_JOB_KIND_GRID = 3,
    RLV_JOB_KIND_DECAL = 4,
    RLV_JOB_KIND_CROWD_MODEL = 5,
    RLV_JOB_KIND_TISSUE = 6,
    RLV_JOB_KIND_PARTICLES = 7,
    RLV_JOB_KIND_SURFACE = 8,
    RLV_JOB_KIND_CASTER = 9,
    RLV_JOB_KIND_PROCEDURAL = 10,
    RLV_JOB_KIND_COLLIDER = 11,
    RLV_JOB_KIND_PICTURE = 12,
    RLV_JOB_KIND_DOCUMENT = 13,
    RLV_JOB_KIND_IMPRINT_REPORT = 14,
    RLV_JOB_KIND_BAKE_REPORT = 15,
    RLV_JOB_KIND_PTEX_REPORT = 16,
    RLV_JOB_KIND_TRANSFER_REPORT = 17,
    RLV_JOB_KIND_FLUID_REPORT = 18,
    RLV_JOB_KIND_CLIENT_STATUS = 19,
    RLV_JOB_KIND_BYTES = 20,
}

descriptor! {
    pub struct RlvJobInfo {
        struct_size: u32,
        state: u32,
        result: RlvResult,
        fraction: f32,
        stage: [u8; RLV_NAME_SIZE as usize],
        kind: u32,
    }
}

/// How far a job is.
#[derive(Default)]
struct State {
    /// Whether it has what it needs for itself.
    begun: bool,
    fraction: f32,
    stage: String,
    ended: Option<Result<Product>>,
    notice: Option<Notice>,
}

/// `RlvJobDone`: NULL, or a function that gets its user pointer.
pub type RlvJobDone = Option<unsafe extern "C" fn(*mut c_void)>;

/// What the host is called with when a job ends.
struct Notice {
    callback: unsafe extern "C" fn(*mut c_void),
    user: *mut c_void,
}

// SAFETY: the pointer is only handed back to its owner's function, which the header says runs on the job's thread.
unsafe impl Send for Notice {}

impl Notice {
    fn send(&self) {
        // SAFETY: the host gave this function for this pointer.
        unsafe { (self.callback)(self.user) };
    }
}

/// What a job shares with its thread.
#[derive(Default)]
struct Shared {
    /// What the job makes: one of the `RLV_JOB_KIND_` values.
    kind: u32,
    state: Mutex<State>,
    changed: Condvar,
    cancelled: AtomicBool,
    /// Messages that wait until the host asks for the job.
    messages: Arc<Queue>,
}

impl Shared {
    // The state is whole after every statement.
    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn wait<'a>(&self, state: MutexGuard<'a, State>, until: impl Fn(&State) -> bool) -> MutexGuard<'a, State> {
        self.changed.wait_while(state, |state| !until(state)).unwrap_or_else(PoisonError::into_inner)
    }
}

/// The progress of a job.
struct JobProgress(Arc<Shared>);

impl Progress for JobProgress {
    fn report(&mut self, fraction: f32, stage: &str) -> bool {
        let mut state = self.0.state();
        state.fraction = fraction;
        state.stage.clear();
        state.stage.push_str(stage);
        if !state.begun {
            state.begun = true;
            self.0.changed.notify_all();
        }
        !self.0.cancelled.load(Ordering::Relaxed)
    }
}

pub struct JobObject {
    context: Arc<ContextObject>,
    shared: Arc<Shared>,
    thread: Mutex<Option<JoinHandle<()>>>,
}

impl Drop for JobObject {
    fn drop(&mut self) {
        self.shared.cancelled.store(true, Ordering::Relaxed);
    }
}

impl JobObject {
    /// Waits, no longer than `time` if there is one, and says how far the job is.
    fn wait(&self, time: Option<Duration>) -> RlvJobInfo {
        let state = self.shared.state();
        let state = match time {
            None => self.shared.wait(state, |state| state.ended.is_some()),
            Some(time) => {
                let waited = self.shared.changed.wait_timeout_while(state, time, |state| state.ended.is_none());
                waited.unwrap_or_else(PoisonError::into_inner).0
            }
        };
        let (number, result) = match &state.ended {
            None => (RLV_JOB_RUNNING, RLV_OK),
            Some(Ok(_)) => (RLV_JOB_DONE, RLV_OK),
            Some(Err(error)) if error.kind == ErrorKind::Cancelled => (RLV_JOB_CANCELLED, result_of(error.kind)),
            Some(Err(error)) => (RLV_JOB_FAILED, result_of(error.kind)),
        };
        let (fraction, stage) = (state.fraction, fixed(&state.stage));
        let messages = self.shared.messages.take();
        drop(state);
        if number != RLV_JOB_RUNNING {
            let thread = self.thread.lock().unwrap_or_else(PoisonError::into_inner).take();
            // It has nothing left to do; a panic of it was caught. What is called when it ends may ask on that thread.
            thread.filter(|thread| thread.thread().id() != std::thread::current().id()).map(JoinHandle::join);
        }
        // The host's callback may ask for the job again.
        messages.iter().for_each(|(level, text)| self.context.log(*level, text));
        RlvJobInfo { struct_size: 0, state: number, result, fraction, stage, kind: self.shared.kind }
    }

    /// What the job made, taken out by `take`, which knows it as `what`.
    fn product<T>(&self, what: &str, take: impl FnOnce(&Product) -> Option<T>) -> Result<T> {
        match &self.shared.state().ended {
            None => Err(still_running()),
            Some(Err(error)) => Err(error.clone()),
            Some(Ok(product)) => {
                take(product).ok_or_else(|| Error::invalid(format!("the job was not started for {what}")).at("job"))
            }
        }
    }
}

fn still_running() -> Error {
    Error { remedy: "wait for it with rlv_job_wait".into(), ..busy("job", None) }
}

/// Starts `call` on a thread of its own, or of the host. Returns when it has reported progress for the first time, or
/// ended, and what fails before that fails here; on a thread of the host it returns at once.
fn start(
    context: &Arc<ContextObject>,
    kind: u32,
    call: impl FnOnce(&mut dyn Progress) -> Result<Product> + Send + 'static,
) -> Result<RlvJob> {
    let shared = Arc::new(Shared { kind, ..Shared::default() });
    let inside = Arc::clone(&shared);
    let function = work::function();
    let run = move || {
        let job = || caught(|| call(&mut JobProgress(Arc::clone(&inside)))?.checked(kind));
        let ended = work::named(function, || log::collect(&inside.messages, job));
        let mut state = inside.state();
        state.ended = Some(ended);
        let notice = state.notice.take();
        drop(state);
        inside.changed.notify_all();
        notice.iter().for_each(Notice::send);
    };
    let object =
        |thread| JobObject { context: Arc::clone(context), shared: Arc::clone(&shared), thread: Mutex::new(thread) };
    if let Some(spawn) = context.spawn {
        // The host may begin it when this call has returned, so nothing is waited for here.
        let job = registry::insert(object(None))?;
        spawn.begin(Box::new(run));
        return Ok(job);
    }
    let thread = std::thread::Builder::new().name("relievo-job".into()).spawn(run).map_err(|error| {
        Error::memory(format!("the system gives no thread: {error}")).advise("wait for other jobs first")
    })?;
    let state = shared.wait(shared.state(), |state| state.begun || state.ended.is_some());
    let refused = match &state.ended {
        Some(Err(error)) if !state.begun => Some(error.clone()),
        _ => None,
    };
    if let Some(error) = refused {
        drop(state);
        // It has nothing left to do.
        let _ = thread.join();
        return Err(error);
    }
    drop(state);
    registry::insert(object(Some(thread)))
}

/// Starts what makes an object, or nothing but a file; `wrap` makes a product of it.
///
/// # Safety
/// `out` is NULL or valid for a write.
unsafe fn launch<T: 'static>(
    out: *mut RlvJob,
    kind: u32,
    wrap: fn(T) -> Product,
    read: impl FnOnce() -> Result<Making<T>>,
) -> Result<()> {
    present("out", out)?;
    let making = read()?;
    let job = start(&making.context().clone(), kind, move |progress| making.watched(progress).map(wrap))?;
    // SAFETY: checked above.
    unsafe { put(out, job) };
    Ok(())
}

/// Gives a reference to the object that a job made, which `find` takes from its product and messages call `what`.
///
/// # Safety
/// `out` is NULL or valid for a write.
unsafe fn give<H: Handle>(
    job: RlvJob,
    out: *mut H,
    what: &str,
    find: impl FnOnce(&Product) -> Option<H>,
) -> Result<()> {
    present("out", out)?;
    let made = registry::get(job)?.product(what, find)?;
    registry::retain(made)?;
    // SAFETY: checked above.
    unsafe { put(out, made) };
    Ok(())
}

/// Writes a report on what a job made, which `find` takes from its product and messages call `what`.
///
/// # Safety
/// `out` is NULL or a descriptor that starts with its size.
unsafe fn describe<D: Descriptor>(
    job: RlvJob,
    out: *mut D,
    what: &str,
    find: impl FnOnce(&Product) -> Option<D>,
) -> Result<()> {
    let report = registry::get(job)?.product(what, find)?;
    // SAFETY: promised by the caller.
    unsafe { write_descriptor(out, report) }
}

/// Makes a function that copies the value out of a product of one kind.
macro_rules! taken {
    ($kind:ident) => {
        |product: &Product| match product {
            Product::$kind(made, ..) => Some(*made),
            _ => None,
        }
    };
}

/// Starts what makes a grid.
fn start_grid(work: grid::Work) -> Result<RlvJob> {
    start(&work.context().clone(), RLV_JOB_KIND_GRID, move |progress| work.run(progress).map(Product::Grid))
}

/// Starts what lays a sticker.
fn start_decal(laying: Laying) -> Result<RlvJob> {
    start(&laying.context().clone(), RLV_JOB_KIND_DECAL, move |progress| laying.run(progress).map(Product::Decal))
}

/// Starts a call of a client.
fn start_client(kind: u32, job: ClientJob) -> Result<RlvJob> {
    start(&job.context().clone(), kind, move |progress| job.run(progress).map(Product::from))
}

entry! {
    fn rlv_job_tessellate(detail: RlvDetail, options: *const RlvTessellateOptions, out: *mut RlvJob) {
        present("out", out)?;
        let detail = registry::get(detail)?;
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        let options = unsafe { tessellate::Cells::new(options) }?;
        let (context, view) = (detail.context.clone(), detail.view());
        let job = start(&context.clone(), RLV_JOB_KIND_MESH, move |progress| {
            progress.step(0.0, "tessellate")?;
            // A product is released where the job is cancelled.
            let made = Product::Mesh(tessellate::tessellate_committed(&context, &view, options, progress)?);
            progress.step(1.0, "tessellate")?;
            Ok(made)
        })?;
        // SAFETY: checked above.
        unsafe { put(out, job) };
        Ok(())
    }

    fn rlv_job_sweep(
        detail: RlvDetail,
        collider: RlvCollider,
        from: *const f64,
        to: *const f64,
        settings: *const RlvImprintSettings,
        moment: *const RlvImprintMoment,
        out: *mut RlvJob,
    ) {
        present("out", out)?;
        let (detail, collider) = (registry::get(detail)?, registry::get(collider)?);
        // SAFETY: the caller gives NULL or twelve doubles.
        let poses = unsafe { [Pose::rigid(transform(from)?), Pose::rigid(transform(to)?)] };
        // SAFETY: the caller gives NULL or descriptors that start with their size.
        let how = unsafe { imprint::how(settings, moment) }?;
        let job = start(&detail.context.clone(), RLV_JOB_KIND_IMPRINT_REPORT, move |progress| {
            imprint::sweep(&detail, &collider, poses, &how, progress).map(Product::Imprint)
        })?;
        // SAFETY: checked above.
        unsafe { put(out, job) };
        Ok(())
    }

    fn rlv_job_sweep_points(
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
        out: *mut RlvJob,
    ) {
        present("out", out)?;
        let (detail, collider) = (registry::get(detail)?, registry::get(collider)?);
        // SAFETY: the caller gives NULL or twelve doubles, `count` points, and NULL or descriptors that start with their
        // size.
        let (poses, how) = unsafe {
            let poses = imprint::poses_of(&collider, [from, to], [from_points, to_points], count, stride)?;
            (poses, imprint::how(settings, moment)?)
        };
        let job = start(&detail.context.clone(), RLV_JOB_KIND_IMPRINT_REPORT, move |progress| {
            imprint::sweep(&detail, &collider, poses, &how, progress).map(Product::Imprint)
        })?;
        // SAFETY: checked above.
        unsafe { put(out, job) };
        Ok(())
    }

    fn rlv_job_bake(detail: RlvDetail, options: *const RlvBakeOptions, path: *const c_char, out: *mut RlvJob) {
        present("out", out)?;
        let detail = registry::get(detail)?;
        // SAFETY: the caller gives a NUL-terminated text, and NULL or a descriptor that starts with its size.
        let order = unsafe { bake::Order::read(options, path) }?;
        let (context, view) = (detail.context.clone(), detail.view());
        let job = start(&context.clone(), RLV_JOB_KIND_BAKE_REPORT, move |progress| {
            order.write(&context.context, &view, progress).map(Product::Bake)
        })?;
        // SAFETY: checked above.
        unsafe { put(out, job) };
        Ok(())
    }

    fn rlv_job_ptex_write(detail: RlvDetail, channel: u32, path: *const c_char, out: *mut RlvJob) {
        present("out", out)?;
        let detail = registry::get(detail)?;
        // SAFETY: the caller gives a NUL-terminated text.
        let export = unsafe { Export::read(&detail, channel, path) }?;
        let job = start(&detail.context.clone(), RLV_JOB_KIND_NONE, move |progress| {
            export.write(&detail.context.context, progress).map(|()| Product::File)
        })?;
        // SAFETY: checked above.
        unsafe { put(out, job) };
        Ok(())
    }

    fn rlv_job_ptex_read(detail: RlvDetail, path: *const c_char, options: *const RlvPtexOptions, out: *mut RlvJob) {
        present("out", out)?;
        let detail = registry::get(detail)?;
        // SAFETY: the caller gives a NUL-terminated text, and NULL or a descriptor that starts with its size.
        let import = unsafe { Import::read(path, options) }?;
        let job = start(&detail.context.clone(), RLV_JOB_KIND_PTEX_REPORT, move |progress| {
            import.take_up(&detail, progress).map(Product::Ptex)
        })?;
        // SAFETY: checked above.
        unsafe { put(out, job) };
        Ok(())
    }

    fn rlv_job_transfer(
        context: RlvContext,
        mesh: RlvMesh,
        path: *const c_char,
        to_path: *const c_char,
        options: *const RlvTransferOptions,
        out: *mut RlvJob,
    ) {
        present("out", out)?;
        let context = registry::get(context)?;
        // SAFETY: the caller gives NUL-terminated texts, and NULL or a descriptor that starts with its size.
        let transfer = unsafe { Transfer::read(mesh, path, to_path, options) }?;
        let job = start(&context.clone(), RLV_JOB_KIND_TRANSFER_REPORT, move |progress| {
            transfer.run(&context, progress).map(Product::Transfer)
        })?;
        // SAFETY: checked above.
        unsafe { put(out, job) };
        Ok(())
    }

    fn rlv_job_progressive(mesh: RlvMesh, options: *const RlvProgressiveOptions, out: *mut RlvJob) {
        present("out", out)?;
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        let build = unsafe { Build::read(mesh, options) }?;
        let job = start(&build.context().clone(), RLV_JOB_KIND_PROGRESSIVE, move |progress| build.run(progress).map(Product::Progressive))?;
        // SAFETY: checked above.
        unsafe { put(out, job) };
        Ok(())
    }

    fn rlv_job_simplify(mesh: RlvMesh, options: *const RlvSimplifyOptions, out: *mut RlvJob) {
        present("out", out)?;
        // SAFETY: the caller gives NULL or a descriptor that starts with its size, with arrays of their counts.
        let simplification = unsafe { Simplification::read(mesh, options) }?;
        let job = start(&simplification.context().clone(), RLV_JOB_KIND_MESH, move |progress| {
            simplification.run(progress).map(|(mesh, error)| Product::Simplified(mesh, error))
        })?;
        // SAFETY: checked above.
        unsafe { put(out, job) };
        Ok(())
    }

    fn rlv_job_repair(mesh: RlvMesh, settings: *const RlvRepairSettings, out: *mut RlvJob) {
        present("out", out)?;
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        let repair = unsafe { RepairJob::read(mesh, settings) }?;
        let job = start(&repair.context().clone(), RLV_JOB_KIND_MESH, move |progress| {
            repair.run(progress).map(|(mesh, report)| Product::Repaired(mesh, Box::new(report)))
        })?;
        // SAFETY: checked above.
        unsafe { put(out, job) };
        Ok(())
    }

    fn rlv_job_isosurface(isosurface: RlvIsosurface, options: *const RlvIsosurfaceMeshOptions, out: *mut RlvJob) {
        present("out", out)?;
        // SAFETY: the caller gives NULL or a descriptor that starts with its size, with channels of their counts.
        let meshing = unsafe { Meshing::read(isosurface, options) }?;
        let job = start(&meshing.context().clone(), RLV_JOB_KIND_MESH, move |progress| meshing.run(progress).map(Product::Mesh))?;
        // SAFETY: checked above.
        unsafe { put(out, job) };
        Ok(())
    }

    fn rlv_job_grid_read(
        context: RlvContext,
        path: *const c_char,
        name: *const c_char,
        bounds: *const f64,
        out: *mut RlvJob,
    ) {
        present("out", out)?;
        // SAFETY: the caller gives NULL or NUL-terminated texts, and NULL or six numbers.
        let work = unsafe { grid::Work::reading(context, path, name, bounds) }?;
        let job = start_grid(work)?;
        // SAFETY: checked above.
        unsafe { put(out, job) };
        Ok(())
    }

    fn rlv_job_grid_from_mesh(mesh: RlvMesh, settings: *const RlvGridSettings, out: *mut RlvJob) {
        present("out", out)?;
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        let job = start_grid(unsafe { grid::from_mesh(mesh, settings) }?)?;
        // SAFETY: checked above.
        unsafe { put(out, job) };
        Ok(())
    }

    fn rlv_job_grid_change(grid: RlvGrid, change: u32, settings: *const RlvGridSettings, out: *mut RlvJob) {
        present("out", out)?;
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        let job = start_grid(unsafe { grid::changing(grid, change, settings) }?)?;
        // SAFETY: checked above.
        unsafe { put(out, job) };
        Ok(())
    }

    fn rlv_job_grid_mesh(grid: RlvGrid, settings: *const RlvGridSettings, out: *mut RlvJob) {
        present("out", out)?;
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        let meshing = unsafe { grid::Meshing::read(grid, settings) }?;
        let job = start(&meshing.context().clone(), RLV_JOB_KIND_MESH, move |progress| meshing.run(progress).map(Product::Mesh))?;
        // SAFETY: checked above.
        unsafe { put(out, job) };
        Ok(())
    }

    fn rlv_job_decal_on_mesh(
        mesh: RlvMesh,
        options: *const RlvDecalOptions,
        pins: *const RlvDecalPin,
        count: usize,
        stride: usize,
        out: *mut RlvJob,
    ) {
        present("out", out)?;
        // SAFETY: the caller gives NULL or a descriptor that starts with its size, and `count` pins.
        let job = start_decal(unsafe { Laying::on_mesh(mesh, options, pins, count, stride) }?)?;
        // SAFETY: checked above.
        unsafe { put(out, job) };
        Ok(())
    }

    fn rlv_job_decal_on_detail(
        detail: RlvDetail,
        options: *const RlvDecalOptions,
        pins: *const RlvDecalPin,
        count: usize,
        stride: usize,
        out: *mut RlvJob,
    ) {
        present("out", out)?;
        // SAFETY: the caller gives NULL or a descriptor that starts with its size, and `count` pins.
        let job = start_decal(unsafe { Laying::on_detail(detail, options, pins, count, stride) }?)?;
        // SAFETY: checked above.
        unsafe { put(out, job) };
        Ok(())
    }

    fn rlv_job_crowd(
        context: RlvContext,
        path: *const c_char,
        clips: *const RlvCrowdClipName,
        clip_count: usize,
        settings: *const RlvCrowdBuildSettings,
        out: *mut RlvJob,
    ) {
        present("out", out)?;
        // SAFETY: the caller gives NUL-terminated texts, and NULL or a descriptor that starts with its size.
        let build = unsafe { CrowdBuild::read(registry::get(context)?, path, clips, clip_count, settings) }?;
        let job = start(&build.context().clone(), RLV_JOB_KIND_CROWD_MODEL, move |progress| {
            build.run(progress).map(|model| Product::Crowd(model, None))
        })?;
        // SAFETY: checked above.
        unsafe { put(out, job) };
        Ok(())
    }

    fn rlv_job_crowd_refit(
        model: RlvCrowdModel,
        path: *const c_char,
        clips: *const RlvCrowdClipName,
        clip_count: usize,
        settings: *const RlvCrowdBuildSettings,
        out: *mut RlvJob,
    ) {
        present("out", out)?;
        // SAFETY: the caller gives NUL-terminated texts, and NULL or a descriptor that starts with its size.
        let refit = unsafe { CrowdRefit::read(model, path, clips, clip_count, settings) }?;
        let job = start(&refit.context().clone(), RLV_JOB_KIND_CROWD_MODEL, move |progress| {
            refit.run(progress).map(|(model, report)| Product::Crowd(model, Some(report)))
        })?;
        // SAFETY: checked above.
        unsafe { put(out, job) };
        Ok(())
    }

    fn rlv_job_crowd_model_with_blend(model: RlvCrowdModel, blend: u32, out: *mut RlvJob) {
        let made = |model| Product::Crowd(model, None);
        // SAFETY: the caller gives NULL or room for a handle.
        unsafe { launch(out, RLV_JOB_KIND_CROWD_MODEL, made, || crowd::blending(model, blend)) }
    }

    fn rlv_job_fluid(fluid: RlvFluid, seconds: f64, out: *mut RlvJob) {
        present("out", out)?;
        let fluid = registry::get(fluid)?;
        let job = start(&fluid.context.clone(), RLV_JOB_KIND_FLUID_REPORT, move |progress| fluid.advance(seconds, progress).map(Product::Fluid))?;
        // SAFETY: checked above.
        unsafe { put(out, job) };
        Ok(())
    }

    fn rlv_job_client_submit(client: RlvClient, scene: *const RlvClientScene, out: *mut RlvJob) {
        present("out", out)?;
        // SAFETY: the caller gives NULL or a descriptor whose texts and files are as the header demands.
        let job = start_client(RLV_JOB_KIND_CLIENT_STATUS, unsafe { ClientJob::submit(client, scene) }?)?;
        // SAFETY: checked above.
        unsafe { put(out, job) };
        Ok(())
    }

    fn rlv_job_client_fetch(
        client: RlvClient,
        scene: *const c_char,
        frame: u64,
        fetch: *const RlvClientFetch,
        out: *mut RlvJob,
    ) {
        present("out", out)?;
        // SAFETY: the caller gives NULL or a NUL-terminated text, and NULL or a descriptor as the header demands.
        let job = start_client(RLV_JOB_KIND_PARTICLES, unsafe { ClientJob::fetch(client, scene, frame, fetch) }?)?;
        // SAFETY: checked above.
        unsafe { put(out, job) };
        Ok(())
    }

    fn rlv_job_client_fetch_mesh(
        client: RlvClient,
        scene: *const c_char,
        frame: u64,
        settings: *const c_char,
        out: *mut RlvJob,
    ) {
        present("out", out)?;
        // SAFETY: the caller gives NULL or NUL-terminated texts.
        let job = start_client(RLV_JOB_KIND_MESH, unsafe { ClientJob::mesh(client, scene, frame, settings) }?)?;
        // SAFETY: checked above.
        unsafe { put(out, job) };
        Ok(())
    }

    fn rlv_job_surface_create(context: RlvContext, cage: RlvMesh, options: *const RlvSurfaceOptions, out: *mut RlvJob) {
        // SAFETY: the caller gives what the header demands.
        unsafe { launch(out, RLV_JOB_KIND_SURFACE, Product::Surface, || surface::create(context, cage, options)) }
    }

    fn rlv_job_caster_create_mesh(context: RlvContext, mesh: RlvMesh, out: *mut RlvJob) {
        // SAFETY: the caller gives what the header demands.
        unsafe { launch(out, RLV_JOB_KIND_CASTER, Product::Caster, || caster::of_mesh(context, mesh)) }
    }

    fn rlv_job_caster_create_detail(detail: RlvDetail, options: *const RlvTessellateOptions, out: *mut RlvJob) {
        // SAFETY: the caller gives what the header demands.
        unsafe { launch(out, RLV_JOB_KIND_CASTER, Product::Caster, || caster::of_detail(detail, options)) }
    }

    fn rlv_job_caster_create_tessellation(tessellation: RlvTessellation, out: *mut RlvJob) {
        // SAFETY: the caller gives what the header demands.
        unsafe { launch(out, RLV_JOB_KIND_CASTER, Product::Caster, || caster::of_tessellation(tessellation)) }
    }

    fn rlv_job_procedural_create(detail: RlvDetail, options: *const RlvProceduralOptions, out: *mut RlvJob) {
        // SAFETY: the caller gives what the header demands.
        unsafe { launch(out, RLV_JOB_KIND_PROCEDURAL, Product::Procedural, || procedural::create(detail, options)) }
    }

    fn rlv_job_procedural_create_moving(begin: RlvProcedural, end: RlvDetail, out: *mut RlvJob) {
        // SAFETY: the caller gives what the header demands.
        unsafe { launch(out, RLV_JOB_KIND_PROCEDURAL, Product::Procedural, || procedural::create_moving(begin, end)) }
    }

    fn rlv_job_collider_create_mesh(context: RlvContext, mesh: RlvMesh, matrix: *const f64, out: *mut RlvJob) {
        // SAFETY: the caller gives what the header demands.
        unsafe { launch(out, RLV_JOB_KIND_COLLIDER, Product::Collider, || collider::of_mesh(context, mesh, matrix)) }
    }

    fn rlv_job_collider_create_surface(surface: RlvSurface, options: *const RlvTessellateOptions, matrix: *const f64, out: *mut RlvJob) {
        // SAFETY: the caller gives what the header demands.
        unsafe { launch(out, RLV_JOB_KIND_COLLIDER, Product::Collider, || collider::of_surface(surface, options, matrix)) }
    }

    fn rlv_job_collider_create_detail(detail: RlvDetail, options: *const RlvTessellateOptions, out: *mut RlvJob) {
        // SAFETY: the caller gives what the header demands.
        unsafe { launch(out, RLV_JOB_KIND_COLLIDER, Product::Collider, || collider::of_detail(detail, options)) }
    }

    fn rlv_job_mesh_read(context: RlvContext, path: *const c_char, out: *mut RlvJob) {
        // SAFETY: the caller gives what the header demands.
        unsafe { launch(out, RLV_JOB_KIND_MESH, Product::Mesh, || mesh::reading(context, path)) }
    }

    fn rlv_job_mesh_write(mesh: RlvMesh, path: *const c_char, out: *mut RlvJob) {
        // SAFETY: the caller gives what the header demands.
        unsafe { launch(out, RLV_JOB_KIND_NONE, |()| Product::File, || mesh::writing(mesh, path)) }
    }

    fn rlv_job_particles_read(context: RlvContext, path: *const c_char, out: *mut RlvJob) {
        // SAFETY: the caller gives what the header demands.
        unsafe { launch(out, RLV_JOB_KIND_PARTICLES, Product::Particles, || particles::reading(context, path)) }
    }

    fn rlv_job_particles_write(particles: RlvParticles, path: *const c_char, out: *mut RlvJob) {
        // SAFETY: the caller gives what the header demands.
        unsafe { launch(out, RLV_JOB_KIND_NONE, |()| Product::File, || particles::writing(particles, path)) }
    }

    fn rlv_job_progressive_read(context: RlvContext, path: *const c_char, triangles: usize, out: *mut RlvJob) {
        // SAFETY: the caller gives what the header demands.
        unsafe { launch(out, RLV_JOB_KIND_PROGRESSIVE, Product::Progressive, || progressive::reading(context, path, triangles)) }
    }

    fn rlv_job_progressive_write(progressive: RlvProgressive, path: *const c_char, out: *mut RlvJob) {
        // SAFETY: the caller gives what the header demands.
        unsafe { launch(out, RLV_JOB_KIND_NONE, |()| Product::File, || progressive::writing(progressive, path)) }
    }

    fn rlv_job_crowd_model_read(context: RlvContext, path: *const c_char, out: *mut RlvJob) {
        // SAFETY: the caller gives what the header demands.
        unsafe {
            launch(
                out,
                RLV_JOB_KIND_CROWD_MODEL,
                |model| Product::Crowd(model, None),
                || crowd::reading(context, path),
            )
        }
    }

    fn rlv_job_crowd_model_write(model: RlvCrowdModel, path: *const c_char, out: *mut RlvJob) {
        // SAFETY: the caller gives what the header demands.
        unsafe { launch(out, RLV_JOB_KIND_NONE, |()| Product::File, || crowd::writing(model, path)) }
    }

    fn rlv_job_tissue_read(context: RlvContext, path: *const c_char, out: *mut RlvJob) {
        // SAFETY: the caller gives what the header demands.
        unsafe { launch(out, RLV_JOB_KIND_TISSUE, |made| Product::Tissue(made, None), || tissue::reading(context, path)) }
    }

    fn rlv_job_tissue_write(tissue: RlvTissue, path: *const c_char, out: *mut RlvJob) {
        // SAFETY: the caller gives what the header demands.
        unsafe { launch(out, RLV_JOB_KIND_NONE, |()| Product::File, || tissue::writing(tissue, path)) }
    }

    fn rlv_job_grid_write(grids: *const RlvGrid, count: usize, path: *const c_char, writing: u32, out: *mut RlvJob) {
        // SAFETY: the caller gives what the header demands.
        unsafe { launch(out, RLV_JOB_KIND_NONE, |()| Product::File, || grid::writing(grids, count, path, writing)) }
    }

    fn rlv_job_picture_open(context: RlvContext, path: *const c_char, out: *mut RlvJob) {
        // SAFETY: the caller gives what the header demands.
        unsafe { launch(out, RLV_JOB_KIND_PICTURE, Product::Picture, || picture::opening(context, path)) }
    }

    fn rlv_job_document_create(detail: RlvDetail, path: *const c_char, memory: u64, out: *mut RlvJob) {
        // SAFETY: the caller gives what the header demands.
        unsafe { launch(out, RLV_JOB_KIND_DOCUMENT, Product::Document, || document::creating(detail, path, memory)) }
    }

    fn rlv_job_document_open(detail: RlvDetail, path: *const c_char, memory: u64, out: *mut RlvJob) {
        // SAFETY: the caller gives what the header demands.
        unsafe { launch(out, RLV_JOB_KIND_DOCUMENT, Product::Document, || document::opening(detail, path, memory)) }
    }

    fn rlv_job_document_open_bytes(detail: RlvDetail, bytes: *const u8, size: usize, memory: u64, out: *mut RlvJob) {
        // SAFETY: the caller gives what the header demands.
        unsafe { launch(out, RLV_JOB_KIND_DOCUMENT, Product::Document, || document::opening_bytes(detail, bytes, size, memory)) }
    }

    fn rlv_job_document_save_bytes(document: RlvDocument, out: *mut RlvJob) {
        // SAFETY: the caller gives what the header demands.
        unsafe { launch(out, RLV_JOB_KIND_BYTES, Product::Bytes, || document::saving_bytes(document)) }
    }

    fn rlv_job_document_save(document: RlvDocument, path: *const c_char, out: *mut RlvJob) {
        // SAFETY: the caller gives what the header demands.
        unsafe { launch(out, RLV_JOB_KIND_NONE, |()| Product::File, || document::saving(document, path)) }
    }

    fn rlv_job_document_compact(context: RlvContext, path: *const c_char, keep: usize, out: *mut RlvJob) {
        // SAFETY: the caller gives what the header demands.
        unsafe { launch(out, RLV_JOB_KIND_NONE, |()| Product::File, || document::compacting(context, path, keep)) }
    }

    fn rlv_job_retain(job: RlvJob) {
        registry::retain(job)
    }

    fn rlv_job_tissue_build(context: RlvContext, description: *const RlvTissueDescription, out: *mut RlvJob) {
        present("out", out)?;
        // SAFETY: the caller gives NULL or descriptors that start with their size, with arrays of their counts.
        let building = unsafe { Building::read(context, description) }?;
        let job = start(&building.context().clone(), RLV_JOB_KIND_TISSUE, move |progress| {
            building.run(progress).map(|(tissue, report)| Product::Tissue(tissue, Some(report)))
        })?;
        // SAFETY: checked above.
        unsafe { put(out, job) };
        Ok(())
    }

    fn rlv_job_tissue_advance(simulation: RlvTissueSimulation, seconds: f64, out: *mut RlvJob) {
        present("out", out)?;
        let simulation = registry::get(simulation)?;
        let job = start(&simulation.context.clone(), RLV_JOB_KIND_NONE, move |progress| {
            simulation.advance(seconds, progress).map(|()| Product::TissueSteps)
        })?;
        // SAFETY: checked above.
        unsafe { put(out, job) };
        Ok(())
    }

    fn rlv_job_release(job: RlvJob) {
        registry::release(job)
    }

    fn rlv_job_poll(job: RlvJob, out: *mut RlvJobInfo) {
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        unsafe { wait(job, Some(Duration::ZERO), out) }
    }

    fn rlv_job_wait(job: RlvJob, seconds: f64, out: *mut RlvJobInfo) {
        let time = duration(seconds)?;
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        unsafe { wait(job, time, out) }
    }

    fn rlv_job_notify(job: RlvJob, callback: RlvJobDone, user: *mut c_void) {
        let job = registry::get(job)?;
        let mut state = job.shared.state();
        let notice = callback.map(|callback| Notice { callback, user });
        if state.ended.is_some() {
            // The callback may ask for the job again.
            drop(state);
            notice.iter().for_each(Notice::send);
        } else {
            state.notice = notice;
        }
        Ok(())
    }

    fn rlv_job_cancel(job: RlvJob) {
        registry::get(job)?.shared.cancelled.store(true, Ordering::Relaxed);
        Ok(())
    }

    fn rlv_job_result(job: RlvJob) {
        registry::get(job)?.product("", |_| Some(()))
    }

    fn rlv_job_mesh(job: RlvJob, out: *mut RlvMesh) {
        let find = |product: &Product| match product {
            Product::Mesh(mesh) | Product::Simplified(mesh, _) | Product::Repaired(mesh, _) => Some(*mesh),
            _ => None,
        };
        // SAFETY: the caller gives NULL or room for a handle.
        unsafe { give(job, out, "triangles", find) }
    }

    fn rlv_job_simplify_error(job: RlvJob, out: *mut f32) {
        present("out", out)?;
        let error = registry::get(job)?.product("simplification", |product| match product {
            Product::Simplified(_, error) => Some(*error),
            _ => None,
        })?;
        // SAFETY: checked above.
        unsafe { put(out, error) };
        Ok(())
    }

    fn rlv_job_repair_report(job: RlvJob, out: *mut RlvRepairReport) {
        let find = |product: &Product| match product {
            Product::Repaired(_, report) => Some(**report),
            _ => None,
        };
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        unsafe { describe(job, out, "a repair", find) }
    }

    fn rlv_job_progressive_mesh(job: RlvJob, out: *mut RlvProgressive) {
        // SAFETY: the caller gives NULL or room for a handle.
        unsafe { give(job, out, "a progressive mesh", taken!(Progressive)) }
    }

    fn rlv_job_grid(job: RlvJob, out: *mut RlvGrid) {
        // SAFETY: the caller gives NULL or room for a handle.
        unsafe { give(job, out, "a grid", taken!(Grid)) }
    }

    fn rlv_job_decal(job: RlvJob, out: *mut RlvDecal) {
        // SAFETY: the caller gives NULL or room for a handle.
        unsafe { give(job, out, "a decal", taken!(Decal)) }
    }

    fn rlv_job_tissue(job: RlvJob, out: *mut RlvTissue) {
        // SAFETY: the caller gives NULL or room for a handle.
        unsafe { give(job, out, "a model of soft tissue", taken!(Tissue)) }
    }

    fn rlv_job_tissue_report(job: RlvJob, out: *mut RlvTissueReport) {
        let find = |product: &Product| match product {
            Product::Tissue(_, report) => *report,
            _ => None,
        };
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        unsafe { describe(job, out, "building soft tissue", find) }
    }

    fn rlv_job_particles(job: RlvJob, out: *mut RlvParticles) {
        // SAFETY: the caller gives NULL or room for a handle.
        unsafe { give(job, out, "particles", taken!(Particles)) }
    }

    fn rlv_job_surface(job: RlvJob, out: *mut RlvSurface) {
        // SAFETY: the caller gives NULL or room for a handle.
        unsafe { give(job, out, "a surface", taken!(Surface)) }
    }

    fn rlv_job_caster(job: RlvJob, out: *mut RlvCaster) {
        // SAFETY: the caller gives NULL or room for a handle.
        unsafe { give(job, out, "a caster", taken!(Caster)) }
    }

    fn rlv_job_procedural(job: RlvJob, out: *mut RlvProcedural) {
        // SAFETY: the caller gives NULL or room for a handle.
        unsafe { give(job, out, "a procedural", taken!(Procedural)) }
    }

    fn rlv_job_collider(job: RlvJob, out: *mut RlvCollider) {
        // SAFETY: the caller gives NULL or room for a handle.
        unsafe { give(job, out, "a collider", taken!(Collider)) }
    }

    fn rlv_job_picture(job: RlvJob, out: *mut RlvPicture) {
        // SAFETY: the caller gives NULL or room for a handle.
        unsafe { give(job, out, "a picture", taken!(Picture)) }
    }

    fn rlv_job_document(job: RlvJob, out: *mut RlvDocument) {
        // SAFETY: the caller gives NULL or room for a handle.
        unsafe { give(job, out, "a document", taken!(Document)) }
    }

    fn rlv_job_bytes(job: RlvJob, out: *mut RlvBytes) {
        // SAFETY: the caller gives NULL or room for a handle.
        unsafe { give(job, out, "bytes", taken!(Bytes)) }
    }

    fn rlv_job_client_status(job: RlvJob, out: *mut RlvClientStatus) {
        let find = |product: &Product| match product {
            Product::Submitted(status) => Some(**status),
            _ => None,
        };
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        unsafe { describe(job, out, "a scene", find) }
    }

    fn rlv_job_crowd_model(job: RlvJob, out: *mut RlvCrowdModel) {
        // SAFETY: the caller gives NULL or room for a handle.
        unsafe { give(job, out, "a crowd model", taken!(Crowd)) }
    }

    fn rlv_job_crowd_refit_report(job: RlvJob, out: *mut RlvCrowdRefitReport) {
        let find = |product: &Product| match product {
            Product::Crowd(_, report) => *report,
            _ => None,
        };
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        unsafe { describe(job, out, "refitting a crowd model", find) }
    }

    fn rlv_job_imprint_report(job: RlvJob, out: *mut RlvImprintReport) {
        let find = |product: &Product| match product {
            Product::Imprint(report) => Some(imprint::report_of(report)),
            _ => None,
        };
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        unsafe { describe(job, out, "an imprint", find) }
    }

    fn rlv_job_fluid_report(job: RlvJob, out: *mut RlvFluidReport) {
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        unsafe { describe(job, out, "a fluid", taken!(Fluid)) }
    }

    fn rlv_job_ptex_report(job: RlvJob, out: *mut RlvPtexReport) {
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        unsafe { describe(job, out, "reading Ptex", taken!(Ptex)) }
    }

    fn rlv_job_transfer_report(job: RlvJob, out: *mut RlvTransferReport) {
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        unsafe { describe(job, out, "a transfer", taken!(Transfer)) }
    }

    fn rlv_job_bake_report(job: RlvJob, out: *mut RlvBakeReport) {
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        unsafe { describe(job, out, "a bake", taken!(Bake)) }
    }
}

/// # Safety
/// `out` is NULL or a descriptor that starts with its size.
unsafe fn wait(job: RlvJob, time: Option<Duration>, out: *mut RlvJobInfo) -> Result<()> {
    let job = registry::get(job)?;
    // SAFETY: promised by the caller.
    unsafe { check_optional(out) }?;
    let info = job.wait(time);
    // SAFETY: as above.
    unsafe { write_optional(out, info) }
}
