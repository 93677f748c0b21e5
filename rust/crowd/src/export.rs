//! Levels of detail as glTF, for engines without this library: one skinned mesh for each level, by the extension MSFT_lod or
//! in files of their own.

use std::f64::consts::PI;
use std::path::{Path, PathBuf};

use glam::{DAffine3, DMat3, DVec3, Vec3};
use relievo_core::{Attribute, Domain, Error, Mesh, Progress, Result, Values};
use relievo_meshio::{Joint, JointClip, Levels, write_glb_levels};

use crate::clip::BoneMatrix;
use crate::hierarchy::CrowdModel;

/// Levels of detail at most.
pub const MAX_LEVELS: u32 = 16;
/// Ratio of the triangles of a level to those of the one before.
const RATIO: f64 = 0.25;
/// Pixels of the screen that coverages are computed for.
const SCREEN: [f64; 2] = [1920.0, 1080.0];

/// What levels of detail are written, and how.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LevelSettings {
    /// Levels at most, 1 to [`MAX_LEVELS`].
    pub count: u32,
    /// Error that may be seen, in pixels of a screen of 1920 × 1080, above 0.
    pub pixels: f64,
    /// Whether each level has a file of its own, without the extension MSFT_lod: of `robot.glb` they are `robot_LOD0.glb` and
    /// so on.
    pub is_separate: bool,
}

/// What an export wrote.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Exported {
    /// The file that has all levels, or the file of every level.
    pub files: Vec<PathBuf>,
    /// The error of every level, in units of the model, and its triangles; the finest first.
    pub levels: Vec<(f32, u64)>,
    /// Bones that are sheared in some pose, which glTF cannot say.
    pub sheared: u32,
}

impl CrowdModel {
    /// Returns the errors and the clusters of up to `count` levels: the input, then cuts of at most a fourth of the triangles
    /// of the level before, as fine as that allows. Fewer where the model has no coarser cuts.
    pub fn levels(&self, count: u32) -> Vec<(f32, Vec<u32>)> {
        let mut errors: Vec<f32> = self.groups.iter().map(|group| group.error).collect();
        errors.sort_unstable_by(f32::total_cmp);
        let mut levels = vec![(0.0, self.input_clusters())];
        let mut triangles = self.triangle_count(&levels[0].1);
        for _ in 1..count {
            let most = (RATIO * triangles as f64) as u64;
            // Triangles fall as errors rise.
            let at = errors.partition_point(|error| self.triangle_count(&self.cut(*error)) > most);
            let Some(error) = errors.get(at).or(errors.last()) else { break };
            let cut = self.cut(*error);
            let left = self.triangle_count(&cut);
            if left >= triangles {
                break;
            }
            triangles = left;
            levels.push((*error, cut));
        }
        levels
    }

    /// Writes levels of detail as GLB, skinned, with all clips. With the extension MSFT_lod a level is shown where its error
    /// covers at most so many pixels. Clips end with their first pose, so that they repeat. Morph targets keep the weights of
    /// the first pose.
    ///
    /// # Errors
    /// A number is out of range, a file cannot be written (files of finer levels are there then), or `progress` asks to
    /// stop.
    pub fn save_levels(&self, path: &Path, settings: &LevelSettings, progress: &mut dyn Progress) -> Result<Exported> {
        let LevelSettings { count, pixels, is_separate } = *settings;
        if !(1..=MAX_LEVELS).contains(&count) || !(pixels > 0.0 && pixels.is_finite()) {
            return Err(Error::invalid(format!("{count} levels of {pixels} pixels"))
                .advise(format!("give 1 to {MAX_LEVELS} levels and an error above 0 pixels")));
        }
        progress.step(0.0, "cut levels")?;
        let levels = self.levels(count);
        progress.step(0.3, "gather levels")?;
        let meshes: Vec<Mesh> = levels.iter().map(|(_, clusters)| self.skinned_mesh(clusters)).collect();
        let radius = 0.5 * f64::from(self.size());
        let coverage = |error: f32| {
            // The radius in pixels where the error is as large as it may be.
            let seen = radius * pixels / f64::from(error.max(f32::MIN_POSITIVE));
            (PI * seen * seen / (SCREEN[0] * SCREEN[1])).min(1.0)
        };
        // A level is shown until the next one is good enough, the last to the end.
        let coverages: Vec<f64> = levels.iter().skip(1).map(|(error, _)| coverage(*error)).chain([0.0]).collect();
        // A singular map has no inverse: the joint then is the map of the bone itself.
        let inverse_bind = |map: &DAffine3| {
            let is_regular = map.matrix3.determinant() != 0.0 && map.inverse().is_finite();
            if is_regular { *map } else { DAffine3::IDENTITY }
        };
        let bones = &self.character.bones;
        let joints: Vec<Joint> = bones
            .iter()
            .map(|bone| Joint { name: &bone.name, inverse_bind: inverse_bind(&bone.inverse_bind) })
            .collect();
        let binds: Vec<DAffine3> = joints.iter().map(|joint| joint.inverse_bind.inverse()).collect();
        let clips: Vec<JointClip> = self
            .clips
            .iter()
            .map(|clip| {
                let poses = || clip.poses.iter().chain(clip.poses.first());
                let times = (0..poses().count()).map(|frame| frame as f32 / clip.rate).collect();
                let places = poses().map(|pose| pose.bones.iter().zip(&binds).map(|(bone, bind)| map(bone) * *bind));
                JointClip { name: &clip.name, times, places: places.map(Iterator::collect).collect() }
            })
            .collect();
        let whole = Levels {
            name: "model",
            meshes: &meshes,
            coverages: &coverages,
            materials: &self.character.material_names,
            joints: &joints,
            clips: &clips,
        };
        let triangles = |(error, clusters): &(f32, Vec<u32>)| (*error, self.triangle_count(clusters));
        let mut made = Exported { levels: levels.iter().map(triangles).collect(), ..Exported::default() };
        let parts: Vec<(PathBuf, Levels)> = if is_separate {
            // The coarser levels of other files are not known there.
            let alone = |(level, mesh)| {
                (level_path(path, level), Levels { meshes: std::slice::from_ref(mesh), coverages: &[0.0], ..whole })
            };
            meshes.iter().enumerate().map(alone).collect()
        } else {
            vec![(path.to_owned(), whole)]
        };
        for (number, (path, part)) in parts.iter().enumerate() {
            progress.step(0.5 + 0.5 * number as f32 / parts.len() as f32, "write levels")?;
            made.sheared = write_glb_levels(path, part)?;
            made.files.push(path.clone());
        }
        progress.report(1.0, "write levels");
        Ok(made)
    }

    /// Makes a mesh of clusters at binding, with the point attributes `joints` and `weights`.
    fn skinned_mesh(&self, clusters: &[u32]) -> Mesh {
        let character = &self.character;
        let weights = self.clips.first().and_then(|clip| clip.poses.first()).map_or(&[][..], |pose| &pose.weights);
        let points: Vec<[f32; 3]> =
            (0..character.points.len()).map(|vertex| character.morphed(vertex, weights)).collect();
        let normals = character.values("normal").map_or(&[][..], |values| values.as_chunks::<3>().0);
        let (mut mesh, used) = self.gathered(clusters, &points, normals);
        let influences = || used.iter().map(|vertex| &character.influences[*vertex]);
        let joints = influences().flat_map(|it| it.bones.map(u32::from)).collect();
        let weights = influences().flat_map(|it| it.weights).collect();
        for (name, values) in [("joints", Values::U32(joints)), ("weights", Values::F32(weights))] {
            let name = name.into();
            mesh.attributes.push(Attribute { name, domain: Domain::Point, width: 4, values, indices: None });
        }
        mesh
    }
}

/// Returns the path of the file of a level beside that of all levels.
fn level_path(path: &Path, level: usize) -> PathBuf {
    let mut name = path.file_stem().unwrap_or_default().to_owned();
    name.push(format!("_LOD{level}.glb"));
    path.with_file_name(name)
}

/// Returns the map of a bone in double precision.
fn map(rows: &BoneMatrix) -> DAffine3 {
    let column = |at: usize| Vec3::new(rows[0][at], rows[1][at], rows[2][at]).as_dvec3();
    let [x, y, z]: [DVec3; 3] = [column(0), column(1), column(2)];
    DAffine3::from_mat3_translation(DMat3::from_cols(x, y, z), column(3))
}
