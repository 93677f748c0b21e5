//! Writes binary glTF 2.0: triangles with normals, texture coordinates and colours, one node per instance, one
//! primitive per material slot.
//!
//! Faces are fanned into triangles and holes left out. Points whose corners differ in an attribute are repeated. v of
//! texture coordinates is turned, because glTF counts it from the top of the image.

use std::collections::{BTreeMap, HashMap};
use std::io::Write;
use std::path::Path;

use glam::{DAffine3, Vec3};
use relievo_core::{Attribute, Domain, Error, Mesh, Result, Values};
use serde_json::{Value, json};

use crate::corners::CornerValues;
use crate::file;

/// A mesh and where it is.
#[derive(Clone, Copy, Debug)]
pub struct Instance<'a> {
    /// Name of its node and mesh.
    pub name: &'a str,
    /// The mesh, in its own space.
    pub mesh: &'a Mesh,
    /// The map from its space to the scene's.
    pub transform: DAffine3,
    /// Names of the slots of the face attribute `material`: the same name is the same material in all instances, and
    /// an empty one is none. Slots without a name are called by their number.
    pub materials: &'a [String],
}

impl<'a> Instance<'a> {
    /// A mesh that is where its points are.
    pub fn new(name: &'a str, mesh: &'a Mesh) -> Self {
        Self { name, mesh, transform: DAffine3::IDENTITY, materials: &[] }
    }
}

/// Writes instances as GLB.
///
/// # Errors
/// Fails, and leaves no file: with `Invalid` if a mesh cannot be used (see [`Mesh::check`]), no instance is given or a
/// transform is not finite, with `Unsupported` if the file would be larger than the format's 4 GiB, and with `NotFound`
/// or `Io` if the system refuses.
pub fn write_glb(path: &Path, instances: &[Instance]) -> Result<()> {
    let (json, buffer) = described(instances).map_err(|error| error.at(path.display().to_string()))?;
    store(path, &json, &buffer)
}

/// The bytes of the file that [`write_glb`] writes. Fails as that does.
pub(crate) fn glb_bytes(instances: &[Instance]) -> Result<Vec<u8>> {
    let (json, buffer) = described(instances)?;
    let mut bytes = Vec::new();
    let (head, text) = head(&json, &buffer)?;
    write_parts(&head, &text, &buffer, &mut bytes).map_err(|error| Error::internal(error.to_string()))?;
    Ok(bytes)
}

/// The description and the buffer of a GLB of instances.
fn described(instances: &[Instance]) -> Result<(Value, Vec<u8>)> {
    let mut writer = Writer::default();
    for (index, instance) in instances.iter().enumerate() {
        writer.add(instance).map_err(|error| error.at(format!("instance {index} `{}`", instance.name)))?;
    }
    if instances.is_empty() {
        return Err(Error::invalid("there is no mesh to write"));
    }
    Ok(writer.finish())
}

/// Writes the description and the buffer of a GLB. The length of the buffer is a multiple of four.
pub(crate) fn store(path: &Path, json: &Value, buffer: &[u8]) -> Result<()> {
    let (head, text) = head(json, buffer).map_err(|error| error.at(path.display().to_string()))?;
    file::store(path, |out| write_parts(&head, &text, buffer, out))
}

/// The five words that a GLB begins with, and its text.
fn head(json: &Value, buffer: &[u8]) -> Result<([u32; 5], Vec<u8>)> {
    let mut text = json.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    let length = u32::try_from(12 + 8 + text.len() + 8 + buffer.len());
    let length = length.map_err(|_| Error::unsupported("a GLB holds at most 4 GiB").advise("split the mesh"))?;
    let words = [u32::from_le_bytes(*b"glTF"), 2, length, text.len() as u32, u32::from_le_bytes(*b"JSON")];
    Ok((words, text))
}

fn write_parts(head: &[u32; 5], text: &[u8], buffer: &[u8], out: &mut impl Write) -> std::io::Result<()> {
    head.iter().try_for_each(|word| out.write_all(&word.to_le_bytes()))?;
    out.write_all(text)?;
    out.write_all(&(buffer.len() as u32).to_le_bytes())?;
    out.write_all(b"BIN\0")?;
    out.write_all(buffer)
}

/// glTF's number for an array of vertex attributes.
const ARRAY_BUFFER: u32 = 34962;
/// glTF's number for an array of indices.
const ELEMENT_ARRAY_BUFFER: u32 = 34963;
/// glTF's number for 32-bit floats.
pub(crate) const FLOAT: u32 = 5126;
/// glTF's number for 16-bit unsigned integers.
const UNSIGNED_SHORT: u32 = 5123;
/// glTF's number for 32-bit unsigned integers.
const UNSIGNED_INT: u32 = 5125;

/// Collects the buffer and its description. Every element of an array has a multiple of four bytes, so that all are aligned.
#[derive(Default)]
pub(crate) struct Writer {
    buffer: Vec<u8>,
    views: Vec<Value>,
    pub accessors: Vec<Value>,
    meshes: Vec<Value>,
    pub nodes: Vec<Value>,
    materials: Vec<Value>,
    /// Materials by the names that instances give.
    named: HashMap<String, usize>,
}

impl Writer {
    fn add(&mut self, instance: &Instance) -> Result<()> {
        if !instance.transform.is_finite() {
            return Err(Error::invalid("its transform is not finite"));
        }
        let mesh = self.mesh(instance, false)?;
        let mut node = json!({ "name": instance.name, "mesh": mesh });
        if instance.transform != DAffine3::IDENTITY {
            node["matrix"] = json!(glam::DMat4::from(instance.transform).to_cols_array());
        }
        self.nodes.push(node);
        Ok(())
    }

    /// Adds the mesh of an instance, with its point attributes `joints` and `weights` if it is skinned. Returns its number.
    pub fn mesh(&mut self, instance: &Instance, is_skinned: bool) -> Result<usize> {
        let mesh = instance.mesh;
        mesh.check()?;
        let vertices = Vertices::of(mesh);
        if vertices.triangles.is_empty() {
            return Err(Error::invalid("all its faces are holes").advise("leave the mesh out"));
        }
        let mut attributes = serde_json::Map::new();
        let positions = vertices.gather(|[point, ..]| mesh.points[point as usize]);
        let (mut low, mut high) = (positions[0], positions[0]);
        for point in &positions {
            for axis in 0..3 {
                low[axis] = low[axis].min(point[axis]);
                high[axis] = high[axis].max(point[axis]);
            }
        }
        let accessor = self.floats(positions.as_flattened(), 3);
        self.accessors[accessor]["min"] = json!(low);
        self.accessors[accessor]["max"] = json!(high);
        attributes.insert("POSITION".into(), json!(accessor));
        if let Some(normals) = &vertices.normals {
            // glTF wants unit normals; one that is none is set to an axis.
            let unit = |value: [f32; 3]| Vec3::from(value).try_normalize().unwrap_or(Vec3::Z).to_array();
            let values = vertices.gather(|[_, _, normal, _]| unit(normals.value(normal)));
            attributes.insert("NORMAL".into(), json!(self.floats(values.as_flattened(), 3)));
        }
        if let Some(uvs) = &vertices.uvs {
            let values = vertices.gather(|[_, uv, ..]| {
                let [u, v] = uvs.value(uv);
                [u, 1.0 - v]
            });
            attributes.insert("TEXCOORD_0".into(), json!(self.floats(values.as_flattened(), 2)));
        }
        if let Some(colors) = &vertices.colors {
            let values = vertices.gather(|[.., color]| colors.value::<4>(color));
            attributes.insert("COLOR_0".into(), json!(self.floats(values.as_flattened(), 4)));
        }
        if is_skinned {
            let (joints, weights) = influences(mesh)?;
            let joints = vertices.gather(|[point, ..]| joints[point as usize]);
            let view = self.view(bytemuck::cast_slice(joints.as_flattened()), Some(ARRAY_BUFFER));
            self.accessors.push(json!({
                "bufferView": view, "componentType": UNSIGNED_SHORT, "count": joints.len(), "type": "VEC4",
            }));
            attributes.insert("JOINTS_0".into(), json!(self.accessors.len() - 1));
            let weights = vertices.gather(|[point, ..]| weights[point as usize]);
            attributes.insert("WEIGHTS_0".into(), json!(self.floats(weights.as_flattened(), 4)));
        }
        let mut primitives = Vec::new();
        for name in instance.materials {
            self.material(name);
        }
        for (slot, triangles) in by_slot(mesh, &vertices.triangles) {
            let indices = triangles.as_flattened();
            let view = self.view(bytemuck::cast_slice(indices), Some(ELEMENT_ARRAY_BUFFER));
            self.accessors.push(json!({
                "bufferView": view, "componentType": UNSIGNED_INT, "count": indices.len(), "type": "SCALAR",
            }));
            let mut primitive = json!({ "attributes": attributes, "indices": self.accessors.len() - 1 });
            let material = slot.and_then(|slot| match instance.materials.get(slot as usize) {
                Some(name) => self.material(name),
                None => {
                    self.materials.push(json!({ "name": slot.to_string() }));
                    Some(self.materials.len() - 1)
                }
            });
            if let Some(material) = material {
                primitive["material"] = json!(material);
            }
            primitives.push(primitive);
        }
        self.meshes.push(json!({ "name": instance.name, "primitives": primitives }));
        Ok(self.meshes.len() - 1)
    }

    /// The material of this name, made when first asked for; none without a name.
    fn material(&mut self, name: &str) -> Option<usize> {
        if name.is_empty() {
            return None;
        }
        if let Some(known) = self.named.get(name) {
            return Some(*known);
        }
        self.materials.push(json!({ "name": name }));
        self.named.insert(name.into(), self.materials.len() - 1);
        Some(self.materials.len() - 1)
    }

    pub fn view(&mut self, bytes: &[u8], target: Option<u32>) -> usize {
        let mut view = json!({ "buffer": 0, "byteOffset": self.buffer.len(), "byteLength": bytes.len() });
        if let Some(target) = target {
            view["target"] = json!(target);
        }
        self.views.push(view);
        // The format is little-endian, as every processor Relievo runs on.
        self.buffer.extend_from_slice(bytes);
        self.views.len() - 1
    }

    fn floats(&mut self, values: &[f32], width: usize) -> usize {
        let view = self.view(bytemuck::cast_slice(values), Some(ARRAY_BUFFER));
        let kind = ["SCALAR", "VEC2", "VEC3", "VEC4"][width - 1];
        self.accessors.push(json!({
            "bufferView": view, "componentType": FLOAT, "count": values.len() / width, "type": kind,
        }));
        self.accessors.len() - 1
    }

    /// Returns the description, with every node in the scene, and the buffer.
    pub fn finish(self) -> (Value, Vec<u8>) {
        let mut json = json!({
            "asset": { "version": "2.0", "generator": concat!("Relievo ", env!("CARGO_PKG_VERSION")) },
            "scene": 0,
            "scenes": [{ "nodes": (0..self.nodes.len()).collect::<Vec<_>>() }],
            "nodes": self.nodes,
            "meshes": self.meshes,
            "accessors": self.accessors,
            "bufferViews": self.views,
            "buffers": [{ "byteLength": self.buffer.len() }],
        });
        // The format knows no empty lists.
        if !self.materials.is_empty() {
            json["materials"] = json!(self.materials);
        }
        (json, self.buffer)
    }
}

/// Returns the joints and weights of every point of a mesh.
fn influences(mesh: &Mesh) -> Result<(Vec<[u16; 4]>, &[[f32; 4]])> {
    let of = |name: &str| {
        let found =
            mesh.attribute(name).filter(|it| it.domain == Domain::Point && it.width == 4 && it.indices.is_none());
        found.map(|found| &found.values)
    };
    let (Some(Values::U32(joints)), Some(Values::F32(weights))) = (of("joints"), of("weights")) else {
        return Err(Error::invalid("the mesh has no joints or no weights on its points"));
    };
    let narrow = |joint: &u32| {
        u16::try_from(*joint).map_err(|_| Error::unsupported(format!("glTF has no joint {joint}, only up to 65535")))
    };
    let joints = joints.iter().map(narrow).collect::<Result<Vec<u16>>>()?;
    Ok((joints.as_chunks::<4>().0.to_vec(), weights.as_chunks::<4>().0))
}

/// The triangles of every material slot of `mesh`, slots ascending; all together if it has none.
fn by_slot(mesh: &Mesh, triangles: &[[u32; 3]]) -> Vec<(Option<u32>, Vec<[u32; 3]>)> {
    let slots = match mesh.attribute("material") {
        Some(Attribute { domain: Domain::Face, width: 1, values: Values::U32(slots), indices: None, .. }) => slots,
        _ => return vec![(None, triangles.to_vec())],
    };
    let mut hole = vec![false; mesh.face_count()];
    mesh.holes.iter().for_each(|face| hole[*face as usize] = true);
    let faces = mesh.face_sizes.iter().zip(slots).zip(hole).filter(|(_, hole)| !hole);
    let slots = faces.flat_map(|((size, slot), _)| std::iter::repeat_n(*slot, (*size as usize).saturating_sub(2)));
    let mut lists: BTreeMap<u32, Vec<[u32; 3]>> = BTreeMap::new();
    for (slot, triangle) in slots.zip(triangles) {
        lists.entry(slot).or_default().push(*triangle);
    }
    lists.into_iter().map(|(slot, list)| (Some(slot), list)).collect()
}

/// Vertices of a mesh that have one value of every attribute, and triangles of them.
struct Vertices<'a> {
    uvs: Option<CornerValues<'a>>,
    normals: Option<CornerValues<'a>>,
    colors: Option<CornerValues<'a>>,
    /// Point, texture coordinate, normal and colour of every vertex; `None` if vertices are points.
    split: Option<Vec<[u32; 4]>>,
    points: usize,
    triangles: Vec<[u32; 3]>,
}

impl<'a> Vertices<'a> {
    fn of(mesh: &'a Mesh) -> Self {
        let uvs = CornerValues::find(mesh, "uv", 2);
        let normals = CornerValues::find(mesh, "normal", 3);
        let colors = CornerValues::find(mesh, "color", 3);
        let on_corners = [&uvs, &normals, &colors].into_iter().flatten().any(|values| values.indices.is_some());
        let points = mesh.points.len();
        if !on_corners {
            return Self { uvs, normals, colors, split: None, points, triangles: mesh.triangles() };
        }
        let mut hole = vec![false; mesh.face_count()];
        mesh.holes.iter().for_each(|face| hole[*face as usize] = true);
        let mut known = HashMap::new();
        let mut split = Vec::new();
        let mut triangles = Vec::with_capacity(mesh.corners.len());
        let mut corner = 0;
        let mut face_vertices = Vec::new();
        for (face, hole) in mesh.faces().zip(hole) {
            face_vertices.clear();
            for point in face {
                let index =
                    |values: &Option<CornerValues>| values.as_ref().map_or(0, |values| values.index(corner, *point));
                let key = [*point, index(&uvs), index(&normals), index(&colors)];
                corner += 1;
                if hole {
                    continue;
                }
                let next = split.len() as u32;
                face_vertices.push(*known.entry(key).or_insert_with(|| {
                    split.push(key);
                    next
                }));
            }
            let fan = 2..face_vertices.len();
            triangles.extend(fan.map(|last| [face_vertices[0], face_vertices[last - 1], face_vertices[last]]));
        }
        Self { uvs, normals, colors, split: Some(split), points, triangles }
    }

    /// `value` of every vertex, which gets its point, texture coordinate, normal and colour.
    fn gather<T>(&self, value: impl Fn([u32; 4]) -> T) -> Vec<T> {
        match &self.split {
            Some(split) => split.iter().copied().map(value).collect(),
            None => (0..self.points as u32).map(|point| value([point; 4])).collect(),
        }
    }
}
