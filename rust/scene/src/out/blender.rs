//! Frames as Python scripts that make them in Blender: camera, sun, sky, and every visible object.
//!
//! A script holds a description in JSON, and its arrays are in a file of numbers beside it, little-endian and one after
//! the other: so a million points take no longer than reading them. Displaced surfaces are meshes with normals, texture
//! coordinates and colours. Limit surfaces on which nothing happened are their cages under a Subdivision Surface modifier,
//! which is OpenSubdiv too, and so stay as smooth as one asks for. Blender's axes, its camera and its sun are as ours.
//! Colours are scene-linear. Units: those of the scene.

use std::io::Write;
use std::path::PathBuf;

use glam::{DAffine3, DMat3, DVec3};
use relievo_core::mesh::INFINITE_SHARPNESS;
use relievo_core::{Context, Domain, Error, Mesh, Result, Values};
use relievo_detail::DisplacedObject;
use serde_json::{Value, json};

use crate::format::description::Geometry;
use crate::out::export::{displaced_mesh, floats, point_colors, shown_mesh, triangle_mesh};
use crate::out::output::Folder;
use crate::out::picture::{automatic_view, camera, lights};
use crate::out::povray::{is_dark, sky_stops};
use crate::state::world::{Item, World};

/// The script, in which `@SCENE@` stands for the description.
const SCRIPT: &str = include_str!("blender.py");

/// Writes the frame. Returns the script and the file of its arrays.
pub fn write(context: &Context, world: &World, folder: &Folder, frame: u32) -> Result<Vec<PathBuf>> {
    let _stage = context.stats().begin("export.blender");
    let scene = &world.scene;
    let mut arrays = Arrays::default();
    let mut objects = Vec::new();
    for (index, item) in world.items().iter().enumerate().filter(|(index, _)| scene.objects[*index].visible) {
        objects.push(object(context, world, index, item, &mut arrays)?);
    }
    let view = camera(world, &automatic_view(scene, world.start_bounds()), scene.time(frame))?;
    let lights = lights(scene);
    let suns = lights.suns.iter().map(|sun| {
        let direction = DVec3::from(sun.direction.map(f64::from)).normalize_or(DVec3::Z);
        let side = direction.any_orthonormal_vector();
        // It shines along −z.
        let axes = DMat3::from_cols(side, direction.cross(side), direction);
        json!({
            "matrix": matrix(&DAffine3::from_mat3(axes)),
            "irradiance": sun.irradiance,
            "angle": 2.0 * sun.angular_radius,
        })
    });
    let sky = (!is_dark(&lights.sky)).then(|| {
        let stops = sky_stops(&lights.sky);
        json!({ "up": lights.sky.up, "stops": stops.iter().map(|(at, color)| json!([at, color])).collect::<Vec<_>>() })
    });
    let settings = &scene.output.settings;
    let description = json!({
        "frame": frame,
        "fps": scene.fps,
        "size": [settings.width, settings.height],
        "exposure": scene.output.exposure,
        "camera": { "matrix": matrix(&DAffine3::from_mat3_translation(view.axes, view.eye)), "fov": view.fov },
        "suns": suns.collect::<Vec<_>>(),
        "sky": sky,
        "objects": objects,
    });
    let text = serde_json::to_string_pretty(&description)
        .map_err(|error| Error::invalid(format!("the scene cannot be described: {error}")))?;
    // The quotes that end the text in the script are only in names; JSON has another way to say them.
    let script = SCRIPT.replace("@SCENE@", &text.replace('\'', "\\u0027"));
    let (path, numbers) = (folder.file(&format!("scene-{frame:06}.py")), folder.file(&format!("scene-{frame:06}.bin")));
    relievo_core::file::store(&numbers, |out| out.write_all(&arrays.bytes))?;
    relievo_core::file::store(&path, |out| out.write_all(script.as_bytes()))?;
    Ok(vec![path, numbers])
}

/// The description of an object, whose arrays are added to `arrays`.
fn object(context: &Context, world: &World, index: usize, item: &Item, arrays: &mut Arrays) -> Result<Value> {
    let entry = &world.scene.objects[index];
    let base = entry.colour.map(|value| value.min(1.0));
    let is_plain = match item {
        Item::Surface(surface) => is_plain(world, index, surface)?,
        _ => false,
    };
    let (transform, mesh, is_painted) = match item {
        Item::Mesh(item) => (item.transform, shown_mesh(context, entry, &item.mesh)?, false),
        Item::Triangles(item) => {
            let painted = item.object.colors().is_some();
            (*item.object.transform(), triangle_mesh(context, world, index, item)?, painted)
        }
        Item::Surface(surface) if is_plain => (*surface.transform(), world.cage(index).clone(), false),
        Item::Surface(surface) => {
            let mesh = displaced_mesh(context, world, index, surface)?;
            (*surface.transform(), mesh, surface.colors().is_some())
        }
    };
    let mut described = json!({
        "name": entry.name.text,
        "matrix": matrix(&transform),
        "color": base,
        "specular": entry.specular,
        "roughness": entry.roughness,
        "mesh": arrays.mesh(&mesh),
    });
    if let Some(colors) = point_colors(entry, base, &mesh, is_painted) {
        described["mesh"]["colors"] = arrays.add(colors.as_flattened().iter().map(|value| value.to_le_bytes()));
    }
    if is_plain {
        let sharp = |sharpness: f32| sharpness.min(INFINITE_SHARPNESS).to_le_bytes();
        let edges = mesh.creases.iter().flat_map(|crease| crease.points.map(u32::to_le_bytes));
        let has_sharp_corners = match entry.geometry {
            Geometry::Surface(surface) => world.scene.surfaces[surface].sharp_corners,
            Geometry::Mesh(_) => true,
        };
        described["subdivision"] = json!({
            // As fine as tiles are elsewhere.
            "levels": world.scene.output.rate.ilog2(),
            "corners": has_sharp_corners,
            "edges": arrays.add(edges),
            "sharpness": arrays.add(mesh.creases.iter().map(|crease| sharp(crease.sharpness))),
            "points": arrays.add(mesh.sharp_points.iter().map(|(point, _)| point.to_le_bytes())),
            "point_sharpness": arrays.add(mesh.sharp_points.iter().map(|(_, sharpness)| sharp(*sharpness))),
        });
    }
    Ok(described)
}

/// Whether a surface is that of its cage as it is read, without displacement, colours or holes.
fn is_plain(world: &World, index: usize, surface: &DisplacedObject) -> Result<bool> {
    let displaced = surface.displaced()?;
    let untouched = displaced.field().allocated().next().is_none()
        && displaced.vectors().is_none_or(|vectors| vectors.allocated().next().is_none());
    let is_bare = world.coat(index).is_none();
    Ok(untouched && is_bare && world.cage(index).holes.is_empty() && !world.is_object_animated(index))
}

/// Rows of a matrix of four by four.
fn matrix(transform: &DAffine3) -> [[f64; 4]; 4] {
    let [x, y, z, w] =
        [transform.matrix3.x_axis, transform.matrix3.y_axis, transform.matrix3.z_axis, transform.translation];
    let row = |axis: usize| [x[axis], y[axis], z[axis], w[axis]];
    [row(0), row(1), row(2), [0.0, 0.0, 0.0, 1.0]]
}

/// Numbers of four bytes, one array after the other.
#[derive(Debug, Default)]
struct Arrays {
    bytes: Vec<u8>,
}

impl Arrays {
    /// Adds an array. Returns where it begins, in bytes, and how many numbers it has.
    fn add(&mut self, numbers: impl Iterator<Item = [u8; 4]>) -> Value {
        let start = self.bytes.len();
        self.bytes.extend(numbers.flatten());
        json!([start, (self.bytes.len() - start) / 4])
    }

    /// Adds the points, the faces that are no holes, normals and texture coordinates of a mesh.
    fn mesh(&mut self, mesh: &Mesh) -> Value {
        let mut offsets = mesh.face_offsets();
        offsets.pop();
        let is_kept = |face: usize| !mesh.holes.contains(&(face as u32));
        let kept: Vec<usize> = (0..mesh.face_count()).filter(|face| mesh.holes.is_empty() || is_kept(*face)).collect();
        let corners: Vec<usize> = kept
            .iter()
            .flat_map(|face| offsets[*face] as usize..(offsets[*face] + mesh.face_sizes[*face]) as usize)
            .collect();
        let mut described = json!({
            "points": self.add(mesh.points.as_flattened().iter().map(|value| value.to_le_bytes())),
            "sizes": self.add(kept.iter().map(|face| mesh.face_sizes[*face].to_le_bytes())),
            "corners": self.add(corners.iter().map(|corner| mesh.corners[*corner].to_le_bytes())),
        });
        if let Some(normals) = floats(mesh, "normal", Domain::Point, 3) {
            described["normals"] = self.add(normals.iter().map(|value| value.to_le_bytes()));
        }
        let uv = mesh.attribute("uv").filter(|uv| uv.width == 2 && uv.domain != Domain::Face);
        if let Some((uv, Values::F32(values))) = uv.map(|uv| (uv, &uv.values)) {
            let place = |corner: usize| match (uv.domain, &uv.indices) {
                (Domain::Corner, Some(indices)) => indices[corner] as usize,
                (Domain::Corner, None) => corner,
                _ => mesh.corners[corner] as usize,
            };
            let of_corner = |corner: &usize| [0, 1].map(|k| values[2 * place(*corner) + k].to_le_bytes());
            described["uv"] = self.add(corners.iter().flat_map(of_corner));
        }
        described
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arrays_lie_one_after_the_other_and_holes_are_left_out() {
        let mut mesh = Mesh::new(vec![[0.0; 3]; 5], vec![3, 3, 4], vec![0, 1, 2, 1, 2, 3, 0, 1, 3, 4]);
        mesh.holes.push(1);
        let mut arrays = Arrays::default();
        let described = arrays.mesh(&mesh);
        assert_eq!(described["points"], json!([0, 15]));
        assert_eq!(described["sizes"], json!([60, 2]));
        assert_eq!(described["corners"], json!([68, 7]));
        assert!(described.get("normals").is_none() && described.get("uv").is_none());
        let number = |at: usize| u32::from_le_bytes(arrays.bytes[at..at + 4].try_into().unwrap());
        assert_eq!([number(60), number(64)], [3, 4]);
        assert_eq!((0..7).map(|k| number(68 + 4 * k)).collect::<Vec<_>>(), [0, 1, 2, 0, 1, 3, 4]);
        assert_eq!(arrays.bytes.len(), 68 + 28);
    }
}
