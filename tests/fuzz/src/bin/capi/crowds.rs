//! Crowds: models of small files and of their bytes, agents that are placed and cut, and their draws.

use std::ffi::CString;
use std::fs;
use std::path::PathBuf;
use std::ptr::{null, null_mut};
use std::sync::LazyLock;

use libfuzzer_sys::arbitrary::{Result, Unstructured};
use relievo_abi::bytes::*;
use relievo_abi::context::RlvContext;
use relievo_abi::crowd::*;
use relievo_abi::device_crowd::*;
use relievo_abi::job::*;
use relievo_abi::mesh::RlvMesh;
use relievo_core::Context;
use relievo_core::progress::Silent;
use relievo_crowd::{BuildSettings, CrowdModel};

use super::{Handles, UNTOUCHED, called, count, made, matrix, number, numbers, place, sized, wait};

/// Vertices of an arm: rings of as many sides.
const SIDES: u32 = 6;
/// Texels of a picture of an impostor.
const TEXELS: usize = RLV_CROWD_PICTURE_SIDE * RLV_CROWD_PICTURE_SIDE;

/// Files of two arms with the same triangles, of another one, and of none.
static FILES: LazyLock<[CString; 4]> = LazyLock::new(|| {
    [("arm", 6, 0.01), ("rough", 6, 0.1), ("short", 4, 0.01), ("none", 0, 0.0)]
        .map(|(name, rings, bumps)| file(name, rings, bumps))
});

/// The bytes of the model of the first arm.
pub static MODEL: LazyLock<Vec<u8>> = LazyLock::new(|| {
    let context = Context::serial();
    let path = FILES[0].to_str().expect("a path");
    let source = relievo_meshio::read_model(&context, path.as_ref()).expect("an arm");
    let settings =
        BuildSettings { cluster_triangles: 16, group_clusters: 4, pose_rate: 4.0, ..BuildSettings::default() };
    let model = CrowdModel::build(&context, &source, &[0], &settings, &mut Silent).expect("a model");
    let mut made = Vec::new();
    model.write(&mut made).expect("memory");
    made
});

/// The folder of the files of this process.
pub fn folder() -> PathBuf {
    std::env::temp_dir().join(format!("relievo-fuzz-capi-{}", std::process::id()))
}

/// Writes a tube of some rings that bends within a second, and grows by a morph target, as glTF; without rings nothing.
/// Returns its path.
fn file(name: &str, rings: u32, bumps: f32) -> CString {
    let folder = folder();
    let path = folder.join(format!("{name}.gltf"));
    let made = CString::new(path.to_str().expect("a path")).expect("a path");
    if rings == 0 {
        return made;
    }
    let (mut points, mut offsets, mut joints, mut weights) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    for (ring, side) in (0..rings).flat_map(|ring| (0..SIDES).map(move |side| (ring, side))) {
        let (angle, along) = (side as f32 * std::f32::consts::TAU / SIDES as f32, ring as f32 / (rings - 1) as f32);
        let radius = 0.2 + bumps * ((3 * ring + 2 * side) as f32).sin();
        points.extend([radius * angle.cos(), along, radius * angle.sin()]);
        offsets.extend([0.1 * angle.cos(), 0.0, 0.1 * angle.sin()]);
        joints.extend([0_u16, 1, 0, 0]);
        weights.extend([1.0 - along, along, 0.0, 0.0]);
    }
    let mut indices = Vec::new();
    for (ring, side) in (0..rings - 1).flat_map(|ring| (0..SIDES).map(move |side| (ring, side))) {
        let (low, next) = (ring * SIDES + side, ring * SIDES + (side + 1) % SIDES);
        indices.extend([low, low + SIDES, next + SIDES, low, next + SIDES, next]);
    }
    let vertices = rings * SIDES;
    let floats = |values: &[f32]| values.iter().flat_map(|value| value.to_le_bytes()).collect::<Vec<u8>>();
    let parts = [
        (floats(&points), vertices, 5126, "VEC3"),
        (joints.iter().flat_map(|joint| joint.to_le_bytes()).collect(), vertices, 5123, "VEC4"),
        (floats(&weights), vertices, 5126, "VEC4"),
        (indices.iter().flat_map(|index| index.to_le_bytes()).collect(), indices.len() as u32, 5125, "SCALAR"),
        (floats(&[0.0, 1.0]), 2, 5126, "SCALAR"),
        (floats(&[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.6, 0.8]), 2, 5126, "VEC4"),
        (floats(&offsets), vertices, 5126, "VEC3"),
        (floats(&[0.0, 1.0]), 2, 5126, "SCALAR"),
    ];
    let (mut views, mut accessors, mut buffer) = (Vec::new(), Vec::new(), Vec::new());
    for (view, (bytes, count, component, kind)) in parts.iter().enumerate() {
        let (start, length) = (buffer.len(), bytes.len());
        views.push(format!(r#"{{"buffer":0,"byteOffset":{start},"byteLength":{length}}}"#));
        accessors.push(format!(
            r#"{{"bufferView":{view},"componentType":{component},"count":{count},"type":"{kind}","min":[-1,-1,-1],"max":[1,1,1]}}"#
        ));
        buffer.extend(bytes);
    }
    let text = format!(
        r#"{{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0,1]}}],"nodes":[{{"mesh":0,"skin":0}},{{"children":[2]}},{{}}],
        "skins":[{{"joints":[1,2]}}],"meshes":[{{"primitives":[{{"attributes":{{"POSITION":0,"JOINTS_0":1,"WEIGHTS_0":2}},"indices":3,
        "targets":[{{"POSITION":6}}]}}]}}],"animations":[{{"name":"bend","channels":[
        {{"sampler":0,"target":{{"node":2,"path":"rotation"}}}},{{"sampler":1,"target":{{"node":0,"path":"weights"}}}}],
        "samplers":[{{"input":4,"output":5}},{{"input":4,"output":7}}]}}],
        "buffers":[{{"uri":"{name}.bin","byteLength":{}}}],"bufferViews":[{}],"accessors":[{}]}}"#,
        buffer.len(),
        views.join(","),
        accessors.join(",")
    );
    fs::create_dir_all(&folder).and_then(|()| fs::write(&path, text)).expect("a folder for files");
    fs::write(path.with_extension("bin"), buffer).expect("a folder for files");
    made
}

/// Models: built, refitted and read, at once and as jobs, and their arrays.
pub fn models(bytes: &mut Unstructured, handles: &mut Handles) -> Result<()> {
    let context = RlvContext { id: handles.pick(bytes, 0)? };
    let stored = &*MODEL;
    let length = if bytes.ratio(1, 8)? { bytes.int_in_range(0..=stored.len())? } else { stored.len() };
    let mut out = RlvCrowdModel { id: UNTOUCHED };
    // SAFETY: so many bytes are there.
    let result = unsafe { rlv_crowd_model_read_bytes(context, stored.as_ptr(), length, &mut out) };
    made(result, out.id, &mut handles.crowd_models);

    let model = RlvCrowdModel { id: handles.pick(bytes, 25)? };
    // Builds take longer than all else.
    if bytes.ratio(1, 8)? {
        make(bytes, handles, context, model)?;
    }
    look(bytes, handles, model)
}

/// Builds, refits, reads and writes models.
fn make(bytes: &mut Unstructured, handles: &mut Handles, context: RlvContext, model: RlvCrowdModel) -> Result<()> {
    let mut settings: RlvCrowdBuildSettings = sized(bytes)?;
    settings.settings =
        BuildSettings { cluster_triangles: 16, group_clusters: 4, pose_rate: 4.0, ..BuildSettings::default() };
    if bytes.ratio(1, 4)? {
        settings.settings.pose_distance = number(bytes)?;
        settings.settings.pose_rate = number(bytes)?;
        settings.settings.cluster_triangles = bytes.int_in_range(0..=300)?;
        settings.settings.group_clusters = bytes.int_in_range(0..=40)?;
    }
    let names = [c"bend".as_ptr(), c"0".as_ptr(), c"walk".as_ptr(), null()];
    let clips = [RlvCrowdClipName { name: *bytes.choose(&names[..])? }, RlvCrowdClipName { name: c"bend".as_ptr() }];
    let (clips, clip_count) = if bytes.ratio(1, 4)? { (clips.as_ptr(), count(bytes, 2)?) } else { (null(), 0) };
    let path = if bytes.ratio(1, 16)? { null() } else { bytes.choose(&FILES[..])?.as_ptr() };
    let nowhere = c"/nowhere/nothing.rcrowd".as_ptr();
    let mut report: RlvCrowdRefitReport = sized(bytes)?;
    let mut patience = if bytes.ratio(1, 4)? { bytes.int_in_range(0..=40_u32)? } else { u32::MAX };
    let user = (&raw mut patience).cast();
    let (mut out, mut job) = (RlvCrowdModel { id: UNTOUCHED }, RlvJob { id: UNTOUCHED });
    // SAFETY: descriptors are sized, texts end, there are two names, and the user pointer is what the callback takes it for.
    unsafe {
        let blend = bytes.int_in_range(0..=2)?;
        let result = match bytes.int_in_range(0..=7_u8)? {
            0 => rlv_crowd_model_build(context, path, clips, clip_count, &settings, Some(wait), user, &mut out),
            1 => {
                let report: *mut RlvCrowdRefitReport = if bytes.ratio(1, 4)? { null_mut() } else { &mut report };
                rlv_crowd_model_refit(model, path, clips, clip_count, &settings, Some(wait), user, report, &mut out)
            }
            2 => rlv_crowd_model_read(context, nowhere, &mut out),
            6 => rlv_crowd_model_with_blend(model, blend, &mut out),
            at => {
                let result = match at {
                    3 => rlv_job_crowd(context, path, clips, clip_count, &settings, &mut job),
                    4 => rlv_job_crowd_refit(model, path, clips, clip_count, &settings, &mut job),
                    5 => rlv_job_crowd_model_with_blend(model, blend, &mut job),
                    _ => rlv_job_crowd_model_write(model, nowhere, &mut job),
                };
                made(result, job.id, &mut handles.jobs);
                let started = RlvJob { id: handles.pick(bytes, 12)? };
                called(rlv_job_wait(started, -1.0, null_mut()));
                if called(rlv_job_crowd_refit_report(started, &mut report)) {
                    assert!(report.growth.is_finite() && report.growth > 0.0);
                }
                rlv_job_crowd_model(started, &mut out)
            }
        };
        made(result, out.id, &mut handles.crowd_models);
    }
    Ok(())
}

/// Asks for all that a model has, in arrays that may be too small.
fn look(bytes: &mut Unstructured, handles: &mut Handles, model: RlvCrowdModel) -> Result<()> {
    let mut info: RlvCrowdModelInfo = sized(bytes)?;
    let (mut clip, mut material): (RlvCrowdClip, RlvCrowdMaterial) = (sized(bytes)?, sized(bytes)?);
    let mut error = number(bytes)?;
    if bytes.ratio(3, 4)? {
        error = error.abs() / 64.0;
    }
    let (index, pose) = (bytes.int_in_range(0..=1)?, bytes.int_in_range(0..=4)?);
    let mut mesh = RlvMesh { id: UNTOUCHED };
    let (mut held, mut data, mut size) = (RlvBytes { id: UNTOUCHED }, null(), 0);
    // SAFETY: descriptors are sized, texts end, and the outputs are there.
    unsafe {
        called(rlv_crowd_params(&mut null(), &mut size));
        called(rlv_crowd_model_info(model, &mut info));
        called(rlv_crowd_model_clip(model, index, &mut clip));
        called(rlv_crowd_model_material(model, index, &mut material));
        called(rlv_crowd_model_write(model, c"/nowhere/nothing.rcrowd".as_ptr()));
        if called(rlv_crowd_model_write_bytes(model, &mut held)) {
            assert!(called(rlv_bytes_get(held, &mut data, &mut size)));
            assert_eq!(std::slice::from_raw_parts(data, 4), &MODEL[..4]);
            assert!(called(rlv_bytes_release(held)));
        }
        let result = rlv_crowd_model_mesh(model, error, index, pose, &mut mesh);
        made(result, mesh.id, &mut handles.meshes);
    }
    let vertices = (info.vertex_count as usize).min(1 << 12);
    let triangles = (info.triangle_count as usize).min(1 << 14);
    let clusters = (info.cluster_count as usize).min(1 << 10);
    let offsets = (info.offset_count as usize).min(1 << 12);
    let (mut points, mut uvs, mut bones) =
        (vec![0.0_f32; 3 * vertices], vec![0.0_f32; 2 * vertices], vec![0; 4 * vertices]);
    let mut weights = vec![0.0_f32; 4 * vertices];
    let mut arrays: RlvCrowdVertices = sized(bytes)?;
    arrays.capacity = count(bytes, vertices)?;
    (arrays.points, arrays.bones, arrays.weights) = (points.as_mut_ptr(), bones.as_mut_ptr(), weights.as_mut_ptr());
    arrays.uvs = if bytes.ratio(1, 8)? { uvs.as_mut_ptr() } else { null_mut() };
    let mut collapses = vec![RlvCrowdCollapse::default(); vertices];
    let mut moved = vec![RlvCrowdOffset::default(); offsets];
    let (mut corners, mut materials) = (vec![0_u32; 3 * triangles], vec![0_u32; triangles]);
    let mut parts = vec![RlvCrowdCluster::default(); clusters];
    let room = count(bytes, triangles)?;
    // SAFETY: arrays have the room that is said.
    unsafe {
        if called(rlv_crowd_model_get_vertices(model, &arrays)) {
            assert!(bones.iter().all(|bone| *bone < info.bone_count.max(1)));
            assert!(points.iter().chain(&weights).all(|value| value.is_finite()));
        }
        if called(rlv_crowd_model_get_collapses(model, collapses.as_mut_ptr(), count(bytes, vertices)?, 0)) {
            assert!(collapses.iter().all(|it| (it.target as usize) < vertices));
        }
        if called(rlv_crowd_model_get_offsets(model, moved.as_mut_ptr(), count(bytes, offsets)?, 0)) {
            assert!(moved.iter().all(|it| (it.vertex as usize) < vertices && it.morph < info.morph_count));
        }
        if called(rlv_crowd_model_get_triangles(model, corners.as_mut_ptr(), materials.as_mut_ptr(), room)) {
            assert!(corners.iter().all(|corner| (*corner as usize) < vertices));
        }
        if called(rlv_crowd_model_get_clusters(model, parts.as_mut_ptr(), count(bytes, clusters)?, 0)) {
            let inside = |part: &RlvCrowdCluster| (part.first_triangle + part.triangle_count) as usize <= triangles;
            assert!(parts.iter().all(inside));
        }
    }
    Ok(())
}

/// Agents that are added, moved and weighed, a view that cuts them, and its draws and impostors, also on a device.
pub fn crowds(bytes: &mut Unstructured, handles: &mut Handles) -> Result<()> {
    let context = RlvContext { id: handles.pick(bytes, 0)? };
    let models = [RlvCrowdModel { id: handles.pick(bytes, 25)? }, RlvCrowdModel { id: handles.pick(bytes, 25)? }];
    let mut out = RlvCrowd { id: UNTOUCHED };
    // SAFETY: there are two models.
    let result = unsafe { rlv_crowd_create(context, models.as_ptr(), count(bytes, 2)?, &mut out) };
    made(result, out.id, &mut handles.crowds);
    let crowd = RlvCrowd { id: handles.pick(bytes, 26)? };
    let mut out = RlvDeviceCrowd { id: UNTOUCHED };
    // SAFETY: the output is there.
    let result = unsafe { rlv_device_crowd_create(crowd, &mut out) };
    made(result, out.id, &mut handles.device_crowds);
    let on_device = RlvDeviceCrowd { id: handles.pick(bytes, 27)? };

    let (own, agents) = (numbers(bytes, 2)?, [agent(bytes)?, agent(bytes)?, agent(bytes)?]);
    let (at, mut first) = (bytes.int_in_range(0..=4)?, UNTOUCHED as u32);
    // SAFETY: there are three agents, and two weights or NULL.
    unsafe {
        called(rlv_crowd_add(crowd, agents.as_ptr(), count(bytes, 3)?, 0, &mut first));
        if bytes.ratio(1, 4)? {
            called(rlv_crowd_set(crowd, at, agents.as_ptr(), count(bytes, 3)?, 0));
        }
        if bytes.ratio(1, 4)? {
            let (own, given) =
                if bytes.ratio(1, 4)? { (null(), 0) } else { (own.as_ptr(), bytes.int_in_range(0..=2)?) };
            called(rlv_crowd_set_weights(crowd, at, own, given));
        }
    }
    let mut view = view(bytes)?;
    let suns = [sun(bytes)?, sun(bytes)?];
    if bytes.ratio(1, 4)? {
        (view.suns, view.sun_count) = (suns.as_ptr(), count(bytes, 2)?);
        view.around = if bytes.ratio(1, 4)? { f64::from(number(bytes)?) } else { 0.0 };
    }
    let (mut frame, mut info): (RlvCrowdFrame, RlvDeviceCrowdInfo) = (sized(bytes)?, sized(bytes)?);
    // SAFETY: descriptors are sized.
    let [is_cut, is_cut_there] = unsafe {
        [called(rlv_crowd_cut(crowd, &view, &mut frame)), called(rlv_device_crowd_cut(on_device, &view, &mut info))]
    };
    if !is_cut {
        frame = RlvCrowdFrame { draw_count: 4, agent_count: 4, impostor_count: 2, picture_count: 2, ..frame };
    }
    if is_cut_there {
        frame.matrix_count = frame.matrix_count.max(info.matrix_count);
    }
    take(bytes, (crowd, on_device), &frame, is_cut)
}

/// An agent that stands in front of a view, or somewhere.
fn agent(bytes: &mut Unstructured) -> Result<RlvCrowdAgent> {
    let mut made = RlvCrowdAgent { phase: f64::from(number(bytes)?), ..RlvCrowdAgent::default() };
    if bytes.ratio(1, 8)? {
        (made.model, made.clip) = (bytes.int_in_range(0..=2)?, bytes.int_in_range(0..=1)?);
    }
    made.transform = matrix(bytes)?.unwrap_or([1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, -2.0]);
    if bytes.ratio(1, 4)? {
        made.transform[11] = -1000.0 * f64::from(number(bytes)?.abs());
    }
    Ok(made)
}

/// A sun, mostly of some direction.
fn sun(bytes: &mut Unstructured) -> Result<RlvCrowdSun> {
    let mut sun = RlvCrowdSun { towards: place(bytes)?, angular_radius: 0.01 };
    if bytes.ratio(1, 8)? {
        sun.angular_radius = f64::from(number(bytes)?);
    }
    Ok(sun)
}

/// A view, mostly of what stands at the origin.
fn view(bytes: &mut Unstructured) -> Result<RlvCrowdView> {
    let mut view: RlvCrowdView = sized(bytes)?;
    (view.width, view.height, view.tolerance) = (bytes.int_in_range(1..=64)?, bytes.int_in_range(1..=64)?, 0.5);
    (view.eye, view.target, view.up, view.fov) = (place(bytes)?, [0.0; 3], [0.0, 1.0, 0.0], 0.6);
    view.time = f64::from(number(bytes)?);
    (view.occlusion, view.geomorph, view.impostors) =
        (bytes.ratio(1, 4)?.into(), bytes.ratio(1, 4)?.into(), bytes.ratio(1, 2)?.into());
    if bytes.ratio(1, 8)? {
        (view.target, view.up, view.fov) = (place(bytes)?, place(bytes)?, f64::from(number(bytes)?));
        (view.tolerance, view.occlusion) = (number(bytes)?, bytes.int_in_range(0..=2)?);
        view.width = if view.occlusion == 0 { bytes.arbitrary()? } else { view.width };
    }
    Ok(view)
}

/// Copies draws and impostors of the last cuts, which are those of `frame` if `is_cut`.
fn take(
    bytes: &mut Unstructured,
    (crowd, on_device): (RlvCrowd, RlvDeviceCrowd),
    frame: &RlvCrowdFrame,
    is_cut: bool,
) -> Result<()> {
    let room = |count: u32| (count as usize).min(1 << 12);
    let (draw_count, agent_count, matrix_count) =
        (room(frame.draw_count), room(frame.agent_count), room(frame.matrix_count));
    let (weight_count, quad_count, picture_count) =
        (room(frame.weight_count), room(frame.impostor_count), room(frame.picture_count).min(8));
    let mut draws = vec![RlvCrowdDraw::default(); draw_count];
    let mut instances = vec![RlvCrowdInstance::default(); agent_count];
    let (mut clusters, mut firsts) = (vec![0_u32; 2 * draw_count], vec![0_u32; agent_count]);
    let (mut matrices, mut weights, mut blends) =
        (vec![0.0_f32; 12 * matrix_count], vec![0.0_f32; weight_count], vec![0.5_f32; draw_count]);
    let mut buffers: RlvCrowdBuffers = sized(bytes)?;
    (buffers.draws, buffers.draw_capacity) = (draws.as_mut_ptr(), count(bytes, draw_count)?);
    (buffers.clusters, buffers.blends) = (clusters.as_mut_ptr(), blends.as_mut_ptr());
    (buffers.instances, buffers.instance_capacity) = (instances.as_mut_ptr(), count(bytes, agent_count)?);
    (buffers.matrices, buffers.matrix_capacity) = (matrices.as_mut_ptr(), count(bytes, matrix_count)?);
    (buffers.weights, buffers.weight_capacity) = (weights.as_mut_ptr(), count(bytes, weight_count)?);
    buffers.first_weights = firsts.as_mut_ptr();
    let mut dual_rows = vec![0.0_f32; 20 * matrix_count];
    buffers.dual_rows = if bytes.ratio(1, 4)? { dual_rows.as_mut_ptr() } else { null_mut() };
    let mut quads = vec![RlvCrowdImpostor::default(); quad_count];
    let mut pictures = vec![RlvCrowdPicture::default(); picture_count];
    let mut texels = vec![RlvCrowdTexel::default(); picture_count * TEXELS];
    let mut squares: RlvCrowdImpostors = sized(bytes)?;
    (squares.impostors, squares.impostor_capacity) = (quads.as_mut_ptr(), count(bytes, quad_count)?);
    (squares.pictures, squares.picture_capacity) = (pictures.as_mut_ptr(), count(bytes, picture_count)?);
    (squares.texels, squares.texel_capacity) = (texels.as_mut_ptr(), count(bytes, texels.len())?);
    let mut objects: RlvDeviceCrowdVulkan = sized(bytes)?;
    // SAFETY: descriptors are sized, and arrays have the room that is said.
    unsafe {
        called(rlv_device_crowd_get(on_device, &buffers));
        called(rlv_device_crowd_get_impostors(on_device, &squares));
        called(rlv_device_crowd_vulkan(on_device, &mut objects));
        if called(rlv_crowd_get(crowd, &buffers)) && is_cut {
            assert!(blends.iter().all(|blend| (0.0..=1.0).contains(blend)));
            assert!(firsts.iter().all(|first| *first as usize <= weight_count));
            assert!(instances.iter().all(|instance| (instance.first_matrix as usize) <= matrix_count));
        }
        if called(rlv_crowd_get_impostors(crowd, &squares)) && is_cut {
            assert!(quads.iter().all(|quad| (quad.picture as usize) < picture_count));
            assert!(pictures.iter().all(|picture| picture.radius > 0.0));
        }
    }
    Ok(())
}
