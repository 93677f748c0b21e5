//! Surfaces that follow soft tissue, in the frames that a simulation wrote.

use std::path::Path;

use glam::{DAffine3, Vec3};
use relievo_core::{Context, Error, Mesh, Result};
use relievo_tissue::{Model, SavedState};

/// A bound surface of a model.
#[derive(Debug)]
pub struct TissueSurface {
    model: Model,
    bound: usize,
    /// From the metres of the model, z up, to the units of the scene.
    space: DAffine3,
}

impl TissueSurface {
    /// Reads a model and finds its bound surface of a name, or the first. Fails if the file is damaged or there is none.
    pub fn read(context: &Context, path: &Path, name: Option<&str>, space: DAffine3) -> Result<Self> {
        let model = Model::read(context, path)?;
        let bound = find(&model, name).map_err(|error| error.at(path.display().to_string()))?;
        Ok(Self { bound, space, model })
    }

    /// Returns the surface in a frame. Fails if the file is damaged or of another model.
    pub fn mesh(&self, context: &Context, path: &Path) -> Result<Mesh> {
        let state = SavedState::read(context, path)?.state;
        let (nodes, moved) = (self.model.nodes.len(), state.displacements.len());
        if moved != nodes {
            return Err(Error::invalid(format!("{moved} nodes of the frame do not fit the {nodes} of the model"))
                .at(path.display().to_string())
                .advise("name the model that was simulated"));
        }
        let binding = &self.model.bindings[self.bound];
        let points = binding.points(context, &self.model, &state.displacements);
        let place = |point: [f32; 3]| self.space.transform_point3(Vec3::from(point).as_dvec3()).as_vec3().to_array();
        Ok(Mesh::from_triangles(points.into_iter().map(place).collect(), &binding.triangles))
    }
}

/// Returns the number of the bound surface of a name, or of the first. Fails if there is none.
pub(super) fn find(model: &Model, name: Option<&str>) -> Result<usize> {
    let bound = model.bindings.iter().position(|binding| name.is_none_or(|name| binding.name == name));
    bound.ok_or_else(|| {
        let names: Vec<&str> = model.bindings.iter().map(|binding| binding.name.as_str()).collect();
        let advice =
            if names.is_empty() { "build it with [[bind]]".to_owned() } else { format!("it has {}", names.join(", ")) };
        Error::invalid("the model has no such bound surface").advise(advice)
    })
}
