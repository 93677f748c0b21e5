//! Colliders; see `include/relievo/collider.h`.

use std::sync::{Arc, OnceLock, RwLock};

use glam::{DAffine3, DVec3};
use relievo_core::{Mesh, Progress, Result};
use relievo_detail::Collider;
use relievo_detail::tool::{ToolSettings, pressed};

use crate::border::array::{Input, present, put};
use crate::border::descriptor::write_descriptor;
use crate::border::making::Making;
use crate::border::registry::{self, handle, try_read, try_write};
use crate::details::detail::{RlvDetail, transform};
use crate::runtime::context::{ContextObject, RlvContext};
use crate::runtime::parameter::{RlvParameter, Table, settings, write_table};
use crate::surfaces::mesh::RlvMesh;
use crate::surfaces::surface::RlvSurface;
use crate::surfaces::tessellate::{Cells, RlvTessellateOptions, bare_mesh, tessellate_bare_view};

handle!(RlvCollider, 5, ColliderObject);

settings!(RlvToolSettings, ToolSettings);

descriptor! {
    pub struct RlvColliderInfo {
        struct_size: u32,
        is_closed: u32,
        point_count: usize,
        triangle_count: usize,
        matrix: [f64; 12],
        open_edge_count: usize,
    }
}

/// A collider and the context it belongs to.
pub struct ColliderObject {
    pub context: Arc<ContextObject>,
    pub collider: RwLock<Collider>,
}

/// Registers a collider of the triangles of `mesh`, placed by `matrix`.
fn register(
    context: Arc<ContextObject>,
    mesh: &Mesh,
    matrix: DAffine3,
    progress: &mut dyn Progress,
) -> Result<RlvCollider> {
    progress.step(0.5, STAGE)?;
    let collider = Collider::of_mesh(&context.context, mesh, matrix)?;
    progress.step(1.0, STAGE)?;
    registry::insert(ColliderObject { context, collider: RwLock::new(collider) })
}

/// What is being done while a collider is made.
const STAGE: &str = "collider";

/// Reports the triangles of a collider as the first half of the work.
fn first_half(progress: &mut dyn Progress) -> impl Progress + '_ {
    |fraction: f32, _: &str| progress.report(0.5 * fraction, STAGE)
}

/// Reads what a collider of a mesh is made of.
///
/// # Errors
/// Fails with `Invalid` if a handle is not alive. What the work refuses, it returns: a mesh that is busy or cannot be
/// collided with, or `Cancelled`.
///
/// # Safety
/// `matrix` is NULL or twelve doubles.
pub unsafe fn of_mesh(context: RlvContext, mesh: RlvMesh, matrix: *const f64) -> Result<Making<RlvCollider>> {
    let context = registry::get(context)?;
    let mesh = registry::get(mesh)?;
    // SAFETY: promised by the caller.
    let matrix = unsafe { transform(matrix) }?;
    Ok(Making::new(context.clone(), move |progress| {
        let mesh = try_read(&mesh.mesh, "mesh")?;
        progress.step(0.0, STAGE)?;
        register(context, &mesh, matrix, progress)
    }))
}

/// Reads what a collider of a limit surface is made of.
///
/// # Errors
/// Fails with `Invalid` if the handle is not alive or an option is out of range. What the work refuses, it returns:
/// triangles over the memory limit, or `Cancelled`.
///
/// # Safety
/// `options` is NULL or a descriptor that starts with its size, `matrix` NULL or twelve doubles.
pub unsafe fn of_surface(
    surface: RlvSurface,
    options: *const RlvTessellateOptions,
    matrix: *const f64,
) -> Result<Making<RlvCollider>> {
    let surface = registry::get(surface)?;
    // SAFETY: promised by the caller.
    let ((cells, _), matrix) = unsafe { (Cells::new(options)?, transform(matrix)?) };
    Ok(Making::new(surface.context.clone(), move |progress| {
        let context = surface.context.clone();
        progress.step(0.0, STAGE)?;
        let mesh = bare_mesh(&context.context, &surface, cells, &mut first_half(progress))?;
        register(context, &mesh, matrix, progress)
    }))
}

/// Reads the last commit of a detail, of which a collider is made.
///
/// # Errors
/// Fails with `Invalid` if the handle is not alive or an option is out of range. What the work refuses, it returns:
/// triangles over the memory limit, or `Cancelled`.
///
/// # Safety
/// `options` is NULL or a descriptor that starts with its size.
pub unsafe fn of_detail(detail: RlvDetail, options: *const RlvTessellateOptions) -> Result<Making<RlvCollider>> {
    let detail = registry::get(detail)?;
    // SAFETY: promised by the caller.
    let (cells, _) = unsafe { Cells::new(options) }?;
    let (context, view) = (detail.context.clone(), detail.view());
    Ok(Making::new(context.clone(), move |progress| {
        progress.step(0.0, STAGE)?;
        let made = tessellate_bare_view(&context.context, &view, cells, &mut first_half(progress))?;
        register(context, &made.mesh, view.transform, progress)
    }))
}

entry! {
    fn rlv_collider_create_mesh(context: RlvContext, mesh: RlvMesh, matrix: *const f64, out: *mut RlvCollider) {
        present("out", out)?;
        // SAFETY: the caller promises NULL or twelve doubles.
        let handle = unsafe { of_mesh(context, mesh, matrix) }?.now()?;
        // SAFETY: checked above.
        unsafe { put(out, handle) };
        Ok(())
    }

    fn rlv_collider_create_surface(surface: RlvSurface, options: *const RlvTessellateOptions, matrix: *const f64, out: *mut RlvCollider) {
        present("out", out)?;
        // SAFETY: the caller gives NULL or a descriptor that starts with its size, and NULL or twelve doubles.
        let handle = unsafe { of_surface(surface, options, matrix) }?.now()?;
        // SAFETY: checked above.
        unsafe { put(out, handle) };
        Ok(())
    }

    fn rlv_collider_create_detail(detail: RlvDetail, options: *const RlvTessellateOptions, out: *mut RlvCollider) {
        present("out", out)?;
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        let handle = unsafe { of_detail(detail, options) }?.now()?;
        // SAFETY: checked above.
        unsafe { put(out, handle) };
        Ok(())
    }

    fn rlv_collider_retain(collider: RlvCollider) {
        registry::retain(collider)
    }

    fn rlv_collider_release(collider: RlvCollider) {
        registry::release(collider)
    }

    fn rlv_collider_info(collider: RlvCollider, out: *mut RlvColliderInfo) {
        let object = registry::get(collider)?;
        let collider = try_read(&object.collider, "collider")?;
        let info = RlvColliderInfo {
            struct_size: 0,
            is_closed: u32::from(collider.is_closed()),
            point_count: collider.points().len(),
            triangle_count: collider.triangles().len(),
            matrix: collider.transform().to_cols_array(),
            open_edge_count: collider.open_edges(),
        };
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        unsafe { write_descriptor(out, info) }
    }

    fn rlv_collider_set_transform(collider: RlvCollider, matrix: *const f64) {
        let object = registry::get(collider)?;
        // SAFETY: the caller promises NULL or twelve doubles.
        let matrix = unsafe { transform(matrix) }?;
        try_write(&object.collider, "collider")?.set_transform(matrix)
    }

    fn rlv_collider_set_points(collider: RlvCollider, points: *const f32, count: usize, stride: usize) {
        let object = registry::get(collider)?;
        // SAFETY: the caller promises `count` points.
        let points = unsafe { Input::new("points", points.cast::<[f32; 3]>(), count, stride) }?;
        let context = &object.context.context;
        let points = points.to_vec("points", context.memory_limit())?;
        try_write(&object.collider, "collider")?.set_points(context, &points)
    }

    fn rlv_collider_press_params(params: *mut *const RlvParameter, count: *mut usize) {
        static TABLE: OnceLock<Table> = OnceLock::new();
        // SAFETY: the caller gives pointers to which a value may be written, or NULL.
        unsafe { write_table(&TABLE, ToolSettings::PARAMETERS, params, count) }
    }

    fn rlv_collider_press(
        collider: RlvCollider,
        place: *const f64,
        normal: *const f64,
        force: f64,
        settings: *const RlvToolSettings,
    ) {
        let object = registry::get(collider)?;
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        let settings = unsafe { RlvToolSettings::read(settings) }?;
        let vector = |name, pointer| -> Result<DVec3> {
            // SAFETY: the caller promises three doubles.
            let values = unsafe { Input::new(name, pointer, 3, 0) }?;
            Ok(DVec3::new(values.get(0), values.get(1), values.get(2)))
        };
        let (place, normal) = (vector("place", place)?, vector("normal", normal)?);
        let mut collider = try_write(&object.collider, "collider")?;
        let pose = pressed(&collider, place, normal, force, &settings)?;
        collider.set_transform(pose)
    }
}
