//! Sequences of C calls on live, dead, foreign and made-up handles, with arrays that are what the headers demand or
//! visibly not. Every failure is an ordinary result: a fault inside the library, or an output written by a failed call,
//! is a bug.
#![no_main]

#[path = "capi/crowds.rs"]
mod crowds;
#[path = "capi/streams.rs"]
mod streams;

use std::ffi::{c_char, c_void};
use std::ptr::{null, null_mut};

use libfuzzer_sys::arbitrary::{Result, Unstructured};
use libfuzzer_sys::fuzz_target;
use relievo_abi::allocator::*;
use relievo_abi::bake::*;
use relievo_abi::bezier::*;
use relievo_abi::brush::*;
use relievo_abi::bytes::*;
use relievo_abi::capability::*;
use relievo_abi::caster::*;
use relievo_abi::collider::*;
use relievo_abi::context::*;
use relievo_abi::crowd::*;
use relievo_abi::decal::*;
use relievo_abi::detail::*;
use relievo_abi::device_crowd::*;
use relievo_abi::diffuse::*;
use relievo_abi::document::*;
use relievo_abi::error::{RLV_ERROR_INTERNAL, RLV_OK, RlvResult};
use relievo_abi::evaluate::*;
use relievo_abi::fluid::*;
use relievo_abi::foam::*;
use relievo_abi::grid::*;
use relievo_abi::imprint::*;
use relievo_abi::isosurface::*;
use relievo_abi::job::*;
use relievo_abi::layer::*;
use relievo_abi::level::*;
use relievo_abi::mesh::*;
use relievo_abi::object::*;
use relievo_abi::particles::*;
use relievo_abi::picture::*;
use relievo_abi::procedural::*;
use relievo_abi::progressive::*;
use relievo_abi::repair::*;
use relievo_abi::shader::*;
use relievo_abi::simplify::*;
use relievo_abi::stroke::*;
use relievo_abi::subdivision::*;
use relievo_abi::surface::*;
use relievo_abi::tessellate::*;
use relievo_abi::tissue::*;
use relievo_core::Context;
use relievo_core::parameter::Switch;
use relievo_particleio::{Channel, Particles, encode_frame};

/// What an output holds that no call may leave a part of.
const UNTOUCHED: u64 = 0xfedc_ba98_7654_3210;

macro_rules! handles {
    ($($noun:ident,)*) => {
        /// Handles by noun. What is in one list may be tried as another.
        #[derive(Default)]
        struct Handles {
            $($noun: Vec<u64>,)*
        }

        impl Handles {
            const NOUNS: usize = [$(stringify!($noun)),*].len();

            fn lists(&self) -> [&[u64]; Self::NOUNS] {
                [$(&self.$noun),*]
            }
        }
    };
}

handles! {
    contexts,
    meshes,
    surfaces,
    details,
    colliders,
    casters,
    tessellations,
    brushes,
    strokes,
    documents,
    procedurals,
    beziers,
    jobs,
    progressives,
    levels,
    fluids,
    isosurfaces,
    particles,
    grids,
    decals,
    foams,
    shaders,
    diffuses,
    tissues,
    simulations,
    crowd_models,
    crowds,
    device_crowds,
}

impl Handles {
    /// A handle of `noun`, mostly one that was given out.
    fn pick(&self, bytes: &mut Unstructured, noun: usize) -> Result<u64> {
        let list = match bytes.int_in_range(0..=31_u8)? {
            0 => return Ok(0),
            1 => return bytes.arbitrary(),
            2 => self.lists()[bytes.int_in_range(0..=Self::NOUNS - 1)?],
            _ => self.lists()[noun],
        };
        if list.is_empty() { Ok(0) } else { bytes.choose(list).copied() }
    }
}

/// Checks what every call promises.
fn called(result: RlvResult) -> bool {
    assert_ne!(result, RLV_ERROR_INTERNAL, "a fault inside the library");
    result == RLV_OK
}

/// Keeps the handle of a call that made one; a call that failed must not have written it.
fn made(result: RlvResult, id: u64, list: &mut Vec<u64>) {
    if called(result) {
        list.push(id);
    } else {
        assert_eq!(id, UNTOUCHED, "a failed call wrote its output");
    }
}

/// A descriptor of zeros but for its size, which is now and then wrong.
fn sized<T>(bytes: &mut Unstructured) -> Result<T> {
    let size = if bytes.ratio(1, 32)? { bytes.int_in_range(0..=size_of::<T>() as u32)? } else { size_of::<T>() as u32 };
    // SAFETY: descriptors are plain numbers and pointers, for which zeros are values, and begin with a u32.
    unsafe {
        let mut value: T = std::mem::zeroed();
        (&raw mut value).cast::<u32>().write(size);
        Ok(value)
    }
}

/// Mostly a small number in eighths, now and then anything.
fn number(bytes: &mut Unstructured) -> Result<f32> {
    if bytes.ratio(1, 64)? { bytes.arbitrary() } else { Ok(f32::from(bytes.arbitrary::<i8>()?) / 8.0) }
}

fn numbers(bytes: &mut Unstructured, count: usize) -> Result<Vec<f32>> {
    (0..count).map(|_| number(bytes)).collect()
}

/// Three doubles, now and then such as no float holds.
fn place(bytes: &mut Unstructured) -> Result<[f64; 3]> {
    if bytes.ratio(1, 64)? {
        bytes.arbitrary()
    } else {
        Ok([number(bytes)?, number(bytes)?, number(bytes)?].map(f64::from))
    }
}

/// A count that says what an array holds, or a little less; with a NULL pointer also more.
fn count(bytes: &mut Unstructured, length: usize) -> Result<usize> {
    if bytes.ratio(1, 16)? { bytes.int_in_range(0..=length) } else { Ok(length) }
}

/// Twelve doubles of an affine map, or none.
fn matrix(bytes: &mut Unstructured) -> Result<Option<[f64; 12]>> {
    if bytes.arbitrary()? {
        return Ok(None);
    }
    let mut matrix = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0];
    for _ in 0..bytes.int_in_range(0..=4)? {
        matrix[bytes.int_in_range(0..=11)?] = f64::from(number(bytes)?);
    }
    for value in &mut matrix[9..] {
        *value = f64::from(number(bytes)?) / 4.0;
    }
    Ok(Some(matrix))
}

fn pointer(matrix: &Option<[f64; 12]>) -> *const f64 {
    matrix.as_ref().map_or(null(), |matrix| matrix.as_ptr())
}

/// Arrays that a mesh borrows.
type Lent = (Vec<f32>, Vec<u32>, Vec<u32>);

/// Frees the arrays of a mesh that is gone.
unsafe extern "C" fn give_up(user: *mut c_void) {
    // SAFETY: they were boxed for this.
    drop(unsafe { Box::from_raw(user.cast::<Lent>()) });
}

fn create_mesh(bytes: &mut Unstructured, handles: &mut Handles) -> Result<()> {
    let (columns, rows) = (bytes.int_in_range(1..=3_u32)?, bytes.int_in_range(1..=3_u32)?);
    let mut corners: Vec<u32> = Vec::new();
    for at in (0..rows).flat_map(|row| (0..columns).map(move |column| row * (columns + 1) + column)) {
        corners.extend([at, at + 1, at + columns + 2, at + columns + 1]);
    }
    if bytes.ratio(1, 8)? {
        let at = bytes.int_in_range(0..=corners.len() - 1)?;
        corners[at] = bytes.int_in_range(0..=20)?;
    }
    let sizes = vec![if bytes.ratio(1, 16)? { bytes.int_in_range(0..=8)? } else { 4_u32 }; corners.len() / 4];
    let mut points = Vec::new();
    for point in 0..(columns + 1) * (rows + 1) {
        points.extend([(point % (columns + 1)) as f32, (point / (columns + 1)) as f32, number(bytes)? / 32.0]);
    }
    let creases: Vec<u32> =
        (0..2 * bytes.int_in_range(0..=2)?).map(|_| bytes.int_in_range(0..=16)).collect::<Result<_>>()?;
    let sharpness = numbers(bytes, creases.len() / 2)?;
    let holes: Vec<u32> = (0..bytes.int_in_range(0..=1)?).map(|_| bytes.int_in_range(0..=9)).collect::<Result<_>>()?;
    let mut arrays: RlvMeshArrays = sized(bytes)?;
    arrays.points = points.as_ptr();
    arrays.point_count = count(bytes, points.len() / 3)?;
    arrays.face_size = 4;
    if bytes.arbitrary()? {
        arrays.face_sizes = sizes.as_ptr();
    }
    arrays.face_count = count(bytes, sizes.len())?;
    arrays.corners = if bytes.ratio(1, 64)? { null() } else { corners.as_ptr() };
    arrays.corner_count = count(bytes, corners.len())?;
    arrays.creases = creases.as_ptr();
    arrays.crease_sharpness = sharpness.as_ptr();
    arrays.crease_count = sharpness.len();
    arrays.holes = holes.as_ptr();
    arrays.hole_count = holes.len();
    if bytes.ratio(1, 64)? {
        // Reading less than an element apart is refused; further apart would leave the array.
        arrays.point_stride = bytes.int_in_range(0..=11)?;
    }
    let context = RlvContext { id: handles.pick(bytes, 0)? };
    let mut out = RlvMesh { id: UNTOUCHED };
    // SAFETY: arrays hold at least what their counts say, or are NULL.
    let result = unsafe { rlv_mesh_create(context, &arrays, &mut out) };
    made(result, out.id, &mut handles.meshes);
    if bytes.ratio(1, 4)? {
        let settings = repair_settings(bytes)?;
        let mut report: RlvRepairReport = sized(bytes)?;
        let mut out = RlvMesh { id: UNTOUCHED };
        let (none, user) = (null(), null_mut());
        // SAFETY: as above; descriptors are sized.
        let result =
            unsafe { rlv_repair_arrays(context, &arrays, none, 0, &settings, None, user, &mut report, &mut out) };
        made(result, out.id, &mut handles.meshes);
    }
    if bytes.ratio(1, 4)? {
        let user: *mut Lent = Box::into_raw(Box::new((points, sizes, corners)));
        let mut out = RlvMesh { id: UNTOUCHED };
        // SAFETY: as above; the arrays live until they are given up.
        let result = unsafe { rlv_mesh_create_borrowed(context, &arrays, Some(give_up), user.cast(), &mut out) };
        made(result, out.id, &mut handles.meshes);
        if result != RLV_OK {
            // SAFETY: nobody has them.
            unsafe { give_up(user.cast()) };
        }
    }
    Ok(())
}

/// Settings of repairs, some of them out of range.
fn repair_settings(bytes: &mut Unstructured) -> Result<RlvRepairSettings> {
    let mut made: RlvRepairSettings = sized(bytes)?;
    let it = &mut made.settings;
    for step in [
        &mut it.weld,
        &mut it.degenerate,
        &mut it.duplicates,
        &mut it.orient,
        &mut it.split,
        &mut it.fill,
        &mut it.refine,
        &mut it.fair,
        &mut it.unused,
    ] {
        *step = Switch(u32::from(bytes.arbitrary::<u8>()? % 8 != 0));
    }
    (it.tolerance, it.hole_area) = (number(bytes)?, number(bytes)?);
    (it.hole_edges, it.listed) = (bytes.int_in_range(0..=9)?, bytes.int_in_range(0..=9)?);
    Ok(made)
}

/// Checks and repairs of a mesh, at once and as a job.
fn repairs(bytes: &mut Unstructured, handles: &mut Handles) -> Result<()> {
    let mesh = RlvMesh { id: handles.pick(bytes, 1)? };
    let settings = repair_settings(bytes)?;
    let mut report: RlvRepairReport = sized(bytes)?;
    let mut out = RlvMesh { id: UNTOUCHED };
    let mut job = RlvJob { id: UNTOUCHED };
    // SAFETY: descriptors are sized.
    unsafe {
        called(rlv_repair_check(mesh, &settings, None, null_mut(), &mut report));
        let result = rlv_repair_mesh(mesh, &settings, None, null_mut(), &mut report, &mut out);
        made(result, out.id, &mut handles.meshes);
        let result = rlv_job_repair(mesh, &settings, &mut job);
        made(result, job.id, &mut handles.jobs);
        let started = RlvJob { id: handles.pick(bytes, 12)? };
        called(rlv_job_repair_report(started, &mut report));
    }
    Ok(())
}

fn read_mesh(bytes: &mut Unstructured, handles: &mut Handles) -> Result<()> {
    let mesh = RlvMesh { id: handles.pick(bytes, 1)? };
    let mut info: RlvMeshInfo = sized(bytes)?;
    let room = bytes.int_in_range(0..=64_usize)?;
    let (mut floats, mut whole) = (vec![0.0_f32; 3 * room], vec![0_u32; 3 * room]);
    let index = bytes.int_in_range(0..=2)?;
    let name = [b'u', b'v', 0];
    let values = numbers(bytes, 64)?;
    let mut attribute: RlvAttributeArrays = sized(bytes)?;
    attribute.domain = bytes.int_in_range(0..=3)?;
    attribute.type_ = bytes.int_in_range(0..=2)?;
    attribute.width = if bytes.arbitrary()? { 2 } else { bytes.int_in_range(0..=5)? };
    attribute.name = name.as_ptr().cast();
    attribute.values = values.as_ptr().cast();
    attribute.value_count = bytes.int_in_range(0..=9)?;
    if bytes.arbitrary()? {
        attribute.value_count = *bytes.choose(&[4, 8, 12, 16, 24])?;
    }
    let mut about: RlvAttributeInfo = sized(bytes)?;
    let mut found = 0;
    // SAFETY: every array has the room that is told.
    unsafe {
        called(rlv_mesh_info(mesh, &mut info));
        called(rlv_mesh_get_points(mesh, floats.as_mut_ptr(), room, 0));
        called(rlv_mesh_get_faces(mesh, whole.as_mut_ptr(), room, whole.as_mut_ptr().add(room), room));
        called(rlv_mesh_get_triangles(mesh, whole.as_mut_ptr(), room, 0));
        called(rlv_mesh_add_attribute(mesh, &attribute));
        called(rlv_mesh_find_attribute(mesh, name.as_ptr().cast(), &mut found));
        called(rlv_mesh_attribute_info(mesh, index, &mut about));
        called(rlv_mesh_get_attribute(mesh, index, floats.as_mut_ptr().cast(), floats.len(), null_mut(), 0));
        called(rlv_mesh_set_points(mesh, values.as_ptr(), bytes.int_in_range(0..=21)?, 0));
    }
    Ok(())
}

fn use_surface(bytes: &mut Unstructured, handles: &mut Handles) -> Result<()> {
    let mut options: RlvSurfaceOptions = sized(bytes)?;
    options.boundary = bytes.int_in_range(0..=2)?;
    options.kind = bytes.int_in_range(0..=5)? / 2;
    options.isolation = bytes.int_in_range(0..=11)?;
    options.patch_limit = if bytes.arbitrary()? { 5000 } else { bytes.arbitrary()? };
    let (context, mesh) = (RlvContext { id: handles.pick(bytes, 0)? }, RlvMesh { id: handles.pick(bytes, 1)? });
    let mut out = RlvSurface { id: UNTOUCHED };
    let (longest, mut pieces) = (f64::from(number(bytes)?), RlvMesh { id: UNTOUCHED });
    // SAFETY: zeros are numbers, and the output is there.
    let mut about: RlvMeshInfo = unsafe { std::mem::zeroed() };
    about.struct_size = size_of::<RlvMeshInfo>() as u32;
    called(unsafe { rlv_mesh_info(mesh, &mut about) });
    let extent =
        about.low.iter().zip(about.high).map(|(low, high)| f64::from(high) - f64::from(*low)).fold(0.0, f64::max);
    // Millions of triangles are made where they are asked for, which takes longer than an input may.
    let many = longest > 0.0 && extent > 16.0 * longest;
    if bytes.ratio(1, 4)? && !many {
        // SAFETY: the output is there.
        let result = unsafe { rlv_mesh_split(mesh, longest, &mut pieces) };
        made(result, pieces.id, &mut handles.meshes);
    }
    // SAFETY: the descriptor is sized, the output is there.
    let result = unsafe { rlv_surface_create(context, mesh, &options, &mut out) };
    made(result, out.id, &mut handles.surfaces);
    let surface = RlvSurface { id: handles.pick(bytes, 2)? };
    let (mut info, mut tile): (RlvSurfaceInfo, RlvTileInfo) = (sized(bytes)?, sized(bytes)?);
    let (mut first, mut tiles) = (0, 0);
    let points = numbers(bytes, 48)?;
    // SAFETY: every array has the room that is told.
    unsafe {
        called(rlv_surface_info(surface, &mut info));
        called(rlv_surface_tile_info(surface, bytes.int_in_range(0..=12)?, &mut tile));
        called(rlv_surface_face_tiles(surface, bytes.int_in_range(0..=12)?, &mut first, &mut tiles));
        called(rlv_surface_set_points(surface, points.as_ptr(), bytes.int_in_range(0..=16)?, 0));
    }
    subdivide(bytes, handles, (context, mesh), &points)
}

/// Evaluates and refines a cage under any rules.
fn subdivide(
    bytes: &mut Unstructured,
    handles: &mut Handles,
    (context, mesh): (RlvContext, RlvMesh),
    points: &[f32],
) -> Result<()> {
    let mut options: RlvSubdivisionOptions = sized(bytes)?;
    options.scheme = bytes.int_in_range(0..=3)?;
    options.boundary = bytes.int_in_range(0..=3)?;
    options.face_varying = bytes.int_in_range(0..=6)?;
    options.creasing = bytes.int_in_range(0..=2)?;
    options.triangle_rule = bytes.int_in_range(0..=2)?;
    options.isolation = bytes.int_in_range(0..=11)?;
    let mut subdivision = RlvSubdivision { id: UNTOUCHED };
    // SAFETY: the descriptor is sized, the output is there.
    if !called(unsafe { rlv_subdivision_create(context, mesh, &options, &mut subdivision) }) {
        assert_eq!(subdivision.id, UNTOUCHED, "a failed call wrote its output");
        return Ok(());
    }
    let tiles = [bytes.int_in_range(0..=8)?, bytes.int_in_range(0..=8)?];
    let uvs = [0.25, number(bytes)?, 0.5, 0.5];
    let (mut values, mut second) = ([0.0; 8], [0.0; 8]);
    let mut arrays: RlvSubdivisionArrays = sized(bytes)?;
    arrays.point_rule = bytes.int_in_range(0..=2)?;
    arrays.count = count(bytes, 2)?;
    (arrays.tiles, arrays.uvs) = (tiles.as_ptr(), uvs.as_ptr());
    (arrays.values, arrays.value_stride) = (values.as_mut_ptr(), 16);
    if bytes.arbitrary()? {
        (arrays.duv, arrays.duv_stride) = (second.as_mut_ptr(), 16);
    }
    let attribute = *bytes.choose(&[null(), c"uv".as_ptr(), c"color".as_ptr(), c"material".as_ptr()])?;
    let mut info: RlvSubdivisionInfo = sized(bytes)?;
    let (mut first, mut tile_count, mut refined) = (0, 0, RlvMesh { id: UNTOUCHED });
    // SAFETY: every array has the room that is given, a row of four floats for each place.
    let result = unsafe {
        called(rlv_subdivision_info(subdivision, &mut info));
        called(rlv_subdivision_face_tiles(subdivision, bytes.int_in_range(0..=12)?, &mut first, &mut tile_count));
        called(rlv_subdivision_set_points(subdivision, points.as_ptr(), bytes.int_in_range(0..=16)?, 0));
        called(rlv_subdivision_evaluate(subdivision, attribute, &arrays));
        called(rlv_subdivision_retain(subdivision));
        called(rlv_subdivision_release(subdivision));
        let result = rlv_subdivision_refine(subdivision, bytes.int_in_range(0..=3)?, &mut refined);
        called(rlv_subdivision_release(subdivision));
        result
    };
    made(result, refined.id, &mut handles.meshes);
    Ok(())
}

fn use_detail(bytes: &mut Unstructured, handles: &mut Handles) -> Result<()> {
    let mut options: RlvDetailOptions = sized(bytes)?;
    options.tile_size = *bytes.choose(&[8, 8, 16, 16, 32, 0, 7, 512])?;
    options.budget = if bytes.arbitrary()? { 0 } else { bytes.int_in_range(0..=40_000)? };
    let sizes: Vec<u32> =
        (0..2 * bytes.int_in_range(0..=2)?).map(|_| bytes.int_in_range(0..=17)).collect::<Result<_>>()?;
    options.face_sizes = sizes.as_ptr();
    options.face_size_count = sizes.len() / 2;
    let place = matrix(bytes)?;
    let mut out = RlvDetail { id: UNTOUCHED };
    let surface = RlvSurface { id: handles.pick(bytes, 2)? };
    // SAFETY: arrays hold what their counts say.
    let result = unsafe { rlv_detail_create(surface, &options, pointer(&place), &mut out) };
    made(result, out.id, &mut handles.details);
    let detail = RlvDetail { id: handles.pick(bytes, 3)? };
    let (mut info, mut changes): (RlvDetailInfo, RlvDetailChanges) = (sized(bytes)?, sized(bytes)?);
    let mut about: RlvDetailTileInfo = sized(bytes)?;
    let mut tiles = [0; 8];
    let mut found = 0;
    let tile = bytes.int_in_range(0..=12)?;
    let channel = if bytes.ratio(1, 4)? { bytes.int_in_range(0..=4)? } else { RLV_CHANNEL_DISPLACEMENT };
    let mut about_channel: RlvChannelInfo = sized(bytes)?;
    let mut vectors: RlvVectorOptions = sized(bytes)?;
    vectors.tile_size = *bytes.choose(&[8, 16, 5])?;
    let mut paint: RlvPaintOptions = sized(bytes)?;
    (paint.tile_size, paint.color) = (*bytes.choose(&[8, 16, 5])?, [0.5, 0.25, number(bytes)?, 1.0]);
    let mut decay: RlvDecayOptions = sized(bytes)?;
    (decay.delay, decay.duration) = (number(bytes)?, number(bytes)?.abs());
    decay.budget = bytes.int_in_range(0..=40_000)?;
    let time = if bytes.ratio(1, 32)? { bytes.arbitrary()? } else { f64::from(number(bytes)?) };
    let mut folds: RlvDetailFolds = sized(bytes)?;
    let mut block = vec![0_u8; 2 * 34 * 34];
    let points = numbers(bytes, 48)?;
    // SAFETY: every array has the room that is told.
    unsafe {
        called(rlv_detail_info(detail, &mut info));
        called(rlv_detail_tile_info(detail, channel, tile, &mut about));
        called(rlv_detail_channel_info(detail, channel, &mut about_channel));
        called(rlv_detail_folds(detail, &mut folds));
        match bytes.int_in_range(0..=12_u8)? {
            4 => {
                called(rlv_detail_add_vectors(detail, &vectors));
            }
            5 => {
                called(rlv_detail_add_traces(detail, bytes.int_in_range(0..=40_000)?));
            }
            6 => {
                called(rlv_detail_set_decay(detail, &decay));
            }
            7 => {
                called(rlv_detail_advance(detail, time));
            }
            8 => {
                called(rlv_detail_add_paint(detail, &paint));
            }
            0 => {
                called(rlv_detail_set_budget(detail, bytes.int_in_range(0..=100_000)?));
            }
            1 => {
                called(rlv_detail_set_transform(detail, pointer(&place)));
            }
            2 => {
                called(rlv_detail_set_points(detail, points.as_ptr(), bytes.int_in_range(0..=16)?, 0));
            }
            3 => {
                let size = *bytes.choose(&[0, 200, 400, 600, 800, 2 * 18 * 18, 2 * 34 * 34, 7])?;
                bytes.fill_buffer(&mut block[..64])?;
                called(rlv_detail_write_block(detail, channel, tile, block.as_ptr().cast(), size));
            }
            _ => {}
        }
        called(rlv_detail_read_block(detail, channel, tile, block.as_mut_ptr().cast(), block.len(), &mut found));
        called(rlv_detail_commit(detail, if bytes.arbitrary()? { &mut changes } else { null_mut() }));
        called(rlv_detail_changed_tiles(detail, tiles.as_mut_ptr(), tiles.len(), &mut found));
    }
    Ok(())
}

fn tessellation(bytes: &mut Unstructured) -> Result<RlvTessellateOptions> {
    let mut options: RlvTessellateOptions = sized(bytes)?;
    options.coarse = *bytes.choose(&[1, 2, 4, 8, 0, 3, 1024])?;
    options.fine = *bytes.choose(&[1, 4, 16, 5, 4096])?;
    options.places = bytes.int_in_range(0..=2)?;
    Ok(options)
}

fn use_collider(bytes: &mut Unstructured, handles: &mut Handles) -> Result<()> {
    let place = matrix(bytes)?;
    let options = tessellation(bytes)?;
    let (context, mesh) = (RlvContext { id: handles.pick(bytes, 0)? }, RlvMesh { id: handles.pick(bytes, 1)? });
    let (surface, detail) = (RlvSurface { id: handles.pick(bytes, 2)? }, RlvDetail { id: handles.pick(bytes, 3)? });
    let mut out = RlvCollider { id: UNTOUCHED };
    // SAFETY: descriptors are sized, the matrix has twelve doubles or is NULL.
    let result = unsafe {
        match bytes.int_in_range(0..=2_u8)? {
            0 => rlv_collider_create_mesh(context, mesh, pointer(&place), &mut out),
            1 => rlv_collider_create_surface(surface, &options, pointer(&place), &mut out),
            _ => rlv_collider_create_detail(detail, &options, &mut out),
        }
    };
    made(result, out.id, &mut handles.colliders);
    let collider = RlvCollider { id: handles.pick(bytes, 4)? };
    let mut info: RlvColliderInfo = sized(bytes)?;
    let points = numbers(bytes, 48)?;
    // SAFETY: as above, and the points are as many as told.
    unsafe {
        called(rlv_collider_info(collider, &mut info));
        if bytes.ratio(1, 4)? {
            called(rlv_collider_set_points(collider, points.as_ptr(), bytes.int_in_range(0..=16)?, 0));
        }
        called(rlv_collider_set_transform(collider, pointer(&place)));
    }
    Ok(())
}

fn press(bytes: &mut Unstructured, handles: &mut Handles) -> Result<()> {
    // Words in the order of the header.
    let mut words = [
        if bytes.ratio(1, 32)? { bytes.arbitrary()? } else { size_of::<RlvImprintSettings>() as u32 },
        bytes.int_in_range(4000..=60_000)?,
        (number(bytes)? / 64.0).abs().to_bits(),
        bytes.arbitrary()?,
        number(bytes)?.abs().to_bits(),
        (number(bytes)? / 16.0).abs().to_bits(),
        number(bytes)?.abs().to_bits(),
        (number(bytes)? / 16.0).abs().to_bits(),
        bytes.int_in_range(0..=3)?,
        bytes.int_in_range(0..=3)?,
        bytes.int_in_range(0..=2)?,
        bytes.int_in_range(0..=1)?,
        (number(bytes)? / 16.0).abs().to_bits(),
        number(bytes)?.abs().to_bits(),
        (number(bytes)? / 16.0).abs().to_bits(),
    ];
    // A larger size than the struct has would have to be there.
    words[0] = words[0].min(size_of_val(&words) as u32);
    let mut moment: RlvImprintMoment = sized(bytes)?;
    moment.frame = bytes.arbitrary()?;
    let mut report: RlvImprintReport = sized(bytes)?;
    let (detail, collider) = (RlvDetail { id: handles.pick(bytes, 3)? }, RlvCollider { id: handles.pick(bytes, 4)? });
    let settings: *const RlvImprintSettings = words.as_ptr().cast();
    let places = [matrix(bytes)?, matrix(bytes)?];
    let vector = [0, 1, 2].map(|_| number(bytes).map_or(0.0, f64::from));
    let mut patience = bytes.int_in_range(0..=8_u32)?;
    // SAFETY: descriptors are sized, matrices have twelve numbers and vectors three.
    unsafe {
        match bytes.int_in_range(0..=8_u8)? {
            0 => {
                let user = (&raw mut patience).cast();
                let [from, to] = [pointer(&places[0]), pointer(&places[1])];
                called(rlv_imprint_sweep(detail, collider, from, to, settings, &moment, Some(wait), user, &mut report));
            }
            8 => {
                let user = (&raw mut patience).cast();
                let [from, to] = [pointer(&places[0]), pointer(&places[1])];
                let count = bytes.int_in_range(0..=16_usize)?;
                let mut points = [[0.0_f32; 3]; 16];
                for value in points.as_flattened_mut() {
                    *value = number(bytes)?;
                }
                let place = points.as_ptr().cast();
                called(rlv_imprint_sweep_points(
                    detail,
                    collider,
                    from,
                    to,
                    place,
                    place,
                    count,
                    0,
                    settings,
                    &moment,
                    Some(wait),
                    user,
                    &mut report,
                ));
            }
            1 => {
                let other = RlvDetail { id: handles.pick(bytes, 3)? };
                called(rlv_imprint_collide(detail, other, settings, settings, &moment, &mut report, null_mut()));
            }
            2 => {
                let force = f64::from(number(bytes)?);
                called(rlv_collider_press(collider, vector.as_ptr(), vector.as_ptr(), force, null()));
            }
            3 => {
                let sizes = [bytes.int_in_range(0..=5)?, *bytes.choose(&[8, 16, 32, 12_u32])?];
                called(rlv_detail_set_face_sizes(detail, sizes.as_ptr(), 1, 0));
            }
            _ => {
                called(rlv_imprint_run(detail, collider, settings, &moment, &mut report));
            }
        }
    }
    Ok(())
}

fn draw(bytes: &mut Unstructured, handles: &mut Handles) -> Result<()> {
    let mut options: RlvBrushOptions = sized(bytes)?;
    (options.action, options.mode, options.falloff) =
        (bytes.int_in_range(0..=2)?, bytes.int_in_range(0..=8)?, bytes.int_in_range(0..=5)?);
    options.color = [0.5, number(bytes)?.abs(), 0.25, 1.0];
    options.height = number(bytes)?;
    let mut settings: RlvBrushSettings = sized(bytes)?;
    settings.settings = Default::default();
    settings.settings.radius = number(bytes)?.abs();
    settings.settings.spacing = 1.0;
    settings.settings.string = number(bytes)?;
    settings.settings.jitter_position = number(bytes)?;
    let pixels = numbers(bytes, 12)?;
    let mut stamp: RlvStampOptions = sized(bytes)?;
    (stamp.width, stamp.height, stamp.channels) = (bytes.int_in_range(0..=3)?, 1, bytes.int_in_range(0..=4)?);
    (stamp.channel, stamp.pixels) = (bytes.int_in_range(0..=4)?, pixels.as_ptr());
    let curve = [0.0, f64::from(number(bytes)?), 1.0, f64::from(number(bytes)?)];
    let context = RlvContext { id: handles.pick(bytes, 0)? };
    let mut out = RlvBrush { id: UNTOUCHED };
    // SAFETY: descriptors are sized and arrays as long as told.
    let result = unsafe { rlv_brush_create(context, &options, &settings, &mut out) };
    made(result, out.id, &mut handles.brushes);
    let (detail, brush) = (RlvDetail { id: handles.pick(bytes, 3)? }, RlvBrush { id: handles.pick(bytes, 7)? });
    let point = |bytes: &mut Unstructured| -> Result<RlvStrokePoint> {
        let position = [number(bytes)?, number(bytes)?, number(bytes)? / 16.0].map(f64::from);
        Ok(RlvStrokePoint {
            position,
            pressure: f64::from(number(bytes)?.abs() / 16.0),
            time: f64::from(number(bytes)?),
        })
    };
    let points = [point(bytes)?, point(bytes)?, point(bytes)?];
    let count = count(bytes, points.len())?;
    let mut report: RlvStrokeReport = sized(bytes)?;
    let mut begun = RlvStroke { id: UNTOUCHED };
    // SAFETY: as above.
    let result = unsafe {
        called(rlv_brush_set_stamp(brush, if bytes.arbitrary()? { &stamp } else { null() }, null()));
        called(rlv_brush_set_curve(brush, bytes.int_in_range(0..=3)?, curve.as_ptr(), 2));
        called(rlv_stroke_run(detail, brush, points.as_ptr(), count, 0, &mut report));
        rlv_stroke_begin(detail, brush, &mut begun)
    };
    made(result, begun.id, &mut handles.strokes);
    let stroke = RlvStroke { id: handles.pick(bytes, 8)? };
    // SAFETY: as above.
    unsafe {
        called(rlv_stroke_extend(stroke, points.as_ptr(), count, 0, &mut report));
        if bytes.arbitrary()? {
            called(rlv_stroke_end(stroke, null_mut()));
        }
    }
    Ok(())
}

/// A progress callback that cancels when its patience is at an end.
unsafe extern "C" fn wait(user: *mut c_void, _: f32, _: *const c_char) -> u32 {
    // SAFETY: the user pointer is the patience of the call.
    let patience = unsafe { &mut *user.cast::<u32>() };
    if *patience == 0 {
        return RLV_PROGRESS_CANCEL;
    }
    *patience -= 1;
    RLV_PROGRESS_CONTINUE
}

fn evaluate(bytes: &mut Unstructured, handles: &mut Handles) -> Result<()> {
    let tiles: Vec<u32> = (0..4).map(|_| bytes.int_in_range(0..=9)).collect::<Result<_>>()?;
    let uvs: Vec<f32> = (0..8).map(|_| Ok(number(bytes)?.abs() / 8.0)).collect::<Result<_>>()?;
    let mut outputs = [[0.0_f32; 16]; 6];
    let mut arrays: RlvEvaluateArrays = sized(bytes)?;
    arrays.count = 4;
    arrays.tiles = tiles.as_ptr();
    arrays.uvs = uvs.as_ptr();
    let [positions, normals, displacements, vectors, traces, colors] = &mut outputs;
    if bytes.arbitrary()? {
        arrays.vectors = vectors.as_mut_ptr();
    }
    if bytes.ratio(1, 4)? {
        arrays.traces = traces.as_mut_ptr();
    }
    if bytes.ratio(1, 4)? {
        arrays.colors = colors.as_mut_ptr();
    }
    let footprints: Vec<f32> = (0..16).map(|_| number(bytes)).collect::<Result<_>>()?;
    if bytes.arbitrary()? {
        arrays.footprints = footprints.as_ptr();
    }
    arrays.positions = positions.as_mut_ptr();
    arrays.normals = normals.as_mut_ptr();
    arrays.displacements = displacements.as_mut_ptr();
    let (surface, detail) = (RlvSurface { id: handles.pick(bytes, 2)? }, RlvDetail { id: handles.pick(bytes, 3)? });
    let options = tessellation(bytes)?;
    let mut out = RlvMesh { id: UNTOUCHED };
    // SAFETY: arrays hold what the count says.
    let result = unsafe {
        called(rlv_evaluate_surface(surface, &arrays));
        called(rlv_evaluate_detail(detail, &arrays));
        if bytes.arbitrary()? {
            rlv_tessellate_surface(surface, &options, &mut out)
        } else {
            rlv_tessellate_detail(detail, &options, &mut out)
        }
    };
    made(result, out.id, &mut handles.meshes);
    Ok(())
}

fn cast(bytes: &mut Unstructured, handles: &mut Handles) -> Result<()> {
    let (context, mesh) = (RlvContext { id: handles.pick(bytes, 0)? }, RlvMesh { id: handles.pick(bytes, 1)? });
    let detail = RlvDetail { id: handles.pick(bytes, 3)? };
    let options = tessellation(bytes)?;
    let mut out = RlvCaster { id: UNTOUCHED };
    // SAFETY: descriptors are sized.
    let result = unsafe {
        if bytes.arbitrary()? {
            rlv_caster_create_mesh(context, mesh, &mut out)
        } else {
            rlv_caster_create_detail(detail, &options, &mut out)
        }
    };
    made(result, out.id, &mut handles.casters);
    let rays = numbers(bytes, 12)?;
    let mut hits = [RlvHit::default(); 2];
    let mut arrays: RlvRayArrays = sized(bytes)?;
    arrays.count = 2;
    arrays.origins = rays.as_ptr();
    arrays.directions = rays[6..].as_ptr();
    arrays.hits = hits.as_mut_ptr();
    arrays.max_distance = number(bytes)?;
    let masks = [bytes.arbitrary::<u32>()?, 1];
    arrays.masks = masks.as_ptr();
    let caster = RlvCaster { id: handles.pick(bytes, 5)? };
    // SAFETY: arrays hold two rays.
    unsafe {
        called(rlv_caster_set_mask(caster, bytes.int_in_range(0..=3)?));
        called(rlv_caster_cast(caster, &arrays));
    }
    Ok(())
}

/// Bakes to memory; files are the business of other targets.
fn bake(bytes: &mut Unstructured, handles: &mut Handles) -> Result<()> {
    let mut options: RlvBakeOptions = sized(bytes)?;
    (options.quantity, options.is_udim) = (bytes.int_in_range(0..=8)?, bytes.int_in_range(0..=1)?);
    (options.width, options.height) = (bytes.int_in_range(0..=24)?, bytes.int_in_range(0..=24)?);
    (options.gutter, options.samples) = (bytes.int_in_range(0..=3)?, bytes.int_in_range(0..=2)?);
    (options.space, options.axes, options.handedness) =
        (bytes.int_in_range(0..=2)?, bytes.int_in_range(0..=2)?, bytes.int_in_range(0..=2)?);
    let mut report: RlvBakeReport = sized(bytes)?;
    let mut patience = bytes.int_in_range(0..=8_u32)?;
    let detail = RlvDetail { id: handles.pick(bytes, 3)? };
    let user = (&raw mut patience).cast();
    // SAFETY: descriptors are sized, and the user pointer is what both callbacks take it for.
    called(unsafe { rlv_bake_run(detail, &options, Some(receive), Some(wait), user, &mut report) });
    Ok(())
}

/// Reads a picture to its last number.
unsafe extern "C" fn receive(user: *mut c_void, picture: *const RlvBakePicture) -> u32 {
    // SAFETY: the library gives a picture with its arrays, and the user pointer of the call.
    unsafe {
        let RlvBakePicture { width, height, channels, pixels, covered, .. } = *picture;
        let count = (width * height) as usize;
        let pixels = std::slice::from_raw_parts(pixels, count * channels as usize);
        assert!(pixels.iter().all(|value| value.is_finite()));
        assert!(std::slice::from_raw_parts(covered, count).iter().all(|covered| *covered <= 1));
        wait(user, 1.0, null())
    }
}

/// Layers and the history of a detail, without a file.
fn remember(bytes: &mut Unstructured, handles: &mut Handles) -> Result<()> {
    let detail = RlvDetail { id: handles.pick(bytes, 3)? };
    let mut options: RlvLayerOptions = sized(bytes)?;
    (options.kind, options.blend) = (bytes.int_in_range(0..=2)?, bytes.int_in_range(0..=8)?);
    (options.is_visible, options.opacity) = (bytes.int_in_range(0..=1)?, number(bytes)?.abs() / 16.0);
    options.tile_size = *bytes.choose(&[0, 8, 16, 32, 9])?;
    let name = [bytes.arbitrary::<u8>()?, 0];
    let (mut id, mut count) = (bytes.int_in_range(0..=20)?, 0);
    let mut about: RlvLayerInfo = sized(bytes)?;
    let mut out = RlvDocument { id: UNTOUCHED };
    let mut changes: RlvDocumentChanges = sized(bytes)?;
    let mut info: RlvDocumentInfo = sized(bytes)?;
    if bytes.arbitrary()? {
        // SAFETY: the output is there.
        let result = unsafe { rlv_document_create(detail, null(), bytes.int_in_range(0..=10_000)?, &mut out) };
        made(result, out.id, &mut handles.documents);
    }
    let document = RlvDocument { id: handles.pick(bytes, 9)? };
    // SAFETY: descriptors are sized, and texts end.
    unsafe {
        called(rlv_document_begin(document, null()));
        match bytes.int_in_range(0..=7_u8)? {
            0 | 1 => called(rlv_layer_add(detail, name.as_ptr().cast(), &options, &mut id)),
            2 => called(rlv_layer_set(detail, id, &options)),
            3 => called(rlv_layer_place(detail, id, bytes.int_in_range(0..=3)?)),
            4 => called(rlv_layer_remove(detail, id)),
            5 => called(rlv_layer_merge(detail, id)),
            6 => called(rlv_layer_flatten(detail)),
            _ => called(rlv_layer_set_active(detail, id)),
        };
        called(rlv_layer_count(detail, &mut count));
        called(rlv_layer_info(detail, bytes.int_in_range(0..=4)?, &mut about));
        match bytes.int_in_range(0..=3_u8)? {
            0 => called(rlv_document_end(document, &mut changes)),
            1 => called(rlv_document_abandon(document)),
            2 => called(rlv_document_undo(document, &mut changes)),
            _ => called(rlv_document_redo(document, null_mut())),
        };
        called(rlv_document_info(document, &mut info));
    }
    Ok(())
}

/// Triangles that follow a detail.
fn follow(bytes: &mut Unstructured, handles: &mut Handles) -> Result<()> {
    if bytes.arbitrary()? {
        let options = tessellation(bytes)?;
        let mut out = RlvTessellation { id: UNTOUCHED };
        // SAFETY: the descriptor is sized.
        let result = unsafe { rlv_tessellation_create(RlvDetail { id: handles.pick(bytes, 3)? }, &options, &mut out) };
        made(result, out.id, &mut handles.tessellations);
    }
    let tessellation = RlvTessellation { id: handles.pick(bytes, 6)? };
    let (mut info, mut changes): (RlvTessellationInfo, RlvTessellationChanges) = (sized(bytes)?, sized(bytes)?);
    let mut out = RlvMesh { id: UNTOUCHED };
    let (mut ranges, mut found) = ([0_u32; 16], 0);
    let (mut positions, mut normals) = ([0.0_f32; 48], [0.0_f32; 48]);
    let first = if bytes.ratio(1, 16)? { bytes.arbitrary()? } else { bytes.int_in_range(0..=40)? };
    // SAFETY: every array has the room that is told.
    let result = unsafe {
        called(rlv_tessellation_info(tessellation, &mut info));
        called(rlv_tessellation_update(tessellation, &mut changes));
        called(rlv_tessellation_changed_ranges(tessellation, ranges.as_mut_ptr(), 8, &mut found));
        let count = bytes.int_in_range(0..=16)?;
        let (positions, normals) = (positions.as_mut_ptr(), normals.as_mut_ptr());
        called(rlv_tessellation_get_points(tessellation, first, count, positions, 0, normals, 0));
        called(rlv_tessellation_get_traces(tessellation, first, count, positions, 0));
        called(rlv_tessellation_get_colors(tessellation, first, count, normals, 0));
        rlv_tessellation_mesh(tessellation, &mut out)
    };
    made(result, out.id, &mut handles.meshes);
    Ok(())
}

/// Primitives of a renderer, and a ray that may be none.
fn primitives(bytes: &mut Unstructured, handles: &mut Handles) -> Result<()> {
    let mut options: RlvProceduralOptions = sized(bytes)?;
    (options.coarse, options.fine) = (*bytes.choose(&[0, 4, 8, 3])?, *bytes.choose(&[0, 4, 8, 16, 513])?);
    let detail = RlvDetail { id: handles.pick(bytes, 3)? };
    let mut out = RlvProcedural { id: UNTOUCHED };
    let begin = RlvProcedural { id: handles.pick(bytes, 10)? };
    // SAFETY: the descriptor is sized, the output is there.
    let result = unsafe {
        if bytes.arbitrary()? {
            rlv_procedural_create(detail, &options, &mut out)
        } else {
            rlv_procedural_create_moving(begin, detail, &mut out)
        }
    };
    made(result, out.id, &mut handles.procedurals);
    let procedural = RlvProcedural { id: handles.pick(bytes, 10)? };
    let (mut info, mut table): (RlvProceduralInfo, RlvProceduralTable) = (sized(bytes)?, sized(bytes)?);
    let mut rays = [0.0_f32; 20];
    for value in &mut rays[..9] {
        *value = number(bytes)?;
    }
    let primitive = bytes.int_in_range(0..=40_u32)?;
    // SAFETY: descriptors are sized; the table is only used whole and while its procedural lives.
    let met = unsafe {
        called(rlv_procedural_info(procedural, &mut info));
        if called(rlv_procedural_table(procedural, &mut table))
            && table.struct_size as usize == size_of::<RlvProceduralTable>()
            && let Some(intersect) = table.intersect
        {
            intersect(table.data, &-1, primitive, 0, 0, rays.as_mut_ptr().cast(), 1);
            primitive.min(table.primitive_count)
        } else {
            primitive
        }
    };
    let mut hits: RlvProceduralHits = sized(bytes)?;
    let (mut tile, mut position, mut normal, mut color) = (0, [0.0_f32; 3], [0.0_f32; 3], [0.0_f32; 4]);
    let uv = if bytes.ratio(1, 4)? { [number(bytes)?, number(bytes)?] } else { [rays[15], rays[16]] };
    (hits.count, hits.primitives, hits.uvs, hits.tiles) = (1, &met, uv.as_ptr(), &mut tile);
    (hits.positions, hits.normals) = (position.as_mut_ptr(), normal.as_mut_ptr());
    if bytes.arbitrary()? {
        hits.colors = color.as_mut_ptr();
    }
    // SAFETY: every array has one element.
    if called(unsafe { rlv_procedural_evaluate(procedural, &hits) }) {
        assert!(position.iter().chain(&normal).chain(&color).all(|value| value.is_finite()));
    }
    Ok(())
}

/// Bézier patches, at levels and from places that may be none.
fn patches(bytes: &mut Unstructured, handles: &mut Handles) -> Result<()> {
    let points = numbers(bytes, 96)?;
    let weights: Vec<f32> = (0..32).map(|_| Ok(number(bytes)?.abs() + 0.125)).collect::<Result<_>>()?;
    let indices: Vec<u32> = (0..32).map(|_| bytes.int_in_range(0..=32)).collect::<Result<_>>()?;
    let mut arrays: RlvBezierArrays = sized(bytes)?;
    (arrays.points, arrays.point_count) = (points.as_ptr(), count(bytes, 32)?);
    if bytes.arbitrary()? {
        arrays.weights = weights.as_ptr();
    }
    if bytes.arbitrary()? {
        (arrays.indices, arrays.index_count) = (indices.as_ptr(), count(bytes, 32)?);
    }
    let context = RlvContext { id: handles.pick(bytes, 0)? };
    let mut out = RlvBezier { id: UNTOUCHED };
    // SAFETY: arrays hold at least what their counts say, or are NULL.
    let result = unsafe { rlv_bezier_create(context, &arrays, &mut out) };
    made(result, out.id, &mut handles.beziers);
    let bezier = RlvBezier { id: handles.pick(bytes, 11)? };
    let mut info: RlvBezierInfo = sized(bytes)?;
    let mut controls = [0.0_f32; 64];
    let mut view: RlvBezierView = sized(bytes)?;
    (view.most, view.forward) = (bytes.int_in_range(0..=3)?, [0.0, 0.0, -1.0]);
    view.eye = [f64::from(number(bytes)?), f64::from(number(bytes)?), f64::from(number(bytes)?)];
    (view.pixels, view.corner) = (f64::from(number(bytes)?.abs()) * 64.0, f64::from(number(bytes)?.abs()));
    view.tolerance = f64::from(number(bytes)?.abs());
    let mut needed = [0_u32; 2];
    let mut fine: RlvBezierLevels = sized(bytes)?;
    fine.level = bytes.int_in_range(0..=3)?;
    let own = [bytes.int_in_range(0..=2)?, bytes.int_in_range(1..=9)?];
    if bytes.arbitrary()? {
        (fine.levels, fine.level_count) = (own.as_ptr(), count(bytes, 2)?);
    }
    let (tiles, uvs) = ([0_u32, bytes.int_in_range(0..=2)?], numbers(bytes, 4)?);
    let mut outputs = [[0.0_f32; 6]; 4];
    let [positions, normals, du, dv] = &mut outputs;
    let mut places: RlvEvaluateArrays = sized(bytes)?;
    (places.count, places.tiles, places.uvs) = (2, tiles.as_ptr(), uvs.as_ptr());
    (places.positions, places.normals) = (positions.as_mut_ptr(), normals.as_mut_ptr());
    (places.du, places.dv) = (du.as_mut_ptr(), dv.as_mut_ptr());
    let (mut point_count, mut triangle_count) = (0, 0);
    let mut mesh = RlvMesh { id: UNTOUCHED };
    // SAFETY: every array has the room that is told.
    let result = unsafe {
        called(rlv_bezier_info(bezier, &mut info));
        called(rlv_bezier_get_controls(bezier, bytes.int_in_range(0..=2)?, controls.as_mut_ptr(), 0));
        called(rlv_bezier_evaluate(bezier, &places));
        called(rlv_bezier_levels(bezier, &view, needed.as_mut_ptr(), 2));
        if called(rlv_bezier_count(bezier, &fine, &mut point_count, &mut triangle_count)) {
            let mut points = vec![0.0_f32; 3 * point_count];
            let mut corners = vec![0_u32; 3 * triangle_count];
            let mut room: RlvBezierTriangles = sized(bytes)?;
            (room.positions, room.point_capacity) = (points.as_mut_ptr(), point_count);
            (room.corners, room.triangle_capacity) = (corners.as_mut_ptr(), count(bytes, triangle_count)?);
            if called(rlv_bezier_tessellate(bezier, &fine, &room)) {
                assert!(points.iter().all(|value| value.is_finite()));
                assert!(corners.iter().all(|corner| (*corner as usize) < point_count));
            }
        }
        rlv_bezier_mesh(bezier, &fine, &mut mesh)
    };
    made(result, mesh.id, &mut handles.meshes);
    Ok(())
}

/// A region of influence, mostly on the mesh.
fn region(bytes: &mut Unstructured) -> Result<RlvLevelRegion> {
    let center = [number(bytes)? / 8.0, number(bytes)? / 8.0, number(bytes)? / 8.0].map(f64::from);
    Ok(RlvLevelRegion { center, radius: number(bytes)?, falloff: bytes.int_in_range(0..=5)? })
}

/// Progressive meshes, their levels and edits, in buffers that may be too small.
fn levels(bytes: &mut Unstructured, handles: &mut Handles) -> Result<()> {
    let mesh = RlvMesh { id: handles.pick(bytes, 1)? };
    let locked: [u32; 2] = [bytes.int_in_range(0..=20)?, bytes.int_in_range(0..=20)?];
    let names = [c"uv", c"color", c"normal", c"none"];
    let weight = RlvSimplifyWeight {
        name: bytes.choose(&names)?.as_ptr(),
        weight: number(bytes)?,
        is_left_out: bytes.int_in_range(0..=2)?,
    };
    let factors = numbers(bytes, 4)?;
    let mut simple: RlvSimplifyOptions = sized(bytes)?;
    (simple.error, simple.triangles) = (number(bytes)?, bytes.int_in_range(0..=16)?);
    (simple.weights, simple.weight_count) = (&weight, bytes.int_in_range(0..=1)?);
    (simple.locked, simple.locked_count) = (locked.as_ptr(), bytes.int_in_range(0..=2)?);
    (simple.factors, simple.factor_count) = (factors.as_ptr(), if bytes.ratio(1, 4)? { factors.len() } else { 0 });
    (simple.bound, simple.is_border_locked) = (number(bytes)?, bytes.int_in_range(0..=2)?);
    let mut less = RlvMesh { id: UNTOUCHED };
    // SAFETY: descriptors are sized, and so are their arrays.
    let result = unsafe { rlv_simplify_mesh(mesh, &simple, None, null_mut(), null_mut(), &mut less) };
    made(result, less.id, &mut handles.meshes);
    let mut options: RlvProgressiveOptions = sized(bytes)?;
    options.base_triangles = bytes.int_in_range(0..=16)?;
    (options.locked, options.locked_count) = (locked.as_ptr(), bytes.int_in_range(0..=2)?);
    let mut out = RlvProgressive { id: UNTOUCHED };
    // SAFETY: descriptors are sized, and so are their arrays.
    let result = unsafe { rlv_progressive_create(mesh, &options, None, null_mut(), &mut out) };
    made(result, out.id, &mut handles.progressives);
    let whole = RlvProgressive { id: handles.pick(bytes, 13)? };
    let mut out = RlvLevel { id: UNTOUCHED };
    // SAFETY: the output is there.
    let result = unsafe { rlv_level_create(whole, &mut out) };
    made(result, out.id, &mut handles.levels);
    let level = RlvLevel { id: handles.pick(bytes, 14)? };
    let planes = numbers(bytes, 4)?;
    let mut view: RlvLevelView = sized(bytes)?;
    view.eye = place(bytes)?;
    [view.pixels, view.tolerance, view.outline] = place(bytes)?;
    (view.planes, view.plane_count) = (planes.as_ptr(), count(bytes, 1)?);
    let handle = RlvLevelHandle {
        region: region(bytes)?,
        translation: [number(bytes)?, number(bytes)?, number(bytes)?],
        axis: [0.0, 0.0, if bytes.ratio(1, 8)? { number(bytes)? } else { 1.0 }],
        angle: number(bytes)?,
        reserved: 0,
    };
    let anchor = region(bytes)?;
    let mut edit: RlvLevelEdit = sized(bytes)?;
    (edit.handles, edit.handle_count) = (&handle, count(bytes, 1)?);
    (edit.anchors, edit.anchor_count) = (&anchor, bytes.int_in_range(0..=1)?);
    let brush = RlvBrush { id: handles.pick(bytes, 7)? };
    let position = [number(bytes)?, number(bytes)?, number(bytes)?].map(f64::from);
    let point = RlvStrokePoint { position, pressure: f64::from(number(bytes)?.abs() / 16.0), time: -1.0 };
    let mut sculpted: RlvLevelSculpted = sized(bytes)?;
    for _ in 0..bytes.int_in_range(0..=4)? {
        // SAFETY: descriptors are sized, and so are their arrays.
        unsafe {
            called(match bytes.int_in_range(0..=7_u8)? {
                0 => rlv_level_set_error(level, number(bytes)?),
                7 => rlv_level_set_bound(level, number(bytes)?, None, null_mut(), null_mut()),
                1 => rlv_level_set_triangles(level, bytes.int_in_range(0..=64)?),
                2 => rlv_level_set_view(level, &view),
                3 => rlv_level_edit(level, &edit, null_mut()),
                4 => rlv_level_undo(level),
                5 => rlv_level_redo(level),
                _ => rlv_level_sculpt(level, brush, &point, 1, 0, &mut sculpted),
            });
        }
    }
    let mut info: RlvLevelInfo = sized(bytes)?;
    // SAFETY: the descriptor is sized.
    if called(unsafe { rlv_level_info(level, &mut info) }) {
        let mut points = vec![0.0_f32; 3 * info.vertex_count];
        let mut triangles = vec![0_u32; 3 * info.triangle_count];
        let mut room: RlvLevelBuffers = sized(bytes)?;
        room.is_whole = 1;
        (room.points, room.vertex_capacity) = (points.as_mut_ptr(), info.vertex_count);
        (room.triangles, room.triangle_capacity) = (triangles.as_mut_ptr(), count(bytes, info.triangle_count)?);
        // SAFETY: the arrays have the room that is told.
        if called(unsafe { rlv_level_update(level, &room, null_mut()) }) {
            assert!(triangles.iter().all(|corner| (*corner as usize) < info.vertex_count));
        }
        let (mut ranges, mut found) = ([0_u32; 16], 0);
        let domain = bytes.int_in_range(0..=3)?;
        // SAFETY: the array has room for 8 pairs.
        called(unsafe { rlv_level_changed_ranges(level, domain, ranges.as_mut_ptr(), 8, &mut found) });
    }
    let mut mesh = RlvMesh { id: UNTOUCHED };
    // SAFETY: the output is there.
    let result = unsafe { rlv_level_mesh(level, &mut mesh) };
    made(result, mesh.id, &mut handles.meshes);
    if bytes.ratio(1, 4)? {
        let mut settled = RlvProgressive { id: UNTOUCHED };
        // SAFETY: the output is there.
        let result = unsafe { rlv_level_settle(level, &mut settled) };
        made(result, settled.id, &mut handles.progressives);
    }
    Ok(())
}

/// Fluids of few particles, which may lie on each other, and steps of them.
fn fluids(bytes: &mut Unstructured, handles: &mut Handles) -> Result<()> {
    let context = RlvContext { id: handles.pick(bytes, 0)? };
    let mut options: RlvFluidOptions = sized(bytes)?;
    (options.spacing, options.density, options.step) = (1.0, 1000.0, 0.01);
    (options.max_excess, options.mean_excess, options.courant) = (0.01, 0.001, 0.4);
    (options.min_corrections, options.max_corrections) = (1, 20);
    (options.kernels, options.steps) = (bytes.int_in_range(0..=2)?, bytes.int_in_range(0..=2)?);
    options.gravity = [number(bytes)?, number(bytes)?, -9.81];
    if bytes.ratio(1, 4)? {
        (options.spacing, options.viscosity, options.step) = (number(bytes)?, number(bytes)?, number(bytes)?);
    }
    let mut out = RlvFluid { id: UNTOUCHED };
    // SAFETY: descriptors are sized, and so are their arrays.
    let result = unsafe { rlv_fluid_create(context, &options, &mut out) };
    made(result, out.id, &mut handles.fluids);
    let fluid = RlvFluid { id: handles.pick(bytes, 15)? };
    let (points, speeds) = (numbers(bytes, 24)?, numbers(bytes, 24)?);
    let mut particles: RlvFluidParticles = sized(bytes)?;
    (particles.points, particles.count) = (points.as_ptr(), count(bytes, 8)?);
    particles.velocities = if bytes.ratio(1, 2)? { speeds.as_ptr() } else { std::ptr::null() };
    particles.lifetime = number(bytes)?;
    let gone = [bytes.int_in_range(0..=9_u32)?];
    let mesh = RlvMesh { id: handles.pick(bytes, 1)? };
    let mut collider: RlvFluidColliderOptions = sized(bytes)?;
    (collider.contact, collider.is_container) = (bytes.int_in_range(0..=3)?, bytes.int_in_range(0..=2)?);
    let carried = channel(bytes, &speeds)?;
    (particles.channels, particles.channel_count) = (&carried, bytes.int_in_range(0..=1)?);
    let mut tap: RlvFluidEmitterOptions = sized(bytes)?;
    (tap.channels, tap.channel_count) = (&carried, bytes.ratio(1, 4)?.into());
    (tap.shape, tap.speed, tap.radius) = (bytes.int_in_range(0..=3)?, number(bytes)?, number(bytes)?);
    tap.center = place(bytes)?;
    (tap.u, tap.v) = ([number(bytes)?, number(bytes)?, 1.0], [number(bytes)?, 1.0, number(bytes)?]);
    let force = RlvFluidForce {
        kind: bytes.int_in_range(0..=6)?,
        seed: 3,
        vector: tap.u,
        strength: number(bytes)?,
        place: place(bytes)?,
        radius: number(bytes)?,
        rate: number(bytes)?,
    };
    let (low, high) = (place(bytes)?, place(bytes)?);
    let mut number_of = 0;
    for _ in 0..bytes.int_in_range(0..=5)? {
        // SAFETY: descriptors are sized, and so are their arrays.
        unsafe {
            called(match bytes.int_in_range(0..=15_u8)? {
                0 => rlv_fluid_add(fluid, &particles),
                1 => rlv_fluid_add_box(fluid, low.as_ptr(), high.as_ptr(), speeds.as_ptr()),
                2 => rlv_fluid_remove(fluid, gone.as_ptr(), 1, 0, null_mut()),
                3 => rlv_fluid_set_walls(fluid, points.as_ptr(), count(bytes, 8)?, 0),
                4 => rlv_fluid_set_basin(fluid, low.as_ptr(), high.as_ptr()),
                5 => rlv_fluid_set_wall_points(fluid, points.as_ptr(), count(bytes, 8)?, 0, speeds.as_ptr(), 0),
                6 => rlv_fluid_accelerate(fluid, speeds.as_ptr(), count(bytes, 8)?, 0),
                7 => rlv_fluid_fill(fluid, mesh, null(), null(), null_mut()),
                8 => rlv_fluid_add_collider(fluid, mesh, null(), &collider, &mut number_of),
                9 => rlv_fluid_move_collider(fluid, 0, null(), points.as_ptr(), count(bytes, 8)?, 0, number(bytes)?),
                10 => rlv_fluid_add_emitter(fluid, mesh, null(), &tap),
                11 => rlv_fluid_add_sink(fluid, low.as_ptr(), high.as_ptr(), bytes.int_in_range(0..=2)?),
                12 => rlv_fluid_set_forces(fluid, &force, 1, 0),
                _ => rlv_fluid_step(fluid, number(bytes)?, null_mut()),
            });
        }
    }
    let mut info: RlvFluidInfo = sized(bytes)?;
    // SAFETY: the descriptor is sized.
    if called(unsafe { rlv_fluid_info(fluid, &mut info) }) {
        let room = info.particle_count.min(64);
        let (mut places, mut ids, mut densities) = (vec![0.0_f32; 3 * room], vec![0_u32; room], vec![0.0_f32; room]);
        let mut arrays: RlvFluidArrays = sized(bytes)?;
        (arrays.points, arrays.numbers, arrays.capacity) = (places.as_mut_ptr(), ids.as_mut_ptr(), room);
        if bytes.ratio(1, 4)? {
            arrays.densities = densities.as_mut_ptr();
        }
        // SAFETY: the arrays have the room that is told.
        if called(unsafe { rlv_fluid_get(fluid, &arrays) }) {
            assert!(ids.windows(2).all(|pair| pair[0] < pair[1]));
            assert!(places.iter().all(|coordinate| coordinate.is_finite()));
        }
    }
    let mut surface = RlvIsosurface { id: UNTOUCHED };
    // SAFETY: the output is there.
    let result = unsafe { rlv_fluid_isosurface(fluid, std::ptr::null(), &mut surface) };
    made(result, surface.id, &mut handles.isosurfaces);
    Ok(())
}

/// A channel of particles, of up to three numbers of an array of 24.
fn channel(bytes: &mut Unstructured, values: &[f32]) -> Result<RlvAttributeArrays> {
    let mut channel: RlvAttributeArrays = sized(bytes)?;
    let names = [c"age", c"color", c"velocity", c"blind", c"normal", c""];
    (channel.name, channel.width) = (bytes.choose(&names)?.as_ptr(), bytes.int_in_range(0..=3)?);
    (channel.values, channel.value_count) = (values.as_ptr().cast(), count(bytes, 8)?);
    (channel.domain, channel.type_) = (bytes.ratio(1, 16)?.into(), bytes.ratio(1, 16)?.into());
    Ok(channel)
}

/// What particles of fluids carry, states of them that are kept and cut, and states that nobody wrote, behind sums that are right.
fn states(bytes: &mut Unstructured, handles: &mut Handles) -> Result<()> {
    let (fluid, other) = (RlvFluid { id: handles.pick(bytes, 15)? }, RlvFluid { id: handles.pick(bytes, 15)? });
    let values = numbers(bytes, 24)?;
    let channel = channel(bytes, &values)?;
    let mut info: RlvAttributeInfo = sized(bytes)?;
    let (mut index, mut size, mut read) = (bytes.int_in_range(0..=3)?, 0, [0.0_f32; 3 * 64]);
    // SAFETY: descriptors are sized, and so are their arrays; no channel has more than three numbers but those of states.
    unsafe {
        called(rlv_fluid_set_channel(fluid, &channel));
        called(rlv_fluid_find_channel(fluid, channel.name, &mut index));
        if called(rlv_fluid_channel_info(fluid, index, &mut info)) && info.width <= 3 {
            called(rlv_fluid_get_channel(fluid, index, read.as_mut_ptr(), 64, 0));
        }
    }
    // SAFETY: the size is there, and then the bytes.
    let kept = unsafe {
        let mut kept = Vec::new();
        let (mut held, mut data) = (RlvBytes::default(), null());
        if called(rlv_fluid_save_bytes(fluid, &mut held)) {
            assert!(called(rlv_bytes_get(held, &mut data, &mut size)));
            kept = std::slice::from_raw_parts(data, size).to_vec();
            assert!(called(rlv_bytes_release(held)));
            assert!(called(rlv_fluid_restore_bytes(fluid, kept.as_ptr(), size)), "what was saved is restored");
        }
        kept
    };
    let length = if bytes.ratio(1, 4)? { bytes.int_in_range(0..=kept.len())? } else { kept.len() };
    // SAFETY: so many bytes are there.
    called(unsafe { rlv_fluid_restore_bytes(other, kept.as_ptr(), length) });
    let rows: [i8; 12] = bytes.arbitrary()?;
    let count = bytes.int_in_range(0..=4_usize)?;
    let places = |from: usize| (0..3 * count).map(|at| f32::from(rows[(at + from) % 12]) / 4.0).collect::<Vec<_>>();
    let mut state = 2_u32.to_le_bytes().to_vec();
    if bytes.ratio(7, 8)? {
        // No description, and 28 bytes of totals; seconds, the acceleration and share, the next number and the count.
        state.extend([0; 32]);
        state.extend(f64::from(number(bytes)?).to_le_bytes());
        state.extend([number(bytes)?, 0.5].iter().flat_map(|value| value.to_le_bytes()));
        state.extend([bytes.int_in_range(0..=9_u32)?, count as u32].iter().flat_map(|value| value.to_le_bytes()));
    }
    if bytes.ratio(1, 2)? {
        // Lists that may be: what steps begin with, pushes and pressures, births, lifetimes.
        let some = |at: usize| 0.125 + f32::from(rows[at % 12].unsigned_abs()) / 8.0;
        state.extend((0..6 * count).flat_map(|at| some(at).to_le_bytes()));
        state.extend((0..count).flat_map(|at| f64::from(some(at)).to_le_bytes()));
        state.extend((0..count).flat_map(|at| some(at).to_le_bytes()));
    }
    state.extend(bytes.bytes(bytes.len().min(48 * count))?);
    let frame = Particles {
        points: places(0).as_chunks().0.to_vec(),
        spacing: Some(1.0),
        numbers: Some((0..count as u32).collect()),
        channels: vec![Channel { name: "velocity".into(), width: 3, values: places(5) }],
        ..Particles::default()
    };
    if let Ok(frame) = encode_frame(&Context::serial(), &frame, Some(&state)) {
        // SAFETY: so many bytes are there.
        if called(unsafe { rlv_fluid_restore_bytes(other, frame.as_ptr(), frame.len()) }) {
            // SAFETY: no output is asked for.
            called(unsafe { rlv_fluid_step(other, number(bytes)?, null_mut()) });
        }
    }
    Ok(())
}

/// Particles of arrays and of fluids, those that a surface needs, and files that are not there.
fn pictures_of_particles(bytes: &mut Unstructured, handles: &mut Handles) -> Result<()> {
    let context = RlvContext { id: handles.pick(bytes, 0)? };
    let (points, values) = (numbers(bytes, 24)?, numbers(bytes, 24)?);
    let ids: [u32; 8] = bytes.arbitrary()?;
    let channels = [channel(bytes, &values)?, channel(bytes, &values)?];
    let mut arrays: RlvParticlesArrays = sized(bytes)?;
    (arrays.has_time, arrays.time) = (bytes.int_in_range(0..=2)?, f64::from(number(bytes)?));
    (arrays.points, arrays.count, arrays.spacing) = (points.as_ptr(), count(bytes, 8)?, number(bytes)?);
    arrays.numbers = if bytes.ratio(1, 2)? { ids.as_ptr() } else { null() };
    (arrays.channels, arrays.channel_count) = (channels.as_ptr(), bytes.int_in_range(0..=2)?);
    let mut out = RlvParticles { id: UNTOUCHED };
    // SAFETY: descriptors are sized, and so are their arrays.
    let result = unsafe { rlv_particles_create(context, &arrays, &mut out) };
    made(result, out.id, &mut handles.particles);
    let fluid = RlvFluid { id: handles.pick(bytes, 15)? };
    let mut out = RlvParticles { id: UNTOUCHED };
    // SAFETY: the output is there.
    let result = unsafe { rlv_fluid_particles(fluid, &mut out) };
    made(result, out.id, &mut handles.particles);
    let particles = RlvParticles { id: handles.pick(bytes, 17)? };
    let classes: [u8; 8] = bytes.arbitrary::<[u8; 8]>()?.map(|class| class % 4);
    let mut out = RlvParticles { id: UNTOUCHED };
    // SAFETY: the classes are as many as are told.
    let result = unsafe { rlv_particles_keep(particles, classes.as_ptr(), count(bytes, 8)?, 0, &mut out) };
    made(result, out.id, &mut handles.particles);
    let mut out = RlvParticles { id: UNTOUCHED };
    // SAFETY: the text ends.
    let result = unsafe { rlv_particles_read(context, c"/nowhere/nothing.bgeo".as_ptr(), &mut out) };
    made(result, out.id, &mut handles.particles);
    let mut info: RlvParticlesInfo = sized(bytes)?;
    let mut told: RlvAttributeInfo = sized(bytes)?;
    let (mut room, mut numbers) = ([0.0_f32; 4 * 64], [0_u32; 64]);
    let index = bytes.int_in_range(0..=3)?;
    // SAFETY: descriptors are sized, arrays have the room that is told, and texts end.
    unsafe {
        called(rlv_particles_info(particles, &mut info));
        called(rlv_particles_get_points(particles, room.as_mut_ptr(), 64, 0));
        called(rlv_particles_get_numbers(particles, numbers.as_mut_ptr(), 64, 0));
        called(rlv_particles_channel_info(particles, index, &mut told));
        called(rlv_particles_get_channel(particles, index, room.as_mut_ptr(), 64, 0));
        called(rlv_particles_write(particles, c"/nowhere/nothing.ply".as_ptr()));
        called(rlv_fluid_add_particles(fluid, particles));
        called(rlv_fluid_save(fluid, c"/nowhere/nothing.rlvfluid".as_ptr()));
        called(rlv_fluid_restore(fluid, c"/nowhere/nothing.rlvfluid".as_ptr()));
    }
    let mut surface = RlvIsosurface { id: UNTOUCHED };
    // SAFETY: the output is there.
    let result = unsafe { rlv_particles_isosurface(particles, null(), &mut surface) };
    made(result, surface.id, &mut handles.isosurfaces);
    Ok(())
}

/// Surfaces of few particles, their meshes, and rays.
fn isosurfaces(bytes: &mut Unstructured, handles: &mut Handles) -> Result<()> {
    let context = RlvContext { id: handles.pick(bytes, 0)? };
    let (points, speeds) = (numbers(bytes, 24)?, numbers(bytes, 24)?);
    let blind: [u8; 8] = bytes.arbitrary::<[u8; 8]>()?.map(|flag| flag % 3);
    let mut particles: RlvIsosurfaceParticles = sized(bytes)?;
    (particles.points, particles.count) = (points.as_ptr(), count(bytes, 8)?);
    particles.velocities = if bytes.ratio(1, 2)? { speeds.as_ptr() } else { std::ptr::null() };
    particles.blind = if bytes.ratio(1, 4)? { blind.as_ptr() } else { std::ptr::null() };
    let mut options: RlvIsosurfaceOptions = sized(bytes)?;
    options.function = bytes.int_in_range(0..=4)?;
    (options.radius, options.support, options.sharpness) = (1.0, 0.0, 8.0);
    (options.iso, options.centring, options.march_steps) = (0.6, 0.9, 8.0);
    if bytes.ratio(1, 4)? {
        (options.radius, options.support, options.iso) = (number(bytes)?, number(bytes)?, number(bytes)?);
        (options.shutter_open, options.shutter_close) = (number(bytes)?, number(bytes)?);
        (options.sharpness, options.centring, options.march_steps) = (number(bytes)?, number(bytes)?, number(bytes)?);
    }
    let mut out = RlvIsosurface { id: UNTOUCHED };
    // SAFETY: descriptors are sized, and so are their arrays.
    let result = unsafe { rlv_isosurface_create(context, &particles, &options, &mut out) };
    made(result, out.id, &mut handles.isosurfaces);
    let surface = RlvIsosurface { id: handles.pick(bytes, 16)? };
    let mut how: RlvIsosurfaceMeshOptions = sized(bytes)?;
    (how.iterations, how.cell) = (bytes.int_in_range(0..=2)?, if bytes.ratio(1, 4)? { number(bytes)? } else { 0.0 });
    (how.forwards, how.backwards) = (number(bytes)?, number(bytes)?);
    let mut channel: RlvAttributeArrays = sized(bytes)?;
    (channel.name, channel.width) = (c"age".as_ptr(), bytes.int_in_range(0..=3)?);
    (channel.values, channel.value_count) = (speeds.as_ptr().cast(), count(bytes, 8)?);
    (how.channels, how.channel_count) = (&channel, bytes.int_in_range(0..=1)?);
    let mut mesh = RlvMesh { id: UNTOUCHED };
    // SAFETY: descriptors are sized, and so are their arrays.
    let result = unsafe { rlv_isosurface_mesh(surface, &how, None, null_mut(), &mut mesh) };
    made(result, mesh.id, &mut handles.meshes);
    let mut classes = [0_u8; 8];
    let mut counts: RlvIsosurfaceClasses = sized(bytes)?;
    let mut table: RlvIsosurfaceTable = sized(bytes)?;
    let ray = RlvIsosurfaceRay {
        origin: [number(bytes)?, number(bytes)?, number(bytes)?],
        direction: [number(bytes)?, number(bytes)?, number(bytes)?],
        min_distance: number(bytes)?,
        max_distance: number(bytes)?,
        time: number(bytes)?,
    };
    let far = if ray.max_distance == 0.0 { f32::INFINITY } else { ray.max_distance };
    let mut rays: RlvRayArrays = sized(bytes)?;
    rays.count = 1;
    (rays.origins, rays.directions) = (ray.origin.as_ptr(), ray.direction.as_ptr());
    (rays.min_distances, rays.max_distances, rays.times) = (&ray.min_distance, &far, &ray.time);
    let (mut first, mut second) = (RlvIsosurfaceHit::default(), RlvIsosurfaceHit::default());
    // SAFETY: descriptors are sized, and so are their arrays; the surface of the table lives.
    unsafe {
        called(rlv_isosurface_classify(
            surface,
            number(bytes)?,
            classes.as_mut_ptr(),
            8,
            0,
            None,
            null_mut(),
            &mut counts,
        ));
        if called(rlv_isosurface_table(surface, &mut table))
            && called(rlv_isosurface_cast(surface, &rays, &mut first, 0))
        {
            let has = |size: u32, of: usize| usize::try_from(size).is_ok_and(|size| size >= of);
            let whole = has(table.struct_size, size_of::<RlvIsosurfaceTable>())
                && has(rays.struct_size, size_of::<RlvRayArrays>());
            if let (Some(intersect), true) = (table.intersect, whole) {
                let met = intersect(table.data, &ray, &mut second);
                assert!((met == 1) == first.distance.is_finite() && first.distance == second.distance);
            }
        }
    }
    Ok(())
}

/// Jobs, some of which are waited for.
fn background(bytes: &mut Unstructured, handles: &mut Handles) -> Result<()> {
    let (detail, collider) = (RlvDetail { id: handles.pick(bytes, 3)? }, RlvCollider { id: handles.pick(bytes, 4)? });
    let places = [matrix(bytes)?, matrix(bytes)?];
    let options = tessellation(bytes)?;
    let mut out = RlvJob { id: UNTOUCHED };
    let path = c"/nowhere/nothing".as_ptr();
    let (context, mesh) = (RlvContext { id: handles.pick(bytes, 0)? }, RlvMesh { id: handles.pick(bytes, 1)? });
    let surface = RlvSurface { id: handles.pick(bytes, 2)? };
    let (tessellation, document) =
        (RlvTessellation { id: handles.pick(bytes, 6)? }, RlvDocument { id: handles.pick(bytes, 9)? });
    let (procedural, particles) =
        (RlvProcedural { id: handles.pick(bytes, 10)? }, RlvParticles { id: handles.pick(bytes, 17)? });
    // SAFETY: descriptors are sized, matrices have twelve numbers, texts end.
    let result = unsafe {
        match bytes.int_in_range(0..=26_u8)? {
            4 => rlv_job_surface_create(context, mesh, null(), &mut out),
            5 => rlv_job_caster_create_mesh(context, mesh, &mut out),
            6 => rlv_job_caster_create_detail(detail, &options, &mut out),
            7 => rlv_job_caster_create_tessellation(tessellation, &mut out),
            8 => rlv_job_procedural_create(detail, null(), &mut out),
            9 => rlv_job_procedural_create_moving(procedural, detail, &mut out),
            10 => rlv_job_collider_create_mesh(context, mesh, pointer(&places[0]), &mut out),
            11 => rlv_job_collider_create_surface(surface, &options, pointer(&places[0]), &mut out),
            12 => rlv_job_collider_create_detail(detail, &options, &mut out),
            13 => rlv_job_mesh_read(context, path, &mut out),
            14 => rlv_job_mesh_write(mesh, path, &mut out),
            15 => rlv_job_particles_read(context, path, &mut out),
            16 => rlv_job_particles_write(particles, path, &mut out),
            17 => rlv_job_picture_open(context, path, &mut out),
            18 => rlv_job_document_create(detail, null(), 0, &mut out),
            19 => rlv_job_document_open(detail, path, 0, &mut out),
            20 => rlv_job_document_save(document, path, &mut out),
            21 => rlv_job_document_compact(context, path, 0, &mut out),
            22 => rlv_job_document_save_bytes(document, &mut out),
            23 => rlv_job_document_open_bytes(detail, bytes.bytes(0)?.as_ptr(), 0, 0, &mut out),
            24 => rlv_job_progressive_read(context, path, 0, &mut out),
            25 => rlv_job_crowd_model_read(context, path, &mut out),
            26 => rlv_job_tissue_read(context, path, &mut out),
            0 => rlv_job_tessellate(detail, &options, &mut out),
            1 => rlv_job_ptex_read(detail, path, null(), &mut out),
            2 => rlv_job_bake(detail, null(), path, &mut out),
            _ => rlv_job_sweep(detail, collider, pointer(&places[0]), pointer(&places[1]), null(), null(), &mut out),
        }
    };
    // SAFETY: NULL is refused.
    assert!(!called(unsafe { rlv_allocator_set(null()) }));
    made(result, out.id, &mut handles.jobs);
    let job = RlvJob { id: handles.pick(bytes, 12)? };
    let (mut info, mut report): (RlvJobInfo, RlvImprintReport) = (sized(bytes)?, sized(bytes)?);
    let mut mesh = RlvMesh { id: UNTOUCHED };
    // SAFETY: descriptors are sized, the output is there.
    let result = unsafe {
        if bytes.arbitrary()? {
            called(rlv_job_cancel(job));
        }
        called(rlv_job_poll(job, &mut info));
        called(rlv_job_wait(
            job,
            if bytes.ratio(1, 4)? { f64::from(number(bytes)?) / 1024.0 } else { -1.0 },
            &mut info,
        ));
        called(rlv_job_result(job));
        called(rlv_job_imprint_report(job, &mut report));
        rlv_job_mesh(job, &mut mesh)
    };
    made(result, mesh.id, &mut handles.meshes);
    let mut surface = RlvSurface { id: UNTOUCHED };
    let mut caster = RlvCaster { id: UNTOUCHED };
    let mut collider = RlvCollider { id: UNTOUCHED };
    let mut procedural = RlvProcedural { id: UNTOUCHED };
    let mut document = RlvDocument { id: UNTOUCHED };
    let mut picture = RlvPicture { id: UNTOUCHED };
    // SAFETY: the outputs are there.
    unsafe {
        made(rlv_job_surface(job, &mut surface), surface.id, &mut handles.surfaces);
        made(rlv_job_caster(job, &mut caster), caster.id, &mut handles.casters);
        made(rlv_job_collider(job, &mut collider), collider.id, &mut handles.colliders);
        made(rlv_job_procedural(job, &mut procedural), procedural.id, &mut handles.procedurals);
        made(rlv_job_document(job, &mut document), document.id, &mut handles.documents);
        // There is no file to open.
        assert!(!called(rlv_job_picture(job, &mut picture)));
    }
    Ok(())
}

/// A parallel loop of a host that does the pieces from the last to the first, and one of them twice.
unsafe extern "C" fn backwards(_: *mut c_void, count: usize, body: RlvLoopBody, work: *mut c_void) {
    let Some(body) = body else { return };
    for index in (0..count).rev().chain((count > 0).then_some(0)) {
        // SAFETY: the work is that of this loop, and the index lies below the count.
        unsafe { body(work, index) };
    }
}

/// Begins a task on a thread of a host.
unsafe extern "C" fn begin(_: *mut c_void, task: RlvTask, work: *mut c_void) {
    let (Some(task), work) = (task, work.expose_provenance()) else { return };
    // SAFETY: a task runs once, on any thread.
    std::thread::spawn(move || unsafe { task(std::ptr::with_exposed_provenance_mut(work)) });
}

unsafe extern "C" fn notified(_: *mut c_void) {}

/// What a host asks and gives apart from geometry: threads, capabilities, notices of jobs, and waiting for objects.
fn hosts(bytes: &mut Unstructured, handles: &mut Handles) -> Result<()> {
    let mut options: RlvContextOptions = sized(bytes)?;
    (options.threads, options.memory_limit) = (bytes.int_in_range(0..=3)?, 1 << 24);
    let [runs, begins, shares]: [bool; 3] = bytes.arbitrary()?;
    options.host_loop = runs.then_some(backwards);
    options.host_spawn = begins.then_some(begin);
    options.shared.id = if shares { handles.pick(bytes, 0)? } else { 0 };
    let mut out = RlvContext { id: UNTOUCHED };
    let (mut info, mut capability): (RlvObjectInfo, RlvCapability) = (sized(bytes)?, sized(bytes)?);
    let noun = bytes.int_in_range(0..=27)?;
    let (object, job) = (handles.pick(bytes, noun)?, RlvJob { id: handles.pick(bytes, 12)? });
    let seconds = if bytes.ratio(1, 4)? { f64::from(number(bytes)?) / 1024.0 } else { 0.0 };
    let room = bytes.int_in_range(0..=64_usize)?;
    // SAFETY: rows are plain numbers.
    let mut rows: Vec<RlvCapabilityFormat> = vec![unsafe { std::mem::zeroed() }; room];
    let mut found = UNTOUCHED as usize;
    // SAFETY: descriptors are sized, rows have the room that is told, and the functions are those of a host.
    unsafe {
        if handles.contexts.len() < 8 {
            made(rlv_context_create(&options, &mut out), out.id, &mut handles.contexts);
        }
        called(rlv_job_notify(job, bytes.arbitrary::<bool>()?.then_some(notified), null_mut()));
        called(rlv_object_wait(object, seconds.min(0.01), &mut info));
        // It asks the drivers of graphics devices, which takes long.
        if bytes.ratio(1, 16)? {
            called(rlv_capability_get(&mut capability));
        }
        let listed = called(rlv_capability_list(rows.as_mut_ptr(), room, &mut found));
        assert!(!listed || found <= room, "{found} formats in room for {room}");
    }
    Ok(())
}

/// Retains or releases a handle as the given noun.
fn count_reference(noun: usize, id: u64, retain: bool) -> RlvResult {
    // SAFETY: handles are checked by the library, whatever their number.
    unsafe {
        match (noun, retain) {
            (0, true) => rlv_context_retain(RlvContext { id }),
            (0, false) => rlv_context_release(RlvContext { id }),
            (1, true) => rlv_mesh_retain(RlvMesh { id }),
            (1, false) => rlv_mesh_release(RlvMesh { id }),
            (2, true) => rlv_surface_retain(RlvSurface { id }),
            (2, false) => rlv_surface_release(RlvSurface { id }),
            (3, true) => rlv_detail_retain(RlvDetail { id }),
            (3, false) => rlv_detail_release(RlvDetail { id }),
            (4, true) => rlv_collider_retain(RlvCollider { id }),
            (4, false) => rlv_collider_release(RlvCollider { id }),
            (5, true) => rlv_caster_retain(RlvCaster { id }),
            (5, false) => rlv_caster_release(RlvCaster { id }),
            (6, true) => rlv_tessellation_retain(RlvTessellation { id }),
            (6, false) => rlv_tessellation_release(RlvTessellation { id }),
            (7, true) => rlv_brush_retain(RlvBrush { id }),
            (7, false) => rlv_brush_release(RlvBrush { id }),
            (8, true) => rlv_stroke_retain(RlvStroke { id }),
            (8, false) => rlv_stroke_release(RlvStroke { id }),
            (9, true) => rlv_document_retain(RlvDocument { id }),
            (9, false) => rlv_document_release(RlvDocument { id }),
            (10, true) => rlv_procedural_retain(RlvProcedural { id }),
            (10, false) => rlv_procedural_release(RlvProcedural { id }),
            (11, true) => rlv_bezier_retain(RlvBezier { id }),
            (11, false) => rlv_bezier_release(RlvBezier { id }),
            (12, true) => rlv_job_retain(RlvJob { id }),
            (12, false) => rlv_job_release(RlvJob { id }),
            (13, true) => rlv_progressive_retain(RlvProgressive { id }),
            (13, false) => rlv_progressive_release(RlvProgressive { id }),
            (14, true) => rlv_level_retain(RlvLevel { id }),
            (14, false) => rlv_level_release(RlvLevel { id }),
            (15, true) => rlv_fluid_retain(RlvFluid { id }),
            (15, false) => rlv_fluid_release(RlvFluid { id }),
            (16, true) => rlv_isosurface_retain(RlvIsosurface { id }),
            (16, false) => rlv_isosurface_release(RlvIsosurface { id }),
            (17, true) => rlv_particles_retain(RlvParticles { id }),
            (17, false) => rlv_particles_release(RlvParticles { id }),
            (18, true) => rlv_grid_retain(RlvGrid { id }),
            (18, false) => rlv_grid_release(RlvGrid { id }),
            (19, true) => rlv_decal_retain(RlvDecal { id }),
            (19, false) => rlv_decal_release(RlvDecal { id }),
            (20, true) => rlv_foam_retain(RlvFoam { id }),
            (20, false) => rlv_foam_release(RlvFoam { id }),
            (21, true) => rlv_shader_retain(RlvShader { id }),
            (21, false) => rlv_shader_release(RlvShader { id }),
            (22, true) => rlv_diffuse_retain(RlvDiffuse { id }),
            (22, false) => rlv_diffuse_release(RlvDiffuse { id }),
            (23, true) => rlv_tissue_retain(RlvTissue { id }),
            (23, false) => rlv_tissue_release(RlvTissue { id }),
            (24, true) => rlv_tissue_simulation_retain(RlvTissueSimulation { id }),
            (24, false) => rlv_tissue_simulation_release(RlvTissueSimulation { id }),
            (25, true) => rlv_crowd_model_retain(RlvCrowdModel { id }),
            (25, false) => rlv_crowd_model_release(RlvCrowdModel { id }),
            (26, true) => rlv_crowd_retain(RlvCrowd { id }),
            (26, false) => rlv_crowd_release(RlvCrowd { id }),
            (_, true) => rlv_device_crowd_retain(RlvDeviceCrowd { id }),
            (_, false) => rlv_device_crowd_release(RlvDeviceCrowd { id }),
        }
    }
}

/// Foam of a few particles in a small picture, shaded, asked for its layers and composited in place.
fn foam(bytes: &mut Unstructured, handles: &mut Handles) -> Result<()> {
    let (width, height) = (bytes.int_in_range(0..=9_u32)?, bytes.int_in_range(0..=9_u32)?);
    let depths = numbers(bytes, 81)?;
    let mut view: RlvFoamView = sized(bytes)?;
    (view.width, view.height) = (width, height);
    (view.eye, view.up) = ([0.0, f64::from(number(bytes)?), 2.0], [0.0, 1.0, 0.0]);
    (view.fov, view.orthographic) = (f64::from(number(bytes)?.abs()) / 4.0, f64::from(number(bytes)?.max(0.0)));
    if bytes.arbitrary()? {
        (view.solids, view.fluid) = (depths.as_ptr(), depths.as_ptr());
    }
    let context = RlvContext { id: handles.pick(bytes, 0)? };
    let mut out = RlvFoam { id: UNTOUCHED };
    // SAFETY: depths are at least as many as pixels, and the descriptor is sized.
    let result = unsafe { rlv_foam_create(context, &view, null(), &mut out) };
    made(result, out.id, &mut handles.foams);
    let (positions, lives) = (numbers(bytes, 12)?, numbers(bytes, 4)?);
    let (ids, kinds): ([u32; 4], [u8; 4]) = (bytes.arbitrary()?, bytes.arbitrary()?);
    let kinds = kinds.map(|kind| u32::from(kind % 4));
    let mut particles: RlvFoamParticles = sized(bytes)?;
    particles.count = count(bytes, 4)?;
    (particles.positions, particles.lives) = (positions.as_ptr(), lives.as_ptr());
    (particles.ids, particles.kinds) = (ids.as_ptr(), kinds.as_ptr());
    let foam = RlvFoam { id: handles.pick(bytes, 20)? };
    let radiance = numbers(bytes, 24)?;
    let mut light: RlvFoamLight = sized(bytes)?;
    (light.width, light.height) = (4, bytes.int_in_range(0..=2)?);
    (light.up, light.radiance) = ([0.0, 0.0, number(bytes)?], radiance.as_ptr());
    let given = if bytes.arbitrary()? { &raw const light } else { null() };
    // The picture may be another one's, of 9 × 9 pixels at most.
    let mut picture = [0.5_f32; 4 * 81];
    let mut layers: RlvFoamLayers = sized(bytes)?;
    let (mut intensity, mut normal) = ([0.0_f32; 81], [0.0_f32; 243]);
    (layers.intensity, layers.normal) = (intensity.as_mut_ptr(), normal.as_mut_ptr());
    let mut patience = bytes.int_in_range(0..=40_u32)?;
    let start = picture.as_mut_ptr();
    // SAFETY: arrays hold four particles, two rows of texels, and 81 pixels; the user pointer is what the callback takes it
    // for.
    unsafe {
        called(rlv_foam_add(foam, &particles));
        called(rlv_foam_shade(foam, given, Some(wait), (&raw mut patience).cast()));
        called(rlv_foam_get(foam, &layers));
        called(rlv_foam_composite(foam, start, bytes.int_in_range(2..=5)?, start));
    }
    Ok(())
}

/// A shader with a wrong byte now and then, marked, its texts and log, and the membership of a few vectors.
fn shaders(bytes: &mut Unstructured, handles: &mut Handles) -> Result<()> {
    let mut source =
        *b"void main() { float a = 1.0, b = a; /*. vector a; b; a */ gl_FragColor = vec4(b /*. * confidence */); }\0";
    let last = source.len() - 2;
    if bytes.arbitrary()? {
        source[bytes.int_in_range(0..=last)?] = bytes.arbitrary()?;
    }
    let mut options: RlvShaderOptions = sized(bytes)?;
    (options.language, options.stage) = (bytes.int_in_range(0..=2)? / 2, bytes.int_in_range(0..=3)?);
    let mut out = RlvShader { id: UNTOUCHED };
    // SAFETY: the source ends with a zero, and the descriptor is sized.
    let result = unsafe { rlv_shader_create(source.as_ptr().cast(), &options, &mut out) };
    made(result, out.id, &mut handles.shaders);
    let shader = RlvShader { id: handles.pick(bytes, 21)? };
    let chosen: [u8; 2] = bytes.arbitrary()?;
    let chosen = chosen.map(|index| u32::from(index % 4));
    let mut out = RlvShader { id: UNTOUCHED };
    // SAFETY: there are two indices.
    let result = unsafe { rlv_shader_mark(shader, chosen.as_ptr(), count(bytes, 2)?, null(), &mut out) };
    made(result, out.id, &mut handles.shaders);
    let (mut text, mut length, index) = ([0_u8; 4096], 0, bytes.int_in_range(0..=3)?);
    let kind = bytes.int_in_range(0..=3)?;
    let size = bytes.int_in_range(0..=text.len())?;
    let mut variable: RlvShaderVariable = sized(bytes)?;
    let mut layout: RlvShaderLayout = sized(bytes)?;
    let mut feature: RlvShaderFeature = sized(bytes)?;
    let log: [u32; 8] = bytes.arbitrary()?;
    let (vectors, mut vector) = (numbers(bytes, 12)?, [0.0_f32; 4]);
    let classes: [u8; 3] = bytes.arbitrary()?;
    let classes = classes.map(|class| u32::from(class) % 3);
    let mut examples: RlvShaderExamples = sized(bytes)?;
    (examples.feature_count, examples.count) = (bytes.int_in_range(0..=4)?, count(bytes, 3)?);
    (examples.classes, examples.vectors) = (classes.as_ptr(), vectors.as_ptr());
    (examples.exponent, examples.is_scaled) = (number(bytes)?.abs(), bytes.arbitrary()?);
    let (mut words, mut packed) = ([0_u32; 64], 0);
    // SAFETY: texts, words and numbers have the room that is said; three examples have twelve numbers.
    unsafe {
        called(rlv_shader_text(shader, kind, text.as_mut_ptr().cast(), size, &mut length));
        called(rlv_shader_variable(shader, index, &mut variable));
        called(rlv_shader_layout(shader, &mut layout));
        called(rlv_shader_feature(shader, index, &mut feature));
        called(rlv_shader_unpack_log(shader, log.as_ptr(), count(bytes, 8)?, vector.as_mut_ptr(), 4, null_mut()));
        let (mode, room) = (bytes.int_in_range(0..=3)?, bytes.int_in_range(0..=64)?);
        called(rlv_shader_pack_examples(&examples, mode, 3, 4, words.as_mut_ptr(), room, &mut packed));
        called(rlv_shader_membership(&examples, vectors.as_ptr(), 3, 0, vector.as_mut_ptr()));
    }
    Ok(())
}

/// Grids with blocks of values, changed, combined and meshed. Without the module of OpenVDB every call is refused.
fn grids(bytes: &mut Unstructured, handles: &mut Handles) -> Result<()> {
    let mut out = RlvGrid { id: UNTOUCHED };
    let context = RlvContext { id: handles.pick(bytes, 0)? };
    let kind = bytes.int_in_range(0..=11)?;
    let background: [f64; 3] = if bytes.ratio(1, 8)? { bytes.arbitrary()? } else { [0.0; 3] };
    let voxel = if bytes.ratio(1, 8)? { bytes.arbitrary()? } else { 0.5 };
    // SAFETY: three numbers are read.
    let result = unsafe { rlv_grid_create(context, kind, background.as_ptr(), voxel, &mut out) };
    made(result, out.id, &mut handles.grids);
    let grid = RlvGrid { id: handles.pick(bytes, 18)? };
    let low: [i32; 3] = if bytes.ratio(1, 8)? { bytes.arbitrary()? } else { [-1, 0, 7] };
    let size: [u32; 3] = if bytes.ratio(1, 8)? { bytes.arbitrary()? } else { [3, 2, 4] };
    let mut values = [0u8; 24 * 24];
    bytes.fill_buffer(&mut values)?;
    let length = *bytes.choose(&[24, 96, 192, 288, 576, 100])?;
    let tolerance = if bytes.ratio(1, 8)? { bytes.arbitrary()? } else { 0.0 };
    let place: [f64; 3] = bytes.arbitrary()?;
    let (mut numbers, mut info) = ([0.0; 3], sized::<RlvGridInfo>(bytes)?);
    // SAFETY: three numbers each are read, the block has room for `length` bytes, and the descriptor is sized.
    unsafe {
        called(rlv_grid_set_block(grid, low.as_ptr(), size.as_ptr(), values.as_ptr().cast(), length, tolerance));
        called(rlv_grid_get_block(grid, low.as_ptr(), size.as_ptr(), values.as_mut_ptr().cast(), length));
        called(rlv_grid_sample(grid, place.as_ptr(), 1, 0, u32::from(bytes.ratio(1, 2)?), numbers.as_mut_ptr(), 3));
        called(rlv_grid_info(grid, &mut info));
        called(rlv_grid_set_class(grid, bytes.int_in_range(0..=4)?));
        called(rlv_grid_set_name(grid, c"grid".as_ptr()));
    }
    let other = RlvGrid { id: handles.pick(bytes, 18)? };
    let mut settings: RlvGridSettings = sized(bytes)?;
    settings.settings = Default::default();
    settings.settings.value = number(bytes)?;
    let (mut made_grid, mut mesh) = (RlvGrid { id: UNTOUCHED }, RlvMesh { id: UNTOUCHED });
    // SAFETY: the descriptor is sized.
    unsafe {
        let result = rlv_grid_combine(grid, other, bytes.int_in_range(0..=3)?, None, null_mut(), &mut made_grid);
        made(result, made_grid.id, &mut handles.grids);
        made_grid.id = UNTOUCHED;
        let result = rlv_grid_convert(grid, bytes.int_in_range(0..=10)?, &mut made_grid);
        made(result, made_grid.id, &mut handles.grids);
        let result = rlv_grid_mesh(grid, &settings, None, null_mut(), &mut mesh);
        made(result, mesh.id, &mut handles.meshes);
    }
    Ok(())
}

/// Stickers on meshes and details: laid, dragged, settled, written and made meshes.
fn decals(bytes: &mut Unstructured, handles: &mut Handles) -> Result<()> {
    let mut options: RlvDecalOptions = sized(bytes)?;
    (options.width, options.height) = (bytes.int_in_range(0..=16)?, bytes.int_in_range(0..=16)?);
    options.can_overlap = bytes.int_in_range(0..=1)?;
    let mut outline = [[0.0_f64; 2]; 4];
    for corner in &mut outline {
        *corner = [f64::from(number(bytes)?), f64::from(number(bytes)?)];
    }
    (options.outline, options.outline_count, options.outline_stride) = (std::ptr::null(), 0, 0);
    if bytes.ratio(1, 3)? {
        (options.outline, options.outline_count) = (outline.as_ptr().cast(), bytes.int_in_range(0..=4)?);
    }
    options.pose_width = f64::from(number(bytes)?);
    options.pose_up = [0.0, 1.0, f64::from(number(bytes)?)];
    (options.steps, options.decrease) = (bytes.int_in_range(0..=4)?, number(bytes)?);
    (options.triangles, options.cells) = (bytes.int_in_range(0..=2000)?, bytes.int_in_range(0..=4)?);
    let mut pins = [RlvDecalPin::default(); 4];
    for pin in &mut pins {
        pin.image = [bytes.int_in_range(0..=16)?, bytes.int_in_range(0..=16)?].map(|value: u32| f64::from(value));
        pin.position = [f64::from(number(bytes)?), f64::from(number(bytes)?), f64::from(number(bytes)?)];
        pin.depth = f64::from(number(bytes)?);
    }
    let count = bytes.int_in_range(0..=4)?;
    let mut out = RlvDecal { id: UNTOUCHED };
    let mesh = RlvMesh { id: handles.pick(bytes, 1)? };
    let detail = RlvDetail { id: handles.pick(bytes, 3)? };
    // SAFETY: the descriptor is sized, its outline and the pins are of their counts.
    let result = unsafe {
        if bytes.ratio(1, 2)? {
            rlv_decal_on_mesh(mesh, &options, pins.as_ptr(), count, 0, None, null_mut(), &mut out)
        } else {
            rlv_decal_on_detail(detail, &options, pins.as_ptr(), count, 0, None, null_mut(), &mut out)
        }
    };
    made(result, out.id, &mut handles.decals);
    let decal = RlvDecal { id: handles.pick(bytes, 19)? };
    let pixels = [0.5_f32; 4 * 256];
    let mut image: RlvDecalImage = sized(bytes)?;
    image.channels = bytes.int_in_range(0..=5)?;
    (image.pixels, image.pixel_count) = (pixels.as_ptr(), bytes.int_in_range(0..=256)?);
    let (mut quality, mut report) = (sized::<RlvDecalQuality>(bytes)?, sized::<RlvDecalReport>(bytes)?);
    let place = [f64::from(number(bytes)?), f64::from(number(bytes)?), f64::from(number(bytes)?)];
    let mut made_mesh = RlvMesh { id: UNTOUCHED };
    // SAFETY: descriptors are sized, the image has its pixels of up to four channels, and places their numbers.
    unsafe {
        called(rlv_decal_drag_pin(decal, bytes.int_in_range(0..=4)?, place.as_ptr()));
        called(rlv_decal_settle(decal, None, null_mut()));
        called(rlv_decal_move_image(decal, bytes.int_in_range(0..=4)?, place.as_ptr(), None, null_mut()));
        called(rlv_decal_quality(decal, &mut quality));
        if image.channels <= 4 {
            called(rlv_decal_paint(decal, &image, number(bytes)?, &mut report));
            called(rlv_decal_emboss(decal, &image, number(bytes)?, &mut report));
        }
        let result = rlv_decal_mesh(decal, f64::from(number(bytes)?), &mut made_mesh);
        made(result, made_mesh.id, &mut handles.meshes);
    }
    Ok(())
}

/// Diffuse particles of a few fast particles of fluid: advanced, asked for, and made foam.
fn diffuses(bytes: &mut Unstructured, handles: &mut Handles) -> Result<()> {
    let context = RlvContext { id: handles.pick(bytes, 0)? };
    let mut options: RlvDiffuseOptions = sized(bytes)?;
    (options.spacing, options.gravity) = (0.5, [0.0, number(bytes)?, -9.81]);
    (options.has_bounds, options.low, options.high) = (bytes.int_in_range(0..=2)?, [-4.0; 3], place(bytes)?);
    let mut settings: RlvDiffuseSettings = sized(bytes)?;
    settings.settings = Default::default();
    let it = &mut settings.settings;
    (it.air_min, it.air_max, it.energy_min, it.energy_max) = (0.0, number(bytes)?, 0.0, 1.0);
    (it.crest_min, it.crest_max, it.steps) = (0.0, 1.0, bytes.int_in_range(0..=3)?);
    (it.air_rate, it.crest_rate, it.most) = (200.0, number(bytes)?, bytes.int_in_range(0..=99)?);
    if bytes.ratio(1, 8)? {
        (options.spacing, it.lifetime_max, it.drag) = (number(bytes)?, number(bytes)?, number(bytes)?);
    }
    let given = if bytes.ratio(1, 8)? { null() } else { &raw const settings };
    let mut out = RlvDiffuse { id: UNTOUCHED };
    // SAFETY: descriptors are sized.
    let result = unsafe { rlv_diffuse_create(context, &options, given, &mut out) };
    made(result, out.id, &mut handles.diffuses);
    let run = RlvDiffuse { id: handles.pick(bytes, 22)? };
    let (positions, velocities) = (numbers(bytes, 24)?, numbers(bytes, 24)?);
    let mut fluid: RlvDiffuseFluid = sized(bytes)?;
    (fluid.positions, fluid.velocities, fluid.count) = (positions.as_ptr(), velocities.as_ptr(), count(bytes, 8)?);
    let (mut report, mut info) = (sized::<RlvDiffuseReport>(bytes)?, sized::<RlvDiffuseInfo>(bytes)?);
    let mut potentials: RlvDiffusePotentials = sized(bytes)?;
    let (mut air, mut energies) = ([-1.0_f32; 8], [-1.0_f32; 8]);
    (potentials.air, potentials.energies) = (air.as_mut_ptr(), energies.as_mut_ptr());
    potentials.capacity = count(bytes, 8)?;
    let mut patience = bytes.int_in_range(0..=40_u32)?;
    // A restart would let a frame without settings make more particles than an input may take the time for.
    let seconds = number(bytes)?.min(0.25);
    // SAFETY: descriptors are sized, arrays have eight elements, and the user pointer is what the callback takes it for.
    unsafe {
        let user = (&raw mut patience).cast();
        let report: *mut RlvDiffuseReport = if bytes.ratio(1, 4)? { null_mut() } else { &mut report };
        called(rlv_diffuse_advance(run, &fluid, seconds, report, Some(wait), user));
        if called(rlv_diffuse_potentials(run, &fluid, &potentials)) {
            assert!(air.iter().chain(&energies).all(|value| *value <= 1.0));
        }
        called(rlv_diffuse_restore(run, c"/nowhere/nothing.rlvfluid".as_ptr()));
        called(rlv_diffuse_save(run, c"/nowhere/nothing.rlvfluid".as_ptr(), f64::from(seconds)));
        called(rlv_diffuse_info(run, &mut info));
    }
    let room = info.count.min(4096);
    let (mut places, mut kinds, mut lives) = (vec![0.0_f32; 3 * room], vec![9_u32; room], vec![-1.0_f32; room]);
    let mut arrays: RlvDiffuseArrays = sized(bytes)?;
    (arrays.positions, arrays.kinds, arrays.lives) = (places.as_mut_ptr(), kinds.as_mut_ptr(), lives.as_mut_ptr());
    arrays.capacity = count(bytes, room)?;
    // SAFETY: the arrays have the room that is said.
    if called(unsafe { rlv_diffuse_get(run, &arrays) }) {
        let count = info.count.min(room);
        assert!(places.iter().all(|coordinate| coordinate.is_finite()));
        assert!(kinds[..count].iter().all(|kind| *kind < 3) && lives.iter().all(|life| (-1.0..=1.0).contains(life)));
    }
    let mut out = RlvParticles { id: UNTOUCHED };
    // SAFETY: the output is there.
    let result = unsafe { rlv_diffuse_particles(run, f64::from(number(bytes)?), &mut out) };
    made(result, out.id, &mut handles.particles);
    Ok(())
}

/// Decals written into channels and textures, and moved with their meshes.
fn write_decals(bytes: &mut Unstructured, handles: &mut Handles) -> Result<()> {
    let decal = RlvDecal { id: handles.pick(bytes, 19)? };
    let pixels = [0.25_f32; 4 * 256];
    let mut image: RlvDecalImage = sized(bytes)?;
    image.channels = bytes.int_in_range(0..=4)?;
    (image.pixels, image.pixel_count) = (pixels.as_ptr(), bytes.int_in_range(0..=256)?);
    let mut ink: RlvDecalInk = sized(bytes)?;
    (ink.channel, ink.blend) = (bytes.int_in_range(0..=4)?, bytes.int_in_range(0..=7)?);
    (ink.opacity, ink.height) = (number(bytes)?, number(bytes)?);
    let mut report: RlvDecalReport = sized(bytes)?;
    let mut canvas = [0.5_f32; 4 * 256];
    let mut texture: RlvDecalTexture = sized(bytes)?;
    (texture.width, texture.height) = (bytes.int_in_range(0..=16)?, bytes.int_in_range(0..=16)?);
    (texture.channels, texture.gutter) = (bytes.int_in_range(0..=4)?, bytes.int_in_range(0..=257)?);
    (texture.pixels, texture.pixel_count) = (canvas.as_mut_ptr(), (texture.width * texture.height) as usize);
    let points = numbers(bytes, 48)?;
    let mut painted = 0;
    let mut patience = bytes.int_in_range(0..=40_u32)?;
    // SAFETY: descriptors are sized, images have 256 pixels of up to four channels, and there are 16 points.
    unsafe {
        let ink: *const RlvDecalInk = if bytes.ratio(1, 4)? { null() } else { &ink };
        called(rlv_decal_write(decal, &image, ink, &mut report));
        called(rlv_decal_paint_texture(decal, &image, number(bytes)?, &texture, &mut painted));
        let user = (&raw mut patience).cast();
        called(rlv_decal_pose(decal, points.as_ptr(), bytes.int_in_range(0..=16)?, 0, Some(wait), user));
        let document = RlvDocument { id: handles.pick(bytes, 9)? };
        let (mut recipe, mut id, mut count) = (sized::<RlvDecalRecipe>(bytes)?, bytes.int_in_range(0..=2_u32)?, 0);
        let mut pins = [RlvDecalPin::default(); 4];
        let mut out = RlvDecal { id: UNTOUCHED };
        let layer = c"label";
        called(rlv_decal_pins(decal, pins.as_mut_ptr(), bytes.int_in_range(0..=4)?, &mut count));
        let result = rlv_decal_take_up(document, id, Some(wait), user, &mut out);
        made(result, out.id, &mut handles.decals);
        called(rlv_decal_update(decal, document, id, &image, ink, Some(wait), user));
        called(rlv_decal_apply(decal, document, layer.as_ptr(), &image, ink, Some(wait), user, &mut id));
        called(rlv_decal_count(document, &mut count));
        called(rlv_decal_recipe(document, bytes.int_in_range(0..=2)?, &mut recipe));
        called(rlv_decal_remove(document, bytes.int_in_range(0..=2)?));
    }
    Ok(())
}

/// Outlines of images with alpha, and stickers along curves.
fn strips(bytes: &mut Unstructured, handles: &mut Handles) -> Result<()> {
    let (mesh, detail) = (RlvMesh { id: handles.pick(bytes, 1)? }, RlvDetail { id: handles.pick(bytes, 3)? });
    let mut pixels = [0.0_f32; 4 * 64];
    let alpha: [u8; 8] = bytes.arbitrary()?;
    for (at, pixel) in pixels.as_chunks_mut::<4>().0.iter_mut().enumerate() {
        pixel[3] = f32::from(alpha[at / 8] >> (at % 8) & 1);
    }
    let mut image: RlvDecalImage = sized(bytes)?;
    (image.channels, image.pixels) = (bytes.int_in_range(1..=4)?, pixels.as_ptr());
    let [width, height] = [bytes.int_in_range(0..=8_u32)?, bytes.int_in_range(0..=8_u32)?];
    image.pixel_count = (width * height) as usize;
    let (mut corners, mut corner_count) = ([0.0_f64; 2 * 256], 0);
    let (level, tolerance) = (f64::from(number(bytes)?), f64::from(number(bytes)?));
    let room = bytes.int_in_range(0..=256)?;
    let mut options: RlvDecalOptions = sized(bytes)?;
    (options.width, options.height) = (bytes.int_in_range(0..=16)?, bytes.int_in_range(0..=4)?);
    (options.steps, options.triangles, options.cells) = (2, 2000, bytes.int_in_range(0..=4)?);
    let curve: Vec<f64> = numbers(bytes, 12)?.into_iter().map(f64::from).collect();
    let (mut pins, mut pin_count, mut length) = ([RlvDecalPin::default(); 16], 0, 0.0);
    let (given, capacity) = (count(bytes, 4)?, bytes.int_in_range(0..=16)?);
    let on = curve.as_ptr();
    // SAFETY: descriptors are sized, and arrays have the room that is said.
    unsafe {
        let corners = corners.as_mut_ptr();
        if called(rlv_decal_contour(&image, width, height, level, tolerance, corners, room, &mut corner_count)) {
            assert!(corner_count <= room);
            (options.outline, options.outline_count) = (corners, corner_count);
        }
        let pins = pins.as_mut_ptr();
        called(rlv_decal_strip_on_mesh(mesh, &options, on, given, 0, pins, capacity, &mut pin_count, &mut length));
        called(rlv_decal_strip_on_detail(detail, &options, on, given, 0, pins, capacity, &mut pin_count, null_mut()));
    }
    Ok(())
}

/// Models of soft tissue: blocks, models of meshes and of grids, their sets, held nodes and surfaces that follow them.
fn tissues(bytes: &mut Unstructured, handles: &mut Handles) -> Result<()> {
    let context = RlvContext { id: handles.pick(bytes, 0)? };
    let mut materials: [RlvTissueMaterial; 2] = [sized(bytes)?, sized(bytes)?];
    for material in &mut materials {
        material.name = if bytes.ratio(1, 16)? { null() } else { c"gel".as_ptr() };
        material.library = *bytes.choose(&[null(), null(), c"dermis".as_ptr(), c"bone".as_ptr()])?;
        (material.density, material.young, material.poisson) = (1000.0, 3000.0, 0.3);
        if bytes.ratio(1, 4)? {
            (material.density, material.young, material.poisson) = (number(bytes)?, number(bytes)?, number(bytes)?);
        }
    }
    let (low, size) = (place(bytes)?, numbers(bytes, 3)?);
    let counts: [u8; 3] = bytes.arbitrary()?;
    let counts = counts.map(|count| u32::from(count % 4));
    let cell = if bytes.ratio(1, 4)? { size.as_ptr() } else { [0.25_f32, 0.25, 0.5].as_ptr() };
    let mut out = RlvTissue { id: UNTOUCHED };
    // SAFETY: three numbers each are read, and descriptors are sized.
    let result = unsafe { rlv_tissue_block(context, low.as_ptr(), cell, counts.as_ptr(), &materials[0], &mut out) };
    made(result, out.id, &mut handles.tissues);

    let mesh = RlvMesh { id: handles.pick(bytes, 1)? };
    let rings: Vec<f64> = numbers(bytes, 64)?.into_iter().map(f64::from).collect();
    let mut volume: RlvTissueVolume = sized(bytes)?;
    (volume.name, volume.mesh) = (c"flesh".as_ptr(), mesh);
    (volume.level, volume.material) = (bytes.int_in_range(0..=1)?, bytes.int_in_range(0..=2)?);
    (volume.is_muscle, volume.has_layers) = (bytes.int_in_range(0..=2)?, bytes.int_in_range(0..=2)?);
    (volume.stiffness, volume.strength) = (number(bytes)?, number(bytes)?);
    volume.direction = [1.0, f64::from(number(bytes)?), 0.0];
    if bytes.ratio(1, 4)? {
        (volume.rings, volume.ring_size, volume.ring_count) = (rings.as_ptr(), 4, bytes.int_in_range(0..=4)?);
        volume.mesh.id = 0;
    }
    let mut surface: RlvTissueSurface = sized(bytes)?;
    (surface.name, surface.mesh) = (c"skin".as_ptr(), RlvMesh { id: handles.pick(bytes, 1)? });
    (surface.purpose, surface.is_internal) = (bytes.int_in_range(0..=3)?, bytes.int_in_range(0..=2)?);
    surface.angle = number(bytes)?;
    let mut layer: RlvTissueLayer = sized(bytes)?;
    (layer.material, layer.start, layer.thickness) = (bytes.int_in_range(0..=2)?, number(bytes)?, number(bytes)?);
    let mut description: RlvTissueDescription = sized(bytes)?;
    (description.samples, description.cell, description.share) = (bytes.int_in_range(0..=3)?, [0.5; 3], 0.5);
    if bytes.ratio(1, 8)? {
        (description.cell, description.share) = ([number(bytes)?.max(0.25); 3], number(bytes)?);
    }
    (description.materials, description.material_count) = (materials.as_ptr(), count(bytes, 2)?);
    (description.volumes, description.volume_count) = (&volume, count(bytes, 1)?);
    (description.surfaces, description.surface_count) = (&surface, bytes.int_in_range(0..=1)?);
    (description.layers, description.layer_count) = (&layer, bytes.int_in_range(0..=1)?);
    description.skin = if bytes.ratio(1, 4)? { mesh } else { RlvMesh { id: 0 } };
    let mut label: RlvTissueLabel = sized(bytes)?;
    (label.material, label.low, label.high) = (bytes.int_in_range(0..=2)?, number(bytes)?, number(bytes)?);
    let mut labels: RlvTissueLabels = sized(bytes)?;
    (labels.block, labels.share) = (bytes.int_in_range(0..=3)?, 0.5);
    (labels.materials, labels.material_count) = (materials.as_ptr(), 2);
    (labels.labels, labels.label_count) = (&label, count(bytes, 1)?);
    let grid = RlvGrid { id: handles.pick(bytes, 18)? };
    let mut report: RlvTissueReport = sized(bytes)?;
    let mut patience = bytes.int_in_range(0..=40_u32)?;
    // SAFETY: descriptors are sized, with arrays of their counts; the user pointer is what the callback takes it for.
    unsafe {
        let user = (&raw mut patience).cast();
        out.id = UNTOUCHED;
        let result = rlv_tissue_build(context, &description, Some(wait), user, &mut report, &mut out);
        made(result, out.id, &mut handles.tissues);
        out.id = UNTOUCHED;
        let result = rlv_tissue_from_grid(grid, &labels, &mut report, &mut out);
        made(result, out.id, &mut handles.tissues);
        out.id = UNTOUCHED;
        let result = rlv_tissue_scan(context, c"/nowhere/nothing.nrrd".as_ptr(), &labels, null_mut(), &mut out);
        made(result, out.id, &mut handles.tissues);
        out.id = UNTOUCHED;
        let result = rlv_tissue_read(context, c"/nowhere/nothing.rtissue".as_ptr(), &mut out);
        made(result, out.id, &mut handles.tissues);
    }

    let tissue = RlvTissue { id: handles.pick(bytes, 23)? };
    let (mut info, mut set) = (sized::<RlvTissueInfo>(bytes)?, sized::<RlvTissueSet>(bytes)?);
    let mut muscle: RlvTissueMuscle = sized(bytes)?;
    let (mut index, name) = (bytes.int_in_range(0..=2)?, *bytes.choose(&[c"end", c"flesh", c""])?);
    let held: [u8; 4] = bytes.arbitrary()?;
    let held = held.map(|node| u32::from(node % 70));
    let (near, far) = (place(bytes)?.map(|value| value.min(0.0)), place(bytes)?);
    let (mut nodes, mut corners, mut mains) = ([0.0_f32; 3 * 128], [0_u32; 8 * 64], [0_u32; 64]);
    let mut found = [0_u32; 128];
    // SAFETY: descriptors are sized, arrays have the room that is said, and texts end.
    unsafe {
        called(rlv_tissue_info(tissue, &mut info));
        called(rlv_tissue_get_nodes(tissue, nodes.as_mut_ptr(), bytes.int_in_range(0..=128)?, 0));
        called(rlv_tissue_get_elements(tissue, corners.as_mut_ptr(), mains.as_mut_ptr(), bytes.int_in_range(0..=64)?));
        called(rlv_tissue_muscle(tissue, index, &mut muscle));
        called(rlv_tissue_find_muscle(tissue, name.as_ptr(), &mut index));
        called(rlv_tissue_add_set(tissue, name.as_ptr(), near.as_ptr(), far.as_ptr(), &mut index));
        called(rlv_tissue_find_set(tissue, name.as_ptr(), &mut index));
        called(rlv_tissue_set(tissue, index, &mut set));
        called(rlv_tissue_get_set(tissue, index, found.as_mut_ptr(), bytes.int_in_range(0..=128)?));
        called(rlv_tissue_hold(tissue, held.as_ptr(), count(bytes, 4)?, 0, bytes.int_in_range(0..=8)?));
        called(rlv_tissue_bind(tissue, mesh, name.as_ptr(), null_mut()));
        called(rlv_tissue_write(tissue, c"/nowhere/nothing.rtissue".as_ptr()));
    }
    Ok(())
}

/// Simulations of soft tissue: driven, loaded, pressed, pushed by bodies, a few steps of them, and states that are asked for.
fn simulations(bytes: &mut Unstructured, handles: &mut Handles) -> Result<()> {
    let tissue = RlvTissue { id: handles.pick(bytes, 23)? };
    let mut options: RlvTissueOptions = sized(bytes)?;
    (options.gravity, options.safety, options.hourglass) = ([0.0, number(bytes)?, -9.81], 0.7, 1.0);
    options.self_friction = if bytes.ratio(1, 4)? { number(bytes)? } else { -1.0 };
    if bytes.ratio(1, 4)? {
        (options.halvings, options.damping) = (bytes.int_in_range(0..=17)?, number(bytes)?);
        (options.safety, options.hourglass, options.mass_scaling) = (number(bytes)?, number(bytes)?, number(bytes)?);
        options.step = number(bytes)?;
    }
    let mut out = RlvTissueSimulation { id: UNTOUCHED };
    // SAFETY: the descriptor is sized.
    let result = unsafe { rlv_tissue_simulate(tissue, &options, &mut out) };
    made(result, out.id, &mut handles.simulations);
    let simulation = RlvTissueSimulation { id: handles.pick(bytes, 24)? };
    let times = [0.0, 0.001, f64::from(number(bytes)?)];
    let values = numbers(bytes, 24)?;
    let nodes: [u8; 4] = bytes.arbitrary()?;
    let nodes = nodes.map(|node| u32::from(node % 70));
    let mut body: RlvTissueCollider = sized(bytes)?;
    (body.body, body.mesh) = (bytes.int_in_range(0..=3)?, RlvMesh { id: handles.pick(bytes, 1)? });
    (body.radius, body.friction) = (number(bytes)?, number(bytes)?);
    (body.times, body.translations, body.key_count) = (times.as_ptr(), values.as_ptr(), count(bytes, 3)?);
    body.rotations = if bytes.ratio(1, 2)? { values.as_ptr() } else { null() };
    let mut info: RlvTissueSimulationInfo = sized(bytes)?;
    let (on, keys) = (values.as_ptr(), times.as_ptr());
    for _ in 0..bytes.int_in_range(0..=5)? {
        let (axes, nodes_given, keys_given) = (bytes.int_in_range(0..=8)?, count(bytes, 4)?, count(bytes, 3)?);
        // SAFETY: descriptors are sized, and arrays have four nodes, three keys and eight vectors.
        unsafe {
            called(match bytes.int_in_range(0..=5_u8)? {
                0 => rlv_tissue_simulation_activate(simulation, axes, keys, on, keys_given),
                1 => rlv_tissue_simulation_drive(simulation, nodes.as_ptr(), nodes_given, axes, keys, on, keys_given),
                2 => rlv_tissue_simulation_load(simulation, on, bytes.int_in_range(0..=8)?, 0),
                3 => rlv_tissue_simulation_press(simulation, nodes.as_ptr(), nodes_given, keys, on, keys_given),
                4 => rlv_tissue_simulation_add_collider(simulation, &body),
                _ => rlv_tissue_simulation_step(simulation, bytes.int_in_range(0..=9)?),
            });
        }
    }
    let mut patience = bytes.int_in_range(0..=40_u32)?;
    let (mut energies, mut rest) = (sized::<RlvTissueEnergies>(bytes)?, sized::<RlvTissueRelaxation>(bytes)?);
    let (mut positions, mut stresses, mut points) = ([0.0_f32; 3 * 128], [0.0_f32; 6 * 64], [0.0_f32; 3 * 64]);
    let mut arrays: RlvTissueArrays = sized(bytes)?;
    (arrays.positions, arrays.node_count) = (positions.as_mut_ptr(), bytes.int_in_range(0..=128)?);
    (arrays.stresses, arrays.element_count) = (stresses.as_mut_ptr(), bytes.int_in_range(0..=64)?);
    let (mut strains, mut pressures) = ([0.0_f32; 6 * 64], [0.0_f32; 128]);
    (arrays.strains, arrays.contact_pressures) = (strains.as_mut_ptr(), pressures.as_mut_ptr());
    let (tolerance, which) = (number(bytes)?, bytes.int_in_range(0..=2)?);
    let mut mesh = RlvMesh { id: UNTOUCHED };
    // SAFETY: descriptors are sized, arrays have the room that is said, texts end, and the user pointer is what the callback
    // takes it for.
    unsafe {
        let user = (&raw mut patience).cast();
        if called(rlv_tissue_simulation_info(simulation, &mut info)) {
            // Many steps take longer than an input may.
            let seconds = f64::from(number(bytes)?).min(9.0 * f64::from(info.step));
            called(rlv_tissue_simulation_advance(simulation, seconds, Some(wait), user));
        }
        called(rlv_tissue_simulation_relax(simulation, tolerance, 20, Some(wait), user, &mut rest));
        called(rlv_tissue_simulation_energies(simulation, &mut energies));
        called(rlv_tissue_simulation_get(simulation, &arrays));
        called(rlv_tissue_simulation_get_bound(simulation, which, points.as_mut_ptr(), 64, 0));
        called(rlv_tissue_simulation_save(simulation, c"/nowhere/nothing.rtstate".as_ptr()));
        called(rlv_tissue_simulation_restore(simulation, c"/nowhere/nothing.rtstate".as_ptr()));
        called(rlv_tissue_simulation_write_vtu(simulation, c"/nowhere/nothing.vtu".as_ptr()));
        called(rlv_tissue_simulation_write_vdb(simulation, c"/nowhere/nothing.vdb".as_ptr()));
        let result = rlv_tissue_simulation_mesh(simulation, which, &mut mesh);
        made(result, mesh.id, &mut handles.meshes);
    }
    Ok(())
}

fn sequence(bytes: &mut Unstructured, handles: &mut Handles) -> Result<()> {
    let mut options: RlvContextOptions = sized(bytes)?;
    options.threads = 1;
    options.memory_limit = 1 << 24;
    let mut out = RlvContext { id: UNTOUCHED };
    // SAFETY: the descriptor is sized.
    let result = unsafe { rlv_context_create(&options, &mut out) };
    made(result, out.id, &mut handles.contexts);
    while !bytes.is_empty() {
        match bytes.int_in_range(0..=41_u8)? {
            0..=2 => create_mesh(bytes, handles)?,
            3 => read_mesh(bytes, handles)?,
            4..=5 => use_surface(bytes, handles)?,
            6..=7 => use_detail(bytes, handles)?,
            8..=9 => use_collider(bytes, handles)?,
            10..=12 => press(bytes, handles)?,
            13 => evaluate(bytes, handles)?,
            14 => cast(bytes, handles)?,
            15 => follow(bytes, handles)?,
            16..=17 => draw(bytes, handles)?,
            18 => bake(bytes, handles)?,
            19 => remember(bytes, handles)?,
            20 => primitives(bytes, handles)?,
            21 => patches(bytes, handles)?,
            22 => background(bytes, handles)?,
            23 => levels(bytes, handles)?,
            24 => repairs(bytes, handles)?,
            25 => fluids(bytes, handles)?,
            26 => isosurfaces(bytes, handles)?,
            27 => states(bytes, handles)?,
            28 => pictures_of_particles(bytes, handles)?,
            29 => grids(bytes, handles)?,
            30 => decals(bytes, handles)?,
            31 => foam(bytes, handles)?,
            32 => shaders(bytes, handles)?,
            33 => diffuses(bytes, handles)?,
            34 => write_decals(bytes, handles)?,
            35 => strips(bytes, handles)?,
            36 => tissues(bytes, handles)?,
            37 => simulations(bytes, handles)?,
            38 => crowds::models(bytes, handles)?,
            39 => crowds::crowds(bytes, handles)?,
            40 => streams::streams(bytes, handles)?,
            _ if bytes.ratio(1, 4)? => hosts(bytes, handles)?,
            _ => {
                let noun = bytes.int_in_range(0..=27)?;
                let id = handles.pick(bytes, noun)?;
                called(count_reference(noun, id, bytes.ratio(1, 3)?));
            }
        }
    }
    Ok(())
}

fuzz_target!(|data: &[u8]| {
    let mut handles = Handles::default();
    // The bytes end somewhere in the sequence.
    let _ = sequence(&mut Unstructured::new(data), &mut handles);
    for id in &handles.jobs {
        // SAFETY: handles are checked by the library; nothing is to run when the next sequence begins.
        called(unsafe { rlv_job_wait(RlvJob { id: *id }, -1.0, null_mut()) });
    }
    for (noun, list) in handles.lists().into_iter().enumerate() {
        for id in list {
            while count_reference(noun, *id, false) == RLV_OK {}
        }
    }
});
