//! Clients of the simulation server; see `include/relievo/client.h`.
//!
//! A call takes an idle connection or makes another one, so that a host can ask for the state of a scene while a job waits
//! for a frame of it.

use std::collections::BTreeMap;
use std::ffi::{c_char, c_void};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use relievo_client::{
    Activity, Client, ClientOptions, Fetch, Frame, FrameInfo, FrameName, Nothing, Packing, Particles as Wanted,
    SceneName, Status, Submit, SurfaceForm, Values, Welcome,
};
use relievo_core::{Error, Progress, Result, file};
use relievo_particleio::{Channel, Particles};

use crate::border::array::{Input, fixed, present, put, text};
use crate::border::descriptor::{
    check_optional, numbered, read_descriptor, read_optional, write_descriptor, write_optional,
};
use crate::border::registry::{self, handle};
use crate::runtime::context::{ContextObject, HostProgress, RLV_NAME_SIZE, RLV_TEXT_SIZE, RlvContext, RlvProgress};
use crate::simulation::particles::{self, RlvParticles};
use crate::surfaces::mesh::{self, RlvMesh};

handle!(RlvClient, 30, ClientObject);

constants! {
    u32:
    RLV_CLIENT_RUNNING = 0,
    RLV_CLIENT_FORCES = 1,
    RLV_CLIENT_PAUSED = 2,
    RLV_CLIENT_DONE = 3,
    RLV_CLIENT_CANCELLED = 4,
    RLV_CLIENT_FAILED = 5,
    RLV_CLIENT_PAUSE = 0,
    RLV_CLIENT_RESUME = 1,
    RLV_CLIENT_CANCEL = 2,
    RLV_CLIENT_REMOVE = 3,
    RLV_CLIENT_ALL = 0,
    RLV_CLIENT_BLIND = 1,
    RLV_CLIENT_SURFACE = 2,
    RLV_CLIENT_FRAME = 0,
    RLV_CLIENT_MESH = 1,
    RLV_CLIENT_LEVEL_SET = 2,
}

descriptor! {
    pub struct RlvClientOptions {
        struct_size: u32,
        reserved: u32,
        address: *const c_char,
        token: *const c_char,
        authorities: *const c_char,
        timeout: f64,
        patience: f64,
    }
}

descriptor! {
    pub struct RlvClientStatus {
        struct_size: u32,
        state: u32,
        ready: u64,
        frames: u64,
        particles: u64,
        seconds_left: f64,
        fraction: f32,
        reserved: u32,
        text: [u8; RLV_TEXT_SIZE as usize],
    }
}

descriptor! {
    pub struct RlvClientInfo {
        struct_size: u32,
        protocol: [u32; 2],
        reserved: u32,
        server: [u8; RLV_NAME_SIZE as usize],
        user: [u8; RLV_TEXT_SIZE as usize],
        kinds: [u8; RLV_TEXT_SIZE as usize],
    }
}

descriptor! {
    pub struct RlvClientFile {
        name: *const c_char,
        path: *const c_char,
    }
}

descriptor! {
    pub struct RlvClientScene {
        struct_size: u32,
        is_forced: u32,
        name: *const c_char,
        kind: *const c_char,
        description: *const c_char,
        files: *const RlvClientFile,
        file_count: usize,
    }
}

descriptor! {
    pub struct RlvClientFetch {
        struct_size: u32,
        particles: u32,
        is_half: u32,
        is_plain: u32,
        channels: *const c_char,
    }
}

/// Connections that are held while no call needs them.
const IDLE: usize = 4;
/// Files of a scene at most.
const MAX: usize = 1 << 20;
/// Seconds of an option at most.
const LONGEST: f64 = 86400.0;
/// The channel of places, which particles have in another place than other channels.
const POSITION: &str = "position";
/// The same of numbers.
const NUMBER: &str = "number";
/// Bytes that a particle of a frame takes while it is made, for each of its numbers.
const NUMBER_BYTES: u64 = 12;

/// A client and its connections that no call has.
pub struct ClientObject {
    context: Arc<ContextObject>,
    options: ClientOptions,
    idle: Mutex<Vec<Client>>,
    welcome: Mutex<Welcome>,
}

impl ClientObject {
    /// Does something on a connection.
    fn with<T>(&self, task: impl FnOnce(&mut Client) -> Result<T>) -> Result<T> {
        let idle = || self.idle.lock().unwrap_or_else(PoisonError::into_inner);
        let taken = idle().pop();
        let mut client = taken.map_or_else(|| Client::connect(self.options.clone()), Ok)?;
        let done = task(&mut client);
        *self.welcome.lock().unwrap_or_else(PoisonError::into_inner) = client.welcome().clone();
        let mut idle = idle();
        if idle.len() < IDLE {
            idle.push(client);
        }
        done
    }

    /// Submits a scene whose files are on this machine.
    fn submit(&self, order: &SceneOrder, progress: &mut dyn Progress) -> Result<Status> {
        self.with(|client| {
            let files = client.send_files(&order.files, progress)?;
            client.submit(&Submit { files, ..order.scene.clone() })
        })
    }

    /// Makes particles of a frame.
    fn fetch(&self, fetch: &Fetch, progress: &mut dyn Progress) -> Result<Particles> {
        self.with(|client| {
            let name = FrameName { scene: fetch.scene.clone(), frame: fetch.frame };
            let info: FrameInfo = client.call("frame.info", &name)?;
            let numbers: u64 = info.channels.iter().map(|channel| u64::from(channel.width)).sum();
            let bytes = numbers.saturating_mul(NUMBER_BYTES).saturating_mul(info.count);
            if bytes > self.context.context.memory_limit() {
                return Err(Error::memory(format!("{} particles take {bytes} bytes", info.count))
                    .at(&fetch.scene)
                    .advise("raise the memory limit of the context, or fetch fewer channels or particles"));
            }
            particles_of(client.frame(fetch, progress)?, &info)
        })
    }

    /// Passes a frame or its surface, as a file, to `write`.
    fn file(
        &self,
        order: &FileOrder,
        progress: &mut dyn Progress,
        write: impl FnMut(&[u8]) -> std::io::Result<()>,
    ) -> Result<u64> {
        let FileOrder { scene, frame, form, settings } = order;
        self.with(|client| match form {
            None => client.file(scene, *frame, progress, write),
            Some(form) => client.surface((scene, *frame), (*form, settings), progress, write),
        })
    }

    /// Makes a mesh of the surface of a frame.
    fn mesh(&self, order: &FileOrder, progress: &mut dyn Progress) -> Result<RlvMesh> {
        let limit = self.context.context.memory_limit();
        let (mut bytes, mut is_full) = (Vec::new(), false);
        let fetched = self.file(order, progress, |part| {
            is_full = (bytes.len() + part.len()) as u64 > limit || bytes.try_reserve(part.len()).is_err();
            if is_full {
                return Err(std::io::ErrorKind::OutOfMemory.into());
            }
            bytes.extend_from_slice(part);
            Ok(())
        });
        if is_full {
            return Err(Error::memory("the mesh has no room within the memory limit")
                .at(&order.scene)
                .advise("raise the memory limit of the context, or ask for larger cells"));
        }
        fetched?;
        let model = relievo_meshio::read_ply(&bytes, limit - bytes.len() as u64)?;
        drop(bytes);
        let mesh = model.into_merged_mesh(&self.context.context)?;
        mesh.check()?;
        mesh::register(self.context.clone(), mesh)
    }

    /// Writes a frame or its surface to a file.
    fn save(&self, order: &FileOrder, path: &Path, progress: &mut dyn Progress) -> Result<()> {
        let mut failure = None;
        let stored = file::store(path, |out| {
            let written = self.file(order, progress, |part| out.write_all(part));
            written.map(drop).map_err(|error| {
                let text = error.to_string();
                failure = Some(error);
                std::io::Error::other(text)
            })
        });
        stored.map_err(|error| failure.unwrap_or(error))
    }
}

/// Returns the particles of a frame that was fetched. Fails if it has no positions or is not sound.
fn particles_of(frame: Frame, info: &FrameInfo) -> Result<Particles> {
    let wrong = |name: &str| Error::invalid(format!("the server sent no channel {name:?} that particles can have"));
    let Frame { mut channels, .. } = frame;
    let points = match channels.remove(POSITION) {
        Some((3, Values::Floats(values))) => values.as_chunks::<3>().0.to_vec(),
        _ => return Err(wrong(POSITION)),
    };
    let numbers = match channels.remove(NUMBER) {
        None => None,
        Some((1, Values::Integers(numbers))) => Some(numbers),
        Some(_) => return Err(wrong(NUMBER)),
    };
    let channel = |(name, (width, values)): (String, (u32, Values))| match values {
        Values::Floats(values) => Ok(Channel { name, width, values }),
        Values::Integers(_) => Err(wrong(&name)),
    };
    let particles = Particles {
        points,
        time: Some(info.seconds),
        spacing: (info.spacing > 0.0).then_some(info.spacing),
        numbers,
        channels: channels.into_iter().map(channel).collect::<Result<_>>()?,
    };
    particles.check()?;
    Ok(particles)
}

/// A scene as the host gives it, copied.
pub struct SceneOrder {
    scene: Submit,
    files: BTreeMap<String, PathBuf>,
}

impl SceneOrder {
    /// # Safety
    /// `scene` is NULL or a descriptor whose texts and files are as the header demands.
    unsafe fn read(scene: *const RlvClientScene) -> Result<Self> {
        // SAFETY: a descriptor of nothing but numbers and NULL pointers.
        let default: RlvClientScene = unsafe { std::mem::zeroed() };
        // SAFETY: promised by the caller.
        let given = unsafe { read_descriptor(scene, default) }?;
        // SAFETY: the caller gives NUL-terminated texts, or NULL for the kind.
        let (name, kind, description) = unsafe {
            let kind = if given.kind.is_null() { "fluid" } else { text("kind", given.kind)? };
            (text("name", given.name)?, kind, text("description", given.description)?)
        };
        if given.is_forced > 1 {
            return Err(Error::invalid(format!("is_forced is {}", given.is_forced))
                .at("is_forced")
                .advise("use 0 or 1"));
        }
        if given.file_count > MAX || given.files.is_null() && given.file_count > 0 {
            return Err(Error::invalid(format!("there cannot be {} files", given.file_count)).at("files"));
        }
        let mut files = BTreeMap::new();
        for at in 0..given.file_count {
            // SAFETY: the caller promises `file_count` files of NUL-terminated texts.
            let (name, path) = unsafe {
                let RlvClientFile { name, path } = given.files.add(at).read_unaligned();
                (text("files", name)?, text("files", path)?)
            };
            files.insert(name.to_owned(), PathBuf::from(path));
        }
        let scene = Submit {
            scene: name.into(),
            kind: kind.into(),
            description: description.into(),
            files: Default::default(),
            forced: given.is_forced == 1,
        };
        Ok(Self { scene, files })
    }
}

/// A frame that is fetched as a file.
struct FileOrder {
    scene: String,
    frame: u64,
    /// What is made of it at the server; `None` for the frame itself.
    form: Option<SurfaceForm>,
    settings: String,
}

impl FileOrder {
    /// # Safety
    /// Texts are NUL-terminated or NULL.
    unsafe fn read(scene: *const c_char, frame: u64, form: u32, settings: *const c_char) -> Result<Self> {
        let forms = [(None, "frame"), (Some(SurfaceForm::Mesh), "mesh"), (Some(SurfaceForm::LevelSet), "level set")];
        let form = numbered("form", &forms, form)?;
        // SAFETY: promised by the caller.
        let (scene, settings) = unsafe {
            let settings = if settings.is_null() { "" } else { text("settings", settings)? };
            (text("scene", scene)?, settings)
        };
        Ok(Self { scene: scene.into(), frame, form, settings: settings.into() })
    }
}

/// Returns what is fetched of a frame.
///
/// # Safety
/// `scene` is NULL or a NUL-terminated text, `fetch` NULL or a descriptor whose text is NUL-terminated or NULL.
unsafe fn read_fetch(scene: *const c_char, frame: u64, fetch: *const RlvClientFetch) -> Result<Fetch> {
    // SAFETY: a descriptor of nothing but numbers and NULL pointers, which stand for all particles and channels.
    let default: RlvClientFetch = unsafe { std::mem::zeroed() };
    // SAFETY: promised by the caller.
    let (scene, given) = unsafe { (text("scene", scene)?, read_optional(fetch, default)?) };
    let kinds = [(Wanted::All, "all"), (Wanted::Blind, "blind"), (Wanted::Surface, "surface")];
    for (name, flag) in [("is_half", given.is_half), ("is_plain", given.is_plain)] {
        if flag > 1 {
            return Err(Error::invalid(format!("{name} is {flag}")).at(name).advise("use 0 or 1"));
        }
    }
    let mut channels = Vec::new();
    if !given.channels.is_null() {
        // SAFETY: promised by the caller.
        let names = unsafe { text("channels", given.channels) }?;
        channels = [POSITION].into_iter().chain(names.split(',').map(str::trim)).map(str::to_owned).collect();
    }
    let is_plain = given.is_plain == 1;
    Ok(Fetch {
        scene: scene.into(),
        frame,
        channels,
        particles: numbered("particles", &kinds, given.particles)?,
        packing: if is_plain { Packing::None } else { Packing::Zstd },
        half: given.is_half == 1,
        differences: !is_plain,
        ..Fetch::default()
    })
}

/// Returns the options of a client.
///
/// # Safety
/// `options` is NULL or a descriptor whose texts are NUL-terminated or NULL.
unsafe fn read_options(options: *const RlvClientOptions) -> Result<ClientOptions> {
    let ClientOptions { address, timeout, patience, .. } = ClientOptions::default();
    let default = RlvClientOptions {
        struct_size: 0,
        reserved: 0,
        address: std::ptr::null(),
        token: std::ptr::null(),
        authorities: std::ptr::null(),
        timeout: timeout.as_secs_f64(),
        patience: patience.as_secs_f64(),
    };
    // SAFETY: promised by the caller.
    let given = unsafe { read_optional(options, default) }?;
    // SAFETY: as above.
    let optional = |name, given: *const c_char| (!given.is_null()).then(|| unsafe { text(name, given) }).transpose();
    let seconds = |name: &str, given: f64, least: f64| match given >= least && given <= LONGEST {
        true => Ok(Duration::from_secs_f64(given)),
        false => {
            Err(Error::invalid(format!("it cannot be {given} seconds")).at(name).advise("use at most 86400 seconds"))
        }
    };
    Ok(ClientOptions {
        address: optional("address", given.address)?.map_or(Ok(address), str::parse)?,
        token: optional("token", given.token)?.unwrap_or_default().into(),
        authorities: optional("authorities", given.authorities)?.map(PathBuf::from),
        timeout: seconds("timeout", given.timeout, 1e-3)?,
        patience: seconds("patience", given.patience, 0.0)?,
    })
}

impl From<&Status> for RlvClientStatus {
    fn from(status: &Status) -> Self {
        let error = status.error.as_ref().map(|failure| Error::from(failure.clone()).to_string());
        Self {
            struct_size: 0,
            state: match status.state {
                Activity::Running => RLV_CLIENT_RUNNING,
                Activity::Forces => RLV_CLIENT_FORCES,
                Activity::Paused => RLV_CLIENT_PAUSED,
                Activity::Done => RLV_CLIENT_DONE,
                Activity::Cancelled => RLV_CLIENT_CANCELLED,
                Activity::Failed => RLV_CLIENT_FAILED,
            },
            ready: status.ready,
            frames: status.frames,
            particles: status.particles,
            seconds_left: status.seconds_left.unwrap_or(-1.0),
            fraction: status.fraction,
            reserved: 0,
            text: fixed(&error.unwrap_or_default()),
        }
    }
}

/// A call of a client that runs as a job.
pub enum ClientWork {
    /// Submits a scene.
    Submit(Box<SceneOrder>),
    /// Waits for a frame and makes particles of it.
    Fetch(Fetch),
    /// Waits for a frame and makes a mesh of its surface.
    Mesh(String, u64, String),
}

/// What such a call made.
pub enum ClientProduct {
    /// The state of the scene that was submitted.
    Status(Box<RlvClientStatus>),
    /// A reference to particles.
    Particles(RlvParticles),
    /// A reference to a mesh.
    Mesh(RlvMesh),
}

/// The part of a job that waits for a frame takes this part of its progress.
const WAITING: f32 = 0.9;

/// A client and its call, for a job.
pub struct ClientJob {
    client: Arc<ClientObject>,
    work: ClientWork,
}

impl ClientJob {
    /// Copies a scene that is submitted.
    ///
    /// # Errors
    /// Fails with `Invalid` if the handle is not alive, or the descriptor or a text of it cannot be used.
    ///
    /// # Safety
    /// As for [`rlv_client_submit`].
    pub unsafe fn submit(client: RlvClient, scene: *const RlvClientScene) -> Result<Self> {
        let client = registry::get(client)?;
        // SAFETY: promised by the caller.
        let order = unsafe { SceneOrder::read(scene) }?;
        Ok(Self { client, work: ClientWork::Submit(Box::new(order)) })
    }

    /// Copies what of a frame is fetched.
    ///
    /// # Errors
    /// Fails with `Invalid` if the handle is not alive, or the descriptor or a text of it cannot be used.
    ///
    /// # Safety
    /// As for [`rlv_client_fetch`].
    pub unsafe fn fetch(
        client: RlvClient,
        scene: *const c_char,
        frame: u64,
        fetch: *const RlvClientFetch,
    ) -> Result<Self> {
        let client = registry::get(client)?;
        // SAFETY: promised by the caller.
        let fetch = unsafe { read_fetch(scene, frame, fetch) }?;
        Ok(Self { client, work: ClientWork::Fetch(fetch) })
    }

    /// Copies what frame is fetched as a mesh.
    ///
    /// # Errors
    /// Fails with `Invalid` if the handle is not alive, or a text cannot be used.
    ///
    /// # Safety
    /// As for [`rlv_client_fetch_mesh`].
    pub unsafe fn mesh(client: RlvClient, scene: *const c_char, frame: u64, settings: *const c_char) -> Result<Self> {
        let client = registry::get(client)?;
        // SAFETY: promised by the caller.
        let FileOrder { scene, settings, .. } = unsafe { FileOrder::read(scene, frame, RLV_CLIENT_MESH, settings) }?;
        Ok(Self { client, work: ClientWork::Mesh(scene, frame, settings) })
    }

    /// Returns the context of the client.
    pub fn context(&self) -> &Arc<ContextObject> {
        &self.client.context
    }

    /// Makes the call.
    ///
    /// # Errors
    /// Fails with `Busy` while another call uses the client, with `Io` if the server cannot be reached, with the error
    /// that it returns, with `Invalid` if it sends what does not fit, and with `Cancelled` if the scene stops before
    /// the frame or `progress` asks to stop.
    pub fn run(self, progress: &mut dyn Progress) -> Result<ClientProduct> {
        let Self { client, work } = self;
        progress.step(0.0, "connect")?;
        let wait = |scene: &str, frame: u64, progress: &mut dyn Progress| {
            let mut part = |fraction: f32, stage: &str| progress.report(WAITING * fraction, stage);
            client.with(|connection| connection.wait(scene, frame, &mut part))
        };
        let rest = |progress: &mut dyn Progress, fraction: f32, stage: &str| {
            progress.report(WAITING + (1.0 - WAITING) * fraction, stage)
        };
        match work {
            ClientWork::Submit(order) => {
                let status = client.submit(&order, progress)?;
                Ok(ClientProduct::Status(Box::new(RlvClientStatus::from(&status))))
            }
            ClientWork::Fetch(fetch) => {
                wait(&fetch.scene, fetch.frame, progress)?;
                let fetched =
                    client.fetch(&fetch, &mut |fraction: f32, stage: &str| rest(progress, fraction, stage))?;
                Ok(ClientProduct::Particles(particles::register(client.context.clone(), fetched)?))
            }
            ClientWork::Mesh(scene, frame, settings) => {
                wait(&scene, frame, progress)?;
                let order = FileOrder { scene, frame, form: Some(SurfaceForm::Mesh), settings };
                let mesh = client.mesh(&order, &mut |fraction: f32, stage: &str| rest(progress, fraction, stage))?;
                Ok(ClientProduct::Mesh(mesh))
            }
        }
    }
}

entry! {
    fn rlv_client_connect(context: RlvContext, options: *const RlvClientOptions, out: *mut RlvClient) {
        present("out", out)?;
        let context = registry::get(context)?;
        // SAFETY: the caller gives NULL or a descriptor whose texts are as the header demands.
        let options = unsafe { read_options(options) }?;
        let first = Client::connect(options.clone())?;
        let welcome = Mutex::new(first.welcome().clone());
        let client = ClientObject { context, options, idle: Mutex::new(vec![first]), welcome };
        let handle = registry::insert(client)?;
        // SAFETY: checked above.
        unsafe { put(out, handle) };
        Ok(())
    }

    fn rlv_client_retain(client: RlvClient) {
        registry::retain(client)
    }

    fn rlv_client_release(client: RlvClient) {
        registry::release(client)
    }

    fn rlv_client_info(client: RlvClient, out: *mut RlvClientInfo) {
        let object = registry::get(client)?;
        let Welcome { version, server, user, kinds } =
            object.welcome.lock().unwrap_or_else(PoisonError::into_inner).clone();
        let info = RlvClientInfo {
            struct_size: 0,
            protocol: version,
            reserved: 0,
            server: fixed(&server),
            user: fixed(&user),
            kinds: fixed(&kinds.join(" ")),
        };
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        unsafe { write_descriptor(out, info) }
    }

    fn rlv_client_submit(
        client: RlvClient,
        scene: *const RlvClientScene,
        progress: RlvProgress,
        user: *mut c_void,
        status: *mut RlvClientStatus,
    ) {
        let object = registry::get(client)?;
        // SAFETY: the caller gives NULL or descriptors that start with their sizes, with texts as the header demands.
        let order = unsafe {
            check_optional(status)?;
            SceneOrder::read(scene)?
        };
        let submitted = object.submit(&order, &mut HostProgress { callback: progress, user })?;
        // SAFETY: as above.
        unsafe { write_optional(status, RlvClientStatus::from(&submitted)) }
    }

    fn rlv_client_poll(client: RlvClient, scene: *const c_char, out: *mut RlvClientStatus) {
        let object = registry::get(client)?;
        // SAFETY: the caller gives NULL or a NUL-terminated text.
        let scene = unsafe { text("scene", scene) }?;
        let status = object.with(|client| client.status(scene))?;
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        unsafe { write_descriptor(out, RlvClientStatus::from(&status)) }
    }

    fn rlv_client_wait(
        client: RlvClient,
        scene: *const c_char,
        frame: u64,
        progress: RlvProgress,
        user: *mut c_void,
        status: *mut RlvClientStatus,
    ) {
        let object = registry::get(client)?;
        // SAFETY: the caller gives NULL or a NUL-terminated text, and NULL or a descriptor that starts with its size.
        let scene = unsafe {
            check_optional(status)?;
            text("scene", scene)?
        };
        let mut progress = HostProgress { callback: progress, user };
        let waited = object.with(|client| client.wait(scene, frame, &mut progress))?;
        // SAFETY: as above.
        unsafe { write_optional(status, RlvClientStatus::from(&waited)) }
    }

    fn rlv_client_steer(
        client: RlvClient,
        scene: *const c_char,
        frame: u64,
        changes: *const c_char,
        status: *mut RlvClientStatus,
    ) {
        let object = registry::get(client)?;
        // SAFETY: the caller gives NULL or NUL-terminated texts, and NULL or a descriptor that starts with its size.
        let (scene, changes) = unsafe {
            check_optional(status)?;
            (text("scene", scene)?, text("changes", changes)?)
        };
        let steered = object.with(|client| client.steer(scene, frame, changes))?;
        // SAFETY: as above.
        unsafe { write_optional(status, RlvClientStatus::from(&steered)) }
    }

    fn rlv_client_force(
        client: RlvClient,
        scene: *const c_char,
        frame: u64,
        accelerations: *const f32,
        count: usize,
        stride: usize,
        status: *mut RlvClientStatus,
    ) {
        let object = registry::get(client)?;
        // SAFETY: the caller gives NULL or a NUL-terminated text, `count` accelerations, and NULL or a descriptor that starts
        // with its size.
        let (scene, accelerations) = unsafe {
            check_optional(status)?;
            (text("scene", scene)?, Input::new("accelerations", accelerations.cast::<[f32; 3]>(), count, stride)?)
        };
        let accelerations = accelerations.to_vec("accelerations", object.context.context.memory_limit())?;
        if let Some(at) = accelerations.iter().position(|it| !it.iter().all(|axis| axis.is_finite())) {
            return Err(Error::invalid(format!("acceleration {at} is not finite")).at("accelerations"));
        }
        let mut silent = relievo_core::progress::Silent;
        let forced = object.with(|client| client.force(scene, frame, &accelerations, &mut silent))?;
        // SAFETY: as above.
        unsafe { write_optional(status, RlvClientStatus::from(&forced)) }
    }

    fn rlv_client_control(client: RlvClient, scene: *const c_char, action: u32) {
        let object = registry::get(client)?;
        // SAFETY: the caller gives NULL or a NUL-terminated text.
        let scene = unsafe { text("scene", scene) }?;
        let name = SceneName { scene: scene.into() };
        let methods = [
            ("scene.pause", "pause"),
            ("scene.resume", "resume"),
            ("scene.cancel", "cancel"),
            ("scene.remove", "remove"),
        ];
        let method = numbered("action", &methods, action)?;
        object.with(|client| match method {
            "scene.remove" => client.call::<Nothing>(method, &name).map(drop),
            _ => client.call::<Status>(method, &name).map(drop),
        })
    }

    fn rlv_client_fetch(
        client: RlvClient,
        scene: *const c_char,
        frame: u64,
        fetch: *const RlvClientFetch,
        progress: RlvProgress,
        user: *mut c_void,
        out: *mut RlvParticles,
    ) {
        present("out", out)?;
        let object = registry::get(client)?;
        // SAFETY: the caller gives NULL or a NUL-terminated text, and NULL or a descriptor as the header demands.
        let fetch = unsafe { read_fetch(scene, frame, fetch) }?;
        let fetched = object.fetch(&fetch, &mut HostProgress { callback: progress, user })?;
        let made = particles::register(object.context.clone(), fetched)?;
        // SAFETY: checked above.
        unsafe { put(out, made) };
        Ok(())
    }

    fn rlv_client_fetch_mesh(
        client: RlvClient,
        scene: *const c_char,
        frame: u64,
        settings: *const c_char,
        progress: RlvProgress,
        user: *mut c_void,
        out: *mut RlvMesh,
    ) {
        present("out", out)?;
        let object = registry::get(client)?;
        // SAFETY: the caller gives NULL or NUL-terminated texts.
        let order = unsafe { FileOrder::read(scene, frame, RLV_CLIENT_MESH, settings) }?;
        let made = object.mesh(&order, &mut HostProgress { callback: progress, user })?;
        // SAFETY: checked above.
        unsafe { put(out, made) };
        Ok(())
    }

    fn rlv_client_save(
        client: RlvClient,
        scene: *const c_char,
        frame: u64,
        form: u32,
        settings: *const c_char,
        path: *const c_char,
        progress: RlvProgress,
        user: *mut c_void,
    ) {
        let object = registry::get(client)?;
        // SAFETY: the caller gives NULL or NUL-terminated texts.
        let (order, path) = unsafe { (FileOrder::read(scene, frame, form, settings)?, text("path", path)?) };
        object.save(&order, Path::new(path), &mut HostProgress { callback: progress, user })
    }
}
