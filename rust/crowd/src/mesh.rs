//! Meshes of crowd models: some of the clusters in one pose, with attributes and materials.

use std::collections::HashMap;

use relievo_core::{Attribute, Context, Domain, Mesh, Result, Values};

use crate::clip::Pose;
use crate::hierarchy::CrowdModel;
use crate::skinning::{skin, skin_normals};

impl CrowdModel {
    /// Makes a mesh of clusters in a pose. It has the vertices that they use, with the attributes of the character and
    /// its normals turned into the pose, and the index of the material of each face as `material`.
    ///
    /// # Errors
    /// The pose has another number of bones than the character, or clusters of the model are read while it is drawn.
    pub fn mesh(&self, context: &Context, clusters: &[u32], pose: &Pose) -> Result<Mesh> {
        self.check_triangles()?;
        let points = skin(context, &self.character, pose, self.blend)?;
        let normals = skin_normals(context, &self.character, pose, self.blend)?;
        Ok(self.gathered(clusters, &points, &normals).0)
    }

    /// Makes a mesh of clusters with the vertices that they use, at `points` with `normals`. Returns also the vertices.
    pub(crate) fn gathered(&self, clusters: &[u32], points: &[[f32; 3]], normals: &[[f32; 3]]) -> (Mesh, Vec<usize>) {
        let mut numbers = HashMap::new();
        let mut used: Vec<usize> = Vec::new();
        let (mut triangles, mut materials) = (Vec::new(), Vec::new());
        for cluster in clusters {
            for triangle in self.triangles(*cluster) {
                triangles.push(triangle.map(|vertex| {
                    *numbers.entry(vertex).or_insert_with(|| {
                        used.push(vertex as usize);
                        used.len() as u32 - 1
                    })
                }));
            }
            let found = self.clusters[*cluster as usize];
            let range = found.first as usize..(found.first + found.count) as usize;
            materials.extend(&self.character.materials[range]);
        }
        let mut mesh = Mesh::from_triangles(used.iter().map(|vertex| points[*vertex]).collect(), &triangles);
        for attribute in &self.character.attributes {
            let width = attribute.width as usize;
            let values = match self.character.values(&attribute.name) {
                Some(_) if attribute.name == "normal" => used.iter().flat_map(|vertex| normals[*vertex]).collect(),
                Some(values) => used.iter().flat_map(|vertex| &values[vertex * width..][..width]).copied().collect(),
                None => continue,
            };
            mesh.attributes.push(Attribute { values: Values::F32(values), ..attribute.clone() });
        }
        mesh.attributes.push(Attribute {
            name: "material".into(),
            domain: Domain::Face,
            width: 1,
            values: Values::U32(materials),
            indices: None,
        });
        (mesh, used)
    }
}
