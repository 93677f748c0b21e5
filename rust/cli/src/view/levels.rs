//! A progressive mesh in the window, its level by a slider.

use std::path::Path;
use std::sync::Arc;

use relievo_core::{Context, Result};
use relievo_lod::Progressive;
use relievo_lod::progressive::{ActiveMesh, Cut};
use relievo_render::Mesh;
use relievo_view::show::{Eye, Picture, Range, Setting, Subject};

/// Levels of a mesh.
pub struct Levels {
    context: Context,
    name: String,
    mesh: Arc<Progressive>,
    active: ActiveMesh,
}

impl Levels {
    /// Opens a progressive mesh.
    pub fn open(context: Context, path: &Path) -> Result<Self> {
        let mesh = Arc::new(Progressive::open(&context, path, usize::MAX)?);
        let name = path.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
        Ok(Self { context, name, active: ActiveMesh::new(&mesh), mesh })
    }
}

impl Subject for Levels {
    fn name(&self) -> String {
        self.name.clone()
    }

    fn settings(&self) -> Vec<Setting> {
        let [least, most] = [self.mesh.base_faces().len(), self.mesh.triangle_count()].map(|count| count.max(1) as f64);
        vec![Setting {
            name: "Triangles".into(),
            hint: "The finest level of at most so many triangles".into(),
            range: Range::Slider { least, most, is_logarithmic: true, is_whole: true },
            value: most,
        }]
    }

    fn picture(&mut self, _: usize, values: &[f64], _: &Eye) -> Result<Picture> {
        let faces = values.first().map_or(usize::MAX, |count| count.round() as usize);
        let cut = if faces >= self.mesh.triangle_count() { Cut::FINEST } else { Cut::of_faces(&self.mesh, faces) };
        self.active.adapt(&self.context, cut);
        let left = self.mesh.splits().filter(|(split, key, _)| !cut.has(*key, *split));
        let error = left.map(|(_, key, _)| key.error()).fold(0.0, f32::max);
        let made = self.active.extract();
        let facts = vec![
            format!("{} vertices, {} triangles", made.points.len(), made.triangles.len()),
            format!("estimated deviation {error:.4}"),
        ];
        let mesh = Mesh { points: made.points, normals: made.normals, triangles: made.triangles, ..Mesh::default() };
        Ok(Picture { mesh, facts, ..Picture::default() })
    }
}
