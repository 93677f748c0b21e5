//! glTF 2.0, text and binary: triangle meshes, the node hierarchy, skins, morph targets and animations.
//!
//! Lengths are metres, y is up, and v of texture coordinates is turned so that it counts upwards.

mod accessor;
mod animation;
mod container;
pub(crate) mod glb_levels;
pub(crate) mod glb_writer;
mod hierarchy;
mod influences;
mod primitive;

use relievo_core::Result;

pub use container::Open;

use crate::budget::Budget;
use crate::model::Model;
use crate::notes::Notes;

/// Reads a `.glb` or `.gltf` file. `memory_limit` bounds in bytes what is allocated for it; `open` is asked for the
/// files it names, and gets their name and the most bytes it may return.
///
/// # Errors
/// Fails with `Invalid`, and the element, if data are missing, cut off or not finite, an index refers to nothing, or
/// nodes form a circle; with `Unsupported` for another version, or an extension that is required and not read; with
/// `Memory` above the limit; and as `open` does.
pub fn read_gltf(bytes: &[u8], memory_limit: u64, open: &Open) -> Result<Model> {
    // Many meshes may name the same few bytes; a small file that becomes gigabytes is an attack.
    let sane = (1 << 30) + 256 * bytes.len() as u64;
    let mut budget = Budget::new(memory_limit.min(sane));
    let mut notes = Notes::default();
    let file = container::Container::open(bytes, &mut budget, open)?;
    let name = |material: &gltf::json::Material| material.name.clone().unwrap_or_default();
    let mut materials: Vec<String> = file.json.materials.iter().map(name).collect();
    let mut meshes = Vec::new();
    for index in 0..file.json.meshes.len() {
        meshes.push(primitive::mesh(&file, &mut budget, &mut notes, index, &mut materials)?);
    }
    let hierarchy = hierarchy::Hierarchy::read(&file, &mut budget, &mut notes, &meshes)?;
    // What a pose of all instances takes, so that many nodes cannot make much of one mesh either.
    for node in &hierarchy.nodes {
        let Some(part) = node.mesh.and_then(|mesh| meshes.get(mesh)) else { continue };
        let joints = node.skin.and_then(|skin| hierarchy.skins.get(skin)).map_or(0, |skin| skin.joints.len());
        let point = 48 + 12 * part.targets.len() as u64;
        budget
            .charge(point * part.mesh.points.len() as u64 + 8 * part.mesh.corners.len() as u64 + 96 * joints as u64)?;
    }
    let animations = animation::animations(&file, &mut budget, &mut notes, &hierarchy, &meshes)?;
    let hierarchy::Hierarchy { nodes, skins, .. } = hierarchy;
    let notes = notes.into_list();
    Ok(Model { meshes, nodes, skins, animations, materials, notes, ..Model::default() })
}
