//! Models of crowds; see `include/relievo/crowd.h`.

use std::ffi::c_char;
use std::path::PathBuf;
use std::sync::Arc;

use relievo_core::{Error, Result};
use relievo_crowd::{Blend, CrowdModel, NONE};

use super::fill;
use crate::border::array::{Output, Plain, fixed, present, put, text};
use crate::border::descriptor::{numbered, read_descriptor, write_descriptor};
use crate::border::making::Making;
use crate::border::registry::{self, handle};
use crate::runtime::bytes::{self, RlvBytes};
use crate::runtime::context::{ContextObject, RLV_NAME_SIZE, RLV_TEXT_SIZE, RlvContext};
use crate::surfaces::mesh::{self, RlvMesh};

handle!(RlvCrowdModel, 32, CrowdModelObject);

constants! {
    u32:
    RLV_CROWD_BLEND_LINEAR = 0,
    RLV_CROWD_BLEND_DUAL_QUATERNION = 1,
}

/// Ways to blend bones in the order of their numbers.
const BLENDS: [(Blend, &str); 2] = [(Blend::Linear, "linear"), (Blend::DualQuaternion, "dual")];

descriptor! {
    pub struct RlvCrowdModelInfo before blend {
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
        blend: u32,
        reserved: u32,
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

// SAFETY: a handle is one integer.
unsafe impl Plain for RlvCrowdModel {}
// SAFETY: integers of four bytes without padding.
unsafe impl Plain for RlvCrowdCollapse {}
// SAFETY: integers and floats of four bytes without padding.
unsafe impl Plain for RlvCrowdOffset {}
// SAFETY: integers and floats of four bytes without padding.
unsafe impl Plain for RlvCrowdCluster {}

/// A model, which the crowds that show it share.
pub struct CrowdModelObject {
    pub(super) context: Arc<ContextObject>,
    pub(super) model: Arc<CrowdModel>,
}

impl CrowdModelObject {
    pub fn new(context: Arc<ContextObject>, model: Arc<CrowdModel>) -> Self {
        Self { context, model }
    }
}

pub(super) fn register(context: Arc<ContextObject>, model: CrowdModel) -> Result<RlvCrowdModel> {
    registry::insert(CrowdModelObject::new(context, Arc::new(model)))
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
        blend: match model.blend {
            Blend::Linear => RLV_CROWD_BLEND_LINEAR,
            Blend::DualQuaternion => RLV_CROWD_BLEND_DUAL_QUATERNION,
        },
        reserved: 0,
    }
}

/// Returns a clip of a model.
fn clip_of(model: &CrowdModel, clip: u32) -> Result<&relievo_crowd::Clip> {
    model.clips.get(clip as usize).ok_or_else(|| {
        Error::invalid(format!("clip {clip} does not exist"))
            .at("clip")
            .advise(format!("the model has {} clips counted from 0", model.clips.len()))
    })
}

/// Reads which crowd model is read.
///
/// # Errors
/// Fails with `Invalid` if the handle is not alive or the path is no text. What the work refuses, it returns: a file that
/// cannot be read or is damaged, or `Cancelled`.
///
/// # Safety
/// `path` is NULL or a NUL-terminated text.
pub unsafe fn reading(context: RlvContext, path: *const c_char) -> Result<Making<RlvCrowdModel>> {
    let context = registry::get(context)?;
    // SAFETY: promised by the caller.
    let path = PathBuf::from(unsafe { text("path", path) }?);
    Ok(Making::new(context.clone(), move |progress| {
        progress.step(0.0, "read")?;
        let model = CrowdModel::load(&context.context, &path)?;
        progress.step(1.0, "read")?;
        register(context, model)
    }))
}

/// Reads where a crowd model is written to.
///
/// # Errors
/// Fails with `Invalid` if the handle is not alive or the path is no text. What the work refuses, it returns: a file that
/// cannot be written, or `Cancelled`.
///
/// # Safety
/// As for [`reading`].
pub unsafe fn writing(model: RlvCrowdModel, path: *const c_char) -> Result<Making<()>> {
    let object = registry::get(model)?;
    // SAFETY: promised by the caller.
    let path = PathBuf::from(unsafe { text("path", path) }?);
    Ok(Making::new(object.context.clone(), move |progress| {
        progress.step(0.0, "write")?;
        object.model.save(&path)?;
        progress.report(1.0, "write");
        Ok(())
    }))
}

/// Reads how the bones of a crowd model are to be blended.
///
/// # Errors
/// Fails with `Invalid` if the handle is not alive or there is no such way. What the work refuses, it returns: `Cancelled`.
pub fn blending(model: RlvCrowdModel, blend: u32) -> Result<Making<RlvCrowdModel>> {
    let object = registry::get(model)?;
    let blend = numbered("blend", &BLENDS, blend)?;
    Ok(Making::new(object.context.clone(), move |progress| {
        let made = object.model.with_blend_watched(&object.context.context, blend, progress)?;
        register(object.context.clone(), made)
    }))
}

entry! {
    fn rlv_crowd_model_with_blend(model: RlvCrowdModel, blend: u32, out: *mut RlvCrowdModel) {
        present("out", out)?;
        let handle = blending(model, blend)?.now()?;
        // SAFETY: checked above.
        unsafe { put(out, handle) };
        Ok(())
    }

    fn rlv_crowd_model_read(context: RlvContext, path: *const c_char, out: *mut RlvCrowdModel) {
        present("out", out)?;
        // SAFETY: the caller gives NULL or a NUL-terminated text.
        let handle = unsafe { reading(context, path) }?.now()?;
        // SAFETY: checked above.
        unsafe { put(out, handle) };
        Ok(())
    }

    fn rlv_crowd_model_write(model: RlvCrowdModel, path: *const c_char) {
        // SAFETY: the caller gives NULL or a NUL-terminated text.
        unsafe { writing(model, path) }?.now()
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
        object.model.check_triangles()?;
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
        object.model.check_triangles()?;
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
}
