//! Characters of rigid limbs for tests, as glTF.

use std::path::Path;

use glam::Vec3;
use serde_json::{Value, json};

/// A limb: triangles that move rigidly.
#[derive(Clone, Debug, Default)]
pub struct Limb {
    /// Points about its pivot.
    pub points: Vec<[f32; 3]>,
    /// Triangles, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
    /// Times in seconds, ascending from 0, at which it is given.
    pub times: Vec<f32>,
    /// Where its pivot is at these times.
    pub places: Vec<[f32; 3]>,
    /// Its turns at these times, as quaternions x, y, z, w.
    pub turns: Vec<[f32; 4]>,
}

impl Limb {
    /// Adds a box.
    pub fn add_box(&mut self, low: [f32; 3], high: [f32; 3]) {
        let first = self.points.len() as u32;
        for corner in 0..8 {
            let place = |axis: usize| if corner >> axis & 1 == 1 { high[axis] } else { low[axis] };
            self.points.push([place(0), place(1), place(2)]);
        }
        let sides = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [1, 3, 7, 5], [3, 2, 6, 7], [2, 0, 4, 6]];
        let halves = sides.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]);
        self.triangles.extend(halves.map(|triangle| triangle.map(|corner: u32| first + corner)));
    }
}

/// Writes a character with one animation, called `walk`, as glTF with its buffer beside it. Triangles are flat.
///
/// # Panics
/// If a file cannot be written.
pub fn write_limbs(path: &Path, limbs: &[Limb]) {
    let mut file = Parts::default();
    let (mut nodes, mut meshes, mut channels, mut samplers) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    for (node, limb) in limbs.iter().enumerate() {
        let (mut points, mut normals) = (Vec::new(), Vec::new());
        for triangle in &limb.triangles {
            let [a, b, c] = triangle.map(|point| Vec3::from(limb.points[point as usize]));
            points.extend([a, b, c].map(|point| point.to_array()));
            normals.extend([(b - a).cross(c - a).normalize().to_array(); 3]);
        }
        let place =
            |pick: fn(Vec3, Vec3) -> Vec3| points.iter().copied().map(Vec3::from).reduce(pick).map(|v| v.to_array());
        let (low, high) = (place(Vec3::min).unwrap_or_default(), place(Vec3::max).unwrap_or_default());
        let corners: Vec<u8> = (0..points.len() as u32).flat_map(u32::to_le_bytes).collect();
        let corners = file.add(corners, 5125, points.len(), "SCALAR", None);
        let normals = file.add(floats(normals.as_flattened()), 5126, points.len(), "VEC3", None);
        let points = file.add(floats(points.as_flattened()), 5126, points.len(), "VEC3", Some([&low, &high]));
        nodes.push(json!({ "mesh": node, "translation": limb.places[0], "rotation": limb.turns[0] }));
        meshes.push(
            json!({ "primitives": [{ "attributes": { "POSITION": points, "NORMAL": normals }, "indices": corners }] }),
        );
        let count = limb.times.len();
        let ends = [[limb.times[0]], [limb.times[count - 1]]];
        let times = file.add(floats(&limb.times), 5126, count, "SCALAR", Some([&ends[0], &ends[1]]));
        let places = file.add(floats(limb.places.as_flattened()), 5126, count, "VEC3", None);
        let turns = file.add(floats(limb.turns.as_flattened()), 5126, count, "VEC4", None);
        for (path, values) in [("translation", places), ("rotation", turns)] {
            channels.push(json!({ "sampler": samplers.len(), "target": { "node": node, "path": path } }));
            samplers.push(json!({ "input": times, "output": values }));
        }
    }
    let buffer = path.with_extension("bin");
    let uri = buffer.file_name().map(|name| name.to_string_lossy().into_owned());
    let made = json!({
        "asset": { "version": "2.0" },
        "scene": 0,
        "scenes": [{ "nodes": (0..limbs.len()).collect::<Vec<_>>() }],
        "nodes": nodes,
        "meshes": meshes,
        "animations": [{ "name": "walk", "channels": channels, "samplers": samplers }],
        "buffers": [{ "uri": uri, "byteLength": file.bytes.len() }],
        "bufferViews": file.views,
        "accessors": file.accessors,
    });
    std::fs::write(&buffer, &file.bytes).unwrap_or_else(|error| panic!("{}: {error}", buffer.display()));
    std::fs::write(path, made.to_string()).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
}

/// The buffer of a file and what is where in it.
#[derive(Default)]
struct Parts {
    bytes: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
}

impl Parts {
    /// Adds values and returns their number. Their extent is given where glTF asks for it.
    fn add(&mut self, bytes: Vec<u8>, kind: u32, count: usize, form: &str, extent: Option<[&[f32]; 2]>) -> usize {
        let number = self.views.len();
        self.views.push(json!({ "buffer": 0, "byteOffset": self.bytes.len(), "byteLength": bytes.len() }));
        self.bytes.extend(bytes);
        let mut accessor = json!({ "bufferView": number, "componentType": kind, "count": count, "type": form });
        if let Some([least, most]) = extent {
            (accessor["min"], accessor["max"]) = (json!(least), json!(most));
        }
        self.accessors.push(accessor);
        number
    }
}

fn floats(values: &[f32]) -> Vec<u8> {
    values.iter().flat_map(|value| value.to_le_bytes()).collect()
}
