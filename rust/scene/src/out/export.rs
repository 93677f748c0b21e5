//! The files of a frame: displaced meshes, tiles as EXR, pictures.

use std::path::PathBuf;

use glam::{DAffine3, DVec3, Vec3};
use relievo_core::{Attribute, Context, Domain, Mesh, Result, Values};
use relievo_detail::{DisplacedObject, LayeredObject};
use relievo_meshio::Instance;
use relievo_render::{Channel, Content, Layer, Samples, Value, write_exr};
use relievo_tiles::triangle::{FaceRates, TriangleTessellation};
use relievo_tiles::{Mark, Tessellation, by_format};

use crate::format::description::{ObjectEntry, TintEntry};
use crate::format::placement::Up;
use crate::out::output::Folder;
use crate::out::stages::{Division, STAGE, Stages};
use crate::out::tessellation::Rates;
use crate::state::triangles::TriangleItem;
use crate::state::world::{Item, World};

/// The name of an object, the names of its materials, its mesh in its own space, and where it is.
pub(crate) type Shown<'a> = (&'a str, &'a [String], Mesh, DAffine3);

/// The mesh that an object shows: that of the surface, where its points are a fluid.
pub(crate) fn shown_mesh(context: &Context, entry: &ObjectEntry, mesh: &Mesh) -> Result<Mesh> {
    match &entry.fluid {
        Some(fluid) => {
            fluid.mesh(context, &mesh.points).map_err(|error| error.at(format!("object `{}`", entry.name.text)))
        }
        None => Ok(mesh.clone()),
    }
}

/// The meshes of all visible objects, divided as `stages` says or as their tiles are now.
pub(crate) fn shown<'a>(context: &Context, world: &'a World, stages: Option<&Stages>) -> Result<Vec<Shown<'a>>> {
    let scene = &world.scene;
    let mut list: Vec<Shown> = Vec::new();
    for (index, item) in world.items().iter().enumerate().filter(|(index, _)| scene.objects[*index].visible) {
        let name = scene.objects[index].name.text.as_str();
        let materials = world.materials(index);
        let division = stages.and_then(|stages| stages.division(index));
        list.push(match item {
            Item::Mesh(item) => {
                let mesh = shown_mesh(context, &scene.objects[index], &item.mesh)?;
                (name, materials, mesh, item.transform)
            }
            Item::Triangles(item) => {
                let mesh = match division {
                    Some(Division::Faces(rates)) => {
                        let rates = |face: u32| rates.get(face as usize).copied().unwrap_or(FaceRates::SINGLE);
                        divided_triangles(context, world, index, item, rates)?
                    }
                    _ => triangle_mesh(context, world, index, item)?,
                };
                (name, materials, mesh, *item.object.transform())
            }
            Item::Surface(surface) => {
                let mesh = match division {
                    Some(Division::Tiles(rates)) => divided(context, world, index, surface, rates)?.mesh,
                    _ => displaced_mesh(context, world, index, surface)?,
                };
                (name, materials, mesh, *surface.transform())
            }
        });
    }
    Ok(list)
}

/// Writes the meshes of all visible objects in the formats the scene asks for: GLB as one file with y up, OBJ and PLY
/// one file per object in world space. Returns the files. A stage in USD is written when all frames are done.
///
/// # Errors
/// Fails with `Invalid` if a mesh does not pass [`Mesh::check`], as that of a fluid without particles, or no object is
/// visible for GLB; with `Memory` if a mesh would have 2³² corners or points, or that of a fluid exceeds the memory
/// limit; with `Unsupported` if a mesh is too large for a format; and with `NotFound` or `Io` if a file cannot be
/// written.
pub fn write_meshes(context: &Context, world: &World, folder: &Folder, frame: u32) -> Result<Vec<PathBuf>> {
    let _stage = context.stats().begin("export.meshes");
    let scene = &world.scene;
    let formats: Vec<&str> = scene.output.mesh_formats.iter().copied().filter(|format| *format != STAGE).collect();
    if formats.is_empty() {
        return Ok(Vec::new());
    }
    let list = shown(context, world, None)?;
    let mut written = Vec::new();
    for format in formats {
        if format == "glb" {
            let path = folder.file(&format!("mesh-{frame:06}.glb"));
            let y_up = y_up(scene.up);
            let instances: Vec<Instance> = list
                .iter()
                .map(|(name, materials, mesh, transform)| {
                    let transform = y_up * *transform;
                    Instance { name, mesh, transform, materials }
                })
                .collect();
            relievo_meshio::write_glb(&path, &instances)?;
            written.push(path);
            continue;
        }
        for (name, materials, mesh, transform) in &list {
            let path = folder.file(&format!("mesh-{frame:06}-{name}.{format}"));
            let mesh = placed(mesh, transform);
            if format == "obj" {
                relievo_meshio::write_obj(&path, &mesh, materials)?;
            } else {
                relievo_meshio::write(&path, &mesh)?;
            }
            written.push(path);
        }
    }
    Ok(written)
}

/// The displaced surface that an object shows as triangles in its own space, with its colours.
pub(crate) fn displaced_mesh(
    context: &Context,
    world: &World,
    index: usize,
    surface: &DisplacedObject,
) -> Result<Mesh> {
    Ok(tessellated(context, world, index, surface)?.0.mesh)
}

/// As [`displaced_mesh`], with the tile of every triangle, and how finely tiles are divided.
pub(crate) fn tessellated(
    context: &Context,
    world: &World,
    index: usize,
    surface: &DisplacedObject,
) -> Result<(Tessellation, Rates)> {
    let scene = &world.scene;
    let coat = world.coat(index);
    let rates = Rates::new(&surface.displaced()?, coat.as_ref(), scene.output.rate, scene.output.mesh_rate);
    Ok((divided(context, world, index, surface, &rates)?, rates))
}

/// The displaced surface that an object shows, with its tiles divided as given.
fn divided(
    context: &Context,
    world: &World,
    index: usize,
    surface: &DisplacedObject,
    rates: &Rates,
) -> Result<Tessellation> {
    let displaced = surface.displaced()?;
    let mut tessellation = displaced.tessellate(context, world.cage(index), rates.as_slice())?;
    if let Some(limit) = world.texture_limit(context, index)? {
        tessellation.smooth_attribute(context, "uv", &limit)?;
    }
    if let Some(colors) = surface.colors() {
        by_format!(colors, field => tessellation.paint(field));
    }
    if let Some(traces) = surface.traces() {
        tessellation.trace(traces.field(), surface.time());
    }
    Ok(tessellation)
}

/// The displaced triangle mesh that an object shows, in its own space, with its colours and traces.
pub(crate) fn triangle_mesh(context: &Context, world: &World, index: usize, item: &TriangleItem) -> Result<Mesh> {
    divided_triangles(context, world, index, item, |face| item.object.rates(face))
}

/// As [`triangle_mesh`], with faces divided as given.
fn divided_triangles(
    context: &Context,
    world: &World,
    index: usize,
    item: &TriangleItem,
    rates: impl Fn(u32) -> FaceRates + Sync,
) -> Result<Mesh> {
    let object = &item.object;
    let displaced = object.displaced()?;
    let mut whole = TriangleTessellation::new(context, &displaced, object.normals(), world.cage(index), rates)?;
    if let Some(colors) = object.colors() {
        by_format!(colors, field => whole.paint(field))?;
    }
    if let Some(traces) = object.traces() {
        whole.trace(traces.field(), object.time());
    }
    Ok(whole.mesh)
}

/// The colours of the points of a mesh: what is painted, under the tint of traces.
pub(crate) fn point_colors(entry: &ObjectEntry, base: [f32; 3], mesh: &Mesh, painted: bool) -> Option<Vec<[f32; 3]>> {
    let painted = floats(mesh, "color", Domain::Point, 3).filter(|_| painted);
    let tint: Option<(&TintEntry, [&[f32]; 3])> = entry.traces.as_ref().and_then(|tint| {
        let [contact, depth, age] = ["contact", "depth", "age"].map(|name| floats(mesh, name, Domain::Point, 1));
        Some((tint, [contact?, depth?, age?]))
    });
    if painted.is_none() && tint.is_none() {
        return None;
    }
    let color = |point: usize| {
        let under = painted.map_or(base, |colors| [0, 1, 2].map(|channel| colors[3 * point + channel]));
        let Some((tint, [contact, depth, age])) = tint else { return under };
        // Ages are counted back from now.
        let time = (age[point] >= 0.0).then_some(-age[point]);
        tint.over(Vec3::from(under), &Mark { contact: contact[point], depth: depth[point], time }, 0.0)
    };
    Some((0..mesh.points.len()).map(color).collect())
}

/// The values of an attribute of floats.
pub(crate) fn floats<'a>(mesh: &'a Mesh, name: &str, domain: Domain, width: u32) -> Option<&'a [f32]> {
    match mesh.attribute(name) {
        Some(Attribute { domain: own, width: found, values: Values::F32(values), .. })
            if *own == domain && *found == width =>
        {
            Some(values)
        }
        _ => None,
    }
}

/// The rotation that brings `up` to y, which glTF has up.
fn y_up(up: Up) -> DAffine3 {
    DAffine3::from_mat3(up.from_y_up().transpose())
}

/// `mesh` in world space.
fn placed(mesh: &Mesh, transform: &DAffine3) -> Mesh {
    let mut mesh = mesh.clone();
    for point in &mut mesh.points {
        *point = transform.transform_point3(DVec3::from(point.map(f64::from))).as_vec3().to_array();
    }
    let normal = transform.matrix3.inverse().transpose();
    for attribute in mesh.attributes.iter_mut().filter(|attribute| attribute.name == "normal" && attribute.width == 3) {
        let Values::F32(values) = &mut attribute.values else { continue };
        for value in values.chunks_exact_mut(3) {
            let turned = normal * DVec3::new(f64::from(value[0]), f64::from(value[1]), f64::from(value[2]));
            value.copy_from_slice(&turned.normalize_or_zero().as_vec3().to_array());
        }
    }
    mesh
}

/// Writes the allocated tiles of every surface, one EXR file per object with a layer per tile: the coefficients of the
/// displacement in half floats, row 0 at v = 0, those of vectors in layers of their own, and as `face_corner` the face
/// of the cage and, of a face without four corners, the corner that the tile belongs to. Returns the files.
///
/// # Errors
/// Fails with `NotFound` or `Io` if a file cannot be written.
pub fn write_tiles(context: &Context, world: &World, folder: &Folder, frame: u32) -> Result<Vec<PathBuf>> {
    let _stage = context.stats().begin("export.tiles");
    let mut written = Vec::new();
    for (index, item) in world.items().iter().enumerate() {
        let Item::Surface(surface) = item else { continue };
        let field = surface.displacement().field();
        let name = &world.scene.objects[index].name.text;
        let topology = field.topology();
        // One attribute: the encoder writes several in an order that differs from run to run.
        let face_corner = |tile: u32| {
            let place = [topology.face(tile) as i32, topology.sub_corner(tile) as i32];
            vec![("face_corner".into(), Value::I32x2(place))]
        };
        let scalars = field.allocated().filter_map(|tile| {
            let (block, size) = (field.block(tile)?, field.size(tile) as usize);
            let rows = block.chunks_exact(size + 2).skip(1).take(size);
            let samples = rows.flat_map(|row| row[1..=size].iter().copied()).collect();
            Some(Layer {
                name: Some(format!("tile.{tile}")),
                width: size as u32,
                height: size as u32,
                channels: vec![Channel { name: "displacement".into(), samples: Samples::F16(samples) }],
                attributes: face_corner(tile),
            })
        });
        let mut layers: Vec<Layer> = scalars.collect();
        let vectors = surface.vectors().map(|vectors| vectors.field());
        layers.extend(
            vectors.into_iter().flat_map(|field| field.allocated().map(move |tile| (field, tile))).filter_map(
                |(field, tile)| {
                    let (block, size) = (field.block(tile)?, field.size(tile) as usize);
                    let rows = || block.chunks_exact(size + 2).skip(1).take(size).flat_map(|row| &row[1..=size]);
                    let channels = ["along", "across", "up"].into_iter().enumerate().map(|(axis, name)| Channel {
                        name: name.into(),
                        samples: Samples::F16(rows().map(|vector| vector.0[axis]).collect()),
                    });
                    Some(Layer {
                        name: Some(format!("vectors.{tile}")),
                        width: size as u32,
                        height: size as u32,
                        channels: channels.collect(),
                        attributes: face_corner(tile),
                    })
                },
            ),
        );
        if layers.is_empty() {
            continue;
        }
        let path = folder.file(&format!("tiles-{frame:06}-{name}.exr"));
        write_exr(&path, &layers, Content::Data)?;
        written.push(path);
    }
    Ok(written)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_up_axis_becomes_y() {
        for up in [Up::X, Up::Y, Up::Z] {
            let turned = y_up(up).transform_vector3(up.direction());
            assert!((turned - DVec3::Y).length() < 1e-12);
            assert!((y_up(up).matrix3.determinant() - 1.0).abs() < 1e-12);
        }
    }
}
