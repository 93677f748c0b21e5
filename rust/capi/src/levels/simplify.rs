//! Simplification; see `include/relievo/simplify.h`.

use std::ffi::{c_char, c_void};
use std::sync::Arc;

use relievo_core::{Error, Progress, Result};
use relievo_lod::{AttributeOptions, SimplifyOptions, simplify_mesh};

use crate::border::array::{Input, Plain, present, put, put_optional, text};
use crate::border::descriptor::read_optional;
use crate::border::registry::{self, try_read};
use crate::runtime::context::{ContextObject, HostProgress, RlvProgress};
use crate::surfaces::mesh::{self, MeshObject, RlvMesh};

descriptor! {
    pub struct RlvSimplifyWeight {
        name: *const c_char,
        weight: f32,
        is_left_out: u32,
    }
}

descriptor! {
    pub struct RlvSimplifyOptions {
        struct_size: u32,
        error: f32,
        triangles: usize,
        weights: *const RlvSimplifyWeight,
        weight_count: usize,
        weight_stride: usize,
        locked: *const u32,
        locked_count: usize,
        locked_stride: usize,
        factors: *const f32,
        factor_count: usize,
        factor_stride: usize,
        bound: f32,
        is_border_locked: u32,
    }
}

impl Default for RlvSimplifyWeight {
    fn default() -> Self {
        Self { name: std::ptr::null(), weight: 0.0, is_left_out: 0 }
    }
}

// SAFETY: a pointer, a float and an integer without padding.
unsafe impl Plain for RlvSimplifyWeight {}

/// What is to be simplified, and how.
pub struct Simplification {
    object: Arc<MeshObject>,
    options: SimplifyOptions,
    attributes: AttributeOptions,
}

impl Simplification {
    /// Copies what was asked for.
    ///
    /// # Errors
    /// Fails with `Invalid` if the handle is not alive, or an option or an array cannot be used, and with `Memory` if
    /// an array exceeds the context's memory limit.
    ///
    /// # Safety
    /// `options` is NULL or a descriptor whose arrays are as the header demands.
    pub unsafe fn read(mesh: RlvMesh, options: *const RlvSimplifyOptions) -> Result<Self> {
        let object = registry::get(mesh)?;
        // SAFETY: promised by the caller.
        let (options, attributes) = unsafe { read(options, object.context.context.memory_limit()) }?;
        Ok(Self { object, options, attributes })
    }

    pub fn context(&self) -> &Arc<ContextObject> {
        &self.object.context
    }

    /// Makes the mesh. Returns it, and its largest distance if there is a bound, else its largest estimated deviation.
    ///
    /// # Errors
    /// Fails with `Busy` if the mesh is being changed, with `Invalid` if no triangle is left or what was asked for
    /// cannot be, with `Memory` if the host refuses the bytes of the mesh, and with `Cancelled` if `progress` asks to
    /// stop.
    pub fn run(&self, progress: &mut dyn Progress) -> Result<(RlvMesh, f32)> {
        let mesh = try_read(&self.object.mesh, "mesh")?;
        let made = simplify_mesh(&self.context().context, &mesh, &self.options, &self.attributes, progress)?;
        if made.mesh.face_count() == 0 {
            return Err(Error::invalid("no triangle is left of it")
                .at("mesh")
                .advise("give it triangles with area; rlv_repair_check lists those without"));
        }
        Ok((mesh::register(self.context().clone(), made.mesh)?, made.error))
    }
}

/// What attributes count for.
///
/// # Errors
/// Fails with `Invalid` if a name is no text, or `is_left_out` is neither 0 nor 1.
///
/// # Safety
/// Names are NULL or NUL-terminated texts.
pub unsafe fn attributes_of(weights: &Input<RlvSimplifyWeight>) -> Result<AttributeOptions> {
    let mut attributes = AttributeOptions::default();
    for RlvSimplifyWeight { name, weight, is_left_out } in weights.iter() {
        // SAFETY: promised by the caller.
        let name = unsafe { text("weights", name) }?.to_owned();
        match is_left_out {
            0 => attributes.weights.push((name, weight)),
            1 => attributes.left_out.push(name),
            _ => return Err(Error::invalid(format!("is_left_out of `{name}` is {is_left_out}")).at("weights")),
        }
    }
    Ok(attributes)
}

/// What is asked for.
///
/// # Safety
/// `options` is NULL or a descriptor whose arrays are as the header demands.
unsafe fn read(options: *const RlvSimplifyOptions, limit: u64) -> Result<(SimplifyOptions, AttributeOptions)> {
    // SAFETY: a descriptor of nothing but numbers and NULL pointers.
    let default = RlvSimplifyOptions { error: -1.0, bound: -1.0, ..unsafe { std::mem::zeroed() } };
    // SAFETY: promised by the caller.
    let given = unsafe { read_optional(options, default) }?;
    // SAFETY: promised by the caller.
    let (weights, locked, factors) = unsafe {
        (
            Input::new("weights", given.weights, given.weight_count, given.weight_stride)?,
            Input::new("locked", given.locked, given.locked_count, given.locked_stride)?,
            Input::new("factors", given.factors, given.factor_count, given.factor_stride)?,
        )
    };
    // SAFETY: promised by the caller.
    let attributes = unsafe { attributes_of(&weights) }?;
    if given.is_border_locked > 1 {
        let number = given.is_border_locked;
        return Err(Error::invalid(format!("is_border_locked is {number}")).at("options").advise("use 0 or 1"));
    }
    let length = |length: f32| if length < 0.0 { f32::INFINITY } else { length };
    let options = SimplifyOptions {
        target_triangles: given.triangles,
        max_error: length(given.error),
        bound: length(given.bound),
        is_border_locked: given.is_border_locked == 1,
        locked: locked.to_vec("locked", limit)?,
        vertex_weights: factors.to_vec("factors", limit)?,
    };
    Ok((options, attributes))
}

entry! {
    fn rlv_simplify_mesh(
        mesh: RlvMesh,
        options: *const RlvSimplifyOptions,
        progress: RlvProgress,
        user: *mut c_void,
        error: *mut f32,
        out: *mut RlvMesh,
    ) {
        present("out", out)?;
        // SAFETY: the caller gives NULL or a descriptor that starts with its size, with arrays of their counts.
        let simplification = unsafe { Simplification::read(mesh, options) }?;
        let (made, deviation) = simplification.run(&mut HostProgress { callback: progress, user })?;
        // SAFETY: checked above.
        unsafe { put(out, made) };
        // SAFETY: the caller promises a place, or NULL.
        unsafe { put_optional(error, deviation) };
        Ok(())
    }
}
