//! glTF files made here, whose poses have closed forms, and broken ones.

use relievo_core::{Context, Error, Mesh, Result, Values};
use relievo_meshio::{Model, Root, read_gltf, read_model, read_model_within};
use serde_json::{Value, json};

/// Builds a file: arrays first, then the rest of the JSON around their numbers.
#[derive(Default)]
struct File {
    buffer: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
}

impl File {
    fn view(&mut self, bytes: &[u8]) -> usize {
        self.views.push(json!({ "buffer": 0, "byteOffset": self.buffer.len(), "byteLength": bytes.len() }));
        self.buffer.extend(bytes);
        self.buffer.resize(self.buffer.len().next_multiple_of(4), 0);
        self.views.len() - 1
    }

    fn accessor(&mut self, component: u32, shape: &str, count: usize, bytes: &[u8]) -> usize {
        let view = self.view(bytes);
        self.accessors.push(json!({ "bufferView": view, "componentType": component, "type": shape, "count": count }));
        self.accessors.len() - 1
    }

    fn floats(&mut self, shape: &str, values: &[f32]) -> usize {
        let width = ["SCALAR", "VEC2", "VEC3", "VEC4"].iter().position(|name| *name == shape).map_or(16, |at| at + 1);
        let bytes: Vec<u8> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
        self.accessor(5126, shape, values.len() / width, &bytes)
    }

    fn shorts(&mut self, shape: &str, width: usize, values: &[u16]) -> usize {
        let bytes: Vec<u8> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
        self.accessor(5123, shape, values.len() / width, &bytes)
    }

    fn json(&self, mut rest: Value) -> Value {
        rest["asset"] = json!({ "version": "2.0" });
        rest["buffers"] = json!([{ "byteLength": self.buffer.len() }]);
        rest["bufferViews"] = json!(self.views);
        rest["accessors"] = json!(self.accessors);
        rest
    }

    fn glb(&self, rest: Value) -> Vec<u8> {
        glb(&self.json(rest), &self.buffer)
    }
}

fn glb(json: &Value, buffer: &[u8]) -> Vec<u8> {
    let mut text = json.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    let mut bytes = b"glTF".to_vec();
    for word in [2, 28 + text.len() + buffer.len(), text.len()] {
        bytes.extend((word as u32).to_le_bytes());
    }
    bytes.extend(b"JSON");
    bytes.extend(&text);
    bytes.extend((buffer.len() as u32).to_le_bytes());
    bytes.extend(b"BIN\0");
    bytes.extend(buffer);
    bytes
}

fn no_files(name: &str, _: u64) -> Result<Vec<u8>> {
    Err(Error::invalid(format!("asked for {name}")))
}

fn open(bytes: &[u8]) -> Result<Model> {
    read_gltf(bytes, 1 << 24, &no_files)
}

fn merged(bytes: &[u8]) -> Mesh {
    open(bytes).unwrap().into_merged_mesh(&Context::serial()).unwrap()
}

fn close(found: [f32; 3], expected: [f32; 3]) {
    let far = (0..3).any(|axis| (found[axis] - expected[axis]).abs() > 1e-6);
    assert!(!far, "{found:?} instead of {expected:?}");
}

const TRIANGLE: [f32; 9] = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];

/// A file whose only mesh is one triangle; `change` gets the JSON before it is written.
fn triangle(change: impl FnOnce(&mut File, &mut Value)) -> Vec<u8> {
    let mut file = File::default();
    let positions = file.floats("VEC3", &TRIANGLE);
    let mut rest = json!({
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": positions } }] }],
        "nodes": [{ "mesh": 0 }],
        "scenes": [{ "nodes": [0] }],
        "scene": 0,
    });
    change(&mut file, &mut rest);
    file.glb(rest)
}

#[test]
fn strips_fans_and_missing_indices_make_the_triangles_of_the_standard() {
    let points: Vec<f32> = (0..5).flat_map(|index| [index as f32, (index % 2) as f32, 0.0]).collect();
    let read = |mode: u32, indices: Option<&[u16]>| {
        let mut file = File::default();
        let mut primitive = json!({ "attributes": { "POSITION": file.floats("VEC3", &points) }, "mode": mode });
        if let Some(indices) = indices {
            primitive["indices"] = json!(file.shorts("SCALAR", 1, indices));
        }
        let bytes = file.glb(json!({ "meshes": [{ "primitives": [primitive] }], "nodes": [{ "mesh": 0 }] }));
        merged(&bytes).corners
    };
    assert_eq!(read(5, None), [0, 1, 2, 1, 3, 2, 2, 3, 4]);
    assert_eq!(read(5, Some(&[4, 3, 2, 2, 1])), [4, 3, 2], "joining triangles are left out");
    assert_eq!(read(6, None), [0, 1, 2, 0, 2, 3, 0, 3, 4]);
    assert_eq!(read(4, Some(&[0, 1, 2, 2, 1, 3])), [0, 1, 2, 2, 1, 3]);
    assert!(read(1, None).is_empty(), "lines are no faces");
}

#[test]
fn sparse_and_normalised_arrays_are_read() {
    let bytes = triangle(|file, rest| {
        let places = file.view(&[1]);
        let values = file.view(&[7.0f32, 8.0, 9.0].map(f32::to_le_bytes).concat());
        file.accessors[0]["sparse"] = json!({
            "count": 1,
            "indices": { "bufferView": places, "componentType": 5121 },
            "values": { "bufferView": values },
        });
        let uv = file.accessor(5121, "VEC2", 3, &[0, 255, 51, 0, 255, 255]);
        file.accessors[uv]["normalized"] = json!(true);
        let color = file.accessor(5123, "VEC4", 3, &[0xff; 24]);
        file.accessors[color]["normalized"] = json!(true);
        let normal = file.accessor(5120, "VEC3", 3, &[0, 0, 127, 0, 0, 129, 0, 0, 128]);
        file.accessors[normal]["normalized"] = json!(true);
        let attributes = &mut rest["meshes"][0]["primitives"][0]["attributes"];
        attributes["TEXCOORD_0"] = json!(uv);
        attributes["COLOR_0"] = json!(color);
        attributes["NORMAL"] = json!(normal);
    });
    let mesh = merged(&bytes);
    assert_eq!(mesh.points, [[0.0; 3], [7.0, 8.0, 9.0], [0.0, 1.0, 0.0]]);
    let floats = |name: &str| mesh.attribute(name).unwrap().values.clone();
    assert_eq!(floats("uv"), Values::F32(vec![0.0, 0.0, 0.2, 1.0, 1.0, 0.0]), "v counts upwards");
    assert_eq!(floats("color"), Values::F32(vec![1.0; 12]));
    assert_eq!(floats("normal"), Values::F32(vec![0.0, 0.0, 1.0, 0.0, 0.0, -1.0, 0.0, 0.0, -1.0]));
}

#[test]
fn interleaved_arrays_and_shared_points_are_read_once() {
    let mut file = File::default();
    let mixed: Vec<f32> = TRIANGLE.as_chunks::<3>().0.iter().flat_map(|p| [p[0], p[1], p[2], 0.0, 0.0, 1.0]).collect();
    let view = file.view(&mixed.iter().flat_map(|value| value.to_le_bytes()).collect::<Vec<_>>());
    file.views[view]["byteStride"] = json!(24);
    for offset in [0, 12] {
        file.accessors.push(json!({
            "bufferView": view, "byteOffset": offset, "componentType": 5126, "type": "VEC3", "count": 3,
        }));
    }
    let there = file.shorts("SCALAR", 1, &[0, 1, 2]);
    let back = file.shorts("SCALAR", 1, &[2, 1, 0]);
    let attributes = json!({ "POSITION": 0, "NORMAL": 1 });
    let mesh = merged(&file.glb(json!({
        "materials": [{ "name": "a" }, { "name": "b" }],
        "meshes": [{ "primitives": [
            { "attributes": attributes, "indices": there, "material": 1 },
            { "attributes": attributes, "indices": back },
        ] }],
        "nodes": [{ "mesh": 0 }],
    })));
    assert_eq!(mesh.points.as_flattened(), TRIANGLE);
    assert_eq!(mesh.corners, [0, 1, 2, 2, 1, 0]);
    assert_eq!(mesh.attribute("normal").unwrap().values, Values::F32([0.0, 0.0, 1.0].repeat(3)));
    assert_eq!(mesh.attribute("material").unwrap().values, Values::U32(vec![1, 2]));
}

#[test]
fn nodes_place_meshes_and_mirrors_keep_the_front() {
    let bytes = triangle(|_, rest| {
        rest["nodes"] = json!([
            { "mesh": 0, "scale": [-1, 1, 1], "name": "mirror" },
            { "children": [0], "rotation": [0, 0, 0.707_106_77, 0.707_106_77], "translation": [0, 0, 5] },
            { "mesh": 0, "name": "not in the scene" },
        ]);
        rest["scenes"] = json!([{ "nodes": [1] }]);
    });
    let mesh = merged(&bytes);
    assert_eq!(mesh.points.len(), 3);
    close(mesh.points[1], [0.0, -1.0, 5.0]);
    close(mesh.points[2], [-1.0, 0.0, 5.0]);
    assert_eq!(mesh.corners, [0, 2, 1]);
}

/// A bar along x with a joint at 0 and one at 1, which an animation turns by a right angle about z within one second.
fn bar(change: impl FnOnce(&mut File, &mut Value)) -> Vec<u8> {
    let mut file = File::default();
    let positions = file.floats("VEC3", &[0.0, 0.0, 0.0, 2.0, 0.0, 0.0, 1.5, 0.5, 0.0]);
    let joints = file.accessor(5121, "VEC4", 3, &[0, 9, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0]);
    let weights = file.floats("VEC4", &[1.0, 0.0, 0.0, 0.0, 3.0, 0.0, 0.0, 0.0, 0.25, 0.25, 0.0, 0.0]);
    let identity = [1.0f32, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0];
    let mut second = identity;
    second[12] = -1.0;
    let inverse = file.floats("MAT4", &[identity, second].concat());
    let times = file.floats("SCALAR", &[0.0, 1.0]);
    let half = std::f32::consts::FRAC_1_SQRT_2;
    let turns = file.floats("VEC4", &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, half, half]);
    let mut rest = json!({
        "meshes": [{ "primitives": [{
            "attributes": { "POSITION": positions, "JOINTS_0": joints, "WEIGHTS_0": weights },
        }] }],
        "nodes": [
            // The placement of a skinned mesh does not count.
            { "mesh": 0, "skin": 0, "translation": [100, 0, 0] },
            { "children": [2] },
            { "translation": [1, 0, 0] },
        ],
        "skins": [{ "joints": [1, 2], "inverseBindMatrices": inverse }],
        "animations": [{
            "name": "bend",
            "channels": [{ "sampler": 0, "target": { "node": 2, "path": "rotation" } }],
            "samplers": [{ "input": times, "output": turns }],
        }],
    });
    change(&mut file, &mut rest);
    file.glb(rest)
}

#[test]
fn a_skinned_bar_bends_as_its_joints_turn() {
    let model = open(&bar(|_, _| ())).unwrap();
    let context = Context::serial();
    assert_eq!(model.animation("bend"), Ok(0));
    assert_eq!(model.animation("0"), Ok(0));
    assert!(model.animation("bendt").unwrap_err().to_string().contains("did you mean `bend`?"));
    for time in [-1.0, 0.0, 0.25, 0.5, 1.0, 7.0f64] {
        let points = model.pose(&context, 0, time).unwrap().merged_points();
        let angle = time.clamp(0.0, 1.0) * std::f64::consts::FRAC_PI_2;
        let (sin, cos) = (angle.sin() as f32, angle.cos() as f32);
        close(points[0], [0.0; 3]);
        close(points[1], [1.0 + cos, sin, 0.0]);
        // Half at rest, half turned about (1, 0).
        let turned = [1.0 + 0.5 * cos - 0.5 * sin, 0.5 * sin + 0.5 * cos];
        close(points[2], [0.5 * (1.5 + turned[0]), 0.5 * (0.5 + turned[1]), 0.0]);
    }
    let rest = model.merged_mesh(&context).unwrap();
    close(rest.points[1], [2.0, 0.0, 0.0]);
    assert_eq!(rest.attribute("joints"), None);
    assert!(model.pose(&context, 1, 0.0).is_err());
    assert!(model.pose(&context, 0, f64::NAN).is_err());
    let threads = relievo_core::ContextOptions { threads: 2, memory_limit: 0 };
    let two = Context::new(&threads).unwrap();
    assert_eq!(model.pose(&two, 0, 0.3), model.pose(&context, 0, 0.3));
}

#[test]
fn the_four_joints_with_the_largest_weights_are_used() {
    let model = open(&bar(|file, rest| {
        let joints = file.accessor(5121, "VEC4", 3, &[0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0]);
        // The first point has five joints, the second a negative weight.
        let first = file.floats("VEC4", &[0.1, 0.2, 0.1, 0.1, 0.5, -0.5, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
        let more_joints = file.accessor(5121, "VEC4", 3, &[1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0]);
        let more = file.floats("VEC4", &[0.5, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 3.0, 0.0, 0.0, 0.0]);
        rest["meshes"][0]["primitives"][0]["attributes"] = json!({
            "POSITION": 0, "JOINTS_0": joints, "WEIGHTS_0": first, "JOINTS_1": more_joints, "WEIGHTS_1": more,
        });
    }))
    .unwrap();
    let mesh = &model.meshes[0].mesh;
    let (Some(Values::U32(joints)), Some(Values::F32(weights))) =
        (mesh.attribute("joints").map(|it| &it.values), mesh.attribute("weights").map(|it| &it.values))
    else {
        panic!("{:?}", mesh.attributes)
    };
    assert_eq!(joints[..], [1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0]);
    let expected = [[5.0, 2.0, 1.0, 1.0].map(|weight: f32| weight / 9.0), [1.0, 0.0, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0]];
    weights.iter().zip(expected.as_flattened()).for_each(|(found, expected)| assert!((found - expected).abs() < 1e-6));
    let notes = model.notes.join("; ");
    assert!(notes.contains("a point has more than four joints") && !notes.contains("2 times"), "{notes}");
    assert!(notes.contains("negative weights"), "{notes}");
}

#[test]
fn morph_targets_follow_their_weights() {
    let bytes = triangle(|file, rest| {
        let up = file.floats("VEC3", &[0.0, 0.0, 1.0, 0.0, 0.0, 2.0, 0.0, 0.0, 3.0]);
        // A target without bytes is one of zeros, except where it is sparse.
        let places = file.view(&2u16.to_le_bytes());
        let values = file.view(&[10.0f32, 0.0, 0.0].map(f32::to_le_bytes).concat());
        file.accessors.push(json!({
            "componentType": 5126, "type": "VEC3", "count": 3,
            "sparse": { "count": 1, "indices": { "bufferView": places, "componentType": 5123 }, "values": { "bufferView": values } },
        }));
        let side = file.accessors.len() - 1;
        let times = file.floats("SCALAR", &[1.0, 3.0]);
        let weights = file.floats("SCALAR", &[0.0, 1.0, 1.0, 0.0]);
        rest["meshes"][0]["primitives"][0]["targets"] = json!([{ "POSITION": up }, { "POSITION": side }]);
        rest["meshes"][0]["weights"] = json!([0.5, 0.0]);
        rest["animations"] = json!([{
            "channels": [{ "sampler": 0, "target": { "node": 0, "path": "weights" } }],
            "samplers": [{ "input": times, "output": weights }],
        }]);
    });
    let model = open(&bytes).unwrap();
    let context = Context::serial();
    close(model.merged_mesh(&context).unwrap().points[2], [0.0, 1.0, 1.5]);
    let at = |time: f64| model.pose(&context, 0, time).unwrap().merged_points();
    close(at(1.0)[2], [10.0, 1.0, 0.0]);
    close(at(1.5)[2], [7.5, 1.0, 0.75]);
    close(at(3.0)[1], [1.0, 0.0, 2.0]);
    assert_eq!(model.animations[0].range(), (1.0, 3.0));
}

#[test]
fn curves_step_and_bend() {
    let moved = |interpolation: &str, values: &[f32], time: f64| {
        let bytes = triangle(|file, rest| {
            let times = file.floats("SCALAR", &[0.0, 2.0]);
            let values = file.floats("VEC3", values);
            rest["animations"] = json!([{
                "channels": [{ "sampler": 0, "target": { "node": 0, "path": "translation" } }],
                "samplers": [{ "input": times, "output": values, "interpolation": interpolation }],
            }]);
        });
        open(&bytes).unwrap().pose(&Context::serial(), 0, time).unwrap().merged_points()[0]
    };
    let ends = [1.0, 0.0, 0.0, 3.0, 0.0, 0.0];
    close(moved("STEP", &ends, 1.9), [1.0, 0.0, 0.0]);
    close(moved("STEP", &ends, 2.0), [3.0, 0.0, 0.0]);
    close(moved("LINEAR", &ends, 0.5), [1.5, 0.0, 0.0]);
    // t³ in x, t² in y, 2t in z, from 0 to 2, by values and slopes: a cubic curve gives them back.
    let keys = [[0.0, 0.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 2.0], [12.0, 4.0, 2.0], [8.0, 4.0, 4.0], [0.0, 0.0, 0.0]];
    for time in [0.0, 0.3, 1.0, 1.7, 2.0] {
        let t = time as f32;
        close(moved("CUBICSPLINE", keys.as_flattened(), time), [t * t * t, t * t, 2.0 * t]);
    }
}

#[test]
fn broken_files_are_refused_with_the_element() {
    let cases: Vec<(Vec<u8>, &str)> = vec![
        (b"glTF".to_vec(), "not of version 2"),
        (triangle(|_, _| ())[..100].to_vec(), "the file has 100 bytes"),
        (b"{".to_vec(), "the JSON cannot be read"),
        (b"{\"asset\":{\"version\":\"1.0\"}}".to_vec(), "it is glTF 1.0"),
        (triangle(|_, rest| rest["extensionsRequired"] = json!(["KHR_draco_mesh_compression"])), "KHR_draco"),
        (triangle(|_, rest| rest["nodes"][0]["mesh"] = json!(3)), "node 0: mesh 3 does not exist"),
        (triangle(|_, rest| rest["nodes"] = json!([{ "children": [1] }, { "children": [0] }])), "its own ancestor"),
        (triangle(|_, rest| rest["nodes"] = json!([{ "children": [0] }])), "its own ancestor"),
        (triangle(|_, rest| rest["nodes"] = json!([{ "children": [2] }, { "children": [2] }, {}])), "also a child"),
        (triangle(|_, rest| rest["nodes"] = json!([{ "children": [9] }])), "node 0: its child 9"),
        (triangle(|_, rest| rest["nodes"][0]["rotation"] = json!([0, 0, 0, 0])), "no unit quaternion"),
        (triangle(|_, rest| rest["nodes"][0]["matrix"] = json!(vec![1.0; 16])), "not affine"),
        (triangle(|_, rest| rest["scene"] = json!(2)), "scene 2 does not exist"),
        (triangle(|_, rest| rest["scenes"][0]["nodes"] = json!([7])), "node 7 of the scene"),
        (
            triangle(|_, rest| rest["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = json!(5)),
            "mesh 0, primitive 0: POSITION: accessor 5 does not exist",
        ),
        (triangle(|_, rest| rest["meshes"][0]["primitives"][0]["material"] = json!(5)), "material 5"),
        (triangle(|file, _| file.accessors[0]["count"] = json!(4)), "accessor 0: its 4 elements leave buffer view 0"),
        (triangle(|file, _| file.accessors[0]["count"] = json!(u64::MAX)), "accessor 0"),
        (triangle(|file, _| file.accessors[0]["byteOffset"] = json!(u64::MAX)), "accessor 0"),
        (triangle(|file, _| file.accessors[0]["type"] = json!("VEC2")), "its elements are Vec2"),
        (triangle(|file, _| file.accessors[0]["type"] = json!("VEC9")), "its type is not known"),
        (triangle(|file, _| file.accessors[0]["bufferView"] = Value::Null), "it has no bytes"),
        (triangle(|file, _| file.views[0]["byteStride"] = json!(4)), "its stride 4"),
        (triangle(|file, _| file.views[0]["byteStride"] = json!(0)), "its stride 0"),
        (triangle(|file, _| file.views[0]["byteLength"] = json!(u64::MAX)), "buffer view 0: it leaves"),
        (triangle(|file, _| file.views[0]["buffer"] = json!(3)), "buffer 3 does not exist"),
        (
            triangle(|file, rest| {
                rest["meshes"][0]["primitives"][0]["indices"] = json!(file.shorts("SCALAR", 1, &[0, 1, 3]));
            }),
            "index 2: point 3 does not exist",
        ),
        (
            triangle(|file, rest| {
                rest["meshes"][0]["primitives"][0]["indices"] = json!(file.shorts("SCALAR", 1, &[0, 1]));
            }),
            "2 corners make no whole triangles",
        ),
        (
            triangle(|file, rest| {
                rest["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] = json!(file.floats("VEC3", &[0.0; 6]));
            }),
            "2 elements instead of 3",
        ),
        (triangle(|file, _| file.buffer[..4].copy_from_slice(&f32::NAN.to_le_bytes())), "element 0: a number is not"),
        (bar(|_, rest| rest["skins"][0]["joints"] = json!([1])), "point 1: joint 1 does not exist"),
        (bar(|_, rest| rest["skins"][0]["joints"] = json!([1, 17])), "skin 0: its joint, node 17"),
        (bar(|file, _| file.accessors[3]["count"] = json!(1)), "skin 0: 1 matrices for 2 joints"),
        (bar(|_, rest| rest["animations"][0]["channels"][0]["target"]["node"] = json!(8)), "node 8 does not exist"),
        (bar(|_, rest| rest["animations"][0]["channels"][0]["sampler"] = json!(8)), "sampler 8 does not exist"),
        (bar(|_, rest| rest["animations"][0]["channels"][0]["target"]["path"] = json!("x")), "its path is not known"),
        (bar(|file, _| file.accessors[4]["count"] = json!(1)), "1 keys have 8 numbers instead of 4"),
        (
            bar(|file, rest| {
                rest["animations"][0]["samplers"][0]["input"] = json!(file.floats("SCALAR", &[1.0, 1.0]));
            }),
            "animation 0, channel 0: key 1 is not later than key 0",
        ),
    ];
    for (index, (bytes, expected)) in cases.iter().enumerate() {
        let message = open(bytes).expect_err(expected).to_string();
        assert!(message.contains(expected), "case {index}: {message:?} should contain {expected:?}");
    }
}

#[test]
fn small_files_cannot_become_large_meshes() {
    let bytes = triangle(|_, rest| {
        let primitive = rest["meshes"][0]["primitives"][0].clone();
        rest["meshes"] = json!(vec![json!({ "primitives": [primitive] }); 2000]);
    });
    assert_eq!(read_gltf(&bytes, 300_000, &no_files).unwrap_err().kind, relievo_core::ErrorKind::Memory);
    // Zeros without bytes, as many as the file likes to say.
    let bytes = triangle(|file, rest| {
        file.accessors.push(json!({
            "componentType": 5126, "type": "VEC3", "count": 4_000_000_000u64,
            "sparse": { "count": 0, "indices": { "bufferView": 0, "componentType": 5125 }, "values": { "bufferView": 0 } },
        }));
        rest["meshes"][0]["primitives"][0]["targets"] = json!([{ "POSITION": 1 }]);
    });
    assert!(read_gltf(&bytes, u64::MAX, &no_files).unwrap_err().to_string().contains("instead of 3"));
}

#[test]
fn buffers_come_from_the_file_or_from_below_its_folder() {
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path().join("scene");
    std::fs::create_dir_all(folder.join("sub")).unwrap();
    let mut file = File::default();
    let positions = file.floats("VEC3", &TRIANGLE);
    let rest = json!({ "meshes": [{ "primitives": [{ "attributes": { "POSITION": positions } }] }], "nodes": [{ "mesh": 0 }] });
    for place in ["scene/with space.bin", "scene/sub/a.bin", "outside.bin"] {
        std::fs::write(temporary.path().join(place), &file.buffer).unwrap();
    }
    let path = folder.join("a.gltf");
    let with = |uri: &str| {
        let mut json = file.json(rest.clone());
        json["buffers"][0]["uri"] = json!(uri);
        std::fs::write(&path, json.to_string()).unwrap();
    };
    let context = Context::serial();
    let base64 = "data:application/octet-stream;base64,\
                  AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA";
    for good in ["with%20space.bin", "sub/a.bin", "./sub/../sub/a.bin", base64] {
        with(good);
        let model = read_model(&context, &path).unwrap();
        assert_eq!(model.meshes[0].mesh.points.as_flattened(), TRIANGLE, "{good}");
    }
    let outside = temporary.path().join("outside.bin");
    let bad = [
        ("../outside.bin", "outside the folders"),
        ("%2e%2e/outside.bin", "outside the folders"),
        (outside.to_str().unwrap(), "outside the folders"),
        ("http://example.com/a.bin", "nothing is fetched"),
        ("none.bin", "buffer 0: "),
        ("sub", "it is not a file"),
        ("data:text/plain,abc", "not in base 64"),
    ];
    for (uri, expected) in bad {
        with(uri);
        let message = read_model(&context, &path).unwrap_err().to_string();
        assert!(message.contains(expected), "{message:?} should contain {expected:?}");
    }
    with("../outside.bin");
    let root = Root::below(&folder).unwrap().allow(temporary.path()).unwrap();
    assert!(read_model_within(&context, &path, &root).is_ok());
}
