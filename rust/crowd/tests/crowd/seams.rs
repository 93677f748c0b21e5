//! Attributes on both sides of seams and creases, and characters of several skins.

use glam::{DQuat, DVec3, Vec3};
use relievo_core::progress::Silent;
use relievo_core::{Attribute, Context, Domain, Mesh, Values};
use relievo_crowd::{Blend, BuildSettings, CrowdModel, skin};
use relievo_meshio::Model;

use crate::arm::arm;
use crate::skinning::evaluated;

const SETTINGS: (u32, f32) = (30, 6.0);

fn built(source: &Model, clips: &[usize]) -> CrowdModel {
    let (cluster_triangles, pose_rate) = SETTINGS;
    let settings = BuildSettings { cluster_triangles, pose_rate, group_clusters: 4, ..BuildSettings::default() };
    CrowdModel::build(&Context::serial(), source, clips, &settings, &mut Silent).unwrap()
}

fn attribute(name: &str, width: u32, values: Vec<f32>) -> Attribute {
    Attribute { name: name.into(), domain: Domain::Point, width, values: Values::F32(values), indices: None }
}

#[test]
fn colours_stay_on_their_side_of_a_seam() {
    // Rings in the lower half are red, those above blue; the ring between is there in both colours.
    let (rings, sides) = (33, 12);
    let mut source = arm(rings, sides);
    let mesh = &mut source.meshes[0].mesh;
    let (middle, columns) = (rings / 2, sides + 1);
    let is_high: Vec<bool> = (0..mesh.points.len()).map(|vertex| mesh.points[vertex][1] > 1.5 + 1e-4).collect();
    let count = mesh.points.len();
    let first = middle * columns;
    // Copies for the upper side.
    mesh.points.extend_from_within(first..first + columns);
    for attribute in &mut mesh.attributes {
        let width = attribute.width as usize;
        match &mut attribute.values {
            Values::F32(values) => values.extend_from_within(first * width..(first + columns) * width),
            Values::U32(values) => values.extend_from_within(first * width..(first + columns) * width),
        }
    }
    for corners in mesh.corners.chunks_exact_mut(3) {
        if corners.iter().any(|vertex| is_high[*vertex as usize]) {
            for vertex in corners.iter_mut().filter(|vertex| (first..first + columns).contains(&(**vertex as usize))) {
                *vertex += (count - first) as u32;
            }
        }
    }
    let blue = |vertex: usize| vertex >= count || is_high[vertex];
    let colors = (0..mesh.points.len()).flat_map(|at| if blue(at) { [0.0, 0.0, 1.0] } else { [1.0, 0.0, 0.0] });
    mesh.attributes.push(attribute("color", 3, colors.collect()));
    let model = built(&source, &[0]);
    let colors = model.character.values("color").unwrap();
    let color = |vertex: u32| &colors[3 * vertex as usize..][..3];
    let mut ended = 0;
    for error in [0.0, 0.01, 0.03, 0.1, f32::INFINITY] {
        let cut = model.cut(error);
        let mut sides = [Vec::new(), Vec::new()];
        for triangle in cut.iter().flat_map(|cluster| model.triangles(*cluster)) {
            let own = color(triangle[0]);
            assert!(triangle.iter().all(|vertex| color(*vertex) == own), "a triangle of two colours at {error}");
            for vertex in triangle {
                let point = model.character.points[*vertex as usize];
                if (point[1] - 1.5).abs() < 1e-4 {
                    sides[usize::from(own[0] == 0.0)].push(point.map(f32::to_bits));
                }
            }
        }
        // Both sides end at the same places of the seam.
        for side in &mut sides {
            side.sort_unstable();
            side.dedup();
        }
        assert!(!sides[0].is_empty() && sides[0] == sides[1], "the seam opens at {error}");
        ended = sides[0].len();
    }
    assert!(ended < sides, "the seam is simplified too: {ended} places");
}

#[test]
fn normals_stay_on_their_side_of_creases() {
    // A box of grids, each side with its own normal.
    const STEPS: u32 = 8;
    let (mut points, mut normals, mut triangles) = (Vec::new(), Vec::new(), Vec::new());
    for (axis, sign) in (0..3).flat_map(|axis| [(axis, -1.0f32), (axis, 1.0)]) {
        let first = points.len() as u32;
        let normal: [f32; 3] = std::array::from_fn(|at| if at == axis { sign } else { 0.0 });
        for at in 0..(STEPS + 1) * (STEPS + 1) {
            let [u, v] = [at % (STEPS + 1), at / (STEPS + 1)].map(|step| 2.0 * step as f32 / STEPS as f32 - 1.0);
            let mut point = normal;
            (point[(axis + 1) % 3], point[(axis + 2) % 3]) = (u, v);
            points.push(point);
            normals.extend(normal);
        }
        for at in 0..STEPS * STEPS {
            let a = first + at / STEPS * (STEPS + 1) + at % STEPS;
            let (b, c, d) = (a + 1, a + STEPS + 2, a + STEPS + 1);
            let quad = if sign > 0.0 { [[a, b, c], [a, c, d]] } else { [[a, c, b], [a, d, c]] };
            triangles.extend(quad);
        }
    }
    let mut mesh = Mesh::from_triangles(points, &triangles);
    mesh.attributes.push(attribute("normal", 3, normals));
    let model = built(&Model::from_mesh(mesh), &[]);
    let normals = model.character.values("normal").unwrap();
    // The sides are flat, so the box is left at hardly any error.
    for error in [0.0, 1e-5] {
        let cut = model.cut(error * model.size());
        for triangle in cut.iter().flat_map(|cluster| model.triangles(*cluster)) {
            let [a, b, c] = triangle.map(|vertex| Vec3::from(model.character.points[vertex as usize]));
            let normal = (b - a).cross(c - a).normalize();
            for vertex in triangle {
                let own = Vec3::from_slice(&normals[3 * *vertex as usize..][..3]);
                assert!(own.dot(normal) > 0.999, "{own} on a triangle across {normal} at {error}");
            }
        }
    }
    let left = model.triangle_count(&model.cut(1e-5 * model.size()));
    assert!(left < u64::from(model.input_triangles) / 4, "{left} triangles are left");
}

/// Returns a binary glTF of two prisms of two bones each. Each has a skin of its own, with the joints of the other order, and
/// the upper bones turn in one clip.
fn two_skins() -> Vec<u8> {
    let mut parts: [Vec<u8>; 8] = Default::default();
    let floats = |values: &[f32]| values.iter().flat_map(|value| value.to_le_bytes()).collect::<Vec<u8>>();
    for ring in 0..9 {
        for side in 0..6 {
            let (angle, height) = (std::f32::consts::TAU * side as f32 / 6.0, 0.25 * ring as f32);
            parts[0].extend(floats(&[0.3 * angle.cos(), height, 0.3 * angle.sin()]));
            let share = (height - 0.5).clamp(0.0, 1.0);
            parts[2].extend(floats(&[1.0 - share, share, 0.0, 0.0]));
            parts[1].extend([0, 1, 0, 0]);
            if ring < 8 {
                let (low, next) = (6 * ring + side, 6 * ring + (side + 1) % 6);
                let corners = [low, low + 6, next + 6, low, next + 6, next].map(|corner: i32| corner as u16);
                parts[3].extend(corners.into_iter().flat_map(u16::to_le_bytes));
            }
        }
    }
    parts[4] = floats(&[0.0, 1.0]);
    let turn = |angle: f64| DQuat::from_rotation_z(angle).to_array().map(|value| value as f32);
    parts[5] = floats(&[turn(0.0), turn(1.2)].concat());
    let identity = |height: f32| [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, height, 0.0, 1.0];
    parts[6] = floats(&[identity(0.0), identity(-1.0)].concat());
    // The joints of the second skin are half as high.
    parts[7] = floats(&[identity(0.0), identity(-0.5)].concat());
    let mut start = 0;
    let views: Vec<String> = parts
        .iter()
        .map(|part| {
            start += part.len();
            format!(r#"{{"buffer":0,"byteOffset":{},"byteLength":{}}}"#, start - part.len(), part.len())
        })
        .collect();
    let accessor = |part: usize, kind: u32, count: usize, form: &str| {
        format!(r#"{{"bufferView":{part},"componentType":{kind},"count":{count},"type":"{form}"}}"#)
    };
    let limited = |part: usize, count: usize, form: &str, low: &str, high: &str| {
        format!(
            r#"{{"bufferView":{part},"componentType":5126,"count":{count},"type":"{form}","min":{low},"max":{high}}}"#
        )
    };
    let accessors = [
        limited(0, 54, "VEC3", "[-0.3,0,-0.3]", "[0.3,2,0.3]"),
        accessor(1, 5121, 54, "VEC4"),
        accessor(2, 5126, 54, "VEC4"),
        accessor(3, 5123, 288, "SCALAR"),
        limited(4, 2, "SCALAR", "[0]", "[1]"),
        accessor(5, 5126, 2, "VEC4"),
        accessor(6, 5126, 2, "MAT4"),
        accessor(7, 5126, 2, "MAT4"),
    ];
    let buffer = parts.concat();
    let mut text = format!(
        r#"{{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0,1,2,4]}}],
        "nodes":[{{"mesh":0,"skin":0}},{{"mesh":0,"skin":1}},{{"children":[3]}},{{"translation":[0,1,0]}},
        {{"translation":[3,0,0],"children":[5]}},{{"translation":[0,0.5,0]}}],
        "skins":[{{"joints":[2,3],"inverseBindMatrices":6}},{{"joints":[4,5],"inverseBindMatrices":7}}],
        "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0,"JOINTS_0":1,"WEIGHTS_0":2}},"indices":3}}]}}],
        "animations":[{{"name":"turn","channels":[{{"sampler":0,"target":{{"node":3,"path":"rotation"}}}},
        {{"sampler":0,"target":{{"node":5,"path":"rotation"}}}}],"samplers":[{{"input":4,"output":5}}]}}],
        "buffers":[{{"byteLength":{}}}],"bufferViews":[{}],"accessors":[{}]}}"#,
        buffer.len(),
        views.join(","),
        accessors.join(",")
    );
    while !text.len().is_multiple_of(4) {
        text.push(' ');
    }
    let length = |bytes: usize| (bytes as u32).to_le_bytes();
    let chunk = |kind: &[u8; 4], bytes: &[u8]| [&length(bytes.len()), &kind[..], bytes].concat();
    let chunks = [chunk(b"JSON", text.as_bytes()), chunk(b"BIN\0", &buffer)].concat();
    [&b"glTF"[..], &2u32.to_le_bytes(), &length(12 + chunks.len()), &chunks].concat()
}

#[test]
fn each_mesh_follows_its_own_skin() {
    let bytes = two_skins();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("two.glb");
    std::fs::write(&path, &bytes).unwrap();
    let context = Context::serial();
    let model = built(&relievo_meshio::read_model(&context, &path).unwrap(), &[0]);
    assert_eq!((model.input_triangles, model.character.bones.len()), (192, 4));
    for (frame, pose) in model.clips[0].poses.iter().enumerate() {
        let ours = skin(&context, &model.character, pose, Blend::Linear).unwrap();
        let theirs = evaluated(&bytes, 0, frame as f64 / f64::from(SETTINGS.1));
        assert_eq!(ours.len(), theirs.len());
        for (ours, theirs) in ours.iter().zip(theirs) {
            let off = DVec3::from(ours.map(f64::from)).distance(theirs);
            assert!(off < 1e-5, "pose {frame}: {off}");
        }
    }
    // No triangle of any cut has corners of both.
    let is_second = |vertex: &u32| model.character.influences[*vertex as usize].bones[0] >= 2;
    for group in &model.groups {
        for triangle in model.cut(group.error).iter().flat_map(|cluster| model.triangles(*cluster)) {
            assert_eq!(triangle.iter().filter(|vertex| is_second(vertex)).count() % 3, 0);
        }
    }
}
