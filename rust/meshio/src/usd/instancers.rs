//! Prims `PointInstancer` (OpenUSD's `UsdGeomPointInstancer`) with the places of their copies at rest.

use std::collections::HashSet;

use glam::{DAffine3, DQuat, DVec3};
use openusd::sdf::Value;
use relievo_core::{Error, Result};

use super::stage::{Prim, Stage, word, words};
use super::{hierarchy, opened, shown};
use crate::budget::Budget;
use crate::instancers::{Copied, PointInstancer};
use crate::root::Root;
use crate::transform;

/// Reads the point instancers of a stage, as [`super::read_usd`] reads its meshes. Copies are where they are at rest.
///
/// # Errors
/// The stage is damaged, or the arrays of an instancer differ in length or are not finite.
pub fn read_usd_instancers(
    bytes: Vec<u8>,
    memory_limit: u64,
    folder: &std::path::Path,
    root: &Root,
) -> Result<Vec<PointInstancer>> {
    let mut stage = Stage::open(bytes, Budget::new(memory_limit), folder, root)?;
    let (clock, space) = opened(&stage)?;
    let back = space.inverse();
    let top = stage.top();
    let mut waiting: Vec<(Prim, DAffine3)> = vec![(top, DAffine3::IDENTITY)];
    let mut found = Vec::new();
    while let Some((prim, above)) = waiting.pop() {
        let place = |error: Error| error.at(prim.path.clone());
        let mut own = above;
        if !prim.path.is_empty() {
            if !shown(&stage, &prim).map_err(place)? {
                continue;
            }
            let (operations, reset) = hierarchy::placement(&stage, &prim, clock).map_err(place)?;
            own = if reset { DAffine3::IDENTITY } else { above } * transform::map(&operations, None);
            let kind = stage.field(&prim, "typeName")?.as_deref().and_then(word).unwrap_or_default().to_owned();
            if kind == "PointInstancer" {
                let mut instancer = instancer(&stage, &prim).map_err(place)?;
                for copy in &mut instancer.copies {
                    copy.velocity = (space * own).transform_vector3(copy.velocity);
                    copy.transform = space * own * copy.transform * back;
                }
                found.push(instancer);
                // What is below are prototypes.
                continue;
            }
        }
        waiting.extend(stage.children(&prim)?.into_iter().rev().map(|child| (child, own)));
    }
    Ok(found)
}

/// Reads an instancer with the places of its copies in its own space.
fn instancer(stage: &Stage, prim: &Prim) -> Result<PointInstancer> {
    let prototypes = match stage.property_field(prim, "prototypes", "targetPaths")?.as_deref() {
        Some(Value::PathListOp(list)) => list.iter().map(|path| path.as_str().to_owned()).collect(),
        _ => Vec::new(),
    };
    let integers = |name: &str| -> Result<Vec<u32>> {
        let value = stage.property(prim, name)?;
        let list = value.rest().map(|value| stage.integers(value)).transpose()?.flatten();
        Ok(list.unwrap_or_default())
    };
    let floats = |name: &str, width: u32| -> Result<Vec<f32>> {
        let value = stage.property(prim, name)?;
        let list = value.rest().map(|value| stage.floats(value)).transpose()?.flatten();
        let values = list.filter(|list| list.1 == width).map_or_else(Vec::new, |list| list.0);
        match values.iter().all(|value| value.is_finite()) {
            true => Ok(values),
            false => Err(Error::invalid(format!("`{name}` has a number that is not finite"))),
        }
    };
    let indices = integers("protoIndices")?;
    let count = indices.len();
    if let Some(index) = indices.iter().find(|index| **index as usize >= prototypes.len()) {
        return Err(Error::invalid(format!("prototype {index} does not exist"))
            .advise(format!("the instancer has {} prototypes counted from 0", prototypes.len())));
    }
    let fits = |name: &str, length: usize, is_needed: bool| {
        let good = length == count || (length == 0 && !is_needed);
        if good { Ok(()) } else { Err(Error::invalid(format!("`{name}` has {length} elements for {count} copies"))) }
    };
    let (positions, scales, velocities) = (floats("positions", 3)?, floats("scales", 3)?, floats("velocities", 3)?);
    let mut orientations = Vec::new();
    for name in ["orientationsf", "orientations"] {
        let value = stage.property(prim, name)?;
        if orientations.is_empty()
            && let Some(value) = value.rest()
        {
            orientations = rotations(stage, value)?;
        }
    }
    fits("positions", positions.len() / 3, true)?;
    fits("scales", scales.len() / 3, false)?;
    fits("velocities", velocities.len() / 3, false)?;
    fits("orientations", orientations.len(), false)?;
    let phases = floats("primvars:phase", 1)?;
    let clips = stage.property(prim, "primvars:clip")?;
    let clips: Vec<String> = match clips.rest() {
        Some(value) => match (word(value), stage.integers(value)?) {
            (Some(one), _) => vec![one.to_owned()],
            (None, Some(numbers)) => numbers.iter().map(u32::to_string).collect(),
            (None, None) => words(value).into_iter().map(str::to_owned).collect(),
        },
        None => Vec::new(),
    };
    // A primvar may be one value for all.
    for (name, length) in [("primvars:phase", phases.len()), ("primvars:clip", clips.len())] {
        if length != 1 {
            fits(name, length, false)?;
        }
    }
    let hidden: HashSet<u32> = integers("invisibleIds")?.into_iter().chain(inactive(stage, prim)?).collect();
    let ids = integers("ids")?;
    fits("ids", ids.len(), false)?;
    stage.charge((size_of::<Copied>() * count) as u64 + clips.iter().map(|clip| clip.len() as u64).sum::<u64>())?;
    let vector = |list: &[f32], at: usize| {
        list.get(3 * at..3 * at + 3).map(|it| DVec3::new(f64::from(it[0]), f64::from(it[1]), f64::from(it[2])))
    };
    let mut copies = Vec::with_capacity(count);
    for (at, prototype) in indices.into_iter().enumerate() {
        if hidden.contains(&ids.get(at).copied().unwrap_or(at as u32)) {
            continue;
        }
        copies.push(Copied {
            prototype,
            transform: DAffine3::from_scale_rotation_translation(
                vector(&scales, at).unwrap_or(DVec3::ONE),
                orientations.get(at).copied().unwrap_or(DQuat::IDENTITY),
                vector(&positions, at).unwrap_or_default(),
            ),
            velocity: vector(&velocities, at).unwrap_or_default(),
            clip: clips.get(at).or(clips.first()).cloned().unwrap_or_default(),
            phase: f64::from(phases.get(at).or(phases.first()).copied().unwrap_or_default()),
        });
    }
    Ok(PointInstancer { path: prim.path.clone(), prototypes, copies })
}

/// Returns the ids of copies that are turned off.
fn inactive(stage: &Stage, prim: &Prim) -> Result<Vec<u32>> {
    let list = match stage.field(prim, "inactiveIds")?.as_deref() {
        Some(Value::Int64ListOp(list)) => list.iter().copied().collect::<Vec<i64>>(),
        // Layers of text have a plain list.
        Some(value) => return Ok(stage.integers(value)?.unwrap_or_default()),
        None => Vec::new(),
    };
    Ok(list.into_iter().filter_map(|id| u32::try_from(id).ok()).collect())
}

/// Returns unit quaternions of an array.
fn rotations(stage: &Stage, value: &Value) -> Result<Vec<DQuat>> {
    let unit = |parts: [f64; 4]| {
        let turn = DQuat::from_array(parts);
        let length = turn.length();
        if length > 1e-12 && length.is_finite() {
            Ok(turn * (1.0 / length))
        } else {
            Err(Error::invalid("an orientation has no length or is not finite"))
        }
    };
    let count = match value {
        Value::QuathVec(list) => list.len(),
        Value::QuatfVec(list) => list.len(),
        Value::QuatdVec(list) => list.len(),
        _ => 0,
    };
    stage.charge((size_of::<DQuat>() * count) as u64)?;
    match value {
        Value::QuathVec(list) => list.iter().map(|it| unit([it.x, it.y, it.z, it.w].map(f64::from))).collect(),
        Value::QuatfVec(list) => list.iter().map(|it| unit([it.x, it.y, it.z, it.w].map(f64::from))).collect(),
        Value::QuatdVec(list) => list.iter().map(|it| unit([it.x, it.y, it.z, it.w])).collect(),
        _ => Ok(Vec::new()),
    }
}
