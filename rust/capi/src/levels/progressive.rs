//! Progressive meshes; see `include/relievo/progressive.h`.

use std::ffi::{c_char, c_void};
use std::path::PathBuf;
use std::sync::{Arc, Mutex, OnceLock, Weak};

use relievo_core::{Domain, Error, Progress, Result};
use relievo_lod::progressive::{BuildOptions, DeviceHierarchy, Extents};
use relievo_lod::{AttributeOptions, Progressive, Welded, weld};

use crate::border::array::{Input, present, put, text};
use crate::border::descriptor::{read_optional, write_descriptor};
use crate::border::making::Making;
use crate::border::registry::{self, handle, try_read};
use crate::border::work::broken;
use crate::levels::simplify::{RlvSimplifyWeight, attributes_of};
use crate::runtime::bytes::{self, RlvBytes};
use crate::runtime::context::{ContextObject, HostProgress, RlvContext, RlvProgress};
use crate::surfaces::mesh::{MeshObject, RlvAttributeInfo, RlvMesh};

handle!(RlvProgressive, 16, ProgressiveObject);

descriptor! {
    pub struct RlvProgressiveOptions {
        struct_size: u32,
        keeps_attributes: u32,
        base_triangles: usize,
        locked: *const u32,
        locked_count: usize,
        locked_stride: usize,
        weights: *const RlvSimplifyWeight,
        weight_count: usize,
        weight_stride: usize,
    }
}

descriptor! {
    pub struct RlvProgressiveInfo {
        struct_size: u32,
        attribute_count: u32,
        vertex_count: usize,
        triangle_count: usize,
        base_vertex_count: usize,
        base_triangle_count: usize,
        bytes: usize,
        wedge_count: usize,
        wedge_width: u32,
        face_width: u32,
    }
}

/// A progressive mesh and the context it belongs to.
pub struct ProgressiveObject {
    pub context: Arc<ContextObject>,
    pub mesh: Arc<Progressive>,
    extents: OnceLock<Extents>,
    /// What the device of the context has of it, as long as there is a level there.
    sent: Mutex<Weak<DeviceHierarchy>>,
}

impl ProgressiveObject {
    /// How far splits reach, which views ask for.
    pub fn extents(&self) -> &Extents {
        self.extents.get_or_init(|| Extents::new(&self.mesh))
    }

    /// What the device of the context has of it, which is sent if it has nothing.
    ///
    /// # Errors
    /// Fails with `Unsupported` if the context has no graphics device, with `Memory` if that has no room for it, with
    /// `Device` if it was lost, and with `Internal` if an earlier panic left this broken.
    pub fn on_device(&self) -> Result<Arc<DeviceHierarchy>> {
        let device = self.context.opened_device()?;
        device.check()?;
        let mut sent = self.sent.lock().map_err(|_| broken("progressive mesh"))?;
        if let Some(there) = sent.upgrade() {
            return Ok(there);
        }
        let context = &self.context.context;
        let made = Arc::new(DeviceHierarchy::with_surroundings(context, device, &self.mesh, self.extents())?);
        *sent = Arc::downgrade(&made);
        Ok(made)
    }
}

/// What a progressive mesh is to be built of.
pub struct Build {
    context: Arc<ContextObject>,
    source: Source,
    options: BuildOptions,
}

/// Its places alone, or a mesh whose attributes are kept.
enum Source {
    Places(Vec<[f32; 3]>, Vec<[u32; 3]>),
    Mesh(Arc<MeshObject>, AttributeOptions),
}

impl Build {
    /// Copies what is needed of a mesh.
    ///
    /// # Errors
    /// Fails with `Invalid` if the handle is not alive, an option or an array cannot be used or a locked point does not
    /// exist, and with `Busy` if the mesh is being changed.
    ///
    /// # Safety
    /// `options` is NULL or a descriptor whose arrays are as the header demands.
    pub unsafe fn read(mesh: RlvMesh, options: *const RlvProgressiveOptions) -> Result<Self> {
        let object = registry::get(mesh)?;
        let mesh = try_read(&object.mesh, "mesh")?;
        let known = |point: u32| match mesh.points.get(point as usize) {
            Some(_) => Ok(point),
            None => Err(Error::invalid(format!("the mesh has no point {point}")).at("locked")),
        };
        // SAFETY: promised by the caller.
        let (mut options, attributes) = unsafe { read_options(options, known) }?;
        let source = match attributes {
            Some(attributes) => Source::Mesh(object.clone(), attributes),
            None => {
                let Welded { points, triangles, numbers } = weld(&mesh.points, &mesh.triangles());
                options.locked.iter_mut().for_each(|point| *point = numbers[*point as usize]);
                Source::Places(points, triangles)
            }
        };
        Ok(Self { context: object.context.clone(), source, options })
    }

    pub fn context(&self) -> &Arc<ContextObject> {
        &self.context
    }

    /// Builds it.
    ///
    /// # Errors
    /// Fails with `Busy` if the mesh is being changed, with `Cancelled` if `progress` asks to stop, and as
    /// [`Progressive::build`] or [`Progressive::build_mesh`] does.
    pub fn run(&self, progress: &mut dyn Progress) -> Result<RlvProgressive> {
        let context = &self.context.context;
        let mesh = match &self.source {
            Source::Places(points, triangles) => {
                Progressive::build(context, points, triangles, &self.options, progress)?
            }
            Source::Mesh(object, attributes) => {
                let mesh = try_read(&object.mesh, "mesh")?;
                Progressive::build_mesh(context, &mesh, &self.options, attributes, progress)?.0
            }
        };
        register(self.context.clone(), mesh)
    }
}

/// What a mesh is built for, and what its attributes count for if they are kept. `number` tells the vertex at a locked
/// point.
///
/// # Errors
/// Fails with `Invalid` if `struct_size` is none of the type or an option or an array cannot be used, with
/// `Unsupported` if a field that this library lacks is not zero, and as `number` does.
///
/// # Safety
/// `options` is NULL or a descriptor whose arrays are as the header demands.
pub unsafe fn read_options(
    options: *const RlvProgressiveOptions,
    number: impl Fn(u32) -> Result<u32>,
) -> Result<(BuildOptions, Option<AttributeOptions>)> {
    // SAFETY: a descriptor of nothing but numbers and NULL pointers.
    let default: RlvProgressiveOptions = unsafe { std::mem::zeroed() };
    let default = RlvProgressiveOptions { base_triangles: BuildOptions::default().faces, ..default };
    // SAFETY: promised by the caller.
    let given = unsafe { read_optional(options, default) }?;
    // SAFETY: promised by the caller.
    let (locked, weights) = unsafe {
        (
            Input::new("locked", given.locked, given.locked_count, given.locked_stride)?,
            Input::new("weights", given.weights, given.weight_count, given.weight_stride)?,
        )
    };
    let attributes = match given.keeps_attributes {
        0 => None,
        // SAFETY: promised by the caller.
        1 => Some(unsafe { attributes_of(&weights) }?),
        other => {
            let error = Error::invalid(format!("keeps_attributes is {other}")).at("keeps_attributes");
            return Err(error.advise("use 0 or 1"));
        }
    };
    let locked = locked.iter().map(number).collect::<Result<_>>()?;
    Ok((BuildOptions { faces: given.base_triangles, locked }, attributes))
}

/// Registers a progressive mesh.
///
/// # Errors
/// Fails with `Memory` if there are too many objects.
pub fn register(context: Arc<ContextObject>, mesh: impl Into<Arc<Progressive>>) -> Result<RlvProgressive> {
    let (mesh, extents, sent) = (mesh.into(), OnceLock::new(), Mutex::default());
    registry::insert(ProgressiveObject { context, mesh, extents, sent })
}

/// Reads which progressive mesh is read, up to so many triangles.
///
/// # Errors
/// Fails with `Invalid` if the handle is not alive or the path is no text. What the work refuses, it returns: a file that
/// cannot be read or is damaged, or `Cancelled`.
///
/// # Safety
/// `path` is NULL or a NUL-terminated text.
pub unsafe fn reading(context: RlvContext, path: *const c_char, triangles: usize) -> Result<Making<RlvProgressive>> {
    let context = registry::get(context)?;
    // SAFETY: promised by the caller.
    let path = PathBuf::from(unsafe { text("path", path) }?);
    Ok(Making::new(context.clone(), move |progress| {
        progress.step(0.0, "read")?;
        let mesh = Progressive::open(&context.context, &path, triangles)?;
        progress.step(1.0, "read")?;
        register(context, mesh)
    }))
}

/// Reads where a progressive mesh is written to.
///
/// # Errors
/// Fails with `Invalid` if the handle is not alive or the path is no text. What the work refuses, it returns: a file that
/// cannot be written, or `Cancelled`.
///
/// # Safety
/// As for [`reading`].
pub unsafe fn writing(progressive: RlvProgressive, path: *const c_char) -> Result<Making<()>> {
    let object = registry::get(progressive)?;
    // SAFETY: promised by the caller.
    let path = PathBuf::from(unsafe { text("path", path) }?);
    Ok(Making::new(object.context.clone(), move |progress| {
        progress.step(0.0, "write")?;
        object.mesh.save(&object.context.context, &path)?;
        progress.report(1.0, "write");
        Ok(())
    }))
}

entry! {
    fn rlv_progressive_create(
        mesh: RlvMesh,
        options: *const RlvProgressiveOptions,
        progress: RlvProgress,
        user: *mut c_void,
        out: *mut RlvProgressive,
    ) {
        present("out", out)?;
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        let build = unsafe { Build::read(mesh, options) }?;
        let made = build.run(&mut HostProgress { callback: progress, user })?;
        // SAFETY: checked above.
        unsafe { put(out, made) };
        Ok(())
    }

    fn rlv_progressive_read(context: RlvContext, path: *const c_char, triangles: usize, out: *mut RlvProgressive) {
        present("out", out)?;
        // SAFETY: the caller gives NULL or a NUL-terminated text.
        let made = unsafe { reading(context, path, triangles) }?.now()?;
        // SAFETY: checked above.
        unsafe { put(out, made) };
        Ok(())
    }

    fn rlv_progressive_write(progressive: RlvProgressive, path: *const c_char) {
        // SAFETY: the caller gives NULL or a NUL-terminated text.
        unsafe { writing(progressive, path) }?.now()
    }

    fn rlv_progressive_read_bytes(
        context: RlvContext,
        bytes: *const u8,
        size: usize,
        triangles: usize,
        out: *mut RlvProgressive,
    ) {
        present("out", out)?;
        let context = registry::get(context)?;
        // SAFETY: the caller promises `size` bytes.
        let bytes = unsafe { bytes::take(bytes, size, context.context.memory_limit()) }?;
        let mesh = Progressive::read(&context.context, &mut bytes.as_slice(), triangles).map_err(|error| error.at("bytes"))?;
        let made = register(context, mesh)?;
        // SAFETY: checked above.
        unsafe { put(out, made) };
        Ok(())
    }

    fn rlv_progressive_write_bytes(progressive: RlvProgressive, out: *mut RlvBytes) {
        present("out", out)?;
        let object = registry::get(progressive)?;
        // SAFETY: checked above.
        unsafe { bytes::give(object.mesh.to_bytes(&object.context.context)?, out) }
    }

    fn rlv_progressive_retain(progressive: RlvProgressive) {
        registry::retain(progressive)
    }

    fn rlv_progressive_release(progressive: RlvProgressive) {
        registry::release(progressive)
    }

    fn rlv_progressive_info(progressive: RlvProgressive, out: *mut RlvProgressiveInfo) {
        let object = registry::get(progressive)?;
        let [wedge_width, face_width] = object.mesh.attribute_widths();
        let info = RlvProgressiveInfo {
            struct_size: 0,
            attribute_count: object.mesh.attributes().len() as u32,
            vertex_count: object.mesh.vertex_count(),
            triangle_count: object.mesh.triangle_count(),
            base_vertex_count: object.mesh.base_vertices().len(),
            base_triangle_count: object.mesh.base_faces().len(),
            bytes: object.mesh.bytes(),
            wedge_count: object.mesh.wedge_count(),
            wedge_width: wedge_width as u32,
            face_width: face_width as u32,
        };
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        unsafe { write_descriptor(out, info) }
    }

    fn rlv_progressive_attribute_info(progressive: RlvProgressive, index: u32, out: *mut RlvAttributeInfo) {
        let object = registry::get(progressive)?;
        let attributes = object.mesh.attributes();
        let attribute = attributes.get(index as usize).ok_or_else(|| {
            Error::invalid(format!("attribute {index} does not exist"))
                .at("attribute")
                .advise(format!("the progressive mesh has {}", attributes.len()))
        })?;
        let count = match attribute.domain {
            Domain::Face => object.mesh.triangle_count(),
            Domain::Point | Domain::Corner => object.mesh.wedge_count(),
        };
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        unsafe { write_descriptor(out, RlvAttributeInfo::new(attribute, count, 0)) }
    }
}
