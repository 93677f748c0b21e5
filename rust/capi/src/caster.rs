//! Ray casting; see `include/relievo/caster.h`.

use std::sync::Arc;

use glam::Vec3;
use relievo_core::{Context, Error, Mesh, Result};
use relievo_embree::{Device, Ray, Scene};

use crate::array::{Input, Output, Plain, present, put};
use crate::context::{ContextObject, RlvContext};
use crate::descriptor::read_descriptor;
use crate::mesh::RlvMesh;
use crate::registry::{self, handle, try_read};

handle!(RlvCaster, 6, CasterObject);

constants! {
    u32:
    RLV_NO_ELEMENT = u32::MAX,
}

descriptor! {
    pub struct RlvHit {
        distance: f32,
        face: u32,
        tile: u32,
        u: f32,
        v: f32,
        position: [f32; 3],
        normal: [f32; 3],
    }
}

descriptor! {
    pub struct RlvRayArrays {
        struct_size: u32,
        reserved: u32,
        count: usize,
        origins: *const f32,
        origin_stride: usize,
        directions: *const f32,
        direction_stride: usize,
        hits: *mut RlvHit,
        hit_stride: usize,
        min_distance: f32,
        max_distance: f32,
    }
}

impl Default for RlvHit {
    fn default() -> Self {
        Self {
            distance: f32::INFINITY,
            face: RLV_NO_ELEMENT,
            tile: RLV_NO_ELEMENT,
            u: 0.0,
            v: 0.0,
            position: [0.0; 3],
            normal: [0.0; 3],
        }
    }
}

// SAFETY: eleven numbers of four bytes, without padding.
unsafe impl Plain for RlvHit {}

/// Triangles in a hierarchy. It never changes, so any number of threads may cast.
pub struct CasterObject {
    context: Arc<ContextObject>,
    scene: Scene,
    /// The face of every triangle.
    faces: Vec<u32>,
}

/// Rays of one item of parallel work, and of the memory between two writes.
const CHUNK: usize = 1024;

impl CasterObject {
    /// Builds the hierarchy over the triangles of `mesh`.
    fn of_mesh(context: Arc<ContextObject>, mesh: &Mesh) -> Result<Self> {
        let mut scene = Scene::new(&Device::new()?)?;
        let triangles = mesh.triangles();
        let mut hole = vec![false; mesh.face_count()];
        mesh.holes.iter().for_each(|face| hole[*face as usize] = true);
        let faces = mesh.face_sizes.iter().zip(hole).enumerate().filter(|(_, (_, hole))| !hole);
        let faces = faces.flat_map(|(face, (size, _))| std::iter::repeat_n(face as u32, *size as usize - 2)).collect();
        let object = scene.add_object()?;
        context.context.stats().time("caster.build", || {
            scene.set_mesh(object, 0, &mesh.points, &triangles)?;
            scene.commit().map(|_| ())
        })?;
        Ok(Self { context, scene, faces })
    }

    fn cast(&self, ray: &Ray, tracer: &relievo_embree::Tracer<'_>) -> RlvHit {
        let Some(hit) = tracer.intersect(ray) else { return RlvHit::default() };
        let position = Vec3::from(ray.origin) + hit.t * Vec3::from(ray.direction);
        RlvHit {
            distance: hit.t,
            face: self.faces.get(hit.primitive as usize).copied().unwrap_or(RLV_NO_ELEMENT),
            tile: RLV_NO_ELEMENT,
            u: hit.u,
            v: hit.v,
            position: position.to_array(),
            normal: Vec3::from(hit.normal).normalize_or_zero().to_array(),
        }
    }
}

/// The caller's rays, checked.
struct Rays {
    origins: Input<[f32; 3]>,
    directions: Input<[f32; 3]>,
    hits: Output<RlvHit>,
    min_distance: f32,
    max_distance: f32,
}

impl Rays {
    /// # Safety
    /// `arrays` is NULL or a descriptor whose arrays are as `caster.h` demands.
    unsafe fn new(arrays: *const RlvRayArrays) -> Result<Self> {
        // SAFETY: a descriptor of nothing but numbers and NULL pointers.
        let default: RlvRayArrays = unsafe { std::mem::zeroed() };
        // SAFETY: promised by the caller.
        let given = unsafe { read_descriptor(arrays, default) }?;
        let count = given.count;
        // SAFETY: the caller promises `count` elements of each.
        let rays = unsafe {
            Self {
                origins: Input::new("origins", given.origins.cast(), count, given.origin_stride)?,
                directions: Input::new("directions", given.directions.cast(), count, given.direction_stride)?,
                hits: Output::new("hits", given.hits, count, given.hit_stride)?,
                min_distance: given.min_distance,
                max_distance: if given.max_distance == 0.0 { f32::INFINITY } else { given.max_distance },
            }
        };
        if !(rays.min_distance >= 0.0 && rays.min_distance <= rays.max_distance) {
            return Err(Error::invalid(format!("rays cannot run from {} to {}", given.min_distance, given.max_distance))
                .at("min_distance")
                .advise("use 0 <= min_distance <= max_distance; a max_distance of 0 is no limit"));
        }
        for index in 0..count {
            let (origin, direction) = (Vec3::from(rays.origins.get(index)), Vec3::from(rays.directions.get(index)));
            if !origin.is_finite() || !direction.is_finite() || direction == Vec3::ZERO {
                return Err(Error::invalid("the origin or direction is not finite, or the direction is zero")
                    .at(format!("ray {index}")));
            }
        }
        Ok(rays)
    }

    fn get(&self, index: usize) -> Ray {
        let (origin, direction) = (self.origins.get(index), self.directions.get(index));
        Ray { origin, direction, near: self.min_distance, far: self.max_distance }
    }

    /// Casts all rays.
    fn cast(&self, context: &Context, cast: impl Fn(&Ray) -> RlvHit + Sync) {
        let count = self.origins.len();
        for first in (0..count).step_by(CHUNK * 64) {
            let rays: Vec<Ray> = (first..count.min(first + CHUNK * 64)).map(|index| self.get(index)).collect();
            let hits = context.map(rays.len().div_ceil(CHUNK), |chunk| {
                rays.iter().skip(chunk * CHUNK).take(CHUNK).map(&cast).collect::<Vec<_>>()
            });
            for (index, hit) in hits.into_iter().flatten().enumerate() {
                self.hits.set(first + index, hit);
            }
        }
    }
}

entry! {
    fn rlv_caster_create_mesh(context: RlvContext, mesh: RlvMesh, out: *mut RlvCaster) {
        present("out", out)?;
        let context = registry::get(context)?;
        let mesh = registry::get(mesh)?;
        let caster = CasterObject::of_mesh(context, &*try_read(&mesh.mesh, "mesh")?)?;
        let handle = registry::insert(caster)?;
        // SAFETY: checked above.
        unsafe { put(out, handle) };
        Ok(())
    }

    fn rlv_caster_retain(caster: RlvCaster) {
        registry::retain(caster)
    }

    fn rlv_caster_release(caster: RlvCaster) {
        registry::release(caster)
    }

    fn rlv_caster_cast(caster: RlvCaster, arrays: *const RlvRayArrays) {
        let object = registry::get(caster)?;
        // SAFETY: the caller's arrays are as the header demands.
        let rays = unsafe { Rays::new(arrays) }?;
        let tracer = object.scene.tracer()?;
        rays.cast(&object.context.context, |ray| object.cast(ray, &tracer));
        Ok(())
    }
}
