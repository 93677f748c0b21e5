//! Joints and weights of a primitive's points: files may have any number of joints for a point, four are used.

use gltf::json::accessor::Type;
use gltf::json::mesh::{Primitive, Semantic};
use gltf::json::validation::Checked;
use relievo_core::{Error, Mesh, Result, Values};

use super::accessor::{Wanted, floats, integers};
use super::container::Container;
use super::primitive::SETS;
use crate::budget::Budget;
use crate::notes::Notes;

/// Joints of a point that are used.
const USED: usize = 4;

/// Reads four joints and weights for each of `count` points: of all that the file has those with the largest weights, the earlier
/// ones of equal weight. `None` if the file has no joints.
///
/// # Errors
/// Fails with `Invalid` if an accessor is damaged or has another number of points, and with `Memory` if there is too little.
pub(super) fn read(
    file: &Container,
    (budget, notes): (&mut Budget, &mut Notes),
    primitive: &Primitive,
    count: usize,
) -> Result<Option<(Vec<u32>, Vec<f32>)>> {
    let find = |semantic: Semantic| primitive.attributes.get(&Checked::Valid(semantic)).map(|index| index.value());
    let wanted = Wanted { shapes: &[Type::Vec4], count: Some(count) };
    let mut set = |number: u32, notes: &mut Notes| -> Result<Option<(Vec<u32>, Vec<f32>)>> {
        let both = [Semantic::Joints(number), Semantic::Weights(number)].map(|it| (find(it.clone()), it));
        let [(Some(joints), joints_name), (Some(weights), weights_name)] = both else { return Ok(None) };
        let place = |name: Semantic| move |error: Error| error.at(format!("{name:?}"));
        let joints = integers(file, budget, joints, &wanted).map_err(place(joints_name))?;
        let weights = floats(file, budget, weights, &wanted).map_err(place(weights_name))?.0;
        for _ in weights.as_chunks::<USED>().0.iter().filter(|weights| weights.iter().any(|weight| *weight < 0.0)) {
            notes.add("negative weights of joints are left out", 0);
        }
        Ok(Some((joints, weights)))
    };
    let Some((mut joints, mut weights)) = set(0, notes)? else { return Ok(None) };
    for number in 1..SETS {
        let Some((more_joints, more_weights)) = set(number, notes)? else { break };
        let more = more_joints.as_chunks::<USED>().0.iter().zip(more_weights.as_chunks::<USED>().0);
        let known = joints.as_chunks_mut::<USED>().0.iter_mut().zip(weights.as_chunks_mut::<USED>().0);
        for ((joints, weights), (more_joints, more_weights)) in known.zip(more) {
            let mut all: Vec<(u32, f32)> = joints.iter().copied().zip(weights.iter().copied()).collect();
            all.extend(more_joints.iter().copied().zip(more_weights.iter().copied()));
            all.sort_by(|a, b| b.1.total_cmp(&a.1));
            if all[USED].1 > 0.0 {
                notes.add("a point has more than four joints, of which the four with the largest weights are used", 0);
            }
            for (at, (joint, weight)) in all.into_iter().take(USED).enumerate() {
                (joints[at], weights[at]) = (joint, weight);
            }
        }
    }
    if primitive.attributes.contains_key(&Checked::Valid(Semantic::Joints(SETS))) {
        notes.add("only the first eight sets of joints are read", 0);
    }
    Ok(Some((joints, weights)))
}

/// Makes the weights of every point add up to one and drops joints of no weight.
pub(super) fn normalise(mesh: &mut Mesh, notes: &mut Notes) {
    let at = |name: &str| mesh.attributes.iter().position(|attribute| attribute.name == name);
    let (Some(joints), Some(weights)) = (at("joints"), at("weights")) else { return };
    let Values::F32(mut weights_of) = std::mem::replace(&mut mesh.attributes[weights].values, Values::F32(Vec::new()))
    else {
        return;
    };
    if let Values::U32(joints_of) = &mut mesh.attributes[joints].values {
        for (joints, weights) in joints_of.as_chunks_mut::<USED>().0.iter_mut().zip(weights_of.as_chunks_mut().0) {
            normalise_point(joints, weights, notes);
        }
    }
    mesh.attributes[weights].values = Values::F32(weights_of);
}

fn normalise_point(joints: &mut [u32; USED], weights: &mut [f32; USED], notes: &mut Notes) {
    for (joint, weight) in joints.iter_mut().zip(weights.iter_mut()) {
        if *weight <= 0.0 {
            (*joint, *weight) = (0, 0.0);
        }
    }
    let sum: f64 = weights.iter().map(|weight| f64::from(*weight)).sum();
    if sum > 0.0 {
        weights.iter_mut().for_each(|weight| *weight = (f64::from(*weight) / sum) as f32);
    } else {
        notes.add("points without a joint hang on the first one", 0);
        (*joints, *weights) = ([0; USED], [1.0, 0.0, 0.0, 0.0]);
    }
}
