//! Soft tissue in the window: a model, or its frames, with colours that stand for materials, stress or strain, cut open.

use std::path::{Path, PathBuf};

use clap::ValueEnum as _;
use glam::DVec3;
use relievo_core::{Context, Error, Result};
use relievo_scene::tissue::{Motion, is_named};
use relievo_tissue::{Simulation, SimulationOptions};
use relievo_view::show::{Eye, Frames, Picture, Range, Setting, Subject};

use crate::tissue::picture::{coloring, faces, surfaces};
use crate::tissue::render::{Cut, Show};

/// What colours may stand for of a model alone, which no collider presses on.
const SHOWN: [Show; 6] = [Show::Material, Show::Muscle, Show::Stress, Show::Strain, Show::Volume, Show::Surface];

/// Metres above any model.
const FAR: f64 = 1e6;

/// Tissue over time.
pub struct Tissue {
    context: Context,
    name: String,
    simulation: Simulation,
    motion: Option<Motion>,
    frames: Vec<PathBuf>,
    /// The frame that the simulation is at.
    at: Option<usize>,
    low: [f32; 3],
    high: [f32; 3],
}

impl Tissue {
    /// Opens a model or the description of its simulation, with the frames in a folder if there is one.
    pub fn open(context: Context, path: &Path, folder: Option<&Path>) -> Result<Self> {
        let motion = is_named(path, "toml").then(|| Motion::read(path)).transpose()?;
        let simulation = match &motion {
            Some(motion) => motion.begin(&context, crate::tissue::model(&context, &motion.model())?)?,
            None => Simulation::new(crate::tissue::model(&context, path)?, &SimulationOptions::default())?,
        };
        let mut frames = Vec::new();
        if let Some(folder) = folder {
            let failed = |error: std::io::Error| Error::io(folder, &error);
            for entry in std::fs::read_dir(folder).map_err(failed)? {
                frames.push(entry.map_err(failed)?.path());
            }
            frames.retain(|path| is_named(path, "rtstate"));
            frames.sort();
            if frames.is_empty() {
                return Err(Error::invalid("there are no frames of tissue in the folder")
                    .at(folder.display().to_string())
                    .advise("make some by `relievo tissue sim`"));
            }
        }
        let nodes = || simulation.model().nodes.iter().map(|node| glam::Vec3::from(*node));
        let low = nodes().reduce(glam::Vec3::min).unwrap_or_default().to_array();
        let high = nodes().reduce(glam::Vec3::max).unwrap_or_default().to_array();
        let name = path.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
        Ok(Self { context, name, simulation, motion, frames, at: None, low, high })
    }
}

impl Subject for Tissue {
    fn name(&self) -> String {
        self.name.clone()
    }

    fn frames(&self) -> Frames {
        Frames { count: self.frames.len().max(1), rate: self.motion.as_ref().map_or(24.0, |motion| motion.fps) }
    }

    fn settings(&self) -> Vec<Setting> {
        let names = SHOWN.iter().filter_map(|show| show.to_possible_value()).map(|value| value.get_name().to_owned());
        let choice = |name: &str, hint: &str, names: Vec<String>| Setting {
            name: name.into(),
            hint: hint.into(),
            range: Range::Choice(names),
            value: 0.0,
        };
        vec![
            choice("Colours show", "Stress and strain are those of the elements", names.collect()),
            choice(
                "Cut across",
                "What is above a place along an axis is left out",
                ["none", "x", "y", "z"].map(String::from).into(),
            ),
            Setting {
                name: "Cut at".into(),
                hint: "A share of the model along the axis, at rest".into(),
                range: Range::Slider { least: 0.0, most: 1.0, is_logarithmic: false, is_whole: false },
                value: 0.5,
            },
            choice(
                "Draw",
                "The elements, or the surfaces that follow them",
                ["elements", "bound surfaces"].map(String::from).into(),
            ),
        ]
    }

    fn picture(&mut self, frame: usize, values: &[f64], _: &Eye) -> Result<Picture> {
        if let Some(path) = self.frames.get(frame).filter(|_| self.at != Some(frame)) {
            crate::tissue::show(&self.context, &mut self.simulation, path)?;
            self.at = Some(frame);
        }
        let value = |at: usize| values.get(at).copied().unwrap_or_default();
        let show = SHOWN[(value(0) as usize).min(SHOWN.len() - 1)];
        let coloring = coloring(&self.context, &self.simulation, show, None)?;
        let axis = (value(1) as usize).checked_sub(1).filter(|axis| *axis < 3);
        let cut = axis.map(|axis| {
            let share = value(2) as f32;
            Cut { axis, at: self.low[axis] + share * (self.high[axis] - self.low[axis]) }
        });
        // What is above the plane is left out, from wherever it is seen.
        let above = cut.map_or(DVec3::ZERO, |cut| {
            let mut place = DVec3::ZERO;
            place[cut.axis] = FAR;
            place
        });
        let mut picture = Picture { legend: coloring.legend, ..Picture::default() };
        if value(3) as usize == 1 {
            for mesh in surfaces(&self.context, &self.simulation, &coloring.paint) {
                add(&mut picture.mesh, mesh);
            }
        } else {
            picture.mesh = faces(&self.simulation, cut, above, &coloring.paint);
        }
        let model = self.simulation.model();
        picture.facts = vec![
            format!("{} elements, {} nodes", model.elements.len(), model.nodes.len()),
            format!("{:.4} s", self.simulation.state().seconds),
        ];
        Ok(picture)
    }
}

/// Adds a mesh to another.
pub fn add(into: &mut relievo_render::Mesh, mesh: relievo_render::Mesh) {
    let first = into.points.len() as u32;
    into.points.extend(mesh.points);
    into.normals.extend(mesh.normals);
    into.colors.extend(mesh.colors);
    into.triangles.extend(mesh.triangles.into_iter().map(|triangle| triangle.map(|point| first + point)));
}
