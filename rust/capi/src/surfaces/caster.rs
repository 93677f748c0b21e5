//! Ray casting; see `include/relievo/caster.h`.

mod chunks;
pub mod rays;

use std::sync::{Arc, RwLock};

use glam::Vec3;
use relievo_core::{Error, Mesh, Progress, Result};
use relievo_embree::{Device, Ray, Scene, Tracer};
use relievo_surface::Place;
use relievo_tiles::Tessellation;

use crate::border::array::{Output, Plain, present, put};
use crate::border::making::Making;
use crate::border::registry::{self, handle, try_read, try_write};
use crate::details::detail::RlvDetail;
use crate::details::view::{Looked, View, Wanted};
use crate::runtime::context::{ContextObject, RlvContext};
use crate::surfaces::mesh::RlvMesh;
use crate::surfaces::shape::Shape;
use crate::surfaces::tessellate::{
    Cells, RlvTessellateOptions, RlvTessellation, TessellationObject, Vertices, tessellate_bare_view,
};
use chunks::Chunks;
use rays::Rays;
pub use rays::RlvRayArrays;

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

/// Triangles in a hierarchy, which any number of threads may cast against while none updates it.
pub struct CasterObject {
    context: Arc<ContextObject>,
    geometry: RwLock<Geometry>,
    /// What it follows.
    tessellation: Option<Arc<TessellationObject>>,
}

/// Triangles that rays meet.
struct Geometry {
    scene: Scene,
    /// The face of every triangle.
    faces: Vec<u32>,
    places: Option<Places>,
    following: Option<Following>,
    /// Rays that share no bit with it hit nothing.
    mask: u32,
}

/// What a caster needs to follow a tessellation.
struct Following {
    chunks: Chunks,
    /// Number of the update that it is of.
    serial: u64,
}

/// Where the triangles of a detail are on its surface, and the detail they are of.
struct Places {
    view: Arc<View>,
    shape: Shape,
    /// u and v of every corner in the triangle's tile, which is what `faces` says.
    parameters: Vec<[f32; 2]>,
}

/// Rays of one item of parallel work.
const CHUNK: usize = 1024;
/// Items of work between two writes to the caller's array, which bounds the memory of a call.
const BATCH: usize = 64;

impl CasterObject {
    fn new(context: Arc<ContextObject>, geometry: Geometry) -> Self {
        Self { context, geometry: RwLock::new(geometry), tessellation: None }
    }

    /// Builds the hierarchy over the triangles of `mesh`.
    fn of_mesh(context: Arc<ContextObject>, mesh: &Mesh, progress: &mut dyn Progress) -> Result<Self> {
        progress.step(0.0, STAGE)?;
        let mut hole = vec![false; mesh.face_count()];
        mesh.holes.iter().for_each(|face| hole[*face as usize] = true);
        let faces = mesh.face_sizes.iter().zip(hole).enumerate().filter(|(_, (_, hole))| !hole);
        let faces = faces.flat_map(|(face, (size, _))| std::iter::repeat_n(face as u32, *size as usize - 2)).collect();
        let triangles = mesh.triangles();
        progress.step(0.1, STAGE)?;
        let scene = build(&context, &mesh.points, &triangles)?;
        progress.step(1.0, STAGE)?;
        Ok(Self::new(context, Geometry { scene, faces, places: None, following: None, mask: u32::MAX }))
    }

    /// Builds the hierarchy over the triangles of a detail.
    fn of_detail(
        context: Arc<ContextObject>,
        view: Arc<View>,
        cells: Cells,
        progress: &mut dyn Progress,
    ) -> Result<Self> {
        progress.step(0.0, STAGE)?;
        let mut first = |fraction: f32, _: &str| progress.report(0.5 * fraction, STAGE);
        let Tessellation { mesh, tiles, parameters } =
            tessellate_bare_view(&context.context, &view, cells, &mut first)?;
        let triangles = mesh.triangles();
        progress.step(0.5, STAGE)?;
        let scene = build(&context, &mesh.points, &triangles)?;
        progress.step(1.0, STAGE)?;
        let places = Some(Places { shape: view.shape(), view, parameters });
        Ok(Self::new(context, Geometry { scene, faces: tiles, places, following: None, mask: u32::MAX }))
    }

    /// Builds the hierarchies over the triangles of a tessellation, which it follows.
    fn of_tessellation(tessellation: Arc<TessellationObject>, progress: &mut dyn Progress) -> Result<Self> {
        let context = tessellation.shared_context();
        let geometry = tessellation.with_vertices(|vertices| {
            progress.step(0.0, STAGE)?;
            Geometry::following(&context, vertices, u32::MAX)
        })?;
        progress.step(1.0, STAGE)?;
        Ok(Self { context, geometry: RwLock::new(geometry), tessellation: Some(tessellation) })
    }

    /// Brings the hierarchies to the last update of what it follows.
    fn update(&self) -> Result<()> {
        let Some(tessellation) = &self.tessellation else {
            return Err(Error::invalid("the caster follows nothing")
                .at("caster")
                .advise("make it with rlv_caster_create_tessellation"));
        };
        let mut geometry = try_write(&self.geometry, "caster")?;
        tessellation.with_vertices(|vertices| geometry.update(&self.context, vertices))
    }
}

impl Geometry {
    fn following(context: &ContextObject, vertices: &Vertices<'_>, mask: u32) -> Result<Self> {
        let mut scene = Scene::new(&device(context)?)?;
        let chunks = context.context.stats().time("caster.build", || {
            let chunks = Chunks::new(&mut scene, vertices.points, vertices.corners)?;
            scene.commit().map(|_| chunks)
        })?;
        let following = Some(Following { chunks, serial: vertices.serial });
        let view = vertices.view.clone();
        let places = Places { shape: view.shape(), view, parameters: vertices.parameters.to_vec() };
        Ok(Self { scene, faces: vertices.tiles.to_vec(), places: Some(places), following, mask })
    }

    /// Moves what the last update wrote; all of it, if there were several since, and builds it anew if there are other
    /// triangles. After a failure it is to be built anew.
    fn update(&mut self, context: &ContextObject, vertices: &Vertices<'_>) -> Result<()> {
        let before = self.following.as_ref().map(|following| following.serial);
        let Some((Following { chunks, serial }, places)) = self.following.as_mut().zip(self.places.as_mut()) else {
            *self = Self::following(context, vertices, self.mask)?;
            return Ok(());
        };
        if before == Some(vertices.serial) {
            return Ok(());
        }
        if vertices.rebuilt_since(*serial) {
            *self = Self::following(context, vertices, self.mask)?;
            return Ok(());
        }
        let whole = [[0, vertices.points.len() as u32]];
        let ranges = if *serial + 1 == vertices.serial { vertices.ranges } else { &whole };
        let scene = &mut self.scene;
        let moved = context.context.stats().time("caster.update", || {
            chunks.update(scene, vertices.points, ranges)?;
            scene.commit().map(|_| ())
        });
        (*serial, places.view) = (vertices.serial, vertices.view.clone());
        if moved.is_err() {
            self.following = None;
        }
        moved
    }

    fn cast(&self, ray: &Ray, tracer: &Tracer<'_>) -> RlvHit {
        let Some(hit) = tracer.intersect(ray) else { return RlvHit::default() };
        let position = Vec3::from(ray.origin) + hit.t * Vec3::from(ray.direction);
        let triangle = match &self.following {
            Some(Following { chunks, .. }) => chunks.triangle(hit.mesh, hit.primitive),
            None => hit.primitive as usize,
        };
        let mut found = RlvHit {
            distance: hit.t,
            face: self.faces.get(triangle).copied().unwrap_or(RLV_NO_ELEMENT),
            u: hit.u,
            v: hit.v,
            position: position.to_array(),
            normal: Vec3::from(hit.normal).normalize_or_zero().to_array(),
            ..RlvHit::default()
        };
        let Some(places) = &self.places else { return found };
        let Some([a, b, c]) = places.parameters.get(3 * triangle..3 * triangle + 3) else { return found };
        let blend = |axis: usize| {
            let value = a[axis] + hit.u * (b[axis] - a[axis]) + hit.v * (c[axis] - a[axis]);
            value.clamp(0.0, 1.0)
        };
        (found.tile, found.u, found.v) = (found.face, blend(0), blend(1));
        if let Shape::Triangles(_) = places.shape {
            found.v = found.v.min(1.0 - found.u);
        }
        found.face = places.shape.face(found.tile);
        found
    }

    /// The normals of the displaced surface, in place of those of the triangles.
    fn smooth(
        &self,
        context: &ContextObject,
        hits: &mut [RlvHit],
        at: &mut Vec<Place>,
        looked: &mut Looked,
    ) -> Result<()> {
        let Some(places) = &self.places else { return Ok(()) };
        let on = |hit: &RlvHit| hit.tile != RLV_NO_ELEMENT;
        at.clear();
        at.extend(hits.iter().filter(|hit| on(hit)).map(|hit| Place::new(hit.tile, hit.u, hit.v)));
        places.view.look(&context.context, at, None, Wanted::default(), looked)?;
        for (hit, normal) in hits.iter_mut().filter(|hit| on(hit)).zip(&looked.points.normal) {
            hit.normal = *normal;
        }
        Ok(())
    }
}

/// A device of Embree whose memory the host's monitor hears of.
fn device(context: &ContextObject) -> Result<Device> {
    let memory = Arc::clone(&context.memory);
    Device::with_monitor(Some(Arc::new(move |bytes| memory.ask(bytes))))
}

fn build(context: &ContextObject, points: &[[f32; 3]], triangles: &[[u32; 3]]) -> Result<Scene> {
    let mut scene = Scene::new(&device(context)?)?;
    let object = scene.add_object()?;
    context.context.stats().time("caster.build", || {
        scene.set_mesh(object, 0, points, triangles)?;
        scene.commit().map(|_| ())
    })?;
    Ok(scene)
}

/// Rays of one batch, and what they hit.
#[derive(Default)]
struct Batch {
    /// None for a ray that hits nothing whatever there is.
    rays: Vec<Option<Ray>>,
    hits: Vec<RlvHit>,
    places: Vec<Place>,
    looked: Looked,
}

/// Rays of one batch, and whether anything is in their way.
#[derive(Default)]
struct Shadows {
    rays: Vec<Option<Ray>>,
    found: Vec<u8>,
}

/// What is being done while a caster is made.
const STAGE: &str = "caster";

/// Reads what a caster of a mesh is made of.
///
/// # Errors
/// Fails with `Invalid` if a handle is not alive. What the work refuses, it returns: a mesh that is busy, memory that
/// Embree does not get, or `Cancelled`.
pub fn of_mesh(context: RlvContext, mesh: RlvMesh) -> Result<Making<RlvCaster>> {
    let (context, mesh) = (registry::get(context)?, registry::get(mesh)?);
    Ok(Making::new(context.clone(), move |progress| {
        registry::insert(CasterObject::of_mesh(context, &*try_read(&mesh.mesh, "mesh")?, progress)?)
    }))
}

/// Reads the last commit of a detail, of which a caster is made.
///
/// # Errors
/// Fails with `Invalid` if the handle is not alive or an option is out of range. What the work refuses, it returns:
/// triangles over the memory limit, or `Cancelled`.
///
/// # Safety
/// `options` is NULL or a descriptor that starts with its size.
pub unsafe fn of_detail(detail: RlvDetail, options: *const RlvTessellateOptions) -> Result<Making<RlvCaster>> {
    let detail = registry::get(detail)?;
    // SAFETY: promised by the caller.
    let (cells, _) = unsafe { Cells::new(options) }?;
    let (context, view) = (detail.context.clone(), detail.view());
    Ok(Making::new(context.clone(), move |progress| {
        registry::insert(CasterObject::of_detail(context, view, cells, progress)?)
    }))
}

/// Reads what a caster that follows a tessellation is made of.
///
/// # Errors
/// Fails with `Invalid` if the handle is not alive. What the work refuses, it returns: a tessellation that is busy,
/// memory that Embree does not get, or `Cancelled`.
pub fn of_tessellation(tessellation: RlvTessellation) -> Result<Making<RlvCaster>> {
    let tessellation = registry::get(tessellation)?;
    Ok(Making::new(tessellation.shared_context(), move |progress| {
        registry::insert(CasterObject::of_tessellation(tessellation, progress)?)
    }))
}

entry! {
    fn rlv_caster_create_mesh(context: RlvContext, mesh: RlvMesh, out: *mut RlvCaster) {
        present("out", out)?;
        let handle = of_mesh(context, mesh)?.now()?;
        // SAFETY: checked above.
        unsafe { put(out, handle) };
        Ok(())
    }

    fn rlv_caster_create_detail(detail: RlvDetail, options: *const RlvTessellateOptions, out: *mut RlvCaster) {
        present("out", out)?;
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        let handle = unsafe { of_detail(detail, options) }?.now()?;
        // SAFETY: checked above.
        unsafe { put(out, handle) };
        Ok(())
    }

    fn rlv_caster_create_tessellation(tessellation: RlvTessellation, out: *mut RlvCaster) {
        present("out", out)?;
        let handle = of_tessellation(tessellation)?.now()?;
        // SAFETY: checked above.
        unsafe { put(out, handle) };
        Ok(())
    }

    fn rlv_caster_update(caster: RlvCaster) {
        registry::get(caster)?.update()
    }

    fn rlv_caster_set_mask(caster: RlvCaster, mask: u32) {
        try_write(&registry::get(caster)?.geometry, "caster")?.mask = mask;
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
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        let given = unsafe { RlvRayArrays::read(arrays) }?;
        // SAFETY: the caller's arrays are as the header demands.
        let (rays, out) = unsafe { (Rays::new(&given)?, Output::new("hits", given.hits, given.count, given.hit_stride)?) };
        let geometry = try_read(&object.geometry, "caster")?;
        let tracer = geometry.scene.tracer()?;
        let count = given.count;
        let context = &object.context.context;
        let mut room = context.scratch().lend::<Batch>();
        let Batch { rays: batch, hits, places, looked } = &mut *room;
        for first in (0..count).step_by(CHUNK * BATCH) {
            batch.clear();
            batch.extend((first..count.min(first + CHUNK * BATCH)).map(|index| rays.get(index, geometry.mask)));
            hits.clear();
            hits.resize(batch.len(), RlvHit::default());
            context.for_each_part((batch.as_slice(), hits.as_mut_slice()), CHUNK, |_, (rays, hits)| {
                hits.iter_mut().zip(rays).for_each(|(hit, ray)| {
                    *hit = ray.as_ref().map_or_else(RlvHit::default, |ray| geometry.cast(ray, &tracer));
                });
                Ok(())
            })?;
            geometry.smooth(&object.context, hits, places, looked)?;
            for (index, hit) in hits.iter().enumerate() {
                out.set(first + index, *hit);
            }
        }
        Ok(())
    }

    fn rlv_caster_occluded(caster: RlvCaster, arrays: *const RlvRayArrays, occluded: *mut u8, stride: usize) {
        let object = registry::get(caster)?;
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        let given = unsafe { RlvRayArrays::read(arrays) }?;
        // SAFETY: the caller's arrays are as the header demands.
        let (rays, out) = unsafe { (Rays::new(&given)?, Output::new("occluded", occluded, given.count, stride)?) };
        let geometry = try_read(&object.geometry, "caster")?;
        let tracer = geometry.scene.tracer()?;
        let context = &object.context.context;
        let mut room = context.scratch().lend::<Shadows>();
        let Shadows { rays: batch, found } = &mut *room;
        for first in (0..given.count).step_by(CHUNK * BATCH) {
            batch.clear();
            batch.extend((first..given.count.min(first + CHUNK * BATCH)).map(|index| rays.get(index, geometry.mask)));
            found.clear();
            found.resize(batch.len(), 0);
            context.for_each_part((batch.as_slice(), found.as_mut_slice()), CHUNK, |_, (rays, found)| {
                for (found, ray) in found.iter_mut().zip(rays) {
                    *found = u8::from(ray.as_ref().is_some_and(|ray| tracer.occluded(ray)));
                }
                Ok(())
            })?;
            found.iter().enumerate().for_each(|(index, found)| out.set(first + index, *found));
        }
        Ok(())
    }
}
