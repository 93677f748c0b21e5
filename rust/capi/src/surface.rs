//! Surfaces; see `include/relievo/surface.h`.

use std::sync::{Arc, Mutex, PoisonError, RwLock, TryLockError};

use relievo_core::{Error, Mesh, Result};
use relievo_surface::{BoundaryRule, Surface, SurfaceOptions};

use crate::array::{Input, present, put};
use crate::context::{ContextObject, RLV_LOG_INFO, RlvContext};
use crate::descriptor::{read_optional, write_descriptor};
use crate::mesh::RlvMesh;
use crate::registry::{self, busy, handle, try_read};

handle!(RlvSurface, 3, SurfaceObject);

constants! {
    u32:
    RLV_BOUNDARY_EDGES_AND_CORNERS = 0,
    RLV_BOUNDARY_EDGES = 1,
}

descriptor! {
    pub struct RlvSurfaceOptions {
        struct_size: u32,
        boundary: u32,
        isolation: u32,
        patch_limit: u32,
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
        reserved: u32,
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
    pub surface: Surface,
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

fn no_tile(surface: &Surface, tile: u32) -> Error {
    Error::invalid(format!("tile {tile} does not exist"))
        .at("tile")
        .advise(format!("the surface has {} tiles", surface.tile_count()))
}

/// Fails unless `tile` exists.
pub fn check_tile(surface: &Surface, tile: u32) -> Result<()> {
    if (tile as usize) < surface.tile_count() { Ok(()) } else { Err(no_tile(surface, tile)) }
}

entry! {
    fn rlv_surface_create(context: RlvContext, cage: RlvMesh, options: *const RlvSurfaceOptions, out: *mut RlvSurface) {
        present("out", out)?;
        let context = registry::get(context)?;
        let mesh_object = registry::get(cage)?;
        let default = RlvSurfaceOptions { struct_size: 0, boundary: 0, isolation: 0, patch_limit: 0 };
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        let given = unsafe { read_optional(options, default) }?;
        let boundary = match given.boundary {
            RLV_BOUNDARY_EDGES_AND_CORNERS => BoundaryRule::EdgesAndCorners,
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
        let mesh = try_read(&mesh_object.mesh, "mesh")?;
        let surface = Surface::new(&context.context, &mesh, &options)?;
        let cage = Arc::new(mesh.clone());
        drop(mesh);
        let points = cage.points.as_slice().into();
        let pinned = surface.topology().pinned_side_count();
        let log = context.clone();
        let handle = registry::insert(SurfaceObject { context, cage, options, pose: RwLock::new(Pose { surface, points }), posing: Mutex::new(()) })?;
        // SAFETY: checked above.
        unsafe { put(out, handle) };
        if pinned > 0 {
            log.log(RLV_LOG_INFO, &format!("the cage is not manifold: {pinned} sides of tiles meet at edges of more than two"));
        }
        Ok(())
    }

    fn rlv_surface_retain(surface: RlvSurface) {
        registry::retain(surface)
    }

    fn rlv_surface_release(surface: RlvSurface) {
        registry::release(surface)
    }

    fn rlv_surface_info(surface: RlvSurface, out: *mut RlvSurfaceInfo) {
        let surface = registry::get(surface)?.snapshot().surface;
        let (low, high) = surface.bounds();
        let info = RlvSurfaceInfo {
            struct_size: 0,
            non_manifold: u32::from(surface.topology().pinned_side_count() > 0),
            point_count: surface.table().cage_point_count(),
            face_count: surface.topology().face_count(),
            tile_count: surface.tile_count(),
            patch_count: surface.patch_count(),
            bytes: surface.bytes(),
            low,
            high,
            extent: surface.extent(),
            reserved: 0,
        };
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        unsafe { write_descriptor(out, info) }
    }

    fn rlv_surface_set_points(surface: RlvSurface, points: *const f32, count: usize, stride: usize) {
        let object = registry::get(surface)?;
        // SAFETY: the caller promises `count` points.
        let points = unsafe { Input::new("points", points.cast::<[f32; 3]>(), count, stride) }?;
        let points = points.to_vec("points", object.context.context.memory_limit())?;
        let _alone = match object.posing.try_lock() {
            Ok(guard) => guard,
            // The lock guards no data, so an earlier panic broke nothing.
            Err(TryLockError::Poisoned(poisoned)) => poisoned.into_inner(),
            Err(TryLockError::WouldBlock) => return Err(busy("surface")),
        };
        let surface = object.snapshot().surface.posed(&object.context.context, &points)?;
        let posed = Pose { surface, points: points.into() };
        *object.pose.write().unwrap_or_else(PoisonError::into_inner) = posed;
        Ok(())
    }

    fn rlv_surface_tile_info(surface: RlvSurface, tile: u32, out: *mut RlvTileInfo) {
        let surface = registry::get(surface)?.snapshot().surface;
        check_tile(&surface, tile)?;
        let topology = surface.topology();
        let (low, high) = surface.tile_bounds(tile);
        let info = RlvTileInfo {
            struct_size: 0,
            face: topology.face(tile),
            corner: topology.sub_corner(tile),
            is_part: u32::from(topology.is_sub(tile)),
            is_hole: u32::from(topology.is_hole(tile)),
            low,
            high,
        };
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        unsafe { write_descriptor(out, info) }
    }

    fn rlv_surface_face_tiles(surface: RlvSurface, face: u32, first: *mut u32, count: *mut u32) {
        present("first", first)?;
        present("count", count)?;
        let surface = registry::get(surface)?.snapshot().surface;
        let topology = surface.topology();
        if face as usize >= topology.face_count() {
            return Err(Error::invalid(format!("face {face} does not exist"))
                .at("face")
                .advise(format!("the cage has {} faces", topology.face_count())));
        }
        let tiles = topology.tiles_of(face);
        // SAFETY: both were checked above.
        unsafe {
            put(first, tiles.start);
            put(count, tiles.len() as u32);
        }
        Ok(())
    }
}
