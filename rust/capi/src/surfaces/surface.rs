//! Surfaces; see `include/relievo/surface.h`.

use std::sync::{Arc, Mutex, PoisonError, RwLock};

use glam::Vec3;
use relievo_core::{Error, Mesh, Result};
use relievo_surface::subdivision::{sharpened, without_boundary};
use relievo_surface::{BoundaryRule, Surface, SurfaceOptions, TriangleSurface};

use crate::border::array::{Input, present, put};
use crate::border::descriptor::{read_optional, write_descriptor};
use crate::border::making::Making;
use crate::border::registry::{self, handle, try_read};
use crate::border::work::hold_empty;
use crate::runtime::context::{ContextObject, RLV_LOG_INFO, RlvContext};
use crate::surfaces::mesh::RlvMesh;
use crate::surfaces::shape::Shape;

handle!(RlvSurface, 3, SurfaceObject);

constants! {
    u32:
    RLV_BOUNDARY_EDGES_AND_CORNERS = 0,
    RLV_BOUNDARY_EDGES = 1,
    RLV_BOUNDARY_NONE = 2,
    RLV_SURFACE_CATMULL_CLARK = 0,
    RLV_SURFACE_TRIANGLES = 1,
    RLV_SURFACE_BILINEAR = 2,
}

descriptor! {
    pub struct RlvSurfaceOptions {
        struct_size: u32,
        boundary: u32,
        isolation: u32,
        patch_limit: u32,
        kind: u32,
        reserved: u32,
    }
}

descriptor! {
    pub struct RlvSurfaceInfo {
        struct_size: u32,
        non_manifold: u32,
        point_count: usize,
        face_count: usize,
        tile_count: usize,
        patch_count: usize,
        bytes: u64,
        low: [f32; 3],
        high: [f32; 3],
        extent: f32,
        kind: u32,
    }
}

descriptor! {
    pub struct RlvTileInfo {
        struct_size: u32,
        face: u32,
        corner: u32,
        is_part: u32,
        is_hole: u32,
        low: [f32; 3],
        high: [f32; 3],
    }
}

/// A surface and the points of the cage it was posed at.
#[derive(Clone)]
pub struct Pose {
    pub shape: Shape,
    pub points: Arc<[[f32; 3]]>,
}

/// A surface whose pose can be replaced while others read the one before.
pub struct SurfaceObject {
    pub context: Arc<ContextObject>,
    /// The cage it was made from, with its attributes.
    pub cage: Arc<Mesh>,
    /// How it was made.
    pub options: SurfaceOptions,
    pose: RwLock<Pose>,
    /// Held by the call that makes the next pose.
    posing: Mutex<()>,
}

impl SurfaceObject {
    /// The present pose, which stays as it is.
    pub fn snapshot(&self) -> Pose {
        // Held only for as long as a clone or an assignment takes.
        self.pose.read().unwrap_or_else(PoisonError::into_inner).clone()
    }
}

/// What is being done while a surface is made.
const STAGE: &str = "surface";

/// Reads what a surface is made of.
///
/// # Errors
/// Fails with `Invalid` if a handle is not alive, or the boundary rule, the isolation or the kind is out of range. What
/// the work refuses, it returns: a mesh that is busy or cannot be subdivided, patches over a limit, or `Cancelled`.
///
/// # Safety
/// `options` is NULL or a descriptor that starts with its size.
pub unsafe fn create(
    context: RlvContext,
    cage: RlvMesh,
    options: *const RlvSurfaceOptions,
) -> Result<Making<RlvSurface>> {
    let context = registry::get(context)?;
    let mesh_object = registry::get(cage)?;
    let default = RlvSurfaceOptions { struct_size: 0, boundary: 0, isolation: 0, patch_limit: 0, kind: 0, reserved: 0 };
    // SAFETY: promised by the caller.
    let given = unsafe { read_optional(options, default) }?;
    let boundary = match given.boundary {
        RLV_BOUNDARY_EDGES_AND_CORNERS | RLV_BOUNDARY_NONE => BoundaryRule::EdgesAndCorners,
        RLV_BOUNDARY_EDGES => BoundaryRule::Edges,
        other => {
            return Err(Error::invalid(format!("{other} is no boundary rule"))
                .at("boundary")
                .advise("use an RLV_BOUNDARY_ value"));
        }
    };
    let mut options = SurfaceOptions { boundary, ..SurfaceOptions::default() };
    if given.isolation > 10 {
        return Err(Error::invalid(format!("{} levels of isolation are too many", given.isolation))
            .at("isolation")
            .advise("use 1 to 10, or 0 for the default"));
    }
    if given.isolation > 0 {
        options.isolation = given.isolation;
    }
    if given.patch_limit > 0 {
        options.patch_limit = given.patch_limit;
    }
    let kind = given.kind;
    if ![RLV_SURFACE_CATMULL_CLARK, RLV_SURFACE_TRIANGLES, RLV_SURFACE_BILINEAR].contains(&kind) {
        return Err(Error::invalid(format!("{kind} is no kind of surface"))
            .at("kind")
            .advise("use an RLV_SURFACE_ value"));
    }
    Ok(Making::new(context.clone(), move |progress| {
        let mut mesh = try_read(&mesh_object.mesh, "mesh")?.clone();
        progress.step(0.0, STAGE)?;
        if kind == RLV_SURFACE_BILINEAR {
            mesh = sharpened(&mesh)?;
        }
        if kind != RLV_SURFACE_TRIANGLES && given.boundary == RLV_BOUNDARY_NONE {
            mesh = without_boundary(&mesh);
        }
        let (shape, note) = shape_of(&context, &mesh, kind, &options)?;
        progress.step(0.9, STAGE)?;
        let cage = Arc::new(mesh);
        progress.step(1.0, STAGE)?;
        let pose = RwLock::new(Pose { shape, points: cage.points.as_slice().into() });
        let log = context.clone();
        let handle = registry::insert(SurfaceObject { context, cage, options, pose, posing: Mutex::new(()) })?;
        if let Some(note) = note {
            log.log(RLV_LOG_INFO, &note);
        }
        Ok(handle)
    }))
}

/// Makes what can be evaluated, of a kind that exists, and what the log says of the mesh.
fn shape_of(
    context: &ContextObject,
    mesh: &Mesh,
    kind: u32,
    options: &SurfaceOptions,
) -> Result<(Shape, Option<String>)> {
    if kind == RLV_SURFACE_TRIANGLES {
        let surface = TriangleSurface::new(&context.context, mesh)?;
        let branching = surface.topology().branching_count();
        let note =
            (branching > 0).then(|| format!("the mesh is not manifold: {branching} edges have more than two faces"));
        return Ok((Shape::Triangles(Arc::new(surface)), note));
    }
    let surface = Surface::new(&context.context, mesh, options)?;
    let pinned = surface.topology().pinned_side_count();
    let note = (pinned > 0)
        .then(|| format!("the cage is not manifold: {pinned} sides of tiles meet at edges of more than two"));
    Ok((Shape::Tiles(surface), note))
}

entry! {
    fn rlv_surface_create(context: RlvContext, cage: RlvMesh, options: *const RlvSurfaceOptions, out: *mut RlvSurface) {
        present("out", out)?;
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        let handle = unsafe { create(context, cage, options) }?.now()?;
        // SAFETY: checked above.
        unsafe { put(out, handle) };
        Ok(())
    }

    fn rlv_surface_retain(surface: RlvSurface) {
        registry::retain(surface)
    }

    fn rlv_surface_release(surface: RlvSurface) {
        registry::release(surface)
    }

    fn rlv_surface_info(surface: RlvSurface, out: *mut RlvSurfaceInfo) {
        let object = registry::get(surface)?;
        let shape = object.snapshot().shape;
        let (low, high) = shape.bounds();
        let (kind, non_manifold, patch_count, bytes) = match &shape {
            Shape::Tiles(surface) => {
                let pinned = surface.topology().pinned_side_count() > 0;
                (RLV_SURFACE_CATMULL_CLARK, pinned, surface.patch_count(), surface.bytes())
            }
            Shape::Triangles(surface) => {
                let bytes = size_of_val(surface.points()) + size_of_val(surface.normals());
                let branching = surface.topology().branching_count() > 0;
                (RLV_SURFACE_TRIANGLES, branching, shape.tile_count(), bytes as u64)
            }
        };
        let diagonal = Vec3::from(high) - Vec3::from(low);
        let info = RlvSurfaceInfo {
            struct_size: 0,
            non_manifold: u32::from(non_manifold),
            point_count: shape.point_count(),
            face_count: object.cage.face_count(),
            tile_count: shape.tile_count(),
            patch_count,
            bytes,
            low,
            high,
            extent: diagonal.length(),
            kind,
        };
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        unsafe { write_descriptor(out, info) }
    }

    fn rlv_surface_set_points(surface: RlvSurface, points: *const f32, count: usize, stride: usize) {
        let object = registry::get(surface)?;
        // SAFETY: the caller promises `count` points.
        let points = unsafe { Input::new("points", points.cast::<[f32; 3]>(), count, stride) }?;
        let points = points.to_vec("points", object.context.context.memory_limit())?;
        let _alone = hold_empty(&object.posing, "surface")?;
        let shape = object.snapshot().shape.posed(&object.context.context, &points)?;
        let posed = Pose { shape, points: points.into() };
        *object.pose.write().unwrap_or_else(PoisonError::into_inner) = posed;
        Ok(())
    }

    fn rlv_surface_tile_info(surface: RlvSurface, tile: u32, out: *mut RlvTileInfo) {
        let shape = registry::get(surface)?.snapshot().shape;
        shape.check_tile(tile)?;
        let (low, high) = shape.tile_bounds(tile);
        let (corner, is_part, is_hole) = match &shape {
            Shape::Tiles(surface) => {
                let topology = surface.topology();
                (topology.sub_corner(tile), topology.is_sub(tile), topology.is_hole(tile))
            }
            Shape::Triangles(_) => (0, false, false),
        };
        let info = RlvTileInfo {
            struct_size: 0,
            face: shape.face(tile),
            corner,
            is_part: u32::from(is_part),
            is_hole: u32::from(is_hole),
            low,
            high,
        };
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        unsafe { write_descriptor(out, info) }
    }

    fn rlv_surface_face_tiles(surface: RlvSurface, face: u32, first: *mut u32, count: *mut u32) {
        present("first", first)?;
        present("count", count)?;
        let object = registry::get(surface)?;
        let faces = object.cage.face_count();
        if face as usize >= faces {
            return Err(Error::invalid(format!("face {face} does not exist"))
                .at("face")
                .advise(format!("the mesh has {faces} faces")));
        }
        let tiles = object.snapshot().shape.tiles_of(face);
        // SAFETY: both were checked above.
        unsafe {
            put(first, tiles.start);
            put(count, tiles.len() as u32);
        }
        Ok(())
    }
}
