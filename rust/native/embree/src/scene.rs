//! A scene of two levels: objects made of triangle meshes, each placed by an affine transform.
//!
//! Meshes have hierarchies of their own, so that an edit rebuilds only the meshes it touched, and a moved object
//! rebuilds none. Positions and distances are in the units given; nothing here scales.

use std::collections::BTreeMap;

use relievo_core::{Error, Result};

use crate::abi::{self, INVALID_ID, RTCHit, RTCHit8, RTCRay, RTCRay8, RTCRayHit, RTCRayHit8, Valid8};
use crate::device::{Device, GeometryOwner, SceneOwner};

/// A ray. `direction` need not have unit length; distances are multiples of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Start.
    pub origin: [f32; 3],
    /// Direction.
    pub direction: [f32; 3],
    /// Smallest distance of a hit.
    pub near: f32,
    /// Largest distance of a hit.
    pub far: f32,
}

impl Ray {
    /// The largest coordinate of an origin or direction. Embree's builds with assertions abort at rays of about 1e18,
    /// also after the transform of an object; what is larger than this hits nothing.
    pub const LARGEST: f32 = 1e12;

    /// A ray without end.
    pub fn new(origin: [f32; 3], direction: [f32; 3]) -> Self {
        Self { origin, direction, near: 0.0, far: f32::INFINITY }
    }

    #[inline]
    fn is_traceable(&self, reach: f32) -> bool {
        // The comparison also refuses what is not a number.
        self.origin.iter().chain(&self.direction).all(|value| value.abs() <= reach)
            && self.near >= 0.0
            && self.near <= self.far
    }
}

/// Where a ray met a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Distance, in multiples of the ray's direction.
    pub t: f32,
    /// The object.
    pub object: ObjectId,
    /// The mesh of the object.
    pub mesh: u32,
    /// The triangle of the mesh.
    pub primitive: u32,
    /// Barycentric weight of the triangle's second corner.
    pub u: f32,
    /// Barycentric weight of the triangle's third corner.
    pub v: f32,
    /// Normal of the triangle in object space, not of unit length, to the side from which it is counter-clockwise.
    pub normal: [f32; 3],
}

/// An object of a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ObjectId(pub u32);

/// A scene under construction. [`Scene::commit`] makes it traceable.
pub struct Scene {
    device: Device,
    top: SceneOwner,
    objects: BTreeMap<u32, Object>,
    next: u32,
    dirty: bool,
}

struct Object {
    scene: SceneOwner,
    instance: GeometryOwner,
    meshes: BTreeMap<u32, Mesh>,
    dirty: bool,
    /// How much larger coordinates can become from scene to object space.
    stretch: f32,
}

struct Mesh {
    geometry: GeometryOwner,
    points: usize,
}

/// The largest coordinate of a ray in the space of an object, and how much a transform may make coordinates larger.
const LARGEST_INSIDE: f32 = 1e17;
const LARGEST_STRETCH: f32 = 1e12;

/// Triangles up to which a mesh gets the better hierarchy, which takes longer to build and less to trace: a large one
/// would be waited for after every edit.
const SMALL_MESH: usize = 1024;

const IDENTITY: [f32; 12] = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0];

impl Scene {
    /// An empty scene.
    ///
    /// # Errors
    /// Fails with `Memory` if Embree makes no scene, and with `Internal` if it reports another error.
    pub fn new(device: &Device) -> Result<Self> {
        let top = device.scene(abi::RTC_SCENE_FLAG_ROBUST, abi::RTC_BUILD_QUALITY_LOW)?;
        Ok(Self { device: device.clone(), top, objects: BTreeMap::new(), next: 0, dirty: true })
    }

    /// Adds an object without meshes at the identity.
    ///
    /// # Errors
    /// Fails with `Memory` if Embree makes no scene or instance, and with `Internal` if it reports another error.
    pub fn add_object(&mut self) -> Result<ObjectId> {
        let embree = &self.device.table().embree;
        let id = self.next;
        let scene =
            self.device.scene(abi::RTC_SCENE_FLAG_ROBUST | abi::RTC_SCENE_FLAG_DYNAMIC, abi::RTC_BUILD_QUALITY_LOW)?;
        let instance = self.device.geometry(abi::RTC_GEOMETRY_TYPE_INSTANCE)?;
        // SAFETY: all handles are alive; Embree keeps references of its own.
        unsafe {
            embree.rtcSetGeometryInstancedScene(instance.handle, scene.handle);
            embree.rtcAttachGeometryByID(self.top.handle, instance.handle, id);
        }
        self.device.check()?;
        self.objects.insert(id, Object { scene, instance, meshes: BTreeMap::new(), dirty: true, stretch: 1.0 });
        self.next += 1;
        self.dirty = true;
        self.set_transform(ObjectId(id), &IDENTITY)?;
        Ok(ObjectId(id))
    }

    /// Removes an object.
    ///
    /// # Errors
    /// Fails with `Invalid` if there is no such object.
    pub fn remove_object(&mut self, object: ObjectId) -> Result<()> {
        self.object(object)?;
        // SAFETY: the object is attached under its id.
        unsafe { self.device.table().embree.rtcDetachGeometry(self.top.handle, object.0) };
        self.objects.remove(&object.0);
        self.dirty = true;
        self.device.check()
    }

    /// Places an object: the columns of a 3×4 matrix from object to scene space.
    ///
    /// # Errors
    /// The matrix is singular or nearly so, not finite, or has numbers beyond 1e12.
    pub fn set_transform(&mut self, object: ObjectId, columns: &[f32; 12]) -> Result<()> {
        let stretch = stretch(columns);
        // The comparison also refuses what is not a number.
        if !(columns.iter().all(|value| value.abs() <= Ray::LARGEST) && stretch <= LARGEST_STRETCH) {
            return Err(Error::invalid("the transform of an object is singular, not finite or beyond 1e12"));
        }
        self.object(object)?;
        if let Some(object) = self.objects.get_mut(&object.0) {
            object.stretch = stretch;
        }
        let instance = self.object(object)?.instance.handle;
        let embree = &self.device.table().embree;
        // SAFETY: the instance is alive and twelve floats are read.
        unsafe {
            embree.rtcSetGeometryTransform(instance, 0, abi::RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, columns.as_ptr().cast());
            embree.rtcCommitGeometry(instance);
        }
        self.dirty = true;
        self.device.check()
    }

    /// Gives mesh `mesh` of an object its points and triangles, in place of what it had.
    ///
    /// # Errors
    /// A triangle names a point that does not exist, or memory runs out.
    pub fn set_mesh(&mut self, object: ObjectId, mesh: u32, points: &[[f32; 3]], triangles: &[[u32; 3]]) -> Result<()> {
        let quality =
            if triangles.len() <= SMALL_MESH { abi::RTC_BUILD_QUALITY_MEDIUM } else { abi::RTC_BUILD_QUALITY_LOW };
        self.add_mesh(object, mesh, points, triangles, quality)
    }

    /// Does what [`Scene::set_mesh`] does for a mesh whose points move a little at a time: after [`Scene::move_points`] a
    /// commit fits the boxes of its hierarchy, in a fraction of the time that building it takes. Where points move far
    /// between one another, rays take longer than in a mesh that is set anew.
    ///
    /// # Errors
    /// Those of [`Scene::set_mesh`].
    pub fn set_moving_mesh(
        &mut self,
        object: ObjectId,
        mesh: u32,
        points: &[[f32; 3]],
        triangles: &[[u32; 3]],
    ) -> Result<()> {
        self.add_mesh(object, mesh, points, triangles, abi::RTC_BUILD_QUALITY_REFIT)
    }

    fn add_mesh(
        &mut self,
        object: ObjectId,
        mesh: u32,
        points: &[[f32; 3]],
        triangles: &[[u32; 3]],
        quality: abi::RTCBuildQuality,
    ) -> Result<()> {
        self.remove_mesh(object, mesh)?;
        if mesh == INVALID_ID || u32::try_from(triangles.len()).is_err() {
            return Err(Error::invalid("a mesh has too large a number or too many triangles"));
        }
        check_points(points)?;
        if let Some(at) = triangles.iter().position(|corners| corners.iter().any(|at| *at as usize >= points.len())) {
            return Err(Error::invalid(format!("it names a point that does not exist, of {}", points.len()))
                .at(format!("triangle {at}")));
        }
        if triangles.is_empty() {
            return Ok(());
        }
        let embree = &self.device.table().embree;
        let geometry = self.device.geometry(abi::RTC_GEOMETRY_TYPE_TRIANGLE)?;
        geometry.fill(abi::RTC_BUFFER_TYPE_VERTEX, abi::RTC_FORMAT_FLOAT3, &padded(points))?;
        geometry.fill(abi::RTC_BUFFER_TYPE_INDEX, abi::RTC_FORMAT_UINT3, triangles)?;
        let scene = self.object(object)?.scene.handle;
        // SAFETY: all handles are alive and the number is free.
        unsafe {
            embree.rtcSetGeometryBuildQuality(geometry.handle, quality);
            embree.rtcCommitGeometry(geometry.handle);
            embree.rtcAttachGeometryByID(scene, geometry.handle, mesh);
        }
        self.device.check()?;
        let points = points.len();
        self.touched(object, |object| object.meshes.insert(mesh, Mesh { geometry, points }));
        Ok(())
    }

    /// Moves the points of a mesh; its triangles stay.
    ///
    /// # Errors
    /// Fails with `Invalid` if there is no such object or mesh, there are not as many points as before, or a coordinate
    /// is not finite or beyond 1e12.
    pub fn move_points(&mut self, object: ObjectId, mesh: u32, points: &[[f32; 3]]) -> Result<()> {
        let embree = &self.device.table().embree;
        let found = self.object(object)?.meshes.get(&mesh);
        let found = found.ok_or_else(|| Error::invalid(format!("there is no mesh {mesh}")))?;
        if found.points != points.len() {
            return Err(Error::invalid(format!("{} points instead of {}", points.len(), found.points))
                .advise("set the mesh anew when its topology changes"));
        }
        let geometry = found.geometry.handle;
        check_points(points)?;
        // SAFETY: the vertex buffer has room for `points` items of four floats and nobody traces while the scene is
        // borrowed mutably.
        unsafe {
            let data = embree.rtcGetGeometryBufferData(geometry, abi::RTC_BUFFER_TYPE_VERTEX, 0).cast::<[f32; 4]>();
            if data.is_null() {
                return Err(Error::internal("Embree lost a vertex buffer"));
            }
            for (index, [x, y, z]) in points.iter().enumerate() {
                data.add(index).write([*x, *y, *z, 0.0]);
            }
            embree.rtcUpdateGeometryBuffer(geometry, abi::RTC_BUFFER_TYPE_VERTEX, 0);
            embree.rtcCommitGeometry(geometry);
        }
        self.touched(object, |_| ());
        self.device.check()
    }

    /// Removes a mesh of an object, if there is one.
    ///
    /// # Errors
    /// Fails with `Invalid` if there is no such object.
    pub fn remove_mesh(&mut self, object: ObjectId, mesh: u32) -> Result<()> {
        let found = self.object(object)?;
        if found.meshes.contains_key(&mesh) {
            // SAFETY: the mesh is attached under its number.
            unsafe { self.device.table().embree.rtcDetachGeometry(found.scene.handle, mesh) };
            self.touched(object, |object| object.meshes.remove(&mesh));
        }
        self.device.check()
    }

    /// Builds or updates the hierarchies of what changed. While the result lives, the scene cannot change.
    ///
    /// # Errors
    /// Fails with `Memory` if Embree has no memory for the hierarchies, and with `Internal` if it reports another
    /// error.
    pub fn commit(&mut self) -> Result<Tracer<'_>> {
        let embree = &self.device.table().embree;
        for object in self.objects.values_mut().filter(|object| object.dirty) {
            // SAFETY: the scene and its geometries are alive; the borrow keeps others from using them.
            unsafe {
                self.device.commit(object.scene.handle);
                embree.rtcCommitGeometry(object.instance.handle);
            }
            object.dirty = false;
        }
        if self.dirty {
            // SAFETY: as above.
            unsafe { self.device.commit(self.top.handle) };
            self.dirty = false;
        }
        self.device.check()?;
        let stretch = self.objects.values().map(|object| object.stretch).fold(1.0, f32::max);
        Ok(Tracer { scene: self, reach: Ray::LARGEST.min(LARGEST_INSIDE / stretch) })
    }

    /// The scene for tracing as it was committed, from any number of threads.
    ///
    /// # Errors
    /// Fails with `Internal` if it changed since the last [`Scene::commit`].
    pub fn tracer(&self) -> Result<Tracer<'_>> {
        if self.dirty || self.objects.values().any(|object| object.dirty) {
            return Err(Error::internal("a scene is traced that is not committed"));
        }
        let stretch = self.objects.values().map(|object| object.stretch).fold(1.0, f32::max);
        Ok(Tracer { scene: self, reach: Ray::LARGEST.min(LARGEST_INSIDE / stretch) })
    }

    fn object(&self, object: ObjectId) -> Result<&Object> {
        self.objects.get(&object.0).ok_or_else(|| Error::invalid(format!("there is no object {}", object.0)))
    }

    /// Changes an object, and has it and the scene built again at the next commit.
    fn touched<R>(&mut self, object: ObjectId, change: impl FnOnce(&mut Object) -> R) {
        self.dirty = true;
        if let Some(object) = self.objects.get_mut(&object.0) {
            object.dirty = true;
            change(object);
        }
    }
}

/// The largest sum of a row of the inverse of a matrix's linear part, or the like with its translation: what it makes
/// of coordinates of size 1.
fn stretch(columns: &[f32; 12]) -> f32 {
    let [x, y, z] = [0, 3, 6].map(|at| [0, 1, 2].map(|axis| f64::from(columns[at + axis])));
    let cross =
        |a: [f64; 3], b: [f64; 3]| [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
    let rows = [cross(y, z), cross(z, x), cross(x, y)];
    let determinant = x[0] * rows[0][0] + x[1] * rows[0][1] + x[2] * rows[0][2];
    let sum = |row: [f64; 3]| (row[0].abs() + row[1].abs() + row[2].abs()) / determinant.abs();
    let largest = rows.map(sum).into_iter().fold(0.0, |a: f64, b| if a >= b { a } else { b });
    (2.0 * largest) as f32
}

/// Fails unless Embree can use the points.
pub(crate) fn check_points(points: &[[f32; 3]]) -> Result<()> {
    match points.iter().position(|point| !point.iter().all(|value| value.abs() <= Ray::LARGEST)) {
        None => Ok(()),
        Some(at) => Err(Error::invalid("a coordinate is not finite or beyond 1e12").at(format!("point {at}"))),
    }
}

/// Points in the 16-byte steps in which Embree reads them.
pub(crate) fn padded(points: &[[f32; 3]]) -> Vec<[f32; 4]> {
    points.iter().map(|[x, y, z]| [*x, *y, *z, 0.0]).collect()
}

/// A scene that can be traced, from any number of threads.
#[derive(Clone, Copy)]
pub struct Tracer<'a> {
    scene: &'a Scene,
    /// The largest coordinate of rays that stay small enough for Embree in the space of every object.
    reach: f32,
}

impl Tracer<'_> {
    /// The closest hit of `ray`.
    #[inline]
    pub fn intersect(&self, ray: &Ray) -> Option<Hit> {
        if !ray.is_traceable(self.reach) {
            return None;
        }
        let hit = RTCHit {
            Ng_x: 0.0,
            Ng_y: 0.0,
            Ng_z: 0.0,
            u: 0.0,
            v: 0.0,
            primID: INVALID_ID,
            geomID: INVALID_ID,
            instID: [INVALID_ID],
            instPrimID: [INVALID_ID],
        };
        let mut record = RTCRayHit { ray: record(ray), hit };
        // SAFETY: the scene is committed and stays as it is while it is borrowed.
        unsafe { self.scene.device.table().trace.intersect(self.scene.top.handle, &mut record) };
        let RTCRayHit { ray, hit } = record;
        (hit.geomID != INVALID_ID).then_some(Hit {
            t: ray.tfar,
            object: ObjectId(hit.instID[0]),
            mesh: hit.geomID,
            primitive: hit.primID,
            u: hit.u,
            v: hit.v,
            normal: [hit.Ng_x, hit.Ng_y, hit.Ng_z],
        })
    }

    /// Whether anything is hit by `ray`.
    #[inline]
    pub fn occluded(&self, ray: &Ray) -> bool {
        if !ray.is_traceable(self.reach) {
            return false;
        }
        let mut record = record(ray);
        // SAFETY: as for `intersect`.
        unsafe { self.scene.device.table().trace.occluded(self.scene.top.handle, &mut record) };
        record.tfar == f32::NEG_INFINITY
    }

    /// The closest hits of up to eight rays. It is faster than one at a time where they go much the same way.
    #[inline]
    pub fn intersect8(&self, rays: &[Option<Ray>; 8]) -> [Option<Hit>; 8] {
        let (valid, ray) = record8(rays, self.reach);
        let hit = RTCHit8 {
            Ng_x: [0.0; 8],
            Ng_y: [0.0; 8],
            Ng_z: [0.0; 8],
            u: [0.0; 8],
            v: [0.0; 8],
            primID: [INVALID_ID; 8],
            geomID: [INVALID_ID; 8],
            instID: [[INVALID_ID; 8]],
            instPrimID: [[INVALID_ID; 8]],
        };
        let mut record = RTCRayHit8 { ray, hit };
        // SAFETY: as for `intersect`.
        unsafe { self.scene.device.table().trace.intersect8(&valid, self.scene.top.handle, &mut record) };
        let RTCRayHit8 { ray, hit } = record;
        std::array::from_fn(|at| {
            (valid.0[at] != 0 && hit.geomID[at] != INVALID_ID).then(|| Hit {
                t: ray.tfar[at],
                object: ObjectId(hit.instID[0][at]),
                mesh: hit.geomID[at],
                primitive: hit.primID[at],
                u: hit.u[at],
                v: hit.v[at],
                normal: [hit.Ng_x[at], hit.Ng_y[at], hit.Ng_z[at]],
            })
        })
    }

    /// Whether anything is hit by each of up to eight rays, which should go much the same way.
    #[inline]
    pub fn occluded8(&self, rays: &[Option<Ray>; 8]) -> [bool; 8] {
        let (valid, mut record) = record8(rays, self.reach);
        // SAFETY: as for `intersect`.
        unsafe { self.scene.device.table().trace.occluded8(&valid, self.scene.top.handle, &mut record) };
        std::array::from_fn(|at| valid.0[at] != 0 && record.tfar[at] == f32::NEG_INFINITY)
    }
}

#[inline]
fn record(ray: &Ray) -> RTCRay {
    let ([org_x, org_y, org_z], [dir_x, dir_y, dir_z]) = (ray.origin, ray.direction);
    let (tnear, tfar) = (ray.near, ray.far);
    RTCRay { org_x, org_y, org_z, tnear, dir_x, dir_y, dir_z, time: 0.0, tfar, mask: u32::MAX, id: 0, flags: 0 }
}

#[inline]
fn record8(rays: &[Option<Ray>; 8], reach: f32) -> (Valid8, RTCRay8) {
    // What is not traced is a ray without length.
    let none = Ray { origin: [0.0; 3], direction: [1.0; 3], near: 0.0, far: -1.0 };
    let traced = rays.map(|ray| ray.filter(|ray| ray.is_traceable(reach)));
    let ray = |at: usize| traced[at].unwrap_or(none);
    let [org_x, org_y, org_z] = [0, 1, 2].map(|axis| std::array::from_fn(|at| ray(at).origin[axis]));
    let [dir_x, dir_y, dir_z] = [0, 1, 2].map(|axis| std::array::from_fn(|at| ray(at).direction[axis]));
    let record = RTCRay8 {
        org_x,
        org_y,
        org_z,
        tnear: std::array::from_fn(|at| ray(at).near),
        dir_x,
        dir_y,
        dir_z,
        time: [0.0; 8],
        tfar: std::array::from_fn(|at| ray(at).far),
        mask: [u32::MAX; 8],
        id: [0; 8],
        flags: [0; 8],
    };
    (Valid8(std::array::from_fn(|at| -i32::from(traced[at].is_some()))), record)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Numbers in 0..1 from a counter, the same on every machine.
    struct Sequence(u64);

    impl Sequence {
        fn next(&mut self) -> f32 {
            self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (self.0 >> 40) as f32 / (1u64 << 24) as f32
        }

        fn point(&mut self, scale: f32) -> [f32; 3] {
            std::array::from_fn(|_| (self.next() - 0.5) * scale)
        }
    }

    fn one_triangle() -> Scene {
        let mut scene = Scene::new(&Device::new().unwrap()).unwrap();
        let object = scene.add_object().unwrap();
        scene.set_mesh(object, 7, &[[0.0; 3], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0]], &[[0, 1, 2]]).unwrap();
        scene
    }

    #[test]
    fn rays_that_embree_would_abort_at_hit_nothing() {
        let mut scene = one_triangle();
        let tracer = scene.commit().unwrap();
        for value in [f32::MAX, 1e19, f32::INFINITY, f32::NAN] {
            for axis in 0..3 {
                let mut ray = Ray::new([0.5, 0.5, 1.0], [0.0, 0.0, -1.0]);
                assert!(tracer.intersect(&ray).is_some());
                ray.origin[axis] = value;
                assert!(tracer.intersect(&ray).is_none() && !tracer.occluded(&ray));
                let mut ray = Ray::new([0.5, 0.5, 1.0], [0.0, 0.0, -1.0]);
                ray.direction[axis] = value;
                assert!(tracer.intersect(&ray).is_none() && !tracer.occluded(&ray));
                let mut packet = [Some(Ray::new([0.5, 0.5, 1.0], [0.0, 0.0, -1.0])); 8];
                packet[axis] = Some(ray);
                assert_eq!(tracer.intersect8(&packet).map(|hit| hit.is_none()), std::array::from_fn(|at| at == axis));
                assert_eq!(tracer.occluded8(&packet), std::array::from_fn(|at| at != axis));
            }
        }
    }

    #[test]
    fn tiny_huge_flat_and_far_objects_are_traced_or_refused() {
        let mut scene = one_triangle();
        let object = ObjectId(0);
        for exponent in -44..=38 {
            let scale = 10f32.powi(exponent);
            for (stretched, offset) in [(0..3, 0.0), (2..3, 0.0), (0..1, 1e12), (0..3, f32::MAX)] {
                let mut place = IDENTITY;
                for axis in stretched {
                    place[4 * axis] = scale;
                }
                place[11] = offset;
                let placed = scene.set_transform(object, &place);
                assert!(placed.is_ok() || !(1e-9..1e12).contains(&scale) || offset > 1e12, "{scale}");
                let tracer = scene.commit().unwrap();
                for far in [1.0, 1e6, 1e12] {
                    let ray = Ray::new([0.5 * scale, 0.25 * scale, far], [0.0, far * 1e-3, -far]);
                    let hit = tracer.intersect(&ray);
                    assert_eq!(hit.is_some(), tracer.occluded(&ray));
                }
            }
        }
        for value in [f32::NAN, f32::INFINITY, 1e30] {
            let points = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, value, 0.0]];
            assert!(scene.set_mesh(object, 1, &points, &[[0, 1, 2]]).unwrap_err().to_string().contains("point 2"));
            assert!(scene.move_points(object, 7, &points).is_err());
        }
    }

    #[test]
    fn a_triangle_is_hit_where_the_closed_form_says_and_missed_beside_it() {
        let mut scene = one_triangle();
        let tracer = scene.commit().unwrap();
        let hit = tracer.intersect(&Ray::new([0.5, 0.25, 3.0], [0.0, 0.0, -2.0])).unwrap();
        assert_eq!((hit.object, hit.mesh, hit.primitive), (ObjectId(0), 7, 0));
        assert!((hit.t - 1.5).abs() < 1e-6 && (hit.u - 0.25).abs() < 1e-6 && (hit.v - 0.125).abs() < 1e-6);
        assert!(hit.normal[2] > 0.0 && hit.normal[0] == 0.0, "a counter-clockwise triangle looks to +z");
        assert_eq!(tracer.intersect(&Ray::new([1.5, 1.5, 3.0], [0.0, 0.0, -1.0])), None);
        assert_eq!(tracer.intersect(&Ray::new([0.5, 0.25, 3.0], [0.0, 0.0, 1.0])), None);
        let short = Ray { far: 2.9, ..Ray::new([0.5, 0.25, 3.0], [0.0, 0.0, -1.0]) };
        assert!(!tracer.occluded(&short));
        assert!(tracer.occluded(&Ray { far: 3.1, ..short }));
    }

    #[test]
    fn an_empty_scene_and_an_empty_mesh_have_no_hits() {
        let mut scene = Scene::new(&Device::new().unwrap()).unwrap();
        assert_eq!(scene.commit().unwrap().intersect(&Ray::new([0.0; 3], [0.0, 0.0, 1.0])), None);
        let object = scene.add_object().unwrap();
        scene.set_mesh(object, 0, &[], &[]).unwrap();
        assert_eq!(scene.commit().unwrap().intersect(&Ray::new([0.0; 3], [0.0, 0.0, 1.0])), None);
    }

    #[test]
    fn moving_points_placing_objects_and_removing_meshes_show_after_a_commit() {
        let mut scene = one_triangle();
        let object = ObjectId(0);
        let ray = Ray::new([0.5, 0.25, 3.0], [0.0, 0.0, -1.0]);
        scene.commit().unwrap();
        scene.move_points(object, 7, &[[0.0, 0.0, 1.0], [2.0, 0.0, 1.0], [0.0, 2.0, 1.0]]).unwrap();
        assert!((scene.commit().unwrap().intersect(&ray).unwrap().t - 2.0).abs() < 1e-6);
        let mut place = IDENTITY;
        place[11] = -4.0;
        scene.set_transform(object, &place).unwrap();
        assert!((scene.commit().unwrap().intersect(&ray).unwrap().t - 6.0).abs() < 1e-6);
        scene.remove_mesh(object, 7).unwrap();
        assert_eq!(scene.commit().unwrap().intersect(&ray), None);
        scene.set_mesh(object, 7, &[[0.0; 3], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0]], &[[0, 1, 2]]).unwrap();
        assert!(scene.commit().unwrap().occluded(&ray));
        scene.remove_object(object).unwrap();
        assert!(!scene.commit().unwrap().occluded(&ray));
    }

    #[test]
    fn moving_meshes_have_the_hits_of_meshes_that_are_set_anew() {
        let mut random = Sequence(3);
        let device = Device::new().unwrap();
        let [mut moving, mut anew] = [(); 2].map(|()| Scene::new(&device).unwrap());
        let object = moving.add_object().unwrap();
        let objects = (object, anew.add_object().unwrap());
        let mut points: Vec<[f32; 3]> = (0..900).map(|_| random.point(4.0)).collect();
        let triangles: Vec<[u32; 3]> = (0..300).map(|at| [3 * at, 3 * at + 1, 3 * at + 2]).collect();
        moving.set_moving_mesh(objects.0, 5, &points, &triangles).unwrap();
        moving.commit().unwrap();
        let mut hits = 0;
        for step in 0..6 {
            for point in &mut points {
                let offset = random.point(if step < 4 { 0.2 } else { 4.0 });
                *point = std::array::from_fn(|axis| point[axis] + offset[axis]);
            }
            moving.move_points(objects.0, 5, &points).unwrap();
            anew.set_mesh(objects.1, 5, &points, &triangles).unwrap();
            let (moving, anew) = (moving.commit().unwrap(), anew.commit().unwrap());
            for _ in 0..300 {
                let ray = Ray::new(random.point(6.0), random.point(1.0));
                let (found, expected) = (moving.intersect(&ray), anew.intersect(&ray));
                let named = |hit: Option<Hit>| hit.map(|hit| (hit.mesh, hit.primitive, hit.t.to_bits()));
                assert_eq!(named(found), named(expected));
                hits += u32::from(found.is_some());
            }
        }
        assert!(hits > 500, "{hits} hits say too little");
    }

    #[test]
    fn bad_input_is_refused() {
        let mut scene = one_triangle();
        let object = ObjectId(0);
        let error = scene.set_mesh(object, 0, &[[0.0; 3]; 3], &[[0, 1, 2], [0, 1, 3]]).unwrap_err();
        assert!(error.to_string().contains("triangle 1"), "{error}");
        assert!(scene.move_points(object, 7, &[[0.0; 3]; 2]).is_err());
        assert!(scene.move_points(object, 8, &[]).is_err());
        assert!(scene.add_object().is_ok() && scene.remove_object(ObjectId(9)).is_err());
        assert!(scene.set_transform(object, &[f32::NAN; 12]).is_err());
    }

    #[test]
    fn many_triangles_agree_with_brute_force() {
        let mut random = Sequence(1);
        let mut scene = Scene::new(&Device::new().unwrap()).unwrap();
        let object = scene.add_object().unwrap();
        let mut soup = Vec::new();
        for mesh in 0..5 {
            let mut points = Vec::new();
            for _ in 0..200 {
                let centre = random.point(8.0);
                for _ in 0..3 {
                    let offset = random.point(2.0);
                    points.push(std::array::from_fn(|axis| centre[axis] + offset[axis]));
                }
            }
            let triangles: Vec<[u32; 3]> = (0..200).map(|at| [3 * at, 3 * at + 1, 3 * at + 2]).collect();
            scene.set_mesh(object, mesh, &points, &triangles).unwrap();
            soup.extend(points.chunks_exact(3).enumerate().map(|(at, t)| (mesh, at as u32, [t[0], t[1], t[2]])));
        }
        let tracer = scene.commit().unwrap();
        let mut hits = 0;
        for _ in 0..2000 {
            let ray = Ray::new(random.point(12.0), random.point(1.0));
            let nearest = soup
                .iter()
                .filter_map(|(mesh, at, corners)| Some((moller(&ray, corners)?, *mesh, *at)))
                .min_by(|a, b| a.0.total_cmp(&b.0));
            let found = tracer.intersect(&ray);
            match (nearest, found) {
                (Some((t, mesh, primitive)), Some(hit)) => {
                    hits += 1;
                    assert!((f64::from(hit.t) - t).abs() < 1e-3 * t.max(1.0), "{hit:?} against {t}");
                    assert_eq!((hit.mesh, hit.primitive), (mesh, primitive));
                }
                (None, None) => {}
                // A ray within rounding of an edge may go either way; none of these is.
                (expected, found) => panic!("{expected:?} against {found:?}"),
            }
            assert_eq!(found.is_some(), tracer.occluded(&ray));
        }
        assert!(hits > 500, "{hits} hits say too little");
    }

    #[test]
    fn eight_rays_at_once_hit_what_each_hits_alone() {
        let mut random = Sequence(2);
        let mut scene = Scene::new(&Device::new().unwrap()).unwrap();
        let object = scene.add_object().unwrap();
        let points: Vec<[f32; 3]> = (0..3000).map(|_| random.point(4.0)).collect();
        let triangles: Vec<[u32; 3]> = (0..1000).map(|at| [3 * at, 3 * at + 1, 3 * at + 2]).collect();
        scene.set_mesh(object, 3, &points, &triangles).unwrap();
        let tracer = scene.commit().unwrap();
        for turn in 0..200 {
            let (origin, middle) = (random.point(20.0), random.point(4.0));
            let rays: [Option<Ray>; 8] = std::array::from_fn(|at| {
                let offset = random.point(0.5);
                let toward = [0, 1, 2].map(|axis| middle[axis] + offset[axis] - origin[axis]);
                ((turn + at) % 5 != 0).then_some(Ray::new(origin, toward))
            });
            let alone = rays.map(|ray| ray.and_then(|ray| tracer.intersect(&ray)));
            let together = tracer.intersect8(&rays);
            let name = |hit: Option<Hit>| hit.map(|hit| (hit.object, hit.mesh, hit.primitive));
            assert_eq!(together.map(name), alone.map(name));
            for (a, b) in alone.iter().flatten().zip(together.iter().flatten()) {
                assert!((a.t - b.t).abs() < 1e-5 && (a.u - b.u).abs() < 1e-3 && (a.v - b.v).abs() < 1e-3);
            }
            assert_eq!(tracer.occluded8(&rays), alone.map(|hit| hit.is_some()));
        }
    }

    /// The ray–triangle test of Möller and Trumbore 1997 in f64.
    fn moller(ray: &Ray, corners: &[[f32; 3]; 3]) -> Option<f64> {
        let wide = |v: [f32; 3]| v.map(f64::from);
        let sub = |a: [f64; 3], b: [f64; 3]| [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
        let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        let cross = |a: [f64; 3], b: [f64; 3]| {
            [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
        };
        let [a, b, c] = corners.map(wide);
        let (ab, ac, direction) = (sub(b, a), sub(c, a), wide(ray.direction));
        let p = cross(direction, ac);
        let s = sub(wide(ray.origin), a);
        let q = cross(s, ab);
        let scale = 1.0 / dot(ab, p);
        let (u, v, t) = (dot(s, p) * scale, dot(direction, q) * scale, dot(ac, q) * scale);
        (u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t >= 0.0).then_some(t)
    }
}
