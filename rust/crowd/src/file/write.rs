//! The chunks of a file that is written.

use relievo_core::Values;

use super::MIXED;
use super::columns::{Columns, folded, index_bytes};
use crate::geomorph::Collapse;
use crate::hierarchy::{Cluster, CrowdModel, NONE, Report};
use crate::morph::Morphs;

impl CrowdModel {
    pub(super) fn skeleton_bytes(&self) -> Vec<u8> {
        let character = &self.character;
        let mut out = Columns::default();
        out.number(character.material_names.len() as u32);
        character.material_names.iter().for_each(|name| out.text(name));
        for bone in &character.bones {
            out.text(&bone.name);
            out.number(bone.node);
            bone.inverse_bind.to_cols_array().iter().for_each(|value| out.0.extend(value.to_le_bytes()));
        }
        out.numbers(&character.parents.iter().map(|parent| parent.unwrap_or(NONE)).collect::<Vec<_>>());
        for clip in &self.clips {
            out.text(&clip.name);
            out.number(clip.rate.to_bits());
            out.number(clip.poses.len() as u32);
        }
        for attribute in &character.attributes {
            out.text(&attribute.name);
            out.number(attribute.width);
        }
        let Report { poses, representatives, measured, exceeded } = self.report;
        out.number(poses);
        out.number(representatives);
        out.0.extend([measured, exceeded].iter().flat_map(|count| count.to_le_bytes()));
        out.floats(self.low.into_iter().chain(self.high));
        if self.file_version() > 1 {
            out.number(character.morphs.count);
            out.number(character.morphs.offsets.len() as u32);
        }
        out.0
    }

    pub(super) fn hierarchy_bytes(&self, lengths: &[u32]) -> Vec<u8> {
        let mut out = Columns::default();
        let column = |value: fn(&Cluster) -> u32| self.clusters.iter().map(value).collect::<Vec<_>>();
        out.numbers(&column(|cluster| cluster.count));
        out.numbers(&column(|cluster| cluster.made_by));
        out.numbers(&column(|cluster| cluster.used_by));
        out.numbers(&column(|cluster| cluster.deformation.to_bits()));
        out.numbers(&column(|cluster| cluster.depth));
        out.floats(self.groups.iter().map(|group| group.error));
        for axis in 0..3 {
            out.floats(self.groups.iter().map(|group| group.low[axis]));
            out.floats(self.groups.iter().map(|group| group.high[axis]));
        }
        out.numbers(&self.groups.iter().map(|group| group.depth).collect::<Vec<_>>());
        if self.file_version() > 3 {
            out.floats(self.distances.iter().map(|it| it.chosen));
            out.floats(self.distances.iter().map(|it| it.all));
        }
        out.numbers(lengths);
        out.0
    }

    pub(super) fn vertex_bytes(&self) -> Vec<u8> {
        let character = &self.character;
        let mut out = Columns::default();
        (0..3).for_each(|axis| out.floats(character.points.iter().map(|point| point[axis])));
        for slot in 0..4 {
            out.numbers(&character.influences.iter().map(|it| u32::from(it.bones[slot])).collect::<Vec<_>>());
            out.floats(character.influences.iter().map(|influence| influence.weights[slot]));
        }
        for attribute in &character.attributes {
            let (Values::F32(values), width) = (&attribute.values, attribute.width as usize) else { continue };
            (0..width).for_each(|at| out.floats(values.iter().skip(at).step_by(width).copied()));
        }
        if character.morphs.count > 0 {
            let Morphs { starts, offsets, .. } = &character.morphs;
            out.numbers(&starts.windows(2).map(|pair| pair[1] - pair[0]).collect::<Vec<_>>());
            out.numbers(&offsets.iter().map(|it| it.morph).collect::<Vec<_>>());
            (0..3).for_each(|axis| out.floats(offsets.iter().map(|it| it.offset[axis])));
        }
        if self.has_collapses() {
            out.numbers(&self.collapses.iter().map(|it| it.group).collect::<Vec<_>>());
            // Vertices go to near ones, most of which have near numbers.
            let step = |(vertex, it): (u32, &Collapse)| it.target.wrapping_sub(vertex);
            out.numbers(&(0..).zip(&self.collapses).map(step).map(folded).collect::<Vec<_>>());
        }
        out.0
    }

    pub(super) fn pose_bytes(&self) -> Vec<u8> {
        let mut out = Columns::default();
        let poses = || self.clips.iter().flat_map(|clip| &clip.poses);
        for (row, column) in (0..3).flat_map(|row| (0..4).map(move |column| (row, column))) {
            out.floats(poses().flat_map(|pose| pose.bones.iter().map(move |bone| bone[row][column])));
        }
        out.floats(poses().flat_map(|pose| pose.weights.iter().copied()));
        out.0
    }

    pub(super) fn cluster_bytes(&self, index: u32) -> Vec<u8> {
        let Cluster { first, count, .. } = self.clusters[index as usize];
        let triangles = self.triangles(index);
        let materials = &self.character.materials[first as usize..(first + count) as usize];
        let mut vertices: Vec<u32> = triangles.iter().flatten().copied().collect();
        vertices.sort_unstable();
        vertices.dedup();
        let mut out = Columns::default();
        let common = materials.first().copied().filter(|one| materials.iter().all(|other| other == one));
        out.number(vertices.len() as u32);
        out.number(common.unwrap_or(MIXED));
        let before = std::iter::once(0).chain(vertices.iter().copied());
        out.numbers(&vertices.iter().zip(before).map(|(vertex, before)| vertex - before).collect::<Vec<_>>());
        let local = |vertex: &u32| vertices.binary_search(vertex).unwrap_or_default() as u32;
        let indices: Vec<u32> = triangles.iter().flatten().map(local).collect();
        out.planes(&indices, index_bytes(vertices.len()));
        if common.is_none() {
            out.numbers(materials);
        }
        out.0
    }
}
