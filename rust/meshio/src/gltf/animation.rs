//! Animations of a glTF file (glTF 2.0, Section 3.11).

use gltf::json::accessor::Type;
use gltf::json::animation::{Animation as Source, Channel as SourceChannel, Interpolation as Curve, Property as Path};
use relievo_core::{Error, Result};

use super::accessor::{Wanted, floats};
use super::container::{Container, understood};
use super::hierarchy::Hierarchy;
use crate::budget::Budget;
use crate::model::{Animation, Channel, Interpolation, Part, Property};
use crate::notes::Notes;

/// Reads all animations.
pub(crate) fn animations(
    file: &Container,
    budget: &mut Budget,
    notes: &mut Notes,
    hierarchy: &Hierarchy,
    meshes: &[Part],
) -> Result<Vec<Animation>> {
    let mut animations = Vec::new();
    for (index, source) in file.json.animations.iter().enumerate() {
        let mut channels = Vec::new();
        for (number, channel) in source.channels.iter().enumerate() {
            let place = |error: Error| error.at(format!("animation {index}, channel {number}"));
            channels.extend(self::channel(file, budget, notes, hierarchy, meshes, source, channel).map_err(place)?);
        }
        let name = source.name.clone().unwrap_or_default();
        animations.push(Animation { name, channels, ..Animation::default() });
    }
    Ok(animations)
}

fn channel(
    file: &Container,
    budget: &mut Budget,
    notes: &mut Notes,
    hierarchy: &Hierarchy,
    meshes: &[Part],
    animation: &Source,
    source: &SourceChannel,
) -> Result<Option<Channel>> {
    let missing = |what: &str, index: usize| Error::invalid(format!("{what} {index} does not exist"));
    let sampler = source.sampler.value();
    let sampler = animation.samplers.get(sampler).ok_or_else(|| missing("sampler", sampler))?;
    let target = source.target.node.value();
    let node = *hierarchy.place.get(target).ok_or_else(|| missing("node", target))?;
    let property = match understood(&source.target.path, "path")? {
        Path::Translation => Property::Translation,
        Path::Rotation => Property::Rotation,
        Path::Scale => Property::Scale,
        Path::MorphTargetWeights => Property::Weights,
    };
    let interpolation = match understood(&sampler.interpolation, "interpolation")? {
        Curve::Linear => Interpolation::Linear,
        Curve::Step => Interpolation::Step,
        Curve::CubicSpline => Interpolation::Cubic,
    };
    let width = match property {
        Property::Translation | Property::Scale => 3,
        Property::Rotation => 4,
        Property::Weights => {
            hierarchy.nodes[node].mesh.and_then(|mesh| meshes.get(mesh)).map_or(0, |part| part.targets.len())
        }
    };
    if width == 0 {
        notes.add("an animation of morph weights is left out because its node has no morph targets", 0);
        return Ok(None);
    }
    let wanted = Wanted { shapes: &[Type::Scalar], count: None };
    let (times, _) = floats(file, budget, sampler.input.value(), &wanted).map_err(|error| error.at("times"))?;
    if let Some(at) = times.windows(2).position(|pair| pair[0] >= pair[1]) {
        return Err(Error::invalid(format!("key {} is not later than key {at}", at + 1))
            .advise("keys must be in the order of time"));
    }
    if times.is_empty() {
        return Ok(None);
    }
    let shape = match property {
        Property::Translation | Property::Scale => Type::Vec3,
        Property::Rotation => Type::Vec4,
        Property::Weights => Type::Scalar,
    };
    let wanted = Wanted { shapes: &[shape], count: None };
    let (values, _) = floats(file, budget, sampler.output.value(), &wanted).map_err(|error| error.at("values"))?;
    let parts = if interpolation == Interpolation::Cubic { 3 } else { 1 };
    if values.len() != times.len() * width * parts {
        let what =
            format!("{} keys have {} numbers instead of {}", times.len(), values.len(), times.len() * width * parts);
        return Err(Error::invalid(what).advise("export the file again"));
    }
    Ok(Some(Channel { node, property, interpolation, times, values }))
}
