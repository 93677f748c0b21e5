//! The objects of a scene as the kernels want them: surfaces with displacement, colliders, and where everything is.

use std::collections::BTreeSet;
use std::path::PathBuf;
use std::sync::OnceLock;

use glam::{DAffine3, DVec3};
use relievo_core::{Context, Domain, Error, Mesh, Result, Values};
use relievo_detail::canvas::Canvas;
use relievo_detail::{Action, Collider, DecayingObject, DisplacedObject, LayeredObject, Stamp, TriangleObject};
use relievo_gpu::Device;
use relievo_surface::Surface;

use crate::format::description::{CrowdEntry, Geometry, Scene};
use crate::out::output::Folder;
use crate::state::assets::Assets;
use crate::state::coat::Coat;
use crate::state::physics::Physics;
use crate::state::stamps::Loaded;
use crate::state::stickers;
use crate::state::triangles::TriangleItem;
use crate::state::walking;

/// A scene whose meshes are loaded and whose surfaces are made.
#[derive(Debug)]
pub struct World {
    /// What the scene file says.
    pub scene: Scene,
    /// Bodies on their way through time.
    pub physics: Physics,
    pub(super) assets: Assets,
    pub(super) items: Vec<Item>,
    /// The meshes that press as colliders.
    pub(super) colliders: Vec<Option<Collider>>,
    /// Notes on surfaces with less isolation than the default.
    pub(super) lowered: Vec<String>,
    /// Per object the checksum and the notes of the document it starts from.
    pub(super) documents: Vec<Option<(u32, Vec<String>)>>,
    /// Images of brushes.
    pub(super) stamps: Vec<Loaded>,
    pub(super) stickers: Vec<stickers::Loaded>,
    pub(super) crowds: Vec<walking::Loaded>,
    /// The crowds that press, one for each of `crowd_colliders`.
    pub(super) pressing: Vec<walking::Pressing>,
    pub(super) transforms: Vec<DAffine3>,
    /// Where the objects are at time 0.
    pub(super) start: Vec<DAffine3>,
    /// Seconds for which the items are posed.
    pub(super) time: f64,
    /// Per object the time of its edits when the scene is at 0: documents whose edits fade go on from theirs.
    pub(super) begun: Vec<f64>,
    /// Whether a graphics device was given to the surfaces.
    pub(super) on_device: bool,
    /// Per object the limit of its texture coordinates, once it was asked for: no pose changes it.
    pub(super) textures: Vec<OnceLock<Surface>>,
}

/// What the kernels know of an object.
#[derive(Debug)]
pub enum Item {
    /// A surface, which may have displacement.
    Surface(Box<DisplacedObject>),
    /// A mesh whose triangles may have displacement.
    Triangles(Box<TriangleItem>),
    /// A mesh as it is.
    Mesh(Box<MeshItem>),
}

/// An object that shows a mesh.
#[derive(Debug)]
pub struct MeshItem {
    /// The mesh, posed.
    pub mesh: Mesh,
    /// From object space to the world.
    pub transform: DAffine3,
}

impl World {
    /// The objects.
    pub fn items(&self) -> &[Item] {
        &self.items
    }

    /// Keeps frames of soft tissue in the folder of the cache of the scene.
    pub(crate) fn keep_tissue(&mut self, cache: &Folder) -> Result<()> {
        if self.scene.tissue.is_empty() { Ok(()) } else { self.assets.keep_tissue(cache) }
    }

    /// Returns what the user should know of soft tissue since the last call.
    pub(crate) fn take_tissue_notes(&mut self) -> Vec<String> {
        self.assets.take_tissue_notes()
    }

    /// Models and agents of the crowds.
    pub(crate) fn crowds(&self) -> &[walking::Loaded] {
        &self.crowds
    }

    /// What an object shows, for writing, the agents that collider `entry` of the crowds presses into it, and how they do.
    pub(crate) fn item_and_crowd(
        &mut self,
        object: usize,
        entry: usize,
    ) -> Option<(&mut Item, &walking::Loaded, &walking::Pressing)> {
        let crowd = self.scene.crowd_colliders.get(entry)?.crowd;
        Some((self.items.get_mut(object)?, self.crowds.get(crowd)?, self.pressing.get(entry)?))
    }

    /// Returns the agents that collider `entry` of the crowds presses, and how they do.
    pub(crate) fn crowd_that_presses(&self, entry: usize) -> Option<(&walking::Loaded, &walking::Pressing)> {
        let crowd = self.scene.crowd_colliders.get(entry)?.crowd;
        Some((self.crowds.get(crowd)?, self.pressing.get(entry)?))
    }

    /// Has a graphics device make imprints on surfaces, and dabs on surfaces and meshes, from now on, or the processor
    /// again. What a device does not do, the processor does.
    ///
    /// # Errors
    /// Fails with `Memory` or `Device` if the device has no room for one of them or is lost; objects before it work on
    /// the device then.
    pub fn use_device(&mut self, device: Option<&Device>) -> relievo_core::Result<()> {
        for item in &mut self.items {
            match item {
                Item::Surface(surface) => surface.use_device(device)?,
                Item::Triangles(item) => item.object.use_device(device)?,
                Item::Mesh(_) => {}
            }
        }
        self.on_device = device.is_some();
        Ok(())
    }

    /// Whether it has a graphics device, lost or not.
    pub fn is_on_device(&self) -> bool {
        self.on_device
    }

    /// Notes of where the processor took over from a graphics device, told once.
    pub fn take_device_faults(&mut self) -> Vec<String> {
        let (items, objects) = (&mut self.items, &self.scene.objects);
        let told = items.iter_mut().zip(objects).filter_map(|(item, object)| {
            let fault = match item {
                Item::Surface(surface) => surface.take_device_fault(),
                Item::Triangles(item) => item.object.take_device_fault(),
                Item::Mesh(_) => None,
            }?;
            Some(format!("the processor took over for `{}`: {fault}", object.name.text))
        });
        told.collect()
    }

    /// The surface of an object, if it shows one, for writing.
    pub fn surface_mut(&mut self, object: usize) -> Option<&mut DisplacedObject> {
        match self.items.get_mut(object) {
            Some(Item::Surface(surface)) => Some(surface),
            _ => None,
        }
    }

    /// The sticker of decal number `index`.
    #[cfg(feature = "decal")]
    pub(crate) fn sticker(&self, index: usize) -> Result<&stickers::Loaded> {
        self.stickers.get(index).ok_or_else(|| Error::internal("a decal has no sticker"))
    }

    /// What an object shows, for writing, and the sticker of decal number `index`.
    #[cfg(feature = "decal")]
    pub(crate) fn item_and_sticker(&mut self, object: usize, index: usize) -> Result<(&mut Item, &stickers::Loaded)> {
        let found = self.items.get_mut(object).zip(self.stickers.get(index));
        found.ok_or_else(|| Error::internal("a decal has no object or no sticker"))
    }

    /// Those of `objects` that can be painted and sculpted, for writing.
    pub(crate) fn canvases(&mut self, objects: &[usize]) -> Vec<&mut dyn Canvas> {
        let items = self.items.iter_mut().enumerate().filter(|(index, _)| objects.contains(index));
        items
            .filter_map(|(_, item)| match item {
                Item::Surface(surface) => Some(&mut **surface as &mut dyn Canvas),
                Item::Triangles(item) => Some(&mut item.object as &mut dyn Canvas),
                Item::Mesh(_) => None,
            })
            .collect()
    }

    /// An image as a brush of `action` takes it.
    pub(crate) fn stamp(&self, index: usize, action: &Action) -> Option<&Stamp> {
        let loaded = self.stamps.get(index)?;
        Some(if matches!(action, Action::Paint { .. }) { &loaded.paint } else { &loaded.sculpt })
    }

    /// The triangle mesh of an object, if it shows one that may be displaced, for writing.
    pub fn triangles_mut(&mut self, object: usize) -> Option<&mut TriangleItem> {
        match self.items.get_mut(object) {
            Some(Item::Triangles(item)) => Some(item),
            _ => None,
        }
    }

    /// The mesh that an object shows, or the control cage of its surface, at time 0.
    pub fn cage(&self, object: usize) -> &Mesh {
        if let Some(Item::Triangles(item)) = self.items.get(object)
            && let Some(cage) = &item.cage
        {
            return cage;
        }
        self.assets.mesh(self.scene.cage_of(&self.scene.objects[object]))
    }

    /// Returns the files of the mesh of an object, one for each frame; `None` if it is not a sequence.
    pub fn sequence(&self, object: usize) -> Option<&[PathBuf]> {
        self.assets.sequence(self.scene.cage_of(self.scene.objects.get(object)?))
    }

    /// Names of the material slots of an object's mesh or cage.
    pub fn materials(&self, object: usize) -> &[String] {
        self.assets.materials(self.scene.cage_of(&self.scene.objects[object]))
    }

    /// What was left out or repaired while reading meshes, and what of the objects may surprise.
    pub fn notes(&self) -> Vec<String> {
        let entries = self.scene.meshes.iter().enumerate();
        let meshes = entries.flat_map(|(index, entry)| {
            self.assets.notes(index).iter().map(|note| format!("mesh `{}`: {note}", entry.name.text))
        });
        let triangles = self.items.iter().zip(&self.scene.objects).flat_map(|(item, object)| {
            let notes = if let Item::Triangles(item) = item { &item.notes[..] } else { &[] };
            notes.iter().map(|note| format!("object `{}`: {note}", object.name.text))
        });
        let objects = self.items.iter().zip(&self.scene.objects).filter_map(|(item, object)| {
            let Item::Surface(surface) = item else { return None };
            let sides = surface.surface().topology().pinned_side_count();
            let name = &object.name.text;
            (sides > 0).then(|| {
                format!("object `{name}`: {sides} sides of faces meet at non-manifold edges and stay undisplaced there")
            })
        });
        let objects_that_press = self
            .scene
            .colliders
            .iter()
            .filter_map(|entry| Some((&entry.name.text, self.colliders.get(entry.object)?.as_ref()?)));
        let crowds = self.scene.crowd_colliders.iter().zip(&self.pressing);
        let crowds_that_press = crowds.map(|(entry, pressing)| (&entry.name.text, pressing.collider()));
        let open = objects_that_press.chain(crowds_that_press).filter(|(_, collider)| !collider.is_closed());
        let open = open.map(|(name, collider)| {
            let count = collider.open_edges();
            if collider.is_sheet() {
                format!(
                    "collider `{name}`: its mesh is a sheet with {count} open edges, so it is solid behind the front of \
                     its faces; turn them over if it leaves no imprint"
                )
            } else {
                format!(
                    "collider `{name}`: its mesh has {count} open edges; their holes are covered to make it solid, and \
                     `relievo mesh repair FILE -o FILE` closes them in the file"
                )
            }
        });
        let documents = self.documents.iter().zip(&self.scene.objects).flat_map(|(document, object)| {
            let notes = document.iter().flat_map(|(_, notes)| notes);
            notes.map(|note| format!("object `{}`: {note}", object.name.text))
        });
        let lowered = self.lowered.iter().cloned();
        meshes.chain(lowered).chain(triangles).chain(objects).chain(open).chain(documents).collect()
    }

    /// The limit of the texture coordinates of an object's surface; `None` if it is a mesh or its cage has none.
    ///
    /// # Errors
    /// Fails as [`Surface::face_varying`].
    pub fn texture_limit(&self, context: &Context, object: usize) -> Result<Option<Surface>> {
        let (Some(entry), cage) = (self.scene.objects.get(object), self.cage(object)) else { return Ok(None) };
        let Geometry::Surface(index) = entry.geometry else { return Ok(None) };
        let smooth = cage
            .attribute("uv")
            .is_some_and(|uv| uv.domain == Domain::Corner && uv.width == 2 && matches!(uv.values, Values::F32(_)));
        if !smooth {
            return Ok(None);
        }
        let known = &self.textures[object];
        if known.get().is_none() {
            let limit = Surface::face_varying(context, cage, "uv", &self.scene.surfaces[index].options())?;
            let _ = known.set(limit);
        }
        Ok(known.get().cloned())
    }

    /// The colours of an object's surface; `None` if it is of one colour, or a mesh.
    pub(crate) fn coat(&self, object: usize) -> Option<Coat<'_>> {
        let (Some(entry), Some(Item::Surface(surface))) = (self.scene.objects.get(object), self.items.get(object))
        else {
            return None;
        };
        Coat::new(entry, surface.colors(), surface.traces().map(|traces| traces.field()), surface.time())
    }

    /// Brings all surfaces to `time`: what was edited fades as it should.
    pub(crate) fn advance(&mut self, context: &Context, time: f64) -> Result<()> {
        self.begun.iter().zip(&mut self.items).try_for_each(|(begun, item)| match item {
            Item::Surface(surface) => surface.advance(context, begun + time),
            Item::Triangles(item) => item.object.advance(context, begun + time),
            Item::Mesh(_) => Ok(()),
        })
    }

    /// Notes that all surfaces are at `time`.
    pub(crate) fn set_time(&mut self, time: f64) -> Result<()> {
        self.begun.iter().zip(&mut self.items).try_for_each(|(begun, item)| match item {
            Item::Surface(surface) => surface.set_time(begun + time),
            Item::Triangles(item) => item.object.set_time(begun + time),
            Item::Mesh(_) => Ok(()),
        })
    }

    /// All surfaces.
    pub(crate) fn surfaces_mut(&mut self) -> impl Iterator<Item = &mut DisplacedObject> {
        self.items.iter_mut().filter_map(|item| match item {
            Item::Surface(surface) => Some(&mut **surface),
            Item::Triangles(_) | Item::Mesh(_) => None,
        })
    }

    /// Where the objects are.
    pub fn transforms(&self) -> &[DAffine3] {
        &self.transforms
    }

    /// Smallest and largest coordinates in the world of everything that is visible, at time 0, whatever the time is
    /// now; surfaces count with their cages. `None` if nothing is visible.
    pub fn start_bounds(&self) -> Option<(DVec3, DVec3)> {
        let shown = self.start.iter().enumerate().filter(|(object, _)| self.scene.objects[*object].visible);
        let places = shown.flat_map(|(object, transform)| {
            let points = self.cage(object).points.iter();
            points.map(|point| transform.transform_point3(DVec3::from(point.map(f64::from))))
        });
        places.fold(None, |bounds, place| {
            let (low, high) = bounds.unwrap_or((place, place));
            Some((low.min(place), high.max(place)))
        })
    }

    /// Places the objects.
    ///
    /// # Errors
    /// Fails with `Invalid` if a transform cannot be undone; objects before it are placed then.
    pub fn place(&mut self, transforms: &[DAffine3]) -> Result<()> {
        for (index, transform) in transforms.iter().enumerate().take(self.items.len()) {
            let name = || format!("object `{}`", self.scene.objects[index].name.text);
            let named = |error: Error| error.at(name());
            match &mut self.items[index] {
                Item::Surface(surface) => surface.set_transform(*transform).map_err(named)?,
                Item::Triangles(item) => item.object.set_transform(*transform).map_err(named)?,
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
    ///
    /// # Errors
    /// Fails as [`Assets::points`], and with `Invalid` if a surface or collider has another number of points, or one is
    /// not finite; objects before it are posed then.
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
                Item::Surface(surface) => surface.pose(context, &points)?,
                Item::Triangles(item) => item.object.pose(context, &points)?,
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

    /// A surface to press into and the mesh that presses, as a collider; `None` unless that is what the two are.
    pub fn surface_and_collider(&mut self, into: usize, by: usize) -> Option<(&mut DisplacedObject, &mut Collider)> {
        match (self.items.get_mut(into)?, self.colliders.get_mut(by)?) {
            (Item::Surface(surface), Some(collider)) => Some((surface, collider)),
            _ => None,
        }
    }

    /// The surfaces among the objects `into`, and the meshes among `by` that press, as colliders; both ascending.
    pub(crate) fn surfaces_and_colliders(
        &mut self,
        into: &BTreeSet<usize>,
        by: &BTreeSet<usize>,
    ) -> (Vec<&mut DisplacedObject>, Vec<&mut Collider>) {
        let surfaces = self.items.iter_mut().enumerate().filter_map(|(index, item)| match item {
            Item::Surface(surface) if into.contains(&index) => Some(&mut **surface),
            _ => None,
        });
        let colliders = self.colliders.iter_mut().enumerate().filter(|(index, _)| by.contains(index));
        (surfaces.collect(), colliders.filter_map(|(_, collider)| collider.as_mut()).collect())
    }

    /// The triangle meshes among the objects `into`, and the meshes among `by` that press, as colliders; both ascending.
    pub(crate) fn triangles_and_colliders(
        &mut self,
        into: &BTreeSet<usize>,
        by: &BTreeSet<usize>,
    ) -> (Vec<&mut TriangleObject>, Vec<&mut Collider>) {
        let meshes = self.items.iter_mut().enumerate().filter_map(|(index, item)| match item {
            Item::Triangles(mesh) if into.contains(&index) => Some(&mut mesh.object),
            _ => None,
        });
        let colliders = self.colliders.iter_mut().enumerate().filter(|(index, _)| by.contains(index));
        (meshes.collect(), colliders.filter_map(|(_, collider)| collider.as_mut()).collect())
    }

    /// A triangle mesh to press into and the mesh that presses, as a collider; `None` unless that is what the two are.
    pub(crate) fn triangles_and_collider(
        &mut self,
        into: usize,
        by: usize,
    ) -> Option<(&mut TriangleObject, &mut Collider)> {
        match (self.items.get_mut(into)?, self.colliders.get_mut(by)?) {
            (Item::Triangles(item), Some(collider)) => Some((&mut item.object, collider)),
            _ => None,
        }
    }

    /// Two surfaces, each with the cage whose faces it has; `None` unless both are surfaces, and not the same.
    pub fn two_surfaces(&mut self, a: usize, b: usize) -> Option<[(&mut DisplacedObject, &Mesh); 2]> {
        let cage = |object: usize| Some(self.assets.mesh(self.scene.cage_of(self.scene.objects.get(object)?)));
        let (cage_a, cage_b) = (cage(a)?, cage(b)?);
        match self.items.get_disjoint_mut([a, b]).ok()? {
            [Item::Surface(a), Item::Surface(b)] => Some([(a, cage_a), (b, cage_b)]),
            _ => None,
        }
    }

    /// The points of an object's mesh at `time` seconds if they move.
    ///
    /// # Errors
    /// Fails as [`Assets::points`].
    pub fn moving_points(&mut self, context: &Context, object: usize, time: f64) -> Result<Option<Vec<[f32; 3]>>> {
        if !self.is_object_animated(object) {
            return Ok(None);
        }
        let mesh = self.scene.cage_of(&self.scene.objects[object]);
        self.assets.points(context, mesh, time, self.scene.fps).map(Some)
    }

    /// A number for everything that decides the imprints: the scene without camera, light, colours and outputs, and
    /// the files it reads.
    pub fn fingerprint(&self) -> u64 {
        let scene = &self.scene;
        let objects: Vec<_> = scene
            .objects
            .iter()
            .map(|object| {
                (
                    &object.name,
                    object.geometry,
                    object.placement,
                    object.deformable,
                    object.detail,
                    object.traces.is_some(),
                    object.decay,
                    &object.layers,
                )
            })
            .collect();
        let files: Vec<_> = (0..scene.meshes.len()).map(|mesh| self.assets.checksums(mesh)).collect();
        let painted: Vec<_> = (0..scene.objects.len())
            .filter(|object| scene.is_painted(*object))
            .map(|object| scene.objects[object].colour)
            .collect();
        let documents: Vec<_> = self.documents.iter().map(|document| document.as_ref().map(|(crc, _)| crc)).collect();
        let stamps: Vec<u32> = self.stamps.iter().map(|stamp| stamp.checksum).collect();
        let stickers: Vec<u32> = self.stickers.iter().map(stickers::Loaded::checksum).collect();
        let decisive = (
            (env!("CARGO_PKG_VERSION"), scene.fps, scene.up, scene.seed, scene.physics),
            (&scene.meshes, files, &scene.surfaces, objects, &scene.bodies, &scene.colliders),
            (&scene.strokes, painted, documents),
            (&scene.riders, &scene.stamps, stamps),
            (&scene.decals, stickers),
        );
        let mut text = format!("{decisive:?}");
        if !scene.tissue.is_empty() {
            text.push_str(&format!("{:?}", scene.tissue));
        }
        if !scene.crowd_colliders.is_empty() {
            let model = |entry: &CrowdEntry| (entry.file.clone(), entry.clip.clone(), entry.agents.clone());
            let crowds: Vec<_> = scene.crowds.iter().map(model).collect();
            let files: Vec<_> = self.pressing.iter().map(walking::Pressing::checksums).collect();
            text.push_str(&format!("{:?}", (&scene.crowd_colliders, crowds, files, scene.metres)));
        }
        // FNV-1a of the text of all of it.
        text.bytes()
            .fold(0xcbf2_9ce4_8422_2325, |hash: u64, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3))
    }
}
