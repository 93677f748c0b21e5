//! Pictures of a world: what changed since the last frame is tessellated and handed to the ray caster, or handed to a
//! graphics device that draws surfaces as it has them, then the views the scene asks for are rendered.

use glam::{DAffine3, DVec3};
use relievo_core::{Context, Error, Result};
use relievo_gpu::Device;
use relievo_render as render;
use relievo_render::virtual_vertex;
use relievo_tiles::triangle::TriangleBlock;

use crate::format::description::{CameraEntry, Scene, View};
use crate::format::placement::Up;
use crate::out::output::Folder;
use crate::out::tessellation::{self, Rates};
use crate::run::foam::Overlay;
use crate::run::simulate::Change;
use crate::state::coat::Coat;
use crate::state::triangles;
use crate::state::walking;
use crate::state::world::{Item, World};

/// What a world is drawn by.
enum Stage {
    Rays(render::Scene),
    Device(Box<virtual_vertex::Stage>),
}

/// The view of a world.
pub struct Studio {
    stage: Stage,
    objects: Vec<Shown>,
    automatic: View,
    overlay: Overlay,
    crowds: Vec<walking::Shown>,
}

struct Shown {
    id: Option<render::ObjectId>,
    drawn: bool,
    rates: Option<Rates>,
    /// Tiles that are shown as just changed.
    recent: Vec<u32>,
}

impl std::fmt::Debug for Studio {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        out.debug_struct("Studio").field("objects", &self.objects.len()).finish_non_exhaustive()
    }
}

/// Tags of triangles: what the false colours of tiles tell apart.
const TAGS: [(&str, u32); 4] =
    [("untouched", 0xBBBBBB), ("allocated", 0x56B4E9), ("changed in this frame", 0xE69F00), ("rigid", 0x555555)];
const UNTOUCHED: u32 = 0;
const ALLOCATED: u32 = 1;
const CHANGED: u32 = 2;
const RIGID: u32 = 3;

impl Studio {
    /// A view of `world` in which nothing is drawn before [`Self::update`]: by `device`, or by the ray caster, which
    /// draws all scenes with crowds. Frames of foam are kept in `cache`.
    ///
    /// # Errors
    /// Fails with `Invalid` if a transform is singular, foam is to be made of a mesh that is no sequence of files, or a
    /// setting of foam or an agent of a crowd cannot be used; with `NotFound` or `Io` if the folder for foam cannot be
    /// made; with `Device` or `Memory` if the device is lost or has no memory; and without a device with `NotFound` or
    /// `Unsupported` if Embree is missing or of another version.
    pub fn new(context: &Context, world: &World, device: Option<&Device>, cache: &Folder) -> Result<Self> {
        let device = device.filter(|_| world.crowds().is_empty());
        let mut studio = Self {
            stage: match device {
                Some(device) => Stage::Device(Box::new(virtual_vertex::Stage::new(device)?)),
                None => Stage::Rays(render::Scene::new()?),
            },
            objects: Vec::new(),
            automatic: automatic_view(&world.scene, world.start_bounds()),
            overlay: Overlay::new(context, world, device, cache)?,
            crowds: world.crowds().iter().map(walking::Shown::new).collect::<Result<_>>()?,
        };
        for (index, item) in world.items().iter().enumerate() {
            let entry = &world.scene.objects[index];
            let mut shown = Shown { id: None, drawn: false, rates: None, recent: Vec::new() };
            if entry.visible {
                let base_color = entry.colour.map(|value| value.min(1.0));
                let (specular, roughness) = (entry.specular, entry.roughness);
                let material = render::Material { base_color, specular, roughness };
                let transform = match item {
                    Item::Surface(surface) => *surface.transform(),
                    Item::Triangles(item) => *item.object.transform(),
                    Item::Mesh(item) => item.transform,
                };
                let id = studio.stage.add_object(transform, material)?;
                if let Stage::Rays(scene) = &mut studio.stage {
                    scene.set_dielectric(id, entry.dielectric)?;
                }
                shown.id = Some(id);
            }
            studio.objects.push(shown);
        }
        Ok(studio)
    }

    /// Returns what the user should know of the pictures since the last call.
    pub fn take_notes(&mut self) -> Vec<String> {
        self.overlay.take_notes()
    }

    /// Takes over what changed of every object; what was not drawn yet is drawn as a whole.
    ///
    /// # Errors
    /// Fails with `Invalid` if a transform is singular or the particles of a fluid cannot be used, with `Memory` if
    /// memory does not suffice, and with `Device` if the device is lost.
    pub fn update(&mut self, context: &Context, world: &World, changes: &[Change]) -> Result<()> {
        let mut stage = context.stats().begin("tessellate");
        let mut count = 0;
        let tagged = world.scene.output.pictures.contains(&"tiles");
        for (index, item) in world.items().iter().enumerate() {
            let Some(id) = self.objects[index].id else { continue };
            let change = changes.get(index);
            let changed = change.map_or(&[][..], |change| &change.tiles);
            let drawn = std::mem::replace(&mut self.objects[index].drawn, true);
            let whole = !drawn || change.is_none_or(|change| change.posed);
            match item {
                Item::Surface(surface) => {
                    self.stage.set_transform(id, *surface.transform())?;
                    let displaced = surface.displaced()?;
                    let coat = world.coat(index);
                    let rates = Rates::new(&displaced, coat.as_ref(), world.scene.output.rate, u32::MAX);
                    let field = displaced.field();
                    let topology = field.topology();
                    let before = self.objects[index].rates.replace(rates.clone());
                    let tags = if tagged { changed.to_vec() } else { Vec::new() };
                    let recent = std::mem::replace(&mut self.objects[index].recent, tags);
                    let fading: Vec<u32> = coat.iter().flat_map(Coat::fading).collect();
                    let stale = |tile: u32| match &before {
                        Some(before) if !whole => {
                            changed.binary_search(&tile).is_ok()
                                || recent.binary_search(&tile).is_ok()
                                || fading.binary_search(&tile).is_ok()
                                || before.of(tile) != rates.of(tile)
                                || before.edges(topology, tile) != rates.edges(topology, tile)
                        }
                        _ => true,
                    };
                    let tag = |tile: u32| {
                        let changed = changed.binary_search(&tile).is_ok();
                        let painted = coat.is_some_and(|coat| coat.size(tile).is_some());
                        match (field.is_allocated(tile) || painted, changed) {
                            (true, true) => CHANGED,
                            (true, false) => ALLOCATED,
                            (false, _) => UNTOUCHED,
                        }
                    };
                    if let Stage::Device(stage) = &mut self.stage {
                        // One quad per texel, as far as a draw can have them.
                        let most = 1 << virtual_vertex::MAX_POWER;
                        let power = |tile: u32| rates.of(tile).min(most).trailing_zeros() as u8;
                        let powers = (0..field.tile_count() as u32).map(power).collect();
                        let divided = virtual_vertex::TileRates::new(topology, powers)?;
                        stage.set_surface(
                            context,
                            id,
                            (&displaced, Coat::drawn(coat.as_ref())),
                            whole,
                            divided,
                            tag,
                        )?;
                        continue;
                    }
                    let tiles: Vec<u32> = (0..field.tile_count() as u32).filter(|tile| stale(*tile)).collect();
                    let pieces = context.map(tiles.len(), |at| {
                        tessellation::tile(context, &displaced, coat.as_ref(), &rates, tiles[at])
                    });
                    for (tile, piece) in tiles.iter().zip(pieces) {
                        let piece = piece?;
                        count += piece.triangles.len() as u64;
                        let tags = vec![tag(*tile); piece.triangles.len()];
                        let mesh = render::Mesh {
                            points: piece.points,
                            triangles: piece.triangles,
                            normals: piece.normals,
                            colors: piece.colors,
                            tags,
                            edges: piece.edges,
                        };
                        self.stage.set_mesh(id, *tile, mesh)?;
                    }
                }
                Item::Triangles(item) => {
                    let object = &item.object;
                    self.stage.set_transform(id, *object.transform())?;
                    let tags = if tagged { changed.to_vec() } else { Vec::new() };
                    let recent = std::mem::replace(&mut self.objects[index].recent, tags);
                    let topology = object.surface().topology();
                    let fresh = TriangleBlock::change(topology, changed.iter().copied()).faces;
                    let tag = |face: u32| match (object.is_allocated(face), fresh.binary_search(&face).is_ok()) {
                        (true, true) => CHANGED,
                        (true, false) => ALLOCATED,
                        (false, _) => UNTOUCHED,
                    };
                    if let Stage::Device(stage) = &mut self.stage {
                        let coat = triangles::coat(object, &world.scene.objects[index]);
                        let shown = (&object.displaced()?, object.normals(), coat);
                        let stale = (!whole).then(|| triangles::stale_faces(object, changed));
                        stage.set_triangles(context, id, shown, stale.as_deref(), tag)?;
                        continue;
                    }
                    let stale: Vec<u32> = match whole {
                        true => (0..triangles::part_count(object)).collect(),
                        false => {
                            let mut parts = triangles::stale_parts(object, changed);
                            parts.extend(triangles::stale_parts(object, &recent));
                            parts.extend(triangles::fading_parts(object, &world.scene.objects[index]));
                            parts.sort_unstable();
                            parts.dedup();
                            parts
                        }
                    };
                    let parts = context
                        .map(stale.len(), |at| triangles::part(object, &world.scene.objects[index], stale[at], tag));
                    for (part, mesh) in stale.iter().zip(parts) {
                        let mesh = mesh?;
                        count += mesh.triangles.len() as u64;
                        self.stage.set_mesh(id, *part, mesh)?;
                    }
                }
                Item::Mesh(item) => {
                    self.stage.set_transform(id, item.transform)?;
                    if !whole {
                        continue;
                    }
                    let entry = &world.scene.objects[index];
                    if let Some(fluid) = &entry.fluid {
                        let named = |error: Error| error.at(format!("object `{}`", entry.name.text));
                        if let (Stage::Rays(scene), None) = (&mut self.stage, fluid.cell) {
                            let implicit = fluid.implicit(context, &item.mesh.points).map_err(named)?;
                            scene.set_implicit(id, Some(implicit))?;
                            continue;
                        }
                        let mesh = fluid.mesh(context, &item.mesh.points).map_err(named)?;
                        count += mesh.face_count() as u64;
                        let tags = vec![RIGID; mesh.face_count()];
                        self.stage.set_mesh(id, 0, render::Mesh { tags, ..render::Mesh::of_tessellation(mesh) })?;
                        continue;
                    }
                    let triangles = item.mesh.triangles();
                    count += triangles.len() as u64;
                    let tags = vec![RIGID; triangles.len()];
                    let mesh =
                        render::Mesh { points: item.mesh.points.clone(), triangles, tags, ..render::Mesh::default() };
                    self.stage.set_mesh(id, 0, mesh)?;
                }
            }
        }
        stage.count("triangles", count);
        Ok(())
    }

    /// Renders `kind`, one of the scene's pictures, at `time` seconds.
    ///
    /// # Errors
    /// Fails with `Invalid` if the camera has no direction of view or a setting of the view is out of range, with
    /// `Memory` if the picture does not fit the memory limit, with `Device` if the device is lost, and with `NotFound`,
    /// `Io` or `Invalid` if a file of a fluid, or a frame of its foam, cannot be read or written.
    pub fn render(&mut self, context: &Context, world: &World, kind: &str, time: f64) -> Result<render::Frame> {
        let scene = &world.scene;
        let mut view = render::View::new(camera(world, &self.automatic, time)?);
        view.settings = scene.output.settings;
        view.lights = lights(scene);
        match kind {
            "wireframe" => view.settings.wireframe = relievo_core::parameter::Switch::ON,
            "tiles" => {
                let palette = TAGS.iter().map(|(_, hex)| render::color::from_hex(*hex)).collect();
                view.false_color = Some(render::FalseColor { palette });
            }
            _ => {}
        }
        if let Stage::Rays(picture) = &mut self.stage {
            let mut stage = context.stats().begin("crowds");
            for ((shown, loaded), entry) in self.crowds.iter_mut().zip(world.crowds()).zip(&scene.crowds) {
                let drawn = shown.draw(context, (loaded, entry), (&view, time), RIGID, picture)?;
                stage.count("triangles", drawn);
            }
        }
        let mut frame = context.stats().time("render", || self.stage.render(context, &view))?;
        if kind == "beauty" && !self.overlay.is_empty() {
            let number = (time * scene.fps).round() as usize;
            self.draw_foam(context, world, (&view, number), &mut frame)?;
        }
        if kind == "tiles" {
            let entries = TAGS.map(|(text, hex)| (render::color::from_hex(hex), text));
            render::draw_legend(&mut frame.color, &entries);
        }
        Ok(frame)
    }
}

impl Studio {
    /// Lays the foam of fluids at a frame of the scene over its picture.
    fn draw_foam(
        &mut self,
        context: &Context,
        world: &World,
        (view, number): (&render::View, usize),
        frame: &mut render::Frame,
    ) -> Result<()> {
        let ids: Vec<_> = self.objects.iter().map(|shown| shown.id).collect();
        let fluids = world.scene.objects.iter().zip(&ids).filter(|(entry, _)| entry.fluid.is_some());
        let fluids: Vec<_> = fluids.filter_map(|(_, id)| *id).collect();
        let solids = match &mut self.stage {
            Stage::Rays(scene) => scene.render_without(context, &fluids, &view.for_depths())?.depth,
            // A device draws all objects at once, so solids behind a fluid are left out.
            Stage::Device(_) => {
                let mut depth = frame.depth.clone();
                for (value, seen) in depth.data_mut().iter_mut().zip(&frame.object) {
                    if fluids.iter().any(|id| id.number() == *seen) {
                        *value = f32::INFINITY;
                    }
                }
                depth
            }
        };
        self.overlay.draw(context, (view, number), &ids, &solids, frame)
    }
}

impl Stage {
    fn add_object(&mut self, transform: DAffine3, material: render::Material) -> Result<render::ObjectId> {
        match self {
            Self::Rays(scene) => scene.add_object(transform, material),
            Self::Device(stage) => Ok(stage.add_object(transform, material)),
        }
    }

    fn set_transform(&mut self, id: render::ObjectId, transform: DAffine3) -> Result<()> {
        match self {
            Self::Rays(scene) => scene.set_transform(id, transform),
            Self::Device(stage) => stage.set_transform(id, transform),
        }
    }

    fn set_mesh(&mut self, id: render::ObjectId, number: u32, mesh: render::Mesh) -> Result<()> {
        match self {
            Self::Rays(scene) => scene.set_mesh(id, number, mesh),
            Self::Device(stage) => stage.set_mesh(id, number, &mesh),
        }
    }

    fn render(&mut self, context: &Context, view: &render::View) -> Result<render::Frame> {
        match self {
            Self::Rays(scene) => scene.render(context, view),
            Self::Device(stage) => stage.render(view),
        }
    }
}

/// The camera of `world` at `time` seconds. Where the scene does not say, it looks as `automatic` does.
pub(crate) fn camera(world: &World, automatic: &View, time: f64) -> Result<render::Camera> {
    let entry = &world.scene.camera;
    let view = view_at(entry, time);
    let shift = entry.follow.and_then(|object| world.items().get(object)).map_or(DVec3::ZERO, |item| match item {
        Item::Surface(surface) => surface.transform().translation,
        Item::Triangles(item) => item.object.transform().translation,
        Item::Mesh(item) => item.transform.translation,
    });
    // Without a place of its own the camera looks from the automatic direction, at a given target too.
    let (place, middle) = (automatic.position.unwrap_or(DVec3::ONE), automatic.target.unwrap_or(DVec3::ZERO));
    let target = view.target.map_or(middle, |target| target + shift);
    let position = view.position.map_or(target + (place - middle), |position| position + shift);
    let up = world.scene.up.direction();
    // Straight from above the up direction says nothing.
    let along = (target - position).normalize_or_zero().dot(up).abs() > 1.0 - 1e-9;
    let up = if along { up.any_orthogonal_vector() } else { up };
    render::Camera::look_at(position, target, up, view.fov)
}

/// The camera at `time`: positions follow a cubic through the keyframes, so that it does not jerk.
fn view_at(entry: &CameraEntry, time: f64) -> View {
    let views = &entry.views;
    let after = views.partition_point(|view| view.time <= time);
    let at = |index: usize| views.get(index).or(views.last());
    let (Some(before), Some(next)) = (after.checked_sub(1).and_then(at), views.get(after)) else {
        let none = View { time, position: None, target: None, fov: 0.7 };
        return views.get(after).or(views.last()).copied().unwrap_or(none);
    };
    let share = (time - before.time) / (next.time - before.time);
    let early = after.checked_sub(2).and_then(at).unwrap_or(before);
    let late = at(after + 1).unwrap_or(next);
    let blend = |pick: fn(&View) -> Option<DVec3>| {
        let (a, b) = (pick(before)?, pick(next)?);
        let slope = |from: &View, to: &View| match (pick(from), pick(to)) {
            (Some(p), Some(q)) if to.time > from.time => (q - p) / (to.time - from.time),
            _ => DVec3::ZERO,
        };
        let span = next.time - before.time;
        let (out, into) = (slope(early, next) * span, slope(before, late) * span);
        let (s, s2, s3) = (share, share * share, share * share * share);
        let hermite = a * (2.0 * s3 - 3.0 * s2 + 1.0) + out * (s3 - 2.0 * s2 + s) + b * (3.0 * s2 - 2.0 * s3);
        Some(hermite + into * (s3 - s2))
    };
    View {
        time,
        position: blend(|view| view.position),
        target: blend(|view| view.target),
        fov: before.fov + (next.fov - before.fov) * share,
    }
}

/// A view from the front, the side and above that sees everything within `bounds`. They must not depend on the frame
/// that is drawn first, or runs of other frames would show other views.
pub(crate) fn automatic_view(scene: &Scene, bounds: Option<(DVec3, DVec3)>) -> View {
    let fov = scene.camera.views.first().map_or(0.7, |view| view.fov);
    let settings = &scene.output.settings;
    let aspect = f64::from(settings.width) / f64::from(settings.height);
    let (position, target) = whole_view(bounds, fov, aspect, scene.up);
    View { time: 0.0, position: Some(position), target: Some(target), fov }
}

/// From where, and to where, a camera sees all that is within `bounds`; `aspect` is the width of its picture by its
/// height.
pub fn whole_view(bounds: Option<(DVec3, DVec3)>, fov: f64, aspect: f64, up: Up) -> (DVec3, DVec3) {
    let (target, radius) =
        bounds.map_or((DVec3::ZERO, 1.0), |(low, high)| ((low + high) * 0.5, ((high - low) * 0.5).length()));
    // The narrower of both fields of view holds the sphere around everything, whose rim is mostly empty.
    let narrow = ((fov * 0.5).tan() * aspect.min(1.0)).atan();
    let distance = (radius / narrow.sin()).max(1e-6) * 0.92;
    let direction = up.from_z_up([0.55, -0.75, 0.36]).map(f64::from);
    (target + DVec3::from(direction).normalize() * distance, target)
}

/// What lights a scene.
pub(crate) fn lights(scene: &Scene) -> render::Lights {
    let sun = render::Sun {
        direction: scene.sun.direction.as_vec3().to_array(),
        irradiance: scene.sun.radiance,
        angular_radius: (scene.sun.angle * 0.5) as f32,
    };
    let sky = render::Sky {
        up: scene.up.direction().as_vec3().to_array(),
        zenith: scene.sky.zenith,
        horizon: scene.sky.horizon,
        ground: scene.sky.ground,
    };
    render::Lights { suns: vec![sun], sky }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_camera_passes_its_keyframes_and_rests_outside() {
        let view =
            |time: f64, x: f64| View { time, position: Some(DVec3::X * x), target: Some(DVec3::Y), fov: 0.5 + x };
        let entry = CameraEntry { views: vec![view(1.0, 0.0), view(2.0, 1.0), view(4.0, 2.0)], follow: None };
        for (time, x) in [(0.0, 0.0), (1.0, 0.0), (2.0, 1.0), (4.0, 2.0), (9.0, 2.0)] {
            let at = view_at(&entry, time);
            assert!((at.position.unwrap().x - x).abs() < 1e-12 && (at.fov - 0.5 - x).abs() < 1e-12, "{time}");
        }
        let speed = |time: f64| {
            let x = |time: f64| view_at(&entry, time).position.unwrap().x;
            (x(time + 1e-6) - x(time)) / 1e-6
        };
        assert!((speed(2.0 - 2e-6) - speed(2.0)).abs() < 1e-4);
    }
}

#[cfg(all(test, feature = "fluid"))]
mod foam {
    use std::path::Path;

    use relievo_particleio::{Channel, Particles, write};

    use super::*;
    use crate::format::file::parse;

    /// Two blocks of water that run into each other, in two frames. The lens and the shutter blur their foam.
    fn write_scene(context: &Context, folder: &Path, look: &str) -> World {
        let blocks = |frame: usize| {
            let side = |at: usize| 0.05 * at as f32;
            let places = (0..1024).map(|at| [side(at % 16), side(at / 16 % 8), side(at / 128)]);
            let (points, ways): (Vec<_>, Vec<_>) = places
                .map(|[x, y, z]| {
                    let way = if x < 0.4 { 4.0 } else { -4.0 };
                    ([x + way * frame as f32 / 96.0, y, z], [way, 0.0, 0.5])
                })
                .unzip();
            let channels = vec![Channel { name: "velocity".into(), width: 3, values: ways.concat() }];
            Particles { points, channels, ..Particles::default() }
        };
        (0..3).for_each(|frame| write(context, &folder.join(format!("{frame}.ply")), &blocks(frame)).unwrap());
        let text = format!(
            "version = 1\n[meshes.water]\nsequence = \"%d.ply\"\ncount = 3\n[objects.water]\nmesh = \"water\"\n\
             [camera]\nposition = [1.2, -1.6, 1.2]\ntarget = [0.4, 0.2, 0.2]\n[output]\nwidth = 96\nheight = 72\n\
             [objects.water.fluid]\nspacing = 0.05\ncell = 1.0\n[objects.water.fluid.foam]\nair_min = 0.5\nair_max = 5\n\
             energy_min = 0.5\nenergy_max = 5\nair_rate = 300\n[objects.water.fluid.foam.look]\nradius = 0.03\n{look}"
        );
        World::new(context, parse(&folder.join("scene.toml"), &text).unwrap(), &[]).unwrap()
    }

    #[test]
    fn a_device_draws_the_foam_of_a_scene_as_the_processor_does() {
        let Some(device) = relievo_testing::device() else { return };
        let context = &Context::serial();
        let folder = tempfile::tempdir().unwrap();
        for look in ["", "aperture = 0.08\nfocus = 1.2\nshutter = 0.02\n"] {
            let world = write_scene(context, folder.path(), look);
            let cache = Folder::new(&folder.path().join("cache")).unwrap();
            let mut studio = Studio::new(context, &world, None, &cache).unwrap();
            studio.update(context, &world, &[]).unwrap();
            let mut draw = |overlay| {
                studio.overlay = overlay;
                studio.render(context, &world, "beauty", 2.0 / world.scene.fps).unwrap().color
            };
            let without = draw(Overlay::default());
            let [ours, theirs] =
                [Some(&device), None].map(|device| draw(Overlay::new(context, &world, device, &cache).unwrap()));
            let far = |a: &render::Image, b: &render::Image| {
                let pairs = a.data().chunks(3).zip(b.data().chunks(3));
                pairs.filter(|(a, b)| a.iter().zip(*b).any(|(a, b)| (a - b).abs() > 1.0 / 255.0)).count()
            };
            let drawn = far(&theirs, &without);
            assert!(drawn > 300, "{look}: foam is in {drawn} pixels");
            assert!(far(&ours, &theirs) <= 96 * 72 / 1000, "{look}: {} pixels differ", far(&ours, &theirs));
        }
    }
}
