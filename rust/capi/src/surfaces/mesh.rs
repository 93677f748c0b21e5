//! Meshes; see `include/relievo/mesh.h`.

use std::ffi::{c_char, c_void};
use std::mem::ManuallyDrop;
use std::ops::Deref;
use std::path::{Path, PathBuf};
use std::sync::{Arc, RwLock};

use relievo_core::{Attribute, Crease, Domain, Error, ErrorKind, Mesh, Result, Values};
use relievo_surface::triangle::split;

use crate::border::array::{Input, Output, Plain, fixed, present, put, reserve, text};
use crate::border::descriptor::{read_descriptor, write_descriptor};
use crate::border::making::Making;
use crate::border::memory::{Admitted, mesh_bytes};
use crate::border::registry::{self, handle, try_read, try_write};
use crate::runtime::bytes::{self, RlvBytes};
use crate::runtime::context::{ContextObject, RLV_NAME_SIZE, RlvContext};

handle!(RlvMesh, 2, MeshObject);

constants! {
    u32:
    RLV_DOMAIN_POINT = 0,
    RLV_DOMAIN_CORNER = 1,
    RLV_DOMAIN_FACE = 2,
    RLV_TYPE_F32 = 0,
    RLV_TYPE_U32 = 1,
}

descriptor! {
    pub struct RlvMeshArrays {
        struct_size: u32,
        face_size: u32,
        points: *const f32,
        point_count: usize,
        point_stride: usize,
        face_sizes: *const u32,
        face_count: usize,
        face_stride: usize,
        corners: *const u32,
        corner_count: usize,
        corner_stride: usize,
        creases: *const u32,
        crease_sharpness: *const f32,
        crease_count: usize,
        crease_stride: usize,
        crease_sharpness_stride: usize,
        sharp_points: *const u32,
        sharp_point_sharpness: *const f32,
        sharp_point_count: usize,
        sharp_point_stride: usize,
        sharp_point_sharpness_stride: usize,
        holes: *const u32,
        hole_count: usize,
        hole_stride: usize,
    }
}

descriptor! {
    pub struct RlvMeshInfo {
        struct_size: u32,
        attribute_count: u32,
        point_count: usize,
        face_count: usize,
        corner_count: usize,
        triangle_count: usize,
        crease_count: usize,
        sharp_point_count: usize,
        hole_count: usize,
        low: [f32; 3],
        high: [f32; 3],
    }
}

descriptor! {
    pub struct RlvAttributeArrays {
        struct_size: u32,
        domain: u32,
        type_: u32,
        width: u32,
        name: *const c_char,
        values: *const c_void,
        value_count: usize,
        value_stride: usize,
        indices: *const u32,
        index_count: usize,
        index_stride: usize,
    }
}

descriptor! {
    pub struct RlvAttributeInfo {
        struct_size: u32,
        domain: u32,
        type_: u32,
        width: u32,
        value_count: usize,
        index_count: usize,
        name: [u8; RLV_NAME_SIZE as usize],
    }
}

/// `RlvMeshReleased`: NULL, or a function that gets its user pointer.
pub type RlvMeshReleased = Option<unsafe extern "C" fn(*mut c_void)>;

/// A mesh, some of whose arrays may be the host's.
pub struct Body {
    mesh: ManuallyDrop<Mesh>,
    lent: Option<Lent>,
}

/// Arrays that a host lends: vectors of memory that is not ours, which are never written to, grown or dropped.
struct Lent {
    released: RlvMeshReleased,
    user: *mut c_void,
    has_points: bool,
    has_sizes: bool,
}

// SAFETY: the pointer is only handed back to its owner's function, which the header says runs on any thread.
unsafe impl Send for Lent {}
// SAFETY: as above.
unsafe impl Sync for Lent {}

impl Deref for Body {
    type Target = Mesh;

    fn deref(&self) -> &Mesh {
        &self.mesh
    }
}

impl Body {
    fn new(mesh: Mesh) -> Self {
        Self { mesh: ManuallyDrop::new(mesh), lent: None }
    }

    /// Puts other points, as many, in place of the mesh's.
    fn set_points(&mut self, points: Vec<[f32; 3]>) {
        let before = std::mem::replace(&mut self.mesh.points, points);
        if let Some(lent) = self.lent.as_mut().filter(|lent| lent.has_points) {
            lent.has_points = false;
            std::mem::forget(before);
        }
    }

    /// Adds an attribute, unless the mesh would be unsound with it.
    fn add(&mut self, attribute: Attribute) -> Result<()> {
        self.mesh.attributes.push(attribute);
        self.mesh.check().inspect_err(|_| {
            self.mesh.attributes.pop();
        })
    }

    /// Returns the bytes of its own arrays.
    fn bytes(&self) -> u64 {
        let lent = self.lent.as_ref().map_or(0, |lent| {
            let points = if lent.has_points { size_of_val(&*self.mesh.points) } else { 0 };
            let sizes = if lent.has_sizes { size_of_val(&*self.mesh.face_sizes) } else { 0 };
            points + sizes + size_of_val(&*self.mesh.corners)
        });
        mesh_bytes(&self.mesh) - lent as u64
    }
}

impl Drop for Body {
    fn drop(&mut self) {
        if let Some(lent) = &self.lent {
            std::mem::forget(std::mem::take(&mut self.mesh.corners));
            if lent.has_points {
                std::mem::forget(std::mem::take(&mut self.mesh.points));
            }
            if lent.has_sizes {
                std::mem::forget(std::mem::take(&mut self.mesh.face_sizes));
            }
        }
        // SAFETY: it is dropped here and used no more.
        unsafe { ManuallyDrop::drop(&mut self.mesh) };
        if let Some(Lent { released: Some(released), user, .. }) = self.lent {
            // SAFETY: the host gave this function for this pointer.
            unsafe { released(user) };
        }
    }
}

/// Takes an array of the host as it lies.
///
/// # Safety
/// `count` elements can be read at `pointer`, and stay as they are, until the vector is forgotten.
unsafe fn lend<T: Plain>(name: &str, pointer: *const T, count: usize, stride: usize) -> Result<Vec<T>> {
    // SAFETY: promised by the caller.
    unsafe { Input::new(name, pointer, count, stride) }?;
    if count > 0 && (!pointer.is_aligned() || (stride != 0 && stride != size_of::<T>())) {
        return Err(Error::invalid(format!("elements {stride} bytes apart cannot be borrowed"))
            .at(name)
            .advise("pack the elements at a multiple of 4 bytes, or copy them with rlv_mesh_create"));
    }
    if count == 0 {
        return Ok(Vec::new());
    }
    // SAFETY: the elements are there and aligned; who calls forgets the vector and never lets it grow, so that nobody asks an
    // allocator for the memory.
    Ok(unsafe { Vec::from_raw_parts(pointer.cast_mut(), count, count) })
}

/// Borrows the large arrays of a descriptor and copies the others. Nobody hears when they are used no more.
///
/// # Safety
/// `arrays` is NULL or a descriptor that starts with its size, and its arrays are as `mesh.h` demands.
unsafe fn borrow(arrays: *const RlvMeshArrays, limit: u64) -> Result<Body> {
    // SAFETY: a descriptor of nothing but numbers and NULL pointers.
    let default: RlvMeshArrays = unsafe { std::mem::zeroed() };
    // SAFETY: promised by the caller.
    let given = unsafe { read_descriptor(arrays, default) }?;
    let has_sizes = !given.face_sizes.is_null();
    let rest = RlvMeshArrays { point_count: 0, corner_count: 0, face_sizes: std::ptr::null(), face_count: 0, ..given };
    // SAFETY: promised by the caller.
    let mut mesh = unsafe { copy(&rest, limit) }?;
    if !has_sizes {
        mesh.face_sizes = same_sizes(&given, limit)?;
    }
    let lent = Lent { released: None, user: std::ptr::null_mut(), has_points: true, has_sizes };
    let mut body = Body { mesh: ManuallyDrop::new(mesh), lent: Some(lent) };
    // SAFETY: promised by the caller; the body forgets what is lent.
    unsafe {
        body.mesh.points = lend("points", given.points.cast::<[f32; 3]>(), given.point_count, given.point_stride)?;
        body.mesh.corners = lend("corners", given.corners, given.corner_count, given.corner_stride)?;
        if has_sizes {
            body.mesh.face_sizes = lend("face_sizes", given.face_sizes, given.face_count, given.face_stride)?;
        }
    }
    body.check().map_err(|error| offer_repair(error, "rlv_repair_arrays"))?;
    Ok(body)
}

/// A mesh and the context it belongs to.
pub struct MeshObject {
    pub context: Arc<ContextObject>,
    pub mesh: RwLock<Body>,
    #[expect(dead_code, reason = "given back when it is dropped")]
    admitted: Admitted,
}

impl RlvAttributeInfo {
    /// Of an attribute with so many values and indices.
    pub fn new(attribute: &Attribute, value_count: usize, index_count: usize) -> Self {
        Self {
            struct_size: 0,
            domain: match attribute.domain {
                Domain::Point => RLV_DOMAIN_POINT,
                Domain::Corner => RLV_DOMAIN_CORNER,
                Domain::Face => RLV_DOMAIN_FACE,
            },
            type_: match attribute.values {
                Values::F32(_) => RLV_TYPE_F32,
                Values::U32(_) => RLV_TYPE_U32,
            },
            width: attribute.width,
            value_count,
            index_count,
            name: fixed(&attribute.name),
        }
    }
}

/// Adds to an error about a mesh the call that may mend it.
fn offer_repair(error: Error, call: &str) -> Error {
    let repair = format!("{call} may mend it");
    let remedy = if error.remedy.is_empty() { repair } else { format!("{}; {repair}", error.remedy) };
    error.advise(remedy)
}

/// Registers a checked mesh.
///
/// # Errors
/// Fails with `Memory` if the host refuses its bytes or there are too many objects.
pub fn register(context: Arc<ContextObject>, mesh: Mesh) -> Result<RlvMesh> {
    let admitted = context.memory.admit("mesh", mesh_bytes(&mesh))?;
    registry::insert(MeshObject { context, mesh: RwLock::new(Body::new(mesh)), admitted })
}

/// Registers a mesh of borrowed arrays. Where that fails nobody hears that they are used no more.
fn register_borrowed(
    context: Arc<ContextObject>,
    mut body: Body,
    released: RlvMeshReleased,
    user: *mut c_void,
) -> Result<RlvMesh> {
    let admitted = context.memory.admit("mesh", body.bytes())?;
    if let Some(lent) = &mut body.lent {
        (lent.released, lent.user) = (released, user);
    }
    registry::insert(MeshObject { context, mesh: RwLock::new(body), admitted })
}

/// Makes the sizes of faces that all have `face_size` corners.
fn same_sizes(arrays: &RlvMeshArrays, limit: u64) -> Result<Vec<u32>> {
    let expected = (arrays.face_count as u64).checked_mul(u64::from(arrays.face_size));
    if expected != Some(arrays.corner_count as u64) {
        return Err(Error::invalid(format!(
            "{} faces of {} corners do not make {} corners",
            arrays.face_count, arrays.face_size, arrays.corner_count
        ))
        .at("face_size")
        .advise("set face_size to the corners of every face, or pass face_sizes"));
    }
    let mut same = reserve("face_sizes", arrays.face_count, limit)?;
    same.resize(arrays.face_count, arrays.face_size);
    Ok(same)
}

/// Copies the arrays, refusing what has no room within the memory limit of the context.
///
/// # Safety
/// The arrays are as `mesh.h` demands.
unsafe fn copy(arrays: &RlvMeshArrays, limit: u64) -> Result<Mesh> {
    // SAFETY: for all of these, the caller promises that every array that is not NULL has its count of elements.
    let (points, sizes, corners, creases, crease_sharpness, sharp_points, sharp_sharpness, holes) = unsafe {
        (
            Input::new("points", arrays.points.cast::<[f32; 3]>(), arrays.point_count, arrays.point_stride)?,
            Input::new(
                "face_sizes",
                arrays.face_sizes,
                if arrays.face_sizes.is_null() { 0 } else { arrays.face_count },
                arrays.face_stride,
            )?,
            Input::new("corners", arrays.corners, arrays.corner_count, arrays.corner_stride)?,
            Input::new("creases", arrays.creases.cast::<[u32; 2]>(), arrays.crease_count, arrays.crease_stride)?,
            Input::new(
                "crease_sharpness",
                arrays.crease_sharpness,
                arrays.crease_count,
                arrays.crease_sharpness_stride,
            )?,
            Input::new("sharp_points", arrays.sharp_points, arrays.sharp_point_count, arrays.sharp_point_stride)?,
            Input::new(
                "sharp_point_sharpness",
                arrays.sharp_point_sharpness,
                arrays.sharp_point_count,
                arrays.sharp_point_sharpness_stride,
            )?,
            Input::new("holes", arrays.holes, arrays.hole_count, arrays.hole_stride)?,
        )
    };
    let face_sizes =
        if arrays.face_sizes.is_null() { same_sizes(arrays, limit)? } else { sizes.to_vec("face_sizes", limit)? };
    let mut mesh = Mesh::new(points.to_vec("points", limit)?, face_sizes, corners.to_vec("corners", limit)?);
    mesh.creases = reserve("creases", creases.len(), limit)?;
    mesh.creases
        .extend(creases.iter().zip(crease_sharpness.iter()).map(|(points, sharpness)| Crease { points, sharpness }));
    mesh.sharp_points = reserve("sharp_points", sharp_points.len(), limit)?;
    mesh.sharp_points.extend(sharp_points.iter().zip(sharp_sharpness.iter()));
    mesh.holes = holes.to_vec("holes", limit)?;
    Ok(mesh)
}

/// Copies the arrays of a descriptor, without a check of the mesh that they make.
///
/// # Errors
/// Fails with `Invalid` if the descriptor is NULL, its `struct_size` is none of the type or an array cannot be used,
/// with `Unsupported` if a field that this library lacks is not zero, and with `Memory` if an array takes more than
/// `limit` bytes.
///
/// # Safety
/// `arrays` is NULL or a descriptor that starts with its size, and its arrays are as `mesh.h` demands.
pub unsafe fn read_arrays(arrays: *const RlvMeshArrays, limit: u64) -> Result<Mesh> {
    // SAFETY: a descriptor of nothing but numbers and NULL pointers.
    let default: RlvMeshArrays = unsafe { std::mem::zeroed() };
    // SAFETY: promised by the caller.
    unsafe { copy(&read_descriptor(arrays, default)?, limit) }
}

/// Copies an attribute.
///
/// # Errors
/// Fails with `Invalid` if there is no such domain or type, the width is not 1 to 4, the name is no text, empty or too
/// long for `RLV_NAME_SIZE`, or an array cannot be used, and with `Memory` if one takes more than `limit` bytes.
///
/// # Safety
/// The arrays are as `mesh.h` demands.
pub unsafe fn copy_attribute(arrays: &RlvAttributeArrays, limit: u64) -> Result<Attribute> {
    let domain = match arrays.domain {
        RLV_DOMAIN_POINT => Domain::Point,
        RLV_DOMAIN_CORNER => Domain::Corner,
        RLV_DOMAIN_FACE => Domain::Face,
        other => {
            return Err(Error::invalid(format!("{other} is no domain"))
                .at("domain")
                .advise("use an RLV_DOMAIN_ value"));
        }
    };
    if !(1..=4).contains(&arrays.width) {
        return Err(Error::invalid(format!("{} numbers per value are not supported", arrays.width))
            .at("width")
            .advise("use 1 to 4"));
    }
    // SAFETY: the caller promises NULL or a NUL-terminated string.
    let name = unsafe { text("name", arrays.name) }?;
    if name.is_empty() || name.len() >= RLV_NAME_SIZE as usize {
        return Err(Error::invalid(format!("the name has {} bytes", name.len()))
            .at("name")
            .advise(format!("use 1 to {} bytes", RLV_NAME_SIZE - 1)));
    }
    // Both types are four bytes wide, so both are copied as bit patterns first.
    let width = arrays.width as usize;
    let stride = if arrays.value_stride == 0 { width * 4 } else { arrays.value_stride };
    let (count, start) = (arrays.value_count, arrays.values.cast::<u32>());
    let mut bits: Vec<u32> = reserve("values", count.saturating_mul(width), limit)?;
    if stride < width * 4 {
        return Err(Error::invalid(format!("the stride of {stride} bytes is less than a value"))
            .at("value_stride")
            .advise(format!("use 0 for packed values, or at least {}", width * 4)));
    }
    // SAFETY: the caller promises `count` values of `width` numbers, `stride` bytes from one another; the first input
    // checks that the whole range fits the address space.
    unsafe {
        Input::new("values", start, count, stride)?;
        for index in 0..count {
            let value = start.cast::<u8>().add(index * stride).cast::<u32>();
            bits.extend(Input::new("values", value, width, 0)?.iter());
        }
    }
    let values = match arrays.type_ {
        RLV_TYPE_F32 => Values::F32(bits.into_iter().map(f32::from_bits).collect()),
        RLV_TYPE_U32 => Values::U32(bits),
        other => {
            return Err(Error::invalid(format!("{other} is no type")).at("type").advise("use an RLV_TYPE_ value"));
        }
    };
    let indices = if arrays.indices.is_null() {
        None
    } else {
        // SAFETY: the caller promises `index_count` indices.
        let indices = unsafe { Input::new("indices", arrays.indices, arrays.index_count, arrays.index_stride) }?;
        Some(indices.to_vec("indices", limit)?)
    };
    Ok(Attribute { name: name.to_string(), domain, width: arrays.width, values, indices })
}

fn attribute(mesh: &Mesh, index: u32) -> Result<&Attribute> {
    mesh.attributes.get(index as usize).ok_or_else(|| {
        Error::invalid(format!("attribute {index} does not exist"))
            .at("attribute")
            .advise(format!("the mesh has {}", mesh.attributes.len()))
    })
}

/// Checks that every coordinate is finite.
///
/// # Errors
/// Fails with `Invalid`, and the number of the element, if one is not.
pub fn finite(name: &str, points: &[[f32; 3]]) -> Result<()> {
    match points.iter().position(|point| !point.iter().all(|value| value.is_finite())) {
        Some(index) => {
            Err(Error::invalid("a coordinate is not a finite number").at(format!("{name}, element {index}")))
        }
        None => Ok(()),
    }
}

/// Reads what a mesh is read from.
///
/// # Errors
/// Fails with `Invalid` if the handle is not alive or the path is no text. What the work refuses, it returns: a file
/// that cannot be read or is damaged, a mesh that cannot be used or whose bytes the host refuses, or `Cancelled`.
///
/// # Safety
/// `path` is NULL or a NUL-terminated text.
pub unsafe fn reading(context: RlvContext, path: *const c_char) -> Result<Making<RlvMesh>> {
    let context = registry::get(context)?;
    // SAFETY: promised by the caller.
    let path = unsafe { text("path", path) }?.to_owned();
    Ok(Making::new(context.clone(), move |progress| {
        progress.step(0.0, "read")?;
        let mesh = relievo_meshio::read(&context.context, Path::new(&path))?;
        progress.step(0.8, "check")?;
        mesh.check().map_err(|error| offer_repair(error, "rlv_repair_read").at(path.clone()))?;
        progress.step(1.0, "check")?;
        register(context, mesh)
    }))
}

/// Reads where a mesh is written to.
///
/// # Errors
/// Fails with `Invalid` if the handle is not alive or the path is no text. What the work refuses, it returns: a mesh
/// that is busy, a file that cannot be written, or `Cancelled`.
///
/// # Safety
/// As for [`reading`].
pub unsafe fn writing(mesh: RlvMesh, path: *const c_char) -> Result<Making<()>> {
    let object = registry::get(mesh)?;
    // SAFETY: promised by the caller.
    let path = PathBuf::from(unsafe { text("path", path) }?);
    Ok(Making::new(object.context.clone(), move |progress| {
        let mesh = try_read(&object.mesh, "mesh")?;
        progress.step(0.0, "write")?;
        relievo_meshio::write(&path, &mesh)?;
        // The file is there: too late to stop.
        progress.report(1.0, "write");
        Ok(())
    }))
}

entry! {
    fn rlv_mesh_create(context: RlvContext, arrays: *const RlvMeshArrays, out: *mut RlvMesh) {
        present("out", out)?;
        let context = registry::get(context)?;
        // SAFETY: the caller gives NULL or a descriptor that starts with its size, with arrays as the header demands.
        let mesh = unsafe { read_arrays(arrays, context.context.memory_limit()) }?;
        mesh.check().map_err(|error| offer_repair(error, "rlv_repair_arrays"))?;
        let handle = register(context, mesh)?;
        // SAFETY: checked above.
        unsafe { put(out, handle) };
        Ok(())
    }

    fn rlv_mesh_create_borrowed(
        context: RlvContext,
        arrays: *const RlvMeshArrays,
        released: RlvMeshReleased,
        user: *mut c_void,
        out: *mut RlvMesh,
    ) {
        present("out", out)?;
        let context = registry::get(context)?;
        // SAFETY: the caller gives NULL or a descriptor that starts with its size, with arrays as the header demands.
        let body = unsafe { borrow(arrays, context.context.memory_limit()) }?;
        let handle = register_borrowed(context, body, released, user)?;
        // SAFETY: checked above.
        unsafe { put(out, handle) };
        Ok(())
    }

    fn rlv_mesh_read(context: RlvContext, path: *const c_char, out: *mut RlvMesh) {
        present("out", out)?;
        // SAFETY: the caller promises NULL or a NUL-terminated string.
        let handle = unsafe { reading(context, path) }?.now()?;
        // SAFETY: checked above.
        unsafe { put(out, handle) };
        Ok(())
    }

    fn rlv_mesh_write(mesh: RlvMesh, path: *const c_char) {
        // SAFETY: the caller promises NULL or a NUL-terminated string.
        unsafe { writing(mesh, path) }?.now()
    }

    fn rlv_mesh_read_bytes(
        context: RlvContext,
        format: *const c_char,
        bytes: *const u8,
        size: usize,
        out: *mut RlvMesh,
    ) {
        present("out", out)?;
        let context = registry::get(context)?;
        // SAFETY: the caller promises NULL or a NUL-terminated string, and `size` bytes.
        let (format, bytes) = unsafe { (text("format", format)?, bytes::take(bytes, size, context.context.memory_limit())?) };
        let mesh = relievo_meshio::parse(&context.context, format, bytes).map_err(|error| error.at("bytes"))?;
        mesh.check().map_err(|error| offer_repair(error, "rlv_repair_arrays").at("bytes"))?;
        let handle = register(context, mesh)?;
        // SAFETY: checked above.
        unsafe { put(out, handle) };
        Ok(())
    }

    fn rlv_mesh_write_bytes(mesh: RlvMesh, format: *const c_char, out: *mut RlvBytes) {
        present("out", out)?;
        let object = registry::get(mesh)?;
        // SAFETY: the caller promises NULL or a NUL-terminated string.
        let format = unsafe { text("format", format) }?;
        let made = relievo_meshio::to_bytes(format, &*try_read(&object.mesh, "mesh")?)?;
        // SAFETY: checked above.
        unsafe { bytes::give(made, out) }
    }

    fn rlv_mesh_split(mesh: RlvMesh, longest_edge: f64, out: *mut RlvMesh) {
        present("out", out)?;
        let object = registry::get(mesh)?;
        let (made, _) = split(&object.context.context, &*try_read(&object.mesh, "mesh")?, longest_edge)?;
        let handle = register(object.context.clone(), made)?;
        // SAFETY: checked above.
        unsafe { put(out, handle) };
        Ok(())
    }

    fn rlv_mesh_retain(mesh: RlvMesh) {
        registry::retain(mesh)
    }

    fn rlv_mesh_release(mesh: RlvMesh) {
        registry::release(mesh)
    }

    fn rlv_mesh_info(mesh: RlvMesh, out: *mut RlvMeshInfo) {
        let object = registry::get(mesh)?;
        let mesh = try_read(&object.mesh, "mesh")?;
        let (low, high) = mesh.bounds().unwrap_or_default();
        let mut hole = vec![false; mesh.face_count()];
        for face in &mesh.holes {
            if let Some(hole) = hole.get_mut(*face as usize) {
                *hole = true;
            }
        }
        let sizes = mesh.face_sizes.iter().zip(hole);
        let info = RlvMeshInfo {
            struct_size: 0,
            attribute_count: mesh.attributes.len() as u32,
            point_count: mesh.points.len(),
            face_count: mesh.face_count(),
            corner_count: mesh.corners.len(),
            triangle_count: sizes.filter(|(_, hole)| !hole).map(|(size, _)| *size as usize - 2).sum(),
            crease_count: mesh.creases.len(),
            sharp_point_count: mesh.sharp_points.len(),
            hole_count: mesh.holes.len(),
            low,
            high,
        };
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        unsafe { write_descriptor(out, info) }
    }

    fn rlv_mesh_set_points(mesh: RlvMesh, points: *const f32, count: usize, stride: usize) {
        let object = registry::get(mesh)?;
        // SAFETY: the caller promises `count` points.
        let points = unsafe { Input::new("points", points.cast::<[f32; 3]>(), count, stride) }?;
        let points = points.to_vec("points", object.context.context.memory_limit())?;
        finite("points", &points)?;
        let mut mesh = try_write(&object.mesh, "mesh")?;
        if points.len() != mesh.points.len() {
            return Err(Error::invalid(format!("{} points were given for {}", points.len(), mesh.points.len()))
                .at("points")
                .advise("give one position per point; make another mesh if the topology changed"));
        }
        mesh.set_points(points);
        Ok(())
    }

    fn rlv_mesh_add_attribute(mesh: RlvMesh, arrays: *const RlvAttributeArrays) {
        let object = registry::get(mesh)?;
        // SAFETY: a descriptor of nothing but numbers and NULL pointers.
        let default: RlvAttributeArrays = unsafe { std::mem::zeroed() };
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        let arrays = unsafe { read_descriptor(arrays, default) }?;
        // SAFETY: the caller's arrays are as the header demands.
        let attribute = unsafe { copy_attribute(&arrays, object.context.context.memory_limit()) }?;
        try_write(&object.mesh, "mesh")?.add(attribute)
    }

    fn rlv_mesh_get_points(mesh: RlvMesh, points: *mut f32, capacity: usize, stride: usize) {
        let object = registry::get(mesh)?;
        let mesh = try_read(&object.mesh, "mesh")?;
        // SAFETY: the caller promises room for `capacity` points.
        let out = unsafe { Output::new("points", points.cast::<[f32; 3]>(), capacity, stride) }?;
        out.holds("points", mesh.points.len())?.fill(mesh.points.iter().copied());
        Ok(())
    }

    fn rlv_mesh_get_faces(mesh: RlvMesh, face_sizes: *mut u32, face_capacity: usize, corners: *mut u32, corner_capacity: usize) {
        let object = registry::get(mesh)?;
        let mesh = try_read(&object.mesh, "mesh")?;
        // SAFETY: the caller promises room for the capacities, or NULL for what is not wanted.
        let (sizes, corners) = unsafe {
            (
                Output::optional("face_sizes", face_sizes, face_capacity, 0)?,
                Output::optional("corners", corners, corner_capacity, 0)?,
            )
        };
        let sizes = sizes.map(|out| out.holds("face_sizes", mesh.face_sizes.len())).transpose()?;
        let corners = corners.map(|out| out.holds("corners", mesh.corners.len())).transpose()?;
        if let Some(sizes) = sizes {
            sizes.fill(mesh.face_sizes.iter().copied());
        }
        if let Some(corners) = corners {
            corners.fill(mesh.corners.iter().copied());
        }
        Ok(())
    }

    fn rlv_mesh_get_triangles(mesh: RlvMesh, triangles: *mut u32, capacity: usize, stride: usize) {
        let object = registry::get(mesh)?;
        let mesh = try_read(&object.mesh, "mesh")?;
        let made = mesh.triangles();
        // SAFETY: the caller promises room for `capacity` triangles.
        let out = unsafe { Output::new("triangles", triangles.cast::<[u32; 3]>(), capacity, stride) }?;
        out.holds("triangles", made.len())?.fill(made);
        Ok(())
    }

    fn rlv_mesh_find_attribute(mesh: RlvMesh, name: *const c_char, out: *mut u32) {
        present("out", out)?;
        let object = registry::get(mesh)?;
        // SAFETY: the caller promises NULL or a NUL-terminated string.
        let name = unsafe { text("name", name) }?;
        let mesh = try_read(&object.mesh, "mesh")?;
        let found = mesh.attributes.iter().position(|attribute| attribute.name == name).ok_or_else(|| {
            let error = Error::new(ErrorKind::NotFound, format!("the mesh has no attribute `{name}`"));
            match relievo_core::error::nearest(name, mesh.attributes.iter().map(|attribute| attribute.name.as_str())) {
                Some(near) => error.advise(format!("did you mean `{near}`?")),
                None => error,
            }
        })?;
        // SAFETY: checked above.
        unsafe { put(out, found as u32) };
        Ok(())
    }

    fn rlv_mesh_attribute_info(mesh: RlvMesh, index: u32, out: *mut RlvAttributeInfo) {
        let object = registry::get(mesh)?;
        let mesh = try_read(&object.mesh, "mesh")?;
        let attribute = attribute(&mesh, index)?;
        let count = attribute.values.len() / attribute.width as usize;
        let info = RlvAttributeInfo::new(attribute, count, attribute.indices.as_ref().map_or(0, Vec::len));
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        unsafe { write_descriptor(out, info) }
    }

    fn rlv_mesh_get_attribute(mesh: RlvMesh, index: u32, values: *mut c_void, number_capacity: usize, indices: *mut u32, index_capacity: usize) {
        let object = registry::get(mesh)?;
        let mesh = try_read(&object.mesh, "mesh")?;
        let attribute = attribute(&mesh, index)?;
        // SAFETY: the caller promises room for the capacities, or NULL for what is not wanted.
        let (out, index_out) = unsafe {
            (
                Output::optional("values", values.cast::<u32>(), number_capacity, 0)?,
                Output::optional("indices", indices, index_capacity, 0)?,
            )
        };
        let out = out.map(|out| out.holds("values", attribute.values.len())).transpose()?;
        let have = attribute.indices.as_deref().unwrap_or_default();
        let index_out = index_out.map(|out| out.holds("indices", have.len())).transpose()?;
        if let Some(out) = out {
            match &attribute.values {
                Values::F32(numbers) => out.fill(numbers.iter().map(|number| number.to_bits())),
                Values::U32(numbers) => out.fill(numbers.iter().copied()),
            }
        }
        if let Some(out) = index_out {
            out.fill(have.iter().copied());
        }
        Ok(())
    }
}
