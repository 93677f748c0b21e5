//! Progressive meshes; see `include/relievo/progressive.h`.

use std::ffi::{c_char, c_void};
use std::path::Path;
use std::sync::{Arc, OnceLock};

use relievo_core::{Error, Progress, Result};
use relievo_lod::progressive::{BuildOptions, Extents};
use relievo_lod::{Progressive, weld};

use crate::array::{Input, present, put, text};
use crate::context::{ContextObject, HostProgress, RlvContext, RlvProgress};
use crate::descriptor::{read_optional, write_descriptor};
use crate::mesh::RlvMesh;
use crate::registry::{self, handle, try_read};

handle!(RlvProgressive, 16, ProgressiveObject);

descriptor! {
    pub struct RlvProgressiveOptions {
        struct_size: u32,
        reserved: u32,
        base_triangles: usize,
        locked: *const u32,
        locked_count: usize,
        locked_stride: usize,
    }
}

descriptor! {
    pub struct RlvProgressiveInfo {
        struct_size: u32,
        reserved: u32,
        vertex_count: usize,
        triangle_count: usize,
        base_vertex_count: usize,
        base_triangle_count: usize,
        bytes: usize,
    }
}

/// A progressive mesh and the context it belongs to.
pub struct ProgressiveObject {
    pub context: Arc<ContextObject>,
    pub mesh: Arc<Progressive>,
    extents: OnceLock<Extents>,
}

impl ProgressiveObject {
    /// How far splits reach, which views ask for.
    pub fn extents(&self) -> &Extents {
        self.extents.get_or_init(|| Extents::new(&self.mesh))
    }
}

/// What a progressive mesh is to be built of.
pub struct Build {
    context: Arc<ContextObject>,
    points: Vec<[f32; 3]>,
    triangles: Vec<[u32; 3]>,
    options: BuildOptions,
}

impl Build {
    /// Copies what is needed of a mesh.
    ///
    /// # Safety
    /// `options` is NULL or a descriptor whose array is as the header demands.
    pub unsafe fn read(mesh: RlvMesh, options: *const RlvProgressiveOptions) -> Result<Self> {
        let object = registry::get(mesh)?;
        let mesh = try_read(&object.mesh, "mesh")?;
        let welded = weld(&mesh.points, &mesh.triangles());
        let number = |point: u32| {
            let refusal = || Error::invalid(format!("the mesh has no point {point}")).at("locked");
            welded.numbers.get(point as usize).copied().ok_or_else(refusal)
        };
        // SAFETY: promised by the caller.
        let options = unsafe { read_options(options, number) }?;
        Ok(Self { context: object.context.clone(), points: welded.points, triangles: welded.triangles, options })
    }

    pub fn context(&self) -> &Arc<ContextObject> {
        &self.context
    }

    /// Builds it.
    pub fn run(&self, progress: &mut dyn Progress) -> Result<RlvProgressive> {
        let context = &self.context.context;
        let mesh = Progressive::build(context, &self.points, &self.triangles, &self.options, progress)?;
        register(self.context.clone(), mesh)
    }
}

/// What a mesh is built for. `number` tells the vertex at a locked point.
///
/// # Safety
/// `options` is NULL or a descriptor whose array is as the header demands.
pub unsafe fn read_options(
    options: *const RlvProgressiveOptions,
    number: impl Fn(u32) -> Result<u32>,
) -> Result<BuildOptions> {
    let default = RlvProgressiveOptions {
        struct_size: 0,
        reserved: 0,
        base_triangles: BuildOptions::default().faces,
        locked: std::ptr::null(),
        locked_count: 0,
        locked_stride: 0,
    };
    // SAFETY: promised by the caller.
    let given = unsafe { read_optional(options, default) }?;
    // SAFETY: promised by the caller.
    let locked = unsafe { Input::new("locked", given.locked, given.locked_count, given.locked_stride) }?;
    Ok(BuildOptions { faces: given.base_triangles, locked: locked.iter().map(number).collect::<Result<_>>()? })
}

/// Registers a progressive mesh.
pub fn register(context: Arc<ContextObject>, mesh: Progressive) -> Result<RlvProgressive> {
    registry::insert(ProgressiveObject { context, mesh: Arc::new(mesh), extents: OnceLock::new() })
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
        let context = registry::get(context)?;
        // SAFETY: the caller gives NULL or a NUL-terminated text.
        let path = unsafe { text("path", path) }?;
        let mesh = Progressive::open(&context.context, Path::new(path), triangles)?;
        let made = register(context, mesh)?;
        // SAFETY: checked above.
        unsafe { put(out, made) };
        Ok(())
    }

    fn rlv_progressive_write(progressive: RlvProgressive, path: *const c_char) {
        let object = registry::get(progressive)?;
        // SAFETY: the caller gives NULL or a NUL-terminated text.
        let path = unsafe { text("path", path) }?;
        object.mesh.save(&object.context.context, Path::new(path))
    }

    fn rlv_progressive_retain(progressive: RlvProgressive) {
        registry::retain(progressive)
    }

    fn rlv_progressive_release(progressive: RlvProgressive) {
        registry::release(progressive)
    }

    fn rlv_progressive_info(progressive: RlvProgressive, out: *mut RlvProgressiveInfo) {
        let object = registry::get(progressive)?;
        let info = RlvProgressiveInfo {
            struct_size: 0,
            reserved: 0,
            vertex_count: object.mesh.vertex_count(),
            triangle_count: object.mesh.triangle_count(),
            base_vertex_count: object.mesh.base_vertices().len(),
            base_triangle_count: object.mesh.base_faces().len(),
            bytes: object.mesh.bytes(),
        };
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        unsafe { write_descriptor(out, info) }
    }
}
