//! Damaged files: readers return, with a mesh whose indices exist or with an error, and never panic.

use proptest::prelude::*;
use relievo_core::{Context, Error, Mesh, Result};
use relievo_meshio::{
    Instance, Model, Root, read_gltf, read_obj, read_off, read_ply, read_stl, read_usd, write_glb, write_ply,
};

const OBJ: &str = "# seed\no thing\nv 0 0 0 1 .5 .25\nv 1 0 0\nv 1 1 0\nv 0 1 1e-3\nvt 0 0\nvt 1 1\nvn 0 0 1\nusemtl a\n\
                   f 1/1/1 2/2/1 3/1/1 \\\n 4/2/1\nf -4//-1 -3//1 -2//1\ng b c\nusemtl d\nf 1 2 4\nl 1 2\n\
                   t crease 3/2/0 0 1 2 1 2\nt corner 1/1/0 3 9.5\nt hole 1/0/0 1\nt other 0/0/1 x\n";

const PLY: &str = "ply\nformat ascii 1.0\ncomment seed\nelement vertex 4\nproperty float x\nproperty float y\n\
                   property double z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\n\
                   element face 2\nproperty list uchar int vertex_indices\nproperty list uchar float texcoord\n\
                   property short tag\nelement tristrips 1\nproperty list int int vertex_indices\nend_header\n\
                   0 0 0 1 2 3\n1 0 0 4 5 6\n1 1 0 7 8 9\n0 1 0 1 1 1\n4 0 1 2 3 8 0 0 1 0 1 1 0 1 -3\n\
                   3 0 1 2 6 0 0 1 0 1 1 4\n6 0 1 2 -1 3 1\n";

const STL: &str = "solid seed\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\n\
                   endfacet\nendsolid seed\n";

const OFF: &str = "CNOFF\n3 1 3 # seed\n0 0 0 0 0 1 9 9 9 9\n1 0 0 0 0 1 9 9 9 9\n0 1 0 0 0 1 9 9 9 9\n3 0 1 2 1 0 0\n";

const USDA: &str = "#usda 1.0\n(\n defaultPrim = \"a\"\n metersPerUnit = 0.5\n upAxis = \"Z\"\n subLayers = [@x.usda@]\n)\n\
                    def Xform \"a\" (\n variants = { string v = \"w\" }\n prepend variantSets = \"v\"\n) {\n \
                    double3 xformOp:translate.timeSamples = { 1: (0, 1, 2), 2.5: (3, 4, 5) }\n float xformOp:rotateX = 9\n \
                    uniform token[] xformOpOrder = [\"xformOp:translate\", \"!invert!xformOp:rotateX\"]\n \
                    def Mesh \"m\" (\n  inherits = </c>\n ) {\n  point3f[] points.timeSamples = {\n   1: [(0, 0, 0), (1, 0, 0), \
                    (0, 1, 0), (1, 1, 1)],\n   2: [(0, 0, 0), (1, 0, 0), (0, 1, 0), (1, 1, 2)],\n  }\n  \
                    int[] faceVertexCounts = [3, 3]\n  int[] faceVertexIndices = [0, 1, 2, 2, 1, 3]\n  \
                    uniform token orientation = \"leftHanded\"\n  int[] creaseIndices = [0, 1, 3]\n  int[] creaseLengths = [3]\n  \
                    float[] creaseSharpnesses = [1.5]\n  texCoord2f[] primvars:st = [(0, 0), (1, 1)] ( interpolation = \
                    \"faceVarying\" )\n  int[] primvars:st:indices = [0, 1, 0, 1, 0, 1]\n  def GeomSubset \"s\" { int[] indices = \
                    [1] }\n }\n variantSet \"v\" = {\n  \"w\" { def \"n\" ( references = </a/m> ) {} }\n }\n}\n\
                    class \"c\" { vector3f[] velocities = [(0, 0, 1), (0, 0, 1), (0, 0, 1), (0, 0, 1)] }\n";

fn usda(bytes: &[u8]) -> Result<Model> {
    read_usd(bytes.to_vec(), 1 << 20, std::path::Path::new("."), &Root::none())
}

/// A binary stage of OpenUSD's with time samples, packed arrays, list operations and dictionaries.
const USDC: &[u8] = include_bytes!("../../../../tests/fuzz/seeds/usd/seed.usdc");

fn binary_ply() -> Vec<u8> {
    written("seed.ply", write_ply)
}

fn glb() -> Vec<u8> {
    written("seed.glb", |path, mesh| write_glb(path, &[Instance::new("seed", mesh)]))
}

fn written(name: &str, write: impl Fn(&std::path::Path, &Mesh) -> Result<()>) -> Vec<u8> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    let mesh = read_obj(OBJ.as_bytes(), u64::MAX).unwrap().meshes.remove(0).mesh;
    write(&path, &mesh).unwrap();
    std::fs::read(path).unwrap()
}

/// A file with a skin, a morph target and an animation, whose bytes lie in the text.
const GLTF: &str = r#"{"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0,1]}],
"nodes":[{"mesh":0,"skin":0},{"children":[2],"translation":[1,0,0]},{"rotation":[0,0,0,1]}],
"meshes":[{"primitives":[{"attributes":{"POSITION":0,"JOINTS_0":1,"WEIGHTS_0":2},"targets":[{"POSITION":0}]}],"weights":[0.5]}],
"skins":[{"joints":[1,2]}],
"animations":[{"channels":[{"sampler":0,"target":{"node":2,"path":"translation"}},{"sampler":1,"target":{"node":0,"path":"weights"}}],
"samplers":[{"input":3,"output":4},{"input":3,"output":5,"interpolation":"STEP"}]}],
"accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"},{"bufferView":1,"componentType":5121,"count":3,"type":"VEC4"},
{"bufferView":0,"componentType":5126,"count":3,"type":"VEC4"},{"bufferView":0,"byteOffset":8,"componentType":5126,"count":2,"type":"SCALAR"},
{"bufferView":0,"componentType":5126,"count":2,"type":"VEC3"},{"bufferView":0,"componentType":5126,"count":2,"type":"SCALAR"}],
"bufferViews":[{"buffer":0,"byteLength":48},{"buffer":0,"byteOffset":36,"byteLength":12}],
"buffers":[{"byteLength":48,"uri":"data:;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAAAAAAAAAAAAAAAAAA"}]}"#;

fn no_files(_: &str, _: u64) -> Result<Vec<u8>> {
    Err(Error::invalid("no files"))
}

/// What a reader may return: every index exists, every number is finite, so that nothing later can go wrong but
/// what [`Mesh::check`] looks for.
fn sound(model: &Model) {
    for part in &model.meshes {
        let mesh = &part.mesh;
        let total: u64 = mesh.face_sizes.iter().map(|size| u64::from(*size)).sum();
        assert_eq!(total, mesh.corners.len() as u64);
        assert!(mesh.corners.iter().all(|point| (*point as usize) < mesh.points.len()));
        if let Err(error) = mesh.check() {
            let what = error.what.as_str();
            let allowed = ["is empty", "it has 0 corners", "it has 1 corners", "it has 2 corners", "is repeated"];
            assert!(allowed.iter().any(|allowed| what.ends_with(allowed)), "{error}");
        }
        assert!(part.targets.iter().all(|target| target.len() == mesh.points.len()));
        assert_eq!(part.weights.len(), part.targets.len());
    }
    let context = Context::serial();
    let merged = model.merged_mesh(&context).unwrap();
    for animation in 0..model.animations.len() {
        let points = model.pose(&context, animation, 0.5).unwrap().merged_points();
        assert_eq!(points.len(), merged.points.len());
    }
}

/// A change of a file.
#[derive(Clone, Debug)]
enum Damage {
    Cut(prop::sample::Index),
    Set(prop::sample::Index, u8),
    Digit(prop::sample::Index, u8),
    Repeat(prop::sample::Index, prop::sample::Index),
    Remove(prop::sample::Index, u8),
}

fn damage() -> impl Strategy<Value = Vec<Damage>> {
    let any_index = any::<prop::sample::Index>;
    let one = prop_oneof![
        1 => any_index().prop_map(Damage::Cut),
        3 => (any_index(), any::<u8>()).prop_map(|(at, value)| Damage::Set(at, value)),
        4 => (any_index(), 0..10u8).prop_map(|(at, digit)| Damage::Digit(at, digit)),
        1 => (any_index(), any_index()).prop_map(|(from, to)| Damage::Repeat(from, to)),
        2 => (any_index(), 1..20u8).prop_map(|(at, count)| Damage::Remove(at, count)),
    ];
    prop::collection::vec(one, 1..6)
}

fn apply(seed: &[u8], list: &[Damage]) -> Vec<u8> {
    let mut bytes = seed.to_vec();
    for damage in list {
        if bytes.is_empty() {
            break;
        }
        let length = bytes.len();
        match damage {
            Damage::Cut(at) => bytes.truncate(at.index(length)),
            Damage::Set(at, value) => bytes[at.index(length)] = *value,
            Damage::Digit(at, digit) => {
                // A digit becomes another, so that the rest still makes sense.
                let start = at.index(length);
                if let Some(at) = (start..length).find(|at| bytes[*at].is_ascii_digit()) {
                    bytes[at] = b'0' + digit;
                }
            }
            Damage::Repeat(from, to) => {
                let (from, to) = (from.index(length), to.index(length));
                let piece = bytes[from.min(to)..from.max(to)].to_vec();
                bytes.splice(to..to, piece);
            }
            Damage::Remove(at, count) => {
                let start = at.index(length);
                bytes.drain(start..(start + usize::from(*count)).min(length));
            }
        }
    }
    bytes
}

fn check(read: Result<Model>) {
    if let Ok(model) = read {
        sound(&model);
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 600, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn obj(list in damage()) {
        check(read_obj(&apply(OBJ.as_bytes(), &list), 1 << 20));
    }

    #[test]
    fn ply_text(list in damage()) {
        check(read_ply(&apply(PLY.as_bytes(), &list), 1 << 20));
    }

    #[test]
    fn ply_binary(list in damage()) {
        check(read_ply(&apply(&binary_ply(), &list), 1 << 20));
    }

    #[test]
    fn gltf_text(list in damage()) {
        check(read_gltf(&apply(GLTF.as_bytes(), &list), 1 << 20, &no_files));
    }

    #[test]
    fn gltf_binary(list in damage()) {
        check(read_gltf(&apply(&glb(), &list), 1 << 20, &no_files));
    }

    #[test]
    fn stl(list in damage()) {
        check(read_stl(&apply(STL.as_bytes(), &list), 1 << 20));
    }

    #[test]
    fn off(list in damage()) {
        check(read_off(&apply(OFF.as_bytes(), &list), 1 << 20));
    }

    #[test]
    fn usd_text(list in damage()) {
        check(usda(&apply(USDA.as_bytes(), &list)));
    }

    #[test]
    fn usd_binary(list in damage()) {
        check(usda(&apply(USDC, &list)));
    }

    #[test]
    fn any_bytes(bytes in prop::collection::vec(any::<u8>(), 0..300)) {
        check(read_obj(&bytes, 1 << 20));
        check(read_ply(&[b"ply\n", bytes.as_slice()].concat(), 1 << 20));
        check(read_gltf(&bytes, 1 << 20, &no_files));
        check(read_stl(&bytes, 1 << 20));
        check(read_off(&[b"OFF 3 2 0\n", bytes.as_slice()].concat(), 1 << 20));
        check(usda(&[b"#usda 1.0\n", bytes.as_slice()].concat()));
        check(usda(&[b"PXR-USDC\0\x08\0\0\0\0\0\0\x18\0\0\0\0\0\0\0", bytes.as_slice()].concat()));
        check(read_gltf(&[b"glTF\x02\0\0\0", bytes.as_slice()].concat(), 1 << 20, &no_files));
    }
}

#[test]
fn the_seeds_are_good() {
    sound(&read_obj(OBJ.as_bytes(), 1 << 20).unwrap());
    sound(&read_ply(PLY.as_bytes(), 1 << 20).unwrap());
    sound(&read_ply(&binary_ply(), 1 << 20).unwrap());
    sound(&read_gltf(GLTF.as_bytes(), 1 << 20, &no_files).unwrap());
    sound(&read_gltf(&glb(), 1 << 20, &no_files).unwrap());
    sound(&read_stl(STL.as_bytes(), 1 << 20).unwrap());
    sound(&read_off(OFF.as_bytes(), 1 << 20).unwrap());
    sound(&usda(USDA.as_bytes()).unwrap());
    sound(&usda(USDC).unwrap());
}

/// Sizes that a header only claims cost nothing.
#[test]
fn claims_are_checked_before_memory_is_taken() {
    let header = |rows: &str, list: &str| {
        format!(
            "ply\nformat binary_little_endian 1.0\nelement vertex {rows}\nproperty float x\nproperty float y\n\
             property float z\nelement face 1\nproperty list {list} int vertex_indices\nend_header\n"
        )
    };
    for rows in ["4294967295", "18446744073709551615", "1000000"] {
        assert!(read_ply(header(rows, "uint").as_bytes(), u64::MAX).is_err());
    }
    let mut bytes = header("1", "uint").into_bytes();
    bytes.extend([0; 12]);
    bytes.extend(u32::MAX.to_le_bytes());
    assert!(read_ply(&bytes, u64::MAX).unwrap_err().to_string().contains("the file ends here"));
    let long = format!("t crease {}/1/0 0 1 1\n", i64::MAX);
    assert!(read_obj(long.as_bytes(), u64::MAX).is_err());
}

/// Time grows with the length, not with its square: a hundred times the length is done in a test's time.
#[test]
fn long_files_of_odd_shapes_end() {
    let many = 200_000;
    let context = Context::serial();
    let materials: String = (0..many).map(|index| format!("usemtl m{index}\nf 1 2 3\n")).collect();
    let model = read_obj(format!("v 0 0 0\nv 1 0 0\nv 0 1 0\n{materials}").as_bytes(), u64::MAX).unwrap();
    assert_eq!(model.materials.len(), many);
    let unknown: String = (0..many).map(|index| format!("word{index} 1\n")).collect();
    assert!(read_obj(unknown.as_bytes(), u64::MAX).unwrap().notes.len() < 20);
    let fan = format!(
        "v 0 0 0\nv 1 0 0\n{}{}",
        "v 0 1 0\n".repeat(many),
        (3..many).map(|i| format!("f 1 2 {i}\n")).collect::<String>()
    );
    assert_eq!(read_obj(fan.as_bytes(), u64::MAX).unwrap().meshes[0].mesh.face_count(), many - 3);
    let columns: String = (0..many / 10).map(|index| format!("property float c{index}\n")).collect();
    let ply = format!(
        "ply\nformat ascii 1.0\nelement vertex 0\nproperty float x\nproperty float y\nproperty float z\n{columns}end_header\n"
    );
    read_ply(ply.as_bytes(), u64::MAX).unwrap();
    let elements: String = (0..many).map(|index| format!("element e{index} 0\nproperty float x\n")).collect();
    let ply = format!("ply\nformat ascii 1.0\n{elements}end_header\n");
    assert!(read_ply(ply.as_bytes(), u64::MAX).unwrap().notes.len() < 20);
    // A chain of nodes as deep as the file is long.
    let nodes: String = (1..many).map(|index| format!("{{\"children\":[{index}]}},")).collect();
    let chain = format!("{{\"asset\":{{\"version\":\"2.0\"}},\"nodes\":[{nodes}{{}}]}}");
    let model = read_gltf(chain.as_bytes(), u64::MAX, &no_files).unwrap();
    assert_eq!(model.rest(&context).matrices.len(), many);
    // Many nodes with one mesh of many points, many attributes of one primitive.
    let mut file: serde_json::Value = serde_json::from_str(GLTF).unwrap();
    file["nodes"] = serde_json::json!(vec![serde_json::json!({ "mesh": 0 }); many]);
    file["scenes"] = serde_json::json!([]);
    file["scene"] = serde_json::Value::Null;
    file["skins"] = serde_json::Value::Null;
    file.as_object_mut().unwrap().retain(|_, value| !value.is_null());
    file["animations"] = serde_json::json!([]);
    file["meshes"][0]["primitives"][0]["targets"] =
        serde_json::json!(vec![serde_json::json!({ "POSITION": 0 }); 10_000]);
    let error = read_gltf(file.to_string().as_bytes(), u64::MAX, &no_files).unwrap_err();
    assert_eq!(error.kind, relievo_core::ErrorKind::Memory);
    let sets: String = (0..many).map(|index| format!(",\"TEXCOORD_{index}\":0")).collect();
    let sets = GLTF.replace("\"POSITION\":0,", &format!("\"POSITION\":0{sets},"));
    assert!(read_gltf(sets.as_bytes(), u64::MAX, &no_files).is_err());
    let nested = format!("{}{}", "[".repeat(many), "]".repeat(many));
    assert!(read_gltf(nested.as_bytes(), u64::MAX, &no_files).is_err());
}
