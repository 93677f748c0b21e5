//! Jobs: long calls on a thread of their own; see `include/relievo/job.h`.
//!
//! A call that runs as a job tells its progress as any other. The first word of it says that it has all that it needs for
//! itself, and is what the function that starts it waits for: so what can be refused is refused there.

use std::ffi::{c_char, c_void};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;

use relievo_core::{Error, ErrorKind, Progress, Result};
use relievo_detail::{Pose, Report};

use crate::array::{fixed, present, put};
use crate::bake::{self, RlvBakeOptions, RlvBakeReport};
use crate::border::caught;
use crate::client::{ClientJob, ClientProduct, RlvClient, RlvClientFetch, RlvClientScene, RlvClientStatus};
use crate::collider::RlvCollider;
use crate::context::{ContextObject, RLV_NAME_SIZE, RlvContext};
use crate::crowd::{CrowdBuild, RlvCrowdBuildSettings, RlvCrowdClipName, RlvCrowdModel};
use crate::decal::{Laying, RlvDecal, RlvDecalOptions, RlvDecalPin};
use crate::descriptor::{check_optional, write_descriptor, write_optional};
use crate::detail::{RlvDetail, transform};
use crate::document::{RlvTransferOptions, RlvTransferReport, Transfer};
use crate::error::{RLV_OK, RlvResult, result_of};
use crate::fluid::{RlvFluid, RlvFluidReport};
use crate::grid::{self, RlvGrid, RlvGridSettings};
use crate::imprint::{self, RlvImprintMoment, RlvImprintReport, RlvImprintSettings};
use crate::isosurface::{Meshing, RlvIsosurface, RlvIsosurfaceMeshOptions};
use crate::log::{self, Queue};
use crate::mesh::RlvMesh;
use crate::object::duration;
use crate::particles::RlvParticles;
use crate::progressive::{Build, RlvProgressive, RlvProgressiveOptions};
use crate::ptex::{Export, Import, RlvPtexOptions, RlvPtexReport};
use crate::registry::{self, handle};
use crate::repair::{RepairJob, RlvRepairReport, RlvRepairSettings};
use crate::simplify::{RlvSimplifyOptions, Simplification};
use crate::tessellate::{self, RlvTessellateOptions};
use crate::tissue::{Building, RlvTissue, RlvTissueDescription, RlvTissueReport, RlvTissueSimulation};
use crate::work::{self, busy};

handle!(RlvJob, 13, JobObject);

constants! {
    u32:
    RLV_JOB_RUNNING = 0,
    RLV_JOB_DONE = 1,
    RLV_JOB_FAILED = 2,
    RLV_JOB_CANCELLED = 3,
}

descriptor! {
    pub struct RlvJobInfo {
        struct_size: u32,
        state: u32,
        result: RlvResult,
        fraction: f32,
        stage: [u8; RLV_NAME_SIZE as usize],
    }
}

/// What a job made.
pub enum Product {
    /// A reference to a mesh, which the job releases.
    Mesh(RlvMesh),
    /// The same, and how far the mesh deviates.
    Simplified(RlvMesh, f32),
    /// The same of a progressive mesh.
    Progressive(RlvProgressive),
    /// The same of a grid.
    Grid(RlvGrid),
    /// The same of a decal.
    Decal(RlvDecal),
    /// The same of a crowd model.
    Crowd(RlvCrowdModel),
    /// A mesh as above, and the report on its repair.
    Repaired(RlvMesh, Box<RlvRepairReport>),
    Imprint(Report),
    Bake(RlvBakeReport),
    /// A file without more to say about it.
    File,
    Ptex(RlvPtexReport),
    Transfer(RlvTransferReport),
    Fluid(RlvFluidReport),
    /// A model of soft tissue as above, and what it was made of.
    Tissue(RlvTissue, RlvTissueReport),
    /// Steps of soft tissue, without more to say about them.
    TissueSteps,
    /// The state of a scene that was submitted.
    Submitted(Box<RlvClientStatus>),
    /// The same of particles.
    Particles(RlvParticles),
}

impl From<ClientProduct> for Product {
    fn from(product: ClientProduct) -> Self {
        match product {
            ClientProduct::Status(status) => Self::Submitted(status),
            ClientProduct::Particles(particles) => Self::Particles(particles),
            ClientProduct::Mesh(mesh) => Self::Mesh(mesh),
        }
    }
}

impl Drop for Product {
    fn drop(&mut self) {
        // Nothing can be done about a host that released it too often.
        let _ = match self {
            Self::Mesh(mesh) | Self::Simplified(mesh, _) | Self::Repaired(mesh, _) => registry::release(*mesh),
            Self::Progressive(mesh) => registry::release(*mesh),
            Self::Grid(grid) => registry::release(*grid),
            Self::Decal(decal) => registry::release(*decal),
            Self::Tissue(tissue, _) => registry::release(*tissue),
            Self::Particles(particles) => registry::release(*particles),
            Self::Crowd(model) => registry::release(*model),
            _ => Ok(()),
        };
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
        RlvJobInfo { struct_size: 0, state: number, result, fraction, stage }
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
    call: impl FnOnce(&mut dyn Progress) -> Result<Product> + Send + 'static,
) -> Result<RlvJob> {
    let shared = Arc::new(Shared::default());
    let inside = Arc::clone(&shared);
    let function = work::function();
    let run = move || {
        let job = || caught(|| call(&mut JobProgress(Arc::clone(&inside))));
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

/// Starts what makes a grid.
fn start_grid(work: grid::Work) -> Result<RlvJob> {
    start(&work.context().clone(), move |progress| work.run(progress).map(Product::Grid))
}

/// Starts what lays a sticker.
fn start_decal(laying: Laying) -> Result<RlvJob> {
    start(&laying.context().clone(), move |progress| laying.run(progress).map(Product::Decal))
}

/// Starts a call of a client.
fn start_client(job: ClientJob) -> Result<RlvJob> {
    start(&job.context().clone(), move |progress| job.run(progress).map(Product::from))
}

entry! {
    fn rlv_job_tessellate(detail: RlvDetail, options: *const RlvTessellateOptions, out: *mut RlvJob) {
        present("out", out)?;
        let detail = registry::get(detail)?;
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        let options = unsafe { tessellate::Cells::new(options) }?;
        let (context, view) = (detail.context.clone(), detail.view());
        let job = start(&context.clone(), move |progress| {
            progress.step(0.0, "tessellate")?;
            // A product is released where the job is cancelled.
            let made = Product::Mesh(tessellate::tessellate_committed(&context, &view, options)?);
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
        let job = start(&detail.context.clone(), move |progress| {
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
        let job = start(&detail.context.clone(), move |progress| {
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
        let job = start(&context.clone(), move |progress| {
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
        let job = start(&detail.context.clone(), move |progress| {
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
        let job = start(&detail.context.clone(), move |progress| {
            import.take_up(&detail, progress).map(Product::Ptex)
        })?;
        // SAFETY: checked above.
        unsafe { put(out, job) };
        Ok(())
    }

    fn rlv_job_transfer(
        context: RlvContext,
        path: *const c_char,
        to: RlvMesh,
        to_path: *const c_char,
        options: *const RlvTransferOptions,
        out: *mut RlvJob,
    ) {
        present("out", out)?;
        let context = registry::get(context)?;
        // SAFETY: the caller gives NUL-terminated texts, and NULL or a descriptor that starts with its size.
        let transfer = unsafe { Transfer::read(path, to, to_path, options) }?;
        let job = start(&context.clone(), move |progress| {
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
        let job = start(&build.context().clone(), move |progress| build.run(progress).map(Product::Progressive))?;
        // SAFETY: checked above.
        unsafe { put(out, job) };
        Ok(())
    }

    fn rlv_job_simplify(mesh: RlvMesh, options: *const RlvSimplifyOptions, out: *mut RlvJob) {
        present("out", out)?;
        // SAFETY: the caller gives NULL or a descriptor that starts with its size, with arrays of their counts.
        let simplification = unsafe { Simplification::read(mesh, options) }?;
        let job = start(&simplification.context().clone(), move |progress| {
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
        let job = start(&repair.context().clone(), move |progress| {
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
        let job = start(&meshing.context().clone(), move |progress| meshing.run(progress).map(Product::Mesh))?;
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
        let job = start(&meshing.context().clone(), move |progress| meshing.run(progress).map(Product::Mesh))?;
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
        let build = unsafe { CrowdBuild::read(context, path, clips, clip_count, settings) }?;
        let job = start(&build.context().clone(), move |progress| build.run(progress).map(Product::Crowd))?;
        // SAFETY: checked above.
        unsafe { put(out, job) };
        Ok(())
    }

    fn rlv_job_fluid(fluid: RlvFluid, seconds: f64, out: *mut RlvJob) {
        present("out", out)?;
        let fluid = registry::get(fluid)?;
        let job = start(&fluid.context.clone(), move |progress| fluid.advance(seconds, progress).map(Product::Fluid))?;
        // SAFETY: checked above.
        unsafe { put(out, job) };
        Ok(())
    }

    fn rlv_job_client_submit(client: RlvClient, scene: *const RlvClientScene, out: *mut RlvJob) {
        present("out", out)?;
        // SAFETY: the caller gives NULL or a descriptor whose texts and files are as the header demands.
        let job = start_client(unsafe { ClientJob::submit(client, scene) }?)?;
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
        let job = start_client(unsafe { ClientJob::fetch(client, scene, frame, fetch) }?)?;
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
        let job = start_client(unsafe { ClientJob::mesh(client, scene, frame, settings) }?)?;
        // SAFETY: checked above.
        unsafe { put(out, job) };
        Ok(())
    }

    fn rlv_job_retain(job: RlvJob) {
        registry::retain(job)
    }

    fn rlv_job_tissue_build(context: RlvContext, description: *const RlvTissueDescription, out: *mut RlvJob) {
        present("out", out)?;
        // SAFETY: the caller gives NULL or descriptors that start with their size, with arrays of their counts.
        let building = unsafe { Building::read(context, description) }?;
        let job = start(&building.context().clone(), move |progress| {
            building.run(progress).map(|(tissue, report)| Product::Tissue(tissue, report))
        })?;
        // SAFETY: checked above.
        unsafe { put(out, job) };
        Ok(())
    }

    fn rlv_job_tissue_advance(simulation: RlvTissueSimulation, seconds: f64, out: *mut RlvJob) {
        present("out", out)?;
        let simulation = registry::get(simulation)?;
        let job = start(&simulation.context.clone(), move |progress| {
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
        present("out", out)?;
        let mesh = registry::get(job)?.product("triangles", |product| match product {
            Product::Mesh(mesh) | Product::Simplified(mesh, _) | Product::Repaired(mesh, _) => Some(*mesh),
            _ => None,
        })?;
        registry::retain(mesh)?;
        // SAFETY: checked above.
        unsafe { put(out, mesh) };
        Ok(())
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
        let report = registry::get(job)?.product("a repair", |product| match product {
            Product::Repaired(_, report) => Some(**report),
            _ => None,
        })?;
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        unsafe { write_descriptor(out, report) }
    }

    fn rlv_job_progressive_mesh(job: RlvJob, out: *mut RlvProgressive) {
        present("out", out)?;
        let mesh = registry::get(job)?.product("a progressive mesh", |product| match product {
            Product::Progressive(mesh) => Some(*mesh),
            _ => None,
        })?;
        registry::retain(mesh)?;
        // SAFETY: checked above.
        unsafe { put(out, mesh) };
        Ok(())
    }

    fn rlv_job_grid(job: RlvJob, out: *mut RlvGrid) {
        present("out", out)?;
        let grid = registry::get(job)?.product("a grid", |product| match product {
            Product::Grid(grid) => Some(*grid),
            _ => None,
        })?;
        registry::retain(grid)?;
        // SAFETY: checked above.
        unsafe { put(out, grid) };
        Ok(())
    }

    fn rlv_job_decal(job: RlvJob, out: *mut RlvDecal) {
        present("out", out)?;
        let decal = registry::get(job)?.product("a decal", |product| match product {
            Product::Decal(decal) => Some(*decal),
            _ => None,
        })?;
        registry::retain(decal)?;
        // SAFETY: checked above.
        unsafe { put(out, decal) };
        Ok(())
    }

    fn rlv_job_tissue(job: RlvJob, out: *mut RlvTissue) {
        present("out", out)?;
        let tissue = registry::get(job)?.product("a model of soft tissue", |product| match product {
            Product::Tissue(tissue, _) => Some(*tissue),
            _ => None,
        })?;
        registry::retain(tissue)?;
        // SAFETY: checked above.
        unsafe { put(out, tissue) };
        Ok(())
    }

    fn rlv_job_tissue_report(job: RlvJob, out: *mut RlvTissueReport) {
        let report = registry::get(job)?.product("a model of soft tissue", |product| match product {
            Product::Tissue(_, report) => Some(*report),
            _ => None,
        })?;
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        unsafe { write_descriptor(out, report) }
    }

    fn rlv_job_particles(job: RlvJob, out: *mut RlvParticles) {
        present("out", out)?;
        let particles = registry::get(job)?.product("particles", |product| match product {
            Product::Particles(particles) => Some(*particles),
            _ => None,
        })?;
        registry::retain(particles)?;
        // SAFETY: checked above.
        unsafe { put(out, particles) };
        Ok(())
    }

    fn rlv_job_client_status(job: RlvJob, out: *mut RlvClientStatus) {
        let status = registry::get(job)?.product("a scene", |product| match product {
            Product::Submitted(status) => Some(**status),
            _ => None,
        })?;
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        unsafe { write_descriptor(out, status) }
    }

    fn rlv_job_crowd_model(job: RlvJob, out: *mut RlvCrowdModel) {
        present("out", out)?;
        let model = registry::get(job)?.product("a crowd model", |product| match product {
            Product::Crowd(model) => Some(*model),
            _ => None,
        })?;
        registry::retain(model)?;
        // SAFETY: checked above.
        unsafe { put(out, model) };
        Ok(())
    }

    fn rlv_job_imprint_report(job: RlvJob, out: *mut RlvImprintReport) {
        let report = registry::get(job)?.product("an imprint", |product| match product {
            Product::Imprint(report) => Some(imprint::report_of(report)),
            _ => None,
        })?;
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        unsafe { write_descriptor(out, report) }
    }

    fn rlv_job_fluid_report(job: RlvJob, out: *mut RlvFluidReport) {
        let report = registry::get(job)?.product("a fluid", |product| match product {
            Product::Fluid(report) => Some(*report),
            _ => None,
        })?;
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        unsafe { write_descriptor(out, report) }
    }

    fn rlv_job_ptex_report(job: RlvJob, out: *mut RlvPtexReport) {
        let report = registry::get(job)?.product("reading Ptex", |product| match product {
            Product::Ptex(report) => Some(*report),
            _ => None,
        })?;
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        unsafe { write_descriptor(out, report) }
    }

    fn rlv_job_transfer_report(job: RlvJob, out: *mut RlvTransferReport) {
        let report = registry::get(job)?.product("a transfer", |product| match product {
            Product::Transfer(report) => Some(*report),
            _ => None,
        })?;
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        unsafe { write_descriptor(out, report) }
    }

    fn rlv_job_bake_report(job: RlvJob, out: *mut RlvBakeReport) {
        let report = registry::get(job)?.product("a bake", |product| match product {
            Product::Bake(report) => Some(*report),
            _ => None,
        })?;
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        unsafe { write_descriptor(out, report) }
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
