//! Characters with more triangles.

use std::collections::HashMap;

use glam::Vec3;
use relievo_core::{Attribute, Mesh, Values};
use relievo_meshio::Model;

/// Divides all triangles of a model into four, some times, and adds waves, so that no level is without error.
pub fn refined(source: &Model, times: u32) -> Model {
    let mut model = source.clone();
    for part in &mut model.meshes {
        let extent = part.mesh.bounds().map_or(1.0, |(low, high)| Vec3::from(high).distance(low.into()));
        for _ in 0..times {
            part.mesh = divided(&part.mesh);
        }
        part.targets.clear();
        part.weights.clear();
        for point in &mut part.mesh.points {
            let place = Vec3::from(*point) / extent;
            let wave =
                |k: f32| Vec3::new((k * place.y).sin(), (k * place.z + 1.0).sin(), (k * place.x + 2.0).sin()) / k;
            *point = (Vec3::from(*point) + 0.04 * extent * (wave(23.0) + wave(61.0) + wave(149.0))).to_array();
        }
    }
    model
}

/// Joins the vertices of a mesh at one point with the same bones and weights.
pub fn joined(mesh: &Mesh) -> Mesh {
    let values = |name: &str| mesh.attribute(name).map(|attribute| &attribute.values);
    let (Some(Values::U32(joints)), Some(Values::F32(weights))) = (values("joints"), values("weights")) else {
        return mesh.clone();
    };
    let (joints, weights) = (joints.as_chunks::<4>().0, weights.as_chunks::<4>().0);
    let (mut known, mut firsts) = (HashMap::new(), Vec::new());
    let numbers: Vec<u32> = (0..mesh.points.len())
        .map(|at| {
            let key = (mesh.points[at].map(f32::to_bits), joints[at], weights[at].map(f32::to_bits));
            *known.entry(key).or_insert_with(|| {
                firsts.push(at);
                firsts.len() as u32 - 1
            })
        })
        .collect();
    let triangles: Vec<[u32; 3]> =
        mesh.triangles().iter().map(|triangle| triangle.map(|corner| numbers[corner as usize])).collect();
    let mut made = Mesh::from_triangles(firsts.iter().map(|at| mesh.points[*at]).collect(), &triangles);
    let joints = Values::U32(firsts.iter().flat_map(|at| joints[*at]).collect());
    let weights = Values::F32(firsts.iter().flat_map(|at| weights[*at]).collect());
    for (name, values) in [("joints", joints), ("weights", weights)] {
        let source = mesh.attribute(name).cloned();
        made.attributes.extend(source.map(|attribute| Attribute { values, ..attribute }));
    }
    made
}

/// Divides all triangles of a mesh into four.
fn divided(mesh: &Mesh) -> Mesh {
    let mut middles: HashMap<(u32, u32), u32> = HashMap::new();
    let mut ends: Vec<(u32, u32)> = Vec::new();
    let count = mesh.points.len() as u32;
    let mut middle = |a: u32, b: u32| {
        *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
            ends.push((a.min(b), a.max(b)));
            count + ends.len() as u32 - 1
        })
    };
    let mut triangles = Vec::new();
    for [a, b, c] in mesh.triangles() {
        let [ab, bc, ca] = [middle(a, b), middle(b, c), middle(c, a)];
        triangles.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
    }
    let mut points = mesh.points.clone();
    points.extend(ends.iter().map(|(a, b)| {
        let (a, b) = (Vec3::from(mesh.points[*a as usize]), Vec3::from(mesh.points[*b as usize]));
        (0.5 * (a + b)).to_array()
    }));
    let mut made = Mesh::from_triangles(points, &triangles);
    made.attributes =
        mesh.attributes.iter().filter(|it| it.name != "joints" && it.name != "material").cloned().collect();
    for attribute in &mut made.attributes {
        let width = attribute.width as usize;
        if let Values::F32(values) = &mut attribute.values {
            let mean = |(a, b): &(u32, u32), at: usize| {
                0.5 * (values[*a as usize * width + at] + values[*b as usize * width + at])
            };
            let more: Vec<f32> = ends.iter().flat_map(|end| (0..width).map(move |at| mean(end, at))).collect();
            values.extend(more);
        }
    }
    blend_influences(mesh, &mut made, &ends);
    made
}

/// Gives the middles of edges the four strongest of the bones of both ends.
fn blend_influences(mesh: &Mesh, made: &mut Mesh, ends: &[(u32, u32)]) {
    let values = |name: &str| mesh.attribute(name).map(|attribute| &attribute.values);
    let (Some(Values::U32(joints)), Some(Values::F32(weights))) = (values("joints"), values("weights")) else { return };
    let (mut all_joints, mut all_weights) = (joints.clone(), weights.clone());
    for (a, b) in ends {
        let mut sums: Vec<(u32, f32)> = Vec::new();
        for vertex in [*a as usize, *b as usize] {
            for at in 4 * vertex..4 * vertex + 4 {
                match sums.iter_mut().find(|known| known.0 == joints[at]) {
                    Some(known) => known.1 += weights[at],
                    None => sums.push((joints[at], weights[at])),
                }
            }
        }
        sums.sort_by(|a, b| b.1.total_cmp(&a.1));
        sums.resize(4, (0, 0.0));
        let total: f32 = sums.iter().map(|sum| sum.1).sum();
        all_joints.extend(sums.iter().map(|sum| sum.0));
        all_weights.extend(sums.iter().map(|sum| sum.1 / total));
    }
    for attribute in &mut made.attributes {
        if attribute.name == "weights" {
            attribute.values = Values::F32(all_weights.clone());
        }
    }
    let joints = mesh.attribute("joints").cloned();
    made.attributes.extend(joints.map(|attribute| Attribute { values: Values::U32(all_joints), ..attribute }));
}
