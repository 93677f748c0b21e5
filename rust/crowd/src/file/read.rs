//! The chunks of a file that is read.

use glam::{DAffine3, DMat3, DVec3};
use relievo_core::{Attribute, Domain, Result, Values};

use super::columns::{Rows, index_bytes, unfolded};
use super::{Counts, MIXED, damaged};
use crate::character::{Bone, Influence};
use crate::clip::{Clip, MAX_POSES, Pose};
use crate::geomorph::Collapse;
use crate::hierarchy::{Cluster, CrowdModel, Distances, Group, NONE, Report};
use crate::morph::{MAX_MORPHS, MorphOffset};

/// Returns the number of poses of each clip, and the number of offsets of morph targets.
pub(super) fn read_skeleton(bytes: &[u8], counts: &Counts, model: &mut CrowdModel) -> Result<(Vec<usize>, usize)> {
    let mut rows = Rows(bytes);
    let character = &mut model.character;
    for _ in 0..rows.number()? {
        character.material_names.push(rows.text()?);
    }
    for _ in 0..counts.bones {
        let (name, node) = (rows.text()?, rows.number()?);
        let mut values = [0.0; 12];
        for value in &mut values {
            *value = f64::from_bits(rows.long()?);
        }
        let column = |at: usize| DVec3::new(values[at], values[at + 1], values[at + 2]);
        let linear = DMat3::from_cols(column(0), column(3), column(6));
        character.bones.push(Bone { name, node, inverse_bind: DAffine3::from_mat3_translation(linear, column(9)) });
    }
    character.parents =
        rows.numbers(counts.nodes)?.into_iter().map(|parent| Some(parent).filter(|it| *it != NONE)).collect();
    let mut frames = Vec::new();
    for _ in 0..counts.clips {
        let (name, rate, poses) = (rows.text()?, rows.floats(1)?[0], rows.number()? as usize);
        if !(rate > 0.0) || poses == 0 || poses > MAX_POSES {
            return Err(damaged("a clip has no rate or no poses"));
        }
        model.clips.push(Clip { name, rate, poses: Vec::new() });
        frames.push(poses);
    }
    for _ in 0..counts.attributes {
        let (name, width) = (rows.text()?, rows.number()?);
        if !(1..=4).contains(&width) {
            return Err(damaged("an attribute has no width"));
        }
        let values = Values::F32(Vec::new());
        character.attributes.push(Attribute { name, domain: Domain::Point, width, values, indices: None });
    }
    let (poses, representatives) = (rows.number()?, rows.number()?);
    model.report = Report { poses, representatives, measured: rows.long()?, exceeded: rows.long()? };
    let bounds = rows.floats(6)?;
    (model.low, model.high) = ([bounds[0], bounds[1], bounds[2]], [bounds[3], bounds[4], bounds[5]]);
    let mut offsets = 0;
    if counts.version > 1 {
        (model.character.morphs.count, offsets) = (rows.number()?, rows.number()? as usize);
        let least = if counts.version == 2 { 1 } else { 0 };
        if !(least..=MAX_MORPHS).contains(&(model.character.morphs.count as usize)) {
            return Err(damaged("the number of morph targets is wrong"));
        }
    }
    rows.end()?;
    Ok((frames, offsets))
}

/// Returns the lengths of the chunks of clusters, the coarsest first.
pub(super) fn read_hierarchy(bytes: &[u8], counts: &Counts, model: &mut CrowdModel) -> Result<Vec<u32>> {
    let mut rows = Rows(bytes);
    let clusters = counts.clusters;
    let (sizes, made_by, used_by) = (rows.numbers(clusters)?, rows.numbers(clusters)?, rows.numbers(clusters)?);
    let (deformation, depth) = (rows.floats(clusters)?, rows.numbers(clusters)?);
    let mut first: u32 = 0;
    for index in 0..clusters {
        let count = sizes[index];
        model.clusters.push(Cluster {
            first,
            count,
            made_by: made_by[index],
            used_by: used_by[index],
            deformation: deformation[index],
            depth: depth[index],
        });
        first = first.checked_add(count).ok_or_else(|| damaged("there are too many triangles"))?;
    }
    if first as usize != counts.triangles {
        return Err(damaged("the clusters have another number of triangles than the file"));
    }
    let errors = rows.floats(counts.groups)?;
    let mut bounds = Vec::new();
    for _ in 0..6 {
        bounds.push(rows.floats(counts.groups)?);
    }
    let depth = rows.numbers(counts.groups)?;
    for (index, error) in errors.into_iter().enumerate() {
        let low = [bounds[0][index], bounds[2][index], bounds[4][index]];
        let high = [bounds[1][index], bounds[3][index], bounds[5][index]];
        model.groups.push(Group { error, low, high, depth: depth[index] });
    }
    if counts.version > 3 {
        let (chosen, all) = (rows.floats(counts.groups)?, rows.floats(counts.groups)?);
        model.distances = chosen.into_iter().zip(all).map(|(chosen, all)| Distances { chosen, all }).collect();
    }
    let lengths = rows.numbers(clusters)?;
    rows.end()?;
    Ok(lengths)
}

pub(super) fn read_vertices(bytes: &[u8], (counts, offsets): (&Counts, usize), model: &mut CrowdModel) -> Result<()> {
    let mut rows = Rows(bytes);
    let count = counts.vertices;
    let axes = [rows.floats(count)?, rows.floats(count)?, rows.floats(count)?];
    let character = &mut model.character;
    character.points = (0..count).map(|index| [axes[0][index], axes[1][index], axes[2][index]]).collect();
    character.influences = vec![Influence::default(); count];
    for slot in 0..4 {
        let (bones, weights) = (rows.numbers(count)?, rows.floats(count)?);
        for (influence, (bone, weight)) in character.influences.iter_mut().zip(bones.into_iter().zip(weights)) {
            influence.bones[slot] = u16::try_from(bone).map_err(|_| damaged("a bone does not exist"))?;
            influence.weights[slot] = weight;
        }
    }
    for attribute in &mut character.attributes {
        let width = attribute.width as usize;
        let mut values = vec![0.0; count * width];
        for at in 0..width {
            let column = rows.floats(count)?;
            values.iter_mut().skip(at).step_by(width).zip(column).for_each(|(to, from)| *to = from);
        }
        attribute.values = Values::F32(values);
    }
    if character.morphs.count > 0 {
        let morphs = &mut character.morphs;
        let mut sum = 0u32;
        morphs.starts.push(0);
        for own in rows.numbers(count)? {
            sum = sum.checked_add(own).ok_or_else(|| damaged("there are too many offsets"))?;
            morphs.starts.push(sum);
        }
        let targets = rows.numbers(offsets)?;
        let axes = [rows.floats(offsets)?, rows.floats(offsets)?, rows.floats(offsets)?];
        let offset = |(at, morph): (usize, u32)| MorphOffset { morph, offset: [axes[0][at], axes[1][at], axes[2][at]] };
        morphs.offsets = targets.into_iter().enumerate().map(offset).collect();
    }
    if counts.version > 2 {
        let (groups, targets) = (rows.numbers(count)?, rows.numbers(count)?);
        let targets = (0..).zip(targets).map(|(vertex, number): (u32, u32)| vertex.wrapping_add(unfolded(number)));
        model.collapses = groups.into_iter().zip(targets).map(|(group, target)| Collapse { group, target }).collect();
    }
    rows.end()
}

pub(super) fn read_poses(bytes: &[u8], frames: &[usize], model: &mut CrowdModel) -> Result<()> {
    let mut rows = Rows(bytes);
    let bones = model.character.bones.len();
    let poses: usize = frames.iter().sum();
    let total = poses.checked_mul(bones).ok_or_else(|| damaged("there are too many poses"))?;
    let mut columns = Vec::new();
    for _ in 0..12 {
        columns.push(rows.floats(total)?);
    }
    let morphs = model.character.morphs.count as usize;
    let weights = rows.floats(poses.checked_mul(morphs).ok_or_else(|| damaged("there are too many weights"))?)?;
    let matrix = |at: usize| std::array::from_fn(|row| std::array::from_fn(|column| columns[4 * row + column][at]));
    let mut made = (0..poses).map(|pose| Pose {
        bones: (0..bones).map(|bone| matrix(pose * bones + bone)).collect(),
        weights: weights[pose * morphs..(pose + 1) * morphs].to_vec(),
    });
    for (clip, count) in model.clips.iter_mut().zip(frames) {
        clip.poses = made.by_ref().take(*count).collect();
    }
    rows.end()
}

pub(super) fn read_cluster(bytes: &[u8], count: usize, vertex_count: usize) -> Result<(Vec<[u32; 3]>, Vec<u32>)> {
    let mut rows = Rows(bytes);
    let (used, common) = (rows.number()? as usize, rows.number()?);
    let mut vertices = rows.numbers(used)?;
    let mut sum: u32 = 0;
    for vertex in &mut vertices {
        sum = sum.checked_add(*vertex).ok_or_else(|| damaged("a vertex does not exist"))?;
        *vertex = sum;
    }
    if sum as usize >= vertex_count {
        return Err(damaged("a vertex does not exist"));
    }
    let indices = rows.planes(3 * count, index_bytes(used))?;
    let vertex = |index: u32| vertices.get(index as usize).copied().ok_or_else(|| damaged("a vertex does not exist"));
    let triangle = |corners: &[u32; 3]| Ok([vertex(corners[0])?, vertex(corners[1])?, vertex(corners[2])?]);
    let triangles = indices.as_chunks::<3>().0.iter().map(triangle).collect::<Result<Vec<_>>>()?;
    let materials = if common == MIXED { rows.numbers(count)? } else { vec![common; count] };
    rows.end()?;
    Ok((triangles, materials))
}
