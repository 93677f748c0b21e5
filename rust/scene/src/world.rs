//! The objects of a scene as the kernels want them: surfaces with displacement, colliders, and where everything is.

use std::path::PathBuf;

use glam::DAffine3;
use relievo_core::{Context, Domain, Error, Mesh, Result, Values};
use relievo_detail::{Collider, DisplacedObject};
use relievo_surface::{BoundaryRule, Surface, SurfaceOptions};
use relievo_tiles::{Displaced, Displacement, DisplacementOptions};

use crate::assets::Assets;
use crate::description::{Geometry, Scene, SurfaceEntry};
use crate::diagnostic::{Diagnostic, Failure, Faults};
use crate::paths::Paths;
use crate::physics::Physics;
use crate::tessellation::Rates;

/// A scene whose meshes are loaded and whose surfaces are made.
#[derive(Debug)]
pub struct World {
    /// What the scene file says.
    pub scene: Scene,
    /// Bodies on their way through time.
    pub physics: Physics,
    assets: Assets,
    items: Vec<Item>,
    /// The objects as colliders, made when first asked for.
    colliders: Vec<Option<Collider>>,
    transforms: Vec<DAffine3>,
    /// Seconds for which the items are posed.
    time: f64,
}

/// What the kernels know of an object.
#[derive(Debug)]
pub enum Item {
    /// A surface, which may have displacement.
    Surface(Box<DisplacedObject>),
    /// A mesh as it is.
    Mesh(MeshItem),
}

/// An object that shows a mesh.
#[derive(Debug)]
pub struct MeshItem {
    /// The mesh, posed.
    pub mesh: Mesh,
    /// From object space to the world.
    pub transform: DAffine3,
}

/// Quads along a side of an untouched tile of a surface that is a collider.
const COLLIDER_RATE: u32 = 16;

impl World {
    /// Loads the meshes of `scene`, from below its folder and the folders `allowed`, and makes its surfaces, at time 0.
    pub fn new(context: &Context, scene: Scene, allowed: &[PathBuf]) -> std::result::Result<Self, Failure> {
        let paths = Paths::new(&scene.path, allowed)?;
        let assets = context.stats().time("load.meshes", || Assets::load(context, &scene, &paths))?;
        let refuse = |fault: Diagnostic| Faults {
            name: scene.path.display().to_string(),
            text: scene.text.clone(),
            list: vec![fault],
        };
        let cages: Vec<&Mesh> = scene.objects.iter().map(|object| assets.mesh(scene.cage_of(object))).collect();
        let physics = context.stats().time("load.physics", || Physics::new(&scene, &cages)).map_err(refuse)?;
        let transforms = physics.transforms();
        let mut items = Vec::new();
        for (object, transform) in scene.objects.iter().zip(&transforms) {
            let transform = *transform;
            let mesh = assets.mesh(scene.cage_of(object));
            let item = match object.geometry {
                Geometry::Mesh(_) => Ok(Item::Mesh(MeshItem { mesh: mesh.clone(), transform })),
                Geometry::Surface(index) => {
                    let entry = &scene.surfaces[index];
                    let options = surface_options(entry);
                    let detail = DisplacementOptions {
                        size: object.detail.tile_size,
                        budget: object.detail.budget,
                        ..Default::default()
                    };
                    make_surface(context, mesh, &options, &detail, transform)
                        .map_err(|error| refuse(Diagnostic::from_error(entry.name.span.clone(), &error)))
                }
            };
            items.push(item?);
        }
        let colliders = items.iter().map(|_| None).collect();
        Ok(Self { physics, assets, items, colliders, transforms, scene, time: 0.0 })
    }

    /// The objects.
    pub fn items(&self) -> &[Item] {
        &self.items
    }

    /// The surface of an object, if it shows one, for writing. It will be tessellated anew where it is a collider.
    pub fn surface_mut(&mut self, object: usize) -> Option<&mut DisplacedObject> {
        match self.items.get_mut(object) {
            Some(Item::Surface(surface)) => {
                self.colliders[object] = None;
                Some(surface)
            }
            _ => None,
        }
    }

    /// The mesh that an object shows, or the control cage of its surface, at time 0.
    pub fn cage(&self, object: usize) -> &Mesh {
        self.assets.mesh(self.scene.cage_of(&self.scene.objects[object]))
    }

    /// What was left out or repaired while reading meshes.
    pub fn notes(&self) -> Vec<String> {
        let entries = self.scene.meshes.iter().enumerate();
        let meshes = entries.flat_map(|(index, entry)| {
            self.assets.notes(index).iter().map(|note| format!("mesh `{}`: {note}", entry.name.text))
        });
        let objects = self.items.iter().zip(&self.scene.objects).filter_map(|(item, object)| {
            let Item::Surface(surface) = item else { return None };
            let sides = surface.surface().topology().pinned_side_count();
            let name = &object.name.text;
            (sides > 0).then(|| {
                format!("object `{name}`: {sides} sides of faces meet at non-manifold edges and stay undisplaced there")
            })
        });
        meshes.chain(objects).collect()
    }

    /// The limit of the texture coordinates of an object's surface; `None` if it is a mesh or its cage has none.
    pub fn texture_limit(&self, context: &Context, object: usize) -> Result<Option<Surface>> {
        let (Some(entry), cage) = (self.scene.objects.get(object), self.cage(object)) else { return Ok(None) };
        let Geometry::Surface(index) = entry.geometry else { return Ok(None) };
        let smooth = cage
            .attribute("uv")
            .is_some_and(|uv| uv.domain == Domain::Corner && uv.width == 2 && matches!(uv.values, Values::F32(_)));
        if !smooth {
            return Ok(None);
        }
        Surface::face_varying(context, cage, "uv", &surface_options(&self.scene.surfaces[index])).map(Some)
    }

    /// Where the objects are.
    pub fn transforms(&self) -> &[DAffine3] {
        &self.transforms
    }

    /// Places the objects.
    pub fn place(&mut self, transforms: &[DAffine3]) -> Result<()> {
        for (index, transform) in transforms.iter().enumerate().take(self.items.len()) {
            let name = || format!("object `{}`", self.scene.objects[index].name.text);
            let named = |error: Error| error.at(name());
            match &mut self.items[index] {
                Item::Surface(surface) => surface.set_transform(*transform).map_err(named)?,
                Item::Mesh(item) => item.transform = *transform,
            }
            if let Some(collider) = &mut self.colliders[index] {
                collider.set_transform(*transform).map_err(named)?;
            }
            self.transforms[index] = *transform;
        }
        Ok(())
    }

    /// Poses objects whose meshes are animated for `time` seconds. Returns their indices.
    pub fn pose(&mut self, context: &Context, time: f64) -> Result<Vec<usize>> {
        let mut moved = Vec::new();
        if time == self.time {
            return Ok(moved);
        }
        self.time = time;
        for index in 0..self.items.len() {
            let object = &self.scene.objects[index];
            let mesh = self.scene.cage_of(object);
            if !self.assets.is_animated(mesh) {
                continue;
            }
            let name = || format!("object `{}`", object.name.text);
            let points = self.assets.points(context, mesh, time, self.scene.fps).map_err(|error| error.at(name()))?;
            match &mut self.items[index] {
                Item::Surface(surface) => {
                    surface.pose(context, &points)?;
                    self.colliders[index] = None;
                }
                Item::Mesh(item) => {
                    if let Some(collider) = &mut self.colliders[index] {
                        collider.set_points(context, &points)?;
                    }
                    item.mesh.points = points;
                }
            }
            moved.push(index);
        }
        Ok(moved)
    }

    /// Whether any object's points move.
    pub fn is_animated(&self) -> bool {
        (0..self.scene.meshes.len()).any(|mesh| self.assets.is_animated(mesh))
    }

    /// Whether the points of an object move.
    pub fn is_object_animated(&self, object: usize) -> bool {
        self.scene.objects.get(object).is_some_and(|entry| self.assets.is_animated(self.scene.cage_of(entry)))
    }

    /// Makes the collider of an object, as it is now: meshes as they are, surfaces displaced and tessellated.
    pub fn make_collider(&mut self, context: &Context, object: usize) -> Result<&mut Collider> {
        let missing = || Error::internal(format!("there is no object {object}"));
        let slot = self.colliders.get_mut(object).ok_or_else(missing)?;
        if slot.is_none() {
            let made = match self.items.get(object).ok_or_else(missing)? {
                Item::Mesh(item) => Collider::of_mesh(context, &item.mesh, item.transform)?,
                Item::Surface(surface) => {
                    let displaced = Displaced::new(surface.surface(), surface.displacement().field())?;
                    let rates = Rates::new(&displaced, COLLIDER_RATE, u32::MAX);
                    let cage = self.assets.mesh(self.scene.cage_of(&self.scene.objects[object]));
                    let mesh = displaced.tessellate(context, cage, rates.as_slice())?.mesh;
                    let triangles = mesh.triangles();
                    Collider::new(context, mesh.points, triangles, *surface.transform())?
                }
            };
            *slot = Some(made);
        }
        slot.as_mut().ok_or_else(missing)
    }

    /// Has the object tessellated anew when it is next asked for as a collider.
    pub fn forget_collider(&mut self, object: usize) {
        if let (Some(Item::Surface(_)), Some(slot)) = (self.items.get(object), self.colliders.get_mut(object)) {
            *slot = None;
        }
    }

    /// A surface to press into and the collider that presses, made by [`Self::make_collider`]; `None` unless both are
    /// there.
    pub fn pair(&mut self, into: usize, by: usize) -> Option<(&mut DisplacedObject, &Collider)> {
        match (self.items.get_mut(into)?, self.colliders.get(by)?) {
            (Item::Surface(surface), Some(collider)) => Some((surface, collider)),
            _ => None,
        }
    }

    /// A number for everything that decides the imprints: the scene without camera, light, colours and outputs, and
    /// the files it reads.
    pub fn fingerprint(&self) -> u64 {
        let scene = &self.scene;
        let objects: Vec<_> = scene
            .objects
            .iter()
            .map(|object| (&object.name, object.geometry, object.placement, object.deformable, object.detail))
            .collect();
        let files: Vec<_> = (0..scene.meshes.len()).map(|mesh| self.assets.checksums(mesh)).collect();
        let decisive = (
            (env!("CARGO_PKG_VERSION"), scene.fps, scene.up, scene.seed, scene.physics),
            (&scene.meshes, files, &scene.surfaces, objects, &scene.bodies, &scene.colliders),
        );
        // FNV-1a of the text of all of it.
        format!("{decisive:?}")
            .bytes()
            .fold(0xcbf2_9ce4_8422_2325, |hash: u64, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3))
    }
}

/// How a cage of the scene becomes a surface.
fn surface_options(entry: &SurfaceEntry) -> SurfaceOptions {
    let mut options = SurfaceOptions::default();
    options.isolation = entry.isolation.unwrap_or(options.isolation);
    if !entry.sharp_corners {
        options.boundary = BoundaryRule::Edges;
    }
    options
}

fn make_surface(
    context: &Context,
    mesh: &Mesh,
    options: &SurfaceOptions,
    detail: &DisplacementOptions,
    transform: DAffine3,
) -> Result<Item> {
    let surface = Surface::new(context, mesh, options)?;
    let displacement = Displacement::new(surface.topology().clone(), detail)?;
    let object = DisplacedObject::new(context, surface, &mesh.points, displacement, transform)?;
    Ok(Item::Surface(Box::new(object)))
}
