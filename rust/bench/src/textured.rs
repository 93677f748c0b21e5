//! Simplification of meshes with texture coordinates beside meshoptimizer's, with attributes that move with places: rates,
//! how far surfaces are apart, and how far a texture is from where it was.

use std::collections::HashMap;

use relievo_core::progress::Silent;
use relievo_core::{Attribute, Context, Domain, Mesh, Result, Values};
use relievo_lod::{Attributes, SimplifyOptions, default_weight, simplify_with};

use crate::deviation::{Deviation, box_of, texture_shift};
use crate::lod::{RUNS, Triangles, left, noisy_knot};
use crate::measure::{Sample, compare, seconds};
use crate::report::{Goal, Report};
use crate::shapes;

/// Triangles, and the texture coordinates of their vertices.
pub type Textured = (Triangles, Vec<[f32; 2]>);

/// Measures every case into `report`.
pub fn run(report: &mut Report, context: &Context) -> Result<()> {
    case(report, context, "textured noisy knot, 327,680 triangles", &textured_knot(640, 256))?;
    match shapes::model(context, "cages/beast.obj")? {
        Some(mesh) => {
            let model = textured(&mesh);
            case(report, context, &format!("textured beast.obj, {} triangles", model.0.1.len()), &model)
        }
        None => {
            eprintln!("skipped: cages/beast.obj is not there");
            Ok(())
        }
    }
}

/// A knot with a texture that goes around it four times, and seams where that begins.
fn textured_knot(along: u32, around: u32) -> Textured {
    let (closed, _) = noisy_knot(along, around);
    let place = |i: u32, j: u32| closed[(i % along * around + j % around) as usize];
    let vertices = || (0..=along).flat_map(|i| (0..=around).map(move |j| (i, j)));
    let points = vertices().map(|(i, j)| place(i, j)).collect();
    let uvs = vertices().map(|(i, j)| [4.0 * i as f32 / along as f32, j as f32 / around as f32]).collect();
    let row = around + 1;
    let quads = (0..along).flat_map(|i| (0..around).map(move |j| i * row + j));
    let triangles = quads.flat_map(|at| [[at, at + row, at + row + 1], [at, at + row + 1, at + 1]]).collect();
    ((points, triangles), uvs)
}

/// The triangles of a mesh whose corners have texture coordinates, with a vertex for every pair of both.
fn textured(mesh: &Mesh) -> Textured {
    let (mut known, mut points, mut uvs) = (HashMap::new(), Vec::new(), Vec::new());
    let uv = mesh.attribute("uv").filter(|uv| uv.domain == Domain::Corner && uv.width == 2);
    let (mut vertices, mut triangles, mut start) = (Vec::new(), Vec::new(), 0);
    for (corner, point) in mesh.corners.iter().enumerate() {
        let value = uv.map_or([0.0; 2], |uv| value_of(uv, corner));
        let vertex = *known.entry((*point, value.map(f32::to_bits))).or_insert_with(|| {
            points.push(mesh.points[*point as usize]);
            uvs.push(value);
            points.len() as u32 - 1
        });
        vertices.push(vertex);
    }
    for size in &mesh.face_sizes {
        let corner = |at: u32| vertices[(start + at) as usize];
        triangles.extend((2..*size).map(|last| [corner(0), corner(last - 1), corner(last)]));
        start += size;
    }
    ((points, triangles), uvs)
}

fn value_of(uv: &Attribute, corner: usize) -> [f32; 2] {
    let value = uv.indices.as_ref().map_or(corner, |indices| indices[corner] as usize);
    match &uv.values {
        Values::F32(values) => [values[2 * value], values[2 * value + 1]],
        Values::U32(_) => [0.0; 2],
    }
}

fn case(report: &mut Report, context: &Context, name: &str, model: &Textured) -> Result<()> {
    let millions = model.0.1.len() as f64 / 1e6;
    let (mine, peer) =
        compare(RUNS, || millions / seconds(|| ours(context, model)), || millions / seconds(|| theirs(model)));
    report.add(name, &mine, Some(("meshoptimizer", &peer)), "Mtri/s", Goal::None);
    let (ours, theirs) = (ours(context, model)?, theirs(model));
    let rows = [&ours, &theirs].map(|made| -> Result<[f64; 2]> {
        let apart = Deviation::between(context, &model.0, &made.0)?.mean;
        Ok([apart, texture_shift(context, model, made)?])
    });
    let [ours, theirs] = rows;
    let what = [("root mean square deviation", "% of diagonal"), ("shift of the texture, 95th percentile", "% of it")];
    for ((what, unit), (ours, theirs)) in what.into_iter().zip(ours?.into_iter().zip(theirs?)) {
        let [ours, theirs] = [ours, theirs].map(|value| Sample::new(vec![value]));
        report.add(&format!("{name}: {what}"), &ours, Some(("meshoptimizer", &theirs)), unit, Goal::RatioAtMost(1.0));
    }
    Ok(())
}

fn ours(context: &Context, ((points, triangles), uvs): &Textured) -> Result<Textured> {
    let weights = &[default_weight("uv"); 2];
    let attributes = Attributes { values: uvs.as_flattened(), weights, uvs: &[0], ..Default::default() };
    let options = SimplifyOptions { target_triangles: left(triangles), ..SimplifyOptions::default() };
    let made = simplify_with(context, points, triangles, &attributes, &options, &mut Silent)?;
    Ok(((made.points, made.triangles), made.values.as_chunks().0.to_vec()))
}

/// With the same weights as ours, which are parts of the diagonal there and of the largest side here.
fn theirs(((points, triangles), uvs): &Textured) -> Textured {
    let (mut points, mut uvs, mut indices) = (points.clone(), uvs.clone(), triangles.as_flattened().to_vec());
    let (low, high) = box_of(&points);
    let weight = default_weight("uv") * low.distance(high) / (high - low).max_element();
    let options = meshopt::SimplifyOptions::None;
    let count = meshopt::simplify_with_update(
        &mut indices,
        &mut points,
        uvs.as_flattened_mut(),
        &[weight; 2],
        size_of::<[f32; 2]>(),
        None,
        3 * left(triangles),
        f32::MAX,
        options,
        None,
    );
    ((points, indices[..count].as_chunks().0.to_vec()), uvs)
}
