//! Models that are no clean characters: errors, or a hierarchy that keeps its promises.

use glam::{DAffine3, DVec3};
use relievo_core::progress::Silent;
use relievo_core::{Context, Mesh, Values};
use relievo_crowd::{BuildSettings, CrowdModel};
use relievo_meshio::{Model, Placement};
use relievo_testing::Random;

use crate::arm::arm;

fn build(model: &Model, clips: &[usize]) -> relievo_core::Result<CrowdModel> {
    let settings = BuildSettings { cluster_triangles: 20, pose_rate: 4.0, ..BuildSettings::default() };
    let made = CrowdModel::build(&Context::serial(), model, clips, &settings, &mut Silent)?;
    made.check().unwrap();
    assert_eq!(made.triangle_count(&made.input_clusters()), u64::from(made.input_triangles));
    Ok(made)
}

#[test]
fn static_models_and_triangles_without_order_are_built() {
    let mut random = Random(1);
    let points: Vec<[f32; 3]> = (0..40).map(|_| [random.unit(), random.unit(), random.unit()]).collect();
    // Many triangles at each edge, some repeat a place.
    let mut triangles: Vec<[u32; 3]> = Vec::new();
    while triangles.len() < 300 {
        let triangle = [0; 3].map(|_: u32| random.below(40) as u32);
        if triangle[0] != triangle[1] && triangle[1] != triangle[2] && triangle[2] != triangle[0] {
            triangles.push(triangle);
        }
    }
    build(&Model::from_mesh(Mesh::from_triangles(points.clone(), &triangles)), &[]).unwrap();
    // All points at one place, and all on a line.
    build(&Model::from_mesh(Mesh::from_triangles(vec![[1.0; 3]; 40], &triangles)), &[]).unwrap();
    let line: Vec<[f32; 3]> = (0..40).map(|at| [at as f32, 0.0, 0.0]).collect();
    build(&Model::from_mesh(Mesh::from_triangles(line, &triangles)), &[]).unwrap();
    // No two triangles share a point.
    let soup: Vec<[f32; 3]> = triangles.iter().flatten().map(|point| points[*point as usize]).collect();
    let apart: Vec<[u32; 3]> = (0..300).map(|at| [3 * at, 3 * at + 1, 3 * at + 2]).collect();
    build(&Model::from_mesh(Mesh::from_triangles(soup, &apart)), &[]).unwrap();
    let far: Vec<[f32; 3]> = points.iter().map(|point| point.map(|value| value + 1e6)).collect();
    build(&Model::from_mesh(Mesh::from_triangles(far, &triangles)), &[]).unwrap();
}

#[test]
fn clips_without_keys_mirrors_and_collapsed_bones_are_built() {
    let mut source = arm(12, 8);
    source.animations[0].channels.clear();
    assert_eq!(build(&source, &[0]).unwrap().clips[0].poses.len(), 1);
    let mut source = arm(12, 8);
    source.place(DAffine3::from_scale(DVec3::new(-1.0, 1.0, 1.0)));
    build(&source, &[0]).unwrap();
    let mut source = arm(12, 8);
    source.nodes[2].local = Placement::Matrix(DAffine3::from_scale(DVec3::ZERO));
    build(&source, &[0]).unwrap();
}

#[test]
fn smooth_tubes_and_skinned_triangles_without_order_are_built() {
    // Simplification hardly moves a smooth tube, so that distances are near the rounding of coordinates.
    let mut smooth = arm(24, 16);
    for point in &mut smooth.meshes[0].mesh.points {
        let radius = point[0].hypot(point[2]);
        if radius > 0.0 {
            (point[0], point[2]) = (0.3 * point[0] / radius, 0.3 * point[2] / radius);
        }
    }
    let settings = BuildSettings { cluster_triangles: 20, pose_rate: 30.0, ..BuildSettings::default() };
    let made = CrowdModel::build(&Context::serial(), &smooth, &[0], &settings, &mut Silent).unwrap();
    assert!(made.triangle_count(&made.cut(0.03 * made.size())) * 3 < u64::from(made.input_triangles));
    // No two triangles share a point.
    let mut apart = arm(12, 8);
    let mesh = &mut apart.meshes[0].mesh;
    let corners = std::mem::take(&mut mesh.corners);
    mesh.points = corners.iter().map(|vertex| mesh.points[*vertex as usize]).collect();
    for attribute in &mut mesh.attributes {
        let width = attribute.width as usize;
        let at = |vertex: &u32| *vertex as usize * width..(*vertex as usize + 1) * width;
        match &mut attribute.values {
            Values::F32(values) => *values = corners.iter().flat_map(|it| values[at(it)].to_vec()).collect(),
            Values::U32(values) => *values = corners.iter().flat_map(|it| values[at(it)].to_vec()).collect(),
        }
    }
    mesh.corners = (0..corners.len() as u32).collect();
    build(&apart, &[0]).unwrap();
    // Any three points make a triangle, so that many meet at each edge.
    let mut random = Random(2);
    let mut tangled = arm(12, 8);
    let mesh = &mut tangled.meshes[0].mesh;
    for corners in mesh.corners.as_chunks_mut::<3>().0 {
        let first = random.below(mesh.points.len() - 2) as u32;
        *corners = [first, first + 1, first + 2];
    }
    build(&tangled, &[0]).unwrap();
}

#[test]
fn models_that_cannot_be_are_refused() {
    let good = arm(6, 6);
    let change = |change: &dyn Fn(&mut Model)| {
        let mut model = good.clone();
        change(&mut model);
        let error = build(&model, &[0]).unwrap_err();
        assert!(!error.what.is_empty());
    };
    change(&|model| model.meshes[0].mesh.points[3][1] = f32::NAN);
    change(&|model| model.meshes[0].mesh.points[3][1] = 1e30);
    change(&|model| model.meshes[0].mesh.corners[3] = 4000);
    change(&|model| model.meshes[0].mesh = Mesh::default());
    change(&|model| model.nodes[0].mesh = None);
    change(&|model| model.animations.clear());
    change(&|model| model.skins[0].inverse_bind[1] = DAffine3::from_translation(DVec3::NAN));
    change(&|model| model.animations[0].channels[0].times[2] = 1e30);
    change(&|model| {
        if let Values::F32(weights) = &mut model.meshes[0].mesh.attributes[2].values {
            weights[0] = 5.0;
        }
    });
    let settings = BuildSettings { cluster_triangles: 1, ..BuildSettings::default() };
    assert!(CrowdModel::build(&Context::serial(), &good, &[0], &settings, &mut Silent).is_err());
    let mut asked = 0;
    let mut stop = |_: f32, _: &str| {
        asked += 1;
        asked < 3
    };
    let stopped = CrowdModel::build(&Context::serial(), &good, &[0], &BuildSettings::default(), &mut stop);
    assert_eq!(stopped.unwrap_err().kind, relievo_core::ErrorKind::Cancelled);
}
