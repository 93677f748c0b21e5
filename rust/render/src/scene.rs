//! What is rendered: objects made of triangle meshes and implicit surfaces, with materials, placed in the world.
//!
//! An object may be cut into any number of meshes. Only meshes that are set anew have their hierarchies built again, so
//! a surface that changes in places should be cut accordingly; an object that only moves rebuilds nothing.

use glam::{DAffine3, DMat3, DVec3, Mat3, Vec3};
use relievo_core::{Context, Error, Result, Values};
use relievo_embree as embree;

use crate::color::Color;
use crate::dielectric::Dielectric;
use crate::frame::Frame;
use crate::implicit::Implicit;
use crate::settings::View;

/// A triangle mesh.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// Positions in object space.
    pub points: Vec<[f32; 3]>,
    /// Triangles, counter-clockwise from their front.
    pub triangles: Vec<[u32; 3]>,
    /// Normals at the points, of any length; empty for flat triangles.
    pub normals: Vec<[f32; 3]>,
    /// Colours at the points, in place of the material's; may be empty.
    pub colors: Vec<Color>,
    /// One number per triangle, which false colours show; may be empty.
    pub tags: Vec<u32>,
    /// Per triangle the edges that count as marked for the wireframe, bit e for the edge from corner e to the next;
    /// empty if all are.
    pub edges: Vec<u8>,
}

impl Mesh {
    /// The triangles of a tessellation with its point attributes `normal` and `color`, where it has them.
    pub fn of_tessellation(mesh: relievo_core::Mesh) -> Self {
        let list = |name: &str| match mesh.attribute(name).map(|attribute| &attribute.values) {
            Some(Values::F32(values)) => values.as_chunks::<3>().0.to_vec(),
            _ => Vec::new(),
        };
        let (normals, colors) = (list("normal"), list("color"));
        let triangles = mesh.corners.as_chunks::<3>().0.to_vec();
        Self { points: mesh.points, triangles, normals, colors, ..Self::default() }
    }
}

/// How a surface reflects.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Material {
    /// Diffuse reflectance where the mesh has no colours, 0 to 1.
    pub base_color: Color,
    /// Reflectance of the glossy part seen straight on, 0 to 1; plastics and water have 0.04.
    pub specular: f32,
    /// Roughness of the glossy part, 0 to 1.
    pub roughness: f32,
}

impl Default for Material {
    fn default() -> Self {
        Self { base_color: [0.7; 3], specular: 0.02, roughness: 0.5 }
    }
}

/// An object of a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ObjectId(u32);

impl ObjectId {
    pub(crate) fn of(number: u32) -> Self {
        Self(number)
    }

    /// The number that pictures of object ids hold.
    pub fn number(self) -> u32 {
        self.0
    }
}

/// Objects to be rendered.
pub struct Scene {
    pub(crate) embree: embree::Scene,
    pub(crate) objects: Vec<Option<Object>>,
}

pub(crate) struct Object {
    pub id: embree::ObjectId,
    pub transform: DAffine3,
    pub material: Material,
    pub dielectric: Option<Dielectric>,
    pub meshes: Vec<Option<Mesh>>,
    pub implicit: Option<Box<dyn Implicit>>,
}

/// Meshes an object may have.
const MAX_MESHES: u32 = 1 << 22;

impl Scene {
    /// An empty scene.
    ///
    /// # Errors
    /// Embree is missing or of another version.
    pub fn new() -> Result<Self> {
        let device = embree::Device::new()?;
        Ok(Self { embree: embree::Scene::new(&device)?, objects: Vec::new() })
    }

    /// Adds an object without meshes.
    ///
    /// # Errors
    /// Fails with `Invalid` if the transform is singular or not finite or a number of the material is not 0 to 1, and
    /// with `Memory` or `Internal` if Embree makes no object.
    pub fn add_object(&mut self, transform: DAffine3, material: Material) -> Result<ObjectId> {
        check_transform(&transform)?;
        check_material(&material)?;
        let id = self.embree.add_object()?;
        let index = self.objects.len();
        let meshes = Vec::new();
        self.objects.push(Some(Object { id, transform, material, dielectric: None, meshes, implicit: None }));
        Ok(ObjectId(index as u32))
    }

    /// Removes an object with its meshes. Its id is not used again.
    ///
    /// # Errors
    /// Fails with `Invalid` if there is no such object.
    pub fn remove_object(&mut self, object: ObjectId) -> Result<()> {
        let id = self.object(object)?.id;
        self.embree.remove_object(id)?;
        self.objects[object.0 as usize] = None;
        Ok(())
    }

    /// Places an object.
    ///
    /// # Errors
    /// The transform is singular or not finite.
    pub fn set_transform(&mut self, object: ObjectId, transform: DAffine3) -> Result<()> {
        check_transform(&transform)?;
        self.object(object)?.transform = transform;
        Ok(())
    }

    /// Gives an object another material.
    ///
    /// # Errors
    /// Fails with `Invalid` if a number of the material is not 0 to 1, or there is no such object.
    pub fn set_material(&mut self, object: ObjectId, material: Material) -> Result<()> {
        check_material(&material)?;
        self.object(object)?.material = material;
        Ok(())
    }

    /// Lets light go through an object, whose surface is closed, or not. It then has the glossy part of its material and
    /// no diffuse one.
    ///
    /// # Errors
    /// The index of refraction or the absorption is out of range.
    pub fn set_dielectric(&mut self, object: ObjectId, dielectric: Option<Dielectric>) -> Result<()> {
        if let Some(dielectric) = &dielectric {
            dielectric.check()?;
        }
        self.object(object)?.dielectric = dielectric;
        Ok(())
    }

    /// Gives an object an implicit surface beside its meshes, or none.
    ///
    /// # Errors
    /// Fails with `Invalid` if there is no such object.
    pub fn set_implicit(&mut self, object: ObjectId, implicit: Option<Box<dyn Implicit>>) -> Result<()> {
        self.object(object)?.implicit = implicit;
        Ok(())
    }

    /// Sets mesh `number` of an object in place of what it was. A mesh without triangles is as good as none.
    ///
    /// # Errors
    /// Triangles name points that do not exist, or the lists' lengths do not fit.
    pub fn set_mesh(&mut self, object: ObjectId, number: u32, mesh: Mesh) -> Result<()> {
        if number >= MAX_MESHES {
            return Err(Error::invalid(format!("mesh {number} of an object"))
                .advise(format!("use numbers below {MAX_MESHES}, from 0 up")));
        }
        check_lengths(&mesh)?;
        let id = self.object(object)?.id;
        self.embree.set_mesh(id, number, &mesh.points, &mesh.triangles)?;
        let meshes = &mut self.object(object)?.meshes;
        if meshes.len() <= number as usize {
            meshes.resize_with(number as usize + 1, || None);
        }
        meshes[number as usize] = Some(mesh);
        Ok(())
    }

    /// Moves the points of a mesh and gives them other normals; triangles, colours and tags stay. This is cheaper than
    /// [`Scene::set_mesh`].
    ///
    /// # Errors
    /// Fails with `Invalid` if there is no such object or mesh, there are not as many points or normals as before, or a
    /// coordinate is not finite or beyond 1e12.
    pub fn move_points(
        &mut self,
        object: ObjectId,
        number: u32,
        points: Vec<[f32; 3]>,
        normals: Vec<[f32; 3]>,
    ) -> Result<()> {
        let found = self.object(object)?;
        let id = found.id;
        let mesh = found.meshes.get(number as usize).and_then(Option::as_ref);
        let mesh = mesh.ok_or_else(|| Error::invalid(format!("there is no mesh {number}")))?;
        if mesh.points.len() != points.len() || !(normals.is_empty() || normals.len() == points.len()) {
            return Err(Error::invalid("the points or normals are not as many as before"));
        }
        if !mesh.triangles.is_empty() {
            self.embree.move_points(id, number, &points)?;
        }
        if let Some(Some(mesh)) = self.object(object)?.meshes.get_mut(number as usize) {
            mesh.points = points;
            mesh.normals = normals;
        }
        Ok(())
    }

    /// Removes a mesh of an object, if there is one.
    ///
    /// # Errors
    /// Fails with `Invalid` if there is no such object.
    pub fn remove_mesh(&mut self, object: ObjectId, number: u32) -> Result<()> {
        let found = self.object(object)?;
        if let Some(slot) = found.meshes.get_mut(number as usize) {
            *slot = None;
            let id = found.id;
            self.embree.remove_mesh(id, number)?;
        }
        Ok(())
    }

    /// Renders the scene without some of its objects, which are as before afterwards.
    ///
    /// # Errors
    /// There is no such object, or [`Self::render`] fails.
    pub fn render_without(&mut self, context: &Context, hidden: &[ObjectId], view: &View) -> Result<Frame> {
        let mut taken = Vec::with_capacity(hidden.len());
        for id in hidden {
            let object = self.object(*id)?;
            let (embree, implicit, meshes) = (object.id, object.implicit.take(), std::mem::take(&mut object.meshes));
            for number in (0..meshes.len()).filter(|number| meshes[*number].is_some()) {
                self.embree.remove_mesh(embree, number as u32)?;
            }
            taken.push((implicit, meshes));
        }
        let frame = self.render(context, view);
        for (id, (implicit, meshes)) in hidden.iter().zip(taken) {
            self.set_implicit(*id, implicit)?;
            for (number, mesh) in (0..).zip(meshes) {
                if let Some(mesh) = mesh {
                    self.set_mesh(*id, number, mesh)?;
                }
            }
        }
        frame
    }

    /// How many triangles there are.
    pub fn triangle_count(&self) -> u64 {
        let meshes = self.objects.iter().flatten().flat_map(|object| object.meshes.iter().flatten());
        meshes.map(|mesh| mesh.triangles.len() as u64).sum()
    }

    fn object(&mut self, object: ObjectId) -> Result<&mut Object> {
        let found = self.objects.get_mut(object.0 as usize).and_then(Option::as_mut);
        found.ok_or_else(|| Error::invalid(format!("there is no object {}", object.0)))
    }

    /// Where the objects are as seen from `eye`, and the traceable scene in that space.
    pub(crate) fn placed(&mut self, eye: DVec3) -> Result<Placed<'_>> {
        let mut placements = Vec::with_capacity(self.objects.len());
        for object in &self.objects {
            let Some(object) = object else {
                placements.push(None);
                continue;
            };
            let linear = object.transform.matrix3.as_mat3();
            let translation = (object.transform.translation - eye).as_vec3();
            let columns = [linear.x_axis, linear.y_axis, linear.z_axis, translation];
            let mut flat = [0.0; 12];
            for (to, from) in flat.chunks_exact_mut(3).zip(columns) {
                to.copy_from_slice(&from.to_array());
            }
            self.embree.set_transform(object.id, &flat)?;
            let inverse = object.transform.inverse();
            placements.push(Some(Placement {
                back: inverse.matrix3,
                eye: inverse.transform_point3(eye),
                linear,
                translation,
                normal: linear.inverse().transpose(),
                mirrored: linear.determinant() < 0.0,
                material: object.material,
                dielectric: object.dielectric,
            }));
        }
        Ok(Placed { tracer: self.embree.commit()?, objects: &self.objects, placements })
    }
}

/// A committed scene in a space whose origin is the camera.
pub(crate) struct Placed<'a> {
    pub tracer: embree::Tracer<'a>,
    pub objects: &'a [Option<Object>],
    pub placements: Vec<Option<Placement>>,
}

impl Placed<'_> {
    /// Where an object is.
    pub fn placement(&self, object: u32) -> Option<&Placement> {
        self.placements.get(object as usize)?.as_ref()
    }
}

pub(crate) struct Placement {
    /// From directions in the camera's space to those in the object's, and the camera there.
    pub back: DMat3,
    pub eye: DVec3,
    pub linear: Mat3,
    pub translation: Vec3,
    pub normal: Mat3,
    pub mirrored: bool,
    pub material: Material,
    pub dielectric: Option<Dielectric>,
}

fn check_transform(transform: &DAffine3) -> Result<()> {
    let linear = transform.matrix3.as_mat3();
    let inverse = linear.inverse();
    if transform.is_finite() && linear.determinant() != 0.0 && linear.is_finite() && inverse.is_finite() {
        return Ok(());
    }
    Err(Error::invalid("the transform of an object is singular or not finite")
        .advise("give it a scale that is not zero on every axis"))
}

fn check_material(material: &Material) -> Result<()> {
    let unit = |value: f32| (0.0..=1.0).contains(&value);
    if material.base_color.into_iter().all(unit) && unit(material.specular) && unit(material.roughness) {
        return Ok(());
    }
    Err(Error::invalid("a material's colour, specular or roughness is out of range").advise("use 0 to 1"))
}

fn check_lengths(mesh: &Mesh) -> Result<()> {
    let fits = |length: usize, count: usize| length == 0 || length == count;
    let (points, triangles) = (mesh.points.len(), mesh.triangles.len());
    let lists = [
        ("normals", mesh.normals.len(), points),
        ("colors", mesh.colors.len(), points),
        ("tags", mesh.tags.len(), triangles),
        ("edges", mesh.edges.len(), triangles),
    ];
    match lists.into_iter().find(|(_, length, count)| !fits(*length, *count)) {
        None => Ok(()),
        Some((name, length, count)) => Err(Error::invalid(format!("a mesh has {length} {name} instead of {count}"))
            .advise("leave the list empty or give one per element")),
    }
}
