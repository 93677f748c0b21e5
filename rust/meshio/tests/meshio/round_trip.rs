//! What is written is read back as it was, by our readers and by the `gltf` crate's own.

use std::path::Path;

use glam::{DAffine3, DQuat, DVec3};
use relievo_core::{Attribute, Context, Crease, Domain, Mesh, Values};
use relievo_meshio::{Instance, read, read_model, write, write_glb, write_obj};

fn attribute(name: &str, domain: Domain, width: u32, values: Values) -> Attribute {
    Attribute { name: name.into(), domain, width, values, indices: None }
}

/// A quad and a pentagon with everything that a mesh can have.
fn rich() -> Mesh {
    let points = (0..7).map(|index| [index as f32 * 0.1, (index * index) as f32 / 3.0, -1e-7]).collect();
    let mut mesh = Mesh::new(points, vec![4, 5], vec![0, 1, 2, 3, 3, 2, 4, 5, 6]);
    let seam = Values::F32(vec![0.0, 0.0, 1.0, 0.0, 1.0, 0.25, 0.0, 1.0, 0.5, 0.75]);
    let indices = Some(vec![0, 1, 2, 3, 4, 2, 1, 0, 4]);
    mesh.attributes = vec![
        Attribute { indices, ..attribute("uv", Domain::Corner, 2, seam) },
        attribute("normal", Domain::Point, 3, Values::F32([0.0, 0.6, 0.8].repeat(7))),
        attribute("color", Domain::Point, 3, Values::F32([1.0, 0.0, 1.0].repeat(7))),
        attribute("material", Domain::Face, 1, Values::U32(vec![1, 0])),
    ];
    mesh.creases = vec![Crease { points: [2, 3], sharpness: 2.5 }];
    mesh.sharp_points = vec![(4, 10.0)];
    mesh
}

#[test]
fn obj_keeps_everything() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("rich.obj");
    let mut mesh = rich();
    mesh.holes = vec![1];
    write_obj(&path, &mesh, &["ice".into(), "deep\nsnow".into()]).unwrap();
    let model = read_model(&Context::serial(), &path).unwrap();
    // Slots are numbered in the order of the file.
    assert_eq!(model.materials, ["deep snow", "ice"]);
    let mut found = model.into_merged_mesh(&Context::serial()).unwrap();
    found.attributes.iter_mut().filter(|attribute| attribute.name == "material").for_each(|attribute| {
        assert_eq!(attribute.values, Values::U32(vec![0, 1]));
        attribute.values = Values::U32(vec![1, 0]);
    });
    // Normals with the indices of points need not be of the file, as long as they are the same.
    for name in ["uv", "normal", "color", "material"] {
        assert_eq!(found.attribute(name), mesh.attribute(name), "{name}");
    }
    found.attributes = mesh.attributes.clone();
    assert_eq!(found, mesh);
}

#[test]
fn ply_keeps_everything_but_tags() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("rich.ply");
    let mut mesh = rich();
    mesh.attributes.push(attribute("heat", Domain::Point, 1, Values::F32((0..7).map(|v| v as f32 / 7.0).collect())));
    mesh.attributes.push(attribute("velocity", Domain::Point, 3, Values::F32(vec![0.3; 21])));
    write(&path, &mesh).unwrap();
    let found = read(&Context::serial(), &path).unwrap();
    assert_eq!((&found.points, &found.face_sizes, &found.corners), (&mesh.points, &mesh.face_sizes, &mesh.corners));
    for name in ["normal", "color", "material", "heat", "velocity"] {
        assert_eq!(found.attribute(name), mesh.attribute(name), "{name}");
    }
    assert_eq!(corner_values(&found, "uv"), corner_values(&mesh, "uv"));
}

/// The floats of an attribute at every corner, wherever it sits.
fn corner_values(mesh: &Mesh, name: &str) -> Vec<f32> {
    let Attribute { domain, width, values: Values::F32(values), indices, .. } = mesh.attribute(name).unwrap() else {
        panic!("{name}")
    };
    let value = |index: usize| &values[index * *width as usize..(index + 1) * *width as usize];
    (0..mesh.corners.len())
        .flat_map(|corner| match (domain, indices) {
            (Domain::Point, _) => value(mesh.corners[corner] as usize),
            (_, Some(indices)) => value(indices[corner] as usize),
            (_, None) => value(corner),
        })
        .copied()
        .collect()
}

#[test]
fn glb_keeps_triangles_attributes_and_places() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("rich.glb");
    let mut mesh = rich();
    mesh.attributes.pop();
    let transform = DAffine3::from_rotation_translation(DQuat::from_rotation_z(0.5), DVec3::new(1.0, 2.0, 3.0));
    write_glb(&path, &[Instance::new("here", &mesh), Instance { transform, ..Instance::new("there", &mesh) }]).unwrap();

    let model = read_model(&Context::serial(), &path).unwrap();
    assert_eq!(model.nodes.iter().map(|node| node.name.as_str()).collect::<Vec<_>>(), ["here", "there"]);
    let part = &model.meshes[0].mesh;
    assert_eq!(part.check(), Ok(()));
    // Two triangles of the quad, three of the pentagon, fanned.
    let fans = [0, 1, 2, 0, 2, 3, 4, 5, 6, 4, 6, 7, 4, 7, 8];
    let expect = |name: &str, width: usize| -> Vec<f32> {
        let values = corner_values(&mesh, name);
        fans.iter().flat_map(|corner| values[corner * width..(corner + 1) * width].to_vec()).collect()
    };
    let positions: Vec<_> = part.corners.iter().map(|corner| part.points[*corner as usize]).collect();
    let expected: Vec<_> = fans.iter().map(|corner| mesh.points[mesh.corners[*corner] as usize]).collect();
    assert_eq!(positions, expected);
    assert_eq!(corner_values(part, "uv"), expect("uv", 2));
    for (found, expected) in corner_values(part, "normal").iter().zip(expect("normal", 3)) {
        assert!((found - expected).abs() < 1e-6);
    }
    // Seven points, of which one meets a seam of the texture.
    assert_eq!(part.points.len(), 8);
    let merged = model.merged_mesh(&Context::serial()).unwrap();
    let moved = transform.transform_point3(DVec3::from(part.points[4].map(f64::from)));
    let found = DVec3::from(merged.points[8 + 4].map(f64::from));
    assert!((moved - found).length() < 1e-6, "{moved} {found}");
}

#[test]
fn glb_is_valid_for_the_gltf_crate() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("rich.glb");
    write(&path, &rich()).unwrap();
    let bytes = std::fs::read(&path).unwrap();
    assert_eq!(bytes.len() % 4, 0);
    let document = gltf::Gltf::from_slice(&bytes).unwrap();
    let blob = document.blob.clone().unwrap();
    let primitives: Vec<_> = document.meshes().next().unwrap().primitives().collect();
    let primitive = &primitives[0];
    let indices =
        |primitive: &gltf::Primitive| primitive.reader(|_| Some(&blob)).read_indices().unwrap().into_u32().count();
    // The pentagon has slot 0, the quad slot 1.
    assert_eq!(primitives.iter().map(indices).collect::<Vec<_>>(), [9, 6]);
    assert_eq!(document.materials().map(|material| material.name()).collect::<Vec<_>>(), [Some("0"), Some("1")]);
    let reader = primitive.reader(|_| Some(&blob));
    let points: Vec<_> = reader.read_positions().unwrap().collect();
    assert_eq!(points.len(), 8);
    assert_eq!(reader.read_tex_coords(0).unwrap().into_f32().count(), 8);
    assert_eq!(reader.read_colors(0).unwrap().into_rgba_f32().next(), Some([1.0, 0.0, 1.0, 1.0]));
    let bounds = primitive.bounding_box();
    for axis in 0..3 {
        let values = || points.iter().map(|point| point[axis]);
        assert_eq!(bounds.min[axis], values().fold(f32::MAX, f32::min));
        assert_eq!(bounds.max[axis], values().fold(f32::MIN, f32::max));
    }
}

#[test]
fn glb_keeps_material_slots_with_their_names() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("slots.glb");
    // Six triangles with slots in any order; the last is a hole.
    let points: Vec<[f32; 3]> = (0..18).map(|index| [index as f32, (index % 3) as f32, (index / 3) as f32]).collect();
    let mut mesh = Mesh::new(points, vec![3; 6], (0..18).collect());
    mesh.holes = vec![5];
    mesh.attributes = vec![attribute("material", Domain::Face, 1, Values::U32(vec![2, 0, 2, 3, 1, 9]))];
    let names = ["snow", "", "ice", "unused"].map(String::from);
    let named = Instance { materials: &names[..3], ..Instance::new("a", &mesh) };
    let other = Instance { materials: &names[2..], ..Instance::new("b", &mesh) };
    write_glb(&path, &[named, other]).unwrap();
    let model = read_model(&Context::serial(), &path).unwrap();
    // Slots of no material come last; slot 3 of the one and 2 and 3 of the other have no name.
    assert_eq!(model.materials, ["snow", "ice", "3", "unused", "2", "3", ""]);
    for (part, expected) in model.meshes.iter().zip([[0u32, 6, 1, 1, 2], [1, 3, 4, 4, 5]]) {
        let slots = &part.mesh.attribute("material").unwrap().values;
        assert_eq!(*slots, Values::U32(expected.to_vec()));
        // The first corner of every triangle tells which face it was.
        let faces: Vec<u32> = part.mesh.faces().map(|face| part.mesh.points[face[0] as usize][2] as u32).collect();
        assert_eq!(faces, [1, 4, 0, 2, 3]);
        assert_eq!(part.mesh.points.len(), 18, "primitives share their points");
    }
}

#[test]
fn meshes_that_cannot_be_used_are_not_written() {
    let folder = tempfile::tempdir().unwrap();
    for extension in ["obj", "ply", "glb", "stl", "off"] {
        let path = folder.path().join("bad").with_extension(extension);
        assert!(write(&path, &Mesh::default()).unwrap_err().to_string().contains("empty"));
        assert!(!path.exists());
    }
    let mut holes = rich();
    holes.holes = vec![0, 1];
    assert!(write(&folder.path().join("bad.glb"), &holes).is_err());
    assert!(write(&folder.path().join("bad.xyz"), &rich()).is_err());
    assert!(write(Path::new("/none/such/folder/a.obj"), &rich()).is_err());
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
}

#[test]
fn files_that_gzip_packed_are_read_within_the_limit() {
    let folder = tempfile::tempdir().unwrap();
    let plain = folder.path().join("a.obj");
    write(&plain, &rich()).unwrap();
    let bytes = std::fs::read(&plain).unwrap();
    let pack = |bytes: &[u8]| {
        let mut packer = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::default());
        std::io::Write::write_all(&mut packer, bytes).unwrap();
        packer.finish().unwrap()
    };
    let path = folder.path().join("a.obj.gz");
    let packed = pack(&bytes);
    std::fs::write(&path, &packed).unwrap();
    assert_eq!(read(&Context::serial(), &path).unwrap(), read(&Context::serial(), &plain).unwrap());
    std::fs::write(&path, &packed[..packed.len() - 9]).unwrap();
    assert!(read(&Context::serial(), &path).unwrap_err().to_string().contains("gzip is damaged"));
    // 64 MiB of blanks in 64 KiB.
    std::fs::write(&path, pack(&vec![b' '; 64 << 20])).unwrap();
    let small = Context::new(&relievo_core::ContextOptions { threads: 1, memory_limit: 1 << 20 }).unwrap();
    assert_eq!(read(&small, &path).unwrap_err().kind, relievo_core::ErrorKind::Memory);
}

/// Every known mesh survives OBJ, bit by bit, and PLY and GLB in its points and faces.
#[test]
fn real_meshes_survive() {
    let Some(data) = relievo_testing::data() else { return };
    let context = Context::serial();
    let folder = tempfile::tempdir().unwrap();
    for name in
        ["cages/bishop.obj", "cages/rabbit.obj", "cages/spot_control_mesh.obj", "meshes/horse.ply", "ugly/cow.obj"]
    {
        let mesh = read(&context, &data.join(name)).unwrap();
        let [obj, ply, glb] = ["a.obj", "a.ply", "a.glb"].map(|file| folder.path().join(file));
        write(&obj, &mesh).unwrap();
        let found = read(&context, &obj).unwrap();
        assert_eq!((&found.points, &found.face_sizes, &found.corners), (&mesh.points, &mesh.face_sizes, &mesh.corners));
        assert_eq!(found.creases, mesh.creases, "{name}");
        for attribute in mesh.attributes.iter().filter(|attribute| ["uv", "normal"].contains(&attribute.name.as_str()))
        {
            assert_eq!(corner_values(&found, &attribute.name), corner_values(&mesh, &attribute.name), "{name}");
        }
        write(&ply, &mesh).unwrap();
        let found = read(&context, &ply).unwrap();
        assert_eq!((&found.points, &found.face_sizes, &found.corners), (&mesh.points, &mesh.face_sizes, &mesh.corners));
        write(&glb, &mesh).unwrap();
        let found = read(&context, &glb).unwrap();
        let place = |mesh: &Mesh, triangle: &[u32; 3]| triangle.map(|corner| mesh.points[corner as usize]);
        let expected: Vec<_> = mesh.triangles().iter().map(|triangle| place(&mesh, triangle)).collect();
        let found: Vec<_> = found.triangles().iter().map(|triangle| place(&found, triangle)).collect();
        assert!(expected == found, "{name}");
    }
}
