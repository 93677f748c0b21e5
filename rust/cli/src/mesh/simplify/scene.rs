//! What a file holds around its meshes that a simplified mesh does not have.

use std::io::Read;
use std::path::Path;

use relievo_core::{Context, Error, Result, file};
use relievo_meshio::Model;
use serde_json::Value;

/// The first bytes of a binary glTF file.
const MAGIC: &[u8] = b"glTF";
/// Where the JSON of a binary glTF file starts, and where its length is (glTF 2.0, Section 4.4).
const TEXT: usize = 20;
const LENGTH: std::ops::Range<usize> = 12..16;

/// Lists the parts of a model that are left out when it becomes one mesh at rest, each with its count. Lists none for a
/// model of one unnamed mesh.
pub fn left_out(model: &Model, textures: usize) -> Vec<String> {
    let has_name = |names: &mut dyn Iterator<Item = &String>| names.filter(|name| !name.is_empty()).count();
    let nodes = model.nodes.len();
    let is_one = nodes == 1 && model.nodes[0].local == relievo_meshio::Placement::IDENTITY;
    let counts = [
        (model.skins.len(), "skin"),
        (model.animations.len(), "animation"),
        (model.meshes.iter().map(|part| part.targets.len()).sum(), "morph target"),
        (if is_one { 0 } else { nodes }, "node"),
        (has_name(&mut model.meshes.iter().map(|part| &part.name)), "mesh name"),
        (has_name(&mut model.materials.iter()), "material name"),
        (textures, "texture"),
    ];
    let listed = |(count, what): (usize, &str)| match count {
        0 => None,
        1 => Some(format!("1 {what} is")),
        _ => Some(format!("{count} {what}s are")),
    };
    counts.into_iter().filter_map(listed).collect()
}

/// Counts the textures of a glTF file, text or binary; other files have none. Fails if the file cannot be read.
pub fn texture_count(context: &Context, path: &Path) -> Result<usize> {
    let extension = path.extension().map(|extension| extension.to_string_lossy().to_ascii_lowercase());
    let mut head = Vec::new();
    let start = file::open(path)?.take(MAGIC.len() as u64).read_to_end(&mut head);
    start.map_err(|error| Error::io(path, &error))?;
    if head != MAGIC && extension.as_deref() != Some("gltf") {
        return Ok(0);
    }
    let bytes = file::load(path, context.memory_limit())?;
    let text = if bytes.starts_with(MAGIC) { json_chunk(&bytes) } else { Some(&*bytes) };
    let json: Option<Value> = text.and_then(|text| serde_json::from_slice(text).ok());
    Ok(json.and_then(|json| json["textures"].as_array().map(Vec::len)).unwrap_or(0))
}

/// Returns the JSON of a binary glTF file.
fn json_chunk(bytes: &[u8]) -> Option<&[u8]> {
    let length = u32::from_le_bytes(bytes.get(LENGTH)?.try_into().ok()?);
    bytes.get(TEXT..)?.get(..length as usize)
}
