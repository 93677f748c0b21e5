//! Files nobody here made, with counts that were found by other means (`SOURCES.md` beside them).

use std::path::{Path, PathBuf};

use relievo_core::Context;
use relievo_meshio::read_model;
use relievo_testing::data;

fn files(folder: &Path, extension: &str) -> Vec<PathBuf> {
    let mut list: Vec<_> = std::fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|found| found.eq_ignore_ascii_case(extension)))
        .collect();
    list.sort();
    list
}

/// Points and faces of every mesh whose counts are known.
const COUNTS: &[(&str, usize, usize)] = &[
    ("cages/armorguy.obj", 10022, 8639),
    ("cages/beast.obj", 32311, 32364),
    ("cages/bigguy.obj", 1452, 1450),
    ("cages/bishop.obj", 917, 968),
    ("cages/car.obj", 1642, 1575),
    ("cages/monsterfrog.obj", 1308, 1292),
    ("cages/quadknot.obj", 1440, 1440),
    ("cages/rabbit.obj", 644, 678),
    ("cages/spot_control_mesh.obj", 188, 180),
    ("cages/spot_quadrangulated.obj", 2930, 2928),
    ("cages/suzanne.obj", 507, 500),
    ("cages/t-rex.obj", 11185, 11070),
    ("cages/target.obj", 1715, 1660),
    ("cages/reference/bilinear_cube_level0.obj", 26, 24),
    ("cages/reference/catmark_edgecorner_level2.obj", 1956, 1792),
    ("meshes/beetle-alt.obj", 19887, 38656),
    ("meshes/cheburashka.obj", 6669, 13334),
    ("meshes/fandisk.obj", 6475, 12946),
    ("meshes/horse.ply", 48485, 96966),
    ("meshes/igea.ply", 134345, 268686),
    ("meshes/ogre.obj", 62194, 124008),
    ("meshes/stanford-bunny.obj", 35947, 69451),
    ("ugly/beetle.obj", 1148, 2053),
    ("ugly/bunny_zippered.ply", 8171, 16301),
    ("ugly/chair_model.obj", 3186, 12756),
    ("ugly/cow.obj", 2903, 5804),
    ("ugly/cycloidal.ply", 21384, 43368),
    ("ugly/featuretype.ply", 5096, 3476),
    ("ugly/joined_tetrahedra.obj", 5, 8),
    ("ugly/multibody.stl", 20, 32),
    ("ugly/not_convex.obj", 288, 96),
    ("ugly/octagonal_pocket.ply", 1658, 3262),
    ("ugly/shared.STL", 14, 24),
    ("ugly/soup.stl", 300, 100),
    ("ugly/teapot_unwelded.obj", 3644, 6320),
];

#[test]
fn known_counts_are_found() {
    let Some(data) = data() else { return };
    for (name, points, faces) in COUNTS {
        let mesh = relievo_meshio::read(&Context::serial(), &data.join(name)).unwrap();
        assert_eq!((mesh.points.len(), mesh.face_count()), (*points, *faces), "{name}");
        assert_eq!(mesh.check(), Ok(()), "{name}");
    }
}

#[test]
fn faces_by_size_and_creases_of_the_cages_are_found() {
    let Some(data) = data() else { return };
    type Sizes = &'static [(u32, usize)];
    let cases: [(&str, Sizes, usize); 4] = [
        ("armorguy", &[(3, 238), (4, 8339), (5, 54), (6, 8)], 7101),
        ("bishop", &[(3, 132), (4, 836)], 224),
        ("rabbit", &[(3, 176), (4, 496), (16, 6)], 0),
        ("car", &[(4, 1575)], 314),
    ];
    for (name, sizes, creases) in cases {
        let mesh = relievo_meshio::read(&Context::serial(), &data.join(format!("cages/{name}.obj"))).unwrap();
        for (size, count) in sizes {
            assert_eq!(mesh.face_sizes.iter().filter(|found| *found == size).count(), *count, "{name}: {size}-gons");
        }
        assert_eq!(mesh.creases.len(), creases, "{name}");
    }
}

#[test]
fn odd_obj_files_are_read_or_refused_with_a_reason() {
    let Some(data) = data() else { return };
    let context = Context::serial();
    let read = |name: &str| read_model(&context, &data.join("formats").join(name)).unwrap();
    // One refers to normals that it does not have; four have no usable face.
    let refused = ["face_in_group_name_mid_file"];
    let unusable = ["face_in_group_name", "notenoughindices", "obj_points", "obj_wireframe"];
    for path in files(&data.join("formats"), "obj") {
        let stem = path.file_stem().unwrap().to_str().unwrap();
        match read_model(&context, &path) {
            Ok(model) => {
                let check = model.meshes[0].mesh.check();
                assert_eq!(check.is_err(), unusable.contains(&stem), "{stem}: {check:?}");
            }
            Err(error) => {
                assert!(refused.contains(&stem), "{error}");
                assert!(error.place.ends_with("line 5") && error.what == "normal 4 does not exist", "{error}");
            }
        }
    }
    assert_eq!(read("negative_indices.obj").meshes[0].mesh.face_count(), 6);
    assert_eq!(read("jacked.obj").materials, ["material0"]);
    assert_eq!(read("face_in_group_name.obj").groups, ["An f Three Other Things"]);
    assert_eq!(read("nancolor.obj").notes, ["colours are left out because some are not finite"]);
    assert_eq!(read("polygonfaces.obj").meshes[0].mesh.face_sizes, [5]);
    let error = read("notenoughindices.obj").meshes[0].mesh.check().unwrap_err();
    assert_eq!(error.place, "face 0");
}

#[test]
fn odd_ply_files_are_read() {
    let Some(data) = data() else { return };
    let context = Context::serial();
    let read = |name: &str| read_model(&context, &data.join("formats").join(name)).unwrap();
    let counts = |name: &str| (read(name).meshes[0].mesh.points.len(), read(name).meshes[0].mesh.face_count());
    assert_eq!(counts("cube_blender_uv.ply"), (24, 6));
    assert_eq!(counts("fuze_ascii.ply"), (502, 1000));
    assert_eq!(counts("metadata.ply"), (4, 2));
    assert_eq!(counts("multi.ply"), (4, 1));
    assert_eq!(counts("ply_empty_header.ply"), (0, 0));
    assert_eq!(counts("points_ascii_with_lists.ply"), (5, 0));
    assert_eq!(counts("points_bin.ply"), (5, 0));
    let fuze = read("fuze_ascii.ply");
    let uv = fuze.meshes[0].mesh.attribute("uv").unwrap();
    assert_eq!((uv.domain, uv.values.len()), (relievo_core::Domain::Corner, 6000));
    assert_eq!(fuze.meshes[0].mesh.check(), Ok(()));
}

/// Meshes, triangles, points and animations of every instance of the characters.
#[test]
fn characters_have_the_known_parts() {
    let Some(data) = data() else { return };
    let context = Context::serial();
    let cases = [
        ("AnimatedMorphCube", 12, 24, 1, 0),
        ("BoxAnimated", 254, 0, 1, 0),
        ("girl", 561, 496, 2, 23),
        ("greenman", 356, 196, 4, 12),
        ("rigged_figure", 256, 370, 1, 19),
        ("robot", 3238, 7218, 14, 43),
    ];
    for (name, triangles, points, animations, joints) in cases {
        let model = read_model(&context, &data.join(format!("characters/{name}.glb"))).unwrap();
        let mesh = model.merged_mesh(&context).unwrap();
        assert_eq!(mesh.check(), Ok(()), "{name}");
        assert_eq!(mesh.face_count(), triangles, "{name}");
        assert!(points == 0 || mesh.points.len() == points, "{name}");
        assert_eq!(model.animations.len(), animations, "{name}");
        assert_eq!(model.skins.first().map_or(0, |skin| skin.joints.len()), joints, "{name}");
        for animation in 0..animations {
            let (start, end) = model.animations[animation].range();
            for time in [start - 1.0, start, 0.5 * (start + end), end, end + 1.0] {
                let points = model.pose(&context, animation, time).unwrap().merged_points();
                assert_eq!(points.len(), mesh.points.len());
                assert!(points.as_flattened().iter().all(|value| value.is_finite() && value.abs() < 1e3), "{name}");
            }
        }
    }
}

/// Boundary and non-manifold edges, components and unused points that others counted.
#[test]
fn summaries_agree_with_known_counts() {
    let Some(data) = data() else { return };
    let cases = [
        ("cages/armorguy.obj", 2034, 0, 345, 0),
        ("cages/car.obj", 0, 0, 31, 0),
        ("cages/monsterfrog.obj", 0, 0, 9, 0),
        ("cages/quadknot.obj", 0, 0, 1, 0),
        ("cages/t-rex.obj", 562, 0, 54, 0),
        ("cages/target.obj", 120, 0, 0, 0),
        ("meshes/beetle-alt.obj", 1136, 0, 0, 0),
        ("meshes/ogre.obj", 236, 0, 44, 0),
        ("meshes/stanford-bunny.obj", 223, 0, 0, 1113),
        ("meshes/igea.ply", 0, 0, 1, 0),
        ("ugly/beetle.obj", 296, 47, 0, 0),
        ("ugly/bunny_zippered.ply", 123, 150, 0, 25),
        ("ugly/cycloidal.ply", 0, 242, 100, 0),
        ("ugly/joined_tetrahedra.obj", 0, 3, 1, 0),
        ("ugly/octagonal_pocket.ply", 54, 0, 0, 0),
        ("ugly/teapot_unwelded.obj", 1036, 0, 0, 0),
    ];
    for (name, boundary, non_manifold, components, unused) in cases {
        let mesh = relievo_meshio::read(&Context::serial(), &data.join(name)).unwrap();
        let summary = relievo_meshio::Summary::of_mesh(&mesh);
        let found = (summary.boundary_edges, summary.non_manifold_edges, summary.components, summary.unused_points);
        // Zero stands for what nobody counted.
        let or = |known: usize, found: usize| if known == 0 { found } else { known };
        let expected = (or(boundary, found.0), non_manifold, or(components, found.2), or(unused, found.3));
        println!("{name}: {found:?}");
        assert_eq!(found, expected, "{name}");
    }
}

#[test]
fn odd_stl_and_off_files_are_read() {
    let Some(data) = data() else { return };
    let read = |name: &str| relievo_meshio::read(&Context::serial(), &data.join("formats").join(name)).unwrap();
    let counts = |name: &str| (read(name).points.len(), read(name).face_count());
    assert_eq!(counts("comments.off"), (8, 6));
    assert_eq!(counts("whitespace.off"), (8, 6));
    assert_eq!(counts("stl_empty_ascii.stl"), (0, 0));
    assert_eq!(counts("stl_empty_bin.stl"), (0, 0));
    assert_eq!(counts("two_objects_mixed_case_names.stl").1, 24);
}
