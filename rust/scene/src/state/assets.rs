//! The meshes of a scene: read or generated, and where their points are at any time.

use std::path::{Path, PathBuf};

use glam::{DAffine3, DMat3, DVec3};
use relievo_core::{Context, Error, Mesh, Result};
use relievo_meshio::{Model, Root};

use crate::format::description::{Geometry, MeshSource, Scene};
use crate::format::diagnostic::{Diagnostic, Faults};
use crate::format::sequence::Pattern;
use crate::out::output::Folder;
use crate::state::checksum::checksum;
use crate::state::paths::Paths;
use crate::state::physics::Physics;
use crate::state::tissue::{Solid, Tissue, TissueSurface};

/// The meshes of a scene, by index.
#[derive(Debug)]
pub struct Assets {
    list: Vec<Asset>,
    /// Soft tissue that the scene simulates.
    tissues: Vec<Tissue>,
}

#[derive(Debug)]
struct Asset {
    /// At time 0.
    mesh: Mesh,
    motion: Motion,
    /// Checksums of the files it came from.
    files: Vec<u32>,
    notes: Vec<String>,
    /// Names of the slots of the attribute `material`.
    materials: Vec<String>,
}

#[derive(Debug)]
enum Motion {
    Still,
    Animation { model: Box<Model>, animation: usize },
    Sequence { paths: Vec<PathBuf>, loaded: Vec<(usize, Vec<[f32; 3]>)>, source: Box<Source> },
    Tissue { tissue: usize, bound: usize },
}

/// How the files of a sequence are read.
#[derive(Debug)]
enum Source {
    Meshes { root: Root, space: DAffine3, particles: bool },
    Tissue(TissueSurface),
}

impl Source {
    /// Reads a file: the mesh and the names of its materials.
    fn read(&self, context: &Context, path: &Path) -> Result<(Mesh, Vec<String>)> {
        match self {
            Self::Meshes { root, space, particles } => read_mesh(context, path, root, *space, *particles),
            Self::Tissue(surface) => Ok((surface.mesh(context, path)?, Vec::new())),
        }
    }

    /// Returns whether files may have different numbers of points.
    fn has_particles(&self) -> bool {
        matches!(self, Self::Meshes { particles: true, .. })
    }
}

impl Assets {
    /// Reads and generates the meshes of `scene`.
    ///
    /// # Errors
    /// Fails with a fault for each tissue that cannot be read or simulated. If all can be, it fails with a fault for
    /// each mesh whose file cannot be read, that does not pass [`Mesh::check`], or that lacks the animation or surface
    /// that the scene names.
    pub fn load(context: &Context, scene: &Scene, paths: &Paths) -> std::result::Result<Self, Faults> {
        let mut list = Vec::new();
        let mut faults = Vec::new();
        let mut tissues = Vec::new();
        for entry in &scene.tissue {
            match Tissue::read(context, scene, paths, entry, space(scene) * Y_UP) {
                Ok(tissue) => tissues.push(tissue),
                Err(error) => faults.push(Diagnostic::from_error(entry.simulation.span.clone(), &error)),
            }
        }
        // Meshes refer to tissue by its index.
        let count = if faults.is_empty() { scene.meshes.len() } else { 0 };
        for index in 0..count {
            match load(context, scene, paths, &tissues, index) {
                Ok(asset) => list.push(asset),
                Err(error) => faults.push(Diagnostic::from_error(scene.source_span(index), &error)),
            }
        }
        if faults.is_empty() {
            return Ok(Self { list, tissues });
        }
        Err(Faults { name: scene.path.display().to_string(), text: scene.text.clone(), list: faults })
    }

    /// Lets the tissue of a scene meet its bodies, of which each has a physics and the objects that it meets. Fails as
    /// [`Tissue::meet`] does.
    pub(crate) fn meet(
        &mut self,
        context: &Context,
        scene: &Scene,
        bodies: Vec<(Physics, Vec<Solid>)>,
    ) -> std::result::Result<(), Diagnostic> {
        for (index, (entry, (physics, solids))) in scene.tissue.iter().zip(bodies).enumerate() {
            let fault = |error: Error| Diagnostic::from_error(entry.name.span.clone(), &error);
            let shows =
                |mesh: usize| matches!(self.list[mesh].motion, Motion::Tissue { tissue, .. } if tissue == index);
            let shown = scene.objects.iter().position(|object| shows(scene.cage_of(object)));
            if let Some(body) = scene.bodies.iter().find(|body| shows(scene.cage_of(&scene.objects[body.object]))) {
                return Err(Diagnostic::new(body.name.span.clone(), "a body moves soft tissue as a whole")
                    .advise("remove the body; the simulation of the tissue moves it"));
            }
            if let Some(object) =
                entry.colliders.iter().find(|object| self.is_animated(scene.cage_of(&scene.objects[**object])))
            {
                let what = format!("`{}` changes its shape", scene.objects[*object].name.text);
                return Err(Diagnostic::new(entry.name.span.clone(), what)
                    .advise("let the tissue meet objects whose mesh does not change"));
            }
            let place = shown.map_or(DAffine3::IDENTITY, |object| physics.transforms()[object]);
            self.tissues[index].meet(context, (scene, entry), physics, place, &solids).map_err(fault)?;
        }
        for asset in &mut self.list {
            if let Motion::Tissue { tissue, bound } = asset.motion {
                asset.mesh = self.tissues[tissue].mesh(context, bound);
            }
        }
        Ok(())
    }

    /// Keeps the frames of tissue in the folder of the cache of a scene.
    pub(crate) fn keep_tissue(&mut self, cache: &Folder) -> Result<()> {
        self.tissues.iter_mut().try_for_each(|tissue| tissue.keep(cache))
    }

    /// Returns what the user should know of tissue since the last call.
    pub(crate) fn take_tissue_notes(&mut self) -> Vec<String> {
        self.tissues.iter_mut().flat_map(Tissue::take_notes).collect()
    }

    /// A mesh at time 0.
    pub fn mesh(&self, index: usize) -> &Mesh {
        &self.list[index].mesh
    }

    /// Whether the points of a mesh move.
    pub fn is_animated(&self, index: usize) -> bool {
        !matches!(self.list[index].motion, Motion::Still)
    }

    /// What was left out or repaired while reading a mesh.
    pub fn notes(&self, index: usize) -> &[String] {
        &self.list[index].notes
    }

    /// Names of the slots that a mesh's attribute `material` refers to.
    pub fn materials(&self, index: usize) -> &[String] {
        &self.list[index].materials
    }

    /// Checksums of the files a mesh came from.
    pub fn checksums(&self, index: usize) -> &[u32] {
        &self.list[index].files
    }

    /// Returns the files of a mesh, one for each frame; `None` if it is not a sequence.
    pub fn sequence(&self, index: usize) -> Option<&[PathBuf]> {
        match &self.list[index].motion {
            Motion::Sequence { paths, .. } => Some(paths),
            _ => None,
        }
    }

    /// The points of a mesh at `time` seconds, `fps` frames a second; between files of a sequence they move evenly,
    /// or stay where there are not as many in both.
    ///
    /// # Errors
    /// Fails as [`relievo_meshio::read_model_within`] if a file of a sequence cannot be read; with `Invalid` if it
    /// cannot be used or its faces are not those of the first file, or an element of tissue turns inside out; and with
    /// `NotFound` or `Io` if a frame of tissue cannot be read or written.
    pub fn points(&mut self, context: &Context, index: usize, time: f64, fps: f64) -> Result<Vec<[f32; 3]>> {
        let asset = &mut self.list[index];
        match &mut asset.motion {
            Motion::Tissue { tissue, bound } => {
                let tissue = &mut self.tissues[*tissue];
                let place = (time * fps).clamp(0.0, f64::from(tissue.last()));
                let (before, share) = (place.floor() as u32, place.fract());
                let a = tissue.points(context, *bound, before)?;
                if share == 0.0 {
                    return Ok(a);
                }
                Ok(blend(&a, &tissue.points(context, *bound, before + 1)?, share))
            }
            Motion::Still => Ok(asset.mesh.points.clone()),
            Motion::Animation { model, animation } => Ok(model.pose(context, *animation, time)?.merged_points()),
            Motion::Sequence { paths, loaded, source } => {
                let place = (time * fps).clamp(0.0, (paths.len() - 1) as f64);
                let (before, share) = (place.floor() as usize, place.fract());
                let after = (before + 1).min(paths.len() - 1);
                loaded.retain(|(number, _)| *number == before || *number == after);
                for number in [before, after] {
                    if loaded.iter().all(|(known, _)| *known != number) {
                        let (read, _) = source.read(context, &paths[number])?;
                        // There may be more or less particles in every file.
                        let alike = read.points.len() == asset.mesh.points.len() && read.corners == asset.mesh.corners;
                        if !(alike || source.has_particles()) {
                            return Err(Error::invalid("the topology differs from the sequence's first file")
                                .at(paths[number].display().to_string())
                                .advise("export all files of a sequence with the same faces"));
                        }
                        loaded.push((number, read.points));
                    }
                }
                let find = |number: usize| loaded.iter().find(|(known, _)| *known == number).map(|(_, points)| points);
                let (Some(a), Some(b)) = (find(before), find(after)) else {
                    return Err(Error::internal("a file of the sequence is not loaded"));
                };
                if share == 0.0 || a.len() != b.len() {
                    return Ok(a.clone());
                }
                Ok(blend(a, b, share))
            }
        }
    }
}

/// Returns points that are a share of the way from those of a list to those of another.
fn blend(a: &[[f32; 3]], b: &[[f32; 3]], share: f64) -> Vec<[f32; 3]> {
    let blend = |a: f32, b: f32| (f64::from(a) + (f64::from(b) - f64::from(a)) * share) as f32;
    a.iter().zip(b).map(|(a, b)| std::array::from_fn(|axis| blend(a[axis], b[axis]))).collect()
}

/// Turns what has z up so that y is up.
const Y_UP: DAffine3 =
    DAffine3 { matrix3: DMat3 { x_axis: DVec3::X, y_axis: DVec3::NEG_Z, z_axis: DVec3::Y }, translation: DVec3::ZERO };

/// What brings metres with y up to the units and the axis of a scene.
fn space(scene: &Scene) -> DAffine3 {
    DAffine3::from_mat3(scene.up.from_y_up() * scene.metres.recip())
}

/// What a file holds. Where it says its unit and which axis is up, it is brought to the scene's.
fn read_model(context: &Context, path: &Path, root: &Root, space: DAffine3) -> Result<Model> {
    let mut model = relievo_meshio::read_model_within(context, path, root)?;
    if model.is_converted {
        model.place(space);
    }
    Ok(model)
}

/// A mesh that can be used, and the names of its materials.
fn read_mesh(
    context: &Context,
    path: &Path,
    root: &Root,
    space: DAffine3,
    particles: bool,
) -> Result<(Mesh, Vec<String>)> {
    let model = read_model(context, path, root, space)?;
    let materials = model.materials.clone();
    let named = |error: Error| error.at(path.display().to_string());
    let mesh = model.into_merged_mesh(context).map_err(named)?;
    check(&mesh, particles).map_err(named)?;
    Ok((mesh, materials))
}

/// Whether nothing but the points of a mesh is used, which then needs no faces.
fn is_particles(scene: &Scene, index: usize) -> bool {
    let mut shown = scene.objects.iter().filter(|object| object.geometry == Geometry::Mesh(index)).peekable();
    shown.peek().is_some()
        && shown.all(|object| object.fluid.is_some())
        && scene.surfaces.iter().all(|surface| surface.mesh != index)
}

/// Fails if a mesh cannot be used: `particles` may be points alone, and none.
fn check(mesh: &Mesh, particles: bool) -> Result<()> {
    if !particles || !mesh.face_sizes.is_empty() {
        return mesh.check();
    }
    match mesh.points.iter().position(|point| !point.iter().all(|value| value.is_finite())) {
        Some(at) => Err(Error::invalid("a coordinate is not a finite number").at(format!("particle {at}"))),
        None => Ok(()),
    }
}

fn load(context: &Context, scene: &Scene, paths: &Paths, tissues: &[Tissue], index: usize) -> Result<Asset> {
    let particles = is_particles(scene, index);
    match &scene.meshes[index].source {
        MeshSource::Shape(shape) => {
            let mesh = shape.mesh(scene.up);
            Ok(Asset { mesh, motion: Motion::Still, files: Vec::new(), notes: Vec::new(), materials: Vec::new() })
        }
        MeshSource::Tissue { tissue, bound, .. } => {
            let simulated = &tissues[*tissue];
            let bound = simulated.bound(bound.as_ref().map(|name| name.text.as_str()))?;
            let (mesh, files) = (simulated.mesh(context, bound), simulated.checksums().to_vec());
            check(&mesh, particles)?;
            let motion = Motion::Tissue { tissue: *tissue, bound };
            Ok(Asset { mesh, motion, files, notes: Vec::new(), materials: Vec::new() })
        }
        MeshSource::File { path, animation } => {
            let path = paths.resolve(&path.text)?;
            let place = |error: Error| error.at(path.display().to_string());
            let files = vec![checksum(&path)?];
            let model = read_model(context, &path, paths.root(), space(scene))?;
            let (notes, materials) = (model.notes.clone(), model.materials.clone());
            let (mesh, motion) = match animation {
                None => (model.into_merged_mesh(context).map_err(place)?, Motion::Still),
                Some(name) => {
                    let animation = model.animation(&name.text).map_err(place)?;
                    let mut mesh = model.merged_mesh(context).map_err(place)?;
                    mesh.points = model.pose(context, animation, 0.0).map_err(place)?.merged_points();
                    (mesh, Motion::Animation { model: Box::new(model), animation })
                }
            };
            check(&mesh, particles).map_err(place)?;
            Ok(Asset { mesh, motion, files, notes, materials })
        }
        MeshSource::Sequence { pattern, first, count, tissue, bound } => {
            let mut list = Vec::new();
            let mut files = Vec::new();
            let pattern = Pattern::new(&pattern.text)?;
            for number in *first..first.saturating_add(*count) {
                let path = paths.resolve(&pattern.path(number))?;
                files.push(checksum(&path)?);
                list.push(path);
            }
            let Some(start) = list.first() else { return Err(Error::invalid("the sequence has no files")) };
            let source = match tissue {
                Some(model) => {
                    let path = paths.resolve(&model.text)?;
                    files.push(checksum(&path)?);
                    let name = bound.as_ref().map(|name| name.text.as_str());
                    Source::Tissue(TissueSurface::read(context, &path, name, space(scene) * Y_UP)?)
                }
                None => Source::Meshes { root: paths.root().clone(), space: space(scene), particles },
            };
            let (mesh, materials) = source.read(context, start)?;
            let loaded = vec![(0, mesh.points.clone())];
            let motion = Motion::Sequence { loaded, paths: list, source: Box::new(source) };
            Ok(Asset { mesh, motion, files, notes: Vec::new(), materials })
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TRIANGLE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 HEIGHT\nf 1 2 3\n";

    fn scene(folder: &Path, meshes: &str) -> (Scene, Paths) {
        let text = format!("version = 1\n[objects.a]\nmesh = \"a\"\n[meshes.a]\n{meshes}\n");
        let path = folder.join("scene.toml");
        let scene = crate::format::file::parse(&path, &text).unwrap_or_else(|faults| panic!("{faults}"));
        (scene, Paths::new(&path, &[]).unwrap())
    }

    #[test]
    fn a_sequence_moves_evenly_between_its_files_and_rests_at_its_ends() {
        let folder = tempfile::tempdir().unwrap();
        for number in 3..6 {
            let text = TRIANGLE.replace("HEIGHT", &number.to_string());
            std::fs::write(folder.path().join(format!("walk.{number:03}.obj")), text).unwrap();
        }
        let context = Context::serial();
        for pattern in ["walk.###.obj", "walk.%03d.obj", "walk.00%d.obj"] {
            let (scene, paths) = scene(folder.path(), &format!("sequence = \"{pattern}\"\nfirst = 3\ncount = 3"));
            let mut assets = Assets::load(&context, &scene, &paths).unwrap();
            for (frame, height) in [(0.0, 3.0), (0.25, 3.25), (1.0, 4.0), (1.5, 4.5), (9.0, 5.0), (0.5, 3.5)] {
                let found = assets.points(&context, 0, frame / 24.0, 24.0).unwrap()[2][2];
                assert_eq!(found, height, "{pattern}, frame {frame}");
            }
        }
    }

    #[test]
    fn meshes_that_cannot_be_used_are_told_at_the_path() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("bad.obj"), "v 0 0 0\nv 1 0 0\nf 1 2 9\n").unwrap();
        let context = Context::serial();
        for (mesh, says) in [
            ("file = \"missing.obj\"", "there is no file"),
            ("file = \"bad.obj\"", "bad.obj"),
            ("file = \"../bad.obj\"", "--allow-path"),
            ("sequence = \"bad.#.obj\"\ncount = 2", "there is no file"),
            ("sequence = \"bad.%02d.obj\"\ncount = 2", "bad.00.obj"),
        ] {
            let (scene, paths) = scene(folder.path(), mesh);
            let faults = Assets::load(&context, &scene, &paths).unwrap_err();
            let shown = faults.to_string();
            assert!(shown.contains(says) && shown.contains("scene.toml:5:"), "{shown}");
        }
    }
}
