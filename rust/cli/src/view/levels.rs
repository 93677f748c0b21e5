//! A progressive mesh in the window: its level by a slider, finer around a handle, and how far it is from the finest.

use std::collections::VecDeque;
use std::path::Path;
use std::sync::Arc;

use glam::{DVec3, Vec3};
use relievo_core::{Context, Result};
use relievo_lod::Progressive;
use relievo_lod::progressive::{ActiveMesh, Cut, Extents, Extract, View};
use relievo_render::Mesh;
use relievo_view::show::{Eye, Picture, Range, Setting, Subject};

use super::deviation::{Measuring, Shape};
use crate::tissue::picture::{scale, viridis};

/// Levels whose deviations are remembered.
const REMEMBERED: usize = 32;

/// Meshes that are tried at most until one has as many triangles as asked for.
const TRIES: usize = 40;

/// The share of the triangles that were asked for which a mesh around the handle has at least.
const ENOUGH: f64 = 0.97;

/// What a level is of: triangles that were asked for, and where the handle is if it is finer there.
type Level = (usize, Option<[u64; 3]>);

/// Levels of a mesh.
pub struct Levels {
    context: Context,
    name: String,
    mesh: Arc<Progressive>,
    active: ActiveMesh,
    /// The level that the mesh is at.
    level: Option<Level>,
    extents: Option<Extents>,
    /// Deviation that is allowed at a distance of 1 from the handle.
    slope: f32,
    handle: Option<DVec3>,
    /// Whether the mesh is finer at the handle.
    is_gathered: bool,
    finest: Option<Arc<Shape>>,
    /// Deviations of levels, those measured last at the end.
    known: VecDeque<(Level, Vec<f32>)>,
    measuring: Option<(Level, Measuring)>,
    /// Measurements that were done.
    done: u64,
}

impl Levels {
    /// Opens a progressive mesh.
    pub fn open(context: Context, path: &Path) -> Result<Self> {
        let mesh = Arc::new(Progressive::open(&context, path, usize::MAX)?);
        let name = path.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
        Ok(Self {
            context,
            name,
            active: ActiveMesh::new(&mesh),
            mesh,
            level: None,
            extents: None,
            slope: 0.01,
            handle: None,
            is_gathered: false,
            finest: None,
            known: VecDeque::new(),
            measuring: None,
            done: 0,
        })
    }

    /// Returns the finest mesh.
    fn finest(&mut self) -> Arc<Shape> {
        if self.finest.is_none() {
            let mut active = ActiveMesh::new(&self.mesh);
            active.adapt(&self.context, Cut::FINEST);
            let Extract { points, triangles, .. } = active.extract();
            self.finest = Some(Arc::new(Shape { points, triangles }));
        }
        self.finest.clone().unwrap_or_default()
    }

    /// Becomes a mesh of at most so many triangles that deviates the less the nearer it is to the handle: by a share of the
    /// distance, which is looked for.
    fn gather(&mut self, faces: usize, handle: DVec3) -> Result<()> {
        let Self { context, mesh, active, extents, slope, .. } = self;
        if faces >= mesh.triangle_count() {
            active.adapt(context, Cut::FINEST);
            return Ok(());
        }
        let extents = extents.get_or_insert_with(|| Extents::new(mesh));
        let (mut ratio, mut was_fine) = (4.0, None);
        for number in 0..TRIES {
            let view = View {
                eye: handle.as_vec3().to_array(),
                pixels: 1.0,
                tolerance: slope.clamp(1e-9, 1e9),
                outline: 1.0,
                planes: Vec::new(),
            };
            active.adapt_to(context, &view, extents)?;
            let count = active.triangle_count();
            let is_fine = count > faces;
            if !is_fine && (count as f64 >= ENOUGH * faces as f64 || ratio < 1.01 || number + 8 > TRIES) {
                break;
            }
            if was_fine.is_some_and(|was| was != is_fine) {
                ratio = f32::sqrt(ratio);
            }
            was_fine = Some(is_fine);
            *slope = if is_fine { *slope * ratio } else { *slope / ratio };
        }
        Ok(())
    }

    /// Colours a mesh by its deviations if they are known, and has them measured if not.
    fn color(&mut self, level: Level, picture: &mut Picture) -> Result<()> {
        let known =
            self.known.iter().find(|(known, values)| *known == level && values.len() == picture.mesh.points.len());
        if let Some((_, values)) = known {
            let most = values.iter().copied().fold(0.0, f32::max);
            let (most, legend) = scale(Vec::new(), Some(most), "");
            picture.mesh.colors = values.iter().map(|value| viridis(value / most)).collect();
            picture.legend = legend;
            return Ok(());
        }
        picture.facts.push("the deviation is being measured".into());
        if self.measuring.as_ref().is_none_or(|(measured, _)| *measured != level) {
            // Stops what is measured of another level.
            self.measuring = None;
            let shape = Shape { points: picture.mesh.points.clone(), triangles: picture.mesh.triangles.clone() };
            let finest = self.finest();
            self.measuring = Some((level, Measuring::start(&self.context, &finest, shape)?));
        }
        Ok(())
    }
}

/// Returns the point that is farthest from the middle of the box around all: a tip.
fn tip(points: &[[f32; 3]]) -> Option<DVec3> {
    let places = || points.iter().map(|point| Vec3::from(*point).as_dvec3());
    let middle = 0.5 * (places().reduce(DVec3::min)? + places().reduce(DVec3::max)?);
    places().max_by(|a, b| a.distance(middle).total_cmp(&b.distance(middle)))
}

impl Subject for Levels {
    fn name(&self) -> String {
        self.name.clone()
    }

    fn settings(&self) -> Vec<Setting> {
        let [least, most] = [self.mesh.base_faces().len(), self.mesh.triangle_count()].map(|count| count.max(1) as f64);
        let choice = |name: &str, hint: &str, names: [&str; 2]| Setting {
            name: name.into(),
            hint: hint.into(),
            range: Range::Choice(names.map(str::to_owned).to_vec()),
            value: 0.0,
        };
        vec![
            Setting {
                name: "Triangles".into(),
                hint: "The finest level of at most so many triangles".into(),
                range: Range::Slider { least, most, is_logarithmic: true, is_whole: true },
                value: most,
            },
            choice(
                "Fine",
                "Everywhere, or the finer the nearer it is to the handle, which you drag over the surface",
                ["everywhere", "at the handle"],
            ),
            choice(
                "Colours show",
                "How far the level is from the finest mesh, measured once the slider rests",
                ["plain", "deviation"],
            ),
        ]
    }

    fn handle(&self) -> Option<DVec3> {
        self.handle.filter(|_| self.is_gathered)
    }

    fn move_handle(&mut self, place: DVec3) {
        self.handle = Some(place);
    }

    fn works(&mut self) -> (u64, bool) {
        if let Some((level, measuring)) = &self.measuring
            && let Some(found) = measuring.found()
        {
            // What cannot be measured leaves the level without colours.
            if let Ok(values) = found {
                if self.known.len() == REMEMBERED {
                    self.known.pop_front();
                }
                self.known.push_back((*level, values));
            }
            self.measuring = None;
            self.done += 1;
        }
        (self.done, self.measuring.is_some())
    }

    fn picture(&mut self, _: usize, values: &[f64], _: &Eye) -> Result<Picture> {
        let faces = values.first().map_or(usize::MAX, |count| count.round() as usize);
        let [is_gathered, is_measured] = [1, 2].map(|at| values.get(at).copied().unwrap_or_default() == 1.0);
        self.is_gathered = is_gathered;
        if is_gathered && self.handle.is_none() {
            self.handle = tip(&self.finest().points);
        }
        let handle = self.handle.filter(|_| is_gathered);
        let level = (faces, handle.map(|place| place.to_array().map(f64::to_bits)));
        // A mesh around the handle depends on what it was before: it is not made twice.
        if self.level != Some(level) {
            match handle {
                Some(handle) => self.gather(faces, handle)?,
                None if faces >= self.mesh.triangle_count() => _ = self.active.adapt(&self.context, Cut::FINEST),
                None => _ = self.active.adapt(&self.context, Cut::of_faces(&self.mesh, faces)),
            }
            self.level = Some(level);
        }
        let made = self.active.extract();
        let mut facts = vec![format!("{} vertices, {} triangles", made.points.len(), made.triangles.len())];
        if handle.is_none() {
            let cut = self.active.cut();
            let left = self.mesh.splits().filter(|(split, key, _)| !cut.has(*key, *split));
            let error = left.map(|(_, key, _)| key.error()).fold(0.0, f32::max);
            facts.push(format!("estimated deviation {error:.4}"));
        }
        let mesh = Mesh { points: made.points, normals: made.normals, triangles: made.triangles, ..Mesh::default() };
        let mut picture = Picture { mesh, facts, ..Picture::default() };
        if is_measured {
            self.color(level, &mut picture)?;
        } else {
            self.measuring = None;
        }
        Ok(picture)
    }
}
