//! The world of a scene, loaded: meshes read, surfaces made, documents taken up.

use std::path::PathBuf;
use std::sync::{Arc, OnceLock};

use glam::{DAffine3, Vec3, Vec4};
use relievo_core::{Context, Error, Mesh, Result};
use relievo_detail::{Collider, DecayingObject, DisplacedObject, LayeredObject};
use relievo_document::PageFile;
use relievo_surface::{Surface, SurfaceOptions};
use relievo_tiles::{ChannelOptions, Displacement, DisplacementOptions, Paint, Traces, VectorDisplacement};

use crate::format::description::{ColliderEntry, Geometry, ObjectEntry, Scene, StampSource, TrianglesEntry};
use crate::format::diagnostic::{Diagnostic, Failure, Faults};
use crate::state::assets::Assets;
use crate::state::documents;
use crate::state::paths::Paths;
use crate::state::physics::Physics;
use crate::state::triangles::TriangleItem;
use crate::state::walking;
use crate::state::world::{Item, MeshItem, World};
use crate::state::{stamps, stickers};

impl World {
    /// Loads the meshes of `scene`, from below its folder and the folders `allowed`, and makes its surfaces, at time 0.
    ///
    /// # Errors
    /// Fails with [`Failure::Scene`] if an entry cannot be used, such as a mesh, document, image or crowd that cannot
    /// be read, and with [`Failure::Other`] if the folder of the scene or one of `allowed` does not exist.
    pub fn new(context: &Context, mut scene: Scene, allowed: &[PathBuf]) -> std::result::Result<Self, Failure> {
        let paths = Paths::new(&scene.path, allowed)?;
        let mut assets = context.stats().time("load.meshes", || Assets::load(context, &scene, &paths))?;
        let lowered = choose_isolations(context, &mut scene, &assets)?;
        let refuse = |fault: Diagnostic| Faults {
            name: scene.path.display().to_string(),
            text: scene.text.clone(),
            list: vec![fault],
        };
        let cages: Vec<&Mesh> = scene.objects.iter().map(|object| assets.mesh(scene.cage_of(object))).collect();
        let physics = context.stats().time("load.physics", || Physics::new(&scene, &cages)).map_err(refuse)?;
        let bodies = scene.tissue.iter().map(|entry| {
            let solids = entry.colliders.iter().map(|object| (*object, cages[*object].clone())).collect();
            Physics::new(&scene, &cages).map(|physics| (physics, solids))
        });
        let bodies = bodies.collect::<std::result::Result<Vec<_>, _>>().map_err(refuse)?;
        context.stats().time("load.tissue", || assets.meet(context, &scene, bodies)).map_err(refuse)?;
        let transforms = physics.transforms();
        let (mut items, mut documents) = (Vec::new(), Vec::new());
        for (object, transform) in scene.objects.iter().zip(&transforms) {
            let transform = *transform;
            let mesh = assets.mesh(scene.cage_of(object));
            let document = object.document.as_ref().map(|name| {
                let opened = context.stats().time("load.documents", || documents::open(context, &paths, &name.text));
                opened.map_err(|error| refuse(Diagnostic::from_error(name.span.clone(), &error)))
            });
            let mut document = document.transpose()?;
            let item = match object.geometry {
                Geometry::Mesh(_) => Ok(Item::Mesh(Box::new(MeshItem { mesh: mesh.clone(), transform }))),
                Geometry::Surface(index) => {
                    let entry = &scene.surfaces[index];
                    if let Some(triangles) = &entry.triangles {
                        let fault = |error: Error| refuse(Diagnostic::from_error(entry.name.span.clone(), &error));
                        check_triangles(object, triangles, assets.is_animated(entry.mesh)).map_err(&fault)?;
                        let color = Vec3::from(object.colour).extend(1.0);
                        let paint = scene.is_painted(items.len()).then_some(color);
                        let bent = scene.is_bent(items.len());
                        let item = TriangleItem::new(context, mesh, triangles, &object.detail, paint, bent, transform);
                        let mut item = item.map_err(&fault)?;
                        if let (Some(start), Some(name)) = (&mut document, &object.document) {
                            start
                                .fit_triangles(item.cage.as_ref().unwrap_or(mesh))
                                .and_then(|()| start.take_up(context, &mut item.object, object.detail.budget))
                                .map_err(|error| refuse(Diagnostic::from_error(name.span.clone(), &error)))?;
                        }
                        for layer in &object.layers {
                            layer
                                .make_fading(context, &mut item.object, object.detail.segments, object.detail.budget)
                                .map_err(|error| refuse(Diagnostic::from_error(layer.name.span.clone(), &error)))?;
                        }
                        item.keep(object).map_err(fault)?;
                        items.push(Item::Triangles(Box::new(item)));
                        documents.push(document.map(|start| (start.checksum, start.notes)));
                        continue;
                    }
                    let options = entry.options();
                    let detail = DisplacementOptions {
                        size: object.detail.tile_size,
                        budget: object.detail.budget,
                        ..Default::default()
                    };
                    // Colours are those of the object where nothing is painted.
                    let paint = scene.is_painted(items.len()).then(|| {
                        let options = ChannelOptions { size: object.detail.paint_size, ..detail.clone() };
                        (object.detail.halves, Vec3::from(object.colour).extend(1.0), options)
                    });
                    let fault = |error: Error| refuse(Diagnostic::from_error(entry.name.span.clone(), &error));
                    make_surface(context, mesh, &options, &detail, paint, transform).map_err(fault).and_then(
                        |mut item| {
                            if object.detail.page {
                                item.page_to(Some(Arc::new(PageFile::new(None)))).map_err(&fault)?;
                            }
                            if let (Some(start), Some(name)) = (&mut document, &object.document) {
                                start
                                    .fit(mesh)
                                    .and_then(|()| start.take_up(context, &mut item, object.detail.budget))
                                    .map_err(|error| refuse(Diagnostic::from_error(name.span.clone(), &error)))?;
                            }
                            if scene.is_bent(items.len()) && item.vectors().is_none() {
                                let vectors = VectorDisplacement::on(item.surface(), &detail);
                                vectors.and_then(|vectors| item.set_vectors(vectors)).map_err(fault)?;
                            }
                            for layer in &object.layers {
                                layer
                                    .make_fading(context, &mut item, layer.size, object.detail.budget)
                                    .map_err(|error| refuse(Diagnostic::from_error(layer.name.span.clone(), &error)))?;
                            }
                            if let Some(decay) = object.decay {
                                item.set_decay(decay, object.detail.budget).map_err(fault)?;
                            }
                            if object.traces.is_some() && item.traces().is_none() {
                                let traces = Traces::of(item.displacement().field(), object.detail.budget);
                                traces.and_then(|traces| item.set_traces(traces)).map_err(fault)?;
                            }
                            Ok(Item::Surface(Box::new(item)))
                        },
                    )
                }
            };
            items.push(item?);
            documents.push(document.map(|start| (start.checksum, start.notes)));
        }
        let mut colliders: Vec<Option<Collider>> = items.iter().map(|_| None).collect();
        for entry in &scene.colliders {
            let fault = |error: Error| refuse(Diagnostic::from_error(entry.name.span.clone(), &error));
            check_collider(entry, &items).map_err(fault)?;
            let (Some(Item::Mesh(item)), Some(slot)) = (items.get(entry.object), colliders.get_mut(entry.object))
            else {
                continue;
            };
            let collider = match slot {
                Some(collider) => collider,
                None => slot.insert(Collider::of_mesh(context, &item.mesh, item.transform).map_err(fault)?),
            };
            if entry.tool.is_some() && !collider.is_closed() {
                let error = Error::invalid("the tool has open edges and so no volume")
                    .advise("use a closed mesh; `relievo mesh repair FILE -o FILE` closes holes");
                return Err(fault(error).into());
            }
        }
        let stamps = scene.stamps.iter().map(|entry| {
            let span = match &entry.source {
                StampSource::File(file) => file.span.clone(),
                StampSource::Pattern(_) => entry.name.span.clone(),
            };
            let loaded = context.stats().time("load.stamps", || stamps::Loaded::new(context, &paths, entry));
            loaded.map_err(|error| refuse(Diagnostic::from_error(span, &error)))
        });
        let stamps = stamps.collect::<std::result::Result<_, _>>()?;
        let stickers = scene.decals.iter().map(|entry| {
            let loaded = context.stats().time("load.decals", || stickers::Loaded::new(context, &paths, entry));
            loaded.map_err(|error| refuse(Diagnostic::from_error(entry.image.span.clone(), &error)))
        });
        let stickers = stickers.collect::<std::result::Result<_, _>>()?;
        let crowds = scene.crowds.iter().map(|entry| {
            let loaded = context.stats().time("load.crowds", || walking::Loaded::new(context, &paths, &scene, entry));
            loaded.map_err(|error| refuse(Diagnostic::from_error(entry.file.span.clone(), &error)))
        });
        let crowds = crowds.collect::<std::result::Result<Vec<_>, _>>()?;
        let pressing = scene.crowd_colliders.iter().map(|entry| {
            let fault = |error: Error| refuse(Diagnostic::from_error(entry.name.span.clone(), &error));
            let crowd = (&crowds[entry.crowd], &scene.crowds[entry.crowd]);
            walking::Pressing::new(context, &paths, crowd, entry).map_err(fault)
        });
        let pressing = pressing.collect::<std::result::Result<_, _>>()?;
        let start = transforms.clone();
        let begun = items.iter().map(|item| match item {
            Item::Surface(surface) => surface.time(),
            Item::Triangles(item) => item.object.time(),
            Item::Mesh(_) => 0.0,
        });
        let begun = begun.collect();
        Ok(Self {
            begun,
            stamps,
            stickers,
            crowds,
            pressing,
            physics,
            assets,
            items,
            colliders,
            documents,
            lowered,
            transforms,
            start,
            textures: vec![OnceLock::new(); scene.objects.len()],
            scene,
            time: 0.0,
            on_device: false,
        })
    }
}

/// Fails if an object shows triangles whose points move and which are to be split.
fn check_triangles(object: &ObjectEntry, entry: &TrianglesEntry, animated: bool) -> Result<()> {
    if !animated || entry.longest_edge.is_none() {
        return Ok(());
    }
    let name = &object.name.text;
    Err(Error::unsupported(format!("object `{name}` shows triangles and is animated and to be split"))
        .advise("remove `longest_edge`"))
}

/// Fails if surfaces of triangles are to take part in imprints in a way that they cannot.
fn check_collider(entry: &ColliderEntry, items: &[Item]) -> Result<()> {
    let is_triangles = |object: &usize| matches!(items.get(*object), Some(Item::Triangles(_)));
    if is_triangles(&entry.object) {
        return Err(Error::unsupported("a surface of triangles cannot press").advise("give the object its `mesh`"));
    }
    if !entry.into.iter().any(is_triangles) {
        return Ok(());
    }
    let rigid = matches!(items.get(entry.object), Some(Item::Mesh(_)));
    let unfit = [
        (!rigid, "a surface cannot press into triangles", "press with a `mesh`"),
        (entry.tool.is_some(), "a force cannot press into triangles", "remove `tool`"),
    ];
    match unfit.into_iter().find(|(unfit, ..)| *unfit) {
        Some((_, what, remedy)) => Err(Error::unsupported(what).advise(remedy)),
        None => Ok(()),
    }
}

/// Chooses the isolation of the surfaces that name none. Returns notes about those for which the default is too much.
fn choose_isolations(
    context: &Context,
    scene: &mut Scene,
    assets: &Assets,
) -> std::result::Result<Vec<String>, Failure> {
    let mut notes = Vec::new();
    for index in 0..scene.surfaces.len() {
        let entry = &scene.surfaces[index];
        let used = scene.objects.iter().any(|object| object.geometry == Geometry::Surface(index));
        if !used || entry.triangles.is_some() || entry.isolation.is_some() {
            continue;
        }
        let (mesh, options) = (assets.mesh(entry.mesh), entry.options());
        let chosen = Surface::choose_isolation(context, mesh, &options, None);
        let (options, note) = chosen.map_err(|error| Faults {
            name: scene.path.display().to_string(),
            text: scene.text.clone(),
            list: vec![Diagnostic::from_error(entry.name.span.clone(), &error)],
        })?;
        notes.extend(note.map(|note| format!("surface `{}`: {note}", entry.name.text)));
        scene.surfaces[index].isolation = Some(options.isolation);
    }
    Ok(notes)
}

fn make_surface(
    context: &Context,
    mesh: &Mesh,
    options: &SurfaceOptions,
    detail: &DisplacementOptions,
    paint: Option<(bool, Vec4, ChannelOptions)>,
    transform: DAffine3,
) -> Result<DisplacedObject> {
    let surface = Surface::new(context, mesh, options)?;
    let displacement = Displacement::new(surface.topology().clone(), detail)?;
    let topology = surface.topology().clone();
    let mut object = DisplacedObject::new(context, surface, &mesh.points, displacement, transform)?;
    match paint {
        Some((true, color, options)) => object.set_half_paint(Paint::of_color(topology, color, &options)?)?,
        Some((false, color, options)) => object.set_paint(Paint::of_color(topology, color, &options)?)?,
        None => {}
    }
    Ok(object)
}
