//! Crowds of articulated models; see `include/relievo/crowd.h`.

use std::ffi::{c_char, c_void};
use std::path::{Path, PathBuf};
use std::sync::{Arc, OnceLock, RwLock};

use glam::{DAffine3, DVec3};
use relievo_core::{Error, Progress, Result};
use relievo_crowd::{
    Agent, BuildSettings, Crowd, CrowdModel, CrowdView, Culled, Draw, DrawList, Frame, Instance, NONE, Occlusion,
    PixelView,
};
use relievo_render::Camera;

use crate::border::array::{Input, Output, Plain, fixed, present, put, text};
use crate::border::descriptor::{check_optional, read_descriptor, write_descriptor, write_optional};
use crate::border::registry::{self, handle, try_read, try_write};
use crate::runtime::bytes::{self, RlvBytes};
use crate::runtime::context::{ContextObject, HostProgress, RLV_NAME_SIZE, RLV_TEXT_SIZE, RlvContext, RlvProgress};
use crate::runtime::parameter::{RlvParameter, Table, settings, table};
use crate::surfaces::mesh::{self, RlvMesh};

mod impostors;

pub use impostors::*;

handle!(RlvCrowdModel, 32, CrowdModelObject);
handle!(RlvCrowd, 33, CrowdObject);

settings!(RlvCrowdBuildSettings, BuildSettings);

descriptor! {
    pub struct RlvCrowdClipName {
        name: *const c_char,
    }
}

descriptor! {
    pub struct RlvCrowdModelInfo {
        struct_size: u32,
        vertex_count: u32,
        triangle_count: u32,
        input_triangles: u32,
        cluster_count: u32,
        group_count: u32,
        bone_count: u32,
        clip_count: u32,
        material_count: u32,
        pose_count: u32,
        representatives: u32,
        largest_error: f32,
        measured: u64,
        exceeded: u64,
        low: [f32; 3],
        high: [f32; 3],
        morph_count: u32,
        offset_count: u32,
    }
}

descriptor! {
    pub struct RlvCrowdClip {
        struct_size: u32,
        pose_count: u32,
        rate: f32,
        name: [u8; RLV_NAME_SIZE as usize],
    }
}

descriptor! {
    pub struct RlvCrowdMaterial {
        struct_size: u32,
        name: [u8; RLV_TEXT_SIZE as usize],
    }
}

descriptor! {
    pub struct RlvCrowdVertices {
        struct_size: u32,
        reserved: u32,
        capacity: usize,
        points: *mut f32,
        normals: *mut f32,
        uvs: *mut f32,
        bones: *mut u32,
        weights: *mut f32,
    }
}

#[repr(C)]
#[derive(Clone, Copy, Debug, Default)]
pub struct RlvCrowdCollapse {
    pub group: u32,
    pub target: u32,
}

descriptor! {
    pub struct RlvCrowdOffset {
        vertex: u32,
        morph: u32,
        offset: [f32; 3],
    }
}

descriptor! {
    pub struct RlvCrowdCluster {
        first_triangle: u32,
        triangle_count: u32,
        made_by: u32,
        used_by: u32,
        depth: u32,
        deformation: f32,
    }
}

descriptor! {
    pub struct RlvCrowdAgent {
        model: u32,
        clip: u32,
        phase: f64,
        transform: [f64; 12],
    }
}

descriptor! {
    pub struct RlvCrowdView {
        struct_size: u32,
        width: u32,
        height: u32,
        tolerance: f32,
        eye: [f64; 3],
        target: [f64; 3],
        up: [f64; 3],
        fov: f64,
        time: f64,
        occlusion: u32,
        geomorph: u32,
        impostors: u32,
        reserved: u32,
    }
}

descriptor! {
    pub struct RlvCrowdFrame {
        struct_size: u32,
        agent_count: u32,
        draw_count: u32,
        matrix_count: u32,
        changed: u32,
        hidden: u32,
        clusters: u64,
        triangles: u64,
        hidden_triangles: u64,
        occluder_triangles: u64,
        weight_count: u32,
        impostor_count: u32,
        picture_count: u32,
        reserved: u32,
    }
}

#[repr(C)]
#[derive(Clone, Copy, Debug, Default)]
pub struct RlvCrowdDraw {
    pub index_count: u32,
    pub instance_count: u32,
    pub first_index: u32,
    pub base_vertex: i32,
    pub first_instance: u32,
}

descriptor! {
    pub struct RlvCrowdInstance {
        agent: u32,
        first_matrix: u32,
        transform: [f32; 12],
    }
}

descriptor! {
    pub struct RlvCrowdBuffers {
        struct_size: u32,
        reserved: u32,
        draws: *mut RlvCrowdDraw,
        draw_capacity: usize,
        draw_stride: usize,
        clusters: *mut u32,
        instances: *mut RlvCrowdInstance,
        instance_capacity: usize,
        instance_stride: usize,
        matrices: *mut f32,
        matrix_capacity: usize,
        matrix_stride: usize,
        weights: *mut f32,
        weight_capacity: usize,
        first_weights: *mut u32,
        blends: *mut f32,
    }
}

impl Default for RlvCrowdClipName {
    fn default() -> Self {
        Self { name: std::ptr::null() }
    }
}

impl Default for RlvCrowdOffset {
    fn default() -> Self {
        Self { vertex: 0, morph: 0, offset: [0.0; 3] }
    }
}

impl Default for RlvCrowdCluster {
    fn default() -> Self {
        Self { first_triangle: 0, triangle_count: 0, made_by: NONE, used_by: NONE, depth: 0, deformation: 0.0 }
    }
}

impl Default for RlvCrowdAgent {
    fn default() -> Self {
        Self { model: 0, clip: 0, phase: 0.0, transform: [0.0; 12] }
    }
}

impl Default for RlvCrowdInstance {
    fn default() -> Self {
        Self { agent: 0, first_matrix: 0, transform: [0.0; 12] }
    }
}

// SAFETY: a pointer without padding.
unsafe impl Plain for RlvCrowdClipName {}
// SAFETY: a handle is one integer.
unsafe impl Plain for RlvCrowdModel {}
// SAFETY: integers of four bytes without padding.
unsafe impl Plain for RlvCrowdCollapse {}
// SAFETY: integers and floats of four bytes without padding.
unsafe impl Plain for RlvCrowdOffset {}
// SAFETY: integers and floats of four bytes without padding.
unsafe impl Plain for RlvCrowdCluster {}
// SAFETY: two integers, then doubles, without padding.
unsafe impl Plain for RlvCrowdAgent {}
// SAFETY: integers of four bytes without padding.
unsafe impl Plain for RlvCrowdDraw {}
// SAFETY: integers and floats of four bytes without padding.
unsafe impl Plain for RlvCrowdInstance {}

/// A model, which the crowds that show it share.
pub struct CrowdModelObject {
    context: Arc<ContextObject>,
    model: Arc<CrowdModel>,
}

/// A crowd with what its last view draws.
pub struct CrowdObject {
    context: Arc<ContextObject>,
    state: RwLock<State>,
}

struct State {
    crowd: Crowd,
    frame: Frame,
    occlusion: Occlusion,
    list: DrawList,
    shown: ShownImpostors,
    is_cut: bool,
}

impl CrowdObject {
    pub fn context(&self) -> &Arc<ContextObject> {
        &self.context
    }

    /// Works with the models and agents.
    ///
    /// # Errors
    /// Fails with `Busy` while they change, with `Internal` if an earlier panic left them broken, and as `work` does.
    pub fn with_crowd<T>(&self, work: impl FnOnce(&Crowd) -> Result<T>) -> Result<T> {
        work(&try_read(&self.state, "crowd")?.crowd)
    }
}

impl State {
    /// Fails where what the last cut found is not that of the agents.
    fn check_cut(&self) -> Result<()> {
        if self.is_cut {
            return Ok(());
        }
        Err(Error::invalid("the agents changed since the last cut, or there was none")
            .advise("call rlv_crowd_cut first"))
    }

    fn shown(&self) -> Result<&ShownImpostors> {
        self.check_cut()?;
        Ok(&self.shown)
    }
}

/// A hierarchy to be built of a file, with all that this needs copied.
pub struct CrowdBuild {
    context: Arc<ContextObject>,
    path: PathBuf,
    clips: Vec<String>,
    settings: BuildSettings,
}

impl CrowdBuild {
    /// Copies what a build needs.
    ///
    /// # Errors
    /// Fails with `Invalid` if the handle is not alive, a text or the array of clips cannot be used or a setting is out
    /// of range, and with `Memory` if the names exceed the context's memory limit.
    ///
    /// # Safety
    /// `path` is NULL or a NUL-terminated text, `clips` has `count` names, `settings` is NULL or a descriptor that starts
    /// with its size.
    pub unsafe fn read(
        context: RlvContext,
        path: *const c_char,
        clips: *const RlvCrowdClipName,
        count: usize,
        settings: *const RlvCrowdBuildSettings,
    ) -> Result<Self> {
        let context = registry::get(context)?;
        // SAFETY: promised by the caller.
        let (path, settings) = unsafe { (text("path", path)?, RlvCrowdBuildSettings::read(settings)?) };
        // SAFETY: promised by the caller.
        let names = unsafe { Input::new("clips", clips, count, 0) }?.to_vec("clips", context.context.memory_limit())?;
        // SAFETY: as above.
        let clips = names.iter().map(|clip| unsafe { text("clips", clip.name) }.map(str::to_owned));
        let clips = clips.collect::<Result<Vec<_>>>()?;
        Ok(Self { context, path: path.into(), clips, settings })
    }

    pub fn context(&self) -> &Arc<ContextObject> {
        &self.context
    }

    /// Builds the hierarchy.
    ///
    /// # Errors
    /// Fails with `NotFound` if the file or a clip does not exist, as [`relievo_meshio::read_model`] and
    /// [`CrowdModel::build`] do, and with `Cancelled` if `progress` asks to stop.
    pub fn run(&self, progress: &mut dyn Progress) -> Result<RlvCrowdModel> {
        progress.step(0.0, "read poses")?;
        let context = &self.context.context;
        let source = relievo_meshio::read_model(context, &self.path)?;
        source.notes.iter().for_each(|note| self.context.log(crate::runtime::context::RLV_LOG_WARNING, note));
        let animations = match self.clips.as_slice() {
            [] => (0..source.animations.len()).collect(),
            names => names.iter().map(|name| source.animation(name)).collect::<Result<Vec<_>>>()?,
        };
        let place = |error: Error| error.at(self.path.display().to_string());
        let model = CrowdModel::build(context, &source, &animations, &self.settings, progress).map_err(place)?;
        register(self.context.clone(), model)
    }
}

fn register(context: Arc<ContextObject>, model: CrowdModel) -> Result<RlvCrowdModel> {
    registry::insert(CrowdModelObject { context, model: Arc::new(model) })
}

fn info_of(model: &CrowdModel) -> RlvCrowdModelInfo {
    let character = &model.character;
    RlvCrowdModelInfo {
        struct_size: 0,
        vertex_count: character.points.len() as u32,
        triangle_count: character.triangles.len() as u32,
        input_triangles: model.input_triangles,
        cluster_count: model.clusters.len() as u32,
        group_count: model.groups.len() as u32,
        bone_count: character.bones.len() as u32,
        clip_count: model.clips.len() as u32,
        material_count: character.material_names.len() as u32,
        pose_count: model.report.poses,
        representatives: model.report.representatives,
        largest_error: model.groups.iter().map(|group| group.error).fold(0.0, f32::max),
        measured: model.report.measured,
        exceeded: model.report.exceeded,
        low: model.low,
        high: model.high,
        morph_count: character.morphs.count,
        offset_count: character.morphs.offsets.len() as u32,
    }
}

/// Returns the agent that C describes.
fn agent_of(given: &RlvCrowdAgent) -> Agent {
    let RlvCrowdAgent { model, clip, phase, transform } = *given;
    Agent { model, clip, phase, transform: DAffine3::from_cols_array(&transform) }
}

/// A view that C describes.
pub(crate) struct Seen {
    pub view: CrowdView,
    pub eye: DVec3,
    /// The same for culling by occlusion, where that is asked for.
    pub pixels: Option<PixelView>,
    pub time: f64,
}

/// Returns the view that C describes.
///
/// # Safety
/// `view` is NULL or a descriptor that starts with its size.
pub(crate) unsafe fn view_of(view: *const RlvCrowdView) -> Result<Seen> {
    // SAFETY: a descriptor of nothing but numbers.
    let default: RlvCrowdView = unsafe { std::mem::zeroed() };
    // SAFETY: promised by the caller.
    let given = unsafe { read_descriptor(view, default) }?;
    let RlvCrowdView { width, height, tolerance, eye, target, up, fov, time, occlusion, geomorph, impostors, .. } =
        given;
    if width == 0 || height == 0 {
        return Err(Error::invalid("the picture has no pixels").at("view").advise("set width and height"));
    }
    if !time.is_finite() {
        return Err(Error::invalid("the time is not finite").at("view").advise("give seconds"));
    }
    let camera = Camera::look_at(DVec3::from(eye), DVec3::from(target), DVec3::from(up), fov)?;
    let is_on = |name: &str, value: u32| match value {
        0 => Ok(false),
        1 => Ok(true),
        other => Err(Error::invalid(format!("{name} is {other}")).at("view").advise("set it to 0 or 1")),
    };
    let mut view = CrowdView::perspective(camera.eye, camera.axes, camera.fov, [width, height], tolerance)?;
    view.geomorph = is_on("geomorph", geomorph)?;
    view.impostors = is_on("impostors", impostors)?;
    let pixels = PixelView { eye: camera.eye, axes: camera.axes, fov: camera.fov, size: [width, height] };
    let pixels = is_on("occlusion", occlusion)?.then_some(pixels);
    Ok(Seen { view, eye: camera.eye, pixels, time })
}

/// Fills an array of elements with so many numbers each that is wanted, or fails if the model lacks them.
fn fill<T: Plain>(out: Option<Output<T>>, name: &str, values: Option<impl ExactSizeIterator<Item = T>>) -> Result<()> {
    let Some(out) = out else { return Ok(()) };
    let Some(values) = values else {
        return Err(Error::invalid("the model has none").at(name).advise("pass NULL"));
    };
    out.holds(name, values.len())?.fill(values);
    Ok(())
}

entry! {
    fn rlv_crowd_params(params: *mut *const RlvParameter, count: *mut usize) {
        static TABLE: OnceLock<Table> = OnceLock::new();
        present("params", params)?;
        present("count", count)?;
        let rows = table(&TABLE, BuildSettings::PARAMETERS);
        // SAFETY: both were checked above.
        unsafe {
            put(params, rows.as_ptr());
            put(count, rows.len());
        }
        Ok(())
    }

    fn rlv_crowd_model_build(
        context: RlvContext,
        path: *const c_char,
        clips: *const RlvCrowdClipName,
        clip_count: usize,
        settings: *const RlvCrowdBuildSettings,
        progress: RlvProgress,
        user: *mut c_void,
        out: *mut RlvCrowdModel,
    ) {
        present("out", out)?;
        // SAFETY: the caller gives NUL-terminated texts, and NULL or a descriptor that starts with its size.
        let build = unsafe { CrowdBuild::read(context, path, clips, clip_count, settings) }?;
        let made = build.run(&mut HostProgress { callback: progress, user })?;
        // SAFETY: checked above.
        unsafe { put(out, made) };
        Ok(())
    }

    fn rlv_crowd_model_read(context: RlvContext, path: *const c_char, out: *mut RlvCrowdModel) {
        present("out", out)?;
        let context = registry::get(context)?;
        // SAFETY: the caller gives NULL or a NUL-terminated text.
        let path = unsafe { text("path", path) }?;
        let model = CrowdModel::load(&context.context, Path::new(path))?;
        let handle = register(context, model)?;
        // SAFETY: checked above.
        unsafe { put(out, handle) };
        Ok(())
    }

    fn rlv_crowd_model_write(model: RlvCrowdModel, path: *const c_char) {
        let object = registry::get(model)?;
        // SAFETY: the caller gives NULL or a NUL-terminated text.
        let path = unsafe { text("path", path) }?;
        object.model.save(Path::new(path))
    }

    fn rlv_crowd_model_read_bytes(context: RlvContext, bytes: *const u8, size: usize, out: *mut RlvCrowdModel) {
        present("out", out)?;
        let context = registry::get(context)?;
        let limit = context.context.memory_limit();
        // SAFETY: the caller promises `size` bytes.
        let bytes = unsafe { bytes::take(bytes, size, limit) }?;
        let model = CrowdModel::from_bytes(&bytes, limit).map_err(|error| error.at("bytes"))?;
        let handle = register(context, model)?;
        // SAFETY: checked above.
        unsafe { put(out, handle) };
        Ok(())
    }

    fn rlv_crowd_model_write_bytes(model: RlvCrowdModel, out: *mut RlvBytes) {
        present("out", out)?;
        let object = registry::get(model)?;
        let mut made = Vec::new();
        object.model.write(&mut made).map_err(|error| Error::internal(error.to_string()))?;
        // SAFETY: checked above.
        unsafe { bytes::give(made, out) }
    }

    fn rlv_crowd_model_retain(model: RlvCrowdModel) {
        registry::retain(model)
    }

    fn rlv_crowd_model_release(model: RlvCrowdModel) {
        registry::release(model)
    }

    fn rlv_crowd_model_info(model: RlvCrowdModel, out: *mut RlvCrowdModelInfo) {
        let object = registry::get(model)?;
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        unsafe { write_descriptor(out, info_of(&object.model)) }
    }

    fn rlv_crowd_model_clip(model: RlvCrowdModel, clip: u32, out: *mut RlvCrowdClip) {
        let object = registry::get(model)?;
        let found = clip_of(&object.model, clip)?;
        let (pose_count, rate, name) = (found.poses.len() as u32, found.rate, fixed(&found.name));
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        unsafe { write_descriptor(out, RlvCrowdClip { struct_size: 0, pose_count, rate, name }) }
    }

    fn rlv_crowd_model_material(model: RlvCrowdModel, material: u32, out: *mut RlvCrowdMaterial) {
        let object = registry::get(model)?;
        let names = &object.model.character.material_names;
        let name = names.get(material as usize).ok_or_else(|| {
            Error::invalid(format!("material {material} does not exist"))
                .at("material")
                .advise(format!("the model has {} materials counted from 0", names.len()))
        })?;
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        unsafe { write_descriptor(out, RlvCrowdMaterial { struct_size: 0, name: fixed(name) }) }
    }

    fn rlv_crowd_model_get_vertices(model: RlvCrowdModel, vertices: *const RlvCrowdVertices) {
        let object = registry::get(model)?;
        // SAFETY: a descriptor of nothing but numbers and NULL pointers.
        let default: RlvCrowdVertices = unsafe { std::mem::zeroed() };
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        let given = unsafe { read_descriptor(vertices, default) }?;
        let character = &object.model.character;
        let (count, capacity) = (character.points.len(), given.capacity);
        // SAFETY: the caller promises room for `capacity` vertices in each array that is not NULL.
        let (points, normals, uvs, bones, weights) = unsafe {
            (
                Output::<[f32; 3]>::optional("points", given.points.cast(), capacity, 0)?,
                Output::<[f32; 3]>::optional("normals", given.normals.cast(), capacity, 0)?,
                Output::<[f32; 2]>::optional("uvs", given.uvs.cast(), capacity, 0)?,
                Output::<[u32; 4]>::optional("bones", given.bones.cast(), capacity, 0)?,
                Output::<[f32; 4]>::optional("weights", given.weights.cast(), capacity, 0)?,
            )
        };
        if capacity < count {
            return Err(Error::invalid(format!("there is room for {capacity} vertices, but there are {count}"))
                .at("capacity")
                .advise("ask rlv_crowd_model_info for the count"));
        }
        let found = character.values("uv").map(|values| values.as_chunks::<2>().0);
        fill(uvs, "uvs", found.filter(|found| found.len() == count).map(|found| found.iter().copied()))?;
        let found = character.values("normal").map(|values| values.as_chunks::<3>().0.iter().copied());
        fill(normals, "normals", found)?;
        fill(points, "points", Some(character.points.iter().copied()))?;
        fill(bones, "bones", Some(character.influences.iter().map(|it| it.bones.map(u32::from))))?;
        fill(weights, "weights", Some(character.influences.iter().map(|it| it.weights)))
    }

    fn rlv_crowd_model_get_collapses(
        model: RlvCrowdModel,
        collapses: *mut RlvCrowdCollapse,
        capacity: usize,
        stride: usize,
    ) {
        let object = registry::get(model)?;
        // SAFETY: the caller promises room for `capacity` elements.
        let out = unsafe { Output::new("collapses", collapses, capacity, stride) }?;
        if !object.model.has_collapses() {
            return Err(Error::unsupported("the file of the model does not say where vertices go")
                .at("model")
                .advise("build it again"));
        }
        let found = object.model.collapses.iter();
        let found = found.map(|it| RlvCrowdCollapse { group: it.group, target: it.target });
        fill(Some(out), "collapses", Some(found))
    }

    fn rlv_crowd_model_get_offsets(
        model: RlvCrowdModel,
        offsets: *mut RlvCrowdOffset,
        capacity: usize,
        stride: usize,
    ) {
        let object = registry::get(model)?;
        // SAFETY: the caller promises room for `capacity` offsets.
        let out = unsafe { Output::new("offsets", offsets, capacity, stride) }?;
        let morphs = &object.model.character.morphs;
        let vertices = 0..object.model.character.points.len();
        let of = |vertex: usize| {
            let found = morphs.of(vertex).iter();
            found.map(move |it| RlvCrowdOffset { vertex: vertex as u32, morph: it.morph, offset: it.offset })
        };
        let found: Vec<RlvCrowdOffset> = vertices.flat_map(of).collect();
        fill(Some(out), "offsets", Some(found.into_iter()))
    }

    fn rlv_crowd_model_get_triangles(
        model: RlvCrowdModel,
        triangles: *mut u32,
        materials: *mut u32,
        capacity: usize,
    ) {
        let object = registry::get(model)?;
        let character = &object.model.character;
        // SAFETY: the caller promises room for `capacity` triangles, or NULL for what is not wanted.
        let (corners, slots) = unsafe {
            (
                Output::<[u32; 3]>::optional("triangles", triangles.cast(), capacity, 0)?,
                Output::optional("materials", materials, capacity, 0)?,
            )
        };
        let slots = slots.map(|out| out.holds("materials", character.materials.len())).transpose()?;
        fill(corners, "triangles", Some(character.triangles.iter().copied()))?;
        fill(slots, "materials", Some(character.materials.iter().copied()))
    }

    fn rlv_crowd_model_get_clusters(
        model: RlvCrowdModel,
        clusters: *mut RlvCrowdCluster,
        capacity: usize,
        stride: usize,
    ) {
        let object = registry::get(model)?;
        // SAFETY: the caller promises room for `capacity` clusters.
        let out = unsafe { Output::new("clusters", clusters, capacity, stride) }?;
        let clusters = object.model.clusters.iter().map(|cluster| RlvCrowdCluster {
            first_triangle: cluster.first,
            triangle_count: cluster.count,
            made_by: cluster.made_by,
            used_by: cluster.used_by,
            depth: cluster.depth,
            deformation: cluster.deformation,
        });
        fill(Some(out), "clusters", Some(clusters))
    }

    fn rlv_crowd_model_mesh(model: RlvCrowdModel, error: f32, clip: u32, pose: u32, out: *mut RlvMesh) {
        present("out", out)?;
        let object = registry::get(model)?;
        if !(error >= 0.0) {
            return Err(Error::invalid(format!("the error is {error}")).at("error").advise("use 0 or more"));
        }
        let found = clip_of(&object.model, clip)?;
        let posed = found.poses.get(pose as usize).ok_or_else(|| {
            Error::invalid(format!("pose {pose} does not exist"))
                .at("pose")
                .advise(format!("the clip has {} poses counted from 0", found.poses.len()))
        })?;
        let clusters = if error == 0.0 { object.model.input_clusters() } else { object.model.cut(error) };
        let made = object.model.mesh(&object.context.context, &clusters, posed)?;
        let handle = mesh::register(object.context.clone(), made)?;
        // SAFETY: checked above.
        unsafe { put(out, handle) };
        Ok(())
    }

    fn rlv_crowd_create(context: RlvContext, models: *const RlvCrowdModel, count: usize, out: *mut RlvCrowd) {
        present("out", out)?;
        let context = registry::get(context)?;
        // SAFETY: the caller promises `count` handles.
        let handles = unsafe { Input::new("models", models, count, 0) }?;
        if handles.is_empty() {
            return Err(Error::invalid("there is no model").at("models").advise("give one at least"));
        }
        let models = handles.iter().map(|handle| registry::get(handle).map(|object| Arc::clone(&object.model)));
        let crowd = Crowd::new(models.collect::<Result<Vec<_>>>()?);
        let state = State {
            crowd,
            frame: Frame::default(),
            occlusion: Occlusion::default(),
            list: DrawList::default(),
            shown: ShownImpostors::default(),
            is_cut: false,
        };
        let handle = registry::insert(CrowdObject { context, state: RwLock::new(state) })?;
        // SAFETY: checked above.
        unsafe { put(out, handle) };
        Ok(())
    }

    fn rlv_crowd_retain(crowd: RlvCrowd) {
        registry::retain(crowd)
    }

    fn rlv_crowd_release(crowd: RlvCrowd) {
        registry::release(crowd)
    }

    fn rlv_crowd_add(crowd: RlvCrowd, agents: *const RlvCrowdAgent, count: usize, stride: usize, first: *mut u32) {
        let object = registry::get(crowd)?;
        // SAFETY: the caller promises `count` agents.
        let agents = unsafe { Input::new("agents", agents, count, stride) }?;
        let mut state = try_write(&object.state, "crowd")?;
        let start = state.crowd.agents().len();
        // All are checked before one is added.
        for (at, agent) in agents.iter().enumerate() {
            state.crowd.check(&agent_of(&agent)).map_err(|error| error.at(format!("agent {at}")))?;
        }
        if agents.len() > relievo_crowd::MOST_AGENTS - start {
            let most = relievo_crowd::MOST_AGENTS;
            return Err(Error::unsupported(format!("a crowd has at most {most} agents")).at("count"));
        }
        agents.iter().try_for_each(|agent| state.crowd.add(agent_of(&agent)).map(drop))?;
        state.is_cut = false;
        if !first.is_null() {
            // SAFETY: the caller gives NULL or a place for a number.
            unsafe { put(first, start as u32) };
        }
        Ok(())
    }

    fn rlv_crowd_set(crowd: RlvCrowd, first: u32, agents: *const RlvCrowdAgent, count: usize, stride: usize) {
        let object = registry::get(crowd)?;
        // SAFETY: the caller promises `count` agents.
        let agents = unsafe { Input::new("agents", agents, count, stride) }?;
        let mut state = try_write(&object.state, "crowd")?;
        let known = state.crowd.agents().len();
        if (first as usize).checked_add(count).is_none_or(|end| end > known) {
            return Err(Error::invalid(format!("agents {first} and {count} more go beyond the {known} there are"))
                .at("first")
                .advise("add them by rlv_crowd_add"));
        }
        for (at, agent) in agents.iter().enumerate() {
            state.crowd.check(&agent_of(&agent)).map_err(|error| error.at(format!("agent {at}")))?;
        }
        for (agent, index) in agents.iter().zip(first..) {
            state.crowd.set(index, agent_of(&agent))?;
        }
        state.is_cut = false;
        Ok(())
    }

    fn rlv_crowd_set_weights(crowd: RlvCrowd, agent: u32, weights: *const f32, count: usize) {
        let object = registry::get(crowd)?;
        // SAFETY: the caller promises `count` weights.
        let given = unsafe { Input::new("weights", weights, count, 0) }?;
        let mut state = try_write(&object.state, "crowd")?;
        let given = given.to_vec("weights", object.context.context.memory_limit())?;
        let weights = (!weights.is_null()).then_some(given.as_slice());
        state.crowd.set_weights(agent, weights).map_err(|error| error.at("weights"))?;
        state.is_cut = false;
        Ok(())
    }

    fn rlv_crowd_cut(crowd: RlvCrowd, view: *const RlvCrowdView, out: *mut RlvCrowdFrame) {
        let object = registry::get(crowd)?;
        // SAFETY: the caller gives NULL or descriptors that start with their size.
        let Seen { view, eye, pixels, time } = unsafe {
            check_optional(out)?;
            view_of(view)?
        };
        let mut state = try_write(&object.state, "crowd")?;
        let State { crowd, frame, occlusion, list, shown, is_cut } = &mut *state;
        *is_cut = false;
        let context = &object.context.context;
        crowd.cut(context, &view, frame)?;
        let culled = match pixels {
            Some(pixels) => occlusion.cull(context, crowd, (&pixels, time), frame)?,
            None => Culled::default(),
        };
        list.update(crowd, frame, time)?;
        let [impostor_count, picture_count] = shown.update(context, (crowd, frame, time), eye)?;
        *is_cut = true;
        let found = RlvCrowdFrame {
            struct_size: 0,
            agent_count: list.instances.len() as u32,
            draw_count: list.draws.len() as u32,
            matrix_count: list.matrices.len() as u32,
            changed: frame.changed,
            hidden: culled.hidden,
            clusters: frame.clusters,
            triangles: frame.triangles,
            hidden_triangles: culled.hidden_triangles,
            occluder_triangles: culled.occluder_triangles,
            weight_count: list.weights.len() as u32,
            impostor_count,
            picture_count,
            reserved: 0,
        };
        // SAFETY: checked above.
        unsafe { write_optional(out, found) }
    }

    fn rlv_crowd_get(crowd: RlvCrowd, buffers: *const RlvCrowdBuffers) {
        let object = registry::get(crowd)?;
        // SAFETY: a descriptor of nothing but numbers and NULL pointers.
        let default: RlvCrowdBuffers = unsafe { std::mem::zeroed() };
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        let given = unsafe { read_descriptor(buffers, default) }?;
        let state = try_read(&object.state, "crowd")?;
        state.check_cut()?;
        // SAFETY: the caller promises room for the capacities in each array that is not NULL.
        unsafe { write_list(&given, &state.list) }
    }
}

/// Writes a list of draws to the arrays of C.
///
/// # Safety
/// There is room for the capacities in each array that is not NULL.
pub(crate) unsafe fn write_list(given: &RlvCrowdBuffers, list: &DrawList) -> Result<()> {
    // SAFETY: the caller promises room for the capacities in each array that is not NULL.
    let (draws, clusters, instances, matrices, weights, first_weights, blends) = unsafe {
        (
            Output::optional("draws", given.draws, given.draw_capacity, given.draw_stride)?,
            Output::<[u32; 2]>::optional("clusters", given.clusters.cast(), given.draw_capacity, 0)?,
            Output::optional("instances", given.instances, given.instance_capacity, given.instance_stride)?,
            Output::<[f32; 12]>::optional(
                "matrices",
                given.matrices.cast(),
                given.matrix_capacity,
                given.matrix_stride,
            )?,
            Output::optional("weights", given.weights, given.weight_capacity, 0)?,
            Output::optional("first_weights", given.first_weights, given.instance_capacity, 0)?,
            Output::optional("blends", given.blends, given.draw_capacity, 0)?,
        )
    };
    // Nothing is written unless there is room for all.
    draws.map(|out| out.holds("draws", list.draws.len())).transpose()?;
    clusters.map(|out| out.holds("clusters", list.clusters.len())).transpose()?;
    instances.map(|out| out.holds("instances", list.instances.len())).transpose()?;
    matrices.map(|out| out.holds("matrices", list.matrices.len())).transpose()?;
    weights.map(|out| out.holds("weights", list.weights.len())).transpose()?;
    first_weights.map(|out| out.holds("first_weights", list.first_weights.len())).transpose()?;
    blends.map(|out| out.holds("blends", list.blends.len())).transpose()?;
    fill(draws, "draws", Some(list.draws.iter().map(draw_of)))?;
    fill(clusters, "clusters", Some(list.clusters.iter().copied()))?;
    fill(instances, "instances", Some(list.instances.iter().map(instance_of)))?;
    fill(matrices, "matrices", Some(list.matrices.iter().map(|rows| flat(*rows))))?;
    fill(weights, "weights", Some(list.weights.iter().copied()))?;
    fill(first_weights, "first_weights", Some(list.first_weights.iter().copied()))?;
    fill(blends, "blends", Some(list.blends.iter().copied()))
}

/// Returns a clip of a model.
fn clip_of(model: &CrowdModel, clip: u32) -> Result<&relievo_crowd::Clip> {
    model.clips.get(clip as usize).ok_or_else(|| {
        Error::invalid(format!("clip {clip} does not exist"))
            .at("clip")
            .advise(format!("the model has {} clips counted from 0", model.clips.len()))
    })
}

fn draw_of(draw: &Draw) -> RlvCrowdDraw {
    let Draw { index_count, instance_count, first_index, base_vertex, first_instance } = *draw;
    RlvCrowdDraw { index_count, instance_count, first_index, base_vertex, first_instance }
}

fn instance_of(instance: &Instance) -> RlvCrowdInstance {
    let Instance { agent, first_matrix, transform } = *instance;
    RlvCrowdInstance { agent, first_matrix, transform: flat(transform) }
}

/// Returns the numbers of a map, row after row.
fn flat(rows: [[f32; 4]; 3]) -> [f32; 12] {
    std::array::from_fn(|at| rows[at / 4][at % 4])
}
